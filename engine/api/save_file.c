/* api/save_file.c - whole files: written beside their place and moved there, read after a look at their size. */
#define _POSIX_C_SOURCE 200809L     /* openat and friends, fsync */

#include "api/save_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static void say(char *why, size_t capacity, const char *path, const char *what, int error)
{
    char text[128] = "";
    if (strerror_r(error, text, sizeof text) != 0)
        snprintf(text, sizeof text, "error %d", error);
    snprintf(why, capacity, "%s: %s: %s", path, what, text);
}

/* ---- writing ---- */

static int write_all(int file, const unsigned char *data, size_t size)
{
    while (size > 0) {
        ssize_t n = write(file, data, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? errno : EIO;
        data += n;
        size -= (size_t)n;
    }
    return 0;
}

/* A new file in the same folder, so that moving it to its place is one act of the file system. */
static int open_beside(const char *path, char *name, size_t capacity)
{
    for (int i = 0; i < 100; i++) {
        snprintf(name, capacity, "%s.%d.new", path, i);
        int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0 || errno != EEXIST)
            return file;
    }
    return -1;
}

/* The name is on the disk only when the folder is. Some file systems cannot say: the file itself is safe by then. */
static void sync_folder(const char *path, char *name, size_t capacity)
{
    const char *slash = strrchr(path, '/');
    snprintf(name, capacity, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    int folder = open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        (void)fsync(folder);
        close(folder);
    }
}

dig_status file_replace(const char *path, const void *data, size_t size, char *why, size_t capacity)
{
    size_t room = strlen(path) + 16;
    char *name = malloc(room);
    if (!name) {
        snprintf(why, capacity, "%s: not enough memory", path);
        return DIG_E_MEMORY;
    }
    int file = open_beside(path, name, room);
    if (file < 0) {
        say(why, capacity, path, "cannot be written", errno);
        free(name);
        return DIG_E_FILE;
    }
    int error = write_all(file, data, size);
    if (error == 0 && fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP)     /* a file system that cannot */
        error = errno;
    if (close(file) != 0 && error == 0)
        error = errno;
    if (error == 0 && rename(name, path) != 0)
        error = errno;
    if (error != 0) {
        unlink(name);
        say(why, capacity, path, "cannot be written", error);
    } else {
        sync_folder(path, name, room);
    }
    free(name);
    return error == 0 ? DIG_OK : DIG_E_FILE;
}

/* ---- reading ---- */

static size_t read_some(int file, unsigned char *data, size_t size, int *error)
{
    size_t got = 0;
    *error = 0;
    while (got < size) {
        ssize_t n = read(file, data + got, size - got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            *error = errno;
        if (n <= 0)
            break;
        got += (size_t)n;
    }
    return got;
}

static dig_status read_open(int file, const char *path, FileLook *look, void *context, unsigned char **data, size_t *size, char *why,
                            size_t capacity)
{
    struct stat info;
    unsigned char start[FILE_START];
    int error;
    if (fstat(file, &info) != 0) {
        say(why, capacity, path, "cannot be read", errno);
        return DIG_E_FILE;
    }
    if (!S_ISREG(info.st_mode)) {
        snprintf(why, capacity, "%s: cannot be read: it is no file", path);
        return DIG_E_FILE;
    }
    size_t got = read_some(file, start, sizeof start, &error);
    if (error == 0)
        DIG_TRY(look(context, start, got, (uint64_t)info.st_size));
    *size = (size_t)info.st_size;
    *data = error == 0 ? malloc(*size + 1) : NULL;
    if (error == 0 && !*data) {
        snprintf(why, capacity, "%s: not enough memory for %zu bytes", path, *size);
        return DIG_E_MEMORY;
    }
    if (error == 0) {
        memcpy(*data, start, got < *size ? got : *size);
        if (got < *size)
            got += read_some(file, *data + got, *size - got, &error);
    }
    if (error == 0 && got == *size)
        return DIG_OK;
    free(*data);
    *data = NULL;
    if (error != 0)
        say(why, capacity, path, "cannot be read", error);
    else
        snprintf(why, capacity, "%s: it changed while it was read", path);
    return DIG_E_FILE;
}

dig_status file_read(const char *path, FileLook *look, void *context, unsigned char **data, size_t *size, char *why, size_t capacity)
{
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);      /* a pipe must not hang */
    *data = NULL;
    if (file < 0) {
        say(why, capacity, path, "cannot be read", errno);
        return DIG_E_FILE;
    }
    dig_status s = read_open(file, path, look, context, data, size, why, capacity);
    close(file);
    return s;
}
