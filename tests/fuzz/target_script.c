/* tests/fuzz/target_script.c - any bytes as a script: read from a file, compiled and run in the sandbox, as `digbox run` does.
 *
 * What must hold: the file's bytes are what is compiled; a failure has a code and a text; nothing else comes of any text.
 */
#include "state.h"

#include <string.h>

#include "lua/sandbox.h"

static const char *const texts[] = {
    "local t = {} for i = 1, 20 do t[i] = i * 2 end table.sort(t, function(a, b) return a > b end) return #t, t[1]",
    "local s = ('x'):rep(20) .. 'yz' return s:gsub('(x+)(%a)', '%2%1'), s:find('[^x]'), s:match('()y()'), s:gmatch('.')()",
    "local c = coroutine.wrap(function(...) for i = 1, 3 do coroutine.yield(i, ...) end error 'end' end) c(1) c() c() return pcall(c)",
    "local m = setmetatable({}, { __index = function(t, k) return k .. '!' end, __call = function(_, x) return x end }) return m.a, m(3)",
    "return pcall(error, { 1 }), xpcall(function() error 'x' end, function(e) return e .. e end), select('#', table.unpack({ 1, nil, 3 }, 1, 3))",
    "goto done do local x <const> = 5 local y <close> = setmetatable({}, { __close = function() end }) end ::done:: return 1 // 0.0, 7 & 3, ~5",
    "return load('return ' .. ('1+'):rep(9) .. '1')(), load('x ='), load(function() return nil end), tostring(print), tostring({}), #_VERSION",
    "for k, v in pairs { 1, 2, a = 3, b = 4 } do print(k, v) end return next({}), rawlen { 1 }, rawequal(1, 1), math.random(5), utf8.char(8364)",
    "local d = require 'digbox' return d.vec(1, 2, 3):length(), d.quantity('4 cm'), pcall(d.world, { stp = 1 }), pcall(require, 'nothing')",
    "return string.format('%5.2f %q %s %d %x', 1.5, 'a\\n', 'b', 3, 255), ('%d'):rep(3, ','), string.pack('<i4z', 5, 'a'), ('a'):byte(1, -1)",
    "#!/usr/bin/env digbox\n-- comment\nreturn [==[long]==], 0x1p4, 1e10, 'a\\z  b\\x41\\u{20ac}'",
    "local function deep(n) return n == 0 and 0 or 1 + deep(n - 1) end return deep(100), pcall(deep, 1e6), ('('):rep(50):find(('%('):rep(30))",
    "\xef\xbb\xbfreturn table.concat({ 1, 2 }, ','), table.move({ 1, 2, 3 }, 1, 3, 2), table.remove({ 1 }), table.insert({}, 1)",
    "\x1bLua\x54\x00\x19\x93\r\n\x1a\n",
    NULL,
};

static void script_seeds(FuzzGive *give, void *context)
{
    for (int i = 0; texts[i]; i++)
        give(context, texts[i], strlen(texts[i]) + (texts[i][0] == '\x1b' ? 4 : 0));
}

static int read_file(lua_State *L)
{
    const char *path = lua_tostring(L, 1);
    lua_pushboolean(L, lib_push_source(L, path));
    return 2;
}

static void judge_message(lua_State *L, int code)
{
    size_t size = 0;
    const char *text = lua_tolstring(L, -1, &size);
    if (code == EXIT_FINE)
        return;
    if (!text || code == EXIT_INTERNAL)
        fuzz_fail("a failure of code %d without a text", code);
}

static void script_run(const unsigned char *data, size_t size)
{
    FuzzState *f = fuzz_open("fuzz.lua", 200000);
    lua_State *L = fuzz_lua(f);
    size_t read = 0;
    lua_pushcfunction(L, read_file);
    lua_pushstring(L, fuzz_file(data, size));
    if (lua_pcall(L, 1, 2, 0) != LUA_OK || !lua_toboolean(L, -1))
        fuzz_fail("a file of %zu bytes cannot be read: %s", size, lua_tostring(L, 1));
    const char *text = lua_tolstring(L, 1, &read);
    if (read != size || (size > 0 && memcmp(text, data, size) != 0))
        fuzz_fail("%zu bytes became %zu", size, read);
    int code = fuzz_run(f, (const char *)data, size);
    if (code != EXIT_MEMORY)
        judge_message(L, code);
    fuzz_close(f);
}

const FuzzTarget fuzz_script = {.name = "script", .longest = 2048, .seeds = script_seeds, .run = script_run};
