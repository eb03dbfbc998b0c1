/* api/ask.c - could this happen? A question is put to a copy of a DIG, in which it is tried; the world itself never notices.
 *
 * Stages, the cheap ones first, ending with the first that decides:
 *   1  what is fixed does not move; gears that contradict each other (ask_linkage.c) do not turn;
 *   2  the push, tried: does the body move at all within a few steps, and then as far as was asked?
 *   3  it does not: how much more would it need, from the start or from where it was stopped? (ask_needs.c)
 *   4  what holds it, and what holds that? (ask_holders.c)
 *
 * The copy is stepped like any world: an answer is what would come out, not a guess about it. It holds that DIG and what is around it
 * (part.h); where something gets farther than that, more of the world is taken, and where there was more, it is tried again.
 */
#include "api/ask.h"

#include <stdio.h>

dig_question dig_question_defaults(void) { return (dig_question){.by = 0.01, .with = NAN, .within = 5}; }

const char *dig_verdict_name(dig_verdict v)
{
    static const char *const names[] = {"free", "blocked", "needs", "conflict", "unknown"};
    return (unsigned)v < sizeof names / sizeof *names ? names[v] : "";
}

/* ---- the part of the world that is asked ---- */

static dig_status open_part(Ask *k)
{
    const Body *b = &k->w->bodies.data[k->q->body.slot];
    real by = k->q->turns ? k->q->by * b->outer : k->q->by;
    k->far = 0.02 + 0.1 * b->outer + real_min(by, 2 * b->outer);
    if (part_take(k->w, k->q->body.slot, k->far, &k->part) != DIG_OK)
        return ask_no_memory(k);
    k->body = part_body(&k->part, k->q->body.slot);
    return DIG_OK;
}

/* What was put somewhere since the last step touches nothing yet: what it stands on, and what holds it, is found by stepping. */
static dig_status settle_part(Ask *k)
{
    World *w = k->part.world;
    if (w->asking.count == 0)
        return DIG_OK;
    DIG_TRY(ask_use_copy(k));
    k->a->steps++;
    dig_status s = dig_world_step(k->copy);
    if (s != DIG_OK)
        return world_fail(k->w, s, "ask: %s", dig_error(k->copy));
    return api_refill(w, k->copy) == DIG_OK ? DIG_OK : ask_no_memory(k);
}

static bool same_slots(const Slots *a, const Slots *b)
{
    return a->count == b->count && (a->count == 0 || memcmp(a->data, b->data, (size_t)a->count * sizeof *a->data) == 0);
}

/* Takes more of the world. *more: there was more. */
static dig_status widen(Ask *k, bool *more)
{
    Part wider;
    k->far *= 4;
    if (part_take(k->w, k->q->body.slot, k->far, &wider) != DIG_OK)
        return ask_no_memory(k);
    *more = !same_slots(&wider.bodies, &k->part.bodies);
    world_work(k->w, k->part.world->work);
    part_close(&k->part);
    k->part = wider;
    k->body = part_body(&k->part, k->q->body.slot);
    if (*more) {
        world_work(k->w, k->copy ? k->copy->work : 0);
        dig_world_close(k->copy);
        k->copy = NULL;
        DIG_TRY(settle_part(k));
    }
    return DIG_OK;
}

static void close_part(Ask *k)
{
    world_work(k->w, (k->part.world ? k->part.world->work : 0) + (k->copy ? k->copy->work : 0));
    part_close(&k->part);
    dig_world_close(k->copy);
}

/* What stopped it is asked of the copy, there, without the push that brought it there: the last of those on the body that go on. */
static dig_status go_on_from_here(Ask *k)
{
    World *w = k->part.world;
    if (api_refill(w, k->copy) != DIG_OK)
        return ask_no_memory(k);
    int last = w->pushes.count - 1;
    while (last >= 0 && (w->pushes.data[last].body != k->body || w->pushes.data[last].law))
        last--;
    for (int i = last; i >= 0 && i + 1 < w->pushes.count; i++)
        w->pushes.data[i] = w->pushes.data[i + 1];
    w->pushes.count -= last >= 0;
    return DIG_OK;
}

/* ---- the push, tried to its end ---- */

static void add_consequence(dig_answer *a, const char *what, dig_part who, real amount)
{
    if (a->consequence_count < DIG_ANSWER_PARTS)
        a->consequences[a->consequence_count++] = (dig_consequence){what, who, amount};
}

static void note_breaks(Ask *k)
{
    const World *copy = k->copy;
    for (int i = 0; i < copy->events.count; i++)
        if (copy->events.data[i].kind == DIG_EVENT_BROKEN)
            add_consequence(k->a, "broken", (dig_part){.joint = copy->events.data[i].joint}, copy->events.data[i].impulse / copy->def.step);
}

static void note_moves(Ask *k)
{
    for (int i = 0; i < k->part.world->bodies.count; i++) {
        const Body *was = &k->part.world->bodies.data[i], *is = &k->copy->bodies.data[i];
        if (!was->alive || was->kind != DIG_DYNAMIC || (uint32_t)i == k->body)
            continue;
        real far = vec3_distance(was->x, is->x);
        if (far > ASK_LITTLE && vec3_length(was->v) < ASK_STARTS)
            add_consequence(k->a, "moves", (dig_part){.body = body_handle(k->copy, (uint32_t)i)}, far);
    }
}

/* *stopped: by something, not by the clock; *more: it got where there is more than the part holds. */
static dig_status push_once(Ask *k, real push, Trial *t, bool *stopped, bool *more)
{
    const dig_question *q = k->q;
    *stopped = *more = false;
    k->a->consequence_count = 0;
    DIG_TRY(ask_push(k, push, t));
    while (!*more && !*stopped && t->moved < q->by && (real)t->steps * k->copy->def.step < q->within) {
        DIG_TRY(ask_step(k, t));
        note_breaks(k);
        *stopped = t->moved < q->by && ask_stuck(k, t);
        while (!*more && part_left(&k->part, k->copy))
            DIG_TRY(widen(k, more));
    }
    return DIG_OK;
}

static bool gets_there(const Ask *k, const Trial *t) { return t->moved >= k->q->by * (1 - 1e-12); }

static dig_status try_push(Ask *k, real push, Trial *t, bool *stopped)
{
    bool more;
    do
        DIG_TRY(push_once(k, push, t, stopped, &more));
    while (more);
    return DIG_OK;
}

/* ---- answers ---- */

static const char *unit(const Ask *k) { return k->q->turns ? "N m" : "N"; }
static const char *way_unit(const Ask *k) { return k->q->turns ? "rad" : "m"; }

static void add_self(Ask *k) { ask_add_chain(k->a, (dig_part){.body = body_handle(k->part.world, k->body)}); }

/* a->needs is known. Where no push does it, it is asked who holds it against one that friction and weight do not. */
static dig_status find_holders(Ask *k, real push, char *who, size_t capacity)
{
    real from = isfinite(k->a->needs) ? push : ASK_STRONG * ask_weight(k);
    DIG_TRY(ask_holders(k, from));
    DIG_TRY(ask_chain(k, from));
    ask_name_holders(k, who, capacity);
    return DIG_OK;
}

/* Something stops it on its way: does more push get it on from there? */
static dig_status answer_stopped(Ask *k)
{
    dig_answer *a = k->a;
    char who[144], more[48] = ", whatever the push"; /* together they fit a->because */
    DIG_TRY(go_on_from_here(k));
    DIG_TRY(ask_needs(k, k->q->with, true, &a->needs));
    DIG_TRY(find_holders(k, k->q->with, who, sizeof who));
    a->verdict = isfinite(a->needs) ? DIG_NEEDS : DIG_BLOCKED;
    if (isfinite(a->needs))
        snprintf(more, sizeof more, "; to go on it needs %.4g %s", a->needs, unit(k));
    snprintf(a->because, sizeof a->because, "it moves %.4g of %.4g %s, then %s %s it%s", a->moved, k->q->by, way_unit(k), who,
             a->held_count > 1 ? "stop" : "stops", more);
    return DIG_OK;
}

/* It is on its way when time is up. Where what is beyond the push that starts it (`starts`, NaN: unknown) makes it faster in proportion,
 * so much of it is needed; that is tried. */
static dig_status answer_slow(Ask *k, real starts, bool free)
{
    dig_answer *a = k->a, said = *a;
    Trial t = {0};
    bool stopped;
    real with = k->q->with, least = starts > 0 && starts < with ? starts : 0;
    real push = (least + (with - least) * k->q->by / a->moved) * (1 + 1e-6);
    DIG_TRY(try_push(k, push, &t, &stopped));
    said.trials = a->trials;
    said.steps = a->steps;
    *a = said;
    add_self(k);
    bool does = gets_there(k, &t);
    a->verdict = does ? DIG_NEEDS : DIG_UNKNOWN;
    a->needs = does ? push : (real)NAN;
    int n = snprintf(a->because, sizeof a->because, "%sit moves %.4g of %.4g %s in %.3g s%s", free ? "nothing holds it but its own inertia: " : "",
                     a->moved, k->q->by, way_unit(k), a->time, free ? "" : ", then time is up");
    if (does)
        snprintf(a->because + n, sizeof a->because - (size_t)n, "; in that time it needs %.4g %s", push, unit(k));
    return DIG_OK;
}

/* needs: a->needs is known. from: a push that does not start it. */
static dig_status answer_held(Ask *k, real from)
{
    dig_answer *a = k->a;
    char who[160];
    DIG_TRY(find_holders(k, from, who, sizeof who));
    const char *hold = a->held_count > 1 ? "hold" : "holds";
    if (isfinite(a->needs)) {
        a->verdict = DIG_NEEDS;
        a->ok = isnan(k->q->with);
        snprintf(a->because, sizeof a->because, "%s %s it; it needs %.4g %s", who, hold, a->needs, unit(k));
    } else {
        a->verdict = DIG_BLOCKED;
        snprintf(a->because, sizeof a->because, "%s %s it, whatever the push", who, hold);
    }
    return DIG_OK;
}

#define ONWARD 1.2              /* times what starts it, */
#define INERTIA 0.05            /* and so much of its weight: what takes it all its way in time, and no farther into what is there */

/* a->needs starts it. Does something stop it on its way? */
static dig_status look_on_its_way(Ask *k, bool *stopped)
{
    dig_answer *a = k->a, said = *a;
    const dig_question *asked = k->q;
    dig_question pushed = *asked;
    char start[64];
    Trial t = {0};
    *stopped = false;
    pushed.with = ONWARD * a->needs + INERTIA * ask_weight(k);
    k->q = &pushed;
    dig_status status = try_push(k, pushed.with, &t, stopped);
    *stopped = *stopped && !gets_there(k, &t);
    if (status == DIG_OK && *stopped) {
        a->moved = real_max(0, real_min(t.moved, pushed.by));
        a->time = (real)t.steps * k->copy->def.step;
        note_moves(k);
        status = answer_stopped(k);
        size_t length = (size_t)snprintf(start, sizeof start, "%.4g %s start it: ", said.needs, unit(k));
        if (length + strlen(a->because) < sizeof a->because) {
            memmove(a->because + length, a->because, strlen(a->because) + 1);
            memcpy(a->because, start, length);
        }
    } else {
        said.trials = a->trials;
        said.steps = a->steps;
        *a = said;
    }
    k->q = asked;
    return status;
}

static dig_status answer_how_much(Ask *k)
{
    dig_answer *a = k->a;
    bool stopped = false;
    DIG_TRY(ask_needs(k, ask_weight(k), false, &a->needs));
    if (isfinite(a->needs))
        DIG_TRY(look_on_its_way(k, &stopped));
    if (stopped)
        return DIG_OK;
    if (a->needs > ASK_FREE * ask_weight(k))
        return answer_held(k, 0.5 * a->needs);
    a->verdict = DIG_FREE;
    a->ok = true;
    add_self(k);
    snprintf(a->because, sizeof a->because, "nothing holds it");
    return DIG_OK;
}

/* It does not get there: stopped by something, or too slow, or it does not start. */
static dig_status answer_short(Ask *k, bool stopped)
{
    dig_answer *a = k->a;
    real starts = NAN;
    if (!stopped && a->moved > 0)
        DIG_TRY(ask_draw(k, ASK_MOST * ask_weight(k), &starts));
    bool moved = a->moved >= ASK_LITTLE * ask_scale(k), free = starts <= ASK_FREE * ask_weight(k);
    if (stopped && moved)
        return answer_stopped(k);
    if (!stopped && (moved || free))
        return answer_slow(k, starts, free);
    DIG_TRY(ask_needs(k, k->q->with, true, &a->needs));
    return answer_held(k, k->q->with);
}

static dig_status answer_push(Ask *k)
{
    dig_answer *a = k->a;
    Trial t = {0};
    bool stopped;
    DIG_TRY(try_push(k, k->q->with, &t, &stopped));
    note_moves(k);
    a->moved = real_min(t.moved, k->q->by);
    a->time = (real)t.steps * k->copy->def.step;
    if (!gets_there(k, &t))
        return answer_short(k, stopped);
    a->verdict = DIG_FREE;
    a->ok = true;
    add_self(k);
    snprintf(a->because, sizeof a->because, "it moves %.4g %s in %.3g s", k->q->by, way_unit(k), a->time);
    ask_add_broken(k, a->because, sizeof a->because);
    return DIG_OK;
}

static dig_status answer(Ask *k)
{
    dig_answer *a = k->a;
    if (!ask_conflict(k->part.world, k->body, a->held, &a->held_count)) {
        DIG_TRY(settle_part(k));
        return isnan(k->q->with) ? answer_how_much(k) : answer_push(k);
    }
    char who[160];
    a->verdict = DIG_CONFLICT;
    a->needs = INFINITY;
    memcpy(a->chain, a->held, sizeof a->chain);
    a->chain_count = a->held_count;
    snprintf(a->because, sizeof a->because, "%s turn against each other", ask_name_holders(k, who, sizeof who));
    return DIG_OK;
}

/* ---- the call ---- */

static dig_status check(const World *w, const dig_question *q)
{
    DIG_TRY(api_finite(w, q->along, "ask", "along", "1"));
    DIG_TRY(api_finite(w, q->at, "ask", "at", "m"));
    if (!(vec3_largest(vec3_abs(q->along)) > 0))
        return world_fail(w, DIG_E_ARG, "ask: along = {0, 0, 0}, must not be zero: it is a direction");
    if (!(q->by > 0 && q->by <= 1e6))
        return world_fail(w, DIG_E_ARG, "ask: by = %g %s, must be > 0: for the other way reverse %s", q->by, q->turns ? "rad" : "m",
                          q->turns ? "the axis" : "the direction");
    if (!isnan(q->with) && !(q->with > 0 && q->with <= 1e30))
        return world_fail(w, DIG_E_ARG, "ask: with = %g %s, must be > 0", q->with, q->turns ? "N m" : "N");
    if (!(q->within > 0 && q->within <= 1e4))
        return world_fail(w, DIG_E_ARG, "ask: within = %g s, must be > 0 and at most 10000 s", q->within);
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "ask: not while the world is stepping");
    return DIG_OK;
}

static void name_in_world(const Part *p, dig_part *parts, int count)
{
    for (int i = 0; i < count; i++) {
        if (parts[i].body.gen)
            parts[i].body.slot = part_body_from(p, parts[i].body.slot);
        if (parts[i].joint.gen)
            parts[i].joint.slot = part_joint_from(p, parts[i].joint.slot);
    }
}

dig_status dig_ask(dig_world *w, const dig_question *q, dig_answer *a)
{
    *a = (dig_answer){.verdict = DIG_UNKNOWN, .needs = NAN};
    const Body *b = api_body(w, q->body, "ask");
    if (!b)
        return DIG_E_DEAD;
    DIG_TRY(check(w, q));
    if (b->kind != DIG_DYNAMIC) {
        a->verdict = DIG_BLOCKED;
        a->needs = INFINITY;
        a->held[a->held_count++] = a->chain[a->chain_count++] = (dig_part){.body = q->body};
        snprintf(a->because, sizeof a->because, "%s is %s", BODY_TEXT(w, b), b->kind == DIG_STATIC ? "fixed" : "kinematic: it moves as it is told");
        return DIG_OK;
    }
    Ask k = {.w = w, .q = q, .a = a, .along = vec3_unit(q->along)};
    k.local = q->has_at ? quat_unrotate(b->q, vec3_sub(q->at, b->x)) : vec3_zero();
    dig_status s = open_part(&k);
    if (s == DIG_OK)
        s = answer(&k);
    name_in_world(&k.part, a->held, a->held_count);
    name_in_world(&k.part, a->chain, a->chain_count);
    for (int i = 0; i < a->consequence_count; i++)
        name_in_world(&k.part, &a->consequences[i].who, 1);
    close_part(&k);
    return s;
}
