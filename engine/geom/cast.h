/* geom/cast.h - three ways to find what a moving ball meets, and bisection for the time.
 *
 * The founding document names them: a ray from the old position to the new, a capped cylinder (the ball swept along that
 * line), and an arc (the ball's true path under constant acceleration). The first two miss what only the arc meets.
 *
 * Floor: geom.
 */
#ifndef DIG_CAST_H
#define DIG_CAST_H

#include "geom/manifold.h"

typedef struct CastHit { real t; vec3 point, normal; } CastHit;     /* s, m, unit (out of the shape) */

/* All return true and fill hit for the first meeting in [0, time]; the target stands still at `at`. */
bool cast_ray(const Shape *s, pose at, vec3 from, vec3 velocity, real time, CastHit *hit);                  /* a point on a line   */
/* a ball on a line; a ball on its parabola */
bool cast_capped_cylinder(const Shape *s, pose at, vec3 from, real radius, vec3 velocity, real time, CastHit *hit);
bool cast_arc(const Shape *s, pose at, vec3 from, real radius, vec3 velocity, vec3 acceleration, real time, CastHit *hit);

/* The zero of gap(context, t) in [lo, hi], gap(lo) > 0 >= gap(hi), by `count` bisections: error <= (hi - lo) * 2^-count. */
real bisect_impact(real (*gap)(void *context, real t), void *context, real lo, real hi, int count);

#endif
