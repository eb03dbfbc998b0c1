/* geom/wet.h - what part of a solid lies below a plane.
 *
 * A plane is normal . x <= offset in the shape's frame, its normal a unit vector. Volumes and first moments add, so that those
 * of a compound are the sums over its solids.
 *
 * Floor: geom.
 */
#ifndef DIG_WET_H
#define DIG_WET_H

#include "geom/shape.h"

/* The part of a solid with normal . x <= offset; zero for what is no solid (plane, open mesh). */
Wet  shape_wet(const Shape *s, vec3 normal, real offset);

/* ---- for the files of shape types ---- */

/* Adds what a face, corners counter-clockwise seen from outside, contributes to the part of a polyhedron below the plane. */
void wet_face(Wet *sum, const vec3 *corners, int count, vec3 normal, real offset);

/* A slice y0 <= y <= y1 of a solid of revolution about y: radius r0 + slope y, or, of a ball about (0, middle, 0), its own. */
typedef struct Lathe { real y0, y1, r0, slope, ball, middle; } Lathe;

void wet_lathe(Wet *sum, const Lathe *l, vec3 normal, real offset);

#endif
