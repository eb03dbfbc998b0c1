/* lua/bind_past.c - what was before a moment, for the overlays trails and energy: of a running world, or of a replay. When it is fed is
 * decided in lua/digbox/film.lua and render.lua. */
#include "bind.h"

#include "replay/replay.h"
#include "view/past.h"

#define PAST "digbox.past"

typedef struct PastRef {
    Past     p;
    ViewPast shown;
    int      frame;             /* of a replay: the last that it was fed; -1: none */
} PastRef;

static PastRef *check_past(lua_State *L, int index) { return luaL_checkudata(L, index, PAST); }

static int no_room(lua_State *L) { return bind_fail_text(L, DIG_E_MEMORY, "no memory for what was before: trails and energies"); }

static int past_gc(lua_State *L)
{
    past_close(&check_past(L, 1)->p);
    return 0;
}

/* core.past(first, step) -> past, which begins with that step of a world whose frames take so long */
static int past_new(lua_State *L)
{
    lua_Integer first = luaL_checkinteger(L, 1);
    real step = luaL_checknumber(L, 2);
    PastRef *ref = lua_newuserdatauv(L, sizeof *ref, 0);
    past_open(&ref->p, first > 0 ? (uint64_t)first : 0, step);
    ref->frame = -1;
    luaL_setmetatable(L, PAST);
    return 1;
}

/* core.past_take(past, world): where its bodies are, before a step or at the end */
static int past_points(lua_State *L)
{
    PastRef *ref = check_past(L, 1);
    return past_take(&ref->p, bind_check_world(L, 2)->w) == DIG_OK ? 0 : no_room(L);
}

/* core.past_energy(past, world), after a step */
static int past_energies(lua_State *L)
{
    PastRef *ref = check_past(L, 1);
    const dig_world *w = bind_check_world(L, 2)->w;
    dig_energy e = dig_world_energy(w);
    past_energy(&ref->p, dig_world_steps(w), &e);
    return 0;
}

/* core.past_read(past, reader, frame, trails, energies): what was up to a frame of a replay, which is not before the last one */
static int past_read(lua_State *L)
{
    PastRef *ref = check_past(L, 1);
    Replay *r = bind_check_reader(L, 2);
    int frame = (int)luaL_checkinteger(L, 3);
    dig_status s = replay_past(r, ref->frame + 1, frame, lua_toboolean(L, 4), lua_toboolean(L, 5), &ref->p);
    ref->frame = frame;
    return s == DIG_OK ? 0 : bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
}

const ViewPast *bind_past(lua_State *L, int index)
{
    PastRef *ref = check_past(L, index);
    if (past_show(&ref->p, &ref->shown) != DIG_OK)
        no_room(L);
    return &ref->shown;
}

void bind_past_open(lua_State *L, int core)
{
    static const luaL_Reg functions[] = {
        {"past", past_new}, {"past_take", past_points}, {"past_energy", past_energies}, {"past_read", past_read}, {NULL, NULL},
    };
    bind_held_type(L, PAST, past_gc);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
