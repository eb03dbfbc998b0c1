/* solve/lever.c - movers give what they touch no more than a bounded multiple of their own motion in a substep.
 *
 * A plate that comes down on a row of limbs that stand straight above each other asks them to buckle: at an angle a from straight, at its
 * speed over a, for hundreds of megajoules where they stand straight to rounding; no row sees that they would be out of the way after a
 * millimetre. No lever of everyday things is so long. Where contacts of movers make the group faster than all of it at so many times their
 * speed, by its energy, impulses count by the share that does not: the mover goes on into what it presses by what is left, limbs are off
 * their line after that, and the next substeps find them so. What falls in a substep counts as speed, too: a mover that lifts a load slowly by
 * a lever of twenty gives it no more than that, and has to.
 */
#include "solve/group.h"

#define LEVER 10.0              /* times the speed of the mover */

/* What movers do by a solve's impulses at contacts. */
typedef struct Driven { real work, fastest; } Driven;       /* J, m/s */

static void add_driven(const Group *g, const PointRow *r, Driven *sum)
{
    int by = g->member[r->a].kinematic ? r->a : g->member[r->b].kinematic ? r->b : -1;
    if (by < 0 || !(r->jn > 0))
        return;
    const GroupContact *c = &g->contacts[r->contact];
    vec3 v = vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, vec3_sub(c->manifold.points[r->point].a, g->pos[by].x)));
    vec3 impulse = vec3_mad(vec3_mad(vec3_scale(r->jn + r->blow, c->manifold.normal), r->jt[0], r->t[0].n), r->jt[1], r->t[1].n);
    sum->work += vec3_dot(impulse, v) * (by == r->a ? 1 : -1);
    sum->fastest = real_max(sum->fastest, vec3_length(v));
}

/* Of the impulses of a solve. 1: all of them. before: velocities without them. */
static real share_of(Group *g, Vel *before)
{
    Driven sum = {0, 0};
    real mass = 0, gain = group_kinetic(g);
    for (int i = 0; i < g->point_count; i++)
        add_driven(g, &g->points[i], &sum);
    for (int i = 0; i < g->moving_count; i++)
        mass += g->member[i].moves ? g->member[i].mass : 0;
    real speed = LEVER * (sum.fastest + g->fall * g->h), most = 0.5 * mass * speed * speed;
    if (!(sum.work > most) || !(gain > most))
        return 1;
    Vel *after = g->vel;
    g->vel = before;
    gain -= group_kinetic(g);
    g->vel = after;
    return gain > most && sum.work >= gain ? sqrt(most / gain) : 1;     /* else motors and springs gave it */
}

bool group_may_lever(const Group *g) { return g->driven && g->joint_count > 0; }

void group_ease_levers(Group *g, Vel *before)
{
    real s = share_of(g, before);
    if (!(s < 1))
        return;
    for (int i = 0; i < g->moving_count; i++) {
        Vel *v = &g->vel[i];
        *v = (Vel){vec3_mad(before[i].v, s, vec3_sub(v->v, before[i].v)), vec3_mad(before[i].w, s, vec3_sub(v->w, before[i].w))};
    }
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        r->jn *= s;
        r->jt[0] *= s;
        r->jt[1] *= s;
        r->blow *= s;
    }
    for (int i = 0; i < g->roll_count; i++)
        g->rolls[i].j = vec3_scale(s, g->rolls[i].j);
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p *= s;
}
