/* lua/bind.h - what the Lua binding shares: handles, vectors, tables that fill def structs, errors at the script's line.
 *
 * Handles are userdata {world, id}; the world's userdata is their first user value, so a world outlives its handles. A removed
 * body is found by its generation and named by the text that its removal left on the handle.
 *
 * Nothing here owns memory across a call that can raise: buffers are Lua userdata.
 */
#ifndef DIGBOX_BIND_H
#define DIGBOX_BIND_H

#include <lauxlib.h>
#include <lua.h>

#include "digbox.h"

struct OwnRef;
/* Who limits what a script does. */
typedef struct BindHost {
    void       (*charge)(lua_State *L, size_t work);    /* so much was done in C for it, in units of about one instruction of Lua; may raise */
    lua_State *(*run)(lua_State *L);                    /* from now on this thread of Lua runs; gives the one that did before                */
    void       (*poll)(lua_State *L);                   /* before each step: stops at Ctrl-C and at limits; may raise                        */
} BindHost;
typedef struct WorldRef {
    dig_world  *w;              /* NULL: closed                                                     */
    const BindHost *host;       /* NULL: nobody does                                                */
    uint64_t    charged;        /* of dig_world_work                                                */
    const char *shut;           /* name of the effect whose function runs: nothing else may be done */
    int         quiet;          /* -1, or nothing is to be done around a step unless world:warnings() gets more entries than this (core.quiet) */
    struct OwnRef *failed;      /* an effect's function did; its error is still to be raised        */
} WorldRef;
typedef struct BodyRef  { WorldRef *world; dig_body id; } BodyRef;
typedef struct JointRef { WorldRef *world; dig_joint id; } JointRef;
typedef struct DigRef   { WorldRef *world; dig_dig id; } DigRef;
typedef struct RegionRef { WorldRef *world; dig_region id; } RegionRef;     /* its first user value is the world */
typedef struct ShapeRef { dig_shape_def def; dig_surface_def surface; } ShapeRef;        /* its data struct follows it in the same block */

#if defined(__GNUC__)
#define BIND_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define BIND_PRINTF(text, first)
#endif

/* Names of the metatables; also what errors call the types. */
#define BIND_WORLD "world"
#define BIND_BODY  "body"
#define BIND_JOINT "joint"
#define BIND_DIG   "DIG"
#define BIND_SHAPE "shape"
#define BIND_REGION "region"
#define BIND_VEC   "vector"
#define BIND_QUAT  "rotation"

enum { REF_WORLD = 1, REF_REMOVED = 2, REF_NAME = 3 };          /* user values of body and joint handles */

/* Files of lua/digbox, put into the program by lua/embed.sh; ends with name NULL. */
struct digbox_source { const char *name; const char *text; size_t size; };
extern const struct digbox_source digbox_embedded[];

/* ---- modules: each adds its functions to the table `core` at the given index ---- */

void bind_vec_open(lua_State *L, int core);
void bind_world_open(lua_State *L, int core);
void bind_space_open(lua_State *L, int core);
void bind_region_open(lua_State *L, int core);
void bind_body_open(lua_State *L, int core);
void bind_shape_open(lua_State *L, int core);
void bind_joint_open(lua_State *L, int core);
void bind_graph_open(lua_State *L, int core);
void bind_film_open(lua_State *L, int core);
void bind_frames_open(lua_State *L, int core);
void bind_file_open(lua_State *L, int core);
void bind_watch_open(lua_State *L, int core);
void bind_aside_open(lua_State *L, int core);
void bind_effect_open(lua_State *L, int core);
void bind_ask_open(lua_State *L, int core);
void bind_own_open(lua_State *L, int core);
void bind_message_open(lua_State *L, int core);
void bind_frozen_open(lua_State *L, int core);
void bind_mean_open(lua_State *L, int core);
void bind_hint_open(lua_State *L, int core);
void bind_trace_open(lua_State *L, int core);
void bind_schema_open(lua_State *L, int core);
void bind_replay_open(lua_State *L, int core);
void bind_reader_open(lua_State *L, int core);
void bind_json_open(lua_State *L, int core);
void bind_past_open(lua_State *L, int core);

/* Pushes the value of a JSON text (bind_json.c); false: it is none, and nothing is pushed. */
bool bind_push_json(lua_State *L, const char *text);

/* A view as Lua has it; takes it over. Without a renderer an error. */
struct View;
struct Replay;
struct ViewPast;
int bind_push_view(lua_State *L, struct View *v);
struct Replay *bind_check_reader(lua_State *L, int index);
const struct ViewPast *bind_past(lua_State *L, int index);      /* until it is fed again */

/* Pushes a field of a table that the script gave, and returns its type: what stands in the table, without asking its metatable. */
static inline int bind_own_field(lua_State *L, int table, const char *name)
{
    table = lua_absindex(L, table);
    lua_pushstring(L, name);
    return lua_rawget(L, table);
}

/* A field of the table on the top of the stack. */
static inline void bind_set_text(lua_State *L, const char *name, const char *text)
{
    lua_pushstring(L, text);
    lua_setfield(L, -2, name);
}

static inline void bind_set_bool(lua_State *L, const char *name, bool on)
{
    lua_pushboolean(L, on);
    lua_setfield(L, -2, name);
}

static inline void bind_set_real(lua_State *L, const char *name, real x)
{
    x += 0.0;           /* -0 is 0 to who reads it */
    lua_pushnumber(L, x);
    lua_setfield(L, -2, name);
}

static inline void bind_set_int(lua_State *L, const char *name, lua_Integer x)
{
    lua_pushinteger(L, x);
    lua_setfield(L, -2, name);
}

/* From now on the script of this state has limits; for the program's own states. Worlds that are made later know it. */
void bind_host_by(lua_State *L, const BindHost *host);
const BindHost *bind_host(lua_State *L);        /* NULL: there is none */
/* Charges for a list or table of so many items that C reads or makes. */
void bind_charge_items(lua_State *L, size_t items);
/* Charges for what was done in the world since the last time, and for one call. Every check of a handle does. */
void bind_settle(lua_State *L, WorldRef *world);

/* What a function of core.guard does. Upvalues: a function written in Lua, its name, the class that its first argument has to have or nil,
 * the metatable of that class or nil. */
enum { GUARD_UPVALUES = 4 };
int  bind_guarded(lua_State *L);

/* Opens everything and leaves the module `digbox` on the stack; the core table stands in the registry as "digbox.core". */
int  bind_open(lua_State *L);
__attribute__((visibility("default"))) int  luaopen_digbox(lua_State *L);
__attribute__((visibility("default"))) int  luaopen_digbox_test(lua_State *L);

/* Pushes the value of an embedded file, run once with the core table as its argument; false when there is no such file. */
bool bind_use(lua_State *L, const char *name);

/* ---- errors ---------------------------------------------------------------------- */

/* "world.lua:12: ": the innermost frame of the script, not of the files embedded here. Pushes it ("" when there is none). */
void bind_where(lua_State *L);
void bind_place(lua_State *L);           /* the same without the colon: "world.lua:12" */

/* The string at index as C reads it; an error, which begins with what (NULL: nothing), where C would not see all of it: it holds a NUL. */
const char *bind_string(lua_State *L, int index, const char *what);

/* As bind_text, for what is then looked up by its name: an error where a string holds a NUL byte. */
const char *bind_name(lua_State *L, int index, const char *what);

/* Pushes the text of a value and returns it: no address in it. Values with __tostring are asked. */
const char *bind_text(lua_State *L, int index);

/* Raises position + message. */
int bind_error(lua_State *L, const char *format, ...) BIND_PRINTF(2, 3);

/* Raises the message of a call that failed; the status decides the program's exit code if nobody catches it. */
int bind_fail(lua_State *L, const dig_world *w, dig_status status);
int bind_fail_text(lua_State *L, dig_status status, const char *format, ...) BIND_PRINTF(3, 4);

/* The exit code that belongs to an uncaught error message (1 for errors of the script itself). */
int bind_exit_code(lua_State *L, const char *message);

/* The string keys of the tables at first..last of the stack, in the order of the alphabet: that of lua_next is another in every run.
 * The array is pushed, and stands as long as the tables do. */
const char **bind_names(lua_State *L, int first, int last, int *count);

/* "unknown field 'radus' (did you mean 'radius'?)", or the list of what is known. Candidates are the string keys of the tables
 * at first..last of the stack. */
int bind_unknown(lua_State *L, const char *what, const char *kind, const char *name, int first, int last);

/* The table on the top is a record of that name: a name that it has not is an error, but for `empty` (NULL-ended, or NULL), which may be
 * nil. With `spelled`, names may be as in the founding document: currPos for curr_pos. */
void bind_record(lua_State *L, const char *what, const char *const *empty, bool spelled);

/* What another name stands for here, by its meaning, out of the names that are known; or a sentence instead (bind_mean.c). NULL: nothing. */
const char *bind_mean(const char *name, const char *const *names, int count);
const char *bind_mean_note(const char *name, const char *const *names, int count);
/* Pushes "world:ball{ radius = 0.1, at = {0, 1, 0} }", or "" where there is no example. */
const char *bind_example(lua_State *L, const char *what);
/* Puts behind the message on the top, where it is one of Lua's own, what may help who comes from elsewhere (bind_hint.c). */
void bind_hint(lua_State *L);
/* Raises "world:ball wants a table of fields; got number (write world:ball{ ... })". */
int bind_wants_fields(lua_State *L, int index, const char *what);

/* ---- types ------------------------------------------------------------------------- */

/* Makes a locked metatable: methods and getters (name -> function of self) become reachable as core.types[name].methods and
 * .getters, so that lua/digbox/ can add to them. fallback (may be NULL) gets (self, key) and returns how many values it pushed. */
void bind_type(lua_State *L, int core, const char *name, const luaL_Reg *methods, const luaL_Reg *getters, lua_CFunction fallback,
               const luaL_Reg *metamethods);

/* A locked metatable of what only the program itself holds: no methods, released by gc. */
void bind_held_type(lua_State *L, const char *name, lua_CFunction gc);

/* Indexing a function (world.stats.bodies) then says that a method wants a call; for the program's own states only. */
void bind_hint_methods(lua_State *L);

/* Adds methods to a type that exists. */
void bind_extend(lua_State *L, int core, const char *type, const luaL_Reg *methods);

WorldRef *bind_check_world(lua_State *L, int arg);
BodyRef  *bind_check_body(lua_State *L, int arg);       /* alive, or an error that names it */
JointRef *bind_check_joint(lua_State *L, int arg);
DigRef   *bind_check_dig(lua_State *L, int arg);
ShapeRef *bind_check_shape(lua_State *L, int arg);
BodyRef  *bind_body_of(lua_State *L, int arg, const WorldRef *world);  /* alive and of this world */

/* world: stack index of the world's userdata. A null id pushes nil. */
void bind_push_body(lua_State *L, int world, dig_body id);
int  bind_push_bodies(lua_State *L, int world, const dig_body *ids, int n);     /* a list; 1 */
void bind_push_joint(lua_State *L, int world, dig_joint id);
void bind_push_region(lua_State *L, int world, dig_region id);
void bind_push_dig(lua_State *L, int world, dig_dig id);
void bind_push_world_of(lua_State *L, int handle);      /* the world's userdata of a handle */
void bind_push_vec3(lua_State *L, vec3 v);
void bind_push_quat(lua_State *L, quat q);
void bind_push_list(lua_State *L, int size);            /* a list that prints its items */
void bind_push_matrix(lua_State *L, const real *m, int size);   /* list of rows */

/* "body 'crate'", "body #12" */
void bind_push_body_name(lua_State *L, const BodyRef *b);

/* Leaves the reason on a handle that stops being valid, if there is one. */
void bind_mark_removed(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen, const char *how);

/* The Lua side of a world: a table {bodies = {}, joints = {}, data = {}, ...}. */
void bind_push_state(lua_State *L, int world);

/* ---- layers and links -------------------------------------------------------------------- */

/* "thermal" -> 2; an error names the layers. */
uint32_t bind_layer(lua_State *L, int index, const char *what);
/* A kind of link and the layer it is in: "contact", "joint", or a layer's name for any link of that layer; kind -1 = any. */
/* Fields of a message in the table on the top. */
void bind_set_message(lua_State *L, int world, const dig_message *m);
void bind_link_kind(lua_State *L, int index, const char *what, uint32_t *layer, int *kind);

/* ---- values ------------------------------------------------------------------------- */

/* The length of v, also where it is so short or long that squares are not held. */
real bind_length(vec3 v);
/* Makes v one long; false, and v as it was, when it has no direction. */
bool bind_unit(vec3 *v);
/* The length of a direction; one whose squares are not held is made one long first. 0: it has none. */
real bind_direction(vec3 *v);
bool bind_is_vec3(lua_State *L, int index);
vec3 bind_vec3(lua_State *L, int index, const char *unit, const char *what, const char *field);
quat bind_quat(lua_State *L, int index, const char *what, const char *field);
real bind_real(lua_State *L, int index, const char *unit, const char *what, const char *field);
/* "play" (plan), 0.001 or "1 mm" (tolerance, m; plan is then empty). */
void bind_accuracy(lua_State *L, int index, const char *what, dig_text *plan, real *tolerance);
lua_Integer bind_int(lua_State *L, int index, const char *what, const char *field);
/* Raises an error where an angle past a full turn looks like one in degrees ('90 deg' and '90 rad' are taken as they are). */
void bind_refuse_degrees(lua_State *L, int index, const char *what, const char *field);
/* A line on stderr with the script's position, once: what is legal but hardly meant. */
void bind_remark(lua_State *L, const char *text);
real bind_seconds(lua_State *L, int index, const char *what);

/* Fields of a table of arguments. A nil field leaves *value alone and returns false. */
void bind_push_declared(lua_State *L, const char *what);        /* the fields that core.declare(what, ...) named */
void bind_arguments(lua_State *L, int table, const char *what);  /* checks that it is a table, and its keys against those */
bool bind_get_vec3(lua_State *L, int table, const char *what, const char *field, const char *unit, vec3 *value);
bool bind_get_quat(lua_State *L, int table, const char *what, const char *field, quat *value);
bool bind_get_real(lua_State *L, int table, const char *what, const char *field, const char *unit, real *value);
/* Of the table at 2: a vector field, or a number (with unit) times the direction in its field `along`. */
vec3 bind_directed(lua_State *L, const char *what, const char *field, const char *unit);

/* ---- effects ------------------------------------------------------------------------ */

/* Raises the error of an effect's function, if one waits. */
void bind_own_check(lua_State *L, WorldRef *world);
/* Remembers the present line of the script as where a thing was made ("bodies", "joints", "regions") or first pushed ("pushes"). */
void bind_note(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen);
/* Pushes "world.lua:12", where that body was made; "" or nil for one that no line of a script made. */
void bind_push_made(lua_State *L, int world, dig_body b);
/* body:disable, with what its handles and those of its joints are to say. */
dig_status bind_disable(lua_State *L, int world, dig_body b);
/* A frame step, or an error; bodies that keep it from being taken are set aside. */
void bind_step(lua_State *L, int world);
/* Before a body, joint or region goes: what it called for is said, and its line forgotten. */
void bind_forget(lua_State *L, int world, const char *kind, uint32_t slot, uint32_t gen);
/* What first called for each effect, in words, where it is known. */
void bind_explain(lua_State *L, int world);

/* ---- def structs from tables ----------------------------------------------------------- */

typedef struct Fill {
    lua_State      *L;
    int             table;      /* stack index of the table that is read             */
    int             anchor;     /* stack index of a table that keeps arrays alive    */
    const char     *what;       /* "world:sphere"                                    */
    const char     *subject;    /* "body 'plank 7'", or what: starts range errors    */
    const WorldRef *world;      /* for handles and materials; may be NULL            */
} Fill;

/* Fills one field from the value on top of the stack (which stays). */
void bind_fill_field(const Fill *f, const dig_param *row, void *field);

/* Fills every field that the table has. */
void bind_fill(const Fill *f, const dig_param *rows, void *base);

/* Fields of effects (dig_effect_schema) that a body may have. */
enum { BIND_SETS = 40 };
/* Row sets of all that a body's table may have: those of the body, `own` (may be NULL), those of effects; ends with NULL. */
void bind_body_sets(const dig_param *own, const dig_param *sets[BIND_SETS]);
/* The row of an effect's body fields by name, and the effect's schema; NULL: there is none. */
const dig_param *bind_effect_row(const char *name, dig_schema *of);
/* Structs of the effects whose fields the table has, as a userdata that is pushed (nil: none); bind_effects_join then makes the
 * body take part in them. */
void bind_effects_read(const Fill *f);
void bind_effects_join(lua_State *L, int read, const WorldRef *world, dig_body body);

/* Rows of digbox.material_pair, and of the place of a shape in a body. */
const dig_param *bind_pair_rows(void);
const dig_param *bind_part_rows(void);

/* Raises an error for a key that is neither in the row sets (NULL-terminated) nor in extras (NULL-terminated, may be NULL). */
void bind_check_keys(lua_State *L, int table, const char *what, const dig_param *const *sets, const char *const *extras);

/* Puts in the place of the table below the top, and of `what` at the top ("joint.motor"), a table that reads the same and cannot be
 * assigned to; and takes what was frozen out again where such a table is given (anything else stays as it is). */
void bind_freeze(lua_State *L, const char *what);
void bind_thaw(lua_State *L, int index);

/* Pushes a field of a def struct as a Lua value. */
void bind_push_field(lua_State *L, int world, const dig_param *row, const void *field);

/* The shape and the pose in the table of arguments at 2: {digbox.sphere{...}, at=, rotation=}, {shape = ...} or {sphere = {...}}.
 * The table is replaced by a copy that has the shape as its field "shape". */
const dig_shape_def *bind_shape_argument(lua_State *L, const char *what, pose *at);

/* A body whose shapes are given; the table at index 2 holds the body's fields. */
int bind_create_body(lua_State *L, const char *what, const dig_shape_def *shapes, int count, bool fixed, const dig_param *own,
                     const char *const *extras);

#endif
