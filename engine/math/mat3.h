/* math/mat3.h - 3x3 matrices, by value, row by row.
 *
 * Floor: math.
 */
#ifndef DIG_MAT3_H
#define DIG_MAT3_H

#include "math/vec.h"

typedef struct mat3 { vec3 r0, r1, r2; } mat3;      /* rows */

static inline mat3 mat3_diagonal(vec3 d) { return (mat3){{d.x, 0, 0}, {0, d.y, 0}, {0, 0, d.z}}; }
static inline mat3 mat3_zero(void) { return mat3_diagonal((vec3){0, 0, 0}); }
static inline mat3 mat3_identity(void) { return mat3_diagonal((vec3){1, 1, 1}); }
static inline vec3 mat3_mul_vec(mat3 m, vec3 v) { return (vec3){vec3_dot(m.r0, v), vec3_dot(m.r1, v), vec3_dot(m.r2, v)}; }
static inline mat3 mat3_transpose(mat3 m)
{
    return (mat3){{m.r0.x, m.r1.x, m.r2.x}, {m.r0.y, m.r1.y, m.r2.y}, {m.r0.z, m.r1.z, m.r2.z}};
}
static inline mat3 mat3_add(mat3 a, mat3 b) { return (mat3){vec3_add(a.r0, b.r0), vec3_add(a.r1, b.r1), vec3_add(a.r2, b.r2)}; }
static inline mat3 mat3_sub(mat3 a, mat3 b) { return (mat3){vec3_sub(a.r0, b.r0), vec3_sub(a.r1, b.r1), vec3_sub(a.r2, b.r2)}; }
static inline mat3 mat3_scale(real s, mat3 a) { return (mat3){vec3_scale(s, a.r0), vec3_scale(s, a.r1), vec3_scale(s, a.r2)}; }
static inline mat3 mat3_mul(mat3 a, mat3 b)
{
    mat3 t = mat3_transpose(b);
    return (mat3){mat3_mul_vec(t, a.r0), mat3_mul_vec(t, a.r1), mat3_mul_vec(t, a.r2)};
}
static inline mat3 mat3_outer(vec3 a, vec3 b) { return (mat3){vec3_scale(a.x, b), vec3_scale(a.y, b), vec3_scale(a.z, b)}; }
/* [v]x: mat3_skew(a) b = a x b */
static inline mat3 mat3_skew(vec3 v) { return (mat3){{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}; }
static inline real mat3_det(mat3 m) { return vec3_dot(m.r0, vec3_cross(m.r1, m.r2)); }

/* Inverse by cofactors. The caller knows that m is regular. */
static inline mat3 mat3_inverse(mat3 m)
{
    vec3 c0 = vec3_cross(m.r1, m.r2), c1 = vec3_cross(m.r2, m.r0), c2 = vec3_cross(m.r0, m.r1);
    real d = 1 / vec3_dot(m.r0, c0);
    return (mat3){{d * c0.x, d * c1.x, d * c2.x}, {d * c0.y, d * c1.y, d * c2.y}, {d * c0.z, d * c1.z, d * c2.z}};
}

/* Principal moments (ascending is not promised) and axes (columns, right-handed) of
 * a symmetric matrix, by cyclic Jacobi rotations (Golub & Van Loan, ch. 8.5). */
void mat3_principal(mat3 m, vec3 *moments, mat3 *axes);

#endif
