/* api/room.c - the six-sided room: walls that have no body of their own and can be opened one by one. */
#include "api/api.h"
#include "api/command.h"

const char *dig_wall_name(int wall) { return wall_name(wall); }

static int material_of(const World *w, const dig_room_def *r) { return r->material.s[0] ? material_find(w, r->material.s) : 0; }

/* The wall on side i faces inwards; it is a plane of the world itself. */
static dig_status add_wall(World *w, int i)
{
    const dig_room_def *r = &w->room;
    vec3 middle = vec3_add(r->at, (vec3){0, 0.5 * r->size.y, 0});
    real sign = i % 2 ? -1 : 1;
    vec3 outward = {i / 2 == 0 ? sign : 0, i / 2 == 1 ? sign : 0, i / 2 == 2 ? sign : 0};
    vec3 normal = vec3_neg(outward);
    vec3 at = vec3_add(middle, vec3_mul(outward, vec3_scale(0.5, r->size)));
    dig_plane_def plane = {normal, vec3_dot(normal, at)};
    Surface surface = {material_of(w, r), r->friction, r->friction, NAN, r->restitution};
    if (surface.material < 0)
        return world_fail(w, DIG_E_ARG, "room: there is no material '%s'", r->material.s);
    Shape shape;
    char why[128];
    dig_status s = shape_make("plane", &plane, &shape, why, sizeof why);
    if (s == DIG_OK) {
        s = solid_add(w, NONE, &shape, pose_identity(), &surface, (vec3){-1, -1, -1}, &w->room_solid[i]);
        shape_free(&shape);             /* the solid holds a reference of its own */
        if (s == DIG_OK)
            w->solids.data[w->room_solid[i]].wall = (uint8_t)(i + 1);
    }
    if (s != DIG_OK)
        w->room_solid[i] = NONE;
    return s;
}

/* Bodies that touched the wall leave it. */
static void remove_wall(World *w, int i)
{
    if (w->room_solid[i] == NONE)
        return;
    solid_remove(w, w->room_solid[i]);
    w->room_solid[i] = NONE;
    for (int t = 0; t < w->touches.count; t++)
        if (w->touches.data[t].alive && w->touches.data[t].wall == i + 1 && w->touches.data[t].pairs == 0) {
            dig_event *e = event_post(w, DIG_EVENT_CONTACT_END, w->touches.data[t].body_a, NONE);
            if (e)
                e->wall = (uint8_t)(i + 1);
            touch_remove(w, (uint32_t)t);
        }
}

static dig_status do_set(World *w, const dig_room_def *def)
{
    char why[256];
    if (param_check(dig_schema_at("room", 0)->rows, def, "room", why, sizeof why) != DIG_OK)
        return world_fail(w, DIG_E_ARG, "%s", why);
    if (material_of(w, def) < 0)
        return world_fail(w, DIG_E_ARG, "room: there is no material '%s'", def->material.s);
    for (int i = 0; i < 6 && w->has_room; i++)
        remove_wall(w, i);
    w->room = *def;
    param_settle(dig_schema_at("room", 0)->rows, &w->room);
    w->has_room = true;
    for (int i = 0; i < 6; i++)
        w->room_solid[i] = NONE;
    for (int i = 0; i < 6; i++)
        if (add_wall(w, i) != DIG_OK)
            return world_fail(w, DIG_E_MEMORY, "room: not enough memory");
    world_wake_all(w);
    return DIG_OK;
}

dig_status run_room(World *w, CommandArg *a)
{
    return do_set(w, a[0].what);
}

dig_status dig_room_set(dig_world *w, const dig_room_def *def)
{
    return COMMAND(w, COMMAND_ROOM, do_set(w, def), {.what = def});
}

bool dig_has_room(const dig_world *w) { return w->has_room; }

static dig_status do_open_wall(World *w, const char *wall, bool open)
{
    if (!w->has_room)
        return world_fail(w, DIG_E_ARG, "room: this world has none");
    for (int i = 0; i < 6; i++) {
        if (strcmp(wall, dig_wall_name(i + 1)) != 0)
            continue;
        bool there = w->room_solid[i] != NONE;
        if (open && there)
            remove_wall(w, i);
        if (!open && !there)
            DIG_TRY(add_wall(w, i));
        world_wake_all(w);
        return DIG_OK;
    }
    return world_fail(w, DIG_E_ARG, "room: there is no wall '%s'; they are +x -x +y -y +z -z", wall);
}

dig_status run_wall(World *w, CommandArg *a)
{
    return do_open_wall(w, a[0].what, a[1].yes);
}

dig_status dig_room_open(dig_world *w, const char *wall, bool open)
{
    return COMMAND(w, COMMAND_WALL, do_open_wall(w, wall, open), {.what = wall}, {.yes = open});
}
