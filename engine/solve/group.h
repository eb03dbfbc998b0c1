/* solve/group.h - a group: the DIGs that may meet in this step, gathered for advancing.
 *
 * The world's records stay as they are while a group is advanced; everything
 * here is a copy in the step's scratch memory. group_commit writes it back and
 * cannot fail. Bodies are addressed by local index.
 *
 * Floor: solve. Includes base, math, geom, world.
 */
#ifndef DIG_GROUP_H
#define DIG_GROUP_H

/* A contact that carried force less than so many substeps ago is the same contact: it closes without bouncing. */
#define HELD_SUBSTEPS 4

#include "base/arena.h"
#include "base/team.h"
#include "solve/joint_type.h"
#include "solve/plan.h"
#include "world/world.h"

/* Laws that the ways obey by themselves, from the group's pairs, joints and pushes, as far as an effect stands for them: one that is
 * switched off, or not in the list, is no law of this world. */
typedef enum Law { LAW_NONE, LAW_CONTACT, LAW_FRICTION, LAW_ROLLING, LAW_JOINTS, LAW_PUSH } Law;

/* Small structs in compact arrays: what is read together lies together. */
typedef struct Pos  { vec3 x; quat q; } Pos;                    /* m, 1  centre of mass                     */
typedef struct Vel  { vec3 v, w; } Vel;                         /* m/s, rad/s                               */
typedef struct Mass { real im; mat3 ii; } Mass;                 /* 1/kg, 1/(kg m^2) world axes, now         */

/* All that moves in a group: how far it reaches, and no more than that do gravity, pushes and springs do to it. What a motor without a bound is measured by. */
typedef struct Bulk { bool found; real mass, size, load; } Bulk;     /* kg, m from its middle, N */

typedef struct Member {         /* the rest of a gathered body */
    uint32_t slot;              /* in world->bodies; NONE = the world itself           */
    bool     moves;             /* dynamic and awake in this try: impulses move it     */
    bool     moved;             /* was not at rest before the step                     */
    bool     dormant;           /* dynamic but asleep: wakes when something pushes it  */
    bool     pushed;            /* dormant and pushed in this try: its DIG must wake   */
    bool     kinematic;
    bool     round;             /* isotropic inertia                                   */
    bool     constrained;       /* a row acts on it in this substep                    */
    bool     implicit_move;     /* move with the end velocity, not the mean            */
    bool     met;               /* something that came at it was stopped at the start of this substep */
    bool     collided;          /* struck in this step                                 */
    bool     been;              /* what Group.been says of it holds; else where it went is plain */
    bool     fresh;             /* no history: new, teleported or struck in the last step */
    uint8_t  covered;           /* faces of its box, Covered                           */
    int      integrator;        /* dig_integrator; all but DIG_AUTO are the sweep's alone */
    real     pull;              /* m/s^2  gravity and pushes do no more to any point of it */
    real     outer, rim, travel;    /* m                                               */
    real     mass, gravity_scale;
    real     im;                /* 1/kg  0: it does not move                           */
    const mat3 *inertia, *inv_inertia;  /* body axes; the world's, but where time goes at another rate */
    vec3     force, torque;     /* N, N m, of this substep; once it was watched, N m s: change of the angular momentum in the step, if not round */
    real     push_work;         /* J   of those by hand, in the step                   */
    vec3     swerve;            /* rad/s  change of its spin in the substep by its own turning: in velocities from predict() to move();
                                 *     of a crowd, rad: its turn in this piece of the step */
} Member;

/* m/s, m  By so much springs and motors may throw a member within the step; where something is near. */
typedef struct Throw { real rate, far; } Throw;

typedef struct Been {           /* of a member, within this step: at blows, at the ends of a swing */
    box3     places;            /* m   where its centre of mass was                    */
    real     swung;             /* rad  so far it may have turned there, to and fro    */
} Been;

typedef struct Apart {          /* of a member's forces in this substep, what is booked apart */
    vec3     drag, drag_torque; /* N, N m  what takes energy away for good             */
    vec3     law, law_torque;   /* N, N m  what laws of regions and of scripts add, but for drags */
    real     driven;            /* W   what moves the medium puts in by them           */
} Apart;

/* One direction of one contact point: Jacobian and effective mass. */
typedef struct Dir {
    vec3 n;                     /* linear, on b (+) and a (-)       */
    vec3 aa, ab;                /* m  angular, on a and on b        */
    vec3 ia, ib;                /*    I^-1 aa, I^-1 ab              */
    real k;                     /* 1/kg                             */
} Dir;

typedef struct PointRow {       /* a contact point in the solve     */
    int  contact, point;        /* of the group's contacts          */
    int  a, b;
    Dir  n, t[2];
    real ktt;                   /* 1/kg coupling of the tangents    */
    real kmax;                  /* 1/kg largest tangential eigenvalue */
    real target;                /* m/s  normal velocity wanted at least */
    real bounce;                /* restitution where blows are not located in time, else 0 */
    real rate_before;           /* m/s  normal velocity at the start of the substep */
    real friction, friction_dynamic;        /* filled by effect/friction.c; 0 = no tangential work */
    bool slides;                /* dynamic friction holds           */
    bool curved;                /* the normal turns: the row is that of the middle of the substep, for the mean velocity, or of two parts
                                 * of one thing for that at the end */
    real jn, jt[2];             /* N s                              */
    real blow;                  /* N s  of the normal impulse, what a bounce gave: the solve does not take it back */
    real gap, healed;           /* m    before and after it was put right in place; equal if it was not */
} PointRow;

typedef struct RollRow {        /* rolling resistance of one contact: three angular directions */
    int  contact, first, count; /* its point rows                   */
    int  a, b;
    real lever;                 /* m    |torque| <= lever * normal force */
    real reach;                 /* m    size, to compare spin with speed */
    mat3 inv_k;                 /* kg m^2                            */
    vec3 j;                     /* N m s                             */
} RollRow;

typedef struct JointBlock {     /* the rows of one joint, hard ones first */
    int  joint;                 /* of the group's joints            */
    int  first, hard, count;    /* rows                             */
    real l[6 * 6];              /* LDL^T factor of the hard block   */
} JointBlock;

typedef struct JointRow {
    Row  row;
    vec3 im[ROW_BODIES], ii[ROW_BODIES];    /* M^-1 J^T             */
    real k;                     /* J M^-1 J^T                       */
    real gamma, bias;           /* soft: rate + bias + gamma p = 0  */
    real p, lo, hi;             /* N s or N m s; its bounds         */
} JointRow;

/* A manifold with as many points as its shapes can have. */
typedef struct GroupManifold {
    vec3     normal;
    ManifoldPoint *points;      /* in the group's places; NULL: there was none, and there is no room yet (group_points) */
    int      count;
    uint8_t  room;              /* points and memories there can be */
    uint8_t  left;              /* bit per point without a row in this substep: where it closes, that is located as an impact */
    bool     wide;              /* the world's has room for more than one, too */
    bool     slides;
} GroupManifold;

#define WEIGHT_LEAST 1e-300     /* N s  1 over less is no number */

typedef struct GroupContact {
    int      pair;              /* of the group's pairs             */
    int      a, b;              /* local bodies                     */
    uint32_t slot;              /* world contact; NONE = spare      */
    uint32_t piece;
    bool     live;              /* has points                       */
    bool     touching;          /* at the end of the step, by group_judge */
    bool     idle, was_idle : 1;        /* no point, and no force: until group_judge in the world's record, then now; then */
    bool     grips : 1;         /* movers have closed on what it presses: see grip.c */
    GroupManifold manifold;
} GroupContact;

/* What acted in a contact, over the whole step. */
typedef struct Acted {
    vec3     impulse;           /* N s on b                         */
    real     last;              /* s   into the step, when force last acted */
    vec3     point_sum; real point_weight;      /* where, weighted by impulse; up to WEIGHT_LEAST: nowhere */
} Acted;

#define ACTED_BLOCK 8           /* as half a batch of a crowd */

/* Of its points, which they come after: [room]. */
static inline PointMemory *contact_memory(const GroupContact *c) { return (PointMemory *)(void *)(c->manifold.points + c->manifold.room); }

/* Of a contact with something that nothing moves, while something else of that kind presses from the other side: see squeeze.c. */
typedef struct Squeeze {
    real rate;                  /* m/s  it gives way by             */
    real depth;                 /* m    so deep it may stay         */
    int      next;              /* of the contacts by which the same body is pressed, < 0: none */
    bool     grips;             /* movers that have closed on it still leave it no room */
} Squeeze;

/* What movers hold by friction goes as they do, and is one of them for the step: see grip.c. */
typedef struct Carried {
    int      body;
    int      first, count;      /* its contacts in Group.jaws       */
    Vel      before;            /* m/s, rad/s  its velocity, before         */
    vec3     heals;             /* m    by which it is moved at the end: equally deep in each */
    vec3     from, force, torque;       /* m, N, N m  its place, and what acts on it, at the start */
    real     kinetic, time;     /* J, s  then; how long it is held   */
    Apart    apart;             /*      of that force, what is booked apart */
} Carried;

typedef struct GroupPair {
    uint32_t slot;              /* world pair                       */
    uint32_t memory;            /* the world's; NONE: it has none   */
    int      a, b;              /* local bodies                     */
    int      contact, contacts; /* range of the group's contacts    */
    int      impact;            /* its entry of Group.impacts + 1; 0 = none */
    bool     struck : 1;        /* an impact happened in this step  */
    bool     meets : 1;         /* in this substep, whatever it looks like at its start */
    bool     fresh : 1;         /* the manifold must be made anew  */
    bool     was_touching : 1;  /* at the end of the last step     */
    bool     touching : 1;      /* of this one, by group_judge     */
    bool     both_moved : 1;    /* neither was at rest before      */
    bool     seamed : 1;        /* something is beside its fixed one: see Group.seams */
    bool     hidden : 1;        /* where the two are nearest a fixed neighbour covers it: there may be a place farther off that nobody watches */
    uint8_t  presses;           /* bits: at which points it presses as it did before, in this substep */
    Covered  covered;           /* faces that joints hold to the next piece of the same thing */
    const Rub *rub;             /* of its two surfaces, in the step's memory; many pairs may have one, see group_own_rubs */
    const Form *on_a, *on_b;    /* of its solids, with their shapes */
    real     speed;             /* m/s  fastest approach seen by the rows; once struck, of its impacts */
    real     size;              /* m   of the smaller solid: scale of tolerances */
    real     reach;             /* m   so far ahead its contact looks  */
    real     until;             /* m   see Pair; < 0 but in a crowd    */
    ManifoldCache *hint;        /* in the group's places; NULL: a ball, which needs none */
} GroupPair;

typedef struct Impact {         /* what happened to a pair that was struck in this step */
    real     time, impulse;     /* s, N s                           */
    int      first, last;       /* its entries of strikes + 1; 0 = none */
} Impact;

static inline void pair_approaches(GroupPair *q, real speed) { q->speed = q->struck ? q->speed : real_max(q->speed, speed); }

/* Of a pair with a fixed solid, what else is fixed beside that, near the other one of the pair: a range of the group's `beside_which`. */
typedef struct Seams { int first, count; } Seams;

/* A pair that a crowd has left out: its bodies do not meet by themselves in this step. */
typedef struct Left {
    uint32_t slot;              /* world pair                       */
    int      a, b;              /* local bodies                     */
    float    slack;             /* m   so much farther the two may get, together, before they could */
    int      places;            /* points there can be; < 0: it was taken since */
} Left;

typedef struct GroupJoint {
    uint32_t slot;
    int      a, b;
    int      other[2];          /* local joints, < 0 none           */
    bool     broken;            /* in this step, at the time        */
    bool     lags;              /* its motor without a bound is stalled: it pushed in the last step and is not at its speed, or no velocities obey it and
                                 * the rest: see group_motor_lag */
    bool     stores;            /* joint_stores of it               */
    bool     looped;            /* its motor drives without a bound, and other joints hold its ends to each other, too: see group_motor_most */
    real     broke;             /* s   into it                      */
    real     overload;          /* 1   its share of what it bears, then */
    real     breaks_at;         /* N   0 = never                    */
    vec3     ra, rb; quat fa, fb;
    real     memory[JOINT_MEMORY];
    real     force[JOINT_SLOTS];            /* N or N m, warm start */
    vec3     impulse, angular_impulse;      /* on a, over the step  */
    real     lost;              /* J   to its friction and dampers, over the step; of the group's lost */
    real     off;               /* m   the most that its rows are off, of what was swept: watch.c */
    JointView view;             /* its ends: once group_joint_view was asked for */
} GroupJoint;

/* What welds make one, by its lowest body; the last is the world itself. [body_count + 1] */
typedef struct Things {
    int     *firm;              /* by welds that cannot break        */
    int     *whole;             /* by all that are whole             */
    bool    *tied;              /* by the lowest of these: something is near it, holds or pushes it */
} Things;

typedef struct GroupPush { int body; vec3 force, torque, at; bool has_at, law; } GroupPush;    /* scaled by the share of the step it acts */

typedef struct Strike {         /* an impact, for events and messages */
    real time;                  /* s from the start of the step     */
    int  pair;
    real speed, impulse;
    vec3 point, normal;
} Strike;

typedef struct Group Group;
typedef struct GroupKept GroupKept;
struct Group {
    const World *world;
    const AccuracyPlan *plan;
    Arena    *lasting;          /* until the step is committed */
    Arena    *arena;            /* while the group is advanced */
    Spare    *spare;            /* of lasting, what the group has done with */
    void     *idle; size_t idle_bytes;          /* nobody's while the group is advanced: what is in it then is lost */
    Team     *team;             /* that advances it; NULL: one thread */
    vec3      gravity;          /* m/s^2  of the world */
    real      fall;             /* m/s^2  the largest where its members are: the scale of what weight does */
    Bulk      bulk;             /* once it was asked for */
    bool      throws_found;     /* group_find_throws was called */
    uint32_t  effects;          /* bit per effect of the list that this group calls for */
    bool      turns;            /* one of them may turn a sphere                    */
    uint32_t  laws;             /* bit per Law that these stand for                */
    dig_status (*stage)(Group *g, int stage);           /* runs the effects of one stage (step/step.c) */
    bool      decay_friction;   /* the founding document's alternative to Coulomb */
    bool      varies;           /* forces depend on where bodies are or how they move */
    bool      settles;          /* an effect acts at the end of the step: it has a STAGE_SETTLE */
    bool      stores;           /* forces have a potential that only their effect knows */
    bool      drags, rules;     /* some forces are drags, or laws of regions: see Apart */
    bool      own;              /* an effect of the caller's takes part: only the calling thread may advance the group */
    bool      waits;            /* and this thread is another: it is still to be advanced */
    dig_effect_part *parts;     /* [moving_count] what such effects are shown; NULL = none was asked yet */
    int       planar;           /* 0 or 1..3: x, y, z is the dead axis */

    const uint32_t *leads; int dig_count;       /* first members of its DIGs */
    const uint32_t *slots, *still;              /* of the bodies, ascending: of those that may move, and of the rest */

    Pos      *pos; Vel *vel; Mass *mass; Member *member; int body_count, moving_count;
    mat3     *inertias;         /* [2 body_count] where time may go at another rate: of members, then their inverses */
    Throw    *throws;           /* [body_count] NULL: nothing throws anything */
    Apart    *apart;            /* [moving_count]; NULL: no force of this group can be a drag or a law's */
    /* As mass, not there in a crowd, which asks for none of them: */
    Vel      *shift;            /* m, rad  position correction of a projection */
    Pos      *start_pos;        /* [body_count] at the start of the substep, */
    Vel      *start_vel;        /* the same; in a crowd whose effects ask for losses, too */
    vec3     *couples;          /* [body_count] N m s  of the last solve, by joints whose rows lie where bodies will be half-way, else 0; NULL: no joints */
    Been     *been;             /* [body_count] of members that have one */
    GroupPair *pairs;       int pair_count;     /* there is room for those left out, too */
    Left     *left;         int left_count, left_end;       /* see group_gather_struck; the list's end, with those taken since */
    bool     pairs_roll;        /* some pair may have rolling resistance */
    Rub      *rubs;             /* [pair_count and left_count] each pair's own, that may be changed; NULL: it is what its surfaces are */
    int      *walled;       int walled_count;       /* pairs with something fixed, see seam.c */
    bool     *astray;           /* [moving_count] who got farther than foreseen; NULL: not known */
    Things   *things;           /* NULL: there are none */
    uint32_t *over;         int over_count;     /* world pairs that touch, of two that have become one thing */
    int      *changed;      int changed_count;  /* group_judge: pairs whose touch began or ended, or that were struck apart */
    int       live_count, rubbing_count;        /* group_judge: contacts with points, and those of them with friction */
    int      *turned;       int turned_count;   /* group_judge: contacts whose record in the world, or whose pair's memory, comes, goes, or grows */
    int       widened_count, remembered_count;  /* group_judge: of these, contacts that grow; memories that come */
    Seams    *seams;            /* [walled_count, or fewer] what is beside the fixed one of each of these that is `seamed` */
    Beside   *beside;           /* the fixed ones that movers meet */
    int      *beside_which;     /* of these, by seams */
    real      finest;           /* m   group_judge: size of the smallest solid in a pair; INFINITY: there is no pair */
    GroupContact *contacts; int contact_count;
    ContactRest *contact_rest;  /* [contact_count] what they lost is of the group's lost, over the whole step. NULL: all is 0, in a crowd where nothing
                                 * rolls and no effect asks for losses */
    Acted    *acted;            /* [contact_count] NULL: nothing did yet, or it is known by `acts` */
    Acted    **few;             /* of a large crowd, in blocks of ACTED_BLOCK, that of contacts in which anything may have acted: */
    const int *acts;            /* [contact_count] its number there, < 0: there is none; NULL: no such crowd */
    Squeeze  *squeezed;         /* [contact_count], if anything squeezes; NULL: not looked for */
    int      *pressed;          /* [body_count] a body's first of these */
    bool      squeezes;
    Carried  *carried;      int carried_count;
    int      *jaws;         int jaw_count;      /* contacts of those that are held */
    bool      sparse;           /* contacts that had no point have no room either: of a large crowd that is most of what is awake */
    atomic_flag taking;         /* a thread of the team takes from the arena, or of these: */
    real     *room;         int room_left;      /* for points of such contacts */
    bool      no_room;          /* there was no memory for them, or for strikes */
    real     *places;       int place_count;    /* of each pair, room for a hint, unless with a ball; then of each of its contacts for its
                                                         * points, then for their memories; of those that came in later elsewhere */
    GroupJoint *joints;     int joint_count;
    GroupPush *pushes;      int push_count;
    PointRow *points;       int point_count, point_capacity;
    RollRow  *rolls;        int roll_count;
    JointBlock *blocks;     int block_count;
    JointRow *rows;         int row_count;
    Strike   *strikes;      int strike_count, strike_room, strikes_most;        /* room: grows up to so many as most */
    Impact   *impacts;      int impact_count;       /* as mass; in a crowd there is room for what it has to note */

    real      t, h;             /* s   since the start of the step, this substep */
    bool      jammed;           /*     what heals contradicts itself: for the rest of the step it heals in place, as far as it goes */
    bool      stops_kept;       /*     what ran past a stop is not brought back by the velocities of this solve */
    real      heal_over;        /* s   so long overlaps heal in this substep: one cut short by an impact heals as the whole did in which that was found */
    vec3      lag;              /* m/s what moves with its end velocity is moved by this, too: see fall_together */
    real      lifted;           /* J   against forces, by healing in this substep */
    real      touch;            /* m   gap at which contacts count as touching, per metre of size */
    bool      only_holds;       /* what is heavy leans on nothing light, as a bucket that holds it */
    bool      gentle;           /* what lands gently is not located: see locate_least() */
    real      close_speed;      /* m/s below which a bounce is over */
    bool      midpoint;         /* joint rows hold for the mean velocity of the substep */
    bool      locate;           /* impacts are located in time in this group */
    bool      patches;          /* sweeps take the points of a contact together: see relax_patch */
    bool      strikes_stops;    /* joints that run into their stops strike, too: see impacts */
    bool      joints_direct;    /* joints and contacts are solved together, directly */
    int       events_left;
    int       whirls_left;      /* parts of the step that are cut short where something whirls near something */

    /* what it took and achieved */
    const struct Way *way;      /* that advanced it                 */
    bool      looked;           /* contacts are those of the step's start, within the reach of all of it */
    bool      handed_on;        /* the last way tried put it back for the next one to take */
    const char *gave_up;        /* why a finer way failed within its budget in this step; NULL = none did */
    int       substeps, sweeps, located;
    bool      starts_soft;      /*     a direct solve of this step did not get there with rows hard at once */
    bool      from_inside;      /*     the last direct solve was one from the inside (direct_cone.c): sweeps would only take its impulses apart */
    bool      inside_failed;    /*     or it failed: a rescue would only ask the same again */
    int       factors;          /*     factorisations of direct solves of this step */
    real      multiplied;       /*     multiplications in them */
    int       direct_failures;  /*     direct solves of this step that did not converge; without joints, one after the other */
    int       direct_factors;   /*     that the last direct solve of this step took */
    real      residual_first;   /* m/s what the first of the last sweeps changed velocities by */
    int       rescues_failed;   /*     the same of those that are tried after the sweeps */
    int       whirled_parts;    /*     of the step: see sweep.c                         */
    bool      stalled;          /*     the last sweeps brought nothing                  */
    bool      unsolved;         /*     in this substep, rows that contradict each other */
    bool      contradicts;      /*     the same in some substep of this step            */
    int       evaluations, refused, events;
    int       kind_turns;       /*     of directions of slip and kinds of contacts, over one an evaluation */
    int       unturned;         /*     spheres whose rotation was not solved: nothing can turn them */
    real      tolerance;        /* 1   local error of the traced way over the size of the bodies */
    real      trace_step;       /* s   its last step length; 0 = none                  */
    int       trace_wait;       /*     steps for which it is not tried again           */
    bool      may_trace;        /*     the world's budget for traced and conserved groups reaches it */
    bool      crowd;            /*     the crowd takes it: it need not look for what cannot act in this step */
    bool      calm;             /*     as many as a crowd, but they lie there: all is solved at once, or handed on to the crowd */
    bool      again;            /*     the step was tried before: some went farther than foreseen */
    int       strays;           /*     solids that did so now (step/stray.c) */
    Toil      toil;             /*     of its members, the most; after the step, theirs */
    bool      dear;             /*     this step was: see toil.c                       */
    int       pieces;           /*     a crowd is to cut its step into; 0 = it says by itself */
    int       toil_most;        /*     sweeps give up beyond; 0 = they do not          */
    bool      may_pause;        /*     stirred by a mover, or else a crowd: toil.c     */
    bool      movers;           /*     one of its bodies is a mover                    */
    bool      driven;           /*     and one of these moves                          */
    bool      trace_failed;     /*     it was tried in this step, and handed on        */
    real      passed;           /* s   that it left to the sweep within this step      */
    bool      breaks_found;     /*     its breaks were found as it went on             */
    int       parted_before;    /*     times that a part was done again for them       */
    GroupKept *before;          /*     the start of the part, where joints can break   */
    bool      conserve_failed;  /*     the same of the way that conserves energy       */
    real      residual, penetration, joint_error;
    real      lost, work_in, law;   /* J */
    real      braced;           /* J   taken by the geometric stiffness of the present substep's direct solve */
    bool      losses;           /*     an effect asks for those of each contact; where they cost nothing they are there anyway */
    struct GroupWatch {         /* step/watch.c */
        real  elastic;          /* J   in its springs at the start of the step                    */
        real  rise, borne;      /* J   gained without work in it; how much may be                 */
        real  carried, carried_borne;   /* J   the same, of the steps before                      */
        real  part, part_borne; /* J   what each member carries on of the sum of rises, and of how much may be */
        real  smallest;         /* m   size of its smallest moving body                           */
        int   gainer;           /*     who gained most                                            */
        int   count;            /*     moving bodies                                              */
        int   leavers;          /*     bodies that end up beyond the edge of the world, and were not reported there */
        uint32_t misfit;        /*     slot of the body whose velocities fit least, where the residual is too large */
    } watch;
    real      effect_us[MAX_EFFECTS], touch_us;     /* us, only in timed steps */
    bool      timed;
    dig_status status;
    bool      sound;            /* it came out well, and all its numbers are finite and not too large */
    int       culprit;          /* local body that became non-finite */
    const char *culprit_effect;
    bool      woke;             /* a sleeping body was pushed: its DIG wakes and the step starts again */
    bool      blame;            /* check after each effect, to name the culprit */
};

static inline ContactRest *contact_rest_of(const Group *g, const GroupContact *c) { return &g->contact_rest[c - g->contacts]; }
static inline vec3 contact_rolling(const Group *g, const GroupContact *c) { return g->contact_rest ? contact_rest_of(g, c)->rolling : vec3_zero(); }

static inline Acted *contact_acted(const Group *g, const GroupContact *c) { return &g->acted[c - g->contacts]; }
/* The same by its number, in any group; NULL: nothing acted in it. */
static inline Acted *acted_in(const Group *g, int contact)
{
    if (!g->acts)
        return g->acted ? &g->acted[contact] : NULL;
    unsigned i = (unsigned)g->acts[contact];
    return (int)i < 0 ? NULL : &g->few[i / ACTED_BLOCK][i % ACTED_BLOCK];
}

/* One group at most has so large a part of what is awake: as a crowd it does not give back what a piece of its step took until the step is over. */
static inline bool group_is_most(const Group *g) { return 2 * g->moving_count > g->world->awake.count; }

/* gather.c */
dig_status group_gather(Group *g, const World *w, const uint32_t *leads, int dig_count, const uint32_t *pairs, int pair_count,
                        Arena *lasting, Arena *arena);
/* Gathers pairs left out whose bodies may meet if the speed of each changes by so much: [body_count], m/s. They come last. */
dig_status group_gather_struck(Group *g, const real *stop, real dt);
dig_status group_gather_rest(Group *g);                 /* contact_rest, as the world has it */
dig_status group_open_acted(Group *g);                  /* acted, of all contacts: nothing yet */
void       group_close_left(Group *g);                  /* no more of them come in: their room is spare */
#define POINT_PLACE ((int)(sizeof(ContactPoint) / sizeof(real)))        /* of the group's places */
/* Room for points that a contact has had none for, by any thread of the group's; false: no memory, and the step will fail. */
bool       group_take_room(Group *g, GroupContact *c);
static inline bool group_has_room(Group *g, GroupContact *c) { return c->manifold.points || group_take_room(g, c); }
dig_status group_fill_out(Group *g);                    /* room for all contacts, where they are sparse */
dig_status group_own_rubs(Group *g, int first);         /* rubs: of pairs from this on, and of those that came before */
dig_status group_leave_out(Group *g, int first);        /* what no effect stands for, of pairs from this on */
dig_status group_judge(Group *g, real dt);              /* at the end of the step: who touches */
void       group_commit_records(World *w, Group *g);    /* of contacts; one group at a time */
void       group_commit(World *w, const Group *g);      /* then what is in them: groups at once */
/* A shape of a pair in its body, about the centre of mass. */
static inline pose pair_local(const GroupPair *q, bool b)
{
    const Form *f = b ? q->on_b : q->on_a;
    return (pose){f->arm, f->at.q};
}
/* Pose of a pair's shape a or b from the present positions. */
static inline pose group_shape_pose(const Group *g, int body, pose local)
{
    return pose_of_part((pose){g->pos[body].x, g->pos[body].q}, local);
}
dig_status group_weigh(Group *g);                       /* mass, but for inertias, and what is there with it */
mat3       group_inverse_inertia(const Group *g, int body);     /* in world axes, now */
void       group_refresh_mass(Group *g, int body);      /* keeps it */
void       group_joint_view(Group *g, int joint);       /* its ends and those of joints that it couples, from the present positions and velocities */
real       group_spring_energy(const GroupJoint *j);        /* J  as it was viewed last */
real       group_row_driven(const Group *g, const Row *r);      /* m/s or rad/s  of its rate, what kinematic ends do */
void       group_joint_move(Group *g, int joint);       /* once viewed: those of its ends that can move, again */

/* fused.c: bodies that cannot move against each other do not meet */
dig_status fuse(Group *g, int pair_count);
void       fuse_near(Group *g, int a, int b);           /* told of all pairs, */
bool       fused(Group *g, uint32_t pair, int a, int b);        /* then asked once of each */

/* cover.c: faces at joints that are none of a thing's surface */
void       cover(Group *g);

/* seam.c: fixed solids beside each other, and what is hidden between them. Again when pairs have come in, from this on. */
dig_status seams(Group *g, int first);
bool seam_near(const Group *g, const GroupPair *q);     /* is something fixed beside the fixed one of this pair? */
/* A contact of the pair, in these poses: is it at a part of the fixed one that others cover? Uncovered it is at one that they do not, or none. */
bool seam_hides(const Group *g, const GroupPair *q, pose pa, pose pb, const Manifold *m);
bool seam_uncover(const Group *g, const GroupPair *q, pose pa, pose pb, Manifold *m);

/* force.c: what the effects of STAGE_FORCE ask for now, and what drags and laws of regions took and gave over a substep in which
 * bodies moved and turned so far */
dig_status group_forces(Group *g);
dig_status group_apart(Group *g);                       /* room for what is booked apart, once it is known which effects take part */
void       group_brake(Group *g, int body, vec3 force, vec3 torque);        /* adds a drag against what stands still */
void       group_rule(Group *g, int body, vec3 force, vec3 torque);         /* adds what is the work of laws: regions', scripts' */
void       group_book_apart(Group *g, int body, vec3 moved, vec3 turned, real h);
void       group_book_push(Group *g, const GroupPush *p, real work);        /* J */

/* part.c */
void group_part(Group *g, int joint, real share);       /* it breaks now: gone for the rest of the step, at that share of what it bears */
bool group_may_part(const Group *g);                    /* has it joints that can break, and may a part of the step be done again? */
bool group_keep_before(Group *g);                       /* the start of a part; false: out of memory */
void group_back_before(Group *g);                       /* there again, but for what the try has cost */
void group_mean_load(Group *g, int joint, real dt, vec3 *force, vec3 *couple);      /* N, N m, on a at its anchor, over the frame that ends now */
real group_sways(Group *g, real dt);       /* rad/s  Of the fastest joint that is pressed against a stop which turns with it: sway.c */
real group_share(Group *g, int joint, real dt);         /* of its limit, in the mean of the last frame of dt */
int  group_overloaded(Group *g, real dt, real *share);  /* the joint most over its limit in the mean of the last frame of dt; < 0: none */

/* keep.c */
struct GroupKept {              /* a group as it was */
    Pos *pos; Vel *vel; Mass *mass; Member *member; GroupPair *pairs; GroupContact *contacts; real *places; GroupJoint *joints;
    Apart *apart; Impact *impacts; Rub *rubs;
    Pos *start_pos; Vel *start_vel; Been *been; ContactRest *contact_rest; Acted *acted;
    Group scalars;
    void *block; size_t bytes;  /* where all that lies */
};
bool group_keep(const Group *g, GroupKept *k);          /* false: out of memory */
bool group_keep_in(const Group *g, GroupKept *k);       /* the same, into what it has from before, or was zero */
void group_put_back(Group *g, const GroupKept *k);      /* but for what the try has cost: evaluations, turns and refused */
bool group_deep(const Group *g);                        /* does a contact point overlap? */
bool group_joints_broken(const Group *g);               /* may velocities break joints: were bodies hit or given a speed, or is a joint new? */

/* joint_view.c: frames, from anchors and orientations */
void joint_end_set(JointEnd *e, vec3 x, quat q, vec3 v, vec3 w, vec3 local_anchor, quat local_frame);

/* touch.c: contacts of the present positions, looking `time` s ahead; all = false: only pairs whose manifold is stale */
void group_touch(Group *g, real time, bool all);
void group_touch_pair(Group *g, GroupPair *q, real time);
/* The same of two convex solids, looking `farther` for what is near without a contact. m  What is between them at least, where there
 * is no point; else 0. */
real group_touch_convex(Group *g, GroupPair *q, real time, real farther);
real group_touch_within(Group *g, GroupPair *q, real reach);       /* m; returns the same */
bool group_outruns(const Group *g, real time);                     /* may two close on each other in that time by more than was looked ahead for? */
/* Pairs that the velocities now found press deep into each other, for they had no row: they get one when the substep is solved again.
 * What comes down on what is stopped in this substep was not approaching it at its start. through: only those that would get past each
 * other. */
bool group_touch_missed(Group *g, real time, bool through);
real group_thin(const GroupPair *q);       /* m  with its middle so deep in the other the thinner one of a pair is past it */

/* joint_rows.c */
void group_build_joints(Group *g, bool midpoint);
real group_motor_lag(const Group *g, const Row *r);        /* N or N m  what the motor of this row gives while it is not at its speed; of one without a bound
                                                            * from Group.bulk */
real group_motor_most(const Group *g, const GroupJoint *j, const Row *r);      /* N or N m  the same, at its speed, too */
void group_turn_joints(Group *g, const Vel *found);     /* for the velocities at the end, as their bodies will have turned half-way: as they
                                                         * did before, or by the velocities found; [body_count] */
/* Will the velocities found open a joint? What is thin and turns far in a substep swings its ends off the line that they hold for. */
bool group_joints_open(const Group *g);
bool group_may_lever(const Group *g);    /* lever.c: may a mover have to give more than a lever does? */
void group_ease_levers(Group *g, Vel *before);    /* impulses count by a share where it has; before: velocities without them */
real group_heal(Group *g);                 /* has the rows take position errors off; returns the fastest, m/s */
bool group_stops_passed(const Group *g);    /* is something behind its stop, where a script has set that, and brought back? */
bool group_jams(const Group *g, real heals);            /* could the rows not do both what holds and that? */
bool group_throws(const Group *g, real heals);          /* do limbs whirl that are wedged near their joints? */
void group_unwind(Group *g);               /* all rows begin without an impulse */
bool group_joints_gape(const Group *g);     /* is one open as its present rows say, so that it could be seen? */
bool group_clean_joints(Group *g);          /* true: then strike_stops(), too */
real joint_row_rate(const Group *g, const Row *r);      /* m/s or rad/s, now */
void joint_row_warm(Group *g, JointRow *r);
/* m/s or rad/s  Of a row, now. */
static inline real group_row_rate(const Group *g, const Row *r)
{
    real rate = 0;
    for (int k = 0; k < r->count; k++)
        if (r->body[k] >= 0)
            rate += vec3_dot(r->lin[k], g->vel[r->body[k]].v) + vec3_dot(r->ang[k], g->vel[r->body[k]].w);
    return rate;
}
real group_row_mobility(const Group *g, const Row *r, int k);   /* kg^-1 or (kg m^2)^-1  what a row moves of its k-th body, per unit of impulse */

/* hold.c: after a substep in which poses and velocities of moving members went on from start_pos and start_vel. both: what was lost is
 * given back, too, where it is little (not to what hangs on a mover). *taken: J out of their motion; work_in has what movers gave */
dig_status group_hold(Group *g, bool both, real *taken);

#define BODIES_AHEAD 3          /* turns of a loop, that a body's record is fetched before it is needed */
#define JOINTS_AHEAD 4          /* the same of a joint's                                               */

/* The points of a world's contact after the first, once it is here itself. */
static inline void fetch_more(const World *w, uint32_t contact)
{
    if (contact != NONE && w->contacts.data[contact].more != NONE)
        fetch_soon(&w->more.data[w->contacts.data[contact].more], sizeof(MorePoints));
}

/* sweep.c: the sub-stepped way */
dig_status sweep_advance(Group *g, real dt);
dig_status sweep_piece(Group *g, real dt, real until);  /* from g->t on, of a step of dt; room for rows and strikes is there */
/* portion.c: parts of a step */
#define SWEEP_FINE 16         /* substeps of a step: in longer ones what was found first is no good guess of how bodies turn */
int  sweep_whirls(const Group *g);                      /* Group.whirls_left of a step */
int  sweep_parts(const Group *g);
int  sweep_whirled_parts(const Group *g, real dt);
real sweep_longest_piece(Group *g, real dt);            /* s  how long the next substep may be */
real group_kinetic(const Group *g);                     /* J */
/* x' = x + h v' (semi-implicit Euler). All others: x' = x + h (v + v') / 2, which is Verlet's 2 x - x'' + a h^2 written with the
 * velocity: it needs no equal steps and no position before the last impact. */
static inline bool member_by_euler(const Member *m)
{
    return m->integrator == DIG_EULER || (m->integrator == DIG_SWITCH && (m->fresh || m->collided));
}
/* book.c: what a substep did */
Vel  group_way_of(const Group *g, int body);            /* what a substep moves it with: forces work along that */
Vel  group_mean_velocity(const Group *g, int body);     /* of start and end; of what impulses do not move: its own */
real group_mean_rate(const Group *g, const Row *r);     /* m/s or rad/s  of a row, by these */
real group_blow_speed(const Group *g);                  /* m/s  an approach faster than by what pushes it in a substep, and lost in it, is a blow */
void group_forget_idle(Group *g);                       /* points that took no part in the solve remember no force */
void group_book(Group *g);
void group_book_pushes(Group *g);                       /* their work in a substep */
real group_kinetic_of(const Group *g, int body);         /* J */
/* m/s  Slower impacts are no impacts; size: m, of the smallest pair; fall: m/s^2. */
static inline real close_speed_of(real size, real fall) { return isfinite(size) ? sqrt(2e-5 * size * fall) + 1e-9 * size : 0; }
/* m/s  What comes so slowly to what it lies on lands gently. */
static inline real gentle_speed_of(real size, real fall) { return 0.1 * sqrt(fall * size); }
real group_close_speed(const Group *g);
/* impact.c: what touches and approaches is struck, now */
int  group_events(const Group *g);                      /* impacts that may be located in a step */
void impacts(Group *g);
void strike_stops(Group *g);                            /* those that the substep, of g->h, would run past */
bool contact_presses(const Group *g, const GroupContact *c, real approach);    /* by what counts; approach: m/s  of what comes at it */
Impact *group_impact(Group *g, GroupPair *q);          /* of this step: a new one if it has none */
void strike_report(Group *g, const PointRow *r, real speed);
/* relax.c: Gauss-Seidel sweeps over rows; each returns the largest velocity change, m/s */
real relax_points(Group *g, int first, int count);
/* A blow of points[first..end) that are on (all, where on is NULL) as it ends where they stick or part, within `enough`, m/s. */
bool stick(Group *g, const bool *on, int first, int end, real enough);
real relax_patch(Group *g, int first, int count);      /* points of one contact at once */
void warm_points(Group *g);                              /* what their impulses do to velocities */
real relax_joints(Group *g);
real relax_roll(Group *g, RollRow *r);
real relax_rolls(Group *g);
int  relax(Group *g, int sweeps, real residual);        /* until the change is below residual; returns sweeps done */
bool relax_in_vain(const Group *g, const Vel *before, real worst);    /* the sweep left all bodies as they were before it, though it changed them by `worst` */
/* impulses.c: of all rows, from their present ones */
#define VELOCITY_COARSE 1e-3             /* m/s: a small group whose velocities are worse than this gets more sweeps than its plan gives */
void relax_group(Group *g);
/* idle.c: contacts that nothing presses */
int idle_leave(Group *g);               /* these have no row from now on; returns how many points */
int idle_call(Group *g, bool all);      /* those whose bodies approach by the velocities found, or all, have one again; how many */
Vel *group_velocities(const Group *g);  /* a copy, from the arena; NULL: out of memory */
dig_status group_warm_start(Group *g);  /* the velocities that the rows' impulses make, or as much of these as does no harm */
/* toil.c */
void toil_gather(Group *g);
void toil_count(Group *g, real dt);     /* after a step of sweeps */
#define TOIL_DEAR 200                   /* of a step of few bodies; one that follows what it knew takes some dozens */
int  group_toil(const Group *g);        /* sweeps of this step, and what else is as dear */
Toil toil_after(const Group *g, Toil of);       /* of a member, after the step */
static inline bool toil_pauses(const Group *g) { return g->toil.pause > 0; }
/* More than are solved and watched for all that happens whatever it costs: see toil_bodies in plan.h */
static inline bool group_many(const Group *g) { return g->moving_count > g->plan->toil_bodies; }
/* Many that lie there, of which a direct solve has not found the forces: see crowd/calm.c. */
static inline bool lies_uneasy(const Group *g) { return g->calm && g->trace_wait > 0; }
/* direct.c: all contacts at once, exactly, from the present impulses; false: not for this group, or it failed, and nothing changed */
bool direct_solve(Group *g, real residual);
bool direct_rescue(Group *g);           /* the same where sweeps have not got there, slower and surer */
bool direct_project(Group *g);          /* a projection's rows at once, into g->vel, which holds the shift */
bool direct_project_joints(Group *g);      /* the same, of joints that sweeps are for */
real group_mass_ratio(const Group *g);  /* 1  of what moves, at least 1 */
bool group_top_heavy(const Group *g);   /* is something much heavier than something else? */
#define HEAVY 30.0                      /* times the lightest mass: an error that is nothing to what is heavy throws what is light */
#define STIRRED 1000.0                  /* times the lightest mass, where things may pause: 40 boxes of 10,000:1 in a bucket sank by a seventh of their size */
bool group_elastic(const Group *g);     /* do any of its joints give and store energy? */
bool group_bears_load(const Group *g);  /* do joints carry what is heavy, or give? Else they are limbs that slide and turn */
bool direct_joints(Group *g);           /* should joints and contacts be solved together? */
real direct_wanted(const Group *g);     /* m/s  sweeps that stop above this are to be followed by direct_solve; 0 = never */
/* lean.c */
void lean_find(Group *g, bool known);   /* g->only_holds; known: the contacts are, else those of the last step's end hold */
bool group_leans(const Group *g);       /* may something heavy press on something light? */
/* turn.c */
vec3 group_swerve(const Group *g, int i);        /* rad/s  Member.swerve, from the velocities before the substep */
void group_find_throws(Group *g);                /* throw.c: throws, GroupJoint.lags */
bool group_in_loop(Group *g, int joint);        /* there: do other joints hold its ends to each other, by themselves or through what does not move? */
void group_find_loops(Group *g);                /* there: GroupJoint.looped */
bool group_motors_yield(Group *g);                /* there: gives motors without a bound one; false: none was left without */
void group_find_bulk(Group *g);                  /* there: Group.bulk */
/* m */
static inline real group_thrown(const Group *g, int body, real time)
{
    return g->throws ? real_min(g->throws[body].rate * time, g->throws[body].far) : 0;
}
void group_note_blow(Group *g, int body);       /* impact.c: where it is it was struck */
void group_note_swing(Group *g, int body, vec3 x, real turned);        /* there: its centre of mass was at x, having turned by so much, rad */
quat member_turned(const Member *m, quat q, vec3 l, real h);    /* after h seconds free of torque, with angular momentum l */
bool group_spins_off(const Group *g);           /* a substep is too long for something thin at joints */
/* Does it turn so far in a substep that rows, which hold at its start, say nothing of how? Then it turns on as it would free of them, and with what heals it
 * turns its spin: by the mean of two momenta, or under a spin that stays, its axis comes to lie anywhere to what it has, with any energy. */
bool group_whirls(const Group *g, int i);
void group_note_couples(Group *g, bool turned); /* turned: rows of joints lie where their bodies will be half-way */
void group_turn(Group *g, int i, vec3 mean_w);  /* turns the body on through the substep */
/* project.c: position errors are removed without touching velocities */
void project(Group *g);
void project_back(Group *g);    /* the gaps only: the poses are the caller's. Not those that were looked at anew since */
/* Part of the size. The points of what overlaps farther say little about where it would press. */
#define MERGED 0.05
bool contact_merged(const Group *g, const GroupContact *c);     /* squeeze.c: of two that nothing keeps from parting, deep in each other */
/* squeeze.c: of the contacts there are now. Rows that are eased press no more than they must: what friction holds would be let slip. */
typedef enum Jaws { JAWS_SLIP = 1, JAWS_RUB = 2, JAWS_ALL = 3 } Jaws;
real contact_depth(const GroupContact *c);              /* m  of its deepest point; -INFINITY: it has none */
dig_status squeeze_open(Group *g);                      /* room for what it finds */
void group_squeeze(Group *g, Jaws which, real ahead);       /* s  they may have closed by then */
real squeeze_missing(const Group *g);                   /* m/s  what rows ask for that cannot be */
bool squeeze_possible(const Group *g);                  /* is it worth looking? */
static inline Squeeze squeeze_of(const Group *g, int contact) { return g->squeezes ? g->squeezed[contact] : (Squeeze){0, 0, -1, false}; }
static inline bool is_squeezed(const Group *g, int contact)
{
    return g->squeezes && (g->squeezed[contact].rate + g->squeezed[contact].depth > 0 || g->squeezed[contact].grips);
}
/* grip.c */
#define GRIP_SINKS 1e-9         /* of the size: by less what is held does not go into what else it touches */
bool       grip_possible(const Group *g);
bool       group_grips(const Group *g);                 /* have movers closed on something, as far as is known? */
/* Whom movers hold for the rest of the step, or will have closed on in `ahead` s: they are movers until grip_give. */
dig_status grip_take(Group *g, real rest, real ahead);
void       grip_follow(Group *g, real h);               /* after all have moved straight on for h s: round with what turns */
void       grip_lead(Group *g);                         /* and its velocity is again that of its place */
bool       grip_is_jaw(const Group *g, int first, int count, int contact);     /* is it among so many of Group.jaws? */
void       grip_give(Group *g);                         /* at its end they are as before */
bool       grip_let_go(Group *g);                       /* none is held in this step; false: none was */
dig_status grip_note(Group *g);                         /* then: who has closed on what */
/* locate.c: s into the substep of the first impact, or INFINITY */
void locate_look(Group *g, real time);                  /* contacts of what lies open, as far ahead: of those kept from the step before nobody knows */
real locate_impact(Group *g);
real locate_least(const Group *g, const GroupPair *q);   /* m/s  slower blows of a pair are not located */
real missing_little(const Group *g, real dt);         /* s  the longest substep that may go without */
/* m  How far points of a pair move against each other in h seconds, at most. */
real group_travel(const Group *g, const GroupPair *q, const Motion *a, const Motion *b, real h);
/* Moves a pair by h seconds and `travel` metres at most: is one deeper than `most` (m) in the other at some instant after they meet? */
bool group_went_through(const GroupPair *q, const Motion *a, const Motion *b, real h, real most, real travel);
bool overshoots(const Group *g, bool through);  /* would the substep press bodies deep into each other? through: past the middle of the thinner one */

/* What lies calm: two that touch move against each other no faster than this part of the speed of a fall by their own size, but for this
 * part of them. Else direct solves take long, and creep does not matter. */
#define CALM_SPEED 0.03
#define CALM_FAST  0.05

typedef enum WayTally { WAY_TRACED, WAY_CONSERVED, WAY_SWEPT } WayTally;

/* A way to advance a group. The choice is by counts, never by the clock.
 *
 * advance moves g from t = 0 to t = dt, or fails, or finds that it cannot do it: then it puts the group back as it was, sets
 * g->handed_on and returns DIG_OK, and the next way takes the group. Work done in vain has its reason in g->gave_up; a way that
 * only after a look sees that the group is not for it leaves that alone. */
typedef struct Way {
    const char *name;
    WayTally    tally;          /* where dig_stats counts its groups */
    bool       (*suits)(const Group *g);
    dig_status (*advance)(Group *g, real dt);
    bool        inertias;       /* begins with inverse inertias in world axes: g->mass[].ii */
    bool        carries;        /* takes groups in which movers hold something */
} Way;

extern const Way way_wedge;

#endif
