/* geom/shape_save.c - shapes as bytes: the list of how each type is written, and the types that few numbers describe. */
#include <stdio.h>
#include <stdlib.h>

#include "geom/save.h"
#include "geom/shape_build.h"

/* Reading: makes the shape as a script would. */
static void make(Pack *p, const char *type, const void *def, Shape *s)
{
    char why[160];
    if (!p->reading || !pack_good(p))
        return;
    dig_status status = shape_make(type, def, s, why, sizeof why);
    if (status == DIG_E_MEMORY)
        pack_fail_memory(p);
    else if (status != DIG_OK)
        pack_fail(p, "%s", why);
}

static void pack_sphere(Pack *p, Shape *s)
{
    dig_sphere_def def = {p->reading ? 0 : ((const SphereData *)s->data)->radius};
    pack_real(p, &def.radius);
    make(p, "sphere", &def, s);
}

/* Halving and doubling are exact: the size gives the same halves again. */
static void pack_box(Pack *p, Shape *s)
{
    dig_box_def def = {p->reading ? vec3_zero() : vec3_scale(2, ((const BoxData *)s->data)->half)};
    pack_vec3(p, &def.size, SHAPE_LENGTH_MAX, "box size");
    make(p, "box", &def, s);
}

static void pack_capsule(Pack *p, Shape *s)
{
    const CapsuleData *d = s->data;
    dig_capsule_def def = {p->reading ? 0 : d->radius, p->reading ? 0 : 2 * d->half};
    pack_real(p, &def.radius);
    pack_real(p, &def.length);
    make(p, "capsule", &def, s);
}

static void pack_cylinder(Pack *p, Shape *s)
{
    const CylinderData *d = s->data;
    dig_cylinder_def def = {p->reading ? 0 : d->radius, p->reading ? 0 : 2 * d->half};
    pack_real(p, &def.radius);
    pack_real(p, &def.height);
    make(p, "cylinder", &def, s);
}

static void pack_cone(Pack *p, Shape *s)
{
    const ConeData *d = s->data;
    dig_cone_def def = {p->reading ? 0 : d->radius, p->reading ? 0 : d->height};
    pack_real(p, &def.radius);
    pack_real(p, &def.height);
    make(p, "cone", &def, s);
}

/* The normal is kept as it is: a unit vector made unit once more may differ in its last digit. */
static void pack_plane(Pack *p, Shape *s)
{
    const PlaneData *d = s->data;
    dig_plane_def def = {p->reading ? vec3_zero() : d->normal, p->reading ? 0 : d->offset};
    pack_vec3(p, &def.normal, 1, "plane normal");
    pack_real(p, &def.offset);
    pack_check(p, fabs(vec3_length2(def.normal) - 1) <= 1e-12, "a plane's normal is no unit vector");
    make(p, "plane", &def, s);
    if (p->reading && s->data)
        ((PlaneData *)(uintptr_t)s->data)->normal = def.normal;     /* nobody else has it yet */
}

static void pack_heightfield(Pack *p, Shape *s)
{
    const HeightfieldData *d = s->data;
    dig_heightfield_def def = {.unused = {NULL, 0}};
    if (!p->reading) {
        def.columns = d->columns;
        def.rows = d->rows;
        def.size = (vec3){-2 * d->x0, 0, -2 * d->z0};
    }
    uint32_t columns = (uint32_t)def.columns, rows = (uint32_t)def.rows;
    pack_u32(p, &columns);
    pack_u32(p, &rows);
    pack_real(p, &def.size.x);
    pack_real(p, &def.size.z);
    uint64_t count = (uint64_t)columns * rows;
    real *heights = NULL;
    if (p->reading) {
        if (!pack_check(p, count > 0 && count <= (p->size - p->at) / sizeof(real), "a height field's heights end early"))
            return;
        heights = malloc((size_t)count * sizeof *heights);
        if (!heights) {
            pack_fail_memory(p);
            return;
        }
    }
    for (size_t i = 0; i < (size_t)count; i++) {
        real h = p->reading ? 0 : heightfield_heights(d)[i];
        pack_real(p, &h);
        if (p->reading)
            heights[i] = h;
    }
    def.columns = columns;
    def.rows = rows;
    def.heights = heights;
    make(p, "heightfield", &def, s);
    free(heights);
}

/* A new shape type needs a line here. */
static const struct { const ShapeType *type; void (*pack)(Pack *p, Shape *s); } packers[] = {
    {&shape_sphere, pack_sphere},     {&shape_box, pack_box},     {&shape_capsule, pack_capsule},
    {&shape_cylinder, pack_cylinder}, {&shape_cone, pack_cone},   {&shape_plane, pack_plane},
    {&shape_hull, hull_pack},         {&shape_mesh, mesh_pack},   {&shape_heightfield, pack_heightfield},
};

void shape_pack(Pack *p, Shape *s)
{
    char name[32] = "";
    if (p->reading)
        *s = (Shape){0};
    else
        snprintf(name, sizeof name, "%s", s->type->name);
    pack_text(p, name, sizeof name);
    for (size_t i = 0; i < sizeof packers / sizeof *packers; i++)
        if (strcmp(packers[i].type->name, name) == 0) {
            packers[i].pack(p, s);
            return;
        }
    pack_fail(p, "there is no shape '%.31s'", name);
}
