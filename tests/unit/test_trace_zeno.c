/* tests/unit/test_trace_zeno.c - bounces without end come to rest at the sum of their times, in few events, with what their whole impulse
 * leaves. Every expectation is a closed form.
 */
#include "physics_fixture.h"

static const real restitutions[] = {0.5, 0.9, 0.99};
static const real steps[] = {1.0 / 30, 1.0 / 60, 1.0 / 240};
enum { RESTITUTIONS = 3, STEPS = 3 };

typedef struct Rest { real at; int events, worst; } Rest;       /* s; located in all, in the worst step */

/* Steps until a contact that lasts begins; its time. */
static Rest run_to_rest(dig_world *w, real time)
{
    Rest r = {NAN, 0, 0};
    real end = dig_world_time(w) + time;
    while (dig_world_time(w) < end) {
        step(w, 1);
        dig_stats s = dig_world_stats(w);
        CHECK_INT(s.swept + s.conserved, 0);
        r.events += s.trace_events;
        r.worst = s.trace_events > r.worst ? s.trace_events : r.worst;
        const dig_event *e;
        int n = dig_events(w, &e);
        for (int i = 0; i < n; i++)
            if (e[i].kind == DIG_EVENT_CONTACT_BEGIN)
                r.at = e[i].time;
        if (s.contacts > 0)
            return r;
    }
    fail_msg("not at rest after %g s", time);
    return r;
}

/* From the height h: sqrt(2 h / g) (1 + e) / (1 - e). Away from it, the height at any time is that of its own flight. */
static real rest_time(real height, real e) { return sqrt(2 * height / GRAVITY) * (1 + e) / (1 - e); }

static real height_at(real time, real height, real e)
{
    real fall = sqrt(2 * height / GRAVITY), r = e * GRAVITY * fall, left = time - fall;
    if (left < 0)
        return height - 0.5 * GRAVITY * time * time;
    for (; r > 1e-12; r *= e) {
        real flight = 2 * r / GRAVITY;
        if (left < flight)
            return r * left - 0.5 * GRAVITY * left * left;
        left -= flight;
    }
    return 0;
}

TEST(a_ball_rests_at_the_sum_of_its_flights)
{
    for (int k = 0; k < RESTITUTIONS; k++)
        for (int i = 0; i < STEPS; i++) {
            real e = restitutions[k], height = e > 0.95 ? 0.01 : 0.5, radius = 0.1;
            dig_world *w = open_world(steps[i], "play", true);
            add_floor(w, look(0, e));
            dig_body ball = add_ball(w, look(0, e), radius, 1, (vec3){0, radius + height, 0}, vec3_zero());
            real want = rest_time(height, e);
            int events = 0, worst = 0;
            while (dig_world_time(w) < want - steps[i]) {
                step(w, 1);
                events += dig_world_stats(w).trace_events;
                worst = int_max(worst, dig_world_stats(w).trace_events);
                CHECK_NEAR(state_of(w, ball).position.y - radius, height_at(dig_world_time(w), height, e), 1e-13 / (1 - e));
            }
            Rest r = run_to_rest(w, 1);
            printf("e = %g, step 1/%g: at rest after %.15g s, want %.15g; %d located, at most %d in a step\n", e, 1 / steps[i], r.at, want,
                   events + r.events, int_max(worst, r.worst));
            CHECK_NEAR(r.at, want, 1e-11 / (1 - e));
            step(w, 3);
            CHECK_NEAR(state_of(w, ball).position.y, radius, 1e-12);
            CHECK_NEAR(state_of(w, ball).velocity.y, 0, 1e-12);
            CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-10);
            dig_world_close(w);
        }
}

TEST(a_box_dropped_flat_rests_at_the_sum_of_its_flights)
{
    for (int k = 0; k < RESTITUTIONS; k++) {
        real e = restitutions[k], height = e > 0.95 ? 0.01 : 0.3;
        dig_world *w = open_world(1.0 / 60, "play", true);
        add_floor(w, look(0.5, e));
        dig_body box = add_box(w, look(0.5, e), (vec3){1, 0.4, 0.7}, 2, (vec3){0, 0.2 + height, 0}, quat_exp((vec3){0, 0.3, 0}));
        Rest r = run_to_rest(w, 10);
        printf("box, e = %g: at rest after %.15g s, want %.15g; %d located, at most %d in a step\n", e, r.at, rest_time(height, e), r.events,
               r.worst);
        CHECK_NEAR(r.at, rest_time(height, e), 1e-8);
        step(w, 5);
        CHECK_NEAR(state_of(w, box).position.y, 0.2, 1e-10);
        dig_world_close(w);
    }
}

/* Against a table that rises evenly the same series, seen from the table. */
TEST(a_table_that_moves_evenly_changes_nothing_but_the_place)
{
    real e = 0.9, height = 0.05, radius = 0.1, up = 0.3, along = 0.2;
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body_def d = body_with(look(0, e), (vec3){0, -0.5, 0}, quat_identity());
    d.kinematic = true;
    d.velocity = (vec3){along, up, 0};
    dig_box_def table = {{20, 1, 20}};
    add_body(w, d, "box", &table);
    dig_body ball = add_ball(w, look(0, e), radius, 1, (vec3){0, radius + height, 0}, (vec3){0, up, 0});
    Rest r = run_to_rest(w, 10);
    CHECK_NEAR(r.at, rest_time(height, e), 1e-10);
    CHECK_NEAR(state_of(w, ball).position.y, radius + up * dig_world_time(w), 1e-11);
    CHECK_NEAR(state_of(w, ball).velocity.y, up, 1e-11);
    CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-10);
    dig_world_close(w);
}

/* The impulse of the whole series, m v (1 + e) / (1 - e), bounds what friction takes: mu of it from the speed, 5 mu / (2 R) of it from the
 * spin, as long as it slips; from then on it rolls. The place at rest is that of one that had been pressed evenly all the time. */
TEST(friction_takes_its_part_of_the_whole_impulse)
{
    real e = 0.8, radius = 0.2, mass = 1.5, v = 1, mu = 0.1, fast = 8;
    for (int i = 0; i < STEPS; i++) {
        dig_world *w = open_world(steps[i], "play", true);
        Look l = {mu, NAN, 0, e};
        add_floor(w, l);
        dig_body ball = add_ball(w, l, radius, mass, (vec3){0, radius, 0}, (vec3){fast, 0, 0});
        dig_body_state s = state_of(w, ball);
        s.velocity = (vec3){fast, v, 0};                        /* thrown up from the floor at v: comes back at v */
        CHECK_INT(dig_body_hit(w, ball, (vec3){0, mass * v, 0}, vec3_zero(), false), DIG_OK);
        Rest r = run_to_rest(w, 10);
        real back = 2 * v / GRAVITY, rest = back / (1 - e), whole = v * (1 + e) / (1 - e);      /* per mass */
        CHECK_NEAR(r.at, rest, 1e-9);
        real left = dig_world_time(w) - rest;                   /* slides on: 7/2 mu whole < fast */
        real speed = fast - mu * whole, spin = -2.5 * mu * whole / radius;
        s = state_of(w, ball);
        CHECK_NEAR(s.velocity.x, speed - mu * GRAVITY * left, 1e-9);
        CHECK_NEAR(s.spin.z, spin - 2.5 * mu * GRAVITY / radius * left, 1e-8);
        /* from the first blow at `back` on: pressed by g evenly after a plastic blow of v */
        real t = dig_world_time(w) - back;
        CHECK_NEAR(s.position.x, fast * back + (fast - mu * v) * t - 0.5 * mu * GRAVITY * t * t, 1e-9);
        CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-9);
        dig_world_close(w);
    }
}

/* Spin alone: the slip is R w, and ends within the series. Rolling is left: v = R w0 2/7. */
TEST(a_spin_that_is_used_up_in_the_series_leaves_rolling)
{
    real e = 0.9, radius = 0.2, mu = 0.4, w0 = 3, height = 0.02;
    dig_world *w = open_world(1.0 / 60, "play", true);
    Look l = {mu, NAN, 0, e};
    add_floor(w, l);
    dig_body_def d = body_with(l, (vec3){0, radius + height, 0}, quat_identity());
    d.mass = 1;
    d.spin = (vec3){0, 0, -w0};
    dig_sphere_def s = {radius};
    dig_body ball = add_body(w, d, "sphere", &s);
    Rest r = run_to_rest(w, 10);
    CHECK_NEAR(r.at, rest_time(height, e), 1e-10);
    CHECK_NEAR(state_of(w, ball).velocity.x, radius * w0 * 2 / 7, 1e-10);
    CHECK_NEAR(state_of(w, ball).spin.z, -w0 * 2 / 7, 1e-10);
    CHECK(r.events < 60);
    dig_world_close(w);
}

/* A spin about a skew axis, slipping throughout: in long steps many bounces are taken at once, in short ones few. */
TEST(a_ball_that_turns_ends_in_the_same_orientation_whatever_the_step)
{
    static const real frames[] = {1.0 / 20, 1.0 / 1000};
    real e = 0.95, radius = 0.2, mu = 0.05, height = 0.002;
    dig_body_state s[2];
    for (int i = 0; i < 2; i++) {
        dig_world *w = open_world(frames[i], "study", true);
        Look l = {mu, NAN, 0, e};
        add_floor(w, l);
        dig_body_def d = body_with(l, (vec3){0, radius + height, 0}, quat_identity());
        d.mass = 1;
        d.spin = (vec3){3, 40, -20};
        d.velocity = (vec3){2, 0, 1};
        dig_sphere_def ball = {radius};
        dig_body b = add_body(w, d, "sphere", &ball);
        step(w, (int)round(0.8 / frames[i]));
        s[i] = state_of(w, b);
        CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-9);
        dig_world_close(w);
    }
    CHECK_NEAR(vec3_distance(s[0].position, s[1].position), 0, 1e-9);
    CHECK_NEAR(vec3_distance(s[0].spin, s[1].spin), 0, 1e-8);
    quat turn = quat_mul(s[0].rotation, quat_conjugate(s[1].rotation));
    CHECK_NEAR(hypot(hypot(turn.x, turn.y), turn.z), 0, 1e-5);
}

int main(void)
{
    RUN_TESTS(unit_test(a_ball_rests_at_the_sum_of_its_flights), unit_test(a_box_dropped_flat_rests_at_the_sum_of_its_flights),
              unit_test(a_table_that_moves_evenly_changes_nothing_but_the_place), unit_test(friction_takes_its_part_of_the_whole_impulse),
              unit_test(a_spin_that_is_used_up_in_the_series_leaves_rolling),
              unit_test(a_ball_that_turns_ends_in_the_same_orientation_whatever_the_step));
}
