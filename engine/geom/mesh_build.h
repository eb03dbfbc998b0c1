/* geom/mesh_build.h - the data of a triangle mesh, and how it is made from lists. For mesh.c and mesh_save.c only.
 *
 * Floor: geom.
 */
#ifndef DIG_MESH_BUILD_H
#define DIG_MESH_BUILD_H

#include "geom/shape_build.h"

#define MESH_TRIANGLES (1 << 22)    /* most triangles, and most vertices */
#define MESH_LEAF      4            /* most triangles in a leaf of the inner tree */

/* A node of the inner tree, stored depth first: its first child follows it, and a query that misses its box goes on at
 * `next`, so that walking needs no stack. */
typedef struct MeshNode {
    box3     box;
    uint32_t first, count;          /* triangles of a leaf; count 0 = not a leaf */
    uint32_t next;
} MeshNode;

typedef struct MeshData {
    int       vertex_count, triangle_count, node_count;
    bool      closed;               /* every edge runs as often one way as the other, and the volume is > 0 */
    MassProps mass;                 /* all zero when open; the arrays follow */
} MeshData;

static inline const MeshNode *mesh_nodes(const MeshData *d) { return (const MeshNode *)(const void *)(d + 1); }
static inline const vec3 *mesh_vertices(const MeshData *d) { return (const vec3 *)(const void *)(mesh_nodes(d) + d->node_count); }
/* [3 * triangle_count], from 0, in the order of the tree, counter-clockwise outside */
static inline const uint32_t *mesh_triangles(const MeshData *d)
{
    return (const uint32_t *)(const void *)(mesh_vertices(d) + d->vertex_count);
}
/* [3 * triangle_count] across corner k -> k + 1 */
static inline const uint32_t *mesh_neighbours(const MeshData *d) { return mesh_triangles(d) + 3 * (size_t)d->triangle_count; }

/* Checks the lists and makes the data of s; fails with a sentence. */
dig_status mesh_build(const dig_mesh_def *def, Shape *s, char *why, size_t capacity);

#endif
