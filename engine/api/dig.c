/* api/dig.c - dynamic interaction graphs: membership, links, neighbours, paths; messages. */
#include "api/api.h"

#include <stdio.h>
#include <stdlib.h>

dig_dig dig_of(const dig_world *w, dig_body b)
{
    return (dig_dig){world_body(w, b) ? graph_of(w->graph, b.slot) : GRAPH_NONE, DIG_LAYER_MECHANICAL};
}

static real dig_energy_of(const World *w, uint32_t id)
{
    real sum = 0;
    for (uint32_t m = graph_first(w->graph, id); m != NONE; m = graph_next(w->graph, m))
        sum += body_energy(w, &w->bodies.data[m]);
    return sum;
}

dig_status dig_dig_get(const dig_world *w, dig_dig d, dig_dig_state *out)
{
    int size = graph_size(w->graph, d.id);
    if (size == 0)
        return world_fail(w, DIG_E_DEAD, "DIG %u is no more", d.id);
    int accuracy = int_max(w->accuracy, (int)graph_user(w->graph, d.id));
    *out = (dig_dig_state){size, w->bodies.data[graph_first(w->graph, d.id)].awake, dig_energy_of(w, d.id), accuracy_plan(accuracy)->name};
    return DIG_OK;
}

static int compare_digs(const void *a, const void *b)
{
    const dig_dig *x = a, *y = b;
    return x->id < y->id ? -1 : x->id > y->id;
}

int dig_digs(const dig_world *w, dig_dig *out, int capacity)
{
    int count = graph_count(w->graph), n = int_min(count, capacity);
    for (int i = 0; i < n; i++)
        out[i] = (dig_dig){graph_by_index(w->graph, i), DIG_LAYER_MECHANICAL};
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
    int n = 0;
    for (uint32_t m = graph_size(w->graph, d.id) ? graph_first(w->graph, d.id) : NONE; m != NONE; m = graph_next(w->graph, m)) {
        if (n < capacity)
            out[n] = body_handle(w, m);
        n++;
    }
    if (n <= capacity && n > 1)
        qsort(out, (size_t)n, sizeof *out, compare_bodies);
    return n;
}

dig_status dig_dig_accuracy(dig_world *w, dig_dig d, const char *plan, real tolerance)
{
    if (!plan && !(tolerance > 0 && tolerance <= 1))
        return world_fail(w, DIG_E_ARG, "accuracy = %g m, must be > 0 and at most 1 m", tolerance);
    int accuracy = plan ? accuracy_find(plan) : accuracy_for(tolerance);
    if (accuracy == 0)
        return world_fail(w, DIG_E_ARG, "accuracy = '%s', must be sketch, play, study, reference or a length", plan);
    if (graph_size(w->graph, d.id) == 0)
        return world_fail(w, DIG_E_DEAD, "DIG %u is no more", d.id);
    w->dig_accuracies = true;
    graph_set_user(w->graph, d.id, (uint64_t)accuracy);
    for (uint32_t m = graph_first(w->graph, d.id); m != NONE; m = graph_next(w->graph, m))
        w->bodies.data[m].accuracy = (uint8_t)accuracy;
    return DIG_OK;
}

/* ---- links ---- */

static void fill_contact(const World *w, const Touch *t, dig_link *link)
{
    vec3 force = vec3_zero(), point = vec3_zero();
    real weight = 0;
    const Body *b = &w->bodies.data[t->body_a];
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            if (!p->touching || (p->body_a != t->body_b && p->body_b != t->body_b))
                continue;
            real sign = p->body_a == t->body_a ? 1 : -1;       /* effort acts on link->b = t->body_b */
            for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next) {
                const Contact *contact = &w->contacts.data[c];
                if (!contact->touching)
                    continue;
                force = vec3_mad(force, sign, contact->force);
                real share = vec3_length(contact->force) + 1e-30;
                point = vec3_mad(point, share, contact->point);
                weight += share;
                link->normal = vec3_scale(sign, contact->manifold.normal);
            }
        }
    link->effort = force;
    link->point = weight > 0 ? vec3_scale(1 / weight, point) : t->point;
}

static vec3 velocity_at(const World *w, uint32_t body, vec3 at)
{
    if (body == NONE)
        return vec3_zero();
    const Body *b = &w->bodies.data[body];
    return vec3_add(b->v, vec3_cross(b->w, vec3_sub(at, b->x)));
}

static void fill_link(const World *w, const GraphLink *l, dig_link *out)
{
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

int dig_links_of(const dig_world *w, dig_body b, dig_link *out, int capacity)
{
    int n = 0;
    if (!world_body(w, b))
        return 0;
    if (w->bodies.data[b.slot].kind != DIG_DYNAMIC) {      /* no node: its links are listed at the other ends */
        for (int i = 0; i < w->touches.count; i++) {
            const Touch *t = &w->touches.data[i];
            if (!t->alive || t->link == NONE || (t->body_a != b.slot && t->body_b != b.slot))
                continue;
            if (n < capacity)
                fill_link(w, graph_link(w->graph, t->link), &out[n]);
            n++;
        }
        for (uint32_t j = w->bodies.data[b.slot].joint_first; j != NONE; j = joint_next(w, j, b.slot)) {
            if (w->joints.data[j].link == NONE)
                continue;
            if (n < capacity)
                fill_link(w, graph_link(w->graph, w->joints.data[j].link), &out[n]);
            n++;
        }
        return n;
    }
    for (uint32_t l = graph_link_first(w->graph, b.slot); l != NONE; l = graph_link_next(w->graph, b.slot, l)) {
        if (n < capacity)
            fill_link(w, graph_link(w->graph, l), &out[n]);
        n++;
    }
    return n;
}

int dig_links_in(const dig_world *w, dig_dig d, dig_link *out, int capacity)
{
    int n = 0;
    for (uint32_t m = graph_size(w->graph, d.id) ? graph_first(w->graph, d.id) : NONE; m != NONE; m = graph_next(w->graph, m))
        for (uint32_t l = graph_link_first(w->graph, m); l != NONE; l = graph_link_next(w->graph, m, l)) {
            const GraphLink *link = graph_link(w->graph, l);
            if (link->a != m)
                continue;                   /* once, at its first end */
            if (n < capacity)
                fill_link(w, link, &out[n]);
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

int dig_neighbours(const dig_world *w, dig_body b, int kind, dig_body *out, int capacity)
{
    if (!world_body(w, b))
        return 0;
    int count = dig_links_of(w, b, NULL, 0), n = 0;
    dig_link *links = malloc((size_t)(count + 1) * sizeof *links);
    if (!links)
        return 0;
    dig_links_of(w, b, links, count);
    for (int i = 0; i < count; i++)
        if (kind < 0 || (int)links[i].kind == kind)
            n = api_add_unique(out, n, capacity, links[i].a.slot == b.slot ? links[i].b : links[i].a);
    free(links);
    if (n <= capacity && n > 1)
        qsort(out, (size_t)n, sizeof *out, compare_bodies);
    return n;
}

/* ---- shortest path, breadth first; a static body may end it but never be passed ---- */

static uint32_t other_end(const GraphLink *l, uint32_t node) { return l->a == node ? l->b : l->a; }

static bool search_path(const World *w, uint32_t from, uint32_t to, int kind, uint32_t *parent, uint32_t *queue)
{
    int head = 0, tail = 0;
    queue[tail++] = from;
    parent[from] = from;
    while (head < tail) {
        uint32_t node = queue[head++];
        if (node == to)
            return true;
        if (!graph_has_node(w->graph, node))
            continue;
        for (uint32_t l = graph_link_first(w->graph, node); l != NONE; l = graph_link_next(w->graph, node, l)) {
            const GraphLink *link = graph_link(w->graph, l);
            uint32_t next = other_end(link, node);
            if (parent[next] != NONE || (kind >= 0 && link->kind != kind))
                continue;
            parent[next] = node;
            queue[tail++] = next;
        }
    }
    return false;
}

int dig_path(const dig_world *w, dig_body from, dig_body to, int kind, dig_body *out, int capacity)
{
    if (!world_body(w, from) || !world_body(w, to))
        return 0;
    bool reversed = !graph_has_node(w->graph, from.slot);      /* a static start: search from the other end */
    uint32_t a = reversed ? to.slot : from.slot, b = reversed ? from.slot : to.slot;
    size_t slots = (size_t)w->bodies.count;
    uint32_t *parent = malloc(slots * sizeof *parent), *queue = malloc(slots * sizeof *queue);
    int n = 0;
    if (parent && queue && graph_has_node(w->graph, a)) {
        for (size_t i = 0; i < slots; i++)
            parent[i] = NONE;
        if (search_path(w, a, b, kind, parent, queue)) {
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

bool dig_body_touches(const dig_world *w, dig_body a, dig_body b)
{
    if (!world_body(w, a) || !world_body(w, b))
        return false;
    const Touch *t = touch_find(w, a.slot, b.slot, 0);
    return t && (t->pairs > 0 || t->link != NONE);
}

/* ---- messages ---- */

static dig_status post(World *w, dig_body from, dig_body to, const char *kind, const real value[4])
{
    dig_message m = {.time = world_time(w), .from = from, .to = to};
    if (!kind[0])
        return world_fail(w, DIG_E_ARG, "send: a message needs a kind that is not empty");
    snprintf(m.kind, sizeof m.kind, "%s", kind);
    if (value)
        memcpy(m.value, value, sizeof m.value);
    Body *b = &w->bodies.data[to.slot];
    uint64_t id = message_post(&w->messages, &m);
    if (id == 0)
        return world_fail(w, DIG_E_ARG, "message '%s': its values must be finite", kind);
    b->message_id = id;
    b->message_time = m.time;
    b->message_from = from;
    memcpy(b->message_kind, m.kind, sizeof b->message_kind);
    dig_event *e = event_post(w, DIG_EVENT_MESSAGE, to.slot, from.gen ? from.slot : NONE);
    if (e)
        e->message = id;
    return DIG_OK;
}

dig_status dig_message_send(dig_world *w, dig_body from, dig_body to, const char *kind, const real value[4])
{
    if (!api_body(w, to, "send") || (from.gen && !api_body(w, from, "send")))
        return DIG_E_DEAD;
    return post(w, from, to, kind, value);
}

dig_status dig_message_broadcast(dig_world *w, dig_dig d, dig_body from, const char *kind, const real value[4])
{
    if (graph_size(w->graph, d.id) == 0)
        return world_fail(w, DIG_E_DEAD, "broadcast: DIG %u is no more", d.id);
    for (uint32_t m = graph_first(w->graph, d.id); m != NONE; m = graph_next(w->graph, m))
        DIG_TRY(post(w, from, body_handle(w, m), kind, value));
    return DIG_OK;
}

int dig_messages(const dig_world *w, dig_message *out, int capacity) { return message_list(&w->messages, out, capacity); }
