/* lua/bind_replay.c - `digbox run --replay FILE`: a recorder for a world. When it is called is decided in lua/digbox/replay.lua. */
#include "bind.h"

#include <stdio.h>

#include "replay/replay.h"

#define RECORDER "digbox.recorder"

typedef struct RecorderRef { Recorder *r; WorldRef *world; } RecorderRef;      /* user value 1: the world's userdata */

static Recorder *check_recorder(lua_State *L)
{
    RecorderRef *ref = luaL_checkudata(L, 1, RECORDER);
    if (!ref->r)
        bind_error(L, "the replay is closed");
    return ref->r;
}

static int done(lua_State *L, dig_status s, const Recorder *r)
{
    return s == DIG_OK ? 0 : bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FILE, "%s", recorder_error(r));
}

/* core.replay_open(path, world, origin) -> recorder */
static int replay_begin(lua_State *L)
{
    char why[1400] = "";
    const char *path = luaL_checkstring(L, 1), *origin = luaL_checkstring(L, 3);
    WorldRef *world = bind_check_world(L, 2);
    RecorderRef *ref = lua_newuserdatauv(L, sizeof *ref, 1);
    *ref = (RecorderRef){NULL, world};
    luaL_setmetatable(L, RECORDER);
    lua_pushvalue(L, 2);
    lua_setiuservalue(L, -2, 1);
    dig_status s = recorder_open(path, world->w, origin, &ref->r, why, sizeof why);
    if (s == DIG_OK && recorder_listen(ref->r) != DIG_OK)
        return bind_fail_text(L, DIG_E_FILE, "%s", recorder_error(ref->r));
    return s == DIG_OK ? 1 : bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FILE, "%s", why);
}

/* core.replay_before_step(recorder) */
static int replay_before_step(lua_State *L)
{
    Recorder *r = check_recorder(L);
    return done(L, recorder_before_step(r), r);
}

/* core.replay_step(recorder) */
static int replay_step(lua_State *L)
{
    Recorder *r = check_recorder(L);
    return done(L, recorder_step(r), r);
}

static bool vector_field(lua_State *L, int table, const char *name, vec3 *out)
{
    bool there = lua_getfield(L, table, name) != LUA_TNIL;
    if (there)
        *out = bind_vec3(L, -1, "m", "camera", name);
    lua_pop(L, 1);
    return there;
}

static ReplayCamera read_camera(lua_State *L, int table)
{
    ReplayCamera c = {.fov = 0};
    lua_getfield(L, table, "name");
    snprintf(c.name, sizeof c.name, "%s", luaL_optstring(L, -1, ""));
    lua_getfield(L, table, "fov");
    c.fov = luaL_checknumber(L, -1);
    lua_pop(L, 2);
    c.has_at = vector_field(L, table, "at", &c.at);
    c.has_look_at = vector_field(L, table, "look_at", &c.look_at);
    c.has_up = vector_field(L, table, "up", &c.up);
    return c;
}

/* core.replay_cameras(recorder, list): of {name=, at=, look_at=, up=, fov=}, where they stand from now on */
static int replay_put_cameras(lua_State *L)
{
    Recorder *r = check_recorder(L);
    int count = (int)luaL_len(L, 2);
    ReplayCamera *list = lua_newuserdatauv(L, ((size_t)count + 1) * sizeof *list, 0);
    for (int i = 0; i < count; i++) {
        lua_rawgeti(L, 2, i + 1);
        list[i] = read_camera(L, lua_gettop(L));
        lua_pop(L, 1);
    }
    return done(L, recorder_cameras(r, list, count), r);
}

/* core.replay_note(recorder, name, text) */
static int replay_add_note(lua_State *L)
{
    Recorder *r = check_recorder(L);
    return done(L, recorder_note(r, luaL_checkstring(L, 2), luaL_checkstring(L, 3)), r);
}

/* core.replay_close(recorder) */
static int replay_end(lua_State *L)
{
    char why[1400] = "";
    RecorderRef *ref = luaL_checkudata(L, 1, RECORDER);
    Recorder *r = ref->r;
    ref->r = NULL;
    dig_status s = recorder_close(r, why, sizeof why);
    return s == DIG_OK ? 0 : bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FILE, "%s", why);
}

static int recorder_gc(lua_State *L)
{
    RecorderRef *ref = luaL_checkudata(L, 1, RECORDER);
    if (ref->r && !ref->world->w)
        recorder_lose_world(ref->r);
    recorder_close(ref->r, NULL, 0);
    ref->r = NULL;
    return 0;
}

void bind_replay_open(lua_State *L, int core)
{
    static const luaL_Reg functions[] = {
        {"replay_open", replay_begin}, {"replay_before_step", replay_before_step}, {"replay_step", replay_step},
        {"replay_cameras", replay_put_cameras}, {"replay_note", replay_add_note}, {"replay_close", replay_end}, {NULL, NULL},
    };
    bind_held_type(L, RECORDER, recorder_gc);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
