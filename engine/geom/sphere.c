/* geom/sphere.c - the sphere: a point with a rounding radius. */
#include "geom/shape_build.h"

static const dig_param sphere_params[] = {
    SHAPE_LENGTH("radius", "radius", dig_sphere_def, radius),
    {0}
};

static real radius_of(const Shape *s) { return ((const SphereData *)s->data)->radius; }

static dig_status sphere_make(const void *def, Shape *s, char *why, size_t capacity)
{
    real r = ((const dig_sphere_def *)def)->radius;
    SphereData *d = shape_alloc(s, sizeof *d);
    (void)why;
    (void)capacity;
    if (!d)
        return DIG_E_MEMORY;
    d->radius = r;
    s->round = s->inner = s->outer = s->rolling = r;
    return DIG_OK;
}

static vec3 sphere_support(const Shape *s, vec3 direction)
{
    (void)s;
    (void)direction;
    return vec3_zero();
}

static box3 sphere_bounds(const Shape *s, pose at)
{
    return box3_grow((box3){at.p, at.p}, s->round);
}

static real sphere_area(const Shape *s)
{
    real r = ((const SphereData *)s->data)->radius;
    return 4 * DIG_PI * r * r;
}

static void sphere_mass(const Shape *s, MassProps *out)
{
    real r = radius_of(s), volume = 4.0 / 3 * DIG_PI * r * r * r, I = 0.4 * volume * r * r;
    *out = (MassProps){.volume = volume, .inertia = mat3_diagonal((vec3){I, I, I})};
}

static bool sphere_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    real r = radius_of(s);
    if (vec3_length2(ray->from) <= r * r)
        return false;

    /* from the point of the line next to the centre: a far start costs no digits */
    real middle = -vec3_dot(ray->from, ray->along);
    vec3 nearest = vec3_mad(ray->from, middle, ray->along);
    real disc = r * r - vec3_length2(nearest);
    if (!(disc >= 0))
        return false;
    real back = sqrt(disc);
    return shape_hit(ray, middle - back, vec3_scale(1 / r, vec3_mad(nearest, -back, ray->along)), hit);
}

static bool sphere_contains(const Shape *s, vec3 p)
{
    return vec3_length2(p) <= radius_of(s) * radius_of(s);
}

/* ---- drawing: an icosahedron, each triangle cut into four twice ---- */

typedef struct Icosphere {
    vec3     v[162];
    uint32_t parents[162][2];       /* of the edge whose middle the vertex is */
    int      count;
} Icosphere;

static uint32_t middle_of(Icosphere *m, uint32_t a, uint32_t b)
{
    uint32_t lo = a < b ? a : b, hi = a < b ? b : a;
    for (int i = 12; i < m->count; i++)
        if (m->parents[i][0] == lo && m->parents[i][1] == hi)
            return (uint32_t)i;
    int i = m->count++;
    m->v[i] = vec3_unit(vec3_add(m->v[lo], m->v[hi]));
    m->parents[i][0] = lo;
    m->parents[i][1] = hi;
    return (uint32_t)i;
}

static dig_status sphere_mesh(const Shape *s, ShapeMesh *out)
{
    static const uint32_t faces[20][3] = {
        {0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
        {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}
    };
    const real g = 1.6180339887498949;          /* golden ratio */
    const vec3 corners[12] = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g},
                              {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    Icosphere m = {.count = 12};
    uint32_t t[2][320][3];
    for (int i = 0; i < 12; i++)
        m.v[i] = vec3_unit(corners[i]);
    memcpy(t[0], faces, sizeof faces);

    int count = 20;
    for (int level = 0; level < 2; level++, count *= 4)
        for (int i = 0; i < count; i++) {
            const uint32_t *f = t[level][i];
            uint32_t a = f[0], b = f[1], c = f[2];
            uint32_t ab = middle_of(&m, a, b), bc = middle_of(&m, b, c), ca = middle_of(&m, c, a);
            const uint32_t parts[4][3] = {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}};
            memcpy(t[1 - level][4 * i], parts, sizeof parts);
        }

    DIG_TRY(shape_mesh_open(out, m.count, 3 * count, true));
    for (int i = 0; i < m.count; i++) {
        shape_mesh_vertex(out, i, vec3_scale(radius_of(s), m.v[i]));
        shape_mesh_normal(out, i, m.v[i]);
    }
    for (int i = 0; i < count; i++)             /* two levels end where they began: in t[0] */
        shape_mesh_triangle(out, i, t[0][i][0], t[0][i][1], t[0][i][2]);
    return DIG_OK;
}

static void sphere_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    real r = s->round, d = real_clamp(offset, -r, r), rest = (r - d) * (r + d);
    sum->volume += DIG_PI * (r + d) * (r + d) * (2 * r - d) / 3;
    sum->moment = vec3_mad(sum->moment, -0.25 * DIG_PI * rest * rest, normal);
}

static real sphere_shadow(const Shape *s, vec3 direction)
{
    (void)direction;
    return DIG_PI * s->round * s->round;
}

static int sphere_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    (void)s;
    (void)direction;
    corners[0] = vec3_zero();
    *feature = 0;
    return 1;
}

const ShapeType shape_sphere = {
    .name     = "sphere",
    .doc      = "A ball about its origin.",
    .params   = sphere_params,
    .def_size = sizeof(dig_sphere_def),
    .solid    = true,
    .convex   = true,
    .make     = sphere_make,
    .support  = sphere_support,
    .bounds   = sphere_bounds,
    .mass     = sphere_mass,
    .wet      = sphere_wet,
    .shadow   = sphere_shadow,
    .drag     = 0.47,
    .area     = sphere_area,
    .ray      = sphere_ray,
    .contains = sphere_contains,
    .mesh     = sphere_mesh,
    .face     = sphere_face,
};
