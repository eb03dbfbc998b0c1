/* solve/medium.c - what a fluid does to a solid that moves through it: drag. */
#include "solve/medium.h"

#include "geom/wet.h"

/* Integral of k |u| over the time h. Along a line, u' = a - k |u| u is Riccati's equation: with k u = y'/y it is y'' = a k y, and
 * the integral is the logarithm of y = cosh s + k u h sinh(s) / s, s = h sqrt(a k). It ends at the terminal speed exactly and
 * passes it for no k and h. What slows down has a < 0, and the first terms of the series do: only their error matters, and y > 1. */
static real damping_of(real k, real speed, real gain, real h)
{
    real x = k * speed * h, s2 = k * gain * h * h;
    if (s2 < 1e-8)
        return log1p(real_max(0.5 * x, x + 0.5 * s2));
    real s = sqrt(s2), x_s = x / s;
    return s + log(0.5 * (1 + x_s) + 0.5 * (1 - x_s) * exp(-2 * s));
}

/* With the mean rate C / h of damping, u' = a - (C / h) u has the mean (1 - e^-C) / h u + (1 - (1 - e^-C) / C) a. */
vec3 medium_slowing(vec3 u, vec3 a, real k, real c, real h)
{
    vec3 pull = vec3_mad(a, -c, u);
    real speed = vec3_length(u), gain = (vec3_length(vec3_mad(u, h, pull)) - speed) / h;
    real C = damping_of(k, speed, gain, h) + c * h;
    if (!(C > 0))
        return vec3_zero();
    real gone = -expm1(-C);
    return vec3_scale(-1, vec3_mad(vec3_scale(gone / h, u), C < 1e-6 ? 0.5 * C : 1 - gone / C, a));
}

void medium_area(const World *w, uint32_t body, quat q, vec3 along, real *area, real *drag)
{
    *area = *drag = 0;
    for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        real shown = shape_shadow(&solid->shape, quat_unrotate(quat_mul(q, solid->at.q), along));
        *area += shown;
        *drag += solid->shape.type->drag * shown;
    }
}

/* The spin about each axis is resisted as that of a box of the same inertia: -rho c / 64 d_i (d_j^4 + d_k^4) |w_i| w_i, from the
 * pressure of 1/2 rho c v^2 on its faces (Todorov, Erez & Tassa 2012). */
static vec3 spin_resistance(const Body *b, vec3 w, real density, real c, real damping, real h)
{
    real i[3] = {b->inertia.r0.x, b->inertia.r1.y, b->inertia.r2.z}, d2[3], rate[3] = {w.x, w.y, w.z};
    for (int k = 0; k < 3; k++)
        d2[k] = real_max(0, 6 / b->mass * (i[(k + 1) % 3] + i[(k + 2) % 3] - i[k]));
    for (int k = 0; k < 3; k++) {
        real one = d2[(k + 1) % 3], two = d2[(k + 2) % 3], factor = density * c / 64 * sqrt(d2[k]) * (one * one + two * two);
        rate[k] *= i[k] / h * expm1(-log1p(factor / i[k] * fabs(rate[k]) * h) - damping * h);
    }
    return (vec3){rate[0], rate[1], rate[2]};
}

void medium_drag(Group *g, int body, const Medium *m, const DragBody *own, real share, real displaced, vec3 arm)
{
    Member *to = &g->member[body];
    const Body *b = &g->world->bodies.data[to->slot];
    vec3 u = vec3_sub(vec3_add(g->vel[body].v, vec3_cross(g->vel[body].w, arm)), m->flow);
    vec3 along = vec3_unit_or(u, (vec3){0, 1, 0}), lever = vec3_cross(arm, along);
    real area, drag;
    medium_area(g->world, to->slot, g->pos[body].q, along, &area, &drag);
    real c = own && !isnan(own->coefficient) ? own->coefficient : area > 0 ? drag / area : 0;
    area = own && own->area > 0 ? own->area : area;
    real mobility = g->mass[body].im + vec3_dot(lever, mat3_mul_vec(g->mass[body].ii, lever));
    real damping = m->damping * displaced, h = g->h;
    vec3 a = vec3_scale(g->mass[body].im, to->force);
    vec3 force = vec3_scale(1 / mobility, medium_slowing(u, a, 0.5 * m->density * c * area * share * mobility, damping * mobility, h));
    vec3 spin = quat_unrotate(g->pos[body].q, g->vel[body].w);
    vec3 brake = quat_rotate(g->pos[body].q, spin_resistance(b, spin, m->density * share, c, damping / b->mass, h));
    vec3 torque = vec3_add(vec3_cross(arm, force), brake);
    to->force = vec3_add(to->force, force);
    to->torque = vec3_add(to->torque, torque);
    to->drag = vec3_add(to->drag, force);
    to->drag_torque = vec3_add(to->drag_torque, torque);
    to->driven += vec3_dot(force, m->flow);
    g->drags = true;
}
