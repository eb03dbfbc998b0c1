/* geom/heightfield.c - the ground as heights on a grid: y = height(x, z), centred on the origin, two triangles a cell.
 *
 * Cell (i, j) lies between columns i, i + 1 (x) and rows j, j + 1 (z). Its diagonal runs from its low corner to its high one:
 * piece 2 c is the triangle at the high-z side, piece 2 c + 1 the one at the high-x side, c = j (columns - 1) + i.
 */
#include "geom/shape_build.h"

#define GRID_MAX 4096

static const dig_param heightfield_params[] = {
    {.name = "columns", .kind = DIG_INT, .unit = "", .doc = "number of heights along x", .fallback = NAN, .min = 2, .max = GRID_MAX,
     .offset = offsetof(dig_heightfield_def, columns), .required = true},
    {.name = "rows", .kind = DIG_INT, .unit = "", .doc = "number of heights along z", .fallback = NAN, .min = 2, .max = GRID_MAX,
     .offset = offsetof(dig_heightfield_def, rows), .required = true},
    {.name = "size", .kind = DIG_VEC3, .unit = "m", .doc = "extents along x and z; y is ignored", .fallback = NAN, .min = 0,
     .max = SHAPE_LENGTH_MAX, .offset = offsetof(dig_heightfield_def, size), .required = true},
    {0}
};

static const HeightfieldData *data_of(const Shape *s) { return s->data; }

static real height_at(const HeightfieldData *d, int i, int j)
{
    return heightfield_heights(d)[(size_t)j * (size_t)d->columns + (size_t)i];
}

static vec3 point_at(const HeightfieldData *d, int i, int j)
{
    return (vec3){d->x0 + i * d->dx, height_at(d, i, j), d->z0 + j * d->dz};
}

static dig_status check_heights(const dig_heightfield_def *def, char *why, size_t capacity)
{
    if (!(def->size.x >= SHAPE_LENGTH_MIN && def->size.z >= SHAPE_LENGTH_MIN))
        return shape_fail(DIG_E_ARG, why, capacity, "heightfield size = %g m along %s, must be %g to %g m",
                          def->size.x >= SHAPE_LENGTH_MIN ? def->size.z : def->size.x, def->size.x >= SHAPE_LENGTH_MIN ? "z" : "x",
                          SHAPE_LENGTH_MIN, SHAPE_LENGTH_MAX);
    if (!def->heights)
        return shape_fail(DIG_E_ARG, why, capacity, "heightfield has no heights, must have %lld", (long long)(def->rows * def->columns));
    for (int64_t i = 0; i < def->rows * def->columns; i++)
        if (!(fabs(def->heights[i]) <= SHAPE_LENGTH_MAX))
            return shape_fail(isfinite(def->heights[i]) ? DIG_E_ARG : DIG_E_FINITE, why, capacity,
                              "heightfield height in row %lld, column %lld = %g m, must be %g to %g m", (long long)(i / def->columns + 1),
                              (long long)(i % def->columns + 1), def->heights[i], -SHAPE_LENGTH_MAX, SHAPE_LENGTH_MAX);
    return DIG_OK;
}

static dig_status heightfield_make(const void *def_, Shape *s, char *why, size_t capacity)
{
    const dig_heightfield_def *def = def_;
    DIG_TRY(check_heights(def, why, capacity));
    size_t count = (size_t)def->rows * (size_t)def->columns;
    HeightfieldData *d = shape_alloc(s, sizeof *d + count * sizeof(real));
    if (!d)
        return DIG_E_MEMORY;

    *d = (HeightfieldData){.columns = (int)def->columns, .rows = (int)def->rows, .x0 = -0.5 * def->size.x, .z0 = -0.5 * def->size.z,
                           .dx = def->size.x / (real)(def->columns - 1), .dz = def->size.z / (real)(def->rows - 1),
                           .low = INFINITY, .high = -INFINITY};
    real *heights = (real *)(void *)(d + 1);
    for (size_t i = 0; i < count; i++) {
        heights[i] = def->heights[i];
        d->low  = real_min(d->low, heights[i]);
        d->high = real_max(d->high, heights[i]);
    }
    s->outer = vec3_length((vec3){d->x0, real_max(fabs(d->low), fabs(d->high)), d->z0});
    return DIG_OK;
}

static box3 local_box(const HeightfieldData *d)
{
    return (box3){{d->x0, d->low, d->z0}, {d->x0 + (d->columns - 1) * d->dx, d->high, d->z0 + (d->rows - 1) * d->dz}};
}

static box3 heightfield_bounds(const Shape *s, pose at)
{
    box3 local = local_box(data_of(s));
    mat3 R = quat_matrix(at.q);
    vec3 half = vec3_scale(0.5, vec3_sub(local.high, local.low)), middle = pose_point(at, vec3_lerp(local.low, local.high, 0.5));
    vec3 e = {vec3_dot(vec3_abs(R.r0), half), vec3_dot(vec3_abs(R.r1), half), vec3_dot(vec3_abs(R.r2), half)};
    return (box3){vec3_sub(middle, e), vec3_add(middle, e)};
}

/* ---- pieces ---- */

static void heightfield_piece(const Shape *s, uint32_t piece, vec3 corners[3])
{
    const HeightfieldData *d = data_of(s);
    int cell = (int)(piece / 2), i = cell % (d->columns - 1), j = cell / (d->columns - 1);
    corners[0] = point_at(d, i, j);
    if (piece % 2 == 0) {
        corners[1] = point_at(d, i, j + 1);
        corners[2] = point_at(d, i + 1, j + 1);
    } else {
        corners[1] = point_at(d, i + 1, j + 1);
        corners[2] = point_at(d, i + 1, j);
    }
}

static real heightfield_area(const Shape *s)
{
    const HeightfieldData *d = data_of(s);
    vec3 c[3];
    real sum = 0;
    for (int i = 0; i < 2 * (d->columns - 1) * (d->rows - 1); i++) {
        heightfield_piece(s, (uint32_t)i, c);
        sum += shape_triangle_area(c);
    }
    return sum;
}

/* Cells that [low, high] touches along one axis, with a little to spare for rounding: the caller checks exactly. */
typedef struct Cells { int first, last; } Cells;

static Cells cells_between(real low, real high, real start, real step, int cells)
{
    const real slack = 1e-6;
    real first = floor((low - start) / step - slack), last = floor((high - start) / step + slack);
    return (Cells){(int)real_clamp(first, 0, cells), (int)real_clamp(last, -1, cells - 1)};
}

static int heightfield_pieces(const Shape *s, box3 box, uint32_t *piece, int capacity)
{
    const HeightfieldData *d = data_of(s);
    Cells x = cells_between(box.low.x, box.high.x, d->x0, d->dx, d->columns - 1);
    Cells z = cells_between(box.low.z, box.high.z, d->z0, d->dz, d->rows - 1);
    int count = 0;
    if (!box3_overlap(local_box(d), box))
        return 0;

    for (int j = z.first; j <= z.last; j++)
        for (int i = x.first; i <= x.last; i++)
            for (uint32_t k = 0; k < 2; k++) {
                uint32_t p = 2 * (uint32_t)(j * (d->columns - 1) + i) + k;
                vec3 c[3];
                heightfield_piece(s, p, c);
                box3 around = {vec3_min(c[0], vec3_min(c[1], c[2])), vec3_max(c[0], vec3_max(c[1], c[2]))};
                if (!box3_overlap(around, box))
                    continue;
                if (count < capacity)
                    piece[count] = p;
                count++;
            }
    return count;
}

/* Edges of piece 2c: x low, z high, diagonal; of 2c + 1: diagonal, x high, z low. */
static uint32_t heightfield_neighbour(const Shape *s, uint32_t piece, int edge)
{
    const HeightfieldData *d = data_of(s);
    int across = d->columns - 1, cell = (int)(piece / 2), i = cell % across, j = cell / across;
    if (piece % 2 == 0) {
        if (edge == 2)
            return piece + 1;
        if (edge == 0 ? i == 0 : j == d->rows - 2)
            return SHAPE_NO_PIECE;
        return 2 * (uint32_t)(edge == 0 ? cell - 1 : cell + across) + 1;
    }
    if (edge == 0)
        return piece - 1;
    if (edge == 1 ? i == across - 1 : j == 0)
        return SHAPE_NO_PIECE;
    return 2 * (uint32_t)(edge == 1 ? cell + 1 : cell - across);
}

/* ---- questions ---- */

/* Below the surface and above the ground plan, however deep. */
static bool heightfield_contains(const Shape *s, vec3 p)
{
    const HeightfieldData *d = data_of(s);
    real x = (p.x - d->x0) / d->dx, z = (p.z - d->z0) / d->dz;
    if (!(x >= 0 && x <= d->columns - 1 && z >= 0 && z <= d->rows - 1))
        return false;
    int i = int_min((int)x, d->columns - 2), j = int_min((int)z, d->rows - 2);
    real u = x - i, v = z - j;
    real h00 = height_at(d, i, j), h10 = height_at(d, i + 1, j), h01 = height_at(d, i, j + 1), h11 = height_at(d, i + 1, j + 1);
    real h = v >= u ? h00 + v * (h01 - h00) + u * (h11 - h01) : h00 + u * (h10 - h00) + v * (h11 - h10);
    return p.y <= h;
}

typedef struct GridRay { const Shape *s; const Ray *ray; TriangleRay prepared; real best; vec3 normal; } GridRay;

static void ray_cell(GridRay *g, int i, int j)
{
    for (uint32_t k = 0; k < 2; k++) {
        vec3 c[3];
        real t;
        heightfield_piece(g->s, 2 * (uint32_t)(j * (data_of(g->s)->columns - 1) + i) + k, c);
        vec3 n = vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0]));
        if (vec3_dot(n, g->ray->along) < 0 && shape_ray_triangle(&g->prepared, c, &t) && t < g->best) {
            g->best = t;
            g->normal = n;
        }
    }
}

/* Part of [t0, t1] in which low <= o + t d <= high. */
static void clip(real o, real d, real low, real high, real *t0, real *t1)
{
    if (d == 0)
        return;
    real a = (low - o) / d, b = (high - o) / d;
    *t0 = real_max(*t0, real_min(a, b));
    *t1 = real_min(*t1, real_max(a, b));
}

/* Goes from column to column (or row to row, whichever the ray crosses faster) and looks at the few cells it passes in each. */
static bool heightfield_ray(const Shape *s, const Ray *ray, RayHit *hit)
{
    const HeightfieldData *d = data_of(s);
    GridRay g = {s, ray, shape_triangle_ray(ray), INFINITY, {0, 0, 0}};
    real enter;
    if (!shape_ray_box(ray, local_box(d), ray->length, &enter) || heightfield_contains(s, ray->from))
        return false;

    vec3 o = ray->from, a = ray->along;
    bool by_x = fabs(a.x) * d->dz >= fabs(a.z) * d->dx;
    real om = by_x ? o.x : o.z, am = by_x ? a.x : a.z, start = by_x ? d->x0 : d->z0, step = by_x ? d->dx : d->dz;
    real on = by_x ? o.z : o.x, an = by_x ? a.z : a.x, start_n = by_x ? d->z0 : d->x0, step_n = by_x ? d->dz : d->dx;
    int  cells = (by_x ? d->columns : d->rows) - 1, cells_n = (by_x ? d->rows : d->columns) - 1;

    box3 box = local_box(d);
    real t0 = enter, t1 = ray->length;
    clip(om, am, start, start + cells * step, &t0, &t1);
    clip(o.y, a.y, box.low.y, box.high.y, &t0, &t1);
    real m0 = om + t0 * am, m1 = om + t1 * am;
    Cells all = cells_between(real_min(m0, m1), real_max(m0, m1), start, step, cells);
    for (int k = all.first; k <= all.last && !isfinite(g.best); k++) {
        int  i = am < 0 ? all.last - (k - all.first) : k;
        real u0 = t0, u1 = t1;
        clip(om, am, start + (i - 1e-6) * step, start + (i + 1 + 1e-6) * step, &u0, &u1);
        real n0 = on + u0 * an, n1 = on + u1 * an;
        Cells few = cells_between(real_min(n0, n1), real_max(n0, n1), start_n, step_n, cells_n);
        for (int j = few.first; j <= few.last; j++)
            ray_cell(&g, by_x ? i : j, by_x ? j : i);
    }
    return isfinite(g.best) && shape_hit(ray, g.best, vec3_unit(g.normal), hit);
}

/* ---- drawing ---- */

/* Central differences, one-sided at the rim. */
static vec3 normal_at(const HeightfieldData *d, int i, int j)
{
    int i0 = int_max(i - 1, 0), i1 = int_min(i + 1, d->columns - 1), j0 = int_max(j - 1, 0), j1 = int_min(j + 1, d->rows - 1);
    real slope_x = (height_at(d, i1, j) - height_at(d, i0, j)) / ((i1 - i0) * d->dx);
    real slope_z = (height_at(d, i, j1) - height_at(d, i, j0)) / ((j1 - j0) * d->dz);
    return vec3_unit((vec3){-slope_x, 1, -slope_z});
}

static dig_status heightfield_mesh(const Shape *s, ShapeMesh *out)
{
    const HeightfieldData *d = data_of(s);
    int cell = 0;
    DIG_TRY(shape_mesh_open(out, d->columns * d->rows, 6 * (d->columns - 1) * (d->rows - 1), true));
    for (int j = 0; j < d->rows; j++)
        for (int i = 0; i < d->columns; i++) {
            shape_mesh_vertex(out, j * d->columns + i, point_at(d, i, j));
            shape_mesh_normal(out, j * d->columns + i, normal_at(d, i, j));
        }
    for (int j = 0; j + 1 < d->rows; j++)
        for (int i = 0; i + 1 < d->columns; i++, cell++) {
            uint32_t low = (uint32_t)(j * d->columns + i), up = low + (uint32_t)d->columns;
            shape_mesh_triangle(out, 2 * cell, low, up, up + 1);
            shape_mesh_triangle(out, 2 * cell + 1, low, up + 1, low + 1);
        }
    return DIG_OK;
}

const ShapeType shape_heightfield = {
    .name     = "heightfield",
    .doc      = "Ground given by heights on a grid; always static.",
    .params   = heightfield_params,
    .def_size = sizeof(dig_heightfield_def),
    .make     = heightfield_make,
    .bounds   = heightfield_bounds,
    .area     = heightfield_area,
    .ray      = heightfield_ray,
    .contains = heightfield_contains,
    .mesh     = heightfield_mesh,
    .pieces   = heightfield_pieces,
    .piece    = heightfield_piece,
    .neighbour = heightfield_neighbour,
};
