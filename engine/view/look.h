/* view/look.h - what is to be seen of a world, in double, as tables of rows: between the world and its pictures.
 *
 * A picture (view/view.h) is made in two steps: look_take copies from the world what a picture depends on, look_view makes the
 * picture from that alone. A replay keeps the tables, so that a picture made from it is the one that a film of the running world
 * would have had, bit for bit: both are made by look_view.
 *
 * Rows are plain memory without padding or pointers: equal states are equal bytes, which lets a recorder keep what changed. The
 * first three tables and the poses have a row per slot of the world, all zero where there is nothing.
 *
 * Owns:      its tables and meshes, and a reference to each shape that it knows; look_close releases them.
 * Invariant: look_check.
 * Floor:     view. Includes base, math and geom.
 */
#ifndef DIG_LOOK_H
#define DIG_LOOK_H

#include "base/list.h"
#include "base/map.h"
#include "geom/shape.h"
#include "view/view.h"

#define LOOK_NONE UINT32_MAX

typedef enum LookTable {
    LOOK_SCENE,         /* one row                                          */
    LOOK_BODIES,        /* by slot: what seldom changes                     */
    LOOK_POSES,         /* by slot of the body                              */
    LOOK_SOLIDS,        /* by slot: the shapes                              */
    LOOK_JOINTS,        /* by slot: what seldom changes                     */
    LOOK_LOADS,         /* by slot of the joint                             */
    LOOK_CONTACTS,      /* points that bear a force                         */
    LOOK_EDGES,         /* links, layer by layer                            */
    LOOK_ARROWS,        /* pushes                                           */
    LOOK_TABLES
} LookTable;

typedef struct LookScene {
    real     time;              /* s                                        */
    uint64_t step, seed;
    vec3     low, high;         /* m, bounds of all that has an end; low > high: nothing has */
    vec3     gravity;           /* m/s^2                                    */
    vec3     room_size, room_at;        /* m                                */
    uint32_t has_room, open_walls;      /* a bit for each, in the order +x -x +y -y +z -z */
} LookScene;

typedef struct LookBody {
    uint32_t there;             /* 0 or 1                                   */
    uint32_t gen;               /* of its handle, the world's first being 1 */
    uint32_t index;             /* the recorder's                           */
    uint8_t  kind;              /* dig_body_kind                            */
    uint8_t  labelled;          /* it has a name, and an end                */
    uint8_t  spare[2];
    uint32_t sheet, column, row, spare2;        /* sheet 0: no particle of one */
    vec3     centre;            /* m, centre of mass in the body            */
    char     name[64];
} LookBody;

typedef struct LookPose {
    vec3     x;                 /* m, centre of mass                        */
    quat     q;
    real     temperature;       /* K; 0 = it has none                       */
    float    v[3], w[3];        /* m/s of the centre of mass, rad/s         */
    float    force[3];          /* N, mean resultant over the last step     */
    uint32_t dig;               /* id, 0 = none                             */
    uint8_t  awake, mode;       /* dig_mode                                 */
    uint8_t  spare[6];
} LookPose;

typedef struct LookSolid {
    uint32_t there;
    uint32_t body;              /* slot; LOOK_NONE: the world's             */
    uint32_t mesh;
    uint32_t pattern;           /* ViewPattern                              */
    pose     at;                /* in the body, or in the world             */
    float    colour[3];         /* linear RGB                               */
    float    roughness, metallic;
    float    clear;             /* 1 - opacity: 0 = nothing is seen through it */
} LookSolid;

typedef struct LookJoint {
    uint32_t there;
    uint32_t gen;
    uint32_t a, b;              /* slots; b LOOK_NONE: the world            */
    uint32_t drawn;             /* as lines: not between joints, as gears are */
    uint32_t spare;
    vec3     ra, rb;            /* m, anchors from the centres of mass, body axes; rb in the world without b */
    real     radius;            /* m, of the bar or coil that shows it; 0 = none does */
    char     type[16], name[64];
} LookJoint;

typedef struct LookLoad {
    float stress;               /* 1, share of what it bears; < 0 = nothing breaks it */
    float force[3];             /* N on a                                   */
} LookLoad;

typedef struct LookContact { float p[3], n[3], force[3]; } LookContact;     /* ViewContact */
typedef struct LookArrow { vec3 p; float v[3], spare; } LookArrow;          /* m, N */

typedef struct LookEdge {
    uint32_t a, b;              /* slots                                    */
    uint32_t dig;
    uint32_t link;              /* in the layer's graph                     */
    uint8_t  kind, layer, bound, spare;
    float    end[3];            /* m from the origin: bound, where the outside is met */
} LookEdge;

typedef struct LookMesh {
    ViewMesh mesh;
    vec3     normal;            /* of a plane: solid where normal . x <= offset, in the body */
    real     offset;
    Shape    shape;             /* of which it was made; not in a replay    */
} LookMesh;

typedef struct Look {
    ListAny tables[LOOK_TABLES];
    LIST(LookMesh) meshes;
    Map     known;              /* address of a shape's data -> mesh        */
} Look;

extern const size_t look_row_size[LOOK_TABLES];

static inline LookScene   *look_scene(const Look *l) { return l->tables[LOOK_SCENE].data; }
static inline LookBody    *look_bodies(const Look *l) { return l->tables[LOOK_BODIES].data; }
static inline LookPose    *look_poses(const Look *l) { return l->tables[LOOK_POSES].data; }
static inline LookSolid   *look_solids(const Look *l) { return l->tables[LOOK_SOLIDS].data; }
static inline LookJoint   *look_joints(const Look *l) { return l->tables[LOOK_JOINTS].data; }
static inline LookLoad    *look_loads(const Look *l) { return l->tables[LOOK_LOADS].data; }
static inline LookContact *look_contacts(const Look *l) { return l->tables[LOOK_CONTACTS].data; }
static inline LookEdge    *look_edges(const Look *l) { return l->tables[LOOK_EDGES].data; }
static inline LookArrow   *look_arrows(const Look *l) { return l->tables[LOOK_ARROWS].data; }
static inline int          look_count(const Look *l, LookTable t) { return l->tables[t].count; }

/* Makes a table `count` rows long; new rows are zero. */
dig_status look_resize(Look *l, LookTable t, int count);
/* What is to be seen of the world now, in place of what was. Keeps the meshes that are there. */
dig_status look_take(Look *l, const dig_world *w);
/* The same, by a caller who knows that nobody changed a body or a shape since it was taken last, but for places, speeds and forces: their
 * two tables then stay, and *same says so. Bodies that came or went are seen all the same. */
dig_status look_take_moving(Look *l, const dig_world *w, bool *same);
/* Is what look_take took still what is to be seen, as far as calls between steps can change it? Cheap; false when in doubt. */
bool       look_holds(const Look *l, const dig_world *w);
dig_status look_view(const Look *l, View **out);
/* Deep, but for the meshes, which `to` does not get. */
dig_status look_copy_tables(Look *to, const Look *from);
void       look_close(Look *l);
/* m, added to every position of its view. */
vec3       look_origin(const LookScene *s);
/* For tables that were read: every index in range, every number finite, rotations of length 1; it has so many meshes. NULL, or what is wrong. */
const char *look_check(const Look *l, int meshes);

#endif
