/* replay/replay.h - a run that is kept in a file, and read again.
 *
 * A replay holds what is needed to look at a run without simulating it (poses in double, shapes, contacts, links, events,
 * energies), the checksum after every step, and the log of commands from which the run is simulated again. docs/replay.md
 * describes the bytes.
 *
 * Frames are numbered from 0, the state before the first step; frame n is the state after n steps that were recorded. The
 * world may be stepped before recording begins: RecordInfo.first_step says how often.
 *
 * Owns:      a Recorder its file, until recorder_close; a Replay its file and what it decoded. What a reading function
 *            returns belongs to the Replay and stays valid until the next call with another frame.
 * Invariant: a file cut short opens up to its last whole block.
 * Floor:     replay. Includes base, math, world, view, api.
 */
#ifndef DIG_REPLAY_H
#define DIG_REPLAY_H

#include "view/view.h"

/* At the time of a frame there are two states: what the step led to, and what the script made of it before the next step (it
 * moves, adds and removes bodies between steps). replay_frame and a picture of that very moment show the second, as a film does;
 * a picture of a moment before it is on the way to the first. The checksum, energies and events are of the first.
 */

/* ---- writing --------------------------------------------------------------------- */

typedef struct Recorder Recorder;

/* Begins a replay of w, which is not stepped meanwhile. `origin` is text for people and tools (script, arguments, version,
 * seed), a JSON object; it is kept as it is. Fails with a sentence that names the path. */
dig_status recorder_open(const char *path, dig_world *w, const char *origin, Recorder **out, char *why, size_t capacity);
/* Before each step: what the script did since the last one becomes part of its frame. Costs little when nothing was done. */
dig_status recorder_before_step(Recorder *r);
/* After each step of the world. */
dig_status recorder_step(Recorder *r);
/* From here on what is done to the world goes into the replay: its state now, and each command (dig_world_tap). Once, before the
 * first step; it calls the two below. */
dig_status recorder_listen(Recorder *r);
/* Bytes of the log of commands since the last step; gathered until the next frame. */
dig_status recorder_commands(Recorder *r, const void *bytes, size_t size);
/* The bytes of a saved world from which the commands start. */
dig_status recorder_start(Recorder *r, const void *bytes, size_t size);
/* What a script says of a camera; who draws chooses the rest. */
enum { REPLAY_CAMERA_NAME = 64 };
typedef struct ReplayCamera {
    char name[REPLAY_CAMERA_NAME];
    bool has_at, has_look_at, has_up;
    vec3 at, look_at, up;       /* m; m; direction */
    real fov;                   /* rad */
} ReplayCamera;

/* Where the cameras stand from now on. Before recorder_step: where the step led them; else: where the script left them. */
dig_status recorder_cameras(Recorder *r, const ReplayCamera *list, int count);
/* A named text that belongs to the whole run or to the frame of this moment: lights, films, what a script printed. A later
 * note of the same name takes the place of the earlier one from its frame on. Text is JSON; `name` at most 31 bytes. */
dig_status recorder_note(Recorder *r, const char *name, const char *text);
/* The world was closed: nothing more is taken from it. */
void recorder_lose_world(Recorder *r);
const char *recorder_error(const Recorder *r);         /* the first failure, which ends the recording; "" = none */
/* Writes the index and closes; the world must still be there. After a failure (disk full) the file is still readable to its last
 * whole block. NULL: nothing to do. */
dig_status recorder_close(Recorder *r, char *why, size_t capacity);

/* ---- reading --------------------------------------------------------------------- */

typedef struct Replay Replay;

typedef struct ReplayInfo {
    uint32_t    version;        /* of the format */
    uint64_t    first_step;     /* steps of the world before frame 0 */
    int         frames;         /* at least 1 */
    int         bodies;         /* all that were ever there; their indices are 0..bodies-1 */
    real        step;           /* s */
    uint64_t    seed;
    bool        cut;            /* the file ended early: frames up to its last whole block are there */
    const char *origin;         /* JSON */
    const char *digbox;         /* version of the program that wrote it */
} ReplayInfo;

/* A body from birth to removal. A slot that is used again makes another one. */
typedef struct ReplayBody {
    dig_body      id;
    const char   *name, *material;
    dig_body_kind kind;
    real          mass;         /* kg when it was made; infinite for static bodies */
    vec3          centre;       /* m, centre of mass in the body */
    int           born, died;   /* frames; died = frames when it was there to the end */
    const char   *shape;        /* type of its first shape, "sphere", ... */
} ReplayBody;

typedef struct ReplayPose {     /* of one body at one frame */
    int      body;              /* index */
    vec3     position;          /* m, origin of the body */
    quat     rotation;
    vec3     velocity, spin;    /* m/s of the centre of mass, rad/s */
    vec3     force;             /* N, mean resultant over the step */
    uint32_t dig;               /* id, 0 = none */
    real     temperature;       /* K, 0 = it has none */
    bool     awake;
    dig_mode mode;
} ReplayPose;

typedef struct ReplayFrame {
    int               frame;
    real              time;     /* s */
    uint64_t          checksum; /* of the world after the step */
    dig_energy        energy;
    const ReplayPose *poses; int pose_count;    /* bodies that are there, by index */
    const dig_event  *events; int event_count;  /* of the step that led here; bodies by id */
    const dig_link   *links; int link_count;    /* mechanical and other layers; each link once */
    int               struts;   /* joints that are drawn as bars */
} ReplayFrame;

dig_status        replay_open(const char *path, Replay **out, char *why, size_t capacity);
void              replay_close(Replay *r);
const char       *replay_error(const Replay *r);        /* of the last call that failed */
const ReplayInfo *replay_info(const Replay *r);
const ReplayBody *replay_body(const Replay *r, int index);      /* NULL past the end */
int               replay_body_of(const Replay *r, dig_body id); /* index, or -1 */
dig_status        replay_frame(Replay *r, int frame, const ReplayFrame **out);
/* The picture of a moment, s, between frames blended as films are; free it with dig_view_free. */
dig_status        replay_view(Replay *r, real time, View **out);
/* Feeds what was in the frames from..frame to a Past (view/past.h), whose last one was from - 1: where bodies were, energies. */
struct Past;
dig_status        replay_past(Replay *r, int from, int frame, bool points, bool energies, struct Past *past);
/* The saved world and the commands that led to a frame; DIG_E_FORMAT: there are none, or they cannot be read. */
dig_status        replay_start(Replay *r, const void **bytes, size_t *size);
dig_status        replay_commands(Replay *r, int frame, const void **bytes, size_t *size);
/* The cameras at a frame: where its step led them (`arrived`), or where the script left them. */
dig_status        replay_cameras(Replay *r, int frame, bool arrived, const ReplayCamera **out, int *count);
/* The note of that name that holds at a frame, or NULL; `since` (may be NULL) gets its frame. */
const char       *replay_note(const Replay *r, const char *name, int frame, int *since);

#endif
