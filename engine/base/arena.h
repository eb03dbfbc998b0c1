/* base/arena.h - scratch memory that is taken piece by piece and given back all at once.
 *
 * A step takes what it needs with arena_alloc and gives everything back with arena_reset; an inner piece of work that needs
 * scratch brackets it with arena_mark and arena_rewind. When a step needed more than one chunk, arena_reset replaces the chunks
 * by one that would have been enough, so that the steady state never calls the allocator; and by a smaller one when it is
 * larger than eight megabytes and nothing has needed an eighth of it for many steps. Of one so large, pages that some steps have not
 * needed are given back, as is what a full chunk has left.
 *
 * Owns:      its chunks. A zeroed Arena is empty and valid; arena_close makes it so again.
 * Invariant: every piece is aligned to ARENA_ALIGN bytes; contents are undefined until written. With DIG_DEBUG, fresh and
 *            given-back memory is filled with 0xFF, which reads as NaN, as -1 and as an index out of range.
 * Floor:     base.
 */
#ifndef DIG_ARENA_H
#define DIG_ARENA_H

#include "base/base.h"

#define ARENA_ALIGN 64u                 /* bytes: a cache line, the longest register */
#define ARENA_FIRST (256u << 10)        /* bytes: the smallest chunk; only what is written to takes memory, and most worlds need no more */

typedef struct ArenaChunk ArenaChunk;

struct ArenaChunk {
    ArenaChunk    *next;
    unsigned char *data;        /* first aligned byte                  */
    size_t         size, used;  /* bytes; used: once it is no longer the current one */
};

typedef struct Arena {
    unsigned char *next, *end;          /* where the next piece begins, and up to where there is room: in the current chunk, whole units */
    ArenaChunk *first, *current;        /* current NULL: nothing taken yet; chunks after it are kept for reuse */
    size_t   taken;                     /* bytes, in chunks before the current one */
    size_t   high, before;              /* bytes, most taken at the same time of late, seen where pieces are given back, and before that */
    size_t   written;                   /* bytes of the first chunk that may take memory */
    int      resets;                    /* since these were last looked at         */
    size_t   held;                      /* bytes of all chunks                     */
    uint64_t allocations;               /* calls to malloc so far                  */
} Arena;

typedef struct ArenaMark {
    ArenaChunk *chunk;
    size_t      used, live;             /* bytes */
} ArenaMark;

void     *arena_grow(Arena *a, size_t bytes);           /* arena_alloc where there is no room; or to be poisoned */

/* bytes = 0 gives a valid piece too. NULL: out of memory; the arena is unchanged and usable. Inline: a step of a small world takes
 * thirty pieces, which were a tenth of it. */
static inline void *arena_alloc(Arena *a, size_t bytes)
{
#ifndef DIG_DEBUG
    size_t want = bytes ? bytes : 1;
    unsigned char *piece = a->next;
    if (want <= (size_t)(a->end - piece)) {
        a->next = piece + ((want + (ARENA_ALIGN - 1)) & ~(size_t)(ARENA_ALIGN - 1));
        return piece;
    }
#endif
    return arena_grow(a, bytes);
}

void     *arena_zero(Arena *a, size_t bytes);           /* the same, filled with 0 */

/* The last piece taken keeps its first `bytes` only; what was taken before it is another matter, and stays as it is. */
void      arena_shrink(Arena *a, void *last, size_t bytes);
/* Where the next piece begins if it has room there; NULL: not known. */
static inline void *arena_next(const Arena *a) { return a->next; }

/* Scratch memory that was taken and is no longer needed, while what was taken after it still is: a list that lies in that memory itself.
 * Its user forgets it where the arena is rewound before any of it. */
typedef struct Spare Spare;
struct Spare { Spare *next; size_t bytes; };            /* bytes from here on, a multiple of ARENA_ALIGN */

void      spare_add(Spare **list, void *at, size_t bytes);         /* of an arena's piece: one is there that ends with it, or all that comes after is spare */
void      spare_trim(Spare **list, Arena *a, void *last, size_t bytes, size_t keep);     /* of what was taken last, so many bytes, the rest is free */
void      spare_lend(Spare **list, void *at, size_t bytes);        /* of other memory, for as long as that is nobody's; not into a list with an arena's */
void     *spare_find(Spare **list, size_t bytes);                  /* NULL: none has room */
/* From the list where it has room, else arena_alloc. */
static inline void *spare_take(Spare **list, Arena *a, size_t bytes)
{
    void *piece = *list ? spare_find(list, bytes) : NULL;
    return piece ? piece : arena_alloc(a, bytes);
}

void      arena_ready(Arena *a);                        /* takes memory for what a small step needs: the first one need not wait for its pages */
/* Bytes that the current chunk has given. */
static inline size_t arena_used(const Arena *a) { return a->current ? (size_t)(a->next - a->current->data) : 0; }
static inline size_t arena_live(const Arena *a) { return a->taken + arena_used(a); }           /* taken now */

static inline ArenaMark arena_mark(const Arena *a)
{
    size_t used = arena_used(a);
    return (ArenaMark){a->current, used, a->taken + used};
}

void      arena_go_back(Arena *a, ArenaMark m);         /* arena_rewind past the beginning of a chunk; or to be poisoned */

/* Gives back all taken since the mark; marks nest. Inline: a step of a small world does so five times, mostly within a chunk. */
static inline void arena_rewind(Arena *a, ArenaMark m)
{
#ifndef DIG_DEBUG
    if (m.chunk && m.chunk == a->current) {
        size_t live = arena_live(a);
        a->high = live > a->high ? live : a->high;
        a->next = m.chunk->data + m.used;
        return;
    }
#endif
    arena_go_back(a, m);
}

void      arena_reset(Arena *a);                        /* gives back everything; invalidates marks */
void      arena_close(Arena *a);
size_t    arena_bytes(const Arena *a);                  /* held */

#endif
