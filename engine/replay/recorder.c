/* replay/recorder.c - writes a run into a replay while it happens.
 *
 * Frames gather in memory until a block is full; then what is new since the last block (meshes, bodies, notes, commands) and the
 * block itself are packed and written, in this order, so that a file that ends after a block lacks nothing that the block needs.
 * Packing costs more than gathering, and nobody waits for it: a thread does it while the world goes on. The bytes of the file
 * depend on what was recorded only.
 *
 * The file has its name from its first whole block on: under it stands the old replay or one that opens.
 */
#define _POSIX_C_SOURCE 200809L     /* ftruncate, fsync, strerror_r */

#include "api/api.h"
#include "base/file.h"
#include "replay/format.h"
#include "replay/replay.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#define BLOCK_BYTES  (1024u * 1024u)    /* a block is full with so many bytes before packing */
#define BLOCK_FRAMES 256u               /* or so many frames                                 */
#define LEVEL        1                  /* of deflate: higher ones gain a few per cent of doubles */

typedef struct Known { uint32_t gen, index; } Known;            /* the body in a slot; gen 0: none */
typedef struct NoteHash { char name[32]; uint64_t hash; } NoteHash;

/* In the order of the file: what a block needs stands before it. */
enum { PART_MESHES, PART_BODIES, PART_NOTES, PART_COMMANDS, PART_FRAMES, PARTS };
static const char part_tags[PARTS][5] = {"MESH", "BODY", "NOTE", "CMDS", "FRAM"};

typedef struct Part { Pack bytes; uint32_t first, count; } Part;      /* count: records; frames and commands: frames */

/* The file, and a block on its way to it. Belongs to the thread while one runs. */
typedef struct Writer {
    FileDraft draft;
    const char *path;           /* of the recorder                             */
    bool     placed;            /* the draft has that name                     */
    uint64_t at, whole;         /* bytes written; those up to the end of the last block */
    Part     parts[PARTS];
    LIST(Section) sections;
    struct libdeflate_compressor *compressor;
    dig_status failed;
    char     why[200];
} Writer;

struct Recorder {
    World   *w;
    Kept     now, last;
    uint32_t frame;             /* that was taken last                         */
    uint32_t first, records;    /* of the block: its first frame; frames in it */
    uint32_t body_count, mesh_count;        /* that were given to their parts  */
    Part     parts[PARTS];      /* of the block                                */
    Pack     pending;           /* commands since the last step                */
    bool     any_commands;      /* in the block                                */
    bool     listens;           /* to what is done to the world                */
    LIST(Known)    known;
    LIST(NoteHash) hashes;
    Writer   writer;
    pthread_t thread; bool running;
    dig_status failed;
    char     path[1024], why[1400];
};

static dig_status fail(Recorder *r, dig_status s, const char *what)
{
    if (r->failed == DIG_OK) {
        r->failed = s;
        snprintf(r->why, sizeof r->why, "%s: %s", r->path, what);
    }
    return r->failed;
}

static dig_status fail_pack(Recorder *r, const Pack *p)
{
    return p->no_memory ? fail(r, DIG_E_MEMORY, "not enough memory for the replay") : fail(r, DIG_E_FORMAT, p->why);
}

const char *recorder_error(const Recorder *r) { return r->why; }
void recorder_lose_world(Recorder *r) { r->w = NULL; }

/* ---- the file: nothing here looks at the recorder ---- */

static dig_status writer_fail(Writer *f, dig_status s, const char *what, int error)
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

static const char cannot[] = "the replay cannot be written";

static dig_status put(Writer *f, const void *data, size_t size)
{
    int error = f->failed == DIG_OK ? file_write_all(f->draft.handle, data, size) : 0;
    if (error != 0)
        return writer_fail(f, DIG_E_FILE, cannot, error);
    f->at += size;
    return f->failed;
}

/* What does not get smaller is left as it is. */
static dig_status put_section(Writer *f, const char *tag, uint32_t first, uint32_t count, const Pack *body)
{
    Section s = {.first = first, .count = count, .raw = body->size, .size = body->size, .offset = f->at};
    if (!pack_good(body))
        return writer_fail(f, body->no_memory ? DIG_E_MEMORY : DIG_E_FORMAT, body->why, 0);
    memcpy(s.tag, tag, sizeof s.tag);
    void *packed = body->size > 64 ? malloc(body->size) : NULL;
    size_t size = packed ? libdeflate_deflate_compress(f->compressor, body->data, body->size, packed, body->size) : 0;
    const void *data = size > 0 ? packed : body->data;
    s.packed = size > 0;
    if (size > 0)
        s.size = size;
    s.crc = libdeflate_crc32(0, data, (size_t)s.size);
    Pack head = pack_writer();
    section_header(&head, &s);
    if (pack_good(&head) && list_push(&f->sections, NULL) == DIG_OK)
        f->sections.data[f->sections.count - 1] = s;
    else
        writer_fail(f, DIG_E_MEMORY, "not enough memory for the replay", 0);
    put(f, head.data, head.size);
    put(f, data, (size_t)s.size);
    pack_close(&head);
    free(packed);
    return f->failed;
}

/* The file has something to show: it may have its name. */
static dig_status give_name(Writer *f)
{
    if (f->failed == DIG_OK && !f->placed && rename(f->draft.name, f->path) != 0)
        return writer_fail(f, DIG_E_FILE, cannot, errno);
    f->placed = f->placed || f->failed == DIG_OK;
    f->whole = f->failed == DIG_OK ? f->at : f->whole;
    return f->failed;
}

static void *put_parts(void *writer)
{
    Writer *f = writer;
    for (int i = 0; i < PARTS; i++) {
        Part *p = &f->parts[i];
        if (f->failed == DIG_OK && (p->bytes.size > 0 || !pack_good(&p->bytes)))
            put_section(f, part_tags[i], p->first, p->count, &p->bytes);
        p->bytes.size = 0;
        p->count = 0;
    }
    give_name(f);
    return NULL;
}

/* ---- blocks ---- */

static dig_status wait_for_writer(Recorder *r)
{
    if (r->running)
        pthread_join(r->thread, NULL);
    r->running = false;
    return r->writer.failed == DIG_OK ? r->failed : fail(r, r->writer.failed, r->writer.why);
}

/* Hands the block over. The writer's packs, which are empty by now, take the place of its own. */
static dig_status put_block(Recorder *r)
{
    DIG_TRY(wait_for_writer(r));
    if (!r->any_commands)
        r->parts[PART_COMMANDS].bytes.size = 0;
    r->parts[PART_FRAMES].first = r->parts[PART_COMMANDS].first = r->first;
    r->parts[PART_FRAMES].count = r->parts[PART_COMMANDS].count = r->records;
    for (int i = 0; i < PARTS; i++) {
        Part empty = r->writer.parts[i];
        r->writer.parts[i] = r->parts[i];
        r->parts[i] = empty;
    }
    r->running = pthread_create(&r->thread, NULL, put_parts, &r->writer) == 0;
    if (!r->running)
        put_parts(&r->writer);
    r->any_commands = false;
    r->first += r->records;
    r->records = 0;
    kept_clear(&r->last);           /* a block begins with all rows */
    return r->failed;
}

/* ---- what is new ---- */

static void describe_body(const World *w, uint32_t slot, const LookBody *row, KeptBody *out)
{
    const Body *b = &w->bodies.data[slot];
    const char *shape = b->shape_first == NONE ? "" : w->solids.data[b->shape_first].shape.type->name;
    *out = (KeptBody){.index = row->index, .slot = slot, .gen = row->gen, .kind = (uint32_t)b->kind, .centre = b->centre,
                      .mass = b->kind == DIG_DYNAMIC ? b->mass : INFINITY};
    snprintf(out->name, sizeof out->name, "%s", b->name);
    snprintf(out->material, sizeof out->material, "%s", w->materials.data[b->surface.material].name);
    snprintf(out->shape, sizeof out->shape, "%s", shape);
}

static void note_birth(Recorder *r, uint32_t slot, LookBody *row)
{
    uint8_t kind = 1;
    KeptBody b;
    row->index = r->body_count++;
    r->known.data[slot] = (Known){row->gen, row->index};
    describe_body(r->w, slot, row, &b);
    b.born = r->frame;
    pack_u8(&r->parts[PART_BODIES].bytes, &kind);
    replay_kept_body(&r->parts[PART_BODIES].bytes, &b);
    r->parts[PART_BODIES].count++;
}

static void note_death(Recorder *r, uint32_t slot)
{
    uint8_t kind = 0;
    pack_u8(&r->parts[PART_BODIES].bytes, &kind);
    pack_u32(&r->parts[PART_BODIES].bytes, &r->known.data[slot].index);
    pack_u32(&r->parts[PART_BODIES].bytes, &r->frame);
    r->known.data[slot].gen = 0;
    r->parts[PART_BODIES].count++;
}

static dig_status note_bodies(Recorder *r)
{
    int count = look_count(&r->now.look, LOOK_BODIES);
    while (r->known.count < count)
        DIG_TRY(list_push(&r->known, NULL));
    for (int i = 0; i < count; i++) {
        LookBody *row = &look_bodies(&r->now.look)[i];
        Known *k = &r->known.data[i];
        if (k->gen != 0 && (!row->there || row->gen != k->gen))
            note_death(r, (uint32_t)i);
        if (row->there && k->gen == 0)
            note_birth(r, (uint32_t)i, row);
        if (row->there)
            row->index = r->known.data[i].index;
    }
    return DIG_OK;
}

static void note_meshes(Recorder *r)
{
    for (; r->mesh_count < (uint32_t)r->now.look.meshes.count; r->mesh_count++, r->parts[PART_MESHES].count++)
        replay_mesh(&r->parts[PART_MESHES].bytes, &r->now.look.meshes.data[r->mesh_count]);
}

/* ---- frames ---- */

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static dig_status take_flows(Recorder *r)
{
    int count = look_count(&r->now.look, LOOK_EDGES);
    vec3 origin = look_origin(look_scene(&r->now.look));
    DIG_TRY(kept_resize(&r->now, KEPT_FLOWS, count));
    for (int i = 0; i < count; i++) {
        const LookEdge *e = &look_edges(&r->now.look)[i];
        KeptFlow *f = &kept_flows(&r->now)[i];
        dig_link link;
        api_link(r->w, e->layer, e->link, &link);
        *f = (KeptFlow){.began = link.began, .joint = LOOK_NONE};
        if (link.joint.gen != 0) {
            f->joint = link.joint.slot;
            f->joint_gen = link.joint.gen - r->w->gen_start + 1;
        }
        write_vec(f->effort, link.effort);
        write_vec(f->flow, link.flow);
        write_vec(f->point, vec3_sub(link.point, origin));
        write_vec(f->normal, link.normal);
    }
    return DIG_OK;
}

static void keep_handle(const World *w, uint32_t out[2], uint32_t slot, uint32_t gen)
{
    out[0] = slot;
    out[1] = gen ? gen - w->gen_start + 1 : 0;
}

static dig_status take_events(Recorder *r)
{
    const dig_event *events;
    int count = dig_events(r->w, &events);
    DIG_TRY(kept_resize(&r->now, KEPT_EVENTS, count));
    for (int i = 0; i < count; i++) {
        const dig_event *e = &events[i];
        KeptEvent *k = &kept_events(&r->now)[i];
        *k = (KeptEvent){.time = e->time, .speed = e->speed, .impulse = e->impulse, .stress = e->stress, .point = e->point,
                         .normal = e->normal, .message = e->message, .kind = (uint32_t)e->kind, .dig = e->dig, .other_dig = e->other_dig,
                         .wall = (uint32_t)e->wall, .link = (uint32_t)e->link, .layer = e->layer};
        keep_handle(r->w, k->a, e->a.slot, e->a.gen);
        keep_handle(r->w, k->b, e->b.slot, e->b.gen);
        keep_handle(r->w, k->joint, e->joint.slot, e->joint.gen);
        keep_handle(r->w, k->region, e->region.slot, e->region.gen);
    }
    return DIG_OK;
}

static dig_status take_state(Recorder *r)
{
    DIG_TRY(kept_resize(&r->now, KEPT_STATE, 1));
    *kept_state(&r->now) = (KeptState){dig_world_checksum(r->w), dig_world_energy(r->w)};
    return take_events(r);
}

static dig_status record(Recorder *r, RecordKind kind)
{
    uint8_t mark = (uint8_t)kind;
    dig_status s = look_take(&r->now.look, r->w);
    if (s == DIG_OK)
        s = take_flows(r);
    if (s == DIG_OK && kind == RECORD_FRAME)
        s = take_state(r);
    if (s == DIG_OK)
        s = note_bodies(r);
    if (s != DIG_OK)
        return fail(r, s, "not enough memory for the replay");
    note_meshes(r);
    pack_u8(&r->parts[PART_FRAMES].bytes, &mark);
    delta_write(&r->parts[PART_FRAMES].bytes, &r->now, &r->last);
    return pack_good(&r->parts[PART_FRAMES].bytes) ? DIG_OK : fail_pack(r, &r->parts[PART_FRAMES].bytes);
}

/* Commands that led to this frame. */
static void close_commands(Recorder *r)
{
    uint32_t size = (uint32_t)r->pending.size;
    pack_u32(&r->parts[PART_COMMANDS].bytes, &size);
    pack_bytes(&r->parts[PART_COMMANDS].bytes, r->pending.data, r->pending.size);
    r->any_commands = r->any_commands || size > 0;
    r->pending.size = 0;
}

static dig_status next_frame(Recorder *r)
{
    if (r->records >= BLOCK_FRAMES || r->parts[PART_FRAMES].bytes.size >= BLOCK_BYTES)
        DIG_TRY(put_block(r));
    r->frame = r->first + r->records;
    DIG_TRY(record(r, RECORD_FRAME));
    close_commands(r);
    r->records++;
    return DIG_OK;
}

dig_status recorder_before_step(Recorder *r)
{
    if (r->failed != DIG_OK || look_holds(&r->now.look, r->w))
        return r->failed;
    return record(r, RECORD_LEFT);
}

dig_status recorder_step(Recorder *r)
{
    return r->failed != DIG_OK ? r->failed : next_frame(r);
}

dig_status recorder_commands(Recorder *r, const void *bytes, size_t size)
{
    unsigned char *to = pack_space(&r->pending, size);
    if (to && size > 0)
        memcpy(to, bytes, size);
    return pack_good(&r->pending) ? r->failed : fail_pack(r, &r->pending);
}

dig_status recorder_start(Recorder *r, const void *bytes, size_t size)
{
    Pack p = pack_writer();
    unsigned char *to = pack_space(&p, size);
    if (to && size > 0)
        memcpy(to, bytes, size);
    if (wait_for_writer(r) == DIG_OK)
        put_section(&r->writer, "STRT", 0, 0, &p);
    pack_close(&p);
    return wait_for_writer(r);
}

/* A failure stays with the recorder, which tells of it at its next call. */
static void hear(void *context, const void *bytes, size_t size) { (void)recorder_commands(context, bytes, size); }

dig_status recorder_listen(Recorder *r)
{
    void *bytes;
    size_t size;
    dig_status s = dig_world_pack(r->w, &bytes, &size);
    if (s != DIG_OK)
        return fail(r, s, dig_error(r->w));
    s = recorder_start(r, bytes, size);
    free(bytes);
    if (s == DIG_OK && (s = dig_world_tap(r->w, hear, r)) != DIG_OK)
        return fail(r, s, dig_error(r->w));
    r->listens = s == DIG_OK;
    return s;
}

/* ---- notes ---- */

dig_status recorder_note(Recorder *r, const char *name, const char *text)
{
    size_t size = strlen(text);
    char own[32] = "";
    uint64_t hash = hash_bytes(HASH_START, text, size);
    int i = 0;
    if (strlen(name) >= sizeof own || size > INT32_MAX)
        return fail(r, DIG_E_ARG, "the name of a note has more than 31 bytes, or its text more than 2 GiB");
    memcpy(own, name, strlen(name));
    while (i < r->hashes.count && strcmp(r->hashes.data[i].name, own) != 0)
        i++;
    if (i == r->hashes.count) {
        if (list_push(&r->hashes, NULL) != DIG_OK)
            return fail(r, DIG_E_MEMORY, "not enough memory for the replay");
        memcpy(r->hashes.data[i].name, own, sizeof own);
    } else if (r->hashes.data[i].hash == hash) {
        return r->failed;           /* it holds already */
    }
    r->hashes.data[i].hash = hash;
    uint32_t bytes = (uint32_t)size;
    pack_u32(&r->parts[PART_NOTES].bytes, &r->frame);
    pack_bytes(&r->parts[PART_NOTES].bytes, own, sizeof own);
    pack_u32(&r->parts[PART_NOTES].bytes, &bytes);
    unsigned char *to = pack_space(&r->parts[PART_NOTES].bytes, size);
    if (to && size > 0)
        memcpy(to, text, size);
    r->parts[PART_NOTES].count++;
    return pack_good(&r->parts[PART_NOTES].bytes) ? r->failed : fail_pack(r, &r->parts[PART_NOTES].bytes);
}

/* ---- beginning and end ---- */

static dig_status put_start(Recorder *r, const char *origin)
{
    ReplayHeader h = {.format = REPLAY_FORMAT, .version = DIGBOX_VERSION, .first_step = r->w->steps, .seed = (uint64_t)r->w->def.seed,
                      .step = r->w->def.step};
    Pack p = pack_writer(), text = pack_writer();
    replay_header(&p, &h);
    uint32_t crc = pack_good(&p) ? libdeflate_crc32(0, p.data, p.size) : 0;
    pack_u32(&p, &crc);
    if (!pack_good(&p))
        fail_pack(r, &p);
    put(&r->writer, p.data, p.size);
    unsigned char *to = pack_space(&text, strlen(origin));
    if (to)
        memcpy(to, origin, strlen(origin));
    put_section(&r->writer, "ORIG", 0, 0, &text);
    pack_close(&p);
    pack_close(&text);
    return wait_for_writer(r);
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

static void release(Recorder *r)
{
    wait_for_writer(r);
    for (int i = 0; i < PARTS; i++) {
        pack_close(&r->parts[i].bytes);
        pack_close(&r->writer.parts[i].bytes);
    }
    pack_close(&r->pending);
    kept_close(&r->now);
    kept_close(&r->last);
    list_close(&r->known);
    list_close(&r->hashes);
    list_close(&r->writer.sections);
    if (r->writer.compressor)
        libdeflate_free_compressor(r->writer.compressor);
    end_file(&r->writer);
    free(r);
}

/* A draft; what is no file (a device, a pipe, a link) is written as it is. */
static void open_file(Writer *f)
{
    char why[1400], text[160];
    struct stat info;
    if (lstat(f->path, &info) == 0 && !S_ISREG(info.st_mode)) {
        f->draft.handle = open(f->path, O_WRONLY | O_TRUNC | O_CLOEXEC);
        f->placed = true;
        if (f->draft.handle < 0)
            writer_fail(f, DIG_E_FILE, cannot, errno);
    } else if (file_draft(f->path, &f->draft, why, sizeof why) != DIG_OK) {
        snprintf(text, sizeof text, "%s%.120s", cannot, why + strlen(f->path));
        writer_fail(f, DIG_E_FILE, text, 0);
    }
}

static dig_status open_writer(Recorder *r)
{
    Writer *f = &r->writer;
    f->path = r->path;
    open_file(f);
    f->compressor = libdeflate_alloc_compressor(LEVEL);
    if (!f->compressor)
        writer_fail(f, DIG_E_MEMORY, "not enough memory for the replay", 0);
    return wait_for_writer(r);
}

dig_status recorder_open(const char *path, dig_world *w, const char *origin, Recorder **out, char *why, size_t capacity)
{
    Recorder *r = calloc(1, sizeof *r);
    *out = NULL;
    if (!r) {
        snprintf(why, capacity, "%s: not enough memory for the replay", path);
        return DIG_E_MEMORY;
    }
    r->w = w;
    r->writer.draft.handle = -1;
    snprintf(r->path, sizeof r->path, "%s", path);
    dig_status s = open_writer(r);
    if (s == DIG_OK)
        s = put_start(r, origin ? origin : "{}");
    if (s == DIG_OK)
        s = next_frame(r);
    if (s == DIG_OK) {
        *out = r;
        return DIG_OK;
    }
    snprintf(why, capacity, "%s", r->why);
    release(r);
    return s;
}

static dig_status put_index(Writer *f)
{
    Pack p = pack_writer(), end = pack_writer();
    uint64_t at = f->at;
    uint32_t format = REPLAY_FORMAT;
    unsigned char magic[8];
    for (int i = 0; i < f->sections.count; i++) {
        section_header(&p, &f->sections.data[i]);
        pack_u64(&p, &f->sections.data[i].offset);
    }
    put_section(f, "INDX", 0, (uint32_t)f->sections.count, &p);
    memcpy(magic, replay_end_magic, sizeof magic);
    pack_u64(&end, &at);
    pack_u32(&end, &format);
    uint32_t crc = pack_good(&end) ? libdeflate_crc32(0, end.data, end.size) : 0;
    pack_u32(&end, &crc);
    pack_bytes(&end, magic, sizeof magic);
    if (!pack_good(&end))
        writer_fail(f, DIG_E_MEMORY, "not enough memory for the replay", 0);
    put(f, end.data, end.size);
    pack_close(&p);
    pack_close(&end);
    return f->failed;
}

/* Whole, on the disk; a failure may come as late as with close. */
static dig_status close_file(Writer *f)
{
    if (fsync(f->draft.handle) != 0 && errno != EINVAL && errno != ENOTSUP)     /* a file system that cannot */
        return writer_fail(f, DIG_E_FILE, cannot, errno);
    if (close(f->draft.handle) != 0 && errno != EINTR) {
        writer_fail(f, DIG_E_FILE, cannot, errno);
        f->draft.handle = -1;
    }
    return f->failed;
}

dig_status recorder_close(Recorder *r, char *why, size_t capacity)
{
    if (!r)
        return DIG_OK;
    if (r->w && r->listens)
        dig_world_tap(r->w, NULL, NULL);
    if (r->failed == DIG_OK && r->w)
        recorder_before_step(r);        /* as the script left it */
    if (r->failed == DIG_OK && r->pending.size > 0)
        close_commands(r);
    if (r->failed == DIG_OK && put_block(r) == DIG_OK && wait_for_writer(r) == DIG_OK)
        put_index(&r->writer);
    wait_for_writer(r);
    if (r->failed == DIG_OK && close_file(&r->writer) == DIG_OK)
        r->writer.draft.handle = -1;
    dig_status s = wait_for_writer(r);
    if (s != DIG_OK && why)
        snprintf(why, capacity, "%s", r->why);
    release(r);
    return s;
}
