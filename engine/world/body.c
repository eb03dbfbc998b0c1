/* world/body.c - bodies and their solids: creation, removal, mass, boxes, waking. */
#include "world/world.h"
#include "world/joint.h"
#include "world/region.h"

#include "geom/mass.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- in messages ---- */

const char *new_body_text(const char *name, char text[BODY_TEXT_SIZE])
{
    if (!name[0])
        return "body";
    snprintf(text, BODY_TEXT_SIZE, "body '%.63s'", name);
    return text;
}

const char *body_text(const World *w, const Body *b, char text[BODY_TEXT_SIZE])
{
    if (body_name(w, b)[0])
        return new_body_text(body_name(w, b), text);
    snprintf(text, BODY_TEXT_SIZE, "body #%d", (int)(b - w->bodies.data));
    return text;
}

const char *wall_name(int wall)
{
    static const char *const names[] = {"", "+x", "-x", "+y", "-y", "+z", "-z"};
    return wall >= 0 && wall < (int)(sizeof names / sizeof *names) ? names[wall] : "";
}

const char *solid_text(const World *w, const Solid *s, char text[BODY_TEXT_SIZE])
{
    if (s->body != NONE)
        return body_text(w, &w->bodies.data[s->body], text);
    snprintf(text, BODY_TEXT_SIZE, "wall %s of the room", wall_name(s->wall));
    return text;
}

/* ---- solids ---- */

void solid_ask(World *w, uint32_t slot)
{
    if (w->solids.data[slot].asks)
        return;
    w->solids.data[slot].asks = true;
    w->asking.data[w->asking.count++] = slot;
}

void form_drop(const Form *f)
{
    if (!share_drop(f))
        return;
    shape_free(&((Form *)f)->shape);
    free((Form *)f);
}

static bool is_shape(const Shape *s, const Shape *like)
{
    size_t bytes = shape_bytes(s);
    return s->type == like->type && memcmp(&s->round, &like->round, offsetof(Shape, refs) - offsetof(Shape, round)) == 0 &&
           bytes == shape_bytes(like) && (s->data == like->data || memcmp(s->data, like->data, bytes) == 0);
}

static bool is_form(const void *record, const void *other)
{
    const Form *f = record, *like = other;
    return memcmp(&f->at, &like->at, offsetof(Form, surface) - offsetof(Form, at)) == 0 && surface_same(&f->surface, &like->surface) &&
           memcmp(&f->colour, &like->colour, sizeof like->colour) == 0 && is_shape(&f->shape, &like->shape);
}

const Form *form_take(World *w, const Form *now, const Form *like)
{
    const Form *found = share_keep(share_find(&w->forms, now, like, is_form));
    Form *made = found ? NULL : malloc(sizeof *made);
    if (!made)
        return found;
    w->allocations++;
    *made = *like;
    made->share.users = 1;
    made->shape = shape_keep(&like->shape);
    form_drop(share_note(&w->forms, made));
    return made;
}

dig_status solid_form(World *w, Solid *s, const Form *like)
{
    const Form *f = form_take(w, s->form, like);
    if (!f)
        return DIG_E_MEMORY;
    form_drop(s->form);
    s->form = f;
    return DIG_OK;
}

static dig_status open_solid(World *w, uint32_t slot, const Form *like)
{
    Solid *s = &w->solids.data[slot];
    const Shape *shape = &like->shape;
    bool collides = s->body == NONE || w->bodies.data[s->body].collides;
    DIG_TRY(solid_form(w, s, like));
    /* room for every solid at once, so that asking cannot fail later */
    DIG_TRY(list_reserve(&w->asking, w->solids.capacity, &w->allocations));
    if (!isfinite(shape->outer)) {
        DIG_TRY(list_push(&w->unbounded, &w->allocations));
        w->unbounded.data[w->unbounded.count - 1] = slot;
    } else if (collides) {
        DIG_TRY(tree_insert(&w->tree, shape->type->bounds(shape, solid_pose(w, s)), slot, &s->leaf));
    }
    return DIG_OK;
}

dig_status solid_add(World *w, uint32_t body, const Shape *shape, pose at, const Surface *surface, vec3 colour, uint32_t *slot)
{
    vec3 centre = body == NONE ? vec3_zero() : w->bodies.data[body].centre;
    Form like = {.shape = *shape, .at = at, .arm = vec3_sub(at.p, centre), .surface = *surface, .colour = colour};
    DIG_TRY(world_slot(w, &w->solids, &w->free_solids, slot));
    w->solids.data[*slot] = (Solid){.body = body, .next = NONE, .leaf = -1, .pair_first = NONE};
    dig_status status = open_solid(w, *slot, &like);
    if (status != DIG_OK) {
        form_drop(w->solids.data[*slot].form);
        slot_give(w, &w->free_solids, *slot);
        return status;
    }
    w->solids.data[*slot].alive = true;
    solid_ask(w, *slot);
    w->tally.shapes += shape_bytes(shape);
    return DIG_OK;
}

void solid_remove(World *w, uint32_t slot)
{
    Solid *s = &w->solids.data[slot];
    pairs_of_solid_remove(w, slot);
    if (s->leaf >= 0)
        tree_remove(&w->tree, s->leaf);
    for (int i = 0; i < w->unbounded.count; i++) {
        if (w->unbounded.data[i] == slot) {
            memmove(&w->unbounded.data[i], &w->unbounded.data[i + 1], (size_t)(w->unbounded.count - i - 1) * sizeof(uint32_t));
            w->unbounded.count--;
            break;
        }
    }
    if (s->asks)
        for (int i = 0; i < w->asking.count; i++)
            if (w->asking.data[i] == slot)
                w->asking.data[i] = w->asking.data[--w->asking.count];
    w->tally.shapes -= shape_bytes(&s->form->shape);
    form_drop(s->form);
    s->form = NULL;
    s->alive = false;
    slot_give(w, &w->free_solids, slot);
}

/* May these two solids ever touch? Not within one body, not when nothing of them can move, not across a joint that
 * forbids it, not within a negative group. */
bool bodies_may_touch(const World *w, const Solid *a, const Solid *b)
{
    if (a->body == b->body)
        return false;
    const Body *ba = a->body == NONE ? NULL : &w->bodies.data[a->body], *bb = b->body == NONE ? NULL : &w->bodies.data[b->body];
    bool da = ba && ba->kind == DIG_DYNAMIC, db = bb && bb->kind == DIG_DYNAMIC;
    if (!da && !db)
        return false;
    if ((ba && !ba->collides) || (bb && !bb->collides))
        return false;
    if (ba && bb && body_make(ba)->group < 0 && body_make(ba)->group == body_make(bb)->group)
        return false;
    return !(ba && bb && joint_forbids_contact(w, a, b));
}

void body_refit(World *w, uint32_t slot)
{
    const Body *b = &w->bodies.data[slot];
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        Solid *solid = &w->solids.data[s];
        if (solid->leaf >= 0)
            tree_move(&w->tree, solid->leaf, solid->form->shape.type->bounds(&solid->form->shape, solid_pose(w, solid)));
        solid_ask(w, s);
        for (uint32_t l = solid->pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            pair_stir(&w->pairs.data[l / 2]);
    }
}

/* ---- mass ---- */

const Inertia no_inertia;

const Make no_make;

/* Of an inertia, or a make: nothing but the record is to be freed. */
static void drop(const void *record)
{
    if (share_drop(record))
        free((void *)record);
}

static bool is_make(const void *record, const void *other)
{
    const Make *m = record, *like = other;
    return surface_same(&m->surface, &like->surface) && memcmp(&m->colour, &like->colour, sizeof *m - offsetof(Make, colour)) == 0;
}

dig_status body_make_set(World *w, Body *b, const Make *like)
{
    const Make *m = share_keep(share_find(&w->makes, b->make, like, is_make));
    if (!m) {
        Make *made = malloc(sizeof *made);
        if (!made)
            return world_fail(w, DIG_E_MEMORY, "not enough memory for what a body is like");
        w->allocations++;
        *made = *like;
        made->share.users = 1;
        drop(share_note(&w->makes, made));
        m = made;
    }
    drop(b->make);
    b->make = m;
    return DIG_OK;
}

void body_shares_keep(Body *b)
{
    share_keep(b->inertia);
    share_keep(b->make);
}

static void drop_inertia(Body *b)
{
    drop(b->inertia);
    b->inertia = NULL;
}

void body_shares_drop(Body *b)
{
    drop_inertia(b);
    drop(b->make);
    b->make = NULL;
}

static bool is_inertia(const void *record, const void *of) { return memcmp(&((const Inertia *)record)->of, of, sizeof(mat3)) == 0; }

dig_status body_inertia_set(World *w, Body *b, mat3 inertia)
{
    const Inertia *i = share_keep(share_find(&w->inertias, b->inertia, &inertia, is_inertia));
    if (!i) {
        Inertia *made = malloc(sizeof *made);
        if (!made)
            return DIG_E_MEMORY;
        w->allocations++;
        *made = (Inertia){{1}, inertia, mat3_inverse(inertia)};
        drop(share_note(&w->inertias, made));
        i = made;
    }
    drop(b->inertia);
    b->inertia = i;
    return DIG_OK;
}

/* Scales mass and inertia to a new mass. */
dig_status body_set_mass(World *w, Body *b, real mass)
{
    real scale = mass / b->mass;
    if (body_inertia_set(w, b, mat3_scale(scale, body_inertia(b)->of)) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for the inertia of a body");
    b->density *= scale;
    b->mass = mass;
    b->inv_mass = 1 / mass;
    return DIG_OK;
}

/* Are the principal moments equal to rounding? Then the body feels no gyroscopic torque. */
static bool is_isotropic(mat3 m)
{
    real size = 1e-12 * (m.r0.x + m.r1.y + m.r2.z);
    return fabs(m.r0.x - m.r1.y) < size && fabs(m.r0.x - m.r2.z) < size && fabs(m.r0.y) < size && fabs(m.r0.z) < size && fabs(m.r1.z) < size;
}

static dig_status set_mass_from_shapes(World *w, Body *b, const dig_body_def *def, const Shape *shapes, const int *materials)
{
    MassProps sum = {0};
    for (int i = 0; i < def->shape_count; i++) {
        const ShapeType *type = shapes[i].type;
        if (!type->mass)
            return world_fail(w, DIG_E_ARG, "%s: a %s has no mass: make the body fixed or kinematic", NEW_BODY_TEXT(def->name.s), type->name);
        MassProps unit;
        type->mass(&shapes[i], &unit);
        if (!(unit.volume > 0))
            return world_fail(w, DIG_E_ARG, "%s: its %s has volume %g m^3, must be > 0 (is the mesh closed?)", NEW_BODY_TEXT(def->name.s), type->name,
                              unit.volume);
        real density = isnan(def->density) ? w->materials.data[materials[i]].def.density : def->density;
        if (def->shapes[i].density > 0)
            density = def->shapes[i].density;
        pose at = quat_norm2(def->shapes[i].at.q) > 0 ? def->shapes[i].at : (pose){def->shapes[i].at.p, quat_identity()};
        mass_add(&sum, &unit, density, at);
    }
    b->centre = sum.centre;
    b->mass = sum.volume;           /* mass_add weighs with density: "volume" is kg here */
    if (body_inertia_set(w, b, sum.inertia) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for the inertia of a body");
    b->density = b->mass;
    real volume = 0;
    for (int i = 0; i < def->shape_count; i++) {
        MassProps unit;
        shapes[i].type->mass(&shapes[i], &unit);
        volume += unit.volume;
    }
    b->density = b->mass / volume;
    DIG_TRY(body_set_mass(w, b, isnan(def->mass) ? b->mass : def->mass));
    b->round_inertia = is_isotropic(body_inertia(b)->of);
    return DIG_OK;
}

/* What does not turn has so much inertia, that of all its mass at its farthest point, that no force it could bear turns it by anything
 * that shows: all ways to advance it take that as they take any inertia. */
#define UNTURNED 1e9

static dig_status keep_from_turning(World *w, Body *b)
{
    b->round_inertia = true;
    dig_status s = body_inertia_set(w, b, mat3_diagonal(vec3_scale(UNTURNED * b->mass * b->outer * b->outer, (vec3){1, 1, 1})));
    return s == DIG_OK ? s : world_fail(w, s, "not enough memory for the inertia of a body");
}

bool body_turns(const Body *b)
{
    return b->kind != DIG_DYNAMIC || body_inertia(b)->of.r0.x < 0.5 * UNTURNED * b->mass * b->outer * b->outer;
}

/* ---- creation ---- */

static bool is_share(real x) { return isnan(x) || (x >= 0 && isfinite(x)); }

static dig_status check_part(const World *w, const char *name, int number, const dig_shape_def *s)
{
    const dig_surface_def *own = s->surface;
    if (!vec3_finite(s->at.p) || !quat_finite(s->at.q))
        return world_fail(w, DIG_E_ARG, "%s: the place of its shape %d must be finite", name, number);
    if (!(s->density >= 0 && isfinite(s->density)))
        return world_fail(w, DIG_E_ARG, "%s: density = %g kg/m^3 of its shape %d, must be > 0", name, s->density, number);
    if (own && !(is_share(own->friction) && is_share(own->friction_dynamic) && is_share(own->rolling_friction) && is_share(own->restitution)))
        return world_fail(w, DIG_E_ARG, "%s: friction and restitution of its shape %d must be finite and >= 0", name, number);
    return DIG_OK;
}

static dig_status check_def(const World *w, const dig_body_def *def)
{
    const char *name = NEW_BODY_TEXT(def->name.s);
    if (def->fixed && def->kinematic)
        return world_fail(w, DIG_E_ARG, "%s: fixed and kinematic exclude each other", name);
    if (!vec3_finite(def->at) || !vec3_finite(def->velocity) || !vec3_finite(def->spin) || !quat_finite(def->rotation))
        return world_fail(w, DIG_E_ARG, "%s: at, rotation, velocity and spin must be finite", name);
    if (!def->turns && vec3_length2(def->spin) > 0)
        return world_fail(w, DIG_E_ARG, "%s: turns = false and a spin exclude each other", name);
    if (!isnan(def->mass) && !(def->mass > 0 && isfinite(def->mass)))
        return world_fail(w, DIG_E_ARG, "%s: mass = %g kg, must be > 0%s", name, def->mass,
                          def->mass == 0 ? " (a body without mass is fixed = true or kinematic = true)" : "");
    if (!isnan(def->density) && !(def->density > 0 && isfinite(def->density)))
        return world_fail(w, DIG_E_ARG, "%s: density = %g kg/m^3, must be > 0", name, def->density);
    if (!(quat_norm2(def->rotation) > 0.98 && quat_norm2(def->rotation) < 1.02))
        return world_fail(w, DIG_E_ARG, "%s: rotation has length %g, must be 1", name, sqrt(quat_norm2(def->rotation)));
    if (def->shape_count < 1 || def->shape_count > 4096)
        return world_fail(w, DIG_E_ARG, "%s: %d shapes, must be 1..4096", name, def->shape_count);
    for (int i = 0; i < def->shape_count; i++)
        DIG_TRY(check_part(w, name, i + 1, &def->shapes[i]));
    if (def->material.s[0] && material_find(w, def->material.s) < 0)
        return world_fail(w, DIG_E_ARG, "%s: there is no material '%s'", name, def->material.s);
    return DIG_OK;
}

static dig_status make_shapes(World *w, const dig_body_def *def, Shape *shapes, int *materials)
{
    int base = def->material.s[0] ? material_find(w, def->material.s) : 0;
    for (int i = 0; i < def->shape_count; i++) {
        const dig_shape_def *s = &def->shapes[i];
        char why[256] = "";
        materials[i] = s->material.s[0] ? material_find(w, s->material.s) : base;
        dig_status status = materials[i] < 0 ? DIG_E_ARG : shape_make(s->type, s->data, &shapes[i], why, sizeof why);
        if (status == DIG_OK)
            world_work_shape(w, &shapes[i], s->data);
        if (status == DIG_OK && !shapes[i].type->solid && !shapes[i].type->mass && !def->fixed && !def->kinematic) {
            shape_free(&shapes[i]);
            snprintf(why, sizeof why, "a %s has no mass: make the body fixed or kinematic", s->type);
            status = DIG_E_ARG;
        }
        if (status != DIG_OK) {
            while (--i >= 0)
                shape_free(&shapes[i]);
            return materials[0] < 0 || !why[0] ? world_fail(w, status, "%s: there is no material '%s'", NEW_BODY_TEXT(def->name.s), s->material.s)
                                               : world_fail(w, status, "%s: %s", NEW_BODY_TEXT(def->name.s), why);
        }
    }
    return DIG_OK;
}

/* A ball about its own centre gets nowhere by turning. */
void body_measure(const World *w, Body *b)
{
    const Solid *only = b->shape_count == 1 ? &w->solids.data[b->shape_first] : NULL;
    b->outer = 0;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next) {
        const Solid *solid = &w->solids.data[s];
        b->outer = real_max(b->outer, vec3_length(vec3_sub(solid->form->at.p, b->centre)) + solid->form->shape.outer);
    }
    b->rim = only && only->form->shape.type == &shape_sphere && vec3_equal(only->form->at.p, b->centre) ? 0 : b->outer;
}

/* What the part says, where it does not the body, where that does not (NaN) the material. */
static Surface surface_of(const dig_body_def *def, const dig_surface_def *own, int material)
{
    Surface s = {material, def->friction, def->friction_dynamic, def->rolling_friction, def->restitution};
    if (!own)
        return s;
    s.friction = isnan(own->friction) ? s.friction : own->friction;
    if (!isnan(own->friction_dynamic) || !isnan(own->friction))     /* the dynamic one is as the static one where nobody says it */
        s.friction_dynamic = own->friction_dynamic;
    s.rolling = isnan(own->rolling_friction) ? s.rolling : own->rolling_friction;
    s.restitution = isnan(own->restitution) ? s.restitution : own->restitution;
    return s;
}

static dig_status attach_solids(World *w, uint32_t slot, const dig_body_def *def, const Shape *shapes, const int *materials)
{
    Body *b = &w->bodies.data[slot];
    uint32_t last = NONE;
    for (int i = 0; i < def->shape_count; i++) {
        pose at = def->shapes[i].at;
        at.q = quat_norm2(at.q) > 0 ? quat_unit(at.q) : quat_identity();
        Surface surface = surface_of(def, def->shapes[i].surface, materials[i]);
        vec3 colour = def->shapes[i].colour.x >= 0 ? def->shapes[i].colour : def->colour;
        uint32_t solid;
        dig_status s = solid_add(w, slot, &shapes[i], at, &surface, colour, &solid);
        if (s != DIG_OK)
            return world_fail(w, s, "%s: not enough memory", NEW_BODY_TEXT(def->name.s));
        *(last == NONE ? &b->shape_first : &w->solids.data[last].next) = solid;
        last = solid;
        b->shape_count++;
    }
    return DIG_OK;
}

dig_status bodies_rest(World *w)
{
    DIG_TRY(list_reserve(&w->rest, w->bodies.capacity, &w->allocations));
    DIG_TRY(list_reserve(&w->drifts, w->bodies.capacity, &w->allocations));
    w->rest.count = w->drifts.count = w->bodies.count;
    return DIG_OK;
}

static dig_status take_slot(World *w, uint32_t *slot)
{
    DIG_TRY(world_slot(w, &w->bodies, &w->free_bodies, slot));
    dig_status room = bodies_rest(w);
    if (room != DIG_OK)
        slot_give(w, &w->free_bodies, *slot);
    return room;
}

const BodyRest no_rest;

BodyRest *body_rest_own(World *w, Body *b)
{
    BodyRest *rest = &w->rest.data[b - w->bodies.data];
    if (!b->rests)
        *rest = no_rest;
    b->rests = true;
    return rest;
}

void body_rest_set(World *w, Body *b, const BodyRest *rest)
{
    b->rests = memcmp(rest, &no_rest, sizeof *rest) != 0;
    if (b->rests)
        *body_rest_own(w, b) = *rest;
}

static void fill_body(World *w, Body *b, const dig_body_def *def)
{
    b->alive = true;
    b->awake = true;
    b->collides = def->collides;
    b->kind = def->fixed ? DIG_STATIC : def->kinematic ? DIG_KINEMATIC : DIG_DYNAMIC;
    b->mode = def->fixed ? DIG_FIXED : DIG_MOVING;
    b->q = quat_unit(def->rotation);
    b->v = def->fixed ? vec3_zero() : def->velocity;
    b->w = def->fixed ? vec3_zero() : def->spin;
    b->gravity_scale = def->gravity_scale;
    b->rate = 1;
    BodyRest rest = {.sheet = {round(def->sheet.x), round(def->sheet.y), round(def->sheet.z)}};
    memcpy(rest.name, def->name.s, sizeof rest.name);
    body_rest_set(w, b, &rest);
    b->shape_first = b->joint_first = NONE;
    b->move_end = -1;
    b->told_mass = b->kind == DIG_DYNAMIC || isnan(def->mass) ? 0 : def->mass;
    b->integrator = (uint8_t)def->integrator;
    b->euler = b->integrator != DIG_VERLET;
}

static dig_status finish_body(World *w, uint32_t slot, const dig_body_def *def, const Shape *shapes, const int *materials)
{
    Body *b = &w->bodies.data[slot];
    fill_body(w, b, def);
    Surface surface = {def->material.s[0] ? material_find(w, def->material.s) : 0, def->friction, def->friction_dynamic, def->rolling_friction,
                       def->restitution};
    DIG_TRY(body_make_set(w, b, &(Make){.surface = surface, .colour = def->colour, .opacity = def->opacity, .group = def->group}));
    if (b->kind == DIG_DYNAMIC)
        DIG_TRY(set_mass_from_shapes(w, b, def, shapes, materials));
    b->x = vec3_add(def->at, quat_rotate(b->q, b->centre));
    if (b->kind == DIG_DYNAMIC && w->region_count > 0)
        b->rate = region_rate(w, b->x);             /* its velocity is given as it is seen */
    b->prev_x = b->x;
    b->prev_q = b->q;
    DIG_TRY(attach_solids(w, slot, def, shapes, materials));
    b = &w->bodies.data[slot];
    body_measure(w, b);
    if (b->kind == DIG_DYNAMIC && !def->turns)
        DIG_TRY(keep_from_turning(w, b));
    DIG_TRY(list_reserve(&w->awake, w->bodies.capacity, &w->allocations));
    while (w->parent.count < w->bodies.capacity) {
        DIG_TRY(list_push(&w->parent, &w->allocations));
        w->parent.data[w->parent.count - 1] = NONE;
    }
    if (b->kind == DIG_DYNAMIC)
        DIG_TRY(graph_node_add(w->graph, slot));
    if (b->kind != DIG_STATIC)
        body_list(w, slot);
    return DIG_OK;
}

static void detach_solids(World *w, uint32_t slot)
{
    for (uint32_t s = w->bodies.data[slot].shape_first; s != NONE;) {
        uint32_t next = w->solids.data[s].next;
        solid_remove(w, s);
        s = next;
    }
}

/* Surfaces alone, which enclose nothing and so have no mass: unless one is given, they stand still, as planes do. */
static bool stands_still(const dig_body_def *def, const Shape *shapes)
{
    for (int i = 0; i < def->shape_count; i++)
        if (strcmp(shapes[i].type->name, "mesh") != 0 || shape_mesh_closed(&shapes[i]))
            return false;
    return !def->kinematic && isnan(def->mass) && isnan(def->density) && vec3_length2(def->velocity) + vec3_length2(def->spin) == 0;
}

dig_status body_create(World *w, const dig_body_def *given, dig_body *out)
{
    dig_body_def still = *given, *def = &still;
    DIG_TRY(check_def(w, def));
    arena_reset(&w->scratch);
    Shape *shapes = arena_zero(&w->scratch, (size_t)def->shape_count * sizeof *shapes);
    int *materials = arena_zero(&w->scratch, (size_t)def->shape_count * sizeof *materials);
    if (!shapes || !materials)
        return world_fail(w, DIG_E_MEMORY, "%s: not enough memory", NEW_BODY_TEXT(def->name.s));
    DIG_TRY(make_shapes(w, def, shapes, materials));
    still.fixed = still.fixed || stands_still(def, shapes);

    uint32_t slot, gen;
    uint32_t old_count = (uint32_t)w->bodies.count;
    dig_status s = world_generation(w, NEW_BODY_TEXT(def->name.s), &gen);
    bool numbered = s == DIG_OK;
    if (numbered)
        s = take_slot(w, &slot);
    if (s == DIG_OK) {
        w->bodies.data[slot].gen = gen;
        s = finish_body(w, slot, def, shapes, materials);
        if (s != DIG_OK) {
            detach_solids(w, slot);
            body_shares_drop(&w->bodies.data[slot]);
            w->bodies.data[slot].alive = false;
            slot_give(w, &w->free_bodies, slot);
        }
    } else if (numbered) {
        world_fail(w, s, "%s: not enough memory after %u bodies", NEW_BODY_TEXT(def->name.s), old_count);
    }
    for (int i = 0; i < def->shape_count; i++)
        shape_free(&shapes[i]);         /* the solids hold references of their own */
    if (s != DIG_OK)
        return s;
    *out = (dig_body){slot, w->bodies.data[slot].gen};
    if (w->ledger.started && w->bodies.data[slot].kind == DIG_DYNAMIC)
        w->ledger.initial += body_energy(w, &w->bodies.data[slot]);
    return DIG_OK;
}

real body_energy(const World *w, const Body *b)
{
    if (b->kind != DIG_DYNAMIC)
        return 0;
    vec3 wl = quat_unrotate(b->q, b->w);
    real kinetic = 0.5 * b->mass * vec3_length2(b->v) + 0.5 * vec3_dot(wl, mat3_mul_vec(body_inertia(b)->of, wl));
    return body_inertness(b) * kinetic - b->mass * b->gravity_scale * vec3_dot(w->def.gravity, b->x);
}

/* ---- removal and waking ---- */

void body_list(World *w, uint32_t slot)
{
    if (w->bodies.data[slot].listed)
        return;
    w->bodies.data[slot].listed = true;
    w->awake.data[w->awake.count++] = slot;
}

void body_wake(World *w, uint32_t slot)
{
    uint32_t id = graph_of(w->graph, slot);
    if (id == GRAPH_NONE) {
        if (w->bodies.data[slot].kind == DIG_KINEMATIC)
            body_list(w, slot);
        return;
    }
    for (uint32_t m = graph_first(w->graph, id); m != NONE; m = graph_next(w->graph, m)) {
        Body *b = &w->bodies.data[m];
        if (!b->awake) {
            event_post(w, DIG_EVENT_WOKE, m, NONE);
            body_list(w, m);
        }
        b->awake = true;
        b->still = 0;
        b->mode = DIG_MOVING;
    }
}

void world_wake_all(World *w)
{
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive)
            body_wake(w, (uint32_t)i);
}

void touches_wake(World *w, uint32_t slot)
{
    for (uint32_t s = w->bodies.data[slot].shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            uint32_t other = p->body_a == slot ? p->body_b : p->body_a;
            if (p->touching && other != NONE)
                body_wake(w, other);
        }
    for (uint32_t j = w->bodies.data[slot].joint_first; j != NONE; j = joint_next(w, j, slot)) {
        const JointRec *r = &w->joints.data[j];
        uint32_t other = r->a == slot ? r->b : r->a;
        if (other != NONE)
            body_wake(w, other);
    }
}

/* Wakes what touches the body, and drops its touches and links. */
static void leave_touches(World *w, uint32_t slot)
{
    for (int i = 0; i < w->touches.count; i++) {
        Touch *t = &w->touches.data[i];
        if (!t->alive || (t->body_a != slot && t->body_b != slot))
            continue;
        uint32_t other = t->body_a == slot ? t->body_b : t->body_a;
        if (other != NONE)
            body_wake(w, other);
        if (t->link != NONE)
            graph_link_remove(w->graph, t->link);
        touch_remove(w, (uint32_t)i);
    }
}

/* No joint holds it, nothing touches or pushes it, and no step moves it any more. */
static void withdraw(World *w, uint32_t slot)
{
    if (w->ledger.started)
        w->ledger.initial -= body_energy(w, &w->bodies.data[slot]);
    while (w->bodies.data[slot].joint_first != NONE)
        joint_remove(w, w->bodies.data[slot].joint_first);
    graph_begin(w->graph);
    leave_touches(w, slot);
    graph_end(w->graph);
    post_graph_changes(w, DIG_LAYER_MECHANICAL);
    if (graph_has_node(w->graph, slot))
        graph_node_remove(w->graph, slot);
    for (int i = w->pushes.count - 1; i >= 0; i--)
        if (w->pushes.data[i].body == slot)
            w->pushes.data[i] = w->pushes.data[--w->pushes.count];
    Body *b = &w->bodies.data[slot];
    for (int i = 0; b->listed && i < w->awake.count; i++)
        if (w->awake.data[i] == slot) {
            w->awake.data[i] = w->awake.data[--w->awake.count];
            b->listed = b->paired = false;
        }
}

void body_remove(World *w, uint32_t slot)
{
    withdraw(w, slot);
    layers_forget(w, slot);
    event_post(w, DIG_EVENT_REMOVED, slot, NONE);
    detach_solids(w, slot);
    for (int i = 0; i < w->effect_count; i++)
        column_remove(&w->effects[i].members, slot);
    w->bits.old = true;
    w->bodies.data[slot].alive = false;
    body_shares_drop(&w->bodies.data[slot]);
    slot_give(w, &w->free_bodies, slot);
}

void body_disable(World *w, uint32_t slot)
{
    body_wake(w, slot);                             /* what it was part of goes on without it */
    withdraw(w, slot);
    for (uint32_t s = w->bodies.data[slot].shape_first; s != NONE; s = w->solids.data[s].next)
        pairs_of_solid_remove(w, s);
    Body *b = &w->bodies.data[slot];
    if (!vec3_finite(b->x) || !quat_finite(b->q)) {
        b->x = b->prev_x;
        b->q = b->prev_q;
    }
    b->told_mass = b->kind == DIG_DYNAMIC ? b->mass : b->told_mass;
    b->kind = DIG_STATIC;
    b->mode = DIG_FIXED;
    b->collides = false;
    b->awake = true;
    b->v = b->w = b->force = b->torque = vec3_zero();
    b->mass = b->inv_mass = b->density = b->pull = b->still = b->trace_step = 0;
    drop_inertia(b);
    b->round_inertia = b->collided = b->crowded = false;
    b->trace_wait = b->trace_pause = 0;
    b->toil = (Toil){0, 0, 0};
    b->accuracy = 0;
    b->rate = 1;
    b->move_end = -1;
    b->watch = (BodyWatch){0};
    if (b->rests) {
        BodyRest *rest = body_rest_own(w, b);
        rest->hit_v = rest->hit_w = vec3_zero();
        rest->breach = (Breach){{0}, {0}, {0}};
    }
    body_refit(w, slot);
    event_post(w, DIG_EVENT_DISABLED, slot, NONE);
}
