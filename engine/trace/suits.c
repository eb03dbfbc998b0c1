/* trace/suits.c - which groups the traced way takes. */
#include "base/forest.h"
#include "trace/trace.h"

#define STIFF         40        /* rad of a spring's swing in the frame                       */
#define STABLE        3.3       /* over the rate of a damper: the longest stable step of the pair */
#define STEP_EVALUATIONS 6      /* of the pair                                                */

#define FAST_LOOP  0.3          /* rad in a step */
#define LOOP_BODIES 128         /* more than any plan traces */

/* Do the joints close a loop, by themselves or through what does not move? Loops pass through singular positions; the way that
 * holds joints in place passes them better than this one, which holds accelerations, unless they turn fast against the step. */
static bool has_loop(const Group *g)
{
    int parent[LOOP_BODIES + 1];
    if (g->moving_count > LOOP_BODIES)
        return true;
    for (int i = 0; i <= g->moving_count; i++)
        parent[i] = i;
    for (int j = 0; j < g->joint_count; j++) {
        if (g->joints[j].view.type->free_axes == 6 || g->joints[j].view.type->couples)
            continue;
        int a = g->joints[j].a, b = g->joints[j].b, n = g->moving_count;
        a = forest_root(parent, a >= 0 && a < n && g->member[a].moves ? a : n);
        b = forest_root(parent, b >= 0 && b < n && g->member[b].moves ? b : n);
        if (a == b)
            return true;
        parent[a] = b;
    }
    return false;
}

static real fastest_spin(const Group *g)
{
    real w = 0;
    for (int i = 0; i < g->moving_count; i++)
        w = real_max(w, vec3_length2(g->vel[i].w));
    return sqrt(w);
}

bool trace_suits(const Group *g)
{
    const AccuracyPlan *p = g->plan;
    if (g->moving_count > p->trace_bodies || g->decay_friction || g->trace_wait > 0 || !g->may_trace)
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].integrator != DIG_AUTO)
            return false;
    if (g->pair_count == 0 && has_loop(g) && fastest_spin(g) * g->world->def.step < FAST_LOOP)
        return false;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!feature_kind_known(q->sa) || !feature_kind_known(q->sb) || q->contacts != 1)
            return false;
    }
    return true;
}

/* kg^-1 or (kg m^2)^-1  What a row moves of its k-th body, per unit of impulse. */
static real mobility_of(const Group *g, const Row *r, int k)
{
    int b = r->body[k];
    if (b < 0)
        return 0;
    return g->mass[b].im * vec3_length2(r->lin[k]) + vec3_dot(r->ang[k], mat3_mul_vec(g->mass[b].ii, r->ang[k]));
}

/* Dampers whose rate keeps explicit steps so short that they would use up the budget. The rate is bounded by the sums of the rows of
 * D J M^-1 J^T (Gershgorin). */
static bool too_damped(const Tracer *t)
{
    const Group *g = t->g;
    real worst = 0, *rate = arena_zero(g->arena, (size_t)(g->body_count + 1) * sizeof *rate);
    for (int pass = 0; rate && pass < 2; pass++)
        for (int j = 0; j < g->joint_count; j++)
            for (int i = 0; i < t->row_count[j]; i++) {
                const Row *r = &t->rows[j * JOINT_SLOTS + i];
                real sum = 0;
                for (int k = 0; k < r->count && r->kind == ROW_SOFT && r->damping > 0; k++) {
                    int b = r->body[k];
                    if (pass == 0 && b >= 0)
                        rate[b] += r->damping * mobility_of(g, r, k);
                    sum += b >= 0 ? rate[b] : 0;
                }
                worst = real_max(worst, sum);
            }
    return worst * t->end * STEP_EVALUATIONS > STABLE * t->work;
}

/* Springs that swing many times within the step are not followed, but kept in their energy: that is another way's work. */
bool trace_too_stiff(const Tracer *t)
{
    const Group *g = t->g;
    bool damped = false;
    for (int j = 0; j < g->joint_count; j++)
        for (int i = 0; i < t->row_count[j]; i++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + i];
            real mobility = 0;
            for (int k = 0; k < r->count && r->kind == ROW_SOFT; k++)
                mobility += mobility_of(g, r, k);
            if (sqrt(r->stiffness * mobility) * t->end > STIFF)
                return true;
            damped = damped || (r->kind == ROW_SOFT && r->damping > 0);
        }
    return damped && too_damped(t);
}
