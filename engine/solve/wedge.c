/* solve/wedge.c - one body that two stiff things squeeze, and hold by friction: it goes where they take it.
 *
 * No force says how it moves, for between stiff things any pair of opposite forces is one: a solve finds some, with as much friction, from substep to
 * substep other ones. Where both rub, what they have taken hold of they do not let slip. So it goes with the mean of both, and to where it is as
 * deep in the one as in the other. What else it touches must not be in its way: that, blows, and bodies that press on it are for the sweep.
 */
#include "solve/group.h"

#define HEAL_SPEED 3.0          /* m/s per sqrt(m): as in project.c */
#define SLIPS 1e-6              /* of the size in a step */
#define SINKS 1e-9              /* of the size: by less it does not go into what else it touches */

static bool still(const Group *g, int body) { return vec3_is_zero(g->vel[body].v) && vec3_is_zero(g->vel[body].w); }

static bool suits(const Group *g)
{
    if (g->moving_count != 1 || g->pair_count < 2 || g->joint_count > 0 || g->push_count > 0 || g->planar || g->own || g->varies)
        return false;
    if (!g->member[0].moves || g->member[0].integrator != DIG_AUTO || g->world->region_count > 0)
        return false;
    for (int i = 1; i < g->body_count; i++)
        if (g->member[i].dormant)
            return false;
    return squeeze_possible(g);
}

/* The two contacts that squeeze; false: there are others, or one lets slip, or nobody drives them: what was made a little too wide for its place
 * between two that are fixed is not held there. */
static bool find_jaws(const Group *g, int jaw[2])
{
    int n = 0;
    bool driven = false;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!is_squeezed(g, i))
            continue;
        if (n == 2 || !(g->pairs[c->pair].friction > 0) || g->pairs[c->pair].fresh)
            return false;
        driven = driven || g->member[c->a].kinematic || g->member[c->b].kinematic;
        jaw[n++] = i;
    }
    return n == 2 && driven;
}

/* Do they move alike, but for what squeezes? What glides past the other would make it roll, or lets it slip. */
static bool move_alike(const Group *g, const int jaw[2])
{
    vec3 v[2], w[2], n = g->contacts[jaw[0]].manifold.normal;
    real size = g->pairs[g->contacts[jaw[0]].pair].size;
    for (int k = 0; k < 2; k++) {
        const GroupContact *at = &g->contacts[jaw[k]];
        int by = at->a == 0 ? at->b : at->a;
        w[k] = g->vel[by].w;
        v[k] = vec3_add(g->vel[by].v, vec3_cross(w[k], vec3_sub(g->pos[0].x, g->pos[by].x)));
    }
    vec3 off = vec3_sub(v[1], v[0]);
    real slips = vec3_length(vec3_mad(off, -vec3_dot(n, off), n)) + size * vec3_distance(w[0], w[1]);
    return slips * g->world->def.step <= SLIPS * size;
}

/* How they move it: by this speed, and in this step by `heals` more. */
typedef struct Carried { Vel vel; vec3 heals; } Carried;

/* m  What turns takes it round, not along the tangent: that would let it out of turning jaws by half the square of their turn in each step. */
static vec3 bend(vec3 w, vec3 arm, real dt)
{
    if (vec3_is_zero(w))
        return vec3_zero();
    return vec3_sub(quat_rotate(quat_exp(vec3_scale(dt, w)), arm), vec3_mad(arm, dt, vec3_cross(w, arm)));
}

static Carried carried_by(const Group *g, const int jaw[2], real dt)
{
    Carried c = {0};
    vec3 bends = vec3_zero();
    real depth[2], size = INFINITY;
    for (int k = 0; k < 2; k++) {
        const GroupContact *at = &g->contacts[jaw[k]];
        int by = at->a == 0 ? at->b : at->a;
        vec3 arm = vec3_sub(g->pos[0].x, g->pos[by].x);
        c.vel.v = vec3_mad(c.vel.v, 0.5, vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, arm)));
        c.vel.w = vec3_mad(c.vel.w, 0.5, g->vel[by].w);
        bends = vec3_mad(bends, 0.5, bend(g->vel[by].w, arm, dt));
        depth[k] = contact_depth(at);
        size = real_min(size, g->pairs[at->pair].size);
    }
    const GroupContact *first = &g->contacts[jaw[0]];
    real most = HEAL_SPEED * sqrt(size) * dt, side = first->b == 0 ? 1 : -1;
    c.heals = vec3_mad(bends, side * real_clamp(0.5 * (depth[0] - depth[1]), -most, most), first->manifold.normal);
    return c;
}

/* m  What it touches besides, and goes into. */
static bool in_its_way(const Group *g, const Carried *c, real dt)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *at = &g->contacts[i];
        real side = at->b == 0 ? 1 : -1;
        int by = at->a == 0 ? at->b : at->a;
        for (int k = 0; at->live && !is_squeezed(g, i) && k < at->manifold.count; k++) {
            const ManifoldPoint *p = &at->manifold.points[k];
            vec3 v = vec3_add(c->vel.v, vec3_cross(c->vel.w, vec3_sub(p->a, g->pos[0].x)));
            vec3 u = vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, vec3_sub(p->a, g->pos[by].x)));
            real way = side * vec3_dot(at->manifold.normal, vec3_mad(c->heals, dt, vec3_sub(v, u)));
            if (p->gap + way < real_min(p->gap, 0) - SINKS * g->pairs[at->pair].size)
                return true;
        }
    }
    return false;
}

static real energy_of(const Group *g) { return group_kinetic_of(g, 0) - vec3_dot(g->member[0].force, g->pos[0].x); }

static void move(Group *g, const Carried *c, real dt)
{
    for (int i = 0; i < g->body_count; i++) {
        if (i == 0)
            g->vel[i] = c->vel;
        else if (!g->member[i].kinematic)
            continue;
        g->pos[i].x = vec3_mad(g->pos[i].x, dt, g->vel[i].v);
        if (!still(g, i))
            g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(dt, g->vel[i].w)), g->pos[i].q));
    }
    g->pos[0].x = vec3_add(g->pos[0].x, c->heals);
}

/* Does it still touch nothing deeper than before, but for the two? */
static bool came_through(const Group *g, const int jaw[2], real before)
{
    for (int i = 0; i < g->contact_count; i++)
        if (g->contacts[i].live && i != jaw[0] && i != jaw[1] && contact_depth(&g->contacts[i]) > before + SINKS * g->member[0].outer)
            return false;
    return g->contacts[jaw[0]].live && g->contacts[jaw[1]].live;
}

static void book(Group *g, const int jaw[2], real gained, real dt)
{
    g->work_in += real_max(0, gained);
    g->lost += real_max(0, -gained);
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        for (int k = 0; k < c->manifold.room; k++)
            contact_memory(c)[k] = (PointMemory){.held = c->live && k < c->manifold.count ? HELD_SUBSTEPS : 0};
        g->penetration = c->live ? real_max(g->penetration, contact_depth(c)) : g->penetration;
    }
    for (int k = 0; k < 2; k++) {
        g->contacts[jaw[k]].last = dt;
        g->contacts[jaw[k]].manifold.slides = false;
    }
    g->member[0].constrained = true;
}

static dig_status advance(Group *g, real dt)
{
    int jaw[2];
    GroupKept kept;
    DIG_TRY(squeeze_open(g));
    if (!group_keep(g, &kept))
        return DIG_E_MEMORY;
    group_squeeze(g, JAWS_RUB);
    bool goes = g->squeezes && find_jaws(g, jaw) && move_alike(g, jaw);
    if (goes) {
        g->h = dt;
        DIG_TRY(group_forces(g));
        Carried c = carried_by(g, jaw, dt);
        real before = energy_of(g), deep = 0, far = dt * vec3_length(c.vel.v) + vec3_length(c.heals);
        for (int i = 0; i < g->contact_count; i++)
            deep = g->contacts[i].live && !is_squeezed(g, i) ? real_max(deep, contact_depth(&g->contacts[i])) : deep;
        goes = far < g->pairs[g->contacts[jaw[0]].pair].size && !in_its_way(g, &c, dt);
        if (goes) {
            move(g, &c, dt);
            group_touch(g, dt, true);
            goes = came_through(g, jaw, deep);
            book(g, jaw, energy_of(g) - before, dt);
        }
    }
    real missing = squeeze_missing(g);
    g->squeezes = false;
    if (!goes) {
        group_put_back(g, &kept);
        g->handed_on = true;
        return DIG_OK;
    }
    g->evaluations = g->substeps = 1;
    g->residual = missing;
    g->t = dt;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_wedge = {.name = "wedge", .tally = WAY_SWEPT, .suits = suits, .advance = advance, .inertias = true};
