/* render/program.h - shader programs, made on demand, one for each kind of surface.
 *
 * llvmpipe runs both sides of every `if`, so there is no program that can do everything: a key of a few bits selects
 * what is compiled in. Programs stay until the renderer closes.
 *
 * Owns:  the programs and the uniform buffer that all of them read.
 * Floor: render.
 */
#ifndef DIG_PROGRAM_H
#define DIG_PROGRAM_H

#include "render/gl.h"

typedef enum ProgramKind { PROGRAM_SURFACE, PROGRAM_SKY, PROGRAM_NUMBER, PROGRAM_DEPTH, PROGRAM_ID, PROGRAM_NORMAL, PROGRAM_STROKE, PROGRAM_GLYPH,
                           PROGRAM_KIND_COUNT } ProgramKind;

/* How a surface gets its normal. */
typedef enum ProgramForm { FORM_SMOOTH, FORM_SPHERE, FORM_BOX, FORM_CYLINDER, FORM_TWO_SIDED, FORM_MESH, FORM_COUNT } ProgramForm;

typedef struct ProgramKey {
    ProgramKind kind;
    ProgramForm form;
    int         pattern;        /* ViewPattern                               */
    int         lamps;          /* 0..4                                      */
    bool        shadows;
    bool        corner_sky;     /* hidden sky worked out at the corners of a mesh, not at each pixel */
    bool        plane;          /* an infinite plane: tiles instead of plain */
    bool        clear;          /* what lies behind is seen through it       */
    bool        floor;          /* ... whose light comes from the floor map  */
    bool        open;           /* ... but not here: outside the map         */
    bool        mirror;         /* ... which mirrors what stands on it       */
} ProgramKey;

enum { PROGRAM_CAPACITY = 192, FRAME_LAMPS = 4 };

/* The uniform block "Frame" (std140: only vec4 and mat4). Positions are in scene units relative to the eye unless
 * said otherwise, directions in scene axes, colours linear. */
typedef struct Frame {
    float to_clip[16];                          /* column by column                                          */
    float to_sun[16];                           /* to [0,1]^3 of the sun map                                 */
    float eye[4];                               /* in the scene; w: metres per scene unit                    */
    float forward[4];                           /* of the camera; w: 1 / fog distance^2                      */
    float ray[3][4];                            /* sky direction = ray[0] x + ray[1] y + ray[2]               */
    float sun[4], sun_colour[4];                /* towards the sun; sun.w: bias, sun_colour.w: its square   */
    float zenith[4], horizon[4], ground[4];     /* light from above, from the rim, from below                */
    float sky_top[4], sky_rim[4], sky_low[4];   /* the sky as it is seen; the rim is the fog; sky_top.w: glow */
    float top[4];                               /* maps over the floor: uv = (x, y) top.x + top.zw; y: offset */
    float shade[4];                             /* near and wide weight of hidden sky, floor z, largest step */
    float world[3][4];                          /* rows: scene to world axes                                 */
    float lamp_at[FRAME_LAMPS][4], lamp_colour[FRAME_LAMPS][4];     /* colour times power                    */
    float screen[4];                            /* 2 / width, 2 / height, lower end of the sky (-1..1)        */
} Frame;

typedef struct Program { uint32_t key; GLuint name; } Program;

typedef struct Programs {
    Program entry[PROGRAM_CAPACITY];
    int     count;
    GLuint  frame;
} Programs;

/* Texture units that programs read from. */
enum { UNIT_SUN, UNIT_HEIGHT, UNIT_FLOOR, UNIT_MIRROR, UNIT_FONT };

void programs_open(Programs *p, const Gl *gl);
void programs_close(Programs *p, const Gl *gl);
void programs_set_frame(Programs *p, const Gl *gl, const Frame *frame);

/* The program for a key, compiled when first wanted; NULL and the compiler's words in `why` when that fails. */
const Program *programs_get(Programs *p, const Gl *gl, ProgramKey key, char *why, size_t capacity);

uint32_t program_key_bits(ProgramKey key);

#endif
