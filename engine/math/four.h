/* math/four.h - four numbers, vectors, matrices and quaternions side by side, one a lane.
 *
 * The compiler splits them where registers are shorter. Every lane is computed by the rounded operations that vec.h, mat3.h and
 * quat.h take alone, in the same order and without fused multiply-adds: the bits are the same with all sets of instructions.
 *
 * Floor: math.
 */
#ifndef DIG_FOUR_H
#define DIG_FOUR_H

#include "math/pair.h"
#include "math/quat.h"

#define LANES 4
typedef real    four __attribute__((vector_size(LANES * sizeof(real))));
typedef real    four_any __attribute__((vector_size(LANES * sizeof(real)), aligned(8), may_alias));       /* wherever it lies */
typedef int64_t four_int __attribute__((vector_size(LANES * sizeof(int64_t))));

typedef struct four3 { four x, y, z; } four3;
typedef struct four33 { four3 r0, r1, r2; } four33;             /* rows */
typedef struct four_quat { four x, y, z, w; } four_quat;

INLINE four four_all(real x) { return (four){x, x, x, x}; }
INLINE four four_pick(four_int which, four yes, four no) { return (four)((which & (four_int)yes) | (~which & (four_int)no)); }
INLINE four four_where(four_int which, four x) { return (four)(which & (four_int)x); }       /* 0 elsewhere */
INLINE four four_most(four a, four b) { return four_pick(a > b, a, b); }
INLINE four four_abs(four a) { return four_most(a, -a); }

#define SHUFFLE __builtin_shufflevector

/* Four rows of four become four columns. */
INLINE void four_transpose(four r[4])
{
    four s0 = SHUFFLE(r[0], r[1], 0, 4, 2, 6), s1 = SHUFFLE(r[0], r[1], 1, 5, 3, 7);
    four s2 = SHUFFLE(r[2], r[3], 0, 4, 2, 6), s3 = SHUFFLE(r[2], r[3], 1, 5, 3, 7);
    r[0] = SHUFFLE(s0, s2, 0, 1, 4, 5);
    r[1] = SHUFFLE(s1, s3, 0, 1, 4, 5);
    r[2] = SHUFFLE(s0, s2, 2, 3, 6, 7);
    r[3] = SHUFFLE(s1, s3, 2, 3, 6, 7);
}

INLINE four four_root(four x)
{
    UNROLL
    for (int i = 0; i < LANES; i++)
        x[i] = sqrt(x[i]);
    return x;
}

INLINE four3 four3_zero(void) { return (four3){four_all(0), four_all(0), four_all(0)}; }
INLINE four3 four3_add(four3 a, four3 b) { return (four3){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE four3 four3_sub(four3 a, four3 b) { return (four3){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINE four3 four3_scale(four s, four3 a) { return (four3){s * a.x, s * a.y, s * a.z}; }
/* a + s b */
INLINE four3 four3_mad(four3 a, four s, four3 b) { return (four3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
INLINE four four3_dot(four3 a, four3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE four3 four3_cross(four3 a, four3 b)
{
    return (four3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
INLINE four3 four3_all(vec3 v) { return (four3){four_all(v.x), four_all(v.y), four_all(v.z)}; }
INLINE vec3 four3_get(const four3 *v, int lane) { return (vec3){v->x[lane], v->y[lane], v->z[lane]}; }
INLINE void four3_put(four3 *v, int lane, vec3 to)
{
    v->x[lane] = to.x;
    v->y[lane] = to.y;
    v->z[lane] = to.z;
}

/* Four vectors, each with a fourth number, from their components; and the other way. */
INLINE void four3_apart(four3 v, four fourth, four to[LANES])
{
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
    to[3] = fourth;
    four_transpose(to);
}
INLINE four3 four3_together(four from[LANES], four *fourth)
{
    four_transpose(from);
    *fourth = from[3];
    return (four3){from[0], from[1], from[2]};
}

INLINE four33 four33_scale(four s, four33 a) { return (four33){four3_scale(s, a.r0), four3_scale(s, a.r1), four3_scale(s, a.r2)}; }
INLINE four3 four33_mul3(const four33 *m, four3 v) { return (four3){four3_dot(m->r0, v), four3_dot(m->r1, v), four3_dot(m->r2, v)}; }
/* By the transpose. */
INLINE four3 four33_back3(const four33 *m, four3 v)
{
    return four3_mad(four3_mad(four3_scale(v.x, m->r0), v.y, m->r1), v.z, m->r2);
}
INLINE four33 four33_mul(const four33 *a, const four33 *b)
{
    return (four33){four33_back3(b, a->r0), four33_back3(b, a->r1), four33_back3(b, a->r2)};
}
INLINE four33 four33_all(const mat3 *m) { return (four33){four3_all(m->r0), four3_all(m->r1), four3_all(m->r2)}; }
INLINE void four33_put(four33 *m, int lane, const mat3 *to)
{
    four3_put(&m->r0, lane, to->r0);
    four3_put(&m->r1, lane, to->r1);
    four3_put(&m->r2, lane, to->r2);
}
/* By cofactors, as mat3_inverse. */
INLINE four33 four33_inverse(const four33 *m)
{
    four3 c0 = four3_cross(m->r1, m->r2), c1 = four3_cross(m->r2, m->r0), c2 = four3_cross(m->r0, m->r1);
    four d = 1.0 / four3_dot(m->r0, c0);
    return (four33){{d * c0.x, d * c1.x, d * c2.x}, {d * c0.y, d * c1.y, d * c2.y}, {d * c0.z, d * c1.z, d * c2.z}};
}

INLINE quat four_quat_get(const four_quat *q, int lane) { return (quat){q->x[lane], q->y[lane], q->z[lane], q->w[lane]}; }
INLINE void four_quat_put(four_quat *q, int lane, quat to)
{
    q->x[lane] = to.x;
    q->y[lane] = to.y;
    q->z[lane] = to.z;
    q->w[lane] = to.w;
}
INLINE four_quat four_quat_conjugate(four_quat q) { return (four_quat){-q.x, -q.y, -q.z, q.w}; }
INLINE four_quat four_quat_mul(four_quat a, four_quat b)
{
    return (four_quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                       a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
INLINE four3 four_quat_rotate(four_quat q, four3 v)
{
    four3 u = {q.x, q.y, q.z}, t = four3_scale(four_all(2), four3_cross(u, v));
    return four3_add(four3_mad(v, q.w, t), four3_cross(u, t));
}
INLINE four_quat four_quat_unit(four_quat q)
{
    four s = 1.0 / four_root(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return (four_quat){s * q.x, s * q.y, s * q.z, s * q.w};
}
INLINE four33 four_quat_matrix(four_quat q)
{
    four xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    four xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (four33){{1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy)},
                    {2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx)},
                    {2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)}};
}

#endif
