/* lua/bind_own.c - effects written in Lua: the engine asks a function of the script for forces, at every evaluation of the equations
 * of motion.
 *
 * An effect has a Lua thread of its own, on whose stack lie its functions and the tables that they are shown; the functions are
 * called there, protected, so that no error passes through the engine. An error waits there until the step has been undone. The
 * world is shut meanwhile: bind_check_world and its like refuse it.
 */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The stack of an effect's thread; a call gets the first ones as its arguments. */
enum { OWN_EFFECT = 1, OWN_STEP, OWN_ENERGY, OWN_VIEWS, OWN_LIST, OWN_WORLD, OWN_META, OWN_ARGUMENTS = OWN_META, OWN_FAILURE };
enum { OWN_SELF = OWN_ARGUMENTS + 1 };

typedef struct OwnRef {
    WorldRef  *world;
    lua_State *thread;
    const dig_effect_call *call;
    real       stored;          /* J, what the energy function said */
    bool       failed;          /* the error lies at OWN_FAILURE    */
    char       name[32], who[48];
} OwnRef;

/* ---- what the functions are shown ------------------------------------------------- */

static void set_raw(lua_State *L, int table, const char *name)
{
    lua_pushstring(L, name);
    lua_insert(L, -2);
    lua_rawset(L, table);
}

/* Pushes the table of a body: the one it had in the last call, or a new one. */
static void push_view(lua_State *L, dig_body body)
{
    if (lua_rawgeti(L, OWN_VIEWS, body.slot) == LUA_TTABLE) {
        lua_getfield(L, -1, "body");
        const BodyRef *old = luaL_testudata(L, -1, BIND_BODY);
        bool same = old && old->id.gen == body.gen;
        lua_pop(L, 1);
        if (same)
            return;
    }
    lua_pop(L, 1);
    lua_createtable(L, 0, 12);
    int view = lua_gettop(L);
    bind_push_body(L, OWN_WORLD, body);
    set_raw(L, view, "body");
    lua_pushvalue(L, OWN_META);
    lua_setmetatable(L, view);
    lua_pushvalue(L, view);
    lua_rawseti(L, OWN_VIEWS, body.slot);
}

static void show_vec3(lua_State *L, int view, const char *name, vec3 v)
{
    bind_push_vec3(L, v);
    set_raw(L, view, name);
}

/* zero: index of the vector that stands for no force */
static void show_body(lua_State *L, const dig_effect_part *p, int zero)
{
    push_view(L, p->body);
    int view = lua_gettop(L);
    show_vec3(L, view, "position", p->position);
    show_vec3(L, view, "centre", p->centre);
    show_vec3(L, view, "velocity", p->velocity);
    show_vec3(L, view, "spin", p->spin);
    bind_push_quat(L, p->rotation);
    set_raw(L, view, "rotation");
    lua_pushnumber(L, p->mass);
    set_raw(L, view, "mass");
    lua_pushvalue(L, zero);
    set_raw(L, view, "force");
    lua_pushvalue(L, zero);
    set_raw(L, view, "torque");
}

/* Fills the list and sets effect.time; leaves the vector of no force on the stack and returns its index. */
static int show_all(lua_State *L, const dig_effect_call *c)
{
    bind_push_vec3(L, (vec3){0, 0, 0});
    int zero = lua_gettop(L);
    lua_pushnumber(L, c->time);
    lua_pushliteral(L, "time");
    lua_insert(L, -2);
    lua_rawset(L, OWN_EFFECT);
    for (int i = 0; i < c->count; i++) {
        show_body(L, &c->parts[i], zero);
        lua_rawseti(L, OWN_LIST, i + 1);
    }
    for (lua_Integer i = c->count + 1; lua_rawgeti(L, OWN_LIST, i) != LUA_TNIL; i++) {     /* the length may be what the script made it */
        lua_pop(L, 1);
        lua_pushnil(L);
        lua_rawseti(L, OWN_LIST, i);
    }
    lua_pop(L, 1);
    return zero;
}

/* Is the value on top of the stack a vector with a component that is no finite number? */
static bool is_endless(lua_State *L)
{
    static const char *const names[] = {"x", "y", "z"};
    const vec3 *v = luaL_testudata(L, -1, BIND_VEC);
    bool endless = v && !(isfinite(v->x) && isfinite(v->y) && isfinite(v->z));
    for (int i = 0; i < 3 && lua_istable(L, -1); i++) {
        if (lua_rawgeti(L, -1, i + 1) == LUA_TNIL) {
            lua_pop(L, 1);
            lua_pushstring(L, names[i]);
            lua_rawget(L, -2);
        }
        endless = endless || (lua_type(L, -1) == LUA_TNUMBER && !isfinite(lua_tonumber(L, -1)));
        lua_pop(L, 1);
    }
    return endless;
}

/* What the view on top of the stack says of its force or torque. */
static vec3 take(lua_State *L, const OwnRef *o, const char *name, const char *unit, int zero)
{
    vec3 v = {0, 0, 0};
    lua_pushstring(L, name);
    lua_rawget(L, -2);
    if (is_endless(L)) {
        lua_getfield(L, -2, "body");
        bind_push_body_name(L, lua_touserdata(L, -1));
        bind_error(L, "at t = %g s %s gave %s a non-finite %s", o->call->time, o->who, lua_tostring(L, -1), name);
    }
    if (!lua_rawequal(L, -1, zero) && !lua_isnil(L, -1))
        v = bind_vec3(L, -1, unit, o->who, name);
    lua_pop(L, 1);
    return v;
}

/* view:push{...}: more force and torque, besides what the view says already */
static void add(lua_State *L, const char *who, const char *name, const char *unit, vec3 more)
{
    lua_getfield(L, 1, name);
    vec3 v = lua_isnil(L, -1) ? (vec3){0, 0, 0} : bind_vec3(L, -1, unit, who, name);
    lua_pop(L, 1);
    show_vec3(L, 1, name, (vec3){v.x + more.x, v.y + more.y, v.z + more.z});
}

static void check_act(lua_State *L, const char *what)
{
    lua_settop(L, 2);
    if (!lua_istable(L, 1))
        bind_error(L, "%s: expected a body, got %s (methods are called with ':')", what, luaL_typename(L, 1));
    bind_arguments(L, 2, what);
    lua_getfield(L, 2, "lasts");
    if (!lua_isnil(L, -1))
        bind_error(L, "%s.lasts: not here, an effect is asked again at every step", what);
    lua_settop(L, 2);
}

/* view:push{force=, along=, at=} -> view: as body:push, while the effect is asked */
static int view_push(lua_State *L)
{
    static const char what[] = "body:push";
    const char *who = lua_tostring(L, lua_upvalueindex(1));
    vec3 at;
    check_act(L, what);
    vec3 force = bind_directed(L, what, "force", "N");
    add(L, who, "force", "N", force);
    if (bind_get_vec3(L, 2, what, "at", "m", &at)) {
        lua_getfield(L, 1, "centre");
        vec3 centre = bind_vec3(L, -1, "m", who, "centre"), arm = {at.x - centre.x, at.y - centre.y, at.z - centre.z};
        add(L, who, "torque", "N*m", (vec3){arm.y * force.z - arm.z * force.y, arm.z * force.x - arm.x * force.z, arm.x * force.y - arm.y * force.x});
    }
    lua_settop(L, 1);
    return 1;
}

/* view:twist{torque=, along=} -> view */
static int view_twist(lua_State *L)
{
    static const char what[] = "body:twist";
    check_act(L, what);
    add(L, lua_tostring(L, lua_upvalueindex(1)), "torque", "N*m", bind_directed(L, what, "torque", "N*m"));
    lua_settop(L, 1);
    return 1;
}

/* view.name, view.data, view.speed, view.push; view.forse: no such field. Upvalues: who, the table of the two acts. */
static int view_index(lua_State *L)
{
    lua_settop(L, 2);
    const char *key = bind_name(L, 2, NULL);
    if (strcmp(key, "name") == 0 || strcmp(key, "data") == 0) {
        lua_getfield(L, 1, "body");
        lua_getfield(L, -1, key);
        return 1;
    }
    if (strcmp(key, "speed") == 0) {
        lua_getfield(L, 1, "velocity");
        vec3 v = bind_vec3(L, -1, "m/s", NULL, key);
        lua_pushnumber(L, sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
        return 1;
    }
    lua_settop(L, 2);
    lua_pushvalue(L, 2);
    if (lua_rawget(L, lua_upvalueindex(2)) != LUA_TNIL)
        return 1;
    lua_pushvalue(L, lua_upvalueindex(2));
    lua_replace(L, 2);
    return bind_unknown(L, lua_tostring(L, lua_upvalueindex(1)), "a body has no field", key, 1, 2);
}

/* view.forse = f */
static int view_newindex(lua_State *L)
{
    lua_settop(L, 2);
    return bind_unknown(L, lua_tostring(L, lua_upvalueindex(1)), "a body has no field", bind_text(L, 2), 1, 1);
}

/* ---- calls ---------------------------------------------------------------------------- */

static int call_step(lua_State *L)
{
    OwnRef *o = lua_touserdata(L, OWN_SELF);
    const dig_effect_call *c = o->call;
    int zero = show_all(L, c);
    lua_pushvalue(L, OWN_STEP);
    lua_pushvalue(L, OWN_EFFECT);
    lua_pushvalue(L, OWN_LIST);
    lua_pushnumber(L, c->dt);
    lua_call(L, 3, 0);
    for (int i = 0; i < c->count; i++) {
        lua_rawgeti(L, OWN_VIEWS, c->parts[i].body.slot);
        c->parts[i].force = take(L, o, "force", "N", zero);
        c->parts[i].torque = take(L, o, "torque", "N*m", zero);
        lua_pop(L, 1);
    }
    return 0;
}

static int call_energy(lua_State *L)
{
    OwnRef *o = lua_touserdata(L, OWN_SELF);
    show_all(L, o->call);
    lua_pushvalue(L, OWN_ENERGY);
    lua_pushvalue(L, OWN_EFFECT);
    lua_pushvalue(L, OWN_LIST);
    lua_call(L, 2, 1);
    o->stored = bind_real(L, -1, "J", o->who, "energy");
    return 0;
}

/* Calls f on the effect's thread. After a failure, and until it is told, nothing is called. */
static bool call(OwnRef *o, lua_CFunction f, const dig_effect_call *c)
{
    lua_State *L = o->thread;
    const char *outer = o->world->shut;
    const BindHost *host = o->world->host;
    if (o->world->failed || !lua_checkstack(L, OWN_ARGUMENTS + 4))
        return false;
    o->call = c;
    o->world->shut = o->name;
    lua_State *before = host ? host->run(L) : NULL;
    lua_pushcfunction(L, f);
    for (int i = 1; i <= OWN_ARGUMENTS; i++)
        lua_pushvalue(L, i);
    lua_pushlightuserdata(L, o);
    int status = lua_pcall(L, OWN_ARGUMENTS + 1, 0, 0);
    o->world->shut = outer;
    if (host)
        host->run(before);
    if (status == LUA_OK)
        return true;
    lua_replace(L, OWN_FAILURE);
    o->world->failed = o;
    return false;
}

static dig_status step_own(void *data, const dig_effect_call *c, char *why, size_t capacity)
{
    OwnRef *o = data;
    if (call(o, call_step, c))
        return DIG_OK;
    const char *text = o->world->failed == o && lua_type(o->thread, OWN_FAILURE) == LUA_TSTRING ? lua_tostring(o->thread, OWN_FAILURE) : "failed";
    snprintf(why, capacity, "%s", text);
    return DIG_E_ARG;
}

static real energy_own(void *data, const dig_effect_call *c)
{
    OwnRef *o = data;
    return call(o, call_energy, c) ? o->stored : 0;
}

/* Where the text of an error goes on after "world.lua:12: "; its start when it has no position. */
static const char *after_position(const char *text)
{
    for (const char *p = strchr(text, ':'); p; p = strchr(p + 1, ':')) {
        size_t digits = strspn(p + 1, "0123456789");
        if (digits > 0 && p[1 + digits] == ':' && p[2 + digits] == ' ')
            return p + 3 + digits;
    }
    return text;
}

/* Where the function begins, for errors in what it left. */
static void push_definition(lua_State *L, const OwnRef *o)
{
    lua_Debug ar;
    lua_pushvalue(o->thread, OWN_STEP);
    lua_getinfo(o->thread, ">S", &ar);
    lua_pushfstring(L, ar.source[0] == '@' ? "%s:%d: " : "", ar.source + 1, ar.linedefined);
}

/* What ends the script is no error of its own. */
static bool ends_script(lua_State *L)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "finished");
    bool ends = lua_rawequal(L, -3, -1);
    lua_pop(L, 2);
    return ends;
}

void bind_own_check(lua_State *L, WorldRef *world)
{
    OwnRef *o = world->failed;
    if (!o)
        return;
    world->failed = NULL;
    lua_pushvalue(o->thread, OWN_FAILURE);
    lua_xmove(o->thread, L, 1);
    lua_pushnil(o->thread);
    lua_replace(o->thread, OWN_FAILURE);
    if (lua_type(L, -1) != LUA_TSTRING && !ends_script(L)) {
        const char *kind = luaL_typename(L, -1);
        push_definition(L, o);
        lua_pushfstring(L, "effect '%s': error was called with a %s, must be with a text that says what is wrong", o->name, kind);
        lua_concat(L, 2);
        lua_error(L);
    }
    const char *text = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : NULL;
    if (!text || bind_exit_code(L, text) != 1)          /* a way to end the script, or a limit: as it is */
        lua_error(L);
    const char *rest = after_position(text);
    if (rest == text)
        push_definition(L, o);
    else
        lua_pushlstring(L, text, (size_t)(rest - text));
    if (strncmp(rest, "effect '", 8) == 0 || strncmp(rest, "at t = ", 7) == 0)
        lua_pushstring(L, rest);
    else
        lua_pushfstring(L, "effect '%s': %s", o->name, rest);
    lua_concat(L, 2);
    lua_error(L);
}

/* ---- adding ----------------------------------------------------------------------------- */

static dig_stage stage_named(lua_State *L, const char *name)
{
    for (int i = 0; i < DIG_STAGES; i++)
        if (strcmp(dig_stage_name((dig_stage)i), name) == 0)
            return (dig_stage)i;
    lua_newtable(L);
    for (int i = 0; i < DIG_STAGES; i++)
        bind_set_bool(L, dig_stage_name((dig_stage)i), true);
    bind_unknown(L, "world:add_effect:", "unknown stage", name, lua_gettop(L), lua_gettop(L));
    return DIG_STAGE_FORCE;
}

/* The metatable of what stands for a body. */
static void push_meta(lua_State *L, const char *who)
{
    static const luaL_Reg acts[] = {{"push", view_push}, {"twist", view_twist}, {NULL, NULL}};
    lua_createtable(L, 0, 3);
    lua_pushfstring(L, "%s:", who);
    luaL_newlibtable(L, acts);
    lua_pushstring(L, who);
    luaL_setfuncs(L, acts, 1);
    lua_pushcclosure(L, view_index, 2);
    lua_setfield(L, -2, "__index");
    lua_pushfstring(L, "%s:", who);
    lua_pushcclosure(L, view_newindex, 1);
    lua_setfield(L, -2, "__newindex");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
}

/* The thread on top of L gets what lies at 2 (effect), 5 (step) and 6 (energy), and its own tables. */
static void furnish(lua_State *L, OwnRef *o)
{
    static const int given[] = {2, 5, 6};
    luaL_checkstack(o->thread, 2 * OWN_FAILURE, "effect");
    for (size_t i = 0; i < 3; i++) {
        lua_pushvalue(L, given[i]);
        lua_xmove(L, o->thread, 1);
    }
    lua_newtable(o->thread);
    lua_newtable(o->thread);
    lua_pushvalue(L, 1);
    lua_xmove(L, o->thread, 1);
    push_meta(o->thread, o->who);
    lua_pushnil(o->thread);
}

/* core.own_add(world, effect, name, stage, step, energy or nil, all, law or nil) */
static int own_add(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    lua_settop(L, 8);
    dig_effect_def def = {.name = bind_string(L, 3, NULL), .stage = stage_named(L, bind_string(L, 4, NULL)), .all = lua_toboolean(L, 7),
                          .law = luaL_optstring(L, 8, "a function of the script"), .step = step_own, .energy = lua_isnil(L, 6) ? NULL : energy_own};
    OwnRef *o = lua_newuserdatauv(L, sizeof *o, 1);
    memset(o, 0, sizeof *o);
    o->world = ref;
    snprintf(o->name, sizeof o->name, "%s", def.name);
    snprintf(o->who, sizeof o->who, "effect '%s'", o->name);
    o->thread = lua_newthread(L);
    lua_setiuservalue(L, 9, 1);
    furnish(L, o);
    def.data = o;
    bind_place(L);
    def.why = lua_tostring(L, -1);
    bind_push_state(L, 1);
    luaL_getsubtable(L, -1, "own");             /* the world keeps it, for its snapshots, too */
    lua_pushvalue(L, 9);
    lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    dig_status s = dig_effect_add(ref->w, &def);
    if (s != DIG_OK)
        return bind_fail_text(L, s, "world:add_effect: %s", dig_error(ref->w));
    return 0;
}

/* core.own_join(world, name, body, joins) */
static int own_join(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const char *name = luaL_checkstring(L, 2);
    dig_body body = bind_body_of(L, 3, ref)->id;
    dig_status s = lua_toboolean(L, 4) ? dig_effect_join(ref->w, name, body, NULL, NULL) : dig_effect_leave(ref->w, name, body);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* core.own_drop(world, name) */
static int own_drop(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_status s = dig_effect_drop(ref->w, luaL_checkstring(L, 2));
    ref->failed = NULL;                         /* that of its energy function, which was asked a last time */
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

void bind_own_open(lua_State *L, int core)
{
    static const luaL_Reg functions[] = {{"own_add", own_add}, {"own_join", own_join}, {"own_drop", own_drop}, {NULL, NULL}};
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
