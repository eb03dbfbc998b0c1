/* export/output.h - bytes that grow: text, numbers, JSON strings.
 *
 * Owns:  its bytes, until output_close.
 * Floor: export.
 */
#ifndef DIG_EXPORT_OUTPUT_H
#define DIG_EXPORT_OUTPUT_H

#include "base/base.h"
#include "export/export.h"

/* Bytes that grow. After a failure every further call does nothing; output_good says so, once, at the end. */
struct Output {
    unsigned char *data;
    size_t size, capacity;
    char   why[200];            /* the first failure, "" = none                                       */
};

void output_bytes(Output *o, const void *bytes, size_t size);
void output_text(Output *o, const char *format, ...) DIG_PRINTF(2, 3);
void output_number(Output *o, real x);          /* the shortest of 15 to 17 digits that reads as the same number; null if not finite */
void output_json(Output *o, const char *text);  /* quoted, escaped */
void output_fail(Output *o, const char *format, ...) DIG_PRINTF(2, 3);
static inline bool output_good(const Output *o) { return o->why[0] == '\0'; }
void output_close(Output *o);

#endif
