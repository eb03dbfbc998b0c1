/* test_part.c - one DIG and its surroundings taken out of a world: all its invariants hold, what is elsewhere is not in it, it moves
 * like the DIG in its world, and put back it is what it was.
 */
#include "physics_fixture.h"

#include "api/part.h"
#include "base/rng.h"

enum { CLUSTERS = 6, EACH = 4 };

typedef struct Town { dig_world *w; dig_body floor, frame, body[CLUSTERS][EACH]; } Town;

/* Every ten metres two blocks, one on the other, and two wheels on axles in one fixed frame, with a gear between them. */
static Town build(void)
{
    Town t = {.w = open_world(1.0 / 60, NULL, true)};
    const Look l = look(0.5, 0);
    const dig_plane_def plane = {{0, 1, 0}, 0};
    const dig_box_def block = {{1, 1, 1}}, rail = {{100, 0.1, 0.1}};
    const dig_cylinder_def disc = {0.2, 0.05};
    dig_body_def d = body_with(l, (vec3){0, 0, 0}, quat_identity());
    d.fixed = true;
    t.floor = add_body(t.w, d, "plane", &plane);
    d.at = (vec3){0, 5, 0};
    t.frame = add_body(t.w, d, "box", &rail);
    for (int i = 0; i < CLUSTERS; i++) {
        dig_joint axle[2];
        real x = 10 * i;
        for (int k = 0; k < 2; k++) {
            d = body_with(l, (vec3){x + 0.1 * k, 0.5 + k, 0}, quat_identity());
            t.body[i][k] = add_body(t.w, d, "box", &block);
            d = body_with(l, (vec3){x + 0.41 * k, 5, 0.5}, quat_exp((vec3){0.5 * 3.14159265358979, 0, 0}));
            d.group = -1;
            d.spin = (vec3){0, 0, k ? -1 : 1};
            t.body[i][2 + k] = add_body(t.w, d, "cylinder", &disc);
            axle[k] = create_joint(t.w, "hinge", t.body[i][2 + k], t.frame, d.at, (vec3){0, 0, 1}, NULL);
        }
        struct { dig_joint of[2]; real ratio[2]; } gear = {{axle[0], axle[1]}, {1, -1}};
        create_joint(t.w, "gear", (dig_body){0}, (dig_body){0}, d.at, (vec3){0, 0, 1}, &gear);
    }
    for (int i = 0; i < 20; i++)
        CHECK_INT(dig_world_step(t.w), DIG_OK);
    return t;
}

static int count_dynamic(const dig_world *w)
{
    int n = 0;
    for (int i = 0; i < w->bodies.count; i++)
        n += w->bodies.data[i].kind == DIG_DYNAMIC;
    return n;
}

TEST(it_holds_the_dig_and_its_grounds_and_nothing_else)
{
    Town t = build();
    for (int i = 0; i < CLUSTERS; i++)
        for (int k = 0; k < EACH; k++) {
            Part p;
            CHECK_INT(part_take(t.w, t.body[i][k].slot, 0.1, &p), DIG_OK);
            CHECK_INT(dig_world_check(p.world), DIG_OK);
            CHECK(!p.whole);
            CHECK_INT(count_dynamic(p.world), 2);
            CHECK_INT(p.joints.count, k < 2 ? 0 : 3);
            CHECK_INT(part_body_from(&p, part_body(&p, t.body[i][k].slot)), t.body[i][k].slot);
            CHECK(part_body(&p, t.body[(i + 1) % CLUSTERS][k].slot) == NONE);
            CHECK(part_body(&p, t.floor.slot) != NONE);
            CHECK((part_body(&p, t.frame.slot) != NONE) == (k >= 2));
            part_close(&p);
        }
    dig_world_close(t.w);
}

TEST(who_is_within_reach_is_in_it)
{
    Town t = build();
    Part p;
    CHECK_INT(part_take(t.w, t.body[0][0].slot, 8.5, &p), DIG_OK);      /* the next are 9 m away */
    CHECK_INT(count_dynamic(p.world), 4);
    part_close(&p);
    CHECK_INT(part_take(t.w, t.body[0][0].slot, 9.5, &p), DIG_OK);
    CHECK_INT(dig_world_check(p.world), DIG_OK);
    CHECK_INT(count_dynamic(p.world), 8);
    part_close(&p);
    dig_world_close(t.w);
}

static void push(dig_world *w, uint32_t slot)
{
    CHECK_INT(dig_body_push(w, body_handle(w, slot), (vec3){6000, 0, 100}, vec3_zero(), false, 1e6), DIG_OK);
}

/* The block is pushed, and carries the other along; the wheels go on turning. */
TEST(it_moves_as_in_its_world)
{
    Town t = build();
    for (int k = 0; k < EACH; k += 2) {
        Part p;
        CHECK_INT(part_take(t.w, t.body[2][k].slot, 0.1, &p), DIG_OK);
        push(t.w, t.body[2][k].slot);
        push(p.world, part_body(&p, t.body[2][k].slot));
        for (int i = 0; i < 20; i++) {
            CHECK_INT(dig_world_step(t.w), DIG_OK);
            CHECK_INT(dig_world_step(p.world), DIG_OK);
        }
        CHECK_INT(dig_world_check(p.world), DIG_OK);
        for (int j = k; j < k + 2; j++) {
            const Body *here = &p.world->bodies.data[part_body(&p, t.body[2][j].slot)], *there = &t.w->bodies.data[t.body[2][j].slot];
            CHECK_NEAR(vec3_distance(here->x, there->x), 0, 1e-9);
            CHECK_NEAR(vec3_distance(here->v, there->v), 0, 1e-9);
            CHECK_NEAR(vec3_distance(here->w, there->w), 0, 1e-9);
        }
        part_close(&p);
    }
    dig_world_close(t.w);
}

TEST(a_copy_is_put_back_without_new_memory)
{
    Town t = build();
    Part p;
    World *copy;
    CHECK_INT(part_take(t.w, t.body[1][0].slot, 0.1, &p), DIG_OK);
    CHECK_INT(api_clone(p.world, &copy), DIG_OK);
    uint64_t as_it_was = dig_world_checksum(copy), allocations = 0;
    for (int i = 0; i < 4; i++) {
        push(copy, part_body(&p, t.body[1][0].slot));
        for (int k = 0; k < 30; k++)
            CHECK_INT(dig_world_step(copy), DIG_OK);
        CHECK(dig_world_checksum(copy) != as_it_was);
        if (i < 2)
            allocations = dig_world_stats(copy).allocations;
        CHECK_INT(api_refill(copy, p.world), DIG_OK);
        CHECK(dig_world_checksum(copy) == as_it_was);
        CHECK_INT(dig_world_check(copy), DIG_OK);
    }
    CHECK_INT(dig_world_stats(copy).allocations, allocations);
    CHECK(dig_world_checksum(p.world) == as_it_was);
    dig_world_close(copy);
    part_close(&p);
    dig_world_close(t.w);
}

static dig_status wind(void *data, const dig_effect_call *call, char *why, size_t capacity)
{
    (void)data;
    (void)call;
    (void)why;
    (void)capacity;
    return DIG_OK;
}

TEST(with_an_effect_of_the_callers_own_it_is_the_whole_world)
{
    Town t = build();
    Part p;
    const dig_effect_def def = {.name = "wind", .law = "F = 0", .stage = DIG_STAGE_FORCE, .all = true, .step = wind};
    CHECK_INT(dig_effect_add(t.w, &def), DIG_OK);
    CHECK_INT(part_take(t.w, t.body[3][1].slot, 0.1, &p), DIG_OK);
    CHECK(p.whole);
    CHECK(dig_world_checksum(p.world) == dig_world_checksum(t.w));
    CHECK_INT(part_body(&p, t.body[3][1].slot), t.body[3][1].slot);
    part_close(&p);
    dig_world_close(t.w);
}

int main(void)
{
    RUN_TESTS(unit_test(it_holds_the_dig_and_its_grounds_and_nothing_else), unit_test(who_is_within_reach_is_in_it),
              unit_test(it_moves_as_in_its_world), unit_test(a_copy_is_put_back_without_new_memory),
              unit_test(with_an_effect_of_the_callers_own_it_is_the_whole_world));
}
