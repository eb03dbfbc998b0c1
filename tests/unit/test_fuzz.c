/* tests/unit/test_fuzz.c - the fuzz targets of tests/fuzz/ for a short time: their first inputs, and changes of them from a fixed seed.
 *
 * Blind changes find less than libFuzzer does (`make fuzz`), but run with any compiler and in every `make test`.
 * DIGBOX_FULL=1: scripts of a million random calls together (A22).
 */
#define _GNU_SOURCE             /* of fuzz/state.c */
#include "lua/state.h"

#include "check.h"

#include <stdlib.h>

#include "fuzz/state.c"
#include "fuzz/target_api.c"
#include "fuzz/target_mesh.c"
#include "fuzz/target_replay.c"
#include "fuzz/target_save.c"
#include "fuzz/target_script.c"

enum { INPUTS = 64 };

typedef struct Inputs { unsigned char *data[INPUTS]; size_t size[INPUTS]; int count; } Inputs;

static void take(void *context, const void *bytes, size_t size)
{
    Inputs *in = context;
    CHECK(in->count < INPUTS);
    in->data[in->count] = malloc(size + 1);
    CHECK(in->data[in->count] != NULL);
    memcpy(in->data[in->count], bytes, size);
    in->size[in->count++] = size;
}

static uint64_t random_next(uint64_t *state)        /* xorshift64 (Marsaglia 2003) */
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static size_t below(uint64_t *random, size_t n) { return n > 0 ? (size_t)((random_next(random) >> 16) % n) : 0; }

/* One change: a bit, a byte, a number of four bytes, a part left out, or a part of the input given twice. Returns the new size. */
static size_t change(unsigned char *data, size_t size, size_t longest, uint64_t *random)
{
    static const uint32_t odd[] = {0, 1, 0xff, 0x7f, 0x7fffffff, 0x80000000, 0xffffffff, 0xfffffffe, 0x7ff00000, 0x7ff80000, 0xfff00000, 64, 1 << 20};
    size_t at = below(random, size), part = 1 + below(random, size / 8 + 4);
    if (size < 8)
        return size;
    part = part < size - at ? part : size - at;
    switch (random_next(random) >> 40 & 7) {
    case 0: case 1: data[at] ^= (unsigned char)(1u << below(random, 8)); return size;
    case 2: case 3: data[at] = (unsigned char)(random_next(random) >> 24); return size;
    case 4: case 5:
        for (size_t i = 0, x = odd[below(random, sizeof odd / sizeof *odd)]; i < 4; i++)
            data[at / 4 * 4 + i < size ? at / 4 * 4 + i : at] = (unsigned char)(x >> 8 * i);
        return size;
    case 6:
        memmove(data + at, data + at + part, size - at - part);
        return size - part;
    default:
        if (size + part > longest)
            return size;
        memmove(data + at + part, data + at, size - at);
        return size + part;
    }
}

static void run_for_a_while(const FuzzTarget *target, int count)
{
    Inputs in = {.count = 0};
    uint64_t random = 88172645463325252u;
    unsigned char *data = malloc(target->longest + 1);
    CHECK(data != NULL);
    target->seeds(take, &in);
    CHECK(in.count > 0);
    for (int i = 0; i < in.count; i++)
        target->run(in.data[i], in.size[i]);
    for (int n = 0; n < count; n++) {
        size_t which = below(&random, (size_t)in.count), size = in.size[which];
        CHECK(size <= target->longest);
        memcpy(data, in.data[which], size);
        for (size_t k = 1 + below(&random, 4); k > 0; k--)
            size = change(data, size, target->longest, &random);
        target->run(data, size);
    }
    for (int i = 0; i < in.count; i++)
        free(in.data[i]);
    free(data);
}

enum { CALLS_A_SCRIPT = 24 };
TEST(random_calls_break_nothing) { run_for_a_while(&fuzz_api, getenv("DIGBOX_FULL") ? 1000000 / CALLS_A_SCRIPT : 60); }
TEST(random_scripts_break_nothing) { run_for_a_while(&fuzz_script, 200); }
TEST(random_saved_worlds_break_nothing) { run_for_a_while(&fuzz_save, 400); }
TEST(random_replays_break_nothing) { run_for_a_while(&fuzz_replay, 300); }
TEST(random_meshes_break_nothing) { run_for_a_while(&fuzz_mesh, 150); }

int main(void)
{
    RUN_TESTS(unit_test(random_calls_break_nothing), unit_test(random_scripts_break_nothing), unit_test(random_saved_worlds_break_nothing),
              unit_test(random_replays_break_nothing), unit_test(random_meshes_break_nothing));
}
