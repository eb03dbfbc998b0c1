/* tests/unit/test_trace_energy.c - traced mechanisms that nothing drives or brakes: their energy stays where it was, frame after
 * frame, and what is held leaves momentum, joints and the motion itself alone.
 *
 * Without it the rod pendulum here drifts by 2e-7 J, the double one by 1e-4 J, the sprung one by 1e-5 J, the free pair by 1e-6 J.
 */
#include "base/param.h"
#include "physics_fixture.h"

enum { FRAMES = SANITIZED ? 1000 : 6000 };
static const dig_body nobody = {0, 0};
static const vec3 z_axis = {0, 0, 1};

static dig_body add_rod(dig_world *w, vec3 at, vec3 spin)
{
    dig_body_def d = body_with(look(0, 0), at, quat_identity());
    d.mass = 1;
    d.collides = false;
    d.spin = spin;
    d.velocity = vec3_cross(spin, at);
    return add_body(w, d, "box", &(dig_box_def){{1, 0.1, 0.1}});
}

static void sprung_hinge(dig_world *w, dig_body a, vec3 at, real stiffness, real damping)
{
    char data[1024];
    const dig_schema *schema = dig_schema_find("joint", "hinge");
    CHECK(schema && schema->size <= sizeof data);
    dig_schema_defaults(schema, data);
    const char *names[2] = {"spring.stiffness", "spring.damping"};
    const real values[2] = {stiffness, damping};
    for (int i = 0; i < 2; i++) {
        size_t offset;
        CHECK(param_find_path(schema->rows, names[i], &offset));
        memcpy(data + offset, &values[i], sizeof(real));
    }
    create_joint(w, "hinge", a, nobody, at, z_axis, data);
}

/* Runs it, traced; the greatest |what the integration made up|, J. */
static real made_up(dig_world *w)
{
    real most = 0;
    for (int i = 0; i < FRAMES; i++) {
        step(w, 1);
        CHECK_INT(dig_world_stats(w).traced, dig_world_stats(w).groups);
        CHECK(dig_world_stats(w).joint_error < 1e-6);
        most = real_max(most, fabs(dig_world_energy(w).numerical));
    }
    return most;
}

TEST(rod_pendulum_keeps_its_energy_at_every_plan)
{
    const char *plans[] = {"play", "study"};
    for (int k = 0; k < 2; k++) {
        dig_world *w = open_world(1.0 / 60, plans[k], true);
        join_bodies(w, "hinge", add_rod(w, (vec3){0.5, 0, 0}, vec3_zero()), nobody, vec3_zero(), z_axis);
        CHECK_NEAR(made_up(w), 0, 1e-10);
        dig_world_close(w);
    }
}

/* A frame that ends as the rod turns back: no velocity is left that could be scaled. Fallen for a frame, and thrown back as it fell. */
TEST(what_turns_back_at_the_end_of_a_frame_keeps_its_energy)
{
    dig_world *w = open_world(1.0 / 30, "play", true);
    dig_body rod = add_rod(w, (vec3){0.5, 0, 0}, vec3_zero());
    join_bodies(w, "hinge", rod, nobody, vec3_zero(), z_axis);
    step(w, 1);
    dig_body_state s = state_of(w, rod);
    vec3 back = vec3_neg(s.velocity), spin = vec3_neg(s.spin);
    CHECK_INT(dig_body_teleport(w, rod, NULL, NULL, &back, &spin), DIG_OK);
    real before = dig_world_energy(w).numerical;
    step(w, 1);
    s = state_of(w, rod);
    CHECK_NEAR(s.spin.z, 0, 1e-4);
    CHECK_NEAR(dig_world_energy(w).numerical, before, 1e-13);           /* 3e-9 J else */
    CHECK_NEAR(vec3_length(s.position), 0.5, 1e-9);
    dig_world_close(w);
}

TEST(double_pendulum_keeps_its_energy)
{
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body a = add_rod(w, (vec3){0.5, 0, 0}, vec3_zero()), b = add_rod(w, (vec3){1.5, 0, 0}, vec3_zero());
    join_bodies(w, "hinge", a, nobody, vec3_zero(), z_axis);
    join_bodies(w, "hinge", b, a, (vec3){1, 0, 0}, z_axis);
    CHECK_NEAR(made_up(w), 0, 1e-8);
    dig_world_close(w);
}

TEST(sprung_pendulum_keeps_its_energy_and_a_damped_one_loses_what_it_should)
{
    dig_world *w = open_world(1.0 / 60, "play", true);
    sprung_hinge(w, add_rod(w, (vec3){0.5, 0, 0}, vec3_zero()), vec3_zero(), 20, 0);
    CHECK_NEAR(made_up(w), 0, 1e-8);
    dig_world_close(w);
    w = open_world(1.0 / 60, "play", true);
    sprung_hinge(w, add_rod(w, (vec3){0.5, 0, 0}, vec3_zero()), vec3_zero(), 20, 0.5);
    CHECK_NEAR(made_up(w), 0, 1e-6);
    CHECK(dig_world_energy(w).lost > 0.5);
    CHECK(dig_world_energy(w).kinetic < 1e-3);
    dig_world_close(w);
}

/* On nothing: only the motion against each other is scaled. */
TEST(free_pair_keeps_energy_and_both_momenta)
{
    dig_world *w = open_world(1.0 / 60, "play", false);
    dig_body a = add_rod(w, (vec3){-0.5, 0, 0}, (vec3){1, 0.5, 4}), b = add_rod(w, (vec3){0.5, 0, 0}, (vec3){1, 0.5, -2});
    join_bodies(w, "ball", a, b, vec3_zero(), z_axis);
    vec3 p = dig_world_momentum(w), l = dig_world_angular_momentum(w);
    CHECK_NEAR(made_up(w), 0, 1e-9);
    CHECK(vec3_distance(dig_world_momentum(w), p) < 1e-11);
    CHECK(vec3_distance(dig_world_angular_momentum(w), l) < 3e-7);      /* as without: the local errors of 6000 frames */
    dig_world_close(w);
}

/* A joint that someone left apart is closed by moving what it joins: what flies fast then goes by another line, about which it would have
 * another angular momentum (6e-4 kg m^2/s more here, were it not held). */
TEST(a_joint_put_right_keeps_both_momenta)
{
    dig_world *w = open_world(1.0 / 60, "play", false);
    dig_body a = add_rod(w, (vec3){-0.5, 0, 0}, (vec3){1, 0.5, 4}), b = add_rod(w, (vec3){0.5, 0, 0}, (vec3){1, 0.5, -2});
    join_bodies(w, "ball", a, b, vec3_zero(), z_axis);
    step(w, 1);
    dig_body_state s = state_of(w, b);
    vec3 at = vec3_add(s.position, (vec3){1e-3, -2e-3, 1e-3});
    CHECK_INT(dig_body_teleport(w, b, &at, &s.rotation, &s.velocity, &s.spin), DIG_OK);
    vec3 p = dig_world_momentum(w), l = dig_world_angular_momentum(w);
    step(w, 1);
    CHECK(dig_world_stats(w).traced == 1);
    CHECK(dig_world_stats(w).joint_error < 1e-9);
    CHECK(vec3_distance(dig_world_momentum(w), p) < 1e-13);
    CHECK(vec3_distance(dig_world_angular_momentum(w), l) < 1e-12);
    dig_world_close(w);
}

/* Two that may meet are in one group: the errors of the faster one are not made good by the other. */
TEST(neighbours_do_not_share_their_energy)
{
    const real spins[2] = {0, 12};
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body rods[2];
    real start[2];
    int together = 0;
    for (int k = 0; k < 2; k++) {
        dig_body_def d = body_with(look(0, 0), (vec3){0.5, 0, 0.11 * k}, quat_identity());
        d.mass = 1;
        d.spin = (vec3){0, 0, spins[k]};
        d.velocity = (vec3){0, 0.5 * spins[k], 0};
        rods[k] = add_body(w, d, "box", &(dig_box_def){{1, 0.1, 0.1}});
        join_bodies(w, "hinge", rods[k], nobody, (vec3){0, 0, 0.11 * k}, z_axis);
        start[k] = 0.5 * (0.25 + 1.01 / 12) * spins[k] * spins[k];
    }
    for (int i = 0; i < 600; i++) {
        step(w, 1);
        together += dig_world_stats(w).groups == 1;
        for (int k = 0; k < 2; k++) {
            dig_body_state s = state_of(w, rods[k]);
            real kinetic = 0.5 * vec3_length2(s.velocity) + 0.5 * 1.01 / 12 * vec3_length2(s.spin);
            CHECK_NEAR(kinetic + GRAVITY * s.position.y, start[k], 1e-9);
        }
    }
    CHECK(together > 100);
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(rod_pendulum_keeps_its_energy_at_every_plan),
              unit_test(what_turns_back_at_the_end_of_a_frame_keeps_its_energy), unit_test(double_pendulum_keeps_its_energy),
              unit_test(sprung_pendulum_keeps_its_energy_and_a_damped_one_loses_what_it_should),
              unit_test(free_pair_keeps_energy_and_both_momenta), unit_test(a_joint_put_right_keeps_both_momenta),
              unit_test(neighbours_do_not_share_their_energy));
}
