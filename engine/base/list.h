/* base/list.h - typed growable arrays: LIST(Body) bodies;
 *
 * Owns:      `data`, a block (base/block.h); list_close frees it.
 * Invariant: count <= capacity. New items are zeroed. Data moves when the list
 *            grows, so hold indices, not pointers, across list_push.
 * Floor:     base.
 */
#ifndef DIG_LIST_H
#define DIG_LIST_H

#include "base/base.h"

#define LIST(type)              \
    struct {                    \
        type *data;             \
        int   count, capacity;  \
    }

/* The common shape of every LIST. */
typedef struct ListAny { void *data; int count, capacity; } ListAny;

/* Makes room for `want` items in all; *allocations counts the calls to the allocator. */
dig_status list_reserve_any(void **data, int *capacity, size_t item, int want, uint64_t *allocations);
dig_status list_copy_any(void **to, int *to_count, int *to_capacity, const void *from, int count, size_t item, uint64_t *allocations);

static inline dig_status list_room(void **data, int *capacity, size_t item, int want, uint64_t *allocations)
{
    return want <= *capacity ? DIG_OK : list_reserve_any(data, capacity, item, want, allocations);
}

#define list_reserve(list, want, allocations) \
    list_room((void **)&(list)->data, &(list)->capacity, sizeof *(list)->data, (want), (allocations))

/* Adds one zeroed item at the end; its index is (list)->count - 1 afterwards. */
#define list_push(list, allocations) \
    list_push_any((void **)&(list)->data, &(list)->count, &(list)->capacity, sizeof *(list)->data, (allocations))

dig_status list_push_any(void **data, int *count, int *capacity, size_t item, uint64_t *allocations);

#define list_copy(to, from, allocations) \
    list_copy_any((void **)&(to)->data, &(to)->count, &(to)->capacity, (from)->data, (from)->count, sizeof *(from)->data, (allocations))

/* Gives back room beyond `keep` items, but none that is used; where that fails, nothing changes. */
void list_trim_any(void **data, int count, int *capacity, size_t item, int keep);
#define list_trim(list, keep) list_trim_any((void **)&(list)->data, (list)->count, &(list)->capacity, sizeof *(list)->data, (keep))

void list_free_any(void **data, int *count, int *capacity, size_t item);
#define list_close(list) list_free_any((void **)&(list)->data, &(list)->count, &(list)->capacity, sizeof *(list)->data)

#define list_bytes(list) ((size_t)(list)->capacity * sizeof *(list)->data)

#endif
