/* base/list.c - growth of typed arrays. */
#include "base/list.h"

#include "base/block.h"


dig_status list_reserve_any(void **data, int *capacity, size_t item, int want, uint64_t *allocations)
{
    if (want <= *capacity)
        return DIG_OK;
    /* Small lists grow by a half; what grows without being copied, by an eighth. */
    int grown = *capacity < 16 ? 16 : *capacity + *capacity / ((size_t)*capacity * item < BLOCK_LARGE ? 2 : 8);
    if (grown < want)
        grown = want;
    void *moved = block_resize(*data, (size_t)*capacity * item, (size_t)grown * item);
    if (!moved)
        return DIG_E_MEMORY;
    *data = moved;
    *capacity = grown;
    if (allocations)
        ++*allocations;
    return DIG_OK;
}

dig_status list_push_any(void **data, int *count, int *capacity, size_t item, uint64_t *allocations)
{
    DIG_TRY(list_reserve_any(data, capacity, item, *count + 1, allocations));
    memset((char *)*data + (size_t)*count * item, 0, item);
    ++*count;
    return DIG_OK;
}

dig_status list_copy_any(void **to, int *to_count, int *to_capacity, const void *from, int count, size_t item, uint64_t *allocations)
{
    DIG_TRY(list_reserve_any(to, to_capacity, item, count, allocations));
    if (count > 0)
        memcpy(*to, from, (size_t)count * item);
    *to_count = count;
    return DIG_OK;
}

void list_trim_any(void **data, int count, int *capacity, size_t item, int keep)
{
    keep = keep < count ? count : keep;
    void *moved = keep > 0 && keep < *capacity ? block_resize(*data, (size_t)*capacity * item, (size_t)keep * item) : NULL;
    if (!moved)
        return;
    *data = moved;
    *capacity = keep;
}

void list_free_any(void **data, int *count, int *capacity, size_t item)
{
    block_free(*data, (size_t)*capacity * item);
    *data = NULL;
    *count = *capacity = 0;
}
