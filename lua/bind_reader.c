/* lua/bind_reader.c - a replay, read for `digbox render`: its frames' views and notes. What becomes of them is decided in
 * lua/digbox/render.lua. */
#include "bind.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "render/render.h"
#include "replay/replay.h"
#include "state.h"

#define READER "digbox.reader"

typedef struct ReaderRef { Replay *r; } ReaderRef;

Replay *bind_check_reader(lua_State *L, int index)
{
    ReaderRef *ref = luaL_checkudata(L, index, READER);
    return ref->r;
}

static Replay *check_reader(lua_State *L) { return bind_check_reader(L, 1); }

/* core.reader(path) -> reader, or nil and a sentence */
static int reader_open(lua_State *L)
{
    char why[1400] = "";
    const char *path = luaL_checkstring(L, 1);
    ReaderRef *ref = lua_newuserdatauv(L, sizeof *ref, 0);
    *ref = (ReaderRef){NULL};
    luaL_setmetatable(L, READER);
    if (replay_open(path, &ref->r, why, sizeof why) == DIG_OK)
        return 1;
    lua_pushnil(L);
    lua_pushstring(L, why);
    return 2;
}

static int reader_gc(lua_State *L)
{
    ReaderRef *ref = luaL_checkudata(L, 1, READER);
    replay_close(ref->r);
    *ref = (ReaderRef){NULL};
    return 0;
}

static void set_number(lua_State *L, const char *name, real value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

/* core.reader_info(reader) -> {frames, first_step, step, seed, cut, origin} */
static int reader_info(lua_State *L)
{
    const ReplayInfo *info = replay_info(check_reader(L));
    lua_newtable(L);
    lua_pushinteger(L, info->frames);
    lua_setfield(L, -2, "frames");
    lua_pushinteger(L, (lua_Integer)info->first_step);
    lua_setfield(L, -2, "first_step");
    lua_pushinteger(L, (lua_Integer)info->seed);
    lua_setfield(L, -2, "seed");
    lua_pushboolean(L, info->cut);
    lua_setfield(L, -2, "cut");
    set_number(L, "step", info->step);
    bind_set_text(L, "origin", info->origin);
    return 1;
}

/* core.reader_note(reader, name, frame) -> value of the note, or nil where there is none */
static int reader_note(lua_State *L)
{
    const char *name = luaL_checkstring(L, 2), *text = replay_note(check_reader(L), name, (int)luaL_checkinteger(L, 3), NULL);
    if (!text)
        return 0;
    return bind_push_json(L, text) ? 1 : bind_error(L, "the replay's note '%s' is damaged", name);
}

static void set_vector(lua_State *L, const char *name, bool there, vec3 v)
{
    if (!there)
        return;
    bind_push_vec3(L, v);
    lua_setfield(L, -2, name);
}

/* core.reader_cameras(reader, frame, arrived) -> {{name=, at=, look_at=, up=, fov=}, ...}, as the script left them or its step led to */
static int reader_cameras(lua_State *L)
{
    Replay *r = check_reader(L);
    const ReplayCamera *list;
    int count;
    dig_status s = replay_cameras(r, (int)luaL_checkinteger(L, 2), lua_toboolean(L, 3), &list, &count);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    lua_createtable(L, count, 0);
    for (int i = 0; i < count; i++) {
        lua_newtable(L);
        bind_set_text(L, "name", list[i].name);
        set_vector(L, "at", list[i].has_at, list[i].at);
        set_vector(L, "look_at", list[i].has_look_at, list[i].look_at);
        set_vector(L, "up", list[i].has_up, list[i].up);
        set_number(L, "fov", list[i].fov);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* core.reader_view(reader, time) -> view */
static int reader_view(lua_State *L)
{
    Replay *r = check_reader(L);
    View *v = NULL;
    dig_status s = replay_view(r, luaL_checknumber(L, 2), &v);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    v->seed = replay_info(r)->seed;
    return bind_push_view(L, v);
}

/* core.reader_checksum(reader, frame) -> 16 hexadecimal digits */
static int reader_checksum(lua_State *L)
{
    Replay *r = check_reader(L);
    const ReplayFrame *f;
    char text[24];
    dig_status s = replay_frame(r, (int)luaL_checkinteger(L, 2), &f);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    snprintf(text, sizeof text, "%016llx", (unsigned long long)f->checksum);
    lua_pushstring(L, text);
    return 1;
}

/* core.stopped() -> whether SIGINT or SIGTERM came */
static int reader_stopped(lua_State *L)
{
    lua_pushboolean(L, app_signal() != 0);
    return 1;
}

void bind_reader_open(lua_State *L, int core)
{
    static const luaL_Reg reader[] = {
        {"reader", reader_open}, {"reader_info", reader_info}, {"reader_note", reader_note}, {"reader_view", reader_view},
        {"reader_cameras", reader_cameras},
        {"reader_checksum", reader_checksum}, {"stopped", reader_stopped}, {NULL, NULL},
    };
    bind_held_type(L, READER, reader_gc);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, reader, 0);
    lua_pop(L, 1);
}
