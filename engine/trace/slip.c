/* trace/slip.c - slips so slow that friction turns them within a step: they are held in their direction, or steps stay short of where they end. */
#include "trace/trace.h"

#define AIMS  8                 /* passes and change of direction, rad, that find where a slip aims */
#define AIMED 1e-6

/* The direction in which a held slip needs no force across it, and the velocities that go that way. Friction turns so slow a slip
 * there within much less than the step, but steps that follow it would use up the budget. */
static bool aim_slips(Tracer *t)
{
    Group *g = t->g;
    for (int pass = 0; pass < AIMS; pass++) {
        real worst = 0;
        for (int i = 0; i < t->touch_count; i++) {
            Cone *c = &t->touch[i].slip;
            if (!t->touch[i].gate.presses || !c->axes || c->grip != GRIP_SLIP || !c->locked)
                continue;
            vec3 d = vec3_unit_or(vec3_neg(c->force), c->d);
            worst = real_max(worst, vec3_distance(d, c->d));
            c->d = d;
        }
        trace_align(t);
        if (!trace_accelerate(t))
            return false;
        if (worst < AIMED)
            break;
    }
    real kinetic = group_kinetic(g);
    if (!trace_project(t, false))
        return false;
    g->work_in += t->given;
    g->lost += kinetic + t->given - group_kinetic(g);
    trace_store(t, t->y);
    trace_load(t, t->y, t->t);
    trace_kinematics(t);
    return trace_accelerate(t);
}

bool trace_slow_slip(const Tracer *t, const Touching *c, real h)
{
    if (!c->gate.presses || !c->slip.axes || c->slip.grip != GRIP_SLIP)
        return false;
    real press = c->slip.moving * c->gate.force, push = press * (t->g->mass[c->a].im + t->g->mass[c->b].im);
    return vec3_length2(c->slip.u) < 4 * h * h * real_max(push * push, vec3_length2(c->slip.acc));
}

bool trace_any_slow_slip(const Tracer *t, real h)
{
    for (int i = 0; i < t->touch_count; i++)
        if (trace_slow_slip(t, &t->touch[i], h))
            return true;
    return false;
}

/* Rows across the slips of a patch that turns on its place leave it no way to move: then none is held. */
static bool accelerate_held(Tracer *t)
{
    if (trace_accelerate(t))
        return true;
    bool any = false;
    for (int i = 0; i < t->touch_count; i++) {
        any = any || t->touch[i].slip.locked;
        t->touch[i].slip.locked = false;
    }
    if (!any || t->g->status != DIG_OK)
        return false;
    t->fault = NULL;
    return trace_accelerate(t);
}

/* What a row across a slip does, over what may be neglected. */
static real held_by(const Tracer *t, const Touching *c)
{
    real press = c->slip.moving * c->gate.force, lateral = fabs(c->slip.lateral);
    if (!c->slip.locked || !(lateral > 1e-6 * press))
        return 0;
    if (!(press > 0))
        return INFINITY;
    return vec3_length(c->slip.u) * lateral / (t->tolerance * t->pace * press);
}

/* The most of it at the end of a tried step: from rest a slip may have got so fast within it that it had to turn. */
real trace_held_most(const Tracer *t)
{
    real most = 0;
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].gate.presses && t->touch[i].gate.force > 0 && t->touch[i].slip.axes)
            most = real_max(most, held_by(t, &t->touch[i]));
    return most;
}

#define SHORT_OF 0.49           /* of the time that a slip has left: past half of it the slip would be held in its direction */
#define LEFT_ASIDE (1.0 / 32)   /* of the tolerance: such a way aside no step notices */

/* s  What drags a slip aside turns it the faster the slower it gets: where it comes to its end a step over that end is refused, and the next one, and
 * so on. */
real trace_short_of_turns(const Tracer *t, real h)
{
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        real speed = vec3_length(c->slip.u), slows = speed > 0 ? -vec3_dot(c->slip.acc, c->slip.u) / speed : 0;
        if (!c->gate.presses || !c->slip.axes || c->slip.grip != GRIP_SLIP || !(slows * h > SHORT_OF * speed))
            continue;
        real aside = c->slip.locked ? fabs(c->slip.lateral) / (c->slip.moving * c->gate.force)
                                    : vec3_length(vec3_mad(c->slip.acc, slows / speed, c->slip.u)) / slows;
        if (aside * speed * speed > LEFT_ASIDE * t->tolerance * slows)
            h = SHORT_OF * speed / slows;
    }
    return h;
}

/* A slip so slow that its direction would turn within the step is held in its direction, with a row across it. */
bool trace_hold_slow_slips(Tracer *t, real h, bool aim)
{
    bool changed = false;
    for (int i = 0; i < t->touch_count; i++) {
        Touching *c = &t->touch[i];
        if (!c->gate.presses || !c->slip.axes || c->slip.grip != GRIP_SLIP)
            continue;
        bool slow = trace_slow_slip(t, c, h);
        real speed = vec3_length(c->slip.u);
        if (slow && !c->slip.locked && speed > 0)
            c->slip.d = vec3_scale(1 / speed, c->slip.u);
        changed = changed || slow != c->slip.locked || (aim && slow);
        c->slip.locked = slow;
    }
    if (!changed && !t->locks)
        return true;
    t->locks = false;
    trace_align(t);
    if (changed && !accelerate_held(t))
        return false;
    if (aim && !aim_slips(t))
        return false;
    bool released = false;
    for (int i = 0; i < t->touch_count && !aim; i++) {
        Touching *c = &t->touch[i];
        if (held_by(t, c) > 1) {
            c->slip.locked = false;
            released = true;
        }
    }
    if (released && !trace_accelerate(t))
        return false;
    if (changed || released)
        trace_keep(t, 0);
    return true;
}
