/* solve/direction.h - directions of contact points, shared by the solvers and the contact effects.
 *
 * Floor: solve.
 */
#ifndef DIG_DIRECTION_H
#define DIG_DIRECTION_H

#include "solve/group.h"

void dir_make(const Group *g, Dir *d, int a, int b, vec3 n, vec3 ra, vec3 rb);
/* m/s, of b relative to a; here and below inline: these are what sweeps spend their time in */
static inline __attribute__((always_inline)) real dir_rate_between(const Dir *d, const Vel *a, const Vel *b)
{
    return vec3_dot(d->n, vec3_sub(b->v, a->v)) + vec3_dot(d->aa, a->w) + vec3_dot(d->ab, b->w);
}
/* N s on b, minus on a */
static inline __attribute__((always_inline)) void dir_apply_between(const Dir *d, Vel *a, real ima, Vel *b, real imb, real p)
{
    *a = (Vel){vec3_mad(a->v, -p * ima, d->n), vec3_mad(a->w, p, d->ia)};
    *b = (Vel){vec3_mad(b->v, p * imb, d->n), vec3_mad(b->w, p, d->ib)};
}
/* The same of the group's bodies. */
static inline real dir_rate(const Group *g, const Dir *d, int a, int b) { return dir_rate_between(d, &g->vel[a], &g->vel[b]); }
static inline void dir_apply(Group *g, const Dir *d, int a, int b, real p)
{
    dir_apply_between(d, &g->vel[a], g->mass[a].im, &g->vel[b], g->mass[b].im, p);
}
real dir_coupling(const Group *g, const Dir *d, const Dir *e, int a, int b);
void dir_mask(const Group *g, vec3 *linear, vec3 *angular);             /* drops the dead axis of a planar world */
void point_row_set(const Group *g, PointRow *r, vec3 normal, vec3 at, vec3 xa, vec3 xb);
void point_row_make(const Group *g, PointRow *r, int contact, int point);
/* r: one for each point of the contact; the same bits as of one after the other */
void contact_rows_make(const Group *g, PointRow *r, int contact);

#endif
