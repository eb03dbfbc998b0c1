/* chain/chain.h - the way for jointed groups of crowds: chains, ropes and trees of bodies that touch nothing, at the speed of a
 * game engine and with joints that hold to a tenth of a millimetre.
 *
 * One implicit step for the whole frame. Unknown are the end poses and the joints' impulses p; with the Cayley vector
 * c = 2 vec(q0* q) / scal(q0* q) of a body's turn and 1/2 <= k <= 1
 *
 *     x = x0 + h (k v + (1 - k) v0),          c = h (k W + (1 - k) W0)                (W body axes)
 *     m (v - v0) = h f + sum of p J_lin,      R I W - R0 I W0 = h tau + sum of p J_ang
 *     C(end) = 0
 *
 * where J is the discrete gradient of C (conserve/system.h says of what kind). With k = 1/2 this is the rule of the room
 * conserve, that keeps energy; the energy it changes by is
 *
 *     -(k - 1/2) (m |v - v0|^2 + ...) + p (C - C0) / h
 *
 * so that with k a little above 1/2 what the step cannot follow, the ringing of a cracked whip, dies within a quarter of a
 * second, and slow motion loses next to nothing: a swing of period T a share of 2 pi^2 (2 k - 1) h / T in each period.
 *
 * What makes it fast: a first guess that has the impulses of the last step in it, so that one or two Newton iterations are enough
 * for a swing, four on the average, substeps included, for chains that crack; bodies ordered from the leaves of the tree to its
 * root, each with a small dense front of its joints' rows that passes on to the next what is left of it (the multifrontal method:
 * Duff & Reid 1983, ACM Trans. Math. Softw. 9, 302; on a tree nothing fills in); four bodies of a tree side by side in all that each
 * does by itself, so that along the tree there is left only what one body passes on to the next.
 *
 * Not taken: rings, joints with stops, motors, springs or friction, bodies that may touch something. Those are swept.
 *
 * Floor: chain. Includes base, math, solve, world.
 */
#ifndef DIG_CHAIN_H
#define DIG_CHAIN_H

#include "solve/group.h"

extern const Way way_chain;

#endif
