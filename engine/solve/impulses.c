/* solve/impulses.c - the impulses of a substep: by sweeps, and where these would take too long, of all rows at once.
 */
#include "solve/direction.h"

/* ---- where they begin ---- */

static void warm_start(Group *g)
{
    warm_points(g);
    for (int i = 0; i < g->roll_count; i++) {
        RollRow *r = &g->rolls[i];
        g->vel[r->a].w = vec3_sub(g->vel[r->a].w, mat3_mul_vec(g->mass[r->a].ii, r->j));
        g->vel[r->b].w = vec3_add(g->vel[r->b].w, mat3_mul_vec(g->mass[r->b].ii, r->j));
    }
    for (int i = 0; i < g->row_count; i++)
        joint_row_warm(g, &g->rows[i]);
}

Vel *group_velocities(const Group *g)
{
    Vel *copy = arena_alloc(g->arena, (size_t)g->body_count * sizeof *copy);
    return copy ? memcpy(copy, g->vel, (size_t)g->body_count * sizeof *copy) : NULL;
}

/* J, twice: of the motion before impulses, of what they change it by, and between the two. */
typedef struct Energies { real before, change, between; } Energies;

static void add_energies(const Group *g, int i, Vel before, Vel change, Energies *sum)
{
    const Member *m = &g->member[i];
    if (!m->moves)
        return;
    vec3 wb = quat_unrotate(g->pos[i].q, before.w), wc = quat_unrotate(g->pos[i].q, change.w);
    vec3 lb = mat3_mul_vec(*m->inertia, wb), lc = mat3_mul_vec(*m->inertia, wc);
    sum->before += m->mass * vec3_dot(before.v, before.v) + vec3_dot(wb, lb);
    sum->change += m->mass * vec3_dot(change.v, change.v) + vec3_dot(wc, lc);
    sum->between += m->mass * vec3_dot(before.v, change.v) + vec3_dot(wb, lc);
}

static void scale_guess(Group *g, real s)
{
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        r->jn *= s;
        r->jt[0] *= s;
        r->jt[1] *= s;
    }
    for (int i = 0; i < g->roll_count; i++)
        g->rolls[i].j = vec3_scale(s, g->rolls[i].j);
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p *= s;
}

#define GUESS_RISE 1.5          /* times the kinetic energy without it */

/* The impulses of the last substep are where the sweeps begin, and each sweep lessens the energy that impulses leave. After a blow, or
 * a substep that found no solution, that beginning may hold a hundred times the energy of the motion, and the sweeps that there are
 * leave much of it: joints with a body wedged between others then blow up. A guess that is so much worse than none is scaled by the
 * one factor after which the least energy is left; impulses so scaled stay in their cones. Not where all is solved at once: near the
 * solution light bodies under heavy ones show much energy too, and that solve gets there. */
dig_status group_warm_start(Group *g)
{
    if (g->joints_direct) {
        warm_start(g);
        return DIG_OK;
    }
    ArenaMark mark = arena_mark(g->arena);
    const Vel *before = group_velocities(g);
    if (!before)
        return DIG_E_MEMORY;
    warm_start(g);
    Energies e = {0};
    for (int i = 0; i < g->moving_count; i++)
        add_energies(g, i, before[i], (Vel){vec3_sub(g->vel[i].v, before[i].v), vec3_sub(g->vel[i].w, before[i].w)}, &e);
    if (e.before + 2 * e.between + e.change > GUESS_RISE * e.before) {
        real s = real_clamp(-e.between / e.change, 0, 1);
        memcpy(g->vel, before, (size_t)g->body_count * sizeof *before);
        scale_guess(g, s);
        warm_start(g);
    }
    arena_rewind(g->arena, mark);
    return DIG_OK;
}

/* ---- how long they are looked for ---- */

/* m/s: and what is nearly at rest must not be worse than this, for it adds up */
#define CREEP 1e-6

/* A step that took so many sweeps locates no more impacts: each would cost as many again. Or so many times all those of its plan: what
 * is that fine may take as many where nothing is wrong, and a blow that is not located there costs a thousandth of its energy. */
#define DEAR 4000
#define DEAR_PLANS 5

#define WORK      8000          /* sweeps times rows of a substep */
#define WORK_CALM 300000        /* the same of many that lie there: a few seconds later they sleep, if sweeps get there */

static int sweeps_for(const Group *g, int most)
{
    int rows = 2 * g->joint_count + 1;
    for (int i = 0; i < g->contact_count; i++)
        rows += g->contacts[i].live;
    return (int)real_clamp((real)(g->calm ? WORK_CALM : WORK) / rows, 4, most);
}

/* So many are tried; where they do not get there, all rows are solved at once, and checked by so many more. */
#define FIRST_SWEEPS 12
#define LAST_SWEEPS 3

#define FACTOR_COSTS 3          /* sweeps */

/* Would sweeps, as they have come along so far, get there for less than the last direct solve of this step took? */
static bool soon_there(const Group *g, real wanted)
{
    real rate = log(g->residual / g->residual_first) / FIRST_SWEEPS, more = log(wanted / g->residual) / rate;
    return rate < 0 && !g->stalled && more < FACTOR_COSTS * g->direct_factors;
}

/* In a heap of many that is solved from the inside each located impact costs as much as the substep does, and what does not bounce is as well stopped by
 * that: 40 boxes of 10,000:1 that land took 6.2 s of processor time in 2.5 s, now 3.4, no deeper. What bounces would make up energy: 0.1 % of it. */
static bool lands_as_many(const Group *g)
{
    bool bounces = false;
    for (int i = 0; i < g->pair_count && !bounces; i++)
        bounces = g->pairs[i].rub->restitution > 0;
    return !bounces && group_many(g);
}

static void solve_rows(Group *g)
{
    g->unsolved = g->from_inside = g->inside_failed = false;
    int sweeps = sweeps_for(g, g->plan->sweeps);
    real wanted = lies_uneasy(g) ? 0 : direct_wanted(g);
    if (g->joints_direct && wanted > 0 && direct_solve(g, wanted))
        return;
    int done = wanted > 0 ? int_min(sweeps, FIRST_SWEEPS) : sweeps;
    relax(g, done, wanted > 0 ? wanted : g->plan->residual);
    while (wanted > 0 && g->residual > wanted && done + FIRST_SWEEPS <= sweeps && soon_there(g, wanted)) {
        g->residual = 0;
        relax(g, FIRST_SWEEPS, wanted);
        done += FIRST_SWEEPS;
    }
    if (wanted > 0 && g->residual > wanted && direct_solve(g, wanted)) {
        if (!g->from_inside) {
            g->residual = 0;
            relax(g, LAST_SWEEPS, g->plan->residual);
        }
    } else if (g->residual > g->plan->residual && sweeps > done) {
        g->residual = 0;
        relax(g, sweeps - done, g->plan->residual);
    }
    bool creeps = !g->from_inside && !g->inside_failed && g->residual > (wanted > 0 ? CREEP : VELOCITY_COARSE);
    if (creeps && direct_rescue(g) && g->row_count == 0 && !g->from_inside) {
        g->residual = 0;
        relax(g, LAST_SWEEPS, g->plan->residual);
    }
    int more = sweeps_for(g, 10 * g->plan->sweeps) - sweeps;        /* none: what is left of it stays the residual */
    if (g->residual > VELOCITY_COARSE && !g->stalled && !g->from_inside && more > 0) {
        g->residual = 0;
        relax(g, more, VELOCITY_COARSE);
    }
    g->unsolved = g->residual > VELOCITY_COARSE && g->stalled && !g->from_inside;
    g->contradicts = g->contradicts || g->unsolved;
    if (g->unsolved || (g->from_inside && lands_as_many(g)) || g->sweeps > int_max(DEAR, DEAR_PLANS * g->plan->substeps * g->plan->sweeps))
        g->events_left = 0;
}

#define CALLS 2                 /* rounds after which all contacts are called that nothing pressed, should one more sink in */

void relax_group(Group *g)
{
    real worst = g->residual;
    int left = idle_leave(g);
    for (int round = 1, called = 1; called > 0; round++) {
        g->residual = 0;
        solve_rows(g);
        called = left > 0 ? idle_call(g, false) : 0;
        if (called > 0 && round == CALLS)
            called += idle_call(g, true);
        left -= called;
    }
    idle_call(g, true);
    g->residual = real_max(g->residual, worst);
}
