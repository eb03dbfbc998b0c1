/* lua/lib_order.c - pairs and next in a fixed order: numbers, then strings by their bytes, then false and true, then bodies and joints
 * as they were made.
 *
 * Lua hashes strings with a seed that differs between runs, and everything else by its address, so its own order is another one in
 * every run. Tables, functions and coroutines as keys have nothing to be ordered by: two of them in one table are refused where
 * a script asks for an order. The program's own Lua gets them last, as Lua has them: it sorts what it shows.
 *
 * What a weak table still holds hangs on when Lua collected last, and that on addresses (they decide when a table grows): a script
 * may look a key up in one, as a cache does, but not go through it. */

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "bind.h"
#include "sandbox.h"

enum { KEY_NUMBER, KEY_STRING, KEY_FALSE, KEY_TRUE, KEY_BODY, KEY_JOINT, KEY_OTHER };
enum { CACHED = 8 };            /* traversals by next that are remembered, for loops inside loops */

typedef struct Key {
    int         rank, place;    /* place: in the list of keys, from 1 */
    lua_Number  number;
    lua_Integer integer;        /* where number alone is not exact */
    const char *text;
    size_t      length;
} Key;

static Key read_key(lua_State *L, int index, int place)
{
    Key k = {.rank = KEY_OTHER, .place = place};
    const BodyRef *body;
    const JointRef *joint;
    int kind = lua_type(L, index);
    switch (kind) {
    case LUA_TNUMBER:
        k.rank = KEY_NUMBER;
        k.number = lua_tonumber(L, index);
        k.integer = lua_isinteger(L, index) ? lua_tointeger(L, index) : 0;
        break;
    case LUA_TSTRING:
        k.rank = KEY_STRING;
        k.text = lua_tolstring(L, index, &k.length);
        break;
    case LUA_TBOOLEAN:
        k.rank = lua_toboolean(L, index) ? KEY_TRUE : KEY_FALSE;
        break;
    case LUA_TUSERDATA:
        if ((body = luaL_testudata(L, index, BIND_BODY)) != NULL) {
            k.rank = KEY_BODY;
            k.integer = (lua_Integer)((uint64_t)body->id.gen << 32 | body->id.slot);
        } else if ((joint = luaL_testudata(L, index, BIND_JOINT)) != NULL) {
            k.rank = KEY_JOINT;
            k.integer = (lua_Integer)((uint64_t)joint->id.gen << 32 | joint->id.slot);
        }
        break;
    default: break;
    }
    return k;
}

static int compare_keys(const void *x, const void *y)
{
    const Key *a = x, *b = y;
    if (a->rank != b->rank)
        return a->rank < b->rank ? -1 : 1;
    if (a->rank == KEY_STRING) {
        size_t n = a->length < b->length ? a->length : b->length;
        int by = n > 0 ? memcmp(a->text, b->text, n) : 0;
        return by ? by : (a->length > b->length) - (a->length < b->length);
    }
    if (a->number < b->number || a->number > b->number)
        return a->number < b->number ? -1 : 1;
    if (a->rank == KEY_OTHER)
        return a->place - b->place;             /* as Lua has them */
    return (a->integer > b->integer) - (a->integer < b->integer);
}

static void refuse(lua_State *L, const Key *a, const Key *b)
{
    if (a->rank == KEY_OTHER || compare_keys(a, b) == 0)
        bind_error(L, "pairs: tables, functions and coroutines as keys have no fixed order; use a list, or names as keys");
}

/* Refuses to go through the table at t where what is in it differs from run to run. */
static void check_strong(lua_State *L, int t)
{
    if (luaL_getmetafield(L, t, "__mode") == LUA_TNIL)
        return;
    if (lua_isstring(L, -1) && strpbrk(lua_tostring(L, -1), "kv"))
        bind_error(L, "pairs: what a weak table (__mode) still holds differs from run to run; keep a list of what is to be gone through");
    lua_pop(L, 1);
}

/* Are the keys numbers that come in their order by themselves? Then nothing has to be sorted. */
static bool is_in_order(lua_State *L, int t)
{
    lua_Number last = 0;
    bool first = true;
    size_t n = 0;
    for (lua_pushnil(L); lua_next(L, t); n++) {
        lua_pop(L, 1);
        lua_Number key = lua_tonumber(L, -1);
        if (lua_type(L, -1) != LUA_TNUMBER || (!first && key <= last)) {
            lua_pop(L, 1);
            app_charge(L, n);
            return false;
        }
        last = key;
        first = false;
    }
    app_charge(L, n);
    return true;
}

typedef struct Order {
    int count, at;              /* keys; which was given last, 0 = none */
    int place[];                /* [count] in the list of keys */
} Order;

/* Pushes the list of keys and the Order of the table at t. */
static Order *push_order(lua_State *L, int t, bool strict)
{
    int n = 0;
    lua_newtable(L);
    int list = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, t); ) {
        lua_pop(L, 1);
        lua_pushvalue(L, -1);
        lua_rawseti(L, list, ++n);
    }
    app_charge(L, 4 * (size_t)n);
    Order *o = lua_newuserdatauv(L, sizeof *o + (size_t)n * sizeof *o->place, 0);
    Key *keys = lua_newuserdatauv(L, ((size_t)n + 1) * sizeof *keys, 0);
    for (int i = 0; i < n; i++) {
        lua_rawgeti(L, list, i + 1);
        keys[i] = read_key(L, -1, i + 1);       /* the list keeps the text */
        lua_pop(L, 1);
    }
    qsort(keys, (size_t)n, sizeof *keys, compare_keys);
    for (int i = 1; i < n && strict; i++)
        if (keys[i].rank >= KEY_BODY && keys[i].rank == keys[i - 1].rank)
            refuse(L, &keys[i - 1], &keys[i]);
    *o = (Order){.count = n};
    for (int i = 0; i < n; i++)
        o->place[i] = keys[i].place;
    lua_pop(L, 1);
    return o;
}

/* Pushes the next key that is still there, and its value; returns how many. */
static int give_next(lua_State *L, int t, int list, Order *o)
{
    while (o->at < o->count) {
        lua_rawgeti(L, list, o->place[o->at++]);
        lua_pushvalue(L, -1);
        if (lua_rawget(L, t) != LUA_TNIL)
            return 2;
        lua_pop(L, 2);
    }
    lua_pushnil(L);
    return 1;
}

/* upvalues: list of keys, Order */
static int step_sorted(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    return give_next(L, 1, lua_upvalueindex(1), lua_touserdata(L, lua_upvalueindex(2)));
}

/* ---- next: remembers the orders it made ------------------------------------------------------ */

/* The smallest key, without sorting: `next(t)` is mostly a question whether there is one. */
static int first_key(lua_State *L, int t, bool strict)
{
    Key least = {0};
    size_t n = 0;
    lua_settop(L, 1);
    lua_pushnil(L);                     /* the least so far: 2 */
    for (lua_pushnil(L); lua_next(L, t); n++) {
        lua_pop(L, 1);
        Key k = read_key(L, -1, (int)n);
        if (strict && n > 0 && k.rank >= KEY_BODY && k.rank == least.rank)
            refuse(L, &k, &least);
        if (n > 0 && compare_keys(&k, &least) > 0)
            continue;
        least = k;
        lua_pushvalue(L, -1);
        lua_replace(L, 2);
    }
    app_charge(L, 2 * n);
    if (n == 0)
        return 1;
    lua_pushvalue(L, 2);
    lua_rawget(L, t);
    return 2;
}

/* Pushes list and Order from the upvalue's slot. */
static Order *push_slot(lua_State *L, int cache, int slot)
{
    lua_rawgeti(L, cache, 3 * slot + 2);
    lua_rawgeti(L, cache, 3 * slot + 3);
    return lua_touserdata(L, -1);
}

/* The remembered traversal of table 1 that gave key 2 last: pushes list and Order, or nothing. */
static Order *find_slot(lua_State *L, int cache)
{
    for (int slot = 0; slot < CACHED; slot++) {
        bool same = lua_rawgeti(L, cache, 3 * slot + 1) == LUA_TTABLE && lua_rawequal(L, -1, 1);
        lua_pop(L, 1);
        if (!same)
            continue;
        Order *o = push_slot(L, cache, slot);
        if (o->at > 0 && lua_rawgeti(L, -2, o->place[o->at - 1]) != LUA_TNIL && lua_rawequal(L, -1, 2)) {
            lua_pop(L, 1);
            return o;
        }
        lua_settop(L, 2);
    }
    return NULL;
}

/* How many keys come before the next of key 2. That may be gone: who goes through a table may clear it. */
static int place_of(lua_State *L, const Order *o, int list)
{
    Key wanted = read_key(L, 2, 0);
    int before = 0;
    bool found = false;
    for (int i = 0; i < o->count && !found; i++) {
        lua_rawgeti(L, list, o->place[i]);
        Key k = read_key(L, -1, i + 1);
        found = lua_rawequal(L, -1, 2);
        if (found || compare_keys(&k, &wanted) < 0)
            before = i + 1;
        lua_pop(L, 1);
    }
    return before;
}

/* Sorts anew, goes to key 2, and remembers that in the oldest slot. */
static Order *make_slot(lua_State *L, int cache, bool strict)
{
    Order *o = push_order(L, 1, strict);
    o->at = place_of(L, o, lua_gettop(L) - 1);
    lua_rawgeti(L, cache, 3 * CACHED + 1);
    int slot = (int)lua_tointeger(L, -1) % CACHED;
    lua_pushinteger(L, slot + 1);
    lua_rawseti(L, cache, 3 * CACHED + 1);
    lua_pop(L, 1);
    lua_pushvalue(L, 1);
    lua_rawseti(L, cache, 3 * slot + 1);
    lua_pushvalue(L, -2);
    lua_rawseti(L, cache, 3 * slot + 2);
    lua_pushvalue(L, -1);
    lua_rawseti(L, cache, 3 * slot + 3);
    return o;
}

/* next(table [, key]). upvalues: what it remembers, is it strict */
static int order_next(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 2);
    bool strict = lua_toboolean(L, lua_upvalueindex(2));
    if (strict)
        check_strong(L, 1);
    if (lua_isnil(L, 2))
        return first_key(L, 1, strict);
    int cache = lua_upvalueindex(1);
    Order *o = find_slot(L, cache);
    if (!o)
        o = make_slot(L, cache, strict);
    int n = give_next(L, 1, 3, o);
    if (n == 1)
        o->at = 0;
    return n;
}

/* A traversal whose keys need no sorting. Should that change meanwhile, next takes over. upvalue: next */
static int step_plain(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 2);
    bool first = lua_isnil(L, 2);
    lua_Number last = lua_tonumber(L, 2);
    lua_pushvalue(L, 2);
    if (!lua_next(L, 1)) {
        lua_pushnil(L);
        return 1;
    }
    if (lua_type(L, -2) == LUA_TNUMBER && (first || lua_tonumber(L, -2) > last))
        return 2;
    lua_settop(L, 2);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, 2, 2);
    return 2;
}

/* upvalues: step_plain, is it strict */
static int order_pairs(lua_State *L)
{
    luaL_checkany(L, 1);
    if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
        lua_pushvalue(L, 1);
        lua_call(L, 1, 3);
        return 3;
    }
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    bool strict = lua_toboolean(L, lua_upvalueindex(2));
    if (strict)
        check_strong(L, 1);
    if (is_in_order(L, 1)) {
        lua_pushvalue(L, lua_upvalueindex(1));
    } else {
        push_order(L, 1, strict);
        lua_pushcclosure(L, step_sorted, 2);
    }
    lua_pushvalue(L, 1);
    lua_pushnil(L);
    return 3;
}

void lib_push_order(lua_State *L, bool strict)
{
    lua_createtable(L, 3 * CACHED + 1, 0);
    for (int i = 1; i <= 3 * CACHED; i++) {
        lua_pushboolean(L, 0);
        lua_rawseti(L, -2, i);
    }
    lua_pushinteger(L, 0);
    lua_rawseti(L, -2, 3 * CACHED + 1);
    lua_pushboolean(L, strict);
    lua_pushcclosure(L, order_next, 2);
    lua_pushvalue(L, -1);
    lua_pushcclosure(L, step_plain, 1);
    lua_pushboolean(L, strict);
    lua_pushcclosure(L, order_pairs, 2);
}
