/* render/target.c - makes framebuffers. */
#include "render/target.h"

#include <stdio.h>

static const GLenum colour_formats[TARGET_COUNT] = {
    [RENDER_COLOUR] = GL_RGBA8, [RENDER_DEPTH] = GL_R32F, [RENDER_ID] = GL_R32UI, [RENDER_NORMAL] = GL_RGBA8,
    [TARGET_OVERLAY] = GL_RGBA8, [TARGET_MIRROR] = GL_RGBA8,
};

static void drop(Target *t, const Gl *gl)
{
    GLuint targets[] = {t->draw, t->whole}, buffers[] = {t->colour, t->depth, t->resolved};
    gl->DeleteFramebuffers(2, targets);
    gl->DeleteRenderbuffers(3, buffers);
    gl->DeleteTextures(1, &t->picture);
    *t = (Target){0};
}

void targets_close(Targets *t, const Gl *gl)
{
    for (int i = 0; i < TARGET_COUNT; i++)
        drop(&t->entry[i], gl);
}

static GLuint make_buffer(const Gl *gl, GLenum format, int width, int height, int samples, GLenum place)
{
    GLuint name = 0;
    gl->GenRenderbuffers(1, &name);
    gl->BindRenderbuffer(GL_RENDERBUFFER, name);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, name);
    return name;
}

static GLuint make_picture(const Gl *gl, int width, int height, GLint filter)
{
    GLuint name = 0;
    gl->GenTextures(1, &name);
    gl->BindTexture(GL_TEXTURE_2D, name);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, name, 0);
    return name;
}

static void make(Target *t, const Gl *gl, GLenum format, GLint filter)
{
    gl->GenFramebuffers(1, &t->draw);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->draw);
    if (format == GL_RGBA8 && t->samples == 0)
        t->picture = make_picture(gl, t->width, t->height, filter);
    else
        t->colour = make_buffer(gl, format, t->width, t->height, t->samples, GL_COLOR_ATTACHMENT0);
    t->depth = make_buffer(gl, GL_DEPTH_COMPONENT24, t->width, t->height, t->samples, GL_DEPTH_ATTACHMENT);
    if (t->samples == 0)
        return;
    gl->GenFramebuffers(1, &t->whole);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->whole);
    t->resolved = make_buffer(gl, format, t->width, t->height, 0, GL_COLOR_ATTACHMENT0);
}

static bool complete(const Target *t, const Gl *gl)
{
    bool ok = true;
    GLuint names[] = {t->draw, t->whole};
    for (int i = 0; i < 2; i++) {
        if (!names[i])
            continue;
        gl->BindFramebuffer(GL_FRAMEBUFFER, names[i]);
        ok = ok && gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    }
    return ok && gl->GetError() == GL_NO_ERROR;
}

const Target *targets_get(Targets *targets, const Gl *gl, int index, int width, int height, int samples, char *why, size_t capacity)
{
    Target *t = &targets->entry[index];
    if (index != RENDER_COLOUR)
        samples = 0;
    if (t->draw && t->width == width && t->height == height && t->samples == samples)
        return t;
    drop(t, gl);
    *t = (Target){.width = width, .height = height, .samples = samples};
    make(t, gl, colour_formats[index], index == TARGET_MIRROR ? GL_LINEAR : GL_NEAREST);
    if (complete(t, gl))
        return t;
    drop(t, gl);
    snprintf(why, capacity, "the driver has no room for a picture of %d x %d pixels with %d samples", width, height, samples);
    return NULL;
}
