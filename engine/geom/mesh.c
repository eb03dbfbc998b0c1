/* geom/mesh.c - the triangle mesh: a closed one has an inside and an exact mass. */
#include "geom/mesh_build.h"

static const dig_param mesh_params[] = {
    {.name = "vertices", .kind = DIG_POINTS, .unit = "m", .doc = "corners of the triangles", .fallback = NAN, .min = -SHAPE_LENGTH_MAX,
     .max = SHAPE_LENGTH_MAX, .offset = offsetof(dig_mesh_def, vertices), .required = true},
    {.name = "triangles", .kind = DIG_INDICES, .unit = "", .doc = "three vertex numbers a triangle, from 1, counter-clockwise outside",
     .fallback = NAN, .min = 1, .max = MESH_TRIANGLES, .offset = offsetof(dig_mesh_def, triangles), .required = true},
    {0}
};

static dig_status mesh_make(const void *def, Shape *s, char *why, size_t capacity)
{
    return mesh_build(def, s, why, capacity);
}

static void corners_of(const MeshData *d, uint32_t piece, vec3 corners[3])
{
    const uint32_t *t = mesh_triangles(d) + 3 * (size_t)piece;
    for (int k = 0; k < 3; k++)
        corners[k] = mesh_vertices(d)[t[k]];
}

/* Of the box about the triangles: not tight where the mesh is turned, but most meshes stand still. */
static box3 mesh_bounds(const Shape *s, pose at)
{
    box3 local = mesh_nodes(s->data)->box;
    mat3 R = quat_matrix(at.q);
    vec3 half = vec3_scale(0.5, vec3_sub(local.high, local.low)), middle = pose_point(at, vec3_lerp(local.low, local.high, 0.5));
    vec3 e = {vec3_dot(vec3_abs(R.r0), half), vec3_dot(vec3_abs(R.r1), half), vec3_dot(vec3_abs(R.r2), half)};
    return (box3){vec3_sub(middle, e), vec3_add(middle, e)};
}

static real mesh_area(const Shape *s)
{
    const MeshData *d = s->data;
    vec3 c[3];
    real sum = 0;
    for (int i = 0; i < d->triangle_count; i++) {
        corners_of(d, (uint32_t)i, c);
        sum += shape_triangle_area(c);
    }
    return sum;
}

static void mesh_mass(const Shape *s, MassProps *out)
{
    *out = ((const MeshData *)s->data)->mass;
}

bool shape_mesh_closed(const Shape *s)
{
    return s->type == &shape_mesh && ((const MeshData *)s->data)->closed;
}

/* The nearest crossing. Where a closed surface is left before it is entered, the ray started inside. */
static bool mesh_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    const MeshData *d = s->data;
    const MeshNode *nodes = mesh_nodes(d);
    TriangleRay prepared = shape_triangle_ray(ray);
    real best = INFINITY, limit = ray->length, enter, t;
    vec3 normal = {0, 0, 0}, c[3];

    for (uint32_t i = 0; i < (uint32_t)d->node_count;) {
        const MeshNode *node = &nodes[i];
        if (!shape_ray_box(ray, node->box, limit, &enter)) {
            i = node->next;
            continue;
        }
        for (uint32_t k = node->first; k < node->first + node->count; k++) {
            corners_of(d, k, c);
            if (!shape_ray_triangle(&prepared, c, &t) || t > limit)
                continue;
            vec3 n = vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0]));
            if (t < best || vec3_dot(n, ray->along) < 0) {      /* at a silhouette both sides are met at once: the front counts */
                best = limit = t;
                normal = n;
            }
        }
        i++;
    }
    bool behind = vec3_dot(normal, ray->along) > 0;
    if (!isfinite(best) || (behind && d->closed))
        return false;
    return shape_hit(ray, best, vec3_unit(behind ? vec3_neg(normal) : normal), hit);
}

/* How often the surface winds round the point: the sum of the solid angles of the triangles over 4 pi.
 *
 * Source: Van Oosterom & Strackee, The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30(2), 1983. */
static bool mesh_contains(const Shape *s, vec3 p)
{
    const MeshData *d = s->data;
    box3 point = {p, p};
    if (!d->closed || !box3_overlap(mesh_nodes(d)->box, point))
        return false;

    real angle = 0;         /* half of the solid angle */
    for (uint32_t i = 0; i < (uint32_t)d->triangle_count; i++) {
        vec3 c[3];
        corners_of(d, i, c);
        for (int k = 0; k < 3; k++)
            c[k] = vec3_sub(c[k], p);
        real a = vec3_length(c[0]), b = vec3_length(c[1]), e = vec3_length(c[2]);
        real below = a * b * e + vec3_dot(c[0], c[1]) * e + vec3_dot(c[1], c[2]) * a + vec3_dot(c[2], c[0]) * b;
        angle += atan2(vec3_dot(c[0], vec3_cross(c[1], c[2])), below);
    }
    return angle > DIG_PI;
}

static dig_status mesh_mesh(const Shape *s, ShapeMesh *out)
{
    const MeshData *d = s->data;
    DIG_TRY(shape_mesh_open(out, d->vertex_count, 3 * d->triangle_count, false));
    for (int i = 0; i < d->vertex_count; i++)
        shape_mesh_vertex(out, i, mesh_vertices(d)[i]);
    memcpy(out->indices, mesh_triangles(d), 3 * (size_t)d->triangle_count * sizeof *out->indices);
    return DIG_OK;
}

/* ---- against planes: as its convex hull ---- */

/* How far a box reaches along d. */
static real box_along(box3 box, vec3 d)
{
    vec3 far = {d.x > 0 ? box.high.x : box.low.x, d.y > 0 ? box.high.y : box.low.y, d.z > 0 ? box.high.z : box.low.z};
    return vec3_dot(far, d);
}

typedef void VertexVisit(void *context, uint32_t number, vec3 v);

/* Every vertex that reaches at least *most along d, some of them more than once; visit may raise *most. */
static void visit_along(const MeshData *d, vec3 along, const real *most, VertexVisit *visit, void *context)
{
    const MeshNode *nodes = mesh_nodes(d);
    for (uint32_t i = 0; i < (uint32_t)d->node_count;) {
        if (box_along(nodes[i].box, along) < *most) {
            i = nodes[i].next;
            continue;
        }
        for (uint32_t k = 3 * nodes[i].first; k < 3 * (nodes[i].first + nodes[i].count); k++) {
            uint32_t number = mesh_triangles(d)[k];
            vec3 v = mesh_vertices(d)[number];
            if (vec3_dot(v, along) >= *most)
                visit(context, number, v);
        }
        i++;
    }
}

typedef struct Farthest { vec3 along, at; real most; } Farthest;

static void take_farthest(void *context, uint32_t number, vec3 v)
{
    (void)number;
    Farthest *f = context;
    real reach = vec3_dot(v, f->along);
    if (reach > f->most) {
        f->most = reach;
        f->at = v;
    }
}

static vec3 mesh_support(const Shape *s, vec3 direction)
{
    Farthest f = {.along = direction, .most = -INFINITY};
    visit_along(s->data, direction, &f.most, take_farthest, &f);
    return f.at;
}

typedef struct Foot { vec3 across[SHAPE_FOOT]; real most[SHAPE_FOOT]; vec3 at[SHAPE_FOOT]; uint32_t number[SHAPE_FOOT]; } Foot;

static void take_foot(void *context, uint32_t number, vec3 v)
{
    Foot *f = context;
    for (int i = 0; i < SHAPE_FOOT; i++) {
        real reach = vec3_dot(v, f->across[i]);
        if (reach > f->most[i]) {
            f->most[i] = reach;
            f->at[i] = v;
            f->number[i] = number;
        }
    }
}

static int mesh_foot(const Shape *s, vec3 down, real height, vec3 corners[SHAPE_FOOT], uint32_t feature[SHAPE_FOOT])
{
    Foot f;
    vec3 u, v;
    int count = 0;
    real from = vec3_dot(mesh_support(s, down), down) - height;
    vec3_basis(down, &u, &v);
    for (int i = 0; i < SHAPE_FOOT; i++) {
        real angle = 2 * DIG_PI * (i + 0.3) / SHAPE_FOOT;        /* square to no edge of what is made along axes: all of it would be farthest */
        f.across[i] = vec3_mad(vec3_scale(cos(angle), u), sin(angle), v);
        f.most[i] = -INFINITY;
    }
    visit_along(s->data, down, &from, take_foot, &f);
    for (int i = 0; i < SHAPE_FOOT; i++) {
        if (count > 0 && (f.number[i] == feature[count - 1] || f.number[i] == feature[0]))
            continue;
        corners[count] = f.at[i];
        feature[count++] = f.number[i];
    }
    return count;
}

/* ---- pieces: the triangles ---- */

static void mesh_piece(const Shape *s, uint32_t piece, vec3 corners[3])
{
    corners_of(s->data, piece, corners);
}

static int mesh_pieces(const Shape *s, box3 box, uint32_t *piece, int capacity)
{
    const MeshData *d = s->data;
    const MeshNode *nodes = mesh_nodes(d);
    int count = 0;

    for (uint32_t i = 0; i < (uint32_t)d->node_count;) {
        const MeshNode *node = &nodes[i];
        if (!box3_overlap(node->box, box)) {
            i = node->next;
            continue;
        }
        for (uint32_t k = node->first; k < node->first + node->count; k++) {
            vec3 c[3];
            corners_of(d, k, c);
            box3 around = {vec3_min(c[0], vec3_min(c[1], c[2])), vec3_max(c[0], vec3_max(c[1], c[2]))};
            if (!box3_overlap(around, box))
                continue;
            if (count < capacity)
                piece[count] = k;
            count++;
        }
        i++;
    }
    return count;
}

static uint32_t mesh_neighbour(const Shape *s, uint32_t piece, int edge)
{
    return mesh_neighbours(s->data)[3 * (size_t)piece + (size_t)edge];
}

const ShapeType shape_mesh = {
    .name     = "mesh",
    .doc      = "A surface of triangles; without mass unless it is closed.",
    .params   = mesh_params,
    .def_size = sizeof(dig_mesh_def),
    .make     = mesh_make,
    .support  = mesh_support,
    .foot     = mesh_foot,
    .bounds   = mesh_bounds,
    .mass     = mesh_mass,
    .area     = mesh_area,
    .ray      = mesh_ray,
    .contains = mesh_contains,
    .mesh     = mesh_mesh,
    .pieces   = mesh_pieces,
    .piece    = mesh_piece,
    .neighbour = mesh_neighbour,
};
