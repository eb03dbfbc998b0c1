/* geom/mesh_build.c - a triangle mesh from lists: equal vertices joined, useless triangles dropped, which triangles meet at
 * which edge, whether the surface is closed, and a tree of boxes over it all. */
#include <stdlib.h>

#include "geom/mass.h"
#include "geom/mesh_build.h"

typedef struct Corner { vec3 p; uint32_t i; } Corner;           /* a vertex, to be sorted by place */
typedef struct Side { uint32_t lo, hi, half; } Side;            /* an edge of a triangle: half = 3 * triangle + k */

typedef struct MeshWork {
    const dig_mesh_def *def;
    int       count;            /* triangles that are left                         */
    uint32_t *triangles;        /* [3 * count]                                     */
    uint32_t *same;             /* [vertices] the first vertex at the same place   */
    Corner   *corners;          /* [vertices]                                      */
    Side     *sides;            /* [3 * count]                                     */
    uint32_t *neighbours;       /* [3 * count]                                     */
    uint32_t *order;            /* [count] triangles in the order of the tree      */
    MeshNode *nodes;            /* [2 * count]                                     */
    int       node_count;
    bool      closed;
    MassProps mass;
} MeshWork;

static dig_status check_lists(const dig_mesh_def *def, char *why, size_t capacity)
{
    int vertices = def->vertices.count, indices = def->triangles.count;
    if (vertices > MESH_TRIANGLES)
        return shape_fail(DIG_E_FULL, why, capacity, "mesh has %d vertices, must be at most %d", vertices, MESH_TRIANGLES);
    if (indices % 3 != 0)
        return shape_fail(DIG_E_ARG, why, capacity, "mesh has %d indices, must be a multiple of 3", indices);
    if (indices < 3 || !def->triangles.v)
        return shape_fail(DIG_E_ARG, why, capacity, "mesh has 0 triangles, must be 1 to %d", MESH_TRIANGLES);
    if (indices / 3 > MESH_TRIANGLES)
        return shape_fail(DIG_E_FULL, why, capacity, "mesh has %d triangles, must be 1 to %d", indices / 3, MESH_TRIANGLES);
    for (int i = 0; i < indices; i++)
        if (def->triangles.v[i] < 1 || def->triangles.v[i] > vertices)
            return shape_fail(DIG_E_ARG, why, capacity, "mesh triangle %d has index %lld, must be 1 to %d", i / 3 + 1,
                              (long long)def->triangles.v[i], vertices);
    return DIG_OK;
}

static dig_status open_work(MeshWork *w)
{
    size_t vertices = (size_t)w->def->vertices.count, count = (size_t)w->def->triangles.count / 3;
    w->triangles  = malloc(3 * count * sizeof *w->triangles);
    w->same       = malloc(vertices * sizeof *w->same);
    w->corners    = malloc(vertices * sizeof *w->corners);
    w->sides      = malloc(3 * count * sizeof *w->sides);
    w->neighbours = malloc(3 * count * sizeof *w->neighbours);
    w->order      = malloc(count * sizeof *w->order);
    w->nodes      = calloc(2 * count, sizeof *w->nodes);       /* no byte of the shape is left to chance */
    bool all = w->triangles && w->same && w->corners && w->sides && w->neighbours && w->order && w->nodes;
    return all ? DIG_OK : DIG_E_MEMORY;
}

static void close_work(MeshWork *w)
{
    free(w->triangles);
    free(w->same);
    free(w->corners);
    free(w->sides);
    free(w->neighbours);
    free(w->order);
    free(w->nodes);
}

/* ---- vertices and triangles ---- */

static int compare_corners(const void *a, const void *b)
{
    const Corner *p = a, *q = b;
    for (int k = 0; k < 3; k++) {
        real x = vec3_at(p->p, k), y = vec3_at(q->p, k);
        if (x != y)
            return x < y ? -1 : 1;
    }
    return p->i < q->i ? -1 : 1;
}

/* Files often give every triangle vertices of its own: join those at the same place, or no two triangles would be neighbours. */
static void join_vertices(MeshWork *w)
{
    int count = w->def->vertices.count;
    for (int i = 0; i < count; i++)
        w->corners[i] = (Corner){w->def->vertices.v[i], (uint32_t)i};
    qsort(w->corners, (size_t)count, sizeof *w->corners, compare_corners);
    for (int i = 0; i < count; i++) {
        bool again = i > 0 && vec3_equal(w->corners[i].p, w->corners[i - 1].p);
        w->same[w->corners[i].i] = again ? w->same[w->corners[i - 1].i] : w->corners[i].i;
    }
}

/* Triangles between three different places. */
static void collect_triangles(MeshWork *w)
{
    w->count = 0;
    for (int i = 0; i + 2 < w->def->triangles.count; i += 3) {
        const int64_t *t = w->def->triangles.v + i;
        uint32_t a = w->same[t[0] - 1], b = w->same[t[1] - 1], c = w->same[t[2] - 1];
        if (a == b || b == c || c == a)
            continue;
        uint32_t *to = w->triangles + 3 * (size_t)w->count++;
        to[0] = a;
        to[1] = b;
        to[2] = c;
    }
}

/* Height over the longest edge below 1e-12 of that edge: there is no normal to speak of. */
static bool has_area(const vec3 *v, const uint32_t *t)
{
    vec3 ab = vec3_sub(v[t[1]], v[t[0]]), bc = vec3_sub(v[t[2]], v[t[1]]), ca = vec3_sub(v[t[0]], v[t[2]]);
    real longest = vec3_largest((vec3){vec3_length2(ab), vec3_length2(bc), vec3_length2(ca)});
    return vec3_length(vec3_cross(ab, bc)) > 1e-12 * longest;
}

static void drop_slivers(MeshWork *w)
{
    int kept = 0;
    for (int i = 0; i < w->count; i++) {
        const uint32_t *t = w->triangles + 3 * (size_t)i;
        if (has_area(w->def->vertices.v, t)) {
            memmove(w->triangles + 3 * (size_t)kept, t, 3 * sizeof *t);
            kept++;
        }
    }
    w->count = kept;
}

/* ---- edges ---- */

static int compare_sides(const void *a, const void *b)
{
    const Side *p = a, *q = b;
    if (p->lo != q->lo)
        return p->lo < q->lo ? -1 : 1;
    if (p->hi != q->hi)
        return p->hi < q->hi ? -1 : 1;
    return p->half < q->half ? -1 : p->half > q->half;
}

/* Finds the neighbours (where exactly two triangles meet, one each way) and returns whether every edge runs as often one way
 * as the other. */
static bool match_sides(MeshWork *w)
{
    uint32_t halves = 3 * (uint32_t)w->count;
    bool balanced = true;

    for (uint32_t h = 0; h < halves; h++) {
        uint32_t a = w->triangles[h], b = w->triangles[h % 3 == 2 ? h - 2 : h + 1];
        w->sides[h] = (Side){a < b ? a : b, a < b ? b : a, h};
        w->neighbours[h] = SHAPE_NO_PIECE;
    }
    qsort(w->sides, halves, sizeof *w->sides, compare_sides);
    for (uint32_t i = 0, end; i < halves; i = end) {
        int forward = 0, backward = 0;
        for (end = i; end < halves && w->sides[end].lo == w->sides[i].lo && w->sides[end].hi == w->sides[i].hi; end++) {
            bool up = w->triangles[w->sides[end].half] == w->sides[end].lo;
            forward += up;
            backward += !up;
        }
        balanced = balanced && forward == backward;
        if (forward == 1 && backward == 1) {
            w->neighbours[w->sides[i].half]     = w->sides[i + 1].half / 3;
            w->neighbours[w->sides[i + 1].half] = w->sides[i].half / 3;
        }
    }
    return balanced;
}

/* Is there an inside? A closed surface that is turned inside out is turned round. */
static void find_inside(MeshWork *w)
{
    if (w->count == 0 || !match_sides(w))
        return;
    const vec3 *v = w->def->vertices.v;
    mass_of_triangles(v, w->triangles, w->count, &w->mass);
    if (w->mass.volume < 0) {
        for (int i = 0; i < w->count; i++) {
            uint32_t *t = w->triangles + 3 * (size_t)i, swap = t[1];
            t[1] = t[2];
            t[2] = swap;
        }
        mass_of_triangles(v, w->triangles, w->count, &w->mass);
    }
    vec3 low = v[w->triangles[0]], high = low;
    for (int i = 0; i < 3 * w->count; i++) {
        low  = vec3_min(low, v[w->triangles[i]]);
        high = vec3_max(high, v[w->triangles[i]]);
    }
    real size = vec3_largest(vec3_sub(high, low));
    w->closed = w->mass.volume > 1e-12 * size * size * size;    /* a sheet with two sides encloses nothing */
    if (!w->closed)
        w->mass = (MassProps){.inertia = mat3_zero()};
}

/* ---- the tree of boxes ---- */

static box3 triangle_box(const MeshWork *w, uint32_t triangle)
{
    const vec3 *v = w->def->vertices.v;
    const uint32_t *t = w->triangles + 3 * (size_t)triangle;
    return (box3){vec3_min(v[t[0]], vec3_min(v[t[1]], v[t[2]])), vec3_max(v[t[0]], vec3_max(v[t[1]], v[t[2]]))};
}

static real triangle_middle(const MeshWork *w, uint32_t triangle, int axis)
{
    box3 b = triangle_box(w, triangle);
    return 0.5 * (vec3_at(b.low, axis) + vec3_at(b.high, axis));
}

/* Moves the triangles whose middle lies below the cut to the front, keeping the order otherwise as it falls out; returns
 * their number. Halves the list when that would leave one side empty. */
static int split(MeshWork *w, int first, int count)
{
    vec3 low = {INFINITY, INFINITY, INFINITY}, high = vec3_neg(low);
    for (int i = first; i < first + count; i++) {
        vec3 m = {triangle_middle(w, w->order[i], 0), triangle_middle(w, w->order[i], 1), triangle_middle(w, w->order[i], 2)};
        low  = vec3_min(low, m);
        high = vec3_max(high, m);
    }
    vec3 extent = vec3_sub(high, low);
    int  axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2, below = 0;
    real cut = 0.5 * (vec3_at(low, axis) + vec3_at(high, axis));

    for (int i = first; i < first + count; i++)
        if (triangle_middle(w, w->order[i], axis) < cut) {
            uint32_t swap = w->order[first + below];
            w->order[first + below++] = w->order[i];
            w->order[i] = swap;
        }
    return below == 0 || below == count ? count / 2 : below;
}

static void grow_tree(MeshWork *w, int first, int count)
{
    MeshNode *node = &w->nodes[w->node_count++];
    node->box = triangle_box(w, w->order[first]);
    for (int i = first + 1; i < first + count; i++)
        node->box = box3_union(node->box, triangle_box(w, w->order[i]));
    node->first = (uint32_t)first;
    node->count = count <= MESH_LEAF ? (uint32_t)count : 0;
    if (count > MESH_LEAF) {
        int below = split(w, first, count);
        grow_tree(w, first, below);
        grow_tree(w, first + below, count - below);
    }
    node->next = (uint32_t)w->node_count;
}

static void sort_by_tree(MeshWork *w)
{
    for (int i = 0; i < w->count; i++)
        w->order[i] = (uint32_t)i;
    w->node_count = 0;
    grow_tree(w, 0, w->count);

    uint32_t *old = w->neighbours;              /* not in use yet */
    memcpy(old, w->triangles, 3 * (size_t)w->count * sizeof *old);
    for (int i = 0; i < w->count; i++)
        memcpy(w->triangles + 3 * (size_t)i, old + 3 * (size_t)w->order[i], 3 * sizeof *old);
}

/* ---- all of it ---- */

static dig_status store(const MeshWork *w, Shape *s)
{
    size_t vertices = (size_t)w->def->vertices.count, nodes = (size_t)w->node_count, count = (size_t)w->count;
    MeshData *d = shape_alloc(s, sizeof *d + nodes * sizeof(MeshNode) + vertices * sizeof(vec3) + 6 * count * sizeof(uint32_t));
    if (!d)
        return DIG_E_MEMORY;
    d->vertex_count   = w->def->vertices.count;
    d->triangle_count = w->count;
    d->node_count     = w->node_count;
    d->closed         = w->closed;
    d->mass           = w->mass;

    /* the arrays follow the header: the only place that writes through their accessors */
    MeshNode *to_nodes = (MeshNode *)(void *)(d + 1);
    vec3 *to_vertices  = (vec3 *)(void *)(to_nodes + nodes);
    uint32_t *to_triangles = (uint32_t *)(void *)(to_vertices + vertices);
    memcpy(to_nodes, w->nodes, nodes * sizeof *to_nodes);
    memcpy(to_vertices, w->def->vertices.v, vertices * sizeof *to_vertices);
    memcpy(to_triangles, w->triangles, 3 * count * sizeof *to_triangles);
    memcpy(to_triangles + 3 * count, w->neighbours, 3 * count * sizeof *to_triangles);

    for (size_t i = 0; i < 3 * count; i++)
        s->outer = real_max(s->outer, vec3_length(to_vertices[to_triangles[i]]));
    return DIG_OK;
}

dig_status mesh_build(const dig_mesh_def *def, Shape *s, char *why, size_t capacity)
{
    MeshWork w = {.def = def};
    DIG_TRY(check_lists(def, why, capacity));
    dig_status status = open_work(&w);
    if (status == DIG_OK) {
        join_vertices(&w);
        collect_triangles(&w);
        find_inside(&w);                        /* before slivers go: they may close the surface between two long edges */
        drop_slivers(&w);
        if (w.count == 0) {
            status = shape_fail(DIG_E_ARG, why, capacity, "mesh has no triangle with an area (of %d given)", def->triangles.count / 3);
        } else {
            sort_by_tree(&w);
            (void)match_sides(&w);              /* the triangles have new numbers */
            status = store(&w, s);
        }
    }
    close_work(&w);
    return status;
}
