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
    for (int i = 0; i < g->joint_count; i++) {
        const JointView *v = &g->joints[i].view;
        if (!v->type->only_point || !v->type->only_point(v->params))
            return false;
    }
    return true;
}

static bool suits(const Group *g)
{
    if (g->may_trace || g->joint_count == 0 || g->plan->crowd_total == INT32_MAX || g->planar || !plain_members(g))
        return false;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            if (g->contacts[i].memory[k].normal > 0)
                return false;           /* it carried load a step ago */
    return plain_joints(g);
}

/* ---- one tree ---- */

static Pos fixed_pose(const Group *g, int body, real time)
{
    if (body < 0)
        return (Pos){vec3_zero(), quat_identity()};
    if (!g->member[body].kinematic)
        return g->pos[body];
    quat turn = quat_exp(vec3_scale(time, g->vel[body].w));
    return (Pos){vec3_mad(g->pos[body].x, time, g->vel[body].v), quat_unit(quat_mul(turn, g->pos[body].q))};
}

static void open_link(const Chain *c, Link *l)
{
    const Group *g = c->g;
    const Member *m = &g->member[l->body];
    l->mass = m->mass;
    l->inertia = m->inertia;
    l->x = g->pos[l->body].x;
    l->q = g->pos[l->body].q;
    l->r = quat_matrix(l->q);
    l->v = g->vel[l->body].v;
    l->w = mat3_mul_vec(mat3_transpose(l->r), g->vel[l->body].w);
}

/* The end of the last substep is the start of the next. */
static void begin_link(const Chain *c, Link *l)
{
    const Member *m = &c->g->member[l->body];
    l->x0 = l->x;
    l->q0 = l->q;
    l->r0 = l->r;
    l->v0 = l->v;
    l->w0 = l->w;
    l->p0 = vec3_mad(vec3_scale(l->mass, l->v0), c->h, m->force);
    l->l0 = vec3_mad(mat3_mul_vec(l->r0, mat3_mul_vec(l->inertia, l->w0)), c->h, m->torque);
}

/* Of an anchor that does not move, or is driven, between the times t0 and t1. */
static void begin_fixed(const Chain *c, Tie *t, int side, real t0, real t1)
{
    const GroupJoint *j = &c->g->joints[t->joint];
    int body = side ? j->b : j->a;
    vec3 anchor = side ? j->rb : j->ra;
    Pos p0 = fixed_pose(c->g, body, t0), p1 = fixed_pose(c->g, body, t1);
    vec3 arm = quat_rotate(p1.q, anchor);
    t->fixed = vec3_add(p1.x, arm);
    t->arm = vec3_scale(0.5, vec3_add(quat_rotate(p0.q, anchor), arm));
}

/* Of b, in which a joint's force is kept from step to step. */
static quat frame_of(const Chain *c, const Tie *t)
{
    const GroupJoint *j = &c->g->joints[t->joint];
    return quat_mul(t->link[1] >= 0 ? c->link[t->link[1]].q : fixed_pose(c->g, j->b, 0).q, j->fb);
}

static void guess(const Chain *c, Tie *t)
{
    const real *force = c->g->joints[t->joint].force;
    t->p = vec3_scale(c->h, quat_rotate(frame_of(c, t), (vec3){force[0], force[1], force[2]}));
    t->impulse = t->twist[0] = t->twist[1] = vec3_zero();
}

static void begin(const Chain *c, const Linkage *t, real from)
{
    for (int n = t->first; n < t->first + t->links; n++) {
        if (from == 0)
            open_link(c, &c->link[n]);
        begin_link(c, &c->link[n]);
    }
    for (int n = t->first; n < t->first + t->links; n++)
        for (int i = 0; i < c->link[n].ends; i++) {
            const End *e = &c->end[c->link[n].end + i];
            if (!link_owns(&c->link[n], i))
                continue;
            if (e->child < 0)
                begin_fixed(c, &c->tie[e->tie], e->side > 0, from, from + c->h);
            c->tie[e->tie].h = c->h;
            if (from == 0)
                guess(c, &c->tie[e->tie]);
        }
}

static int parts_of(const Chain *c, const Linkage *t, real dt)
{
    real w = 0;
    for (int n = t->first; n < t->first + t->links; n++)
        w = real_max(w, vec3_length2(c->g->vel[c->link[n].body].w));
    int parts = 1;
    while (parts < PARTS_MOST && sqrt(w) * dt > parts * SPIN_MOST)
        parts *= 2;
    return parts;
}

/* The whole step of one tree, cut finer until it succeeds. */
static bool advance_tree(Chain *c, const Linkage *t, real dt)
{
    for (int parts = parts_of(c, t, dt); parts <= PARTS_MOST; parts *= 2) {
        bool done = true;
        c->h = dt / parts;
        for (int i = 0; i < parts && done; i++) {
            begin(c, t, i * c->h);
            done = tree_step(c, t);
        }
        if (!done) {
            c->g->refused++;
            continue;
        }
        c->g->substeps = int_max(c->g->substeps, parts);
        c->g->joint_error = real_max(c->g->joint_error, c->error);
        return true;
    }
    return false;
}

/* ---- what is kept ---- */

static void close_link(Group *g, const Link *l)
{
    Member *m = &g->member[l->body];
    m->start_pos = g->pos[l->body];
    m->start_vel = g->vel[l->body];
    m->constrained = m->constrained || l->ends > 0;
    g->pos[l->body] = (Pos){l->x, l->q};
    g->vel[l->body] = (Vel){l->v, mat3_mul_vec(l->r, l->w)};
    group_refresh_mass(g, l->body);
}

static void close_tie(const Chain *c, const Tie *t)
{
    Group *g = c->g;
    GroupJoint *j = &g->joints[t->joint];
    j->impulse = t->impulse;
    j->angular_impulse = t->twist[0];
    vec3 force = vec3_scale(1 / t->h, quat_unrotate(frame_of(c, t), t->p));
    memset(j->force, 0, sizeof j->force);
    j->force[0] = force.x;
    j->force[1] = force.y;
    j->force[2] = force.z;
    for (int side = 0; side < 2; side++) {
        int body = side ? j->b : j->a;
        if (body >= 0 && g->member[body].kinematic)
            g->work_in -= (side ? -1 : 1) * vec3_dot(t->impulse, g->vel[body].v) + vec3_dot(t->twist[side], g->vel[body].w);
    }
}

/* J  By forces, since the start of the step. */
static real work_of(Group *g, real dt)
{
    real work = 0;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves)
            work += vec3_dot(g->member[i].force, vec3_sub(g->pos[i].x, g->member[i].start_pos.x)) +
                    0.5 * dt * vec3_dot(g->member[i].torque, vec3_add(g->vel[i].w, g->member[i].start_vel.w));
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        vec3 turn = vec3_scale(0.5 * dt, vec3_add(g->vel[p->body].w, g->member[p->body].start_vel.w));
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        vec3 way = vec3_sub(g->pos[p->body].x, g->member[p->body].start_pos.x);
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
typedef struct Saved { GroupContact *contacts; ContactPoint *places; GroupPair *pairs; } Saved;

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

/* why: what was tried in vain; NULL: nothing was tried. */
static dig_status hand_on(Group *g, const Saved *s, const char *why)
{
    if (g->pair_count > 0)
        memcpy(g->pairs, s->pairs, (size_t)g->pair_count * sizeof *s->pairs);
    if (g->contact_count > 0)
        memcpy(g->contacts, s->contacts, (size_t)g->contact_count * sizeof *s->contacts);
    if (g->place_count > 0)
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
static void move_bodies(const Chain *c, real dt)
{
    Group *g = c->g;
    for (int i = g->moving_count; i < g->body_count; i++) {
        g->member[i].start_pos = g->pos[i];
        if (g->member[i].kinematic)
            g->pos[i] = fixed_pose(g, i, dt);
    }
    for (int i = 0; i < c->links; i++)
        close_link(g, &c->link[i]);
}

static void undo(Group *g)
{
    for (int i = 0; i < g->body_count; i++) {
        if (g->member[i].moves || g->member[i].kinematic)
            g->pos[i] = g->member[i].start_pos;
        if (g->member[i].moves)
            g->vel[i] = g->member[i].start_vel;
        group_refresh_mass(g, i);
    }
}

/* Nothing touches: what touches next is a blow. */
static void forget_contacts(Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < g->contacts[i].manifold.count; k++) {
            PointMemory *m = &g->contacts[i].memory[k];
            m->normal = 0;
            m->held = 0;
            m->tangent = vec3_zero();
        }
}

static dig_status finish(const Chain *c, const Saved *s, real dt)
{
    Group *g = c->g;
    real before = group_kinetic(g), given = g->work_in;
    move_bodies(c, dt);
    if (g->pair_count > 0) {
        group_touch(g, dt / g->plan->substeps, true);
        if (group_deep(g)) {
            undo(g);
            return hand_on(g, s, NULL);
        }
    }
    for (int i = 0; i < c->ties; i++)
        close_tie(c, &c->tie[i]);
    given = g->work_in - given;
    g->lost += before + given + work_of(g, dt) - group_kinetic(g);
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        group_book_apart(g, i, vec3_sub(g->pos[i].x, m->start_pos.x), vec3_scale(0.5 * dt, vec3_add(g->vel[i].w, m->start_vel.w)), dt);
    }
    g->t = dt;
    g->close_speed = group_close_speed(g);
    forget_contacts(g);
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    return g->status;
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
    DIG_TRY(tree_make(&c, &fits));
    if (!fits)
        return hand_on(g, &saved, NULL);
    DIG_TRY(apply_forces(g, dt));
    for (int i = 0; i < c.trees; i++)
        if (!advance_tree(&c, &c.tree[i], dt))
            return hand_on(g, &saved, "chain: no solution");
    return finish(&c, &saved, dt);
}

const Way way_chain = {.name = "chain", .tally = WAY_SWEPT, .suits = suits, .advance = advance};
