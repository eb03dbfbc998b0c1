/* crowd/crowd.h - the way for crowds: large contact groups, and worlds of very many small ones, at the speed of a game engine.
 *
 * The accurate ways collide several times a step and iterate until nothing changes. Here each step
 *
 *   1 collides once; a manifold whose points have hardly moved against each other is carried along instead;
 *   2 writes one row for each contact point that may act within the step, with its Jacobian kept for the whole step;
 *   3 makes the plan's substeps: velocities; one pass of soft rows that also push bodies apart; positions; one pass of hard rows
 *     that takes the pushing velocity out again (small steps: Macklin et al. 2019; soft constraints with a relaxing pass: Catto,
 *     "Solver2D", 2024). Restitution comes once, at the end. Where a pass still changes much, or overlap shows that the load is
 *     too deep for one, there are more of both, as many as a bound on the work allows, and the rows are the harder for it.
 *
 * What is done differently, and why:
 *
 *   - Velocities are scaled by the square root of the mass, u = sqrt(m) v, and spins by a root of the inertia, w = S s with
 *     S S^T = I^-1. A row then needs its Jacobian only: M^-1 J^T = J^T. Half the numbers of a row are gone.
 *   - With J fixed in the step, applying the impulses of the last substep again changes every body by what they changed it
 *     then. Warm starting needs no pass over the rows: a body's velocity goes on by its last difference.
 *   - Eight rows that share no body are solved side by side, or sixteen where registers hold so many (wide.c); rows are as large as their number of points.
 *   - Contacts of balls have rows of their own: a normal that turns nobody, and friction as one vector. They are half as large.
 *   - Rows are single precision, and hold differences from the start of the step only; state and positions stay double.
 *   - What a contact of one point has carried for a while by overlap it goes on carrying without (book.c): piles of balls do not sink.
 *   - What an impact stops is in the way of others that fell along behind it, at no speed against it: they are looked for (touch.c).
 *   - What is still deep in a pile that has landed is put apart at the end of the step, in place alone (wide.c, separate).
 *   - Thin things take the step in pieces, each with contacts of its own (pieces.c), and a turn may add no energy (bodies.c).
 *   - Friction acts at the middle of the contact area, two directions in a round cone and a torque about the normal.
 *
 * Price: penetration of about a millimetre for metre-sized boxes, impacts at the ends of steps, errors of 1e-7 of the impulses.
 *
 * Floor: crowd. Includes base, math, geom, world, solve.
 */
#ifndef DIG_CROWD_H
#define DIG_CROWD_H

#include "solve/group.h"

extern const Way way_crowd;
extern const Way way_calm;              /* calm.c: what would be a crowd, but lies there */
extern const Way way_tumble;            /* tumble.c: few that fall over each other, where steps are dear */
extern const Way way_tumble_late;       /* the same, by sweeps unless they turn out so */

/* What a crowd does not take. The step decides by these, before it gathers anything (step/groups.c). */
#define CROWD_MASS_RATIO 30.0   /* of the bodies of a group: beyond it, single passes may not carry the load */
#define CROWD_LIGHT      0.3    /* of the bodies may be lighter than the heaviest by more than that: they bear little of it */
#define CROWD_LIVELY     0.5    /* restitution: what bounces better deserves better                         */
#define CROWD_LIVELY_MOST 16    /* times the plan's crowd: larger groups are crowds even if lively     */
bool crowd_allows(const World *w);

#endif
