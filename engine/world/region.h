/* world/region.h - parts of space where other laws hold. A body is in a region when its centre of mass is.
 *
 * Gravity, drag, friction and restitution are asked for where a body is, whenever forces are (effect/region.c). The rate of
 * time is a state of the body: it changes in the step in which the border is crossed, at its end.
 *
 * Where time goes r times as fast, a body has the velocity r v and the inertia m / r^2 against forces of the world's time; v is
 * its velocity by the time inside. The energy m v^2 / 2 and all forces are those of outside. At the border v stays.
 *
 * Floor: world.
 */
#ifndef DIG_REGION_H
#define DIG_REGION_H

#include "world/world.h"

static inline bool region_holds(const Region *r, vec3 at)
{
    return r->alive && r->shape.type->contains(&r->shape, pose_unpoint(r->at, at));
}

real region_rate(const World *w, vec3 at);              /* 1  of time: the product of all regions there */
real region_conduct(const World *w, vec3 at);           /* 1  factor on conductances: the product of all regions there */
real region_fall(const World *w, const Body *b, vec3 at);       /* m/s^2  in the world's time, at gravity_scale 1: how fast it falls there */
/* Its centre of mass was at `from`, `took` s ago: tells whose border it has crossed, and when, as if the way were straight; and takes
 * over the rate of time. */
void region_cross(World *w, uint32_t body, vec3 from, real took);
void region_cross_all(World *w);                        /* those that move, at the end of a step */
void region_changed(World *w);                          /* a region came or went: all take over the rate of time */
uint64_t region_hash(const Region *r, uint64_t h);

#endif
