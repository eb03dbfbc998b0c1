/* world/mail.h - messages on their way: one queue for the whole world, outside the graph, ordered by (time, id).
 *
 * A post is a message before anybody has it: it says by which route it goes, not to whom. Who gets it is found when it is taken
 * out of the queue (step/deliver.c), so that it reaches those who are in the DIG then. A post without delay is never queued: it
 * is delivered at once, between steps, where nothing else changes.
 *
 * Exactly once: whatever follows from one message, each body gets a message of one kind once at one instant. What answers a
 * message has the root of that message; a body remembers the root, kind and time of the last message it got, and `heard` those
 * that came before it at this instant. So a message that is delivered once costs one comparison, and a cascade that goes
 * round in circles ends.
 *
 * Owns:      its lists. A zeroed Mail is empty and has no memory; mail_close makes it so again.
 * Invariant: `queue` is a binary heap by (time, id).
 * Floor:     world.
 */
#ifndef DIG_MAIL_H
#define DIG_MAIL_H

#include "base/list.h"
#include "base/map.h"

#define MAIL_STORM 10000        /* answers at one instant; more are a storm */

typedef struct Post {
    uint64_t id, root;          /* root: first message of the cascade, 0 = this one              */
    real     time;              /* s, when it is due                                             */
    dig_post what;
} Post;

typedef struct Reach {          /* one receiver of the post that is being delivered              */
    uint32_t body, from;        /* slot; index of the one it was reached from, itself for the first */
    int      hop;
    real     value;             /* the post's first value as it arrives                          */
} Reach;

typedef struct Seen { uint64_t stamp; uint32_t index; } Seen;           /* of a body slot: in which search, where in `reach` */

typedef struct Letter { uint64_t root; char kind[32]; dig_body from, to; } Letter;    /* how a cascade began */

typedef struct Mail {
    LIST(Post)        queue;
    LIST(dig_message) waiting, shown;   /* of the message events in world->pending and world->events, ids ascending */
    /* of the present instant */
    real     instant;           /* s of what is in heard and roots                               */
    Map      heard;             /* (hash of root and kind, slot): got it, and something else since */
    LIST(Letter) roots;         /* of the answers so far                                         */
    int      answers;           /* posts that answered at this instant                           */
    uint64_t answering;         /* root of what is posted now, 0 = nothing is answered           */
    /* reused by every delivery */
    LIST(Reach) reach;
    LIST(Seen)  seen;
    uint64_t    stamp;
} Mail;

void       mail_close(Mail *m);
dig_status mail_copy(Mail *to, const Mail *from, uint64_t *allocations);        /* not what is reused */
size_t     mail_bytes(const Mail *m);
uint64_t   mail_hash(uint64_t h, const Mail *m);        /* of the queue; h itself when it is empty */

dig_status mail_queue(Mail *m, const Post *p, uint64_t *allocations);
bool       mail_due(const Mail *m, real now);
Post       mail_take(Mail *m);                          /* the first; there must be one */
bool       mail_in_order(const Mail *m);

/* What happened at another instant no longer counts. */
void       mail_at(Mail *m, real now);
bool       mail_heard(const Mail *m, uint64_t root, const char *kind, uint32_t body);
void       mail_note(Mail *m, uint64_t root, const char *kind, uint32_t body);

#endif
