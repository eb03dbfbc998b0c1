/* solve/direct.h - the direct solve of a group's rows: what its files share.
 *
 * Floor:  solve.
 */
#ifndef DIG_DIRECT_H
#define DIG_DIRECT_H

#include "solve/blocks.h"
#include "solve/direction.h"

/* Where the impulse of a row may lie. */
typedef enum Set {
    SET_CONE,                   /* normal >= 0, |tangent| <= mu normal                             */
    SET_DISC,                   /* normal >= 0, |tangent| <= bound, which follows from outside     */
    SET_BALL                    /* |all three| <= bound                                            */
} Set;

typedef enum Held { HELD_NOT, HELD_NORMAL, HELD_ALL, HELD_SLIPS } Held;     /* how an impulse answers to its velocities */

/* A contact point (normal, two tangents), or rolling resistance (three spins). */
typedef struct Triple {
    int  place[2];              /* of bodies a and b in the matrix; < 0: does not move             */
    int  index;                 /* of the group's points, or rolls                                 */
    Set  set;
    real j[3][12];              /* Jacobian: v and w of a, of b                                    */
    real r;                     /* 1/kg  compliance of the augmented Lagrangian                    */
    real target[3];             /* m/s */
    real mu, bound;
    real lift;                  /* m/s   De Saxce's: mu times the slip                             */
    real lift_before, slip_before;  /* m/s  the lift of the round before, and what it led to; no number = none */
    real start[3];              /* N s   already in the velocities                                 */
    real prox[3], force[3];     /* N s   of the last round, and now                                */
    real rate[3], change[3];    /* m/s   J v, and J dv                                             */
    real w[9];                  /* d force / d wish                                                */
    Held held, factored;        /* now, and in the factor                                          */
} Triple;

/* A row of a joint. */
typedef struct Single {         /* what is read most comes first                                   */
    real rate, change;
    real target, lo, hi;
    real r;                     /* compliance: of the augmented Lagrangian, or a spring's own      */
    real prox, force, start;    /* as of a triple                                                  */
    bool bounded, soft;         /* the impulse has a bound; it is a spring's                       */
    bool answers, factored;     /* the force follows the velocities: it is not at a bound          */
    int  row;                   /* of the group's                                                  */
    int  count, place[ROW_BODIES];
    real j[ROW_BODIES][6];
} Single;

/* What the force of a row with a bound is along dv: the nearest value in its range to wish - along by. */
typedef struct Bend { real wish, by, change, lo, hi; } Bend;

typedef struct Direct {
    Group  *g;
    Blocks  blocks;             /* the matrix                                                       */
    bool    based;              /* what is the same in all rounds is in it, and eliminated          */
    Triple *triples; int triple_count;
    Single *singles; int single_count;
    mat3   *stiff;              /* [bodies] kg m^2  h^2 times the geometric stiffness              */
    vec3   *round;              /* [bodies] rad/s  how what floats turns as one: what pulls at it turns along, and does not brake that */
    int    *place;              /* [bodies] < 0: no unknown                                        */
    bool   *narrow;             /* [bodies] it does not turn                                       */
    int    *body;               /* [places]                                                        */
    real   *mass;               /* [places][10]  kg, kg m^2: m and the tensor                      */
    real   *v, *v0, *dv, *grad; /* [6 places]                                                      */
    Bend   *bends; int bend_count;      /* of the present dv                                       */
    real    level, rise;        /* of the slope along dv, at its start and per step: what is straight in it                         */
    bool    projects;           /* positions, not velocities: nothing moves so far */
    bool    slack;              /* no geometric stiffness: nothing is taut, and nothing is to brake what whirls */
    bool    heavy;              /* something in the group is heavy on what is light                 */
    bool    kept;               /* the factor is that of the present sets                          */
    bool    late_lift;          /*       lifts are those of the start: what is wedged in something that gives chases them to infinity */
    bool    inside;             /*       begins from the inside (direct_cone.c); rounds then only let lifts fall                     */
    bool    quits;              /*       a round that ends far from its minimum is the last: there is another way */
    bool    swings;             /* rounds go to and fro: lifts go half the way                      */
    int     factors, rounds, most_factors;
    real    hardened, hardest;  /* 1    compliances over what they were at first, and at last      */
    real    accept;             /* m/s  what is good enough to be taken                            */
    real    unbalanced;         /* m/s  what velocities and impulses differ by                     */
    real    error;              /* m/s  reached                                                    */
} Direct;

/* direct_joints.c: the same for rows of joints, called by what is below */
bool springs_swing(Group *g);                           /* do springs pull so hard that what they hold sways across them faster than sweeps follow? */
bool singles_open(Direct *d);                           /* false: out of memory */
void singles_link(const Direct *d, BlockLinks *of, int *link, bool *late);      /* adds pairs by d->place; late: of rows with a bound */
void singles_changes(Direct *d);
void singles_move(Direct *d, real along);
bool singles_forces(Direct *d);                         /* false: the factor is not of these any more */
void singles_begin(Direct *d);
void singles_free(Direct *d);                            /* forces of what has no bound, or no room in it */
void singles_keep(Direct *d);                            /* forces are the estimates */
void singles_gradient(Direct *d);
void singles_assemble(Direct *d, bool bounded);         /* those with a bound, or those without */
void singles_line(Direct *d);                           /* adds to level and rise, and notes what bends */
real singles_slope(const Direct *d, real along);        /* of what bends */
real singles_off(const Direct *d);
real singles_unmet(const Direct *d);                    /* m/s or rad/s  how far off what they do is, of those without a bound */
void singles_round(Direct *d, real harder);             /* harder: times the compliance of what has a bound */
void singles_write(Direct *d);                          /* impulses and velocities into the group */
bool stiffness_open(Direct *d);                         /* false: out of memory */

/* direct.c: kg m^2  of a body, without what taut joints add; false: it has none */
bool direct_tensor(const Group *g, int body, mat3 *tensor);
/* m/s  the change of velocity that the gradient stands for, rims included */
real direct_unbalanced(const Direct *d);

/* direct_cone.c: from the inside: impulses so far, velocities and lifts; convex: without lifts. m/s  how far off they are. */
real direct_inside(Direct *d, bool convex);

/* direct_rows.c */
bool direct_rows(Direct *d);                            /* false: out of memory */
void direct_changes(Direct *d);                         /* what dv does to the rates */
void triples_changes(Direct *d);                        /* of contacts and rolls alone */
void direct_move(Direct *d, real along);                /* takes this part of dv */
void direct_forces(Direct *d);                          /* impulses of the present rates */
void direct_begin(Direct *d);                           /* forces predicted from the first estimate */
void direct_gradient(Direct *d);
bool direct_assemble(Direct *d, bool fresh);            /* fresh: as the forces answer now, else as at the end of the last round; false: no factor */
void direct_line(Direct *d);                            /* before direct_slope() is asked along a new dv */
real direct_slope(const Direct *d, real along);         /* of the merit function, this part of the step on */
real direct_mobility(const Direct *d, const Triple *t); /* 1/kg  effective, mean of the rows */
real direct_off(const Direct *d);                       /* m/s  how far off the estimate is */
/* The impulses are the new estimate, with harder rows if asked. m/s  how far off the last one was; leaves predicted forces. */
real direct_round(Direct *d, bool harden);

#endif
