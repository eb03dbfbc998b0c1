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

#define TEAM_LINE 64            /* bytes of a cache line: what several threads write to has one of its own; to move it takes 50 to 250 ns */

typedef struct TeamHand { _Alignas(TEAM_LINE) atomic_int left; } TeamHand;      /* of a thread: what is left of its shares; team.c */

struct Team {
    void      (*run)(Team *t, TeamPart *part, void *context);
    int         threads;
    TeamHand   *hand;           /* [threads]                                                   */
    _Alignas(TEAM_LINE) atomic_int arrived;     /* at the meeting                              */
    _Alignas(TEAM_LINE) atomic_uint meetings;   /* that are over                               */
};

/* Every thread does its part at the same time, so that parts may meet; returns when all are done. */
static inline void team_run(Team *t, TeamPart *part, void *context)
{
    if (t)
        t->run(t, part, context);
    else
        part(context, 0, 1);
}

#define TEAM_SHARES 8           /* for each thread */

/* Into how many shares a deal goes. */
static inline int team_shares(const Team *t) { return t ? TEAM_SHARES * t->threads : 1; }

void team_share_out(Team *t, TeamPart *part, void *context);

/* As team_run for parts that do not meet, called once for each of team_shares. Each thread begins with its own eighths, which are the same
 * part of the whole in each deal, for what it wrote in one is in its cache in the next; who is done helps those who are not. A macro of
 * (team, part, context): the part is called by its name, so that one that is INLINE is a loop of its caller where there is no team. */
#define team_deal(team, part, ...)              \
    do {                                        \
        Team *team_ = (team);                   \
        if (team_)                              \
            team_share_out(team_, (part), (__VA_ARGS__)); \
        else                                    \
            (part)((__VA_ARGS__), 0, 1);        \
    } while (0)

/* Within a part of team_run: waits until all have come here. What they wrote before is seen by all after. */
void team_meet(Team *t);
void team_pause(int tries);     /* a little while, for a loop that waits; after many tries others may have the processor */

/* The share of `count` things in a row that falls to a thread, or is dealt out: first <= i < end. A division takes longer than much of
 * what is dealt out to one. */
static inline int team_first(int count, int thread, int threads)
{
    return thread == 0 ? 0 : thread == threads ? count : (int)((int64_t)count * thread / threads);
}
static inline int team_end(int count, int thread, int threads) { return team_first(count, thread + 1, threads); }

#endif
