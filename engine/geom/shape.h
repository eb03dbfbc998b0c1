/* geom/shape.h - solids: what a shape type must supply, and shape instances.
 *
 * A shape type is one file ending in one const ShapeType; the list is in
 * shape.c. Convex shapes are a core plus a rounding radius: a sphere is a
 * point with radius r, a capsule a segment with radius r, a box has radius 0.
 * GJK and EPA see only `support` of the core. A shape without support (mesh,
 * height field, plane) supplies convex pieces or its own exact pairs.
 *
 * Owns:      a Shape owns `data` (one allocation, plain memory without inner
 *            pointers except behind `extra`); shape_free gives it back.
 * Invariant: `data` never changes after shape_make: shapes may be shared by
 *            threads and by snapshots.
 * Floor:     geom. Includes base and math.
 */
#ifndef DIG_SHAPE_H
#define DIG_SHAPE_H

#include "base/base.h"
#include "math/quat.h"

typedef struct MassProps {      /* of a solid of density 1 kg/m^3, in its own frame; sums (geom/mass.h) hold kg and kg m^2 */
    union {
        real volume;            /* m^3                                              */
        real mass;              /* kg, the same number at unit density              */
    };
    vec3 centre;                /* m                                                */
    mat3 inertia;               /* m^5 about the centre                             */
} MassProps;

typedef struct Wet {            /* a part of a solid, in the shape's frame */
    real volume;                /* m^3                                              */
    vec3 moment;                /* m^4  integral of x over it                       */
} Wet;

typedef struct Ray { vec3 from, along; real length; } Ray;      /* along is a unit vector */
typedef struct RayHit { vec3 point, normal; real distance; } RayHit;

/* A triangle mesh for drawing; see ViewMesh. Allocated with malloc, freed by the caller. */
typedef struct ShapeMesh {
    int    vertex_count, index_count;
    float *vertices, *normals;      /* normals NULL = flat */
    uint32_t *indices;
} ShapeMesh;

#define SHAPE_FOOT 16           /* directions, see foot() */

typedef struct ShapeType ShapeType;

typedef struct Shape {
    const ShapeType *type;
    const void      *data;      /* the type's own, immutable               */
    real             round;     /* m  rounding radius around the core      */
    real             inner;     /* m  radius of a ball about shape_middle that fits inside, for continuous collision; 0 = none (plane: infinite) */
    real             outer;     /* m  radius about the shape's origin that contains it (plane: infinite) */
    real             rolling;   /* m  radius of curvature where it rolls (sphere, capsule, cylinder); 0 = it does not */
    int             *refs;      /* shared by copies and snapshots (shape_keep, shape_free) */
} Shape;

struct ShapeType {
    union {                     /* the same four fields, as the public API shows them */
        dig_schema schema;
        struct {
            const char *name;           /* Lua key: world:box, parts                      */
            const char *doc;            /* one sentence                                   */
            const dig_param *params;    /* rows of the def struct in digbox.h             */
            size_t      def_size;
        };
    };
    bool        solid;          /* false: plane, mesh, height field, which are surfaces        */
    bool        convex;         /* is what support() says                                     */
    /* Checks def (already inside its ranges) and fills shape. why gets one sentence with value, unit and bound. */
    dig_status (*make)(const void *def, Shape *shape, char *why, size_t capacity);
    vec3       (*support)(const Shape *s, vec3 direction);      /* core point farthest along; local; direction need not be unit */
    vec3       (*middle)(const Shape *s);                       /* m  a point well inside, see shape_middle; NULL: the origin is one */
    box3       (*bounds)(const Shape *s, pose at);              /* world, rounding included; infinite planes use +-1e30 */
    void       (*mass)(const Shape *s, MassProps *out);         /* exact; NULL: has none. An open mesh gives volume 0 */
    /* Adds the part with normal . x <= offset, a unit vector; what does not meet the plane is not asked. NULL: is no solid. */
    void       (*wet)(const Shape *s, vec3 normal, real offset, Wet *sum);
    real       (*shadow)(const Shape *s, vec3 direction);       /* m^2  area of its projection along a unit vector; NULL: it never moves */
    real        drag;           /* 1  drag coefficient of that area (Hoerner 1965) at Reynolds numbers of 1e4 to 2e5 */
    real       (*area)(const Shape *s);                         /* m^2 of the whole surface; NULL: infinite */
    /* First hit from outside; a start inside the shape gives no hit of it. The normal points out of the shape; open meshes
     * are hit from both sides (normal towards the start), height fields from above. */
    bool       (*ray)(const Shape *s, const Ray *local, RayHit *hit);
    bool       (*contains)(const Shape *s, vec3 local);         /* is the point inside or on the surface? never NULL */
    dig_status (*mesh)(const Shape *s, ShapeMesh *out);         /* smooth normals where the surface is smooth */
    /* Flat face of the core whose outward normal is nearest to direction (local): writes its corners in order, counter-
     * clockwise about the outward normal, at most 16 (thin out evenly beyond), returns their number (1 = a vertex or
     * smooth point, 2 = an edge or side line, >= 3 = a face) and the feature number of the face. Used to build manifolds. */
    int        (*face)(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature);    /* NULL when not convex */
    /* Only for meshes, which planes meet as they would meet their hulls: of the corners no more than height behind the farthest one along
     * down (a unit vector, local), the farthest in each of so many directions across, in order around; each once, with its number. */
    int        (*foot)(const Shape *s, vec3 down, real height, vec3 corners[SHAPE_FOOT], uint32_t feature[SHAPE_FOOT]);
    /* Only for mesh and heightfield: convex pieces (triangles, as hull-like Shapes on the caller's storage) whose bounds
     * meet `box` (local). Returns the number there are; writes at most capacity indices. */
    int        (*pieces)(const Shape *s, box3 box, uint32_t *piece, int capacity);
    void       (*piece)(const Shape *s, uint32_t piece, vec3 corners[3]);   /* counter-clockwise seen from outside / above */
    /* The piece on the other side of the edge corners[edge] -> corners[(edge + 1) % 3], or SHAPE_NO_PIECE. */
    uint32_t   (*neighbour)(const Shape *s, uint32_t piece, int edge);
};

#define SHAPE_NO_PIECE UINT32_MAX
#define SHAPE_LENGTH_MIN 1e-4   /* m  smallest radius, height, extent */
#define SHAPE_LENGTH_MAX 1e5    /* m  largest */
#define HULL_VERTICES    255    /*    most corners of a hull */

/* ---- what `data` points to, for exact pairs and for the view; read only ---- */

typedef struct SphereData   { real radius; } SphereData;                /* m; core: the origin */
typedef struct BoxData      { vec3 half; } BoxData;                     /* m */
typedef struct CapsuleData  { real radius, half; } CapsuleData;         /* m; core: (0, -half, 0) to (0, half, 0) */
typedef struct CylinderData { real radius, half; } CylinderData;        /* m; y from -half to half */
typedef struct ConeData     { real radius, height, base, apex, slant; } ConeData;   /* m; y from base = -h/4 to apex = 3h/4; slant height */
typedef struct PlaneData    { vec3 normal; real offset; } PlaneData;    /* solid where normal . x <= offset */

typedef struct HullFace { vec3 normal; real offset; int first, count; } HullFace;   /* corners[first ...], counter-clockwise outside */
typedef struct HullEdge { uint8_t tail, head; uint16_t left, right; } HullEdge;     /* left: the face that runs tail -> head; tail < head */
typedef struct HullData {
    int       vertex_count, face_count, edge_count, corner_count;
    MassProps mass;             /* the arrays follow: see hull_vertices ... */
} HullData;

static inline const HullData *hull_data(const Shape *s) { return s->data; }
static inline const vec3 *hull_vertices(const HullData *h) { return (const vec3 *)(const void *)(h + 1); }
static inline const HullFace *hull_faces(const HullData *h) { return (const HullFace *)(const void *)(hull_vertices(h) + h->vertex_count); }
static inline const HullEdge *hull_edges(const HullData *h) { return (const HullEdge *)(const void *)(hull_faces(h) + h->face_count); }
static inline const uint8_t *hull_corners(const HullData *h) { return (const uint8_t *)(hull_edges(h) + h->edge_count); }

/* m  A point that is surely inside a convex shape: corners of hulls lie about any origin, on their surface or far beside them, too. */
static inline vec3 shape_middle(const Shape *s) { return s->type->middle ? s->type->middle(s) : vec3_zero(); }

bool shape_mesh_closed(const Shape *s);     /* a mesh whose surface encloses a volume: its mass is exact, contains() works */

extern const ShapeType shape_sphere, shape_box, shape_capsule, shape_cylinder, shape_cone, shape_plane, shape_hull, shape_mesh,
    shape_heightfield;
extern const ShapeType *const shape_types[];            /* NULL-terminated */

const ShapeType *shape_type_find(const char *name);     /* NULL when there is none */

/* Makes a shape with one reference. Fails with a sentence in why, leaving *out zeroed. */
dig_status shape_make(const char *type, const void *def, Shape *out, char *why, size_t capacity);
Shape      shape_keep(const Shape *s);                  /* one more reference; not thread-safe (called between steps only) */
void       shape_free(Shape *s);                        /* drops one; the last frees the data; zeroes *s */

size_t     shape_bytes(const Shape *s);                 /* of the data */

#endif
