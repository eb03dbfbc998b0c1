/* crowd/bodies.c - bodies to scaled coordinates and back.
 *
 * u = v / root with root = 1/sqrt(m), and w = S s with S = R C, C C^T the body's inverse inertia (Cholesky). In u and s the kinetic
 * energy is half the sum of squares, and an impulse p along a row with Jacobian J changes them by p J^T.
 */
#include "crowd/system.h"

/* Lower root of a symmetric positive matrix; what does not turn about an axis has a zero there. */
static mat3 root_of(mat3 m)
{
    real l00 = sqrt(real_max(0, m.r0.x)), i0 = l00 > 0 ? 1 / l00 : 0;
    real l10 = m.r1.x * i0, l20 = m.r2.x * i0;
    real l11 = sqrt(real_max(0, m.r1.y - l10 * l10)), i1 = l11 > 0 ? 1 / l11 : 0;
    real l21 = (m.r2.y - l20 * l10) * i1, l22 = sqrt(real_max(0, m.r2.z - l20 * l20 - l21 * l21));
    return (mat3){{l00, 0, 0}, {l10, l11, 0}, {l20, l21, l22}};
}

static mat3 spin_root(const Member *m, quat q)
{
    if (m->round)
        return mat3_diagonal((vec3){sqrt(m->inv_inertia->r0.x), sqrt(m->inv_inertia->r0.x), sqrt(m->inv_inertia->r0.x)});
    return mat3_mul(quat_matrix(q), root_of(*m->inv_inertia));
}

mat3 body_axes(const Crowd *c, int body) { return spin_root(&c->g->member[body], c->g->pos[body].q); }

static vec3 momentum_of(const Member *m, quat q, vec3 w) { return quat_rotate(q, mat3_mul_vec(*m->inertia, quat_unrotate(q, w))); }
static vec3 spin_of(const Member *m, quat q, vec3 l) { return quat_rotate(q, mat3_mul_vec(*m->inv_inertia, quat_unrotate(q, l))); }

/* J  l: of its spin. */
static real kinetic_of(const Member *m, Vel v, vec3 l) { return 0.5 * m->mass * vec3_length2(v.v) + 0.5 * vec3_dot(v.w, l); }

static Six six_of(vec3 linear, vec3 angular)
{
    return (Six){{(float)linear.x, (float)linear.y, (float)linear.z, (float)angular.x, (float)angular.y, (float)angular.z}};
}

static void open_still(Crowd *c, int i)
{
    c->vel[i] = c->move[i] = c->start[i] = c->last[i] = c->push[i] = c->axes[0][i] = c->axes[1][i] = (Six){{0}};
}

/* J  Its kinetic energy. */
static real open_body(Crowd *c, int i)
{
    Group *g = c->g;
    Member *m = &g->member[i];
    Frame *f = &c->frame[i];
    if (g->start_pos)
        g->start_pos[i] = g->pos[i];
    *f = (Frame){.root = 0};
    if (!m->moves) {
        open_still(c, i);
        return 0;
    }
    *f = (Frame){.root = sqrt(m->im)};
    mat3 axes = body_axes(c, i);
    const mat3 *s = &axes;
    c->axes[0][i] = (Six){{(float)s->r0.x, (float)s->r1.x, (float)s->r2.x, (float)s->r0.y,
                           (float)s->r1.y, (float)s->r2.y, (float)s->r0.z, (float)s->r1.z}};
    c->axes[1][i] = (Six){{(float)s->r2.z, (float)f->root}};
    vec3 l = momentum_of(m, g->pos[i].q, g->vel[i].w);
    c->vel[i] = six_of(vec3_scale(1 / f->root, g->vel[i].v), mat3_mul_vec(mat3_transpose(*s), l));      /* S^T I w = S^-1 w */
    c->move[i] = (Six){{0}};
    c->last[i] = c->start[i] = c->vel[i];
    vec3 torque = vec3_length2(m->torque) > 0 ? mat3_mul_vec(mat3_transpose(*s), m->torque) : vec3_zero();
    c->push[i] = six_of(vec3_scale((real)c->h * f->root, m->force), vec3_scale((real)c->h, torque));
    return kinetic_of(m, g->vel[i], l);
}

/* Threads share blocks of bodies, not bodies: their sums are then the same for any number of threads. */
#define BLOCK 64

static int block_end(const Crowd *c, int block) { return int_min((block + 1) * BLOCK, c->bodies); }

static void open_share(void *context, int thread, int threads)
{
    Crowd *c = context;
    for (int b = team_first(c->blocks, thread, threads), end = team_end(c->blocks, thread, threads); b < end; b++) {
        c->lost[b] = 0;
        for (int i = b * BLOCK; i < block_end(c, b); i++)
            c->lost[b] += open_body(c, i);
    }
}

dig_status bodies_open(Crowd *c)
{
    Group *g = c->g;
    int threads = g->team ? g->team->threads : 1;
    size_t n = (size_t)crowd_spare(c, threads);
    Six *six = spare_take(&g->spare, g->lasting, 4 * n * sizeof *six);         /* in pieces, for what is spare is */
    c->vel = spare_take(&g->spare, g->lasting, n * sizeof *six);
    c->move = spare_take(&g->spare, g->lasting, n * sizeof *six);
    c->start = spare_take(&g->spare, g->lasting, n * sizeof *six);
    c->frame = spare_take(&g->spare, g->lasting, n * sizeof *c->frame);
    c->blocks = (c->bodies + BLOCK - 1) / BLOCK;
    c->lost = arena_alloc(g->lasting, 2 * (size_t)c->blocks * sizeof *c->lost);
    c->farthest = c->lost + c->blocks;
    c->others = arena_alloc(g->lasting, (size_t)(g->body_count - c->bodies) * sizeof *c->others);
    if (!six || !c->vel || !c->move || !c->start || !c->frame || !c->lost || !c->others)
        return DIG_E_MEMORY;
    c->last = six;
    c->push = six + n;
    c->axes[0] = six + 2 * n;
    c->axes[1] = six + 3 * n;
    c->carriage = (Carriage *)(void *)c->last;
    _Static_assert(sizeof *c->carriage <= 4 * sizeof *six, "there is room for a carriage in the place of four of them");
    for (int i = c->bodies; i < (int)n; i++)
        open_still(c, i);
    if (g->start_vel)
        memcpy(g->start_vel, g->vel, (size_t)c->bodies * sizeof *g->vel);
    team_deal(g->team, open_share, c);
    return DIG_OK;
}

void bodies_spare(const Crowd *c)
{
    Group *g = c->g;
    size_t n = (size_t)crowd_spare(c, g->team ? g->team->threads : 1);
    spare_add(&g->spare, c->vel, n * sizeof *c->vel);
    spare_add(&g->spare, c->move, n * sizeof *c->move);
    spare_add(&g->spare, c->start, n * sizeof *c->start);
    spare_add(&g->spare, c->frame, n * sizeof *c->frame);
}

static vec3 change(const Six *now, const Six *before, int at)
{
    return (vec3){(real)now->at[at] - (real)before->at[at], (real)now->at[at + 1] - (real)before->at[at + 1],
                  (real)now->at[at + 2] - (real)before->at[at + 2]};
}

/* By so much has the body turned since the start, where it was at `from`: in world axes. */
static void turn_by(Crowd *c, int i, vec3 from, vec3 angle)
{
    Group *g = c->g;
    quat q = quat_exp(angle), before = g->pos[i].q;
    g->member[i].swerve = angle;
    g->pos[i].q = quat_unit(quat_mul(q, before));
    vec3 to = g->pos[i].x;
    *carriage_of(c, i) = (Carriage){quat_matrix(q), from, to, travel_by(vec3_sub(to, from), before, g->pos[i].q, g->member[i].outer)};
}

/* rad: by so much the middle of the turn may differ from its start, of bodies that are turned in one piece */
#define ASTRAY 0.01

#define GAIN 0.02               /* of a body's energy of spin: its turn may not add more */

/* kg m^2/s  Impulses act along arms as they lie at the start. When a long thin body turns away from them, a part of what turned it across
 * comes to turn it about its own axis, with thousands of times the energy. Such an angular momentum is taken a part of the way to where
 * it would be had it turned with the body, where its energy is that of before: so far that nothing is gained. before: twice that energy, J. */
static vec3 without_gain(const Member *m, vec3 l, vec3 turned, quat q, real before)
{
    real gain = vec3_dot(l, spin_of(m, q, l)) - before;
    if (!(gain > GAIN * before))
        return l;
    vec3 d = vec3_sub(turned, l);
    real part = gain / real_max(gain, vec3_dot(d, spin_of(m, q, d)));     /* the smaller root of what is left */
    return vec3_mad(l, part, d);
}

/* The angular momentum stays, but for that, and is returned. A body that turns far meanwhile does so with the spin that belongs to the middle of its turn;
 * and what is long and thin, whose spin changes much more than its axis in that time, piece by piece. */
static vec3 turn(Crowd *c, int i, vec3 from, vec3 angle)
{
    Group *g = c->g;
    const Member *m = &g->member[i];
    quat q = g->pos[i].q;
    if (m->round) {
        turn_by(c, i, from, angle);
        return mat3_mul_vec(*m->inertia, g->vel[i].w);
    }
    vec3 w = g->vel[i].w, l = momentum_of(m, q, w);
    if (vec3_length2(angle) > 1e-6) {
        quat middle = quat_unit(quat_mul(quat_exp(vec3_scale(0.5, angle)), q));
        vec3 off = vec3_scale(c->dt, vec3_sub(spin_of(m, middle, l), w));
        if (vec3_length2(off) < ASTRAY * ASTRAY)
            angle = vec3_add(angle, off);
        else
            angle = quat_log(quat_mul(member_turned(m, q, momentum_of(m, q, vec3_scale(1 / c->dt, angle)), c->dt), quat_conjugate(q)));
    }
    turn_by(c, i, from, angle);
    l = without_gain(m, l, quat_rotate(quat_mul(g->pos[i].q, quat_conjugate(q)), l), g->pos[i].q, vec3_dot(w, l));
    g->vel[i].w = spin_of(m, g->pos[i].q, l);
    return l;
}

/* On its parabola, with the exact end of its turn as for others. */
static vec3 fly(Crowd *c, int i)
{
    Group *g = c->g;
    const Member *m = &g->member[i];
    vec3 a = vec3_scale(m->im, m->force);
    g->pos[i].x = vec3_mad(vec3_mad(g->pos[i].x, c->dt, g->vel[i].v), 0.5 * c->dt * c->dt, a);
    g->vel[i].v = vec3_mad(g->vel[i].v, c->dt, a);
    vec3 before = g->vel[i].w;
    g->vel[i].w = vec3_add(before, spin_of(m, g->pos[i].q, vec3_scale(c->dt, m->torque)));
    return vec3_scale(0.5 * c->dt, vec3_add(before, g->vel[i].w));
}

/* J  Its kinetic energy, less what forces gave. */
static real close_body(Crowd *c, int i)
{
    Group *g = c->g;
    const Frame *f = &c->frame[i];
    Member *m = &g->member[i];
    m->constrained = f->held;
    vec3 from = g->pos[i].x, angle;
    if (f->held) {
        mat3 s = body_axes(c, i);
        g->vel[i].v = vec3_mad(g->vel[i].v, f->root, change(&c->vel[i], &c->start[i], 0));
        g->vel[i].w = vec3_add(g->vel[i].w, mat3_mul_vec(s, change(&c->vel[i], &c->start[i], 3)));
        g->pos[i].x = vec3_mad(g->pos[i].x, f->root, (vec3){c->move[i].at[0], c->move[i].at[1], c->move[i].at[2]});
        angle = mat3_mul_vec(s, (vec3){c->move[i].at[3], c->move[i].at[4], c->move[i].at[5]});
    } else {
        angle = fly(c, i);
    }
    vec3 l = turn(c, i, from, angle);
    return kinetic_of(m, g->vel[i], l) - vec3_dot(m->force, vec3_sub(g->pos[i].x, from)) - vec3_dot(m->torque, m->swerve);
}

static void close_share(void *context, int thread, int threads)
{
    Crowd *c = context;
    for (int b = team_first(c->blocks, thread, threads), end = team_end(c->blocks, thread, threads); b < end; b++) {
        c->farthest[b] = 0;
        for (int i = b * BLOCK; i < block_end(c, b); i++) {
            if (!c->trait[i].moves)
                continue;
            c->lost[b] -= close_body(c, i);
            c->farthest[b] = real_max(c->farthest[b], carriage_of(c, i)->way);
        }
    }
}

void bodies_close(Crowd *c)
{
    Group *g = c->g;
    team_deal(g->team, close_share, c);
    for (int i = c->bodies; i < g->body_count; i++) {
        if (!g->member[i].kinematic)
            continue;
        vec3 from = g->pos[i].x;
        g->pos[i].x = vec3_mad(from, c->dt, g->vel[i].v);
        turn_by(c, i, from, vec3_scale(c->dt, g->vel[i].w));
    }
}

real bodies_farthest(const Crowd *c)
{
    real way = 0;
    for (int b = 0; b < c->blocks; b++)
        way = real_max(way, c->farthest[b]);
    return way;
}

/* Its spin turns back with it, and keeps its energy; forces did no work on the way it did not go. */
void body_hold_back(Crowd *c, int body, real part, vec3 carried)
{
    Group *g = c->g;
    const Member *m = &g->member[body];
    const Carriage *k = carriage_of(c, body);
    vec3 from = k->from, less = vec3_mad(carried, part - 1, vec3_sub(k->to, from));
    vec3 turned = vec3_scale(part, m->swerve), unturned = vec3_sub(turned, m->swerve);
    c->lost[body / BLOCK] += vec3_dot(m->force, less) + vec3_dot(m->torque, unturned);
    g->vel[body].w = quat_rotate(quat_exp(unturned), g->vel[body].w);
    g->pos[body].q = quat_mul(quat_exp(vec3_scale(-1, m->swerve)), g->pos[body].q);
    g->pos[body].x = vec3_add(g->pos[body].x, less);
    turn_by(c, body, from, turned);
}
