/* solve/direction.h - directions of contact points, shared by the solvers and the contact effects.
 *
 * Floor: solve.
 */
#ifndef DIG_DIRECTION_H
#define DIG_DIRECTION_H

#include "solve/group.h"

void dir_make(const Group *g, Dir *d, int a, int b, vec3 n, vec3 ra, vec3 rb);
/* m/s, of b relative to a; here and below inline: these two are what sweeps spend their time in */
static inline real dir_rate(const Group *g, const Dir *d, int a, int b)
{
    const Vel *va = &g->vel[a], *vb = &g->vel[b];
    return vec3_dot(d->n, vec3_sub(vb->v, va->v)) + vec3_dot(d->aa, va->w) + vec3_dot(d->ab, vb->w);
}
/* N s on b, minus on a */
static inline void dir_apply(Group *g, const Dir *d, int a, int b, real p)
{
    Vel *va = &g->vel[a], *vb = &g->vel[b];
    va->v = vec3_mad(va->v, -p * g->mass[a].im, d->n);
    va->w = vec3_mad(va->w, p, d->ia);
    vb->v = vec3_mad(vb->v, p * g->mass[b].im, d->n);
    vb->w = vec3_mad(vb->w, p, d->ib);
}
real dir_coupling(const Group *g, const Dir *d, const Dir *e, int a, int b);
void dir_mask(const Group *g, vec3 *linear, vec3 *angular);             /* drops the dead axis of a planar world */
void point_row_set(const Group *g, PointRow *r, vec3 normal, vec3 at, vec3 xa, vec3 xb);
void point_row_make(const Group *g, PointRow *r, int contact, int point);

#endif
