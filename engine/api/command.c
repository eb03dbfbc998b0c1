/* api/command.c - the list of commands; carrying them out while somebody listens, and again from their bytes. */
#include "api/command.h"

#include <stdio.h>
#include <stdlib.h>

/* Arguments: b body, j joint, r region, w wire, g DIG, v vec3, n number, u whole number, y yes or no, s text; S text, V vec3, Q
 * quaternion, or none; definitions: B body, J joint, R region, O room, M material, P pair, W wire, T post, L list of a post, K settings of the joint before,
 * E effect of the caller's, X the same with who takes part, C bytes; by the name before: p field of a body,
 * m what an effect keeps of a body, o its options. After '>': what it returns. */
typedef struct Command {
    const char *name, *arguments;
    CommandRun *run;
    bool        leaves_traces;          /* even when it is refused */
} Command;

static const Command commands[COMMAND_IDS] = {
    [COMMAND_STEP]          = {"step", "", run_step, true},
    [COMMAND_GRAVITY]       = {"gravity", "v", run_gravity, false},
    [COMMAND_ACCURACY]      = {"accuracy", "Sn", run_accuracy, false},
    [COMMAND_SNAPSHOT]      = {"snapshot", "u", run_snapshot, false},
    [COMMAND_RESTORE]       = {"restore", "u", run_restore, false},
    [COMMAND_RESTORE_SAVED] = {"restore saved", "C", run_restore_saved, false},
    [COMMAND_FORGET]        = {"forget", "u", run_forget, false},

    [COMMAND_BODY]          = {"body", "B>b", run_body, true},
    [COMMAND_BODY_REMOVE]   = {"remove body", "b", run_body_remove, false},
    [COMMAND_PUSH]          = {"push", "bvvyn", run_push, false},
    [COMMAND_TWIST]         = {"twist", "bvn", run_twist, false},
    [COMMAND_HIT]           = {"hit", "bvvy", run_hit, false},
    [COMMAND_WARM]          = {"warm", "bnn", run_warm, false},
    [COMMAND_TELEPORT]      = {"teleport", "bVQVV", run_teleport, false},
    [COMMAND_MOVE_TO]       = {"move to", "bvQn", run_move_to, false},
    [COMMAND_VELOCITY]      = {"set velocity", "bvv", run_velocity, false},
    [COMMAND_BODY_SET]      = {"set body", "bsp", run_body_set, true},
    [COMMAND_WAKE]          = {"wake", "b", run_wake, false},

    [COMMAND_JOINT]         = {"joint", "J>j", run_joint, true},
    [COMMAND_JOINT_REMOVE]  = {"remove joint", "j", run_joint_remove, false},
    [COMMAND_JOINT_SET]     = {"set joint", "jK", run_joint_set, false},

    [COMMAND_ROOM]          = {"room", "O", run_room, true},
    [COMMAND_WALL]          = {"wall", "sy", run_wall, true},
    [COMMAND_REGION]        = {"region", "R>r", run_region, false},
    [COMMAND_REGION_REMOVE] = {"remove region", "r", run_region_remove, false},
    [COMMAND_REGION_PUSH]   = {"region push", "rbv", run_region_push, false},
    [COMMAND_MATERIAL]      = {"material", "sM", run_material, false},
    [COMMAND_PAIR]          = {"material pair", "P", run_pair, false},

    [COMMAND_EFFECT_JOIN]    = {"effect join", "sbmS", run_effect_join, false},
    [COMMAND_EFFECT_LEAVE]   = {"effect leave", "sb", run_effect_leave, false},
    [COMMAND_EFFECT_OPTION]  = {"effect option", "soS", run_effect_option, false},
    [COMMAND_EFFECT_SET]     = {"effect set", "sy", run_effect_set, false},
    [COMMAND_EFFECT_EXPLAIN] = {"effect explain", "sS", run_effect_explain, false},
    [COMMAND_EFFECT_ADD]     = {"effect add", "E", run_effect_add, false},
    [COMMAND_EFFECT_DROP]    = {"effect drop", "s", run_effect_drop, false},
    [COMMAND_EFFECT_THERE]   = {"effect there", "X", run_effect_there, false},

    [COMMAND_DIG_ACCURACY]  = {"DIG accuracy", "gSn", run_dig_accuracy, false},
    [COMMAND_WIRE]          = {"wire", "W>w", run_wire, true},
    [COMMAND_WIRE_SET]      = {"set wire", "wnn", run_wire_set, false},
    [COMMAND_WIRE_REMOVE]   = {"remove wire", "w", run_wire_remove, false},

    [COMMAND_POST]          = {"post", "T", run_post, true},
    [COMMAND_POST_LIST]     = {"post list", "TL", run_post_list, true},
    [COMMAND_ANSWERING]     = {"answering", "u", run_answering, false},
    [COMMAND_TAKE]          = {"take", "", run_take, false},
    [COMMAND_DROPPED]       = {"dropped", "u", run_dropped, false},

    [COMMAND_DISABLE]       = {"disable", "b", run_disable, false},
    [COMMAND_INJECT]        = {"inject", "b", run_inject, false},
};

const char *dig_command_name(int index) { return index >= 0 && index < COMMAND_IDS - 1 ? commands[index + 1].name : NULL; }

/* ---- its head ---- */

typedef struct Head { uint8_t id, status; uint32_t size; } Head;

static void pack_head(Pack *p, Head *h)
{
    pack_u8(p, &h->id);
    pack_u8(p, &h->status);
    pack_u32(p, &h->size);
}

static bool read_head(const void *bytes, size_t size, Head *h)
{
    Pack p = pack_reader(bytes, size);
    pack_head(&p, h);
    return pack_good(&p) && h->id >= 1 && h->id < COMMAND_IDS && h->status < DIG_STATUS_COUNT && h->size <= size - COMMAND_HEAD;
}

int dig_command_look(const void *bytes, size_t size, size_t *consumed)
{
    Head h;
    bool is_one = read_head(bytes, size, &h);
    if (consumed)
        *consumed = is_one ? COMMAND_HEAD + (size_t)h.size : 0;
    return is_one ? h.id - 1 : -1;
}

/* ---- listening ---- */

Pack *tap_stream(const World *w) { return w->tap && w->tap->inside ? &w->tap->bytes : NULL; }

void tap_release(Tap *t)
{
    if (!t || --t->users > 0)
        return;
    list_close(&t->forgotten);
    pack_close(&t->bytes);
    arena_close(&t->memory);
    free(t);
}

static void begin(Tap *t)
{
    unsigned char *data = t->bytes.data;
    size_t capacity = t->bytes.capacity;
    Head h = {0};
    t->bytes = pack_writer();           /* the buffer is used again */
    t->bytes.data = data;
    t->bytes.capacity = capacity;
    pack_head(&t->bytes, &h);
    arena_reset(&t->memory);
}

static void send(Tap *t, CommandId id, dig_status s)
{
    Head h = {(uint8_t)id, (uint8_t)s, (uint32_t)(t->bytes.size - COMMAND_HEAD)};
    size_t size = t->bytes.size;
    t->bytes.size = 0;
    pack_head(&t->bytes, &h);
    t->bytes.size = size;
    if (t->fn)
        t->fn(t->context, t->bytes.data, size);
}

static void send_forget(Tap *t, uint64_t snapshot)
{
    begin(t);
    pack_u64(&t->bytes, &snapshot);
    if (pack_good(&t->bytes))
        send(t, COMMAND_FORGET, DIG_OK);
}

/* Without memory to remember it, a replay keeps the snapshot to its end. */
void tap_forget(Tap *t, uint64_t snapshot)
{
    uint64_t allocations = 0;
    if (!t->inside)
        send_forget(t, snapshot);
    else if (list_push(&t->forgotten, &allocations) == DIG_OK)
        t->forgotten.data[t->forgotten.count - 1] = snapshot;
}

/* What cannot be written is refused by the call itself: an unknown type, a name without an end. */
dig_status command_do(World *w, CommandId id, CommandArg *a)
{
    const Command *c = &commands[id];
    Tap *t = w->tap;
    if (t->inside)
        return c->run(w, a);
    begin(t);
    Coder coder = {&t->bytes, w, &t->memory};
    command_arguments(&coder, c->arguments, a);
    if (t->bytes.no_memory)
        return world_fail(w, DIG_E_MEMORY, "not enough memory to log a command");
    t->inside = true;
    dig_status s = c->run(w, a);
    t->inside = false;
    if (s == DIG_OK || c->leaves_traces) {
        command_results(&coder, c->arguments, a);
        if (pack_good(&t->bytes))
            send(t, id, s);
    }
    for (int i = 0; i < t->forgotten.count; i++)
        send_forget(t, t->forgotten.data[i]);
    t->forgotten.count = 0;
    return s;
}

dig_status dig_world_tap(dig_world *w, dig_tap_fn *fn, void *context)
{
    if (w->busy || (w->tap && w->tap->inside) || (w->tap && fn))
        return world_fail(w, DIG_E_BUSY, w->tap ? "tap: somebody listens already" : "tap: the world is stepping");
    if (!fn) {
        if (w->tap)
            w->tap->fn = NULL;
        tap_release(w->tap);
        w->tap = NULL;
        return DIG_OK;
    }
    if (!(w->tap = calloc(1, sizeof *w->tap)))
        return world_fail(w, DIG_E_MEMORY, "tap: not enough memory");
    *w->tap = (Tap){.users = 1, .fn = fn, .context = context};
    dig_status s = tap_effects(w);
    if (s != DIG_OK) {
        tap_release(w->tap);
        w->tap = NULL;
    }
    return s;
}

/* ---- playing ---- */

void playback_close(Playback *b)
{
    if (!b)
        return;
    for (int i = 0; i < b->snapshots.count; i++)
        dig_snapshot_free(b->snapshots.data[i].snapshot);
    list_close(&b->snapshots);
    arena_close(&b->memory);
    free(b);
}

static dig_status play(World *w, const Head *h, Pack *p)
{
    const Command *c = &commands[h->id];
    CommandArg a[COMMAND_ARGS] = {{.what = NULL}};
    Coder coder = {p, w, &w->playback->memory};
    arena_reset(coder.memory);
    command_arguments(&coder, c->arguments, a);
    if (!pack_good(p))
        return world_fail(w, p->no_memory ? DIG_E_MEMORY : DIG_E_FORMAT, "command '%s': %s", c->name, p->why);
    w->playback->stream = p;
    dig_status s = w->tap ? command_do(w, h->id, a) : c->run(w, a);
    w->playback->stream = NULL;
    if (s != (dig_status)h->status) {
        char why[sizeof w->error];      /* not from the buffer that it goes to */
        memcpy(why, w->error, sizeof why);
        if (s == DIG_E_MEMORY)
            return s;                   /* that says nothing about the log */
        return world_fail(w, DIG_E_KIND, "command '%s' returned '%s', and '%s' when it was logged%s%s", c->name, dig_status_name(s),
                          dig_status_name((dig_status)h->status), s ? ": " : "", s ? why : "");
    }
    command_results(&coder, c->arguments, a);
    pack_end(p);
    return pack_good(p) ? DIG_OK : world_fail(w, p->no_memory ? DIG_E_MEMORY : DIG_E_KIND, "command '%s': %s", c->name, p->why);
}

dig_status dig_command_play(dig_world *w, const void *bytes, size_t size, size_t *consumed)
{
    Head h;
    if (consumed)
        *consumed = 0;
    if (w->busy || (w->playback && w->playback->stream))
        return world_fail(w, DIG_E_BUSY, "a command cannot be played while the world is stepping");
    if (!read_head(bytes, size, &h))
        return world_fail(w, DIG_E_FORMAT, "this is no command of digbox %s, or it is cut short", DIGBOX_VERSION);
    if (!w->playback && !(w->playback = calloc(1, sizeof *w->playback)))
        return world_fail(w, DIG_E_MEMORY, "not enough memory to play a command");
    Pack p = pack_reader((const char *)bytes + COMMAND_HEAD, h.size);
    dig_status s = play(w, &h, &p);
    if (consumed && s == DIG_OK)
        *consumed = COMMAND_HEAD + (size_t)h.size;
    return s;
}
