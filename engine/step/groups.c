/* step/groups.c - DIGs that may meet in this step are advanced together.
 *
 * A group is a set of DIGs connected by pairs whose reach boxes overlap, with
 * at least one awake member. Static and kinematic bodies connect nothing, so
 * that the ground does not join all piles into one. Groups share no writable
 * data: any order, or any number of threads, gives the same bits.
 */
#include "base/sort.h"
#include "crowd/crowd.h"
#include "step/step.h"
#include "world/joint.h"

/* Threads unite at the same time. What has a parent never becomes a root again, and each of its parents is one of its forebears for ever. */
static uint32_t parent_of(const World *w, uint32_t i) { return __atomic_load_n(&w->parent.data[i], __ATOMIC_RELAXED); }

static uint32_t find_root(World *w, uint32_t i)
{
    for (uint32_t up = parent_of(w, i), over; up != i; i = over) {
        over = parent_of(w, up);
        if (over != up)
            __atomic_store_n(&w->parent.data[i], over, __ATOMIC_RELAXED);
        up = parent_of(w, over);
    }
    return i;
}

/* The lower slot becomes the root: independent of the order of unions. */
static void unite(World *w, uint32_t a, uint32_t b)
{
    for (;;) {
        a = find_root(w, a);
        b = find_root(w, b);
        if (a == b)
            return;
        uint32_t high = a > b ? a : b, low = a > b ? b : a;
        if (__atomic_compare_exchange_n(&w->parent.data[high], &high, low, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED))
            return;
    }
}

/* What there is to share out: the DIGs concerned, by their first members, and the pairs that may meet. */
typedef struct Found { uint32_t *nodes, *pairs; int node_count, pair_count; } Found;

/* Every DIG is represented by its first member. */
static uint32_t dig_node(World *w, uint32_t body, Found *f)
{
    uint32_t lead = graph_lead(w->graph, body);
    if (w->parent.data[lead] == NONE) {
        w->parent.data[lead] = lead;
        f->nodes[f->node_count++] = lead;
    }
    return lead;
}

typedef struct Awake { World *w; uint32_t *nodes; int *found; } Awake;         /* found: by each share, from where it begins to look */

INLINE void node_share(void *context, int thread, int threads)
{
    const Awake *a = context;
    World *w = a->w;
    int first = team_first(w->awake.count, thread, threads), n = 0;
    for (int i = first, end = team_end(w->awake.count, thread, threads); i < end; i++) {
        uint32_t lead = body_dynamic(w, w->awake.data[i]) ? graph_lead(w->graph, w->awake.data[i]) : NONE;
        if (lead != NONE && parent_of(w, lead) == NONE && __atomic_exchange_n(&w->parent.data[lead], lead, __ATOMIC_RELAXED) == NONE)
            a->nodes[first + n++] = lead;
    }
    a->found[thread] = n;
}

#define SHARED_LEAST 512         /* pairs, or bodies and pairs: fewer are not worth a team */

/* The DIGs of all that is awake; in which order is not said. */
static dig_status list_awake(World *w, Found *f)
{
    Team *team = w->awake.count < SHARED_LEAST ? NULL : workers_team(w->workers);
    int shares = team_shares(team);
    Awake a = {w, f->nodes, arena_alloc(&w->scratch, (size_t)shares * sizeof *a.found)};
    if (!a.found)
        return DIG_E_MEMORY;
    team_deal(team, node_share, &a);
    f->node_count = a.found[0];         /* those of the first share are where they should be */
    for (int i = 1; i < shares; f->node_count += a.found[i++])
        memmove(f->nodes + f->node_count, f->nodes + team_first(w->awake.count, i, shares), (size_t)a.found[i] * sizeof *f->nodes);
    return DIG_OK;
}

/* Only what is listed has a reach of this step. A sleeper is just where it is: its leaf is as wide as when it moved. */
static box3 reach_now(const World *w, const Solid *s, bool listed)
{
    if (listed)
        return solid_reach(w, s);
    if (s->body != NONE && w->bodies.data[s->body].kind == DIG_DYNAMIC)
        return s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s));
    return s->leaf >= 0 ? tree_box(&w->tree, s->leaf) : (box3){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
}

/* A mover that may reach a sleeper wakes it: neither has an inverse mass, so no impulse would tell. */
static bool mover_wakes(World *w, uint32_t mover, uint32_t other)
{
    const Body *m = &w->bodies.data[mover], *o = &w->bodies.data[other];
    if (m->kind != DIG_KINEMATIC || o->awake || (vec3_length2(m->v) == 0 && vec3_length2(m->w) == 0))
        return false;
    body_wake(w, other);
    return true;
}

static bool is_listed(const World *w, uint32_t body) { return body != NONE && w->bodies.data[body].listed; }

bool pair_met(const World *w, const Pair *p)
{
    return (p->dynamic_a || p->dynamic_b) && box3_overlap(reach_now(w, &w->solids.data[p->solid_a], is_listed(w, p->body_a)),
                                                          reach_now(w, &w->solids.data[p->solid_b], is_listed(w, p->body_b)));
}

/* m  So much may the faces of both move, together, until the boxes no longer overlap, or do. */
static real room_between(box3 a, box3 b)
{
    vec3 low = vec3_sub(a.high, b.low), high = vec3_sub(b.high, a.low);
    return fabs(vec3_least(vec3_min(low, high)));
}

#define DOWN     (1 - 2e-7)     /* a float made of a double is no more than that */

/* Do they meet? What was found is kept until one of them may have got far enough to change it: what lies is only asked how far it got. */
static bool look_at(const World *w, Pair *p)
{
    static const Body none;     /* the world itself is nowhere else, and what does not move is as good as that */
    const Body *a = p->dynamic_a ? &w->bodies.data[p->body_a] : &none, *b = p->dynamic_b ? &w->bodies.data[p->body_b] : &none;
    bool keeps = p->pieces ? false : p->dynamic_a ? a->listed : !is_listed(w, p->body_a);
    keeps = keeps && (p->dynamic_b ? b->listed : !is_listed(w, p->body_b)) && (p->dynamic_a || p->dynamic_b);
    real roam = a->roam + b->roam;
    if (keeps && roam < p->met_until)
        return p->met;
    if (!keeps || !(roam < INFINITY)) {
        p->met_until = 0;
        return pair_met(w, p);
    }
    box3 x = reach_now(w, &w->solids.data[p->solid_a], p->dynamic_a), y = reach_now(w, &w->solids.data[p->solid_b], p->dynamic_b);
    p->met = box3_overlap(x, y);
    real room = room_between(x, y) - PLACE_ROUNDING * vec3_largest(vec3_max(vec3_abs(p->dynamic_a ? x.low : y.low), vec3_abs(p->dynamic_a ? x.high : y.high)));
    p->met_until = (float)(DOWN * roams_until(room, a->travel + b->travel, roam));
    return p->met;
}

/* What is found out about a listed pair. */
enum { GONE, APART, MEETS, UNITED, KINDS };         /* MEETS: and one is asleep; UNITED: so do two of the same group */

typedef struct Looking { World *w; uint8_t *found; Found *f; int (*count)[KINDS]; } Looking;        /* [near]; of each share, then of those before it */

static void fetch_ends(const World *w, uint32_t solid, uint32_t body)
{
    fetch_soon(&w->solids.data[solid].reach, sizeof(box3));
    if (body != NONE)
        fetch_soon(&w->bodies.data[body], 8);
}

/* Of the listed pairs that come after number i: the next ones but some, and of the next ones what they name. */
static void fetch_pairs(const World *w, int i)
{
    if (i + 2 * FETCH_AHEAD < w->near.count)
        fetch_soon(&w->pairs.data[w->near.data[i + 2 * FETCH_AHEAD]], offsetof(Pair, next));
    if (i + FETCH_AHEAD >= w->near.count)
        return;
    const Pair *p = &w->pairs.data[w->near.data[i + FETCH_AHEAD]];
    fetch_ends(w, p->solid_a, p->body_a);
    fetch_ends(w, p->solid_b, p->body_b);
}

/* Of a pair that meets: DIGs that are awake are united here. */
static int unite_pair(World *w, const Pair *p)
{
    if (p->dynamic_a && p->dynamic_b) {
        uint32_t a = graph_lead(w->graph, p->body_a), b = graph_lead(w->graph, p->body_b);
        if (a == b)
            return UNITED;          /* it is awake, for one end is listed */
        if (parent_of(w, a) == NONE || parent_of(w, b) == NONE)
            return MEETS;
        unite(w, a, b);
        return UNITED;
    }
    return w->bodies.data[p->dynamic_a ? p->body_a : p->body_b].awake ? UNITED : MEETS;
}

INLINE void look_share(void *context, int thread, int threads)
{
    const Looking *l = context;
    World *w = l->w;
    int count[KINDS] = {0};
    for (int i = team_first(w->near.count, thread, threads), end = team_end(w->near.count, thread, threads); i < end; i++) {
        Pair *p = &w->pairs.data[w->near.data[i]];
        fetch_pairs(w, i);
        l->found[i] = GONE;
        if ((i > 0 && w->near.data[i - 1] == w->near.data[i]) || !p->alive)
            continue;                       /* gone, and its slot was given to a new pair, which may be another thread's; or gone */
        p->listed = is_listed(w, p->body_a) || is_listed(w, p->body_b);
        if (!p->listed)
            continue;
        l->found[i] = (uint8_t)(look_at(w, p) ? unite_pair(w, p) : APART);
        count[l->found[i]]++;
    }
    memcpy(l->count[thread], count, sizeof count);
}

/* Where nobody sleeps: those that meet are listed, and what is gone leaves its share of the near ones. */
INLINE void pack_share(void *context, int thread, int threads)
{
    const Looking *l = context;
    uint32_t *near = l->w->near.data, *pairs = l->f->pairs + l->count[thread][UNITED], *to = near + team_first(l->w->near.count, thread, threads);
    for (int i = team_first(l->w->near.count, thread, threads), end = team_end(l->w->near.count, thread, threads); i < end; i++) {
        if (l->found[i] == UNITED)
            *pairs++ = near[i];
        if (l->found[i] != GONE)
            *to++ = near[i];
    }
}

static void pack(Looking *l, Team *team)
{
    World *w = l->w;
    int shares = team_shares(team), total = w->near.count, kept = 0;
    for (int i = 0; i < shares; i++) {
        int own = l->count[i][UNITED];
        l->count[i][APART] += own;          /* so many it keeps */
        l->count[i][UNITED] = l->f->pair_count;
        l->f->pair_count += own;
    }
    team_deal(team, pack_share, l);
    for (int i = 0; i < shares; kept += l->count[i++][APART])
        if (kept < team_first(total, i, shares))
            memmove(w->near.data + kept, w->near.data + team_first(total, i, shares), (size_t)l->count[i][APART] * sizeof *w->near.data);
    w->near.count = kept;
}

/* One pair that meets a sleeper, or a mover; unites the DIGs of both. DIG_E_BUSY: a mover woke a sleeper. */
static dig_status collect_pair(World *w, uint32_t slot, Found *f)
{
    const Pair *p = &w->pairs.data[slot];
    if (p->dynamic_a && p->dynamic_b) {
        unite(w, dig_node(w, p->body_a, f), dig_node(w, p->body_b, f));
    } else {
        uint32_t body = p->dynamic_a ? p->body_a : p->body_b, other = p->dynamic_a ? p->body_b : p->body_a;
        if (!w->bodies.data[body].awake)    /* the other is a mover, for one end is listed */
            return mover_wakes(w, other, body) ? DIG_E_BUSY : DIG_OK;
        dig_node(w, body, f);
    }
    f->pairs[f->pair_count++] = slot;
    return DIG_OK;
}

/* Most are in order from the last step; what came since is at the end. */
static dig_status sort_near(World *w)
{
    uint32_t *near = w->near.data;
    int count = w->near.count, old = count > 0;
    while (old < count && near[old - 1] <= near[old])
        old++;
    if (old >= count)
        return DIG_OK;
    ArenaMark mark = arena_mark(&w->scratch);
    uint32_t *added = arena_alloc(&w->scratch, (size_t)(count - old) * sizeof *added);
    if (!added)
        return DIG_E_MEMORY;
    memcpy(added, near + old, (size_t)(count - old) * sizeof *added);
    DIG_TRY(sort_u32(added, count - old, &w->scratch));
    for (int to = count - 1, i = old - 1, k = count - old - 1; k >= 0; to--)
        near[to] = i >= 0 && near[i] > added[k] ? near[i--] : added[k--];
    arena_rewind(&w->scratch, mark);
    return DIG_OK;
}

/* Goes through the pairs in the order of their storage, and drops those that are gone or fell asleep. */
static dig_status collect_pairs(World *w, Found *f)
{
    if (w->near.count == 0)
        return DIG_OK;
    DIG_TRY(sort_near(w));
    uint32_t *near = w->near.data;
    int n = 0, count = w->near.count;
    Team *team = count < SHARED_LEAST ? NULL : workers_team(w->workers);
    int shares = team_shares(team), sleepers = 0;
    Looking l = {w, arena_alloc(&w->scratch, (size_t)count), f, arena_alloc(&w->scratch, (size_t)shares * sizeof *l.count)};
    if (!l.found || !l.count)
        return DIG_E_MEMORY;
    team_deal(team, look_share, &l);
    for (int i = 0; i < shares; i++)
        sleepers += l.count[i][MEETS];
    if (sleepers == 0) {
        pack(&l, team);
        return DIG_OK;
    }
    dig_status status = DIG_OK;
    for (int i = 0; i < count; i++) {
        if (l.found[i] == GONE)
            continue;
        near[n++] = near[i];
        if (status == DIG_OK && l.found[i] == MEETS)
            status = collect_pair(w, near[i], f);
        else if (status == DIG_OK && l.found[i] == UNITED)
            f->pairs[f->pair_count++] = near[i];
    }
    w->near.count = n;
    return status;
}

static int group_accuracy(const World *w, const uint32_t *leads, int count)
{
    int accuracy = w->accuracy;
    for (int i = 0; i < count && w->dig_accuracies; i++)
        accuracy = int_max(accuracy, (int)graph_user_of(w->graph, leads[i]));
    return accuracy;
}

static int bodies_of(const World *w, const Step *s, const struct StepGroup *g)
{
    int bodies = 0;
    for (int i = 0; i < g->dig_count; i++)
        bodies += graph_fellows(w->graph, s->leads[g->dig_first + i]);
    return bodies;
}

typedef struct Plain { real light, heavy; bool free; } Plain;          /* kg; free, and advanced the default way */

static const Plain nobody = {INFINITY, 0, true};

static void add_plain(Plain *p, const Body *b)
{
    p->free = p->free && b->joint_first == NONE && b->integrator == DIG_AUTO;
    p->light = real_min(p->light, b->mass);
    p->heavy = real_max(p->heavy, b->mass);
}

/* Free bodies of about the same mass, advanced the default way. */
static bool is_plain(const Plain *p) { return p->free && p->heavy <= CROWD_MASS_RATIO * p->light; }

/* Are but few of its bodies much lighter than the heaviest? Those find room between the others. What is heavy on a bed of light things is not for a crowd. */
static bool few_light(const World *w, const Step *s, const struct StepGroup *g, real heaviest)
{
    int all = 0, light = 0;
    for (int i = 0; i < g->dig_count; i++)
        for (uint32_t m = s->leads[g->dig_first + i]; m != NONE; m = graph_next(w->graph, m), all++)
            light += w->bodies.data[m].mass * CROWD_MASS_RATIO < heaviest;
    return light <= CROWD_LIGHT * all;
}

static bool plain_bodies(const World *w, const Step *s, const struct StepGroup *g)
{
    Plain p = nobody;
    for (int i = 0; i < g->dig_count && !s->plain; i++)
        for (uint32_t m = s->leads[g->dig_first + i]; m != NONE && p.free; m = graph_next(w->graph, m))
            add_plain(&p, &w->bodies.data[m]);
    return is_plain(&p) || (p.free && few_light(w, s, g, p.heavy));
}

typedef struct Everybody { const World *w; Plain *of; } Everybody;      /* of each share of the world's bodies */

static void plain_share(void *context, int thread, int threads)
{
    const Everybody *e = context;
    const World *w = e->w;
    Plain p = nobody;
    for (int i = team_first(w->bodies.count, thread, threads), end = team_end(w->bodies.count, thread, threads); i < end && p.free; i++)
        if (w->bodies.data[i].alive && w->bodies.data[i].kind == DIG_DYNAMIC)
            add_plain(&p, &w->bodies.data[i]);
    e->of[thread] = p;
}

/* Is it so of all there are? Where most of them are awake, that is asked once, by all threads. */
static dig_status find_plain(World *w, Step *s, Team *team)
{
    int shares = team_shares(team);
    s->plain = false;
    if (!team || 2 * w->awake.count < w->bodies.count)
        return DIG_OK;
    Everybody e = {w, arena_alloc(&w->scratch, (size_t)shares * sizeof *e.of)};
    if (!e.of)
        return DIG_E_MEMORY;
    team_deal(team, plain_share, &e);
    for (int i = 1; i < shares; i++) {
        e.of[0].free = e.of[0].free && e.of[i].free;
        e.of[0].light = real_min(e.of[0].light, e.of[i].light);
        e.of[0].heavy = real_max(e.of[0].heavy, e.of[i].heavy);
    }
    s->plain = is_plain(&e.of[0]);
    return DIG_OK;
}

/* Bounces are simultaneous in a crowd; what bounces well deserves better, unless there is very much of it. */
static bool bounces_well(const World *w, const Step *s, const struct StepGroup *g)
{
    for (int i = 0; i < g->pair_count; i++) {
        const Pair *p = &w->pairs.data[s->pairs[g->pair_first + i]];
        if (p->bounces && pair_rub(w, p).restitution > CROWD_LIVELY)
            return true;
    }
    return false;
}

#define SLEEPY   4              /* times as much may be in the world where it will fall asleep: it is solved once */
#define PATIENCE 512            /* steps: who was put off for longer is a crowd until it is tried again: sweeps left it too rough, several times */

/* m^2/s^2  How fast two move against each other where the smaller one is, its rim included, squared. */
static real pair_speed2(const Body *small, const Body *large)
{
    vec3 v = vec3_sub(vec3_sub(small->v, large->v), vec3_cross(large->w, vec3_sub(small->x, large->x)));
    return vec3_length2(v) + small->outer * small->outer * vec3_length2(vec3_sub(small->w, large->w));
}

/* Do they lie there, against each other, on a table that moves, too, and are solved in time (solve/toil.c)? Then it is not for a crowd. */
static bool lies_calm(const World *w, const Step *s, const struct StepGroup *g)
{
    static const Body ground;
    int fast = 0;
    for (int i = 0; i < g->pair_count; i++) {
        const Pair *p = &w->pairs.data[s->pairs[g->pair_first + i]];
        const Body *a = p->body_a == NONE ? &ground : &w->bodies.data[p->body_a], *b = p->body_b == NONE ? &ground : &w->bodies.data[p->body_b];
        bool first = p->dynamic_a && (!p->dynamic_b || a->outer <= b->outer);
        const Body *small = first ? a : b;
        if ((small->trace_wait > 0 && small->trace_pause > PATIENCE) || a->toil.pause > 0 || b->toil.pause > 0)
            return false;
        real pull = real_max(a->awake ? a->pull : 0, b->awake ? b->pull : 0);       /* that of a sleeper is an old one */
        fast += !(pair_speed2(small, first ? b : a) <= CALM_SPEED * CALM_SPEED * small->outer * pull);
    }
    return fast <= CALM_FAST * g->pair_count;
}

/* Has it been solved in vain for so long that it pauses (solve/toil.c), while no mover stirs it? */
static bool toils(const World *w, const Step *s, const struct StepGroup *g)
{
    bool any = false;
    for (int i = 0; i < g->pair_count; i++) {
        const Pair *p = &w->pairs.data[s->pairs[g->pair_first + i]];
        const Body *a = p->body_a == NONE ? NULL : &w->bodies.data[p->body_a], *b = p->body_b == NONE ? NULL : &w->bodies.data[p->body_b];
        if ((a && a->kind == DIG_KINEMATIC) || (b && b->kind == DIG_KINEMATIC))
            return false;
        any = any || (a && a->toil.pause > 0) || (b && b->toil.pause > 0);
    }
    return any;
}

/* Of so many bodies: is it for the crowd, by its own size, or because the world has so much else to advance that small groups are no exception? */
static bool takes_crowd(const World *w, const Step *s, const struct StepGroup *g, int bodies, int total)
{
    const AccuracyPlan *plan = g->plan;
    bool few = bodies <= plan->crowd_bodies && total <= plan->crowd_total;
    if ((few && !(bodies > plan->toil_bodies && toils(w, s, g))) || !crowd_allows(w) || !plain_bodies(w, s, g))
        return false;
    return bodies > CROWD_LIVELY_MOST * plan->crowd_bodies || !bounces_well(w, s, g);
}

bool may_crowd(const World *w, const Step *s, const struct StepGroup *g)
{
    return takes_crowd(w, s, g, bodies_of(w, s, g), INT32_MAX);
}

/* Of a crowd: is it to be solved at once (crowd/calm.c)? */
static bool takes_calm(const World *w, const Step *s, const struct StepGroup *g, int total)
{
    const AccuracyPlan *plan = g->plan;
    int64_t most = (w->def.sleeping ? SLEEPY : 1) * (int64_t)plan->crowd_total;
    return total <= most && bodies_of(w, s, g) <= plan->calm_bodies && lies_calm(w, s, g);
}

/* The sum of what traced groups may cost is bounded by counts, never by the clock, so that results do not depend on the machine.
 * The first group fits always: one long chain is a world's main business, not one of a thousand. */
static bool within_budget(const struct StepGroup *g, int64_t *spent)
{
    bool fits = *spent == 0 || *spent + g->cost <= g->plan->trace_total;
    *spent += fits ? g->cost : 0;
    return fits;
}

/* Is it held together by plain ball joints, in a world of so much else? Then the room chain is enough for it, unless it is most of
 * that world. */
static bool takes_chain(const World *w, const Step *s, const struct StepGroup *g, int total)
{
    int joints = 0;
    if (total <= g->plan->crowd_total || 2 * bodies_of(w, s, g) >= w->awake.count)
        return false;
    for (int i = 0; i < g->dig_count; i++)
        for (uint32_t m = s->leads[g->dig_first + i]; m != NONE; m = graph_next(w->graph, m))
            for (uint32_t j = w->bodies.data[m].joint_first; j != NONE; j = joint_next(w, j, m), joints++)
                if (!w->joints.data[j].plain)
                    return false;
    return joints > 0;
}

/* The dynamic end of a pair: its group is the pair's. */
static uint32_t pair_root(World *w, uint32_t pair)
{
    const Pair *p = &w->pairs.data[pair];
    return find_root(w, graph_lead(w->graph, p->dynamic_a ? p->body_a : p->body_b));
}

/* Shares the sorted nodes and pairs out to the groups, the one with the lowest root first. A root is the lowest node of its group, so
 * that it comes before the others. number[root]: which group. */
static void share_out(World *w, Step *s, const Found *f, uint32_t *number)
{
    for (int i = 0; i < f->node_count; i++) {
        uint32_t root = find_root(w, f->nodes[i]);
        if (root == f->nodes[i]) {
            number[root] = (uint32_t)s->count;
            s->parts[s->count++] = (struct StepGroup){0};
        }
        s->parts[number[root]].dig_count++;
    }
    for (int i = 0; i < f->pair_count; i++)
        s->parts[number[pair_root(w, f->pairs[i])]].pair_count++;
    for (int i = 0, digs = 0, pairs = 0; i < s->count; i++) {
        struct StepGroup *g = &s->parts[i];
        g->dig_first = digs;
        g->pair_first = pairs;
        digs += g->dig_count;
        pairs += g->pair_count;
        g->dig_count = g->pair_count = 0;
    }
    for (int i = 0; i < f->node_count; i++) {
        struct StepGroup *g = &s->parts[number[find_root(w, f->nodes[i])]];
        s->leads[g->dig_first + g->dig_count++] = f->nodes[i];
    }
    for (int i = 0; i < f->pair_count; i++) {
        struct StepGroup *g = &s->parts[number[pair_root(w, f->pairs[i])]];
        s->pairs[g->pair_first + g->pair_count++] = f->pairs[i];
    }
}

/* One group: the lists are its own. */
static void keep_together(Step *s, const Found *f)
{
    s->count = 1;
    s->parts[0] = (struct StepGroup){.dig_count = f->node_count, .pair_count = f->pair_count};
    s->leads = f->nodes;
    s->pairs = f->pairs;
}

#define JOINED_MOST 256         /* bodies, about */

/* Small groups of a crowd are advanced together, so that rows are solved eight at a time: lists of neighbours stand side by side. */
static void join_crowds(const World *w, Step *s)
{
    int n = 0, bodies = JOINED_MOST;    /* of the last group; as good as full: none may join it */
    for (int i = 0; i < s->count; i++) {
        struct StepGroup g = s->parts[i];
        int own = g.crowd ? bodies_of(w, s, &g) : JOINED_MOST;
        if (n > 0 && bodies + own <= JOINED_MOST && s->parts[n - 1].accuracy == g.accuracy) {
            s->parts[n - 1].dig_count += g.dig_count;
            s->parts[n - 1].pair_count += g.pair_count;
            s->parts[n - 1].cost += g.cost;
            bodies += own;
        } else {
            s->parts[n++] = g;
            bodies = own;
        }
    }
    s->count = n;
}

typedef struct Choosing { const World *w; Step *s; int total; } Choosing;

static void choose_way(void *context, int i, Scratch scratch)
{
    const Choosing *c = context;
    struct StepGroup *g = &c->s->parts[i];
    (void)scratch;
    g->accuracy = group_accuracy(c->w, c->s->leads + g->dig_first, g->dig_count);
    g->plan = accuracy_plan(g->accuracy);
    int bodies = bodies_of(c->w, c->s, g);
    bool many = takes_crowd(c->w, c->s, g, bodies, c->w->debt.pause > 0 ? INT32_MAX : c->total);
    g->calm = many && takes_calm(c->w, c->s, g, c->total);
    g->crowd = many && !g->calm;
    g->cost = bodies + g->pair_count;
}

static dig_status cut(World *w, Step *s, const Found *f)
{
    size_t nodes = (size_t)f->node_count;
    DIG_TRY(sort_u32(f->nodes, f->node_count, &w->scratch));
    s->parts = arena_alloc(&w->scratch, nodes * sizeof *s->parts);
    if (!s->parts)
        return DIG_E_MEMORY;
    bool one = true;
    for (int i = 1; i < f->node_count && one; i++)
        one = find_root(w, f->nodes[i]) == f->nodes[0];
    if (one && f->node_count > 0)
        keep_together(s, f);
    else {
        uint32_t *number = arena_alloc(&w->scratch, (size_t)w->bodies.count * sizeof *number);
        s->leads = arena_alloc(&w->scratch, nodes * sizeof *s->leads);
        s->pairs = arena_alloc(&w->scratch, (size_t)f->pair_count * sizeof *s->pairs);
        if (!number || !s->leads || !s->pairs)
            return DIG_E_MEMORY;
        share_out(w, s, f, number);
    }
    int64_t spent = 0;
    int total = w->awake.count + f->pair_count;
    Choosing c = {w, s, total};
    DIG_TRY(find_plain(w, s, total < SHARED_LEAST ? NULL : workers_team(w->workers)));
    workers_run(total < SHARED_LEAST ? NULL : w->workers, world_scratch(w), choose_way, &c, s->count);
    for (int i = 0; i < s->count; i++) {
        struct StepGroup *g = &s->parts[i];
        g->may_trace = !g->crowd && !g->calm && !takes_chain(w, s, g, total) && within_budget(g, &spent);
    }
    if (total > accuracy_plan(w->accuracy)->crowd_total)
        join_crowds(w, s);
    s->groups = arena_alloc(&w->scratch, (size_t)s->count * sizeof *s->groups);
    return s->groups ? DIG_OK : DIG_E_MEMORY;
}

dig_status form_groups(World *w, Step *s)
{
    s->count = 0;
    if (w->awake.count + w->near.count == 0)        /* all are asleep */
        return DIG_OK;
    Found f = {.nodes = arena_alloc(&w->scratch, (size_t)int_max(graph_count(w->graph), w->awake.count) * sizeof *f.nodes),
               .pairs = arena_alloc(&w->scratch, (size_t)w->near.count * sizeof *f.pairs)};
    if (!f.nodes || !f.pairs)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for the step's groups");
    ArenaMark mark = arena_mark(&w->scratch);
    dig_status status = list_awake(w, &f);
    if (status == DIG_OK)
        status = collect_pairs(w, &f);
    arena_rewind(&w->scratch, mark);        /* all that was found is in f */
    if (status == DIG_OK)
        status = cut(w, s, &f);
    for (int i = 0; i < f.node_count; i++)
        w->parent.data[f.nodes[i]] = NONE;
    return status == DIG_E_MEMORY ? world_fail(w, status, "not enough memory for the step's groups") : status;
}
