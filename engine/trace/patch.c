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
    int  count, point[MANIFOLD_POINTS];         /* that press */
    vec3 centre, n, t[2];
    vec3 arm[MANIFOLD_POINTS];                  /* m  from the centre */
} Patch;

/* sum_i e_i at the points, on one side; tau_i are torques. */
static Arrow arrow_of(const Tracer *t, const Patch *p, const int *which, int count, int body, real sign, const vec3 *e, const vec3 *tau)
{
    vec3 x = t->g->pos[body].x, lin = vec3_zero(), ang = vec3_zero();
    for (int i = 0; i < count; i++) {
        lin = vec3_add(lin, e[i]);
        ang = vec3_add(ang, vec3_cross(vec3_sub(t->touch[p->point[which[i]]].k.at, x), e[i]));
        if (tau)
            ang = vec3_add(ang, tau[i]);
    }
    return (Arrow){vec3_scale(sign, lin), vec3_scale(sign, ang)};
}

/* A row whose rate is sum_i e_i . u_i and whose force on b at point i is c_i, with the torque tau_i; NULL: as e_i, without torques. */
static Line *add_line(Tracer *t, LineKind kind, const Patch *p, const int *which, int count, const vec3 *e, const vec3 *c, const vec3 *tau)
{
    const Touching *first = &t->touch[p->point[which[0]]];
    Line *l = trace_line(t, kind, p->point[which[0]]);
    if (!l)
        return NULL;
    for (int side = 0; side < 2; side++) {
        int body = side ? first->b : first->a;
        if (!trace_moves(t, body))
            continue;
        real sign = side ? 1 : -1;
        Arrow j = arrow_of(t, p, which, count, body, sign, e, NULL), g;
        if (c)
            g = arrow_of(t, p, which, count, body, sign, c, tau);
        trace_line_body(t, l, body, &j, c ? &g : &j);
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
        bool again = rank > 0;
        for (int pass = 0; pass < 2 && again; pass++) {
            real taken = 0, left = 0;
            for (int k = 0; k < rank; k++) {
                real dot = 0;
                for (int i = 0; i < points; i++)
                    dot += v[i] * field[k][i];
                for (int i = 0; i < points; i++)
                    v[i] -= dot * field[k][i];
                taken += dot * dot;
            }
            for (int i = 0; i < points; i++)
                left += v[i] * v[i];
            again = taken > left;           /* little is left: once more takes the rounding out */
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

/* What pushes with a normal force of 1 at a point that slides or rolls: friction along it, resistance against the roll. */
static void add_sliding(const Touching *q, vec3 *push, vec3 *turn)
{
    *push = q->slip.axes && q->slip.grip != GRIP_STICK ? vec3_mad(q->k.n, -cone_bound(&q->slip), q->slip.d) : q->k.n;
    *turn = q->roll.axes && q->roll.grip != GRIP_STICK ? vec3_scale(-cone_bound(&q->roll), q->roll.d) : vec3_zero();
}

static bool slides(const Touching *q)
{
    return (q->slip.axes && q->slip.grip != GRIP_STICK) || (q->roll.axes && q->roll.grip != GRIP_STICK);
}

/* f = a + b x + c y over the patch, as independent distributions. */
static int distributions(const Patch *p, real field[3][MANIFOLD_POINTS])
{
    real size = 0;
    field[0][0] = 1;
    if (p->count == 1)
        return 1;
    for (int i = 0; i < p->count; i++) {
        field[0][i] = 1;
        field[1][i] = vec3_dot(p->arm[i], p->t[0]);
        field[2][i] = vec3_dot(p->arm[i], p->t[1]);
        size = real_max(size, vec3_length(p->arm[i]));
    }
    return independent(field, 3, p->count, size);
}

static void normal_rows(Tracer *t, const Patch *p, bool forces)
{
    static const int which[MANIFOLD_POINTS] = {0, 1, 2, 3};
    real field[3][MANIFOLD_POINTS];
    vec3 push[MANIFOLD_POINTS], turn[MANIFOLD_POINTS];
    bool sliding = false;
    for (int i = 0; i < p->count && forces; i++)
        sliding = sliding || slides(&t->touch[p->point[i]]);
    for (int i = 0; i < p->count && sliding; i++)
        add_sliding(&t->touch[p->point[i]], &push[i], &turn[i]);
    t->sys.sliding = t->sys.sliding || sliding;
    int rank = distributions(p, field);
    for (int f = 0; f < rank; f++) {
        vec3 e[MANIFOLD_POINTS], c[MANIFOLD_POINTS], tau[MANIFOLD_POINTS];
        real drift = 0, error = 0;
        for (int i = 0; i < p->count; i++) {
            const Kinematics *k = &t->touch[p->point[i]].k;
            e[i] = vec3_scale(field[f][i], k->n);
            drift += field[f][i] * k->drift_n;
            error += field[f][i] * k->gap;
        }
        for (int i = 0; i < p->count && sliding; i++) {
            c[i] = vec3_scale(field[f][i], push[i]);
            tau[i] = vec3_scale(field[f][i], turn[i]);
        }
        Line *l = add_line(t, LINE_NORMAL, p, which, p->count, e, sliding ? c : NULL, tau);
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
    Line *l = add_line(t, kind, p, which, count, e, NULL, NULL);
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
            e[i] = way == 2 ? vec3_scale(weight / size, vec3_cross(p->n, p->arm[which[i]])) : vec3_scale(weight, p->t[way]);
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
        Arrow on_a = {vec3_zero(), vec3_neg(e)}, on_b = {vec3_zero(), e};
        trace_line_body(t, l, q->a, &on_a, &on_a);
        trace_line_body(t, l, q->b, &on_b, &on_b);
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
