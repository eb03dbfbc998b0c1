/* solve/fours.c - contact points and rolling resistance of a group, four rows side by side.
 *
 * Every lane computes what relax.c computes for one row, by the same rounded operations in the same order.
 */
#include "solve/fours.h"
#include "base/wide.h"
#include "solve/four_dir.h"

/* ---- rows in lanes ---- */

/* Bodies, and which row of the group it is; < 0: none, and the bodies are the spare one after the last. */
typedef struct FourRows { int32_t a[LANES], b[LANES], row[LANES]; } FourRows;

typedef struct FourPoints {
    FourRows of;
    four     ima, imb;          /* 1/kg */
    FourDir  n, t[2];
    four     target;
    four_int acts;              /* n.k > 0 */
    bool     rub;               /* some lane has friction */
    four_int rubs, sticks;      /* lanes with friction; those whose tangents can be solved together */
    four     friction, blow, ktt, det, kmax;
} FourPoints;

typedef struct FourRolls {
    FourRows of;
    four33   inv_k, ia, ib;
    four     lever, reach;
} FourRolls;

typedef struct Impulses { real at[3][LANES]; } Impulses;       /* N s of a normal and two tangents, or N m s of a roll */

struct Fours {
    Group      *g;
    FourPoints *points; int point_fours;
    FourRolls  *rolls;  int roll_fours;
    Impulses   *impulses;       /* [point_fours + roll_fours]          */
    int        *place;          /* [point_count] of the normal impulse, in numbers */
    bool        plain;
    bool        swept;          /* once, row by row                    */
    bool        filled;         /* with more than which rows and bodies, and impulses: from the second sweep on */
};

/* ---- which rows go together ---- */

/* Bits of fours: which have a row of a body, and which have no lane left. */
typedef struct Deal {
    const Group *g;
    uint64_t *has;              /* [body_count][words] */
    uint64_t *full;             /* [words]             */
    int      *lanes;            /* [rows] in use of each four */
    int       words, fours, none;       /* none: words before this one are full */
} Deal;

static bool deal_open(Deal *d, Group *g, int rows)
{
    *d = (Deal){.g = g, .words = rows / 64 + 1};
    d->has = arena_zero(g->arena, (size_t)g->body_count * (size_t)d->words * sizeof *d->has);
    d->full = arena_zero(g->arena, (size_t)d->words * sizeof *d->full);
    d->lanes = arena_zero(g->arena, (size_t)(rows + 1) * sizeof *d->lanes);
    return d->has && d->full && d->lanes;
}

/* LANES times its four, and its lane. */
static int deal_row(Deal *d, int a, int b)
{
    bool of_a = d->g->member[a].moves, of_b = d->g->member[b].moves;
    uint64_t *has_a = d->has + (size_t)a * (size_t)d->words, *has_b = d->has + (size_t)b * (size_t)d->words, free = 0;
    while (d->full[d->none] == UINT64_MAX)
        d->none++;
    int word = d->none;
    for (;; word++) {
        free = ~(d->full[word] | (of_a ? has_a[word] : 0) | (of_b ? has_b[word] : 0));
        if (free)
            break;
    }
    int i = 64 * word + __builtin_ctzll(free);
    uint64_t bit = free & (~free + 1);
    int lane = d->lanes[i]++;
    if (lane == LANES - 1)
        d->full[word] |= bit;
    has_a[word] |= bit;
    has_b[word] |= bit;
    d->fours = int_max(d->fours, i + 1);
    return LANES * i + lane;
}

/* Places of all points or of all rolls. NULL: no memory. */
static int *deal(Group *g, bool rolls, int *fours)
{
    Deal d;
    int count = rolls ? g->roll_count : g->point_count, *place = arena_alloc(g->arena, (size_t)(count + 1) * sizeof *place);
    if (!place || !deal_open(&d, g, count))
        return NULL;
    for (int i = 0; i < count; i++)
        place[i] = rolls ? deal_row(&d, g->rolls[i].a, g->rolls[i].b) : deal_row(&d, g->points[i].a, g->points[i].b);
    *fours = d.fours;
    return place;
}

/* ---- filling ---- */

static FourRows no_rows(int spare)
{
    FourRows r;
    for (int lane = 0; lane < LANES; lane++) {
        r.a[lane] = r.b[lane] = spare;
        r.row[lane] = -1;
    }
    return r;
}

static void put_rows(FourRows *to, int lane, int a, int b, int row)
{
    to->a[lane] = a;
    to->b[lane] = b;
    to->row[lane] = row;
}

static void put_impulse(Impulses *to, int lane, vec3 j)
{
    to->at[0][lane] = j.x;
    to->at[1][lane] = j.y;
    to->at[2][lane] = j.z;
}

/* What lanes without a row, or without friction, compute with: nothing comes of it. */
static const PointRow NO_ROW = {.n.k = 1, .t = {{.k = 1}, {.k = 1}}, .kmax = 1};

/* Whose rows stand in `of` already. Lanes without one write to the spare velocity after the last. */
INLINE void fill_point(const Group *g, FourPoints *to)
{
    const Dir *n[LANES], *t[LANES], *u[LANES];
    to->acts = to->rubs = to->sticks = (four_int){0};
    to->det = to->kmax = four_all(1);
    to->ima = to->imb = to->target = to->friction = to->blow = to->ktt = four_all(0);
    to->rub = false;
    for (int lane = 0; lane < LANES; lane++) {
        const PointRow *r = to->of.row[lane] < 0 ? &NO_ROW : &g->points[to->of.row[lane]], *rub = &NO_ROW;
        n[lane] = &r->n;
        if (to->of.row[lane] >= 0) {
            to->ima[lane] = g->mass[r->a].im;
            to->imb[lane] = g->mass[r->b].im;
            to->target[lane] = r->target;
            to->acts[lane] = r->n.k > 0 ? -1 : 0;
            rub = r->friction > 0 && r->kmax > 0 ? r : rub;
        }
        t[lane] = &rub->t[0];
        u[lane] = &rub->t[1];
        if (rub == &NO_ROW)
            continue;
        real det = r->t[0].k * r->t[1].k - r->ktt * r->ktt;
        bool sticks = det > 1e-12 * r->kmax * r->kmax;
        to->rub = true;
        to->rubs[lane] = -1;
        to->sticks[lane] = sticks ? -1 : 0;
        to->friction[lane] = r->slides ? r->friction_dynamic : r->friction;
        to->blow[lane] = r->blow;
        to->ktt[lane] = r->ktt;
        to->det[lane] = sticks ? det : 1;
        to->kmax[lane] = r->kmax;
    }
    four_dir_load(&to->n, n);
    to->n.k = four_pick(to->acts, to->n.k, four_all(1));
    four_dir_load(&to->t[0], t);
    four_dir_load(&to->t[1], u);
}

static void fill_roll(const Group *g, FourRolls *to)
{
    *to = (FourRolls){.of = to->of};
    for (int lane = 0; lane < LANES && to->of.row[lane] >= 0; lane++) {
        const RollRow *r = &g->rolls[to->of.row[lane]];
        four33_put(&to->inv_k, lane, &r->inv_k);
        four33_put(&to->ia, lane, &g->mass[r->a].ii);
        four33_put(&to->ib, lane, &g->mass[r->b].ii);
        to->lever[lane] = r->lever;
        to->reach[lane] = r->reach;
    }
}

INLINE void fill(Fours *f)
{
    for (int i = 0; i < f->point_fours; i++)
        fill_point(f->g, &f->points[i]);
    for (int i = 0; i < f->roll_fours; i++)
        fill_roll(f->g, &f->rolls[i]);
    f->filled = true;
}

/* Which rows go where. */
static void lay(Fours *f, const int *points, const int *rolls)
{
    const Group *g = f->g;
    for (int i = 0; i < f->point_fours; i++)
        f->points[i].of = no_rows(g->body_count);
    for (int i = 0; i < f->roll_fours; i++)
        f->rolls[i].of = no_rows(g->body_count);
    for (int i = 0; i < g->roll_count; i++)
        put_rows(&f->rolls[rolls[i] / LANES].of, rolls[i] % LANES, g->rolls[i].a, g->rolls[i].b, i);
    for (int i = 0; i < g->point_count; i++) {
        int x = points[i] / LANES, lane = points[i] % LANES;
        put_rows(&f->points[x].of, lane, g->points[i].a, g->points[i].b, i);
        f->place[i] = LANES * 3 * x + lane;
    }
}

/* From the rows. */
static void read_impulses(Fours *f)
{
    const Group *g = f->g;
    real *x = f->impulses->at[0];
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        x[f->place[i]] = r->jn;
        x[f->place[i] + LANES] = r->jt[0];
        x[f->place[i] + 2 * LANES] = r->jt[1];
    }
    for (int i = 0; i < f->roll_fours; i++)
        for (int lane = 0; lane < LANES && f->rolls[i].of.row[lane] >= 0; lane++)
            put_impulse(&f->impulses[f->point_fours + i], lane, g->rolls[f->rolls[i].of.row[lane]].j);
}

#define ROWS_LEAST   8
#define BODIES_LEAST 3
#define FILLED_LEAST 1.5        /* lanes in the mean: below that, one row after the other is as fast */

static Fours *fours_make(Group *g, int more, bool plain)
{
    int point_fours = 0, roll_fours = 0, *points = deal(g, false, &point_fours), *rolls = deal(g, true, &roll_fours);
    Fours *f = arena_alloc(g->arena, sizeof *f);
    if (!points || !rolls || !f) {
        g->status = DIG_E_MEMORY;
        return NULL;
    }
    if (g->point_count < FILLED_LEAST * point_fours)
        return NULL;
    *f = (Fours){.g = g, .place = points, .point_fours = point_fours, .roll_fours = roll_fours, .plain = plain};
    f->points = arena_alloc(g->arena, (size_t)point_fours * sizeof *f->points);
    f->rolls = arena_alloc(g->arena, (size_t)roll_fours * sizeof *f->rolls);
    f->impulses = arena_zero(g->arena, (size_t)(point_fours + roll_fours) * sizeof *f->impulses + (size_t)(more + 3) * sizeof(real));
    if (!f->points || !f->rolls || !f->impulses) {
        g->status = DIG_E_MEMORY;
        return NULL;
    }
    lay(f, points, rolls);
    read_impulses(f);
    g->vel[g->body_count] = (Vel){vec3_zero(), vec3_zero()};
    return f;
}

Fours *fours_open(Group *g, int more, bool plain)
{
    if (g->point_count < ROWS_LEAST || g->moving_count < BODIES_LEAST || g->patches || (group_top_heavy(g) && !toil_pauses(g)))
        return NULL;
    ArenaMark mark = arena_mark(g->arena);
    Fours *f = fours_make(g, more, plain);
    if (!f)
        arena_rewind(g->arena, mark);
    return f;
}

int fours_count(const Fours *f) { return 3 * LANES * (f->point_fours + f->roll_fours); }
real *fours_impulses(Fours *f) { return f->impulses->at[0]; }

void fours_order(const Fours *f, int *points, int *rolls)
{
    for (int i = 0; i < f->point_fours; i++)
        for (int lane = 0; lane < LANES && f->points[i].of.row[lane] >= 0; lane++)
            *points++ = f->points[i].of.row[lane];
    for (int i = 0; i < f->roll_fours; i++)
        for (int lane = 0; lane < LANES && f->rolls[i].of.row[lane] >= 0; lane++)
            *rolls++ = f->rolls[i].of.row[lane];
}

void fours_close(const Fours *f)
{
    const real *x = f->impulses->at[0];
    for (int i = 0; i < f->g->point_count; i++) {
        PointRow *r = &f->g->points[i];
        r->jn = x[f->place[i]];
        r->jt[0] = x[f->place[i] + LANES];
        r->jt[1] = x[f->place[i] + 2 * LANES];
    }
    for (int i = 0; i < f->roll_fours; i++) {
        const Impulses *j = &f->impulses[f->point_fours + i];
        for (int lane = 0; lane < LANES; lane++)
            if (f->rolls[i].of.row[lane] >= 0)
                f->g->rolls[f->rolls[i].of.row[lane]].j = (vec3){j->at[0][lane], j->at[1][lane], j->at[2][lane]};
    }
}

/* ---- velocities ---- */

typedef struct FourVel { four3 v, w; } FourVel;

/* Of each body v and the first of w, then the other two. */
INLINE FourVel gather(const Vel *vel, const int32_t at[LANES])
{
    four r[4];
    pair p[4];
    UNROLL
    for (int i = 0; i < LANES; i++) {
        r[i] = *(const four_any *)(const void *)&vel[at[i]].v.x;
        p[i] = *(const pair *)(const void *)&vel[at[i]].w.y;
    }
    four_transpose(r);
    four low = SHUFFLE(p[0], p[2], 0, 1, 2, 3), high = SHUFFLE(p[1], p[3], 0, 1, 2, 3);
    return (FourVel){{r[0], r[1], r[2]}, {r[3], SHUFFLE(low, high, 0, 4, 2, 6), SHUFFLE(low, high, 1, 5, 3, 7)}};
}

INLINE void scatter(Vel *vel, const int32_t at[LANES], const FourVel *from)
{
    four r[4] = {from->v.x, from->v.y, from->v.z, from->w.x};
    four low = SHUFFLE(from->w.y, from->w.z, 0, 4, 2, 6), high = SHUFFLE(from->w.y, from->w.z, 1, 5, 3, 7);
    pair p[4] = {SHUFFLE(low, low, 0, 1), SHUFFLE(high, high, 0, 1), SHUFFLE(low, low, 2, 3), SHUFFLE(high, high, 2, 3)};
    four_transpose(r);
    UNROLL
    for (int i = 0; i < LANES; i++) {
        *(four_any *)(void *)&vel[at[i]].v.x = r[i];
        *(pair *)(void *)&vel[at[i]].w.y = p[i];
    }
}

/* Spins alone, and one number more, which goes back as it came. */
INLINE void gather_spins(const Vel *vel, const int32_t at[LANES], four r[4])
{
    UNROLL
    for (int i = 0; i < LANES; i++)
        r[i] = *(const four_any *)(const void *)&vel[at[i]].v.z;
    four_transpose(r);
}

INLINE void scatter_spins(Vel *vel, const int32_t at[LANES], four r[4])
{
    four_transpose(r);
    UNROLL
    for (int i = 0; i < LANES; i++)
        *(four_any *)(void *)&vel[at[i]].v.z = r[i];
}

/* ---- the sweep; see relax.c for what it does ---- */

INLINE four rate_of(const FourDir *d, const FourVel *a, const FourVel *b)
{
    return four3_dot(d->n, four3_sub(b->v, a->v)) + four3_dot(d->aa, a->w) + four3_dot(d->ab, b->w);
}

INLINE void apply(const FourPoints *x, const FourDir *d, FourVel *a, FourVel *b, four p)
{
    a->v = four3_mad(a->v, -p * x->ima, d->n);
    a->w = four3_mad(a->w, p, d->ia);
    b->v = four3_mad(b->v, p * x->imb, d->n);
    b->w = four3_mad(b->w, p, d->ib);
}

INLINE four relax_rubs(const FourPoints *x, four_any *j, FourVel *a, FourVel *b)
{
    four u0 = rate_of(&x->t[0], a, b), u1 = rate_of(&x->t[1], a, b), zero = four_all(0);
    four bound = (j[0] + x->blow) * x->friction;
    four s0 = j[1] - (x->t[1].k * u0 - x->ktt * u1) / x->det, s1 = j[2] - (x->t[0].k * u1 - x->ktt * u0) / x->det;
    four_int sticks = x->sticks & (four_int)(s0 * s0 + s1 * s1 <= bound * bound);
    four j0 = j[1] - u0 / x->kmax, j1 = j[2] - u1 / x->kmax;
    four length = four_root(j0 * j0 + j1 * j1);
    four_int over = (four_int)(length > bound);
    four s = four_pick(over, bound / four_pick(over, length, four_all(1)), four_all(1));
    j0 = four_pick(x->rubs, four_pick(sticks, s0, j0 * s), j[1]);
    j1 = four_pick(x->rubs, four_pick(sticks, s1, j1 * s), j[2]);
    four p0 = four_pick(x->rubs, j0 - j[1], zero), p1 = four_pick(x->rubs, j1 - j[2], zero);
    j[1] = j0;
    j[2] = j1;
    apply(x, &x->t[0], a, b, p0);
    apply(x, &x->t[1], a, b, p1);
    return four_most(four_abs(p0), four_abs(p1)) * x->kmax;
}

INLINE four relax_normals(const FourPoints *x, four_any *j, FourVel *a, FourVel *b)
{
    four error = x->target - rate_of(&x->n, a, b);
    four jn = four_pick(x->acts, four_most(four_all(0), j[0] + error / x->n.k), j[0]);
    four p = jn - j[0];
    j[0] = jn;
    apply(x, &x->n, a, b, p);
    return four_abs(p) * x->n.k;
}

INLINE four relax_rolling(const Fours *f, const FourRolls *x, four_any *j)
{
    const Group *g = f->g;
    const real *impulses = f->impulses->at[0];
    four a[4], b[4], normal = four_all(0);
    for (int lane = 0; lane < LANES && x->of.row[lane] >= 0; lane++) {
        const RollRow *r = &g->rolls[x->of.row[lane]];
        for (int k = r->first; k < r->first + r->count; k++)
            normal[lane] += impulses[f->place[k]] + g->points[k].blow;
    }
    gather_spins(g->vel, x->of.a, a);
    gather_spins(g->vel, x->of.b, b);
    four3 wa = {a[1], a[2], a[3]}, wb = {b[1], b[2], b[3]}, was = {j[0], j[1], j[2]};
    four3 to = four3_sub(was, four33_mul3(&x->inv_k, four3_sub(wb, wa)));
    four length = four_root(four3_dot(to, to)), bound = x->lever * normal;
    four_int over = (four_int)(length > bound);
    to = four3_scale(four_pick(over, bound / four_pick(over, length, four_all(1)), four_all(1)), to);
    four3 p = four3_sub(to, was), da = four33_mul3(&x->ia, p), db = four33_mul3(&x->ib, p);
    j[0] = to.x;
    j[1] = to.y;
    j[2] = to.z;
    scatter_spins(g->vel, x->of.a, (four[4]){a[0], wa.x - da.x, wa.y - da.y, wa.z - da.z});
    scatter_spins(g->vel, x->of.b, (four[4]){b[0], wb.x + db.x, wb.y + db.y, wb.z + db.z});
    return x->reach * four_most(four_root(four3_dot(da, da)), four_root(four3_dot(db, db)));
}

INLINE real relax_fours(Fours *f)
{
    four worst = four_all(0);
    Vel *vel = f->g->vel;
    for (int i = 0; i < f->roll_fours; i++)
        worst = four_most(worst, relax_rolling(f, &f->rolls[i], (four_any *)(void *)&f->impulses[f->point_fours + i]));
    for (int i = 0; i < f->point_fours; i++) {
        const FourPoints *x = &f->points[i];
        four_any *j = (four_any *)(void *)&f->impulses[i];
        FourVel a = gather(vel, x->of.a), b = gather(vel, x->of.b);
        if (x->rub)
            worst = four_most(worst, relax_rubs(x, j, &a, &b));
        worst = four_most(worst, relax_normals(x, j, &a, &b));
        scatter(vel, x->of.a, &a);
        scatter(vel, x->of.b, &b);
    }
    return real_max(real_max(worst[0], worst[1]), real_max(worst[2], worst[3]));
}

/* The first sweep, in the same order: what rests needs no second one, and lanes are not worth filling for it. */
static real relax_rows(Fours *f)
{
    Group *g = f->g;
    real worst = 0;
    for (int i = 0; i < f->roll_fours; i++)
        for (int lane = 0; lane < LANES && f->rolls[i].of.row[lane] >= 0; lane++)
            worst = real_max(worst, relax_roll(g, &g->rolls[f->rolls[i].of.row[lane]]));
    for (int i = 0; i < f->point_fours; i++)
        for (int lane = 0; lane < LANES && f->points[i].of.row[lane] >= 0; lane++)
            worst = real_max(worst, relax_points(g, f->points[i].of.row[lane], 1));
    read_impulses(f);
    f->swept = true;
    return worst;
}

INLINE real relax_next(Fours *f)
{
    if (!f->filled)
        fill(f);
    return relax_fours(f);
}

static real relax_plain(Fours *f) { return relax_next(f); }
WIDE static real relax_wide(Fours *f) { return relax_next(f); }

real fours_relax(Fours *f)
{
    if (!f->swept)
        return relax_rows(f);
    return f->plain || !has_wide() ? relax_plain(f) : relax_wide(f);
}
