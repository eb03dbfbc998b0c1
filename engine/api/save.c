/* api/save.c - saving a world to a file and loading it: header, table of sections, order of things.
 *
 * The file, all numbers little-endian:
 *
 *    0  magic, 8 bytes: 0x89 "DIGBOX" 0x0A
 *    8  u32 format, 12 u32 bytes of the header, 16 u64 bytes of the file
 *   24  version of the program that made it, 16 bytes, zero-filled
 *   40  u32 number of sections
 *   44  per section: 4 bytes name, u32 CRC-32, u64 offset, u64 bytes
 *       u32 CRC-32 of the header up to here
 *       the sections, in order and without gaps
 *
 * The first 24 bytes stay where they are in every format to come.
 */
#include "api/save.h"
#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>

static const struct { char name[5]; void (*pack)(Pack *p, World *w); } sections[] = {
    {"WRLD", save_settings}, {"MATE", save_materials}, {"BODY", save_bodies}, {"SOLI", save_solids}, {"JOIN", save_joints},
    {"PAIR", save_pairs},    {"TOUC", save_touches},   {"ACTS", save_acts},   {"LIST", save_lists},  {"TREE", save_tree},
    {"DIGS", save_graph},    {"LAYR", save_layers},    {"EVNT", save_events},  {"MESG", save_messages}, {"MAIL", save_mail},
    {"EFFE", save_effects}, {"NOTE", save_note},
};

enum {
    SECTIONS = sizeof sections / sizeof *sections,
    STABLE_BYTES = 24, VERSION_BYTES = 16, FIXED_BYTES = 44, ENTRY_BYTES = 24,
    HEADER_BYTES = FIXED_BYTES + SECTIONS * ENTRY_BYTES + 4,
    PACKED = 60, BYTES_READ = 4,        /* world_work: units for each thing that is written, bytes that are read for one */
};

static const unsigned char magic[8] = {0x89, 'D', 'I', 'G', 'B', 'O', 'X', '\n'};

typedef struct Entry { char name[4]; uint32_t crc; uint64_t offset, size; } Entry;

typedef struct Header {
    unsigned char magic[8];
    uint32_t format, bytes;
    uint64_t file_size;
    char     version[VERSION_BYTES];
    uint32_t count;
    Entry    entries[SECTIONS];
    uint32_t crc;
} Header;

/* All but the checksum. */
static void pack_header(Pack *p, Header *h)
{
    pack_bytes(p, h->magic, sizeof h->magic);
    pack_u32(p, &h->format);
    pack_u32(p, &h->bytes);
    pack_u64(p, &h->file_size);
    pack_bytes(p, h->version, sizeof h->version);
    pack_u32(p, &h->count);
    for (int i = 0; i < SECTIONS; i++) {
        Entry *e = &h->entries[i];
        pack_bytes(p, e->name, sizeof e->name);
        pack_u32(p, &e->crc);
        pack_u64(p, &e->offset);
        pack_u64(p, &e->size);
    }
}

/* ---- saving ---- */

/* The sections one after the other, and what the header says of them. */
static void write_sections(Pack *all, World *w, Header *h)
{
    for (int i = 0; i < SECTIONS && pack_good(all); i++) {
        size_t start = all->size;
        if (i == 0)
            save_def(all, &w->def);
        sections[i].pack(all, w);
        if (!pack_good(all))
            return;
        Entry *e = &h->entries[i];
        memcpy(e->name, sections[i].name, sizeof e->name);
        e->offset = HEADER_BYTES + start;
        e->size = all->size - start;
        e->crc = pack_crc32(all->data + start, all->size - start);
    }
}

static void write_file(Pack *file, World *w)
{
    world_work_through(w, PACKED);
    Header h = {.format = SAVE_FORMAT, .bytes = HEADER_BYTES, .version = DIGBOX_VERSION, .count = SECTIONS};
    Pack all = pack_writer();
    memcpy(h.magic, magic, sizeof magic);
    write_sections(&all, w, &h);
    h.file_size = HEADER_BYTES + all.size;
    pack_header(file, &h);
    if (pack_good(file))
        h.crc = pack_crc32(file->data, file->size);
    pack_u32(file, &h.crc);
    if (pack_good(&all))
        pack_bytes(file, all.data, all.size);
    else if (all.no_memory)
        pack_fail_memory(file);
    else
        pack_fail(file, "%.150s", all.why);
    pack_close(&all);
}

dig_status dig_world_save(dig_world *w, const char *path)
{
    char why[sizeof w->error];
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "world:save() cannot be called while the world is stepping");
    if (!path || !path[0])
        return world_fail(w, DIG_E_ARG, "save: no path was given");
    Pack file = pack_writer();
    write_file(&file, w);
    dig_status s = pack_good(&file) ? DIG_OK : file.no_memory ? DIG_E_MEMORY : DIG_E_FORMAT;
    if (s != DIG_OK)
        world_fail(w, s, "%s: %s", path, file.why);
    else if ((s = file_replace(path, file.data, file.size, FILE_DURABLE, why, sizeof why)) != DIG_OK)
        world_fail(w, s, "%s", why);
    pack_close(&file);
    return s;
}

dig_status dig_world_pack(dig_world *w, void **bytes, size_t *size)
{
    Pack file = pack_writer();
    *bytes = NULL;
    *size = 0;
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "a world cannot be packed while it is stepping");
    write_file(&file, w);
    if (pack_good(&file)) {
        *bytes = file.data;
        *size = file.size;
        return DIG_OK;
    }
    dig_status s = world_fail(w, file.no_memory ? DIG_E_MEMORY : DIG_E_FORMAT, "%s", file.why);
    pack_close(&file);
    return s;
}

/* ---- loading ---- */

typedef struct Loader {
    const char *path;           /* or what stands for it      */
    char       *why;
    size_t      capacity;
    uint32_t    gen_start;      /* of its handles; 0 = any    */
} Loader;

static dig_status refuse(const Loader *l, dig_status s, const char *format, ...) DIG_PRINTF(3, 4);
static dig_status refuse(const Loader *l, dig_status s, const char *format, ...)
{
    va_list args;
    int n = snprintf(l->why, l->capacity, "%s: ", l->path);
    va_start(args, format);
    if (n >= 0 && (size_t)n < l->capacity)
        vsnprintf(l->why + n, l->capacity - (size_t)n, format, args);
    va_end(args);
    return s;
}

/* The program's name for itself, as far as it can be printed. */
static void read_version(const unsigned char *start, size_t got, char version[VERSION_BYTES + 1])
{
    size_t n = 0;
    for (size_t i = STABLE_BYTES; i < got && n < VERSION_BYTES && start[i] > ' ' && start[i] < 0x7f; i++)
        version[n++] = (char)start[i];
    version[n] = '\0';
}

/* From the part of the header that every format has. */
static dig_status look_at_start(void *context, const unsigned char *start, size_t got, uint64_t size)
{
    const Loader *l = context;
    char version[VERSION_BYTES + 1];
    Header h;
    Pack p = pack_reader(start, got);
    if (memcmp(start, magic, got < sizeof magic ? got : sizeof magic) != 0)
        return refuse(l, DIG_E_FORMAT, "this is not a world of digbox");
    if (got < STABLE_BYTES)
        return refuse(l, DIG_E_FORMAT, "file ends after %zu bytes, in its header", got);
    pack_bytes(&p, h.magic, sizeof h.magic);
    pack_u32(&p, &h.format);
    pack_u32(&p, &h.bytes);
    pack_u64(&p, &h.file_size);
    read_version(start, got, version);
    if (h.format != SAVE_FORMAT)
        return refuse(l, DIG_E_FORMAT, "made by digbox %s (format %u); this is %s (format %u)", version, h.format, DIGBOX_VERSION, SAVE_FORMAT);
    if (size < h.file_size)
        return refuse(l, DIG_E_FORMAT, "file ends after %llu of %llu bytes", (unsigned long long)size, (unsigned long long)h.file_size);
    if (size > h.file_size)
        return refuse(l, DIG_E_FORMAT, "file has %llu bytes, its header says %llu", (unsigned long long)size, (unsigned long long)h.file_size);
    if (h.bytes != HEADER_BYTES || size < HEADER_BYTES)
        return refuse(l, DIG_E_FORMAT, "its header has %u bytes, must be %u", h.bytes, (unsigned)HEADER_BYTES);
    return DIG_OK;
}

/* Sections lie one behind the other and fill the file. */
static dig_status read_header(const Loader *l, const unsigned char *data, size_t size, Header *h)
{
    Pack p = pack_reader(data, HEADER_BYTES);
    pack_header(&p, h);
    pack_u32(&p, &h->crc);
    if (pack_crc32(data, HEADER_BYTES - 4) != h->crc)
        return refuse(l, DIG_E_FORMAT, "its header is damaged (checksum)");
    uint64_t end = HEADER_BYTES;
    if (h->count != SECTIONS)
        return refuse(l, DIG_E_FORMAT, "it has %u sections, must have %u", h->count, (unsigned)SECTIONS);
    for (int i = 0; i < SECTIONS; i++) {
        const Entry *e = &h->entries[i];
        if (memcmp(e->name, sections[i].name, sizeof e->name) != 0 || e->offset != end || e->size > size - end)
            return refuse(l, DIG_E_FORMAT, "section %s is not where it should be", sections[i].name);
        end += e->size;
    }
    if (end != size)
        return refuse(l, DIG_E_FORMAT, "%llu bytes follow its last section", (unsigned long long)(size - end));
    for (int i = 0; i < SECTIONS; i++)
        if (pack_crc32(data + h->entries[i].offset, (size_t)h->entries[i].size) != h->entries[i].crc)
            return refuse(l, DIG_E_FORMAT, "section %s is damaged (checksum)", sections[i].name);
    return DIG_OK;
}

static dig_status section_failed(const Loader *l, const char *name, const Pack *p)
{
    if (p->no_memory)
        return refuse(l, DIG_E_MEMORY, "not enough memory");
    return refuse(l, DIG_E_FORMAT, "section %s: %s", name, p->why);
}

/* The world is opened with no gravity and given its own: it may be more than a new one is given. */
static dig_status open_saved(const Loader *l, Pack *p, World **w)
{
    char why[256];
    dig_world_def def = dig_world_defaults();
    save_def(p, &def);
    if (!pack_good(p))
        return section_failed(l, sections[0].name, p);
    vec3 gravity = def.gravity;
    def.gravity = vec3_zero();
    dig_status s = dig_world_open(&def, w, why, sizeof why);
    if (s != DIG_OK)
        return refuse(l, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "section %s: %s", sections[0].name, why);
    (*w)->def.gravity = gravity;
    (*w)->gen_start = l->gen_start ? l->gen_start : (*w)->gen_start;
    return DIG_OK;
}

static dig_status read_sections(const Loader *l, const unsigned char *data, const Header *h, World **w)
{
    for (int i = 0; i < SECTIONS; i++) {
        Pack p = pack_reader(data + h->entries[i].offset, (size_t)h->entries[i].size);
        if (i == 0)
            DIG_TRY(open_saved(l, &p, w));
        sections[i].pack(&p, *w);
        pack_end(&p);
        if (!pack_good(&p))
            return section_failed(l, sections[i].name, &p);
    }
    Pack p = pack_reader(NULL, 0);
    save_connect(&p, *w);
    if (pack_good(&p))
        return DIG_OK;
    return p.no_memory ? refuse(l, DIG_E_MEMORY, "not enough memory") : refuse(l, DIG_E_FORMAT, "%s", p.why);
}

static dig_status read_world(const Loader *l, const unsigned char *data, size_t size, World **out)
{
    Header h;
    World *w = NULL;
    dig_status s = read_header(l, data, size, &h);
    if (s == DIG_OK)
        s = read_sections(l, data, &h, &w);
    if (s == DIG_OK) {
        world_work(w, size / BYTES_READ);
        *out = w;
    } else {
        dig_world_close(w);
    }
    return s;
}

dig_status dig_world_load(const char *path, dig_world **out, char *why, size_t capacity)
{
    Loader l = {.path = path ? path : "", .why = why, .capacity = capacity};
    unsigned char *data;
    size_t size;
    *out = NULL;
    if (!path || !path[0])
        return refuse(&l, DIG_E_ARG, "load: no path was given");
    DIG_TRY(file_read(path, look_at_start, &l, &data, &size, why, capacity));
    dig_status s = read_world(&l, data, size, out);
    free(data);
    return s;
}

dig_status save_read(const void *bytes, size_t size, uint32_t gen_start, World **out, char *why, size_t capacity)
{
    Loader l = {"the world", why, capacity, gen_start};
    *out = NULL;
    DIG_TRY(look_at_start(&l, bytes, size < FILE_START ? size : FILE_START, size));
    return read_world(&l, bytes, size, out);
}

dig_status dig_world_unpack(const void *bytes, size_t size, dig_world **out, char *why, size_t capacity)
{
    return save_read(bytes, size, 0, out, why, capacity);
}
