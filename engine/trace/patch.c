/* trace/patch.c - the rows of one contact: its points act as one patch.
 *
 * Four corners on a face hold a body in three ways only (along the normal, about two axes), and when they stick in three more
 * (along the face, about the normal). One row a way instead of one a point makes the system regular, and spreads the forces
 * over the points by a rule that does not depend on rounding:
 *   normal forces      lie on a plane over the patch, f = a + b x + c y: the distribution of least norm;
 *   tangential forces  are those of a rigid turn of the patch, weighted with the normal forces.
 */
#include "math/pair.h"
#include "trace/trace.h"

#define FLAT    1e-9        /* 1 - cosine: points of such normals make one patch                */
#define THIN    1e-6        /* of the patch's size: a way that narrow is none                   */

typedef struct Patch {
    int  count, point[MANIFOLD_POINTS];         /* that press */
    int  body[2];                               /* a and b; < 0: does not move */
    vec3 centre, n, t[2];
    bool even;                                  /* all normals are n, to the last digit */
    vec3 arm[MANIFOLD_POINTS];                  /* m  from the centre */
    vec3 lever[2][MANIFOLD_POINTS];             /* m  from the centres of mass of a and b */
} Patch;

/* The points that take part in a row. */
typedef struct Subset { int count, which[MANIFOLD_POINTS]; } Subset;

/* Opens a row on these points; what its e are, which nobody asks of normal forces, is the caller's to say. */
INLINE Line *open_line(Tracer *t, LineKind kind, const Patch *p, const Subset *s)
{
    Line *l = trace_line(t, kind, p->point[s->which[0]]);
    if (!l)
        return NULL;
    l->points = s->count;
    for (int i = 0; i < s->count; i++)
        l->point[i] = p->point[s->which[i]];
    return l;
}

/* On one body. The copies keep the arrows of all other worlds in registers. */
INLINE void push_body(const Tracer *t, Line *l, int body, const Arrow *j, const Arrow *g)
{
    if (t->g->planar) {
        Arrow flat_j = *j, flat_g = *g;
        dir_mask(t->g, &flat_j.lin, &flat_j.ang);
        dir_mask(t->g, &flat_g.lin, &flat_g.ang);
        trace_line_push(t, l, body, &flat_j, &flat_g);
    } else {
        trace_line_push(t, l, body, j, g);
    }
}

/* Outward on b, inward on a. */
static inline Arrow arrow(int side, vec3 lin, vec3 ang)
{
    return side ? (Arrow){lin, ang} : (Arrow){vec3_neg(lin), vec3_neg(ang)};
}

/* sum_i e_i at the points, on one side; tau_i are torques. */
static Arrow arrow_of(const Patch *p, const Subset *s, int side, const vec3 *e, const vec3 *tau)
{
    vec3 lin = vec3_zero(), ang = vec3_zero();
    for (int i = 0; i < s->count; i++) {
        lin = vec3_add(lin, e[i]);
        ang = vec3_add(ang, vec3_cross(p->lever[side][s->which[i]], e[i]));
        if (tau)
            ang = vec3_add(ang, tau[i]);
    }
    return arrow(side, lin, ang);
}

/* A row whose rate is sum_i e_i . u_i and whose force on b at point i is c_i, with the torque tau_i; NULL: as e_i, without torques. */
static Line *add_line(Tracer *t, LineKind kind, const Patch *p, const Subset *s, const vec3 *e, const vec3 *c, const vec3 *tau)
{
    Line *l = open_line(t, kind, p, s);
    for (int side = 0; l && side < 2; side++) {
        if (p->body[side] < 0)
            continue;
        Arrow j = arrow_of(p, s, side, e, NULL), g;
        if (c)
            g = arrow_of(p, s, side, c, tau);
        push_body(t, l, p->body[side], &j, c ? &g : &j);
    }
    return l;
}

/* The same of e_i = w_i d, and c_i = w_i f; NULL: as e_i. */
INLINE Line *even_line(Tracer *t, LineKind kind, const Patch *p, const Subset *s, const real *w, vec3 d, const vec3 *f)
{
    Line *l = open_line(t, kind, p, s);
    real sum = 0;
    for (int i = 0; l && i < s->count; i++)
        sum += w[i];
    for (int side = 0; l && side < 2; side++) {
        if (p->body[side] < 0)
            continue;
        vec3 lever = vec3_zero();
        for (int i = 0; i < s->count; i++)
            lever = vec3_mad(lever, w[i], p->lever[side][s->which[i]]);
        Arrow j = arrow(side, vec3_scale(sum, d), vec3_cross(lever, d)), g = j;
        if (f)
            g = arrow(side, vec3_scale(sum, *f), vec3_cross(lever, *f));
        push_body(t, l, p->body[side], &j, &g);
    }
    return l;
}

static Line *add_even_line(Tracer *t, LineKind kind, const Patch *p, const Subset *s, const real *w, vec3 d)
{
    return even_line(t, kind, p, s, w, d, NULL);
}

static Line *add_sliding_line(Tracer *t, LineKind kind, const Patch *p, const Subset *s, const real *w, vec3 d, vec3 f)
{
    return even_line(t, kind, p, s, w, d, &f);
}

/* Gram and Schmidt: the fields that are independent on these points, of unit norm. Returns their number. */
INLINE int orthogonal(real field[][MANIFOLD_POINTS], int fields, int points, real size)
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
                UNROLL
                for (int i = 0; i < points; i++)
                    dot += v[i] * field[k][i];
                UNROLL
                for (int i = 0; i < points; i++)
                    v[i] -= dot * field[k][i];
                taken += dot * dot;
            }
            UNROLL
            for (int i = 0; i < points; i++)
                left += v[i] * v[i];
            again = taken > left;           /* little is left: once more takes the rounding out */
        }
        UNROLL
        for (int i = 0; i < points; i++)
            norm += v[i] * v[i];
        norm = sqrt(norm);
        if (!(norm > THIN * (f == 0 ? 1 : size)) || rank == points)
            continue;
        UNROLL
        for (int i = 0; i < points; i++)
            field[rank][i] = v[i] / norm;
        rank++;
    }
    return rank;
}

/* The same, written out by the compiler for edges and for faces. */
static int independent(real field[][MANIFOLD_POINTS], int fields, int points, real size)
{
    switch (points) {
    case 2: return orthogonal(field, fields, 2, size);
    case 4: return orthogonal(field, fields, 4, size);
    default: return orthogonal(field, fields, points, size);
    }
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

/* What does not turn slides the same way at all its points. */
static bool slides_alike(const Tracer *t, const Patch *p)
{
    const Touching *first = &t->touch[p->point[0]];
    for (int i = 0; i < p->count; i++) {
        const Touching *q = &t->touch[p->point[i]];
        if (q->slip.grip != first->slip.grip || q->slip.grip == GRIP_STICK || !vec3_equal(q->slip.d, first->slip.d) || q->roll.axes)
            return false;
    }
    return p->even && first->slip.axes;
}

static Line *normal_line(Tracer *t, const Patch *p, const Subset *all, const real *share, bool sliding)
{
    if (p->even && !sliding)
        return add_even_line(t, LINE_NORMAL, p, all, share, p->n);
    if (slides_alike(t, p)) {
        vec3 push, turn;
        add_sliding(&t->touch[p->point[0]], &push, &turn);
        return add_sliding_line(t, LINE_NORMAL, p, all, share, p->n, push);
    }
    vec3 e[MANIFOLD_POINTS], c[MANIFOLD_POINTS], tau[MANIFOLD_POINTS];
    for (int i = 0; i < p->count; i++) {
        vec3 push, turn;
        e[i] = vec3_scale(share[i], t->touch[p->point[i]].k.n);
        add_sliding(&t->touch[p->point[i]], &push, &turn);
        c[i] = vec3_scale(share[i], push);
        tau[i] = vec3_scale(share[i], turn);
    }
    return add_line(t, LINE_NORMAL, p, all, e, sliding ? c : NULL, tau);
}

static void normal_rows(Tracer *t, const Patch *p, bool forces)
{
    const Subset all = {p->count, {0, 1, 2, 3}};
    real field[3][MANIFOLD_POINTS];
    bool sliding = false;
    for (int i = 0; i < p->count && forces; i++)
        sliding = sliding || slides(&t->touch[p->point[i]]);
    t->sys.sliding = t->sys.sliding || sliding;
    int rank = distributions(p, field);
    for (int f = 0; f < rank; f++) {
        Line *l = normal_line(t, p, &all, field[f], sliding);
        if (!l)
            return;
        for (int i = 0; i < p->count; i++) {
            const Kinematics *k = &t->touch[p->point[i]].k;
            l->drift += field[f][i] * k->drift_n;
            l->error += field[f][i] * k->gap;
            l->share[i] = field[f][i];
        }
    }
}

/* ---- friction that sticks ---- */

/* Its force acts along e at its points. */
INLINE void act_along(const Tracer *t, Line *l, const vec3 *e)
{
    for (int i = 0; l && i < l->points; i++) {
        l->e[i] = e[i];
        l->drift += vec3_dot(e[i], t->touch[l->point[i]].k.drift);
    }
}

/* The same way at all of them, w_i d. */
static void add_along(Tracer *t, LineKind kind, const Patch *p, const Subset *s, const real *w, vec3 d)
{
    vec3 e[MANIFOLD_POINTS];
    for (int i = 0; i < s->count; i++)
        e[i] = vec3_scale(w[i], d);
    act_along(t, add_even_line(t, kind, p, s, w, d), e);
}

static void stick_rows(Tracer *t, const Patch *p)
{
    Subset s = {.count = 0};
    real size = 0, weight[MANIFOLD_POINTS];
    for (int i = 0; i < p->count; i++) {
        const Cone *c = &t->touch[p->point[i]].slip;
        if (!c->axes || c->grip != GRIP_STICK || !(c->weight > 0))
            continue;
        size = real_max(size, vec3_length(vec3_sub(p->arm[i], p->arm[s.count ? s.which[0] : i])));
        weight[s.count] = c->weight;
        s.which[s.count++] = i;
    }
    if (s.count == 1)
        weight[0] = 1;
    for (int way = 0; way < 2 && s.count > 0; way++)
        add_along(t, LINE_SLIP, p, &s, weight, p->t[way]);
    if (!(size > 0))            /* one point, or some at the same place: no turn to hold */
        return;
    vec3 e[MANIFOLD_POINTS];
    for (int i = 0; i < s.count; i++)
        e[i] = vec3_scale(weight[i] / size, vec3_cross(p->n, p->arm[s.which[i]]));
    act_along(t, add_line(t, LINE_SLIP, p, &s, e, NULL, NULL), e);
}

/* ---- slip so slow that its direction is held: nothing may move across it ---- */

static void lateral_rows(Tracer *t, const Patch *p)
{
    bool done[MANIFOLD_POINTS] = {false};
    for (int i = 0; i < p->count; i++) {
        const Cone *c = &t->touch[p->point[i]].slip;
        if (done[i] || !c->axes || c->grip != GRIP_SLIP || !c->locked)
            continue;
        Subset s = {.count = 0};        /* those that go the same way */
        real field[2][MANIFOLD_POINTS], size = 0;
        for (int k = i; k < p->count; k++) {
            const Cone *o = &t->touch[p->point[k]].slip;
            if (!o->axes || o->grip != GRIP_SLIP || !o->locked || !vec3_equal(o->d, c->d))
                continue;
            done[k] = true;
            field[0][s.count] = 1;
            field[1][s.count] = vec3_dot(p->arm[k], c->d);
            size = real_max(size, vec3_length(p->arm[k]));
            s.which[s.count++] = k;
        }
        vec3 across = vec3_unit_or(vec3_cross(p->n, c->d), vec3_zero());
        int rank = independent(field, 2, s.count, size);
        for (int f = 0; f < rank; f++)
            add_along(t, LINE_LATERAL, p, &s, field[f], across);
    }
}

/* Rolling resistance that holds: no relative spin. */
static void roll_rows(Tracer *t, const Patch *p, int owner)
{
    const Touching *q = &t->touch[owner];
    for (int way = 0; way < 3 && q->roll.axes && q->roll.grip == GRIP_STICK; way++) {
        Line *l = trace_line(t, LINE_ROLL, owner);
        if (!l)
            return;
        vec3 e = {way == 0, way == 1, way == 2};
        for (int side = 0; side < 2; side++) {
            Arrow j = arrow(side, vec3_zero(), e);
            if (p->body[side] >= 0)
                push_body(t, l, p->body[side], &j, &j);
        }
        l->e[0] = e;
    }
}

static void lay_out_patch(const Tracer *t, Patch *p)
{
    const Touching *first = &t->touch[p->point[0]];
    p->centre = vec3_zero();
    for (int i = 0; i < p->count; i++)
        p->centre = vec3_mad(p->centre, 1.0 / p->count, t->touch[p->point[i]].k.at);
    for (int i = 0; i < p->count; i++)
        p->arm[i] = vec3_sub(t->touch[p->point[i]].k.at, p->centre);
    for (int side = 0; side < 2; side++) {
        int body = side ? first->b : first->a;
        p->body[side] = trace_moves(t, body) ? body : -1;
        for (int i = 0; i < p->count && p->body[side] >= 0; i++)
            p->lever[side][i] = vec3_sub(t->touch[p->point[i]].k.at, t->g->pos[body].x);
    }
    if (p->count > 1 || (first->slip.axes && first->slip.grip == GRIP_STICK))
        vec3_basis(p->n, &p->t[0], &p->t[1]);
}

/* Of one point that sticks or has no friction, along d. */
static Line *point_line(Tracer *t, LineKind kind, const Patch *p, vec3 d)
{
    Line *l = trace_line(t, kind, p->point[0]);
    for (int side = 0; l && side < 2; side++) {
        if (p->body[side] < 0)
            continue;
        Arrow j = arrow(side, d, vec3_cross(p->lever[side][0], d));
        push_body(t, l, p->body[side], &j, &j);
    }
    if (l) {
        l->points = 1;
        l->point[0] = p->point[0];
        l->share[0] = 1;
        l->e[0] = d;
    }
    return l;
}

static void point_rows(Tracer *t, const Patch *p, bool positions)
{
    const Touching *c = &t->touch[p->point[0]];
    Line *l = point_line(t, LINE_NORMAL, p, p->n);
    if (l) {
        l->drift = c->k.drift_n;
        l->error = c->k.gap;
    }
    for (int way = 0; way < 2 && !positions && c->slip.axes; way++)
        if ((l = point_line(t, LINE_SLIP, p, p->t[way])))
            l->drift = vec3_dot(p->t[way], c->k.drift);
}

/* ---- an edge: two points that stick or have no friction ---- */

static bool edge_end(const Touching *q)
{
    return !q->roll.axes && (!q->slip.axes || (q->slip.grip == GRIP_STICK && q->slip.weight > 0));
}

static bool is_edge(const Tracer *t, const Patch *p)
{
    if (p->count != 2 || !p->even)
        return false;
    const Touching *a = &t->touch[p->point[0]], *b = &t->touch[p->point[1]];
    return edge_end(a) && edge_end(b) && !a->slip.axes == !b->slip.axes && !vec3_equal(a->k.at, b->k.at);
}

/* w[0] d at one end and w[1] d at the other. */
INLINE void edge_line(Tracer *t, LineKind kind, const Patch *p, const real w[2], vec3 d)
{
    const Subset ends = {2, {0, 1}};
    Line *l = open_line(t, kind, p, &ends);
    for (int side = 0; l && side < 2; side++) {
        if (p->body[side] < 0)
            continue;
        vec3 lever = vec3_mad(vec3_scale(w[0], p->lever[side][0]), w[1], p->lever[side][1]);
        Arrow j = arrow(side, vec3_scale(w[0] + w[1], d), vec3_cross(lever, d));
        push_body(t, l, p->body[side], &j, &j);
    }
    for (int i = 0; l && i < 2; i++) {
        const Kinematics *k = &t->touch[p->point[i]].k;
        if (kind == LINE_NORMAL) {
            l->share[i] = w[i];
            l->drift += w[i] * k->drift_n;
            l->error += w[i] * k->gap;
        } else {
            l->e[i] = vec3_scale(w[i], d);
            l->drift += vec3_dot(l->e[i], k->drift);
        }
    }
}

/* The rows that normal_rows and stick_rows would find, written out: what rocks has them built six times a frame. */
static void edge_rows(Tracer *t, const Patch *p, bool positions)
{
    const Cone *a = &t->touch[p->point[0]].slip, *b = &t->touch[p->point[1]].slip;
    const real even[2] = {sqrt(0.5), sqrt(0.5)}, odd[2] = {-sqrt(0.5), sqrt(0.5)};
    edge_line(t, LINE_NORMAL, p, even, p->n);
    edge_line(t, LINE_NORMAL, p, odd, p->n);
    if (positions || !a->axes)
        return;
    const real held[2] = {a->weight, b->weight}, turned[2] = {-a->weight, b->weight};
    vec3 along = vec3_sub(p->arm[1], p->arm[0]);
    edge_line(t, LINE_SLIP, p, held, p->t[0]);
    edge_line(t, LINE_SLIP, p, held, p->t[1]);
    edge_line(t, LINE_SLIP, p, turned, vec3_scale(0.5 / vec3_length(along), vec3_cross(p->n, along)));
}

static void patch_rows(Tracer *t, Patch *p, bool forces, bool positions)
{
    lay_out_patch(t, p);
    if (is_edge(t, p)) {
        edge_rows(t, p, positions);
        return;
    }
    bool simple = p->count == 1 && !slides(&t->touch[p->point[0]]);
    if (simple)
        point_rows(t, p, positions);
    else
        normal_rows(t, p, forces);
    if (positions)
        return;
    if (!simple)
        stick_rows(t, p);
    if (!simple && forces)
        lateral_rows(t, p);
    for (int i = 0; i < p->count; i++)
        roll_rows(t, p, p->point[i]);
}

void trace_patch(Tracer *t, int first, bool forces, bool positions)
{
    int contact = t->touch[first].contact;
    bool done[MANIFOLD_POINTS] = {false};
    for (int i = first; i < t->touch_count && t->touch[i].contact == contact; i++) {
        if (!t->touch[i].gate.presses || done[i - first])
            continue;
        Patch p;
        p.n = t->touch[i].k.n;
        p.even = true;
        p.point[0] = i;
        p.count = 1;
        for (int k = i + 1; k < t->touch_count && t->touch[k].contact == contact; k++)
            if (!done[k - first] && t->touch[k].gate.presses && vec3_dot(t->touch[k].k.n, p.n) > 1 - FLAT) {
                done[k - first] = true;
                p.even = p.even && vec3_equal(t->touch[k].k.n, p.n);
                p.point[p.count++] = k;
            }
        patch_rows(t, &p, forces, positions);
    }
}
