/* tests/unit/test_shape.c - the primitives: mass, support, bounds, rays, faces and pictures against closed forms. */
#include <stdlib.h>

#include "check.h"
#include "draw_fixture.h"
#include "geom/mass.h"

/* ---- the cast ---- */

static const dig_sphere_def   ball   = {0.7};
static const dig_box_def      block  = {{1, 2, 3}};
static const dig_capsule_def  pill   = {0.3, 1.2};
static const dig_cylinder_def drum   = {0.5, 1.4};
static const dig_cone_def     funnel = {0.6, 2};

#define SOLIDS 5
static Shape solid(int i)
{
    static const char *const types[SOLIDS] = {"sphere", "box", "capsule", "cylinder", "cone"};
    const void *const defs[SOLIDS] = {&ball, &block, &pill, &drum, &funnel};
    Shape s;
    char why[256] = "";
    if (shape_make(types[i], defs[i], &s, why, sizeof why) != DIG_OK)
        fail_msg("%s: %s", types[i], why);
    return s;
}

static pose draw_pose(uint64_t *state)
{
    vec3 p = vec3_scale(10, draw_vec3(state));
    return (pose){p, quat_exp(vec3_scale(3, draw_unit(state)))};
}

/* ---- mass ---- */

/* Radius squared at height y above the origin of the solids of revolution. */
static real radius2(int i, real y)
{
    switch (i) {
    case 0:  return 0.7 * 0.7 - y * y;
    case 2: {
        real over = real_max(fabs(y) - 0.6, 0);
        return 0.3 * 0.3 - over * over;
    }
    case 3:  return 0.5 * 0.5;
    default: return (1.5 - y) * 0.3 * (1.5 - y) * 0.3;      /* 0.6 / 2 a metre, apex at 3h/4 */
    }
}

/* Stacks thin discs between two heights with Simpson's rule: dV = pi r^2, dI_y = pi r^4 / 2, dI_x = pi (r^4 / 4 + r^2 y^2). */
static void stack_discs(int i, real low, real high, real sum[4])
{
    const int n = 2000;
    for (int k = 0; k <= n; k++) {
        real y = low + (high - low) * k / n, w = (high - low) / n / 3 * (k == 0 || k == n ? 1 : k % 2 ? 4 : 2);
        real r2 = radius2(i, y);
        sum[0] += w * DIG_PI * r2;
        sum[1] += w * DIG_PI * r2 * y;
        sum[2] += w * DIG_PI * r2 * r2 / 2;
        sum[3] += w * DIG_PI * (r2 * r2 / 4 + r2 * y * y);
    }
}

TEST(solids_of_revolution_weigh_what_their_discs_weigh)
{
    static const real cuts[SOLIDS][4] = {{-0.7, 0, 0, 0.7}, {0}, {-0.9, -0.6, 0.6, 0.9}, {-0.7, 0, 0, 0.7}, {-0.5, 0, 0, 1.5}};
    for (int i = 0; i < SOLIDS; i++) {
        if (i == 1)
            continue;
        real sum[4] = {0};
        for (int k = 0; k < 3; k++)
            stack_discs(i, cuts[i][k], cuts[i][k + 1], sum);
        Shape s = solid(i);
        MassProps m;
        s.type->mass(&s, &m);
        CHECK_NEAR(m.volume, sum[0], 1e-11);
        CHECK_NEAR(m.centre.x, 0, 0);
        CHECK_NEAR(m.centre.y * m.volume, sum[1], 1e-11);
        CHECK_NEAR(m.centre.z, 0, 0);
        CHECK_NEAR(m.inertia.r1.y, sum[2], 1e-11);
        CHECK_NEAR(m.inertia.r0.x, sum[3], 1e-11);
        CHECK_NEAR(m.inertia.r2.z, sum[3], 1e-11);
        CHECK_NEAR(m.inertia.r0.y, 0, 0);
        CHECK_NEAR(m.inertia.r0.z, 0, 0);
        CHECK_NEAR(m.inertia.r1.z, 0, 0);
        shape_free(&s);
    }
}

TEST(textbook_masses)
{
    MassProps m;
    Shape s = solid(0);
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 4 * DIG_PI * 0.343 / 3, 1e-15);
    CHECK_NEAR(m.inertia.r0.x / m.volume, 0.4 * 0.49, 1e-15);
    shape_free(&s);

    s = solid(1);
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 6, 1e-14);
    CHECK_NEAR(m.inertia.r0.x, 6.0 * (4 + 9) / 12, 1e-14);
    CHECK_NEAR(m.inertia.r1.y, 6.0 * (9 + 1) / 12, 1e-14);
    CHECK_NEAR(m.inertia.r2.z, 6.0 * (1 + 4) / 12, 1e-14);
    shape_free(&s);

    s = solid(3);
    s.type->mass(&s, &m);
    CHECK_NEAR(m.inertia.r1.y / m.volume, 0.125, 1e-15);
    CHECK_NEAR(m.inertia.r0.x / m.volume, 0.25 / 4 + 1.96 / 12, 1e-15);
    shape_free(&s);

    s = solid(4);
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, DIG_PI * 0.36 * 2 / 3, 1e-15);
    CHECK_NEAR(m.inertia.r1.y / m.volume, 0.3 * 0.36, 1e-15);
    shape_free(&s);
}

static real picture_area(const Shape *s)
{
    ShapeMesh m = {0};
    real sum = 0;
    CHECK(s->type->mesh(s, &m) == DIG_OK);
    for (int i = 0; i < m.index_count; i += 3) {
        vec3 c[3];
        for (int k = 0; k < 3; k++) {
            const float *v = m.vertices + 3 * m.indices[i + k];
            c[k] = (vec3){v[0], v[1], v[2]};
        }
        sum += 0.5 * vec3_length(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])));
    }
    free(m.vertices);
    free(m.normals);
    free(m.indices);
    return sum;
}

TEST(surfaces)
{
    static const real want[SOLIDS] = {4 * DIG_PI * 0.49, 22, 4 * DIG_PI * 0.3 * 0.9, 2 * DIG_PI * 0.5 * 1.9, DIG_PI * 0.6 * (0.6 + 2.08806130178211)};
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        CHECK_NEAR(s.type->area(&s), want[i], 1e-12);
        CHECK_NEAR(picture_area(&s) / want[i], 0.985, 0.0151);      /* of corners that lie on the surface */
        shape_free(&s);
    }
    vec3 corner[8];
    for (int i = 0; i < 8; i++)
        corner[i] = (vec3){i & 1 ? 1 : 0, i & 2 ? 2 : 0, i & 4 ? 3 : 0};
    Shape s;
    char why[256];
    CHECK(shape_make("hull", &(dig_hull_def){{corner, 8}}, &s, why, sizeof why) == DIG_OK);
    CHECK_NEAR(s.type->area(&s), 22, 1e-12);
    shape_free(&s);
    const int64_t triangle[3] = {1, 2, 3};
    CHECK(shape_make("mesh", &(dig_mesh_def){{corner, 3}, {triangle, 3}}, &s, why, sizeof why) == DIG_OK);
    CHECK_NEAR(s.type->area(&s), 1, 1e-15);
    shape_free(&s);
    const real heights[6] = {0, 0, 0, 1, 1, 1};
    CHECK(shape_make("heightfield", &(dig_heightfield_def){.heights = heights, .columns = 3, .rows = 2, .size = {4, 0, 1}}, &s, why, sizeof why) == DIG_OK);
    CHECK_NEAR(s.type->area(&s), 4 * sqrt(2), 1e-14);
    shape_free(&s);
}

/* ---- support, bounds, balls inside and outside ---- */

/* The support function of each solid, rounding included: how far it reaches along a unit vector. */
static real reach(int i, vec3 d)
{
    real across = sqrt(d.x * d.x + d.z * d.z);
    switch (i) {
    case 0:  return 0.7;
    case 1:  return 0.5 * fabs(d.x) + fabs(d.y) + 1.5 * fabs(d.z);
    case 2:  return 0.6 * fabs(d.y) + 0.3;
    case 3:  return 0.7 * fabs(d.y) + 0.5 * across;
    default: return fmax(1.5 * d.y, 0.6 * across - 0.5 * d.y);
    }
}

TEST(support_reaches_as_far_as_the_solid)
{
    uint64_t state = 1;
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        for (int k = 0; k < 3000; k++) {
            vec3 d = draw_unit(&state);
            vec3 p = s.type->support(&s, vec3_scale(exp(20 * draw(&state)), d));       /* the length must not matter */
            CHECK_NEAR(vec3_dot(p, d) + s.round, reach(i, d), 1e-14);
            CHECK(s.type->contains(&s, vec3_scale(1 - 1e-12, p)));
        }
        for (int axis = 0; axis < 6; axis++) {
            real e = axis % 2 ? -1 : 1;
            vec3 d = {axis / 2 == 0 ? e : 0, axis / 2 == 1 ? e : 0, axis / 2 == 2 ? e : 0};
            CHECK_NEAR(vec3_dot(s.type->support(&s, d), d) + s.round, reach(i, d), 1e-15);
        }
        shape_free(&s);
    }
}

TEST(bounds_touch_the_solid_on_all_sides)
{
    uint64_t state = 2;
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        for (int k = 0; k < 500; k++) {
            pose at = draw_pose(&state);
            box3 b = s.type->bounds(&s, at);
            for (int axis = 0; axis < 3; axis++) {
                vec3 d = {axis == 0, axis == 1, axis == 2};
                CHECK_NEAR(vec3_at(b.high, axis), vec3_at(at.p, axis) + reach(i, quat_unrotate(at.q, d)), 1e-14 * 20);
                CHECK_NEAR(vec3_at(b.low, axis), vec3_at(at.p, axis) - reach(i, quat_unrotate(at.q, vec3_neg(d))), 1e-14 * 20);
            }
        }
        shape_free(&s);
    }
}

TEST(the_inner_ball_fits_and_the_outer_ball_covers)
{
    uint64_t state = 3;
    static const real inner[SOLIDS] = {0.7, 0.5, 0.3, 0.5, 0.43095};    /* cone: 1.5 * 0.6 / sqrt(4.36), but 0.5 to the base */
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        CHECK_NEAR(s.inner, inner[i], 1e-4);
        real farthest = 0;
        for (int k = 0; k < 3000; k++) {
            vec3 d = draw_unit(&state);
            CHECK(s.type->contains(&s, vec3_scale(s.inner * (1 - 1e-12), d)));
            CHECK(!s.type->contains(&s, vec3_scale(s.outer * (1 + 1e-12), d)));
            farthest = fmax(farthest, vec3_length(s.type->support(&s, d)) + s.round);
        }
        CHECK_NEAR(s.outer, farthest, 1e-12);
        shape_free(&s);
    }
}

TEST(only_round_things_roll)
{
    static const real rolling[SOLIDS] = {0.7, 0, 0.3, 0.5, 0};
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        CHECK_NEAR(s.rolling, rolling[i], 0);
        shape_free(&s);
    }
}

/* ---- rays ---- */

TEST(rays_hit_where_geometry_says)
{
    const struct { int shape; vec3 from, along; real distance; vec3 normal; } shots[] = {
        {0, {-5, 0, 0}, {1, 0, 0}, 4.3, {-1, 0, 0}},
        {0, {-5, 0.42, 0}, {1, 0, 0}, 5 - 0.56, {-0.8, 0.6, 0}},               /* 0.42^2 + 0.56^2 = 0.7^2 */
        {1, {3, 0.9, 1.4}, {-1, 0, 0}, 2.5, {1, 0, 0}},
        {1, {0, -7, 0}, {0, 1, 0}, 6, {0, -1, 0}},
        {2, {0, 5, 0}, {0, -1, 0}, 4.1, {0, 1, 0}},
        {2, {4, 0.5, 0}, {-1, 0, 0}, 3.7, {1, 0, 0}},
        {2, {4, 0.78, 0}, {-1, 0, 0}, 4 - 0.24, {0.8, 0.6, 0}},                /* 0.18^2 + 0.24^2 = 0.3^2 above the end */
        {3, {0.2, 3, 0.2}, {0, -1, 0}, 2.3, {0, 1, 0}},
        {3, {0.3, 0.1, -2}, {0, 0, 1}, 2 - 0.4, {0.6, 0, -0.8}},
        {4, {0.1, -3, 0}, {0, 1, 0}, 2.5, {0, -1, 0}},
        {4, {5, 0.5, 0}, {-1, 0, 0}, 4.7, {2 / 2.08806130178211, 0.6 / 2.08806130178211, 0}},
        {4, {0, 9, 0}, {0, -1, 0}, 7.5, {0, 1, 0}},
    };
    for (size_t k = 0; k < sizeof shots / sizeof *shots; k++) {
        Shape s = solid(shots[k].shape);
        RayHit hit = {0};
        Ray ray = {shots[k].from, shots[k].along, 100};
        if (!s.type->ray(&s, &ray, &hit))
            fail_msg("shot %zu missed", k);
        CHECK_NEAR(hit.distance, shots[k].distance, 1e-14);
        CHECK_NEAR(vec3_distance(hit.normal, shots[k].normal), 0, 1e-13);
        CHECK_NEAR(vec3_distance(hit.point, vec3_mad(ray.from, hit.distance, ray.along)), 0, 1e-14);

        ray.length = hit.distance - 1e-9;       /* too short by a nanometre */
        CHECK(!s.type->ray(&s, &ray, &hit));
        ray.length = 100;
        ray.along = vec3_neg(ray.along);        /* away */
        CHECK(!s.type->ray(&s, &ray, &hit));
        shape_free(&s);
    }
}

/* Whatever the shape: nothing of it lies on the ray before the hit, the hit is on the surface, and a miss meets nothing. */
static void check_shot(const Shape *s, const Ray *ray, int *hits)
{
    RayHit hit = {0};
    bool met = s->type->ray(s, ray, &hit);
    real until = met ? hit.distance : ray->length;
    for (int k = 0; k < 100; k++) {
        vec3 p = vec3_mad(ray->from, (until - 1e-9) * k / 99, ray->along);
        if (s->type->contains(s, p))
            fail_msg("%s: inside at %d %% of a free ray", s->type->name, k);
    }
    if (!met)
        return;
    ++*hits;
    CHECK_NEAR(vec3_length(hit.normal), 1, 1e-12);
    CHECK(vec3_dot(hit.normal, ray->along) <= 0);
    CHECK(s->type->contains(s, vec3_mad(hit.point, -1e-9, hit.normal)));
    CHECK(!s->type->contains(s, vec3_mad(hit.point, 1e-9, hit.normal)));
}

TEST(rays_stop_at_the_surface_and_nowhere_else)
{
    uint64_t state = 4;
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        int hits = 0, shots = 0;
        while (shots < 2000) {
            vec3 from = vec3_scale(3, draw_vec3(&state)), to = vec3_scale(0.8, draw_vec3(&state));
            Ray ray = {from, vec3_unit(vec3_sub(to, from)), 8};
            RayHit hit;
            if (s.type->contains(&s, from)) {
                CHECK(!s.type->ray(&s, &ray, &hit));
                continue;
            }
            check_shot(&s, &ray, &hits);
            shots++;
        }
        CHECK(hits > 300 && hits < 2000);
        shape_free(&s);
    }
}

/* Rays along axes and edges have zero components: the places where divisions go wrong. */
TEST(rays_with_zero_components_are_no_exception)
{
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        int hits = 0;
        for (int axis = 0; axis < 3; axis++)
            for (int u = -8; u <= 8; u++)
                for (int v = -8; v <= 8; v++) {
                    real a = 0.1234 * u, b = 0.1234 * v;
                    vec3 from = axis == 0 ? (vec3){-4, a, b} : axis == 1 ? (vec3){a, -4, b} : (vec3){a, b, -4};
                    Ray ray = {from, {axis == 0, axis == 1, axis == 2}, 8};
                    check_shot(&s, &ray, &hits);
                }
        CHECK(hits > 50);
        shape_free(&s);
    }
}

/* From 1e6 m the hit may be off by the rounding of the start, not by its square. */
TEST(far_starts_lose_no_more_than_rounding)
{
    Shape s = solid(0);
    Ray ray = {{-1e6, 0.42, 0}, {1, 0, 0}, 2e6};
    RayHit hit = {0};
    CHECK(s.type->ray(&s, &ray, &hit));
    CHECK_NEAR(hit.distance, 1e6 - 0.56, 3e-10);
    CHECK_NEAR(vec3_distance(hit.normal, (vec3){-0.8, 0.6, 0}), 0, 1e-12);
    shape_free(&s);
}

/* ---- the plane ---- */

TEST(a_plane_is_solid_below)
{
    const dig_plane_def ground = {{0, 5, 0}, 2};
    Shape s;
    RayHit hit;
    char why[128];
    CHECK_INT(shape_make("plane", &ground, &s, why, sizeof why), DIG_OK);
    CHECK(s.type->contains(&s, (vec3){1e5, 1.999, 0}));
    CHECK(!s.type->contains(&s, (vec3){1e5, 2.001, 0}));
    CHECK(isinf(s.inner) && isinf(s.outer));

    Ray down = {{7, 5, 1}, {0.6, -0.8, 0}, 10}, up = {{7, 5, 1}, {0, 1, 0}, 10}, inside = {{0, 0, 0}, {0, 1, 0}, 10};
    CHECK(s.type->ray(&s, &down, &hit));
    CHECK_NEAR(hit.distance, 3.75, 1e-14);
    CHECK_NEAR(hit.normal.y, 1, 1e-15);
    CHECK(!s.type->ray(&s, &up, &hit));
    CHECK(!s.type->ray(&s, &inside, &hit));

    pose at = pose_identity();
    at.p.y = 0.5;
    box3 b = s.type->bounds(&s, at);
    CHECK_NEAR(b.high.y, 2.5, 1e-15);
    CHECK(b.low.y <= -1e30 && b.high.x >= 1e30);
    at.q = quat_axis_angle((vec3){1, 0, 0}, 0.1);
    CHECK(s.type->bounds(&s, at).high.y >= 1e30);
    shape_free(&s);

    const dig_plane_def wall = {{-1, 0, 0}, -3};            /* solid at x >= 3 */
    CHECK_INT(shape_make("plane", &wall, &s, why, sizeof why), DIG_OK);
    CHECK_NEAR(s.type->bounds(&s, pose_identity()).low.x, 3, 1e-15);
    shape_free(&s);
}

/* ---- faces ---- */

/* The corners lie on the surface, in one plane across their own normal, counter-clockwise, and the normal is near d. */
static void check_face(const Shape *s, vec3 d, const vec3 *c, int count)
{
    vec3 n = vec3_zero();
    for (int k = 1; k + 1 < count; k++)
        n = vec3_add(n, vec3_cross(vec3_sub(c[k], c[0]), vec3_sub(c[k + 1], c[0])));
    n = vec3_unit(n);
    CHECK(vec3_dot(n, d) > 0.5);
    for (int k = 0; k < count; k++) {
        CHECK_NEAR(vec3_dot(n, c[k]), vec3_dot(n, s->type->support(s, n)), 1e-14);
        vec3 turn = vec3_cross(vec3_sub(c[(k + 1) % count], c[k]), vec3_sub(c[(k + 2) % count], c[(k + 1) % count]));
        CHECK(vec3_dot(turn, n) > 0);
    }
}

TEST(faces_look_the_way_asked)
{
    uint64_t state = 5;
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        for (int k = 0; k < 1000; k++) {
            vec3 d = draw_unit(&state), c[16];
            uint32_t feature = 99;
            int count = s.type->face(&s, d, c, &feature);
            CHECK(count >= 1 && count <= 16 && feature < 6);
            if (count >= 3)
                check_face(&s, d, c, count);
            if (count == 1)
                CHECK_NEAR(vec3_distance(c[0], s.type->support(&s, d)), 0, 1e-15);
            if (count == 2 && i != 2) {         /* a side line leaves the surface at neither end and turns under the direction */
                real across = sqrt(d.x * d.x + d.z * d.z);
                CHECK_NEAR((c[0].x * d.x + c[0].z * d.z) / across, i == 3 ? 0.5 : 0.6, 1e-14);
            }
        }
        shape_free(&s);
    }
}

TEST(faces_of_the_upright_poses)
{
    vec3 c[16];
    uint32_t f = 99;
    Shape s = solid(1);
    CHECK_INT(s.type->face(&s, (vec3){0, -1, 0}, c, &f), 4);
    CHECK_INT(f, 2);
    for (int k = 0; k < 4; k++)
        CHECK_NEAR(c[k].y, -1, 0);
    shape_free(&s);

    s = solid(2);
    CHECK_INT(s.type->face(&s, (vec3){1, 0.009, 0}, c, &f), 2);
    CHECK_INT(s.type->face(&s, (vec3){1, 0.011, 0}, c, &f), 1);
    CHECK_NEAR(c[0].y, 0.6, 0);
    shape_free(&s);

    s = solid(3);
    CHECK_INT(s.type->face(&s, (vec3){0, 1, 0}, c, &f), 8);
    CHECK_INT(f, 1);
    vec3 c2[16];
    CHECK_INT(s.type->face(&s, (vec3){0.3, 1, 0.2}, c2, &f), 8);
    for (int k = 0; k < 8; k++)                 /* fixed in the body */
        CHECK(vec3_equal(c[k], c2[k]));
    CHECK_INT(s.type->face(&s, (vec3){0, 0, 1}, c, &f), 2);
    CHECK_INT(f, 2);
    CHECK_NEAR(c[0].z, 0.5, 1e-15);
    CHECK_NEAR(c[0].y, -0.7, 1e-15);
    CHECK_NEAR(c[1].y, 0.7, 1e-15);
    shape_free(&s);

    s = solid(4);
    CHECK_INT(s.type->face(&s, (vec3){0, -1, 0}, c, &f), 8);
    CHECK_INT(s.type->face(&s, (vec3){0, 1, 0}, c, &f), 1);
    CHECK_NEAR(c[0].y, 1.5, 0);
    CHECK_INT(s.type->face(&s, (vec3){2, 0.6, 0}, c, &f), 2);       /* across the side */
    CHECK_NEAR(c[0].x, 0.6, 1e-15);
    CHECK_NEAR(c[1].y, 1.5, 0);
    shape_free(&s);
}

/* ---- pictures ---- */

/* Volume inside the picture, in double again. */
static MassProps picture_mass(const ShapeMesh *m)
{
    MassProps out;
    vec3 *v = malloc((size_t)m->vertex_count * sizeof *v);
    assert_non_null(v);
    for (int i = 0; i < m->vertex_count; i++)
        v[i] = (vec3){m->vertices[3 * i], m->vertices[3 * i + 1], m->vertices[3 * i + 2]};
    mass_of_triangles(v, m->indices, m->index_count / 3, &out);
    free(v);
    return out;
}

/* Inscribed, so never heavier than the solid, and lighter by the facets only; outward, or the volume would be negative. */
TEST(pictures_are_closed_outward_and_nearly_as_big)
{
    static const real loss[SOLIDS] = {0.035, 1e-6, 0.04, 0.015, 0.015};
    for (int i = 0; i < SOLIDS; i++) {
        Shape s = solid(i);
        ShapeMesh m;
        MassProps exact, drawn;
        CHECK_INT(s.type->mesh(&s, &m), DIG_OK);
        s.type->mass(&s, &exact);
        drawn = picture_mass(&m);
        CHECK(drawn.volume < exact.volume * (1 + 1e-6));
        CHECK_NEAR(drawn.volume / exact.volume, 1, loss[i]);
        CHECK_NEAR(vec3_distance(drawn.centre, exact.centre), 0, 1e-6);

        CHECK(m.normals != NULL);
        for (int k = 0; k < m.index_count; k += 3) {
            vec3 p[3], mean = {0, 0, 0};
            for (int j = 0; j < 3; j++) {
                uint32_t v = m.indices[k + j];
                CHECK(v < (uint32_t)m.vertex_count);
                p[j] = (vec3){m.vertices[3 * v], m.vertices[3 * v + 1], m.vertices[3 * v + 2]};
                mean = vec3_add(mean, (vec3){m.normals[3 * v], m.normals[3 * v + 1], m.normals[3 * v + 2]});
            }
            vec3 n = vec3_unit(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
            CHECK(vec3_dot(n, vec3_unit(mean)) > 0.95);
        }
        if (i == 0)
            CHECK_INT(m.index_count / 3, 320);
        free(m.vertices);
        free(m.normals);
        free(m.indices);
        shape_free(&s);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(solids_of_revolution_weigh_what_their_discs_weigh), unit_test(textbook_masses), unit_test(surfaces),
              unit_test(support_reaches_as_far_as_the_solid), unit_test(bounds_touch_the_solid_on_all_sides),
              unit_test(the_inner_ball_fits_and_the_outer_ball_covers), unit_test(only_round_things_roll),
              unit_test(rays_hit_where_geometry_says), unit_test(rays_stop_at_the_surface_and_nowhere_else),
              unit_test(rays_with_zero_components_are_no_exception), unit_test(far_starts_lose_no_more_than_rounding),
              unit_test(a_plane_is_solid_below), unit_test(faces_look_the_way_asked), unit_test(faces_of_the_upright_poses),
              unit_test(pictures_are_closed_outward_and_nearly_as_big));
}
