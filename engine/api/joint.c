/* api/joint.c - joints: creation from a type's table, reading, setting. */
#include "api/api.h"
#include "api/command.h"

#include <stdio.h>

static const JointType *find_type(const char *name)
{
    for (int i = 0; joint_types[i]; i++)
        if (strcmp(joint_types[i]->name, name) == 0)
            return joint_types[i];
    return NULL;
}

static void view_end(const World *w, JointEnd *e, uint32_t body, vec3 anchor, quat frame)
{
    if (body == NONE) {
        joint_end_set(e, vec3_zero(), quat_identity(), vec3_zero(), vec3_zero(), anchor, frame);
        e->body = -1;
        return;
    }
    const Body *b = &w->bodies.data[body];
    joint_end_set(e, b->x, b->q, b->v, b->w, anchor, frame);
    e->body = (int)body;
}

static void view_of(const World *w, const JointRec *r, JointView *view, real memory[JOINT_MEMORY])
{
    memset(view, 0, sizeof *view);
    memcpy(memory, r->memory, sizeof r->memory);
    view->params = r->params;
    view->breaks_at = r->breaks_at;
    view->memory = memory;
    view->type = r->type;
    view_end(w, &view->a, r->a, r->ra, r->fa);
    view_end(w, &view->b, r->b, r->rb, r->fb);
}

void api_joint_view(const World *w, uint32_t slot, JointView *view, real memory[JOINT_MEMORY])
{
    view_of(w, &w->joints.data[slot], view, memory);
}

real api_joint_energy(const World *w, uint32_t slot)
{
    const JointRec *r = &w->joints.data[slot];
    real memory[JOINT_MEMORY];
    JointView view;
    if (!r->type->energy)
        return 0;
    view_of(w, r, &view, memory);
    return r->type->energy(&view);
}

real api_body_springs(const World *w, uint32_t body)
{
    real sum = 0;
    for (uint32_t j = w->bodies.data[body].joint_first; j != NONE; j = joint_next(w, j, body))
        sum += api_joint_energy(w, j);
    return sum;
}

void api_book_given(World *w, real energy)
{
    if (w->ledger.started)
        w->ledger.initial += energy;
}

dig_joint_def dig_joint_defaults(void)
{
    dig_joint_def def;
    memset(&def, 0, sizeof def);
    param_defaults(dig_schema_at("joint.common", 0)->rows, &def);
    return def;
}

/* Which bodies? For a type that couples joints, those that the two joints move. */
static dig_status find_bodies(const World *w, const JointType *type, const dig_joint_def *def, JointRec *r)
{
    r->a = r->b = r->other[0] = r->other[1] = r->link = NONE;
    if (type->couples) {
        const dig_joint *joints = def->data;
        for (int k = 0; k < 2; k++) {
            const JointRec *j = api_joint(w, joints[k], type->name);
            if (!j)
                return DIG_E_DEAD;
            *(k ? &r->b : &r->a) = w->bodies.data[j->a].kind == DIG_DYNAMIC || j->b == NONE ? j->a : j->b;
            r->other[k] = joints[k].slot;
        }
        /* a carrier of both wheels: the wheel itself, then */
        for (int k = 1; k >= 0 && r->a == r->b; k--) {
            const JointRec *j = &w->joints.data[r->other[k]];
            uint32_t other = j->a == r->a ? j->b : j->a;
            *(k ? &r->b : &r->a) = other == NONE ? r->a : other;
        }
        if (r->a == r->b && r->other[0] != r->other[1])
            return world_fail(w, DIG_E_ARG, "%s: a and b both join %s to the world", type->name, BODY_TEXT(w, &w->bodies.data[r->a]));
        return r->other[0] != r->other[1] ? DIG_OK : world_fail(w, DIG_E_ARG, "%s: a and b are the same joint", type->name);
    }
    if (!api_body(w, def->a, type->name))
        return DIG_E_DEAD;
    r->a = def->a.slot;
    if (def->b.gen) {
        if (!api_body(w, def->b, type->name))
            return DIG_E_DEAD;
        r->b = def->b.slot;
    }
    const Body *a = &w->bodies.data[r->a], *b = r->b == NONE ? NULL : &w->bodies.data[r->b];
    if (r->a == r->b)
        return world_fail(w, DIG_E_ARG, "%s: a and b are the same %s", type->name, BODY_TEXT(w, a));
    if (a->kind != DIG_DYNAMIC && (!b || b->kind != DIG_DYNAMIC))
        return world_fail(w, DIG_E_ARG, "%s: nothing to hold: neither %s nor %s can move", type->name, BODY_TEXT(w, a), b ? BODY_TEXT(w, b) : "the world");
    return DIG_OK;
}

/* Anchors and frames in the bodies' own axes, from world points. */
static dig_status place(const World *w, const JointType *type, const dig_joint_def *def, JointRec *r)
{
    const Body *a = &w->bodies.data[r->a], *b = r->b == NONE ? NULL : &w->bodies.data[r->b];
    vec3 at = isnan(def->at.x) ? a->x : def->at, pa = at, pb = at;
    DIG_TRY(api_finite(w, at, type->name, "at", "m"));
    if (type->two_anchors) {
        const vec3 *anchors = (const vec3 *)(const void *)r->params;
        pa = isnan(anchors[0].x) ? a->x : anchors[0];
        pb = !isnan(anchors[1].x) ? anchors[1] : b ? b->x : at;
        if (!b && isnan(anchors[1].x) && isnan(def->at.x))
            return world_fail(w, DIG_E_ARG, "%s: a joint to the world needs 'at' or 'at_b', the point where it hangs", type->name);
    }
    vec3 axis = isnan(def->axis.x) ? (vec3){0, 1, 0} : def->axis, u, n;
    DIG_TRY(api_finite(w, axis, type->name, "axis", ""));
    if (!(vec3_length(axis) > 1e-9))
        return world_fail(w, DIG_E_ARG, "%s: axis = {%g, %g, %g} has no direction", type->name, axis.x, axis.y, axis.z);
    axis = vec3_unit(axis);
    vec3_basis(axis, &u, &n);
    vec3 up = type->has_up ? *(const vec3 *)(const void *)r->params : (vec3){NAN, NAN, NAN};
    up = vec3_mad(up, -vec3_dot(up, axis), axis);
    if (vec3_length(up) > 1e-9) {           /* false for NaN: any will do */
        u = vec3_unit(up);
        n = vec3_cross(axis, u);
    }
    quat frame = quat_from_matrix(mat3_transpose((mat3){axis, u, n}));
    r->ra = quat_unrotate(a->q, vec3_sub(pa, a->x));
    r->fa = quat_mul(quat_conjugate(a->q), frame);
    r->rb = b ? quat_unrotate(b->q, vec3_sub(pb, b->x)) : pb;
    r->fb = b ? quat_mul(quat_conjugate(b->q), frame) : frame;
    return DIG_OK;
}

static dig_status add_link(World *w, uint32_t slot)
{
    JointRec *r = &w->joints.data[slot];
    uint32_t a = r->a, b = r->b;
    if (a == NONE || b == NONE || a == b)
        return DIG_OK;                      /* to the world: nothing to link */
    bool dynamic_a = w->bodies.data[a].kind == DIG_DYNAMIC, dynamic_b = w->bodies.data[b].kind == DIG_DYNAMIC;
    graph_begin(w->graph);
    dig_status s = graph_link_add(w->graph, dynamic_a ? a : b, dynamic_a ? b : a, !dynamic_a || !dynamic_b, DIG_LINK_JOINT, slot, world_time(w), &r->link);
    DIG_TRY(graph_end(w->graph));
    if (s != DIG_OK) {
        r->link = NONE;
        return s;
    }
    dig_event *e = event_post(w, DIG_EVENT_LINK, a, b);
    if (e)
        e->link = DIG_LINK_JOINT;
    post_graph_changes(w, DIG_LAYER_MECHANICAL);
    return DIG_OK;
}

/* What ranges cannot check; may complete params. */
static dig_status check_params(const World *w, const JointRec *r, void *params, bool fresh)
{
    JointView view, other[2];
    real memory[3][JOINT_MEMORY];
    char why[256] = "";
    if (!r->type->check)
        return DIG_OK;
    view_of(w, r, &view, memory[0]);
    for (int k = 0; k < 2 && r->type->couples; k++) {
        view_of(w, &w->joints.data[r->other[k]], &other[k], memory[k + 1]);
        view.other[k] = &other[k];
    }
    view.params = params;
    dig_status s = r->type->check(params, &view, why, sizeof why);
    if (s == DIG_OK && fresh && r->type->check_new)
        s = r->type->check_new(params, &view, why, sizeof why);
    return s == DIG_OK ? s : world_fail(w, s, "%s: %s", r->type->name, why);
}

static dig_status prepare(World *w, const dig_joint_def *def, JointRec *r)
{
    const JointType *type = def->type ? find_type(def->type) : NULL;
    if (!type)
        return world_fail(w, DIG_E_ARG, "there is no joint type '%s'", def->type ? def->type : "(null)");
    memset(r, 0, sizeof *r);
    r->type = type;
    if (type->params_size > sizeof r->params)
        return world_fail(w, DIG_E_ARG, "%s: its parameters take %zu bytes, at most %zu", type->name, type->params_size, sizeof r->params);
    if (def->data)
        memcpy(r->params, def->data, type->params_size);
    else
        param_defaults(type->params, r->params);
    char why[256] = "";
    if (param_check(type->params, r->params, type->name, why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    param_settle(type->params, r->params);
    if (!memchr(def->name.s, 0, sizeof def->name.s))
        return world_fail(w, DIG_E_ARG, "%s: its name is longer than 63 bytes", type->name);
    if (!(def->breaks_at > 0))
        return world_fail(w, DIG_E_ARG, "%s: breaks_at = %g N, must be > 0", type->name, def->breaks_at);
    DIG_TRY(find_bodies(w, type, def, r));
    DIG_TRY(place(w, type, def, r));
    memcpy(r->name, def->name.s, sizeof r->name);
    r->breaks_at = isfinite(def->breaks_at) ? def->breaks_at : 0;
    r->collides = def->collides || type->couples;
    r->at_point = type->at_point;
    r->plain = joint_plain(type, r->params);
    return check_params(w, r, r->params, true);
}

static dig_status do_create(World *w, const dig_joint_def *def, dig_joint *out)
{
    JointRec r;
    uint32_t slot;
    *out = (dig_joint){0, 0};
    DIG_TRY(prepare(w, def, &r));
    DIG_TRY(world_generation(w, def->type, &r.gen));
    if (world_slot(w, &w->joints, &w->free_joints, &slot) != DIG_OK)
        return world_fail(w, DIG_E_MEMORY, "%s: not enough memory", def->type);
    r.alive = true;
    r.next_a = r.next_b = NONE;
    w->joints.data[slot] = r;
    if (add_link(w, slot) != DIG_OK) {
        w->joints.data[slot].alive = false;
        slot_give(w, &w->free_joints, slot);
        return world_fail(w, DIG_E_MEMORY, "%s: not enough memory", def->type);
    }
    joint_attach(w, slot);
    body_wake(w, r.a);
    if (r.b != NONE)
        body_wake(w, r.b);
    joint_stir_pairs(w, &r);
    api_book_given(w, api_joint_energy(w, slot));
    *out = (dig_joint){slot, r.gen};
    return DIG_OK;
}

dig_status run_joint(World *w, CommandArg *a)
{
    return do_create(w, a[0].what, a[1].place);
}

dig_status dig_joint_create(dig_world *w, const dig_joint_def *def, dig_joint *out)
{
    return COMMAND(w, COMMAND_JOINT, do_create(w, def, out), {.what = def}, {.place = out});
}

static dig_status do_remove_joint(World *w, dig_joint j)
{
    const JointRec *r = api_joint(w, j, "remove");
    if (!r)
        return DIG_E_DEAD;
    api_book_given(w, -api_joint_energy(w, j.slot));
    joint_remove(w, j.slot);
    return DIG_OK;
}

dig_status run_joint_remove(World *w, CommandArg *a)
{
    return do_remove_joint(w, a[0].joint);
}

dig_status dig_joint_remove(dig_world *w, dig_joint j)
{
    return COMMAND(w, COMMAND_JOINT_REMOVE, do_remove_joint(w, j), {.joint = j});
}

bool dig_joint_alive(const dig_world *w, dig_joint j) { return world_joint(w, j) != NULL; }

dig_status dig_joint_get(const dig_world *w, dig_joint handle, dig_joint_state *out)
{
    const JointRec *r = api_joint(w, handle, "joint");
    if (!r)
        return DIG_E_DEAD;
    JointView view;
    real memory[JOINT_MEMORY];
    view_of(w, r, &view, memory);
    memset(out, 0, sizeof *out);
    out->type = r->type->name;
    out->name = r->name;
    out->a = body_handle(w, r->a);
    out->b = body_handle(w, r->b);
    out->at = view.a.p;
    if (r->type->coordinate)
        *(r->type->angular ? &out->angle : &out->distance) = r->type->coordinate(&view);
    if (r->type->two_anchors)
        out->distance = vec3_distance(view.a.p, view.b.p);
    out->speed = r->type->speed ? r->type->speed(&view) : 0;
    out->force = r->force;
    out->torque = vec3_sub(r->torque, vec3_cross(view.a.r, r->force));      /* the couple at the anchor */
    out->stress = joint_share(&view, out->force, out->torque);
    out->at_limit = r->type->at_limit && r->type->at_limit(&view);
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    if (!r->type->couples) {
        r->type->rows(&view, &list);
        for (int i = 0; i < list.count; i++)
            if (rows[i].kind == ROW_HARD && !rows[i].angular)
                out->error = hypot(out->error, rows[i].error);
    }
    return DIG_OK;
}

dig_status dig_joint_param(const dig_world *w, dig_joint handle, const char *name, void *value)
{
    const JointRec *r = api_joint(w, handle, name);
    size_t offset;
    if (!r)
        return DIG_E_DEAD;
    if (strcmp(name, "breaks_at") == 0) {
        *(real *)value = r->breaks_at > 0 ? r->breaks_at : INFINITY;
        return DIG_OK;
    }
    if (strcmp(name, "collides") == 0) {
        *(bool *)value = r->collides;
        return DIG_OK;
    }
    const dig_param *row = param_find_path(r->type->params, name, &offset);
    if (!row)
        return world_fail(w, DIG_E_ARG, "%s has no parameter '%s'", r->type->name, name);
    memcpy(value, (const char *)r->params + offset, param_size(row));
    return DIG_OK;
}

/* Copies of what can be set in a joint. */
typedef struct Settable { real params[sizeof ((JointRec *)0)->params / sizeof(real)], breaks_at; bool collides; } Settable;

static dig_status set_one(World *w, const JointRec *r, const dig_setting *set, Settable *to)
{
    size_t offset;
    char why[256];
    if (strcmp(set->param, "breaks_at") == 0) {
        real force = *(const real *)set->value;
        if (!(force > 0))
            return world_fail(w, DIG_E_ARG, "%s: breaks_at = %g N, must be > 0", r->type->name, force);
        to->breaks_at = isfinite(force) ? force : 0;
        return DIG_OK;
    }
    if (strcmp(set->param, "collides") == 0) {
        to->collides = *(const bool *)set->value;
        return to->collides || !r->type->couples ? DIG_OK : world_fail(w, DIG_E_ARG, "%s: collides is a matter of the joints it couples", r->type->name);
    }
    const dig_param *row = param_find_path(r->type->params, set->param, &offset);
    if (!row)
        return world_fail(w, DIG_E_ARG, "%s has no parameter '%s'", r->type->name, set->param);
    if (row->kind == DIG_JOINT || row->kind == DIG_BODY)
        return world_fail(w, DIG_E_ARG, "%s: '%s' is fixed at creation", r->type->name, set->param);
    if (param_check_field(row, set->value, r->type->name, why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    memcpy((char *)to->params + offset, set->value, param_size(row));
    return DIG_OK;
}

static void set_collides(World *w, JointRec *r, bool collides)
{
    if (collides == r->collides)
        return;
    r->collides = collides;
    body_wake(w, r->a);
    if (r->b != NONE)
        body_wake(w, r->b);
    joint_stir_pairs(w, r);
}

static dig_status do_set(World *w, dig_joint handle, const dig_setting *set, int count)
{
    JointRec *r = api_joint(w, handle, count > 0 ? set[0].param : "set");
    if (!r)
        return DIG_E_DEAD;
    Settable to = {.breaks_at = r->breaks_at, .collides = r->collides};
    memcpy(to.params, r->params, sizeof to.params);
    for (int i = 0; i < count; i++)
        DIG_TRY(set_one(w, r, &set[i], &to));
    param_settle(r->type->params, to.params);
    bool wakes = to.breaks_at != r->breaks_at;      /* at rest it may bear too much for that */
    if (memcmp(to.params, r->params, sizeof to.params) != 0) {
        DIG_TRY(check_params(w, r, to.params, false));
        real before = api_joint_energy(w, handle.slot);
        memcpy(r->params, to.params, sizeof to.params);
        r->plain = joint_plain(r->type, r->params);
        api_book_given(w, api_joint_energy(w, handle.slot) - before);
        wakes = true;
    }
    if (wakes && r->a != NONE)
        body_wake(w, r->a);
    if (wakes && r->b != NONE)
        body_wake(w, r->b);
    r->breaks_at = to.breaks_at;
    set_collides(w, r, to.collides);
    return DIG_OK;
}

dig_status run_joint_set(World *w, CommandArg *a)
{
    const CommandSettings *s = a[1].what;
    return do_set(w, a[0].joint, s->set, s->count);
}

dig_status dig_joint_set(dig_world *w, dig_joint handle, const dig_setting *settings, int count)
{
    return COMMAND(w, COMMAND_JOINT_SET, do_set(w, handle, settings, count), {.joint = handle}, {.what = &(CommandSettings){settings, count}});
}

int dig_joints(const dig_world *w, dig_joint *out, int capacity)
{
    int n = 0;
    for (int i = 0; i < w->joints.count; i++)
        if (w->joints.data[i].alive) {
            if (n < capacity)
                out[n] = joint_handle(w, (uint32_t)i);
            n++;
        }
    return n;
}

dig_joint dig_joint_find(const dig_world *w, const char *name)
{
    for (int i = 0; i < w->joints.count; i++)
        if (w->joints.data[i].alive && strcmp(w->joints.data[i].name, name) == 0)
            return joint_handle(w, (uint32_t)i);
    return (dig_joint){0, 0};
}
