/* world/check.c - every invariant of the state, for tests and debug builds. */
#include "world/joint.h"

static dig_status check_bodies(const World *w)
{
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive)
            continue;
        if (!vec3_finite(b->x) || !vec3_finite(b->v) || !vec3_finite(b->w) || !quat_finite(b->q))
            return world_fail(w, DIG_E_FINITE, "%s has a non-finite position or velocity", BODY_TEXT(w, b));
        if (!(fabs(quat_norm2(b->q) - 1) < 1e-12))
            return world_fail(w, DIG_E_ARG, "%s: |q|^2 - 1 = %g", BODY_TEXT(w, b), quat_norm2(b->q) - 1);
        if ((b->kind == DIG_DYNAMIC) != graph_has_node(w->graph, (uint32_t)i))
            return world_fail(w, DIG_E_ARG, "%s: dynamic bodies, and only they, are in a DIG", BODY_TEXT(w, b));
        if (b->kind == DIG_DYNAMIC && b->awake && !b->listed)
            return world_fail(w, DIG_E_ARG, "%s: awake = %d but listed = %d", BODY_TEXT(w, b), b->awake, b->listed);
        if (b->kind == DIG_DYNAMIC && !b->awake && (vec3_length2(b->v) > 0 || vec3_length2(b->w) > 0))
            return world_fail(w, DIG_E_ARG, "%s sleeps but moves", BODY_TEXT(w, b));
    }
    return DIG_OK;
}

static dig_status check_pairs(const World *w)
{
    int memories = w->memories.count - w->free_memories.count;
    for (int i = 0; i < w->pairs.count; i++) {
        const Pair *p = &w->pairs.data[i];
        if (!p->alive)
            continue;
        memories -= p->memory != NONE;
        if (p->memory != NONE && !p->pieces && w->memories.data[p->memory].cache.kind == 0)
            return world_fail(w, DIG_E_ARG, "pair %d has a memory, but no hint", i);
        if (p->smooth != !(pair_rub(w, p).friction > 0))
            return world_fail(w, DIG_E_ARG, "pair %d does not know that it is %s", i, p->smooth ? "rough" : "smooth");
        if (!w->solids.data[p->solid_a].alive || !w->solids.data[p->solid_b].alive || p->solid_a >= p->solid_b)
            return world_fail(w, DIG_E_ARG, "pair %d joins solids %u and %u, one of them gone", i, p->solid_a, p->solid_b);
        uint32_t found;
        if (!pair_find(w, p->solid_a, p->solid_b, &found) || found != (uint32_t)i)
            return world_fail(w, DIG_E_ARG, "pair %d is not in the index", i);
        if (p->dynamic_a != body_dynamic(w, p->body_a) || p->dynamic_b != body_dynamic(w, p->body_b))
            return world_fail(w, DIG_E_ARG, "pair %d does not know the kinds of its bodies", i);
        for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next)
            if (w->contacts.data[c].count > (w->contacts.data[c].more == NONE ? 1 : MANIFOLD_POINTS))
                return world_fail(w, DIG_E_ARG, "pair %d has a contact of %d points without room for them", i, w->contacts.data[c].count);
    }
    if (memories != 0)
        return world_fail(w, DIG_E_ARG, "%d memories of pairs belong to none", memories);
    return DIG_OK;
}

/* Every touch has as many touching pairs as it says, and a link while it lasts. */
static dig_status check_touches(const World *w)
{
    for (int i = 0; i < w->touches.count; i++) {
        const Touch *t = &w->touches.data[i];
        if (!t->alive)
            continue;
        int pairs = 0;
        for (int k = 0; k < w->pairs.count; k++) {
            const Pair *p = &w->pairs.data[k];
            uint8_t wall = p->alive ? w->solids.data[p->solid_a].wall | w->solids.data[p->solid_b].wall : 0;
            bool same = (p->body_a == t->body_a && p->body_b == t->body_b) || (p->body_a == t->body_b && p->body_b == t->body_a);
            pairs += p->alive && p->touching && same && wall == t->wall;
        }
        if (pairs != t->pairs)
            return world_fail(w, DIG_E_ARG, "touch %d of slots %u and %u counts %d pairs, there are %d", i, t->body_a, t->body_b, t->pairs, pairs);
        if (t->pairs == 0 && !t->brief)
            return world_fail(w, DIG_E_ARG, "touch %d of slots %u and %u is over but was not ended", i, t->body_a, t->body_b);
        if (t->pairs > 0 && t->link == NONE && t->body_b != NONE)
            return world_fail(w, DIG_E_ARG, "touch %d of slots %u and %u has no link", i, t->body_a, t->body_b);
    }
    return DIG_OK;
}

static dig_status check_tally(const World *w)
{
    Tally t = world_tally(w);
    if (w->tally.touching != t.touching || w->tally.smooth != t.smooth || w->tally.shapes != t.shapes)
        return world_fail(w, DIG_E_ARG, "the tally has %d touches, %d smooth pairs, %zu bytes of shapes; there are %d, %d, %zu", w->tally.touching,
                          w->tally.smooth, w->tally.shapes, t.touching, t.smooth, t.shapes);
    return DIG_OK;
}

dig_status world_check(const World *w)
{
    DIG_TRY(check_bodies(w));
    DIG_TRY(check_pairs(w));
    DIG_TRY(check_touches(w));
    DIG_TRY(check_tally(w));
    if (!graph_check(w->graph))
        return world_fail(w, DIG_E_ARG, "the DIGs are not the connected components of the links");
    for (uint32_t i = 1; i < DIG_LAYERS; i++)
        if (!layer_check(&w->layers[i]))
            return world_fail(w, DIG_E_ARG, "the %s layer is broken", dig_layer_name(i));
    if (!mail_in_order(&w->mail))
        return world_fail(w, DIG_E_ARG, "the queue of messages is not in order");
    if (!tree_check(&w->tree))
        return world_fail(w, DIG_E_ARG, "the tree of boxes is broken");
    return DIG_OK;
}
