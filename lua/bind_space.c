/* lua/bind_space.c - questions in space: rays, overlaps, sweeps. */

#include "bind.h"

#include <math.h>
#include <string.h>

static void push_hit(lua_State *L, const dig_hit *hit)
{
    static const char *const sometimes[] = {"body", NULL};          /* a wall of the room is none */
    lua_createtable(L, 0, 5);
    bind_push_body(L, 1, hit->body);
    lua_setfield(L, -2, "body");
    bind_push_vec3(L, hit->point);
    lua_setfield(L, -2, "point");
    bind_push_vec3(L, hit->normal);
    lua_setfield(L, -2, "normal");
    bind_set_real(L, "distance", hit->distance);
    bind_set_real(L, "fraction", hit->fraction);
    bind_record(L, "hit", sometimes, false);
}

/* The way in the fields from, and to or along and length, of the table at 2: its start, unit direction or not, and length. */
static void read_way(lua_State *L, const char *what, vec3 *from, vec3 *along, real *length)
{
    vec3 to;
    bool has_from = bind_get_vec3(L, 2, what, "from", "m", from), has_to = bind_get_vec3(L, 2, what, "to", "m", &to);
    bool has_along = bind_get_vec3(L, 2, what, "along", "1", along);
    if (!has_from)
        bind_error(L, "%s: from is missing", what);
    if (has_to == has_along)
        bind_error(L, "%s wants either to or along", what);
    if (has_to)
        *along = (vec3){to.x - from->x, to.y - from->y, to.z - from->z};
    real norm = bind_length(*along);
    *length = has_to ? norm : 1e4;
    bind_get_real(L, 2, what, "length", "m", length);
    if (!(norm > 0))
        bind_error(L, "%s: the %s has no direction", what, strcmp(what, "world:ray") == 0 ? "ray" : "way");
    if (!(*length > 0))
        bind_error(L, "%s: length = %g m, must be > 0: for the other way reverse the direction", what, *length);
}

/* world:ray{from=, to=} or {from=, along=, length=} -> hits by distance */
static int world_ray(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    vec3 from, along;
    real length;
    bind_arguments(L, 2, "world:ray");
    read_way(L, "world:ray", &from, &along, &length);
    dig_hit few[64], *hits = few;
    int n = dig_ray(ref->w, from, along, length, few, 64);
    if (n > 64) {
        hits = lua_newuserdatauv(L, (size_t)n * sizeof *hits, 0);
        n = dig_ray(ref->w, from, along, length, hits, n);
    }
    if (n < 0)
        return bind_fail(L, ref->w, DIG_E_ARG);
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        push_hit(L, &hits[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* world:overlap{shape, at=, rotation=} -> bodies */
static int world_overlap(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    pose at;
    const dig_shape_def *shape = bind_shape_argument(L, "world:overlap", &at);
    int n = dig_overlap(ref->w, shape, at, NULL, 0);
    if (n < 0)
        return bind_fail(L, ref->w, DIG_E_ARG);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    return bind_push_bodies(L, 1, ids, dig_overlap(ref->w, shape, at, ids, n));
}

/* world:sweep{shape, at=, rotation=, velocity=, acceleration=, time=} or {shape, rotation=, from=, to= | along=, length=} -> hit or nil */
static int world_sweep(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    pose at;
    vec3 velocity = {0, 0, 0}, acceleration = {0, 0, 0};
    real time = 1;
    dig_hit hit;
    const dig_shape_def *shape = bind_shape_argument(L, "world:sweep", &at);
    bool moves = bind_get_vec3(L, 2, "world:sweep", "velocity", "m/s", &velocity);
    moves = bind_get_vec3(L, 2, "world:sweep", "acceleration", "m/s^2", &acceleration) || moves;
    moves = bind_get_real(L, 2, "world:sweep", "time", "s", &time) || moves;
    vec3 from, along, old;
    real length;
    if (bind_get_vec3(L, 2, "world:sweep", "from", "m", &from) || bind_get_vec3(L, 2, "world:sweep", "to", "m", &from) ||
        bind_get_vec3(L, 2, "world:sweep", "along", "1", &along) || bind_get_real(L, 2, "world:sweep", "length", "m", &length)) {
        read_way(L, "world:sweep", &from, &along, &length);
        if (moves || bind_get_vec3(L, 2, "world:sweep", "at", "m", &old))
            return bind_error(L, "world:sweep wants either from, and to or along, or at and velocity");
        real share = length / bind_direction(&along);
        at.p = (vec3){at.p.x + from.x, at.p.y + from.y, at.p.z + from.z};
        velocity = (vec3){along.x * share, along.y * share, along.z * share};
    } else if (!moves) {
        return bind_error(L, "world:sweep wants a way: from, and to or along, or at and velocity");
    }
    int found = dig_sweep(ref->w, shape, at, velocity, acceleration, time, &hit);
    if (found < 0)
        return bind_fail(L, ref->w, DIG_E_ARG);
    if (found == 0)
        lua_pushnil(L);
    else
        push_hit(L, &hit);
    return 1;
}

static const luaL_Reg methods[] = {{"ray", world_ray}, {"overlap", world_overlap}, {"sweep", world_sweep}, {NULL, NULL}};

void bind_space_open(lua_State *L, int core)
{
    bind_extend(L, core, BIND_WORLD, methods);
}
