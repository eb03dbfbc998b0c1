/* world/work.c - how much was done in a world, counted and not timed: equal calls take equal amounts on every machine, at any number
 * of threads. What runs a script charges it for this (docs/security.md), so that heavy calls cannot go round a limit of instructions.
 *
 * One unit is about ten nanoseconds of one core, as one instruction of Lua is. Counts stand for costs, not more: what matters is that
 * they grow with them.
 */
#include "world/world.h"

enum { CALL = 20, SHAPE = 100, POINT = 30, BYTES = 16 };    /* units; BYTES: of a shape's data for one unit */

/* The counter is, beside the text of errors, what a question may change in a const world. */
void world_work(const World *w, uint64_t units)
{
    World *mutable_world = (World *)(uintptr_t)w;
    mutable_world->work += units;
}

void world_work_through(const World *w, uint64_t each)
{
    int things = w->bodies.count + w->solids.count + w->pairs.count + w->contacts.count + w->joints.count + w->events.count;
    world_work(w, CALL + each * (uint64_t)things);
}

void world_work_shape(const World *w, const Shape *s, const void *def)
{
    uint64_t points = 0;
    for (const dig_param *row = s->type->params; row->name; row++) {
        const void *value = (const char *)def + row->offset;
        points += row->kind == DIG_POINTS ? (uint64_t)((const dig_points *)value)->count : 0;
        points += row->kind == DIG_INDICES ? (uint64_t)((const dig_indices *)value)->count : 0;
    }
    world_work(w, SHAPE + POINT * points + shape_bytes(s) / BYTES);
}
