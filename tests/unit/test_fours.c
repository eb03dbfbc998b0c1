/* tests/unit/test_fours.c - rows four side by side are solved to the bits of rows one after the other. */
#include "physics_fixture.h"
#include "solve/direction.h"
#include "solve/fours.h"

#include <stdlib.h>

enum { BODIES = 24, STILL = 3, POINTS = 90, ROLLS = 30 };

typedef struct Heap {
    Arena    arena;
    Group    g;
    Vel      vel[BODIES + 1];
    Mass     mass[BODIES];
    Member   member[BODIES];
    PointRow points[POINTS];
    RollRow  rolls[ROLLS];
    uint64_t seed;
} Heap;

static real draw(Heap *h, real lo, real hi)
{
    h->seed = h->seed * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * (real)(h->seed >> 11) * 0x1p-53;
}

static vec3 draw3(Heap *h, real most) { return (vec3){draw(h, -most, most), draw(h, -most, most), draw(h, -most, most)}; }

static void body(Heap *h, int i)
{
    bool moves = i < BODIES - STILL;
    real m = draw(h, 0.1, 10);
    h->member[i].moves = moves;
    h->vel[i] = (Vel){draw3(h, 2), draw3(h, 5)};
    h->mass[i] = moves ? (Mass){1 / m, mat3_diagonal((vec3){draw(h, 5, 20) / m, draw(h, 5, 20) / m, draw(h, 5, 20) / m})} : (Mass){0, mat3_zero()};
}

static void point(Heap *h, int i, int a, int b)
{
    PointRow *r = &h->points[i];
    *r = (PointRow){.a = a, .b = b, .contact = i};
    point_row_set(&h->g, r, vec3_unit(draw3(h, 1)), vec3_zero(), draw3(h, 0.5), draw3(h, 0.5));
    r->target = draw(h, -1, 1);
    r->friction = i % 4 == 0 ? 0 : 0.5;
    r->friction_dynamic = 0.3;
    r->slides = i % 3 == 0;
    r->blow = i % 5 == 0 ? 0.2 : 0;
    r->jn = draw(h, 0, 1);
    r->jt[0] = draw(h, -0.1, 0.1);
    if (i % 17 == 0)
        r->n.k = 0;             /* a row that nothing can move */
}

static void roll(Heap *h, int i)
{
    const PointRow *p = &h->points[3 * i];
    real k = draw(h, 0.01, 0.1);
    h->rolls[i] = (RollRow){.first = 3 * i, .count = 1 + i % 3, .a = p->a, .b = p->b, .lever = 0.01, .reach = 0.3, .inv_k = mat3_diagonal((vec3){k, k, k})};
}

/* Points of pairs drawn at random, one side at most of which does not move; of `one`, all with the first body. */
static Heap *heap(uint64_t seed, bool one)
{
    Heap *h = calloc(1, sizeof *h);
    CHECK(h != NULL);
    h->seed = seed;
    h->g = (Group){.arena = &h->arena, .vel = h->vel, .mass = h->mass, .member = h->member, .body_count = BODIES, .moving_count = BODIES - STILL,
                   .points = h->points, .point_count = POINTS, .rolls = h->rolls, .roll_count = ROLLS};
    for (int i = 0; i < BODIES; i++)
        body(h, i);
    for (int i = 0; i < POINTS; i++) {
        int a = one ? 0 : (int)draw(h, 0, BODIES - STILL), b = (int)draw(h, 0, BODIES);
        point(h, i, a, b == a ? BODIES - 1 : b);
    }
    for (int i = 0; i < ROLLS; i++)
        roll(h, i);
    return h;
}

static void drop(Heap *h)
{
    arena_close(&h->arena);
    free(h);
}

static void check_same(const Heap *a, const Heap *b)
{
    for (int i = 0; i < BODIES; i++) {
        CHECK(vec3_distance(a->vel[i].v, b->vel[i].v) == 0);
        CHECK(vec3_distance(a->vel[i].w, b->vel[i].w) == 0);
    }
    for (int i = 0; i < POINTS; i++)
        CHECK(a->points[i].jn == b->points[i].jn && a->points[i].jt[0] == b->points[i].jt[0] && a->points[i].jt[1] == b->points[i].jt[1]);
    for (int i = 0; i < ROLLS; i++)
        CHECK(vec3_distance(a->rolls[i].j, b->rolls[i].j) == 0);
}

/* One row after the other, as h's are dealt to fours. */
static real sweep_in_turn(Heap *h, const int *points, const int *rolls)
{
    real worst = 0;
    for (int i = 0; i < ROLLS; i++) {       /* alone, as if it were the group's only one */
        Group g = h->g;
        g.rolls += rolls[i];
        g.roll_count = 1;
        worst = real_max(worst, relax_rolls(&g));
    }
    for (int i = 0; i < POINTS; i++)
        worst = real_max(worst, relax_points(&h->g, points[i], 1));
    return worst;
}

TEST(rows_side_by_side_are_swept_to_the_bits_of_rows_in_turn)
{
    for (uint64_t seed = 1; seed <= 20; seed++)
        for (int plain = 0; plain < 2; plain++) {
            Heap *one = heap(seed, false), *four = heap(seed, false);
            Fours *f = fours_open(&four->g, 5, plain);
            CHECK(f != NULL);
            int points[POINTS], rolls[ROLLS];
            fours_order(f, points, rolls);
            for (int sweep = 0; sweep < 10; sweep++) {
                real worst = sweep_in_turn(one, points, rolls);
                CHECK(worst > 0);
                CHECK_NEAR(fours_relax(f), worst, 0);
            }
            for (int i = 0; i < 5; i++)
                CHECK(fours_impulses(f)[fours_count(f) + i] == 0);
            fours_close(f);
            check_same(one, four);
            drop(one);
            drop(four);
        }
}

TEST(rows_that_all_have_one_body_are_left_to_be_swept_in_turn)
{
    Heap *h = heap(1, true);
    CHECK(fours_open(&h->g, 0, false) == NULL);
    CHECK_INT(h->g.status, DIG_OK);
    drop(h);
}

TEST(few_rows_are_left_to_be_swept_in_turn)
{
    Heap *h = heap(1, false);
    h->g.point_count = 4;
    CHECK(fours_open(&h->g, 0, false) == NULL);
    drop(h);
}

/* In any other order its load would not come down a tower in one sweep. */
TEST(what_carries_something_heavy_is_left_to_be_swept_in_turn)
{
    for (int heavy = 0; heavy < 2; heavy++) {
        Heap *h = heap(1, false);
        for (int i = 0; i < BODIES - STILL; i++)
            h->member[i].mass = heavy && i == 0 ? 100 : 1;
        CHECK((fours_open(&h->g, 0, false) == NULL) == (heavy == 1));
        drop(h);
    }
}

/* Impulses from nowhere, as of one direction after the other. */
TEST(points_warm_up_to_the_bits_of_directions_in_turn)
{
    Heap *one = heap(3, false), *all = heap(3, false);
    warm_points(&all->g);
    for (int i = 0; i < POINTS; i++) {
        PointRow *r = &one->points[i];
        dir_apply(&one->g, &r->n, r->a, r->b, r->jn);
        dir_apply(&one->g, &r->t[0], r->a, r->b, r->jt[0]);
        dir_apply(&one->g, &r->t[1], r->a, r->b, r->jt[1]);
    }
    check_same(one, all);
    drop(one);
    drop(all);
}

static bool same_dir(const Dir *d, const Dir *e) { return memcmp(d, e, sizeof *d) == 0; }

TEST(rows_of_a_contacts_points_side_by_side_have_the_bits_of_rows_in_turn)
{
    Heap *h = heap(5, false);
    Pos pos[2] = {{draw3(h, 1), quat_identity()}, {draw3(h, 1), quat_identity()}};
    for (int i = 0; i < 200; i++) {
        ManifoldPoint at[MANIFOLD_POINTS];
        GroupContact c = {.a = 0, .b = 1, .manifold = {.normal = vec3_unit(draw3(h, 1)), .points = at, .count = 1 + i % MANIFOLD_POINTS}};
        for (int k = 0; k < MANIFOLD_POINTS; k++)
            at[k] = (ManifoldPoint){.a = draw3(h, 2), .b = draw3(h, 2)};
        PointRow rows[MANIFOLD_POINTS], row;
        memset(rows, 0xAA, sizeof rows);
        h->g.pos = pos;
        h->g.contacts = &c;
        h->g.planar = i % 5 == 4 ? 1 + i % 3 : 0;
        contact_rows_make(&h->g, rows, 0);
        for (int k = 0; k < c.manifold.count; k++) {
            const PointRow *r = &rows[k];
            point_row_make(&h->g, &row, 0, k);
            CHECK(same_dir(&r->n, &row.n) && same_dir(&r->t[0], &row.t[0]) && same_dir(&r->t[1], &row.t[1]));
            CHECK(r->ktt == row.ktt && r->kmax == row.kmax && r->a == 0 && r->b == 1 && r->point == k);
            CHECK(r->target == 0 && r->friction == 0 && r->jn == 0 && r->jt[1] == 0 && r->gap == 0 && !r->slides && !r->curved);
        }
    }
    drop(h);
}

int main(void)
{
    RUN_TESTS(unit_test(rows_side_by_side_are_swept_to_the_bits_of_rows_in_turn),
               unit_test(rows_that_all_have_one_body_are_left_to_be_swept_in_turn),
               unit_test(few_rows_are_left_to_be_swept_in_turn),
               unit_test(what_carries_something_heavy_is_left_to_be_swept_in_turn),
               unit_test(points_warm_up_to_the_bits_of_directions_in_turn),
               unit_test(rows_of_a_contacts_points_side_by_side_have_the_bits_of_rows_in_turn));
}
