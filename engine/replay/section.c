/* replay/section.c - finds the sections of a replay and brings them into memory, trusting nothing that the file says. */
#define _POSIX_C_SOURCE 200809L     /* pread */

#include "replay/inside.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

dig_status replay_fail(Replay *r, dig_status s, const char *format, ...)
{
    va_list args;
    int n = snprintf(r->why, sizeof r->why, "%s: ", r->path);
    va_start(args, format);
    vsnprintf(r->why + n, sizeof r->why - (size_t)n, format, args);
    va_end(args);
    return s;
}

/* ---- bytes of the file ---- */

static dig_status read_at(Replay *r, uint64_t at, void *to, size_t size)
{
    char *out = to, text[128] = "";
    while (size > 0) {
        ssize_t n = pread(r->file, out, size, (off_t)at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 && strerror_r(errno, text, sizeof text) != 0)
            snprintf(text, sizeof text, "error %d", errno);
        if (n <= 0)
            return replay_fail(r, DIG_E_FILE, "cannot be read: %s", n < 0 ? text : "it became shorter meanwhile");
        out += n;
        at += (uint64_t)n;
        size -= (size_t)n;
    }
    return DIG_OK;
}

void replay_unload(Loaded *l)
{
    free(l->data);
    *l = (Loaded){.section = -1};
}

static dig_status damaged(Replay *r, const Section *s, const char *how)
{
    return replay_fail(r, DIG_E_FORMAT, "section %.4s at byte %llu %s", s->tag, (unsigned long long)s->offset, how);
}

static dig_status unpack(Replay *r, const Section *s, unsigned char *packed, Loaded *to)
{
    if (libdeflate_crc32(0, packed, (size_t)s->size) != s->crc)
        return damaged(r, s, "is damaged (checksum)");
    if (!s->packed) {
        memcpy(to->data, packed, (size_t)s->size);
        return DIG_OK;
    }
    size_t got = 0;
    if (libdeflate_deflate_decompress(r->decompressor, packed, (size_t)s->size, to->data, to->size, &got) != LIBDEFLATE_SUCCESS || got != to->size)
        return damaged(r, s, "cannot be unpacked");
    return DIG_OK;
}

dig_status replay_load(Replay *r, int section, Loaded *to)
{
    const Section *s = &r->sections.data[section];
    if (to->data && to->section == section)
        return DIG_OK;
    replay_unload(to);
    unsigned char *packed = malloc((size_t)s->size + 1);
    to->data = malloc((size_t)s->raw + 1);
    to->size = (size_t)s->raw;
    dig_status status = packed && to->data ? DIG_OK : replay_fail(r, DIG_E_MEMORY, "not enough memory for %llu bytes", (unsigned long long)s->raw);
    if (status == DIG_OK)
        status = read_at(r, s->offset + SECTION_HEADER, packed, (size_t)s->size);
    if (status == DIG_OK)
        status = unpack(r, s, packed, to);
    free(packed);
    if (status == DIG_OK)
        to->section = section;
    else
        replay_unload(to);
    return status;
}

/* ---- which sections there are ---- */

/* Sizes and frames of a section that may lie at its offset; `end`: where the last section must end. */
static bool section_fits(const Section *s, uint64_t end)
{
    return s->packed <= 1 && s->offset <= end && end - s->offset >= SECTION_HEADER && s->size <= end - s->offset - SECTION_HEADER &&
           (s->packed ? s->raw <= (s->size + 1) * DEFLATE_RATIO : s->raw == s->size) && s->first <= INT32_MAX / 2 && s->count <= INT32_MAX / 2;
}

static dig_status add_section(Replay *r, const Section *s)
{
    if (list_push(&r->sections, NULL) != DIG_OK)
        return replay_fail(r, DIG_E_MEMORY, "not enough memory");
    r->sections.data[r->sections.count - 1] = *s;
    return DIG_OK;
}

/* The index at the end. *found false: there is none that can be used, which is no failure. */
static dig_status read_index(Replay *r, bool *found)
{
    unsigned char bytes[REPLAY_TRAILER], head[SECTION_HEADER], magic[8];
    uint64_t at = 0;
    uint32_t format = 0, crc = 0;
    Section s = {0};
    *found = false;
    if (r->size < REPLAY_HEADER + SECTION_HEADER + REPLAY_TRAILER)
        return DIG_OK;
    DIG_TRY(read_at(r, r->size - REPLAY_TRAILER, bytes, sizeof bytes));
    Pack p = pack_reader(bytes, sizeof bytes);
    pack_u64(&p, &at);
    pack_u32(&p, &format);
    pack_u32(&p, &crc);
    pack_bytes(&p, magic, sizeof magic);
    if (memcmp(magic, replay_end_magic, sizeof magic) != 0 || crc != libdeflate_crc32(0, bytes, 12) || at < REPLAY_HEADER ||
        at > r->size - REPLAY_TRAILER - SECTION_HEADER)
        return DIG_OK;
    DIG_TRY(read_at(r, at, head, sizeof head));
    p = pack_reader(head, sizeof head);
    section_header(&p, &s);
    s.offset = at;
    if (!pack_good(&p) || memcmp(s.tag, "INDX", 4) != 0 || !section_fits(&s, r->size - REPLAY_TRAILER))
        return DIG_OK;
    Loaded index = {.section = -1};
    DIG_TRY(add_section(r, &s));
    dig_status status = replay_load(r, 0, &index);
    r->sections.count = 0;
    if (status == DIG_E_FORMAT)
        return DIG_OK;
    DIG_TRY(status);
    p = pack_reader(index.data, index.size);
    while (status == DIG_OK && pack_good(&p) && p.at < p.size) {
        section_header(&p, &s);
        pack_u64(&p, &s.offset);
        if (pack_check(&p, s.offset >= REPLAY_HEADER && section_fits(&s, at), "a section lies outside"))
            status = add_section(r, &s);
    }
    *found = pack_good(&p);
    if (!*found)
        r->sections.count = 0;
    replay_unload(&index);
    return status;
}

/* From section to section, as far as they are whole. */
static dig_status walk(Replay *r)
{
    uint64_t at = REPLAY_HEADER;
    unsigned char head[SECTION_HEADER];
    while (r->size - at >= SECTION_HEADER) {
        Section s = {0};
        DIG_TRY(read_at(r, at, head, sizeof head));
        Pack p = pack_reader(head, sizeof head);
        section_header(&p, &s);
        s.offset = at;
        if (!pack_good(&p) || !section_fits(&s, r->size))
            break;
        DIG_TRY(add_section(r, &s));
        at += SECTION_HEADER + s.size;
    }
    return DIG_OK;
}

/* Blocks must follow each other from frame 0 on; what comes after a gap cannot be used. */
static dig_status find_blocks(Replay *r)
{
    uint32_t next = 0;
    for (int i = 0; i < r->sections.count; i++) {
        const Section *s = &r->sections.data[i];
        if (memcmp(s->tag, "FRAM", 4) != 0)
            continue;
        if (s->first != next || s->count == 0 || s->count > s->raw || s->count > INT32_MAX / 2 - next) {
            r->info.cut = true;
            break;
        }
        if (list_push(&r->blocks, NULL) != DIG_OK)
            return replay_fail(r, DIG_E_MEMORY, "not enough memory");
        r->blocks.data[r->blocks.count - 1] = i;
        next += s->count;
    }
    r->info.frames = (int)next;
    return DIG_OK;
}

dig_status replay_find_sections(Replay *r)
{
    bool found;
    DIG_TRY(read_index(r, &found));
    r->info.cut = !found;
    if (!found)
        DIG_TRY(walk(r));
    DIG_TRY(find_blocks(r));
    if (r->info.frames == 0)
        return replay_fail(r, DIG_E_FORMAT, "file ends after %llu bytes, before its first frame", (unsigned long long)r->size);
    return DIG_OK;
}
