/* api/save_connect.c - after reading: what records say of each other is checked, and what follows from them is rebuilt.
 *
 * Every function walks one kind of list. Lists are followed only over indices that were checked, and every element is met at
 * most once: it is marked, or has a link back that is set once.
 */
#include "api/save.h"

#include <stdlib.h>

static bool body_is(const World *w, uint32_t slot) { return slot < (uint32_t)w->bodies.count && w->bodies.data[slot].alive; }
static bool solid_is(const World *w, uint32_t slot) { return slot < (uint32_t)w->solids.count && w->solids.data[slot].alive; }
static bool joint_is(const World *w, uint32_t slot) { return slot < (uint32_t)w->joints.count && w->joints.data[slot].alive; }
static bool touch_is(const World *w, uint32_t slot) { return slot < (uint32_t)w->touches.count && w->touches.data[slot].alive; }
static bool is_plane(const Solid *s) { return s->form->shape.type == &shape_plane; }

/* ---- bodies and solids ---- */

/* The list of a body's solids; each is met once (marks). */
static bool walk_solids(World *w, uint32_t body, unsigned char *met)
{
    Body *b = &w->bodies.data[body];
    b->shape_count = 0;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        if (!solid_is(w, s) || w->solids.data[s].body != body || w->solids.data[s].wall != 0 || met[s])
            return false;
        met[s] = 1;
        b->shape_count++;
    }
    return b->shape_count > 0;
}

/* A solid without a body is a wall of the room. */
static bool wall_is_sound(const World *w, uint32_t slot)
{
    const Solid *s = &w->solids.data[slot];
    return s->body == NONE && s->wall > 0 && w->has_room && w->room_solid[s->wall - 1] == slot && is_plane(s);
}

static bool room_is_sound(const World *w)
{
    for (int i = 0; i < 6 && w->has_room; i++)
        if (w->room_solid[i] != NONE && (!solid_is(w, w->room_solid[i]) || w->solids.data[w->room_solid[i]].wall != i + 1))
            return false;
    return true;
}

static void connect_solids(Pack *p, World *w, unsigned char *met)
{
    for (int i = 0; i < w->bodies.count && pack_good(p); i++) {
        Body *b = &w->bodies.data[i];
        if (!b->alive)
            continue;
        if (pack_check(p, walk_solids(w, (uint32_t)i, met), "the list of a body's shapes is broken"))
            pack_check(p, save_derive_mass(w, b), "the inertia of a body is impossible for its shapes");
    }
    for (int i = 0; i < w->solids.count && pack_good(p); i++)
        if (w->solids.data[i].alive && !met[i])
            pack_check(p, wall_is_sound(w, (uint32_t)i), "a shape belongs to nothing");
    pack_check(p, room_is_sound(w), "the room has a wall that is none");
}

/* ---- boxes ---- */

static bool leaf_is_sound(const World *w, uint32_t slot)
{
    const Solid *s = &w->solids.data[slot];
    if (s->leaf == -1)
        return true;
    if (s->leaf < 0 || s->leaf >= w->tree.capacity || is_plane(s))
        return false;
    const TreeNode *n = &w->tree.nodes[s->leaf];
    return n->height == 0 && n->user == slot;
}

/* As many leaves as solids that have one, and each solid's is its own. */
static void connect_boxes(Pack *p, World *w, unsigned char *met)
{
    int leaves = 0, boxes = 0, planes = 0;
    for (int i = 0; i < w->tree.capacity; i++)
        leaves += w->tree.nodes[i].height == 0;
    for (int i = 0; i < w->solids.count; i++) {
        const Solid *s = &w->solids.data[i];
        if (!s->alive)
            continue;
        pack_check(p, leaf_is_sound(w, (uint32_t)i), "a shape has the box of another");
        boxes += s->leaf >= 0;
        planes += is_plane(s);
    }
    pack_check(p, leaves == boxes, "a box belongs to no shape");
    pack_check(p, planes == w->unbounded.count, "the list of planes is not that of the planes");
    for (int i = 0; i < w->unbounded.count && pack_good(p); i++) {
        const Solid *s = &w->solids.data[w->unbounded.data[i]];
        pack_check(p, s->alive && is_plane(s) && !met[w->unbounded.data[i]], "the list of planes holds what is none, or one twice");
        met[w->unbounded.data[i]] = 1;
    }
}

/* ---- lists of what is to be done ---- */

static void connect_awake(Pack *p, World *w)
{
    for (int i = 0; i < w->awake.count && pack_good(p); i++) {
        Body *b = &w->bodies.data[w->awake.data[i]];
        pack_check(p, b->alive && b->kind != DIG_STATIC && !b->listed, "the list of bodies awake is broken");
        b->listed = true;
    }
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        pack_check(p, !b->alive || b->listed || !(b->kind == DIG_DYNAMIC && b->awake), "a body is awake but not listed");
    }
    for (int i = 0; i < w->asking.count && pack_good(p); i++) {
        Solid *s = &w->solids.data[w->asking.data[i]];
        pack_check(p, s->alive && !s->asks, "the list of shapes to be compared is broken");
        s->asks = true;
    }
    for (int i = 0; i < w->pushes.count; i++)
        pack_check(p, body_is(w, w->pushes.data[i].body) && body_dynamic(w, w->pushes.data[i].body), "a push acts on nothing");
}

/* ---- joints ---- */

/* The list of a body's joints. A joint has two ends, each in the list of its body: two marks. */
static bool walk_joints(const World *w, uint32_t body, unsigned char *met)
{
    for (uint32_t s = w->bodies.data[body].joint_first; s != NONE; s = joint_next(w, s, body)) {
        if (!joint_is(w, s) || (w->joints.data[s].a != body && w->joints.data[s].b != body))
            return false;
        unsigned char end = w->joints.data[s].a == body ? 1 : 2;
        if (met[s] & end)
            return false;
        met[s] |= end;
    }
    return true;
}

static bool has_end(const JointRec *j, uint32_t body) { return j->a == body || j->b == body; }

static bool ends_are_sound(const World *w, const JointRec *j)
{
    if (!body_is(w, j->a) || j->a == j->b || (j->b != NONE && !body_is(w, j->b)))
        return false;
    return body_dynamic(w, j->a) || body_dynamic(w, j->b);
}

/* A coupling holds two other joints, by a body of each. */
static bool coupling_is_sound(const World *w, uint32_t slot)
{
    const JointRec *j = &w->joints.data[slot];
    for (int k = 0; k < 2; k++) {
        if (!j->type->couples) {
            if (j->other[k] != NONE)
                return false;
            continue;
        }
        if (!joint_is(w, j->other[k]) || w->joints.data[j->other[k]].type->couples || j->other[k] == j->other[1 - k])
            return false;
        if (!has_end(&w->joints.data[j->other[k]], k ? j->b : j->a))
            return false;
    }
    return true;
}

/* A wheel keeps the direction of its spin axis in its memory, a unit vector or nothing: save for that, memories are numbers. */
static bool memory_is_sound(const JointRec *j)
{
    const real *m = j->memory;
    real length = m[1] * m[1] + m[2] * m[2] + m[3] * m[3];
    return strcmp(j->type->name, "wheel") != 0 || length == 0 || fabs(length - 1) < 1e-6;
}

/* What ranges cannot say, the type checks, as when the joint was made. */
static void check_params(Pack *p, World *w, uint32_t slot)
{
    JointRec *j = &w->joints.data[slot];
    JointView view, other[2];
    real memory[3][JOINT_MEMORY];
    char why[128] = "";
    if (!j->type->check)
        return;
    api_joint_view(w, slot, &view, memory[0]);
    for (int k = 0; k < 2 && j->type->couples; k++) {
        api_joint_view(w, j->other[k], &other[k], memory[k + 1]);
        view.other[k] = &other[k];
    }
    if (j->type->check(j->params, &view, why, sizeof why) != DIG_OK)
        pack_fail(p, "%s: %s", j->type->name, why);
}

static void connect_joints(Pack *p, World *w, unsigned char *met)
{
    for (int i = 0; i < w->joints.count && pack_good(p); i++)
        if (w->joints.data[i].alive)
            pack_check(p, ends_are_sound(w, &w->joints.data[i]) && coupling_is_sound(w, (uint32_t)i) && memory_is_sound(&w->joints.data[i]),
                       "a joint holds what cannot be held");
    for (int i = 0; i < w->bodies.count && pack_good(p); i++)
        if (w->bodies.data[i].alive)
            pack_check(p, walk_joints(w, (uint32_t)i, met), "the list of a body's joints is broken");
    for (int i = 0; i < w->joints.count && pack_good(p); i++) {
        const JointRec *j = &w->joints.data[i];
        if (j->alive && pack_check(p, met[i] == (j->b == NONE ? 1 : 3), "a joint is in no list"))
            check_params(p, w, (uint32_t)i);
    }
}

/* ---- pairs and touches ---- */

/* Is it in the tree, or compared by hand? */
static bool may_pair(const World *w, uint32_t slot) { return solid_is(w, slot) && (w->solids.data[slot].leaf >= 0 || is_plane(&w->solids.data[slot])); }

static bool pair_is_sound(World *w, uint32_t slot)
{
    Pair *p = &w->pairs.data[slot];
    if (!may_pair(w, p->solid_a) || !may_pair(w, p->solid_b) || p->solid_a >= p->solid_b)
        return false;
    const Solid *a = &w->solids.data[p->solid_a], *b = &w->solids.data[p->solid_b];
    bool many = p->contact != NONE && w->contacts.data[p->contact].next != NONE;
    p->body_a = a->body;
    p->body_b = b->body;
    pair_sort(w, p);
    p->prev[0] = p->prev[1] = NONE;
    uint32_t other;
    return a->body != b->body && (body_dynamic(w, a->body) || body_dynamic(w, b->body)) && p->pieces == many && !pair_find(w, p->solid_a, p->solid_b, &other)
        && pair_enter(w, slot) == DIG_OK;
}

/* The list of a solid's pairs; fills prev. Only the first has none, so that no element is met twice. */
static int walk_pairs(World *w, uint32_t solid)
{
    uint32_t first = w->solids.data[solid].pair_first, prev = NONE;
    int count = 0;
    for (uint32_t l = first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
        if (l / 2 >= (uint32_t)w->pairs.count || !w->pairs.data[l / 2].alive)
            return -1;
        Pair *pair = &w->pairs.data[l / 2];
        if ((l % 2 ? pair->solid_b : pair->solid_a) != solid || pair->prev[l % 2] != NONE || (prev != NONE && l == first))
            return -1;
        pair->prev[l % 2] = prev;
        prev = l;
        count++;
    }
    return count;
}

static void connect_pairs(Pack *p, World *w)
{
    int ends = 0;
    if (index_reserve(&w->pair_index, w->pairs.count) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    for (int i = 0; i < w->pairs.count && pack_good(p); i++)
        if (w->pairs.data[i].alive) {
            pack_check(p, pair_is_sound(w, (uint32_t)i), "a pair joins what cannot touch");
            ends += 2;
        }
    for (int i = 0; i < w->solids.count && pack_good(p); i++) {
        if (!w->solids.data[i].alive)
            continue;
        int count = walk_pairs(w, (uint32_t)i);
        pack_check(p, count >= 0, "the list of a shape's pairs is broken");
        ends -= count;
    }
    pack_check(p, ends == 0, "a pair is in no list");
}

static bool touch_is_sound(World *w, uint32_t slot)
{
    const Touch *t = &w->touches.data[slot];
    if (!body_is(w, t->body_a) || (t->body_b != NONE && !body_is(w, t->body_b)) || t->body_a >= t->body_b)
        return false;
    if ((t->body_b == NONE) != (t->wall > 0) || (!body_dynamic(w, t->body_a) && !body_dynamic(w, t->body_b)))
        return false;
    return !touch_find(w, t->body_a, t->body_b, t->wall) && touch_enter(w, slot) == DIG_OK;
}

/* Each touch has as many touching pairs as it says. */
static void connect_touches(Pack *p, World *w, int *pairs)
{
    if (index_reserve(&w->touch_index, w->touches.count) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    for (int i = 0; i < w->touches.count && pack_good(p); i++)
        if (w->touches.data[i].alive)
            pack_check(p, touch_is_sound(w, (uint32_t)i), "a touch is between what cannot touch");
    for (int i = 0; i < w->pairs.count && pack_good(p); i++) {
        const Pair *pair = &w->pairs.data[i];
        if (!pair->alive || !pair->touching)
            continue;
        const Touch *t = touch_find(w, pair->body_a, pair->body_b, w->solids.data[pair->solid_a].wall | w->solids.data[pair->solid_b].wall);
        if (pack_check(p, t != NULL, "a pair touches without a touch"))
            pairs[t - w->touches.data]++;
    }
    for (int i = 0; i < w->touches.count && pack_good(p); i++)
        pack_check(p, !w->touches.data[i].alive || w->touches.data[i].pairs == pairs[i], "a touch counts pairs that do not touch");
}

/* ---- the graph ---- */

static bool link_joins(const GraphLink *l, uint32_t a, uint32_t b, const World *w)
{
    return l && ((l->a == a && l->b == b) || (l->a == b && l->b == a)) && l->bound == !(body_dynamic(w, a) && body_dynamic(w, b));
}

static int count_links(const World *w)
{
    int links = 0;
    for (int i = 0; i < w->bodies.count; i++) {
        if (!graph_has_node(w->graph, (uint32_t)i))
            continue;
        for (uint32_t l = graph_link_first(w->graph, (uint32_t)i); l != GRAPH_END; l = graph_link_next(w->graph, (uint32_t)i, l))
            links += graph_link(w->graph, l)->a == (uint32_t)i;
    }
    return links;
}

/* Touches and joints know their links, links their touches and joints. */
static void connect_links(Pack *p, World *w)
{
    int links = count_links(w);
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!touch_is(w, (uint32_t)i) || t->link == NONE) {
            pack_check(p, !t->alive || t->body_b == NONE || t->pairs == 0, "bodies touch without a link");
            continue;
        }
        const GraphLink *l = graph_link(w->graph, t->link);
        pack_check(p, link_joins(l, t->body_a, t->body_b, w) && l->kind == DIG_LINK_CONTACT && l->user == (uint32_t)i, "a touch has a wrong link");
        links--;
    }
    for (int i = 0; i < w->joints.count; i++) {
        const JointRec *j = &w->joints.data[i];
        if (!j->alive || j->link == NONE) {
            pack_check(p, !j->alive || j->b == NONE, "a joint has no link");
            continue;
        }
        const GraphLink *l = graph_link(w->graph, j->link);
        pack_check(p, link_joins(l, j->a, j->b, w) && l->kind == DIG_LINK_JOINT && l->user == (uint32_t)i, "a joint has a wrong link");
        links--;
    }
    pack_check(p, links == 0, "a link belongs to nothing");
}

static void connect_graph(Pack *p, World *w)
{
    for (int i = 0; i < w->bodies.count; i++) {
        bool node = w->bodies.data[i].alive && w->bodies.data[i].kind == DIG_DYNAMIC;
        pack_check(p, graph_has_node(w->graph, (uint32_t)i) == node, "the DIGs hold other bodies than there are");
    }
    for (int i = 0; i < graph_count(w->graph); i++)
        pack_check(p, graph_user(w->graph, graph_by_index(w->graph, i)) <= ACCURACY_FINEST, "a DIG has no such accuracy");
    if (pack_good(p))
        connect_links(p, w);
}

/* ---- all of it ---- */

/* Room that the engine relies on: whoever may be listed has a place. */
static dig_status reserve(World *w)
{
    uint64_t *n = &w->allocations;
    DIG_TRY(list_reserve(&w->awake, w->bodies.capacity, n));
    DIG_TRY(list_reserve(&w->asking, w->solids.capacity, n));
    DIG_TRY(list_reserve(&w->brief, w->touches.capacity, n));
    DIG_TRY(list_reserve(&w->parent, w->bodies.capacity, n));
    while (w->parent.count < w->bodies.capacity)
        w->parent.data[w->parent.count++] = NONE;
    return DIG_OK;
}

void save_connect(Pack *p, World *w)
{
    size_t most = (size_t)(w->bodies.count + w->solids.count + w->joints.count) + 1;
    unsigned char *met = calloc(most, 1);
    int *pairs = calloc((size_t)w->touches.count + 1, sizeof *pairs);
    if (!met || !pairs || reserve(w) != DIG_OK) {
        pack_fail_memory(p);
    } else {
        connect_solids(p, w, met);
        memset(met, 0, most);
        if (pack_good(p))
            connect_boxes(p, w, met);
        memset(met, 0, most);
        if (pack_good(p))
            connect_awake(p, w);
        if (pack_good(p))
            connect_joints(p, w, met);
        if (pack_good(p))
            connect_pairs(p, w);
        if (pack_good(p))
            connect_touches(p, w, pairs);
        if (pack_good(p))
            connect_graph(p, w);
        w->tally = world_tally(w);
    }
    free(met);
    free(pairs);
}
