/* world/column.h - what an effect keeps of each body that takes part in it: one struct a body, dense, in the order of their slots.
 *
 * The structs hold nothing but reals, so that one piece of code copies, saves and hashes them all. An effect that no body takes
 * part in has an empty column: no bytes.
 *
 * Owns:  its three arrays; column_close frees them. Grows in column_add only.
 * Floor: world, but needs base only.
 */
#ifndef DIG_COLUMN_H
#define DIG_COLUMN_H

#include "base/hash.h"

typedef struct Column {
    size_t    size;             /* bytes of a member; a multiple of sizeof(real)           */
    real     *data;             /* [count * size / sizeof(real)]                           */
    uint32_t *body;             /* [count] their slots, ascending                          */
    uint32_t *row;              /* [rows] of a body slot: place in the above + 1; 0 = takes no part */
    int       count, capacity, rows;
    int       bodies;           /* room in body: as capacity, but where memory ran out     */
} Column;

static inline void *column_at(const Column *c, int i) { return (char *)c->data + (size_t)i * c->size; }
/* NULL: takes no part. Valid until the next change of the column. */
static inline void *column_find(const Column *c, uint32_t body)
{
    return body < (uint32_t)c->rows && c->row[body] ? column_at(c, (int)c->row[body] - 1) : NULL;
}
dig_status column_add(Column *c, uint32_t body, const void *member, uint64_t *allocations);     /* or replaces; DIG_E_MEMORY: nothing changed */
void       column_remove(Column *c, uint32_t body);
dig_status column_copy(Column *to, const Column *from, uint64_t *allocations);
void       column_close(Column *c);
size_t     column_bytes(const Column *c);
uint64_t   column_hash(const Column *c, uint64_t h);

#endif
