/* lua/bind_graph.c - dynamic interaction graphs, links, paths and events. */

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
    static const char *const sometimes[] = {"a", "b", "joint", NULL};
    lua_createtable(L, 0, 11);
    set_body(L, world, "a", k->a);
    set_body(L, world, "b", k->b);
    bind_set_text(L, "kind", k->layer ? dig_layer_name(k->layer) : link_kinds[k->kind]);
    bind_push_joint(L, world, k->joint);
    lua_setfield(L, -2, "joint");
    if (k->layer) {                         /* volts and amperes have no direction */
        bind_set_real(L, "effort", k->effort.x);
        bind_set_real(L, "flow", k->flow.x);
    } else {
        set_vec3(L, "effort", k->effort);
        set_vec3(L, "flow", k->flow);
    }
    bind_set_real(L, "power", k->power);
    bind_set_real(L, "began", k->began);
    set_vec3(L, "point", k->point);
    set_vec3(L, "normal", k->normal);
    lua_pushboolean(L, k->bound);
    lua_setfield(L, -2, "bound");
    bind_record(L, "link of a body", sometimes, false);
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

uint32_t bind_layer(lua_State *L, int index, const char *what)
{
    const char *name = bind_name(L, index, "layer");
    lua_newtable(L);
    for (uint32_t i = 0; dig_layer_name(i); i++) {
        if (strcmp(name, dig_layer_name(i)) == 0) {
            lua_pop(L, 2);
            return i;
        }
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, dig_layer_name(i));
    }
    int names_at = lua_gettop(L);
    return (uint32_t)bind_unknown(L, lua_pushfstring(L, "%s:", what), "unknown layer", name, names_at, names_at);
}

void bind_link_kind(lua_State *L, int index, const char *what, uint32_t *layer, int *kind)
{
    static const char *const mechanical[] = {[DIG_LINK_CONTACT] = "contact", [DIG_LINK_JOINT] = "joint"};
    const char *name = bind_name(L, index, "kind");
    lua_newtable(L);
    *layer = DIG_LAYER_MECHANICAL;
    *kind = -1;
    for (int i = 0; i <= DIG_LINK_JOINT; i++) {
        if (strcmp(name, mechanical[i]) == 0)
            *kind = i;
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, mechanical[i]);
    }
    for (uint32_t i = 1; dig_layer_name(i); i++) {
        if (strcmp(name, dig_layer_name(i)) == 0)
            *layer = i;
        lua_pushboolean(L, 1);
        lua_setfield(L, -2, dig_layer_name(i));
    }
    int names_at = lua_gettop(L);
    if (*kind < 0 && *layer == DIG_LAYER_MECHANICAL)
        bind_unknown(L, lua_pushfstring(L, "%s:", what), "unknown kind", name, names_at, names_at);
    lua_pop(L, 2);
}

/* {kind = "contact" | "joint" | "thermal" | ...} at arg, or nothing */
static void kind_argument(lua_State *L, int arg, const char *what, uint32_t *layer, int *kind)
{
    *layer = DIG_LAYER_MECHANICAL;
    *kind = -1;
    if (lua_isnoneornil(L, arg))
        return;
    bind_arguments(L, arg, what);
    if (bind_own_field(L, arg, "kind") != LUA_TNIL)
        bind_link_kind(L, lua_gettop(L), what, layer, kind);
    lua_pop(L, 1);
}

static int list_neighbours(const BodyRef *b, uint32_t layer, int kind, dig_body *ids, int n)
{
    return layer == DIG_LAYER_MECHANICAL ? dig_neighbours(b->world->w, b->id, kind, ids, n) : dig_neighbours_in_layer(b->world->w, b->id, layer, ids, n);
}

static int list_path(const BodyRef *a, dig_body b, uint32_t layer, int kind, dig_body *ids, int n)
{
    return layer == DIG_LAYER_MECHANICAL ? dig_path(a->world->w, a->id, b, kind, ids, n) : dig_path_in_layer(a->world->w, a->id, b, layer, ids, n);
}

/* body:neighbours{kind=} -> bodies */
static int body_neighbours(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    uint32_t layer;
    int kind;
    kind_argument(L, 2, "body:neighbours", &layer, &kind);
    int n = list_neighbours(b, layer, kind, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = list_neighbours(b, layer, kind, ids, n);
    bind_push_world_of(L, 1);
    return bind_push_bodies(L, lua_gettop(L), ids, n);
}

/* body:links{kind=} -> list of {a, b, kind, effort, flow, power, began, point, normal, joint, bound} */
static int body_links(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    uint32_t layer;
    int kind, kept = 0;
    kind_argument(L, 2, "body:links", &layer, &kind);
    int n = dig_links_of_layer(b->world->w, b->id, layer, NULL, 0);
    dig_link *links = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *links, 0);
    n = dig_links_of_layer(b->world->w, b->id, layer, links, n);
    for (int i = 0; i < n; i++)
        if (kind < 0 || (int)links[i].kind == kind)
            links[kept++] = links[i];
    bind_push_world_of(L, 1);
    return push_links(L, lua_gettop(L), links, kept);
}

/* body:dig_of(layer) -> DIG or nil */
static int body_dig_of(lua_State *L)
{
    BodyRef *b = bind_check_body(L, 1);
    uint32_t layer = lua_isnoneornil(L, 2) ? DIG_LAYER_MECHANICAL : bind_layer(L, 2, "body:dig_of");
    bind_push_world_of(L, 1);
    bind_push_dig(L, lua_gettop(L), dig_of_layer(b->world->w, b->id, layer));
    return 1;
}

/* digbox.path(a, b, {kind=}) -> bodies from a to b, both included; empty when there is no way */
static int graph_path(lua_State *L)
{
    lua_settop(L, 3);
    BodyRef *a = bind_check_body(L, 1), *b = bind_body_of(L, 2, a->world);
    uint32_t layer;
    int kind;
    kind_argument(L, 3, "digbox.path", &layer, &kind);
    int n = list_path(a, b->id, layer, kind, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = list_path(a, b->id, layer, kind, ids, n);
    bind_push_world_of(L, 1);
    return bind_push_bodies(L, lua_gettop(L), ids, n);
}

/* ---- DIGs ------------------------------------------------------------------------------ */

/* world:digs([layer]) -> list by id */
static int world_digs(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    uint32_t layer = lua_isnoneornil(L, 2) ? DIG_LAYER_MECHANICAL : bind_layer(L, 2, "world:digs");
    int n = dig_digs_of_layer(ref->w, layer, NULL, 0);
    dig_dig *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = dig_digs_of_layer(ref->w, layer, ids, n);
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
static int dig_get_layer(lua_State *L) { lua_pushstring(L, dig_layer_name(bind_check_dig(L, 1)->id.layer)); return 1; }
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
    return bind_push_bodies(L, lua_gettop(L), ids, n);
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
    const DigRef *d = luaL_checkudata(L, 1, BIND_DIG);
    lua_pushfstring(L, d->id.layer ? "%s DIG %d" : "%sDIG %d", d->id.layer ? dig_layer_name(d->id.layer) : "", (int)d->id.id);
    return 1;
}

/* ---- events --------------------------------------------------------------------------------- */

static void push_event(lua_State *L, const dig_world *w, const dig_event *e)
{
    const dig_message *m = dig_message_of(w, e);
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
    bind_push_dig(L, 1, (dig_dig){e->dig, e->layer});
    lua_setfield(L, -2, "dig");
    bind_push_dig(L, 1, (dig_dig){e->other_dig, e->layer});
    lua_setfield(L, -2, "other_dig");
    if (e->wall > 0) {
        lua_pushstring(L, dig_wall_name(e->wall));
        lua_setfield(L, -2, "wall");
    }
    if (e->kind == DIG_EVENT_ENTERED || e->kind == DIG_EVENT_LEFT) {
        bind_push_region(L, 1, e->region);
        lua_setfield(L, -2, "region");
    }
    if (e->kind == DIG_EVENT_LINK || e->kind == DIG_EVENT_UNLINK) {
        lua_pushstring(L, e->layer ? dig_layer_name(e->layer) : link_kinds[e->link]);
        lua_setfield(L, -2, "kind");
    }
    if (e->kind >= DIG_EVENT_MERGED && e->kind <= DIG_EVENT_UNLINK)
        bind_set_text(L, "layer", dig_layer_name(e->layer));
    if (m)
        bind_set_message(L, 1, m);
}

/* core.events(world, mask [, last]) -> list of the last step's events whose bit (1 << kind) is set; the last so many only */
static int graph_events(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    lua_Integer mask = luaL_checkinteger(L, 2);
    const dig_event *events;
    int n = dig_events(ref->w, &events), kept = 0, last = (int)luaL_optinteger(L, 3, n);
    lua_settop(L, 1);
    lua_newtable(L);
    for (int i = n - last; i < n; i++) {
        if (!(mask >> events[i].kind & 1))
            continue;
        push_event(L, ref->w, &events[i]);
        lua_rawseti(L, -2, ++kept);
    }
    return 1;
}

/* core.tell_moves(world): who moves is an event from now on */
static int graph_tell_moves(lua_State *L)
{
    dig_tell_moves(bind_check_world(L, 1)->w, true);
    return 0;
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
    {"members", dig_get_members}, {"links", dig_get_links}, {"accuracy", dig_set_accuracy}, {NULL, NULL},
};
static const luaL_Reg getters[] = {
    {"id", dig_get_id}, {"layer", dig_get_layer}, {"size", dig_get_size}, {"awake", dig_get_awake}, {"energy", dig_get_energy}, {"plan", dig_get_plan},
    {"valid", dig_get_valid}, {NULL, NULL},
};
static const luaL_Reg meta[] = {{"__eq", dig_eq}, {"__tostring", dig_tostring}, {NULL, NULL}};
static const luaL_Reg body_methods[] = {
    {"neighbours", body_neighbours}, {"links", body_links}, {"dig_of", body_dig_of}, {NULL, NULL},
};
static const luaL_Reg world_methods[] = {{"digs", world_digs}, {NULL, NULL}};
static const luaL_Reg functions[] = {
    {"path", graph_path}, {"events", graph_events}, {"tell_moves", graph_tell_moves}, {"mark_removed", graph_mark_removed}, {NULL, NULL},
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
