/* geom/patch.c - the common case of contact, a face that something lies on: proved right instead of searched for.
 *
 * Where a face of one core looks at the other, the difference a - b has a flat patch across the face's normal n: the face less
 * all points of the other that lie farthest against n. No distance is below that of the patch's plane; when the foot of the
 * origin lies on the patch, it is the distance. From inside the same patch is where the polytope of epa_depth starts. */
#include "geom/gjk.h"

#define TILT    1e-7        /* rad  turns the supports to the corners of the patch; a round side falls off by TILT^2 / 2 only */
#define NEAR    0.05        /* sine: faces farther off the last normal are not tried ... */
#define NEAR_B  0.7         /* ... nor, when there is none, farther off the way to b */
#define ON_FACE 1e-13       /* of the size */
#define ON_EDGE 1e-14       /* of the size squared: flush faces have the foot on the very edge of the patch */

static vec3 face_normal(const Shape *s, vec3 toward)
{
    vec3 c[16], sum = vec3_zero();
    uint32_t feature;
    if (!s->type->face)
        return sum;
    int count = s->type->face(s, toward, c, &feature);
    for (int i = 1; i + 1 < count; i++)
        sum = vec3_add(sum, vec3_cross(vec3_sub(c[i], c[0]), vec3_sub(c[i + 1], c[0])));
    return vec3_unit_or(sum, sum);
}

/* Of the face of b that looks against `toward`: as a normal from a to b. */
static vec3 face_normal_of_b(const ConvexPair *p, vec3 toward)
{
    vec3 n = face_normal(p->b, mat3_mul_vec(p->back, vec3_neg(toward)));
    return vec3_neg(mat3_mul_vec(p->turn, n));
}

bool patch_find(const ConvexPair *p, vec3 n, Patch *out)
{
    static const real across[4] = {1, -1, -1, 1}, along[4] = {1, 1, -1, -1};
    vec3 s, r;
    vec3_basis(n, &s, &r);
    out->normal = n;
    out->count = 0;
    for (int k = 0; k < 4; k++) {
        vec3 d = vec3_mad(vec3_mad(n, across[k] * TILT, s), along[k] * TILT, r);
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
    for (int k = 0; k < out->count; k++)
        if (!(fabs(vec3_dot(n, out->w[k]) - out->offset) <= ON_FACE * p->size))
            return false;
    return vec3_length(vec3_cross(vec3_sub(out->w[1], out->w[0]), vec3_sub(out->w[2], out->w[0]))) > TILT * p->size * p->size;
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

bool patch_gap(const ConvexPair *p, vec3 guess, real enough, ConvexGap *out)
{
    bool guessed = vec3_length2(guess) > 0, point = p->a->outer == p->a->round || p->b->outer == p->b->round;
    vec3 toward = vec3_unit_or(guessed ? guess : convex_way(p), vec3_zero());
    real sine = guessed ? NEAR : NEAR_B;
    for (int k = 0; k < 2 && !point; k++) {            /* points need no patch: GJK is as quick */
        vec3 n = k == 0 ? face_normal(p->a, toward) : face_normal_of_b(p, toward);
        Patch patch;
        if (!(vec3_length2(n) > 0) || !(vec3_dot(n, toward) > 0) || !(vec3_length2(vec3_cross(n, toward)) < sine * sine))
            continue;
        if (!patch_find(p, n, &patch))
            continue;
        if (-patch.offset > enough) {
            *out = (ConvexGap){-patch.offset, n, patch.a[0], patch.b[0]};
            return true;
        }
        if (patch_foot(&patch, p->size, out) && (patch.offset <= 0 || epa_from_patch(p, &patch, out)))
            return true;
    }
    return false;
}
