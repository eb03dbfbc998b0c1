/* geom/mass.c - mass, centre of mass and inertia: turning, moving, adding, and of any closed surface. */
#include "geom/mass.h"

mat3 inertia_turn(mat3 inertia, quat q)
{
    mat3 R = quat_matrix(q);
    mat3 I = mat3_mul(mat3_mul(R, inertia), mat3_transpose(R));

    /* The product is symmetric only up to rounding; users factor it and expect both halves alike. */
    real xy = 0.5 * (I.r0.y + I.r1.x), xz = 0.5 * (I.r0.z + I.r2.x), yz = 0.5 * (I.r1.z + I.r2.y);
    return (mat3){{I.r0.x, xy, xz}, {xy, I.r1.y, yz}, {xz, yz, I.r2.z}};
}

mat3 inertia_offset(real mass, vec3 d)
{
    real d2 = vec3_length2(d);
    return mat3_scale(mass, mat3_sub(mat3_diagonal((vec3){d2, d2, d2}), mat3_outer(d, d)));
}

/* The common centre lies between the two, so both parallel-axis terms join to one with the reduced mass m1 m2 / (m1 + m2)
 * and the distance of the two centres: nothing is subtracted, however far from the origin they are. */
void mass_add(MassProps *sum_in_kg, const MassProps *unit, real density, pose at)
{
    real m1 = sum_in_kg->mass, m2 = density * unit->volume;
    vec3 c2 = pose_point(at, unit->centre);
    mat3 I2 = mat3_scale(density, inertia_turn(unit->inertia, at.q));
    real m  = m1 + m2;

    if (!(m > 0))
        return;
    vec3 d = vec3_sub(c2, sum_in_kg->centre);
    if (!(m1 > 0))
        *sum_in_kg = (MassProps){.mass = m2, .centre = c2, .inertia = I2};
    else
        *sum_in_kg = (MassProps){.mass = m, .centre = vec3_mad(sum_in_kg->centre, m2 / m, d),
                                 .inertia = mat3_add(mat3_add(sum_in_kg->inertia, I2), inertia_offset(m1 * m2 / m, d))};
}

void mass_scale(MassProps *sum_in_kg, real mass)
{
    if (!(sum_in_kg->mass > 0))
        return;
    sum_in_kg->inertia = mat3_scale(mass / sum_in_kg->mass, sum_in_kg->inertia);
    sum_in_kg->mass    = mass;
}

/* Middle of the bounds of the vertices in use: tetrahedra from here are small, so little cancels. */
static vec3 middle_of(const vec3 *vertices, const uint32_t *triangles, int triangle_count)
{
    if (triangle_count <= 0)
        return vec3_zero();
    vec3 low = vertices[triangles[0]], high = low;
    for (int i = 1; i < 3 * triangle_count; i++) {
        low  = vec3_min(low, vertices[triangles[i]]);
        high = vec3_max(high, vertices[triangles[i]]);
    }
    return vec3_lerp(low, high, 0.5);
}

/* The second moments of a tetrahedron with corners 0, a, b, c and D = a . (b x c) = 6 V are
 *
 *   integral x x' dV = D / 120 (a a' + b b' + c c' + s s'),   s = a + b + c
 *
 * and the inertia of the sum C of all of them is trace(C) 1 - C, moved from the reference point to the centre.
 *
 * Source: Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor, J. Math. Stat. 1(1), 2004; Eberly,
 * Polyhedral mass properties (revisited), 2002. Checked in tests/unit/test_mass.c. */
void mass_of_triangles(const vec3 *vertices, const uint32_t *triangles, int triangle_count, MassProps *out)
{
    vec3 middle = middle_of(vertices, triangles, triangle_count);
    real six_volumes = 0;
    vec3 first = {0, 0, 0};                     /* 24 * integral x dV   */
    mat3 second = mat3_zero();                  /* 120 * integral x x' dV */

    for (int i = 0; i < triangle_count; i++) {
        vec3 a = vec3_sub(vertices[triangles[3 * i]], middle);
        vec3 b = vec3_sub(vertices[triangles[3 * i + 1]], middle);
        vec3 c = vec3_sub(vertices[triangles[3 * i + 2]], middle);
        vec3 s = vec3_add(vec3_add(a, b), c);
        real D = vec3_dot(a, vec3_cross(b, c));

        six_volumes += D;
        first = vec3_mad(first, D, s);
        mat3 corners = mat3_add(mat3_add(mat3_outer(a, a), mat3_outer(b, b)), mat3_add(mat3_outer(c, c), mat3_outer(s, s)));
        second = mat3_add(second, mat3_scale(D, corners));
    }

    *out = (MassProps){.volume = six_volumes / 6, .centre = middle, .inertia = mat3_zero()};
    if (six_volumes == 0)
        return;
    vec3 d = vec3_scale(0.25 / six_volumes, first);
    mat3 C = mat3_scale(1.0 / 120, second);
    real t = C.r0.x + C.r1.y + C.r2.z;
    out->centre  = vec3_add(middle, d);
    out->inertia = mat3_sub(mat3_sub(mat3_diagonal((vec3){t, t, t}), C), inertia_offset(out->volume, d));
}
