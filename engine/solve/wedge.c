/* solve/wedge.c - a group in which movers hold something (solve/grip.c). Where that is all that would move, nothing is solved: it goes where they take
 * it. Else the sweep takes the group, with what is held as movers.
 *
 * What else it touches it must not have gone into by the end of the step: then it is for the sweep, not held.
 */
#include "solve/group.h"

static bool still(const Group *g, int body) { return vec3_is_zero(g->vel[body].v) && vec3_is_zero(g->vel[body].w); }

static bool holds_all(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves || g->member[i].dormant)
            return false;
    return true;
}

static void move(Group *g, real dt)
{
    for (int i = 0; i < g->body_count; i++) {
        if (!g->member[i].kinematic)
            continue;
        g->pos[i].x = vec3_mad(g->pos[i].x, dt, g->vel[i].v);
        if (!still(g, i))
            g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(dt, g->vel[i].w)), g->pos[i].q));
    }
    grip_follow(g, dt);
    grip_lead(g);
    for (int i = 0; i < g->carried_count; i++) {
        Carried *h = &g->carried[i];
        g->pos[h->body].x = vec3_add(g->pos[h->body].x, h->heals);
        h->heals = vec3_zero();
    }
}

/* m  The deepest contact beside those that hold. */
static real depth_of_others(const Group *g)
{
    real deep = 0;
    for (int i = 0; i < g->contact_count; i++)
        deep = g->contacts[i].live && !grip_is_jaw(g, 0, g->jaw_count, i) ? real_max(deep, contact_depth(&g->contacts[i])) : deep;
    return deep;
}

/* Does all that is held still touch nothing deeper than before, but for its holders? */
static bool came_through(const Group *g, real before)
{
    for (int i = 0; i < g->jaw_count; i++)
        if (!g->contacts[g->jaws[i]].live)
            return false;
    for (int i = 0; i < g->carried_count; i++)
        if (vec3_distance(g->pos[g->carried[i].body].x, g->carried[i].from) > g->member[g->carried[i].body].outer)
            return false;
    return depth_of_others(g) <= before + GRIP_SINKS * g->member[g->carried[0].body].outer;
}

static void book(Group *g)
{
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        for (int k = 0; k < c->manifold.room; k++)
            contact_memory(c)[k] = (PointMemory){.held = c->live && k < c->manifold.count ? HELD_SUBSTEPS : 0};
        g->penetration = c->live ? real_max(g->penetration, contact_depth(c)) : g->penetration;
    }
    group_book_pushes(g);
}

static dig_status advance(Group *g, real dt)
{
    GroupKept kept;
    DIG_TRY(grip_take(g, dt, 0));
    if (g->woke)
        return DIG_OK;          /* what they carry comes at a sleeper: this try is thrown away */
    if (!holds_all(g)) {        /* but maybe some */
        g->handed_on = true;
        return DIG_OK;
    }
    if (!group_keep(g, &kept))
        return DIG_E_MEMORY;
    real deep = depth_of_others(g);
    g->h = dt;
    move(g, dt);
    group_touch(g, dt, true);
    if (!came_through(g, deep)) {
        group_put_back(g, &kept);
        grip_let_go(g);
        g->handed_on = true;
        return DIG_OK;
    }
    book(g);
    g->evaluations = g->substeps = 1;
    g->t = dt;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_wedge = {.name = "wedge", .tally = WAY_SWEPT, .suits = grip_possible, .advance = advance, .inertias = true, .carries = true};
