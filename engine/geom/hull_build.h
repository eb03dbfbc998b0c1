/* geom/hull_build.h - from a cloud of points to the corners and polygons of its convex hull. For hull.c and hull_save.c only.
 *
 * Floor: geom.
 */
#ifndef DIG_HULL_BUILD_H
#define DIG_HULL_BUILD_H

#include "geom/shape_build.h"

#define HULL_FACES   (2 * HULL_VERTICES - 4)    /* all triangles (Euler) */
#define HULL_CORNERS (6 * HULL_VERTICES - 12)   /* twice the edges       */
#define HULL_POINTS  65535                      /* most points given     */

typedef struct HullWork {
    int     vertex_count, face_count, corner_count;
    vec3    vertices[HULL_VERTICES];            /* in the order of the points given                                   */
    int     first[HULL_FACES], count[HULL_FACES];
    uint8_t corners[HULL_CORNERS];              /* counter-clockwise outside; the lowest first, faces in dictionary order */
    uint16_t side[HULL_VERTICES][HULL_VERTICES];    /* 1 + face left of the edge [tail][head], 0 = no such edge       */
} HullWork;

/* Builds the hull; fails with a sentence. The result depends on the points and their order only. */
dig_status hull_build(const dig_points *points, HullWork *work, char *why, size_t capacity);

/* Is it a closed surface of one piece whose polygons are convex? Fills `side`. */
bool hull_is_sound(HullWork *work);

/* Makes the shape's data from a sound hull (hull.c). */
dig_status hull_make_data(const HullWork *work, Shape *s);

/* Twice the area vector of a face (Newell): along the outward normal, sound when the polygon is flat only to rounding. */
vec3 hull_area(const HullWork *work, int face);

#endif
