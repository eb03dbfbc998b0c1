/* replay/recorder.c - writes a run into a replay while it happens.
 *
 * Frames gather in memory until a block is full; then what is new since the last block (meshes, bodies, notes, commands) and the
 * block itself are packed and written, in this order, so that a file that ends after a block lacks nothing that the block needs.
 */
#define _POSIX_C_SOURCE 200809L     /* open, write, strerror_r */

#include "api/api.h"
#include "replay/format.h"
#include "replay/replay.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define BLOCK_BYTES  (1024u * 1024u)    /* a block is full with so many bytes before packing */
#define BLOCK_FRAMES 256u               /* or so many frames                                 */
#define LEVEL        1                  /* of deflate: higher ones gain a few per cent of doubles */

typedef struct Known { uint32_t gen, index; } Known;            /* the body in a slot; gen 0: none */
typedef struct NoteHash { char name[32]; uint64_t hash; } NoteHash;

struct Recorder {
    World   *w;
    int      file;
    uint64_t at;                /* bytes written                               */
    Kept     now, last;
    uint32_t frame;             /* that was taken last                         */
    uint32_t first, records;    /* of the block: its first frame; frames in it */
    uint32_t body_count, mesh_count;        /* that were given to `bodies`, `meshes` */
    Pack     frames, meshes, bodies, notes, commands;
    Pack     pending;           /* commands since the last step                */
    bool     any_commands;      /* in the block                                */
    bool     listens;           /* to what is done to the world                */
    uint32_t bodies_in, meshes_in, notes_in;                    /* records in these */
    LIST(Known)    known;
    LIST(NoteHash) hashes;
    LIST(Section)  sections;
    struct libdeflate_compressor *compressor;
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

static dig_status fail_errno(Recorder *r, int error)
{
    char text[128] = "";
    char what[200];
    if (strerror_r(error, text, sizeof text) != 0)
        snprintf(text, sizeof text, "error %d", error);
    snprintf(what, sizeof what, "the replay cannot be written: %s", text);
    return fail(r, DIG_E_FILE, what);
}

static dig_status fail_pack(Recorder *r, const Pack *p)
{
    return p->no_memory ? fail(r, DIG_E_MEMORY, "not enough memory for the replay") : fail(r, DIG_E_FORMAT, p->why);
}

const char *recorder_error(const Recorder *r) { return r->why; }
void recorder_lose_world(Recorder *r) { r->w = NULL; }

/* ---- the file ---- */

static dig_status put(Recorder *r, const void *data, size_t size)
{
    const char *from = data;
    while (size > 0 && r->failed == DIG_OK) {
        ssize_t n = write(r->file, from, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail_errno(r, n < 0 ? errno : EIO);
        from += n;
        size -= (size_t)n;
        r->at += (uint64_t)n;
    }
    return r->failed;
}

static dig_status put_section(Recorder *r, const char tag[4], uint32_t first, uint32_t count, const Pack *body)
{
    Section s = {.first = first, .count = count, .raw = body->size, .size = body->size, .offset = r->at};
    if (!pack_good(body))
        return fail_pack(r, body);
    memcpy(s.tag, tag, sizeof s.tag);
    void *packed = body->size > 64 ? malloc(body->size) : NULL;
    size_t size = packed ? libdeflate_deflate_compress(r->compressor, body->data, body->size, packed, body->size) : 0;
    const void *data = size > 0 ? packed : body->data;
    s.packed = size > 0;
    if (size > 0)
        s.size = size;
    s.crc = libdeflate_crc32(0, data, (size_t)s.size);
    Pack head = pack_writer();
    section_header(&head, &s);
    dig_status status = pack_good(&head) && list_push(&r->sections, NULL) == DIG_OK ? DIG_OK : fail(r, DIG_E_MEMORY, "not enough memory for the replay");
    if (status == DIG_OK) {
        r->sections.data[r->sections.count - 1] = s;
        status = put(r, head.data, head.size);
    }
    if (status == DIG_OK)
        status = put(r, data, (size_t)s.size);
    pack_close(&head);
    free(packed);
    return status;
}

/* A section of records that gathered, which are then gone. */
static dig_status put_records(Recorder *r, const char tag[4], uint32_t first, uint32_t count, Pack *p)
{
    if (p->size == 0 && pack_good(p))
        return r->failed;
    dig_status s = put_section(r, tag, first, count, p);
    p->size = 0;
    return s;
}

static dig_status put_block(Recorder *r)
{
    if (r->records == 0)
        return r->failed;
    DIG_TRY(put_records(r, "MESH", 0, r->meshes_in, &r->meshes));
    DIG_TRY(put_records(r, "BODY", 0, r->bodies_in, &r->bodies));
    DIG_TRY(put_records(r, "NOTE", 0, r->notes_in, &r->notes));
    if (r->any_commands)
        DIG_TRY(put_records(r, "CMDS", r->first, r->records, &r->commands));
    r->commands.size = 0;
    r->any_commands = false;
    DIG_TRY(put_records(r, "FRAM", r->first, r->records, &r->frames));
    r->first += r->records;
    r->records = r->meshes_in = r->bodies_in = r->notes_in = 0;
    kept_clear(&r->last);           /* a block begins with all rows */
    return DIG_OK;
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
    pack_u8(&r->bodies, &kind);
    replay_kept_body(&r->bodies, &b);
    r->bodies_in++;
}

static void note_death(Recorder *r, uint32_t slot)
{
    uint8_t kind = 0;
    pack_u8(&r->bodies, &kind);
    pack_u32(&r->bodies, &r->known.data[slot].index);
    pack_u32(&r->bodies, &r->frame);
    r->known.data[slot].gen = 0;
    r->bodies_in++;
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
    for (; r->mesh_count < (uint32_t)r->now.look.meshes.count; r->mesh_count++, r->meshes_in++)
        replay_mesh(&r->meshes, &r->now.look.meshes.data[r->mesh_count]);
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
    pack_u8(&r->frames, &mark);
    delta_write(&r->frames, &r->now, &r->last);
    return pack_good(&r->frames) ? DIG_OK : fail_pack(r, &r->frames);
}

/* Commands that led to this frame. */
static void close_commands(Recorder *r)
{
    uint32_t size = (uint32_t)r->pending.size;
    pack_u32(&r->commands, &size);
    pack_bytes(&r->commands, r->pending.data, r->pending.size);
    r->any_commands = r->any_commands || size > 0;
    r->pending.size = 0;
}

static dig_status next_frame(Recorder *r)
{
    if (r->records >= BLOCK_FRAMES || r->frames.size >= BLOCK_BYTES)
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
    dig_status s = put_section(r, "STRT", 0, 0, &p);
    pack_close(&p);
    return s;
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
    pack_u32(&r->notes, &r->frame);
    pack_bytes(&r->notes, own, sizeof own);
    pack_u32(&r->notes, &bytes);
    unsigned char *to = pack_space(&r->notes, size);
    if (to && size > 0)
        memcpy(to, text, size);
    r->notes_in++;
    return pack_good(&r->notes) ? r->failed : fail_pack(r, &r->notes);
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
    dig_status s = pack_good(&p) ? put(r, p.data, p.size) : fail_pack(r, &p);
    unsigned char *to = pack_space(&text, strlen(origin));
    if (to)
        memcpy(to, origin, strlen(origin));
    if (s == DIG_OK)
        s = put_section(r, "ORIG", 0, 0, &text);
    pack_close(&p);
    pack_close(&text);
    return s;
}

static void release(Recorder *r)
{
    Pack *packs[] = {&r->frames, &r->meshes, &r->bodies, &r->notes, &r->commands, &r->pending};
    for (size_t i = 0; i < sizeof packs / sizeof *packs; i++)
        pack_close(packs[i]);
    kept_close(&r->now);
    kept_close(&r->last);
    list_close(&r->known);
    list_close(&r->hashes);
    list_close(&r->sections);
    if (r->compressor)
        libdeflate_free_compressor(r->compressor);
    if (r->file >= 0)
        close(r->file);
    free(r);
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
    snprintf(r->path, sizeof r->path, "%s", path);
    r->file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    dig_status s = r->file < 0 ? fail_errno(r, errno) : DIG_OK;
    r->compressor = libdeflate_alloc_compressor(LEVEL);
    if (!r->compressor)
        s = fail(r, DIG_E_MEMORY, "not enough memory for the replay");
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

static dig_status put_index(Recorder *r)
{
    Pack p = pack_writer(), end = pack_writer();
    uint64_t at = r->at;
    unsigned char magic[8];
    for (int i = 0; i < r->sections.count; i++) {
        section_header(&p, &r->sections.data[i]);
        pack_u64(&p, &r->sections.data[i].offset);
    }
    dig_status s = put_section(r, "INDX", 0, (uint32_t)r->sections.count, &p);
    uint32_t format = REPLAY_FORMAT;
    memcpy(magic, replay_end_magic, sizeof magic);
    pack_u64(&end, &at);
    pack_u32(&end, &format);
    uint32_t crc = pack_good(&end) ? libdeflate_crc32(0, end.data, end.size) : 0;
    pack_u32(&end, &crc);
    pack_bytes(&end, magic, sizeof magic);
    if (s == DIG_OK)
        s = pack_good(&end) ? put(r, end.data, end.size) : fail_pack(r, &end);
    pack_close(&p);
    pack_close(&end);
    return s;
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
    if (r->failed == DIG_OK && put_block(r) == DIG_OK)
        put_index(r);
    if (close(r->file) != 0 && r->failed == DIG_OK)
        fail_errno(r, errno);
    r->file = -1;
    dig_status s = r->failed;
    if (s != DIG_OK && why)
        snprintf(why, capacity, "%s", r->why);
    release(r);
    return s;
}
