/* test_contact_points - where contact points lie: on the shapes, facing each other along the normal, where the edges cross. */
#include "collide_fixture.h"

#include "geom/pair.h"

enum { KINDS = 6, BALL = 0, PILL = 2, TRIES = 350 };

static const real gaps[] = {5e-3, 1e-5, 1e-9, 0, -1e-9, -1e-5, -1e-3};
enum { GAPS = sizeof gaps / sizeof *gaps };

#define EXACT 1e-7          /* of the size of the pair */
#define REACH 1e-2          /* m */

static Shape random_shape(Random *r, int kind)
{
    real x = random_between(r, 0.2, 1), y = random_between(r, 0.2, 2);
    vec3 points[20];
    switch (kind) {
    case BALL: return fixture_sphere(x);
    case 1: return fixture_box(2 * x, y, random_between(r, 0.2, 2));
    case PILL: return fixture_capsule(0.5 * x, y);
    case 3: return fixture_cylinder(x, y);
    case 4: return fixture_cone(x, y);
    default:
        for (int i = 0; i < 20; i++)
            points[i] = random_vec3(r, 0.8);
        return fixture_hull(points, 20);
    }
}

/* Distance of a point from the surface, by a small ball about it: the way of closed forms and of GJK on a point. */
static real off_surface(const Shape *s, pose at, vec3 point)
{
    real radius = 2e-4;
    Shape ball = fixture_sphere(radius);
    real gap = shape_distance(s, at, &ball, (pose){point, quat_identity()}, INFINITY, NULL, NULL, NULL);
    shape_free(&ball);
    return fabs(gap + radius);
}

static real sideways(vec3 a, vec3 b, vec3 n, real gap) { return vec3_distance(b, vec3_mad(a, gap, n)); }

typedef struct Meeting { Shape a, b; pose pa, pb; vec3 normal, on_a, on_b; real gap, size; } Meeting;

/* b comes from somewhere until it is near, then along the normal until it is `gap` away. */
static Meeting random_meeting(Random *r, int ka, int kb, real gap)
{
    Meeting m = {.a = random_shape(r, ka), .b = random_shape(r, kb)};
    m.pa = (pose){random_vec3(r, 0.3), random_turn(r)};
    m.pb = (pose){vec3_scale(6, random_direction(r)), random_turn(r)};
    vec3 way = vec3_unit(vec3_sub(m.pb.p, m.pa.p)), n;
    for (int pass = 0; pass < 60; pass++) {
        real apart = shape_distance(&m.a, m.pa, &m.b, m.pb, INFINITY, &n, NULL, NULL);
        m.pb.p = apart > 0.02 ? vec3_mad(m.pb.p, 0.01 - apart, way) : vec3_mad(m.pb.p, gap - apart, n);
        if (apart <= 0.02)
            break;
    }
    m.gap = shape_distance(&m.a, m.pa, &m.b, m.pb, INFINITY, &m.normal, &m.on_a, &m.on_b);
    m.size = m.a.outer + m.b.outer;
    return m;
}

static void meeting_free(Meeting *m)
{
    shape_free(&m->a);
    shape_free(&m->b);
}

static void check_below(const Meeting *m, const char *what, real got, real limit)
{
    if (!(got <= limit))
        fail_msg("%s on %s, gap %g: %s %g m, at most %g", m->a.type->name, m->b.type->name, m->gap, what, got, limit);
}

TEST(nearest_points_lie_on_the_surfaces_and_face_each_other)
{
    Random r = {5};
    for (int ka = 0; ka < KINDS; ka++)
        for (int kb = 0; kb < KINDS; kb++)
            for (int i = 0; i < TRIES; i++) {
                Meeting m = random_meeting(&r, ka, kb, gaps[i % GAPS]);
                check_below(&m, "nearest point off a by", off_surface(&m.a, m.pa, m.on_a), EXACT * m.size);
                check_below(&m, "nearest point off b by", off_surface(&m.b, m.pb, m.on_b), EXACT * m.size);
                check_below(&m, "nearest points miss each other by", sideways(m.on_a, m.on_b, m.normal, m.gap), EXACT * m.size);
                meeting_free(&m);
            }
}

/* Ends of two lines that run side by side within 0.1 rad: both lie on their lines, and miss each other by that angle (manifold.h). */
static bool side_by_side(const ManifoldPoint *p) { return p->feature >> 29 == 2 && (p->feature >> 16 & 63) == 63; }

/* A point higher than the deepest one may be measured inside rounding: by no more than it is higher. */
static void check_point(const Meeting *m, const Manifold *f, const ManifoldPoint *p, real deepest)
{
    real higher = p->gap - deepest;
    CHECK_NEAR(vec3_dot(vec3_sub(p->b, p->a), f->normal), p->gap, 1e-13);
    check_below(m, "contact point off a by", off_surface(&m->a, m->pa, p->a), EXACT * m->size + (m->a.round > 0 ? higher : 0));
    check_below(m, "contact point off b by", off_surface(&m->b, m->pb, p->b), EXACT * m->size + (m->b.round > 0 ? higher : 0));
    check_below(m, "contact points miss each other by", sideways(p->a, p->b, f->normal, p->gap),
                (side_by_side(p) ? 0.15 : EXACT) * m->size);
}

TEST(contact_points_lie_on_the_surfaces_and_face_each_other)
{
    Random r = {6};
    int lines = 0, points = 0;
    for (int ka = 0; ka < KINDS; ka++)
        for (int kb = 0; kb < KINDS; kb++)
            for (int i = 0; i < TRIES; i++) {
                Meeting m = random_meeting(&r, ka, kb, gaps[i % GAPS]);
                Manifold f;
                uint32_t piece;
                CHECK_INT(manifold_collide(&m.a, m.pa, &m.b, m.pb, REACH, NULL, &f, &piece, 1), 1);
                real deepest = deepest_gap(&f);
                /* of boxes, edges must separate by 1e-6 of the smaller more than faces */
                CHECK_NEAR(deepest, m.gap, ka == 1 && kb == 1 ? 2e-6 : 1e-8);
                for (int k = 0; k < f.count; k++) {
                    check_point(&m, &f, &f.points[k], deepest);
                    lines += side_by_side(&f.points[k]);
                    points++;
                }
                meeting_free(&m);
            }
    CHECK(lines * 50 < points);
}

/* A capsule across the edge x = y = 1/2 of a cube. The normal leans by `lean` from the upper face, the axis by `turn` from the edge. */
TEST(a_capsule_across_an_edge_touches_where_its_line_crosses)
{
    real radius = 0.2, half = 0.35;
    Shape cube[2] = {fixture_box(1, 1, 1), fixture_box_hull(1, 1, 1)}, pill = fixture_capsule(radius, 2 * half);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 200; i++) {
            Random r = {(uint64_t)i + 1};
            real lean = random_between(&r, 0.02, 1.5), turn = random_between(&r, 0.2, DIG_PI - 0.2), gap = gaps[i % GAPS];
            vec3 n = {sin(lean), cos(lean), 0}, t = {cos(lean), -sin(lean), 0}, z = {0, 0, 1};
            vec3 along = vec3_add(vec3_scale(cos(turn), z), vec3_scale(sin(turn), t)), across = vec3_cross(along, n);
            vec3 at = {0.5, 0.5, random_between(&r, -0.4, 0.4)};
            /* columns: the capsule's axis is its y */
            mat3 axes = mat3_transpose((mat3){across, along, n});
            vec3 centre = vec3_mad(vec3_mad(at, radius + gap, n), random_between(&r, -0.8, 0.8) * half, along);
            pose pb = {centre, quat_from_matrix(axes)};
            Manifold m;
            uint32_t piece;
            CHECK_INT(manifold_collide(&cube[k], pose_identity(), &pill, pb, REACH, NULL, &m, &piece, 1), 1);
            CHECK_NEAR(vec3_dot(m.normal, n), 1, 1e-12);
            real nearest = INFINITY;
            for (int j = 0; j < m.count; j++) {
                if (m.points[j].gap > gap + 1e-9)
                    continue;
                nearest = real_min(nearest, vec3_distance(m.points[j].a, at));
                CHECK_NEAR(vec3_distance(m.points[j].a, at), 0, 1e-8);
                CHECK_NEAR(vec3_distance(m.points[j].b, vec3_mad(at, gap, n)), 0, 1e-8);
            }
            CHECK_NEAR(nearest, 0, 1e-8);
        }
    shape_free(&cube[0]);
    shape_free(&cube[1]);
    shape_free(&pill);
}

/* Two bars on edge, one across the other: they meet where the edges cross, wherever along them that is. */
TEST(edges_that_cross_touch_where_they_cross)
{
    real up = 0.5 * sqrt(0.5);                  /* half the diagonal of the cross-section, a square of side 1/2 */
    Shape bar[2] = {fixture_box(2, 0.5, 0.5), fixture_box_hull(2, 0.5, 0.5)};
    quat on_edge = quat_axis_angle((vec3){1, 0, 0}, DIG_PI / 4);
    Random r = {7};
    for (int i = 0; i < 400; i++) {
        real angle = random_between(&r, 0.2, DIG_PI - 0.2), gap = gaps[i % GAPS], sa = random_between(&r, -0.9, 0.9);
        real sb = random_between(&r, -0.9, 0.9);
        quat turn = quat_axis_angle((vec3){0, 1, 0}, angle);
        vec3 at = {sa, up, 0}, along = quat_rotate(turn, (vec3){1, 0, 0});
        pose pa = {vec3_zero(), on_edge}, pb = {vec3_mad((vec3){sa, 2 * up + gap, 0}, -sb, along), quat_mul(turn, on_edge)};
        Manifold m;
        uint32_t piece;
        CHECK_INT(manifold_collide(&bar[i % 2], pa, &bar[i / 2 % 2], pb, REACH, NULL, &m, &piece, 1), 1);
        CHECK_INT(m.count, 1);
        CHECK_NEAR(m.points[0].gap, gap, 1e-14);
        CHECK_NEAR(vec3_distance(m.points[0].a, at), 0, 1e-8);
        CHECK_NEAR(vec3_distance(m.points[0].b, vec3_mad(at, gap, (vec3){0, 1, 0})), 0, 1e-8);
    }
    shape_free(&bar[0]);
    shape_free(&bar[1]);
}

/* Corner of a box straight over the corner, or a point of the edge, of another: distance t along `way`, which both corners look along.
 * Overlapping, any normal between their faces' will do, so that the depth is at most -t; it never has the wrong sign. Manifolds know
 * lengths to 1e-9 of the smaller shape only. */
TEST(a_corner_on_a_corner_or_an_edge_keeps_its_distance_and_sign)
{
    static const real at_t[] = {1e-2, 1e-5, 1e-7, 0, -1e-12, -1e-10, -1e-8, -1e-5, -1e-3};
    Shape a[2] = {fixture_box(1, 1, 1), fixture_box_hull(1, 1, 1)}, b[2] = {fixture_box(0.6, 0.8, 1), fixture_box_hull(0.6, 0.8, 1)};
    Random r = {9};
    for (int i = 0; i < 3600; i++) {
        bool edge = i % 2;
        int k = i / 2 % 2;
        real t = at_t[i / 4 % 9];
        vec3 way, back, at = {0.5, 0.5, edge ? random_between(&r, -0.3, 0.3) : 0.5}, n;
        pose pb;
        do {
            way = vec3_abs(random_direction(&r));
            way.z = edge ? 0 : way.z;
            way = vec3_unit(way);
            pb.q = random_turn(&r);
            back = quat_rotate(quat_conjugate(pb.q), vec3_neg(way));
        } while (way.x < 0.1 || way.y < 0.1 || (!edge && way.z < 0.1) || fabs(back.x) < 0.1 || fabs(back.y) < 0.1 || fabs(back.z) < 0.1);
        vec3 corner = {copysign(0.3, back.x), copysign(0.4, back.y), copysign(0.5, back.z)};
        pb.p = vec3_sub(vec3_mad(at, t, way), quat_rotate(pb.q, corner));
        Manifold m;
        uint32_t piece;
        real apart = shape_distance(&a[k], pose_identity(), &b[k], pb, INFINITY, &n, NULL, NULL);
        CHECK_INT(manifold_collide(&a[k], pose_identity(), &b[k], pb, 2e-2, NULL, &m, &piece, 1), 1);
        real deepest = deepest_gap(&m);
        CHECK(vec3_dot(n, way) > 0.05 && vec3_dot(m.normal, way) > 0.05);
        if (t >= 0) {
            CHECK_NEAR(apart, t, 1e-14);
            CHECK_NEAR(deepest, t, 3e-9);
        } else if (!(apart < 0 && apart > 1.01 * t - 1e-14 && deepest < (t < -1e-9 ? 0 : 1e-9) && deepest > 1.01 * t - 1e-9)) {
            fail_msg("corner %g m inside: distance %g, deepest point %g", -t, apart, deepest);
        }
    }
    for (int k = 0; k < 2; k++) {
        shape_free(&a[k]);
        shape_free(&b[k]);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(nearest_points_lie_on_the_surfaces_and_face_each_other),
              unit_test(contact_points_lie_on_the_surfaces_and_face_each_other),
              unit_test(a_capsule_across_an_edge_touches_where_its_line_crosses), unit_test(edges_that_cross_touch_where_they_cross),
              unit_test(a_corner_on_a_corner_or_an_edge_keeps_its_distance_and_sign));
}
