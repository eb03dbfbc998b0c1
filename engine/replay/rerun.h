/* replay/rerun.h - a run that was kept, simulated again: does it lead to the same states?
 *
 * A replay holds the world from which it starts and the log of commands (digbox.h). A rerun plays them in a world of its own and
 * compares the checksum after every step with the one that was kept.
 *
 * Floor: replay.
 */
#ifndef DIG_RERUN_H
#define DIG_RERUN_H

#include "replay/replay.h"

typedef struct Rerun {
    int      frames;            /* that were compared and are the same, the first included          */
    int      commands;          /* played, steps included                                           */
    int      differs;           /* first frame that is not the same; -1: all are                    */
    uint64_t step;              /* of the world there                                               */
    uint64_t was, is;           /* its checksums, kept and now; equal: a command did not go the same way */
    char     why[400];          /* one sentence; empty when all is the same                         */
} Rerun;

/* DIG_OK: it was simulated, and out says what came out. Else why says what is wrong with the file. */
dig_status replay_rerun(Replay *r, Rerun *out, char *why, size_t capacity);

#endif
