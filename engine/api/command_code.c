/* api/command_code.c - arguments of commands as bytes, and back: one function for each letter, which writes and reads.
 *
 * Definitions go by their rows (dig_schema), so that a new row is logged without new code. What is written is copied first;
 * what is read lies in the coder's memory. Reading trusts nothing but leaves ranges to the call, which checks them anyway.
 */
#include "api/command.h"

#include <stdio.h>

/* ---- memory ---- */

/* Room for what is read; for what is written, a copy of it. NULL after a failure. */
static void *room(Coder *c, const void *given, size_t size)
{
    void *mine = pack_good(c->p) ? arena_zero(c->memory, size + 1) : NULL;
    if (!mine && pack_good(c->p))
        pack_fail_memory(c->p);
    if (mine && given && !c->p->reading)
        memcpy(mine, given, size);
    return mine;
}

/* The struct of an argument, to be coded field by field; NULL after a failure. */
static void *struct_of(Coder *c, CommandArg *a, size_t size)
{
    if (!c->p->reading && !a->what)
        pack_fail(c->p, "a definition is missing");
    void *mine = room(c, a->what, size);
    if (c->p->reading)
        a->what = mine;
    return mine;
}

static bool is_there(Coder *c, const void *given)
{
    bool there = given != NULL;
    pack_bool(c->p, &there);
    return there && pack_good(c->p);
}

/* ---- numbers and texts ---- */

static void code_reals(Pack *p, real *x, int count)
{
    for (int i = 0; i < count; i++)
        pack_real(p, &x[i]);
}

static void code_vec3(Pack *p, vec3 *v)
{
    pack_real(p, &v->x);
    pack_real(p, &v->y);
    pack_real(p, &v->z);
}

static void code_quat(Pack *p, quat *q)
{
    pack_real(p, &q->x);
    pack_real(p, &q->y);
    pack_real(p, &q->z);
    pack_real(p, &q->w);
}

static void code_pose(Pack *p, pose *at)
{
    code_vec3(p, &at->p);
    code_quat(p, &at->q);
}

static void arg_vec3(Coder *c, CommandArg *a) { code_vec3(c->p, &a->vec); }
static void arg_number(Coder *c, CommandArg *a) { pack_real(c->p, &a->number); }
static void arg_whole(Coder *c, CommandArg *a) { pack_u64(c->p, &a->whole); }
static void arg_yes(Coder *c, CommandArg *a) { pack_bool(c->p, &a->yes); }

/* Names are far shorter than 255 bytes: what is cut here is refused by the call. */
static const char *code_text(Coder *c, const char *given)
{
    char text[256] = "";
    if (given && !c->p->reading)
        snprintf(text, sizeof text, "%s", given);
    pack_text(c->p, text, sizeof text);
    char *mine = c->p->reading ? room(c, NULL, strlen(text)) : NULL;
    if (mine)
        memcpy(mine, text, strlen(text));
    return mine ? mine : given;
}

static void arg_text(Coder *c, CommandArg *a)
{
    if (!c->p->reading && !a->what)
        pack_fail(c->p, "a name is missing");
    a->what = code_text(c, a->what);
}

static void arg_text_or_none(Coder *c, CommandArg *a)
{
    if (is_there(c, a->what))
        a->what = code_text(c, a->what);
}

static void arg_vec3_or_none(Coder *c, CommandArg *a)
{
    vec3 *v = is_there(c, a->what) ? struct_of(c, a, sizeof *v) : NULL;
    if (v)
        code_vec3(c->p, v);
}

static void arg_quat_or_none(Coder *c, CommandArg *a)
{
    quat *q = is_there(c, a->what) ? struct_of(c, a, sizeof *q) : NULL;
    if (q)
        code_quat(c->p, q);
}

/* ---- handles ---- */

static void arg_body(Coder *c, CommandArg *a) { save_body_handle(c->p, c->w, &a->body); }
static void arg_joint(Coder *c, CommandArg *a) { save_joint_handle(c->p, c->w, &a->joint); }
static void arg_region(Coder *c, CommandArg *a) { save_region_handle(c->p, c->w, &a->region); }

static void arg_wire(Coder *c, CommandArg *a)
{
    pack_u32(c->p, &a->wire.layer);
    pack_u32(c->p, &a->wire.slot);
    save_gen(c->p, c->w, &a->wire.gen, false);
}

static void code_dig(Pack *p, dig_dig *d)
{
    pack_u32(p, &d->id);
    pack_u32(p, &d->layer);
}

static void arg_dig(Coder *c, CommandArg *a) { code_dig(c->p, &a->dig); }

/* ---- structs that rows describe ---- */

static void code_points(Coder *c, dig_points *list, const char *name)
{
    uint32_t count = pack_count(c->p, list->v && list->count > 0 ? (uint32_t)list->count : 0, sizeof(vec3), name);
    vec3 *v = room(c, list->v, count * sizeof *v);
    for (uint32_t i = 0; v && i < count; i++)
        code_vec3(c->p, &v[i]);
    *list = (dig_points){v, v ? (int)count : 0};
}

static void code_indices(Coder *c, dig_indices *list, const char *name)
{
    uint32_t count = pack_count(c->p, list->v && list->count > 0 ? (uint32_t)list->count : 0, sizeof(int64_t), name);
    int64_t *v = room(c, list->v, count * sizeof *v);
    for (uint32_t i = 0; v && i < count; i++)
        pack_i64(c->p, &v[i]);
    *list = (dig_indices){v, v ? (int)count : 0};
}

static void code_rows(Coder *c, const dig_param *rows, void *fields)
{
    for (const dig_param *row = rows; row && row->name && pack_good(c->p); row++) {
        void *field = (char *)fields + row->offset;
        switch (row->kind) {
        case DIG_TABLE: code_rows(c, row->rows, field); break;
        case DIG_POINTS: code_points(c, field, row->name); break;
        case DIG_INDICES: code_indices(c, field, row->name); break;
        default: save_field(c->p, c->w, row, field); break;
        }
    }
}

static const dig_param *common(const char *kind) { return dig_schema_at(kind, 0)->rows; }

static void arg_room(Coder *c, CommandArg *a)
{
    dig_room_def *def = struct_of(c, a, sizeof *def);
    if (def)
        code_rows(c, common("room"), def);
}

static void arg_material(Coder *c, CommandArg *a)
{
    dig_material_def *def = struct_of(c, a, sizeof *def);
    if (def)
        code_rows(c, common("material"), def);
}

static void arg_pair(Coder *c, CommandArg *a)
{
    dig_pair_def *def = struct_of(c, a, sizeof *def);
    if (!def)
        return;
    pack_text(c->p, def->a.s, sizeof def->a.s);
    pack_text(c->p, def->b.s, sizeof def->b.s);
    pack_real(c->p, &def->friction);
    pack_real(c->p, &def->friction_dynamic);
    pack_real(c->p, &def->rolling_friction);
    pack_real(c->p, &def->restitution);
}

/* A struct of one of several types, by the type's name. */
static void *code_typed(Coder *c, const char *kind, const char **type, const void *data)
{
    const dig_schema *s = NULL;
    if (!c->p->reading && (!*type || !data))
        pack_fail(c->p, "a %s has no type or no data", kind);
    *type = code_text(c, *type);
    if (pack_good(c->p) && !(s = dig_schema_find(kind, *type)))
        pack_fail(c->p, "there is no %s '%s'", kind, *type);
    void *mine = s ? room(c, data, s->size) : NULL;
    if (mine)
        code_rows(c, s->rows, mine);
    return mine;
}

/* The rows of a heightfield do not name its heights: there are as many as they say. */
static void code_heights(Coder *c, dig_heightfield_def *def)
{
    bool bounded = def->columns >= 1 && def->columns <= 65536 && def->rows >= 1 && def->rows <= 32767;
    size_t most = bounded ? (size_t)(def->columns * def->rows) : 0;
    uint32_t count = pack_count(c->p, def->heights ? (uint32_t)most : 0, sizeof(real), "heights");
    if (count != 0 && count != most)
        pack_fail(c->p, "a heightfield has %u heights, must be %zu", count, most);
    real *heights = room(c, def->heights, count * sizeof *heights);
    if (heights)
        code_reals(c->p, heights, (int)count);
    def->heights = count > 0 ? heights : NULL;
}

static void code_shape(Coder *c, dig_shape_def *s)
{
    void *data = code_typed(c, "shape", &s->type, s->data);
    if (data && strcmp(s->type, "heightfield") == 0)
        code_heights(c, data);
    s->data = data;
    code_pose(c->p, &s->at);
    pack_text(c->p, s->material.s, sizeof s->material.s);
    code_vec3(c->p, &s->colour);
    pack_real(c->p, &s->density);
    bool own = s->surface != NULL;
    pack_bool(c->p, &own);
    dig_surface_def *surface = own ? room(c, s->surface, sizeof *surface) : NULL;
    if (surface) {
        pack_real(c->p, &surface->friction);
        pack_real(c->p, &surface->friction_dynamic);
        pack_real(c->p, &surface->rolling_friction);
        pack_real(c->p, &surface->restitution);
    }
    s->surface = surface;
}

static void arg_body_def(Coder *c, CommandArg *a)
{
    dig_body_def *def = struct_of(c, a, sizeof *def);
    if (!def)
        return;
    code_rows(c, common("body"), def);
    uint32_t count = pack_count(c->p, def->shape_count > 0 ? (uint32_t)def->shape_count : 0, 60, "shapes");
    dig_shape_def *shapes = room(c, def->shapes, count * sizeof *shapes);
    for (uint32_t i = 0; shapes && i < count && pack_good(c->p); i++)
        code_shape(c, &shapes[i]);
    def->shapes = shapes;
    def->shape_count = (int)count;
}

static void arg_joint_def(Coder *c, CommandArg *a)
{
    dig_joint_def *def = struct_of(c, a, sizeof *def);
    if (!def)
        return;
    code_rows(c, common("joint.common"), def);
    def->data = code_typed(c, "joint", &def->type, def->data);
}

static void arg_region_def(Coder *c, CommandArg *a)
{
    dig_region_def *def = struct_of(c, a, sizeof *def);
    if (!def)
        return;
    code_rows(c, common("region"), def);
    code_shape(c, &def->shape);
    code_pose(c->p, &def->at);
}

/* ---- by the name in the argument before ---- */

static void code_value(Coder *c, const dig_param *row, CommandArg *a)
{
    if (!row || row->kind == DIG_TABLE || row->kind == DIG_POINTS || row->kind == DIG_INDICES)
        pack_fail(c->p, "there is no such parameter");
    void *value = pack_good(c->p) ? struct_of(c, a, param_size(row)) : NULL;
    if (value)
        save_field(c->p, c->w, row, value);
}

static void arg_body_value(Coder *c, CommandArg *a)
{
    int effect;
    const char *name = a[-1].what;
    const dig_param *row = name ? param_find(common("body"), name) : NULL;
    code_value(c, row || !name ? row : api_effect_row(c->w, name, &effect), a);
}

/* Names of parameters, and as many bytes as their rows say. */
static void arg_settings(Coder *c, CommandArg *a)
{
    const JointRec *r = world_joint(c->w, a[-1].joint);
    CommandSettings *l = struct_of(c, a, sizeof *l);
    if (!l)
        return;
    uint32_t count = pack_count(c->p, l->count > 0 ? (uint32_t)l->count : 0, 2, "parameters of a joint");
    dig_setting *set = room(c, l->set, count * sizeof *set);
    for (uint32_t i = 0; set && i < count; i++) {
        CommandArg name = {.what = set[i].param}, value = {.what = set[i].value};
        arg_text(c, &name);
        const char *text = name.what;
        size_t offset;
        bool shared = text && (strcmp(text, "breaks_at") == 0 || strcmp(text, "collides") == 0);
        code_value(c, shared ? param_find(common("joint.common"), text) : r && text ? param_find_path(r->type->params, text, &offset) : NULL, &value);
        set[i] = (dig_setting){text, value.what};
    }
    *l = (CommandSettings){set, set ? (int)count : 0};
}

static const EffectSlot *effect_named(const World *w, const char *name)
{
    for (int i = 0; name && i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, name) == 0)
            return &w->effects[i];
    return NULL;
}

/* Nothing but reals, those that rows declare and those that are the effect's own. */
static void code_kept(Coder *c, CommandArg *a, size_t size)
{
    real *x = struct_of(c, a, size);
    for (size_t i = 0; x && i < size / sizeof *x; i++) {
        pack_real(c->p, &x[i]);
        pack_check(c->p, !(fabs(x[i]) > SAVE_MUCH), "a number of an effect is too large");
    }
}

static void arg_member(Coder *c, CommandArg *a)
{
    const EffectSlot *e = effect_named(c->w, a[-2].what);
    bool kept = e && !e->owner && e->type->body_params;
    if (!e)
        pack_fail(c->p, "there is no such effect");
    else if (is_there(c, kept ? a->what : NULL))
        code_kept(c, a, e->type->body_size);
    else if (kept)
        pack_fail(c->p, "what effect '%s' keeps of a body is missing", e->name);
}

static void arg_options(Coder *c, CommandArg *a)
{
    const EffectSlot *e = effect_named(c->w, a[-1].what);
    if (!e || !e->type->world_params)
        pack_fail(c->p, "there is no such effect, or it has no options");
    else
        code_kept(c, a, e->type->world_size);
}

/* ---- wires and messages ---- */

static void arg_wire_def(Coder *c, CommandArg *a)
{
    dig_wire_def *def = struct_of(c, a, sizeof *def);
    if (!def)
        return;
    pack_u32(c->p, &def->layer);
    save_body_handle(c->p, c->w, &def->a);
    save_body_handle(c->p, c->w, &def->b);
    pack_bool(c->p, &def->bound);
    pack_real(c->p, &def->ratio);
}

static void arg_post(Coder *c, CommandArg *a)
{
    dig_post *m = struct_of(c, a, sizeof *m);
    int32_t link, hops;
    if (!m)
        return;
    pack_enum(c->p, &m->route, DIG_ROUTES, "route of a message");
    pack_enum(c->p, &m->transform, DIG_TRANSFORMS, "transform of a message");
    pack_text(c->p, m->kind, sizeof m->kind);
    code_reals(c->p, m->value, 4);
    save_body_handle(c->p, c->w, &m->from);
    save_body_handle(c->p, c->w, &m->to);
    code_dig(c->p, &m->dig);
    save_region_handle(c->p, c->w, &m->region);
    pack_u32(c->p, &m->layer);
    link = m->link;
    hops = m->hops;
    pack_i32(c->p, &link);
    pack_i32(c->p, &hops);
    m->link = link;
    m->hops = hops;
    pack_real(c->p, &m->factor);
    pack_real(c->p, &m->after);
}

static void arg_list(Coder *c, CommandArg *a)
{
    CommandList *l = struct_of(c, a, sizeof *l);
    if (!l)
        return;
    uint32_t count = pack_count(c->p, l->count > 0 ? (uint32_t)l->count : 0, 16, "receivers");
    dig_body *to = room(c, l->to, count * sizeof *to);
    real *value = room(c, l->value, count * sizeof *value);
    for (uint32_t i = 0; to && value && i < count; i++) {
        save_body_handle(c->p, c->w, &to[i]);
        pack_real(c->p, &value[i]);
    }
    *l = (CommandList){to, value, (int)count};
}

/* ---- effects of the caller's, and files ---- */

static void code_effect(Coder *c, dig_effect_def *def)
{
    bool energy = def->energy != NULL;
    bool explained = def->why != NULL;
    def->name = code_text(c, def->name);
    def->law = code_text(c, def->law);
    pack_enum(c->p, &def->stage, DIG_STAGES, "stage of an effect");
    pack_bool(c->p, &def->all);
    pack_bool(c->p, &energy);
    pack_bool(c->p, &explained);
    if (explained)
        def->why = code_text(c, def->why);
    if (c->p->reading)
        command_play_effect(c->w, def, energy);
}

static void arg_effect(Coder *c, CommandArg *a)
{
    dig_effect_def *def = struct_of(c, a, sizeof *def);
    if (def)
        code_effect(c, def);
}

static void arg_effect_there(Coder *c, CommandArg *a)
{
    CommandEffect *e = struct_of(c, a, sizeof *e);
    if (!e)
        return;
    code_effect(c, &e->def);
    pack_bool(c->p, &e->on);
    pack_bool(c->p, &e->forced);
    uint32_t count = pack_count(c->p, (uint32_t)e->count, 8, "bodies of an effect");
    dig_body *members = room(c, e->members, count * sizeof *members);
    for (uint32_t i = 0; members && i < count; i++)
        save_body_handle(c->p, c->w, &members[i]);
    e->members = members;
    e->count = members ? (int)count : 0;
}

static void arg_bytes(Coder *c, CommandArg *a)
{
    CommandBytes *b = struct_of(c, a, sizeof *b);
    if (!b)
        return;
    uint32_t size = pack_count(c->p, (uint32_t)b->size, 1, "bytes of a world");
    void *data = room(c, b->data, size);
    if (data)
        pack_bytes(c->p, data, size);
    *b = (CommandBytes){data, data ? size : 0};
}

/* ---- letters ---- */

typedef void ArgCoder(Coder *c, CommandArg *a);

static ArgCoder *const coders[128] = {
    ['b'] = arg_body, ['j'] = arg_joint, ['r'] = arg_region, ['w'] = arg_wire, ['g'] = arg_dig,
    ['v'] = arg_vec3, ['n'] = arg_number, ['u'] = arg_whole, ['y'] = arg_yes, ['s'] = arg_text,
    ['S'] = arg_text_or_none, ['V'] = arg_vec3_or_none, ['Q'] = arg_quat_or_none,
    ['B'] = arg_body_def, ['J'] = arg_joint_def, ['R'] = arg_region_def, ['O'] = arg_room, ['M'] = arg_material, ['P'] = arg_pair,
    ['W'] = arg_wire_def, ['T'] = arg_post, ['L'] = arg_list, ['E'] = arg_effect, ['X'] = arg_effect_there, ['C'] = arg_bytes,
    ['p'] = arg_body_value, ['K'] = arg_settings, ['m'] = arg_member, ['o'] = arg_options,
};

void command_arguments(Coder *c, const char *letters, CommandArg *a)
{
    bool results = false;
    for (const char *l = letters; *l; l++) {
        if (*l == '>') {
            results = true;
            continue;
        }
        if (!results)
            coders[(unsigned char)*l](c, a);
        else if (c->p->reading)
            a->place = room(c, NULL, sizeof *a);
        a++;
    }
}

/* Handles are plain numbers at the start of the union. */
void command_results(Coder *c, const char *letters, CommandArg *a)
{
    const char *results = strchr(letters, '>');
    for (a += results ? results - letters : 0; results && *++results && pack_good(c->p); a++) {
        size_t size = *results == 'w' ? sizeof a->wire : sizeof a->body;
        CommandArg is = {.whole = 0}, was;
        memcpy(&is, a->place, size);
        was = is;
        coders[(unsigned char)*results](c, &was);
        if (memcmp(&was, &is, size) != 0)
            pack_fail(c->p, "it returned another handle (slot %u) than when it was logged (slot %u)", is.body.slot, was.body.slot);
    }
}
