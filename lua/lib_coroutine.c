/* lua/lib_coroutine.c - the library `coroutine` of scripts (manual of Lua 5.4, section 6.2).
 *
 * Three things differ from Lua's own: the limits know which coroutine runs, so that a hook reaches it; making one is charged, since
 * each starts counting its instructions anew; and coroutines that close each other from __close nest a bounded number of times.
 * Lua 5.4.4 forgets how deep the C stack is there and runs off its end. */

#include "sandbox.h"

enum { NEW_WORK = 1000 };       /* units; as many instructions as a coroutine may run before the hook sees it */
enum { CLOSE_DEPTH = 16 };      /* each can nest 200 C calls; process.c makes the stack large enough          */

static lua_State *check_coroutine(lua_State *L, int index)
{
    lua_State *co = lua_tothread(L, index);
    luaL_argexpected(L, co, index, "coroutine");
    return co;
}

static const char *status_of(lua_State *L, lua_State *co)
{
    lua_Debug ar;
    if (L == co)
        return "running";
    switch (lua_status(co)) {
    case LUA_YIELD: return "suspended";
    case LUA_OK: break;
    default: return "dead";
    }
    if (lua_getstack(co, 0, &ar))
        return "normal";
    return lua_gettop(co) == 0 ? "dead" : "suspended";
}

/* Moves `arguments` values from the top of L to co and lets it run. Returns the number of results on L, or -1 with a message. */
static int go_on(lua_State *L, lua_State *co, int arguments)
{
    int results;
    if (!lua_checkstack(co, arguments)) {
        lua_pushliteral(L, "too many arguments to resume");
        return -1;
    }
    lua_xmove(L, co, arguments);
    app_run(co);
    int status = lua_resume(co, L, arguments, &results);
    app_run(L);
    if (status != LUA_OK && status != LUA_YIELD) {
        lua_xmove(co, L, 1);
        return -1;
    }
    if (!lua_checkstack(L, results + 1)) {
        lua_pop(co, results);
        lua_pushliteral(L, "too many results to resume");
        return -1;
    }
    lua_xmove(co, L, results);
    return results;
}

static int co_create(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TFUNCTION);
    app_charge(L, NEW_WORK);
    lua_State *co = lua_newthread(L);
    lua_pushvalue(L, 1);
    lua_xmove(L, co, 1);
    return 1;
}

/* False, with a message on L, when it cannot be resumed. */
static bool can_resume(lua_State *L, lua_State *co)
{
    const char *status = status_of(L, co);
    if (*status == 's')
        return true;
    lua_pushfstring(L, "cannot resume %s coroutine", *status == 'd' ? "dead" : "non-suspended");
    return false;
}

static int co_resume(lua_State *L)
{
    lua_State *co = check_coroutine(L, 1);
    int n = can_resume(L, co) ? go_on(L, co, lua_gettop(L) - 1) : -1;
    lua_pushboolean(L, n >= 0);
    lua_insert(L, n >= 0 ? -(n + 1) : -2);
    return n >= 0 ? n + 1 : 2;
}

/* Closes the pending variables of a coroutine; the status, with a message on co unless it is LUA_OK. */
static int close_pending(lua_State *L, lua_State *co)
{
    App *app = app_of(L);
    if (app->closing >= CLOSE_DEPTH)
        return luaL_error(L, "C stack overflow (more than %d coroutines close each other)", CLOSE_DEPTH);
    app->closing++;
    app_run(co);
    int status = lua_resetthread(co);
    app_run(L);
    app->closing--;
    return status;
}

static int co_wrapped(lua_State *L)
{
    lua_State *co = lua_tothread(L, lua_upvalueindex(1));
    int n = can_resume(L, co) ? go_on(L, co, lua_gettop(L)) : -1;
    if (n >= 0)
        return n;
    if (lua_status(co) > LUA_YIELD) {                   /* it failed: what it left open is closed now */
        lua_pushvalue(L, -1);
        lua_xmove(L, co, 1);
        int status = close_pending(L, co);
        if (status != LUA_OK) {
            lua_xmove(co, L, 1);
            lua_replace(L, -2);
        }
    }
    if (lua_type(L, -1) == LUA_TSTRING) {               /* adds where it was called, as Lua does */
        luaL_where(L, 1);
        lua_insert(L, -2);
        lua_concat(L, 2);
    }
    return lua_error(L);
}

static int co_wrap(lua_State *L)
{
    co_create(L);
    lua_pushcclosure(L, co_wrapped, 1);
    return 1;
}

static int co_close(lua_State *L)
{
    lua_State *co = check_coroutine(L, 1);
    const char *status = status_of(L, co);
    if (*status != 's' && *status != 'd')
        return luaL_error(L, "cannot close a %s coroutine", status);
    bool fine = close_pending(L, co) == LUA_OK;
    lua_pushboolean(L, fine);
    if (fine)
        return 1;
    lua_xmove(co, L, 1);
    return 2;
}

/* As Lua's, but its refusal says where. */
static int co_yield(lua_State *L)
{
    if (lua_isyieldable(L))
        return lua_yield(L, lua_gettop(L));
    bool outermost = lua_pushthread(L) == 1;
    return luaL_error(L, "attempt to yield %s", outermost ? "from outside a coroutine" : "across a C-call boundary");
}

const LibEntry lib_coroutine[] = {
    {"close", co_close, false}, {"create", co_create, false},   {"isyieldable", NULL, false}, {"resume", co_resume, false},
    {"running", NULL, false},   {"status", NULL, false},        {"wrap", co_wrap, false},     {"yield", co_yield, false},
    {NULL, NULL, false},
};
