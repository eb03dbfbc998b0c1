/* crowd/touch.c - contacts of the present poses, once a step.
 *
 * A manifold of three or four points whose two sides have hardly moved against each other is not made anew: its points, carried along
 * with their bodies at the end of the last step, still face each other. That they belong to the present poses is told by a sign
 * of the poses, kept where the pair has its hint. Other contacts, manifolds with a corner that is too high for this, and those that are
 * nearly a line, about which bodies may turn with no point moving, are kept until their bodies have gone too far.
 */
#include "crowd/system.h"
#include "math/reg3.h"

#define CARRIED 0x63617272u     /* kind of a hint that holds a sign; no shape pair has this one   */
#define SLID    2e-3            /* of the size: points that have slid farther are found anew      */
#define TILTED  4e-3            /* of the size: so are manifolds whose gaps differ by more        */
#define NARROW  0.1             /* of the size: three points that are narrower are a line, four that are half as wide */
#define STAYS   2e-3            /* of the size: so far may bodies of other contacts go against each other till then */
#define FARTHER 0.05            /* of the size: so much farther is looked for what is near        */
#define LOOKS   0.01            /* of the size: what contacts look ahead for in any case          */

/* Three numbers that are the same as long as neither body moves. */
static vec3 sign_of(const Group *g, const GroupPair *q)
{
    const Pos *a = &g->pos[q->a], *b = &g->pos[q->b];
    vec3 turns = {0.5 * a->q.x + 0.25 * b->q.x, 0.5 * a->q.y + 0.25 * b->q.y, 0.5 * a->q.z + 0.25 * b->q.z};
    return vec3_add(turns, vec3_mad(b->x, 0.75, a->x));
}

/* Do its three or four points span no area? They lie in order about it. */
static bool is_line(const GroupPair *q, const GroupManifold *m)
{
    const ManifoldPoint *p = m->points;
    vec3 d = vec3_sub(p[2].a, p[0].a), e = m->count == 4 ? vec3_sub(p[3].a, p[1].a) : vec3_sub(p[1].a, p[0].a);
    real longest = real_max(real_max(vec3_length2(d), vec3_length2(e)), m->count == 4 ? 0 : vec3_length2(vec3_sub(p[2].a, p[1].a)));
    return vec3_length2(vec3_cross(d, e)) < NARROW * NARROW * q->size * q->size * longest;
}

/* It has three points or more: no ball. */
void crowd_sign(const Group *g, GroupPair *q)
{
    if (q->hint->kind != CARRIED && is_line(q, &g->contacts[q->contact].manifold))      /* found anew in this step */
        return;
    vec3 s = sign_of(g, q);
    *q->hint = (ManifoldCache){.kind = CARRIED, .axis = {s.x, s.y, s.z}};
}

INLINE bool keeps(const Group *g, GroupPair *q)
{
    if (q->fresh || !q->hint || q->hint->kind != CARRIED)
        return false;
    GroupContact *c = &g->contacts[q->contact];
    vec3 s = sign_of(g, q);
    if (c->manifold.count < 3 || s.x != q->hint->axis[0] || s.y != q->hint->axis[1] || s.z != q->hint->axis[2])
        return false;
    const reg3 n = reg3_of(c->manifold.normal);
    real low = INFINITY, high = -INFINITY, slid = 0;
    for (ManifoldPoint *p = c->manifold.points, *end = p + c->manifold.count; p < end; p++) {
        reg3 d = reg3_load(&p->b) - reg3_load(&p->a);
        p->gap = reg3_dot(d, n);
        low = real_min(low, p->gap);
        high = real_max(high, p->gap);
        slid = real_max(slid, reg3_length2(d - reg3_all(p->gap) * n));
    }
    return slid < SLID * SLID * q->size * q->size && high - low < TILTED * q->size && high < SLID * q->size;
}

/* Of one or two points, none, or a tilted manifold: as long as its bodies have moved so little since they were found that the normal is still right. What
 * both of them moved in common does not count (book.c). */
INLINE bool stays(const Crowd *crowd, const GroupPair *q)
{
    GroupContact *c = &crowd->g->contacts[q->contact];
    real travel = crowd->trait[q->a].travel + crowd->trait[q->b].travel;
    if (q->fresh || c->manifold.count == 0 || travel > q->until)
        return false;
    const reg3 n = reg3_of(c->manifold.normal);
    for (int k = 0; k < c->manifold.count; k++) {
        ManifoldPoint *p = &c->manifold.points[k];
        p->gap = reg3_dot(reg3_load(&p->b) - reg3_load(&p->a), n);
    }
    return true;
}

/* Will keeps() have to refuse a manifold that lies like this? */
static bool is_tilted(const GroupPair *q, const GroupManifold *m)
{
    real low = INFINITY, high = -INFINITY;
    for (int k = 0; k < m->count; k++) {
        low = real_min(low, m->points[k].gap);
        high = real_max(high, m->points[k].gap);
    }
    return high >= SLID * q->size || high - low >= TILTED * q->size;
}

/* For how long the contact that was found will do. room: m  between the two, where there is none. */
static void note_until(const Crowd *crowd, GroupPair *q, real room)
{
    const GroupContact *c = &crowd->g->contacts[q->contact];
    real travel = crowd->trait[q->a].travel + crowd->trait[q->b].travel;
    if (!c->live)
        q->until = travel + room - LOOKS * q->size;
    else if (c->manifold.count >= 3 ? is_tilted(q, &c->manifold) || is_line(q, &c->manifold)
                                    : !(q->on_a->shape.round > 0 && q->on_b->shape.round > 0 && c->manifold.room == 1))
        q->until = travel + STAYS * q->size;
}

/* The sign took the place of the hint, but the normal went with the bodies. */
static void restore_hint(const Group *g, GroupPair *q)
{
    quat turn = group_shape_pose(g, q->a, pair_local(q, false)).q;
    *q->hint = manifold_hint(quat_rotate(quat_conjugate(turn), g->contacts[q->contact].manifold.normal));
}

static void find(const Crowd *crowd, GroupPair *q)
{
    if (q->hint && q->hint->kind == CARRIED)
        restore_hint(crowd->g, q);
    note_until(crowd, q, group_touch_convex(crowd->g, q, crowd->dt, FARTHER * q->size));
}

real crowd_closing(const Group *g, const GroupContact *t, const ManifoldPoint *p, real *speed)
{
    vec3 v = vec3_sub(crowd_velocity(g, t->b, p->b), crowd_velocity(g, t->a, p->a));
    *speed = vec3_length(v);
    return -vec3_dot(v, t->manifold.normal);
}

#define BRISK 5e-3              /* of the size: what closes by more in a step may stop a body that others are close behind */

/* m/s  The fastest that a contact closes which it may do in the step; 0: none does, or too slowly to matter. */
static real struck(const Group *g, const GroupPair *q, real dt)
{
    real most = 0, speed;
    for (int i = q->contact; i < q->contact + q->contacts; i++) {
        const GroupContact *t = &g->contacts[i];
        for (int k = 0; t->live && k < t->manifold.count; k++) {
            real closing = crowd_closing(g, t, &t->manifold.points[k], &speed);
            if (closing * dt > real_max(t->manifold.points[k].gap, BRISK * q->size))
                most = real_max(most, closing);
        }
    }
    return most;
}

/* What blows ask of a pair, close together, for the pairs of thousands of bodies fit no cache. */
typedef struct Ends {
    int   a, b;
    float struck;               /* m/s  see struck()                                                                  */
    float reach, size;          /* m    the pair's; its reach rounded down, so that what is within it is within that  */
    float restitution;
    real  gap;                  /* m    the least, once there was a blow                                              */
} Ends;

#define ROUNDED (1 - 0x1p-22)   /* 1  times this a number is no larger as a float */

static void note_reach(Ends *e, const GroupPair *q) { e->reach = (float)(ROUNDED * q->reach); }

typedef struct Touching { const Crowd *c; Ends *ends; int first; } Touching;       /* from this pair on */

/* False: its bodies have hardly moved, and it was left as it was. */
INLINE bool touch_pair(const Crowd *c, GroupPair *q)
{
    if (q->contacts == 1 && (keeps(c->g, q) || stays(c, q)))
        return false;
    if (q->contacts == 1)
        find(c, q);
    else
        group_touch_pair(c->g, q, c->dt);
    return true;
}

INLINE void touch_part(void *context, int thread, int threads)
{
    const Touching *t = context;
    const Group *g = t->c->g;
    int count = g->pair_count - t->first;
    for (int i = t->first + team_first(count, thread, threads), end = t->first + team_end(count, thread, threads); i < end; i++) {
        GroupPair *q = &g->pairs[i];
        t->ends[i] = (Ends){.a = q->a, .b = q->b, .size = (float)q->size, .restitution = (float)q->rub->restitution};
        bool found = touch_pair(t->c, q);
        note_reach(&t->ends[i], q);
        if (found && q->reach > (BRISK + LOOKS) * q->size)        /* it looked so far ahead, for the pair is fast */
            t->ends[i].struck = (float)struck(g, q, t->c->dt);
    }
}

FOR_WIDTHS(touch_share, touch_part)

/* m  Infinite: nothing is near. */
static real least_gap(const Group *g, const GroupPair *q)
{
    real gap = INFINITY;
    for (int i = q->contact; i < q->contact + q->contacts; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            gap = real_min(gap, g->contacts[i].manifold.points[k].gap);
    return gap;
}

/* By all threads, for to look at a contact is a miss. */
static void gap_share(void *context, int thread, int threads)
{
    const Touching *t = context;
    const Group *g = t->c->g;
    int count = g->pair_count - t->first;
    for (int i = t->first + team_first(count, thread, threads), end = t->first + team_end(count, thread, threads); i < end; i++)
        t->ends[i].gap = least_gap(g, &g->pairs[i]);
}

/* What a blow asks of a body, close together. */
typedef struct Weight {
    real mass, speed;           /* kg, m/s                                                        */
    real behind;                /* kg  mass behind Crowd.stop: of the two that met                */
    bool moves;
} Weight;

/* What impacts may do to the bodies of a crowd. */
typedef struct Blows {
    Crowd   *c;
    Ends    *ends;
    Weight  *weight;            /* [body_count of g] */
    uint8_t *news;              /* [body_count of g] number of the round in which its stop was changed last, counted from 1; 0 = in none */
    int     *first, *pairs;     /* [body_count of g + 1], [2 pairs] those that were there at first, body by body               */
    int     *later, *next;      /* [body_count of g], [2 pairs that came later] lists of these, as 2 (pair - early) + side; < 0: no more */
    int      early;             /* so many were there at first */
    int     *tally;             /* [threads, body_count of g] of the pairs that each thread lists, how many; then where the next one goes */
    uint64_t *looks[2];         /* a bit a pair: to be looked at in this round, in the next one */
} Blows;

/* m/s  By how much y may be changed, when x is by so much: y runs into x as fast as it moves, or is pushed by x, and shares the impulse. */
static real passed_on(const Blows *s, const Ends *e, int x, int y)
{
    const Weight *to = &s->weight[y];
    real most = s->c->stop[x], mass = s->weight[x].behind, part = isinf(mass) ? 1 : mass / (mass + to->mass), share = (1 + (real)e->restitution) * part;
    return real_min(most, real_max(to->speed, share * most));
}

#define NEWS 1.1                /* times what was known: what is less is not passed on */

static bool is_reached(const Ends *e, const GroupPair *q) { return e->gap <= (real)e->reach || e->gap <= q->reach; }

/* What comes of it for the other end of a pair that an impact may stop one. */
typedef struct Follow {
    int  from, to;              /* bodies                                                          */
    real way, passed;           /* m  that it goes farther; m/s  by so much the other may be changed */
    bool news, looks;           /* that is more than was known; its contact is to be looked for so far */
} Follow;

/* Does anything come of it? To look at the pair itself would be a miss, and mostly need not be. */
static bool may_follow(const Blows *s, const Ends *e, const GroupPair *q, Follow *f)
{
    const Crowd *c = s->c;
    f->from = c->stop[e->a] >= c->stop[e->b] ? e->a : e->b;
    f->to = f->from == e->a ? e->b : e->a;
    real most = c->stop[f->from], known = NEWS * c->stop[f->to];
    f->way = most * c->dt;
    bool within = (real)e->reach >= f->way;
    if ((most <= known && within) || !(f->way > BRISK * (real)e->size))
        return false;
    f->passed = s->weight[f->to].moves ? passed_on(s, e, f->from, f->to) : 0;       /* a wall is looked at, too, but hands nothing on */
    f->news = f->passed > known;
    f->looks = !within && e->gap > 0 && q->reach < f->way;
    return f->looks || (f->news && is_reached(e, q));
}

/* Can the other get there in this step? Then it may be stopped, too: the body; else -1. */
static int follow(const Blows *s, Ends *e, GroupPair *q)
{
    Crowd *c = s->c;
    Follow f;
    if (!may_follow(s, e, q, &f))
        return -1;
    if (f.looks) {
        real room = group_touch_within(c->g, q, f.way + q->reach);
        if (q->contacts == 1)
            note_until(c, q, room);
        note_reach(e, q);
        e->gap = least_gap(c->g, q);
    }
    if (!f.news || !is_reached(e, q))
        return -1;
    c->stop[f.to] = f.passed;
    s->weight[f.to].behind = s->weight[f.from].behind;
    return f.to;
}

#define FOLLOWERS 32            /* as many bodies one behind the other */

static void weigh_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    const Group *g = s->c->g;
    for (int i = team_first(g->body_count, thread, threads), end = team_end(g->body_count, thread, threads); i < end; i++)
        s->weight[i] = (Weight){.mass = g->member[i].mass, .speed = vec3_length(g->vel[i].v), .moves = s->c->trait[i].moves};
}

static void tally_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    int *tally = s->tally + (size_t)thread * (size_t)s->c->g->body_count;
    for (int i = team_first(s->early, thread, threads), end = team_end(s->early, thread, threads); i < end; i++) {
        tally[s->ends[i].a]++;
        tally[s->ends[i].b]++;
    }
}

static void list_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    int *tally = s->tally + (size_t)thread * (size_t)s->c->g->body_count;
    for (int i = team_first(s->early, thread, threads), end = team_end(s->early, thread, threads); i < end; i++) {
        s->pairs[tally[s->ends[i].a]++] = i;
        s->pairs[tally[s->ends[i].b]++] = i;
    }
}

/* The pairs of each body, in their order: a list is read in one go. */
static void list_early(Blows *s)
{
    const Group *g = s->c->g;
    int threads = g->team ? g->team->threads : 1, count = 0;
    team_run(g->team, tally_share, s);
    for (int i = 0; i < g->body_count; i++) {
        s->first[i] = count;
        for (int t = 0; t < threads; t++) {
            int *tally = &s->tally[t * g->body_count + i], more = *tally;
            *tally = count;
            count += more;
        }
    }
    s->first[g->body_count] = count;
    team_run(g->team, list_share, s);
}

static void list_later(const Blows *s, int from, int end)
{
    for (int i = 2 * (from - s->early); i < 2 * (end - s->early); i++) {
        const Ends *e = &s->ends[s->early + i / 2];
        int body = i % 2 ? e->b : e->a;
        s->next[i] = s->later[body];
        s->later[body] = i;
    }
}

static inline void mark(uint64_t *looks, int i) { looks[i / 64] |= (uint64_t)1 << i % 64; }

/* There is news of this body, from pair number i: its pairs are looked at in the next round, and those after that one in this. */
static void tell_pairs(const Blows *s, int body, int i)
{
    for (int k = s->first[body], end = s->first[body + 1]; k < end; k++) {
        mark(s->looks[1], s->pairs[k]);
        if (s->pairs[k] > i)
            mark(s->looks[0], s->pairs[k]);
    }
    for (int k = s->later[body]; k >= 0; k = s->next[k]) {
        mark(s->looks[1], s->early + k / 2);
        if (s->early + k / 2 > i)
            mark(s->looks[0], s->early + k / 2);
    }
}

/* kg  What is behind the ends of a pair that was struck. */
static real mass_behind(const Blows *s, int x, int y)
{
    const Trait *a = &s->c->trait[x], *b = &s->c->trait[y];
    bool driven = a->kinematic || b->kinematic;      /* does not give way */
    return driven ? INFINITY : (a->moves ? s->weight[x].mass : 0) + (b->moves ? s->weight[y].mass : 0);
}

/* The ends of a pair that was struck may be stopped. */
static void note_stops(const Blows *s, const Ends *e)
{
    real mass = mass_behind(s, e->a, e->b);
    for (int k = 0; k < 2; k++) {
        int body = k ? e->b : e->a;
        if (!s->c->trait[body].moves)
            continue;
        s->c->stop[body] = real_max(s->c->stop[body], (real)e->struck);
        s->weight[body].behind = real_max(s->weight[body].behind, mass);
        if (s->news[body] == 0)
            tell_pairs(s, body, -1);
        s->news[body] = 1;
    }
}

/* The same body by body, for all threads: of what was struck, the most. */
static void stop_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    const Crowd *c = s->c;
    for (int i = team_first(c->g->body_count, thread, threads), end = team_end(c->g->body_count, thread, threads); i < end; i++)
        for (int k = s->first[i]; c->trait[i].moves && k < s->first[i + 1]; k++) {
            const Ends *e = &s->ends[s->pairs[k]];
            if (!(e->struck > 0))
                continue;
            c->stop[i] = real_max(c->stop[i], (real)e->struck);
            s->weight[i].behind = real_max(s->weight[i].behind, mass_behind(s, e->a, e->b));
            s->news[i] = 1;
        }
}

/* Pairs of bodies with news. */
static void mark_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    int words = s->early / 64 + 1;
    for (int w = team_first(words, thread, threads), end = team_end(words, thread, threads); w < end; w++) {
        uint64_t marks = 0;
        for (int i = 64 * w; i < int_min(64 * (w + 1), s->early); i++)
            marks |= (uint64_t)(s->news[s->ends[i].a] | s->news[s->ends[i].b]) << i % 64;
        s->looks[0][w] = s->looks[1][w] = marks;
    }
}

#define TEAM_LEAST 64           /* pairs that come in: fewer are not worth a team */

/* Pairs that the blows known by now may bring together; those of bodies with news are looked at. */
static dig_status touch_struck(const Blows *s, int round)
{
    Ends *ends = s->ends;
    Group *g = s->c->g;
    Touching t = {s->c, ends, g->pair_count};
    DIG_TRY(group_gather_struck(g, s->c->stop, s->c->dt));
    Team *team = g->pair_count - t.first < TEAM_LEAST ? NULL : g->team;
    team_deal(team, touch_share(s->c), &t);
    team_deal(team, gap_share, &t);
    list_later(s, t.first, g->pair_count);
    for (int i = t.first; i < g->pair_count; i++) {
        int latest = int_max(s->news[ends[i].a], s->news[ends[i].b]);
        if (latest > 0 && latest >= round - 1)
            mark(s->looks[0], i);
        if (latest >= round)
            mark(s->looks[1], i);
    }
    return DIG_OK;
}

/* most: pairs there can be. */
static dig_status open_blows(Blows *s, size_t most)
{
    Crowd *c = s->c;
    Group *g = c->g;
    size_t count = (size_t)g->body_count, words = most / 64 + 1, threads = g->team ? (size_t)g->team->threads : 1;
    s->early = g->pair_count;
    c->stop = arena_zero(g->lasting, count * sizeof *c->stop);
    s->news = arena_zero(g->lasting, count);
    s->looks[0] = arena_zero(g->lasting, 2 * words * sizeof *s->looks[0]);
    s->looks[1] = s->looks[0] + words;
    s->weight = spare_take(&g->spare, g->lasting, count * sizeof *s->weight);
    s->first = spare_take(&g->spare, g->lasting, (2 * count + 1) * sizeof *s->first);
    s->pairs = spare_take(&g->spare, g->lasting, 2 * most * sizeof *s->pairs);
    s->tally = spare_take(&g->spare, g->lasting, threads * count * sizeof *s->tally);
    if (!c->stop || !s->news || !s->looks[0] || !s->weight || !s->first || !s->pairs || !s->tally)
        return DIG_E_MEMORY;
    s->later = s->first + count + 1;
    s->next = s->pairs + 2 * s->early;
    memset(s->later, 0xff, count * sizeof *s->later);
    memset(s->tally, 0, threads * count * sizeof *s->tally);
    team_deal(g->team, gap_share, &(Touching){c, s->ends, 0});
    team_deal(g->team, weigh_share, s);
    list_early(s);
    return DIG_OK;
}

static void close_blows(Blows *s, size_t most)
{
    Group *g = s->c->g;
    size_t count = (size_t)g->body_count, threads = g->team ? (size_t)g->team->threads : 1;
    spare_add(&g->spare, s->tally, threads * count * sizeof *s->tally);
    spare_add(&g->spare, s->pairs, 2 * most * sizeof *s->pairs);
    spare_add(&g->spare, s->first, (2 * count + 1) * sizeof *s->first);
    spare_add(&g->spare, s->weight, count * sizeof *s->weight);
}

/* Of what is marked, nothing would come of most, as things are now: that can be seen by all threads. What changes meanwhile is marked anew. */
static void sift_share(void *context, int thread, int threads)
{
    const Blows *s = context;
    int words = s->c->g->pair_count / 64 + 1;
    for (int w = team_first(words, thread, threads), end = team_end(words, thread, threads); w < end; w++)
        for (uint64_t left = s->looks[0][w]; left; left &= left - 1) {
            int i = 64 * w + __builtin_ctzll(left);
            Follow f;
            if (!may_follow(s, &s->ends[i], &s->c->g->pairs[i], &f))
                s->looks[0][w] &= ~(left & -left);
        }
}

#define SIFTED_LEAST 512        /* marks: fewer are not worth a team */

static void sift(Blows *s)
{
    int marks = 0;
    for (int w = 0; w <= s->c->g->pair_count / 64 && s->c->team; w++)
        marks += __builtin_popcountll(s->looks[0][w]);
    if (marks >= SIFTED_LEAST)
        team_deal(s->c->team, sift_share, s);
}

/* Of the pairs that this round looks at, in their order. Returns whether there was news. */
static bool one_round(Blows *s, int round)
{
    Group *g = s->c->g;
    bool more = false;
    sift(s);
    for (int w = 0; w <= g->pair_count / 64; w++)
        while (s->looks[0][w]) {            /* what is marked meanwhile comes later */
            int i = 64 * w + __builtin_ctzll(s->looks[0][w]);
            s->looks[0][w] &= s->looks[0][w] - 1;
            int body = follow(s, &s->ends[i], &g->pairs[i]);
            if (body < 0)
                continue;
            s->news[body] = (uint8_t)round;
            tell_pairs(s, body, i);
            more = true;
        }
    return more;
}

static int first_struck(const Group *g, const Ends *ends)
{
    int i = 0;
    while (i < g->pair_count && !(ends[i].struck > 0))
        i++;
    return i;
}

/* Bodies that fall together do not close on each other until the first of them is stopped, and then within the step. A pair is looked
 * at again only when there was news of one of its bodies in the round before, or is in this one. most: pairs there can be. */
static dig_status look_behind(Crowd *c, Ends *ends, size_t most)
{
    Group *g = c->g;
    Blows s = {.c = c, .ends = ends};
    int first = first_struck(g, ends);
    if (first < g->pair_count)
        DIG_TRY(open_blows(&s, most));
    if (g->team && c->stop) {
        team_deal(g->team, stop_share, &s);
        team_deal(g->team, mark_share, &s);
    }
    for (int i = first; i < g->pair_count && !g->team; i++)
        if (ends[i].struck > 0)
            note_stops(&s, &ends[i]);
    bool more = c->stop != NULL;
    for (int round = 1; round <= FOLLOWERS && more; round++) {
        DIG_TRY(touch_struck(&s, round));
        more = one_round(&s, round);
        uint64_t *done = s.looks[0];        /* none is left in it */
        s.looks[0] = s.looks[1];
        s.looks[1] = done;
    }
    if (c->stop)
        close_blows(&s, most);
    return DIG_OK;
}

dig_status crowd_touch(Crowd *c)
{
    Group *g = c->g;
    size_t most = (size_t)(g->pair_count + g->left_count);
    Touching t = {.c = c, .ends = spare_take(&g->spare, g->lasting, most * sizeof *t.ends)};
    if (!t.ends)
        return DIG_E_MEMORY;
    team_deal(g->team, touch_share(c), &t);
    DIG_TRY(look_behind(c, t.ends, most));
    spare_add(&g->spare, t.ends, most * sizeof *t.ends);
    group_close_left(g);
    return g->no_room ? DIG_E_MEMORY : DIG_OK;
}
