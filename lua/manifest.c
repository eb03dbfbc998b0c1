/* lua/manifest.c - the list beside the frames of a film, read with suspicion and written whole. */

#define _POSIX_C_SOURCE 200809L     /* pread, fstat */

#include "manifest.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nettle/sha2.h>

#include "base/file.h"
#include "base/text.h"

static const char magic[] = "# digbox frames 1\n";
enum { MOST_BYTES = 1 << 28 };

/* ---- sums ------------------------------------------------------------------------ */

static void print_sum(struct sha256_ctx *c, char sum[MANIFEST_SUM])
{
    uint8_t digest[SHA256_DIGEST_SIZE];
    sha256_digest(c, sizeof digest, digest);
    for (size_t i = 0; i < sizeof digest; i++)
        snprintf(sum + 2 * i, 3, "%02x", digest[i]);
}

void manifest_sum(const void *data, size_t size, char sum[MANIFEST_SUM])
{
    struct sha256_ctx c;
    sha256_init(&c);
    sha256_update(&c, size, data);
    print_sum(&c, sum);
}

dig_status manifest_sum_file(const char *path, char sum[MANIFEST_SUM], uint64_t *size, char *why, size_t capacity)
{
    struct sha256_ctx c;
    struct stat info;
    uint8_t part[65536];
    ssize_t n = -1;
    int handle = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);         /* a pipe must not hang */
    bool ordinary = handle >= 0 && fstat(handle, &info) == 0 && S_ISREG(info.st_mode);
    *size = 0;
    sha256_init(&c);
    while (ordinary && ((n = read(handle, part, sizeof part)) > 0 || (n < 0 && errno == EINTR)))
        if (n > 0) {
            sha256_update(&c, (size_t)n, part);
            *size += (uint64_t)n;
        }
    print_sum(&c, sum);
    if (n < 0)
        snprintf(why, capacity, "%s: %s", path, handle >= 0 && !ordinary ? "is no file" : strerror(errno));
    if (handle >= 0)
        close(handle);
    return n < 0 ? DIG_E_FILE : DIG_OK;
}

/* ---- lines ------------------------------------------------------------------------- */

/* Below the manifest's folder, and nothing that a terminal could act upon. */
static bool is_safe_name(const char *name)
{
    return !text_fault(name) && file_stays_below(name);
}

size_t manifest_print(const ManifestFrame *f, char text[MANIFEST_LINE])
{
    int length = snprintf(text, MANIFEST_LINE,
                          "# frame %lld: %" PRIu64 " bytes, step %" PRIu64 ", time %.17g, world %s, scene %s\n%s  %s\n",
                          f->index, f->size, f->step, f->time, f->world, f->scene, f->sum, f->name);
    return length > 0 && length < MANIFEST_LINE ? (size_t)length : 0;
}

/* Both lines of a frame, without their ends. What is printed again from what was read must be the same: no other spelling counts. */
static bool read_frame(const char *first, const char *second, ManifestFrame *f)
{
    char again[MANIFEST_LINE];
    *f = (ManifestFrame){0};
    static const char form[] = "# frame %lld: %" SCNu64 " bytes, step %" SCNu64 ", time %lg, world %16[0-9a-f], scene %16[0-9a-f]";
    if (sscanf(first, form, &f->index, &f->size, &f->step, &f->time, f->world, f->scene) != 6 || sscanf(second, "%64[0-9a-f]", f->sum) != 1)
        return false;
    f->name = strlen(second) > 66 ? second + 66 : "";
    if (f->index < 0 || !is_safe_name(f->name))
        return false;
    size_t length = manifest_print(f, again), head = strlen(first);
    return length == head + strlen(second) + 2 && memcmp(again, first, head) == 0 && memcmp(again + head + 1, second, strlen(second)) == 0;
}

static bool add_frame(Manifest *m, const ManifestFrame *f)
{
    if (m->count == m->capacity) {
        int capacity = 2 * m->capacity + 64;
        ManifestFrame *more = realloc(m->frames, (size_t)capacity * sizeof *more);
        if (!more)
            return false;
        m->frames = more;
        m->capacity = capacity;
    }
    m->frames[m->count++] = *f;
    return true;
}

/* ---- reading --------------------------------------------------------------------------- */

static int by_index(const void *a, const void *b)
{
    const ManifestFrame *p = a, *q = b;
    if (p->index != q->index)
        return p->index < q->index ? -1 : 1;
    return p->name < q->name ? -1 : p->name > q->name;      /* as they stand in the text */
}

long long manifest_first(const char *head)
{
    long long first;
    const char *line = strstr(head, "\n# frames: ");
    return line && sscanf(line, "\n# frames: %lld..", &first) == 1 && first > 0 ? first : 0;
}

/* In order of the frames; of several entries for one the last. */
static void sort_frames(Manifest *m)
{
    int kept = 0;
    m->in_order = true;
    for (int i = 0; i < m->count; i++)
        m->in_order = m->in_order && (i == 0 ? m->frames[i].index == m->first : m->frames[i].index == m->frames[i - 1].index + 1);
    if (m->in_order)
        return;
    qsort(m->frames, (size_t)m->count, sizeof *m->frames, by_index);
    for (int i = 0; i < m->count; i++)
        if (i + 1 == m->count || m->frames[i + 1].index != m->frames[i].index)
            m->frames[kept++] = m->frames[i];
    m->count = kept;
}

typedef struct Lines { char *at, *end; int number; } Lines;

/* The next line, its end cut off; NULL when no whole one is left. */
static char *next_line(Lines *l)
{
    char *line = l->at, *stop = memchr(line, '\n', (size_t)(l->end - line));
    if (!stop || memchr(line, '\0', (size_t)(stop - line)))
        return NULL;
    *stop = '\0';
    l->at = stop + 1;
    l->number++;
    return line;
}

/* The lines before the first frame. */
static bool read_head(Manifest *m, Lines *l)
{
    while (l->at < l->end && *l->at == '#' && strncmp(l->at, "# frame ", 8) != 0 && strncmp(l->at, "# end: ", 7) != 0) {
        char *line = next_line(l);
        if (!line)
            return false;
        line[strlen(line)] = '\n';
    }
    size_t size = (size_t)(l->at - m->text);
    m->head = malloc(size + 1);
    if (!m->head)
        return false;
    memcpy(m->head, m->text, size);
    m->head[size] = '\0';
    m->first = manifest_first(m->head);
    m->whole = size;
    return true;
}

/* All that is whole. False at a line that cannot be understood; l->number is its number. */
static bool read_frames(Manifest *m, Lines *l)
{
    ManifestFrame f;
    while (l->at < l->end) {
        char *first = next_line(l), *second;
        if (first && strncmp(first, "# end: ", 7) == 0)
            return sscanf(first, "# end: %lld frames", &m->end) == 1 && m->end >= 0 && l->at == l->end;
        second = first ? next_line(l) : NULL;
        if (!second) {
            m->torn = true;
            return true;
        }
        if (!read_frame(first, second, &f) || !add_frame(m, &f))
            return false;
        m->whole = (size_t)(l->at - m->text);
    }
    return true;
}

static dig_status parse(const char *path, Manifest *m, size_t size, char *why, size_t capacity)
{
    Lines l = {m->text, m->text + size, 0};
    if (size == 0)
        return DIG_OK;
    if (size < sizeof magic - 1 || memcmp(m->text, magic, sizeof magic - 1) != 0) {
        m->torn = size < sizeof magic - 1 && memcmp(m->text, magic, size) == 0;
        if (m->torn)
            return DIG_OK;
        snprintf(why, capacity, "%s: is no list of frames that this digbox knows", path);
        return DIG_E_FORMAT;
    }
    if (!read_head(m, &l)) {
        m->torn = true;                 /* the film was cut before its first frame */
        m->whole = 0;
        return DIG_OK;
    }
    if (!read_frames(m, &l)) {
        snprintf(why, capacity, "%s:%d: is not what digbox writes into a list of frames", path, l.number);
        return DIG_E_FORMAT;
    }
    sort_frames(m);
    return DIG_OK;
}

static bool read_bytes(int handle, char *text, size_t size)
{
    for (size_t got = 0; got < size;) {
        ssize_t n = pread(handle, text + got, size - got, (off_t)got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        got += (size_t)n;
    }
    return true;
}

dig_status manifest_read(int handle, const char *path, Manifest *m, char *why, size_t capacity)
{
    struct stat info;
    *m = (Manifest){.end = -1};
    if (fstat(handle, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > MOST_BYTES) {
        snprintf(why, capacity, "%s: is no list of frames", path);
        return DIG_E_FORMAT;
    }
    size_t size = (size_t)info.st_size;
    m->text = malloc(size + 1);
    if (!m->text) {
        snprintf(why, capacity, "%s: not enough memory", path);
        return DIG_E_MEMORY;
    }
    m->text[size] = '\0';
    if (!read_bytes(handle, m->text, size)) {
        snprintf(why, capacity, "%s: cannot be read: %s", path, strerror(errno));
        manifest_close(m);
        return DIG_E_FILE;
    }
    dig_status s = parse(path, m, size, why, capacity);
    if (s != DIG_OK)
        manifest_close(m);
    return s;
}

void manifest_close(Manifest *m)
{
    free(m->text);
    free(m->head);
    free(m->frames);
    *m = (Manifest){0};
}

const ManifestFrame *manifest_find(const Manifest *m, long long index)
{
    int low = 0, high = m->count;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (m->frames[middle].index < index)
            low = middle + 1;
        else
            high = middle;
    }
    return low < m->count && m->frames[low].index == index ? &m->frames[low] : NULL;
}

/* ---- writing ------------------------------------------------------------------------------- */

dig_status manifest_rewrite(const char *path, const Manifest *m, char *why, size_t capacity)
{
    char lines[MANIFEST_LINE];
    FileDraft d;
    DIG_TRY(file_draft(path, &d, why, capacity));
    DIG_TRY(file_draft_write(&d, path, m->head, strlen(m->head), why, capacity));
    for (int i = 0; i < m->count; i++)
        DIG_TRY(file_draft_write(&d, path, lines, manifest_print(&m->frames[i], lines), why, capacity));
    if (m->end >= 0) {
        int length = snprintf(lines, sizeof lines, "# end: %lld frames\n", m->end);
        DIG_TRY(file_draft_write(&d, path, lines, (size_t)length, why, capacity));
    }
    return file_draft_place(&d, path, FILE_DURABLE, why, capacity);
}

void manifest_path_of(const char *manifest, const char *name, char *path, size_t capacity)
{
    const char *slash = strrchr(manifest, '/');
    snprintf(path, capacity, "%.*s%s", slash ? (int)(slash - manifest) + 1 : 0, manifest, name);
}
