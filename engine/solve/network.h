/* solve/network.h - what flows along the branches of a network: heat, later current and water.
 *
 * A node has an effort (K, V, Pa), a branch a flow (W, A, m^3/s). Every branch, whatever is in it, is for given efforts of its
 * ends a line flow = g (xa - xb) + i0 with g >= 0 (Norton). So the matrix is symmetric positive definite and as large as there
 * are unknown efforts, without exchanges and without unknowns for sources. What keeps its effort whatever flows (the air of a
 * room, the earth, a lake) is a boundary: its effort is known, and nothing is connected through it. What hangs together
 * otherwise is a part, solved by itself: its numbers do not depend on what else there is.
 *
 *     C dx/dt = source - sum of flows out
 *
 * Time goes by the backward Euler rule, which is monotone and never rings, or by TR-BDF2 (Bank et al. 1985) with the error
 * estimate of Hosea & Shampine (1996) in as many substeps as the tolerance asks for. What went through each branch is the sum of
 * the very flows of which the efforts were made: what is stored is what came in less what went out, to rounding, whatever the
 * rule and however far the Newton iteration got.
 *
 * Use: network_open; set effort, capacity, source and the ends of branches; network_plan; set what else may change;
 * network_advance or network_settle, which take no memory.
 *
 * Owns:  nothing; all memory is the arena's.
 * Floor: solve. Includes base.
 */
#ifndef DIG_NETWORK_H
#define DIG_NETWORK_H

#include "solve/ldl.h"

typedef struct NetLine { real g, i0; } NetLine;

typedef struct NetBranch NetBranch;
/* The tangent of the branch's law at these efforts; h: s, of the implicit step, INFINITY = at rest. Pure. */
typedef NetLine NetLaw(const NetBranch *b, real xa, real xb, real h);

struct NetBranch {
    int     a, b;               /* flow is positive from a to b; from Network.nodes on: boundaries */
    NetLaw *law;                /* NULL: line, as it is           */
    real    p[4];               /* the law's own                  */
    NetLine line;               /* where it is solved             */
    real    through;            /* flow times s, in the last network_advance */
};

typedef struct NetPart {        /* what hangs together            */
    int  node, nodes;           /* range of Network.member        */
    int  branch, branches;      /* range of Network.order         */
    bool bent;                  /* a branch has a law             */
    bool swept;                 /* solved by iteration: no matrix */
    real passed;                /* s   that the last advance went on: dt, unless there was no solution */
    Ldl  matrix;
} NetPart;

typedef struct Network {
    int   nodes, boundaries, branches;
    real *effort;               /* [nodes + boundaries]           */
    real *capacity;             /* [nodes]  flow times s per effort; 0 = none */
    real *source;               /* [nodes]  flow fed in           */
    NetBranch *branch;
    int   direct;               /* parts of more nodes are solved by conjugate gradients: where capacities are large, as of heat in
                                 * frame steps, that is some ten rounds, and nothing to plan; 0 = all directly */
    real  tolerance;            /* of an effort and a step; 0 = one backward Euler step, whatever it brings */

    int   substeps, iterations; /* in the last advance            */
    bool  failed;               /* a part had no solution; it stayed where it got to */

    NetPart *part; int parts;
    int  *member;               /* [nodes]  by part, ascending    */
    int  *place;                /* [nodes]  number within its part */
    int  *order;                /* [branches] by part, ascending  */
    int  *value;                /* [branches] coefficient between its ends in the part's matrix, < 0 none */
    /* [nodes] scratch: at the start; what is added to the balance; the capacity term's reference; flows in at three stages; change */
    real *start, *extra, *rest, *rate[3], *change;
    real *work[4];              /* [nodes] of the iteration: diagonal, residual, direction, its image */
    real *flow[3];              /* [branches] at three stages     */
} Network;

/* Takes memory for so many, all zero. */
dig_status network_open(Network *n, Arena *arena, int nodes, int boundaries, int branches);
/* The ends of the branches are set: parts, orders of elimination. */
dig_status network_plan(Network *n, Arena *arena);
void       network_advance(Network *n, real dt);
void       network_settle(Network *n);          /* the efforts at rest, as if all capacities were 0 */

#endif
