/* lua/bind_handle.c - handles: checking them, one userdata for each body, joint and DIG, why a dead one is dead; lists. */

#include "bind.h"

#include <string.h>

static const char *name_of_type(lua_State *L, int arg)
{
    if (luaL_getmetafield(L, arg, "__name") == LUA_TSTRING) {
        const char *name = lua_tostring(L, -1);
        lua_pop(L, 1);
        return name;        /* stays alive in the metatable */
    }
    return luaL_typename(L, arg);
}

static void *check_type(lua_State *L, int arg, const char *name)
{
    void *ref = luaL_testudata(L, arg, name);
    lua_Debug call;
    if (ref)
        return ref;
    bool known = lua_getstack(L, 0, &call) && lua_getinfo(L, "n", &call) && call.name, method = known && strcmp(call.namewhat, "method") == 0;
    if (known && arg > (method ? 2 : 1))        /* a body that is asked of one other says enough */
        bind_error(L, "%s: argument %d: expected a %s, got %s", call.name, arg - method, name, name_of_type(L, arg));
    else
        bind_error(L, "expected a %s, got %s%s", name, name_of_type(L, arg),
                   arg == 1 && !lua_isuserdata(L, 1) ? " (methods are called with ':')" : "");
    return NULL;
}

/* ---- what calls cost ---- */

enum { CALL = 10, ITEM = 5 };           /* units: of any call, of an item of a list */
static const char host_key;

void bind_host_by(lua_State *L, const BindHost *host)
{
    lua_pushlightuserdata(L, (void *)(uintptr_t)host);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &host_key);
}

const BindHost *bind_host(lua_State *L)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &host_key);
    const BindHost *host = lua_touserdata(L, -1);
    lua_pop(L, 1);
    return host;
}

void bind_charge_items(lua_State *L, size_t items)
{
    const BindHost *host = bind_host(L);
    if (host)
        host->charge(L, ITEM * items);
}

void bind_settle(lua_State *L, WorldRef *world)
{
    if (!world->host || !world->w)
        return;
    uint64_t work = dig_world_work(world->w), owed = work - world->charged + CALL;
    world->charged = work;
    world->host->charge(L, (size_t)owed);
}

/* ---- checks ---- */

/* Inside the function of an effect, nothing but what it is shown. */
static void check_free(lua_State *L, WorldRef *ref)
{
    if (ref->shut)
        bind_error(L, "effect '%s': its functions see the bodies they are given; the world cannot be asked or changed there", ref->shut);
    bind_settle(L, ref);
}

WorldRef *bind_check_world(lua_State *L, int arg)
{
    WorldRef *ref = check_type(L, arg, BIND_WORLD);
    if (!ref->w)
        bind_error(L, "the world is closed");
    check_free(L, ref);
    return ref;
}

/* For what belongs to a world, named `what`. */
static void check_open(lua_State *L, WorldRef *ref, const char *what)
{
    if (!ref->w)
        bind_error(L, "the %s's world is closed", what);
    check_free(L, ref);
}

static void fail_removed(lua_State *L, int arg, const char *type)
{
    lua_getiuservalue(L, arg, REF_REMOVED);
    lua_getiuservalue(L, arg, REF_NAME);
    const char *how = lua_tostring(L, -2), *name = lua_tostring(L, -1);
    if (how)
        bind_error(L, "%s", how);
    else if (strcmp(type, BIND_JOINT) == 0)         /* what a script removes says where */
        bind_error(L, "%s%s%s is no more: it broke (the event broken says when), or world:restore went back before it",
                   name && *name ? "joint '" : "this joint", name ? name : "", name && *name ? "'" : "");
    else if (name)
        bind_error(L, "%s '%s' was removed", type, name);
    else
        bind_error(L, "this %s was removed", type);
}

BodyRef *bind_check_body(lua_State *L, int arg)
{
    BodyRef *ref = check_type(L, arg, BIND_BODY);
    check_open(L, ref->world, "body");
    if (!dig_body_alive(ref->world->w, ref->id))
        fail_removed(L, arg, BIND_BODY);
    return ref;
}

JointRef *bind_check_joint(lua_State *L, int arg)
{
    JointRef *ref = check_type(L, arg, BIND_JOINT);
    check_open(L, ref->world, "joint");
    if (!dig_joint_alive(ref->world->w, ref->id))
        fail_removed(L, arg, BIND_JOINT);
    return ref;
}

DigRef *bind_check_dig(lua_State *L, int arg)
{
    DigRef *ref = check_type(L, arg, BIND_DIG);
    check_open(L, ref->world, "DIG");
    return ref;
}

ShapeRef *bind_check_shape(lua_State *L, int arg)
{
    return check_type(L, arg, BIND_SHAPE);
}

BodyRef *bind_body_of(lua_State *L, int arg, const WorldRef *world)
{
    BodyRef *ref = bind_check_body(L, arg);
    if (ref->world != world) {
        bind_push_body_name(L, ref);
        bind_error(L, "%s belongs to another world", lua_tostring(L, -1));
    }
    return ref;
}

/* ---- handles ---------------------------------------------------------------------- */

void bind_push_state(lua_State *L, int world)
{
    lua_getiuservalue(L, world, 1);
}

static lua_Integer handle_key(uint32_t slot, uint32_t gen)
{
    return (lua_Integer)(((uint64_t)slot << 32) | gen);
}

/* Pushes the cached handle and returns true, or leaves the cache table on the stack and returns false. */
static bool push_cached(lua_State *L, int world, const char *cache, lua_Integer key)
{
    bind_push_state(L, world);
    lua_getfield(L, -1, cache);
    lua_remove(L, -2);
    if (lua_rawgeti(L, -1, key) != LUA_TNIL) {
        lua_remove(L, -2);
        return true;
    }
    lua_pop(L, 1);
    return false;
}

static void *new_handle(lua_State *L, int world, size_t size, const char *type, lua_Integer key, const char *name)
{
    void *ref = lua_newuserdatauv(L, size, 3);
    lua_pushvalue(L, world);
    lua_setiuservalue(L, -2, REF_WORLD);
    if (name && *name) {
        lua_pushstring(L, name);
        lua_setiuservalue(L, -2, REF_NAME);
    }
    luaL_setmetatable(L, type);
    lua_pushvalue(L, -1);
    lua_rawseti(L, -3, key);
    lua_remove(L, -2);
    return ref;
}

/* Pushes nil for what is nothing, or the handle that is there already; false: there is none yet. */
static bool push_known(lua_State *L, int world, const char *cache, lua_Integer key, bool nothing)
{
    luaL_checkstack(L, 8, "too many values");
    if (!nothing)
        return push_cached(L, world, cache, key);
    lua_pushnil(L);
    return true;
}

void bind_push_body(lua_State *L, int world, dig_body id)
{
    world = lua_absindex(L, world);
    WorldRef *w = lua_touserdata(L, world);
    lua_Integer key = handle_key(id.slot, id.gen);
    dig_body_state s;
    if (push_known(L, world, "bodies", key, key == 0))
        return;
    const char *name = dig_body_get(w->w, id, &s) == DIG_OK ? s.name : NULL;
    *(BodyRef *)new_handle(L, world, sizeof(BodyRef), BIND_BODY, key, name) = (BodyRef){w, id};
}

void bind_push_joint(lua_State *L, int world, dig_joint id)
{
    world = lua_absindex(L, world);
    WorldRef *w = lua_touserdata(L, world);
    lua_Integer key = handle_key(id.slot, id.gen);
    dig_joint_state s;
    if (push_known(L, world, "joints", key, key == 0))
        return;
    const char *name = dig_joint_get(w->w, id, &s) == DIG_OK ? s.name : NULL;
    *(JointRef *)new_handle(L, world, sizeof(JointRef), BIND_JOINT, key, name) = (JointRef){w, id};
}

void bind_push_dig(lua_State *L, int world, dig_dig id)
{
    world = lua_absindex(L, world);
    WorldRef *w = lua_touserdata(L, world);
    lua_Integer key = handle_key(id.id, id.layer);
    if (push_known(L, world, "digs", key, id.id == 0))
        return;
    *(DigRef *)new_handle(L, world, sizeof(DigRef), BIND_DIG, key, NULL) = (DigRef){w, id};
}

int bind_push_bodies(lua_State *L, int world, const dig_body *ids, int n)
{
    world = lua_absindex(L, world);
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        bind_push_body(L, world, ids[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

void bind_mark_removed(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen, const char *how)
{
    if (push_cached(L, world, kind, handle_key(slot, gen))) {
        lua_getiuservalue(L, -1, REF_REMOVED);
        if (lua_isnil(L, -1)) {
            lua_pushstring(L, how);
            lua_setiuservalue(L, -3, REF_REMOVED);
        }
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
}

void bind_push_world_of(lua_State *L, int handle)
{
    lua_getiuservalue(L, handle, REF_WORLD);
}

void bind_push_body_name(lua_State *L, const BodyRef *b)
{
    dig_body_state s;
    if (dig_body_get(b->world->w, b->id, &s) == DIG_OK && s.name && *s.name)
        lua_pushfstring(L, "body '%s'", s.name);
    else
        lua_pushfstring(L, "body #%d", (int)b->id.slot);
}

/* ---- lists ---------------------------------------------------------------------------- */

static int list_tostring(lua_State *L)
{
    luaL_Buffer b;
    lua_Integer n = (lua_Integer)lua_rawlen(L, 1);
    luaL_buffinit(L, &b);
    luaL_addchar(&b, '{');
    for (lua_Integer i = 1; i <= n && i <= 100; i++) {
        luaL_addstring(&b, i > 1 ? ", " : "");
        lua_rawgeti(L, 1, i);
        bind_text(L, -1);
        lua_remove(L, -2);
        luaL_addvalue(&b);
    }
    luaL_addstring(&b, n > 100 ? ", ...}" : "}");
    luaL_pushresult(&b);
    return 1;
}

void bind_push_list(lua_State *L, int size)
{
    bind_charge_items(L, (size_t)size);
    lua_createtable(L, size, 0);
    if (luaL_newmetatable(L, "list")) {
        lua_pushcfunction(L, list_tostring);
        lua_setfield(L, -2, "__tostring");
        lua_pushnil(L);
        lua_setfield(L, -2, "__name");
        lua_pushboolean(L, 0);
        lua_setfield(L, -2, "__metatable");
    }
    lua_setmetatable(L, -2);
}

void bind_push_matrix(lua_State *L, const real *m, int size)
{
    lua_createtable(L, size, 0);
    for (int i = 0; i < size; i++) {
        lua_createtable(L, size, 0);
        for (int j = 0; j < size; j++) {
            lua_pushnumber(L, m[i * size + j]);
            lua_rawseti(L, -2, j + 1);
        }
        lua_rawseti(L, -2, i + 1);
    }
}
