/* tests/unit/test_stage.c - what of a scene counts for its light: the whole of what is seen, whatever small bodies do. */
#include "picture_fixture.h"
#include "render/stage.h"

enum { WIDTH = 160, HEIGHT = 90 };

/* Two fixed boxes of 6 m, 22 m apart on a floor, seen from 20 m. */
static RenderOptions banks(Scene *s)
{
    scene_open(s);
    add(s, VIEW_PLANE, 0, 0, 0, 0, 0, 0);
    add(s, VIEW_BOX, 6, 3, 4, -11.1, 1.5, 0)->fixed = true;
    add(s, VIEW_BOX, 6, 3, 4, 11.1, 1.5, 0)->fixed = true;
    RenderOptions o = render_defaults();
    o.width = WIDTH;
    o.height = HEIGHT;
    o.camera = (RenderCamera){{0, 6, 20}, {0, 3, 0}, {0, 1, 0}, 0.96};
    return o;
}

static StageEye eye_of(const RenderOptions *o)
{
    return (StageEye){{o->camera.at[0], o->camera.at[1], o->camera.at[2]}, tan(0.5 * o->camera.fov)};
}

/* Pixels that differ by more than a few levels. */
static int count_other(const unsigned char *a, const unsigned char *b)
{
    int other = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int most = 0;
        for (int k = 0; k < 3; k++)
            most = int_max(most, abs(a[3 * i + k] - b[3 * i + k]));
        other += most > 6;
    }
    return other;
}

TEST(a_small_body_changes_only_its_own_pixels)
{
    static const float suns[][3] = {{0, 0, 0}, {3, 6, 2}, {-3, 2, 1}};
    static unsigned char without[3 * WIDTH * HEIGHT];
    Scene s;
    RenderOptions o = banks(&s);
    for (int k = 0; k < 3; k++)
        for (int samples = 0; samples <= 4; samples += 4) {
            o.samples = samples;
            memcpy(o.sun, suns[k], sizeof o.sun);
            s.view.item_count = 3;
            memcpy(without, draw(&s, &o), sizeof without);
            s.view.mesh_count = 3;
            add(&s, VIEW_SPHERE, 0.1, 0, 0, 0, 0.1, 0);
            CHECK(count_other(without, draw(&s, &o)) <= 6);       /* 250 to 2000 if the ball were all that counts */
        }
}

/* The largest change, 1, of the box in units of its size while the ball goes on by one step of `step` m. */
static real follow(Scene *s, const RenderOptions *o, ViewItem *ball, vec3 way, real step, int count, real *most_unit)
{
    StageEye eye = eye_of(o);
    Stage before = stage_of(&s->view, &eye);
    real worst = 0;
    *most_unit = before.unit;
    for (int i = 1; i <= count; i++) {
        for (int k = 0; k < 3; k++)
            ball->p[k] += (float)(step * (k == 0 ? way.x : k == 1 ? way.y : way.z));
        Stage now = stage_of(&s->view, &eye);
        vec3 low = vec3_sub(vec3_mad(now.centre, now.unit, now.low), vec3_mad(before.centre, before.unit, before.low));
        vec3 high = vec3_sub(vec3_mad(now.centre, now.unit, now.high), vec3_mad(before.centre, before.unit, before.high));
        worst = real_max(worst, real_max(vec3_length(low), vec3_length(high)) / now.unit);
        *most_unit = real_max(*most_unit, now.unit);
        before = now;
    }
    return worst;
}

TEST(who_flies_off_is_let_go_without_a_jump)
{
    static const vec3 ways[] = {{1, 0, 0}, {0.8, 0.6, 0}, {0, 0, -1}, {0.6, 0, 0.8}};
    for (int k = 0; k < 4; k++) {
        Scene s;
        RenderOptions o = banks(&s);
        StageEye eye = eye_of(&o);
        real still = stage_of(&s.view, &eye).unit, most;
        ViewItem *ball = add(&s, VIEW_SPHERE, 0.1, 0, 0, 0, 1, 0);
        CHECK(follow(&s, &o, ball, ways[k], 0.1, 3000, &most) < 0.05);
        CHECK(most <= 1.5 * still);
        CHECK_NEAR(stage_of(&s.view, &eye).unit, still, 1e-9);
    }
}

/* One of a handful of equal bodies. */
TEST(one_of_a_few_that_flies_off_is_let_go)
{
    Scene s;
    RenderOptions o = banks(&s);
    scene_open(&s);
    add(&s, VIEW_PLANE, 0, 0, 0, 0, 0, 0);
    for (int i = 0; i < 4; i++)
        add(&s, VIEW_BOX, 1, 1, 1, 1.5 * i - 2, 0.5, 14);
    StageEye eye = eye_of(&o);
    real still = stage_of(&s.view, &eye).unit, most;
    ViewItem *fifth = add(&s, VIEW_BOX, 1, 1, 1, 4, 0.5, 14);
    CHECK(follow(&s, &o, fifth, (vec3){0.8, 0, -0.6}, 0.1, 3000, &most) < 0.1);
    CHECK_NEAR(stage_of(&s.view, &eye).unit, still, 1e-9);
}

/* The nearer the eye comes to a small body, the more it alone counts, and that without a jump. */
TEST(coming_near_a_small_body_makes_it_the_scene)
{
    Scene s;
    RenderOptions o = banks(&s);
    add(&s, VIEW_SPHERE, 0.1, 0, 0, 0, 0.1, 0);
    StageEye eye = eye_of(&o);
    real last = stage_of(&s.view, &eye).unit;
    CHECK(last > 14);
    while (eye.at.z > 0.5) {
        eye.at = vec3_scale(0.99, eye.at);
        real unit = stage_of(&s.view, &eye).unit;
        CHECK(unit / last > 0.6 && unit / last < 1.2);
        last = unit;
    }
    CHECK(last < 0.3);
}

/* Far beyond the sun map, on the side that is away from the sun: nothing hides the sun there. */
TEST(what_lies_beyond_the_sun_map_is_lit)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_SPHERE, 1, 0, 0, 0, 0, 0);
    ViewItem *wall = add(&s, VIEW_BOX, 60, 60, 1, 0, 0, -40);
    wall->fixed = true;
    RenderOptions o = render_defaults();
    o.width = WIDTH;
    o.height = HEIGHT;
    o.camera = (RenderCamera){{0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 0.8};
    o.sun[1] = 0.3f;
    o.sun[2] = 1;
    for (int samples = 0; samples <= 4; samples += 4) {
        o.samples = samples;
        o.shadows = false;
        const unsigned char *pixel = (const unsigned char *)draw(&s, &o) + 3 * (WIDTH * 10 + 20);
        int open = pixel[1];
        o.shadows = true;
        pixel = (const unsigned char *)draw(&s, &o) + 3 * (WIDTH * 10 + 20);
        CHECK_NEAR(pixel[1], open, 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(a_small_body_changes_only_its_own_pixels),
        unit_test(who_flies_off_is_let_go_without_a_jump),
        unit_test(one_of_a_few_that_flies_off_is_let_go),
        unit_test(coming_near_a_small_body_makes_it_the_scene),
        unit_test(what_lies_beyond_the_sun_map_is_lit),
    };
    return cmocka_run_group_tests(tests, open_shared, close_shared);
}
