/* tests/fuzz/target_replay.c - any bytes as a replay, unpacked and with its checksums made good so that what is inside is judged.
 *
 * What must hold: refused with a sentence, or every question that can be asked of a replay has an answer or a sentence: bodies,
 * frames, pictures between them, notes, the commands, and the run simulated again. docs/replay.md has the bytes.
 */
#define _GNU_SOURCE             /* P_tmpdir of scratch.h */
#include "state.h"

#include <string.h>

#include "scratch.h"

#include <libdeflate.h>

#include "replay/rerun.h"

enum { HEADER = 64, HEAD = 40, RECORDED = 6, LOOKED_AT = 12 };

static void put(unsigned char *to, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        to[i] = (unsigned char)(x >> 8 * i);
}

static uint64_t get(const unsigned char *from, int bytes)
{
    uint64_t x = 0;
    for (int i = 0; i < bytes; i++)
        x |= (uint64_t)from[i] << 8 * i;
    return x;
}

static void sign(unsigned char *data, size_t size)
{
    if (size < HEADER)
        return;
    put(data + 60, libdeflate_crc32(0, data, 60), 4);
    for (size_t at = HEADER; at + HEAD <= size; ) {
        uint64_t bytes = get(data + at + 24, 8);
        if (bytes > size - at - HEAD)
            break;
        put(data + at + 32, libdeflate_crc32(0, data + at + HEAD, (size_t)bytes), 4);
        put(data + at + 36, libdeflate_crc32(0, data + at, 36), 4);
        at += HEAD + (size_t)bytes;
    }
}

/* ---- first inputs ---- */

static unsigned char *read_whole(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END) != 0)
        fuzz_fail("cannot read %s", path);
    *size = (size_t)ftell(f);
    rewind(f);
    unsigned char *data = malloc(*size + 1);
    if (!data || fread(data, 1, *size, f) != *size)
        fuzz_fail("cannot read %s", path);
    fclose(f);
    return data;
}

/* Every section unpacked and without the index, so that changes reach the rows. */
static void give_unpacked(const unsigned char *data, size_t size, FuzzGive *give, void *context)
{
    struct libdeflate_decompressor *d = libdeflate_alloc_decompressor();
    size_t room = 1 << 22, at = HEADER, to = HEADER;
    unsigned char *out = malloc(room);
    if (!d || !out)
        fuzz_fail("no memory");
    memcpy(out, data, HEADER);
    while (at + HEAD <= size && memcmp(data + at, "INDX", 4) != 0) {
        size_t raw = (size_t)get(data + at + 16, 8), bytes = (size_t)get(data + at + 24, 8);
        if (raw > room - to - HEAD)
            fuzz_fail("a replay of %zu bytes is too large", size);
        memcpy(out + to, data + at, HEAD);
        if (!data[at + 4])
            memcpy(out + to + HEAD, data + at + HEAD, raw);
        else if (libdeflate_deflate_decompress(d, data + at + HEAD, bytes, out + to + HEAD, raw, NULL) != LIBDEFLATE_SUCCESS)
            fuzz_fail("a section cannot be unpacked");
        put(out + to + 4, 0, 4);
        put(out + to + 24, raw, 8);
        to += HEAD + raw;
        at += HEAD + bytes;
    }
    sign(out, to);
    give(context, out, to);
    free(out);
    libdeflate_free_decompressor(d);
}

static void record(dig_world *w, const char *path)
{
    char why[1400] = "";
    Recorder *r;
    dig_status s = recorder_open(path, w, "{\"script\":\"fuzz\"}", &r, why, sizeof why);
    if (s != DIG_OK)
        fuzz_fail("%s", why);
    s = recorder_listen(r);
    for (int i = 0; i < RECORDED && s == DIG_OK; i++) {
        s = recorder_note(r, "said", i % 2 ? "\"odd\"" : "[1,2]");
        if (s == DIG_OK)
            s = recorder_before_step(r);
        if (s == DIG_OK)
            s = dig_world_step(w);
        if (s == DIG_OK)
            s = recorder_step(r);
    }
    if (recorder_close(r, why, sizeof why) != DIG_OK || s != DIG_OK)
        fuzz_fail("recording: %s %s", why, dig_error(w));
}

static void replay_seeds(FuzzGive *give, void *context)
{
    for (int i = 0; fuzz_rooms[i]; i++) {
        char path[512];
        size_t size;
        FuzzState *f = fuzz_open("fuzz.lua", 100000000);
        if (fuzz_run(f, fuzz_rooms[i], strlen(fuzz_rooms[i])) != EXIT_FINE)
            fuzz_fail("room %d: %s", i, lua_tostring(fuzz_lua(f), -1));
        record(fuzz_world(f), scratch_path(path, sizeof path, "fuzz.replay"));
        unsigned char *data = read_whole(path, &size);
        remove(path);
        give_unpacked(data, size, give, context);
        free(data);
        fuzz_close(f);
    }
}

/* ---- questions ---- */

static void look_between(Replay *r, real time)
{
    View *v = NULL;
    if (replay_view(r, time, &v) != DIG_OK && !replay_error(r)[0])
        fuzz_fail("no picture of %g s and no sentence", time);
    dig_view_free(v);
}

static void ask_frame(Replay *r, int frame)
{
    const ReplayInfo *info = replay_info(r);
    const ReplayFrame *f;
    const void *bytes;
    size_t size;
    if (replay_frame(r, frame, &f) != DIG_OK) {
        if (!replay_error(r)[0])
            fuzz_fail("frame %d: no sentence", frame);
        return;
    }
    for (int i = 0; i < f->pose_count; i++)
        if (!replay_body(r, f->poses[i].body))
            fuzz_fail("frame %d: a pose of body %d of %d", frame, f->poses[i].body, info->bodies);
    look_between(r, f->time);
    look_between(r, f->time + 0.3 * info->step);
    replay_note(r, "said", frame, NULL);
    if (replay_commands(r, frame, &bytes, &size) == DIG_OK && size > 0)
        dig_command_look(bytes, size, NULL);
}

static void ask_all(Replay *r)
{
    const ReplayInfo *info = replay_info(r);
    size_t letters = strlen(info->origin) + strlen(info->digbox);
    for (int i = 0; i < info->bodies && i < 1000; i++) {
        const ReplayBody *b = replay_body(r, i);
        letters += strlen(b->name) + strlen(b->material) + strlen(b->shape);
    }
    for (int i = 0; i < info->frames && i < LOOKED_AT; i++)
        ask_frame(r, i);
    ask_frame(r, info->frames - 1);
    ask_frame(r, 0);                            /* and back */
    ask_frame(r, info->frames);
    ask_frame(r, -1);
    if (letters > (size_t)1 << 40)
        fuzz_fail("texts without an end");
}

static void replay_run(const unsigned char *data, size_t size)
{
    char why[1400] = "";
    Replay *r = NULL;
    Rerun again;
    unsigned char *copy = malloc(size + 1);
    if (!copy)
        fuzz_fail("no memory");
    memcpy(copy, data, size);
    sign(copy, size);
    dig_status s = replay_open(fuzz_file(copy, size), &r, why, sizeof why);
    free(copy);
    if (s != DIG_OK && (r || !why[0]))
        fuzz_fail("refused without a sentence");
    if (s != DIG_OK)
        return;
    ask_all(r);
    if (replay_info(r)->frames <= LOOKED_AT && replay_rerun(r, &again, why, sizeof why) != DIG_OK && !why[0])
        fuzz_fail("not simulated again, without a sentence");
    replay_close(r);
}

const FuzzTarget fuzz_replay = {.name = "replay", .longest = 1 << 19, .seeds = replay_seeds, .run = replay_run};
