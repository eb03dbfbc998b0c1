/* step/debt.c - a world that is too dear for its frames goes on as crowds for a while.
 *
 * Groups of up to 48 bodies are solved to the last digit, located impacts and all. One such heap has the time for it; where twenty of them
 * are shaken in a box, 150 bodies took 100 ms a frame, until they had merged into one group that was large enough to be a crowd, and
 * then 2 ms. So the work of groups that could be crowds is counted (units, never the clock: bits do not depend on the machine), and what is
 * more than a frame's is a debt that later frames pay off. When it grows too large, and there are as many bodies as make a crowd, all of them are
 * crowds for some seconds, as in a world of more than crowd_total bodies and pairs. What lies calm is solved at once there, too, and falls asleep.
 */
#include "step/step.h"

#define FRAME   2000000u        /* units of work, which a frame may take: 20 ms of a core     */
#define MOST    (30 * FRAME)    /* such a debt is too large                                   */
#define AFTER   (27 * FRAME)    /* what of it is left after the pause: three frames to try it */
#define PAUSE   240u            /* steps                                                      */

/* Step.dear_work of those that may be crowds; 0: too few bodies for one. */
static uint64_t spare_work(const World *w, const Step *s)
{
    uint64_t work = 0;
    int bodies = 0;
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        if (g->crowd || g->calm || !may_crowd(w, s, &s->parts[i]))
            continue;
        work += work_of(g);
        bodies += g->moving_count;
    }
    return bodies > accuracy_plan(w->accuracy)->crowd_bodies ? work : 0;
}

void settle_debt(World *w, const Step *s)
{
    Debt *d = &w->debt;
    if (d->pause > 0) {
        d->pause--;
        return;
    }
    uint64_t work = s->dear_work;
    if (work > FRAME)
        work = spare_work(w, s);
    d->work = d->work + work > FRAME ? d->work + work - FRAME : 0;
    if (d->work >= MOST)
        *d = (Debt){.work = AFTER, .pause = PAUSE};
}
