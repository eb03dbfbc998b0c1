/* solve/plan.h - accuracy plans: what each level of care means in numbers.
 *
 * Nobody tests the level; code reads the knob (plan->substeps).
 *
 * Floor: solve.
 */
#ifndef DIG_PLAN_H
#define DIG_PLAN_H

#include "base/base.h"

typedef struct AccuracyPlan {
    const char *name;           /* Lua: digbox.world{accuracy = "study"}                            */
    int         substeps;       /* 1    equal parts a step is cut into, before located impacts      */
    int         sweeps;         /* 1    most Gauss-Seidel sweeps per substep for a small group      */
    real        residual;       /* m/s  velocity change per sweep at which a solve stops            */
    int         events;         /* 1    most impacts located in time per group and step             */
    int         events_bodies;  /* 1    groups with more moving bodies than this locate none         */
    int         crowd_bodies;   /* 1    groups with more moving bodies than this are advanced as a crowd   */
    int         toil_bodies;    /* 1    groups with more moving bodies than this may pause while a mover stirs them, or they are solved in vain: solve/toil.c;
                                 *      and what lands gently in them is not located: solve/locate.c */
    int         calm_bodies;    /* 1    up to so many are not where they lie calm: they are solved at once, and fall asleep  */
    int         crowd_total;    /* 1    so are all groups beyond trace_total, with more awake bodies and pairs in the world */
    int         trace_bodies;   /* 1    groups with more moving bodies are not traced; 1: nor with joints */
    int         trace_rows;     /* 1    most rows of a traced group's direct solve                        */
    int         trace_total;    /* 1    most bodies and pairs of all traced and conserved groups of a world together */
    int         trace_work;     /* 1    most evaluations of a traced group per step; 25 sweeps of blows count as one, so do 4 turns of directions */
    int         trace_passes;   /* 1    most places per step that a traced group is swept past            */
    real        tolerance;      /* m    the promise; picks the plan when a script gives a number    */
} AccuracyPlan;

extern const AccuracyPlan accuracy_plans[];         /* ends with a NULL name; ordered from coarse to fine */

/* How accurate a world, a DIG or a group is to be: one number, the larger the finer, so that of several the largest counts.
 * It is 16 times the decimal logarithm of one over the tolerance in metres, rounded up, in 1..ACCURACY_FINEST; 0 = nothing was
 * asked for. A plan's name stands for its own tolerance. */
#define ACCURACY_FINEST 192                         /* 1e-12 m */

int accuracy_find(const char *plan);                /* 0 = there is no such plan */
int accuracy_for(real metres);                      /* > 0 */
const AccuracyPlan *accuracy_plan(int accuracy);    /* the coarsest that keeps it; the finest when none does */
real accuracy_tolerance(int accuracy);              /* m  the promise */
real accuracy_local(int accuracy);                  /* 1  local error of the traced way over the size of the bodies */

#endif
