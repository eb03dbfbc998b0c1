/* replay/writer.c - what changed from frame to frame, in blocks, into the file of a replay. Nothing here looks at the world. */
#define _POSIX_C_SOURCE 200809L     /* ftruncate, fsync, strerror_r */

#include "replay/writer.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#define BLOCK_BYTES  (1024u * 1024u)    /* a block is full with so many bytes before packing */
#define BLOCK_FRAMES 256u               /* or so many frames                                 */
#define LEVEL        1                  /* of deflate: higher ones gain a few per cent of doubles */
#define PIECES       8u                 /* so many pieces, ...                                            */
#define PIECE        2048u              /* ... each of so many bytes, are packed to see whether packing is worth its time */

static const char part_tags[PARTS][5] = {"MESH", "BODY", "NOTE", "CMDS", "FRAM"};

static const char cannot[] = "the replay cannot be written";

static dig_status fail(Writer *f, dig_status s, const char *what, int error)
{
    char text[100] = "";
    if (f->failed != DIG_OK)
        return f->failed;
    if (error != 0 && strerror_r(error, text, sizeof text) != 0)
        snprintf(text, sizeof text, "error %d", error);
    f->failed = s;
    snprintf(f->why, sizeof f->why, "%s%s%s", what, error != 0 ? ": " : "", text);
    return s;
}

static dig_status no_memory(Writer *f) { return fail(f, DIG_E_MEMORY, "not enough memory for the replay", 0); }

/* ---- bytes and sections ---- */

dig_status writer_bytes(Writer *f, const void *data, size_t size)
{
    int error = f->failed == DIG_OK ? file_write_all(f->draft.handle, data, size) : 0;
    if (error != 0)
        return fail(f, DIG_E_FILE, cannot, error);
    f->at += size;
    return f->failed;
}

static size_t pack_some(Writer *f, const unsigned char *from, size_t size, size_t most)
{
    if (f->room < size) {
        free(f->packed);
        f->packed = malloc(size);
        f->room = f->packed ? size : 0;
    }
    return f->packed ? libdeflate_deflate_compress(f->compressor, from, size, f->packed, most) : 0;
}

/* Deflate takes 40 instructions a byte, ten times what it cost to make these bytes; what moves freely loses a fifth by it and is left.
 * Tables follow each other in a frame and pack very differently, so pieces from all of the block say what is to be had. */
static bool worth_packing(Writer *f, const Pack *body)
{
    unsigned char some[PIECES * PIECE];
    if (body->size < 4 * sizeof some)
        return true;
    for (size_t i = 0; i < PIECES; i++)
        memcpy(some + i * PIECE, body->data + (2 * i + 1) * (body->size / (2 * PIECES)), PIECE);
    return pack_some(f, some, sizeof some, sizeof some - sizeof some / 4) > 0;
}

/* Bytes in f->packed, or 0: it stays as it is. */
static size_t pack_body(Writer *f, const Pack *body)
{
    return body->size > 64 && worth_packing(f, body) ? pack_some(f, body->data, body->size, body->size) : 0;
}

dig_status writer_section(Writer *f, const char *tag, uint32_t first, uint32_t count, const Pack *body)
{
    Section s = {.first = first, .count = count, .raw = body->size, .size = body->size, .offset = f->at};
    if (!pack_good(body))
        return fail(f, body->no_memory ? DIG_E_MEMORY : DIG_E_FORMAT, body->why, 0);
    memcpy(s.tag, tag, sizeof s.tag);
    size_t size = pack_body(f, body);
    const void *data = size > 0 ? f->packed : body->data;
    s.packed = size > 0;
    if (size > 0)
        s.size = size;
    s.crc = libdeflate_crc32(0, data, (size_t)s.size);
    Pack head = pack_writer();
    section_header(&head, &s);
    if (pack_good(&head) && list_push(&f->sections, NULL) == DIG_OK)
        f->sections.data[f->sections.count - 1] = s;
    else
        no_memory(f);
    writer_bytes(f, head.data, head.size);
    writer_bytes(f, data, (size_t)s.size);
    pack_close(&head);
    return f->failed;
}

/* ---- blocks ---- */

/* The file has something to show: it may have its name. */
static void give_name(Writer *f)
{
    if (f->failed != DIG_OK)
        return;
    if (!f->placed && rename(f->draft.name, f->path) != 0) {
        fail(f, DIG_E_FILE, cannot, errno);
        return;
    }
    f->placed = true;
    f->whole = f->at;
}

static void put_block(Writer *f)
{
    uint32_t frames = f->block[PART_FRAMES].count;
    if (f->block[PART_COMMANDS].count == 0)
        f->block[PART_COMMANDS].bytes.size = 0;
    f->block[PART_COMMANDS].count = frames;
    for (int i = 0; i < PARTS; i++) {
        Part *p = &f->block[i];
        if (f->failed == DIG_OK && (p->bytes.size > 0 || !pack_good(&p->bytes)))
            writer_section(f, part_tags[i], i >= PART_COMMANDS ? f->first : 0, p->count, &p->bytes);
        p->bytes.size = 0;
        p->count = 0;
    }
    f->first += frames;
    kept_clear(&f->last);           /* a block begins with all rows */
    give_name(f);
}

/* The batch's parts, from `done` on up to `head`, become those of the block. */
static void take_parts(Writer *f, RecordHead *done, const RecordHead *head)
{
    for (int i = 0; i < PART_FRAMES; i++) {
        if (head->sizes[i] > done->sizes[i])
            pack_bytes(&f->block[i].bytes, f->batch.parts[i].bytes.data + done->sizes[i], head->sizes[i] - done->sizes[i]);
        f->block[i].count += head->counts[i] - done->counts[i];
    }
    *done = *head;
}

static size_t bytes_of_rows(const RecordHead *head)
{
    size_t size = 0;
    for (int t = 0; t < KEPT_TABLES; t++)
        size += head->rows[t] > 0 ? (size_t)head->rows[t] * kept_row_size(t) : 0;
    return size;
}

static dig_status keep_given(Writer *f, int table, int count, const unsigned char *rows)
{
    DIG_TRY(kept_resize(&f->given, table, count));
    if (count > 0)
        memcpy(kept_table(&f->given, table)->data, rows, (size_t)count * kept_row_size(table));
    return DIG_OK;
}

static void write_tables(Writer *f, const RecordHead *head, const unsigned char *rows)
{
    Pack *to = &f->block[PART_FRAMES].bytes;
    for (int t = 0; t < KEPT_TABLES; t++) {
        int count = head->rows[t];
        if (count == ROWS_AS_BEFORE) {
            const ListAny *given = kept_table(&f->given, t);
            delta_write(to, t, given->count, given->data, &f->last);
            continue;
        }
        if (kept_seldom(t) && keep_given(f, t, count, rows) != DIG_OK)
            no_memory(f);
        delta_write(to, t, count, rows, &f->last);
        rows += (size_t)count * kept_row_size(t);
    }
}

void writer_batch(Writer *f)
{
    RecordHead head = {0}, done = {0};
    Part *frames = &f->block[PART_FRAMES];
    for (size_t at = 0; at < f->batch.records.size; at += sizeof head + bytes_of_rows(&head)) {
        memcpy(&head, f->batch.records.data + at, sizeof head);
        take_parts(f, &done, &head);
        if (head.kind == RECORD_FRAME && (frames->count >= BLOCK_FRAMES || frames->bytes.size >= BLOCK_BYTES))
            put_block(f);
        uint8_t kind = (uint8_t)head.kind;
        pack_u8(&frames->bytes, &kind);
        write_tables(f, &head, f->batch.records.data + at + sizeof head);
        frames->count += head.kind == RECORD_FRAME;
    }
    for (int i = 0; i < PART_FRAMES; i++) {
        Part *p = &f->batch.parts[i];
        head.sizes[i] = p->bytes.size;
        head.counts[i] = p->count;
        if (!pack_good(&p->bytes))
            no_memory(f);
    }
    take_parts(f, &done, &head);
    for (int i = 0; i < PART_FRAMES; i++)
        f->batch.parts[i].bytes.size = f->batch.parts[i].count = 0;
    f->batch.records.size = 0;
}

/* ---- beginning and end ---- */

/* A draft; what is no file (a device, a pipe, a link) is written as it is. */
static void open_file(Writer *f)
{
    char why[1400], text[160];
    struct stat info;
    if (lstat(f->path, &info) == 0 && !S_ISREG(info.st_mode)) {
        f->draft.handle = open(f->path, O_WRONLY | O_TRUNC | O_CLOEXEC);
        f->placed = true;
        if (f->draft.handle < 0)
            fail(f, DIG_E_FILE, cannot, errno);
    } else if (file_draft(f->path, &f->draft, why, sizeof why) != DIG_OK) {
        snprintf(text, sizeof text, "%s%.120s", cannot, why + strlen(f->path));
        fail(f, DIG_E_FILE, text, 0);
    }
}

dig_status writer_open(Writer *f, const char *path)
{
    f->draft.handle = -1;
    f->path = path;
    open_file(f);
    f->compressor = libdeflate_alloc_compressor(LEVEL);
    return f->compressor ? f->failed : no_memory(f);
}

static void put_index(Writer *f)
{
    Pack p = pack_writer(), end = pack_writer();
    uint64_t at = f->at;
    unsigned char magic[8];
    for (int i = 0; i < f->sections.count; i++) {
        section_header(&p, &f->sections.data[i]);
        pack_u64(&p, &f->sections.data[i].offset);
    }
    writer_section(f, "INDX", 0, (uint32_t)f->sections.count, &p);
    memcpy(magic, replay_end_magic, sizeof magic);
    pack_u64(&end, &at);
    pack_u32(&end, &(uint32_t){REPLAY_FORMAT});
    uint32_t crc = pack_good(&end) ? libdeflate_crc32(0, end.data, end.size) : 0;
    pack_u32(&end, &crc);
    pack_bytes(&end, magic, sizeof magic);
    if (!pack_good(&end))
        no_memory(f);
    writer_bytes(f, end.data, end.size);
    pack_close(&p);
    pack_close(&end);
}

/* Whole, on the disk; a failure may come as late as with close. */
static void close_file(Writer *f)
{
    if (fsync(f->draft.handle) != 0 && errno != EINVAL && errno != ENOTSUP) {   /* a file system that cannot */
        fail(f, DIG_E_FILE, cannot, errno);
        return;
    }
    int handle = f->draft.handle;
    f->draft.handle = -1;
    if (close(handle) != 0 && errno != EINTR)
        fail(f, DIG_E_FILE, cannot, errno);
}

dig_status writer_finish(Writer *f)
{
    if (f->failed == DIG_OK)
        put_block(f);
    if (f->failed == DIG_OK)
        put_index(f);
    if (f->failed == DIG_OK)
        close_file(f);
    return f->failed;
}

/* Of a file that could not be written whole blocks are left, or nothing. */
static void end_file(Writer *f)
{
    if (f->draft.handle < 0)
        return;
    if (!f->placed) {
        file_draft_drop(&f->draft);
        return;
    }
    if (f->failed == DIG_OK || ftruncate(f->draft.handle, (off_t)f->whole) == 0)
        (void)fsync(f->draft.handle);
    close(f->draft.handle);
}

void writer_release(Writer *f)
{
    for (int i = 0; i < PARTS; i++)
        pack_close(&f->block[i].bytes);
    for (int i = 0; i < PART_FRAMES; i++)
        pack_close(&f->batch.parts[i].bytes);
    pack_close(&f->batch.records);
    kept_close(&f->last);
    kept_close(&f->given);
    list_close(&f->sections);
    free(f->packed);
    if (f->compressor)
        libdeflate_free_compressor(f->compressor);
    end_file(f);
}
