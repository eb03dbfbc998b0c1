/* base/team.c - meetings of threads: by looking again and again, for they are short. */
#include "base/team.h"

#include <sched.h>

#define PATIENCE 2000           /* looks, a few tens of microseconds; then the processor is offered to others */

void team_pause(int tries)
{
    if (tries > PATIENCE)
        sched_yield();
#if defined(__x86_64__)
    else
        __builtin_ia32_pause();
#endif
}

typedef struct Deal { TeamPart *part; void *context; int shares; atomic_int next; } Deal;

static void take_shares(void *context, int thread, int threads)
{
    Deal *d = context;
    (void)thread;
    (void)threads;
    for (int i; (i = atomic_fetch_add_explicit(&d->next, 1, memory_order_relaxed)) < d->shares;)
        d->part(d->context, i, d->shares);
}

void team_share_out(Team *t, TeamPart *part, void *context)
{
    Deal d = {.part = part, .context = context, .shares = team_shares(t)};
    t->run(t, take_shares, &d);
}

void team_meet(Team *t)
{
    if (!t)
        return;
    unsigned over = atomic_load_explicit(&t->meetings, memory_order_relaxed);
    if (atomic_fetch_add_explicit(&t->arrived, 1, memory_order_acq_rel) == t->threads - 1) {
        atomic_store_explicit(&t->arrived, 0, memory_order_relaxed);
        atomic_store_explicit(&t->meetings, over + 1, memory_order_release);
        return;
    }
    for (int tries = 0; atomic_load_explicit(&t->meetings, memory_order_acquire) == over; tries += tries < INT32_MAX)
        team_pause(tries);
}
