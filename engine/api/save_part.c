/* api/save_part.c - what records have in common: handles, surfaces, tables with free slots, structs described by rows. */
#include "api/save.h"

#include <stdlib.h>

void save_gen(Pack *p, const World *w, uint32_t *gen, bool own)
{
    uint32_t number = *gen ? *gen - w->gen_start + 1 : 0;
    pack_u32(p, &number);
    if (!p->reading)
        return;
    if (own)
        pack_check(p, number >= 1 && number <= w->serial, "a handle was never given");
    *gen = number ? number - 1 + w->gen_start : 0;
}

void save_body_handle(Pack *p, const World *w, dig_body *b)
{
    pack_u32(p, &b->slot);
    save_gen(p, w, &b->gen, false);
}

void save_joint_handle(Pack *p, const World *w, dig_joint *j)
{
    pack_u32(p, &j->slot);
    save_gen(p, w, &j->gen, false);
}

void save_region_handle(Pack *p, const World *w, dig_region *r)
{
    pack_u32(p, &r->slot);
    save_gen(p, w, &r->gen, false);
}

void save_surface(Pack *p, const World *w, Surface *s)
{
    uint32_t material = (uint32_t)s->material;
    pack_index(p, &material, (uint32_t)w->materials.count, false, "material");
    s->material = (int)material;
    pack_real_or_nan(p, &s->friction, 0, 100, "friction");
    pack_real_or_nan(p, &s->friction_dynamic, 0, 100, "friction_dynamic");
    pack_real_or_nan(p, &s->rolling, 0, 10, "rolling_friction");
    pack_real_or_nan(p, &s->restitution, 0, 1, "restitution");
}

void save_pose(Pack *p, pose *at, const char *what)
{
    pack_vec3(p, &at->p, SAVE_FAR, what);
    pack_quat(p, &at->q, what);
}

/* ---- structs described by rows ---- */

/* Reals and whole numbers of a field, through copies: fields are reached by offset. */
static void pack_reals(Pack *p, char *field, size_t size)
{
    for (size_t at = 0; at < size; at += sizeof(real)) {
        real x;
        memcpy(&x, field + at, sizeof x);
        pack_real(p, &x);
        memcpy(field + at, &x, sizeof x);
    }
}

static void pack_whole_field(Pack *p, char *field)
{
    int64_t i;
    memcpy(&i, field, sizeof i);
    pack_i64(p, &i);
    memcpy(field, &i, sizeof i);
}

static void pack_yes_field(Pack *p, char *field)
{
    bool b;
    memcpy(&b, field, sizeof b);
    pack_bool(p, &b);
    memcpy(field, &b, sizeof b);
}

/* dig_body and dig_joint are the same two numbers. */
static void pack_handle_field(Pack *p, const World *w, char *field)
{
    dig_body b;
    memcpy(&b, field, sizeof b);
    save_body_handle(p, w, &b);
    memcpy(field, &b, sizeof b);
}

void save_field(Pack *p, const World *w, const dig_param *row, void *field)
{
    switch (row->kind) {
    case DIG_REAL: case DIG_RANGE: case DIG_PAIR: case DIG_VEC3: case DIG_DIR: case DIG_SIZE3: case DIG_COLOUR: case DIG_QUAT:
        pack_reals(p, field, param_size(row));
        break;
    case DIG_INT: case DIG_CHOICE: pack_whole_field(p, field); break;
    case DIG_BOOL: pack_yes_field(p, field); break;
    case DIG_TEXT: case DIG_MATERIAL: pack_text(p, field, sizeof(dig_text)); break;
    case DIG_BODY: case DIG_JOINT: pack_handle_field(p, w, field); break;
    case DIG_TABLE: case DIG_POINTS: case DIG_INDICES: pack_fail(p, "'%s' is a list, which no record keeps", row->name); break;
    }
}

static void check_specks(Pack *p, const char *field, size_t size)
{
    for (size_t at = 0; at < size; at += sizeof(real)) {
        real x;
        memcpy(&x, field + at, sizeof x);
        pack_check(p, x == 0 || !(fabs(x) < PARAM_SPECK), "a number is too small to be divided by");
    }
}

static void pack_fields(Pack *p, const World *w, const dig_param *rows, char *fields)
{
    for (const dig_param *row = rows; row && row->name; row++) {
        char *field = fields + row->offset;
        if (row->kind == DIG_TABLE) {
            pack_fields(p, w, row->rows, field);
            continue;
        }
        save_field(p, w, row, field);
        if (param_has_reals(row))
            check_specks(p, field, param_size(row));
    }
}

void save_rows(Pack *p, const World *w, const dig_param *rows, void *fields, const char *subject)
{
    char why[160];
    pack_fields(p, w, rows, fields);
    if (p->reading && pack_good(p) && param_check(rows, fields, subject, why, sizeof why) != DIG_OK)
        pack_fail(p, "%s", why);
}

/* ---- lists and tables ---- */

void save_slots(Pack *p, World *w, void *list, uint32_t limit, const char *what)
{
    LIST(uint32_t) *slots = list;
    uint32_t count = pack_count(p, (uint32_t)slots->count, sizeof(uint32_t), what);
    if (p->reading) {
        if (list_reserve_any((void **)&slots->data, &slots->capacity, sizeof *slots->data, (int)count, &w->allocations) != DIG_OK) {
            pack_fail_memory(p);
            return;
        }
        slots->count = (int)count;
    }
    for (uint32_t i = 0; i < count; i++)
        pack_index(p, &slots->data[i], limit, false, what);
}

unsigned char *save_table(Pack *p, World *w, void **data, int *count, int *capacity, size_t item, void *free_list, size_t least, const char *what)
{
    LIST(uint32_t) *unused = free_list;
    uint32_t slots = (uint32_t)*count;
    pack_u32(p, &slots);
    save_slots(p, w, unused, slots, what);
    uint32_t used = slots - (uint32_t)unused->count;
    if (!pack_check(p, (uint32_t)unused->count <= slots && slots <= INT32_MAX && (uint64_t)used * least <= p->size - p->at, what))
        return NULL;
    unsigned char *marks = calloc((size_t)slots + 1, 1);
    bool room = marks != NULL;
    if (p->reading && room)     /* room in the free list for every slot there is: giving one back cannot fail */
        room = list_reserve_any(data, capacity, item, (int)slots, &w->allocations) == DIG_OK
            && list_reserve_any((void **)&unused->data, &unused->capacity, sizeof *unused->data, (int)slots, &w->allocations) == DIG_OK;
    if (!room) {
        pack_fail_memory(p);
        free(marks);
        return NULL;
    }
    *count = (int)slots;
    for (int i = 0; i < unused->count; i++) {
        pack_check(p, !marks[unused->data[i]], what);
        marks[unused->data[i]] = 1;
    }
    if (pack_good(p))
        return marks;
    free(marks);
    return NULL;
}
