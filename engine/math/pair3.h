/* math/pair3.h - two vectors and two rotations side by side, one a lane.
 *
 * Every lane is computed by the operations of vec.h, mat3.h and quat.h, in their order: the bits are the same.
 *
 * Floor: math.
 */
#ifndef DIG_PAIR3_H
#define DIG_PAIR3_H

#include "math/pair.h"
#include "math/quat.h"

typedef struct pair3 { pair x, y, z; } pair3;
typedef struct pair_quat { pair x, y, z, w; } pair_quat;

INLINE pair3 pair3_of(vec3 a, vec3 b) { return (pair3){{a.x, b.x}, {a.y, b.y}, {a.z, b.z}}; }
INLINE pair_quat pair_quat_of(quat a, quat b) { return (pair_quat){{a.x, b.x}, {a.y, b.y}, {a.z, b.z}, {a.w, b.w}}; }
INLINE vec3 pair3_get(pair3 v, int lane) { return (vec3){v.x[lane], v.y[lane], v.z[lane]}; }
INLINE pair pair3_dot(pair3 a, pair3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE pair3 pair3_cross(pair3 a, pair3 b)
{
    return (pair3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
INLINE pair3 pair3_by(const mat3 *m, pair3 v)
{
    return (pair3){m->r0.x * v.x + m->r0.y * v.y + m->r0.z * v.z, m->r1.x * v.x + m->r1.y * v.y + m->r1.z * v.z,
                   m->r2.x * v.x + m->r2.y * v.y + m->r2.z * v.z};
}
INLINE pair3 pair3_add(pair3 a, pair3 b) { return (pair3){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE pair3 pair3_sub(pair3 a, pair3 b) { return (pair3){a.x - b.x, a.y - b.y, a.z - b.z}; }

INLINE pair_quat pair_quat_conjugate(pair_quat q) { return (pair_quat){-q.x, -q.y, -q.z, q.w}; }
INLINE pair3 pair_quat_rotate(pair_quat q, pair3 v)
{
    pair3 u = {q.x, q.y, q.z}, t = pair3_cross(u, v);
    t = (pair3){2 * t.x, 2 * t.y, 2 * t.z};
    pair3 c = pair3_cross(u, t);
    return (pair3){(v.x + q.w * t.x) + c.x, (v.y + q.w * t.y) + c.y, (v.z + q.w * t.z) + c.z};
}

#endif
