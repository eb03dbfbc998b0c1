/* lua/bind_reader.c - a replay, read for `digbox render`: its frames' views, notes and energies. What becomes of them is decided in
 * lua/digbox/render.lua. */
#include "bind.h"

#include "command.h"
#include "replay/replay.h"
#include "state.h"

#define READER "digbox.reader"

typedef struct ReaderRef { Replay *r; } ReaderRef;

static Replay *check_reader(lua_State *L)
{
    ReaderRef *ref = luaL_checkudata(L, 1, READER);
    return ref->r;
}

/* core.reader(path) -> reader, or nil and a sentence */
static int reader_open(lua_State *L)
{
    char why[1400] = "";
    const char *path = luaL_checkstring(L, 1);
    ReaderRef *ref = lua_newuserdatauv(L, sizeof *ref, 0);
    ref->r = NULL;
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
    ref->r = NULL;
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

/* core.reader_note(reader, name, frame) -> JSON or nil, frame since when */
static int reader_note(lua_State *L)
{
    int since = 0;
    const char *text = replay_note(check_reader(L), luaL_checkstring(L, 2), (int)luaL_checkinteger(L, 3), &since);
    if (!text)
        return 0;
    lua_pushstring(L, text);
    lua_pushinteger(L, since);
    return 2;
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
        {"reader_checksum", reader_checksum}, {"stopped", reader_stopped}, {NULL, NULL},
    };
    luaL_newmetatable(L, READER);
    lua_pushcfunction(L, reader_gc);
    lua_setfield(L, -2, "__gc");
    lua_pop(L, 1);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, reader, 0);
    lua_pop(L, 1);
}
