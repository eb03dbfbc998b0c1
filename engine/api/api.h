/* api/api.h - what the files behind digbox.h share. They check arguments, then call down.
 *
 * Floor: api. Includes everything but render.
 */
#ifndef DIG_API_H
#define DIG_API_H

#include "base/param.h"
#include "step/step.h"
#include "world/joint.h"

/* Finds the body or fails with a sentence. */
Body     *api_body(const World *w, dig_body b, const char *call);
JointRec *api_joint(const World *w, dig_joint j, const char *call);
/* The joint as its type sees it, from the present state; memory is a copy. */
void api_joint_view(const World *w, uint32_t slot, JointView *view, real memory[JOINT_MEMORY]);
real api_joint_energy(const World *w, uint32_t slot);             /* J  of its spring */
real api_body_springs(const World *w, uint32_t body);             /* J  of all springs at it */
void api_book_given(World *w, real energy);                       /* J  brought into the world, or taken out of it, by hand */
/* Adds b unless it is there; returns the new number. */
int api_add_unique(dig_body *out, int n, int capacity, dig_body b);
/* dig.c: a link of a layer's graph, with what it bears */
void api_link(const World *w, uint32_t layer, uint32_t link, dig_link *out);
/* effect.c */
void api_open_effects(World *w);
void api_effects_energy(const World *w, dig_energy *sum);       /* adds what effects store, J */
real api_effects_stored(const World *w);                        /* the same in one number, J */
/* What has come or gone by hand since effects stored `before`, J, is not made up by the integration. */
void api_book_stored(World *w, real before);
/* A row of an effect's body_params by name; NULL: no effect has it. */
const dig_param *api_effect_row(const World *w, const char *name, int *effect);
dig_status api_effects_follow(World *w, uint32_t body);          /* its mass has changed: those that it takes part in hear of it */
dig_status api_effect_set(World *w, uint32_t body, int effect, const dig_param *row, const void *value);
void api_effect_get(const World *w, uint32_t body, int effect, const dig_param *row, void *value);
/* snapshot.c: a world of its own with the same state, one thread; dig_world_close */
dig_status api_clone(const World *w, World **out);
/* The same into a world that is there, a clone of `from` or of what it was taken from; where it had room, nothing is allocated. What
 * is left when memory runs out is fit for dig_world_close only. */
dig_status api_refill(World *to, const World *from);
dig_status api_copy_effects(World *to, const World *from);      /* their options, not who takes part */
/* NULL: not a body that forces move; *status says why. */
Body      *api_pushable(World *w, dig_body b, const char *call, dig_status *status);
dig_status api_push(World *w, dig_body b, Push p, real lasts, const char *call);
/* own.c: a body takes part in an effect of the caller's */
dig_status api_own_join(World *w, int effect, uint32_t body);
dig_status api_finite(const World *w, vec3 v, const char *call, const char *what, const char *unit);
dig_status api_within(const World *w, vec3 v, real most, const char *call, const char *what, const char *unit);     /* finite, and no larger */

#endif
