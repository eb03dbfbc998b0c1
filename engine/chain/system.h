/* chain/system.h - what the files of this room share.
 *
 * Bodies lie four side by side, so that what each does by itself is computed for four of them at once.
 *
 * Floor: chain. Includes base, math, solve, world.
 */
#ifndef DIG_CHAIN_SYSTEM_H
#define DIG_CHAIN_SYSTEM_H

#include "math/four.h"
#include "solve/group.h"

#define TIE_ROWS  3             /* of a joint                           */
#define LINK_ENDS 8             /* most joints of a body                */
#define LINK_ROWS (LINK_ENDS * TIE_ROWS)

/* A joint keeps two points together. */
typedef struct Tie {
    int  joint;                 /* of the group                         */
    int  end[2];                /* of a and b, in lanes of Chain.ends; < 0 = it does not move by itself */
    real h;                     /* s    of the substep                  */
    vec3 fixed;                 /* m    the point of such an end, at the end of the substep */
    vec3 arm;                   /* m    from its body to it, mean of the substep */
    vec3 twist;                 /* N m s  on that body, of all substeps so far */
} Tie;

/* One end of a joint, at each of four bodies that move. A body that has no more of them has 0 for its side. */
typedef struct Ends {
    int   tie[LANES];           /* up to the body's Links.count         */
    int   child[LANES];         /* the link beyond, whose front passes its remains on to here; < 0 = none */
    four  side;                 /* 1 at a, -1 at b                      */
    four3 arm;                  /* m    from the centre of mass, body axes */
    four3 r0, r;                /* m    the same in world axes, at the start and the end */
    four3 p, change;            /* N s  of the joint on its a, of this substep; of that by the last iteration */
    four3 at;                   /* m    its side times the point at the end */
    four3 error;                /* m    C = pa - pb at the end, where the link owns the joint */
    four3 impulse, twist;       /* N s, N m s  on the body, of all substeps so far */
} Ends;

/* Four bodies that move, in their places in the tree. The first end of each is the one towards the root. */
typedef struct Links {
    int   body[LANES];          /* < 0 = none                           */
    int   own[LANES];           /* first end whose joint it owns: 1 where there is one towards the root */
    int   count[LANES];         /* of its ends                          */
    int   end, ends;            /* first of Chain.ends; the most that one of the four has */
    int   front;                /* first of its numbers in Chain.number: rows x (rows + 1), the last column is the right-hand side */
    int   turn;                 /* first of its columns in Chain.turn   */
    four  mass;
    four33 inertia, inverse;    /* body axes                            */
    four3 force, torque;        /* N, N m  from outside                 */
    four3 x0, v0, w0; four_quat q0; four33 r0;      /* at the start; w0 body axes */
    four3 p0, l0;               /* N s, N m s  momenta at the start with the impulses of outer forces added */
    four3 x, v, w; four_quat q; four33 r;           /* at the end; w body axes, implied by the turn */
    four3 c;                    /* rad  Cayley vector, body axes        */
    four3 loose;                /* rad  turn of this iteration if no joint acted */
} Links;

/* A tree of bodies: the root, then each after the one it hangs on. */
typedef struct Linkage { int first, last; } Linkage;            /* of Chain.links */

typedef struct Chain {
    Group *g;
    real   h, k;                /* s; 1  weight of the end velocity     */
    Links *links; int link_count;       /* lanes, the empty ones at the ends of trees among them */
    Ends  *ends;
    Tie   *tie;  int ties;
    Linkage *tree; int trees;
    four  *number;
    four3 *turn;                /* rad/(N s)  inverse angular slope times the lever of a row, body axes */
    real   lost;                /* J  of motion, by the trees so far    */
    real   error;               /* m  largest of the last substep       */
    real   enough;              /* m  at which an iteration is the last */
} Chain;

/* Link n and end n are lanes n % LANES. */
static inline Links *links_of(const Chain *c, int link) { return &c->links[link / LANES]; }
static inline Ends *ends_of(const Chain *c, int end) { return &c->ends[end / LANES]; }
static inline int lane_of(int n) { return n % LANES; }
/* Of a link, towards the root. */
static inline int first_end(const Chain *c, int link) { return links_of(c, link)->end * LANES + lane_of(link); }

/* tree.c: the group's joints as trees. *fits: they are */
dig_status tree_make(Chain *c, bool *fits);
/* solve.c: one step of a tree; false: no solution was found */
bool tree_step(Chain *c, const Linkage *t);

#endif
