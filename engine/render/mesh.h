/* render/mesh.h - triangle meshes on the GPU: ready-made solids in several finenesses, and the views' own, cached.
 *
 * A vertex is `shape * size + y * shift * length`: one unit capsule serves every radius and length, one unit cylinder
 * every radius and height. A view's mesh is recognised by its contents, not by its address, so that each new view
 * of the same world finds the meshes of the last one.
 *
 * Owns:      the buffers of every mesh; meshes_close frees them.
 * Invariant: entries below MESH_BUILT_IN are the ready-made ones and stay.
 * Floor:     render.
 */
#ifndef DIG_RENDER_MESH_H
#define DIG_RENDER_MESH_H

#include "render/gl.h"
#include "view/view.h"

enum { MESH_LEVELS = 5 };       /* finenesses of the round solids */

enum { MESH_BOX, MESH_QUAD, MESH_PATCH, MESH_SPHERE, MESH_CAPSULE = MESH_SPHERE + MESH_LEVELS, MESH_CYLINDER = MESH_CAPSULE + MESH_LEVELS,
       MESH_CONE = MESH_CYLINDER + MESH_LEVELS, MESH_BUILT_IN = MESH_CONE + MESH_LEVELS, MESH_CAPACITY = 4096,
       MESH_PROBES = 64 };     /* places where a key may lie */

typedef struct MeshVertex { float shape[3], normal[3], shift; } MeshVertex;

typedef struct GpuMesh {
    uint64_t key;           /* hash of the contents                          */
    uint64_t used;          /* number of the draw that used it last          */
    GLuint   array, vertices, indices;
    GLsizei  index_count;   /* 0 = free entry                                */
    bool     closed;        /* every edge has its twin: back faces are hidden */
    MeshVertex *corners;    /* [vertex_count] the same here, for the depths that the CPU draws */
    uint32_t   *list;       /* [index_count] */
    int         vertex_count;
} GpuMesh;

typedef struct Meshes { GpuMesh entry[MESH_CAPACITY]; } Meshes;

/* Makes the ready-made solids. DIG_E_MEMORY leaves what is there to meshes_close. */
dig_status meshes_open(Meshes *meshes, const Gl *gl);
void       meshes_close(Meshes *meshes, const Gl *gl);

/* Gives MESH_PATCH, a flat piece of MESH_QUAD's plane, these corners: x and z of each, in the order of MESH_QUAD. */
void meshes_patch(Meshes *meshes, const Gl *gl, float corners[4][2]);

/* The entry that holds a view's own mesh, uploaded if need be. Overwrites the entry unused for longest among its places;
 * -1 when this very draw uses all of them, memory is out or an index is wrong. `key` is mesh_hash(m). */
int      meshes_find(Meshes *meshes, const Gl *gl, const ViewMesh *m, uint64_t key, uint64_t draw);
uint64_t mesh_hash(const ViewMesh *m);

/* Fineness at which the outline of a solid of `radius` pixels is off by half a pixel at most. */
int mesh_level(real radius);

/* The same solid so many levels coarser, the coarsest at the least; own meshes have one level. */
int mesh_coarser(int mesh, int levels);

/* Cosine of half a segment: how far the middles of the chords lie from the axis, in radii. */
real mesh_chord(int level);

#endif
