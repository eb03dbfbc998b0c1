/* lua/cost_compare.c - how far two runs are apart, whether twins part, and what follows from it. */

#include "cost.h"

#include <math.h>

/* Twins that differ by more than this part of a body's size, or by less than ten times what they began with. */
static const real PARTED = 1e-3, GROWING = 10;

/* ---- rows of the same body after the same frame step ------------------------------ */

typedef struct Pairing { const CostRun *a, *b; int i, j, missing; } Pairing;

static int order(const CostRow *p, const CostRow *q)
{
    if (p->step != q->step)
        return p->step < q->step ? -1 : 1;
    if (p->slot != q->slot)
        return p->slot < q->slot ? -1 : 1;
    return p->gen < q->gen ? -1 : p->gen > q->gen;
}

static bool next_pair(Pairing *p, const CostRow **a, const CostRow **b)
{
    while (p->i < p->a->count && p->j < p->b->count) {
        *a = &p->a->rows[p->i];
        *b = &p->b->rows[p->j];
        int o = order(*a, *b);
        p->i += o <= 0;
        p->j += o >= 0;
        if (o == 0)
            return true;
        p->missing += (*a)->step == (*b)->step;     /* other frames are no loss: one run kept fewer */
    }
    return false;
}

static real distance(vec3 a, vec3 b)
{
    real x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return sqrt(x * x + y * y + z * z);
}

/* rad, of the rotation that leads from a to b; from the vector part of conj(a) b, which keeps small angles exact. */
static real angle_between(quat a, quat b)
{
    real x = a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y;
    real y = a.w * b.y - a.y * b.w - a.z * b.x + a.x * b.z;
    real z = a.w * b.z - a.z * b.w - a.x * b.y + a.y * b.x;
    real w = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
    return 2 * atan2(sqrt(x * x + y * y + z * z), fabs(w));
}

/* ---- errors ------------------------------------------------------------------------- */

void cost_compare(const CostRun *run, const CostRun *reference, real end, real within, CostError *error)
{
    Pairing p = {run, reference, 0, 0, 0};
    const CostRow *a, *b;
    real squares = 0;
    *error = (CostError){.until = INFINITY};
    while (next_pair(&p, &a, &b)) {
        real time = b->step * reference->frame;
        if (time > end + 1e-9)
            break;
        real far = distance(a->position, b->position), turn = angle_between(a->rotation, b->rotation);
        real off = fmax(far, turn * b->size);
        error->position = fmax(error->position, far);
        error->rotation = fmax(error->rotation, turn);
        error->max = fmax(error->max, off);
        if (off > within && time < error->until)
            error->until = time;
        squares += off * off;
        error->compared++;
    }
    error->rms = error->compared > 0 ? sqrt(squares / error->compared) : 0;
    error->missing = p.missing;
}

/* ---- twins ---------------------------------------------------------------------------- */

void cost_twins(const CostRun *one, const CostRun *two, CostTwins *twins)
{
    Pairing p = {one, two, 0, 0, 0};
    const CostRow *a, *b;
    uint32_t step = 0, frames = 0;
    real worst = 0, first = 0, since = 0, since_value = 0;
    *twins = (CostTwins){.known = true, .horizon = INFINITY};
    for (bool more = true; more && !twins->apart; ) {
        more = next_pair(&p, &a, &b);
        if (!more || b->step != step) {         /* a frame is complete */
            real time = step * two->frame;
            if (step == 0)
                first = worst;
            if (step == 0 || worst <= GROWING * first) {
                since = time;
                since_value = worst;
                frames = 0;
            }
            frames++;
            twins->last = worst;
            twins->seen = time;
            if (worst > PARTED) {
                twins->apart = true;
                twins->horizon = time;
                twins->jump = frames <= 3;
                twins->factor = pow(worst / fmax(since_value, 1e-300), 1 / fmax(time - since, 1e-300));
            }
            worst = 0;
        }
        if (more) {
            step = b->step;
            real off = fmax(distance(a->position, b->position), angle_between(a->rotation, b->rotation) * b->size);
            worst = fmax(worst, off / b->size);
        }
    }
}

/* ---- what follows ------------------------------------------------------------------------ */

real cost_ms_per_second(const CostRun *run)
{
    real time = run->steps * run->frame;
    return time > 0 ? 1e3 * run->cpu / time : 0;
}

static bool is_complete(const CostSetting *s)
{
    return s->run && s->run->end == COST_COMPLETE;
}

int cost_cheapest(const Cost *c)
{
    int best = -1, complete = 0;
    for (int i = 0; i < c->count; i++)
        complete += is_complete(&c->settings[i]);
    /* The reference proves nothing about itself: something that differs from it must come that near. */
    if (complete < 2 || c->agreement > c->o->within || c->compared <= 0)
        return -1;
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        if (!is_complete(s) || s->error.max > c->o->within || s->error.missing > 0)
            continue;
        /* Plans come first: a number must be cheaper by more than the noise of timing. */
        if (best < 0 || cost_ms_per_second(s->run) < (s->plan ? 1 : 0.9) * cost_ms_per_second(c->settings[best].run))
            best = i;
    }
    return best;
}

real cost_of_tenth(const Cost *c)
{
    real n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, low = INFINITY, high = 0;
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        if (!is_complete(s) || s->error.max <= 0 || s->run->cpu <= 0)
            continue;
        real x = -log10(s->error.max), y = log10(s->run->cpu);
        n++;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        low = fmin(low, s->error.max);
        high = fmax(high, s->error.max);
    }
    if (n < 3 || high < 10 * low)
        return 0;
    real slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    return slope > 0 ? pow(10, slope) : 0;
}

void cost_judge(Cost *c)
{
    const CostRun *reference = c->settings[c->reference].run;
    real end = reference->steps * reference->frame;
    c->compared = end;
    if (c->twins.known)         /* a twin may have used up its budget shortly before */
        c->compared = fmin(end, c->twins.seen);
    if (c->twins.apart)         /* the last frame at which they were together */
        c->compared = fmax(0, c->twins.horizon - reference->frame * reference->stride);
    c->agreement = -1;
    for (int i = 0; i < c->count; i++) {
        CostSetting *s = &c->settings[i];
        if (!is_complete(s))
            continue;
        cost_compare(s->run, reference, c->compared, c->o->within, &s->error);
        if (i != c->reference && s->error.max > 0 && (c->agreement < 0 || s->error.max < c->agreement))
            c->agreement = s->error.max;
    }
}
