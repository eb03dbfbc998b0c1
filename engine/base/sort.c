/* base/sort.c - insertion for a few numbers, a radix sort by bytes (lowest first) for many. */
#include "base/sort.h"

#define FEW 48                  /* numbers: below, insertion wins */

static bool ascending(const uint32_t *a, int count)
{
    for (int i = 1; i < count; i++)
        if (a[i - 1] > a[i])
            return false;
    return true;
}

static void insert(uint32_t *a, int count)
{
    for (int i = 1; i < count; i++) {
        uint32_t x = a[i];
        int k = i;
        for (; k > 0 && a[k - 1] > x; k--)
            a[k] = a[k - 1];
        a[k] = x;
    }
}

/* One pass: stable by the byte at `shift`. */
static void pass(uint32_t *to, const uint32_t *from, int count, int shift)
{
    int place[256] = {0};
    for (int i = 0; i < count; i++)
        place[from[i] >> shift & 0xFF]++;
    for (int i = 0, sum = 0; i < 256; i++) {
        int here = place[i];
        place[i] = sum;
        sum += here;
    }
    for (int i = 0; i < count; i++)
        to[place[from[i] >> shift & 0xFF]++] = from[i];
}

dig_status sort_u32(uint32_t *a, int count, Arena *scratch)
{
    if (ascending(a, count))
        return DIG_OK;
    if (count < FEW) {
        insert(a, count);
        return DIG_OK;
    }
    ArenaMark mark = arena_mark(scratch);
    uint32_t *from = a, *to = arena_alloc(scratch, (size_t)count * sizeof *to), differ = 0;
    if (!to)
        return DIG_E_MEMORY;
    for (int i = 1; i < count; i++)
        differ |= a[i] ^ a[0];
    for (int shift = 0; shift < 32; shift += 8) {
        if (!(differ >> shift & 0xFF))
            continue;                       /* all have the same byte here */
        pass(to, from, count, shift);
        uint32_t *t = from;
        from = to;
        to = t;
    }
    if (from != a)
        memcpy(a, from, (size_t)count * sizeof *a);
    arena_rewind(scratch, mark);
    return DIG_OK;
}
