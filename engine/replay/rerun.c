/* replay/rerun.c - the log of commands of a replay, played again. */
#include "replay/rerun.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

static void differs(Rerun *o, const dig_world *w, int frame, const char *what)
{
    o->differs = frame;
    o->step = dig_world_steps(w);
    snprintf(o->why, sizeof o->why, "%s", what);
}

typedef struct Log { const unsigned char *bytes; size_t size, at; } Log;     /* of one frame */

/* Effects of the caller's, which no file of a world holds, stand first in a log: they belong to the world that it starts from. */
static bool is_part_of_start(const Log *l)
{
    const char *name = dig_command_name(dig_command_look(l->bytes + l->at, l->size - l->at, NULL));
    return name && strcmp(name, "effect there") == 0;
}

/* All commands that led to a frame, or those of the start. */
static dig_status play(dig_world *w, int frame, Log *l, bool start, Rerun *o, char *why, size_t capacity)
{
    for (size_t length; l->at < l->size && (!start || is_part_of_start(l)); l->at += length) {
        dig_status s = dig_command_play(w, l->bytes + l->at, l->size - l->at, &length);
        if (s == DIG_E_KIND) {
            differs(o, w, frame, dig_error(w));
            return DIG_OK;
        }
        if (s != DIG_OK) {
            snprintf(why, capacity, "frame %d: %s", frame, dig_error(w));
            return s;
        }
        o->commands++;
    }
    return DIG_OK;
}

static dig_status log_of(Replay *r, int frame, Log *l, char *why, size_t capacity)
{
    const void *bytes = NULL;
    dig_status s = replay_commands(r, frame, &bytes, &l->size);
    l->bytes = bytes;
    l->at = 0;
    if (s != DIG_OK)
        snprintf(why, capacity, "%s", replay_error(r));
    return s;
}

static dig_status compare(dig_world *w, Replay *r, int frame, Rerun *o, char *why, size_t capacity)
{
    const ReplayFrame *f;
    dig_status s = replay_frame(r, frame, &f);
    if (s != DIG_OK) {
        snprintf(why, capacity, "%s", replay_error(r));
        return s;
    }
    o->was = f->checksum;
    o->is = dig_world_checksum(w);
    if (o->was != o->is)
        differs(o, w, frame, frame > 0 ? "the step led to another state" : "the world it starts from has another state");
    else
        o->frames++;
    return DIG_OK;
}

static dig_status play_frames(dig_world *w, Replay *r, Rerun *o, char *why, size_t capacity)
{
    Log l = {NULL, 0, 0};
    if (replay_info(r)->frames > 1) {
        DIG_TRY(log_of(r, 1, &l, why, capacity));
        DIG_TRY(play(w, 0, &l, true, o, why, capacity));
    }
    if (o->differs < 0)
        DIG_TRY(compare(w, r, 0, o, why, capacity));
    for (int i = 1; i < replay_info(r)->frames && o->differs < 0; i++) {
        size_t done = i == 1 ? l.at : 0;
        DIG_TRY(log_of(r, i, &l, why, capacity));
        l.at = done;
        DIG_TRY(play(w, i, &l, false, o, why, capacity));
        if (o->differs < 0)
            DIG_TRY(compare(w, r, i, o, why, capacity));
    }
    return DIG_OK;
}

dig_status replay_rerun(Replay *r, Rerun *out, char *why, size_t capacity)
{
    const void *bytes;
    size_t size;
    dig_world *w;
    *out = (Rerun){.differs = -1};
    dig_status s = replay_start(r, &bytes, &size);
    if (s != DIG_OK) {
        snprintf(why, capacity, "%s", replay_error(r));
        return s;
    }
    DIG_TRY(dig_world_unpack(bytes, size, &w, why, capacity));
    s = play_frames(w, r, out, why, capacity);
    dig_world_close(w);
    return s;
}
