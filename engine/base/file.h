/* base/file.h - whole files: under a file's name stands the old one or the new one, never a part; and reading with care.
 *
 * What is being written is a draft in the same folder, .digbox-PID-NAME.tmp, locked (flock) as long as its process lives. A draft
 * that nobody has locked was left by a process that was killed: file_sweep removes those.
 *
 * Owns:      nothing between calls, but for an open FileDraft.
 * Floor:     base.
 */
#ifndef DIG_FILE_H
#define DIG_FILE_H

#include "base/base.h"

#define FILE_START 64u          /* bytes that are read for a first look */

typedef enum FileCare {
    FILE_QUICK,                 /* whole as long as the machine keeps running                     */
    FILE_FLUSHED,               /* its bytes are on the disk before it has its name               */
    FILE_DURABLE                /* and so is the name when the call returns                       */
} FileCare;

typedef struct FileDraft {
    int  handle;                /* -1 = none is open */
    char name[4096];
} FileDraft;

/* These fail with a sentence that names the path and the reason of the system; then the draft is gone and the old file untouched. */
dig_status file_draft(const char *path, FileDraft *d, char *why, size_t capacity);
dig_status file_draft_write(FileDraft *d, const char *path, const void *data, size_t size, char *why, size_t capacity);
dig_status file_draft_place(FileDraft *d, const char *path, FileCare care, char *why, size_t capacity);
void file_draft_drop(FileDraft *d);

/* A pipe that no program started later inherits: one that held the writing end would keep the reader waiting for its end. Returns an errno. */
int file_pipe(int ends[2]);

/* All of it: a draft, the bytes, the name. */
dig_status file_replace(const char *path, const void *data, size_t size, FileCare care, char *why, size_t capacity);

/* Removes drafts in that folder that nobody is writing any more; returns how many. */
int file_sweep(const char *folder);

/* The names in the file's folder are on the disk, where the file system can say so. */
void file_sync_folder(const char *path);

/* Writes all of it, or returns an errno. */
int file_write_all(int handle, const void *data, size_t size);

/* Judges the first bytes (at most FILE_START) and the size of a file before memory for it is taken. */
typedef dig_status FileLook(void *context, const unsigned char *start, size_t got, uint64_t size);
/* *data is to be freed by the caller. */
dig_status file_read(const char *path, FileLook *look, void *context, unsigned char **data, size_t *size, char *why, size_t capacity);

/* Is the path relative, and without ".." a way out of the folder that it is relative to? Links are not looked at. */
bool file_stays_below(const char *path);

#endif
