/* lua/lib_table.c - the library `table` of scripts: as the manual of Lua 5.4 has it (section 6.6), but each loop charges fuel, so
 * that a table which lies about its length costs no more than any other loop.
 *
 * sort is a merge sort: stable, n log n whatever the comparison says, and the same at every run. It sorts a copy, so a comparison
 * that fails leaves the table as it was, and one that changes the table does no harm. */

#include <limits.h>

#include "sandbox.h"

static lua_Integer length_of(lua_State *L, int index)
{
    return luaL_len(L, index);
}

/* A table, or what has the metamethods to stand for one. */
static void check_list(lua_State *L, int index)
{
    if (lua_type(L, index) == LUA_TTABLE)
        return;
    if (luaL_getmetafield(L, index, "__index") == LUA_TNIL)
        luaL_checktype(L, index, LUA_TTABLE);
    lua_pop(L, 1);
}

static int table_insert(lua_State *L)
{
    check_list(L, 1);
    lua_Integer end = (lua_Integer)((lua_Unsigned)length_of(L, 1) + 1), at = end;
    int n = lua_gettop(L);
    if (n == 3) {
        at = luaL_checkinteger(L, 2);
        luaL_argcheck(L, (lua_Unsigned)at - 1u < (lua_Unsigned)end, 2, "position out of bounds");
        for (lua_Integer i = end; i > at; i--) {
            app_charge(L, 1);
            lua_geti(L, 1, i - 1);
            lua_seti(L, 1, i);
        }
    } else if (n != 2) {
        return luaL_error(L, "wrong number of arguments to 'insert'");
    }
    lua_settop(L, n);
    lua_seti(L, 1, at);
    return 0;
}

static int table_remove(lua_State *L)
{
    check_list(L, 1);
    lua_Integer end = length_of(L, 1), at = luaL_optinteger(L, 2, end);
    if (at != end)                      /* one past the end is allowed, and 0 in an empty list */
        luaL_argcheck(L, (lua_Unsigned)at - 1u <= (lua_Unsigned)end, 2, "position out of bounds");
    lua_geti(L, 1, at);
    for (; at < end; at++) {
        app_charge(L, 1);
        lua_geti(L, 1, at + 1);
        lua_seti(L, 1, at);
    }
    lua_pushnil(L);
    lua_seti(L, 1, at);
    return 1;
}

static int table_move(lua_State *L)
{
    lua_Integer from = luaL_checkinteger(L, 2), last = luaL_checkinteger(L, 3), to = luaL_checkinteger(L, 4);
    int target = lua_isnoneornil(L, 5) ? 1 : 5;
    check_list(L, 1);
    check_list(L, target);
    if (last >= from) {
        luaL_argcheck(L, from > 0 || last < LUA_MAXINTEGER + from, 3, "too many elements to move");
        lua_Integer count = last - from + 1;
        luaL_argcheck(L, to <= LUA_MAXINTEGER - count + 1, 4, "destination wrap around");
        bool backwards = to > from && to <= last && (target == 1 || lua_compare(L, 1, target, LUA_OPEQ));
        for (lua_Integer k = 0; k < count; k++) {
            lua_Integer i = backwards ? count - 1 - k : k;
            app_charge(L, 1);
            lua_geti(L, 1, from + i);
            lua_seti(L, target, to + i);
        }
    }
    lua_pushvalue(L, target);
    return 1;
}

static int table_concat(lua_State *L)
{
    check_list(L, 1);
    size_t separator_length;
    const char *separator = luaL_optlstring(L, 2, "", &separator_length);
    lua_Integer i = luaL_optinteger(L, 3, 1), last = luaL_opt(L, luaL_checkinteger, 4, length_of(L, 1));
    luaL_Buffer b;
    luaL_buffinit(L, &b);
    for (; i <= last; i++) {
        lua_geti(L, 1, i);
        if (!lua_isstring(L, -1))
            return luaL_error(L, "invalid value (at index %I) in table for 'concat'", (LUAI_UACINT)i);
        app_charge(L, 1 + lua_rawlen(L, -1) / 16);
        luaL_addvalue(&b);
        if (i == last)
            break;                      /* not i++: that may be the last integer there is */
        luaL_addlstring(&b, separator, separator_length);
    }
    luaL_pushresult(&b);
    return 1;
}

static int table_pack(lua_State *L)
{
    int n = lua_gettop(L);
    app_charge(L, (size_t)n);
    lua_createtable(L, n, 1);
    lua_insert(L, 1);
    for (int i = n; i >= 1; i--)
        lua_seti(L, 1, i);
    lua_pushinteger(L, n);
    lua_setfield(L, 1, "n");
    return 1;
}

static int table_unpack(lua_State *L)
{
    lua_Integer i = luaL_optinteger(L, 2, 1), last = luaL_opt(L, luaL_checkinteger, 3, length_of(L, 1));
    if (i > last)
        return 0;
    lua_Unsigned count = (lua_Unsigned)last - (lua_Unsigned)i;
    if (count >= INT_MAX || !lua_checkstack(L, (int)(count + 1)))
        return luaL_error(L, "too many results to unpack");
    app_charge(L, (size_t)count + 1);
    for (lua_Unsigned k = 0; k <= count; k++)
        lua_geti(L, 1, (lua_Integer)((lua_Unsigned)i + k));
    return (int)count + 1;
}

/* ---- sort ------------------------------------------------------------------------ */

enum { SORT_TABLE = 1, SORT_LESS = 2, SORT_A = 3, SORT_B = 4 };         /* places on the stack */

/* Is the value on top less than the one below it? */
static bool is_less(lua_State *L)
{
    if (lua_isnil(L, SORT_LESS))
        return lua_compare(L, -1, -2, LUA_OPLT);
    lua_pushvalue(L, SORT_LESS);
    lua_pushvalue(L, -2);
    lua_pushvalue(L, -4);
    lua_call(L, 2, 1);
    bool less = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return less;
}

/* Merges the runs [i, middle) and [middle, end) of one table into the other. Of equal values the left one comes first. */
static void merge(lua_State *L, int from, int to, lua_Integer i, lua_Integer middle, lua_Integer end)
{
    lua_Integer j = middle;
    for (lua_Integer k = i; k < end; k++) {
        app_charge(L, 2);
        if (j >= end) {
            lua_rawgeti(L, from, i++);
        } else if (i >= middle) {
            lua_rawgeti(L, from, j++);
        } else {
            lua_rawgeti(L, from, i);
            lua_rawgeti(L, from, j);
            if (is_less(L)) {
                lua_remove(L, -2);
                j++;
            } else {
                lua_pop(L, 1);
                i++;
            }
        }
        lua_rawseti(L, to, k);
    }
}

static int table_sort(lua_State *L)
{
    check_list(L, 1);
    lua_Integer n = length_of(L, 1);
    if (n < 2)
        return 0;
    luaL_argcheck(L, n < INT_MAX, 1, "array too big");
    if (!lua_isnoneornil(L, 2))
        luaL_checktype(L, 2, LUA_TFUNCTION);
    lua_settop(L, 2);
    luaL_checkstack(L, 16, "sort");
    lua_newtable(L);
    lua_newtable(L);
    for (lua_Integer i = 1; i <= n; i++) {
        app_charge(L, 1);
        lua_geti(L, SORT_TABLE, i);
        lua_rawseti(L, SORT_A, i);
    }
    int from = SORT_A, to = SORT_B;
    for (lua_Integer width = 1; width < n; width *= 2) {
        for (lua_Integer i = 1; i <= n; i += 2 * width) {
            lua_Integer middle = i + width <= n ? i + width : n + 1, end = i + 2 * width <= n ? i + 2 * width : n + 1;
            merge(L, from, to, i, middle, end);
        }
        int other = from;
        from = to;
        to = other;
    }
    for (lua_Integer i = 1; i <= n; i++) {
        app_charge(L, 1);
        lua_rawgeti(L, from, i);
        lua_seti(L, SORT_TABLE, i);
    }
    return 0;
}

const LibEntry lib_table[] = {
    {"concat", table_concat, false}, {"insert", table_insert, false}, {"move", table_move, false},   {"pack", table_pack, false},
    {"remove", table_remove, false}, {"sort", table_sort, false},     {"unpack", table_unpack, false}, {NULL, NULL, false},
};
