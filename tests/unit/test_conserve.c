/* tests/unit/test_conserve.c - jointed groups that touch nothing: joints hold, energy and both momenta stay.
 *
 * Bounds on what is conserved are about three times what a run leaves: single steps are solved to 1e-11 m, composed ones to 1e-13 m,
 * and hundreds of them add up. Momentum needs no solve: it stays to rounding.
 * Not in RENDER=0: physics alone. */
#include "base/param.h"
#include "base/rng.h"
#include "conserve/system.h"
#include "physics_fixture.h"

static const dig_body nobody = {0, 0};
static const vec3 x_axis = {1, 0, 0}, y_axis = {0, 1, 0}, z_axis = {0, 0, 1};

/* ---- building ---- */

typedef struct Value { const char *name; real value; } Value;

/* Up to two numbers among the joint's parameters. */
static dig_joint join_with(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at, vec3 axis, Value first, Value second)
{
    char data[1024];
    const dig_schema *schema = dig_schema_find("joint", type);
    CHECK(schema && schema->size <= sizeof data);
    dig_schema_defaults(schema, data);
    const Value values[2] = {first, second};
    for (int i = 0; i < 2 && values[i].name; i++) {
        size_t offset;
        CHECK(param_find_path(schema->rows, values[i].name, &offset));
        memcpy(data + offset, &values[i].value, sizeof(real));
    }
    return create_joint(w, type, a, b, at, axis, data);
}

static dig_body_def ghost(vec3 at, quat q, real mass)
{
    dig_body_def d = body_with(look(0, 0), at, q);
    d.mass = mass;
    d.collides = false;
    return d;
}

/* A square rod of 1 kg from p to q. */
static dig_body add_rod(dig_world *w, vec3 p, vec3 q, real section)
{
    vec3 d = vec3_sub(q, p);
    real length = vec3_length(d);
    dig_box_def box = {{length, section, section}};
    return add_body(w, ghost(vec3_scale(0.5, vec3_add(p, q)), quat_between(x_axis, vec3_scale(1 / length, d)), 1), "box", &box);
}

static dig_body add_bob(dig_world *w, vec3 at, real mass, real radius)
{
    return add_body(w, ghost(at, quat_identity(), mass), "sphere", &(dig_sphere_def){radius});
}

/* The end of a rod. */
static vec3 tip(const dig_world *w, dig_body rod)
{
    dig_body_state s = state_of(w, rod);
    return vec3_add(s.position, quat_rotate(s.rotation, (vec3){0.5, 0, 0}));
}

/* Groups of up to 12 bodies are traced at "play" unless their joints close a loop, and with joints none at "sketch": the worlds here are longer,
 * closed, or "sketch". Loops, too, are traced at "study". */
static void check_conserved(const dig_world *w)
{
    dig_stats s = dig_world_stats(w);
    if (s.conserved != 1 || s.swept != 0)
        fail_msg("conserved %d, swept %d groups: %s", s.conserved, s.swept, s.gave_up_why);
}

/* ---- chains ---- */

/* Links of 0.2 m and 1 kg, horizontal, with a heavy ball at the end. */
static dig_body add_chain(dig_world *w, int links, real end_mass)
{
    dig_body last = nobody;
    for (int i = 0; i < links; i++) {
        vec3 from = {0.2 * i, 0, 0};
        dig_body b = add_rod(w, from, (vec3){0.2 * (i + 1), 0, 0}, 0.02);
        join_bodies(w, "ball", b, last, from, z_axis);
        last = b;
    }
    vec3 end = {0.2 * links, 0, 0};
    dig_body bob = add_bob(w, end, end_mass, 0.1);
    join_bodies(w, "ball", bob, last, end, z_axis);
    return bob;
}

/* B04. The converged greatest speed of the first pass is 1.0068 sqrt(2 g L). */
TEST(chain_with_a_thousand_times_its_link_keeps_length_and_energy_at_one_step_a_frame)
{
    enum { LINKS = 50 };
    const real length = 0.2 * LINKS, fall = sqrt(2 * GRAVITY * length);
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body bob = add_chain(w, LINKS, 1000);
    real e0 = dig_world_energy(w).total, fastest = 0;
    for (int i = 0; i < (SANITIZED ? 120 : 300); i++) {
        step(w, 1);
        check_conserved(w);
        CHECK_NEAR(dig_world_stats(w).joint_error, 0, 1e-11);
        CHECK_NEAR((dig_world_energy(w).total - e0) / (1000 * GRAVITY * length), 0, 2e-10);
        fastest = real_max(fastest, vec3_length(state_of(w, bob).velocity));
    }
    CHECK_NEAR(fastest / fall, 1.0068, 6e-4);
    dig_world_close(w);
}

/* The work is linear in the length: iterations stay, each costs as many blocks as there are links. */
TEST(iterations_do_not_grow_with_the_chain)
{
    const int links[2] = {25, 200};
    int evaluations[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        dig_world *w = open_world(1.0 / 60, "play", true);
        add_chain(w, links[k], 1000);
        for (int i = 0; i < 30; i++) {
            step(w, 1);
            check_conserved(w);
            evaluations[k] += dig_world_stats(w).evaluations;
        }
        dig_world_close(w);
    }
    CHECK(evaluations[1] <= 2 * evaluations[0]);
}

TEST(free_chain_keeps_momentum_and_angular_momentum_to_rounding)
{
    enum { LINKS = 14 };
    dig_world *w = open_world(1.0 / 60, "play", false);
    dig_body last = nobody;
    for (int i = 0; i < LINKS; i++) {
        dig_body_def d = ghost((vec3){0.2 * i + 0.1, 0, 0}, quat_identity(), 1);
        d.velocity = (vec3){0, 0.3 * i - 1, 0.2 * (i % 3)};
        d.spin = (vec3){1, 0.3 * i, 2};
        dig_body b = add_body(w, d, "box", &(dig_box_def){{0.2, 0.02, 0.02}});
        if (i > 0)
            join_bodies(w, "ball", b, last, (vec3){0.2 * i, 0, 0}, z_axis);
        last = b;
    }
    vec3 end = {0.2 * LINKS, 0, 0};
    join_bodies(w, "ball", add_bob(w, end, 100, 0.1), last, end, z_axis);
    vec3 p = dig_world_momentum(w), l = dig_world_angular_momentum(w);
    step(w, 1);             /* the velocities given break the joints: the first step puts them right, without momentum */
    real e = dig_world_energy(w).total;
    for (int i = 0; i < 1200; i++) {
        step(w, 1);
        CHECK_NEAR(vec3_distance(dig_world_momentum(w), p) / vec3_length(p), 0, 1e-13);
        CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), l) / vec3_length(l), 0, 1e-13);
        CHECK_NEAR(dig_world_energy(w).total / e, 1, 4e-11);
        check_conserved(w);
    }
    dig_world_close(w);
}

/* ---- loops ---- */

/* Parallelogram of three rods: phi'' = g (2 / 2 + 1) / (2 (1/3 + s^2 / 12) + 1) sin(phi) for rods of 1 m, 1 kg, section s. The
 * classical Runge-Kutta rule with a thousandth of a second is exact here. */
static real parallelogram_angle(real section, real rate, real time)
{
    const real k = 2 * GRAVITY / (2.0 / 3 + section * section / 6 + 1), h = 1e-3;
    real phi = 0, w = rate;
    for (int i = 0; i < (int)lround(time / h); i++) {
        real a1 = k * sin(phi), w2 = w + 0.5 * h * a1, a2 = k * sin(phi + 0.5 * h * w), w3 = w + 0.5 * h * a2;
        real a3 = k * sin(phi + 0.5 * h * w2), w4 = w + h * a3, a4 = k * sin(phi + h * w3);
        phi += h * (w + 2 * w2 + 2 * w3 + w4) / 6;
        w += h * (a1 + 2 * a2 + 2 * a3 + a4) / 6;
    }
    return phi;
}

typedef struct FourBar { dig_world *w; dig_body rod[3]; } FourBar;

/* Four hinges in a plane: three of the twenty rows say nothing new. */
static FourBar open_four_bar(const char *plan, real section)
{
    dig_world *w = open_world(1.0 / 60, plan, true);
    dig_body a = add_rod(w, vec3_zero(), y_axis, section), b = add_rod(w, y_axis, (vec3){1, 1, 0}, section);
    dig_body c = add_rod(w, (vec3){1, 1, 0}, x_axis, section);
    join_bodies(w, "hinge", a, nobody, vec3_zero(), z_axis);
    join_bodies(w, "hinge", b, a, y_axis, z_axis);
    join_bodies(w, "hinge", c, b, (vec3){1, 1, 0}, z_axis);
    join_bodies(w, "hinge", c, nobody, x_axis, z_axis);
    vec3 half = {0.5, 0, 0}, spin = {0, 0, -1}, none = vec3_zero();
    dig_body_teleport(w, a, NULL, NULL, &half, &spin);
    dig_body_teleport(w, c, NULL, NULL, &half, &spin);
    dig_body_teleport(w, b, NULL, NULL, &x_axis, &none);
    return (FourBar){w, {a, b, c}};
}

/* Runs it for 20 s, through its singular positions; bounds of the gaps of its joints, its energy, its plane, and its angle after 2 s. */
static void check_four_bar(const char *plan, bool traced, real gap, real energy, real off_plane, real off)
{
    const real section = 0.05;
    FourBar f = open_four_bar(plan, section);
    real e = dig_world_energy(f.w).total;
    for (int i = 1; i <= 1200; i++) {
        step(f.w, 1);
        if (traced)
            CHECK_INT(dig_world_stats(f.w).traced, 1);
        else
            check_conserved(f.w);
        CHECK_NEAR(dig_world_stats(f.w).joint_error, 0, gap);
        CHECK_NEAR(dig_world_energy(f.w).total, e, energy);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(state_of(f.w, f.rod[k]).position.z, 0, off_plane);
        if (i == 120) {
            real phi = parallelogram_angle(section, 1, 2);
            CHECK_NEAR(vec3_distance(tip(f.w, f.rod[0]), (vec3){sin(phi), cos(phi), 0}), 0, off);
        }
    }
    CHECK_INT(dig_world_stats(f.w).gave_up, 0);
    dig_world_close(f.w);
}

/* B20 */
TEST(four_bar_loop_stays_in_its_plane_and_follows_its_equation) { check_four_bar("play", false, 1e-12, 5e-12, 1e-14, 3e-7); }

/* Where the budget lasts for it it is traced, though it turns slowly, with local errors of 1e-10 at most. */
TEST(four_bar_loop_is_traced_at_a_fine_tolerance)
{
    check_four_bar("study", true, 1e-12, 5e-12, 1e-14, 1e-11);
    check_four_bar("reference", true, 2e-13, 5e-12, 1e-14, 1e-11);
}

/* A20. Five rods and six hinges that by count could not move. OpenSim's layout; P3(1 s) from one closed coordinate. */
static real bricard_error(real h, const char *plan)
{
    static const vec3 corner[6] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
    const vec3 axis[3] = {y_axis, z_axis, x_axis};
    dig_world *w = open_world(h, plan, true);
    dig_body rod[5], last = nobody;
    for (int i = 0; i < 5; i++) {
        rod[i] = add_rod(w, corner[i], corner[i + 1], 0.1);
        join_bodies(w, "hinge", rod[i], last, corner[i], axis[i % 3]);
        last = rod[i];
    }
    join_bodies(w, "hinge", last, nobody, corner[5], x_axis);
    real e = dig_world_energy(w).total;
    step(w, (int)lround(1 / h));
    check_conserved(w);
    CHECK_NEAR(dig_world_energy(w).total, e, 4e-10);
    CHECK_NEAR(dig_world_stats(w).joint_error, 0, 5e-12);
    real error = vec3_distance(tip(w, rod[2]), (vec3){0.510501461187219736, -1.64916759939480631, 0.140123114553185828});
    dig_world_close(w);
    return error;
}

/* Newton's method of a precise step: two digits become four and eight, if the matrix is right, and the last ones come by a factor that is
 * there. Each of the five steps of a frame takes three iterations that count, and one that finds the solution good enough. */
TEST(precise_steps_take_three_iterations)
{
    FourBar f = open_four_bar("play", 0.05);
    int evaluations = 0;
    for (int i = 0; i < 300; i++) {
        step(f.w, 1);
        check_conserved(f.w);
        CHECK_NEAR(dig_world_stats(f.w).joint_error, 0, 2e-14);
        evaluations += dig_world_stats(f.w).evaluations;
    }
    CHECK(evaluations <= 300 * 5 * 3);
    dig_world_close(f.w);
}

/* Two nodes of 3 and 5 unknowns that know each other. */
typedef struct Nodes {
    System s;
    Elimination order[2];
    Later later[1];
    Block target[1];
    Exchange exchange[2];
    real value[9 + 15 + 15 + 25], side[12], a[8][8];
} Nodes;

static void open_nodes(Nodes *n, uint64_t *dice)
{
    *n = (Nodes){.order = {{.node = 0, .size = 3, .diagonal = 0, .lower = 9, .upper = 24, .width = 5, .count = 1},
                           {.node = 1, .size = 5, .diagonal = 39, .lower = 64, .upper = 64, .first = 1}},
                 .later = {{.node = 1, .size = 5}}, .target = {{39, 5}}};
    n->s = (System){.node_count = 2, .order = n->order, .later = n->later, .target = n->target, .exchange = n->exchange, .value = n->value,
                    .side = n->side};
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 8; k++) {
            real *at = i < 3 ? (k < 3 ? &n->value[3 * i + k] : &n->value[24 + 5 * i + k - 3])
                             : (k < 3 ? &n->value[9 + 3 * (i - 3) + k] : &n->value[39 + 5 * (i - 3) + k - 3]);
            *at = n->a[i][k] = 2 * rng_real(dice) - 1;
        }
}

/* Puts a random side there, and returns how far the solution that `again` or a new factor finds misses it. */
static real miss_of(Nodes *n, uint64_t *dice, bool again)
{
    real b[8], worst = 0;
    for (int i = 0; i < 8; i++)
        b[i] = n->side[i < 3 ? i : i + 3] = 2 * rng_real(dice) - 1;
    if (again)
        factor_again(&n->s);
    else
        CHECK(factor_solve(&n->s));
    for (int i = 0; i < 8; i++) {
        real sum = -b[i];
        for (int k = 0; k < 8; k++)
            sum += n->a[i][k] * n->side[k < 3 ? k : k + 3];
        worst = real_max(worst, fabs(sum));
    }
    return worst;
}

TEST(a_factor_serves_for_other_sides)
{
    uint64_t dice = 7;
    for (int i = 0; i < 20; i++) {
        Nodes n;
        open_nodes(&n, &dice);
        CHECK_NEAR(miss_of(&n, &dice, false), 0, 1e-10);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(miss_of(&n, &dice, true), 0, 1e-10);
    }
}

/* The single step is of order two, the composed one of order four. */
TEST(bricard_linkage_moves_and_converges_with_its_order)
{
    real coarse = bricard_error(1.0 / 60, "sketch"), fine = bricard_error(1.0 / 120, "sketch");
    CHECK(coarse < 3e-4);
    CHECK_NEAR(log2(coarse / fine), 2, 0.01);
    coarse = bricard_error(1.0 / 60, "play");
    fine = bricard_error(1.0 / 120, "play");
    CHECK(coarse < 1e-8);
    CHECK_NEAR(log2(coarse / fine), 4, 0.01);
}

/* B20. Forty rows on six freedoms: who bears what is not determined, but the sum is the weight and nothing is huge. */
static void check_door(const char *plan, bool traced, real off, real faster)
{
    dig_world *w = open_world(1.0 / 60, plan, true);
    dig_body_def d = ghost((vec3){0.5, 0, 0}, quat_identity(), 20);
    d.spin = y_axis;
    d.velocity = (vec3){0, 0, -0.5};
    dig_body door = add_body(w, d, "box", &(dig_box_def){{1, 2, 0.05}});
    dig_joint hinge[8];
    for (int i = 0; i < 8; i++)
        hinge[i] = join_bodies(w, "hinge", door, nobody, (vec3){0, -0.9 + i * 1.8 / 7, 0}, y_axis);
    for (int i = 0; i < 600; i++) {
        step(w, 1);
        if (traced)
            CHECK_INT(dig_world_stats(w).traced, 1);
        else
            check_conserved(w);
        real sum = 0;
        for (int k = 0; k < 8; k++) {
            dig_joint_state s;
            CHECK_INT(dig_joint_get(w, hinge[k], &s), DIG_OK);
            CHECK(vec3_length(s.force) < 100);
            sum += s.force.y;
        }
        CHECK_NEAR(sum, 20 * GRAVITY, off);
    }
    CHECK_NEAR(state_of(w, door).spin.y, 1, faster);
    dig_world_close(w);
}

TEST(door_on_eight_hinges_has_moderate_forces) { check_door("sketch", false, 2e-6, 2e-10); }

/* Its hinges are no loop that could pass a singular position. */
TEST(door_on_eight_hinges_is_traced) { check_door("play", true, 5e-9, 1e-11); }

/* ---- springs, sliders, lengths ---- */

/* B21. Masses and springs in a square grid, hung by its upper row. */
static void run_lattice(real stiffness, real damping, real tolerance)
{
    enum { N = 6 };
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body bob[N][N];
    for (int i = 0; i < N; i++)
        for (int k = 0; k < N; k++) {
            dig_body_def d = ghost((vec3){0.5 * i, -0.5 * k, 0}, quat_identity(), 1);
            d.fixed = k == 0;
            bob[i][k] = add_body(w, d, "sphere", &(dig_sphere_def){0.1});
        }
    for (int i = 0; i < N; i++)
        for (int k = 1; k < N; k++) {
            const Value s = {"stiffness", stiffness}, c = {"damping", damping};
            join_with(w, "spring", bob[i][k], bob[i][k - 1], vec3_zero(), x_axis, s, c);
            if (i > 0)
                join_with(w, "spring", bob[i][k], bob[i - 1][k], vec3_zero(), x_axis, s, c);
        }
    real lost = 0;
    for (int i = 0; i < 120; i++) {
        step(w, 1);
        check_conserved(w);
        dig_energy e = dig_world_energy(w);
        CHECK_NEAR(e.numerical, 0, tolerance);
        CHECK(e.lost >= lost - 1e-12);
        lost = e.lost;
    }
    CHECK((damping > 0) == (lost > 1e-3));
    dig_world_close(w);
}

TEST(spring_lattice_makes_no_energy_at_any_stiffness)
{
    run_lattice(1e4, 0, 2e-12);
    run_lattice(1e6, 0, 2e-12);
    run_lattice(1e8, 0, 2e-12);
}

TEST(dampers_lose_what_the_ledger_says) { run_lattice(1e4, 20, 2e-12); }

/* x = x0 cos(w t); the rule turns by 2 atan(w h / 2) a step instead of w h. */
TEST(mass_on_a_slider_with_a_spring_swings_with_the_phase_of_the_rule)
{
    const real h = 1.0 / 60, mass = 2, stiffness = 200;
    dig_world *w = open_world(h, "sketch", false);
    dig_body b = add_bob(w, vec3_zero(), mass, 0.1);
    dig_joint j = join_with(w, "slider", b, nobody, vec3_zero(), (vec3){0.6, 0.8, 0}, (Value){"spring.stiffness", stiffness}, (Value){"spring.rest", 0.3});
    const real turn = 2 * atan(0.5 * h * sqrt(stiffness / mass));
    for (int i = 1; i <= 200; i++) {
        step(w, 1);
        check_conserved(w);
        dig_joint_state s;
        CHECK_INT(dig_joint_get(w, j, &s), DIG_OK);
        CHECK_NEAR(s.distance, 0.3 * (1 - cos(turn * i)), 1e-13);
        CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-13);
    }
    dig_world_close(w);
}

static void close_by(dig_world *w, dig_body a, dig_body b, vec3 at)
{
    dig_body c = add_bob(w, at, 1, 0.1);
    join_bodies(w, "hinge", a, c, at, z_axis);
    join_bodies(w, "weld", b, c, at, z_axis);
}

/* A hinge with a torsion spring on a moving base: the discrete gradient of an angle. Closed: a third body between them. */
static void run_sprung_hinge(const char *plan, bool closed)
{
    dig_world *w = open_world(1.0 / 60, plan, false);
    dig_body a = add_rod(w, vec3_zero(), x_axis, 0.1);
    dig_body_def d = ghost((vec3){-0.4, 0.1, 0}, quat_identity(), 3);
    d.spin = (vec3){0.7, -0.4, 3};
    dig_body b = add_body(w, d, "box", &(dig_box_def){{0.8, 0.5, 0.3}});
    join_with(w, "hinge", a, b, vec3_zero(), z_axis, (Value){"spring.stiffness", 15}, (Value){"spring.rest", 1});
    if (closed)
        close_by(w, a, b, (vec3){0, 0, 0.5});
    step(w, 1);
    real e = dig_world_energy(w).total;
    vec3 l = dig_world_angular_momentum(w);
    for (int i = 0; i < 600; i++) {
        step(w, 1);
        check_conserved(w);
        CHECK_NEAR(dig_world_energy(w).total / e, 1, 3e-10);
        CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), l), 0, 1.2e-10);
    }
    dig_world_close(w);
}

TEST(sprung_hinge_between_free_bodies_keeps_energy_and_angular_momentum)
{
    run_sprung_hinge("sketch", false);          /* single steps */
    run_sprung_hinge("play", true);             /* composed ones */
}

TEST(distance_joints_and_welds_hold_in_a_swing)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    dig_body a = add_rod(w, x_axis, (vec3){2, 0, 0}, 0.1), b = add_rod(w, (vec3){2, 0, 0}, (vec3){2, 0, 1}, 0.1);
    dig_body bob = add_bob(w, (vec3){2, 1, 1}, 5, 0.1);
    join_bodies(w, "weld", a, b, (vec3){2, 0, 0}, z_axis);
    join_bodies(w, "ball", a, nobody, x_axis, z_axis);
    join_bodies(w, "distance", bob, a, vec3_zero(), z_axis);
    real e = dig_world_energy(w).total;
    real apart = vec3_distance(state_of(w, a).position, state_of(w, bob).position);
    for (int i = 0; i < 300; i++) {
        step(w, 1);
        check_conserved(w);
        CHECK_NEAR(vec3_distance(state_of(w, a).position, state_of(w, bob).position), apart, 2e-11);
        CHECK_NEAR(dig_world_stats(w).joint_error, 0, 4e-11);
        CHECK_NEAR(dig_world_energy(w).total, e, 2e-9);
    }
    dig_world_close(w);
}

/* ---- work from outside ---- */

/* What a driven body puts in through a joint is booked. */
TEST(driven_pivot_and_a_push_leave_a_balanced_ledger)
{
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    dig_body_def d = ghost(vec3_zero(), quat_identity(), NAN);
    d.kinematic = true;
    d.velocity = (vec3){0.5, 0.2, 0};
    d.spin = (vec3){0, 0.3, 0};
    dig_body pivot = add_body(w, d, "sphere", &(dig_sphere_def){0.1});
    dig_body rod = add_rod(w, vec3_zero(), x_axis, 0.1);
    join_bodies(w, "hinge", rod, pivot, vec3_zero(), z_axis);
    CHECK_INT(dig_body_push(w, rod, (vec3){0, 30, 5}, x_axis, true, 0.5), DIG_OK);
    for (int i = 0; i < 120; i++) {
        step(w, 1);
        check_conserved(w);
        CHECK_NEAR(dig_world_energy(w).numerical, 0, 3e-10);
        if (i == 0)         /* the rod was at rest: the pivot jerks it */
            CHECK(dig_world_energy(w).lost > 0.01);
    }
    CHECK(fabs(dig_world_energy(w).work_in) > 1);
    dig_world_close(w);
}

/* ---- what it leaves to others ---- */

static void check_swept(const dig_world *w)
{
    CHECK_INT(dig_world_stats(w).conserved, 0);
    CHECK_INT(dig_world_stats(w).swept, 1);
}

TEST(motors_and_friction_and_near_stops_and_contacts_are_left_to_the_sweep)
{
    const char *types[3] = {"hinge", "hinge", "rope"};      /* the rope is taut from the start */
    const Value cases[3] = {{"motor.speed", 1}, {"friction", 0.1}, {"length", 0.5}};
    for (int i = 0; i < 3; i++) {
        dig_world *w = open_world(1.0 / 60, "sketch", true);
        join_with(w, types[i], add_rod(w, vec3_zero(), x_axis, 0.1), nobody, vec3_zero(), z_axis, cases[i], (Value){0});
        step(w, 1);
        check_swept(w);
        dig_world_close(w);
    }
    dig_world *w = open_world(1.0 / 60, "sketch", true);
    add_floor(w, look(0.5, 0));
    dig_body_def d = body_with(look(0.5, 0), (vec3){0.5, 1, 0}, quat_identity());
    dig_body b = add_body(w, d, "box", &(dig_box_def){{1, 0.1, 0.1}});
    join_bodies(w, "hinge", b, nobody, (vec3){0, 1, 0}, z_axis);
    join_bodies(w, "ball", add_bob(w, (vec3){1, 1, 0}, 0.1, 0.05), b, (vec3){1, 1, 0}, z_axis);      /* alone it would be a pendulum */
    step(w, 1);
    check_conserved(w);
    int swept = 0;
    for (int i = 0; i < 300; i++) {
        step(w, 1);
        swept += dig_world_stats(w).swept;
    }
    CHECK(swept > 0);
    CHECK(state_of(w, b).position.y > 0.4);         /* the floor stops the rod */
    CHECK_INT(dig_world_stats(w).gave_up, 0);       /* handed on in time, before work was done in vain */
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(chain_with_a_thousand_times_its_link_keeps_length_and_energy_at_one_step_a_frame),
              unit_test(iterations_do_not_grow_with_the_chain), unit_test(free_chain_keeps_momentum_and_angular_momentum_to_rounding),
              unit_test(four_bar_loop_stays_in_its_plane_and_follows_its_equation), unit_test(four_bar_loop_is_traced_at_a_fine_tolerance),
              unit_test(precise_steps_take_three_iterations), unit_test(a_factor_serves_for_other_sides),
              unit_test(bricard_linkage_moves_and_converges_with_its_order), unit_test(door_on_eight_hinges_has_moderate_forces),
              unit_test(door_on_eight_hinges_is_traced),
              unit_test(spring_lattice_makes_no_energy_at_any_stiffness), unit_test(dampers_lose_what_the_ledger_says),
              unit_test(mass_on_a_slider_with_a_spring_swings_with_the_phase_of_the_rule),
              unit_test(sprung_hinge_between_free_bodies_keeps_energy_and_angular_momentum),
              unit_test(distance_joints_and_welds_hold_in_a_swing), unit_test(driven_pivot_and_a_push_leave_a_balanced_ledger),
              unit_test(motors_and_friction_and_near_stops_and_contacts_are_left_to_the_sweep));
}
