/* geom/wet.c - what part of a solid lies below a plane. */
#include "geom/wet.h"


Wet shape_wet(const Shape *s, vec3 normal, real offset)
{
    Wet sum = {0, {0, 0, 0}};
    MassProps whole;
    if (!s->type->wet || offset <= -s->outer)
        return sum;
    if (offset < s->outer) {
        s->type->wet(s, normal, offset, &sum);
        return sum;
    }
    s->type->mass(s, &whole);
    return (Wet){whole.volume, vec3_scale(whole.volume, whole.centre)};
}

/* ---- polyhedra ---- */

/* The signed tetrahedron from o to a triangle: volume D/6, its centre a quarter of the sum of its corners. */
static void add_triangle(Wet *sum, vec3 o, vec3 a, vec3 b, vec3 c)
{
    a = vec3_sub(a, o);
    b = vec3_sub(b, o);
    c = vec3_sub(c, o);
    real volume = vec3_dot(a, vec3_cross(b, c)) / 6;
    vec3 centre = vec3_mad(o, 0.25, vec3_add(a, vec3_add(b, c)));
    sum->volume += volume;
    sum->moment = vec3_mad(sum->moment, volume, centre);
}

/* Tetrahedra from a point of the plane: the cut itself, which lies in the plane, contributes nothing and is never built. */
void wet_face(Wet *sum, const vec3 *corners, int count, vec3 normal, real offset)
{
    vec3 o = vec3_scale(offset, normal), first = {0, 0, 0}, before = {0, 0, 0};
    int kept = 0;
    for (int i = 0; i < count; i++) {
        vec3 a = corners[i], b = corners[i + 1 < count ? i + 1 : 0], cut[2];
        real da = vec3_dot(normal, a) - offset, db = vec3_dot(normal, b) - offset;
        int n = 0;
        if (da <= 0)
            cut[n++] = a;
        if ((da <= 0) != (db <= 0))
            cut[n++] = vec3_lerp(a, b, da / (da - db));
        for (int k = 0; k < n; k++, kept++) {
            if (kept == 0)
                first = cut[k];
            else if (kept > 1)
                add_triangle(sum, o, first, before, cut[k]);
            before = cut[k];
        }
    }
}

/* ---- solids of revolution ---- */

/* Abscissas and weights of Gauss and Legendre with 16 points on -1..1 (Abramowitz & Stegun 1964, table 25.4): the positive half. */
static const real gauss[8][2] = {
    {0.0950125098376374402, 0.1894506104550684963}, {0.2816035507792589132, 0.1826034150449235889},
    {0.4580167776572273863, 0.1691565193950025382}, {0.6178762444026437484, 0.1495959888165767321},
    {0.7554044083550030339, 0.1246289712555338720}, {0.8656312023878317439, 0.0951585116824927848},
    {0.9445750230732325761, 0.0622535239386478929}, {0.9894009349916499326, 0.0271524594117540949},
};

static real radius_at(const Lathe *l, real y)
{
    return l->ball > 0 ? sqrt(real_max(0, l->ball * l->ball - (y - l->middle) * (y - l->middle))) : real_max(0, l->r0 + l->slope * y);
}

/* The plane cuts each disc along a chord, at x = c from the axis. */
typedef struct Chord { real slant, rise, offset; } Chord;      /* slant x + rise y <= offset */

static real chord_of(const Chord *c, real y, real r)
{
    real d = c->offset - c->rise * y;
    return d >= c->slant * r ? r : d <= -c->slant * r ? -r : d / c->slant;
}

/* Between two heights at which the chord enters or leaves the disc the integrand has roots of the distance to them, which the
 * substitution y = y0 + (y1 - y0) s^2 (3 - 2 s) takes away. */
static void add_slices(const Lathe *l, const Chord *c, real y0, real y1, real sum[3])
{
    for (int i = 0; i < 16; i++) {
        real x = i & 1 ? gauss[i / 2][0] : -gauss[i / 2][0], s = 0.5 * (1 + x);
        real y = y0 + (y1 - y0) * s * s * (3 - 2 * s), r = radius_at(l, y), at = chord_of(c, y, r);
        real half = sqrt(real_max(0, r * r - at * at)), weight = 3 * s * (1 - s) * (y1 - y0) * gauss[i / 2][1];
        real area = r > 0 ? r * r * acos(real_clamp(-at / r, -1, 1)) + at * half : 0;
        sum[0] += weight * area;
        sum[1] += weight * y * area;
        sum[2] -= weight * 2 / 3 * half * half * half;
    }
}

/* Heights at which the chord touches the disc, within the slice; at most two. */
static int touching(const Lathe *l, const Chord *c, real cut[2])
{
    real y[2] = {INFINITY, INFINITY};
    int n = 0;
    if (l->ball > 0) {
        real d = c->offset - c->rise * l->middle, root = l->ball * l->ball - d * d;
        if (!(root > 0))
            return 0;
        y[0] = l->middle + c->rise * d - c->slant * sqrt(root);
        y[1] = l->middle + c->rise * d + c->slant * sqrt(root);
    } else {
        y[0] = (c->offset - c->slant * l->r0) / (c->rise + c->slant * l->slope);
        y[1] = (c->offset + c->slant * l->r0) / (c->rise - c->slant * l->slope);
    }
    for (int i = 0; i < 2; i++)
        if (y[i] > l->y0 && y[i] < l->y1)
            cut[n++] = y[i];
    if (n == 2 && cut[0] > cut[1]) {
        real swap = cut[0];
        cut[0] = cut[1];
        cut[1] = swap;
    }
    return n;
}

void wet_lathe(Wet *sum, const Lathe *l, vec3 normal, real offset)
{
    Chord c = {sqrt(normal.x * normal.x + normal.z * normal.z), normal.y, offset};
    real cut[2], parts[3] = {0, 0, 0}, from = l->y0;
    int n = touching(l, &c, cut);
    for (int i = 0; i <= n; i++) {
        real to = i < n ? cut[i] : l->y1;
        add_slices(l, &c, from, to, parts);
        from = to;
    }
    real x = c.slant > 0 ? parts[2] / c.slant : 0;
    sum->volume += parts[0];
    sum->moment = vec3_add(sum->moment, (vec3){x * normal.x, parts[1], x * normal.z});
}
