/* tests/unit/test_handles.c - handles of what is gone are never valid again, however many there were (H3, H13).
 *
 * A world gives numbers from one counter and never one twice. That they last for HANDLES_MOST things is seen from a world that has
 * given nearly all of them. DIGBOX_FULL=1: 10^8 bodies instead of 10^6.
 */
#define _GNU_SOURCE             /* mallinfo2 */
#include "physics_fixture.h"
#include "world/world.h"

#include <malloc.h>
#include <stdlib.h>

enum { KEPT = 1000000, AT_ONCE = 10, STEP_EVERY = 100 };

static dig_body add_small(dig_world *w, int64_t n)
{
    return add_ball(w, look(0.5, 0.3), 0.1, 1, (vec3){(double)(n % 7), 1, 0}, vec3_zero());
}

/* A hinge's worth of everything that has a handle. */
static dig_status add_joint(dig_world *w, dig_body a, dig_joint *out)
{
    dig_joint_def j = dig_joint_defaults();
    const dig_schema *schema = dig_schema_find("joint", "ball");
    char data[1024];
    dig_schema_defaults(schema, data);
    j.type = "ball";
    j.data = data;
    j.a = a;
    j.at = state_of(w, a).position;
    return dig_joint_create(w, &j, out);
}

static size_t in_use(void) { return mallinfo2().uordblks; }

/* Bodies come and go, ten at once, in another order than they came; now and then the world steps. */
static void churn(dig_world *w, int64_t count, dig_body *kept)
{
    dig_body now[AT_ONCE];
    for (int64_t n = 0; n < count; n += AT_ONCE) {
        for (int i = 0; i < AT_ONCE; i++) {
            now[i] = add_small(w, n + i);
            if (n + i < KEPT)
                kept[n + i] = now[i];
        }
        for (int i = 0; i < AT_ONCE; i++)
            CHECK(dig_body_remove(w, now[i * 7 % AT_ONCE]) == DIG_OK);
        if (n / AT_ONCE % STEP_EVERY == 0)
            step(w, 1);
    }
}

TEST(bodies_that_come_and_go_leave_nothing_behind)
{
    int64_t count = getenv("DIGBOX_FULL") ? 100000000 : 1000000;
    dig_world *w = open_world(1.0 / 60, NULL, true);
    dig_body *kept = calloc(KEPT, sizeof *kept), last;
    CHECK(kept != NULL);
    churn(w, 20000, kept);
    size_t bytes = dig_world_stats(w).bytes;
    size_t used = in_use();
    churn(w, count, kept);
    CHECK(dig_world_stats(w).bytes == bytes);
    CHECK(in_use() < used + (1 << 20) && used < in_use() + (1 << 20));
    for (int i = 0; i < AT_ONCE; i++)
        last = add_small(w, i);                             /* in the slots that all of them had */
    int alive = 0;
    for (int i = 0; i < KEPT; i++)
        alive += dig_body_alive(w, kept[i]);
    CHECK_INT(alive, 0);
    CHECK(dig_body_alive(w, last));
    check_world(w);
    free(kept);
    dig_world_close(w);
}

/* The last numbers are good ones, from wherever the world counts; then there are no more, and the world goes on with what it has. */
static void use_up(uint32_t from)
{
    enum { LEFT = 256 };
    dig_world *w = open_world(1.0 / 60, NULL, true);
    w->gen_start = from;
    dig_body first = add_small(w, 0), all[LEFT];
    dig_joint joint;
    w->serial = HANDLES_MOST - LEFT - 1;
    CHECK(add_joint(w, first, &joint) == DIG_OK);
    for (int i = 0; i < LEFT; i++) {
        all[i] = add_small(w, i);
        CHECK(all[i].gen != 0 && all[i].gen > first.gen);   /* 0 is no body; less would be one from long ago */
        if (i % 2 == 0)
            CHECK(dig_body_remove(w, all[i]) == DIG_OK);
    }
    for (int i = 0; i < LEFT; i++)
        CHECK(dig_body_alive(w, all[i]) == (i % 2 == 1));
    uint64_t sum = dig_world_checksum(w);
    int64_t bodies = dig_world_stats(w).bodies;
    dig_body_def d = body_with(look(0.5, 0.3), (vec3){0, 9, 0}, quat_identity());
    dig_shape_def shape = {.type = "sphere", .data = &(dig_sphere_def){0.1}, .colour = {-1, 0, 0}};
    dig_body none;
    d.shapes = &shape;
    d.shape_count = 1;
    for (int i = 0; i < 3; i++) {
        CHECK_INT(dig_body_create(w, &d, &none), DIG_E_MEMORY);
        CHECK(none.gen == 0 && strstr(dig_error(w), "this world has made 3000000000 bodies, joints and links"));
        CHECK_INT(add_joint(w, all[1], &joint), DIG_E_MEMORY);
        dig_region_def r = dig_region_defaults();
        dig_region region;
        r.shape = shape;
        CHECK_INT(dig_region_create(w, &r, &region), DIG_E_MEMORY);
    }
    CHECK(dig_world_checksum(w) == sum && dig_world_stats(w).bodies == bodies);
    step(w, 10);
    check_world(w);
    dig_world_close(w);
}

TEST(no_handle_comes_twice_even_when_all_are_used_up)
{
    use_up(1);
    use_up(0x3fffffffu);        /* the highest that a world begins with */
}

int main(void)
{
    RUN_TESTS(unit_test(bodies_that_come_and_go_leave_nothing_behind),
              unit_test(no_handle_comes_twice_even_when_all_are_used_up));
}
