/* tests/unit/test_direct_cone.c - impulses found from the inside of their cones: one body on something fixed, by Coulomb's law in closed form, and rows of
 * joints with a bound. */
#include "solve/direct.h"
#include "check.h"

/* kg, kg m^2, m: a point under the centre, so that normal impulses do not turn it */
#define MASS    2.0
#define INERTIA 0.4
#define LEVER   0.5

typedef struct Case { Set set; real mu, bound; bool convex; Vel vel; real force[3]; real lift, reach; } Case;

static void put_row(real *j, vec3 v, vec3 w)
{
    memcpy(j + 6, &v, sizeof v);
    memcpy(j + 9, &w, sizeof w);
}

static Triple triple(const Case *c)
{
    static const vec3 axes[3] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
    Triple t = {.place = {-1, 0}, .set = c->set, .mu = c->mu, .bound = c->bound, .r = 1e-6 / MASS};
    for (int k = 0; k < 3; k++) {
        vec3 none = {0, 0, 0}, arm = vec3_cross((vec3){0, -LEVER, 0}, axes[k]);
        put_row(t.j[k], c->set == SET_BALL ? none : axes[k], c->set == SET_BALL ? axes[k] : arm);
        t.rate[k] = c->set == SET_BALL ? vec3_dot(axes[k], c->vel.w) : vec3_dot(axes[k], c->vel.v) + vec3_dot(arm, c->vel.w);
    }
    return t;
}

static void check(const Case *c)
{
    Arena arena = {0};
    Mass mass = {.im = 1 / MASS, .ii = mat3_diagonal((vec3){1 / INERTIA, 1 / INERTIA, 1 / INERTIA})};
    real reach = c->reach;
    Member member = {.outer = reach, .moves = true};
    RollRow roll = {.reach = reach};
    Group g = {.arena = &arena, .mass = &mass, .member = &member, .body_count = 1, .rolls = &roll, .roll_count = 1};
    Triple t = triple(c);
    int body = 0;
    real numbers[10] = {MASS, INERTIA, 0, 0, 0, INERTIA, 0, 0, 0, INERTIA}, v[6] = {0}, v0[6] = {0}, dv[6], grad[6];
    Direct d = {.g = &g, .triples = &t, .triple_count = 1, .body = &body, .mass = numbers, .v = v, .v0 = v0, .dv = dv, .grad = grad, .hardened = 1};
    const bool narrow = false;
    CHECK(blocks_plan(&d.blocks, &arena, &(BlockLinks){1, 0, NULL, &narrow, NULL, 0}) && blocks_reserve(&d.blocks, &arena));
    real off = direct_inside(&d, c->convex);
    CHECK(off <= 1e-5);
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(t.prox[k], c->force[k], 3e-5 / real_max(1, reach));
    CHECK_NEAR(t.lift, c->lift, 3e-5);
    arena_close(&arena);
}

/* The tangent has 1/2 + 0.25/0.4 = 1.125 per kg against it. */
TEST(coulombs_law_from_the_inside)
{
    static const Case cases[] = {
        {SET_CONE, 0.5, 0, false, {{3, -1, 0}, {0, 0, 0}}, {2, -1, 0}, 0.5 * (3 - 1.125), 1},
        {SET_CONE, 2, 0, false, {{3, -1, 0}, {0, 0, 0}}, {2, -3 / 1.125, 0}, 0, 1},
        {SET_CONE, 0, 0, false, {{3, -1, 0}, {0, 0, 0}}, {2, 0, 0}, 0, 1},
        {SET_CONE, 0.5, 0, false, {{3, 1, 0}, {0, 0, 0}}, {0, 0, 0}, 0.5 * 3, 1},
        /* a convex cone lifts what slides: v_n = mu slip, so that f_n (1/2 + 1.125/4) = 1 + 3/2 */
        {SET_CONE, 0.5, 0, true, {{3, -1, 0}, {0, 0, 0}}, {3.2, -1.6, 0}, 0, 1},
        {SET_DISC, 0.5, 1, false, {{3, -1, 0}, {0, 0, 0}}, {2, -1, 0}, 0, 1},
        {SET_DISC, 0.5, 5, false, {{3, -1, 0}, {0, 0, 0}}, {2, -3 / 1.125, 0}, 0, 1},
        {SET_DISC, 0.5, 0, false, {{3, -1, 0}, {0, 0, 0}}, {2, 0, 0}, 0, 1},
        {SET_BALL, 0, 0.5, false, {{0, 0, 0}, {0, 0, 4}}, {0, 0, -0.5}, 0, 1},
        {SET_BALL, 0, 5, false, {{0, 0, 0}, {0, 0, 4}}, {0, 0, -4 * INERTIA}, 0, 1},
        /* what is large counts by its rim */
        {SET_BALL, 0, 0.5, false, {{0, 0, 0}, {0, 0, 4}}, {0, 0, -0.5}, 0, 1000},
        {SET_BALL, 0, 5, false, {{0, 0, 0}, {0, 0, 4}}, {0, 0, -4 * INERTIA}, 0, 1000},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check(&cases[i]);
}

/* A row along x or about z, beside one that holds z. */
typedef struct Bound { bool turns; real lo, hi, target, rate, force; } Bound;

static void check_bound(const Bound *c)
{
    Arena arena = {0};
    Mass mass = {.im = 1 / MASS, .ii = mat3_diagonal((vec3){1 / INERTIA, 1 / INERTIA, 1 / INERTIA})};
    Member member = {.outer = 1, .moves = true};
    vec3 x = {1, 0, 0}, z = {0, 0, 1}, none = {0, 0, 0}, lin = c->turns ? none : x, ang = c->turns ? z : none;
    JointRow rows[2] = {{.row = {.count = 1, .body = {0}, .lin = {lin}, .ang = {ang}}, .k = c->turns ? 1 / INERTIA : 1 / MASS},
                        {.row = {.count = 1, .body = {0}, .lin = {z}, .ang = {none}}, .k = 1 / MASS}};
    Group g = {.arena = &arena, .mass = &mass, .member = &member, .body_count = 1, .rows = rows, .row_count = 2};
    Single singles[2] = {{.rate = c->rate, .target = c->target, .lo = c->lo, .hi = c->hi, .r = 1e-6 * rows[0].k, .bounded = true, .count = 1},
                         {.rate = 1, .lo = -INFINITY, .hi = INFINITY, .r = 1e-8 * rows[1].k, .row = 1, .count = 1}};
    vec3 of[2][2] = {{lin, ang}, {z, none}};
    for (int i = 0; i < 2; i++)
        memcpy(singles[i].j[0], of[i], sizeof of[i]);
    Triple t = {.set = SET_BALL};
    int body = 0;
    real numbers[10] = {MASS, INERTIA, 0, 0, 0, INERTIA, 0, 0, 0, INERTIA}, v[6] = {0}, v0[6] = {0}, dv[6], grad[6];
    Direct d = {.g = &g, .triples = &t, .singles = singles, .single_count = 2, .body = &body, .mass = numbers, .v = v, .v0 = v0, .dv = dv, .grad = grad,
                .hardened = 1};
    const bool narrow = false;
    CHECK(blocks_plan(&d.blocks, &arena, &(BlockLinks){1, 0, NULL, &narrow, NULL, 0}) && blocks_reserve(&d.blocks, &arena));
    real off = direct_inside(&d, false);
    CHECK(c->lo < c->hi ? off <= 1e-5 : off == INFINITY);
    CHECK_NEAR(singles[0].prox, c->force, c->lo < c->hi ? 3e-5 : INFINITY);
    CHECK_NEAR(singles[1].prox, c->lo < c->hi ? -MASS : 0, 3e-5);
    CHECK(singles[0].r == 1e-6 * rows[0].k);
    arena_close(&arena);
}

TEST(stops_motors_and_dry_friction_from_the_inside)
{
    static const Bound cases[] = {
        {false, 0, INFINITY, 0, -3, 3 * MASS},
        {false, 0, INFINITY, 0, 3, 0},
        {false, -INFINITY, 0, 0, 3, -3 * MASS},
        {false, -INFINITY, 0, 0, -3, 0},
        {false, -1, 1, 5, 0, 1},
        {false, -20, 20, 5, 0, 5 * MASS},
        {false, -2, 2, 0, 3, -2},
        {false, -20, 20, 0, 3, -3 * MASS},
        {false, 1, 4, 0, 3, 1},             /* pushes at least so hard */
        {false, 3, 3, 0, 0, 0},             /* no room: nothing to find */
        {true, -INFINITY, 0, 0, 4, -4 * INERTIA},
        {true, -0.5, 0.5, 0, 4, -0.5},
        {true, -5, 5, 0, 4, -4 * INERTIA},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_bound(&cases[i]);
}

TEST(without_rows_there_is_nothing_to_find)
{
    Arena arena = {0};
    Group g = {.arena = &arena};
    Triple t = {.set = SET_BALL};
    CHECK(!(direct_inside(&(Direct){.g = &g, .triples = &t, .triple_count = 1, .hardened = 1}, false) < INFINITY));
    arena_close(&arena);
}

int main(void) { RUN_TESTS(unit_test(coulombs_law_from_the_inside), unit_test(stops_motors_and_dry_friction_from_the_inside),
                          unit_test(without_rows_there_is_nothing_to_find)); }
