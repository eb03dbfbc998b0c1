/* render/batch.h - the things to draw, sorted so that each program and mesh is bound once.
 *
 * Owns:  the list, the packed instances and their GPU buffer; batches_close frees them.
 * Floor: render.
 */
#ifndef DIG_BATCH_H
#define DIG_BATCH_H

#include "render/heat.h"
#include "render/mesh.h"
#include "render/program.h"
#include "render/stage.h"

typedef struct Instance {       /* as the vertex shader reads it; scene units */
    float    place[4];          /* relative to the eye; [3] a seed for the pattern          */
    float    turn[4];           /* quaternion                                               */
    float    size[4];           /* factors of the unit solid; [3] shift along y             */
    float    colour[4];         /* linear; [3] roughness                                    */
    float    look[4];           /* metallic, or minus how strongly it shines in its colour; bevel, 1 / cell of the pattern, grain axis; planes:
                                 * 0, share of a mirror, 1 / cell, metallic */
    float    half[4];           /* half extents, half width of a stripe; planes: offset of the tiles */
    float    clear;             /* 1 - opacity                                              */
    uint32_t number[2];         /* body, item in the view                                   */
} Instance;

typedef struct DrawItem {
    uint64_t   order;           /* distance, roughly; program; mesh      */
    float      distance;        /* from the eye: nearer first            */
    int        index;           /* in the view: settles ties             */
    ProgramKey key;
    int        mesh;
    bool       closed, caster;  /* back faces hidden; throws a shadow    */
    bool       numbered;        /* drawn as its index, shaded afterwards */
    Instance   instance;
} DrawItem;

typedef struct Batches {
    DrawItem *items;
    Instance *packed;
    int      *meshes;           /* [view's mesh_count] entry of each mesh of the view, -1 = cannot be drawn */
    int       count, capacity, mesh_capacity;
    int       drawn;            /* so many of the items are shaded by OpenGL                             */
    int       solid;            /* so many of the items, the first ones, let nothing through; the rest lies from far to near */
    GLuint    buffer;
} Batches;

typedef struct BatchEye {       /* from where it is drawn */
    vec3 at;                    /* scene                                     */
    real pixels;                /* height of the picture / (2 tan(fov / 2))  */
    real reach;                 /* scene units: planes end here, in the fog  */
    int  lamps;
    bool shadows, overlay_dig, overlay_stress;
    bool patch;                 /* the floor is drawn in two pieces: inside its map ...       */
    real patch_x, patch_y, patch_half;      /* ... which covers this square, scene units, and outside */
    bool numbers;               /* what render/shade.h can shade is drawn as numbers          */
    bool mirrors;               /* the floor mirrors what stands on it       */
    bool fine;                  /* the finest meshes, for data layers        */
    HeatScale heat;             /* on: bodies are coloured by temperature    */
} BatchEye;

dig_status batches_build(Batches *b, Meshes *meshes, const Gl *gl, const View *v, const Stage *s, const BatchEye *eye, uint64_t draw);
void       batches_close(Batches *b, const Gl *gl);

/* Draws the items from `first` to before `last` with programs of `kind`. */
dig_status batches_draw(const Batches *b, const Meshes *meshes, Programs *programs, const Gl *gl, ProgramKind kind, int first, int last,
                        char *why, size_t capacity);

/* How much of a mirror a plane is, 0..1: polished stone, ice and metal are, most floors are none. */
real plane_sheen(const ViewItem *item);

/* A colour for each DIG, well apart from those of its neighbours; linear. */
void dig_colour(uint32_t dig, float colour[3]);
void stress_colour(float stress, float colour[3]);      /* linear */

#endif
