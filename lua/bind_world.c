/* lua/bind_world.c - worlds: opening, stepping, books, snapshots, the room, materials. */

#define _POSIX_C_SOURCE 200809L /* clock_gettime */

#include "bind.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

typedef struct SnapshotRef { dig_snapshot *s; WorldRef *world; } SnapshotRef;

#define SNAPSHOT "snapshot"

enum { OPENING = 5000 };        /* units: what a world costs that is opened and closed again */

/* ---- opening ----------------------------------------------------------------- */

static void weak_table(lua_State *L, const char *name)
{
    lua_newtable(L);
    lua_createtable(L, 0, 1);
    lua_pushliteral(L, "v");
    lua_setfield(L, -2, "__mode");
    lua_setmetatable(L, -2);
    lua_setfield(L, -2, name);
}

static WorldRef *new_world(lua_State *L)
{
    WorldRef *ref = lua_newuserdatauv(L, sizeof *ref, 1);
    *ref = (WorldRef){.host = bind_host(L), .quiet = -1};
    if (ref->host)
        ref->host->charge(L, OPENING);
    luaL_setmetatable(L, BIND_WORLD);
    lua_newtable(L);
    weak_table(L, "bodies");
    weak_table(L, "joints");
    weak_table(L, "digs");
    lua_newtable(L);
    lua_setfield(L, -2, "data");
    lua_setiuservalue(L, -2, 1);
    return ref;
}

/* accuracy = "play" | 0.001 | "1 mm" */
void bind_accuracy(lua_State *L, int index, const char *what, dig_text *plan, real *tolerance)
{
    const char *text = lua_type(L, index) == LUA_TSTRING ? bind_string(L, index, "accuracy") : NULL;
    memset(plan, 0, sizeof *plan);
    *tolerance = (real)NAN;
    if (text && !strchr("0123456789.+-", text[0]))
        snprintf(plan->s, sizeof plan->s, "%s", text);
    else
        *tolerance = bind_real(L, index, "m", what, "accuracy");
}

/* core.world{...} -> world */
static int world_open(lua_State *L)
{
    const dig_schema *schema = dig_schema_at("world", 0);
    const dig_param *sets[] = {schema->rows, NULL};
    static const char *const extras[] = {"accuracy", NULL};
    dig_world_def def = dig_world_defaults();
    char why[512] = "";

    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    bind_check_keys(L, 1, "digbox.world", sets, extras);
    if (lua_getfield(L, 1, "accuracy") != LUA_TNIL) {
        bind_accuracy(L, 2, "digbox.world", &def.accuracy, &def.tolerance);
        lua_pushnil(L);
        lua_setfield(L, 1, "accuracy");         /* the table is a copy made by init.lua */
    }
    lua_newtable(L);
    Fill fill = {L, 1, 3, "digbox.world", "digbox.world", NULL};
    bind_fill(&fill, schema->rows, &def);
    WorldRef *ref = new_world(L);
    dig_status s = dig_world_open(&def, &ref->w, why, sizeof why);
    if (s != DIG_OK)
        return bind_fail_text(L, s, "digbox.world: %s", why);
    bind_push_state(L, -1);
    lua_pushinteger(L, def.seed);
    lua_setfield(L, -2, "seed");
    lua_pop(L, 1);
    return 1;
}

/* core.load(path) -> world */
static int world_load(lua_State *L)
{
    char why[512] = "";
    const char *path = luaL_checkstring(L, 1);
    WorldRef *ref = new_world(L);
    dig_status s = dig_world_load(path, &ref->w, why, sizeof why);
    if (s != DIG_OK)
        return bind_fail_text(L, s, "digbox.load: %s", why);
    return 1;
}

static int world_gc(lua_State *L)
{
    WorldRef *ref = luaL_checkudata(L, 1, BIND_WORLD);
    dig_world_close(ref->w);
    ref->w = NULL;
    return 0;
}

/* core.state(world) -> the table that the Lua side keeps with a world */
static int world_state(lua_State *L)
{
    bind_check_world(L, 1);
    bind_push_state(L, 1);
    return 1;
}

/* core.is_open(world) */
static int world_is_open(lua_State *L)
{
    const WorldRef *ref = luaL_checkudata(L, 1, BIND_WORLD);
    lua_pushboolean(L, ref->w != NULL);
    return 1;
}

/* core.is_free(world): open, and no function of an effect runs, in the middle of a step */
static int world_is_free(lua_State *L)
{
    const WorldRef *ref = luaL_checkudata(L, 1, BIND_WORLD);
    lua_pushboolean(L, ref->w && !ref->shut);
    return 1;
}

/* core.step(world): one frame step -> how many entries world:warnings() has */
static int world_step(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    bind_step(L, 1);
    lua_pushinteger(L, dig_warnings(ref->w, NULL, 0));
    return 1;
}

static void step_alone(lua_State *L, WorldRef *ref)
{
    if (ref->host)
        ref->host->poll(L);
    bind_step(L, 1);
    bind_settle(L, ref);
}

/* core.steps(world, n, warnings): up to n frame steps between which nobody looks. Another number of entries in world:warnings() ends it.
 * -> how many were taken, that number */
static int world_steps_many(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    lua_Integer n = luaL_checkinteger(L, 2), warnings = luaL_checkinteger(L, 3), done = 0;
    while (done < n) {
        step_alone(L, ref);
        done++;
        lua_Integer now = dig_warnings(ref->w, NULL, 0);
        if (now != warnings) {
            warnings = now;
            break;
        }
    }
    lua_pushinteger(L, done);
    lua_pushinteger(L, warnings);
    return 2;
}

enum { CORE = GUARD_UPVALUES + 1 };     /* upvalue of quiet_step, after those of what is guarded */

/* The world of a call world:step() around whose step there is nothing to be done, or NULL. */
static WorldRef *find_quiet(lua_State *L)
{
    if (lua_gettop(L) != 1 || !lua_isuserdata(L, 1) || !lua_getmetatable(L, 1))
        return NULL;
    if (!lua_rawequal(L, 2, lua_upvalueindex(GUARD_UPVALUES)))
        return NULL;
    WorldRef *ref = lua_touserdata(L, 1);
    return ref->w && !ref->shut && ref->quiet >= 0 ? ref : NULL;
}

/* Most steps of small worlds go here: a step of one body takes no longer than to ask what methods.step asks, and to get there. */
static int quiet_step(lua_State *L)
{
    int n = lua_gettop(L);
    WorldRef *ref = find_quiet(L);
    if (!ref) {
        lua_settop(L, n);
        return bind_guarded(L);
    }
    step_alone(L, ref);
    int warnings = dig_warnings(ref->w, NULL, 0);
    if (warnings == ref->quiet)
        return 0;
    ref->quiet = warnings;
    lua_getfield(L, lua_upvalueindex(CORE), "watch");
    lua_pushvalue(L, 1);
    bind_push_state(L, 1);
    lua_pushinteger(L, warnings);
    lua_call(L, 3, 0);
    return 0;
}

/* core.quiet(world, warnings or nil): is there nothing to be done around its next steps, as long as world:warnings() has so many entries? */
static int world_quiet(lua_State *L)
{
    WorldRef *ref = luaL_checkudata(L, 1, BIND_WORLD);
    ref->quiet = (int)luaL_optinteger(L, 2, -1);
    return 0;
}

/* core.quiet_step(step, core) -> the method, of one that is guarded */
static int make_quiet_step(lua_State *L)
{
    for (int i = 1; i <= GUARD_UPVALUES; i++)
        lua_getupvalue(L, 1, i);
    lua_pushvalue(L, 2);
    lua_pushcclosure(L, quiet_step, CORE);
    return 1;
}

/* core.cpu_seconds() -> s of CPU time of this process, all threads. Scripts cannot reach it: they see simulated time alone. */
static int cpu_seconds(lua_State *L)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    lua_pushnumber(L, (double)t.tv_sec + 1e-9 * (double)t.tv_nsec);
    return 1;
}

/* core.save(world, path, note or nil) */
static int world_save(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    size_t size = 0;
    const char *path = luaL_checkstring(L, 2), *note = luaL_optlstring(L, 3, NULL, &size);
    bind_explain(L, 1);
    dig_status s = dig_world_note(ref->w, note, size);
    if (s == DIG_OK)
        s = dig_world_save(ref->w, path);
    if (s != DIG_OK)
        return bind_fail(L, ref->w, s);
    dig_world_note(ref->w, NULL, 0);
    return 0;
}

/* core.noted(world) -> the note of the file it came from, or nil. It is given once. */
static int world_noted(lua_State *L)
{
    const WorldRef *ref = bind_check_world(L, 1);
    size_t size;
    const char *note = dig_world_noted(ref->w, &size);
    if (!note)
        return 0;
    lua_pushlstring(L, note, size);
    dig_world_note(ref->w, NULL, 0);
    return 1;
}

/* core.gone(world, "body" or "joint") -> a handle of one that was removed before the world was saved */
static int world_gone(lua_State *L)
{
    bind_check_world(L, 1);
    if (strcmp(luaL_checkstring(L, 2), "body") == 0)
        bind_push_body(L, 1, (dig_body){UINT32_MAX, UINT32_MAX});
    else
        bind_push_joint(L, 1, (dig_joint){UINT32_MAX, UINT32_MAX});
    return 1;
}

/* world:check() raises when an invariant of the state is broken */
static int world_check(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_status s = dig_world_check(ref->w);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* ---- snapshots ------------------------------------------------------------------ */

/* world:snapshot() -> snap */
static int world_snapshot(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    SnapshotRef *snap = lua_newuserdatauv(L, sizeof *snap, 1);
    *snap = (SnapshotRef){NULL, ref};
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    luaL_setmetatable(L, SNAPSHOT);
    dig_status s = dig_world_snapshot(ref->w, &snap->s);
    return s == DIG_OK ? 1 : bind_fail(L, ref->w, s);
}

/* core.restore(world, snap) */
static int world_restore(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    SnapshotRef *snap = luaL_testudata(L, 2, SNAPSHOT);
    if (!snap)
        return bind_error(L, "world:restore wants a snapshot; got %s", bind_text(L, 2));
    if (snap->world != ref)
        return bind_error(L, "world:restore: the snapshot belongs to another world");
    dig_status s = dig_world_restore(ref->w, snap->s);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

static int snapshot_gc(lua_State *L)
{
    SnapshotRef *snap = luaL_checkudata(L, 1, SNAPSHOT);
    dig_snapshot_free(snap->s);
    snap->s = NULL;
    return 0;
}

/* ---- lists ----------------------------------------------------------------------- */

/* world:bodies() -> list */
static int world_bodies(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    int n = dig_bodies(ref->w, NULL, 0);
    dig_body *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    return bind_push_bodies(L, 1, ids, dig_bodies(ref->w, ids, n));
}

/* world:joints() -> list */
static int world_joints(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    int n = dig_joints(ref->w, NULL, 0);
    dig_joint *ids = lua_newuserdatauv(L, (size_t)(n + 1) * sizeof *ids, 0);
    n = dig_joints(ref->w, ids, n);
    bind_push_list(L, n);
    for (int i = 0; i < n; i++) {
        bind_push_joint(L, 1, ids[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* world:find "name" -> body or joint of that name, or nil */
static int world_find(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    if (lua_type(L, 2) != LUA_TSTRING)
        return bind_error(L, "world:find wants a name; got %s", luaL_typename(L, 2));
    const char *name = bind_string(L, 2, NULL);
    bind_push_body(L, 1, dig_body_find(ref->w, name));
    if (lua_isnil(L, -1))
        bind_push_joint(L, 1, dig_joint_find(ref->w, name));
    return 1;
}

/* ---- books ----------------------------------------------------------------------- */

/* world.energy -> table, J */
static int world_energy(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_energy e = dig_world_energy(ref->w);
    bind_own_check(L, ref);
    lua_newtable(L);
    bind_set_real(L, "kinetic", e.kinetic);
    bind_set_real(L, "potential", e.potential);
    bind_set_real(L, "elastic", e.elastic);
    bind_set_real(L, "heat", e.heat);
    bind_set_real(L, "electric", e.electric);
    bind_set_real(L, "work_in", e.work_in);
    bind_set_real(L, "law", e.law);
    bind_set_real(L, "lost", e.lost);
    bind_set_real(L, "numerical", e.numerical);
    bind_set_real(L, "total", e.total);
    bind_set_real(L, "initial", e.initial);
    bind_record(L, "world.energy", NULL, false);
    return 1;
}

/* world:stats() -> table */
static int world_stats(lua_State *L)
{
    const dig_world *w = bind_check_world(L, 1)->w;
    dig_stats s = dig_world_stats(w);
    lua_newtable(L);
    bind_set_real(L, "energy_drift", dig_world_energy(w).numerical);
    bind_set_int(L, "bodies", s.bodies);
    bind_set_int(L, "awake", s.awake);
    bind_set_int(L, "digs", s.digs);
    bind_set_int(L, "contacts", s.contacts);
    bind_set_int(L, "pairs", s.pairs);
    bind_set_int(L, "joints", s.joints);
    bind_set_int(L, "events", (lua_Integer)s.events);
    bind_set_int(L, "steps", (lua_Integer)s.steps);
    bind_set_int(L, "work", (lua_Integer)dig_world_work(w));
    bind_set_int(L, "rejected", (lua_Integer)s.rejected);
    bind_set_int(L, "groups", s.groups);
    bind_set_int(L, "iterations", s.iterations);
    bind_set_int(L, "factors", s.factors);
    bind_set_int(L, "substeps", s.substeps);
    bind_set_int(L, "located", s.located);
    bind_set_int(L, "traced", s.traced);
    bind_set_int(L, "conserved", s.conserved);
    bind_set_int(L, "swept", s.swept);
    bind_set_int(L, "unturned", s.unturned);
    bind_set_int(L, "smooth", s.smooth);
    bind_set_int(L, "fast", s.fast);
    bind_set_int(L, "evaluations", s.evaluations);
    bind_set_int(L, "refused", s.refused);
    bind_set_int(L, "trace_events", s.trace_events);
    bind_set_int(L, "gave_up", (lua_Integer)s.gave_up);
    if (s.gave_up_why[0]) {
        lua_pushstring(L, s.gave_up_why);
        lua_setfield(L, -2, "gave_up_why");
    }
    bind_set_int(L, "posted", (lua_Integer)s.posted);
    bind_set_int(L, "delivered", (lua_Integer)s.delivered);
    bind_set_int(L, "dropped", (lua_Integer)s.dropped);
    bind_set_int(L, "repeated", (lua_Integer)s.repeated);
    bind_set_int(L, "storms", (lua_Integer)s.storms);
    bind_set_int(L, "warnings", (lua_Integer)s.warnings);
    bind_set_real(L, "residual", s.residual);
    bind_set_real(L, "penetration", s.penetration);
    bind_set_real(L, "joint_error", s.joint_error);
    bind_set_int(L, "all_traced", (lua_Integer)s.all_traced);
    bind_set_int(L, "all_conserved", (lua_Integer)s.all_conserved);
    bind_set_int(L, "all_swept", (lua_Integer)s.all_swept);
    bind_set_int(L, "all_refused", (lua_Integer)s.all_refused);
    bind_set_real(L, "worst_residual", s.worst_residual);
    bind_set_real(L, "worst_penetration", s.worst_penetration);
    bind_set_real(L, "worst_joint_error", s.worst_joint_error);
    bind_set_int(L, "bytes", (lua_Integer)s.bytes);
    bind_set_int(L, "allocations", (lua_Integer)s.allocations);
    lua_newtable(L);
    bind_set_real(L, "sense", s.us_sense);
    bind_set_real(L, "touch", s.us_touch);
    bind_set_real(L, "graph", s.us_graph);
    bind_set_real(L, "advance", s.us_advance);
    bind_set_real(L, "commit", s.us_commit);
    bind_set_real(L, "report", s.us_report);
    lua_setfield(L, -2, "us");
    return 1;
}

/* world:checksum() -> text */
static int world_checksum(lua_State *L)
{
    char text[32];
    snprintf(text, sizeof text, "%016" PRIx64, dig_world_checksum(bind_check_world(L, 1)->w));
    lua_pushstring(L, text);
    return 1;
}

static int world_time(lua_State *L) { lua_pushnumber(L, dig_world_time(bind_check_world(L, 1)->w)); return 1; }
static int world_steps(lua_State *L) { lua_pushinteger(L, (lua_Integer)dig_world_steps(bind_check_world(L, 1)->w)); return 1; }
static int world_frame(lua_State *L) { lua_pushnumber(L, dig_world_frame(bind_check_world(L, 1)->w)); return 1; }
static int world_gravity(lua_State *L) { bind_push_vec3(L, dig_world_gravity(bind_check_world(L, 1)->w)); return 1; }
static int world_accuracy(lua_State *L) { lua_pushstring(L, dig_world_accuracy(bind_check_world(L, 1)->w)); return 1; }
static int world_momentum(lua_State *L) { bind_push_vec3(L, dig_world_momentum(bind_check_world(L, 1)->w)); return 1; }
static int world_angular(lua_State *L) { bind_push_vec3(L, dig_world_angular_momentum(bind_check_world(L, 1)->w)); return 1; }

/* Of what a world is made with the error says so. */
static int refuse_to_assign(lua_State *L, const char *key)
{
    for (const dig_param *row = dig_schema_at("world", 0)->rows; row->name; row++)
        if (strcmp(row->name, key) == 0)
            return bind_error(L, "world.%s is decided when a world is made: digbox.world{ %s = ... }", key, key);
    return bind_error(L, "world.%s cannot be assigned (gravity and accuracy can)", key);
}

/* world.gravity = {..}   world.accuracy = "study" */
static int world_newindex(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const char *key = bind_name(L, 2, NULL);
    dig_status s;
    if (strcmp(key, "gravity") == 0) {
        s = dig_world_set_gravity(ref->w, bind_vec3(L, 3, "m/s^2", "world", "gravity"));
    } else if (strcmp(key, "accuracy") == 0) {
        dig_text plan;
        real tolerance;
        bind_accuracy(L, 3, "digbox.world", &plan, &tolerance);
        s = dig_world_set_accuracy(ref->w, plan.s[0] ? plan.s : NULL, tolerance);
    } else {
        return refuse_to_assign(L, key);
    }
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* ---- the room, and materials ---------------------------------------------------------------- */

/* core.room(world, {size=, at=, material=, friction=, restitution=}); its name is Lua's */
static int world_room(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const dig_schema *schema = dig_schema_at("room", 0);
    const dig_param *sets[] = {schema->rows, NULL};
    dig_room_def def;
    luaL_checktype(L, 2, LUA_TTABLE);
    static const char *const extras[] = {"name", NULL};
    bind_check_keys(L, 2, "world:room", sets, extras);
    Fill fill = {L, 2, 2, "world:room", "world:room", ref};
    dig_schema_defaults(schema, &def);
    bind_fill(&fill, schema->rows, &def);
    dig_status s = dig_room_set(ref->w, &def);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* core.has_room(world) */
static int world_has_room(lua_State *L)
{
    lua_pushboolean(L, dig_has_room(bind_check_world(L, 1)->w));
    return 1;
}

/* core.room_open(world, wall, open) */
static int world_room_open(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    dig_status s = dig_room_open(ref->w, bind_string(L, 2, NULL), lua_toboolean(L, 3));
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* core.material(world, name, {...}): like = "oak" takes what is not given from there */
static int world_material(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const dig_schema *schema = dig_schema_at("material", 0);
    const dig_param *sets[] = {schema->rows, NULL};
    static const char *const extras[] = {"like", NULL};
    dig_material_def def;
    const char *name = bind_string(L, 2, NULL);
    luaL_checktype(L, 3, LUA_TTABLE);
    lua_settop(L, 3);
    const char *what = lua_pushfstring(L, "digbox.material '%s'", name);
    bind_check_keys(L, 3, what, sets, extras);
    dig_schema_defaults(schema, &def);
    lua_newtable(L);
    Fill fill = {L, 3, 5, what, what, ref};
    if (lua_getfield(L, 3, "like") != LUA_TNIL) {
        dig_text like;
        const dig_param row = {.name = "like", .kind = DIG_MATERIAL};
        bind_fill_field(&fill, &row, &like);
        dig_material_get(ref->w, like.s, &def);
    }
    lua_pop(L, 1);
    bind_fill(&fill, schema->rows, &def);
    dig_status s = dig_material_add(ref->w, name, &def);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* core.material_of(world, name) -> {density=, strength=, stiffness=, ...}: its numbers */
static int world_material_of(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const char *name = bind_string(L, 2, NULL);
    dig_material_def def;
    if (dig_material_get(ref->w, name, &def) != DIG_OK)
        return 0;
    lua_newtable(L);
    for (const dig_param *row = dig_schema_at("material", 0)->rows; row->name; row++)
        if (row->kind == DIG_REAL)
            bind_set_real(L, row->name, *(const real *)(const void *)((const char *)&def + row->offset));
    return 1;
}

static const dig_param pair_rows[] = {
    {"a", DIG_MATERIAL, "", "one material", 0, 0, 0, offsetof(dig_pair_def, a), NULL, NULL, true, 0},
    {"b", DIG_MATERIAL, "", "the other", 0, 0, 0, offsetof(dig_pair_def, b), NULL, NULL, true, 0},
    {"friction", DIG_REAL, "1", "static", NAN, 0, 1e3, offsetof(dig_pair_def, friction), NULL, NULL, false, 0},
    {"friction_dynamic", DIG_REAL, "1", "sliding", NAN, 0, 1e3, offsetof(dig_pair_def, friction_dynamic), NULL, NULL, false, 0},
    {"rolling_friction", DIG_REAL, "1", "rolling", NAN, 0, 1e3, offsetof(dig_pair_def, rolling_friction), NULL, NULL, false, 0},
    {"restitution", DIG_REAL, "1", "bounce", NAN, 0, 1, offsetof(dig_pair_def, restitution), NULL, NULL, false, 0},
    {.name = NULL},
};

const dig_param *bind_pair_rows(void) { return pair_rows; }

/* core.material_pair(world, {a=, b=, friction=, ...}) */
static int world_material_pair(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    const dig_param *sets[] = {pair_rows, NULL};
    const real none = (real)NAN;
    dig_pair_def def = {{""}, {""}, none, none, none, none};
    luaL_checktype(L, 2, LUA_TTABLE);
    bind_check_keys(L, 2, "digbox.material_pair", sets, NULL);
    Fill fill = {L, 2, 2, "digbox.material_pair", "digbox.material_pair", ref};
    bind_fill(&fill, pair_rows, &def);
    dig_status s = dig_material_pair(ref->w, &def);
    return s == DIG_OK ? 0 : bind_fail(L, ref->w, s);
}

/* ---- tables --------------------------------------------------------------------------- */

static int world_eq(lua_State *L)
{
    lua_pushboolean(L, lua_rawequal(L, 1, 2));
    return 1;
}

static int world_tostring(lua_State *L)
{
    WorldRef *ref = luaL_checkudata(L, 1, BIND_WORLD);
    if (ref->w)
        lua_pushfstring(L, "world at t = %f s", dig_world_time(ref->w));
    else
        lua_pushliteral(L, "closed world");
    return 1;
}

static int snapshot_tostring(lua_State *L)
{
    lua_pushliteral(L, "snapshot");
    return 1;
}

/* world:close(): frees the world; its handles are dead from then on */
static int world_close(lua_State *L)
{
    bind_check_world(L, 1);
    return world_gc(L);
}

static const luaL_Reg methods[] = {
    {"bodies", world_bodies}, {"joints", world_joints}, {"find", world_find}, {"checksum", world_checksum}, {"check", world_check},
    {"stats", world_stats},
    {"snapshot", world_snapshot}, {NULL, NULL},
};
static const luaL_Reg getters[] = {
    {"time", world_time}, {"steps", world_steps}, {"frame", world_frame}, {"gravity", world_gravity}, {"accuracy", world_accuracy},
    {"momentum", world_momentum}, {"angular_momentum", world_angular}, {"energy", world_energy}, {NULL, NULL},
};
static const luaL_Reg meta[] = {
    {"__newindex", world_newindex}, {"__gc", world_gc}, {"__eq", world_eq}, {"__tostring", world_tostring}, {NULL, NULL},
};
static const luaL_Reg snapshot_methods[] = {{NULL, NULL}};
static const luaL_Reg snapshot_meta[] = {{"__gc", snapshot_gc}, {"__tostring", snapshot_tostring}, {NULL, NULL}};
static const luaL_Reg functions[] = {
    {"world", world_open}, {"load", world_load}, {"state", world_state}, {"is_open", world_is_open}, {"is_free", world_is_free},
    {"step", world_step}, {"steps", world_steps_many}, {"quiet", world_quiet}, {"quiet_step", make_quiet_step}, {"save", world_save}, {"noted", world_noted},
    {"gone", world_gone}, {"restore", world_restore},
    {"close", world_close}, {"room", world_room}, {"room_open", world_room_open}, {"has_room", world_has_room},
    {"material", world_material}, {"material_of", world_material_of}, {"material_pair", world_material_pair},
    {"cpu_seconds", cpu_seconds}, {NULL, NULL},
};

void bind_world_open(lua_State *L, int core)
{
    bind_type(L, core, BIND_WORLD, methods, getters, NULL, meta);
    bind_type(L, core, SNAPSHOT, snapshot_methods, NULL, NULL, snapshot_meta);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pop(L, 1);
}
