/* world/column.c - one struct a body for those that take part in an effect, in the order of their slots. */
#include "world/column.h"

#include "base/block.h"
#include "base/list.h"

static dig_status reserve(Column *c, uint32_t body, uint64_t *allocations)
{
    DIG_TRY(list_reserve_any((void **)&c->data, &c->capacity, c->size, c->count + 1, allocations));
    DIG_TRY(list_reserve_any((void **)&c->body, &c->bodies, sizeof *c->body, c->count + 1, allocations));
    return list_reserve_any((void **)&c->row, &c->rows, sizeof *c->row, (int)body + 1, allocations);
}

/* Members from `first` on are where they are now. */
static void number(Column *c, int first)
{
    for (int i = first; i < c->count; i++)
        c->row[c->body[i]] = (uint32_t)i + 1;
}

dig_status column_add(Column *c, uint32_t body, const void *member, uint64_t *allocations)
{
    void *old = column_find(c, body);
    if (old) {
        memcpy(old, member, c->size);
        return DIG_OK;
    }
    DIG_TRY(reserve(c, body, allocations));
    int at = c->count;
    while (at > 0 && c->body[at - 1] > body)
        at--;
    memmove(column_at(c, at + 1), column_at(c, at), (size_t)(c->count - at) * c->size);
    memmove(c->body + at + 1, c->body + at, (size_t)(c->count - at) * sizeof *c->body);
    memcpy(column_at(c, at), member, c->size);
    c->body[at] = body;
    c->count++;
    number(c, at);
    return DIG_OK;
}

void column_remove(Column *c, uint32_t body)
{
    if (!column_find(c, body))
        return;
    int at = (int)c->row[body] - 1;
    c->row[body] = 0;
    c->count--;
    memmove(column_at(c, at), column_at(c, at + 1), (size_t)(c->count - at) * c->size);
    memmove(c->body + at, c->body + at + 1, (size_t)(c->count - at) * sizeof *c->body);
    number(c, at);
}

dig_status column_copy(Column *to, const Column *from, uint64_t *allocations)
{
    for (int i = 0; i < from->count; i++)
        DIG_TRY(column_add(to, from->body[i], column_at(from, i), allocations));
    return DIG_OK;
}

void column_close(Column *c)
{
    block_free(c->data, (size_t)c->capacity * c->size);
    block_free(c->body, (size_t)c->bodies * sizeof *c->body);
    block_free(c->row, (size_t)c->rows * sizeof *c->row);
    *c = (Column){.size = c->size};
}

size_t column_bytes(const Column *c)
{
    return (size_t)c->capacity * c->size + (size_t)c->bodies * sizeof *c->body + (size_t)c->rows * sizeof *c->row;
}

uint64_t column_hash(const Column *c, uint64_t h)
{
    for (int i = 0; i < c->count; i++) {
        const real *x = column_at(c, i);
        h = hash_u64(h, c->body[i]);
        for (size_t k = 0; k < c->size / sizeof *x; k++)
            h = hash_real(h, x[k]);
    }
    return h;
}
