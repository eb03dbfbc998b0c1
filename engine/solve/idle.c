/* solve/idle.c - contacts that touch while nothing presses them: left out of a solve until it turns out that they are called for.
 *
 * A thing that just fits between two walls may be held by any force between these, with friction along them: the rows have that solution
 * beside the one without it, and sweeps and direct solves alike get there from wherever their first rounds turn the thing against a wall.
 * Bodies that give a little would not: they press each other by as much as something presses them together. So a contact that bore nothing
 * before, and whose bodies do not approach there by what pushes them, takes no part until a solve without it lets them sink into each other.
 * What is laid into each other is moved apart, and nobody knows where it would press: there any force from before may be such a one.
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

/* What of a body's fall is stopped, if all that is struck, or stands on what is, stops there. */
typedef struct Stopped { vec3 v; bool stops; } Stopped;

/* m/s  As approach, with the spins left out. */
static real falls(const Group *g, const Stopped *s, const PointRow *r)
{
    vec3 n = g->contacts[r->contact].manifold.normal;
    return r->target - vec3_dot(n, vec3_sub(s[r->b].v, s[r->a].v));
}

static bool stops_at(const Group *g, const Stopped *s, int body) { return !g->member[body].moves || s[body].stops; }

/* Of two as they were, the one that nothing had stopped yet comes to rest on the other. What lies on several comes down on all of them. */
static bool comes_down(const Group *g, const Stopped *was, const PointRow *r)
{
    return stops_at(g, was, r->a) != stops_at(g, was, r->b) && falls(g, was, r) > slack(g, r);
}

static void stop(const Group *g, const Stopped *was, Stopped *s, const PointRow *r)
{
    bool a = stops_at(g, was, r->a);
    Stopped *who = &s[a ? r->b : r->a];
    if (!who->stops)
        who->v = vec3_mad(who->v, a ? falls(g, was, r) : -falls(g, was, r), g->contacts[r->contact].manifold.normal);
    who->stops = true;
}

#define PASSES 64

/* What would be called in round after round, as the load of a stack comes down on it, is so at once; returns how many points. */
static int foresee(Group *g)
{
    ArenaMark mark = arena_mark(g->arena);
    size_t bytes = (size_t)g->body_count * sizeof(Stopped);
    Stopped *s = arena_alloc(g->arena, bytes), *was = arena_alloc(g->arena, bytes);
    int called = 0;
    bool more = s && was;               /* without memory the rounds find it */
    for (int i = 0; i < g->body_count && more; i++)
        s[i] = (Stopped){g->vel[i].v, false};
    for (int pass = 0; pass < PASSES && more; pass++) {
        more = false;
        memcpy(was, s, bytes);
        for (int i = 0, end; i < g->point_count; i = end) {
            bool down = false;
            end = end_of_contact(g, i);
            for (int k = i; k < end; k++)
                if (comes_down(g, was, &g->points[k])) {
                    stop(g, was, s, &g->points[k]);
                    down = true;
                }
            more = more || down;
            for (int k = i; k < end && down; k++)
                if (g->points[k].n.k < 0) {
                    g->points[k].n.k = -g->points[k].n.k;
                    called++;
                }
        }
    }
    arena_rewind(g->arena, mark);
    return called;
}

static bool is_merged(const Group *g, const PointRow *r) { return contact_merged(g, &g->contacts[r->contact]); }

/* Of a contact of points first to end - 1. */
static bool may_leave(const Group *g, int first, int end)
{
    bool idle = true, touch = false, acts = true;
    for (int k = first; k < end; k++) {
        idle = idle && is_idle(g, &g->points[k]);
        touch = touch || touches(g, &g->points[k]);
        acts = acts && g->points[k].n.k > 0 && g->points[k].blow == 0;
    }
    return (idle && touch) || (acts && is_merged(g, &g->points[first]));
}

/* N s  The impulses that points had, by point. */
static void *keep_impulses(const Group *g)
{
    real (*kept)[3] = arena_alloc(g->arena, (size_t)g->point_count * sizeof *kept);
    for (int i = 0; i < g->point_count && kept; i++) {
        const PointRow *r = &g->points[i];
        kept[i][0] = r->jn;
        kept[i][1] = r->jt[0];
        kept[i][2] = r->jt[1];
    }
    return kept;
}

/* Those that were called begin where they were. */
static void take_up(Group *g, real (*kept)[3])
{
    for (int i = 0; i < g->point_count && kept; i++) {
        PointRow *r = &g->points[i];
        if (!(r->n.k > 0 && r->jn == 0 && kept[i][0] > 0 && is_merged(g, r)))
            continue;
        r->jn = kept[i][0];
        r->jt[0] = kept[i][1];
        r->jt[1] = kept[i][2];
        dir_apply(g, &r->n, r->a, r->b, r->jn);
        dir_apply(g, &r->t[0], r->a, r->b, r->jt[0]);
        dir_apply(g, &r->t[1], r->a, r->b, r->jt[1]);
    }
}

int idle_leave(Group *g)
{
    int left = 0;
    ArenaMark mark = arena_mark(g->arena);
    void *kept = NULL;
    for (int i = 0, end; i < g->point_count; i = end) {
        end = end_of_contact(g, i);
        if (!may_leave(g, i, end))
            continue;
        kept = kept || !is_merged(g, &g->points[i]) ? kept : keep_impulses(g);
        for (int k = i; k < end; k++, left++)
            leave(g, &g->points[k]);
    }
    if (left > 0) {
        left -= foresee(g);
        take_up(g, kept);
    }
    arena_rewind(g->arena, mark);
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
