/* geom/manifold_hidden.c - contacts with parts of a fixed shape's surface that other fixed shapes cover.
 *
 * A floor laid out of tiles has a face between each two of them. What slides over the seam overlaps the next tile by rounding, from above
 * and from the side: the side face may be the nearer one, or the edge over it, and stops what slides. This is the ghost edge of meshes
 * (manifold_surface.c) for bodies of their own, which know of no neighbours: here they are told.
 *
 * A direction is a normal of a union of convex solids at a point if it is one of each of them that has the point: the tangents of a union
 * are those of its parts, and its normals are what all of them turn away from (Rockafellar & Wets 1998, 6.5). So none may go on beyond the
 * plane across it there. A contact of which that is not so is met along a face of the fixed shape instead, the one that separates best of
 * those that are not covered; but only if the seam is closed up to that face. In the corner below a step the floor covers the foot of its
 * face, too, and what strikes it there is stopped. */
#include "geom/pair.h"

#define FLUSH  2e-3     /* of the smaller shape of the pair: steps and gaps between fixed shapes up to this are none */
#define ASKEW  1e-6     /* rad: by so much a shape beside may stand above the plane across a normal */
#define TOUCH  0.1      /* times that step: what overlaps no more just touches */
#define LIFT   3        /* times that step: so far before a face there is room, or it is covered */
#define SAME   1e-6     /* rad: a normal this near to a face's is the face's */
#define ALIKE  0.9      /* cosine: what meets a face with an area is less askew to it (manifold_convex.c) */
#define OVER   1e-9     /* of the smaller shape: so far beside a face is over it */

typedef struct Seam {           /* a contact of a fixed shape, what is beside that, and all in world axes */
    const Pair   *p;            /* a: the fixed one */
    const Neighbours *by;
    real          flush;        /* m */
    const Manifold *m;          /* normal out of the fixed one, points a on it */
} Seam;

static real flush_of(const Shape *fixed, const Shape *other) { return FLUSH * real_min(fixed->outer, other->outer); }

/* The six of a box */
static vec3 box_normal(int i)
{
    real sign = i & 1 ? -1 : 1;
    return (vec3){i / 2 == 0 ? sign : 0, i / 2 == 1 ? sign : 0, i / 2 == 2 ? sign : 0};
}

/* Is the point in the shape, or no farther from it than margin? Never in what has no inside, or none here. */
static bool within(const Shape *s, vec3 local, real margin)
{
    vec3 normal, on;
    real gap;
    if (s->type == &shape_plane) {
        const PlaneData *d = s->data;
        return vec3_dot(d->normal, local) - d->offset <= margin;
    }
    if (s->type == &shape_hull) {
        const HullData *h = hull_data(s);
        for (int i = 0; i < h->face_count; i++)
            if (vec3_dot(hull_faces(h)[i].normal, local) - hull_faces(h)[i].offset > margin)
                return false;
        return true;
    }
    return s->type->convex && point_gap(s, shape_kind(s), local, &gap, &normal, &on) && gap - s->round <= margin;
}

static const Beside *neighbour(const Neighbours *by, int i) { return &by->all[by->which[i]]; }

static bool has_point(const Seam *s, const Beside *b, vec3 point) { return within(b->shape, pose_unpoint(b->at, point), s->flush); }

static bool any_has_point(const Seam *s, vec3 point)
{
    for (int i = 0; i < s->by->count; i++)
        if (has_point(s, neighbour(s->by, i), point))
            return true;
    return false;
}

/* Does it go on beyond the plane through the point across n? */
static bool goes_on(const Beside *b, vec3 point, vec3 n)
{
    vec3 local = quat_unrotate(b->at.q, n);
    if (b->shape->type == &shape_plane)
        return vec3_length(vec3_sub(((const PlaneData *)b->shape->data)->normal, local)) > ASKEW;
    vec3 farthest = vec3_mad(b->shape->type->support(b->shape, local), b->shape->round, local), from = pose_unpoint(b->at, point);
    vec3 d = vec3_sub(farthest, from);
    return vec3_dot(local, d) > ASKEW * vec3_length(d);
}

/* One that has this point, and goes on beyond the plane across the contact's normal there: that is none of their surface. */
static bool no_normal(const Seam *s, vec3 point)
{
    for (int i = 0; i < s->by->count; i++)
        if (has_point(s, neighbour(s->by, i), point) && goes_on(neighbour(s->by, i), point, s->m->normal))
            return true;
    return false;
}

/* Shortens from..to to what is not outside a plane by more than margin. False: nothing is left. */
static bool cut(vec3 *from, vec3 *to, vec3 normal, real offset, real margin)
{
    real a = vec3_dot(normal, *from) - offset - margin, b = vec3_dot(normal, *to) - offset - margin;
    if (a > 0 && b > 0)
        return false;
    if (a > 0)
        *from = vec3_lerp(*from, *to, a / (a - b));
    else if (b > 0)
        *to = vec3_lerp(*from, *to, a / (a - b));
    return true;
}

/* A point in the middle of what of from..to, in its own frame, is in the shape. Of round ones only a few points are looked at. */
static bool point_between(const Shape *s, vec3 from, vec3 to, real margin, vec3 *point)
{
    bool in = true;
    if (s->type == &shape_plane) {
        const PlaneData *d = s->data;
        in = cut(&from, &to, d->normal, d->offset, margin);
    } else if (s->type == &shape_hull) {
        const HullData *h = hull_data(s);
        for (int i = 0; i < h->face_count && in; i++)
            in = cut(&from, &to, hull_faces(h)[i].normal, hull_faces(h)[i].offset, margin);
    } else if (s->type == &shape_box) {
        vec3 half = ((const BoxData *)s->data)->half;
        for (int i = 0; i < 6 && in; i++)
            in = cut(&from, &to, box_normal(i), i / 2 == 0 ? half.x : i / 2 == 1 ? half.y : half.z, margin);
    } else {
        for (int i = 0; i <= 4; i++)
            if (within(s, *point = vec3_lerp(from, to, 0.25 * i), margin))
                return true;
        return false;
    }
    *point = vec3_lerp(from, to, 0.5);
    return in;
}

/* ---- faces of the fixed one ---- */

static int face_count(const Shape *s)
{
    return s->type == &shape_box ? 6 : s->type == &shape_hull ? hull_data(s)->face_count : s->type == &shape_cylinder ? 2 : 0;
}

/* In its own frame */
static vec3 face_normal(const Shape *s, int i)
{
    return s->type == &shape_hull ? hull_faces(hull_data(s))[i].normal : box_normal(s->type == &shape_cylinder ? i + 2 : i);
}

/* A face of it: normal in its own frame, and what is between the two along that. */
typedef struct Way { vec3 normal; real height, gap; } Way;

static Way way_out(const Pair *p, vec3 normal)
{
    real height = vec3_dot(normal, convex_support_a(&p->c, normal));
    return (Way){normal, height, vec3_dot(normal, convex_support_b(&p->c, vec3_neg(normal))) - p->b->round - height};
}

/* m  How far a point in world axes is behind the plane of the face */
static real depth_below(const Pair *p, const Way *w, vec3 point)
{
    return w->height - vec3_dot(w->normal, mat3_mul_vec(mat3_transpose(p->axes), vec3_sub(point, p->at.p)));
}

/* Has no point of the contact room before that face? */
static bool covered(const Seam *s, const Way *w)
{
    vec3 out = pair_direction(s->p, w->normal);
    for (int i = 0; i < s->m->count; i++) {
        vec3 point = s->m->points[i].a;
        if (!any_has_point(s, vec3_mad(point, depth_below(s->p, w, point) + LIFT * s->flush, out)))
            return false;
    }
    return true;
}

/* Is the contact's normal that of a face? */
static bool is_normal(const Seam *s, vec3 face) { return vec3_distance(pair_direction(s->p, face), s->m->normal) < SAME; }

/* Is a part of the other before that face? What lies behind it as a whole is on another side, and would be pulled right through. */
static bool stands_out(const Pair *p, vec3 normal, real height)
{
    return vec3_dot(normal, convex_support_b(&p->c, normal)) + p->b->round > height;
}

/* Of those with room before them, the face that separates best of which the other stands out; not that of the contact itself. */
static bool best_way(const Seam *s, Way *best)
{
    best->gap = -INFINITY;
    for (int i = 0, count = face_count(s->p->a); i < count; i++) {
        Way w = way_out(s->p, face_normal(s->p->a, i));
        if (w.gap > best->gap + pair_same(s->p, OVER) && stands_out(s->p, w.normal, w.height) && !is_normal(s, w.normal) && !covered(s, &w))
            *best = w;
    }
    return best->gap > -INFINITY;
}

/* Of the contact's area: its corners, the middles of its edges and its own. */
static int area_points(const Manifold *m) { return m->count == 1 ? 1 : 2 * m->count + 1; }

static vec3 area_point(const Manifold *m, int i)
{
    vec3 sum = vec3_zero();
    if (i < m->count)
        return m->points[i].a;
    if (i < 2 * m->count)
        return vec3_lerp(m->points[i - m->count].a, m->points[(i + 1) % m->count].a, 0.5);
    for (int k = 0; k < m->count; k++)
        sum = vec3_add(sum, m->points[k].a);
    return vec3_scale(1.0 / m->count, sum);
}

/* Is there room before the contact's own face beside the point? A neighbour has what lies in an inner corner, but the face goes on from
 * there, and stops what is in the corner. */
static bool bare_beside(const Seam *s, vec3 point)
{
    static const real along[8] = {1, 1, 0, -1, -1, -1, 0, 1}, across[8] = {0, 1, 1, 1, 0, -1, -1, -1};
    vec3 t, u;
    vec3_basis(s->m->normal, &t, &u);
    for (int i = 0; i < 8; i++) {
        vec3 d = vec3_add(vec3_scale(along[i], t), vec3_scale(across[i], u));
        vec3 foot = vec3_mad(point, LIFT * s->flush, d), farther = vec3_mad(foot, s->flush, d);
        if (within(s->p->a, pose_unpoint(s->p->at, farther), pair_same(s->p, OVER)) &&
            !any_has_point(s, vec3_mad(foot, LIFT * s->flush, s->m->normal)))
            return true;
    }
    return false;
}

static bool at_face(const Seam *s)
{
    bool face = false;
    for (int i = 0, count = face_count(s->p->a); i < count && !face; i++)
        face = is_normal(s, face_normal(s->p->a, i));
    return face;
}

/* Is all of the contact's area closed up to that face, where it is not at the rim of the face? There a contact with nearly the face's own
 * normal is one, if nothing hides it. What fits into a hole touches each wall between two others, which have the corners of that area. */
static bool closed(const Seam *s, const Way *w)
{
    vec3 out = pair_direction(s->p, w->normal);
    bool alike = vec3_dot(out, s->m->normal) > ALIKE, face = at_face(s);
    for (int i = 0; i < area_points(s->m); i++) {
        vec3 point = area_point(s->m, i);
        real below = depth_below(s->p, w, point);
        bool rim = below <= s->flush;
        if (rim ? alike && !no_normal(s, point)
                : !no_normal(s, point) || !any_has_point(s, vec3_mad(point, below, out)) || (face && bare_beside(s, point)))
            return false;
    }
    return true;
}

/* Is the contact, along an edge of its area, at a place that is none of the surface of all of them? Before a face there is no room; across
 * another normal one beside it goes on. */
static bool suspect(const Seam *s)
{
    bool face = at_face(s);
    vec3 lift = face ? vec3_scale(LIFT * s->flush, s->m->normal) : vec3_zero(), point;
    for (int i = 0; i < s->m->count; i++) {
        vec3 from = vec3_add(s->m->points[i].a, lift), to = vec3_add(s->m->points[(i + 1) % s->m->count].a, lift);
        for (int k = 0; k < s->by->count; k++) {
            const Beside *b = neighbour(s->by, k);
            if (point_between(b->shape, pose_unpoint(b->at, from), pose_unpoint(b->at, to), s->flush, &point) &&
                (face || goes_on(b, pose_point(b->at, point), s->m->normal)))
                return true;
        }
    }
    return false;
}

/* Only with what lies over that face: what is beside it is the neighbour's. */
static int meet_face(const Pair *p, const Way *w, Manifold *out)
{
    out->count = 0;
    if (w->gap > p->reach)
        return 0;
    ConvexGap g = {.normal = w->normal, .gap = w->gap};
    g.on_b = vec3_mad(convex_support_b(&p->c, vec3_neg(w->normal)), -p->b->round, w->normal);
    g.on_a = vec3_mad(g.on_b, -w->gap, w->normal);
    bool over = within(p->a, g.on_a, pair_same(p, OVER));
    if (p->kind_b == KIND_BALL)
        return over ? contacts_single(p, &g, out) : 0;
    if (!over)
        g.gap = INFINITY;
    return collide_faces(p, &g, out);
}

static real least_gap(const Manifold *m)
{
    real least = INFINITY;
    for (int i = 0; i < m->count; i++)
        least = real_min(least, m->points[i].gap);
    return least;
}

/* Do the two hardly overlap, by the face or by the contact? Else something would be lost where that has no point over the face: shapes that
 * cross are not taken apart, and what is deep between them is met as it was. So is what the face would throw out: a brick in a wall of
 * bricks touches the next one but one along an edge, and only the front of the wall has room before it. */
static bool shallow(const Seam *s, const Way *instead)
{
    if (instead->gap >= -s->flush)
        return true;
    Manifold there;
    return least_gap(s->m) >= -TOUCH * s->flush && (meet_face(s->p, instead, &there) == 0 || least_gap(&there) >= -s->flush);
}

/* Is the contact none of the surface of all of them? Then instead is the face that stands in for it. */
static bool hidden(const Seam *s, Way *instead) { return suspect(s) && best_way(s, instead) && shallow(s, instead) && closed(s, instead); }

/* Has the fixed one faces that can stand in for each other, and the contact points near what is beside it? */
static bool can_hide(const Shape *fixed, const Shape *other, const Neighbours *by, const Manifold *m)
{
    if (m->count == 0 || !other->type->convex || face_count(fixed) == 0)
        return false;
    box3 points = {m->points[0].a, m->points[0].a};
    for (int i = 1; i < m->count; i++)
        points = (box3){vec3_min(points.low, m->points[i].a), vec3_max(points.high, m->points[i].a)};
    points = box3_grow(points, (LIFT + 1) * flush_of(fixed, other));
    for (int i = 0; i < by->count; i++)
        if (box3_overlap(points, neighbour(by, i)->box))
            return true;
    return false;
}

bool manifold_hidden(const Shape *fixed, pose at, const Shape *other, pose other_at, const Neighbours *by, const Manifold *m)
{
    if (!can_hide(fixed, other, by, m))
        return false;
    Pair p = pair_make(fixed, at, other, other_at);
    Way instead;
    return hidden(&(Seam){&p, by, flush_of(fixed, other), m}, &instead);
}

bool manifold_uncover(const Shape *fixed, pose at, const Shape *other, pose other_at, real reach, const Neighbours *by, Manifold *m)
{
    if (!can_hide(fixed, other, by, m))
        return false;
    Pair p = pair_make(fixed, at, other, other_at);
    Way instead;
    p.reach = reach;
    if (!hidden(&(Seam){&p, by, flush_of(fixed, other), m}, &instead))
        return false;
    meet_face(&p, &instead, m);
    return true;
}
