/* trace/hang.c - one body that hangs by one joint on what stands still, and meets nothing: what the ways for that ask and book alike. */
#include "trace/trace.h"

#define PAIRS  4                /* most of what is near */
#define CLOSED 1e-13            /* of the size: what hangs off its place by no more is in it */
#define DRIFT  1e-2             /* the same, of the tolerance */

#define PART   0.5              /* rad: so far a part of the step turns at most, at the rate of its own swing, too */
#define PARTS  64               /* most of them: what turns faster is the tracer's */

int hang_parts(real turn) { return turn < PART * PARTS ? (int)real_max(1, ceil(turn / PART)) : 0; }

bool hang_suits(const Group *g)
{
    if (g->joint_count != 1 || g->moving_count != 1 || !trace_untouched(g, PAIRS) || g->push_count > 0 || g->planar || !g->may_trace)
        return false;
    if (g->own || g->varies || g->drags || g->rules || g->world->region_count > 0)
        return false;
    const GroupJoint *j = &g->joints[0];
    const Member *m = &g->member[0];
    if (j->breaks_at > 0 || j->broken || !m->moves || m->integrator != DIG_AUTO)
        return false;
    return j->a == 0 ? member_still(g, j->b) : j->b == 0 && member_still(g, j->a);
}

bool hang_look(Group *g, Hang *hang)
{
    GroupJoint *j = &g->joints[0];
    const Member *m = &g->member[0];
    group_joint_view(g, 0);
    bool is_a = j->a == 0;
    *hang = (Hang){.is_a = is_a, .own = is_a ? &j->view.a : &j->view.b, .other = is_a ? &j->view.b : &j->view.a, .before = g->vel[0]};
    real size = m->outer;
    hang->least = real_max(CLOSED, DRIFT * trace_tolerance(g)) * size;
    hang->slowest = hang->least * sqrt(real_max(g->fall, 1e-3 * size) / size);
    return isfinite(size) && size > 0;
}

bool hang_holds(const Hang *hang)
{
    vec3 slip = vec3_add(hang->before.v, vec3_cross(hang->before.w, hang->own->r));
    return vec3_distance(hang->own->p, hang->other->p) <= hang->least && vec3_length(slip) <= hang->slowest;
}

bool hang_apart(Group *g, real h, real way)
{
    const Member *m = &g->member[0];
    real foreseen = h * (vec3_length(g->vel[0].v) + m->outer * vec3_length(g->vel[0].w) + h * m->pull) + group_thrown(g, 0, h);
    bool apart = true;
    for (int i = 0; i < g->pair_count; i++) {
        group_touch_pair(g, &g->pairs[i], h);
        if (way > foreseen)
            group_touch_within(g, &g->pairs[i], g->pairs[i].reach + way - foreseen);
        apart = apart && !g->pairs[i].hidden && !g->contacts[g->pairs[i].contact].live;
    }
    g->looked = true;
    if (apart)
        trace_leave_pairs(g);
    return apart;
}

vec3 hang_impulse(const Group *g, const Hang *hang, real h)
{
    const Member *m = &g->member[0];
    return vec3_mad(vec3_scale(m->mass, vec3_sub(g->vel[0].v, hang->before.v)), -h, m->force);
}

void hang_book_impulses(Group *g, const Hang *hang, vec3 impulse, vec3 about_centre, vec3 couple)
{
    GroupJoint *j = &g->joints[0];
    if (hang->is_a) {
        j->impulse = impulse;
        j->angular_impulse = about_centre;
    } else if (j->a >= 0) {
        j->impulse = vec3_neg(impulse);
        j->angular_impulse = vec3_neg(vec3_add(couple, vec3_cross(j->view.a.r, impulse)));
    }
}

int hang_rows(Group *g, Row rows[JOINT_SLOTS])
{
    GroupJoint *j = &g->joints[0];
    RowList list = {rows, 0, JOINT_SLOTS};
    group_joint_move(g, 0);
    j->view.type->rows(&j->view, &list);
    memset(j->force, 0, sizeof j->force);
    for (int i = 0; i < list.count; i++)
        if (rows[i].kind == ROW_HARD)
            g->joint_error = real_max(g->joint_error, fabs(rows[i].error));
    return list.count;
}

dig_status hang_advance(Group *g, real dt, bool (*follow)(Group *g, real h))
{
    real h = g->h;
    g->h = dt;
    DIG_TRY(group_forces(g));
    if (!follow(g, dt)) {
        g->h = h;
        g->handed_on = true;
        return DIG_OK;
    }
    g->member[0].constrained = true;
    g->evaluations = g->substeps = 1;
    g->t = g->trace_step = dt;
    return g->stage(g, STAGE_SETTLE);
}
