/* api/ask_holders.c - what holds it? That without which it would move: its links are taken away one by one, the firmest first. */
#include "api/ask.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct Links { dig_part part[ASK_LINKS]; int count; } Links;

/* ---- what it hangs on ---- */

static bool at_limit(const World *w, uint32_t joint)
{
    real memory[JOINT_MEMORY];
    JointView view;
    api_joint_view(w, joint, &view, memory);
    const JointType *type = w->joints.data[joint].type;
    return type->at_limit && type->at_limit(&view);
}

static void add_link(Links *list, dig_part p)
{
    if (list->count < ASK_LINKS)
        list->part[list->count++] = p;
}

/* The fast ones, those at a stop, couplings, the others. */
enum { FAST, AT_LIMIT, COUPLES, LOOSE };

static void add_joints(Links *list, const World *w, uint32_t body, int rank)
{
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
        const JointType *type = w->joints.data[j].type;
        int own = type->free_axes == 0 ? FAST : at_limit(w, j) ? AT_LIMIT : type->couples ? COUPLES : LOOSE;
        if (own == rank)
            add_link(list, (dig_part){.joint = joint_handle(w, j)});
    }
}

/* What it touches: that which moves, or else what does not, walls too. */
static void add_touches(Links *list, const World *w, uint32_t body, bool moving)
{
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!t->alive || t->pairs == 0 || (t->body_a != body && t->body_b != body))
            continue;
        uint32_t other = t->body_a == body ? t->body_b : t->body_a;
        dig_part wall = {.wall = t->wall}, part = {.body = body_handle(w, other)};
        if ((other != NONE && w->bodies.data[other].kind == DIG_DYNAMIC) == moving)
            add_link(list, other == NONE ? wall : part);
    }
}

static void list_links(const Ask *k, Links *list)
{
    const World *w = k->part.world;
    list->count = 0;
    add_joints(list, w, k->body, FAST);
    add_joints(list, w, k->body, AT_LIMIT);
    add_touches(list, w, k->body, true);
    add_joints(list, w, k->body, COUPLES);
    add_touches(list, w, k->body, false);
    add_joints(list, w, k->body, LOOSE);
}

dig_status ask_holders(Ask *k, real push)
{
    dig_answer *a = k->a;
    bool does = false;
    Links list;
    list_links(k, &list);
    for (int i = 0; i < list.count && !does; i++) {
        DIG_TRY(ask_starts_without(k, push, &list.part[i], 1, &does));
        if (does)
            a->held[a->held_count++] = list.part[i];
    }
    for (int n = 2; n <= list.count && !does; n++) {
        DIG_TRY(ask_starts_without(k, push, list.part, n, &does));
        for (int i = 0; does && i < int_min(n, DIG_ANSWER_PARTS); i++)
            a->held[a->held_count++] = list.part[i];
    }
    return DIG_OK;
}

/* ---- the way the message took ---- */

void ask_add_chain(dig_answer *a, dig_part p)
{
    if (a->chain_count < DIG_ANSWER_PARTS)
        a->chain[a->chain_count++] = p;
}

/* Breadth first along the links, from a body to the nearest that stands firm, without passing the one that asked. parent[]: where each
 * was reached from. NONE: there is none. */
static uint32_t find_ground(const Ask *k, uint32_t from, uint32_t *parent, uint32_t *queue)
{
    const World *w = k->part.world;
    int head = 0, tail = 0;
    memset(parent, 0xff, (size_t)w->bodies.count * sizeof *parent);
    parent[k->body] = k->body;
    parent[from] = from;
    queue[tail++] = from;
    while (head < tail) {
        uint32_t node = queue[head++];
        if (!graph_has_node(w->graph, node))
            return node;
        for (uint32_t l = graph_link_first(w->graph, node); l != GRAPH_END; l = graph_link_next(w->graph, node, l)) {
            const GraphLink *link = graph_link(w->graph, l);
            uint32_t next = link->a == node ? link->b : link->a;
            if (parent[next] == NONE) {
                parent[next] = node;
                queue[tail++] = next;
            }
        }
    }
    return NONE;
}

static dig_status chain_to_ground(Ask *k, uint32_t from)
{
    const World *w = k->part.world;
    uint32_t *lists = malloc(2 * (size_t)w->bodies.count * sizeof *lists), way[DIG_ANSWER_PARTS];
    if (!lists)
        return world_fail(k->w, DIG_E_MEMORY, "ask: not enough memory for the way to the ground");
    uint32_t found = find_ground(k, from, lists, lists + w->bodies.count);
    int count = 0;
    for (uint32_t b = found == NONE ? from : found; count < DIG_ANSWER_PARTS; b = lists[b]) {
        way[count++] = b;
        if (b == from)
            break;
    }
    while (count > 0)
        ask_add_chain(k->a, (dig_part){.body = body_handle(w, way[--count])});
    free(lists);
    return DIG_OK;
}

dig_status ask_chain(Ask *k)
{
    dig_answer *a = k->a;
    ask_add_chain(a, (dig_part){.body = body_handle(k->part.world, k->body)});
    if (a->held_count == 0)
        return DIG_OK;
    dig_part p = a->held[0];
    uint32_t next = p.body.slot;
    if (p.joint.gen) {
        const JointRec *r = &k->part.world->joints.data[p.joint.slot];
        ask_add_chain(a, p);
        next = r->a == k->body ? r->b : r->a;
    } else if (p.wall) {
        ask_add_chain(a, p);
        next = NONE;
    }
    return next != NONE ? chain_to_ground(k, next) : DIG_OK;
}

/* ---- names ---- */

static void name_part(const Ask *k, dig_part p, char *text, size_t capacity)
{
    const World *w = k->part.world;
    if (p.joint.gen) {
        const JointRec *r = &w->joints.data[p.joint.slot];
        snprintf(text, capacity, "%s%s%s%s", r->type->name, r->name[0] ? " '" : "", r->name, r->name[0] ? "'" : "");
    } else if (p.wall) {
        snprintf(text, capacity, "the wall %s of the room", wall_name(p.wall));
    } else {
        const Body *b = &w->bodies.data[p.body.slot];
        if (b->name[0])
            snprintf(text, capacity, "body '%s'", b->name);
        else
            snprintf(text, capacity, "body #%u", part_body_from(&k->part, p.body.slot));
    }
}

/* It is to go up, and no link has been found without which it would. */
static bool only_weight_holds(const Ask *k)
{
    const World *w = k->part.world;
    vec3 weight = vec3_scale(w->bodies.data[k->body].gravity_scale, w->def.gravity);
    return k->a->held_count == 0 && !k->q->turns && vec3_dot(weight, k->along) < 0;
}

const char *ask_name_holders(const Ask *k, char *text, size_t capacity)
{
    size_t at = 0;
    snprintf(text, capacity, only_weight_holds(k) ? "its weight" : "what it hangs on");
    for (int i = 0; i < k->a->held_count && at < capacity; i++) {
        char name[100];
        name_part(k, k->a->held[i], name, sizeof name);
        at += (size_t)snprintf(text + at, capacity - at, "%s%s", i ? " and " : "", name);
    }
    return text;
}
