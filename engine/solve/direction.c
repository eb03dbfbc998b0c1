/* solve/direction.c - one direction of a contact point: Jacobian, effective mass, impulse. */
#include "solve/direction.h"

static vec3 masked(const Group *g, vec3 v, bool linear)
{
    if (!g->planar)
        return v;
    real *c[3] = {&v.x, &v.y, &v.z};
    for (int i = 0; i < 3; i++)
        if ((i == g->planar - 1) == linear)
            *c[i] = 0;
    return v;
}

void dir_mask(const Group *g, vec3 *linear, vec3 *angular)
{
    *linear = masked(g, *linear, true);
    *angular = masked(g, *angular, false);
}

void dir_make(const Group *g, Dir *d, int a, int b, vec3 n, vec3 ra, vec3 rb)
{
    d->n = masked(g, n, true);
    d->aa = masked(g, vec3_cross(n, ra), false);        /* -(ra x n) */
    d->ab = masked(g, vec3_cross(rb, n), false);
    const Mass *ma = &g->mass[a], *mb = &g->mass[b];
    d->ia = mat3_mul_vec(ma->ii, d->aa);
    d->ib = mat3_mul_vec(mb->ii, d->ab);
    d->k = (ma->im + mb->im) * vec3_dot(d->n, d->n) + vec3_dot(d->aa, d->ia) + vec3_dot(d->ab, d->ib);
}

/* J_1 M^-1 J_2^T of two directions of one point. */
real dir_coupling(const Group *g, const Dir *d, const Dir *e, int a, int b)
{
    return (g->mass[a].im + g->mass[b].im) * vec3_dot(d->n, e->n) + vec3_dot(d->aa, e->ia) + vec3_dot(d->ab, e->ib);
}

/* The three directions of a contact point at `at`, for centres of mass at xa and xb. Tangents follow the normal alone, so that
 * warm starting can be projected. */
void point_row_set(const Group *g, PointRow *r, vec3 normal, vec3 at, vec3 xa, vec3 xb)
{
    vec3 t, u, ra = vec3_sub(at, xa), rb = vec3_sub(at, xb);
    vec3_basis(normal, &t, &u);
    dir_make(g, &r->n, r->a, r->b, normal, ra, rb);
    dir_make(g, &r->t[0], r->a, r->b, t, ra, rb);
    dir_make(g, &r->t[1], r->a, r->b, u, ra, rb);
    r->ktt = dir_coupling(g, &r->t[0], &r->t[1], r->a, r->b);
    real mean = 0.5 * (r->t[0].k + r->t[1].k), half = 0.5 * (r->t[0].k - r->t[1].k);
    r->kmax = mean + sqrt(half * half + r->ktt * r->ktt);
}

void point_row_make(const Group *g, PointRow *r, int contact, int point)
{
    const GroupContact *c = &g->contacts[contact];
    const ManifoldPoint *p = &c->manifold.points[point];
    *r = (PointRow){.contact = contact, .point = point, .a = c->a, .b = c->b};
    point_row_set(g, r, c->manifold.normal, vec3_scale(0.5, vec3_add(p->a, p->b)), g->pos[c->a].x, g->pos[c->b].x);
}
