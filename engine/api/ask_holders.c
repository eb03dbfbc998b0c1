/* api/ask_holders.c - what holds it? That without which it would move: its links are taken away one by one, the firmest first. And what
 * holds that? Its links are taken away in the same manner, up to what stands firm.
 *
 * A joint that leaves an axis free guides what the body does as well as it holds it: without its hinge a door gets round what stands in
 * its way. So what the body touches is taken away before such joints are.
 */
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

/* All that follow but for what leads back to the chain so far. */
static bool in_chain(const dig_answer *a, dig_part p)
{
    bool found = false;
    for (int i = 0; i < a->chain_count && !found; i++)
        found = p.joint.gen ? a->chain[i].joint.slot == p.joint.slot && a->chain[i].joint.gen
                            : p.body.gen && a->chain[i].body.gen && a->chain[i].body.slot == p.body.slot;
    return found;
}

static void add_joints(Links *list, const Ask *k, uint32_t body, int rank)
{
    const World *w = k->part.world;
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
        const JointType *type = w->joints.data[j].type;
        int own = type->free_axes == 0 ? FAST : at_limit(w, j) ? AT_LIMIT : type->couples ? COUPLES : LOOSE;
        dig_part part = {.joint = joint_handle(w, j)};
        if (own == rank && !in_chain(k->a, part))
            add_link(list, part);
    }
}

/* What it touches: that which moves, or else what does not, walls too. */
static void add_touches(Links *list, const Ask *k, uint32_t body, bool moving)
{
    const World *w = k->part.world;
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!t->alive || t->pairs == 0 || (t->body_a != body && t->body_b != body))
            continue;
        uint32_t other = t->body_a == body ? t->body_b : t->body_a;
        dig_part part = {.wall = t->wall};
        if (other != NONE)
            part = (dig_part){.body = body_handle(w, other)};
        if ((other != NONE && w->bodies.data[other].kind == DIG_DYNAMIC) == moving && !in_chain(k->a, part))
            add_link(list, part);
    }
}

static void list_links(const Ask *k, uint32_t body, Links *list)
{
    list->count = 0;
    add_joints(list, k, body, FAST);
    add_touches(list, k, body, true);
    add_touches(list, k, body, false);
    add_joints(list, k, body, AT_LIMIT);
    add_joints(list, k, body, COUPLES);
    add_joints(list, k, body, LOOSE);
}

/* Who need not be taken away for it to start is no holder. */
static dig_status drop_bystanders(Ask *k, real push, dig_part *parts, int *count)
{
    for (int i = *count - 1; i >= 0 && *count > 1; i--) {
        dig_part without[ASK_LINKS];
        bool does;
        memcpy(without, parts, (size_t)i * sizeof *parts);
        memcpy(without + i, parts + i + 1, (size_t)(*count - 1 - i) * sizeof *parts);
        DIG_TRY(ask_starts_without(k, push, without, *count - 1, &does));
        if (does)
            memcpy(parts, without, (size_t)--*count * sizeof *parts);
    }
    return DIG_OK;
}

dig_status ask_holders(Ask *k, real push)
{
    dig_answer *a = k->a;
    bool does = false;
    Links list;
    list_links(k, k->body, &list);
    k->linked = list.count > 0;
    for (int i = 0; i < list.count && !does; i++) {
        DIG_TRY(ask_starts_without(k, push, &list.part[i], 1, &does));
        if (does)
            a->held[a->held_count++] = list.part[i];
    }
    for (int n = 2; n <= list.count && !does; n++) {
        DIG_TRY(ask_starts_without(k, push, list.part, n, &does));
        list.count = does ? n : list.count;
    }
    if (does && a->held_count == 0) {
        DIG_TRY(drop_bystanders(k, push, list.part, &list.count));
        a->held_count = int_min(list.count, DIG_ANSWER_PARTS);
        memcpy(a->held, list.part, (size_t)a->held_count * sizeof *list.part);
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
    for (count--; count > 0; count--)           /* without `from`, who is in it */
        ask_add_chain(k->a, (dig_part){.body = body_handle(w, way[count - 1])});
    free(lists);
    return DIG_OK;
}

/* The link, and whom it leads to. NONE: nobody. */
static uint32_t follow(Ask *k, uint32_t from, dig_part p)
{
    ask_add_chain(k->a, p);
    if (!p.joint.gen)
        return p.wall ? NONE : p.body.slot;
    const JointRec *r = &k->part.world->joints.data[p.joint.slot];
    uint32_t next = r->a == from ? r->b : r->a;
    if (next != NONE)
        ask_add_chain(k->a, (dig_part){.body = body_handle(k->part.world, next)});
    return next;
}

/* What holds the one that holds? That without which, and without the other holders, the push would start the body. A single link needs
 * no trial. *found false: none, by at most `trials` of them. */
static dig_status find_next(Ask *k, real push, uint32_t node, int *trials, dig_part *next, bool *found)
{
    const dig_answer *a = k->a;
    dig_part without[DIG_ANSWER_PARTS];
    Links list;
    *found = false;
    list_links(k, node, &list);
    memcpy(without, a->held, sizeof without);
    for (int i = 0; i < list.count && !*found && (list.count == 1 || *trials > 0); i++) {
        *next = without[0] = list.part[i];
        *found = list.count == 1;
        *trials -= !*found;
        if (!*found)
            DIG_TRY(ask_starts_without(k, push, without, a->held_count, found));
    }
    return DIG_OK;
}

dig_status ask_chain(Ask *k, real push)
{
    const World *w = k->part.world;
    dig_answer *a = k->a;
    int trials = ASK_LINKS;
    ask_add_chain(a, (dig_part){.body = body_handle(w, k->body)});
    uint32_t node = a->held_count > 0 ? follow(k, k->body, a->held[0]) : NONE;
    while (node != NONE && graph_has_node(w->graph, node) && a->chain_count < DIG_ANSWER_PARTS) {
        dig_part next;
        bool found;
        DIG_TRY(find_next(k, push, node, &trials, &next, &found));
        if (!found)
            return chain_to_ground(k, node);
        node = follow(k, node, next);
    }
    return DIG_OK;
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
        if (body_name(w, b)[0])
            snprintf(text, capacity, "body '%s'", body_name(w, b));
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

/* Of one holder, who stands firm behind it, if that is somebody else. */
static void name_backing(const Ask *k, char *text, size_t capacity)
{
    const dig_answer *a = k->a;
    char name[100];
    if (a->held_count != 1 || a->chain_count < 3 || !a->held[0].body.gen)
        return;
    dig_part last = a->chain[a->chain_count - 1];
    if (last.body.gen && graph_has_node(k->part.world->graph, last.body.slot))
        return;
    name_part(k, last, name, sizeof name);
    snprintf(text, capacity, ", itself held by %s,", name);
}

const char *ask_name_holders(const Ask *k, char *text, size_t capacity)
{
    size_t at = 0;
    snprintf(text, capacity, only_weight_holds(k) ? "its weight" : k->linked ? "what it hangs on" : "its own inertia");
    for (int i = 0; i < k->a->held_count && at < capacity; i++) {
        char name[100];
        name_part(k, k->a->held[i], name, sizeof name);
        at += (size_t)snprintf(text + at, capacity - at, "%s%s", i ? " and " : "", name);
    }
    if (at < capacity)
        name_backing(k, text + at, capacity - at);
    return text;
}

void ask_add_broken(const Ask *k, char *text, size_t capacity)
{
    size_t at = strlen(text);
    for (int i = 0, count = 0; i < k->a->consequence_count && at < capacity; i++) {
        const dig_consequence *c = &k->a->consequences[i];
        char name[100];
        if (strcmp(c->what, "broken") != 0)
            continue;
        name_part(k, c->who, name, sizeof name);
        at += (size_t)snprintf(text + at, capacity - at, "%s%s", count++ ? " and " : ", and breaks ", name);
    }
}
