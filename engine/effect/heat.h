/* effect/heat.h - one temperature a body, what flows between bodies that touch, and to the air.
 *
 *     m c dT/dt = heating + losses of its contacts + sum G (T' - T) + h A (Ta - T) + eps sigma A (Ta^4 - T^4)
 *
 * Floor: effect. Includes solve, world.
 */
#ifndef DIG_HEAT_H
#define DIG_HEAT_H

#include "solve/medium.h"
#include "solve/network.h"
#include "world/world.h"

#define HEAT_SIGMA   5.670374419e-8     /* W/(m^2 K^4); exact in the SI of 2019, to its digits */
#define HEAT_AMBIENT AMBIENT            /* K */
#define HEAT_MOST    1e7                /* K */

typedef struct Heat {           /* of a body */
    real temperature;           /* K    these four first: others know them by their place, as Warmth */
    real expansion;             /* 1/K                                                    */
    real expansion_from;        /* K    at which it is as large as its shapes             */
    real swelled;               /* 1    private: the effect buoyancy's                    */
    real heat_capacity;         /* J/(kg K)                                               */
    real conductivity;          /* W/(m K)                                                */
    real emissivity;            /* 1                                                      */
    real convection;            /* W/(m^2 K)                                              */
    real surface;               /* m^2                                                    */
    real contact_conductance;   /* W/K  with each body it touches; NaN = by area and pressure */
    real heating;               /* W    fed in                                            */
    real capacity;              /* J/K  private; 0 = keeps its temperature whatever flows: planes, open grounds */
    real material_capacity, material_conductivity;     /* private; what of the two is the material's, NaN: its own */
    real start;                 /* K    private; when it joined                           */
    real stored;                /* J    private; since then: temperature = start + stored / capacity. Exact where a body is so large
                                 *      that its temperature does not change by a digit */
} Heat;

typedef struct HeatWorld {
    real ambient, gradient;     /* K, K/m  these two first: as Surround                   */
    real asperities;            /* 1/m  mean slope of the surfaces over their roughness   */
    real hardness;              /* Pa   of what touches                                   */
} HeatWorld;

/* W/K  of two surfaces pressed together (Cooper, Mikic & Yovanovich 1969): conductivities, N, m^2. */
real heat_contact(const HeatWorld *o, real ka, real kb, real force, real area);
/* 1  The part of the heat made where a and b rub that goes into a: by their effusivities sqrt(k rho c), half where both have none. */
real heat_share(real effusivity_a, real effusivity_b);
/* m^2  of a contact: the polygon of its points; an edge counts as a millimetre wide, a point as a square of that. */
real heat_area(const Manifold *m);

#endif
