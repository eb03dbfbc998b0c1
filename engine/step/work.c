/* step/work.c - how much a step did, from what its groups counted (world/work.c says what a unit is). The same at any number of threads.
 *
 * The prices were fitted to the CPU time of the steps of worlds/ (docs/security.md has what came out).
 */
#include "step/step.h"

/* units, and multiplications for one */
enum { STEP = 200, BODY = 40, GROUP = 150, MOVE = 40, PAIR = 60, SWEEP = 40, ROW = 12, MULTIPLICATIONS = 20, EVALUATION = 120, TERM = 25 };

uint64_t work_of(const Group *g)
{
    uint64_t moving = (uint64_t)g->moving_count, pairs = (uint64_t)g->pair_count, rows = (uint64_t)(g->point_count + g->row_count);
    uint64_t substeps = (uint64_t)int_max(g->substeps, 1), sweeps = (uint64_t)g->sweeps, evaluations = (uint64_t)(g->evaluations + g->kind_turns + g->refused);
    uint64_t factors = (uint64_t)(g->multiplied / MULTIPLICATIONS);
    uint64_t done = GROUP + factors + substeps * (MOVE * moving + PAIR * pairs) + sweeps * (SWEEP + ROW * rows);
    return done + evaluations * (EVALUATION + TERM * (moving + pairs + rows));
}

void count_work(World *w, Step *s)
{
    uint64_t sum = STEP + BODY * (uint64_t)w->awake.count;
    s->dear_work = 0;
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        uint64_t work = work_of(g);
        sum += work;
        s->dear_work += g->crowd || g->calm ? 0 : work;
    }
    world_work(w, sum);
}
