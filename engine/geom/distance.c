/* geom/distance.c - signed distance of two shapes: closed forms where there are any, else GJK and EPA on the cores. */
#include "geom/pair.h"

ShapeKind shape_kind(const Shape *s)
{
    static const struct { const ShapeType *type; ShapeKind kind; } named[] = {
        {&shape_box, KIND_BOX}, {&shape_capsule, KIND_CAPSULE}, {&shape_plane, KIND_PLANE}, {&shape_triangle, KIND_TRIANGLE},
        {&shape_cylinder, KIND_CYLINDER}, {&shape_cone, KIND_CONE},
    };
    if (s->type->convex && s->outer == s->round)
        return KIND_BALL;
    for (size_t i = 0; i < sizeof named / sizeof *named; i++)
        if (s->type == named[i].type)
            return named[i].kind;
    return s->type->convex ? KIND_CONVEX : KIND_SURFACE;
}

/* Largest coordinate that the pair's computations meet. */
static real size_of(const Shape *a, const Shape *b, vec3 shift)
{
    real ra = a->outer < INFINITY ? a->outer : 0, rb = b->outer < INFINITY ? b->outer : 0;
    return ra + rb + vec3_length(shift);
}

Pair pair_make(const Shape *a, pose pa, const Shape *b, pose pb)
{
    Pair p = {.a = a, .b = b, .kind_a = shape_kind(a), .kind_b = shape_kind(b), .at = pa, .axes = quat_matrix(pa.q)};
    mat3 back_a = mat3_transpose(p.axes);
    p.c = (ConvexPair){.a = a, .b = b, .turn = mat3_mul(back_a, quat_matrix(pb.q))};
    p.c.back = mat3_transpose(p.c.turn);
    p.c.shift = mat3_mul_vec(back_a, vec3_sub(pb.p, pa.p));
    p.c.size = size_of(a, b, p.c.shift);
    p.grain = real_min(a->outer, b->outer);
    return p;
}

Pair pair_with_piece(const Pair *p, const Shape *triangle, vec3 origin)
{
    Pair piece = *p;
    piece.a = piece.c.a = triangle;
    piece.kind_a = KIND_TRIANGLE;
    piece.at.p = pair_point(p, origin);
    piece.c.shift = vec3_sub(p->c.shift, origin);
    piece.c.size = size_of(triangle, p->b, piece.c.shift);
    piece.grain = real_min(triangle->outer, p->b->outer);
    return piece;
}

Pair pair_swapped(const Pair *p)
{
    Pair s = *p;
    s.a = p->b;
    s.b = p->a;
    s.kind_a = p->kind_b;
    s.kind_b = p->kind_a;
    s.at.p = pair_point(p, p->c.shift);
    s.axes = mat3_mul(p->axes, p->c.turn);
    s.c = (ConvexPair){.a = p->b, .b = p->a, .turn = p->c.back, .back = p->c.turn, .size = p->c.size,
                       .shift = vec3_neg(mat3_mul_vec(p->c.back, p->c.shift))};
    return s;
}

void segment_nearest(vec3 p0, vec3 p1, vec3 q0, vec3 q1, real *s, real *t)
{
    vec3 u = vec3_sub(p1, p0), v = vec3_sub(q1, q0), w = vec3_sub(q0, p0);
    real uu = vec3_length2(u), vv = vec3_length2(v), uv = vec3_dot(u, v), uw = vec3_dot(u, w), vw = vec3_dot(v, w);
    vec3 n = vec3_cross(u, v);
    real nn = vec3_length2(n);

    if (!(uu > 0)) {
        *s = 0;
        *t = vv > 0 ? real_clamp(-vw / vv, 0, 1) : 0;
        return;
    }
    /* parallel ones: the middle of the part where they face each other, so that the answer does not hop between its ends */
    if (!(nn > 1e-20 * uu * vv)) {
        real at0 = uw / uu, at1 = (uw + uv) / uu;
        real lo = real_clamp(real_min(at0, at1), 0, 1), hi = real_clamp(real_max(at0, at1), 0, 1);
        *s = 0.5 * (lo + hi);
    } else {
        *s = real_clamp(vec3_dot(vec3_cross(w, v), n) / nn, 0, 1);
    }
    *t = vv > 0 ? (*s * uv - vw) / vv : 0;
    if (*t < 0 || *t > 1) {
        *t = real_clamp(*t, 0, 1);
        *s = real_clamp((uw + *t * uv) / uu, 0, 1);
    }
}

/* From a gap of cores to the gap of surfaces. */
static void add_rounding(const Pair *p, ConvexGap *g)
{
    g->gap -= p->a->round + p->b->round;
    g->on_a = vec3_mad(g->on_a, p->a->round, g->normal);
    g->on_b = vec3_mad(g->on_b, -p->b->round, g->normal);
}

static void flip(ConvexGap *g)
{
    vec3 a = g->on_a;
    g->on_a = g->on_b;
    g->on_b = a;
    g->normal = vec3_neg(g->normal);
}

/* b as seen from a's frame: what was found in b's frame, with the roles exchanged. */
static void from_frame_of_b(const Pair *p, ConvexGap *g)
{
    g->normal = mat3_mul_vec(p->c.turn, g->normal);
    g->on_a = convex_point_b(&p->c, g->on_a);
    g->on_b = convex_point_b(&p->c, g->on_b);
    flip(g);
}

static void plane_gap(const ConvexPair *c, ConvexGap *g)
{
    const PlaneData *plane = c->a->data;
    g->normal = plane->normal;
    g->on_b = convex_support_b(c, vec3_neg(g->normal));
    g->gap = vec3_dot(g->normal, g->on_b) - plane->offset;
    g->on_a = vec3_mad(g->on_b, -g->gap, g->normal);
}

static void capsule_gap(const ConvexPair *c, ConvexGap *g)
{
    vec3 p1 = {0, ((const CapsuleData *)c->a->data)->half, 0}, p0 = vec3_neg(p1);
    vec3 half = mat3_mul_vec(c->turn, (vec3){0, ((const CapsuleData *)c->b->data)->half, 0});
    vec3 q0 = vec3_sub(c->shift, half), q1 = vec3_add(c->shift, half), side, other;
    real s, t;
    segment_nearest(p0, p1, q0, q1, &s, &t);
    g->on_a = vec3_lerp(p0, p1, s);
    g->on_b = vec3_lerp(q0, q1, t);
    vec3 d = vec3_sub(g->on_b, g->on_a);
    g->gap = vec3_length(d);
    if (g->gap > 1e-12 * c->size) {
        g->normal = vec3_scale(1 / g->gap, d);
        return;
    }
    vec3_basis((vec3){0, 1, 0}, &side, &other);         /* crossing axes: across both, or across either when parallel */
    g->normal = vec3_unit_or(vec3_cross(vec3_sub(p1, p0), half), side);
    if (vec3_dot(g->normal, c->shift) < 0)
        g->normal = vec3_neg(g->normal);
}

/* A ball b against the core of a. */
static bool ball_gap(const Shape *a, ShapeKind kind, vec3 centre, ConvexGap *g)
{
    g->on_b = centre;
    return point_gap(a, kind, centre, &g->gap, &g->normal, &g->on_a);
}

void pair_gap(const Pair *p, real enough, vec3 *axis, ConvexGap *out)
{
    const ConvexPair *c = &p->c;
    if (p->kind_a == KIND_PLANE) {
        plane_gap(c, out);
    } else if (p->kind_b == KIND_PLANE) {
        Pair s = pair_swapped(p);
        plane_gap(&s.c, out);
        from_frame_of_b(p, out);
    } else if (p->kind_b == KIND_BALL && ball_gap(p->a, p->kind_a, c->shift, out)) {
        /* done */
    } else if (p->kind_a == KIND_BALL && ball_gap(p->b, p->kind_b, vec3_neg(mat3_mul_vec(c->back, c->shift)), out)) {
        from_frame_of_b(p, out);
    } else if (p->kind_a == KIND_CAPSULE && p->kind_b == KIND_CAPSULE) {
        capsule_gap(c, out);
    } else {
        convex_gap(c, enough + p->a->round + p->b->round, axis, out);
    }
    add_rounding(p, out);
}

box3 pair_bounds_b(const Pair *p)
{
    pose at = {p->c.shift, quat_from_matrix(p->c.turn)};
    return p->b->type->bounds(p->b, at);
}

/* ---- surfaces: the least over their pieces ---- */

typedef struct Least { const Pair *p; real enough, gap; vec3 normal, on_a, on_b; uint32_t piece; } Least;

static bool take_piece(void *context, const SurfacePiece *piece)
{
    Least *l = context;
    Shape triangle = triangle_shape(piece->corners);
    Pair p = pair_with_piece(l->p, &triangle, piece->origin);
    ConvexGap g;
    pair_gap(&p, real_min(l->gap, l->enough), NULL, &g);
    if (g.gap < l->gap) {
        l->gap = g.gap;
        l->normal = g.normal;
        l->on_a = vec3_add(g.on_a, piece->origin);
        l->on_b = vec3_add(g.on_b, piece->origin);
        l->piece = piece->number;
    }
    return true;
}

/* Distance of two boxes: no shapes inside them are nearer. */
static real box_gap(box3 a, box3 b)
{
    vec3 d = vec3_max(vec3_max(vec3_sub(a.low, b.high), vec3_sub(b.low, a.high)), vec3_zero());
    return vec3_length(d);
}

/* Grows the searched box until it holds the nearest piece for sure: all pieces within the distance found meet it. */
static void surface_gap(const Pair *p, real enough, ConvexGap *out)
{
    box3 whole = p->a->type->bounds(p->a, pose_identity()), box = pair_bounds_b(p);
    real grow = box_gap(whole, box), limit = grow + vec3_length(vec3_sub(whole.high, whole.low)) + p->b->outer;
    Least l = {.p = p, .enough = enough, .gap = INFINITY};

    if (grow > enough) {
        *out = (ConvexGap){.gap = grow, .normal = {0, 1, 0}};
        return;
    }
    grow = grow * (1 + 1e-9) + 0.1 * p->b->outer;
    for (;;) {
        surface_visit(p->a, box3_grow(box, real_min(grow, enough)), take_piece, &l);
        if (l.gap <= grow || grow >= real_min(limit, enough))
            break;
        grow = l.gap < INFINITY ? l.gap : 4 * grow;
    }
    *out = (ConvexGap){l.gap, l.normal, l.on_a, l.on_b};
    /* wholly inside a solid: as deep as the way to the surface and once through it */
    vec3 middle = convex_point_b(&p->c, shape_middle(p->b));
    if (l.gap > 0 && box3_overlap(whole, (box3){middle, middle}) && p->a->type->contains(p->a, middle)) {
        out->gap = -(l.gap + 2 * p->b->inner);
        out->normal = vec3_neg(l.normal);
    }
    if (l.gap == INFINITY)              /* nothing as near as `enough` */
        *out = (ConvexGap){.gap = enough < INFINITY ? enough * (1 + 1e-12) + 1e-300 : INFINITY, .normal = {0, 1, 0}};
}

real shape_distance(const Shape *a, pose pa, const Shape *b, pose pb, real enough, vec3 *normal, vec3 *on_a, vec3 *on_b)
{
    Pair p = pair_make(a, pa, b, pb);
    ConvexGap g = {.gap = INFINITY, .normal = {0, 1, 0}};
    if (kinds_meet(a, p.kind_a, b, p.kind_b)) {
        if (in_pieces(p.kind_a, p.kind_b)) {
            surface_gap(&p, enough, &g);
        } else if (in_pieces(p.kind_b, p.kind_a)) {
            Pair s = pair_swapped(&p);
            surface_gap(&s, enough, &g);
            from_frame_of_b(&p, &g);
        } else {
            pair_gap(&p, enough, NULL, &g);
        }
    }
    if (normal)
        *normal = pair_direction(&p, g.normal);
    if (on_a)
        *on_a = pair_point(&p, g.on_a);
    if (on_b)
        *on_b = pair_point(&p, g.on_b);
    return g.gap;
}
