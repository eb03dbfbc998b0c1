/* lua/bind_body.c - bodies: state as properties, parameters that can be set, acts and questions as methods. */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static dig_body_state state_of(lua_State *L, const BodyRef *b)
{
    dig_body_state s;
    dig_status status = dig_body_get(b->world->w, b->id, &s);
    if (status != DIG_OK)
        bind_fail(L, b->world->w, status);
    return s;
}

static dig_body_state state(lua_State *L)
{
    return state_of(L, bind_check_body(L, 1));
}

static int done(lua_State *L, const BodyRef *b, dig_status s)
{
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    lua_settop(L, 1);
    return 1;
}

/* ---- state ----------------------------------------------------------------------- */

static int get_position(lua_State *L) { bind_push_vec3(L, state(L).position); return 1; }
static int get_rotation(lua_State *L) { bind_push_quat(L, state(L).rotation); return 1; }
static int get_centre(lua_State *L) { bind_push_vec3(L, state(L).centre); return 1; }
static int get_velocity(lua_State *L) { bind_push_vec3(L, state(L).velocity); return 1; }
static int get_spin(lua_State *L) { bind_push_vec3(L, state(L).spin); return 1; }
static int get_mass(lua_State *L) { lua_pushnumber(L, state(L).mass); return 1; }
static int get_force(lua_State *L) { bind_push_vec3(L, state(L).force); return 1; }
static int get_torque(lua_State *L) { bind_push_vec3(L, state(L).torque); return 1; }
static int get_energy(lua_State *L) { lua_pushnumber(L, state(L).energy); return 1; }
static int get_work(lua_State *L) { lua_pushnumber(L, state(L).work_received); return 1; }
static int get_awake(lua_State *L) { lua_pushboolean(L, state(L).awake); return 1; }

static int get_speed(lua_State *L)
{
    vec3 v = state(L).velocity;
    lua_pushnumber(L, sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
    return 1;
}

static int get_asleep(lua_State *L)
{
    dig_body_state s = state(L);
    lua_pushboolean(L, s.kind == DIG_DYNAMIC && !s.awake);
    return 1;
}

static int get_inertia(lua_State *L)
{
    dig_body_state s = state(L);
    bind_push_matrix(L, s.inertia, 3);
    return 1;
}

static int get_bounds(lua_State *L)
{
    dig_body_state s = state(L);
    lua_createtable(L, 0, 2);
    bind_push_vec3(L, s.low);
    lua_setfield(L, -2, "low");
    bind_push_vec3(L, s.high);
    lua_setfield(L, -2, "high");
    return 1;
}

static int get_mode(lua_State *L)
{
    static const char *const names[] = {"moving", "resting", "fixed"};
    lua_pushstring(L, names[state(L).mode]);
    return 1;
}

static int get_kind(lua_State *L)
{
    static const char *const names[] = {"dynamic", "kinematic", "static"};
    lua_pushstring(L, names[state(L).kind]);
    return 1;
}

static int get_dig(lua_State *L)
{
    dig_dig d = state(L).dig;
    bind_push_world_of(L, 1);
    bind_push_dig(L, lua_gettop(L), d);
    return 1;
}

static int get_world(lua_State *L)
{
    bind_check_body(L, 1);
    bind_push_world_of(L, 1);
    return 1;
}

/* Also of a body that was removed: an event may speak of it. */
static int get_name(lua_State *L)
{
    BodyRef *b = luaL_checkudata(L, 1, BIND_BODY);
    if (b->world->w && dig_body_alive(b->world->w, b->id))
        lua_pushstring(L, state_of(L, b).name);
    else
        lua_getiuservalue(L, 1, REF_NAME);
    return 1;
}

static int get_valid(lua_State *L)
{
    BodyRef *b = luaL_checkudata(L, 1, BIND_BODY);
    lua_pushboolean(L, b->world->w && dig_body_alive(b->world->w, b->id));
    return 1;
}

static void push_data_table(lua_State *L, const BodyRef *b)
{
    bind_push_world_of(L, 1);
    bind_push_state(L, lua_gettop(L));
    lua_getfield(L, -1, "data");
    lua_pushinteger(L, (lua_Integer)(((uint64_t)b->id.slot << 32) | b->id.gen));
}

/* body.data: any Lua value the script wants to keep with the body; the functions of effects may look at it, too */
static int get_data(lua_State *L)
{
    const BodyRef *b = luaL_checkudata(L, 1, BIND_BODY);
    push_data_table(L, b->world->shut ? b : bind_check_body(L, 1));
    lua_rawget(L, -2);
    return 1;
}

/* ---- debug: the record of the founding document ------------------------------------ */

static void set_vec3(lua_State *L, const char *name, vec3 v)
{
    bind_push_vec3(L, v);
    lua_setfield(L, -2, name);
}

static void set_quat(lua_State *L, const char *name, quat q)
{
    bind_push_quat(L, q);
    lua_setfield(L, -2, name);
}

static void set_matrix(lua_State *L, const char *name, const real *m, int size)
{
    bind_push_matrix(L, m, size);
    lua_setfield(L, -2, name);
}

/* Of the last message that it received, if it received one. */
static const char *const sometimes[] = {"origin", "me", "you", "direction", NULL};

/* The fields of its packet: me sent it, you got it, direction is from one to the other. */
static void set_packet(lua_State *L, const BodyRef *b, int world, const dig_body_debug *d)
{
    dig_body_debug from;
    if (dig_body_inspect(b->world->w, d->origin, &from) != DIG_OK)
        return;
    const vec3 me = from.curr_pos, you = d->curr_pos;
    bind_push_body(L, world, d->origin);
    lua_setfield(L, -2, "me");
    bind_push_body(L, world, b->id);
    lua_setfield(L, -2, "you");
    set_vec3(L, "direction", (vec3){you.x - me.x, you.y - me.y, you.z - me.z});
}

static int get_debug(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    dig_body_debug d;
    dig_status s = dig_body_inspect(b->world->w, b->id, &d);
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    bind_push_world_of(L, 1);
    int world = lua_gettop(L);
    lua_newtable(L);
    bind_set_int(L, "m_id", (lua_Integer)d.m_id);
    bind_set_int(L, "db_id", d.db_id);
    bind_set_text(L, "mess_type", d.mess_type);
    bind_set_int(L, "dig_id", d.dig_id);
    bind_set_real(L, "mess_time", d.mess_time);
    bind_set_bool(L, "floor", d.floor);
    bind_set_bool(L, "collided", d.collided);
    bind_set_bool(L, "euler", d.euler);
    set_vec3(L, "curr_pos", d.curr_pos);
    set_vec3(L, "prev_pos", d.prev_pos);
    set_vec3(L, "next_pos", d.next_pos);
    set_quat(L, "curr_rot", d.curr_rot);
    set_quat(L, "prev_rot", d.prev_rot);
    set_quat(L, "next_rot", d.next_rot);
    set_matrix(L, "itensor", d.itensor, 3);
    set_matrix(L, "iti", d.iti, 3);
    set_matrix(L, "itiws", d.itiws, 3);
    bind_set_real(L, "mo_inertia", d.mo_inertia);
    set_vec3(L, "res_force", d.res_force);
    set_vec3(L, "torque", d.torque);
    set_vec3(L, "c_mass", d.c_mass);
    set_vec3(L, "ang_mom", d.ang_mom);
    set_vec3(L, "velocity", d.velocity);
    set_vec3(L, "omega", d.omega);
    bind_set_real(L, "mass", d.mass);
    bind_set_real(L, "rest", d.rest);
    bind_push_body(L, world, d.origin);
    lua_setfield(L, -2, "origin");
    bind_push_body(L, world, b->id);
    lua_setfield(L, -2, "object");
    bind_set_text(L, "sp", d.material);
    set_matrix(L, "matrix", d.matrix, 4);
    bind_set_text(L, "object_type", d.object_type);
    set_packet(L, b, world, &d);
    bind_record(L, "body.debug", sometimes, true);
    return 1;
}

/* body.integrating: "euler" while it has no history, else "verlet"; see the parameter integrator */
static int get_integrating(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    dig_body_debug d;
    dig_status s = dig_body_inspect(b->world->w, b->id, &d);
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    lua_pushstring(L, d.euler ? "euler" : "verlet");
    return 1;
}

/* ---- parameters ---------------------------------------------------------------------- */

static const dig_param *find_row(const char *key)
{
    dig_schema of;
    for (const dig_param *row = dig_schema_at("body", 0)->rows; row->name; row++)
        if (strcmp(row->name, key) == 0)
            return row;
    return bind_effect_row(key, &of);
}

/* All names, into the table on the top of the stack. */
static void name_rows(lua_State *L, bool (*but)(const char *))
{
    const dig_param *sets[BIND_SETS];
    bind_body_sets(NULL, sets);
    for (int i = 0; sets[i]; i++)
        for (const dig_param *row = sets[i]; row->name; row++)
            if (!but || !but(row->name))
                bind_set_bool(L, row->name, true);
}

typedef union Field { real r; int64_t i; bool b; vec3 v; quat q; dig_text t; real range[2]; dig_body body; dig_joint joint; } Field;

/* body.friction and the other rows of the schema */
static int read_parameter(lua_State *L)
{
    Field field;
    const dig_param *row = lua_type(L, 2) == LUA_TSTRING ? find_row(bind_string(L, 2, NULL)) : NULL;
    if (!row) {
        if (luaL_testudata(L, 1, BIND_BODY) && get_valid(L) == 1 && lua_toboolean(L, -1)) {
            bind_push_body_name(L, lua_touserdata(L, 1));
            const char *who = lua_tostring(L, -1);
            lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
            lua_getfield(L, -1, "types");
            lua_getfield(L, -1, BIND_BODY);
            lua_getfield(L, -1, "methods");
            lua_getfield(L, -2, "getters");
            lua_newtable(L);
            name_rows(L, NULL);
            int last = lua_gettop(L);
            return bind_unknown(L, who, "has no field or method", bind_text(L, 2), last - 2, last);
        }
        return 0;
    }
    BodyRef *b = bind_check_body(L, 1);
    dig_status s = dig_body_param(b->world->w, b->id, row->name, &field);
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    if (row->kind == DIG_REAL && isnan(field.r)) {
        lua_pushnil(L);         /* nothing was given, and there is no default */
        return 1;
    }
    bind_push_world_of(L, 1);
    bind_push_field(L, lua_gettop(L), row, &field);
    return 1;
}

static const char *const state_names[] = {
    "position", "at", "rotation", "velocity", "speed", "spin", "centre", "inertia", "awake", "asleep", "valid", "dig", "energy",
    "force", "torque", "bounds", "mode", "integrating", "debug", "work_received", "kind", "world",
};
enum { STATE_NAMES = sizeof state_names / sizeof *state_names };

static bool is_state(const char *key)
{
    for (int i = 0; i < STATE_NAMES; i++)
        if (strcmp(state_names[i], key) == 0)
            return true;
    return false;
}

/* What changes a body's state in the place of an assignment; "" where nothing does. */
static const char *way_to_change(lua_State *L, const char *key)
{
    static const struct { const char *names, *way; } ways[] = {
        {" position at rotation velocity speed spin centre ", ": use :teleport"}, {" force ", ": use :push or :hit"}, {" torque ", ": use :twist"},
        {" awake asleep ", ": use :wake"},
    };
    const char *way = "", *key_between = lua_pushfstring(L, " %s ", key);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++)
        if (strstr(ways[i].names, key_between))
            way = ways[i].way;
    return way;
}

/* A slip of the pen in the name of a state is told apart from one in a parameter's. */
static int refuse_unknown(lua_State *L, const char *key)
{
    lua_newtable(L);
    bind_set_bool(L, "data", true);
    name_rows(L, is_state);
    int count, at = lua_gettop(L);
    const char **names = bind_names(L, at, at, &count), *near = strlen(key) > 1 ? dig_suggest(key, state_names, STATE_NAMES) : NULL;
    if (near && !bind_mean(key, names, count) && !bind_mean_note(key, names, count) && !dig_suggest(key, names, count))
        return bind_error(L, "body has no parameter '%.60s' (did you mean '%s'? it is state and cannot be assigned%s)", key, near, way_to_change(L, near));
    return bind_unknown(L, "body", "has no parameter", key, at, at);
}

/* body.friction = 0.3; body.position = p is refused */
static int body_newindex(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    const char *key = bind_name(L, 2, NULL);
    if (strcmp(key, "data") == 0) {
        push_data_table(L, b);
        lua_pushvalue(L, 3);
        lua_rawset(L, -3);
        return 0;
    }
    if (is_state(key))
        return bind_error(L, "body.%s is state and cannot be assigned%s", key, way_to_change(L, key));
    const dig_param *row = find_row(key);
    if (!row)
        return refuse_unknown(L, key);
    Field field;
    lua_settop(L, 3);
    bind_push_body_name(L, b);
    Fill fill = {L, 3, 3, "body", lua_tostring(L, -1), b->world};
    lua_pushvalue(L, 3);
    bind_fill_field(&fill, row, &field);
    dig_status s = dig_body_set(b->world->w, b->id, row->name, &field);
    if (s != DIG_OK)
        return bind_fail(L, b->world->w, s);
    if (strcmp(key, "name") == 0) {
        lua_pushvalue(L, 3);
        lua_setiuservalue(L, 1, REF_NAME);
    }
    return 0;
}

/* ---- acts ------------------------------------------------------------------------------ */

/* A time that is not given is 0: one frame step. */
static real span(lua_State *L, const char *what, const char *field)
{
    real s = 0;
    if (bind_get_real(L, 2, what, field, "s", &s) && s < 0)
        bind_error(L, "%s.%s = %g s, must be >= 0", what, field, s);
    return s;
}

static void note_push(lua_State *L, const BodyRef *b)
{
    bind_push_world_of(L, 1);
    bind_note(L, lua_gettop(L), "pushes", b->id.slot, b->id.gen);
    lua_pop(L, 1);
}

/* body:push{force=, along=, at=, lasts=} -> body
 * force  {x,y,z} or number  N   in world axes, or along `along`
 * at     {x,y,z}            m   world point; default: the centre of mass
 * lasts                     s   default: the next frame step only
 */
static int body_push(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    vec3 at = {0, 0, 0};
    bind_arguments(L, 2, "body:push");
    vec3 force = bind_directed(L, "body:push", "force", "N");
    bool has_at = bind_get_vec3(L, 2, "body:push", "at", "m", &at);
    real lasts = span(L, "body:push", "lasts");
    note_push(L, b);
    return done(L, b, dig_body_push(b->world->w, b->id, force, at, has_at, lasts));
}

/* body:twist{torque=, along=, lasts=} -> body      N m, s */
static int body_twist(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    bind_arguments(L, 2, "body:twist");
    vec3 torque = bind_directed(L, "body:twist", "torque", "N*m");
    real lasts = span(L, "body:twist", "lasts");
    note_push(L, b);
    return done(L, b, dig_body_twist(b->world->w, b->id, torque, lasts));
}

/* body:hit{impulse=, along=, at=} -> body          N s, at once */
static int body_hit(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    vec3 at = {0, 0, 0};
    bind_arguments(L, 2, "body:hit");
    vec3 impulse = bind_directed(L, "body:hit", "impulse", "N*s");
    bool has_at = bind_get_vec3(L, 2, "body:hit", "at", "m", &at);
    return done(L, b, dig_body_hit(b->world->w, b->id, impulse, at, has_at));
}

/* body:teleport{at=, rotation=, velocity=, spin=} -> body */
static int body_teleport(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    vec3 at, velocity, spin;
    quat rotation;
    bind_arguments(L, 2, "body:teleport");
    bool has_at = bind_get_vec3(L, 2, "body:teleport", "at", "m", &at);
    bool has_rotation = bind_get_quat(L, 2, "body:teleport", "rotation", &rotation);
    bool has_velocity = bind_get_vec3(L, 2, "body:teleport", "velocity", "m/s", &velocity);
    bool has_spin = bind_get_vec3(L, 2, "body:teleport", "spin", "rad/s", &spin);
    return done(L, b, dig_body_teleport(b->world->w, b->id, has_at ? &at : NULL, has_rotation ? &rotation : NULL,
                                        has_velocity ? &velocity : NULL, has_spin ? &spin : NULL));
}

/* body:move_to{at=, rotation=, over=} -> body      kinematic bodies only */
static int body_move_to(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    vec3 at = state(L).position;
    quat rotation;
    bind_arguments(L, 2, "body:move_to");
    bind_get_vec3(L, 2, "body:move_to", "at", "m", &at);
    bool has_rotation = bind_get_quat(L, 2, "body:move_to", "rotation", &rotation);
    real over = span(L, "body:move_to", "over");
    return done(L, b, dig_body_move_to(b->world->w, b->id, at, has_rotation ? &rotation : NULL, over));
}

/* body:drive{velocity=, spin=} -> body             kinematic bodies only: keeps moving so */
static int body_drive(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    vec3 velocity = {0, 0, 0}, spin = {0, 0, 0};
    bind_arguments(L, 2, "body:drive");
    bind_get_vec3(L, 2, "body:drive", "velocity", "m/s", &velocity);
    bind_get_vec3(L, 2, "body:drive", "spin", "rad/s", &spin);
    return done(L, b, dig_body_set_velocity(b->world->w, b->id, velocity, spin));
}

/* body:wake() -> body */
static int body_wake(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    return done(L, b, dig_body_wake(b->world->w, b->id));
}

/* The joints of a body go with it, or when it is disabled: say so on their handles. */
static void mark_joints(lua_State *L, int world, dig_body b, const char *what, const char *where)
{
    const dig_world *w = ((WorldRef *)lua_touserdata(L, world))->w;
    int n = dig_joints(w, NULL, 0);
    dig_joint *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = dig_joints(w, ids, n);
    for (int i = 0; i < n; i++) {
        dig_joint_state s;
        bool ours = dig_joint_get(w, ids[i], &s) == DIG_OK &&
                    ((s.a.slot == b.slot && s.a.gen == b.gen) || (s.b.slot == b.slot && s.b.gen == b.gen));
        if (ours) {
            const char *how = lua_pushfstring(L, "joint '%s' was removed %s%s", s.name, what, where);
            bind_mark_removed(L, world, "joints", ids[i].slot, ids[i].gen, how);
            lua_pop(L, 1);
        }
    }
    lua_pop(L, 1);
}

/* Pushes " at world.lua:12", or "" where no line of a script called. */
static const char *push_at(lua_State *L)
{
    bind_place(L);
    return lua_rawlen(L, -1) > 0 ? lua_pushfstring(L, " at %s", lua_tostring(L, -1)) : "";
}

dig_status bind_disable(lua_State *L, int world, dig_body b)
{
    int top = lua_gettop(L);
    mark_joints(L, world, b, "when its body was disabled", push_at(L));
    bind_forget(L, world, "pushes", b.slot, b.gen);
    lua_settop(L, top);
    return dig_body_disable(((WorldRef *)lua_touserdata(L, world))->w, b);
}

/* body:disable() -> body */
static int body_disable(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    bind_push_world_of(L, 1);
    return done(L, b, bind_disable(L, lua_gettop(L), b->id));
}

/* body:remove() */
static int body_remove(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    lua_settop(L, 1);
    bind_push_world_of(L, 1);
    bind_push_body_name(L, b);
    const char *where = push_at(L);
    mark_joints(L, 2, b->id, "with its body", where);
    const char *how = lua_pushfstring(L, "%s was removed%s", lua_tostring(L, 3), where);
    bind_mark_removed(L, 2, "bodies", b->id.slot, b->id.gen, how);
    bind_forget(L, 2, "bodies", b->id.slot, b->id.gen);
    bind_forget(L, 2, "pushes", b->id.slot, b->id.gen);
    push_data_table(L, b);
    lua_pushnil(L);
    lua_rawset(L, -3);
    dig_status s = dig_body_remove(b->world->w, b->id);
    return s == DIG_OK ? 0 : bind_fail(L, b->world->w, s);
}

/* ---- questions --------------------------------------------------------------------------- */

/* body:touches(other) -> true or false */
static int body_touches(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    lua_pushboolean(L, dig_body_touches(b->world->w, b->id, bind_body_of(L, 2, b->world)->id));
    return 1;
}

/* body:contains(other) -> true when the other's centre of mass lies inside this body's outline */
static int body_contains(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    lua_pushboolean(L, dig_body_contains(b->world->w, b->id, bind_body_of(L, 2, b->world)->id));
    return 1;
}

/* body:velocity_at(point) -> vector                m/s of the material point there */
static int body_velocity_at(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    bind_push_vec3(L, dig_body_point_velocity(b->world->w, b->id, bind_vec3(L, 2, "m", "body:velocity_at", NULL)));
    return 1;
}

static int body_tostring(lua_State *L)
{
    BodyRef *b = luaL_checkudata(L, 1, BIND_BODY);
    if (b->world->w && dig_body_alive(b->world->w, b->id)) {
        bind_push_body_name(L, b);
        return 1;
    }
    lua_getiuservalue(L, 1, REF_NAME);
    if (lua_isstring(L, -1) && lua_rawlen(L, -1) > 0)
        lua_pushfstring(L, "removed body '%s'", lua_tostring(L, -1));
    else
        lua_pushfstring(L, "removed body #%d", (int)b->id.slot);
    return 1;
}

static int body_eq(lua_State *L)
{
    const BodyRef *a = luaL_testudata(L, 1, BIND_BODY), *b = luaL_testudata(L, 2, BIND_BODY);
    lua_pushboolean(L, a && b && a->world == b->world && a->id.slot == b->id.slot && a->id.gen == b->id.gen);
    return 1;
}

static const luaL_Reg methods[] = {
    {"push", body_push}, {"twist", body_twist}, {"hit", body_hit}, {"teleport", body_teleport}, {"move_to", body_move_to},
    {"drive", body_drive}, {"wake", body_wake}, {"disable", body_disable}, {"remove", body_remove}, {"touches", body_touches}, {"contains", body_contains},
    {"velocity_at", body_velocity_at}, {NULL, NULL},
};
static const luaL_Reg getters[] = {
    {"position", get_position}, {"rotation", get_rotation}, {"centre", get_centre}, {"velocity", get_velocity}, {"speed", get_speed},
    {"spin", get_spin}, {"mass", get_mass}, {"inertia", get_inertia}, {"awake", get_awake}, {"asleep", get_asleep}, {"valid", get_valid},
    {"dig", get_dig}, {"energy", get_energy}, {"force", get_force}, {"torque", get_torque}, {"bounds", get_bounds}, {"mode", get_mode},
    {"kind", get_kind}, {"integrating", get_integrating}, {"debug", get_debug},
    {"name", get_name}, {"work_received", get_work}, {"world", get_world}, {"data", get_data},
    {NULL, NULL},
};
static const luaL_Reg meta[] = {{"__newindex", body_newindex}, {"__tostring", body_tostring}, {"__eq", body_eq}, {NULL, NULL}};

void bind_body_open(lua_State *L, int core)
{
    bind_type(L, core, BIND_BODY, methods, getters, read_parameter, meta);
}
