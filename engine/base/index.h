/* base/index.h - finds records by a hash of their key, where the records hold the key themselves: a map of a third of the size.
 *
 * Open addressing with linear probing; index_remove shifts the entries that follow back. What it holds depends only on the sequence of
 * calls, never on addresses.
 *
 * Owns:      its table. A zeroed Index is empty and valid; index_close makes it so again.
 * Invariant: at most two thirds of the table are used. No allocation while count stays within what index_reserve was given.
 * Floor:     base.
 */
#ifndef DIG_INDEX_H
#define DIG_INDEX_H

#include "base/arena.h"
#include "base/map.h"

typedef struct IndexEntry { uint32_t hash, record; } IndexEntry;        /* hash 0 = free */

typedef struct Index {
    IndexEntry *entries;        /* [size], or NULL */
    uint32_t  size;
    uint32_t  count;            /* used entries */
} Index;

/* Is this the record with that key? */
typedef bool IndexSame(const void *context, uint32_t record, MapKey key);

dig_status index_reserve(Index *x, int entries);                    /* DIG_E_MEMORY, DIG_E_ARG: unchanged */
bool       index_find(const Index *x, MapKey key, IndexSame *same, const void *context, uint32_t *record);
dig_status index_add(Index *x, MapKey key, uint32_t record);        /* whose key is not there yet; DIG_E_MEMORY: unchanged */
void       index_remove(Index *x, MapKey key, uint32_t record);     /* which may be in it or not */
/* Record r is to[r] from now on; gives back room if there is much, by way of scratch memory. */
void       index_renumber(Index *x, const uint32_t *to, Arena *scratch);
dig_status index_copy(Index *to, const Index *from);                /* same table, entry by entry; DIG_E_MEMORY: unchanged */
void       index_close(Index *x);
size_t     index_bytes(const Index *x);

#endif
