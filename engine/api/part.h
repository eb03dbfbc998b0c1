/* api/part.h - a world that holds one DIG of another world, and what that DIG can meet nearby: for questions.
 *
 * In it are the members of the DIG; all DIGs that reach into a box around it; the fixed and moved bodies there, planes and walls, and
 * those that members are joined to or lie on; the links, contacts and pushes of all these, as they are, with what they remember; regions
 * and effects. Left out is everything else: other layers, messages, events, and what is elsewhere, even if it is on its way here. What
 * it costs depends on what is in it, not on the size of the world.
 *
 * Where an effect of the caller's own is at work, which may look at anything, the part is the whole.
 *
 * Owns:  its world; part_close frees it.
 * Floor: api.
 */
#ifndef DIG_PART_H
#define DIG_PART_H

#include "api/api.h"

typedef struct Slots { uint32_t *data; int count, capacity; } Slots;      /* ascending; a LIST */

typedef struct Part {
    World *world;
    bool   whole;               /* slots are those of the world it was taken from */
    box3   around;              /* m   all that is in here is in the part; what moves out of it may miss something */
    Slots  bodies, solids, pairs, contacts, touches, joints, links;     /* [of the part] slot in the world it was taken from */
} Part;

/* What is around: the box of the DIG's members, `far` m wider on all sides. DIG_E_MEMORY: nothing is left. */
dig_status part_take(const World *w, uint32_t body, real far, Part *out);
void       part_close(Part *p);

/* From slots of the world to those of the part (NONE: not in it), and back. */
uint32_t   part_body(const Part *p, uint32_t slot);
uint32_t   part_body_from(const Part *p, uint32_t slot);
uint32_t   part_joint_from(const Part *p, uint32_t slot);

/* Is something that has moved no longer inside of what was looked at? */
bool       part_left(const Part *p, const World *now);

#endif
