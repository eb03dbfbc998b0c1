/* trace/pass.c - the start of a frame, and what is done where the trace finds no step: the group is swept past that place, for a small
 * part of the frame, and traced on from there.
 *
 * Where points chatter, or no choice of who presses and slides agrees with itself, that is so in one configuration; a little later
 * bodies are in another. Were the whole frame swept instead, its first-order errors would be those of the whole frame.
 */
#include "trace/trace.h"

#define PASS_LEAST (1.0 / 64)   /* of the frame; twice that where it fails again at once, and so on */
#define FAILED 0.9              /* of the frame: where so much was passed, it is not tried again at once */

static Hold hold_of(Group *g, int joint, const Row *r)
{
    GroupJoint *j = &g->joints[joint];
    if (isinf(r->hi)) {
        group_find_bulk(g);
        j->looped = j->looped || (r->rate != 0 && group_in_loop(g, joint));
    }
    real bound = j->looped || j->lags ? group_motor_most(g, j, r) : group_motor_lag(g, r);
    return (Hold){.joint = joint, .slot = r->slot, .most = j->looped ? bound : r->hi, .lag = bound, .target = r->kind == ROW_MOTOR ? r->rate : 0};
}

static void list_drives(Tracer *t)
{
    t->stop_count = t->hold_count = 0;
    for (int j = 0; j < t->g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_LIMIT)
                t->stops[t->stop_count++] = (Stop){.gate.presses = t->g->joints[j].force[r->slot] > 0, .joint = j, .slot = r->slot};
            else if (r->kind == ROW_MOTOR || r->kind == ROW_DRY)
                t->holds[t->hold_count++] = hold_of(t->g, j, r);
        }
}

static bool overlaps(const Tracer *t)
{
    for (int i = 0; i < t->touch_count; i++)
        if (!t->touch[i].gate.presses && t->touch[i].gate.gap < -t->gap_deep)
            return true;
    return false;
}

static bool beyond_stop(const Tracer *t)
{
    for (int j = 0; j < t->g->joint_count; j++)
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_LIMIT && r->error < -BEYOND)
                return true;
        }
    return false;
}

bool trace_squeezed(Tracer *t)
{
    Group *g = t->g;
    if (!g->driven || !squeeze_possible(g))
        return false;
    if (squeeze_open(g) == DIG_OK)
        group_squeeze(g, JAWS_ALL, 0);
    else
        g->status = DIG_E_MEMORY;
    bool any = g->squeezes;
    g->squeezes = false;
    for (int i = 0; i < g->contact_count && any && !t->fault; i++)
        if (g->squeezed[i].rate > g->close_speed)
            t->fault = "something is squeezed that cannot give way";
    return t->fault;
}

bool trace_start(Tracer *t)
{
    Group *g = t->g;
    for (int i = 0; i < g->joint_count; i++)
        group_joint_view(g, i);
    trace_keep_angles(t);
    t->touch_count = 0;
    trace_kinematics(t);        /* its joints; contacts are found below */
    list_drives(t);
    trace_drives(t);
    trace_bonds(t);
    t->dirty = true;
    if (g->pair_count > 0 ? !trace_touch(t, true) : !trace_items(t))
        return false;
    if (overlaps(t))
        t->fault = "bodies that overlap";
    else if (!trace_squeezed(t) && t->stop_count > 0 && beyond_stop(t))
        t->fault = "a joint beyond its stop";
    return !t->fault;
}

/* Mechanisms that nothing presses are for the way that keeps their energy. */
bool trace_may_pass(const Tracer *t)
{
    bool presses = t->g->joint_count == 0;
    for (int i = 0; i < t->touch_count && !presses; i++)
        presses = t->touch[i].gate.presses;
    return presses && t->passes < t->g->plan->trace_passes && t->g->status == DIG_OK;
}

static real length_of(Tracer *t)
{
    bool again = t->passes > 0 && t->t - t->pass_end < 1e-3 * t->end;
    t->pass = again ? 2 * t->pass : PASS_LEAST * t->end;
    t->passes++;
    real rest = t->end - t->t;
    bool last = t->passes == t->g->plan->trace_passes || t->g->evaluations > t->work || rest < 1.5 * t->pass;
    return last ? rest : t->pass;
}

bool trace_pass(Tracer *t)
{
    Group *g = t->g;
    real touch = g->touch, close_speed = g->close_speed, h = g->h, length = length_of(t);
    int events_left = g->events_left;
    trace_load(t, t->y, t->t);
    trace_remember(t);
    for (int j = 0; j < g->joint_count; j++) {
        g->joints[j].view.followed = false;
        memcpy(g->joints[j].force, &t->joint_force[j * JOINT_SLOTS], sizeof g->joints[j].force);
    }
    g->touch = 1e-7;
    g->trace_failed = true;         /* at this place: it is swept the finer */
    g->status = sweep_piece(g, t->end, t->t + length < t->end ? t->t + length : t->end);
    g->touch = touch;
    g->close_speed = close_speed;
    g->h = h;
    g->events_left = events_left;
    g->locate = true;
    g->joints_direct = false;
    g->passed += length;
    g->trace_failed = g->passed > FAILED * t->end;
    g->gave_up = t->fault ? t->fault : "no step";
    if (g->woke || g->status != DIG_OK)
        return true;
    t->fault = NULL;
    t->conserves = t->turns = false;
    t->near_events = t->probe_wait = 0;
    t->t = t->pass_end = t->mark = g->t;
    t->mark_work = g->evaluations;
    t->h_next = t->pass;
    trace_store(t, t->y);
    trace_load(t, t->y, t->t);
    return trace_start(t);
}
