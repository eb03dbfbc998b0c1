/* effect/rolling.c - rolling resistance: a torque against rolling, at most (coefficient * radius) times the normal force. */
#include "effect/effect.h"
#include "solve/direction.h"

static bool rolls(const GroupPair *q) { return q->rub->rolling > 0 && (q->on_a->shape.rolling > 0 || q->on_b->shape.rolling > 0); }

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    for (int i = 0; i < g->pair_count && g->pairs_roll; i++)
        if (rolls(&g->pairs[i]))
            return true;
    return false;
}

static int members(const Group *g)
{
    int n = 0;
    for (int i = 0; i < g->contact_count; i++)
        n += g->contacts[i].live && rolls(&g->pairs[g->contacts[i].pair]);
    return n;
}

static EffectCause cause(const Group *g)
{
    int i = 0;
    while (i + 1 < g->pair_count && !rolls(&g->pairs[i]))
        i++;
    return effect_cause_pair(g, &g->pairs[i]);
}

/* Radius at which the pair rolls: that of the only round one, or of both together (1/r = 1/ra + 1/rb). */
static real rolling_radius(const GroupPair *q)
{
    real a = q->on_a->shape.rolling, b = q->on_b->shape.rolling;
    return a > 0 && b > 0 ? a * b / (a + b) : real_max(a, b);
}

/* In a planar world only the spin about the dead axis is left. */
static bool invert(const Group *g, mat3 k, mat3 *inverse)
{
    if (!g->planar) {
        *inverse = mat3_det(k) > 0 ? mat3_inverse(k) : mat3_zero();
        return mat3_det(k) > 0;
    }
    real s = g->planar == 1 ? k.r0.x : g->planar == 2 ? k.r1.y : k.r2.z;
    real i = s > 0 ? 1 / s : 0;
    *inverse = mat3_diagonal((vec3){g->planar == 1 ? i : 0, g->planar == 2 ? i : 0, g->planar == 3 ? i : 0});
    return s > 0;
}

static dig_status rows(const EffectSlot *e, Group *g)
{
    (void)e;
    g->roll_count = 0;
    for (int i = 0; i < g->point_count;) {
        int contact = g->points[i].contact, first = i;
        while (i < g->point_count && g->points[i].contact == contact)
            i++;
        const GroupContact *c = &g->contacts[contact];
        const GroupPair *q = &g->pairs[c->pair];
        mat3 inverse;
        if (!rolls(q) || !invert(g, mat3_add(g->mass[c->a].ii, g->mass[c->b].ii), &inverse))
            continue;
        RollRow *r = &g->rolls[g->roll_count++];
        *r = (RollRow){.contact = contact, .first = first, .count = i - first, .a = c->a, .b = c->b, .inv_k = inverse};
        r->reach = rolling_radius(q);
        r->lever = q->rub->rolling * r->reach;
        r->j = vec3_scale(g->h, contact_rolling(g, c));
    }
    return DIG_OK;
}

const EffectType effect_rolling = {
    .name = "rolling",
    .law = "|tau| <= c R F_n, against the relative spin",
    .cite = "coulomb1785",
    .wanted = wanted,
    .stands = LAW_ROLLING,
    .members = members,
    .cause = cause,
    .run = {[STAGE_ROWS] = rows},
};
