/* lua/verify_film.c - `digbox verify FOLDER`: are the frames of films as their manifests say? */

#define _XOPEN_SOURCE 700       /* scandir */

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "command.h"
#include "manifest.h"
#include "state.h"

static bool ends_in(const char *name, const char *end)
{
    size_t n = strlen(name), m = strlen(end);
    return n > m && strcmp(name + n - m, end) == 0;
}

bool verify_is_film(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && (S_ISDIR(info.st_mode) || ends_in(path, ".sha256"));
}

/* Whether that frame is as it was written; else says in what it differs. */
static bool check_frame(const char *manifest, const ManifestFrame *f, char *why, size_t capacity)
{
    char path[4096], sum[MANIFEST_SUM], reason[4400];
    uint64_t size;
    manifest_path_of(manifest, f->name, path, sizeof path);
    if (manifest_sum_file(path, sum, &size, reason, sizeof reason) != DIG_OK)
        snprintf(why, capacity, "frame %lld: %s", f->index, reason);
    else if (size != f->size)
        snprintf(why, capacity, "frame %lld: %s has %" PRIu64 " bytes, had %" PRIu64, f->index, path, size, f->size);
    else if (strcmp(sum, f->sum) != 0)
        snprintf(why, capacity, "frame %lld: %s is not what was written (SHA-256 %.12s..., was %.12s...)", f->index, path, sum, f->sum);
    else
        return true;
    return false;
}

/* The first frame that the list ought to have and has not, or -1. */
static long long first_gap(const Manifest *m)
{
    for (int i = 0; i < m->count; i++)
        if (m->frames[i].index != m->first + i)
            return m->first + i;
    return m->end > m->count ? m->first + m->count : -1;
}

static int check_frames(const char *path, const Manifest *m)
{
    char first[4600] = "", why[4600] = "";
    int bad = 0;
    uint64_t bytes = 0;
    long long gap = first_gap(m);
    for (int i = 0; i < m->count && !app_signal(); i++) {
        bytes += m->frames[i].size;
        if (!check_frame(path, &m->frames[i], bad ? why : first, sizeof why))
            bad++;
    }
    printf("%s: %d frame%s%s%s: ", path, m->count, m->count == 1 ? "" : "s", m->end < 0 ? " of a film that was cut" : "",
           m->torn ? ", whose last entry is torn" : "");
    if (bad)
        printf("%s%s", first, bad > 1 ? "; others differ, too" : "");
    else if (gap >= 0 && m->end >= 0)
        printf("frame %lld is missing", gap);
    else
        printf("all as they were written (%" PRIu64 " bytes)", bytes);
    if (gap >= 0 && m->end < 0)
        printf("; frame %lld is still to come", gap);
    printf("\n");
    return flush_output(bad || (gap >= 0 && m->end >= 0) ? EXIT_FORMAT : EXIT_FINE);
}

static int check_manifest(const char *path)
{
    char why[4400];
    Manifest m;
    int handle = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (handle < 0) {
        snprintf(why, sizeof why, "%s: %s", path, strerror(errno));
        say_error(why);
        return EXIT_FORMAT;
    }
    dig_status s = manifest_read(handle, path, &m, why, sizeof why);
    close(handle);
    if (s != DIG_OK) {
        say_error(why);
        return exit_code_of_reading(s);
    }
    int code = check_frames(path, &m);
    manifest_close(&m);
    return code;
}

static int is_manifest(const struct dirent *e)
{
    return ends_in(e->d_name, ".sha256") && strstr(e->d_name, "manifest") != NULL;
}

static int check_folder(const char *folder)
{
    struct dirent **entries;
    char path[4096];
    int worst = EXIT_FINE, n = scandir(folder, &entries, is_manifest, alphasort);
    for (int i = 0; i < n; i++) {
        const char *slash = folder[strlen(folder) - 1] == '/' ? "" : "/";
        if (snprintf(path, sizeof path, "%s%s%s", folder, slash, entries[i]->d_name) < (int)sizeof path) {
            int code = check_manifest(path);
            worst = code > worst ? code : worst;
        }
        free(entries[i]);
    }
    if (n >= 0)
        free(entries);
    if (n > 0)
        return worst;
    snprintf(path, sizeof path, "%.2000s: %s", folder, n < 0 ? strerror(errno) : "holds no film with a manifest (docs/frames.md)");
    say_error(path);
    return EXIT_FORMAT;
}

int verify_film(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode) ? check_folder(path) : check_manifest(path);
}
