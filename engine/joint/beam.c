/* joint/beam.c - the elastic joint between two rigid pieces of a beam (rigid finite elements: Wittbrodt, Adamiec-Wojcik & Wojciech
 * 2006, Dynamics of Flexible Multibody Systems, ch. 2).
 *
 * A beam of many rigid pieces bends in the joints between them alone. One joint stands for the length l of the beam, from the middle of
 * one piece to that of the next (at a clamped end: half a piece):
 *
 *   N = EA x / l        M = EI angle / l about u and n        T = GJ angle / l about the axis        no shear (Euler-Bernoulli)
 *
 * all with the same relaxation time (Kelvin-Voigt, as in joint/strut.c). The section is a rectangle, height along u, width along n. A
 * saw cut takes the share `cut` of the height: A (1 - cut), I (1 - cut)^3 and Z (1 - cut)^2 for bending about n. The joint
 * breaks where  |N| / A + |M_u| / Z_u + |M_n| / Z_n  exceeds the strength.
 *
 * memory: [0], [1] plastic angles about u and n.
 */
#include "solve/joint_type.h"

enum { AXIAL = 0, SHEAR = 1, TWIST = 3, BEND = 4 };     /* slots; BEND + i is about u, n */

typedef struct Beam {
    vec3 up;                    /* height is measured this way */
    real length;                /* m                           */
    real width, height;         /* m                           */
    real modulus, shear;        /* Pa                          */
    real strength, yield;       /* Pa                          */
    real cut;                   /* 1                           */
    real relaxation;            /* s                           */
} Beam;

static const dig_param beam_rows[] = {
    {.name = "up", .kind = DIG_DIR, .unit = "1", .doc = "which way the height of the section is; default any across the axis",
     .fallback = NAN, .offset = offsetof(Beam, up)},
    {.name = "length", .kind = DIG_REAL, .unit = "m", .doc = "length of the beam that bends here", .fallback = NAN, .min = 1e-6,
     .max = 1e6, .offset = offsetof(Beam, length), .required = true},
    {.name = "width", .kind = DIG_REAL, .unit = "m", .doc = "of the section, across up", .fallback = NAN, .min = 1e-6, .max = 1e4,
     .offset = offsetof(Beam, width), .required = true},
    {.name = "height", .kind = DIG_REAL, .unit = "m", .doc = "of the section, along up", .fallback = NAN, .min = 1e-6, .max = 1e4,
     .offset = offsetof(Beam, height), .required = true},
    {.name = "modulus", .kind = DIG_REAL, .unit = "Pa", .doc = "Young's modulus", .fallback = NAN, .min = 1, .max = 1e15,
     .offset = offsetof(Beam, modulus), .required = true},
    {.name = "shear_modulus", .kind = DIG_REAL, .unit = "Pa", .doc = "for torsion; default modulus / 2.6", .fallback = NAN, .min = 1,
     .max = 1e15, .offset = offsetof(Beam, shear)},
    {.name = "strength", .kind = DIG_REAL, .unit = "Pa", .doc = "stress at which it breaks", .fallback = INFINITY, .min = 1e-6,
     .max = INFINITY, .offset = offsetof(Beam, strength)},
    {.name = "yield", .kind = DIG_REAL, .unit = "Pa", .doc = "stress above which a bend stays", .fallback = INFINITY, .min = 1e-6,
     .max = INFINITY, .offset = offsetof(Beam, yield)},
    {.name = "cut", .kind = DIG_REAL, .unit = "1", .doc = "share of the height that is sawn through", .min = 0, .max = 0.999,
     .offset = offsetof(Beam, cut)},
    {.name = "relaxation", .kind = DIG_REAL, .unit = "s", .doc = "time in which 63 % of a strain goes back by itself", .min = 0,
     .max = 1e6, .offset = offsetof(Beam, relaxation)},
    {.name = NULL},
};

typedef struct Section { real area, inertia[2], modulus[2], torsion; } Section;     /* m^2, m^4, m^3 about u and n, m^4 */

/* Torsion of a rectangle a >= b: J = a b^3 (1/3 - 0.21 b/a (1 - (b/a)^4 / 12)), good to 0.5 % (Young & Budynas 2002, table 10.7). */
static Section section_of(const Beam *s)
{
    real h = s->height * (1 - s->cut), b = s->width, most = real_max(h, b), least = real_min(h, b), slim = least / most;
    return (Section){
        .area = b * h,
        .inertia = {h * b * b * b / 12, b * h * h * h / 12},
        .modulus = {h * b * b / 6, b * h * h / 6},
        .torsion = most * least * least * least * (1.0 / 3 - 0.21 * slim * (1 - slim * slim * slim * slim / 12)),
    };
}

static real shear_of(const Beam *s) { return isnan(s->shear) ? s->modulus / 2.6 : s->shear; }

/* rad  About u (i = 0) or n. */
static real bend_of(const JointView *j, int i)
{
    JointView v = joint_turned(j, i + 1);
    real angle = 0;
    return joint_angle(&v, &angle);
}

static void add_spring(RowList *out, const Row *like, real x, real k, real relaxation, int slot)
{
    rows_spring(out, like, x, &(DriveSpring){k, k * relaxation, 0}, slot);
}

static void rows(const JointView *j, RowList *out)
{
    const Beam *s = j->params;
    Section c = section_of(s);
    Row like;
    RowList one = {&like, 0, 1};
    rows_translation(&one, j, ROW_SOFT, j->b.axis, AXIAL);
    add_spring(out, &like, like.error, s->modulus * c.area / s->length, s->relaxation, AXIAL);
    rows_along(out, j, j->b.u, SHEAR);
    rows_along(out, j, j->b.n, SHEAR + 1);
    for (int turn = 0; turn < 3; turn++) {
        JointView v = joint_turned(j, turn);
        real angle = 0, k = turn == 0 ? shear_of(s) * c.torsion : s->modulus * c.inertia[turn - 1];
        one.count = 0;
        rows_twist(&one, &v, ROW_SOFT, TWIST + turn);
        add_spring(out, &like, joint_angle(&v, &angle) - (turn > 0 ? j->memory[turn - 1] : 0), k / s->length, s->relaxation, TWIST + turn);
    }
}

static real energy(const JointView *j)
{
    const Beam *s = j->params;
    Section c = section_of(s);
    real x = vec3_dot(j->b.axis, vec3_sub(j->a.p, j->b.p)), twist = 0, sum = s->modulus * c.area * x * x;
    joint_angle(j, &twist);
    sum += shear_of(s) * c.torsion * twist * twist;
    for (int i = 0; i < 2; i++) {
        real bend = bend_of(j, i) - j->memory[i];
        sum += s->modulus * c.inertia[i] * bend * bend;
    }
    return 0.5 * sum / s->length;
}

static real share(const JointView *j, vec3 force, vec3 couple)
{
    const Beam *s = j->params;
    Section c = section_of(s);
    real stress = fabs(vec3_dot(force, j->b.axis)) / c.area + fabs(vec3_dot(couple, j->b.u)) / c.modulus[0] +
                  fabs(vec3_dot(couple, j->b.n)) / c.modulus[1];
    real plain = j->breaks_at > 0 ? vec3_length(force) / j->breaks_at : 0;
    return real_max(stress / s->strength, plain);
}

static real settle(const JointView *j, vec3 force, vec3 couple)
{
    const Beam *s = j->params;
    Section c = section_of(s);
    real before = energy(j);
    bool yields = false;
    (void)force;
    (void)couple;
    for (int i = 0; i < 2; i++) {
        real bend = bend_of(j, i) - j->memory[i], most = s->yield * c.modulus[i] * s->length / (s->modulus * c.inertia[i]);
        if (!(fabs(bend) > most))
            continue;
        j->memory[i] += copysign(fabs(bend) - most, bend);
        yields = true;
    }
    return yields ? before - energy(j) : 0;
}

/* The angle of bending, both ways together. */
static real coordinate(const JointView *j) { return hypot(bend_of(j, 0), bend_of(j, 1)); }

const JointType joint_beam = {
    .name = "beam",
    .doc = "an elastic section of a beam between two rigid pieces",
    .params = beam_rows,
    .params_size = sizeof(Beam),
    .fuses = true,
    .free_axes = 4,
    .has_up = true,
    .elastic = true,
    .rows = rows,
    .coordinate = coordinate,
    .angular = true,
    .energy = energy,
    .share = share,
    .settle = settle,
};
