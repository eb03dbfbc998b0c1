/* api/dig.c - dynamic interaction graphs: membership, links, neighbours, paths, in all layers. */
#include "api/api.h"
#include "api/command.h"

#include <stdlib.h>

dig_dig dig_of_layer(const dig_world *w, dig_body b, uint32_t layer)
{
    const Graph *g = layer_graph(w, layer);
    return (dig_dig){g && world_body(w, b) ? graph_of(g, b.slot) : GRAPH_NONE, layer};
}

dig_dig dig_of(const dig_world *w, dig_body b) { return dig_of_layer(w, b, DIG_LAYER_MECHANICAL); }

/* Its graph and how many members it has; 0: it is no more. */
static int size_of(const World *w, dig_dig d, const Graph **g)
{
    *g = layer_graph(w, d.layer);
    return *g ? graph_size(*g, d.id) : 0;
}

/* Awake when one of its members is: in the mechanical layer all or none are. */
dig_status dig_dig_get(const dig_world *w, dig_dig d, dig_dig_state *out)
{
    const Graph *g;
    int size = size_of(w, d, &g);
    if (size == 0)
        return world_fail(w, DIG_E_DEAD, "DIG %u is no more", d.id);
    int accuracy = d.layer == DIG_LAYER_MECHANICAL ? int_max(w->accuracy, (int)graph_user(g, d.id)) : w->accuracy;
    *out = (dig_dig_state){.size = size, .plan = accuracy_plan(accuracy)->name};
    for (uint32_t m = graph_first(g, d.id); m != NONE; m = graph_next(g, m)) {
        out->awake |= w->bodies.data[m].awake && w->bodies.data[m].kind != DIG_STATIC;
        out->energy += body_energy(w, &w->bodies.data[m]);
    }
    return DIG_OK;
}

static int compare_digs(const void *a, const void *b)
{
    const dig_dig *x = a, *y = b;
    return x->id < y->id ? -1 : x->id > y->id;
}

int dig_digs(const dig_world *w, dig_dig *out, int capacity) { return dig_digs_of_layer(w, DIG_LAYER_MECHANICAL, out, capacity); }

int dig_digs_of_layer(const dig_world *w, uint32_t layer, dig_dig *out, int capacity)
{
    const Graph *g = layer_graph(w, layer);
    int count = g ? graph_count(g) : 0, n = int_min(count, capacity);
    for (int i = 0; i < n; i++)
        out[i] = (dig_dig){graph_by_index(g, i), layer};
    if (n > 1)
        qsort(out, (size_t)n, sizeof *out, compare_digs);
    return count;
}

static int compare_bodies(const void *a, const void *b)
{
    const dig_body *x = a, *y = b;
    return x->slot < y->slot ? -1 : x->slot > y->slot;
}

int dig_members(const dig_world *w, dig_dig d, dig_body *out, int capacity)
{
    const Graph *g;
    int n = 0;
    for (uint32_t m = size_of(w, d, &g) ? graph_first(g, d.id) : NONE; m != NONE; m = graph_next(g, m)) {
        if (n < capacity)
            out[n] = body_handle(w, m);
        n++;
    }
    if (n <= capacity && n > 1)
        qsort(out, (size_t)n, sizeof *out, compare_bodies);
    return n;
}

static dig_status do_set_accuracy(World *w, dig_dig d, const char *plan, real tolerance)
{
    if (!plan && !(tolerance > 0 && tolerance <= 1))
        return world_fail(w, DIG_E_ARG, "accuracy = %g m, must be > 0 and at most 1 m", tolerance);
    int accuracy = plan ? accuracy_find(plan) : accuracy_for(tolerance);
    if (accuracy == 0)
        return world_fail(w, DIG_E_ARG, "accuracy = '%s', must be sketch, play, study, reference or a length", plan);
    if (d.layer != DIG_LAYER_MECHANICAL)
        return world_fail(w, DIG_E_KIND, "accuracy: DIG %u is of the %s layer, only mechanical ones are advanced", d.id, dig_layer_name(d.layer));
    if (graph_size(w->graph, d.id) == 0)
        return world_fail(w, DIG_E_DEAD, "DIG %u is no more", d.id);
    w->dig_accuracies = true;
    graph_set_user(w->graph, d.id, (uint64_t)accuracy);
    for (uint32_t m = graph_first(w->graph, d.id); m != NONE; m = graph_next(w->graph, m))
        w->bodies.data[m].accuracy = (uint8_t)accuracy;
    return DIG_OK;
}

dig_status run_dig_accuracy(World *w, CommandArg *a)
{
    return do_set_accuracy(w, a[0].dig, a[1].what, a[2].number);
}

dig_status dig_dig_accuracy(dig_world *w, dig_dig d, const char *plan, real tolerance)
{
    return COMMAND(w, COMMAND_DIG_ACCURACY, do_set_accuracy(w, d, plan, tolerance), {.dig = d}, {.what = plan}, {.number = tolerance});
}

/* ---- links ---- */

typedef struct Bearing { vec3 force, point; real weight; } Bearing;

/* What the contacts of a pair do to the touch's body b. */
static void add_pair(const World *w, const Touch *t, const Pair *p, Bearing *sum, dig_link *link)
{
    real sign = p->body_a == t->body_a ? 1 : -1;
    for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next) {
        const Contact *contact = &w->contacts.data[c];
        if (!contact->touching)
            continue;
        sum->force = vec3_mad(sum->force, sign, contact->force);
        real share = vec3_length(contact->force) + 1e-30;
        sum->point = vec3_mad(sum->point, share, contact->point);
        sum->weight += share;
        link->normal = vec3_scale(sign, contact->normal);
    }
}

static void fill_contact(const World *w, const Touch *t, dig_link *link)
{
    Bearing sum = {vec3_zero(), vec3_zero(), 0};
    uint32_t pair;
    if (t->body_b != NONE && pair_between(w, t->body_a, t->body_b, &pair)) {
        if (pair != NONE && w->pairs.data[pair].touching)
            add_pair(w, t, &w->pairs.data[pair], &sum, link);
    } else {
        const Body *b = &w->bodies.data[t->body_a];
        for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
            for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
                const Pair *p = &w->pairs.data[l / 2];
                if (p->touching && (p->body_a == t->body_b || p->body_b == t->body_b))
                    add_pair(w, t, p, &sum, link);
            }
    }
    link->effort = sum.force;
    link->point = sum.weight > 0 ? vec3_scale(1 / sum.weight, sum.point) : vec3_zero();
}

static vec3 velocity_at(const World *w, uint32_t body, vec3 at)
{
    if (body == NONE)
        return vec3_zero();
    const Body *b = &w->bodies.data[body];
    return vec3_add(b->v, vec3_cross(b->w, vec3_sub(at, b->x)));
}

static void fill_wire(const World *w, uint32_t layer, const GraphLink *l, dig_link *out)
{
    const LayerLink *k = &w->layers[layer].links.data[l->user];
    *out = (dig_link){.a = body_handle(w, k->a), .b = body_handle(w, k->b), .kind = (dig_link_kind)l->kind, .began = l->began, .bound = l->bound,
                      .effort = {k->effort, 0, 0}, .flow = {k->flow, 0, 0}, .power = k->effort * k->flow, .layer = layer};
    vec3 from = w->bodies.data[k->a].x, to = w->bodies.data[k->b].x, along = vec3_sub(to, from);
    out->point = vec3_lerp(from, to, 0.5);
    out->normal = vec3_length(along) > 0 ? vec3_unit(along) : vec3_zero();
}

static void fill_link(const World *w, uint32_t layer, const GraphLink *l, dig_link *out)
{
    if (layer != DIG_LAYER_MECHANICAL) {
        fill_wire(w, layer, l, out);
        return;
    }
    memset(out, 0, sizeof *out);
    out->kind = (dig_link_kind)l->kind;
    out->began = l->began;
    out->bound = l->bound;
    uint32_t a, b;
    if (l->kind == DIG_LINK_CONTACT) {
        const Touch *t = &w->touches.data[l->user];
        a = t->body_a;
        b = t->body_b;
        fill_contact(w, t, out);
    } else {
        const JointRec *r = &w->joints.data[l->user];
        real memory[JOINT_MEMORY];
        JointView view;
        a = r->a;
        b = r->b;
        out->joint = joint_handle(w, l->user);
        api_joint_view(w, l->user, &view, memory);
        out->effort = vec3_neg(r->force);
        out->point = view.a.p;
        out->normal = view.a.axis;
    }
    out->a = body_handle(w, a);
    out->b = body_handle(w, b);
    out->flow = vec3_sub(velocity_at(w, b, out->point), velocity_at(w, a, out->point));
    out->power = vec3_dot(out->effort, out->flow);
}

void api_link(const World *w, uint32_t layer, uint32_t link, dig_link *out)
{
    fill_link(w, layer, graph_link(layer_graph(w, layer), link), out);
}

/* Static bodies are no nodes: their mechanical links are found through touches and joints. */
static int links_of_static(const World *w, uint32_t body, dig_link *out, int capacity)
{
    int n = 0;
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!t->alive || t->link == NONE || (t->body_a != body && t->body_b != body))
            continue;
        if (n < capacity)
            fill_link(w, DIG_LAYER_MECHANICAL, graph_link(w->graph, t->link), &out[n]);
        n++;
    }
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
        if (w->joints.data[j].link == NONE)
            continue;
        if (n < capacity)
            fill_link(w, DIG_LAYER_MECHANICAL, graph_link(w->graph, w->joints.data[j].link), &out[n]);
        n++;
    }
    return n;
}

/* A boundary of a layer is no node there. */
static int links_of_boundary(const World *w, uint32_t layer, uint32_t body, dig_link *out, int capacity)
{
    const Layer *l = &w->layers[layer];
    int n = 0;
    for (int i = 0; i < l->links.count; i++) {
        if (!l->links.data[i].alive || l->links.data[i].b != body)
            continue;
        if (n < capacity)
            fill_link(w, layer, graph_link(l->graph, l->links.data[i].link), &out[n]);
        n++;
    }
    return n;
}

int dig_links_of_layer(const dig_world *w, dig_body b, uint32_t layer, dig_link *out, int capacity)
{
    const Graph *g = layer_graph(w, layer);
    int n = 0;
    if (!g || !world_body(w, b))
        return 0;
    if (!graph_has_node(g, b.slot))
        return layer == DIG_LAYER_MECHANICAL ? links_of_static(w, b.slot, out, capacity) : links_of_boundary(w, layer, b.slot, out, capacity);
    for (uint32_t l = graph_link_first(g, b.slot); l != NONE; l = graph_link_next(g, b.slot, l)) {
        if (n < capacity)
            fill_link(w, layer, graph_link(g, l), &out[n]);
        n++;
    }
    return n;
}

int dig_links_of(const dig_world *w, dig_body b, dig_link *out, int capacity) { return dig_links_of_layer(w, b, DIG_LAYER_MECHANICAL, out, capacity); }

int dig_links_in(const dig_world *w, dig_dig d, dig_link *out, int capacity)
{
    const Graph *g;
    int n = 0;
    for (uint32_t m = size_of(w, d, &g) ? graph_first(g, d.id) : NONE; m != NONE; m = graph_next(g, m))
        for (uint32_t l = graph_link_first(g, m); l != NONE; l = graph_link_next(g, m, l)) {
            const GraphLink *link = graph_link(g, l);
            if (link->a != m)
                continue;                   /* once, at its first end */
            if (n < capacity)
                fill_link(w, d.layer, link, &out[n]);
            n++;
        }
    return n;
}

int api_add_unique(dig_body *out, int n, int capacity, dig_body b)
{
    for (int i = 0; i < int_min(n, capacity); i++)
        if (out[i].slot == b.slot)
            return n;
    if (n < capacity)
        out[n] = b;
    return n + 1;
}

static int neighbours(const World *w, dig_body b, uint32_t layer, int kind, dig_body *out, int capacity)
{
    int count = dig_links_of_layer(w, b, layer, NULL, 0), n = 0;
    dig_link *links = malloc((size_t)(count + 1) * sizeof *links);
    if (!links)
        return 0;
    dig_links_of_layer(w, b, layer, links, count);
    for (int i = 0; i < count; i++)
        if (kind < 0 || (int)links[i].kind == kind)
            n = api_add_unique(out, n, capacity, links[i].a.slot == b.slot ? links[i].b : links[i].a);
    free(links);
    if (n <= capacity && n > 1)
        qsort(out, (size_t)n, sizeof *out, compare_bodies);
    return n;
}

int dig_neighbours(const dig_world *w, dig_body b, int kind, dig_body *out, int capacity)
{
    return neighbours(w, b, DIG_LAYER_MECHANICAL, kind, out, capacity);
}

int dig_neighbours_in_layer(const dig_world *w, dig_body b, uint32_t layer, dig_body *out, int capacity)
{
    return neighbours(w, b, layer, -1, out, capacity);
}

/* ---- shortest path, breadth first; a static body may end it but never be passed ---- */

static uint32_t other_end(const GraphLink *l, uint32_t node) { return l->a == node ? l->b : l->a; }

static bool search_path(const Graph *g, uint32_t from, uint32_t to, int kind, uint32_t *parent, uint32_t *queue)
{
    int head = 0, tail = 0;
    queue[tail++] = from;
    parent[from] = from;
    while (head < tail) {
        uint32_t node = queue[head++];
        if (node == to)
            return true;
        if (!graph_has_node(g, node))
            continue;
        for (uint32_t l = graph_link_first(g, node); l != NONE; l = graph_link_next(g, node, l)) {
            const GraphLink *link = graph_link(g, l);
            uint32_t next = other_end(link, node);
            if (parent[next] != NONE || (kind >= 0 && link->kind != kind))
                continue;
            parent[next] = node;
            queue[tail++] = next;
        }
    }
    return false;
}

static int find_path(const World *w, const Graph *g, dig_body from, dig_body to, int kind, dig_body *out, int capacity)
{
    if (!g || !world_body(w, from) || !world_body(w, to))
        return 0;
    bool reversed = !graph_has_node(g, from.slot);      /* a static start: search from the other end */
    uint32_t a = reversed ? to.slot : from.slot, b = reversed ? from.slot : to.slot;
    size_t slots = (size_t)w->bodies.count;
    uint32_t *parent = malloc(slots * sizeof *parent), *queue = malloc(slots * sizeof *queue);
    int n = 0;
    if (parent && queue && graph_has_node(g, a)) {
        for (size_t i = 0; i < slots; i++)
            parent[i] = NONE;
        if (search_path(g, a, b, kind, parent, queue)) {
            for (uint32_t node = b;; node = parent[node]) {     /* from b back to a */
                if (n < capacity)
                    out[n] = body_handle(w, node);
                n++;
                if (node == a)
                    break;
            }
            for (int i = 0; !reversed && n <= capacity && i < n / 2; i++) {
                dig_body t = out[i];
                out[i] = out[n - 1 - i];
                out[n - 1 - i] = t;
            }
        }
    }
    free(parent);
    free(queue);
    return n;
}

int dig_path(const dig_world *w, dig_body from, dig_body to, int kind, dig_body *out, int capacity)
{
    return find_path(w, w->graph, from, to, kind, out, capacity);
}

int dig_path_in_layer(const dig_world *w, dig_body from, dig_body to, uint32_t layer, dig_body *out, int capacity)
{
    return find_path(w, layer_graph(w, layer), from, to, -1, out, capacity);
}

bool dig_body_touches(const dig_world *w, dig_body a, dig_body b)
{
    if (!world_body(w, a) || !world_body(w, b))
        return false;
    const Touch *t = touch_find(w, a.slot, b.slot, 0);
    return t && (t->pairs > 0 || t->link != NONE);
}
