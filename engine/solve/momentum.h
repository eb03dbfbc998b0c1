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
enum { MECHANISM_TIED = 1, MECHANISM_HELD = 2 };        /* by joints or touching: to another that moves, to what does not */
/* root: [moving_count] as above; ties: [moving_count], zero before: of all of a mechanism, at its root. */
void       group_mechanisms(const Group *g, int *root, uint8_t *ties);
real       mechanism_kinetic(const Group *g, const int *root, int which);      /* J */
/* The kinetic energy it had, by a faster motion: of what floats, about that as one rigid body, so that it keeps both momenta. False, and
 * nothing has changed: more than `most` of that motion's energy is missing. */
bool       mechanism_hold_kinetic(Group *g, const int *root, int which, bool floats, real kinetic, real most);
bool       group_isolated(const Group *g);
dig_status group_hold_momenta(Group *g, real dt);       /* both momenta of all that floats, at the end of a frame */

#endif
