/* lua/bind_value.c - numbers, vectors and rotations from Lua values: plain SI numbers or strings with a unit. */

#include "bind.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* "world:sphere.radius"; just one of them when the other is missing. */
static void push_path(lua_State *L, const char *what, const char *field)
{
    if (!field)
        lua_pushstring(L, what);
    else if (!what)
        lua_pushstring(L, field);
    else
        lua_pushfstring(L, "%s.%s", what, field);
}

static int wrong_type(lua_State *L, int index, const char *what, const char *field, const char *wanted)
{
    index = lua_absindex(L, index);
    const char *got = luaL_getmetafield(L, index, "__name") == LUA_TSTRING ? lua_tostring(L, -1) : luaL_typename(L, index);
    push_path(L, what, field);
    const char *hint = "";
    if (luaL_testudata(L, index, BIND_BODY) && strncmp(wanted, "a vector", 8) == 0)
        hint = " (its place is body.position)";
    const char *text = lua_type(L, index) == LUA_TSTRING ? lua_tostring(L, index) : "";
    size_t sign = *text == '-' || *text == '+';
    if (text[sign] && strchr("xyzXYZ", text[sign]) && !text[sign + 1])
        hint = strchr("xX", text[sign]) ? " (x is {1, 0, 0})" : strchr("yY", text[sign]) ? " (y, up, is {0, 1, 0})" : " (z is {0, 0, 1})";
    if (lua_type(L, index) == LUA_TNUMBER && field && strcmp(field, "gravity") == 0)
        hint = " (y is up: {0, -9.81, 0})";
    return bind_error(L, "%s wants %s; got %s%s", lua_tostring(L, -1), wanted, got, hint);
}

static real parse_text(lua_State *L, const char *text, const char *unit, const char *what, const char *field)
{
    char why[256];
    real value = 0;
    if (dig_unit_parse(text, unit, &value, why, sizeof why) != DIG_OK) {
        push_path(L, what, field);
        bind_error(L, "%s%s%s", lua_tostring(L, -1), strncmp(why, "wants ", 6) == 0 ? " " : ": ", why);
    }
    return value;
}

real bind_real(lua_State *L, int index, const char *unit, const char *what, const char *field)
{
    if (lua_type(L, index) == LUA_TSTRING)
        return parse_text(L, bind_string(L, index, field ? field : what), unit, what, field);
    if (lua_type(L, index) != LUA_TNUMBER) {
        bool plain = !unit || !*unit || strcmp(unit, "1") == 0;
        index = lua_absindex(L, index);
        wrong_type(L, index, what, field, plain ? "a number" : lua_pushfstring(L, "a number or a string such as '1 %s'", unit));
    }
    real value = lua_tonumber(L, index);
    if (isnan(value)) {
        push_path(L, what, field);
        bind_error(L, "%s = nan, must be a finite number", lua_tostring(L, -1));
    }
    return value;
}

/* A plain number past a full turn that is whole, or whole and a half, is hardly ever one of radians: those come with pi. */
static bool seems_degrees(lua_State *L, int index, real *x)
{
    *x = lua_type(L, index) == LUA_TNUMBER ? lua_tonumber(L, index) : 0;
    return isfinite(*x) && fabs(*x) > 6.5 && floor(2 * *x) == 2 * *x;
}

void bind_refuse_degrees(lua_State *L, int index, const char *what, const char *field)
{
    real x;
    if (!seems_degrees(L, index, &x))
        return;
    push_path(L, what, field);
    bind_error(L, "%s = %.6g rad is %.3g turns: write '%.6g deg' if degrees are meant, else '%.6g rad'", lua_tostring(L, -1), x,
               fabs(x) / 6.283185307179586, x, x);
}

/* An angle that a thing is turned by may well be any number: this is said, not refused. */
static void remark_degrees(lua_State *L, int table, const char *what)
{
    real x;
    lua_pushliteral(L, "angle");
    if (lua_rawget(L, table) == LUA_TNUMBER && seems_degrees(L, -1, &x) && fmod(x, 5) == 0) {
        char text[200];
        snprintf(text, sizeof text, "%s.angle = %.6g rad: write '%.6g deg' if degrees are meant", what, x, x);
        bind_remark(L, text);
    }
    lua_pop(L, 1);
}

void bind_remark(lua_State *L, const char *text)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    if (lua_getfield(L, -1, "remark") == LUA_TFUNCTION) {
        bind_where(L);
        lua_pushstring(L, text);
        lua_concat(L, 2);
        lua_call(L, 1, 0);
        lua_pop(L, 1);
    } else {
        lua_pop(L, 2);
    }
}

lua_Integer bind_int(lua_State *L, int index, const char *what, const char *field)
{
    int whole = 0;
    lua_Integer value = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : 0;
    if (lua_type(L, index) != LUA_TNUMBER)
        wrong_type(L, index, what, field, "a whole number");
    if (!whole) {
        lua_Number x = lua_tonumber(L, index);
        push_path(L, what, field);
        bind_error(L, "%s wants a whole number; got %g", lua_tostring(L, -1), x);
    }
    return value;
}

real bind_seconds(lua_State *L, int index, const char *what)
{
    real s = bind_real(L, index, "s", what, NULL);
    if (!(s >= 0) || isinf(s))
        bind_error(L, "%s: the time = %g s, must be finite and >= 0", what, s);
    return s;
}

bool bind_is_vec3(lua_State *L, int index)
{
    return lua_istable(L, index) || luaL_testudata(L, index, BIND_VEC);
}

/* One component: t[i], or t.x .y .z */
static real component(lua_State *L, int table, int i, const char *unit, const char *what, const char *field)
{
    static const char *const names[3] = {"x", "y", "z"};
    if (lua_rawgeti(L, table, i + 1) == LUA_TNIL) {
        lua_pop(L, 1);
        lua_pushstring(L, names[i]);
        lua_rawget(L, table);
    }
    if (lua_isnil(L, -1)) {
        push_path(L, what, field);
        bind_error(L, "%s wants {x, y, z}; component %s is missing", lua_tostring(L, -1), names[i]);
    }
    const char *inner = field ? lua_pushfstring(L, "%s.%s", field, names[i]) : names[i];
    real value = bind_real(L, field ? -2 : -1, unit, what, inner);
    if (isinf(value)) {
        push_path(L, what, inner);
        bind_error(L, "%s = inf, must be a finite number", lua_tostring(L, -1));
    }
    lua_pop(L, field ? 2 : 1);
    return value;
}

vec3 bind_vec3(lua_State *L, int index, const char *unit, const char *what, const char *field)
{
    vec3 *v = luaL_testudata(L, index, BIND_VEC);
    if (v) {
        if (!isfinite(v->x) || !isfinite(v->y) || !isfinite(v->z)) {
            push_path(L, what, field);
            bind_error(L, "%s = {%g, %g, %g}, must be finite", lua_tostring(L, -1), v->x, v->y, v->z);
        }
        return *v;
    }
    if (!lua_istable(L, index))
        wrong_type(L, index, what, field, "a vector {x, y, z}");
    index = lua_absindex(L, index);
    if (lua_rawlen(L, index) > 3) {
        push_path(L, what, field);
        bind_error(L, "%s wants {x, y, z}; got %d components", lua_tostring(L, -1), (int)lua_rawlen(L, index));
    }
    vec3 out;
    out.x = component(L, index, 0, unit, what, field);
    out.y = component(L, index, 1, unit, what, field);
    out.z = component(L, index, 2, unit, what, field);
    return out;
}

real bind_length(vec3 v)
{
    real square = v.x * v.x + v.y * v.y + v.z * v.z;
    if (square > 1e-280 && square < 1e280)
        return sqrt(square);
    real most = fmax(fabs(v.x), fmax(fabs(v.y), fabs(v.z)));
    if (!(most > 0 && most <= DBL_MAX && square >= 0))      /* zero, inf, NaN */
        return sqrt(square);
    real x = v.x / most, y = v.y / most, z = v.z / most;
    return most * sqrt(x * x + y * y + z * z);
}

#define ORDINARY 1e140          /* lengths from its inverse on keep their bits */

bool bind_unit(vec3 *v)
{
    real most = fmax(fabs(v->x), fmax(fabs(v->y), fabs(v->z)));
    if (most > 0 && most <= DBL_MAX && !(most > 1 / ORDINARY && most < ORDINARY))
        *v = (vec3){v->x / most, v->y / most, v->z / most};
    real length = bind_length(*v);
    if (!(length > 0 && length <= DBL_MAX))
        return false;
    *v = (vec3){v->x / length, v->y / length, v->z / length};
    return true;
}

real bind_direction(vec3 *v)
{
    real length = bind_length(*v);
    if (length > 1 / ORDINARY && length < ORDINARY)
        return length;
    return bind_unit(v) ? 1 : 0;
}

/* {axis =, angle =}: sine and cosine of half the angle about the unit axis. Of {from =, to =} nothing is there, only known. */
static quat from_axis_angle(lua_State *L, int table, const char *what)
{
    static const char *const names[] = {"axis", "angle", "from", "to", NULL};
    vec3 axis = {0, 1, 0};
    real angle = 0;
    bind_check_keys(L, table, what, NULL, names);
    bind_get_vec3(L, table, what, "axis", "1", &axis);
    bind_get_real(L, table, what, "angle", "rad", &angle);
    remark_degrees(L, table, what);
    real length = bind_direction(&axis);
    if (!(length > 0))
        bind_error(L, "%s.axis = {%g, %g, %g}, must not be zero: it is a direction", what, axis.x, axis.y, axis.z);
    if (isinf(angle))
        bind_error(L, "%s.angle = inf rad, must be a finite number", what);
    real s = sin(angle / 2) / length;
    return (quat){s * axis.x, s * axis.y, s * axis.z, cos(angle / 2)};
}

/* The shortest turn from one direction to another: q ~ (a x b, 1 + a.b). Opposite ones turn about any normal. */
static quat between(vec3 a, vec3 b)
{
    real d = a.x * b.x + a.y * b.y + a.z * b.z;
    vec3 c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    if (d < -1 + 1e-12) {
        vec3 n = fabs(a.x) < 0.6 ? (vec3){0, a.z, -a.y} : (vec3){-a.z, 0, a.x};
        real length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
        return (quat){n.x / length, n.y / length, n.z / length, 0};
    }
    real n = sqrt(c.x * c.x + c.y * c.y + c.z * c.z + (1 + d) * (1 + d));
    return (quat){c.x / n, c.y / n, c.z / n, (1 + d) / n};
}

static vec3 direction(lua_State *L, int table, const char *what, const char *field)
{
    vec3 v = {0, 1, 0};
    bind_get_vec3(L, table, what, field, "1", &v);
    if (!bind_unit(&v))
        bind_error(L, "%s.%s = {%g, %g, %g}, must not be zero: it is a direction", what, field, v.x, v.y, v.z);
    return v;
}

/* {from =, to =}: directions before and after */
static quat from_directions(lua_State *L, int table, const char *what)
{
    static const char *const names[] = {"from", "to", NULL};
    bind_check_keys(L, table, what, NULL, names);
    vec3 from = direction(L, table, what, "from");
    return between(from, direction(L, table, what, "to"));
}

static bool has_field(lua_State *L, int table, const char *name)
{
    bool has = lua_getfield(L, table, name) != LUA_TNIL;
    lua_pop(L, 1);
    return has;
}

quat bind_quat(lua_State *L, int index, const char *what, const char *field)
{
    quat *q = luaL_testudata(L, index, BIND_QUAT);
    if (q)
        return *q;
    if (!lua_istable(L, index))
        wrong_type(L, index, what, field, "a rotation: {axis = {0, 1, 0}, angle = '90 deg'}, {from=, to=} or {x, y, z, w}");
    index = lua_absindex(L, index);
    push_path(L, what, field);
    const char *path = lua_tostring(L, -1);
    if (lua_rawlen(L, index) == 0) {
        bool pointed = has_field(L, index, "from") || has_field(L, index, "to");
        quat turned = pointed ? from_directions(L, index, path) : from_axis_angle(L, index, path);
        lua_pop(L, 1);
        return turned;
    }
    if (lua_rawlen(L, index) != 4)
        bind_error(L, "%s wants {axis = {0, 1, 0}, angle = '90 deg'} or {x, y, z, w}; got %d components", path, (int)lua_rawlen(L, index));
    real c[4];
    for (int i = 0; i < 4; i++) {
        lua_rawgeti(L, index, i + 1);
        c[i] = bind_real(L, -1, "1", path, NULL);
        lua_pop(L, 1);
    }
    real length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
    if (!(length > 0.9 && length < 1.1))
        bind_error(L, "%s = {%g, %g, %g, %g}, must have length 1: it is a rotation", path, c[0], c[1], c[2], c[3]);
    lua_pop(L, 1);
    return (quat){c[0] / length, c[1] / length, c[2] / length, c[3] / length};
}

/* ---- tables of arguments ---------------------------------------------------- */

void bind_push_declared(lua_State *L, const char *what)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.fields");
    if (lua_getfield(L, -1, what) != LUA_TTABLE)
        luaL_error(L, "%s is not declared", what);
    lua_remove(L, -2);
}

void bind_arguments(lua_State *L, int table, const char *what)
{
    if (!lua_istable(L, table))
        bind_wants_fields(L, table, what);
    table = lua_absindex(L, table);
    bind_push_declared(L, what);
    int declared = lua_gettop(L);
    const char *worst = NULL;           /* the first in the alphabet, whatever the order of next */
    for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
        if (lua_type(L, -2) != LUA_TSTRING)
            bind_check_keys(L, table, what, NULL, NULL);
        lua_pushvalue(L, -2);
        bool known = lua_rawget(L, declared) != LUA_TNIL;
        lua_pop(L, 1);
        if (!known && (!worst || strcmp(lua_tostring(L, -2), worst) < 0))
            worst = lua_tostring(L, -2);
    }
    if (worst)
        bind_unknown(L, lua_pushfstring(L, "%s:", what), "unknown field", worst, declared, declared);
    lua_settop(L, declared - 1);
}

static bool get_field(lua_State *L, int table, const char *field)
{
    table = lua_absindex(L, table);
    lua_pushstring(L, field);
    if (lua_rawget(L, table) != LUA_TNIL)
        return true;
    lua_pop(L, 1);
    return false;
}

bool bind_get_vec3(lua_State *L, int table, const char *what, const char *field, const char *unit, vec3 *value)
{
    if (!get_field(L, table, field))
        return false;
    *value = bind_vec3(L, -1, unit, what, field);
    lua_pop(L, 1);
    return true;
}

bool bind_get_quat(lua_State *L, int table, const char *what, const char *field, quat *value)
{
    if (!get_field(L, table, field))
        return false;
    *value = bind_quat(L, -1, what, field);
    lua_pop(L, 1);
    return true;
}

bool bind_get_real(lua_State *L, int table, const char *what, const char *field, const char *unit, real *value)
{
    if (!get_field(L, table, field))
        return false;
    *value = bind_real(L, -1, unit, what, field);
    if (isinf(*value))
        bind_error(L, "%s.%s = inf, must be a finite number", what, field);
    lua_pop(L, 1);
    return true;
}

vec3 bind_directed(lua_State *L, const char *what, const char *field, const char *unit)
{
    vec3 v = {0, 0, 0};
    lua_pushstring(L, field);
    int type = lua_rawget(L, 2);
    if (type == LUA_TNIL)
        bind_error(L, "%s: %s is missing", what, field);
    if (type != LUA_TNUMBER && type != LUA_TSTRING) {
        lua_pop(L, 1);
        bind_get_vec3(L, 2, what, field, unit, &v);
        return v;
    }
    real amount = bind_real(L, -1, unit, what, field);
    if (isinf(amount))
        bind_error(L, "%s.%s = inf %s, must be a finite number", what, field, unit);
    lua_pop(L, 1);
    if (!bind_get_vec3(L, 2, what, "along", "1", &v))
        bind_error(L, "%s: %s is a number; it needs along = {x, y, z}", what, field);
    real length = bind_direction(&v);
    if (!(length > 0))
        bind_error(L, "%s.along = {%g, %g, %g}, must not be zero: it is a direction", what, v.x, v.y, v.z);
    return (vec3){amount * v.x / length, amount * v.y / length, amount * v.z / length};
}
