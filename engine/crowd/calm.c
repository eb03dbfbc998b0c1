/* crowd/calm.c - many bodies that lie on each other, solved as few are.
 *
 * A crowd carries loads by overlap, and passes hand them on body by body: a tower of sixty is more than they carry, and what lies there
 * trembles by millimetres a second, never asleep. Once it is calm its forces hardly change: a direct solve (solve/direct.c) finds them in
 * some dozens of factorisations, the next steps in none, and half a second later all is asleep. What slides a little in a heap takes more
 * than that is worth: then it is swept, for as many steps as after a failure of the traced way. In one part of the step, with as many
 * sweeps as few bodies have: heaps of 100 to 450 boxes in a room, which crept by millimetres a second for ever as a crowd and in four
 * parts, sleep 4 to 15 s after they were dropped (37 of 37; of 16 more of 150, 15 within 20 s). What sweeps leave too rough is put back,
 * and is a crowd in this step (4 of 15,000 steps of such heaps).
 */
#include "crowd/crowd.h"

#define ROUGH 1e-2              /* m/s */

static bool suits(const Group *g) { return g->calm; }

static dig_status advance(Group *g, real dt)
{
    GroupKept before;
    if (!group_keep(g, &before))
        return DIG_E_MEMORY;
    DIG_TRY(sweep_advance(g, dt));
    g->trace_failed = g->trace_wait == 0 && g->direct_failures > 0;
    if (g->woke || g->residual <= ROUGH)
        return DIG_OK;
    int factors = g->factors;
    real multiplied = g->multiplied;
    group_put_back(g, &before);
    g->factors = factors;
    g->multiplied = multiplied;
    g->calm = false;
    g->crowd = g->handed_on = g->trace_failed = true;
    return DIG_OK;
}

const Way way_calm = {.name = "calm", .tally = WAY_SWEPT, .suits = suits, .advance = advance, .inertias = true};
