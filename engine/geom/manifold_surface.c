/* geom/manifold_surface.c - contacts with meshes and height fields: one manifold per triangle, without ghosts at inner edges.
 *
 * A triangle alone is met at its edges in directions that the whole surface does not have there. A normal counts at an edge or
 * corner only if the neighbours lie behind the plane across it; otherwise the triangle may only push along its own normal. */
#include "geom/pair.h"

#define IN_FEATURE 1e-6     /* of the triangle: corners that lie equally far along the normal */
#define BEHIND     1e-7     /* rad: neighbours may stand this much above the plane across the normal */
#define DEEP       1e-2     /* of the inner radius of b: sunk as deep as that, a triangle asks whether another one is nearer */
#define CREASE     1e-3     /* rad: edges as blunt as that are met as they come */
#define RING       64       /* most triangles looked at around a corner */
#define SAME_POINT 1e-9     /* of the smaller shape */
#define SAME_AXIS  1e-6     /* rad */
#define BACKWARD   -0.999999    /* cosine: straight through the triangle */
#define WALK       16       /* most triangles from where something touches to where its middle is */

typedef struct Meeting {
    const Pair *p;          /* a: the surface, b: the convex */
    bool      solid;        /* only the front of its triangles is met */
    bool      field;        /* pushed up from any depth */
    Manifold *out;
    uint32_t *piece;
    int       count, capacity;
} Meeting;

static vec3 front_of(const vec3 c[3]) { return vec3_unit_or(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])), vec3_zero()); }

static bool stands_behind(vec3 corner, vec3 from, vec3 n)
{
    vec3 d = vec3_sub(corner, from);
    return vec3_dot(n, d) <= BEHIND * vec3_length(d);
}

static int corner_at(const vec3 corners[3], vec3 v)
{
    for (int k = 0; k < 3; k++)
        if (vec3_equal(corners[k], v))
            return k;
    return -1;
}

typedef bool PieceTest(const void *context, const Shape *s, const vec3 c[3]);

/* Do all triangles around corner v, met one after the other across edges that start (or end) there, pass the test? */
static bool ring_passes(const Shape *s, uint32_t start, vec3 v, PieceTest *test, const void *context)
{
    for (int way = 0; way < 2; way++) {
        uint32_t at = start;
        for (int step = 0; step < RING; step++) {
            vec3 c[3];
            s->type->piece(s, at, c);
            int k = corner_at(c, v);
            if (k < 0)
                return true;
            if (!test(context, s, c))
                return false;
            at = s->type->neighbour(s, at, way == 0 ? k : (k + 2) % 3);
            if (at == start)
                return true;
            if (at == SHAPE_NO_PIECE)
                break;
        }
    }
    return true;
}

typedef struct Across { vec3 corner, n; } Across;

static bool lies_behind(const void *context, const Shape *s, const vec3 c[3])
{
    const Across *x = context;
    (void)s;
    return stands_behind(c[0], x->corner, x->n) && stands_behind(c[1], x->corner, x->n) && stands_behind(c[2], x->corner, x->n);
}

/* May the surface push along n (frame of the surface) where this piece is farthest along n? */
static bool allowed(const Shape *s, const SurfacePiece *piece, real size, vec3 n)
{
    vec3 c[3];
    real high[3], top = -INFINITY;
    bool in[3];
    s->type->piece(s, piece->number, c);
    for (int k = 0; k < 3; k++) {
        high[k] = vec3_dot(n, piece->corners[k]);
        top = real_max(top, high[k]);
    }
    for (int k = 0; k < 3; k++)
        in[k] = high[k] >= top - IN_FEATURE * size;

    for (int k = 0; k < 3; k++) {
        int next = (k + 1) % 3;
        if (in[k] && in[next]) {
            uint32_t other = s->type->neighbour(s, piece->number, k);
            if (other == SHAPE_NO_PIECE)
                return true;
            vec3 far_side[3];
            s->type->piece(s, other, far_side);
            for (int i = 0; i < 3; i++)
                if (!vec3_equal(far_side[i], c[k]) && !vec3_equal(far_side[i], c[next]) && !stands_behind(far_side[i], c[k], n))
                    return false;
            return true;
        }
    }
    for (int k = 0; k < 3; k++)
        if (in[k])
            return ring_passes(s, piece->number, c[k], lies_behind, &(Across){c[k], n});
    return true;
}

/* ---- keeping manifolds ---- */

static real deepest(const Manifold *m)
{
    real least = INFINITY;
    for (int i = 0; i < m->count; i++)
        least = real_min(least, m->points[i].gap);
    return least;
}

/* Points on edges that two triangles share are found twice: once is enough. */
static void drop_known_points(const Meeting *meet, Manifold *m, real same)
{
    int kept = 0;
    for (int i = 0; i < m->count; i++) {
        bool known = false;
        for (int k = 0; k < meet->count && !known; k++) {
            const Manifold *old = &meet->out[k];
            if (!(vec3_distance(old->normal, m->normal) < SAME_AXIS))
                continue;
            for (int j = 0; j < old->count; j++)
                known = known || vec3_distance(old->points[j].b, m->points[i].b) < same;
        }
        if (!known)
            m->points[kept++] = m->points[i];
    }
    m->count = kept;
}

/* When there is no room the shallowest goes. */
static void keep(Meeting *meet, Manifold *m, uint32_t piece)
{
    int at = meet->count;
    drop_known_points(meet, m, pair_same(meet->p, SAME_POINT));
    if (m->count == 0)
        return;
    if (at == meet->capacity) {
        at = 0;
        for (int i = 1; i < meet->count; i++)
            if (deepest(&meet->out[i]) > deepest(&meet->out[at]))
                at = i;
        if (deepest(m) >= deepest(&meet->out[at]))
            return;
    } else {
        meet->count++;
    }
    meet->out[at] = *m;
    if (meet->piece)
        meet->piece[at] = piece;
}

/* ---- one triangle ---- */

/* Has the surface an edge here that juts out, or ends? If not, the triangle can only be met along its own normal: what its
 * corners may be part of belongs to other triangles too. */
static bool juts_out(const Shape *s, const SurfacePiece *piece, vec3 front)
{
    vec3 c[3], far_side[3];
    s->type->piece(s, piece->number, c);
    for (int k = 0; k < 3; k++) {
        uint32_t other = s->type->neighbour(s, piece->number, k);
        if (other == SHAPE_NO_PIECE)
            return true;
        s->type->piece(s, other, far_side);
        for (int i = 0; i < 3; i++) {
            vec3 d = vec3_sub(far_side[i], c[k]);
            if (vec3_dot(front, d) < -BEHIND * vec3_length(d))
                return true;
        }
    }
    return false;
}

static bool over_triangle(const vec3 c[3], vec3 q)
{
    vec3 n = vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0]));
    for (int k = 0; k < 3; k++)
        if (vec3_dot(vec3_cross(n, vec3_sub(c[(k + 1) % 3], c[k])), vec3_sub(q, c[k])) < 0)
            return false;
    return true;
}

/* One triangle of a convex corner or edge: is b at most half as deep behind a neighbour's plane as behind its own? What lies behind
 * both is met through the nearer face. */
typedef struct Rival { const Shape *surface; const Pair *p; const SurfacePiece *piece; vec3 front; bool turned; real depth; } Rival;

static bool is_no_rival(const void *context, const Shape *s, const vec3 c[3])
{
    const Rival *r = context;
    vec3 n = front_of(c), from = vec3_sub(c[0], r->piece->origin);
    (void)s;
    n = r->turned ? vec3_neg(n) : n;
    for (int k = 0; k < 3; k++)
        if (!stands_behind(r->piece->corners[k], from, n) ||
            !stands_behind(vec3_sub(c[k], r->piece->origin), r->piece->corners[0], r->front))
            return true;                        /* no convex corner */
    real depth = r->p->b->round - vec3_dot(n, vec3_sub(convex_support_b(&r->p->c, vec3_neg(n)), from));
    return depth > 0.5 * r->depth;
}

/* A thin plate under the edge of a box of triangles reaches behind the plane of the box's side, too: there by half its width. */
static bool neighbour_is_nearer(const Rival *r)
{
    if (!(r->depth > DEEP * r->p->b->inner))
        return false;
    const Shape *s = r->surface;
    vec3 c[3];
    s->type->piece(s, r->piece->number, c);
    for (int k = 0; k < 3; k++)
        if (!ring_passes(s, r->piece->number, c[k], is_no_rival, r))
            return true;
    return false;
}

/* Does this triangle rise from triangle `other`, and is the ball over that, and nearer to it than to this plane? */
static bool rises_from(const Rival *r, uint32_t other, vec3 centre)
{
    vec3 c[3];
    bool rises = false;
    r->surface->type->piece(r->surface, other, c);
    for (int i = 0; i < 3; i++) {
        c[i] = vec3_sub(c[i], r->piece->origin);
        vec3 d = vec3_sub(c[i], r->piece->corners[0]);
        rises = rises || vec3_dot(r->front, d) > CREASE * vec3_length(d);
    }
    if (!rises || !over_triangle(c, centre))
        return false;
    vec3 n = front_of(c);
    return vec3_dot(r->turned ? vec3_neg(n) : n, vec3_sub(centre, c[0])) <= r->p->b->round - r->depth;
}

/* Is the ball, whose foot on this plane is at q, over the triangle across an edge from which this one rises, or one beside that? Between
 * two planes it is to know of both: when its foot comes over this triangle it would long have sunk into it. */
static bool comes_to_crease(const Rival *r, vec3 q)
{
    const vec3 *c = r->piece->corners;
    const Shape *s = r->surface;
    vec3 own = r->turned ? vec3_neg(r->front) : r->front, centre = convex_point_b(&r->p->c, shape_middle(r->p->b));
    for (int k = 0; k < 3; k++) {
        vec3 outward = vec3_unit_or(vec3_cross(vec3_sub(c[(k + 1) % 3], c[k]), own), vec3_zero());
        real beside = vec3_dot(outward, vec3_sub(q, c[k]));
        uint32_t other = s->type->neighbour(s, r->piece->number, k);
        if (!(beside > 0) || beside > r->p->reach || other == SHAPE_NO_PIECE)
            continue;
        if (rises_from(r, other, centre))
            return true;
        for (int i = 0; i < 3; i++) {
            uint32_t next = s->type->neighbour(s, other, i);
            if (next != SHAPE_NO_PIECE && next != r->piece->number && rises_from(r, next, centre))
                return true;
        }
    }
    return false;
}

/* The triangle met along its own normal: with what of b lies over it. */
static int meet_flat(const Pair *p, vec3 front, const Rival *rival, Manifold *m)
{
    if (neighbour_is_nearer(rival))
        return 0;
    const vec3 *c = p->a->data;
    ConvexGap g = {.normal = front};
    g.on_b = vec3_mad(convex_support_b(&p->c, vec3_neg(front)), -p->b->round, front);
    g.gap = vec3_dot(front, vec3_sub(g.on_b, c[0]));
    g.on_a = vec3_mad(g.on_b, -g.gap, front);
    bool over = over_triangle(c, g.on_b);
    if (p->kind_b == KIND_BALL)
        return over || (g.gap > 0 && comes_to_crease(rival, g.on_b)) ? contacts_single(p, &g, m) : 0;
    if (!over)
        g.gap = INFINITY;                       /* its lowest point lies beside: only clipped corners count */
    return collide_faces(p, &g, m);
}

/* The general way: the nearest points decide, if the surface can push that way at all. */
static int meet_sharp(const Meeting *meet, const Pair *p, const SurfacePiece *piece, vec3 front, real centre, const Rival *rival, Manifold *m)
{
    ConvexGap g;
    pair_gap(p, p->reach, NULL, &g);
    if (g.gap > p->reach)
        return 0;
    real cosine = vec3_dot(front, g.normal);
    bool own = cosine > 0 && vec3_length(vec3_cross(front, g.normal)) < SAME_AXIS;
    if (own || (cosine > BACKWARD && allowed(meet->p->a, piece, p->a->outer, g.normal)))
        return p->kind_b == KIND_BALL ? contacts_single(p, &g, m) : collide_faces(p, &g, m);

    if (cosine < 0 && (g.gap > 0 || !meet->solid))
        return 0;                               /* from behind */
    if (!meet->field && centre < -p->b->inner)
        return 0;                               /* through a wall: its other side decides */
    return meet_flat(p, front, rival, m);
}

/* The edge of the triangle that q lies farthest beyond; -1: it is over the triangle. */
static int edge_beyond(const vec3 c[3], vec3 front, vec3 q)
{
    int edge = -1;
    real most = 0;
    for (int k = 0; k < 3; k++) {
        vec3 outward = vec3_unit_or(vec3_cross(vec3_sub(c[(k + 1) % 3], c[k]), front), vec3_zero());
        real beside = vec3_dot(outward, vec3_sub(q, c[k]));
        if (beside > most) {
            most = beside;
            edge = k;
        }
    }
    return edge;
}

typedef enum Side { IN_FRONT, BEHIND_IT, BEYOND_RIM } Side;

/* On which side of an open surface is b, where this piece is? Its middle tells. Where that is beside the triangle, as that of a rod across a ridge, the
 * triangle's plane does not: the middle is on another side of it without having gone through. So the way to the middle is gone, from triangle to triangle. */
static Side side_of(const Pair *p, uint32_t piece)
{
    const Shape *s = p->a;
    vec3 middle = convex_point_b(&p->c, shape_middle(p->b)), c[3];
    uint32_t at = piece, from = SHAPE_NO_PIECE;
    bool behind = false, own = false;
    for (int step = 0; step < WALK; step++) {
        s->type->piece(s, at, c);
        vec3 front = front_of(c);
        bool before = behind;
        behind = vec3_dot(front, vec3_sub(middle, c[0])) < 0;
        own = step == 0 ? behind : own;
        int edge = p->kind_b == KIND_BALL ? -1 : edge_beyond(c, front, middle);
        uint32_t next = edge < 0 ? SHAPE_NO_PIECE : s->type->neighbour(s, at, edge);
        if (next == SHAPE_NO_PIECE)
            return edge >= 0 ? BEYOND_RIM : behind ? BEHIND_IT : IN_FRONT;
        if (next == from) {                 /* beyond the edge of both: out of a ridge, or under a valley */
            vec3 last[3];
            s->type->piece(s, from, last);
            bool ridge = true;
            for (int k = 0; k < 3; k++)
                ridge = ridge && stands_behind(last[k], c[edge], front);
            return (ridge ? behind && before : behind || before) ? BEHIND_IT : IN_FRONT;
        }
        from = at;
        at = next;
    }
    return own ? BEHIND_IT : IN_FRONT;
}

/* front: of the piece p->a. What hangs over a rim is on the side on which it is nearest. */
static bool is_behind(const Pair *whole, const Pair *p, uint32_t piece, vec3 front)
{
    Side side = side_of(whole, piece);
    ConvexGap g;
    if (side != BEYOND_RIM)
        return side == BEHIND_IT;
    pair_gap(p, INFINITY, NULL, &g);
    return vec3_dot(front, g.normal) < 0;
}

static bool meet_piece(void *context, const SurfacePiece *piece)
{
    Meeting *meet = context;
    Shape triangle = triangle_shape(piece->corners);
    const vec3 *c = piece->corners;
    Pair p = pair_with_piece(meet->p, &triangle, piece->origin);
    Manifold m;
    vec3 front = front_of(c);
    real centre = vec3_dot(front, vec3_sub(convex_point_b(&p.c, shape_middle(p.b)), c[0]));
    bool turned = !meet->solid && is_behind(meet->p, &p, piece->number, front);
    if (turned) {
        front = vec3_neg(front);
        centre = -centre;
    }
    real lowest = vec3_dot(front, vec3_sub(convex_support_b(&p.c, vec3_neg(front)), c[0])) - p.b->round;
    if (lowest > p.reach)
        return true;
    const Rival rival = {meet->p->a, &p, piece, front, turned, -lowest};
    bool flat = (meet->field || centre >= 0) && !juts_out(meet->p->a, piece, front);
    if (flat ? meet_flat(&p, front, &rival, &m) : meet_sharp(meet, &p, piece, front, centre, &rival, &m))
        keep(meet, &m, piece->number);
    return true;
}

int collide_surface(const Pair *p, Manifold *out, uint32_t *piece, int capacity)
{
    bool field = p->a->type == &shape_heightfield;
    Meeting meet = {.p = p, .solid = field || shape_mesh_closed(p->a), .field = field, .out = out, .piece = piece, .capacity = capacity};
    surface_visit(p->a, box3_grow(pair_bounds_b(p), p->reach), meet_piece, &meet);
    return meet.count;
}
