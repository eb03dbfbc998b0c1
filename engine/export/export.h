/* export/export.h - a replay in forms that other programs read. A format is one file that ends in its table.
 *
 * Floor: export. Includes base, math, view, api, replay.
 */
#ifndef DIG_EXPORT_H
#define DIG_EXPORT_H

#include "replay/replay.h"

typedef struct Output Output;

typedef struct ExportOptions {
    int  first, last;           /* frames, both included                                              */
    real fps;                   /* frames a second that are written, at most; 0 = every one           */
    real at;                    /* s, of what shows one moment; NaN = the last frame                  */
} ExportOptions;

typedef struct ExportFormat {
    const char *suffix;         /* ".glb"                                                             */
    const char *what;           /* one line of help                                                   */
    /* Fails with a status after output_fail; on DIG_E_FORMAT and the like replay_error may say more. */
    dig_status (*write)(Replay *r, const ExportOptions *options, Output *out);
} ExportFormat;

extern const ExportFormat export_glb, export_csv, export_jsonl, export_npy, export_dot;

ExportOptions       export_defaults(const Replay *r);
const ExportFormat *export_format(int index);               /* NULL past the end                      */
const ExportFormat *export_find(const char *path);          /* by its suffix; NULL: none              */
/* The whole file or nothing, under a temporary name first. why gets one sentence on failure. */
dig_status export_write(Replay *r, const ExportFormat *format, const ExportOptions *options, const char *path, char *why, size_t capacity);

/* The frames that are to be written: first, then the next whose time is at least 1/fps after the one before. -1: no more. */
int export_next_frame(const Replay *r, const ExportOptions *options, int frame);
/* "ball", or "body 3" when it has no name. */
const char *export_name(const ReplayBody *b, int index, char buffer[32]);

#endif
