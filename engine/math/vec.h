/* math/vec.h - three-vectors, by value.
 *
 * Floor: math.
 */
#ifndef DIG_VEC_H
#define DIG_VEC_H

#include "base/base.h"

static inline vec3 vec3_of(real x, real y, real z) { return (vec3){x, y, z}; }
static inline vec3 vec3_zero(void) { return (vec3){0, 0, 0}; }
static inline vec3 vec3_add(vec3 a, vec3 b) { return (vec3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec3 vec3_sub(vec3 a, vec3 b) { return (vec3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec3 vec3_neg(vec3 a) { return (vec3){-a.x, -a.y, -a.z}; }
static inline vec3 vec3_scale(real s, vec3 a) { return (vec3){s * a.x, s * a.y, s * a.z}; }
static inline vec3 vec3_mul(vec3 a, vec3 b) { return (vec3){a.x * b.x, a.y * b.y, a.z * b.z}; }
/* a + s b */
static inline vec3 vec3_mad(vec3 a, real s, vec3 b) { return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
static inline real vec3_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec3 vec3_cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline real vec3_length2(vec3 a) { return vec3_dot(a, a); }
static inline real vec3_length(vec3 a) { return sqrt(vec3_dot(a, a)); }
static inline real vec3_distance(vec3 a, vec3 b) { return vec3_length(vec3_sub(a, b)); }
static inline vec3 vec3_min(vec3 a, vec3 b) { return (vec3){real_min(a.x, b.x), real_min(a.y, b.y), real_min(a.z, b.z)}; }
static inline vec3 vec3_max(vec3 a, vec3 b) { return (vec3){real_max(a.x, b.x), real_max(a.y, b.y), real_max(a.z, b.z)}; }
static inline vec3 vec3_abs(vec3 a) { return (vec3){fabs(a.x), fabs(a.y), fabs(a.z)}; }
static inline vec3 vec3_lerp(vec3 a, vec3 b, real t) { return vec3_mad(a, t, vec3_sub(b, a)); }
static inline bool vec3_finite(vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
static inline bool vec3_equal(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
static inline real vec3_at(vec3 a, int i) { return i == 0 ? a.x : i == 1 ? a.y : a.z; }
static inline real vec3_least(vec3 a) { return real_min(a.x, real_min(a.y, a.z)); }
static inline real vec3_largest(vec3 a) { return real_max(a.x, real_max(a.y, a.z)); }

/* Unit vector along a, or `otherwise` when a is zero or not finite. Scales first, so that any length will do. */
static inline vec3 vec3_unit_or(vec3 a, vec3 otherwise)
{
    real m = vec3_largest(vec3_abs(a));
    if (!(m > 0) || !isfinite(m))
        return otherwise;
    vec3 s = vec3_scale(1 / m, a);
    if (!vec3_finite(s))            /* m is subnormal: 1/m overflowed */
        s = (vec3){a.x / m, a.y / m, a.z / m};
    return vec3_scale(1 / vec3_length(s), s);
}

static inline vec3 vec3_unit(vec3 a) { return vec3_unit_or(a, (vec3){0, 1, 0}); }

/* By the bits of all three at once, but for their signs: 0 and -0, and nothing else, have none. */
static inline bool vec3_is_zero(vec3 v)
{
    uint64_t bits[3];
    _Static_assert(sizeof bits == sizeof v, "no more than its three numbers");
    memcpy(bits, &v, sizeof bits);
    return (bits[0] | bits[1] | bits[2]) << 1 == 0;
}

/* Two unit vectors that make a right-handed frame with the unit vector n: t x u = n. */
static inline void vec3_basis(vec3 n, vec3 *t, vec3 *u)
{
    vec3 other = fabs(n.x) < 0.57735026918962576 ? (vec3){1, 0, 0} : fabs(n.y) < 0.57735026918962576 ? (vec3){0, 1, 0} : (vec3){0, 0, 1};
    *t = vec3_unit(vec3_cross(other, n));
    *u = vec3_cross(n, *t);
}

typedef struct box3 { vec3 low, high; } box3;

static inline bool box3_overlap(box3 a, box3 b)
{
    return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
           a.low.z <= b.high.z && b.low.z <= a.high.z;
}
static inline bool box3_inside(box3 outer, box3 inner)
{
    return outer.low.x <= inner.low.x && outer.low.y <= inner.low.y && outer.low.z <= inner.low.z &&
           inner.high.x <= outer.high.x && inner.high.y <= outer.high.y && inner.high.z <= outer.high.z;
}
static inline box3 box3_union(box3 a, box3 b) { return (box3){vec3_min(a.low, b.low), vec3_max(a.high, b.high)}; }
static inline box3 box3_grow(box3 a, real by)
{
    return (box3){vec3_sub(a.low, (vec3){by, by, by}), vec3_add(a.high, (vec3){by, by, by})};
}
/* The box swept by a when it moves by d. */
static inline box3 box3_swept(box3 a, vec3 d)
{
    box3 b = {vec3_add(a.low, d), vec3_add(a.high, d)};
    return box3_union(a, b);
}

#endif
