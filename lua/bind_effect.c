/* lua/bind_effect.c - effects: the fields of bodies and the options that call for them, and the list of what is on and why. */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- fields of bodies -------------------------------------------------------------- */

void bind_body_sets(const dig_param *own, const dig_param *sets[BIND_SETS])
{
    int n = 0;
    dig_schema s;
    sets[n++] = dig_schema_at("body", 0)->rows;
    if (own)
        sets[n++] = own;
    for (int i = 0; n < BIND_SETS - 1 && dig_effect_schema(i, "body", &s); i++)
        if (s.rows)
            sets[n++] = s.rows;
    sets[n] = NULL;
}

const dig_param *bind_effect_row(const char *name, dig_schema *of)
{
    for (int i = 0; dig_effect_schema(i, "body", of); i++)
        for (const dig_param *row = of->rows; row && row->name; row++)
            if (strcmp(row->name, name) == 0)
                return row;
    return NULL;
}

static bool has_field(lua_State *L, int table, const dig_param *rows)
{
    bool has = false;
    for (const dig_param *row = rows; row->name && !has; row++) {
        lua_pushstring(L, row->name);
        has = lua_rawget(L, table) != LUA_TNIL;
        lua_pop(L, 1);
    }
    return has;
}

void bind_effects_read(const Fill *f)
{
    lua_State *L = f->L;
    dig_schema s;
    lua_pushnil(L);
    int read = lua_gettop(L);
    for (int i = 0; dig_effect_schema(i, "body", &s); i++) {
        if (!s.rows || !has_field(L, f->table, s.rows))
            continue;
        if (lua_isnil(L, read)) {
            lua_newtable(L);
            lua_replace(L, read);
        }
        void *member = lua_newuserdatauv(L, s.size, 0);
        memset(member, 0, s.size);
        dig_schema_defaults(&s, member);
        bind_fill(f, s.rows, member);
        lua_rawseti(L, read, i + 1);
    }
}

void bind_effects_join(lua_State *L, int read, const WorldRef *world, dig_body body)
{
    dig_schema s;
    for (int i = 0; lua_istable(L, read) && dig_effect_schema(i, "body", &s); i++) {
        if (lua_rawgeti(L, read, i + 1) == LUA_TUSERDATA) {
            bind_place(L);
            dig_status status = dig_effect_join(world->w, s.name, body, lua_touserdata(L, -2), lua_tostring(L, -1));
            if (status != DIG_OK) {
                const char *text = lua_pushstring(L, dig_error(world->w));
                dig_body_remove(world->w, body);
                bind_fail_text(L, status, "%s", text);
            }
            lua_pop(L, 1);
        }
        lua_pop(L, 1);
    }
}

/* ---- what called for them ------------------------------------------------------------- */

static lua_Integer key_of(uint32_t slot, uint32_t gen) { return (lua_Integer)(((uint64_t)slot << 32) | gen); }

/* Pushes the table {handle = line} of that kind. */
static void push_places(lua_State *L, int world, const char *kind)
{
    bind_push_state(L, world);
    luaL_getsubtable(L, -1, "places");
    luaL_getsubtable(L, -1, kind);
    lua_replace(L, -3);
    lua_pop(L, 1);
}

void bind_note(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen)
{
    push_places(L, world, kind);
    if (lua_rawgeti(L, -1, key_of(slot, gen)) == LUA_TNIL) {
        bind_place(L);
        lua_rawseti(L, -3, key_of(slot, gen));
    }
    lua_pop(L, 2);
}

void bind_push_made(lua_State *L, int world, dig_body b)
{
    push_places(L, world, "bodies");
    lua_rawgeti(L, -1, key_of(b.slot, b.gen));
    lua_remove(L, -2);
}

/* "world.lua:12 (body 'ball')"; what came from a file has no line. */
static void explain(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen, const char *who, const dig_effect_info *info)
{
    dig_world *w = ((WorldRef *)lua_touserdata(L, world))->w;
    push_places(L, world, kind);
    if (lua_rawgeti(L, -1, key_of(slot, gen)) == LUA_TSTRING && lua_rawlen(L, -1) > 0)
        lua_pushfstring(L, "%s (%s)", lua_tostring(L, -1), who);
    else
        lua_pushstring(L, who);
    dig_effect_explain(w, info->name, lua_tostring(L, -1));
    lua_pop(L, 3);
}

static void explain_one(lua_State *L, int world, const dig_effect_info *info)
{
    const dig_world *w = ((WorldRef *)lua_touserdata(L, world))->w;
    dig_body_state b;
    dig_joint_state j;
    char who[96];
    if (info->first_region.gen != 0) {
        explain(L, world, "regions", info->first_region.slot, info->first_region.gen, "a region", info);
    } else if (info->first_joint.gen != 0 && dig_joint_get(w, info->first_joint, &j) == DIG_OK) {
        snprintf(who, sizeof who, j.name[0] ? "%s '%s'" : "a %s", j.type, j.name);
        explain(L, world, "joints", info->first_joint.slot, info->first_joint.gen, who, info);
    } else if (info->first.gen != 0 && dig_body_get(w, info->first, &b) == DIG_OK) {
        snprintf(who, sizeof who, b.name[0] ? "body '%s'" : "a body", b.name);
        explain(L, world, strcmp(info->name, "push") == 0 ? "pushes" : "bodies", info->first.slot, info->first.gen, who, info);
    }
}

void bind_explain(lua_State *L, int world)
{
    const dig_world *w = ((WorldRef *)lua_touserdata(L, world))->w;
    dig_effect_info info;
    world = lua_absindex(L, world);
    for (int i = 0; i < dig_effect_count(w); i++)
        if (dig_effect_get(w, i, &info) == DIG_OK && !info.explained)
            explain_one(L, world, &info);
}

void bind_forget(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen)
{
    world = lua_absindex(L, world);
    bind_explain(L, world);
    push_places(L, world, kind);
    lua_pushnil(L);
    lua_rawseti(L, -2, key_of(slot, gen));
    lua_pop(L, 1);
}

/* ---- the effects of a world ----------------------------------------------------------- */

static void push_options(lua_State *L, const dig_world *w, int index)
{
    dig_schema s;
    dig_effect_info info;
    if (dig_effect_get(w, index, &info) != DIG_OK || !dig_effect_schema(index, "world", &s) || !s.rows || strcmp(s.name, info.name) != 0)
        return;
    void *options = lua_newuserdatauv(L, s.size, 0);
    if (dig_effect_options(w, s.name, options)) {
        lua_newtable(L);
        for (const dig_param *row = s.rows; row->name; row++) {
            bind_push_field(L, 1, row, (const char *)options + row->offset);
            lua_setfield(L, -2, row->name);
        }
        lua_setfield(L, -3, "options");
    }
    lua_pop(L, 1);
}

/* world:effects() -> {name = {on, bodies, us, us_mean, bytes, calls, law, why, own, order, options}} */
static int world_effects(lua_State *L)
{
    dig_world *w = bind_check_world(L, 1)->w;
    dig_effect_info info;
    lua_settop(L, 1);
    bind_explain(L, 1);
    lua_newtable(L);
    for (int i = 0; i < dig_effect_count(w); i++) {
        if (dig_effect_get(w, i, &info) != DIG_OK)
            continue;
        lua_newtable(L);
        bind_set_bool(L, "on", info.on);
        bind_set_bool(L, "allowed", info.allowed);
        bind_set_int(L, "bodies", info.bodies);
        bind_set_real(L, "us", info.us);
        bind_set_real(L, "us_mean", info.us_mean);
        bind_set_bool(L, "own", info.own);
        bind_set_int(L, "order", i + 1);
        bind_set_int(L, "bytes", (lua_Integer)info.bytes);
        bind_set_int(L, "calls", (lua_Integer)info.calls);
        bind_set_text(L, "law", info.law);
        bind_set_text(L, "why", info.why);
        push_options(L, w, i);
        lua_setfield(L, -2, info.name);
    }
    return 1;
}

/* The options in the table at 3, over what they are now. */
static int set_options(lua_State *L, const WorldRef *ref, int index, const char *name)
{
    dig_schema s;
    if (!dig_effect_schema(index, "world", &s) || strcmp(s.name, name) != 0 || !s.rows)
        return bind_error(L, "world:effect('%s', {...}): it has no options, only true or false", name);
    const char *what = lua_pushfstring(L, "world:effect('%s')", name);
    const dig_param *sets[] = {s.rows, NULL};
    bind_check_keys(L, 3, what, sets, NULL);
    void *options = lua_newuserdatauv(L, s.size, 0);
    dig_effect_options(ref->w, name, options);
    Fill fill = {L, 3, 3, what, what, ref};
    bind_fill(&fill, s.rows, options);
    bind_place(L);
    dig_status status = dig_effect_option(ref->w, name, options, lua_tostring(L, -1));
    return status == DIG_OK ? 0 : bind_fail(L, ref->w, status);
}

/* world:effect(name, true | false | {options}) */
static int world_effect(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_effect_info info;
    int index = -1;
    lua_settop(L, 3);
    if (lua_type(L, 2) != LUA_TSTRING)
        return bind_error(L, "world:effect(name, on) wants the name of an effect, as in world:effect('drag', true); got %s", luaL_typename(L, 2));
    const char *name = bind_string(L, 2, NULL);
    lua_newtable(L);
    for (int i = 0; i < dig_effect_count(ref->w); i++)
        if (dig_effect_get(ref->w, i, &info) == DIG_OK) {
            index = strcmp(info.name, name) == 0 ? i : index;
            bind_set_int(L, info.name, i);
        }
    if (index < 0)
        return bind_unknown(L, "world:effect:", "unknown effect", name, lua_gettop(L), lua_gettop(L));
    if (lua_istable(L, 3))
        return set_options(L, ref, index, name);
    if (!lua_isboolean(L, 3))
        return bind_error(L, "world:effect('%s', on) wants true, false or a table of options; got %s", name, luaL_typename(L, 3));
    dig_status s = dig_effect_set(ref->w, name, lua_toboolean(L, 3));
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* body:warm{energy=} or body:warm{to=} -> body          J or K */
static int body_warm(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    real energy = NAN, to = NAN;
    bind_arguments(L, 2, "body:warm");
    bind_get_real(L, 2, "body:warm", "energy", "J", &energy);
    bind_get_real(L, 2, "body:warm", "to", "K", &to);
    dig_status s = dig_body_warm(b->world->w, b->id, energy, to);
    lua_settop(L, 1);
    return s == DIG_OK ? 1 : bind_fail(L, b->world->w, s);
}

static const luaL_Reg body_methods[] = {{"warm", body_warm}, {NULL, NULL}};
static const luaL_Reg methods[] = {{"effects", world_effects}, {"effect", world_effect}, {NULL, NULL}};

void bind_effect_open(lua_State *L, int core)
{
    bind_extend(L, core, BIND_WORLD, methods);
    bind_extend(L, core, BIND_BODY, body_methods);
}
