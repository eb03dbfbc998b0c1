/* lua/bind.c - types, errors at the script's line, and opening the module. */

#include "bind.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

enum { LIST_LIMIT = 600 };      /* bytes of names listed in an error */

/* ---- errors ------------------------------------------------------------------ */

static void push_line(lua_State *L, const char *format)
{
    lua_Debug ar;
    for (int level = 0; lua_getstack(L, level, &ar); level++) {
        lua_getinfo(L, "Sl", &ar);
        if (ar.source[0] == '@' && ar.currentline > 0) {
            lua_pushfstring(L, format, ar.source + 1, ar.currentline);
            return;
        }
    }
    lua_pushliteral(L, "");
}

void bind_where(lua_State *L) { push_line(L, "%s:%d: "); }

void bind_place(lua_State *L) { push_line(L, "%s:%d"); }

const char *bind_text(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    int kind = lua_type(L, index);
    if (kind == LUA_TNIL || kind == LUA_TBOOLEAN || kind == LUA_TNUMBER || kind == LUA_TSTRING)
        return luaL_tolstring(L, index, NULL);
    if (luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        lua_pop(L, 1);
        return luaL_tolstring(L, index, NULL);
    }
    if (luaL_getmetafield(L, index, "__name") != LUA_TSTRING)
        lua_pushstring(L, lua_typename(L, kind));
    return lua_tostring(L, -1);
}

const char *bind_string(lua_State *L, int index, const char *what)
{
    size_t length;
    const char *text = luaL_checklstring(L, index, &length);
    if (strlen(text) != length) {
        bind_error(L, "%s%s'%s' is followed by a NUL byte, which no name and no number holds", what ? what : "", what ? ": " : "",
                   luaL_gsub(L, text, "\n", " "));
    }
    return text;
}

const char *bind_name(lua_State *L, int index, const char *what)
{
    if (lua_type(L, index) == LUA_TSTRING)
        bind_string(L, index, what);
    return bind_text(L, index);
}

static int raise_text(lua_State *L, const char *format, va_list arguments)
{
    char text[2048];
    vsnprintf(text, sizeof text, format, arguments);
    text_clean(text);            /* what a script gave may hold line feeds and escapes: they are not to reach a terminal */
    bind_where(L);
    lua_pushstring(L, text);
    lua_concat(L, 2);
    return lua_error(L);
}

int bind_error(lua_State *L, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    raise_text(L, format, arguments);
    va_end(arguments);
    return 0;
}

static int exit_code_of(dig_status status)
{
    switch (status) {
    case DIG_E_MEMORY: return 3;
    case DIG_E_FINITE: return 10;
    case DIG_E_FILE: return 9;
    case DIG_E_FORMAT: return 8;
    default: return 1;
    }
}

int bind_fail_text(lua_State *L, dig_status status, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    bind_where(L);
    lua_pushstring(L, text);
    lua_concat(L, 2);
    lua_pushvalue(L, -1);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.failure");
    lua_pushinteger(L, exit_code_of(status));
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.failure_code");
    return lua_error(L);
}

int bind_fail(lua_State *L, const dig_world *w, dig_status status)
{
    const char *text = w ? dig_error(w) : NULL;
    return bind_fail_text(L, status, "%s", text && *text ? text : dig_status_name(status));
}

int bind_exit_code(lua_State *L, const char *message)
{
    int code = 1;
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.failure");
    const char *failure = lua_tostring(L, -1);
    if (failure && message && strstr(message, failure)) {
        lua_getfield(L, LUA_REGISTRYINDEX, "digbox.failure_code");
        code = (int)lua_tointeger(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return code;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

const char **bind_names(lua_State *L, int first, int last, int *count)
{
    int n = 0;
    for (int t = first; t <= last; t++)
        for (lua_pushnil(L); lua_next(L, t); lua_pop(L, 1))
            n += lua_type(L, -2) == LUA_TSTRING;
    const char **names = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *names, 0);
    *count = 0;
    for (int t = first; t <= last; t++)
        for (lua_pushnil(L); lua_next(L, t); lua_pop(L, 1))
            if (lua_type(L, -2) == LUA_TSTRING && *count < n)
                names[(*count)++] = lua_tostring(L, -2);
    qsort((void *)names, (size_t)*count, sizeof *names, compare_names);
    return names;
}

int bind_unknown(lua_State *L, const char *what, const char *kind, const char *name, int first, int last)
{
    int count;
    char known[LIST_LIMIT + 8] = "";
    luaL_checkstack(L, 8, "too many values");
    const char **names = bind_names(L, first, last, &count);
    const char *near = bind_mean(name, names, count);
    const char *note = near ? NULL : bind_mean_note(name, names, count);
    if (note)
        return bind_error(L, "%s %s '%.60s' (%s)", what, kind, name, note);
    if (!near && strlen(name) > 1)      /* any letter is one edit from any other */
        near = dig_suggest(name, names, count);
    if (near)
        return bind_error(L, "%s %s '%.60s' (did you mean '%s'?)", what, kind, name, near);
    size_t used = 0;
    for (int i = 0; i < count; i++) {
        size_t length = strlen(names[i]);
        if (names[i][0] == '_' || (i > 0 && strcmp(names[i], names[i - 1]) == 0))
            continue;
        if (used + length + 2 > LIST_LIMIT) {
            used += (size_t)snprintf(known + used, sizeof known - used, " ...");
            break;
        }
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", names[i]);
    }
    if (used == 0)
        return bind_error(L, "%s %s '%.60s': it has none", what, kind, name);
    return bind_error(L, "%s %s '%.60s' (known: %s)", what, kind, name, known);
}

/* ---- types -------------------------------------------------------------------- */

/* upvalues: methods, getters, type name, fallback or nil */
static int object_index(lua_State *L)
{
    if (lua_type(L, 2) == LUA_TSTRING) {
        lua_pushvalue(L, 2);
        if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL)
            return 1;
        lua_pushvalue(L, 2);
        if (lua_rawget(L, lua_upvalueindex(2)) != LUA_TNIL) {
            lua_pushvalue(L, 1);
            lua_call(L, 1, 1);
            return 1;
        }
        lua_settop(L, 2);
    }
    if (!lua_isnil(L, lua_upvalueindex(4))) {
        lua_pushvalue(L, lua_upvalueindex(4));
        lua_pushvalue(L, 1);
        lua_pushvalue(L, 2);
        int before = lua_gettop(L) - 3;
        lua_call(L, 2, LUA_MULTRET);
        if (lua_gettop(L) > before)
            return 1;
    }
    const char *key = bind_name(L, 2, NULL);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_pushvalue(L, lua_upvalueindex(2));
    int top = lua_gettop(L);
    return bind_unknown(L, lua_tostring(L, lua_upvalueindex(3)), "has no field or method", key, top - 1, top);
}

static int read_only(lua_State *L)
{
    const char *key = bind_name(L, 2, NULL);
    if (luaL_testudata(L, 1, BIND_VEC))
        return bind_error(L, "vector.%s cannot be assigned: vectors do not change, make another ({x, y, z}; body:teleport{ at = ... })", key);
    return bind_error(L, "%s.%s cannot be assigned", lua_tostring(L, lua_upvalueindex(1)), key);
}

void bind_type(lua_State *L, int core, const char *name, const luaL_Reg *methods, const luaL_Reg *getters, lua_CFunction fallback,
               const luaL_Reg *metamethods)
{
    luaL_newmetatable(L, name);
    lua_newtable(L);
    luaL_setfuncs(L, methods, 0);
    lua_newtable(L);
    if (getters)
        luaL_setfuncs(L, getters, 0);

    lua_getfield(L, core, "types");
    lua_newtable(L);
    lua_pushvalue(L, -4);
    lua_setfield(L, -2, "methods");
    lua_pushvalue(L, -3);
    lua_setfield(L, -2, "getters");
    lua_pushvalue(L, -5);
    lua_setfield(L, -2, "meta");
    lua_setfield(L, -2, name);
    lua_pop(L, 1);

    lua_pushstring(L, name);
    if (fallback)
        lua_pushcfunction(L, fallback);
    else
        lua_pushnil(L);
    lua_pushcclosure(L, object_index, 4);
    lua_setfield(L, -2, "__index");
    lua_pushstring(L, name);
    lua_pushcclosure(L, read_only, 1);
    lua_setfield(L, -2, "__newindex");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    luaL_setfuncs(L, metamethods, 0);
    lua_pop(L, 1);
}

void bind_held_type(lua_State *L, const char *name, lua_CFunction gc)
{
    luaL_newmetatable(L, name);
    lua_pushcfunction(L, gc);
    lua_setfield(L, -2, "__gc");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 1);
}

void bind_extend(lua_State *L, int core, const char *type, const luaL_Reg *methods)
{
    lua_getfield(L, core, "types");
    lua_getfield(L, -1, type);
    lua_getfield(L, -1, "methods");
    luaL_setfuncs(L, methods, 0);
    lua_pop(L, 3);
}

/* Pushes the name of the type of which the function at index 1 is a method, and that of the method; or nothing. */
static bool push_method_name(lua_State *L)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "types");
    int types = lua_gettop(L);
    for (lua_pushnil(L); lua_next(L, types); lua_pop(L, 1)) {
        lua_getfield(L, -1, "methods");
        for (lua_pushnil(L); lua_next(L, types + 3); lua_pop(L, 1))
            if (lua_rawequal(L, -1, 1)) {
                lua_pushvalue(L, types + 1);
                lua_pushvalue(L, types + 4);
                return true;
            }
        lua_pop(L, 1);
    }
    return false;
}

static int function_index(lua_State *L)
{
    lua_settop(L, 2);
    if (push_method_name(L)) {
        const char *type = lua_tostring(L, -2), *method = lua_tostring(L, -1);
        return bind_error(L, "%s is a method: %s:%s()", method, type, method);
    }
    const char *key = bind_name(L, 2, NULL);
    return bind_error(L, "attempt to index a function value (field '%s')", key);
}

/* #world.bodies */
static int function_length(lua_State *L)
{
    lua_settop(L, 1);
    if (!push_method_name(L))
        return bind_error(L, "attempt to get length of a function value");
    const char *type = lua_tostring(L, -2), *method = lua_tostring(L, -1);
    return bind_error(L, "%s is a method: #%s:%s()", method, type, method);
}

void bind_hint_methods(lua_State *L)
{
    lua_pushcfunction(L, function_index);
    lua_createtable(L, 0, 3);
    lua_pushcfunction(L, function_length);
    lua_setfield(L, -2, "__len");
    lua_pushcfunction(L, function_index);
    lua_setfield(L, -2, "__index");
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    lua_setmetatable(L, -2);            /* of all functions */
    lua_pop(L, 1);
}

/* ---- opening ------------------------------------------------------------------------------ */

static const struct digbox_source *find_source(const char *name)
{
    for (const struct digbox_source *s = digbox_embedded; s->name; s++)
        if (strcmp(s->name, name) == 0)
            return s;
    return NULL;
}

bool bind_use(lua_State *L, const char *name)
{
    const struct digbox_source *s = find_source(name);
    if (!s)
        return false;
    luaL_getsubtable(L, LUA_REGISTRYINDEX, "digbox.loaded");
    if (lua_getfield(L, -1, name) == LUA_TNIL) {
        lua_pop(L, 1);
        char chunk[64];
        snprintf(chunk, sizeof chunk, "=digbox/%s.lua", name);
        if (luaL_loadbufferx(L, s->text, s->size, chunk, "t") != LUA_OK)
            lua_error(L);
        lua_getfield(L, LUA_REGISTRYINDEX, "digbox.env");
        lua_setupvalue(L, -2, 1);
        lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
        lua_call(L, 1, 1);
        if (lua_isnil(L, -1)) {
            lua_pop(L, 1);
            lua_pushboolean(L, 1);
        }
        lua_pushvalue(L, -1);
        lua_setfield(L, -3, name);
    }
    lua_remove(L, -2);
    return true;
}

/* core.use(name) -> the value of an embedded file */
static int core_use(lua_State *L)
{
    const char *name = luaL_checkstring(L, 1);
    if (!bind_use(L, name))
        return bind_error(L, "no embedded file '%s'", name);
    return 1;
}

/* core.fail(format, ...) raises with the script's position */
static int core_fail(lua_State *L)
{
    int n = lua_gettop(L);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.env");
    lua_getfield(L, -1, "string");
    lua_getfield(L, -1, "format");
    lua_insert(L, 1);
    lua_settop(L, n + 1);
    lua_call(L, n, 1);
    return bind_error(L, "%s", lua_tostring(L, -1));
}

/* core.where() -> "world.lua:12: " */
static int core_where(lua_State *L)
{
    bind_where(L);
    return 1;
}

/* core.unknown(what, kind, name, table...) raises "what kind 'name' (did you mean ...)" */
static int core_unknown(lua_State *L)
{
    return bind_unknown(L, luaL_checkstring(L, 1), luaL_checkstring(L, 2), luaL_checkstring(L, 3), 4, lua_gettop(L));
}

/* core.raise(code, message): no position; the program ends with that exit code if nobody catches it */
static int core_raise(lua_State *L)
{
    lua_pushvalue(L, 1);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.failure_code");
    lua_pushvalue(L, 2);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.failure");
    lua_settop(L, 2);
    return lua_error(L);
}

/* Where the stack still stands: Lua's own words for it have no position (those of lua/lib_coroutine.c have one), and name what no
 * script sees. */
static int handle_yield(lua_State *L)
{
    static const char *const lua_says[] = {"attempt to yield across a C-call boundary", "attempt to yield from outside a coroutine"};
    size_t length = 0;
    const char *text = lua_type(L, 1) == LUA_TSTRING ? lua_tolstring(L, 1, &length) : "";
    bool yields = false;
    for (int i = 0; i < 2; i++) {
        size_t n = strlen(lua_says[i]);
        yields = yields || (length >= n && strcmp(text + length - n, lua_says[i]) == 0);
    }
    if (yields) {
        bind_where(L);
        lua_pushliteral(L, "cannot yield here: the world waits for this function to return");
        lua_concat(L, 2);
    }
    return 1;
}

/* core.call(f, ...) -> as pcall, but what it calls cannot leave it by a yield */
static int core_call(lua_State *L)
{
    lua_pushcfunction(L, handle_yield);
    lua_insert(L, 1);
    bool fine = lua_pcall(L, lua_gettop(L) - 2, LUA_MULTRET, 1) == LUA_OK;
    lua_pushboolean(L, fine);
    lua_replace(L, 1);
    return lua_gettop(L);
}

/* core.poll(): before each step. The program puts its own in place, which stops at Ctrl-C and at limits. */
static int core_poll(lua_State *L)
{
    (void)L;
    return 0;
}

static const luaL_Reg core_functions[] = {
    {"use", core_use}, {"fail", core_fail}, {"where", core_where}, {"unknown", core_unknown}, {"raise", core_raise},
    {"poll", core_poll}, {"call", core_call}, {NULL, NULL},
};

static void copy_table(lua_State *L, int from)
{
    from = lua_absindex(L, from);
    lua_newtable(L);
    for (lua_pushnil(L); lua_next(L, from); lua_pop(L, 1)) {
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, -5);
    }
}

/* The embedded files see copies of the libraries, so that a script which changes a global does not change them. */
static void make_environment(lua_State *L)
{
    static const char *const libraries[] = {"string", "table", "math", "coroutine"};
    lua_pushglobaltable(L);
    copy_table(L, -1);
    for (size_t i = 0; i < sizeof libraries / sizeof *libraries; i++) {
        lua_getfield(L, -1, libraries[i]);
        copy_table(L, -1);
        lua_setfield(L, -3, libraries[i]);
        lua_pop(L, 1);
    }
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.env");
    lua_pop(L, 1);
}

int bind_open(lua_State *L)
{
    make_environment(L);
    lua_newtable(L);
    int core = lua_gettop(L);
    lua_pushglobaltable(L);
    lua_setfield(L, core, "globals");
    lua_newtable(L);
    lua_setfield(L, core, "types");
    lua_newtable(L);
    lua_setfield(L, core, "options");
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.fields");        /* declare.lua fills it */
    lua_setfield(L, core, "fields");
    luaL_setfuncs(L, core_functions, 0);
    lua_pushvalue(L, core);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.core");
    bind_vec_open(L, core);
    bind_world_open(L, core);
    bind_space_open(L, core);
    bind_watch_open(L, core);
    bind_aside_open(L, core);
    bind_trace_open(L, core);
    bind_replay_open(L, core);
    bind_reader_open(L, core);
    bind_json_open(L, core);
    bind_past_open(L, core);
    bind_region_open(L, core);
    bind_body_open(L, core);
    bind_ask_open(L, core);
    bind_effect_open(L, core);
    bind_own_open(L, core);
    bind_message_open(L, core);
    bind_frozen_open(L, core);
    bind_mean_open(L, core);
    bind_hint_open(L, core);
    bind_shape_open(L, core);
    bind_joint_open(L, core);
    bind_graph_open(L, core);
    bind_film_open(L, core);
    bind_frames_open(L, core);
    bind_file_open(L, core);
    bind_schema_open(L, core);
    lua_settop(L, core - 1);
    bind_use(L, "init");
    return 1;
}

/* For a plain lua5.4: require "digbox" of digbox.so. */
int luaopen_digbox(lua_State *L)
{
    return bind_open(L);
}

/* require "digbox.test" finds it in the same file, whether or not "digbox" is open already. */
int luaopen_digbox_test(lua_State *L)
{
    lua_getglobal(L, "require");
    lua_pushliteral(L, "digbox");
    lua_call(L, 1, 0);
    bind_use(L, "test");
    return 1;
}
