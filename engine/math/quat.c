/* math/quat.c - the parts of mat3.h and quat.h too long to inline. */
#include "math/quat.h"

quat quat_from_matrix(mat3 m)
{
    real t = m.r0.x + m.r1.y + m.r2.z;
    quat q;
    if (t > 0) {
        real s = 2 * sqrt(t + 1);
        q = (quat){(m.r2.y - m.r1.z) / s, (m.r0.z - m.r2.x) / s, (m.r1.x - m.r0.y) / s, s / 4};
    } else if (m.r0.x > m.r1.y && m.r0.x > m.r2.z) {
        real s = 2 * sqrt(1 + m.r0.x - m.r1.y - m.r2.z);
        q = (quat){s / 4, (m.r0.y + m.r1.x) / s, (m.r0.z + m.r2.x) / s, (m.r2.y - m.r1.z) / s};
    } else if (m.r1.y > m.r2.z) {
        real s = 2 * sqrt(1 + m.r1.y - m.r0.x - m.r2.z);
        q = (quat){(m.r0.y + m.r1.x) / s, s / 4, (m.r1.z + m.r2.y) / s, (m.r0.z - m.r2.x) / s};
    } else {
        real s = 2 * sqrt(1 + m.r2.z - m.r0.x - m.r1.y);
        q = (quat){(m.r0.z + m.r2.x) / s, (m.r1.z + m.r2.y) / s, s / 4, (m.r1.x - m.r0.y) / s};
    }
    return quat_unit(q);
}

void mat3_principal(mat3 m, vec3 *moments, mat3 *axes)
{
    real a[3][3] = {{m.r0.x, m.r0.y, m.r0.z}, {m.r1.x, m.r1.y, m.r1.z}, {m.r2.x, m.r2.y, m.r2.z}};
    real v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};

    for (int sweep = 0; sweep < 32; sweep++) {
        real off = fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]);
        if (!(off > 1e-17 * (fabs(a[0][0]) + fabs(a[1][1]) + fabs(a[2][2]))))
            break;
        for (int k = 0; k < 3; k++) {
            int p = pairs[k][0], q = pairs[k][1];
            if (a[p][q] == 0)
                continue;
            real theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
            real t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
            real c = 1 / sqrt(t * t + 1), s = t * c;
            for (int i = 0; i < 3; i++) {
                real x = a[i][p], y = a[i][q];
                a[i][p] = c * x - s * y;
                a[i][q] = s * x + c * y;
            }
            for (int i = 0; i < 3; i++) {
                real x = a[p][i], y = a[q][i];
                a[p][i] = c * x - s * y;
                a[q][i] = s * x + c * y;
            }
            for (int i = 0; i < 3; i++) {
                real x = v[i][p], y = v[i][q];
                v[i][p] = c * x - s * y;
                v[i][q] = s * x + c * y;
            }
        }
    }
    *moments = (vec3){a[0][0], a[1][1], a[2][2]};
    *axes = (mat3){{v[0][0], v[0][1], v[0][2]}, {v[1][0], v[1][1], v[1][2]}, {v[2][0], v[2][1], v[2][2]}};
    if (mat3_det(*axes) < 0) {          /* right-handed: flip the last column */
        axes->r0.z = -axes->r0.z;
        axes->r1.z = -axes->r1.z;
        axes->r2.z = -axes->r2.z;
    }
}
