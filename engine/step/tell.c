/* step/tell.c - collision messages: to each member of the DIG of every body that was struck by something outside its DIG.
 *
 * A strike is one short record, however many members the DIG has. At the end of the step the records become messages, but only
 * those that the log keeps: a pile that is struck a hundred times in a step writes no more than the log holds, and every member
 * remembers the last one once.
 */
#include "step/step.h"

#include <stdlib.h>

static const char kind[32] = MESSAGE_BLOW;

struct Telling {
    uint64_t id;                /* of the message to the first member; the others' follow in the order of the members */
    real     time, speed;       /* s, m/s */
    uint32_t lead, striker;     /* first member of the DIG; body, NONE = the world */
    int      count;             /* members */
};

/* Who remembers a telling, or whose message of it the log keeps. */
struct Heard { uint32_t member; int telling; uint64_t id; };

/* What the log's message asks of its body and of the striker. */
struct Missive { dig_body to; vec3 direction; };

/* Each strike may concern two DIGs, and these are of bodies that were advanced, or stand still beside them. */
dig_status reserve_tell(World *w, Step *s)
{
    int strikes = 0, bodies = 0;
    for (int i = 0; i < s->count; i++) {
        strikes += s->groups[i].strike_count;
        bodies += s->groups[i].body_count;
    }
    s->telling_count = 0;
    if (strikes == 0)
        return DIG_OK;
    int64_t letters = 2 * (int64_t)strikes * bodies;
    size_t kept = letters < (int64_t)MESSAGE_KEPT ? (size_t)letters : MESSAGE_KEPT;
    s->tellings = step_room(w, s, 2 * (size_t)strikes * sizeof *s->tellings);
    s->heard = step_room(w, s, ((size_t)bodies > kept ? (size_t)bodies : kept) * sizeof *s->heard);
    s->missives = step_room(w, s, kept * sizeof *s->missives);
    bool there = s->tellings && s->heard && s->missives;
    return there ? DIG_OK : world_fail(w, DIG_E_MEMORY, "not enough memory for the messages of %d strikes", strikes);
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

#define SHARED_LEAST 256         /* members: fewer are not worth a team */

static Team *team_for(const World *w, int count) { return count < SHARED_LEAST ? NULL : workers_team(w->workers); }

/* By all threads: members of a pile lie far apart in memory. */
typedef struct Hearing { World *w; const Step *s; int count; } Hearing;

static void remember_share(void *context, int thread, int threads)
{
    const Hearing *all = context;
    for (int i = team_first(all->count, thread, threads), end = team_end(all->count, thread, threads); i < end; i++) {
        const struct Heard *h = &all->s->heard[i];
        const struct Telling *t = &all->s->tellings[h->telling];
        Body *b = &all->w->bodies.data[h->member];
        b->message_id = b->message_root = h->id;
        b->message_time = t->time;
        b->message_from = body_handle(all->w, t->striker);
        b->told_blow = true;
    }
}

/* What every member remembers: the last telling of its DIG, in the order of the calls. Ids that were given before `first` are of
 * earlier steps. */
static void remember(World *w, Step *s, uint64_t first)
{
    int n = 0;
    for (int i = s->telling_count - 1; i >= 0; i--) {
        const struct Telling *t = &s->tellings[i];
        uint64_t id = t->id;
        if (w->bodies.data[t->lead].message_id >= first)
            continue;                       /* a later one was remembered already */
        w->bodies.data[t->lead].message_id = id;
        for (uint32_t m = t->lead; m != NONE; m = graph_next(w->graph, m))
            s->heard[n++] = (struct Heard){m, i, id++};
    }
    team_deal(team_for(w, n), remember_share, &(Hearing){w, s, n});
}

static int compare_tellings(const void *a, const void *b)
{
    const struct Telling *x = a, *y = b;
    if (x->time != y->time)
        return x->time < y->time ? -1 : 1;
    return x->id < y->id ? -1 : x->id > y->id;
}

/* The striker, unless it has no place. */
static const Body *striker_of(const World *w, const struct Telling *t)
{
    const Body *b = t->striker == NONE ? NULL : &w->bodies.data[t->striker];
    return b && isfinite(b->outer) ? b : NULL;
}

static void write_share(void *context, int thread, int threads)
{
    const Hearing *all = context;
    const World *w = all->w;
    for (int i = team_first(all->count, thread, threads), end = team_end(all->count, thread, threads); i < end; i++) {
        const struct Heard *h = &all->s->heard[i];
        const Body *from = striker_of(w, &all->s->tellings[h->telling]);
        all->s->missives[i].to = body_handle(w, h->member);
        all->s->missives[i].direction = from ? vec3_sub(w->bodies.data[h->member].x, from->x) : vec3_zero();
    }
}

/* Members from number n of the list on that hear of a telling but for the first `skip` of them; returns where the list ends then. */
static int list_members(const World *w, Step *s, int telling, int skip, int n)
{
    const struct Telling *t = &s->tellings[telling];
    uint32_t m = t->lead;
    for (int i = 0; i < t->count; i++, m = graph_next(w->graph, m))
        if (i >= skip)
            s->heard[n++] = (struct Heard){m, telling, t->id + (uint64_t)i};
    return n;
}

/* The log's messages of those on the list. */
static void write_messages(World *w, Step *s, int count)
{
    team_deal(team_for(w, count), write_share, &(Hearing){w, s, count});
    dig_message message = {0};
    memcpy(message.kind, kind, sizeof message.kind);
    for (int i = 0; i < count; i++) {
        const struct Heard *h = &s->heard[i];
        const struct Telling *t = &s->tellings[h->telling];
        if (i == 0 || h->telling != h[-1].telling)
            message.from = body_handle(w, t->striker);
        message.id = h->id;
        message.time = t->time;
        message.value[0] = t->speed;
        message.to = s->missives[i].to;
        message.direction = s->missives[i].direction;
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
    int first = s->telling_count, n = 0;
    while (first > 0 && room > 0)
        room -= s->tellings[--first].count;
    for (int i = first; i < s->telling_count; i++)
        n = list_members(w, s, i, i == first && room < 0 ? (int)-room : 0, n);
    write_messages(w, s, n);
}
