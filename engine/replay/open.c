/* replay/open.c - opens a replay: its header, and the records of what there is: meshes, bodies, notes. */
#define _POSIX_C_SOURCE 200809L     /* open, fstat */

#include "replay/inside.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- records ---- */

static dig_status no_memory(Replay *r) { return replay_fail(r, DIG_E_MEMORY, "not enough memory"); }

static void read_meshes(Replay *r, Pack *p)
{
    while (pack_good(p) && p->at < p->size) {
        if (list_push(&r->meshes, NULL) != DIG_OK)
            pack_fail_memory(p);
        else
            replay_mesh(p, &r->meshes.data[r->meshes.count - 1]);
    }
}

static void read_birth(Replay *r, Pack *p)
{
    KeptBody b = {0};
    replay_kept_body(p, &b);
    uint32_t last = r->kept_bodies.count > 0 ? r->kept_bodies.data[r->kept_bodies.count - 1].born : 0;
    pack_check(p, b.index == (uint32_t)r->kept_bodies.count && b.born >= last, "bodies are not in their order");
    pack_check(p, b.gen != 0, "a body has no generation");
    if (!pack_good(p))
        return;
    if (list_push(&r->kept_bodies, NULL) != DIG_OK || list_push(&r->bodies, NULL) != DIG_OK ||
        map_put(&r->body_map, (MapKey){b.slot, b.gen, 0}, b.index) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    r->kept_bodies.data[b.index] = b;
    r->bodies.data[b.index] = (ReplayBody){.id = {b.slot, b.gen}, .kind = (dig_body_kind)b.kind, .mass = b.mass, .centre = b.centre,
                                           .born = (int)(b.born > INT32_MAX / 2 ? INT32_MAX / 2 : b.born), .died = INT32_MAX};
}

static void read_death(Replay *r, Pack *p)
{
    uint32_t index = 0, frame = 0;
    pack_u32(p, &index);
    pack_u32(p, &frame);
    pack_check(p, index < (uint32_t)r->bodies.count && frame <= INT32_MAX / 2 && (int)frame >= r->bodies.data[index].born, "a body dies that does not live");
    if (pack_good(p))
        r->bodies.data[index].died = (int)frame;
}

static void read_bodies(Replay *r, Pack *p)
{
    while (pack_good(p) && p->at < p->size) {
        uint8_t birth = 0;
        pack_small(p, &birth, 2, "kind of a record");
        if (pack_good(p) && birth)
            read_birth(r, p);
        else if (pack_good(p))
            read_death(r, p);
    }
}

static void read_notes(Replay *r, Pack *p)
{
    while (pack_good(p) && p->at < p->size) {
        Note n = {.order = r->orders++};
        uint32_t size = 0;
        pack_u32(p, &n.frame);
        pack_bytes(p, n.name, sizeof n.name);
        pack_u32(p, &size);
        pack_check(p, n.name[sizeof n.name - 1] == '\0', "the name of a note has no end");
        const unsigned char *from = pack_take(p, size);
        n.text = from ? malloc((size_t)size + 1) : NULL;
        if (!n.text || list_push(&r->notes, NULL) != DIG_OK) {
            free(n.text);
            pack_fail_memory(p);
            return;
        }
        memcpy(n.text, from, size);
        n.text[size] = '\0';
        r->notes.data[r->notes.count - 1] = n;
    }
}

static void read_origin(Replay *r, Pack *p)
{
    const unsigned char *from = pack_take(p, p->size);
    free(r->origin);
    r->origin = malloc(p->size + 1);
    if (!r->origin) {
        pack_fail_memory(p);
        return;
    }
    if (p->size > 0)
        memcpy(r->origin, from, p->size);
    r->origin[p->size] = '\0';
}

static int by_name(const void *a, const void *b)
{
    const Note *x = a, *y = b;
    int name = strcmp(x->name, y->name);
    if (name != 0)
        return name;
    return x->frame != y->frame ? (x->frame < y->frame ? -1 : 1) : x->order < y->order ? -1 : 1;
}

/* Bodies that were born after the last frame that is there do not count; nor do deaths then. */
static void settle_bodies(Replay *r)
{
    int frames = r->info.frames;
    while (r->bodies.count > 0 && r->bodies.data[r->bodies.count - 1].born >= frames)
        r->bodies.count--;
    for (int i = 0; i < r->bodies.count; i++) {
        ReplayBody *b = &r->bodies.data[i];
        const KeptBody *k = &r->kept_bodies.data[i];
        b->died = b->died > frames ? frames : b->died;
        b->name = k->name;
        b->material = k->material;
        b->shape = k->shape;
    }
    r->info.bodies = r->bodies.count;
}

dig_status replay_read_records(Replay *r)
{
    static const struct { char tag[5]; void (*read)(Replay *r, Pack *p); } readers[] = {
        {"ORIG", read_origin}, {"MESH", read_meshes}, {"BODY", read_bodies}, {"NOTE", read_notes},
    };
    Loaded l = {.section = -1};
    int last = r->blocks.data[r->blocks.count - 1];         /* what stands behind the last block belongs to none */
    for (int i = 0; i < last; i++)
        for (size_t k = 0; k < sizeof readers / sizeof *readers; k++) {
            if (memcmp(r->sections.data[i].tag, readers[k].tag, 4) != 0)
                continue;
            DIG_TRY(replay_load(r, i, &l));
            Pack p = pack_reader(l.data, l.size);
            readers[k].read(r, &p);
            replay_unload(&l);
            if (!pack_good(&p))
                return p.no_memory ? no_memory(r) : replay_fail(r, DIG_E_FORMAT, "section %s: %s", readers[k].tag, p.why);
        }
    if (r->notes.count > 1)
        qsort(r->notes.data, (size_t)r->notes.count, sizeof *r->notes.data, by_name);
    settle_bodies(r);
    return DIG_OK;
}

/* ---- opening ---- */

static dig_status read_header(Replay *r)
{
    unsigned char bytes[REPLAY_HEADER];
    uint32_t crc = 0;
    ssize_t got = pread(r->file, bytes, sizeof bytes, 0);
    size_t n = got < 0 ? 0 : (size_t)got;
    if (memcmp(bytes, replay_magic, n < 8 ? n : 8) != 0)
        return replay_fail(r, DIG_E_FORMAT, "this is not a replay of digbox (digbox run WORLD.lua --replay FILE writes one)");
    if (n < sizeof bytes)
        return replay_fail(r, DIG_E_FORMAT, "file ends after %zu bytes, in its header", n);
    Pack p = pack_reader(bytes, sizeof bytes);
    replay_header(&p, &r->header);
    pack_u32(&p, &crc);
    if (r->header.format != REPLAY_FORMAT)
        return replay_fail(r, DIG_E_FORMAT, "replay of format %u, but digbox %s reads format %u: record it again with digbox run --replay",
                           r->header.format, DIGBOX_VERSION, REPLAY_FORMAT);
    if (crc != libdeflate_crc32(0, bytes, sizeof bytes - 4))
        return replay_fail(r, DIG_E_FORMAT, "its header is damaged (checksum)");
    if (!pack_good(&p))
        return replay_fail(r, DIG_E_FORMAT, "%s", p.why);
    r->info.version = r->header.format;
    r->info.first_step = r->header.first_step;
    r->info.step = r->header.step;
    r->info.seed = r->header.seed;
    r->info.digbox = r->header.version;
    return DIG_OK;
}

static dig_status open_file(Replay *r)
{
    struct stat info;
    char text[128] = "";
    r->file = open(r->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);     /* a pipe must not hang */
    if (r->file < 0 || fstat(r->file, &info) != 0) {
        if (strerror_r(errno, text, sizeof text) != 0)
            snprintf(text, sizeof text, "error %d", errno);
        return replay_fail(r, DIG_E_FILE, "cannot be read: %s", text);
    }
    if (!S_ISREG(info.st_mode))
        return replay_fail(r, DIG_E_FILE, "cannot be read: it is no file");
    r->size = (uint64_t)info.st_size;
    r->decompressor = libdeflate_alloc_decompressor();
    return r->decompressor ? DIG_OK : no_memory(r);
}

dig_status replay_open(const char *path, Replay **out, char *why, size_t capacity)
{
    Replay *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r) {
        snprintf(why, capacity, "%s: not enough memory", path);
        return DIG_E_MEMORY;
    }
    r->block.section = r->commands.section = r->start.section = r->block_frame = r->before_frame = -1;
    r->file = -1;
    snprintf(r->path, sizeof r->path, "%s", path);
    dig_status s = open_file(r);
    if (s == DIG_OK)
        s = read_header(r);
    if (s == DIG_OK)
        s = replay_find_sections(r);
    if (s == DIG_OK)
        s = replay_read_records(r);
    r->info.origin = r->origin ? r->origin : "{}";
    if (s == DIG_OK) {
        *out = r;
        return DIG_OK;
    }
    snprintf(why, capacity, "%s", r->why);
    replay_close(r);
    return s;
}

void replay_close(Replay *r)
{
    if (!r)
        return;
    replay_unload(&r->block);
    replay_unload(&r->commands);
    replay_unload(&r->start);
    for (int i = 0; i < r->meshes.count; i++) {
        free(r->meshes.data[i].mesh.vertices);
        free(r->meshes.data[i].mesh.normals);
        free(r->meshes.data[i].mesh.indices);
    }
    for (int i = 0; i < r->notes.count; i++)
        free(r->notes.data[i].text);
    list_close(&r->meshes);
    list_close(&r->notes);
    list_close(&r->sections);
    list_close(&r->blocks);
    list_close(&r->kept_bodies);
    list_close(&r->bodies);
    list_close(&r->poses);
    list_close(&r->events);
    list_close(&r->links);
    list_close(&r->cameras);
    map_close(&r->body_map);
    kept_close(&r->now);
    kept_close(&r->before);
    free(r->origin);
    if (r->decompressor)
        libdeflate_free_decompressor(r->decompressor);
    if (r->file >= 0)
        close(r->file);
    free(r);
}

/* ---- what was read ---- */

const char *replay_error(const Replay *r) { return r->why; }
const ReplayInfo *replay_info(const Replay *r) { return &r->info; }

const ReplayBody *replay_body(const Replay *r, int index)
{
    return index >= 0 && index < r->bodies.count ? &r->bodies.data[index] : NULL;
}

int replay_body_of(const Replay *r, dig_body id)
{
    uint32_t index;
    return map_find(&r->body_map, (MapKey){id.slot, id.gen, 0}, &index) && index < (uint32_t)r->bodies.count ? (int)index : -1;
}

const char *replay_note(const Replay *r, const char *name, int frame, int *since)
{
    int low = 0, high = r->notes.count;         /* the first note that is after (name, frame) */
    while (low < high) {
        int mid = low + (high - low) / 2, order = strcmp(r->notes.data[mid].name, name);
        if (order < 0 || (order == 0 && frame >= 0 && r->notes.data[mid].frame <= (uint32_t)frame))
            low = mid + 1;
        else
            high = mid;
    }
    if (low == 0 || strcmp(r->notes.data[low - 1].name, name) != 0)
        return NULL;
    if (since)
        *since = (int)r->notes.data[low - 1].frame;
    return r->notes.data[low - 1].text;
}
