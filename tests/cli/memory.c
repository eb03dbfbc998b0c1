/* tests/cli/memory.c - put before the C library by memory.sh (LD_PRELOAD): the Nth allocation that the program itself asks for fails.
 *
 * DIGBOX_FAIL=N-once or N-on (it and all after it), N from 1. Only calls from the program's own code count: what libraries of the
 * system do without memory is not ours to judge. DIGBOX_COUNT=FILE of 8 bytes: how many there were in all processes together.
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *block, size_t size);

static uintptr_t begin, end;            /* of the program's code */
static long at, count, *counted;
static int goes_on;

__attribute__((constructor)) static void prepare(void)
{
    const ElfW(Phdr) *segment = (const ElfW(Phdr) *)getauxval(AT_PHDR);
    uintptr_t base = 0;
    for (unsigned long i = 0; i < getauxval(AT_PHNUM); i++)
        if (segment[i].p_type == PT_PHDR)
            base = (uintptr_t)segment - segment[i].p_vaddr;
    for (unsigned long i = 0; i < getauxval(AT_PHNUM); i++)
        if (segment[i].p_type == PT_LOAD && (segment[i].p_flags & PF_X)) {
            begin = base + segment[i].p_vaddr;
            end = begin + segment[i].p_memsz;
        }
    const char *wish = getenv("DIGBOX_FAIL");
    at = wish ? atol(wish) : 0;
    goes_on = wish && strstr(wish, "-on");
    const char *path = getenv("DIGBOX_COUNT");
    int f = path ? open(path, O_RDWR) : -1;
    void *shared = f >= 0 ? mmap(NULL, sizeof *counted, PROT_READ | PROT_WRITE, MAP_SHARED, f, 0) : MAP_FAILED;
    counted = shared != MAP_FAILED ? shared : NULL;
    if (f >= 0)
        close(f);
}

static int fails(const void *from)
{
    if ((uintptr_t)from < begin || (uintptr_t)from >= end)
        return 0;
    count++;
    if (counted)
        ++*counted;
    if (at == 0 || (count != at && !(goes_on && count > at)))
        return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size); }
void *realloc(void *block, size_t size) { return size > 0 && fails(__builtin_return_address(0)) ? NULL : __libc_realloc(block, size); }
