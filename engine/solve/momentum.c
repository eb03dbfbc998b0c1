/* solve/momentum.c - what hangs on nothing keeps its momentum and its angular momentum, whatever a solve leaves undone.
 *
 * Impulses come in pairs, and so do their torques, but for what a substep's turns, a solve that stops at its tolerance, and positions
 * that are put right leave: after a frame in which only joints, contacts and an even field acted, all of a floating mechanism is
 * given the motion of one rigid body that it lacks. That changes no velocity of one part against another: joints and contacts hold as
 * before.
 */
#include "base/forest.h"
#include "solve/momentum.h"

#define LARGEST 1e-2            /* of the momenta in the sum: more than a solve leaves, and not made good */
#define TURNING 3e-2            /* the same of angular ones: chains of eight that whirl by 0.4 rad in a frame lose 1.2 hundredths in it at "sketch" */

/* kg m^2/s  About a point that moves with the velocity v. */
static vec3 turning(const Member *m, const Pos *pos, const Vel *vel, vec3 at, vec3 v)
{
    vec3 own = quat_rotate(pos->q, mat3_mul_vec(*m->inertia, quat_unrotate(pos->q, vel->w)));
    return vec3_mad(own, m->mass, vec3_cross(vec3_sub(pos->x, at), vec3_sub(vel->v, v)));
}

void rigid_motion(const Group *g, const int *root, int which, Rigid *out)
{
    *out = (Rigid){.inertia = mat3_zero()};
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        out->mass += g->member[i].mass;
        out->at = vec3_mad(out->at, g->member[i].mass, g->pos[i].x);
        out->v = vec3_mad(out->v, g->member[i].mass, g->vel[i].v);
    }
    out->at = vec3_scale(1 / out->mass, out->at);
    out->v = vec3_scale(1 / out->mass, out->v);
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        const Member *m = &g->member[i];
        mat3 turn = quat_matrix(g->pos[i].q), skew = mat3_skew(vec3_sub(g->pos[i].x, out->at));
        out->l = vec3_add(out->l, turning(m, &g->pos[i], &g->vel[i], out->at, out->v));
        out->inertia = mat3_add(out->inertia, mat3_mul(turn, mat3_mul(*m->inertia, mat3_transpose(turn))));
        out->inertia = mat3_sub(out->inertia, mat3_scale(m->mass, mat3_mul(skew, skew)));
    }
    out->w = mat3_mul_vec(mat3_inverse(out->inertia), out->l);
}

/* Does everything pull at its parts alike? */
static bool pulled_alike(const Group *g, const int *root, int which, vec3 *pull)
{
    *pull = vec3_scale(g->mass[which].im, g->member[which].force);
    for (int i = which; i < g->moving_count; i++) {
        vec3 own = vec3_scale(g->mass[i].im, g->member[i].force);
        if (root[i] == which && (!vec3_equal(own, *pull) || vec3_length2(g->member[i].torque) > 0))
            return false;
    }
    return true;
}

/* As it was at the start of the frame: its centre of mass, the velocity of that, angular momentum about it, and from how much each of
 * these two is summed. */
typedef struct Before { vec3 at, v, l; real speed, turns; } Before;

static Before before(const Group *g, const int *root, int which)
{
    Before b = {.speed = 0};
    real mass = 0;
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        const Body *was = &g->world->bodies.data[g->member[i].slot];
        mass += g->member[i].mass;
        b.at = vec3_mad(b.at, g->member[i].mass, was->x);
        b.v = vec3_mad(b.v, g->member[i].mass, was->v);
        b.speed += g->member[i].mass * vec3_length(was->v);
    }
    b.at = vec3_scale(1 / mass, b.at);
    b.v = vec3_scale(1 / mass, b.v);
    b.speed /= mass;
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        const Body *was = &g->world->bodies.data[g->member[i].slot];
        real outer = g->member[i].outer, speed = vec3_distance(was->v, b.v) + outer * vec3_length(was->w);
        b.l = vec3_add(b.l, turning(&g->member[i], &(Pos){was->x, was->q}, &(Vel){was->v, was->w}, b.at, b.v));
        b.turns += g->member[i].mass * (vec3_distance(was->x, b.at) + outer) * speed;
    }
    return b;
}

static void add_motion(Group *g, const int *root, int which, Rigid *r, vec3 v, vec3 w)
{
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        g->vel[i].v = vec3_add(g->vel[i].v, vec3_add(v, vec3_cross(w, vec3_sub(g->pos[i].x, r->at))));
        g->vel[i].w = vec3_add(g->vel[i].w, w);
    }
    r->v = vec3_add(r->v, v);
    r->w = vec3_add(r->w, w);
}

static void hold_turning(Group *g, const int *root, int which, const Before *b, real most, Rigid *r)
{
    vec3 off = vec3_sub(b->l, r->l);
    if (vec3_length(off) <= most * b->turns)
        add_motion(g, root, which, r, vec3_zero(), mat3_mul_vec(mat3_inverse(r->inertia), off));
}

void rigid_hold_turning(Group *g, const int *root, int which, real most, Rigid *r)
{
    vec3 pull;
    if (!pulled_alike(g, root, which, &pull))
        return;
    Before b = before(g, root, which);
    hold_turning(g, root, which, &b, most, r);
}

/* Overlaps that are put right by equal shares, and substeps that move bodies by other velocities, leave the straight line a little:
 * about any point but the centre itself, that is angular momentum. */
static void hold_course(Group *g, const int *root, int which, const Before *b, real dt, const Rigid *r)
{
    vec3 off = vec3_sub(vec3_mad(b->at, dt, b->v), r->at);
    if (vec3_length(off) > LARGEST * dt * b->speed)
        return;
    for (int i = which; i < g->moving_count; i++)
        if (root[i] == which)
            g->pos[i].x = vec3_add(g->pos[i].x, off);
}

static void hold_both(Group *g, const int *root, int which, real dt)
{
    vec3 pull;
    Rigid r;
    if (!pulled_alike(g, root, which, &pull))
        return;
    rigid_motion(g, root, which, &r);
    Before b = before(g, root, which);
    vec3 off = vec3_sub(vec3_mad(b.v, dt, pull), r.v);
    if (vec3_length(off) <= LARGEST * (b.speed + dt * vec3_length(pull)))
        add_motion(g, root, which, &r, off, vec3_zero());
    hold_turning(g, root, which, &b, TURNING, &r);
    if (vec3_is_zero(pull))
        hold_course(g, root, which, &b, dt, &r);
}

/* J  Of body i, were its motion that. */
static real motion_energy(const Group *g, int i, const Vel *vel)
{
    const Member *m = &g->member[i];
    vec3 w = quat_unrotate(g->pos[i].q, vel->w);
    return 0.5 * (m->mass * vec3_length2(vel->v) + vec3_dot(w, mat3_mul_vec(*m->inertia, w)));
}

real mechanism_kinetic(const Group *g, const int *root, int which)
{
    real sum = 0;
    for (int i = which; i < g->moving_count; i++)
        if (root[i] == which)
            sum += motion_energy(g, i, &g->vel[i]);
    return sum;
}

/* Of body i, as part of that rigid one. */
static Vel carried(const Group *g, int i, const Rigid *r)
{
    return (Vel){vec3_add(r->v, vec3_cross(r->w, vec3_sub(g->pos[i].x, r->at))), r->w};
}

bool mechanism_hold_kinetic(Group *g, const int *root, int which, bool floats, real kinetic, real most)
{
    Rigid rigid = {.mass = 0};
    real own = 0, gone = kinetic - mechanism_kinetic(g, root, which);
    if (floats)
        rigid_motion(g, root, which, &rigid);
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        Vel by = carried(g, i, &rigid);
        own += motion_energy(g, i, &(Vel){vec3_sub(g->vel[i].v, by.v), vec3_sub(g->vel[i].w, by.w)});
    }
    if (!(fabs(gone) <= most * own))
        return false;
    real scale = own > 0 ? sqrt(1 + gone / own) : 1;
    for (int i = which; i < g->moving_count; i++) {
        if (root[i] != which)
            continue;
        Vel by = carried(g, i, &rigid);
        g->vel[i] = (Vel){vec3_mad(by.v, scale, vec3_sub(g->vel[i].v, by.v)), vec3_mad(by.w, scale, vec3_sub(g->vel[i].w, by.w))};
    }
    return true;
}

bool group_isolated(const Group *g)
{
    bool even = g->push_count == 0 && g->world->region_count == 0 && !g->varies;
    return g->joint_count + g->contact_count > 0 && even && !g->own && !g->drags && !g->rules && !g->planar;
}

static void tie(const Group *g, int *root, uint8_t *ties, int a, int b)
{
    bool one = a >= 0 && g->member[a].moves, other = b >= 0 && g->member[b].moves;
    if (one && other) {
        forest_unite(root, a, b);
        ties[a] |= MECHANISM_TIED;
    } else if (one || other) {
        ties[one ? a : b] |= MECHANISM_HELD;
    }
}

/* What joints hold together, and what pressed on each other in the frame. */
void group_mechanisms(const Group *g, int *root, uint8_t *ties)
{
    for (int i = 0; i < g->moving_count; i++)
        root[i] = i;
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        tie(g, root, ties, j->a, j->b);
        for (int k = 0; k < 2; k++) {           /* gears and racks act on the bodies of those that they couple, too */
            const GroupJoint *other = j->other[k] >= 0 ? &g->joints[j->other[k]] : j;
            tie(g, root, ties, j->a, other->a);
            tie(g, root, ties, j->a, other->b);
        }
    }
    for (int i = 0; i < g->contact_count; i++)
        if (!vec3_is_zero(g->acted[i].impulse))
            tie(g, root, ties, g->contacts[i].a, g->contacts[i].b);
    for (int i = 0; i < g->moving_count; i++) {
        root[i] = forest_root(root, i);
        ties[root[i]] |= ties[i];
    }
}

dig_status group_hold_momenta(Group *g, real dt)
{
    if (!group_isolated(g))
        return DIG_OK;
    ArenaMark mark = arena_mark(g->arena);
    size_t n = (size_t)g->moving_count;
    int *root = arena_alloc(g->arena, (n + 1) * sizeof *root);
    uint8_t *ties = arena_zero(g->arena, n + 1);
    if (!root || !ties)
        return DIG_E_MEMORY;
    group_mechanisms(g, root, ties);
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && root[i] == i && ties[i] == MECHANISM_TIED)      /* one alone does what its integrator does */
            hold_both(g, root, i, dt);
    arena_rewind(g->arena, mark);
    return DIG_OK;
}
