/* lua/bind_watch.c - what a world notices about itself. */

#include "bind.h"

static void push_warning(lua_State *L, const dig_world *w, const dig_warning *n)
{
    const dig_rule_info *rule = dig_rule_get(n->rule);
    lua_createtable(L, 0, 12);
    bind_set_text(L, "rule", rule->name);
    bind_set_text(L, "reason", rule->reason);
    bind_set_text(L, "advice", rule->advice);
    bind_set_text(L, "unit", rule->unit);
    bind_set_real(L, "time", n->time);
    bind_set_real(L, "value", n->value);
    bind_set_real(L, "bound", n->bound);
    bind_set_text(L, "name", n->name.s);
    if (n->why[0])
        bind_set_text(L, "why", n->why);
    lua_pushinteger(L, (lua_Integer)n->times);
    lua_setfield(L, -2, "times");
    lua_pushinteger(L, n->body.slot);
    lua_setfield(L, -2, "slot");
    lua_pushinteger(L, n->dig);
    lua_setfield(L, -2, "dig");
    if (dig_body_alive(w, n->body)) {
        bind_push_body(L, 1, n->body);
        lua_setfield(L, -2, "body");
    }
}

/* world:warnings() -> list of {rule=, time=, body=, name=, dig=, value=, bound=, unit=, times=, reason=, advice=, why=} */
static int world_warnings(lua_State *L)
{
    const dig_world *w = bind_check_world(L, 1)->w;
    dig_warning list[DIG_WARNINGS];
    int count = dig_warnings(w, list, (int)DIG_WARNINGS);
    bind_push_list(L, count);
    for (int i = 0; i < count; i++) {
        push_warning(L, w, &list[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* core.warning_count(world): how many entries that list has */
static int warning_count(lua_State *L)
{
    lua_pushinteger(L, dig_warnings(bind_check_world(L, 1)->w, NULL, 0));
    return 1;
}

static const luaL_Reg methods[] = {{"warnings", world_warnings}, {NULL, NULL}};

void bind_watch_open(lua_State *L, int core)
{
    bind_extend(L, core, BIND_WORLD, methods);
    lua_pushcfunction(L, warning_count);
    lua_setfield(L, core, "warning_count");
}
