/* geom/box.c - the box about its origin, edges along the axes. */
#include "geom/shape_build.h"
#include "geom/wet.h"

static const dig_param box_params[] = {
    {.name = "size", .kind = DIG_SIZE3, .unit = "m", .doc = "full extents along x, y and z; a number makes a cube", .fallback = NAN,
     .min = SHAPE_LENGTH_MIN, .max = SHAPE_LENGTH_MAX, .offset = offsetof(dig_box_def, size), .required = true},
    {0}
};

static vec3 half_of(const Shape *s) { return ((const BoxData *)s->data)->half; }

static dig_status box_make(const void *def, Shape *s, char *why, size_t capacity)
{
    BoxData *d = shape_alloc(s, sizeof *d);
    (void)why;
    (void)capacity;
    if (!d)
        return DIG_E_MEMORY;
    d->half  = vec3_scale(0.5, ((const dig_box_def *)def)->size);
    s->inner = real_min(d->half.x, real_min(d->half.y, d->half.z));
    s->outer = vec3_length(d->half);
    return DIG_OK;
}

static vec3 box_support(const Shape *s, vec3 direction)
{
    vec3 h = half_of(s);
    return (vec3){direction.x < 0 ? -h.x : h.x, direction.y < 0 ? -h.y : h.y, direction.z < 0 ? -h.z : h.z};
}

static box3 box_bounds(const Shape *s, pose at)
{
    mat3 R = quat_matrix(at.q);
    vec3 h = half_of(s);
    vec3 e = {vec3_dot(vec3_abs(R.r0), h), vec3_dot(vec3_abs(R.r1), h), vec3_dot(vec3_abs(R.r2), h)};
    return (box3){vec3_sub(at.p, e), vec3_add(at.p, e)};
}

static real box_area(const Shape *s)
{
    vec3 h = ((const BoxData *)s->data)->half;
    return 8 * (h.x * h.y + h.y * h.z + h.z * h.x);
}

static void box_mass(const Shape *s, MassProps *out)
{
    vec3 h = half_of(s), h2 = vec3_mul(h, h);
    real volume = 8 * h.x * h.y * h.z, k = volume / 3;      /* m (2h)^2 / 12 = m h^2 / 3 */
    *out = (MassProps){.volume = volume, .inertia = mat3_diagonal((vec3){k * (h2.y + h2.z), k * (h2.z + h2.x), k * (h2.x + h2.y)})};
}

static void box_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    static const int face[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    vec3 h = half_of(s), c[4];
    for (int f = 0; f < 6; f++) {
        for (int k = 0; k < 4; k++)
            c[k] = (vec3){face[f][k] & 1 ? h.x : -h.x, face[f][k] & 2 ? h.y : -h.y, face[f][k] & 4 ? h.z : -h.z};
        wet_face(sum, c, 4, normal, offset);
    }
}

static real box_shadow(const Shape *s, vec3 direction)
{
    vec3 h = half_of(s), d = vec3_abs(direction);
    return 4 * (d.x * h.y * h.z + d.y * h.z * h.x + d.z * h.x * h.y);
}

static bool box_contains(const Shape *s, vec3 p)
{
    vec3 h = half_of(s);
    return fabs(p.x) <= h.x && fabs(p.y) <= h.y && fabs(p.z) <= h.z;
}

/* The last of the three slabs to be entered gives the normal. */
static bool box_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    vec3 half = half_of(s);
    real enter = -INFINITY, leave = INFINITY;
    vec3 normal = {0, 0, 0};
    if (box_contains(s, ray->from))
        return false;

    for (int i = 0; i < 3; i++) {
        real o = vec3_at(ray->from, i), d = vec3_at(ray->along, i), h = vec3_at(half, i);
        if (d == 0) {
            if (fabs(o) > h)
                return false;
            continue;
        }
        real near_side = (d > 0 ? -h : h), t = (near_side - o) / d;
        if (t > enter) {
            real out = d > 0 ? -1 : 1;
            enter  = t;
            normal = (vec3){i == 0 ? out : 0, i == 1 ? out : 0, i == 2 ? out : 0};
        }
        leave = real_min(leave, (-near_side - o) / d);
    }
    return enter <= leave && shape_hit(ray, enter, normal, hit);
}

/* Corners of the face across axis i on side +1 or -1, counter-clockwise seen from outside. */
static void face_corners(vec3 half, int i, real side, vec3 corners[4])
{
    static const real along_u[4] = {1, -1, -1, 1}, along_v[4] = {1, 1, -1, -1};
    int u = (i + 1) % 3, v = (i + 2) % 3;
    real h[3] = {half.x, half.y, half.z};

    for (int k = 0; k < 4; k++) {
        int from = side > 0 ? k : 3 - k;
        real c[3];
        c[i] = side * h[i];
        c[u] = along_u[from] * h[u];
        c[v] = along_v[from] * h[v];
        corners[k] = (vec3){c[0], c[1], c[2]};
    }
}

static int box_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    vec3 a = vec3_abs(direction);
    int  i = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    bool positive = vec3_at(direction, i) >= 0;
    face_corners(half_of(s), i, positive ? 1 : -1, corners);
    *feature = (uint32_t)(2 * i + (positive ? 1 : 0));
    return 4;
}

static dig_status box_mesh(const Shape *s, ShapeMesh *out)
{
    DIG_TRY(shape_mesh_open(out, 24, 36, true));
    for (int f = 0; f < 6; f++) {
        vec3 c[4], n = {0, 0, 0};
        real side = f % 2 ? 1 : -1;
        face_corners(half_of(s), f / 2, side, c);
        *(f / 2 == 0 ? &n.x : f / 2 == 1 ? &n.y : &n.z) = side;
        for (int k = 0; k < 4; k++) {
            shape_mesh_vertex(out, 4 * f + k, c[k]);
            shape_mesh_normal(out, 4 * f + k, n);
        }
        uint32_t first = (uint32_t)(4 * f);
        shape_mesh_triangle(out, 2 * f, first, first + 1, first + 2);
        shape_mesh_triangle(out, 2 * f + 1, first, first + 2, first + 3);
    }
    return DIG_OK;
}

const ShapeType shape_box = {
    .name     = "box",
    .doc      = "A box about its origin with edges along x, y and z.",
    .params   = box_params,
    .def_size = sizeof(dig_box_def),
    .solid    = true,
    .convex   = true,
    .make     = box_make,
    .support  = box_support,
    .bounds   = box_bounds,
    .mass     = box_mass,
    .wet      = box_wet,
    .shadow   = box_shadow,
    .drag     = 1.05,       /* a cube, face on */
    .area     = box_area,
    .ray      = box_ray,
    .contains = box_contains,
    .mesh     = box_mesh,
    .face     = box_face,
};
