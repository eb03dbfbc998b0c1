/* geom/hull.c - the convex hull of points: at most 255 corners, faces merged to polygons. The points stay in the body's frame. */
#include <stdlib.h>

#include "geom/hull_build.h"
#include "geom/mass.h"
#include "geom/wet.h"

static const dig_param hull_params[] = {
    {.name = "points", .kind = DIG_POINTS, .unit = "m", .doc = "at least 4 points not in one plane; at most 255 end up as corners",
     .fallback = NAN, .min = -SHAPE_LENGTH_MAX, .max = SHAPE_LENGTH_MAX, .offset = offsetof(dig_hull_def, points), .required = true,
     .most = HULL_POINTS},
    {0}
};

/* ---- making ---- */

/* The plane goes through the corner of the whole hull that lies farthest out, so that no corner is outside any face. */
static HullFace face_of(const HullWork *work, int f)
{
    HullFace face = {vec3_unit(hull_area(work, f)), -INFINITY, work->first[f], work->count[f]};
    for (int i = 0; i < work->vertex_count; i++)
        face.offset = real_max(face.offset, vec3_dot(face.normal, work->vertices[i]));
    return face;
}

static dig_status mass_of_faces(const HullWork *work, MassProps *out)
{
    uint32_t *triangles = malloc(3 * sizeof *triangles * (size_t)work->corner_count);
    int count = 0;
    if (!triangles)
        return DIG_E_MEMORY;
    for (int f = 0; f < work->face_count; f++)
        for (int i = 1; i + 1 < work->count[f]; i++, count++) {
            const uint8_t *corners = work->corners + work->first[f];
            triangles[3 * count]     = corners[0];
            triangles[3 * count + 1] = corners[i];
            triangles[3 * count + 2] = corners[i + 1];
        }
    mass_of_triangles(work->vertices, triangles, count, out);
    free(triangles);
    return DIG_OK;
}

static void copy_work(const HullWork *work, HullData *d)
{
    /* the arrays follow the header: the only place that writes through their accessors */
    vec3 *vertices   = (vec3 *)(void *)(d + 1);
    HullFace *faces  = (HullFace *)(void *)(vertices + d->vertex_count);
    HullEdge *edges  = (HullEdge *)(void *)(faces + d->face_count);
    uint8_t *corners = (uint8_t *)(edges + d->edge_count);
    int edge = 0;

    memcpy(vertices, work->vertices, (size_t)d->vertex_count * sizeof *vertices);
    memcpy(corners, work->corners, (size_t)d->corner_count);
    for (int f = 0; f < d->face_count; f++)
        faces[f] = face_of(work, f);
    for (int a = 0; a < d->vertex_count; a++)
        for (int b = a + 1; b < d->vertex_count; b++)
            if (work->side[a][b])
                edges[edge++] = (HullEdge){(uint8_t)a, (uint8_t)b, (uint16_t)(work->side[a][b] - 1), (uint16_t)(work->side[b][a] - 1)};
}

dig_status hull_make_data(const HullWork *work, Shape *s)
{
    HullData header = {.vertex_count = work->vertex_count, .face_count = work->face_count, .edge_count = work->corner_count / 2,
                       .corner_count = work->corner_count};
    DIG_TRY(mass_of_faces(work, &header.mass));
    HullData *d = shape_alloc(s, sizeof header + (size_t)header.vertex_count * sizeof(vec3) + (size_t)header.face_count * sizeof(HullFace) +
                              (size_t)header.edge_count * sizeof(HullEdge) + (size_t)header.corner_count);
    if (!d)
        return DIG_E_MEMORY;
    *d = header;
    copy_work(work, d);

    s->inner = INFINITY;
    for (int f = 0; f < d->face_count; f++)
        s->inner = real_min(s->inner, hull_faces(d)[f].offset - vec3_dot(hull_faces(d)[f].normal, d->mass.centre));
    for (int i = 0; i < d->vertex_count; i++)
        s->outer = real_max(s->outer, vec3_length(hull_vertices(d)[i]));
    return DIG_OK;
}

static dig_status hull_make(const void *def, Shape *s, char *why, size_t capacity)
{
    HullWork *work = malloc(sizeof *work);
    if (!work)
        return DIG_E_MEMORY;
    dig_status status = hull_build(&((const dig_hull_def *)def)->points, work, why, capacity);
    if (status == DIG_OK)
        status = hull_make_data(work, s);
    free(work);
    return status;
}

/* ---- asking ---- */

/* All corners in turn, two at a time: for at most 255 of them this beats walking along edges, and is exact on nearly flat faces. */
static vec3 hull_support(const Shape *s, vec3 direction)
{
    const HullData *d = s->data;
    const vec3 *v = hull_vertices(d);
    int  best[2] = {0, 1}, i = 2;
    real far0 = vec3_dot(v[0], direction), far1 = vec3_dot(v[1], direction);

    for (; i + 1 < d->vertex_count; i += 2) {
        real d0 = vec3_dot(v[i], direction), d1 = vec3_dot(v[i + 1], direction);
        best[0] = d0 > far0 ? i : best[0];
        far0    = d0 > far0 ? d0 : far0;
        best[1] = d1 > far1 ? i + 1 : best[1];
        far1    = d1 > far1 ? d1 : far1;
    }
    if (i < d->vertex_count && vec3_dot(v[i], direction) > far0) {
        best[0] = i;
        far0 = vec3_dot(v[i], direction);
    }
    return v[far1 > far0 || (far1 == far0 && best[1] < best[0]) ? best[1] : best[0]];
}

static box3 hull_bounds(const Shape *s, pose at)
{
    const HullData *d = s->data;
    mat3 R = quat_matrix(at.q);
    vec3 first = mat3_mul_vec(R, hull_vertices(d)[0]);
    box3 b = {first, first};
    for (int i = 1; i < d->vertex_count; i++) {
        vec3 p = mat3_mul_vec(R, hull_vertices(d)[i]);
        b = (box3){vec3_min(b.low, p), vec3_max(b.high, p)};
    }
    return (box3){vec3_add(b.low, at.p), vec3_add(b.high, at.p)};
}

/* Each face as a fan. */
static real hull_area_of(const Shape *s)
{
    const HullData *d = hull_data(s);
    real sum = 0;
    for (int f = 0; f < d->face_count; f++) {
        const HullFace *face = &hull_faces(d)[f];
        const uint8_t *corner = hull_corners(d) + face->first;
        for (int i = 2; i < face->count; i++)
            sum += shape_triangle_area((vec3[]){hull_vertices(d)[corner[0]], hull_vertices(d)[corner[i - 1]], hull_vertices(d)[corner[i]]});
    }
    return sum;
}

static vec3 hull_middle(const Shape *s) { return hull_data(s)->mass.centre; }

static void hull_mass(const Shape *s, MassProps *out)
{
    *out = hull_data(s)->mass;
}

/* Corners of a face, in order. */
static int corners_of(const HullData *d, const HullFace *f, vec3 corners[HULL_VERTICES])
{
    for (int k = 0; k < f->count; k++)
        corners[k] = hull_vertices(d)[hull_corners(d)[f->first + k]];
    return f->count;
}

static void hull_wet(const Shape *s, vec3 normal, real offset, Wet *sum)
{
    const HullData *d = s->data;
    vec3 corners[HULL_VERTICES];
    for (int f = 0; f < d->face_count; f++)
        wet_face(sum, corners, corners_of(d, &hull_faces(d)[f], corners), normal, offset);
}

/* Half of what all faces show: the front casts the same shadow as the back. */
static real hull_shadow(const Shape *s, vec3 direction)
{
    const HullData *d = s->data;
    vec3 c[HULL_VERTICES];
    real sum = 0;
    for (int f = 0; f < d->face_count; f++) {
        vec3 area = vec3_zero();
        int n = corners_of(d, &hull_faces(d)[f], c);
        for (int k = 2; k < n; k++)
            area = vec3_add(area, vec3_cross(vec3_sub(c[k - 1], c[0]), vec3_sub(c[k], c[0])));
        sum += 0.25 * fabs(vec3_dot(area, direction));
    }
    return sum;
}

static bool hull_contains(const Shape *s, vec3 p)
{
    const HullData *d = s->data;
    for (int f = 0; f < d->face_count; f++)
        if (vec3_dot(hull_faces(d)[f].normal, p) > hull_faces(d)[f].offset)
            return false;
    return true;
}

/* Cuts the line by every face in turn (Cyrus & Beck 1978). */
static bool hull_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    const HullData *d = s->data;
    real enter = -INFINITY, leave = INFINITY;
    vec3 normal = {0, 0, 0};

    for (int f = 0; f < d->face_count; f++) {
        const HullFace *face = &hull_faces(d)[f];
        real above = vec3_dot(face->normal, ray->from) - face->offset, climbs = vec3_dot(face->normal, ray->along);
        if (climbs == 0) {
            if (above > 0)
                return false;
        } else if (climbs > 0) {
            leave = real_min(leave, -above / climbs);
        } else if (-above / climbs > enter) {
            enter  = -above / climbs;
            normal = face->normal;
        }
    }
    return enter <= leave && enter > 0 && shape_hit(ray, enter, normal, hit);
}

static int hull_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    const HullData *d = s->data;
    const HullFace *faces = hull_faces(d);
    int best = 0;
    real most = vec3_dot(faces[0].normal, direction);
    for (int f = 1; f < d->face_count; f++) {
        real x = vec3_dot(faces[f].normal, direction);
        if (x > most) {
            most = x;
            best = f;
        }
    }
    int count = int_min(faces[best].count, 16);
    for (int k = 0; k < count; k++)
        corners[k] = hull_vertices(d)[hull_corners(d)[faces[best].first + k * faces[best].count / count]];
    *feature = (uint32_t)best;
    return count;
}

static dig_status hull_mesh(const Shape *s, ShapeMesh *out)
{
    const HullData *d = s->data;
    int triangle = 0;
    DIG_TRY(shape_mesh_open(out, d->vertex_count, 3 * (d->corner_count - 2 * d->face_count), false));
    for (int i = 0; i < d->vertex_count; i++)
        shape_mesh_vertex(out, i, hull_vertices(d)[i]);
    for (int f = 0; f < d->face_count; f++) {
        const uint8_t *c = hull_corners(d) + hull_faces(d)[f].first;
        for (int i = 1; i + 1 < hull_faces(d)[f].count; i++)
            shape_mesh_triangle(out, triangle++, c[0], c[i], c[i + 1]);
    }
    return DIG_OK;
}

const ShapeType shape_hull = {
    .name     = "hull",
    .doc      = "The convex hull of points.",
    .params   = hull_params,
    .def_size = sizeof(dig_hull_def),
    .solid    = true,
    .convex   = true,
    .make     = hull_make,
    .support  = hull_support,
    .middle   = hull_middle,
    .bounds   = hull_bounds,
    .mass     = hull_mass,
    .wet      = hull_wet,
    .shadow   = hull_shadow,
    .drag     = 1.05,
    .area     = hull_area_of,
    .ray      = hull_ray,
    .contains = hull_contains,
    .mesh     = hull_mesh,
    .face     = hull_face,
};
