/* tests/bench/selftest.c - does the checker find what is there? Overlaps known in closed form, a joint apart, a body lost.
 *
 * Run before every measurement: a checker that sees nothing would call everything fast.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "scene.h"

static const double level[4] = {0, 0, 0, 1};
static const double deep = 0.01;           /* m, of every overlap below */

static const BenchBody ball = {.kind = BENCH_SPHERE, .size = {0.25}}, cube = {.kind = BENCH_BOX, .size = {0.5, 0.5, 0.5}},
                       pill = {.kind = BENCH_CAPSULE, .size = {0.18, 0.2}}, ico = {.kind = BENCH_HULL, .size = {0.3}};

static int expect(const char *what, double got, double want)
{
    if (fabs(got - want) <= 1e-9)
        return 0;
    printf("bench: the checker finds %.12g in '%s', and it is %.12g\n", got, what, want);
    return 1;
}

static int pair_once(const char *what, const BenchBody body[2], const BenchPose pose[2], double want)
{
    BenchBody copy[2] = {body[0], body[1]};
    BenchScene scene = {.body = copy, .bodies = 2, .ball = -1};
    BenchFound found;
    bench_check(&scene, pose, &found);
    return expect(what, found.penetration_max, want) + expect(what, found.overlaps, want > 0);
}

/* Body a at the origin, b at (x, y, z): how deep do they overlap, whichever comes first? */
static int pair(const char *what, BenchBody a, const double turn_a[4], BenchBody b, const double turn_b[4], double x, double y, double z,
                double want)
{
    BenchPose at_a = {{0, 0, 0}, {0}}, at_b = {{x, y, z}, {0}};
    memcpy(at_a.turn, turn_a, sizeof at_a.turn);
    memcpy(at_b.turn, turn_b, sizeof at_b.turn);
    return pair_once(what, (BenchBody[2]){a, b}, (BenchPose[2]){at_a, at_b}, want) +
           pair_once(what, (BenchBody[2]){b, a}, (BenchPose[2]){at_b, at_a}, want);
}

static int pairs(void)
{
    const double pi = acos(-1), diagonal = sqrt(0.5);
    const double about_x[4] = {sin(pi / 8), 0, 0, cos(pi / 8)}, about_y[4] = {0, sin(pi / 8), 0, cos(pi / 8)};
    const double about_z[4] = {0, 0, sin(pi / 8), cos(pi / 8)};
    const double lying_x[4] = {0, 0, diagonal, diagonal}, lying_z[4] = {diagonal, 0, 0, diagonal};
    const double face = 0.3 * sqrt((5 + 2 * sqrt(5.0)) / 15), along = (face + 0.25 - deep) / sqrt(3);       /* the icosahedron's inradius */
    int bad = 0;
    bad += pair("spheres", ball, level, ball, level, 0.3, 0, 0.4 - 0.01, 0.5 - hypot(0.3, 0.39));
    bad += pair("spheres apart", ball, level, ball, level, 0.3, 0, 0.4 + 1e-6, 0);
    bad += pair("boxes, face on face", cube, level, cube, about_y, 0.1, 1 - deep, 0.2, deep);
    bad += pair("boxes, edge on face", cube, level, cube, about_x, 0.1, 0.5 + diagonal - deep, 0, deep);
    bad += pair("boxes, edge across edge", cube, about_z, cube, about_x, 0, 2 * diagonal - deep, 0, deep);
    bad += pair("boxes, edges apart", cube, about_z, cube, about_x, 0, 2 * diagonal + 1e-6, 0, 0);
    bad += pair("sphere on a corner", cube, level, ball, level, 0.5 + 0.14, 0.5 + 0.14, 0.5 + 0.14, 0.25 - 0.14 * sqrt(3));
    bad += pair("sphere beside a corner", cube, level, ball, level, 0.5 + 0.15, 0.5 + 0.15, 0.5 + 0.15, 0);
    bad += pair("sphere on a capsule's end", pill, level, ball, level, 0, 0.2 + 0.18 + 0.25 - deep, 0, deep);
    bad += pair("capsule across capsule", pill, lying_x, pill, lying_z, 0.05, 0.36 - deep, 0.05, deep);
    bad += pair("capsule on a box", cube, about_y, pill, lying_x, 0, 0.5 + 0.18 - deep, 0, deep);
    bad += pair("sphere on a face of the hull", ico, level, ball, level, along, along, along, deep);
    bad += pair("hull, its edge on a box", cube, level, ico, level, 0, 0.5 + 0.3 * sqrt((5 + sqrt(5.0)) / 10) - deep, 0, deep);
    return bad;
}

static int whole_scene(void)
{
    BenchBody body[3] = {cube, pill, ball};
    BenchJoint joint = {0, 1, {0, 1, 0}};
    BenchScene scene = {.body = body, .bodies = 3, .joint = &joint, .joints = 1, .plane = {{0, 1, 0, 0}}, .planes = 1, .ball = -1};
    BenchPose pose[3] = {{{0, 0.5 - deep, 0}, {0, 0, 0, 1}}, {{0, 3, 0}, {0, 0, 0, 1}}, {{9, -3, 0}, {0, 0, 0, 1}}};
    int top[2] = {0, 1}, bad = 0;
    BenchFound found;
    scene.top = top;
    scene.tops = 2;
    body[0].at[1] = 0.5;
    body[1].at[1] = 3;
    memcpy(body[0].turn, level, sizeof level);
    memcpy(body[1].turn, level, sizeof level);
    bench_check(&scene, pose, &found);
    bad += expect("box in the ground", found.penetration_max, deep);
    bad += expect("joint apart", found.joint_error, deep);
    bad += expect("mean height", found.top_height, (3.5 - deep) / 2);
    bad += expect("bodies lost", found.lost, 1);
    pose[1].at[0] = NAN;
    bench_check(&scene, pose, &found);
    return bad + expect("bodies lost, one without a place", found.lost, 2);
}

int main(void) { return pairs() + whole_scene() > 0; }
