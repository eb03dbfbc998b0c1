/* tests/unit/test_trace_feature.c - frozen contact features: their gap, rate and drift, and which one a manifold's point becomes.
 *
 * Reference for the motion: the same bodies moved by hand along x += v s, q = exp(w s) q with constant v and w, their nearest points
 * worked out again at each pose, and differences of fourth order.
 */
#include "trace_fixture.h"

enum { TRIES = 500, KINDS = POINT_RIM + 1 };

static const char *const kind_names[KINDS] = {"point-plane", "plane-point", "point-point", "point-line", "line-point", "line-line",
                                               "rim-plane", "plane-rim", "rim-point", "point-rim"};

/* ---- the plain computation ---- */

typedef struct Plain { real gap; vec3 n, at, u; } Plain;

static vec3 nearest_on_line(vec3 o, vec3 d, vec3 p) { return vec3_mad(o, vec3_dot(vec3_sub(p, o), d) / vec3_length2(d), d); }

/* Nearest points of two lines by the normal equations of |ob + s db - oa - r da|^2. */
static void nearest_of_lines(vec3 oa, vec3 da, vec3 ob, vec3 db, vec3 *on_a, vec3 *on_b)
{
    vec3 w = vec3_sub(ob, oa);
    real aa = vec3_dot(da, da), ab = vec3_dot(da, db), bb = vec3_dot(db, db), wa = vec3_dot(w, da), wb = vec3_dot(w, db);
    real det = aa * bb - ab * ab;
    *on_a = vec3_mad(oa, (wa * bb - wb * ab) / det, da);
    *on_b = vec3_mad(ob, (wa * ab - wb * aa) / det, db);
}

/* The point of a circle that is farthest along q, by its angle. */
static vec3 farthest_on_rim(vec3 o, vec3 d, real r, vec3 q)
{
    vec3 u, v;
    vec3_basis(vec3_unit(d), &u, &v);
    real angle = atan2(vec3_dot(q, v), vec3_dot(q, u));
    return vec3_mad(vec3_mad(o, r * cos(angle), u), r * sin(angle), v);
}

static vec3 velocity_at(const Pos *p, const Vel *v, vec3 at) { return vec3_add(v->v, vec3_cross(v->w, vec3_sub(at, p->x))); }

static Plain plain(const Pos p[2], const Vel v[2], const Feature *f)
{
    vec3 a = vec3_add(p[0].x, quat_rotate(p[0].q, f->pa)), b = vec3_add(p[1].x, quat_rotate(p[1].q, f->pb));
    vec3 da = quat_rotate(p[0].q, f->da), db = quat_rotate(p[1].q, f->db);
    Plain r;
    switch (f->kind) {
    case PLANE_POINT: r = (Plain){.gap = vec3_dot(da, vec3_sub(b, a)) - f->rb, .n = da, .at = vec3_mad(b, -f->rb, da)}; break;
    case PLANE_RIM:
        r.at = farthest_on_rim(b, db, f->rb, vec3_neg(da));
        r = (Plain){.gap = vec3_dot(da, vec3_sub(r.at, a)), .n = da, .at = r.at};
        break;
    case RIM_PLANE:
        r.at = farthest_on_rim(a, da, f->ra, vec3_neg(db));
        r = (Plain){.gap = vec3_dot(db, vec3_sub(r.at, b)), .n = vec3_neg(db), .at = r.at};
        break;
    case RIM_POINT:
        a = farthest_on_rim(a, da, f->ra, vec3_sub(b, a));
        r.n = vec3_unit(vec3_sub(b, a));
        r.gap = vec3_distance(a, b) - f->rb;
        r.at = vec3_mad(b, -f->rb, r.n);
        break;
    case POINT_RIM:
        b = farthest_on_rim(b, db, f->rb, vec3_sub(a, b));
        r.n = vec3_unit(vec3_sub(b, a));
        r.gap = vec3_distance(a, b) - f->ra;
        r.at = b;
        break;
    case POINT_PLANE: r = (Plain){.gap = vec3_dot(db, vec3_sub(a, b)) - f->ra, .n = vec3_neg(db), .at = vec3_mad(a, -f->ra, db)}; break;
    default:
        if (f->kind == POINT_LINE)
            b = nearest_on_line(b, db, a);
        else if (f->kind == LINE_POINT)
            a = nearest_on_line(a, da, b);
        else if (f->kind == LINE_LINE)
            nearest_of_lines(a, da, b, db, &a, &b);
        r.n = vec3_unit(vec3_sub(b, a));
        r.gap = vec3_distance(a, b) - f->ra - f->rb;
        r.at = vec3_mad(b, -f->rb, r.n);
    }
    r.u = vec3_sub(velocity_at(&p[1], &v[1], r.at), velocity_at(&p[0], &v[0], r.at));
    return r;
}

/* ---- features that move ---- */

static Feature random_feature(Dice *d, FeatureKind kind)
{
    Feature f = {.kind = kind, .pa = dice_vec(d), .pb = dice_vec(d), .da = dice_unit(d), .db = dice_unit(d),
                 .ra = dice_in(d, 0, 0.5), .rb = dice_in(d, 0, 0.5)};
    if (kind == PLANE_POINT)
        f.ra = 0;
    if (kind == POINT_PLANE)
        f.rb = 0;
    if (kind == RIM_PLANE || kind == RIM_POINT)
        f.ra += 0.1;
    if (kind == PLANE_RIM || kind == POINT_RIM)
        f.rb += 0.1;
    return f;
}

/* Two bodies and a feature whose normal has a direction: nothing it divides by is small, and da x db points from a to b. */
static Feature random_meeting(Hand *h, Dice *d, FeatureKind kind)
{
    for (;;) {
        Feature f = random_feature(d, kind);
        for (int i = 0; i < 2; i++) {
            h->pos[i] = (Pos){vec3_scale(2, dice_vec(d)), dice_quat(d)};
            h->vel[i] = (Vel){vec3_scale(2, dice_vec(d)), vec3_scale(2, dice_vec(d))};
        }
        vec3 m = vec3_cross(quat_rotate(h->pos[0].q, f.da), quat_rotate(h->pos[1].q, f.db));
        Plain p = plain(h->pos, h->vel, &f);
        if (kind >= RIM_PLANE) {        /* across the axis by a good part, and not near the nearest point */
            vec3 axis = kind == RIM_PLANE || kind == RIM_POINT ? quat_rotate(h->pos[0].q, f.da) : quat_rotate(h->pos[1].q, f.db);
            vec3 q = kind == PLANE_RIM ? quat_rotate(h->pos[0].q, f.da) : kind == RIM_PLANE ? quat_rotate(h->pos[1].q, f.db)
                : vec3_sub(vec3_add(h->pos[1].x, quat_rotate(h->pos[1].q, f.pb)), vec3_add(h->pos[0].x, quat_rotate(h->pos[0].q, f.pa)));
            if (vec3_length(vec3_cross(axis, q)) > 0.5 && (kind <= PLANE_RIM || p.gap + (kind == RIM_POINT ? f.rb : f.ra) > 0.5))
                return f;
            continue;
        }
        bool far = p.gap + f.ra + f.rb > 0.5 || kind == PLANE_POINT || kind == POINT_PLANE;
        if (kind == LINE_LINE && vec3_dot(m, p.n) < 0)
            f.da = vec3_neg(f.da);
        if (far && (kind != LINE_LINE || vec3_length(m) > 0.5))
            return f;
    }
}

static void check_close(const char *what, FeatureKind kind, real got, real want, real tolerance)
{
    if (!(fabs(got - want) <= tolerance * (1 + fabs(want))))
        fail_msg("%s: %s = %.17g, want %.17g (off by %g)", kind_names[kind], what, got, want, got - want);
}

static void check_close3(const char *what, FeatureKind kind, vec3 got, vec3 want, real tolerance)
{
    if (!(vec3_distance(got, want) <= tolerance * (1 + vec3_length(want))))
        fail_msg("%s: %s = (%.17g, %.17g, %.17g), want (%.17g, %.17g, %.17g)", kind_names[kind], what, got.x, got.y, got.z, want.x, want.y,
                 want.z);
}

/* In some of the tries one of the two does not move, as most grounds do not. */
static void stand_still(Hand *h, int i)
{
    if (i % 4 > 1)
        h->vel[i % 4 - 2] = (Vel){vec3_zero(), vec3_zero()};
}

TEST(gap_normal_point_and_velocity_of_a_feature_are_those_of_the_nearest_points)
{
    Dice d = {1};
    Hand h;
    hand_open(&h, 2, 2);
    for (int kind = 0; kind < KINDS; kind++)
        for (int i = 0; i < TRIES; i++) {
            Feature f = random_meeting(&h, &d, (FeatureKind)kind);
            stand_still(&h, i);
            Plain want = plain(h.pos, h.vel, &f);
            Kinematics k;
            feature_move(&h.g, &f, 0, 1, &k);
            check_close("gap", f.kind, k.gap, want.gap, 1e-14);
            CHECK(feature_gap(&f, &h.pos[0], &h.pos[1]) == k.gap);
            check_close3("normal", f.kind, k.n, want.n, 1e-14);
            check_close3("point", f.kind, k.at, want.at, 1e-13);
            check_close3("velocity", f.kind, k.u, want.u, 1e-13);
        }
}

/* Where the gap does not depend on how a body is turned, it is the same to the bit; where it is said to, it does. */
TEST(gaps_of_centres_do_not_depend_on_how_their_bodies_are_turned)
{
    Dice d = {2};
    Hand h;
    hand_open(&h, 2, 2);
    int centred = 0;
    for (int kind = 0; kind < KINDS; kind++)
        for (int i = 0; i < TRIES; i++) {
            Feature f = random_meeting(&h, &d, (FeatureKind)kind);
            f.pa = i % 2 ? vec3_zero() : f.pa;
            f.pb = i % 3 ? vec3_zero() : f.pb;
            for (int b = 0; b < 2; b++) {
                Pos turned[2] = {h.pos[0], h.pos[1]};
                turned[b].q = dice_quat(&d);
                bool same = feature_gap(&f, &turned[0], &turned[1]) == feature_gap(&f, &h.pos[0], &h.pos[1]);
                CHECK(feature_turns(&f, b == 1) || same);
                centred += !feature_turns(&f, b == 1);
            }
        }
    CHECK(centred > TRIES);
}

TEST(rate_and_drift_of_a_feature_are_derivatives_along_free_motion)
{
    Dice d = {2};
    Hand h;
    hand_open(&h, 2, 2);
    for (int kind = 0; kind < KINDS; kind++) {
        real largest = 0;
        for (int i = 0; i < TRIES; i++) {
            Feature f = random_meeting(&h, &d, (FeatureKind)kind);
            stand_still(&h, i);
            Kinematics k;
            feature_move(&h.g, &f, 0, 1, &k);
            real gap[4], rate[4], ux[4], uy[4], uz[4];
            for (int s = 0; s < 4; s++) {
                Pos then[2] = {pos_after(h.pos[0], h.vel[0], ticks[s]), pos_after(h.pos[1], h.vel[1], ticks[s])};
                Plain p = plain(then, h.vel, &f);
                gap[s] = p.gap;
                rate[s] = vec3_dot(p.n, p.u);
                ux[s] = p.u.x;
                uy[s] = p.u.y;
                uz[s] = p.u.z;
            }
            check_close("rate", f.kind, k.rate, difference(gap), 1e-8);
            check_close("drift along the normal", f.kind, k.drift_n, difference(rate), 1e-8);
            check_close3("drift", f.kind, k.drift, (vec3){difference(ux), difference(uy), difference(uz)}, 1e-8);
            largest = real_max(largest, fabs(k.drift_n));
        }
        CHECK(largest > 1);         /* the motions are such that a missing term would show */
    }
}

/* Known by hand: a ball that rolls round inside a larger circle of centres at speed v is drawn in by v^2 / distance. */
TEST(a_point_that_passes_another_at_a_distance_drifts_away_by_the_centrifugal_acceleration)
{
    Hand h;
    hand_open(&h, 2, 2);
    h.pos[1].x = (vec3){0, 0, 0.8};
    h.vel[1].v = (vec3){3, 0, 0};
    Feature f = {.kind = POINT_POINT, .ra = 0.3, .rb = 0.5};
    Kinematics k;
    feature_move(&h.g, &f, 0, 1, &k);
    CHECK_NEAR(k.gap, 0, 1e-15);
    CHECK_NEAR(k.rate, 0, 1e-15);
    CHECK_NEAR(k.drift_n, 9 / 0.8, 1e-13);
}

/* ---- features from manifolds ---- */

enum { SHAPES = 5 };
typedef enum Solidity { BALL, BRICK, PILL, GEM, FLOOR } Solidity;
static const char *const solid_names[SHAPES] = {"sphere", "box", "capsule", "hull", "plane"};

static Shape shape_of(Solidity s)
{
    static const vec3 corners[7] = {{-0.5, -0.4, -0.3}, {0.6, -0.4, -0.2}, {0.5, 0.5, -0.3}, {-0.4, 0.4, -0.4},
                                    {0.1, 0, 0.7}, {0.6, 0.3, 0.3}, {-0.5, 0.1, 0.4}};
    dig_sphere_def ball = {0.4};
    dig_box_def brick = {{1, 0.6, 0.4}};
    dig_capsule_def pill = {0.2, 0.7};
    dig_hull_def gem = {{corners, 7}};
    dig_plane_def floor = {{0, 1, 0}, 0.1};
    const void *defs[SHAPES] = {&ball, &brick, &pill, &gem, &floor};
    Shape shape;
    char why[160] = "";
    if (shape_make(solid_names[s], defs[s], &shape, why, sizeof why) != DIG_OK)
        fail_msg("%s: %s", solid_names[s], why);
    return shape;
}

typedef struct Meeting { Hand h; GroupPair pair; Form on[2]; Manifold m; int count; bool corners; } Meeting;

/* Its shapes in their bodies. */
static pose local(const Meeting *m, int side) { return (pose){m->on[side].arm, m->on[side].at.q}; }
static void set_local(Meeting *m, int side, pose at)
{
    m->on[side].arm = at.p;
    m->on[side].at.q = at.q;
}

static void meeting_open(Meeting *m, Solidity a, Solidity b)
{
    hand_open(&m->h, 2, 2);
    m->on[0] = (Form){.shape = shape_of(a), .at.q = quat_identity()};
    m->on[1] = (Form){.shape = shape_of(b), .at.q = quat_identity()};
    m->pair = (GroupPair){.a = 0, .b = 1, .on_a = &m->on[0], .on_b = &m->on[1], .size = 1};
}

static void meeting_close(Meeting *m)
{
    shape_free(&m->on[0].shape);
    shape_free(&m->on[1].shape);
}

static void collide(Meeting *m)
{
    pose pa = group_shape_pose(&m->h.g, 0, local(m, 0)), pb = group_shape_pose(&m->h.g, 1, local(m, 1));
    m->count = manifold_collide(&m->on[0].shape, pa, &m->on[1].shape, pb, 1e-2, NULL, &m->m, NULL, 1) == 1 ? m->m.count : 0;
}

static int sides_of(const Shape *s, vec3 local)
{
    if (s->type != &shape_box)
        return 0;
    vec3 h = ((const BoxData *)s->data)->half;
    return (fabs(local.x) > h.x - 1e-6) + (fabs(local.y) > h.y - 1e-6) + (fabs(local.z) > h.z - 1e-6);
}

/* Both somewhere, b moved towards a until it is near, then along the normal until it is `gap` away: for convex shapes that is exact in
 * one move.
 * corners: boxes meet corner to corner, or corner to edge. Nothing can rest like that, and the manifold's normal there is that of a
 * face or of two edges, not that of the nearest points. */
static void approach(Meeting *m, Dice *d, real gap)
{
    for (int i = 0; i < 2; i++)
        m->h.pos[i] = (Pos){vec3_scale(i ? 6 : 0.2, dice_unit(d)), dice_quat(d)};
    set_local(m, 0, (pose){vec3_scale(0.3, dice_vec(d)), dice_quat(d)});
    set_local(m, 1, (pose){vec3_scale(0.3, dice_vec(d)), dice_quat(d)});
    vec3 up = quat_rotate(quat_mul(m->h.pos[0].q, local(m, 0).q), (vec3){0, 1, 0});
    if (m->on[0].shape.type == &shape_plane)
        m->h.pos[1].x = vec3_scale(6, up);
    if (m->on[1].shape.type == &shape_plane)
        m->h.pos[1].x = vec3_scale(-6, quat_rotate(quat_mul(m->h.pos[1].q, local(m, 1).q), (vec3){0, 1, 0}));
    vec3 way = vec3_unit(vec3_sub(m->h.pos[1].x, m->h.pos[0].x));
    for (int pass = 0; pass < 40; pass++) {
        pose pa = group_shape_pose(&m->h.g, 0, local(m, 0)), pb = group_shape_pose(&m->h.g, 1, local(m, 1));
        vec3 n, on_a, on_b;
        real apart = shape_distance(&m->on[0].shape, pa, &m->on[1].shape, pb, INFINITY, &n, &on_a, &on_b);
        if (apart > 0.02) {
            m->h.pos[1].x = vec3_mad(m->h.pos[1].x, 0.01 - apart, way);
            continue;
        }
        m->corners = sides_of(&m->on[0].shape, pose_unpoint(pa, on_a)) + sides_of(&m->on[1].shape, pose_unpoint(pb, on_b)) >= 5;
        m->h.pos[1].x = vec3_mad(m->h.pos[1].x, gap - apart, n);
        break;
    }
}

static void find(const Meeting *m, const ManifoldPoint *p, Feature *f)
{
    Sides sides;
    feature_sides(&m->h.g, &m->pair, m->m.normal, &sides);
    feature_find(&m->pair, &sides, p, f);
}

/* The frozen feature of every point that touches has the gap of the manifold. A point higher than the deepest one may lie over a face
 * that is not square to the manifold's normal, or beyond where two lines are nearest: its gap is another then, except on what is flat
 * everywhere or round. */
static void check_features(const Meeting *m, real tolerance)
{
    real deepest = INFINITY;
    const Shape *a = &m->on[0].shape, *b = &m->on[1].shape;
    bool simple = a->type == &shape_plane || b->type == &shape_plane || a->type == &shape_sphere || b->type == &shape_sphere;
    for (int i = 0; i < m->count; i++)
        deepest = real_min(deepest, m->m.points[i].gap);
    for (int i = 0; i < m->count; i++) {
        const ManifoldPoint *p = &m->m.points[i];
        Feature f;
        Kinematics k;
        find(m, p, &f);
        feature_move(&m->h.g, &f, 0, 1, &k);
        bool pointed = f.kind != PLANE_POINT && f.kind != POINT_PLANE && f.kind != LINE_LINE && f.ra + f.rb == 0;
        if ((!simple && p->gap > deepest + 1e-9) || (pointed && fabs(p->gap) < 1e-6))
            continue;                   /* a corner that meets a corner or an edge: no normal, and nothing rests on it */
        if (!(fabs(k.gap - p->gap) <= tolerance))
            fail_msg("%s on %s, point %d of %d, %s: gap %.12g, want %.12g (off by %g)", m->on[0].shape.type->name, m->on[1].shape.type->name, i, m->count,
                     kind_names[f.kind], k.gap, p->gap, k.gap - p->gap);
        CHECK_NEAR(vec3_dot(k.n, m->m.normal), 1, 1e-6);
    }
}

/* A single point apart from the other body: the contact point is the nearest one. */
static void check_place(const Meeting *m)
{
    pose pa = group_shape_pose(&m->h.g, 0, local(m, 0)), pb = group_shape_pose(&m->h.g, 1, local(m, 1));
    vec3 n, on_a, on_b;
    Feature f;
    Kinematics k;
    if (m->count != 1 || m->m.points[0].gap < 1e-3)
        return;
    find(m, &m->m.points[0], &f);
    shape_distance(&m->on[0].shape, pa, &m->on[1].shape, pb, INFINITY, &n, &on_a, &on_b);
    feature_move(&m->h.g, &f, 0, 1, &k);
    vec3 want = f.kind == POINT_PLANE ? on_a : on_b;
    if (!(vec3_distance(k.at, want) < 1e-9))
        fail_msg("%s on %s, %s: contact point %g m from the nearest", m->on[0].shape.type->name, m->on[1].shape.type->name, kind_names[f.kind],
                 vec3_distance(k.at, want));
}

TEST(features_of_shapes_that_meet_anyhow_have_the_gap_of_the_manifold)
{
    static const real gaps[] = {5e-3, 1e-5, 1e-9, 0, -1e-9};
    Dice d = {3};
    for (int a = 0; a < SHAPES; a++)
        for (int b = 0; b < SHAPES; b++) {
            if (a == FLOOR && b == FLOOR)
                continue;
            Meeting m;
            meeting_open(&m, (Solidity)a, (Solidity)b);
            int met = 0, corners = 0;
            for (int i = 0; i < TRIES; i++) {
                approach(&m, &d, gaps[i % 5]);
                collide(&m);
                met += m.count > 0;
                corners += m.corners;
                if (m.corners)
                    continue;
                check_features(&m, 1e-9);
                check_place(&m);
            }
            CHECK(corners < TRIES / 2);
            if (met < TRIES * 9 / 10)
                fail_msg("%s on %s: met in %d of %d tries", solid_names[a], solid_names[b], met, TRIES);
            meeting_close(&m);
        }
}

static Feature feature_at(const Meeting *m, int point)
{
    Feature f;
    find(m, &m->m.points[point], &f);
    return f;
}

TEST(a_box_flat_on_a_plane_touches_with_its_four_corners)
{
    Dice d = {4};
    for (int i = 0; i < TRIES; i++) {
        Meeting m;
        meeting_open(&m, FLOOR, BRICK);
        quat turn = dice_quat(&d), yaw = quat_exp((vec3){0, dice(&d), 0});
        m.h.pos[0] = (Pos){dice_vec(&d), turn};
        m.h.pos[1] = (Pos){vec3_add(m.h.pos[0].x, quat_rotate(turn, (vec3){dice(&d), 0.1 + 0.3, dice(&d)})), quat_mul(turn, yaw)};
        collide(&m);
        CHECK_INT(m.count, 4);
        check_features(&m, 1e-9);
        int seen = 0;
        for (int k = 0; k < 4; k++) {
            Feature f = feature_at(&m, k);
            CHECK_INT(f.kind, PLANE_POINT);
            CHECK_NEAR(fabs(f.pb.x), 0.5, 0);           /* the corner itself, to the last digit */
            CHECK_NEAR(f.pb.y, -0.3, 0);
            CHECK_NEAR(fabs(f.pb.z), 0.2, 0);
            CHECK_NEAR(vec3_distance(f.da, (vec3){0, 1, 0}), 0, 0);
            seen |= 1 << ((f.pb.x > 0) + 2 * (f.pb.z > 0));
        }
        CHECK_INT(seen, 15);
        meeting_close(&m);
    }
}

TEST(a_box_on_one_corner_or_one_edge_keeps_corners_on_the_plane)
{
    for (int corners = 1; corners <= 2; corners++) {
        Meeting m;
        meeting_open(&m, FLOOR, BRICK);
        quat lean = quat_exp((vec3){0, 0, 0.4});
        if (corners == 1)
            lean = quat_mul(quat_exp((vec3){0.3, 0, 0}), lean);
        vec3 low = {-0.5, -0.3, corners == 1 ? 0.2 : 0};
        if (quat_rotate(lean, low).y > quat_rotate(lean, (vec3){-0.5, -0.3, -0.2}).y + 1e-9)
            low.z = -0.2;
        m.h.pos[1] = (Pos){{0, 0.1 - quat_rotate(lean, low).y, 0}, lean};
        collide(&m);
        CHECK(m.count >= corners);
        check_features(&m, 1e-9);
        int touching = 0;
        for (int k = 0; k < m.count; k++) {
            if (m.m.points[k].gap > 1e-6)
                continue;
            Feature f = feature_at(&m, k);
            CHECK_INT(f.kind, PLANE_POINT);
            CHECK_NEAR(f.pb.x, -0.5, 0);
            CHECK_NEAR(f.pb.y, -0.3, 0);
            CHECK_NEAR(fabs(f.pb.z), 0.2, 0);
            touching++;
        }
        CHECK_INT(touching, corners);
        meeting_close(&m);
    }
}

/* One brick across another: the four points are where the rims cross, and stay there when one slides along. */
TEST(crossing_rims_of_two_boxes_follow_the_crossing)
{
    Meeting m;
    meeting_open(&m, BRICK, BRICK);
    m.h.pos[1] = (Pos){{0.03, 0.6, 0.02}, quat_exp((vec3){0, 1.1, 0})};
    m.h.vel[1] = (Vel){{0.7, 0, -0.4}, {0, 2, 0}};
    collide(&m);
    CHECK_INT(m.count, 4);
    check_features(&m, 1e-9);
    int crossings = 0;
    for (int i = 0; i < m.count; i++) {
        Feature f = feature_at(&m, i);
        crossings += f.kind == LINE_LINE;
        CHECK_INT(f.kind, LINE_LINE);
        CHECK_NEAR(f.da.y, 0, 1e-15);
        CHECK_NEAR(f.db.y, 0, 1e-15);
        real tick = 1e-5;
        Kinematics now, then;
        Hand moved = m.h;
        moved.g.pos = moved.pos;
        moved.g.vel = moved.vel;
        moved.pos[1] = pos_after(m.h.pos[1], m.h.vel[1], tick);
        feature_move(&m.h.g, &f, 0, 1, &now);
        feature_move(&moved.g, &f, 0, 1, &then);
        CHECK_NEAR(then.gap, 0, 1e-15);
        Meeting later = m;
        later.h.g.pos = later.h.pos;
        later.h.pos[1] = moved.pos[1];
        later.pair.on_a = &later.on[0];
        later.pair.on_b = &later.on[1];
        collide(&later);
        real nearest = INFINITY;
        for (int k = 0; k < later.count; k++)
            nearest = real_min(nearest, vec3_distance(later.m.points[k].b, then.at));
        CHECK_NEAR(nearest, 0, 1e-12);
    }
    CHECK_INT(crossings, 4);
    meeting_close(&m);
}

TEST(edges_that_cross_in_the_air_are_lines)
{
    Meeting m;
    meeting_open(&m, BRICK, BRICK);
    m.on[0].at.q = quat_exp((vec3){0.7853981633974483, 0, 0});               /* edge along x up */
    m.on[1].at.q = quat_mul(quat_exp((vec3){0, 1.3, 0}), m.on[0].at.q);
    real high = 0.5 * sqrt(2) * (0.3 + 0.2);                                /* of the raised edge: a diagonal of the cross-section */
    real apart = 2 * high + 1e-4;
    m.h.pos[1].x = (vec3){0.01, apart, 0.02};
    collide(&m);
    CHECK_INT(m.count, 1);
    check_features(&m, 1e-9);
    CHECK_INT(feature_at(&m, 0).kind, LINE_LINE);
    CHECK_NEAR(m.m.points[0].gap, 1e-4, 1e-12);
    meeting_close(&m);
}

TEST(a_capsule_touches_with_its_end_points_or_its_line)
{
    Meeting m;
    meeting_open(&m, FLOOR, PILL);
    m.h.pos[1] = (Pos){{0, 0.3, 0}, quat_exp((vec3){0, 0, 1.5707963267948966})};      /* lying */
    collide(&m);
    CHECK_INT(m.count, 2);
    for (int i = 0; i < 2; i++) {
        Feature f = feature_at(&m, i);
        CHECK_INT(f.kind, PLANE_POINT);
        CHECK_NEAR(fabs(f.pb.y), 0.35, 1e-15);
        CHECK_NEAR(f.rb, 0.2, 0);
    }
    check_features(&m, 1e-9);
    meeting_close(&m);
    meeting_open(&m, BALL, PILL);
    m.h.pos[1] = (Pos){{0.1, 0.6, 0}, quat_exp((vec3){0, 0, 1.5707963267948966})};
    collide(&m);
    CHECK_INT(m.count, 1);
    CHECK_INT(feature_at(&m, 0).kind, POINT_LINE);
    CHECK_NEAR(m.m.points[0].gap, 0, 1e-12);
    meeting_close(&m);
    meeting_open(&m, PILL, PILL);
    m.h.pos[1] = (Pos){{0.1, 0, 0.4}, quat_exp((vec3){0, 0, 1.2})};
    collide(&m);
    CHECK_INT(feature_at(&m, 0).kind, LINE_LINE);
    check_features(&m, 1e-9);
    meeting_close(&m);
}

TEST(only_the_shapes_with_a_frozen_feature_are_known)
{
    for (int i = 0; shape_types[i]; i++) {
        Shape s = {.type = shape_types[i]};
        bool want = strcmp(shape_types[i]->name, "cylinder") == 0;
        for (int k = 0; k < SHAPES; k++)
            want = want || strcmp(shape_types[i]->name, solid_names[k]) == 0;
        CHECK_INT(feature_kind_known(&s), want);
    }
}

int main(void)
{
    RUN_TESTS(unit_test(gap_normal_point_and_velocity_of_a_feature_are_those_of_the_nearest_points),
              unit_test(gaps_of_centres_do_not_depend_on_how_their_bodies_are_turned),
              unit_test(rate_and_drift_of_a_feature_are_derivatives_along_free_motion),
              unit_test(a_point_that_passes_another_at_a_distance_drifts_away_by_the_centrifugal_acceleration),
              unit_test(features_of_shapes_that_meet_anyhow_have_the_gap_of_the_manifold),
              unit_test(a_box_flat_on_a_plane_touches_with_its_four_corners),
              unit_test(a_box_on_one_corner_or_one_edge_keeps_corners_on_the_plane),
              unit_test(crossing_rims_of_two_boxes_follow_the_crossing),
              unit_test(edges_that_cross_in_the_air_are_lines),
              unit_test(a_capsule_touches_with_its_end_points_or_its_line),
              unit_test(only_the_shapes_with_a_frozen_feature_are_known));
}
