/* base/map.c - hash map with open addressing, linear probing and removal by shifting back. */
#include "base/map.h"

#include "base/block.h"

#define MAP_LARGEST (1u << 30)  /* entries of the table */

/* Two rounds of the 64-bit finaliser of splitmix (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
 * OOPSLA 2014; constants "mix13" of D. Stafford). Never 0. */
uint32_t map_hash(MapKey k)
{
    uint64_t x = ((uint64_t)k.a << 32 | k.b) + 0x9E3779B97F4A7C15u;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    x = (x ^ x >> 31) + k.c;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    uint32_t h = (uint32_t)(x >> 32);
    return h ? h : 1;
}

static bool same_key(MapKey x, MapKey y)
{
    return x.a == y.a && x.b == y.b && x.c == y.c;
}

/* Index of the key's entry, or of the free one where it belongs. The table is never full. */
static uint32_t find_place(const Map *m, MapKey k, uint32_t hash)
{
    uint32_t mask = m->size - 1, i = hash & mask;
    while (m->entries[i].hash && !(m->entries[i].hash == hash && same_key(m->entries[i].key, k)))
        i = (i + 1) & mask;
    return i;
}

static bool holds(uint32_t size, uint64_t entries)
{
    return entries * 3 <= (uint64_t)size * 2;
}

dig_status map_reserve(Map *m, int entries)
{
    if (entries < 0 || !holds(MAP_LARGEST, (uint64_t)entries))
        return DIG_E_ARG;
    uint32_t size = m->size ? m->size : 16;
    while (!holds(size, (uint64_t)entries))
        size *= 2;
    if (size == m->size)
        return DIG_OK;
    MapEntry *table = block_resize(NULL, 0, size * sizeof *table);
    if (!table)
        return DIG_E_MEMORY;
    Map grown = {table, size, m->count, m->allocations + 1};
    for (uint32_t i = 0; i < m->size; i++)
        if (m->entries[i].hash)
            table[find_place(&grown, m->entries[i].key, m->entries[i].hash)] = m->entries[i];
    block_free(m->entries, m->size * sizeof *m->entries);
    *m = grown;
    return DIG_OK;
}

bool map_find(const Map *m, MapKey k, uint32_t *value)
{
    if (!m->count)
        return false;
    const MapEntry *e = &m->entries[find_place(m, k, map_hash(k))];
    if (e->hash && value)
        *value = e->value;
    return e->hash != 0;
}

dig_status map_put(Map *m, MapKey k, uint32_t value)
{
    uint32_t hash = map_hash(k);
    uint32_t i = m->size ? find_place(m, k, hash) : 0;
    if (m->size && m->entries[i].hash) {
        m->entries[i].value = value;
        return DIG_OK;
    }
    if (!m->size || !holds(m->size, (uint64_t)m->count + 1)) {
        DIG_TRY(map_reserve(m, (int)(m->count + 1)));
        i = find_place(m, k, hash);
    }
    m->entries[i] = (MapEntry){k, value, hash};
    m->count++;
    return DIG_OK;
}

bool map_remove(Map *m, MapKey k)
{
    if (!m->count)
        return false;
    uint32_t mask = m->size - 1, hole = find_place(m, k, map_hash(k));
    if (!m->entries[hole].hash)
        return false;
    /* An entry may fill the hole unless its home lies cyclically behind the hole. */
    for (uint32_t i = (hole + 1) & mask; m->entries[i].hash; i = (i + 1) & mask) {
        uint32_t home = m->entries[i].hash & mask;
        if (((i - home) & mask) >= ((i - hole) & mask)) {
            m->entries[hole] = m->entries[i];
            hole = i;
        }
    }
    m->entries[hole] = (MapEntry){0};
    m->count--;
    return true;
}

dig_status map_copy(Map *to, const Map *from)
{
    if (to == from)
        return DIG_OK;
    if (to->size != from->size) {
        MapEntry *table = NULL;
        if (from->size) {
            table = block_open(from->size * sizeof *table);
            if (!table)
                return DIG_E_MEMORY;
            to->allocations++;
        }
        block_free(to->entries, to->size * sizeof *to->entries);
        to->entries = table;
        to->size = from->size;
    }
    if (from->size)
        memcpy(to->entries, from->entries, from->size * sizeof *to->entries);
    to->count = from->count;
    return DIG_OK;
}

void map_close(Map *m)
{
    block_free(m->entries, m->size * sizeof *m->entries);
    *m = (Map){0};
}

size_t map_bytes(const Map *m)
{
    return m->size * sizeof *m->entries;
}
