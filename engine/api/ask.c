/* api/ask.c - could this happen? A question is put to a copy of the world, in which it is tried; the world itself never notices.
 *
 * Stages, the cheap ones first, ending with the first that decides:
 *   1  what is fixed does not move; gears that contradict each other (ask_linkage.c) do not turn;
 *   2  the push, tried: does the body move at all within a few steps, and then as far as was asked?
 *   3  it does not: how much more would it need? Speeds after a few steps are linear in the push above the threshold, so that two
 *      of them say where it is; then halving;
 *   4  what holds it? That without which it would move: its links are taken away one by one, the firmest first.
 *
 * The copy is stepped like any world: an answer is what would come out, not a guess about it.
 */
#include "api/api.h"

#include <stdio.h>
#include <stdlib.h>

#define FEW         6           /* steps after which what has not started will not          */
#define HELD        1e-7        /* m/s: what the solver leaves of a speed that is held      */
#define STARTS      1e-4        /* m/s: faster than this after a few steps, and it moves    */
#define A_LITTLE    1e-3        /* m: less is not moved                                     */
#define MOST        1e3         /* times the weight of a DIG: no push is stronger           */
#define SHARP       2e-3        /* of the force needed, relative                            */
#define FREE        5e-3        /* times the weight of a DIG: what needs less is free           */
#define LINKS       24          /* of a body that are tried to be taken away                */

typedef struct Ask {
    const World *w;
    const dig_question *q;
    dig_answer *a;
    vec3 along;                 /* unit                                  */
    vec3 local;                 /* m, where it is pushed, body axes from the centre of mass */
    dig_part links[LINKS]; int link_count;
} Ask;

typedef struct Trial {          /* one copy, pushed */
    World *copy;
    vec3   start;               /* m, of the point that is watched */
    real   moved, speed, faster;        /* m or rad so far; its rate now, and how much that grew in the last step */
    int    steps;
} Trial;

const char *dig_verdict_name(dig_verdict v)
{
    static const char *const names[] = {"free", "blocked", "needs", "conflict", "unknown"};
    return (unsigned)v < sizeof names / sizeof *names ? names[v] : "";
}

dig_question dig_question_defaults(void) { return (dig_question){.by = 0.01, .with = NAN, .within = 5}; }

/* ---- a copy that is pushed ---- */

static void open_lock(World *copy, dig_part p)
{
    static const char *const walls[] = {"", "+x", "-x", "+y", "-y", "+z", "-z"};
    bool no = false;
    if (p.joint.gen && dig_joint_alive(copy, p.joint))
        dig_joint_remove(copy, p.joint);
    else if (p.wall)
        dig_room_open(copy, walls[p.wall], true);
    else if (p.body.gen)
        dig_body_set(copy, p.body, "collides", &no);
}

static void make_unbreakable(World *copy)
{
    for (int i = 0; i < copy->joints.count; i++)
        copy->joints.data[i].breaks_at = 0;
}

static vec3 point_now(const Ask *k, const World *w)
{
    const Body *b = &w->bodies.data[k->q->body.slot];
    return vec3_add(b->x, quat_rotate(b->q, k->local));
}

static real rate_now(const Ask *k, const World *w)
{
    const Body *b = &w->bodies.data[k->q->body.slot];
    vec3 arm = quat_rotate(b->q, k->local);
    return k->q->turns ? vec3_dot(b->w, k->along) : vec3_dot(vec3_add(b->v, vec3_cross(b->w, arm)), k->along);
}

/* without: what is taken away before. */
static dig_status begin(Ask *k, real push, const dig_part *without, int count, bool unbreakable, Trial *t)
{
    const dig_question *q = k->q;
    *t = (Trial){0};
    if (api_clone(k->w, &t->copy) != DIG_OK)
        return world_fail(k->w, DIG_E_MEMORY, "ask: not enough memory for a copy of the world");
    k->a->trials++;
    for (int i = 0; i < count; i++)
        open_lock(t->copy, without[i]);
    if (unbreakable)
        make_unbreakable(t->copy);
    t->start = point_now(k, t->copy);
    t->speed = rate_now(k, t->copy);
    vec3 act = vec3_scale(push, k->along);
    return q->turns ? dig_body_twist(t->copy, q->body, act, 1e6) : dig_body_push(t->copy, q->body, act, t->start, true, 1e6);
}

static void end(Trial *t)
{
    dig_world_close(t->copy);
    t->copy = NULL;
}

static dig_status step(Ask *k, Trial *t)
{
    real before = t->speed;
    dig_status s = dig_world_step(t->copy);
    if (s != DIG_OK)
        return world_fail(k->w, s, "ask: %s", dig_error(t->copy));
    k->a->steps++;
    t->steps++;
    t->speed = rate_now(k, t->copy);
    t->faster = t->speed - before;
    t->moved = k->q->turns ? t->moved + 0.5 * (before + t->speed) * t->copy->def.step : vec3_dot(vec3_sub(point_now(k, t->copy), t->start), k->along);
    return DIG_OK;
}

/* m/s or rad/s  of a body this large */
static real scale(const Ask *k) { return k->q->turns ? 1 / real_max(1e-9, k->w->bodies.data[k->q->body.slot].outer) : 1; }

/* A few steps of a copy: does it start? *rate: how fast it is then. */
static dig_status starts(Ask *k, real push, const dig_part *without, int count, bool *does, real *rate)
{
    Trial t;
    dig_status s = begin(k, push, without, count, true, &t);
    *does = false;
    while (s == DIG_OK && t.steps < FEW) {
        s = step(k, &t);
        if (t.steps >= 2 && fabs(t.speed) < HELD * scale(k) && fabs(t.moved) < HELD * scale(k))
            break;
    }
    if (s == DIG_OK)
        *does = t.speed > STARTS * scale(k) && t.moved > 0;
    *rate = t.speed;
    end(&t);
    return s;
}

/* ---- how much would it need? ---- */

static real weight(const Ask *k)
{
    const World *w = k->w;
    real mass = 0;
    for (uint32_t m = graph_lead(w->graph, k->q->body.slot); m != NONE; m = graph_next(w->graph, m))
        mass += w->bodies.data[m].mass;
    return mass * real_max(1, vec3_length(w->def.gravity)) * (k->q->turns ? real_max(1e-9, w->bodies.data[k->q->body.slot].outer) : 1);
}

/* One more push between those two. */
static dig_status halve(Ask *k, real push, real *low, real *high, real *rate)
{
    bool does;
    real r;
    if (!(push > *low && push < *high))
        return DIG_OK;
    DIG_TRY(starts(k, push, NULL, 0, &does, &r));
    *(does ? high : low) = push;
    *rate = does ? r : *rate;
    return DIG_OK;
}

/* Between a push that does not start it and one that does, after which it is that fast. Where it would start by the line through
 * two such points is tried from both sides; where that is not it (what sticks is held by more than what slides), halves. */
static dig_status narrow(Ask *k, real low, real high, real rate, real *needs)
{
    for (int i = 0; i < 12 && high - low > SHARP * high; i++) {
        bool does;
        real r, beyond = 1.1 * high;
        DIG_TRY(starts(k, beyond, NULL, 0, &does, &r));
        real root = r > rate ? high - rate * (beyond - high) / (r - rate) : 0;
        DIG_TRY(halve(k, root * (1 + 0.4 * SHARP), &low, &high, &rate));
        DIG_TRY(halve(k, root * (1 - 0.4 * SHARP), &low, &high, &rate));
        if (high - low > SHARP * high)
            DIG_TRY(halve(k, 0.5 * (low + high), &low, &high, &rate));
    }
    *needs = high;
    return DIG_OK;
}

/* From a push that starts it down to one that does not. */
static dig_status search_down(Ask *k, real high, real rate, real *needs)
{
    bool does = true;
    real r;
    while (high > FREE * weight(k)) {
        real low = 0.25 * high;
        DIG_TRY(starts(k, low, NULL, 0, &does, &r));
        if (!does)
            return narrow(k, low, high, rate, needs);
        high = low;
        rate = r;
    }
    *needs = high;
    return DIG_OK;
}

/* infinite: no push starts it */
static dig_status find_needs(Ask *k, real push, real *needs)
{
    bool does;
    real rate, most = MOST * weight(k);
    *needs = INFINITY;
    DIG_TRY(starts(k, push, NULL, 0, &does, &rate));
    if (does)
        return search_down(k, push, rate, needs);
    for (real low = push; low < most; low *= 4) {
        DIG_TRY(starts(k, 4 * low, NULL, 0, &does, &rate));
        if (does)
            return narrow(k, low, 4 * low, rate, needs);
    }
    return DIG_OK;
}

/* ---- what holds it? ---- */

static bool at_limit(const World *w, uint32_t joint)
{
    real memory[JOINT_MEMORY];
    JointView view;
    api_joint_view(w, joint, &view, memory);
    const JointType *type = w->joints.data[joint].type;
    return type->at_limit && type->at_limit(&view);
}

static void add_link(Ask *k, dig_part p)
{
    if (k->link_count < LINKS)
        k->links[k->link_count++] = p;
}

static void add_joints(Ask *k, const World *w, uint32_t body, int rank)
{
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body)) {
        const JointRec *r = &w->joints.data[j];
        int own = r->type->free_axes == 0 ? 0 : at_limit(w, j) ? 1 : r->type->couples ? 3 : 5;
        if (own == rank)
            add_link(k, (dig_part){.joint = joint_handle(w, j)});
    }
}

/* Those that move, then those that do not, then walls. */
static void add_touches(Ask *k, const World *w, uint32_t body, int rank)
{
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!t->alive || t->pairs == 0 || (t->body_a != body && t->body_b != body))
            continue;
        uint32_t other = t->body_a == body ? t->body_b : t->body_a;
        int own = other != NONE && w->bodies.data[other].kind == DIG_DYNAMIC ? 2 : 4;
        dig_part wall = {.wall = t->wall}, part = {.body = body_handle(w, other)};
        if (own == rank)
            add_link(k, other == NONE ? wall : part);
    }
}

/* All that the body hangs on, the firmest first. */
static void list_links(Ask *k, const World *w)
{
    k->link_count = 0;
    for (int rank = 0; rank < 6; rank++) {
        add_joints(k, w, k->q->body.slot, rank);
        add_touches(k, w, k->q->body.slot, rank);
    }
}

/* The first link without which it would move; or, where there is none, as many of them as it takes. */
static dig_status find_holders(Ask *k, real push)
{
    dig_answer *a = k->a;
    bool does = false;
    real rate;
    list_links(k, k->w);
    for (int i = 0; i < k->link_count && !does; i++) {
        DIG_TRY(starts(k, push, &k->links[i], 1, &does, &rate));
        if (does)
            a->held[a->held_count++] = k->links[i];
    }
    for (int n = 2; n <= k->link_count && !does; n++) {
        DIG_TRY(starts(k, push, k->links, n, &does, &rate));
        for (int i = 0; does && i < int_min(n, DIG_ANSWER_PARTS); i++)
            a->held[a->held_count++] = k->links[i];
    }
    return DIG_OK;
}

/* ---- the way the message took ---- */

static void add_chain(dig_answer *a, dig_part p)
{
    if (a->chain_count < DIG_ANSWER_PARTS)
        a->chain[a->chain_count++] = p;
}

/* From a body to the nearest that stands firm, without passing the one that asked. */
static void chain_to_ground(Ask *k, uint32_t from)
{
    const World *w = k->w;
    int n = w->bodies.count, head = 0, tail = 0;
    uint32_t *parent = malloc((size_t)n * sizeof *parent), *queue = malloc((size_t)n * sizeof *queue), way[DIG_ANSWER_PARTS], found = NONE;
    if (parent && queue) {
        memset(parent, 0xff, (size_t)n * sizeof *parent);
        parent[k->q->body.slot] = k->q->body.slot;
        parent[from] = from;
        queue[tail++] = from;
    }
    while (head < tail && found == NONE) {
        uint32_t node = queue[head++];
        if (!graph_has_node(w->graph, node)) {
            found = node;
            break;
        }
        for (uint32_t l = graph_link_first(w->graph, node); l != GRAPH_END; l = graph_link_next(w->graph, node, l)) {
            const GraphLink *link = graph_link(w->graph, l);
            uint32_t next = link->a == node ? link->b : link->a;
            if (parent[next] == NONE) {
                parent[next] = node;
                queue[tail++] = next;
            }
        }
    }
    int count = 0;
    for (uint32_t b = found == NONE ? from : found; count < DIG_ANSWER_PARTS; b = parent[b]) {
        way[count++] = b;
        if (b == from)
            break;
    }
    while (count > 0)
        add_chain(k->a, (dig_part){.body = body_handle(w, way[--count])});
    free(parent);
    free(queue);
}

static void tell_chain(Ask *k)
{
    dig_answer *a = k->a;
    add_chain(a, (dig_part){.body = k->q->body});
    if (a->held_count == 0)
        return;
    dig_part p = a->held[0];
    uint32_t next = p.body.slot;
    if (p.joint.gen) {
        const JointRec *r = &k->w->joints.data[p.joint.slot];
        add_chain(a, p);
        next = r->a == k->q->body.slot ? r->b : r->a;
    } else if (p.wall) {
        add_chain(a, p);
        next = NONE;
    }
    if (next != NONE)
        chain_to_ground(k, next);
}

static void name_part(const World *w, dig_part p, char *text, size_t capacity)
{
    static const char *const walls[] = {"", "+x", "-x", "+y", "-y", "+z", "-z"};
    if (p.joint.gen) {
        const JointRec *r = &w->joints.data[p.joint.slot];
        snprintf(text, capacity, "%s%s%s%s", r->type->name, r->name[0] ? " '" : "", r->name, r->name[0] ? "'" : "");
    } else if (p.wall) {
        snprintf(text, capacity, "the wall %s of the room", walls[p.wall]);
    } else {
        const Body *b = &w->bodies.data[p.body.slot];
        if (b->name[0])
            snprintf(text, capacity, "body '%s'", b->name);
        else
            snprintf(text, capacity, "body #%u", p.body.slot);
    }
}

static const char *list_holders(const Ask *k, char *text, size_t capacity)
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < k->a->held_count && at < capacity; i++) {
        char name[100];
        name_part(k->w, k->a->held[i], name, sizeof name);
        at += (size_t)snprintf(text + at, capacity - at, "%s%s", i ? " and " : "", name);
    }
    return text[0] ? text : "what it hangs on";
}

/* ---- the push, tried to its end ---- */

static void add_consequence(dig_answer *a, const char *what, dig_part who, real amount)
{
    if (a->consequence_count < DIG_ANSWER_PARTS)
        a->consequences[a->consequence_count++] = (dig_consequence){what, who, amount};
}

static void note_breaks(Ask *k, const World *copy)
{
    for (int i = 0; i < copy->events.count; i++)
        if (copy->events.data[i].kind == DIG_EVENT_BROKEN)
            add_consequence(k->a, "broken", (dig_part){.joint = copy->events.data[i].joint}, copy->events.data[i].impulse / copy->def.step);
}

static void note_moves(Ask *k, const World *copy)
{
    for (int i = 0; i < k->w->bodies.count; i++) {
        const Body *was = &k->w->bodies.data[i], *is = &copy->bodies.data[i];
        if (!was->alive || was->kind != DIG_DYNAMIC || (uint32_t)i == k->q->body.slot)
            continue;
        real far = vec3_distance(was->x, is->x);
        if (far > A_LITTLE && vec3_length(was->v) < STARTS)
            add_consequence(k->a, "moves", (dig_part){.body = body_handle(k->w, (uint32_t)i)}, far);
    }
}

/* At rest, and not starting? */
static bool stuck(const Ask *k, const Trial *t)
{
    bool slow = fabs(t->speed) < STARTS * scale(k) && t->faster < 0.2 * STARTS * scale(k);
    bool held = t->steps >= 2 && fabs(t->speed) < HELD * scale(k) && fabs(t->moved) < HELD * scale(k);
    return held || (t->steps >= FEW && slow);
}

/* *stopped: by something, not by the clock. Then *w_end is the copy as it ended, to be asked what stopped it. */
static dig_status try_push(Ask *k, Trial *t, bool *stopped)
{
    const dig_question *q = k->q;
    dig_status s = begin(k, q->with, NULL, 0, false, t);
    *stopped = false;
    while (s == DIG_OK && t->moved < q->by && (real)t->steps * t->copy->def.step < q->within && !*stopped) {
        s = step(k, t);
        if (s == DIG_OK) {
            note_breaks(k, t->copy);
            *stopped = t->moved < q->by && stuck(k, t);
        }
    }
    if (s != DIG_OK)
        return s;
    note_moves(k, t->copy);
    k->a->moved = real_min(t->moved, q->by);
    k->a->time = (real)t->steps * t->copy->def.step;
    return DIG_OK;
}

static const char *unit(const Ask *k) { return k->q->turns ? "N m" : "N"; }

/* It went a part of the way: what stopped it is asked of the copy, there. */
static dig_status answer_partly(Ask *k, Trial *t, bool stopped)
{
    dig_answer *a = k->a;
    const World *w = k->w;
    char who[160] = "time";
    if (stopped) {
        k->w = t->copy;
        dig_status s = find_holders(k, k->q->with);
        if (s == DIG_OK)
            tell_chain(k);
        list_holders(k, who, sizeof who);
        k->w = w;
        DIG_TRY(s);
    } else {
        add_chain(a, (dig_part){.body = k->q->body});
    }
    a->verdict = DIG_FREE;
    snprintf(a->because, sizeof a->because, "it moves %.4g of %.4g %s, then %s %s", a->moved, k->q->by, k->q->turns ? "rad" : "m",
             stopped ? who : "time", !stopped ? "is up" : a->held_count > 1 ? "stop it" : "stops it");
    return DIG_OK;
}

static dig_status answer_held(Ask *k, real from)
{
    dig_answer *a = k->a;
    char who[160];
    DIG_TRY(find_needs(k, from, &a->needs));
    DIG_TRY(find_holders(k, from));
    tell_chain(k);
    list_holders(k, who, sizeof who);
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

static dig_status answer_push(Ask *k)
{
    dig_answer *a = k->a;
    Trial t;
    bool stopped;
    if (isnan(k->q->with)) {
        DIG_TRY(find_needs(k, weight(k), &a->needs));
        if (a->needs > FREE * weight(k))
            return answer_held(k, isfinite(a->needs) ? 0.5 * a->needs : weight(k));
        a->verdict = DIG_FREE;
        a->ok = true;
        add_chain(a, (dig_part){.body = k->q->body});
        snprintf(a->because, sizeof a->because, "nothing holds it");
        return DIG_OK;
    }
    dig_status s = try_push(k, &t, &stopped);
    if (s == DIG_OK && t.moved >= k->q->by * (1 - 1e-12)) {
        a->verdict = DIG_FREE;
        a->ok = true;
        add_chain(a, (dig_part){.body = k->q->body});
        snprintf(a->because, sizeof a->because, "it moves %.4g %s in %.3g s", k->q->by, k->q->turns ? "rad" : "m", a->time);
    } else if (s == DIG_OK && fabs(t.moved) >= A_LITTLE * scale(k)) {
        s = answer_partly(k, &t, stopped);
    } else if (s == DIG_OK) {
        end(&t);
        return answer_held(k, k->q->with);
    }
    end(&t);
    return s;
}

/* ---- the call ---- */

static dig_status check(const World *w, const dig_question *q)
{
    DIG_TRY(api_finite(w, q->along, "ask", "along", "1"));
    DIG_TRY(api_finite(w, q->at, "ask", "at", "m"));
    if (!(vec3_length(q->along) > 0))
        return world_fail(w, DIG_E_ARG, "ask: along = {0, 0, 0}, must not be zero: it is a direction");
    if (!(q->by > 0 && q->by <= 1e6))
        return world_fail(w, DIG_E_ARG, "ask: by = %g %s, must be > 0", q->by, q->turns ? "rad" : "m");
    if (!isnan(q->with) && !(q->with > 0 && q->with <= 1e30))
        return world_fail(w, DIG_E_ARG, "ask: with = %g %s, must be > 0", q->with, q->turns ? "N m" : "N");
    if (!(q->within > 0 && q->within <= 1e4))
        return world_fail(w, DIG_E_ARG, "ask: within = %g s, must be > 0 and at most 10000 s", q->within);
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "ask: not while the world is stepping");
    return DIG_OK;
}

dig_status dig_ask(dig_world *w, const dig_question *q, dig_answer *a)
{
    *a = (dig_answer){.verdict = DIG_UNKNOWN, .needs = NAN};
    const Body *b = api_body(w, q->body, "ask");
    if (!b)
        return DIG_E_DEAD;
    DIG_TRY(check(w, q));
    Ask k = {.w = w, .q = q, .a = a, .along = vec3_unit(q->along)};
    k.local = q->has_at ? quat_unrotate(b->q, vec3_sub(q->at, b->x)) : vec3_zero();
    if (b->kind != DIG_DYNAMIC) {
        a->verdict = DIG_BLOCKED;
        a->needs = INFINITY;
        a->held[a->held_count++] = a->chain[a->chain_count++] = (dig_part){.body = q->body};
        snprintf(a->because, sizeof a->because, "body '%s' is %s", b->name, b->kind == DIG_STATIC ? "fixed" : "kinematic: it moves as it is told");
        return DIG_OK;
    }
    if (api_linkage_conflict(w, q->body.slot, a->held, &a->held_count)) {
        char who[160];
        a->verdict = DIG_CONFLICT;
        a->needs = INFINITY;
        memcpy(a->chain, a->held, sizeof a->chain);
        a->chain_count = a->held_count;
        snprintf(a->because, sizeof a->because, "%s turn against each other", list_holders(&k, who, sizeof who));
        return DIG_OK;
    }
    return answer_push(&k);
}
