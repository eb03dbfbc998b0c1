/* tests/fuzz/state.h - states in which fuzz targets run scripts: those of the program, sandbox and all.
 *
 * Limits raise errors there instead of ending the process; what ends it all the same (memory, in the middle of an allocation) comes
 * back here, and the state is left as it is for good.
 */
#ifndef DIG_FUZZ_STATE_H
#define DIG_FUZZ_STATE_H

#include "fuzz.h"

#include "lua/bind.h"
#include "lua/state.h"

typedef struct FuzzState FuzzState;

/* fuel: instructions and engine work that its script may use. */
FuzzState *fuzz_open(const char *script, long long fuel);
void       fuzz_close(FuzzState *f);

/* The same state for another script, which sees what the last one left; opens a new one (f may be NULL) where that was lost. */
FuzzState *fuzz_again(FuzzState *f, const char *script, long long fuel);

lua_State *fuzz_lua(const FuzzState *f);

/* Runs a text as the script; the exit code. Without a failure its first result is on the stack, else a sentence. */
int        fuzz_run(FuzzState *f, const char *text, size_t size);

/* The world made last that is open, or NULL. */
dig_world *fuzz_world(FuzzState *f);
/* Calls visit for every open world. */
void       fuzz_worlds(FuzzState *f, void (*visit)(dig_world *w, void *context), void *context);

/* Worlds of a few bodies each that together have one of everything: scripts, NULL-terminated. */
extern const char *const fuzz_rooms[];

/* A name for a file of this process in memory where the system has that: bytes are put there; valid till the next call. */
const char *fuzz_file(const unsigned char *data, size_t size);

#endif
