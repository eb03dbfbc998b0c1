/* solve/degree.h - the order in which the unknowns of a sparse symmetric system are eliminated.
 *
 * Least degree first (Tinney & Walker 1967), with buckets and last-in first-out ties: on trees there is no fill and the work is
 * linear. Use: degree_open, degree_link for every pair that shares a coefficient, degree_ready for every node that may go, from
 * the last to the first; then degree_next and degree_eliminate until all are gone. What is linked to a node when it goes is the
 * pattern of its column in the factor.
 *
 * Owns:  nothing; all memory is the arena's.
 * Floor: solve. Includes base.
 */
#ifndef DIG_DEGREE_H
#define DIG_DEGREE_H

#include "base/arena.h"

typedef struct Adjacent { int *node; int count, room; } Adjacent;

typedef struct Degree {
    Arena    *arena;
    Adjacent *next;             /* neighbours not yet eliminated */
    int      *head, *after, *before;    /* buckets by degree     */
    bool     *eligible;         /* may go                        */
    int      *mark, marks;      /* linked to the one looked at when its mark is the last one given */
    int       count;
    bool      failed;           /* out of memory: nothing in here can be used */
} Degree;

void degree_open(Degree *d, Arena *arena, int count);
void degree_link(Degree *d, int x, int y);
void degree_ready(Degree *d, int node);
int  degree_next(Degree *d);                            /* the next to go, no longer in its bucket; some node must be ready */
void degree_eliminate(Degree *d, int node, bool frees); /* its neighbours become each other's; frees: they may go, too */

#endif
