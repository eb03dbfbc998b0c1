/* effect/effect.h - what an effect must supply. One effect is one file ending in one const table.
 *
 * Effects never include each other. They meet in forces, rows and records of
 * the group, and in what the world keeps. They never change who touches whom; an effect may keep a layer of its own, in which
 * it says who exchanges heat or current with whom.
 *
 * An effect has two parts, and may leave out either:
 *   - on groups: run[] is called while a group is advanced. It never sees sleeping members and writes only its own group.
 *   - on the world: flow() is called once a frame step, when the step is the world; it sees sleepers, too.
 *
 * What it keeps are plain structs that hold nothing but reals (vec3 and quat are made of them): one for the world, one for each
 * body that takes part (world/column.h). They begin with the fields that rows declare; what follows is private. So that one piece
 * of code copies, saves, restores and hashes them all. None of it is there until a scene calls for the effect.
 *
 * Floor: effect. Includes base, math, geom, world, solve.
 */
#ifndef DIG_EFFECT_H
#define DIG_EFFECT_H

#include "solve/group.h"

typedef dig_status EffectFn(const EffectSlot *e, Group *g);

typedef struct EffectType {
    const char *name;                   /* Lua key: world:effect("friction", true)          */
    const char *law;                    /* the equation, one line                           */
    const char *cite;                   /* key in docs/references.bib                       */

    const dig_param *world_params;      /* world:effect("drag", {density = 1.2}); NULL: none. Options of the effect as a whole */
    size_t           world_size;        /* bytes of the struct they describe; e->world once called for, else NULL */
    const dig_param *body_params;       /* world:ball{temperature = 300}: a body with one of these fields takes part; NULL: none */
    size_t           body_size;         /* bytes of the struct they describe; column_find(&e->members, body) */
    /* Checks what ranges cannot, and completes what was left NaN (a surface from the shape). why gets one sentence. May be NULL. */
    dig_status     (*join)(const World *w, const EffectSlot *e, uint32_t body, void *member, char *why, size_t capacity);

    /* ---- on groups ---- */
    /* Does this group need it? Asked once per group and step, so that what no scene calls for costs one test.
     * NULL: yes when one of its moving bodies takes part (body_params), or, without body_params, when e->world is there. */
    bool      (*wanted)(const World *w, const Group *g);
    int       (*members)(const Group *g);       /* bodies taking part, for reports; NULL = those of the group with body_params, or all that move */
    Law         stands;                 /* what it stands for: without it, the ways leave it out */
    bool        central;                /* turns no sphere: its forces go through the centre of mass, or it has none */
    bool        varies;                 /* its forces depend on where bodies are or how they move: they are not even over a step */
    EffectCause (*cause)(const Group *g);       /* what in the first group calls for it, asked once; NULL: its first body that takes part */
    EffectFn   *run[STAGE_COUNT];       /* NULL: takes no part in that stage                */
    bool        losses;                 /* asks for what each contact loses: Contact.lost   */

    /* ---- on the world ---- */
    /* Once a frame step, before anything is committed: takes the memory that flow will need (w->scratch lasts until the next step).
     * May fail; changes nothing. May be NULL. */
    dig_status (*reserve)(World *w, EffectSlot *e, real dt);
    /* Once a frame step, after the commit and the change of the DIGs: cannot fail. May be NULL. Called only when something takes
     * part: a member, or e->world is there. */
    void       (*flow)(World *w, EffectSlot *e, real dt);
    uint32_t    layer;                  /* that flow marks: layer_mark(w, layer, a, b, ...) for each link that is there now; 0: none */
    /* Adds what it stores, J, to the fields of `sum` (heat, elastic, electric, potential). May be NULL. */
    void       (*energy)(const World *w, const EffectSlot *e, dig_energy *sum);
} EffectType;

/* Of a pair: its body that moves, or else the other one. */
static inline EffectCause effect_cause_pair(const Group *g, const GroupPair *q)
{
    const Member *m = &g->member[g->member[q->a].moves ? q->a : q->b];
    return (EffectCause){.body = body_handle(g->world, m->slot)};
}

/* World.bits, where an effect may have changed. */
void effects_look(World *w);

extern const EffectType *const effect_types[];      /* NULL-terminated; effects.c; its order is the order within a stage */

#endif
