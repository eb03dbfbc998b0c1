/* step/step.c - the order of things. */
#include "step/step.h"
#include "world/region.h"

/* In a timed step, books the CPU time since the last call. Statistics only: nothing depends on it. */
static void book_time(Step *s, real *us)
{
    if (s->timed)
        *us += stopwatch_lap(&s->watch);
}

dig_status step_sense(World *w)
{
    arena_reset(&w->scratch);
    if (w->group_scratch.held > ARENA_FIRST)        /* else it is empty and as it should be */
        arena_reset(&w->group_scratch);
    if (w->workers)
        workers_reset(w->workers);
    ArenaMark mark = arena_mark(&w->scratch);
    dig_status status = sense_pairs(w, w->def.step);
    arena_rewind(&w->scratch, mark);        /* all that it found is in the world */
    return status;
}

static dig_status try_once(World *w, Step *s)
{
    dig_stats *t = &w->stats;
    DIG_TRY(step_sense(w));
    book_time(s, &t->us_sense);
    dig_status status = form_groups(w, s);
    book_time(s, &t->us_graph);
    if (status == DIG_OK)
        status = advance_groups(w, s);
    count_work(w, s);
    book_time(s, &t->us_advance);
    return status;
}

/* What the tries of this step found out about who gets farther than foreseen is not for the next one. */
static void forget_strays(World *w)
{
    for (int i = 0; i < w->awake.count; i++)
        for (uint32_t s = w->bodies.data[w->awake.data[i]].shape_first; s != NONE; s = w->solids.data[s].next)
            w->solids.data[s].astray = 0;
}

/* Forms groups and advances them. Where something pushes a sleeper, or gets where nobody looked, this is done again: each round
 * wakes at least one DIG, or is one of a few (look_for_strays), so that it ends. */
static dig_status advance(World *w, Step *s)
{
    dig_stats *t = &w->stats;
    if (s->timed) {
        t->us_sense = t->us_touch = t->us_graph = t->us_advance = t->us_commit = t->us_report = 0;
        s->watch = stopwatch_start();
    }
    dig_status status;
    do
        status = try_once(w, s);
    while (status == DIG_E_BUSY);
    if (s->tries > 0)
        forget_strays(w);
    return status;
}

/* Kinematic bodies that are on their way end the step exactly where they should be. */
static void move_movers(World *w, real dt);

/* Advances the world by one frame step. The order below is the whole story.
 * If it fails, motion and effect state are those before the call. */
dig_status step_world(World *w)
{
    Step s = {.dt = w->def.step, .timed = w->timed_always || w->steps % TIMED_EVERY == 0};

    w->culprit = (dig_body){0, 0};
    effects_look(w);
    end_events(w);
    DIG_TRY(advance(w, &s));            /* 1 whose boxes may meet, in which groups;          */
                                        /*   each group on private copies                    */
    DIG_TRY(check_finite(w, &s));       /* 2 all numbers finite, or name the culprit         */
    DIG_TRY(reserve_regraph(w, &s));    /* 3 from here on nothing can fail:                  */
    DIG_TRY(reserve_flow(w, s.dt));     /*   all memory is there                             */
    commit_groups(w, &s);               /* 4 the copies become the world                     */
    begin_events(w);
    settle_debt(w, &s);                 /*   did it take longer than a frame may?            */
    move_movers(w, s.dt);               /* 5 kinematic bodies                                */
    w->steps++;
    region_cross_all(w);                /*   who crossed the border of a region              */
    book_time(&s, &w->stats.us_commit);
    regraph(w, &s);                     /* 6 contacts begin and end, DIGs merge and split    */
    book_time(&s, &w->stats.us_graph);
    flow(w, &s);                        /* 7 heat, and what else goes on while bodies sleep  */
    rest(w, s.dt);                      /* 8 who comes to rest, who falls asleep             */
    report(w, &s);                      /* 9 events, residuals, energy ledger                */
    book_time(&s, &w->stats.us_report);
    return DIG_OK;
}

static void move_movers(World *w, real dt)
{
    real end = (real)(w->steps + 1) * dt;
    for (int i = 0; i < w->awake.count && w->movers > 0; i++) {
        Body *b = &w->bodies.data[w->awake.data[i]];
        if (b->kind != DIG_KINEMATIC)
            continue;
        b->prev_x = b->x;
        b->prev_q = b->q;
        vec3 x = vec3_mad(b->x, dt, b->v);
        quat q = quat_unit(quat_mul(quat_exp(vec3_scale(dt, b->w)), b->q));
        bool arrives = b->move_end > b->move_start && end >= b->move_end - MOVE_SLACK * dt;
        if (arrives) {
            x = body_rest(w, b)->move_to;
            q = body_rest(w, b)->turn_to;
        }
        body_travels(b, x, q);
        b->x = x;
        b->q = q;
        if (arrives) {
            b->v = b->w = vec3_zero();
            b->move_end = b->move_start - 1;
        }
    }
}
