/* lua/bind_frames.c - the frames of a film that is being taken: the manifest beside them, and which of an earlier run are kept.
 *
 * When a frame is due and what it shows is decided in lua/digbox/frames.lua. The manifest is locked while the film is open; a frame
 * is added to it once the frame has its name.
 */

#define _XOPEN_SOURCE 700       /* ftruncate, fcntl */

#include "bind.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "manifest.h"

#define FRAMES "frames"

enum { SYNC_EVERY = 64 };       /* frames between calls that put their names and the manifest on the disk */

typedef struct Frames {
    int      handle;            /* of the manifest, -1 = closed                                     */
    int      unsynced;
    bool     mixed;             /* frames were added behind later ones: to be put in order          */
    long long last;             /* index of the last entry of the file                              */
    Manifest kept;              /* what an earlier run left                                         */
    char     path[2048];
} Frames;

static Frames *check_frames(lua_State *L)
{
    return luaL_checkudata(L, 1, FRAMES);
}

static int frames_gc(lua_State *L)
{
    Frames *f = check_frames(L);
    if (f->handle >= 0)
        close(f->handle);
    f->handle = -1;
    manifest_close(&f->kept);
    return 0;
}

/* nil, what is wrong, exit code */
static int refuse(lua_State *L, int code, const char *text)
{
    lua_pushnil(L);
    lua_pushstring(L, text);
    lua_pushinteger(L, code);
    return 3;
}

static int refuse_errno(lua_State *L, const char *path, int error)
{
    return refuse(L, 9, lua_pushfstring(L, "%s: %s", path, strerror(error)));
}

/* 0, or the process that has it locked; -1 where locks are unknown */
static int lock_whole(int handle)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (fcntl(handle, F_SETLK, &lock) == 0 || (errno != EACCES && errno != EAGAIN))
        return 0;
    lock = (struct flock){.l_type = F_WRLCK, .l_whence = SEEK_SET};
    return fcntl(handle, F_GETLK, &lock) == 0 && lock.l_type != F_UNLCK && lock.l_pid > 0 ? (int)lock.l_pid : -1;
}

/* The first line in which the heads of two manifests differ, cut out of each. */
static void push_difference(lua_State *L, const char *there, const char *wanted)
{
    size_t at = 0;
    for (size_t i = 0; there[i] && there[i] == wanted[i]; i++)
        if (there[i] == '\n')
            at = i + 1;
    for (int i = 0; i < 2; i++) {
        const char *line = (i ? wanted : there) + at;
        line += strncmp(line, "# ", 2) == 0 ? 2 : 0;
        lua_pushlstring(L, line, strcspn(line, "\n"));
    }
}

/* Locks and reads what is there. Returns 0, or the number of values that refuse. */
static int take_over(lua_State *L, Frames *f, const char *head, const char *mode)
{
    char why[2400];
    int other = lock_whole(f->handle);
    if (other != 0)
        return refuse(L, 2, lua_pushfstring(L, "%s: its film is in use by process %d", f->path, other));
    dig_status s = manifest_read(f->handle, f->path, &f->kept, why, sizeof why);
    bool force = strcmp(mode, "force") == 0, resume = strcmp(mode, "resume") == 0;
    if (s != DIG_OK && !force)
        return refuse(L, 8, lua_pushfstring(L, "%s; --force takes the film anew", why));
    if (!force && !resume && f->kept.count > 0)
        return refuse(L, 2, lua_pushfstring(L, "%s: %d frames of an earlier run are there; "
                                            "--resume goes on with them, --force takes them anew", f->path, f->kept.count));
    if (resume && f->kept.count > 0 && strcmp(f->kept.head, head) != 0) {
        push_difference(L, f->kept.head, head);
        return refuse(L, 2, lua_pushfstring(L, "%s: --resume: another run\n  there:  %s\n  wanted: %s", f->path, lua_tostring(L, -2),
                                            lua_tostring(L, -1)));
    }
    return 0;
}

/* The file as it is from now on: what is kept, or a head alone. Returns an errno. */
static int begin_file(Frames *f, const char *head)
{
    bool kept = f->kept.count > 0;
    if (ftruncate(f->handle, kept ? (off_t)f->kept.whole : 0) != 0)
        return errno;
    f->last = kept ? f->kept.frames[f->kept.count - 1].index : manifest_first(head) - 1;
    f->mixed = kept && !f->kept.in_order;
    int error = kept ? 0 : file_write_all(f->handle, head, strlen(head));
    return error == 0 && fdatasync(f->handle) != 0 && errno != EINVAL && errno != ENOTSUP ? errno : error;
}

/* core.frames_open(path, head, mode) -> frames; or nil, what is wrong, exit code. mode: "new", "resume", or "force", which forgets what
 * was there and gives the names of those frames, by their numbers, as a second value. */
static int frames_open(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1), *head = luaL_checkstring(L, 2), *mode = luaL_checkstring(L, 3);
    Frames *f = lua_newuserdatauv(L, sizeof *f, 0);
    *f = (Frames){.handle = -1};
    luaL_setmetatable(L, FRAMES);
    if (snprintf(f->path, sizeof f->path, "%s", path) >= (int)sizeof f->path)
        return refuse_errno(L, path, ENAMETOOLONG);
    f->handle = open(path, O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, 0666);
    if (f->handle < 0)
        return refuse_errno(L, path, errno);
    int refused = take_over(L, f, head, mode);
    if (refused)
        return refused;
    lua_pushvalue(L, 4);
    lua_createtable(L, f->kept.count, 0);
    if (strcmp(mode, "resume") != 0) {
        for (int i = 0; i < f->kept.count; i++) {
            lua_pushstring(L, f->kept.frames[i].name);
            lua_rawseti(L, -2, f->kept.frames[i].index);
        }
        manifest_close(&f->kept);
    }
    int error = begin_file(f, head);
    return error == 0 ? 2 : refuse_errno(L, path, error);
}

/* core.frames_kept(frames, index) -> name, size, SHA-256, checksum of the world, of the scene; nil when there is no such frame */
static int frames_kept(lua_State *L)
{
    const ManifestFrame *k = manifest_find(&check_frames(L)->kept, luaL_checkinteger(L, 2));
    if (!k)
        return 0;
    lua_pushstring(L, k->name);
    lua_pushinteger(L, (lua_Integer)k->size);
    lua_pushstring(L, k->sum);
    lua_pushstring(L, k->world);
    lua_pushstring(L, k->scene);
    return 5;
}

/* Returns an errno. */
static int sync_frames(Frames *f)
{
    f->unsynced = 0;
    file_sync_folder(f->path);
    return fdatasync(f->handle) != 0 && errno != EINVAL && errno != ENOTSUP ? errno : 0;
}

static int append(Frames *f, const char *text, size_t size)
{
    off_t end = lseek(f->handle, 0, SEEK_END);
    int error = end < 0 ? errno : file_write_all(f->handle, text, size);
    if (error != 0 && end >= 0 && ftruncate(f->handle, end) != 0)
        return error;           /* its end is torn, which is seen when it is read */
    return error;
}

/* The two lines of a frame whose number is at `first`, all else behind it. Returns their length, 0 when the name is too long. */
static size_t print_entry(lua_State *L, int first, ManifestFrame *frame, char lines[MANIFEST_LINE])
{
    *frame = (ManifestFrame){.index = luaL_checkinteger(L, first), .name = luaL_checkstring(L, first + 1),
                             .size = (uint64_t)luaL_checkinteger(L, first + 2), .step = (uint64_t)luaL_checkinteger(L, first + 4),
                             .time = luaL_checknumber(L, first + 5)};
    snprintf(frame->sum, sizeof frame->sum, "%s", luaL_checkstring(L, first + 3));
    snprintf(frame->world, sizeof frame->world, "%s", luaL_checkstring(L, first + 6));
    snprintf(frame->scene, sizeof frame->scene, "%s", luaL_checkstring(L, first + 7));
    return manifest_print(frame, lines);
}

/* Returns an errno. */
static int add_entry(Frames *f, long long index, const char *lines, size_t size)
{
    int error = f->handle < 0 ? EBADF : size == 0 ? ENAMETOOLONG : append(f, lines, size);
    f->mixed = f->mixed || index != f->last + 1;
    f->last = index;
    if (error == 0 && ++f->unsynced >= SYNC_EVERY)
        error = sync_frames(f);
    return error;
}

/* core.frames_add(frames, index, name, size, sum, step, time, world, scene): the frame is under its name */
static int frames_add(lua_State *L)
{
    Frames *f = check_frames(L);
    char lines[MANIFEST_LINE];
    ManifestFrame frame;
    size_t size = print_entry(L, 2, &frame, lines);
    int error = add_entry(f, frame.index, lines, size);
    return error == 0 ? 0 : bind_fail_text(L, DIG_E_FILE, "%s: %s", f->path, strerror(error));
}

/* ---- entries that other processes hand on, for those that draw one film side by side ---- */

typedef struct Entry {          /* one write to a pipe, which POSIX does not cut: it is below PIPE_BUF */
    long long index;
    size_t    size;
    char      lines[MANIFEST_LINE];
} Entry;

/* core.frames_send(fd, index, name, size, sum, step, time, world, scene): to the process that holds the manifest */
static int frames_send(lua_State *L)
{
    int fd = (int)luaL_checkinteger(L, 1);
    Entry e = {.index = 0};
    ManifestFrame frame;
    e.size = print_entry(L, 2, &frame, e.lines);
    e.index = frame.index;
    int error = e.size == 0 ? ENAMETOOLONG : file_write_all(fd, &e, sizeof e);
    return error == 0 ? 0 : bind_fail_text(L, DIG_E_FILE, "frame %d cannot be handed on: %s", (int)frame.index, strerror(error));
}

/* core.frames_take(frames, fd) -> whether an entry came from there and was added; false: no more will come */
static int frames_take(lua_State *L)
{
    Frames *f = check_frames(L);
    int fd = (int)luaL_checkinteger(L, 2);
    Entry e = {.index = 0};
    size_t got = 0;
    while (got < sizeof e) {
        ssize_t n = read(fd, (char *)&e + got, sizeof e - got);
        if (n <= 0 && !(n < 0 && errno == EINTR))
            break;
        got += n > 0 ? (size_t)n : 0;
    }
    lua_pushboolean(L, got == sizeof e && e.size < sizeof e.lines);
    int error = lua_toboolean(L, -1) ? add_entry(f, e.index, e.lines, e.size) : 0;
    return error == 0 ? 1 : bind_fail_text(L, DIG_E_FILE, "%s: %s", f->path, strerror(error));
}

/* Of a resumed film: the entries in the order of the frames. */
static dig_status put_in_order(const Frames *f, char *why, size_t capacity)
{
    Manifest m;
    dig_status s = manifest_read(f->handle, f->path, &m, why, capacity);
    if (s == DIG_OK)
        s = manifest_rewrite(f->path, &m, why, capacity);
    manifest_close(&m);
    return s;
}

/* core.frames_close(frames, count): no frame comes any more. count: the film came to its end with so many, nil: it was cut */
static int frames_close(lua_State *L)
{
    Frames *f = check_frames(L);
    char line[64], why[2400] = "";
    dig_status s = DIG_OK;
    if (f->handle < 0)
        return 0;
    int length = lua_isnoneornil(L, 2) ? 0 : snprintf(line, sizeof line, "# end: %" PRId64 " frames\n", (int64_t)luaL_checkinteger(L, 2));
    int error = length > 0 ? append(f, line, (size_t)length) : 0;
    if (error == 0)
        error = sync_frames(f);
    if (error != 0)
        snprintf(why, sizeof why, "%s: %s", f->path, strerror(error));
    else if (f->mixed)
        s = put_in_order(f, why, sizeof why);
    frames_gc(L);
    return error == 0 && s == DIG_OK ? 0 : bind_fail_text(L, s == DIG_OK ? DIG_E_FILE : s, "%s", why);
}

/* core.sum_file(path) -> SHA-256, bytes; nil when it cannot be read */
static int frames_sum(lua_State *L)
{
    char sum[MANIFEST_SUM], why[1200];
    uint64_t size;
    if (manifest_sum_file(luaL_checkstring(L, 1), sum, &size, why, sizeof why) != DIG_OK)
        return 0;
    lua_pushstring(L, sum);
    lua_pushinteger(L, (lua_Integer)size);
    return 2;
}

/* core.hash(text) -> 16 hexadecimal digits of it and of all source text that was loaded */
static int frames_hash(lua_State *L)
{
    size_t size;
    char hex[17];
    const char *text = luaL_checklstring(L, 1, &size);
    uint64_t h = hash_bytes(HASH_START, text, size);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.sources");
    const char *sources = lua_tolstring(L, -1, &size);
    if (sources)
        h = hash_bytes(h, sources, size);
    snprintf(hex, sizeof hex, "%016" PRIx64, h);
    lua_pushstring(L, hex);
    return 1;
}

/* core.sweep(path): drafts that killed processes left in the file's folder */
static int frames_sweep(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1), *slash = strrchr(path, '/');
    lua_pushlstring(L, slash ? path : ".", slash == path ? 1 : slash ? (size_t)(slash - path) : 1);
    lua_pushinteger(L, file_sweep(lua_tostring(L, -1)));
    return 1;
}

/* core.remove(path): for embedded files only, which decide what may go */
static int frames_remove(lua_State *L)
{
    lua_pushboolean(L, unlink(luaL_checkstring(L, 1)) == 0);
    return 1;
}

/* core.exit_code(message) of an error that was caught */
static int frames_exit_code(lua_State *L)
{
    lua_pushinteger(L, bind_exit_code(L, lua_tostring(L, 1)));
    return 1;
}

void bind_frames_open(lua_State *L, int core)
{
    static const luaL_Reg functions[] = {
        {"frames_open", frames_open}, {"frames_kept", frames_kept}, {"frames_add", frames_add}, {"frames_send", frames_send},
        {"frames_take", frames_take}, {"frames_close", frames_close}, {"sum_file", frames_sum}, {"hash", frames_hash},
        {"sweep", frames_sweep}, {"remove", frames_remove}, {"exit_code", frames_exit_code}, {NULL, NULL},
    };
    bind_held_type(L, FRAMES, frames_gc);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
