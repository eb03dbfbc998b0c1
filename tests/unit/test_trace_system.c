/* tests/unit/test_trace_system.c - the direct solve A x = b of the traced way, and the rows of a contact patch.
 *
 * Reference for the solve: the same matrix multiplied out densely, by Gaussian elimination with partial pivoting. Reference for the
 * patch: the balance of force and torque of a rigid body at rest, by hand.
 */
#include "trace_fixture.h"

enum { N = 24, BODIES = 8, DOF = 6 * BODIES };

/* ---- a system of random rows ---- */

typedef struct Bench {
    System s;
    Line   lines[N + 1];
    real   a[(N + 1) * (N + 1)], f[(N + 1) * (N + 1)], b[N + 1], x[N + 1], r[N + 1], dx[N + 1];
    int    first[N + 1], swap[N + 1], run[N + 1];
    real   im[BODIES];
    mat3   ii[BODIES];
    real   dense[N][N];         /* J M^-1 G, multiplied out */
} Bench;

static void bench_open(Bench *t, Dice *d)
{
    memset(t, 0, sizeof *t);
    t->s = (System){.capacity = N, .lines = t->lines, .a = t->a, .f = t->f, .b = t->b, .x = t->x, .r = t->r, .dx = t->dx,
                    .first = t->first, .swap = t->swap, .run = t->run};
    for (int i = 0; i < BODIES; i++) {
        t->im[i] = dice_in(d, 0.2, 3);
        mat3 r = quat_matrix(dice_quat(d)), m = mat3_diagonal((vec3){dice_in(d, 0.5, 4), dice_in(d, 0.5, 4), dice_in(d, 0.5, 4)});
        t->ii[i] = mat3_mul(mat3_mul(r, m), mat3_transpose(r));
    }
}

static void put_body(Bench *t, Line *l, int body, vec3 lin, vec3 ang, vec3 glin, vec3 gang)
{
    int k = l->count++;
    l->body[k] = body;
    l->j[k].lin = lin;
    l->j[k].ang = ang;
    l->gang[k] = gang;
    l->m[k].lin = vec3_scale(t->im[body], glin);
    l->m[k].ang = mat3_mul_vec(t->ii[body], gang);
}

/* slide: how far G departs from the transpose of J */
static void add_row(Bench *t, Dice *d, int a, int b, real slide)
{
    Line *l = &t->lines[t->s.count++];
    for (int k = 0; k < 2; k++) {
        vec3 lin = dice_vec(d), ang = dice_vec(d);
        put_body(t, l, k ? b : a, lin, ang, vec3_mad(lin, slide, dice_vec(d)), vec3_mad(ang, slide, dice_vec(d)));
    }
    t->s.sliding = t->s.sliding || slide != 0;
}

static void spread(const Line *l, bool mass, real row[DOF])
{
    memset(row, 0, DOF * sizeof *row);
    for (int k = 0; k < l->count; k++) {
        vec3 v[2] = {mass ? l->m[k].lin : l->j[k].lin, mass ? l->m[k].ang : l->j[k].ang};
        for (int i = 0; i < 6; i++)
            row[6 * l->body[k] + i] += vec3_at(v[i / 3], i % 3);
    }
}

static void multiply_out(Bench *t)
{
    for (int i = 0; i < t->s.count; i++)
        for (int k = 0; k < t->s.count; k++) {
            real j[DOF], mg[DOF];
            spread(&t->lines[i], false, j);
            spread(&t->lines[k], true, mg);
            t->dense[i][k] = 0;
            for (int m = 0; m < DOF; m++)
                t->dense[i][k] += j[m] * mg[m];
        }
}

static void eliminate(real a[N][N], int n, real *b)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int k = i + 1; k < n; k++)
            if (fabs(a[k][i]) > fabs(a[best][i]))
                best = k;
        real keep = b[i];
        b[i] = b[best];
        b[best] = keep;
        for (int m = 0; m < n; m++) {
            keep = a[i][m];
            a[i][m] = a[best][m];
            a[best][m] = keep;
        }
        for (int k = i + 1; k < n; k++) {
            real l = a[k][i] / a[i][i];
            for (int m = i; m < n; m++)
                a[k][m] -= l * a[i][m];
            b[k] -= l * b[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
}

static real largest(const real *v, int n)
{
    real most = 0;
    for (int i = 0; i < n; i++)
        most = real_max(most, fabs(v[i]));
    return most;
}

/* Largest entry of b - A x with the dense matrix, over the largest of b. */
static real remainder_over(const Bench *t)
{
    int n = t->s.count;
    real r[N];
    for (int i = 0; i < n; i++) {
        r[i] = t->b[i];
        for (int k = 0; k < n; k++)
            r[i] -= t->dense[i][k] * t->x[k];
    }
    return largest(r, n) / largest(t->b, n);
}

static void check_against_elimination(Bench *t, Dice *d, real tolerance)
{
    int n = t->s.count;
    real want[N], a[N][N];
    for (int i = 0; i < n; i++)
        want[i] = t->b[i] = dice(d);
    multiply_out(t);
    memcpy(a, t->dense, sizeof a);
    eliminate(a, n, want);
    CHECK(system_factor(&t->s));
    CHECK(!t->s.redundant);
    CHECK(system_solve(&t->s, 1e-2));
    CHECK(t->s.residual < 1e-12);
    CHECK(remainder_over(t) < 1e-12);
    for (int i = 0; i < n; i++)
        CHECK_NEAR(t->x[i], want[i], tolerance * largest(want, n));
}

TEST(a_symmetric_system_has_the_solution_of_gaussian_elimination)
{
    Dice d = {1};
    for (int round = 0; round < 200; round++) {
        Bench t;
        bench_open(&t, &d);
        int rows = 1 + round % N;
        for (int i = 0; i < rows; i++)
            add_row(&t, &d, i % BODIES, (i + 1 + i / BODIES) % BODIES, 0);
        check_against_elimination(&t, &d, 1e-10);
    }
}

TEST(an_unsymmetric_system_has_the_solution_of_gaussian_elimination)
{
    Dice d = {2};
    for (int round = 0; round < 200; round++) {
        Bench t;
        bench_open(&t, &d);
        int rows = 1 + round % N;
        for (int i = 0; i < rows; i++)
            add_row(&t, &d, i % BODIES, (i + 1 + i / BODIES) % BODIES, 0.2);
        check_against_elimination(&t, &d, 1e-9);
    }
}

TEST(rows_in_order_along_a_chain_are_factored_within_a_narrow_profile)
{
    Dice d = {3};
    Bench t;
    bench_open(&t, &d);
    for (int body = 0; body + 1 < BODIES; body++)
        for (int k = 0; k < 3; k++)
            add_row(&t, &d, body, body + 1, 0);
    check_against_elimination(&t, &d, 1e-10);
    for (int i = 0; i < t.s.count; i++)
        CHECK_INT(t.first[i], i < 3 ? 0 : 3 * (i / 3 - 1));     /* the first row of the body before */
}

/* ---- rows that repeat others ---- */

/* Four springless legs under a table: unit forces along y at (+-x, +-z); any height, tilt and turn repeats (1, -1, 1, -1). */
static void add_legs(Bench *t, real x, real z)
{
    static const real sx[4] = {-1, 1, 1, -1}, sz[4] = {-1, -1, 1, 1};
    for (int i = 0; i < 4; i++) {
        Line *l = &t->lines[t->s.count++];
        vec3 up = {0, 1, 0}, arm = vec3_cross((vec3){sx[i] * x, 0, sz[i] * z}, up);
        put_body(t, l, 0, up, arm, up, arm);
    }
}

TEST(four_corners_share_the_load_with_least_norm)
{
    Dice d = {4};
    for (int round = 0; round < 100; round++) {
        Bench t;
        bench_open(&t, &d);
        t.ii[0] = mat3_diagonal((vec3){dice_in(&d, 0.5, 4), 1, dice_in(&d, 0.5, 4)});
        add_legs(&t, dice_in(&d, 0.2, 2), dice_in(&d, 0.2, 2));
        multiply_out(&t);
        real y[4];
        for (int i = 0; i < 4; i++)
            y[i] = dice_in(&d, 1, 10);
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 4; k++)
                t.b[i] += t.dense[i][k] * y[k];
        real off = (y[0] - y[1] + y[2] - y[3]) / 4;
        CHECK(system_factor(&t.s));
        CHECK(t.s.redundant);
        CHECK(system_solve(&t.s, 1e-2));
        CHECK(t.s.residual < 1e-12);
        CHECK(remainder_over(&t) < 1e-12);
        for (int i = 0; i < 4; i++)         /* what lies along the repetition is taken off */
            CHECK_NEAR(t.x[i], y[i] - (i % 2 ? -off : off), 1e-7 * 10);
    }
}

TEST(a_row_stated_three_times_holds_a_third_each)
{
    Dice d = {5};
    for (int round = 0; round < 100; round++) {
        Bench t;
        bench_open(&t, &d);
        for (int i = 0; i < 10; i++)
            add_row(&t, &d, i % BODIES, (i + 1) % BODIES, 0);
        for (int i = 0; i < 2; i++)
            t.lines[t.s.count++] = t.lines[4];
        real want[N], a[N][N];
        for (int i = 0; i < 10; i++)
            want[i] = t.b[i] = dice(&d);
        t.b[10] = t.b[11] = t.b[4];
        multiply_out(&t);
        memcpy(a, t.dense, sizeof a);
        eliminate(a, 10, want);
        CHECK(system_factor(&t.s));
        CHECK(t.s.redundant);
        CHECK(system_solve(&t.s, 1e-2));
        CHECK(remainder_over(&t) < 1e-11);
        real most = largest(want, 10);
        for (int i = 0; i < 12; i++) {
            bool third = i == 4 || i >= 10;
            CHECK_NEAR(t.x[i], third ? want[4] / 3 : want[i], 1e-6 * most);
        }
    }
}

/* As the hinges of a door. */
TEST(four_rows_on_the_same_bodies_stated_five_times_hold_a_fifth_each)
{
    Dice d = {8};
    for (int round = 0; round < 100; round++) {
        Bench t;
        bench_open(&t, &d);
        for (int i = 0; i < 4; i++)
            add_row(&t, &d, 0, 1, 0);
        for (int i = 4; i < 20; i++)
            t.lines[t.s.count++] = t.lines[i % 4];
        real want[N], a[N][N];
        for (int i = 0; i < 20; i++)
            want[i] = t.b[i] = i < 4 ? dice(&d) : t.b[i % 4];
        multiply_out(&t);
        memcpy(a, t.dense, sizeof a);
        eliminate(a, 4, want);
        CHECK(system_factor(&t.s));
        CHECK_INT(t.s.rank, 4);
        CHECK(system_solve(&t.s, 1e-2));
        CHECK(remainder_over(&t) < 1e-11);
        real most = largest(want, 4);
        for (int i = 0; i < 20; i++)
            CHECK_NEAR(t.x[i], want[i % 4] / 5, 1e-10 * most);
    }
}

TEST(unsymmetric_rows_that_repeat_are_solved_too)
{
    Dice d = {6};
    for (int round = 0; round < 100; round++) {
        Bench t;
        bench_open(&t, &d);
        for (int i = 0; i < 9; i++)
            add_row(&t, &d, i % BODIES, (i + 1) % BODIES, 0.2);
        t.lines[t.s.count++] = t.lines[3];
        for (int i = 0; i < 9; i++)
            t.b[i] = dice(&d);
        t.b[9] = t.b[3];
        multiply_out(&t);
        CHECK(system_factor(&t.s));
        CHECK(t.s.redundant);
        CHECK(system_solve(&t.s, 1e-2));
        CHECK(remainder_over(&t) < 1e-10);
    }
}

TEST(repeated_rows_that_contradict_each_other_are_refused_beyond_what_drift_may_do)
{
    Dice d = {7};
    for (int sliding = 0; sliding < 2; sliding++) {
        real apart[] = {1e-6, 1e-3, 0.5, 2};
        for (int i = 0; i < 4; i++) {
            Bench t;
            bench_open(&t, &d);
            for (int k = 0; k < 4; k++)
                add_row(&t, &d, k, k + 1, sliding ? 0.2 : 0);
            t.lines[t.s.count++] = t.lines[2];
            for (int k = 0; k < 5; k++)
                t.b[k] = 1;
            t.b[4] = 1 - apart[i];
            CHECK(system_factor(&t.s));
            CHECK(t.s.redundant);
            bool accepted = system_solve(&t.s, 1e-2);
            if (accepted != (apart[i] < 1e-2))
                fail_msg("rows that differ by %g of the right side: %s", apart[i], accepted ? "accepted" : "refused");
            CHECK_NEAR(t.s.residual, apart[i] / 2 / largest(t.b, 5), 1e-3 * apart[i]);      /* met half-way */
            CHECK(system_solve(&t.s, INFINITY));
        }
    }
}

TEST(no_right_side_means_no_forces_and_no_numbers_mean_no_solution)
{
    Dice d = {8};
    Bench t;
    bench_open(&t, &d);
    add_row(&t, &d, 0, 1, 0);
    add_row(&t, &d, 1, 2, 0);
    CHECK(system_factor(&t.s));
    t.x[0] = t.x[1] = 7;
    CHECK(system_solve(&t.s, 1e-2));
    CHECK_NEAR(t.x[0], 0, 0);
    CHECK_NEAR(t.x[1], 0, 0);
    t.b[0] = INFINITY;
    CHECK(!system_solve(&t.s, 1e-2));
    t.b[0] = t.b[1] = NAN;
    CHECK(!system_solve(&t.s, 1e-2));
    t.b[0] = NAN;
    t.b[1] = 1;
    CHECK(!system_solve(&t.s, 1e-2));
}

/* ---- a box on a plane ---- */

typedef struct Table {
    Hand h;
    vec3 half, ex, ey, ez, reach;       /* m; axes of the plane in world axes; push: where, from the centre */
    real mass, weight;                  /* kg, N */
} Table;

/* A box at rest on a plane through the origin, turned any way, gravity against the plane's normal. pressing: bits of corners. */
static void table_open(Table *t, Dice *d, int pressing, bool sticks)
{
    Hand *h = &t->h;
    hand_open(h, 1, 2);
    t->half = (vec3){dice_in(d, 0.3, 1), dice_in(d, 0.2, 0.6), dice_in(d, 0.3, 1)};
    t->mass = dice_in(d, 1, 5);
    t->weight = 9.81 * t->mass;
    quat turn = dice_quat(d);
    t->ex = quat_rotate(turn, (vec3){1, 0, 0});
    t->ey = quat_rotate(turn, (vec3){0, 1, 0});
    t->ez = quat_rotate(turn, (vec3){0, 0, 1});
    vec3 s = t->half;
    hand_mass(h, 0, t->mass, vec3_scale(t->mass / 3, (vec3){s.y * s.y + s.z * s.z, s.x * s.x + s.z * s.z, s.x * s.x + s.y * s.y}));
    h->g.gravity = vec3_scale(-9.81, t->ey);
    h->pos[0] = (Pos){vec3_scale(s.y, t->ey), turn};
    group_refresh_mass(&h->g, 0);
    h->g.contact_count = 1;
    hand_trace(h);
    static const real sx[4] = {-1, 1, 1, -1}, sz[4] = {-1, -1, 1, 1};
    for (int i = 0; i < 4; i++) {
        Touching *c = &h->t.touch[h->t.touch_count++];
        *c = (Touching){.a = 1, .b = 0, .point = i, .id = (uint32_t)i, .feature = {.kind = PLANE_POINT}};
        c->feature.pb = (vec3){sx[i] * s.x, -s.y, sz[i] * s.z};
        c->feature.da = t->ey;
        c->gate.closed = c->gate.presses = pressing >> i & 1;
        c->slip = (Cone){.axes = sticks ? 2 : 0, .grip = GRIP_STICK, .still = 0.5, .moving = 0.4, .weight = 1};
        c->roll.weight = 1;
    }
}

static void push(Table *t, vec3 force, vec3 at)        /* both in the box's axes */
{
    Hand *h = &t->h;
    h->g.push_count = 1;
    h->pushes[0] = (GroupPush){.body = 0, .force = quat_rotate(h->pos[0].q, force), .at = at, .has_at = true};
}

static void accelerate(Table *t)
{
    trace_store(&t->h.t, t->h.t.y);
    trace_kinematics(&t->h.t);
    CHECK(trace_items(&t->h.t));
    if (!trace_accelerate(&t->h.t))
        fail_msg("%s", t->h.t.fault);
}

static real along(vec3 v, vec3 d) { return vec3_dot(v, d); }

/* Newton and Euler, with the accelerations found and the forces shared out, and what presses does not move. */
static void check_balance(const Table *t)
{
    const Hand *h = &t->h;
    vec3 force = vec3_scale(t->mass, h->g.gravity), torque = vec3_zero();
    for (int i = 0; i < h->g.push_count; i++) {
        force = vec3_add(force, h->pushes[i].force);
        torque = vec3_add(torque, vec3_cross(quat_rotate(h->pos[0].q, h->pushes[i].at), h->pushes[i].force));
    }
    for (int i = 0; i < 4; i++) {
        const Touching *c = &h->t.touch[i];
        if (!c->gate.presses) {
            CHECK_NEAR(c->gate.force, 0, 0);
            continue;
        }
        vec3 f = vec3_add(vec3_scale(c->gate.force, c->k.n), c->slip.force);
        force = vec3_add(force, f);
        torque = vec3_add(torque, vec3_cross(vec3_sub(c->k.at, h->pos[0].x), f));
        CHECK_NEAR(c->gate.acc, 0, 1e-11);
        if (c->slip.axes && c->slip.grip == GRIP_STICK)
            CHECK_NEAR(vec3_length(c->slip.acc), 0, 1e-11);
    }
    vec3 w = h->vel[0].w, l = quat_rotate(h->pos[0].q, mat3_mul_vec(*h->member[0].inertia, quat_unrotate(h->pos[0].q, w)));
    vec3 a = vec3_scale(1 / t->mass, force), alpha = mat3_mul_vec(h->mass[0].ii, vec3_sub(torque, vec3_cross(w, l)));
    CHECK_NEAR(vec3_distance(h->t.acc[0], a), 0, 1e-11);
    CHECK_NEAR(vec3_distance(h->t.alpha[0], alpha), 0, 1e-11);
}

/* Closed form: with the friction at floor level, a push P at height y tips the load by M = P y about the floor, and
 * N_i = W/4 + x_i Mx / sum x^2 + z_i Mz / sum z^2. The tangential forces are a shift and a turn, T_i = t + k n x r_i. */
TEST(four_corners_that_stick_carry_weight_and_push_as_a_plane_over_the_patch)
{
    Dice d = {11};
    for (int round = 0; round < 100; round++) {
        Table t;
        table_open(&t, &d, 15, true);
        vec3 force = vec3_scale(0.3 * t.weight, dice_vec(&d)), at = vec3_mul(t.half, dice_vec(&d));
        push(&t, force, at);
        accelerate(&t);
        check_balance(&t);
        const Tracer *s = &t.h.t;
        CHECK_NEAR(vec3_length(s->acc[0]), 0, 1e-11);
        CHECK_NEAR(vec3_length(s->alpha[0]), 0, 1e-11);
        real high = at.y + t.half.y, load = t.weight - force.y, x2 = 4 * t.half.x * t.half.x, z2 = 4 * t.half.z * t.half.z;
        real mx = force.x * high - force.y * at.x, mz = force.z * high - force.y * at.z;        /* of the load, about the patch */
        real yaw = at.z * force.x - at.x * force.z;                                             /* about ey */
        for (int i = 0; i < 4; i++) {
            vec3 r = s->touch[i].feature.pb, got = s->touch[i].slip.force;
            CHECK_NEAR(s->touch[i].gate.force, load / 4 + r.x * mx / x2 + r.z * mz / z2, 1e-10 * t.weight);
            CHECK_NEAR(along(got, t.ex), -force.x / 4 - yaw / (x2 + z2) * r.z, 1e-10 * t.weight);
            CHECK_NEAR(along(got, t.ez), -force.z / 4 + yaw / (x2 + z2) * r.x, 1e-10 * t.weight);
            CHECK_NEAR(along(got, t.ey), 0, 1e-10 * t.weight);
        }
        hand_close(&t.h);
    }
}

TEST(any_set_of_corners_that_presses_does_not_move_and_the_body_obeys_newton)
{
    Dice d = {12};
    for (int pressing = 0; pressing < 16; pressing++)
        for (int round = 0; round < 20; round++) {
            Table t;
            table_open(&t, &d, pressing, round % 2);
            push(&t, vec3_scale(0.5 * t.weight, dice_vec(&d)), vec3_mul(t.half, dice_vec(&d)));
            accelerate(&t);
            check_balance(&t);
            hand_close(&t.h);
        }
}

/* Two points whose normals are equal to the last digit have rows of their own. A tilt of 1e-10 leads the other way, to the same forces. */
TEST(an_edge_shares_its_forces_as_any_patch_does)
{
    Dice d = {19};
    for (int round = 0; round < 100; round++) {
        static const int two[] = {1 + 2, 1 + 4, 2 + 4, 4 + 8};
        Table t;
        table_open(&t, &d, two[round % 4], round % 3 != 0);
        push(&t, vec3_scale(0.5 * t.weight, dice_vec(&d)), vec3_mul(t.half, dice_vec(&d)));
        Touching *touch = t.h.t.touch;
        for (int i = 0; i < 4; i++)
            touch[i].slip.weight = dice_in(&d, 0.1, 1);
        accelerate(&t);
        Touching edge[4];
        memcpy(edge, touch, sizeof edge);
        int rows = t.h.t.sys.count, last = two[round % 4] & 8 ? 3 : two[round % 4] & 4 ? 2 : 1;
        touch[last].feature.da = vec3_unit(vec3_mad(t.ey, 1e-10, t.ex));
        accelerate(&t);
        CHECK_INT(t.h.t.sys.count, rows);
        for (int i = 0; i < 4; i++) {
            CHECK_NEAR(touch[i].gate.force, edge[i].gate.force, 1e-7 * t.weight);
            CHECK_NEAR(vec3_distance(touch[i].slip.force, edge[i].slip.force), 0, 1e-7 * t.weight);
        }
        hand_close(&t.h);
    }
}

/* They have no turn to hold, and no size to divide by: as one they do. */
TEST(corners_at_the_same_place_act_as_one)
{
    Dice d = {20};
    for (int round = 0; round < 20; round++) {
        Table t;
        table_open(&t, &d, 1 + 2, true);
        t.h.t.touch[1].feature.pb = t.h.t.touch[0].feature.pb;
        push(&t, vec3_scale(0.2 * t.weight, dice_vec(&d)), vec3_mul(t.half, dice_vec(&d)));
        accelerate(&t);
        check_balance(&t);
        CHECK_NEAR(t.h.t.touch[0].gate.force, t.h.t.touch[1].gate.force, 1e-10 * t.weight);
        CHECK_NEAR(vec3_distance(t.h.t.touch[0].slip.force, t.h.t.touch[1].slip.force), 0, 1e-10 * t.weight);
        hand_close(&t.h);
    }
}

/* On one edge the box stands on two points and tips about them: a pendulum upside down. */
TEST(a_box_held_at_two_corners_tips_about_their_edge)
{
    Dice d = {13};
    Table t;
    table_open(&t, &d, 2 + 4, true);                    /* the corners with x > 0 */
    accelerate(&t);
    check_balance(&t);
    real arm2 = t.half.x * t.half.x + t.half.y * t.half.y, inertia = t.mass * arm2 * 4 / 3;
    CHECK_NEAR(vec3_distance(t.h.t.alpha[0], vec3_scale(t.weight * t.half.x / inertia, t.ez)), 0, 1e-11);
    CHECK_NEAR(t.h.t.touch[1].gate.force, t.h.t.touch[2].gate.force, 1e-11);
    hand_close(&t.h);
}

/* Friction mu N against the slip at floor level: a = -mu g, and the load leans forward by mu W times the height of the centre. */
TEST(a_sliding_box_slows_by_mu_g_and_leans_on_its_front_corners)
{
    Dice d = {14};
    for (int round = 0; round < 50; round++) {
        Table t;
        table_open(&t, &d, 15, true);
        real heading = dice_in(&d, 0, 6.28), c = cos(heading), s = sin(heading), mu = 0.2;
        vec3 way = vec3_mad(vec3_scale(c, t.ex), s, t.ez);
        t.h.vel[0].v = vec3_scale(2, way);
        for (int i = 0; i < 4; i++) {
            t.h.t.touch[i].slip.grip = GRIP_SLIP;
            t.h.t.touch[i].slip.moving = mu;
            t.h.t.touch[i].slip.d = way;
        }
        accelerate(&t);
        check_balance(&t);
        CHECK(t.h.t.sys.sliding);
        CHECK_NEAR(vec3_distance(t.h.t.acc[0], vec3_scale(-9.81 * mu, way)), 0, 1e-11);
        CHECK_NEAR(vec3_length(t.h.t.alpha[0]), 0, 1e-11);
        real lean = mu * t.weight * t.half.y;
        for (int i = 0; i < 4; i++) {
            vec3 r = t.h.t.touch[i].feature.pb;
            real want = t.weight / 4 + lean * (c * r.x / (4 * t.half.x * t.half.x) + s * r.z / (4 * t.half.z * t.half.z));
            CHECK_NEAR(t.h.t.touch[i].gate.force, want, 1e-10 * t.weight);
            CHECK_NEAR(vec3_distance(t.h.t.touch[i].slip.force, vec3_scale(-mu * want, way)), 0, 1e-10 * t.weight);
        }
        hand_close(&t.h);
    }
}

/* The kinds by themselves: below the cone it sticks, beyond it slides; a corner the push would lift opens. */
TEST(kinds_are_found_from_the_forces)
{
    Dice d = {15};
    for (int round = 0; round < 50; round++) {
        Table t;
        table_open(&t, &d, 15, true);
        real part = round % 2 ? 0.49 : 0.51;            /* of the weight; static friction 0.5, dynamic 0.4 */
        push(&t, (vec3){part * t.weight, 0, 0}, (vec3){0, -t.half.y, 0});       /* at floor level: it does not tip */
        trace_kinematics(&t.h.t);
        CHECK(trace_items(&t.h.t));
        if (!trace_kinds(&t.h.t, false))
            fail_msg("%s", t.h.t.fault);
        check_balance(&t);
        CHECK_NEAR(vec3_distance(t.h.t.acc[0], vec3_scale(part > 0.5 ? 9.81 * (part - 0.4) : 0, t.ex)), 0, 1e-9);
        for (int i = 0; i < 4; i++) {
            CHECK(t.h.t.touch[i].gate.presses);
            CHECK_INT(t.h.t.touch[i].slip.grip, part > 0.5 ? GRIP_SLIP : GRIP_STICK);
            /* what speeds up leans back */
            real back = part > 0.5 ? (part - 0.4) * t.weight * t.half.y : 0, x = t.h.t.touch[i].feature.pb.x;
            CHECK_NEAR(t.h.t.touch[i].gate.force, t.weight / 4 - back * x / (4 * t.half.x * t.half.x), 1e-9 * t.weight);
        }
        hand_close(&t.h);
        table_open(&t, &d, 15, true);
        push(&t, (vec3){0, 0.6 * t.weight, 0}, (vec3){t.half.x, t.half.y, 0});      /* tips it over the edge at x < 0 */
        trace_kinematics(&t.h.t);
        CHECK(trace_items(&t.h.t));
        if (!trace_kinds(&t.h.t, false))
            fail_msg("%s", t.h.t.fault);
        check_balance(&t);
        for (int i = 0; i < 4; i++) {
            bool back = t.h.t.touch[i].feature.pb.x < 0;
            CHECK_INT(t.h.t.touch[i].gate.presses, back);
            if (!back)
                CHECK(t.h.t.touch[i].gate.acc > 0);
        }
        hand_close(&t.h);
    }
}

/* Forces that were found hold as long as nothing asks for others: a part in a million more or less of one of them does. */
TEST(forces_that_still_hold_are_told_from_those_that_do_not)
{
    Dice d = {16};
    for (int round = 0; round < 50; round++) {
        Table t;
        bool slides = round % 2;
        table_open(&t, &d, 15, true);
        push(&t, vec3_scale(slides ? 0.1 : 0.3, (vec3){t.weight, 0, 0}), (vec3){0, -t.half.y, 0});
        t.h.vel[0].v = vec3_scale(slides ? 2 : 0, t.ex);
        for (int i = 0; i < 4 && slides; i++)           /* so little that no corner lifts */
            t.h.t.touch[i].slip.still = t.h.t.touch[i].slip.moving = 0.02;
        trace_kinematics(&t.h.t);
        CHECK(trace_items(&t.h.t));
        CHECK(!trace_again(&t.h.t));                    /* none yet */
        CHECK(trace_kinds(&t.h.t, false));
        vec3 acc = t.h.t.acc[0], alpha = t.h.t.alpha[0];
        CHECK(trace_again(&t.h.t));
        CHECK_NEAR(vec3_distance(t.h.t.acc[0], acc), 0, 1e-13);
        CHECK_NEAR(vec3_distance(t.h.t.alpha[0], alpha), 0, 1e-12);
        Touching *c = &t.h.t.touch[round % 4];
        c->gate.force *= 1 + 1e-6;
        CHECK(!trace_again(&t.h.t));
        c->gate.force /= 1 + 1e-6;
        c->slip.force = vec3_mad(c->slip.force, 1e-6 * t.weight, t.ez);
        CHECK(!trace_again(&t.h.t));
        c->slip.force = vec3_mad(c->slip.force, -1e-6 * t.weight, t.ez);
        c->slip.still = c->slip.moving = slides ? 0.3 : 0.25;      /* another friction */
        CHECK(!trace_again(&t.h.t));
        hand_close(&t.h);
    }
}

/* Rows that were noted serve where the box went on as it was, whatever pushes it there; where anything of theirs is another, they do not. */
TEST(rows_serve_as_long_as_nothing_of_theirs_has_changed)
{
    Dice d = {17};
    for (int round = 0; round < 50; round++) {
        Table t;
        bool slides = round % 2;
        table_open(&t, &d, 15, true);
        t.h.vel[0].v = vec3_scale(slides ? 2 : 0, t.ex);
        for (int i = 0; i < 4 && slides; i++) {
            t.h.t.touch[i].slip.grip = GRIP_SLIP;
            t.h.t.touch[i].slip.moving = 0.2;
            t.h.t.touch[i].slip.d = t.ex;
        }
        accelerate(&t);
        CHECK(trace_rows_stay(&t.h.t));
        t.h.pos[0].x = vec3_mad(t.h.pos[0].x, 1e-3, t.ex);
        push(&t, vec3_scale(0.1 * t.weight, dice_unit(&d)), dice_vec(&d));
        trace_kinematics(&t.h.t);
        CHECK(trace_rows_stay(&t.h.t));
        CHECK(trace_accelerate(&t.h.t));
        check_balance(&t);
        vec3 acc = t.h.t.acc[0], alpha = t.h.t.alpha[0];
        t.h.t.noted = false;
        CHECK(trace_accelerate(&t.h.t));
        CHECK_NEAR(vec3_distance(t.h.t.acc[0], acc), 0, 1e-12);
        CHECK_NEAR(vec3_distance(t.h.t.alpha[0], alpha), 0, 1e-11);
        Touching *c = &t.h.t.touch[round % 4];
        c->gate.presses = false;
        CHECK(!trace_rows_stay(&t.h.t));
        c->gate.presses = true;
        CHECK(trace_accelerate(&t.h.t));
        CHECK(trace_rows_stay(&t.h.t));
        c->slip.weight *= 0.5;
        CHECK(!trace_rows_stay(&t.h.t));
        c->slip.weight *= 2;
        CHECK(trace_accelerate(&t.h.t));
        c->slip.d = vec3_unit(vec3_mad(c->slip.d, 1e-9, t.ez));
        CHECK_INT(trace_rows_stay(&t.h.t), !slides);
        CHECK(trace_accelerate(&t.h.t));
        t.h.pos[0].q = quat_unit(quat_mul(quat_exp(vec3_scale(1e-9, dice_unit(&d))), t.h.pos[0].q));
        CHECK(!trace_rows_stay(&t.h.t));
        hand_close(&t.h);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(a_symmetric_system_has_the_solution_of_gaussian_elimination),
              unit_test(an_unsymmetric_system_has_the_solution_of_gaussian_elimination),
              unit_test(rows_in_order_along_a_chain_are_factored_within_a_narrow_profile),
              unit_test(four_corners_share_the_load_with_least_norm),
              unit_test(a_row_stated_three_times_holds_a_third_each),
              unit_test(four_rows_on_the_same_bodies_stated_five_times_hold_a_fifth_each),
              unit_test(unsymmetric_rows_that_repeat_are_solved_too),
              unit_test(repeated_rows_that_contradict_each_other_are_refused_beyond_what_drift_may_do),
              unit_test(no_right_side_means_no_forces_and_no_numbers_mean_no_solution),
              unit_test(four_corners_that_stick_carry_weight_and_push_as_a_plane_over_the_patch),
              unit_test(any_set_of_corners_that_presses_does_not_move_and_the_body_obeys_newton),
              unit_test(a_box_held_at_two_corners_tips_about_their_edge),
              unit_test(corners_at_the_same_place_act_as_one),
              unit_test(an_edge_shares_its_forces_as_any_patch_does),
              unit_test(rows_serve_as_long_as_nothing_of_theirs_has_changed),
              unit_test(forces_that_still_hold_are_told_from_those_that_do_not),
              unit_test(a_sliding_box_slows_by_mu_g_and_leans_on_its_front_corners),
              unit_test(kinds_are_found_from_the_forces));
}
