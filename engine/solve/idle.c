/* solve/idle.c - contacts that touch while nothing presses them: left out of a solve until it turns out that they are called for.
 *
 * A thing that just fits between two walls may be held by any force between these, with friction along them: the rows have that solution
 * beside the one without it, and sweeps and direct solves alike get there from wherever their first rounds turn the thing against a wall.
 * Bodies that give a little would not: they press each other by as much as something presses them together. So a contact that bore nothing
 * before, and whose bodies do not approach there by what pushes them, takes no part until a solve without it lets them sink into each other.
 */
#include "solve/direction.h"

#define NEAR   1e-6             /* of the size: farther apart it is no touch, deeper it overlaps        */
#define SLACK  1e-9             /* of the size: so far may they get into each other in a substep        */
#define NOISE  0.1              /* of what a solve is to leave at most: less is no load                 */
#define COARSE 1e-5             /* m/s: what a solve leaves of velocities is no approach, up to this    */

static real size_of(const Group *g, const PointRow *r) { return g->pairs[g->contacts[r->contact].pair].size; }

/* m/s  of a row, faster than it should: it would close more than it may. */
static real approach(const Group *g, const PointRow *r) { return r->target - dir_rate(g, &r->n, r->a, r->b); }

/* m/s  Not more where an impact cuts a substep short: what approaches goes on to do so in the next one. */
static real slack(const Group *g, const PointRow *r) { return SLACK * size_of(g, r) / real_max(g->h, g->world->def.step / g->plan->substeps); }

static int end_of_contact(const Group *g, int first)
{
    int i = first;
    while (i < g->point_count && g->points[i].contact == g->points[first].contact)
        i++;
    return i;
}

/* What its impulse from before does to velocities is less than what solves leave of them. */
static bool is_idle(const Group *g, const PointRow *r)
{
    real noise = NOISE * g->plan->residual, gap = g->contacts[r->contact].manifold.points[r->point].gap;
    bool bare = r->n.k > 0 && r->blow == 0 && r->jn * r->n.k <= noise && hypot(r->jt[0], r->jt[1]) * r->kmax <= noise;
    return bare && gap >= -NEAR * size_of(g, r) && approach(g, r) <= slack(g, r) + noise;
}

static bool touches(const Group *g, const PointRow *r)
{
    return g->contacts[r->contact].manifold.points[r->point].gap <= NEAR * size_of(g, r);
}

/* Rows of no effect are passed over by all that solves: until it is called its effective mass stands there with the other sign. */
static void leave(Group *g, PointRow *r)
{
    dir_apply(g, &r->n, r->a, r->b, -r->jn);
    dir_apply(g, &r->t[0], r->a, r->b, -r->jt[0]);
    dir_apply(g, &r->t[1], r->a, r->b, -r->jt[1]);
    r->jn = r->jt[0] = r->jt[1] = 0;
    r->n.k = -r->n.k;
}

int idle_leave(Group *g)
{
    int left = 0;
    for (int i = 0, end; i < g->point_count; i = end) {
        bool idle = true, touch = false;
        end = end_of_contact(g, i);
        for (int k = i; k < end; k++) {
            idle = idle && is_idle(g, &g->points[k]);
            touch = touch || touches(g, &g->points[k]);
        }
        for (int k = i; k < end && idle && touch; k++, left++)
            leave(g, &g->points[k]);
    }
    return left;
}

int idle_call(Group *g, bool all)
{
    int called = 0;
    real coarse = real_min(2 * g->residual, COARSE);
    for (int i = 0, end; i < g->point_count; i = end) {
        bool sinks = false;
        end = end_of_contact(g, i);
        for (int k = i; k < end; k++)
            sinks = sinks || (g->points[k].n.k < 0 && (all || approach(g, &g->points[k]) > slack(g, &g->points[k]) + coarse));
        for (int k = i; k < end && sinks; k++, called++)
            g->points[k].n.k = fabs(g->points[k].n.k);
    }
    return called;
}
