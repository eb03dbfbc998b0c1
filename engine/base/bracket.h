/* base/bracket.h - a bracketed root, made narrower by false position.
 *
 * Illinois variant (Dowell & Jarratt 1971, BIT 11): where one end stays twice, its value counts half, so that it moves.
 *
 * Floor: base.
 */
#ifndef DIG_BRACKET_H
#define DIG_BRACKET_H

#include "base/base.h"

typedef struct Bracket { real lo, hi, at_lo, at_hi; int side; } Bracket;        /* at_lo and at_hi: values of opposite signs */

/* The value f at x between the ends becomes that of one of them. */
static inline void bracket_put(Bracket *b, real x, real f)
{
    if ((f > 0) == (b->at_lo > 0)) {
        b->lo = x;
        b->at_lo = f;
        b->at_hi *= b->side == -1 ? 0.5 : 1;
        b->side = -1;
    } else {
        b->hi = x;
        b->at_hi = f;
        b->at_lo *= b->side == 1 ? 0.5 : 1;
        b->side = 1;
    }
}

#endif
