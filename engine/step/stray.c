/* step/stray.c - who got farther than foreseen, and into something that its group did not watch.
 *
 * Which bodies may meet in a step is decided before it, from their speeds then; a blow can send one farther. Where it would end up in
 * what its group did not watch, or would have passed through that on its way, the step is done again with a longer reach. Groups that do not
 * follow their blows in time, crowds among them, are not exact: there it must end up deep. A plate that is driven into a crowd hands its
 * speed on through any number of bodies, and so does a row of balls: the last of them may end far behind a thin wall.
 */
#include "step/step.h"
#include "geom/cast.h"

#include <stdlib.h>

#define ASTRAY_TRIES 6          /* of one step */
#define DEEP 0.02               /* outer radii: by less bodies may end up in each other where blows are not followed */

/* A solid that ends beyond its reach: its centre is there, and was there before; its box. low: m  the box begins here, along the axis of the
 * search. whole: the box is of all its way. */
typedef struct Stray { const Group *g; uint32_t solid; vec3 at, from; box3 end; real low; bool missed, whole; } Stray;

static int compare_slot(const void *key, const void *left)
{
    uint32_t a = *(const uint32_t *)key, b = ((const Left *)left)->slot;
    return a < b ? -1 : a > b;
}

/* May the two touch, and is that no pair that the group watched? Asked last: pairs lie anywhere in memory. */
static bool unwatched(const World *w, const Group *g, uint32_t solid, uint32_t other)
{
    uint32_t pair = NONE;
    if (other == solid || !bodies_may_touch(w, &w->solids.data[solid], &w->solids.data[other]))
        return false;
    if (!pair_find(w, solid, other, &pair) || !pair_met(w, &w->pairs.data[pair]))
        return true;
    return g->left_count > 0 && bsearch(&pair, g->left, (size_t)g->left_count, sizeof *g->left, compare_slot);
}

/* Does it follow its blows in time? */
static bool exact(const Group *g) { return !g->crowd && (g->located > 0 || g->varies); }

static real margin_of(const Group *g, const Solid *s) { return exact(g) ? 0 : DEEP * s->form->shape.outer; }

/* Its reach has room for a turn at the speed it had, and for by how much else it misses where its speed would have brought it (reach_of in
 * sense.c). A turn may have room enough for a blow: of what is alone the way is looked at then. */
static bool goes_as_foreseen(const World *w, const Body *b, const Pos *p, const Solid *s, bool alone)
{
    if (b->kind != DIG_DYNAMIC || w->region_count > 0)
        return false;
    const Form *f = s->form;
    real dt = w->def.step, arm = (vec3_is_zero(f->arm) ? 0 : vec3_length(f->arm)) + (f->shape.type == &shape_sphere ? 0 : f->shape.outer);
    if (alone && arm > 0 && vec3_length2(b->w) > 0)
        return false;
    real room = real_min(2, vec3_length(b->w) * dt) * arm + 0.02 * f->shape.outer + 0.5 * b->pull * dt * dt;
    return travel_by(vec3_sub(p->x, vec3_mad(b->x, dt, b->v)), b->q, p->q, arm) <= 0.99 * room;
}

/* m  What its centre of mass may have been off the straight line from where it was to where it is: it got no faster than at the two ends, and
 * what it turned by meanwhile, rad, it went round on an arc. */
static real bulge_of(real chord, real most, real turn)
{
    real slack = 0.5 * sqrt(real_max(0, most * most - chord * chord));
    return real_max(slack, 0.5 * chord * tan(0.25 * turn));
}

/* Where a solid may have been: blows turned it round at known places, and what slides along something or hangs by joints bends no farther
 * than its speed and its turn let it. */
static box3 whole_way(const World *w, const Group *g, int member, const Solid *s)
{
    const Member *m = &g->member[member];
    const Body *b = &w->bodies.data[m->slot];
    vec3 x = g->pos[member].x;
    real dt = w->def.step, fastest = real_max(vec3_length(b->v), vec3_length(g->vel[member].v)) + b->pull * dt;
    Been been = m->been ? g->been[member] : (Been){{x, x}, 0};
    real spin = real_max(vec3_length(b->w), vec3_length(g->vel[member].w)), swung = real_max(been.swung, spin * dt), chord = vec3_distance(x, b->x);
    bool any = swung >= 2 && (chord == 0 || m->collided);       /* in any direction, and on no arc: what it turned by tells nothing */
    real turn = any ? 0 : vec3_length(quat_log(quat_mul(g->pos[member].q, quat_conjugate(b->q))));
    real bulge = m->collided ? 0 : bulge_of(chord, fastest * dt, turn);
    box3 way = {vec3_min(b->x, x), vec3_max(b->x, x)}, start = s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s));
    way = box3_union(way, been.places);
    real arm = vec3_distance(s->form->at.p, b->centre) + s->form->shape.outer;
    real turned = real_min(2, real_max(swung, turn)) * arm + bulge, rim = arm + bulge;
    vec3 low = vec3_max(vec3_sub(vec3_sub(start.low, b->x), (vec3){turned, turned, turned}), (vec3){-rim, -rim, -rim});
    vec3 high = vec3_min(vec3_add(vec3_sub(start.high, b->x), (vec3){turned, turned, turned}), (vec3){rim, rim, rim});
    return (box3){vec3_add(way.low, low), vec3_add(way.high, high)};
}

/* Thought to be alone, whoever is in its group now, and so fast that it might pass through something within the step. */
static bool alone(const World *w, const Group *g, int member, const Solid *s)
{
    const Body *b = &w->bodies.data[g->member[member].slot];
    if (!b->alone || g->crowd)
        return false;
    real far = w->def.step * (vec3_length(b->v) + vec3_length(b->w) * b->rim + b->pull * w->def.step);
    return far > 0.9 * s->form->shape.inner;
}

/* May a joint have swung it round, by a drive's doing or by that of what it holds together? An arc ends elsewhere than it goes through. */
static bool thrown(const Group *g, const Body *b) { return b->joint_first != NONE && !g->crowd; }

/* Was it elsewhere within the step than its ends tell? */
static bool turned_back(const Member *m) { return m->been; }

/* Does it hardly move? Its reach has room for where it was. */
static bool stays(const Body *b, const Pos *p, real margin)
{
    vec3 move = vec3_sub(p->x, b->x);
    return margin > 0 && vec3_length2(move) <= margin * margin && travel_by(move, b->q, p->q, b->outer) <= margin;
}

/* Asked of what neither stays nor goes as foreseen. */
static bool strays(const World *w, int member, Stray *out)
{
    const Group *g = out->g;
    const Solid *s = &w->solids.data[out->solid];
    const Body *b = &w->bodies.data[g->member[member].slot];
    const Pos *p = &g->pos[member];
    real margin = margin_of(g, s);
    pose at = pose_mul((pose){vec3_sub(p->x, quat_rotate(p->q, b->centre)), p->q}, s->form->at);
    if (s->leaf < 0 || !vec3_finite(p->x) || !quat_finite(p->q))
        return false;
    out->at = at.p;
    out->from = solid_pose(w, s).p;
    out->end = out->whole ? whole_way(w, g, member, s) : box3_grow(s->form->shape.type->bounds(&s->form->shape, at), -margin);
    return !box3_inside(solid_reach(w, s), out->end);
}

/* The solids of a member that stray: fills `out`, if there is one; returns how many there are. */
static int list_member(const World *w, const Group *g, int member, Stray *out)
{
    int n = 0;
    const Member *m = &g->member[member];
    const Body *b = &w->bodies.data[m->slot];
    const Pos *p = &g->pos[member];
    for (uint32_t c = b->shape_first; c != NONE && m->moves; c = w->solids.data[c].next) {
        const Solid *s = &w->solids.data[c];
        bool by_itself = alone(w, g, member, s);
        if (!turned_back(m) && ((!by_itself && stays(b, p, margin_of(g, s))) || goes_as_foreseen(w, b, p, s, by_itself)))
            continue;
        Stray stray = {.g = g, .solid = c, .whole = by_itself || thrown(g, b)};
        if (!strays(w, member, &stray))
            continue;
        if (out)
            out[n] = stray;
        n++;
    }
    return n;
}

typedef struct Count { const Group *g; bool *strays; atomic_int count; } Count;      /* strays: [moving_count] */

INLINE void count_share(void *context, int thread, int threads)
{
    Count *c = context;
    int n = 0;
    for (int i = team_first(c->g->moving_count, thread, threads), end = team_end(c->g->moving_count, thread, threads); i < end; i++) {
        int more = list_member(c->g->world, c->g, i, NULL);
        if (c->strays)
            c->strays[i] = more > 0;
        n += more;
    }
    atomic_fetch_add(&c->count, n);
}

int count_strays(Group *g)
{
    Count c = {.g = g, .strays = arena_alloc(g->lasting, (size_t)g->moving_count)};       /* NULL: all are asked again */
    team_deal(g->team, count_share, &c);
    g->astray = c.strays;
    return atomic_load(&c.count);
}

/* Of groups that have any. */
static void list_strays(const World *w, const Step *s, Stray *out)
{
    for (int i = 0, n = 0; i < s->count; i++)
        for (int k = 0; k < s->groups[i].moving_count && s->groups[i].strays > 0; k++)
            if (!s->groups[i].astray || s->groups[i].astray[k])
                n += list_member(w, &s->groups[i], k, out + n);
}

/* Might two solids whose centres end up there be in each other by more than does not matter? What is exact is looked at anew. */
static bool deep(const World *w, const Stray *x, uint32_t other, vec3 at)
{
    const Solid *s = &w->solids.data[x->solid], *o = &w->solids.data[other];
    real near = s->form->shape.outer + o->form->shape.outer - DEEP * real_min(s->form->shape.outer, o->form->shape.outer);
    return x->whole || exact(x->g) || vec3_length2(vec3_sub(at, x->at)) < near * near;
}

typedef struct Meeting { World *w; real dt; Stray *stray; } Meeting;

/* m  How far it gets if nothing strikes it. */
static vec3 way_of(const Meeting *m, const Solid *o)
{
    const Body *b = o->body == NONE ? NULL : &m->w->bodies.data[o->body];
    bool moves = b && (b->kind == DIG_KINEMATIC || (b->kind == DIG_DYNAMIC && b->awake));
    return moves ? vec3_scale(m->dt, b->v) : vec3_zero();
}

/* What it was seen to reach in this step, or where it stands. */
static box3 may_be(const World *w, uint32_t other)
{
    const Solid *o = &w->solids.data[other];
    bool listed = o->body != NONE && w->bodies.data[o->body].listed;
    return listed ? solid_reach(w, o) : o->form->shape.type->bounds(&o->form->shape, solid_pose(w, o));
}

static bool meets(void *context, uint32_t other)
{
    const Meeting *m = context;
    const Solid *o = &m->w->solids.data[other];
    pose at = solid_pose(m->w, o);
    at.p = vec3_add(at.p, way_of(m, o));
    m->stray->missed = deep(m->w, m->stray, other, at.p) &&
                       (m->stray->whole ? box3_overlap(m->stray->end, may_be(m->w, other)) :
                        exact(m->stray->g) || box3_overlap(m->stray->end, o->form->shape.type->bounds(&o->form->shape, at))) &&
                       unwatched(m->w, m->stray->g, m->stray->solid, other);
    return !m->stray->missed;
}

static void go_astray(World *w, Solid *s, real far)
{
    s->astray = far;
    w->bodies.data[s->body].lies = 0;
}

#define ROUNDING 1e-9           /* of the size */

/* Is the line nowhere nearer to the centre than the solid is thick? */
static bool goes_past(vec3 from, vec3 way, vec3 centre, real outer)
{
    vec3 to = vec3_sub(centre, from);
    real along = vec3_length2(way) > 0 ? real_clamp(vec3_dot(to, way) / vec3_length2(way), 0, 1) : 0, near = (1 + ROUNDING) * outer;
    return vec3_length2(vec3_mad(to, -along, way)) > near * near;
}

/* Does the straight line from where its centre was to where it ends pass through the other? That will be struck, and may get as far: of
 * a row of balls each try would else find the next one alone. */
static bool passes(void *context, uint32_t other)
{
    const Meeting *m = context;
    Solid *o = &m->w->solids.data[other];
    vec3 way = vec3_sub(vec3_sub(m->stray->at, m->stray->from), way_of(m, o));
    CastHit hit;
    if (goes_past(m->stray->from, way, solid_pose(m->w, o).p, o->form->shape.outer) ||
        !unwatched(m->w, m->stray->g, m->stray->solid, other) || !cast_ray(&o->form->shape, solid_pose(m->w, o), m->stray->from, way, 1, &hit))
        return true;
    m->stray->missed = true;
    if (m->stray->g->crowd)
        return false;
    if (o->body != NONE && m->w->bodies.data[o->body].kind == DIG_DYNAMIC && m->w->bodies.data[o->body].awake)
        go_astray(m->w, o, real_max(o->astray, vec3_length(way)));
    return true;
}

static void look_on_its_way(World *w, real dt, Stray *stray)
{
    Meeting m = {w, dt, stray};
    tree_query(&w->tree, stray->end, meets, &m);
    if (!stray->missed)
        tree_query(&w->tree, (box3){vec3_min(stray->from, stray->at), vec3_max(stray->from, stray->at)}, passes, &m);
}

/* The tree has no planes. */
static void look_at_planes(const World *w, Stray *stray)
{
    for (int i = 0; i < w->unbounded.count && !stray->missed; i++) {
        uint32_t plane = w->unbounded.data[i];
        stray->missed = plane_near(w, plane, stray->end) && unwatched(w, stray->g, stray->solid, plane);
    }
}

typedef struct Straying { World *w; real dt; Stray *list; int count; bool crowds; } Straying;    /* crowds: those of crowds, or the others */

/* What a crowd's may strike is not told that it was: these change nothing but their own. */
static void look_share(void *context, int thread, int threads)
{
    const Straying *x = context;
    for (int i = team_first(x->count, thread, threads), end = team_end(x->count, thread, threads); i < end; i++)
        if (x->list[i].g->crowd == x->crowds) {
            look_on_its_way(x->w, x->dt, &x->list[i]);
            look_at_planes(x->w, &x->list[i]);
        }
}

#define SHARED_LEAST 32         /* fewer are not worth a team */

static int compare_low(const void *a, const void *b)
{
    const Stray *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    return (x->solid > y->solid) - (x->solid < y->solid);
}

/* Along which they are farthest apart: many may lie in one plane. */
static int widest_axis(const Stray *list, int count)
{
    vec3 low = list[0].end.low, high = low;
    for (int i = 1; i < count; i++) {
        low = vec3_min(low, list[i].end.low);
        high = vec3_max(high, list[i].end.low);
    }
    vec3 wide = vec3_sub(high, low);
    return wide.x >= wide.y && wide.x >= wide.z ? 0 : wide.y >= wide.z ? 1 : 2;
}

/* The tree knows where solids were looked for, not where two that both went astray met. */
static void look_at_each_other(const World *w, Stray *list, int count)
{
    int axis = widest_axis(list, count);
    for (int i = 0; i < count; i++)
        list[i].low = vec3_at(list[i].end.low, axis);
    qsort(list, (size_t)count, sizeof *list, compare_low);
    for (int i = 0; i < count; i++)
        for (int k = i + 1; k < count && list[k].low <= vec3_at(list[i].end.high, axis); k++)
            if (box3_overlap(list[i].end, list[k].end) && deep(w, &list[i], list[k].solid, list[k].at) && unwatched(w, list[i].g, list[i].solid, list[k].solid))
                list[i].missed = list[k].missed = true;
}

static void reach_farther(World *w, Solid *s, box3 end)
{
    box3 reach = solid_reach(w, s);
    vec3 low = vec3_sub(reach.low, end.low), high = vec3_sub(end.high, reach.high);
    go_astray(w, s, s->astray + (real_max(vec3_largest(low), vec3_largest(high)) + 0.1 * s->form->shape.outer));
}

dig_status look_for_strays(World *w, Step *s)
{
    int count = 0;
    for (int i = 0; i < s->count; i++)
        count += s->groups[i].strays;
    if (count == 0 || s->tries >= ASTRAY_TRIES)
        return DIG_OK;
    Stray *list = arena_alloc(&w->scratch, (size_t)count * sizeof *list);
    if (!list)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for bodies that got farther than foreseen");
    list_strays(w, s, list);
    team_deal(count < SHARED_LEAST ? NULL : workers_team(w->workers), look_share, &(Straying){w, s->dt, list, count, true});
    look_share(&(Straying){w, s->dt, list, count, false}, 0, 1);
    look_at_each_other(w, list, count);
    bool again = false;
    for (int i = 0; i < count; i++)
        if (list[i].missed) {
            reach_farther(w, &w->solids.data[list[i].solid], list[i].end);
            again = true;
        }
    s->tries += again;
    return again ? DIG_E_BUSY : DIG_OK;
}
