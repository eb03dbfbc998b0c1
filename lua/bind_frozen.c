/* lua/bind_frozen.c - tables that are read only: copies that a script would change in the belief that it changes the thing. */

#include "bind.h"

#include <string.h>

static const char marker;       /* its address: the key of what is frozen, in the metatable */

/* upvalue: "joint.motor". joint.motor.speed = 5 */
static int refuse_change(lua_State *L)
{
    const char *what = lua_tostring(L, lua_upvalueindex(1));
    const char *key = bind_text(L, 2), *value = lua_isnumber(L, 3) ? bind_text(L, 3) : "...";
    if (lua_type(L, 2) == LUA_TSTRING)
        return bind_error(L, "%s is a copy, changing it would change nothing: write %s = { %s = %s }; what is not given stays", what, what, key, value);
    return bind_error(L, "%s is a copy, changing it would change nothing: write %s = { ..., ... }", what, what);
}

/* upvalues here and below: what is frozen. So pairs and the like see what is in it. */
static int frozen_pairs(lua_State *L)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.env");
    lua_getfield(L, -1, "pairs");
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_call(L, 1, 3);
    return 3;
}

static int frozen_length(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)lua_rawlen(L, lua_upvalueindex(1)));
    return 1;
}

/* {-1.0, 1.0}, {max_torque = 5.0, speed = 2.0} */
static int frozen_text(lua_State *L)
{
    int table = lua_upvalueindex(1), count;
    lua_pushvalue(L, table);
    lua_replace(L, 1);
    lua_settop(L, 1);
    const char **names = bind_names(L, 1, 1, &count);
    lua_pushliteral(L, "{");
    int text = lua_gettop(L), length = (int)lua_rawlen(L, 1);
    for (int i = 0; i < length + count; i++) {
        const char *name = i < length ? "" : names[i - length], *is = i < length ? "" : " = ";
        if (i < length)
            lua_rawgeti(L, 1, i + 1);
        else
            lua_getfield(L, 1, name);
        const char *value = bind_text(L, -1);
        lua_pushfstring(L, "%s%s%s%s%s", lua_tostring(L, text), i > 0 ? ", " : "", name, is, value);
        lua_replace(L, text);
        lua_settop(L, text);
    }
    lua_pushliteral(L, "}");
    lua_concat(L, 2);
    return 1;
}

void bind_freeze(lua_State *L, const char *what)
{
    static const luaL_Reg meta[] = {{"__pairs", frozen_pairs}, {"__len", frozen_length}, {"__tostring", frozen_text}, {NULL, NULL}};
    luaL_checkstack(L, 8, "a table of parameters");
    int table = lua_gettop(L) - 1;              /* the text is above it */
    lua_newtable(L);
    lua_createtable(L, 0, 7);
    for (const luaL_Reg *m = meta; m->name; m++) {
        lua_pushvalue(L, table);
        lua_pushcclosure(L, m->func, 1);
        lua_setfield(L, -2, m->name);
    }
    lua_pushvalue(L, table);
    lua_setfield(L, -2, "__index");
    lua_pushvalue(L, table);
    lua_rawsetp(L, -2, &marker);
    lua_pushstring(L, what);
    lua_pushcclosure(L, refuse_change, 1);
    lua_setfield(L, -2, "__newindex");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    lua_setmetatable(L, -2);
    lua_replace(L, table);
    lua_settop(L, table);
}

void bind_thaw(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    if (!lua_istable(L, index) || !lua_getmetatable(L, index))
        return;
    if (lua_rawgetp(L, -1, &marker) == LUA_TTABLE) {
        lua_replace(L, index);
        lua_pop(L, 1);
    } else {
        lua_pop(L, 2);
    }
}

/* core.thaw(value) -> what is frozen in it, or itself */
static int thaw(lua_State *L)
{
    lua_settop(L, 1);
    bind_thaw(L, 1);
    return 1;
}

void bind_frozen_open(lua_State *L, int core)
{
    lua_pushcfunction(L, thaw);
    lua_setfield(L, core, "thaw");
}
