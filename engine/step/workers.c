/* step/workers.c - a small pool of threads that share out the groups of one step.
 *
 * Which thread takes a group does not matter: groups share no writable data,
 * and each thread has scratch memory of its own. A group too large for one
 * thread is advanced by all of them as a team.
 */
#include "step/step.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

typedef struct Worker { struct Workers *pool; Arena step, group; pthread_t thread; int number; } Worker;       /* arenas: see Scratch */

struct Workers {
    Team            team;           /* comes first: a Team * of this pool is its address        */
    int             count;          /* besides the calling thread                               */
    Worker         *workers;
    TeamPart       *part;           /* of this round                                            */
    void           *context;
    _Alignas(TEAM_LINE) atomic_uint round;
    _Alignas(TEAM_LINE) atomic_int busy;
    _Alignas(TEAM_LINE) atomic_int asleep;
    atomic_bool     stop;
    pthread_mutex_t lock;           /* for those who sleep                                      */
    pthread_cond_t  start;
};

/* A worker looks for the next round for about a millisecond, and lets others have its processor for most of it: within a step one comes
 * soon, and to be woken takes longer than most rounds. */
#define LOOKS 4000

/* False: there is none to come. */
static bool next_round(struct Workers *p, unsigned *round)
{
    for (int i = 0; i < LOOKS; i++) {
        if (atomic_load(&p->round) != *round || atomic_load(&p->stop))
            break;
        team_pause(i);
    }
    if (atomic_load(&p->round) == *round && !atomic_load(&p->stop)) {
        pthread_mutex_lock(&p->lock);
        atomic_fetch_add(&p->asleep, 1);        /* before the round is looked at: who begins one looks at them the other way round */
        while (atomic_load(&p->round) == *round && !atomic_load(&p->stop))
            pthread_cond_wait(&p->start, &p->lock);
        atomic_fetch_sub(&p->asleep, 1);
        pthread_mutex_unlock(&p->lock);
    }
    *round = atomic_load(&p->round);
    return !atomic_load(&p->stop);
}

static void *run_worker(void *arg)
{
    Worker *self = arg;
    struct Workers *p = self->pool;
    for (unsigned round = 0; next_round(p, &round);) {
        p->part(p->context, self->number, p->team.threads);
        atomic_fetch_sub(&p->busy, 1);
    }
    return NULL;
}

static void wake_sleepers(struct Workers *p)
{
    if (atomic_load(&p->asleep) == 0)
        return;
    pthread_mutex_lock(&p->lock);
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
}

static void run_team(Team *t, TeamPart *part, void *context)
{
    struct Workers *p = (struct Workers *)(void *)t;
    p->part = part;
    p->context = context;
    atomic_store(&p->busy, p->count);
    atomic_fetch_add(&p->round, 1);
    wake_sleepers(p);
    part(context, 0, t->threads);
    for (int tries = 0; atomic_load(&p->busy) > 0; tries += tries < INT32_MAX)
        team_pause(tries);
}

dig_status workers_open(int threads, struct Workers **out)
{
    struct Workers *p = aligned_alloc(TEAM_LINE, sizeof *p);
    Worker *workers = calloc((size_t)threads, sizeof *workers);
    TeamHand *hand = aligned_alloc(TEAM_LINE, (size_t)threads * sizeof *hand);
    if (!p || !workers || !hand) {
        free(p);
        free(workers);
        free(hand);
        return DIG_E_MEMORY;
    }
    memset(p, 0, sizeof *p);
    p->workers = workers;
    p->team.hand = hand;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->start, NULL);
    for (int i = 0; i < threads - 1; i++) {
        p->workers[i].pool = p;
        p->workers[i].number = i + 1;
        if (pthread_create(&p->workers[i].thread, NULL, run_worker, &p->workers[i]) != 0)
            break;                      /* fewer threads: slower, the same bits */
        p->count++;
    }
    p->team.run = run_team;
    p->team.threads = p->count + 1;
    *out = p;
    return DIG_OK;
}

void workers_close(struct Workers *p)
{
    if (!p)
        return;
    atomic_store(&p->stop, true);
    wake_sleepers(p);
    for (int i = 0; i < p->count; i++) {
        pthread_join(p->workers[i].thread, NULL);
        arena_close(&p->workers[i].step);
        arena_close(&p->workers[i].group);
    }
    pthread_cond_destroy(&p->start);
    pthread_mutex_destroy(&p->lock);
    free(p->team.hand);
    free(p->workers);
    free(p);
}

Team *workers_team(struct Workers *p) { return p && p->count > 0 ? &p->team : NULL; }

typedef struct Jobs { struct Workers *pool; Scratch own; Job *job; void *context; int count; atomic_int next; } Jobs;

static void take_jobs(void *context, int thread, int threads)
{
    Jobs *j = context;
    Worker *worker = &j->pool->workers[int_max(thread - 1, 0)];
    Scratch scratch = thread == 0 ? j->own : (Scratch){&worker->step, &worker->group};
    (void)threads;
    for (int i; (i = atomic_fetch_add(&j->next, 1)) < j->count;)
        j->job(j->context, i, scratch);
}

void workers_share(struct Workers *p, Scratch own, Job *job, void *context, int count)
{
    Team *team = workers_team(p);
    for (int i = 0; i < count && !team; i++)
        job(context, i, own);
    if (!team)
        return;
    Jobs j = {.pool = p, .own = own, .job = job, .context = context, .count = count};
    team_run(team, take_jobs, &j);
}

void workers_reset(struct Workers *p)
{
    for (int i = 0; i < p->count; i++) {
        arena_reset(&p->workers[i].step);
        arena_reset(&p->workers[i].group);
    }
}

size_t workers_bytes(const struct Workers *p)
{
    size_t bytes = sizeof *p;
    for (int i = 0; i < p->count; i++)
        bytes += arena_bytes(&p->workers[i].step) + arena_bytes(&p->workers[i].group);
    return bytes;
}
