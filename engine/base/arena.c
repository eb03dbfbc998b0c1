/* base/arena.c - chunks of scratch memory in a list, filled one after the other. */
#include "base/arena.h"

#include "base/block.h"

static size_t round_up(size_t bytes)
{
    return (bytes + (ARENA_ALIGN - 1)) & ~(size_t)(ARENA_ALIGN - 1);
}

static void poison(void *data, size_t bytes)
{
#ifdef DIG_DEBUG
    memset(data, 0xFF, bytes);
#else
    (void)data;
    (void)bytes;
#endif
}

/* The chunk becomes the current one; NULL: none is. */
static void go_to(Arena *a, ArenaChunk *c)
{
    a->current = c;
    a->next = c ? c->data + c->used : NULL;
    a->end = c ? c->data + c->size / ARENA_ALIGN * ARENA_ALIGN : NULL;
}

/* Notes what is taken now, and returns it. */
static size_t take_stock(Arena *a)
{
    size_t live = arena_live(a);
    if (a->current)
        a->current->used = arena_used(a);
    a->high = live > a->high ? live : a->high;
    return live;
}

static size_t chunk_bytes(size_t size) { return sizeof(ArenaChunk) + size + ARENA_ALIGN; }

static ArenaChunk *chunk_open(Arena *a, size_t size)
{
    ArenaChunk *c = block_open(chunk_bytes(size));
    if (!c)
        return NULL;
    unsigned char *data = (unsigned char *)(c + 1);
    data += (ARENA_ALIGN - (uintptr_t)data % ARENA_ALIGN) % ARENA_ALIGN;
    *c = (ArenaChunk){.data = data, .size = size};
    a->held += size;
    a->allocations++;
    return c;
}

static void chunks_close(Arena *a)
{
    for (ArenaChunk *c = a->first, *next; c; c = next) {
        next = c->next;
        block_free(c, chunk_bytes(c->size));
    }
    a->first = NULL;
    go_to(a, NULL);
    a->taken = a->held = a->written = 0;
}

#define READY ((size_t)64 << 10)        /* bytes */

void arena_ready(Arena *a)
{
    if (a->first || !(a->first = chunk_open(a, ARENA_FIRST)))   /* NULL: the next arena_alloc tries again */
        return;
    memset(a->first->data, 0, READY);
    go_to(a, a->first);
}

#define LATELY 64               /* resets */
#define FEW    16               /* of these; LATELY is a multiple */
/* Bytes up to which an arena doubles and keeps what it has: to save less is worth no call to the allocator. Beyond it grows by a quarter. */
#define SMALL  ((size_t)8 << 20)

#define REST   ((size_t)1 << 20)        /* bytes that are left in a chunk: less is not worth a call to the system */

/* Makes a chunk with room for `size` bytes the current one: the next in the list when it is large enough, else a new one
 * put in front of it. */
static ArenaChunk *next_chunk(Arena *a, size_t size)
{
    ArenaChunk **link = a->current ? &a->current->next : &a->first;
    ArenaChunk *c = *link;
    size_t live = take_stock(a);
    if (!c || c->size < size) {
        ArenaChunk *full = a->current;
        if (full && full->size - full->used >= REST)    /* earlier steps have written to it */
            block_forget(full->data + full->used, full->size - full->used);
        size_t part = a->held <= SMALL ? a->held : a->held / 4, more = part > ARENA_FIRST ? part : ARENA_FIRST;
        c = chunk_open(a, size > more ? size : more);
        if (!c)
            return NULL;
        c->next = *link;
        *link = c;
    }
    c->used = 0;
    a->taken = live;
    go_to(a, c);
    return c;
}

void *arena_grow(Arena *a, size_t bytes)
{
    if (bytes > (size_t)PTRDIFF_MAX / 2)
        return NULL;
    size_t size = bytes ? round_up(bytes) : ARENA_ALIGN;
    if ((size_t)(a->end - a->next) < size && !next_chunk(a, size))
        return NULL;
    void *piece = a->next;
    a->next += size;
    poison(piece, size);
    return piece;
}

void *arena_zero(Arena *a, size_t bytes)
{
    void *piece = arena_alloc(a, bytes);
    if (piece)
        memset(piece, 0, bytes);
    return piece;
}

void arena_shrink(Arena *a, void *last, size_t bytes)
{
    take_stock(a);
    ArenaChunk *c = a->current;
    size_t first = (size_t)((unsigned char *)last - c->data), keep = first + (bytes ? round_up(bytes) : ARENA_ALIGN);
    DIG_ASSERT(first < c->used && keep <= c->used);
    poison(c->data + keep, c->used - keep);
    c->used = keep;
    go_to(a, c);
}

#define SPARE_LEAST 1024        /* bytes: less is not worth a look */

/* Before larger ones: what is small is used up first, so that there is room for what is large. */
static void spare_push(Spare **list, unsigned char *at, size_t bytes)
{
    _Static_assert(sizeof(Spare) <= ARENA_ALIGN, "the head takes one unit");
    if (bytes < SPARE_LEAST)
        return;
    while (*list && (*list)->bytes < bytes)
        list = &(*list)->next;
    Spare *s = (void *)at;
    *s = (Spare){*list, bytes};
    *list = s;
}

static unsigned char *next_unit(void *at) { return (unsigned char *)at + (ARENA_ALIGN - (uintptr_t)at % ARENA_ALIGN) % ARENA_ALIGN; }

void spare_add(Spare **list, void *at, size_t bytes)
{
    unsigned char *first = next_unit(at), *end = next_unit((unsigned char *)at + bytes);
    for (Spare **link = list, *s = *link; s; s = *link) {
        bool before = (unsigned char *)s + s->bytes == first, after = (unsigned char *)s == end;
        if (before)
            first = (unsigned char *)s;
        if (after)
            end += s->bytes;
        if (before || after)
            *link = s->next;
        else
            link = &s->next;
    }
    spare_push(list, first, (size_t)(end - first));
}

void spare_trim(Spare **list, Arena *a, void *last, size_t bytes, size_t keep)
{
    if ((unsigned char *)last + round_up(bytes) == a->next)
        arena_shrink(a, last, keep);
    else
        spare_add(list, (unsigned char *)last + keep, bytes - keep);
}

void spare_lend(Spare **list, void *at, size_t bytes)
{
    unsigned char *first = next_unit(at), *end = (unsigned char *)at + bytes;
    if (first < end)
        spare_push(list, first, (size_t)(end - first) / ARENA_ALIGN * ARENA_ALIGN);
}

/* From its end, so that its head stays where it is; or all of it. */
void *spare_find(Spare **list, size_t bytes)
{
    size_t size = bytes ? round_up(bytes) : ARENA_ALIGN;
    for (Spare **link = list, *s = *link; s; link = &s->next, s = *link) {
        if (bytes > s->bytes || size > s->bytes)        /* the first: size may have overflowed */
            continue;
        s->bytes -= size;
        unsigned char *piece = (unsigned char *)s + s->bytes;
        if (s->bytes == 0)
            *link = s->next;
        poison(piece, size);
        return piece;
    }
    return NULL;
}

void arena_go_back(Arena *a, ArenaMark m)
{
    size_t live = take_stock(a);
    DIG_ASSERT(m.live <= live);
    (void)live;
    ArenaChunk *last = m.chunk ? m.chunk : a->first, *c = last;         /* the first is at hand again where nothing stays */
    size_t keep = m.used;                               /* bytes of c that stay */
    while (c && a->current) {
        poison(c->data + keep, c->used - keep);
        c->used = keep;
        keep = 0;
        if (c == a->current)
            break;
        c = c->next;
    }
    go_to(a, last);
    a->taken = m.live - m.used;
}

#define KEPT BLOCK_LARGE        /* bytes, pages are kept up to a multiple of this */

/* Of one large chunk, what the last few steps have not needed takes no memory until it is needed again. */
static void forget_unused(Arena *a)
{
    ArenaChunk *c = a->first;
    if (!c || c->next || a->held <= SMALL)
        return;
    size_t keep = (a->high + a->high / 32 + KEPT - 1) / KEPT * KEPT, written = a->written < c->size ? a->written : c->size;
    if (written <= keep)
        return;
    block_forget(c->data + keep, written - keep);
    a->written = keep;
}

void arena_reset(Arena *a)
{
    arena_rewind(a, (ArenaMark){.chunk = a->first});
    bool look = ++a->resets >= LATELY;
    if (a->high > a->written)
        a->written = a->high;
    size_t most = a->high > a->before ? a->high : a->before;
    if (a->resets % FEW == 0) {
        forget_unused(a);
        a->before = most;
        a->high = 0;
    }
    if (look) {
        a->resets = 0;
        a->before = 0;
    }
    size_t size = round_up(most + most / 16);           /* not all that is held: chunks end where pieces do not fit */
    if (size > a->held || a->held <= SMALL)
        size = a->held;
    if (!a->first || !(a->first->next || (look && size < a->held / 8 * 7)))
        return;
    chunks_close(a);
    a->first = chunk_open(a, size);     /* NULL: the next arena_alloc tries again */
    go_to(a, a->first);
}

void arena_close(Arena *a)
{
    chunks_close(a);
    *a = (Arena){0};
}

size_t arena_bytes(const Arena *a)
{
    return a->held;
}
