/* chain/way.c - which groups are advanced as trees of joints, how the step is cut, and what is reported. */
#include "chain/chain.h"
#include "chain/system.h"

#define WEIGHT      0.51        /* of the end velocity: 1/2 keeps all energy, 1 is the backward Euler rule */
#define PARTS_MOST  16          /* substeps that a step is cut into where one does not do */
#define SPIN_MOST   0.7         /* rad  of a substep, at the start                        */
#define APART_MOST  0.01        /* of a body's size: joints further apart are swept       */
#define NEAR        1e-3        /* of the smaller body's size: a gap that counts as none */
#define ENOUGH_MOST 2e-5        /* m    error of joints at the end of a step, at any plan */

/* ---- what is taken ---- */

static bool plain_members(const Group *g)
{
    for (int i = 0; i < g->body_count; i++)
        if (g->member[i].dormant || (g->member[i].moves && g->member[i].integrator != DIG_AUTO))
            return false;
    return true;
}

static bool plain_joints(const Group *g)
{
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].broken || !g->world->joints.data[g->joints[i].slot].plain)
            return false;
    return true;
}

static bool suits(const Group *g)
{
    if (g->may_trace || g->joint_count == 0 || g->plan->crowd_total == INT32_MAX || g->planar || !plain_members(g))
        return false;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (contact_memory(&g->contacts[i])[k].normal > 0)
                return false;           /* it carried load a step ago */
    return plain_joints(g);
}

/* ---- one tree ---- */

Pos fixed_pose(const Group *g, int body, real time)
{
    if (body < 0)
        return (Pos){vec3_zero(), quat_identity()};
    if (!g->member[body].kinematic)
        return g->pos[body];
    quat turn = quat_exp(vec3_scale(time, g->vel[body].w));
    return (Pos){vec3_mad(g->pos[body].x, time, g->vel[body].v), quat_unit(quat_mul(turn, g->pos[body].q))};
}

/* Of an anchor that does not move, or is driven, between the times t0 and t1. */
static void begin_fixed(const Chain *c, int joint, int side, real t0, real t1)
{
    const GroupJoint *j = &c->g->joints[joint];
    Tie *t = &c->tie[joint];
    int body = side ? j->b : j->a;
    vec3 anchor = side ? j->rb : j->ra;
    Pos p0 = fixed_pose(c->g, body, t0), p1 = fixed_pose(c->g, body, t1);
    vec3 arm = quat_rotate(p1.q, anchor);
    t->fixed = reg3_of(vec3_scale(side ? -1 : 1, vec3_add(p1.x, arm)));
    t->arm = vec3_scale(0.5, vec3_add(quat_rotate(p0.q, anchor), arm));
}

/* From that time on. */
static void begin_anchors(const Chain *c, const Linkage *t, real from)
{
    for (int n = t->first_tie; n < t->last_tie; n++)
        for (int side = 0; side < 2; side++)
            if (c->tie[c->owned[n]].end[side] < 0)
                begin_fixed(c, c->owned[n], side, from, from + c->h);
}

/* What the joints of a substep do to bodies that do not move. */
static void twist_fixed(const Chain *c, const Linkage *t)
{
    for (int n = t->first_tie; n < t->last_tie; n++) {
        Tie *tie = &c->tie[c->owned[n]];
        if (tie->end[0] >= 0 && tie->end[1] >= 0)
            continue;
        const int end = moving_end(tie);
        const Ends *e = ends_of(c, end);
        tie->twist = vec3_sub(tie->twist, vec3_cross(tie->arm, vec3_scale(e->side[lane_of(end)], four3_get(&e->p, lane_of(end)))));
    }
}

/* Of a tree that was opened. */
static int parts_of(const Chain *c, real dt)
{
    int parts = 1;
    while (parts < PARTS_MOST && c->spin * dt > parts * SPIN_MOST)
        parts *= 2;
    return parts;
}

/* The whole step of one tree, cut finer until it succeeds. */
static bool advance_tree(Chain *c, const Linkage *t, real dt)
{
    links_open(c, t);
    for (int parts = parts_of(c, dt); parts <= PARTS_MOST; parts *= 2) {
        bool done = true;
        c->h = dt / parts;
        ties_guess(c, t);
        for (int i = 0; i < parts && done; i++) {
            begin_anchors(c, t, i * c->h);
            done = tree_step(c, t);
            if (done)
                twist_fixed(c, t);
        }
        if (!done) {
            c->g->refused++;
            links_open(c, t);
            continue;
        }
        c->lost += c->began - c->ended;
        c->g->substeps = int_max(c->g->substeps, parts);
        c->g->joint_error = real_max(c->g->joint_error, c->error);
        return true;
    }
    return false;
}

/* ---- what is kept ---- */

/* J  Of movers, by what holds to them: in the order of the joints. */
static real given_by_movers(const Chain *c)
{
    const Group *g = c->g;
    real work = g->work_in;
    for (int i = 0; i < c->ties && g->movers; i++) {
        const GroupJoint *j = &g->joints[i];
        if (j->a >= 0 && g->member[j->a].kinematic)
            work -= vec3_dot(j->impulse, g->vel[j->a].v) + vec3_dot(j->angular_impulse, g->vel[j->a].w);
        if (j->b >= 0 && g->member[j->b].kinematic)
            work -= -vec3_dot(j->impulse, g->vel[j->b].v) + vec3_dot(tie_twist_on_b(c, i), g->vel[j->b].w);
    }
    return work;
}

/* J  By forces, since the start of the step. */
static real work_of(Group *g, real dt)
{
    real work = 0;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves)
            work += vec3_dot(g->member[i].force, vec3_sub(g->pos[i].x, g->start_pos[i].x)) +
                    0.5 * dt * vec3_dot(g->member[i].torque, vec3_add(g->vel[i].w, g->start_vel[i].w));
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        vec3 turn = vec3_scale(0.5 * dt, vec3_add(g->vel[p->body].w, g->start_vel[p->body].w));
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        vec3 way = vec3_sub(g->pos[p->body].x, g->start_pos[p->body].x);
        real done = vec3_dot(p->force, vec3_add(way, vec3_cross(turn, arm))) + vec3_dot(p->torque, turn);
        group_book_push(g, p, done);
    }
    return work;
}

/* ---- contacts: nothing may touch ---- */

static bool any_near(const Group *g, real time)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            const ManifoldPoint *p = &c->manifold.points[k];
            vec3 va = vec3_add(g->vel[c->a].v, vec3_cross(g->vel[c->a].w, vec3_sub(p->a, g->pos[c->a].x)));
            vec3 vb = vec3_add(g->vel[c->b].v, vec3_cross(g->vel[c->b].w, vec3_sub(p->b, g->pos[c->b].x)));
            if (p->gap < NEAR * g->pairs[c->pair].size + 2 * time * vec3_length(vec3_sub(vb, va)) + g->fall * time * time)
                return true;
        }
    }
    return false;
}

/* What looking for contacts changes, and the poses; nothing else is written before the step has succeeded. */
typedef struct Saved { GroupContact *contacts; real *places; GroupPair *pairs; } Saved;

static dig_status save(const Group *g, Saved *s)
{
    s->contacts = arena_alloc(g->arena, (size_t)(g->contact_count + 1) * sizeof *s->contacts);
    s->pairs = arena_alloc(g->arena, (size_t)(g->pair_count + 1) * sizeof *s->pairs);
    s->places = arena_alloc(g->arena, (size_t)(g->place_count + 1) * sizeof *s->places);
    if (!s->contacts || !s->places || !s->pairs)
        return DIG_E_MEMORY;
    if (g->pair_count > 0)
        memcpy(s->pairs, g->pairs, (size_t)g->pair_count * sizeof *s->pairs);
    if (g->contact_count > 0)
        memcpy(s->contacts, g->contacts, (size_t)g->contact_count * sizeof *s->contacts);
    if (g->place_count > 0)
        memcpy(s->places, g->places, (size_t)g->place_count * sizeof *s->places);
    return DIG_OK;
}

/* why: what was tried in vain; NULL: nothing was tried. s: nothing was saved where there are no pairs, though there may be room for points. */
static dig_status hand_on(Group *g, const Saved *s, const char *why)
{
    if (g->pair_count > 0)
        memcpy(g->pairs, s->pairs, (size_t)g->pair_count * sizeof *s->pairs);
    if (s->contacts && g->contact_count > 0)
        memcpy(g->contacts, s->contacts, (size_t)g->contact_count * sizeof *s->contacts);
    if (s->places && g->place_count > 0)
        memcpy(g->places, s->places, (size_t)g->place_count * sizeof *s->places);
    for (int i = 0; i < g->moving_count; i++)
        g->member[i].force = g->member[i].torque = vec3_zero();
    g->substeps = 0;
    g->joint_error = 0;
    g->handed_on = true;
    if (why)
        g->gave_up = why;
    return DIG_OK;
}

/* ---- the step ---- */

static dig_status apply_forces(Group *g, real dt)
{
    g->h = dt;
    return group_forces(g);
}

/* Links and driven bodies go where they are at the end of the step. */
static void move_bodies(Chain *c, real dt)
{
    Group *g = c->g;
    for (int i = g->moving_count; i < g->body_count; i++) {
        g->start_pos[i] = g->pos[i];
        if (g->member[i].kinematic)
            g->pos[i] = fixed_pose(g, i, dt);
    }
    memcpy(g->start_pos, g->pos, (size_t)g->moving_count * sizeof *g->pos);
    memcpy(g->start_vel, g->vel, (size_t)g->moving_count * sizeof *g->vel);
    for (int i = 0; i < c->trees; i++)
        links_close(c, &c->tree[i]);
}

static void undo(Group *g)
{
    for (int i = 0; i < g->body_count; i++) {
        if (g->member[i].moves || g->member[i].kinematic)
            g->pos[i] = g->start_pos[i];
        if (g->member[i].moves)
            g->vel[i] = g->start_vel[i];
        group_refresh_mass(g, i);
    }
}

/* Nothing touches: what touches next is a blow. */
static void forget_contacts(Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < g->contacts[i].manifold.count; k++) {
            PointMemory *m = &contact_memory(&g->contacts[i])[k];
            m->normal = 0;
            m->held = 0;
            m->tangent = vec3_zero();
        }
}

/* What was found is the group's, or the group is handed on. */
static dig_status finish(Chain *c, const Saved *s, real dt)
{
    Group *g = c->g;
    real given = g->work_in;
    move_bodies(c, dt);
    if (g->pair_count > 0) {
        group_touch(g, dt / g->plan->substeps, true);
        if (group_deep(g)) {
            undo(g);
            return hand_on(g, s, NULL);
        }
    }
    for (int i = 0; i < c->trees; i++)
        ties_close(c, &c->tree[i]);
    g->work_in = given_by_movers(c);
    given = g->work_in - given;
    g->lost += c->lost + given + work_of(g, dt);
    for (int i = 0; i < g->moving_count && g->apart; i++)
        group_book_apart(g, i, vec3_sub(g->pos[i].x, g->start_pos[i].x), vec3_scale(0.5 * dt, vec3_add(g->vel[i].w, g->start_vel[i].w)), dt);
    g->t = dt;
    g->close_speed = group_close_speed(g);
    forget_contacts(g);
    return DIG_OK;
}

static dig_status advance(Group *g, real dt)
{
    /* where velocities break joints, those of the end alone count, and obey them */
    Chain c = {.g = g, .ties = g->joint_count, .k = group_joints_broken(g) ? 1 : WEIGHT,
               .enough = real_min(ENOUGH_MOST, 0.2 * g->plan->tolerance)};
    Saved saved = {0};
    bool fits = true;
    if (g->pair_count > 0) {
        DIG_TRY(save(g, &saved));
        group_touch(g, 2 * dt, true);
        if (any_near(g, dt))
            return hand_on(g, &saved, NULL);
    }
    ArenaMark mark = arena_mark(g->arena);
    DIG_TRY(tree_make(&c, &fits));
    if (!fits)
        return hand_on(g, &saved, NULL);
    DIG_TRY(apply_forces(g, dt));
    for (int i = 0; i < c.trees; i++)
        if (!advance_tree(&c, &c.tree[i], dt))
            return hand_on(g, &saved, "chain: no solution");
    DIG_TRY(finish(&c, &saved, dt));
    if (g->handed_on)
        return DIG_OK;
    if (g->pair_count == 0)         /* nothing of it is needed any more: the next group finds its room still in the cache */
        arena_rewind(g->arena, mark);
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    return g->status;
}

const Way way_chain = {.name = "chain", .tally = WAY_SWEPT, .suits = suits, .advance = advance};
