/* lua/bind_fill.c - def structs from tables, by parameter rows. One switch over the kinds each way, and nothing that knows a type. */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"

enum { POINT_LIMIT = 4000000, MATERIAL_LIMIT = 256 };

/* ---- errors ------------------------------------------------------------------ */

static const char *unit_of(const dig_param *row)
{
    return row->unit && strcmp(row->unit, "1") != 0 ? row->unit : "";
}

/* Same words as the engine's own check of a def struct. part: "", ".x", "[2]" */
static void check_bounds(const Fill *f, const dig_param *row, const char *part, real x)
{
    const char *unit = unit_of(row), *gap = *unit ? " " : "";
    bool ranged = row->max > row->min;
    char value[96];
    snprintf(value, sizeof value, "%s: %s%s = %.6g%s%s", f->subject, row->name, part, x, gap, unit);
    if (isnan(x) || (isinf(x) && !(ranged && x >= row->min && x <= row->max)))
        bind_error(f->L, "%s, must be a finite number", value);
    if (!ranged || (x >= row->min && x <= row->max))
        return;
    if (row->min > 0 && !(x > 0))
        bind_error(f->L, "%s, must be > 0", value);
    if (x < row->min && !(row->min < 0) && !(row->min > 0))
        bind_error(f->L, "%s, must be >= 0", value);
    if (x < row->min)
        bind_error(f->L, "%s, must be at least %s%s%s", value, lua_pushfstring(f->L, "%f", row->min), gap, unit);
    bind_error(f->L, "%s, must be at most %s%s%s%s", value, lua_pushfstring(f->L, "%f", row->max), gap, unit,
               row->kind == DIG_COLOUR ? " (write {1, 0.5, 0}, '#ff8000' or a name)" : "");
}

/* "world", "plank", or what Lua calls it */
static const char *class_of(lua_State *L, int index)
{
    index = lua_absindex(L, index);
    return luaL_getmetafield(L, index, "__name") == LUA_TSTRING ? lua_tostring(L, -1) : luaL_typename(L, index);
}

static void wrong_kind(const Fill *f, const dig_param *row, const char *wanted)
{
    bind_error(f->L, "%s.%s wants %s; got %s", f->what, row->name, wanted, class_of(f->L, -1));
}

/* ---- one function per family of kinds ------------------------------------------ */

static real checked_real(const Fill *f, const dig_param *row, int index, const char *part)
{
    if (lua_type(f->L, index) == LUA_TNUMBER && isnan(lua_tonumber(f->L, index)))
        check_bounds(f, row, part, (real)NAN);
    real x = bind_real(f->L, index, row->unit, f->what, row->name);
    if (row->unit && strcmp(row->unit, "rad") == 0)
        bind_refuse_degrees(f->L, index, f->what, row->name);
    check_bounds(f, row, part, x);
    return x;
}

static void fill_vec3(const Fill *f, const dig_param *row, vec3 *field)
{
    lua_State *L = f->L;
    if (row->kind == DIG_SIZE3 && (lua_type(L, -1) == LUA_TNUMBER || lua_type(L, -1) == LUA_TSTRING)) {
        real x = checked_real(f, row, -1, "");
        *field = (vec3){x, x, x};
    } else {
        *field = bind_vec3(L, -1, row->unit, f->what, row->name);
    }
    check_bounds(f, row, ".x", field->x);
    check_bounds(f, row, ".y", field->y);
    check_bounds(f, row, ".z", field->z);
    if (row->kind == DIG_DIR && !bind_unit(field))
        bind_error(L, "%s: %s = {%g, %g, %g}, must not be zero: it is a direction", f->subject, row->name, field->x, field->y, field->z);
}

/* One sRGB channel to linear light (IEC 61966-2-1). */
static real linear_of(real c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

typedef struct Colour { const char *name; unsigned rgb; } Colour;

static const Colour colours[] = {
    {"black", 0x000000}, {"white", 0xffffff}, {"grey", 0x808080}, {"red", 0xd03028}, {"green", 0x2f9e44}, {"blue", 0x2f6fd0},
    {"yellow", 0xf2c530}, {"orange", 0xf08020}, {"purple", 0x8a4fc0}, {"brown", 0x7a5230}, {"cyan", 0x30b8c8}, {"pink", 0xe884a8},
};

static void fill_colour(const Fill *f, const dig_param *row, vec3 *field)
{
    lua_State *L = f->L;
    unsigned rgb = 0;
    if (lua_type(L, -1) != LUA_TSTRING) {
        fill_vec3(f, row, field);
        return;
    }
    const char *text = bind_string(L, -1, row->name);
    bool known = strlen(text) == 7 && text[0] == '#' && strspn(text + 1, "0123456789abcdefABCDEF") == 6 &&
                 sscanf(text + 1, "%x", &rgb) == 1;
    for (size_t i = 0; i < sizeof colours / sizeof *colours && !known; i++)
        if (strcmp(colours[i].name, text) == 0) {
            rgb = colours[i].rgb;
            known = true;
        }
    if (!known)
        bind_error(L, "%s.%s: unknown colour '%.40s' (write {r, g, b} from 0 to 1, '#rrggbb' or a name such as 'red')", f->what,
                   row->name, text);
    *field = (vec3){linear_of((rgb >> 16 & 255) / 255.0), linear_of((rgb >> 8 & 255) / 255.0), linear_of((rgb & 255) / 255.0)};
}

static void fill_range(const Fill *f, const dig_param *row, real *field)
{
    lua_State *L = f->L;
    bind_thaw(L, -1);
    if (!lua_istable(L, -1) || lua_rawlen(L, -1) != 2)
        wrong_kind(f, row, row->kind == DIG_RANGE ? "{lowest, highest}" : "{first, second}");
    for (int i = 0; i < 2; i++) {
        lua_rawgeti(L, -1, i + 1);
        field[i] = checked_real(f, row, -1, i == 0 ? "[1]" : "[2]");
        lua_pop(L, 1);
    }
    if (row->kind == DIG_RANGE && !(field[0] <= field[1]))
        bind_error(L, "%s: %s = {%s, %s}%s%s, must have the lower bound first", f->subject, row->name,
                   lua_pushfstring(L, "%f", field[0]), lua_pushfstring(L, "%f", field[1]), *unit_of(row) ? " " : "", unit_of(row));
}

static void fill_text(const Fill *f, const dig_param *row, dig_text *field)
{
    lua_State *L = f->L;
    size_t length = 0;
    if (lua_type(L, -1) != LUA_TSTRING)
        wrong_kind(f, row, "a text");
    const char *text = lua_tolstring(L, -1, &length);
    if (length >= sizeof field->s)
        bind_error(L, "%s.%s has %d bytes, must have at most %d", f->what, row->name, (int)length, (int)sizeof field->s - 1);
    if (strlen(text) < length || text_fault(text))
        bind_error(L, "%s.%s %s", f->what, row->name, strlen(text) < length ? "holds a control character" : text_fault(text));
    memset(field->s, 0, sizeof field->s);
    memcpy(field->s, text, length);
}

static void fill_material(const Fill *f, const dig_param *row, dig_text *field)
{
    dig_material_def def;
    fill_text(f, row, field);
    if (!f->world || !f->world->w || !field->s[0] || dig_material_get(f->world->w, field->s, &def) == DIG_OK)
        return;
    lua_State *L = f->L;
    lua_newtable(L);
    for (int i = 0; i < MATERIAL_LIMIT && dig_material_name(f->world->w, i); i++) {
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, dig_material_name(f->world->w, i));
    }
    const char *what = lua_pushfstring(L, "%s.%s:", f->what, row->name);
    bind_unknown(L, what, "unknown material", field->s, lua_gettop(L) - 1, lua_gettop(L) - 1);
}

static void fill_choice(const Fill *f, const dig_param *row, int64_t *field)
{
    lua_State *L = f->L;
    if (lua_type(L, -1) != LUA_TSTRING)
        wrong_kind(f, row, "one of its names");
    const char *text = bind_string(L, -1, row->name);
    lua_newtable(L);
    for (int i = 0; row->choices[i]; i++) {
        if (strcmp(row->choices[i], text) == 0) {
            *field = i;
            lua_pop(L, 1);
            return;
        }
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, row->choices[i]);
    }
    const char *what = lua_pushfstring(L, "%s.%s:", f->what, row->name);
    bind_unknown(L, what, "unknown choice", text, lua_gettop(L) - 1, lua_gettop(L) - 1);
}

/* Arrays live in userdata that the anchor table keeps. */
static void *anchored(const Fill *f, size_t bytes)
{
    void *block = lua_newuserdatauv(f->L, bytes > 0 ? bytes : 1, 0);
    lua_rawseti(f->L, f->anchor, (lua_Integer)lua_rawlen(f->L, f->anchor) + 1);
    return block;
}

static int list_length(const Fill *f, const dig_param *row, const char *wanted)
{
    if (!lua_istable(f->L, -1))
        wrong_kind(f, row, wanted);
    lua_Unsigned n = lua_rawlen(f->L, -1);
    int most = row->most > 0 ? row->most : POINT_LIMIT;
    if (n > (lua_Unsigned)most)
        bind_error(f->L, "%s.%s has %.0f entries, must have at most %d", f->what, row->name, (lua_Number)n, most);
    bind_charge_items(f->L, (size_t)n);
    return (int)n;
}

/* {x, y, z} of three finite numbers, as nearly all are; what else there may be, and what is wrong with it, is bind_vec3's. */
static bool plain_point(lua_State *L, vec3 *out)
{
    real *x[3] = {&out->x, &out->y, &out->z};
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 3)
        return false;
    bool fine = true;
    for (int i = 0; i < 3 && fine; i++) {
        fine = lua_rawgeti(L, -1, i + 1) == LUA_TNUMBER;
        *x[i] = fine ? lua_tonumber(L, -1) : 0;
        fine = fine && isfinite(*x[i]);
        lua_pop(L, 1);
    }
    return fine;
}

static void fill_points(const Fill *f, const dig_param *row, dig_points *field)
{
    lua_State *L = f->L;
    int n = list_length(f, row, "a list of points {{x, y, z}, ...}");
    vec3 *v = anchored(f, (size_t)n * sizeof *v);
    for (int i = 0; i < n; i++) {
        char name[96];
        lua_rawgeti(L, -1, i + 1);
        if (!plain_point(L, &v[i])) {
            snprintf(name, sizeof name, "%s[%d]", row->name, i + 1);
            v[i] = bind_vec3(L, -1, row->unit, f->what, name);
        }
        lua_pop(L, 1);
    }
    *field = (dig_points){v, n};
}

/* Numbers one after the other, or in groups: {1, 2, 3, ...} and {{1, 2, 3}, ...} */
static void fill_indices(const Fill *f, const dig_param *row, dig_indices *field)
{
    lua_State *L = f->L;
    int n = list_length(f, row, "a list of whole numbers"), total = 0;
    for (int i = 0; i < n; i++) {
        lua_rawgeti(L, -1, i + 1);
        lua_Unsigned m = lua_istable(L, -1) ? lua_rawlen(L, -1) : 1;    /* of a table with holes: any number */
        lua_pop(L, 1);
        total = m > POINT_LIMIT ? POINT_LIMIT + 1 : total + (int)m;
        if (total > POINT_LIMIT)
            bind_error(L, "%s.%s has more than %d entries", f->what, row->name, POINT_LIMIT);
    }
    int64_t *v = anchored(f, (size_t)total * sizeof *v);
    int k = 0;
    for (int i = 0; i < n; i++) {
        lua_rawgeti(L, -1, i + 1);
        if (!lua_istable(L, -1)) {
            v[k++] = bind_int(L, -1, f->what, row->name);
        } else {
            for (int j = 1, m = (int)lua_rawlen(L, -1); j <= m; j++) {
                lua_rawgeti(L, -1, j);
                v[k++] = bind_int(L, -1, f->what, row->name);
                lua_pop(L, 1);
            }
        }
        lua_pop(L, 1);
    }
    *field = (dig_indices){v, k};
}

static void fill_body(const Fill *f, const dig_param *row, dig_body *field)
{
    lua_State *L = f->L;
    const WorldRef *world = luaL_testudata(L, -1, BIND_WORLD);
    bool first = strcmp(row->name, "a") == 0 || strcmp(row->name, "holds") == 0;
    if (lua_type(L, -1) == LUA_TSTRING)
        bind_error(L, "%s.%s wants a body; got the text '%.60s' (world:find gives the body of a name)", f->what, row->name, lua_tostring(L, -1));
    if (world)
        bind_error(L, "%s.%s wants a body; got %s (%s)", f->what, row->name, world == f->world ? "world" : "another world",
                   first ? "give the body as a, and b = world or no b" : "what is held by the world has none");
    if (!luaL_testudata(L, -1, BIND_BODY))
        wrong_kind(f, row, "a body");
    *field = (f->world ? bind_body_of(L, lua_gettop(L), f->world) : bind_check_body(L, lua_gettop(L)))->id;
}

static void fill_joint(const Fill *f, const dig_param *row, dig_joint *field)
{
    lua_State *L = f->L;
    if (!luaL_testudata(L, -1, BIND_JOINT))
        wrong_kind(f, row, "a joint");
    JointRef *ref = bind_check_joint(L, lua_gettop(L));
    if (f->world && ref->world != f->world)
        bind_error(L, "%s.%s: the joint belongs to another world", f->what, row->name);
    *field = ref->id;
}

static void fill_table(const Fill *f, const dig_param *row, void *field)
{
    lua_State *L = f->L;
    bind_thaw(L, -1);
    if (!lua_istable(L, -1))
        wrong_kind(f, row, "a table");
    const dig_param *sets[] = {row->rows, NULL};
    luaL_checkstack(L, 8, "tables too deep");
    int top = lua_gettop(L);
    const char *what = lua_pushfstring(L, "%s.%s", f->what, row->name);
    const char *subject = lua_pushfstring(L, "%s: %s", f->subject, row->name);
    Fill inner = {L, top, f->anchor, what, subject, f->world};
    bind_check_keys(L, top, what, sets, NULL);
    bind_fill(&inner, row->rows, field);
    lua_settop(L, top);
}

void bind_fill_field(const Fill *f, const dig_param *row, void *field)
{
    lua_State *L = f->L;
    switch (row->kind) {
    case DIG_REAL:
        *(real *)field = checked_real(f, row, -1, "");
        break;
    case DIG_INT: {
        lua_Integer i = bind_int(L, -1, f->what, row->name);
        check_bounds(f, row, "", (real)i);
        *(int64_t *)field = i;
        break;
    }
    case DIG_BOOL:
        if (!lua_isboolean(L, -1))
            wrong_kind(f, row, "true or false");
        *(bool *)field = lua_toboolean(L, -1);
        break;
    case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: fill_vec3(f, row, field); break;
    case DIG_QUAT: *(quat *)field = bind_quat(L, -1, f->what, row->name); break;
    case DIG_RANGE: case DIG_PAIR: fill_range(f, row, field); break;
    case DIG_COLOUR: fill_colour(f, row, field); break;
    case DIG_TEXT: fill_text(f, row, field); break;
    case DIG_MATERIAL: fill_material(f, row, field); break;
    case DIG_BODY: fill_body(f, row, field); break;
    case DIG_JOINT: fill_joint(f, row, field); break;
    case DIG_POINTS: fill_points(f, row, field); break;
    case DIG_INDICES: fill_indices(f, row, field); break;
    case DIG_TABLE: fill_table(f, row, field); break;
    case DIG_CHOICE: fill_choice(f, row, field); break;
    }
}

void bind_fill(const Fill *f, const dig_param *rows, void *base)
{
    lua_State *L = f->L;
    luaL_checkstack(L, 8, "tables too deep");
    for (const dig_param *row = rows; row && row->name; row++) {
        lua_pushstring(L, row->name);
        if (lua_rawget(L, f->table) != LUA_TNIL)
            bind_fill_field(f, row, (char *)base + row->offset);
        lua_pop(L, 1);
    }
}

/* ---- unknown keys ---------------------------------------------------------------- */

static bool known_key(const char *key, const dig_param *const *sets, const char *const *extras)
{
    for (int i = 0; sets && sets[i]; i++)
        for (const dig_param *row = sets[i]; row->name; row++)
            if (strcmp(row->name, key) == 0)
                return true;
    for (int i = 0; extras && extras[i]; i++)
        if (strcmp(extras[i], key) == 0)
            return true;
    return false;
}

static void fail_unknown_key(lua_State *L, const char *what, const char *key, const dig_param *const *sets, const char *const *extras)
{
    lua_newtable(L);
    int names = lua_gettop(L);
    for (int i = 0; sets && sets[i]; i++)
        for (const dig_param *row = sets[i]; row->name; row++) {
            lua_pushboolean(L, 1);
            lua_setfield(L, names, row->name);
        }
    for (int i = 0; extras && extras[i]; i++) {
        lua_pushboolean(L, 1);
        lua_setfield(L, names, extras[i]);
    }
    bind_unknown(L, lua_pushfstring(L, "%s:", what), "unknown field", key, names, names);
}

/* A key that is no name: the least of the numbers, else what kind of thing the first in the alphabet of kinds is. */
static void fail_nameless_key(lua_State *L, int table, const char *what)
{
    const char *kind = NULL;
    bool number = false;
    lua_settop(L, lua_gettop(L) - 2);
    lua_pushnil(L);                     /* the least number so far */
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        int type = lua_type(L, -2);
        if (type == LUA_TNUMBER && (!number || lua_compare(L, -2, -3, LUA_OPLT))) {
            lua_pushvalue(L, -2);
            lua_replace(L, -4);
            number = true;
        } else if (type != LUA_TNUMBER && type != LUA_TSTRING && (!kind || strcmp(luaL_typename(L, -2), kind) < 0)) {
            kind = luaL_typename(L, -2);
        }
    }
    const char *name = number ? lua_tostring(L, -1) : kind, *example = bind_example(L, what);
    bind_error(L, "%s: unknown field %s (fields have names%s%s)", what, name, *example ? ": " : "", example);
}

void bind_check_keys(lua_State *L, int table, const char *what, const dig_param *const *sets, const char *const *extras)
{
    table = lua_absindex(L, table);
    const char *worst = NULL;           /* the first in the alphabet, so that the message does not depend on the order of next */
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            fail_nameless_key(L, table, what);
        const char *key = bind_string(L, -2, what);
        if (!known_key(key, sets, extras) && (!worst || strcmp(key, worst) < 0))
            worst = key;
    }
    if (worst)
        fail_unknown_key(L, what, worst, sets, extras);
}

/* ---- the way back -------------------------------------------------------------------- */

void bind_push_field(lua_State *L, int world, const dig_param *row, const void *field)
{
    switch (row->kind) {
    case DIG_REAL: lua_pushnumber(L, *(const real *)field); break;
    case DIG_INT: lua_pushinteger(L, *(const int64_t *)field); break;
    case DIG_BOOL: lua_pushboolean(L, *(const bool *)field); break;
    case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: bind_push_vec3(L, *(const vec3 *)field); break;
    case DIG_QUAT: bind_push_quat(L, *(const quat *)field); break;
    case DIG_TEXT: case DIG_MATERIAL: lua_pushstring(L, ((const dig_text *)field)->s); break;
    case DIG_BODY: bind_push_body(L, world, *(const dig_body *)field); break;
    case DIG_JOINT: bind_push_joint(L, world, *(const dig_joint *)field); break;
    case DIG_CHOICE: lua_pushstring(L, row->choices[*(const int64_t *)field]); break;
    case DIG_RANGE: case DIG_PAIR:
        lua_createtable(L, 2, 0);
        for (int i = 0; i < 2; i++) {
            lua_pushnumber(L, ((const real *)field)[i]);
            lua_rawseti(L, -2, i + 1);
        }
        break;
    case DIG_TABLE:
        lua_newtable(L);
        for (const dig_param *inner = row->rows; inner && inner->name; inner++) {
            bind_push_field(L, world, inner, (const char *)field + inner->offset);
            lua_setfield(L, -2, inner->name);
        }
        break;
    case DIG_POINTS: case DIG_INDICES: lua_pushnil(L); break;
    }
}
