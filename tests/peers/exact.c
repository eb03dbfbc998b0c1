/* tests/peers/exact.c - reference motions without a handy closed form, integrated in minimal coordinates.
 *
 * Classical Runge-Kutta of fourth order in long double, steps of 1/12000 s: with h^4 = 5e-17 s^4 and a rounding error
 * of 1e-19 the results hold to some 1e-14. Each is compared with published digits before it is used.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "suite.h"

enum { PER_FRAME = 200, FRAMES = 600, WIDEST = 7 };
typedef long double wide;
typedef void (*Slope)(const wide *state, wide *rate);

static const wide gravity = 9.81L;

static void runge_kutta(wide *y, int n, wide h, Slope slope)
{
    wide k[4][WIDEST], at[WIDEST];
    slope(y, k[0]);
    for (int stage = 1; stage < 4; stage++) {
        for (int i = 0; i < n; i++)
            at[i] = y[i] + (stage == 3 ? h : h / 2) * k[stage - 1][i];
        slope(at, k[stage]);
    }
    for (int i = 0; i < n; i++)
        y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
}

static void frame(wide *y, int n, Slope slope)
{
    for (int k = 0; k < PER_FRAME; k++)
        runge_kutta(y, n, 1.0L / (60 * PER_FRAME), slope);
}

static void must_agree(const char *what, wide got, wide want)
{
    if (fabsl(got - want) < 2e-12L)
        return;
    fprintf(stderr, "reference %s: got %.16Lg, want %.16Lg\n", what, got, want);
    exit(1);
}

/* Rod 1 x 0.1 x 0.1 m, 1 kg, about its centre; state: angle, rate. */
static const wide rod_inertia = 1.01L / 12;

static void one_rod(const wide *y, wide *rate)
{
    rate[0] = y[1];
    rate[1] = -gravity / 2 * sinl(y[0]) / (rod_inertia + 0.25L);
}

/* Two of them, hinged end to end; state: angles from straight down, rates. M q'' = -f from Lagrange's equations. */
static void two_rods(const wide *y, wide *rate)
{
    wide c = cosl(y[0] - y[1]) / 2, s = sinl(y[0] - y[1]) / 2;
    wide m11 = rod_inertia + 1.25L, m22 = rod_inertia + 0.25L;
    wide f1 = -s * y[3] * y[3] - 1.5L * gravity * sinl(y[0]);
    wide f2 = s * y[2] * y[2] - 0.5L * gravity * sinl(y[1]);
    wide det = m11 * m22 - c * c;
    rate[0] = y[2];
    rate[1] = y[3];
    rate[2] = (m22 * f1 - c * f2) / det;
    rate[3] = (m11 * f2 - c * f1) / det;
}

const TwoAngles *exact_pendulum(int rods)
{
    static TwoAngles one[FRAMES + 1], two[FRAMES + 1];
    TwoAngles *out = rods == 1 ? one : two;
    if (out[0].angle[0] > 0)
        return out;
    wide level = acosl(-1.0L) / 2, y[4] = {level, rods == 1 ? 0 : level, 0, 0};
    for (int k = 0; k <= FRAMES; k++) {
        out[k].angle[0] = (double)y[0];
        out[k].angle[1] = rods == 1 ? 0 : (double)y[1];
        frame(y, rods == 1 ? 2 : 4, rods == 1 ? one_rod : two_rods);
    }
    if (rods == 1) {
        must_agree("A07 angle(10 s)", one[600].angle[0], 0.82746667874679126L);
    } else {
        must_agree("A08 tip x(3 s)", sinl(two[180].angle[0]) + sinl(two[180].angle[1]), 1.2936756729037632L);
        must_agree("A08 tip z(3 s)", -cosl(two[180].angle[0]) - cosl(two[180].angle[1]), -1.4066160071847258L);
    }
    return out;
}

/* Euler's equations and q' = q w / 2 for the box of A09; state: quaternion (w, x, y, z), angular velocity in body axes. */
static void rotor(const wide *y, wide *rate)
{
    static const wide inertia[3] = {0.4L / 12, 1.04L / 12, 1.36L / 12};
    const wide *w = y + 4;
    rate[0] = (-y[1] * w[0] - y[2] * w[1] - y[3] * w[2]) / 2;
    rate[1] = (y[0] * w[0] + y[2] * w[2] - y[3] * w[1]) / 2;
    rate[2] = (y[0] * w[1] + y[3] * w[0] - y[1] * w[2]) / 2;
    rate[3] = (y[0] * w[2] + y[1] * w[1] - y[2] * w[0]) / 2;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        rate[4 + i] = (inertia[j] - inertia[k]) * w[j] * w[k] / inertia[i];
    }
}

const Orientation *exact_rotor(void)
{
    static Orientation out[FRAMES + 1];
    if (out[0].turn[0] > 0)
        return out;
    wide y[WIDEST] = {1, 0, 0, 0, 0.1L, 5, 0.1L};
    for (int k = 0; k <= FRAMES; k++) {
        for (int i = 0; i < 4; i++)
            out[k].turn[i] = (double)y[i];
        frame(y, WIDEST, rotor);
    }
    static const wide end[4] = {0.04708551769268645L, -0.33976629267684835L, -0.04007006820467736L, -0.93847547118628223L};
    const double *got = out[FRAMES].turn;
    wide sign = got[0] * end[0] < 0 ? -1 : 1;      /* q and -q are the same orientation */
    for (int i = 0; i < 4; i++)
        must_agree("A09 orientation(10 s)", sign * got[i], end[i]);
    return out;
}
