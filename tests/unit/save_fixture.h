/* tests/unit/save_fixture.h - a world with one of everything, and files for it. */
#define _XOPEN_SOURCE 700       /* P_tmpdir, getpid; to be included first */
#ifndef DIG_SAVE_FIXTURE_H
#define DIG_SAVE_FIXTURE_H

#include <stdlib.h>
#include <unistd.h>

#include "physics_fixture.h"
#include "scratch.h"

/* ---- files ---- */

typedef struct Bytes { unsigned char *data; size_t size; } Bytes;

static inline Bytes read_bytes(const char *path)
{
    Bytes b = {NULL, 0};
    FILE *f = fopen(path, "rb");
    if (!f)
        fail_msg("cannot read %s", path);
    fseek(f, 0, SEEK_END);
    b.size = (size_t)ftell(f);
    rewind(f);
    b.data = malloc(b.size + 1);
    if (!b.data || fread(b.data, 1, b.size, f) != b.size)
        fail_msg("cannot read %s", path);
    fclose(f);
    return b;
}

static inline void write_bytes(const char *path, const unsigned char *data, size_t size)
{
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(data, 1, size, f) != size || fclose(f) != 0)
        fail_msg("cannot write %s", path);
}

static inline void save_to(dig_world *w, const char *path)
{
    if (dig_world_save(w, path) != DIG_OK)
        fail_msg("save: %s", dig_error(w));
}

static inline dig_world *load_from(const char *path)
{
    char why[256] = "";
    dig_world *w;
    if (dig_world_load(path, &w, why, sizeof why) != DIG_OK)
        fail_msg("load: %s", why);
    return w;
}

/* Bytes of the world's file. */
static inline Bytes bytes_of(dig_world *w, const char *name)
{
    char path[512];
    save_to(w, scratch_path(path, sizeof path, name));
    Bytes b = read_bytes(path);
    remove(path);
    return b;
}

/* ---- the scene: each part stands for itself, some metres from the next ---- */

static inline void fail_unless(dig_world *w, dig_status s, const char *what)
{
    if (s != DIG_OK)
        fail_msg("%s: %s", what, dig_error(w));
}

static inline dig_body add_solids(dig_world *w, const char *name, vec3 at, bool fixed, const dig_shape_def *shapes, int count)
{
    dig_body b;
    dig_body_def d = dig_body_defaults();
    snprintf(d.name.s, sizeof d.name.s, "%s", name);
    d.at = at;
    d.fixed = fixed;
    d.shapes = shapes;
    d.shape_count = count;
    fail_unless(w, dig_body_create(w, &d, &b), name);
    return b;
}

static inline dig_shape_def shape_of(const char *type, const void *data, vec3 at)
{
    dig_shape_def s = {.type = type, .data = data, .at = {at, quat_identity()}};
    s.colour = (vec3){-1, -1, -1};
    return s;
}

static inline dig_joint join(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at, vec3 axis, const void *data)
{
    dig_joint j;
    dig_joint_def d = dig_joint_defaults();
    d.type = type;
    d.a = a;
    d.b = b;
    d.at = at;
    d.axis = axis;
    d.data = data;
    fail_unless(w, dig_joint_create(w, &d, &j), type);
    return j;
}

/* A bucket of five boards, with a hull and a ball in it. */
static inline void add_bucket(dig_world *w, vec3 at)
{
    const dig_box_def bottom = {{1, 0.1, 1}}, side = {{0.1, 0.6, 1}}, end = {{0.8, 0.6, 0.1}};
    dig_shape_def boards[5] = {shape_of("box", &bottom, (vec3){0, 0, 0}), shape_of("box", &side, (vec3){-0.45, 0.35, 0}),
                               shape_of("box", &side, (vec3){0.45, 0.35, 0}), shape_of("box", &end, (vec3){0, 0.35, -0.45}),
                               shape_of("box", &end, (vec3){0, 0.35, 0.45})};
    snprintf(boards[0].material.s, sizeof boards[0].material.s, "steel");
    add_solids(w, "bucket", at, false, boards, 5);

    const vec3 corners[7] = {{-0.15, -0.1, -0.1}, {0.16, -0.1, -0.12}, {0.1, -0.1, 0.17}, {-0.12, -0.1, 0.13}, {0.02, 0.2, 0.03},
                             {0.1, 0.1, 0.05}, {0, 0, 0}};
    const dig_hull_def hull = {{corners, 7}};
    dig_shape_def stone = shape_of("hull", &hull, vec3_zero());
    add_solids(w, "stone", vec3_add(at, (vec3){0.1, 0.5, 0}), false, &stone, 1);
    dig_body ball = add_ball(w, look(0.4, 0.5), 0.1, 2, vec3_add(at, (vec3){-0.2, 0.8, 0.1}), vec3_zero());
    fail_unless(w, dig_body_set(w, ball, "name", &(dig_text){"ball"}), "name");
}

/* A mesh that is a shallow roof, with a capsule and a cone on it. */
static inline void add_roof(dig_world *w, vec3 at)
{
    const vec3 v[9] = {{-1, 0.2, -1}, {0, 0, -1}, {1, 0.2, -1}, {-1, 0.1, 0}, {0, 0, 0}, {1, 0.15, 0}, {-1, 0.2, 1}, {0, 0, 1}, {1, 0.2, 1}};
    const int64_t t[24] = {1, 4, 2, 2, 4, 5, 2, 5, 3, 3, 5, 6, 4, 7, 5, 5, 7, 8, 5, 8, 6, 6, 8, 9};
    const dig_mesh_def mesh = {{v, 9}, {t, 24}};
    dig_shape_def roof = shape_of("mesh", &mesh, vec3_zero());
    add_solids(w, "roof", at, true, &roof, 1);
    const dig_capsule_def capsule = {0.1, 0.3};
    const dig_cone_def cone = {0.2, 0.4};
    const dig_cylinder_def cylinder = {0.15, 0.2};
    dig_shape_def s[3] = {shape_of("capsule", &capsule, vec3_zero()), shape_of("cone", &cone, vec3_zero()),
                          shape_of("cylinder", &cylinder, vec3_zero())};
    add_solids(w, "capsule", vec3_add(at, (vec3){-0.5, 0.5, 0.1}), false, &s[0], 1);
    add_solids(w, "cone", vec3_add(at, (vec3){0.5, 0.4, -0.2}), false, &s[1], 1);
    add_solids(w, "cylinder", vec3_add(at, (vec3){0.1, 0.6, 0.6}), false, &s[2], 1);
}

static inline void add_hills(dig_world *w, vec3 at)
{
    const real heights[12] = {0, 0.1, 0.1, 0, 0.1, 0, 0.05, 0.1, 0, 0.1, 0.1, 0};
    const dig_heightfield_def hills = {.heights = heights, .columns = 4, .rows = 3, .size = {2.7, 0, 2.1}};
    dig_shape_def s = shape_of("heightfield", &hills, vec3_zero());
    add_solids(w, "hills", at, true, &s, 1);
    add_ball(w, look(0.5, 0.2), 0.15, 1, vec3_add(at, (vec3){0.2, 0.6, 0.1}), (vec3){0.3, 0, 0});
}

static inline void add_joints(dig_world *w, vec3 at)
{
    Look l = look(0.5, 0);
    dig_body post = add_box(w, l, (vec3){0.2, 0.2, 0.2}, 5, at, quat_identity());
    dig_body door = add_box(w, l, (vec3){0.5, 0.05, 0.3}, 2, vec3_add(at, (vec3){0.35, 0.3, 0}), quat_identity());
    dig_body weight = add_ball(w, l, 0.1, 1, vec3_add(at, (vec3){0, 1.2, 0.8}), vec3_zero());
    dig_body wheel = add_ball(w, l, 0.12, 1, vec3_add(at, (vec3){0, 0.9, -0.8}), vec3_zero());
    dig_body frame = add_box(w, l, (vec3){0.2, 0.1, 0.2}, 3, vec3_add(at, (vec3){0, 1.2, -0.8}), quat_identity());
    dig_schema const *hinge = dig_schema_find("joint", "hinge"), *spring = dig_schema_find("joint", "spring");
    dig_schema const *axle = dig_schema_find("joint", "wheel"), *rope = dig_schema_find("joint", "rope");
    real params[48];

    dig_schema_defaults(hinge, params);
    params[0] = -1;                                 /* limits */
    params[1] = 1.5;
    join(w, "hinge", door, post, vec3_add(at, (vec3){0.1, 0.3, 0}), (vec3){0, 0, 1}, params);
    dig_schema_defaults(spring, params);
    params[6] = 40;                                 /* stiffness, damping */
    params[7] = 0.5;
    join(w, "spring", weight, post, (vec3){NAN, NAN, NAN}, (vec3){NAN, NAN, NAN}, params);
    dig_schema_defaults(axle, params);
    join(w, "wheel", wheel, frame, vec3_add(at, (vec3){0, 0.9, -0.8}), (vec3){0, 1, 0}, params);
    dig_schema_defaults(rope, params);
    join(w, "rope", frame, (dig_body){0, 0}, vec3_add(at, (vec3){0, 2, -0.8}), (vec3){NAN, NAN, NAN}, params);
}

static inline void add_acts(dig_world *w, vec3 at)
{
    Look l = look(0.5, 0.3);
    dig_body pushed = add_box(w, l, (vec3){0.3, 0.3, 0.3}, 3, vec3_add(at, (vec3){0, 0.16, 0}), quat_identity());
    dig_body hit = add_box(w, l, (vec3){0.2, 0.4, 0.3}, 2, vec3_add(at, (vec3){0, 0.21, 1}), quat_identity());
    dig_body_def d = body_with(l, vec3_add(at, (vec3){0, 0.11, -1}), quat_identity());
    d.kinematic = true;
    dig_box_def lift = {{0.5, 0.2, 0.5}};
    dig_body mover = add_body(w, d, "box", &lift);
    add_ball(w, l, 0.1, 1, vec3_add(at, (vec3){0, 0.4, -1}), vec3_zero());
    fail_unless(w, dig_body_push(w, pushed, (vec3){9, 0, 1}, vec3_add(at, (vec3){0.1, 0.2, 0}), true, 6), "push");
    fail_unless(w, dig_body_twist(w, pushed, (vec3){0, 0.4, 0}, 3), "twist");
    fail_unless(w, dig_body_hit(w, hit, (vec3){0, 1, 2}, vec3_add(at, (vec3){0.1, 0.3, 1}), true), "hit");
    fail_unless(w, dig_body_move_to(w, mover, vec3_add(at, (vec3){0, 0.6, -1}), NULL, 4), "move_to");
    fail_unless(w, dig_message_send(w, pushed, hit, "greeting", (const real[4]){1, 2, 3, 4}), "send");
    const dig_wire_def wires[] = {{DIG_LAYER_ELECTRICAL, pushed, hit, false, 3}, {DIG_LAYER_ELECTRICAL, hit, mover, true, 0},
                                  {DIG_LAYER_THERMAL, mover, hit, false, 0}};
    dig_wire wire = {0, 0, 0};
    for (size_t i = 0; i < sizeof wires / sizeof wires[0]; i++)
        fail_unless(w, dig_wire_add(w, &wires[i], &wire), "link");
    fail_unless(w, dig_wire_set(w, wire, 4, 0.5), "link");
    for (int i = 0; i < DIG_ROUTES; i++) {
        dig_post p = dig_post_defaults();
        memcpy(p.kind, "later", 6);
        p.route = (dig_route)i;
        p.from = pushed;
        p.to = hit;
        p.after = 0.3 + 0.1 * (i % 3);
        p.layer = i == DIG_ROUTE_FLOOD ? DIG_LAYER_ELECTRICAL : DIG_LAYER_MECHANICAL;
        p.transform = i == DIG_ROUTE_FLOOD ? DIG_TRANSFORM_RATIO : DIG_TRANSFORM_SAME;
        if (i != DIG_ROUTE_REGION)
            fail_unless(w, dig_message_post(w, &p, NULL), "post");
    }

    const dig_box_def space = {{0.8, 0.8, 0.8}};
    dig_region_def r = dig_region_defaults();
    dig_region region;
    r.shape = shape_of("box", &space, vec3_zero());
    r.at = (pose){vec3_add(at, (vec3){0, 0.5, 1}), quat_identity()};
    r.drag = 0.4;
    r.gravity = (vec3){1, -5, 0};
    r.conduct = 3;
    r.time_rate = 0.7;
    fail_unless(w, dig_region_create(w, &r, &region), "region");
}

/* A stack that stands and falls asleep, and one in a DIG with a plan of its own. */
static inline void add_stacks(dig_world *w, vec3 at)
{
    for (int i = 0; i < 4; i++)
        add_box(w, look(0.6, 0), (vec3){0.4, 0.2, 0.4}, 2, vec3_add(at, (vec3){0, 0.1 + 0.2 * i, 0}), quat_identity());
    dig_body b = {0, 0};
    for (int i = 0; i < 3; i++)
        b = add_box(w, look(0.6, 0), (vec3){0.3, 0.2, 0.3}, 2, vec3_add(at, (vec3){1.5, 0.105 + 0.21 * i, 0}), quat_identity());
    fail_unless(w, dig_dig_accuracy(w, dig_of(w, b), "study", 0), "plan");
}

static inline void add_materials(dig_world *w)
{
    dig_material_def m;
    fail_unless(w, dig_material_get(w, "oak", &m), "oak");
    m.friction = 0.33;
    fail_unless(w, dig_material_add(w, "waxed oak", &m), "material");
    dig_pair_def pair = {.a = {"waxed oak"}, .b = {"steel"}, .friction = 0.1, .friction_dynamic = 0.08, .rolling_friction = NAN,
                         .restitution = NAN};
    fail_unless(w, dig_material_pair(w, &pair), "pair");
}

/* Some bodies come and go, so that free slots and their order matter. */
static inline void add_and_remove(dig_world *w)
{
    dig_body b[6];
    for (int i = 0; i < 6; i++)
        b[i] = add_ball(w, look(0.5, 0.5), 0.1, 1, (vec3){-8 + 0.15 * i, 0.1, 6}, vec3_zero());
    step(w, 3);
    fail_unless(w, dig_body_remove(w, b[3]), "remove");
    fail_unless(w, dig_body_remove(w, b[1]), "remove");
    fail_unless(w, dig_body_remove(w, b[4]), "remove");
}

/* A room with one of everything. */
static inline void furnish(dig_world *w)
{
    dig_room_def room = {{24, 12, 24}, {0, 0, 0}, 0.5, 0.2, {""}};
    fail_unless(w, dig_room_set(w, &room), "room");
    fail_unless(w, dig_room_open(w, "+y", true), "open");
    add_materials(w);
    add_stacks(w, (vec3){-8, 0, -8});
    add_joints(w, (vec3){-4, 0.1, 0});
    add_bucket(w, (vec3){0, 0.05, 0});
    add_roof(w, (vec3){4, 0.1, 0});
    add_hills(w, (vec3){4, 0.1, 5});
    add_acts(w, (vec3){8, 0, 0});
}

static inline dig_world *open_scene(void)
{
    dig_world_def def = dig_world_defaults();
    def.seed = 7;
    dig_world *w = open_with(def);
    furnish(w);
    dig_body slider = add_box(w, look(0.3, 0), (vec3){0.4, 0.2, 0.4}, 2, (vec3){0, 0.1, -8}, quat_identity());
    fail_unless(w, dig_body_set(w, slider, "material", &(dig_text){"waxed oak"}), "material");
    fail_unless(w, dig_effect_set(w, "rolling", true), "effect");
    add_and_remove(w);
    return w;
}

/* A file small enough to be cut everywhere: a ball on a floor and a box on a hinge. */
static inline dig_world *open_small_scene(void)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    add_floor(w, look(0.5, 0));
    add_ball(w, look(0.5, 0.3), 0.2, 1, (vec3){0, 0.19999, 0}, vec3_zero());
    dig_body box = add_box(w, look(0.5, 0), (vec3){0.4, 0.2, 0.2}, 1, (vec3){2, 1, 0}, quat_identity());
    join(w, "hinge", box, (dig_body){0, 0}, (vec3){1.8, 1, 0}, (vec3){0, 0, 1}, NULL);
    step(w, 5);
    return w;
}

#endif
