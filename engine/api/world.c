/* api/world.c - opening, stepping and reading a world. */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>

Body *api_body(const World *w, dig_body b, const char *call)
{
    Body *body = world_body(w, b);
    if (!body)
        world_fail(w, DIG_E_DEAD, b.gen == 0 ? "%s: no body was given" : "%s: this body was removed, or belongs to another world", call);
    return body;
}

JointRec *api_joint(const World *w, dig_joint j, const char *call)
{
    JointRec *joint = world_joint(w, j);
    if (!joint)
        world_fail(w, DIG_E_DEAD, j.gen == 0 ? "%s: no joint was given" : "%s: this joint was removed, or belongs to another world", call);
    return joint;
}

dig_status api_finite(const World *w, vec3 v, const char *call, const char *what, const char *unit)
{
    if (vec3_finite(v))
        return DIG_OK;
    return world_fail(w, DIG_E_ARG, "%s: %s = {%g, %g, %g} %s must be finite", call, what, v.x, v.y, v.z, unit);
}

dig_status api_within(const World *w, vec3 v, real most, const char *call, const char *what, const char *unit)
{
    DIG_TRY(api_finite(w, v, call, what, unit));
    if (vec3_largest(vec3_abs(v)) <= most)
        return DIG_OK;
    return world_fail(w, DIG_E_ARG, "%s: %s = {%g, %g, %g} %s, must be at most %g %s", call, what, v.x, v.y, v.z, unit, most, unit);
}

dig_world_def dig_world_defaults(void)
{
    dig_world_def def;
    memset(&def, 0, sizeof def);
    dig_schema_defaults(dig_schema_at("world", 0), &def);
    def.gravity = (vec3){0, -9.81, 0};
    return def;
}

static dig_status check_world_def(const dig_world_def *def, char *why, size_t capacity)
{
    DIG_TRY(param_check(dig_schema_at("world", 0)->rows, def, "world", why, capacity));
    if (!vec3_finite(def->gravity)) {       /* of its row NAN only says that the default is none of one number */
        snprintf(why, capacity, "world: gravity = {%g, %g, %g}, must be finite", def->gravity.x, def->gravity.y, def->gravity.z);
        return DIG_E_ARG;
    }
    const char *p = def->plane.s, *f = def->friction_law.s;
    if (p[0] && strcmp(p, "xy") != 0 && strcmp(p, "yz") != 0 && strcmp(p, "xz") != 0) {
        snprintf(why, capacity, "world: plane = '%s', must be 'xy', 'yz' or 'xz'", p);
        return DIG_E_ARG;
    }
    if (f[0] && strcmp(f, "coulomb") != 0 && strcmp(f, "decay") != 0) {
        snprintf(why, capacity, "world: friction_law = '%s', must be 'coulomb' or 'decay'", f);
        return DIG_E_ARG;
    }
    if (def->accuracy.s[0] && accuracy_find(def->accuracy.s) == 0) {
        snprintf(why, capacity, "world: accuracy = '%s', must be sketch, play, study, reference or a length", def->accuracy.s);
        return DIG_E_ARG;
    }
    return DIG_OK;
}

dig_status dig_world_open(const dig_world_def *def, dig_world **out, char *why, size_t capacity)
{
    *out = NULL;
    DIG_TRY(check_world_def(def, why, capacity));
    World *w;
    dig_world_def settled = *def;
    param_settle(dig_schema_at("world", 0)->rows, &settled);
    DIG_TRY(world_open(&settled, &w, why, capacity));
    w->accuracy = !isnan(def->tolerance) ? accuracy_for(def->tolerance) : accuracy_find(def->accuracy.s[0] ? def->accuracy.s : "play");
    api_open_effects(w);
    arena_ready(&w->scratch);
    arena_ready(&w->group_scratch);
    if (def->threads > 1) {
        dig_status s = workers_open((int)def->threads, &w->workers);
        if (s != DIG_OK) {
            snprintf(why, capacity, "world: not enough memory for %d threads", (int)def->threads);
            world_close(w);
            return s;
        }
    }
    *out = w;
    return DIG_OK;
}

void dig_world_close(dig_world *w)
{
    if (w) {
        workers_close(w->workers);
        playback_close(w->playback);
        if (w->tap)
            w->tap->fn = NULL;
        tap_release(w->tap);
    }
    world_close(w);
}

const char *dig_error(const dig_world *w) { return w->error; }

static dig_status do_step(World *w)
{
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "world:step() cannot be called while the world is stepping");
    if (!w->ledger.started) {
        w->ledger.started = true;
        w->ledger.initial = dig_world_energy(w).total;
    }
    w->busy = true;
    int pending = w->pending.count;
    dig_status s = step_world(w);
    w->poisoned = (dig_body){0, 0};
    if (s != DIG_OK)
        w->pending.count = int_min(pending, w->pending.count);
    w->busy = false;
    return s;
}

dig_status run_step(World *w, CommandArg *a)
{
    (void)a;
    return do_step(w);
}

dig_status dig_world_step(dig_world *w)
{
    return COMMAND(w, COMMAND_STEP, do_step(w), {.what = NULL});
}

dig_body dig_world_culprit(const dig_world *w) { return w->culprit; }

static dig_status do_inject(World *w, dig_body b)
{
    dig_status s;
    if (!api_pushable(w, b, "inject", &s))
        return s;
    w->poisoned = b;
    body_wake(w, b.slot);
    return DIG_OK;
}

dig_status run_inject(World *w, CommandArg *a)
{
    return do_inject(w, a[0].body);
}

dig_status dig_world_inject(dig_world *w, dig_body b)
{
    return COMMAND(w, COMMAND_INJECT, do_inject(w, b), {.body = b});
}

real dig_world_time(const dig_world *w) { return world_time(w); }
uint64_t dig_world_steps(const dig_world *w) { return w->steps; }
real dig_world_frame(const dig_world *w) { return w->def.step; }
vec3 dig_world_gravity(const dig_world *w) { return w->def.gravity; }
uint64_t dig_world_work(const dig_world *w) { return w->work; }

uint64_t dig_world_checksum(const dig_world *w)
{
    world_work_through(w, 30);
    return world_hash(w);
}

dig_status dig_world_check(dig_world *w)
{
    world_work_through(w, 30);
    return world_check(w);
}

static dig_status do_set_gravity(World *w, vec3 g)
{
    DIG_TRY(api_finite(w, g, "world", "gravity", "m/s^2"));
    real before = dig_world_energy(w).potential;
    w->def.gravity = g;
    for (int i = 0; i < w->bodies.count; i++)
        w->bodies.data[i].lies = -1;
    if (w->ledger.started)
        w->ledger.initial += dig_world_energy(w).potential - before;
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_gravity(World *w, CommandArg *a)
{
    return do_set_gravity(w, a[0].vec);
}

dig_status dig_world_set_gravity(dig_world *w, vec3 g)
{
    return COMMAND(w, COMMAND_GRAVITY, do_set_gravity(w, g), {.vec = g});
}

static dig_status do_set_accuracy(World *w, const char *plan, real tolerance)
{
    if (!plan && !(tolerance > 0 && tolerance <= 1))
        return world_fail(w, DIG_E_ARG, "world: accuracy = %g m, must be > 0 and at most 1 m", tolerance);
    int accuracy = plan ? accuracy_find(plan) : accuracy_for(tolerance);
    if (accuracy == 0)
        return world_fail(w, DIG_E_ARG, "world: accuracy = '%s', must be sketch, play, study, reference or a length", plan);
    w->accuracy = accuracy;
    return DIG_OK;
}

dig_status run_accuracy(World *w, CommandArg *a)
{
    return do_set_accuracy(w, a[0].what, a[1].number);
}

dig_status dig_world_set_accuracy(dig_world *w, const char *plan, real tolerance)
{
    return COMMAND(w, COMMAND_ACCURACY, do_set_accuracy(w, plan, tolerance), {.what = plan}, {.number = tolerance});
}

const char *dig_world_accuracy(const dig_world *w) { return accuracy_plan(w->accuracy)->name; }

static real elastic_energy(const World *w)
{
    real sum = 0;
    for (int i = 0; i < w->joints.count; i++)
        if (w->joints.data[i].alive)
            sum += api_joint_energy(w, (uint32_t)i);
    return sum;
}

dig_energy dig_world_energy(const dig_world *w)
{
    world_work(w, 4 * (uint64_t)(w->bodies.count + w->joints.count));
    dig_energy e = {.work_in = w->ledger.work_in, .law = w->ledger.law, .lost = w->ledger.lost, .initial = w->ledger.initial};
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive || b->kind != DIG_DYNAMIC)
            continue;
        vec3 wl = quat_unrotate(b->q, b->w);
        e.kinetic += 0.5 * body_inertness(b) * (b->mass * vec3_length2(b->v) + vec3_dot(wl, mat3_mul_vec(body_inertia(b)->of, wl)));
        e.potential -= b->mass * b->gravity_scale * vec3_dot(w->def.gravity, b->x);
    }
    e.elastic = elastic_energy(w);
    api_effects_energy(w, &e);
    e.total = e.kinetic + e.potential + e.elastic + e.heat + e.electric;
    if (!w->ledger.started)
        e.initial = e.total;
    e.numerical = e.total + e.lost - e.initial - e.work_in - e.law;
    return e;
}

vec3 dig_world_momentum(const dig_world *w)
{
    vec3 p = vec3_zero();
    world_work(w, (uint64_t)w->bodies.count);
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive && w->bodies.data[i].kind == DIG_DYNAMIC)
            p = vec3_mad(p, body_inertness(&w->bodies.data[i]) * w->bodies.data[i].mass, w->bodies.data[i].v);
    return p;
}

vec3 dig_world_angular_momentum(const dig_world *w)
{
    vec3 l = vec3_zero();
    world_work(w, 4 * (uint64_t)w->bodies.count);
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive || b->kind != DIG_DYNAMIC)
            continue;
        l = vec3_add(l, vec3_scale(body_inertness(b) * b->mass, vec3_cross(b->x, b->v)));
        l = vec3_mad(l, body_inertness(b), mat3_mul_vec(body_inertia_world(b), b->w));
    }
    return l;
}

void dig_time_every_step(dig_world *w, bool on) { w->timed_always = on; }

void dig_tell_moves(dig_world *w, bool on) { w->tells_moves = on; }

/* Did it get farther than a ball that fits inside it is wide? */
static bool is_fast(const World *w, const Body *b)
{
    real inner = INFINITY;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        inner = real_min(inner, w->solids.data[s].form->shape.inner);
    return vec3_distance(b->x, b->prev_x) > inner;
}

dig_stats dig_world_stats(const dig_world *w)
{
    dig_stats s = w->stats;
    world_work(w, 4 * (uint64_t)w->awake.count);
    s.fast = 0;
    s.smooth = w->tally.smooth;
    s.bodies = w->bodies.count - w->free_bodies.count;
    s.awake = 0;
    for (int i = 0; i < w->awake.count; i++) {
        const Body *b = &w->bodies.data[w->awake.data[i]];
        bool moves = b->alive && b->awake && b->kind == DIG_DYNAMIC;
        s.awake += moves;
        s.fast += moves && is_fast(w, b);
    }
    s.digs = graph_count(w->graph);
    s.pairs = w->pairs.count - w->free_pairs.count;
    s.joints = w->joints.count - w->free_joints.count;
    s.contacts = w->tally.touching;
    s.bytes = world_bytes(w) + (w->workers ? workers_bytes(w->workers) : 0);
    s.allocations = w->allocations + w->scratch.allocations + w->group_scratch.allocations;
    return s;
}

int dig_warnings(const dig_world *w, dig_warning *out, int capacity)
{
    for (int i = 0; i < int_min(capacity, w->warning_count); i++)
        out[i] = w->warnings[i];
    return w->warning_count;
}

int dig_events(const dig_world *w, const dig_event **out)
{
    *out = w->events.data;
    return w->events.count;
}
