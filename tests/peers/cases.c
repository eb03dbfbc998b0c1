/* tests/peers/cases.c - suite A, scenes A01 to A14, for the peers: initial data, exact results, errors.
 *
 * The same data and the same measures as digbox is run with. Inclines are level ground under inclined gravity, which is
 * the same world seen by an observer who leans, and spares the peers the rounding of an inclined box.
 */
#include <math.h>
#include <string.h>
#include "suite.h"

static const double g = 9.81;
static const double radian = 3.14159265358979323846 / 180;

/* ---- building ---- */
static PeerBody *add(PeerScene *s, int kind, double a, double b, double c, double mass, double x, double y, double z)
{
    PeerBody *body = &s->body[s->bodies++];
    *body = (PeerBody){.kind = kind, .size = {a, b, c}, .mass = mass, .at = {x, y, z}, .turn = {1, 0, 0, 0}};
    return body;
}

static PeerBody *add_sphere(PeerScene *s, double radius, double mass, double x, double y, double z)
{
    return add(s, PEER_SPHERE, radius, 0, 0, mass, x, y, z);
}

static void add_ground(PeerScene *s)
{
    add(s, PEER_GROUND, 0, 0, 0, 0, 0, 0, 0);
}

static void lean(PeerScene *s, double angle)
{
    s->gravity[0] = g * sin(angle);
    s->gravity[2] = -g * cos(angle);
}

/* ---- vectors ---- */
static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double vector_distance(const double a[3], const double b[3])
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(d, d));
}

double angle_between(const double p[4], const double q[4])
{
    /* The vector part of conj(p) q, whose length is the sine of half the angle: exact for small angles, unlike acos. */
    double x = p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2];
    double y = p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1];
    double z = p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0];
    double w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
    return 2 * atan2(sqrt(x * x + y * y + z * z), fabs(w));
}

static const PeerState *last(const PeerRun *run, int body)
{
    return &run->sample[run->frames][body];
}

/* ---- A01: a spinning projectile; largest error of its place and orientation in 2 s ---- */
static void build_a01(PeerScene *s, int variant)
{
    (void)variant;
    PeerBody *ball = add_sphere(s, 0.1, 1, 0, 0, 0);
    memcpy(ball->v, (double[3]){10, 0, 10}, sizeof ball->v);
    memcpy(ball->spin, (double[3]){1, 2, 3}, sizeof ball->spin);
}

static double error_a01(const PeerRun *run, int variant)
{
    (void)variant;
    double worst = 0, spin = sqrt(14);                      /* spin: (1, 2, 3) */
    for (int k = 1; k <= run->frames; k++) {
        double t = k / 60.0, c = cos(spin * t / 2), s = sin(spin * t / 2) / spin;
        worst = fmax(worst, vector_distance(run->sample[k][0].at, (double[3]){10 * t, 0, 10 * t - g * t * t / 2}));
        worst = fmax(worst, angle_between(run->sample[k][0].turn, (double[4]){c, s, 2 * s, 3 * s}));
    }
    return worst;
}

/* ---- A02: a bouncing ball; rms of the height over 3 s ---- */
static void build_a02(PeerScene *s, int variant)
{
    (void)variant;
    add_sphere(s, 0.1, 1, 0, 0, 1.1);
    add_ground(s);
    s->restitution = 0.8;
}

static double bounce_height(double t)
{
    double up = 0, fall = sqrt(2 / g), flight = 2 * fall;   /* the gap: 1 m */
    t += fall;                                              /* as if it had been thrown up from the ground */
    for (up = g * fall; t > flight; up *= 0.8, flight *= 0.8)
        t -= flight;
    return 0.1 + up * t - g * t * t / 2;
}

static double error_a02(const PeerRun *run, int variant)
{
    (void)variant;
    double sum = 0;
    for (int k = 1; k <= run->frames; k++)
        sum += pow(run->sample[k][0].at[2] - bounce_height(k / 60.0), 2);
    return sqrt(sum / run->frames);
}

/* ---- A03: a block slides to rest, heading 30 degrees; final place, relative ---- */
static void build_a03(PeerScene *s, int variant)
{
    (void)variant;
    PeerBody *block = add(s, PEER_BOX, 0.5, 0.5, 0.1, 1, 0, 0, 0.1);
    block->v[0] = 4 * cos(30 * radian);
    block->v[1] = 4 * sin(30 * radian);
    add_ground(s);
    s->friction = 0.4;
}

static double error_a03(const PeerRun *run, int variant)
{
    (void)variant;
    double d = 16 / (2 * 0.4 * g);
    return vector_distance(last(run, 0)->at, (double[3]){d * cos(30 * radian), d * sin(30 * radian), 0.1}) / d;
}

/* ---- A04: a sphere rolls down 20 degrees; place after 2 s, relative ---- */
static void build_a04(PeerScene *s, int variant)
{
    (void)variant;
    add_sphere(s, 0.5, 1, 0, 0, 0.5);
    add_ground(s);
    lean(s, 20 * radian);
    s->friction = 0.5;
}

static double error_a04(const PeerRun *run, int variant)
{
    (void)variant;
    double way = 5.0 / 7 * g * sin(20 * radian) * 2;
    return vector_distance(last(run, 0)->at, (double[3]){way, 0, 0.5}) / way;
}

/* ---- A05a: a bowling ball slides, then rolls; largest error of its place in 2 s, relative to the way ---- */
static void build_a05(PeerScene *s, int variant)
{
    (void)variant;
    add_sphere(s, 0.1, 1, 0, 0, 0.1)->v[0] = 5;
    add_ground(s);
    s->friction = 0.2;
}

static double error_a05(const PeerRun *run, int variant)
{
    (void)variant;
    double worst = 0, rolls = 10 / (7 * 0.2 * g), way = 300 / (49 * 0.2 * g);   /* since when, and where */
    for (int k = 1; k <= run->frames; k++) {
        double t = k / 60.0, x = t < rolls ? 5 * t - 0.1 * g * t * t : way + 25.0 / 7 * (t - rolls);
        worst = fmax(worst, vector_distance(run->sample[k][0].at, (double[3]){x, 0, 0.1}));
    }
    return worst / 7.6629428529821715;
}

/* ---- A06a, A06d: a block 5 % below and above the limit of friction; creep in 5 s in metres, and place after 5 s, relative ---- */
static void build_slope(PeerScene *s, double ratio)
{
    add(s, PEER_BOX, 0.5, 0.5, 0.25, 1, 0, 0, 0.25);
    add_ground(s);
    lean(s, atan(ratio * 0.5));
    s->friction = 0.5;
}

static void build_a06a(PeerScene *s, int variant)
{
    (void)variant;
    build_slope(s, 0.95);
}

static double error_a06a(const PeerRun *run, int variant)
{
    (void)variant;
    return vector_distance(last(run, 0)->at, (double[3]){0, 0, 0.25});
}

static void build_a06d(PeerScene *s, int variant)
{
    (void)variant;
    build_slope(s, 1.05);
}

static double error_a06d(const PeerRun *run, int variant)
{
    (void)variant;
    double way = 2.7142979458875707;
    return vector_distance(last(run, 0)->at, (double[3]){way, 0, 0.25}) / way;
}

/* ---- A07, A08: one and two rods on hinges, let go level; largest error of the centre, of the tip ---- */
static void build_rods(PeerScene *s, int rods)
{
    for (int i = 0; i < rods; i++) {
        add(s, PEER_BOX, 0.5, 0.05, 0.05, 1, i + 0.5, 0, 0);
        s->hinge[s->hinges++] = (PeerHinge){.from = i - 1, .to = i, .at = {i, 0, 0}, .axis = {0, 1, 0}};
    }
}

static void build_a07(PeerScene *s, int variant)
{
    (void)variant;
    build_rods(s, 1);
}

static double error_a07(const PeerRun *run, int variant)
{
    (void)variant;
    const TwoAngles *exact = exact_pendulum(1);
    double worst = 0;
    for (int k = 1; k <= run->frames; k++) {
        double a = exact[k].angle[0];
        worst = fmax(worst, vector_distance(run->sample[k][0].at, (double[3]){sin(a) / 2, 0, -cos(a) / 2}));
    }
    return worst;
}

static void build_a08(PeerScene *s, int variant)
{
    (void)variant;
    build_rods(s, 2);
}

static double error_a08(const PeerRun *run, int variant)
{
    (void)variant;
    const TwoAngles *exact = exact_pendulum(2);
    double worst = 0;
    for (int k = 1; k <= run->frames; k++) {
        const PeerState *rod = &run->sample[k][1];
        const double *a = exact[k].angle, *q = rod->turn;
        double along[3] = {1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] + q[0] * q[3]), 2 * (q[1] * q[3] - q[0] * q[2])};
        double tip[3], want[3] = {sin(a[0]) + sin(a[1]), 0, -cos(a[0]) - cos(a[1])};
        for (int i = 0; i < 3; i++)
            tip[i] = rod->at[i] + along[i] / 2;
        worst = fmax(worst, vector_distance(tip, want));
    }
    return worst;
}

/* ---- A09: a free box that turns over; largest error of its orientation in 10 s ---- */
static void build_a09(PeerScene *s, int variant)
{
    (void)variant;
    PeerBody *box = add(s, PEER_BOX, 0.5, 0.3, 0.1, 1, 0, 0, 0);
    memcpy(box->spin, (double[3]){0.1, 5, 0.1}, sizeof box->spin);
    s->gravity[2] = 0;
}

static double error_a09(const PeerRun *run, int variant)
{
    (void)variant;
    const Orientation *exact = exact_rotor();
    double worst = 0;
    for (int k = 1; k <= run->frames; k++)
        worst = fmax(worst, angle_between(run->sample[k][0].turn, exact[k].turn));
    return worst;
}

/* ---- A10a, A10b: Newton's cradle, five touching spheres hit by one and by two; largest error of a velocity ---- */
static void build_a10(PeerScene *s, int arrive)
{
    for (int i = 0; i < 5; i++)
        add_sphere(s, 0.5, 1, i, 0, 0);
    for (int i = 0; i < arrive; i++)
        add_sphere(s, 0.5, 1, -1.5 - i, 0, 0)->v[0] = 1;
    s->gravity[2] = 0;
    s->restitution = 1;
}

static double error_a10(const PeerRun *run, int arrive)
{
    double worst = 0;
    for (int i = 0; i < 5 + arrive; i++) {
        double leaves = i < 5 && i >= 5 - arrive ? 1 : 0;
        worst = fmax(worst, vector_distance(last(run, i)->v, (double[3]){leaves, 0, 0}));
    }
    return worst;
}

/* ---- A10c: 1 kg on 3 kg, dropped together with a gap of 1e-6 m; largest error of the upper one's height in 1.5 s ---- */
static void build_a10c(PeerScene *s, int variant)
{
    (void)variant;
    add_sphere(s, 0.5, 1, 0, 0, 2.5 + 1e-6);
    add_sphere(s, 0.5, 3, 0, 0, 1.5);
    add_ground(s);
    s->restitution = 1;
}

static double error_a10c(const PeerRun *run, int variant)
{
    (void)variant;
    /* The lower one turns back at 1.5 m; they meet the time `late` after it, and the upper one leaves with twice the speed. */
    double v = sqrt(2 * g), late = 1e-6 / (2 * v), leaves = 2 * v - g * late, worst = 0;
    double meet = sqrt(2 / g) + late, from = 1.5 + 1e-6 - (v * late + g * late * late / 2);
    for (int k = 1; k <= run->frames; k++) {
        double t = k / 60.0, since = t - meet;
        double want = since < 0 ? 2.5 + 1e-6 - g * t * t / 2 : from + leaves * since - g * since * since / 2;
        worst = fmax(worst, fabs(run->sample[k][0].at[2] - want));
    }
    return worst;
}

/* ---- A11: a ball on a table that starts and stops; place after 3 s, relative ---- */
static void build_a11(PeerScene *s, int variant)
{
    (void)variant;
    add_sphere(s, 0.1, 1, 0, 0, 0.1);
    add(s, PEER_BOX, 10, 10, 0.5, 0, 0, 0, -0.5)->mover = 1;
    s->friction = 0.5;
}

static void drive_a11(double t, int variant)
{
    (void)variant;
    peer_move(1, (double[3]){t < 1 - 1e-9 ? 2 : 0, 0, 0}, (double[3]){0, 0, 0});
}

static double error_a11(const PeerRun *run, int variant)
{
    (void)variant;
    double rest[3] = {4.0 / 7, 0, 0.1};
    return vector_distance(last(run, 0)->at, rest) / rest[0];
}

/* ---- A12: a rocking block that hits flat; first and second peak of its tilt, relative ---- */
static const double block_lean = 0.24497866312686415;   /* atan(1/4): between the diagonal and an edge */

static void build_a12(PeerScene *s, int variant)
{
    (void)variant;
    double tilt = block_lean / 2, r = hypot(0.25, 1), a = block_lean - tilt;   /* about the edge at x = 0.25 */
    PeerBody *block = add(s, PEER_BOX, 0.25, 0.25, 1, 500, 0.25 - r * sin(a), 0, r * cos(a));
    block->turn[0] = cos(tilt / 2);
    block->turn[2] = sin(tilt / 2);
    add_ground(s);
    s->friction = 2;
}

/* Between impacts the block keeps its energy, so that any moment shows how far it will tilt. */
static double peak_shown(const PeerState *s)
{
    static const double zero[3] = {0};
    double speed = vector_distance(s->v, zero), spin = vector_distance(s->spin, zero);
    double per_mass = (speed * speed + 4.25 / 12 * spin * spin) / 2 + g * (s->at[2] - 1);
    return block_lean - acos(fmin(1, cos(block_lean) + per_mass / (g * hypot(0.25, 1))));
}

static double error_a12(const PeerRun *run, int variant)
{
    (void)variant;
    double first = peak_shown(&run->sample[54][0]) / 0.094736793120816732 - 1;      /* 0.9 s */
    double second = peak_shown(&run->sample[99][0]) / 0.075060698006574959 - 1;     /* 1.65 s */
    return fmax(fabs(first), fabs(second));
}

/* ---- A13a, A13b: two spheres collide, one spins; contact slips, contact sticks; largest error of a velocity ---- */
static void build_a13(PeerScene *s, int variant)
{
    PeerBody *a = add_sphere(s, 0.5, 1, 0, 0, 0);
    add_sphere(s, 0.5, 1, 1.3, 0, 0);
    a->v[0] = 1;
    a->spin[2] = variant == 0 ? 10 : 1;
    s->gravity[2] = 0;
    s->restitution = 0.5;
    s->friction = 0.3;
}

static double error_a13(const PeerRun *run, int variant)
{
    double along = 0.75, across = variant == 0 ? 0.225 : 1.0 / 14, twist = across * 0.5 / 0.1;
    const PeerState *a = last(run, 0), *b = last(run, 1);
    double error = fmax(vector_distance(a->v, (double[3]){1 - along, -across, 0}), vector_distance(b->v, (double[3]){along, across, 0}));
    error = fmax(error, 0.5 * vector_distance(a->spin, (double[3]){0, 0, (variant == 0 ? 10 : 1) - twist}));
    return fmax(error, 0.5 * vector_distance(b->spin, (double[3]){0, 0, -twist}));
}

/* ---- A14: a ball rolls on a turntable, in a circle; largest error of its place in 6 s ---- */
static void build_a14(PeerScene *s, int variant)
{
    (void)variant;
    PeerBody *ball = add_sphere(s, 0.1, 1, 1, 0, 0.1);
    ball->v[1] = 0.5;
    ball->spin[0] = (3.5 - 0.5) / 0.1;
    add(s, PEER_DISC, 3, 0.5, 0, 0, 0, 0, -0.5)->mover = 1;
    s->friction = 0.5;
}

static void drive_a14(double t, int variant)
{
    (void)variant;
    if (t == 0)
        peer_move(1, (double[3]){0, 0, 0}, (double[3]){0, 0, 3.5});
}

static double error_a14(const PeerRun *run, int variant)
{
    (void)variant;
    double worst = 0;
    for (int k = 1; k <= run->frames; k++) {
        double t = k / 60.0;
        worst = fmax(worst, vector_distance(run->sample[k][0].at, (double[3]){1 + 0.5 * (cos(t) - 1), 0.5 * sin(t), 0.1}));
    }
    return worst;
}

const PeerCase peer_cases[] = {
    /* id  variant s tracked conserves */
    {"A01",  0,  2, 1, PEER_ENERGY, build_a01, 0, error_a01},
    {"A02",  0,  3, 1, 0, build_a02, 0, error_a02},
    {"A03",  0,  2, 1, 0, build_a03, 0, error_a03},
    {"A04",  0,  2, 1, PEER_ENERGY, build_a04, 0, error_a04},
    {"A05a", 0,  2, 1, 0, build_a05, 0, error_a05},
    {"A06a", 0,  5, 1, 0, build_a06a, 0, error_a06a},
    {"A06d", 0,  5, 1, 0, build_a06d, 0, error_a06d},
    {"A07",  0, 10, 1, PEER_ENERGY, build_a07, 0, error_a07},
    {"A08",  0,  3, 2, PEER_ENERGY, build_a08, 0, error_a08},
    {"A09",  0, 10, 1, PEER_ENERGY | PEER_MOMENTUM, build_a09, 0, error_a09},
    {"A10a", 1,  2, 7, PEER_ENERGY | PEER_MOMENTUM, build_a10, 0, error_a10},
    {"A10b", 2,  2, 7, PEER_ENERGY | PEER_MOMENTUM, build_a10, 0, error_a10},
    {"A10c", 0, 1.5, 2, PEER_ENERGY, build_a10c, 0, error_a10c},
    {"A11",  0,  3, 1, 0, build_a11, drive_a11, error_a11},
    {"A12",  0, 2.5, 1, 0, build_a12, 0, error_a12},
    {"A13a", 0,  1, 2, PEER_MOMENTUM, build_a13, 0, error_a13},
    {"A13b", 1,  1, 2, PEER_MOMENTUM, build_a13, 0, error_a13},
    {"A14",  0,  6, 1, 0, build_a14, drive_a14, error_a14},
    {0}
};
