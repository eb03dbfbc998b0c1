/* lua/manifest.h - the list beside the frames of a film: which there are, their sizes, SHA-256, and the state of the world they show.
 *
 * Text that `sha256sum -c` reads: what it does not need stands in lines that begin with #. The film and all that its frames depend on
 * come first; then two lines for each frame, written at once when the frame has its name; at last `# end: N frames`, which a film that
 * was cut lacks. Of two entries for one frame the later one holds. docs/frames.md has the format.
 */
#ifndef DIGBOX_MANIFEST_H
#define DIGBOX_MANIFEST_H

#include <stdint.h>

#include "digbox.h"

enum { MANIFEST_SUM = 65, MANIFEST_LINE = 2048 };       /* bytes of a sum as text with its NUL; of the two lines of a frame */

typedef struct ManifestFrame {
    long long   index;
    uint64_t    size, step;     /* bytes; steps of the world                                */
    double      time;           /* s                                                        */
    char        world[17], scene[17];       /* checksum of the world; of camera and light   */
    char        sum[MANIFEST_SUM];
    const char *name;           /* from the manifest's folder                               */
} ManifestFrame;

typedef struct Manifest {       /* as read; zeros: nothing */
    char          *text, *head; /* head: the lines before the first frame                   */
    ManifestFrame *frames;      /* [count] by index, each once                              */
    int            count, capacity;
    size_t         whole;       /* bytes of the file up to the last whole frame             */
    bool           torn;        /* something stands behind it that is not whole             */
    long long      first;       /* number of its first frame: 0, but for a part of a film   */
    long long      end;         /* frames of a film that came to its end, -1 = it was cut   */
    bool           in_order;    /* as in the file                                           */
} Manifest;

/* An empty file reads as nothing. Fails at the first line that cannot be understood and is not the end of a file that was cut. */
dig_status manifest_read(int handle, const char *path, Manifest *m, char *why, size_t capacity);
void       manifest_close(Manifest *m);

/* Of a head: the number of the first frame. A part of a film says it in a line of its own, `# frames: A..B`; else 0. */
long long manifest_first(const char *head);

const ManifestFrame *manifest_find(const Manifest *m, long long index);

/* The two lines of a frame. Returns their length. */
size_t manifest_print(const ManifestFrame *f, char text[MANIFEST_LINE]);

/* All of it anew in the order of the frames. */
dig_status manifest_rewrite(const char *path, const Manifest *m, char *why, size_t capacity);

/* SHA-256 of bytes, and of a file: DIG_E_FILE when it cannot be read. */
void       manifest_sum(const void *data, size_t size, char sum[MANIFEST_SUM]);
dig_status manifest_sum_file(const char *path, char sum[MANIFEST_SUM], uint64_t *size, char *why, size_t capacity);

/* folder of the manifest + name */
void manifest_path_of(const char *manifest, const char *name, char *path, size_t capacity);

#endif
