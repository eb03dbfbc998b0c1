/* render/cast.c - triangles into depth maps. */
#include "render/cast.h"

#include <stdlib.h>

#include "render/wide.h"

/* ---- gathering --------------------------------------------------------- */

static bool fit(void **data, int *capacity, int wanted, size_t each)
{
    if (wanted <= *capacity)
        return true;
    int roomy = wanted + wanted / 2;
    void *larger = realloc(*data, (size_t)roomy * each);
    if (!larger)
        return false;
    *data = larger;
    *capacity = roomy;
    return true;
}

static bool reserve(Casters *c, int places, int corners, int groups)
{
    void *data[4] = {c->places, c->seen, c->corners, c->groups};
    int capacity = c->place_capacity;
    bool ok = fit(&data[0], &c->place_capacity, places, 3 * sizeof(float)) && fit(&data[1], &capacity, places, 3 * sizeof(float)) &&
              fit(&data[2], &c->corner_capacity, corners, sizeof(uint32_t)) && fit(&data[3], &c->group_capacity, groups, sizeof(CastGroup));
    c->places = data[0];
    c->seen = data[1];
    c->corners = data[2];
    c->groups = data[3];
    if (!ok)
        c->place_capacity = int_min(c->place_capacity, capacity);
    return ok;
}

/* v turned by the quaternion q */
static void turn(const float q[4], const float v[3], float out[3])
{
    float t[3] = {2 * (q[1] * v[2] - q[2] * v[1]), 2 * (q[2] * v[0] - q[0] * v[2]), 2 * (q[0] * v[1] - q[1] * v[0])};
    out[0] = v[0] + q[3] * t[0] + q[1] * t[2] - q[2] * t[1];
    out[1] = v[1] + q[3] * t[1] + q[2] * t[0] - q[0] * t[2];
    out[2] = v[2] + q[3] * t[2] + q[0] * t[1] - q[1] * t[0];
}

static void put_caster(Casters *c, const DrawItem *d, const GpuMesh *mesh)
{
    const Instance *k = &d->instance;
    uint32_t first = (uint32_t)c->place_count;
    for (int i = 0; i < mesh->vertex_count; i++) {
        const MeshVertex *v = &mesh->corners[i];
        float own[3] = {v->shape[0] * k->size[0], v->shape[1] * k->size[1] + v->shift * k->size[3], v->shape[2] * k->size[2]};
        float *to = c->places + 3 * (size_t)c->place_count++;
        turn(k->turn, own, to);
        for (int axis = 0; axis < 3; axis++)
            to[axis] += k->place[axis];
    }
    c->groups[c->group_count++] = (CastGroup){c->corner_count, mesh->index_count, d->closed};
    for (int i = 0; i < mesh->index_count; i++)
        c->corners[c->corner_count++] = first + mesh->list[i];
}

static dig_status add_caster(Casters *c, const DrawItem *d, const GpuMesh *mesh)
{
    if (!reserve(c, c->place_count + mesh->vertex_count, c->corner_count + mesh->index_count, c->group_count + 1))
        return DIG_E_MEMORY;
    put_caster(c, d, mesh);
    return DIG_OK;
}

dig_status cast_gather(Casters *c, const Batches *b, const Meshes *meshes, int coarser)
{
    c->place_count = c->corner_count = c->group_count = 0;
    for (int i = 0; i < b->count; i++)
        if (b->items[i].caster)
            DIG_TRY(add_caster(c, &b->items[i], &meshes->entry[mesh_coarser(b->items[i].mesh, coarser)]));
    return DIG_OK;
}

dig_status cast_gather_one(Casters *c, const DrawItem *d, const Meshes *meshes)
{
    c->place_count = c->corner_count = c->group_count = 0;
    return add_caster(c, d, &meshes->entry[d->mesh]);
}

void cast_close(Casters *c)
{
    free(c->places);
    free(c->seen);
    free(c->corners);
    free(c->groups);
    *c = (Casters){0};
}

/* ---- drawing ----------------------------------------------------------- */

/* A triangle in texels: z = depth at texel (0, 0), then per texel across and per row. */
typedef struct Facet { const float *corner[3]; float z, dx, dy; int first, last; } Facet;

/* x rounded up, 0 to size; without ceilf, which older processors have no instruction for */
LANE_CODE int clamp_texel(float x, int size)
{
    float inside = least(most(x, 0), (float)size);
    int i = (int)inside;
    return i + ((float)i < inside);
}

static int order_corners(const float *a, const float *b) { return a[1] < b[1] || (a[1] == b[1] && a[0] <= b[0]); }

/* The plane of a triangle and its rows, lowest corner first; the sign of its area, 0 = nothing to draw. */
static int set_up(Facet *f, const float *a, const float *b, const float *c, int size)
{
    float x1 = b[0] - a[0], y1 = b[1] - a[1], x2 = c[0] - a[0], y2 = c[1] - a[1], area = x1 * y2 - x2 * y1;
    if (!(area > 1e-9f || area < -1e-9f))
        return 0;
    float z1 = b[2] - a[2], z2 = c[2] - a[2];
    f->dx = (z1 * y2 - z2 * y1) / area;
    f->dy = (z2 * x1 - z1 * x2) / area;
    f->z = a[2] + f->dx * (0.5f - a[0]) + f->dy * (0.5f - a[1]);
    const float *low = a, *middle = b, *high = c, *other;
    if (!order_corners(low, middle))
        other = low, low = middle, middle = other;
    if (!order_corners(middle, high))
        other = middle, middle = high, high = other;
    if (!order_corners(low, middle))
        other = low, low = middle, middle = other;
    f->corner[0] = low;
    f->corner[1] = middle;
    f->corner[2] = high;
    f->first = clamp_texel(low[1] - 0.5f, size);
    f->last = clamp_texel(high[1] - 0.5f, size);
    return area > 0 ? 1 : -1;
}

/* The edge from a (the lower end) to b: where it crosses height y is x + run ((y - y0) / rise); a level one counts at its end a. */
typedef struct Edge { float x, y0, run, rise; } Edge;

static Edge edge_of(const float *a, const float *b)
{
    float rise = b[1] - a[1];
    return rise > 0 ? (Edge){a[0], a[1], b[0] - a[0], rise} : (Edge){a[0], a[1], 0, 1};
}

enum { WINDOW = 8 };        /* taken together: rows of a facet, texels of a row */

/* Of WINDOW rows from j on the texels [first, last) whose middles lie inside. */
LANE_CODE void find_spans(const Edge *across, const Edge *low, const Edge *high, int j, int size, int *first, int *last)
{
    const float bend = high->y0;
    float one[WINDOW], under[WINDOW], over[WINDOW], other[WINDOW];
    for (int i = 0; i < WINDOW; i++) {
        float y = (float)(j + i) + 0.5f;
        one[i] = across->x + across->run * ((y - across->y0) / across->rise);
        under[i] = low->x + low->run * ((y - low->y0) / low->rise);
        over[i] = high->x + high->run * ((y - high->y0) / high->rise);
    }
    for (int i = 0; i < WINDOW; i++)
        other[i] = (float)(j + i) + 0.5f < bend ? under[i] : over[i];
    for (int i = 0; i < WINDOW; i++) {
        first[i] = clamp_texel(least(one[i], other[i]) - 0.5f, size);
        last[i] = clamp_texel(most(one[i], other[i]) - 0.5f, size);
    }
}

/* row[i] = min(row[i], max(z + (i - first) dx, 0)) for first <= i < last; the far end needs no limit, as nothing there is 1.
 * Whole windows are looked at, so that short spans are not worked on texel by texel. */
LANE_CODE void lower_span(float *row, int size, int first, int last, float z, float dx)
{
    for (int w = first; w < last; w += WINDOW) {
        const int start = int_min(w, size - WINDOW), skip = first - start, count = last - start;
        float *to = row + start, depth[WINDOW];
        for (int k = 0; k < WINDOW; k++)
            depth[k] = most(z + dx * (float)(k - skip), 0);
        for (int k = 0; k < WINDOW; k++)
            depth[k] = ((k >= skip) & (k < count)) ? depth[k] : 1;
        for (int k = 0; k < WINDOW; k++)
            to[k] = least(depth[k], to[k]);
    }
}

LANE_CODE void lower_facet(const Facet *f, float z, float dx, float dy, int size, float *out)
{
    const Edge across = edge_of(f->corner[0], f->corner[2]), low = edge_of(f->corner[0], f->corner[1]);
    const Edge high = edge_of(f->corner[1], f->corner[2]);
    int first[WINDOW], last[WINDOW];
    for (int j = f->first; j < f->last; j += WINDOW) {
        find_spans(&across, &low, &high, j, size, first, last);
        for (int i = 0; i < int_min(WINDOW, f->last - j); i++)
            lower_span(out + (size_t)(j + i) * (size_t)size, size, first[i], last[i], z + dy * (float)(j + i) + dx * (float)first[i], dx);
    }
}

/* Takes all places into texels and depths. */
static void see(Casters *c, const float m[16], int size)
{
    float half = 0.5f * (float)size;
    for (int i = 0; i < c->place_count; i++) {
        const float *p = c->places + 3 * (size_t)i;
        float *s = c->seen + 3 * (size_t)i;
        s[0] = half + half * (m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]);
        s[1] = half + half * (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]);
        s[2] = 0.5f + 0.5f * (m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14]);
    }
}

void cast_clear(float *out, int size)
{
    for (int i = 0; i < size * size; i++)
        out[i] = 1;
}

static int set_up_corner(const Casters *c, int corner, int size, Facet *f)
{
    const uint32_t *k = c->corners + corner;
    return set_up(f, c->seen + 3 * (size_t)k[0], c->seen + 3 * (size_t)k[1], c->seen + 3 * (size_t)k[2], size);
}

LANE_CODE void draw_nearest(const Casters *c, int size, float slope, float *out)
{
    for (int g = 0; g < c->group_count; g++) {
        const CastGroup *group = &c->groups[g];
        for (int i = group->first; i < group->first + group->count; i += 3) {
            Facet f;
            int side = set_up_corner(c, i, size, &f);
            if (side == 0 || (side < 0 && group->closed))
                continue;
            float steep = fabsf(f.dx) > fabsf(f.dy) ? fabsf(f.dx) : fabsf(f.dy);
            lower_facet(&f, f.z + slope * steep, f.dx, f.dy, size, out);
        }
    }
}

LANE_CODE void draw_heights(const Casters *c, int size, float *above, float *below)
{
    for (int g = 0; g < c->group_count; g++) {
        const CastGroup *group = &c->groups[g];
        for (int i = group->first; i < group->first + group->count; i += 3) {
            Facet f;
            int side = set_up_corner(c, i, size, &f);
            if (side > 0 || (side < 0 && !group->closed))
                lower_facet(&f, f.z, f.dx, f.dy, size, above);
            if (side < 0 || (side > 0 && !group->closed))
                lower_facet(&f, 1 - f.z, -f.dx, -f.dy, size, below);
        }
    }
}

static void nearest_plainly(const Casters *c, int size, float slope, float *out) { draw_nearest(c, size, slope, out); }
WIDE static void nearest_widely(const Casters *c, int size, float slope, float *out) { draw_nearest(c, size, slope, out); }
static void heights_plainly(const Casters *c, int size, float *above, float *below) { draw_heights(c, size, above, below); }
WIDE static void heights_widely(const Casters *c, int size, float *above, float *below) { draw_heights(c, size, above, below); }

void cast_nearest(Casters *c, const float to_map[16], int size, float slope, float *out)
{
    DIG_ASSERT(size >= WINDOW);
    see(c, to_map, size);
    (has_wide() ? nearest_widely : nearest_plainly)(c, size, slope, out);
}

void cast_heights(Casters *c, const float to_map[16], int size, float *above, float *below)
{
    DIG_ASSERT(size >= WINDOW);
    see(c, to_map, size);
    cast_clear(above, size);
    cast_clear(below, size);
    (has_wide() ? heights_widely : heights_plainly)(c, size, above, below);
}
