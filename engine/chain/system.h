/* chain/system.h - what the files of this room share.
 *
 * Floor: chain. Includes base, math, solve, world.
 */
#ifndef DIG_CHAIN_SYSTEM_H
#define DIG_CHAIN_SYSTEM_H

#include "solve/group.h"

#define TIE_ROWS  3             /* of a joint                           */
#define LINK_ENDS 8             /* most joints of a body                */
#define LINK_ROWS (LINK_ENDS * TIE_ROWS)

/* A joint keeps two points together. */
typedef struct Tie {
    int  joint;                 /* of the group                         */
    real h;                     /* s    of the substep                  */
    int  link[2];               /* of a and b; < 0 = it does not move by itself */
    vec3 fixed;                 /* m    the point of such an end, at the end of the substep */
    vec3 arm;                   /* m    from its body to it, mean of the substep */
    vec3 p;                     /* N s  on a, of this substep           */
    real change[TIE_ROWS];      /*      of p by the last iteration      */
    vec3 error;                 /* m    C = pa - pb at the end          */
    vec3 impulse, twist[2];     /* N s  on a; N m s  on a, on b: of all substeps so far */
} Tie;

/* One end of a joint, at a body that moves. */
typedef struct End {
    int  tie;
    int  child;                 /* the link beyond, whose front passes its remains on to here; < 0 = none */
    int  at;                    /* first row in the body's front        */
    real side;                  /* 1 at a, -1 at b                      */
    vec3 arm;                   /* m  from the centre of mass, body axes */
    vec3 r0, r;                 /* m  the same in world axes, at the start and the end */
} End;

/* A body that moves, in its place in the tree. Its ends are in the order of elimination: the one towards the root is the last. */
typedef struct Link {
    int  body;
    int  end, ends;
    int  rows, passed;          /* of the front; of them left to the link towards the root */
    int  front;                 /* first of its numbers in Chain.number: rows x (rows + 1), the last column is the right-hand side */
    int  turn;                  /* first of its columns in Chain.turn   */
    real mass;
    mat3 inertia;               /* body axes                            */
    vec3 x0, v0, w0; quat q0; mat3 r0;      /* at the start; w0 body axes */
    vec3 p0, l0;                /* N s, N m s  momenta at the start with the impulses of outer forces added */
    vec3 x, v, w; quat q; mat3 r;           /* at the end; w body axes, implied by the turn */
    vec3 c;                     /* rad  Cayley vector, body axes        */
    vec3 loose;                 /* rad  turn of this iteration if no joint acted */
} Link;

/* A tree of bodies. */
typedef struct Linkage { int first, links; } Linkage;         /* of the links: the root, then each after the one it hangs on */

typedef struct Chain {
    Group *g;
    real   h, k;                /* s; 1  weight of the end velocity     */
    Link  *link; int links;
    End   *end;  int ends;
    Tie   *tie;  int ties;
    Linkage  *tree; int trees;
    real  *number;
    vec3  *turn;                /* rad/(N s)  inverse angular slope times the lever of a row, body axes */
    real   error;               /* m  largest of the last substep       */
    real   enough;              /* m  at which an iteration is the last */
} Chain;

/* Each joint belongs to the link nearer to the root, or to its only one. */
static inline bool link_owns(const Link *l, int end) { return !l->passed || end < l->ends - 1; }

/* tree.c: the group's joints as trees. *fits: they are */
dig_status tree_make(Chain *c, bool *fits);
/* solve.c: one step of a tree; false: no solution was found */
bool tree_step(Chain *c, const Linkage *t);

#endif
