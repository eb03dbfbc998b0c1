/* geom/manifold_box.c - two boxes: separating axes (Gottschalk, Lin & Manocha 1996), then the incident face clipped in the
 * reference face's plane. Works in arrays, since axes are chosen by number. */
#include "geom/pair.h"

/* An edge pair must separate by this much more than the best face (of the smaller shape): while faces lie flat on each other, crossing
 * edges separate equally well, and the choice must not follow rounding. */
#define FACE_BIAS   1e-6
#define A_BIAS      1e-7        /* of the smaller shape: of two faces that separate equally well the normal is a's */
#define SAME_TILT   5e-5        /* 1 - cosine of 0.01 rad: of two faces that nearly face each other the reference is a's while they rock */
#define ON_SIDE     1e-9        /* of the smaller shape: corners this near to a side are inside */
#define FLAT_ENOUGH 0.966       /* cosine: with the faces more than 15 degrees from the normal, crossing edges meet in one point */
#define PARALLEL2   1e-10       /* squared sine: the cross product of such edges is no axis */

/* One box as seen by the other: r[i][j] = axis i of the first . axis j of the second; o = centre of the second. */
typedef struct Boxes { real ha[3], hb[3], r[3][3], o[3]; } Boxes;

typedef struct Axis { real gap; int i, j; real sign; vec3 n; } Axis;    /* n: unit, from a to b, for edges */

static void put(vec3 v, real out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static Boxes boxes_of(const Pair *p)
{
    Boxes x = {.ha = {0}};
    put(((const BoxData *)p->a->data)->half, x.ha);
    put(((const BoxData *)p->b->data)->half, x.hb);
    put(p->c.turn.r0, x.r[0]);
    put(p->c.turn.r1, x.r[1]);
    put(p->c.turn.r2, x.r[2]);
    put(p->c.shift, x.o);
    return x;
}

static Axis best_face_of_a(const Boxes *x)
{
    Axis best = {.gap = -INFINITY};
    for (int i = 0; i < 3; i++) {
        real gap = fabs(x->o[i]) - (x->ha[i] + fabs(x->r[i][0]) * x->hb[0] + fabs(x->r[i][1]) * x->hb[1] + fabs(x->r[i][2]) * x->hb[2]);
        if (gap > best.gap)
            best = (Axis){.gap = gap, .i = i, .sign = x->o[i] < 0 ? -1 : 1};
    }
    return best;
}

static Axis best_face_of_b(const Boxes *x)
{
    Axis best = {.gap = -INFINITY};
    for (int j = 0; j < 3; j++) {
        real d = x->o[0] * x->r[0][j] + x->o[1] * x->r[1][j] + x->o[2] * x->r[2][j];
        real gap = fabs(d) - (x->hb[j] + fabs(x->r[0][j]) * x->ha[0] + fabs(x->r[1][j]) * x->ha[1] + fabs(x->r[2][j]) * x->ha[2]);
        if (gap > best.gap)
            best = (Axis){.gap = gap, .i = j, .sign = d < 0 ? -1 : 1};
    }
    return best;
}

/* Axis e_i x b_j has components (-r[i2][j], r[i1][j]) along i1, i2, the axes after i. */
static Axis best_edges(const Boxes *x)
{
    Axis best = {.gap = -INFINITY};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            real n1 = -x->r[i2][j], n2 = x->r[i1][j], sine2 = n1 * n1 + n2 * n2;
            if (sine2 < PARALLEL2)
                continue;
            real d = n1 * x->o[i1] + n2 * x->o[i2];
            real reach_a = fabs(n1) * x->ha[i1] + fabs(n2) * x->ha[i2];
            real reach_b = fabs(x->r[i][j2]) * x->hb[j1] + fabs(x->r[i][j1]) * x->hb[j2];
            real gap = (fabs(d) - reach_a - reach_b) / sqrt(sine2);
            if (gap > best.gap) {
                real n[3] = {0, 0, 0}, k = (d < 0 ? -1 : 1) / sqrt(sine2);
                n[i1] = k * n1;
                n[i2] = k * n2;
                best = (Axis){.gap = gap, .i = i, .j = j, .n = {n[0], n[1], n[2]}};
            }
        }
    return best;
}

real box_separation(const Pair *p)
{
    Boxes x = boxes_of(p);
    return real_max(real_max(best_face_of_a(&x).gap, best_face_of_b(&x).gap), best_edges(&x).gap);
}

/* ---- clipping in the plane of the reference face ---- */

/* Features are the same whichever box is the reference: corners 0..7 by the signs of x, y, z; edges 8..19; faces 20..25. */
static uint32_t corner_number(const real c[3]) { return (c[0] > 0 ? 1u : 0) | (c[1] > 0 ? 2u : 0) | (c[2] > 0 ? 4u : 0); }
static uint32_t face_number(int axis, real sign) { return 20 + 2 * (uint32_t)axis + (sign > 0 ? 1 : 0); }

/* The edge along axis k next to the point c of the box. */
static uint32_t edge_number(int k, const real c[3])
{
    return 8 + 4 * (uint32_t)k + (c[(k + 1) % 3] > 0 ? 1u : 0) + (c[(k + 2) % 3] > 0 ? 2u : 0);
}

/* A corner of the clipped area in the frame of the reference box: position, its features, and the feature of the edge that
 * leads to the next corner: an edge of the incident box, or a side 0..3 of the reference face (edge 0). */
typedef struct Corner { real p[3]; uint32_t ref, incident, edge; int side; } Corner;

typedef struct Frame {
    const Boxes *x;             /* the reference is box a of it */
    int  axis, u, v;            /* of the reference face and of its plane */
    real sign;                  /* the face lies at sign * ha[axis] */
    real same;                  /* m */
    real lean[3];               /* of the contact normal per height over the face: along u and v, 0 along axis */
} Frame;

/* Moves a point along the contact normal as if its height over the face were 0 (way = -1), and back (1). */
static void slide(const Frame *f, real way, real p[3])
{
    real height = p[f->axis] - f->sign * f->x->ha[f->axis];
    for (int i = 0; i < 3; i++)
        p[i] += way * height * f->lean[i];
}

/* Sides in turn: +u, +v, -u, -v. */
static int  side_axis(const Frame *f, int side) { return side % 2 ? f->v : f->u; }
static real side_sign(int side) { return side < 2 ? 1 : -1; }

static uint32_t side_edge(const Frame *f, int side)
{
    real c[3] = {0, 0, 0};
    c[f->axis] = f->sign;
    c[side_axis(f, side)] = side_sign(side);
    return edge_number(side_axis(f, side + 1), c);
}

static uint32_t incident_face(const Frame *f, const real n[3], Corner out[4])
{
    const Boxes *x = f->x;
    static const real along[4] = {1, -1, -1, 1}, across[4] = {1, 1, -1, -1};
    real most = -1, sign = 1;
    int j = 0;
    for (int k = 0; k < 3; k++) {
        real d = n[0] * x->r[0][k] + n[1] * x->r[1][k] + n[2] * x->r[2][k];
        if (fabs(d) > most * (1 + 1e-9)) {
            most = fabs(d);
            j = k;
            sign = d > 0 ? -1 : 1;
        }
    }
    int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    for (int k = 0; k < 4; k++) {
        real c[3];
        c[j] = sign * x->hb[j];
        c[j1] = along[k] * x->hb[j1];
        c[j2] = across[k] * x->hb[j2];
        for (int i = 0; i < 3; i++)
            out[k].p[i] = x->o[i] + x->r[i][0] * c[0] + x->r[i][1] * c[1] + x->r[i][2] * c[2];
        out[k].ref = face_number(f->axis, f->sign);
        out[k].incident = corner_number(c);
        out[k].side = -1;
        /* corners run ++ -+ -- +-: the edge to the next one lies along j1, then j2, ... */
        out[k].edge = k % 2 == 0 ? edge_number(j1, c) : edge_number(j2, c);
    }
    return face_number(j, sign);
}

static Corner cut(const Frame *f, const Corner *in, const Corner *out, const Corner *first, int side, uint32_t incident_face_number)
{
    int k = side_axis(f, side);
    real level = side_sign(side) * f->x->ha[k], t = (level - in->p[k]) / (out->p[k] - in->p[k]);
    Corner c = *first;
    for (int i = 0; i < 3; i++)
        c.p[i] = in->p[i] + t * (out->p[i] - in->p[i]);
    c.p[k] = level;
    if (first->side < 0) {
        c.ref = side_edge(f, side);
        c.incident = first->edge;
    } else {                                    /* along another side already: a corner of the reference face */
        real corner[3];
        corner[f->axis] = f->sign;
        corner[side_axis(f, first->side)] = side_sign(first->side);
        corner[k] = side_sign(side);
        c.ref = corner_number(corner);
        c.incident = incident_face_number;
    }
    return c;
}

static int clip_side(const Frame *f, const Corner *from, int count, Corner *to, int side, uint32_t incident_face_number)
{
    int k = side_axis(f, side), n = 0;
    real sign = side_sign(side), half = f->x->ha[k];
    for (int i = 0; i < count; i++) {
        const Corner *c = &from[i], *next = &from[i + 1 < count ? i + 1 : 0];
        real here = sign * c->p[k] - half, there = sign * next->p[k] - half;
        if (here <= f->same) {
            to[n] = *c;
            if (there > f->same && here >= -f->same)
                to[n].side = side;              /* leaves from the side itself */
            n++;
            if (there > f->same && here < -f->same) {
                to[n] = cut(f, c, next, c, side, incident_face_number);
                to[n++].side = side;
            }
        } else if (there < -f->same) {
            to[n++] = cut(f, next, c, c, side, incident_face_number);
        }
    }
    return n;
}

/* Clips along the contact normal and adds the corners within reach. n: contact normal out of the reference box, in its frame. */
static void clip_faces(const Pair *p, const Frame *f, const real n[3], bool ref_is_a, Contacts *c)
{
    Corner corner[12], other[12];
    uint32_t incident = incident_face(f, n, corner);
    int count = 4;
    for (int i = 0; i < count; i++)
        slide(f, -1, corner[i].p);
    for (int side = 0; side < 4 && count > 0; side++) {
        bool crosses = false;
        int k = side_axis(f, side);
        for (int i = 0; i < count; i++)
            crosses = crosses || side_sign(side) * corner[i].p[k] > f->x->ha[k] + f->same;
        if (!crosses)
            continue;
        count = clip_side(f, corner, count, other, side, incident);
        memcpy(corner, other, (size_t)count * sizeof *corner);
    }
    for (int i = 0; i < count; i++) {
        Corner *k = &corner[i];
        real flat[3] = {k->p[0], k->p[1], k->p[2]};
        flat[f->axis] = f->sign * f->x->ha[f->axis];
        slide(f, 1, k->p);
        vec3 on_incident = {k->p[0], k->p[1], k->p[2]}, on_ref = {flat[0], flat[1], flat[2]};
        if (ref_is_a)
            contacts_add(c, p->reach, on_ref, on_incident, 1u << 16 | k->incident << 8 | k->ref);
        else
            contacts_add(c, p->reach, convex_point_b(&p->c, on_incident), convex_point_b(&p->c, on_ref),
                         1u << 16 | k->ref << 8 | k->incident);
    }
}

/* The same two boxes with the roles exchanged. */
static Boxes swapped(const Boxes *x)
{
    Boxes s;
    for (int i = 0; i < 3; i++) {
        s.ha[i] = x->hb[i];
        s.hb[i] = x->ha[i];
        s.o[i] = -(x->r[0][i] * x->o[0] + x->r[1][i] * x->o[1] + x->r[2][i] * x->o[2]);
        for (int j = 0; j < 3; j++)
            s.r[i][j] = x->r[j][i];
    }
    return s;
}

/* Fills the contacts with the reference face across `axis` of box a or b. */
static void use_face(const Pair *p, const Boxes *x, bool ref_is_a, int axis, real sign, Contacts *c)
{
    Boxes s;
    if (!ref_is_a)
        s = swapped(x);
    Frame f = {.x = ref_is_a ? x : &s, .axis = axis, .u = (axis + 1) % 3, .v = (axis + 2) % 3, .sign = sign, .same = pair_same(p, ON_SIDE)};
    real n[3];
    put(ref_is_a ? c->normal : vec3_neg(mat3_mul_vec(p->c.back, c->normal)), n);
    f.lean[f.u] = n[f.u] / n[axis];
    f.lean[f.v] = n[f.v] / n[axis];
    clip_faces(p, &f, n, ref_is_a, c);
}

/* Most parallel face axis of a box to a direction in its frame. */
static int parallel_axis(const real n[3])
{
    return fabs(n[0]) >= fabs(n[1]) && fabs(n[0]) >= fabs(n[2]) ? 0 : fabs(n[1]) >= fabs(n[2]) ? 1 : 2;
}

static vec3 unit_axis(int i) { return (vec3){i == 0, i == 1, i == 2}; }

/* The nearest points of the two edges of axis e that face each other, unless the edges end before they cross. */
static void add_crossing(const Pair *p, const Boxes *x, const Axis *e, const real na[3], const real nb[3], Contacts *c)
{
    real ca[3], cb[3], s, t;
    for (int k = 0; k < 3; k++) {
        ca[k] = k == e->i ? 0 : na[k] < 0 ? -x->ha[k] : x->ha[k];
        cb[k] = k == e->j ? 0 : nb[k] < 0 ? -x->hb[k] : x->hb[k];
    }
    vec3 middle_a = {ca[0], ca[1], ca[2]}, middle_b = convex_point_b(&p->c, (vec3){cb[0], cb[1], cb[2]});
    vec3 da = vec3_scale(x->ha[e->i], unit_axis(e->i)), db = vec3_scale(x->hb[e->j], mat3_mul_vec(p->c.turn, unit_axis(e->j)));
    vec3 a0 = vec3_sub(middle_a, da), a1 = vec3_add(middle_a, da), b0 = vec3_sub(middle_b, db), b1 = vec3_add(middle_b, db);
    segment_nearest(a0, a1, b0, b1, &s, &t);
    if (s > 0 && s < 1 && t > 0 && t < 1)
        contacts_add(c, p->reach, vec3_lerp(a0, a1, s), vec3_lerp(b0, b1, t),
                     1u << 16 | edge_number(e->j, cb) << 8 | edge_number(e->i, ca));
}

static bool shows(const Contacts *c, real gap, real same)
{
    for (int i = 0; i < c->count; i++)
        if (c->at[i].gap <= gap + same)
            return true;
    return false;
}

/* Crossing edges: nearly flat boxes still touch along an area, measured along the edges' normal; others in one point. */
static void use_edges(const Pair *p, const Boxes *x, const Axis *e, Contacts *c)
{
    real na[3], nb[3];
    c->normal = e->n;
    put(e->n, na);
    put(vec3_neg(mat3_mul_vec(p->c.back, e->n)), nb);
    int ia = parallel_axis(na), jb = parallel_axis(nb);
    if (fabs(na[ia]) > FLAT_ENOUGH || fabs(nb[jb]) > FLAT_ENOUGH) {
        bool ref_is_a = fabs(na[ia]) >= fabs(nb[jb]) - SAME_TILT;
        use_face(p, x, ref_is_a, ref_is_a ? ia : jb, (ref_is_a ? na[ia] : nb[jb]) < 0 ? -1 : 1, c);
    }
    if (!shows(c, e->gap, pair_same(p, ON_SIDE)))       /* else the crossing is one of the corners */
        add_crossing(p, x, e, na, nb, c);
}

int collide_boxes(const Pair *p, ManifoldCache *cache, Manifold *out)
{
    Boxes x = boxes_of(p);
    Axis a = best_face_of_a(&x), b = best_face_of_b(&x);
    if (a.gap > p->reach || b.gap > p->reach)
        return 0;
    Axis e = best_edges(&x);
    if (e.gap > p->reach)
        return 0;

    real faces = real_max(a.gap, b.gap);
    bool crossing = e.gap > faces + pair_same(p, FACE_BIAS);
    Contacts c;
    c.count = 0;
    if (crossing) {
        use_edges(p, &x, &e, &c);
    } else if (a.gap >= b.gap - pair_same(p, A_BIAS)) {
        c.normal = (vec3){a.i == 0 ? a.sign : 0, a.i == 1 ? a.sign : 0, a.i == 2 ? a.sign : 0};
        use_face(p, &x, true, a.i, a.sign, &c);
    } else {
        real n[3];
        c.normal = vec3_scale(b.sign, (vec3){x.r[0][b.i], x.r[1][b.i], x.r[2][b.i]});
        put(c.normal, n);
        int i = parallel_axis(n);
        if (fabs(n[i]) > 1 - SAME_TILT)
            use_face(p, &x, true, i, n[i] < 0 ? -1 : 1, &c);
        else
            use_face(p, &x, false, b.i, -b.sign, &c);
    }
    /* corners and edges that pass each other diagonally: the general way knows their distance */
    real apart = crossing ? e.gap : faces;
    bool diagonal = apart > 0 && !shows(&c, apart, pair_same(p, ON_SIDE));
    return c.count > 0 && !diagonal ? contacts_finish(p, &c, out) : collide_convex(p, cache, out);
}
