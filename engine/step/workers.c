/* step/workers.c - a small pool of threads that share out the groups of one step.
 *
 * Which thread takes a group does not matter: groups share no writable data,
 * and each thread has scratch memory of its own.
 */
#include "step/step.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

typedef struct Worker { struct Workers *pool; Arena arena; pthread_t thread; } Worker;

struct Workers {
    int             count;          /* besides the calling thread */
    Worker         *workers;
    pthread_mutex_t lock;
    pthread_cond_t  start, done;
    uint64_t        round;          /* guarded by lock */
    int             busy;           /* guarded by lock */
    bool            stop;           /* guarded by lock */
    Job            *job;
    void           *context;
    int             jobs;
    atomic_int      next;
};

static void take_jobs(struct Workers *p, Arena *arena)
{
    for (;;) {
        int i = atomic_fetch_add(&p->next, 1);
        if (i >= p->jobs)
            return;
        p->job(p->context, i, arena);
    }
}

static void *run_worker(void *arg)
{
    Worker *self = arg;
    struct Workers *p = self->pool;
    uint64_t round = 0;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (p->round == round && !p->stop)
            pthread_cond_wait(&p->start, &p->lock);
        if (p->stop)
            break;
        round = p->round;
        pthread_mutex_unlock(&p->lock);
        take_jobs(p, &self->arena);
        pthread_mutex_lock(&p->lock);
        if (--p->busy == 0)
            pthread_cond_signal(&p->done);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

dig_status workers_open(int threads, struct Workers **out)
{
    struct Workers *p = calloc(1, sizeof *p);
    if (!p)
        return DIG_E_MEMORY;
    p->workers = calloc((size_t)threads, sizeof *p->workers);
    if (!p->workers) {
        free(p);
        return DIG_E_MEMORY;
    }
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->start, NULL);
    pthread_cond_init(&p->done, NULL);
    for (int i = 0; i < threads - 1; i++) {
        p->workers[i].pool = p;
        if (pthread_create(&p->workers[i].thread, NULL, run_worker, &p->workers[i]) != 0)
            break;                      /* fewer threads: slower, the same bits */
        p->count++;
    }
    *out = p;
    return DIG_OK;
}

void workers_close(struct Workers *p)
{
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->stop = true;
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
    for (int i = 0; i < p->count; i++) {
        pthread_join(p->workers[i].thread, NULL);
        arena_close(&p->workers[i].arena);
    }
    pthread_cond_destroy(&p->done);
    pthread_cond_destroy(&p->start);
    pthread_mutex_destroy(&p->lock);
    free(p->workers);
    free(p);
}

void workers_run(struct Workers *p, Arena *own, Job *job, void *context, int count)
{
    p->job = job;
    p->context = context;
    p->jobs = count;
    atomic_store(&p->next, 0);
    if (p->count == 0 || count < 2) {
        take_jobs(p, own);
        return;
    }
    pthread_mutex_lock(&p->lock);
    p->busy = p->count;
    p->round++;
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
    take_jobs(p, own);
    pthread_mutex_lock(&p->lock);
    while (p->busy > 0)
        pthread_cond_wait(&p->done, &p->lock);
    pthread_mutex_unlock(&p->lock);
}

void workers_reset(struct Workers *p)
{
    for (int i = 0; i < p->count; i++)
        arena_reset(&p->workers[i].arena);
}

size_t workers_bytes(const struct Workers *p)
{
    size_t bytes = sizeof *p;
    for (int i = 0; i < p->count; i++)
        bytes += arena_bytes(&p->workers[i].arena);
    return bytes;
}
