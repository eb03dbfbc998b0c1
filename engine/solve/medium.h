/* solve/medium.h - what a fluid does to a solid that moves through it: drag; and what effects may know of how warm both are.
 *
 * Floor: solve.
 */
#ifndef DIG_MEDIUM_H
#define DIG_MEDIUM_H

#include "solve/group.h"

typedef struct Medium {
    real density;               /* kg/m^3                                              */
    vec3 flow;                  /* m/s   its own velocity: wind or current             */
    real damping;               /* 1/s   of a body with the mass of what it displaces  */
    real viscosity;             /* Pa s  Stokes' drag, as on a ball of the same volume */
} Medium;

/* The first fields of what the effect `heat` keeps of a body, and of its options: what others may know of it. */
typedef struct Warmth {
    real temperature;           /* K                                                   */
    real expansion;             /* 1/K   of its volume                                 */
    real expansion_from;        /* K     at which it is as large as its shapes         */
    real swelled;               /* 1     by this part it is larger: what displaces keeps it here, and its books by it */
} Warmth;

typedef struct Surround { real ambient, gradient; } Surround;       /* K at the origin's height, K/m upward */

#define SHRUNK  -0.9            /* 1  least of swelled */
#define AMBIENT 293.15          /* K */

/* K  At a height against gravity. s NULL: nobody has said anything. */
static inline real surround_at(const Surround *s, real height) { return s ? real_max(s->ambient + s->gradient * height, 0) : AMBIENT; }
/* Against gravity; 0 without. */
static inline vec3 medium_up(const World *w) { return vec3_unit_or(vec3_neg(w->def.gravity), vec3_zero()); }

/* What a body says of its own drag. */
typedef struct DragBody {
    real coefficient;           /* 1     NaN: that of its shapes                       */
    real area;                  /* m^2   0: what its shapes show to the flow           */
} DragBody;

/* m/s^2  Mean over a time h of what slows a motion u against the medium down, by -(c + k |u|) u, while all else accelerates it by a. */
vec3 medium_slowing(vec3 u, vec3 a, real k, real c, real h);
/* m^2  Sum over the body's solids of the area that each shows to a flow along a unit vector of the world, and of that times its
 * coefficient. */
void medium_area(const World *w, uint32_t body, quat q, vec3 along, real *area, real *drag);
/* Adds the drag of the part `share` of a body, 0..1, at `arm` from its centre, and the resistance to its spin. `displaced`: kg of the
 * medium in whose place it is. own: NULL = none of its own. Also notes what of it is lost, and what the flow puts in. */
void medium_drag(Group *g, int body, const Medium *m, const DragBody *own, real share, real displaced, vec3 arm);

#endif
