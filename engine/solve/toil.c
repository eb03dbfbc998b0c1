/* solve/toil.c - what a mover stirs on and on is spared, for some steps, the solves that do not pay there.
 *
 * Direct solves are what makes a tower stand, an arch hold and a heap fall asleep. In a bucket of balls that is moved to and fro each step has
 * other contacts, Newton's method stops at their kinks, and where forty balls took 1.2 s of processor time a second, sixty, which are a crowd,
 * took 0.05. So where a mover moves, steps that take long are counted, one up for each, one down for each that does not. What lands has some
 * dozens of them; what is stirred on has more, and then pauses: it is only swept, and impacts are solved as roughly as few sweeps do. After a
 * pause it has some tries to show that it has come to lie: the first solve of what lies takes long, the next do not.
 *
 * What nothing stirs, and is solved in vain step after step, is a crowd while it pauses: a touched tower of three dozen small blocks slid on at
 * 5 mm/s by what its solves missed.
 *
 * What lies calm and would else be a crowd (crowd/calm.c) is solved at once, for it will sleep. Where it toils over and over it does not, and is a
 * crowd while it pauses, whether something stirs it or not.
 *
 * A step that was dear for few bodies is remembered for some steps: what tumbles is a crowd then (crowd/tumble.c).
 *
 * 40 balls in a bucket that is moved by 15 cm at 3 rad/s: 1.2 s of processor time a second before, 0.5 with this, once a second is over. What else was
 * measured and tried is in docs/decisions.md.
 */
#include "solve/group.h"

#define SWEEPS      2000        /* of a step: more is a toil */
#define FACTORS     100         /* so are more factorisations */
#define FACTORS_CALM 15         /* of what lies calm: its forces last, and the next steps take none. Balls that roll on take 20 to 200 in each */
#define ROUGH       1e-4        /* m/s: what nothing stirs is solved in vain where it is still off by more */
#define MOST        60          /* toils, before a pause */
#define MOST_VAIN   20          /* of what nothing stirs */
#define MOST_CALM   8           /* of what lies calm: heaps that come to rest have up to four */
#define TRIES       3           /* after it, before the next */
#define PAUSE       64          /* steps, */
#define PAUSE_TIME  (64 / 60.0) /* s: what nothing stirs shall fall asleep in it, which takes half a second of rest; up to 255 steps, 1/239 s each */
#define FACTOR_SWEEPS 3         /* a factorisation is as dear */
#define DEAR        30          /* steps for which that is remembered */

/* Are they many? Not what joints hold: there it was not tried. What lies calm has a crowd to go back to. What is heavy on what is light has none:
 * swept only, 60 boxes of 10,000:1 sank by half their size into each other. Stirred they may pause, but where masses are farther apart. */
static bool may_pause(const Group *g)
{
    if (g->calm)
        return true;
    return group_many(g) && g->joint_count == 0 && !g->crowd && (!group_leans(g) || (g->driven && group_mass_ratio(g) <= STIRRED));
}

void toil_gather(Group *g)
{
    g->toil = (Toil){0, 0, 0};
    lean_find(g, false);
    g->may_pause = may_pause(g);
    for (int i = 0; g->may_pause && i < g->moving_count; i++) {
        const Body *b = &g->world->bodies.data[g->slots[i]];
        if (!b->awake)
            continue;
        g->toil.steps = (uint8_t)int_max(g->toil.steps, b->toil.steps);
        g->toil.pause = (uint8_t)int_max(g->toil.pause, b->toil.pause);
    }
}

static void count(Toil *t, bool toils, int most, int pause)
{
    if (t->pause > 0) {
        t->pause--;
    } else if (!toils) {
        t->steps = (uint8_t)int_max(0, t->steps - 1);
    } else if (++t->steps >= most) {
        t->pause = (uint8_t)pause;
        t->steps = (uint8_t)(most - TRIES);
    }
}

/* Steps. At 1/120 s 64 of them ended before a tower slept, which had sunk meanwhile and was lifted again, on and on. */
static int pause_of(const Group *g, real dt)
{
    return g->driven ? PAUSE : (int)real_clamp(ceil(PAUSE_TIME / dt - 1e-6), PAUSE, UINT8_MAX);
}

void toil_count(Group *g, real dt)
{
    bool dear = g->sweeps > SWEEPS || g->factors > (g->calm && !g->driven ? FACTORS_CALM : FACTORS), in_vain = g->driven || g->calm || g->residual > ROUGH;
    if (g->may_pause)
        count(&g->toil, dear && in_vain, g->calm ? MOST_CALM : g->driven ? MOST : MOST_VAIN, pause_of(g, dt));
}

int group_toil(const Group *g) { return g->sweeps + FACTOR_SWEEPS * g->factors + g->evaluations; }

Toil toil_after(const Group *g, Toil of)
{
    if (g->may_pause && (g->driven || g->calm))
        return g->toil;
    if (g->may_pause)
        of = (Toil){.steps = g->toil.steps, .pause = g->toil.pause, .dear = of.dear};
    else
        count(&of, false, MOST, PAUSE);
    of.dear = g->dear || group_toil(g) > TOIL_DEAR ? DEAR : (uint8_t)int_max(0, of.dear - 1);
    return of;
}
