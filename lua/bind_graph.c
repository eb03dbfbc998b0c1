/* lua/bind_graph.c - dynamic interaction graphs, links, paths, messages and events. */

#include "bind.h"

#include <math.h>
#include <string.h>

static void set_vec3(lua_State *L, const char *name, vec3 v)
{
    bind_push_vec3(L, v);
    lua_setfield(L, -2, name);
}

static void set_body(lua_State *L, int world, const char *name, dig_body id)
{
    bind_push_body(L, world, id);
    lua_setfield(L, -2, name);
}

/* ---- links ------------------------------------------------------------------------ */

static const char *const link_kinds[] = {"contact", "joint", "port", "range"};

static void push_link(lua_State *L, int world, const dig_link *k)
{
    lua_createtable(L, 0, 11);
    set_body(L, world, "a", k->a);
    set_body(L, world, "b", k->b);
    lua_pushstring(L, link_kinds[k->kind]);
    lua_setfield(L, -2, "kind");
    bind_push_joint(L, world, k->joint);
    lua_setfield(L, -2, "joint");
    set_vec3(L, "effort", k->effort);
    set_vec3(L, "flow", k->flow);
    bind_set_real(L, "power", k->power);
    bind_set_real(L, "began", k->began);
    set_vec3(L, "point", k->point);
    set_vec3(L, "normal", k->normal);
    lua_pushboolean(L, k->bound);
    lua_setfield(L, -2, "bound");
}

static int push_links(lua_State *L, int world, const dig_link *links, int n)
{
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        push_link(L, world, &links[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

static int push_bodies(lua_State *L, int world, const dig_body *ids, int n)
{
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        bind_push_body(L, world, ids[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* {kind = "contact" | "joint" | "range" | ...} at arg, or nothing: -1 = any kind, -2 = a kind of a layer that is not there */
static int kind_argument(lua_State *L, int arg, const char *what)
{
    static const char *const names[] = {"kind", NULL};
    static const char *const later[] = {"electrical", "thermal", "hydraulic"};
    if (lua_isnoneornil(L, arg))
        return -1;
    bind_arguments(L, arg, what, names);
    if (lua_getfield(L, arg, "kind") == LUA_TNIL)
        return -1;
    const char *kind = luaL_tolstring(L, -1, NULL);
    lua_newtable(L);
    for (int i = 0; i < DIG_LINK_KINDS; i++) {
        if (strcmp(kind, link_kinds[i]) == 0)
            return i;
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, link_kinds[i]);
    }
    for (size_t i = 0; i < sizeof later / sizeof *later; i++)
        if (strcmp(kind, later[i]) == 0)
            return -2;
    int names_at = lua_gettop(L);
    const char *start = lua_pushfstring(L, "%s:", what);
    return bind_unknown(L, start, "unknown kind", kind, names_at, names_at);
}

/* body:neighbours{kind=} -> bodies */
static int body_neighbours(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    int kind = kind_argument(L, 2, "body:neighbours");
    int n = kind == -2 ? 0 : dig_neighbours(b->world->w, b->id, kind, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = n > 0 ? dig_neighbours(b->world->w, b->id, kind, ids, n) : 0;
    bind_push_world_of(L, 1);
    return push_bodies(L, lua_gettop(L), ids, n);
}

/* body:links() -> list of {a, b, kind, effort, flow, power, began, point, normal, joint, bound} */
static int body_links(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    int n = dig_links_of(b->world->w, b->id, NULL, 0);
    dig_link *links = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *links, 0);
    n = dig_links_of(b->world->w, b->id, links, n);
    bind_push_world_of(L, 1);
    return push_links(L, lua_gettop(L), links, n);
}

/* body:dig_of(layer) -> DIG or nil */
static int body_dig_of(lua_State *L)
{
    static const char *const layers[] = {"mechanical", "electrical", "thermal", "hydraulic"};
    BodyRef *b = bind_check_body(L, 1);
    const char *layer = luaL_optstring(L, 2, "mechanical");
    lua_newtable(L);
    for (size_t i = 0; i < sizeof layers / sizeof *layers; i++) {
        if (strcmp(layer, layers[i]) == 0) {
            bind_push_world_of(L, 1);
            bind_push_dig(L, lua_gettop(L), i == 0 ? dig_of(b->world->w, b->id) : (dig_dig){0, 0});
            return 1;
        }
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, layers[i]);
    }
    return bind_unknown(L, "body:dig_of:", "unknown layer", layer, lua_gettop(L), lua_gettop(L));
}

/* digbox.path(a, b, {kind=}) -> bodies from a to b, both included; empty when there is no way */
static int graph_path(lua_State *L)
{
    lua_settop(L, 3);
    BodyRef *a = bind_check_body(L, 1), *b = bind_body_of(L, 2, a->world);
    int kind = kind_argument(L, 3, "digbox.path");
    int n = kind == -2 ? 0 : dig_path(a->world->w, a->id, b->id, kind, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = n > 0 ? dig_path(a->world->w, a->id, b->id, kind, ids, n) : 0;
    bind_push_world_of(L, 1);
    return push_bodies(L, lua_gettop(L), ids, n);
}

/* ---- DIGs ------------------------------------------------------------------------------ */

/* world:digs() -> list by id */
static int world_digs(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    int n = dig_digs(ref->w, NULL, 0);
    dig_dig *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = dig_digs(ref->w, ids, n);
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        bind_push_dig(L, 1, ids[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

static dig_dig_state dig_state(lua_State *L)
{
    DigRef *d = bind_check_dig(L, 1);
    dig_dig_state s;
    dig_status status = dig_dig_get(d->world->w, d->id, &s);
    if (status == DIG_E_DEAD)
        bind_error(L, "DIG %d is no more: it merged into another or lost its members", (int)d->id.id);
    if (status != DIG_OK)
        bind_fail(L, d->world->w, status);
    return s;
}

static int dig_get_id(lua_State *L) { lua_pushinteger(L, bind_check_dig(L, 1)->id.id); return 1; }
static int dig_get_size(lua_State *L) { lua_pushinteger(L, dig_state(L).size); return 1; }
static int dig_get_awake(lua_State *L) { lua_pushboolean(L, dig_state(L).awake); return 1; }
static int dig_get_energy(lua_State *L) { lua_pushnumber(L, dig_state(L).energy); return 1; }
static int dig_get_plan(lua_State *L) { lua_pushstring(L, dig_state(L).plan); return 1; }

static int dig_get_valid(lua_State *L)
{
    DigRef *d = luaL_checkudata(L, 1, BIND_DIG);
    dig_dig_state s;
    lua_pushboolean(L, d->world->w && dig_dig_get(d->world->w, d->id, &s) == DIG_OK);
    return 1;
}

/* dig:members() -> bodies */
static int dig_get_members(lua_State *L)
{
    dig_state(L);
    DigRef *d = lua_touserdata(L, 1);
    int n = dig_members(d->world->w, d->id, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = dig_members(d->world->w, d->id, ids, n);
    bind_push_world_of(L, 1);
    return push_bodies(L, lua_gettop(L), ids, n);
}

/* dig:links() -> links */
static int dig_get_links(lua_State *L)
{
    dig_state(L);
    DigRef *d = lua_touserdata(L, 1);
    int n = dig_links_in(d->world->w, d->id, NULL, 0);
    dig_link *links = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *links, 0);
    n = dig_links_in(d->world->w, d->id, links, n);
    bind_push_world_of(L, 1);
    return push_links(L, lua_gettop(L), links, n);
}

/* dig:accuracy "reference" | 1e-6 | "1 um" -> dig */
static int dig_set_accuracy(lua_State *L)
{
    dig_state(L);
    DigRef *d = lua_touserdata(L, 1);
    dig_text plan;
    real tolerance;
    bind_accuracy(L, 2, "dig", &plan, &tolerance);
    dig_status s = dig_dig_accuracy(d->world->w, d->id, plan.s[0] ? plan.s : NULL, tolerance);
    if (s != DIG_OK)
        return bind_fail(L, d->world->w, s);
    lua_settop(L, 1);
    return 1;
}

static int dig_eq(lua_State *L)
{
    const DigRef *a = luaL_testudata(L, 1, BIND_DIG), *b = luaL_testudata(L, 2, BIND_DIG);
    lua_pushboolean(L, a && b && a->world == b->world && a->id.id == b->id.id && a->id.layer == b->id.layer);
    return 1;
}

static int dig_tostring(lua_State *L)
{
    lua_pushfstring(L, "DIG %d", (int)((DigRef *)luaL_checkudata(L, 1, BIND_DIG))->id.id);
    return 1;
}

/* ---- messages ----------------------------------------------------------------------------- */

/* Up to four numbers: a number, or a list of them */
static void values_argument(lua_State *L, int arg, const char *what, real value[4])
{
    memset(value, 0, 4 * sizeof *value);
    if (lua_isnoneornil(L, arg))
        return;
    if (!lua_istable(L, arg)) {
        value[0] = bind_real(L, arg, NULL, what, "value");
        return;
    }
    lua_Unsigned n = lua_rawlen(L, arg);
    if (n > 4)
        bind_error(L, "%s: a message carries at most 4 numbers; got %d", what, (int)n);
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
    return lua_tostring(L, arg);
}

/* body:send(to, name [, values]) -> body */
static int body_send(lua_State *L)
{
    BodyRef *from = bind_check_body(L, 1), *to = bind_body_of(L, 2, from->world);
    real value[4];
    const char *name = name_argument(L, 3, "body:send");
    values_argument(L, 4, "body:send", value);
    dig_status s = dig_message_send(from->world->w, from->id, to->id, name, value);
    if (s != DIG_OK)
        return bind_fail(L, from->world->w, s);
    lua_settop(L, 1);
    return 1;
}

/* dig:broadcast(name [, values [, from]]) -> dig */
static int dig_broadcast(lua_State *L)
{
    dig_state(L);
    DigRef *d = lua_touserdata(L, 1);
    real value[4];
    dig_body from = {0, 0};
    const char *name = name_argument(L, 2, "dig:broadcast");
    values_argument(L, 3, "dig:broadcast", value);
    if (!lua_isnoneornil(L, 4))
        from = bind_body_of(L, 4, d->world)->id;
    dig_status s = dig_message_broadcast(d->world->w, d->id, from, name, value);
    if (s != DIG_OK)
        return bind_fail(L, d->world->w, s);
    lua_settop(L, 1);
    return 1;
}

static void set_message(lua_State *L, int world, const dig_message *m)
{
    lua_pushinteger(L, (lua_Integer)m->id);
    lua_setfield(L, -2, "id");
    bind_set_real(L, "time", m->time);
    set_body(L, world, "from", m->from);
    set_body(L, world, "to", m->to);
    lua_pushstring(L, m->kind);
    lua_setfield(L, -2, "kind");
    bind_set_real(L, "value", m->value[0]);
    lua_createtable(L, 4, 0);
    for (int i = 0; i < 4; i++) {
        lua_pushnumber(L, m->value[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, "values");
    set_vec3(L, "direction", m->direction);
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
        lua_createtable(L, 0, 8);
        set_message(L, 1, &m[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* ---- events --------------------------------------------------------------------------------- */

static const dig_message *find_message(const dig_message *m, int n, uint64_t id)
{
    int lo = 0, hi = n;         /* ids rise */
    while (lo < hi) {
        int mid = (lo + hi) / 2;
        if (m[mid].id < id)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo < n && m[lo].id == id ? &m[lo] : NULL;
}

static void push_event(lua_State *L, const dig_event *e, const dig_message *m)
{
    static const char *const walls[] = {"", "+x", "-x", "+y", "-y", "+z", "-z"};
    lua_createtable(L, 0, 16);
    lua_pushstring(L, dig_event_name(e->kind));
    lua_setfield(L, -2, "event");
    bind_set_real(L, "time", e->time);
    set_body(L, 1, "a", e->a);
    set_body(L, 1, "b", e->b);
    bind_set_real(L, "speed", e->speed);
    bind_set_real(L, "impulse", e->impulse);
    bind_set_real(L, "stress", e->stress);
    set_vec3(L, "point", e->point);
    set_vec3(L, "normal", e->normal);
    bind_push_joint(L, 1, e->joint);
    lua_setfield(L, -2, "joint");
    bind_push_dig(L, 1, (dig_dig){e->dig, DIG_LAYER_MECHANICAL});
    lua_setfield(L, -2, "dig");
    bind_push_dig(L, 1, (dig_dig){e->other_dig, DIG_LAYER_MECHANICAL});
    lua_setfield(L, -2, "other_dig");
    if (e->wall >= 1 && e->wall <= 6) {
        lua_pushstring(L, walls[e->wall]);
        lua_setfield(L, -2, "wall");
    }
    if (e->kind == DIG_EVENT_ENTERED || e->kind == DIG_EVENT_LEFT) {
        bind_push_region(L, 1, e->region);
        lua_setfield(L, -2, "region");
    }
    if (e->kind == DIG_EVENT_LINK || e->kind == DIG_EVENT_UNLINK) {
        lua_pushstring(L, link_kinds[e->link]);
        lua_setfield(L, -2, "kind");
    }
    if (m)
        set_message(L, 1, m);
}

/* core.events(world, mask) -> list of the last step's events whose bit (1 << kind) is set */
static int graph_events(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    lua_Integer mask = luaL_checkinteger(L, 2);
    const dig_event *events;
    const dig_message *messages = NULL;
    int n = dig_events(ref->w, &events), kept = 0, count = 0;
    lua_settop(L, 1);
    if (mask >> DIG_EVENT_MESSAGE & 1) {
        count = dig_messages(ref->w, NULL, 0);
        dig_message *copy = lua_newuserdatauv(L, (size_t)(count + 1) * sizeof *copy, 0);
        count = dig_messages(ref->w, copy, count);
        messages = copy;
    }
    lua_newtable(L);
    for (int i = 0; i < n; i++) {
        if (!(mask >> events[i].kind & 1))
            continue;
        push_event(L, &events[i], events[i].kind == DIG_EVENT_MESSAGE ? find_message(messages, count, events[i].message) : NULL);
        lua_rawseti(L, -2, ++kept);
    }
    return 1;
}

/* core.mark_removed(body, how): a body that the engine took away, not the script */
static int graph_mark_removed(lua_State *L)
{
    BodyRef *b = luaL_checkudata(L, 1, BIND_BODY);
    bind_push_world_of(L, 1);
    bind_mark_removed(L, lua_gettop(L), "bodies", b->id.slot, b->id.gen, luaL_checkstring(L, 2));
    return 0;
}

/* ---- tables -------------------------------------------------------------------------------- */

static const luaL_Reg methods[] = {
    {"members", dig_get_members}, {"links", dig_get_links}, {"broadcast", dig_broadcast}, {"accuracy", dig_set_accuracy}, {NULL, NULL},
};
static const luaL_Reg getters[] = {
    {"id", dig_get_id}, {"size", dig_get_size}, {"awake", dig_get_awake}, {"energy", dig_get_energy}, {"plan", dig_get_plan},
    {"valid", dig_get_valid}, {NULL, NULL},
};
static const luaL_Reg meta[] = {{"__eq", dig_eq}, {"__tostring", dig_tostring}, {NULL, NULL}};
static const luaL_Reg body_methods[] = {
    {"neighbours", body_neighbours}, {"links", body_links}, {"dig_of", body_dig_of}, {"send", body_send}, {NULL, NULL},
};
static const luaL_Reg world_methods[] = {{"digs", world_digs}, {"messages", world_messages}, {NULL, NULL}};
static const luaL_Reg functions[] = {
    {"path", graph_path}, {"events", graph_events}, {"mark_removed", graph_mark_removed}, {NULL, NULL},
};

void bind_graph_open(lua_State *L, int core)
{
    bind_type(L, core, BIND_DIG, methods, getters, NULL, meta);
    bind_extend(L, core, BIND_BODY, body_methods);
    bind_extend(L, core, BIND_WORLD, world_methods);
    lua_newtable(L);
    for (int k = 0; k < DIG_EVENT_KINDS; k++) {
        lua_pushinteger(L, k);
        lua_setfield(L, -2, dig_event_name((dig_event_kind)k));
    }
    lua_setfield(L, core, "event_kinds");
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
