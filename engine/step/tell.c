/* step/tell.c - collision messages: to each member of the DIG of every body that was struck by something outside its DIG.
 *
 * A strike is one short record, however many members the DIG has. At the end of the step the records become messages, but only
 * those that the log keeps: a pile that is struck a hundred times in a step writes no more than the log holds, and every member
 * remembers the last one once.
 */
#include "step/step.h"

#include <stdlib.h>

static const char kind[32] = "collision";

struct Telling {
    uint64_t id;                /* of the message to the first member; the others' follow in the order of the members */
    real     time, speed;       /* s, m/s */
    uint32_t lead, striker;     /* first member of the DIG; body, NONE = the world */
    int      count;             /* members */
};

/* Each strike may concern two DIGs. */
dig_status reserve_tell(World *w, Step *s)
{
    int strikes = 0;
    for (int i = 0; i < s->count; i++)
        strikes += s->groups[i].strike_count;
    s->telling_count = 0;
    s->tellings = strikes ? arena_alloc(&w->scratch, 2 * (size_t)strikes * sizeof *s->tellings) : NULL;
    return strikes && !s->tellings ? world_fail(w, DIG_E_MEMORY, "not enough memory for the messages of %d strikes", strikes) : DIG_OK;
}

void tell(World *w, Step *s, uint32_t struck, uint32_t striker, real time, real speed)
{
    uint32_t lead = struck == NONE ? NONE : graph_lead(w->graph, struck);
    bool within = striker != NONE && graph_lead(w->graph, striker) == lead;
    if (lead == NONE || within || !isfinite(time) || !isfinite(speed))
        return;
    struct Telling *t = &s->tellings[s->telling_count++];
    *t = (struct Telling){.time = time, .speed = speed, .lead = lead, .striker = striker, .count = graph_fellows(w->graph, lead)};
    t->id = message_ids(&w->messages, (uint64_t)t->count);
}

/* ---- at the end of the step ---- */

/* What every member remembers: the last telling of its DIG, in the order of the calls. Ids that were given before `first` are of
 * earlier steps. */
static void remember(World *w, const Step *s, uint64_t first)
{
    for (int i = s->telling_count - 1; i >= 0; i--) {
        const struct Telling *t = &s->tellings[i];
        uint64_t id = t->id;
        if (w->bodies.data[t->lead].message_id >= first)
            continue;                       /* a later one was remembered already */
        for (uint32_t m = t->lead; m != NONE; m = graph_next(w->graph, m)) {
            Body *b = &w->bodies.data[m];
            b->message_id = id++;
            b->message_root = b->message_id;
            b->message_time = t->time;
            b->message_from = body_handle(w, t->striker);
            memcpy(b->message_kind, kind, sizeof b->message_kind);
        }
    }
}

static int compare_tellings(const void *a, const void *b)
{
    const struct Telling *x = a, *y = b;
    if (x->time != y->time)
        return x->time < y->time ? -1 : 1;
    return x->id < y->id ? -1 : x->id > y->id;
}

/* The log's messages of one telling but for its first `skip` members. */
static void write_messages(World *w, const struct Telling *t, int skip)
{
    dig_message message = {.time = t->time, .from = body_handle(w, t->striker), .value = {t->speed}};
    memcpy(message.kind, kind, sizeof message.kind);
    bool plane = t->striker == NONE || !isfinite(w->bodies.data[t->striker].outer);
    vec3 from = plane ? vec3_zero() : w->bodies.data[t->striker].x;
    uint32_t m = t->lead;
    for (int i = 0; i < t->count; i++, m = graph_next(w->graph, m)) {
        if (i < skip)
            continue;
        message.id = t->id + (uint64_t)i;
        message.to = body_handle(w, m);
        message.direction = plane ? vec3_zero() : vec3_sub(w->bodies.data[m].x, from);
        message_keep(&w->messages, &message);
    }
}

void tell_all(World *w, Step *s)
{
    if (s->telling_count == 0)
        return;
    remember(w, s, s->tellings[0].id);
    qsort(s->tellings, (size_t)s->telling_count, sizeof *s->tellings, compare_tellings);
    int64_t room = MESSAGE_KEPT;
    int first = s->telling_count;
    while (first > 0 && room > 0)
        room -= s->tellings[--first].count;
    for (int i = first; i < s->telling_count; i++)
        write_messages(w, &s->tellings[i], i == first && room < 0 ? (int)-room : 0);
}
