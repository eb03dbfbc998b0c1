/* resident.h - which pages take memory of their own. Define _DEFAULT_SOURCE before the first header. */
#ifndef DIG_RESIDENT_H
#define DIG_RESIDENT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

/* Of the pages that lie wholly within, those that are there and nobody else's: what was only read is the system's page of zeros. 0 where
 * blocks are the checker's (base/block.c), < 0 where the system does not tell (Linux: Documentation/admin-guide/mm/pagemap.rst). */
static inline int resident_pages(const void *part, size_t bytes)
{
    int count = 0;
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), first = ((uintptr_t)part + page - 1) / page, end = ((uintptr_t)part + bytes) / page;
    FILE *map = fopen("/proc/self/pagemap", "rb");
    if (!map || fseek(map, (long)(first * sizeof(uint64_t)), SEEK_SET) != 0)
        count = -1;
    for (uintptr_t i = first; i < end && count >= 0; i++) {
        uint64_t entry;
        bool told = fread(&entry, sizeof entry, 1, map) == 1;
        count = told ? count + (int)(entry >> 63 & entry >> 56 & 1) : -1;
    }
    if (map)
        fclose(map);
#else
    (void)part;
    (void)bytes;
#endif
    return count;
}

#endif
