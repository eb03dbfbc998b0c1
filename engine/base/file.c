/* base/file.c - whole files: written as drafts beside their place and moved there, read after a look at their size. */
#define _POSIX_C_SOURCE 200809L     /* open and friends, fsync, lstat */

#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char draft_start[] = ".digbox-", draft_end[] = ".tmp";

/* `what`: "" or "cannot be read: " */
static void say(char *why, size_t capacity, const char *path, const char *what, int error)
{
    char text[128] = "";
    if (strerror_r(error, text, sizeof text) != 0)
        snprintf(text, sizeof text, "error %d", error);
    snprintf(why, capacity, "%s: %s%s", path, what, text);
}

/* ---- writing ---- */

int file_write_all(int handle, const void *data, size_t size)
{
    const char *from = data;
    while (size > 0) {
        ssize_t n = write(handle, from, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? errno : EIO;
        from += n;
        size -= (size_t)n;
    }
    return 0;
}

static int folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash - path) + 1 : 0;
}

/* A name has at most 255 bytes with most file systems: of a long one a part will do, the number makes it the only one. */
static bool draft_name(const char *path, int number, char *name, size_t capacity)
{
    int folder = folder_length(path);
    int length = snprintf(name, capacity, "%.*s%s%ld-%d-%.120s%s", folder, path, draft_start, (long)getpid(), number, path + folder,
                          draft_end);
    return length > 0 && (size_t)length < capacity;
}

/* Locked before anyone can have swept it away. */
static bool is_ours(int handle)
{
    struct stat info;
    return flock(handle, LOCK_EX | LOCK_NB) == 0 ? fstat(handle, &info) == 0 && info.st_nlink > 0 : errno != EWOULDBLOCK;
}

/* Returns an errno. */
static int open_draft(FileDraft *d, const char *path)
{
    for (int i = 0; i < 100; i++) {
        if (!draft_name(path, i, d->name, sizeof d->name))
            return ENAMETOOLONG;
        d->handle = open(d->name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (d->handle >= 0 && is_ours(d->handle))
            return 0;
        if (d->handle < 0 && errno != EEXIST)
            return errno;
        if (d->handle >= 0)
            close(d->handle);
        d->handle = -1;
    }
    return EEXIST;
}

dig_status file_draft(const char *path, FileDraft *d, char *why, size_t capacity)
{
    struct stat info;
    d->handle = -1;
    if (lstat(path, &info) == 0 && !S_ISREG(info.st_mode)) {        /* a rename would put a file in its place */
        snprintf(why, capacity, "%s: exists and is not an ordinary file", path);
        return DIG_E_FILE;
    }
    int error = open_draft(d, path);
    if (error == 0)
        return DIG_OK;
    say(why, capacity, path, "", error);
    return DIG_E_FILE;
}

static dig_status fail(FileDraft *d, const char *path, int error, char *why, size_t capacity)
{
    file_draft_drop(d);
    say(why, capacity, path, "", error);
    return DIG_E_FILE;
}

dig_status file_draft_write(FileDraft *d, const char *path, const void *data, size_t size, char *why, size_t capacity)
{
    int error = file_write_all(d->handle, data, size);
    return error == 0 ? DIG_OK : fail(d, path, error, why, capacity);
}

/* A failure may come as late as with close; the lock stays until the file has its name. Returns an errno. */
static int place(const FileDraft *d, const char *path, FileCare care)
{
    if (care != FILE_QUICK && fsync(d->handle) != 0 && errno != EINVAL && errno != ENOTSUP)     /* a file system that cannot */
        return errno;
    int other = fcntl(d->handle, F_DUPFD_CLOEXEC, 0);
    if (other < 0 || (close(other) != 0 && errno != EINTR) || rename(d->name, path) != 0)
        return errno;
    return 0;
}

dig_status file_draft_place(FileDraft *d, const char *path, FileCare care, char *why, size_t capacity)
{
    int error = place(d, path, care);
    if (error != 0)
        return fail(d, path, error, why, capacity);
    close(d->handle);
    d->handle = -1;
    if (care == FILE_DURABLE)
        file_sync_folder(path);
    return DIG_OK;
}

void file_draft_drop(FileDraft *d)
{
    if (d->handle < 0)
        return;
    unlink(d->name);
    close(d->handle);
    d->handle = -1;
}

int file_pipe(int ends[2])
{
    if (pipe(ends) != 0)
        return errno;
    for (int i = 0; i < 2; i++)
        fcntl(ends[i], F_SETFD, FD_CLOEXEC);
    return 0;
}

/* The name is on the disk only when the folder is. Some file systems cannot say: the file itself is safe by then. */
void file_sync_folder(const char *path)
{
    char name[4096];
    int length = folder_length(path);
    snprintf(name, sizeof name, "%.*s", length > 0 ? length : 1, length > 0 ? path : ".");
    int folder = open(name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        (void)fsync(folder);
        close(folder);
    }
}

dig_status file_replace(const char *path, const void *data, size_t size, FileCare care, char *why, size_t capacity)
{
    FileDraft d;
    DIG_TRY(file_draft(path, &d, why, capacity));
    DIG_TRY(file_draft_write(&d, path, data, size, why, capacity));
    return file_draft_place(&d, path, care, why, capacity);
}

/* ---- what killed processes left ---- */

static bool is_draft(const char *name)
{
    size_t length = strlen(name), end = sizeof draft_end - 1;
    return strncmp(name, draft_start, sizeof draft_start - 1) == 0 && length > end && strcmp(name + length - end, draft_end) == 0;
}

int file_sweep(const char *folder)
{
    int count = 0;
    DIR *list = opendir(folder);
    if (!list)
        return 0;
    for (const struct dirent *e; (e = readdir(list));) {
        if (!is_draft(e->d_name))
            continue;
        int handle = openat(dirfd(list), e->d_name, O_RDWR | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
        if (handle < 0)
            continue;
        struct stat info;
        if (fstat(handle, &info) == 0 && S_ISREG(info.st_mode) && flock(handle, LOCK_EX | LOCK_NB) == 0)
            count += unlinkat(dirfd(list), e->d_name, 0) == 0;
        close(handle);
    }
    closedir(list);
    return count;
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
        say(why, capacity, path, "cannot be read: ", errno);
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
        say(why, capacity, path, "cannot be read: ", error);
    else
        snprintf(why, capacity, "%s: it changed while it was read", path);
    return DIG_E_FILE;
}

dig_status file_read(const char *path, FileLook *look, void *context, unsigned char **data, size_t *size, char *why, size_t capacity)
{
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);      /* a pipe must not hang */
    *data = NULL;
    if (file < 0) {
        say(why, capacity, path, "cannot be read: ", errno);
        return DIG_E_FILE;
    }
    dig_status s = read_open(file, path, look, context, data, size, why, capacity);
    close(file);
    return s;
}

bool file_stays_below(const char *path)
{
    if (path[0] == '/' || path[0] == '\0')
        return false;
    for (const char *p = path; p; p = strchr(p, '/')) {
        p += *p == '/';
        if (strncmp(p, "..", 2) == 0 && (p[2] == '/' || p[2] == '\0'))
            return false;
    }
    return true;
}
