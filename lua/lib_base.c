/* lua/lib_base.c - what scripts find in _G: built from lists, never by taking away, and checked before the script starts.
 *
 * base functions, text without addresses, load and require of text only, and the walk that refuses what is on no list. */

#define _XOPEN_SOURCE 700       /* realpath, fstat, lstat */

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <lualib.h>

#include "bind.h"
#include "command.h"
#include "sandbox.h"

enum { SCRIPT_LIMIT = 16 * 1024 * 1024, LOAD_LIMIT = 4 * 1024 * 1024, BYTES_A_UNIT = 16 };

/* ---- text of values -------------------------------------------------------------- */

static int base_tostring(lua_State *L)
{
    luaL_checkany(L, 1);
    bind_text(L, 1);
    return 1;
}

/* Prints to stdout, up to the limit of the run; past it nothing, and one line on stderr says so. What a terminal would act upon is
 * not printed, unless the script is trusted. */
static int base_print(lua_State *L)
{
    App *app = app_of(L);
    int n = lua_gettop(L);
    for (int i = 1; i <= n + 1; i++) {
        size_t length = 1;
        const char *text = "\n";
        if (i <= n) {
            bind_text(L, i);
            text = lua_tolstring(L, -1, &length);
        }
        app_charge(L, 1 + length / BYTES_A_UNIT);
        size_t room = app->log_limit > app->logged ? app->log_limit - app->logged : 0;
        if (app->log_limit > 0 && length + 1 > room) {
            if (room > 0)
                fprintf(stderr, "digbox: %s: log limit reached: what it prints past %zu bytes is left out\n", app->script, app->log_limit);
            app->logged = app->log_limit;
            return 0;
        }
        if (i > 1 && i <= n)
            fputc('\t', stdout);
        if (app->trust)
            fwrite(text, 1, length, stdout);
        else
            say_text(stdout, text, length, "\n\t");
        app->logged += length + (i > 1 && i <= n);
        lua_settop(L, n);
    }
    return 0;
}

/* ---- load ------------------------------------------------------------------------------ */

/* Joins what the function at 1 gives until it gives nothing. */
static void join_pieces(lua_State *L)
{
    luaL_Buffer b;
    size_t total = 0, length = 1;
    luaL_buffinit(L, &b);
    while (length > 0 && total <= LOAD_LIMIT) {
        app_charge(L, 10);
        lua_pushvalue(L, 1);
        lua_call(L, 0, 1);
        if (lua_isnil(L, -1)) {
            lua_pop(L, 1);
            break;
        }
        if (!lua_isstring(L, -1))
            luaL_error(L, "reader function must return a string");
        length = lua_rawlen(L, -1);
        lua_tolstring(L, -1, &length);
        total += length;
        luaL_addvalue(&b);
    }
    luaL_pushresult(&b);
}

/* load(chunk [, name [, mode [, env]]]): text only, whatever the mode asks, and at most 4 MiB */
static int base_load(lua_State *L)
{
    int n = lua_gettop(L);
    size_t size;
    bool text = lua_isstring(L, 1);
    if (!text) {
        luaL_checktype(L, 1, LUA_TFUNCTION);
        join_pieces(L);
    } else {
        lua_pushvalue(L, 1);
    }
    const char *chunk = lua_tolstring(L, -1, &size), *name = luaL_optstring(L, 2, text ? chunk : "=(load)");
    app_charge(L, size);
    if (size > LOAD_LIMIT) {
        luaL_pushfail(L);
        lua_pushliteral(L, "load: the chunk has more than 4 MiB");
        return 2;
    }
    if (luaL_loadbufferx(L, chunk, size, name, "t") != LUA_OK) {
        luaL_pushfail(L);
        lua_insert(L, -2);
        return 2;
    }
    if (n >= 4) {
        lua_pushvalue(L, 4);
        if (!lua_setupvalue(L, -2, 1))
            lua_pop(L, 1);
    }
    return 1;
}

/* ---- the rest of the base ------------------------------------------------------------------ */

/* Is the value at 1 _G, with the metatable that it had at first? That one holds `require` and is not shown. */
static bool is_first_globals(lua_State *L)
{
    bool same = false;
    if (lua_istable(L, 1) && lua_getmetatable(L, 1)) {
        lua_getfield(L, LUA_REGISTRYINDEX, "digbox.globals");
        same = lua_rawequal(L, -1, -2);
        lua_pop(L, 2);
    }
    return same;
}

/* upvalue: the library's own */
static int base_getmetatable(lua_State *L)
{
    luaL_checkany(L, 1);
    if (is_first_globals(L))
        return 0;
    lua_settop(L, 1);
    return lib_call_first(L);
}

/* setmetatable without finalizers. A script that gives _G another metatable finds `require` in _G itself. upvalue: the library's own */
static int base_setmetatable(lua_State *L)
{
    if (is_first_globals(L)) {
        lua_getglobal(L, "require");
        lua_pushliteral(L, "require");
        lua_insert(L, -2);
        lua_rawset(L, 1);
    }
    if (lua_istable(L, 2)) {
        lua_pushliteral(L, "__gc");
        if (lua_rawget(L, 2) != LUA_TNIL)
            return bind_error(L, "setmetatable: __gc is not available to scripts");
    }
    lua_settop(L, 2);
    return lib_call_first(L);
}

static int base_collectgarbage(lua_State *L)
{
    if (strcmp(luaL_optstring(L, 1, "collect"), "count") != 0)
        return bind_error(L, "collectgarbage: only \"count\" is available to scripts");
    lua_pushnumber(L, (lua_Number)app_of(L)->memory_used / 1024);
    return 1;
}

/* ---- require ------------------------------------------------------------------------- */

bool lib_push_source(lua_State *L, const char *path)
{
    struct stat info;
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        lua_pushfstring(L, "%s: %s", path, S_ISDIR(info.st_mode) ? strerror(EISDIR) : "not a regular file");
        return false;
    }
    FILE *f = fopen(path, "rb");
    if (!f) {
        lua_pushfstring(L, "%s: %s", path, strerror(errno));
        return false;
    }
    luaL_Buffer b;
    size_t total = 0, got;
    luaL_buffinit(L, &b);
    do {
        char *room = luaL_prepbuffer(&b);
        got = fread(room, 1, LUAL_BUFFERSIZE, f);
        luaL_addsize(&b, got);
        total += got;
    } while (got > 0 && total <= SCRIPT_LIMIT);
    int error = ferror(f) ? errno : 0;
    fclose(f);
    luaL_pushresult(&b);
    if (error == 0 && total <= SCRIPT_LIMIT)
        return true;
    lua_pop(L, 1);
    lua_pushfstring(L, "%s: %s", path, error ? strerror(error) : "more than 16 MiB: not a script");
    return false;
}

/* A hash of all source text that was loaded so far: what a frame looks like depends on it. */
static void note_source(lua_State *L, const char *text, size_t size)
{
    char hash[17];
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.sources");
    const char *before = lua_tostring(L, -1);
    app_hash(text, size, hash);
    lua_pushfstring(L, "%s%s", before ? before : "", hash);
    app_hash(lua_tostring(L, -1), lua_rawlen(L, -1), hash);
    lua_pushstring(L, hash);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.sources");
    lua_pop(L, 2);
}

int lib_load_source(lua_State *L, const char *path)
{
    size_t size;
    const char *text = lua_tolstring(L, -1, &size);
    note_source(L, text, size);
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        text += 3;
        size -= 3;
    }
    if (size > 0 && text[0] == LUA_SIGNATURE[0]) {
        lua_pop(L, 1);
        lua_pushfstring(L, "%s: precompiled Lua is not accepted", path);
        return LUA_ERRSYNTAX;
    }
    if (size > 0 && text[0] == '#')
        while (size > 0 && *text != '\n') {
            text++;
            size--;
        }
    lua_pushfstring(L, "@%s", path);
    int status = luaL_loadbufferx(L, text, size, lua_tostring(L, -1), "t");
    lua_replace(L, -3);
    lua_pop(L, 1);
    return status;
}

/* Where module "a.b" lies: a/b.lua in the script's folder, really in there. */
static bool push_module_path(lua_State *L, const char *name)
{
    char real_module[PATH_MAX], real_folder[PATH_MAX];
    const char *script = app_of(L)->script, *slash = strrchr(script, '/');
    size_t length = strlen(name);
    if (length == 0 || length > 200 || length != lua_rawlen(L, 1) || strstr(name, "..") || name[0] == '.' ||
        strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-") != length)
        return false;
    lua_pushlstring(L, script, slash ? (size_t)(slash - script) + 1 : 0);
    luaL_gsub(L, name, ".", "/");
    lua_pushliteral(L, ".lua");
    lua_concat(L, 3);
    lua_pushlstring(L, script, slash ? (size_t)(slash - script) + 1 : 0);
    const char *folder = *lua_tostring(L, -1) ? lua_tostring(L, -1) : ".";
    bool inside = realpath(lua_tostring(L, -2), real_module) && realpath(folder, real_folder);
    if (inside) {
        size_t n = strlen(real_folder);
        inside = strncmp(real_module, real_folder, n) == 0 && (real_module[n] == '/' || real_folder[n - 1] == '/');
    }
    lua_pop(L, 1);
    if (!inside)
        lua_pop(L, 1);
    return inside;
}

/* upvalue 1 lists the modules that are being loaded, too: by number, in their order. */
static void note_loading(lua_State *L, bool begins)
{
    lua_Integer n = (lua_Integer)lua_rawlen(L, lua_upvalueindex(1));
    if (begins)
        lua_pushvalue(L, 1);
    else
        lua_pushnil(L);
    lua_rawseti(L, lua_upvalueindex(1), begins ? n + 1 : n);
}

/* Module 'a' requires itself via b, c. */
static int refuse_cycle(lua_State *L, const char *name)
{
    int n = (int)lua_rawlen(L, lua_upvalueindex(1)), found = n;
    for (int i = n; i >= 1; i--) {
        lua_rawgeti(L, lua_upvalueindex(1), i);
        if (strcmp(lua_tostring(L, -1), name) == 0)
            found = i;
        lua_pop(L, 1);
    }
    lua_pushliteral(L, "");
    for (int i = found + 1; i <= n; i++) {
        lua_rawgeti(L, lua_upvalueindex(1), i);
        lua_pushfstring(L, "%s%s%s", lua_tostring(L, -2), i == found + 1 ? " via " : ", ", lua_tostring(L, -1));
        lua_replace(L, -3);
        lua_pop(L, 1);
    }
    return bind_error(L, "module '%s' requires itself%s", name, lua_tostring(L, -1));
}

/* Runs the module named at 1; leaves its value. upvalue 1 says meanwhile that it is being loaded. */
static void load_module(lua_State *L, const char *name)
{
    if (!push_module_path(L, name)) {
        bind_error(L, "module '%s' not found beside the script", name);
        return;
    }
    const char *path = lua_tostring(L, -1);
    if (!lib_push_source(L, path) || lib_load_source(L, path) != LUA_OK)
        lua_error(L);
    lua_pushvalue(L, 1);
    lua_pushboolean(L, 0);
    lua_rawset(L, lua_upvalueindex(1));
    note_loading(L, true);
    lua_pushvalue(L, 1);
    int status = lua_pcall(L, 1, 1, 0);
    note_loading(L, false);
    if (status != LUA_OK) {
        lua_pushvalue(L, 1);
        lua_pushnil(L);
        lua_rawset(L, lua_upvalueindex(1));
        lua_error(L);
    }
    if (lua_isnil(L, -1)) {
        lua_pop(L, 1);
        lua_pushboolean(L, 1);
    }
}

/* require(name): digbox, digbox.NAME, or a text module beside the script. upvalue: table of what is loaded */
static int base_require(lua_State *L)
{
    const char *name = bind_string(L, 1, NULL);
    lua_settop(L, 1);
    lua_pushvalue(L, 1);
    if (lua_rawget(L, lua_upvalueindex(1)) == LUA_TBOOLEAN && !lua_toboolean(L, -1))
        return refuse_cycle(L, name);
    if (!lua_isnil(L, -1))
        return 1;
    if (strcmp(name, "digbox") == 0 || strcmp(name, "digbox.test") == 0)
        bind_use(L, strcmp(name, "digbox") == 0 ? "init" : "test");
    else
        load_module(L, name);
    lua_pushvalue(L, 1);
    lua_pushvalue(L, -2);
    lua_rawset(L, lua_upvalueindex(1));
    return 1;
}

/* ---- the lists ---------------------------------------------------------------------------- */

const LibEntry lib_base[] = {
    {"assert", NULL, false},   {"error", NULL, false},        {"getmetatable", base_getmetatable, false}, {"ipairs", NULL, false},
    {"pcall", NULL, false},    {"rawequal", NULL, false},     {"rawget", NULL, false},       {"rawlen", NULL, false},
    {"rawset", NULL, false},   {"select", NULL, false},       {"tonumber", NULL, true},      {"type", NULL, false},
    {"xpcall", NULL, false},   {"print", base_print, false},  {"tostring", base_tostring, false},
    {"load", base_load, false}, {"collectgarbage", base_collectgarbage, false}, {NULL, NULL, false},
};

static const LibEntry math_entries[] = {
    {"abs", NULL, false},   {"acos", NULL, false}, {"asin", NULL, false},       {"atan", NULL, false}, {"ceil", NULL, false},
    {"cos", NULL, false},   {"deg", NULL, false},  {"exp", NULL, false},        {"floor", NULL, false}, {"fmod", NULL, false},
    {"huge", NULL, false},  {"log", NULL, false},  {"max", NULL, false},        {"maxinteger", NULL, false}, {"min", NULL, false},
    {"mininteger", NULL, false}, {"modf", NULL, false}, {"pi", NULL, false},    {"rad", NULL, false},  {"random", NULL, false},
    {"randomseed", NULL, false}, {"sin", NULL, false}, {"sqrt", NULL, false},   {"tan", NULL, false},  {"tointeger", NULL, false},
    {"type", NULL, false},  {"ult", NULL, false},  {NULL, NULL, false},
};

static const LibEntry utf8_entries[] = {
    {"char", NULL, false}, {"charpattern", NULL, false}, {"codepoint", NULL, true}, {"codes", NULL, false}, {"len", NULL, true},
    {"offset", NULL, true}, {NULL, NULL, false},
};

/* Charges the bytes of its text arguments. upvalue: the library's own */
static int charged(lua_State *L)
{
    int n = lua_gettop(L);
    size_t work = 1;
    for (int i = 1; i <= n; i++)
        if (lua_type(L, i) == LUA_TSTRING)
            work += lua_rawlen(L, i) / BYTES_A_UNIT;
    app_charge(L, work);
    return lib_call_first(L);
}

/* Notes that the C function on the top may be there. */
static void allow(lua_State *L)
{
    if (!lua_iscfunction(L, -1))
        return;
    luaL_getsubtable(L, LUA_REGISTRYINDEX, "digbox.allowed");
    lua_pushvalue(L, -2);
    lua_pushboolean(L, 1);
    lua_rawset(L, -3);
    lua_pop(L, 1);
}

/* Puts the entries into the table on the top; Lua's own come from the library at `from`. */
static void fill(lua_State *L, const LibEntry *entries, int from)
{
    for (const LibEntry *e = entries; e->name; e++) {
        lua_getfield(L, from, e->name);
        if (lua_isnil(L, -1))
            luaL_error(L, "Lua's library lacks '%s'", e->name);
        if (e->own)
            lua_pushcclosure(L, e->own, 1);
        else if (e->work)
            lua_pushcclosure(L, charged, 1);
        allow(L);
        lua_setfield(L, -2, e->name);
    }
}

/* Opens one of Lua's libraries aside and makes ours of it, a global. */
static void make_library(lua_State *L, const char *name, lua_CFunction open, const LibEntry *entries)
{
    lua_pushcfunction(L, open);
    lua_pushstring(L, name);
    lua_call(L, 1, 1);
    lua_newtable(L);
    fill(L, entries, lua_gettop(L) - 1);
    lua_setglobal(L, name);
    lua_pop(L, 1);
}

/* A global that is not there is nil, but words that mean something elsewhere are not meant to be nothing: `fixed = True`. */
static int refuse_foreign(lua_State *L)
{
    static const struct { const char *word, *here; } words[] = {
        {"True", "true"}, {"TRUE", "true"}, {"False", "false"}, {"FALSE", "false"}, {"None", "nil"}, {"null", "nil"}, {"NULL", "nil"},
        {"nullptr", "nil"}, {"undefined", "nil"},
    };
    const char *key = lua_type(L, 2) == LUA_TSTRING ? lua_tostring(L, 2) : "";
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcmp(words[i].word, key) == 0)
            return bind_error(L, "there is no '%s': Lua writes %s", key, words[i].here);
    return 0;
}

/* `require` is no field of _G (the table on the top) but found by its metatable. */
static void make_require(lua_State *L)
{
    lua_createtable(L, 0, 1);
    lua_createtable(L, 0, 1);
    lua_newtable(L);
    lua_pushcclosure(L, base_require, 1);
    allow(L);
    lua_setfield(L, -2, "require");
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, refuse_foreign);
    allow(L);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
    lua_setfield(L, -2, "__index");
    lua_pushvalue(L, -1);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.globals");
    lua_setmetatable(L, -2);
}

/* pairs and next of the table on the top */
static void set_order(lua_State *L, bool strict)
{
    lib_push_order(L, strict);
    allow(L);
    lua_setfield(L, -3, "pairs");
    allow(L);
    lua_setfield(L, -2, "next");
}

void lib_finish(lua_State *L)
{
    lua_pushglobaltable(L);
    set_order(L, true);
    lua_pop(L, 1);
}

/* luaopen_base writes into the table of globals: it is given, and emptied into ours. */
static void make_base(lua_State *L)
{
    lua_pushglobaltable(L);
    lua_pushcfunction(L, luaopen_base);
    lua_call(L, 0, 1);                          /* the same table */
    lua_newtable(L);
    int theirs = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, theirs - 1); ) {
        lua_pushvalue(L, -2);
        lua_insert(L, -2);
        lua_rawset(L, theirs);
        lua_pushvalue(L, -1);                   /* clearing a field that exists is allowed on the way */
        lua_pushnil(L);
        lua_rawset(L, theirs - 1);
    }
    lua_pushvalue(L, theirs - 1);
    fill(L, lib_base, theirs);
    lua_pushvalue(L, -1);
    lua_setfield(L, -2, "_G");
    lua_pushliteral(L, LUA_VERSION);
    lua_setfield(L, -2, "_VERSION");
    lua_getfield(L, theirs, "setmetatable");
    lua_pushcclosure(L, base_setmetatable, 1);
    allow(L);
    lua_setfield(L, -2, "setmetatable");
    make_require(L);
    set_order(L, false);
    lua_settop(L, theirs - 3);
}

/* Methods of strings stand in a table of our own, so that a script that clears `string` spoils neither the core's texts nor its own
 * report; what it adds to `string` is found after them. The metatable is out of reach. */
static void lock_strings(lua_State *L)
{
    lua_pushliteral(L, "");
    lua_getmetatable(L, -1);
    lua_newtable(L);
    lua_getglobal(L, "string");
    for (lua_pushnil(L); lua_next(L, -2); ) {
        lua_pushvalue(L, -2);
        lua_insert(L, -2);
        lua_rawset(L, -5);
    }
    lua_newtable(L);
    lua_insert(L, -2);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
    lua_setfield(L, -2, "__index");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
        allow(L);
    lua_pop(L, 2);
}

/* With --trust: io and os of Lua, whole. */
static void open_trusted(lua_State *L)
{
    static const luaL_Reg trusted[] = {{LUA_IOLIBNAME, luaopen_io}, {LUA_OSLIBNAME, luaopen_os}, {NULL, NULL}};
    for (const luaL_Reg *l = trusted; l->name; l++) {
        luaL_requiref(L, l->name, l->func, 1);
        for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
            allow(L);
        lua_pop(L, 1);
    }
}

void lib_open(lua_State *L, bool trust)
{
    make_base(L);
    make_library(L, LUA_STRLIBNAME, luaopen_string, lib_string);
    make_library(L, LUA_TABLIBNAME, luaopen_table, lib_table);
    make_library(L, LUA_COLIBNAME, luaopen_coroutine, lib_coroutine);
    make_library(L, LUA_MATHLIBNAME, luaopen_math, math_entries);
    make_library(L, LUA_UTF8LIBNAME, luaopen_utf8, utf8_entries);
    lock_strings(L);
    if (trust)
        open_trusted(L);
}

/* ---- the check at the start ------------------------------------------------------------------ */

enum { CHECK_SEEN = 1, CHECK_ALLOWED = 2 };     /* places on the stack */

static void check_value(lua_State *L, const char *path);

static void check_table(lua_State *L, int t, const char *path)
{
    for (lua_pushnil(L); lua_next(L, t); lua_pop(L, 1)) {
        char inner[256];
        snprintf(inner, sizeof inner, "%s%s%.60s", path, *path ? "." : "",
                 lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : luaL_typename(L, -2));
        check_value(L, inner);
        lua_pushvalue(L, -2);
        check_value(L, inner);
        lua_pop(L, 1);
    }
}

/* The value on the top, and what can be reached from it. */
static void check_value(lua_State *L, const char *path)
{
    int v = lua_gettop(L);
    luaL_checkstack(L, 16, "check of the sandbox");
    if (lua_iscfunction(L, v)) {
        lua_pushvalue(L, v);
        if (lua_rawget(L, CHECK_ALLOWED) == LUA_TNIL)
            luaL_error(L, "the sandbox is not tight: '%s' is on no list", path);
        lua_settop(L, v);
        return;
    }
    bool light = lua_type(L, v) == LUA_TLIGHTUSERDATA || lua_type(L, v) == LUA_TTHREAD;
    if (light)
        luaL_error(L, "the sandbox is not tight: '%s' is a %s", path, luaL_typename(L, v));
    if (!lua_istable(L, v) && !lua_isuserdata(L, v))
        return;
    lua_pushvalue(L, v);
    if (lua_rawget(L, CHECK_SEEN) == LUA_TNIL) {
        lua_pushvalue(L, v);
        lua_pushboolean(L, 1);
        lua_rawset(L, CHECK_SEEN);
        if (lua_istable(L, v))
            check_table(L, v, path);
        if (lua_getmetatable(L, v)) {
            lua_getfield(L, -1, "__metatable");         /* locked: getmetatable gives that instead */
            if (lua_isnil(L, -1))
                lua_pop(L, 1);
            check_value(L, path);
        }
    }
    lua_settop(L, v);
}

static int check_all(lua_State *L)
{
    lua_newtable(L);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, "digbox.allowed");
    lua_pushglobaltable(L);
    check_value(L, "");
    lua_pushliteral(L, "");
    if (!lua_getmetatable(L, -1))
        return luaL_error(L, "the sandbox is not tight: strings have lost their metatable");
    lua_getfield(L, -1, "__metatable");
    if (lua_isnil(L, -1) || lua_toboolean(L, -1))
        return luaL_error(L, "the sandbox is not tight: the metatable of strings can be reached");
    return 0;
}

void lib_check(lua_State *L)
{
    lua_pushcfunction(L, check_all);
    lua_call(L, 0, 0);
}
