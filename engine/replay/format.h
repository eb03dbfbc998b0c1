/* replay/format.h - the bytes of a replay, shared by those who write and who read them. docs/replay.md has the whole.
 *
 * A file is a header, sections and a trailer. Each section has a header of its own with its sizes and checksums, so that a file
 * without its end is read by going from section to section. The frames of a block are tables (view/look.h and the four below);
 * a frame holds the rows that changed.
 *
 * Owns:      a Kept owns its tables.
 * Floor:     replay.
 */
#ifndef DIG_REPLAY_FORMAT_H
#define DIG_REPLAY_FORMAT_H

#include "base/pack.h"
#include "replay/replay.h"
#include "view/look.h"

#include <libdeflate.h>

#define REPLAY_FORMAT 5u

/* ---- sections ---- */

enum { REPLAY_HEADER = 64, SECTION_HEADER = 40, REPLAY_TRAILER = 24, REPLAY_VERSION = 16 };

typedef struct Section {
    char     tag[4];
    uint32_t packed;            /* 0: as it is, 1: deflate                      */
    uint32_t first, count;      /* frames that it is about; else 0              */
    uint64_t raw, size;         /* bytes, before and after packing              */
    uint32_t crc;               /* of the bytes in the file                     */
    uint64_t offset;            /* in the file, of its header; not in the header */
} Section;

typedef struct ReplayHeader {
    uint32_t format;
    char     version[REPLAY_VERSION + 1];
    uint64_t first_step, seed;
    real     step;              /* s                                            */
} ReplayHeader;

extern const unsigned char replay_magic[8], replay_end_magic[8];

void replay_header(Pack *p, ReplayHeader *h);           /* without its checksum */
/* With the checksum of the header at its end. */
void section_header(Pack *p, Section *s);
/* So many bytes at most come out of deflate for one that goes in. */
#define DEFLATE_RATIO 1032u

/* ---- tables ---- */

enum { KEPT_FLOWS = LOOK_TABLES, KEPT_EVENTS, KEPT_STATE, KEPT_CAMERAS, KEPT_TABLES };

typedef struct KeptFlow {       /* of the edge with the same number             */
    real     began;             /* s                                            */
    uint32_t joint, joint_gen;  /* LOOK_NONE, 0: none                           */
    float    effort[3], flow[3];
    float    point[3], normal[3];       /* m from the origin                    */
} KeptFlow;

typedef struct KeptEvent {      /* dig_event                                    */
    real     time, speed, impulse, stress;
    vec3     point, normal;
    uint64_t message;
    uint32_t kind, a[2], b[2], joint[2], region[2];     /* slot, generation     */
    uint32_t dig, other_dig, wall, link, layer;
} KeptEvent;

typedef struct KeptState {      /* one row: of the world after the step         */
    uint64_t   checksum;
    dig_energy energy;
} KeptState;

typedef struct KeptCamera {     /* ReplayCamera                                 */
    vec3     at, look_at, up;   /* zero: not said                               */
    real     fov;               /* rad                                          */
    uint32_t says, spare;       /* CAMERA_AT | ...                              */
    char     name[REPLAY_CAMERA_NAME];
} KeptCamera;

enum { CAMERA_AT = 1, CAMERA_LOOK_AT = 2, CAMERA_UP = 4 };

typedef struct Kept { Look look; ListAny extra[KEPT_TABLES - LOOK_TABLES]; } Kept;

static inline ListAny *kept_table(Kept *k, int t) { return t < LOOK_TABLES ? &k->look.tables[t] : &k->extra[t - LOOK_TABLES]; }
static inline KeptFlow *kept_flows(const Kept *k) { return k->extra[KEPT_FLOWS - LOOK_TABLES].data; }
static inline KeptEvent *kept_events(const Kept *k) { return k->extra[KEPT_EVENTS - LOOK_TABLES].data; }
static inline KeptState *kept_state(const Kept *k) { return k->extra[KEPT_STATE - LOOK_TABLES].data; }
static inline KeptCamera *kept_cameras(const Kept *k) { return k->extra[KEPT_CAMERAS - LOOK_TABLES].data; }
size_t     kept_row_size(int table);
dig_status kept_resize(Kept *k, int table, int count);
dig_status kept_copy(Kept *to, const Kept *from);       /* but for the meshes */
void       kept_clear(Kept *k);                         /* no rows in any table */
void       kept_close(Kept *k);

/* Writes what differs from `last` in the rows of a table; `last` then is as they are. All tables of a frame in their order. */
void delta_write(Pack *p, int table, int count, const unsigned char *rows, Kept *last);
/* Changes the rows that are written. */
void delta_read(Pack *p, Kept *k);

typedef enum RecordKind {
    RECORD_FRAME,               /* the next frame, after its step               */
    RECORD_LEFT,                /* the same frame, as the script left it before the next step */
    RECORD_KINDS
} RecordKind;

/* ---- meshes, bodies, notes ---- */

void replay_mesh(Pack *p, LookMesh *m);                   /* reading takes memory for what the bytes hold */

typedef struct KeptBody {
    uint32_t index, slot, gen, kind, born;
    real     mass;              /* kg; infinite: does not move by forces        */
    vec3     centre;
    char     name[64], material[64], shape[16];
} KeptBody;

void replay_kept_body(Pack *p, KeptBody *b);

#endif
