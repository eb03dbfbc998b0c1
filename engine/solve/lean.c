/* solve/lean.c - does what is light carry what is heavy?
 *
 * Where it does, an error that is nothing to what is heavy throws what is light, and solves are dear (direct.c). It does not where a bucket of 2 kg
 * holds balls of 57 g: whatever it does to them comes back to it. What is light, and touches through what is light, is one heap; a heap carries
 * a load only from one thing to another: from what is heavy to other such, or to what does not move. */
#include "solve/group.h"

#define MANY    2               /* times as many as are solved whatever it costs: fewer are cheap enough */
#define NOBODY  (-1)
#define GROUND  (-2)            /* what does not move; the others are the group's bodies */

typedef struct Lean {
    int  *up, *on;              /* by member: towards the first of its heap; of that, what the heap touches; of what is heavy, GROUND where it stands */
    real  light;                /* kg  lighter is light */
} Lean;

static int heap_of(const Lean *l, int i)
{
    while (l->up[i] != i) {
        l->up[i] = l->up[l->up[i]];
        i = l->up[i];
    }
    return i;
}

static bool is_light(const Group *g, const Lean *l, int i) { return g->member[i].moves && g->member[i].mass < l->light; }

/* Notes what the heap touches. Does that make two things, of which one is heavy? */
static bool bears(Lean *l, int heap, int thing)
{
    if (l->on[heap] == NOBODY)
        l->on[heap] = thing;
    return thing != NOBODY && l->on[heap] != thing;
}

/* Of two that touch: heaps become one, or get something that they touch. True: that one now bears something heavy. */
static bool join(const Group *g, Lean *l, int a, int b)
{
    bool light_a = is_light(g, l, a), light_b = is_light(g, l, b);
    if (!light_a && !light_b) {
        if (!g->member[a].moves || !g->member[b].moves)
            l->on[g->member[a].moves ? a : b] = GROUND;
        return false;
    }
    if (light_a && light_b) {
        int first = heap_of(l, int_min(a, b)), other = heap_of(l, int_max(a, b)), on = l->on[other];
        l->up[other] = first;
        return first != other && bears(l, first, on);
    }
    int heavy = light_a ? b : a;
    return bears(l, heap_of(l, light_a ? a : b), g->member[heavy].moves ? heavy : GROUND);
}

/* Is what is light alike enough to carry itself? */
static bool alike(const Group *g, const Lean *l)
{
    real least = INFINITY, most = 0;
    for (int i = 0; i < g->moving_count; i++)
        if (is_light(g, l, i)) {
            least = real_min(least, g->member[i].mass);
            most = real_max(most, g->member[i].mass);
        }
    return most <= HEAVY * least;
}

/* Does all that is heavy touch what does not move? What comes down may come to lie on anything. */
static bool heavy_stand(const Group *g, const Lean *l)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && !is_light(g, l, i) && l->on[i] != GROUND)
            return false;
    return true;
}

static bool nothing_heavy_on_light(const Group *g, Lean *l, bool known)
{
    for (int i = 0; i < g->body_count; i++) {
        l->up[i] = i;
        l->on[i] = NOBODY;
    }
    if (!alike(g, l))
        return false;
    for (int i = 0; !known && i < g->pair_count; i++)
        if (g->pairs[i].was_touching && join(g, l, g->pairs[i].a, g->pairs[i].b))
            return false;
    for (int i = 0; known && i < g->contact_count; i++)
        if (g->contacts[i].live && join(g, l, g->contacts[i].a, g->contacts[i].b))
            return false;
    return heavy_stand(g, l);
}

bool group_leans(const Group *g) { return group_top_heavy(g) && !g->only_holds; }

/* Without memory for it nothing is known: as if it leant. */
void lean_find(Group *g, bool known)
{
    g->only_holds = false;
    real ratio = group_mass_ratio(g);
    if (g->joint_count > 0 || g->moving_count <= (int64_t)MANY * g->plan->toil_bodies || !(ratio > HEAVY && ratio <= STIRRED))
        return;
    real heaviest = 0;
    for (int i = 0; i < g->moving_count; i++)
        heaviest = g->member[i].moves ? real_max(heaviest, g->member[i].mass) : heaviest;
    ArenaMark mark = arena_mark(g->arena);
    Lean l = {.light = heaviest / HEAVY};
    l.up = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *l.up);
    l.on = arena_alloc(g->arena, (size_t)(g->body_count + 1) * sizeof *l.on);
    g->only_holds = l.up && l.on && nothing_heavy_on_light(g, &l, known);
    arena_rewind(g->arena, mark);
}
