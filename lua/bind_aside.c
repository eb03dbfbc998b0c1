/* lua/bind_aside.c - frame steps: a body whose numbers stop being finite is set aside, and the others go on.
 *
 * The engine refuses such a step whole and says whose numbers they were. Without that body it is taken again, from the same state:
 * the others get what they would have got had the script disabled it before the step.
 */
#include "bind.h"

/* core.set_aside(world, body, why, place): says so, and counts it */
static void tell(lua_State *L, int world, dig_body who, const char *why)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "set_aside");
    lua_remove(L, -2);
    lua_pushvalue(L, world);
    bind_push_body(L, world, who);
    lua_pushstring(L, why);
    bind_push_made(L, world, who);
    lua_call(L, 4, 0);
}

void bind_step(lua_State *L, int world)
{
    WorldRef *ref = lua_touserdata(L, world);
    dig_status s = dig_world_step(ref->w);
    bind_own_check(L, ref);
    for (dig_body who; s == DIG_E_FINITE && (who = dig_world_culprit(ref->w)).gen != 0;) {
        int top = lua_gettop(L);
        lua_pushstring(L, dig_error(ref->w));
        s = bind_disable(L, world, who);
        if (s != DIG_OK)
            break;
        tell(L, world, who, lua_tostring(L, top + 1));
        lua_settop(L, top);
        s = dig_world_step(ref->w);
        bind_own_check(L, ref);
    }
    if (s != DIG_OK)
        bind_fail(L, ref->w, s);
}

/* core.inject(world, n): in the next step the velocity of body #n is not a number. false: there is no such body */
static int inject(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    lua_Integer number = luaL_checkinteger(L, 2);
    int n = dig_bodies(ref->w, NULL, 0);
    dig_body *all = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *all, 0);
    n = dig_bodies(ref->w, all, n);
    for (int i = 0; i < n; i++) {
        if (all[i].slot != number)
            continue;
        dig_status s = dig_world_inject(ref->w, all[i]);
        if (s != DIG_OK)
            return bind_fail(L, ref->w, s);
        lua_pushboolean(L, true);
        return 1;
    }
    lua_pushboolean(L, false);
    return 1;
}

void bind_aside_open(lua_State *L, int core)
{
    lua_pushcfunction(L, inject);
    lua_setfield(L, core, "inject");
}
