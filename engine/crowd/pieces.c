/* crowd/pieces.c - into how many pieces a step is cut.
 *
 * Rows hold for poses as they are at the start, and soft ones carry a load by overlap, the more the longer they have to. Where things
 * are thin for that, or turn, they get through each other and are pushed out at the far side: 60 rods of 2 m x 1 cm boiled for ever at
 * 2 m/s, in pieces of a quarter of 1/60 s they lie still within 5 mm/s. Each piece has contacts of its own.
 *
 * Springs are as stiff as substeps are short. Were they that in pieces, a heap that needs five pieces in one step and four in the next would be let
 * down and lifted by a third of its sag each time, for ever (60 rods at 0.02 to 0.08 m/s, 138 to 168 of 200 planks). So how stiff they are does
 * not jump with the number of pieces: it grows with the part of a piece that is wanted beyond it.
 */
#include "crowd/system.h"

#define PIECES_MOST 16
#define FINE 16                 /* parts of a piece that are told apart, for how hard rows are */
/* Of the thickness: so much may gravity times the square of a piece's time be. Things of 1 cm take four pieces of 1/60 s, for with those
 * their heaps lay still. */
#define SAGS        0.0168
#define THICK       0.2         /*      of that: by the springs of way.c it takes 200 of such things to press one in by DEEP */
/* Of the thickness: so far may a rim go by its turn in a piece. A row knows its point only, not the corner that turns in meanwhile: with a quarter,
 * as large piles have it, 300 cones, capsules or mixed solids that land in a pen are up to 60 to 120 mm in each other for a frame or some,
 * with a twentieth, in at most eight pieces, 1 to 7, and take no longer but for cones, twice as long. */
#define SWEPT       0.25        /*      of most contacts */
#define SWEPT_LEAST 0.05        /*      of every contact, where that asks for no more than WORK and QUICK_MOST */
#define QUICK_MOST  8           /* pieces: what spins faster was squeezed or shot, and the others need not pay for it */
#define DRIVEN      INFINITY    /* a mover is among them: what it squeezes is thrown the farther, the more pieces and passes there are */
#define WORK        6000        /* live contacts times pieces: a step of so many takes as long as one of a pile of 2000 */
#define DEEP        0.05        /* of the thickness: so much overlap asks for a piece more */
#define SOME        0.05        /* of the contacts may need more pieces than there are, where it is by WORK */

/* m/s  Of a rod's ends, and nearly that of other rims: what rolls about its long axis sweeps nothing. */
static real rim_speed(const Group *g, int body)
{
    const Member *m = &g->member[body];
    if (m->round || !m->moves)
        return 0;
    vec3 w = quat_unrotate(g->pos[body].q, g->vel[body].w);
    return sqrt(3 * real_max(0, vec3_dot(w, mat3_mul_vec(*m->inertia, w))) / m->mass);
}

/* Is everything thick for how fast it falls and turns? Then no contact needs to be asked. */
static bool all_thick(const Crowd *c)
{
    const Group *g = c->g;
    real swept = 2 * g->contact_count <= WORK ? SWEPT_LEAST : SWEPT;
    if (!(g->fall * c->dt * c->dt < THICK * SAGS * c->thinnest))
        return false;
    for (int i = 0; i < c->bodies; i++)
        if (c->trait[i].moves && !c->trait[i].round && !(c->dt * g->member[i].outer * vec3_length(g->vel[i].w) < swept * c->thinnest))
            return false;
    return true;
}

typedef struct Cut {
    const Crowd *c;
    real  *rim;                         /* [body_count of g] m/s */
    int  (*want)[FINE * PIECES_MOST + 1];       /* [shares] contacts that need so many pieces, in parts of one */
    real  *most;                        /* [shares] pieces, were every rim to go no farther than SWEPT_LEAST in one; or DRIVEN */
} Cut;

static void rim_share(void *context, int thread, int threads)
{
    const Cut *x = context;
    const Group *g = x->c->g;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++)
        x->rim[i] = rim_speed(g, i);
}

static int in_parts(real n) { return (int)(FINE * real_clamp(n, 1, PIECES_MOST)); }

static void want_share(void *context, int thread, int threads)
{
    const Cut *x = context;
    const Group *g = x->c->g;
    int *want = x->want[thread];
    real most = 1;
    bool driven = false;
    for (int i = team_first(g->contact_count, thread, threads), end = team_end(g->contact_count, thread, threads); i < end; i++) {
        const GroupContact *t = &g->contacts[i];
        if (!t->live)
            continue;
        real thick = crowd_thickness(&g->pairs[t->pair]), deepest = 0, swept = x->c->dt * (x->rim[t->a] + x->rim[t->b]) / thick;
        for (int k = 0; k < t->manifold.count; k++)
            deepest = real_max(deepest, -t->manifold.points[k].gap);
        real sinks = sqrt(g->fall * x->c->dt * x->c->dt / (SAGS * thick)) + deepest / (DEEP * thick);
        want[in_parts(real_max(swept / SWEPT, sinks))]++;
        most = real_max(most, real_clamp(swept / SWEPT_LEAST, 1, QUICK_MOST));
        driven = driven || x->c->trait[t->a].kinematic || x->c->trait[t->b].kinematic;
    }
    x->most[thread] = driven ? DRIVEN : most;
}

/* Pieces, in parts of one, than which only some contacts need more. */
static real pieces_wanted(const int want[FINE * PIECES_MOST + 1], int contacts)
{
    int parts = FINE * PIECES_MOST, more = 0;
    for (; parts > FINE; parts--) {
        more += want[parts];
        if (more > SOME * contacts)
            break;
    }
    return parts / (real)FINE;
}

dig_status crowd_pieces(const Crowd *c, int *pieces, real *firm)
{
    *pieces = c->g->pieces;
    *firm = 1;
    if (*pieces > 0)
        return DIG_OK;
    *pieces = 1;
    if (all_thick(c))
        return DIG_OK;
    Group *g = c->g;
    int shares = team_shares(c->team), contacts = 0;
    Cut x = {c, arena_alloc(g->lasting, (size_t)g->body_count * sizeof *x.rim), arena_zero(g->lasting, (size_t)shares * sizeof *x.want),
             arena_alloc(g->lasting, (size_t)shares * sizeof *x.most)};
    if (!x.rim || !x.want || !x.most)
        return DIG_E_MEMORY;
    team_deal(c->team, rim_share, &x);
    team_deal(c->team, want_share, &x);
    spare_add(&g->spare, x.rim, (size_t)g->body_count * sizeof *x.rim);
    for (int i = 1; i < shares; i++) {
        x.most[0] = real_max(x.most[0], x.most[i]);
        for (int n = FINE; n <= FINE * PIECES_MOST; n++)
            x.want[0][n] += x.want[i][n];
    }
    for (int n = FINE; n <= FINE * PIECES_MOST; n++)
        contacts += x.want[0][n];
    real wanted = pieces_wanted(x.want[0], contacts);
    if (x.most[0] < DRIVEN)
        wanted = real_max(wanted, real_min(x.most[0], (real)WORK / int_max(1, contacts)));
    *pieces = (int)wanted;
    *firm = *pieces > 1 ? (wanted - 1) / *pieces : 1;        /* times the pieces: 1 at two, as in one, and never less than one piece fewer has */
    return DIG_OK;
}
