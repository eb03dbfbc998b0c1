/* tests/unit/test_file.c - the Nth call that writes fails, for every N, once or from then on: under a file's name stands what was
 * there or the whole new file, the message names it and the reason, and no draft is left. Of a replay that has its name already
 * whole blocks are left.
 *
 * The calls of the system are defined here, before those of the C library.
 */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE             /* syscall */
#endif
#include "save_fixture.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include "base/file.h"
#include "export/export.h"
#include "replay/replay.h"
#include "lua/manifest.h"

/* ---- calls that fail ------------------------------------------------------------------- */

typedef enum Call { OPEN, WRITE, SHORT, INTERRUPTED, SYNC, CLOSE, RENAME, CALLS } Call;

static struct { bool armed, goes_on, fired; Call call; int at, count, error; } fault;

static bool fails(Call call)
{
    if (!fault.armed || call != fault.call)
        return false;
    fault.count++;
    if (fault.count != fault.at && !(fault.goes_on && fault.count > fault.at))
        return false;
    fault.fired = true;
    errno = call == INTERRUPTED ? EINTR : fault.error;
    return true;
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    unsigned mode = flags & O_CREAT ? va_arg(rest, unsigned) : 0;
    va_end(rest);
    return (flags & O_CREAT) && fails(OPEN) ? -1 : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

ssize_t write(int handle, const void *bytes, size_t size)
{
    if (fails(WRITE) || fails(INTERRUPTED))
        return -1;
    return syscall(SYS_write, handle, bytes, size > 1 && fails(SHORT) ? size / 2 : size);
}

/* Nobody pulls the plug here. What cannot be said of a folder is no failure. */
int fsync(int handle)
{
    struct stat info;
    return fstat(handle, &info) == 0 && S_ISREG(info.st_mode) && fails(SYNC) ? -1 : 0;
}

/* The descriptor is gone even when close fails. */
int close(int handle)
{
    bool bad = (fcntl(handle, F_GETFL) & O_ACCMODE) != O_RDONLY && fails(CLOSE);
    int result = (int)syscall(SYS_close, handle);
    if (bad)
        errno = fault.error;
    return bad ? -1 : result;
}

int rename(const char *from, const char *to)
{
    return fails(RENAME) ? -1 : (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

/* ---- what is written --------------------------------------------------------------------- */

static char folder[300], path[400], source[400];
static dig_world *world;

static dig_status write_bytes_of(const char *to, char *why, size_t capacity)
{
    static const unsigned char data[100000] = {1, 2, 3};
    return file_replace(to, data, sizeof data, FILE_DURABLE, why, capacity);
}

static dig_status write_save(const char *to, char *why, size_t capacity)
{
    dig_status s = dig_world_save(world, to);
    if (s != DIG_OK)
        snprintf(why, capacity, "%s", dig_error(world));
    return s;
}

static dig_status write_export(const char *to, char *why, size_t capacity)
{
    Replay *r;
    dig_status s = replay_open(source, &r, why, capacity);
    if (s != DIG_OK)
        return s;
    ExportOptions options = export_defaults(r);
    s = export_write(r, export_find("a.csv"), &options, to, why, capacity);
    replay_close(r);
    return s;
}

static dig_status record(const char *to, int frames, char *why, size_t capacity)
{
    Recorder *r;
    DIG_TRY(recorder_open(to, world, "{}", &r, why, capacity));
    dig_status s = DIG_OK;
    for (int i = 0; i < frames && s == DIG_OK; i++)
        s = recorder_step(r);
    dig_status end = recorder_close(r, why, capacity);
    return s != DIG_OK ? s : end;
}

static dig_status write_short_replay(const char *to, char *why, size_t capacity) { return record(to, 20, why, capacity); }
static dig_status write_long_replay(const char *to, char *why, size_t capacity) { return record(to, 600, why, capacity); }

static dig_status write_manifest(const char *to, char *why, size_t capacity)
{
    char head[] = "# digbox frames 1\n";
    ManifestFrame frames[3];
    Manifest m = {.head = head, .frames = frames, .count = 3, .end = 3};
    for (int i = 0; i < 3; i++) {
        frames[i] = (ManifestFrame){.index = i, .size = 9, .world = "0123456789abcdef", .scene = "0123456789abcdef", .name = "a.png"};
        manifest_sum("abc", (size_t)i, frames[i].sum);
    }
    return manifest_rewrite(to, &m, why, capacity);
}

typedef dig_status Writer(const char *to, char *why, size_t capacity);

static int files_in_folder(void)
{
    int count = 0;
    DIR *d = opendir(folder);
    CHECK(d != NULL);
    for (const struct dirent *e; (e = readdir(d));)
        count += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return count;
}

static bool same(Bytes a, Bytes b) { return a.size == b.size && memcmp(a.data, b.data, a.size) == 0; }

/* Of a replay whose file is neither the old one nor the whole new one: does it open, to its last whole block? */
static void check_cut(const char *what, int least)
{
    char why[600] = "";
    Replay *r;
    if (replay_open(path, &r, why, sizeof why) != DIG_OK)
        fail_msg("%s, %d of call %d: %s", what, fault.at, (int)fault.call, why);
    CHECK(replay_info(r)->cut && replay_info(r)->frames >= least);
    replay_close(r);
}

/* One point: false when there is no such call any more. */
static bool try_point(const char *what, Writer *writer, Bytes old, Bytes new, int least)
{
    char why[1400] = "";
    write_bytes(path, old.data, old.size);
    fault.count = 0;
    fault.fired = false;
    fault.armed = true;
    dig_status s = writer(path, why, sizeof why);
    fault.armed = false;
    bool harmless = fault.call == SHORT || fault.call == INTERRUPTED || !fault.fired;
    bool late = fault.call == CLOSE && s == DIG_OK;         /* the file was whole, closed once, and had its name */
    if (harmless != (s == DIG_OK) && !late)
        fail_msg("%s, %d of call %d (%s): gives %s: %s", what, fault.at, (int)fault.call, fault.goes_on ? "on" : "once", dig_status_name(s), why);
    if (s != DIG_OK && (s != DIG_E_FILE || !strstr(why, path) || !strstr(why, strerror(fault.error))))
        fail_msg("%s, %d of call %d: \"%s\" lacks \"%s\" or the path", what, fault.at, (int)fault.call, why, strerror(fault.error));
    Bytes is = read_bytes(path);
    if (!same(is, new) && (s == DIG_OK || !same(is, old))) {
        if (least == 0 || s == DIG_OK)
            fail_msg("%s, %d of call %d: %zu bytes, neither the old file nor the new one", what, fault.at, (int)fault.call, is.size);
        check_cut(what, least);
    }
    free(is.data);
    CHECK_INT(files_in_folder(), 1);
    return fault.fired;
}

/* `least`: so many frames has what is left of a replay whose first block was written; 0: nothing is ever left in part */
static void try_all(const char *what, Writer *writer, int least)
{
    static const int errors[] = {ENOSPC, EIO, EDQUOT, EROFS, EACCES};
    char why[600] = "";
    if (writer(path, why, sizeof why) != DIG_OK)
        fail_msg("%s: %s", what, why);
    Bytes new = read_bytes(path), old = {(unsigned char *)(uintptr_t)"what was there", 14};
    for (int call = OPEN; call < CALLS; call++)
        for (int goes_on = 0; goes_on < 2; goes_on++) {
            int n = 0;
            fault.call = (Call)call;
            fault.goes_on = goes_on && call != INTERRUPTED;         /* a call that is interrupted for ever never ends */
            do {
                fault.at = ++n;
                fault.error = errors[n % 5];
            } while (try_point(what, writer, old, new, least) && n < 1000);
            if (n < 2 || n == 1000)
                fail_msg("%s: call %d failed %d times", what, call, n - 1);
        }
    free(new.data);
    CHECK_INT(remove(path), 0);
}

TEST(bytes) { try_all("bytes", write_bytes_of, 0); }
TEST(saved_worlds) { try_all("a saved world", write_save, 0); }
TEST(exports) { try_all("an export", write_export, 0); }
TEST(manifests) { try_all("a manifest", write_manifest, 0); }
TEST(replays) { try_all("a replay", write_short_replay, 21); }
TEST(replays_of_many_blocks) { try_all("a long replay", write_long_replay, 256); }

/* ---- drafts ---------------------------------------------------------------------------------- */

static void make_draft(char *name, size_t capacity, const char *end)
{
    snprintf(name, capacity, "%s/%s", folder, end);
    write_bytes(name, (const unsigned char *)"torn", 4);
}

TEST(drafts_that_nobody_writes_are_swept_away)
{
    char torn[400], busy[400], other[400], why[600] = "";
    FileDraft d;
    make_draft(torn, sizeof torn, ".digbox-1-0-a.png.tmp");
    make_draft(busy, sizeof busy, ".digbox-2-0-a.png.tmp");
    make_draft(other, sizeof other, ".digbox-3-a.png");
    int handle = open(busy, O_RDONLY);
    CHECK(flock(handle, LOCK_EX) == 0);
    CHECK_INT(file_draft(path, &d, why, sizeof why), DIG_OK);
    CHECK_INT(file_sweep(folder), 1);
    CHECK(access(torn, F_OK) != 0 && access(busy, F_OK) == 0 && access(other, F_OK) == 0 && access(d.name, F_OK) == 0);
    CHECK_INT(file_draft_place(&d, path, FILE_QUICK, why, sizeof why), DIG_OK);
    CHECK_INT(access(path, F_OK), 0);
    close(handle);
    CHECK_INT(file_sweep(folder), 1);
    CHECK_INT(file_sweep("no/such/folder"), 0);
    CHECK(remove(other) == 0 && remove(path) == 0);
}

TEST(what_is_no_file_is_not_replaced)
{
    char why[600] = "";
    CHECK_INT(symlink("/dev/null", path), 0);
    CHECK_INT(write_bytes_of(path, why, sizeof why), DIG_E_FILE);
    CHECK(strstr(why, "is not an ordinary file"));
    CHECK_INT(unlink(path), 0);
    CHECK_INT(write_bytes_of(folder, why, sizeof why), DIG_E_FILE);
}

static int begin(void **state)
{
    (void)state;
    char why[600] = "";
    scratch_path(folder, sizeof folder, "files");
    snprintf(path, sizeof path, "%s/file", folder);
    scratch_path(source, sizeof source, "source.replay");
    world = open_small_scene();
    return mkdir(folder, 0700) == 0 && record(source, 20, why, sizeof why) == DIG_OK ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    dig_world_close(world);
    return remove(source) == 0 && rmdir(folder) == 0 ? 0 : -1;         /* fails when a test left a file behind */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(bytes), unit_test(saved_worlds), unit_test(exports), unit_test(manifests), unit_test(replays),
        unit_test(replays_of_many_blocks), unit_test(drafts_that_nobody_writes_are_swept_away), unit_test(what_is_no_file_is_not_replaced),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
