/* tests/fuzz/main.c - one target as a program of libFuzzer; FUZZ_TARGET is the name of its table.
 *
 *   fuzz_api --seeds FOLDER    writes the first inputs there
 *   fuzz_api --show FILE       prints what an input stands for, the script of fuzz_api for one
 *   fuzz_api ...               as `fuzz_api -help=1` says
 */
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

extern const FuzzTarget FUZZ_TARGET;

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct Folder { const char *path; int count; } Folder;

static void write_seed(void *context, const void *bytes, size_t size)
{
    Folder *folder = context;
    char path[1024];
    snprintf(path, sizeof path, "%s/seed-%03d", folder->path, folder->count++);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f) != 0)
        fuzz_fail("cannot write %s", path);
}

static void show_file(const char *path)
{
    unsigned char *data = malloc(FUZZ_TARGET.longest + 1);
    FILE *f = fopen(path, "rb");
    if (!f || !data)
        fuzz_fail("cannot read %s", path);
    size_t size = fread(data, 1, FUZZ_TARGET.longest, f);
    fclose(f);
    if (FUZZ_TARGET.show)
        FUZZ_TARGET.show(data, size);
    else
        fwrite(data, 1, size, stdout);
    free(data);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    if (*argc != 3)
        return 0;
    if (strcmp((*argv)[1], "--seeds") == 0) {
        Folder folder = {(*argv)[2], 0};
        FUZZ_TARGET.seeds(write_seed, &folder);
        exit(0);
    }
    if (strcmp((*argv)[1], "--show") == 0) {
        show_file((*argv)[2]);
        exit(0);
    }
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    FUZZ_TARGET.run(data, size);
    return 0;
}
