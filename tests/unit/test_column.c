/* test_column.c - what effects keep of bodies: in the order of slots, whatever the order of joining; copies equal; none, no bytes. */
#include "world/column.h"

#include "check.h"

typedef struct Warm { real temperature, power; } Warm;

static void add(Column *c, uint32_t body, real temperature)
{
    uint64_t allocations = 0;
    CHECK_INT(column_add(c, body, &(Warm){temperature, 1}, &allocations), DIG_OK);
}

static real temperature(const Column *c, uint32_t body)
{
    const Warm *w = column_find(c, body);
    return w ? w->temperature : -1;
}

TEST(a_column_without_members_takes_no_bytes)
{
    Column c = {.size = sizeof(Warm)};
    CHECK_INT(column_bytes(&c), 0);
    CHECK(!column_find(&c, 0));
    CHECK(!column_find(&c, UINT32_MAX));
    column_close(&c);
}

TEST(members_stand_in_the_order_of_their_slots)
{
    Column c = {.size = sizeof(Warm)}, d = {.size = sizeof(Warm)};
    static const uint32_t up[] = {3, 7, 20, 21}, mixed[] = {20, 3, 21, 7};
    for (int i = 0; i < 4; i++) {
        add(&c, up[i], up[i]);
        add(&d, mixed[i], mixed[i]);
    }
    for (int i = 0; i < 4; i++) {
        CHECK_INT(d.body[i], up[i]);
        CHECK_NEAR(temperature(&d, up[i]), up[i], 0);
    }
    CHECK(column_hash(&c, HASH_START) == column_hash(&d, HASH_START));
    add(&d, 7, 99);
    CHECK_INT(d.count, 4);
    CHECK_NEAR(temperature(&d, 7), 99, 0);
    CHECK(column_hash(&c, HASH_START) != column_hash(&d, HASH_START));
    column_close(&c);
    column_close(&d);
}

TEST(removing_a_member_leaves_the_others)
{
    Column c = {.size = sizeof(Warm)};
    for (uint32_t i = 0; i < 50; i++)
        add(&c, (i * 37) % 50, (i * 37) % 50);
    for (uint32_t i = 0; i < 50; i += 2)
        column_remove(&c, i);
    column_remove(&c, 4);
    column_remove(&c, 1000);
    CHECK_INT(c.count, 25);
    for (uint32_t i = 0; i < 50; i++)
        CHECK_NEAR(temperature(&c, i), i % 2 ? (real)i : -1.0, 0);
    column_close(&c);
}

TEST(a_copy_is_equal_and_apart)
{
    uint64_t allocations = 0;
    Column c = {.size = sizeof(Warm)}, d = {.size = sizeof(Warm)};
    for (uint32_t i = 0; i < 9; i++)
        add(&c, 5 * i, i);
    CHECK_INT(column_copy(&d, &c, &allocations), DIG_OK);
    CHECK(allocations > 0);
    CHECK(column_hash(&c, HASH_START) == column_hash(&d, HASH_START));
    column_remove(&c, 5);
    CHECK_NEAR(temperature(&d, 5), 1, 0);
    column_close(&c);
    column_close(&d);
}

int main(void)
{
    RUN_TESTS(unit_test(a_column_without_members_takes_no_bytes), unit_test(members_stand_in_the_order_of_their_slots),
              unit_test(removing_a_member_leaves_the_others), unit_test(a_copy_is_equal_and_apart));
}
