/* lua/bind_record.c - tables that the binding gives and whose names are known: asking for another is an error with a suggestion. */

#include "bind.h"

#include <ctype.h>

/* The name as the founding document spells it: currPos is curr_pos, iTensor is itensor. Pushes the value there, or nil. */
static int push_spelled(lua_State *L, const char *key)
{
    char snake[64], plain[64];
    size_t n = 0, m = 0;
    for (const char *p = key; *p && n + 2 < sizeof snake; p++) {
        if (isupper((unsigned char)*p))
            snake[n++] = '_';
        snake[n++] = plain[m++] = (char)tolower((unsigned char)*p);
    }
    lua_pushlstring(L, snake, n);
    if (lua_rawget(L, 1) != LUA_TNIL)
        return LUA_TTABLE;
    lua_pushlstring(L, plain, m);
    return lua_rawget(L, 1);
}

/* upvalues: what it is called, names that may have no value, whether they may be spelled as in the document */
static int record_index(lua_State *L)
{
    if (lua_type(L, 2) != LUA_TSTRING)
        return 0;
    lua_pushvalue(L, 2);
    if (lua_rawget(L, lua_upvalueindex(2)) != LUA_TNIL)
        return 0;
    if (lua_toboolean(L, lua_upvalueindex(3)) && push_spelled(L, lua_tostring(L, 2)) != LUA_TNIL)
        return 1;
    lua_settop(L, 2);
    lua_pushvalue(L, 1);
    lua_pushvalue(L, lua_upvalueindex(2));
    return bind_unknown(L, lua_tostring(L, lua_upvalueindex(1)), "has no field", lua_tostring(L, 2), 3, 4);
}

/* record() -> record: as a method, too, for what the founding documents write so: body:debug() */
static int record_call(lua_State *L)
{
    lua_settop(L, 1);
    return 1;
}

void bind_record(lua_State *L, const char *what, const char *const *empty, bool spelled)
{
    if (luaL_newmetatable(L, what)) {
        lua_pushstring(L, what);
        lua_newtable(L);
        for (int i = 0; empty && empty[i]; i++) {
            lua_pushboolean(L, true);
            lua_setfield(L, -2, empty[i]);
        }
        lua_pushboolean(L, spelled);
        lua_pushcclosure(L, record_index, 3);
        lua_setfield(L, -2, "__index");
        if (spelled) {
            lua_pushcfunction(L, record_call);
            lua_setfield(L, -2, "__call");
        }
        lua_pushboolean(L, false);
        lua_setfield(L, -2, "__metatable");
        lua_pushnil(L);
        lua_setfield(L, -2, "__name");
    }
    lua_setmetatable(L, -2);
}
