/* trace/touch.c - contacts of the present state become frozen features; those that stay keep their kinds. */
#include "trace/trace.h"

#include <stddef.h>
#include <stdlib.h>

#define RIM 0xf0000000u         /* numbers of rims, apart from those of manifold points */

#define OFF        0.01     /* of the tolerance: what presses is no farther off, nor what leaves deeper */
#define SAME_SPOT  1e-12    /* of the size */
#define SAME_PLACE 1e-7     /* of the size: so far a frozen feature may be from the manifold's point that it stands for */

/* The same contact before: a ball that rolls over an edge has another feature, and is the same still. */
static const Touching *find_old(const Tracer *t, const GroupContact *c, int contact, uint32_t id)
{
    for (int i = 0; i < t->old_count; i++) {
        const Touching *o = &t->old_touch[i];
        if (o->contact == contact && (o->id == id || (c->manifold.count == 1 && o->point == 0)))
            return o;
    }
    return NULL;
}

static void new_contact(const Tracer *t, Touching *c, const GroupPair *q, const GroupContact *from, const PointMemory *memory)
{
    memset(c, 0, offsetof(Touching, feature));          /* its gate and its cones */
    c->slip.weight = c->roll.weight = 1;
    c->gate.force = memory->normal;
    c->slip.force = memory->tangent;
    c->slip.axes = q->rub->friction > 0 ? 2 : 0;
    c->slip.still = q->rub->friction;
    c->slip.moving = q->rub->friction_dynamic;
    real a = q->on_a->shape.rolling, b = q->on_b->shape.rolling, radius = a > 0 && b > 0 ? a * b / (a + b) : real_max(a, b);
    c->roll.axes = q->rub->rolling > 0 && radius > 0 && !t->g->planar ? 3 : 0;
    c->roll.still = c->roll.moving = q->rub->rolling * radius;
    if (c->roll.axes && from->manifold.count == 1)
        c->roll.force = contact_rolling(t->g, from);
}

static bool any_moves(const Group *g, const GroupContact *c) { return g->member[c->a].moves || g->member[c->b].moves; }

/* A contact that pressed in the last step still does, though another way may have left it a little off. */
static bool held_before(const Tracer *t, const GroupContact *c, int point, const Kinematics *k, real size)
{
    return contact_memory(c)[point].held > 0 && fabs(k->gap) < 1e-3 * size && fabs(k->rate) < 1e-4 * t->size * t->pace;
}

/* Is the feature of before, in its present place, what the manifold's point means? Edges across each other are looked at anew. */
static bool still_fits(const Tracer *t, Touching *c, const ManifoldPoint *p, real size)
{
    if (c->feature.kind != POINT_PLANE && c->feature.kind != PLANE_POINT)
        return false;
    if (!t->known)              /* else it was moved there for the last evaluation */
        feature_move(t->g, &c->feature, c->a, c->b, &c->k);
    return fabs(c->k.gap - p->gap) <= SAME_SPOT * size && vec3_distance(c->k.at, p->a) <= fabs(p->gap) + SAME_SPOT * size;
}

/* A rim touches in one place, whichever of its points the manifold has, and is the same rim wherever that is. 0: it is none. */
static uint32_t rim_of(const GroupPair *q, const Sides *sides, const ManifoldPoint *p, Feature *out)
{
    if (q->on_a->shape.type != &shape_cylinder && q->on_b->shape.type != &shape_cylinder)
        return 0;
    feature_find(q, sides, p, out);
    if (!feature_has_rim(out))
        return 0;
    bool on_b = out->kind == PLANE_RIM || out->kind == POINT_RIM;
    vec3 centre = vec3_sub(on_b ? out->pb : out->pa, pair_local(q, on_b).p), axis = on_b ? out->db : out->da;
    return RIM | (on_b ? 2u : 0u) | (vec3_dot(centre, axis) > 0 ? 1u : 0u);
}

static bool has_rim(const Tracer *t, int contact, uint32_t id)
{
    for (int i = t->touch_count - 1; i >= 0 && t->touch[i].contact == contact; i--)
        if (t->touch[i].id == id)
            return true;
    return false;
}

/* How the bodies of a point move at its feature. False: that is not what the manifold's point means. */
static bool place_point(const Tracer *t, Touching *n, const GroupPair *q, const ManifoldPoint *p)
{
    n->gate.gap = n->k.gap;
    n->gate.rate = n->k.rate;
    n->slip.u = vec3_mad(n->k.u, -n->k.rate, n->k.n);
    n->roll.u = vec3_sub(t->g->vel[n->b].w, t->g->vel[n->a].w);
    return fabs(n->k.gap - p->gap) <= SAME_PLACE * q->size;
}

static bool place_rim(const Tracer *t, Touching *n, const GroupPair *q, const ManifoldPoint *p, const Feature *rim)
{
    n->feature = *rim;
    feature_move(t->g, rim, n->a, n->b, &n->k);
    place_point(t, n, q, p);
    return n->k.gap <= p->gap + SAME_PLACE * q->size;
}

static bool add_point(Tracer *t, int contact, int point, const Sides *sides, bool first)
{
    Group *g = t->g;
    GroupContact *c = &g->contacts[contact];
    const GroupPair *q = &g->pairs[c->pair];
    const ManifoldPoint *p = &c->manifold.points[point];
    Touching *n = &t->touch[t->touch_count];
    Feature rim;
    uint32_t id = rim_of(q, sides, p, &rim);
    if (id && has_rim(t, contact, id))
        return true;
    const Touching *old = find_old(t, c, contact, id ? id : p->feature);
    if (old)
        *n = *old;
    else
        new_contact(t, n, q, c, &contact_memory(c)[point]);
    n->contact = contact;
    n->point = point;
    n->a = c->a;
    n->b = c->b;
    n->id = id ? id : p->feature;
    if (!id && !(old && still_fits(t, n, p, q->size))) {
        feature_find(q, sides, p, &n->feature);
        feature_move(t->g, &n->feature, n->a, n->b, &n->k);
    }
    if (!(id ? place_rim(t, n, q, p, &rim) : place_point(t, n, q, p))) {
        if (p->gap > 1e-6 * q->size)
            return true;        /* the frozen feature is not what the manifold means, and does not touch: it is looked for again when it is nearer */
        t->unplaced = true;
        return true;
    }
    if (first) {
        n->gate.closed = n->gate.presses = held_before(t, c, point, &n->k, q->size);
        n->slip.grip = c->manifold.slides || vec3_length(n->slip.u) > t->slip_zero ? GRIP_SLIP : GRIP_STICK;
        n->roll.grip = t->size * vec3_length(n->roll.u) > t->slip_zero ? GRIP_SLIP : GRIP_STICK;
    }
    if (!old)
        n->gate.gap0 = first ? n->k.gap : 0;
    if (!old && !n->gate.closed && fabs(n->k.gap) <= t->gap_zero && n->k.rate <= t->speed_zero)
        t->dirty = true;
    t->touch_count++;
    return true;
}

/* Are the points those of before, in the same order? Corners of faces, that is: other features may have to be found anew. */
static bool same_points(const Tracer *t)
{
    const Group *g = t->g;
    int n = 0;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        int count = c->live && any_moves(g, c) ? c->manifold.count : 0;
        for (int k = 0; k < count; k++, n++) {
            const Touching *o = &t->touch[n];
            const ManifoldPoint *p = &c->manifold.points[k];
            if (n == t->touch_count || o->contact != i || o->point != k || o->id != p->feature)
                return false;
        }
    }
    return n == t->touch_count;
}

/* They stay where they are, with all that is known of them. */
static bool keep_points(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Touching *n = &t->touch[i];
        const GroupContact *c = &t->g->contacts[n->contact];
        const GroupPair *q = &t->g->pairs[c->pair];
        const ManifoldPoint *p = &c->manifold.points[n->point];
        if (!still_fits(t, n, p, q->size) || (!t->known && !place_point(t, n, q, p)))
            return false;
    }
    return true;
}

/* Items in order along chains and stacks keep the profile of the system narrow. */
typedef struct Item { int key, low, what; } Item;

static int compare_items(const void *a, const void *b)
{
    const Item *x = a, *y = b;
    if (x->key != y->key)
        return x->key - y->key;
    return x->low != y->low ? x->low - y->low : y->what - x->what;
}

static Item item_of(const Tracer *t, int a, int b, int what)
{
    int oa = a >= 0 && t->g->member[a].moves ? t->order[a] : -1, ob = b >= 0 && t->g->member[b].moves ? t->order[b] : -1;
    return (Item){int_max(oa, ob), int_min(oa, ob), what};
}

bool trace_items(Tracer *t)
{
    if (t->touch_count + t->stop_count + t->hold_count > WATCHED) {
        t->fault = "more contact points and stops than its budget";
        return false;
    }
    int most = t->g->joint_count + t->touch_count, n = 0;
    ArenaMark mark = arena_mark(t->g->arena);
    Item *items = arena_alloc(t->g->arena, (size_t)(most + 1) * sizeof *items);
    if (!items)
        return false;
    for (int i = 0; i < t->g->joint_count; i++)
        items[n++] = item_of(t, t->g->joints[i].a, t->g->joints[i].b, i);
    for (int i = 0; i < t->touch_count; i++)
        if (i == 0 || t->touch[i].contact != t->touch[i - 1].contact)
            items[n++] = item_of(t, t->touch[i].a, t->touch[i].b, -1 - i);
    bool sorted = true;         /* as bodies that came one after the other are */
    for (int i = 1; i < n && sorted; i++)
        sorted = compare_items(&items[i - 1], &items[i]) < 0;
    if (!sorted)
        qsort(items, (size_t)n, sizeof *items, compare_items);
    for (int i = 0; i < n; i++)
        t->item[i] = items[i].what;
    t->item_count = n;
    arena_rewind(t->g->arena, mark);
    return true;
}

static bool lost_a_pressing_one(const Tracer *t)
{
    int before = 0, now = 0;
    for (int i = 0; i < t->old_count; i++)
        before += t->old_touch[i].gate.presses;
    for (int i = 0; i < t->touch_count; i++)
        now += t->touch[i].gate.presses;
    return now != before;
}

/* Manifolds are kept from step to step, and are those of the present poses unless marked as fresh. Where every pair that moves
 * presses since the last step, they serve; what comes near elsewhere is found at the end of the step. */
static bool all_held(const Tracer *t)
{
    const Group *g = t->g;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        bool held = false;
        for (int k = 0; k < c->manifold.count; k++)
            held = held || contact_memory(c)[k].held == HELD_SUBSTEPS;
        if (!held && any_moves(g, c))
            return false;
    }
    return g->trace_step > 0;
}

bool trace_touch(Tracer *t, bool first)
{
    Group *g = t->g;
    group_touch(g, t->end, !first || !(g->looked || all_held(t)));
    g->looked = false;
    t->touched = t->t;
    t->unplaced = false;
    t->relisted = first || !same_points(t) || !keep_points(t);
    if (!t->relisted)
        return true;
    t->noted = false;
    Touching *swap = t->old_touch;
    t->old_touch = t->touch;
    t->old_count = t->touch_count;
    t->touch = swap;
    t->touch_count = 0;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        if (!c->live || !any_moves(g, c))
            continue;
        Sides sides;
        feature_sides(g, &g->pairs[c->pair], c->manifold.normal, &sides);
        for (int k = 0; k < c->manifold.count; k++)
            if (t->touch_count == t->touch_capacity || !add_point(t, i, k, &sides, first)) {
                t->fault = t->fault ? t->fault : "more contact points than its budget";
                return false;
            }
    }
    if (!first && lost_a_pressing_one(t))
        t->dirty = true;
    if (!trace_items(t))        /* of what is listed, in any case: that list may be kept when it is looked again */
        return false;
    if (t->unplaced)
        t->fault = "a contact without a frozen feature";
    return !t->unplaced;
}

static bool pressed_before(const Tracer *t, const Touching *c)
{
    for (int i = 0; i < t->old_count; i++)
        if (t->old_touch[i].contact == c->contact && t->old_touch[i].gate.presses)
            return true;
    return false;
}

/* Does a body that pressed at o touch the other one still, or what it did not press before, as the next tile that it slides on? */
static bool rests_on(const Tracer *t, const Touching *o, int body)
{
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        if ((c->a == body || c->b == body) && c->gate.gap <= OFF * t->tolerance + t->gap_zero
            && ((c->a == o->a && c->b == o->b) || !pressed_before(t, c)))
            return true;
    }
    return !trace_moves(t, body);
}

/* Do two that pressed each other touch no more? No event has ended that, so one has got over an edge within the step: a cylinder that rolls off a table,
 * whose line touches in other points than before, or a box that is pushed off it, which leans on what pushes.
 * Returns that contact, or -1. */
static int got_over_edge(const Tracer *t)
{
    for (int i = 0; i < t->old_count && t->relisted; i++) {
        const Touching *o = &t->old_touch[i];
        if (o->gate.presses && (!rests_on(t, o, o->a) || !rests_on(t, o, o->b)))
            return o->contact;
    }
    return -1;
}

bool trace_presses(const Tracer *t, int contact)
{
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].contact == contact && t->touch[i].gate.presses)
            return true;
    return false;
}

bool trace_missed(const Tracer *t, int *over)
{
    *over = got_over_edge(t);
    if (*over >= 0)
        return true;
    real off = OFF * t->tolerance + t->gap_zero;
    for (int i = 0; i < t->touch_count; i++) {
        const Gate *g = &t->touch[i].gate;
        bool leaves = g->rate > t->speed_zero && g->gap >= -off;        /* a corner that slides off an edge, from the face that is behind that */
        if (!g->presses && g->gap < real_min(0, g->gap0) - t->gap_zero && !leaves)     /* deeper than it was */
            return true;
        if (g->presses && fabs(g->gap) > off)       /* it rolled over an edge */
            return true;
    }
    return false;
}
