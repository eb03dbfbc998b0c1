/* replay/recorder.c - takes the frames of a replay from a world while it runs.
 *
 * What the world waits for is little: its tables are copied. Frames gather in a batch, with what is new with them (meshes, bodies,
 * notes, commands); a thread makes blocks of them and writes these (replay/writer.h) while the world goes on.
 */
#include "api/api.h"
#include "api/command.h"
#include "replay/replay.h"
#include "replay/writer.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#define BATCH_BYTES  (1024u * 1024u)    /* of tables as they are, that wait for the writer */
#define BATCH_FRAMES 128u               /* or so many frames                               */

typedef struct Known { uint32_t gen, index; } Known;            /* the body in a slot; gen 0: none */
typedef struct NoteHash { char name[32]; uint64_t hash; } NoteHash;

struct Recorder {
    World   *w;
    Kept     now;
    uint32_t frames;            /* that were taken                             */
    uint32_t frame;             /* that was taken last                         */
    uint32_t body_count, mesh_count;        /* that were given to their parts  */
    Batch    batch;             /* to be handed over                           */
    uint32_t batch_frames;
    Pack     pending;           /* commands since the last step                */
    bool     moved_cameras;     /* since the last record                       */
    bool     listens;           /* to what is done to the world                */
    bool     meddled;           /* since a record was taken, somebody did what may change how a body looks */
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

/* ---- the writer ---- */

static dig_status wait_for_writer(Recorder *r)
{
    if (r->running)
        pthread_join(r->thread, NULL);
    r->running = false;
    return r->writer.failed == DIG_OK ? r->failed : fail(r, r->writer.failed, r->writer.why);
}

static void *write_batch(void *writer)
{
    writer_batch(writer);
    return NULL;
}

/* Hands the batch over. The writer's, which is empty by now, takes its place. */
static dig_status hand_over(Recorder *r)
{
    DIG_TRY(wait_for_writer(r));
    Batch empty = r->writer.batch;
    r->writer.batch = r->batch;
    r->batch = empty;
    r->batch_frames = 0;
    r->running = pthread_create(&r->thread, NULL, write_batch, &r->writer) == 0;
    if (!r->running)
        writer_batch(&r->writer);
    return r->failed;
}

/* ---- what is new ---- */

static void describe_body(const World *w, uint32_t slot, const LookBody *row, KeptBody *out)
{
    const Body *b = &w->bodies.data[slot];
    const char *shape = b->shape_first == NONE ? "" : w->solids.data[b->shape_first].form->shape.type->name;
    *out = (KeptBody){.index = row->index, .slot = slot, .gen = row->gen, .kind = (uint32_t)b->kind, .centre = b->centre,
                      .mass = body_mass_read(b)};
    snprintf(out->name, sizeof out->name, "%s", body_name(w, b));
    snprintf(out->material, sizeof out->material, "%s", w->materials.data[body_make(b)->surface.material].name);
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
    pack_u8(&r->batch.parts[PART_BODIES].bytes, &kind);
    replay_kept_body(&r->batch.parts[PART_BODIES].bytes, &b);
    r->batch.parts[PART_BODIES].count++;
}

static void note_death(Recorder *r, uint32_t slot)
{
    uint8_t kind = 0;
    pack_u8(&r->batch.parts[PART_BODIES].bytes, &kind);
    pack_u32(&r->batch.parts[PART_BODIES].bytes, &r->known.data[slot].index);
    pack_u32(&r->batch.parts[PART_BODIES].bytes, &r->frame);
    r->known.data[slot].gen = 0;
    r->batch.parts[PART_BODIES].count++;
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
    for (; r->mesh_count < (uint32_t)r->now.look.meshes.count; r->mesh_count++, r->batch.parts[PART_MESHES].count++)
        replay_mesh(&r->batch.parts[PART_MESHES].bytes, &r->now.look.meshes.data[r->mesh_count]);
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

/* Who moved is told by the poses. */
static dig_status take_events(Recorder *r)
{
    const dig_event *events;
    int all = dig_events(r->w, &events), count = 0;
    for (int i = 0; i < all; i++)
        count += events[i].kind != DIG_EVENT_MOVED;
    DIG_TRY(kept_resize(&r->now, KEPT_EVENTS, count));
    KeptEvent *k = kept_events(&r->now);
    for (const dig_event *e = events; e < events + all; e++) {
        if (e->kind == DIG_EVENT_MOVED)
            continue;
        *k = (KeptEvent){.time = e->time, .speed = e->speed, .impulse = e->impulse, .stress = e->stress, .point = e->point,
                         .normal = e->normal, .message = e->message, .kind = (uint32_t)e->kind, .dig = e->dig, .other_dig = e->other_dig,
                         .wall = (uint32_t)e->wall, .link = (uint32_t)e->link, .layer = e->layer};
        keep_handle(r->w, k->a, e->a.slot, e->a.gen);
        keep_handle(r->w, k->b, e->b.slot, e->b.gen);
        keep_handle(r->w, k->joint, e->joint.slot, e->joint.gen);
        keep_handle(r->w, k->region, e->region.slot, e->region.gen);
        k++;
    }
    return DIG_OK;
}

static dig_status take_state(Recorder *r)
{
    DIG_TRY(kept_resize(&r->now, KEPT_STATE, 1));
    *kept_state(&r->now) = (KeptState){dig_world_checksum(r->w), dig_world_energy(r->w)};
    return take_events(r);
}

/* All tables as they are, behind a head; bodies and shapes only if they are not the `same` as in the record before. */
static dig_status put_record(Recorder *r, RecordHead *head, bool same)
{
    size_t size = sizeof *head;
    for (int t = 0; t < KEPT_TABLES; t++) {
        head->rows[t] = same && kept_seldom(t) ? ROWS_AS_BEFORE : kept_table(&r->now, t)->count;
        size += head->rows[t] > 0 ? (size_t)head->rows[t] * kept_row_size(t) : 0;
    }
    unsigned char *to = pack_space(&r->batch.records, size);
    if (!to)
        return fail_pack(r, &r->batch.records);
    memcpy(to, head, sizeof *head);
    to += sizeof *head;
    for (int t = 0; t < KEPT_TABLES; t++) {
        size = head->rows[t] > 0 ? (size_t)head->rows[t] * kept_row_size(t) : 0;
        if (size > 0)
            memcpy(to, kept_table(&r->now, t)->data, size);
        to += size;
    }
    r->moved_cameras = false;
    return DIG_OK;
}

static dig_status take(Recorder *r, RecordKind kind, bool *same)
{
    *same = false;
    DIG_TRY(r->meddled ? look_take(&r->now.look, r->w) : look_take_moving(&r->now.look, r->w, same));
    r->meddled = !r->listens;
    DIG_TRY(take_flows(r));
    if (kind == RECORD_FRAME)
        DIG_TRY(take_state(r));
    return note_bodies(r);
}

/* Of what the script left, only the cameras may be new: then nothing else is taken. */
static dig_status record(Recorder *r, RecordKind kind, bool only_cameras)
{
    RecordHead head;
    bool same = only_cameras;
    memset(&head, 0, sizeof head);
    head.kind = (uint32_t)kind;
    for (int i = 0; i < PART_FRAMES; i++) {
        head.sizes[i] = r->batch.parts[i].bytes.size;
        head.counts[i] = r->batch.parts[i].count;
    }
    if (!only_cameras) {
        dig_status s = take(r, kind, &same);
        if (s != DIG_OK)
            return fail(r, s, "not enough memory for the replay");
        note_meshes(r);
    }
    return put_record(r, &head, same);
}

/* Commands that led to this frame. */
static void close_commands(Recorder *r)
{
    Part *p = &r->batch.parts[PART_COMMANDS];
    uint32_t size = (uint32_t)r->pending.size;
    pack_u32(&p->bytes, &size);
    pack_bytes(&p->bytes, r->pending.data, r->pending.size);
    p->count += r->pending.size > 0;
    r->pending.size = 0;
}

static dig_status next_frame(Recorder *r)
{
    if (r->batch_frames >= BATCH_FRAMES || r->batch.records.size >= BATCH_BYTES)
        DIG_TRY(hand_over(r));
    r->frame = r->frames;
    DIG_TRY(record(r, RECORD_FRAME, false));
    close_commands(r);
    r->frames++;
    r->batch_frames++;
    return DIG_OK;
}

dig_status recorder_before_step(Recorder *r)
{
    if (r->failed != DIG_OK)
        return r->failed;
    bool holds = look_holds(&r->now.look, r->w);
    return holds && !r->moved_cameras ? DIG_OK : record(r, RECORD_LEFT, holds);
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
        writer_section(&r->writer, "STRT", 0, 0, &p);
    pack_close(&p);
    return wait_for_writer(r);
}

/* Does a command leave bodies and shapes as they are, but for places, speeds and forces? Those that are not known may change anything. */
static bool moves_only(const unsigned char *command, size_t size)
{
    static const uint8_t known[] = {COMMAND_STEP, COMMAND_PUSH, COMMAND_TWIST, COMMAND_HIT, COMMAND_TELEPORT, COMMAND_MOVE_TO, COMMAND_VELOCITY,
                                    COMMAND_WAKE, COMMAND_POST, COMMAND_POST_LIST, COMMAND_TAKE};
    return size > 0 && memchr(known, command[0], sizeof known);
}

/* A failure stays with the recorder, which tells of it at its next call. */
static void hear(void *context, const void *bytes, size_t size)
{
    Recorder *r = context;
    r->meddled = r->meddled || !moves_only(bytes, size);
    (void)recorder_commands(r, bytes, size);
}

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

/* ---- cameras and notes ---- */

dig_status recorder_cameras(Recorder *r, const ReplayCamera *list, int count)
{
    bool same = kept_table(&r->now, KEPT_CAMERAS)->count == count;
    if (kept_resize(&r->now, KEPT_CAMERAS, count) != DIG_OK)
        return fail(r, DIG_E_MEMORY, "not enough memory for the replay");
    for (int i = 0; i < count; i++) {
        const ReplayCamera *c = &list[i];
        KeptCamera k = {.fov = c->fov};
        k.says = (c->has_at ? CAMERA_AT : 0) | (c->has_look_at ? CAMERA_LOOK_AT : 0) | (c->has_up ? CAMERA_UP : 0);
        k.at = c->has_at ? c->at : vec3_zero();
        k.look_at = c->has_look_at ? c->look_at : vec3_zero();
        k.up = c->has_up ? c->up : vec3_zero();
        memcpy(k.name, c->name, sizeof k.name);
        same = same && memcmp(&k, &kept_cameras(&r->now)[i], sizeof k) == 0;
        kept_cameras(&r->now)[i] = k;
    }
    r->moved_cameras = r->moved_cameras || !same;
    return r->failed;
}

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
    pack_u32(&r->batch.parts[PART_NOTES].bytes, &r->frame);
    pack_bytes(&r->batch.parts[PART_NOTES].bytes, own, sizeof own);
    pack_u32(&r->batch.parts[PART_NOTES].bytes, &bytes);
    unsigned char *to = pack_space(&r->batch.parts[PART_NOTES].bytes, size);
    if (to && size > 0)
        memcpy(to, text, size);
    r->batch.parts[PART_NOTES].count++;
    return pack_good(&r->batch.parts[PART_NOTES].bytes) ? r->failed : fail_pack(r, &r->batch.parts[PART_NOTES].bytes);
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
    writer_bytes(&r->writer, p.data, p.size);
    unsigned char *to = pack_space(&text, strlen(origin));
    if (to)
        memcpy(to, origin, strlen(origin));
    writer_section(&r->writer, "ORIG", 0, 0, &text);
    pack_close(&p);
    pack_close(&text);
    return wait_for_writer(r);
}

static void release(Recorder *r)
{
    wait_for_writer(r);
    writer_release(&r->writer);
    for (int i = 0; i < PART_FRAMES; i++)
        pack_close(&r->batch.parts[i].bytes);
    pack_close(&r->batch.records);
    pack_close(&r->pending);
    kept_close(&r->now);
    list_close(&r->known);
    list_close(&r->hashes);
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
    r->meddled = true;
    snprintf(r->path, sizeof r->path, "%s", path);
    writer_open(&r->writer, r->path);
    dig_status s = wait_for_writer(r);
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
    if (r->failed == DIG_OK)
        hand_over(r);
    wait_for_writer(r);
    writer_finish(&r->writer);
    dig_status s = wait_for_writer(r);
    if (s != DIG_OK && why)
        snprintf(why, capacity, "%s", r->why);
    release(r);
    return s;
}
