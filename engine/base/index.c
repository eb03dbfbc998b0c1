/* base/index.c - records by the hash of a key that they hold themselves. */
#include "base/index.h"

#include "base/block.h"

#define INDEX_LARGEST (1u << 30)        /* entries of the table */
#define SMALLEST 16u

static bool holds(uint32_t size, uint64_t entries) { return entries * 3 <= (uint64_t)size * 2; }

/* Of the sizes that a table goes through, the first that holds so many: a quarter more each time, for a large one doubled is mostly air. */
static uint32_t size_for(uint32_t size, uint64_t entries)
{
    while (!holds(size, entries))
        size += size / 4;
    return size;
}

/* Where an entry belongs, by the upper bits of its hash, and where to look next. */
static uint32_t home_of(const Index *x, uint32_t hash) { return (uint32_t)((uint64_t)hash * x->size >> 32); }
static uint32_t after(const Index *x, uint32_t i) { return i + 1 < x->size ? i + 1 : 0; }

/* There is room. */
static void put(Index *x, IndexEntry e)
{
    uint32_t i = home_of(x, e.hash);
    while (x->entries[i].hash)
        i = after(x, i);
    x->entries[i] = e;
    x->count++;
}

static IndexEntry *table_open(uint32_t size) { return block_resize(NULL, 0, size * sizeof(IndexEntry)); }

dig_status index_reserve(Index *x, int entries)
{
    if (entries < 0 || !holds(INDEX_LARGEST, (uint64_t)entries))
        return DIG_E_ARG;
    uint32_t size = size_for(x->size ? x->size : SMALLEST, (uint64_t)entries);
    if (size == x->size)
        return DIG_OK;
    Index grown = {.entries = table_open(size), .size = size};
    if (!grown.entries)
        return DIG_E_MEMORY;
    for (uint32_t i = 0; i < x->size; i++)
        if (x->entries[i].hash)
            put(&grown, x->entries[i]);
    block_free(x->entries, x->size * sizeof *x->entries);
    *x = grown;
    return DIG_OK;
}

bool index_find(const Index *x, MapKey key, IndexSame *same, const void *context, uint32_t *record)
{
    uint32_t hash = map_hash(key);
    if (!x->count)
        return false;
    for (uint32_t i = home_of(x, hash); x->entries[i].hash; i = after(x, i))
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

/* Steps from one place to another, around the end. */
static uint32_t way(const Index *x, uint32_t from, uint32_t to) { return to >= from ? to - from : x->size - from + to; }

void index_remove(Index *x, MapKey key, uint32_t record)
{
    uint32_t hole = home_of(x, map_hash(key));
    if (!x->count)
        return;
    while (x->entries[hole].hash && x->entries[hole].record != record)
        hole = after(x, hole);
    if (!x->entries[hole].hash)
        return;
    /* An entry may fill the hole unless its home lies cyclically behind the hole. */
    for (uint32_t i = after(x, hole); x->entries[i].hash; i = after(x, i)) {
        uint32_t home = home_of(x, x->entries[i].hash);
        if (way(x, home, i) >= way(x, hole, i)) {
            x->entries[hole] = x->entries[i];
            hole = i;
        }
    }
    x->entries[hole] = (IndexEntry){0};
    x->count--;
}

void index_renumber(Index *x, const uint32_t *to, Arena *scratch)
{
    uint32_t size = size_for(SMALLEST, x->count);
    for (uint32_t i = 0; i < x->size; i++)
        if (x->entries[i].hash)
            x->entries[i].record = to[x->entries[i].record];
    if (size >= x->size)
        return;
    ArenaMark mark = arena_mark(scratch);
    uint32_t before = x->size;
    IndexEntry *old = arena_alloc(scratch, before * sizeof *old);
    if (old)
        memcpy(old, x->entries, before * sizeof *old);
    IndexEntry *small = old ? block_resize(x->entries, before * sizeof *small, size * sizeof *small) : NULL;
    if (small) {
        memset(small, 0, size * sizeof *small);
        *x = (Index){.entries = small, .size = size};
        for (uint32_t i = 0; i < before; i++)
            if (old[i].hash)
                put(x, old[i]);
    }
    arena_rewind(scratch, mark);
}

dig_status index_copy(Index *to, const Index *from)
{
    if (to == from)
        return DIG_OK;
    if (to->size != from->size) {
        IndexEntry *table = from->size ? block_open(from->size * sizeof *table) : NULL;
        if (from->size && !table)
            return DIG_E_MEMORY;
        block_free(to->entries, to->size * sizeof *to->entries);
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
    block_free(x->entries, x->size * sizeof *x->entries);
    *x = (Index){0};
}

size_t index_bytes(const Index *x) { return x->size * sizeof *x->entries; }
