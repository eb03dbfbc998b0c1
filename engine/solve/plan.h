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
    real        tolerance;      /* m    the promise; picks the plan when a script gives a number    */
} AccuracyPlan;

extern const AccuracyPlan accuracy_plans[];         /* ends with a NULL name; ordered from coarse to fine */

int plan_find(const char *name);                    /* index, < 0 = none */
int plan_for_tolerance(real metres);                /* the coarsest that keeps it; the finest when none does */

#endif
