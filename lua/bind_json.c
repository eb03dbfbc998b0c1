/* lua/bind_json.c - JSON as Lua has it. core.json in lua/digbox/replay.lua writes it. */
#include "bind.h"

#include <cjson/cJSON.h>

/* Whole numbers are integers, null is nil, lists from 1. cJSON bounds the nesting. */
static void push_json(lua_State *L, const cJSON *j)
{
    const cJSON *item;
    lua_Integer n = 0, whole;
    luaL_checkstack(L, 4, "too deep");
    if (!cJSON_IsArray(j) && !cJSON_IsObject(j)) {
        if (cJSON_IsNumber(j) && lua_numbertointeger(j->valuedouble, &whole) && (lua_Number)whole == j->valuedouble)
            lua_pushinteger(L, whole);
        else if (cJSON_IsNumber(j))
            lua_pushnumber(L, j->valuedouble);
        else if (cJSON_IsBool(j))
            lua_pushboolean(L, cJSON_IsTrue(j));
        else
            lua_pushstring(L, cJSON_GetStringValue(j));         /* null: nil */
        return;
    }
    lua_newtable(L);
    cJSON_ArrayForEach(item, j) {
        push_json(L, item);
        if (cJSON_IsArray(j))
            lua_rawseti(L, -2, ++n);
        else
            lua_setfield(L, -2, item->string);
    }
}

static int push_parsed(lua_State *L)
{
    push_json(L, lua_touserdata(L, 1));
    return 1;
}

bool bind_push_json(lua_State *L, const char *text)
{
    cJSON *parsed = cJSON_ParseWithOpts(text, NULL, true);
    if (!parsed)
        return false;
    lua_pushcfunction(L, push_parsed);
    lua_pushlightuserdata(L, parsed);
    int failed = lua_pcall(L, 1, 1, 0);         /* no memory: it is freed all the same */
    cJSON_Delete(parsed);
    if (failed != LUA_OK)
        lua_error(L);
    return true;
}

/* core.from_json(text) -> its value; nil: it is no JSON (or null) */
static int from_json(lua_State *L) { return bind_push_json(L, luaL_checkstring(L, 1)) ? 1 : 0; }

void bind_json_open(lua_State *L, int core)
{
    lua_pushcfunction(L, from_json);
    lua_setfield(L, core, "from_json");
}
