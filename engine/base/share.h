/* base/share.h - records that are the same for many who have them: there once, and counted by them.
 *
 * A record begins with its Share. Who comes next is likely to want one of those made last, so an owner keeps a few of these (Recent), and is
 * one of those who have them. Nothing here allocates or frees: whose last user goes is freed by its own kind.
 *
 * Threads: those who have a record in common are of one thread.
 * Floor: base.
 */
#ifndef DIG_SHARE_H
#define DIG_SHARE_H

#include "base/base.h"

typedef struct Share { int users; } Share;

#define SHARES_RECENT 8
typedef struct Recent { const void *of[SHARES_RECENT]; int next; } Recent;

typedef bool ShareSame(const void *record, const void *like);

/* One more has it; NULL is none. */
static inline const void *share_keep(const void *record)
{
    if (record)
        ((Share *)record)->users++;
    return record;
}

/* One less has it. True: nobody has, and it is to be freed. */
static inline bool share_drop(const void *record) { return record && --((Share *)record)->users == 0; }

/* A record that is like this: mostly `now` (or NULL), else one of those made last; NULL: none is. */
static inline const void *share_find(const Recent *r, const void *now, const void *like, ShareSame *same)
{
    if (now && same(now, like))
        return now;
    for (int i = 0; i < SHARES_RECENT; i++)
        if (r->of[i] && same(r->of[i], like))
            return r->of[i];
    return NULL;
}

/* Puts one that was just made among these. Returns what has to go for it, to be dropped, or NULL. */
static inline const void *share_note(Recent *r, const void *made)
{
    const void **place = &r->of[r->next], *gone = *place;
    r->next = (r->next + 1) % SHARES_RECENT;
    *place = share_keep(made);
    return gone;
}

#endif
