/* step/report.c - events, residuals, expired pushes, the energy ledger. */
#include "base/block.h"
#include "step/step.h"

#include <stdio.h>
#include <stdlib.h>

static uint32_t slot_low(const dig_event *e) { return e->b.gen && e->b.slot < e->a.slot ? e->b.slot : e->a.slot; }
static uint32_t slot_high(const dig_event *e) { return e->b.gen && e->b.slot < e->a.slot ? e->a.slot : e->b.slot; }

static int compare_events(const void *a, const void *b)
{
    const dig_event *x = a, *y = b;
    if (x->time != y->time)
        return x->time < y->time ? -1 : 1;
    if (x->kind != y->kind)
        return x->kind < y->kind ? -1 : 1;
    if (x->kind == DIG_EVENT_MESSAGE)
        return x->message < y->message ? -1 : x->message > y->message;
    if (slot_low(x) != slot_low(y))
        return slot_low(x) < slot_low(y) ? -1 : 1;
    if (slot_high(x) != slot_high(y))
        return slot_high(x) < slot_high(y) ? -1 : 1;
    if (x->dig != y->dig)
        return x->dig < y->dig ? -1 : 1;
    if (x->other_dig != y->other_dig)
        return x->other_dig < y->other_dig ? -1 : 1;
    if (x->wall != y->wall)
        return x->wall < y->wall ? -1 : 1;
    if (x->layer != y->layer)
        return x->layer < y->layer ? -1 : 1;
    if (x->joint.slot != y->joint.slot)
        return x->joint.slot < y->joint.slot ? -1 : 1;
    return x->speed < y->speed ? -1 : x->speed > y->speed;
}

/* Messages, which may be many, come in order. */
static void sort_events(dig_event *e, int count)
{
    bool sorted = true;
    for (int i = 1; i < count && sorted; i++)
        sorted = compare_events(&e[i - 1], &e[i]) <= 0;
    if (!sorted)
        qsort(e, (size_t)count, sizeof *e, compare_events);
}

#define TRIM_EVERY 64            /* steps */

/* After a step with very many events, their room is given back. */
static void trim_events(World *w)
{
    if (w->steps % TRIM_EVERY != 0)
        return;
    int enough = 64 + 2 * w->events_most;
    if (w->events.capacity > 2 * enough)
        list_trim(&w->events, enough);
    if (w->pending.capacity > 2 * enough)
        list_trim(&w->pending, enough);
    w->events_most = 0;
}

/* The lists change places; what is in them stays where it is. */
static void turn_events(World *w)
{
    dig_event *room = w->events.data;
    int capacity = w->events.capacity, count = w->events.count;
    w->events.data = w->pending.data;
    w->events.count = w->pending.count;
    w->events.capacity = w->pending.capacity;
    w->pending.data = room;
    w->pending.count = count;
    w->pending.capacity = capacity;
}

void end_events(World *w) { w->events.count = w->mail.shown.count = 0; }

/* In the place of the last ones it stays as it is, for something lies there until the step is committed. The other list mostly begins with
 * nothing: what would be made a little longer in each of many steps grows by a half, as lists do. */
dig_status reserve_events(World *w, int count)
{
    if (w->events.capacity >= count)
        return DIG_OK;
    bool small = list_bytes(&w->events) < BLOCK_LARGE;
    return list_reserve(&w->pending, small ? int_max(count, w->events.capacity + w->events.capacity / 2) : count, &w->allocations);
}

/* The room of the last step's events is for those of this one, after what has been waiting, unless that has more: only one of the lists ever gets
 * large. */
void begin_events(World *w)
{
    if (w->pending.capacity > w->events.capacity) {
        list_close(&w->events);
        w->events_written = w->pending.count;
        return;
    }
    w->events.count = w->pending.count;
    if (w->pending.count > 0)
        memcpy(w->events.data, w->pending.data, (size_t)w->pending.count * sizeof *w->events.data);
    w->pending.count = 0;
    turn_events(w);
}

#define FORGET_LEAST ((size_t)64 << 10)         /* bytes, by which there are fewer: less is not worth a call to the system */

/* Of a large list, what a step with more events had written to takes no memory until it is written to again. */
static void forget_events(World *w)
{
    w->events_written = int_min(w->events_written, w->events.capacity);         /* it may have been trimmed since */
    size_t used = (size_t)w->events.count * sizeof *w->events.data, written = (size_t)w->events_written * sizeof *w->events.data;
    if (list_bytes(&w->events) >= BLOCK_LARGE && written >= used + FORGET_LEAST)
        block_forget((unsigned char *)w->events.data + used, written - used);
    else if (w->events.count < w->events_written)
        return;
    w->events_written = w->events.count;
}

/* What was waiting is delivered. */
static void deliver_events(World *w)
{
    turn_events(w);
    dig_message *letters = w->mail.shown.data;
    int capacity = w->mail.shown.capacity;
    w->mail.shown.data = w->mail.waiting.data;
    w->mail.shown.count = w->mail.waiting.count;
    w->mail.shown.capacity = w->mail.waiting.capacity;
    w->mail.waiting.data = letters;
    w->mail.waiting.count = 0;
    w->mail.waiting.capacity = capacity;
    sort_events(w->events.data, w->events.count);
}

/* A push that has ended wakes what it held; order of the rest is kept. */
static void end_pushes(World *w)
{
    real now = world_time(w);
    int n = 0;
    for (int i = 0; i < w->pushes.count; i++) {
        Push p = w->pushes.data[i];
        if (p.until <= now + 1e-9 * w->def.step)
            body_wake(w, p.body);
        else
            w->pushes.data[n++] = p;
    }
    w->pushes.count = n;
}

#define WORLD_EDGE 1e4

bool world_left(const World *w, vec3 x)
{
    vec3 d = w->has_room ? vec3_abs(vec3_sub(x, vec3_add(w->room.at, (vec3){0, 0.5 * w->room.size.y, 0}))) : vec3_abs(x);
    vec3 edge = w->has_room ? vec3_scale(0.5, w->room.size) : (vec3){WORLD_EDGE, WORLD_EDGE, WORLD_EDGE};
    return d.x > edge.x || d.y > edge.y || d.z > edge.z;
}

static void watch_edge(World *w, const Step *s)
{
    for (int i = 0; i < s->count; i++)
        for (int k = 0; k < s->groups[i].moving_count && s->groups[i].watch.leavers > 0; k++) {
            uint32_t slot = s->groups[i].slots[k];
            Body *b = &w->bodies.data[slot];
            if (b->out || !b->awake || !world_left(w, b->x))
                continue;
            b->out = true;
            event_post(w, DIG_EVENT_OUT_OF_WORLD, slot, NONE);
        }
}

/* Only for whom it matters: it is an event for each body in each step. What is at rest has moved by rounding at most. */
static void tell_moves(World *w)
{
    for (int i = 0; i < w->awake.count && w->tells_moves; i++) {
        const Body *b = &w->bodies.data[w->awake.data[i]];
        bool turned = b->q.x != b->prev_q.x || b->q.y != b->prev_q.y || b->q.z != b->prev_q.z || b->q.w != b->prev_q.w;
        if (b->mode != DIG_RESTING && (turned || vec3_distance(b->x, b->prev_x) > 0))
            event_post(w, DIG_EVENT_MOVED, w->awake.data[i], NONE);
    }
}

static void sum_groups(World *w, const Step *s)
{
    dig_stats *t = &w->stats;
    t->groups = s->count;
    t->iterations = t->factors = t->substeps = t->located = t->evaluations = t->refused = t->trace_events = 0;
    t->traced = t->conserved = t->swept = t->unturned = 0;
    t->residual = t->penetration = t->joint_error = 0;
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        t->iterations += g->sweeps;
        t->factors += g->factors;
        t->substeps += g->substeps;
        t->located += g->located;
        t->evaluations += g->evaluations;
        t->refused += g->refused;
        t->trace_events += g->events;
        *(g->way->tally == WAY_TRACED ? &t->traced : g->way->tally == WAY_CONSERVED ? &t->conserved : &t->swept) += 1;
        if (g->gave_up) {
            t->gave_up++;
            snprintf(t->gave_up_why, sizeof t->gave_up_why, "%s", g->gave_up);
        }
        t->us_touch += g->touch_us / (real)int_max(1, (int)w->def.threads);     /* as the others: of one thread */
        t->residual = real_max(t->residual, g->residual);
        t->penetration = real_max(t->penetration, g->penetration);
        t->joint_error = real_max(t->joint_error, g->joint_error);
        t->worst_residual = real_max(t->worst_residual, g->residual);
        t->worst_penetration = real_max(t->worst_penetration, g->penetration);
        t->worst_joint_error = real_max(t->worst_joint_error, g->joint_error);
        t->unturned += g->unturned;
        w->ledger.lost += g->lost;
        w->ledger.work_in += g->work_in;
        w->ledger.law += g->law;
    }
}

/* Contacts are found while groups are advanced: their time is told apart. */
static void part_touch(dig_stats *t)
{
    t->us_touch = real_min(t->us_touch, t->us_advance);
    t->us_advance -= t->us_touch;
}

static void sum_ways(dig_stats *t)
{
    t->all_traced += (uint64_t)t->traced;
    t->all_conserved += (uint64_t)t->conserved;
    t->all_swept += (uint64_t)t->swept;
    t->all_refused += (uint64_t)t->refused;
}

/* Do only those of its column take part? */
static bool takes_some(const EffectSlot *e) { return e->owner ? !e->owner->all : e->type->body_params != NULL; }

static EffectCause cause_of(const Group *g, const EffectSlot *e)
{
    int i = 0;
    if (e->type->cause)
        return e->type->cause(g);
    while (i + 1 < g->moving_count && takes_some(e) && !column_find(&e->members, g->member[i].slot))
        i++;
    return (EffectCause){.body = body_handle(g->world, g->member[i].slot)};
}

static int members_of(const Group *g, const EffectSlot *e)
{
    int n = 0;
    if (e->type->members)
        return e->type->members(g);
    if (!takes_some(e))
        return g->moving_count;
    for (int i = 0; i < g->moving_count; i++)
        n += g->member[i].moves && column_find(&e->members, g->member[i].slot);
    return n;
}

/* Of a timed step, or of one in which nothing moves. */
static void time_effect(const Step *s, EffectSlot *e, int number)
{
    e->us = e->flow_us;
    for (int k = 0; k < s->count; k++)
        e->us += s->groups[k].effect_us[number];
    if (s->count > 0) {
        e->us_sum += e->us;
        e->us_count++;
    }
}

static void count_effects(World *w, const Step *s)
{
    for (uint32_t left = w->met; left; left &= left - 1)
        w->effects[lowest_bit(left)].bodies = 0;
    for (int k = 0; k < s->count; k++) {
        const Group *g = &s->groups[k];
        w->met |= g->effects;
        for (uint32_t left = g->effects; left; left &= left - 1) {
            EffectSlot *e = &w->effects[lowest_bit(left)];
            e->bodies += members_of(g, e);
            e->calls++;
            if (!e->caused && g->moving_count > 0) {
                e->cause = cause_of(g, e);
                e->caused = true;
            }
        }
    }
    for (uint32_t left = s->timed || s->count == 0 ? w->met : 0; left; left &= left - 1) {
        int i = lowest_bit(left);
        if (i < w->effect_count)
            time_effect(s, &w->effects[i], i);
    }
}

void report(World *w, const Step *s)
{
    sum_groups(w, s);
    sum_ways(&w->stats);
    if (s->timed)
        part_touch(&w->stats);
    count_effects(w, s);
    end_pushes(w);
    watch_edge(w, s);
    tell_moves(w);
    w->stats.steps = w->steps;
    watch_world(w, s);
    deliver_due(w);
    deliver_events(w);
    forget_events(w);
    trim_events(w);
}
