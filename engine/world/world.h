/* world/world.h - the state of a world: every table, grouped.
 *
 * Storage stands still: a handle's slot is its row. Solvers work on gathered
 * copies (solve/group.h) that are committed only when the whole step succeeded.
 *
 * Owns:      everything below. Tables grow between steps or in the first stages of step_world only.
 * Invariant: world_check() in check.c.
 * Floor:     world. Includes base, math, geom.
 */
#ifndef DIG_WORLD_H
#define DIG_WORLD_H

#include "base/arena.h"
#include "base/hash.h"
#include "base/list.h"
#include "base/index.h"
#include "base/map.h"
#include "base/share.h"
#include "geom/manifold.h"
#include "geom/tree.h"
#include "world/column.h"
#include "world/graph.h"
#include "world/layer.h"
#include "world/mail.h"
#include "world/message.h"

#define NONE UINT32_MAX

/* Handles that a world gives in its time. One counter for all its slots: a handle of what was removed is never valid again, since no
 * number comes twice; who needs another one then is refused. With what it starts from (world_open) it stays below 2^32. */
#define HANDLES_MOST 3000000000u

/* ---- bodies and their solids ---- */

typedef struct Surface {        /* what friction and restitution need of a surface     */
    int  material;              /* index into world->materials                         */
    real friction, friction_dynamic, rolling, restitution;     /* NaN = the material's  */
} Surface;

/* NaN is NaN; what pads a record is nothing. */
static inline bool surface_same(const Surface *a, const Surface *b)
{
    return a->material == b->material && memcmp(&a->friction, &b->friction, sizeof *a - offsetof(Surface, friction)) == 0;
}

/* What step/watch.c remembers about a body; of rules about a whole group, its first. */
typedef struct BodyWatch {
    real     rise;              /* J      its part of what its group got without work, and has not lost since */
    real     borne;             /* J      its part of how much of that may be */
} BodyWatch;

/* Of a body that broke a rule. */
typedef struct Breach {
    uint32_t since[DIG_RULES], last[DIG_RULES];     /* steps, modulo 2^32, in which a rule was broken, first and last time in a row */
    uint16_t run[DIG_RULES];    /* times in that row, or the most that it counts; 0 = none */
} Breach;

/* m, 1  Where a body got to since it was looked at last, and twice the sines of half its turns; step/rest.c. */
typedef struct Drift { vec3 way, turn; } Drift;

/* Of a group that takes long, see solve/toil.c: steps that did, less those that did not; steps left of its pause; and of the time after a step that
 * was dear. */
typedef struct Toil { uint8_t steps, pause, dear; } Toil;

/* Of all groups that could be crowds, see step/debt.c: work beyond that of a frame, of all steps so far; steps left in which they are. */
typedef struct Debt { uint64_t work; uint32_t pause; } Debt;

/* Of bodies that are alike: made once, never changed. */
typedef struct Inertia {
    Share    share;
    mat3     of, inverse;       /* kg m^2 and 1 over that, body axes, about the centre */
} Inertia;

/* The same, what hardly any step reads of bodies: who changes it has one of his own (body_make_set). */
typedef struct Make {
    Share    share;
    Surface  surface;
    vec3     colour;            /* x < 0 = the material's                              */
    real     opacity;           /* 1      as drawn                                     */
    int64_t  group;
} Make;

typedef struct Body {           /* what every step reads comes first                   */
    uint32_t gen;               /*        generation of the handle                     */
    bool     alive, awake, collides, out;   /* out: already reported out of the world  */
    bool     listed;            /*        in world->awake                              */
    bool     crowded;           /*        a crowd that may sleep had it last: it has a drift in world->drifts */
    bool     paired : 1;        /*        listed, and its pairs are in world->near     */
    bool     rests : 1;         /*        in world->rest there is something of it      */
    bool     alone : 1;         /*        fast, and looked at as if nothing that moves could meet it: flies_alone in step/sense.c */
    bool     pushed : 1;        /*        its pull is found already                    */
    bool     told_blow : 1;     /*        the last message that it got tells of a collision; else BodyRest says what kind that was */
    bool     kept : 1;          /*        the reaches of its solids are of an earlier step: see solid_reach */
    dig_body_kind kind;
    dig_mode mode;
    uint32_t shape_first;       /* list through Solid.next                             */
    uint32_t joint_first;       /* list through JointRec.next                          */
    int      shape_count;
    uint8_t  accuracy;          /* asked for this DIG's sake, 0 = the world's          */
    uint8_t  integrator;        /* dig_integrator                                      */
    bool     round_inertia;     /*        isotropic: no gyroscopic torque              */
    bool     collided, euler;   /*        in the last step: struck; was not in free flight before */
    Toil     toil;              /*        of the group it is in                        */
    vec3     x;                 /* m      centre of mass, world                        */
    quat     q;                 /* 1      body to world                                */
    vec3     v, w;              /* m/s, rad/s of the centre of mass, world             */
    vec3     centre;            /* m      centre of mass in the body frame             */
    real     mass, inv_mass;    /* kg; 0 and 0 for static and kinematic                */
    real     gravity_scale;
    real     rate;              /* 1      of time where it is (world/region.h); 1 outside of all regions */
    real     outer;             /* m      no point of it is farther from the centre    */
    real     rim;               /* m      the same of what turning moves: 0 for a ball about its centre */
    real     pull;              /* m/s^2  gravity and pushes do no more to any point of it in this step; made anew in each */
    real     still;             /* s      time spent slower than the sleep threshold   */
    real     travel;            /* m      no point of it has moved farther so far, added up over steps; for Pair.until */
    real     roam;              /* m      that and its way in this step: no face of its reach differs by more from that of another step than the two
                                 *        roams do from the travel of the earlier one; infinite where it was made longer. No part of the state */
    real     lies;              /* m      with less roam its solids are within their leaves, slow, and new to no plane. 0 = not known, < 0: and
                                 *        what acts on it is not what did. No part of the state */
    const Inertia *inertia;           /*        shared by all that have the same, copies of the world too; NULL: 0 */
    vec3     prev_x;  quat prev_q;      /* before the last step                        */
    vec3     force, torque;     /* N, N m mean resultant of the last step              */
    real     work;              /* J      received from pushes and hits                */
    uint16_t trace_wait, trace_pause;   /* steps until its group is traced again; how many it was put off for last */
    real     trace_step;        /* s      length of the last step of its traced motion; 0 = none */
    BodyWatch watch;            /* step/watch.c; no part of the state                  */
    /* What steps hardly ever read comes last. */
    real     density;           /* kg/m^3 mean                                         */
    real     told_mass;         /* kg     as given to one that is not dynamic, 0 = none; no law asks for it */
    const Make *make;           /*        shared; NULL: nobody yet                     */
    real     move_start, move_end;      /* s  kinematic: of its way to BodyRest.move_to, end < start = none */
    uint64_t message_id, message_root; real message_time; dig_body message_from;       /* the last one that it got */
} Body;

/* What few bodies have, in a list of its own by their slots: what nobody has (Body.rests) is neither read nor written, and takes no memory. */
typedef struct BodyRest {
    char     name[64];          /*        "" = it has none                             */
    vec3     sheet;             /* 1      number, column and row, as drawn; number 0 = no particle of a sheet */
    vec3     move_to; quat turn_to;     /* kinematic: where it is on its way to        */
    char     message_kind[32];  /*        of the last message, but for collisions, which so many are told of */
    vec3     hit_v, hit_w;      /* m/s, rad/s change by hits since the last step, for reports */
    Breach   breach;            /* step/watch.c; no part of the state                  */
} BodyRest;

/* What solids that are alike share, copies of the world too: never changed. */
typedef struct Form {
    Share    share;
    Shape    shape;
    pose     at;                /* in the body frame (origin), or in the world         */
    vec3     arm;               /* m   the shape's origin from the centre of mass, in the body frame */
    Surface  surface;
    vec3     colour;
} Form;

typedef struct Solid {          /* one shape in a body, or of the world itself (body == NONE) */
    bool     alive;
    bool     asks;              /* in world->asking: its box wants to be compared with the tree */
    uint8_t  wall;              /* 1..6 for the room's, else 0                         */
    uint32_t body, next;
    uint32_t pair_first;        /* list through Pair.next, as 2 * pair + side          */
    int32_t  leaf;              /* in world->tree; < 0: unbounded (planes) or no collisions */
    const Form *form;
    box3     reach;             /* m   where it may get in this step                   */
    real     blow;              /* m   of that, what a blow could add                  */
    real     struck;            /* m   the same of a mover's blow, for which its leaf has room */
    real     astray;            /* m   how much farther than foreseen it got in the tries of this step, not kept between steps */
} Solid;

/* ---- contacts ---- */

typedef struct PointMemory {    /* what a contact point remembers between steps        */
    real     normal;            /* N   force, for warm starting                        */
    vec3     tangent;           /* N   friction, world axes                            */
    int      held;              /* substeps since it carried force, counted down to 0  */
    float    borne;             /* N   of the normal force, what soft rows carry without overlap; crowd/book.c */
} PointMemory;

typedef struct ContactPoint { ManifoldPoint at; PointMemory memory; } ContactPoint;
typedef struct MorePoints { ContactPoint point[MANIFOLD_POINTS - 1]; } MorePoints;

typedef struct Contact {        /* one manifold of a pair; a convex pair has at most one */
    uint32_t next;              /* of the same pair                                    */
    uint32_t piece;
    uint32_t more;              /* in world->more: room for the points after the first; NONE until there were some */
    bool     idle : 1;          /* no point, and no force in the last step: nothing to gather, mostly nothing to write back */
    bool     rests : 1;         /* in world->contact_rest there is something of it     */
    bool     grips : 1;         /* movers have closed on what it presses, by this one among others */
    bool     touching, sliding;
    uint8_t  count;             /* points at the end of the last step; see contact_point */
    vec3     normal;            /* 1   unit, from a to b                               */
    ContactPoint first;
    vec3     force;             /* N on b, mean over the last step                     */
    vec3     point;             /* m   where                                           */
} Contact;

/* What few contacts have: as BodyRest, by their slots. */
typedef struct ContactRest {
    vec3     rolling;           /* N m                                                 */
    real     lost;              /* J   in the last step in which one of its bodies was awake; no part of the state. A crowd tells
                                 *     it only where an effect asks for it (EffectType.losses) */
} ContactRest;

typedef struct Rub { real friction, friction_dynamic, rolling, restitution; } Rub;      /* what two surfaces make of each other */

typedef struct PairMemory {     /* what is kept of a pair while there is a hint where to look for its contact */
    ManifoldCache cache;
    Rub      rub;
} PairMemory;

typedef struct Pair {           /* two solids whose fat boxes overlap: mostly that is all there is of them, so it is small */
    bool     alive : 1;
    bool     listed : 1;        /* in world->near                                      */
    bool     pieces : 1;        /* with a mesh or height field: it has a list of contacts, else one at most */
    bool     round : 1;         /* with a sphere: no contact of it has more than one point */
    bool     dynamic_a : 1, dynamic_b : 1;      /* the kinds of its bodies: to look at these for it would be a miss each */
    bool     smooth : 1, bounces : 1;           /* has no friction; has some restitution */
    bool     touching, fresh;   /* fresh: the stored manifold is not that of the present poses */
    bool     met;               /* did the reaches of its solids overlap? So it is ...    */
    float    met_until;         /* m   ... while its bodies have less roam than this. 0: not known; no part of the state */
    uint32_t solid_a, solid_b, body_a, body_b;     /* body NONE: the world; solid_a < solid_b */
    uint32_t next[2], prev[2];  /* lists of the two solids, as 2 * pair + side         */
    uint32_t contact;           /* first of its contacts; NONE: two convex solids with nothing to remember */
    uint32_t memory;            /* in world->memories; NONE: no hint                      */
    real     until;             /* m   travel of both bodies up to which a crowd need not look at them anew (crowd/touch.c); < 0: it must */
} Pair;

typedef struct Touch {          /* two bodies that touch by at least one pair          */
    bool     alive;
    uint32_t body_a, body_b;    /* a < b by slot; b may be NONE (room wall)            */
    uint32_t link;              /* in the graph; NONE for walls                        */
    int      pairs;             /* touching pairs of solids                            */
    uint8_t  wall;
    bool     brief, bounced;    /* over: in w->brief; bounced: its link lives one step  */
    real     began;
    real     speed, impulse;    /* of the impact that began it                         */
} Touch;

/* ---- joints ---- */

/* ---- regions ---- */

typedef struct Region {
    uint32_t gen;
    bool     alive;
    Shape    shape;
    pose     at;
    dig_region_def laws;        /* its shape pointers are not used */
} Region;

struct JointType;

typedef struct JointRec {       /* what every step reads comes first                   */
    uint32_t gen;
    bool     alive, collides;
    bool     at_limit;
    bool     at_point;          /* holds one point of both                             */
    bool     plain;             /* and nothing else of it acts: its parameters are far, and most steps ask for no more of them */
    uint32_t a, b;              /* body slots; NONE = the world                        */
    uint32_t next_a, next_b;    /* lists of the bodies' joints                         */
    uint32_t other[2];          /* joint slots, for gear and rack                      */
    uint32_t link;
    const struct JointType *type;
    vec3     ra, rb;            /* m   anchors from the centre of mass, body axes      */
    quat     fa, fb;            /*     joint frames in body axes: x axis = the joint's */
    real     breaks_at;         /* N                                                   */
    real     memory[4];         /* JOINT_MEMORY                                        */
    real     impulse[12];       /* JOINT_SLOTS  N or N m, force of the last substep    */
    vec3     force, torque;     /* on a, mean over the last step                       */
    real     lost;              /* J   to friction, dampers and yielding in the last step in which one of its bodies was awake; no part of
                                 *     the state */
    real     error;
    real     params[48];        /* the type's struct                                   */
    char     name[64];
} JointRec;

/* ---- outside acts ---- */

typedef struct Push {
    uint32_t body;
    vec3     force, torque;     /* N, N m                                              */
    vec3     at;                /* m   from the centre, body axes                      */
    bool     has_at;
    bool     law;               /* of a region: its work is the law's, no push by hand */
    real     from, until;       /* s                                                   */
} Push;

typedef struct Material { char name[64]; dig_material_def def; } Material;
typedef struct MaterialPair { int a, b; real friction, friction_dynamic, rolling, restitution; } MaterialPair;

typedef struct Ledger {         /* J since the start                                   */
    real work_in, law, lost, initial, last_total;
    bool started;
} Ledger;

/* Counted as they come and go: whoever asks for dig_stats in every step is not to pay for all that sleeps. */
typedef struct Tally {
    int    touching;            /* touches that last: of a touching pair               */
    int    smooth;              /* pairs without friction                              */
    size_t shapes;              /* bytes of the solids' shapes                         */
} Tally;

/* What first called for an effect; what it was not is null. */
typedef struct EffectCause { dig_body body; dig_joint joint; dig_region region; } EffectCause;

/* An effect added by the caller (api/own.c), shared by a world and its snapshots. */
typedef struct EffectOwner {
    int    users;
    bool   all;                 /* every body that moves takes part, not those of the column */
    size_t bytes;
    void (*end)(struct EffectOwner *o);         /* after the last user */
} EffectOwner;

struct EffectType;
typedef struct EffectSlot {     /* one per entry of the effect list                    */
    const struct EffectType *type;
    const char *name;           /* its type's                                          */
    bool     on, forced;        /* forced: set by hand                                 */
    int      bodies;            /* in the last step                                    */
    real     us, flow_us;       /* us in the last timed step, all and of that on the world as a whole */
    real     us_sum; uint64_t us_count;         /* us of all timed steps, and how many these are */
    uint64_t calls;             /* of its functions since the start: run and flow      */
    void    *world;             /* its options (EffectType.world_params); NULL = not called for */
    size_t   world_size;        /* bytes of these                                      */
    Column   members;           /* of the bodies that take part (EffectType.body_params) */
    void    *plan;              /* what its reserve took for its flow, in w->scratch; of this step only */
    EffectCause cause; bool caused;             /* what in the first group that called for it did; none has yet */
    EffectOwner *owner;         /* NULL: one of the list */
    char     why[96];           /* what called for it, as the caller said it; "" = it did not  */
} EffectSlot;

/* When an effect takes part in a substep; SETTLE comes once, at the end of the step. */
typedef enum Stage { STAGE_FORCE, STAGE_ROWS, STAGE_SETTLE, STAGE_COUNT } Stage;

/* One bit for each of a world's effects; those of a group are asked by them. Found anew (effect/effects.c) before a step after which one of
 * the effects may have changed: `old`. */
typedef struct EffectBits {
    uint32_t called;            /* on, and not only for bodies that there are none of, or options that nobody set */
    uint32_t own, turns, varies;                /* of these: of the caller; turn spheres; vary over a step */
    uint32_t flow;              /* of these: act on the world as a whole, and something takes part */
    uint32_t stage[STAGE_COUNT];                /* of these: have a part in it */
    bool     losses;            /* one of these asks for what contacts lose */
    bool     old;
} EffectBits;

#define MAX_EFFECTS 32
#define WORLD_FAR  1e15         /* m            no body gets farther from the origin */
#define WORLD_FAST 1e12         /* m/s, rad/s   or faster                            */
#define TRAVEL_MOST 1e60        /* m            of bodies without a size (planes that are turned) */
#define WORLD_STRONG 1e35       /* N, N m       nor is it pushed harder              */
#define WORLD_LONG 1e15         /* s            and no journey takes longer          */
#define MOVE_SLACK 1e-6         /* frame steps  that a journey may be off a whole number of them and still takes that: rounding */
size_t effect_bytes(const EffectSlot *e);

struct dig_world {
    dig_world_def def;
    int      accuracy;                  /* see solve/plan.h                            */
    bool     timed_always;              /* the clock is read in every step, not only in each 16th */
    unsigned width;                     /* of instructions, as crowd/system.h names them; 0 = the widest this machine has. Tests ask for others */
    bool     tells_moves;               /* somebody asked for the events `moved`       */
    uint64_t steps, serial;             /* serial: distinguishes worlds' handles       */
    uint64_t rng;
    bool     busy;
    Debt     debt;
    uint32_t gen_start;
    bool     dig_accuracies;            /* some DIG has an accuracy of its own         */

    LIST(Body)     bodies;
    LIST(BodyRest) rest;                /* of bodies: as many, or more                 */
    LIST(Drift)    drifts;              /* the same, of those that are crowded: where nothing may sleep it takes no memory */
    LIST(Solid)    solids;
    LIST(Pair)     pairs;
    LIST(PairMemory) memories;          /* of pairs                                    */
    LIST(Contact)  contacts;
    LIST(ContactRest) contact_rest;     /* as many, or more                            */
    LIST(MorePoints) more;              /* of contacts                                 */
    LIST(Touch)    touches;
    LIST(JointRec) joints;
    LIST(Push)     pushes;
    LIST(Region)   regions; int region_count;
    LIST(uint32_t) free_bodies, free_solids, free_pairs, free_memories, free_contacts, free_more, free_touches, free_joints, free_regions;
    LIST(uint32_t) unbounded;           /* solids that are planes                      */
    LIST(uint32_t) awake;               /* bodies to be advanced, ascending            */
    int      movers;                    /* of them, kinematic ones; of this step       */
    LIST(uint32_t) near;                /* pairs of listed bodies, and some that were; nearly ascending */
    LIST(uint32_t) asking;              /* solids that are new or were moved by hand   */
    LIST(uint32_t) brief;               /* touches whose link lives one step           */
    LIST(uint32_t) parent;              /* union-find over body slots, NONE between steps */
    LIST(Material) materials;
    LIST(MaterialPair) material_pairs;
    uint64_t paired;                    /* bits of materials that have a row there, by their numbers modulo 64 */
    LIST(dig_event) events;             /* of the last step                            */
    LIST(dig_event) pending;            /* of calls since then                         */
    int      events_most;               /* for so many, steps of late have made room   */
    int      events_written;            /* of the list's room, so many may take memory */

    Index    pair_index;                /* by (solid, solid, 0)                        */
    Index    touch_index;               /* by (body, body, wall)                       */
    Tree     tree;
    Graph   *graph;                     /* the mechanical layer                        */
    Layer    layers[DIG_LAYERS];        /* the others; [0] is not used                 */
    MessageLog messages;                /* that were delivered                         */
    Mail     mail;                      /* that are on their way                       */
    EffectSlot effects[MAX_EFFECTS]; int effect_count;
    EffectBits bits;
    uint32_t flowing, met;              /* bits of effects on the world as a whole; of those ever called for, or maybe */
    unsigned char *note; size_t note_size;      /* of the program around it, for its file */
    dig_room_def room; bool has_room; uint32_t room_solid[6];

    Ledger   ledger;
    Tally    tally;
    dig_stats stats;
    dig_warning warnings[DIG_WARNINGS]; int warning_count;
    Arena    scratch;                   /* of the calling thread, for a step           */
    Arena    group_scratch;             /* the same, while one group is advanced       */
    dig_body culprit;                   /* whose numbers made the last step fail; null: nobody's */
    dig_body poisoned;                  /* dig_world_inject: in the next step its velocity is NaN */
    Recent   inertias, makes, forms;    /* that were made last */
    struct Workers *workers;            /* step/workers.h; NULL for one thread         */
    struct Tap *tap;                    /* api/command.h: who listens to what is done to it; NULL = nobody */
    struct Playback *playback;          /* there: what plays commands in it; NULL = nothing did */
    uint64_t allocations;
    uint64_t work;                      /* units so far, never taken back: work.c      */
    char     error[512];
};

typedef struct dig_world World;

/* Writes one sentence into the world's error buffer and returns `status`. */
dig_status world_fail(const World *w, dig_status status, const char *format, ...) DIG_PRINTF(3, 4);

/* work.c: books units of work (digbox.h, dig_world_work). A question may, of a const world. */
void world_work(const World *w, uint64_t units);
void world_work_through(const World *w, uint64_t each);         /* of what looks at all that the world holds */
void world_work_shape(const World *w, const Shape *s, const void *def);     /* of a shape made from that */

static inline Body *world_body(const World *w, dig_body b)
{
    if (b.slot >= (uint32_t)w->bodies.count || !w->bodies.data[b.slot].alive || w->bodies.data[b.slot].gen != b.gen)
        return NULL;
    return &w->bodies.data[b.slot];
}
static inline JointRec *world_joint(const World *w, dig_joint j)
{
    if (j.slot >= (uint32_t)w->joints.count || !w->joints.data[j.slot].alive || w->joints.data[j.slot].gen != j.gen)
        return NULL;
    return &w->joints.data[j.slot];
}
static inline dig_body body_handle(const World *w, uint32_t slot)
{
    return slot == NONE ? (dig_body){0, 0} : (dig_body){slot, w->bodies.data[slot].gen};
}
static inline dig_joint joint_handle(const World *w, uint32_t slot)
{
    return slot == NONE ? (dig_joint){0, 0} : (dig_joint){slot, w->joints.data[slot].gen};
}
static inline Region *world_region(const World *w, dig_region r)
{
    if (r.slot >= (uint32_t)w->regions.count || !w->regions.data[r.slot].alive || w->regions.data[r.slot].gen != r.gen)
        return NULL;
    return &w->regions.data[r.slot];
}
extern const BodyRest no_rest;      /* of a body that has none: all of it is 0 */
static inline const BodyRest *body_rest(const World *w, const Body *b) { return b->rests ? &w->rest.data[b - w->bodies.data] : &no_rest; }
BodyRest  *body_rest_own(World *w, Body *b);            /* to be written to */
#define MESSAGE_BLOW "collision"
static inline const char *body_message_kind(const World *w, const Body *b) { return b->told_blow ? MESSAGE_BLOW : body_rest(w, b)->message_kind; }
static inline const char *body_name(const World *w, const Body *b) { return body_rest(w, b)->name; }
/* NONE, the world itself, is not. */
static inline bool body_dynamic(const World *w, uint32_t slot) { return slot != NONE && w->bodies.data[slot].kind == DIG_DYNAMIC; }
static inline real world_time(const World *w) { return (real)w->steps * w->def.step; }

/* Pose of the body's origin. */
static inline pose body_pose(const Body *b)
{
    return (pose){vec3_is_zero(b->centre) ? b->x : vec3_sub(b->x, quat_rotate(b->q, b->centre)), b->q};
}
/* A shape in the frame of its body, in that body's pose: mostly the body is the shape. */
static inline pose pose_of_part(pose body, pose at)
{
    return (pose){vec3_is_zero(at.p) ? body.p : pose_point(body, at.p), at.q.w == 1 ? body.q : quat_mul(body.q, at.q)};
}
static inline pose solid_pose(const World *w, const Solid *s)
{
    return s->body == NONE ? s->form->at : pose_of_part(body_pose(&w->bodies.data[s->body]), s->form->at);
}
static inline Drift *body_drift(World *w, const Body *b) { return &w->drifts.data[b - w->bodies.data]; }      /* if it is crowded */
extern const Make no_make;
static inline const Make *body_make(const Body *b) { return b->make ? b->make : &no_make; }
extern const Inertia no_inertia;
static inline const Inertia *body_inertia(const Body *b) { return b->inertia ? b->inertia : &no_inertia; }
static inline mat3 body_inertia_world(const Body *b)
{
    mat3 r = quat_matrix(b->q);
    return mat3_mul(mat3_mul(r, body_inertia(b)->of), mat3_transpose(r));
}

/* m  So far at most moves a point at a distance r when the centre moves and q changes: as the centre, and 2 r |change of q|. */
static inline real travel_by(vec3 move, quat from, quat to, real r)
{
    quat d = {to.x - from.x, to.y - from.y, to.z - from.z, to.w - from.w};
    real turn2 = d.x * d.x + d.y * d.y + d.z * d.z + d.w * d.w;
    return vec3_length(move) + (turn2 > 0 ? 2 * r * sqrt(turn2) : 0);
}

/* It is about to be at x, q. */
static inline void body_travels(Body *b, vec3 x, quat q)
{
    b->travel = real_min(TRAVEL_MOST, b->travel + travel_by(vec3_sub(x, b->x), b->q, q, b->outer));
}

/* 1  Where time goes r times as fast, motion is r times as fast, under the same forces and with the same energy: against the
 * forces of the world's time, mass and inertia are 1/r^2 of what they are. (Weight is not: it is a force.) */
bool       body_turns(const Body *b);                   /* does it have no more inertia than its shapes can? */
static inline real body_inertness(const Body *b) { return 1 / (b->rate * b->rate); }

/* Takes a free slot of a list or adds one. */
dig_status slot_take(World *w, void **data, int *count, int *capacity, size_t item, void *free_list, uint32_t *slot);
#define world_slot(w, list, free_list, slot) \
    slot_take((w), (void **)&(list)->data, &(list)->count, &(list)->capacity, sizeof *(list)->data, (free_list), (slot))
void slot_give(World *w, void *free_list, uint32_t slot);
/* The generation of the next handle. DIG_E_MEMORY: there is none left, with its sentence. */
dig_status world_generation(World *w, const char *what, uint32_t *gen);

/* world.c */
dig_status world_open(const dig_world_def *def, World **out, char *why, size_t capacity);
void       world_close(World *w);
size_t     world_bytes(const World *w);
uint64_t   world_hash(const World *w);
Tally      world_tally(const World *w);                 /* counted anew */

/* body.c */
dig_status bodies_rest(World *w);               /* room for it, for all bodies there are */
void       body_rest_set(World *w, Body *b, const BodyRest *rest);
dig_status body_create(World *w, const dig_body_def *def, dig_body *out);
/* For messages: "body 'crate'", or "body #12" where it has no name; of one that is being made, and has no number yet, "body". */
enum { BODY_TEXT_SIZE = 80 };
const char *body_text(const World *w, const Body *b, char text[BODY_TEXT_SIZE]);
const char *new_body_text(const char *name, char text[BODY_TEXT_SIZE]);
const char *wall_name(int wall);                /* as dig_wall_name */
/* Its body, or the wall of the room that it is. */
const char *solid_text(const World *w, const Solid *s, char text[BODY_TEXT_SIZE]);
#define BODY_TEXT(w, b)     body_text((w), (b), (char[BODY_TEXT_SIZE]){0})
#define NEW_BODY_TEXT(name) new_body_text((name), (char[BODY_TEXT_SIZE]){0})
void       body_remove(World *w, uint32_t slot);
void       body_disable(World *w, uint32_t slot);       /* it stands where it is, and nothing meets it any more; cannot fail */
void       body_wake(World *w, uint32_t slot);          /* its whole DIG */
void       world_wake_all(World *w);
void       body_list(World *w, uint32_t slot);          /* into world->awake; there is always room */
void       touches_wake(World *w, uint32_t slot);       /* all that touches the body or is joined to it */
dig_status body_set_mass(World *w, Body *b, real mass);
dig_status body_inertia_set(World *w, Body *b, mat3 inertia);           /* DIG_E_MEMORY: as it was, without a word */
void       body_shares_keep(Body *b);              /* it is a copy of another that stays */
void       body_shares_drop(Body *b);              /* it has neither inertia nor make from now on */
dig_status body_make_set(World *w, Body *b, const Make *like);          /* DIG_E_MEMORY: as it was, with its sentence */
/* kg  As it is read: of one that is not dynamic what was given, or infinite. */
static inline real body_mass_read(const Body *b) { return b->kind == DIG_DYNAMIC ? b->mass : b->told_mass > 0 ? b->told_mass : INFINITY; }
void       body_refit(World *w, uint32_t slot);         /* its solids' boxes in the tree */
void       body_measure(const World *w, Body *b);      /* its radii, from where its solids are */
const Form *form_take(World *w, const Form *now, const Form *like);     /* one that is like this, to be dropped; NULL: no memory */
void       form_drop(const Form *f);                /* NULL is none */
dig_status solid_form(World *w, Solid *s, const Form *like);            /* it is like that now */
bool       bodies_may_touch(const World *w, const Solid *a, const Solid *b);
real       body_energy(const World *w, const Body *b);  /* J, kinetic + potential */
dig_status solid_add(World *w, uint32_t body, const Shape *shape, pose at, const Surface *surface, vec3 colour, uint32_t *slot);
void       solid_remove(World *w, uint32_t slot);
static inline void pair_stir(Pair *p) { p->fresh = true; p->met_until = 0; }      /* one of its solids is elsewhere, or another */
void       solid_ask(World *w, uint32_t slot);            /* its box is to be compared with all others at the next step, or in this one */
Surface    surface_resolve(const World *w, const Surface *s);           /* no NaN left */
Rub        surface_pair(const World *w, const Surface *a, const Surface *b);

/* Point k of a contact, less than its count; or, where it has room, than MANIFOLD_POINTS. */
static inline ContactPoint *contact_point(World *w, Contact *c, int k) { return k == 0 ? &c->first : &w->more.data[c->more].point[k - 1]; }
static inline const ContactPoint *contact_point_seen(const World *w, const Contact *c, int k)
{
    return k == 0 ? &c->first : &w->more.data[c->more].point[k - 1];
}

/* Asks for the contacts of pairs that are soon read, and nearer for their further points: between steps they are seldom in a cache. */
static inline void contacts_fetch(const World *w, const Pair *p, const Pair *end)
{
    if (end - p > 2 * FETCH_AHEAD && p[2 * FETCH_AHEAD].alive && p[2 * FETCH_AHEAD].contact != NONE)
        fetch_soon(&w->contacts.data[p[2 * FETCH_AHEAD].contact], sizeof(Contact));
    if (end - p <= FETCH_AHEAD || !p[FETCH_AHEAD].alive || p[FETCH_AHEAD].contact == NONE)
        return;
    const Contact *c = &w->contacts.data[p[FETCH_AHEAD].contact];
    if (c->count > 1 && c->more != NONE)
        fetch_soon(&w->more.data[c->more], (size_t)(c->count - 1) * sizeof(ContactPoint));
}

/* pair.c */
dig_status contact_take(World *w, uint32_t *slot);      /* without a point, next or room for more than one */
dig_status contacts_rest(World *w);                     /* room for it, for as many contacts as there is */
/* What is so already is not written to. */
static inline ContactRest contact_rest(const World *w, uint32_t slot)
{
    return w->contacts.data[slot].rests ? w->contact_rest.data[slot] : (ContactRest){.lost = 0};
}

static inline void contact_rest_set(World *w, uint32_t slot, ContactRest rest)
{
    static const ContactRest none;      /* -0 is another number: the checksum knows it */
    Contact *c = &w->contacts.data[slot];
    c->rests = memcmp(&rest, &none, sizeof none) != 0;
    if (c->rests)
        w->contact_rest.data[slot] = rest;
}
dig_status contact_widen(World *w, Contact *c);         /* room for all points; DIG_E_MEMORY: unchanged */
void       contact_give(World *w, uint32_t slot);
dig_status pair_remember(World *w, Pair *p);
void       pair_forget(World *w, Pair *p);
Rub        pair_rub(const World *w, const Pair *p);
void       pair_sort(const World *w, Pair *p);           /* what its solids make it: pieces, round, whose ends are dynamic, how they rub */
dig_status pair_add(World *w, uint32_t solid_a, uint32_t solid_b);     /* that are none yet */
Pair       pair_new(const World *w, uint32_t solid_a, uint32_t solid_b);            /* one to be added: changes nothing yet */
dig_status pair_add_made(World *w, const Pair *made);
bool       pair_find(const World *w, uint32_t solid_a, uint32_t solid_b, uint32_t *pair);         /* in any order */
dig_status pair_enter(World *w, uint32_t pair);         /* into the index; it is not there yet */
void       pair_attach(World *w, uint32_t pair);        /* into the lists of its solids */
void       pair_remove(World *w, uint32_t pair);
void       pair_let_go(World *w, uint32_t pair);        /* as if its solids had just come near each other */
/* The one pair of two bodies that have one shape each, NONE when there is none. false: they have more, look through their lists. */
bool       pair_between(const World *w, uint32_t body_a, uint32_t body_b, uint32_t *pair);
static inline uint32_t pair_side(const Pair *p, uint32_t solid) { return p->solid_a == solid ? 0 : 1; }
void       pairs_of_solid_remove(World *w, uint32_t solid);
void       pairs_refresh_surfaces(World *w, uint32_t body);
void       all_pairs_refresh_surfaces(World *w);
dig_status touch_find_or_add(World *w, uint32_t a, uint32_t b, uint8_t wall, uint32_t *slot);
dig_status touch_enter(World *w, uint32_t touch);       /* into the index; it is not there yet */
void       touch_remove(World *w, uint32_t slot);
void       touch_count(World *w, Touch *t, int more);   /* so many more of its pairs touch */
Touch     *touch_find(const World *w, uint32_t a, uint32_t b, uint8_t wall);

/* joint.c */
void       joint_remove(World *w, uint32_t slot);
void       joint_stir_pairs(World *w, const JointRec *j);   /* those of its bodies that it forbids, or has forbidden, go or come at the next step */
bool       joint_forbids_contact(const World *w, const Solid *a, const Solid *b);       /* of two bodies */
bool       joint_asks_contact(const World *w, uint32_t a, uint32_t b);         /* is there one across which they still touch? */

/* event.c */
dig_event *event_post(World *w, dig_event_kind kind, uint32_t a, uint32_t b);       /* NULL when there is no memory */
dig_event *event_note(World *w, dig_event_kind kind, uint32_t a, uint32_t b);       /* with the bodies' slots only: to ask for handles would be a miss */
void       event_write(const World *w, dig_event *e, dig_event_kind kind, uint32_t a, uint32_t b);      /* the same in a place that is there */
void       event_name(const World *w, dig_event *e);                                /* gives one that was noted its handles */
dig_event *events_claim(World *w, int count);       /* room for so many in a row, not yet written; NULL when there is no memory */
void       post_graph_changes(World *w, uint32_t layer);                /* of the last batch of a layer's graph */

/* material.c */
dig_status materials_open(World *w);
void       material_pairs_look(World *w);               /* World.paired, after the table has changed */
int        material_find(const World *w, const char *name);             /* < 0 = none */

/* compact.c: between steps. DIG_E_MEMORY: nothing moved, or what moved is in its new place */
dig_status world_compact(World *w);

/* check.c */
dig_status world_check(const World *w);

#endif
