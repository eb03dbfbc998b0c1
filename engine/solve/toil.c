/* solve/toil.c - what a mover stirs on and on is spared, for some steps, the solves that do not pay there.
 *
 * Direct solves are what makes a tower stand, an arch hold and a heap fall asleep. In a bucket of balls that is moved to and fro each step has
 * other contacts, Newton's method stops at their kinks, and where forty balls took 1.2 s of processor time a second, sixty, which are a crowd,
 * took 0.05. So where a mover moves, steps that take long are counted, one up for each, one down for each that does not. What lands has some
 * dozens of them; what is stirred on has more, and then pauses: it is only swept, and impacts are solved as roughly as few sweeps do. After a
 * pause it has some tries to show that it has come to lie: the first solve of what lies takes long, the next do not.
 *
 * 40 balls in a bucket that is moved by 15 cm at 3 rad/s: 1.2 s of processor time a second before, 0.5 with this, once a second is over. What else was
 * measured and tried is in docs/decisions.md.
 */
#include "solve/group.h"

#define SWEEPS      2000        /* of a step: more is a toil */
#define FACTORS     100         /* so are more factorisations */
#define MOST        60          /* toils, before a pause */
#define TRIES       3           /* after it, before the next */
#define PAUSE       64          /* steps */

/* Are they many, and is there a mover that moves? Not what joints hold: there it was not tried. */
static bool is_stirred(const Group *g)
{
    if (g->moving_count <= g->plan->toil_bodies || g->joint_count > 0 || g->crowd || g->calm)
        return false;
    for (int i = g->moving_count; i < g->body_count; i++)
        if (g->member[i].kinematic && g->member[i].moved)
            return true;
    return false;
}

void toil_gather(Group *g)
{
    g->toil = (Toil){0, 0};
    g->stirred = is_stirred(g);
    for (int i = 0; g->stirred && i < g->moving_count; i++) {
        const Body *b = &g->world->bodies.data[g->slots[i]];
        if (!b->awake)
            continue;
        g->toil.steps = (uint8_t)int_max(g->toil.steps, b->toil.steps);
        g->toil.pause = (uint8_t)int_max(g->toil.pause, b->toil.pause);
    }
}

static void count(Toil *t, bool toils)
{
    if (t->pause > 0) {
        t->pause--;
    } else if (!toils) {
        t->steps = (uint8_t)int_max(0, t->steps - 1);
    } else if (++t->steps >= MOST) {
        t->pause = PAUSE;
        t->steps = MOST - TRIES;
    }
}

void toil_count(Group *g)
{
    if (g->stirred)
        count(&g->toil, g->sweeps > SWEEPS || g->factors > FACTORS);
}

Toil toil_after(const Group *g, Toil of)
{
    if (g->stirred)
        return g->toil;
    count(&of, false);
    return of;
}
