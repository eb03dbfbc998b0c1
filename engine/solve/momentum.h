/* solve/momentum.h - the motion of floating mechanisms as one rigid body, and the momenta they keep.
 *
 * A mechanism is given by root[]: the lowest body of each body's own. Only for groups in which nothing acts but joints, contacts and
 * an even field (group_isolated), and for mechanisms that hang on nothing.
 *
 * Floor: solve.
 */
#ifndef DIG_MOMENTUM_H
#define DIG_MOMENTUM_H

#include "solve/group.h"

/* l is no product of inertia and w: those of what spins fast and reaches far cancel */
typedef struct Rigid { real mass; vec3 at, v, w, l; mat3 inertia; } Rigid;

void       rigid_motion(const Group *g, const int *root, int which, Rigid *out);       /* with its momentum and angular momentum */
/* The angular momentum that it had at the start of the frame, by turning all of it a little faster or slower: not where something may
 * turn it, or where more than that part of it is missing. */
void       rigid_hold_turning(Group *g, const int *root, int which, real most, Rigid *r);
bool       group_isolated(const Group *g);
dig_status group_hold_momenta(Group *g, real dt);       /* both momenta of all that floats, at the end of a frame */

#endif
