/* effect/effect.h - what an effect must supply. One effect is one file ending in one const table.
 *
 * Effects never include each other. They meet in forces, rows and records of
 * the group. They never change topology, never see sleeping members, and write
 * only their own group.
 *
 * Floor: effect. Includes base, math, geom, world, solve.
 */
#ifndef DIG_EFFECT_H
#define DIG_EFFECT_H

#include "solve/group.h"

typedef dig_status EffectFn(void *state, Group *g);

typedef struct EffectType {
    const char *name;                   /* Lua key: world:effect("friction", true)          */
    const char *law;                    /* the equation, one line                           */
    const char *cite;                   /* key in docs/references.bib                       */
    size_t      state_size;             /* bytes per world, zeroed when it is switched on   */
    /* Does this group need it? Asked once per group and step, so that what no scene calls for costs one test. */
    bool      (*wanted)(const World *w, const Group *g);
    int       (*members)(const Group *g);       /* bodies taking part, for reports; NULL = all that move */
    EffectFn   *run[STAGE_COUNT];       /* NULL: takes no part in that stage                */
} EffectType;

extern const EffectType *const effect_types[];      /* NULL-terminated; effects.c; its order is the order within a stage */

#endif
