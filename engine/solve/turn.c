/* solve/turn.c - how bodies turn within a substep. */
#include "math/tumble.h"
#include "solve/group.h"

static vec3 momentum_of(const Member *m, quat q, vec3 w) { return quat_rotate(q, mat3_mul_vec(*m->inertia, quat_unrotate(q, w))); }
static vec3 spin_of(const Member *m, quat q, vec3 l) { return quat_rotate(q, mat3_mul_vec(*m->inv_inertia, quat_unrotate(q, l))); }

#define SWERVE_MOST 0.5         /* of the spin: of turns beyond, the rate at the start says ever less, and grows with the spin squared */

/* 1  Greatest over least moment of inertia, by their traces: of a thin rod, of a ball 4.5. */
static real thinness(const Member *m)
{
    const mat3 *a = m->inertia, *b = m->inv_inertia;
    return 0.5 * (a->r0.x + a->r1.y + a->r2.z) * (b->r0.x + b->r1.y + b->r2.z);
}

#define SWERVE_GROWS 0.25       /* of an error in the spin of a thin body about its own axis: more than all of it would grow from substep to substep */

/* 1  How much of an error e in the spin of a thin body about its axis comes back a substep later. Half a swerve of h w e, which group_turn() takes
 * off the mean but takes off the end whole, leaves the axis h^2 w e / 2 beside the momentum I w across it, of which as much is about the axis,
 * where the inertia is I / ratio. */
static real swerve_grows(const Member *m, real angle) { return 0.5 * thinness(m) * angle * angle; }

/* rad/s  By how much a body that nothing holds turns otherwise at the end of the substep, its angular momentum staying as it is. Joint rows
 * are to know of it: they hold for the mean of the velocities before and after, and group_turn() turns it on so. */
vec3 group_swerve(const Group *g, int i)
{
    const Member *m = &g->member[i];
    vec3 w = g->vel[i].w;
    if (g->joint_count == 0 || m->round || g->planar)
        return vec3_zero();
    vec3 by = vec3_scale(g->h, mat3_mul_vec(g->mass[i].ii, vec3_cross(momentum_of(m, g->pos[i].q, w), w)));
    real most = SWERVE_MOST * vec3_length(w), length = vec3_length(by), grows = swerve_grows(m, vec3_length(w) * g->h);
    if (grows > SWERVE_GROWS)
        by = vec3_scale(SWERVE_GROWS / grows, by);
    return length > most ? vec3_scale(most * most / (length * length), by) : by;
}

/* q' = w q / 2 with constant angular momentum L, classical fourth-order Runge-Kutta. */
static quat turn(const Member *m, quat q, vec3 l, real h)
{
    quat k[4], y = q;
    static const real at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    quat sum = {0, 0, 0, 0};
    for (int i = 0; i < 4; i++) {
        if (i > 0)
            y = (quat){q.x + h * at[i] * k[i - 1].x, q.y + h * at[i] * k[i - 1].y, q.z + h * at[i] * k[i - 1].z, q.w + h * at[i] * k[i - 1].w};
        quat u = quat_unit(y);
        vec3 w = spin_of(m, u, l);
        quat r = quat_mul((quat){w.x, w.y, w.z, 0}, y);
        k[i] = (quat){0.5 * r.x, 0.5 * r.y, 0.5 * r.z, 0.5 * r.w};
        sum = (quat){sum.x + weight[i] * k[i].x, sum.y + weight[i] * k[i].y, sum.z + weight[i] * k[i].z, sum.w + weight[i] * k[i].w};
    }
    return quat_unit((quat){q.x + h * sum.x, q.y + h * sum.y, q.z + h * sum.z, q.w + h * sum.w});
}

#define PART       0.1          /* rad  fast spins are cut into turns of this; */
#define FAR        256          /* from so many on the turn is taken in closed form, */
#define PARTS_MOST 8192         /* or where it has none, in as many at most */

quat member_turned(const Member *m, quat q, vec3 l, real h)
{
    int parts = (int)real_clamp(ceil(vec3_length(spin_of(m, q, l)) * h / PART), 1, PARTS_MOST);
    if (parts > FAR && tumble_far(m->inv_inertia, &q, l, h))
        return q;
    for (int k = 0; k < parts; k++)
        q = turn(m, q, l, h / parts);
    return q;
}

#define WHIRLS 1.0              /* rad */

bool group_whirls(const Group *g, int i)
{
    return g->joint_count == 0 && !g->member[i].round && !g->planar && g->h * vec3_length(g->vel[i].w) > WHIRLS;
}

void group_note_couples(Group *g, bool turned)
{
    if (!g->couples)
        return;
    memset(g->couples, 0, (size_t)g->body_count * sizeof *g->couples);
    for (int i = 0; i < g->row_count && turned; i++) {
        const Row *r = &g->rows[i].row;
        for (int k = 0; k < r->count; k++)
            if (r->body[k] >= 0)
                g->couples[r->body[k]] = vec3_mad(g->couples[r->body[k]], g->rows[i].p, r->ang[k]);
    }
}

/* What bodies that move on by their velocities at the end turn farther than by the mean of their spins, by half of what joints gave them, is
 * no motion but a change of place, and their momentum turns along. Where it stayed, what rows that lie at the middle of the turn gave
 * across a rod would come to lie along it in part, where there is next to no inertia: of momentum L and a couple J of the joints, both across, with
 * an inertia of I, by h (L x J) / 2I. */
static vec3 turned_along(const Group *g, int i, vec3 l)
{
    if (!g->couples || !g->member[i].implicit_move)
        return l;
    return quat_rotate(quat_exp(vec3_scale(0.5 * g->h, mat3_mul_vec(g->mass[i].ii, g->couples[i]))), l);
}

/* How the body turns in the substep, and with which spin it ends. */
static vec3 turned_to(const Group *g, int i, vec3 mean_w, quat *q)
{
    const Member *m = &g->member[i];
    vec3 end = momentum_of(m, *q, vec3_sub(g->vel[i].w, m->swerve)), mean = momentum_of(m, *q, vec3_mad(mean_w, -0.5, m->swerve));
    if (group_whirls(g, i))
        mean = end;
    *q = member_turned(m, *q, mean, g->h);
    end = turned_along(g, i, end);
    vec3 w = spin_of(m, *q, end);
    /* refined once: |q| is 1 within rounding only, and that bias would add up to a drift of the angular momentum */
    return vec3_add(w, spin_of(m, *q, vec3_sub(end, momentum_of(m, *q, w))));
}

#define THIN 100.0              /* thinness: a rod 14 times as long as thick */
#define SPUN 0.05               /* of its spin */
#define SPUN_LITTLE 1e-3        /* rad in a substep */

/* Do rows give something thin a spin about its axis that they do not know of? Their impulses lie where it will be half way, and what they give is kept
 * where it was, and where it gets to: of momentum across the axis a share that grows with the square of the substep comes to lie along it. */
bool group_spins_off(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves || m->round || g->planar || !m->constrained || thinness(m) < THIN)
            continue;
        quat q = g->pos[i].q;
        vec3 off = vec3_sub(turned_to(g, i, group_way_of(g, i).w, &q), g->vel[i].w);
        if (vec3_length(off) > real_max(SPUN * vec3_length(g->vel[i].w), SPUN_LITTLE / g->h))
            return true;
    }
    return false;
}

/* The angular momentum that the impulses left is kept while the body turns. */
void group_turn(Group *g, int i, vec3 mean_w)
{
    Member *m = &g->member[i];
    if (m->round || g->planar) {
        g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(g->h, mean_w)), g->pos[i].q));
        return;
    }
    g->vel[i].w = turned_to(g, i, mean_w, &g->pos[i].q);
    group_refresh_mass(g, i);
}
