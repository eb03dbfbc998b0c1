/* render/heat.h - what temperatures look like: as they glow, and as false colours with a scale.
 *
 * Floor: render. Includes view.
 */
#ifndef DIG_RENDER_HEAT_H
#define DIG_RENDER_HEAT_H

#include "view/view.h"

#define HEAT_DRAPER 798.0       /* K: from here on a body is seen to glow, dull red (Draper 1847) */

typedef struct HeatScale { bool on; real low, high; } HeatScale;       /* K */

/* How strongly a body of that temperature shines, 0 below the Draper point, and in which colour: linear RGB, largest 1. */
real heat_glow(real temperature, float colour[3]);
/* From the coldest to the hottest body of the view, both at whole 50 K; off when no body has a temperature. */
HeatScale heat_scale(const View *v);
/* The false colour of a share of the scale, 0..1; linear RGB. Its lightness rises evenly. */
void heat_colour(real share, float colour[3]);

#endif
