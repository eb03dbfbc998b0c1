/* api/schema.c - every parameter of the public API, declared once. Lua keys, checks, errors and docs follow from these rows. */
#include "api/api.h"

#define AT(type, field) offsetof(type, field)

static const dig_param world_rows[] = {
    /* name, kind, unit, doc, default, min, max, offset */
    {.name = "gravity", .kind = DIG_VEC3, .unit = "m/s^2",
     .doc = "acceleration of gravity; default {0, -9.81, 0}", .fallback = NAN, .min = -1e6, .max = 1e6,
     .offset = AT(dig_world_def, gravity)},
    {.name = "step", .kind = DIG_REAL, .unit = "s",
     .doc = "the frame step, not the accuracy", .fallback = 1.0 / 60, .min = 1e-6, .max = 0.1, .offset = AT(dig_world_def, step)},
    {.name = "accuracy", .kind = DIG_TEXT, .unit = "",
     .doc = "sketch, play, study or reference; a number is a tolerance in metres", .offset = AT(dig_world_def, accuracy)},
    {.name = "tolerance", .kind = DIG_REAL, .unit = "m",
     .doc = "accuracy as a length", .fallback = NAN, .min = 1e-12, .max = 1, .offset = AT(dig_world_def, tolerance)},
    {.name = "seed", .kind = DIG_INT, .unit = "1",
     .doc = "of all random numbers", .fallback = 1, .min = -9e15, .max = 9e15, .offset = AT(dig_world_def, seed)},
    {.name = "threads", .kind = DIG_INT, .unit = "1",
     .doc = "the same bits for any number", .fallback = 1, .min = 1, .max = 64, .offset = AT(dig_world_def, threads)},
    {.name = "plane", .kind = DIG_TEXT, .unit = "",
     .doc = "xy, yz or xz keeps all motion in that plane", .offset = AT(dig_world_def, plane)},
    {.name = "friction_law", .kind = DIG_TEXT, .unit = "",
     .doc = "coulomb, or decay: sliding speed decays in proportion", .offset = AT(dig_world_def, friction_law)},
    {.name = "sleeping", .kind = DIG_BOOL, .unit = "",
     .doc = "DIGs at rest fall asleep", .fallback = 1, .max = 1, .offset = AT(dig_world_def, sleeping)},
    {.name = NULL},
};

static const char *const integrators[] = {"auto", "euler", "verlet", "switch", NULL};      /* dig_integrator */

static const dig_param body_rows[] = {
    {.name = "name", .kind = DIG_TEXT, .unit = "",
     .doc = "for messages, events and world:find", .offset = AT(dig_body_def, name)},
    {.name = "at", .kind = DIG_VEC3, .unit = "m",
     .doc = "position of the body's origin", .min = -1e9, .max = 1e9, .offset = AT(dig_body_def, at)},
    {.name = "rotation", .kind = DIG_QUAT, .unit = "1", .doc = "orientation", .offset = AT(dig_body_def, rotation)},
    {.name = "velocity", .kind = DIG_VEC3, .unit = "m/s",
     .doc = "of the centre of mass", .min = -1e6, .max = 1e6, .offset = AT(dig_body_def, velocity)},
    {.name = "spin", .kind = DIG_VEC3, .unit = "rad/s",
     .doc = "angular velocity", .min = -1e6, .max = 1e6, .offset = AT(dig_body_def, spin)},
    {.name = "mass", .kind = DIG_REAL, .unit = "kg",
     .doc = "default from density and volume", .fallback = NAN, .min = 1e-12, .max = 1e15, .offset = AT(dig_body_def, mass)},
    {.name = "density", .kind = DIG_REAL, .unit = "kg/m^3",
     .doc = "default from the material", .fallback = NAN, .min = 1e-6, .max = 1e9, .offset = AT(dig_body_def, density)},
    {.name = "material", .kind = DIG_MATERIAL, .unit = "",
     .doc = "name of a material", .offset = AT(dig_body_def, material)},
    {.name = "friction", .kind = DIG_REAL, .unit = "1",
     .doc = "static friction coefficient", .fallback = NAN, .min = 0, .max = 100, .offset = AT(dig_body_def, friction)},
    {.name = "friction_dynamic", .kind = DIG_REAL, .unit = "1",
     .doc = "dynamic friction coefficient, default as static",
     .fallback = NAN, .min = 0, .max = 100, .offset = AT(dig_body_def, friction_dynamic)},
    {.name = "rolling_friction", .kind = DIG_REAL, .unit = "1",
     .doc = "rolling resistance: lever arm over radius",
     .fallback = NAN, .min = 0, .max = 10, .offset = AT(dig_body_def, rolling_friction)},
    {.name = "restitution", .kind = DIG_REAL, .unit = "1",
     .doc = "speed after over speed before a bounce", .fallback = NAN, .min = 0, .max = 1, .offset = AT(dig_body_def, restitution)},
    {.name = "fixed", .kind = DIG_BOOL, .unit = "", .doc = "never moves", .max = 1, .offset = AT(dig_body_def, fixed)},
    {.name = "kinematic", .kind = DIG_BOOL, .unit = "",
     .doc = "moves as told, whatever pushes it", .max = 1, .offset = AT(dig_body_def, kinematic)},
    {.name = "gravity_scale", .kind = DIG_REAL, .unit = "1",
     .doc = "share of gravity it feels", .fallback = 1, .min = -1000, .max = 1000, .offset = AT(dig_body_def, gravity_scale)},
    {.name = "collides", .kind = DIG_BOOL, .unit = "",
     .doc = "touches other bodies", .fallback = 1, .max = 1, .offset = AT(dig_body_def, collides)},
    {.name = "turns", .kind = DIG_BOOL, .unit = "",
     .doc = "false: it keeps its orientation, as a particle does", .fallback = 1, .max = 1,
     .offset = AT(dig_body_def, turns)},
    {.name = "group", .kind = DIG_INT, .unit = "1",
     .doc = "bodies of the same negative group never touch each other", .min = -9e15, .max = 9e15, .offset = AT(dig_body_def, group)},
    {.name = "integrator", .kind = DIG_CHOICE, .unit = "",
     .doc = "auto, or once a substep by Euler, by Verlet, or switch: Euler at birth and after an impact, then Verlet",
     .max = DIG_INTEGRATORS - 1, .offset = AT(dig_body_def, integrator), .choices = integrators},
    {.name = "colour", .kind = DIG_COLOUR, .unit = "1",
     .doc = "linear red, green, blue; default the material's", .fallback = -1, .min = -1, .max = 1, .offset = AT(dig_body_def, colour)},
    {.name = "opacity", .kind = DIG_REAL, .unit = "1",
     .doc = "share of the light that its surface stops, as drawn; below 1 what lies behind is seen through it",
     .fallback = 1, .max = 1, .offset = AT(dig_body_def, opacity)},
    {.name = "sheet", .kind = DIG_VEC3, .unit = "1",
     .doc = "{number, column, row}: a particle of the sheet of that number, drawn as a surface between neighbours that struts join",
     .min = 0, .max = 1e9, .offset = AT(dig_body_def, sheet)},
    {.name = NULL},
};

static const dig_param joint_rows[] = {
    {.name = "name", .kind = DIG_TEXT, .unit = "", .doc = "for messages and events", .offset = AT(dig_joint_def, name)},
    {.name = "a", .kind = DIG_BODY, .unit = "", .doc = "first body", .offset = AT(dig_joint_def, a)},
    {.name = "b", .kind = DIG_BODY, .unit = "", .doc = "second body; none, or b = world: the world", .offset = AT(dig_joint_def, b)},
    {.name = "at", .kind = DIG_VEC3, .unit = "m",
     .doc = "where, in world coordinates; default the centre of mass of a",
     .fallback = NAN, .min = -1e9, .max = 1e9, .offset = AT(dig_joint_def, at)},
    {.name = "axis", .kind = DIG_DIR, .unit = "1",
     .doc = "its axis, in world coordinates", .fallback = NAN, .offset = AT(dig_joint_def, axis)},
    {.name = "breaks_at", .kind = DIG_REAL, .unit = "N",
     .doc = "breaks when its force exceeds this",
     .fallback = INFINITY, .min = 0, .max = INFINITY, .offset = AT(dig_joint_def, breaks_at)},
    {.name = "collides", .kind = DIG_BOOL, .unit = "",
     .doc = "its two bodies still touch each other, and what else reaches the point that it holds", .max = 1, .offset = AT(dig_joint_def, collides)},
    {.name = NULL},
};

static const dig_param material_rows[] = {
    {.name = "density", .kind = DIG_REAL, .unit = "kg/m^3",
     .doc = "mass per volume", .fallback = 1000, .min = 1e-6, .max = 1e9, .offset = AT(dig_material_def, density)},
    {.name = "friction", .kind = DIG_REAL, .unit = "1",
     .doc = "static friction coefficient", .fallback = 0.5, .min = 0, .max = 100, .offset = AT(dig_material_def, friction)},
    {.name = "friction_dynamic", .kind = DIG_REAL, .unit = "1",
     .doc = "dynamic friction coefficient, default as static",
     .fallback = NAN, .min = 0, .max = 100, .offset = AT(dig_material_def, friction_dynamic)},
    {.name = "rolling_friction", .kind = DIG_REAL, .unit = "1",
     .doc = "rolling resistance: lever arm over radius", .min = 0, .max = 10, .offset = AT(dig_material_def, rolling_friction)},
    {.name = "restitution", .kind = DIG_REAL, .unit = "1",
     .doc = "speed after over speed before a bounce", .min = 0, .max = 1, .offset = AT(dig_material_def, restitution)},
    {.name = "heat_capacity", .kind = DIG_REAL, .unit = "J/(kg K)",
     .doc = "specific heat capacity", .fallback = 1000, .min = 1, .max = 1e6, .offset = AT(dig_material_def, heat_capacity)},
    {.name = "conductivity", .kind = DIG_REAL, .unit = "W/(m K)",
     .doc = "thermal conductivity", .fallback = 1, .min = 0, .max = 1e5, .offset = AT(dig_material_def, conductivity)},
    {.name = "resistivity", .kind = DIG_REAL, .unit = "ohm m",
     .doc = "electrical resistivity", .fallback = 1e12, .min = 0, .max = 1e30, .offset = AT(dig_material_def, resistivity)},
    {.name = "strength", .kind = DIG_REAL, .unit = "Pa",
     .doc = "tensile strength", .fallback = 2e7, .min = 0, .max = 1e13, .offset = AT(dig_material_def, strength)},
    {.name = "stiffness", .kind = DIG_REAL, .unit = "Pa",
     .doc = "Young's modulus", .fallback = 1e9, .min = 1, .max = 1e15, .offset = AT(dig_material_def, stiffness)},
    {.name = "colour", .kind = DIG_COLOUR, .unit = "1",
     .doc = "linear red, green, blue", .fallback = 0.5, .max = 1, .offset = AT(dig_material_def, colour)},
    {.name = "roughness", .kind = DIG_REAL, .unit = "1",
     .doc = "of the surface as drawn; a floor below 0.35 mirrors what stands on it",
     .fallback = 0.6, .min = 0.03, .max = 1, .offset = AT(dig_material_def, roughness)},
    {.name = "metallic", .kind = DIG_REAL, .unit = "1",
     .doc = "0 or 1, as drawn", .max = 1, .offset = AT(dig_material_def, metallic)},
    {.name = "pattern", .kind = DIG_TEXT, .unit = "",
     .doc = "drawn as plain, wood, brick, tile, stripe or check", .offset = AT(dig_material_def, pattern)},
    {.name = "sound", .kind = DIG_TEXT, .unit = "", .doc = "name of its sound", .offset = AT(dig_material_def, sound)},
    {.name = NULL},
};

static const dig_param room_rows[] = {
    {.name = "size", .kind = DIG_SIZE3, .unit = "m",
     .doc = "inner width, height, depth", .fallback = NAN, .min = 1e-3, .max = 1e6, .offset = AT(dig_room_def, size), .required = true},
    {.name = "at", .kind = DIG_VEC3, .unit = "m",
     .doc = "centre of its floor", .min = -1e9, .max = 1e9, .offset = AT(dig_room_def, at)},
    {.name = "friction", .kind = DIG_REAL, .unit = "1",
     .doc = "of its walls, at rest and sliding; default that of the material", .fallback = NAN, .min = 0, .max = 100,
     .offset = AT(dig_room_def, friction)},
    {.name = "restitution", .kind = DIG_REAL, .unit = "1",
     .doc = "of its walls; default that of the material", .fallback = NAN, .min = 0, .max = 1, .offset = AT(dig_room_def, restitution)},
    {.name = "material", .kind = DIG_MATERIAL, .unit = "",
     .doc = "of its walls", .offset = AT(dig_room_def, material)},
    {.name = NULL},
};

static const dig_param region_rows[] = {
    {.name = "gravity", .kind = DIG_VEC3, .unit = "m/s^2", .doc = "acceleration of gravity inside; default the world's",
     .fallback = NAN, .min = -1e6, .max = 1e6, .offset = AT(dig_region_def, gravity)},
    {.name = "drag", .kind = DIG_REAL, .unit = "1/s", .doc = "rate at which speed and spin decay",
     .min = 0, .max = 1e6, .offset = AT(dig_region_def, drag)},
    {.name = "friction_scale", .kind = DIG_REAL, .unit = "1", .doc = "multiplies friction",
     .fallback = 1, .min = 0, .max = 100, .offset = AT(dig_region_def, friction_scale)},
    {.name = "restitution_scale", .kind = DIG_REAL, .unit = "1", .doc = "multiplies restitution, at most to 1",
     .fallback = 1, .min = 0, .max = 100, .offset = AT(dig_region_def, restitution_scale)},
    {.name = "conduct", .kind = DIG_REAL, .unit = "1", .doc = "multiplies conductances",
     .fallback = 1, .min = 0, .max = 1e6, .offset = AT(dig_region_def, conduct)},
    {.name = "time_rate", .kind = DIG_REAL, .unit = "1", .doc = "seconds that go by inside for one outside",
     .fallback = 1, .min = 1e-3, .max = 1e3, .offset = AT(dig_region_def, time_rate)},
    {.name = NULL},
};

static const dig_schema fixed_schemas[] = {
    {"world", "a world", world_rows, sizeof(dig_world_def)},
    {"body", "what all bodies have in common", body_rows, sizeof(dig_body_def)},
    {"joint", "what all joints have in common", joint_rows, sizeof(dig_joint_def)},
    {"material", "a material", material_rows, sizeof(dig_material_def)},
    {"region", "a part of space with laws of its own", region_rows, sizeof(dig_region_def)},
    {"room", "six walls without a body of their own", room_rows, sizeof(dig_room_def)},
};

static const dig_schema *fixed_schema(const char *kind)
{
    for (size_t i = 0; i < sizeof fixed_schemas / sizeof fixed_schemas[0]; i++)
        if (strcmp(fixed_schemas[i].name, kind) == 0)
            return &fixed_schemas[i];
    return NULL;
}

/* "joint" lists the types, "joint.common" what they share. */
const dig_schema *dig_schema_at(const char *kind, int index)
{
    if (index < 0)
        return NULL;
    if (strcmp(kind, "shape") == 0) {
        for (int i = 0; shape_types[i]; i++)
            if (i == index)
                return &shape_types[i]->schema;
        return NULL;
    }
    if (strcmp(kind, "joint") == 0) {
        for (int i = 0; joint_types[i]; i++)
            if (i == index)
                return &joint_types[i]->schema;
        return NULL;
    }
    return index == 0 ? fixed_schema(strcmp(kind, "joint.common") == 0 ? "joint" : kind) : NULL;
}

const dig_schema *dig_schema_find(const char *kind, const char *name)
{
    const dig_schema *s;
    for (int i = 0; (s = dig_schema_at(kind, i)) != NULL; i++)
        if (strcmp(s->name, name) == 0)
            return s;
    return NULL;
}
