/* math/tumble.h - how a free body turns on, in closed form: with its angular momentum, for h seconds.
 *
 * Floor: math.
 */
#ifndef DIG_TUMBLE_H
#define DIG_TUMBLE_H

#include "math/mat3.h"
#include "math/quat.h"

bool tumble_principal(const mat3 *inv_inertia);         /* is it of principal axes? */
int  tumble_axis(const mat3 *inv_inertia);              /* ... about which the other two are the same within rounding, or -1 */
quat tumble_about(const mat3 *inv_inertia, quat q, vec3 momentum, real h, int axis);
/* Of principal axes, no two the same. false: too near the separatrix, or too far a turn, and nothing changed */
bool tumble(const mat3 *inv_inertia, quat *q, vec3 momentum, real h);
/* Of any axes; costs the finding of its own first. The same. */
bool tumble_far(const mat3 *inv_inertia, quat *q, vec3 momentum, real h);

#endif
