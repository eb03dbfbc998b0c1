/* tests/cli/faults.c - put before the C library by faults.sh (LD_PRELOAD): the Nth call that writes fails.
 *
 * Making a folder named fault-CALL-N-KIND-ERRNO says which: CALL is open, write, short (half of what is asked for), fsync,
 * close, rename or mkdir, N counts from 1, KIND is once or on (it and all after it). Only files that are made or written count, no
 * standard streams. Everything else goes straight to the kernel.
 *
 * DIGBOX_NO_GL=library, create or current: there is no EGL, and of OSMesa not that.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static char call[16];
static int  at, count, error;
static int  goes_on;

static int fails(const char *name)
{
    if (strcmp(name, call) != 0)
        return 0;
    count++;
    if (count != at && !(goes_on && count > at))
        return 0;
    errno = error;
    return 1;
}

static void arm(const char *name)
{
    char kind[8] = "";
    call[0] = '\0';
    count = 0;
    if (sscanf(name, "fault-%15[a-z]-%d-%7[a-z]-%d", call, &at, kind, &error) == 4)
        goes_on = strcmp(kind, "on") == 0;
}

static int is_output(int fd)
{
    struct stat info;
    return fd > 2 && fstat(fd, &info) == 0 && S_ISREG(info.st_mode) && (fcntl(fd, F_GETFL) & O_ACCMODE) != O_RDONLY;
}

int mkdir(const char *path, mode_t mode)
{
    const char *name = strstr(path, "fault-");
    bool below = name && strchr(name, '/');
    if (below && fails("mkdir"))
        return -1;
    int result = (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode);
    if (name && !below && result == 0)
        arm(name);
    return result;
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    int mode = flags & O_CREAT ? va_arg(rest, int) : 0;
    va_end(rest);
    if ((flags & O_CREAT) && fails("open"))
        return -1;
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

ssize_t write(int fd, const void *bytes, size_t size)
{
    if (is_output(fd)) {
        if (fails("write"))
            return -1;
        if (size > 1 && fails("short"))
            size /= 2;
    }
    return syscall(SYS_write, fd, bytes, size);
}

/* Nobody pulls the plug here, and the disk takes its time. */
int fsync(int fd) { return is_output(fd) && fails("fsync") ? -1 : 0; }
int fdatasync(int fd) { return is_output(fd) && fails("fsync") ? -1 : 0; }

/* The descriptor is gone even when close fails. */
int close(int fd)
{
    int bad = is_output(fd) && fails("close");
    int result = (int)syscall(SYS_close, fd);
    if (bad)
        errno = error;
    return bad ? -1 : result;
}

int rename(const char *from, const char *to)
{
    return fails("rename") ? -1 : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

/* ---- a renderer that refuses ---------------------------------------------------------------------- */

static int refused(const char *what)
{
    const char *wish = getenv("DIGBOX_NO_GL");
    return wish && strcmp(wish, what) == 0;
}

void *OSMesaCreateContextAttribs(const int *wanted, void *shares)
{
    void *(*real)(const int *, void *) = (void *(*)(const int *, void *))dlsym(RTLD_NEXT, "OSMesaCreateContextAttribs");
    return refused("create") || !real ? NULL : real(wanted, shares);
}

unsigned char OSMesaMakeCurrent(void *context, void *buffer, unsigned type, int width, int height)
{
    unsigned char (*real)(void *, void *, unsigned, int, int) =
        (unsigned char (*)(void *, void *, unsigned, int, int))dlsym(RTLD_NEXT, "OSMesaMakeCurrent");
    return refused("current") || !real ? 0 : real(context, buffer, type, width, height);
}

/* OSMesa is looked up among all that is loaded, where the two above come first. */
void *dlopen(const char *path, int flags)
{
    void *(*real)(const char *, int) = (void *(*)(const char *, int))dlsym(RTLD_NEXT, "dlopen");
    bool osmesa = path && strstr(path, "libOSMesa");
    if (!real || (path && getenv("DIGBOX_NO_GL") && (strstr(path, "libEGL") || (osmesa && refused("library")))))
        return NULL;
    void *library = real(path, osmesa ? (flags & ~RTLD_LOCAL) | RTLD_GLOBAL : flags);
    return osmesa && library ? real(NULL, RTLD_NOW) : library;
}
