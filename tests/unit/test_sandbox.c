/* tests/unit/test_sandbox.c - the libraries of scripts against those of Lua, the check of what is in reach, failing allocations. */
#define _XOPEN_SOURCE 700       /* fork, waitpid, mkstemp */
#include "check.h"
#include "scratch.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

#include "lua/sandbox.h"
#include "lua/state.h"

#ifndef MAP_ANONYMOUS
#define MAP_ANONYMOUS 0x20
#endif

static void run_text(lua_State *L, const char *text)
{
    if (luaL_dostring(L, text) != LUA_OK)
        fail_msg("%s", lua_tostring(L, -1));
}

/* A state of ours in which the global `theirs` holds the libraries of Lua. */
static lua_State *open_both(App *app)
{
    *app = (App){.fuel = -1, .script = "test"};
    lua_State *L = app_open(app);
    CHECK(L != NULL);
    lua_newtable(L);
    luaL_requiref(L, "string", luaopen_string, 0);
    lua_setfield(L, -2, "string");
    luaL_requiref(L, "table", luaopen_table, 0);
    lua_setfield(L, -2, "table");
    lua_setglobal(L, "theirs");
    return L;
}

/* Patterns and texts of a few characters each, many thousands of them: the same captures, positions, counts and failures. */
TEST(patterns_match_as_those_of_lua)
{
    App app;
    lua_State *L = open_both(&app);
    run_text(L,
        "local parts = { 'a', 'b', '.', '%a', '%d', '%A', '[ab]', '[^a]', '[a-c1]', '[]]', '[^]a]', '[%a-]', '%%', '(', ')', '()', '%1', '%2',"
        " '%b()', '%f[%a]', '%f[^a]', '$', '^', '-', '*', '+', '?', ' ', '1', '%s', '%w', '[%d.]', '%bxx' }\n"
        "local letters = { 'a', 'b', 'c', '1', ' ', '(', ')', 'x', '-', 'aa', 'ab', ']', '.', '%' }\n"
        "local function word(from, n) local t = {} for i = 1, n do t[i] = from[math.random(#from)] end return theirs.table.concat(t) end\n"
        "local function all(...) return { n = select('#', ...), ... } end\n"
        "local function same(a, b) if a.n ~= b.n then return false end for i = 1, a.n do if a[i] ~= b[i] then return false end end return true end\n"
        "local function walk(lib, s, p) local t = { n = 0 } for a, b, c in lib.gmatch(s, p) do t[#t + 1] = tostring(a) .. '|' .. tostring(b)"
        " .. '|' .. tostring(c) t.n = t.n + 1 end return table.unpack(t, 1, t.n) end\n"
        "compared = 0\n"
        "for i = 1, 40000 do\n"
        "  local s, p, init = word(letters, math.random(0, 9)), word(parts, math.random(1, 7)), math.random(-4, 6)\n"
        "  local calls = { { 'find', s, p, init }, { 'match', s, p, init }, { 'gsub', s, p, '<%0>' }, { 'gsub', s, p, '%1', 2 },"
        "    { 'gsub', s, p, function(x) return x ~= '' and #tostring(x) .. '' end }, { 'find', s, p, init, true } }\n"
        "  for _, c in ipairs(calls) do\n"
        "    local mine, yours = all(pcall(string[c[1]], table.unpack(c, 2, 5))), all(pcall(theirs.string[c[1]], table.unpack(c, 2, 5)))\n"
        "    if mine[1] and not yours[1] or mine[1] and not same(mine, yours) then\n"
        "      error(('%s(%q, %q, %d): %s, not %s'):format(c[1], s, p, init, tostring(mine[2]), tostring(yours[2])))\n"
        "    end\n"
        "    if mine[1] then compared = compared + 1 end\n"
        "  end\n"
        "  local mine, yours = all(pcall(walk, string, s, p)), all(pcall(walk, theirs.string, s, p))\n"
        "  if mine[1] and not same(mine, yours) then error(('gmatch(%q, %q)'):format(s, p)) end\n"
        "end\n"
        "assert(compared > 50000, compared)\n");
    lua_close(L);
}

/* What is refused must be refused by Lua as well, when it gets that far. */
TEST(patterns_that_are_wrong_are_refused)
{
    App app;
    lua_State *L = open_both(&app);
    run_text(L,
        "for _, p in ipairs { '%', '[', '[a', '[^]', '[%', '(', '(()', '.)', '%1', '(%1)', '%b', '%bx', '%f', '%fa', ('()'):rep(33) } do\n"
        "  assert(not pcall(theirs.string.find, 'a(', p) and not pcall(string.find, 'a(', p), p)\n"
        "end\n");
    lua_close(L);
}

TEST(table_functions_do_as_those_of_lua)
{
    App app;
    lua_State *L = open_both(&app);
    run_text(L,
        "local function list(n) local t = {} for i = 1, n do t[i] = math.random(1000) end return t end\n"
        "local function text(...) local out = {} for i = 1, select('#', ...) do local v = select(i, ...)\n"
        "  if type(v) == 'table' then for k = 1, 14 do out[#out + 1] = tostring(v[k]) end else out[#out + 1] = tostring(v) end end\n"
        "  return theirs.table.concat(out, ' ') end\n"
        "local I = math.maxinteger\n"
        "local calls = { { 'insert', 5 }, { 'insert', 1, 7 }, { 'insert', 4, 7 }, { 'insert', 0, 7 }, { 'insert', 11, 7 },"
        " { 'insert', 12, 7 }, { 'insert' },"
        " { 'insert', 1, 2, 3 }, { 'remove' }, { 'remove', 1 }, { 'remove', 10 }, { 'remove', 11 }, { 'remove', 12 }, { 'remove', 0 }, { 'remove', -1 },"
        " { 'move', 1, 10, 2 }, { 'move', 2, 10, 1 }, { 'move', 3, 1, 9 }, { 'move', 1, 3, 5, {} },"
        " { 'move', 1, I, 2 }, { 'move', I, I, 1 }, { 'move', 1, 2, I },"
        " { 'concat' }, { 'concat', '-' }, { 'concat', '-', 3 }, { 'concat', '-', 3, 5 }, { 'concat', '-', 5, 3 }, { 'concat', '-', 9, 11 }, { 'concat', 5 },"
        " { 'unpack' }, { 'unpack', 3 }, { 'unpack', 3, 5 }, { 'unpack', 11, 12 }, { 'unpack', 5, 3 }, { 'unpack', 1, 1e8 }, { 'sort' },"
        " { 'sort', function(a, b) return a > b end }, { 'sort', 5 }, { 'sort', function() error 'x' end }, { 'insert', 2^53, 1 } }\n"
        "for _, n in ipairs { 10, 0, 1, 2 } do for _, c in ipairs(calls) do\n"
        "  local a = list(n) local b = table.move(a, 1, n, 1, {})\n"
        "  local mine, yours = { pcall(table[c[1]], a, table.unpack(c, 2, 4)) }, { pcall(theirs.table[c[1]], b, table.unpack(c, 2, 4)) }\n"
        "  local x, y = text(table.unpack(mine)), text(table.unpack(yours))\n"
        "  if mine[1] ~= yours[1] or mine[1] and (x ~= y or text(a) ~= text(b)) then\n"
        "    error(c[1] .. ' ' .. n .. ' ' .. tostring(c[2]) .. ': ' .. x .. ', not ' .. y) end\n"
        "end end\n"
        "for n = 0, 300, 7 do local t = list(n) table.sort(t) for i = 2, n do assert(t[i - 1] <= t[i]) end end\n"
        "local t = {} for i = 1, 200 do t[i] = { math.random(5), i } end table.sort(t, function(a, b) return a[1] < b[1] end)\n"
        "for i = 2, 200 do assert(t[i - 1][1] < t[i][1] or t[i - 1][1] == t[i][1] and t[i - 1][2] < t[i][2], 'not stable') end\n");
    lua_close(L);
}

TEST(string_functions_do_as_those_of_lua)
{
    App app;
    lua_State *L = open_both(&app);
    run_text(L,
        "local I, N = math.maxinteger, math.mininteger\n"
        "local at = { 0, 1, 2, 5, 6, 7, -1, -5, -6, -7, I, N }\n"
        "local function same(f, ...) local a, b = table.pack(pcall(string[f], ...)), table.pack(pcall(theirs.string[f], ...))\n"
        "  if a[1] ~= b[1] or a.n ~= b.n then error(f) end\n"
        "  for i = 2, a[1] and a.n or 1 do if a[i] ~= b[i] then error(('%s: %s, not %s'):format(f, tostring(a[i]), tostring(b[i]))) end end end\n"
        "for _, s in ipairs { '', 'a', 'hello', 'hello!' } do\n"
        "  for _, i in ipairs(at) do same('sub', s, i) same('byte', s, i) same('find', s, 'l', i) same('find', s, '', i) same('find', s, '()', i)\n"
        "    for _, j in ipairs(at) do same('sub', s, i, j) if i ~= N or j ~= I then same('byte', s, i, j) end end end\n"
        "  for _, n in ipairs { -1, 0, 1, 2, 3, 7 } do same('rep', s, n) same('rep', s, n, ', ') end\n"
        "  same('upper', s) same('lower', s:upper()) same('reverse', s) same('len', s) same('format', '%5s|%-8q|%d %g %%', s, s, 5, 0.1)\n"
        "end\n"
        "same('char') same('char', 65, 0, 255) same('char', 256) same('format', '%d', '10') same('format', '%d')\n"
        "same('pack', 'i4s1z', 1, 'a', 'b') same('packsize', 'i4i8') same('unpack', 'i4', 'abcd')\n");
    lua_close(L);
}

static int unknown_function(lua_State *L)
{
    return lua_gettop(L);
}

static int check_again(lua_State *L)
{
    lib_check(L);
    return 0;
}

/* The same check that runs before each script. */
TEST(an_unknown_function_is_found)
{
    App app;
    lua_State *L = open_both(&app);
    lua_pushnil(L);
    lua_setglobal(L, "theirs");
    lua_pushcfunction(L, check_again);
    CHECK_INT(lua_pcall(L, 0, 0, 0), LUA_ERRRUN);                /* luaopen_string above has unlocked the metatable of strings */
    CHECK(strstr(lua_tostring(L, -1), "strings") != NULL);
    lua_pushliteral(L, "");
    lua_getmetatable(L, -1);
    lua_pushboolean(L, 0);
    lua_setfield(L, -2, "__metatable");
    lua_pushcfunction(L, check_again);
    CHECK_INT(lua_pcall(L, 0, 0, 0), LUA_OK);
    lua_getglobal(L, "math");
    lua_pushcfunction(L, unknown_function);
    lua_setfield(L, -2, "system");
    lua_pushcfunction(L, check_again);
    CHECK_INT(lua_pcall(L, 0, 0, 0), LUA_ERRRUN);
    CHECK_TEXT(lua_tostring(L, -1), "the sandbox is not tight: 'math.system' is on no list");
    lua_close(L);
}

/* ---- failing allocations ---------------------------------------------------------- */

static const char world_text[] =
    "local digbox = require 'digbox'\n"
    "local world = digbox.world {}\n"
    "world:floor { material = 'tile' }\n"
    "local ball = world:ball { name = 'b', radius = 0.1, at = { 0, 0.1, 0 } }\n"
    "local seen = 0\n"
    "ball:on('contact_begin', function() seen = seen + 1 end)\n"
    "world:step(3)\n"
    "local t = {} for k, v in pairs { a = 1, b = 2 } do t[#t + 1] = k .. v end table.sort(t)\n"
    "local co = coroutine.wrap(function() coroutine.yield(('x'):rep(100):gsub('x', 'yz')) end) co()\n"
    "print(pcall(error, 'caught'), load('return 1')(), #table.concat(t, ','))\n";

/* In a process of its own: the run with that allocation failing. Returns the status of waitpid; *count allocations were made. */
static int run_failing(const char *path, size_t at, bool on, size_t *count)
{
    fflush(NULL);
    pid_t pid = fork();
    if (pid == 0) {
        int nowhere = open("/dev/null", O_WRONLY);
        dup2(nowhere, 1);
        dup2(nowhere, 2);
        App app = {.fuel = -1, .script = path, .fail_at = at, .fail_on = on};
        lua_State *L = app_open(&app);
        int code = L ? app_run_file(L, &app) : EXIT_INTERNAL;
        *count = app.allocations;
        if (L)
            lua_close(L);
        _exit(code);
    }
    int status = 0;
    CHECK(pid > 0 && waitpid(pid, &status, 0) == pid);
    return status;
}

TEST(every_allocation_may_fail)
{
    char path[512];
    const char *points = getenv("POINTS");
    const size_t wanted = points ? strtoul(points, NULL, 10) : 150;
    int file = mkstemp(scratch_path(path, sizeof path, "failing-XXXXXX"));
    CHECK(file >= 0 && write(file, world_text, sizeof world_text - 1) == (ssize_t)sizeof world_text - 1);
    close(file);
    size_t *count = mmap(NULL, sizeof *count, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    int whole = run_failing(path, 0, false, count);
    const size_t n = *count, step = n / wanted + 1;
    int wrong = 0;
    for (size_t at = 1; at <= n; at += at < 40 ? 1 : step) {
        int status = run_failing(path, at, at % 2 == 0, count);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_MEMORY) {
            printf("allocation %zu of %zu: status %d\n", at, n, status);
            wrong++;
        }
    }
    munmap(count, sizeof *count);
    unlink(path);
    CHECK_INT(WIFEXITED(whole) ? WEXITSTATUS(whole) : -1, EXIT_FINE);
    CHECK(n > 1000);
    CHECK_INT(wrong, 0);
}

int main(void)
{
    app_catch_signals();
    RUN_TESTS(unit_test(patterns_match_as_those_of_lua), unit_test(patterns_that_are_wrong_are_refused),
              unit_test(table_functions_do_as_those_of_lua), unit_test(string_functions_do_as_those_of_lua),
              unit_test(an_unknown_function_is_found), unit_test(every_allocation_may_fail));
}
