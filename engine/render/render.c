/* render/render.c - opens a renderer, checks what it is asked for, hands out pixels. */
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"
#include "render/paint.h"

enum { LARGEST = 16384 };       /* px; Mesa accepts more and then fails */

/* ---- open and close ---------------------------------------------------- */

static void release_gl(Renderer *r)
{
    const Gl *gl = &r->gl;
    targets_close(&r->targets, gl);
    overlay_close(&r->overlay, gl);
    light_close(&r->light, gl);
    batches_close(&r->batches, gl);
    batches_close(&r->mirrored, gl);
    meshes_close(&r->meshes, gl);
    programs_close(&r->programs, gl);
    gl->DeleteVertexArrays(1, &r->empty);
}

static dig_status prepare(Renderer *r, char *why, size_t capacity)
{
    const Gl *gl = &r->gl;
    if (!gl_load(&r->gl, r->backend, r->context, why, capacity))
        return DIG_E_FULL;
    snprintf(r->description, sizeof r->description, "%s: %.60s, %.80s", r->backend->name, (const char *)gl->GetString(GL_VERSION),
             (const char *)gl->GetString(GL_RENDERER));
    gl->GenVertexArrays(1, &r->empty);
    programs_open(&r->programs, gl);
    overlay_open(&r->overlay, gl);
    dig_status status = meshes_open(&r->meshes, gl);
    if (status != DIG_OK)
        snprintf(why, capacity, "%s: no memory for the meshes", r->backend->name);
    else
        status = light_open(&r->light, gl, why, capacity);
    if (status == DIG_OK && gl->GetError() != GL_NO_ERROR) {
        snprintf(why, capacity, "%s: OpenGL error while opening", r->backend->name);
        status = DIG_E_FULL;
    }
    if (status != DIG_OK)
        release_gl(r);
    return status;
}

static dig_status open_with(const ContextBackend *backend, Renderer **out, char *why, size_t capacity)
{
    Renderer *r = calloc(1, sizeof *r);
    if (!r) {
        snprintf(why, capacity, "%s: no memory", backend->name);
        return DIG_E_MEMORY;
    }
    r->backend = backend;
    dig_status status = backend->open(&r->context, why, capacity);
    if (status == DIG_OK) {
        if (backend->bind(r->context)) {
            status = prepare(r, why, capacity);
        } else {
            snprintf(why, capacity, "%s: the new context cannot be made current", backend->name);
            status = DIG_E_FULL;
        }
        backend->unbind(r->context);
        if (status != DIG_OK)
            backend->close(r->context);
    }
    if (status != DIG_OK) {
        free(r);
        return status;
    }
    *out = r;
    return DIG_OK;
}

dig_status render_open(const char *backend, Renderer **r, char *why, size_t capacity)
{
    static const ContextBackend *const backends[] = {&context_osmesa, &context_egl};
    dig_status status = DIG_E_ARG;
    *r = NULL;
    if (capacity)
        snprintf(why, capacity, "render_open: no backend '%s', use osmesa or egl", backend ? backend : "");
    size_t said = 0;            /* what each of them failed at */
    for (size_t i = 0; i < sizeof backends / sizeof *backends; i++) {
        if (backend && strcmp(backend, backends[i]->name) != 0)
            continue;
        if (said > 0 && said + 3 < capacity)
            said += (size_t)snprintf(why + said, capacity - said, "; ");
        status = open_with(backends[i], r, why + said, capacity - said);
        said += capacity > said ? strlen(why + said) : 0;
        if (status == DIG_OK) {
            if (capacity)
                why[0] = 0;
            return DIG_OK;
        }
    }
    return status;
}

void render_close(Renderer *r)
{
    if (!r)
        return;
    if (r->backend->bind(r->context)) {
        release_gl(r);
        r->backend->unbind(r->context);
    }
    r->backend->close(r->context);
    shade_close(&r->shade);
    smooth_close(&r->smooth);
    free(r->sum);
    free(r->mirror);
    free(r->pixels);
    free(r->raw);
    free(r);
}

RenderTimes render_times(const Renderer *r) { return r->times; }

const char *render_describe(const Renderer *r) { return r->description; }

const char *render_error(const Renderer *r) { return r->error; }

/* ---- checks ------------------------------------------------------------ */

static bool finite3(const real a[3]) { return isfinite(a[0]) && isfinite(a[1]) && isfinite(a[2]); }

static dig_status refuse(Renderer *r, const char *format, ...) DIG_PRINTF(2, 3);

static dig_status refuse(Renderer *r, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(r->error, sizeof r->error, format, list);
    va_end(list);
    return DIG_E_ARG;
}

static dig_status check_camera(Renderer *r, const RenderCamera *c)
{
    if (!finite3(c->at) || !finite3(c->look_at) || !finite3(c->up))
        return refuse(r, "camera: at, look_at and up must be finite");
    if (c->at[0] == c->look_at[0] && c->at[1] == c->look_at[1] && c->at[2] == c->look_at[2])
        return refuse(r, "camera: at and look_at are the same point (%g, %g, %g) m", c->at[0], c->at[1], c->at[2]);
    if (!(c->fov >= 0.001 && c->fov <= 3.1))
        return refuse(r, "camera: fov = %g rad, must be 0.001 to 3.1", c->fov);
    return DIG_OK;
}

static dig_status check_lamps(Renderer *r, const RenderOptions *o)
{
    if (o->lamp_count < 0 || o->lamp_count > FRAME_LAMPS)
        return refuse(r, "lamp_count = %d, must be 0 to %d", o->lamp_count, FRAME_LAMPS);
    for (int i = 0; i < o->lamp_count; i++)
        if (!finite3(o->lamps[i].at) || !(o->lamps[i].power >= 0) || !isfinite(o->lamps[i].power))
            return refuse(r, "lamp %d: place and power must be finite, power not negative", i + 1);
    return DIG_OK;
}

static dig_status check_options(Renderer *r, const RenderOptions *o)
{
    if (o->width < 1 || o->width > LARGEST || o->height < 1 || o->height > LARGEST)
        return refuse(r, "size = %d x %d pixels, must be 1 to %d each way", o->width, o->height, LARGEST);
    if (o->samples != 0 && o->samples != 2 && o->samples != 4)
        return refuse(r, "samples = %d, must be 0, 2 or 4", o->samples);
    if (o->moments < 0 || o->moments > 64 || (o->moments > 0 ? o->moment < 1 : o->moment != 0) || o->moment > o->moments)
        return refuse(r, "moment %d of %d, must be 1 to 64 or both 0", o->moment, o->moments);
    if ((int)o->layer < 0 || (int)o->layer >= LAYER_COUNT)
        return refuse(r, "layer = %d, must be 0 to %d", (int)o->layer, LAYER_COUNT - 1);
    if (o->sky < 0 || o->sky > 3)
        return refuse(r, "sky = %d, must be 0 (clear), 1 (overcast), 2 (night) or 3 (black)", o->sky);
    if (!isfinite(o->sun[0]) || !isfinite(o->sun[1]) || !isfinite(o->sun[2]))
        return refuse(r, "sun: the direction must be finite");
    DIG_TRY(check_lamps(r, o));
    return check_camera(r, &o->camera);
}

/* ---- pixels ------------------------------------------------------------ */

static bool reserve(void **data, size_t *capacity, size_t wanted)
{
    if (*capacity >= wanted)
        return true;
    free(*data);
    *data = malloc(wanted);
    *capacity = *data ? wanted : 0;
    return *data != NULL;
}

static bool is_rgb(const RenderOptions *o) { return o->layer == RENDER_COLOUR || o->layer == RENDER_NORMAL; }

/* OpenGL's first row is the lowest; ours is the top one. */
static void flip(const Renderer *r, const RenderOptions *o)
{
    size_t stride = 4 * (size_t)o->width, height = (size_t)o->height;
    for (size_t y = 0; y < height; y++)
        memcpy((unsigned char *)r->pixels + stride * y, (const unsigned char *)r->raw + stride * (height - 1 - y), stride);
}

static dig_status no_room(Renderer *r, const RenderOptions *o)
{
    snprintf(r->error, sizeof r->error, "no memory for a picture of %d x %d pixels", o->width, o->height);
    return DIG_E_MEMORY;
}

static dig_status finish_pixels(Renderer *r, const RenderOptions *o)
{
    if (!is_rgb(o)) {
        flip(r, o);
        return DIG_OK;
    }
    if (o->layer == RENDER_COLOUR && o->smooth && o->samples == 0)
        return smooth_edges(&r->smooth, r->raw, o->width, o->height, r->pixels) == DIG_OK ? DIG_OK : no_room(r, o);
    smooth_copy(r->raw, o->width, o->height, r->pixels);
    return DIG_OK;
}

/* Adds a moment to the sum; the last one leaves the mean in r->pixels. Squares of levels add about as light does. */
static dig_status add_moment(Renderer *r, const RenderOptions *o)
{
    size_t count = 3 * (size_t)o->width * (size_t)o->height;
    unsigned char *pixels = r->pixels;
    void *sum = r->sum;
    if (!reserve(&sum, &r->sum_capacity, count * sizeof *r->sum)) {
        r->sum = NULL;
        return no_room(r, o);
    }
    r->sum = sum;
    if (o->moment == 1)
        memset(r->sum, 0, count * sizeof *r->sum);
    for (size_t i = 0; i < count; i++)
        r->sum[i] += (uint32_t)pixels[i] * pixels[i];
    for (size_t i = 0; o->moment == o->moments && i < count; i++)
        pixels[i] = (unsigned char)(sqrtf((float)r->sum[i] / (float)o->moments) + 0.5f);
    return DIG_OK;
}

static dig_status lay_overlay(Renderer *r, const View *v, const RenderOptions *o)
{
    const Target *t = targets_get(&r->targets, &r->gl, TARGET_OVERLAY, o->width, o->height, 0, r->error, sizeof r->error);
    if (!t)
        return DIG_E_MEMORY;
    DIG_TRY(paint_overlay(r, v, o, t));
    smooth_cover(r->raw, o->width, o->height, r->pixels);
    return DIG_OK;
}

/* Adds the time since the last call to *sum, ms. */
static void lap(real *clock, real *sum)
{
    real now = cpu_us();
    *sum += 1e-3 * (now - *clock);
    *clock = now;
}

static dig_status draw_bound(Renderer *r, const View *v, const RenderOptions *o)
{
    real clock = cpu_us(), apart = r->times.light + r->times.read;
    const Target *t = targets_get(&r->targets, &r->gl, (int)o->layer, o->width, o->height, o->samples, r->error, sizeof r->error);
    if (!t)
        return DIG_E_MEMORY;
    size_t size = 4 * (size_t)o->width * (size_t)o->height;
    if (!reserve(&r->raw, &r->raw_capacity, size) || !reserve(&r->pixels, &r->pixel_capacity, size))
        return no_room(r, o);
    DIG_TRY(paint(r, v, o, t));
    lap(&clock, &r->times.draw);
    r->times.draw -= r->times.light + r->times.read - apart;
    DIG_TRY(finish_pixels(r, o));
    lap(&clock, &r->times.smooth);
    if (o->moments > 1 && o->layer == RENDER_COLOUR)
        DIG_TRY(add_moment(r, o));
    return o->overlay && o->layer == RENDER_COLOUR && o->moment == o->moments ? lay_overlay(r, v, o) : DIG_OK;
}

dig_status render_draw(Renderer *r, const View *v, const RenderOptions *o, const void **pixels)
{
    *pixels = NULL;
    r->error[0] = 0;
    DIG_TRY(check_options(r, o));
    if (!r->backend->bind(r->context)) {
        snprintf(r->error, sizeof r->error, "%s: the context cannot be made current on this thread", r->backend->name);
        return DIG_E_FULL;
    }
    dig_status status = draw_bound(r, v, o);
    /* Unbound between pictures: two backends in one thread share Mesa's current context. */
    r->backend->unbind(r->context);
    if (status == DIG_OK)
        *pixels = r->pixels;
    return status;
}
