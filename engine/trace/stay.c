/* trace/stay.c - are the rows of contacts those of before?
 *
 * Where balls roll on planes, and what does not turn slides on them, normals and levers stay what they are: so do the rows and their
 * matrix, and only what is missing at them changes. To see that costs a tenth of building and factoring them again.
 */
#include "trace/trace.h"

#define ROUNDING 2e-15          /* of unit vectors and quaternions, and, times the size, of levers */

static inline bool near_vec(vec3 a, vec3 b, real most)
{
    return vec3_length2(vec3_sub(a, b)) <= most * most;
}

static inline bool near_quat(quat a, quat b)
{
    return fabs(a.x - b.x) <= ROUNDING && fabs(a.y - b.y) <= ROUNDING && fabs(a.z - b.z) <= ROUNDING && fabs(a.w - b.w) <= ROUNDING;
}

/* Kinds in one number. */
static inline unsigned kinds_of(const Touching *c)
{
    return (unsigned)c->gate.presses | (unsigned)c->slip.grip << 1 | (unsigned)c->roll.grip << 3 | (unsigned)c->slip.locked << 5;
}

static inline vec3 lever_of(const Tracer *t, int body, vec3 at) { return trace_moves(t, body) ? vec3_sub(at, t->g->pos[body].x) : vec3_zero(); }

static inline bool same_lever(const Tracer *t, int body, vec3 at, vec3 noted)
{
    return !trace_moves(t, body) || near_vec(vec3_sub(at, t->g->pos[body].x), noted, ROUNDING * t->size);
}

static inline bool slides(const Cone *c) { return c->axes && c->grip != GRIP_STICK; }

static inline bool stays(const Tracer *t, const Touching *c, const Footing *f)
{
    return kinds_of(c) == f->kinds
        && (!c->gate.presses
            || (c->slip.weight == f->weight && near_vec(c->k.n, f->n, ROUNDING)
                && same_lever(t, c->a, c->k.at, f->lever[0]) && same_lever(t, c->b, c->k.at, f->lever[1])
                && (!slides(&c->slip) || near_vec(c->slip.d, f->slip, ROUNDING)) && (!slides(&c->roll) || near_vec(c->roll.d, f->roll, ROUNDING))));
}

/* Not of joints, and where something turns that shows it: the next rows are others. */
static bool may_stay(const Tracer *t)
{
    const Group *g = t->g;
    bool may = g->joint_count == 0 && !t->sys.redundant;
    for (int i = 0; i < g->moving_count && may; i++)
        may = g->member[i].round || vec3_length2(g->vel[i].w) * (t->end * t->end) <= ROUNDING * ROUNDING;
    return may;
}

void trace_note_rows(Tracer *t, bool regular)
{
    const Group *g = t->g;
    t->noted = regular && may_stay(t);
    if (!t->noted)
        return;
    for (int i = 0; i < g->moving_count; i++)
        t->noted_q[i] = g->pos[i].q;
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        t->footing[i] = (Footing){kinds_of(c), c->slip.weight, c->k.n, {lever_of(t, c->a, c->k.at), lever_of(t, c->b, c->k.at)}, c->slip.d, c->roll.d};
    }
}

bool trace_rows_stay(Tracer *t)
{
    const Group *g = t->g;
    for (int i = 0; i < g->moving_count && t->noted; i++)
        t->noted = g->member[i].round || near_quat(g->pos[i].q, t->noted_q[i]);
    for (int i = 0; i < t->touch_count && t->noted; i++)
        t->noted = stays(t, &t->touch[i], &t->footing[i]);
    for (int i = 0; i < t->sys.count && t->noted; i++) {
        Line *l = &t->sys.lines[i];
        l->drift = 0;
        for (int k = 0; k < l->points; k++) {
            const Kinematics *of = &t->touch[l->point[k]].k;
            l->drift += l->kind == LINE_NORMAL ? l->share[k] * of->drift_n : vec3_dot(l->e[k], of->drift);
        }
    }
    return t->noted;
}
