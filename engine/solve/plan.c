/* solve/plan.c - the accuracy plans. */
#include "solve/plan.h"

const AccuracyPlan accuracy_plans[] = {
    /*                                                    crowds:              traced groups: most
     * name       sub  sweeps residual events bodies     bodies     total  bodies rows  total    work passes tolerance */
    {"sketch",     3,   30,   1e-5,   16,     16,         16,       256,      0,    0,      256,      0,  0,  1e-1},
    {"play",       4,  200,   1e-9,   64,     48,         48,      1024,     12,  120,      256,    500,  0,  1e-4},
    {"study",     16,  400,   1e-11, 256,     96,  INT32_MAX, INT32_MAX,     24,  300,     4096,   5000, 16,  1e-7},
    {"reference", 64, 1000,   1e-13, 1024,   200,  INT32_MAX, INT32_MAX,    48,  600, INT32_MAX,  50000, 32,  1e-10},
    {0}
};

/* accuracy_for of their tolerances: every group of every step asks, and logarithms take longer than the flight of a ball. */
static const int numbers[] = {16, 64, 112, 160};

#define STEPS 16.0              /* of the accuracy number in a decade */

int accuracy_for(real metres)
{
    return (int)real_clamp(ceil(-STEPS * log10(metres) - 1e-9), 1, ACCURACY_FINEST);
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

/* A hundredth of the tolerance, for local errors add up. Traced groups are never coarser than a millionth: beyond that, events
 * are missed. */
real accuracy_local(int accuracy) { return real_clamp(0.01 * pow(10, -accuracy / STEPS), 1e-13, 1e-6); }
