/* geom/mass.h - mass, centre of mass and inertia: turning, moving, adding, and of any closed surface.
 *
 * A MassProps holds either a solid of density 1 (m^3, m, m^5), as ShapeType.mass gives it, or a sum of placed solids in
 * kg, m and kg m^2 (`mass` instead of `volume`). The inertia is always about the centre, in the axes of the frame.
 *
 * Floor: geom.
 */
#ifndef DIG_MASS_H
#define DIG_MASS_H

#include "geom/shape.h"

/* R I R': the inertia of the same body after turning it by q. */
mat3 inertia_turn(mat3 inertia, quat q);

/* What the parallel-axis theorem adds to an inertia about the centre of mass for an axis that lies d away: m (d.d 1 - d d'). */
mat3 inertia_offset(real mass, vec3 d);

/* Adds a solid of the given density (kg/m^3) at a pose to a sum (start with all zero). */
void mass_add(MassProps *sum_in_kg, const MassProps *unit, real density, pose at);

/* Scales a sum to a prescribed total mass (kg): the same distribution, another density. A sum without mass stays as it is. */
void mass_scale(MassProps *sum_in_kg, real mass);

/* Volume, centre and inertia of the solid inside a closed surface of triangles, counter-clockwise seen from outside. Exact
 * for polyhedra up to rounding: signed tetrahedra. A surface turned inside out gives a negative volume. */
void mass_of_triangles(const vec3 *vertices, const uint32_t *triangles, int triangle_count, MassProps *out);

#endif
