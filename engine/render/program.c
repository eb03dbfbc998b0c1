/* render/program.c - compiles shader programs from the pieces in shaders.c. */
#include "render/program.h"

#include <stdio.h>

#include "render/shaders.h"

uint32_t program_key_bits(ProgramKey key)
{
    return (uint32_t)key.kind | (uint32_t)key.form << 4 | (uint32_t)key.pattern << 8 | (uint32_t)key.lamps << 12 |
           (uint32_t)key.shadows << 16 | (uint32_t)key.plane << 17 | (uint32_t)key.floor << 18 | (uint32_t)key.corner_sky << 19 |
           (uint32_t)key.open << 20 | (uint32_t)key.clear << 21 | (uint32_t)key.mirror << 22;
}

void programs_open(Programs *p, const Gl *gl)
{
    *p = (Programs){0};
    gl->GenBuffers(1, &p->frame);
    gl->BindBuffer(GL_UNIFORM_BUFFER, p->frame);
    gl->BufferData(GL_UNIFORM_BUFFER, sizeof(Frame), NULL, GL_DYNAMIC_DRAW);
}

void programs_close(Programs *p, const Gl *gl)
{
    for (int i = 0; i < p->count; i++)
        gl->DeleteProgram(p->entry[i].name);
    gl->DeleteBuffers(1, &p->frame);
    *p = (Programs){0};
}

void programs_set_frame(Programs *p, const Gl *gl, const Frame *frame)
{
    gl->BindBuffer(GL_UNIFORM_BUFFER, p->frame);
    gl->BufferData(GL_UNIFORM_BUFFER, sizeof *frame, frame, GL_DYNAMIC_DRAW);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, 0, p->frame);
}

/* Compiles one stage and attaches it; the shader lives on in the program. */
static bool attach(const Gl *gl, GLuint program, GLenum stage, const char *defines, const char *const *pieces, char *why, size_t capacity)
{
    const char *source[2 + SHADER_PIECES];
    int count = 0;
    source[count++] = "#version 330 core\n";
    source[count++] = defines;
    for (int i = 0; i < SHADER_PIECES && pieces[i]; i++)
        source[count++] = pieces[i];
    GLuint shader = gl->CreateShader(stage);
    gl->ShaderSource(shader, count, source, NULL);
    gl->CompileShader(shader);
    GLint ok = 0;
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        char log[300] = "";
        gl->GetShaderInfoLog(shader, (GLsizei)sizeof log, NULL, log);
        snprintf(why, capacity, "shaders.c, %s shader: %s", stage == GL_VERTEX_SHADER ? "vertex" : "fragment", log);
    } else {
        gl->AttachShader(program, shader);
    }
    gl->DeleteShader(shader);
    return ok;
}

static void wire_textures(const Gl *gl, GLuint program)
{
    static const char *const names[] = {
        [UNIT_SUN] = "sun_map", [UNIT_HEIGHT] = "height_map", [UNIT_FLOOR] = "floor_map", [UNIT_MIRROR] = "mirror_map",
        [UNIT_FONT] = "font",
    };
    gl->UseProgram(program);
    for (int unit = 0; unit <= UNIT_FONT; unit++) {
        GLint place = gl->GetUniformLocation(program, names[unit]);
        if (place >= 0)
            gl->Uniform1i(place, unit);
    }
    GLuint block = gl->GetUniformBlockIndex(program, "Frame");
    if (block != GL_INVALID_INDEX)
        gl->UniformBlockBinding(program, block, 0);
}

static bool build(const Gl *gl, ProgramKey key, Program *out, char *why, size_t capacity)
{
    char defines[256];
    snprintf(defines, sizeof defines,
             "#define FORM %d\n#define PATTERN %d\n#define LAMPS %d\n#define SHADOWS %d\n#define PLANE %d\n#define FLOOR %d\n"
             "#define CORNER_SKY %d\n#define OPEN %d\n#define CLEAR %d\n#define MIRROR %d\n",
             (int)key.form, key.pattern, key.lamps, key.shadows, key.plane, key.floor, key.corner_sky, key.open, key.clear, key.mirror);
    const ShaderSource *source = &shader_sources[key.kind];
    GLuint program = gl->CreateProgram();
    bool ok = attach(gl, program, GL_VERTEX_SHADER, defines, source->vertex, why, capacity) &&
              attach(gl, program, GL_FRAGMENT_SHADER, defines, source->fragment, why, capacity);
    if (ok) {
        GLint linked = 0;
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
        ok = linked;
        if (!ok) {
            char log[300] = "";
            gl->GetProgramInfoLog(program, (GLsizei)sizeof log, NULL, log);
            snprintf(why, capacity, "shaders.c, link: %s", log);
        }
    }
    if (!ok) {
        gl->DeleteProgram(program);
        return false;
    }
    wire_textures(gl, program);
    *out = (Program){program_key_bits(key), program};
    return true;
}

const Program *programs_get(Programs *p, const Gl *gl, ProgramKey key, char *why, size_t capacity)
{
    uint32_t bits = program_key_bits(key);
    for (int i = 0; i < p->count; i++)
        if (p->entry[i].key == bits)
            return &p->entry[i];
    if (p->count == PROGRAM_CAPACITY) {     /* rare: five lamp counts times all surfaces; start afresh */
        for (int i = 0; i < p->count; i++)
            gl->DeleteProgram(p->entry[i].name);
        p->count = 0;
    }
    if (!build(gl, key, &p->entry[p->count], why, capacity))
        return NULL;
    return &p->entry[p->count++];
}
