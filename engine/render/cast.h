/* render/cast.h - depths of what throws shadows, seen along one direction; drawn by the CPU.
 *
 * OpenGL in software spends most of a small depth picture on getting it started and read back; this one begins where it is wanted.
 * Pixels are taken at their middles, as OpenGL takes them.
 *
 * Owns:  the triangles of the last cast_gather; cast_close frees them.
 * Floor: render.
 */
#ifndef DIG_CAST_H
#define DIG_CAST_H

#include "render/batch.h"

typedef struct CastGroup { int first, count; bool closed; } CastGroup;     /* indices of a thing; closed: back faces do not count */

typedef struct Casters {
    float     *places, *seen;           /* [3 place_count] scene units relative to the eye; texels and depth in a map */
    uint32_t  *corners;                 /* three a triangle, counter-clockwise seen from outside                      */
    CastGroup *groups;
    int        place_count, corner_count, group_count;
    int        place_capacity, corner_capacity, group_capacity;
} Casters;

/* All casters of a batch in scene units, round ones `coarser` levels coarser than they are seen. */
dig_status cast_gather(Casters *c, const Batches *b, const Meshes *meshes, int coarser);
/* One item, caster or not, as fine as it is seen. */
dig_status cast_gather_one(Casters *c, const DrawItem *d, const Meshes *meshes);
void       cast_close(Casters *c);

/* to_map takes places to -1..1, column by column, w = 1. Into out[size^2], row by row from -1: depth 0..1 of what lies nearest, 1 = nothing.
 * What is there already stays where it is nearer: cast_clear comes first. `slope`: each triangle is pushed away by that many texels of
 * its own steepness. */
void cast_clear(float *out, int size);
void cast_nearest(Casters *c, const float to_map[16], int size, float slope, float *out);

/* Seen from above: depths of the highest tops, and one minus depth of the lowest undersides; 1 = nothing. */
void cast_heights(Casters *c, const float to_map[16], int size, float *above, float *below);

#endif
