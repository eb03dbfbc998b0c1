/* solve/impulses.c - the impulses of a substep: by sweeps, and where these would take too long, of all rows at once.
 */
#include "solve/group.h"

/* m/s: and what is nearly at rest must not be worse than this, for it adds up */
#define CREEP 1e-6

/* A step that took so many sweeps locates no more impacts: each would cost as many again. Or so many times all those of its plan: what
 * is that fine may take as many where nothing is wrong, and a blow that is not located there costs a thousandth of its energy. */
#define DEAR 4000
#define DEAR_PLANS 5

#define WORK      8000          /* sweeps times rows of a substep */
#define WORK_CALM 300000        /* the same of many that lie there: a few seconds later they sleep, if sweeps get there */

static int sweeps_for(const Group *g, int most)
{
    int rows = 2 * g->joint_count + 1;
    for (int i = 0; i < g->contact_count; i++)
        rows += g->contacts[i].live;
    return (int)real_clamp((real)(g->calm ? WORK_CALM : WORK) / rows, 4, most);
}

/* So many are tried; where they do not get there, all rows are solved at once, and checked by so many more. */
#define FIRST_SWEEPS 12
#define LAST_SWEEPS 3

#define FACTOR_COSTS 3          /* sweeps */

/* Would sweeps, as they have come along so far, get there for less than the last direct solve of this step took? */
static bool soon_there(const Group *g, real wanted)
{
    real rate = log(g->residual / g->residual_first) / FIRST_SWEEPS, more = log(wanted / g->residual) / rate;
    return rate < 0 && !g->stalled && more < FACTOR_COSTS * g->direct_factors;
}

void relax_group(Group *g)
{
    real worst = g->residual;
    g->residual = 0;
    g->unsolved = false;
    int sweeps = sweeps_for(g, g->plan->sweeps);
    real wanted = lies_uneasy(g) ? 0 : direct_wanted(g);
    if (g->joints_direct && wanted > 0 && direct_solve(g, wanted)) {
        g->residual = real_max(g->residual, worst);
        return;
    }
    int done = wanted > 0 ? int_min(sweeps, FIRST_SWEEPS) : sweeps;
    relax(g, done, wanted > 0 ? wanted : g->plan->residual);
    while (wanted > 0 && g->residual > wanted && done + FIRST_SWEEPS <= sweeps && soon_there(g, wanted)) {
        g->residual = 0;
        relax(g, FIRST_SWEEPS, wanted);
        done += FIRST_SWEEPS;
    }
    if (wanted > 0 && g->residual > wanted && direct_solve(g, wanted)) {
        g->residual = 0;
        relax(g, LAST_SWEEPS, g->plan->residual);
    } else if (g->residual > g->plan->residual && sweeps > done) {
        g->residual = 0;
        relax(g, sweeps - done, g->plan->residual);
    }
    if (g->residual > (wanted > 0 ? CREEP : VELOCITY_COARSE) && direct_rescue(g) && g->row_count == 0) {
        g->residual = 0;
        relax(g, LAST_SWEEPS, g->plan->residual);
    }
    int more = sweeps_for(g, 10 * g->plan->sweeps) - sweeps;        /* none: what is left of it stays the residual */
    if (g->residual > VELOCITY_COARSE && !g->stalled && more > 0) {
        g->residual = 0;
        relax(g, more, VELOCITY_COARSE);
    }
    g->unsolved = g->residual > VELOCITY_COARSE && g->stalled;
    g->contradicts = g->contradicts || g->unsolved;
    if (g->unsolved || g->sweeps > int_max(DEAR, DEAR_PLANS * g->plan->substeps * g->plan->sweeps))
        g->events_left = 0;
    g->residual = real_max(g->residual, worst);
}
