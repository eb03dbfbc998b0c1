/* tests/unit/test_near.c - who has a pair with whom: all whose fat boxes meet and may touch, and nobody else; in the same order for
 * any number of threads. */
#include "base/rng.h"
#include "physics_fixture.h"
#include "world/world.h"

static real between(uint64_t *rng, real lo, real hi) { return lo + (hi - lo) * rng_real(rng); }

/* Balls and boxes that fly about above a plane, fast and slow, of very different sizes. */
static dig_world *swarm(int threads, int count)
{
    dig_world_def def = dig_world_defaults();
    def.threads = threads;
    char why[200];
    dig_world *w = NULL;
    CHECK(dig_world_open(&def, &w, why, sizeof why) == DIG_OK);
    add_floor(w, look(0.5, 0.5));
    uint64_t rng = 11;
    for (int i = 0; i < count; i++) {
        real size = exp(between(&rng, log(0.02), log(0.5)));
        dig_body_def d = body_with(look(0.5, 0.5), (vec3){between(&rng, -3, 3), between(&rng, 0.6, 6), between(&rng, -3, 3)}, quat_identity());
        d.velocity = (vec3){between(&rng, -9, 9), between(&rng, -9, 9), between(&rng, -9, 9)};
        if (i % 2)
            add_body(w, d, "sphere", &(dig_sphere_def){0.5 * size});
        else
            add_body(w, d, "box", &(dig_box_def){{size, size, size}});
    }
    return w;
}

static void check_pairs(const World *w)
{
    int met = 0;
    for (uint32_t a = 0; a < (uint32_t)w->solids.count; a++)
        for (uint32_t b = a + 1; b < (uint32_t)w->solids.count; b++) {
            const Solid *s = &w->solids.data[a], *o = &w->solids.data[b];
            uint32_t pair;
            bool paired = pair_find(w, a, b, &pair);
            if (!s->alive || !o->alive || s->leaf < 0 || o->leaf < 0)
                continue;               /* a plane has no box: its pairs are those that could get to it */
            bool meets = bodies_may_touch(w, s, o) && box3_overlap(tree_box(&w->tree, s->leaf), tree_box(&w->tree, o->leaf));
            if (meets != paired)
                fail_msg("shapes %u and %u: boxes meet %d, pair %d", a, b, meets, paired);
            met += meets;
        }
    CHECK(met > 0);
}

TEST(all_whose_boxes_meet_have_a_pair_and_nobody_else)
{
    dig_world *w = swarm(1, 300);
    for (int i = 0; i < 60; i++) {
        step(w, 1);
        check_pairs(w);
        if (i == 30)                    /* by hand, and some that go */
            for (uint32_t k = 3; k < 60; k++) {
                dig_body b = body_handle(w, k);
                if (k % 3 == 0)
                    dig_body_remove(w, b);
                else
                    CHECK(dig_body_teleport(w, b, &(vec3){0.05 * k, 2, 0}, NULL, NULL, NULL) == DIG_OK);
            }
    }
    check_world(w);
    dig_world_close(w);
}

TEST(pairs_come_in_the_same_order_on_any_number_of_threads)
{
    dig_world *w[3] = {swarm(1, 900), swarm(2, 900), swarm(5, 900)};
    for (int i = 0; i < 20; i++) {
        for (int k = 0; k < 3; k++)
            step(w[k], 1);
        for (int k = 1; k < 3; k++) {
            CHECK_INT(w[k]->pairs.count, w[0]->pairs.count);
            for (int p = 0; p < w[0]->pairs.count; p++) {
                const Pair *x = &w[0]->pairs.data[p], *y = &w[k]->pairs.data[p];
                CHECK(x->alive == y->alive && (!x->alive || (x->solid_a == y->solid_a && x->solid_b == y->solid_b)));
            }
            CHECK(dig_world_checksum(w[k]) == dig_world_checksum(w[0]));
        }
    }
    for (int k = 0; k < 3; k++)
        dig_world_close(w[k]);
}

int main(void)
{
    RUN_TESTS(unit_test(all_whose_boxes_meet_have_a_pair_and_nobody_else),
              unit_test(pairs_come_in_the_same_order_on_any_number_of_threads));
}
