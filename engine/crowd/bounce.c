/* crowd/bounce.c - what movers give, and how much of all bounces the energy allows. */
#include "crowd/system.h"

/* J, twice what movers gave: by all impulses so far, and by the bounces. Their speed is what they add to the rates. */
static void work_of_movers(const Crowd *c, double *all, double *bounces)
{
    *all = *bounces = 0;
    for (int i = 0; i < c->batches; i++) {
        const Batch *x = &c->batch[i];
        if (!x->drive)
            continue;
        for (int lane = 0; lane < LANES; lane++) {
            for (int k = 0; k < x->points; k++) {
                *all -= 2 * (double)x->point[k].sum.at[lane] * (double)x->drive[k].at[lane];
                *bounces -= x->bounces ? 2 * (double)x->point[k].room.at[lane] * (double)x->drive[k].at[lane] : 0;
            }
            for (int k = 0; k < 2 && x->patch; k++)
                *all -= 2 * (double)x->patch->sum[k].at[lane] * (double)x->drive[x->points + k].at[lane];
            *all -= x->twist ? 2 * (double)x->twist->sum.at[lane] * (double)x->drive[x->points + 2].at[lane] : 0;
        }
    }
}

/* Many that bounce at once, each off its approach before the step, may gain energy. So much of all bounces is taken as the energy
 * before the step, with what forces and movers gave, allows: |plastic + share (bounced - plastic)|^2 = allowed + share of the work
 * that movers do in the bounces. c->last has the plastic velocity. */
static float allowed_share(const Crowd *c)
{
    double allowed, given, plastic = 0, mixed = 0, gain = 0;
    work_of_movers(c, &allowed, &given);
    for (int i = 0; i < c->bodies; i++)
        for (int k = 0; k < 6; k++) {
            double start = (double)c->start[i].at[k], last = (double)c->last[i].at[k], change = (double)c->vel[i].at[k] - last;
            allowed += start * start + 2 * (double)c->push[i].at[k] / (double)c->h * (double)c->move[i].at[k];
            plastic += last * last;
            mixed += last * change;
            gain += change * change;
        }
    double room = allowed - plastic, half = mixed - given / 2, square = half * half + gain * room;
    if (!(gain > 0) || gain + 2 * half <= room)
        return 1;
    return square > 0 ? (float)fmax(0, (sqrt(square) - half) / gain) : 0;
}

static void take_share(Crowd *c, float share)
{
    for (int i = 0; i < c->bodies; i++)
        for (int k = 0; k < 6; k++)
            c->vel[i].at[k] = c->last[i].at[k] + share * (c->vel[i].at[k] - c->last[i].at[k]);
    for (int i = 0; i < c->batches; i++)
        for (int k = 0; k < c->batch[i].points && c->batch[i].bounces; k++) {
            WidePoint *p = &c->batch[i].point[k];
            for (int lane = 0; lane < LANES; lane++)
                p->sum.at[lane] += share * p->room.at[lane];    /* not to j: the next step does not begin with a blow */
        }
}

/* By the sums of all impulses, bounces too: after those. What has left a mover by the end of the step had its work, too. */
real crowd_work_of_movers(const Crowd *c)
{
    double all, bounces;
    work_of_movers(c, &all, &bounces);
    return 0.5 * all;
}

void bounce_share(Crowd *c) { take_share(c, allowed_share(c)); }
