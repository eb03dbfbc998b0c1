/* math/quat.h - rotations as unit quaternions, and poses, by value.
 *
 * Floor: math.
 */
#ifndef DIG_QUAT_H
#define DIG_QUAT_H

#include "math/mat3.h"

static inline quat quat_identity(void) { return (quat){0, 0, 0, 1}; }
static inline quat quat_conjugate(quat q) { return (quat){-q.x, -q.y, -q.z, q.w}; }
static inline quat quat_mul(quat a, quat b)
{
    return (quat){a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                  a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
/* a (w, 0) */
static inline quat quat_mul_pure(quat a, vec3 w)
{
    return (quat){a.w * w.x + a.y * w.z - a.z * w.y, a.w * w.y + a.z * w.x - a.x * w.z, a.w * w.z + a.x * w.y - a.y * w.x,
                  -a.x * w.x - a.y * w.y - a.z * w.z};
}
static inline quat quat_add(quat a, quat b) { return (quat){a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
static inline real quat_norm2(quat q) { return q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w; }
static inline bool quat_finite(quat q) { return isfinite(q.x) && isfinite(q.y) && isfinite(q.z) && isfinite(q.w); }
static inline quat quat_unit(quat q)
{
    real n = quat_norm2(q);
    if (!(n > 0))
        return quat_identity();
    real s = 1 / sqrt(n);
    return (quat){s * q.x, s * q.y, s * q.z, s * q.w};
}
/* q v q* */
static inline vec3 quat_rotate(quat q, vec3 v)
{
    vec3 u = {q.x, q.y, q.z};
    vec3 t = vec3_scale(2, vec3_cross(u, v));
    return vec3_add(vec3_mad(v, q.w, t), vec3_cross(u, t));
}
static inline vec3 quat_unrotate(quat q, vec3 v) { return quat_rotate(quat_conjugate(q), v); }
/* Rotation by the vector r: |r| radians about r. Exact for any length. */
static inline quat quat_exp(vec3 r)
{
    real a2 = vec3_length2(r);
    real half = 0.5 * sqrt(a2);
    /* sin(h)/(2h) by its series where the quotient loses digits */
    real s = a2 < 1e-8 ? 0.5 - a2 / 48 : sin(half) / (2 * half);
    return (quat){s * r.x, s * r.y, s * r.z, cos(half)};
}
/* The rotation vector of q, length in [0, pi]. */
static inline vec3 quat_log(quat q)
{
    vec3 u = {q.x, q.y, q.z};
    real w = q.w;
    if (w < 0) {
        u = vec3_neg(u);
        w = -w;
    }
    real s = vec3_length(u);
    real k = s < 1e-9 ? 2 : 2 * atan2(s, w) / s;
    return vec3_scale(k, u);
}
static inline quat quat_axis_angle(vec3 unit_axis, real angle)
{
    real s = sin(0.5 * angle);
    return (quat){s * unit_axis.x, s * unit_axis.y, s * unit_axis.z, cos(0.5 * angle)};
}
/* The shortest rotation that takes unit vector a to unit vector b. */
static inline quat quat_between(vec3 a, vec3 b)
{
    real d = vec3_dot(a, b);
    if (d < -1 + 1e-12) {
        vec3 t, u;
        vec3_basis(a, &t, &u);
        return (quat){t.x, t.y, t.z, 0};
    }
    vec3 c = vec3_cross(a, b);
    return quat_unit((quat){c.x, c.y, c.z, 1 + d});
}
static inline mat3 quat_matrix(quat q)
{
    real xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    real xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (mat3){{1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)},
                  {2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)},
                  {2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)}};
}
/* From a rotation matrix (Shepperd's method). */
quat quat_from_matrix(mat3 m);

static inline pose pose_identity(void) { return (pose){{0, 0, 0}, {0, 0, 0, 1}}; }
static inline vec3 pose_point(pose p, vec3 v) { return vec3_add(p.p, quat_rotate(p.q, v)); }
static inline vec3 pose_unpoint(pose p, vec3 v) { return quat_unrotate(p.q, vec3_sub(v, p.p)); }
/* a then its child b: the pose of b in a's parent. */
static inline pose pose_mul(pose a, pose b) { return (pose){pose_point(a, b.p), quat_mul(a.q, b.q)}; }
static inline pose pose_inverse(pose a) { quat c = quat_conjugate(a.q); return (pose){quat_rotate(c, vec3_neg(a.p)), c}; }

#endif
