/* geom/manifold.c - which way each pair of shapes is met. */
#include "geom/pair.h"

#define ON_SURFACE 1e-10        /* of the smaller shape */
#define FOOT 0.05               /* of the size of a mesh: corners that much higher are none of its foot */

/* Balls have one point on the line through their centres. */
static int collide_balls(const Shape *a, pose pa, const Shape *b, pose pb, real reach, Manifold *out)
{
    vec3 d = vec3_sub(pb.p, pa.p);
    real length2 = vec3_length2(d), sum = a->round + b->round;
    if (length2 > (sum + reach) * (sum + reach))
        return 0;
    real length = sqrt(length2);
    out->normal = length > 0 ? vec3_scale(1 / length, d) : vec3_unit(d);
    out->count = 1;
    out->points[0] = (ManifoldPoint){vec3_mad(pa.p, a->round, out->normal), vec3_mad(pb.p, -b->round, out->normal), length - sum, 0};
    return length - sum <= reach;
}

/* What there is no closed form for. */
static int collide_ball(const Pair *p, ManifoldCache *cache, Manifold *out)
{
    (void)cache;
    ConvexGap g;
    pair_gap(p, p->reach, NULL, &g);
    return g.gap <= p->reach ? contacts_single(p, &g, out) : 0;
}

/* A ball b, in the frame of a alone, for of its own turn nothing is seen. False: there is no closed form. */
static bool collide_centre(const Shape *a, ShapeKind kind, pose pa, const Shape *ball, vec3 centre, real reach, Manifold *out, int *count)
{
    mat3 axes = quat_matrix(pa.q);
    vec3 local = mat3_mul_vec(mat3_transpose(axes), vec3_sub(centre, pa.p)), n, on;
    real gap;
    if (!point_gap(a, kind, local, &gap, &n, &on))
        return false;
    gap -= a->round + ball->round;
    *count = gap <= reach ? 1 : 0;
    if (*count == 0)
        return true;
    on = vec3_mad(on, a->round, n);
    local = vec3_mad(local, -ball->round, n);
    out->normal = mat3_mul_vec(axes, n);
    out->count = 1;
    out->points[0] = (ManifoldPoint){vec3_add(pa.p, mat3_mul_vec(axes, on)), vec3_add(pa.p, mat3_mul_vec(axes, local)), gap, 0};
    return true;
}

static int collide_capsules(const Pair *p, ManifoldCache *cache, Manifold *out)
{
    (void)cache;
    ConvexGap g;
    pair_gap(p, p->reach, NULL, &g);
    return g.gap <= p->reach ? collide_faces(p, &g, out) : 0;
}

static void add_below(const Pair *p, vec3 core_point, real offset, uint32_t feature, Contacts *c)
{
    vec3 on_b = vec3_mad(core_point, -p->b->round, c->normal);
    vec3 on_a = vec3_mad(on_b, offset - vec3_dot(c->normal, on_b), c->normal);
    contacts_add(c, p->reach, on_a, on_b, feature);
}

/* A plane and a mesh. Of corners far above the deepest one none is taken: what stands on its foot need not touch with what sticks out. */
static int collide_foot(const Pair *p, vec3 down, vec3 deepest, Contacts *c, Manifold *out)
{
    const PlaneData *plane = p->a->data;
    vec3 corner[SHAPE_FOOT];
    uint32_t feature[SHAPE_FOOT];
    real gap = vec3_dot(c->normal, deepest) - plane->offset, height = real_min(p->reach - gap, FOOT * p->b->outer);
    int count = p->b->type->foot(p->b, down, real_max(height, pair_same(p, ON_SURFACE)), corner, feature);
    for (int i = 0; i < count; i++)
        add_below(p, convex_point_b(&p->c, corner[i]), plane->offset, feature[i], c);
    return contacts_finish(p, c, out);
}

/* A plane and a convex: the corners of the face that looks down, and the deepest point where that is none of them (a rim). */
static int collide_plane(const Pair *p, ManifoldCache *cache, Manifold *out)
{
    (void)cache;
    const PlaneData *plane = p->a->data;
    vec3 down = mat3_mul_vec(p->c.back, vec3_neg(plane->normal)), corner[16];
    vec3 deepest = convex_support_b(&p->c, vec3_neg(plane->normal));
    uint32_t face = 0;
    real lowest = INFINITY;
    Contacts c;
    c.normal = plane->normal;
    c.count = 0;
    if (vec3_dot(c.normal, deepest) - plane->offset - p->b->round > p->reach)
        return 0;

    int count = 2;
    if (p->kind_b == KIND_SURFACE)
        return collide_foot(p, down, deepest, &c, out);
    if (p->kind_b == KIND_CAPSULE) {                    /* both ends, however it stands */
        corner[1] = (vec3){0, ((const CapsuleData *)p->b->data)->half, 0};
        corner[0] = vec3_neg(corner[1]);
    } else {
        count = p->b->type->face(p->b, down, corner, &face);
    }
    for (int i = 0; i < count; i++) {
        vec3 q = convex_point_b(&p->c, corner[i]);
        lowest = real_min(lowest, vec3_dot(c.normal, q));
        add_below(p, q, plane->offset, face << 8 | (uint32_t)i, &c);
    }
    if (vec3_dot(c.normal, deepest) < lowest - pair_same(p, ON_SURFACE))
        add_below(p, deepest, plane->offset, face << 8 | 255, &c);
    return contacts_finish(p, &c, out);
}

typedef int CollidePair(const Pair *p, ManifoldCache *cache, Manifold *out);

typedef struct PairRow { CollidePair *collide; bool swapped; } PairRow;

static PairRow row_for(ShapeKind a, ShapeKind b)
{
    if (a == KIND_PLANE || b == KIND_PLANE)
        return (PairRow){collide_plane, a != KIND_PLANE};
    if (a == KIND_BALL || b == KIND_BALL)
        return (PairRow){collide_ball, false};
    if (a == KIND_BOX && b == KIND_BOX)
        return (PairRow){collide_boxes, false};
    if (a == KIND_CAPSULE && b == KIND_CAPSULE)
        return (PairRow){collide_capsules, false};
    return (PairRow){collide_convex, false};
}

static int collide_any_surface(const Pair *p, Manifold *out, uint32_t *piece, int capacity)
{
    if (p->kind_a == KIND_SURFACE)
        return collide_surface(p, out, piece, capacity);
    Pair s = pair_swapped(p);
    int count = collide_surface(&s, out, piece, capacity);
    for (int i = 0; i < count; i++)
        manifold_mirror(&out[i]);
    return count;
}

int manifold_collide(const Shape *a, pose pa, const Shape *b, pose pb, real reach, ManifoldCache *cache, Manifold *out, uint32_t *piece,
                     int capacity)
{
    ShapeKind ka = shape_kind(a), kb = shape_kind(b);
    if (capacity < 1 || !kinds_meet(a, ka, b, kb))
        return 0;
    if (piece)
        piece[0] = 0;
    if (ka == KIND_BALL && kb == KIND_BALL)
        return collide_balls(a, pa, b, pb, reach, out);

    int found;
    if (kb == KIND_BALL && ka < KIND_PLANE && collide_centre(a, ka, pa, b, pb.p, reach, out, &found))
        return found;
    Pair p = pair_make(a, pa, b, pb);
    p.reach = reach;
    if (in_pieces(ka, kb) || in_pieces(kb, ka))
        return collide_any_surface(&p, out, piece, capacity);
    PairRow row = row_for(ka, kb);
    if (!row.swapped)
        return row.collide(&p, cache, out);
    Pair s = pair_swapped(&p);
    int count = row.collide(&s, cache, out);
    if (count)
        manifold_mirror(out);
    return count;
}
