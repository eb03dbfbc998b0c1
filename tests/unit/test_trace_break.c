/* tests/unit/test_trace_break.c - joints of followed groups break at the very time at which their load reaches their strength, whatever
 * the frame step, and what they held flies on from there. Every expectation is a closed form.
 */
#include "physics_fixture.h"

static const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 240};
enum { STEPS = 3 };

typedef struct Setting { const char *name; vec3 value; } Setting;      /* of a number: value.x */

static dig_joint add_joint(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at, real strength, const Setting *with, int count)
{
    const dig_schema *schema = dig_schema_find("joint", type);
    real params[48];
    CHECK(schema->size <= sizeof params);
    dig_schema_defaults(schema, params);
    for (const dig_param *p = schema->rows; p->name; p++)
        for (int i = 0; i < count; i++)
            if (strcmp(p->name, with[i].name) == 0)
                memcpy((char *)params + p->offset, &with[i].value, p->kind == DIG_VEC3 ? sizeof(vec3) : sizeof(real));
    dig_joint_def d = dig_joint_defaults();
    d.type = type;
    d.a = a;
    d.b = b;
    d.at = at;
    d.axis = (vec3){0, 0, 1};
    d.breaks_at = strength;
    d.data = params;
    dig_joint j;
    if (dig_joint_create(w, &d, &j) != DIG_OK)
        fail_msg("%s: %s", type, dig_error(w));
    return j;
}

static const dig_body nobody = {0, 0};

/* Steps until something breaks, at most `time` s; the event's own time. */
static real run_to_break(dig_world *w, real time)
{
    real end = dig_world_time(w) + time;
    while (dig_world_time(w) < end) {
        step(w, 1);
        CHECK_INT(dig_world_stats(w).swept + dig_world_stats(w).conserved, 0);
        const dig_event *e;
        int n = dig_events(w, &e);
        for (int i = 0; i < n; i++)
            if (e[i].kind == DIG_EVENT_BROKEN)
                return e[i].time;
    }
    fail_msg("nothing broke in %g s", time);
    return NAN;
}

/* The parabola through the present state, where it crosses y = level. */
static real landing(const dig_world *w, dig_body b, real level)
{
    dig_body_state s = state_of(w, b);
    real up = s.velocity.y, fall = (up + sqrt(up * up + 2 * GRAVITY * (s.position.y - level))) / GRAVITY;
    return s.position.x + fall * s.velocity.x;
}

static dig_body add_mover(dig_world *w, vec3 at, vec3 velocity)
{
    dig_body_def d = body_with(look(0, 0), at, quat_identity());
    d.kinematic = true;
    d.velocity = velocity;
    dig_sphere_def s = {0.1};
    return add_body(w, d, "sphere", &s);
}

/* ---- springs ---- */

/* m x'' = k (V t - x) from rest: the stretch is (V / o) sin(o t). After the break the ball keeps V (1 - cos(o t*)). */
TEST(a_spring_drawn_at_constant_speed_breaks_at_its_time)
{
    real mass = 2, k = 50, v = 0.7, strength = 5, o = sqrt(k / mass), want = asin(strength * o / (k * v)) / o, speed = v * (1 - cos(o * want));
    for (int i = 0; i < STEPS; i++) {
        dig_world *w = open_world(steps[i], "study", false);
        dig_body ball = add_ball(w, look(0, 0), 0.1, mass, vec3_zero(), vec3_zero());
        dig_body hand = add_mover(w, (vec3){1, 0, 0}, (vec3){v, 0, 0});
        dig_joint j = add_joint(w, "spring", ball, hand, vec3_zero(), strength, &(Setting){"stiffness", {k, 0, 0}}, 1);
        CHECK_NEAR(run_to_break(w, 1), want, 1e-9);
        CHECK(!dig_joint_alive(w, j));
        dig_body_state s = state_of(w, ball);
        CHECK_NEAR(s.velocity.x, speed, 1e-9);
        CHECK_NEAR(s.position.x, v * want - v / o * sin(o * want) + speed * (dig_world_time(w) - want), 1e-9);
        dig_world_close(w);
    }
}

/* Let go on a spring without stretch: the stretch is (m g / k)(1 - cos(o t)). At play too. */
TEST(a_weight_dropped_on_its_spring_breaks_it_at_its_time)
{
    static const char *const plans[] = {"play", "study", "reference"};
    static const real within[] = {1e-7, 1e-9, 1e-11};
    real mass = 3, k = 200, strength = 1.9 * mass * GRAVITY, o = sqrt(k / mass), want = acos(1 - strength / (mass * GRAVITY)) / o;
    for (int i = 0; i < STEPS; i++)
        for (int p = 0; p < 3; p++) {
            dig_world *w = open_world(steps[i], plans[p], true);
            dig_body ball = add_ball(w, look(0, 0), 0.1, mass, (vec3){0, 5, 0}, vec3_zero());
            add_joint(w, "spring", ball, nobody, vec3_zero(), strength,
                      (Setting[]){{"stiffness", {k, 0, 0}}, {"at_b", {0, 6, 0}}}, 2);
            CHECK_NEAR(run_to_break(w, 1), want, within[p]);
            real t = dig_world_time(w) - want, v = -GRAVITY / o * sin(o * want);
            CHECK_NEAR(state_of(w, ball).position.y, 5 - strength / k + v * t - 0.5 * GRAVITY * t * t, within[p]);
            dig_world_close(w);
        }
}

/* With a damper the force at the start is c V at once: enough of it breaks the joint before anything has moved. */
TEST(a_damper_drawn_too_fast_breaks_at_the_first_instant)
{
    dig_world *w = open_world(1.0 / 60, "study", false);
    dig_body ball = add_ball(w, look(0, 0), 0.1, 1, vec3_zero(), vec3_zero());
    dig_body hand = add_mover(w, (vec3){1, 0, 0}, (vec3){2, 0, 0});
    add_joint(w, "spring", ball, hand, vec3_zero(), 9, (Setting[]){{"stiffness", {10, 0, 0}}, {"damping", {5, 0, 0}}}, 2);
    CHECK_NEAR(run_to_break(w, 0.1), 0, 0);
    CHECK_NEAR(state_of(w, ball).velocity.x, 0, 0);
    dig_world_close(w);
}

/* The peak of the load lies inside a frame: one that is over the strength by a millionth breaks, one that is under it does not. */
TEST(a_peak_between_two_frames_is_not_missed)
{
    real mass = 1, k = 900, o = sqrt(k / mass), peak = 2 * mass * GRAVITY;
    for (int over = 0; over < 2; over++)
        for (int i = 0; i < STEPS; i++) {
            dig_world *w = open_world(steps[i], "study", true);
            dig_body ball = add_ball(w, look(0, 0), 0.1, mass, (vec3){0, 5, 0}, vec3_zero());
            real strength = peak * (over ? 1 - 1e-6 : 1 + 1e-6);
            dig_joint j = add_joint(w, "spring", ball, nobody, vec3_zero(), strength,
                                    (Setting[]){{"stiffness", {k, 0, 0}}, {"at_b", {0, 6, 0}}}, 2);
            if (over)       /* the time of a load near its peak is told by the root of what is left of it */
                CHECK_NEAR(run_to_break(w, 0.2), acos(1 - strength / (mass * GRAVITY)) / o, 1e-6);
            else
                step(w, (int)round(1 / steps[i]));
            CHECK(dig_joint_alive(w, j) == !over);
            dig_world_close(w);
        }
}

/* ---- rigid joints ---- */

/* A point on a rope, let go with the rope level: T = 3 m g c, c the cosine from the vertical; v^2 = 2 g L c. */
static void check_point_pendulum(const char *type, const char *plan, real within)
{
    real length = 2, mass = 1.5, c = 0.6, s = 0.8, strength = 3 * mass * GRAVITY * c, speed = sqrt(2 * GRAVITY * length * c), level = -10;
    real x = length * s, y = -length * c, vx = -speed * c, vy = -speed * s;     /* swings from +x towards -x, still going down */
    real fall = (vy + sqrt(vy * vy + 2 * GRAVITY * (y - level))) / GRAVITY, first = NAN;
    for (int i = 0; i < STEPS; i++) {
        dig_world *w = open_world(steps[i], plan, true);
        dig_body ball = add_ball(w, look(0, 0), 0.1, mass, (vec3){length, 0, 0}, vec3_zero());
        add_joint(w, type, ball, nobody, vec3_zero(), strength,
                  (Setting[]){{"at_a", {length, 0, 0}}, {"at_b", {0, 0, 0}}, {"length", {length, 0, 0}}}, 3);
        real at = run_to_break(w, 2);
        first = i ? first : at;
        CHECK_NEAR(at, first, within);
        CHECK_NEAR(landing(w, ball, level), x + fall * vx, within);
        step(w, 5);
        CHECK_NEAR(landing(w, ball, level), x + fall * vx, within);
        CHECK_INT(dig_world_stats(w).traced, 1);
        check_world(w);
        dig_world_close(w);
    }
}

TEST(a_rope_snaps_where_its_tension_is_its_strength) { check_point_pendulum("rope", "study", 1e-8); }
TEST(a_rod_snaps_where_its_tension_is_its_strength)
{
    check_point_pendulum("distance", "study", 1e-8);
    check_point_pendulum("distance", "reference", 1e-10);
}

/* A ball fixed to a hinge: radial m g c (1 + 2 q), tangential m g s (1 - q), q = m L^2 / I; it flies on with its spin. */
TEST(a_hinge_breaks_at_the_angle_of_the_closed_form)
{
    real length = 1.2, radius = 0.3, mass = 2, inertia = mass * (length * length + 0.4 * radius * radius), q = mass * length * length / inertia;
    real strength = 2 * mass * GRAVITY, weight = strength / (mass * GRAVITY);
    real c2 = (weight * weight - (1 - q) * (1 - q)) / ((1 + 2 * q) * (1 + 2 * q) - (1 - q) * (1 - q)), c = sqrt(c2), s = sqrt(1 - c2);
    real spin = sqrt(2 * mass * GRAVITY * length * c / inertia), level = -8;
    real vx = -spin * length * c, vy = -spin * length * s;
    real fall = (vy + sqrt(vy * vy + 2 * GRAVITY * (-length * c - level))) / GRAVITY;
    for (int i = 0; i < STEPS; i++) {
        dig_world *w = open_world(steps[i], "study", true);
        dig_body ball = add_ball(w, look(0, 0), radius, mass, (vec3){length, 0, 0}, vec3_zero());
        add_joint(w, "hinge", ball, nobody, vec3_zero(), strength, NULL, 0);
        run_to_break(w, 2);
        dig_body_state b = state_of(w, ball);
        CHECK_NEAR(landing(w, ball, level), length * s + fall * vx, 1e-8);
        CHECK_NEAR(b.spin.z, -spin, 1e-8);
        CHECK_NEAR(b.velocity.x, vx, 1e-8);
        dig_world_close(w);
    }
}

/* A beam hangs level on two ropes, half its weight on each: the one that is overloaded the most goes first. The other then carries
 * m g / (1 + m r^2 / I) only, which it can. */
TEST(the_one_that_is_overloaded_the_most_goes_first)
{
    real mass = 1, weight = mass * GRAVITY, half = 1, thick = 0.02, q = 1 / (1 + half * half / ((half * half + thick * thick) / 3));
    dig_world *w = open_world(1e-4, "study", true);
    dig_body beam = add_box(w, look(0, 0), (vec3){2 * half, 2 * thick, 2 * thick}, mass, vec3_zero(), quat_identity());
    dig_joint ropes[2];
    for (int i = 0; i < 2; i++) {
        real x = i ? half : -half;
        ropes[i] = add_joint(w, "rope", beam, nobody, vec3_zero(), (i ? 0.4 : 0.45) * weight,
                             (Setting[]){{"at_a", {x, 0, 0}}, {"at_b", {x, 1, 0}}}, 2);
    }
    CHECK_NEAR(run_to_break(w, 0.1), 0, 0);
    CHECK(!dig_joint_alive(w, ropes[1]) && dig_joint_alive(w, ropes[0]));
    dig_joint_state left;
    CHECK_INT(dig_joint_get(w, ropes[0], &left), DIG_OK);
    CHECK_NEAR(vec3_length(left.force), q * weight, 1e-5);
    dig_world_close(w);
}

/* A weight let go on two springs side by side. The stiffer one breaks first; the weight goes on, on the other one, until that breaks too:
 * the stretch is then  mg/k + (s1 - mg/k) cos(o t) + (v1 / o) sin(o t). In long frames both happen in one of them. */
TEST(springs_side_by_side_break_one_after_the_other)
{
    real mass = 2, k[2] = {6000, 2000}, pull = mass * GRAVITY, both = k[0] + k[1], o = sqrt(both / mass);
    real s1 = 1.2 * pull / both, t1 = acos(1 - s1 * both / pull) / o, v1 = pull / both * o * sin(o * t1);
    real o2 = sqrt(k[1] / mass), mean = pull / k[1], size = hypot(s1 - mean, v1 / o2), s2 = mean + 0.3 * size;
    real t2 = t1 + (acos((s1 - mean) / size) - acos(0.3)) / o2;         /* phases of the cosine, both while it goes down */
    static const real frames[] = {0.1, 1.0 / 60, 1.0 / 1000};
    for (int i = 0; i < 3; i++) {
        dig_world *w = open_world(frames[i], "reference", true);
        dig_body ball = add_ball(w, look(0, 0), 0.1, mass, (vec3){0, 5, 0}, vec3_zero());
        for (int n = 0; n < 2; n++)
            add_joint(w, "spring", ball, nobody, vec3_zero(), n ? k[1] * s2 : k[0] * s1,
                      (Setting[]){{"stiffness", {k[n], 0, 0}}, {"at_b", {0, 6, 0}}}, 2);
        real told[2] = {0};
        for (int n = 0; n < 2 && dig_world_time(w) < 0.3;) {
            step(w, 1);
            const dig_event *e;
            int events = dig_events(w, &e);
            for (int m = 0; m < events && n < 2; m++)
                if (e[m].kind == DIG_EVENT_BROKEN)
                    told[n++] = e[m].time;
        }
        CHECK_NEAR(told[0], t1, 1e-11);
        CHECK_NEAR(told[1], t2, 1e-11);
        dig_world_close(w);
    }
}

/* The DIG falls apart at the time of the break: link and split carry it. */
TEST(the_split_has_the_time_of_the_break)
{
    real mass = 2, k = 50, v = 0.7, strength = 3;
    dig_world *w = open_world(1.0 / 30, "study", false);
    dig_body a = add_ball(w, look(0, 0), 0.1, mass, vec3_zero(), vec3_zero());
    dig_body b = add_ball(w, look(0, 0), 0.1, mass, (vec3){-1, 0, 0}, vec3_zero());
    add_joint(w, "spring", a, b, vec3_zero(), strength, &(Setting){"stiffness", {k, 0, 0}}, 1);
    CHECK_INT(dig_body_hit(w, a, (vec3){mass * v, 0, 0}, vec3_zero(), false), DIG_OK);
    /* relative: reduced mass m / 2, the stretch is (v / p) sin(p t), p^2 = 2 k / m */
    real p = sqrt(2 * k / mass), at = asin(strength * p / (k * v)) / p;
    CHECK_INT(dig_of(w, a).id, dig_of(w, b).id);
    CHECK_NEAR(run_to_break(w, 1), at, 1e-9);
    CHECK(dig_of(w, a).id != dig_of(w, b).id);
    const dig_event *e;
    int n = dig_events(w, &e), told = 0;
    for (int i = 0; i < n; i++)
        if (e[i].kind == DIG_EVENT_SPLIT || e[i].kind == DIG_EVENT_UNLINK) {
            CHECK_NEAR(e[i].time, at, 1e-9);
            told++;
        }
    CHECK_INT(told, 2);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(a_spring_drawn_at_constant_speed_breaks_at_its_time), unit_test(a_weight_dropped_on_its_spring_breaks_it_at_its_time),
              unit_test(a_damper_drawn_too_fast_breaks_at_the_first_instant), unit_test(a_peak_between_two_frames_is_not_missed),
              unit_test(a_rope_snaps_where_its_tension_is_its_strength), unit_test(a_rod_snaps_where_its_tension_is_its_strength),
              unit_test(a_hinge_breaks_at_the_angle_of_the_closed_form), unit_test(the_one_that_is_overloaded_the_most_goes_first),
              unit_test(springs_side_by_side_break_one_after_the_other),
              unit_test(the_split_has_the_time_of_the_break));
}
