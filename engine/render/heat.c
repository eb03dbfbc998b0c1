/* render/heat.c - black-body glow and false colours. */
#include "render/heat.h"

#include <math.h>

#define C2 14387.77             /* um K: h c / k */
#define FULL 1500.0             /* K: as bright as a picture that also shows the room can make it */

static const real waves[3] = {0.612, 0.549, 0.465};     /* um: about the middles of red, green and blue */

/* Planck's law at three wavelengths. The true brightness rises a thousandfold from 800 to 1100 K; shown is the square of the way
 * from the Draper point to white heat. */
real heat_glow(real t, float colour[3])
{
    colour[0] = 1;
    colour[1] = colour[2] = 0;
    if (!(t > HEAT_DRAPER))
        return 0;
    real red = pow(waves[0], -5) / expm1(C2 / (waves[0] * t));
    real most = 1;
    for (int i = 1; i < 3; i++) {
        real x = pow(waves[i], -5) / expm1(C2 / (waves[i] * t)) / red;
        colour[i] = (float)x;
        most = x > most ? x : most;
    }
    for (int i = 0; i < 3; i++)
        colour[i] = (float)((real)colour[i] / most);
    real way = (t - HEAT_DRAPER) / (FULL - HEAT_DRAPER);
    way = way < 1 ? way : 1;
    return 2.5 * way * way;
}

#define ROUND 50.0              /* K: so that the scale stands still while things warm */

HeatScale heat_scale(const View *v)
{
    real low = INFINITY, high = -INFINITY;
    for (int i = 0; i < v->item_count; i++) {
        real t = (real)v->items[i].temperature;
        if (!(t > 0 && isfinite(t)))
            continue;
        low = t < low ? t : low;
        high = t > high ? t : high;
    }
    if (!(high >= low))
        return (HeatScale){false, 0, 1};
    low = ROUND * floor(low / ROUND);
    high = ROUND * ceil(high / ROUND);
    return (HeatScale){true, low, high > low ? high : low + ROUND};
}

void heat_colour(real share, float colour[3])
{
    /* dark violet, purple, red, orange, pale yellow */
    static const float stops[5][3] = {{0.010f, 0.006f, 0.050f}, {0.130f, 0.010f, 0.210f}, {0.520f, 0.035f, 0.090f},
                                      {0.930f, 0.270f, 0.020f}, {0.970f, 0.920f, 0.420f}};
    real x = 4 * (share > 0 ? share < 1 ? share : 1 : 0);
    int k = x < 1 ? 0 : x < 2 ? 1 : x < 3 ? 2 : 3;
    for (int i = 0; i < 3; i++)
        colour[i] = (float)((real)stops[k][i] + (x - k) * ((real)stops[k + 1][i] - (real)stops[k][i]));
}
