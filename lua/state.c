/* lua/state.c - the sandboxed Lua state of the program: what scripts may use, limits, signals, require. */

#define _XOPEN_SOURCE 700       /* sigaction, realpath, clock_gettime */

#include "state.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <lualib.h>

#include "bind.h"

enum { HOOK_EVERY = 100000, SCRIPT_LIMIT = 16 * 1024 * 1024 };

/* ---- signals --------------------------------------------------------------- */

enum { PATIENCE = 10 };         /* s from the first signal to the end of a script that does not respond */

static volatile sig_atomic_t caught;

static void on_signal(int number)
{
    if (caught)
        _exit(128 + number);
    caught = number;
    alarm(PATIENCE);
}

/* A C function of Lua can run for ever without a hook being called: the last resort of limits and of signals. Films end torn
 * under their temporary names only. */
static void on_alarm(int number)
{
    static const char text[] = "digbox: the script does not respond; killed\n";
    (void)number;
    ssize_t ignored = write(2, text, sizeof text - 1);
    (void)ignored;
    _exit(caught ? 128 + caught : EXIT_TIME);
}

void app_limit_time(App *app, double seconds)
{
    app->deadline = app_clock() + seconds;
    alarm((unsigned)(1.5 * seconds) + 1);
}

void app_catch_signals(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    action.sa_handler = on_alarm;
    sigaction(SIGALRM, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
#ifdef SIGXFSZ
    signal(SIGXFSZ, SIG_IGN);
#endif
}

int app_signal(void)
{
    return caught;
}

double app_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- limits ---------------------------------------------------------------- */

static App *app_of(lua_State *L)
{
    return *(App **)lua_getextraspace(L);
}

static void stop(lua_State *L, App *app, int code, const char *text)
{
    app->stop_code = code;
    bind_where(L);
    lua_pushstring(L, text);
    lua_concat(L, 2);
    lua_error(L);
}

static void check_limits(lua_State *L, App *app)
{
    if (caught)
        stop(L, app, 128 + caught, caught == SIGINT ? "stopped by Ctrl-C" : "stopped by a signal");
    if (app->fuel == 0)
        stop(L, app, EXIT_FUEL, "used up its instructions; raise --fuel or do less per step");
    if (app->deadline > 0 && app_clock() > app->deadline)
        stop(L, app, EXIT_TIME, "used up its time; raise --time-limit or simulate less");
}

static void count_hook(lua_State *L, lua_Debug *ar)
{
    App *app = app_of(L);
    (void)ar;
    if (app->fuel > 0)
        app->fuel = app->fuel > HOOK_EVERY ? app->fuel - HOOK_EVERY : 0;
    check_limits(L, app);
}

static int poll_limits(lua_State *L)
{
    check_limits(L, app_of(L));
    return 0;
}

static void *allocate(void *data, void *block, size_t old, size_t size)
{
    App *app = data;
    if (!block)
        old = 0;                /* Lua passes a type there */
    if (size == 0) {
        app->memory_used -= old;
        free(block);
        return NULL;
    }
    if (app->memory_limit > 0 && size > old && app->memory_used - old + size > app->memory_limit)
        return NULL;
    void *moved = realloc(block, size);
    if (moved)
        app->memory_used += size - old;
    return moved;
}

static int panic(lua_State *L)
{
    const char *text = lua_tostring(L, -1);
    fprintf(stderr, "digbox: internal: %s\n", text ? text : "error outside a protected call");
    fflush(NULL);
    _exit(EXIT_INTERNAL);
}

/* ---- text of values without addresses ------------------------------------------- */

static void push_text(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    int type = lua_type(L, index);
    bool plain = type == LUA_TNIL || type == LUA_TBOOLEAN || type == LUA_TNUMBER || type == LUA_TSTRING;
    if (plain || luaL_getmetafield(L, index, "__tostring") != LUA_TNIL) {
        if (!plain)
            lua_pop(L, 1);
        luaL_tolstring(L, index, NULL);
        return;
    }
    if (luaL_getmetafield(L, index, "__name") == LUA_TSTRING)
        return;
    lua_pushstring(L, lua_typename(L, type));
}

static int base_tostring(lua_State *L)
{
    luaL_checkany(L, 1);
    push_text(L, 1);
    return 1;
}

static int base_print(lua_State *L)
{
    int n = lua_gettop(L);
    for (int i = 1; i <= n; i++) {
        size_t length;
        push_text(L, i);
        const char *text = lua_tolstring(L, -1, &length);
        if (i > 1)
            fputc('\t', stdout);
        fwrite(text, 1, length, stdout);
        lua_pop(L, 1);
    }
    fputc('\n', stdout);
    return 0;
}

/* load(chunk [, name [, mode [, env]]]): text only, whatever the mode asks. upvalue: the library's own */
static int base_load(lua_State *L)
{
    int n = lua_gettop(L);
    lua_settop(L, n < 4 ? 3 : 4);
    lua_pushliteral(L, "t");
    lua_replace(L, 3);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, n < 4 ? 3 : 4, LUA_MULTRET);
    return lua_gettop(L);
}

/* setmetatable without finalizers. upvalue: the library's own */
static int base_setmetatable(lua_State *L)
{
    if (lua_istable(L, 2)) {
        lua_pushliteral(L, "__gc");
        if (lua_rawget(L, 2) != LUA_TNIL)
            return bind_error(L, "setmetatable: __gc is not available to scripts");
    }
    lua_settop(L, 2);
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_call(L, 2, 1);
    return 1;
}

/* ---- require ------------------------------------------------------------------------- */

/* Text of a file on the stack, or false with a sentence there. */
static bool push_source(lua_State *L, const char *path)
{
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

/* Compiles the text on top of the stack into a function that replaces it, or into a message. */
static int load_source(lua_State *L, const char *path)
{
    size_t size;
    const char *text = lua_tolstring(L, -1, &size);
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
    bool inside = realpath(lua_tostring(L, -2), real_module) && realpath(folder, real_folder) &&
                  strncmp(real_module, real_folder, strlen(real_folder)) == 0;
    lua_pop(L, 1);
    if (!inside)
        lua_pop(L, 1);
    return inside;
}

/* require(name): digbox, digbox.NAME, or a text module beside the script. upvalue: table of what is loaded */
static int base_require(lua_State *L)
{
    const char *name = luaL_checkstring(L, 1);
    lua_settop(L, 1);
    lua_pushvalue(L, 1);
    if (lua_rawget(L, lua_upvalueindex(1)) == LUA_TBOOLEAN && !lua_toboolean(L, -1))
        return bind_error(L, "module '%s' requires itself", name);
    if (!lua_isnil(L, -1))
        return 1;
    if (strcmp(name, "digbox") == 0 || strcmp(name, "digbox.test") == 0) {
        bind_use(L, strcmp(name, "digbox") == 0 ? "init" : "test");
    } else {
        if (!push_module_path(L, name))
            return bind_error(L, "module '%s' not found beside the script", name);
        const char *path = lua_tostring(L, -1);
        if (!push_source(L, path) || load_source(L, path) != LUA_OK)
            return lua_error(L);
        lua_pushvalue(L, 1);
        lua_pushboolean(L, 0);
        lua_rawset(L, lua_upvalueindex(1));
        lua_pushvalue(L, 1);
        if (lua_pcall(L, 1, 1, 0) != LUA_OK) {
            lua_pushvalue(L, 1);
            lua_pushnil(L);
            lua_rawset(L, lua_upvalueindex(1));
            return lua_error(L);
        }
        if (lua_isnil(L, -1)) {
            lua_pop(L, 1);
            lua_pushboolean(L, 1);
        }
    }
    lua_pushvalue(L, 1);
    lua_pushvalue(L, -2);
    lua_rawset(L, lua_upvalueindex(1));
    return 1;
}

/* ---- opening --------------------------------------------------------------------------- */

static void wrap(lua_State *L, const char *name, lua_CFunction f)
{
    lua_getglobal(L, name);
    lua_pushcclosure(L, f, 1);
    lua_setglobal(L, name);
}

static void remove_from(lua_State *L, const char *library, const char *name)
{
    lua_getglobal(L, library);
    lua_pushnil(L);
    lua_setfield(L, -2, name);
    lua_pop(L, 1);
}

static void open_libraries(lua_State *L, bool trust)
{
    static const luaL_Reg libraries[] = {
        {LUA_GNAME, luaopen_base}, {LUA_TABLIBNAME, luaopen_table}, {LUA_STRLIBNAME, luaopen_string}, {LUA_MATHLIBNAME, luaopen_math},
        {LUA_UTF8LIBNAME, luaopen_utf8}, {LUA_COLIBNAME, luaopen_coroutine}, {NULL, NULL},
    };
    static const char *const gone[] = {"dofile", "loadfile", "collectgarbage", "warn", NULL};
    for (const luaL_Reg *l = libraries; l->name; l++) {
        luaL_requiref(L, l->name, l->func, 1);
        lua_pop(L, 1);
    }
    if (trust) {
        luaL_requiref(L, LUA_IOLIBNAME, luaopen_io, 1);
        luaL_requiref(L, LUA_OSLIBNAME, luaopen_os, 1);
        lua_pop(L, 2);
    }
    for (int i = 0; gone[i]; i++) {
        lua_pushnil(L);
        lua_setglobal(L, gone[i]);
    }
    remove_from(L, "string", "dump");
    wrap(L, "load", base_load);
    wrap(L, "setmetatable", base_setmetatable);
    lua_register(L, "tostring", base_tostring);
    lua_register(L, "print", base_print);
    lua_pushliteral(L, "");                 /* the metatable of strings is out of reach */
    lua_getmetatable(L, -1);
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    lua_pop(L, 2);
}

static int open_state(lua_State *L)
{
    App *app = lua_touserdata(L, 1);
    open_libraries(L, app->trust);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pop(L, 1);
    bind_open(L);
    lua_pop(L, 1);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_pushcfunction(L, poll_limits);
    lua_setfield(L, -2, "poll");
    bind_use(L, "sandbox");
    bind_hint_methods(L);
    lua_newtable(L);
    lua_pushcclosure(L, base_require, 1);
    lua_setglobal(L, "require");
    return 0;
}

lua_State *app_open(App *app)
{
    lua_State *L = lua_newstate(allocate, app);
    if (!L)
        return NULL;
    *(App **)lua_getextraspace(L) = app;
    lua_atpanic(L, panic);
    lua_pushcfunction(L, open_state);
    lua_pushlightuserdata(L, app);
    if (lua_pcall(L, 1, 0, 0) != LUA_OK) {
        fprintf(stderr, "digbox: internal: %s\n", lua_tostring(L, -1));
        lua_close(L);
        return NULL;
    }
    lua_sethook(L, count_hook, LUA_MASKCOUNT, HOOK_EVERY);
    return L;
}

void app_set_option(lua_State *L, const char *name)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "options");
    lua_pushvalue(L, -3);
    lua_setfield(L, -2, name);
    lua_pop(L, 3);
}

/* ---- running ------------------------------------------------------------------------------ */

/* Turns what was raised into text; never calls the script's __tostring. */
static int handle_message(lua_State *L)
{
    if (lua_type(L, 1) == LUA_TSTRING)
        return 1;
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "finished");
    if (lua_rawequal(L, 1, -1)) {
        lua_settop(L, 1);
        return 1;
    }
    bind_where(L);
    lua_pushfstring(L, "error was called with a %s, must be with a text that says what is wrong", luaL_typename(L, 1));
    lua_concat(L, 2);
    return 1;
}

static int code_of_failure(lua_State *L, App *app, int status)
{
    if (lua_istable(L, -1)) {               /* core.finished: the script ended itself */
        lua_pop(L, 1);
        return EXIT_FINE;
    }
    if (app->stop_code)
        return app->stop_code;
    if (status == LUA_ERRMEM) {
        lua_pop(L, 1);
        if (app->memory_limit > 0)
            lua_pushfstring(L, "%s: the script needs more than %d MiB; raise --memory-limit", app->script,
                            (int)(app->memory_limit >> 20));
        else
            lua_pushfstring(L, "%s: no memory", app->script);
        return EXIT_MEMORY;
    }
    return bind_exit_code(L, lua_tostring(L, -1));
}

int app_call(lua_State *L, App *app, int arguments, int results)
{
    int base = lua_gettop(L) - arguments;
    lua_pushcfunction(L, handle_message);
    lua_insert(L, base);
    int status = lua_pcall(L, arguments, results, base);
    lua_remove(L, base);
    return status == LUA_OK ? EXIT_FINE : code_of_failure(L, app, status);
}

int app_call_core(lua_State *L, App *app, const char *name, int arguments, int results)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, name);
    lua_remove(L, -2);
    lua_insert(L, -arguments - 1);
    return app_call(L, app, arguments, results);
}

void app_hash(const char *text, size_t size, char out[17])
{
    uint64_t h = 0xcbf29ce484222325u;       /* Fowler, Noll and Vo: FNV-1a, 64 bits */
    for (size_t i = 0; i < size; i++)
        h = (h ^ (unsigned char)text[i]) * 0x100000001b3u;
    snprintf(out, 17, "%016" PRIx64, h);
}

static int load_script(lua_State *L)
{
    const char *path = lua_tostring(L, 1);
    char hash[17];
    size_t size;
    if (!push_source(L, path))
        return lua_error(L);
    const char *text = lua_tolstring(L, -1, &size);
    app_hash(text, size, hash);
    lua_pushstring(L, hash);
    app_set_option(L, "script_hash");
    if (load_source(L, path) != LUA_OK)
        return lua_error(L);
    return 1;
}

int app_run_file(lua_State *L, App *app)
{
    const char *slash = strrchr(app->script, '/');
    lua_pushstring(L, app->script);
    app_set_option(L, "script");
    lua_pushstring(L, slash ? slash + 1 : app->script);
    app_set_option(L, "script_name");
    lua_pushcfunction(L, load_script);
    lua_pushstring(L, app->script);
    int code = app_call(L, app, 1, 1);
    if (code != EXIT_FINE)
        return code;
    return app_call(L, app, 0, 0);
}
