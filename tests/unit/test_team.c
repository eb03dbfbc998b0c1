/* tests/unit/test_team.c - what threads do together: every share is dealt once, whoever takes it, and shares have no gaps. */
#include "check.h"
#include "base/team.h"
#include "step/step.h"

#include <stdlib.h>

enum { THINGS = 1000, MOST_SHARES = 8 * 64 };

typedef struct Work { atomic_int done[THINGS], calls, shares; } Work;

static void mark(void *context, int share, int shares)
{
    Work *w = context;
    atomic_fetch_add(&w->calls, 1);
    atomic_store(&w->shares, shares);
    for (int i = team_first(THINGS, share, shares); i < team_end(THINGS, share, shares); i++)
        atomic_fetch_add(&w->done[i], 1);
}

static void check_deals(Team *t)
{
    for (int round = 0; round < 200; round++) {
        Work *w = calloc(1, sizeof *w);
        CHECK(w);
        team_deal(t, mark, w);
        CHECK_INT(w->calls, team_shares(t));
        CHECK_INT(w->shares, team_shares(t));
        for (int i = 0; i < THINGS; i++)
            CHECK_INT(w->done[i], 1);
        free(w);
    }
}

TEST(a_deal_does_each_share_once_with_any_number_of_threads)
{
    CHECK_INT(team_shares(NULL), 1);
    check_deals(NULL);
    static const int threads[] = {2, 3, 8};
    for (int i = 0; i < 3; i++) {
        struct Workers *p;
        CHECK_INT(workers_open(threads[i], &p), DIG_OK);
        Team *t = workers_team(p);
        CHECK(t ? team_shares(t) % t->threads == 0 : true);         /* a machine may refuse threads */
        check_deals(t);
        workers_close(p);
    }
}

/* The first share is over when all others are: those of its own thread, too, which others must have taken. */
static void wait_for_all(void *context, int share, int shares)
{
    Work *w = context;
    for (int tries = 0; share == 0 && atomic_load(&w->calls) < shares - 1; tries++)
        team_pause(tries);
    atomic_fetch_add(&w->calls, 1);
}

TEST(who_is_done_helps_a_thread_that_is_late)
{
    struct Workers *p;
    CHECK_INT(workers_open(3, &p), DIG_OK);
    Work *w = calloc(1, sizeof *w);
    CHECK(w);
    Team *t = workers_team(p);
    if (t) {
        team_deal(t, wait_for_all, w);
        CHECK_INT(w->calls, team_shares(t));
    }
    free(w);
    workers_close(p);
}

TEST(shares_of_fewer_things_than_there_are_shares_leave_none_out)
{
    for (int count = 0; count < 40; count++)
        for (int shares = 1; shares < MOST_SHARES; shares += 7) {
            int next = 0;
            for (int s = 0; s < shares; s++) {
                CHECK_INT(team_first(count, s, shares), next);
                next = team_end(count, s, shares);
            }
            CHECK_INT(next, count);
        }
}

int main(void)
{
    RUN_TESTS(unit_test(a_deal_does_each_share_once_with_any_number_of_threads), unit_test(who_is_done_helps_a_thread_that_is_late),
              unit_test(shares_of_fewer_things_than_there_are_shares_leave_none_out));
}
