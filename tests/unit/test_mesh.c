/* tests/unit/test_mesh.c - triangle meshes and height fields: inside, mass, pieces, neighbours and rays against plain search. */
#include <stdlib.h>

#include "check.h"
#include "draw_fixture.h"
#include "geom/mass.h"

static Shape mesh_of(const vec3 *v, int vertices, const int64_t *t, int indices)
{
    Shape s;
    char why[256] = "";
    if (shape_make("mesh", &(dig_mesh_def){{v, vertices}, {t, indices}}, &s, why, sizeof why) != DIG_OK)
        fail_msg("mesh: %s", why);
    return s;
}

static void check_refused(const char *type, const void *def, dig_status status, const char *sentence)
{
    Shape s;
    char why[256] = "";
    CHECK_INT(shape_make(type, def, &s, why, sizeof why), status);
    CHECK_TEXT(why, sentence);
    CHECK(s.data == NULL && s.refs == NULL);
}

/* The box 0 <= x <= 1, 0 <= y <= 2, 0 <= z <= 3. */
static const vec3 box_v[8] = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {1, 2, 0}, {0, 0, 3}, {1, 0, 3}, {0, 2, 3}, {1, 2, 3}};
static const int64_t box_t[36] = {1, 5, 7, 1, 7, 3, 2, 4, 8, 2, 8, 6, 1, 2, 6, 1, 6, 5,
                                   3, 7, 8, 3, 8, 4, 1, 3, 4, 1, 4, 2, 5, 6, 8, 5, 8, 7};

/* A frame: outside 4 x 2 x 4 about the origin in x and z, with a hole of 2 x 2 right through along y. Not convex. */
static int frame(vec3 v[16], int64_t t[96])
{
    static const int quads[16][4] = {
        {0, 8, 9, 1}, {1, 9, 10, 2}, {2, 10, 11, 3}, {3, 11, 8, 0},             /* outer walls */
        {4, 5, 13, 12}, {5, 6, 14, 13}, {6, 7, 15, 14}, {7, 4, 12, 15},         /* inner walls */
        {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7},                 /* below */
        {8, 12, 13, 9}, {9, 13, 14, 10}, {10, 14, 15, 11}, {11, 15, 12, 8}};    /* above */
    static const real x[4] = {1, -1, -1, 1}, z[4] = {1, 1, -1, -1};
    for (int i = 0; i < 16; i++) {
        real half = i / 4 % 2 ? 1 : 2;
        v[i] = (vec3){half * x[i % 4], i < 8 ? -1 : 1, half * z[i % 4]};
    }
    for (int q = 0; q < 16; q++) {
        const int *c = quads[q];
        const int64_t two[6] = {c[0] + 1, c[1] + 1, c[2] + 1, c[0] + 1, c[2] + 1, c[3] + 1};
        memcpy(t + 6 * q, two, sizeof two);
    }
    return 96;
}

/* Hills and valleys as a mesh: n x n cells over [-1, 1]^2. */
static real hill(real x, real z) { return 0.3 * sin(4 * x + 1) * cos(3 * z); }

static Shape hills(int n)
{
    vec3 *v = malloc((size_t)((n + 1) * (n + 1)) * sizeof *v);
    int64_t *t = malloc((size_t)(6 * n * n) * sizeof *t);
    int at = 0;
    assert_non_null(v);
    assert_non_null(t);
    for (int j = 0; j <= n; j++)
        for (int i = 0; i <= n; i++) {
            real x = -1 + 2.0 * i / n, z = -1 + 2.0 * j / n;
            v[j * (n + 1) + i] = (vec3){x, hill(x, z), z};
        }
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            int64_t a = j * (n + 1) + i + 1, b = a + n + 1;
            const int64_t two[6] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(t + at, two, sizeof two);
            at += 6;
        }
    Shape s = mesh_of(v, (n + 1) * (n + 1), t, at);
    free(v);
    free(t);
    return s;
}

static Shape field(int columns, int rows)
{
    real *h = malloc((size_t)(columns * rows) * sizeof *h);
    Shape s;
    char why[256] = "";
    assert_non_null(h);
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++)
            h[j * columns + i] = hill(-1 + 2.0 * i / (columns - 1), -1 + 2.0 * j / (rows - 1));
    if (shape_make("heightfield", &(dig_heightfield_def){.heights = h, .columns = columns, .rows = rows, .size = {2, 0, 2}}, &s, why,
                   sizeof why) != DIG_OK)
        fail_msg("%s", why);
    free(h);                                    /* the shape has its own copy */
    return s;
}

static vec3 normal_of(const vec3 c[3]) { return vec3_unit(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0]))); }

/* ---- inside and mass ---- */

TEST(a_closed_mesh_weighs_what_its_box_weighs)
{
    Shape s = mesh_of(box_v, 8, box_t, 36);
    MassProps m;
    CHECK(shape_mesh_closed(&s));
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 6, 1e-14);
    CHECK_NEAR(vec3_distance(m.centre, (vec3){0.5, 1, 1.5}), 0, 1e-15);
    CHECK_NEAR(m.inertia.r0.x, 6.5, 1e-14);
    CHECK_NEAR(m.inertia.r1.y, 5, 1e-14);
    CHECK_NEAR(m.inertia.r2.z, 2.5, 1e-14);
    CHECK_NEAR(m.inertia.r0.y, 0, 1e-15);
    CHECK_NEAR(s.outer, sqrt(14), 1e-15);
    shape_free(&s);
}

TEST(a_mesh_with_a_hole_weighs_the_difference)
{
    vec3 v[16];
    int64_t t[96];
    Shape s = mesh_of(v, 16, t, frame(v, t));
    MassProps m;
    CHECK(shape_mesh_closed(&s));
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 24, 1e-13);
    CHECK_NEAR(m.inertia.r1.y, 32.0 * (16 + 16) / 12 - 8.0 * (4 + 4) / 12, 1e-12);
    CHECK_NEAR(m.inertia.r0.x, 32.0 * (16 + 4) / 12 - 8.0 * (4 + 4) / 12, 1e-12);

    CHECK(s.type->contains(&s, (vec3){1.5, 0.3, 0.2}));
    CHECK(!s.type->contains(&s, (vec3){0.5, 0.3, 0.2}));        /* in the hole */
    CHECK(!s.type->contains(&s, (vec3){1.5, 1.3, 0.2}));
    shape_free(&s);
}

TEST(a_mesh_inside_out_is_turned_round)
{
    int64_t t[36];
    for (int i = 0; i < 36; i += 3) {
        t[i] = box_t[i + 1];
        t[i + 1] = box_t[i];
        t[i + 2] = box_t[i + 2];
    }
    Shape s = mesh_of(box_v, 8, t, 36);
    MassProps m;
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 6, 1e-14);
    for (uint32_t i = 0; i < 12; i++) {
        vec3 c[3];
        s.type->piece(&s, i, c);
        CHECK(vec3_dot(normal_of(c), vec3_sub(c[0], (vec3){0.5, 1, 1.5})) > 0);
    }
    shape_free(&s);
}

/* One triangle less, one turned round, a single sheet, a sheet with two sides: none of them has an inside. */
TEST(leaks_are_noticed)
{
    int64_t t[36];
    MassProps m;
    memcpy(t, box_t, sizeof t);
    Shape s = mesh_of(box_v, 8, t, 33);
    CHECK(!shape_mesh_closed(&s) && !s.type->contains(&s, (vec3){0.5, 1, 1.5}));
    s.type->mass(&s, &m);
    CHECK_NEAR(m.volume, 0, 0);
    shape_free(&s);

    t[0] = box_t[1];
    t[1] = box_t[0];
    s = mesh_of(box_v, 8, t, 36);
    CHECK(!shape_mesh_closed(&s));
    shape_free(&s);

    const int64_t sheet[6] = {1, 2, 3, 1, 3, 2};
    s = mesh_of(box_v, 8, sheet, 3);
    CHECK(!shape_mesh_closed(&s));
    shape_free(&s);
    s = mesh_of(box_v, 8, sheet, 6);
    CHECK(!shape_mesh_closed(&s));
    shape_free(&s);
}

/* Every triangle with three vertices of its own, as many files have it. */
TEST(equal_vertices_are_joined)
{
    vec3 v[36];
    int64_t t[36];
    for (int i = 0; i < 36; i++) {
        v[i] = box_v[box_t[i] - 1];
        t[i] = i + 1;
    }
    Shape s = mesh_of(v, 36, t, 36);
    CHECK(shape_mesh_closed(&s));
    for (uint32_t i = 0; i < 12; i++)
        for (int k = 0; k < 3; k++)
            CHECK(s.type->neighbour(&s, i, k) != SHAPE_NO_PIECE);
    shape_free(&s);
}

TEST(triangles_without_area_are_dropped)
{
    const vec3 v[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 0, 0}};
    const int64_t t[12] = {1, 2, 2, 1, 2, 4, 1, 2, 3, 1, 5, 3};    /* twice the same, on a line, sound, twice the same place */
    Shape s = mesh_of(v, 5, t, 12);
    uint32_t piece[8];
    vec3 c[3];
    CHECK_INT(s.type->pieces(&s, (box3){{-9, -9, -9}, {9, 9, 9}}, piece, 8), 1);
    s.type->piece(&s, piece[0], c);
    CHECK_NEAR(vec3_distance(normal_of(c), (vec3){0, 0, 1}), 0, 0);
    shape_free(&s);
    check_refused("mesh", &(dig_mesh_def){{v, 5}, {t, 6}}, DIG_E_ARG, "mesh has no triangle with an area (of 2 given)");
}

TEST(broken_lists_are_named)
{
    const int64_t high[6] = {1, 2, 3, 1, 2, 9}, zero[6] = {0, 2, 3, 1, 2, 3}, seven[7] = {1, 2, 3, 1, 2, 4, 5};
    check_refused("mesh", &(dig_mesh_def){{box_v, 8}, {high, 6}}, DIG_E_ARG, "mesh triangle 2 has index 9, must be 1 to 8");
    check_refused("mesh", &(dig_mesh_def){{box_v, 8}, {zero, 6}}, DIG_E_ARG, "mesh triangle 1 has index 0, must be 1 to 8");
    check_refused("mesh", &(dig_mesh_def){{box_v, 8}, {seven, 7}}, DIG_E_ARG, "mesh has 7 indices, must be a multiple of 3");
    check_refused("mesh", &(dig_mesh_def){{box_v, 8}, {NULL, 0}}, DIG_E_ARG, "mesh has 0 triangles, must be 1 to 4194304");
    vec3 v[3] = {{0, 0, 0}, {1, 0, 0}, {0, INFINITY, 0}};
    check_refused("mesh", &(dig_mesh_def){{v, 3}, {high, 3}}, DIG_E_FINITE, "mesh vertices[3].y = inf m, must be -100000 to 100000 m");
    check_refused("mesh", &(dig_mesh_def){{NULL, 0}, {high, 3}}, DIG_E_ARG, "mesh triangle 1 has index 1, must be 1 to 0");
}

/* ---- pieces and neighbours: mesh and height field alike ---- */

static int total_pieces(const Shape *s)
{
    return s->type->pieces(s, (box3){{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}}, NULL, 0);
}

/* Exactly the pieces whose bounds meet the box, each once. */
static void check_pieces(const Shape *s, box3 box)
{
    int total = total_pieces(s), want = 0, got;
    uint32_t *piece = malloc((size_t)total * sizeof *piece);
    char *seen = calloc((size_t)total, 1);
    assert_non_null(piece);
    assert_non_null(seen);
    got = s->type->pieces(s, box, piece, total);
    for (int i = 0; i < got; i++) {
        CHECK(piece[i] < (uint32_t)total && !seen[piece[i]]);
        seen[piece[i]] = 1;
    }
    for (int i = 0; i < total; i++) {
        vec3 c[3];
        s->type->piece(s, (uint32_t)i, c);
        box3 b = {vec3_min(c[0], vec3_min(c[1], c[2])), vec3_max(c[0], vec3_max(c[1], c[2]))};
        bool meets = box3_overlap(b, box);
        want += meets;
        CHECK(meets == (seen[i] != 0));
    }
    CHECK_INT(got, want);
    if (want > 1)
        CHECK_INT(s->type->pieces(s, box, piece, 1), want);     /* no room: still counted */
    free(piece);
    free(seen);
}

TEST(pieces_are_those_whose_bounds_meet_the_box)
{
    uint64_t state = 1;
    Shape all[3] = {hills(17), field(18, 12), field(2, 2)};
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 300; i++) {
            vec3 a = vec3_scale(1.2, draw_vec3(&state)), b = vec3_mad(a, 0.4, draw_vec3(&state));
            check_pieces(&all[k], (box3){vec3_min(a, b), vec3_max(a, b)});
        }
        for (int i = 0; i <= 11; i++) {         /* boxes without thickness that only touch the grid lines */
            real x = -1 + 2.0 * i / 11;
            check_pieces(&all[k], (box3){{x, -9, -9}, {x, 9, 9}});
            check_pieces(&all[k], (box3){{-9, -9, x}, {9, 9, x}});
        }
        check_pieces(&all[k], (box3){{-1e30, -1e30, -1e30}, {1e30, 1e30, 1e30}});
        check_pieces(&all[k], (box3){{5, -1, 5}, {6, 1, 6}});
        shape_free(&all[k]);
    }
}

/* Across every edge lies the triangle that runs along it the other way; the rim has none. */
static int check_neighbours(const Shape *s)
{
    int total = total_pieces(s), rim = 0;
    for (int i = 0; i < total; i++)
        for (int k = 0; k < 3; k++) {
            vec3 a[3], b[3];
            uint32_t other = s->type->neighbour(s, (uint32_t)i, k);
            if (other == SHAPE_NO_PIECE) {
                rim++;
                continue;
            }
            s->type->piece(s, (uint32_t)i, a);
            s->type->piece(s, other, b);
            int found = 0;
            for (int j = 0; j < 3; j++)
                found += vec3_equal(a[k], b[(j + 1) % 3]) && vec3_equal(a[(k + 1) % 3], b[j]) &&
                         s->type->neighbour(s, other, j) == (uint32_t)i;
            CHECK_INT(found, 1);
        }
    return rim;
}

TEST(neighbours_know_each_other)
{
    vec3 v[16];
    int64_t t[96];
    Shape s = hills(9);
    CHECK_INT(check_neighbours(&s), 36);
    shape_free(&s);
    s = field(6, 4);
    CHECK_INT(total_pieces(&s), 30);
    CHECK_INT(check_neighbours(&s), 16);
    shape_free(&s);
    s = mesh_of(v, 16, t, frame(v, t));
    CHECK_INT(check_neighbours(&s), 0);
    shape_free(&s);
}

/* ---- rays ---- */

/* Nearest crossing of all triangles by the textbook formula (Moller & Trumbore 1997), either side. */
static real plain_search(const Shape *s, const Ray *ray, vec3 *normal)
{
    real best = INFINITY;
    int total = total_pieces(s);
    for (int i = 0; i < total; i++) {
        vec3 c[3];
        s->type->piece(s, (uint32_t)i, c);
        vec3 e = vec3_sub(c[1], c[0]), f = vec3_sub(c[2], c[0]), o = vec3_sub(ray->from, c[0]);
        vec3 p = vec3_cross(ray->along, f), q = vec3_cross(o, e);
        real det = vec3_dot(e, p), u = vec3_dot(o, p) / det, v = vec3_dot(ray->along, q) / det, t = vec3_dot(f, q) / det;
        if (det != 0 && u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t <= ray->length && t < best) {
            best = t;
            *normal = normal_of(c);
        }
    }
    return best;
}

TEST(rays_find_the_nearest_triangle)
{
    uint64_t state = 2;
    vec3 v[16];
    int64_t t[96];
    Shape all[3] = {hills(17), mesh_of(v, 16, t, frame(v, t)), field(18, 12)};
    for (int k = 0; k < 3; k++) {
        int hits = 0;
        real size = k == 1 ? 2 : 1;
        for (int i = 0; i < 3000; i++) {
            vec3 from = vec3_scale(2.5 * size, draw_vec3(&state)), to = vec3_scale(size, draw_vec3(&state)), n = {0, 0, 0};
            Ray ray = {from, vec3_unit(vec3_sub(to, from)), 10};
            RayHit hit = {0};
            real want = plain_search(&all[k], &ray, &n);
            bool behind = isfinite(want) && vec3_dot(n, ray.along) > 0;
            if (k == 2 && behind)
                continue;                       /* height fields are met from above only */
            if (all[k].type->contains(&all[k], from))
                want = INFINITY;
            CHECK(all[k].type->ray(&all[k], &ray, &hit) == isfinite(want));
            if (!isfinite(want))
                continue;
            hits++;
            CHECK_NEAR(hit.distance, want, 1e-12);
            CHECK_NEAR(vec3_distance(hit.normal, behind ? vec3_neg(n) : n), 0, 1e-9);
        }
        CHECK(hits > 500);
        shape_free(&all[k]);
    }
}

/* Straight down through every vertex and the middle of every edge: never a gap between triangles. */
TEST(rays_do_not_slip_between_triangles)
{
    Shape all[2] = {hills(16), field(17, 17)};
    for (int k = 0; k < 2; k++) {
        for (int j = 1; j < 32; j++)
            for (int i = 1; i < 32; i++) {
                real x = -1 + i / 16.0, z = -1 + j / 16.0;
                Ray down = {{x, 3, z}, {0, -1, 0}, 10};
                vec3 d = vec3_unit((vec3){0.3, -1, 0.2});
                Ray slant = {vec3_mad((vec3){x, hill(x, z), z}, -3, d), d, 10};
                RayHit hit = {0};
                CHECK(all[k].type->ray(&all[k], &down, &hit));
                if (i % 2 == 0 && j % 2 == 0)
                    CHECK_NEAR(hit.point.y, hill(x, z), 1e-14);
                CHECK(all[k].type->ray(&all[k], &slant, &hit));
            }
        shape_free(&all[k]);
    }
}

TEST(an_open_mesh_has_two_sides)
{
    const int64_t sheet[3] = {1, 2, 3};         /* z = 0, normal +z */
    Shape s = mesh_of(box_v, 8, sheet, 3);
    Ray up = {{0.2, 0.3, -1}, {0, 0, 1}, 5}, down = {{0.2, 0.3, 1}, {0, 0, -1}, 5};
    RayHit hit = {0};
    CHECK(s.type->ray(&s, &up, &hit));
    CHECK_NEAR(hit.normal.z, -1, 0);
    CHECK(s.type->ray(&s, &down, &hit));
    CHECK_NEAR(hit.normal.z, 1, 0);
    shape_free(&s);
}

/* ---- the height field alone ---- */

TEST(a_height_field_lies_where_it_should)
{
    const real h[6] = {0, 1, 2, 10, 11, 12};    /* y = x/2 + 1 + 10 (z + 3) / 6 over [-2, 2] x [-3, 3]: one plane */
    Shape s;
    char why[128];
    dig_heightfield_def def = {.heights = h, .columns = 3, .rows = 2, .size = {4, 0, 6}};
    CHECK_INT(shape_make("heightfield", &def, &s, why, sizeof why), DIG_OK);
    box3 b = s.type->bounds(&s, pose_identity());
    CHECK_NEAR(vec3_distance(b.low, (vec3){-2, 0, -3}), 0, 1e-15);
    CHECK_NEAR(vec3_distance(b.high, (vec3){2, 12, 3}), 0, 1e-15);

    uint64_t state = 3;
    vec3 n = vec3_unit((vec3){-0.5, 1, -10.0 / 6});
    for (int i = 0; i < 500; i++) {
        real x = 2 * draw(&state), z = 3 * draw(&state), y = x / 2 + 1 + 10 * (z + 3) / 6;
        CHECK(s.type->contains(&s, (vec3){x, y - 1e-9, z}));
        CHECK(!s.type->contains(&s, (vec3){x, y + 1e-9, z}));
        Ray ray = {{x, y + 2, z}, {0, -1, 0}, 5};
        RayHit hit = {0};
        CHECK(s.type->ray(&s, &ray, &hit));
        CHECK_NEAR(hit.distance, 2, 1e-13);
        CHECK_NEAR(vec3_distance(hit.normal, n), 0, 1e-14);
        ray = (Ray){{x, y - 2, z}, {0, 1, 0}, 5};
        CHECK(!s.type->ray(&s, &ray, &hit));
    }
    CHECK(!s.type->contains(&s, (vec3){2.1, -5, 0}));
    CHECK(!s.type->solid && s.type->mass == NULL);

    ShapeMesh m;
    CHECK_INT(s.type->mesh(&s, &m), DIG_OK);
    CHECK_INT(m.vertex_count, 6);
    CHECK_INT(m.index_count, 12);
    for (int i = 0; i < 6; i++)
        CHECK_NEAR(m.normals[3 * i + 1], n.y, 1e-6);
    free(m.vertices);
    free(m.normals);
    free(m.indices);
    shape_free(&s);
}

TEST(bounds_of_a_turned_surface_hold_it)
{
    uint64_t state = 4;
    Shape all[2] = {hills(9), field(9, 7)};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 100; i++) {
            pose at = {draw_vec3(&state), quat_exp(vec3_scale(3, draw_vec3(&state)))};
            box3 b = box3_grow(all[k].type->bounds(&all[k], at), 1e-14);
            for (int p = total_pieces(&all[k]) - 1; p >= 0; p--) {
                vec3 c[3];
                all[k].type->piece(&all[k], (uint32_t)p, c);
                for (int j = 0; j < 3; j++) {
                    vec3 x = pose_point(at, c[j]);
                    CHECK(box3_inside(b, (box3){x, x}));
                    CHECK(vec3_length(c[j]) <= all[k].outer * (1 + 1e-15));
                }
            }
        }
        shape_free(&all[k]);
    }
}

TEST(broken_height_fields_are_named)
{
    real h[4] = {0, 1, NAN, 2};
    check_refused("heightfield", &(dig_heightfield_def){.heights = h, .columns = 2, .rows = 2, .size = {1, 0, 1}}, DIG_E_FINITE,
                  "heightfield height in row 2, column 1 = nan m, must be -100000 to 100000 m");
    check_refused("heightfield", &(dig_heightfield_def){.heights = h, .columns = 1, .rows = 2, .size = {1, 0, 1}}, DIG_E_ARG,
                  "heightfield columns = 1, must be 2 to 4096");
    check_refused("heightfield", &(dig_heightfield_def){.heights = h, .columns = 2, .rows = 2, .size = {1, 0, 0}}, DIG_E_ARG,
                  "heightfield size = 0 m along z, must be 0.0001 to 100000 m");
    check_refused("heightfield", &(dig_heightfield_def){.columns = 2, .rows = 2, .size = {1, 0, 1}}, DIG_E_ARG,
                  "heightfield has no heights, must have 4");
}

int main(void)
{
    RUN_TESTS(unit_test(a_closed_mesh_weighs_what_its_box_weighs), unit_test(a_mesh_with_a_hole_weighs_the_difference),
              unit_test(a_mesh_inside_out_is_turned_round), unit_test(leaks_are_noticed), unit_test(equal_vertices_are_joined),
              unit_test(triangles_without_area_are_dropped), unit_test(broken_lists_are_named),
              unit_test(pieces_are_those_whose_bounds_meet_the_box), unit_test(neighbours_know_each_other),
              unit_test(rays_find_the_nearest_triangle), unit_test(rays_do_not_slip_between_triangles),
              unit_test(an_open_mesh_has_two_sides), unit_test(a_height_field_lies_where_it_should),
              unit_test(bounds_of_a_turned_surface_hold_it), unit_test(broken_height_fields_are_named));
}
