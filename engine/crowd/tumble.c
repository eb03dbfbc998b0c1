/* crowd/tumble.c - few bodies that tumble over each other, advanced as many are.
 *
 * What falls over each other has its blows located, one after the other, and is solved to the last digit after each: fifteen stones of a
 * falling arch took 30 ms a frame. Nobody can tell where such a heap ends, and a crowd takes a hundredth of that. What stands, lands or
 * creeps is not for it: there loads must be carried without overlap. So a group is a crowd while some of its pairs are fast, in a step in
 * which sweeps turn out dear, and after one (solve/toil.c). What comes out is looked at: a step that leaves something deep, or wins energy,
 * is put back, and done again in shorter pieces; then as for any few.
 */
#include "crowd/crowd.h"

#include "crowd/system.h"

#define LEAST    3              /* bodies */
#define FAST     0.25           /* of what the smaller one of a pair gets by falling half its reach: a thirtieth of that height */
#define PART     4              /* pairs, of which one is fast: an arch whose hinges turn in earnest (four of 16) is among them, one that stands is not */
#define STOUT    0.1            /* its least thickness over its reach: of thinner things overlaps of a crowd show */
/* The step is cut into so many, and if that is not good into more. In one, stones of 9 cm were left up to 2.7 % deep, and 0.08 J of 700 were
 * made when that was lifted; in four it is up to 0.5 %. What is left is put apart in place (way.c). */
#define PIECES   4
#define PIECES_MOST 16
#define DEEP     0.003           /* of the thickness of the thinner one */
#define GAIN     1e-7           /* of the kinetic energy: single precision */

static bool was_dear(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->world->bodies.data[g->member[i].slot].toil.dear > 0)
            return true;
    return false;
}

/* What a crowd may take, but for light things among heavy ones, and nothing but gravity that moves it: then it is known whether energy was won. Not beside a
 * mover, which would stir as a crowd what is swept when it stands still, over and over. */
static bool is_plain(const Group *g)
{
    real light = INFINITY, heavy = 0;
    if (g->own || g->driven || g->varies || g->joint_count > 0 || g->push_count > 0 || g->world->region_count > 0 || !crowd_allows(g->world))
        return false;
    for (int i = 0; i < g->moving_count; i++) {
        if (g->member[i].integrator != DIG_AUTO)
            return false;
        light = real_min(light, g->member[i].mass);
        heavy = real_max(heavy, g->member[i].mass);
    }
    return heavy <= CROWD_MASS_RATIO * light;
}

static bool is_stout(const Form *s) { return s->shape.inner >= STOUT * s->shape.outer || !isfinite(s->shape.outer); }

static bool may_move(const Member *m) { return m->moves || m->dormant; }

/* m^2/s^2  How fast the smaller one moves against the other, its rim included, squared. */
static real pair_speed2(const Group *g, const GroupPair *q)
{
    const Member *a = &g->member[q->a], *b = &g->member[q->b];
    bool first = may_move(a) && (!may_move(b) || a->outer <= b->outer);
    int small = first ? q->a : q->b, large = first ? q->b : q->a;
    const Vel *v = &g->vel[small], *of = &g->vel[large];
    vec3 speed = vec3_sub(vec3_sub(v->v, of->v), vec3_cross(of->w, vec3_sub(g->pos[small].x, g->pos[large].x)));
    real rim = g->member[small].outer;
    return vec3_length2(speed) + rim * rim * vec3_length2(vec3_sub(v->w, of->w));
}

static bool is_fast(const Group *g, const GroupPair *q)
{
    const Member *a = &g->member[q->a], *b = &g->member[q->b];
    real small = !may_move(a) ? b->outer : !may_move(b) ? a->outer : real_min(a->outer, b->outer);
    real pull = real_max(a->moves ? a->pull : 0, b->moves ? b->pull : 0);
    return !(pair_speed2(g, q) <= FAST * FAST * small * pull);
}

/* May the middle of one get past that of the other in so many seconds? It would be pushed out at the far side, and nobody would see it. */
static bool runs_past(const Group *g, const GroupPair *q, real dt)
{
    real thick = q->on_a->shape.inner + q->on_b->shape.inner;
    return !(pair_speed2(g, q) * dt * dt <= thick * thick);
}

static bool any_runs_past(const Group *g, real dt)
{
    for (int i = 0; i < g->pair_count; i++)
        if (runs_past(g, &g->pairs[i], dt))
            return true;
    return false;
}

static bool tumbles(const Group *g)
{
    int fast = 0;
    if (g->crowd || g->calm || g->moving_count < LEAST || g->plan->crowd_bodies == INT32_MAX || !is_plain(g))
        return false;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!is_stout(q->on_a) || !is_stout(q->on_b) || q->rub->restitution > CROWD_LIVELY)
            return false;
        fast += is_fast(g, q);
    }
    return PART * fast >= g->pair_count && !any_runs_past(g, g->world->def.step / PIECES_MOST);
}

/* Of the poses as they are, found anew: what the rows of a crowd saw of their contacts is straight, and they are of some only. */
static bool ends_deep(Group *g, real dt)
{
    bool deep = false;
    group_touch(g, dt, true);
    g->penetration = 0;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        real most = DEEP * crowd_thickness(&g->pairs[c->pair]);
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            g->penetration = real_max(g->penetration, -c->manifold.points[k].gap);
            deep = deep || !(c->manifold.points[k].gap >= -most);
        }
    }
    return deep;
}

/* Has it more energy than its weights gave it? */
static bool gains(const Group *g, const GroupKept *before, real kinetic)
{
    real given = 0;
    for (int i = 0; i < g->moving_count; i++)
        given += vec3_dot(g->member[i].force, vec3_sub(g->pos[i].x, before->pos[i].x));
    return !(group_kinetic(g) - given <= (1 + GAIN) * kinetic);
}

static dig_status advance_as_crowd(Group *g, real dt, const GroupKept *before)
{
    real kinetic = group_kinetic(g);
    for (int pieces = PIECES; pieces <= PIECES_MOST; pieces *= PIECES_MOST / PIECES) {
        if (any_runs_past(g, dt / pieces))
            continue;
        g->pieces = pieces;
        DIG_TRY(way_crowd.advance(g, dt));
        g->dear = true;
        if (g->woke || !(ends_deep(g, dt) || gains(g, before, kinetic) || any_runs_past(g, dt / pieces)))
            return DIG_OK;
        group_put_back(g, before);
    }
    g->handed_on = true;
    return DIG_OK;
}

/* What is spare of the arena is used up by a try. */
static dig_status keep(Group *g, GroupKept *before)
{
    g->spare = NULL;
    return group_keep(g, before) ? DIG_OK : DIG_E_MEMORY;
}

static bool suits(const Group *g) { return was_dear(g) && tumbles(g); }

static dig_status advance(Group *g, real dt)
{
    GroupKept before;
    DIG_TRY(keep(g, &before));
    return advance_as_crowd(g, dt, &before);
}

const Way way_tumble = {.name = "tumble", .tally = WAY_SWEPT, .suits = suits, .advance = advance};

static bool suits_late(const Group *g) { return !was_dear(g) && tumbles(g); }

static dig_status advance_late(Group *g, real dt)
{
    GroupKept before;
    DIG_TRY(keep(g, &before));
    g->toil_most = TOIL_DEAR;
    DIG_TRY(sweep_advance(g, dt));
    if (g->woke || group_toil(g) <= g->toil_most)
        return DIG_OK;
    group_put_back(g, &before);
    return advance_as_crowd(g, dt, &before);
}

const Way way_tumble_late = {.name = "sweep", .tally = WAY_SWEPT, .suits = suits_late, .advance = advance_late, .inertias = true};
