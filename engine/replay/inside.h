/* replay/inside.h - a replay that is open, shared by the files that read it.
 *
 * Owns:      the file and all below.
 * Invariant: `sections` were checked against the size of the file; nothing else was trusted.
 * Floor:     replay.
 */
#ifndef DIG_REPLAY_INSIDE_H
#define DIG_REPLAY_INSIDE_H

#include "replay/format.h"
#include "replay/replay.h"

typedef struct Note { char name[32]; uint32_t frame, order; char *text; } Note;

/* A section in memory, unpacked, and which one it is. */
typedef struct Loaded { int section; unsigned char *data; size_t size; } Loaded;

struct Replay {
    int        file;
    uint64_t   size;            /* bytes of the file                              */
    ReplayInfo info;
    ReplayHeader header;
    char      *origin;
    LIST(Section)    sections;  /* in the order of the file                       */
    LIST(int)        blocks;    /* sections of frames, by frame                   */
    LIST(KeptBody)   kept_bodies;
    LIST(ReplayBody) bodies;
    LIST(Note)       notes;     /* by name, frame, order                          */
    uint32_t   orders;          /* notes so far                                   */
    LIST(LookMesh)   meshes;
    Map        body_map;        /* (slot, gen) -> index                           */

    /* where reading of frames stands */
    Loaded     block, commands, start;
    Pack       cursor;          /* in the block; next record                      */
    int        block_frame;     /* of the last record that was read; -1: none     */
    bool       left;            /* that record is of what the script left         */
    Kept       now;             /* after that record                              */
    Kept       before;          /* for views: a frame as it was left              */
    int        before_frame;    /* -1: none                                       */

    /* what replay_frame returned */
    ReplayFrame frame;
    LIST(ReplayPose) poses;
    LIST(dig_event)  events;
    LIST(dig_link)   links;
    LIST(ReplayCamera) cameras;
    char       path[1024], why[1400];
    struct libdeflate_decompressor *decompressor;
};

dig_status replay_fail(Replay *r, dig_status s, const char *format, ...) DIG_PRINTF(3, 4);
/* Reads and unpacks a section, unless it is loaded. */
dig_status replay_load(Replay *r, int section, Loaded *to);
void       replay_unload(Loaded *l);
/* frames.c: reads on to a frame as its step led to it, or as it was left */
dig_status replay_go(Replay *r, int frame, bool left);
/* open.c: the sections, in the index or one after the other; meshes, bodies, notes */
dig_status replay_find_sections(Replay *r);
dig_status replay_read_records(Replay *r);

#endif
