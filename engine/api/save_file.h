/* api/save_file.h - whole files, written so that there is always the old one or the new one, and read with care.
 *
 * Owns:      nothing between calls.
 * Floor:     api, but needs base only.
 */
#ifndef DIG_SAVE_FILE_H
#define DIG_SAVE_FILE_H

#include "base/base.h"

#define FILE_START 64u          /* bytes that are read for a first look */

/* Writes path.N.new in the same folder, syncs it and renames it. Fails with a sentence that names the path and the reason of
 * the system; then the old file, if there was one, is untouched. */
dig_status file_replace(const char *path, const void *data, size_t size, char *why, size_t capacity);

/* Judges the first bytes (at most FILE_START) and the size of a file before memory for it is taken. */
typedef dig_status FileLook(void *context, const unsigned char *start, size_t got, uint64_t size);
/* *data is to be freed by the caller. */
dig_status file_read(const char *path, FileLook *look, void *context, unsigned char **data, size_t *size, char *why, size_t capacity);

#endif
