/* effect/contact.c - bodies do not pass through each other: one row per contact point,
 *
 *     relative normal velocity >= target,   impulse >= 0.
 *
 * Where impacts are located in time, a point that would strike faster than the
 * closing speed gets no row: the substep is cut at its impact instead. Where
 * they are not (large groups, or the step's events are used up), restitution
 * is a target of the substep in which the gap closes.
 */
#include "effect/effect.h"
#include "solve/direction.h"

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    return g->pair_count > 0;
}

static int members(const Group *g)
{
    int n = 0;
    for (int i = 0; i < g->contact_count; i++)
        n += g->contacts[i].live;
    return n;
}

/* Normal velocity before the substep's forces. */
static real rate_before(const Group *g, const PointRow *r)
{
    const Member *a = &g->member[r->a], *b = &g->member[r->b];
    Vel va = a->moves ? a->start_vel : g->vel[r->a], vb = b->moves ? b->start_vel : g->vel[r->b];
    return vec3_dot(r->n.n, vec3_sub(vb.v, va.v)) + vec3_dot(r->n.aa, va.w) + vec3_dot(r->n.ab, vb.w);
}

/* Does the point need a row, and what velocity may it keep? */
static bool set_target(const Group *g, const GroupPair *q, PointRow *r, real gap)
{
    real predicted = dir_rate(g, &r->n, r->a, r->b);
    r->rate_before = rate_before(g, r);
    if (gap <= g->touch * q->size) {
        if (g->locate && g->events_left > 0 && r->rate_before > g->close_speed && gap > -g->touch * q->size)
            return false;               /* it leaves; should it come back in this substep, that is an impact */
        r->target = gap > 0 ? -gap / g->h : 0;
    } else {
        if (gap + g->h * real_min(predicted, 0) > 0.5 * gap + 1e-3 * q->size)
            return false;               /* not this substep */
        real closing = real_max(0, r->rate_before - predicted) / g->h;      /* m/s^2 */
        real strike = sqrt(r->rate_before * r->rate_before + 2 * closing * gap);
        if (g->locate && g->events_left > 0 && strike > g->close_speed)
            return false;               /* an impact: it will be located */
        r->target = -gap / g->h;
    }
    bool located = g->locate && g->events_left > 0;
    real slow = 2 * vec3_length(g->gravity) * g->h;
    if (!located && q->restitution > 0 && -r->rate_before > slow && gap + g->h * predicted < 0)
        r->target = real_max(r->target, -q->restitution * r->rate_before);
    return true;
}

static void warm(const Group *g, PointRow *r, const PointMemory *m)
{
    r->jn = m->normal * g->h;
    r->jt[0] = g->h * vec3_dot(m->tangent, r->t[0].n);
    r->jt[1] = g->h * vec3_dot(m->tangent, r->t[1].n);
}

static dig_status rows(void *state, Group *g)
{
    (void)state;
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        GroupPair *q = &g->pairs[c->pair];
        if (!c->live || (!g->member[c->a].moves && !g->member[c->b].moves))
            continue;
        for (int k = 0; k < c->manifold.count; k++) {
            PointRow *r = &g->points[g->point_count];
            point_row_make(g, r, i, k);
            if (!set_target(g, q, r, c->manifold.points[k].gap))
                continue;
            warm(g, r, &c->memory[k]);
            q->approach = real_max(q->approach, -r->rate_before);
            g->point_count++;
        }
    }
    return DIG_OK;
}

const EffectType effect_contact = {
    .name = "contact",
    .law = "gap >= 0, normal force >= 0, gap * force = 0; v+ = -e v- at impacts",
    .cite = "stewart1996",
    .wanted = wanted,
    .members = members,
    .run = {[STAGE_ROWS] = rows},
};
