/* solve/plan.c - the accuracy plans. */
#include "solve/plan.h"

const AccuracyPlan accuracy_plans[] = {
    /*                                                    crowds:                                   traced groups: most
     * name       sub  sweeps residual events bodies     bodies      toil      calm     total  bodies rows  total    work passes tolerance */
    {"sketch",     3,   30,   1e-5,   16,     16,         16,       12,       512,       256,      1,  120,      256,     60,  0,  1e-1},
    {"play",       4,  200,   1e-9,   64,     48,         48,       12,       512,      1024,     12,  120,      256,    500,  0,  1e-4},
    {"study",     16,  400,   1e-11, 256,     96,  INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX,     24,  300,     4096,   5000, 16,  1e-7},
    {"reference", 64, 1000,   1e-13, 1024,   200,  INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX,     96, 1200, INT32_MAX,  50000, 32,  1e-10},
    {0}
};

/* accuracy_for of their tolerances. Every group of every step asks: logarithms and powers take a good part of a ball's flight. */
static const int numbers[] = {16, 64, 112, 160};

#define STEPS 16                /* of the accuracy number in a decade */
_Static_assert(ACCURACY_FINEST < 13 * STEPS, "as many decades as are written out");
static const real decades[] = {1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12};
static const real parts[STEPS] = {              /* 10^(-i / STEPS) */
    1, 0.8659643233600653, 0.7498942093324559, 0.6493816315762113, 0.5623413251903491, 0.4869675251658631,
    0.42169650342858224, 0.36517412725483772, 0.31622776601683794, 0.27384196342643613, 0.23713737056616552,
    0.20535250264571462, 0.17782794100389228, 0.15399265260594919, 0.13335214321633240, 0.11547819846894582,
};

int accuracy_for(real metres)
{
    return (int)real_clamp(ceil(-(real)STEPS * log10(metres) - 1e-9), 1, ACCURACY_FINEST);
}

int accuracy_find(const char *plan)
{
    for (int i = 0; accuracy_plans[i].name; i++)
        if (strcmp(accuracy_plans[i].name, plan) == 0)
            return numbers[i];
    return 0;
}

const AccuracyPlan *accuracy_plan(int accuracy)
{
    int i = 0;
    while (accuracy_plans[i + 1].name && numbers[i] < accuracy)
        i++;
    return &accuracy_plans[i];
}

real accuracy_tolerance(int accuracy) { return decades[accuracy / STEPS] * parts[accuracy % STEPS]; }

/* A hundredth of the tolerance, for local errors add up. Traced groups are never coarser than a millionth: beyond that, events
 * are missed. */
real accuracy_local(int accuracy) { return real_clamp(0.01 * accuracy_tolerance(accuracy), 1e-13, 1e-6); }
