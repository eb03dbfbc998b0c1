/* tests/fuzz/target_api.c - bytes as a script of random calls with random and bad values (grammar.lua), run as `digbox run` does.
 *
 * What must hold: no call but a fault of digbox ends the script; every error is one clean line at the script's own place; every world
 * that is left is sound, and is the same world after saving and loading; the same script again says and leaves the same.
 */
#include "state.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lauxlib.h>
#include <lualib.h>

#include "world/world.h"

enum { FUEL = 4000000, SEEDS = 24, SEED_SIZE = 160 };

/* The state that makes scripts of bytes: not of the sandbox, and kept. */
static lua_State *grammar;

static void open_grammar(void)
{
    grammar = luaL_newstate();
    if (!grammar)
        fuzz_fail("no memory");
    luaL_openlibs(grammar);
    bind_open(grammar);
    lua_settop(grammar, 0);
    bool fine = luaL_loadfile(grammar, "tests/fuzz/grammar.lua") == LUA_OK;
    if (fine) {
        lua_getfield(grammar, LUA_REGISTRYINDEX, "digbox.core");
        lua_newtable(grammar);
        for (int i = 0; fuzz_rooms[i]; i++) {
            lua_pushstring(grammar, fuzz_rooms[i]);
            lua_rawseti(grammar, -2, i + 1);
        }
        fine = lua_pcall(grammar, 2, 1, 0) == LUA_OK;
    }
    if (!fine)
        fuzz_fail("%s", lua_tostring(grammar, -1));
}

/* Valid until the next call. */
static const char *script_of(const unsigned char *data, size_t size, size_t *length)
{
    if (!grammar)
        open_grammar();
    lua_settop(grammar, 1);
    lua_pushvalue(grammar, 1);
    lua_pushlstring(grammar, (const char *)data, size);
    if (lua_pcall(grammar, 1, 1, 0) != LUA_OK)
        fuzz_fail("grammar: %s", lua_tostring(grammar, -1));
    return lua_tolstring(grammar, -1, length);
}

/* ---- what is left ---- */

/* Effects of the script's own are functions, which no file holds. */
static bool has_own_effects(const World *w) { return w->effect_count > 0 && w->effects[w->effect_count - 1].owner; }

static void judge_world(dig_world *w, void *context)
{
    char why[600] = "";
    void *bytes = NULL;
    size_t size = 0;
    dig_world *copy = NULL;
    uint64_t *sum = context, own = dig_world_checksum(w);
    *sum ^= own * 0x9e3779b97f4a7c15u;
    if (dig_world_check(w) != DIG_OK)
        fuzz_fail("%s", dig_error(w));
    if (dig_world_pack(w, &bytes, &size) != DIG_OK)
        fuzz_fail("packing: %s", dig_error(w));
    if (dig_world_unpack(bytes, size, &copy, why, sizeof why) != DIG_OK)
        fuzz_fail("what was packed is refused: %s", why);
    if (dig_world_checksum(copy) != own && !has_own_effects(w))
        fuzz_fail("what was packed is another world");
    dig_world_close(copy);
    free(bytes);
}

typedef struct Outcome { int code; uint64_t sum; char *said; } Outcome;

static Outcome run_once(const char *text, size_t size)
{
    Outcome o = {0, 0, NULL};
    FuzzState *f = fuzz_open("fuzz.lua", FUEL);
    o.code = fuzz_run(f, text, size);
    const char *said = o.code == EXIT_MEMORY ? "" : lua_tostring(fuzz_lua(f), -1);
    size_t length = said ? strlen(said) : 0;
    o.said = calloc(1, length + 1);
    if (!o.said)
        fuzz_fail("no memory");
    memcpy(o.said, said ? said : "", length);
    fuzz_worlds(f, judge_world, &o.sum);
    fuzz_close(f);
    return o;
}

static void api_run(const unsigned char *data, size_t size)
{
    size_t length;
    const char *text = script_of(data, size, &length);
    Outcome first = run_once(text, length);
    if (strstr(first.said, "FAULT: "))
        fuzz_fail("%s", first.said);
    if (first.code != EXIT_FINE && first.code != EXIT_FUEL && first.code != EXIT_MEMORY)
        fuzz_fail("code %d: %s", first.code, first.said);
    if (size > 0 && data[size - 1] % 8 == 0) {
        Outcome second = run_once(text, length);
        if (first.code != second.code || first.sum != second.sum || strcmp(first.said, second.said) != 0)
            fuzz_fail("the second run differs (codes %d and %d):\n%s\n---- and ----\n%s", first.code, second.code, first.said, second.said);
        free(second.said);
    }
    free(first.said);
}

static void api_show(const unsigned char *data, size_t size)
{
    size_t length;
    const char *text = script_of(data, size, &length);
    fwrite(text, 1, length, stdout);
}

/* Any bytes are a script: those of a generator with fixed seeds. */
static void api_seeds(FuzzGive *give, void *context)
{
    uint64_t x = 88172645463325252u;        /* xorshift64 (Marsaglia 2003) */
    unsigned char bytes[SEED_SIZE];
    for (int n = 0; n < SEEDS; n++) {
        for (size_t i = 0; i < sizeof bytes; i++) {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
            bytes[i] = (unsigned char)(x >> 24);
        }
        give(context, bytes, sizeof bytes);
    }
}

const FuzzTarget fuzz_api = {.name = "api", .longest = 512, .seeds = api_seeds, .run = api_run, .show = api_show};
