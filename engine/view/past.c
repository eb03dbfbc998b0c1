/* view/past.c - keeps what was before a moment. */
#include "view/past.h"

#include "world/world.h"

#include <math.h>
#include <stdlib.h>

void past_open(Past *p, uint64_t first, real step)
{
    real stride = round(1 / (step * (PAST_POINTS - 1)));
    *p = (Past){.first = first, .step = step, .stride = stride > 1 ? (uint64_t)stride : 1, .row_stride = 1};
}

void past_close(Past *p)
{
    for (int i = 0; i < PAST_POINTS - 1; i++)
        list_close(&p->moments[i].points);
    list_close(&p->now.points);
    list_close(&p->flat);
    p->begun = false;
    p->row_count = 0;
}

/* ---- points ---- */

static PastMoment *place_of(Past *p, uint64_t step) { return &p->moments[step / p->stride % (PAST_POINTS - 1)]; }

static void forget(Past *p)
{
    for (int i = 0; i < PAST_POINTS - 1; i++)
        p->moments[i].points.count = 0;
    p->row_count = 0;
    p->row_stride = 1;
}

/* What was now, if its step has a place in the ring, goes there when a later step comes. */
static void keep_now(Past *p)
{
    if (p->now.step % p->stride != 0)
        return;
    PastMoment *to = place_of(p, p->now.step), was = *to;
    *to = p->now;
    p->now = was;
}

void past_begin(Past *p, uint64_t step)
{
    if (p->begun && step < p->now.step) {
        forget(p);
        p->first = step;
    } else if (p->begun && step > p->now.step) {
        keep_now(p);
    }
    p->now.step = step;
    p->now.points.count = 0;
    p->begun = step >= p->first;
}

dig_status past_point(Past *p, uint32_t slot, uint32_t gen, vec3 x)
{
    while (p->begun && (uint32_t)p->now.points.count <= slot)
        DIG_TRY(list_push(&p->now.points, NULL));
    if (p->begun)
        p->now.points.data[slot] = (PastPoint){x, gen, 0};
    return DIG_OK;
}

dig_status past_take(Past *p, const dig_world *w)
{
    past_begin(p, w->steps);
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (b->alive && b->kind == DIG_DYNAMIC)
            DIG_TRY(past_point(p, (uint32_t)i, b->gen, b->x));
    }
    return DIG_OK;
}

bool past_wants_points(const Past *p, uint64_t step, uint64_t last)
{
    return step == last || (step % p->stride == 0 && step + p->stride * PAST_POINTS > last);
}

/* ---- energies ---- */

/* Rows lie at multiples of row_stride after the first step; every other one goes when there are too many. */
static void thin(Past *p)
{
    int count = 0;
    p->row_stride *= 2;
    for (int i = 0; i < p->row_count; i++)
        if ((p->rows[i].step - p->first) % p->row_stride == 0)
            p->rows[count++] = p->rows[i];
    p->row_count = count;
}

void past_energy(Past *p, uint64_t step, const dig_energy *e)
{
    if (step <= p->first)
        return;
    if (p->row_count > 0 && (p->rows[p->row_count - 1].step - p->first) % p->row_stride != 0)
        p->row_count--;         /* it was there as the last one only */
    while ((step - p->first) / p->row_stride >= PAST_ROWS)
        thin(p);
    p->rows[p->row_count++] = (PastRow){step, {e->kinetic, e->potential, e->elastic, e->heat + e->lost}};
}

/* ---- for pictures ---- */

/* The moment `back` points before now, the last being 1; NULL: it was not seen. */
static const PastMoment *moment_before(Past *p, int back)
{
    uint64_t last = p->now.step / p->stride * p->stride;        /* the last multiple, before now */
    last -= last == p->now.step && last > 0 ? p->stride : 0;
    uint64_t ago = (uint64_t)(back - 1) * p->stride;
    if (last == p->now.step || ago > last || last - ago < p->first)
        return NULL;
    const PastMoment *m = place_of(p, last - ago);
    return m->step == last - ago && m->points.count > 0 ? m : NULL;
}

static dig_status flatten(Past *p)
{
    int count = p->now.points.count, row = 3 * PAST_POINTS;
    DIG_TRY(list_reserve(&p->flat, count * row, NULL));
    for (int back = 0; back < PAST_POINTS; back++) {
        const PastMoment *m = back == 0 ? &p->now : moment_before(p, back);
        for (int i = 0; i < count; i++) {
            bool there = m && i < m->points.count && p->now.points.data[i].gen != 0 && m->points.data[i].gen == p->now.points.data[i].gen;
            const vec3 x = there ? m->points.data[i].x : (vec3){NAN, NAN, NAN};
            memcpy(p->flat.data + (size_t)i * (size_t)row + 3 * (size_t)(PAST_POINTS - 1 - back), &x, sizeof x);
        }
    }
    return DIG_OK;
}

dig_status past_show(Past *p, ViewPast *out)
{
    DIG_TRY(flatten(p));
    uint64_t beyond = p->now.step % p->stride;
    *out = (ViewPast){.trails = p->flat.data, .trail_count = p->now.points.count, .trail_length = PAST_POINTS,
                      .head = beyond == 0 ? 1 : (real)beyond / (real)p->stride, .begin = (real)p->first * p->step};
    for (int i = 0; i < p->row_count; i++) {
        p->table[i][0] = (real)(p->rows[i].step - p->first) * p->step;
        memcpy(&p->table[i][1], p->rows[i].energy, sizeof p->rows[i].energy);
    }
    out->energies = &p->table[0][0];
    out->energy_count = p->row_count;
    return DIG_OK;
}
