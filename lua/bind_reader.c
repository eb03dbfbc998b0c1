/* lua/bind_reader.c - a replay, read for `digbox render`: its frames' views, notes and energies. What becomes of them is decided in
 * lua/digbox/render.lua. */
#include "bind.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "render/render.h"
#include "replay/replay.h"
#include "state.h"

#define READER "digbox.reader"

enum { TRAIL_LENGTH = 31, MOST_SAMPLES = 512 };

typedef struct ReaderRef {
    Replay *r;
    real   *energies;           /* [1 + RENDER_ENERGIES] each, all along the run; NULL = not read yet */
    int     energy_count;
} ReaderRef;

typedef struct HistoryRef { RenderHistory h; real *trails; } HistoryRef;

static Replay *check_reader(lua_State *L)
{
    ReaderRef *ref = luaL_checkudata(L, 1, READER);
    return ref->r;
}

/* core.reader(path) -> reader, or nil and a sentence */
static int reader_open(lua_State *L)
{
    char why[1400] = "";
    const char *path = luaL_checkstring(L, 1);
    ReaderRef *ref = lua_newuserdatauv(L, sizeof *ref, 0);
    *ref = (ReaderRef){NULL, NULL, 0};
    luaL_setmetatable(L, READER);
    if (replay_open(path, &ref->r, why, sizeof why) == DIG_OK)
        return 1;
    lua_pushnil(L);
    lua_pushstring(L, why);
    return 2;
}

static int reader_gc(lua_State *L)
{
    ReaderRef *ref = luaL_checkudata(L, 1, READER);
    replay_close(ref->r);
    free(ref->energies);
    *ref = (ReaderRef){NULL, NULL, 0};
    return 0;
}

static void set_number(lua_State *L, const char *name, real value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, name);
}

/* core.reader_info(reader) -> {frames, first_step, step, seed, cut, origin} */
static int reader_info(lua_State *L)
{
    const ReplayInfo *info = replay_info(check_reader(L));
    lua_newtable(L);
    lua_pushinteger(L, info->frames);
    lua_setfield(L, -2, "frames");
    lua_pushinteger(L, (lua_Integer)info->first_step);
    lua_setfield(L, -2, "first_step");
    lua_pushinteger(L, (lua_Integer)info->seed);
    lua_setfield(L, -2, "seed");
    lua_pushboolean(L, info->cut);
    lua_setfield(L, -2, "cut");
    set_number(L, "step", info->step);
    bind_set_text(L, "origin", info->origin);
    return 1;
}

/* JSON as Lua has it: whole numbers are integers, null is nil, lists from 1. cJSON bounds the nesting. */
static void push_json(lua_State *L, const cJSON *j)
{
    const cJSON *item;
    lua_Integer n = 0, whole;
    luaL_checkstack(L, 4, "too deep");
    if (!cJSON_IsArray(j) && !cJSON_IsObject(j)) {
        if (cJSON_IsNumber(j) && lua_numbertointeger(j->valuedouble, &whole) && (lua_Number)whole == j->valuedouble)
            lua_pushinteger(L, whole);
        else if (cJSON_IsNumber(j))
            lua_pushnumber(L, j->valuedouble);
        else if (cJSON_IsBool(j))
            lua_pushboolean(L, cJSON_IsTrue(j));
        else
            lua_pushstring(L, cJSON_GetStringValue(j));         /* null: nil */
        return;
    }
    lua_newtable(L);
    cJSON_ArrayForEach(item, j) {
        push_json(L, item);
        if (cJSON_IsArray(j))
            lua_rawseti(L, -2, ++n);
        else
            lua_setfield(L, -2, item->string);
    }
}

static int push_note(lua_State *L)
{
    push_json(L, lua_touserdata(L, 1));
    return 1;
}

/* core.reader_note(reader, name, frame) -> value of the note, or nil where there is none */
static int reader_note(lua_State *L)
{
    const char *name = luaL_checkstring(L, 2), *text = replay_note(check_reader(L), name, (int)luaL_checkinteger(L, 3), NULL);
    if (!text)
        return 0;
    cJSON *note = cJSON_Parse(text);
    lua_pushcfunction(L, push_note);
    lua_pushlightuserdata(L, note);
    int failed = note ? lua_pcall(L, 1, 1, 0) : LUA_OK;         /* no memory: the note is freed all the same */
    cJSON_Delete(note);
    if (!note)
        return bind_error(L, "the replay's note '%s' is damaged", name);
    return failed == LUA_OK ? 1 : lua_error(L);
}

static void set_vector(lua_State *L, const char *name, bool there, vec3 v)
{
    if (!there)
        return;
    bind_push_vec3(L, v);
    lua_setfield(L, -2, name);
}

/* core.reader_cameras(reader, frame, arrived) -> {{name=, at=, look_at=, up=, fov=}, ...}, as the script left them or its step led to */
static int reader_cameras(lua_State *L)
{
    Replay *r = check_reader(L);
    const ReplayCamera *list;
    int count;
    dig_status s = replay_cameras(r, (int)luaL_checkinteger(L, 2), lua_toboolean(L, 3), &list, &count);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    lua_createtable(L, count, 0);
    for (int i = 0; i < count; i++) {
        lua_newtable(L);
        bind_set_text(L, "name", list[i].name);
        set_vector(L, "at", list[i].has_at, list[i].at);
        set_vector(L, "look_at", list[i].has_look_at, list[i].look_at);
        set_vector(L, "up", list[i].has_up, list[i].up);
        set_number(L, "fov", list[i].fov);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* core.reader_view(reader, time) -> view */
static int reader_view(lua_State *L)
{
    Replay *r = check_reader(L);
    View *v = NULL;
    dig_status s = replay_view(r, luaL_checknumber(L, 2), &v);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    v->seed = replay_info(r)->seed;
    return bind_push_view(L, v);
}

/* core.reader_checksum(reader, frame) -> 16 hexadecimal digits */
static int reader_checksum(lua_State *L)
{
    Replay *r = check_reader(L);
    const ReplayFrame *f;
    char text[24];
    dig_status s = replay_frame(r, (int)luaL_checkinteger(L, 2), &f);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    snprintf(text, sizeof text, "%016llx", (unsigned long long)f->checksum);
    lua_pushstring(L, text);
    return 1;
}

/* ---- what was before: for trails and the energy strip --------------------------------- */

#define HISTORY "digbox.history"

const RenderHistory *bind_history(lua_State *L, int index)
{
    const HistoryRef *ref = luaL_checkudata(L, index, HISTORY);
    return &ref->h;
}

static int history_gc(lua_State *L)
{
    HistoryRef *ref = luaL_checkudata(L, 1, HISTORY);
    free(ref->trails);
    *ref = (HistoryRef){0};
    return 0;
}

static const ReplayFrame *frame_at(lua_State *L, Replay *r, int frame)
{
    const ReplayFrame *f;
    dig_status s = replay_frame(r, frame, &f);
    if (s != DIG_OK)
        bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FORMAT, "%s", replay_error(r));
    return f;
}

/* The energies all along the run, at most MOST_SAMPLES of them; read once. */
static void read_energies(lua_State *L, ReaderRef *ref)
{
    const ReplayInfo *info = replay_info(ref->r);
    int stride = (info->frames + MOST_SAMPLES - 1) / MOST_SAMPLES;
    if (ref->energies)
        return;
    ref->energies = calloc(MOST_SAMPLES + 1, (1 + RENDER_ENERGIES) * sizeof *ref->energies);
    if (!ref->energies)
        bind_fail_text(L, DIG_E_MEMORY, "no memory for the energies of the replay");
    for (int k = 0; k < info->frames; k += stride) {
        const dig_energy *e = &frame_at(L, ref->r, k)->energy;
        const real row[1 + RENDER_ENERGIES] = {k * info->step, e->kinetic, e->potential, e->elastic, e->heat + e->lost};
        memcpy(ref->energies + (size_t)ref->energy_count++ * (1 + RENDER_ENERGIES), row, sizeof row);
    }
}

/* Where the centre of mass is: position + rotation * centre */
static void centre_of(const ReplayPose *p, vec3 c, real out[3])
{
    quat q = p->rotation;
    vec3 t = {2 * (q.y * c.z - q.z * c.y), 2 * (q.z * c.x - q.x * c.z), 2 * (q.x * c.y - q.y * c.x)};
    out[0] = p->position.x + c.x + q.w * t.x + q.y * t.z - q.z * t.y;
    out[1] = p->position.y + c.y + q.w * t.y + q.z * t.x - q.x * t.z;
    out[2] = p->position.z + c.z + q.w * t.z + q.x * t.y - q.y * t.x;
}

/* Centres of mass over the last second up to `frame`; what is not there or never moves has no trail. */
static bool read_trails(lua_State *L, Replay *r, int frame, HistoryRef *out)
{
    const ReplayInfo *info = replay_info(r);
    int stride = (int)fmax(1, round(1 / (info->step * (TRAIL_LENGTH - 1))));
    size_t row = 3 * TRAIL_LENGTH, count = (size_t)info->bodies * row;
    out->trails = malloc((count + 1) * sizeof *out->trails);
    if (!out->trails)
        return false;
    for (size_t i = 0; i < count; i++)
        out->trails[i] = NAN;
    for (int i = 0; i < TRAIL_LENGTH; i++) {
        int k = frame - (TRAIL_LENGTH - 1 - i) * stride;
        const ReplayFrame *f = k >= 0 ? frame_at(L, r, k) : NULL;
        for (int j = 0; f && j < f->pose_count; j++) {
            const ReplayPose *p = &f->poses[j];
            const ReplayBody *body = replay_body(r, p->body);
            if (!body || body->kind != DIG_DYNAMIC || p->body >= info->bodies)
                continue;
            centre_of(p, body->centre, out->trails + (size_t)p->body * row + 3 * (size_t)i);
        }
    }
    out->h.trails = out->trails;
    out->h.trail_count = info->bodies;
    out->h.trail_length = TRAIL_LENGTH;
    return true;
}

/* core.reader_history(reader, frame, trails, energies) -> history; the flags say what is wanted. It points into the reader. */
static int reader_history(lua_State *L)
{
    ReaderRef *ref = luaL_checkudata(L, 1, READER);
    int frame = (int)luaL_checkinteger(L, 2);
    HistoryRef *out = lua_newuserdatauv(L, sizeof *out, 1);
    *out = (HistoryRef){0};
    luaL_setmetatable(L, HISTORY);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    if (lua_toboolean(L, 3) && !read_trails(L, ref->r, frame, out))
        return bind_fail_text(L, DIG_E_MEMORY, "no memory for the trails of %d bodies", replay_info(ref->r)->bodies);
    if (lua_toboolean(L, 4)) {
        const ReplayInfo *info = replay_info(ref->r);
        read_energies(L, ref);
        out->h.energies = ref->energies;
        out->h.energy_count = ref->energy_count;
        out->h.begin = (real)info->first_step * info->step;
        out->h.end = (info->frames - 1) * info->step;
    }
    return 1;
}

/* core.stopped() -> whether SIGINT or SIGTERM came */
static int reader_stopped(lua_State *L)
{
    lua_pushboolean(L, app_signal() != 0);
    return 1;
}

void bind_reader_open(lua_State *L, int core)
{
    static const luaL_Reg reader[] = {
        {"reader", reader_open}, {"reader_info", reader_info}, {"reader_note", reader_note}, {"reader_view", reader_view},
        {"reader_cameras", reader_cameras},
        {"reader_checksum", reader_checksum}, {"reader_history", reader_history}, {"stopped", reader_stopped}, {NULL, NULL},
    };
    bind_held_type(L, READER, reader_gc);
    bind_held_type(L, HISTORY, history_gc);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, reader, 0);
    lua_pop(L, 1);
}
