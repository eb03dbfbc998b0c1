/* solve/ways.c - the ways to advance a group, in order of preference. Counts decide, never the clock. */
#include "solve/group.h"

static bool suits_all(const Group *g)
{
    (void)g;
    return true;
}

static const Way way_sweep = {.name = "sweep", .suits = suits_all, .advance = sweep_advance};

const Way *const ways[] = {&way_sweep, NULL};

dig_status group_advance(Group *g, real dt)
{
    for (int i = 0; ways[i]; i++)
        if (ways[i]->suits(g))
            return ways[i]->advance(g, dt);
    return DIG_E_ARG;
}
