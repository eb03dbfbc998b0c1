/* lua/sandbox.h - what the libraries of scripts share: the limits they charge, texts without addresses, the list of what is there.
 *
 * Scripts do not get the libraries of Lua but a list of functions: those of Lua that do a bounded amount of work, and our own where
 * a loop in C could run without end (patterns, tables, coroutines) or would show an address. Each loop charges fuel.
 */
#ifndef DIGBOX_SANDBOX_H
#define DIGBOX_SANDBOX_H

#include <lauxlib.h>
#include <lua.h>
#include <stdbool.h>

#include "state.h"

static inline App *app_of(lua_State *L)
{
    return *(App **)lua_getextraspace(L);
}

/* Counts work done in C, in units of about one Lua instruction; where a limit is reached, does not return. */
void app_charge(lua_State *L, size_t work);

/* So many bytes will be asked for: where they are more than the script may use, does not return. */
void app_need(lua_State *L, size_t bytes);

/* Checks every limit now. */
void app_poll(lua_State *L);

/* From now on this coroutine runs, with the hook that it needs at present; gives the one that ran before. */
lua_State *app_run(lua_State *L);

/* Text of a regular file on the stack, or false with a sentence there. Then: that text compiled to a function, or a message. */
bool lib_push_source(lua_State *L, const char *path);
int  lib_load_source(lua_State *L, const char *path);

/* Pushes next and pairs in a fixed order (lib_order.c); strict: keys that have none are refused. */
void lib_push_order(lua_State *L, bool strict);

/* Once the program's own Lua is loaded: scripts get strict ones. */
void lib_finish(lua_State *L);

/* Fills _G, with io and os too when `trust`. Raises when something is in reach of scripts that is on no list. */
void lib_open(lua_State *L, bool trust);

/* Walks all that can be reached from _G and the metatables of basic types. Raises at a C function that is not on the list. */
void lib_check(lua_State *L);

/* Runs the function of Lua's library that the running one stands before, its upvalue 1, in its place: with all that is on the stack,
 * and its errors name the script's line. Only for functions without upvalues of their own. Returns how many values it gave. */
static inline int lib_call_first(lua_State *L)
{
    return lua_tocfunction(L, lua_upvalueindex(1))(L);
}

/* One entry: our own function, or with NULL that of Lua's library; `work`: bytes of string arguments are charged before it. */
typedef struct LibEntry {
    const char   *name;
    lua_CFunction own;
    bool          work;
} LibEntry;

extern const LibEntry lib_base[], lib_string[], lib_table[], lib_coroutine[];

#endif
