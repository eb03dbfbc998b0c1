/* geom/patch.c - the common cases of contact, a face that something lies on and edges that cross: proved right instead of searched for.
 *
 * Where a face of one core looks at the other, the difference a - b has a flat patch across the face's normal n: the face less
 * all points of the other that lie farthest against n. No distance is below that of the patch's plane; when the foot of the
 * origin lies on the patch, it is the distance. From inside the same patch is where the polytope of epa_depth starts. Edges that cross
 * have such a patch, too: a parallelogram. They are the ones that the last normal sees. */
#include "geom/gjk.h"

#define TILT    1e-7        /* rad  turns the supports to the corners of the patch; a round side falls off by TILT^2 / 2 only */
#define NEAR    0.05        /* sine: faces farther off the last normal are not tried ... */
#define NEAR_B  0.7         /* ... nor, when there is none, farther off the way to b */
#define TURNED  {2e-2, 2e-3} /* rad  so far supports are turned to see an edge: the last normal may be off by as much; less beside a face */
#define SKEW    1e-3        /* sine: edges that run more nearly side by side cross nowhere */
#define ON_FACE 1e-13       /* of the size */
#define ON_EDGE 1e-14       /* of the size squared: flush faces have the foot on the very edge of the patch */

static const real across[4] = {1, -1, -1, 1}, along[4] = {1, 1, -1, -1};

/* The k-th of four directions about n, beside it by `turned`. */
static vec3 beside(vec3 n, vec3 s, vec3 r, real turned, int k)
{
    return vec3_mad(vec3_mad(n, across[k] * turned, s), along[k] * turned, r);
}

/* Of one of the two, what lies farthest along d, which runs from a to b, in the frame of a. */
static vec3 farthest(const ConvexPair *p, bool of_b, vec3 d)
{
    return of_b ? convex_support_b(p, vec3_neg(d)) : convex_support_a(p, d);
}

/* A face of a or b, in the axes of its own; normal from a to b, in the frame of a. */
typedef struct Face { bool of_b; int count; vec3 normal, corner[PATCH_CORNERS]; } Face;

/* The one that looks at the other along `toward`. */
static bool find_face(const ConvexPair *p, bool of_b, vec3 toward, Face *f)
{
    const Shape *s = of_b ? p->b : p->a;
    const vec3 *c = f->corner;
    vec3 sum = vec3_zero();
    uint32_t feature;
    if (!s->type->face)
        return false;
    f->of_b = of_b;
    f->count = s->type->face(s, of_b ? mat3_mul_vec(p->back, vec3_neg(toward)) : toward, f->corner, &feature);
    for (int i = 1; i + 1 < f->count; i++)
        sum = vec3_add(sum, vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
    f->normal = vec3_unit_or(sum, sum);
    if (of_b)
        f->normal = vec3_neg(mat3_mul_vec(p->turn, f->normal));
    return f->count >= 3 && vec3_length2(f->normal) > 0;
}

static bool lies_flat(const ConvexPair *p, const Patch *t)
{
    for (int k = 0; k < t->count; k++)
        if (!(fabs(vec3_dot(t->normal, t->w[k]) - t->offset) <= ON_FACE * p->size))
            return false;
    return vec3_length(vec3_cross(vec3_sub(t->w[1], t->w[0]), vec3_sub(t->w[2], t->w[0]))) > TILT * p->size * p->size;
}

/* All of the patch, up to four corners: what both of them have farthest along its normal. */
static bool patch_find(const ConvexPair *p, vec3 n, Patch *out)
{
    vec3 s, r;
    vec3_basis(n, &s, &r);
    out->normal = n;
    out->count = 0;
    for (int k = 0; k < 4; k++) {
        vec3 d = beside(n, s, r, TILT, k);
        vec3 a = convex_support_a(p, d), b = convex_support_b(p, vec3_neg(d)), w = vec3_sub(a, b);
        int last = out->count - 1;
        if (last >= 0 && (vec3_distance(out->w[last], w) < TILT * p->size || vec3_distance(out->w[0], w) < TILT * p->size))
            continue;
        out->a[out->count] = a;
        out->b[out->count] = b;
        out->w[out->count++] = w;
    }
    if (out->count < 3)
        return false;
    out->offset = vec3_dot(n, vec3_sub(convex_support_a(p, n), convex_support_b(p, vec3_neg(n))));
    return lies_flat(p, out);
}

/* Against the face, is only this corner of the other farthest? */
static bool is_alone(const ConvexPair *p, const Face *f, vec3 other)
{
    vec3 s, r;
    vec3_basis(f->normal, &s, &r);
    for (int k = 0; k < 4; k++)
        if (!vec3_equal(farthest(p, !f->of_b, beside(f->normal, s, r, TILT, k)), other))
            return false;
    return true;
}

/* The face less one point of the other. */
static bool patch_over(const ConvexPair *p, const Face *f, vec3 other, Patch *out)
{
    out->normal = f->normal;
    out->count = f->count;
    for (int k = 0; k < f->count; k++) {
        int i = f->of_b ? f->count - 1 - k : k;
        out->a[i] = f->of_b ? other : f->corner[k];
        out->b[i] = f->of_b ? convex_point_b(p, f->corner[k]) : other;
        out->w[i] = vec3_sub(out->a[i], out->b[i]);
    }
    return lies_flat(p, out);
}

/* The foot of the origin on the patch in barycentric weights of one of its triangles; false when it lies beside. */
static bool patch_foot(const Patch *t, real size, ConvexGap *out)
{
    real scale = size * size;
    for (int k = 1; k + 1 < t->count; k++) {
        const int c[3] = {0, k, k + 1};
        real weight[3], sum = 0;
        bool inside = true;
        for (int i = 0; i < 3; i++) {
            weight[i] = vec3_dot(t->normal, vec3_cross(t->w[c[(i + 1) % 3]], t->w[c[(i + 2) % 3]]));
            inside = inside && weight[i] >= -ON_EDGE * scale;
            weight[i] = real_max(weight[i], 0);
            sum += weight[i];
        }
        if (!inside || !(sum > 0))
            continue;
        *out = (ConvexGap){-t->offset, t->normal, vec3_zero(), vec3_zero()};
        for (int i = 0; i < 3; i++) {
            out->on_a = vec3_mad(out->on_a, weight[i] / sum, t->a[c[i]]);
            out->on_b = vec3_mad(out->on_b, weight[i] / sum, t->b[c[i]]);
        }
        return true;
    }
    return false;
}

/* The corners that are farthest in directions beside this one: two where an edge looks there. Three: more than that. */
static int ends_of(const ConvexPair *p, bool of_b, vec3 toward, real turned, vec3 end[2])
{
    vec3 s, r;
    int count = 0;
    vec3_basis(toward, &s, &r);
    for (int k = 0; k < 4; k++) {
        vec3 x = farthest(p, of_b, beside(toward, s, r, turned, k));
        bool known = (count > 0 && vec3_equal(x, end[0])) || (count > 1 && vec3_equal(x, end[1]));
        if (!known && count == 2)
            return 3;
        if (!known)
            end[count++] = x;
    }
    return count;
}

/* Where two edges cross, the difference has a parallelogram. */
static bool patch_of_edges(const ConvexPair *p, vec3 toward, const vec3 a[2], const vec3 b[2], Patch *out)
{
    vec3 u = vec3_sub(a[1], a[0]), v = vec3_sub(b[1], b[0]), n = vec3_cross(v, u);
    if (!(vec3_length2(n) > SKEW * SKEW * vec3_length2(u) * vec3_length2(v)))
        return false;
    const int second = vec3_dot(n, toward) > 0 ? 1 : 0, ia[4] = {0, 1, 1, 0}, ib[4] = {1 - second, 1 - second, second, second};
    n = vec3_unit(second ? n : vec3_neg(n));
    out->normal = n;
    out->count = 4;
    for (int k = 0; k < 4; k++) {
        out->a[k] = a[ia[k]];
        out->b[k] = b[ib[k]];
        out->w[k] = vec3_sub(out->a[k], out->b[k]);
    }
    out->offset = vec3_dot(n, vec3_sub(convex_support_a(p, n), convex_support_b(p, vec3_neg(n))));
    return lies_flat(p, out);
}

static bool patch_settles(const ConvexPair *p, const Patch *t, real enough, ConvexGap *out)
{
    if (-t->offset > enough) {
        *out = (ConvexGap){-t->offset, t->normal, t->a[0], t->b[0]};
        return true;
    }
    return patch_foot(t, p->size, out) && (t->offset <= 0 || epa_from_patch(p, t, out));
}

static bool face_settles(const ConvexPair *p, const Face *f, real enough, ConvexGap *out)
{
    Patch patch;
    vec3 n = f->normal, a = convex_support_a(p, n), b = convex_support_b(p, vec3_neg(n)), other = f->of_b ? a : b;
    patch.offset = vec3_dot(n, vec3_sub(a, b));
    if (-patch.offset > enough) {
        *out = (ConvexGap){-patch.offset, n, a, b};
        return true;
    }
    if (patch_over(p, f, other, &patch)) {
        if (patch_settles(p, &patch, enough, out))
            return true;
        if (f->count < PATCH_CORNERS && !convex_is_round(p) && is_alone(p, f, other))
            return false;
    }
    return patch_find(p, n, &patch) && patch_settles(p, &patch, enough, out);
}

static bool edges_settle(const ConvexPair *p, vec3 toward, real enough, ConvexGap *out)
{
    static const real turned[] = TURNED;
    for (int k = 0; k < 2; k++) {
        Patch patch;
        vec3 a[2], b[2];
        int count_a = ends_of(p, false, toward, turned[k], a);
        if (count_a < 2)
            return false;
        int count_b = ends_of(p, true, toward, turned[k], b);
        if (count_b < 2)
            return false;
        if (count_a == 2 && count_b == 2)
            return patch_of_edges(p, toward, a, b, &patch) && patch_settles(p, &patch, enough, out);
    }
    return false;
}

bool patch_gap(const ConvexPair *p, vec3 guess, real enough, ConvexGap *out)
{
    bool guessed = vec3_length2(guess) > 0, point = p->a->outer == p->a->round || p->b->outer == p->b->round;
    vec3 toward = vec3_unit_or(guessed ? guess : convex_way(p), vec3_zero());
    real sine = guessed ? NEAR : NEAR_B;
    if (point)                                         /* GJK is as quick */
        return false;
    for (int k = 0; k < 2; k++) {
        Face f;
        if (!find_face(p, k == 1, toward, &f))
            continue;
        bool near = vec3_dot(f.normal, toward) > 0 && vec3_length2(vec3_cross(f.normal, toward)) < sine * sine;
        if (near && face_settles(p, &f, enough, out))
            return true;
    }
    return guessed && edges_settle(p, toward, enough, out);
}
