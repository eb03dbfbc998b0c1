/* tests/unit/test_save.c - a saved world goes on as if nothing had happened; a file that is damaged, or made to do damage, is
 * refused or gives a sound world. */
#include "save_fixture.h"
#include "draw_fixture.h"

#include "base/pack.h"
#include "base/rng.h"
#include "geom/save.h"
#include "world/world.h"

#include <sys/stat.h>

/* ---- round trips ---- */

static void same_bytes(Bytes a, Bytes b, const char *what)
{
    size_t at = 0, end = a.size < b.size ? a.size : b.size;
    while (at < end && a.data[at] == b.data[at])
        at++;
    if (a.size != b.size || at < end)
        fail_msg("%s: files of %zu and %zu bytes differ at byte %zu", what, a.size, b.size, at);
}

static dig_world *reloaded(dig_world *w, const char *name)
{
    char path[512];
    save_to(w, scratch_path(path, sizeof path, name));
    dig_world *copy = load_from(path);
    remove(path);
    return copy;
}

TEST(saved_loaded_saved_is_the_same_file)
{
    dig_world *w = open_scene();
    for (int round = 0; round < 4; round++) {
        Bytes first = bytes_of(w, "first.dig");
        dig_world *copy = reloaded(w, "again.dig");
        check_world(copy);
        Bytes second = bytes_of(copy, "second.dig");
        same_bytes(first, second, "saved again");
        free(first.data);
        free(second.data);
        dig_world_close(copy);
        step(w, 30);
    }
    dig_world_close(w);
}

#define EDGE 12                 /* balls along an edge of a cube: about 15,000 pairs as they land */

/* Balls that are made in no order, and fall into a pit of four slopes: where the pairs of a solid have come apart they are put together, by
 * the state alone. */
static uint64_t poured(int threads, bool saved)
{
    dig_world_def def = dig_world_defaults();
    uint64_t rng = 9;
    static int place[EDGE * EDGE * EDGE];
    int n = EDGE * EDGE * EDGE, astray = 0;
    def.step = 1.0 / 60;
    def.threads = threads;
    dig_world *w = open_with(def);
    for (int i = 0; i < 4; i++)
        add_slope(w, look(0.5, 0), vec3_unit((vec3){i == 0 ? 1 : i == 1 ? -1 : 0, 1, i == 2 ? 1 : i == 3 ? -1 : 0}));
    for (int i = 0; i < n; i++) {
        int k = (int)(rng_real(&rng) * (i + 1));
        place[i] = place[k];
        place[k] = i;
    }
    for (int i = 0; i < n; i++) {
        vec3 at = {place[i] % EDGE, place[i] / EDGE % EDGE, place[i] / EDGE / EDGE};
        add_ball(w, look(0.5, 0), 0.25, 60, vec3_mad((vec3){-2.9, 4, -2.9}, 0.51, at), vec3_zero());
    }
    step(w, saved ? 12 : 33);               /* the last of these begins by putting them in order */
    if (saved) {
        dig_world *copy = reloaded(w, "poured.dig");
        dig_world_close(w);
        w = copy;
        step(w, 21);
    }
    check_world(w);
    for (int i = 1; i < w->pairs.count; i++)
        astray += w->pairs.data[i].solid_b < w->pairs.data[i - 1].solid_b;
    CHECK(w->pairs.count > 4096 && astray < w->pairs.count / 8);       /* by chance it would be half of them */
    uint64_t sum = dig_world_checksum(w);
    dig_world_close(w);
    return sum;
}

TEST(pairs_are_put_in_the_order_of_bodies_by_the_state_alone)
{
    uint64_t alone = poured(1, false);
    CHECK(poured(2, false) == alone);
    CHECK(poured(3, true) == alone);
}

TEST(an_empty_world_is_saved_too)
{
    dig_world *w = open_with(dig_world_defaults());
    dig_world *copy = reloaded(w, "empty.dig");
    CHECK_INT(dig_world_stats(copy).bodies, 0);
    CHECK(dig_world_checksum(copy) == dig_world_checksum(w));
    add_ball(copy, look(0.5, 0), 0.1, 1, vec3_zero(), vec3_zero());
    step(copy, 3);
    dig_world_close(copy);
    dig_world_close(w);
}

/* Nothing in a file depends on where a world lies in memory or on the clock. */
/* What is worked out of a body's shapes lies within the bounds that a file is read with. */
TEST(the_largest_body_is_saved_too)
{
    dig_world *w = open_with(dig_world_defaults());
    dig_body b = add_ball(w, look(0.5, 0), 1e5, 1e3, vec3_zero(), vec3_zero());
    fail_unless(w, dig_body_set(w, b, "temperature", &(real){300}), "temperature");
    dig_world *copy = reloaded(w, "large.dig");
    CHECK(dig_world_checksum(copy) == dig_world_checksum(w));
    dig_world_close(copy);
    dig_world_close(w);
}

TEST(equal_worlds_give_equal_files)
{
    dig_world *a = open_scene(), *b = open_scene();
    step(a, 20);
    step(b, 20);
    Bytes x = bytes_of(a, "a.dig"), y = bytes_of(b, "b.dig");
    same_bytes(x, y, "two worlds with the same history");
    free(x.data);
    free(y.data);
    dig_world_close(a);
    dig_world_close(b);
}

static void same_future(dig_world *a, dig_world *b, int steps)
{
    for (int i = 0; i < steps; i++) {
        if (dig_world_checksum(a) != dig_world_checksum(b))
            fail_msg("checksums differ after %d steps", i);
        step(a, 1);
        step(b, 1);
        if (dig_world_energy(a).total != dig_world_energy(b).total)
            fail_msg("energies differ after %d steps", i + 1);
    }
    CHECK(dig_world_checksum(a) == dig_world_checksum(b));
}

static int asleep(const dig_world *w)
{
    dig_stats s = dig_world_stats(w);
    int dynamic = 0;
    for (int i = 0; i < w->bodies.count; i++)
        dynamic += w->bodies.data[i].alive && w->bodies.data[i].kind == DIG_DYNAMIC;
    return dynamic - s.awake;
}

TEST(a_loaded_world_has_the_same_future)
{
    dig_world *w = open_scene();
    step(w, 7);                     /* things fall, bounce, are pushed */
    dig_world *copy = reloaded(w, "early.dig");
    same_future(w, copy, 500);
    check_world(copy);
    dig_world_close(copy);

    CHECK(asleep(w) >= 4);          /* the stack at least */
    copy = reloaded(w, "late.dig");
    CHECK_INT(asleep(copy), asleep(w));
    dig_body top = dig_body_find(w, "stone"), same = dig_body_find(copy, "stone");
    fail_unless(w, dig_body_hit(w, top, (vec3){1, 6, 0}, vec3_zero(), false), "hit");
    fail_unless(copy, dig_body_hit(copy, same, (vec3){1, 6, 0}, vec3_zero(), false), "hit");
    same_future(w, copy, 500);
    check_world(copy);
    dig_world_close(copy);
    dig_world_close(w);
}

/* New bodies and joints take the same slots and DIG numbers in both. */
TEST(what_is_made_after_loading_gets_the_same_numbers)
{
    dig_world *w = open_scene();
    step(w, 40);
    dig_world *copy = reloaded(w, "numbers.dig"), *both[2] = {w, copy};
    for (int i = 0; i < 5; i++) {
        dig_body b[2];
        for (int k = 0; k < 2; k++) {
            b[k] = add_box(both[k], look(0.5, 0.1), (vec3){0.2, 0.2, 0.2}, 1, (vec3){-8 + i, 2, -8}, quat_identity());
            join(both[k], "ball", b[k], (dig_body){0, 0}, (vec3){-8 + i, 2.5, -8}, (vec3){0, 1, 0}, NULL);
            if (i == 2)
                fail_unless(both[k], dig_body_remove(both[k], dig_body_find(both[k], "cone")), "remove");
        }
        CHECK_INT(b[0].slot, b[1].slot);
        CHECK_INT(dig_of(w, b[0]).id, dig_of(copy, b[1]).id);
        same_future(w, copy, 10);
    }
    dig_world_close(copy);
    dig_world_close(w);
}

/* What was read is grown and closed as what was made here: in blocks that are large, too. */
TEST(a_large_world_grows_after_loading)
{
    dig_world *w = open_with(dig_world_defaults());
    for (int i = 0; i < 2500; i++)
        add_ball(w, look(0.5, 0), 0.1, 1, (vec3){i % 50, i / 50, 0}, vec3_zero());
    dig_world *copy = reloaded(w, "many.dig");
    for (int i = 0; i < 2500; i++) {
        vec3 at = {i % 50, i / 50, 9};
        CHECK_INT(add_ball(copy, look(0.5, 0), 0.1, 1, at, vec3_zero()).slot, add_ball(w, look(0.5, 0), 0.1, 1, at, vec3_zero()).slot);
    }
    same_future(w, copy, 2);
    dig_world_close(copy);
    dig_world_close(w);
}

/* A gear keeps handles of its joints among its parameters. */
TEST(a_gear_goes_on_turning)
{
    dig_world *w = open_world(1.0 / 60, NULL, false);
    dig_body a = add_box(w, look(0.5, 0), (vec3){0.4, 0.1, 0.4}, 1, (vec3){0, 0, 0}, quat_identity());
    dig_body b = add_box(w, look(0.5, 0), (vec3){0.4, 0.1, 0.4}, 1, (vec3){2, 0, 0}, quat_identity());
    dig_body none = {0, 0};
    struct { dig_joint a, b; real ratio[2]; } gear = {
        join(w, "hinge", a, none, (vec3){0, 0, 0}, (vec3){0, 1, 0}, NULL),
        join(w, "hinge", b, none, (vec3){2, 0, 0}, (vec3){0, 1, 0}, NULL), {1, -2}};
    join(w, "gear", none, none, (vec3){NAN, NAN, NAN}, (vec3){NAN, NAN, NAN}, &gear);
    fail_unless(w, dig_body_twist(w, a, (vec3){0, 0.3, 0}, 2), "twist");
    step(w, 10);
    dig_world *copy = reloaded(w, "gear.dig");
    for (int i = 0; i < 200; i++) {
        step(w, 1);
        step(copy, 1);
        for (int k = 0; k < w->bodies.count; k++) {
            const Body *x = &w->bodies.data[k], *y = &copy->bodies.data[k];
            CHECK(memcmp(&x->q, &y->q, sizeof x->q) == 0 && memcmp(&x->w, &y->w, sizeof x->w) == 0);
        }
    }
    CHECK_NEAR(w->bodies.data[0].w.y, -2 * w->bodies.data[1].w.y, 1e-6);
    CHECK(fabs(w->bodies.data[0].w.y) > 0.1);
    dig_world_close(copy);
    dig_world_close(w);
}

/* ---- what is in it ---- */

TEST(shapes_come_back_bit_for_bit)
{
    dig_world *w = open_scene(), *copy = reloaded(w, "shapes.dig");
    int seen = 0;
    for (int i = 0; i < w->solids.count; i++) {
        const Solid *a = &w->solids.data[i], *b = &copy->solids.data[i];
        CHECK_INT(a->alive, b->alive);
        if (!a->alive)
            continue;
        CHECK(a->form->shape.type == b->form->shape.type);
        CHECK_INT(shape_bytes(&a->form->shape), shape_bytes(&b->form->shape));
        if (memcmp(a->form->shape.data, b->form->shape.data, shape_bytes(&a->form->shape)) != 0)
            fail_msg("the data of a %s differ", a->form->shape.type->name);
        CHECK(a->form->shape.inner == b->form->shape.inner && a->form->shape.outer == b->form->shape.outer);
        CHECK(a->form->shape.round == b->form->shape.round && a->form->shape.rolling == b->form->shape.rolling);
        CHECK(memcmp(&a->form->arm, &b->form->arm, sizeof a->form->arm) == 0);
        for (int t = 0; shape_types[t]; t++)
            seen |= shape_types[t] == a->form->shape.type ? 1 << t : 0;
    }
    int types = 0;
    while (shape_types[types])
        types++;
    CHECK_INT(seen, (1 << types) - 1);
    dig_world_close(copy);
    dig_world_close(w);
}

TEST(what_follows_from_the_file_is_what_it_was)
{
    dig_world *w = open_scene();
    step(w, 100);
    dig_world *copy = reloaded(w, "derived.dig");
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *a = &w->bodies.data[i], *b = &copy->bodies.data[i];
        CHECK_INT(a->alive, b->alive);
        if (!a->alive)
            continue;
        CHECK(a->outer == b->outer && a->inv_mass == b->inv_mass);
        CHECK(memcmp(&body_inertia(a)->inverse, &body_inertia(b)->inverse, sizeof(mat3)) == 0);
        CHECK_INT(a->shape_count, b->shape_count);
        CHECK_INT(a->listed, b->listed);
        CHECK_TEXT(body_name(copy, b), body_name(w, a));
    }
    for (int i = 0; i < w->tree.capacity && i < copy->tree.capacity; i++) {
        const TreeNode *a = &w->tree.nodes[i], *b = &copy->tree.nodes[i];
        CHECK_INT(a->height, b->height);
        CHECK(a->height < 0 || (memcmp(&a->box, &b->box, sizeof a->box) == 0 && a->parent == b->parent));
    }
    dig_world_close(copy);
    dig_world_close(w);
}

TEST(settings_events_and_messages_come_back)
{
    dig_world *w = open_scene();
    fail_unless(w, dig_world_set_gravity(w, (vec3){0.5, -3e6, 0}), "gravity");      /* more than a new world may have */
    fail_unless(w, dig_world_set_gravity(w, (vec3){0.5, -8, 0}), "gravity");
    fail_unless(w, dig_world_set_accuracy(w, "sketch", NAN), "accuracy");
    step(w, 25);
    dig_world *copy = reloaded(w, "settings.dig");
    CHECK_TEXT(dig_world_accuracy(copy), "sketch");
    CHECK_NEAR(dig_world_gravity(copy).y, -8, 0);
    CHECK_INT(dig_world_steps(copy), dig_world_steps(w));
    CHECK_INT(dig_world_stats(copy).events, dig_world_stats(w).events);
    dig_message a[64], b[64];
    int n = dig_messages(w, a, 64);
    CHECK(n > 0);
    CHECK_INT(dig_messages(copy, b, 64), n);
    for (int i = 0; i < n && i < 64; i++) {
        CHECK_INT(a[i].id, b[i].id);
        CHECK_TEXT(b[i].kind, a[i].kind);
        CHECK(!a[i].to.gen || dig_body_alive(copy, b[i].to) == dig_body_alive(w, a[i].to));
    }
    const dig_event *x, *y;
    n = dig_events(w, &x);
    CHECK_INT(dig_events(copy, &y), n);
    for (int i = 0; i < n; i++)
        CHECK(x[i].kind == y[i].kind && x[i].time == y[i].time && x[i].a.slot == y[i].a.slot);
    dig_material_def oak;
    CHECK_INT(dig_material_get(copy, "waxed oak", &oak), DIG_OK);
    CHECK_NEAR(oak.friction, 0.33, 0);
    dig_world_close(copy);
    dig_world_close(w);
}

/* A ball that switches is saved before its first step (Euler), in flight (Verlet) and after a bounce (Euler again). */
TEST(how_a_body_is_integrated_comes_back)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0, 1));
    dig_body_def d = body_with(look(0, 1), (vec3){0, 1.1, 0}, quat_identity());
    d.integrator = DIG_SWITCH;
    dig_body b = add_body(w, d, "sphere", &(dig_sphere_def){0.1});
    snprintf(d.name.s, sizeof d.name.s, "euler");
    d.integrator = DIG_EULER;
    d.at.x = 1;
    add_body(w, d, "sphere", &(dig_sphere_def){0.1});
    const int until[] = {0, 10, 28};            /* it strikes at sqrt(2 / g) = 0.4515 s, in step 28 */
    for (int i = 0; i < 3; i++) {
        step(w, until[i] - (int)dig_world_steps(w));
        dig_body_debug flags;
        CHECK_INT(dig_body_inspect(w, b, &flags), DIG_OK);
        CHECK_INT(flags.euler, i != 1);
        dig_world *copy = reloaded(w, "integrator.dig");
        int64_t integrator = DIG_AUTO;
        CHECK_INT(dig_body_param(copy, dig_body_find(copy, "euler"), "integrator", &integrator), DIG_OK);
        CHECK_INT(integrator, DIG_EULER);
        same_future(w, copy, 3);
        dig_world_close(copy);
    }
    dig_world_close(w);
}

/* A crowd keeps contacts for as long as bodies hardly move; how long, the file must know. */
TEST(a_heap_that_settles_has_the_same_future)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    Look rough = {0.5, NAN, 0, 0};
    add_floor(w, rough);
    for (int i = 0; i < 75; i++) {
        quat turned = quat_exp((vec3){0.3 * i, 0.2 * i, 0.1 * i});
        add_box(w, rough, (vec3){0.3, 0.4, 0.5}, 60, (vec3){0.55 * (i % 5), 0.4 + 0.6 * (i / 25), 0.55 * (i / 5 % 5)}, turned);
    }
    step(w, 60);
    for (int i = 0; i < 3; i++) {
        dig_world *copy = reloaded(w, "heap.dig");
        same_future(w, copy, 30);
        dig_world_close(copy);
    }
    dig_world_close(w);
}

TEST(handles_of_the_saved_world_are_dead_in_the_loaded_one)
{
    dig_world *w = open_scene(), *copy = reloaded(w, "handles.dig");
    dig_body b = dig_body_find(w, "bucket");
    CHECK(dig_body_alive(w, b));
    CHECK(!dig_body_alive(copy, b));
    CHECK(dig_body_alive(copy, dig_body_find(copy, "bucket")));
    dig_world_close(copy);
    dig_world_close(w);
}

/* A field that is added to a record must be added to engine/api/save_*.c too, or made anew there; then change the number here. */
TEST(every_field_of_the_records_is_known_to_the_file)
{
    CHECK_INT(sizeof(Body), 480);      /* watch, pull, alone, kept, roam and lies are not saved: they begin anew */
    CHECK_INT(sizeof(Drift), 48);
    CHECK_INT(sizeof(Make), 88);        /* users are who have it */
    CHECK_INT(sizeof(BodyRest), 280);   /* breach begins anew */
    CHECK_INT(sizeof(Solid), 104);      /* asks, reach, blow and astray are made anew in each step */
    CHECK_INT(sizeof(Form), 208);       /* arm is made anew; users are who have it */
    CHECK_INT(sizeof(Pair), 56);        /* met and met_until begin anew */
    CHECK_INT(sizeof(PairMemory), 72);
    CHECK_INT(sizeof(Contact), 192);
    CHECK_INT(sizeof(ContactRest), 32);   /* lost is not saved: of the last step */
    CHECK_INT(sizeof(Touch), 48);
    CHECK_INT(sizeof(JointRec), 808);     /* lost is not saved: of the last step */
    CHECK_INT(sizeof(Push), 104);
    CHECK_INT(sizeof(Region), 416);     /* laws.shape is empty: the shape itself is saved */
    CHECK_INT(sizeof(Ledger), 48);
    CHECK_INT(sizeof(dig_event), 152);
    CHECK_INT(sizeof(dig_message), 128);
    CHECK_INT(sizeof(Post), 160);
    CHECK_INT(sizeof(LayerLink), 48);
    CHECK_INT(sizeof(TreeNode), 64);
    CHECK_INT(sizeof(GraphLink), 40);
}

/* ---- files that cannot be written or read ---- */

static dig_status try_load(const char *path, char *why, size_t capacity)
{
    dig_world *w;
    dig_status s = dig_world_load(path, &w, why, capacity);
    CHECK((s == DIG_OK) == (w != NULL));
    dig_world_close(w);
    return s;
}

TEST(what_cannot_be_written_or_read_is_named)
{
    char why[512], path[512], inside[600];
    dig_world *w = open_small_scene();
    uint64_t before = dig_world_checksum(w);
    scratch_path(path, sizeof path, "nowhere");
    snprintf(inside, sizeof inside, "%s/x.dig", path);
    CHECK_INT(dig_world_save(w, inside), DIG_E_FILE);
    CHECK(strstr(dig_error(w), inside) && strstr(dig_error(w), "No such file"));
    CHECK_INT(dig_world_save(w, ""), DIG_E_ARG);
    CHECK_INT(try_load(inside, why, sizeof why), DIG_E_FILE);
    CHECK(strstr(why, inside) && strstr(why, "No such file"));
    CHECK_INT(try_load("", why, sizeof why), DIG_E_ARG);
    CHECK_INT(try_load(P_tmpdir, why, sizeof why), DIG_E_FILE);
    CHECK(dig_world_checksum(w) == before);
    dig_world_close(w);
}

/* The new file takes the place of the old one and leaves nothing beside it. */
TEST(saving_replaces_the_file_whole)
{
    char path[512], folder[512];
    dig_world *w = open_small_scene();
    scratch_path(folder, sizeof folder, "folder");
    CHECK_INT(mkdir(folder, 0700), 0);
    snprintf(path, sizeof path, "%.480s/x.dig", folder);
    write_bytes(path, (const unsigned char *)"old", 3);
    save_to(w, path);
    dig_world_close(load_from(path));
    CHECK_INT(remove(path), 0);
    CHECK_INT(rmdir(folder), 0);        /* empty again */
    dig_world_close(w);
}

/* ---- damaged files ---- */

enum { FORMAT_AT = 8, SIZE_AT = 16, TABLE_AT = 44, ENTRY = 24, COUNT_AT = 40 };

static uint32_t u32_at(const unsigned char *p) { return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24; }
static void put_u32(unsigned char *p, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(x >> 8 * i);
}

/* As one who wants to do damage would: all checksums are right. */
static void mend_checksums(Bytes b)
{
    uint32_t count = u32_at(b.data + COUNT_AT), header = u32_at(b.data + 12);
    for (uint32_t i = 0; i < count; i++) {
        unsigned char *e = b.data + TABLE_AT + i * ENTRY;
        uint32_t offset = u32_at(e + 8), size = u32_at(e + 16);
        if (offset <= b.size && size <= b.size - offset)
            put_u32(e + 4, pack_crc32(b.data + offset, size));
    }
    put_u32(b.data + header - 4, pack_crc32(b.data, header - 4));
}

static dig_status load_bytes(const char *path, const unsigned char *data, size_t size, char *why, size_t capacity)
{
    write_bytes(path, data, size);
    return try_load(path, why, capacity);
}

/* A world, the bytes of its file, and a file for what is made of them. */
typedef struct Victim {
    dig_world *w;
    Bytes      b;
    size_t     header;          /* bytes */
    char       path[512], why[600];
} Victim;

static Victim *open_victim(void)
{
    Victim *v = calloc(1, sizeof *v);
    if (!v)
        fail_msg("not enough memory");
    v->w = open_small_scene();
    v->b = bytes_of(v->w, "victim.dig");
    v->header = u32_at(v->b.data + 12);
    scratch_path(v->path, sizeof v->path, "damaged.dig");
    return v;
}

static void close_victim(Victim *v)
{
    remove(v->path);
    free(v->b.data);
    dig_world_close(v->w);
    free(v);
}

/* Loads the bytes as they are now. */
static dig_status load_victim(Victim *v) { return load_bytes(v->path, v->b.data, v->b.size, v->why, sizeof v->why); }

TEST(a_file_cut_anywhere_says_so)
{
    char want[700];
    Victim *v = open_victim();
    CHECK_INT(load_victim(v), DIG_OK);
    for (size_t size = 0; size < v->b.size; size++) {
        if (load_bytes(v->path, v->b.data, size, v->why, sizeof v->why) != DIG_E_FORMAT)
            fail_msg("cut to %zu of %zu bytes: %s", size, v->b.size, v->why);
        if (size < 24)
            snprintf(want, sizeof want, "%s: file ends after %zu bytes, in its header", v->path, size);
        else
            snprintf(want, sizeof want, "%s: file ends after %zu of %zu bytes", v->path, size, v->b.size);
        CHECK_TEXT(v->why, want);
    }
    v->b.data[v->b.size] = 0;
    CHECK_INT(load_bytes(v->path, v->b.data, v->b.size + 1, v->why, sizeof v->why), DIG_E_FORMAT);
    close_victim(v);
}

TEST(every_flipped_bit_of_the_header_is_noticed)
{
    Victim *v = open_victim();
    for (size_t bit = 0; bit < 8 * v->header; bit++) {
        v->b.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        if (load_victim(v) != DIG_E_FORMAT)
            fail_msg("bit %zu of the header flipped: %s", bit, v->why);
        v->b.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    close_victim(v);
}

TEST(flipped_bits_elsewhere_are_noticed)
{
    Victim *v = open_victim();
    uint64_t random = 88172645463325252u;
    for (int i = 0; i < 2000; i++) {
        size_t bit = 8 * v->header + draw_bits(&random) % (8 * (v->b.size - v->header));
        v->b.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
        CHECK_INT(load_victim(v), DIG_E_FORMAT);
        CHECK(strstr(v->why, "damaged") != NULL);
        v->b.data[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    close_victim(v);
}

/* Bytes of the program around a world travel with it and are no part of what it is. */
TEST(a_note_goes_with_the_file)
{
    static const char note[] = "a bridge\0 of 3 bodies";
    dig_world *w = open_small_scene();
    uint64_t sum = dig_world_checksum(w);
    size_t size = 1;
    CHECK(dig_world_noted(w, &size) == NULL && size == 0);
    CHECK_INT(dig_world_note(w, note, sizeof note), DIG_OK);
    CHECK(dig_world_checksum(w) == sum);
    dig_world *copy = reloaded(w, "note.dig");
    const char *found = dig_world_noted(copy, &size);
    CHECK_INT(size, sizeof note);
    CHECK(found && memcmp(found, note, sizeof note) == 0);
    CHECK(dig_world_checksum(copy) == sum);
    CHECK_INT(dig_world_note(copy, note, (size_t)300 << 20), DIG_E_ARG);
    CHECK(strstr(dig_error(copy), "must have at most 268435456") != NULL);
    CHECK(dig_world_noted(copy, &size) && size == sizeof note);
    CHECK_INT(dig_world_note(copy, NULL, 0), DIG_OK);
    CHECK(dig_world_noted(copy, &size) == NULL && size == 0);
    dig_world_close(copy);
    dig_world_close(w);
}

TEST(other_formats_are_told_apart)
{
    char want[700];
    Victim *v = open_victim();
    put_u32(v->b.data + FORMAT_AT, 17);
    memset(v->b.data + 24, 0, 16);
    memcpy(v->b.data + 24, "0.9", 3);
    CHECK_INT(load_victim(v), DIG_E_FORMAT);
    snprintf(want, sizeof want, "%s: made by digbox 0.9 (format 17); this is %s (format 16)", v->path, DIGBOX_VERSION);
    CHECK_TEXT(v->why, want);
    CHECK_INT(load_bytes(v->path, (const unsigned char *)"-- a script\nreturn 1 + 1 -- of some length\n", 43, v->why, sizeof v->why), DIG_E_FORMAT);
    CHECK(strstr(v->why, "not a world") != NULL);
    close_victim(v);
}

/* Sections that lie outside, overlap or claim more than there is; all with right checksums. */
TEST(a_table_that_lies_is_refused)
{
    Victim *v = open_victim();
    uint32_t sections = u32_at(v->b.data + COUNT_AT);
    for (uint32_t i = 0; i < sections; i++)
        for (int field = 8; field < 24; field += 4) {       /* halves of offset and size */
            unsigned char *at = v->b.data + TABLE_AT + i * ENTRY + field;
            uint32_t was = u32_at(at);
            const uint32_t lies[] = {0, 1, was + 1, was - 1, was + 64, 0x7fffffff, 0xffffffff, (uint32_t)v->b.size};
            for (size_t k = 0; k < sizeof lies / sizeof *lies; k++) {
                if (lies[k] == was)
                    continue;
                put_u32(at, lies[k]);
                mend_checksums(v->b);
                if (load_victim(v) != DIG_E_FORMAT)
                    fail_msg("section %u, byte %d: %u instead of %u was accepted", i, field, lies[k], was);
            }
            put_u32(at, was);
        }
    mend_checksums(v->b);
    CHECK_INT(load_victim(v), DIG_OK);
    close_victim(v);
}

/* Every number of four bytes in the file in turn says that there are four thousand million of something: refused, or loaded
 * without taking more memory than the file is worth (a sanitizer build stops at such a request). */
TEST(counts_beyond_the_file_are_refused)
{
    Victim *v = open_victim();
    for (size_t at = v->header; at + 4 <= v->b.size; at++) {
        uint32_t was = u32_at(v->b.data + at);
        put_u32(v->b.data + at, at % 2 ? 0xffffffff : 0x7fffffff);
        mend_checksums(v->b);
        write_bytes(v->path, v->b.data, v->b.size);
        dig_world *copy;
        if (dig_world_load(v->path, &copy, v->why, sizeof v->why) == DIG_OK) {
            CHECK(dig_world_stats(copy).bytes < 4u << 20);
            check_world(copy);
        }
        dig_world_close(copy);
        put_u32(v->b.data + at, was);
    }
    close_victim(v);
}

/* ---- files made to do damage ---- */

static bool all_finite(const dig_world *w)
{
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (b->alive && !(vec3_finite(b->x) && vec3_finite(b->v) && vec3_finite(b->w) && quat_finite(b->q)))
            return false;
    }
    return true;
}

/* True: it was a world. */
static bool survive(const char *path, int mutant, int steps)
{
    char why[600];
    dig_world *w;
    if (dig_world_load(path, &w, why, sizeof why) != DIG_OK) {
        CHECK(!w && why[0]);
        return false;
    }
    if (dig_world_check(w) != DIG_OK)
        fail_msg("mutant %d was loaded: %s", mutant, dig_error(w));
    for (int i = 0; i < steps; i++)
        if (dig_world_step(w) != DIG_OK || !all_finite(w))
            fail_msg("mutant %d, step %d: %s", mutant, i, dig_error(w));
    if (dig_world_check(w) != DIG_OK)
        fail_msg("mutant %d after %d steps: %s", mutant, steps, dig_error(w));
    dig_world_close(w);
    return true;
}

/* DIG_MUTANTS and DIG_SEED ask for other ones. */
static int number_from(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text ? atoi(text) : otherwise;
}

static void mutate(dig_world *w, const char *name, int mutants, uint64_t random)
{
    char path[512];
    int worlds = 0;
    Bytes b = bytes_of(w, "seed.dig");
    unsigned char *copy = malloc(b.size);
    size_t header = u32_at(b.data + 12);
    scratch_path(path, sizeof path, name);        /* stays there when the test fails */
    for (int i = 0; i < mutants; i++) {
        memcpy(copy, b.data, b.size);
        int changes = 1 + (int)(draw_bits(&random) % 3);
        for (int k = 0; k < changes; k++) {
            size_t at = header + draw_bits(&random) % (b.size - header);
            uint64_t r = draw_bits(&random);
            if (r % 2)
                copy[at] ^= (unsigned char)(1 << r / 2 % 8);
            else
                copy[at] = (unsigned char)(r >> 8);
        }
        mend_checksums((Bytes){copy, b.size});
        write_bytes(path, copy, b.size);
        worlds += survive(path, i, 50);
    }
    printf("    %d of %d mutants of %zu bytes were worlds\n", worlds, mutants, b.size);
    CHECK(worlds > 0 && worlds < mutants);
    remove(path);
    free(copy);
    free(b.data);
    dig_world_close(w);
}

TEST(mutants_of_a_small_world_are_refused_or_sound)
{
    mutate(open_small_scene(), "small-mutant.dig", number_from("DIG_MUTANTS", SANITIZED ? 1000 : 1400), (uint64_t)number_from("DIG_SEED", 1) * 2654435761u);
}

TEST(mutants_of_a_world_with_everything_are_refused_or_sound)
{
    dig_world *w = open_scene();
    step(w, 60);
    mutate(w, "mutant.dig", number_from("DIG_MUTANTS", SANITIZED ? 100 : 600), (uint64_t)number_from("DIG_SEED", 2) * 2654435761u);
}

static const Form *form_of(const dig_world *w, dig_body b) { return w->solids.data[w->bodies.data[b.slot].shape_first].form; }

static const Make *make_of(const dig_world *w, dig_body b) { return w->bodies.data[b.slot].make; }

/* What alike bodies share: a change is one's own, and a snapshot has what it had. */
TEST(who_changes_a_shared_surface_has_his_own)
{
    dig_world *w = open_world(1.0 / 60, "study", true);
    const dig_sphere_def ball = {0.5}, larger = {0.6};
    dig_body a = add_body(w, dig_body_defaults(), "sphere", &ball), b = add_body(w, dig_body_defaults(), "sphere", &ball);
    dig_body c = add_body(w, dig_body_defaults(), "sphere", &larger);
    CHECK(form_of(w, a) == form_of(w, b) && form_of(w, a) != form_of(w, c));
    CHECK(make_of(w, a) == make_of(w, b) && make_of(w, a) == make_of(w, c));
    const real least = 0.125, most = 0.75;
    CHECK(dig_body_set(w, b, "friction", &least) == DIG_OK);
    CHECK(make_of(w, a) != make_of(w, b) && make_of(w, b)->surface.friction == least && isnan(make_of(w, a)->surface.friction));
    CHECK(form_of(w, a) != form_of(w, b) && form_of(w, b)->surface.friction == least && isnan(form_of(w, a)->surface.friction));
    dig_snapshot *s;
    CHECK(dig_world_snapshot(w, &s) == DIG_OK);
    CHECK(dig_body_set(w, b, "friction", &most) == DIG_OK && dig_body_set(w, a, "friction", &most) == DIG_OK);
    CHECK(form_of(w, a) == form_of(w, b) && form_of(w, a)->surface.friction == most);
    CHECK(dig_world_restore(w, s) == DIG_OK);
    CHECK(form_of(w, b)->surface.friction == least && isnan(form_of(w, a)->surface.friction));
    CHECK(make_of(w, b)->surface.friction == least && isnan(make_of(w, a)->surface.friction));
    dig_world *copy = reloaded(w, "forms.dig");
    CHECK(surface_same(&form_of(copy, b)->surface, &form_of(w, b)->surface));
    CHECK(form_of(copy, a) != form_of(copy, b) && form_of(copy, a)->shape.outer == 0.5);
    dig_snapshot_free(s);
    dig_world_close(copy);
    dig_world_close(w);
}

TEST(a_pair_of_a_shape_that_is_none_is_refused)
{
    char path[512], why[600];
    dig_world *w = open_with(dig_world_defaults());
    for (int i = 0; i < 3; i++)
        add_ball(w, look(0.5, 0), 0.1, 1, (vec3){0.19 * i * i, 0, 0}, vec3_zero());
    step(w, 1);
    CHECK(w->pairs.count == 1 && pair_remember(w, w->pairs.data) == DIG_OK);
    w->memories.data[w->pairs.data->memory].cache.kind = 1;
    w->pairs.data->solid_b = 2;         /* that of the last ball, which is no more */
    CHECK(dig_body_remove(w, body_handle(w, 2)) == DIG_OK);
    save_to(w, scratch_path(path, sizeof path, "lies.dig"));
    CHECK_INT(try_load(path, why, sizeof why), DIG_E_FORMAT);
    CHECK(remove(path) == 0);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(saved_loaded_saved_is_the_same_file), unit_test(an_empty_world_is_saved_too),
              unit_test(pairs_are_put_in_the_order_of_bodies_by_the_state_alone),
              unit_test(the_largest_body_is_saved_too), unit_test(equal_worlds_give_equal_files),
              unit_test(a_loaded_world_has_the_same_future), unit_test(a_heap_that_settles_has_the_same_future),
              unit_test(what_is_made_after_loading_gets_the_same_numbers),
        unit_test(a_large_world_grows_after_loading),
              unit_test(a_gear_goes_on_turning), unit_test(shapes_come_back_bit_for_bit), unit_test(what_follows_from_the_file_is_what_it_was),
              unit_test(settings_events_and_messages_come_back), unit_test(how_a_body_is_integrated_comes_back),
              unit_test(handles_of_the_saved_world_are_dead_in_the_loaded_one),
              unit_test(every_field_of_the_records_is_known_to_the_file), unit_test(what_cannot_be_written_or_read_is_named),
              unit_test(saving_replaces_the_file_whole), unit_test(a_file_cut_anywhere_says_so),
              unit_test(every_flipped_bit_of_the_header_is_noticed), unit_test(flipped_bits_elsewhere_are_noticed),
              unit_test(other_formats_are_told_apart), unit_test(a_note_goes_with_the_file),
              unit_test(a_table_that_lies_is_refused), unit_test(counts_beyond_the_file_are_refused),
              unit_test(mutants_of_a_small_world_are_refused_or_sound), unit_test(mutants_of_a_world_with_everything_are_refused_or_sound),
              unit_test(who_changes_a_shared_surface_has_his_own), unit_test(a_pair_of_a_shape_that_is_none_is_refused));
}
