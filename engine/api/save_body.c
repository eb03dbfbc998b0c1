/* api/save_body.c - the sections of bodies and of their solids. */
#include "api/save.h"

#include <stdio.h>
#include <stdlib.h>

enum { BODY_BYTES = 400, SOLID_BYTES = 133 + SHAPE_PACKED };        /* at least */

/* Follows from the rest: inverses, list membership, the number of shapes, the outer radius and what turning moves of it. */
static void pack_mass(Pack *p, World *w, Body *b)
{
    mat3 inertia = body_inertia(b)->of;
    pack_real_in(p, &b->mass, 1e-30, 1e30, "mass of a body");
    pack_real_in(p, &b->density, 0, 1e60, "density of a body");
    pack_vec3(p, &inertia.r0, 1e60, "inertia of a body");
    pack_vec3(p, &inertia.r1, 1e60, "inertia of a body");
    pack_vec3(p, &inertia.r2, 1e60, "inertia of a body");
    if (p->reading && pack_good(p) && body_inertia_set(w, b, inertia) != DIG_OK)
        pack_fail_memory(p);
    pack_bool(p, &b->round_inertia);
}

/* Rotations are zero until the body is first told to move. */
static void pack_turn(Pack *p, quat *q, bool used)
{
    if (used)
        pack_quat(p, q, "rotation of a mover");
    else if (p->reading)
        *q = (quat){0, 0, 0, 0};
}

static void pack_mover(Pack *p, Body *b, BodyRest *rest)
{
    pack_real_in(p, &b->move_start, -SAVE_LONG, SAVE_LONG, "start of a move");
    pack_real_in(p, &b->move_end, -SAVE_LONG, SAVE_LONG, "end of a move");
    bool used = rest->turn_to.w != 0 || rest->turn_to.x != 0 || rest->turn_to.y != 0 || rest->turn_to.z != 0;
    pack_bool(p, &used);
    pack_check(p, used || !(b->move_end > b->move_start), "a body moves to nowhere");
    vec3 from = rest->move_to;             /* where it came from has its place in the file, but nobody asks for it */
    quat turn_from = rest->turn_to;
    pack_vec3(p, &from, SAVE_FAR, "start of a move");
    pack_vec3(p, &rest->move_to, SAVE_FAR, "end of a move");
    pack_turn(p, &turn_from, used);
    pack_turn(p, &rest->turn_to, used);
}

static void pack_last_message(Pack *p, World *w, Body *b)
{
    char kind[sizeof no_rest.message_kind] = "";
    pack_u64(p, &b->message_id);
    if (b->message_id == 0)
        return;
    pack_real_in(p, &b->message_time, -SAVE_LONG, SAVE_LONG, "time of a message");
    save_body_handle(p, w, &b->message_from);
    pack_u64(p, &b->message_root);
    if (!p->reading)
        snprintf(kind, sizeof kind, "%s", body_message_kind(w, b));
    pack_text(p, kind, sizeof kind);
    if (!p->reading)
        return;
    b->told_blow = strcmp(kind, MESSAGE_BLOW) == 0;
    if (!b->told_blow)
        memcpy(body_rest_own(w, b)->message_kind, kind, sizeof kind);
}

static void pack_drift(Pack *p, World *w, Body *b)
{
    pack_bool(p, &b->crowded);
    if (!b->crowded)
        return;
    pack_vec3(p, &body_drift(w, b)->way, SAVE_FAR, "drift of a body");
    pack_vec3(p, &body_drift(w, b)->turn, SAVE_LONG, "drift of a body");
}

static void pack_motion(Pack *p, World *w, Body *b, BodyRest *rest)
{
    pack_vec3(p, &b->x, SAVE_FAR, "position of a body");
    pack_quat(p, &b->q, "rotation of a body");
    pack_vec3(p, &b->v, SAVE_FAST, "velocity of a body");
    pack_vec3(p, &b->w, SAVE_FAST, "spin of a body");
    pack_vec3(p, &b->prev_x, SAVE_FAR, "last position of a body");
    pack_quat(p, &b->prev_q, "last rotation of a body");
    pack_vec3(p, &b->force, SAVE_STRONG, "force on a body");
    pack_vec3(p, &b->torque, SAVE_STRONG, "torque on a body");
    pack_vec3(p, &rest->hit_v, 2 * SAVE_FAST, "hits of a body");
    pack_vec3(p, &rest->hit_w, 2 * SAVE_FAST, "hits of a body");
    pack_real_in(p, &b->work, -SAVE_MUCH, SAVE_MUCH, "work on a body");
    pack_real_in(p, &b->still, 0, SAVE_LONG, "time a body was still");
    pack_drift(p, w, b);
    pack_real_in(p, &b->travel, 0, TRAVEL_MOST, "travel of a body");
    pack_bool(p, &b->collided);
    pack_bool(p, &b->euler);
    bool moves = vec3_length2(b->v) > 0 || vec3_length2(b->w) > 0;
    pack_check(p, !moves || (b->kind != DIG_STATIC && (b->awake || b->kind == DIG_KINEMATIC)), "a body that is asleep or fixed moves");
}

static void pack_make(Pack *p, World *w, Body *b)
{
    Make make = *body_make(b);
    pack_i64(p, &make.group);
    save_surface(p, w, &make.surface);
    pack_real(p, &make.colour.x);
    pack_real(p, &make.colour.y);
    pack_real(p, &make.colour.z);
    pack_real_in(p, &make.opacity, 0, 1, "opacity of a body");
    if (p->reading && pack_good(p) && body_make_set(w, b, &make) != DIG_OK)
        pack_fail_memory(p);
}

static void pack_body(Pack *p, World *w, Body *b)
{
    BodyRest rest = *body_rest(w, b);
    b->alive = true;
    save_gen(p, w, &b->gen, true);
    pack_bool(p, &b->awake);
    pack_bool(p, &b->collides);
    pack_bool(p, &b->out);
    pack_enum(p, &b->kind, 3, "kind of a body");
    pack_enum(p, &b->mode, 3, "mode of a body");
    pack_check(p, (b->mode == DIG_FIXED) == (b->kind == DIG_STATIC), "the mode of a body is not one of its kind");
    pack_text(p, rest.name, sizeof rest.name);
    pack_vec3(p, &b->centre, SAVE_FAR, "centre of mass of a body");
    if (b->kind == DIG_DYNAMIC)
        pack_mass(p, w, b);
    else
        pack_real_in(p, &b->told_mass, 0, 1e30, "mass of a body");
    pack_real_in(p, &b->gravity_scale, -1000, 1000, "gravity_scale of a body");
    pack_make(p, w, b);
    pack_real_in(p, &rest.sheet.x, 0, 1e9, "sheet of a body");
    pack_real_in(p, &rest.sheet.y, 0, 1e9, "sheet of a body");
    pack_real_in(p, &rest.sheet.z, 0, 1e9, "sheet of a body");
    pack_motion(p, w, b, &rest);
    if (b->kind == DIG_KINEMATIC)
        pack_mover(p, b, &rest);
    else if (p->reading)
        b->move_end = -1;
    if (p->reading)
        body_rest_set(w, b, &rest);
    pack_u32(p, &b->shape_first);
    pack_u32(p, &b->joint_first);
    pack_last_message(p, w, b);
    pack_small(p, &b->accuracy, ACCURACY_FINEST + 1, "accuracy of a body");
    pack_u16(p, &b->trace_wait);
    pack_u16(p, &b->trace_pause);
    pack_real_in(p, &b->trace_step, 0, 1, "traced step of a body");
    pack_u8(p, &b->toil.steps);
    pack_u8(p, &b->toil.pause);
    pack_u8(p, &b->toil.dear);
    pack_small(p, &b->integrator, DIG_INTEGRATORS, "integrator of a body");
}

void save_bodies(Pack *p, World *w)
{
    unsigned char *unused = SAVE_TABLE(p, w, &w->bodies, &w->free_bodies, BODY_BYTES, "bodies");
    if (p->reading && unused && bodies_rest(w) != DIG_OK)
        pack_fail_memory(p);
    for (int i = 0; unused && i < w->bodies.count && pack_good(p); i++)
        if (!unused[i])
            pack_body(p, w, &w->bodies.data[i]);
    free(unused);
}

static void pack_solid(Pack *p, World *w, Solid *s)
{
    Form form = {.share = {0}};
    if (!p->reading)
        form = *s->form;
    pack_index(p, &s->body, (uint32_t)w->bodies.count, true, "body of a solid");
    pack_index(p, &s->next, (uint32_t)w->solids.count, true, "next solid of a body");
    save_pose(p, &form.at, "place of a solid");
    save_surface(p, w, &form.surface);
    pack_real(p, &form.colour.x);
    pack_real(p, &form.colour.y);
    pack_real(p, &form.colour.z);
    pack_i32(p, &s->leaf);
    pack_real_in(p, &s->struck, 0, INFINITY, "room of a leaf for blows");
    pack_small(p, &s->wall, 7, "wall of a solid");
    pack_u32(p, &s->pair_first);
    shape_pack(p, &form.shape);
    if (!p->reading)
        return;
    form.arm = vec3_sub(form.at.p, s->body < (uint32_t)w->bodies.count ? w->bodies.data[s->body].centre : vec3_zero());
    s->alive = form.shape.type && solid_form(w, s, &form) == DIG_OK;
    if (form.shape.type && !s->alive)
        pack_fail_memory(p);
    shape_free(&form.shape);    /* the solid holds a reference of its own */
}

void save_solids(Pack *p, World *w)
{
    unsigned char *unused = SAVE_TABLE(p, w, &w->solids, &w->free_solids, SOLID_BYTES, "solids");
    for (int i = 0; unused && i < w->solids.count && pack_good(p); i++)
        if (!unused[i])
            pack_solid(p, w, &w->solids.data[i]);
    free(unused);
}
