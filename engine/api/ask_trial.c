/* api/ask_trial.c - a copy is pushed, or drawn, and stepped like any world; before the next trial it is put back. */
#include "api/ask.h"

#define FEW         6           /* steps after which what has not started will not                  */
#define HELD        1e-7        /* m/s: what the solver leaves of a speed that is held              */
#define CLEAR       1e-2        /* m: who got so far in fewer steps has started, and not just closed a gap */
#define CLEAR_OF    1e-3        /* m: the same, of one without something that may have held it      */
#define CRAWL       4e-3        /* m/s: how fast it is drawn; slower, and it counts as at rest (step/rest.c)  */
#define DRAWN       3           /* steps: one for inertia, two that must agree                      */
#define SAME        1e-3        /* of two forces that agree, relative                               */

real ask_scale(const Ask *k) { return k->q->turns ? 1 / real_max(1e-9, k->part.world->bodies.data[k->body].outer) : 1; }

real ask_weight(const Ask *k)
{
    const World *w = k->part.world;
    real mass = 0;
    for (uint32_t m = graph_lead(w->graph, k->body); m != GRAPH_END; m = graph_next(w->graph, m))
        mass += w->bodies.data[m].mass;
    return mass * real_max(1, vec3_length(w->def.gravity)) / ask_scale(k);
}

/* ---- the copy ---- */

static vec3 point_now(const Ask *k)
{
    const Body *b = &k->copy->bodies.data[k->body];
    return vec3_add(b->x, quat_rotate(b->q, k->local));
}

static real rate_now(const Ask *k)
{
    const Body *b = &k->copy->bodies.data[k->body];
    vec3 arm = quat_rotate(b->q, k->local);
    return k->q->turns ? vec3_dot(b->w, k->along) : vec3_dot(vec3_add(b->v, vec3_cross(b->w, arm)), k->along);
}

static void open_lock(World *copy, dig_part p)
{
    bool no = false;
    if (p.joint.gen && dig_joint_alive(copy, p.joint))
        dig_joint_remove(copy, p.joint);
    else if (p.wall)
        dig_room_open(copy, dig_wall_name(p.wall), true);
    else if (p.body.gen)
        dig_body_set(copy, p.body, "collides", &no);
}

dig_status ask_no_memory(const Ask *k) { return world_fail(k->w, DIG_E_MEMORY, "ask: not enough memory for a copy of the DIG"); }

dig_status ask_use_copy(Ask *k)
{
    if ((k->used || !k->copy) && (k->copy ? api_refill(k->copy, k->part.world) : api_clone(k->part.world, &k->copy)) != DIG_OK)
        return ask_no_memory(k);
    k->used = true;
    return DIG_OK;
}

static dig_status prepare(Ask *k, Trial *t)
{
    *t = (Trial){0};
    DIG_TRY(ask_use_copy(k));
    k->a->trials++;
    t->start = point_now(k);
    t->speed = rate_now(k);
    return DIG_OK;
}

static void make_unbreakable(World *copy)
{
    for (int i = 0; i < copy->joints.count; i++)
        copy->joints.data[i].breaks_at = 0;
}

/* What begins with a jerk is hard to trace exactly, and need not be: who only wants to know whether it starts has it swept. */
static void sweep_it(World *copy)
{
    for (int i = 0; i < copy->bodies.count; i++)
        copy->bodies.data[i].trace_wait = FEW;
}

static dig_status act(Ask *k, real push, const Trial *t)
{
    dig_body body = body_handle(k->copy, k->body);
    vec3 force = vec3_scale(push, k->along);
    dig_status s = k->q->turns ? dig_body_twist(k->copy, body, force, 1e6) : dig_body_push(k->copy, body, force, t->start, true, 1e6);
    return s == DIG_OK ? s : world_fail(k->w, s, "ask: %s", dig_error(k->copy));
}

dig_status ask_push(Ask *k, real push, Trial *t)
{
    DIG_TRY(prepare(k, t));
    return act(k, push, t);
}

dig_status ask_step(Ask *k, Trial *t)
{
    real before = t->speed;
    dig_status s = dig_world_step(k->copy);
    if (s != DIG_OK)
        return world_fail(k->w, s, "ask: %s", dig_error(k->copy));
    k->a->steps++;
    t->steps++;
    t->speed = rate_now(k);
    t->faster = t->speed - before;
    t->moved = k->q->turns ? t->moved + 0.5 * (before + t->speed) * k->copy->def.step : vec3_dot(vec3_sub(point_now(k), t->start), k->along);
    return DIG_OK;
}

static bool is_held(const Ask *k, const Trial *t)
{
    return t->steps >= 2 && fabs(t->speed) < HELD * ask_scale(k) && fabs(t->moved) < HELD * ask_scale(k);
}

/* What only its inertia holds back speeds up as evenly at last as at first; what is held creeps, or comes to rest. */
bool ask_stuck(const Ask *k, const Trial *t)
{
    bool slow = fabs(t->speed) < ASK_STARTS * ask_scale(k) && t->faster < 0.2 * ASK_STARTS * ask_scale(k);
    bool speeds_up = t->faster > 0 && t->faster * t->steps > 0.5 * fabs(t->speed);
    return is_held(k, t) || (t->steps >= FEW && slow && !speeds_up);
}

/* far: m, where it is sure before the last of the steps. */
static dig_status few_steps(Ask *k, real push, real far, Trial *t, bool *does)
{
    *does = false;
    make_unbreakable(k->copy);
    sweep_it(k->copy);
    DIG_TRY(act(k, push, t));
    while (t->steps < FEW && !is_held(k, t) && !(t->steps >= 2 && t->moved > far * ask_scale(k) && t->faster > 0))
        DIG_TRY(ask_step(k, t));
    *does = t->speed > ASK_STARTS * ask_scale(k) && t->moved > 0;
    return DIG_OK;
}

dig_status ask_starts(Ask *k, real push, bool *does, real *rate)
{
    Trial t;
    DIG_TRY(prepare(k, &t));
    DIG_TRY(few_steps(k, push, CLEAR, &t, does));
    *rate = t.speed / t.steps * FEW;            /* it speeds up evenly, or nearly so */
    return DIG_OK;
}

dig_status ask_starts_without(Ask *k, real push, const dig_part *parts, int count, bool *does)
{
    Trial t;
    DIG_TRY(prepare(k, &t));
    for (int i = 0; i < count; i++)
        open_lock(k->copy, parts[i]);
    return few_steps(k, push, CLEAR_OF, &t, does);
}

/* ---- the push as an unknown ---- */

/* One row: what draws the point along a line of the world, or the body about it. */
static void draw_rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    rows_translation(&one, j, ROW_MOTOR, j->b.axis, 0);
    rows_motor(out, &like, j->params, 0);
}

static void twist_rows(const JointView *j, RowList *out)
{
    Row like;
    RowList one = {&like, 0, 1};
    rows_spin(&one, j, ROW_MOTOR, j->b.axis, 0);
    rows_motor(out, &like, j->params, 0);
}

static const JointType draw  = {.name = "draw", .params_size = sizeof(DriveMotor), .free_axes = 5, .rows = draw_rows};
static const JointType twist = {.name = "twist", .params_size = sizeof(DriveMotor), .free_axes = 5, .rows = twist_rows, .angular = true};

static dig_status add_draw(Ask *k, real most, uint32_t *slot)
{
    World *w = k->copy;
    const Body *b = &w->bodies.data[k->body];
    vec3 u, n;
    vec3_basis(k->along, &u, &n);
    quat frame = quat_from_matrix(mat3_transpose((mat3){k->along, u, n}));
    uint32_t gen;
    if (world_generation(w, "ask", &gen) != DIG_OK || world_slot(w, &w->joints, &w->free_joints, slot) != DIG_OK)
        return world_fail(k->w, DIG_E_MEMORY, "ask: not enough memory for a joint");
    JointRec *j = &w->joints.data[*slot];
    *j = (JointRec){.gen = gen, .alive = true, .collides = true, .type = k->q->turns ? &twist : &draw,
                    .a = k->body, .b = NONE, .other = {NONE, NONE}, .link = NONE, .next_a = NONE, .next_b = NONE,
                    .ra = k->local, .rb = point_now(k), .fa = quat_mul(quat_conjugate(b->q), frame), .fb = frame};
    *(DriveMotor *)(void *)j->params = (DriveMotor){CRAWL * ask_scale(k), most};
    joint_attach(w, *slot);
    body_wake(w, k->body);
    return DIG_OK;
}

dig_status ask_draw(Ask *k, real most, real *force)
{
    Trial t;
    uint32_t slot;
    real before = NAN, now = NAN, crawl = CRAWL * ask_scale(k);
    DIG_TRY(prepare(k, &t));
    make_unbreakable(k->copy);
    sweep_it(k->copy);
    bool still = fabs(t.speed) < ASK_STARTS * ask_scale(k);
    DIG_TRY(add_draw(k, most, &slot));
    while (t.steps < DRAWN) {
        DIG_TRY(ask_step(k, &t));
        const JointRec *j = &k->copy->joints.data[slot];
        before = now;
        now = vec3_dot(k->q->turns ? j->torque : j->force, k->along);
    }
    bool steady = fabs(t.speed - crawl) < 0.05 * crawl && fabs(now - before) <= SAME * (fabs(now) + ASK_FREE * ask_weight(k));
    bool in_vain = fabs(t.speed) < 0.05 * crawl;
    *force = still && steady ? now : still && in_vain ? INFINITY : NAN;
    return DIG_OK;
}
