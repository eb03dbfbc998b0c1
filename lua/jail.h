/* lua/jail.h - the walls around the process that runs a script: landlock for files, seccomp for system calls (docs/security.md, D12).
 *
 * They hold whatever the process does, a fault in Lua or in the renderer included. Where the kernel has them not, the run goes on
 * with the walls that are left, unless they were asked for.
 */
#ifndef DIGBOX_JAIL_H
#define DIGBOX_JAIL_H

#include <stdbool.h>
#include <stddef.h>

typedef struct Jail {
    const char *script;         /* its folder may be read                                             */
    const char *out;            /* folder that may be written, made if it is not there; NULL = none   */
    const char *const *also;    /* [also_count] files that may be written; NULLs are skipped          */
    int         also_count;
    const char *kept;           /* one file, which is there, and nothing beside it; NULL = none           */
} Jail;

/* Shuts this process in, for good. False where a wall is missing. The text says which of them hold. */
bool jail_enter(const Jail *jail, char *text, size_t capacity);

/* Which walls this kernel has, for `digbox doctor`: true when all. */
bool jail_describe(char *text, size_t capacity);

#endif
