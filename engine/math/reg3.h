/* math/reg3.h - a vector in one register of four numbers, for loops over many.
 *
 * Every number is computed by the rounded operations of vec.h and mat3.h, in their order: the bits are the same with all sets of
 * instructions. The compiler splits a register where the machine has shorter ones.
 *
 * Floor: math.
 */
#ifndef DIG_REG3_H
#define DIG_REG3_H

#include "math/mat3.h"
#include "math/pair.h"

typedef real reg3 __attribute__((vector_size(32)));             /* x, y, z, and a number that nobody asks for */
typedef real reg3_near __attribute__((vector_size(32), aligned(8), may_alias));
typedef struct reg33 { reg3 c0, c1, c2; } reg33;                /* columns */

/* Reads what comes after the vector, too, and puts 0 in its place: integers there are subnormal numbers, and Intel's processors take some 150
 * cycles for each product with one of these. */
INLINE reg3 reg3_load(const vec3 *v)
{
    return __builtin_shufflevector(*(const reg3_near *)(const void *)v, (reg3){0}, 0, 1, 2, 7);
}
/* Writes it, too: what belongs there is written afterwards. */
INLINE void reg3_store(vec3 *to, reg3 v) { *(reg3_near *)(void *)to = v; }
INLINE reg3 reg3_of(vec3 v) { return (reg3){v.x, v.y, v.z, v.z}; }
INLINE reg3 reg3_all(real x) { return (reg3){x, x, x, x}; }
INLINE vec3 reg3_get(reg3 v) { return (vec3){v[0], v[1], v[2]}; }
INLINE real reg3_dot(reg3 a, reg3 b)
{
    reg3 p = a * b;
    return p[0] + p[1] + p[2];
}
INLINE real reg3_length2(reg3 a) { return reg3_dot(a, a); }
INLINE reg3 reg3_cross(reg3 a, reg3 b)
{
    reg3 yzx_a = __builtin_shufflevector(a, a, 1, 2, 0, 3), zxy_a = __builtin_shufflevector(a, a, 2, 0, 1, 3);
    reg3 yzx_b = __builtin_shufflevector(b, b, 1, 2, 0, 3), zxy_b = __builtin_shufflevector(b, b, 2, 0, 1, 3);
    return yzx_a * zxy_b - zxy_a * yzx_b;
}

INLINE reg33 reg33_of(const mat3 *m)
{
    return (reg33){{m->r0.x, m->r1.x, m->r2.x, m->r2.x}, {m->r0.y, m->r1.y, m->r2.y, m->r2.y}, {m->r0.z, m->r1.z, m->r2.z, m->r2.z}};
}
INLINE reg3 reg33_by(const reg33 *m, reg3 v)
{
    return m->c0 * reg3_all(v[0]) + m->c1 * reg3_all(v[1]) + m->c2 * reg3_all(v[2]);
}

#endif
