/* render/shade.h - the light on boxes, balls, capsules, cylinders, planes and the sky, worked out by the CPU.
 *
 * OpenGL in software spends most of a picture's time in fragment shaders. So where there is one sample a pixel, it is only
 * asked which item each pixel shows (PROGRAM_NUMBER), and the rest is done here: a pixel's ray meets the true solid, in the
 * solid's own axes, and is shaded as shaders.c shades it, all pixels of an item together. Meshes, cones, what is seen
 * through, and pictures with several samples a pixel are left to shaders.c; a test compares the two.
 *
 * Owns:  runs of pixels and their order; shade_close frees them.
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_SHADE_H
#define DIG_SHADE_H

#include "render/subject.h"

typedef struct ShadeRun { uint32_t subject, x, y, count; } ShadeRun;

typedef struct ShadeSpace {
    ShadeRun *runs, *sorted;
    int      *item;             /* [by index in the view] place in the batches                   */
    int      *first;            /* of each subject's runs: 0 the sky, 1 + k the k-th of the batches */
    float    *depth;            /* [pixels of a band] distance along the view of what is nearest so far */
    unsigned char *ends;        /* [width] whether a pixel is the last of a run                  */
    Subject  *subjects;         /* 0 the sky, 1 + k the k-th of the batches                      */
    int       most_index, run_count, run_capacity, sorted_capacity, item_capacity, first_capacity, depth_capacity,
              subject_capacity, end_capacity;
} ShadeSpace;

/* A picture of what the floor mirrors, bottom row first, that covers the same view; none = {0}. */
typedef struct ShadeMirror { const uint32_t *pixels; int width, height; } ShadeMirror;

/* From where and how rays are cast. near > 0: pixels are numbered here, by rays, which every item must allow (subject_can); nothing
 * nearer than that (scene units) is seen. rise > 0: the eye is so far below the floor, and what is nearer than that is not seen. */
typedef struct ShadeEye { real near, rise; ShadeMirror mirror; } ShadeEye;

/* Gives the pixels of `raw`, RGBA with the bottom row first, whose alpha is SHADE_KEY or SKY_KEY their colours and keys.
 * DIG_E_MEMORY leaves some as they are. */
dig_status shade_picture(ShadeSpace *space, const Frame *frame, const Batches *b, const Light *l, const ShadeEye *eye, uint32_t *raw, int width,
                         int height);
void       shade_close(ShadeSpace *space);

#endif
