/* tests/unit/test_trace_rim.c - cylinders, discs and coins on a plane: rolling, standing, sliding and precessing as in closed form.
 */
#include "physics_fixture.h"

static dig_body add_cylinder(dig_world *w, Look l, real radius, real height, real mass, vec3 at, quat q, vec3 velocity, vec3 spin)
{
    dig_body_def d = body_with(l, at, q);
    d.mass = mass;
    d.velocity = velocity;
    d.spin = spin;
    dig_cylinder_def s = {radius, height};
    return add_body(w, d, "cylinder", &s);
}

static void check_traced(const dig_world *w)
{
    dig_stats s = dig_world_stats(w);
    if (s.traced != 1 || s.gave_up > 0)
        fail_msg("at t = %g s: traced %d, gave up %d times: %s", dig_world_time(w), s.traced, (int)s.gave_up, s.gave_up_why);
}

/* A solid cylinder rolls down with a = 2/3 g sin: on a plane and on the face of a box. */
TEST(a_cylinder_rolls_down_a_slope)
{
    real angle = 0.3, radius = 0.2, a = GRAVITY * sin(angle) * 2 / 3;
    vec3 normal = {sin(angle), cos(angle), 0}, down = {cos(angle), -sin(angle), 0};
    quat lying = quat_exp((vec3){1.5707963267948966, 0, 0});
    for (int box = 0; box < 2; box++) {
        dig_world *w = open_world(1.0 / 60, "play", true);
        if (box) {
            dig_body_def d = body_with(look(0.6, 0), vec3_scale(-0.5, normal), quat_exp((vec3){0, 0, -angle}));
            d.fixed = true;
            dig_box_def s = {{40, 1, 40}};
            add_body(w, d, "box", &s);
        } else {
            add_slope(w, look(0.6, 0), normal);
        }
        dig_body c = add_cylinder(w, look(0.6, 0), radius, 0.7, 3, vec3_scale(radius, normal), lying, vec3_zero(), vec3_zero());
        for (int i = 0; i < 90; i++) {
            step(w, 1);
            check_traced(w);
        }
        real t = dig_world_time(w);
        dig_body_state s = state_of(w, c);
        CHECK_NEAR(vec3_dot(s.position, down), 0.5 * a * t * t, 1e-9);
        CHECK_NEAR(vec3_dot(s.position, normal), radius, 1e-11);
        CHECK_NEAR(s.spin.z, -a * t / radius, 1e-9);
        CHECK_NEAR(dig_world_energy(w).numerical, 0, 1e-9);
        dig_world_close(w);
    }
}

/* Thrown without spin it slides, then rolls with 2/3 of its speed. */
TEST(a_sliding_cylinder_comes_to_roll)
{
    real radius = 0.3, mu = 0.25, v = 3, stop = v / (3 * mu * GRAVITY);
    dig_world *w = open_world(1.0 / 60, "play", true);
    add_floor(w, look(mu, 0));
    dig_body c = add_cylinder(w, look(mu, 0), radius, 0.5, 2, (vec3){0, radius, 0}, quat_exp((vec3){1.5707963267948966, 0, 0}), (vec3){v, 0, 0},
                              vec3_zero());
    for (int i = 0; i < 60; i++) {
        step(w, 1);
        check_traced(w);
    }
    dig_body_state s = state_of(w, c);
    CHECK_NEAR(s.velocity.x, 2 * v / 3, 1e-9);
    CHECK_NEAR(s.spin.z, -2 * v / 3 / radius, 1e-9);
    CHECK_NEAR(s.position.x, v * stop - 0.5 * mu * GRAVITY * stop * stop + 2 * v / 3 * (1 - stop), 1e-9);
    dig_world_close(w);
}

/* Standing it rests on its points; pushed along it slides without tipping: the height of its centre is below radius / mu. */
TEST(an_upright_cylinder_rests_and_slides)
{
    real radius = 0.3, mu = 0.4, v = 1.5, stop = v / (mu * GRAVITY);
    for (int moving = 0; moving < 2; moving++) {
        dig_world *w = open_world(1.0 / 60, "play", true);
        add_floor(w, look(mu, 0));
        dig_body c = add_cylinder(w, look(mu, 0), radius, 0.6, 2, (vec3){0, 0.3, 0}, quat_identity(), (vec3){moving ? v : 0, 0, 0}, vec3_zero());
        for (int i = 0; i < 30; i++) {
            step(w, 1);
            check_traced(w);
        }
        dig_body_state s = state_of(w, c);
        CHECK_NEAR(s.position.x, moving ? v * stop - 0.5 * mu * GRAVITY * stop * stop : 0, 1e-9);
        CHECK_NEAR(s.position.y, 0.3, 1e-11);
        CHECK_NEAR(vec3_length(s.spin), 0, 1e-9);
        dig_world_close(w);
    }
}

/* A disc that rolls on its edge in steady precession (Euler's disc): tilted, its centre at rest, the contact running round under it.
 * The material at the contact rests, so the angular velocity w lies along the line from the centre to the contact, w = k c. The axis
 * turns at W about the vertical, w x axis = W y x axis, and with it the angular momentum: W y x L = r x (m g y), r to the contact. */
static void check_steady(real tilt, real thickness, real seconds, real within)
{
    real radius = 0.1, mass = 0.2, half = thickness / 2;
    real about = mass * radius * radius / 2, across = mass * (radius * radius / 4 + thickness * thickness / 12);
    real side = radius * cos(tilt) - half * sin(tilt), h = radius * sin(tilt) + half * cos(tilt), length = hypot(side, h);
    vec3 c = {side / length, -h / length, 0}, axis = {sin(tilt), cos(tilt), 0}, y = {0, 1, 0};     /* the contact at +x */
    real spin = vec3_dot(c, axis);
    vec3 l = vec3_add(vec3_scale(about * spin, axis), vec3_scale(across, vec3_mad(c, -spin, axis)));         /* per k */
    real share = vec3_cross(c, axis).z / vec3_cross(y, axis).z;                                             /* W / k */
    real torque = vec3_cross(vec3_scale(length, c), vec3_scale(mass * GRAVITY, y)).z;
    real k = sqrt(torque / (share * vec3_cross(y, l).z)), turn = k * share;
    CHECK(isfinite(k));
    dig_world *w = open_world(1.0 / 240, "study", true);
    add_floor(w, look(2, 0));
    dig_body disc = add_cylinder(w, look(2, 0), radius, thickness, mass, (vec3){0, h, 0}, quat_exp((vec3){0, 0, -tilt}), vec3_zero(),
                                 vec3_scale(k, c));
    for (int i = 0; i < (int)round(240 * seconds); i++) {
        step(w, 1);
        check_traced(w);
    }
    dig_body_state s = state_of(w, disc);
    real t = dig_world_time(w);
    vec3 now = quat_rotate(s.rotation, y), want = {sin(tilt) * cos(turn * t), cos(tilt), -sin(tilt) * sin(turn * t)};
    printf("disc tilted %g: turns at %g rad/s, off by %g m and %g rad after %g s\n", tilt, turn, vec3_distance(s.position, (vec3){0, h, 0}),
           vec3_distance(now, want), t);
    CHECK_NEAR(vec3_distance(s.position, (vec3){0, h, 0}), 0, within);
    CHECK_NEAR(vec3_distance(now, want), 0, 100 * within);
    dig_world_close(w);
}

TEST(a_disc_precesses_steadily_on_its_rim)
{
    check_steady(0.5, 0.002, 1, 1e-8);
    check_steady(0.2, 0.01, 1, 1e-7);
}

int main(void)
{
    RUN_TESTS(unit_test(a_cylinder_rolls_down_a_slope), unit_test(a_sliding_cylinder_comes_to_roll),
              unit_test(an_upright_cylinder_rests_and_slides), unit_test(a_disc_precesses_steadily_on_its_rim));
}
