/* lua/bind_joint.c - joints: constructors made from the list of joint types, reading, setting parameters, removing. */

#include "bind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* name a b at axis breaks_at collides; offsets into dig_joint_def */
static const dig_param *common_rows(void)
{
    return dig_schema_at("joint.common", 0)->rows;
}

/* Other names of common fields; a type that has a row of that name keeps it. */
static const struct { const char *alias, *name; } aliases[] = {
    {"along", "axis"}, {"holds", "a"}, {"into", "b"}, {"strength", "breaks_at"},
};
enum { ALIAS_COUNT = sizeof aliases / sizeof *aliases };

static const dig_param *find_row(const dig_param *rows, const char *name)
{
    for (const dig_param *row = rows; row && row->name; row++)
        if (strcmp(row->name, name) == 0)
            return row;
    return NULL;
}

/* ---- creating --------------------------------------------------------------------- */

/* The key at -2 says no more than leaving it away: motor = false, or b = the world that the joint is in. */
static bool says_nothing(lua_State *L, const dig_schema *schema)
{
    const char *key = lua_tostring(L, -2);
    if (lua_isboolean(L, -1) && !lua_toboolean(L, -1)) {
        const dig_param *row = find_row(schema->rows, key);
        return row && (row->kind == DIG_TABLE || row->kind == DIG_RANGE);
    }
    for (const dig_param *row = schema->rows; row->name; row++)
        if (row->kind == DIG_JOINT)             /* it couples joints: none of them is the world */
            return false;
    return (strcmp(key, "b") == 0 || strcmp(key, "into") == 0) && lua_rawequal(L, -1, 1);
}

/* Makes a copy of the table at 2 in which aliases have their own names. */
static void resolve_aliases(lua_State *L, const char *what, const dig_schema *schema, bool used[ALIAS_COUNT])
{
    lua_newtable(L);
    for (lua_pushnil(L); lua_next(L, 2); lua_pop(L, 1)) {
        if (says_nothing(L, schema))
            continue;
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, -5);
    }
    lua_replace(L, 2);
    for (int i = 0; i < ALIAS_COUNT; i++) {
        used[i] = false;
        if (find_row(schema->rows, aliases[i].alias))
            continue;
        if (bind_own_field(L, 2, aliases[i].alias) != LUA_TNIL) {
            if (bind_own_field(L, 2, aliases[i].name) != LUA_TNIL)
                bind_error(L, "%s: %s and %s are the same field", what, aliases[i].alias, aliases[i].name);
            lua_pop(L, 1);
            lua_setfield(L, 2, aliases[i].name);
            lua_pushnil(L);
            lua_setfield(L, 2, aliases[i].alias);
            used[i] = true;
        } else {
            lua_pop(L, 1);
        }
    }
}

/* A gear couples joints: a and b then stand for the type's own handles of joints, in order. */
static void take_coupled_joints(const Fill *f, const dig_schema *schema, char *data)
{
    static const char *const ends[] = {"a", "b"};
    lua_State *L = f->L;
    int next = 0;
    for (const dig_param *row = schema->rows; row->name && next < 2; row++) {
        if (row->kind != DIG_JOINT)
            continue;
        if (lua_getfield(L, f->table, ends[next]) != LUA_TNIL && !find_row(schema->rows, ends[next])) {
            dig_param named = *row;
            named.name = ends[next];
            bind_fill_field(f, &named, data + row->offset);
            lua_pushnil(L);
            lua_setfield(L, f->table, ends[next]);
        }
        lua_pop(L, 1);
        next++;
    }
}

/* Errors call a field what the script called it. */
static void fill_common(const Fill *f, const dig_schema *schema, dig_joint_def *def, const bool used[ALIAS_COUNT])
{
    lua_State *L = f->L;
    for (const dig_param *row = common_rows(); row->name; row++) {
        if (find_row(schema->rows, row->name))
            continue;
        dig_param named = *row;
        for (int i = 0; i < ALIAS_COUNT; i++)
            if (used[i] && strcmp(aliases[i].name, row->name) == 0)
                named.name = aliases[i].alias;
        if (lua_getfield(L, f->table, row->name) != LUA_TNIL)
            bind_fill_field(f, &named, (char *)def + row->offset);
        lua_pop(L, 1);
    }
}

static void check_joint_keys(lua_State *L, const char *what, const dig_schema *schema)
{
    const dig_param *sets[] = {schema->rows, common_rows(), NULL};
    const char *names[ALIAS_COUNT + 1] = {NULL};
    for (int i = 0; i < ALIAS_COUNT; i++)
        names[i] = aliases[i].alias;
    bind_check_keys(L, 2, what, sets, names);
}

/* upvalues: schema, "world:hinge" */
static int make_joint(lua_State *L)
{
    const dig_schema *schema = lua_touserdata(L, lua_upvalueindex(1));
    const char *what = lua_tostring(L, lua_upvalueindex(2));
    WorldRef *ref = bind_check_world(L, 1);
    dig_joint_def def = dig_joint_defaults();
    dig_joint id;

    lua_settop(L, 2);
    if (!lua_istable(L, 2))
        return bind_wants_fields(L, 2, what);
    check_joint_keys(L, what, schema);
    bool used[ALIAS_COUNT];
    resolve_aliases(L, what, schema, used);
    char *data = lua_newuserdatauv(L, schema->size > 0 ? schema->size : 1, 0);
    dig_schema_defaults(schema, data);
    lua_newtable(L);
    Fill fill = {L, 2, 4, what, what, ref};
    if (bind_own_field(L, 2, "name") == LUA_TSTRING && lua_rawlen(L, -1) > 0)
        fill.subject = lua_pushfstring(L, "joint '%s'", lua_tostring(L, -1));
    take_coupled_joints(&fill, schema, data);
    bind_fill(&fill, schema->rows, data);
    fill_common(&fill, schema, &def, used);
    def.type = schema->name;
    def.data = data;
    dig_status s = dig_joint_create(ref->w, &def, &id);
    if (s != DIG_OK) {
        const char *text = dig_error(ref->w);
        bool named = strncmp(text, "joint '", 7) == 0;
        size_t type = strlen(schema->name);         /* world:hinge says it already */
        if (strncmp(text, schema->name, type) == 0 && strncmp(text + type, ": ", 2) == 0)
            text += type + 2;
        return bind_fail_text(L, s, "%s%s%s", named ? "" : what, named ? "" : ": ", text);
    }
    bind_note(L, 1, "joints", id.slot, id.gen);
    bind_push_joint(L, 1, id);
    return 1;
}

/* ---- reading ------------------------------------------------------------------------ */

static dig_joint_state state(lua_State *L)
{
    JointRef *j = bind_check_joint(L, 1);
    dig_joint_state s;
    dig_status status = dig_joint_get(j->world->w, j->id, &s);
    if (status != DIG_OK)
        bind_fail(L, j->world->w, status);
    return s;
}

static int push_end(lua_State *L, dig_body id)
{
    bind_push_world_of(L, 1);
    bind_push_body(L, lua_gettop(L), id);
    return 1;
}

static int get_type(lua_State *L) { lua_pushstring(L, state(L).type); return 1; }
static int get_a(lua_State *L) { return push_end(L, state(L).a); }
static int get_b(lua_State *L) { return push_end(L, state(L).b); }
static int get_at(lua_State *L) { bind_push_vec3(L, state(L).at); return 1; }
static int get_angle(lua_State *L) { lua_pushnumber(L, state(L).angle); return 1; }
static int get_distance(lua_State *L) { lua_pushnumber(L, state(L).distance); return 1; }
static int get_speed(lua_State *L) { lua_pushnumber(L, state(L).speed); return 1; }
static int get_force(lua_State *L) { bind_push_vec3(L, state(L).force); return 1; }
static int get_torque(lua_State *L) { bind_push_vec3(L, state(L).torque); return 1; }
static int get_stress(lua_State *L) { lua_pushnumber(L, state(L).stress); return 1; }
static int get_error(lua_State *L) { lua_pushnumber(L, state(L).error); return 1; }
static int get_at_limit(lua_State *L) { lua_pushboolean(L, state(L).at_limit); return 1; }

static int get_valid(lua_State *L)
{
    JointRef *j = luaL_checkudata(L, 1, BIND_JOINT);
    lua_pushboolean(L, j->world->w && dig_joint_alive(j->world->w, j->id));
    return 1;
}

static int get_name(lua_State *L)
{
    JointRef *j = luaL_checkudata(L, 1, BIND_JOINT);
    if (j->world->w && dig_joint_alive(j->world->w, j->id))
        lua_pushstring(L, state(L).name);
    else
        lua_getiuservalue(L, 1, REF_NAME);
    return 1;
}

/* ---- setting -------------------------------------------------------------------------- */

enum { FIELD_BYTES = 256, SETTINGS = 32 };

/* Parameters of one joint, read and checked by their rows; names and texts are kept by the Lua stack. */
typedef struct Settings {
    dig_setting set[SETTINGS];
    union { real align; char bytes[FIELD_BYTES]; } field[SETTINGS];
    int         count;
} Settings;

static void *next_setting(lua_State *L, Settings *s, const char *path)
{
    if (s->count == SETTINGS)
        bind_error(L, "joint:set: more than %d parameters", SETTINGS);
    s->set[s->count] = (dig_setting){path, s->field[s->count].bytes};
    return s->field[s->count++].bytes;
}

/* nil or false: as if it had not been given. */
static void clear_row(lua_State *L, Settings *s, const dig_param *row, const char *path)
{
    luaL_checkstack(L, 8, "parameters of a joint");
    for (const dig_param *inner = row->kind == DIG_TABLE ? row->rows : NULL; inner && inner->name; inner++)
        clear_row(L, s, inner, lua_pushfstring(L, "%s.%s", path, inner->name));
    if (row->kind == DIG_TABLE)
        return;
    if (row->required || (row->kind != DIG_REAL && row->kind != DIG_RANGE))
        bind_error(L, "joint.%s cannot be taken away, it has to have a value", path);
    const real none[2] = {row->fallback, row->fallback};
    memcpy(next_setting(L, s, path), none, row->kind == DIG_REAL ? sizeof none[0] : sizeof none);
}

/* Takes the value on top of the stack; leaves what has to be kept there. */
static void read_row(lua_State *L, JointRef *j, Settings *s, const dig_param *row, const char *path, const char *subject)
{
    int value = lua_gettop(L);
    luaL_checkstack(L, 8, "parameters of a joint");
    if (!lua_toboolean(L, value) && row->kind != DIG_BOOL) {
        clear_row(L, s, row, path);
        return;
    }
    if (row->kind == DIG_TABLE) {
        bind_thaw(L, value);
        if (!lua_istable(L, value))
            bind_error(L, "joint.%s wants a table; got %s", path, luaL_typename(L, value));
        const dig_param *sets[] = {row->rows, NULL};
        bind_check_keys(L, value, path, sets, NULL);
        for (const dig_param *inner = row->rows; inner && inner->name; inner++) {
            const char *name = lua_pushfstring(L, "%s.%s", path, inner->name);
            if (bind_own_field(L, value, inner->name) != LUA_TNIL)
                read_row(L, j, s, inner, name, subject);
            else
                lua_pop(L, 2);
        }
        return;
    }
    Fill fill = {L, value, value, "joint", subject, j->world};
    bind_fill_field(&fill, row, next_setting(L, s, path));
}

static bool is_shared(const char *key) { return strcmp(key, "breaks_at") == 0 || strcmp(key, "collides") == 0; }

static const dig_param *parameter_row(const dig_schema *schema, const char *key)
{
    const dig_param *row = schema ? find_row(schema->rows, key) : NULL;
    return row || !is_shared(key) ? row : find_row(common_rows(), key);
}

/* Pushes a table with the names of all parameters. */
static int push_parameter_names(lua_State *L, const dig_schema *schema)
{
    lua_newtable(L);
    for (int k = 0; k < 2; k++)
        for (const dig_param *row = k ? common_rows() : schema->rows; row->name; row++)
            if (k == 0 || is_shared(row->name)) {
                lua_pushboolean(L, 1);
                lua_setfield(L, -2, row->name);
            }
    return lua_gettop(L);
}

/* joint.angle = 1, joint.a = body */
static void refuse_state(lua_State *L, const char *type, const char *key)
{
    if (strcmp(key, "angle") == 0 || strcmp(key, "distance") == 0 || strcmp(key, "speed") == 0)
        bind_error(L, "joint.%s is state and cannot be assigned: a motor or a spring of the joint brings it there (digbox api world:%s)", key, type);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "types");
    lua_getfield(L, -1, BIND_JOINT);
    lua_getfield(L, -1, "getters");
    if (lua_getfield(L, -1, key) != LUA_TNIL)
        bind_error(L, "joint.%s cannot be assigned", key);
    lua_pop(L, 5);
}

/* The value of `key` is on top of the stack. */
static void read_parameter(lua_State *L, JointRef *j, Settings *s, const char *key)
{
    dig_joint_state now = state(L);
    const dig_schema *schema = dig_schema_find("joint", now.type);
    const dig_param *row = parameter_row(schema, key);
    if (!row) {
        refuse_state(L, now.type, key);
        int names = push_parameter_names(L, schema);
        bind_unknown(L, now.type, "has no parameter", key, names, names);
    }
    const char *subject = lua_pushfstring(L, "joint '%s'", now.name);
    lua_insert(L, -2);
    read_row(L, j, s, row, key, subject);
}

static void apply(lua_State *L, JointRef *j, const Settings *s)
{
    dig_status status = dig_joint_set(j->world->w, j->id, s->set, s->count);
    if (status != DIG_OK)
        bind_fail(L, j->world->w, status);
}

/* joint.friction = 0.2   joint.motor = {speed = 3}   joint.breaks_at = "200 N" */
static int joint_newindex(lua_State *L)
{
    JointRef *j = bind_check_joint(L, 1);
    Settings s;
    s.count = 0;
    lua_settop(L, 3);
    const char *key = bind_name(L, 2, NULL);
    lua_pushvalue(L, 3);
    read_parameter(L, j, &s, key);
    apply(L, j, &s);
    return 0;
}

/* joint:set{motor = {speed = 2}, friction = 0.1} -> joint. All or none: a mistake in one leaves the joint as it was. */
static int joint_set(lua_State *L)
{
    JointRef *j = bind_check_joint(L, 1);
    Settings s;
    s.count = 0;
    if (!lua_istable(L, 2))
        return bind_error(L, "joint:set wants a table; got %s", luaL_typename(L, 2));
    lua_settop(L, 2);
    for (lua_pushnil(L); lua_next(L, 2); lua_pop(L, 1))
        if (lua_type(L, -2) != LUA_TSTRING)
            return bind_error(L, "joint:set: a parameter has a name; got a %s", luaL_typename(L, -2));
    int count;
    const char **names = bind_names(L, 2, 2, &count);
    for (int i = 0; i < count; i++) {
        luaL_checkstack(L, 8, "parameters of a joint");
        lua_pushstring(L, names[i]);
        lua_pushvalue(L, -1);
        lua_rawget(L, 2);
        read_parameter(L, j, &s, names[i]);
    }
    apply(L, j, &s);
    lua_settop(L, 1);
    return 1;
}

/* As it is given, in tables that are read only: one that is changed would change nothing. What is not set is nil. */
static void push_parameter(lua_State *L, int world, JointRef *j, const dig_param *row, const char *path)
{
    union { real align; char bytes[FIELD_BYTES]; } field;
    if (row->kind == DIG_TABLE) {
        luaL_checkstack(L, 8, "parameters of a joint");
        lua_newtable(L);
        for (const dig_param *inner = row->rows; inner && inner->name; inner++) {
            push_parameter(L, world, j, inner, lua_pushfstring(L, "%s.%s", path, inner->name));
            lua_remove(L, -2);
            lua_setfield(L, -2, inner->name);
        }
        bind_freeze(L, lua_pushfstring(L, "joint.%s", path));
        return;
    }
    dig_status s = dig_joint_param(j->world->w, j->id, path, field.bytes);
    if (s != DIG_OK)
        bind_fail(L, j->world->w, s);
    real first = 0;
    if (row->kind == DIG_REAL || row->kind == DIG_RANGE || row->kind == DIG_PAIR)
        memcpy(&first, field.bytes, sizeof first);
    if (isnan(first))
        lua_pushnil(L);
    else
        bind_push_field(L, world, row, field.bytes);
    if (lua_istable(L, -1))
        bind_freeze(L, lua_pushfstring(L, "joint.%s", path));
}

/* Parameters of its type are read as they are set. */
static int joint_parameter(lua_State *L)
{
    JointRef *j = luaL_testudata(L, 1, BIND_JOINT);
    if (!j || lua_type(L, 2) != LUA_TSTRING || !j->world->w || !dig_joint_alive(j->world->w, j->id))
        return 0;
    const char *type = state(L).type;
    const dig_schema *schema = dig_schema_find("joint", type);
    const char *key = bind_string(L, 2, NULL);
    const dig_param *row = parameter_row(schema, key);
    if (row) {
        bind_push_world_of(L, 1);
        push_parameter(L, lua_gettop(L), j, row, key);
        return 1;
    }
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "types");
    lua_getfield(L, -1, BIND_JOINT);
    lua_getfield(L, -1, "getters");
    lua_getfield(L, -2, "methods");
    int names = push_parameter_names(L, schema);
    return bind_unknown(L, type, "has no field or method", key, names - 2, names);
}

/* joint:remove() */
static int joint_remove(lua_State *L)
{
    JointRef *j = bind_check_joint(L, 1);
    dig_joint_state s = state(L);
    lua_settop(L, 1);
    bind_push_world_of(L, 1);
    bind_where(L);
    const char *where = luaL_gsub(L, lua_tostring(L, -1), ": ", "");
    const char *how = lua_pushfstring(L, "joint '%s' was removed%s%s", s.name, *where ? " at " : "", where);
    bind_mark_removed(L, 2, "joints", j->id.slot, j->id.gen, how);
    bind_forget(L, 2, "joints", j->id.slot, j->id.gen);
    dig_status status = dig_joint_remove(j->world->w, j->id);
    return status == DIG_OK ? 0 : bind_fail(L, j->world->w, status);
}

static int joint_tostring(lua_State *L)
{
    JointRef *j = luaL_checkudata(L, 1, BIND_JOINT);
    if (!j->world->w || !dig_joint_alive(j->world->w, j->id)) {
        lua_getiuservalue(L, 1, REF_NAME);
        const char *name = lua_tostring(L, -1);
        lua_pushfstring(L, name && *name ? "removed joint '%s'" : "removed joint", name);
        return 1;
    }
    dig_joint_state s = state(L);
    if (s.name && *s.name)
        lua_pushfstring(L, "%s '%s'", s.type, s.name);
    else
        lua_pushfstring(L, "%s #%d", s.type, (int)j->id.slot);
    return 1;
}

static int joint_eq(lua_State *L)
{
    const JointRef *a = luaL_testudata(L, 1, BIND_JOINT), *b = luaL_testudata(L, 2, BIND_JOINT);
    lua_pushboolean(L, a && b && a->world == b->world && a->id.slot == b->id.slot && a->id.gen == b->id.gen);
    return 1;
}

static const luaL_Reg methods[] = {{"set", joint_set}, {"remove", joint_remove}, {"withdraw", joint_remove}, {NULL, NULL}};
static const luaL_Reg getters[] = {
    {"type", get_type}, {"name", get_name}, {"a", get_a}, {"b", get_b}, {"at", get_at}, {"angle", get_angle}, {"distance", get_distance},
    {"speed", get_speed}, {"force", get_force}, {"torque", get_torque}, {"error", get_error}, {"stress", get_stress}, {"at_limit", get_at_limit},
    {"valid", get_valid}, {NULL, NULL},
};
static const luaL_Reg meta[] = {{"__newindex", joint_newindex}, {"__tostring", joint_tostring}, {"__eq", joint_eq}, {NULL, NULL}};

/* The method of type "hinge" is world:hinge; where that name is taken (ball is the sphere), world:ball_joint. */
void bind_joint_open(lua_State *L, int core)
{
    bind_type(L, core, BIND_JOINT, methods, getters, joint_parameter, meta);
    int top = lua_gettop(L);
    lua_getfield(L, core, "types");
    lua_getfield(L, -1, BIND_WORLD);
    lua_getfield(L, -1, "methods");
    int world = lua_gettop(L);
    const dig_schema *schema;
    for (int i = 0; (schema = dig_schema_at("joint", i)) != NULL; i++) {
        bool taken = lua_getfield(L, world, schema->name) != LUA_TNIL;
        const char *key = lua_pushfstring(L, "%s%s", schema->name, taken ? "_joint" : "");
        lua_pushlightuserdata(L, (void *)(uintptr_t)schema);
        lua_pushfstring(L, "world:%s", key);
        lua_pushcclosure(L, make_joint, 2);
        lua_setfield(L, world, key);
        lua_settop(L, world);
    }
    lua_newtable(L);
    for (int i = 0; i < ALIAS_COUNT; i++)
        bind_set_text(L, aliases[i].alias, aliases[i].name);
    lua_setfield(L, core, "joint_aliases");
    lua_settop(L, top);
}
