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

typedef struct Deal { TeamPart *part; void *context; TeamHand *hand; } Deal;

#define ALL_SHARES (TEAM_SHARES << 16)          /* first that is left, and in the upper half the end of those that are */

/* The owner takes from the front, who helps from the back. < 0: none is left. */
static int take_share(TeamHand *h, bool own)
{
    int left = atomic_load_explicit(&h->left, memory_order_relaxed), first, end;
    do {
        first = left & 0xffff;
        end = left >> 16;
        if (first == end)
            return -1;
    } while (!atomic_compare_exchange_weak_explicit(&h->left, &left, own ? left + 1 : left - (1 << 16), memory_order_relaxed, memory_order_relaxed));
    return own ? first : end - 1;
}

static void take_shares(void *context, int thread, int threads)
{
    Deal *d = context;
    for (int k = 0; k < threads; k++) {
        int whose = (thread + k) % threads;
        for (int i; (i = take_share(&d->hand[whose], k == 0)) >= 0;)
            d->part(d->context, TEAM_SHARES * whose + i, TEAM_SHARES * threads);
    }
}

void team_share_out(Team *t, TeamPart *part, void *context)
{
    Deal d = {.part = part, .context = context, .hand = t->hand};
    for (int i = 0; i < t->threads; i++)
        atomic_store_explicit(&t->hand[i].left, ALL_SHARES, memory_order_relaxed);
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
