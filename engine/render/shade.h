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

/* Gives the pixels of `raw`, RGBA with the bottom row first, whose alpha is SHADE_KEY or SKY_KEY their colours and keys.
 * near > 0: their numbers are found here, by casting rays, which every item must allow (subject_can); nothing nearer than that (scene
 * units) is seen. DIG_E_MEMORY leaves some as they are. */
dig_status shade_picture(ShadeSpace *space, const Frame *frame, const Batches *b, const Light *l, real near, uint32_t *raw, int width,
                         int height);
void       shade_close(ShadeSpace *space);

#endif
