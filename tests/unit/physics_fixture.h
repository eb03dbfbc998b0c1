/* tests/unit/physics_fixture.h - worlds and bodies in one line each, for the tests of motion. Gravity is 9.81 m/s^2 along -y. */
#ifndef DIG_PHYSICS_FIXTURE_H
#define DIG_PHYSICS_FIXTURE_H

#include "check.h"
#include "digbox.h"
#include "math/quat.h"

#define GRAVITY 9.81

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

/* Surface of everything that a test makes, until it says otherwise. */
typedef struct Look { real friction, friction_dynamic, rolling, restitution; } Look;

static inline Look look(real friction, real restitution) { return (Look){friction, NAN, 0, restitution}; }

static inline dig_world *open_with(dig_world_def def)
{
    dig_world *w;
    char why[256] = "";
    if (dig_world_open(&def, &w, why, sizeof why) != DIG_OK)
        fail_msg("world: %s", why);
    return w;
}

/* step in s; plan NULL: the default */
static inline dig_world *open_world(real step, const char *plan, bool gravity)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = (vec3){0, gravity ? -GRAVITY : 0, 0};
    def.step = step;
    if (plan)
        snprintf(def.accuracy.s, sizeof def.accuracy.s, "%s", plan);
    return open_with(def);
}

static inline dig_body_def body_with(Look l, vec3 at, quat q)
{
    dig_body_def d = dig_body_defaults();
    d.at = at;
    d.rotation = q;
    d.friction = l.friction;
    d.friction_dynamic = l.friction_dynamic;
    d.rolling_friction = l.rolling;
    d.restitution = l.restitution;
    return d;
}

/* density 1000 unless the def gives a mass */
static inline dig_body add_body(dig_world *w, dig_body_def d, const char *type, const void *data)
{
    dig_shape_def s;
    memset(&s, 0, sizeof s);
    s.type = type;
    s.data = data;
    s.colour.x = -1;
    d.shapes = &s;
    d.shape_count = 1;
    dig_body b = {0, 0};
    if (dig_body_create(w, &d, &b) != DIG_OK)
        fail_msg("%s: %s", type, dig_error(w));
    return b;
}

/* A joint with its type's own parameters. */
static inline dig_joint create_joint(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at, vec3 axis, const void *data)
{
    dig_joint_def def = dig_joint_defaults();
    def.type = type;
    def.a = a;
    def.b = b;
    def.at = at;
    def.axis = axis;
    def.data = data;
    dig_joint j;
    if (dig_joint_create(w, &def, &j) != DIG_OK)
        fail_msg("%s: %s", type, dig_error(w));
    return j;
}

/* The same with their defaults. */
static inline dig_joint join_bodies(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at, vec3 axis)
{
    char data[1024];
    const dig_schema *schema = dig_schema_find("joint", type);
    CHECK(schema && schema->size <= sizeof data);
    dig_schema_defaults(schema, data);
    return create_joint(w, type, a, b, at, axis, data);
}

/* Solid below normal . x = 0. */
static inline dig_body add_slope(dig_world *w, Look l, vec3 normal)
{
    dig_body_def d = body_with(l, vec3_zero(), quat_identity());
    d.fixed = true;
    dig_plane_def plane = {normal, 0};
    return add_body(w, d, "plane", &plane);
}

static inline dig_body add_floor(dig_world *w, Look l) { return add_slope(w, l, (vec3){0, 1, 0}); }

static inline dig_body add_ball(dig_world *w, Look l, real radius, real mass, vec3 at, vec3 velocity)
{
    dig_body_def d = body_with(l, at, quat_identity());
    d.mass = mass;
    d.velocity = velocity;
    dig_sphere_def s = {radius};
    return add_body(w, d, "sphere", &s);
}

static inline dig_body add_box(dig_world *w, Look l, vec3 size, real mass, vec3 at, quat q)
{
    dig_body_def d = body_with(l, at, q);
    d.mass = mass;
    dig_box_def s = {size};
    return add_body(w, d, "box", &s);
}

static inline dig_body_state state_of(const dig_world *w, dig_body b)
{
    dig_body_state s;
    if (dig_body_get(w, b, &s) != DIG_OK)
        fail_msg("dig_body_get: %s", dig_error(w));
    return s;
}

static inline dig_body_debug debug_of(const dig_world *w, dig_body b)
{
    dig_body_debug s;
    if (dig_body_inspect(w, b, &s) != DIG_OK)
        fail_msg("dig_body_inspect: %s", dig_error(w));
    return s;
}

static inline void step(dig_world *w, int count)
{
    for (int i = 0; i < count; i++)
        if (dig_world_step(w) != DIG_OK)
            fail_msg("step: %s", dig_error(w));
}

static inline void check_world(dig_world *w)
{
    if (dig_world_check(w) != DIG_OK)
        fail_msg("at t = %g s: %s", dig_world_time(w), dig_error(w));
}

static inline int count_events(const dig_world *w, dig_event_kind kind)
{
    const dig_event *e;
    int n = dig_events(w, &e), count = 0;
    for (int i = 0; i < n; i++)
        count += e[i].kind == kind;
    return count;
}

#endif
