/* step/deliver.c - who gets a message, and that they get it.
 *
 * A post is delivered all at once: first the receivers are found, each once, then the message is written down for each of them.
 * Nothing changes in between, so that membership is that of the moment of delivery. The route DIG needs no search and no marks:
 * it walks the list of members.
 *
 * A flood is a breadth-first search along the links of one layer. Links to static bodies do not carry it on, nor to them: else all
 * that stands on one floor would hear of each other. By ratio, the first value is multiplied by each link's ratio on the way; a
 * body that is reached again by another way must get the same value, else the ring of links contradicts itself.
 */
#include "solve/joint_type.h"
#include "step/step.h"
#include "world/region.h"

#define SAME 1e-9               /* of two values that should be equal, relative */

/* ---- writing down ---- */

static bool has_heard(const World *w, const Body *b, uint32_t slot, const Post *p)
{
    if (b->message_id && b->message_time == p->time && b->message_root == p->root && strcmp(body_message_kind(w, b), p->what.kind) == 0)
        return true;
    return mail_heard(&w->mail, p->root, p->what.kind, slot);
}

static void remember(World *w, Body *b, uint32_t slot, const dig_message *m)
{
    if (b->message_id && b->message_time == m->time)
        mail_note(&w->mail, b->message_root, body_message_kind(w, b), slot);
    b->message_id = m->id;
    b->message_root = m->root;
    b->message_time = m->time;
    b->message_from = m->from;
    b->told_blow = strcmp(m->kind, MESSAGE_BLOW) == 0;
    if (!b->told_blow)
        memcpy(body_rest_own(w, b)->message_kind, m->kind, sizeof m->kind);
}

/* Without memory messages are written down, but are no events. */
static bool room_for(World *w, int count)
{
    Mail *m = &w->mail;
    return list_reserve(&w->pending, w->pending.count + count, &w->allocations) == DIG_OK
        && list_reserve(&m->waiting, m->waiting.count + count, &w->allocations) == DIG_OK;
}

/* One post while it is handed out. What is the same for all that get it is written once. */
typedef struct Round {
    World      *w;
    const Post *p;
    bool        answers;        /* to a message that some may have heard; else it is new to everybody */
    bool        told;           /* there is room for a letter for each event, and an event for each letter */
    dig_message letter;
    dig_event   event;
    const Body *from;           /* who sent it; NULL: nobody that is there */
} Round;

/* most: to so many. */
static Round start_round(World *w, const Post *p, int most)
{
    const dig_post *d = &p->what;
    Round r = {.w = w, .p = p, .answers = p->root != 0, .told = room_for(w, most),
               .letter = {.root = p->root, .time = p->time, .from = d->from, .value = {d->value[0], d->value[1], d->value[2], d->value[3]}},
               .event = {.kind = DIG_EVENT_MESSAGE, .time = p->time, .b = d->from}};
    memcpy(r.letter.kind, d->kind, sizeof r.letter.kind);
    r.from = world_body(w, d->from);
    return r;
}

/* The memory of who is next is on its way while others get theirs. */
static void expect(const World *w, uint32_t slot)
{
    const Body *b = &w->bodies.data[slot];
    __builtin_prefetch(b);
    __builtin_prefetch(&b->message_id, 1);
    __builtin_prefetch((const char *)&b->message_from + sizeof b->message_from - 1, 1);
}

/* Without a root: the first that gets it is the root, from then on it stands there. */
static bool give(Round *r, uint32_t slot, real value)
{
    World *w = r->w;
    Body *b = &w->bodies.data[slot];
    dig_message *m = &r->letter;
    if (r->answers && has_heard(w, b, slot, r->p)) {
        w->stats.repeated++;
        return false;
    }
    m->id = message_ids(&w->messages, 1);
    m->root = m->root ? m->root : m->id;
    m->to = r->event.a = (dig_body){slot, b->gen};
    m->value[0] = value;
    m->direction = r->from ? vec3_sub(b->x, r->from->x) : vec3_zero();
    message_append(&w->messages, m);
    remember(w, b, slot, m);
    w->stats.delivered++;
    if (r->told) {
        r->event.message = m->id;
        w->pending.data[w->pending.count++] = r->event;
        w->mail.waiting.data[w->mail.waiting.count++] = *m;
    }
    return true;
}

static void lose(World *w) { w->stats.dropped++; }

/* ---- finding receivers ---- */

static bool start_search(World *w)
{
    Mail *m = &w->mail;
    m->reach.count = 0;
    m->stamp++;
    while (m->seen.count < w->bodies.count)
        if (list_push(&m->seen, &w->allocations) != DIG_OK)
            return false;
    return list_reserve(&m->reach, w->bodies.count, &w->allocations) == DIG_OK;
}

static bool was_reached(const Mail *m, uint32_t body) { return m->seen.data[body].stamp == m->stamp; }

/* True when it was not there yet. */
static bool reach(World *w, uint32_t body, uint32_t from, int hop, real value)
{
    Mail *m = &w->mail;
    if (was_reached(m, body))
        return false;
    m->seen.data[body] = (Seen){m->stamp, (uint32_t)m->reach.count};
    m->reach.data[m->reach.count++] = (Reach){body, from, hop, value};          /* each body once: there is room */
    return true;
}

static uint32_t far_end(const GraphLink *l, uint32_t node) { return l->a == node ? l->b : l->a; }

static bool fits(const dig_post *d, const GraphLink *l) { return d->link < 0 || l->kind == d->link; }

/* Who shares a link with the sender. Static bodies are no nodes: their links are listed at the other ends. */
static void reach_neighbours(World *w, const dig_post *d)
{
    const Graph *g = layer_graph(w, d->layer);
    uint32_t self = d->from.slot;
    if (g && graph_has_node(g, self)) {
        for (uint32_t l = graph_link_first(g, self); l != GRAPH_END; l = graph_link_next(g, self, l)) {
            const GraphLink *link = graph_link(g, l);
            if (fits(d, link))
                reach(w, far_end(link, self), 0, 1, d->value[0]);
        }
        return;
    }
    for (int i = 0; g && i < w->bodies.count; i++) {
        if (!graph_has_node(g, (uint32_t)i))
            continue;
        for (uint32_t l = graph_link_first(g, (uint32_t)i); l != GRAPH_END; l = graph_link_next(g, (uint32_t)i, l)) {
            const GraphLink *link = graph_link(g, l);
            if (fits(d, link) && far_end(link, (uint32_t)i) == self)
                reach(w, (uint32_t)i, 0, 1, d->value[0]);
        }
    }
}

/* What a joint makes of a rate on the way from the wheel `node`: gears and racks say speed of a * first = speed of b * second. */
static real ratio_of_joint(const JointRec *r, uint32_t node)
{
    bool gear = strcmp(r->type->name, "gear") == 0, rack = strcmp(r->type->name, "rack") == 0;
    real onward = gear ? r->params[2] / r->params[3] : rack ? r->params[2] : 0;     /* after two handles */
    return r->a == node || onward == 0 ? onward : 1 / onward;
}

static real ratio_of(const World *w, uint32_t layer, const GraphLink *l, uint32_t node)
{
    if (layer == DIG_LAYER_MECHANICAL)
        return l->kind == DIG_LINK_JOINT ? ratio_of_joint(&w->joints.data[l->user], node) : 0;
    const LayerLink *k = &w->layers[layer].links.data[l->user];
    return k->a == node || k->ratio == 0 ? k->ratio : 1 / k->ratio;
}

/* The ring of two ways to one body: up from both ends to where they meet. */
static void tell_loop(const World *w, uint32_t one, uint32_t other, dig_receipt *r)
{
    const Reach *at = w->mail.reach.data;
    for (; one != other; r->loop_count++) {
        uint32_t *late = at[one].hop >= at[other].hop ? &one : &other;
        if (r->loop_count < DIG_LOOP)
            r->loop[r->loop_count] = body_handle(w, at[*late].body);
        *late = at[*late].from;
    }
    if (r->loop_count < DIG_LOOP)
        r->loop[r->loop_count] = body_handle(w, at[one].body);
    r->loop_count = int_min(r->loop_count + 1, DIG_LOOP);
}

static void flood_link(World *w, const dig_post *d, const GraphLink *l, uint32_t head, dig_receipt *r)
{
    const Reach from = w->mail.reach.data[head];
    uint32_t next = far_end(l, from.body);
    if (d->transform != DIG_TRANSFORM_RATIO && was_reached(&w->mail, next))
        return;                                 /* values are not compared */
    real factor = d->transform == DIG_TRANSFORM_SCALE ? d->factor : d->transform == DIG_TRANSFORM_RATIO ? ratio_of(w, d->layer, l, from.body) : 1;
    if (l->bound || !fits(d, l) || factor == 0)
        return;
    real value = from.value * factor;
    if (!isfinite(value) || reach(w, next, head, from.hop + 1, value))
        return;
    uint32_t there = w->mail.seen.data[next].index;
    real known = w->mail.reach.data[there].value;
    if (d->transform == DIG_TRANSFORM_RATIO && r->loop_count == 0 && fabs(known - value) > SAME * (fabs(known) + fabs(value)))
        tell_loop(w, head, there, r);
}

/* The sender stands first in the list. */
static void reach_flood(World *w, const dig_post *d, dig_receipt *r)
{
    const Graph *g = layer_graph(w, d->layer);
    if (!g || !graph_has_node(g, d->from.slot) || !reach(w, d->from.slot, 0, 0, d->value[0]))
        return;
    for (int head = 0; head < w->mail.reach.count; head++) {
        const Reach at = w->mail.reach.data[head];
        if (d->hops > 0 && at.hop >= d->hops)
            continue;
        for (uint32_t l = graph_link_first(g, at.body); l != GRAPH_END;) {
            const GraphLink *link = graph_link(g, l);
            flood_link(w, d, link, (uint32_t)head, r);
            l = graph_link_after(link, at.body);
        }
    }
}

/* Backwards, so that the way can be read off from the sender; a static end may be reached, never passed. False: no way. */
static bool reach_path(World *w, const dig_post *d, uint32_t *end)
{
    const Graph *g = layer_graph(w, d->layer);
    if (!g || !reach(w, d->from.slot, 0, 0, d->value[0]))
        return false;
    for (int head = 0; head < w->mail.reach.count; head++) {
        const Reach at = w->mail.reach.data[head];
        if (at.body == d->to.slot) {
            *end = (uint32_t)head;
            return true;
        }
        if (!graph_has_node(g, at.body))
            continue;
        for (uint32_t l = graph_link_first(g, at.body); l != GRAPH_END; l = graph_link_next(g, at.body, l))
            if (fits(d, graph_link(g, l)))
                reach(w, far_end(graph_link(g, l), at.body), (uint32_t)head, at.hop + 1, d->value[0]);
    }
    return false;
}

/* ---- routes ---- */

#define AHEAD 4                 /* receivers: memory takes about so long */

static int give_reached(World *w, const Post *p, int first)
{
    const Reach *list = w->mail.reach.data;
    int n = 0, count = w->mail.reach.count;
    Round r = start_round(w, p, int_max(0, count - first));
    for (int i = first; i < count; i++) {
        if (i + AHEAD < count)
            expect(w, list[i + AHEAD].body);
        n += give(&r, list[i].body, list[i].value);
    }
    return n;
}

static int give_one(World *w, const Post *p)
{
    if (!world_body(w, p->what.to)) {
        lose(w);
        return 0;
    }
    Round r = start_round(w, p, 1);
    return give(&r, p->what.to.slot, p->what.value[0]);
}

static int give_members(World *w, const Post *p)
{
    const dig_post *d = &p->what;
    uint32_t layer = d->dig.id ? d->dig.layer : d->layer;
    const Graph *g = layer_graph(w, layer);
    uint32_t id = !g ? GRAPH_NONE : d->dig.id ? d->dig.id : graph_of(g, d->from.slot);
    int n = 0, size = g ? graph_size(g, id) : 0;
    if (size == 0) {
        lose(w);
        return 0;
    }
    Round r = start_round(w, p, size);
    for (uint32_t m = graph_first(g, id), next; m != GRAPH_END; m = next) {
        next = graph_next(g, m);
        if (next != GRAPH_END)
            expect(w, next);
        n += give(&r, m, d->value[0]);
    }
    return n;
}

static int give_path(World *w, const Post *p)
{
    uint32_t end = 0;
    int n = 0;
    if (!world_body(w, p->what.to) || !start_search(w) || !reach_path(w, &p->what, &end)) {
        lose(w);
        return 0;
    }
    Reach *list = w->mail.reach.data;
    uint32_t next = end;
    for (uint32_t i = end; i != 0;) {           /* turn the way round: `from` now leads on */
        uint32_t before = list[i].from;
        list[i].from = next;
        next = i;
        i = before;
    }
    Round r = start_round(w, p, w->mail.reach.count);
    for (uint32_t i = next; end != 0; i = list[i].from) {
        n += give(&r, list[i].body, p->what.value[0]);
        if (i == end)
            break;
    }
    return n;
}

static int give_region(World *w, const Post *p)
{
    dig_region handle = p->what.region;
    if (handle.slot >= (uint32_t)w->regions.count || !w->regions.data[handle.slot].alive || w->regions.data[handle.slot].gen != handle.gen) {
        lose(w);
        return 0;
    }
    if (!start_search(w))
        return 0;
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (b->alive && b->kind == DIG_DYNAMIC && region_holds(&w->regions.data[handle.slot], b->x))
            reach(w, (uint32_t)i, 0, 1, p->what.value[0]);
    }
    return give_reached(w, p, 0);
}

static int give_neighbours(World *w, const Post *p)
{
    if (!start_search(w))
        return 0;
    reach_neighbours(w, &p->what);
    return give_reached(w, p, 0);
}

static int give_flood(World *w, const Post *p, dig_receipt *r)
{
    if (!start_search(w))
        return 0;
    reach_flood(w, &p->what, r);
    return give_reached(w, p, 1);
}

/* Does the route begin at the sender? Then it must be there. */
static bool needs_sender(const dig_post *d)
{
    return d->route == DIG_ROUTE_NEIGHBOURS || d->route == DIG_ROUTE_FLOOD || d->route == DIG_ROUTE_PATH
        || (d->route == DIG_ROUTE_DIG && d->dig.id == 0);
}

int deliver_post(World *w, const Post *p, dig_receipt *receipt)
{
    dig_receipt own = {0};
    dig_receipt *r = receipt ? receipt : &own;
    *r = own;
    mail_at(&w->mail, p->time);
    if (needs_sender(&p->what) && !world_body(w, p->what.from)) {
        lose(w);
        return 0;
    }
    switch (p->what.route) {
    case DIG_ROUTE_TO:         r->reached = give_one(w, p);        break;
    case DIG_ROUTE_NEIGHBOURS: r->reached = give_neighbours(w, p); break;
    case DIG_ROUTE_DIG:        r->reached = give_members(w, p);    break;
    case DIG_ROUTE_FLOOD:      r->reached = give_flood(w, p, r);   break;
    case DIG_ROUTE_PATH:       r->reached = give_path(w, p);       break;
    case DIG_ROUTE_REGION:     r->reached = give_region(w, p);     break;
    case DIG_ROUTES:           break;
    }
    return r->reached;
}

int deliver_list(World *w, const Post *p, const dig_body *to, const real *value, int count)
{
    mail_at(&w->mail, p->time);
    if (!start_search(w))
        return 0;
    for (int i = 0; i < count; i++) {
        if (world_body(w, to[i]))
            reach(w, to[i].slot, 0, 1, value[i]);
        else
            lose(w);
    }
    return give_reached(w, p, 0);
}

void deliver_due(World *w)
{
    real now = world_time(w) + 1e-9 * w->def.step;
    while (mail_due(&w->mail, now)) {
        Post p = mail_take(&w->mail);
        deliver_post(w, &p, NULL);
    }
}
