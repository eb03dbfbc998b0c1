/* conserve/conserve.h - the energy-momentum way to advance a jointed group in which nothing touches.
 *
 * Implicit steps that end on the joints exactly and conserve energy and both momenta by construction, so that taut chains,
 * linkages and springs take one step a frame. Method and sources: conserve/system.h.
 *
 * Floor: conserve. Includes base, math, geom, world, solve.
 */
#ifndef DIG_CONSERVE_H
#define DIG_CONSERVE_H

#include "solve/group.h"

extern const Way way_conserve;

#endif
