/* geom/shape.c - the list of shape types, and making, sharing and freeing shapes. */
#include <stdlib.h>

#include "geom/shape_build.h"

const ShapeType *const shape_types[] = {
    &shape_sphere, &shape_box, &shape_capsule, &shape_cylinder, &shape_cone, &shape_plane, &shape_hull, &shape_mesh,
    &shape_heightfield, NULL
};

const ShapeType *shape_type_find(const char *name)
{
    for (int i = 0; name && shape_types[i]; i++)
        if (strcmp(shape_types[i]->name, name) == 0)
            return shape_types[i];
    return NULL;
}

/* ---- memory: the count, the size and the data are one allocation ---- */

typedef struct Block { int refs; size_t bytes; } Block;
#define BLOCK_HEADER ((sizeof(Block) + 15) / 16 * 16)

void *shape_alloc(Shape *s, size_t bytes)
{
    Block *b = calloc(1, BLOCK_HEADER + bytes);
    if (!b)
        return NULL;
    b->refs  = 1;
    b->bytes = bytes;
    s->refs  = &b->refs;
    s->data  = (char *)b + BLOCK_HEADER;
    return (char *)b + BLOCK_HEADER;
}

Shape shape_keep(const Shape *s)
{
    if (s->refs)
        ++*s->refs;
    return *s;
}

void shape_free(Shape *s)
{
    if (s->refs && --*s->refs == 0)
        free(s->refs);                          /* the first member of its Block */
    *s = (Shape){0};
}

size_t shape_bytes(const Shape *s)
{
    return s->refs ? ((const Block *)(const void *)s->refs)->bytes : 0;
}

/* ---- checking a def against the rows of its type ---- */

typedef struct Check { const char *type; const dig_param *row; char *why; size_t capacity; } Check;

/* `part` names the component, "" for plain numbers. Written so that NaN fails. */
static dig_status check_real(const Check *c, const char *part, real x)
{
    const dig_param *row = c->row;
    if (x >= row->min && x <= row->max)
        return DIG_OK;
    const char *space = row->unit[0] ? " " : "";
    return shape_fail(isfinite(x) ? DIG_E_ARG : DIG_E_FINITE, c->why, c->capacity, "%s %s%s = %g%s%s, must be %g to %g%s%s", c->type,
                      row->name, part, x, space, row->unit, row->min, row->max, space, row->unit);
}

static dig_status check_vec3(const Check *c, vec3 v)
{
    DIG_TRY(check_real(c, ".x", v.x));
    DIG_TRY(check_real(c, ".y", v.y));
    return check_real(c, ".z", v.z);
}

static dig_status check_points(const Check *c, const dig_points *points)
{
    static const char axes[3] = {'x', 'y', 'z'};
    if (points->count < 0 || (points->count > 0 && !points->v))
        return shape_fail(DIG_E_ARG, c->why, c->capacity, "%s %s: %d given, must be a list", c->type, c->row->name, points->count);
    for (int i = 0; i < points->count; i++)
        for (int k = 0; k < 3; k++) {
            real x = vec3_at(points->v[i], k);
            if (!(x >= c->row->min && x <= c->row->max))
                return shape_fail(isfinite(x) ? DIG_E_ARG : DIG_E_FINITE, c->why, c->capacity, "%s %s[%d].%c = %g %s, must be %g to %g %s",
                                  c->type, c->row->name, i + 1, axes[k], x, c->row->unit, c->row->min, c->row->max, c->row->unit);
        }
    return DIG_OK;
}

static dig_status check_row(const Check *c, const void *value)
{
    switch (c->row->kind) {
    case DIG_REAL:   return check_real(c, "", *(const real *)value);
    case DIG_INT:    return check_real(c, "", (real)*(const int64_t *)value);
    case DIG_VEC3:
    case DIG_DIR:
    case DIG_SIZE3:  return check_vec3(c, *(const vec3 *)value);
    case DIG_POINTS: return check_points(c, value);
    default:         return DIG_OK;
    }
}

dig_status shape_make(const char *type, const void *def, Shape *out, char *why, size_t capacity)
{
    Shape s = {0};
    *out = s;
    s.type = shape_type_find(type);
    if (!s.type)
        return shape_fail(DIG_E_ARG, why, capacity, "there is no shape '%s'", type ? type : "");
    if (!def)
        return shape_fail(DIG_E_ARG, why, capacity, "%s has no data", s.type->name);

    for (const dig_param *row = s.type->params; row->name; row++) {
        Check c = {s.type->name, row, why, capacity};
        DIG_TRY(check_row(&c, (const char *)def + row->offset));
    }
    dig_status status = s.type->make(def, &s, why, capacity);
    if (status != DIG_OK) {
        if (status == DIG_E_MEMORY)
            shape_fail(status, why, capacity, "no memory for a %s", s.type->name);
        shape_free(&s);
        return status;
    }
    *out = s;
    return DIG_OK;
}
