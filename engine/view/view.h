/* view/view.h - an immutable picture of a world at one instant.
 *
 * The renderer sees this and nothing else. A view holds no pointer into the
 * world: it may outlive it, be saved, or be drawn on another thread. Poses are
 * relative to `origin`, so that floats suffice however far the scene lies from
 * the world's origin.
 *
 * Owns:      every array below; dig_view_free releases them all.
 * Invariant: every item's mesh is a valid index into meshes.
 * Floor:     view. The struct itself needs nothing but digbox.h.
 */
#ifndef DIG_VIEW_H
#define DIG_VIEW_H

#include "digbox.h"

/* A triangle mesh in the item's own space. Flat normals are made by the
 * renderer where `normals` is NULL. Primitives carry their type and size, so
 * that a renderer may draw them its own way. */
typedef enum ViewForm { VIEW_MESH, VIEW_SPHERE, VIEW_BOX, VIEW_CAPSULE, VIEW_CYLINDER, VIEW_CONE, VIEW_PLANE } ViewForm;

typedef struct ViewMesh {
    ViewForm  form;
    float     size[3];          /* m  sphere {r}, box full extents, capsule {r, straight length}, cylinder/cone {r, height} */
    int       vertex_count, index_count;
    float    *vertices;         /* [3 * vertex_count] m; always there except for VIEW_PLANE */
    float    *normals;          /* [3 * vertex_count], or NULL for flat shading */
    uint32_t *indices;          /* [index_count], 3 a triangle, counter-clockwise seen from outside */
    float    *taken;            /* [3 * vertex_count] of a sheet: vertices at the moment of the picture, while view_blend moves them; else NULL */
} ViewMesh;

typedef struct ViewItem {       /* one shape of one body, a bar or coil between two points, or a part of the room */
    uint32_t body;              /* slot + 1, for the id layer; 0 = none */
    uint32_t joint;             /* of a bar or coil: slot + 1; 0 = it is none; its mesh stands along y, {radius, length} */
    int      mesh;
    float    p[3];              /* m, relative to origin */
    float    q[4];              /* x y z w */
    float    colour[3];         /* linear RGB */
    float    roughness, metallic;
    float    clear;             /* 1 - opacity: 0 = nothing is seen through it */
    int      pattern;           /* ViewPattern */
    uint32_t dig;               /* DIG id, 0 = none (static) */
    float    stress;            /* 1, the largest share of its limit that a joint of its bears; < 0 = none can break */
    bool     asleep, fixed;
    bool     room;              /* a part of the room: it casts no shadow */
    bool     woven;             /* a particle or a thread of a sheet: the sheet is drawn in its place */
    float    temperature;       /* K; 0 = it has none */
} ViewItem;

typedef enum ViewPattern { PATTERN_PLAIN, PATTERN_WOOD, PATTERN_BRICK, PATTERN_TILE, PATTERN_STRIPE, PATTERN_CHECK } ViewPattern;

typedef struct ViewContact { float p[3], n[3], force[3]; } ViewContact;     /* m, 1, N on the second body */
typedef struct ViewLine    { float a[3], b[3], colour[3]; uint32_t dig; bool woven; } ViewLine;    /* joints, ropes, springs */
typedef struct ViewArrow   { float p[3], v[3], colour[3]; } ViewArrow;      /* pushes, N */
typedef struct ViewLabel   { float p[3]; char text[64]; } ViewLabel;
/* A link, between centres of mass. Bound: b is where the outside is met, and belongs to no DIG. */
typedef struct ViewEdge    { float a[3], b[3]; uint32_t dig; int kind; uint32_t layer; bool bound; } ViewEdge;

/* A piece of a sheet, between four particles in order round it: slots of bodies. */
typedef struct ViewQuad    { uint32_t corner[4]; float colour[3]; } ViewQuad;

typedef struct View {
    real         origin[3];             /* m, added to every position            */
    real         time;                  /* s                                     */
    uint64_t     step, seed;
    float        low[3], high[3];       /* m, bounds of all bodies but planes; low > high when there are none */
    float        up[3];                 /* minus the direction of gravity, or +y */
    ViewMesh    *meshes;   int mesh_count;
    ViewItem    *items;    int item_count;
    ViewContact *contacts; int contact_count;
    ViewLine    *lines;    int line_count;
    ViewArrow   *arrows;   int arrow_count;
    ViewLabel   *labels;   int label_count;
    ViewEdge    *edges;    int edge_count;
    ViewQuad    *quads;    int quad_count;
} View;

/* Makes a picture of the world as it is. DIG_E_MEMORY leaves *out NULL. */
dig_status dig_view_take(const dig_world *w, View **out);
void       dig_view_free(View *v);

/* ---- between two pictures ---- */

typedef struct ViewPose { float p[3], q[4]; } ViewPose;

/* The poses of all items, to be freed; NULL: no memory. */
ViewPose *view_poses(const View *v);
/* Moves the items of b, which had the poses `to`, to where they were at a fraction of the way from a, whose items had `from`. */
void      view_blend(const View *a, const ViewPose *from, View *b, const ViewPose *to, real fraction);

#endif
