/* replay/writer.h - the file of a replay, and the frames on their way to it.
 *
 * The recorder, which the world waits for, copies the tables of each frame into a batch. The writer makes of them what changed, and
 * blocks of that, and puts these into the file; a thread runs it meanwhile. The bytes of the file depend on what was recorded only.
 *
 * The file has its name from its first whole block on: under it stands the old replay or one that opens.
 *
 * Owns:      a Writer its file, its batch and its block; whoever runs it owns the Writer meanwhile.
 * Invariant: what a block needs (meshes, bodies, notes) stands before it in the file.
 * Floor:     replay.
 */
#ifndef DIG_WRITER_H
#define DIG_WRITER_H

#include "base/file.h"
#include "replay/format.h"

/* In the order of the file: what a block needs stands before it. */
enum { PART_MESHES, PART_BODIES, PART_NOTES, PART_COMMANDS, PART_FRAMES, PARTS };

typedef struct Part { Pack bytes; uint32_t count; } Part;       /* count: records; of frames: frames; of commands: frames with some */

/* What stands in a batch before the rows of a record. */
typedef struct RecordHead {
    size_t   sizes[PART_FRAMES];        /* of the batch's parts before the record: what belongs to earlier frames */
    uint32_t counts[PART_FRAMES];
    uint32_t kind;                      /* RecordKind                                                             */
    int      rows[KEPT_TABLES];         /* ROWS_AS_BEFORE: those of the record before it, which are not given again */
} RecordHead;

#define ROWS_AS_BEFORE (-1)             /* for tables that seldom change: kept_seldom */

typedef struct Batch {
    Pack records;
    Part parts[PART_FRAMES];
} Batch;

typedef struct Writer {
    FileDraft draft;
    const char *path;           /* of who opened it                                  */
    bool     placed;            /* the draft has that name                           */
    uint64_t at, whole;         /* bytes written; those up to the end of the last block */
    Batch    batch;             /* to be written                                     */
    Kept     last;              /* the tables after the last record                  */
    Kept     given;             /* those that seldom change, as they were given last */
    Part     block[PARTS];
    uint32_t first;             /* frame of the block                                */
    LIST(Section) sections;
    struct libdeflate_compressor *compressor;
    void    *packed;            /* room for packing, `room` bytes                    */
    size_t   room;
    dig_status failed;
    char     why[200];          /* the first failure; nothing is written after it    */
} Writer;

static inline bool kept_seldom(int table) { return table == LOOK_BODIES || table == LOOK_SOLIDS; }

/* The path is kept as it is. */
dig_status writer_open(Writer *f, const char *path);
dig_status writer_bytes(Writer *f, const void *data, size_t size);
dig_status writer_section(Writer *f, const char *tag, uint32_t first, uint32_t count, const Pack *body);
/* Writes the frames of the batch, but for those of a block that is not full; the batch then is empty. */
void       writer_batch(Writer *f);
/* The last block, the index and the trailer, when nothing failed; closes the file. */
dig_status writer_finish(Writer *f);
void       writer_release(Writer *f);

#endif
