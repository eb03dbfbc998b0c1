/* lua/bind_schema.c - the rows of the engine (dig_param) as Lua tables, for help and documents: core.rows(set). */

#include "bind.h"

#include <math.h>
#include <string.h>

/* Words of declare.lua for the kinds of rows. */
static const char *const kind_words[] = {
    [DIG_REAL] = "real", [DIG_INT] = "int", [DIG_BOOL] = "bool", [DIG_VEC3] = "vec", [DIG_DIR] = "dir", [DIG_QUAT] = "quat",
    [DIG_SIZE3] = "size", [DIG_RANGE] = "range", [DIG_PAIR] = "pair", [DIG_COLOUR] = "colour", [DIG_TEXT] = "text",
    [DIG_MATERIAL] = "material", [DIG_BODY] = "body", [DIG_JOINT] = "joint", [DIG_POINTS] = "points", [DIG_INDICES] = "indices",
    [DIG_TABLE] = "table", [DIG_CHOICE] = "choice",
};

static void push_rows(lua_State *L, const dig_param *rows);

static void push_fallback(lua_State *L, const dig_param *row)
{
    switch (row->kind) {
    case DIG_REAL: case DIG_VEC3: case DIG_SIZE3: lua_pushnumber(L, row->fallback); break;
    case DIG_INT: lua_pushinteger(L, isnan(row->fallback) ? 0 : (lua_Integer)row->fallback); break;
    case DIG_BOOL: lua_pushboolean(L, row->fallback != 0); break;
    case DIG_CHOICE: lua_pushstring(L, row->choices[(int)row->fallback]); break;
    default: lua_pushnil(L); break;
    }
    if (lua_type(L, -1) == LUA_TNUMBER && (isnan(row->fallback) || row->required)) {
        lua_pop(L, 1);
        lua_pushnil(L);
    }
    lua_setfield(L, -2, "default");
}

/* {"real m", help, min =, max =, default =, of =, rows =, need =} */
static void push_row(lua_State *L, const dig_param *row)
{
    lua_newtable(L);
    lua_pushfstring(L, "%s %s", kind_words[row->kind], row->unit && *row->unit ? row->unit : "1");
    lua_rawseti(L, -2, 1);
    lua_pushstring(L, row->doc);
    lua_rawseti(L, -2, 2);
    if (row->max > row->min && row->kind != DIG_CHOICE && row->kind != DIG_BOOL) {
        bind_set_real(L, "min", row->min);
        bind_set_real(L, "max", row->max);
    }
    push_fallback(L, row);
    bind_set_bool(L, "need", row->required);
    if (row->kind == DIG_CHOICE) {
        lua_newtable(L);
        for (int i = 0; row->choices[i]; i++)
            bind_set_bool(L, row->choices[i], true);
        lua_setfield(L, -2, "of");
    }
    if (row->kind == DIG_TABLE) {
        push_rows(L, row->rows);
        lua_setfield(L, -2, "fields");
    }
}

static void push_rows(lua_State *L, const dig_param *rows)
{
    luaL_checkstack(L, 12, "rows too deep");
    lua_newtable(L);
    for (const dig_param *row = rows; row && row->name; row++) {
        push_row(L, row);
        lua_setfield(L, -2, row->name);
    }
}

static void push_schema(lua_State *L, const dig_schema *s)
{
    lua_newtable(L);
    bind_set_text(L, "name", s->name);
    bind_set_text(L, "help", s->doc);
    push_rows(L, s->rows);
    lua_setfield(L, -2, "fields");
}

/* core.schemas(kind) -> list of {name =, help =, fields = {name = {spec, help, ...}}}; kinds of dig_schema_at, "pair" and "part" */
static int list_schemas(lua_State *L)
{
    const char *kind = luaL_checkstring(L, 1);
    const dig_schema *s;
    lua_newtable(L);
    for (int i = 0; (s = dig_schema_at(kind, i)) != NULL; i++) {
        push_schema(L, s);
        lua_rawseti(L, -2, i + 1);
    }
    const dig_schema pair = {"pair", "what two materials make of each other", bind_pair_rows(), sizeof(dig_pair_def)};
    const dig_schema part = {"part", "the place of a shape in a body", bind_part_rows(), sizeof(ShapeRef)};
    if (strcmp(kind, "pair") == 0 || strcmp(kind, "part") == 0) {
        push_schema(L, strcmp(kind, "pair") == 0 ? &pair : &part);
        lua_rawseti(L, -2, 1);
    }
    return 1;
}

/* core.effect_schemas(part) -> the same of effects: their options ("world") or their fields of bodies ("body") */
static int list_effect_schemas(lua_State *L)
{
    const char *part = luaL_checkstring(L, 1);
    dig_schema s;
    int n = 0;
    lua_newtable(L);
    for (int i = 0; dig_effect_schema(i, part, &s); i++)
        if (s.rows) {
            push_schema(L, &s);
            lua_rawseti(L, -2, ++n);
        }
    return 1;
}

/* core.material_names(world) -> list */
static int list_materials(lua_State *L)
{
    const WorldRef *ref = bind_check_world(L, 1);
    lua_newtable(L);
    for (int i = 0; dig_material_name(ref->w, i); i++) {
        lua_pushstring(L, dig_material_name(ref->w, i));
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* core.material_pairs(world) -> list of {a =, b =, friction =, ...}; what is not given goes by the rule for pairs */
static int list_pairs(lua_State *L)
{
    const WorldRef *ref = bind_check_world(L, 1);
    dig_pair_def def;
    lua_newtable(L);
    for (int i = 0; dig_material_pair_at(ref->w, i, &def); i++) {
        lua_newtable(L);
        bind_set_text(L, "a", def.a.s);
        bind_set_text(L, "b", def.b.s);
        for (const dig_param *row = bind_pair_rows(); row->name; row++) {
            real x = row->kind == DIG_REAL ? *(const real *)(const void *)((const char *)&def + row->offset) : (real)NAN;
            if (!isnan(x))
                bind_set_real(L, row->name, x);
        }
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

void bind_schema_open(lua_State *L, int core)
{
    static const luaL_Reg functions[] = {
        {"schemas", list_schemas}, {"effect_schemas", list_effect_schemas}, {"material_names", list_materials},
        {"material_pairs", list_pairs}, {NULL, NULL},
    };
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
