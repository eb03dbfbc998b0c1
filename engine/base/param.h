/* base/param.h - checking and filling def structs from their parameter rows.
 *
 * A row says name, kind, unit, default and range of one field; everything here
 * follows from that. A row whose min equals its max has no range of its own.
 *
 * NaN in a field means "not given" where the row's fallback is NaN and the
 * field is not required, and is an error everywhere else.
 *
 * Floor: base.
 */
#ifndef DIG_PARAM_H
#define DIG_PARAM_H

#include "base/base.h"

int param_count(const dig_param *rows);

/* The row called name, or NULL. */
const dig_param *param_find(const dig_param *rows, const char *name);

/* The row of a dotted path ("motor.speed") and the offset of its field from the start of the outermost struct; NULL when
 * there is none. */
const dig_param *param_find_path(const dig_param *rows, const char *path, size_t *offset);

/* Bytes of a field; a nested table has no size of its own: 0. */
size_t param_size(const dig_param *row);

/* Fills def with the defaults of the rows (recursively). */
void param_defaults(const dig_param *rows, void *def);

/* Numbers nearer to 0 than this have no finite inverse once they are multiplied: records hold none. */
#define PARAM_SPECK 1e-250

bool param_has_reals(const dig_param *row);

/* Makes such numbers 0, recursively. */
void param_settle(const dig_param *rows, void *def);

/* Is this one field as the row wants it? On failure DIG_E_ARG, and why holds one sentence that starts with subject:
 * "body 'plank 7': mass = -3 kg, must be > 0". */
dig_status param_check_field(const dig_param *row, const void *field, const char *subject, char *why, size_t capacity);

/* The same for every field of a def struct, in the order of the rows. */
dig_status param_check(const dig_param *rows, const void *def, const char *subject, char *why, size_t capacity);

#endif
