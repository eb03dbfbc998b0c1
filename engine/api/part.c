/* api/part.c - takes one DIG and its surroundings out of a world: first who belongs to it, table by table, then the copies, whose slots
 * are the places in those lists. They are ascending, so that all orders are those of the world.
 */
#include "api/part.h"

#include "base/sort.h"
#include "world/joint.h"

#include <stdlib.h>

#define STILL 1e-4              /* m    has not moved */

/* ---- lists of slots ---- */

static dig_status add(Slots *s, uint32_t slot)
{
    DIG_TRY(list_push(s, NULL));
    s->data[s->count - 1] = slot;
    return DIG_OK;
}

/* Ascending, each once. */
static dig_status tidy(Slots *s, Arena *scratch)
{
    int n = 0;
    DIG_TRY(sort_u32(s->data, s->count, scratch));
    for (int i = 0; i < s->count; i++)
        if (n == 0 || s->data[n - 1] != s->data[i])
            s->data[n++] = s->data[i];
    s->count = n;
    return DIG_OK;
}

/* NONE: it is not there. */
static uint32_t place(const Slots *s, uint32_t slot)
{
    int low = 0, high = s->count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (s->data[middle] < slot)
            low = middle + 1;
        else
            high = middle;
    }
    return low < s->count && s->data[low] == slot ? (uint32_t)low : NONE;
}

/* ---- who belongs to it ---- */

typedef struct Taking { const World *w; Part *p; Map digs; dig_status status; } Taking;     /* digs: first members of those that are in */

static box3 box_of(const World *w, const Body *b)
{
    vec3 out = {b->outer, b->outer, b->outer};
    box3 box = {vec3_sub(b->x, out), vec3_add(b->x, out)};
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        if (w->solids.data[s].leaf >= 0)
            box = s == b->shape_first ? tree_box(&w->tree, w->solids.data[s].leaf) : box3_union(box, tree_box(&w->tree, w->solids.data[s].leaf));
    return box;
}

/* What a member lies on or hangs on, if that is no member itself. */
static dig_status add_grounds(const World *w, Part *p, uint32_t member)
{
    for (uint32_t l = graph_link_first(w->graph, member); l != GRAPH_END; l = graph_link_next(w->graph, member, l)) {
        DIG_TRY(add(&p->links, l));
        if (graph_link(w->graph, l)->bound)
            DIG_TRY(add(&p->bodies, graph_link(w->graph, l)->b));
    }
    for (uint32_t s = w->bodies.data[member].shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *pair = &w->pairs.data[l / 2];
            uint32_t other = l % 2 ? pair->body_a : pair->body_b;
            if (other != NONE && !body_dynamic(w, other))
                DIG_TRY(add(&p->bodies, other));
        }
    return DIG_OK;
}

static dig_status add_dig(Taking *t, uint32_t body)
{
    const World *w = t->w;
    uint32_t lead = graph_lead(w->graph, body);
    if (map_find(&t->digs, map_key(lead), NULL))
        return DIG_OK;
    DIG_TRY(map_put(&t->digs, map_key(lead), 1));
    for (uint32_t m = lead; m != GRAPH_END; m = graph_next(w->graph, m)) {
        DIG_TRY(add(&t->p->bodies, m));
        DIG_TRY(add_grounds(w, t->p, m));
    }
    return DIG_OK;
}

static bool found(void *context, uint32_t solid)
{
    Taking *t = context;
    uint32_t body = t->w->solids.data[solid].body;
    if (body != NONE)
        t->status = body_dynamic(t->w, body) ? add_dig(t, body) : add(&t->p->bodies, body);
    return t->status == DIG_OK;
}

static dig_status find_bodies(Taking *t, uint32_t body, real far)
{
    const World *w = t->w;
    Part *p = t->p;
    uint32_t lead = graph_lead(w->graph, body);
    p->around = box_of(w, &w->bodies.data[lead]);
    for (uint32_t m = lead; m != GRAPH_END; m = graph_next(w->graph, m))
        p->around = box3_union(p->around, box_of(w, &w->bodies.data[m]));
    p->around = box3_grow(p->around, far);
    DIG_TRY(add_dig(t, body));
    tree_query(&w->tree, p->around, found, t);
    DIG_TRY(t->status);
    for (int i = 0; i < w->unbounded.count; i++) {
        uint32_t solid = w->unbounded.data[i];
        DIG_TRY(w->solids.data[solid].body == NONE ? add(&p->solids, solid) : add(&p->bodies, w->solids.data[solid].body));
    }
    return tidy(&p->bodies, &p->world->scratch);
}

/* A pair has an end that can move: it is found from there. */
static dig_status find_pairs(const World *w, Part *p)
{
    for (int i = 0; i < p->solids.count; i++) {
        const Solid *s = &w->solids.data[p->solids.data[i]];
        for (uint32_t l = body_dynamic(w, s->body) ? s->pair_first : NONE; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            if (place(&p->solids, l % 2 ? w->pairs.data[l / 2].solid_a : w->pairs.data[l / 2].solid_b) != NONE)
                DIG_TRY(add(&p->pairs, l / 2));
    }
    DIG_TRY(tidy(&p->pairs, &p->world->scratch));
    for (int i = 0; i < p->pairs.count; i++)
        for (uint32_t c = w->pairs.data[p->pairs.data[i]].contact; c != NONE; c = w->contacts.data[c].next)
            DIG_TRY(add(&p->contacts, c));
    return tidy(&p->contacts, &p->world->scratch);
}

static dig_status find_touches(const World *w, Part *p)
{
    for (int i = 0; i < p->links.count; i++) {
        const GraphLink *l = graph_link(w->graph, p->links.data[i]);
        if (l->kind == DIG_LINK_CONTACT)
            DIG_TRY(add(&p->touches, l->user));
    }
    for (int i = 0; i < p->bodies.count; i++)
        for (uint8_t wall = 1; wall <= 6 && w->has_room; wall++) {
            const Touch *t = touch_find(w, p->bodies.data[i], NONE, wall);
            if (t)
                DIG_TRY(add(&p->touches, (uint32_t)(t - w->touches.data)));
        }
    return tidy(&p->touches, &p->world->scratch);
}

static dig_status find_all(Taking *t, uint32_t body, real far)
{
    const World *w = t->w;
    Part *p = t->p;
    Arena *scratch = &p->world->scratch;
    DIG_TRY(find_bodies(t, body, far));
    DIG_TRY(tidy(&p->links, scratch));
    for (int i = 0; i < p->bodies.count; i++) {
        uint32_t slot = p->bodies.data[i];
        for (uint32_t s = w->bodies.data[slot].shape_first; s != NONE; s = w->solids.data[s].next)
            DIG_TRY(add(&p->solids, s));
        for (uint32_t j = body_dynamic(w, slot) ? w->bodies.data[slot].joint_first : NONE; j != NONE; j = joint_next(w, j, slot))
            DIG_TRY(add(&p->joints, j));
    }
    DIG_TRY(tidy(&p->solids, scratch));
    DIG_TRY(tidy(&p->joints, scratch));
    DIG_TRY(find_pairs(w, p));
    return find_touches(w, p);
}

/* ---- the copies ---- */

/* As long as the list of slots, and with room in the list of free ones for each. */
#define make_table(to, slots, free_list)                                                            \
    do {                                                                                            \
        DIG_TRY(list_reserve((to), (slots)->count, NULL));                                          \
        DIG_TRY(list_reserve((free_list), (to)->capacity, NULL));                                   \
        (to)->count = (slots)->count;                                                               \
    } while (0)

static dig_status copy_bodies(const World *w, const Part *p)
{
    World *to = p->world;
    make_table(&to->bodies, &p->bodies, &to->free_bodies);
    DIG_TRY(bodies_rest(to));
    DIG_TRY(list_reserve(&to->awake, to->bodies.capacity, NULL));
    DIG_TRY(list_reserve(&to->parent, to->bodies.capacity, NULL));
    to->parent.count = to->bodies.capacity;
    memset(to->parent.data, 0xff, (size_t)to->parent.count * sizeof *to->parent.data);
    for (int i = 0; i < p->bodies.count; i++) {
        Body *b = &to->bodies.data[i];
        *b = w->bodies.data[p->bodies.data[i]];
        body_shares_keep(b);
        if (b->rests)
            to->rest.data[i] = w->rest.data[p->bodies.data[i]];
        if (b->crowded)
            to->drifts.data[i] = w->drifts.data[p->bodies.data[i]];
        b->shape_first = place(&p->solids, b->shape_first);
        b->joint_first = NONE;
        b->message_from = (dig_body){0, 0};
        if (b->listed)
            to->awake.data[to->awake.count++] = (uint32_t)i;
    }
    return DIG_OK;
}

static dig_status copy_solids(const World *w, const Part *p)
{
    World *to = p->world;
    make_table(&to->solids, &p->solids, &to->free_solids);
    DIG_TRY(list_reserve(&to->asking, to->solids.capacity, NULL));
    DIG_TRY(tree_reserve(&to->tree, to->solids.count));
    for (int i = 0; i < p->solids.count; i++) {
        Solid *s = &to->solids.data[i];
        *s = w->solids.data[p->solids.data[i]];
        share_keep(s->form);
        s->body = s->body == NONE ? NONE : place(&p->bodies, s->body);
        s->next = s->next == NONE ? NONE : place(&p->solids, s->next);
        s->pair_first = NONE;
        if (s->leaf >= 0)
            DIG_TRY(tree_insert(&to->tree, tree_box(&w->tree, s->leaf), (uint32_t)i, &s->leaf));
        if (s->asks)
            to->asking.data[to->asking.count++] = (uint32_t)i;
    }
    DIG_TRY(list_reserve(&to->unbounded, w->unbounded.count, NULL));
    for (int i = 0; i < w->unbounded.count; i++)
        to->unbounded.data[to->unbounded.count++] = place(&p->solids, w->unbounded.data[i]);
    for (int i = 0; i < 6; i++)
        to->room_solid[i] = w->has_room && w->room_solid[i] != NONE ? place(&p->solids, w->room_solid[i]) : w->room_solid[i];
    return DIG_OK;
}

static dig_status copy_pairs(const World *w, const Part *p)
{
    World *to = p->world;
    make_table(&to->pairs, &p->pairs, &to->free_pairs);
    make_table(&to->contacts, &p->contacts, &to->free_contacts);
    DIG_TRY(contacts_rest(to));
    DIG_TRY(list_reserve(&to->near, p->pairs.count, NULL));
    DIG_TRY(index_reserve(&to->pair_index, p->pairs.count));
    for (int i = 0; i < p->contacts.count; i++) {
        Contact *c = &to->contacts.data[i];
        *c = w->contacts.data[p->contacts.data[i]];
        if (c->rests)
            to->contact_rest.data[i] = w->contact_rest.data[p->contacts.data[i]];
        c->next = place(&p->contacts, c->next);
        uint32_t more = c->more;
        c->more = NONE;
        if (more == NONE)
            continue;
        DIG_TRY(contact_widen(to, c));
        to->more.data[c->more] = w->more.data[more];
    }
    for (int i = 0; i < p->pairs.count; i++) {
        Pair *pair = &to->pairs.data[i];
        *pair = w->pairs.data[p->pairs.data[i]];
        pair->solid_a = place(&p->solids, pair->solid_a);
        pair->solid_b = place(&p->solids, pair->solid_b);
        pair->body_a = to->solids.data[pair->solid_a].body;
        pair->body_b = to->solids.data[pair->solid_b].body;
        pair->contact = place(&p->contacts, pair->contact);
        pair->memory = NONE;
        uint32_t memory = w->pairs.data[p->pairs.data[i]].memory;
        if (memory != NONE) {
            DIG_TRY(pair_remember(to, pair));
            to->memories.data[pair->memory] = w->memories.data[memory];
        }
        pair_attach(to, (uint32_t)i);
        DIG_TRY(pair_enter(to, (uint32_t)i));
        if (pair->listed)
            to->near.data[to->near.count++] = (uint32_t)i;
    }
    return DIG_OK;
}

static dig_status copy_touches(const World *w, const Part *p)
{
    World *to = p->world;
    make_table(&to->touches, &p->touches, &to->free_touches);
    DIG_TRY(list_reserve(&to->brief, to->touches.capacity, NULL));
    DIG_TRY(index_reserve(&to->touch_index, p->touches.count));
    for (int i = 0; i < p->touches.count; i++) {
        Touch *t = &to->touches.data[i];
        *t = w->touches.data[p->touches.data[i]];
        t->body_a = place(&p->bodies, t->body_a);
        t->body_b = t->body_b == NONE ? NONE : place(&p->bodies, t->body_b);
        t->link = NONE;
        DIG_TRY(touch_enter(to, (uint32_t)i));
        if (t->brief)
            to->brief.data[to->brief.count++] = (uint32_t)i;
    }
    return DIG_OK;
}

static dig_status copy_joints(const World *w, const Part *p)
{
    World *to = p->world;
    make_table(&to->joints, &p->joints, &to->free_joints);
    for (int i = 0; i < p->joints.count; i++) {
        JointRec *j = &to->joints.data[i];
        *j = w->joints.data[p->joints.data[i]];
        j->a = j->a == NONE ? NONE : place(&p->bodies, j->a);
        j->b = j->b == NONE ? NONE : place(&p->bodies, j->b);
        j->link = j->next_a = j->next_b = NONE;
        for (int k = 0; k < 2 && j->other[k] != NONE; k++) {
            j->other[k] = place(&p->joints, j->other[k]);
            ((dig_joint *)(void *)j->params)[k].slot = j->other[k];
        }
        joint_attach(to, (uint32_t)i);
    }
    return DIG_OK;
}

/* DIGs get numbers of their own. */
static dig_status copy_graph(const World *w, const Part *p)
{
    World *to = p->world;
    Graph *g = to->graph;
    DIG_TRY(graph_reserve(g, to->bodies.count, p->links.count));
    for (int i = 0; i < to->bodies.count; i++)
        if (body_dynamic(to, (uint32_t)i))
            DIG_TRY(graph_node_add(g, (uint32_t)i));
    graph_begin(g);
    for (int i = 0; i < p->links.count; i++) {
        const GraphLink *l = graph_link(w->graph, p->links.data[i]);
        bool touch = l->kind == DIG_LINK_CONTACT;
        uint32_t user = place(touch ? &p->touches : &p->joints, l->user), link;
        DIG_TRY(graph_link_add(g, place(&p->bodies, l->a), place(&p->bodies, l->b), l->bound, l->kind, user, l->began, &link));
        *(touch ? &to->touches.data[user].link : &to->joints.data[user].link) = link;
    }
    DIG_TRY(graph_end(g));
    for (int i = 0; i < to->bodies.count && w->dig_accuracies; i++)
        if (body_dynamic(to, (uint32_t)i))
            graph_set_user(g, graph_of(g, (uint32_t)i), graph_user_of(w->graph, p->bodies.data[i]));
    return DIG_OK;
}

static dig_status copy_acts(const World *w, const Part *p)
{
    World *to = p->world;
    for (int i = 0; i < w->pushes.count; i++) {
        uint32_t body = place(&p->bodies, w->pushes.data[i].body);
        if (body == NONE)
            continue;
        DIG_TRY(list_push(&to->pushes, NULL));
        to->pushes.data[to->pushes.count - 1] = w->pushes.data[i];
        to->pushes.data[to->pushes.count - 1].body = body;
    }
    DIG_TRY(api_copy_effects(to, w));
    for (int i = 0; i < w->effect_count; i++)
        for (int k = 0; k < p->bodies.count; k++) {
            const void *member = column_find(&w->effects[i].members, p->bodies.data[k]);
            if (member)
                DIG_TRY(column_add(&to->effects[i].members, (uint32_t)k, member, NULL));
        }
    DIG_TRY(list_copy(&to->materials, &w->materials, NULL));
    DIG_TRY(list_copy(&to->material_pairs, &w->material_pairs, NULL));
    to->paired = w->paired;
    DIG_TRY(list_reserve(&to->free_regions, w->regions.capacity, NULL));
    DIG_TRY(list_copy(&to->regions, &w->regions, NULL));
    for (int i = 0; i < to->regions.count; i++)
        if (to->regions.data[i].alive)
            to->regions.data[i].shape = shape_keep(&w->regions.data[i].shape);
    return DIG_OK;
}

/* The ledger counts from nowhere: nobody reads it. */
static void copy_numbers(World *to, const World *from)
{
    to->accuracy = from->accuracy;
    to->dig_accuracies = from->dig_accuracies;
    to->steps = from->steps;
    to->rng = from->rng;
    to->region_count = from->region_count;
    to->room = from->room;
    to->has_room = from->has_room;
    to->ledger.started = true;
}

static dig_status copy_all(const World *w, const Part *p)
{
    copy_numbers(p->world, w);
    DIG_TRY(copy_bodies(w, p));
    DIG_TRY(copy_solids(w, p));
    DIG_TRY(copy_pairs(w, p));
    DIG_TRY(copy_touches(w, p));
    DIG_TRY(copy_joints(w, p));
    DIG_TRY(copy_graph(w, p));
    p->world->tally = world_tally(p->world);
    return copy_acts(w, p);
}

/* ---- the calls ---- */

static bool sees_all(const World *w)
{
    for (int i = 0; i < w->effect_count; i++)
        if (w->effects[i].owner)
            return true;
    return false;
}

dig_status part_take(const World *w, uint32_t body, real far, Part *out)
{
    char why[64];
    *out = (Part){.whole = sees_all(w)};
    if (out->whole)
        return api_clone(w, &out->world);
    DIG_TRY(world_open(&w->def, &out->world, why, sizeof why));
    Taking t = {.w = w, .p = out};
    dig_status s = find_all(&t, body, far);
    if (s == DIG_OK)
        s = copy_all(w, out);
    map_close(&t.digs);
    if (s != DIG_OK)
        part_close(out);
    return s;
}

void part_close(Part *p)
{
    Slots *lists[] = {&p->bodies, &p->solids, &p->pairs, &p->contacts, &p->touches, &p->joints, &p->links};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        list_close(lists[i]);
    dig_world_close(p->world);
    p->world = NULL;
}

uint32_t part_body(const Part *p, uint32_t slot) { return p->whole ? slot : place(&p->bodies, slot); }
uint32_t part_body_from(const Part *p, uint32_t slot) { return p->whole || slot == NONE ? slot : p->bodies.data[slot]; }
uint32_t part_joint_from(const Part *p, uint32_t slot) { return p->whole || slot == NONE ? slot : p->joints.data[slot]; }

bool part_left(const Part *p, const World *now)
{
    for (int i = 0; i < now->bodies.count && !p->whole; i++) {
        const Body *b = &now->bodies.data[i];
        if (b->kind != DIG_DYNAMIC || !b->awake || vec3_distance(b->x, p->world->bodies.data[i].x) < STILL)
            continue;
        vec3 out = {b->outer, b->outer, b->outer};
        if (!box3_inside(p->around, (box3){vec3_sub(b->x, out), vec3_add(b->x, out)}))
            return true;
    }
    return false;
}
