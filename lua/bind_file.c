/* lua/bind_file.c - the few files the Lua side touches: output below the output folder, text beside the script.
 *
 * A script names output relative to the output folder; a leading "out/" stands for it. Nothing leaves that folder unless the
 * program was started with --trust.
 */

#define _XOPEN_SOURCE 700       /* mkdir, realpath */

#include "bind.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/text.h"
#include "command.h"

enum { PATH_LIMIT = 1024, TEXT_LIMIT = 64 * 1024 * 1024 };

/* core.options.name, or otherwise */
static const char *push_option(lua_State *L, const char *name, const char *otherwise)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "options");
    lua_getfield(L, -1, name);
    lua_replace(L, -3);
    lua_pop(L, 1);
    const char *value = lua_tostring(L, -1);
    return value ? value : otherwise;
}

static bool option_on(lua_State *L, const char *name)
{
    push_option(L, name, NULL);
    bool on = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return on;
}

static void check_text_of_path(lua_State *L, const char *path, size_t length)
{
    if (length >= PATH_LIMIT)
        bind_error(L, "the file name has %d bytes, must have at most %d", (int)length, PATH_LIMIT - 1);
    const char *fault = strlen(path) < length ? "holds a control character" : text_fault(path);
    if (fault)
        bind_error(L, "the file name %s", fault);
    if (length == 0 || path[length - 1] == '/')
        bind_error(L, "the file name '%s' names no file", path);
}

static void make_folders(lua_State *L, const char *path)
{
    char folder[2 * PATH_LIMIT];
    snprintf(folder, sizeof folder, "%s", path);
    for (char *p = strchr(folder + 1, '/'); p; p = strchr(p + 1, '/')) {
        *p = '\0';
        if (mkdir(folder, 0777) != 0 && errno != EEXIST)
            bind_fail_text(L, DIG_E_FILE, "%s: %s", folder, strerror(errno));
        *p = '/';
    }
}

/* core.out_path(path) -> where it is written; folders are made, but for a check of the script */
static int file_out_path(lua_State *L)
{
    size_t length;
    const char *path = luaL_checklstring(L, 1, &length);
    check_text_of_path(L, path, length);
    if (!file_stays_below(path)) {
        if (!option_on(L, "trust"))
            return bind_error(L, "'%s' lies outside the output folder (--trust allows it)", path);
        lua_pushvalue(L, 1);
    } else {
        const char *out = push_option(L, "out", "out");
        while (strncmp(path, "./", 2) == 0)
            path += 2;
        if (strncmp(path, "out/", 4) == 0)
            path += 4;
        lua_pushfstring(L, "%s/%s", out, path);
    }
    if (!option_on(L, "dry"))
        make_folders(L, lua_tostring(L, -1));
    return 1;
}

/* core.frame_path("f-%05d.png", 12) -> "f-00012.png"; without a place for the number nil */
static int file_frame_path(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1);
    lua_Integer number = luaL_checkinteger(L, 2);
    const char *mark = strchr(path, '%');
    if (!mark)
        return 0;
    const char *p = mark + 1;
    int width = 0;
    bool zero = *p == '0';
    while (*p >= '0' && *p <= '9' && width < 100)
        width = width * 10 + (*p++ - '0');
    if (*p != 'd' || width > 9 || (width > 0 && !zero) || strchr(p, '%'))
        return bind_error(L, "'%s' is no pattern for frames: it needs one %%d or %%0Nd with N from 1 to 9", path);
    char digits[32];
    snprintf(digits, sizeof digits, "%0*lld", width, (long long)number);
    lua_pushlstring(L, path, (size_t)(mark - path));
    lua_pushstring(L, digits);
    lua_pushstring(L, p + 1);
    lua_concat(L, 3);
    return 1;
}

/* core.write(path, text): a whole file or none */
static int file_write(lua_State *L)
{
    size_t length;
    const char *path = luaL_checkstring(L, 1), *text = luaL_checklstring(L, 2, &length);
    char why[2 * PATH_LIMIT];
    dig_status s = file_replace(path, text, length, FILE_FLUSHED, why, sizeof why);
    return s == DIG_OK ? 0 : bind_fail_text(L, s, "%s", why);
}

/* Pushes the text of a file, or nil and a sentence. */
static int push_file(lua_State *L, const char *path)
{
    FILE *f = fopen(path, "rb");
    if (!f) {
        lua_pushnil(L);
        lua_pushfstring(L, "%s: %s", path, strerror(errno));
        return 2;
    }
    long size = fseek(f, 0, SEEK_END) == 0 ? ftell(f) : -1;
    if (size < 0 || size > TEXT_LIMIT || fseek(f, 0, SEEK_SET) != 0) {
        fclose(f);
        lua_pushnil(L);
        lua_pushfstring(L, "%s: not a file of at most %d MiB", path, TEXT_LIMIT >> 20);
        return 2;
    }
    char *text = malloc((size_t)size + 1);
    size_t got = text ? fread(text, 1, (size_t)size, f) : 0;
    fclose(f);
    if (!text)
        return luaL_error(L, "not enough memory");
    lua_pushlstring(L, text, got);
    free(text);
    return 1;
}

/* core.beside(name) -> the path of a file beside the script (or below its folder), or nil and why not */
static int file_beside(lua_State *L)
{
    size_t length;
    const char *name = luaL_checklstring(L, 1, &length);
    check_text_of_path(L, name, length);
    const char *script = push_option(L, "script", "");
    const char *slash = strrchr(script, '/');
    if (!file_stays_below(name) && !option_on(L, "trust")) {
        lua_pushnil(L);
        lua_pushfstring(L, "'%s' lies outside the script's folder (--trust allows it)", name);
        return 2;
    }
    if (name[0] == '/' || !slash) {
        lua_pushvalue(L, 1);
        return 1;
    }
    lua_pushlstring(L, script, (size_t)(slash - script) + 1);
    lua_pushvalue(L, 1);
    lua_concat(L, 2);
    return 1;
}

/* core.read(path) -> text, or nil and why not. For embedded files only: they decide what may be read. */
static int file_text(lua_State *L)
{
    return push_file(L, luaL_checkstring(L, 1));
}

/* core.exists(path) */
static int file_exists(lua_State *L)
{
    lua_pushboolean(L, access(luaL_checkstring(L, 1), R_OK) == 0);
    return 1;
}

/* core.make_folders(path of a file) */
static int file_make_folders(lua_State *L)
{
    make_folders(L, luaL_checkstring(L, 1));
    return 0;
}

/* core.clock() -> s, of a clock that is never set */
static int file_clock(lua_State *L)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    lua_pushnumber(L, (lua_Number)t.tv_sec + 1e-9 * (lua_Number)t.tv_nsec);
    return 1;
}

/* core.tell(text): to stderr. The progress line, which begins with a return and holds numbers only, may move the cursor. */
static int file_tell(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 1, &size);
    say_text(stderr, text, size, *text == '\r' ? "\n\r\033" : "\n");
    fflush(stderr);
    return 0;
}

static const luaL_Reg functions[] = {
    {"out_path", file_out_path}, {"frame_path", file_frame_path}, {"write", file_write}, {"beside", file_beside}, {"read", file_text},
    {"exists", file_exists}, {"make_folders", file_make_folders}, {"clock", file_clock}, {"tell", file_tell}, {NULL, NULL},
};

/* ---- checking tables of fields for the Lua side -------------------------------------- */

static const struct { const char *word; int kind; } kinds[] = {
    {"real", DIG_REAL}, {"int", DIG_INT}, {"bool", DIG_BOOL}, {"vec", DIG_VEC3}, {"dir", DIG_DIR}, {"quat", DIG_QUAT},
    {"size", DIG_SIZE3}, {"range", DIG_RANGE}, {"colour", DIG_COLOUR}, {"text", DIG_TEXT}, {"body", DIG_BODY}, {"joint", DIG_JOINT},
    {"material", DIG_MATERIAL}, {"any", -1},
};

/* "real m >0", "vec m", "any": kind, unit, bound */
static int read_spec(lua_State *L, const char *spec, const char *name, dig_param *row, char unit[32])
{
    char word[16] = "", bound[8] = "";
    unit[0] = '\0';
    int n = sscanf(spec, "%15s %31s %7s", word, unit, bound);
    if (n >= 2 && unit[0] == '>') {
        snprintf(bound, sizeof bound, "%.7s", unit);
        unit[0] = '\0';
    }
    *row = (dig_param){.name = name, .unit = unit};
    if (strcmp(bound, ">0") == 0) {
        row->min = 1e-300;
        row->max = 1e300;
    } else if (strcmp(bound, ">=0") == 0) {
        row->max = 1e300;
    }
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].word, word) == 0) {
            row->kind = kinds[i].kind < 0 ? DIG_REAL : (dig_kind)kinds[i].kind;
            return kinds[i].kind;
        }
    return luaL_error(L, "no kind '%s' in '%s'", word, spec);
}

/* The declared field on top of the stack (declare.lua): "vec m" or {"vec m", help, min =, max =, default =}. Reads its row and pushes its
 * default, or nil. */
static int read_declared(lua_State *L, const char *name, dig_param *row, char unit[32])
{
    int declared = lua_gettop(L);
    if (!lua_istable(L, declared)) {
        lua_pushnil(L);
        return read_spec(L, lua_tostring(L, declared), name, row, unit);
    }
    lua_rawgeti(L, declared, 1);
    int kind = read_spec(L, lua_tostring(L, -1), name, row, unit);
    bool low = lua_getfield(L, declared, "min") == LUA_TNUMBER, high = lua_getfield(L, declared, "max") == LUA_TNUMBER;
    if (low || high) {
        row->min = low ? lua_tonumber(L, -2) : row->max > row->min ? row->min : -1e300;
        row->max = high ? lua_tonumber(L, -1) : 1e300;
    }
    lua_getfield(L, declared, "default");
    return kind;
}

/* core.check(fields, what [, declared fields [, world]]) -> a table with the checked fields in SI, and defaults of those not given.
 * Declared fields are those of core.declare(what, ...) when they are not given: {radius = {"real m >0", "help"}, at = ..., } */
static int check_fields(lua_State *L)
{
    const char *what = luaL_checkstring(L, 2);
    const char *names[64];
    int count = 0;
    WorldRef *world = luaL_testudata(L, 4, BIND_WORLD);
    lua_settop(L, 4);
    if (!lua_istable(L, 1))
        return bind_wants_fields(L, 1, what);
    if (lua_isnil(L, 3)) {
        bind_push_declared(L, what);
        lua_replace(L, 3);
    }
    int declared;
    const char **all = bind_names(L, 3, 3, &declared);
    while (count < declared && count < 63) {
        names[count] = all[count];
        count++;
    }
    lua_settop(L, 4);
    names[count] = NULL;
    bind_check_keys(L, 1, what, NULL, names);
    lua_newtable(L);
    lua_newtable(L);
    Fill fill = {L, 1, 6, what, what, world};
    for (int i = 0; i < count; i++) {
        union { real r; int64_t i; bool b; vec3 v; quat q; dig_text t; real range[2]; dig_body body; dig_joint joint; } field;
        dig_param row;
        char unit[32];
        lua_getfield(L, 3, names[i]);
        int kind = read_declared(L, names[i], &row, unit), fallback = lua_gettop(L);
        lua_pushstring(L, names[i]);
        if (lua_rawget(L, 1) == LUA_TNIL)
            lua_settop(L, fallback);
        if (lua_isnil(L, -1)) {
            lua_settop(L, 6);
            continue;
        }
        if (kind >= 0 && kind != DIG_BODY && kind != DIG_JOINT) {
            bind_fill_field(&fill, &row, &field);
            bind_push_field(L, 4, &row, &field);
        } else if (kind >= 0) {
            bind_fill_field(&fill, &row, &field);       /* checks it; the handle itself goes on */
        }
        lua_setfield(L, 5, names[i]);
        lua_settop(L, 6);
    }
    lua_settop(L, 5);
    return 1;
}

/* core.quantity(value, unit, what [, field]) -> number in SI; unit nil = any */
static int check_quantity(lua_State *L)
{
    const char *unit = luaL_optstring(L, 2, NULL), *what = luaL_checkstring(L, 3), *field = luaL_optstring(L, 4, NULL);
    lua_pushnumber(L, bind_real(L, 1, unit, what, field));
    return 1;
}

/* core.seconds(value, what) -> s, finite and >= 0 */
static int check_seconds(lua_State *L)
{
    lua_pushnumber(L, bind_seconds(L, 1, luaL_checkstring(L, 2)));
    return 1;
}

/* core.type(value) -> "body", "vector", ..., or Lua's own name */
static int check_type_name(lua_State *L)
{
    static const char *const names[] = {BIND_WORLD, BIND_BODY, BIND_JOINT, BIND_DIG, BIND_SHAPE, BIND_REGION, BIND_VEC, BIND_QUAT, NULL};
    for (int i = 0; names[i]; i++)
        if (luaL_testudata(L, 1, names[i])) {
            lua_pushstring(L, names[i]);
            return 1;
        }
    lua_pushstring(L, luaL_typename(L, 1));
    return 1;
}

/* core.class_of(value) -> the same, and "truss", "film", ... of what is made in Lua */
static int check_class_name(lua_State *L)
{
    luaL_checkany(L, 1);
    if (luaL_getmetafield(L, 1, "__name") == LUA_TSTRING)
        return 1;
    lua_settop(L, 1);
    return check_type_name(L);
}

static int leave_guard(lua_State *L, int status, lua_KContext unused)
{
    (void)status, (void)unused;
    return lua_gettop(L);
}

/* Is the first argument of the class whose metatable is known? */
static bool of_class(lua_State *L)
{
    if (lua_isnil(L, lua_upvalueindex(4)) || !lua_isuserdata(L, 1) || !lua_getmetatable(L, 1))
        return false;
    bool same = lua_rawequal(L, -1, lua_upvalueindex(4));
    lua_pop(L, 1);
    return same;
}

int bind_guarded(lua_State *L)
{
    int n = lua_gettop(L);
    if (!lua_isnil(L, lua_upvalueindex(3)) && !of_class(L)) {
        lua_pushcfunction(L, check_class_name);
        if (n > 0)
            lua_pushvalue(L, 1);
        else
            lua_pushnil(L);
        lua_call(L, 1, 1);
        if (!lua_rawequal(L, -1, lua_upvalueindex(3)))
            return bind_error(L, "%s: expected a %s, got %s (methods are called with ':')", lua_tostring(L, lua_upvalueindex(2)),
                              lua_tostring(L, lua_upvalueindex(3)), lua_tostring(L, -1));
        lua_pop(L, 1);
    }
    lua_pushvalue(L, lua_upvalueindex(1));
    lua_insert(L, 1);
    lua_callk(L, n, LUA_MULTRET, 0, leave_guard);
    return leave_guard(L, LUA_OK, 0);
}

/* core.guard(function, name, class or nil) -> the function as one in C: who ends with `return world:record{...}` leaves his own frame
 * on the stack, and with it the line that errors name. Calls may yield. */
static int make_guard(lua_State *L)
{
    lua_settop(L, 3);
    const char *class = lua_tostring(L, 3);
    if (!class || luaL_getmetatable(L, class) != LUA_TTABLE) {
        lua_settop(L, 3);
        lua_pushnil(L);
    }
    lua_pushcclosure(L, bind_guarded, GUARD_UPVALUES);
    return 1;
}

/* core.is_lua(function) */
static int check_is_lua(lua_State *L)
{
    lua_pushboolean(L, lua_isfunction(L, 1) && !lua_iscfunction(L, 1));
    return 1;
}

/* core.list(table) -> the same table, which prints its items from now on */
static int make_list(lua_State *L)
{
    bind_push_list(L, 0);
    lua_getmetatable(L, -1);
    lua_setmetatable(L, 1);
    lua_settop(L, 1);
    return 1;
}

static const luaL_Reg checks[] = {
    {"check", check_fields}, {"quantity", check_quantity}, {"seconds", check_seconds}, {"type", check_type_name}, {"list", make_list},
    {"class_of", check_class_name}, {"is_lua", check_is_lua}, {"guard", make_guard}, {NULL, NULL},
};

void bind_file_open(lua_State *L, int core)
{
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    luaL_setfuncs(L, checks, 0);
    lua_pushliteral(L, DIGBOX_VERSION);
    lua_setfield(L, -2, "version");
    lua_pop(L, 1);
}
