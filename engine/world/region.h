/* world/region.h - parts of space where other laws hold. A body is in a region when its centre of mass is.
 *
 * Floor: world.
 */
#ifndef DIG_REGION_H
#define DIG_REGION_H

#include "world/world.h"

static inline bool region_holds(const Region *r, vec3 at)
{
    return r->alive && r->shape.type->contains(&r->shape, pose_unpoint(r->at, at));
}

#endif
