/* trace/feature.c - what touches at a contact point: a vertex on a face, an edge across an edge, a ball or a rim on either.
 *
 * A feature is frozen: as long as it is the right one, its gap is a smooth function of the two poses, and every rate below is
 * exact. Derivations: the material of a body moves as v + w x r; a direction c fixed in it as dc/dt = w x c.
 */
#include "math/pair.h"
#include "trace/trace.h"

#define ALIGNED  1e-6       /* sine: a face this square to the normal is the one that touches   */
#define ON_EDGE  1e-7       /* of the size: a point this near to an edge is on it               */
#define CROSSING 0.05       /* sine: edges more parallel than this meet along a line            */

bool feature_kind_known(const Shape *s)
{
    return s->type == &shape_sphere || s->type == &shape_box || s->type == &shape_capsule || s->type == &shape_hull || s->type == &shape_plane
        || s->type == &shape_cylinder;
}

/* ---- finding ---- */

typedef enum Spot { SPOT_POINT, SPOT_LINE, SPOT_FACE, SPOT_RIM } Spot;
/* In the shape's frame. On a face: 2 at one of its corners, 1 on an edge of its rim, 0 inside. */
typedef struct Place { Spot spot; vec3 p, d; int rim; vec3 edge; real round; } Place;      /* round: m, of what is round about p or d */

static vec3 axis_of(int i, real length) { return (vec3){i == 0 ? length : 0, i == 1 ? length : 0, i == 2 ? length : 0}; }

static Place place_on_box(const Shape *s, vec3 p, vec3 toward)
{
    const vec3 half = ((const BoxData *)s->data)->half;
    const real h[3] = {half.x, half.y, half.z}, to[3] = {toward.x, toward.y, toward.z};
    real at[3] = {p.x, p.y, p.z}, same = ON_EDGE * s->outer;
    int on = 0, across = 0, along = 0;
    for (int i = 0; i < 3; i++) {
        if (fabs(at[i]) >= h[i] - same) {
            at[i] = copysign(h[i], at[i]);      /* onto it, without the manifold's rounding */
            on++;
        } else {
            along = i;
        }
        if (fabs(to[i]) > fabs(to[across]))
            across = i;
    }
    vec3 face = axis_of(across, copysign(1, to[across])), line = axis_of(along, 1);
    bool square = vec3_length2(vec3_cross(face, toward)) < ALIGNED * ALIGNED;
    if (square)
        at[across] = copysign(h[across], to[across]);
    return (Place){.spot = square || on < 2 ? SPOT_FACE : on == 2 ? SPOT_LINE : SPOT_POINT, .p = {at[0], at[1], at[2]},
                   .d = on == 2 && !square ? line : face, .rim = on >= 3 ? 2 : on == 2 ? 1 : 0, .edge = line};
}

static Place place_on_hull(const Shape *s, vec3 p, vec3 toward)
{
    const HullData *h = hull_data(s);
    const vec3 *v = hull_vertices(h);
    real same = ON_EDGE * s->outer;
    Place r = {.spot = SPOT_FACE, .p = p};
    int best = 0;
    for (int i = 1; i < h->face_count; i++)
        if (vec3_dot(hull_faces(h)[i].normal, toward) > vec3_dot(hull_faces(h)[best].normal, toward))
            best = i;
    r.d = hull_faces(h)[best].normal;
    bool square = vec3_length(vec3_cross(r.d, toward)) < ALIGNED;
    if (square)
        r.p = vec3_mad(p, hull_faces(h)[best].offset - vec3_dot(r.d, p), r.d);
    for (int i = 0; i < h->vertex_count; i++)
        if (vec3_distance(v[i], p) < same) {
            r.p = v[i];
            r.spot = square ? SPOT_FACE : SPOT_POINT;
            r.rim = 2;
            return r;
        }
    for (int i = 0; i < h->edge_count; i++) {
        vec3 tail = v[hull_edges(h)[i].tail], head = v[hull_edges(h)[i].head], d = vec3_unit(vec3_sub(head, tail)), from = vec3_sub(p, tail);
        if (vec3_length(vec3_mad(from, -vec3_dot(from, d), d)) > same)
            continue;
        r.rim = 1;
        r.edge = d;
        r.p = vec3_mad(tail, vec3_dot(from, d), d);
        if (!square) {
            r.spot = SPOT_LINE;
            r.d = d;
        }
        return r;
    }
    return r;
}

static Place place_on_capsule(const Shape *s, vec3 p)
{
    real h = ((const CapsuleData *)s->data)->half;
    bool end = fabs(p.y) >= h * (1 - ON_EDGE);
    return (Place){.spot = end ? SPOT_POINT : SPOT_LINE, .p = {0, end ? copysign(h, p.y) : p.y, 0}, .d = {0, 1, 0}};
}

/* An end square to the normal is a face, and what touches is fixed to it. Elsewhere the circle round the end touches where it is
 * nearest, or the side along a line. */
static Place place_on_cylinder(const Shape *s, vec3 p, vec3 toward)
{
    const CylinderData *c = s->data;
    real same = ON_EDGE * s->outer, from_axis = hypot(p.x, p.z), end = copysign(c->half, toward.y);
    if (hypot(toward.x, toward.z) < ALIGNED * vec3_length(toward))
        return (Place){.spot = SPOT_FACE, .p = {p.x, end, p.z}, .d = {0, copysign(1, end), 0}, .rim = from_axis > c->radius - same ? 2 : 0};
    if (fabs(p.y) > c->half - same && from_axis > c->radius - same)
        return (Place){.spot = SPOT_RIM, .p = {0, copysign(c->half, p.y), 0}, .d = {0, 1, 0}, .round = c->radius};
    return (Place){.spot = SPOT_LINE, .p = {0, p.y, 0}, .d = {0, 1, 0}, .round = c->radius};
}

/* Does it matter from where it is touched? */
static inline bool has_sides(const Shape *s) { return s->type != &shape_sphere && s->type != &shape_plane; }

/* point: in the world, on or near the core; at, toward: see Sides. */
INLINE Place place_on(const Shape *s, const pose *at, vec3 point, const vec3 *toward)
{
    if (s->type == &shape_sphere)
        return (Place){.spot = SPOT_POINT};             /* its centre */
    vec3 p = pose_unpoint(*at, point);
    if (s->type == &shape_box)
        return place_on_box(s, p, *toward);
    if (s->type == &shape_plane) {
        const PlaneData *plane = s->data;
        return (Place){.spot = SPOT_FACE, .p = vec3_mad(p, plane->offset - vec3_dot(plane->normal, p), plane->normal), .d = plane->normal};
    }
    if (s->type == &shape_cylinder)
        return place_on_cylinder(s, p, *toward);
    if (s->type == &shape_hull)
        return place_on_hull(s, p, *toward);
    return place_on_capsule(s, p);
}

/* Faces that lie on each other touch where their outlines cross: there the two edges are the feature, and follow when one slides.
 * Elsewhere a corner of the one lies in the face of the other. */
static FeatureKind kind_of(const Place *a, const Place *b)
{
    if (a->spot == SPOT_RIM)
        return b->spot == SPOT_FACE ? RIM_PLANE : RIM_POINT;
    if (b->spot == SPOT_RIM)
        return a->spot == SPOT_FACE ? PLANE_RIM : POINT_RIM;
    if (a->spot == SPOT_FACE && b->spot == SPOT_FACE)
        return a->rim > b->rim ? POINT_PLANE : PLANE_POINT;
    if (a->spot == SPOT_FACE)
        return PLANE_POINT;
    if (b->spot == SPOT_FACE)
        return POINT_PLANE;
    if (a->spot == SPOT_LINE && b->spot == SPOT_LINE)
        return LINE_LINE;
    return a->spot == SPOT_LINE ? LINE_POINT : b->spot == SPOT_LINE ? POINT_LINE : POINT_POINT;
}

static inline bool is_turned(quat q) { return q.x != 0 || q.y != 0 || q.z != 0; }
static inline vec3 turn_to_body(const pose *at, bool turned, vec3 d) { return turned ? quat_rotate(at->q, d) : d; }
static inline vec3 to_body(const pose *at, bool turned, vec3 local) { return vec3_add(at->p, turn_to_body(at, turned, local)); }

static const Pos *fixed_place(const Group *g, int body)
{
    const Member *m = &g->member[body];
    return m->moves || m->kinematic ? NULL : &g->pos[body];
}

void feature_sides(const Group *g, const GroupPair *q, vec3 normal, Sides *out)
{
    out->fixed_a = fixed_place(g, q->a);
    out->fixed_b = fixed_place(g, q->b);
    out->la = pair_local(q, false);
    out->lb = pair_local(q, true);
    out->turned_a = is_turned(out->la.q);
    out->turned_b = is_turned(out->lb.q);
    out->n = normal;
    if (q->on_a->shape.type != &shape_sphere)
        out->a = group_shape_pose(g, q->a, out->la);
    if (q->on_b->shape.type != &shape_sphere)
        out->b = group_shape_pose(g, q->b, out->lb);
    if (has_sides(&q->on_a->shape))
        out->out_a = quat_unrotate(out->a.q, normal);
    if (has_sides(&q->on_b->shape))
        out->out_b = quat_unrotate(out->b.q, vec3_neg(normal));
}

/* Few bodies that stand still are turned. */
static inline void to_world(const Pos *at, vec3 *point, vec3 *d)
{
    bool turned = is_turned(at->q);
    *point = vec3_add(at->x, turned ? quat_rotate(at->q, *point) : *point);
    *d = turned ? quat_rotate(at->q, *d) : *d;
}

/* Where a cylinder's side lies on an edge, its rim is the end of that side: of a distance from the circle, which is none there, nobody knows which
 * way it points; a cylinder that rolled over the edge of a table hung on it. toward: in the cylinder's frame. */
static void rim_is_side(Place *rim, const Place *other, vec3 toward)
{
    if (rim->spot == SPOT_RIM && other->spot != SPOT_FACE && other->spot != SPOT_RIM && fabs(toward.y) < ALIGNED * vec3_length(toward))
        rim->spot = SPOT_LINE;
}

void feature_find(const GroupPair *q, const Sides *s, const ManifoldPoint *p, Feature *out)
{
    vec3 core_a = vec3_mad(p->a, -q->on_a->shape.round, s->n), core_b = vec3_mad(p->b, q->on_b->shape.round, s->n);
    Place a = place_on(&q->on_a->shape, &s->a, core_a, &s->out_a), b = place_on(&q->on_b->shape, &s->b, core_b, &s->out_b);
    rim_is_side(&a, &b, s->out_a);
    rim_is_side(&b, &a, s->out_b);
    out->kind = kind_of(&a, &b);
    out->ra = q->on_a->shape.round + a.round;
    out->rb = q->on_b->shape.round + b.round;
    bool rims = a.spot == SPOT_FACE && b.spot == SPOT_FACE && a.rim == 1 && b.rim == 1;
    if (rims || out->kind == LINE_LINE) {
        vec3 da = rims ? a.edge : a.d, db = rims ? b.edge : b.d, m = vec3_cross(quat_rotate(s->a.q, da), quat_rotate(s->b.q, db));
        if (vec3_length(m) > CROSSING) {
            out->kind = LINE_LINE;
            a.d = vec3_dot(m, s->n) < 0 ? vec3_neg(da) : da;        /* so that da x db points from a to b */
            b.d = db;
        } else if (!rims) {
            out->kind = LINE_POINT;
        }
    }
    out->pa = to_body(&s->la, s->turned_a, a.p);
    out->pb = to_body(&s->lb, s->turned_b, b.p);
    out->da = turn_to_body(&s->la, s->turned_a, a.d);
    out->db = turn_to_body(&s->lb, s->turned_b, b.d);
    const Pos *plane = out->kind == PLANE_POINT ? s->fixed_a : out->kind == POINT_PLANE ? s->fixed_b : NULL;
    out->fixed = plane != NULL;
    if (plane)
        to_world(plane, out->kind == PLANE_POINT ? &out->pa : &out->pb, out->kind == PLANE_POINT ? &out->da : &out->db);
}

/* ---- moving ---- */

typedef struct Spin { const Pos *at; const Vel *go; } Spin;     /* one body */

static inline Spin spin_of(const Group *g, int i) { return (Spin){&g->pos[i], &g->vel[i]}; }
static inline vec3 material(const Spin *s, vec3 at) { return vec3_add(s->go->v, vec3_cross(s->go->w, vec3_sub(at, s->at->x))); }
/* A point fixed in the body: of balls, its centre. */
static inline vec3 place_of(const Pos *at, vec3 p) { return vec3_is_zero(p) ? at->x : vec3_add(at->x, quat_rotate(at->q, p)); }
static vec3 along_normal_removed(vec3 v, vec3 n) { return vec3_mad(v, -vec3_dot(v, n), n); }

typedef struct Turning { vec3 n, ndot, at, atdot; real gap; } Turning;

/* Plane of s through o, point p of the other body with its velocity: n fixed in s. */
static inline Turning on_plane(const Spin *s, vec3 o, vec3 normal, vec3 p, vec3 pdot, real round)
{
    vec3 ndot = vec3_cross(s->go->w, normal);
    return (Turning){normal, ndot, vec3_mad(p, -round, normal), vec3_mad(pdot, -round, ndot), vec3_dot(normal, vec3_sub(p, o)) - round};
}

/* f: nearest geometric point of a (itself for a point), p of b. */
static Turning between(vec3 f, vec3 fdot, vec3 p, vec3 pdot, real ra, real rb)
{
    vec3 d = vec3_sub(p, f);
    real length = vec3_length(d);
    vec3 n = vec3_unit_or(d, (vec3){0, 1, 0});
    vec3 ndot = length > 0 ? vec3_scale(1 / length, along_normal_removed(vec3_sub(pdot, fdot), n)) : vec3_zero();
    return (Turning){n, ndot, vec3_mad(p, -rb, n), vec3_mad(pdot, -rb, ndot), length - ra - rb};
}

/* Foot of p on the line of s through o along d: o + s d, s = (p - o) . d. */
static void foot_of(const Spin *s, vec3 o, vec3 d, vec3 p, vec3 pdot, vec3 *f, vec3 *fdot)
{
    vec3 odot = material(s, o), ddot = vec3_cross(s->go->w, d), r = vec3_sub(p, o);
    real at = vec3_dot(r, d), atdot = vec3_dot(vec3_sub(pdot, odot), d) + vec3_dot(r, ddot);
    *f = vec3_mad(o, at, d);
    *fdot = vec3_add(vec3_mad(odot, atdot, d), vec3_scale(at, ddot));
}

/* Where the circle of radius r about o, across d, goes farthest along q: f = o + r e, e the unit vector of q' = q - (q . d) d. */
static void rim_toward(const Spin *s, vec3 o, vec3 d, real r, vec3 q, vec3 qdot, vec3 *f, vec3 *fdot)
{
    vec3 ddot = vec3_cross(s->go->w, d), in = along_normal_removed(q, d);
    vec3 indot = vec3_mad(vec3_mad(qdot, -vec3_dot(qdot, d) - vec3_dot(q, ddot), d), -vec3_dot(q, d), ddot);
    real size = vec3_length(in);
    vec3 e = vec3_unit_or(in, vec3_zero());
    *f = vec3_mad(o, r, e);
    *fdot = size > 0 ? vec3_mad(material(s, o), r / size, along_normal_removed(indot, e)) : material(s, *f);
}

/* The rim of r, centre o and axis d, on the plane of s through p: its lowest point. */
static Turning rim_on_plane(const Spin *r, vec3 o, vec3 d, real radius, const Spin *s, vec3 p, vec3 normal)
{
    vec3 f, fdot;
    rim_toward(r, o, d, radius, vec3_neg(normal), vec3_neg(vec3_cross(s->go->w, normal)), &f, &fdot);
    return on_plane(s, p, normal, f, fdot, 0);
}

static Turning turned_round(Turning t)
{
    t.n = vec3_neg(t.n);
    t.ndot = vec3_neg(t.ndot);
    return t;
}

/* m = da x db points from a to b; the nearest point of line b lies at s = (ob - oa) . (da x m) / m^2 along it. */
static Turning crossing(const Spin *a, vec3 oa, vec3 da, const Spin *b, vec3 ob, vec3 db, const Feature *f)
{
    vec3 m = vec3_cross(da, db), dadot = vec3_cross(a->go->w, da), dbdot = vec3_cross(b->go->w, db);
    vec3 mdot = vec3_add(vec3_cross(dadot, db), vec3_cross(da, dbdot));
    real k = vec3_length2(m), size = sqrt(k);
    vec3 r = vec3_sub(ob, oa), rdot = vec3_sub(material(b, ob), material(a, oa));
    vec3 e = vec3_cross(da, m), edot = vec3_add(vec3_cross(dadot, m), vec3_cross(da, mdot));
    real s = vec3_dot(r, e) / k, sdot = (vec3_dot(rdot, e) + vec3_dot(r, edot) - 2 * s * vec3_dot(m, mdot)) / k;
    vec3 n = vec3_scale(1 / size, m), ndot = vec3_scale(1 / size, along_normal_removed(mdot, n));
    vec3 p = vec3_mad(ob, s, db), pdot = vec3_add(vec3_mad(material(b, ob), sdot, db), vec3_scale(s, dbdot));
    return (Turning){n, ndot, vec3_mad(p, -f->rb, n), vec3_mad(pdot, -f->rb, ndot), vec3_dot(n, r) - f->ra - f->rb};
}

static inline Turning turning_of(const Spin *a, const Spin *b, const Feature *f)
{
    vec3 pa = place_of(a->at, f->pa), pb = place_of(b->at, f->pb);
    vec3 foot, footdot;
    switch (f->kind) {
    case PLANE_POINT:
        return on_plane(a, pa, quat_rotate(a->at->q, f->da), pb, material(b, pb), f->rb);
    case POINT_PLANE:
        return turned_round(on_plane(b, pb, quat_rotate(b->at->q, f->db), pa, material(a, pa), f->ra));
    case PLANE_RIM:
        return rim_on_plane(b, pb, quat_rotate(b->at->q, f->db), f->rb, a, pa, quat_rotate(a->at->q, f->da));
    case RIM_PLANE:
        return turned_round(rim_on_plane(a, pa, quat_rotate(a->at->q, f->da), f->ra, b, pb, quat_rotate(b->at->q, f->db)));
    case RIM_POINT:
        rim_toward(a, pa, quat_rotate(a->at->q, f->da), f->ra, vec3_sub(pb, pa), vec3_sub(material(b, pb), material(a, pa)), &foot, &footdot);
        return between(foot, footdot, pb, material(b, pb), 0, f->rb);
    case POINT_RIM:
        rim_toward(b, pb, quat_rotate(b->at->q, f->db), f->rb, vec3_sub(pa, pb), vec3_sub(material(a, pa), material(b, pb)), &foot, &footdot);
        return between(pa, material(a, pa), foot, footdot, f->ra, 0);
    case LINE_POINT:
        foot_of(a, pa, quat_rotate(a->at->q, f->da), pb, material(b, pb), &foot, &footdot);
        return between(foot, footdot, pb, material(b, pb), f->ra, f->rb);
    case POINT_LINE:
        foot_of(b, pb, quat_rotate(b->at->q, f->db), pa, material(a, pa), &foot, &footdot);
        return between(pa, material(a, pa), foot, footdot, f->ra, f->rb);
    case LINE_LINE:
        return crossing(a, pa, quat_rotate(a->at->q, f->da), b, pb, quat_rotate(b->at->q, f->db), f);
    case POINT_POINT:
        break;
    }
    return between(pa, material(a, pa), pb, material(b, pb), f->ra, f->rb);
}

bool feature_turns(const Feature *f, bool b)
{
    bool point = b ? f->kind == POINT_POINT || f->kind == PLANE_POINT : f->kind == POINT_POINT || f->kind == POINT_PLANE;
    return !point || !vec3_is_zero(b ? f->pb : f->pa);
}

real feature_gap(const Feature *f, const Pos *a, const Pos *b)
{
    static const Vel still = {{0, 0, 0}, {0, 0, 0}};
    if (f->kind == PLANE_POINT || f->kind == POINT_PLANE) {
        bool on_a = f->kind == PLANE_POINT;
        vec3 o = on_a ? f->pa : f->pb, n = on_a ? f->da : f->db;
        if (!f->fixed)
            to_world(on_a ? a : b, &o, &n);
        return vec3_dot(n, vec3_sub(place_of(on_a ? b : a, on_a ? f->pb : f->pa), o)) - (on_a ? f->rb : f->ra);
    }
    if (f->kind == POINT_POINT)
        return vec3_length(vec3_sub(place_of(b, f->pb), place_of(a, f->pa))) - f->ra - f->rb;
    Spin sa = {a, &still}, sb = {b, &still};
    return turning_of(&sa, &sb, f).gap;
}

/* A point on a plane of what does not move, o on it: what most contacts are. The terms that are left, in the order of the general way. */
INLINE void move_on_still(vec3 o, vec3 n, const Pos *x, const Vel *v, const Feature *f, Kinematics *k)
{
    bool on_a = f->kind == PLANE_POINT;
    real side = on_a ? 1 : -1, round = on_a ? f->rb : f->ra;
    vec3 p = place_of(x, on_a ? f->pb : f->pa);
    vec3 u = v->v, drift = vec3_zero();
    k->gap = vec3_dot(n, vec3_sub(p, o)) - round;
    k->at = round != 0 ? vec3_mad(p, -round, n) : p;
    if (!vec3_is_zero(v->w)) {
        vec3 pdot = vec3_add(v->v, vec3_cross(v->w, vec3_sub(p, x->x)));
        u = round != 0 ? vec3_add(v->v, vec3_cross(v->w, vec3_sub(k->at, x->x))) : pdot;
        drift = vec3_cross(v->w, vec3_sub(pdot, v->v));
    }
    k->n = vec3_scale(side, n);
    k->u = vec3_scale(side, u);
    k->rate = vec3_dot(n, u);
    k->drift = vec3_scale(side, drift);
    k->drift_n = vec3_dot(n, drift);
}

static inline bool is_still(const Vel *v) { return vec3_is_zero(v->v) && vec3_is_zero(v->w); }

/* Two balls that do not turn. */
static void move_balls(const Spin *a, const Spin *b, real ra, real rb, Kinematics *k)
{
    Turning t = between(a->at->x, a->go->v, b->at->x, b->go->v, ra, rb);
    k->n = t.n;
    k->at = t.at;
    k->gap = t.gap;
    k->u = vec3_sub(b->go->v, a->go->v);
    k->rate = vec3_dot(t.n, k->u);
    k->drift = vec3_zero();
    k->drift_n = vec3_dot(t.ndot, k->u);
}

/* u = material velocity of b against a at the contact point c. Without accelerations c' - v stays of the body's own velocity at the
 * moving point:  du/dt = wb x (c' - vb) - wa x (c' - va),  d(n . u)/dt = n . du/dt + n' . u. */
void feature_move(const Group *g, const Feature *f, int a, int b, Kinematics *k)
{
    if (f->kind == PLANE_POINT || f->kind == POINT_PLANE) {
        bool on_a = f->kind == PLANE_POINT;     /* the plane */
        int plane = on_a ? a : b, point = on_a ? b : a;
        vec3 o = on_a ? f->pa : f->pb, n = on_a ? f->da : f->db;
        if (f->fixed || is_still(&g->vel[plane])) {
            if (!f->fixed)
                to_world(&g->pos[plane], &o, &n);
            move_on_still(o, n, &g->pos[point], &g->vel[point], f, k);
            return;
        }
    }
    Spin sa = spin_of(g, a), sb = spin_of(g, b);
    if (f->kind == POINT_POINT && vec3_is_zero(sa.go->w) && vec3_is_zero(sb.go->w) && vec3_is_zero(f->pa) && vec3_is_zero(f->pb)) {
        move_balls(&sa, &sb, f->ra, f->rb, k);
        return;
    }
    Turning t = turning_of(&sa, &sb, f);
    k->n = t.n;
    k->at = t.at;
    k->gap = t.gap;
    k->u = vec3_sub(material(&sb, t.at), material(&sa, t.at));
    k->rate = vec3_dot(t.n, k->u);
    k->drift = vec3_sub(vec3_cross(sb.go->w, vec3_sub(t.atdot, sb.go->v)), vec3_cross(sa.go->w, vec3_sub(t.atdot, sa.go->v)));
    k->drift_n = vec3_dot(t.n, k->drift) + vec3_dot(t.ndot, k->u);
}
