/* solve/grip.c - what movers have closed on, and hold by friction, goes where they take it.
 *
 * No force says how it moves, for between stiff things any pair of opposite forces is one: a solve finds some, with as much friction, from substep to
 * substep other ones; and between jaws that stand it finds none, for nothing presses. So friction bears what it has to: what they have taken hold of
 * they do not let slip. It goes with their mean, to where it is as deep in the one as in the other, and is a mover itself as long: what lies on it,
 * hangs from it or strikes it meets it as it meets the jaws.
 *
 * Movers have closed on something where they came at it until it had no room left, or are deep in it. That is kept by their contacts, until they open.
 * What only fits between those that stand is as free as before. What is in its way, and does not move itself, strips it off for as long.
 */
#include "solve/direction.h"
#include "solve/group.h"

#define HEAL_SPEED 3.0          /* m/s per sqrt(m): as in project.c */
#define SLIPS 1e-6              /* of the size in a step */

static int other_of(const GroupContact *c, int body) { return c->a == body ? c->b : c->a; }

static vec3 arm_of(const Group *g, int by, int body) { return vec3_sub(g->pos[body].x, g->pos[by].x); }

static vec3 velocity_at(const Group *g, int by, vec3 arm) { return vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, arm)); }

/* m  What turns takes it round, not along the tangent: that would let it out of turning jaws by half the square of their turn in each step. */
static vec3 bend(vec3 w, vec3 arm, real dt)
{
    if (vec3_is_zero(w))
        return vec3_zero();
    return vec3_sub(quat_rotate(quat_exp(vec3_scale(dt, w)), arm), vec3_mad(arm, dt, vec3_cross(w, arm)));
}

/* m  By what one of them takes the body along. */
static vec3 way_with(const Group *g, int by, int body, real dt)
{
    vec3 arm = arm_of(g, by, body);
    return vec3_mad(bend(g->vel[by].w, arm, dt), dt, velocity_at(g, by, arm));
}

/* Do they move alike, but for what squeezes? What glides past the other would make it roll, or lets it slip. */
static bool move_alike(const Group *g, const Carried *h, real dt)
{
    const GroupContact *first = &g->contacts[g->jaws[h->first]];
    int lead = other_of(first, h->body);
    vec3 way = way_with(g, lead, h->body, dt), n = first->manifold.normal;
    for (int k = 1; k < h->count; k++) {
        const GroupContact *c = &g->contacts[g->jaws[h->first + k]];
        int by = other_of(c, h->body);
        vec3 off = vec3_sub(way_with(g, by, h->body, dt), way);
        if (fabs(vec3_dot(n, c->manifold.normal)) > 1 - SLIPS)          /* the same, or the other side */
            off = vec3_mad(off, -vec3_dot(n, off), n);
        real size = g->pairs[c->pair].size;
        if (vec3_length(off) + size * dt * vec3_distance(g->vel[by].w, g->vel[lead].w) > SLIPS * size)
            return false;
    }
    return true;
}

/* The mean of them all. */
static Vel mean_of(const Group *g, const Carried *h)
{
    Vel mean = {vec3_zero(), vec3_zero()};
    real share = 1.0 / h->count;
    for (int k = 0; k < h->count; k++) {
        int by = other_of(&g->contacts[g->jaws[h->first + k]], h->body);
        mean = (Vel){vec3_mad(mean.v, share, velocity_at(g, by, arm_of(g, by, h->body))), vec3_mad(mean.w, share, g->vel[by].w)};
    }
    return mean;
}

/* It goes with them from now on, and by `heals` more: of the two sides of the first one's normal. */
static void carry(Group *g, Carried *h, real dt)
{
    const GroupContact *first = &g->contacts[g->jaws[h->first]];
    real depth[2] = {-INFINITY, -INFINITY}, size = INFINITY;
    vec3 n = first->b == h->body ? first->manifold.normal : vec3_neg(first->manifold.normal);
    for (int k = 0; k < h->count; k++) {
        const GroupContact *c = &g->contacts[g->jaws[h->first + k]];
        real side = (c->b == h->body ? 1 : -1) * vec3_dot(n, c->manifold.normal);
        size = real_min(size, g->pairs[c->pair].size);
        if (fabs(side) > 1 - SLIPS)
            depth[side < 0] = real_max(depth[side < 0], contact_depth(c));
    }
    real most = HEAL_SPEED * sqrt(size) * dt;
    h->heals = vec3_scale(real_clamp(0.5 * (depth[0] - depth[1]), -most, most), n);
    h->before = g->vel[h->body];
    g->vel[h->body] = mean_of(g, h);
}

void grip_follow(Group *g, real h)
{
    for (int i = 0; i < g->carried_count; i++) {
        const Carried *c = &g->carried[i];
        vec3 bends = vec3_zero();
        for (int k = 0; k < c->count; k++) {
            int by = other_of(&g->contacts[g->jaws[c->first + k]], c->body);
            vec3 arm = vec3_mad(arm_of(g, by, c->body), -h, vec3_sub(g->vel[c->body].v, g->vel[by].v));      /* before they moved */
            bends = vec3_mad(bends, 1.0 / c->count, bend(g->vel[by].w, arm, h));
        }
        g->pos[c->body].x = vec3_add(g->pos[c->body].x, bends);
    }
}

void grip_lead(Group *g)
{
    for (int i = 0; i < g->carried_count; i++)
        g->vel[g->carried[i].body] = mean_of(g, &g->carried[i]);
}

bool grip_is_jaw(const Group *g, int first, int count, int contact)
{
    for (int k = first; k < first + count; k++)
        if (g->jaws[k] == contact)
            return true;
    return false;
}

/* m  By how much a point of the contact closes in the step, as the body is carried. */
static real closes_by(const Group *g, const Carried *h, const GroupContact *c, const ManifoldPoint *p, real dt)
{
    int by = other_of(c, h->body);
    vec3 v = vec3_add(g->vel[h->body].v, vec3_cross(g->vel[h->body].w, vec3_sub(p->a, g->pos[h->body].x)));
    vec3 u = vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, vec3_sub(p->a, g->pos[by].x)));
    return -(c->b == h->body ? 1 : -1) * vec3_dot(c->manifold.normal, vec3_mad(h->heals, dt, vec3_sub(v, u)));
}

#define AHEAD 0.5               /* cosine: such contacts bear what is pushed this way */
#define NEAR  1e-3              /* of the size: contacts so near bear, and what is so deep in what moves has not been able to push it off */

static bool is_near(const Group *g, const GroupContact *c)
{
    real gap = INFINITY;
    for (int k = 0; c->live && k < c->manifold.count; k++)
        gap = real_min(gap, c->manifold.points[k].gap);
    return gap <= NEAR * g->pairs[c->pair].size;
}

/* Does a body that is pushed along n lie against something that does not move, be it through others? What is carried would crush them. */
static bool is_backed(const Group *g, int body, vec3 n, int carried)
{
    ArenaMark mark = arena_mark(g->arena);
    uint8_t *pushed = arena_zero(g->arena, (size_t)g->body_count);
    bool backed = !pushed, more = !backed;
    if (pushed)
        pushed[body] = pushed[carried] = true;
    while (more && !backed) {
        more = false;
        for (int i = 0; i < g->contact_count && !backed; i++) {
            const GroupContact *c = &g->contacts[i];
            real along = vec3_dot(n, c->manifold.normal);
            int from = along > 0 ? c->a : c->b, to = along > 0 ? c->b : c->a;
            if (fabs(along) < AHEAD || from == carried || !pushed[from] || pushed[to] || !is_near(g, c))
                continue;
            pushed[to] = more = true;
            backed = !g->member[to].moves && !g->member[to].dormant;
        }
    }
    arena_rewind(g->arena, mark);
    return backed;
}

/* Does it go into what does not move, or cannot? A sleeper wakes first. */
static bool in_its_way(Group *g, const Carried *h, real dt)
{
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!c->live || (c->a != h->body && c->b != h->body) || grip_is_jaw(g, h->first, h->count, i))
            continue;
        int other = other_of(c, h->body);
        real size = g->pairs[c->pair].size;
        for (int k = 0; k < c->manifold.count; k++) {
            const ManifoldPoint *p = &c->manifold.points[k];
            if (p->gap - closes_by(g, h, c, p, dt) >= real_min(p->gap, 0) - GRIP_SINKS * size)
                continue;
            if (g->member[other].moves && p->gap > -NEAR * size &&
                !is_backed(g, other, c->b == other ? c->manifold.normal : vec3_neg(c->manifold.normal), h->body))
                continue;
            if (!g->member[other].dormant)
                return true;
            g->member[other].pushed = g->woke = true;
        }
    }
    return false;
}

/* Is it joined to what does not move itself? */
static bool is_tied(const Group *g, int body)
{
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        int other = j->a == body ? j->b : j->b == body ? j->a : body;
        if (other < 0 || !g->member[other].moves)
            return true;
    }
    return false;
}

/* May it go with them? Nothing leaves the plane of its world, nor turns that is made not to. */
static bool is_free_to(const Group *g, int body)
{
    vec3 v = g->vel[body].v, w = g->vel[body].w;
    dir_mask(g, &v, &w);
    if (!body_turns(&g->world->bodies.data[g->member[body].slot]))
        w = vec3_zero();
    return vec3_distance(v, g->vel[body].v) + vec3_distance(w, g->vel[body].w) == 0;
}

/* The contacts that squeeze it; false: one of them is looked at anew, or there are none. */
static bool find_jaws(Group *g, Carried *h)
{
    h->first = g->jaw_count;
    h->count = 0;
    for (int i = g->pressed[h->body]; i >= 0; i = g->squeezed[i].next) {
        if (!is_squeezed(g, i))
            continue;
        if (g->pairs[g->contacts[i].pair].fresh)
            return false;
        g->jaws[h->first + h->count++] = i;
    }
    return h->count >= 2;
}

static void take(Group *g, Carried *h)
{
    Member *m = &g->member[h->body];
    Vel carried = g->vel[h->body];
    g->vel[h->body] = h->before;
    h->kinetic = group_kinetic_of(g, h->body);
    g->vel[h->body] = carried;
    h->from = g->pos[h->body].x;
    h->force = m->force;
    h->torque = m->torque;
    if (g->apart)
        h->apart = g->apart[h->body];
    m->moves = false;
    m->kinematic = true;
    m->im = 0;
    g->mass[h->body] = (Mass){0, mat3_zero()};
    g->jaw_count += h->count;
    g->carried_count++;
}

static bool rubs(const Group *g) { return (g->laws >> LAW_FRICTION & 1) && !g->decay_friction; }

bool grip_possible(const Group *g) { return g->movers && rubs(g) && !g->own && !g->crowd && squeeze_possible(g); }

bool group_grips(const Group *g)
{
    bool any = false;
    for (int i = 0; i < g->contact_count && g->movers && !any; i++)
        any = g->contacts[i].grips;
    return any;
}

static dig_status reserve(Group *g)
{
    g->carried = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *g->carried);
    g->jaws = arena_alloc(g->arena, (size_t)(g->contact_count + 1) * sizeof *g->jaws);
    return g->carried && g->jaws ? DIG_OK : DIG_E_MEMORY;
}

dig_status grip_take(Group *g, real rest, real ahead)
{
    if (ahead > 0 && !rubs(g))
        return DIG_OK;
    if (!g->carried)
        DIG_TRY(reserve(g));
    if (!(ahead > 0)) {
        if (group_grips(g))
            group_touch(g, rest, false);        /* what is new at it, as a joint, has its contacts looked at anew */
        DIG_TRY(squeeze_open(g));
    }
    group_squeeze(g, JAWS_RUB, ahead);
    real h = g->h;
    g->h = rest;
    if (g->squeezes)
        DIG_TRY(group_forces(g));
    for (int i = 0; i < g->moving_count && g->squeezes; i++) {
        Carried *c = &g->carried[g->carried_count];
        *c = (Carried){.body = i, .time = rest};
        if (!g->member[i].moves || g->member[i].integrator != DIG_AUTO || !find_jaws(g, c) || !move_alike(g, c, rest) || is_tied(g, i))
            continue;
        carry(g, c, rest);
        if (!is_free_to(g, i) || in_its_way(g, c, rest))
            g->vel[i] = c->before;
        else
            take(g, c);
    }
    g->h = h;
    g->residual = real_max(g->residual, g->carried_count > 0 ? squeeze_missing(g) : 0);
    g->squeezes = false;
    return DIG_OK;
}

/* It is a body like others again. */
static void free_body(Group *g, int body)
{
    Member *m = &g->member[body];
    const Body *b = &g->world->bodies.data[m->slot];
    m->moves = true;
    m->kinematic = false;
    m->im = b->inv_mass / body_inertness(b);
    g->mass[body].im = m->im;
    group_refresh_mass(g, body);
}

bool grip_let_go(Group *g)
{
    bool any = g->carried_count > 0;
    for (int i = 0; i < g->carried_count; i++) {
        g->vel[g->carried[i].body] = g->carried[i].before;
        free_body(g, g->carried[i].body);
    }
    g->carried_count = g->jaw_count = 0;
    return any;
}

/* What its holders gave it, beside its weight and what pushes it; what it gave on is booked by rows, as of any mover. */
static void book(Group *g, const Carried *h, vec3 turned)
{
    vec3 moved = vec3_sub(g->pos[h->body].x, h->from);
    real gained = group_kinetic_of(g, h->body) - h->kinetic - vec3_dot(h->force, moved) - vec3_dot(h->torque, turned);
    if (g->apart) {
        g->apart[h->body] = h->apart;
        group_book_apart(g, h->body, moved, turned, h->time);
    }
    g->work_in += real_max(0, gained);
    g->lost += real_max(0, -gained);
}

/* N s  What a body got from its contacts and joints in this step. */
static vec3 received(const Group *g, int body)
{
    vec3 sum = vec3_zero();
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (c->a == body || c->b == body)
            sum = vec3_mad(sum, c->b == body ? 1 : -1, contact_acted(g, c)->impulse);
    }
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        if (j->a == body || j->b == body)
            sum = vec3_mad(sum, j->a == body ? 1 : -1, j->impulse);
    }
    return sum;
}

static bool is_carried(const Group *g, int body)
{
    for (int i = 0; i < g->carried_count; i++)
        if (g->carried[i].body == body)
            return true;
    return false;
}

/* How hard movers squeeze nobody can say. What they bear is what moves it as it moves, less what else acts on it: across what squeezes by equal
 * shares of friction, along it by those that push that way. A contact with what is carried itself bears only where there is no other. */
static void bear(Group *g, const Carried *h, bool by_carried)
{
    const GroupContact *first = &g->contacts[g->jaws[h->first]];
    vec3 n = first->manifold.normal, left = vec3_scale(g->member[h->body].mass, vec3_sub(g->vel[h->body].v, h->before.v));
    left = vec3_sub(vec3_mad(left, -h->time, h->force), received(g, h->body));
    vec3 along = vec3_scale(vec3_dot(n, left), n);
    int holders = 0, pushers = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int k = h->first; k < h->first + h->count; k++) {
            GroupContact *c = &g->contacts[g->jaws[k]];
            real side = c->b == h->body ? 1 : -1;
            bool pushes = side * vec3_dot(along, c->manifold.normal) > 0;
            if (!by_carried && is_carried(g, other_of(c, h->body)))
                continue;
            holders += pass == 0;
            pushers += pass == 0 && pushes;
            if (pass == 0)
                continue;
            vec3 share = vec3_scale(1.0 / holders, vec3_sub(left, along));
            share = pushes ? vec3_mad(share, 1.0 / pushers, along) : share;
            Acted *acted = contact_acted(g, c);
            acted->impulse = vec3_mad(acted->impulse, side, share);
        }
}

static bool only_by_carried(const Group *g, const Carried *h)
{
    for (int k = h->first; k < h->first + h->count; k++)
        if (!is_carried(g, other_of(&g->contacts[g->jaws[k]], h->body)))
            return false;
    return true;
}

/* Those first that others carry. */
static void bear_all(Group *g)
{
    for (int carried = 1; carried >= 0; carried--)
        for (int i = 0; i < g->carried_count; i++)
            if (only_by_carried(g, &g->carried[i]) == carried)
                bear(g, &g->carried[i], carried);
}

void grip_give(Group *g)
{
    bear_all(g);
    bool healed = false;
    for (int i = 0; i < g->carried_count; i++) {
        Carried *h = &g->carried[i];
        vec3 turned = vec3_scale(h->time, g->vel[h->body].w);
        g->pos[h->body].x = vec3_add(g->pos[h->body].x, h->heals);
        healed = healed || !vec3_is_zero(h->heals);
        free_body(g, h->body);
        g->member[h->body].constrained = true;
        book(g, h, turned);
    }
    real dt = g->world->def.step;
    if (healed)
        group_touch(g, dt, true);
    for (int i = 0; i < g->jaw_count; i++) {
        GroupContact *c = &g->contacts[g->jaws[i]];
        for (int k = 0; k < c->manifold.count; k++)
            contact_memory(c)[k] = (PointMemory){.held = HELD_SUBSTEPS};
        contact_acted(g, c)->last = dt;
        c->manifold.slides = false;
    }
}

dig_status grip_note(Group *g)
{
    if (!(g->driven || group_grips(g)) || !rubs(g))
        return DIG_OK;
    bool two = g->contact_count > 1;            /* one alone squeezes nothing */
    if (two) {
        DIG_TRY(squeeze_open(g));
        group_squeeze(g, JAWS_RUB, 0);
    }
    for (int i = 0; i < g->contact_count; i++)
        g->contacts[i].grips = two && is_squeezed(g, i);
    g->squeezes = false;
    return DIG_OK;
}
