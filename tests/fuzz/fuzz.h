/* tests/fuzz/fuzz.h - what a fuzz target is: a table of how to make first inputs and what to do with any bytes.
 *
 * Each file target_NAME.c ends in such a table. With clang's libFuzzer (main.c, `make fuzz`) it is a program of its own, which
 * learns from what each input reaches; tests/unit/test_fuzz.c runs all of them for a short time under any compiler.
 * A fault is a crash, a report of a sanitizer, or fuzz_fail.
 */
#ifndef DIG_FUZZ_H
#define DIG_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void FuzzGive(void *context, const void *bytes, size_t size);

typedef struct FuzzTarget {
    const char *name;
    size_t      longest;                                        /* bytes that an input has at most                  */
    void      (*seeds)(FuzzGive *give, void *context);          /* gives the first inputs, one a call               */
    void      (*run)(const unsigned char *data, size_t size);
    void      (*show)(const unsigned char *data, size_t size);  /* prints what the input stands for; NULL: as it is */
} FuzzTarget;

extern const FuzzTarget fuzz_api, fuzz_script, fuzz_save, fuzz_replay, fuzz_mesh;

/* Says what was wrong and aborts. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
_Noreturn void fuzz_fail(const char *format, ...);

#endif
