/* joint/strut.c - the strut: a member between two points that carries force along its line alone, tension as well as pressure.
 *
 *   N = EA (L - L0) / L0 + c dL/dt          N > 0 pulls the ends together
 *
 * with c = damping + tau EA / L0: a Kelvin-Voigt solid, whose strain goes back as e^(-t / tau) where no mass resists (Fung 1965,
 * ch. 1.9). It breaks by its share |N| / limit, with a limit of its own for pressure, as buckling asks for. Past its elastic limit
 * the rest length changes: memory[0] is the plastic elongation, m. A saw
 * cut takes its share of the section.
 */
#include <stdio.h>

#include "solve/joint_type.h"

enum { LINE = 0 };          /* slots */
enum { PLASTIC = 0 };       /* memory, m */

typedef struct Strut {
    vec3 at_a, at_b;            /* m    world points at creation    */
    real stiffness;             /* N    EA                          */
    real damping, relaxation;   /* N s/m, s                         */
    real length;                /* m    at rest                     */
    real pressed;               /* N    limit in compression; NaN = as in tension */
    real yield;                 /* N    elastic limit               */
    real cut;                   /* 1    share that is sawn through  */
    real radius;                /* m    as drawn                    */
} Strut;

static const dig_param strut_rows[] = {
    JOINT_END("at_a", "its end on a; default the centre of mass", Strut, at_a),
    JOINT_END("at_b", "its end on b; default the centre of mass", Strut, at_b),
    {.name = "stiffness", .kind = DIG_REAL, .unit = "N", .doc = "EA: modulus times section, force per strain", .fallback = NAN,
     .min = 0, .max = 1e15, .offset = offsetof(Strut, stiffness), .required = true},
    {.name = "damping", .kind = DIG_REAL, .unit = "N*s/m", .doc = "force per speed", .min = 0, .max = 1e12,
     .offset = offsetof(Strut, damping)},
    {.name = "relaxation", .kind = DIG_REAL, .unit = "s", .doc = "time in which 63 % of a strain goes back by itself", .min = 0,
     .max = 1e6, .offset = offsetof(Strut, relaxation)},
    {.name = "length", .kind = DIG_REAL, .unit = "m", .doc = "length without force; default as its ends lie", .fallback = NAN,
     .min = 1e-6, .max = 1e9, .offset = offsetof(Strut, length)},
    {.name = "breaks_pressed", .kind = DIG_REAL, .unit = "N", .doc = "breaks when pressed by more; default breaks_at",
     .fallback = NAN, .min = 1e-12, .max = INFINITY, .offset = offsetof(Strut, pressed)},
    {.name = "yield", .kind = DIG_REAL, .unit = "N", .doc = "elastic limit: what is strained by more stays so", .fallback = INFINITY,
     .min = 1e-12, .max = INFINITY, .offset = offsetof(Strut, yield)},
    {.name = "cut", .kind = DIG_REAL, .unit = "1", .doc = "share of the section that is sawn through", .min = 0, .max = 0.999,
     .offset = offsetof(Strut, cut)},
    {.name = "radius", .kind = DIG_REAL, .unit = "m", .doc = "as drawn; 0 = not at all", .min = 0, .max = 1e4,
     .offset = offsetof(Strut, radius)},
    {.name = NULL},
};

static dig_status check(void *params, const JointView *now, char *why, size_t capacity)
{
    Strut *s = params;
    if (isnan(s->length))
        s->length = joint_length(now);
    if (s->length >= 1e-6)
        return DIG_OK;
    snprintf(why, capacity, "its ends are %g m apart, which is no length for a strut: give length", s->length);
    return DIG_E_ARG;
}

static real rest_of(const JointView *j) { return ((const Strut *)j->params)->length + j->memory[PLASTIC]; }
static real rate_of(const Strut *s) { return s->stiffness * (1 - s->cut) / s->length; }        /* N/m */

static void rows(const JointView *j, RowList *out)
{
    const Strut *s = j->params;
    Row like;
    RowList one = {&like, 0, 1};
    real length, k = rate_of(s);
    if (rows_length(&one, j, ROW_SOFT, &length, LINE))      /* ends that coincide have no line */
        rows_spring(out, &like, length, &(DriveSpring){k, s->damping + k * s->relaxation, rest_of(j)}, LINE);
}

static real energy(const JointView *j)
{
    const Strut *s = j->params;
    return spring_energy(&(DriveSpring){rate_of(s), 0, rest_of(j)}, joint_length(j));
}

static real share(const JointView *j, vec3 force, vec3 couple)
{
    const Strut *s = j->params;
    (void)couple;
    real n = vec3_dot(force, vec3_unit_or(vec3_sub(j->b.p, j->a.p), vec3_zero()));
    real limit = n < 0 && !isnan(s->pressed) ? s->pressed : j->breaks_at > 0 ? j->breaks_at : INFINITY;
    return fabs(n) / (limit * (1 - s->cut));
}

static real settle(const JointView *j, vec3 force, vec3 couple)
{
    const Strut *s = j->params;
    (void)force;
    (void)couple;
    real strain = joint_length(j) - rest_of(j), most = s->yield * (1 - s->cut) / rate_of(s), before = energy(j);
    if (!(fabs(strain) > most))
        return 0;
    j->memory[PLASTIC] += copysign(fabs(strain) - most, strain);
    return before - energy(j);
}

const JointType joint_strut = {
    .name = "strut",
    .doc = "a bar that pulls and presses along its line",
    .params = strut_rows,
    .params_size = sizeof(Strut),
    .free_axes = 6,
    .no_axis = true,
    .two_anchors = true,
    .elastic = true,
    .check = check,
    .rows = rows,
    .coordinate = joint_length,
    .speed = joint_length_rate,
    .energy = energy,
    .share = share,
    .settle = settle,
};
