/* api/ask.h - what the files behind dig_ask share. ask.c asks and answers; ask_linkage.c looks for gears that contradict each other;
 * ask_trial.c pushes a copy; ask_needs.c finds how much it takes; ask_holders.c what holds it.
 *
 * All of them work on a part of the world (api/part.h) and a copy of that, in which one trial after the other is made. Slots and handles
 * are those of the part until ask.c gives the answer.
 *
 * Floor: api.
 */
#ifndef DIG_ASK_H
#define DIG_ASK_H

#include "api/part.h"

#define ASK_STARTS  1e-4        /* m/s: faster than this after a few steps, and it moves    */
#define ASK_LITTLE  1e-3        /* m: less is not moved                                     */
#define ASK_MOST    1e3         /* times the weight of a DIG: no push is stronger           */
#define ASK_STRONG  4           /* times the weight of a DIG: more than rubs and weighs     */
#define ASK_FREE    5e-3        /* times the weight of a DIG: what needs less is free       */
#define ASK_LINKS   24          /* of a body that are tried to be taken away                */

typedef struct Ask {
    const World *w;             /* that is asked; only its sentence about an error is ever written */
    const dig_question *q;
    dig_answer *a;
    Part     part;              /* as it is before each trial            */
    World   *copy;              /* in which the trials are made          */
    bool     used;              /* the copy is no longer what part is    */
    bool     linked;            /* the body has links; ask_holders       */
    real     far;               /* m   around its DIG the part goes      */
    uint32_t body;              /* that is to move                       */
    vec3     along;             /* unit                                  */
    vec3     local;             /* m, where it is pushed, body axes from the centre of mass */
} Ask;

typedef struct Trial {          /* of one push */
    vec3 start;                 /* m, of the point that is watched */
    real moved, speed, faster;  /* m or rad so far; its rate now, and how much that grew in the last step */
    int  steps;
} Trial;

/* ---- ask_trial.c ---- */
real       ask_scale(const Ask *k);             /* m/s or rad/s  of a body this large, for 1 m/s */
real       ask_weight(const Ask *k);            /* N or N m  of its DIG, at least as in 1 m/s^2 */
dig_status ask_no_memory(const Ask *k);         /* says so in the world's error */
dig_status ask_use_copy(Ask *k);                /* the copy is as the part is, and about to change */
dig_status ask_push(Ask *k, real push, Trial *t);      /* joints may break in it */
dig_status ask_step(Ask *k, Trial *t);
bool       ask_stuck(const Ask *k, const Trial *t);     /* at rest, and not starting */
/* A few steps of a copy in which no joint breaks: does it start? *rate: how fast it is after them. */
dig_status ask_starts(Ask *k, real push, bool *does, real *rate);
/* The same with some parts taken away before. */
dig_status ask_starts_without(Ask *k, real push, const dig_part *parts, int count, bool *does);
/* It is drawn slowly by whatever that takes, up to `most`: *force. Infinite: in vain. NaN: it moves, but not evenly. */
dig_status ask_draw(Ask *k, real most, real *force);

/* ---- ask_needs.c ---- */
/* The least push that starts it; infinite: none does. known: `push` is known not to. */
dig_status ask_needs(Ask *k, real push, bool known, real *needs);

/* ---- ask_holders.c ---- */
/* Fills held[]: the first link without which that push would start it; or, where there is none, as many of them as it takes. */
dig_status ask_holders(Ask *k, real push);
/* Fills chain[], from the body by what holds it, and by what holds that, to what stands firm: by trials with that push. */
dig_status ask_chain(Ask *k, real push);
void       ask_add_chain(dig_answer *a, dig_part p);
/* "bolt 'b' and body 'box'", in `text`; of one who holds, who stands firm behind it. */
const char *ask_name_holders(const Ask *k, char *text, size_t capacity);
void       ask_add_broken(const Ask *k, char *text, size_t capacity);          /* what broke on its way, to a sentence */

/* ---- ask_linkage.c ---- */
/* Do gears that hang on this body's hinges contradict each other? Fills the loop's bodies. */
bool       ask_conflict(const World *w, uint32_t body, dig_part *loop, int *count);

#endif
