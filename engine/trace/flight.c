/* trace/flight.c - free flight: a body that nothing holds and nothing can meet in this step.
 *
 * The centre of mass follows its parabola exactly. The angular momentum L does not change, and the orientation obeys
 * q' = q w / 2 with w = I^-1 R^T L in body axes: integrated by the fifth-order formula of Dormand & Prince (1980), in parts small enough
 * for the group's tolerance. A round body turns evenly.
 */
#include "trace/trace.h"

static bool suits(const Group *g)
{
    if (g->joint_count > 0 || g->push_count > 0 || g->world->region_count > 0 || g->varies || g->decay_friction)
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (!g->member[i].moves || g->member[i].integrator != DIG_AUTO)
            return false;
    return g->pair_count == 0;
}

static quat mad(quat a, real s, quat b) { return (quat){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z, a.w + s * b.w}; }

static quat rate(const Member *m, quat q, vec3 l)
{
    vec3 w = vec3_scale(0.5, mat3_mul_vec(m->inv_inertia, quat_unrotate(quat_unit(q), l)));         /* half of it, in body axes */
    return quat_mul(q, (quat){w.x, w.y, w.z, 0});
}

static quat turn(const Member *m, quat q, vec3 l, real h)
{
    quat k[6];
    for (int s = 0; s < 6; s++) {
        quat y = q;
        for (int i = 0; i < s; i++)
            y = mad(y, h * dormand_prince[s][i], k[i]);
        k[s] = rate(m, y, l);
    }
    for (int i = 0; i < 6; i++)
        q = mad(q, h * dormand_prince[6][i], k[i]);
    return quat_unit(q);
}

/* For a turn by so many rad. The local error of a part is about a hundredth of the fifth power of its angle. */
static int parts_of(real angle, real tolerance)
{
    real part = angle / 0.8;
    if (part * part * part * part * part <= tolerance)
        return 1;
    return (int)real_clamp(ceil(part / pow(tolerance, 0.2)), 1, 1000);
}

static void fly(Group *g, int i, real h)
{
    const Member *m = &g->member[i];
    vec3 a = vec3_scale(g->mass[i].im, m->force), none = vec3_zero();
    dir_mask(g, &a, &none);
    g->pos[i].x = vec3_mad(vec3_mad(g->pos[i].x, h, g->vel[i].v), 0.5 * h * h, a);
    g->vel[i].v = vec3_mad(g->vel[i].v, h, a);
    vec3 w = g->vel[i].w;
    if (m->round || g->planar) {
        g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(h, w)), g->pos[i].q));
        return;
    }
    quat q = g->pos[i].q;
    vec3 l = quat_rotate(q, mat3_mul_vec(m->inertia, quat_unrotate(q, w)));
    int parts = parts_of(vec3_length(w) * h, g->tolerance);
    for (int k = 0; k < parts; k++)
        q = turn(m, q, l, h / parts);
    g->pos[i].q = q;
    group_refresh_mass(g, i);
    w = quat_rotate(q, mat3_mul_vec(m->inv_inertia, quat_unrotate(q, l)));
    /* refined once: |q| is 1 within rounding only, and that bias would add up to a drift of the angular momentum */
    vec3 off = vec3_sub(l, quat_rotate(q, mat3_mul_vec(m->inertia, quat_unrotate(q, w))));
    g->vel[i].w = vec3_add(w, quat_rotate(q, mat3_mul_vec(m->inv_inertia, quat_unrotate(q, off))));
}

static dig_status advance(Group *g, real dt)
{
    g->h = dt;
    DIG_TRY(group_forces(g));
    for (int i = 0; i < g->moving_count; i++)
        fly(g, i, dt);
    g->evaluations = g->substeps = 1;
    g->t = dt;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_flight = {.name = "flight", .tally = WAY_TRACED, .suits = suits, .advance = advance};
