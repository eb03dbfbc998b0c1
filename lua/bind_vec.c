/* lua/bind_vec.c - vectors and rotations: small immutable userdata. */

#include "bind.h"

#include <math.h>
#include <stdio.h>

void bind_push_vec3(lua_State *L, vec3 v)
{
    vec3 *out = lua_newuserdatauv(L, sizeof *out, 0);
    *out = v;
    luaL_setmetatable(L, BIND_VEC);
}

void bind_push_quat(lua_State *L, quat q)
{
    quat *out = lua_newuserdatauv(L, sizeof *out, 0);
    *out = q;
    luaL_setmetatable(L, BIND_QUAT);
}

static vec3 cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* q v q*, written as v + 2 u x (u x v + w v) */
static vec3 rotate(quat q, vec3 v)
{
    vec3 u = {q.x, q.y, q.z};
    vec3 c = cross(u, v);
    vec3 t = cross(u, (vec3){c.x + q.w * v.x, c.y + q.w * v.y, c.z + q.w * v.z});
    return (vec3){v.x + 2 * t.x, v.y + 2 * t.y, v.z + 2 * t.z};
}

static quat multiply(quat a, quat b)
{
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

static vec3 operand(lua_State *L, int arg)
{
    return bind_vec3(L, arg, "1", "vector", NULL);
}

/* ---- vectors ------------------------------------------------------------------ */

/* digbox.vec(x, y, z) or digbox.vec{x, y, z} -> vector */
static int vec_new(lua_State *L)
{
    vec3 v;
    if (lua_gettop(L) == 1) {
        v = bind_vec3(L, 1, "m", "digbox.vec", NULL);
    } else {
        lua_settop(L, 3);
        v.x = bind_real(L, 1, "m", "digbox.vec", "x");
        v.y = bind_real(L, 2, "m", "digbox.vec", "y");
        v.z = bind_real(L, 3, "m", "digbox.vec", "z");
    }
    bind_push_vec3(L, v);
    return 1;
}

static int vec_add(lua_State *L)
{
    vec3 a = operand(L, 1), b = operand(L, 2);
    bind_push_vec3(L, (vec3){a.x + b.x, a.y + b.y, a.z + b.z});
    return 1;
}

static int vec_sub(lua_State *L)
{
    vec3 a = operand(L, 1), b = operand(L, 2);
    bind_push_vec3(L, (vec3){a.x - b.x, a.y - b.y, a.z - b.z});
    return 1;
}

/* number * vector, vector * number; two vectors: by components */
static int vec_mul(lua_State *L)
{
    vec3 a, b;
    real s = lua_type(L, 1) == LUA_TNUMBER ? lua_tonumber(L, 1) : 1, t = lua_type(L, 2) == LUA_TNUMBER ? lua_tonumber(L, 2) : 1;
    a = lua_type(L, 1) == LUA_TNUMBER ? (vec3){s, s, s} : operand(L, 1);
    b = lua_type(L, 2) == LUA_TNUMBER ? (vec3){t, t, t} : operand(L, 2);
    bind_push_vec3(L, (vec3){a.x * b.x, a.y * b.y, a.z * b.z});
    return 1;
}

static int vec_div(lua_State *L)
{
    vec3 a = operand(L, 1);
    real s = luaL_checknumber(L, 2);
    bind_push_vec3(L, (vec3){a.x / s, a.y / s, a.z / s});
    return 1;
}

static int vec_unm(lua_State *L)
{
    vec3 a = operand(L, 1);
    bind_push_vec3(L, (vec3){-a.x, -a.y, -a.z});
    return 1;
}

static int vec_length(lua_State *L)
{
    lua_pushnumber(L, bind_length(operand(L, 1)));
    return 1;
}

static int vec_eq(lua_State *L)
{
    const vec3 *a = luaL_testudata(L, 1, BIND_VEC), *b = luaL_testudata(L, 2, BIND_VEC);
    lua_pushboolean(L, a && b && a->x == b->x && a->y == b->y && a->z == b->z);
    return 1;
}

static int vec_tostring(lua_State *L)
{
    const vec3 *v = luaL_checkudata(L, 1, BIND_VEC);
    char text[128];
    snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", v->x + 0.0, v->y + 0.0, v->z + 0.0);       /* no -0 */
    lua_pushstring(L, text);
    return 1;
}

/* v:dot(w) -> number */
static int vec_dot(lua_State *L)
{
    vec3 a = operand(L, 1), b = operand(L, 2);
    lua_pushnumber(L, a.x * b.x + a.y * b.y + a.z * b.z);
    return 1;
}

/* v:cross(w) -> vector */
static int vec_cross(lua_State *L)
{
    bind_push_vec3(L, cross(operand(L, 1), operand(L, 2)));
    return 1;
}

/* v:normalized() -> vector of length 1 */
static int vec_normalized(lua_State *L)
{
    vec3 a = operand(L, 1);
    if (!bind_unit(&a))
        return bind_error(L, "vector:normalized: the vector is %s and has no direction", bind_length(a) > 0 ? "infinite" : "zero");
    bind_push_vec3(L, a);
    return 1;
}

/* v:unpack() -> x, y, z */
static int vec_unpack(lua_State *L)
{
    vec3 a = operand(L, 1);
    lua_pushnumber(L, a.x);
    lua_pushnumber(L, a.y);
    lua_pushnumber(L, a.z);
    return 3;
}

static int vec_x(lua_State *L) { lua_pushnumber(L, ((vec3 *)luaL_checkudata(L, 1, BIND_VEC))->x); return 1; }
static int vec_y(lua_State *L) { lua_pushnumber(L, ((vec3 *)luaL_checkudata(L, 1, BIND_VEC))->y); return 1; }
static int vec_z(lua_State *L) { lua_pushnumber(L, ((vec3 *)luaL_checkudata(L, 1, BIND_VEC))->z); return 1; }

/* v[1], v[2], v[3] */
static int vec_component(lua_State *L)
{
    const vec3 *v = luaL_checkudata(L, 1, BIND_VEC);
    lua_Integer i = lua_isinteger(L, 2) ? lua_tointeger(L, 2) : 0;
    if (i < 1 || i > 3)
        return 0;
    lua_pushnumber(L, i == 1 ? v->x : i == 2 ? v->y : v->z);
    return 1;
}

/* ---- rotations ------------------------------------------------------------------- */

/* digbox.quat{axis=, angle=} | {from=, to=} | {x, y, z, w} -> rotation */
static int quat_new(lua_State *L)
{
    bind_push_quat(L, bind_quat(L, 1, "digbox.quat", NULL));
    return 1;
}

/* rotation * rotation (the right one first), rotation * vector */
static int quat_mul(lua_State *L)
{
    quat a = bind_quat(L, 1, "rotation", NULL);
    if (luaL_testudata(L, 2, BIND_QUAT))
        bind_push_quat(L, multiply(a, *(quat *)lua_touserdata(L, 2)));
    else
        bind_push_vec3(L, rotate(a, operand(L, 2)));
    return 1;
}

/* q:rotate(v) -> vector */
static int quat_rotate(lua_State *L)
{
    bind_push_vec3(L, rotate(bind_quat(L, 1, "rotation", NULL), operand(L, 2)));
    return 1;
}

/* q:inverse() -> rotation */
static int quat_inverse(lua_State *L)
{
    quat q = bind_quat(L, 1, "rotation", NULL);
    bind_push_quat(L, (quat){-q.x, -q.y, -q.z, q.w});
    return 1;
}

static int quat_eq(lua_State *L)
{
    const quat *a = luaL_testudata(L, 1, BIND_QUAT), *b = luaL_testudata(L, 2, BIND_QUAT);
    lua_pushboolean(L, a && b && a->x == b->x && a->y == b->y && a->z == b->z && a->w == b->w);
    return 1;
}

static int quat_tostring(lua_State *L)
{
    const quat *q = luaL_checkudata(L, 1, BIND_QUAT);
    char text[160];
    snprintf(text, sizeof text, "(%.6g, %.6g, %.6g; %.6g)", q->x + 0.0, q->y + 0.0, q->z + 0.0, q->w + 0.0);
    lua_pushstring(L, text);
    return 1;
}

static int quat_x(lua_State *L) { lua_pushnumber(L, ((quat *)luaL_checkudata(L, 1, BIND_QUAT))->x); return 1; }
static int quat_y(lua_State *L) { lua_pushnumber(L, ((quat *)luaL_checkudata(L, 1, BIND_QUAT))->y); return 1; }
static int quat_z(lua_State *L) { lua_pushnumber(L, ((quat *)luaL_checkudata(L, 1, BIND_QUAT))->z); return 1; }
static int quat_w(lua_State *L) { lua_pushnumber(L, ((quat *)luaL_checkudata(L, 1, BIND_QUAT))->w); return 1; }

/* q.angle: 0..pi, about q.axis */
static int quat_angle(lua_State *L)
{
    const quat *q = luaL_checkudata(L, 1, BIND_QUAT);
    lua_pushnumber(L, 2 * atan2(bind_length((vec3){q->x, q->y, q->z}), fabs(q->w)));
    return 1;
}

static int quat_axis(lua_State *L)
{
    const quat *q = luaL_checkudata(L, 1, BIND_QUAT);
    vec3 u = q->w < 0 ? (vec3){-q->x, -q->y, -q->z} : (vec3){q->x, q->y, q->z};
    real n = bind_length(u);
    bind_push_vec3(L, n > 0 ? (vec3){u.x / n, u.y / n, u.z / n} : (vec3){0, 1, 0});
    return 1;
}

/* ---- tables ----------------------------------------------------------------------- */

static const luaL_Reg vec_methods[] = {
    {"dot", vec_dot}, {"cross", vec_cross}, {"length", vec_length}, {"normalized", vec_normalized}, {"unpack", vec_unpack}, {NULL, NULL},
};
static const luaL_Reg vec_getters[] = {{"x", vec_x}, {"y", vec_y}, {"z", vec_z}, {NULL, NULL}};
static const luaL_Reg vec_meta[] = {
    {"__add", vec_add}, {"__sub", vec_sub}, {"__mul", vec_mul}, {"__div", vec_div}, {"__unm", vec_unm}, {"__len", vec_length},
    {"__eq", vec_eq}, {"__tostring", vec_tostring}, {NULL, NULL},
};
static const luaL_Reg quat_methods[] = {{"rotate", quat_rotate}, {"inverse", quat_inverse}, {NULL, NULL}};
static const luaL_Reg quat_getters[] = {
    {"x", quat_x}, {"y", quat_y}, {"z", quat_z}, {"w", quat_w}, {"angle", quat_angle}, {"axis", quat_axis}, {NULL, NULL},
};
static const luaL_Reg quat_meta[] = {{"__mul", quat_mul}, {"__eq", quat_eq}, {"__tostring", quat_tostring}, {NULL, NULL}};
static const luaL_Reg functions[] = {{"vec", vec_new}, {"quat", quat_new}, {NULL, NULL}};

void bind_vec_open(lua_State *L, int core)
{
    bind_type(L, core, BIND_VEC, vec_methods, vec_getters, vec_component, vec_meta);
    bind_type(L, core, BIND_QUAT, quat_methods, quat_getters, NULL, quat_meta);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
