/* solve/plan.c - the accuracy plans. */
#include "solve/plan.h"

const AccuracyPlan accuracy_plans[] = {
    /* name       sub  sweeps residual events bodies tolerance */
    {"sketch",     2,   30,   1e-5,    8,     16,    1e-2},
    {"play",       4,  200,   1e-9,   64,     48,    1e-3},
    {"study",     16,  400,   1e-11, 256,     96,    1e-5},
    {"reference", 64, 1000,   1e-13, 1024,   200,    1e-7},
    {0}
};

int plan_find(const char *name)
{
    for (int i = 0; accuracy_plans[i].name; i++)
        if (strcmp(accuracy_plans[i].name, name) == 0)
            return i;
    return -1;
}

int plan_for_tolerance(real metres)
{
    int i = 0;
    while (accuracy_plans[i + 1].name && accuracy_plans[i].tolerance > metres)
        i++;
    return i;
}
