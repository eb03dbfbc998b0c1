/* step/ways.c - the ways to advance a group, in order of preference. Counts decide, never the clock. */
#include "chain/chain.h"
#include "conserve/conserve.h"
#include "crowd/crowd.h"
#include "step/step.h"
#include "trace/trace.h"

static bool suits_all(const Group *g)
{
    (void)g;
    return true;
}

static const Way way_sweep = {.name = "sweep", .tally = WAY_SWEPT, .suits = suits_all, .advance = sweep_advance, .inertias = true, .carries = true};

static const Way *const ways[] = {&way_tumble, &way_flight, &way_glide, &way_spring, &way_pendulum, &way_top, &way_bob, &way_wedge,
                                   &way_trace, &way_billiard, &way_conserve, &way_chain, &way_calm, &way_crowd, &way_tumble_late, &way_sweep};

INLINE void share_inertias(void *context, int thread, int threads)
{
    Group *g = context;
    for (int i = team_first(g->moving_count, thread, threads), end = team_end(g->moving_count, thread, threads); i < end; i++)
        group_refresh_mass(g, i);
}

static dig_status advance(Group *g, real dt)
{
    bool turned = false;        /* ways put back what they change */
    bool grips = group_grips(g);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        bool suits = (ways[i]->carries || !grips) && ways[i]->suits(g);
        grips = grips && (suits || ways[i] != &way_wedge);
        if (!suits)
            continue;
        if (ways[i] != &way_crowd && !g->mass)
            DIG_TRY(group_weigh(g));
        if (ways[i]->inertias && !turned)
            team_deal(g->team, share_inertias, g);
        turned = turned || ways[i]->inertias;
        g->way = ways[i];
        g->handed_on = false;
        dig_status status = ways[i]->advance(g, dt);
        if (status != DIG_OK || !g->handed_on)
            return status;
        if (ways[i] == &way_wedge)
            grips = g->carried_count > 0;
    }
    return DIG_E_ARG;
}

dig_status group_advance(Group *g, real dt)
{
    DIG_TRY(advance(g, dt));
    if (!g->movers)             /* nothing grips */
        return DIG_OK;
    grip_give(g);
    return grip_note(g);
}
