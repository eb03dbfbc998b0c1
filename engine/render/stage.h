/* render/stage.h - the part of a view that matters, and the axes it is lit and drawn in.
 *
 * Scene axes have z up whatever the world's up is, their origin amid the bodies, and a unit in which the bodies fill
 * a ball of radius one. Light, fog, shadow maps and patterns are written in scene units, so that a watch and a dam
 * are lit alike.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_STAGE_H
#define DIG_STAGE_H

#include "math/quat.h"
#include "view/view.h"

typedef struct Stage {
    mat3 axes;          /* world to scene, a rotation; r2 is the world's up                    */
    vec3 centre;        /* m, world axes, relative to the view's origin: scene (0, 0, 0)        */
    real unit;          /* m per scene unit, on a ladder of 2^(1/4), so that films do not shimmer */
    vec3 low, high;     /* 1, scene: box round what matters                                     */
    real typical;       /* 1, scene: geometric mean radius of the moving bodies, by their radii */
    real floor;         /* 1, scene z of the floor, or of the lowest thing where there is none  */
    int  floor_item;    /* the horizontal plane under the scene, -1 = none                      */
} Stage;

/* Who looks at it. */
typedef struct StageEye { vec3 at; real half; } StageEye;       /* m, relative to the view's origin; half the height that is seen one metre away */

/* What matters: the moving bodies, the fixed ones around them, the floor below. Of huge fixed bodies only the part
 * near the moving ones counts. For an eye, the odd body flung far away from the others is left out, and where what moves is hardly seen
 * the whole scene decides; all that changes smoothly with the places of bodies and eye. Without one (NULL) all bodies count. */
Stage stage_of(const View *v, const StageEye *eye);

/* A point of the view (m, world axes, relative to origin) in scene units. */
vec3 stage_point(const Stage *s, vec3 p);

/* Box round an item in its own axes, m. A plane has none: false. */
bool item_bounds(const View *v, const ViewItem *item, box3 *box);

/* Whether an item is to be drawn, and its numbers are fit for it. */
bool item_sound(const View *v, const ViewItem *item);

static inline vec3 vec3_from(const float v[3]) { return (vec3){(real)v[0], (real)v[1], (real)v[2]}; }
static inline quat quat_from(const float q[4]) { return quat_unit((quat){(real)q[0], (real)q[1], (real)q[2], (real)q[3]}); }

#endif
