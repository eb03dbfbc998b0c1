/* trace/patch.c - the rows of one contact: its points act as one patch.
 *
 * Four corners on a face hold a body in three ways only (along the normal, about two axes), and when they stick in three more
 * (along the face, about the normal). One row a way instead of one a point makes the system regular, and spreads the forces
 * over the points by a rule that does not depend on rounding:
 *   normal forces      lie on a plane over the patch, f = a + b x + c y: the distribution of least norm;
 *   tangential forces  are those of a rigid turn of the patch, weighted with the normal forces.
 */
#include "trace/trace.h"

#define FLAT    1e-9        /* 1 - cosine: points of such normals make one patch                */
#define THIN    1e-6        /* of the patch's size: a way that narrow is none                   */

typedef struct Patch {
    const Touching *touch;
    int  count, point[MANIFOLD_POINTS];         /* that press */
    vec3 centre, n, t[2];
    vec3 arm[MANIFOLD_POINTS];                  /* m  from the centre */
} Patch;

/* A row whose rate is sum_i e_i . u_i and whose force on b at point i is c_i, with the torque tau_i. */
static Line *add_line(Tracer *t, LineKind kind, const Patch *p, const int *which, int count, const vec3 *e, const vec3 *c, const vec3 *tau)
{
    const Touching *first = &t->touch[p->point[which[0]]];
    Line *l = trace_line(t, kind, p->point[which[0]]);
    if (!l)
        return NULL;
    for (int side = 0; side < 2; side++) {
        int body = side ? first->b : first->a;
        real sign = side ? 1 : -1;
        vec3 lin = vec3_zero(), ang = vec3_zero(), glin = vec3_zero(), gang = vec3_zero();
        for (int i = 0; i < count; i++) {
            vec3 arm = vec3_sub(t->touch[p->point[which[i]]].k.at, t->g->pos[body].x);
            lin = vec3_mad(lin, sign, e[i]);
            ang = vec3_mad(ang, sign, vec3_cross(arm, e[i]));
            glin = vec3_mad(glin, sign, c[i]);
            gang = vec3_mad(gang, sign, vec3_add(vec3_cross(arm, c[i]), tau[i]));
        }
        trace_line_body(t, l, body, lin, ang, glin, gang);
    }
    l->points = count;
    for (int i = 0; i < count; i++) {
        l->point[i] = p->point[which[i]];
        l->e[i] = e[i];
    }
    return l;
}

/* Gram and Schmidt: the fields that are independent on these points, of unit norm. Returns their number. */
static int independent(real field[][MANIFOLD_POINTS], int fields, int points, real size)
{
    int rank = 0;
    for (int f = 0; f < fields; f++) {
        real v[MANIFOLD_POINTS], norm = 0;
        memcpy(v, field[f], sizeof v);
        for (int pass = 0; pass < 2; pass++)
            for (int k = 0; k < rank; k++) {
                real dot = 0;
                for (int i = 0; i < points; i++)
                    dot += v[i] * field[k][i];
                for (int i = 0; i < points; i++)
                    v[i] -= dot * field[k][i];
            }
        for (int i = 0; i < points; i++)
            norm += v[i] * v[i];
        norm = sqrt(norm);
        if (!(norm > THIN * (f == 0 ? 1 : size)) || rank == points)
            continue;
        for (int i = 0; i < points; i++)
            field[rank][i] = v[i] / norm;
        rank++;
    }
    return rank;
}

/* ---- normal forces, with sliding friction and rolling resistance in their columns ---- */

static void normal_rows(Tracer *t, const Patch *p, bool forces)
{
    real field[3][MANIFOLD_POINTS], size = 0;
    int which[MANIFOLD_POINTS] = {0, 1, 2, 3};
    for (int i = 0; i < p->count; i++) {
        field[0][i] = 1;
        field[1][i] = vec3_dot(p->arm[i], p->t[0]);
        field[2][i] = vec3_dot(p->arm[i], p->t[1]);
        size = real_max(size, vec3_length(p->arm[i]));
    }
    int rank = independent(field, 3, p->count, size);
    for (int f = 0; f < rank; f++) {
        vec3 e[MANIFOLD_POINTS], c[MANIFOLD_POINTS], tau[MANIFOLD_POINTS];
        real drift = 0, error = 0;
        for (int i = 0; i < p->count; i++) {
            const Touching *q = &t->touch[p->point[i]];
            bool slips = forces && q->slip.axes && q->slip.grip != GRIP_STICK, rolls = forces && q->roll.axes && q->roll.grip != GRIP_STICK;
            vec3 push = slips ? vec3_mad(q->k.n, -cone_bound(&q->slip), q->slip.d) : q->k.n;
            e[i] = vec3_scale(field[f][i], q->k.n);
            c[i] = vec3_scale(field[f][i], push);
            tau[i] = rolls ? vec3_scale(-field[f][i] * cone_bound(&q->roll), q->roll.d) : vec3_zero();
            t->sys.sliding = t->sys.sliding || slips || rolls;
            drift += field[f][i] * q->k.drift_n;
            error += field[f][i] * q->k.gap;
        }
        Line *l = add_line(t, LINE_NORMAL, p, which, p->count, e, c, tau);
        if (!l)
            return;
        l->drift = drift;
        l->error = error;
        memcpy(l->share, field[f], sizeof l->share);
    }
}

/* ---- friction that sticks ---- */

static void tangential_row(Tracer *t, LineKind kind, const Patch *p, const int *which, int count, const vec3 *e)
{
    static const vec3 none[MANIFOLD_POINTS] = {{0, 0, 0}};
    Line *l = add_line(t, kind, p, which, count, e, e, none);
    for (int i = 0; l && i < count; i++)
        l->drift += vec3_dot(e[i], t->touch[p->point[which[i]]].k.drift);
}

static void stick_rows(Tracer *t, const Patch *p)
{
    int which[MANIFOLD_POINTS], count = 0;
    real size = 0;
    for (int i = 0; i < p->count; i++)
        if (t->touch[p->point[i]].slip.axes && t->touch[p->point[i]].slip.grip == GRIP_STICK) {
            size = real_max(size, vec3_length(vec3_sub(p->arm[i], p->arm[count ? which[0] : i])));
            which[count++] = i;
        }
    for (int way = 0; way < (count > 1 ? 3 : 2) && count > 0; way++) {
        vec3 e[MANIFOLD_POINTS];
        for (int i = 0; i < count; i++) {
            real weight = count > 1 ? t->touch[p->point[which[i]]].slip.weight : 1;
            vec3 turn = vec3_scale(1 / size, vec3_cross(p->n, p->arm[which[i]]));
            e[i] = vec3_scale(weight, way == 2 ? turn : p->t[way]);
        }
        tangential_row(t, LINE_SLIP, p, which, count, e);
    }
}

/* ---- slip so slow that its direction is held: nothing may move across it ---- */

static void lateral_rows(Tracer *t, const Patch *p)
{
    bool done[MANIFOLD_POINTS] = {false};
    for (int i = 0; i < p->count; i++) {
        const Cone *c = &t->touch[p->point[i]].slip;
        if (done[i] || !c->axes || c->grip != GRIP_SLIP || !c->locked)
            continue;
        int which[MANIFOLD_POINTS], count = 0;          /* those that go the same way */
        real field[2][MANIFOLD_POINTS], size = 0;
        for (int k = i; k < p->count; k++) {
            const Cone *o = &t->touch[p->point[k]].slip;
            if (!o->axes || o->grip != GRIP_SLIP || !o->locked || !vec3_equal(o->d, c->d))
                continue;
            done[k] = true;
            field[0][count] = 1;
            field[1][count] = vec3_dot(p->arm[k], c->d);
            size = real_max(size, vec3_length(p->arm[k]));
            which[count++] = k;
        }
        vec3 across = vec3_unit_or(vec3_cross(p->n, c->d), vec3_zero());
        int rank = independent(field, 2, count, size);
        for (int f = 0; f < rank; f++) {
            vec3 e[MANIFOLD_POINTS];
            for (int k = 0; k < count; k++)
                e[k] = vec3_scale(field[f][k], across);
            tangential_row(t, LINE_LATERAL, p, which, count, e);
        }
    }
}

/* Rolling resistance that holds: no relative spin. */
static void roll_rows(Tracer *t, int owner)
{
    const Touching *q = &t->touch[owner];
    for (int way = 0; way < 3 && q->roll.axes && q->roll.grip == GRIP_STICK; way++) {
        Line *l = trace_line(t, LINE_ROLL, owner);
        if (!l)
            return;
        vec3 e = {way == 0, way == 1, way == 2};
        trace_line_body(t, l, q->a, vec3_zero(), vec3_neg(e), vec3_zero(), vec3_neg(e));
        trace_line_body(t, l, q->b, vec3_zero(), e, vec3_zero(), e);
        l->e[0] = e;
    }
}

static void patch_rows(Tracer *t, Patch *p, bool forces, bool positions)
{
    p->centre = vec3_zero();
    for (int i = 0; i < p->count; i++)
        p->centre = vec3_mad(p->centre, 1.0 / p->count, t->touch[p->point[i]].k.at);
    for (int i = 0; i < p->count; i++)
        p->arm[i] = vec3_sub(t->touch[p->point[i]].k.at, p->centre);
    vec3_basis(p->n, &p->t[0], &p->t[1]);
    normal_rows(t, p, forces);
    if (positions)
        return;
    stick_rows(t, p);
    if (forces)
        lateral_rows(t, p);
    for (int i = 0; i < p->count; i++)
        roll_rows(t, p->point[i]);
}

void trace_patch(Tracer *t, int first, bool forces, bool positions)
{
    int contact = t->touch[first].contact;
    bool done[MANIFOLD_POINTS] = {false};
    for (int i = first; i < t->touch_count && t->touch[i].contact == contact; i++) {
        if (!t->touch[i].gate.presses || done[i - first])
            continue;
        Patch p = {.n = t->touch[i].k.n};
        for (int k = i; k < t->touch_count && t->touch[k].contact == contact; k++)
            if (!done[k - first] && t->touch[k].gate.presses && vec3_dot(t->touch[k].k.n, p.n) > 1 - FLAT) {
                done[k - first] = true;
                p.point[p.count++] = k;
            }
        patch_rows(t, &p, forces, positions);
    }
}
