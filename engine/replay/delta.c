/* replay/delta.c - tables of rows, and what changed in them from one frame to the next.
 *
 * A table that did not change is one byte, 0. Else: 1, u32 rows, a bit for each row that changed, lowest first, and the changed
 * rows one after the other: a bit for each word of four bytes that changed, and these words XORed with what they were (new rows:
 * with zero). What moves is noise but for its leading digits, which this leaves out for a tenth of the time that deflate takes.
 */
#include "replay/format.h"

#include <stdlib.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "rows are kept as they are in memory, which has to be little-endian"
#endif

_Static_assert(sizeof(KeptFlow) == 64 && sizeof(KeptEvent) == 144 && sizeof(KeptState) == 96 && sizeof(KeptCamera) == 152, "a row has padding");

size_t kept_row_size(int table)
{
    static const size_t sizes[] = {sizeof(KeptFlow), sizeof(KeptEvent), sizeof(KeptState), sizeof(KeptCamera)};
    return table < LOOK_TABLES ? look_row_size[table] : sizes[table - LOOK_TABLES];
}

dig_status kept_resize(Kept *k, int table, int count)
{
    ListAny *list = kept_table(k, table);
    size_t row = kept_row_size(table);
    DIG_TRY(list_reserve_any(&list->data, &list->capacity, row, count, NULL));
    if (count > list->count)
        memset((char *)list->data + (size_t)list->count * row, 0, (size_t)(count - list->count) * row);
    list->count = count;
    return DIG_OK;
}

dig_status kept_copy(Kept *to, const Kept *from)
{
    DIG_TRY(look_copy_tables(&to->look, &from->look));
    for (int t = LOOK_TABLES; t < KEPT_TABLES; t++) {
        const ListAny *list = &from->extra[t - LOOK_TABLES];
        DIG_TRY(kept_resize(to, t, list->count));
        if (list->count > 0)
            memcpy(kept_table(to, t)->data, list->data, (size_t)list->count * kept_row_size(t));
    }
    return DIG_OK;
}

void kept_clear(Kept *k)
{
    for (int t = 0; t < KEPT_TABLES; t++)
        kept_table(k, t)->count = 0;
}

void kept_close(Kept *k)
{
    look_close(&k->look);
    for (int t = LOOK_TABLES; t < KEPT_TABLES; t++)
        list_free_any(&kept_table(k, t)->data, &kept_table(k, t)->count, &kept_table(k, t)->capacity, kept_row_size(t));
    *k = (Kept){0};
}

/* ---- writing ---- */

static size_t mark_bytes(size_t row) { return (row / 4 + 7) / 8; }

/* What changed in a row that is `words` long: the marks of its words, and those XORed with what they were. Returns the bytes. */
static size_t write_row(unsigned char *out, const unsigned char *now, const unsigned char *last, size_t words)
{
    size_t marks = (words + 7) / 8, n = 0;
    uint64_t marked = 0;
    for (size_t k = 0; k < words; k++) {
        uint32_t x, y;
        memcpy(&x, now + 4 * k, 4);
        memcpy(&y, last + 4 * k, 4);
        x ^= y;
        memcpy(out + marks + 4 * n, &x, 4);         /* taken back when it is zero */
        marked |= (uint64_t)(x != 0) << k;
        n += x != 0;
    }
    memcpy(out, &marked, marks);
    return marks + 4 * n;
}

static void write_rows(Pack *p, int count, const unsigned char *now, ListAny *last, int old, size_t row)
{
    size_t bit_bytes = ((size_t)count + 7) / 8, most = bit_bytes + (size_t)count * (row + mark_bytes(row));
    unsigned char *bits = pack_space(p, most), *was = last->data;
    if (!bits)
        return;
    memset(bits, 0, bit_bytes);
    unsigned char *out = bits + bit_bytes;
    for (int i = 0; i < count; i++, now += row, was += row) {
        if (i < old && memcmp(now, was, row) == 0)
            continue;
        bits[i / 8] |= (unsigned char)(1u << i % 8);
        out += write_row(out, now, was, row / 4);
        memcpy(was, now, row);
    }
    p->size -= most - (size_t)(out - bits);
}

void delta_write(Pack *p, int t, int count, const unsigned char *now, Kept *last)
{
    ListAny *list = kept_table(last, t);
    int old = list->count;
    size_t row = kept_row_size(t), size = (size_t)count * row;
    uint8_t differs = count != old || (size > 0 && memcmp(now, list->data, size) != 0);
    pack_u8(p, &differs);
    if (!differs)
        return;
    pack_u32(p, &(uint32_t){(uint32_t)count});
    if (kept_resize(last, t, count) != DIG_OK)
        pack_fail_memory(p);
    else if (count > 0)
        write_rows(p, count, now, list, old, row);
}

/* ---- reading ---- */

static void read_row(Pack *p, unsigned char *to, size_t words)
{
    uint64_t marked = 0;
    size_t n = 0;
    const unsigned char *from = pack_take(p, (words + 7) / 8);
    if (from)
        memcpy(&marked, from, (words + 7) / 8);
    if (!pack_check(p, marked >> (words - 1) <= 1, "a row has more words than it is long"))
        return;
    for (uint64_t left = marked; left != 0; left &= left - 1)
        n++;
    from = pack_take(p, 4 * n);
    for (; from && marked != 0; marked >>= 1, to += 4) {
        uint32_t x, y;
        if (!(marked & 1))
            continue;
        memcpy(&x, from, 4);
        memcpy(&y, to, 4);
        x ^= y;
        memcpy(to, &x, 4);
        from += 4;
    }
}

/* Every new row is among the changed ones and has its marks: a table grows by no more than its bytes hold. */
static void read_table(Pack *p, Kept *k, int t)
{
    uint8_t differs = 0;
    uint32_t count = 0;
    size_t row = kept_row_size(t);
    pack_small(p, &differs, 2, "mark of a table");
    if (!differs)
        return;
    pack_u32(p, &count);
    int old = kept_table(k, t)->count;
    if (!pack_check(p, count <= INT32_MAX / 2 && (count <= (uint32_t)old || (count - (uint32_t)old) <= (p->size - p->at) / mark_bytes(row)),
                    "a table has more rows than there are bytes"))
        return;
    const unsigned char *bits = pack_take(p, ((size_t)count + 7) / 8);
    if (!bits)
        return;
    for (int i = old; i < (int)count; i++)
        if (!pack_check(p, bits[i / 8] >> i % 8 & 1, "a new row is missing"))
            return;
    if (kept_resize(k, t, (int)count) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    unsigned char *to = kept_table(k, t)->data;
    for (int i = 0; i < (int)count && pack_good(p); i++)
        if (bits[i / 8] >> i % 8 & 1)
            read_row(p, to + (size_t)i * row, row / 4);
}

void delta_read(Pack *p, Kept *k)
{
    for (int t = 0; t < KEPT_TABLES; t++)
        read_table(p, k, t);
}
