/* render/subject.h - what pixels shaded by the CPU show: an item or the sky, as the loops of block.h want it.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_SUBJECT_H
#define DIG_SUBJECT_H

#include "render/light.h"

enum { SIDES = 5 };         /* that are told apart of a solid */
enum { SHADE_KEY = 254, SKY_KEY = 255 };    /* alphas of pixels yet to be shaded: an item's, its number in red, green, blue; the sky's */

typedef enum SubjectForm { SUBJECT_SKY, SUBJECT_PLANE, SUBJECT_BALL, SUBJECT_BOX, SUBJECT_CAPSULE, SUBJECT_CYLINDER } SubjectForm;

/* Pixels in which a subject may show: columns [x0, x1), rows [y0, y1). */
typedef struct SubjectRange { int x0, y0, x1, y1; } SubjectRange;

/* Lengths in scene units, directions and places in the axes of the solid (the sky: the scene's) unless said otherwise. */
typedef struct Subject {
    SubjectForm form;
    int   pattern, lamps;
    bool  floor, shadows;               /* its light comes from the floor map; the sun map is there */
    float eye[3];
    float ray[3][3];                    /* of pixel (x, y): [0] x + [1] y + [2]; one long along the view      */
    float sun[3], east[3], north[3], up[3];     /* towards the sun; the scene's axes                          */
    float radius, length;               /* balls, capsules, cylinders; half the side of a plane               */
    float half[4], look[4], colour[4], seed;    /* as in Instance                                             */
    float inverse[3];                   /* 1 / half                                                           */
    float to_sun[3][4], to_top[3][4];   /* place to texels of the sun map and depth; to 0..1 of the maps over the floor and height */
    float direct[3], sky[3];            /* planes: light of the open sun and of the open sky                  */
    float mirror[3], sheen;             /* planes: what they mirror of what is straight above them; all of it times this */
    float lamp[FRAME_LAMPS][3];
    uint32_t key[SIDES];                /* of each side, in place                                             */
    SubjectRange range;                 /* set by whom casts rays at it                                       */
} Subject;

/* Whether an item is of a form that block.h knows, and nothing is seen through it. */
bool subject_can(const DrawItem *d);

void subject_set(Subject *s, const Frame *f, const DrawItem *d, int width, int height);
void subject_set_sky(Subject *s, const Frame *f, int width, int height);

/* Where it may show, nothing nearer than `near` being seen. */
SubjectRange subject_range(const Subject *s, const Frame *f, const DrawItem *d, real near, int width, int height);

#endif
