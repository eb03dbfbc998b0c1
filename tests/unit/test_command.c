/* tests/unit/test_command.c - what is done to a world is logged, and played again leads to the same world, bit for bit. */
#include "save_fixture.h"
#include "draw_fixture.h"

#include "api/command.h"

/* ---- a log in memory ---- */

typedef struct Log {
    unsigned char *bytes;
    size_t size, capacity;
    size_t start[4096];         /* of each command */
    int    count;
} Log;

static void keep(void *context, const void *bytes, size_t size)
{
    Log *l = context;
    if (l->size + size > l->capacity) {
        l->capacity = 2 * (l->size + size);
        l->bytes = realloc(l->bytes, l->capacity);
    }
    if (!l->bytes || l->count >= 4096)
        fail_msg("the log is full");
    memcpy(l->bytes + l->size, bytes, size);
    l->start[l->count++] = l->size;
    l->size += size;
}

static Bytes packed(dig_world *w)
{
    void *data;
    Bytes b = {NULL, 0};
    fail_unless(w, dig_world_pack(w, &data, &b.size), "pack");
    b.data = data;
    return b;
}

static dig_world *unpacked(Bytes b)
{
    char why[256];
    dig_world *w;
    if (dig_world_unpack(b.data, b.size, &w, why, sizeof why) != DIG_OK)
        fail_msg("unpack: %s", why);
    return w;
}

/* A world from here on. */
static Bytes listen(dig_world *w, Log *l)
{
    Bytes start = packed(w);
    fail_unless(w, dig_world_tap(w, keep, l), "tap");
    return start;
}

static void check_same(dig_world *a, dig_world *b, const char *what)
{
    Bytes x = packed(a), y = packed(b);
    size_t at = 0;
    while (at < x.size && at < y.size && x.data[at] == y.data[at])
        at++;
    if (x.size != y.size || at < x.size)
        fail_msg("%s: worlds of %zu and %zu bytes differ at byte %zu", what, x.size, y.size, at);
    CHECK(dig_world_checksum(a) == dig_world_checksum(b));
    free(x.data);
    free(y.data);
}

/* Plays all in a copy of the start, logs that too, and compares: the world, and what was logged of both. */
static void check_played(dig_world *w, Bytes start, const Log *l)
{
    Log again = {.size = 0};
    dig_world *copy = unpacked(start);
    fail_unless(copy, dig_world_tap(copy, keep, &again), "tap");
    for (size_t at = 0, length; at < l->size; at += length)
        if (dig_command_play(copy, l->bytes + at, l->size - at, &length) != DIG_OK)
            fail_msg("command '%s' at byte %zu: %s", dig_command_name(dig_command_look(l->bytes + at, l->size - at, NULL)), at, dig_error(copy));
    check_same(w, copy, "played");
    CHECK_INT(again.size, l->size);
    CHECK(memcmp(again.bytes, l->bytes, l->size) == 0);
    CHECK_INT(dig_world_check(copy), DIG_OK);
    dig_world_close(copy);
    free(again.bytes);
}

/* ---- each command at least once ---- */

typedef struct Spin { real strength; int calls, fail_at; dig_snapshot *garbage; } Spin;

static dig_status spin(void *data, const dig_effect_call *call, char *why, size_t capacity)
{
    Spin *s = data;
    snprintf(why, capacity, "it was told to fail");
    dig_snapshot_free(s->garbage);      /* as a script does that collects its garbage at any time */
    s->garbage = NULL;
    for (int i = 0; i < call->count; i++) {
        call->parts[i].force = (vec3){s->strength * call->parts[i].velocity.z, 0, -s->strength * call->parts[i].velocity.x};
        call->parts[i].torque.y = i == 1 ? -0.0 : 1e-3 * s->calls;      /* what no replay could guess */
    }
    return ++s->calls == s->fail_at ? DIG_E_ARG : DIG_OK;
}

static real spin_energy(void *data, const dig_effect_call *call)
{
    const Spin *s = data;
    return s->calls + 0.1 * call->count;
}

static void add_spin(dig_world *w, const char *name, Spin *s, bool all)
{
    const dig_effect_def def = {.name = name, .law = "F = k v x up", .stage = DIG_STAGE_FORCE, .all = all, .step = spin,
                                .energy = all ? NULL : spin_energy, .data = s, .why = "test_command.c"};
    fail_unless(w, dig_effect_add(w, &def), name);
}

static void build(dig_world *w)
{
    furnish(w);
    add_and_remove(w);
}

static void use_effects(dig_world *w, dig_body b)
{
    dig_schema heat;
    real member[64], options[64];
    for (int i = 0; dig_effect_schema(i, "body", &heat); i++)
        if (strcmp(heat.name, "heat") == 0)
            break;
    dig_schema_defaults(&heat, member);
    fail_unless(w, dig_effect_join(w, "heat", b, member, "test_command.c"), "join");
    fail_unless(w, dig_body_set(w, b, "emissivity", &(real){0.5}), "emissivity");
    fail_unless(w, dig_body_warm(w, b, NAN, 500), "warm");
    dig_effect_options(w, "heat", options);
    fail_unless(w, dig_effect_option(w, "heat", options, NULL), "option");
    fail_unless(w, dig_effect_set(w, "rolling", true), "effect");
    fail_unless(w, dig_effect_explain(w, "rolling", "somebody likes it"), "explain");
}

static void use_bodies(dig_world *w, dig_body b, dig_body mover)
{
    const vec3 at = {1, 3, 1}, velocity = {0, 1, 0};
    const quat q = quat_exp((vec3){0, 0.3, 0});
    fail_unless(w, dig_body_teleport(w, b, &at, &q, NULL, &velocity), "teleport");
    fail_unless(w, dig_body_move_to(w, mover, (vec3){8, 0.4, -1}, &q, 1), "move");
    step(w, 2);
    fail_unless(w, dig_body_set_velocity(w, mover, velocity, velocity), "velocity");
    fail_unless(w, dig_body_set(w, b, "mass", &(real){3}), "mass");
    fail_unless(w, dig_body_set(w, b, "name", &(dig_text){"renamed"}), "name");
    fail_unless(w, dig_body_set(w, b, "colour", &velocity), "colour");
    fail_unless(w, dig_body_wake(w, b), "wake");
    CHECK_INT(dig_body_hit(w, b, (vec3){1e30, 0, 0}, vec3_zero(), false), DIG_E_ARG);
}

static void use_joints(dig_world *w, dig_body b)
{
    dig_joint all[32];
    dig_joint_state j;
    int count = dig_joints(w, all, 32);
    CHECK(count >= 4 && count <= 32);
    for (int i = 0; i < count; i++) {
        fail_unless(w, dig_joint_get(w, all[i], &j), "joint");
        if (strcmp(j.type, "spring") == 0)
            fail_unless(w, dig_joint_set(w, all[i], &(dig_setting){"stiffness", &(real){55}}, 1), "stiffness");
    }
    fail_unless(w, dig_joint_set(w, all[0], &(dig_setting){"breaks_at", &(real){1e4}}, 1), "breaks_at");
    fail_unless(w, dig_joint_remove(w, all[count - 1]), "remove");
    real ball[48];
    dig_schema_defaults(dig_schema_find("joint", "ball"), ball);
    join(w, "ball", b, (dig_body){0, 0}, (vec3){1, 3.2, 1}, (vec3){0, 1, 0}, ball);
}

static void use_messages(dig_world *w, dig_body a, dig_body b)
{
    dig_post p = dig_post_defaults();
    const dig_body to[2] = {a, b};
    memcpy(p.kind, "list", 5);
    p.from = a;
    fail_unless(w, dig_message_list(w, &p, to, (const real[2]){1, 2}, 2), "list");
    const dig_message *last = NULL;
    CHECK(dig_message_take(w) > 0);
    const dig_event *events;
    for (int i = dig_events(w, &events) - 1; i >= 0 && !last; i--)
        last = dig_message_of(w, &events[i]);
    CHECK(last != NULL);
    dig_message_answering(w, last->root);
    fail_unless(w, dig_message_send(w, b, a, "thanks", NULL), "send");
    dig_message_answering(w, 0);
    dig_message_dropped(w, 1);
    CHECK_INT(dig_message_take(w), 1);
    CHECK_INT(dig_message_take(w), 0);
}

static void use_regions_and_wires(dig_world *w, dig_body a, dig_body b)
{
    const dig_sphere_def ball = {2};
    dig_region_def def = dig_region_defaults();
    dig_region r;
    def.shape = shape_of("sphere", &ball, vec3_zero());
    def.at.p = (vec3){0, 1, 0};
    def.drag = 0.2;
    fail_unless(w, dig_region_create(w, &def, &r), "region");
    fail_unless(w, dig_region_push(w, r, a, (vec3){0, 3, 0}), "region");
    step(w, 2);
    fail_unless(w, dig_region_remove(w, r), "region");
    dig_wire wire;
    const dig_wire_def wire_def = {DIG_LAYER_HYDRAULIC, a, b, false, 0};
    fail_unless(w, dig_wire_add(w, &wire_def, &wire), "wire");
    fail_unless(w, dig_wire_remove(w, wire), "wire");
    fail_unless(w, dig_world_set_gravity(w, (vec3){0, -5, 1}), "gravity");
    fail_unless(w, dig_world_set_accuracy(w, NULL, 1e-3), "accuracy");
    step(w, 2);
    fail_unless(w, dig_world_set_accuracy(w, "play", 0), "accuracy");
}

static void use_own_effects(dig_world *w, Spin *s, dig_body a, dig_body b)
{
    add_spin(w, "wind", &s[0], true);
    add_spin(w, "curl", &s[1], false);
    fail_unless(w, dig_effect_join(w, "curl", a, NULL, NULL), "join");
    fail_unless(w, dig_effect_join(w, "curl", b, NULL, NULL), "join");
    fail_unless(w, dig_world_snapshot(w, &s[0].garbage), "snapshot");
    step(w, 3);
    CHECK(s[0].garbage == NULL);
    s[0].fail_at = s[0].calls + 3;
    CHECK_INT(dig_world_step(w), DIG_E_ARG);
    CHECK(strstr(dig_error(w), "it was told to fail") != NULL);
    fail_unless(w, dig_effect_leave(w, "curl", b), "leave");
    step(w, 3);
    CHECK(dig_world_energy(w).elastic > s[1].calls);        /* looked at, which leaves no trace in the log */
}

static void use_snapshots(dig_world *w, dig_snapshot *old)
{
    dig_snapshot *s;
    fail_unless(w, dig_world_snapshot(w, &s), "snapshot");
    step(w, 4);
    fail_unless(w, dig_world_restore(w, s), "restore");
    dig_body made = add_ball(w, look(0.5, 0), 0.1, 1, (vec3){3, 6, 3}, vec3_zero());
    step(w, 2);
    fail_unless(w, dig_world_restore(w, s), "restore");
    CHECK(!dig_body_alive(w, made));
    dig_snapshot_free(s);
    step(w, 2);
    fail_unless(w, dig_world_restore(w, old), "restore");
    step(w, 5);
}

/* A step that one body's numbers make impossible is taken without it. */
static void use_aside(dig_world *w)
{
    dig_body b = add_ball(w, look(0.5, 0), 0.1, 1, (vec3){-3, 6, 3}, vec3_zero());
    fail_unless(w, dig_world_inject(w, b), "inject");
    CHECK_INT(dig_world_step(w), DIG_E_FINITE);
    fail_unless(w, dig_body_disable(w, dig_world_culprit(w)), "disable");
    step(w, 3);
    CHECK_INT(state_of(w, b).kind, DIG_FIXED);
}

static void do_everything(dig_world *w, Spin *s)
{
    dig_snapshot *old;
    dig_body bodies[64];
    int count = dig_bodies(w, bodies, 64);
    dig_body top = dig_body_find(w, "stone"), capsule = dig_body_find(w, "capsule"), mover = {0, 0};
    for (int i = 0; i < count && i < 64; i++)
        if (state_of(w, bodies[i]).kind == DIG_KINEMATIC)
            mover = bodies[i];
    use_effects(w, top);
    use_bodies(w, capsule, mover);
    use_joints(w, capsule);
    use_messages(w, top, capsule);
    use_regions_and_wires(w, top, capsule);
    dig_dig d = dig_of(w, top);
    fail_unless(w, dig_dig_accuracy(w, d, "study", 0), "accuracy");
    use_aside(w);
    use_own_effects(w, s, top, capsule);
    fail_unless(w, dig_world_snapshot(w, &old), "snapshot");
    dig_snapshot_free(old);
}

TEST(every_command_is_played_again)
{
    Spin s[2] = {{.strength = 0.3}, {.strength = 0.1}};
    Log l = {.size = 0};
    dig_world_def def = dig_world_defaults();
    def.seed = 7;
    dig_world *w = open_with(def);
    dig_snapshot *old;
    Bytes start = listen(w, &l);
    build(w);
    step(w, 20);
    do_everything(w, s);
    check_played(w, start, &l);
    fail_unless(w, dig_world_tap(w, NULL, NULL), "tap");
    fail_unless(w, dig_world_snapshot(w, &old), "snapshot");     /* nobody listens, and effects of its own are there */

    Log more = {.size = 0};
    Bytes middle = listen(w, &more);
    use_snapshots(w, old);
    fail_unless(w, dig_effect_drop(w, "wind"), "drop");
    step(w, 3);
    check_played(w, middle, &more);

    int known = 0;
    for (int i = 0; dig_command_name(i); i++, known++) {
        bool there = false;
        for (int k = 0; k < l.count + more.count; k++) {
            const Log *of = k < l.count ? &l : &more;
            size_t at = of->start[k < l.count ? k : k - l.count];
            there |= dig_command_look(of->bytes + at, of->size - at, NULL) == i;
        }
        if (!there)
            fail_msg("command '%s' was not played: add it to this test", dig_command_name(i));
    }
    CHECK_INT(known, COMMAND_IDS - 1);      /* each has a row */
    dig_world_close(w);
    dig_snapshot_free(old);
    free(start.data);
    free(middle.data);
    free(l.bytes);
    free(more.bytes);
}

/* A snapshot may outlive its world, and somebody who listens. */
TEST(a_snapshot_may_be_freed_last)
{
    Log l = {.size = 0};
    dig_snapshot *s;
    dig_world *w = open_small_scene();
    Bytes start = listen(w, &l);
    fail_unless(w, dig_world_snapshot(w, &s), "snapshot");
    dig_world_close(w);
    int count = l.count;
    dig_snapshot_free(s);
    CHECK_INT(l.count, count);
    free(start.data);
    free(l.bytes);
}

TEST(one_listens_at_a_time)
{
    Log l = {.size = 0};
    dig_world *w = open_small_scene();
    Bytes start = listen(w, &l);
    CHECK_INT(dig_world_tap(w, keep, &l), DIG_E_BUSY);
    fail_unless(w, dig_world_tap(w, NULL, NULL), "tap");
    step(w, 1);
    CHECK_INT(l.count, 0);
    fail_unless(w, dig_world_tap(w, keep, &l), "tap");
    step(w, 1);
    CHECK_INT(l.count, 1);
    dig_world_close(w);
    free(start.data);
    free(l.bytes);
}

/* ---- what is refused ---- */

TEST(what_is_refused_is_logged_only_where_it_leaves_traces)
{
    Log l = {.size = 0};
    dig_world *w = open_scene();
    Bytes start = listen(w, &l);
    dig_body stone = dig_body_find(w, "stone"), dead = {1, 2};
    dig_joint joints[8];
    CHECK(dig_joints(w, joints, 8) > 0);
    const vec3 bad = {NAN, 0, 0}, far = {1e300, 0, 0};
    dig_material_def m;
    fail_unless(w, dig_material_get(w, "oak", &m), "oak");
    m.density = -1;
    const dig_pair_def pair = {.a = {"oak"}, .b = {"unobtainium"}};
    dig_region_def region = dig_region_defaults();
    dig_region r;
    const real options[64] = {NAN};
    const dig_effect_def effect = {.name = "gravity", .step = spin};
    CHECK(dig_world_set_gravity(w, bad) != DIG_OK);
    CHECK(dig_world_set_accuracy(w, "exact", 0) != DIG_OK);
    CHECK(dig_body_remove(w, dead) != DIG_OK);
    CHECK(dig_body_push(w, stone, bad, bad, true, 1) != DIG_OK);
    CHECK(dig_body_twist(w, dead, bad, 1) != DIG_OK);
    CHECK(dig_body_hit(w, stone, far, bad, false) != DIG_OK);
    CHECK(dig_body_hit(w, stone, far, bad, true) != DIG_OK);
    CHECK(dig_body_warm(w, stone, 1, NAN) != DIG_OK);
    CHECK(dig_body_teleport(w, stone, &far, NULL, NULL, NULL) != DIG_OK);
    CHECK(dig_body_move_to(w, stone, far, NULL, 1) != DIG_OK);
    CHECK(dig_body_set_velocity(w, stone, far, far) != DIG_OK);
    CHECK(dig_body_wake(w, dead) != DIG_OK);
    CHECK(dig_joint_remove(w, (dig_joint){1, 2}) != DIG_OK);
    CHECK(dig_joint_set(w, joints[0], &(dig_setting){"limits", (const real[2]){3, -3}}, 1) != DIG_OK);
    CHECK(dig_joint_set(w, joints[0], &(dig_setting){"no such thing", &far}, 1) != DIG_OK);
    CHECK(dig_region_create(w, &region, &r) != DIG_OK);
    CHECK(dig_region_remove(w, (dig_region){1, 2}) != DIG_OK);
    CHECK(dig_region_push(w, (dig_region){1, 2}, stone, bad) != DIG_OK);
    CHECK(dig_material_add(w, "oak", &m) != DIG_OK);
    CHECK(dig_material_pair(w, &pair) != DIG_OK);
    CHECK(dig_effect_join(w, "heat", dead, options, NULL) != DIG_OK);
    CHECK(dig_effect_leave(w, "warmth", stone) != DIG_OK);
    CHECK(dig_effect_option(w, "heat", options, NULL) != DIG_OK);
    CHECK(dig_effect_set(w, "warmth", true) != DIG_OK);
    CHECK(dig_effect_explain(w, "warmth", "why") != DIG_OK);
    CHECK(dig_effect_add(w, &effect) != DIG_OK);
    CHECK(dig_effect_drop(w, "gravity") != DIG_OK);
    CHECK(dig_dig_accuracy(w, dig_of(w, stone), "exact", 0) != DIG_OK);
    CHECK(dig_wire_set(w, (dig_wire){1, 2, 3}, 1, 1) != DIG_OK);
    CHECK(dig_wire_remove(w, (dig_wire){1, 2, 3}) != DIG_OK);
    CHECK_INT(l.count, 0);
    dig_world *copy = unpacked(start);
    check_same(w, copy, "refused");

    dig_body_def heavy = dig_body_defaults();
    const dig_sphere_def sphere = {1e9};
    dig_shape_def shape = shape_of("sphere", &sphere, vec3_zero());
    heavy.shapes = &shape;
    heavy.shape_count = 1;
    dig_body out;
    CHECK(dig_body_create(w, &heavy, &out) != DIG_OK);
    CHECK_INT(l.count, 1);
    step(w, 5);
    check_played(w, start, &l);
    dig_world_close(w);
    dig_world_close(copy);
    free(start.data);
    free(l.bytes);
}

/* ---- bytes that somebody changed ---- */

static void mutate(unsigned char *bytes, size_t size, uint64_t *seed)
{
    for (int i = 1 + (int)(draw_bits(seed) % 3); i > 0; i--) {
        size_t at = draw_bits(seed) % size;
        switch (draw_bits(seed) % 4) {
        case 0: bytes[at] ^= (unsigned char)(1u << draw_bits(seed) % 8); break;
        case 1: bytes[at] = (unsigned char)draw_bits(seed); break;
        case 2: memset(bytes + at, 0xff, size - at < 8 ? size - at : 8); break;
        default: memset(bytes + at, 0, size - at < 4 ? size - at : 4); break;
        }
    }
}

/* Plays until something is refused; each refusal has a sentence, and the world is sound afterwards. */
static void play_hostile(Bytes start, const unsigned char *bytes, size_t size)
{
    dig_world *w = unpacked(start);
    for (size_t at = 0, length; at < size; at += length) {
        dig_status s = dig_command_play(w, bytes + at, size - at, &length);
        if (s != DIG_OK && dig_error(w)[0] == '\0')
            fail_msg("%s, without a sentence", dig_status_name(s));
        if (s != DIG_OK)
            break;
    }
    if (dig_world_check(w) != DIG_OK)
        fail_msg("unsound: %s", dig_error(w));
    dig_world_close(w);
}

TEST(changed_bytes_are_refused_or_played)
{
    Spin s[2] = {{.strength = 0.3}, {.strength = 0.1}};
    Log l = {.size = 0};
    dig_world *w = open_small_scene();
    dig_snapshot *old, *snapshot;
    fail_unless(w, dig_world_snapshot(w, &old), "snapshot");
    Bytes start = listen(w, &l);
    add_bucket(w, (vec3){0, 2, 0});
    add_hills(w, (vec3){6, 0.1, 5});
    add_joints(w, (vec3){-4, 0.1, 0});
    add_acts(w, (vec3){8, 0, 0});
    add_materials(w);
    dig_body stone = dig_body_find(w, "stone"), bucket = dig_body_find(w, "bucket");
    use_effects(w, stone);
    use_joints(w, bucket);
    use_regions_and_wires(w, stone, bucket);
    use_own_effects(w, s, stone, bucket);
    fail_unless(w, dig_world_snapshot(w, &snapshot), "snapshot");
    step(w, 1);
    fail_unless(w, dig_world_restore(w, snapshot), "restore");
    dig_snapshot_free(snapshot);
    fail_unless(w, dig_world_restore(w, old), "restore");
    check_played(w, start, &l);

    uint64_t seed = 20261122;
    unsigned char *bytes = malloc(l.size);
    for (int i = 0; bytes && i < (SANITIZED ? 500 : 5000); i++) {
        /* Most of a world's log is built before the first step: each round changes one command and plays up to a few after it. */
        int k = (int)(draw_bits(&seed) % (uint64_t)l.count), last = k + 3 < l.count ? k + 3 : l.count - 1;
        size_t from = l.start[k], to = k + 1 < l.count ? l.start[k + 1] : l.size, end = last + 1 < l.count ? l.start[last + 1] : l.size;
        memcpy(bytes, l.bytes, l.size);
        mutate(bytes + from, to - from, &seed);
        play_hostile(start, bytes, i % 3 ? end : end - draw_bits(&seed) % (end - from));
    }
    dig_world_close(w);
    dig_snapshot_free(old);
    free(bytes);
    free(start.data);
    free(l.bytes);
}

TEST(rubbish_is_no_command)
{
    dig_world *w = open_small_scene();
    const unsigned char rubbish[8] = {200, 0, 0, 0, 0, 0, 1, 2}, cut[6] = {1, 0, 9, 0, 0, 0}, step_and_more[8] = {1, 0, 2, 0, 0, 0, 7, 7};
    size_t length = 1;
    uint64_t before = dig_world_checksum(w);
    CHECK_INT(dig_command_play(w, rubbish, 8, &length), DIG_E_FORMAT);
    CHECK_INT(length, 0);
    CHECK_INT(dig_command_play(w, rubbish, 3, NULL), DIG_E_FORMAT);
    CHECK_INT(dig_command_play(w, cut, 6, NULL), DIG_E_FORMAT);
    CHECK_INT(dig_command_look(cut, 6, NULL), -1);
    CHECK(dig_world_checksum(w) == before);
    CHECK_INT(dig_command_play(w, step_and_more, 8, NULL), DIG_E_KIND);
    CHECK_TEXT(dig_error(w), "command 'step': 2 bytes are left over");
    const unsigned char refused[6] = {1, DIG_E_ARG, 0, 0, 0, 0};
    CHECK_INT(dig_command_play(w, refused, 6, NULL), DIG_E_KIND);
    CHECK(strstr(dig_error(w), "when it was logged") != NULL);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(every_command_is_played_again), unit_test(a_snapshot_may_be_freed_last), unit_test(one_listens_at_a_time),
              unit_test(what_is_refused_is_logged_only_where_it_leaves_traces), unit_test(changed_bytes_are_refused_or_played),
              unit_test(rubbish_is_no_command));
}
