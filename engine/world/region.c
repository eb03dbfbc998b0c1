/* world/region.c - what holds at a place, and who crosses borders. */
#include "world/region.h"

real region_rate(const World *w, vec3 at)
{
    real rate = 1;
    for (int i = 0; i < w->regions.count; i++)
        if (region_holds(&w->regions.data[i], at))
            rate *= w->regions.data[i].laws.time_rate;
    return rate;
}

real region_conduct(const World *w, vec3 at)
{
    real factor = 1;
    for (int i = 0; i < w->regions.count; i++)
        if (region_holds(&w->regions.data[i], at))
            factor *= w->regions.data[i].laws.conduct;
    return factor;
}

real region_fall(const World *w, const Body *b, vec3 at)
{
    vec3 gravity = w->def.gravity;
    for (int i = 0; i < w->regions.count; i++)
        if (!isnan(w->regions.data[i].laws.gravity.x) && region_holds(&w->regions.data[i], at))
            gravity = w->regions.data[i].laws.gravity;
    return vec3_length(gravity) * b->rate * b->rate;
}

/* The velocity by the time inside stays: a product and a quotient of numbers that a crossing back takes in the other order. */
static void take_rate(World *w, Body *b)
{
    real rate = region_rate(w, b->x);
    if (b->kind != DIG_DYNAMIC || rate == b->rate)
        return;
    b->v = vec3_scale(rate, vec3_scale(1 / b->rate, b->v));
    b->w = vec3_scale(rate, vec3_scale(1 / b->rate, b->w));
    b->rate = rate;
}

/* 0..1  Where a straight way crosses the border, of its length; one end is inside, the other is not. */
static real crossing(const Region *r, vec3 from, vec3 to)
{
    bool was = region_holds(r, from);
    real before = 0, after = 1;
    for (int i = 0; i < 40; i++) {
        real middle = 0.5 * (before + after);
        if (region_holds(r, vec3_mad(from, middle, vec3_sub(to, from))) == was)
            before = middle;
        else
            after = middle;
    }
    return after;
}

void region_cross(World *w, uint32_t body, vec3 from, real took)
{
    Body *b = &w->bodies.data[body];
    for (int i = 0; i < w->regions.count && b->kind == DIG_DYNAMIC; i++) {
        const Region *r = &w->regions.data[i];
        bool was = region_holds(r, from), is = region_holds(r, b->x);
        dig_event *e = was == is ? NULL : event_post(w, is ? DIG_EVENT_ENTERED : DIG_EVENT_LEFT, body, NONE);
        if (e) {
            e->time -= took > 0 ? (1 - crossing(r, from, b->x)) * took : 0;
            e->region = (dig_region){(uint32_t)i, r->gen};
            e->point = b->x;
        }
    }
    take_rate(w, b);
}

void region_cross_all(World *w)
{
    for (int i = 0; i < w->awake.count && w->region_count > 0; i++)
        region_cross(w, w->awake.data[i], w->bodies.data[w->awake.data[i]].prev_x, w->def.step);
}

void region_changed(World *w)
{
    for (int i = 0; i < w->bodies.count; i++)
        if (w->bodies.data[i].alive)
            take_rate(w, &w->bodies.data[i]);
}

uint64_t region_hash(const Region *r, uint64_t h)
{
    const dig_region_def *laws = &r->laws;
    h = hash_vec3(hash_quat(hash_vec3(h, r->at.p), r->at.q), laws->gravity);
    h = hash_real(hash_real(h, laws->drag), laws->friction_scale);
    return hash_real(hash_real(hash_real(h, laws->restitution_scale), laws->conduct), laws->time_rate);
}
