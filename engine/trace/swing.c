/* trace/swing.c - springs that swing fast against what else moves: how their errors count, and when they are not traced.
 *
 * A spring of stiffness k between bodies of mobility u (velocity per impulse along it) swings at sqrt(k u). A velocity error along it is
 * no more than an error of its swing: where that takes a millisecond, it has not a second to become a length.
 */
#include "trace/trace.h"

#define STIFF         6         /* rad of a spring's swing, or a damper's decay, in the frame: of fewer all is to be seen */
#define STIFF_TOUCHING 40      /* the same, where something touches: that is left to the sweep's implicit springs */
#define STABLE        3.3       /* over the rate of a damper or spring: the longest stable step of the pair */
#define STEP_EVALUATIONS 6      /* of the pair                                                */
#define RELATIVE_STEP 1000      /* the fifth power of a step, rad, over its error relative to the swing: measured */
#define SWING_PART    0.25      /* of the tolerance for errors of a swing: they add up over the swings that follow */
#define AIM           100       /* a plan's tolerance over the local error: see accuracy_local */

/* Of a soft row: what all its bodies move; how fast it lets them swing, and how fast it lets that die down. */
typedef struct Rates { real mobility, swing, decay; } Rates;

static Rates rates_of(const Group *g, const Row *r)
{
    real mobility = 0;
    for (int k = 0; k < r->count; k++)
        mobility += group_row_mobility(g, r, k);
    return (Rates){mobility, sqrt(r->stiffness * mobility), r->damping * mobility};
}

typedef struct Place { int joint, row; } Place;

/* From one soft row to the next; NULL: there is none. */
static const Row *next_soft(const Tracer *t, Place *at)
{
    for (; at->joint < t->g->joint_count; at->joint++, at->row = 0)
        while (at->row < t->row_count[at->joint]) {
            const Row *r = &t->rows[at->joint * JOINT_SLOTS + at->row++];
            if (r->kind == ROW_SOFT)
                return r;
        }
    return NULL;
}

static real unit_of(const Tracer *t, const Row *r) { return r->angular ? t->size : 1; }

/* ---- errors ---- */

real trace_fastest_swing(const Tracer *t)
{
    real most = 0;
    Place at = {0, 0};
    for (const Row *r = next_soft(t, &at); r; r = next_soft(t, &at))
        most = real_max(most, rates_of(t->g, r).swing);
    return most;
}

real trace_swing_error(const Tracer *t, State *e)
{
    const Group *g = t->g;
    real worst = 0;
    Place at = {0, 0};
    for (const Row *r = next_soft(t, &at); r; r = next_soft(t, &at)) {
        Rates rates = rates_of(g, r);
        real rate = 0;
        if (!(rates.swing > t->pace))
            continue;
        for (int k = 0; k < r->count; k++)
            if (trace_moves(t, r->body[k]))
                rate += vec3_dot(r->lin[k], e[r->body[k]].v) + vec3_dot(r->ang[k], mat3_mul_vec(g->mass[r->body[k]].ii, e[r->body[k]].l));
        for (int k = 0; k < r->count; k++) {
            if (!trace_moves(t, r->body[k]))
                continue;
            State *s = &e[r->body[k]];
            s->v = vec3_mad(s->v, -rate / rates.mobility * g->mass[r->body[k]].im, r->lin[k]);
            s->l = vec3_mad(s->l, -rate / rates.mobility, r->ang[k]);
        }
        worst = real_max(worst, unit_of(t, r) * fabs(rate) / (SWING_PART * rates.swing));
    }
    return worst;
}

/* ---- who follows them ---- */

/* Dampers whose rate keeps explicit steps so short that they would use up the budget. The rate is bounded by the sums of the rows of
 * D J M^-1 J^T (Gershgorin). */
static bool too_damped(const Tracer *t)
{
    const Group *g = t->g;
    real worst = 0, *rate = arena_zero(g->arena, (size_t)(g->body_count + 1) * sizeof *rate);
    for (int pass = 0; rate && pass < 2; pass++) {
        Place at = {0, 0};
        for (const Row *r = next_soft(t, &at); r; r = next_soft(t, &at)) {
            real sum = 0;
            for (int k = 0; k < r->count && r->damping > 0; k++) {
                int b = r->body[k];
                if (pass == 0 && b >= 0)
                    rate[b] += r->damping * group_row_mobility(g, r, k);
                sum += b >= 0 ? rate[b] : 0;
            }
            worst = real_max(worst, sum);
        }
    }
    return worst * t->end * STEP_EVALUATIONS > STABLE * t->work;
}

/* m or rad  How far a row still moves: a swing about where its forces balance, or, held back by a damper, the way there; a damper without a
 * spring is carried on for the frame. */
static real way_of(const Tracer *t, const Row *r, Rates rates)
{
    real rate = fabs(trace_row_rate(t, r)), push = fabs(trace_row_acceleration(t, r)), swing2 = rates.swing * rates.swing;
    if (swing2 > 0)
        return hypot(rate * real_max(1 / rates.swing, rates.decay / swing2), push / swing2);
    return t->end * (rate + push / rates.decay);
}

/* Evaluations of the frame, if a swing of so many radians is followed within the tolerance. */
static real work_for(const Tracer *t, real swing, real size)
{
    return STEP_EVALUATIONS * swing / real_min(STABLE, pow(RELATIVE_STEP * SWING_PART * t->tolerance / size, 0.2));
}

/* Where springs that swing many times within the frame, and dampers as fast, move by no more than the plan's tolerance, nobody can see
 * where in their swing they are, and the way that keeps their energy serves. Others are followed as long as the budget lasts. */
Stiffness trace_stiffness(Tracer *t)
{
    const Group *g = t->g;
    bool stiff = false, damped = false, beyond = false;
    Place at = {0, 0};
    for (const Row *r = next_soft(t, &at); r; r = next_soft(t, &at)) {
        Rates rates = rates_of(g, r);
        stiff = stiff || real_max(rates.swing, rates.decay) * t->end > STIFF;
        beyond = beyond || (t->touch_count > 0 && rates.swing * t->end > STIFF_TOUCHING);
        damped = damped || rates.decay > 0;
    }
    if (beyond)
        return STIFF_BEYOND;
    damped = damped && too_damped(t);
    if (!stiff && !damped)
        return STIFF_NOT;
    if (!trace_accelerate(t))
        return STIFF_BEYOND;
    real most = 0, work = 0;
    at = (Place){0, 0};
    for (const Row *r = next_soft(t, &at); r; r = next_soft(t, &at)) {
        Rates rates = rates_of(g, r);
        bool fast = rates.swing * t->end > STIFF;
        real size = fast || rates.decay > 0 ? unit_of(t, r) * way_of(t, r, rates) : 0;
        most = real_max(most, size);
        if (fast && size > 0)
            work = real_max(work, work_for(t, rates.swing * t->end, size));
    }
    if (most <= AIM * g->tolerance && t->touch_count == 0)
        return STIFF_UNSEEN;
    return damped || work > t->work ? STIFF_BEYOND : STIFF_NOT;
}
