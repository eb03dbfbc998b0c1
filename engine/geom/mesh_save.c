/* geom/mesh_save.c - a triangle mesh as bytes: vertices, triangles in the order of the inner tree, and the tree itself. */
#include "geom/mesh_build.h"
#include "geom/save.h"

enum { NODE_BYTES = 60, VERTEX_BYTES = 24, TRIANGLE_BYTES = 24 };

/* The arrays of the data as they are being read. */
typedef struct Lists { MeshNode *nodes; vec3 *vertices; uint32_t *triangles, *neighbours; } Lists;

static Lists lists_of(const MeshData *d)
{
    Lists l;
    l.nodes = (MeshNode *)(uintptr_t)mesh_nodes(d);
    l.vertices = (vec3 *)(uintptr_t)mesh_vertices(d);
    l.triangles = (uint32_t *)(uintptr_t)mesh_triangles(d);
    l.neighbours = (uint32_t *)(uintptr_t)mesh_neighbours(d);
    return l;
}

static void pack_mass(Pack *p, MassProps *m)
{
    const real most = SHAPE_LENGTH_MAX;
    pack_real_in(p, &m->volume, 1e-300, 8 * most * most * most, "volume of a mesh");
    pack_vec3(p, &m->centre, most, "centre of a mesh");
    pack_vec3(p, &m->inertia.r0, 1e30, "inertia of a mesh");
    pack_vec3(p, &m->inertia.r1, 1e30, "inertia of a mesh");
    pack_vec3(p, &m->inertia.r2, 1e30, "inertia of a mesh");
}

static void pack_lists(Pack *p, const MeshData *d, const Lists *l)
{
    for (int i = 0; i < d->node_count; i++) {
        MeshNode *n = &l->nodes[i];
        pack_vec3(p, &n->box.low, SHAPE_LENGTH_MAX, "box in a mesh");
        pack_vec3(p, &n->box.high, SHAPE_LENGTH_MAX, "box in a mesh");
        pack_index(p, &n->first, (uint32_t)d->triangle_count, false, "triangle of a box in a mesh");
        pack_index(p, &n->count, MESH_LEAF + 1, false, "number of triangles in a box of a mesh");
        pack_index(p, &n->next, (uint32_t)d->node_count + 1, false, "box in a mesh");
    }
    for (int i = 0; i < d->vertex_count; i++)
        pack_vec3(p, &l->vertices[i], SHAPE_LENGTH_MAX, "vertex of a mesh");
    for (int i = 0; i < 3 * d->triangle_count; i++)
        pack_index(p, &l->triangles[i], (uint32_t)d->vertex_count, false, "vertex of a triangle");
    for (int i = 0; i < 3 * d->triangle_count; i++)
        pack_index(p, &l->neighbours[i], (uint32_t)d->triangle_count, true, "neighbour of a triangle");
}

/* ---- what is read ---- */

static bool triangle_fits(const Lists *l, uint32_t t, box3 box)
{
    vec3 c[3];
    for (int k = 0; k < 3; k++)
        c[k] = l->vertices[l->triangles[3 * (size_t)t + (size_t)k]];
    vec3 area = vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0]));
    box3 around = {vec3_min(c[0], vec3_min(c[1], c[2])), vec3_max(c[0], vec3_max(c[1], c[2]))};
    return vec3_length(area) > 0 && box3_inside(box, around);
}

/* Depth first: a leaf is followed by its successor, a branch by two subtrees that end where it does. By induction from the last
 * node on, every `next` leaves the subtree, and the leaves hold all triangles in order. */
static bool tree_is_sound(const MeshData *d, const Lists *l)
{
    uint32_t triangle = 0;
    for (int i = 0; i < d->node_count; i++) {
        const MeshNode *n = &l->nodes[i];
        if (n->first != triangle)
            return false;
        if (n->count == 0) {
            uint32_t left = (uint32_t)i + 1, right = left < (uint32_t)d->node_count ? l->nodes[left].next : (uint32_t)d->node_count;
            if (right <= left || right >= (uint32_t)d->node_count || l->nodes[right].next != n->next ||
                !box3_inside(n->box, l->nodes[left].box) || !box3_inside(n->box, l->nodes[right].box))
                return false;
            continue;
        }
        if (n->next != (uint32_t)i + 1 || n->count > (uint32_t)d->triangle_count - triangle)
            return false;
        for (uint32_t end = triangle + n->count; triangle < end; triangle++)
            if (!triangle_fits(l, triangle, n->box))
                return false;
    }
    return triangle == (uint32_t)d->triangle_count && l->nodes[0].next == (uint32_t)d->node_count;
}

/* Across corner k -> k + 1 of t lies the triangle that runs the other way there, and across that one lies t. */
static bool neighbours_match(const MeshData *d, const Lists *l)
{
    for (uint32_t t = 0; t < (uint32_t)d->triangle_count; t++)
        for (uint32_t k = 0; k < 3; k++) {
            const uint32_t *mine = l->triangles + 3 * (size_t)t;
            uint32_t other = l->neighbours[3 * (size_t)t + k];
            bool match = other == SHAPE_NO_PIECE;
            for (uint32_t m = 0; m < 3 && !match; m++) {
                const uint32_t *its = l->triangles + 3 * (size_t)other;
                match = its[m] == mine[(k + 1) % 3] && its[(m + 1) % 3] == mine[k] && l->neighbours[3 * (size_t)other + m] == t;
            }
            if (!match)
                return false;
        }
    return true;
}

/* Surfaces may wind round a place more than once, each triangle adding less than the box. */
static bool mass_is_possible(const MeshData *d, box3 box)
{
    vec3 size = vec3_sub(box.high, box.low);
    return d->mass.volume <= size.x * size.y * size.z * d->triangle_count;
}

static void read_lists(Pack *p, const MeshData *header, Shape *s)
{
    size_t nodes = (size_t)header->node_count, vertices = (size_t)header->vertex_count, count = (size_t)header->triangle_count;
    MeshData *d = shape_alloc(s, sizeof *d + nodes * sizeof(MeshNode) + vertices * sizeof(vec3) + 6 * count * sizeof(uint32_t));
    if (!d) {
        pack_fail_memory(p);
        return;
    }
    s->type = &shape_mesh;
    d->vertex_count   = header->vertex_count;
    d->triangle_count = header->triangle_count;
    d->node_count     = header->node_count;
    d->closed         = header->closed;
    d->mass           = header->mass;
    Lists l = lists_of(d);
    pack_lists(p, d, &l);
    if (pack_good(p)) {
        pack_check(p, tree_is_sound(d, &l), "the boxes of a mesh are no tree over its triangles");
        pack_check(p, neighbours_match(d, &l), "neighbours of triangles do not match");
        pack_check(p, !d->closed || mass_is_possible(d, l.nodes[0].box), "the mass of a mesh is impossible");
    }
    for (size_t i = 0; pack_good(p) && i < 3 * count; i++)
        s->outer = real_max(s->outer, vec3_length(l.vertices[l.triangles[i]]));
    if (!pack_good(p))
        shape_free(s);
}

void mesh_pack(Pack *p, Shape *s)
{
    MeshData header = {.mass = {.inertia = mat3_zero()}};
    if (!p->reading)
        header = *(const MeshData *)s->data;
    uint32_t vertices = pack_count(p, (uint32_t)header.vertex_count, VERTEX_BYTES, "vertices of a mesh");
    uint32_t triangles = pack_count(p, (uint32_t)header.triangle_count, TRIANGLE_BYTES, "triangles of a mesh");
    uint32_t nodes = pack_count(p, (uint32_t)header.node_count, NODE_BYTES, "boxes of a mesh");
    pack_bool(p, &header.closed);
    if (header.closed)
        pack_mass(p, &header.mass);
    if (!p->reading) {
        Lists l = lists_of(s->data);
        pack_lists(p, &header, &l);
        return;
    }
    pack_check(p, vertices >= 3 && vertices <= MESH_TRIANGLES && triangles >= 1 && triangles <= MESH_TRIANGLES && nodes >= 1 &&
               nodes < 2 * triangles, "a mesh has too few or too many parts");
    if (!pack_good(p))
        return;
    header.vertex_count   = (int)vertices;
    header.triangle_count = (int)triangles;
    header.node_count     = (int)nodes;
    read_lists(p, &header, s);
}
