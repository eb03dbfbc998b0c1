/* api/body.c - bodies: creation, reading, pushing, setting. */
#include "api/api.h"
#include "api/command.h"
#include "world/region.h"

#include <stdio.h>

dig_body_def dig_body_defaults(void)
{
    dig_body_def def;
    memset(&def, 0, sizeof def);
    dig_schema_defaults(dig_schema_at("body", 0), &def);
    def.rotation = quat_identity();
    return def;
}

static dig_status do_create(World *w, const dig_body_def *def, dig_body *out)
{
    char why[256];
    *out = (dig_body){0, 0};
    dig_status s = param_check(dig_schema_at("body", 0)->rows, def, NEW_BODY_TEXT(def->name.s), why, sizeof why);
    if (s != DIG_OK)
        return world_fail(w, s, "%s", why);
    real before = w->ledger.started ? api_effects_stored(w) : 0;
    s = body_create(w, def, out);
    api_book_stored(w, before);
    return s;
}

dig_status run_body(World *w, CommandArg *a)
{
    return do_create(w, a[0].what, a[1].place);
}

dig_status dig_body_create(dig_world *w, const dig_body_def *def, dig_body *out)
{
    return COMMAND(w, COMMAND_BODY, do_create(w, def, out), {.what = def}, {.place = out});
}

static dig_status do_remove_body(World *w, dig_body b)
{
    if (!api_body(w, b, "remove"))
        return DIG_E_DEAD;
    real before = api_effects_stored(w);
    api_book_given(w, -api_body_springs(w, b.slot));
    body_remove(w, b.slot);
    api_book_stored(w, before);
    return DIG_OK;
}

dig_status run_body_remove(World *w, CommandArg *a)
{
    return do_remove_body(w, a[0].body);
}

dig_status dig_body_remove(dig_world *w, dig_body b)
{
    return COMMAND(w, COMMAND_BODY_REMOVE, do_remove_body(w, b), {.body = b});
}

bool dig_body_alive(const dig_world *w, dig_body b) { return world_body(w, b) != NULL; }

static void write_mat3(real out[9], mat3 m)
{
    const real flat[9] = {m.r0.x, m.r0.y, m.r0.z, m.r1.x, m.r1.y, m.r1.z, m.r2.x, m.r2.y, m.r2.z};
    memcpy(out, flat, sizeof flat);
}

static box3 body_bounds(const World *w, const Body *b)
{
    box3 box = {b->x, b->x};
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        box = box3_union(box, solid->form->shape.type->bounds(&solid->form->shape, solid_pose(w, solid)));
    }
    return box;
}

dig_status dig_body_get(const dig_world *w, dig_body handle, dig_body_state *out)
{
    const Body *b = api_body(w, handle, "body");
    if (!b)
        return DIG_E_DEAD;
    memset(out, 0, sizeof *out);
    pose at = body_pose(b);
    box3 box = body_bounds(w, b);
    out->name = body_name(w, b);
    out->kind = b->kind;
    out->mode = b->kind == DIG_STATIC ? DIG_FIXED : b->mode;
    out->awake = b->kind == DIG_DYNAMIC ? b->awake : b->kind == DIG_KINEMATIC;
    out->position = at.p;
    out->rotation = at.q;
    out->centre = b->x;
    out->velocity = b->v;
    out->spin = b->w;
    out->mass = body_mass_read(b);
    write_mat3(out->inertia, body_inertia_world(b));
    out->force = b->force;
    out->torque = b->torque;
    out->low = box.low;
    out->high = box.high;
    out->energy = body_energy(w, b);
    out->work_received = b->work;
    out->dig = dig_of(w, handle);
    out->shape_count = b->shape_count;
    return DIG_OK;
}

static void inspect_motion(const World *w, const Body *b, dig_body_debug *out)
{
    pose at = body_pose(b);
    mat3 r = quat_matrix(b->q), inverse = mat3_mul(mat3_mul(r, body_inertia(b)->inverse), mat3_transpose(r));
    out->floor = b->mode == DIG_RESTING;
    out->collided = b->collided;
    out->euler = b->euler;
    out->curr_pos = b->x;
    out->prev_pos = b->prev_x;
    out->next_pos = b->awake ? vec3_mad(b->x, w->def.step, b->v) : b->x;
    if (b->kind == DIG_DYNAMIC && b->awake && !b->euler)
        out->next_pos = vec3_mad(out->next_pos, 0.5 * w->def.step * w->def.step * b->gravity_scale / body_inertness(b), w->def.gravity);
    out->curr_rot = b->q;
    out->prev_rot = b->prev_q;
    out->next_rot = quat_mul(quat_exp(vec3_scale(w->def.step, b->w)), b->q);
    write_mat3(out->itensor, body_inertia(b)->of);
    write_mat3(out->iti, body_inertia(b)->inverse);
    write_mat3(out->itiws, inverse);
    out->mo_inertia = (body_inertia(b)->of.r0.x + body_inertia(b)->of.r1.y + body_inertia(b)->of.r2.z) / 3;
    out->res_force = b->force;
    out->torque = b->torque;
    out->c_mass = b->x;
    out->ang_mom = vec3_scale(body_inertness(b), mat3_mul_vec(body_inertia_world(b), b->w));
    out->velocity = b->v;
    out->omega = b->w;
    const real m[16] = {r.r0.x, r.r0.y, r.r0.z, at.p.x, r.r1.x, r.r1.y, r.r1.z, at.p.y, r.r2.x, r.r2.y, r.r2.z, at.p.z, 0, 0, 0, 1};
    memcpy(out->matrix, m, sizeof m);
}

dig_status dig_body_inspect(const dig_world *w, dig_body handle, dig_body_debug *out)
{
    const Body *b = api_body(w, handle, "debug");
    if (!b)
        return DIG_E_DEAD;
    memset(out, 0, sizeof *out);
    inspect_motion(w, b, out);
    out->m_id = b->message_id;
    out->db_id = handle.slot;
    out->mess_type = body_message_kind(w, b);
    out->dig_id = graph_of(w->graph, handle.slot);
    out->mess_time = b->message_time;
    out->mass = body_mass_read(b);
    out->rest = surface_resolve(w, &body_make(b)->surface).restitution;
    out->origin = b->message_from;
    out->material = w->materials.data[body_make(b)->surface.material].name;
    out->object_type = b->shape_first == NONE ? "" : w->solids.data[b->shape_first].form->shape.type->name;
    return DIG_OK;
}

/* ---- forces ---- */

Body *api_pushable(World *w, dig_body handle, const char *call, dig_status *status)
{
    Body *b = api_body(w, handle, call);
    *status = b ? DIG_OK : DIG_E_DEAD;
    if (b && b->kind != DIG_DYNAMIC) {
        *status = world_fail(w, DIG_E_KIND, "%s: %s is %s: nothing can push it", call, BODY_TEXT(w, b), b->kind == DIG_STATIC ? "fixed" : "kinematic");
        return NULL;
    }
    return b;
}

static real largest_of(mat3 m)
{
    return real_max(vec3_largest(vec3_abs(m.r0)), real_max(vec3_largest(vec3_abs(m.r1)), vec3_largest(vec3_abs(m.r2))));
}

/* A step that it would fail in would not end it either: who pushes is told at once. The point that a force acts at turns with its body
 * while it lasts, so what counts is the greatest moment on that lever, not that of now. */
static dig_status not_too_strong(World *w, const Body *b, const Push *p, const char *call)
{
    const mat3 *inverse = &body_inertia(b)->inverse;
    real force = vec3_length(p->force), torque = vec3_length(p->torque), light = largest_of(*inverse), levered = 0;
    if (p->has_at && force > 0) {
        levered = largest_of(mat3_mul(*inverse, mat3_skew(p->at))) * force;
        torque += vec3_length(p->at) * force;
    }
    real gain = w->def.step / body_inertness(b), fast = gain * b->inv_mass * force, spin = gain * (light * vec3_length(p->torque) + levered);
    if (fast <= WORLD_FAST && spin <= WORLD_FAST)
        return DIG_OK;
    return world_fail(w, DIG_E_ARG, "%s: %g %s would bring %s to %g %s within a step, must be at most %g", call,
                      fast > WORLD_FAST ? force : torque, fast > WORLD_FAST ? "N" : "N m", BODY_TEXT(w, b),
                      fast > WORLD_FAST ? fast : spin, fast > WORLD_FAST ? "m/s" : "rad/s", WORLD_FAST);
}

dig_status api_push(World *w, dig_body handle, Push p, real lasts, const char *call)
{
    if (isnan(lasts))
        return world_fail(w, DIG_E_ARG, "%s: lasts = nan s, must be a time", call);
    DIG_TRY(not_too_strong(w, &w->bodies.data[handle.slot], &p, call));
    if (list_push(&w->pushes, &w->allocations) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "%s: not enough memory", call);
    p.body = handle.slot;
    p.from = world_time(w);
    p.until = p.from + (lasts > 0 ? lasts : w->def.step);
    w->pushes.data[w->pushes.count - 1] = p;
    body_wake(w, handle.slot);
    return DIG_OK;
}

static dig_status do_push(World *w, dig_body handle, vec3 force, vec3 at, bool has_at, real lasts)
{
    dig_status s;
    const Body *b = api_pushable(w, handle, "push", &s);
    if (!b)
        return s;
    DIG_TRY(api_within(w, force, WORLD_STRONG, "push", "force", "N"));
    if (has_at)
        DIG_TRY(api_finite(w, at, "push", "at", "m"));
    Push p = {.force = force, .has_at = has_at, .at = has_at ? quat_unrotate(b->q, vec3_sub(at, b->x)) : vec3_zero()};
    return api_push(w, handle, p, lasts, "push");
}

dig_status run_push(World *w, CommandArg *a)
{
    return do_push(w, a[0].body, a[1].vec, a[2].vec, a[3].yes, a[4].number);
}

dig_status dig_body_push(dig_world *w, dig_body handle, vec3 force, vec3 at, bool has_at, real lasts)
{
    return COMMAND(w, COMMAND_PUSH, do_push(w, handle, force, at, has_at, lasts),
                   {.body = handle}, {.vec = force}, {.vec = at}, {.yes = has_at}, {.number = lasts});
}

static dig_status do_twist(World *w, dig_body handle, vec3 torque, real lasts)
{
    dig_status s;
    if (!api_pushable(w, handle, "twist", &s))
        return s;
    DIG_TRY(api_within(w, torque, WORLD_STRONG, "twist", "torque", "N m"));
    return api_push(w, handle, (Push){.torque = torque}, lasts, "twist");
}

dig_status run_twist(World *w, CommandArg *a)
{
    return do_twist(w, a[0].body, a[1].vec, a[2].number);
}

dig_status dig_body_twist(dig_world *w, dig_body handle, vec3 torque, real lasts)
{
    return COMMAND(w, COMMAND_TWIST, do_twist(w, handle, torque, lasts), {.body = handle}, {.vec = torque}, {.number = lasts});
}

static dig_status do_hit(World *w, dig_body handle, vec3 impulse, vec3 at, bool has_at)
{
    dig_status s;
    Body *b = api_pushable(w, handle, "hit", &s);
    if (!b)
        return s;
    DIG_TRY(api_finite(w, impulse, "hit", "impulse", "N s"));
    if (has_at)
        DIG_TRY(api_finite(w, at, "hit", "at", "m"));
    real before = body_energy(w, b);
    mat3 r = quat_matrix(b->q), inverse = mat3_mul(mat3_mul(r, body_inertia(b)->inverse), mat3_transpose(r));
    real light = 1 / body_inertness(b);
    vec3 dv = vec3_scale(light * b->inv_mass, impulse);
    vec3 dw = has_at ? mat3_mul_vec(mat3_scale(light, inverse), vec3_cross(vec3_sub(at, b->x), impulse)) : vec3_zero();
    real fast = real_max(vec3_largest(vec3_abs(vec3_add(b->v, dv))), vec3_largest(vec3_abs(vec3_add(b->w, dw))));
    if (!vec3_finite(vec3_add(b->v, dv)) || !vec3_finite(vec3_add(b->w, dw)) || fast > WORLD_FAST)
        return world_fail(w, DIG_E_ARG, "hit: impulse = {%g, %g, %g} N s makes %s too fast for a number", impulse.x, impulse.y,
                          impulse.z, BODY_TEXT(w, b));
    body_wake(w, handle.slot);
    b->v = vec3_add(b->v, dv);
    b->w = vec3_add(b->w, dw);
    BodyRest *rest = body_rest_own(w, b);
    rest->hit_v = vec3_add(rest->hit_v, dv);
    rest->hit_w = vec3_add(rest->hit_w, dw);
    real work = body_energy(w, b) - before;
    b->work += work;
    w->ledger.work_in += w->ledger.started ? work : 0;
    return DIG_OK;
}

dig_status run_hit(World *w, CommandArg *a)
{
    return do_hit(w, a[0].body, a[1].vec, a[2].vec, a[3].yes);
}

dig_status dig_body_hit(dig_world *w, dig_body handle, vec3 impulse, vec3 at, bool has_at)
{
    return COMMAND(w, COMMAND_HIT, do_hit(w, handle, impulse, at, has_at),
                   {.body = handle}, {.vec = impulse}, {.vec = at}, {.yes = has_at});
}

static dig_status check_rotation(const World *w, const quat *q, const char *call)
{
    if (!q || (quat_norm2(*q) > 0.98 && quat_norm2(*q) < 1.02))
        return DIG_OK;
    return world_fail(w, DIG_E_ARG, "%s: rotation has length %g, must be 1", call, sqrt(quat_norm2(*q)));
}

static dig_status do_teleport(World *w, dig_body handle, const vec3 *at, const quat *rotation, const vec3 *velocity, const vec3 *spin)
{
    Body *b = api_body(w, handle, "teleport");
    if (!b)
        return DIG_E_DEAD;
    if (at)
        DIG_TRY(api_within(w, *at, WORLD_FAR, "teleport", "at", "m"));
    if (velocity)
        DIG_TRY(api_within(w, *velocity, WORLD_FAST, "teleport", "velocity", "m/s"));
    if (spin)
        DIG_TRY(api_within(w, *spin, WORLD_FAST, "teleport", "spin", "rad/s"));
    if (spin && vec3_length2(*spin) > 0 && !body_turns(b))
        return world_fail(w, DIG_E_ARG, "teleport: %s was made with turns = false and takes no spin", BODY_TEXT(w, b));
    DIG_TRY(check_rotation(w, rotation, "teleport"));
    real before = body_energy(w, b) + api_body_springs(w, handle.slot) + (w->ledger.started ? api_effects_stored(w) : 0);
    touches_wake(w, handle.slot);
    body_wake(w, handle.slot);
    vec3 origin = at ? *at : body_pose(b).p, from = b->x;
    b->q = rotation ? quat_unit(*rotation) : b->q;
    b->x = vec3_add(origin, quat_rotate(b->q, b->centre));
    b->prev_x = b->x;
    b->prev_q = b->q;
    b->euler = b->euler || b->integrator == DIG_SWITCH;     /* what it did before is no history of where it is now */
    region_cross(w, handle.slot, from, 0);          /* what is given is as it is seen there; what is not is kept */
    if (velocity && b->kind != DIG_STATIC)
        b->v = *velocity;
    if (spin && b->kind != DIG_STATIC)
        b->w = *spin;
    b->still = 0;
    b->out = false;
    body_refit(w, handle.slot);
    api_book_given(w, body_energy(w, b) + api_body_springs(w, handle.slot) + (w->ledger.started ? api_effects_stored(w) : 0) - before);
    return DIG_OK;
}

dig_status run_teleport(World *w, CommandArg *a)
{
    return do_teleport(w, a[0].body, a[1].what, a[2].what, a[3].what, a[4].what);
}

dig_status dig_body_teleport(dig_world *w, dig_body handle, const vec3 *at, const quat *rotation, const vec3 *velocity, const vec3 *spin)
{
    return COMMAND(w, COMMAND_TELEPORT, do_teleport(w, handle, at, rotation, velocity, spin),
                   {.body = handle}, {.what = at}, {.what = rotation}, {.what = velocity}, {.what = spin});
}

static Body *kinematic(World *w, dig_body handle, const char *call, dig_status *status)
{
    Body *b = api_body(w, handle, call);
    *status = b ? DIG_OK : DIG_E_DEAD;
    if (b && b->kind != DIG_KINEMATIC) {
        *status = world_fail(w, DIG_E_KIND, "%s: %s is not kinematic; use :push, :hit or :teleport", call, BODY_TEXT(w, b));
        return NULL;
    }
    return b;
}

static dig_status do_move_to(World *w, dig_body handle, vec3 at, const quat *rotation, real over)
{
    dig_status s;
    Body *b = kinematic(w, handle, "move_to", &s);
    if (!b)
        return s;
    DIG_TRY(api_within(w, at, WORLD_FAR, "move_to", "at", "m"));
    DIG_TRY(check_rotation(w, rotation, "move_to"));
    if (!(over >= 0 && over <= WORLD_LONG))
        return world_fail(w, DIG_E_ARG, "move_to: over = %g s, must be %s %g s", over, over >= 0 ? "at most" : ">=", over >= 0 ? WORLD_LONG : 0);
    quat q = rotation ? quat_unit(*rotation) : b->q;
    vec3 to = vec3_add(at, quat_rotate(q, b->centre));
    real time = real_max(1, ceil(over / w->def.step - MOVE_SLACK)) * w->def.step;     /* whole frames: it stops where one ends */
    vec3 v = vec3_scale(1 / time, vec3_sub(to, b->x));
    DIG_TRY(api_within(w, v, WORLD_FAST, "move_to", "velocity", "m/s"));
    BodyRest *rest = body_rest_own(w, b);
    rest->move_to = to;
    rest->turn_to = q;
    b->move_start = world_time(w);
    b->move_end = b->move_start + time;
    b->v = v;
    b->w = vec3_scale(1 / time, quat_log(quat_mul(q, quat_conjugate(b->q))));
    touches_wake(w, handle.slot);
    return DIG_OK;
}

dig_status run_move_to(World *w, CommandArg *a)
{
    return do_move_to(w, a[0].body, a[1].vec, a[2].what, a[3].number);
}

dig_status dig_body_move_to(dig_world *w, dig_body handle, vec3 at, const quat *rotation, real over)
{
    return COMMAND(w, COMMAND_MOVE_TO, do_move_to(w, handle, at, rotation, over),
                   {.body = handle}, {.vec = at}, {.what = rotation}, {.number = over});
}

static dig_status do_set_velocity(World *w, dig_body handle, vec3 velocity, vec3 spin)
{
    dig_status s;
    Body *b = kinematic(w, handle, "drive", &s);
    if (!b)
        return s;
    DIG_TRY(api_within(w, velocity, WORLD_FAST, "drive", "velocity", "m/s"));
    DIG_TRY(api_within(w, spin, WORLD_FAST, "drive", "spin", "rad/s"));
    b->v = velocity;
    b->w = spin;
    b->move_end = b->move_start - 1;
    touches_wake(w, handle.slot);
    return DIG_OK;
}

dig_status run_velocity(World *w, CommandArg *a)
{
    return do_set_velocity(w, a[0].body, a[1].vec, a[2].vec);
}

dig_status dig_body_set_velocity(dig_world *w, dig_body handle, vec3 velocity, vec3 spin)
{
    return COMMAND(w, COMMAND_VELOCITY, do_set_velocity(w, handle, velocity, spin), {.body = handle}, {.vec = velocity}, {.vec = spin});
}

static dig_status do_wake(World *w, dig_body handle)
{
    if (!api_body(w, handle, "wake"))
        return DIG_E_DEAD;
    body_wake(w, handle.slot);
    return DIG_OK;
}

dig_status run_wake(World *w, CommandArg *a)
{
    return do_wake(w, a[0].body);
}

dig_status dig_body_wake(dig_world *w, dig_body handle)
{
    return COMMAND(w, COMMAND_WAKE, do_wake(w, handle), {.body = handle});
}

static dig_status do_disable(World *w, dig_body b)
{
    if (!api_body(w, b, "disable"))
        return DIG_E_DEAD;
    real before = api_effects_stored(w);
    (void)step_sense(w);        /* the rows of pairs that the next step adds are then those of a step that failed for this body */
    api_book_given(w, -api_body_springs(w, b.slot));
    body_disable(w, b.slot);
    api_book_stored(w, before);
    return DIG_OK;
}

dig_status run_disable(World *w, CommandArg *a)
{
    return do_disable(w, a[0].body);
}

dig_status dig_body_disable(dig_world *w, dig_body b)
{
    return COMMAND(w, COMMAND_DISABLE, do_disable(w, b), {.body = b});
}
