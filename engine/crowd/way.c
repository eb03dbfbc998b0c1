/* crowd/way.c - how a step of a crowd goes. */
#include "crowd/crowd.h"

#include "crowd/system.h"

/* Overlap is corrected by over-damped springs. Their frequencies, per substep: stiffer ones never come to rest in a pyramid (with
 * 0.28 its boxes tremble at 0.3 m/s, with 0.16 at 0.003), softer ones let a row of thirty sink by 7 mm instead of 4. */
#define STIFF  0.16
#define FIRM   0.30             /* against what does not move                                   */
#define DAMPED 10.0             /* 1  damping ratio                                             */
#define PUSH_MOST 3.0           /* m/s per square root of the size in metres, under 10 m/s^2 */

bool crowd_allows(const World *w) { return w->def.plane.s[0] == 0 && strcmp(w->def.friction_law.s, "decay") != 0; }

static bool suits(const Group *g) { return g->crowd; }

/* Overlap x under a spring of angular frequency w, damping ratio z, implicit in the velocity over the substep h. */
static Soft soft_of(real share, real h)
{
    real w = 2 * DIG_PI * share / h, a = 2 * DAMPED + h * w, b = h * w * a;
    return (Soft){(float)(w / a), (float)(b / (1 + b)), (float)(1 / (1 + b))};
}

typedef struct Smallest { const Group *g; struct Least { real size, thickness; } *least; } Smallest;       /* m  [shares] */

static void smallest_share(void *context, int thread, int threads)
{
    const Smallest *s = context;
    struct Least least = {INFINITY, INFINITY};
    for (int i = team_first(s->g->pair_count, thread, threads), end = team_end(s->g->pair_count, thread, threads); i < end; i++) {
        least.size = real_min(least.size, s->g->pairs[i].size);
        least.thickness = real_min(least.thickness, crowd_thickness(&s->g->pairs[i]));
    }
    s->least[thread] = least;
}

/* Of all pairs: their size, and how thin they are. */
static dig_status find_smallest(Crowd *c)
{
    int shares = team_shares(c->team);
    Smallest s = {c->g, arena_alloc(c->g->lasting, (size_t)shares * sizeof *s.least)};
    if (!s.least)
        return DIG_E_MEMORY;
    team_deal(c->team, smallest_share, &s);
    c->finest = c->thinnest = INFINITY;
    for (int i = 0; i < shares; i++) {
        c->finest = real_min(c->finest, s.least[i].size);
        c->thinnest = real_min(c->thinnest, s.least[i].thickness);
    }
    c->g->close_speed = close_speed_of(c->finest, c->g->fall);
    c->finest = isfinite(c->finest) ? c->finest : 1;
    return DIG_OK;
}

static void trait_share(void *context, int thread, int threads)
{
    Crowd *c = context;
    Group *g = c->g;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++) {
        Member *m = &g->member[i];
        c->trait[i] = (Trait){m->travel, m->pull, m->moves, m->kinematic, m->dormant, m->round};
    }
}

static dig_status open(Crowd *c)
{
    Group *g = c->g;
    g->h = c->dt;
    DIG_TRY(group_forces(g));
    c->trait = arena_alloc(g->lasting, (size_t)g->body_count * sizeof *c->trait);          /* not of what is spare: crowd_touch needs all of that */
    if (g->losses && !g->start_vel) {
        g->start_pos = arena_alloc(g->lasting, (size_t)g->body_count * sizeof *g->start_pos);
        g->start_vel = arena_alloc(g->lasting, (size_t)g->body_count * sizeof *g->start_vel);
    }
    if (!c->trait || (g->losses && (!g->start_pos || !g->start_vel)))
        return DIG_E_MEMORY;
    team_deal(g->team, trait_share, c);
    if ((g->pairs_roll || g->losses) && !g->contact_rest)
        DIG_TRY(group_gather_rest(g));
    DIG_TRY(find_smallest(c));
    c->push_most = (float)(PUSH_MOST * sqrt(c->finest));
    return DIG_OK;
}

/* What was left out, for nothing in a whole step could bring it together by itself, may meet after the first of several pieces. */
static dig_status take_all(Group *g)
{
    real *anything = arena_alloc(g->lasting, (size_t)g->body_count * sizeof *anything);
    if (!anything)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->body_count; i++)
        anything[i] = INFINITY;
    return group_gather_struck(g, anything, 1);
}

/* Where nothing stays for long, everything is looked at anew, in the next step, too. */
static void look_anew(Group *g)
{
    for (int i = 0; i < g->pair_count; i++)
        g->pairs[i].until = -1;
}

/* As many passes as the load needs, to come through from the top of the pile to the ground: what overlaps says so. */
#define WORK    40000           /* points, in all passes of a substep of a step of 1/60 s or less; longer ones may do more, for there are fewer */
#define USUAL   (1.0 / 60)      /* s */
/* A pile that has landed may take more, for what is deep in it, or where a blow or a load that shifts asks for them: little else is to be
 * done then, and it is brief. These make rows no harder, for what lies in them would be thrown up. */
#define CALM_WORK 8             /* times as many */
/* What is deep in it all the same, because the load shifts a little in every step or a blow met a single pass, is put apart at the end of
 * the step, in place alone: springs would need many steps, and harder ones would throw it up. While most still moves only where a contact is alone: what
 * turned into another at 100 rad/s stayed 2 to 4 mm deep, and a wall that falls and is lifted row by row bobs up and down. */
#define SEPARATIONS 8
#define BRISK     0.01          /* of the size: what moves farther in 1/60 s, or in a step that is shorter, has not landed */
#define LANDED    0.9           /* of all bodies */

/* Are over such a part of the bodies no faster than that (m/s)? Their spins do not count: balls may roll on the spot. */
static bool slower(const Crowd *c, real speed, real part)
{
    int fast = 0;
    for (int i = 0; i < c->bodies; i++)
        fast += vec3_length2(c->g->vel[i].v) > speed * speed;
    return fast < (1 - part) * c->bodies;
}

static bool landed(const Crowd *c) { return slower(c, BRISK * c->finest / real_min(c->dt, USUAL), LANDED); }

/* A heap that one to five passes hold up creeps on by millimetres a second, for ever. With so many the median is below 0.1, and it falls asleep;
 * half as many are not enough. Rows as hard as for all of these would have thin things thrown up and a pyramid tremble; as soft as for one, those
 * heaps stir at 10 to 20 mm/s. */
#define SETTLING 32             /* passes of a substep, where it can sleep, nearly all is slow and there is work for so many */
#define SETTLING_HARD 4         /* its rows are as hard as for so many, */
#define SETTLING_PUSH 4e-4      /* m/s  but carry what they carry without overlap, and push what there is apart no faster: a wall of twelve rows that had
                                 * sunk into itself by 24 mm was thrown up by the harder rows at 0.28 m/s, once a second for ever */
#define SLOW     0.02           /* m/s */
#define NEARLY   0.95           /* of all bodies */

/* In a step that is cut into pieces, up to 16, each would take as many: no. */
static bool settles(const Crowd *c)
{
    return c->passes_most >= SETTLING && c->pieces == 1 && c->g->world->def.sleeping && slower(c, SLOW, NEARLY);
}

/* Contacts of several points carry their load by overlap for good. One pass a substep hands it on by a row, warm as it starts: a wall of a hundred bricks
 * that has been hit bobs up and down on its rows by centimetres, and what is put apart in place at the end of each step keeps it going. With some
 * passes, as hard as one, it does not. */
#define SAGS   1.5              /* times what a pass need not change: so deep, which leaves some room below SHALLOW */
#define STEADY 4                /* passes, where there is work for so many */

/* One contact that was found late and is deep says nothing of the load of the others: a wall that fell was thrown apart by rows that were all as hard as
 * one brick needed that was half in another (418 to 1394 J in a frame). */
#define OUTLIER 6               /* times as deep as the fourth deepest */

/* How hard rows may be at most where a load comes down through so many contacts. What pushes a tower apart adds up to its top, and what
 * relaxes it again gets no farther than its passes: with rows as hard as there is work for, a column of sixty boxes threw its top
 * 26 m up when it was hit, one of a hundred 41 m, and one of 49 that nobody touched fell. */
#define MUCH_HARDER 8           /* times: less throws nothing */
#define ANY_LEVELS  16          /* so many the hardest rows may push through; passes get there as the square of their number */

/* Contacts from the topmost body down to what does not move, on its shortest way. */
static int levels_of(const Crowd *c, uint8_t *level)
{
    const Group *g = c->g;
    memset(level, UINT8_MAX, (size_t)g->body_count);
    for (int i = c->bodies; i < g->body_count; i++)
        level[i] = 0;
    int top = 0;
    for (bool any = true; any;) {
        any = false;
        for (int i = 0; i < g->contact_count; i++) {
            uint8_t *a = &level[g->contacts[i].a], *b = &level[g->contacts[i].b], *high = *a > *b ? a : b, low = *a > *b ? *b : *a;
            if (!g->contacts[i].live || low + 1 >= *high)
                continue;
            *high = (uint8_t)(low + 1);
            any = true;
        }
    }
    for (int i = 0; i < c->bodies; i++)
        if (level[i] < UINT8_MAX)
            top = int_max(top, level[i]);
    return top;
}

static dig_status limit_hardness(const Crowd *c, int *hard)
{
    if (*hard <= MUCH_HARDER)
        return DIG_OK;
    uint8_t *level = arena_alloc(c->g->lasting, (size_t)c->g->body_count);
    if (!level)
        return DIG_E_MEMORY;
    int levels = int_max(levels_of(c, level), ANY_LEVELS);
    *hard = int_max(1, *hard * ANY_LEVELS * ANY_LEVELS / (levels * levels));
    return DIG_OK;
}

/* But for what is deep in a few contacts only. */
static real without_outliers(real hard, real deep, real load)
{
    return deep > OUTLIER * real_max(load, SHALLOW) ? real_min(hard, real_max(1, 1 + load - SHALLOW)) : hard;
}

/* Of rows whose points share a load. They carry it by overlap for good, a wall of sixteen rows by 5 mm at the ground: harder for what is deep elsewhere,
 * or for some passes more, they lift all of it in a step (up to 478 J of 12 kJ), and it sinks again. So they go by what is deep among
 * themselves, and before that STEADY passes are to mend it; not in a step in pieces, which thin things need: they would stir. */
static real shared_hardness(const Crowd *c, real hard)
{
    real mended = SHALLOW + (c->pieces > 1 ? 0 : STEADY - 1);
    hard = without_outliers(hard, c->sags, c->shared);
    return c->g->pieces > 0 ? hard : real_min(hard, real_max(1, 1 + c->sags - mended));
}

static dig_status plan_passes(Crowd *c)
{
    int points = 1, threads = c->team ? c->team->threads : 1;
    for (int i = 0; i < c->batches; i++)
        points += HALF * c->batch[i].halves * c->batch[i].points;
    int hardest = (int)real_clamp(WORK * real_max(1, c->dt / USUAL) / (real)points, 1, PASSES_MOST);
    real wanted = 1 + c->deep - SHALLOW;
    int allowed = hardest;
    DIG_TRY(limit_hardness(c, &allowed));
    bool down = landed(c);
    real hard = without_outliers(allowed, c->deep, c->load), shared = shared_hardness(c, allowed);
    if (c->sags > SAGS && wanted < STEADY && hardest >= STEADY) {
        hard = real_min(hard, real_max(wanted, 1));
        wanted = STEADY;
    }
    shared = real_min(shared, hard);
    c->passes_most = down ? int_min(CALM_WORK * hardest, PASSES_MOST) : hardest;
    c->separations = SEPARATIONS;
    c->lifts = down || c->g->pieces > 0;
    /* few that tumble: what stays in each other would be lifted when they are swept again */
    c->leaves = c->g->pieces > 0 ? 0 : (float)SHALLOW;
    c->settles = down && settles(c);
    if (c->settles) {
        c->push_most = (float)SETTLING_PUSH;
        hard = real_min(hard, real_max(wanted, SETTLING_HARD));
        shared = hard;
        wanted = real_max(wanted, SETTLING);
    }
    c->passes = (int)real_clamp(wanted, 1, c->passes_most);
    for (int i = 0; i < c->passes_most; i++)
        for (int k = 0; k < BEARINGS; k++) {
            real harder = (k == BEARS_ROUND ? 1 : c->firm) * real_min(i + 1, k == BEARS_SHARED ? shared : hard);
            c->soft[i][k][0] = soft_of(STIFF * harder, (real)c->h);
            c->soft[i][k][1] = soft_of(FIRM * harder, (real)c->h);
        }
    c->worst[0] = arena_zero(c->g->lasting, 2 * (size_t)threads * sizeof *c->worst[0]);
    c->worst[1] = c->worst[0] + threads;
    return c->worst[0] ? DIG_OK : DIG_E_MEMORY;
}

static dig_status advance_piece(Crowd *c, real until)
{
    Group *g = c->g;
    ArenaMark mark = arena_mark(g->lasting);
    int pairs = g->pair_count;
    const Strike *strikes = g->strikes;
    for (int i = g->moving_count; i < g->body_count && g->start_pos; i++)
        g->start_pos[i] = g->pos[i];
    DIG_TRY(crowd_touch(c));
    DIG_TRY(bodies_open(c));
    DIG_TRY(rows_open(c));
    DIG_TRY(plan_passes(c));
    wide_solve(c);
    g->t = until;
    g->substeps += c->substeps;
    g->sweeps += c->passes;
    bodies_close(c);
    if (c->before && crowd_passed(c)) {
        group_put_back(g, c->before);
        g->handed_on = true;
        return DIG_OK;
    }
    DIG_TRY(crowd_hold_back(c));
    DIG_TRY(book_close(c));
    /* nothing of it is needed any more: what comes next finds its room still in the cache */
    if (g->strikes == strikes && g->pair_count == pairs && !c->alone) {
        arena_rewind(g->lasting, mark);
        g->spare = NULL;        /* some of it is gone */
    } else {
        spare_add(&g->spare, c->batch, (size_t)c->batches * sizeof *c->batch);
        spare_add(&g->spare, c->last, 4 * (size_t)c->bodies * sizeof *c->last);
    }
    return DIG_OK;
}

/* As it is, for sweeps, which look at all pairs. */
static dig_status keep_for_sweeps(Group *g, GroupKept *before)
{
    DIG_ASSERT(!g->mass || g->left_count == 0);         /* it has room for impacts of the pairs that there were */
    DIG_TRY(take_all(g));
    group_close_left(g);
    if (!g->mass)
        DIG_TRY(group_weigh(g));
    g->spare = NULL;            /* what is spare of the arena is used up by a try */
    return group_keep(g, before) ? DIG_OK : DIG_E_MEMORY;
}

static dig_status advance_pieces(const Crowd *whole, int pieces)
{
    Group *g = whole->g;
    for (int i = 0; i < pieces; i++) {
        Crowd c = *whole;
        c.pieces = pieces;
        c.dt = whole->dt / pieces;
        c.h = (float)(c.dt / c.substeps);
        c.bounce_least = (float)(g->close_speed + 2 * g->fall * (real)c.h);
        if (pieces > 1)
            look_anew(g);
        DIG_TRY(advance_piece(&c, i + 1 < pieces ? (i + 1) * c.dt : whole->dt));
        if (g->woke || g->handed_on)
            return DIG_OK;      /* this try is thrown away: the sleeper wakes and the step starts again; or it is swept */
    }
    return DIG_OK;
}

static dig_status advance(Group *g, real dt)
{
    Width width = (Width)g->world->width;
    Crowd whole = {.g = g, .team = g->team, .width = width == WIDTH_ANY ? widest() : width, .dt = dt, .substeps = g->plan->substeps, .bodies = g->moving_count};
    DIG_TRY(open(&whole));
    int pieces;
    GroupKept before;
    DIG_TRY(crowd_pieces(&whole, &pieces, &whole.firm));
    bool may_pass = crowd_may_pass(&whole, pieces);
    whole.alone = pieces == 1 && !may_pass && !g->acted && group_is_most(g);
    if (!whole.alone)       /* what a piece takes from the arena may be given back after it */
        DIG_TRY(group_fill_out(g));
    if (!whole.alone && !g->acted)
        DIG_TRY(group_open_acted(g));
    if (may_pass) {
        DIG_TRY(keep_for_sweeps(g, &before));
        whole.before = &before;
    } else if (pieces > 1) {
        DIG_TRY(take_all(g));
    }
    DIG_TRY(advance_pieces(&whole, pieces));
    if (g->woke || g->handed_on)
        return DIG_OK;
    if (pieces > 1)
        look_anew(g);
    book_step(&whole);
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    return g->status;
}

const Way way_crowd = {.name = "crowd", .tally = WAY_SWEPT, .suits = suits, .advance = advance};
