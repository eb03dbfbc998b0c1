/* tests/unit/test_snapshot.c - a world put back to a snapshot does again what it did. */
#define _DEFAULT_SOURCE         /* sysconf */
#include "resident.h"
#include "save_fixture.h"

#include "world/world.h"

static dig_snapshot *snapshot_of(dig_world *w)
{
    dig_snapshot *s;
    fail_unless(w, dig_world_snapshot(w, &s), "snapshot");
    CHECK(s != NULL);
    return s;
}

static void restore(dig_world *w, const dig_snapshot *s)
{
    fail_unless(w, dig_world_restore(w, s), "restore");
    check_world(w);
}

enum { STEPS = 100 };
typedef struct Record { uint64_t sums[STEPS + 1]; real energy[STEPS + 1]; int awake[STEPS + 1]; int events[STEPS + 1]; } Record;

static void record(dig_world *w, Record *r)
{
    const dig_event *events;
    for (int i = 0; i <= STEPS; i++) {
        r->sums[i] = dig_world_checksum(w);
        r->energy[i] = dig_world_energy(w).total;
        r->awake[i] = dig_world_stats(w).awake;
        r->events[i] = dig_events(w, &events);
        if (i < STEPS)
            step(w, 1);
    }
}

static void same_again(dig_world *w, const Record *before)
{
    Record now;
    record(w, &now);
    for (int i = 0; i <= STEPS; i++)
        if (now.sums[i] != before->sums[i] || now.energy[i] != before->energy[i] || now.awake[i] != before->awake[i] ||
            now.events[i] != before->events[i])
            fail_msg("after %d steps: checksum %llx, was %llx; energy %.17g, was %.17g; %d awake, were %d; %d events, were %d", i,
                     (unsigned long long)now.sums[i], (unsigned long long)before->sums[i], now.energy[i], before->energy[i], now.awake[i],
                     before->awake[i], now.events[i], before->events[i]);
}

TEST(restored_it_runs_as_before)
{
    dig_world *w = open_scene();
    step(w, 10);
    Record r;
    dig_snapshot *s = snapshot_of(w);
    record(w, &r);
    for (int round = 0; round < 3; round++) {
        restore(w, s);
        same_again(w, &r);
    }
    dig_snapshot_free(s);
    dig_world_close(w);
}

/* The moment of falling asleep lies in the record: the time each body was still is part of the state. */
TEST(sleep_is_restored_while_and_before_it_comes)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    add_floor(w, look(0.5, 0));
    dig_body top = {0, 0};
    for (int i = 0; i < 5; i++)
        top = add_box(w, look(0.5, 0), (vec3){0.4, 0.4, 0.4}, 1, (vec3){0, 0.2 + 0.4 * i, 0}, quat_identity());
    step(w, 20);
    Record early, late;
    dig_snapshot *before = snapshot_of(w);
    record(w, &early);
    CHECK_INT(early.awake[0], 5);
    CHECK_INT(early.awake[STEPS], 0);
    dig_snapshot *after = snapshot_of(w);
    record(w, &late);
    CHECK_INT(late.awake[0], 0);

    fail_unless(w, dig_body_hit(w, top, (vec3){3, 1, 0}, vec3_zero(), false), "hit");
    step(w, 30);
    restore(w, before);
    same_again(w, &early);
    restore(w, after);
    same_again(w, &late);
    restore(w, before);
    same_again(w, &early);
    dig_snapshot_free(before);
    dig_snapshot_free(after);
    dig_world_close(w);
}

/* Two stacks that were pressed together: without its warm start the solver would begin from nothing and end elsewhere. */
TEST(warm_start_is_restored)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    add_floor(w, look(0.5, 0));
    for (int i = 0; i < 12; i++)
        add_box(w, look(0.4, 0), (vec3){0.3, 0.1, 0.3}, 1 + i, (vec3){0.01 * (i % 3), 0.05 + 0.1 * i, 0}, quat_identity());
    step(w, 8);
    dig_snapshot *s = snapshot_of(w);
    real held = 0, again = 0;
    for (int i = 0; i < w->contacts.count; i++)
        held += w->contacts.data[i].first.memory.normal;
    CHECK(held > 1);
    Record r;
    record(w, &r);
    restore(w, s);
    for (int i = 0; i < w->contacts.count; i++)
        again += w->contacts.data[i].first.memory.normal;
    CHECK_NEAR(again, held, 0);
    same_again(w, &r);
    dig_snapshot_free(s);
    dig_world_close(w);
}

/* What came goes, what went comes back, with the handles that were given for it. */
TEST(bodies_and_joints_made_or_removed_in_between_do_not_matter)
{
    dig_world *w = open_scene();
    step(w, 30);
    Record r;
    dig_snapshot *s = snapshot_of(w);
    record(w, &r);
    restore(w, s);

    dig_body old = dig_body_find(w, "bucket"), stone = dig_body_find(w, "stone");
    fail_unless(w, dig_body_remove(w, old), "remove");
    dig_body fresh[20];
    for (int i = 0; i < 20; i++)
        fresh[i] = add_box(w, look(0.5, 0.2), (vec3){0.2, 0.3, 0.2}, 1, (vec3){0.3 * i - 3, 0.5, 0.4}, quat_identity());
    dig_joint joint = join(w, "ball", fresh[0], fresh[1], (vec3){-2.8, 0.5, 0.4}, (vec3){0, 1, 0}, NULL);
    step(w, 15);
    fail_unless(w, dig_body_remove(w, stone), "remove");
    step(w, 15);
    CHECK(!dig_body_alive(w, old));

    restore(w, s);
    CHECK(dig_body_alive(w, old) && dig_body_alive(w, stone));
    CHECK(!dig_joint_alive(w, joint));
    for (int i = 0; i < 20; i++)
        CHECK(!dig_body_alive(w, fresh[i]));
    same_again(w, &r);

    dig_body next = add_ball(w, look(0.5, 0), 0.1, 1, (vec3){9, 3, 9}, vec3_zero());
    for (int i = 0; i < 20; i++)
        CHECK(next.gen != fresh[i].gen);
    restore(w, s);
    same_again(w, &r);
    dig_snapshot_free(s);
    dig_world_close(w);
}

TEST(settings_are_restored)
{
    dig_world *w = open_scene();
    step(w, 5);
    Bytes before = bytes_of(w, "before.dig");
    dig_snapshot *s = snapshot_of(w);
    dig_material_def m;
    fail_unless(w, dig_material_get(w, "oak", &m), "oak");
    m.friction = 0;
    fail_unless(w, dig_material_add(w, "oak", &m), "material");
    fail_unless(w, dig_material_add(w, "soap", &m), "material");
    fail_unless(w, dig_world_set_gravity(w, (vec3){1, 2, 3}), "gravity");
    fail_unless(w, dig_world_set_accuracy(w, "reference", NAN), "accuracy");
    fail_unless(w, dig_room_open(w, "+x", true), "room");
    fail_unless(w, dig_effect_set(w, "gravity", false), "effect");
    step(w, 10);
    restore(w, s);
    Bytes after = bytes_of(w, "after.dig");
    CHECK_INT(after.size, before.size);
    for (size_t i = 0; i < before.size; i++)
        if (before.data[i] != after.data[i])
            fail_msg("files of before and after differ at byte %zu", i);
    free(before.data);
    free(after.data);
    dig_snapshot_free(s);
    dig_world_close(w);
}

/* Regions keep shapes and free slots like bodies do. */
TEST(regions_are_restored)
{
    dig_world *w = open_world(1.0 / 60, NULL, true);
    const dig_sphere_def ball = {2};
    dig_region_def d = dig_region_defaults();
    d.shape = shape_of("sphere", &ball, vec3_zero());
    d.drag = 3;
    dig_region r[40];
    add_ball(w, look(0.5, 0), 0.1, 1, vec3_zero(), (vec3){1, 0, 0});
    for (int i = 0; i < 40; i++) {
        d.at = (pose){{0.01 * i, 0, 0}, quat_identity()};
        fail_unless(w, dig_region_create(w, &d, &r[i]), "region");
    }
    dig_snapshot *s = snapshot_of(w);
    Record a;
    record(w, &a);
    restore(w, s);
    for (int i = 0; i < 40; i++)
        fail_unless(w, dig_region_remove(w, r[i]), "remove");
    step(w, 3);
    restore(w, s);
    dig_body inside;
    CHECK_INT(dig_region_bodies(w, r[7], &inside, 1), 1);
    same_again(w, &a);
    restore(w, s);
    for (int i = 39; i >= 0; i--)
        fail_unless(w, dig_region_remove(w, r[i]), "remove");
    dig_snapshot_free(s);
    dig_world_close(w);
}

TEST(a_snapshot_of_another_world_is_refused)
{
    dig_world *a = open_small_scene(), *b = open_small_scene();
    dig_snapshot *s = snapshot_of(a);
    uint64_t before = dig_world_checksum(b);
    CHECK_INT(dig_world_restore(b, s), DIG_E_KIND);
    CHECK(strstr(dig_error(b), "another world") != NULL);
    CHECK(dig_world_checksum(b) == before);
    restore(a, s);
    dig_snapshot_free(s);
    dig_snapshot_free(NULL);
    dig_world_close(a);
    dig_world_close(b);
}

/* With threads: they stay with the world. */
TEST(a_world_with_threads_is_restored)
{
    dig_world_def def = dig_world_defaults();
    def.threads = 3;
    dig_world *w = open_with(def);
    add_floor(w, look(0.5, 0));
    for (int i = 0; i < 30; i++)
        add_ball(w, look(0.5, 0.4), 0.2, 1, (vec3){(real)(i % 6), 0.3 + 0.5 * (i / 6), 0.01 * i}, vec3_zero());
    step(w, 5);
    Record r;
    dig_snapshot *s = snapshot_of(w);
    record(w, &r);
    restore(w, s);
    same_again(w, &r);
    dig_snapshot_free(s);
    dig_world_close(w);
}

TEST(a_snapshot_outlives_its_world)
{
    dig_world *w = open_scene();
    dig_snapshot *s = snapshot_of(w);
    dig_world_close(w);
    dig_snapshot_free(s);
}

/* Names, places in sheets, where movers go, rolling friction and losses of contacts: most have none of these. */
TEST(what_few_have_takes_no_memory_and_is_restored)
{
    dig_world *w = open_scene();
    dig_body last = {0, 0};
    for (int i = 0; i < 4000; i++)
        last = add_ball(w, look(0.5, 0), 0.2, 1, (vec3){100 + i % 50, 50 + i / 50, 0}, vec3_zero());
    for (uint32_t i = 0, slot; i < 20000; i++)
        CHECK(contact_take(w, &slot) == DIG_OK);
    int bodies = resident_pages(&w->rest.data[1000], 3000 * sizeof(BodyRest));          /* of 105: one each time that the list grew */
    int contacts = resident_pages(&w->contact_rest.data[1000], 19000 * sizeof(ContactRest));       /* of 148 */
    CHECK(bodies >= 0 && bodies < 12 && contacts >= 0 && contacts < 12);
    for (uint32_t i = 0; i < 20000; i++)
        contact_give(w, i + (uint32_t)w->contacts.count - 20000);
    char name[64] = "last", other[64] = "other";
    CHECK(dig_body_set(w, last, "name", name) == DIG_OK);
    dig_snapshot *s = snapshot_of(w);
    CHECK(dig_body_set(w, last, "name", other) == DIG_OK);
    restore(w, s);
    dig_body found = dig_body_find(w, "last");
    CHECK(found.slot == last.slot && found.gen == last.gen && dig_body_find(w, "other").gen == 0);
    dig_snapshot_free(s);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(restored_it_runs_as_before), unit_test(sleep_is_restored_while_and_before_it_comes), unit_test(warm_start_is_restored),
              unit_test(bodies_and_joints_made_or_removed_in_between_do_not_matter), unit_test(settings_are_restored), unit_test(regions_are_restored),
              unit_test(a_snapshot_of_another_world_is_refused), unit_test(a_world_with_threads_is_restored),
              unit_test(a_snapshot_outlives_its_world), unit_test(what_few_have_takes_no_memory_and_is_restored));
}
