/* lua/bind_message.c - messages: posting and reading; links of the other layers. The methods are in lua/digbox/message.lua. */

#include "bind.h"

#include <string.h>

/* ---- posting ---------------------------------------------------------------------------- */

/* Up to four numbers: a number, or a list of them */
static void values_argument(lua_State *L, int arg, const char *what, real value[4])
{
    memset(value, 0, 4 * sizeof *value);
    if (lua_isnoneornil(L, arg))
        return;
    const vec3 *v = luaL_testudata(L, arg, BIND_VEC);
    if (v) {
        memcpy(value, (real[3]){v->x, v->y, v->z}, 3 * sizeof *value);
        return;
    }
    if (!lua_istable(L, arg)) {
        value[0] = bind_real(L, arg, NULL, what, "value");
        return;
    }
    lua_Unsigned n = lua_rawlen(L, arg);
    if (n > 4)
        bind_error(L, "%s: a message carries at most 4 numbers; got %d", what, (int)n);
    int names;
    const char **name = bind_names(L, arg, arg, &names);
    if (names > 0)
        bind_error(L, "%s: a message carries numbers without names; got '%s'", what, name[0]);
    for (lua_pushnil(L); lua_next(L, arg); lua_pop(L, 1))
        if (!lua_isinteger(L, -2))
            bind_error(L, "%s: a message carries a list of numbers; a key of it is a %s", what, luaL_typename(L, -2));
    lua_pop(L, 1);
    for (lua_Unsigned i = 0; i < n; i++) {
        lua_rawgeti(L, arg, (lua_Integer)i + 1);
        value[i] = bind_real(L, -1, NULL, what, "value");
        lua_pop(L, 1);
    }
}

static const char *name_argument(lua_State *L, int arg, const char *what)
{
    if (lua_type(L, arg) != LUA_TSTRING)
        bind_error(L, "%s wants a name; got %s", what, luaL_typename(L, arg));
    if (lua_rawlen(L, arg) >= sizeof((dig_message *)0)->kind)
        bind_error(L, "%s: the name has %d bytes, must have at most %d", what, (int)lua_rawlen(L, arg),
                   (int)sizeof((dig_message *)0)->kind - 1);
    return bind_string(L, arg, what);
}

static const WorldRef *world_of(lua_State *L)
{
    BodyRef *b = luaL_testudata(L, 1, BIND_BODY);
    DigRef *d = luaL_testudata(L, 1, BIND_DIG);
    return b ? b->world : d ? d->world : bind_check_world(L, 1);
}

static bool field(lua_State *L, const char *name)
{
    lua_settop(L, 3);
    return bind_own_field(L, 3, name) != LUA_TNIL;
}

static const char *const routes[] = {"to", "neighbours", "dig", "flood", "path", "region"};

static void read_route(lua_State *L, const char *what, dig_post *p)
{
    if (!field(L, "route"))
        return;
    const char *name = bind_name(L, -1, what);
    lua_newtable(L);
    int known = lua_gettop(L);
    for (int i = 0; i < DIG_ROUTES; i++) {
        if (strcmp(name, routes[i]) == 0) {
            p->route = (dig_route)i;
            return;
        }
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, routes[i]);
    }
    bind_unknown(L, lua_pushfstring(L, "%s:", what), "unknown route", name, known, known);
}

/* transform = "ratio" or a number */
static void read_transform(lua_State *L, const char *what, dig_post *p)
{
    if (!field(L, "transform"))
        return;
    if (lua_type(L, -1) == LUA_TSTRING && strcmp(bind_string(L, -1, what), "ratio") == 0) {
        p->transform = DIG_TRANSFORM_RATIO;
        return;
    }
    if (lua_type(L, -1) != LUA_TNUMBER)
        bind_error(L, "%s: transform wants 'ratio', a number or a function; got %s", what, bind_text(L, -1));
    p->transform = DIG_TRANSFORM_SCALE;
    p->factor = lua_tonumber(L, -1);
}

static void read_ends(lua_State *L, const WorldRef *world, const char *what, dig_post *p)
{
    if (field(L, "from"))
        p->from = bind_body_of(L, 4, world)->id;
    if (field(L, "to"))
        p->to = bind_body_of(L, 4, world)->id;
    if (field(L, "dig"))
        p->dig = bind_check_dig(L, 4)->id;
    if (field(L, "region")) {
        const RegionRef *r = luaL_testudata(L, 4, BIND_REGION);
        if (r && r->world == world)
            p->region = r->id;
        else
            bind_error(L, "%s: region wants a region of this world; got %s", what, luaL_typename(L, 4));
    }
}

/* The post in the table at 3, whose fields lua/digbox/message.lua has checked. */
static dig_post read_post(lua_State *L, const WorldRef *world, const char *what)
{
    dig_post p = dig_post_defaults();
    field(L, "name");
    strcpy(p.kind, name_argument(L, 4, what));
    field(L, "value");
    values_argument(L, 4, what, p.value);
    read_ends(L, world, what, &p);
    read_route(L, what, &p);
    read_transform(L, what, &p);
    if (field(L, "kind"))
        bind_link_kind(L, 4, what, &p.layer, &p.link);
    if (field(L, "layer")) {
        uint32_t layer = bind_layer(L, 4, what);
        if (p.layer && p.layer != layer)
            bind_error(L, "%s: kind and layer say different layers", what);
        p.layer = layer;
    }
    if (field(L, "hops"))
        p.hops = (int)bind_int(L, 4, what, "hops");
    if (field(L, "after"))
        p.after = bind_real(L, 4, "s", what, "after");
    lua_settop(L, 3);
    return p;
}

/* core.post(handle, what, {name =, value =, from =, route =, ...}) -> bodies reached, the ring that contradicts itself or nil */
static int message_post(lua_State *L)
{
    const WorldRef *world = world_of(L);
    const char *what = luaL_checkstring(L, 2);
    dig_post p = read_post(L, world, what);
    dig_receipt r;
    dig_status s = dig_message_post(world->w, &p, &r);
    if (s != DIG_OK)
        return bind_fail(L, world->w, s);
    lua_pushinteger(L, r.reached);
    if (r.loop_count == 0)
        return 1;
    bind_push_world_of(L, 1);
    int owner = lua_gettop(L);
    bind_push_bodies(L, owner, r.loop, r.loop_count);
    lua_replace(L, owner);
    return 2;
}

/* core.post_list(body, what, {name =}, bodies, values): one message, each body a first value of its own */
static int message_post_list(lua_State *L)
{
    BodyRef *from = bind_check_body(L, 1);
    const char *what = luaL_checkstring(L, 2);
    int n = (int)lua_rawlen(L, 4);
    dig_body *to = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *to, 0);
    real *value = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *value, 0);
    for (int i = 0; i < n; i++) {
        lua_rawgeti(L, 4, i + 1);
        to[i] = bind_body_of(L, -1, from->world)->id;
        lua_rawgeti(L, 5, i + 1);
        value[i] = bind_real(L, -1, NULL, what, "value");
        lua_pop(L, 2);
    }
    dig_post p = dig_post_defaults();
    lua_getfield(L, 3, "name");
    strcpy(p.kind, name_argument(L, lua_gettop(L), what));
    p.from = from->id;
    dig_status s = dig_message_list(from->world->w, &p, to, value, n);
    return s == DIG_OK ? 0 : bind_fail(L, from->world->w, s);
}

/* core.answering(world, root or nil) */
static int message_answering(lua_State *L)
{
    dig_message_answering(bind_check_world(L, 1)->w, (uint64_t)luaL_optinteger(L, 2, 0));
    return 0;
}

/* core.take_messages(world) -> how many message events were added to those of the last step */
static int message_take(lua_State *L)
{
    lua_pushinteger(L, dig_message_take(bind_check_world(L, 1)->w));
    return 1;
}

static int message_dropped(lua_State *L)
{
    dig_message_dropped(bind_check_world(L, 1)->w, 1);
    return 0;
}

/* ---- reading ------------------------------------------------------------------------------ */

void bind_set_message(lua_State *L, int world, const dig_message *m)
{
    bind_set_int(L, "id", (lua_Integer)m->id);
    bind_set_int(L, "root", (lua_Integer)m->root);
    bind_set_real(L, "time", m->time);
    bind_push_body(L, world, m->from);
    lua_setfield(L, -2, "from");
    bind_push_body(L, world, m->to);
    lua_setfield(L, -2, "to");
    bind_set_text(L, "kind", m->kind);
    bind_set_real(L, "value", m->value[0]);
    lua_createtable(L, 4, 0);
    for (int i = 0; i < 4; i++) {
        lua_pushnumber(L, m->value[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, "values");
    bind_push_vec3(L, m->direction);
    lua_setfield(L, -2, "direction");
}

/* world:messages() -> the last 4096, oldest first */
static int world_messages(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    int n = dig_messages(ref->w, NULL, 0);
    dig_message *m = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *m, 0);
    n = dig_messages(ref->w, m, n);
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        lua_createtable(L, 0, 9);
        bind_set_message(L, 1, &m[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* ---- links of other layers ------------------------------------------------------------------ */

#define BIND_WIRE "link"

typedef struct WireRef { WorldRef *world; dig_wire id; } WireRef;       /* its first user value is the world */

/* world:link{a =, b =, layer = "electrical", bound =, ratio =} -> link
 * a b                     the two bodies
 * layer                   electrical, thermal, hydraulic or range
 * bound                   true: b is a boundary of the layer (earth, the air) and joins no DIG; default false
 * ratio                   what arrives at b for 1 at a, for messages by ratio
 */
static int world_link(lua_State *L)
{
    WorldRef *world = bind_check_world(L, 1);
    dig_wire_def def = {0};
    lua_settop(L, 2);
    bind_arguments(L, 2, "world:link");
    bind_own_field(L, 2, "layer");
    def.layer = bind_layer(L, 3, "world:link");
    bind_own_field(L, 2, "a");
    def.a = bind_body_of(L, 4, world)->id;
    bind_own_field(L, 2, "b");
    def.b = bind_body_of(L, 5, world)->id;
    bind_own_field(L, 2, "bound");
    if (!lua_isnil(L, 6) && !lua_isboolean(L, 6))
        return bind_error(L, "world:link.bound wants true or false; got %s", luaL_typename(L, 6));
    def.bound = lua_toboolean(L, 6);
    bind_get_real(L, 2, "world:link", "ratio", "1", &def.ratio);
    WireRef *ref = lua_newuserdatauv(L, sizeof *ref, 1);
    *ref = (WireRef){world, {0, 0, 0}};
    dig_status s = dig_wire_add(world->w, &def, &ref->id);
    if (s != DIG_OK)
        return bind_fail(L, world->w, s);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    luaL_setmetatable(L, BIND_WIRE);
    return 1;
}

static WireRef *check_wire(lua_State *L)
{
    WireRef *ref = luaL_checkudata(L, 1, BIND_WIRE);
    if (!ref->world->w)
        bind_error(L, "this link's world is closed");
    return ref;
}

/* link:remove() */
static int wire_remove(lua_State *L)
{
    const WireRef *ref = check_wire(L);
    dig_status s = dig_wire_remove(ref->world->w, ref->id);
    return s == DIG_OK ? 0 : bind_fail(L, ref->world->w, s);
}

/* link:set(effort, flow), in the units of its layer */
static int wire_set(lua_State *L)
{
    const WireRef *ref = check_wire(L);
    real effort = bind_real(L, 2, NULL, "link:set", "effort"), flow = bind_real(L, 3, NULL, "link:set", "flow");
    dig_status s = dig_wire_set(ref->world->w, ref->id, effort, flow);
    return s == DIG_OK ? 0 : bind_fail(L, ref->world->w, s);
}

static int wire_valid(lua_State *L)
{
    const WireRef *ref = luaL_checkudata(L, 1, BIND_WIRE);
    lua_pushboolean(L, ref->world->w && dig_wire_alive(ref->world->w, ref->id));
    return 1;
}

static int wire_layer(lua_State *L)
{
    lua_pushstring(L, dig_layer_name(((WireRef *)luaL_checkudata(L, 1, BIND_WIRE))->id.layer));
    return 1;
}

static int wire_tostring(lua_State *L)
{
    lua_pushfstring(L, "%s link", dig_layer_name(((WireRef *)luaL_checkudata(L, 1, BIND_WIRE))->id.layer));
    return 1;
}

/* ---- tables -------------------------------------------------------------------------------- */

static const luaL_Reg world_methods[] = {{"messages", world_messages}, {"link", world_link}, {NULL, NULL}};
static const luaL_Reg wire_methods[] = {{"remove", wire_remove}, {"set", wire_set}, {NULL, NULL}};
static const luaL_Reg wire_getters[] = {{"valid", wire_valid}, {"layer", wire_layer}, {NULL, NULL}};
static const luaL_Reg wire_meta[] = {{"__tostring", wire_tostring}, {NULL, NULL}};
static const luaL_Reg functions[] = {
    {"post", message_post}, {"post_list", message_post_list}, {"answering", message_answering}, {"take_messages", message_take},
    {"message_dropped", message_dropped}, {NULL, NULL},
};

void bind_message_open(lua_State *L, int core)
{
    bind_extend(L, core, BIND_WORLD, world_methods);
    bind_type(L, core, BIND_WIRE, wire_methods, wire_getters, NULL, wire_meta);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
