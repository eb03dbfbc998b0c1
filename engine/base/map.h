/* base/map.h - hash map from three numbers to one, with open addressing.
 *
 * Linear probing; map_remove shifts the entries that follow back, so there are no tombstones and a map that is used for hours
 * is as fast as a new one. What it holds depends only on the sequence of calls, never on addresses.
 *
 * Owns:      its table. A zeroed Map is empty and valid; map_close makes it so again.
 * Invariant: at most two thirds of the table are used. No allocation while count stays within what map_reserve was given.
 * Floor:     base.
 */
#ifndef DIG_MAP_H
#define DIG_MAP_H

#include "base/base.h"

typedef struct MapKey { uint32_t a, b, c; } MapKey;

typedef struct MapEntry {
    MapKey   key;
    uint32_t value;
    uint32_t hash;              /* 0 = free */
} MapEntry;

typedef struct Map {
    MapEntry *entries;          /* [size], size a power of two or 0 */
    uint32_t  size;
    uint32_t  count;            /* used entries */
    uint64_t  allocations;      /* calls to malloc so far */
} Map;

dig_status map_reserve(Map *m, int entries);                        /* DIG_E_MEMORY, DIG_E_ARG: unchanged */
bool       map_find(const Map *m, MapKey k, uint32_t *value);       /* value may be NULL; untouched when not found */
dig_status map_put(Map *m, MapKey k, uint32_t value);               /* adds or replaces; DIG_E_MEMORY: unchanged */
bool       map_remove(Map *m, MapKey k);                            /* was it there? */
dig_status map_copy(Map *to, const Map *from);                      /* same table, entry by entry; DIG_E_MEMORY: unchanged */
void       map_close(Map *m);
size_t     map_bytes(const Map *m);

uint32_t   map_hash(MapKey k);                                      /* never 0 */

/* A key of 64 bits. */
static inline MapKey map_key(uint64_t k) { return (MapKey){(uint32_t)(k >> 32), (uint32_t)k, 0}; }

#endif
