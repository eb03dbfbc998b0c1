/* world/joint.h - joint records: lists per body, removal.
 *
 * Invariant: a joint is in the list of each of its bodies exactly once.
 * Floor:     world.
 */
#ifndef DIG_JOINT_H
#define DIG_JOINT_H

#include "world/world.h"

void     joint_attach(World *w, uint32_t joint);                            /* into the lists of its bodies */
/* The next joint of that body, or NONE. */
static inline uint32_t joint_next(const World *w, uint32_t joint, uint32_t body)
{
    const JointRec *j = &w->joints.data[joint];
    return j->a == body ? j->next_a : j->next_b;
}

#endif
