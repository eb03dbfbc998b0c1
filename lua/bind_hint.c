/* lua/bind_hint.c - a sentence behind messages of Lua's own, for those who come from another language or another Lua. The message itself
 * stays as it is: scripts may look at it. */

#include "bind.h"

#include <string.h>

/* What a message has in it, and the sentence. The first that fits is taken. */
static const struct { const char *sign, *hint; } hints[] = {
    /* what the sandbox does not have */
    {"(global 'io')", "worlds have no io: print(...) writes lines, world:record, world:render and world:save write files, digbox.args takes values; "
     "with --trust your own worlds have it"},
    {"(global 'os')", "worlds have no os: world.time is the time, digbox.args takes values, a script ends with return or error(...); "
     "with --trust your own worlds have it"},
    {"(global 'package')", "worlds have no package: require 'name' takes name.lua beside the script"},
    {"(global 'debug')", "worlds have no debug: error(text) stops with the line, print(...) shows values"},
    {"(global 'dofile')", "worlds have no dofile: require 'name' runs name.lua beside the script, once"},
    {"(global 'loadfile')", "worlds have no loadfile: require 'name' takes name.lua beside the script"},
    /* what is made first */
    {"(global 'digbox')", "a script begins with: local digbox = require \"digbox\""},
    {"(global 'world')", "make one first: local world = digbox.world {}"},
    {"(global 'test')", "a test begins with: local test = require \"digbox.test\""},
    {"(global 'task')", "tasks get it: world:spawn(function(task) task:wait(1) end)"},
    {"(global 'wait')", "in a task: world:spawn(function(task) task:wait(1) end)"},
    {"(global 'sleep')", "in a task: world:spawn(function(task) task:wait(1) end)"},
    {"(global 'vec')", "vectors are made by digbox.vec(x, y, z), or just {x, y, z}"},
    {"(global 'vec3')", "vectors are made by digbox.vec(x, y, z), or just {x, y, z}"},
    {"(global 'Vec3')", "vectors are made by digbox.vec(x, y, z), or just {x, y, z}"},
    {"(global 'vector')", "vectors are made by digbox.vec(x, y, z), or just {x, y, z}"},
    {"(global 'Vector3')", "vectors are made by digbox.vec(x, y, z), or just {x, y, z}"},
    {"(global 'CFrame')", "a place is at = {x, y, z}, a rotation digbox.quat{ axis = {0, 1, 0}, angle = '90 deg' }"},
    {"(global 'Quaternion')", "rotations are made by digbox.quat{ axis = {0, 1, 0}, angle = '90 deg' }"},
    {"(global 'quat')", "rotations are made by digbox.quat{ axis = {0, 1, 0}, angle = '90 deg' }"},
    {"(global 'Instance')", "things are made in a world: world:ball{...}, world:box{...}"},
    {"(global 'game')", "things are made in a world: local world = digbox.world {}; world:ball{...}"},
    {"(global 'workspace')", "things are made in a world: local world = digbox.world {}; world:ball{...}"},
    /* other versions of Lua, other languages */
    {"(global 'unpack')", "Lua 5.4 has table.unpack"}, {"(global 'loadstring')", "Lua 5.4 has load"},
    {"(field 'getn')", "the length of a list is #list"}, {"(field 'pow')", "powers are x ^ y"}, {"(field 'atan2')", "Lua 5.4 has math.atan(y, x)"},
    {"(field 'log10')", "Lua 5.4 has math.log(x, 10)"}, {"(field 'round')", "rounded is math.floor(x + 0.5)"},
    {"(field 'clamp')", "clamped is math.max(low, math.min(x, high))"}, {"(field 'sign')", "Lua has no math.sign: x > 0 and 1 or -1"},
    {"(field 'cosh')", "(math.exp(x) + math.exp(-x)) / 2"}, {"(field 'sinh')", "(math.exp(x) - math.exp(-x)) / 2"},
    {"(global 'printf')", "print((\"%.2f\"):format(x))"}, {"(global 'len')", "the length of a list is #list"},
    {"(global 'range')", "for i = 1, 10 do ... end"}, {"(global 'math.pi')", "math.pi"}, {"(global 'pi')", "Lua has math.pi"},
    {"(global 'sin')", "Lua has math.sin"}, {"(global 'cos')", "Lua has math.cos"}, {"(global 'sqrt')", "Lua has math.sqrt"},
    {"(global 'abs')", "Lua has math.abs"}, {"(global 'rad')", "Lua has math.rad; '90 deg' as text is taken, too"},
    {"(global 'random')", "Lua has math.random"}, {"(global 'console')", "Lua has print"},
    {"(for iterator 'for iterator')", "a list is gone through by: for i, thing in ipairs(list) do"},
    /* grammar */
    {"near '!'", "'not equal' is ~= in Lua, and ! is `not`"}, {"near '&'", "Lua writes `and`"}, {"near '|'", "Lua writes `or`"},
    {"syntax error near '+'", "Lua has no += and no ++: x = x + 1"}, {"syntax error near '-'", "Lua has no -= and no --: x = x - 1"},
    {"syntax error near '*'", "Lua has no *=: x = x * 2"}, {"near '//'", "comments begin with --"},
    {"'then' expected near '='", "== compares"}, {"<name> expected near", "fields are written name = value, and : calls a method"},
    {"'then' expected near '{'", "Lua writes: if ... then ... end"}, {"'do' expected near '{'", "Lua writes: while ... do ... end"},
    {"near <eof>", "every function, if, for and while has its `end`; `elseif` is one word"},
};

/* Fields that nothing separates: '}' expected (to close '{' at line 4) near 'at'. */
static const char *hint_of(const char *text)
{
    for (size_t i = 0; i < sizeof hints / sizeof *hints; i++)
        if (strstr(text, hints[i].sign))
            return hints[i].hint;
    const char *brace = strstr(text, "'}' expected");
    return brace && strstr(brace, " near ") ? "is there a comma between the fields?" : NULL;
}

void bind_hint(lua_State *L)
{
    const char *text = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : "";
    bool of_lua = strstr(text, "attempt to ") || strstr(text, " near ");
    const char *hint = of_lua ? hint_of(text) : NULL;
    if (!hint || strstr(text, hint))
        return;
    lua_pushfstring(L, "%s: %s", text, hint);
    lua_replace(L, -2);
}

/* core.hint(message) -> the message, with what may help behind it */
static int give_hint(lua_State *L)
{
    lua_settop(L, 1);
    bind_hint(L);
    return 1;
}

void bind_hint_open(lua_State *L, int core)
{
    lua_pushcfunction(L, give_hint);
    lua_setfield(L, core, "hint");
}
