/* solve/fours.h - contact points and rolling resistance of a group, four rows side by side, for sweeps.
 *
 * Rows that share no moving body can be solved in any order, or at once: the outcome has the same bits. So each row goes to the first
 * four with a lane left and no row of its bodies, which is an order of its own (fours_order), and a sweep over the fours is one over the rows
 * in that order (relax_roll, relax_points), in a third of the time. Impulses lie in one row of numbers, as the acceleration of sweeps wants them.
 *
 * Floor: solve.
 */
#ifndef DIG_FOURS_H
#define DIG_FOURS_H

#include "solve/group.h"

typedef struct Fours Fours;

/* In the group's arena. NULL: there are too few rows, or too few of them can be solved side by side, or something heavy stands on them, whose
 * load comes down a tower in one sweep only where rows are in its order; or no memory (then g->status says so). more: so many numbers have
 * room after the impulses, rounded up to a multiple of four, and are 0. plain: without the long registers that the machine may have; to the
 * same bits. */
Fours *fours_open(Group *g, int more, bool plain);
int    fours_count(const Fours *f);     /* numbers of which the impulses consist: three a row, and those of lanes without one, which are 0 */
real  *fours_impulses(Fours *f);        /* [fours_count + more] N s and N m s */
real   fours_relax(Fours *f);           /* one sweep: rolling resistance, then points; as relax_points: the largest change, m/s */
void   fours_order(const Fours *f, int *points, int *rolls);    /* the group's rows in the order of a sweep */
void   fours_close(const Fours *f);     /* impulses back to the group's rows */

#endif
