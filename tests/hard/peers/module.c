/* tests/hard/peers/module.c - the Lua module of another engine: keeps what a hard case describes, steps the engine, measures.
 *
 *   local core = require("peer_ode").world(step, gx, gy, gz)
 *
 * Engines that are built at once (MuJoCo) want the whole scene, so each is opened with the first step, and again, from
 * where the bodies are, when one was added or taken away. shim.lua makes the world of a case from this.
 */
#include <lauxlib.h>
#include <lua.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "peer.h"

typedef struct {
    PeerScene  scene;
    Peer      *peer;
    PeerState *state;       /* [scene.bodies] */
    bool       fresh;       /* the states are those of the engine */
} Core;

static const char *const type_name = "digbox.hard.peer";
static double opening;      /* CPU seconds that went into opening engines: they are no steps */

static Core *core_of(lua_State *L) { return luaL_checkudata(L, 1, type_name); }

/* ---- reading tables ---- */

static double number_field(lua_State *L, const char *name, double otherwise)
{
    lua_getfield(L, 2, name);
    double x = luaL_optnumber(L, -1, otherwise);
    lua_pop(L, 1);
    return x;
}

static bool flag_field(lua_State *L, const char *name)
{
    lua_getfield(L, 2, name);
    bool x = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return x;
}

/* Numbers of a list; those that are not there stay as they are. Returns how many there were. */
static int list_field(lua_State *L, const char *name, double *out, int most)
{
    lua_getfield(L, 2, name);
    int n = lua_istable(L, -1) ? (int)lua_rawlen(L, -1) : 0;
    for (int i = 0; i < n && i < most; i++) {
        lua_rawgeti(L, -1, i + 1);
        out[i] = luaL_checknumber(L, -1);
        lua_pop(L, 1);
    }
    lua_pop(L, 1);
    return n;
}

static void *grown(void *list, int count, int *room, size_t size)
{
    if (count < *room)
        return list;
    *room = *room ? 2 * *room : 64;
    list = realloc(list, (size_t)*room * size);
    if (!list)
        abort();
    return list;
}

/* ---- states ---- */

static void sync_states(Core *c)
{
    if (c->fresh)
        return;
    if (c->peer)
        peer_states(c->peer, c->state);
    c->fresh = true;
}

/* Before the scene is changed: the engine is closed, and its bodies begin anew from where they are. */
static void close_engine(Core *c)
{
    if (!c->peer)
        return;
    sync_states(c);
    peer_close(c->peer);
    c->peer = NULL;
    for (int i = 0; i < c->scene.bodies; i++)
        c->scene.body[i].start = c->state[i];
    for (int i = 0; i < c->scene.joints; i++) {
        PeerJoint *j = &c->scene.joint[i];
        for (int end = 0; end < 2; end++) {
            const int of = end == 0 ? j->a : j->b;
            double arm[3];
            if (of < 0)
                continue;
            peer_turned(c->state[of].turn, j->local[end], arm);
            for (int k = 0; k < 3; k++)
                j->at[end][k] = c->state[of].at[k] + arm[k];
            if (end == 0)
                peer_turned(c->state[of].turn, j->local_axis[0], j->axis);
        }
    }
}

static int state_of(lua_State *L)
{
    Core *c = core_of(L);
    int i = (int)luaL_checkinteger(L, 2);
    luaL_argcheck(L, i >= 0 && i < c->scene.bodies, 2, "no such body");
    sync_states(c);
    const double *x = c->state[i].at;
    for (int k = 0; k < 13; k++)
        lua_pushnumber(L, x[k]);
    return 13;
}

/* ---- describing ---- */

static int add_body(lua_State *L)
{
    Core *c = core_of(L);
    PeerBody b = {.kind = (int)number_field(L, "kind", 0), .start = {.turn = {1, 0, 0, 0}}};
    close_engine(c);
    list_field(L, "size", b.size, 3);
    list_field(L, "at", b.start.at, 3);
    list_field(L, "turn", b.start.turn, 4);
    list_field(L, "v", b.start.v, 3);
    list_field(L, "spin", b.start.spin, 3);
    b.offset = number_field(L, "offset", 0);
    b.mass = number_field(L, "mass", 0);
    b.friction = number_field(L, "friction", 0.5);
    b.rolling = number_field(L, "rolling", 0);
    b.restitution = number_field(L, "restitution", 0);
    b.group = (int)number_field(L, "group", 0);
    b.ghost = flag_field(L, "ghost");
    b.driven = flag_field(L, "driven");
    memcpy(b.drive[0], b.start.v, sizeof b.drive[0]);
    memcpy(b.drive[1], b.start.spin, sizeof b.drive[1]);
    peer_inertia(&b);
    if (b.kind == PEER_HULL) {
        double points[3 * PEER_POINTS];
        int n = list_field(L, "points", points, 3 * PEER_POINTS);
        b.hull = calloc(1, sizeof *b.hull);
        if (!b.hull || !peer_hull_make(b.hull, points, n / 3, number_field(L, "density", 1000), &b))
            return luaL_error(L, "a hull of %d points is no solid, or has too many", n / 3);
    }
    PeerScene *s = &c->scene;
    s->body = grown(s->body, s->bodies, &s->body_room, sizeof *s->body);
    c->state = realloc(c->state, (size_t)s->body_room * sizeof *c->state);
    if (!c->state)
        abort();
    c->state[s->bodies] = b.start;
    s->body[s->bodies++] = b;
    s->restitution = fmax(s->restitution, b.restitution);
    lua_pushinteger(L, s->bodies - 1);
    lua_pushnumber(L, b.mass);
    return 2;
}

static void carry(const PeerState *s, const double at[3], const double axis[3], double local[3], double local_axis[3])
{
    double arm[3] = {at[0] - s->at[0], at[1] - s->at[1], at[2] - s->at[2]};
    peer_turned_back(s->turn, arm, local);
    peer_turned_back(s->turn, axis, local_axis);
}

static int add_joint(lua_State *L)
{
    Core *c = core_of(L);
    PeerScene *s = &c->scene;
    close_engine(c);
    PeerJoint j = {.kind = (int)number_field(L, "kind", 0), .a = (int)number_field(L, "a", -1), .b = (int)number_field(L, "b", -1)};
    luaL_argcheck(L, j.a >= 0 && j.a < s->bodies && j.b < s->bodies, 2, "a joint of no body");
    list_field(L, "at", j.at[0], 3);
    memcpy(j.at[1], j.at[0], sizeof j.at[1]);
    list_field(L, "at_b", j.at[1], 3);
    list_field(L, "axis", j.axis, 3);
    j.length = number_field(L, "length", 0);
    j.stiffness = number_field(L, "stiffness", 0);
    j.damping = number_field(L, "damping", 0);
    j.limited = flag_field(L, "limited");
    j.lower = number_field(L, "lower", 0);
    j.upper = number_field(L, "upper", 0);
    j.motor_speed = number_field(L, "motor_speed", 0);
    j.motor_torque = number_field(L, "motor_torque", 0);
    const PeerState world = {.turn = {1, 0, 0, 0}};
    carry(&c->state[j.a], j.at[0], j.axis, j.local[0], j.local_axis[0]);
    carry(j.b < 0 ? &world : &c->state[j.b], j.at[1], j.axis, j.local[1], j.local_axis[1]);
    s->joint = grown(s->joint, s->joints, &s->joint_room, sizeof *s->joint);
    s->joint[s->joints++] = j;
    lua_pushinteger(L, s->joints - 1);
    return 1;
}

static int remove_body(lua_State *L)
{
    Core *c = core_of(L);
    close_engine(c);
    c->scene.body[luaL_checkinteger(L, 2)].gone = true;
    return 0;
}

/* ---- moving ---- */

/* Of the thread: the clock of a process counts whole milliseconds once its time is limited (ulimit -t). */
static double cpu_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool open_engine(lua_State *L, Core *c)
{
    char why[200] = "";
    if (c->peer)
        return true;
    double begin = cpu_time();
    c->peer = peer_open(&c->scene, why, sizeof why);
    opening += cpu_time() - begin;
    if (!c->peer)
        luaL_error(L, "cannot: %s", why);
    return c->peer;
}

static int open_world(lua_State *L)
{
    open_engine(L, core_of(L));
    return 0;
}

static int step(lua_State *L)
{
    Core *c = core_of(L);
    open_engine(L, c);
    peer_step(c->peer);
    c->fresh = false;
    return 0;
}

static int drive(lua_State *L)
{
    Core *c = core_of(L);
    PeerBody *b = &c->scene.body[luaL_checkinteger(L, 2)];
    for (int k = 0; k < 6; k++)
        b->drive[k / 3][k % 3] = luaL_checknumber(L, 3 + k);
    return 0;
}

static int push(lua_State *L)
{
    Core *c = core_of(L);
    double impulse[3] = {luaL_checknumber(L, 3), luaL_checknumber(L, 4), luaL_checknumber(L, 5)};
    open_engine(L, c);
    peer_push(c->peer, (int)luaL_checkinteger(L, 2), impulse);
    return 0;
}

/* ---- measuring ---- */

static double spring_energy(const Core *c, const PeerJoint *j)
{
    double d[3], arm[3];
    for (int end = 0; end < 2; end++) {
        const int of = end == 0 ? j->a : j->b;
        memcpy(arm, j->local[end], sizeof arm);
        if (of >= 0)
            peer_turned(c->state[of].turn, j->local[end], arm);
        for (int k = 0; k < 3; k++)
            d[k] = (end ? d[k] : 0) + (end ? -1 : 1) * (arm[k] + (of >= 0 ? c->state[of].at[k] : 0));
    }
    double stretch = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - j->length;
    return j->stiffness * stretch * stretch / 2;
}

/* kinetic, potential, elastic, momentum x y z, angular momentum about the origin x y z */
static int totals(lua_State *L)
{
    Core *c = core_of(L);
    double sum[9] = {0};
    sync_states(c);
    for (int i = 0; i < c->scene.bodies; i++) {
        const PeerBody *b = &c->scene.body[i];
        const PeerState *s = &c->state[i];
        double local[3], l[3];
        if (b->mass <= 0 || b->gone)
            continue;
        peer_turned_back(s->turn, s->spin, local);
        for (int k = 0; k < 3; k++) {
            sum[0] += (b->mass * s->v[k] * s->v[k] + b->inertia[k] * local[k] * local[k]) / 2;
            sum[1] -= b->mass * c->scene.gravity[k] * s->at[k];
            sum[3 + k] += b->mass * s->v[k];
            local[k] *= b->inertia[k];
        }
        peer_turned(s->turn, local, l);
        for (int k = 0; k < 3; k++) {
            int p = (k + 1) % 3, q = (k + 2) % 3;
            sum[6 + k] += l[k] + b->mass * (s->at[p] * s->v[q] - s->at[q] * s->v[p]);
        }
    }
    for (int i = 0; i < c->scene.joints; i++)
        if (c->scene.joint[i].kind == PEER_SPRING)
            sum[2] += spring_energy(c, &c->scene.joint[i]);
    for (int k = 0; k < 9; k++)
        lua_pushnumber(L, sum[k]);
    return 9;
}

/* How far the ends are apart, in m (of a slider: across its axis); the angle of a hinge. */
static int joint_state(lua_State *L)
{
    Core *c = core_of(L);
    const PeerJoint *j = &c->scene.joint[luaL_checkinteger(L, 2)];
    double d[3], axis[3], arm[3], q[4], *turn = c->state[j->a].turn, unit[4] = {1, 0, 0, 0};
    sync_states(c);
    const double *other = j->b >= 0 ? c->state[j->b].turn : unit;
    peer_turned(turn, j->local[0], arm);
    for (int k = 0; k < 3; k++)
        d[k] = c->state[j->a].at[k] + arm[k] - (j->b < 0 ? j->local[1][k] : c->state[j->b].at[k]);
    memcpy(arm, j->local[1], sizeof arm);
    if (j->b >= 0) {
        peer_turned(other, j->local[1], arm);
        for (int k = 0; k < 3; k++)
            d[k] -= arm[k];
    }
    peer_turned(other, j->local_axis[1], axis);
    double along = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
    for (int k = 0; k < 3 && j->kind == PEER_SLIDER; k++)
        d[k] -= along * axis[k];
    lua_pushnumber(L, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
    q[0] = other[0] * turn[0] + other[1] * turn[1] + other[2] * turn[2] + other[3] * turn[3];       /* conj(other) turn */
    q[1] = other[0] * turn[1] - other[1] * turn[0] - other[2] * turn[3] + other[3] * turn[2];
    q[2] = other[0] * turn[2] + other[1] * turn[3] - other[2] * turn[0] - other[3] * turn[1];
    q[3] = other[0] * turn[3] - other[1] * turn[2] + other[2] * turn[1] - other[3] * turn[0];
    double twist = q[1] * j->local_axis[1][0] + q[2] * j->local_axis[1][1] + q[3] * j->local_axis[1][2];
    lua_pushnumber(L, remainder(2 * atan2(twist, q[0]), 2 * acos(-1)));
    return 2;
}

static int joint_force(lua_State *L)
{
    Core *c = core_of(L);
    double f[3] = {0};
    if (!c->peer || !peer_joint_force(c->peer, (int)luaL_checkinteger(L, 2), f))
        return 0;
    for (int k = 0; k < 3; k++)
        lua_pushnumber(L, f[k]);
    return 3;
}

static int penetration(lua_State *L)
{
    Core *c = core_of(L);
    sync_states(c);
    lua_pushnumber(L, peer_penetration(&c->scene, c->state));
    return 1;
}

static int touches(lua_State *L)
{
    enum { ROOM = 4096 };
    Core *c = core_of(L);
    PeerTouch *list = calloc(ROOM, sizeof *list);
    int n = c->peer && list ? peer_touches(c->peer, list, ROOM) : 0;
    lua_createtable(L, n, 0);
    for (int i = 0; i < n; i++) {
        const double x[5] = {list[i].a, list[i].b, list[i].force[0], list[i].force[1], list[i].force[2]};
        lua_createtable(L, 5, 0);
        for (int k = 0; k < 5; k++) {
            lua_pushnumber(L, x[k]);
            lua_rawseti(L, -2, k + 1);
        }
        lua_rawseti(L, -2, i + 1);
    }
    free(list);
    return 1;
}

/* ---- the module ---- */

static int end_world(lua_State *L)
{
    Core *c = core_of(L);
    if (c->peer)
        peer_close(c->peer);
    for (int i = 0; i < c->scene.bodies; i++)
        free(c->scene.body[i].hull);
    free(c->scene.body);
    free(c->scene.joint);
    free(c->state);
    memset(c, 0, sizeof *c);
    return 0;
}

static int new_world(lua_State *L)
{
    Core *c = lua_newuserdatauv(L, sizeof *c, 0);
    memset(c, 0, sizeof *c);
    c->scene.step = luaL_checknumber(L, 1);
    for (int k = 0; k < 3; k++)
        c->scene.gravity[k] = luaL_checknumber(L, 2 + k);
    c->fresh = true;
    luaL_setmetatable(L, type_name);
    return 1;
}

static int cpu_seconds(lua_State *L)
{
    lua_pushnumber(L, cpu_time() - opening);
    return 1;
}

static const luaL_Reg methods[] = {
    {"body", add_body}, {"joint", add_joint}, {"remove", remove_body}, {"open", open_world}, {"step", step}, {"drive", drive},
    {"push", push}, {"state", state_of}, {"totals", totals}, {"joint_state", joint_state}, {"joint_force", joint_force},
    {"penetration", penetration}, {"touches", touches}, {"close", end_world}, {"__gc", end_world}, {NULL, NULL}
};

static int open_module(lua_State *L)
{
    luaL_newmetatable(L, type_name);
    luaL_setfuncs(L, methods, 0);
    lua_pushvalue(L, -1);
    lua_setfield(L, -2, "__index");
    lua_createtable(L, 0, 3);
    lua_pushcfunction(L, new_world);
    lua_setfield(L, -2, "world");
    lua_pushcfunction(L, cpu_seconds);
    lua_setfield(L, -2, "cpu_seconds");
    lua_pushstring(L, peer_name);
    lua_setfield(L, -2, "name");
    return 1;
}

int PEER_OPEN(lua_State *L);        /* luaopen_peer_ENGINE: the build names it */
int PEER_OPEN(lua_State *L) { return open_module(L); }
