/* api/command.h - calls that change a world, as bytes, and carried out again from them.
 *
 * Every public function that changes a world is a row of the table in command.c: a name, its arguments by letters, and a
 * function that calls it. Somebody who taps the world (dig_world_tap) gets the bytes of each call; dig_command_play reads them
 * and calls the same function of another world in the same state, which then does the same.
 *
 * A command, all numbers little-endian:
 *
 *    0  u8 number (CommandId), 1 u8 status that the call returned, 2 u32 bytes that follow
 *    6  its arguments, letter by letter (command_code.c)
 *       what effects of the caller's gave back while it was carried out, in order (command_own.c)
 *       the handles that it returned
 *
 * Handles are relative to the first of their world, as in files of worlds. What a call refused is no command, unless it may
 * leave a trace (a number that was given, a body that woke).
 *
 * Cost: a world that nobody taps pays one branch a call.
 * Owns:      a Tap its buffer; a Playback the snapshots that were taken in it and the memory of the command being played.
 * Floor:     api.
 */
#ifndef DIG_COMMAND_H
#define DIG_COMMAND_H

#include "api/save.h"

/* Numbers are those of files: new ones go to the end. */
typedef enum CommandId {
    COMMAND_STEP = 1, COMMAND_GRAVITY, COMMAND_ACCURACY, COMMAND_SNAPSHOT, COMMAND_RESTORE, COMMAND_RESTORE_SAVED, COMMAND_FORGET,
    COMMAND_BODY, COMMAND_BODY_REMOVE, COMMAND_PUSH, COMMAND_TWIST, COMMAND_HIT, COMMAND_WARM, COMMAND_TELEPORT, COMMAND_MOVE_TO,
    COMMAND_VELOCITY, COMMAND_BODY_SET, COMMAND_WAKE,
    COMMAND_JOINT, COMMAND_JOINT_REMOVE, COMMAND_JOINT_SET,
    COMMAND_ROOM, COMMAND_WALL, COMMAND_REGION, COMMAND_REGION_REMOVE, COMMAND_REGION_PUSH, COMMAND_MATERIAL, COMMAND_PAIR,
    COMMAND_EFFECT_JOIN, COMMAND_EFFECT_LEAVE, COMMAND_EFFECT_OPTION, COMMAND_EFFECT_SET, COMMAND_EFFECT_EXPLAIN,
    COMMAND_EFFECT_ADD, COMMAND_EFFECT_DROP, COMMAND_EFFECT_THERE,
    COMMAND_DIG_ACCURACY, COMMAND_WIRE, COMMAND_WIRE_SET, COMMAND_WIRE_REMOVE,
    COMMAND_POST, COMMAND_POST_LIST, COMMAND_ANSWERING, COMMAND_TAKE, COMMAND_DROPPED,
    COMMAND_DISABLE, COMMAND_INJECT,
    COMMAND_IDS
} CommandId;

#define COMMAND_ARGS 6
#define COMMAND_HEAD 6u         /* bytes before the arguments */

typedef union CommandArg {
    dig_body   body;
    dig_joint  joint;
    dig_region region;
    dig_dig    dig;
    dig_wire   wire;
    vec3       vec;
    real       number;
    uint64_t   whole;
    bool       yes;
    const void *what;           /* a text or a struct, or NULL */
    void       *place;          /* where a result goes         */
} CommandArg;

typedef dig_status CommandRun(World *w, CommandArg *a);

typedef struct CommandList { const dig_body *to; const real *value; int count; } CommandList;   /* of dig_message_list */
typedef struct CommandSettings { const dig_setting *set; int count; } CommandSettings;          /* of dig_joint_set */
typedef struct CommandBytes { const void *data; size_t size; } CommandBytes;

/* An effect of the caller's that is there when a log begins. */
typedef struct CommandEffect {
    dig_effect_def  def;
    bool            on, forced;
    const dig_body *members;
    int             count;
} CommandEffect;

/* ---- calling ---- */

/* `call`, or when somebody listens the same through the table. */
#define COMMAND(w, id, call, ...) ((w)->tap ? command_do((w), (id), (CommandArg[COMMAND_ARGS]){__VA_ARGS__}) : (call))

dig_status command_do(World *w, CommandId id, CommandArg *a);

/* ---- tables, each next to the call that it makes ---- */

CommandRun run_step, run_gravity, run_accuracy, run_snapshot, run_restore, run_restore_saved, run_forget;
CommandRun run_body, run_body_remove, run_push, run_twist, run_hit, run_warm, run_teleport, run_move_to, run_velocity, run_body_set, run_wake;
CommandRun run_disable, run_inject;
CommandRun run_joint, run_joint_remove, run_joint_set;
CommandRun run_room, run_wall, run_region, run_region_remove, run_region_push, run_material, run_pair;
CommandRun run_effect_join, run_effect_leave, run_effect_option, run_effect_set, run_effect_explain;
CommandRun run_effect_add, run_effect_drop, run_effect_there;
CommandRun run_dig_accuracy, run_wire, run_wire_set, run_wire_remove;
CommandRun run_post, run_post_list, run_answering, run_take, run_dropped;

/* ---- arguments: command_code.c ---- */

typedef struct Coder {
    Pack  *p;
    World *w;
    Arena *memory;              /* of what is read, and of copies of what is written */
} Coder;

/* Writes or reads the arguments of these letters; results (after '>') get a place when they are read, and nothing else. */
void command_arguments(Coder *c, const char *letters, CommandArg *a);
/* Writes the results, or reads them and fails where they are others than those in place. */
void command_results(Coder *c, const char *letters, CommandArg *a);

/* ---- who listens ---- */

typedef struct Tap {
    int          users;         /* its world, and the snapshots taken meanwhile */
    dig_tap_fn  *fn;            /* NULL: it is over                             */
    void        *context;
    Pack         bytes;         /* of the command that is carried out           */
    Arena        memory;
    bool         inside;        /* a command is being carried out: what it calls is part of it */
    uint64_t     snapshots;     /* taken so far                                 */
    LIST(uint64_t) forgotten;   /* of these, meanwhile                          */
} Tap;

void tap_release(Tap *t);               /* NULL is allowed; the last user frees it */
/* The bytes that a command in work is written to; NULL: none is, or nobody listens. */
Pack *tap_stream(const World *w);
/* A snapshot was freed, perhaps while a command is carried out: a script's function in a step may collect its garbage. */
void tap_forget(Tap *t, uint64_t snapshot);
/* Effects of the caller's, which no file holds, as commands. */
dig_status tap_effects(World *w);

/* ---- a world that is played ---- */

typedef struct PlaybackSnapshot { uint64_t number; dig_snapshot *snapshot; } PlaybackSnapshot;

typedef struct Playback {
    Pack  *stream;              /* of the command in work; NULL: of none */
    Arena  memory;
    LIST(PlaybackSnapshot) snapshots;
    uint64_t allocations;
} Playback;

void playback_close(Playback *b);       /* NULL is allowed */

/* What an effect of the caller's gave back, written to the log of a world that is tapped. */
dig_status command_answer(const World *w, dig_status s, const dig_effect_call *call, const char *why);
dig_status command_answer_energy(const World *w, real energy);
/* An effect whose functions read what they are to give back from the log that is played. */
void command_play_effect(World *w, dig_effect_def *def, bool energy);

#endif
