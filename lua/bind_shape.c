/* lua/bind_shape.c - constructors of bodies and of shapes for compounds, made from the list of shape types. */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PART_LIMIT = 4096, GRID_LIMIT = 4096 };

/* ---- a body around given shapes ------------------------------------------------ */

/* The table of fields is at 2, the world at 1. own: rows of the shape, already read. */
/* Filters of effects (effect.lua) wait for the body on top of the stack. */
static void note_newborn(lua_State *L)
{
    bind_push_state(L, 1);
    if (lua_getfield(L, -1, "newborn") == LUA_TTABLE) {
        lua_pushvalue(L, -3);
        lua_rawseti(L, -2, (lua_Integer)lua_rawlen(L, -2) + 1);
    }
    lua_pop(L, 2);
}

int bind_create_body(lua_State *L, const char *what, const dig_shape_def *shapes, int count, bool fixed, const dig_param *own,
                     const char *const *extras)
{
    WorldRef *ref = bind_check_world(L, 1);
    const dig_schema *schema = dig_schema_at("body", 0);
    const dig_param *sets[BIND_SETS];
    dig_body_def def = dig_body_defaults();
    dig_body id;

    bind_body_sets(own, sets);
    bind_check_keys(L, 2, what, sets, extras);
    lua_newtable(L);
    Fill fill = {L, 2, lua_gettop(L), what, what, ref};
    def.fixed = fixed;
    if (bind_own_field(L, 2, "name") == LUA_TSTRING && lua_rawlen(L, -1) > 0 && lua_rawlen(L, -1) < sizeof def.name.s)
        fill.subject = lua_pushfstring(L, "body '%s'", lua_tostring(L, -1));
    bind_fill(&fill, schema->rows, &def);
    bind_effects_read(&fill);
    int effects = lua_gettop(L);
    def.shapes = shapes;
    def.shape_count = count;
    dig_status s = dig_body_create(ref->w, &def, &id);
    if (s != DIG_OK) {
        /* The engine says which body; where it cannot, the constructor is named. */
        const char *text = dig_error(ref->w);
        bool named = strncmp(text, "body '", 6) == 0, nameless = strncmp(text, "body: ", 6) == 0;
        return bind_fail_text(L, s, "%s%s%s", named ? "" : what, named ? "" : ": ", nameless ? text + 6 : text);
    }
    bind_effects_join(L, effects, ref, id);
    bind_note(L, 1, "bodies", id.slot, id.gen);
    bind_push_body(L, 1, id);
    note_newborn(L);
    if (bind_own_field(L, 2, "data") != LUA_TNIL) {
        bind_push_state(L, 1);
        lua_getfield(L, -1, "data");
        lua_pushvalue(L, -3);
        lua_rawseti(L, -2, (lua_Integer)(((uint64_t)id.slot << 32) | id.gen));
        lua_pop(L, 2);
    }
    lua_pop(L, 1);
    return 1;
}

/* ---- heights: the one field that no row describes ---------------------------------- */

/* heights = {{h11, h12, ...}, {h21, ...}, ...}: one list a row (z), one number a column (x) */
static void read_heights(lua_State *L, int table, int anchor, const char *what, dig_heightfield_def *def)
{
    bind_own_field(L, table, "heights");
    if (!lua_istable(L, -1))
        bind_error(L, "%s.heights wants a list of rows {{h, h, ...}, ...}; got %s", what, luaL_typename(L, -1));
    lua_Unsigned rows = lua_rawlen(L, -1);
    lua_rawgeti(L, -1, 1);
    lua_Unsigned columns = lua_istable(L, -1) ? lua_rawlen(L, -1) : 0;
    bind_charge_items(L, (size_t)(rows * columns));
    lua_pop(L, 1);
    if (rows < 2 || columns < 2 || rows > GRID_LIMIT || columns > GRID_LIMIT)
        bind_error(L, "%s.heights has %d rows of %d columns, must have 2 to %d of each", what, (int)rows, (int)columns, GRID_LIMIT);
    real *heights = lua_newuserdatauv(L, rows * columns * sizeof *heights, 0);
    lua_rawseti(L, anchor, (lua_Integer)lua_rawlen(L, anchor) + 1);
    for (lua_Unsigned j = 0; j < rows; j++) {
        lua_rawgeti(L, -1, (lua_Integer)j + 1);
        if (!lua_istable(L, -1) || lua_rawlen(L, -1) != columns)
            bind_error(L, "%s.heights[%d] must have %d columns like the first", what, (int)j + 1, (int)columns);
        for (lua_Unsigned i = 0; i < columns; i++) {
            lua_rawgeti(L, -1, (lua_Integer)i + 1);
            real h = bind_real(L, -1, "m", what, "heights");
            if (isinf(h))
                bind_error(L, "%s.heights[%d][%d] = inf m, must be finite", what, (int)j + 1, (int)i + 1);
            heights[j * columns + i] = h;
            lua_pop(L, 1);
        }
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    def->heights = heights;
    def->rows = (int64_t)rows;
    def->columns = (int64_t)columns;
}

static const char *const height_keys[] = {"data", "heights", NULL};
static const char *const plain_keys[] = {"data", NULL};
static const char *const grid_keys[] = {"heights", NULL};

static bool is_heightfield(const dig_schema *schema)
{
    return schema->size == sizeof(dig_heightfield_def) && strcmp(schema->name, "heightfield") == 0;
}

static void fill_shape(const Fill *f, const dig_schema *schema, void *data)
{
    dig_schema_defaults(schema, data);
    bind_fill(f, schema->rows, data);
    if (is_heightfield(schema))
        read_heights(f->L, f->table, f->anchor, f->what, data);
}

/* A required row whose field is missing is an error here, with the script's names. */
static void check_required(lua_State *L, int table, const char *what, const dig_schema *schema)
{
    for (const dig_param *row = schema->rows; row->name; row++) {
        lua_pushstring(L, row->name);
        bool given = lua_rawget(L, table) != LUA_TNIL;
        lua_pop(L, 1);
        bool counted = is_heightfield(schema) && (strcmp(row->name, "rows") == 0 || strcmp(row->name, "columns") == 0);
        if (row->required && !given && !counted)
            bind_error(L, "%s: %s is missing%s", what, row->name,
                       strcmp(row->doc, row->name) == 0 ? "" : lua_pushfstring(L, " (%s)", row->doc));
    }
}

static void want_table(lua_State *L, int arg, const char *what)
{
    if (!lua_istable(L, arg))
        bind_wants_fields(L, arg, what);
}

/* ---- world:sphere{...} and its kind --------------------------------------------------- */

/* upvalues: schema, "world:sphere" */
static int make_body(lua_State *L)
{
    const dig_schema *schema = lua_touserdata(L, lua_upvalueindex(1));
    const char *what = lua_tostring(L, lua_upvalueindex(2));
    WorldRef *ref = bind_check_world(L, 1);
    lua_settop(L, 2);
    want_table(L, 2, what);

    const dig_param *sets[BIND_SETS];
    bind_body_sets(schema->rows, sets);
    const char *const *extras = is_heightfield(schema) ? height_keys : plain_keys;
    bind_check_keys(L, 2, what, sets, extras);
    check_required(L, 2, what, schema);
    const char *subject = what;
    if (bind_own_field(L, 2, "name") == LUA_TSTRING && lua_rawlen(L, -1) > 0)
        subject = lua_pushfstring(L, "body '%s'", lua_tostring(L, -1));
    void *data = lua_newuserdatauv(L, schema->size, 0);
    lua_newtable(L);
    Fill fill = {L, 2, lua_gettop(L), what, subject, ref};
    fill_shape(&fill, schema, data);
    dig_shape_def shape = {schema->name, data, {{0, 0, 0}, {0, 0, 0, 1}}, {""}, {-1, -1, -1}, 0, NULL};
    bool endless = strcmp(schema->name, "plane") == 0 || is_heightfield(schema);
    return bind_create_body(L, what, &shape, 1, endless, schema->rows, extras);
}

/* ---- digbox.sphere{...}: a shape for a compound, an overlap or a sweep ------------------- */

#define OF_PART(field)    offsetof(ShapeRef, def) + offsetof(dig_shape_def, field)
#define OF_SURFACE(field) offsetof(ShapeRef, surface) + offsetof(dig_surface_def, field)

/* Ranges as those of a body (engine/api/schema.c). */
static const dig_param place_rows[] = {
    {"at", DIG_VEC3, "m", "place in the body", 0, -1e6, 1e6, OF_PART(at) + offsetof(pose, p), NULL, NULL, false, 0},
    {"rotation", DIG_QUAT, "", "turn in the body", 0, 0, 0, OF_PART(at) + offsetof(pose, q), NULL, NULL, false, 0},
    {"material", DIG_MATERIAL, "", "default: the body's", 0, 0, 0, OF_PART(material), NULL, NULL, false, 0},
    {"density", DIG_REAL, "kg/m^3", "default: the body's, else the material's", NAN, 1e-6, 1e9, OF_PART(density), NULL, NULL, false, 0},
    {"friction", DIG_REAL, "1", "static; default: the body's", NAN, 0, 100, OF_SURFACE(friction), NULL, NULL, false, 0},
    {"friction_dynamic", DIG_REAL, "1", "default: as static", NAN, 0, 100, OF_SURFACE(friction_dynamic), NULL, NULL, false, 0},
    {"rolling_friction", DIG_REAL, "1", "default: the body's", NAN, 0, 10, OF_SURFACE(rolling_friction), NULL, NULL, false, 0},
    {"restitution", DIG_REAL, "1", "default: the body's", NAN, 0, 1, OF_SURFACE(restitution), NULL, NULL, false, 0},
    {"colour", DIG_COLOUR, "1", "default: the body's", -1, 0, 1, OF_PART(colour), NULL, NULL, false, 0},
    {.name = NULL},
};

const dig_param *bind_part_rows(void) { return place_rows; }

/* upvalues: schema, "digbox.sphere" */
static int make_shape(lua_State *L)
{
    const dig_schema *schema = lua_touserdata(L, lua_upvalueindex(1));
    const char *what = lua_tostring(L, lua_upvalueindex(2));
    const dig_param *sets[] = {schema->rows, place_rows, NULL};
    lua_settop(L, 1);
    want_table(L, 1, what);
    bind_check_keys(L, 1, what, sets, is_heightfield(schema) ? grid_keys : NULL);
    check_required(L, 1, what, schema);

    size_t head = (sizeof(ShapeRef) + 15) / 16 * 16;
    ShapeRef *ref = lua_newuserdatauv(L, head + schema->size, 1);
    void *data = (char *)ref + head;
    ref->def = (dig_shape_def){schema->name, data, {{0, 0, 0}, {0, 0, 0, 1}}, {""}, {-1, -1, -1}, 0, &ref->surface};
    ref->surface = (dig_surface_def){NAN, NAN, NAN, NAN};
    lua_newtable(L);
    lua_pushvalue(L, -1);
    lua_setiuservalue(L, 2, 1);
    Fill fill = {L, 1, 3, what, what, NULL};
    fill_shape(&fill, schema, data);
    bind_fill(&fill, place_rows, ref);
    lua_settop(L, 2);
    luaL_setmetatable(L, BIND_SHAPE);
    return 1;
}

static int shape_tostring(lua_State *L)
{
    lua_pushfstring(L, "%s shape", bind_check_shape(L, 1)->def.type);
    return 1;
}

/* world:body{parts = {digbox.box{...}, ...}, ...} -> body
 * upvalues: nothing, "world:body" */
static int make_compound(lua_State *L)
{
    static const char *const extras[] = {"data", "parts", NULL};
    const char *what = lua_tostring(L, lua_upvalueindex(2));
    bind_check_world(L, 1);
    lua_settop(L, 2);
    want_table(L, 2, what);
    if (bind_own_field(L, 2, "parts") != LUA_TTABLE)
        return bind_error(L, "%s: parts is missing (a list such as {digbox.box{...}, ...})", what);
    lua_Unsigned n = lua_rawlen(L, 3);
    if (n == 0 || n > PART_LIMIT)
        return bind_error(L, "%s.parts has %d shapes, must have 1 to %d", what, (int)n, PART_LIMIT);
    dig_shape_def *shapes = lua_newuserdatauv(L, n * sizeof *shapes, 0);
    for (lua_Unsigned i = 0; i < n; i++) {
        lua_rawgeti(L, 3, (lua_Integer)i + 1);
        ShapeRef *part = luaL_testudata(L, -1, BIND_SHAPE);
        if (!part)
            return bind_error(L, "%s.parts[%d] wants a shape such as digbox.box{...}; got %s", what, (int)i + 1, luaL_typename(L, -1));
        shapes[i] = part->def;
        lua_pop(L, 1);
    }
    return bind_create_body(L, what, shapes, (int)n, false, NULL, extras);
}

/* ---- tables -------------------------------------------------------------------------- */

static void add_constructor(lua_State *L, int table, const char *key, const char *prefix, const char *name, lua_CFunction f,
                            const dig_schema *schema)
{
    lua_pushlightuserdata(L, (void *)(uintptr_t)schema);
    lua_pushfstring(L, "%s%s", prefix, name);
    lua_pushcclosure(L, f, 2);
    lua_setfield(L, table, key);
}

/* core.check_body(fields, what): the fields that bodies have, among others; an error for a bad one */
static int check_body(lua_State *L)
{
    dig_body_def def = dig_body_defaults();
    const char *what = luaL_checkstring(L, 2);
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_newtable(L);
    Fill fill = {L, 1, lua_gettop(L), what, what, NULL};
    bind_fill(&fill, dig_schema_at("body", 0)->rows, &def);
    bind_effects_read(&fill);
    return 0;
}

/* core.constructor(type, "world:rod") -> the constructor of that shape type ("body": of compounds) under another name */
static int make_constructor(lua_State *L)
{
    const char *type = luaL_checkstring(L, 1);
    const dig_schema *schema = dig_schema_find("shape", type);
    bool compound = strcmp(type, "body") == 0;
    if (!schema && !compound)
        return luaL_error(L, "no shape type '%s'", type);
    lua_pushlightuserdata(L, (void *)(uintptr_t)schema);
    lua_pushvalue(L, 2);
    lua_pushcclosure(L, compound ? make_compound : make_body, 2);
    return 1;
}

/* core.body_fields: the names of a body's fields */
static void list_body_fields(lua_State *L, int core)
{
    lua_newtable(L);
    lua_pushboolean(L, 1);
    lua_setfield(L, -2, "data");
    const dig_param *sets[BIND_SETS];
    bind_body_sets(NULL, sets);
    for (int i = 0; sets[i]; i++)
        for (const dig_param *row = sets[i]; row->name; row++)
            bind_set_bool(L, row->name, true);
    lua_setfield(L, core, "body_fields");
}

void bind_shape_open(lua_State *L, int core)
{
    static const luaL_Reg methods[] = {{NULL, NULL}};
    static const luaL_Reg meta[] = {{"__tostring", shape_tostring}, {NULL, NULL}};
    bind_type(L, core, BIND_SHAPE, methods, NULL, NULL, meta);

    lua_newtable(L);
    int shapes = lua_gettop(L);
    lua_getfield(L, core, "types");
    lua_getfield(L, -1, BIND_WORLD);
    lua_getfield(L, -1, "methods");
    int world = lua_gettop(L);
    const dig_schema *schema;
    for (int i = 0; (schema = dig_schema_at("shape", i)) != NULL; i++) {
        add_constructor(L, world, schema->name, "world:", schema->name, make_body, schema);
        add_constructor(L, shapes, schema->name, "digbox.", schema->name, make_shape, schema);
        if (strcmp(schema->name, "sphere") == 0)
            add_constructor(L, world, "ball", "world:", "ball", make_body, schema);
    }
    add_constructor(L, world, "body", "world:", "body", make_compound, NULL);
    lua_pushcfunction(L, make_constructor);
    lua_setfield(L, core, "constructor");
    lua_pushcfunction(L, check_body);
    lua_setfield(L, core, "check_body");
    list_body_fields(L, core);
    lua_pushvalue(L, shapes);
    lua_setfield(L, core, "shapes");
    lua_settop(L, shapes - 1);
}
