/* crowd/rows.c - which contacts act in this step, in batches of twice eight that share no moving body, and their rows.
 *
 * Batches are found by greedy colouring: a contact takes the lowest colour that neither of its moving bodies has yet. Contacts with
 * what does not move have colours of their own and are solved last in every pass, so that nothing is pushed through the ground.
 */
#include "crowd/system.h"
#include "math/reg3.h"

#define COLOURS 64              /* what finds none of them is solved alone                        */
/* A pass that moves a point by less of the size is the last. Where many points share a load, it shifts from one to the other for ever. */
#define NEEDED_ONE  5e-4
#define NEEDED_MANY 1e-2
#define NEAR    0.01            /* of the size: points nearer than this act in any case           */

typedef struct Chosen {         /* what there is to know of a contact before it has a row; of one that does not act: only that */
    int     a, b;               /* the Crowd's bodies; who does not move is none of them */
    uint8_t colour, points;
    bool    acts : 1, fixed : 1, rubs : 1, rolls : 1, driven : 1, bounces : 1, round : 1, shares : 1;
} Chosen;

/* One place for each kind of batch: fixed or not, colour, points; round ones come last. */
#define KINDS_OF_ONE (MANIFOLD_POINTS + 1)      /* colour, fixed or not: these are a phase */
#define PHASES (2 * (COLOURS + 1))
#define KINDS (PHASES * KINDS_OF_ONE)
static int kind_of(const Chosen *x)
{
    return ((int)x->fixed * (COLOURS + 1) + x->colour) * KINDS_OF_ONE + MANIFOLD_POINTS - (x->round ? 0 : x->points);
}

/* Does what comes with this velocity, relative to the other, pass by at its side before the gap could close? A row holds for the present
 * direction only. */
static bool goes_past(const GroupPair *q, real gap, real closing, real speed)
{
    real across2 = speed * speed - closing * closing, reach = q->on_a->shape.outer + q->on_b->shape.outer;
    return gap > q->size && across2 * gap * gap > reach * reach * closing * closing;
}

/* May impacts in this step give it a good part of its speed, or more? Then it goes who knows where. */
static bool is_thrown(const Crowd *c, int body) { return vec3_length(c->g->vel[body].v) < 0.5 * c->stop[body]; }

/* Is that so of this end of a pair, or does it not move and is wider than it is far? A wall is met whichever way what was thrown comes. */
static bool may_come(const Crowd *c, int body, const Shape *s, real gap)
{
    return c->trait[body].moves ? is_thrown(c, body) : gap < s->outer;
}

/* If an impact stops either, the other goes on alone. Not of what is near, or rests: there an impact that throws either to its side matters,
 * too. */
static bool alone_goes_past(const Crowd *c, const GroupContact *t, const ManifoldPoint *p)
{
    const Group *g = c->g;
    const GroupPair *q = &g->pairs[t->pair];
    if (p->gap <= q->size || (may_come(c, t->a, &q->on_a->shape, p->gap) && may_come(c, t->b, &q->on_b->shape, p->gap)))
        return false;
    vec3 n = t->manifold.normal, a = crowd_velocity(g, t->a, p->a), b = crowd_velocity(g, t->b, p->b);
    real to_b = vec3_dot(n, a), to_a = -vec3_dot(n, b);
    return (to_b <= 0 || goes_past(q, p->gap, to_b, vec3_length(a))) && (to_a <= 0 || goes_past(q, p->gap, to_a, vec3_length(b)));
}

/* Might it act within the step? Others may push as hard as the bodies move. */
static bool may_act(const Crowd *c, const GroupContact *t)
{
    const Group *g = c->g;
    const GroupPair *q = &g->pairs[t->pair];
    real near = NEAR * q->size + real_max(c->trait[t->a].pull, c->trait[t->b].pull) * c->dt * c->dt;
    real stop = c->stop ? c->dt * real_max(c->stop[t->a], c->stop[t->b]) : 0;
    for (int k = 0; k < t->manifold.count; k++) {
        const ManifoldPoint *p = &t->manifold.points[k];
        if (p->gap <= near)
            return true;
        real speed, closing = crowd_closing(g, t, p, &speed), way = c->dt * (0.5 * speed + real_max(0, closing));
        bool past = closing > 0 && goes_past(q, p->gap, closing, speed);
        if ((p->gap <= near + way && !past) || (stop > 0 && p->gap <= near + stop + (past ? 0 : way) && !alone_goes_past(c, t, p)))
            return true;
    }
    return false;
}

/* ---- colours ---- */

static int lowest(uint64_t taken) { return taken == UINT64_MAX ? COLOURS : __builtin_ctzll(~taken); }

static void colour(Crowd *c, Chosen *x, uint64_t (*taken)[2])
{
    int a = x->a, b = x->b;
    x->fixed = a == c->bodies || b == c->bodies;
    uint64_t used = (a < c->bodies ? taken[a][x->fixed] : 0) | (b < c->bodies ? taken[b][x->fixed] : 0);
    int at = lowest(used);
    x->colour = (uint8_t)at;
    for (int k = 0; k < 2; k++)
        if ((k ? b : a) < c->bodies) {
            c->frame[k ? b : a].held = true;
            if (at < COLOURS)
                taken[k ? b : a][x->fixed] |= (uint64_t)1 << at;
        }
}

/* m  Radius at which the pair rolls (effect/rolling.c); 0: it does not. */
static real rolling_radius(const GroupPair *q)
{
    real a = q->on_a->shape.rolling, b = q->on_b->shape.rolling;
    return a > 0 && b > 0 ? a * b / (a + b) : real_max(a, b);
}

/* What does not act carries nothing; of what is far off and goes past, the gap along the present direction says nothing either. */
static void forget(const Group *g, GroupContact *t)
{
    bool far = true;
    if (t->manifold.count == 0) {       /* it may have no room for memories either */
        t->live = false;
        return;
    }
    for (int k = 0; k < t->manifold.count; k++)
        far = far && t->manifold.points[k].gap > g->pairs[t->pair].size;
    if (far) {
        t->live = false;
        t->manifold.count = 0;
    }
    for (PointMemory *m = contact_memory(t), *end = m + t->manifold.count; m < end; m++) {
        m->normal = 0;
        m->borne = 0;
        m->held = 0;
        m->tangent = vec3_zero();
    }
    if (t->live && g->contact_rest)
        contact_rest_of(g, t)->rolling = vec3_zero();
}

#define LONE 4                  /* contacts: what fewer are deep by is no load that came down */

/* Of a thread's share: the deepest contacts, in their order, and of those that share a load. */
typedef struct Found { real deep[LONE], shared[LONE]; bool presses; } Found;

typedef struct Rows { Crowd *c; Chosen *chosen; int *sorted; Found *found; } Rows;       /* [contact_count]; sorted: those that act, by their kinds */

static const Chosen *chosen_at(const Rows *r, int i) { return &r->chosen[r->sorted[i]]; }

/* Do several points carry its load together? */
static bool shares_load(const GroupPair *q, const GroupContact *t) { return t->manifold.count > crowd_alone(q); }

/* m  By how much a pass need not move a point. */
static real needed(const GroupPair *q, const GroupContact *t) { return (shares_load(q, t) ? NEEDED_MANY : NEEDED_ONE) * q->size; }

#define STRAIGHT 1e-9           /* rad: rounding */

/* Is the point straight before the centre of this body, which turns alike about all axes? Or does the body not move? */
static bool before_centre(const Crowd *c, int body, vec3 n, vec3 at)
{
    if (!c->trait[body].moves)
        return true;
    vec3 arm = vec3_sub(at, c->g->pos[body].x);
    return c->trait[body].round && vec3_length2(vec3_cross(n, arm)) <= STRAIGHT * STRAIGHT * vec3_length2(arm);
}

static bool is_round(const Crowd *c, const GroupContact *t)
{
    const GroupManifold *m = &t->manifold;
    return m->count == 1 && before_centre(c, t->a, m->normal, m->points[0].a) && before_centre(c, t->b, m->normal, m->points[0].b);
}

static void note_deep(real *most, real deep)
{
    for (int k = 0; k < LONE && deep > most[LONE - 1]; k++)
        if (deep > most[k]) {
            real less = most[k];
            most[k] = deep;
            deep = less;
        }
}

static void choose_share(void *context, int thread, int threads)
{
    const Rows *r = context;
    Crowd *c = r->c;
    Group *g = c->g;
    Found found = {.presses = false};
    for (int i = team_first(g->contact_count, thread, threads), end = team_end(g->contact_count, thread, threads); i < end; i++) {
        GroupContact *t = &g->contacts[i];
        const GroupPair *q = &g->pairs[t->pair];
        const Trait *a = &c->trait[t->a], *b = &c->trait[t->b];
        Chosen *x = &r->chosen[i];
        x->acts = t->live && (a->moves || b->moves) && may_act(c, t);
        if (!x->acts) {
            forget(g, t);
            continue;
        }
        *x = (Chosen){.a = crowd_index(c, t->a), .b = crowd_index(c, t->b), .points = (uint8_t)t->manifold.count, .acts = true,
                      .rubs = q->rub->friction > 0 && !g->decay_friction, .rolls = q->rub->rolling > 0 && rolling_radius(q) > 0,
                      .driven = a->kinematic || b->kinematic, .bounces = q->rub->restitution > 0};
        x->shares = shares_load(q, t);
        x->round = !x->driven && !x->rolls && is_round(c, t);
        real gap = 0;
        for (int k = 0; k < t->manifold.count; k++)
            gap = real_min(gap, t->manifold.points[k].gap);
        real deep = gap < 0 ? -gap / needed(q, t) : 0;
        note_deep(found.deep, deep);
        note_deep(found.shared, x->shares ? deep : 0);
        found.presses = found.presses || x->driven;
    }
    r->found[thread] = found;
}

/* Those that act; returns how many. */
static int colour_all(const Rows *r, uint64_t (*taken)[2], int count[KINDS])
{
    int n = 0;
    for (int i = 0; i < r->c->g->contact_count; i++) {
        Chosen *x = &r->chosen[i];
        r->c->row[i] = -1;
        if (!x->acts)
            continue;
        n++;
        colour(r->c, x, taken);
        count[kind_of(x)]++;
    }
    return n;
}

/* ---- filling lanes ---- */

/* Other threads may write to other lanes at the same time: one number is written, not eight. */
static inline void set(Wide *v, int lane, real x) { v->at[lane] = (float)x; }

static inline void put(Wide v[3], int lane, vec3 x)
{
    set(&v[0], lane, x.x);
    set(&v[1], lane, x.y);
    set(&v[2], lane, x.z);
}

typedef float reg3_short __attribute__((vector_size(16)));

INLINE void put_reg(Wide v[3], int lane, reg3 x)
{
    reg3_short s = __builtin_convertvector(x, reg3_short);
    for (int i = 0; i < 3; i++)
        v[i].at[lane] = s[i];
}

typedef struct Ends {           /* of one contact                                              */
    const GroupContact *c;
    int  a, b;                  /* who does not move: the spare one                            */
    reg3 xa, xb;
    bool driven;                /* a mover takes part                                          */
    real warm;                  /* N s  of a point, at most, that it starts the step with      */
} Ends;

/* Movers at a point: what their speed adds to a rate. */
static vec3 driven_velocity(const Crowd *c, const Ends *e, vec3 at)
{
    vec3 v = vec3_zero();
    if (c->trait[e->c->b].kinematic)
        v = vec3_add(v, crowd_velocity(c->g, e->c->b, at));
    if (c->trait[e->c->a].kinematic)
        v = vec3_sub(v, crowd_velocity(c->g, e->c->a, at));
    return v;
}

/* rad/s  The same of their spins. */
static vec3 driven_spin(const Crowd *c, const GroupContact *t)
{
    vec3 w = vec3_zero();
    if (c->trait[t->b].kinematic)
        w = vec3_add(w, c->g->vel[t->b].w);
    if (c->trait[t->a].kinematic)
        w = vec3_sub(w, c->g->vel[t->a].w);
    return w;
}

/* What a mover drives against a wall, through stones that leave each other no room, bears impulses that no pass brings to an end, each raises
 * them, to those of 5000 m/s: carried on to normals that have turned a little, they throw somebody out at 40 m/s. So no point in a crowd
 * that a mover presses starts with more than moves the lighter one WARM times as fast as both go and holds up WEIGHTS times its weight. What
 * is borne in earnest is found again by the passes. */
#define WARM    1.0
#define WEIGHTS 50.0

static real warm_most(const Crowd *c, const GroupContact *t)
{
    const Group *g = c->g;
    real a = c->trait[t->a].moves ? g->member[t->a].mass : INFINITY, b = c->trait[t->b].moves ? g->member[t->b].mass : INFINITY;
    real speeds = vec3_length(g->vel[t->a].v) + vec3_length(g->vel[t->b].v);
    return real_min(a, b) * (WARM * speeds + WEIGHTS * g->fall * (real)c->h);
}

INLINE void fill_point(const Crowd *c, const Ends *e, const Batch *b, int lane, int k)
{
    const ManifoldPoint *m = &e->c->manifold.points[k];
    const PointMemory *memory = &contact_memory(e->c)[k];
    WidePoint *p = &b->point[k];
    if (b->arms) {
        WideArms *arms = &b->arms[k];
        put_reg(arms->a, lane, e->a < c->bodies ? reg3_load(&m->a) - e->xa : reg3_all(0));
        put_reg(arms->b, lane, e->b < c->bodies ? reg3_load(&m->b) - e->xb : reg3_all(0));
    }
    set(&p->mass, lane, 1);
    set(&p->gap, lane, m->gap);
    set(&p->j, lane, real_min((real)((float)memory->normal * c->h), e->warm));
    set(&p->borne, lane, real_min((real)(memory->borne * c->h), e->warm));
    if (b->drive && e->driven)
        set(&b->drive[k], lane, vec3_dot(e->c->manifold.normal, driven_velocity(c, e, m->a)));
}

INLINE void fill_patch(const Crowd *c, const Ends *e, const Batch *b, int lane)
{
    WidePatch *p = b->patch;
    const GroupManifold *m = &e->c->manifold;
    const PointMemory *memory = contact_memory(e->c);
    vec3 t, u;
    vec3_basis(m->normal, &t, &u);
    put(p->t, lane, t);
    reg3 part = reg3_all(1.0 / m->count), middle = reg3_all(0), force = reg3_all(0), torque = reg3_all(0);
    for (int k = 0; k < m->count; k++) {
        force = force + reg3_load(&memory[k].tangent);
        middle = middle + part * reg3_load(&m->points[k].a);
    }
    set(&p->j[0], lane, (real)((float)reg3_dot(force, reg3_of(t)) * c->h));
    set(&p->j[1], lane, (real)((float)reg3_dot(force, reg3_of(u)) * c->h));
    for (int k = 0; k < m->count; k++)          /* of what the points remember, about their middle */
        torque = torque + reg3_cross(reg3_load(&m->points[k].a) - middle, reg3_load(&memory[k].tangent));
    if (m->count > 1)
        set(&b->twist->j, lane, (real)((float)reg3_dot(reg3_of(m->normal), torque) * c->h));
    if (e->driven) {
        vec3 v = driven_velocity(c, e, reg3_get(middle));
        set(&b->drive[b->points], lane, vec3_dot(v, t));
        set(&b->drive[b->points + 1], lane, vec3_dot(v, u));
        set(&b->drive[b->points + 2], lane, vec3_dot(m->normal, driven_spin(c, e->c)));
    }
}

INLINE void fill_rub(const Crowd *c, const Ends *e, WideRub *r, int lane)
{
    const GroupManifold *m = &e->c->manifold;
    reg3 n = reg3_of(m->normal);
    set(&r->a, lane, e->a < c->bodies ? reg3_dot(n, reg3_load(&m->points[0].a) - e->xa) : 0);
    set(&r->b, lane, e->b < c->bodies ? reg3_dot(n, e->xb - reg3_load(&m->points[0].b)) : 0);
    put_reg(r->j, lane, reg3_all((real)c->h) * reg3_load(&contact_memory(e->c)->tangent));
}

static void put_matrix(Wide *v, int lane, mat3 m)
{
    put(v, lane, m.r0);
    put(v + 3, lane, m.r1);
    put(v + 6, lane, m.r2);
}

static void fill_roll(const Crowd *c, const Ends *e, const GroupPair *q, WideRoll *r, int lane)
{
    const Group *g = c->g;
    mat3 k = mat3_add(group_inverse_inertia(g, e->c->a), group_inverse_inertia(g, e->c->b));
    if (!(mat3_det(k) > 0))
        return;
    k = mat3_inverse(k);
    if (e->a < c->bodies)
        put_matrix(r->sa, lane, body_axes(c, e->a));
    if (e->b < c->bodies)
        put_matrix(r->sb, lane, body_axes(c, e->b));
    put(r->k, lane, k.r0);
    set(&r->k[3], lane, k.r1.y);
    set(&r->k[4], lane, k.r1.z);
    set(&r->k[5], lane, k.r2.z);
    put(r->drive, lane, driven_spin(c, e->c));
    set(&r->lever, lane, q->rub->rolling * rolling_radius(q));
    put(r->j, lane, vec3_scale((real)c->h, contact_rolling(g, e->c)));
}

INLINE Ends ends_of(const Crowd *c, const GroupContact *t)
{
    const Group *g = c->g;
    Ends e = {.c = t, .a = crowd_index(c, t->a), .b = crowd_index(c, t->b), .xa = reg3_of(g->pos[t->a].x), .xb = reg3_of(g->pos[t->b].x)};
    e.driven = c->trait[t->a].kinematic || c->trait[t->b].kinematic;
    e.warm = c->presses ? warm_most(c, t) : INFINITY;
    return e;
}

/* m/s per square root of the size in metres: slower slip than this sticks */
#define SLIPS 1e-3

static bool slides(const Group *g, const GroupContact *c, const GroupPair *q)
{
    vec3 at = c->manifold.points[0].a, v = vec3_sub(crowd_velocity(g, c->b, at), crowd_velocity(g, c->a, at));
    vec3 slip = vec3_mad(v, -vec3_dot(v, c->manifold.normal), c->manifold.normal);
    return vec3_length2(slip) > SLIPS * SLIPS * q->size * g->fall;
}

INLINE void fill_lane(Crowd *c, Batch *b, int lane, GroupContact *t)
{
    const Group *g = c->g;
    const GroupPair *q = &g->pairs[t->pair];
    Ends e = ends_of(c, t);
    b->a[lane] = e.a;
    b->b[lane] = e.b;
    put(b->of->n, lane, t->manifold.normal);
    set(&b->of->restitution, lane, q->rub->restitution);
    t->manifold.slides = q->rub->friction > q->rub->friction_dynamic && slides(g, t, q);
    set(&b->of->friction, lane, t->manifold.slides ? q->rub->friction_dynamic : q->rub->friction);
    set(&b->of->care, lane, (real)(c->h / (float)needed(q, t)));
    for (int k = 0; k < t->manifold.count; k++)
        fill_point(c, &e, b, lane, k);
    if (b->rub)
        fill_rub(c, &e, b->rub, lane);
    if (b->patch)
        fill_patch(c, &e, b, lane);
    if (b->roll && q->rub->rolling > 0 && rolling_radius(q) > 0)
        fill_roll(c, &e, q, b->roll, lane);
}

static void *room_for(Crowd *c, size_t bytes, dig_status *status)
{
    void *p = spare_find(&c->idle, bytes);
    p = p ? p : spare_take(&c->g->spare, c->g->lasting, bytes);
    *status = p ? *status : DIG_E_MEMORY;
    return p;
}

static size_t drive_bytes(const Batch *b) { return (size_t)(b->points + 3) * sizeof *b->drive; }

/* What not every lane fills must hold 0. */
static void clear(Batch *b)
{
    memset(b->of, 0, sizeof *b->of);
    memset(b->point, 0, (size_t)b->points * sizeof *b->point);
    if (b->arms)
        memset(b->arms, 0, (size_t)b->points * sizeof *b->arms);
    if (b->drive)
        memset(b->drive, 0, drive_bytes(b));
    if (b->rub)
        memset(b->rub, 0, sizeof *b->rub);
    if (b->patch)
        memset(b->patch, 0, sizeof *b->patch);
    if (b->twist)
        memset(b->twist, 0, sizeof *b->twist);
    if (b->roll)
        memset(b->roll, 0, sizeof *b->roll);
}

/* What a batch of so many of the sorted contacts needs, from number i on. */
static Batch kind_of_batch(const Rows *r, int i, int count)
{
    const Chosen *first = chosen_at(r, i);
    Batch b = {.points = first->points, .fixed = first->fixed, .round = first->round, .halves = 1, .shares = true};
    for (int end = i + count; i < end; i++) {
        const Chosen *x = chosen_at(r, i);
        b.whole += x->points == first->points;
        b.shares = b.shares && x->shares;
        b.rubs = b.rubs || x->rubs;
        b.rolls = b.rolls || x->rolls;
        b.driven = b.driven || x->driven;
        b.bounces = b.bounces || x->bounces;
    }
    return b;
}

static bool alike(const Batch *a, const Batch *b)
{
    return a->points == b->points && a->round == b->round && a->rubs == b->rubs && a->rolls == b->rolls && a->driven == b->driven &&
           a->bounces == b->bounces && a->shares == b->shares;
}

/* Room for the rows of a batch. */
static dig_status make_batch(Crowd *c, Batch *b)
{
    dig_status status = DIG_OK;
    b->of = room_for(c, sizeof *b->of + (size_t)b->points * (sizeof *b->point + (b->round ? 0 : sizeof *b->arms)), &status);
    if (status != DIG_OK)
        return status;
    b->point = (WidePoint *)(void *)(b->of + 1);
    b->arms = b->round ? NULL : (WideArms *)(void *)(b->point + b->points);
    b->rub = b->rubs && b->round ? room_for(c, sizeof *b->rub, &status) : NULL;
    b->drive = b->driven ? room_for(c, drive_bytes(b), &status) : NULL;
    b->patch = b->rubs && !b->round ? room_for(c, sizeof *b->patch, &status) : NULL;
    b->twist = b->rubs && b->points > 1 ? room_for(c, sizeof *b->twist, &status) : NULL;
    b->roll = b->rolls ? room_for(c, sizeof *b->roll, &status) : NULL;
    for (int k = 0; k < LANES; k++)
        b->a[k] = b->b[k] = c->bodies;
    return status;
}

/* So many contacts of a phase that ends there are one lot, from number i on. */
static int lanes_from(bool alone, int i, int end) { return alone ? 1 : int_min(HALF, end - i); }

typedef struct Strand { int next, end; } Strand;        /* sorted contacts of a colour with as many points, and so in the order of contacts */

/* Of what the strands begin with, that whose contact comes first; NULL: they are used up. */
static Strand *first_of(const Rows *r, Strand *strand, int strands)
{
    Strand *first = NULL;
    for (Strand *s = strand; s < strand + strands; s++)
        if (s->next < s->end && (!first || r->sorted[s->next] < r->sorted[first->next]))
            first = s;
    return first;
}

#define WAITING_MOST 16         /* kinds: more than there are in a pile */

typedef struct Waiting { int batch[WAITING_MOST], count; } Waiting;     /* of a phase, for another half: one of each kind */

/* Puts a lot of contacts into the other half of a batch of its kind, or into a new one. What is alone stays alone. */
static void add_lot(const Rows *r, const Phase *p, Waiting *w, int lot, int count)
{
    Crowd *c = r->c;
    Batch b = kind_of_batch(r, lot, count);
    int k = 0, at = c->batches, first = 0;
    while (k < w->count && !alike(&c->batch[w->batch[k]], &b))
        k++;
    if (k < w->count) {
        at = w->batch[k];
        first = HALF;
        w->batch[k] = w->batch[--w->count];
        c->batch[at].halves = 2;
        c->batch[at].whole += b.whole;
    } else if (k < WAITING_MOST && !p->alone) {
        w->batch[w->count++] = at;
    }
    for (int i = 0; i < count; i++)
        c->row[r->sorted[lot + i]] = at * LANES + first + i;
    if (first == 0)
        c->batch[c->batches++] = b;
}

/* The batches of one colour: i <= number of a sorted contact < end, those with most points first, eight by eight, and two by two of these. They
 * come in the order of contacts whatever their points (within a colour that is free): a thread has nearly the same bodies in each colour then,
 * where what lies side by side has numbers near each other. What is alone keeps its order. */
static void make_phase(const Rows *r, bool alone, int i, int end)
{
    Crowd *c = r->c;
    Phase *p = &c->phase[c->phases++];
    Strand strand[MANIFOLD_POINTS + 1], *s;
    Waiting waiting = {.count = 0};
    int strands = 0;
    *p = (Phase){.first = c->batches, .alone = alone};
    for (int before = i; i < end; before = i, i += lanes_from(alone, i, end)) {
        if (strands == 0 || (r->sorted[i] < r->sorted[before] && !alone))
            strand[strands++].next = i;
        strand[strands - 1].end = i + lanes_from(alone, i, end);
    }
    while ((s = first_of(r, strand, strands)) != NULL) {
        int n = lanes_from(alone, s->next, end);
        add_lot(r, p, &waiting, s->next, n);
        s->next += n;
    }
    p->count = c->batches - p->first;
}

static bool is_alone(int phase) { return phase % (COLOURS + 1) == COLOURS; }

/* Among the sorted contacts. ends: of each kind. */
static int first_in(const int *ends, int phase) { return phase > 0 ? ends[phase * KINDS_OF_ONE - 1] : 0; }

static dig_status make_batches(const Rows *r, const int *ends)
{
    Crowd *c = r->c;
    Group *g = c->g;
    int lots = 0;
    for (int i = 0; i < PHASES; i++) {
        int count = first_in(ends, i + 1) - first_in(ends, i);
        lots += is_alone(i) ? count : (count + HALF - 1) / HALF;
    }
    c->phase = arena_alloc(g->lasting, PHASES * sizeof *c->phase);
    c->batch = spare_take(&g->spare, g->lasting, (size_t)lots * sizeof *c->batch);
    if (!c->batch || !c->phase)
        return DIG_E_MEMORY;
    for (int i = 0; i < PHASES; i++)
        if (first_in(ends, i + 1) > first_in(ends, i))
            make_phase(r, is_alone(i), first_in(ends, i), first_in(ends, i + 1));
    spare_trim(&g->spare, g->lasting, c->batch, (size_t)lots * sizeof *c->batch, (size_t)c->batches * sizeof *c->batch);      /* two lots are one, mostly */
    return DIG_OK;
}

/* Room for the rows of all batches; what lies idle first. */
static dig_status open_batches(Crowd *c)
{
    c->idle = NULL;
    spare_lend(&c->idle, c->g->idle, c->g->idle_bytes);
    for (Batch *b = c->batch; b < c->batch + c->batches; b++) {
        DIG_TRY(make_batch(c, b));
        if (b->whole < LANES || b->driven || b->roll)
            clear(b);
    }
    return DIG_OK;
}

/* In the order of contacts: those of a colour fill its batches one after the other, so that the few that are being filled stay in the
 * cache, and contacts, pairs and points are read as they lie. */
INLINE void fill_part(void *context, int thread, int threads)
{
    Crowd *c = context;
    int count = c->g->contact_count;
    for (int i = team_first(count, thread, threads), end = team_end(count, thread, threads); i < end; i++)
        if (c->row[i] >= 0)
            fill_lane(c, &c->batch[c->row[i] / LANES], c->row[i] % LANES, &c->g->contacts[i]);
}

FOR_WIDTHS(fill_share, fill_part)

dig_status rows_open(Crowd *c)
{
    Group *g = c->g;
    int shares = team_shares(g->team);
    Rows r = {.c = c, .chosen = spare_take(&g->spare, g->lasting, (size_t)(g->contact_count + 1) * sizeof *r.chosen)};
    uint64_t (*taken)[2] = spare_take(&g->spare, g->lasting, (size_t)(c->bodies + 1) * sizeof *taken);
    c->row = spare_take(&g->spare, g->lasting, (size_t)(g->contact_count + 1) * sizeof *c->row);
    r.found = arena_alloc(g->lasting, (size_t)shares * sizeof *r.found);
    if (!r.chosen || !taken || !c->row || !r.found)
        return DIG_E_MEMORY;
    memset(taken, 0, (size_t)(c->bodies + 1) * sizeof *taken);
    int place[KINDS] = {0};
    team_deal(g->team, choose_share, &r);
    if (c->stop)
        spare_add(&g->spare, c->stop, (size_t)g->body_count * sizeof *c->stop);
    c->stop = NULL;
    real deep[LONE] = {0}, shared[LONE] = {0};
    for (int i = 0; i < shares; i++) {
        for (int k = 0; k < LONE; k++) {
            note_deep(deep, r.found[i].deep[k]);
            note_deep(shared, r.found[i].shared[k]);
        }
        c->presses = c->presses || (g->driven && r.found[i].presses);
    }
    c->deep = deep[0];
    c->load = deep[LONE - 1];
    c->sags = shared[0];
    c->shared = shared[LONE - 1];
    int acting = colour_all(&r, taken, place);
    spare_add(&g->spare, taken, (size_t)(c->bodies + 1) * sizeof *taken);
    r.sorted = spare_take(&g->spare, g->lasting, (size_t)acting * sizeof *r.sorted);
    if (!r.sorted)
        return DIG_E_MEMORY;
    for (int i = 0, sum = 0; i < KINDS; i++) {
        int n = place[i];
        place[i] = sum;
        sum += n;
    }
    for (int i = 0; i < g->contact_count; i++)
        if (r.chosen[i].acts)
            r.sorted[place[kind_of(&r.chosen[i])]++] = i;
    DIG_TRY(make_batches(&r, place));
    spare_add(&g->spare, r.sorted, (size_t)acting * sizeof *r.sorted);
    spare_add(&g->spare, r.chosen, (size_t)(g->contact_count + 1) * sizeof *r.chosen);
    DIG_TRY(open_batches(c));
    team_deal(g->team, fill_share(c), c);
    return DIG_OK;
}
