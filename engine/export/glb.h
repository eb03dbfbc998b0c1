/* export/glb.h - what the files that write binary glTF 2.0 share.
 *
 * Source: Khronos glTF 2.0 specification; KHR_lights_punctual.
 * Floor:  export.
 */
#ifndef DIG_EXPORT_GLB_H
#define DIG_EXPORT_GLB_H

#include "base/list.h"
#include "export/output.h"

typedef struct Part { Output text; int count; } Part;      /* the items of one JSON array */

typedef struct GlbMesh {        /* one that is written: shape and look */
    uint64_t hash;
    float    colour[3], roughness, metallic, clear;
    int      form, vertices, indices;
    float    size[3];
    int      mesh, spare;       /* no padding: compared as bytes */
} GlbMesh;

/* Key times and values of one moving thing. Struts change their length; bodies have 1 there. */
typedef struct Key { float time, p[3], q[4], length; } Key;
typedef LIST(Key) Keys;

typedef struct Glb {
    Replay *r;
    const ExportOptions *options;
    Output  bin;
    Part    nodes, meshes, materials, accessors, views, samplers, channels, cameras, lights, roots;
    LIST(GlbMesh) known;
    real    start;              /* s, of the first frame: time 0 of the animation */
    real    reach;              /* m, of planes that are drawn */
    Output *out;                /* gets the first failure */
} Glb;

/* Opens an item of an array: `,` where one came before. Returns its index. */
int  part_begin(Part *p);
/* An accessor on new bytes; low and high only for the first three components of positions and for times. */
enum { GLB_FLOAT = 5126, GLB_UINT = 5125 };         /* component */
enum { GLB_KEYS = 0, GLB_VERTICES = 34962, GLB_INDICES = 34963 };  /* target */
int  glb_accessor(Glb *g, const void *data, int count, int width, int component, bool bounds, int target);
/* glb_mesh.c: the mesh of an item, made once; -1: it cannot be drawn. */
int  glb_mesh(Glb *g, const View *v, const ViewItem *item);
/* glb_track.c: keys become samplers and channels of the one animation. */
void glb_track(Glb *g, int node, Keys *keys, bool stretch);
void glb_presence(Glb *g, int node, real born, real died);      /* s; NAN: from the start, to the end */
/* glb_scene.c: cameras, sun and lamps from the notes of the replay. */
void glb_scene(Glb *g);
void glb_numbers(Output *o, const char *name, const float *x, int count);

#endif
