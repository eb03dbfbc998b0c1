/* solve/medium.c - what a fluid does to a solid that moves through it: drag. */
#include "solve/medium.h"

/* Along a line, u' = a - k |u| u is Riccati's equation: with k u = y'/y it is y'' = a k y, which hyperbolic functions solve where the
 * speed grows, and circular ones where it shrinks, until it turns round. */
typedef struct Line {
    real slowing;               /* m/s^2  mean of -k |u| u over the time               */
    real damping;               /* 1      integral of k |u|                            */
} Line;

/* tanh(s) / s, or tan(s) / s, and 1 minus that. */
typedef struct Ratio { real part, rest; } Ratio;

static Ratio ratio_of(real s, bool grows)
{
    real s2 = grows ? s * s : -s * s;
    if (s < 0.01)
        return (Ratio){1 - s2 / 3 + 2 * s2 * s2 / 15, s2 / 3 - 2 * s2 * s2 / 15};
    real part = (grows ? tanh(s) : tan(s)) / s;
    return (Ratio){part, 1 - part};
}

/* log cosh s, for any s */
static real log_cosh(real s) { return s < 1 ? 0.5 * log1p(sinh(s) * sinh(s)) : s + log1p(exp(-2 * s)) - log(2); }

/* Exactly, for u >= 0. */
static Line line_of(real u, real a, real k, real h)
{
    real rate = sqrt(k * fabs(a)), s = rate * h, x = k * u * h;
    if (!(s > 0))
        return (Line){-k * u * u / (1 + x), log1p(x)};
    real turn = a < 0 ? atan(x / s) : INFINITY;         /* in units of 1 / rate */
    if (turn < s) {
        real after = -sqrt(fabs(a) / k) * tanh(s - turn);
        return (Line){(after - u) / h - a, 0.5 * log1p(x / s * (x / s)) + log_cosh(s - turn)};
    }
    Ratio r = ratio_of(s, a > 0);
    return (Line){-(a * (r.rest + x * r.part) + k * u * u * r.part) / (1 + x * r.part), (a > 0 ? log_cosh(s) : log(cos(s))) + log1p(x * r.part)};
}

/* Along the motion exactly; what turns it is damped at the mean rate of that, and at least as when it starts from rest. So it ends at
 * the terminal speed exactly, passes it for no k and h, and follows a curve to second order. */
static vec3 slowing_of(vec3 u, vec3 a, real k, real h)
{
    real speed = vec3_length(u);
    vec3 along = vec3_unit_or(u, vec3_unit_or(a, (vec3){0, 1, 0}));
    vec3 across = vec3_mad(a, -vec3_dot(a, along), along);
    Line line = line_of(speed, vec3_dot(a, along), k, h);
    real C = line.damping, kept = C < 1e-6 ? 0.5 * C : 1 + expm1(-C) / C;
    Ratio rest = ratio_of(h * sqrt(k * vec3_length(across)), true);
    return vec3_mad(vec3_scale(line.slowing, along), -real_max(kept, rest.rest), across);
}

vec3 medium_slowing(vec3 u, vec3 a, real k, real c, real h)
{
    if (!(c > 0))
        return k > 0 ? slowing_of(u, a, k, h) : vec3_zero();
    vec3 most = k > 0 ? vec3_add(a, slowing_of(u, a, k, h)) : a;
    real C = c * h, gone = -expm1(-C);          /* u' = a - c u has the mean (1 - e^-C) / h u + (1 - (1 - e^-C) / C) a */
    vec3 even = vec3_scale(-1, vec3_mad(vec3_scale(gone / h, u), C < 1e-6 ? 0.5 * C : 1 - gone / C, most));
    return k > 0 ? vec3_add(even, slowing_of(u, vec3_add(a, even), k, h)) : even;
}

void medium_area(const World *w, uint32_t body, quat q, vec3 along, real *area, real *drag)
{
    *area = *drag = 0;
    for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        const ShapeType *type = solid->form->shape.type;
        if (!type->shadow)
            continue;           /* never moves */
        real shown = type->shadow(&solid->form->shape, quat_unrotate(quat_mul(q, solid->form->at.q), along));
        *area += shown;
        *drag += type->drag * shown;
    }
}

/* The spin about each axis is resisted as that of a box of the same inertia: -rho c / 64 d_i (d_j^4 + d_k^4) |w_i| w_i, from the
 * pressure of 1/2 rho c v^2 on its faces (Todorov, Erez & Tassa 2012). */
static vec3 spin_resistance(const Body *b, vec3 w, real density, real c, real damping, real h)
{
    const mat3 *own = &body_inertia(b)->of;
    real i[3] = {own->r0.x, own->r1.y, own->r2.z}, d2[3], rate[3] = {w.x, w.y, w.z};
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
    real mobility = to->im + vec3_dot(lever, mat3_mul_vec(group_inverse_inertia(g, body), lever));
    real damping = m->damping * displaced, h = g->h;
    if (m->viscosity > 0)       /* Stokes 1851 */
        damping += 3 * DIG_PI * m->viscosity * cbrt(6 * displaced / (DIG_PI * m->density));
    vec3 a = vec3_scale(to->im, to->force);
    vec3 force = vec3_scale(1 / mobility, medium_slowing(u, a, 0.5 * m->density * c * area * share * mobility, damping * mobility, h));
    vec3 spin = quat_unrotate(g->pos[body].q, g->vel[body].w);
    vec3 brake = quat_rotate(g->pos[body].q, spin_resistance(b, spin, m->density * share, c, damping / b->mass, h));
    vec3 torque = vec3_add(vec3_cross(arm, force), brake);
    to->force = vec3_add(to->force, force);
    to->torque = vec3_add(to->torque, torque);
    Apart *apart = &g->apart[body];
    apart->drag = vec3_add(apart->drag, force);
    apart->drag_torque = vec3_add(apart->drag_torque, torque);
    apart->driven += vec3_dot(force, m->flow);
    g->drags = true;
}
