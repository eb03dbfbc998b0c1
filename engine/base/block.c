/* base/block.c - blocks from malloc or from the system's pages. */
#define _GNU_SOURCE             /* mremap */
#include "base/block.h"

#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

/* Where every access is checked, the checker's malloc knows more about a block than its pages. A header before what it hands out
 * keeps the two kinds apart there, too: pages that are given to free(), or a small block that is closed as pages, are then reported. */
#if defined(__SANITIZE_ADDRESS__)
#define CHECKED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CHECKED
#endif
#endif

#if defined(MREMAP_MAYMOVE) && !defined(CHECKED)
static bool from_pages(size_t bytes) { return bytes >= BLOCK_LARGE; }

#define WIDE_PAGE ((size_t)2 << 20)     /* bytes of the larger pages that most systems have */

/* Steps go through tables of many megabytes: in small pages every few bodies cost a look into the tables of pages, too. Only a wish:
 * where a block's wide pages cannot lie, small ones do. Not aligned for it: the whole tail of each block would then take memory. */
static void widen(void *data, size_t bytes)
{
#ifdef MADV_HUGEPAGE
    if (bytes >= WIDE_PAGE)
        (void)madvise(data, bytes, MADV_HUGEPAGE);
#else
    (void)data;
    (void)bytes;
#endif
}

static void *pages_open(size_t bytes)
{
    void *data = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED)
        return NULL;
    widen(data, bytes);
    return data;
}

static void *pages_resize(void *data, size_t old, size_t bytes)
{
    char *moved = mremap(data, old, bytes, MREMAP_MAYMOVE);
    if (moved == MAP_FAILED)
        return NULL;
    widen(moved, bytes);
    size_t page = (size_t)sysconf(_SC_PAGESIZE), end = (old + page - 1) / page * page;
    if (bytes > old)            /* what was given back within a page is still there */
        memset(moved + old, 0, (bytes < end ? bytes : end) - old);
    return moved;
}

static void pages_close(void *data, size_t bytes) { munmap(data, bytes); }

void block_forget(void *part, size_t bytes)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), first = ((uintptr_t)part + page - 1) / page * page, end = ((uintptr_t)part + bytes) / page * page;
    if (first < end)
        (void)madvise((void *)first, end - first, MADV_DONTNEED);
}
#elif defined(CHECKED)
#define HEADER 16               /* bytes: what malloc's blocks are aligned to */

static bool from_pages(size_t bytes) { return bytes >= BLOCK_LARGE; }

static void *pages_open(size_t bytes)
{
    char *base = bytes <= SIZE_MAX - HEADER ? calloc(1, bytes + HEADER) : NULL;
    return base ? base + HEADER : NULL;
}

static void *pages_resize(void *data, size_t old, size_t bytes)
{
    char *base = bytes <= SIZE_MAX - HEADER ? realloc((char *)data - HEADER, bytes + HEADER) : NULL;
    if (!base)
        return NULL;
    if (bytes > old)
        memset(base + HEADER + old, 0, bytes - old);
    return base + HEADER;
}

static void pages_close(void *data, size_t bytes)
{
    (void)bytes;
    free((char *)data - HEADER);
}

void block_forget(void *part, size_t bytes) { (void)part; (void)bytes; }
#else
static bool from_pages(size_t bytes) { (void)bytes; return false; }
static void *pages_open(size_t bytes) { (void)bytes; return NULL; }
static void *pages_resize(void *data, size_t old, size_t bytes) { (void)data; (void)old; (void)bytes; return NULL; }
static void pages_close(void *data, size_t bytes) { (void)data; (void)bytes; }
void block_forget(void *part, size_t bytes) { (void)part; (void)bytes; }
#endif

/* What is new from malloc is cleared by calloc, which leaves pages alone that the system hands out as zeros. */
static void *small_resize(void *data, size_t old, size_t bytes)
{
    if (old == 0)
        return calloc(1, bytes);
    char *moved = realloc(data, bytes);
    if (moved && bytes > old)
        memset(moved + old, 0, bytes - old);
    return moved;
}

void *block_open(size_t bytes) { return from_pages(bytes) ? pages_open(bytes) : malloc(bytes); }

#define ZEROS 1024              /* bytes */

/* To fresh pages, which are 0: what is 0 is not written there, so that it takes no memory. */
static void copy_written(char *to, const char *from, size_t bytes)
{
    static const char zeros[ZEROS];
    for (size_t i = 0, part; i < bytes; i += part) {
        part = bytes - i < ZEROS ? bytes - i : ZEROS;
        if (memcmp(from + i, zeros, part) != 0)
            memcpy(to + i, from + i, part);
    }
}

void *block_resize(void *data, size_t old, size_t bytes)
{
    if (bytes == 0) {
        block_free(data, old);
        return NULL;
    }
    if (from_pages(old) && from_pages(bytes))
        return pages_resize(data, old, bytes);
    if (!from_pages(old) && !from_pages(bytes))
        return small_resize(data, old, bytes);
    void *moved = block_open(bytes);
    if (!moved)
        return NULL;
    if (from_pages(bytes))
        copy_written(moved, data, old);
    else if (old > 0)
        memcpy(moved, data, bytes);
    block_free(data, old);
    return moved;
}

void block_clear(void *record, size_t bytes) { memset(record, 0, bytes); }

void block_free(void *data, size_t bytes)
{
    if (data && from_pages(bytes))
        pages_close(data, bytes);
    else
        free(data);
}
