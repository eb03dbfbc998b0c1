/* tests/scratch.h - where a unit test puts its files: TMPDIR, which tests/run.sh gives each of them and clears away. */
#ifndef DIG_SCRATCH_H
#define DIG_SCRATCH_H

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* path = a name of this process in that folder; a name that ends in XXXXXX is for mkdtemp and mkstemp. */
static inline char *scratch_path(char *path, size_t capacity, const char *name)
{
    const char *folder = getenv("TMPDIR");
    snprintf(path, capacity, "%s/digbox-%ld-%s", folder && folder[0] ? folder : P_tmpdir, (long)getpid(), name);
    return path;
}

#endif
