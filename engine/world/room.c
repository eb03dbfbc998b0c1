/* world/room.c - who is in the room. Its walls are planes, solid all through: what is put beyond one is lifted out of it, which gives it energy. */
#include "world/world.h"

/* m  By how much a point is beyond that wall: 0 to 5 for -x or +x and so on, as the room's solids are numbered. */
static real beyond(const dig_room_def *r, int wall, vec3 at)
{
    vec3 off = vec3_sub(at, vec3_add(r->at, (vec3){0, 0.5 * r->size.y, 0}));
    real sign = wall % 2 ? -1 : 1;
    return sign * vec3_at(off, wall / 2) - 0.5 * vec3_at(r->size, wall / 2);
}

dig_status room_admits(World *w, const dig_room_def *r, uint32_t walls, const Body *b, const char *name)
{
    static const char axes[] = "xyz";
    for (int i = 0; i < 6; i++) {
        if (!(walls >> i & 1) || !(beyond(r, i, b->x) > b->outer))
            continue;
        int axis = i / 2;
        real middle = vec3_at(r->at, axis) + (axis == 1 ? 0.5 * r->size.y : 0), half = 0.5 * vec3_at(r->size, axis);
        return world_fail(w, DIG_E_ARG, "%s: it is at %c = %g m, all of it beyond wall %s of the room, which goes from %g to %g m there"
                          " (the room's 'at' is the centre of its floor)",
                          name, axes[axis], vec3_at(b->x, axis), wall_name(i + 1), middle - half, middle + half);
    }
    return DIG_OK;
}

uint32_t room_walls(const World *w)
{
    uint32_t walls = 0;
    for (int i = 0; i < 6 && w->has_room; i++)
        walls |= (uint32_t)(w->room_solid[i] != NONE) << i;
    return walls;
}
