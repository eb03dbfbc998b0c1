/* math/tumble.c - a free body that turns far, in closed form.
 *
 * In principal axes the angular momentum l goes with Jacobi's elliptic functions of one phase: l = (A cn, B sn, C dn), where 3 is the axis
 * that it goes round, 2 the middle one (Whittaker 1937). They are found once (Bulirsch 1965), and
 * carried on by their addition theorem. The shortest turn from l to axis 3 leaves one angle about l, of rate
 *
 *     (w . l + L w3) / (L + l3) = L / I3 + (w . l - L^2 / I3) / (L + l3),
 *
 * whose denominator lies between L and 2 L: an integral of a smooth function, by Gauss's points to rounding. Poles of that lie more than
 * a quarter of the other period, pi / 2, off the real axis.
 */
#include "math/tumble.h"

#define HALVES   12             /* of an arithmetic-geometric mean, which doubles its digits in each */
#define FEW      3              /* pairs of points of a panel that is short, and of one that is not: */
#define MANY     6
#define SHORT    0.15           /* half a panel, of the phase: 20 and 4.4 is what each point brings twice */
#define PANEL    0.75
#define PARTED   1e-10          /* 1 - m: nearer the separatrix they are lost in rounding */
#define FAR      1500           /* of the phase: of what goes farther whole periods are taken at once, */
#define FARTHEST 1e9            /* and the digits of those that are left are worth it */

typedef struct Phase { real s, c, d; } Phase;           /* sn, cn, dn */

typedef struct Means { real mean[HALVES], root[HALVES], end; int last; } Means;         /* arithmetic and geometric, and what both become */

/* m1: 1 - m, above 0 */
static void find_means(Means *of, real m1)
{
    real a = 1, b = sqrt(m1);
    int n = 0;
    for (;; n++) {
        of->mean[n] = a;
        of->root[n] = b;
        if (fabs(a - b) <= 1e-9 * a || n == HALVES - 1)
            break;
        b = sqrt(a * b);
        a = 0.5 * (a + of->root[n]);
    }
    of->end = 0.5 * (a + b);
    of->last = n;
}

static Phase phase_of(const Means *of, real u)
{
    real s = sin(of->end * u), c = cos(of->end * u), d = 1;
    if (s == 0)
        return (Phase){0, c, 1};
    real ratio = c / s, up = of->end * ratio;
    for (int n = of->last; n >= 0; n--) {
        real below = of->mean[n];
        ratio *= up;
        up *= d;
        d = (of->root[n] + ratio) / (below + ratio);
        ratio = up / below;
    }
    real size = 1 / sqrt(up * up + 1);
    s = s < 0 ? -size : size;
    return (Phase){s, up * s, d};
}

/* 1 - m s^2 s'^2 is c^2 + s^2 d'^2, which loses no digits. */
static inline Phase phase_add(Phase p, Phase q, real m)
{
    real all = 1 / (p.c * p.c + p.s * p.s * q.d * q.d);
    return (Phase){all * (p.s * q.c * q.d + q.s * p.c * p.d), all * (p.c * q.c - p.s * q.s * p.d * q.d),
                   all * (p.d * q.d - m * p.s * q.s * p.c * q.c)};
}

static const real few_at[FEW] = {0.23861918608319690863, 0.66120938646626451366, 0.93246951420315202781};
static const real few_weight[FEW] = {0.46791393457269104739, 0.36076157304813860757, 0.17132449237917034504};
static const real many_at[MANY] = {0.12523340851146891547, 0.36783149899818019375, 0.58731795428661744730,
                                   0.76990267419430468704, 0.90411725637047485668, 0.98156063424671925069};
static const real many_weight[MANY] = {0.24914704581340278500, 0.23349253653835480876, 0.20316742672306592175,
                                       0.16007832854334622633, 0.10693932599531843096, 0.04717533638651182719};

/* The mean of 1 / (1 + rise dn) over a length of the phase, `whole`, from p on. */
static real mean_rate(const Means *of, Phase p, real length, Phase whole, real rise, real m)
{
    int panels = (int)ceil(length / (2 * PANEL));
    real half = length / (2 * int_max(panels, 1)), sum = 0;
    bool is_short = half <= SHORT;
    int count = is_short ? FEW : MANY;
    const real *at = is_short ? few_at : many_at, *weight = is_short ? few_weight : many_weight;
    Phase off[MANY], step = panels > 1 ? phase_of(of, 2 * half) : whole;
    for (int i = 0; i < count; i++)
        off[i] = phase_of(of, at[i] * half);
    p = phase_add(p, phase_of(of, half), m);
    for (int k = 0; k < int_max(panels, 1); k++) {
        for (int i = 0; i < count; i++) {           /* dn at either side of the middle: (even -+ odd) / all */
            Phase q = off[i];
            real all = p.c * p.c + p.s * p.s * q.d * q.d, even = all + rise * p.d * q.d, odd = rise * m * p.s * q.s * p.c * q.c;
            sum += weight[i] * all * even / (even * even - odd * odd);
        }
        p = phase_add(p, step, m);
    }
    return sum / int_max(panels, 1);
}

/* The same over more than a period, 2 K of dn, and the phase it ends with: half a turn of sn and cn in each. */
static real mean_far(const Means *of, Phase p, real length, Phase *whole, real rise, real m)
{
    real period = DIG_PI / of->end, turns = floor(length / period), rest = real_max(0, length - turns * period);
    real sign = fmod(turns, 2) == 0 ? 1 : -1;
    *whole = phase_of(of, rest);
    real sum = turns * period * mean_rate(of, p, period, *whole, rise, m) + rest * mean_rate(of, p, rest, *whole, rise, m);
    *whole = (Phase){sign * whole->s, sign * whole->c, whole->d};
    return sum / length;
}

/* From the direction of l to its axis. */
static quat to_axis(vec3 l, real size, vec3 axis)
{
    vec3 turn = vec3_cross(l, axis);
    return quat_unit((quat){turn.x, turn.y, turn.z, size + vec3_dot(l, axis)});
}

/* 1 / (kg m^2) that differ by this part turn nothing in a step */
#define SAME 1e-15

bool tumble_principal(const mat3 *inv_inertia) { return inv_inertia->r0.y == 0 && inv_inertia->r0.z == 0 && inv_inertia->r1.z == 0; }

int tumble_axis(const mat3 *inv_inertia)
{
    const real d[3] = {inv_inertia->r0.x, inv_inertia->r1.y, inv_inertia->r2.z};
    for (int k = 0; k < 3 && tumble_principal(inv_inertia); k++)
        if (fabs(d[(k + 1) % 3] - d[(k + 2) % 3]) <= SAME * d[(k + 1) % 3])
            return k;
    return -1;
}

/* w = L / I + e (1 / Ie - 1 / I) L.e, and L.e stays: the first part turns about L in the world, the second about e in the body. */
quat tumble_about(const mat3 *inv_inertia, quat q, vec3 momentum, real h, int axis)
{
    const real d[3] = {inv_inertia->r0.x, inv_inertia->r1.y, inv_inertia->r2.z};
    const vec3 e = {axis == 0, axis == 1, axis == 2};
    real across = d[(axis + 1) % 3], own = (d[axis] - across) * vec3_dot(e, quat_unrotate(q, momentum));
    return quat_unit(quat_mul(quat_exp(vec3_scale(h * across, momentum)), quat_mul(q, quat_exp(vec3_scale(h * own, e)))));
}

static inline real ratio_root(real a, real b) { return a > 0 && b > 0 ? sqrt(a / b) : 0; }

bool tumble(const mat3 *inv_inertia, quat *q, vec3 momentum, real h)
{
    vec3 body = quat_unrotate(*q, momentum);
    const real l[3] = {body.x, body.y, body.z}, inverse[3] = {inv_inertia->r0.x, inv_inertia->r1.y, inv_inertia->r2.z};
    int low = inverse[0] <= inverse[1] ? (inverse[0] <= inverse[2] ? 0 : 2) : (inverse[1] <= inverse[2] ? 1 : 2);
    int high = inverse[(low + 1) % 3] >= inverse[(low + 2) % 3] ? (low + 1) % 3 : (low + 2) % 3, mid = 3 - low - high;
    /* of w . l - L^2 / I of the middle axis decides which of the others l goes round */
    real above = (inverse[high] - inverse[mid]) * l[high] * l[high], below = (inverse[mid] - inverse[low]) * l[low] * l[low];
    int one = above <= below ? high : low, three = low + high - one;
    real d1 = inverse[one], d2 = inverse[mid], d3 = inverse[three];
    real off = (d1 - d3) * l[one] * l[one] + (d2 - d3) * l[mid] * l[mid];               /* w . l - L^2 / I3 */
    real rest = (d1 - d2) * l[mid] * l[mid] + (d1 - d3) * l[three] * l[three];          /* L^2 / I1 - w . l */
    real scale = (d2 - d3) * rest, m1 = (d1 - d3) * (below - above) / scale, m = (d1 - d2) * off / scale;
    real length = h * sqrt(scale), size = vec3_length(body), way = l[three] < 0 ? -1 : 1;
    if (!(scale > 0) || !(m1 > PARTED) || !(m < 1) || !(length < FARTHEST))
        return false;
    real a = ratio_root(fabs(off), fabs(d1 - d3)), b = ratio_root(fabs(off), fabs(d2 - d3)), c = ratio_root(fabs(rest), fabs(d1 - d3));
    a *= (d2 > d3) == ((mid - one + 3) % 3 == 1) ? way : -way;
    Phase p = b > 0 && a != 0 ? (Phase){l[mid] / b, l[one] / a, fabs(l[three]) / c} : (Phase){0, 1, 1};
    Means means;
    find_means(&means, m1);
    bool far = length >= FAR;
    Phase whole = far ? (Phase){0, 1, 1} : phase_of(&means, length);
    real mean = far ? mean_far(&means, p, length, &whole, c / size, m) : mean_rate(&means, p, length, whole, c / size, m);
    real angle = h * (size * d3 + off / size * mean);
    p = phase_add(p, whole, m);
    real end[3], axis[3] = {0, 0, 0};
    end[one] = a * p.c;
    end[mid] = b * p.s;
    end[three] = way * c * p.d;
    axis[three] = way;
    vec3 l1 = {end[0], end[1], end[2]}, e = {axis[0], axis[1], axis[2]};
    quat home = quat_conjugate(to_axis(body, size, e)), on = quat_mul(quat_exp(vec3_scale(angle, e)), to_axis(l1, vec3_length(l1), e));
    *q = quat_unit(quat_mul(*q, quat_mul(home, on)));
    return true;
}

bool tumble_far(const mat3 *inv_inertia, quat *q, vec3 momentum, real h)
{
    vec3 d;
    mat3 axes;
    mat3_principal(*inv_inertia, &d, &axes);
    quat to = quat_from_matrix(axes), turned = quat_mul(*q, to);
    mat3 inverse = {{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}};
    int axis = tumble_axis(&inverse);
    if (axis >= 0)
        turned = tumble_about(&inverse, turned, momentum, h, axis);
    else if (!tumble(&inverse, &turned, momentum, h))
        return false;
    *q = quat_unit(quat_mul(turned, quat_conjugate(to)));
    return true;
}
