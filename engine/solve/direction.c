/* solve/direction.c - directions of contact points: Jacobian, effective mass, impulse. */
#include "solve/direction.h"
#include "base/wide.h"
#include "solve/four_dir.h"

#define ROUNDED 1e-12           /* of what was there: less than that, left of it, is rounding, and a row of rounding would hold what it must not */

static vec3 masked(const Group *g, vec3 v, bool linear)
{
    if (!g->planar)
        return v;
    vec3 left = v;
    real *c[3] = {&left.x, &left.y, &left.z};
    for (int i = 0; i < 3; i++)
        if ((i == g->planar - 1) == linear)
            *c[i] = 0;
    return vec3_length2(left) > ROUNDED * ROUNDED * vec3_length2(v) ? left : vec3_zero();
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

/* ---- the points of a contact side by side ---- */

_Static_assert(MANIFOLD_POINTS == LANES, "a contact's points fill a four");

/* Bodies of a contact, and where its points are from their centres of mass. */
typedef struct Arms { four im; four33 ii_a, ii_b; four3 ra, rb; } Arms;

INLINE FourDir dirs_make(const Arms *m, vec3 n)
{
    FourDir d = {.n = four3_all(n)};
    d.aa = four3_cross(d.n, m->ra);
    d.ab = four3_cross(m->rb, d.n);
    d.ia = four33_mul3(&m->ii_a, d.aa);
    d.ib = four33_mul3(&m->ii_b, d.ab);
    d.k = m->im * four3_dot(d.n, d.n) + four3_dot(d.aa, d.ia) + four3_dot(d.ab, d.ib);
    return d;
}

INLINE void make_rows(const Group *g, PointRow *r, int contact)
{
    const GroupContact *c = &g->contacts[contact];
    const GroupManifold *m = &c->manifold;
    const Mass *ma = &g->mass[c->a], *mb = &g->mass[c->b];
    Arms arms = {.im = four_all(ma->im + mb->im), .ii_a = four33_all(&ma->ii), .ii_b = four33_all(&mb->ii)};
    vec3 t, u;
    four3 at;
    UNROLL
    for (int k = 0; k < LANES; k++) {
        const ManifoldPoint *p = &m->points[k < m->count ? k : 0];
        four3_put(&at, k, vec3_scale(0.5, vec3_add(p->a, p->b)));
    }
    arms.ra = four3_sub(at, four3_all(g->pos[c->a].x));
    arms.rb = four3_sub(at, four3_all(g->pos[c->b].x));
    vec3_basis(m->normal, &t, &u);
    FourDir n = dirs_make(&arms, m->normal), d = dirs_make(&arms, t), e = dirs_make(&arms, u);
    four ktt = arms.im * four3_dot(d.n, e.n) + four3_dot(d.aa, e.ia) + four3_dot(d.ab, e.ib);
    four mean = 0.5 * (d.k + e.k), half = 0.5 * (d.k - e.k), kmax = mean + four_root(half * half + ktt * ktt);
    four_dir_store(&n, &r->n, sizeof *r, m->count);
    four_dir_store(&d, &r->t[0], sizeof *r, m->count);
    four_dir_store(&e, &r->t[1], sizeof *r, m->count);
    for (int k = 0; k < m->count; k++) {
        r[k].ktt = ktt[k];
        r[k].kmax = kmax[k];
    }
}

static void make_plain(const Group *g, PointRow *r, int contact) { make_rows(g, r, contact); }
WIDE static void make_wide(const Group *g, PointRow *r, int contact) { make_rows(g, r, contact); }

void contact_rows_make(const Group *g, PointRow *r, int contact)
{
    const GroupContact *c = &g->contacts[contact];
    if (g->planar || c->manifold.count == 1) {
        for (int k = 0; k < c->manifold.count; k++)
            point_row_make(g, &r[k], contact, k);
        return;
    }
    for (int k = 0; k < c->manifold.count; k++) {
        r[k].contact = contact;
        r[k].point = k;
        r[k].a = c->a;
        r[k].b = c->b;
        memset((char *)&r[k] + offsetof(PointRow, target), 0, sizeof r[k] - offsetof(PointRow, target));        /* all that effects say */
    }
    (has_wide() ? make_wide : make_plain)(g, r, contact);
}
