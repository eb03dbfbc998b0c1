/* step/step.h - one frame step of a world.
 *
 * Floor: step. Includes base, math, geom, world, solve, joint, effect.
 */
#ifndef DIG_STEP_H
#define DIG_STEP_H

#include "base/clock.h"
#include "base/team.h"
#include "effect/effect.h"

/* Advances the world by one frame step, or leaves motion and effects as they were and says why. */
dig_status step_world(World *w);

/* What each step begins with: who may meet whom in it. Done twice it changes nothing. */
dig_status step_sense(World *w);

/* Time is taken in every so many steps only: looking at the clock costs something, too. */
#define TIMED_EVERY 16

static inline int lowest_bit(uint32_t bits) { return __builtin_ctz(bits); }      /* bits are not 0 */

typedef struct Step {           /* what the stages hand to each other; lives in the world's scratch memory */
    real      dt;
    int       tries;            /* of the step, because something got farther than foreseen */
    bool      plain;            /* all bodies are free, of about the same mass, and advanced the default way; false: not known */
    bool      timed;            /* phases and effects are timed in this step */
    Stopwatch watch;            /* in a timed step                          */
    uint32_t *leads;            /* first members of the DIGs of all groups, group by group */
    uint32_t *pairs;            /* pairs of all groups, group by group      */
    struct StepGroup {
        const AccuracyPlan *plan;
        int dig_first, dig_count, pair_first, pair_count, accuracy, cost;
        bool may_trace, crowd, calm, together;
    } *parts;
    Group    *groups;
    int       count;
    int      *order;            /* in which groups are advanced, NULL: in theirs */
    Spare   **spare;            /* what a group has done with, NULL: none has           */
    int       together;         /* the first so many by all threads together, then the others, the dearest first */
    struct Telling *tellings;   /* tell.c: who is to hear of which strike   */
    struct Heard *heard;        /* by whom                                  */
    struct Missive *missives;   /* and what the log's messages need         */
    int       telling_count;
    struct Change *changes;     /* regraph.c: of a group, pairs whose touch changes */
    bool     *within;           /* of its strikes, which are within a DIG   */
    uint64_t  dear_work;        /* units, of groups that are no crowd and do not lie calm: see debt.c */
} Step;

#define PLACE_ROUNDING 1e-12    /* of places: differences of them are that wrong */

/* sense.c */
dig_status sense_pairs(World *w, real dt);          /* whose boxes may meet in this step                    */
/* near.c */
dig_status ask_all(World *w);                       /* w->asking: pairs that have parted go, new ones come   */
bool       plane_near(const World *w, uint32_t plane, box3 box);    /* is a part of the box in it?                           */
real       plane_room(const World *w, uint32_t solid);              /* m  how far its reach is from having one */
box3       solid_reach(const World *w, const Solid *s);             /* m  where it may get in this step, of a listed body */
real       roams_until(real room, real travel, real roam);          /* m  roam until which faces have moved by less than room since one was so */
bool       plane_new(const World *w, uint32_t solid);               /* is one near its reach that it has no pair with?       */
dig_status ask_planes(World *w, uint32_t solid);    /* those become pairs                                   */
/* groups.c */
bool       pair_met(const World *w, const Pair *p);  /* of a listed pair: is it watched in this try?         */
dig_status form_groups(World *w, Step *s);          /* DIGs that may meet are advanced together             */
bool       may_crowd(const World *w, const Step *s, const struct StepGroup *g);    /* would it be one in a larger world?      */
/* advance.c */
dig_status advance_groups(World *w, Step *s);       /* on private copies, in parallel; DIG_E_BUSY = a sleeper woke or a body went astray: again */
void       commit_groups(World *w, Step *s);        /* the copies become the world                          */
dig_status check_finite(World *w, Step *s);         /* all numbers finite, or name the culprit              */
/* stray.c */
int        count_strays(Group *g);                  /* that got farther than foreseen                       */
dig_status look_for_strays(World *w, Step *s);      /* DIG_E_BUSY = a body got where its group did not look: again */
/* ways.c */
dig_status group_advance(Group *g, real dt);        /* by the first way that suits and can                  */
/* regraph.c */
dig_status reserve_regraph(World *w, Step *s);
static inline void *step_room(World *w, const Step *s, size_t bytes)
{
    return s->spare ? spare_take(s->spare, &w->scratch, bytes) : arena_alloc(&w->scratch, bytes);
}
void       regraph(World *w, Step *s);              /* touches begin and end; DIGs merge and split; breaks  */
/* tell.c: collision messages */
dig_status reserve_tell(World *w, Step *s);
void       tell(World *w, Step *s, uint32_t struck, uint32_t striker, real time, real speed);
void       tell_all(World *w, Step *s);             /* before the DIGs of the step change                   */
/* flow.c: effects on the world as a whole */
dig_status reserve_flow(World *w, real dt);
void       flow(World *w, const Step *s);
/* rest.c */
#define SLEEP_TIME 0.5          /* s  slow for so long, and a DIG sleeps */
void       rest(World *w, real dt);                 /* who comes to rest, who falls asleep                  */
/* watch.c: is the result reliable? */
void       watch_start(Group *g);                   /* before the group is advanced                         */
void       watch_group(Group *g);                   /* after it, while the world is still as it was         */
void       watch_world(World *w, const Step *s);    /* all groups, after the commit                         */
/* deliver.c: who gets a message, and that they get it */
int        deliver_post(World *w, const Post *p, dig_receipt *receipt);         /* how many got it; receipt may be NULL */
void       deliver_due(World *w);                   /* what waited until now                                */
int        deliver_list(World *w, const Post *p, const dig_body *to, const real *value, int count);
/* work.c */
uint64_t   work_of(const Group *g);                 /* units, see world/work.c                              */
void       count_work(World *w, Step *s);           /* of one try of the step, whatever came of it          */
/* debt.c */
void       settle_debt(World *w, const Step *s);    /* of a step that is over, while its groups are as they were */
/* report.c */
bool       world_left(const World *w, vec3 x);      /* out of the room, or farther than anyone looks        */
void       end_events(World *w);                   /* those of the last step: from now on their room is idle */
dig_status reserve_events(World *w, int count);    /* for so many of this step, and those that wait     */
void       begin_events(World *w);                 /* before the first one of this step, when nothing is in that room any more */
void       report(World *w, const Step *s);

/* Memory of one thread. What is needed while one group is advanced, and no longer, is not taken anew for each: a hundred small groups
 * then write to what is in the cache already, not to a hundred places. */
typedef struct Scratch {
    Arena *step;                /* until the step is committed */
    Arena *group;               /* while a group is advanced   */
} Scratch;

/* workers.c: runs job(context, i) for i in 0..count-1 on the world's threads, each with its own memory; own: the calling one's. */
typedef void Job(void *context, int i, Scratch scratch);
dig_status workers_open(int threads, struct Workers **out);
void       workers_close(struct Workers *p);
Team      *workers_team(struct Workers *p);         /* all of them; NULL: there is only the caller */
void       workers_share(struct Workers *p, Scratch own, Job *job, void *context, int count);
/* Inline: where there is one thread, or one thing to do, it is a loop of its caller. */
static inline void workers_run(struct Workers *p, Scratch own, Job *job, void *context, int count)
{
    if (p && count > 1)
        workers_share(p, own, job, context, count);
    else
        for (int i = 0; i < count; i++)
            job(context, i, own);
}
void       workers_reset(struct Workers *p);        /* their memory */
static inline Scratch world_scratch(World *w) { return (Scratch){&w->scratch, &w->group_scratch}; }
size_t     workers_bytes(const struct Workers *p);

#endif
