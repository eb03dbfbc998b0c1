/* api/query.c - lists, finding by name, questions in space, materials, the room. */
#include "api/api.h"
#include "api/command.h"

#include "geom/cast.h"

#include <stdio.h>
#include <stdlib.h>

int dig_bodies(const dig_world *w, dig_body *out, int capacity)
{
    int n = 0;
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive) {
            if (n < capacity)
                out[n] = body_handle(w, (uint32_t)i);
            n++;
        }
    return n;
}

dig_body dig_body_find(const dig_world *w, const char *name)
{
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive && strcmp(body_name(w, &w->bodies.data[i]), name) == 0)
            return body_handle(w, (uint32_t)i);
    return (dig_body){0, 0};
}

vec3 dig_body_point_velocity(const dig_world *w, dig_body handle, vec3 at)
{
    const Body *b = world_body(w, handle);
    return b ? vec3_add(b->v, vec3_cross(b->w, vec3_sub(at, b->x))) : vec3_zero();
}


/* Is inner's centre of mass inside outer's convex outline? By support functions of all its solids: the point is inside when no
 * direction separates it; the directions are those from the point to the nearest point of the outline (Frank-Wolfe steps). */
bool dig_body_contains(const dig_world *w, dig_body outer, dig_body inner)
{
    const Body *o = world_body(w, outer), *b = world_body(w, inner);
    if (!o || !b)
        return false;
    vec3 target = b->x, nearest = o->x;
    for (int i = 0; i < 200; i++) {
        vec3 d = vec3_sub(target, nearest);
        if (vec3_length(d) < 1e-9)
            return true;
        vec3 n = vec3_unit(d), best = nearest;
        real most = -INFINITY;
        for (uint32_t s = o->shape_first; s != NONE; s = w->solids.data[s].next) {
            const Solid *solid = &w->solids.data[s];
            if (!solid->form->shape.type->support)
                continue;
            pose at = solid_pose(w, solid);
            vec3 p = vec3_mad(pose_point(at, solid->form->shape.type->support(&solid->form->shape, quat_unrotate(at.q, n))), solid->form->shape.round, n);
            if (vec3_dot(p, n) > most) {
                most = vec3_dot(p, n);
                best = p;
            }
        }
        if (most < vec3_dot(target, n))
            return false;                   /* n separates the point from the outline */
        vec3 step = vec3_sub(best, nearest);
        real length2 = vec3_length2(step);
        if (!(length2 > 0))
            return true;
        nearest = vec3_mad(nearest, real_clamp(vec3_dot(d, step) / length2, 0, 1), step);
    }
    return true;
}

/* ---- rays, overlaps, sweeps ---- */

enum { ASK_RAY = 100, ASK_SHAPE = 200, TRY_RAY = 20, TRY_OVERLAP = 60, TRY_SWEEP = 300 };    /* units of world_work */

typedef struct RayQuery { const World *w; Ray ray; dig_hit *out; int count, capacity; } RayQuery;

static void ray_solid(RayQuery *q, uint32_t slot)
{
    const Solid *s = &q->w->solids.data[slot];
    pose at = solid_pose(q->w, s);
    world_work(q->w, TRY_RAY);
    Ray local = {pose_unpoint(at, q->ray.from), quat_unrotate(at.q, q->ray.along), q->ray.length};
    RayHit hit;
    if (!s->form->shape.type->ray || !s->form->shape.type->ray(&s->form->shape, &local, &hit) || hit.distance > q->ray.length)
        return;
    dig_hit h = {.body = body_handle(q->w, s->body), .point = pose_point(at, hit.point), .normal = quat_rotate(at.q, hit.normal),
                 .distance = hit.distance, .fraction = q->ray.length > 0 ? hit.distance / q->ray.length : 0};
    /* one hit per body, the nearest; kept in order of distance */
    int i = q->count < q->capacity ? q->count : q->capacity;
    for (int k = 0; k < i; k++)
        if (q->out[k].body.slot == h.body.slot && q->out[k].body.gen == h.body.gen) {
            if (q->out[k].distance <= h.distance)
                return;
            memmove(&q->out[k], &q->out[k + 1], (size_t)(i - k - 1) * sizeof *q->out);
            q->count--;
            i--;
            break;
        }
    q->count++;
    if (i == q->capacity && (i == 0 || q->out[i - 1].distance <= h.distance))
        return;
    int k = i < q->capacity ? i : i - 1;
    while (k > 0 && q->out[k - 1].distance > h.distance) {
        q->out[k] = q->out[k - 1];
        k--;
    }
    q->out[k] = h;
}

static bool ray_leaf(void *context, uint32_t slot, real *length)
{
    (void)length;
    ray_solid(context, slot);
    return true;
}

int dig_ray(const dig_world *w, vec3 from, vec3 along, real length, dig_hit *out, int capacity)
{
    if (!vec3_finite(from) || !vec3_finite(along) || !(length > 0) || !(vec3_largest(vec3_abs(along)) > 0)) {
        world_fail(w, DIG_E_ARG, "ray: from and along must be finite, along not zero, length = %g m must be > 0", length);
        return -1;
    }
    RayQuery q = {w, {from, vec3_unit(along), length}, out, 0, capacity};
    world_work(w, ASK_RAY);
    tree_ray(&w->tree, from, q.ray.along, length, ray_leaf, &q);
    for (int i = 0; i < w->unbounded.count; i++)
        ray_solid(&q, w->unbounded.data[i]);
    return q.count;
}

static dig_status query_shape(World *w, const dig_shape_def *def, Shape *shape)
{
    char why[256];
    dig_status s = shape_make(def->type, def->data, shape, why, sizeof why);
    if (s != DIG_OK)
        return world_fail(w, s, "%s", why);
    world_work(w, ASK_SHAPE);
    world_work_shape(w, shape, def->data);
    return DIG_OK;
}

typedef struct OverlapQuery { const World *w; const Shape *shape; pose at; dig_body *out; int count, capacity; } OverlapQuery;

static bool overlap_leaf(void *context, uint32_t slot)
{
    OverlapQuery *q = context;
    const Solid *s = &q->w->solids.data[slot];
    world_work(q->w, TRY_OVERLAP);
    if (s->body == NONE || shape_distance(q->shape, q->at, &s->form->shape, solid_pose(q->w, s), 0, NULL, NULL, NULL) > 0)
        return true;
    q->count = api_add_unique(q->out, q->count, q->capacity, body_handle(q->w, s->body));
    return true;
}

static int compare_slots(const void *a, const void *b)
{
    uint32_t x = ((const dig_body *)a)->slot, y = ((const dig_body *)b)->slot;
    return (x > y) - (x < y);
}

/* By slot: the order in the tree is nobody's business. */
int dig_overlap(dig_world *w, const dig_shape_def *def, pose at, dig_body *out, int capacity)
{
    Shape shape;
    if (query_shape(w, def, &shape) != DIG_OK)
        return -1;
    OverlapQuery q = {w, &shape, at, out, 0, capacity};
    tree_query(&w->tree, shape.type->bounds(&shape, at), overlap_leaf, &q);
    for (int i = 0; i < w->unbounded.count; i++)
        overlap_leaf(&q, w->unbounded.data[i]);
    shape_free(&shape);
    if (q.count > 1 && capacity > 1)
        qsort(out, (size_t)int_min(q.count, capacity), sizeof *out, compare_slots);
    return q.count;
}

typedef struct SweepQuery { const World *w; const Shape *shape; Motion motion; real time; dig_hit *out; bool found; } SweepQuery;

static bool sweep_leaf(void *context, uint32_t slot)
{
    SweepQuery *q = context;
    const Solid *s = &q->w->solids.data[slot];
    world_work(q->w, TRY_SWEEP);
    Motion still = {.start = solid_pose(q->w, s)};
    real t = time_of_impact(q->shape, &q->motion, &s->form->shape, &still, 0, q->time, NULL);
    if (!(t <= q->time))
        return true;
    vec3 n, a, b;
    shape_distance(q->shape, motion_at(&q->motion, t), &s->form->shape, still.start, INFINITY, &n, &a, &b);
    q->found = true;
    q->time = t;
    *q->out = (dig_hit){.body = body_handle(q->w, s->body), .point = b, .normal = vec3_neg(n), .distance = t};
    return true;
}

int dig_sweep(dig_world *w, const dig_shape_def *def, pose at, vec3 velocity, vec3 acceleration, real time, dig_hit *out)
{
    Shape shape;
    if (!(time > 0 && isfinite(time)) || !vec3_finite(velocity) || !vec3_finite(acceleration)) {
        world_fail(w, DIG_E_ARG, "sweep: velocity and acceleration must be finite, time = %g s must be > 0", time);
        return -1;
    }
    if (query_shape(w, def, &shape) != DIG_OK)
        return -1;
    SweepQuery q = {w, &shape, {.start = at, .v = velocity, .a = acceleration}, time, out, false};
    box3 box = shape.type->bounds(&shape, at);
    real far = vec3_length(velocity) * time + 0.5 * vec3_length(acceleration) * time * time;
    tree_query(&w->tree, box3_grow(box, far), sweep_leaf, &q);
    for (int i = 0; i < w->unbounded.count; i++)
        sweep_leaf(&q, w->unbounded.data[i]);
    if (q.found) {
        vec3 d = vec3_add(vec3_scale(q.time, velocity), vec3_scale(0.5 * q.time * q.time, acceleration));
        out->fraction = q.time / time;
        out->distance = vec3_length(d);
    }
    shape_free(&shape);
    return q.found;
}

/* ---- materials ---- */

static dig_status do_add_material(World *w, const char *name, const dig_material_def *def)
{
    char subject[96], why[256];
    snprintf(subject, sizeof subject, "material '%s'", name);
    if (!name[0] || strlen(name) > 63)
        return world_fail(w, DIG_E_ARG, "material: its name must have 1 to 63 bytes");
    if (param_check(dig_schema_at("material", 0)->rows, def, subject, why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    int i = material_find(w, name);
    if (i < 0) {
        if (list_push(&w->materials, &w->allocations) != DIG_OK)
            return world_fail(w, DIG_E_MEMORY, "material '%s': not enough memory", name);
        i = w->materials.count - 1;
        snprintf(w->materials.data[i].name, sizeof w->materials.data[i].name, "%s", name);
    }
    w->materials.data[i].def = *def;
    param_settle(dig_schema_at("material", 0)->rows, &w->materials.data[i].def);
    all_pairs_refresh_surfaces(w);      /* it may be another meaning of a name in use */
    return DIG_OK;
}

dig_status run_material(World *w, CommandArg *a)
{
    return do_add_material(w, a[0].what, a[1].what);
}

dig_status dig_material_add(dig_world *w, const char *name, const dig_material_def *def)
{
    return COMMAND(w, COMMAND_MATERIAL, do_add_material(w, name, def), {.what = name}, {.what = def});
}

dig_status dig_material_get(const dig_world *w, const char *name, dig_material_def *def)
{
    int i = material_find(w, name);
    if (i < 0)
        return world_fail(w, DIG_E_ARG, "there is no material '%s'", name);
    *def = w->materials.data[i].def;
    return DIG_OK;
}

static dig_status do_add_pair(World *w, const dig_pair_def *def)
{
    int a = material_find(w, def->a.s), b = material_find(w, def->b.s);
    if (a < 0 || b < 0)
        return world_fail(w, DIG_E_ARG, "there is no material '%s'", a < 0 ? def->a.s : def->b.s);
    const real values[4] = {def->friction, def->friction_dynamic, def->rolling_friction, def->restitution};
    static const char *const names[4] = {"friction", "friction_dynamic", "rolling_friction", "restitution"};
    static const real most[4] = {100, 100, 10, 1};
    for (int i = 0; i < 4; i++)
        if (!isnan(values[i]) && !(values[i] >= 0 && values[i] <= most[i]))
            return world_fail(w, DIG_E_ARG, "materials '%s' and '%s': %s = %g, must be 0..%g", def->a.s, def->b.s, names[i], values[i], most[i]);
    if (list_push(&w->material_pairs, &w->allocations) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a pair of materials");
    w->material_pairs.data[w->material_pairs.count - 1] = (MaterialPair){a, b, values[0], values[1], values[2], values[3]};
    material_pairs_look(w);
    all_pairs_refresh_surfaces(w);
    return DIG_OK;
}

dig_status run_pair(World *w, CommandArg *a)
{
    return do_add_pair(w, a[0].what);
}

dig_status dig_material_pair(dig_world *w, const dig_pair_def *def)
{
    return COMMAND(w, COMMAND_PAIR, do_add_pair(w, def), {.what = def});
}

bool dig_material_pair_at(const dig_world *w, int index, dig_pair_def *def)
{
    if (index < 0 || index >= w->material_pairs.count)
        return false;
    const MaterialPair *p = &w->material_pairs.data[index];
    memset(def, 0, sizeof *def);
    snprintf(def->a.s, sizeof def->a.s, "%s", w->materials.data[p->a].name);
    snprintf(def->b.s, sizeof def->b.s, "%s", w->materials.data[p->b].name);
    def->friction = p->friction;
    def->friction_dynamic = p->friction_dynamic;
    def->rolling_friction = p->rolling;
    def->restitution = p->restitution;
    return true;
}

const char *dig_material_name(const dig_world *w, int index)
{
    return index >= 0 && index < w->materials.count ? w->materials.data[index].name : NULL;
}
