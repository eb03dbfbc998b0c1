/* chain/system.h - what the files of this room share.
 *
 * Bodies lie four side by side, so that what each does by itself is computed for four of them at once.
 *
 * Floor: chain. Includes base, math, solve, world.
 */
#ifndef DIG_CHAIN_SYSTEM_H
#define DIG_CHAIN_SYSTEM_H

#include "math/four.h"
#include "math/reg3.h"
#include "solve/group.h"

#define TIE_ROWS  3             /* of a joint                           */
#define LINK_ENDS 8             /* most joints of a body                */
#define LINK_ROWS (LINK_ENDS * TIE_ROWS)

/* A joint of the group keeps two points together. */
typedef struct Tie {
    int  end[2];                /* of a and b, in lanes of Chain.ends; < 0 = it does not move by itself */
    real h;                     /* s    of the substep                  */
    four fixed;                 /* m    the point of such an end, at the end of the substep, with the sign of that end's side */
    vec3 arm;                   /* m    from its body to it, mean of the substep */
    vec3 twist;                 /* N m s  on that body, of all substeps so far */
} Tie;

/* One end of a joint, at each of four bodies that move. A body that has no more of them has 0 for its side. */
typedef struct Ends {
    four *below[LANES];         /* front of the link beyond, that passes its remains on to here; NULL = none */
    const four *other[LANES];   /* m    the joint's other point times its side, where the link owns the joint */
    four_int owned;             /* all bits there                       */
    four  side;                 /* 1 at a, -1 at b                      */
    four3 arm;                  /* m    from the centre of mass, body axes */
    four3 r0, r;                /* m    the same in world axes, at the start and the end */
    four3 p;                    /* N s  of the joint on its a, of this substep */
    four3 at;                   /* m    its side times the point at the end */
    four3 error;                /* m    C = pa - pb at the end, where the link owns the joint */
    four3 impulse, twist;       /* N s, N m s  on the body, of all substeps so far */
} Ends;

/* Four bodies that move, in their places in the tree. The first end of each is the one towards the root. */
typedef struct Links {
    int   body[LANES];          /* < 0 = none: only at the end of a tree */
    int   own[LANES];           /* first end whose joint it owns: 1 where there is one towards the root */
    int   count[LANES];         /* of its ends                          */
    int   end, ends;            /* first of Chain.ends; the most that one of the four has */
    int   first;                /* 1: the joints of all first ends belong to others */
    int   front;                /* first of its fronts in Chain.number, one after the other (solve.c, Front) */
    int   turn;                 /* first of its columns in Chain.turn   */
    four  mass;
    four33 inertia, inverse;    /* body axes                            */
    four3 force, torque;        /* N, N m  from outside                 */
    four3 x0, v0, w0; four_quat q0; four33 r0;      /* at the start; w0 body axes */
    four3 p0, l0;               /* N s, N m s  momenta at the start with the impulses of outer forces added */
    four3 x, v, w; four_quat q; four33 r;           /* at the end; w body axes, implied by the turn */
    four3 c;                    /* rad  Cayley vector, body axes        */
    four  hung[LANES];          /* m    the end towards the root, times its side: one vector each */
    four3 loose;                /* rad  turn of this iteration if no joint acted */
} Links;

/* A tree of bodies: the root, then each after the one it hangs on. */
typedef struct Linkage {
    int first, last;            /* of Chain.links                       */
    int first_tie, last_tie;    /* of Chain.owned                       */
} Linkage;

typedef struct Chain {
    Group *g;
    real   h, k;                /* s; 1  weight of the end velocity     */
    Links *links; int link_count;       /* lanes, the empty ones at the ends of trees among them */
    Ends  *ends;
    Tie   *tie;  int ties;
    int   *owned, owned_count;  /* ties of one tree after the other, as links own them */
    Linkage *tree; int trees;
    four  *number;
    four3 *turn;                /* rad/(N s)  inverse angular slope times the lever of a row, body axes */
    real   spin;                /* rad/s  of the fastest of the last tree that was opened */
    real   began, ended;        /* J  motion of that tree then, and after its last substep */
    real   lost;                /* J  of motion, by the trees so far    */
    real   error;               /* m  largest of the last substep       */
    real   enough;              /* m  at which an iteration is the last */
} Chain;

/* Link n and end n are lanes n % LANES. */
static inline Links *links_of(const Chain *c, int link) { return &c->links[link / LANES]; }
static inline Ends *ends_of(const Chain *c, int end) { return &c->ends[end / LANES]; }
static inline int lane_of(int n) { return n % LANES; }
INLINE four *front_at(const Chain *c, const Links *l, int lane) { return c->number + l->front + lane * TIE_ROWS * l->ends * l->ends; }

/* Of a tie that a link owns. */
static inline int moving_end(const Tie *t) { return t->end[0] >= 0 ? t->end[0] : t->end[1]; }

/* J  Of the links' present motion. */
INLINE real motion_of(const Chain *c, const Linkage *t)
{
    four sum = four_all(0);
    for (const Links *l = c->links + t->first; l < c->links + t->last; l++)
        sum += l->mass * four3_dot(l->v, l->v) + four3_dot(l->w, four33_mul3(&l->inertia, l->w));
    return 0.5 * ((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

/* way.c: where what does not move by itself is at a time of the step; body < 0: the world */
Pos fixed_pose(const Group *g, int body, real time);
/* lanes.c: bodies of the group become links, whose joints push as in the last step; both become the group's again */
void links_open(Chain *c, const Linkage *t);
void ties_guess(Chain *c, const Linkage *t);
void links_close(Chain *c, const Linkage *t);
void ties_close(Chain *c, const Linkage *t);
vec3 tie_twist_on_b(const Chain *c, int joint);         /* N m s  of all substeps */
/* tree.c: the group's joints as trees. *fits: they are */
dig_status tree_make(Chain *c, bool *fits);
/* solve.c: one step of a tree; false: no solution was found */
bool tree_step(Chain *c, const Linkage *t);

#endif
