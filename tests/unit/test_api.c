/* tests/unit/test_api.c - what a script can name: declared, documented and there are the same; bad values are refused.
 * The checks are written in Lua (tests/api/), on a state of their own whose core table they get. */
#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

#include "lua/bind.h"
#include "check.h"

/* Runs tests/api/NAME, which gives a list of problems and a count of checks. */
static void run_checks(const char *name, int least)
{
    char path[256];
    lua_State *L = luaL_newstate();
    CHECK(L != NULL);
    luaL_openlibs(L);
    bind_open(L);
    lua_setglobal(L, "digbox");
    snprintf(path, sizeof path, "tests/api/%s", name);
    bool fine = luaL_loadfile(L, path) == LUA_OK;
    if (fine) {
        lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
        fine = lua_pcall(L, 1, 2, 0) == LUA_OK;
    }
    if (!fine)
        printf("%s\n", lua_tostring(L, -1));
    CHECK(fine);
    int problems = (int)lua_rawlen(L, -2), checks = (int)lua_tointeger(L, -1);
    for (int i = 1; i <= problems; i++) {
        lua_rawgeti(L, -2, i);
        printf("%s: %s\n", name, lua_tostring(L, -1));
        lua_pop(L, 1);
    }
    printf("%s: %d checks, %d problems\n", name, checks, problems);
    CHECK(checks >= least);
    CHECK(problems == 0);
    lua_close(L);
}

TEST(names_are_the_same_everywhere) { run_checks("names.lua", 9000); }

TEST(bad_values_are_refused_and_change_nothing) { run_checks("values.lua", 12000); }

TEST(handles_callbacks_and_odd_tables_do_no_harm) { run_checks("cases.lua", 3000); }

int main(void)
{
    RUN_TESTS(unit_test(names_are_the_same_everywhere), unit_test(bad_values_are_refused_and_change_nothing),
              unit_test(handles_callbacks_and_odd_tables_do_no_harm));
}
