/* base/index.c - records by the hash of a key that they hold themselves. */
#include "base/index.h"

#include <stdlib.h>

#define INDEX_LARGEST (1u << 30)        /* entries of the table */

static bool holds(uint32_t size, uint64_t entries) { return entries * 3 <= (uint64_t)size * 2; }

/* There is room. */
static void put(Index *x, IndexEntry e)
{
    uint32_t mask = x->size - 1, i = e.hash & mask;
    while (x->entries[i].hash)
        i = (i + 1) & mask;
    x->entries[i] = e;
    x->count++;
}

dig_status index_reserve(Index *x, int entries)
{
    if (entries < 0 || !holds(INDEX_LARGEST, (uint64_t)entries))
        return DIG_E_ARG;
    uint32_t size = x->size ? x->size : 16;
    while (!holds(size, (uint64_t)entries))
        size *= 2;
    if (size == x->size)
        return DIG_OK;
    Index grown = {.entries = calloc(size, sizeof *grown.entries), .size = size};
    if (!grown.entries)
        return DIG_E_MEMORY;
    for (uint32_t i = 0; i < x->size; i++)
        if (x->entries[i].hash)
            put(&grown, x->entries[i]);
    free(x->entries);
    *x = grown;
    return DIG_OK;
}

bool index_find(const Index *x, MapKey key, IndexSame *same, const void *context, uint32_t *record)
{
    uint32_t mask = x->size - 1, hash = map_hash(key);
    if (!x->count)
        return false;
    for (uint32_t i = hash & mask; x->entries[i].hash; i = (i + 1) & mask)
        if (x->entries[i].hash == hash && same(context, x->entries[i].record, key)) {
            *record = x->entries[i].record;
            return true;
        }
    return false;
}

dig_status index_add(Index *x, MapKey key, uint32_t record)
{
    DIG_TRY(index_reserve(x, (int)(x->count + 1)));
    put(x, (IndexEntry){map_hash(key), record});
    return DIG_OK;
}

void index_remove(Index *x, MapKey key, uint32_t record)
{
    uint32_t mask = x->size - 1, hash = map_hash(key), hole = hash & mask;
    if (!x->count)
        return;
    while (x->entries[hole].hash && x->entries[hole].record != record)
        hole = (hole + 1) & mask;
    if (!x->entries[hole].hash)
        return;
    /* An entry may fill the hole unless its home lies cyclically behind the hole. */
    for (uint32_t i = (hole + 1) & mask; x->entries[i].hash; i = (i + 1) & mask) {
        uint32_t home = x->entries[i].hash & mask;
        if (((i - home) & mask) >= ((i - hole) & mask)) {
            x->entries[hole] = x->entries[i];
            hole = i;
        }
    }
    x->entries[hole] = (IndexEntry){0};
    x->count--;
}

void index_renumber(Index *x, const uint32_t *to)
{
    uint32_t size = 16;
    while (!holds(size, x->count))
        size *= 2;
    for (uint32_t i = 0; i < x->size; i++)
        if (x->entries[i].hash)
            x->entries[i].record = to[x->entries[i].record];
    Index small = {.size = size};
    if (size >= x->size || !(small.entries = calloc(size, sizeof *small.entries)))
        return;
    for (uint32_t i = 0; i < x->size; i++)
        if (x->entries[i].hash)
            put(&small, x->entries[i]);
    free(x->entries);
    *x = small;
}

dig_status index_copy(Index *to, const Index *from)
{
    if (to == from)
        return DIG_OK;
    if (to->size != from->size) {
        IndexEntry *table = from->size ? malloc(from->size * sizeof *table) : NULL;
        if (from->size && !table)
            return DIG_E_MEMORY;
        free(to->entries);
        to->entries = table;
        to->size = from->size;
    }
    if (from->size)
        memcpy(to->entries, from->entries, from->size * sizeof *to->entries);
    to->count = from->count;
    return DIG_OK;
}

void index_close(Index *x)
{
    free(x->entries);
    *x = (Index){0};
}

size_t index_bytes(const Index *x) { return x->size * sizeof *x->entries; }
