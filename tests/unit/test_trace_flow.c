/* tests/unit/test_trace_flow.c - the traced way's integration in time: the pair of Runge-Kutta formulas, its order, its error estimate
 * and dense output, and free flight.
 *
 * References: the order conditions of Butcher's trees; a pendulum and a free rotor integrated in long double with steps so small that
 * their error is below the rounding of double; the rotor of the acceptance suite, from Jacobi's elliptic functions.
 */
#include "trace_fixture.h"

#include "physics_fixture.h"

/* ---- the table ---- */

typedef struct Condition { real got, want; const char *name; } Condition;

static void apply(const real v[STAGES], real out[STAGES])
{
    for (int i = 0; i < STAGES; i++) {
        out[i] = 0;
        for (int k = 0; k < STAGES - 1; k++)
            out[i] += dormand_prince[i][k] * v[k];
    }
}

static real weigh(const real v[STAGES])
{
    real sum = 0;
    for (int i = 0; i < STAGES - 1; i++)
        sum += dormand_prince[STAGES - 1][i] * v[i];
    return sum;
}

static void times(const real a[STAGES], const real b[STAGES], real out[STAGES])
{
    for (int i = 0; i < STAGES; i++)
        out[i] = a[i] * b[i];
}

TEST(the_table_meets_all_seventeen_order_conditions_up_to_five)
{
    real one[STAGES] = {1, 1, 1, 1, 1, 1, 1}, c[STAGES], c2[STAGES], c3[STAGES], c4[STAGES], ac[STAGES], ac2[STAGES], ac3[STAGES];
    real aac[STAGES], aac2[STAGES], aaac[STAGES], cac[STAGES], acac[STAGES], c2ac[STAGES], cac2[STAGES], caac[STAGES], acac_product[STAGES];
    apply(one, c);
    times(c, c, c2);
    times(c2, c, c3);
    times(c3, c, c4);
    apply(c, ac);
    apply(c2, ac2);
    apply(c3, ac3);
    apply(ac, aac);
    apply(ac2, aac2);
    apply(aac, aaac);
    times(c, ac, cac);
    apply(cac, acac);
    times(c2, ac, c2ac);
    times(c, ac2, cac2);
    times(c, aac, caac);
    times(ac, ac, acac_product);
    const Condition trees[] = {
        {weigh(one), 1, "1"}, {weigh(c), 1.0 / 2, "c"},
        {weigh(c2), 1.0 / 3, "c^2"}, {weigh(ac), 1.0 / 6, "Ac"},
        {weigh(c3), 1.0 / 4, "c^3"}, {weigh(cac), 1.0 / 8, "c Ac"}, {weigh(ac2), 1.0 / 12, "Ac^2"}, {weigh(aac), 1.0 / 24, "AAc"},
        {weigh(c4), 1.0 / 5, "c^4"}, {weigh(c2ac), 1.0 / 10, "c^2 Ac"}, {weigh(acac_product), 1.0 / 20, "(Ac)^2"},
        {weigh(cac2), 1.0 / 15, "c Ac^2"}, {weigh(ac3), 1.0 / 20, "Ac^3"}, {weigh(caac), 1.0 / 30, "c AAc"},
        {weigh(acac), 1.0 / 40, "A(c Ac)"}, {weigh(aac2), 1.0 / 60, "AAc^2"}, {weigh(aaac), 1.0 / 120, "AAAc"},
    };
    for (size_t i = 0; i < sizeof trees / sizeof *trees; i++)
        if (!(fabs(trees[i].got - trees[i].want) <= 1e-14))
            fail_msg("b.%s = %.17g, want %.17g", trees[i].name, trees[i].got, trees[i].want);
    CHECK_NEAR(c[STAGES - 1], 1, 1e-15);        /* the last stage is the first of the next step */
    for (int i = 0; i < STAGES; i++)
        for (int k = i; k < STAGES - 1; k++)
            CHECK_NEAR(dormand_prince[i][k], 0, 0);     /* explicit */
}

/* ---- references ---- */

typedef long double wide;

/* theta'' = -k sin theta by the classical fourth-order formula. */
static void pendulum(wide k, wide time, wide *angle, wide *speed)
{
    const int steps = 20000;
    wide h = time / steps, x = *angle, v = *speed;
    for (int i = 0; i < steps; i++) {
        wide k1 = v, l1 = -k * sinl(x), k2 = v + h / 2 * l1, l2 = -k * sinl(x + h / 2 * k1);
        wide k3 = v + h / 2 * l2, l3 = -k * sinl(x + h / 2 * k2), k4 = v + h * l3, l4 = -k * sinl(x + h * k3);
        x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        v += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
    *angle = x;
    *speed = v;
}

typedef struct Wide { wide q[4], w[3]; } Wide;     /* x y z w; body axes */

/* Euler's equations in body axes, q' = q w / 2. */
static Wide rotor_rate(const Wide *y, const wide inertia[3])
{
    const wide *q = y->q, *w = y->w;
    return (Wide){{(q[3] * w[0] + q[1] * w[2] - q[2] * w[1]) / 2, (q[3] * w[1] + q[2] * w[0] - q[0] * w[2]) / 2,
                   (q[3] * w[2] + q[0] * w[1] - q[1] * w[0]) / 2, -(q[0] * w[0] + q[1] * w[1] + q[2] * w[2]) / 2},
                  {(inertia[1] - inertia[2]) / inertia[0] * w[1] * w[2], (inertia[2] - inertia[0]) / inertia[1] * w[2] * w[0],
                   (inertia[0] - inertia[1]) / inertia[2] * w[0] * w[1]}};
}

static Wide wide_mad(const Wide *a, wide s, const Wide *b)
{
    Wide r;
    for (int i = 0; i < 4; i++)
        r.q[i] = a->q[i] + s * b->q[i];
    for (int i = 0; i < 3; i++)
        r.w[i] = a->w[i] + s * b->w[i];
    return r;
}

static const vec3 rotor_inertia = {0.4 / 12, 1.04 / 12, 1.36 / 12};       /* a box of 1 x 0.6 x 0.2 m and 1 kg */
static const vec3 rotor_spin = {0.1, 5, 0.1};

/* Orientation of the rotor after `time`, from the identity; w = its spin in body axes. */
static quat rotor(real time, vec3 *w)
{
    const wide inertia[3] = {rotor_inertia.x, rotor_inertia.y, rotor_inertia.z};
    int steps = 1 + (int)(20000 * time);
    wide h = (wide)time / steps;
    Wide y = {{0, 0, 0, 1}, {rotor_spin.x, rotor_spin.y, rotor_spin.z}};
    for (int i = 0; i < steps; i++) {
        Wide k1 = rotor_rate(&y, inertia), y2 = wide_mad(&y, h / 2, &k1), k2 = rotor_rate(&y2, inertia), y3 = wide_mad(&y, h / 2, &k2);
        Wide k3 = rotor_rate(&y3, inertia), y4 = wide_mad(&y, h, &k3), k4 = rotor_rate(&y4, inertia);
        y = wide_mad(&y, h / 6, &k1);
        y = wide_mad(&y, h / 3, &k2);
        y = wide_mad(&y, h / 3, &k3);
        y = wide_mad(&y, h / 6, &k4);
    }
    if (w)
        *w = (vec3){(real)y.w[0], (real)y.w[1], (real)y.w[2]};
    return (quat){(real)y.q[0], (real)y.q[1], (real)y.q[2], (real)y.q[3]};
}

/* ---- fixed steps of the tracer ---- */

static void start(Hand *h)
{
    Tracer *t = &h->t;
    hand_trace(h);
    for (int i = 0; i < h->g.joint_count; i++)
        group_joint_view(&h->g, i);
    CHECK(trace_items(t));
    trace_store(t, t->y);
    CHECK(trace_rate(t, t->y, 0, 0));
    for (int i = 0; i < h->g.moving_count; i++) {
        t->spin0[i] = h->vel[i].w;
        t->alpha0[i] = t->alpha[i];
    }
    t->probe_wait = 1000000;            /* the pair itself, never a parabola */
}

static real one(Hand *h, real step)
{
    real error = trace_try(&h->t, step);
    if (!isfinite(error))
        fail_msg("%s", h->t.fault ? h->t.fault : "no step");
    return error;
}

static void go(Hand *h, real step, int steps)
{
    Tracer *t = &h->t;
    for (int i = 0; i < steps; i++) {
        one(h, step);
        State *keep = t->y;
        t->y = t->y1;
        t->y1 = keep;
        t->t += step;
        CHECK(trace_rate(t, t->y, t->t, 0));
    }
}

static void rotor_open(Hand *h)
{
    hand_open(h, 1, 1);
    hand_mass(h, 0, 1, rotor_inertia);
    h->vel[0].w = rotor_spin;
}

#define SWING_K (9.81 / (1 + 0.06))     /* 1/s^2: 1 kg at 1 m, 0.06 kg m^2 */

/* A pendulum in the xy plane on a hinge to the world: at an angle from the lowest place. */
static void pendulum_open(Hand *h, real angle, real speed)
{
    hand_open(h, 1, 1);
    hand_mass(h, 0, 1, (vec3){0.02, 0.03, 0.06});
    h->g.gravity = (vec3){0, -9.81, 0};
    h->pos[0] = (Pos){{sin(angle), -cos(angle), 0}, quat_exp((vec3){0, 0, angle})};
    h->vel[0] = (Vel){{speed * cos(angle), speed * sin(angle), 0}, {0, 0, speed}};
    group_refresh_mass(&h->g, 0);
    GroupJoint *j = &h->joints[0];
    quat frame = quat_between((vec3){1, 0, 0}, (vec3){0, 0, 1});
    *j = (GroupJoint){.a = 0, .b = -1, .ra = {0, 1, 0}, .fa = frame, .fb = frame, .other = {-1, -1}};
    for (int i = 0; joint_types[i]; i++)
        if (strcmp(joint_types[i]->name, "hinge") == 0)
            j->view.type = joint_types[i];
    param_defaults(j->view.type->params, h->params);
    j->view.params = h->params;
    j->view.memory = j->memory;
    h->g.joint_count = 1;
}

static void check_order(const char *what, real coarse, real fine, real lo, real hi)
{
    real order = log2(coarse / fine);
    if (!(order >= lo && order <= hi))
        fail_msg("%s: error %g, then %g with half the step: order %.2f, want %g to %g", what, coarse, fine, order, lo, hi);
}

TEST(the_angle_of_a_pendulum_on_a_hinge_converges_with_order_five)
{
    wide angle = 1.2L, speed = 0.5L;
    pendulum(SWING_K, 1, &angle, &speed);
    real off[3], off_speed[3];
    for (int i = 0; i < 3; i++) {
        Hand h;
        pendulum_open(&h, 1.2, 0.5);
        start(&h);
        int steps = 20 << i;
        go(&h, 1.0 / steps, steps);
        const State *y = &h.t.y[0];
        off[i] = fabs(2 * atan2(y->q.z, y->q.w) - (real)angle);
        off_speed[i] = fabs(y->l.z / 0.06 - (real)speed);
        CHECK_NEAR(2 * atan2(y->q.z, y->q.w), atan2(y->x.x, -y->x.y), 1e-5);
        hand_close(&h);
    }
    check_order("angle, 20 steps", off[0], off[1], 4.6, 6);
    check_order("angle, 40 steps", off[1], off[2], 4.6, 5.6);
    check_order("speed, 40 steps", off_speed[1], off_speed[2], 4.6, 5.6);
    CHECK(off[2] < 1e-8);
}

TEST(the_angle_of_the_free_rotor_converges_with_order_five)
{
    quat want = rotor(2, NULL);
    real off[3];
    for (int i = 0; i < 3; i++) {
        Hand h;
        rotor_open(&h);
        start(&h);
        int steps = 40 << i;
        go(&h, 2.0 / steps, steps);
        off[i] = angle_between(h.t.y[0].q, want);
        hand_close(&h);
    }
    check_order("40 steps", off[0], off[1], 4.6, 6);
    check_order("80 steps", off[1], off[2], 4.6, 5.6);
}

TEST(the_error_estimate_falls_with_the_fifth_power_of_the_step_and_bounds_the_error)
{
    real estimate[3];
    for (int i = 0; i < 3; i++) {
        Hand h;
        real step = 0.1 / (1 << i);
        rotor_open(&h);
        start(&h);
        estimate[i] = one(&h, step) * h.t.tolerance;
        CHECK(angle_between(h.t.y1[0].q, rotor(step, NULL)) < estimate[i]);
        hand_close(&h);
    }
    check_order("0.1 s", estimate[0], estimate[1], 4.6, 5.6);
    check_order("0.05 s", estimate[1], estimate[2], 4.6, 5.6);
}

TEST(the_dense_output_is_of_fourth_order_and_meets_the_ends)
{
    static const real parts[] = {0.1, 0.3, 0.5, 0.7, 0.9};
    real off[2][5];
    for (int i = 0; i < 2; i++) {
        Hand h;
        real step = 0.1 / (1 << i);
        rotor_open(&h);
        start(&h);
        one(&h, step);
        State out[2];
        for (int k = 0; k < 5; k++) {
            trace_dense(&h.t, parts[k], out);
            off[i][k] = angle_between(quat_unit(out[0].q), rotor(parts[k] * step, NULL));
            CHECK_NEAR(quat_norm2(out[0].q), 1, 1e-5);
        }
        trace_dense(&h.t, 0, out);
        CHECK_NEAR(angle_between(out[0].q, h.t.y[0].q), 0, 1e-15);
        trace_dense(&h.t, 1, out);
        CHECK_NEAR(angle_between(out[0].q, h.t.y1[0].q), 0, 1e-15);
        hand_close(&h);
    }
    for (int k = 0; k < 5; k++)
        check_order("dense output", off[0][k], off[1][k], 4.5, 7);        /* of one step: an order more */
}

/* The quadrature of forces is that of the momentum: nothing is lost between what a joint does and what the body gains. */
TEST(the_mean_force_of_a_joint_is_what_the_momentum_gains)
{
    Hand h;
    pendulum_open(&h, 0.9, 1.5);
    start(&h);
    one(&h, 0.05);
    trace_mean(&h.t);
    vec3 gain = vec3_scale(1 / 0.05, vec3_sub(h.t.y1[0].v, h.t.y[0].v)), want = vec3_sub(gain, h.g.gravity);
    CHECK_NEAR(h.t.sum[0], want.x, 1e-12);
    CHECK_NEAR(h.t.sum[1], want.y, 1e-12);
    CHECK_NEAR(h.t.sum[2], want.z, 1e-12);
    CHECK(vec3_length(want) > 5);
    hand_close(&h);
}

/* The forces of the frame before serve where the body has been moved by as little as the holding of its energy moves it, no farther. */
TEST(a_frame_begins_with_the_forces_that_joints_had_where_they_still_hold)
{
    static const struct { real faster; bool again; } cases[] = {{0, true}, {1e-10, true}, {1e-6, false}, {-1e-3, false}};
    for (int i = 0; i < 4; i++) {
        Hand h;
        pendulum_open(&h, 0.9, 1.5);
        start(&h);
        Tracer *t = &h.t;
        t->end = 1.0 / 60;
        CHECK(!trace_joints_again(t));                  /* none yet */
        CHECK(trace_accelerate(t));
        memcpy(h.joints[0].force, t->joint_force, sizeof h.joints[0].force);
        t->y[0].v = vec3_scale(1 + cases[i].faster, t->y[0].v);
        t->y[0].l = vec3_scale(1 + cases[i].faster, t->y[0].l);
        trace_load(t, t->y, 0);
        trace_kinematics(t);
        CHECK_INT(trace_joints_again(t), cases[i].again);
        vec3 acc = t->acc[0], alpha = t->alpha[0];
        CHECK(trace_accelerate(t));
        if (cases[i].again) {
            CHECK_NEAR(vec3_distance(t->acc[0], acc), 0, 4e-9);         /* m/s^2: a thousandth of the tolerance in a frame */
            CHECK_NEAR(vec3_distance(t->alpha[0], alpha), 0, 4e-9);
        }
        h.joints[0].force[0] += 1e-3;
        CHECK(!trace_joints_again(t));
        hand_close(&h);
    }
}

TEST(what_is_pushed_evenly_follows_its_parabola_in_one_step)
{
    Hand h;
    hand_open(&h, 1, 1);
    h.g.gravity = (vec3){0.3, -9.81, 0.1};
    h.member[0].round = true;
    h.vel[0] = (Vel){{1, 2, 3}, {0.4, -0.3, 0.2}};
    h.g.push_count = 1;
    h.pushes[0] = (GroupPush){.body = 0, .torque = {0.8, -0.6, 0.4}};       /* along the spin: the turn is about one axis */
    start(&h);
    h.t.probe_wait = 0;
    CHECK_NEAR(trace_try(&h.t, 0.5), 0, 0);
    CHECK(h.t.probed);
    for (int i = 1; i <= 4; i++) {
        real s = 0.5 * i / 4;
        State y;
        trace_dense(&h.t, i / 4.0, &y);
        CHECK_NEAR(vec3_distance(y.x, (vec3){s + 0.15 * s * s, 2 * s - 4.905 * s * s, 3 * s + 0.05 * s * s}), 0, 1e-15);
        CHECK_NEAR(vec3_distance(y.v, (vec3){1 + 0.3 * s, 2 - 9.81 * s, 3 + 0.1 * s}), 0, 4e-15);
        CHECK_NEAR(angle_between(y.q, quat_exp(vec3_scale(s + s * s, (vec3){0.4, -0.3, 0.2}))), 0, 1e-15);
    }
    hand_close(&h);
    rotor_open(&h);                     /* and a rotor is not taken for one */
    start(&h);
    h.t.probe_wait = 0;
    CHECK(trace_try(&h.t, 0.05) > 0);
    CHECK(!h.t.probed);
    hand_close(&h);
}

/* Orientation after `time` of a spin that grows evenly in direction and size, by the classical fourth-order formula. */
static quat grown_turn(vec3 w, vec3 alpha, real time)
{
    const int steps = 4000;
    real h = time / steps;
    quat q = quat_identity();
    for (int i = 0; i < steps; i++) {
        quat k[4], y = q;
        for (int s = 0; s < 4; s++) {
            vec3 now = vec3_scale(0.5, vec3_mad(w, h * (i + (s + 1) / 2 * 0.5), alpha));
            k[s] = quat_mul((quat){now.x, now.y, now.z, 0}, y);
            real part = s == 2 ? h : h / 2;
            y = (quat){q.x + part * k[s].x, q.y + part * k[s].y, q.z + part * k[s].z, q.w + part * k[s].w};
        }
        for (int s = 0; s < 4; s++) {
            real part = s == 0 || s == 3 ? h / 6 : h / 3;
            q = (quat){q.x + part * k[s].x, q.y + part * k[s].y, q.z + part * k[s].z, q.w + part * k[s].w};
        }
    }
    return q;
}

TEST(a_spin_that_grows_evenly_turns_with_order_four)
{
    const vec3 w = {0.4, -0.3, 0.2}, alpha = {0.5, 0.8, -0.6};
    real off[2];
    for (int i = 0; i < 2; i++) {
        Hand h;
        hand_open(&h, 1, 1);
        h.member[0].round = true;
        h.vel[0].w = w;
        h.g.push_count = 1;
        h.pushes[0] = (GroupPush){.body = 0, .torque = alpha};
        start(&h);
        h.t.probe_wait = 0;
        h.t.tolerance = 1;                  /* so that the bend of the spin does not forbid it */
        real time = 0.4 / (1 << i);
        CHECK_NEAR(trace_try(&h.t, time), 0, 0);
        CHECK(h.t.probed);
        off[i] = angle_between(h.t.y1[0].q, grown_turn(w, alpha, time));
        hand_close(&h);
    }
    CHECK(off[0] < 1e-4);
    check_order("a step of constant acceleration", off[0], off[1], 4.5, 6);
}

/* ---- free flight ---- */

TEST(flight_by_the_fewest_terms_turns_with_order_four)
{
    quat want = rotor(2, NULL);
    real off[3];
    for (int i = 0; i < 3; i++) {
        Hand h;
        rotor_open(&h);
        h.g.tolerance = 1e30;           /* as few terms as can be: four */
        int steps = 100 << i;          /* so many that none is cut into parts */
        for (int k = 0; k < steps; k++)
            CHECK_INT(way_flight.advance(&h.g, 2.0 / steps), DIG_OK);
        off[i] = angle_between(h.pos[0].q, want);
        vec3 l = quat_rotate(h.pos[0].q, vec3_mul(rotor_inertia, quat_unrotate(h.pos[0].q, h.vel[0].w)));
        CHECK_NEAR(vec3_distance(l, vec3_mul(rotor_inertia, rotor_spin)), 0, 1e-14);
        hand_close(&h);
    }
    check_order("100 steps", off[0], off[1], 3.8, 5);
    check_order("200 steps", off[1], off[2], 3.8, 4.6);
}

/* So fast that a frame is many parts, and so thin that the axis it turns about does not bound the speed it may get to. */
TEST(a_thin_fast_body_in_flight_keeps_its_digits_in_every_length_of_step)
{
    quat ends[2];
    for (int i = 0; i < 2; i++) {
        dig_world_def def = dig_world_defaults();
        def.gravity = vec3_zero();
        def.tolerance = 1e-10;
        def.step = i ? 1.0 / 960 : 1.0 / 60;
        dig_world *w = open_with(def);
        dig_body_def d = body_with(look(0, 0), vec3_zero(), quat_identity());
        d.mass = 1;
        d.spin = (vec3){20, 0.5, 30};
        dig_box_def box = {{0.1, 1, 0.4}};
        dig_body b = add_body(w, d, "box", &box);
        step(w, i ? 960 : 60);
        ends[i] = state_of(w, b).rotation;
        dig_world_close(w);
    }
    CHECK_NEAR(angle_between(ends[0], ends[1]), 0, 1e-10);
}

/* A square rod of 1 kg at 600 rad/s, coarsely: its length goes round the angular momentum at |L| / I, turning evenly about itself. */
TEST(a_rod_in_flight_goes_round_its_angular_momentum)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = vec3_zero();
    def.tolerance = 1e-2;
    dig_world *w = open_with(def);
    dig_body_def d = body_with(look(0, 0), vec3_zero(), quat_identity());
    d.mass = 1;
    d.spin = (vec3){60, 40, 600};
    dig_box_def box = {{0.04, 1, 0.04}};
    dig_body b = add_body(w, d, "box", &box);
    const real across = (1 + 0.0016) / 12, along = 0.0032 / 12;
    const vec3 l = {across * 60, along * 40, across * 600};
    for (int i = 1; i <= 60; i++) {
        step(w, 1);
        quat round = quat_exp(vec3_scale(i / 60.0 / across, l)), self = quat_exp((vec3){0, i / 60.0 * 40 * (1 - along / across), 0});
        CHECK_NEAR(angle_between(state_of(w, b).rotation, quat_mul(round, self)), 0, 1e-10);
        CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), l), 0, 1e-12);
    }
    dig_world_close(w);
}

static dig_body open_rotor(dig_world **w, real tolerance)
{
    dig_world_def def = dig_world_defaults();
    def.gravity = vec3_zero();
    def.tolerance = tolerance;
    *w = open_with(def);
    dig_body_def d = body_with(look(0, 0), vec3_zero(), quat_identity());
    d.mass = 1;
    d.spin = rotor_spin;
    dig_box_def box = {{1, 0.6, 0.2}};
    return add_body(*w, d, "box", &box);
}

/* Digits by Jacobi's elliptic functions; see the acceptance suite, A09. */
TEST(the_rotor_in_flight_has_the_digits_of_the_elliptic_functions)
{
    const quat want10 = {.w = 0.04708551769268645, .x = -0.33976629267684835, .y = -0.04007006820467736, .z = -0.93847547118628223};
    const quat want100 = {.w = 0.47774288782843050, .x = -0.07104353449489409, .y = 0.87211101831220062, .z = 0.07833850314041581};
    const vec3 spin10 = {-0.65328677596279357, -4.9516760629825136, 0.50514040660107051};
    vec3 reference;
    CHECK_NEAR(angle_between(rotor(10, &reference), want10), 0, 1e-13);        /* the test's own reference agrees */
    CHECK_NEAR(vec3_distance(reference, spin10), 0, 1e-12);
    dig_world *w;
    dig_body b = open_rotor(&w, 1e-10);
    step(w, 600);
    CHECK_INT(dig_world_stats(w).traced, 1);
    dig_body_state s = state_of(w, b);
    CHECK_NEAR(angle_between(s.rotation, want10), 0, 1e-9);
    CHECK_NEAR(vec3_distance(quat_unrotate(s.rotation, s.spin), spin10), 0, 1e-8);
    CHECK_NEAR(vec3_distance(dig_world_angular_momentum(w), vec3_mul(rotor_inertia, rotor_spin)), 0, 1e-13);
    step(w, 5400);
    CHECK_NEAR(angle_between(state_of(w, b).rotation, want100), 0, 1e-8);
    dig_world_close(w);
}

TEST(the_angle_of_flight_falls_with_the_tolerance)
{
    const quat want = rotor(10, NULL);
    real off[3];
    for (int i = 0; i < 3; i++) {
        dig_world *w;
        dig_body b = open_rotor(&w, pow(10, -4 - 2 * i));
        step(w, 600);
        off[i] = angle_between(state_of(w, b).rotation, want);
        dig_world_close(w);
        CHECK(off[i] < pow(10, -4 - 2 * i));
        CHECK(i == 0 || off[i] < real_max(0.1 * off[i - 1], 1e-10));    /* of rounding this rotor makes as much */
    }
}

int main(void)
{
    RUN_TESTS(unit_test(the_table_meets_all_seventeen_order_conditions_up_to_five),
              unit_test(the_angle_of_a_pendulum_on_a_hinge_converges_with_order_five),
              unit_test(the_angle_of_the_free_rotor_converges_with_order_five),
              unit_test(the_error_estimate_falls_with_the_fifth_power_of_the_step_and_bounds_the_error),
              unit_test(the_dense_output_is_of_fourth_order_and_meets_the_ends),
              unit_test(the_mean_force_of_a_joint_is_what_the_momentum_gains),
              unit_test(a_frame_begins_with_the_forces_that_joints_had_where_they_still_hold),
              unit_test(what_is_pushed_evenly_follows_its_parabola_in_one_step),
              unit_test(a_spin_that_grows_evenly_turns_with_order_four),
              unit_test(flight_by_the_fewest_terms_turns_with_order_four),
              unit_test(a_thin_fast_body_in_flight_keeps_its_digits_in_every_length_of_step),
              unit_test(a_rod_in_flight_goes_round_its_angular_momentum),
              unit_test(the_rotor_in_flight_has_the_digits_of_the_elliptic_functions),
              unit_test(the_angle_of_flight_falls_with_the_tolerance));
}
