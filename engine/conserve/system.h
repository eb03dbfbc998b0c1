/* conserve/system.h - the equations of one energy-momentum step, and their direct sparse solve.
 *
 * Unknown are the poses at the end of a step of length h and the impulses p of the joints. With the Cayley vector
 * c = 2 vec(q0* q) / scal(q0* q) of each body's turn, in its own axes,
 *
 *     v = 2 (x - x0) / h - v0,        W = 2 c / h - W0                        (W body axes: implied end velocities)
 *     m (v - v0)         = h f   + sum of p J_lin
 *     R I W - R0 I W0    = h tau + sum of p J_ang
 *     C(end) = 0  for hard rows,      p = -h (k (C + C0) / 2 + c (C - C0) / h)  for springs and dampers (dampers: see begin_damper)
 *
 * where J is the discrete gradient of C: J . (x - x0, R c) = C - C0 exactly. Every C here is a product of two vectors fixed in
 * bodies, or a length, or an angle; for products it is the derivative with every vector replaced by the mean of its start and
 * end. Joints then do no work, springs give back what they took, and equal and opposite forces act in one line: energy,
 * momentum and angular momentum are conserved to the tolerance of the solve.
 *
 * Sources: Simo & Wong 1991 (Int. J. Num. Meth. Eng. 31, 19), Gonzalez 1996 (J. Nonlinear Sci. 6, 449; discrete gradients),
 * Betsch & Steinmann 2002 (Multibody Syst. Dyn. 8, 367; end positions on the constraints). The solve keeps bodies and joints
 * as nodes of one graph, ordered by least degree as in Baraff 1996 (SIGGRAPH, 137): linear in the length of a chain.
 *
 * Floor: conserve. Includes base, math, solve.
 */
#ifndef DIG_CONSERVE_SYSTEM_H
#define DIG_CONSERVE_SYSTEM_H

#include "solve/group.h"

#define TIE_ROWS 6              /* rows of one joint that can act at once */
#define BLOCK_ROWS TIE_ROWS     /* of a node: 6 of a body, at most as many of a joint */

typedef enum PartKind { PART_POINT, PART_LINE, PART_NORMAL, PART_LENGTH, PART_TWIST } PartKind;

/* Up to three rows of a joint that have one formula. */
typedef struct Part {
    PartKind kind;
    int  at, rows;              /* first row in its tie, how many: 3 for a point, else 1 */
    int  slot;                  /* of the first row             */
    bool soft;
    real stiffness, damping;
    int  turn;                  /* TWIST: about which axis of the joint, see joint_turned */
    vec3 in_a, in_b;            /* LINE: direction in b; NORMAL: a direction in each; body axes */
    real offset;                /* m, 1 or rad  C = coordinate - offset */
    real start;                 /* C at the start of the step   */
    real late, damper, rate;    /* 1, damping in this step, dC/dt at the start: see begin_damper */
} Part;

/* A joint, taken apart. */
typedef struct Tie {
    int  joint;                 /* of the group                 */
    int  a, b;                  /* pieces                       */
    int  part, parts;           /* its parts                    */
    int  rows, row;             /* its rows, the first of them  */
    bool hard;                  /* has a hard row               */
    bool coupled;               /* the force on one end depends on the other's pose */
    vec3 ra, rb;                /* m   anchors, body axes       */
    quat fa, fb;                /*     frames, in body axes     */
    real mid[TIE_ROWS][12];     /* discrete gradient: linear and angular of a, then of b */
    real end[TIE_ROWS][12];     /* gradient at the end          */
    real error[TIE_ROWS];       /* what must vanish             */
    real give[TIE_ROWS];        /* m/(N s) and the like: compliance of the row */
} Tie;

#define PULLS 4                 /* steps of a composed part that others come after */

/* A body; the last one is the world. */
typedef struct Piece {
    bool moves;
    real mass, reach;           /* kg, 5 tr I = scale of angular residuals */
    mat3 inertia, inv_inertia;  /* body axes                    */
    vec3 x0, v0, w0;            /* at the start; w0 body axes   */
    quat q0; mat3 r0;
    vec3 p0, l0;                /* N s, N m s  momenta at the start with the impulses of outer forces added */
    vec3 x; quat q; mat3 r;     /* at the end                   */
    vec3 turn;                  /* rad Cayley vector, world axes */
    vec3 w;                     /* rad/s implied, body axes     */
    vec3 push, twist;           /* N s, N m s  by joints        */
    vec3 pull[PULLS], wrench[PULLS];    /* N, N m  the same over each step since the part began */
} Piece;

typedef struct Block { int at, stride; } Block;         /* in System.value */

typedef struct Elimination {    /* one node, in order           */
    int node, size;
    int diagonal, lower, upper; /* in value                     */
    int width;                  /* rows of all its later neighbours together */
    int first, count;           /* its later neighbours: in later[], and their pairs in target[] */
    int pair;
} Elimination;

typedef struct Exchange {       /* of a diagonal block, decomposed: its rows in order, and 1 over the diagonal */
    int  row[BLOCK_ROWS];
    real inverse[BLOCK_ROWS];
} Exchange;

typedef struct Later { int node, size, column; } Later;

typedef struct TieBlocks { Block ja[2], aj[2], ab, ba; } TieBlocks;

typedef struct System {
    Group  *g;
    real    h;
    int     piece_count, tie_count, part_count, row_count;
    Piece  *piece;              /* [body_count + 1]             */
    Tie    *tie;
    Part   *part;
    real   *p;                  /* impulses, [row_count]        */
    real   *p_last;             /* of the last good step, per second */

    /* order.c: symbolic */
    int     node_count;         /* moving pieces, then ties     */
    Elimination *order;
    int    *position;           /* of a node in order           */
    Later  *later;
    Block  *target;             /* what eliminating a node changes */
    TieBlocks *blocks;
    int     value_count;
    real   *value;              /* the matrix, then its factor  */
    Exchange *exchange;         /* [node_count], in order       */
    real   *side;               /* right-hand side, then the solution; 6 per node */

    int     pulls;              /* steps since the part began: of which there are pulls */
    real    pulled[PULLS], since;       /* s  the middles of these; the end of the last */
    bool    smooth;             /* and the next is like them    */
    bool    rings;              /* of hard ties                 */
    real    residual;           /* m                            */
    bool    precise;            /* solve to rounding            */
    bool    lends;              /* others end with the factor of the iteration before */
    bool    resting;            /* solve for velocities at fixed poses */
    bool    yields;             /* springs and dampers answer to those, over h */
    bool    unplaced;           /* no poses obey the joints     */
} System;

/* romberg.c: runs over one frame step in 2, 4, 8, ... parts, extrapolated to infinitely many (Romberg's table) */
#define ROMBERG_ROWS 6

typedef struct Moved { vec3 x, turn, v, w; } Moved;     /* m, rad  since the start of the frame; velocities at its end */

typedef struct Romberg {
    int    rows, bodies;
    real   error;               /* m   estimate, of places; INFINITY: of one run there is none */
    Moved *last;                /* [ROMBERG_ROWS][bodies]  the last row, one column after the other */
    real   lost[ROMBERG_ROWS];  /* J   the same */
} Romberg;

dig_status romberg_open(Romberg *r, const Group *g);
void   romberg_enter(Romberg *r, const Group *g, const GroupKept *from);       /* a finished run, of twice as many parts as the last */
void   romberg_take(const Romberg *r, Group *g, const GroupKept *from);        /* the best there is becomes the group's */

/* parts.c */
bool   parts_understood(const Group *g);        /* every row of every joint has its formula here, and no stop is near */
dig_status parts_compile(System *s);
void   parts_begin(System *s);                  /* start of a step: C0, spring numbers         */
void   parts_guess(System *s);                  /* adds what the impulses of the rows would do to the pieces at the start */
void   parts_evaluate(System *s);               /* at the end poses: rows, errors, forces      */
bool   parts_turn_over(const System *s, bool rigid);        /* does a spring point the other way than at the start? rigid: one that is as long as it was */
void   parts_push(System *s, const real *p);    /* what impulses do to the pieces, at fixed poses */
real   parts_across(const System *s, const Tie *t);     /* J  of the motion across its hard rows, one by one  */
void   parts_give(const System *s, Tie *t);     /* compliance of its hard rows at the end poses */
void   parts_stiffness(const System *s, const Tie *t, real k[12][12]);  /* derivative of the forces by the end poses */
void   parts_bend(const System *s, const Tie *t, mat3 *a, mat3 *b);     /* the same if not coupled: of the torques by the turns */

/* order.c */
dig_status order_make(System *s);
Block  order_diagonal(const System *s, int node);

/* factor.c */
bool   factor_solve(System *s);                 /* value, side -> its factor, the solution; false: a pivot vanished */
void   factor_again(System *s);                 /* another side -> its solution, by that factor */

/* newton.c */
bool   newton_step(System *s);                  /* from x0, q0, v0, w0 to the end of h */
bool   newton_place(System *s);                 /* poses that obey the joints, moved as little as possible */
bool   newton_clean(System *s);                 /* velocities that obey the joints, changed as little as possible */

/* step.c */
dig_status step_open(System *s, Group *g);      /* joints taken apart, order made              */
bool   step_place(System *s);                   /* poses that obey the joints                  */
bool   step_clean(System *s);                   /* velocities that obey the joints: a plastic blow */
dig_status step_settle(System *s);              /* velocities that obey the joints where they are far off them, of the same energy and momenta */
dig_status step_single(System *s, bool *done);  /* a step of s->h; *done: it converged, and is booked */
bool   step_watch(Group *g, bool last);         /* angles unwind; false: a stop was met        */
void   step_begin(System *s);                   /* poses, velocities and outer impulses; kinematic bodies go where they are driven */
bool   step_write_pose(const System *s, int i); /* of piece i, to its group; false: its velocity is not the step's */
real   step_kinetic(const System *s);           /* J  of the pieces' start velocities */
real   step_fastest_spin(const Group *g);       /* rad/s                                       */
void   step_remember(System *s);                /* joint forces for reports, and as the next first guess; joints are viewed */

/* rough.c */
#define LEVELS 14               /* halvings of a part of the step                              */

int    rough_budget(const Group *g);            /* iterations that one step may take before the group is handed on */
dig_status rough_run(Group *g, real dt, System *s, const char **why);   /* to the end of the frame; *why: it could not */

#endif
