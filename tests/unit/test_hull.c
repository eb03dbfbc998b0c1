/* tests/unit/test_hull.c - convex hulls: known solids, every corner and edge accounted for, hard clouds, refusals. */
#include <stdlib.h>

#include "check.h"
#include "draw_fixture.h"
#include "geom/mass.h"

static Shape hull_of(const vec3 *points, int count)
{
    Shape s;
    char why[256] = "";
    if (shape_make("hull", &(dig_hull_def){{points, count}}, &s, why, sizeof why) != DIG_OK)
        fail_msg("hull of %d: %s", count, why);
    return s;
}

static void check_refused(const vec3 *points, int count, dig_status status, const char *sentence)
{
    Shape s;
    char why[256] = "";
    CHECK_INT(shape_make("hull", &(dig_hull_def){{points, count}}, &s, why, sizeof why), status);
    CHECK_TEXT(why, sentence);
    CHECK(s.data == NULL && s.refs == NULL);
}

static void box_corners(vec3 low, vec3 high, vec3 corners[8])
{
    for (int i = 0; i < 8; i++)
        corners[i] = (vec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z};
}

/* Merged faces are flat to about 1e-6 of the size; clouds here are up to 3 units wide. */
#define MERGED 3e-6

/* Every invariant of the data: Euler, polygons counter-clockwise and flat to `flat`, all corners inside all faces, each edge
 * between the two faces it names, volume and centre inside. */
static void check_hull(const Shape *s, real flat)
{
    const HullData *h = hull_data(s);
    CHECK_INT(h->vertex_count - h->edge_count + h->face_count, 2);
    CHECK_INT(h->corner_count, 2 * h->edge_count);
    for (int f = 0; f < h->face_count; f++) {
        const HullFace *face = &hull_faces(h)[f];
        const uint8_t *c = hull_corners(h) + face->first;
        CHECK_NEAR(vec3_length(face->normal), 1, 1e-14);
        CHECK(face->count >= 3 && face->first + face->count <= h->corner_count);
        for (int k = 0; k < face->count; k++) {
            vec3 a = hull_vertices(h)[c[k]], b = hull_vertices(h)[c[(k + 1) % face->count]], e = hull_vertices(h)[c[(k + 2) % face->count]];
            CHECK_NEAR(vec3_dot(face->normal, a), face->offset, flat);
            CHECK(vec3_dot(vec3_cross(vec3_sub(b, a), vec3_sub(e, b)), face->normal) > -flat * (vec3_distance(a, b) + vec3_distance(b, e)));
        }
        for (int i = 0; i < h->vertex_count; i++)
            CHECK(vec3_dot(face->normal, hull_vertices(h)[i]) <= face->offset);
    }
    for (int i = 0; i < h->edge_count; i++) {
        const HullEdge *edge = &hull_edges(h)[i];
        CHECK(edge->tail < edge->head && edge->left != edge->right);
        const int sides[2] = {edge->left, edge->right}, from[2] = {edge->tail, edge->head}, to[2] = {edge->head, edge->tail};
        for (int k = 0; k < 2; k++) {
            const HullFace *face = &hull_faces(h)[sides[k]];
            const uint8_t *c = hull_corners(h) + face->first;
            int found = 0;
            for (int j = 0; j < face->count; j++)
                found += c[j] == from[k] && c[(j + 1) % face->count] == to[k];
            CHECK_INT(found, 1);
        }
    }
    CHECK(h->mass.volume > 0 && s->type->contains(s, h->mass.centre));
    CHECK(s->inner > 0 && s->outer >= s->inner);
}

TEST(a_hull_of_corners_is_a_box)
{
    vec3 corners[8];
    MassProps hull, box;
    box_corners((vec3){-0.5, -1, -1.5}, (vec3){0.5, 1, 1.5}, corners);
    Shape s = hull_of(corners, 8), b;
    char why[64];
    CHECK_INT(shape_make("box", &(dig_box_def){{1, 2, 3}}, &b, why, sizeof why), DIG_OK);
    check_hull(&s, 1e-15);
    CHECK_INT(hull_data(&s)->vertex_count, 8);
    CHECK_INT(hull_data(&s)->edge_count, 12);
    CHECK_INT(hull_data(&s)->face_count, 6);
    s.type->mass(&s, &hull);
    b.type->mass(&b, &box);
    CHECK_NEAR(hull.volume, box.volume, 1e-14);
    CHECK_NEAR(vec3_length(hull.centre), 0, 1e-15);
    CHECK_NEAR(hull.inertia.r0.x, box.inertia.r0.x, 1e-14);
    CHECK_NEAR(hull.inertia.r1.y, box.inertia.r1.y, 1e-14);
    CHECK_NEAR(hull.inertia.r2.z, box.inertia.r2.z, 1e-14);
    CHECK_NEAR(hull.inertia.r0.y, 0, 1e-15);
    CHECK_NEAR(s.inner, b.inner, 1e-15);
    CHECK_NEAR(s.outer, b.outer, 1e-15);

    uint64_t state = 1;
    for (int k = 0; k < 2000; k++) {            /* and behaves like one */
        vec3 d = draw_unit(&state), from = vec3_scale(4, draw_vec3(&state));
        Ray ray = {from, d, 20};
        RayHit x, y;
        CHECK_NEAR(vec3_distance(s.type->support(&s, d), b.type->support(&b, d)), 0, 1e-15);
        CHECK(s.type->contains(&s, from) == b.type->contains(&b, from));
        bool hit = b.type->ray(&b, &ray, &x);
        CHECK(s.type->ray(&s, &ray, &y) == hit);
        if (hit) {
            CHECK_NEAR(y.distance, x.distance, 1e-13);
            CHECK_NEAR(vec3_distance(y.normal, x.normal), 0, 1e-14);
        }
        vec3 c[16], e[16];
        uint32_t f, g;
        CHECK_INT(s.type->face(&s, d, c, &f), b.type->face(&b, d, e, &g));
        CHECK_NEAR(vec3_distance(vec3_lerp(c[0], c[2], 0.5), vec3_lerp(e[0], e[2], 0.5)), 0, 1e-14);
    }
    shape_free(&s);
    shape_free(&b);
}

/* Copies, points inside, on edges and on faces of the box leave 8 corners and 6 faces. */
TEST(points_that_are_no_corners_are_dropped)
{
    vec3 points[64];
    int count = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (int k = 0; k < 4; k++)
                points[count++] = (vec3){i / 3.0, j / 3.0, k / 3.0};
    Shape s = hull_of(points, count);
    check_hull(&s, 1e-14);
    CHECK_INT(hull_data(&s)->vertex_count, 8);
    CHECK_INT(hull_data(&s)->face_count, 6);
    CHECK_NEAR(hull_data(&s)->mass.volume, 1, 1e-15);
    shape_free(&s);

    box_corners((vec3){0, 0, 0}, (vec3){1, 1, 1}, points);
    for (int i = 8; i < 64; i++)
        points[i] = points[i % 8];
    s = hull_of(points, 64);
    check_hull(&s, 1e-14);
    CHECK_INT(hull_data(&s)->vertex_count, 8);
    shape_free(&s);
}

/* The same numbers, however the points are shuffled: faces, edges and mass do not depend on qhull's lists. */
TEST(the_same_points_give_the_same_bytes)
{
    uint64_t state = 7;
    vec3 points[60];
    for (int i = 0; i < 60; i++)
        points[i] = draw_vec3(&state);
    Shape a = hull_of(points, 60);
    void *noise = malloc(12345);                /* other addresses for the second one */
    Shape b = hull_of(points, 60);
    CHECK_INT(shape_bytes(&a), shape_bytes(&b));
    CHECK_INT(memcmp(a.data, b.data, shape_bytes(&a)), 0);
    shape_free(&b);
    free(noise);

    for (int i = 0; i < 30; i++) {              /* backward: the same solid */
        vec3 swap = points[i];
        points[i] = points[59 - i];
        points[59 - i] = swap;
    }
    b = hull_of(points, 60);
    CHECK_INT(hull_data(&a)->face_count, hull_data(&b)->face_count);
    CHECK_NEAR(hull_data(&a)->mass.volume, hull_data(&b)->mass.volume, 1e-14);
    shape_free(&a);
    shape_free(&b);
}

/* Files hold seven digits. A turned box rounded to them still has six faces of four corners. */
TEST(rounded_coordinates_do_not_splinter_faces)
{
    uint64_t state = 3;
    for (int k = 0; k < 200; k++) {
        quat q = quat_exp(vec3_scale(3, draw_unit(&state)));
        vec3 c[8];
        box_corners((vec3){-0.5, -1, -1.5}, (vec3){0.5, 1, 1.5}, c);
        real digits = k % 2 ? 1e7 : 1e15;
        for (int i = 0; i < 8; i++) {
            vec3 p = vec3_scale(digits, quat_rotate(q, c[i]));
            c[i] = vec3_scale(1 / digits, (vec3){round(p.x), round(p.y), round(p.z)});
        }
        Shape s = hull_of(c, 8);
        check_hull(&s, 1e-6);
        CHECK_INT(hull_data(&s)->face_count, 6);
        CHECK_NEAR(hull_data(&s)->mass.volume, 6, 1e-5);
        shape_free(&s);
    }
}

TEST(random_clouds_keep_every_invariant)
{
    uint64_t state = 11;
    for (int round_ = 0; round_ < 200; round_++) {
        int count = 4 + round_;
        vec3 points[204];
        real low = round_ % 3 == 0 ? 1e-3 : 1, far = round_ % 5 == 0 ? 1e4 : 0;
        for (int i = 0; i < count; i++) {
            vec3 p = round_ % 2 ? draw_unit(&state) : draw_vec3(&state);
            points[i] = (vec3){p.x + far, low * p.y, 2 * p.z};
        }
        Shape s = hull_of(points, count);
        check_hull(&s, MERGED);
        for (int k = 0; k < 50; k++) {
            vec3 d = draw_unit(&state);
            real most = -INFINITY;
            for (int i = 0; i < count; i++)
                most = fmax(most, vec3_dot(points[i], d));
            CHECK_NEAR(vec3_dot(s.type->support(&s, d), d), most, MERGED);
        }
        shape_free(&s);
    }
}

/* On a sphere every point is a corner, and nothing is merged: support must agree with all points exactly. */
TEST(support_is_the_farthest_corner)
{
    uint64_t state = 5;
    for (int count = 4; count <= 255; count = 2 * count + 1) {
        vec3 points[255];
        for (int i = 0; i < count; i++)
            points[i] = draw_unit(&state);
        Shape s = hull_of(points, count);
        CHECK_INT(hull_data(&s)->vertex_count, count);
        for (int k = 0; k < 500; k++) {
            vec3 d = draw_unit(&state);
            real most = -INFINITY;
            for (int i = 0; i < count; i++)
                most = fmax(most, vec3_dot(points[i], d));
            CHECK_NEAR(vec3_dot(s.type->support(&s, d), d), most, 0);
        }
        shape_free(&s);
    }
}

/* Corner tetrahedron 0 <= x, y, z and x + y + z <= 2, moved to (5, 6, 7). */
TEST(a_tetrahedron_has_its_closed_form)
{
    const vec3 points[4] = {{5, 6, 7}, {7, 6, 7}, {5, 8, 7}, {5, 6, 9}};
    Shape s = hull_of(points, 4);
    MassProps m;
    check_hull(&s, 1e-14);
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 8.0 / 6, 1e-14);
    CHECK_NEAR(vec3_distance(m.centre, (vec3){5.5, 6.5, 7.5}), 0, 1e-14);
    CHECK_NEAR(m.inertia.r0.x, 32.0 / 80, 1e-14);
    CHECK_NEAR(m.inertia.r0.y, 32.0 / 480, 1e-14);
    CHECK_NEAR(s.inner, 0.5 / sqrt(3), 1e-14);          /* (2 - 3/2) / sqrt 3 to the slope, 0.5 to the others */
    shape_free(&s);
}

/* A 40-gon prism: two faces of 40 corners, of which face() shows 16, still counter-clockwise and spread all round. */
TEST(large_faces_are_thinned_evenly)
{
    vec3 points[80], c[16];
    for (int i = 0; i < 40; i++) {
        real a = 2 * DIG_PI * i / 40;
        points[2 * i]     = (vec3){cos(a), 0, sin(a)};
        points[2 * i + 1] = (vec3){cos(a), 1, sin(a)};
    }
    Shape s = hull_of(points, 80);
    check_hull(&s, 1e-14);
    CHECK_INT(hull_data(&s)->face_count, 42);
    uint32_t feature;
    CHECK_INT(s.type->face(&s, (vec3){0.1, 1, 0}, c, &feature), 16);
    vec3 area = vec3_zero();
    for (int k = 0; k < 16; k++) {
        CHECK_NEAR(c[k].y, 1, 0);
        area = vec3_add(area, vec3_cross(c[k], c[(k + 1) % 16]));
    }
    CHECK_NEAR(0.5 * area.y, DIG_PI, 0.1);      /* 16 even corners: 3.06 */
    shape_free(&s);
}

TEST(a_picture_of_a_hull_encloses_its_volume)
{
    uint64_t state = 13;
    vec3 points[100], v[100];
    for (int i = 0; i < 100; i++)
        points[i] = draw_vec3(&state);
    Shape s = hull_of(points, 100);
    ShapeMesh m;
    MassProps drawn;
    CHECK_INT(s.type->mesh(&s, &m), DIG_OK);
    for (int i = 0; i < m.vertex_count; i++)
        v[i] = (vec3){m.vertices[3 * i], m.vertices[3 * i + 1], m.vertices[3 * i + 2]};
    mass_of_triangles(v, m.indices, m.index_count / 3, &drawn);
    CHECK_NEAR(drawn.volume, hull_data(&s)->mass.volume, 1e-6);
    free(m.vertices);
    free(m.indices);
    shape_free(&s);
}

TEST(bounds_hold_every_corner_and_touch_six)
{
    uint64_t state = 17;
    vec3 points[30];
    for (int i = 0; i < 30; i++)
        points[i] = draw_vec3(&state);
    Shape s = hull_of(points, 30);
    for (int k = 0; k < 100; k++) {
        pose at = {vec3_scale(10, draw_vec3(&state)), quat_exp(vec3_scale(3, draw_unit(&state)))};
        box3 b = s.type->bounds(&s, at), want = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        for (int i = 0; i < 30; i++) {
            want.low  = vec3_min(want.low, pose_point(at, points[i]));
            want.high = vec3_max(want.high, pose_point(at, points[i]));
        }
        CHECK_NEAR(vec3_distance(b.low, want.low), 0, 1e-14);
        CHECK_NEAR(vec3_distance(b.high, want.high), 0, 1e-14);
    }
    shape_free(&s);
}

/* A plate of 10 m x 10 m x 0.1 mm, the thinnest that is allowed, and the same one 10 km away. */
TEST(thin_plates_are_still_boxes)
{
    for (int k = 0; k < 2; k++) {
        vec3 c[8];
        real far = k * 1e4;
        box_corners((vec3){far, 0, 0}, (vec3){far + 10, 1.1e-4, 10}, c);
        Shape s = hull_of(c, 8);
        check_hull(&s, 1e-9);
        CHECK_INT(hull_data(&s)->face_count, 6);
        CHECK_NEAR(hull_data(&s)->mass.volume, 1.1e-2, 1e-11);
        shape_free(&s);
    }
}

TEST(clouds_without_a_solid_are_refused)
{
    const vec3 p[8] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 3, 0}, {0.3, 0.4, 0}, {-1, 5, 0}, {1, 1, 1e-12}};
    check_refused(NULL, 0, DIG_E_ARG, "hull needs 4 points not in one plane (got 0)");
    check_refused(p, 3, DIG_E_ARG, "hull needs 4 points not in one plane (got 3)");
    check_refused(p, 4, DIG_E_ARG, "hull needs 4 points not in one plane (the 4 given lie in one plane)");
    check_refused(p, 8, DIG_E_ARG, "hull needs 4 points not in one plane (the 8 given lie in one plane)");

    const vec3 line[5] = {{1, 2, 3}, {2, 4, 6}, {3, 6, 9}, {-1, -2, -3}, {1, 2, 3}}, same[4] = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
    check_refused(line, 5, DIG_E_ARG, "hull needs 4 points not in one plane (the 5 given lie on one line)");
    check_refused(same, 4, DIG_E_ARG, "hull needs 4 points not in one plane (the 4 given are one point)");

    const vec3 thin[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 5e-5}};
    check_refused(thin, 4, DIG_E_ARG, "hull is 5e-05 m thin, must be at least 0.0001 m");
    const vec3 tilted[4] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
    check_refused(tilted, 4, DIG_E_ARG, "hull needs 4 points not in one plane (the 4 given lie in one plane)");
}

TEST(broken_numbers_are_named)
{
    vec3 p[4] = {{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}, {0, 0, 1}};
    check_refused(p, 4, DIG_E_FINITE, "hull points[3].y = nan m, must be -100000 to 100000 m");
    p[2].y = -INFINITY;
    check_refused(p, 4, DIG_E_FINITE, "hull points[3].y = -inf m, must be -100000 to 100000 m");
    p[2].y = 2e5;
    check_refused(p, 4, DIG_E_ARG, "hull points[3].y = 200000 m, must be -100000 to 100000 m");
}

/* 255 corners on a sphere pass, 256 do not; 2000 points inside them make no difference. */
TEST(at_most_255_corners)
{
    uint64_t state = 19;
    static vec3 p[2256];
    for (int i = 0; i < 256; i++)
        p[i] = draw_unit(&state);
    Shape s = hull_of(p, 255);
    check_hull(&s, 1e-14);
    CHECK_INT(hull_data(&s)->vertex_count, 255);
    shape_free(&s);
    check_refused(p, 256, DIG_E_FULL, "hull has 256 corners, must be at most 255");

    for (int i = 255; i < 2255; i++)
        p[i] = vec3_scale(0.5, draw_unit(&state));
    s = hull_of(p, 2255);
    CHECK_INT(hull_data(&s)->vertex_count, 255);
    shape_free(&s);
}

/* Clouds at the edge of flatness: a hull or a sentence, never a crash or a broken surface. */
TEST(nearly_flat_clouds_end_well)
{
    uint64_t state = 23;
    int made = 0, refused = 0;
    for (int k = 0; k < 600; k++) {
        vec3 p[40];
        real thick = pow(10, -3 - 9.0 * (k % 30) / 30), size = k % 2 ? 1 : 1e3;
        quat q = quat_exp(vec3_scale(3, draw_unit(&state)));
        for (int i = 0; i < 40; i++) {
            vec3 v = draw_vec3(&state);
            p[i] = quat_rotate(q, (vec3){size * v.x, size * thick * v.y, size * v.z});
        }
        Shape s;
        char why[256] = "";
        if (shape_make("hull", &(dig_hull_def){{p, 40}}, &s, why, sizeof why) == DIG_OK) {
            check_hull(&s, MERGED * size);
            shape_free(&s);
            made++;
        } else {
            CHECK(strncmp(why, "hull ", 5) == 0);
            refused++;
        }
    }
    CHECK(made > 50 && refused > 50);
}

int main(void)
{
    RUN_TESTS(unit_test(a_hull_of_corners_is_a_box), unit_test(points_that_are_no_corners_are_dropped),
              unit_test(the_same_points_give_the_same_bytes), unit_test(rounded_coordinates_do_not_splinter_faces),
              unit_test(random_clouds_keep_every_invariant), unit_test(support_is_the_farthest_corner),
              unit_test(a_tetrahedron_has_its_closed_form), unit_test(large_faces_are_thinned_evenly),
              unit_test(a_picture_of_a_hull_encloses_its_volume), unit_test(bounds_hold_every_corner_and_touch_six),
              unit_test(thin_plates_are_still_boxes), unit_test(clouds_without_a_solid_are_refused), unit_test(broken_numbers_are_named),
              unit_test(at_most_255_corners), unit_test(nearly_flat_clouds_end_well));
}
