/* render/mesh.c - builds and uploads triangle meshes. */
#include "render/mesh.h"

#include <stdlib.h>

#include "base/hash.h"
#include "math/vec.h"

typedef struct MeshDraft {      /* a mesh while it is built */
    MeshVertex *vertices;
    uint32_t   *indices;
    int         vertex_count, index_count;
} MeshDraft;

static const int level_segments[MESH_LEVELS] = {12, 20, 32, 48, 80};     /* round the equator, multiples of 4 */

int mesh_level(real radius)
{
    /* a chord of n segments sags by r (1 - cos(pi / n)) ~ 4.93 r / n^2 */
    for (int level = 0; level < MESH_LEVELS - 1; level++)
        if (4.93 * radius < 0.5 * level_segments[level] * level_segments[level])
            return level;
    return MESH_LEVELS - 1;
}

int mesh_coarser(int mesh, int levels)
{
    if (mesh < MESH_SPHERE || mesh >= MESH_BUILT_IN)
        return mesh;
    return mesh - int_min((mesh - MESH_SPHERE) % MESH_LEVELS, levels);
}

real mesh_chord(int level) { return cos(DIG_PI / level_segments[level]); }

static bool draft_open(MeshDraft *d, int vertex_count, int index_count)
{
    *d = (MeshDraft){0};
    d->vertices = calloc((size_t)vertex_count, sizeof *d->vertices);
    d->indices = calloc((size_t)index_count, sizeof *d->indices);
    return d->vertices && d->indices;
}

static void draft_close(MeshDraft *d)
{
    free(d->vertices);
    free(d->indices);
    *d = (MeshDraft){0};
}

static uint32_t put_vertex(MeshDraft *d, vec3 shape, vec3 normal, real shift)
{
    d->vertices[d->vertex_count] = (MeshVertex){{(float)shape.x, (float)shape.y, (float)shape.z},
                                                {(float)normal.x, (float)normal.y, (float)normal.z}, (float)shift};
    return (uint32_t)d->vertex_count++;
}

static void put_triangle(MeshDraft *d, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *out = d->indices + d->index_count;
    out[0] = a;
    out[1] = b;
    out[2] = c;
    d->index_count += 3;
}

/* Two triangles, corners counter-clockwise seen from outside. */
static void put_quad(MeshDraft *d, uint32_t a, uint32_t b, uint32_t c, uint32_t e)
{
    put_triangle(d, a, b, c);
    put_triangle(d, a, c, e);
}

/* ---- ready-made solids ------------------------------------------------ */

/* Eight shared corners: the shader makes the normals, with softened edges. */
static bool draft_box(MeshDraft *d)
{
    static const unsigned char faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    if (!draft_open(d, 8, 36))
        return false;
    for (int i = 0; i < 8; i++) {
        vec3 corner = {i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5};
        put_vertex(d, corner, vec3_unit(corner), 0);
    }
    for (int i = 0; i < 6; i++)
        put_quad(d, faces[i][0], faces[i][1], faces[i][2], faces[i][3]);
    return true;
}

/* From -1 to 1 in x and z, looking along +y. */
static bool draft_quad(MeshDraft *d)
{
    if (!draft_open(d, 4, 6))
        return false;
    for (int i = 0; i < 4; i++)
        put_vertex(d, (vec3){i & 1 ? 1 : -1, 0, i & 2 ? 1 : -1}, (vec3){0, 1, 0}, 0);
    put_quad(d, 0, 2, 3, 1);
    return true;
}

/* Joins ring `from` to ring `to` above it, each of `segments` vertices. */
static void put_band(MeshDraft *d, uint32_t from, uint32_t to, int segments)
{
    for (int i = 0; i < segments; i++) {
        uint32_t a = (uint32_t)i, b = (uint32_t)((i + 1) % segments);
        put_quad(d, from + a, to + a, to + b, from + b);
    }
}

static uint32_t put_ring(MeshDraft *d, int segments, real radius, real y, vec3 normal, real shift)
{
    uint32_t first = (uint32_t)d->vertex_count;
    for (int i = 0; i < segments; i++) {
        real angle = 2 * DIG_PI * i / segments, c = cos(angle), s = sin(angle);
        put_vertex(d, (vec3){radius * c, y, radius * s}, (vec3){normal.x * c, normal.y, normal.x * s}, shift);
    }
    return first;
}

static void put_cap(MeshDraft *d, uint32_t ring, uint32_t tip, int segments, bool top)
{
    for (int i = 0; i < segments; i++) {
        uint32_t a = ring + (uint32_t)i, b = ring + (uint32_t)((i + 1) % segments);
        put_triangle(d, top ? b : a, top ? a : b, tip);
    }
}

/* A ball of rings from pole to pole; with `split` the halves are pushed apart by the shift: a capsule. */
static bool draft_ball(MeshDraft *d, int segments, bool split)
{
    int half = segments / 4;                /* rings from equator to pole, the pole left out */
    int rings = split ? 2 * half : 2 * half - 1;
    if (!draft_open(d, rings * segments + 2, 6 * rings * segments))
        return false;
    uint32_t before = 0;
    for (int k = 0; k < rings; k++) {
        int step = k < half ? k + 1 : split ? k : k + 1;    /* counted from the south pole */
        real latitude = -0.5 * DIG_PI + 0.5 * DIG_PI * step / half;
        vec3 normal = {cos(latitude), sin(latitude), 0};
        uint32_t ring = put_ring(d, segments, normal.x, normal.y, normal, split ? k < half ? -0.5 : 0.5 : 0);
        if (k > 0)
            put_band(d, before, ring, segments);
        before = ring;
    }
    uint32_t south = put_vertex(d, (vec3){0, -1, 0}, (vec3){0, -1, 0}, split ? -0.5 : 0);
    uint32_t north = put_vertex(d, (vec3){0, 1, 0}, (vec3){0, 1, 0}, split ? 0.5 : 0);
    put_cap(d, 0, south, segments, false);
    put_cap(d, before, north, segments, true);
    return true;
}

/* A flat polygon, cut into triangles that are as little slender as can be: each round joins every second corner left.
 * A fan would make slivers, of which llvmpipe shades mostly pixels that they do not cover. */
static void put_disc(MeshDraft *d, uint32_t ring, int segments, bool top)
{
    for (int step = 1; 2 * step < segments; step *= 2)
        for (int i = 0; i + step < segments; i += 2 * step) {
            uint32_t a = ring + (uint32_t)i, b = a + (uint32_t)step, c = i + 2 * step < segments ? b + (uint32_t)step : ring;
            put_triangle(d, a, top ? c : b, top ? b : c);
        }
}

/* Radius 1, height 1; the shader softens the rim. */
static bool draft_cylinder(MeshDraft *d, int segments)
{
    if (!draft_open(d, 2 * segments, 12 * segments))
        return false;
    uint32_t low = put_ring(d, segments, 1, -0.5, (vec3){1, 0, 0}, 0), high = put_ring(d, segments, 1, 0.5, (vec3){1, 0, 0}, 0);
    put_band(d, low, high, segments);
    put_disc(d, low, segments, false);
    put_disc(d, high, segments, true);
    return true;
}

/* Radius 1, height 1, origin in the centre of mass. Normals (1, 1) become right for any size when divided by it. */
static bool draft_cone(MeshDraft *d, int segments)
{
    if (!draft_open(d, 3 * segments, 6 * segments))
        return false;
    uint32_t low = put_ring(d, segments, 1, -0.25, (vec3){1, 1, 0}, 0), tip = put_ring(d, segments, 0, 0.75, (vec3){1, 1, 0}, 0);
    for (int i = 0; i < segments; i++)
        put_triangle(d, low + (uint32_t)i, tip + (uint32_t)i, low + (uint32_t)((i + 1) % segments));
    uint32_t rim = put_ring(d, segments, 1, -0.25, (vec3){0, -1, 0}, 0);
    put_disc(d, rim, segments, false);
    return true;
}

/* ---- a view's own meshes ---------------------------------------------- */

uint64_t mesh_hash(const ViewMesh *m)
{
    uint64_t h = hash_u64(HASH_START, (uint64_t)m->vertex_count);
    h = hash_u64(h, (uint64_t)m->index_count + (m->normals ? 1u << 31 : 0));
    uint32_t bits;
    for (int i = 0; i < 3 * m->vertex_count; i++) {
        memcpy(&bits, m->vertices + i, sizeof bits);
        h = hash_u64(h, bits);
    }
    for (int i = 0; i < m->index_count; i++)
        h = hash_u64(h, m->indices[i]);
    return h;
}

/* Order by place, ties by index: the first of each group stands for all vertices there. */
typedef struct Corner { float p[3]; uint32_t index; } Corner;

static int compare_corners(const void *a, const void *b)
{
    const Corner *x = a, *y = b;
    for (int i = 0; i < 3; i++)
        if (x->p[i] != y->p[i])
            return x->p[i] < y->p[i] ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static int compare_edges(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* Welds equal places: weld[i] = the vertex that stands for i. */
static void weld_vertices(const ViewMesh *m, Corner *corners, uint32_t *weld)
{
    for (int i = 0; i < m->vertex_count; i++) {
        memcpy(corners[i].p, m->vertices + 3 * i, sizeof corners[i].p);
        corners[i].index = (uint32_t)i;
    }
    qsort(corners, (size_t)m->vertex_count, sizeof *corners, compare_corners);
    for (int i = 0; i < m->vertex_count; i++) {
        bool same = i > 0 && memcmp(corners[i].p, corners[i - 1].p, sizeof corners[i].p) == 0;
        weld[corners[i].index] = same ? weld[corners[i - 1].index] : corners[i].index;
    }
}

/* Whether each directed edge meets its reverse. Open on any doubt (and without memory). */
static bool is_closed(const ViewMesh *m)
{
    size_t edge_count = (size_t)m->index_count;
    Corner *corners = malloc((size_t)m->vertex_count * sizeof *corners);
    uint32_t *weld = malloc((size_t)m->vertex_count * sizeof *weld);
    uint64_t *edges = malloc(2 * edge_count * sizeof *edges);
    bool closed = corners && weld && edges;
    if (closed) {
        weld_vertices(m, corners, weld);
        uint64_t *twins = edges + edge_count;
        for (size_t i = 0; i < edge_count; i++) {
            uint64_t a = weld[m->indices[i]], b = weld[m->indices[i % 3 == 2 ? i - 2 : i + 1]];
            edges[i] = a << 32 | b;
            twins[i] = b << 32 | a;
        }
        qsort(edges, edge_count, sizeof *edges, compare_edges);
        qsort(twins, edge_count, sizeof *twins, compare_edges);
        closed = memcmp(edges, twins, edge_count * sizeof *edges) == 0;
    }
    free(corners);
    free(weld);
    free(edges);
    return closed;
}

static bool indices_sound(const ViewMesh *m)
{
    for (int i = 0; i < m->index_count; i++)
        if (m->indices[i] >= (uint32_t)m->vertex_count)
            return false;
    return m->vertex_count > 0 && m->index_count >= 3 && m->index_count % 3 == 0;
}

static vec3 vertex_at(const float *v, uint32_t i) { return (vec3){(real)v[3 * i], (real)v[3 * i + 1], (real)v[3 * i + 2]}; }

/* With normals the vertices stay shared; without, each triangle gets three of its own. */
static bool draft_view(MeshDraft *d, const ViewMesh *m)
{
    if (!draft_open(d, m->normals ? m->vertex_count : m->index_count, m->index_count))
        return false;
    for (int i = 0; m->normals && i < m->vertex_count; i++)
        put_vertex(d, vertex_at(m->vertices, (uint32_t)i), vertex_at(m->normals, (uint32_t)i), 0);
    for (int i = 0; i + 2 < m->index_count; i += 3) {
        const uint32_t *k = m->indices + i;
        if (m->normals) {
            put_triangle(d, k[0], k[1], k[2]);
            continue;
        }
        vec3 a = vertex_at(m->vertices, k[0]), b = vertex_at(m->vertices, k[1]), c = vertex_at(m->vertices, k[2]);
        vec3 n = vec3_unit(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
        uint32_t first = put_vertex(d, a, n, 0);
        put_vertex(d, b, n, 0);
        put_vertex(d, c, n, 0);
        put_triangle(d, first, first + 1, first + 2);
    }
    return true;
}

/* ---- buffers ---------------------------------------------------------- */

static void upload(GpuMesh *mesh, const Gl *gl, MeshDraft *d)
{
    gl->GenVertexArrays(1, &mesh->array);
    gl->GenBuffers(1, &mesh->vertices);
    gl->GenBuffers(1, &mesh->indices);
    gl->BindVertexArray(mesh->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, mesh->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, d->vertex_count * (GLsizeiptr)sizeof(MeshVertex), d->vertices, GL_STATIC_DRAW);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh->indices);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, d->index_count * (GLsizeiptr)sizeof(uint32_t), d->indices, GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(MeshVertex), (const void *)offsetof(MeshVertex, shape));
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(MeshVertex), (const void *)offsetof(MeshVertex, normal));
    mesh->index_count = d->index_count;
    mesh->vertex_count = d->vertex_count;
    mesh->corners = d->vertices;
    mesh->list = d->indices;
    *d = (MeshDraft){0};        /* the mesh owns the arrays now */
}

static void release(GpuMesh *mesh, const Gl *gl)
{
    if (mesh->index_count > 0) {
        gl->DeleteVertexArrays(1, &mesh->array);
        gl->DeleteBuffers(1, &mesh->vertices);
        gl->DeleteBuffers(1, &mesh->indices);
    }
    free(mesh->corners);
    free(mesh->list);
    *mesh = (GpuMesh){0};
}

static bool keep(Meshes *meshes, const Gl *gl, int entry, MeshDraft *d, bool drafted)
{
    if (drafted) {
        upload(&meshes->entry[entry], gl, d);
        meshes->entry[entry].closed = true;
    }
    draft_close(d);
    return drafted;
}

dig_status meshes_open(Meshes *meshes, const Gl *gl)
{
    MeshDraft d = {0};
    bool ok = keep(meshes, gl, MESH_BOX, &d, draft_box(&d));
    ok = ok && keep(meshes, gl, MESH_QUAD, &d, draft_quad(&d));
    ok = ok && keep(meshes, gl, MESH_PATCH, &d, draft_quad(&d));
    for (int level = 0; ok && level < MESH_LEVELS; level++) {
        int n = level_segments[level];
        ok = keep(meshes, gl, MESH_SPHERE + level, &d, draft_ball(&d, n, false));
        ok = ok && keep(meshes, gl, MESH_CAPSULE + level, &d, draft_ball(&d, n, true));
        ok = ok && keep(meshes, gl, MESH_CYLINDER + level, &d, draft_cylinder(&d, n));
        ok = ok && keep(meshes, gl, MESH_CONE + level, &d, draft_cone(&d, n));
    }
    return ok ? DIG_OK : DIG_E_MEMORY;
}

void meshes_close(Meshes *meshes, const Gl *gl)
{
    for (int i = 0; i < MESH_CAPACITY; i++)
        release(&meshes->entry[i], gl);
}

void meshes_patch(Meshes *meshes, const Gl *gl, float corners[4][2])
{
    GpuMesh *patch = &meshes->entry[MESH_PATCH];
    for (int i = 0; i < 4; i++) {
        patch->corners[i].shape[0] = corners[i][0];
        patch->corners[i].shape[2] = corners[i][1];
    }
    gl->BindBuffer(GL_ARRAY_BUFFER, patch->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, 4 * (GLsizeiptr)sizeof(MeshVertex), patch->corners, GL_DYNAMIC_DRAW);
}

int meshes_find(Meshes *meshes, const Gl *gl, const ViewMesh *m, uint64_t key, uint64_t draw)
{
    int oldest = -1;
    for (unsigned probe = 0; probe < MESH_PROBES; probe++) {
        int i = MESH_BUILT_IN + (int)((key + probe) % (MESH_CAPACITY - MESH_BUILT_IN));
        GpuMesh *mesh = &meshes->entry[i];
        if (mesh->index_count > 0 && mesh->key == key) {
            mesh->used = draw;
            return i;
        }
        if (mesh->used < draw && (oldest < 0 || mesh->used < meshes->entry[oldest].used))
            oldest = i;
    }
    MeshDraft d = {0};
    if (oldest < 0 || !m->vertices || !m->indices || !indices_sound(m))
        return -1;
    bool drafted = draft_view(&d, m);
    if (drafted) {
        release(&meshes->entry[oldest], gl);
        upload(&meshes->entry[oldest], gl, &d);
        meshes->entry[oldest].key = key;
        meshes->entry[oldest].used = draw;
        meshes->entry[oldest].closed = is_closed(m);
    }
    draft_close(&d);
    return drafted ? oldest : -1;
}
