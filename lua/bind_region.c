/* lua/bind_region.c - regions with laws of their own, and the one way in which regions, overlaps and sweeps are told a shape. */

#include "bind.h"

#include <string.h>


/* ---- the shape of a query ------------------------------------------------------- */

/* The shape on top of the stack becomes the field "shape" of a copy of the table at 2, without the field that it came from: skip,
 * or [1] when that is NULL. */
static void put_shape(lua_State *L, const char *what, const char *skip)
{
    int shape = lua_gettop(L);
    lua_newtable(L);
    for (lua_pushnil(L); lua_next(L, 2); lua_pop(L, 1)) {
        bool skipped = skip ? lua_type(L, -2) == LUA_TSTRING && strcmp(bind_string(L, -2, NULL), skip) == 0
                            : lua_isinteger(L, -2) && lua_tointeger(L, -2) == 1;
        if (lua_type(L, -2) == LUA_TSTRING && strcmp(bind_string(L, -2, NULL), "shape") == 0)
            bind_error(L, "%s: the shape is given twice", what);
        if (skipped)
            continue;
        lua_pushvalue(L, -2);
        lua_pushvalue(L, -2);
        lua_rawset(L, shape + 1);
    }
    lua_pushvalue(L, shape);
    lua_setfield(L, shape + 1, "shape");
    lua_replace(L, 2);
    lua_settop(L, shape - 1);
}

/* sphere = {radius = 1} in the place of shape = digbox.sphere{radius = 1} */
static void use_kind_names(lua_State *L, const char *what)
{
    const dig_schema *schema;
    int top = lua_gettop(L);
    for (int i = 0; (schema = dig_schema_at("shape", i)) != NULL; i++) {
        lua_pushstring(L, schema->name);
        if (lua_rawget(L, 2) != LUA_TNIL) {
            lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
            lua_getfield(L, -1, "shapes");
            lua_getfield(L, -1, schema->name);
            lua_pushvalue(L, top + 1);
            lua_call(L, 1, 1);
            put_shape(L, what, schema->name);
        }
        lua_settop(L, top);
    }
}

static quat turn_of(quat a, quat b)
{
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

static vec3 turned(quat q, vec3 v)
{
    quat r = turn_of(turn_of(q, (quat){v.x, v.y, v.z, 0}), (quat){-q.x, -q.y, -q.z, q.w});
    return (vec3){r.x, r.y, r.z};
}

const dig_shape_def *bind_shape_argument(lua_State *L, const char *what, pose *at)
{
    lua_settop(L, 2);
    if (luaL_testudata(L, 2, BIND_SHAPE)) {             /* the shape alone, where it is */
        lua_createtable(L, 1, 0);
        lua_insert(L, 2);
        lua_rawseti(L, 2, 1);
    }
    if (!lua_istable(L, 2))
        bind_wants_fields(L, 2, what);
    if (lua_rawgeti(L, 2, 1) != LUA_TNIL)
        put_shape(L, what, NULL);
    lua_settop(L, 2);
    use_kind_names(L, what);
    bind_arguments(L, 2, what);
    *at = (pose){{0, 0, 0}, {0, 0, 0, 1}};
    bind_get_vec3(L, 2, what, "at", "m", &at->p);
    bind_get_quat(L, 2, what, "rotation", &at->q);
    bind_own_field(L, 2, "shape");
    if (!luaL_testudata(L, -1, BIND_SHAPE))
        bind_error(L, "%s wants a shape such as digbox.sphere{radius = 1}, or sphere = {radius = 1}", what);
    const dig_shape_def *shape = &bind_check_shape(L, lua_gettop(L))->def;
    /* the place of the shape itself counts from the place that was asked for */
    vec3 off = turned(at->q, shape->at.p);
    at->p = (vec3){at->p.x + off.x, at->p.y + off.y, at->p.z + off.z};
    at->q = turn_of(at->q, shape->at.q);
    return shape;
}

/* ---- regions ---------------------------------------------------------------------- */

static RegionRef *check_region(lua_State *L)
{
    RegionRef *ref = luaL_testudata(L, 1, BIND_REGION);
    if (ref && ref->world->shut)
        bind_error(L, "effect '%s': its functions see the bodies they are given; the world cannot be asked or changed there", ref->world->shut);
    if (ref && ref->world->w) {
        bind_settle(L, ref->world);
        return ref;
    }
    if (ref)
        bind_error(L, "the region's world is closed");
    bind_error(L, "expected a region, got %s (methods are called with ':')", luaL_typename(L, 1));
    return NULL;
}

static void read_laws(lua_State *L, const WorldRef *world, dig_region_def *def)
{
    static const char what[] = "world:region.laws";
    static const char *const extras[] = {"force", NULL};
    const dig_schema *schema = dig_schema_at("region", 0);
    const dig_param *sets[] = {schema->rows, NULL};
    if (bind_own_field(L, 2, "laws") == LUA_TNIL)
        return;
    int laws = lua_gettop(L);
    if (!lua_istable(L, laws))
        bind_error(L, "%s wants a table of laws; got %s", what, luaL_typename(L, laws));
    bind_check_keys(L, laws, what, sets, extras);
    if (bind_own_field(L, laws, "force") != LUA_TNIL && !lua_isfunction(L, -1))
        bind_error(L, "%s.force wants a function of a body; got %s", what, luaL_typename(L, -1));
    lua_newtable(L);
    Fill fill = {L, laws, lua_gettop(L), what, what, world};
    bind_fill(&fill, schema->rows, def);
    lua_settop(L, laws);
}

void bind_push_region(lua_State *L, int world, dig_region id)
{
    world = lua_absindex(L, world);
    RegionRef *ref = lua_newuserdatauv(L, sizeof *ref, 1);
    *ref = (RegionRef){lua_touserdata(L, world), id};
    lua_pushvalue(L, world);
    lua_setiuservalue(L, -2, 1);
    luaL_setmetatable(L, BIND_REGION);
}

/* core.region(world, {shape, at=, rotation=, laws={gravity=, drag=, friction_scale=, restitution_scale=, conduct=, time_rate=}}) -> region
 * gravity m/s^2, drag 1/s; laws.force is checked here and called by run.lua */
static int make_region(lua_State *L)
{
    WorldRef *world = bind_check_world(L, 1);
    dig_region_def def = dig_region_defaults();
    def.shape = *bind_shape_argument(L, "world:region", &def.at);
    read_laws(L, world, &def);
    bind_push_region(L, 1, (dig_region){0, 0});
    RegionRef *ref = lua_touserdata(L, -1);
    dig_status s = dig_region_create(world->w, &def, &ref->id);
    if (s != DIG_OK)
        return bind_fail(L, world->w, s);
    bind_note(L, 1, "regions", ref->id.slot, ref->id.gen);
    return 1;
}

/* region:remove(): the laws of the world hold again */
static int region_remove(lua_State *L)
{
    RegionRef *ref = check_region(L);
    bind_push_world_of(L, 1);
    bind_forget(L, -1, "regions", ref->id.slot, ref->id.gen);
    dig_status s = dig_region_remove(ref->world->w, ref->id);
    return s == DIG_OK ? 0 : bind_fail(L, ref->world->w, s);
}

/* Pushes a block of the handles of the dynamic bodies inside. */
static dig_body *bodies_inside(lua_State *L, const RegionRef *ref, int *count)
{
    int n = dig_region_bodies(ref->world->w, ref->id, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    *count = dig_region_bodies(ref->world->w, ref->id, ids, n);
    return ids;
}

/* region:bodies() -> list of the dynamic bodies whose centre of mass is inside; none once it was removed */
static int region_bodies(lua_State *L)
{
    const RegionRef *ref = check_region(L);
    int n;
    lua_settop(L, 1);
    bind_push_world_of(L, 1);
    const dig_body *ids = bodies_inside(L, ref, &n);
    return bind_push_bodies(L, 2, ids, n);
}

/* core.region_force(region, fn): each body inside gets the force fn(body), N, in the next step, as the region's law; nil is no force */
static int region_force(lua_State *L)
{
    const RegionRef *ref = check_region(L);
    int n;
    lua_settop(L, 2);
    bind_push_world_of(L, 1);
    const dig_body *ids = bodies_inside(L, ref, &n);
    for (int i = 0; i < n; i++) {
        if (!dig_body_alive(ref->world->w, ids[i]))
            continue;                               /* a call before this one removed it */
        lua_settop(L, 4);
        lua_pushvalue(L, 2);
        bind_push_body(L, 3, ids[i]);
        lua_call(L, 1, 1);
        if (lua_isnil(L, -1) || !dig_body_alive(ref->world->w, ids[i]))
            continue;
        vec3 force = bind_vec3(L, -1, "N", "world:region.laws", "force");
        if (!(force.x != 0 || force.y != 0 || force.z != 0))
            continue;                               /* a push of nothing would only keep the body awake */
        dig_status s = dig_region_push(ref->world->w, ref->id, ids[i], force);
        if (s != DIG_OK)
            return bind_fail(L, ref->world->w, s);
    }
    return 0;
}

/* region.valid: not yet removed, and its world is open */
static int get_valid(lua_State *L)
{
    const RegionRef *ref = luaL_checkudata(L, 1, BIND_REGION);
    lua_pushboolean(L, ref->world->w && dig_region_alive(ref->world->w, ref->id));
    return 1;
}

static int region_eq(lua_State *L)
{
    const RegionRef *a = luaL_testudata(L, 1, BIND_REGION), *b = luaL_testudata(L, 2, BIND_REGION);
    lua_pushboolean(L, a && b && a->world == b->world && a->id.slot == b->id.slot && a->id.gen == b->id.gen);
    return 1;
}

static int region_tostring(lua_State *L)
{
    const RegionRef *ref = luaL_checkudata(L, 1, BIND_REGION);
    lua_pushfstring(L, "region #%d", (int)ref->id.slot);
    return 1;
}

void bind_region_open(lua_State *L, int core)
{
    static const luaL_Reg methods[] = {{"bodies", region_bodies}, {"remove", region_remove}, {NULL, NULL}};
    static const luaL_Reg getters[] = {{"valid", get_valid}, {NULL, NULL}};
    static const luaL_Reg meta[] = {{"__eq", region_eq}, {"__tostring", region_tostring}, {NULL, NULL}};
    static const luaL_Reg functions[] = {{"region", make_region}, {"region_force", region_force}, {NULL, NULL}};
    bind_type(L, core, BIND_REGION, methods, getters, NULL, meta);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
