/* world/event.c - events waiting to be delivered after the next step. */
#include "world/world.h"

dig_event *events_claim(World *w, int count)
{
    if (list_reserve(&w->pending, w->pending.count + count, &w->allocations) != DIG_OK)
        return NULL;
    w->pending.count += count;
    return &w->pending.data[w->pending.count - count];
}

void event_write(const World *w, dig_event *e, dig_event_kind kind, uint32_t a, uint32_t b)
{
    memset(e, 0, sizeof *e);
    e->kind = kind;
    e->time = world_time(w);
    e->a.slot = a;
    e->b.slot = b;
}

dig_event *event_note(World *w, dig_event_kind kind, uint32_t a, uint32_t b)
{
    if (list_push(&w->pending, &w->allocations) != DIG_OK)
        return NULL;
    dig_event *e = &w->pending.data[w->pending.count - 1];
    event_write(w, e, kind, a, b);
    return e;
}

void event_name(const World *w, dig_event *e)
{
    e->a = body_handle(w, e->a.slot);
    e->b = body_handle(w, e->b.slot);
}

dig_event *event_post(World *w, dig_event_kind kind, uint32_t a, uint32_t b)
{
    dig_event *e = event_note(w, kind, a, b);
    if (e)
        event_name(w, e);
    return e;
}

/* On a merge the finer accuracy wins. Bodies carry what was asked for their DIG; 0 = nothing was. */
static void keep_finer(World *w, uint32_t id)
{
    uint64_t accuracy = 0;
    for (uint32_t m = graph_first(w->graph, id); m != NONE; m = graph_next(w->graph, m))
        accuracy = w->bodies.data[m].accuracy > accuracy ? w->bodies.data[m].accuracy : accuracy;
    graph_set_user(w->graph, id, accuracy);
}

void post_graph_changes(World *w, uint32_t layer)
{
    const GraphChange *changes;
    int count = graph_changes(layer_graph(w, layer), &changes);
    for (int i = 0; i < count; i++) {
        if (layer == DIG_LAYER_MECHANICAL && w->dig_accuracies && changes[i].kind == GRAPH_MERGED)
            keep_finer(w, changes[i].kept);
        dig_event *e = event_post(w, changes[i].kind == GRAPH_MERGED ? DIG_EVENT_MERGED : DIG_EVENT_SPLIT, NONE, NONE);
        if (e) {
            e->dig = changes[i].kept;
            e->other_dig = changes[i].other;
            e->layer = layer;
        }
    }
}

const char *dig_event_name(dig_event_kind k)
{
    static const char *const names[DIG_EVENT_KINDS] = {
        [DIG_EVENT_CONTACT_BEGIN] = "contact_begin", [DIG_EVENT_CONTACT_END] = "contact_end",
        [DIG_EVENT_IMPACT] = "impact", [DIG_EVENT_BROKEN] = "broken", [DIG_EVENT_MOVED] = "moved",
        [DIG_EVENT_SLEPT] = "slept", [DIG_EVENT_WOKE] = "woke", [DIG_EVENT_REMOVED] = "removed",
        [DIG_EVENT_MERGED] = "merged", [DIG_EVENT_SPLIT] = "split", [DIG_EVENT_LINK] = "link",
        [DIG_EVENT_UNLINK] = "unlink", [DIG_EVENT_MESSAGE] = "message", [DIG_EVENT_LIMIT_REACHED] = "limit_reached",
        [DIG_EVENT_OUT_OF_WORLD] = "out_of_world", [DIG_EVENT_ENTERED] = "entered", [DIG_EVENT_LEFT] = "left",
        [DIG_EVENT_DISABLED] = "disabled",
    };
    return (unsigned)k < DIG_EVENT_KINDS ? names[k] : "";
}
