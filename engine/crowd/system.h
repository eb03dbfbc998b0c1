/* crowd/system.h - what the files of this room share.
 *
 * Floor: crowd. Includes base, math, geom, world, solve.
 */
#ifndef DIG_CROWD_SYSTEM_H
#define DIG_CROWD_SYSTEM_H

#include "solve/group.h"

/* ---- sets of instructions ---- */

/* Loops over many are compiled for each of these, from one text, and the widest is taken that the machine has. None fuses operations or puts
 * them in another order: the bits are the same. */
typedef enum Width { WIDTH_ANY, WIDTH_PLAIN, WIDTH_AVX2, WIDTH_AVX512 } Width;

#if defined(__x86_64__)
#define AVX2   __attribute__((target("avx2")))
#if defined(__clang__)
#define AVX512 __attribute__((target("avx512f,avx512vl,avx512bw,avx512dq")))
#else
#define AVX512 __attribute__((target("avx512f,avx512vl,avx512bw,avx512dq,prefer-vector-width=512")))
#endif
static inline Width widest(void)
{
    bool most = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
                __builtin_cpu_supports("avx512dq");
    return most ? WIDTH_AVX512 : __builtin_cpu_supports("avx2") ? WIDTH_AVX2 : WIDTH_PLAIN;
}
#else
#define AVX2
#define AVX512
static inline Width widest(void) { return WIDTH_PLAIN; }
#endif

/* Makes of `part`, which is inlined, the function name(crowd): that part for the crowd's width. */
#define FOR_WIDTHS(name, part) \
    static void name##_plain(void *context, int thread, int threads) { part(context, thread, threads); } \
    AVX2 static void name##_avx2(void *context, int thread, int threads) { part(context, thread, threads); } \
    static TeamPart *name(const Crowd *c) { return c->width >= WIDTH_AVX2 ? name##_avx2 : name##_plain; }

/* ---- wide numbers: sixteen rows side by side ---- */

#define LANES 16                /* of a batch                                                  */
#define HALF  8                 /* so many rows are put together; of those alike, two such lots are a batch (rows.c) */
#ifndef AT_ONCE
#define AT_ONCE HALF            /* lanes that are computed at once: all where registers are that long (wide16.c) */
#endif
typedef float   wide __attribute__((vector_size(AT_ONCE * sizeof(float))));
typedef int32_t wide_int __attribute__((vector_size(AT_ONCE * sizeof(int32_t))));

typedef union Wide {            /* a number of each row                                        */
    float at[LANES];
    wide  own;                  /*      those that are computed at once: by a pointer that may be half way into a batch's */
} Wide;

/* A body as the rows see it: six scaled coordinates, linear then angular, and two that fill the line. */
#define SIX 8
typedef struct Six { float at[SIX]; } Six;

typedef struct WidePoint {      /* contact points, one a lane                                  */
    Wide mass;                  /* kg   1 / (J M^-1 J^T); 0 = no point in this lane; before that 1, 0 */
    Wide gap, now;              /* m    at the start of the step; at that of the substep       */
    Wide room;                  /* m/s  at which a gap may still close in this substep         */
    Wide j, sum;                /* N s  impulse of this substep, of the whole step             */
    Wide borne;                 /* N s  part of j that a soft row does not yield to            */
    Wide rate_before;           /* m/s  normal velocity at the start of the step               */
} WidePoint;

typedef struct WideArms {       /* what spins add to the rate of a point: nothing where contacts are round */
    Wide a[3], b[3];            /* 1/sqrt(kg)  angular Jacobian in scaled spins; until wide.c prepares it m, from the centres of mass */
} WideArms;

typedef struct WideRub {        /* friction of a round contact, as a vector across the normal  */
    Wide a, b;                  /* 1/sqrt(kg)  its arms in scaled spins; until wide.c prepares it m, from the centres of mass along the normal */
    Wide mass;                  /* kg   the same in all directions                             */
    Wide j[3], sum[3];          /* N s                                                         */
} WideRub;

typedef struct WidePatch {      /* friction of one contact, at the middle of its points; all but t and j by wide.c */
    Wide t[3];                  /*      first tangent; the second is n x t                     */
    Wide ta[3], tb[3], ua[3], ub[3];
    Wide ktt, kuu, ktu, det;    /* kg   inverse of the 2 x 2 tangential matrix, times det; 1 / det */
    Wide step;                  /* kg   1 / its largest eigenvalue                             */
    Wide j[2], sum[2];          /* N s                                                         */
} WidePatch;

typedef struct WideTwist {      /* friction about the normal, of contacts of several points; all but j by wide.c */
    Wide a[3], b[3], mass;
    Wide reach;                 /* m    mean distance of the points from the middle            */
    Wide j, sum;                /* N m s  of this substep; of the whole step, by a mover       */
} WideTwist;

typedef struct WideRoll {       /* rolling resistance                                          */
    Wide sa[9], sb[9];          /*      S of the bodies, row by row                            */
    Wide k[6];                  /* kg m^2  inverse of I_a^-1 + I_b^-1: xx xy xz yy yz zz       */
    Wide drive[3];              /* rad/s of movers                                             */
    Wide lever;                 /* m    |torque| <= lever * normal force                       */
    Wide j[3];                  /* N m s                                                       */
} WideRoll;

typedef struct WideContact {    /* contacts, one a lane                                        */
    Wide n[3];                  /*      from a to b                                            */
    Wide ra, rb;                /* 1/sqrt(kg)  roots of the inverse masses; wide.c             */
    Wide friction, restitution;
    Wide care;                  /* s/m  one over the error of a rate that does not matter: passes that change less need no other; rows.c */
} WideContact;

typedef struct Batch {          /* up to sixteen contacts that share no moving body            */
    int32_t a[LANES], b[LANES]; /*      Six of each body; who does not move has a spare one, wide.c */
    int  points;                /*      most points of a lane                                  */
    int  halves;                /*      lots of eight contacts in it: 1, or 2 that are alike   */
    int  whole;                 /*      lanes with as many points                              */
    bool fixed;                 /*      one side of each contact does not move                 */
    bool rubs, rolls, driven, bounces;          /* one of them does                            */
    bool shares;                /*     several points carry the load of each                   */
    bool round;                 /* one point each, straight before the centres of balls: it turns none of them, and friction turns them alike
                                 * in all directions. Points have no arms then, and friction is in rub */
    WideContact *of;
    WidePoint *point;           /* after that                                                  */
    WideArms  *arms;            /* of the points, which they come after; NULL: round           */
    Wide      *drive;           /* m/s  parts of the rates of points, then of friction, that movers give, and rad/s of the twist; NULL: no movers */
    WidePatch *patch;           /* NULL: no friction, or round                                 */
    WideRub   *rub;             /* NULL: no friction, or not round                             */
    WideTwist *twist;           /* NULL: one point each, or no friction                        */
    WideRoll  *roll;            /* NULL: no rolling resistance                                 */
} Batch;

/* How contacts carry a load: balls at a point that stays theirs, others at a point alone, several points together. */
typedef enum Bearing { BEARS_ROUND, BEARS_ALONE, BEARS_SHARED, BEARINGS } Bearing;
static inline Bearing bearing_of(const Batch *b) { return b->round ? BEARS_ROUND : b->shares ? BEARS_SHARED : BEARS_ALONE; }

typedef struct Soft {           /* how a pass corrects overlap                                 */
    float rate;                 /* 1/s  overlap lost per time                                  */
    float mass, keep;           /* 1    share of the effective mass; share of the impulse given up */
} Soft;

typedef struct Frame {          /* a moving body at the start of the step                      */
    real root;                  /* 1/sqrt(kg)                                                  */
    bool held;                  /* some row acts on it                                         */
} Frame;

/* What contacts ask of a body. In the group's members it would lie far apart: those of thousands of bodies fit no cache, these do. */
typedef struct Trait {
    real travel, pull;          /* m, m/s^2  as in Member                                        */
    bool moves, kinematic, dormant, round;
} Trait;

/* How the step moves what is fixed to a body. */
typedef struct Carriage { mat3 turn; vec3 from, to; real way; } Carriage;     /* centre of mass, before and after; m  what its travel grows by */

/* Batches of one colour: no moving body is in two of them, unless they are done one after the other, alone. */
typedef struct Phase { int first, count; bool alone; } Phase;

#define PASSES_MOST 32

#define SHALLOW 2.0             /* times what a pass needs to change: overlap so small is left; so much more takes one more pass */

#define SHARED_LEAST 4          /* batches: fewer are not worth a meeting                      */

/* The batches of a phase that are a thread's. */
static inline bool phase_shared(Phase x) { return !x.alone && x.count >= SHARED_LEAST; }
static inline int phase_first(Phase x, int thread, int threads)
{
    return x.first + (phase_shared(x) ? team_first(x.count, thread, threads) : thread == 0 ? 0 : x.count);
}
static inline int phase_end(Phase x, int thread, int threads)
{
    return x.first + (phase_shared(x) ? team_end(x.count, thread, threads) : x.count);
}

typedef struct Crowd {
    Group *g;
    Team  *team;                /* g's                                                         */
    Width  width;
    real   dt;
    int    substeps;
    float  h;                   /* s   of a substep                                            */
    int    bodies;              /* moving ones; spare ones for each thread come after them     */
    Trait *trait;               /* [body_count of g]                                           */
    Frame *frame;
    Six   *vel, *move;          /* scaled velocity; scaled displacement since the start        */
    Six   *start;               /* velocity at the start of the step                           */
    Six   *last, *push;         /* velocity at the last substep's start; change by forces per substep */
    Six   *axes[2];             /* spin = s * scaled spin: columns of s, root                  */
    Carriage *carriage, *others;    /* at the end of the step: of moving bodies, in the place of last, push and axes; of the group's others */
    real  *lost;                /* [blocks] J  kinetic energy of a block of bodies, and the work of forces on it, less what it has in the end */
    real  *farthest;            /* [blocks] m  that one of them went                           */
    int    blocks;
    Batch *batch; int batches;
    Spare *idle;                /* of g's, for rows: nobody asks for them after the piece      */
    int   *row;                 /* [contact_count of g] LANES times its batch, and its lane; < 0: it does not act */
    bool   alone;               /*     in one piece, and most of the world: Acted are known by row          */
    bool   presses;             /*     a mover that moves presses something: see warm_most() */
    real   deep, load;          /* 1    deepest overlap, in changes that matter (rows.c); that of the fourth deepest contact */
    real   sags, shared;        /* 1    the same of contacts of which several points share the load                         */
    Phase *phase; int phases;
    Soft   soft[PASSES_MOST][BEARINGS][2];      /* by how many passes there are; is one side of a contact fixed */
    int    pieces;              /* that its step is cut into                                  */
    real   firm;                /* 1    of all but balls: see crowd_pieces()                   */
    const GroupKept *before;    /*     the step's start, to sweep it should something pass through something; NULL: nothing may, or they are too many */
    int    passes, passes_most; /* of a substep, at first; never more                          */
    bool   settles;             /*     it is about to come to rest                             */
    int    separations;         /* passes at most that put deep overlap apart at the end of the step */
    bool   lifts;               /*     they do it where several points share a load, too                    */
    float  leaves;              /*     what they leave of it, as SHALLOW                       */
    float *worst[2];            /* [threads] error of rates over what matters; of this pass, of the one before */
    real  *stop;                /* [body_count of g] m/s  by how much an impact in this step may change its speed; NULL: there is none */
    real   finest, thinnest;    /* m   size of the smallest solid in a pair; least thickness of a pair */
    float  push_most;           /* m/s  at which overlap is corrected at most                  */
    float  bounce_least;        /* m/s  slower approaches do not bounce                        */
} Crowd;

/* A thread's body that is nobody's, in a cache line of its own; with the number of threads: how many there are in all. */
static inline int crowd_spare(const Crowd *c, int thread) { return c->bodies + 1 + 2 * thread; }

/* touch.c: contacts of the present poses; points carried on at the end of the step */
dig_status crowd_touch(Crowd *c);
real       crowd_closing(const Group *g, const GroupContact *t, const ManifoldPoint *p, real *speed);      /* m/s  of a point */
void       crowd_sign(const Group *g, GroupPair *q);                     /* if its points span an area */
static inline vec3 crowd_velocity(const Group *g, int body, vec3 at)
{
    return vec3_add(g->vel[body].v, vec3_cross(g->vel[body].w, vec3_sub(at, g->pos[body].x)));
}
/* 1  So many points of a contact carry a load in only one way: one, or the two ends of the line that a cylinder or capsule lies on. */
static inline int crowd_alone(const GroupPair *q) { return q->on_a->shape.rolling > 0 || q->on_b->shape.rolling > 0 ? 2 : 1; }
/* m  Of the thinner of a pair, at most its size; planes and meshes have none. What overlaps by half of it may come out at the far side. */
static inline real crowd_thickness(const GroupPair *q)
{
    real a = q->on_a->shape.inner > 0 ? q->on_a->shape.inner : INFINITY, b = q->on_b->shape.inner > 0 ? q->on_b->shape.inner : INFINITY;
    return real_min(q->size, 2 * real_min(a, b));
}
/* pieces.c: into how many pieces this step is cut, each with contacts of its own, and how much of their frequency springs have then */
dig_status crowd_pieces(const Crowd *c, int *pieces, real *firm);
/* through.c: may few that are thin pass through each other in a step of so many pieces; did any in this one? Of many, what passed through a wall
 * is put back to it; of few, too, what crossed a mesh. Between bodies_close() and book_close() */
bool       crowd_may_pass(const Crowd *c, int pieces);
bool       crowd_passed(const Crowd *c);
dig_status crowd_hold_back(Crowd *c);
/* bodies.c */
dig_status bodies_open(Crowd *c);       /* scaled, from the group's */
void       bodies_close(Crowd *c);      /* and back */
real       bodies_farthest(const Crowd *c);     /* m  that one went, as Member.travel grows */
void       body_hold_back(Crowd *c, int body, real part, vec3 carried);     /* 1, m  it gets no farther than this part of its way, and is carried then */
void       bodies_spare(const Crowd *c);        /* then what they had but for carriages is spare */
mat3       body_axes(const Crowd *c, int body);         /* s, of the pose at the start */
static inline int crowd_index(const Crowd *c, int body) { return body < c->bodies && c->trait[body].moves ? body : c->bodies; }
static inline Carriage *carriage_of(const Crowd *c, int body) { return body < c->bodies ? &c->carriage[body] : &c->others[body - c->bodies]; }
/* rows.c: which contacts act, in batches */
dig_status rows_open(Crowd *c);
/* wide.c: the substeps */
void       wide_solve(Crowd *c);
void       wide_solve_longest(Crowd *c);       /* wide16.c: the same, where registers hold sixteen numbers */
/* bounce.c: takes so much of the bounces just made as the energy before them allows */
void       bounce_share(Crowd *c);
/* J  bounce.c: given by movers in this piece */
real       crowd_work_of_movers(const Crowd *c);
/* book.c: forces, points, impacts and energy for the group's records; of a piece, and of the whole step after it */
dig_status book_close(Crowd *c);
void       book_step(const Crowd *c);

#endif
