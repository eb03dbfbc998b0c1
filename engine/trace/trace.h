/* trace/trace.h - the traced way: a small group's motion followed at high order between located events.
 *
 * The state is (x, q, v, L) of every moving body, L its angular momentum about the centre of mass in world axes. Between
 * events nothing changes its kind: contacts that press stay closed, what sticks sticks, what slides slides. Then
 *
 *     M a = f + G lambda,    J a + (dJ/dt) v = 0
 *
 * is an ordinary differential equation, integrated with error control. An event (an impact, a contact that lets go, slip
 * that ends or begins, a joint's stop) is located in time on the step's dense output, and the kinds are found anew.
 *
 * Floor: trace. Includes base, math, geom, world, solve.
 */
#ifndef DIG_TRACE_H
#define DIG_TRACE_H

#include "math/tumble.h"
#include "solve/direction.h"

/* Does it not move in this step, nor wake? body < 0: the world */
static inline bool member_still(const Group *g, int body)
{
    return body < 0 || (!g->member[body].moves && !g->member[body].dormant && vec3_is_zero(g->vel[body].v) && vec3_is_zero(g->vel[body].w));
}

/* flight.c: turns a body on that nothing twists, as in free flight */
void flight_turn(Group *g, int i, real h);

/* ---- hang.c: one body that hangs by one joint on what stands still ---- */

typedef struct Hang {
    bool is_a;                  /* of its joint; else it is b */
    const JointEnd *own, *other;
    Vel  before;                /* m/s, rad/s  at the start of the step */
    real least, slowest;        /* m, m/s  off its place, or moving off it, by no more it is in it */
} Hang;

/* A step is cut into parts, and of each part the terms of a power series are summed. */
#define SERIES_TERMS 30         /* most of them */
#define SERIES_LEAST 4
int  hang_parts(real turn);                             /* rad in the step, or of its own swing: into so many; 0: too many, they are the tracer's */
bool hang_suits(const Group *g);                        /* ... which does not break, and nothing but one force drives it */
bool hang_look(Group *g, Hang *hang);                   /* false: it has no size */
bool hang_holds(const Hang *hang);                      /* are both anchors one place? What puts them there is a jerk: the tracer's */
/* Does it meet nothing, of which no point gets farther than way, in metres? Then what was found near is left behind: the next step looks anew. */
bool hang_apart(Group *g, real h, real way);
vec3 hang_impulse(const Group *g, const Hang *hang, real h);    /* N s  of the joint on it, over the step */
/* N s, N m s  On the body: about its centre of mass, and without that of the impulse. */
void hang_book_impulses(Group *g, const Hang *hang, vec3 impulse, vec3 about_centre, vec3 couple);
int  hang_rows(Group *g, Row rows[JOINT_SLOTS]);        /* of the joint, where it is now; its forces are none */
/* A way's: follow leaves the group as it was if it returns false. */
dig_status hang_advance(Group *g, real dt, bool (*follow)(Group *g, real h));

extern const Way way_flight, way_glide, way_pendulum, way_bob, way_spring, way_top, way_trace, way_billiard;

/* ---- contact features: what touches what, frozen for a step ---- */

typedef enum FeatureKind {      /* on a, on b; RIM: the circle round the end of a cylinder */
    POINT_PLANE, PLANE_POINT, POINT_POINT, POINT_LINE, LINE_POINT, LINE_LINE, RIM_PLANE, PLANE_RIM, RIM_POINT, POINT_RIM
} FeatureKind;

typedef struct Feature {
    FeatureKind kind;
    bool fixed;                 /* the plane is of what never moves: pa and da, or pb and db, are in world axes */
    vec3 pa, pb;                /* m   a point of the core, from the centre of mass, body axes; a rim's centre */
    vec3 da, db;                /*     outward normal of the plane, or direction of the line, or axis of the rim */
    real ra, rb;                /* m   rounding radii; of a rim: the circle's                   */
} Feature;

typedef struct Kinematics {     /* of a contact, world axes */
    vec3 n, at;                 /*     normal from a to b; contact point, m                     */
    vec3 u;                     /* m/s   material of b against that of a                        */
    vec3 drift;                 /* m/s^2 rate of u without accelerations                        */
    real drift_n;               /* m/s^2 rate of n . u without accelerations                    */
    real gap, rate;             /* m, m/s                                                       */
} Kinematics;

/* What all points of a manifold share: where the two shapes are, in the world and in their bodies, its normal, and the same in either's
 * frame, outward; of balls only the place in the body, of planes no direction. Few shapes are turned in their body. */
typedef struct Sides {
    pose a, b, la, lb;
    vec3 n, out_a, out_b;
    bool turned_a, turned_b;
    const Pos *fixed_a, *fixed_b;       /* of bodies that never move; NULL: it may */
} Sides;

void feature_sides(const Group *g, const GroupPair *q, vec3 normal, Sides *out);
/* What touches at a manifold's point of two shapes of known kind. */
void feature_find(const GroupPair *q, const Sides *s, const ManifoldPoint *p, Feature *out);
bool feature_kind_known(const Shape *s);
static inline bool feature_has_rim(const Feature *f) { return f->kind >= RIM_PLANE; }
void feature_move(const Group *g, const Feature *f, int a, int b, Kinematics *k);
real feature_gap(const Feature *f, const Pos *a, const Pos *b);        /* m  where its bodies are there; the same bits */
bool feature_turns(const Feature *f, bool b);           /* does it matter for the gap how that body is turned? not of balls */

/* ---- what may press, slide or hold ---- */

typedef enum Grip { GRIP_STICK, GRIP_SLIP, GRIP_BRINK } Grip;   /* brink: at the bound of friction, not moving yet */

typedef struct Gate {           /* one-sided: a contact's normal or a joint's stop */
    real gap, rate, acc;        /* m, m/s, m/s^2                                          */
    real force;                 /* N                                                      */
    bool closed, presses;       /* closed: gap and rate are zero; presses: has a row      */
    real gap0, rate0, acc0, force0;             /* at the start of the step               */
} Gate;

typedef struct Cone {           /* friction (2 directions) or rolling resistance (3) of a contact */
    int  axes;                  /* 0 = none                                               */
    real still, moving;         /* bound over the normal force                            */
    real holds;                 /* of the bound: so much more it holds while it sticks; 0 but where it would begin and end to slip at once */
    Grip grip;
    bool locked;                /* slips so slowly that the direction is held             */
    vec3 d, from;               /* unit, of the slip; at the start of the step            */
    vec3 u, acc;                /* relative velocity and acceleration                     */
    vec3 force;                 /* on b                                                   */
    real weight;                /* of its rows in the least-norm sharing                  */
    real lateral;               /* N   of the lock                                        */
} Cone;

/* N  up to which it sticks, where it does */
static inline real cone_hold(const Cone *c, real normal) { return c->still * normal * (1 + c->holds); }
static inline real cone_bound(const Cone *c) { return c->grip == GRIP_BRINK ? c->still : c->moving; }

typedef struct Touching {       /* a contact point */
    Gate gate;
    Cone slip, roll;
    bool idle, called;          /* it touches, and nothing presses it; something did in this frame */
    Feature feature;
    Kinematics k;
    int  contact, point;        /* of the group                                           */
    int  a, b;
    uint32_t id;                /* the manifold point's feature number                    */
    int  opened;                /* how often it let go while its kind was looked for      */
} Touching;

typedef struct Footing {        /* what the rows of a touching point were made of */
    unsigned kinds;
    real weight;
    vec3 n, lever[2];           /* 1, m    */
    vec3 slip, roll;            /* directions */
} Footing;

/* m or rad: a joint that begins so far beyond its stop is led back by the sweeps; nearer it is put right, as sweeps leave it so */
#define BEYOND 1e-3
#define GATE_DRIFT 1e-4         /* of the tolerance: what touches and is that much off is put right; more would count as open */

typedef struct Stop { Gate gate; int joint, slot; } Stop;       /* a LIMIT row of a joint */

typedef struct Hold {           /* a motor or dry friction of a joint */
    int  joint, slot, side;     /* side 0: holds its speed; +-1: at its bound             */
    real most, target, rate, acc, force;        /* most: N or N m, what it holds its speed with */
    real lag;                   /* N or N m  what it gives at its bound: of a motor without one, see group_motor_lag */
} Hold;

typedef struct Bond {           /* a joint that can break              */
    int  joint;
    real strength, start, end;  /* N, or 1 where the type has a share: load at the start and at the end of the step */
} Bond;

/* ---- rows of the direct solve ---- */

typedef enum LineKind { LINE_HARD, LINE_NORMAL, LINE_STOP, LINE_SLIP, LINE_ROLL, LINE_HOLD, LINE_LATERAL } LineKind;

typedef struct Arrow { vec3 lin, ang; } Arrow;
_Static_assert(sizeof(Arrow) == 6 * sizeof(real), "six numbers, two at a time");

typedef struct Line {           /* one row: J of the moving bodies, and M^-1 G */
    LineKind kind;
    int  owner, slot;           /* touching, stop, hold or joint; slot: row of the joint */
    int  points, point[MANIFOLD_POINTS];        /* of a patch: the touching points that share the row's force, */
    real share[MANIFOLD_POINTS];                /* by how much (normal),  */
    vec3 e[MANIFOLD_POINTS];                    /* or along what (tangential) */
    int  count, body[ROW_BODIES];
    Arrow j[ROW_BODIES], m[ROW_BODIES];         /* J; M^-1 G             */
    vec3 gang[ROW_BODIES];      /* G, its torques; G = J without sliding */
    real drift, error, want;    /* m/s^2, m, m/s                         */
} Line;

typedef struct System {         /* A x = b with A = J M^-1 G: L D L^T in its profile, or LU where friction slides */
    int   count, capacity;
    Line *lines;
    real *a, *f, *b, *x, *r, *dx;
    int  *first, *swap;
    int  *run;                  /* one past the last of the rows that follow each other on the same bodies */
    bool  sliding;              /* A is not symmetric                    */
    bool  redundant;            /* softened and refined                  */
    int   rank;                 /* of rows that repeat others, all on the same bodies, which need no A; 0: not factored so */
    real  residual;             /* over the right side                   */
} System;

bool system_factor(System *s);                  /* assembles A from the lines and factors it */
bool system_solve(System *s, real accept);      /* x from b; false: redundant rows contradict each other by more of the right side than that */

/* ---- the tracer ---- */

#define STAGES 7
#define TOUCH_POWERS 5          /* of each touch: force, normal force, what it loses */
#define JOINT_POWERS 7          /* of each joint: force, torque, what it loses */
#define WATCHED 256             /* most contact points, stops and holds of a group: all of them are watched for events */

typedef struct State { vec3 x; quat q; vec3 v, l; } State;      /* 13 reals */
#define STATE_REALS 13

typedef struct Unwound { real memory[JOINT_MEMORY]; } Unwound;          /* of a joint: turns it has made */

/* An event and its function, which falls through zero: a gap, a force, a force's distance from its bound, a speed. */
typedef enum EventKind {
    EVENT_NONE,
    EVENT_CLOSE,                /* an open gate meets: gap                                  */
    EVENT_OPEN,                 /* a pressing gate would pull: force                        */
    EVENT_PRESS,                /* a closed gate without force sinks in: acceleration       */
    EVENT_YIELD,                /* what sticks or holds reaches its bound                   */
    EVENT_HALT,                 /* slip, or a motor's lag, comes to its end: speed          */
    EVENT_GRIP,                 /* what was on the brink sticks again: acceleration         */
    EVENT_BREAK,                /* a joint's load reaches its strength: what is left of it  */
    EVENT_SHORTER               /* none, but the step must be shorter to tell               */
} EventKind;

typedef struct Event { EventKind kind; real at; Gate *gate; const Touching *touch; Cone *cone; Hold *hold; const Gate *normal; const struct Bond *bond; } Event;

typedef struct Tracer {
    Group *g;
    real   t, end;              /* s  within the step                     */
    real   tolerance;           /* m  local error                         */
    real   size, pace;          /* m; 1/s: what turns velocities into lengths */
    real   swing;               /* 1/s  the fastest spring's              */
    real   gap_zero, gap_deep;  /* m  what touches; how deep it may be found to lie by another way's doing */
    real   speed_zero, slip_zero;               /* m/s                    */
    Touching *touch, *old_touch; int touch_count, old_count, touch_capacity;
    real   touched;             /* s  when contacts were last looked for */
    bool   relisted;            /* touch was, when last looked for; else it is as it was, and old_touch says nothing */
    bool   unplaced;            /* something was found then that no frozen feature stands for */
    Stop  *stops; int stop_count;
    Hold  *holds; int hold_count;
    Bond  *bonds; int bond_count;
    Row   *rows; int *row_count;                /* JOINT_SLOTS per joint   */
    System sys;
    Footing *footing; quat *noted_q;            /* of the touching points and the moving bodies, when the rows were noted... */
    bool  noted;                /* ...which are those of the system, still, and factored */
    int   *order;               /* of bodies along chains and stacks       */
    int   *item; int item_count;                /* joints (>= 0) and contacts (-1 - i) in that order */
    real  *joint_force;         /* N or N m, JOINT_SLOTS per joint         */
    real   gate_most, gate_least;       /* N   largest one-sided force of the last solve, and the least that it counts as */

    vec3  *acc0, *torque0, *acc, *torque, *alpha;       /* per moving body: m/s^2, N m, rad/s^2 */
    vec3  *pull, *twist;        /* m/s^2, N m: what the world's effects do to them */
    bool   even, pulled;        /* even: that is the same wherever they go; pulled: and it is known */
    vec3  *spin_l;              /* kg m^2/s  angular momentum of the present state */
    Unwound *unwound;           /* [joints] at the start of the step */
    vec3  *spin0, *alpha0;      /* rad/s, rad/s^2 at the start of the step */
    Pos   *mover_start;         /* poses of kinematic bodies at t = 0      */

    State *y, *y1, *y2, *kept, *stage[STAGES];         /* states and their rates  */
    const State *known;         /* the state of which the present rows and forces are; NULL: of another one */
    real  *quad[STAGES], *sum;  /* forces and powers to be integrated: see flow.c */
    real   over;                /* s  where something that pressed... */
    int    over_contact;        /* ...was found to have got over an edge: it did so before */
    bool   crawled;             /* its steps remained short where slips were slow: from there on these follow their forces */
    real   aimed_at;            /* s  where the last step began that followed slow slips by their forces */
    real   h, h_next, h_probe;  /* s  of the present step, of the next, of the probe that the present one is part of */
    real   part;                /* of the tried step, not a probed one, at which it ends */
    bool   aims;                /* the present step ends where something will meet, or just past it */
    real   error_rate;          /* 1/s^5  error over the tolerance of the last step that went well, over its length's power; 0: none since the last event */
    bool   probed;              /* the present step has constant accelerations */
    int    probe_wait, probe_fails;
    bool   passing;             /* an instant within a step: nothing is looked for there */
    bool   dirty;               /* kinds must be found anew                */
    bool   locks;               /* they were found with slips held in their direction: see hold_slow_slips */
    Event  hint;
    const char *fault;          /* why it cannot go on                     */
    bool   left;                /* to another way, which serves as well    */
    real     given;             /* J  by movers and motors in the last projection of velocities */
    int    near_events; real event_time;
    int    passes, work;        /* places swept past in this frame; most evaluations, sweeps of blows over BLOW_SWEEPS, and turns over TURNS */
    int    mark_work; real mark;                /* evaluations and s, from which on it is looked whether it crawls */
    real   pass, pass_end;      /* s  length and end of the last of them  */
    bool   conserves;           /* nothing in this frame took or gave energy so far: it is held, see energy.c */
    bool   turns;               /* the same of angular momentum: jerks of joints and breaks leave it */
    bool   shifted;             /* what was off its joints or contacts at the start was moved */
    int   *root; bool *held;    /* mechanisms: [moving_count + 1] lowest body; does it hang on something? */
    vec3  *anchor;              /* m   ... where (one place of them) */
    real  *gain;                /* J   of each, by its lowest body             */
    real  *motion;              /* J   kinetic, the same, before joints are put right at the start of the frame */
} Tracer;

/* How many forces and powers are integrated: 4 a contact point, 6 a joint, 1 a push, and three sums. */
static inline int trace_powers(const Tracer *t) { return TOUCH_POWERS * t->touch_count + JOINT_POWERS * t->g->joint_count + t->g->push_count + 3; }

/* suits.c */
bool trace_suits(const Group *g);
bool trace_has_loop(const Group *g);            /* of joints */
real trace_tolerance(const Group *g);           /* local error of its steps, of the size */
/* swing.c */
typedef enum Stiffness { STIFF_NOT, STIFF_UNSEEN, STIFF_BEYOND } Stiffness;     /* its steps follow it; need not; cannot */
Stiffness trace_stiffness(Tracer *t);           /* of springs and dampers at the start of a frame */
real trace_fastest_swing(const Tracer *t);      /* 1/s  of all springs */
real trace_swing_error(const Tracer *t, State *e);      /* m  of errors e, what is an error of such swings' velocity; taken out of e */
/* rows.c */
void trace_kinematics(Tracer *t);               /* contacts, joint rows and free accelerations of the group's present state */
void trace_drives(Tracer *t);                   /* of stops and holds alone, from the joints' rows */
/* NULL: the budget is used up. */
static inline Line *trace_line(Tracer *t, LineKind kind, int owner)
{
    System *s = &t->sys;
    if (s->count == s->capacity) {
        t->fault = "more rows than its budget";
        return NULL;
    }
    Line *l = &s->lines[s->count++];
    l->kind = kind;
    l->owner = owner;
    l->count = l->points = 0;
    l->drift = l->error = l->want = 0;
    return l;
}
static inline bool trace_moves(const Tracer *t, int body) { return body >= 0 && t->g->member[body].moves; }
/* Of a line, for one of its bodies that moves: J, and the torque and M^-1 of G. */
static inline void trace_line_push(const Tracer *t, Line *l, int body, const Arrow *j, const Arrow *g)
{
    const Mass *m = &t->g->mass[body];
    int k = l->count++;
    l->body[k] = body;
    l->j[k] = *j;
    l->gang[k] = g->ang;
    l->m[k] = (Arrow){vec3_scale(m->im, g->lin), mat3_mul_vec(m->ii, g->ang)};
}
bool trace_solve(Tracer *t);                    /* forces for the present kinds, and what they do to the bodies */
bool trace_accelerate(Tracer *t);               /* the same, and the accelerations of contacts, stops and holds */
void trace_read_forces(Tracer *t);              /* of contacts, stops and holds, from the solved rows */
bool trace_movers(const Group *g);              /* is any of its bodies kinematic? */
real trace_gap_acceleration(const Tracer *t, const Touching *c);        /* m/s^2  of any point, by those of the bodies */
void trace_read_accelerations(Tracer *t);       /* these alone, from those of the bodies */
vec3 trace_spin_up(const Tracer *t, int body, vec3 torque);     /* rad/s^2 */
bool trace_project(Tracer *t, bool positions);  /* puts what drifted back on its constraints; false = fault */
typedef struct Violation { real joints, gates; } Violation;
Violation trace_violation(const Tracer *t);     /* m  worst of errors and gaps and (over pace) rates that should be zero */
Row *trace_row(const Tracer *t, int joint, int slot);
real trace_row_rate(const Tracer *t, const Row *r);
real trace_row_acceleration(const Tracer *t, const Row *r);
/* patch.c: rows of one contact, from its first touching point on */
void trace_patch(Tracer *t, int first, bool forces, bool positions);
/* kinds.c */
bool trace_kinds(Tracer *t, bool first);        /* who presses, sticks, slides; first: in this frame */
bool trace_jerk(Tracer *t);                     /* velocities that others left apart, put right where what presses only pushes; false = fault */
void trace_sides(Tracer *t);                    /* which motors and dry frictions hold their speed, which push with their bound */
real trace_acceleration_scale(const Tracer *t); /* m/s^2 */
void trace_align(Tracer *t);                    /* slip directions of one patch */
/* slip.c */
bool trace_slow_slip(const Tracer *t, const Touching *c, real h);       /* friction alone would turn it, or end it, within h */
bool trace_any_slow_slip(const Tracer *t, real h);
real trace_short_of_turns(const Tracer *t, real h);     /* s  h, or less: up to where a slip that turns as it ends can be followed */
bool trace_hold_slow_slips(Tracer *t, real h, bool aim);        /* in their direction, with a row across each; false = fault */
real trace_held_most(const Tracer *t);          /* > 1: at the end of the tried step one should have turned */
/* stay.c */
void trace_note_rows(Tracer *t, bool regular);  /* they were built and factored just now */
bool trace_rows_stay(Tracer *t);                /* they are those that were noted; of the present state but for rounding */
/* again.c */
bool trace_again(Tracer *t);                    /* the forces that contacts have are right now, too; and accelerations are by them */
bool trace_joints_again(Tracer *t);             /* at a frame's start, the same of joints alone: to what the tolerance allows */
/* flow.c */
extern const real dormand_prince[STAGES][STAGES - 1];       /* its last row: the weights of the fifth order */
extern const real dormand_prince_dense[STAGES];
void trace_keep_angles(Tracer *t);                      /* here a step begins */
void trace_load(Tracer *t, const State *y, real time);  /* into the group */
void trace_store(Tracer *t, State *y);                  /* from the group */
void trace_refine(Tracer *t, const State *y);   /* angular velocities to the last digit */
void trace_keep(Tracer *t, int stage);          /* rates and powers of the present state, as evaluated */
void trace_follow(Tracer *t);                   /* slip directions of the present velocities */
bool trace_rate(Tracer *t, const State *y, real time, int stage);
bool trace_steady(const Tracer *t, real h);     /* does a step look as if its forces were constant? */
void trace_parabola(Tracer *t, real h);         /* a step whose forces are those at its start throughout, untried */
real trace_try(Tracer *t, real h);              /* one step from y to y1; its error over the tolerance; INFINITY = fault */
bool trace_stretch(Tracer *t, real more);       /* the tried step by so little, s; false: that is not little */
void trace_dense(const Tracer *t, real part, State *out);   /* y .. y1 at a part of the tried step */
void trace_cut(Tracer *t, real part);
Pos  trace_place(const Tracer *t, int body, real part, bool turned);    /* the same of one body; turned: its rotation, too */
/* happen.c */
real trace_aim(const Tracer *t, real h);        /* s  to just past where the first open gate will meet; h: none will before */
Event trace_scan(Tracer *t);                    /* the first event of the tried step */
real trace_unseen(Tracer *t, const Event *e);   /* < 1: something passes through something before that event; make a step of this part of it */
/* Cuts the tried step at it: y1, t->h; returns 0. Else the error of the cut step, in tolerances, which is more than may be, or no number; INFINITY: it
 * cannot be taken at all. */
real  trace_stop_at(Tracer *t, const Event *e);
/* bond.c: joints that break */
void trace_bonds(Tracer *t);                    /* lists them */
real trace_load_on(const Tracer *t, int joint); /* N  now; of types with a share, that */
void trace_part(Tracer *t, const Event *e);     /* lets go what the event broke */
/* bounce.c */
bool trace_bounce(Tracer *t);                   /* after a blow: what follows in closed form, if it can be; false = fault */
/* trace.c */
void trace_scales(Tracer *t);                   /* lengths, speeds and the tolerance, of its group */
void trace_begin(const Tracer *t);              /* its group is set to be traced */
/* touch.c */
bool trace_touch(Tracer *t, bool first);        /* contacts of the present state; sets dirty when what touches has changed */
bool trace_items(Tracer *t);                    /* joints and contacts in the order of the rows */
bool trace_missed(const Tracer *t, int *over);  /* is something deep in something that was not watched, or has it got over an edge? over: at that contact */
bool trace_presses(const Tracer *t, int contact);
/* pass.c */
/* Does a mover press something against what does not move? Steps up to there would get ever shorter: that is the fault then. */
bool trace_squeezed(Tracer *t);
bool trace_start(Tracer *t);                    /* lists joints and contacts of the present state; false = fault */
bool trace_may_pass(const Tracer *t);
bool trace_pass(Tracer *t);                     /* sweeps past the present time, and starts there; false = fault there */
/* energy.c */
void trace_mark_energy(Tracer *t);
bool trace_mirrored(const Tracer *t);           /* are velocities off the joints at the start of the frame by the way before alone? */
void trace_mark_motion(Tracer *t);              /* of each mechanism, before they are put right... */
bool trace_hold_motion(Tracer *t);              /* ...and after it: what that took is given back; false: it is too much */
void trace_hold_energy(Tracer *t);
/* book.c */
dig_status trace_reserve(Tracer *t);
void trace_remember(Tracer *t);                 /* into the points' memories */
void trace_mean(Tracer *t);                     /* means of forces and powers over the tried step */
void trace_book(Tracer *t, const Touching *touch, int count, real begin);   /* them into the group; the contacts of that step */
void trace_finish(Tracer *t);                   /* what the world wants to know of the frame */

/* Is no more than that near, and was none of it touched? Asked of what moves in closed form. */
static inline bool trace_untouched(const Group *g, int most)
{
    for (int i = 0; i < g->pair_count && g->pair_count <= most; i++)
        if (g->pairs[i].was_touching || g->pairs[i].contacts != 1)
            return false;
    return g->pair_count <= most;
}

/* What was found near, and is not met, is left behind: the next step looks anew. */
static inline void trace_leave_pairs(Group *g)
{
    for (int i = 0; i < g->pair_count; i++) {
        g->contacts[g->pairs[i].contact].live = false;
        g->contacts[g->pairs[i].contact].manifold.count = 0;
    }
}

#endif
