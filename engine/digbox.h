/* digbox.h - the public C API of digbox, a 3D physics sandbox built on
 * dynamic interaction graphs (DIGs).
 *
 * Units are SI, angles are radians, y is up by habit only: nothing in the
 * engine prefers an axis. Every fallible call returns a dig_status and leaves
 * the world as it was when it fails; dig_error(w) then holds one sentence
 * with the value, its unit and its bound.
 *
 * Handles are values. A zeroed handle is null; a handle to something removed
 * is dead and detected. Nothing here prints, exits or keeps global state, so
 * any number of worlds can live side by side, one thread each.
 *
 * This header includes nothing of the engine: it lies below floor 0.
 */
#ifndef DIGBOX_H
#define DIGBOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DIGBOX_VERSION "0.1.0"

typedef double real;

typedef struct vec3 { real x, y, z; } vec3;
typedef struct quat { real x, y, z, w; } quat;          /* w is the scalar part */
typedef struct pose { vec3 p; quat q; } pose;           /* q rotates local to world */

typedef struct dig_world dig_world;

/* ---- status ---------------------------------------------------------- */

typedef enum dig_status {
    DIG_OK = 0,
    DIG_E_ARG,          /* an argument is out of its range          */
    DIG_E_DEAD,         /* the handle's object was removed          */
    DIG_E_KIND,         /* the object is of another kind or world   */
    DIG_E_FULL,         /* a documented limit is reached            */
    DIG_E_MEMORY,       /* no memory                                */
    DIG_E_FINITE,       /* a number stopped being finite            */
    DIG_E_BUSY,         /* not allowed while the world is stepping  */
    DIG_E_FILE,         /* a file could not be read or written      */
    DIG_E_FORMAT,       /* a file is not what it should be          */
    DIG_STATUS_COUNT
} dig_status;

const char *dig_status_name(dig_status s);

/* ---- parameters: declared once, read by Lua, docs, checks and files -- */

typedef enum dig_kind {
    DIG_REAL,           /* real                                          */
    DIG_INT,            /* int64_t                                       */
    DIG_BOOL,           /* bool                                          */
    DIG_VEC3,           /* vec3                                          */
    DIG_DIR,            /* vec3, not zero; stored normalised             */
    DIG_QUAT,           /* quat, normalised                              */
    DIG_SIZE3,          /* vec3 > 0; a single number means a cube        */
    DIG_RANGE,          /* real[2], lo <= hi                             */
    DIG_PAIR,           /* real[2], in any order                         */
    DIG_COLOUR,         /* vec3, 0..1 linear; x < 0 means "not given"    */
    DIG_TEXT,           /* dig_text                                      */
    DIG_MATERIAL,       /* dig_text: name of a material                  */
    DIG_BODY,           /* dig_body                                      */
    DIG_JOINT,          /* dig_joint                                     */
    DIG_POINTS,         /* dig_points                                    */
    DIG_INDICES,        /* dig_indices                                   */
    DIG_TABLE,          /* nested struct with rows of its own            */
    DIG_CHOICE          /* int64_t: index into the row's choices         */
} dig_kind;

typedef struct dig_text    { char s[64]; } dig_text;    /* zero-terminated, at most 63 bytes */
typedef struct dig_points  { const vec3 *v; int count; } dig_points;       /* borrowed for the call */
typedef struct dig_indices { const int64_t *v; int count; } dig_indices;   /* borrowed for the call */

typedef struct dig_param dig_param;
struct dig_param {
    const char *name;       /* Lua key                                            */
    dig_kind    kind;
    const char *unit;       /* "m", "kg", "N*m/rad", "1"; "" when it has none     */
    const char *doc;        /* one sentence                                       */
    real        fallback;   /* default, for REAL INT BOOL CHOICE; NaN = no default,
                             * stays NaN when not given; vectors default to this
                             * in each component                                  */
    real        min, max;   /* inclusive range; NaN is never inside               */
    size_t      offset;     /* into the def struct                                */
    const dig_param  *rows; /* DIG_TABLE: its own rows, offsets from this offset  */
    const char *const *choices;   /* DIG_CHOICE: NULL-terminated                  */
    bool        required;
    int         most;       /* DIG_POINTS, DIG_INDICES: entries; 0 = what memory allows   */
};

/* One set of rows with the size of the struct they describe. */
typedef struct dig_schema {
    const char      *name;      /* "body", "box", "hinge"      */
    const char      *doc;       /* one sentence                */
    const dig_param *rows;      /* ends with a row of name NULL */
    size_t           size;      /* bytes of the def struct     */
} dig_schema;

/* kinds: "world", "body", "material", "room", "region", "joint.common" (one each), "shape", "joint" (one per type). Index from 0;
 * NULL past the end, so that a caller can list them all. */
const dig_schema *dig_schema_at(const char *kind, int index);
const dig_schema *dig_schema_find(const char *kind, const char *name);

/* Fills def with the defaults of the rows (recursively). */
void dig_schema_defaults(const dig_schema *s, void *def);

/* Parses "4 cm", "9.81 m/s^2", "30 deg", "2 N m" into SI. want is the unit of
 * the row. On failure writes one sentence into why (capacity bytes). */
dig_status dig_unit_parse(const char *text, const char *want, real *value, char *why, size_t capacity);

/* The nearest of the candidates to name, or NULL when none is near enough
 * (edit distance above max(1, length / 3)). */
const char *dig_suggest(const char *name, const char *const *candidates, int count);

/* ---- handles ---------------------------------------------------------- */

typedef struct dig_body  { uint32_t slot, gen; } dig_body;
typedef struct dig_joint { uint32_t slot, gen; } dig_joint;
typedef struct dig_region { uint32_t slot, gen; } dig_region;
typedef struct dig_dig   { uint32_t id; uint32_t layer; } dig_dig;      /* ids are never reused; 0 = none */

/* Who is joined to whom, and by what: one graph a layer. */
enum { DIG_LAYER_MECHANICAL, DIG_LAYER_ELECTRICAL, DIG_LAYER_THERMAL, DIG_LAYER_HYDRAULIC, DIG_LAYER_RANGE, DIG_LAYERS };
const char *dig_layer_name(uint32_t layer);             /* "mechanical", "electrical", ...; NULL past the end */

/* ---- world -------------------------------------------------------------- */

typedef struct dig_world_def {
    vec3     gravity;       /* m/s^2                                     */
    real     step;          /* s, frame step                             */
    dig_text accuracy;      /* plan name, or empty when tolerance given  */
    real     tolerance;     /* m; NaN = by name                          */
    int64_t  seed;
    int64_t  threads;       /* 1..64                                     */
    dig_text plane;         /* "", "xy", "yz", "xz": motion kept in it   */
    dig_text friction_law;  /* "coulomb" (default) or "decay"            */
    bool     sleeping;      /* DIGs at rest fall asleep                  */
} dig_world_def;

dig_world_def dig_world_defaults(void);
dig_status    dig_world_open(const dig_world_def *def, dig_world **w, char *why, size_t capacity);
void          dig_world_close(dig_world *w);
const char   *dig_error(const dig_world *w);            /* of the last call that failed */
dig_status    dig_world_step(dig_world *w);             /* one frame step, or nothing */
/* Whose numbers made the last step fail with DIG_E_FINITE; null: nobody's, or those of an effect of the caller's. Without that body
 * (dig_body_disable) the step can be taken. */
dig_body      dig_world_culprit(const dig_world *w);
dig_status    dig_world_inject(dig_world *w, dig_body b);       /* for tests: in the next step its velocity is NaN */
real          dig_world_time(const dig_world *w);       /* s = steps * step */
uint64_t      dig_world_steps(const dig_world *w);
real          dig_world_frame(const dig_world *w);      /* s, the frame step */
vec3          dig_world_gravity(const dig_world *w);
dig_status    dig_world_set_gravity(dig_world *w, vec3 g);
dig_status    dig_world_set_accuracy(dig_world *w, const char *plan, real tolerance);
const char   *dig_world_accuracy(const dig_world *w);
/* What was done in it so far, in units of about ten nanoseconds: counted, not timed, so that equal calls take equal amounts on every
 * machine. Steps, questions, shapes that are made, copies. */
uint64_t      dig_world_work(const dig_world *w);
uint64_t      dig_world_checksum(const dig_world *w);   /* of the whole state; same state, same value */
dig_status    dig_world_check(dig_world *w);            /* every invariant; DIG_OK or the first broken one */

typedef struct dig_snapshot dig_snapshot;
dig_status dig_world_snapshot(dig_world *w, dig_snapshot **s);
dig_status dig_world_restore(dig_world *w, const dig_snapshot *s);      /* bit exact; only into its own world */
void       dig_snapshot_free(dig_snapshot *s);
dig_status dig_world_save(dig_world *w, const char *path);
dig_status dig_world_load(const char *path, dig_world **w, char *why, size_t capacity);
/* What the program around a world wants to find again beside it in its file: any bytes, at most 256 MiB, which the world itself never
 * looks at. No part of its state: not in snapshots, not in the checksum. */
dig_status  dig_world_note(dig_world *w, const void *bytes, size_t size);
const void *dig_world_noted(const dig_world *w, size_t *size);         /* NULL = nothing */
/* The bytes of such a file; free() them. */
dig_status dig_world_pack(dig_world *w, void **bytes, size_t *size);
dig_status dig_world_unpack(const void *bytes, size_t size, dig_world **w, char *why, size_t capacity);

typedef struct dig_energy {     /* J */
    real kinetic, potential, elastic, heat, electric;
    real work_in;       /* by pushes, hits, movers, motors and other outside acts since the start */
    real law;           /* work of the laws of regions since the start: of their forces, and of their gravity where it is not the world's */
    real lost;          /* to friction, impacts, dampers and drag since the start                 */
    real numerical;     /* total + lost - initial - work_in - law: what the integration made up   */
    real total;         /* kinetic + potential + elastic + heat + electric                        */
    real initial;       /* total at the first step, plus what bodies added since brought          */
} dig_energy;

dig_energy dig_world_energy(const dig_world *w);
vec3       dig_world_momentum(const dig_world *w);              /* kg m/s    */
vec3       dig_world_angular_momentum(const dig_world *w);      /* kg m^2/s about the origin */

typedef struct dig_stats {
    int      bodies, awake, digs, contacts, pairs, joints;
    uint64_t events, steps;             /* since the start                              */
    uint64_t rejected;                  /* steps that failed and were undone            */
    int      groups;                    /* sets of DIGs advanced together, last step    */
    int      iterations;                /* solver sweeps, summed over groups            */
    int      factors;                   /* of them, factorisations: all rows of a group solved at once */
    int      substeps;                  /* parts of the step, summed over groups        */
    int      located;                   /* impacts located in time, last step           */
    int      traced, conserved, swept;  /* groups by the way they were advanced, last step */
    /* what was not solved in the last step, as nothing called for it, and what had to be: */
    int      unturned;                  /* rotations: of awake spheres that nothing can turn */
    int      smooth;                    /* frictions: pairs near each other without friction */
    int      fast;                      /* bodies that moved farther than their inner radius: only looking along their way keeps them out of walls */
    int      evaluations;               /* of the equations of motion, by traced and conserved groups, last step */
    int      refused;                   /* integration steps refused by their error estimate, last step */
    int      trace_events;              /* impacts, slips, stops and limits traced, last step */
    /* since the start, or since the file was loaded: what was reached, and by which ways */
    uint64_t all_traced, all_conserved, all_swept, all_refused;         /* groups times steps; integration steps */
    real     worst_residual, worst_penetration, worst_joint_error;      /* as residual ... below, over all steps  */
    uint64_t gave_up;                   /* times since the start that a group left a finer way within its budget */
    char     gave_up_why[64];           /* reason of the last time                      */
    /* messages since the start: posted, got by somebody, lost (receiver gone, no way, cut off by a storm), not sent twice */
    uint64_t posted, delivered, dropped, repeated, storms;
    uint64_t warnings;                  /* times since the start that the world found itself unreliable: dig_warnings */
    real     residual;                  /* m/s, worst velocity change of the last sweep */
    real     penetration;               /* m, worst at the end of the step              */
    real     joint_error;               /* m or rad, worst at the end of the step       */
    real     us_sense, us_touch, us_graph, us_advance, us_commit, us_report;  /* us CPU, last timed step (every 16th) */
    size_t   bytes;                     /* all memory of the world                      */
    uint64_t allocations;               /* calls to the allocator since the start       */
} dig_stats;

dig_stats dig_world_stats(const dig_world *w);
void      dig_time_every_step(dig_world *w, bool on);       /* us_... of every step, not of each 16th; costs about a microsecond a step */

/* ---- what the world notices about itself ---------------------------------- */

typedef enum dig_rule { DIG_RULE_ENERGY, DIG_RULE_OVERLAP, DIG_RULE_JOINT, DIG_RULE_RESIDUAL, DIG_RULE_BUDGET, DIG_RULES } dig_rule;

typedef struct dig_rule_info {
    const char *name;           /* "energy"                             */
    const char *reason;         /* what is wrong, one clause            */
    const char *advice;         /* what to do about it, one clause      */
    const char *unit;           /* of value and bound                   */
} dig_rule_info;

const dig_rule_info *dig_rule_get(dig_rule rule);

#define DIG_WARNINGS 64u        /* most that are kept */

typedef struct dig_warning {
    dig_rule rule;
    real     time;              /* s, when it was first certain         */
    dig_body body;              /* where; may be dead by now            */
    dig_text name;              /* its name then; empty = it has none   */
    uint32_t dig;               /* id of its DIG then; 0 = none         */
    real     value, bound;      /* the worst so far, and what is borne  */
    uint64_t times;             /* that this body broke this rule       */
    char     why[96];           /* more about it, or empty              */
} dig_warning;

/* One for each rule and body, in the order of time. Fills at most capacity entries and returns the number there are. */
int dig_warnings(const dig_world *w, dig_warning *out, int capacity);

/* ---- effects ------------------------------------------------------------ */

typedef struct dig_effect_info {
    const char *name, *law;
    bool   on;          /* not switched off, and something calls for it */
    bool   allowed;     /* not switched off by hand      */
    int    bodies;      /* taking part in the last step; of an effect on the world as a whole, its members */
    real   us;          /* us of the last timed step (every 16th) */
    real   us_mean;     /* us of a step, mean of all timed steps since the start */
    size_t bytes;       /* of what it keeps; 0 until a scene calls for it */
    uint64_t calls;     /* groups and steps it took part in since the start; 0 until a scene calls for it */
    char   why[96];     /* what called for it            */
    bool   explained;   /* why is the caller's (dig_effect_explain, or that of join, option, add), not a general sentence */
    bool   own;         /* added by the caller: dig_effect_add */
    /* What first called for it, when that is known; the others are null, and so is the handle of what is gone. */
    dig_body first; dig_joint first_joint; dig_region first_region;
} dig_effect_info;

int        dig_effect_count(const dig_world *w);
dig_status dig_effect_get(const dig_world *w, int index, dig_effect_info *info);
dig_status dig_effect_set(dig_world *w, const char *name, bool on);             /* by hand */
dig_status dig_effect_explain(dig_world *w, const char *name, const char *why);  /* what called for it, in words, unless that was said before */

/* What an effect keeps, as structs that its rows describe. `part` is "world" (options of the effect as a whole) or "body" (fields
 * of a body, which thereby takes part). Index from 0 over all effects of this build; false past the end; schema->rows is NULL
 * where an effect has no such part. */
bool       dig_effect_schema(int index, const char *part, dig_schema *schema);
/* The body takes part in the effect with this struct, or its struct is replaced. why: who called for it, in words ("world.lua:12"),
 * kept of the first. DIG_E_ARG: a field is out of range. */
dig_status dig_effect_join(dig_world *w, const char *effect, dig_body b, const void *member, const char *why);
dig_status dig_effect_leave(dig_world *w, const char *effect, dig_body b);
/* The struct of a body; false: it does not take part. Or its options; false: not called for, and options holds the defaults. */
bool       dig_effect_member(const dig_world *w, const char *effect, dig_body b, void *member);
bool       dig_effect_options(const dig_world *w, const char *effect, void *options);
dig_status dig_effect_option(dig_world *w, const char *effect, const void *options, const char *why);     /* sets them, and switches it on */

/* ---- effects of one's own ---- */

/* force: asked for forces, at every evaluation of the equations of motion. settle: once at the end of the frame step, to look. */
typedef enum dig_stage { DIG_STAGE_FORCE, DIG_STAGE_SETTLE, DIG_STAGES } dig_stage;
const char *dig_stage_name(dig_stage s);                /* "force", ... */

typedef struct dig_effect_part {    /* a body that takes part, at the instant of the call */
    dig_body body;
    vec3     position; quat rotation;   /* m, body origin                     */
    vec3     centre;                    /* m, centre of mass                  */
    vec3     velocity, spin;            /* m/s of the centre of mass, rad/s   */
    real     mass;                      /* kg                                 */
    vec3     force, torque;             /* N at the centre of mass, N m: to be set; zero before */
} dig_effect_part;

typedef struct dig_effect_call {
    real time;                  /* s, the instant                             */
    real dt;                    /* s for which the force will hold; 0 = at this instant only. settle: the frame step */
    dig_effect_part *parts;     /* of one group: bodies that may meet         */
    int  count;
} dig_effect_call;

/* May be asked more than once for the same instant. On failure it writes one sentence into why; the step is then undone. */
typedef dig_status dig_effect_fn(void *data, const dig_effect_call *call, char *why, size_t capacity);

typedef struct dig_effect_def {
    const char *name, *law;     /* at most 31 and 95 bytes                    */
    dig_stage   stage;
    bool        all;            /* all bodies that move take part; else those of dig_effect_join (member NULL) */
    dig_effect_fn *step;
    real      (*energy)(void *data, const dig_effect_call *call);   /* J that its forces store, of all that take part, or NULL */
    void       *data;           /* must last as long as the world and its snapshots */
    const char *why;            /* as for join                                */
} dig_effect_def;

/* Its step is called by the thread that steps the world. Not saved with the world: functions cannot be. DIG_E_FULL: too many. */
dig_status dig_effect_add(dig_world *w, const dig_effect_def *def);
dig_status dig_effect_drop(dig_world *w, const char *name);     /* takes one that was added away; snapshots keep it */

/* ---- materials ------------------------------------------------------------ */

typedef struct dig_material_def {
    real density;               /* kg/m^3                                */
    real friction;              /* 1, static                             */
    real friction_dynamic;      /* 1, NaN = as static                    */
    real rolling_friction;      /* 1, lever arm over radius              */
    real restitution;           /* 1, 0..1                               */
    real heat_capacity;         /* J/(kg K)                              */
    real conductivity;          /* W/(m K)                               */
    real resistivity;           /* ohm m                                 */
    real strength;              /* Pa                                    */
    real stiffness;             /* Pa, Young's modulus                   */
    vec3 colour;                /* linear RGB 0..1                       */
    real roughness;             /* 1, of the surface as drawn            */
    real metallic;              /* 1, 0 or 1 as drawn                    */
    dig_text pattern;           /* drawn as: plain wood brick tile stripe */
    dig_text sound;
} dig_material_def;

/* Friction of a pair that has a row of its own. */
typedef struct dig_pair_def {
    dig_text a, b;
    real friction, friction_dynamic, rolling_friction, restitution;     /* NaN = by the general rule */
} dig_pair_def;

dig_status dig_material_add(dig_world *w, const char *name, const dig_material_def *def);
dig_status dig_material_get(const dig_world *w, const char *name, dig_material_def *def);
dig_status dig_material_pair(dig_world *w, const dig_pair_def *def);
const char *dig_material_name(const dig_world *w, int index);           /* NULL past the end */
bool dig_material_pair_at(const dig_world *w, int index, dig_pair_def *def);    /* false past the end; NaN: by the rule for pairs */

/* ---- shapes and bodies ------------------------------------------------------ */

/* What one part of a body has of its own; NaN = as the body. */
typedef struct dig_surface_def {
    real friction, friction_dynamic, rolling_friction;  /* 1 */
    real restitution;                                   /* 1 */
} dig_surface_def;

/* A solid of one shape type, placed in its body. data points to a struct
 * described by dig_schema_find("shape", type). */
typedef struct dig_shape_def {
    const char *type;       /* sphere box capsule cylinder cone plane hull mesh heightfield */
    const void *data;
    pose        at;         /* in the body; a zero quaternion means none */
    dig_text    material;   /* empty = the body's                        */
    vec3        colour;     /* x < 0 = the body's                        */
    real        density;    /* kg/m^3, 0 = the body's or its material's  */
    const dig_surface_def *surface;     /* NULL = the body's             */
} dig_shape_def;

typedef struct dig_sphere_def   { real radius; } dig_sphere_def;                /* m */
typedef struct dig_box_def      { vec3 size; } dig_box_def;                     /* m, full extents */
typedef struct dig_capsule_def  { real radius, length; } dig_capsule_def;       /* m, straight part along y */
typedef struct dig_cylinder_def { real radius, height; } dig_cylinder_def;      /* m, axis y, origin at the middle */
typedef struct dig_cone_def     { real radius, height; } dig_cone_def;          /* m, axis y, apex up, origin = centre of mass */
typedef struct dig_plane_def    { vec3 normal; real offset; } dig_plane_def;    /* solid below normal.x = offset */
typedef struct dig_hull_def     { dig_points points; } dig_hull_def;            /* m */
typedef struct dig_mesh_def     { dig_points vertices; dig_indices triangles; } dig_mesh_def;  /* indices from 1 */
typedef struct dig_heightfield_def {            /* y = height(x, z), centred on the origin */
    dig_points  unused;
    const real *heights;                        /* m, [rows * columns], row = z, column = x */
    int64_t     columns, rows;
    vec3        size;                           /* m, x and z extents; y is ignored */
} dig_heightfield_def;

typedef enum dig_body_kind { DIG_DYNAMIC, DIG_KINEMATIC, DIG_STATIC } dig_body_kind;
typedef enum dig_mode { DIG_MOVING, DIG_RESTING, DIG_FIXED } dig_mode;
/* How a body is moved, to compare: auto = by the accuracy; else once a substep by the rule of that name. switch = Euler in its first
 * step, from an impact to the end of that step and in the one after it, Verlet otherwise. */
typedef enum dig_integrator { DIG_AUTO, DIG_EULER, DIG_VERLET, DIG_SWITCH, DIG_INTEGRATORS } dig_integrator;

typedef struct dig_body_def {
    dig_text name;
    vec3     at;                /* m, origin of the body                            */
    quat     rotation;
    vec3     velocity, spin;    /* m/s, rad/s; of the centre of mass                */
    real     mass;              /* kg; NaN = from density                           */
    real     density;           /* kg/m^3; NaN = from the material                  */
    dig_text material;
    real     friction, friction_dynamic, rolling_friction, restitution;   /* NaN = from the material */
    bool     fixed, kinematic;
    real     gravity_scale;
    bool     collides;
    bool     turns;             /* false: it keeps its orientation, as a particle does */
    int64_t  group;             /* bodies of the same negative group never touch    */
    int64_t  integrator;        /* dig_integrator                                   */
    vec3     colour;
    real     opacity;           /* 1, share of the light that its surface stops, as drawn */
    vec3     sheet;             /* 1, number, column and row: a particle of a sheet; number 0 = of none */
    bool     bullet;            /* reserved: continuous collision is always on      */
    const dig_shape_def *shapes;
    int      shape_count;
} dig_body_def;

dig_body_def dig_body_defaults(void);
dig_status   dig_body_create(dig_world *w, const dig_body_def *def, dig_body *out);
dig_status   dig_body_remove(dig_world *w, dig_body b);     /* its joints go with it */
bool         dig_body_alive(const dig_world *w, dig_body b);

typedef struct dig_body_state {
    const char   *name;
    dig_body_kind kind;
    dig_mode      mode;
    bool          awake;
    vec3          position;         /* m, body origin                   */
    quat          rotation;
    vec3          centre;           /* m, centre of mass, world         */
    vec3          velocity, spin;   /* m/s at the centre of mass, rad/s */
    real          mass;             /* kg; fixed, kinematic: as given, or infinite */
    real          inertia[9];       /* kg m^2, world axes, row by row   */
    vec3          force, torque;    /* N, N m: mean resultant over the last step */
    vec3          low, high;        /* m, bounds                        */
    real          energy;           /* J, kinetic + potential           */
    real          work_received;    /* J by pushes and hits             */
    dig_dig       dig;              /* id 0 for static bodies           */
    int           shape_count;
} dig_body_state;

dig_status dig_body_get(const dig_world *w, dig_body b, dig_body_state *out);

/* Every field of the thesis' Appendix B (MAV_newton); see docs/dig.md. */
typedef struct dig_body_debug {
    uint64_t m_id;              /* last message received, 0 = none   */
    uint32_t db_id;             /* slot                              */
    const char *mess_type;      /* "" = none                         */
    uint32_t dig_id;
    real     mess_time;         /* s                                 */
    bool     floor;             /* constraint mode (at rest)         */
    bool     collided;          /* struck something in the last step */
    bool     euler;             /* no history for Verlet: not in free flight in the last step, or before its first; see integrator */
    vec3     curr_pos, prev_pos, next_pos;      /* m; next = predicted */
    quat     curr_rot, prev_rot, next_rot;
    real     itensor[9], iti[9], itiws[9];      /* local inertia, its inverse, inverse in world axes */
    real     mo_inertia;        /* kg m^2, mean of the principal moments */
    vec3     res_force, torque, c_mass, ang_mom, velocity, omega;
    real     mass, rest;        /* kg, coefficient of restitution    */
    dig_body origin;            /* sender of the last message        */
    const char *material;       /* sp: surface                       */
    real     matrix[16];        /* local to world, row by row        */
    const char *object_type;    /* type of the first shape           */
} dig_body_debug;

dig_status dig_body_inspect(const dig_world *w, dig_body b, dig_body_debug *out);

dig_status dig_body_push(dig_world *w, dig_body b, vec3 force, vec3 at, bool has_at, real lasts);  /* N, world point; lasts <= 0: next step */
dig_status dig_body_twist(dig_world *w, dig_body b, vec3 torque, real lasts);                      /* N m */
dig_status dig_body_hit(dig_world *w, dig_body b, vec3 impulse, vec3 at, bool has_at);             /* N s, at once */
/* Energy, J, or as much as brings it to a temperature, K; the other is NaN. Work done on a body that takes part in the effect heat. */
dig_status dig_body_warm(dig_world *w, dig_body b, real energy, real to);
dig_status dig_body_teleport(dig_world *w, dig_body b, const vec3 *at, const quat *rotation, const vec3 *velocity, const vec3 *spin);
dig_status dig_body_move_to(dig_world *w, dig_body b, vec3 at, const quat *rotation, real over);   /* kinematic only; s, rounded up to whole frame steps */
dig_status dig_body_set_velocity(dig_world *w, dig_body b, vec3 velocity, vec3 spin);              /* kinematic only */
/* A row of an effect (dig_effect_schema), in which the body then takes part, or a row of the body schema that may change: mass
 * density material friction... restitution gravity_scale group collides integrator name colour opacity. */
dig_status dig_body_set(dig_world *w, dig_body b, const char *param, const void *value);
dig_status dig_body_param(const dig_world *w, dig_body b, const char *param, void *value);         /* reads any row; takes no part: default */
dig_status dig_body_wake(dig_world *w, dig_body b);
/* Sets it aside for good: fixed where it is, with no joint, and nothing meets it. Its pose is the last good one. */
dig_status dig_body_disable(dig_world *w, dig_body b);

bool dig_body_touches(const dig_world *w, dig_body a, dig_body b);
bool dig_body_contains(const dig_world *w, dig_body outer, dig_body inner);     /* inner's centre of mass lies inside outer's convex outline */
vec3 dig_body_point_velocity(const dig_world *w, dig_body b, vec3 at);          /* m/s */

/* Lists fill at most capacity entries and return the number there are. */
int dig_bodies(const dig_world *w, dig_body *out, int capacity);
int dig_joints(const dig_world *w, dig_joint *out, int capacity);
dig_body dig_body_find(const dig_world *w, const char *name);                   /* first by slot, or null */

/* ---- the room ------------------------------------------------------------------ */
/* Six walls without a body. A wall that is opened lets bodies out. */
/* at = centre of the floor; of the material, friction and restitution unless they are given (NaN = its own) */
typedef struct dig_room_def { vec3 size; vec3 at; real friction, restitution; dig_text material; } dig_room_def;
dig_status dig_room_set(dig_world *w, const dig_room_def *def);
bool dig_has_room(const dig_world *w);
dig_status dig_room_open(dig_world *w, const char *wall, bool open);            /* "+x" "-x" "+y" "-y" "+z" "-z" */
const char *dig_wall_name(int wall);            /* of 1..6, in that order; "" for all other numbers */

/* ---- regions ------------------------------------------------------------------- */
/* Inside a region other laws hold for bodies whose centre of mass is there. */

typedef struct dig_region_def {
    dig_shape_def shape;
    pose at;
    vec3 gravity;               /* m/s^2; NaN = the world's      */
    real drag;                  /* 1/s  rate at which speed and spin decay, by the time inside */
    real friction_scale;        /* 1                             */
    real restitution_scale;     /* 1                             */
    real conduct;               /* 1    factor on conductances   */
    real time_rate;             /* 1    so many seconds go by inside for one outside */
} dig_region_def;

dig_region_def dig_region_defaults(void);
dig_status     dig_region_create(dig_world *w, const dig_region_def *def, dig_region *out);
dig_status     dig_region_remove(dig_world *w, dig_region r);
bool           dig_region_alive(const dig_world *w, dig_region r);
int            dig_region_bodies(const dig_world *w, dig_region r, dig_body *out, int capacity);
dig_status     dig_region_push(dig_world *w, dig_region r, dig_body b, vec3 force);  /* N in the next step; its work is the law's */

/* ---- joints ------------------------------------------------------------------ */

typedef struct dig_joint_def {
    const char *type;           /* hinge slider ball weld distance rope spring gear rack wheel bolt motor */
    dig_text    name;
    dig_body    a, b;           /* b null = the world                                 */
    vec3        at;             /* m, world point; x NaN = the type's default         */
    vec3        axis;           /* world; NaN = the type's default                    */
    real        breaks_at;      /* N; infinite = never                                */
    bool        collides;       /* do a and b still touch each other? default no      */
    const void *data;           /* struct described by dig_schema_find("joint", type) */
} dig_joint_def;

dig_joint_def dig_joint_defaults(void);
dig_status    dig_joint_create(dig_world *w, const dig_joint_def *def, dig_joint *out);
dig_status    dig_joint_remove(dig_world *w, dig_joint j);
bool          dig_joint_alive(const dig_world *w, dig_joint j);

typedef struct dig_joint_state {
    const char *type, *name;
    dig_body    a, b;
    vec3        at;             /* m, world, now                              */
    real        angle;          /* rad, about the axis since creation         */
    real        distance;       /* m, along the axis, or between the ends     */
    real        speed;          /* rad/s or m/s of the free coordinate        */
    vec3        force, torque;  /* N, N m: what the joint does to a, mean over the last step */
    real        error;          /* m, how far the ends are apart              */
    real        stress;         /* 1, load over what it bears: it breaks above 1; 0 = nothing breaks it */
    bool        at_limit;
} dig_joint_state;

dig_status dig_joint_get(const dig_world *w, dig_joint j, dig_joint_state *out);
typedef struct dig_setting { const char *param; const void *value; } dig_setting;   /* "motor.speed", "friction", "breaks_at", ... */
/* All or none; they are checked together, so min and max of a range may pass those there were. */
dig_status dig_joint_set(dig_world *w, dig_joint j, const dig_setting *settings, int count);
dig_status dig_joint_param(const dig_world *w, dig_joint j, const char *param, void *value);        /* reads one, breaks_at or collides */
dig_joint  dig_joint_find(const dig_world *w, const char *name);

/* ---- dynamic interaction graphs ---------------------------------------------------- */

typedef struct dig_dig_state { int size; bool awake; real energy; const char *plan; } dig_dig_state;

dig_dig    dig_of(const dig_world *w, dig_body b);                              /* id 0: in none */
dig_status dig_dig_get(const dig_world *w, dig_dig d, dig_dig_state *out);      /* DIG_E_DEAD: it is no more */
int        dig_digs(const dig_world *w, dig_dig *out, int capacity);            /* mechanical layer, by id */
int        dig_members(const dig_world *w, dig_dig d, dig_body *out, int capacity);
dig_status dig_dig_accuracy(dig_world *w, dig_dig d, const char *plan, real tolerance);    /* plan NULL: the tolerance, m */

typedef enum dig_link_kind { DIG_LINK_CONTACT, DIG_LINK_JOINT, DIG_LINK_PORT, DIG_LINK_RANGE, DIG_LINK_KINDS } dig_link_kind;

typedef struct dig_link {       /* of another layer than the mechanical one: effort.x and flow.x are numbers, in its units */
    dig_body      a, b;
    dig_link_kind kind;
    dig_joint     joint;        /* null for contacts                  */
    vec3          effort;       /* N on b, mean over the last step    */
    vec3          flow;         /* m/s of b relative to a             */
    real          power;        /* W = effort . flow                  */
    real          began;        /* s                                  */
    vec3          point, normal;/* m; normal from a to b              */
    bool          bound;        /* to a static body: outside all DIGs */
    uint32_t      layer;
} dig_link;

int dig_links_of(const dig_world *w, dig_body b, dig_link *out, int capacity);                  /* mechanical; in other layers: */
int dig_links_of_layer(const dig_world *w, dig_body b, uint32_t layer, dig_link *out, int capacity);
int dig_links_in(const dig_world *w, dig_dig d, dig_link *out, int capacity);
int dig_neighbours(const dig_world *w, dig_body b, int kind, dig_body *out, int capacity);      /* kind < 0: any */
int dig_path(const dig_world *w, dig_body from, dig_body to, int kind, dig_body *out, int capacity);   /* shortest, both ends included; 0 = none */
dig_dig dig_of_layer(const dig_world *w, dig_body b, uint32_t layer);           /* id 0: it has no link there */
int dig_digs_of_layer(const dig_world *w, uint32_t layer, dig_dig *out, int capacity);          /* by id */
int dig_neighbours_in_layer(const dig_world *w, dig_body b, uint32_t layer, dig_body *out, int capacity);
int dig_path_in_layer(const dig_world *w, dig_body from, dig_body to, uint32_t layer, dig_body *out, int capacity);

/* A link of another layer than the mechanical one. */
typedef struct dig_wire { uint32_t layer, slot, gen; } dig_wire;

typedef struct dig_wire_def {
    uint32_t layer;             /* not the mechanical one                                        */
    dig_body a, b;
    bool     bound;             /* b is a boundary of the layer: earth, the air; it joins no DIG */
    real     ratio;             /* what arrives at b for 1 at a, for messages by ratio; 0 = none */
} dig_wire_def;

dig_status dig_wire_add(dig_world *w, const dig_wire_def *def, dig_wire *out);
dig_status dig_wire_set(dig_world *w, dig_wire wire, real effort, real flow);   /* in the layer's units; their product is W */
dig_status dig_wire_remove(dig_world *w, dig_wire wire);
bool       dig_wire_alive(const dig_world *w, dig_wire wire);

/* ---- events and messages ------------------------------------------------------------- */

typedef enum dig_event_kind {
    DIG_EVENT_CONTACT_BEGIN, DIG_EVENT_CONTACT_END, DIG_EVENT_IMPACT, DIG_EVENT_BROKEN, DIG_EVENT_MOVED,
    DIG_EVENT_SLEPT, DIG_EVENT_WOKE, DIG_EVENT_REMOVED, DIG_EVENT_MERGED, DIG_EVENT_SPLIT, DIG_EVENT_LINK,
    DIG_EVENT_UNLINK, DIG_EVENT_MESSAGE, DIG_EVENT_LIMIT_REACHED, DIG_EVENT_OUT_OF_WORLD, DIG_EVENT_ENTERED, DIG_EVENT_LEFT,
    DIG_EVENT_DISABLED, DIG_EVENT_KINDS
} dig_event_kind;

const char *dig_event_name(dig_event_kind k);       /* "contact_begin", ... */

typedef struct dig_event {
    dig_event_kind kind;
    real      time;             /* s                                                   */
    dig_body  a, b;             /* b may be null (a wall of the room)                  */
    dig_joint joint;            /* broken, limit_reached                               */
    uint32_t  dig, other_dig;   /* merged: kept and gone; split: kept and new          */
    int       wall;             /* 1..6 for +x -x +y -y +z -z of the room, else 0      */
    real      speed;            /* m/s approach, > 0                                   */
    real      impulse;          /* N s                                                 */
    real      stress;           /* 1, load over what it bore (broken)                  */
    vec3      point, normal;
    dig_link_kind link;         /* link, unlink                                        */
    uint32_t  layer;            /* link, unlink, merged, split                         */
    uint64_t  message;          /* id of the message                                   */
    dig_region region;          /* entered, left                                       */
} dig_event;

/* Events of the last step in the order (time, kind, lower slot, higher slot). Valid until the next step, be it one that fails. */
int dig_events(const dig_world *w, const dig_event **out);
void dig_tell_moves(dig_world *w, bool on);         /* from the next step on there are events `moved`: of each body that did, in each step */

typedef struct dig_message {
    uint64_t id, root;          /* root: id of the message that this one, by way of others, answers; its own when none */
    real     time;
    dig_body from, to;
    char     kind[32];
    real     value[4];
    vec3     direction;         /* m  from -> to; zero where nobody sent it */
} dig_message;

int dig_messages(const dig_world *w, dig_message *out, int capacity);           /* the last 4096, oldest first */
dig_status dig_message_send(dig_world *w, dig_body from, dig_body to, const char *kind, const real value[4]);
dig_status dig_message_broadcast(dig_world *w, dig_dig d, dig_body from, const char *kind, const real value[4]);
const dig_message *dig_message_of(const dig_world *w, const dig_event *e);      /* of a message event of the last step; NULL: of none */

typedef enum dig_route {
    DIG_ROUTE_TO,               /* one body                                                                     */
    DIG_ROUTE_NEIGHBOURS,       /* who shares a link with the sender, static bodies too                          */
    DIG_ROUTE_DIG,              /* every member of a DIG                                                        */
    DIG_ROUTE_FLOOD,            /* along links, outwards from the sender, which gets none itself                */
    DIG_ROUTE_PATH,             /* everybody on the shortest way to a body, in order                            */
    DIG_ROUTE_REGION,           /* dynamic bodies whose centre of mass is in a region                           */
    DIG_ROUTES
} dig_route;

typedef enum dig_transform {    /* what a link does to the first value of a flood                                */
    DIG_TRANSFORM_SAME,         /* nothing                                                                      */
    DIG_TRANSFORM_SCALE,        /* times `factor`                                                               */
    DIG_TRANSFORM_RATIO,        /* times the ratio of the gear, rack or wire; other links pass nothing          */
    DIG_TRANSFORMS
} dig_transform;

typedef struct dig_post {
    dig_route  route;
    char       kind[32];
    real       value[4];
    dig_body   from;            /* may be null with TO, DIG and REGION                                          */
    dig_body   to;              /* TO, PATH                                                                     */
    dig_dig    dig;             /* DIG; id 0: the one the sender is in when the message is delivered            */
    dig_region region;          /* REGION                                                                       */
    uint32_t   layer;           /* NEIGHBOURS, DIG, FLOOD, PATH                                                 */
    int        link;            /* NEIGHBOURS, FLOOD, PATH: along links of this kind only; < 0: any             */
    int        hops;            /* FLOOD: so far at most; 0 = to the end                                        */
    dig_transform transform;    /* FLOOD                                                                        */
    real       factor;          /* SCALE                                                                        */
    real       after;           /* s; 0 = at once. Who gets it is found when it is delivered                    */
} dig_post;

#define DIG_LOOP 16

typedef struct dig_receipt {
    int      reached;           /* bodies; 0 for a post that waits                                              */
    dig_body loop[DIG_LOOP];    /* FLOOD by ratio: a ring of links in which one body would get two values       */
    int      loop_count;        /* 0 = none; the ring may be longer than what is told of it                     */
} dig_receipt;

dig_post   dig_post_defaults(void);
/* receipt may be NULL. DIG_E_FULL: a storm, more than 10,000 answers at one instant; what is left of it is dropped. */
dig_status dig_message_post(dig_world *w, const dig_post *p, dig_receipt *receipt);
/* One message to many, each with a first value of its own; each body once. */
dig_status dig_message_list(dig_world *w, const dig_post *p, const dig_body *to, const real *value, int count);
/* What is posted from now on answers the message with this root; 0 = nothing. For who handles messages. */
void       dig_message_answering(dig_world *w, uint64_t root);
/* Between steps: message events that wait for the next step become the last ones of dig_events. Returns how many. */
int        dig_message_take(dig_world *w);
void       dig_message_dropped(dig_world *w, int count);                        /* handlers found the receiver gone */

/* ---- exploratory questions: could this happen? ------------------------------------------ */
/* Asked of a copy: whatever the answer, the world is as it was, bit for bit. */

typedef enum dig_verdict { DIG_FREE, DIG_BLOCKED, DIG_NEEDS, DIG_CONFLICT, DIG_UNKNOWN } dig_verdict;

const char *dig_verdict_name(dig_verdict v);    /* "free", "blocked", "needs", "conflict", "unknown" */

typedef struct dig_question {
    dig_body body;
    bool  turns;            /* about `along`, by rad, with N m; else along it, by m, with N      */
    vec3  along;            /* world; its length does not matter                                 */
    real  by;               /* m or rad, > 0                                                     */
    real  with;             /* N or N m, > 0; NaN: how much would it need?                       */
    vec3  at;               /* m, world point where it is pushed; has_at false: centre of mass   */
    bool  has_at;
    real  within;           /* s, how long it is pushed at most                                  */
} dig_question;

dig_question dig_question_defaults(void);       /* by 1 cm, with NaN, within 5 s */

typedef struct dig_part { dig_body body; dig_joint joint; int wall; } dig_part;      /* one of the three; wall 1..6 of the room */

#define DIG_ANSWER_PARTS 16

typedef struct dig_consequence {
    const char *what;       /* "broken": the joint; "moves": the body, by `amount` m             */
    dig_part who;
    real     amount;
} dig_consequence;

typedef struct dig_answer {
    dig_verdict verdict;    /* free: it moves by as much as was asked; blocked: no push does it, from where `moved` ends;
                             * needs: more, `needs`; conflict: what it is part of contradicts itself; unknown: time was up */
    bool     ok;            /* it does what was asked: free, or without a push an answer to how much                     */
    real     needs;         /* N or N m that start it, get it on from where it stopped, or there in time;
                             * NaN = not asked or found, infinite = none does                    */
    real     moved;         /* m or rad, before it had moved `by`, stopped, or time was up       */
    real     time;          /* s that took                                                       */
    dig_part held[DIG_ANSWER_PARTS];    int held_count;     /* what holds it: without these it would move; the first counts most */
    dig_part chain[DIG_ANSWER_PARTS];   int chain_count;    /* from the body by what holds it to what stands firm */
    dig_consequence consequences[DIG_ANSWER_PARTS]; int consequence_count;
    int      trials, steps; /* what the answer cost: copies that were tried, and frame steps of them */
    char     because[256];  /* one sentence                                                      */
} dig_answer;

dig_status dig_ask(dig_world *w, const dig_question *q, dig_answer *a);

/* ---- commands: what was done to a world, to be done again ------------------------------ */
/* Every call that changes a world, steps included, is a command: bytes that hold its arguments and what it returned. Played in
 * order in a world in the same state (dig_world_unpack of what dig_world_pack gave), they lead to the same states, bit for bit:
 * handles, numbers of DIGs and refusals too. Effects of the caller's are played from what their functions gave back. */

/* Called after each command; the bytes are its own until it returns. It must not call the world. */
typedef void dig_tap_fn(void *context, const void *bytes, size_t size);

/* fn NULL: nobody listens any more. At once called for what no file of a world holds: the effects that were added. DIG_E_BUSY:
 * somebody listens already, or the world is stepping. */
dig_status dig_world_tap(dig_world *w, dig_tap_fn *fn, void *context);
/* Carries out the first of some commands; *consumed (may be NULL) gets its length. With a sentence in dig_error, DIG_E_FORMAT: it
 * is no command of this build; DIG_E_KIND: it did not return what it did when it was logged; DIG_E_MEMORY. */
dig_status dig_command_play(dig_world *w, const void *bytes, size_t size, size_t *consumed);
/* Index of the first of some commands into the list below, -1: it is none. Length as above. */
int         dig_command_look(const void *bytes, size_t size, size_t *consumed);
const char *dig_command_name(int index);                /* "step", "push", ...; NULL past the end */

/* ---- questions in space --------------------------------------------------------------- */

typedef struct dig_hit { dig_body body; vec3 point, normal; real distance; real fraction; } dig_hit;

int dig_ray(const dig_world *w, vec3 from, vec3 along, real length, dig_hit *out, int capacity);        /* by distance */
int dig_overlap(dig_world *w, const dig_shape_def *shape, pose at, dig_body *out, int capacity);
/* Moves a shape along from + velocity t + acceleration t^2/2 for `time` s and returns the first thing it meets:
 * 1 = out is filled (distance = travelled, fraction = t / time), 0 = nothing, < 0 = bad argument (dig_error). */
int dig_sweep(dig_world *w, const dig_shape_def *shape, pose at, vec3 velocity, vec3 acceleration, real time, dig_hit *out);

#endif
