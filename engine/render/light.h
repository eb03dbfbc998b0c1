/* render/light.h - what the sun and the sky reach: a sun map, a height map, and a map of the light on the floor.
 *
 * The sun map holds the smoothed first and second moments of the depths along the sun, from which Chebyshev's inequality tells
 * a body in one fetch how much of the sun arrives (variance shadow maps: Donnelly and Lauritzen, I3D 2006; four compared taps
 * took three times as long, exponential maps frayed where the sun grazes). Where what is in shadow has something much deeper
 * beside it in the map, the shadow's rim is a texel or two too light. What is seen through throws no shadow, so its own surface is
 * put into the map for itself alone (light_receive).
 * The floor fills most of a picture, so its light is worked out beforehand on the CPU: shadows that are sharp where things
 * touch it and soft far from them, and the part of the sky hidden by what stands on it; a pixel of the floor costs one fetch.
 * Bodies take the hidden sky from heights seen from above, smoothed over two widths: each column counts as filled.
 *
 * Owns:  textures, the casters and working arrays.
 * Floor: render.
 */
#ifndef DIG_LIGHT_H
#define DIG_LIGHT_H

#include "render/cast.h"

enum { SUN_SIZE = 512, HEIGHT_SIZE = 256, FLOOR_SIZE = 512 };      /* texels a side */

/* Where the four bytes of a pixel lie in a word. */
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
enum { RED_SHIFT = 0, GREEN_SHIFT = 8, BLUE_SHIFT = 16, ALPHA_SHIFT = 24 };
#else
enum { RED_SHIFT = 24, GREEN_SHIFT = 16, BLUE_SHIFT = 8, ALPHA_SHIFT = 0 };
#endif

typedef struct Light {
    GLuint  sun_map, height_map, floor_map;
    Casters casters;
    float sun_clip[16], floor_plane[3];         /* of the last sun map: where it lies, and its floor          */
    float *sun;                         /* [SUN_SIZE^2] depths along the sun                                    */
    float least[SUN_SIZE * SUN_SIZE / 256];     /* of each 16 x 16 depths                                      */
    float *moments;                     /* [2 SUN_SIZE^2] smoothed depth less a half, and its square, side by side */
    float *above, *below;               /* [HEIGHT_SIZE^2] depths from above and below: tops and undersides      */
    float *sky, *wide, *blur;           /* [HEIGHT_SIZE^2] of the floor: sky seen, soft shadow, width of its edges */
    float *heights;                     /* [2 HEIGHT_SIZE^2] heights for bodies, smoothed narrowly and widely    */
    float *spare;                       /* [HEIGHT_SIZE^2]                                                       */
    float *shade, *mid, *gap;           /* [FLOOR_SIZE^2] sharp shadow, softened, distance of what throws it     */
    float *scratch;                     /* [FLOOR_SIZE^2]                                                        */
    uint32_t *texels;                   /* [FLOOR_SIZE^2] of the floor: sun, sky, marbling, 255 in memory order  */
    unsigned char *marble;              /* [FLOOR_SIZE^2]                                                        */
} Light;

dig_status light_open(Light *l, const Gl *gl, char *why, size_t capacity);
void       light_close(Light *l, const Gl *gl);

/* The square that the floor's map covers: its middle and half its width, scene units. */
void light_ground(const Stage *s, vec3 sun, real *x, real *y, real *half);

/* Fills the maps; sets the frame's to_sun, top and shade. frame->sun and ->eye are set before. Without memory: DIG_E_MEMORY. */
dig_status light_cast(Light *l, const Batches *b, const Meshes *meshes, const Stage *s, bool shadows, Frame *frame);

/* Hands the maps to OpenGL. */
void light_upload(const Light *l, const Gl *gl);

/* Makes the sun map, as OpenGL has it, one for an item that is seen through: it throws no shadow, but the moments are of its own
 * surface where nothing nearer hides that, so that shadows on it have whole rims. Without memory: DIG_E_MEMORY. */
dig_status light_receive(Light *l, const Gl *gl, const DrawItem *d, const Meshes *meshes);

/* Smooths n x n values (n a multiple of four) in place by a running mean over 2 radius + 1 texels, both ways; edges repeat. */
void blur_box(float *data, float *scratch, int n, int radius);

/* Fills n x n (a power of two) with a marbling round 128 that repeats without a seam. */
void marble_fill(unsigned char *out, int n);

#endif
