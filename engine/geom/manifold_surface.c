/* geom/manifold_surface.c - contacts with meshes and height fields: one manifold per triangle, without ghosts at inner edges.
 *
 * A triangle alone is met at its edges in directions that the whole surface does not have there. A normal counts at an edge or
 * corner only if the neighbours lie behind the plane across it; otherwise the triangle may only push along its own normal. */
#include "geom/pair.h"

#define IN_FEATURE 1e-6     /* of the triangle: corners that lie equally far along the normal */
#define BEHIND     1e-7     /* rad: neighbours may stand this much above the plane across the normal */
#define RING       64       /* most triangles looked at around a corner */
#define SAME_POINT 1e-9     /* of the smaller shape */
#define SAME_AXIS  1e-6     /* rad */

typedef struct Meeting {
    const Pair *p;          /* a: the surface, b: the convex */
    bool      solid;        /* only the front of its triangles is met */
    bool      field;        /* pushed up from any depth */
    Manifold *out;
    uint32_t *piece;
    int       count, capacity;
} Meeting;

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

/* Do the triangles around corner v, met one after the other across edges that start (or end) there, lie behind? */
static bool ring_behind(const Shape *s, uint32_t start, vec3 v, vec3 n)
{
    for (int way = 0; way < 2; way++) {
        uint32_t at = start;
        for (int step = 0; step < RING; step++) {
            vec3 c[3];
            s->type->piece(s, at, c);
            int k = corner_at(c, v);
            if (k < 0)
                return true;
            if (!stands_behind(c[(k + 1) % 3], v, n) || !stands_behind(c[(k + 2) % 3], v, n))
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
            return ring_behind(s, piece->number, c[k], n);
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

/* A normal that the surface does not have: only the triangle's own remains, with what of b lies over the triangle. */
static bool use_own_normal(const Meeting *meet, const Pair *p, vec3 front, ConvexGap *g)
{
    bool from_behind = vec3_dot(g->normal, front) < 0;
    if (from_behind && (g->gap > 0 || !meet->solid))
        return false;
    const vec3 *c = p->a->data;
    real centre = vec3_dot(front, vec3_sub(p->c.shift, c[0]));
    if (!meet->field && centre < -p->b->inner)
        return false;                           /* through a wall: its other side decides */
    vec3 lowest = vec3_mad(convex_support_b(&p->c, vec3_neg(front)), -p->b->round, front);
    g->normal = front;
    g->gap = vec3_dot(front, vec3_sub(lowest, c[0]));
    g->on_b = lowest;
    g->on_a = vec3_mad(lowest, -g->gap, front);
    return g->gap <= p->reach;
}

static bool over_triangle(const vec3 c[3], vec3 n, vec3 q)
{
    for (int k = 0; k < 3; k++)
        if (vec3_dot(vec3_cross(n, vec3_sub(c[(k + 1) % 3], c[k])), vec3_sub(q, c[k])) < 0)
            return false;
    return true;
}

static bool meet_piece(void *context, const SurfacePiece *piece)
{
    Meeting *meet = context;
    Shape triangle = triangle_shape(piece->corners);
    const vec3 *c = piece->corners;
    Pair p = pair_with_piece(meet->p, &triangle, piece->origin);
    ConvexGap g;
    Manifold m;
    pair_gap(&p, p.reach, NULL, &g);
    if (g.gap > p.reach)
        return true;
    vec3 front = vec3_unit_or(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])), vec3_zero());
    if (!meet->solid && vec3_dot(front, p.c.shift) < 0)
        front = vec3_neg(front);
    bool own = vec3_dot(front, g.normal) > 0 && vec3_length(vec3_cross(front, g.normal)) < SAME_AXIS;
    bool forced = !own && (vec3_dot(front, g.normal) < -0.999999 || !allowed(meet->p->a, piece, triangle.outer, g.normal));
    if (forced && !use_own_normal(meet, &p, front, &g))
        return true;

    if (p.kind_b == KIND_BALL) {
        if (!forced || over_triangle(c, front, g.on_b))
            if (contacts_single(&p, &g, &m))
                keep(meet, &m, piece->number);
        return true;
    }
    if (forced)
        g.gap = INFINITY;                       /* its lowest point may lie beside the triangle: only clipped corners count */
    if (collide_faces(&p, &g, &m))
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
