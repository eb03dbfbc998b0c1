/* effect/rolling.c - rolling resistance: a torque against rolling, at most (coefficient * radius) times the normal force. */
#include "effect/effect.h"
#include "solve/direction.h"

static bool rolls(const GroupPair *q) { return q->rolling > 0 && (q->sa->rolling > 0 || q->sb->rolling > 0); }

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    for (int i = 0; i < g->pair_count; i++)
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

/* Radius at which the pair rolls: that of the only round one, or of both together (1/r = 1/ra + 1/rb). */
static real rolling_radius(const GroupPair *q)
{
    real a = q->sa->rolling, b = q->sb->rolling;
    return a > 0 && b > 0 ? a * b / (a + b) : real_max(a, b);
}

static dig_status rows(void *state, Group *g)
{
    (void)state;
    g->roll_count = 0;
    for (int i = 0; i < g->point_count;) {
        int contact = g->points[i].contact, first = i;
        while (i < g->point_count && g->points[i].contact == contact)
            i++;
        const GroupContact *c = &g->contacts[contact];
        const GroupPair *q = &g->pairs[c->pair];
        mat3 k = mat3_add(g->mass[c->a].ii, g->mass[c->b].ii);
        if (!rolls(q) || !(mat3_det(k) > 0))
            continue;
        RollRow *r = &g->rolls[g->roll_count++];
        *r = (RollRow){.contact = contact, .first = first, .count = i - first, .a = c->a, .b = c->b, .inv_k = mat3_inverse(k)};
        r->reach = rolling_radius(q);
        r->lever = q->rolling * r->reach;
        r->j = vec3_scale(g->h, c->rolling);
    }
    return DIG_OK;
}

const EffectType effect_rolling = {
    .name = "rolling",
    .law = "|tau| <= c R F_n, against the relative spin",
    .cite = "coulomb1785",
    .wanted = wanted,
    .members = members,
    .run = {[STAGE_ROWS] = rows},
};
