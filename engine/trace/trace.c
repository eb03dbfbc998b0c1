/* trace/trace.c - the traced way: from event to event through a frame, on a private copy, within a budget of counts. */
#include "solve/momentum.h"
#include "trace/trace.h"

#define CHATTER       40        /* events within CHATTER_TIME of the frame                   */
#define CHATTER_TIME  1e-10
#define GRAZES        8         /* of them after which a friction that lets go and holds again... */
#define GRAZE         1e-6      /* ...holds this part of its bound more                       */
#define AIM_WORK      0.25      /* of the budget: past it, or where it crawls, slow slips follow their forces, in steps of */
#define AIM_STEP      (1.0 / 32)        /* the frame */
#define CRAWL_WORK    (1.0 / 8) /* of the budget, for less than                               */
#define CRAWL         (1.0 / 32)        /* of the frame                                       */
#define SMALL         4         /* bodies, joints and pairs                                   */
#define STEP_LEAST    1e-10     /* of the frame: a step this short without an event is none  */
#define SHORTER_MOST  1e-4      /* of the frame: a step longer than this may fail once more   */
#define ROUGH         0.5       /* of a cut step: so much of it may do where its own error is too large */
#define REACH         0.2       /* of a step: the error of one this short tells nothing of it  */
#define ROUNDED       1e-15     /* of the fastest: joints cannot hold velocities better       */
#define JOINT_DRIFT   1e-2      /* of the tolerance: a joint that much off is put right       */
#define BOUNCE_LEAST  1e-13     /* of the size: bounces lower than this are over             */

/* why: what was tried in vain; NULL: it is left to another way, which serves as well. */
static void hand_on(Group *g, const GroupKept *k, const char *why)
{
    group_put_back(g, k);
    for (int i = 0; i < g->joint_count; i++)
        g->joints[i].view.passing = g->joints[i].view.followed = false;
    g->handed_on = true;
    g->gave_up = why;
    g->trace_failed = why != NULL;
}

/* ---- a frame ---- */

void trace_scales(Tracer *t)
{
    const Group *g = t->g;
    real size = 0, weight = g->fall;
    for (int i = 0; i < g->moving_count; i++)
        size = real_max(size, g->member[i].outer);
    t->size = size > 0 && isfinite(size) ? size : 1;
    t->pace = weight > 0 ? sqrt(weight / t->size) : 1;
    t->tolerance = trace_tolerance(g) * t->size;
    t->gap_zero = 1e-10 * t->size;
    t->gap_deep = 1e-6 * t->size;
    t->speed_zero = sqrt(2 * weight * BOUNCE_LEAST * t->size) + 1e-9 * t->size;
    t->slip_zero = real_max(1e-7 * t->size * t->pace, 10 * t->tolerance * t->pace);
}

void trace_begin(const Tracer *t)
{
    Group *g = t->g;
    g->close_speed = t->speed_zero;
    g->touch = 1e-9;
    g->locate = true;
    g->h = 1e-14;               /* forces are those of this instant */
    g->events_left = g->plan->events;
}

static bool approaching(const Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].gate.gap <= t->gap_zero && t->touch[i].gate.rate < -0.1 * t->g->close_speed)
            return true;
    for (int i = 0; i < t->stop_count; i++)
        if (t->stops[i].gate.gap <= 1e-9 && t->stops[i].gate.rate < -0.1 * t->g->close_speed)
            return true;
    return false;
}

/* m/s  Of any point. */
static real fastest(const Tracer *t)
{
    const Group *g = t->g;
    real most = 0;
    for (int i = 0; i < g->moving_count; i++)
        most = real_max(most, vec3_length(g->vel[i].v) + g->member[i].outer * vec3_length(g->vel[i].w));
    return most;
}

#define JERK       2            /* times: the share of the energy that goes, over the share of the speed that is put right */
#define JERK_LEAST 1e-4         /* of the energy */

/* Contacts that hardly differ may agree only at velocities far from these: what then goes is not what was off. In arches that fall 1e-8 m/s
 * that were off took 2.8 J of 450, 1.7 million times their share, and 3 mm/s 0.16 J of 53, 4 times theirs; elsewhere it is 0.02 at most, and
 * up to 8 where next to nothing goes. What holds its speed may be off, too, by what counts as none: a friction that brings all to rest takes
 * all there is. */
static bool jerks(Tracer *t, real kinetic, real off)
{
    if (t->hold_count > 0)
        off = real_max(off, t->slip_zero);
    real gone = fabs(kinetic + t->given - group_kinetic(t->g)), share = JERK * off / real_max(fastest(t), 1e-300);
    if (gone <= real_max(JERK_LEAST, share) * kinetic)
        return false;
    t->fault = "contacts that hardly differ";
    return true;
}

/* What drifted or was overlooked by a solver with other habits is put right, first in place, then in velocity. At the start of a
 * frame that is the jerk of joints and contacts whose velocities others, a script among them, left apart: it is lost. What nothing but
 * the way before left across joints is given back; where that is much, it is left to that way. */
static bool close_all(Tracer *t, bool start, bool *moved)
{
    Violation v = trace_violation(t);
    real least = real_max(1e-13 * t->size, ROUNDED * fastest(t) / t->pace);
    for (int pass = 0; pass < 8; pass++) {
        real off = real_max(v.joints, v.gates);
        if (v.joints <= real_max(least, JOINT_DRIFT * t->tolerance) && v.gates <= real_max(1e-13 * t->size, GATE_DRIFT * t->tolerance))
            return true;
        *moved = true;
        t->touched = -1;        /* manifolds have other gaps now */
        if (!trace_project(t, true))
            return false;
        trace_store(t, t->y);
        trace_load(t, t->y, t->t);
        trace_kinematics(t);
        real kinetic = group_kinetic(t->g);
        bool mirrored = start && off > t->tolerance && trace_mirrored(t);      /* less is made good at the frame's end */
        if (mirrored)
            trace_mark_motion(t);
        if (!trace_project(t, false))
            return false;
        if (mirrored && !trace_hold_motion(t)) {
            t->left = true;
            return false;
        }
        if (!start && v.gates > 0 && jerks(t, kinetic, off))
            return false;
        if (start && !mirrored && (!t->conserves || off > t->tolerance)) {
            t->conserves = false;
            t->g->work_in += t->given;
            t->g->lost += kinetic + t->given - group_kinetic(t->g);
        }
        trace_store(t, t->y);
        trace_load(t, t->y, t->t);
        trace_kinematics(t);
        v = trace_violation(t);
        real left = real_max(v.joints, v.gates);        /* another corner may be the nearest now, with another normal */
        if (left > 0.5 * off)
            return real_max(off, left) < real_max(1e-8 * t->size, t->tolerance) || (t->fault = "joints or contacts that cannot be closed", false);
    }
    return true;
}

/* What could not be put right is left as it was. */
static bool put_right(Tracer *t, bool start, bool *moved)
{
    Group *g = t->g;
    real lost = g->lost, work_in = g->work_in;
    memcpy(t->kept, t->y, (size_t)g->moving_count * sizeof *t->kept);
    if (close_all(t, start, moved))
        return true;
    memcpy(t->y, t->kept, (size_t)g->moving_count * sizeof *t->y);
    g->lost = lost;
    g->work_in = work_in;
    return false;
}

static void mark_start(Tracer *t)
{
    trace_keep_angles(t);
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        t->conserves = t->conserves && !c->gate.presses;
        c->gate.gap0 = c->gate.gap;
        c->gate.rate0 = c->gate.rate;
        c->gate.acc0 = c->gate.acc;
        c->gate.force0 = c->gate.force;
        c->slip.from = c->slip.d;
        c->roll.from = c->roll.d;
    }
    for (int i = 0; i < t->stop_count; i++) {
        Gate *g = &t->stops[i].gate;
        t->conserves = t->conserves && !g->presses;
        g->gap0 = g->gap;
        g->rate0 = g->rate;
        g->acc0 = g->acc;
        g->force0 = g->force;
    }
    for (int i = 0; i < t->bond_count; i++)
        t->bonds[i].start = trace_load_on(t, t->bonds[i].joint);
    for (int i = 0; i < t->g->moving_count; i++) {
        t->spin0[i] = t->g->vel[i].w;
        t->alpha0[i] = t->alpha[i];
    }
}

/* What a blow stopped does not go on sliding the way its rounding points. */
static void end_slips(Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (vec3_length(c->slip.u) <= t->slip_zero)
            c->slip.grip = GRIP_STICK;
        if (t->size * vec3_length(c->roll.u) <= t->slip_zero)
            c->roll.grip = GRIP_STICK;
    }
}

/* What a blow made faster may pass through a thin wall that was too far off to be looked at before, within the step. */
static bool look_farther(Tracer *t)
{
    if (!group_outruns(t->g, t->end - t->t))
        return true;
    bool found = trace_touch(t, false);
    trace_kinematics(t);
    return found;
}

#define LIVELY 0.5              /* restitution: what bounces less comes to rest */

/* Do two that move bounce on from a blow now? Then each of many blows within an instant is worth its evaluations: swept past, they hand on less.
 * Not so what clatters on what stands still. */
static bool bounces_on(const Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        if (c->gate.gap <= t->gap_zero && c->gate.rate > t->g->close_speed && trace_moves(t, c->a) && trace_moves(t, c->b)
            && t->g->pairs[t->g->contacts[c->contact].pair].rub->restitution >= LIVELY)
            return true;
    }
    return false;
}

/* Blows first, then who presses and slides; and these are put right. */
static bool settle_once(Tracer *t, bool first, bool *moved)
{
    Group *g = t->g;
    if (!first)
        trace_kinematics(t);
    if (approaching(t) && t->touched != t->t) {     /* no step that only opens or sticks looks for contacts: blows go by these */
        if (!trace_touch(t, false))
            return false;
        trace_kinematics(t);
    }
    bool struck = approaching(t);
    if (struck) {
        trace_remember(t);
        g->t = t->t;
        g->patches = true;
        g->strikes_stops = t->stop_count > 0;
        impacts(g);
        g->patches = g->strikes_stops = false;
        g->located++;
        if (g->status != DIG_OK)
            return false;
        trace_store(t, t->y);
        trace_load(t, t->y, t->t);
        trace_kinematics(t);
        end_slips(t);
        if (bounces_on(t)) {
            t->mark_work = g->evaluations;
            t->mark = t->t;
        }
        if (!look_farther(t) || !trace_bounce(t) || trace_squeezed(t))
            return false;
    }
    *moved = false;
    if (first)
        trace_sides(t);         /* what pushes with its bound, does: no jerk stops it */
    if (first && !struck && !trace_jerk(t))
        return false;
    if (first && !struck && !put_right(t, true, moved))          /* another way may have left the closed ones a little off; a blow opens some */
        return false;
    t->shifted = t->shifted || *moved;
    *moved = false;
    g->evaluations++;
    return trace_kinds(t, first) && put_right(t, false, moved) && (!*moved || trace_accelerate(t));
}

#define ROUNDS 4

/* Finds the kinds anew at the present state. To put right what presses may set another corner going inward, as where the way before left the corners
 * of a face a little off: that is a blow again. */
static bool settle(Tracer *t, bool first)
{
    bool moved = true;
    for (int round = 0; round < ROUNDS && moved && (round == 0 || approaching(t)); round++)
        if (!settle_once(t, first && round == 0, &moved))
            return false;
    trace_keep(t, 0);
    t->dirty = false;
    t->probe_wait = 0;
    return true;
}

/* Evaluations of a small group cost less: it may use more. */
static int work_of(const Tracer *t)
{
    const Group *g = t->g;
    return (g->moving_count + g->joint_count + g->pair_count <= SMALL ? 4 : 1) * g->plan->trace_work;
}

/* A force that grazes the bound of its friction and turns while it does may neither stick nor slip in one direction: from one instant
 * to the next it would do both in turn. After a few such it holds a little more. */
static bool count_event(Tracer *t, const Event *e)
{
    Group *g = t->g;
    g->events++;
    if (t->t - t->event_time > CHATTER_TIME * t->end)
        t->near_events = 0;
    t->near_events++;
    t->event_time = t->t;
    if (t->near_events > GRAZES && e->cone && e->kind != EVENT_YIELD)
        e->cone->holds = GRAZE;
    if (t->near_events > CHATTER || g->events > 4 * g->plan->events)
        t->fault = "events that do not end";
    return !t->fault;
}

static void go_back(Tracer *t)
{
    trace_load(t, t->y, t->t);
    t->dirty = true;            /* the contacts found there are not those of before: their kinds are found anew */
}

#define SWINGS 1.5              /* rad in the frame: what swings farther */

/* It may come back within the frame, whose ends do not tell where it was. */
static void note_ways(Tracer *t)
{
    Group *g = t->g;
    for (int i = 0; i < g->moving_count && t->t < t->end && t->swing * t->end > SWINGS; i++) {
        const Member *m = &g->member[i];
        if (!m->moves)
            continue;
        quat turned = quat_mul(t->y1[i].q, quat_conjugate(g->world->bodies.data[m->slot].q));
        group_note_swing(g, i, t->y1[i].x, vec3_length(quat_log(quat_unit(turned))));
    }
}

#define OFF       0.25          /* of the smaller size */
#define OFF_LEAST (1.0 / 64)    /* of the frame: what slides farther in less is followed no finer */

static bool stays(const Tracer *t, const Touching *o)
{
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].contact == o->contact && t->touch[i].id == o->id)
            return true;
    return false;
}

/* Has a point that presses slid so far that it may have lost its hold within the step? A box is over the edge of a table with its middle as it has
 * slid on by half its length: found with the part of it that is over the edge, its points there tell when it tips. And where such points come
 * to lie on each other, their forces change signs at once, and tell nothing of what was before. */
static bool slid_far(const Tracer *t, const Touching *list, int count, bool looked)
{
    for (int i = 0; i < count && t->h > OFF_LEAST * t->end; i++) {
        const Touching *o = &list[i];
        if (!o->gate.presses || t->h * vec3_length(o->slip.u) <= OFF * t->g->pairs[t->g->contacts[o->contact].pair].size)
            continue;
        FeatureKind kind = o->feature.kind;
        bool on_edge = kind == PLANE_POINT ? trace_moves(t, o->a) : kind == POINT_PLANE ? trace_moves(t, o->b) : kind <= LINE_LINE;
        if (on_edge || (looked && !stays(t, o)))
            return true;
    }
    return false;
}

/* Does that press still which will have got over an edge? */
static bool nears_edge(const Tracer *t) { return t->over > t->t && trace_presses(t, t->over_contact); }

#define HELD  (1.0 / 16)        /* of the frame: a step this short may hold a slip wherever it would turn: to follow that from rest takes scores of steps */
#define HELD_AT 1e-6            /* of the size: with this tolerance; what it is off by then goes with the step's third power */
#define EDGE 1e-7               /* of the frame: when something gets over an edge is found to that */

/* The tried step becomes the state. Contacts are looked for at its end; should something be deep in something that nobody
 * watched, the step is taken back. */
static bool accept_step(Tracer *t, const Event *e, bool *taken)
{
    Group *g = t->g;
    real end = t->t + t->h >= t->end * (1 - 1e-14) ? t->end : t->t + t->h, begin = t->t;
    bool look = g->pair_count > 0 && (e->kind == EVENT_NONE || e->kind == EVENT_CLOSE);
    trace_mean(t);
    *taken = false;
    t->t = end;
    bool finer = t->h > EDGE * t->end, found = !look || trace_touch(t, false);
    if (!found && !(t->unplaced && finer)) {
        t->t = begin;
        return false;
    }
    if (!found)                 /* edges so deep in each other that they seem to cross elsewhere: earlier they do not */
        t->fault = NULL;
    bool before = look && t->relisted;
    const Touching *list = before ? t->old_touch : t->touch;
    int count = before ? t->old_count : t->touch_count;
    int over = -1;
    if (finer && (!found || (look && trace_missed(t, &over)) || slid_far(t, list, count, before))) {
        t->over = over >= 0 ? end : t->over;
        t->over_contact = over >= 0 ? over : t->over_contact;
        t->t = begin;
        t->h_next = 0.5 * t->h;
        g->refused++;
        go_back(t);
        return trace_touch(t, false);
    }
    if (t->over > begin && !nears_edge(t)) {    /* what it took to find that was well spent */
        t->over = -1;
        t->mark_work = g->evaluations;
        t->mark = t->t;
    }
    *taken = true;
    note_ways(t);
    trace_book(t, list, count, begin);
    State *old = t->y;
    t->y = t->y1;
    t->y1 = old;
    return true;
}

#define HARDER 2.0              /* times, at most: so much more is the error of the next step foreseen to be */

static bool slips(const Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].gate.presses && t->touch[i].slip.axes && t->touch[i].slip.grip == GRIP_SLIP)
            return true;
    return false;
}

/* s  The next step, after one that went well. Where errors grow from step to step, as of a slip that turns ever faster, it is foreseen that they
 * grow as much again: else each second step would be refused. */
static real grown(Tracer *t, real h, real error)
{
    real rate = error / (h * h * h * h * h), more = t->error_rate > 0 && slips(t) ? real_clamp(rate / t->error_rate, 1, HARDER) : 1;
    real factor = t->probed || !(error > 0) ? 5 : real_clamp(0.9 * pow(error * more, -0.2), 0.2, 5);
    t->error_rate = t->probed ? 0 : rate;
    return real_min(t->end, real_max(t->h_next * REACH > h ? t->h_next * real_min(factor, 1) : 0, h * factor));
}

static bool shorten(Tracer *t, real h, real factor)
{
    t->g->refused++;
    t->h_next = real_min(t->h_next, h * factor);        /* an aimed step may be longer */
    if (t->h_next < STEP_LEAST * t->end)
        t->fault = "steps that become too short";
    go_back(t);
    trace_kinematics(t);
    return !t->fault;
}

/* After a step without event: what drifted is put back, and the rates are taken again unless the change is beneath notice. */
static bool tidy(Tracer *t)
{
    if (t->known != t->y) {
        trace_load(t, t->y, t->t);
        trace_kinematics(t);
    }
    if (approaching(t)) {       /* a corner has passed an edge, and the face behind it faces elsewhere: that is a blow */
        t->dirty = true;
        return true;
    }
    bool moved = false;
    if (!put_right(t, false, &moved))
        return false;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (c->gate.closed && !c->gate.presses && c->gate.gap > t->gap_zero)
            c->gate.closed = false;
        if (c->gate.presses && c->slip.axes && c->slip.grip == GRIP_BRINK && vec3_length(c->slip.u) > t->slip_zero)
            t->dirty = true;
        bool stops = c->gate.presses && c->slip.axes && c->slip.grip == GRIP_SLIP && vec3_length(c->slip.u) < t->slip_zero
            && vec3_dot(c->slip.acc, c->slip.u) < 0;
        if (stops) {
            t->hint = (Event){.kind = EVENT_HALT, .cone = &c->slip};
            t->dirty = true;
        }
    }
    if (t->dirty)
        return true;
    if (moved) {                /* else the accelerations are those of the step's last evaluation */
        t->g->evaluations++;
        if (!trace_accelerate(t))
            return false;
    }
    trace_keep(t, 0);
    return true;
}

/* Does nothing move farther than rounding until the end? Then no force changes either, and nothing can happen. */
static bool at_rest(const Tracer *t, real h)
{
    const Group *g = t->g;
    real least = 1e-3 * t->gap_zero;
    if (g->own)                 /* what the caller's effects ask for may change with time alone */
        return false;
    for (int i = 0; i < t->bond_count; i++)
        if (t->bonds[i].start >= t->bonds[i].strength)
            return false;
    for (int i = 0; i < g->body_count; i++) {
        const Member *m = &g->member[i];
        if (m->kinematic && (vec3_length2(g->vel[i].v) > 0 || vec3_length2(g->vel[i].w) > 0))
            return false;
        if (m->moves && h * (vec3_length(g->vel[i].v) + h * vec3_length(t->acc[i])) > least)
            return false;
        if (m->moves && h * m->outer * (vec3_length(g->vel[i].w) + h * vec3_length(t->alpha[i])) > least)
            return false;
    }
    return true;
}

static void rest_on(Tracer *t, real h)
{
    trace_parabola(t, h);
    trace_mean(t);
    trace_book(t, t->touch, t->touch_count, t->t);
    State *old = t->y;
    t->y = t->y1;
    t->y1 = old;
    trace_load(t, t->y, t->end);
    t->known = t->y;            /* as far as rounding goes */
    t->t = t->end;
    t->h_next = t->end;
}

/* What comes to rest within a frame is touched where it lies now: else by where it was when that was last looked for, for as long as it rests. */
static bool rest_here(Tracer *t, real rest)
{
    if (t->touched != t->t) {
        if (!trace_touch(t, false))
            return false;
        t->dirty = t->dirty || t->relisted;
    }
    if (!t->dirty)
        rest_on(t, rest);
    return true;
}

/* rad  Of the fastest spring, in a step. Where its swing is below the tolerance no error tells of a longer one, which adds to its energy. */
#define SWUNG 1.0

static bool one_step(Tracer *t)
{
    bool taken;
    real rest = t->end - t->t, h = real_min(rest, t->h_next);
    if (t->swing * h > SWUNG)
        h = SWUNG / t->swing;
    bool aim = t->aimed_at != t->t && (t->crawled || t->g->evaluations > AIM_WORK * t->work) && trace_any_slow_slip(t, AIM_STEP * t->end);
    if (aim) {
        h = real_min(rest, AIM_STEP * t->end);
        t->aimed_at = t->t;         /* once from each place: what is refused must get shorter */
    }
    else
        h = trace_short_of_turns(t, h);
    h = rest / ceil(rest / h - 0.01);
    if (nears_edge(t))
        h = real_min(h, real_max(0.5 * (t->over - t->t), EDGE * t->end));
    real meets = trace_aim(t, h);
    t->aims = meets < h;
    h = meets;
    if (!trace_hold_slow_slips(t, h, aim))
        return false;
    mark_start(t);
    if (at_rest(t, rest))
        return rest_here(t, rest);
    real error = trace_try(t, h), held = t->fault ? 0 : trace_held_most(t);
    if (held > 1 && h > HELD * cbrt(t->tolerance / (HELD_AT * t->size)) * t->end)
        return shorten(t, h, real_max(0.2, 0.9 * pow(held, -1.0 / 3)));
    if (t->fault && h > SHORTER_MOST * t->end) {    /* a stage far off its constraints: nearer it will do */
        t->fault = NULL;
        return shorten(t, h, 0.25);
    }
    Event e = {.kind = EVENT_NONE};
    if (!t->fault && error <= 1)
        e = trace_scan(t);
    if (t->fault)
        return false;
    if (!(error <= 1))
        return shorten(t, h, isfinite(error) ? real_max(0.2, 0.9 * pow(error, -0.2)) : 0.2);
    real part = e.kind == EVENT_SHORTER ? 0.25 : trace_unseen(t, &e);
    if (part < 1)
        return shorten(t, h, part);
    if (e.kind == EVENT_NONE) {
        t->h_next = grown(t, h, error);
        if (t->known != t->y1)
            trace_load(t, t->y1, t->t + t->h);
        if (!accept_step(t, &e, &taken))
            return false;
        t->probe_wait = int_max(0, t->probe_wait - 1);
        return t->dirty || t->t >= t->end ? true : tidy(t);
    }
    real rough = trace_stop_at(t, &e);
    if (!(rough <= 0))          /* no number either */
        return rough == INFINITY ? false : shorten(t, t->h, ROUGH);
    if (!accept_step(t, &e, &taken))
        return false;
    if (!taken)                 /* it is found again in a shorter one */
        return true;
    t->error_rate = 0;
    if (!count_event(t, &e))
        return false;
    if (e.kind == EVENT_HALT && e.cone)        /* what turned the faster the slower it got does so no more */
        t->h_next = t->end;
    if (e.kind == EVENT_BREAK)
        trace_part(t, &e);
    else if (e.kind != EVENT_CLOSE && !t->dirty)
        t->hint = e;
    t->dirty = true;
    return true;
}

/* So many evaluations for so little of the frame: the place is better passed than followed, or, in a plan without passes, the frame is lost. Where slow
 * slips may be what makes the steps short, they follow their forces first. */
static bool crawls(Tracer *t)
{
    if (t->g->evaluations - t->mark_work <= CRAWL_WORK * t->work || nears_edge(t))
        return false;
    bool slow = t->t - t->mark < CRAWL * t->end;
    t->mark_work = t->g->evaluations;
    t->mark = t->t;
    if (slow && !t->crawled && trace_any_slow_slip(t, AIM_STEP * t->end)) {
        t->crawled = true;
        return false;
    }
    return slow && (t->passes < t->g->plan->trace_passes || t->g->plan->trace_passes == 0);
}

/* A blow is solved to the last digit, and five boxes of restitution 1/2 on each other hand one to and fro: on a plate that tilts a frame of three
 * such stacks took 210,000 sweeps in 800 evaluations, 170 ms. So many sweeps are as dear as an evaluation, and count as one. */
#define BLOW_SWEEPS 25
/* Where directions of slip come nearer by little in each turn, an evaluation takes 130 of them, each with a factor of its own: two carts whose
 * wheels skid, 160 ms in 44 evaluations. So many turns count as one more. */
#define TURNS 4

static bool over_budget(Tracer *t)
{
    if (crawls(t) && t->t < t->end)
        t->fault = "steps that remain short";
    if (t->g->evaluations + t->g->sweeps / BLOW_SWEEPS + t->g->kind_turns / TURNS > t->work && t->t < t->end)
        t->fault = "more evaluations than its budget";
    return t->fault;
}

static bool run(Tracer *t)
{
    Group *g = t->g;
    t->even = g->push_count == 0 && g->world->region_count == 0 && !g->varies;
    trace_store(t, t->y);
    for (int i = 0; i < g->body_count; i++)
        t->mover_start[i] = g->pos[i];
    bool fine = trace_start(t);
    trace_mark_energy(t);
    t->swing = fine ? trace_fastest_swing(t) : 0;
    Stiffness stiffness = fine ? trace_stiffness(t) : STIFF_NOT;
    if (stiffness != STIFF_NOT) {
        t->fault = stiffness == STIFF_BEYOND ? "springs or dampers too stiff for its steps" : NULL;
        t->left = stiffness == STIFF_UNSEEN;
        return false;
    }
    bool first = true;
    while (!fine || (t->t < t->end && !g->woke)) {
        bool failed = !fine || (t->dirty && !settle(t, first)) || (!g->woke && (over_budget(t) || !one_step(t)));
        first = failed;
        fine = true;
        if (g->woke)
            return !t->fault;
        if (failed && !trace_may_pass(t))
            return false;
        if (failed)
            fine = trace_pass(t);
        if (g->status != DIG_OK)
            return false;
    }
    return true;
}

static dig_status advance(Group *g, real dt)
{
    Tracer tracer = {.g = g, .end = dt};
    Tracer *t = &tracer;
    GroupKept start;
    if (!group_keep(g, &start))             /* before anything is set: the next way is to find what was gathered */
        return DIG_E_MEMORY;
    trace_scales(t);
    trace_begin(t);
    t->work = work_of(t);
    t->h_next = g->trace_step > 0 ? real_min(g->trace_step, dt) : dt;
    t->over = t->aimed_at = -1;
    DIG_TRY(trace_reserve(t));
    bool fine = run(t);
    if (g->status != DIG_OK)
        return g->status;
    if (!fine) {
        hand_on(g, &start, t->left ? NULL : t->fault ? t->fault : "no step");
        return DIG_OK;
    }
    g->t = dt;
    if (!g->woke) {
        if (t->known != t->y) {
            trace_load(t, t->y, dt);
            trace_kinematics(t);
        }
        trace_refine(t, t->y);
        if (t->shifted || t->passes > 0 || t->stop_count > 0)   /* what was moved into place kept its velocities, not its angular momentum */
            DIG_TRY(group_hold_momenta(g, dt));
        trace_hold_energy(t);
        trace_finish(t);
        g->trace_step = t->h_next;
        g->h = dt;
        DIG_TRY(g->stage(g, STAGE_SETTLE));
    }
    g->touch = 1e-7;
    return g->status;
}

const Way way_trace = {.name = "trace", .tally = WAY_TRACED, .suits = trace_suits, .advance = advance, .inertias = true};
