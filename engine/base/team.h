/* base/team.h - a few threads that do one thing together, each its part, and may wait for each other within it.
 *
 * What a part does must not depend on how many there are: the caller shares out work that has no order, or meets in between.
 *
 * Owns:  nothing; who makes a team (step/workers.c) owns its threads. NULL is a valid team: the caller alone.
 * Floor: base.
 */
#ifndef DIG_TEAM_H
#define DIG_TEAM_H

#include "base/base.h"

#include <stdatomic.h>

typedef struct Team Team;
typedef void TeamPart(void *context, int thread, int threads);      /* thread: 0 for the caller's own */

struct Team {
    void      (*run)(Team *t, TeamPart *part, void *context);
    int         threads;
    atomic_int  arrived;        /* at the meeting                                              */
    atomic_uint meetings;       /* that are over                                               */
};

/* Every thread does its part; returns when all are done. */
static inline void team_run(Team *t, TeamPart *part, void *context)
{
    if (t)
        t->run(t, part, context);
    else
        part(context, 0, 1);
}

/* Within a part: waits until all have come here. What they wrote before is seen by all after. */
void team_meet(Team *t);
void team_pause(int tries);     /* a little while, for a loop that waits; after many tries others may have the processor */

/* The share of `count` things in a row that falls to a thread: first <= i < end. */
static inline int team_first(int count, int thread, int threads) { return (int)((int64_t)count * thread / threads); }
static inline int team_end(int count, int thread, int threads) { return team_first(count, thread + 1, threads); }

#endif
