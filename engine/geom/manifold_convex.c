/* geom/manifold_convex.c - manifold of two convex shapes from the normal between them: the face that lies most squarely across
 * the normal (reference) stays, the face of the other that looks at it (incident) is clipped by its sides, all along the normal. */
#include "geom/pair.h"

#define SQUARE       1e-6   /* rad  a normal this near to a face's is the face's */
#define SAME_TILT    1e-2   /* rad  faces this equally tilted: the reference is a's, so that it does not change while they rock */
#define FLAT_ENOUGH  0.966  /* 1    cosine: faces steeper than 15 degrees to the normal make no area */
#define PARALLEL     0.1    /* rad  edges that meet along a line rather than at a point */
#define ON_SIDE      1e-9   /* of the smaller shape: corners this near to a side are inside, so that flush faces keep their corners */
#define CORNERS      36     /* 16 of the incident face and one more for each side of the reference */

/* Features: what kind of meeting a point is, and the numbers of corner or edge and of the side. */
enum { MEET_CORNER = 1, MEET_CROSSING = 2, MEET_SIDES = 3, MEET_NEAREST = 4 };

static uint32_t feature_of(uint32_t kind, bool ref_is_a, int incident, int side, uint32_t faces)
{
    return kind << 29 | (ref_is_a ? 1u : 0u) << 28 | (uint32_t)(incident & 63) << 22 | (uint32_t)(side & 63) << 16 | (faces & 0xffff);
}

typedef struct Face {
    int      count;
    vec3     corner[16], normal;        /* in the frame of a */
    real     tilt;                      /* sine of the angle to the contact normal; 2: no face */
    uint32_t feature;
} Face;

static void measure(Face *f, vec3 toward)
{
    vec3 sum = vec3_zero();
    for (int i = 1; i + 1 < f->count; i++)
        sum = vec3_add(sum, vec3_cross(vec3_sub(f->corner[i], f->corner[0]), vec3_sub(f->corner[i + 1], f->corner[0])));
    f->normal = vec3_unit_or(sum, vec3_zero());
    bool flat = f->count >= 3 && vec3_dot(f->normal, toward) > FLAT_ENOUGH;
    f->tilt = flat ? vec3_length(vec3_cross(f->normal, toward)) : 2;
}

/* Capsules always give both ends: those out of reach drop out by themselves. */
static int face_towards(const Shape *s, ShapeKind kind, vec3 direction, vec3 corner[16], uint32_t *feature)
{
    if (kind != KIND_CAPSULE)
        return s->type->face(s, direction, corner, feature);
    corner[1] = (vec3){0, ((const CapsuleData *)s->data)->half, 0};
    corner[0] = vec3_neg(corner[1]);
    *feature = 0;
    return 2;
}

/* Not by value: what is not used of 16 corners need not be written. */
static void face_of_a(const Pair *p, vec3 n, Face *f)
{
    f->count = face_towards(p->a, p->kind_a, n, f->corner, &f->feature);
    measure(f, n);
}

static void face_of_b(const Pair *p, vec3 n, Face *f)
{
    vec3 toward = vec3_neg(n);
    f->count = face_towards(p->b, p->kind_b, mat3_mul_vec(p->c.back, toward), f->corner, &f->feature);
    for (int i = 0; i < f->count; i++)
        f->corner[i] = convex_point_b(&p->c, f->corner[i]);
    measure(f, toward);
}

/* A corner while clipping: which corner or edge of the incident face it came from, and which side cut it. */
typedef struct Corner { vec3 p; real outside; int edge, side; uint32_t kind; int number, by; } Corner;

/* edge: number of the incident edge that leaves this corner, -1 when the next stretch runs along side `side`. */
static Corner cut(const Corner *in, const Corner *out, const Corner *first, int side, bool leaving)
{
    real t = in->outside / (in->outside - out->outside);
    Corner c = {.p = vec3_lerp(in->p, out->p, t)};
    if (first->edge >= 0) {
        c.kind = MEET_CROSSING;
        c.number = first->edge;
        c.by = side;
    } else {                                    /* the stretch ran along another side: a corner of the reference */
        c.kind = MEET_SIDES;
        c.number = first->side;
        c.by = side;
    }
    c.edge = leaving ? -1 : first->edge;
    c.side = leaving ? side : first->side;
    return c;
}

/* Outward normal of the plane through side s of the reference along the contact normal n: points face each other along n. */
static vec3 side_normal(const Face *ref, int s, vec3 n)
{
    vec3 e = vec3_sub(ref->corner[(s + 1) % ref->count], ref->corner[s]);
    return vec3_unit_or(vec3_cross(e, vec3_dot(n, ref->normal) < 0 ? vec3_neg(n) : n), vec3_zero());
}

/* One side plane (Sutherland & Hodgman 1974). Corners on it within `same` count as inside and are not cut again. */
static int clip(const Corner *in, int count, Corner *to, int side, real same)
{
    int n = 0;
    for (int i = 0; i < count; i++) {
        const Corner *c = &in[i], *next = &in[(i + 1) % count];
        bool here = c->outside <= same, there = next->outside <= same;
        if (here) {
            to[n] = *c;
            if (!there && c->outside >= -same) {        /* leaves from the side itself */
                to[n].edge = -1;
                to[n].side = side;
            }
            n++;
        }
        if (here && !there && c->outside < -same && n < CORNERS)
            to[n++] = cut(c, next, c, side, true);
        else if (!here && there && next->outside < -same && n < CORNERS)
            to[n++] = cut(next, c, c, side, false);
    }
    return n;
}

typedef struct Clipped { int count; Corner at[CORNERS]; } Clipped;

static void clip_polygon(const Face *ref, const Face *incident, vec3 n, real same, Clipped *out)
{
    Corner other[CORNERS];
    out->count = incident->count;
    for (int i = 0; i < incident->count; i++)
        out->at[i] = (Corner){.p = incident->corner[i], .edge = i, .side = -1, .kind = MEET_CORNER, .number = i, .by = 63};

    for (int s = 0; s < ref->count && out->count > 0; s++) {
        vec3 outward = side_normal(ref, s, n);
        bool crosses = false;
        for (int i = 0; i < out->count; i++) {
            out->at[i].outside = vec3_dot(outward, vec3_sub(out->at[i].p, ref->corner[s]));
            crosses = crosses || out->at[i].outside > same;
        }
        if (!crosses)
            continue;
        out->count = clip(out->at, out->count, other, s, same);
        memcpy(out->at, other, (size_t)out->count * sizeof *other);
    }
}

/* A segment or a point against the sides. */
static void clip_segment(const Face *ref, const Face *incident, vec3 n, real same, Clipped *out)
{
    Corner end[2];
    for (int i = 0; i < 2; i++)
        end[i] = (Corner){.p = incident->corner[int_min(i, incident->count - 1)], .kind = MEET_CORNER, .number = i, .by = 63};
    out->count = 0;
    for (int s = 0; s < ref->count; s++) {
        vec3 outward = side_normal(ref, s, n);
        for (int i = 0; i < 2; i++)
            end[i].outside = vec3_dot(outward, vec3_sub(end[i].p, ref->corner[s]));
        if (end[0].outside > same && end[1].outside > same)
            return;
        for (int i = 0; i < 2; i++)
            if (end[i].outside > same) {
                real t = real_clamp(end[1 - i].outside / (end[1 - i].outside - end[i].outside), 0, 1);
                end[i] = (Corner){.p = vec3_lerp(end[1 - i].p, end[i].p, t), .kind = MEET_CROSSING, .number = i, .by = s};
            }
    }
    out->at[0] = end[0];
    out->at[1] = end[1];
    out->count = incident->count;
}

static void add_clipped(const Pair *p, const Face *ref, const Face *incident, bool ref_is_a, Contacts *c)
{
    Clipped clipped;
    if (incident->count >= 3)
        clip_polygon(ref, incident, c->normal, pair_same(p, ON_SIDE), &clipped);
    else
        clip_segment(ref, incident, c->normal, pair_same(p, ON_SIDE), &clipped);

    uint32_t faces = ref->feature * 31 + incident->feature;
    real upright = vec3_dot(ref->normal, c->normal);
    for (int i = 0; i < clipped.count; i++) {
        const Corner *k = &clipped.at[i];
        vec3 on_ref = vec3_mad(k->p, -vec3_dot(ref->normal, vec3_sub(k->p, ref->corner[0])) / upright, c->normal);
        vec3 on_a = vec3_mad(ref_is_a ? on_ref : k->p, p->a->round, c->normal);
        vec3 on_b = vec3_mad(ref_is_a ? k->p : on_ref, -p->b->round, c->normal);
        contacts_add(c, p->reach, on_a, on_b, feature_of(k->kind, ref_is_a, k->number, k->by, faces));
    }
}

/* The edge of a face that lies most squarely across the normal n on its outermost side. */
static void outermost_edge(Face *f, vec3 toward)
{
    int best = 0;
    real most = -INFINITY;
    if (f->count < 3)
        return;
    for (int i = 0; i < f->count; i++) {
        real height = vec3_dot(toward, vec3_add(f->corner[i], f->corner[(i + 1) % f->count]));
        if (height > most) {
            most = height;
            best = i;
        }
    }
    vec3 p = f->corner[best], q = f->corner[(best + 1) % f->count];
    f->corner[0] = p;
    f->corner[1] = q;
    f->count = 2;
    f->feature = f->feature * 16 + (uint32_t)best;
}

/* Two edges that run side by side: the ends of the stretch where they face each other. */
static void add_edges(const Pair *p, Face *fa, Face *fb, Contacts *c)
{
    outermost_edge(fa, c->normal);
    outermost_edge(fb, vec3_neg(c->normal));
    if (fa->count != 2 || fb->count != 2)
        return;
    vec3 u = vec3_sub(fa->corner[1], fa->corner[0]), v = vec3_sub(fb->corner[1], fb->corner[0]);
    real uu = vec3_length2(u), vv = vec3_length2(v), uv = vec3_dot(u, v);
    if (!(vec3_length2(vec3_cross(u, v)) < PARALLEL * PARALLEL * uu * vv))
        return;
    /* edges that leave the contact plane meet at one end only */
    real steep = real_max(fabs(vec3_dot(u, c->normal)) / sqrt(uu), fabs(vec3_dot(v, c->normal)) / sqrt(vv));
    if (steep > PARALLEL && p->kind_a != KIND_CAPSULE && p->kind_b != KIND_CAPSULE)
        return;

    real t0 = vec3_dot(vec3_sub(fb->corner[0], fa->corner[0]), u) / uu, t1 = vec3_dot(vec3_sub(fb->corner[1], fa->corner[0]), u) / uu;
    real lo = real_max(0, real_min(t0, t1)), hi = real_min(1, real_max(t0, t1));
    if (!(lo <= hi) || !(fabs(uv) > 0))
        return;
    for (int i = 0; i < 2; i++) {
        real s = i == 0 ? lo : hi;
        vec3 on_a = vec3_mad(fa->corner[0], s, u);
        vec3 on_b = vec3_mad(fb->corner[0], real_clamp(vec3_dot(vec3_sub(on_a, fb->corner[0]), v) / vv, 0, 1), v);
        contacts_add(c, p->reach, vec3_mad(on_a, p->a->round, c->normal), vec3_mad(on_b, -p->b->round, c->normal),
                     feature_of(MEET_CROSSING, true, i, 63, fa->feature * 31 + fb->feature));
    }
}

int collide_faces(const Pair *p, const ConvexGap *g, Manifold *out)
{
    Contacts c;
    c.normal = g->normal;
    c.count = 0;
    Face fa, fb;
    face_of_a(p, g->normal, &fa);
    face_of_b(p, g->normal, &fb);
    bool ref_is_a = fa.tilt <= fb.tilt + SAME_TILT;
    const Face *ref = ref_is_a ? &fa : &fb;

    if (fa.tilt < SQUARE)
        c.normal = fa.normal;
    else if (fb.tilt < SQUARE)
        c.normal = vec3_neg(fb.normal);
    if (ref->tilt < 2)
        add_clipped(p, ref, ref_is_a ? &fb : &fa, ref_is_a, &c);
    else
        add_edges(p, &fa, &fb, &c);

    real deepest = INFINITY;
    for (int i = 0; i < c.count; i++)
        deepest = real_min(deepest, c.at[i].gap);
    if (g->gap < deepest - pair_same(p, ON_SIDE))         /* rims and crossings that no corner shows */
        contacts_add(&c, p->reach, g->on_a, g->on_b, feature_of(MEET_NEAREST, true, 63, 63, 0));
    return contacts_finish(p, &c, out);
}

ManifoldCache manifold_hint(vec3 normal) { return (ManifoldCache){.kind = KIND_CONVEX, .axis = {normal.x, normal.y, normal.z}}; }

int collide_convex(const Pair *p, ManifoldCache *cache, Manifold *out)
{
    ConvexGap g;
    vec3 axis = vec3_zero();
    if (cache && cache->kind == KIND_CONVEX)
        axis = (vec3){cache->axis[0], cache->axis[1], cache->axis[2]};
    pair_gap(p, p->reach, &axis, &g);
    if (cache)
        *cache = manifold_hint(axis);
    if (g.gap > p->reach)
        return 0;
    if (p->kind_a == KIND_BALL || p->kind_b == KIND_BALL)
        return contacts_single(p, &g, out);
    return collide_faces(p, &g, out);
}
