/* step/watch.c - the world watches itself: is what comes out reliable?
 *
 * Each rule has a bound on something that each group measures in each step, and a
 * patience: one bad step is no alarm. What lasts is recorded with body, DIG, time
 * and value. Nothing here has an influence on motion, and what sleeps costs nothing.
 */
#include "math/pair3.h"
#include "step/step.h"
#include "solve/direction.h"

#include <stdio.h>

/* ---- the rules ---- */

typedef struct Rule {
    dig_rule_info info;
    real bound;                 /* see below                                             */
    real patience;              /* s     for which it must be broken without a pause     */
    uint32_t steps;             /*       and at least so often                           */
} Rule;

static const Rule rules[DIG_RULES] = {
    /* Part of the energy of motion. Blows of hundreds of elastic bodies at once, which no way follows one by one, may make up a
     * fiftieth of theirs. What is more, and is not lost at once, is no motion that one can believe. */
    [DIG_RULE_ENERGY] = {{"energy", "energy rose without work", "take a shorter step or a finer accuracy", "J"}, 0.02, 0, 3},
    /* Part of the size of the smaller solid. Overlaps heal at 3 m/s per square root of a metre, so that even one of half a body
     * is over in half of this time; a DIG in which nothing moves sleeps soon after. */
    [DIG_RULE_OVERLAP] = {{"overlap", "bodies stay inside each other", "make room for them: something presses or holds them there", "m"},
                          0.05, 0.4, 8},
    /* Part of the size of the smaller body, or radians. */
    [DIG_RULE_JOINT] = {{"joint", "the ends of a joint stay apart, or beyond its limits",
                         "look for joints or contacts that want what cannot be", "m"}, 0.1, 0.4, 8},
    /* Part of the speed of a fall by the size of the smallest body. */
    [DIG_RULE_RESIDUAL] = {{"residual", "the solver does not find velocities that fit",
                            "look for joints or contacts that want what cannot be, or take a shorter step", "m/s"}, 0.02, 0.4, 8},
    /* Failures in a row. A traced DIG is tried again after 16, 32, 64, ... steps, a conserved one in each step. */
    [DIG_RULE_BUDGET] = {{"budget", "its DIG is over the budget of what its accuracy asks for, and swept instead",
                          "ask for a coarser accuracy, or take a shorter step", "failures in a row"}, 3, 1, 4},
};

const dig_rule_info *dig_rule_get(dig_rule rule) { return (unsigned)rule < DIG_RULES ? &rules[rule].info : NULL; }

/* ---- a group's energy ---- */

static real elastic(const Group *g)
{
    real sum = 0;
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        if (j->stores && !j->broken)
            sum += group_spring_energy(j);
    }
    return sum;
}

/* again: after the step, of which they were viewed at the start. */
static void view_joints(Group *g, bool again)
{
    for (int i = 0; i < g->joint_count; i++) {
        if (!g->joints[i].stores)
            continue;
        if (again)
            group_joint_move(g, i);
        else
            group_joint_view(g, i);
    }
}

void watch_start(Group *g)
{
    g->watch = (struct GroupWatch){.gainer = 0, .smallest = INFINITY};
    view_joints(g, false);
    g->watch.elastic = elastic(g);
}

/* J  In lane 0 as the world has the body, in lane 1 as the group has it after the step. On the way its angular momentum is found, and what
 * that changed by is left for the commit. */
static pair kinetic(const Body *b, const Pos *pos, const Vel *vel, Member *m)
{
    pair3 v = pair3_of(b->v, vel->v), w = pair3_of(b->w, vel->w);
    pair spin = body_inertia(b)->of.r0.x * pair3_dot(w, w);
    if (!b->round_inertia) {    /* else it has the same in all axes */
        const pair_quat q = pair_quat_of(b->q, pos->q);
        w = pair_quat_rotate(pair_quat_conjugate(q), w);
        const pair3 l = pair3_by(&body_inertia(b)->of, w), momentum = pair_quat_rotate(q, l);
        spin = pair3_dot(w, l);
        m->torque = vec3_sub(pair3_get(momentum, 1), pair3_get(momentum, 0));
    }
    return 0.5 * body_inertness(b) * (b->mass * pair3_dot(v, v) + spin);
}

/* s  For about so long a rise is compared with the most energy that the group had. */
#define LATELY 2

/* The sum of all rises of a group since it last lost as much (Page 1954, Biometrika 41, 100: a cumulative sum that starts anew at
 * zero): what an oscillation takes and gives back is no rise. */
static real rise_of(const Group *g) { return g->stores ? 0 : real_max(0, g->watch.carried + g->watch.rise); }
static real borne_of(const Group *g) { return real_max(g->watch.borne, g->watch.carried_borne / (1 + g->world->def.step / LATELY)); }

/* All members carry the same part, from the commit on, so that a group that falls apart takes it along. */
static void carry(Group *g, real rise, real borne)
{
    real part = 1 / real_max(1, g->watch.count);
    g->watch.part = part * rise;
    g->watch.part_borne = part * borne;
}

#define STANDS 0.01             /* of its size a second: what moves slower stands  */
#define HOP 0.1                 /* of its size: so high it may hop                */

/* What a block of members adds up to. Blocks do not depend on how many threads there are, so sums do not, either. */
#define BLOCK 64
typedef struct Sum { real rise, motion, borne, carried, carried_borne, smallest, most; int count, gainer, leavers; } Sum;
typedef struct Sums { const Group *g; Sum *of; int blocks; } Sums;

static void watch_member(const Group *g, int i, Sum *s)
{
    Member *m = &g->member[i];
    const Body *b = &g->world->bodies.data[m->slot];    /* as it was before the step */
    s->leavers += !b->out && world_left(g->world, g->pos[i].x);
    if (!m->moves)
        return;
    pair energy = kinetic(b, &g->pos[i], &g->vel[i], m);
    real before = energy[0], after = energy[1];
    real gain = after - before - b->mass * b->gravity_scale * vec3_dot(g->gravity, vec3_sub(g->pos[i].x, b->x));
    real slow = STANDS * b->outer, hop = HOP * fabs(b->gravity_scale) * g->fall * b->outer;
    s->rise += gain;
    s->motion += after - before;
    s->borne += rules[DIG_RULE_ENERGY].bound * (before + after) + b->mass * (slow * slow + hop);
    s->carried += b->watch.rise;
    s->carried_borne += b->watch.borne;
    s->count++;
    s->smallest = real_min(s->smallest, b->outer);
    if (gain > s->most) {
        s->most = gain;
        s->gainer = i;
    }
}

#define WATCHED_AHEAD 6          /* what the step has read of them is still near, but for what is watched */

static void sum_block(const Group *g, int block, Sum *s)
{
    *s = (Sum){.smallest = INFINITY, .most = -INFINITY};
    for (int i = block * BLOCK; i < int_min((block + 1) * BLOCK, g->moving_count); i++) {
        if (i + WATCHED_AHEAD < g->moving_count)
            fetch_soon(&g->world->bodies.data[g->slots[i + WATCHED_AHEAD]].watch, sizeof(BodyWatch));
        watch_member(g, i, s);
    }
}

INLINE void sum_share(void *context, int thread, int threads)
{
    const Sums *s = context;
    for (int i = team_first(s->blocks, thread, threads), end = team_end(s->blocks, thread, threads); i < end; i++)
        sum_block(s->g, i, &s->of[i]);
}

static void add_block(Sum *to, const Sum *s)
{
    to->rise += s->rise;
    to->motion += s->motion;
    to->borne += s->borne;
    to->carried += s->carried;
    to->carried_borne += s->carried_borne;
    to->count += s->count;
    to->leavers += s->leavers;
    to->smallest = real_min(to->smallest, s->smallest);
    if (s->most > to->most) {
        to->most = s->most;
        to->gainer = s->gainer;
    }
}

/* Where there is no memory to share it, one thread does it: no step fails for being watched. */
static void sum_members(Group *g, Sum *all)
{
    if (g->moving_count <= BLOCK) {
        sum_block(g, 0, all);
        return;
    }
    *all = (Sum){.smallest = INFINITY, .most = -INFINITY};
    Sums s = {.g = g, .blocks = (g->moving_count + BLOCK - 1) / BLOCK};
    s.of = g->team ? arena_alloc(g->arena, (size_t)s.blocks * sizeof *s.of) : NULL;
    if (s.of)
        team_deal(g->team, sum_share, &s);
    for (int i = 0; i < s.blocks; i++) {
        Sum one;
        if (!s.of)
            sum_block(g, i, &one);
        add_block(all, s.of ? &s.of[i] : &one);
    }
}

/* Of two bodies, the lighter one that moves. */
static uint32_t lighter(const Group *g, int a, int b)
{
    bool first = a >= 0 && g->member[a].moves;
    if (first && b >= 0 && g->member[b].moves)
        first = g->member[a].mass <= g->member[b].mass;
    return g->member[first || b < 0 ? a : b].slot;
}

/* ---- what the rows say, which the group has while it is advanced ---- */

static real joint_size(const Group *g, const GroupJoint *j)
{
    real a = j->a >= 0 && g->member[j->a].moves ? g->member[j->a].outer : INFINITY;
    real b = j->b >= 0 && g->member[j->b].moves ? g->member[j->b].outer : INFINITY;
    return real_min(a, b);
}

/* What a hard row or a limit is off, m or rad. */
static real row_error(const Row *r) { return r->kind == ROW_HARD ? fabs(r->error) : r->kind == ROW_LIMIT ? real_max(0, -r->error) : 0; }

/* The rows are those that the sweeps measured last; the other ways hand on what they cannot hold together. */
static void look_at_joints(Group *g)
{
    for (int i = 0; i < g->joint_count; i++)
        g->joints[i].off = 0;
    for (int i = 0; i < g->block_count && g->way->tally == WAY_SWEPT; i++) {
        const JointBlock *block = &g->blocks[i];
        GroupJoint *j = &g->joints[block->joint];
        for (int k = 0; k < block->count; k++) {
            const Row *r = &g->rows[block->first + k].row;
            j->off = real_max(j->off, row_error(r) * (r->angular ? joint_size(g, j) : 1));
        }
    }
}

/* Whose velocities fit least: at a joint or a contact. */
static uint32_t misfit(const Group *g)
{
    real worst = -INFINITY;
    uint32_t body = g->slots[0];
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count; k++) {
            const Row *r = &g->rows[g->blocks[i].first + k].row;
            real rate = 0;
            for (int n = 0; n < r->count && r->kind == ROW_HARD; n++)
                if (r->body[n] >= 0)
                    rate += vec3_dot(r->lin[n], g->vel[r->body[n]].v) + vec3_dot(r->ang[n], g->vel[r->body[n]].w);
            if (fabs(rate) > worst && r->kind == ROW_HARD) {
                worst = fabs(rate);
                body = lighter(g, g->joints[g->blocks[i].joint].a, g->joints[g->blocks[i].joint].b);
            }
        }
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        real rate = -dir_rate(g, &r->n, r->a, r->b);
        if (r->jn > 0 && rate > worst) {
            worst = rate;
            body = lighter(g, r->a, r->b);
        }
    }
    return body;
}

static real residual_bound(const Group *g)
{
    real size = g->watch.smallest, fall = sqrt(2 * g->fall * size);
    return rules[DIG_RULE_RESIDUAL].bound * (fall + size);              /* without gravity: its size in a second */
}

void watch_group(Group *g)
{
    struct GroupWatch *watch = &g->watch;
    Sum s;
    sum_members(g, &s);
    watch->rise += s.rise;
    watch->borne += s.borne;
    watch->carried += s.carried;
    watch->carried_borne += s.carried_borne;
    watch->count += s.count;
    watch->leavers += s.leavers;
    watch->smallest = real_min(watch->smallest, s.smallest);
    watch->gainer = s.gainer;
    view_joints(g, true);
    real end = elastic(g);
    watch->rise += end - watch->elastic - g->work_in - g->law;
    watch->rise = real_min(watch->rise, real_max(0, s.motion));     /* what is moved out of an overlap may be lifted */
    watch->borne += rules[DIG_RULE_ENERGY].bound * (end + watch->elastic);
    carry(g, rise_of(g), borne_of(g));
    look_at_joints(g);
    if (g->residual > residual_bound(g))
        watch->misfit = misfit(g);
}

/* ---- what lasts is recorded ---- */

static void warn(World *w, dig_rule rule, uint32_t slot, real value, real bound, const char *why)
{
    const Body *b = &w->bodies.data[slot];
    dig_body body = body_handle(w, slot);
    w->stats.warnings++;
    for (int i = 0; i < w->warning_count; i++) {
        dig_warning *old = &w->warnings[i];
        if (old->rule != rule || old->body.slot != body.slot || old->body.gen != body.gen)
            continue;
        old->times++;
        if (value > old->value) {
            old->value = value;
            snprintf(old->why, sizeof old->why, "%s", why);
        }
        return;
    }
    if (w->warning_count == DIG_WARNINGS)
        return;
    dig_warning *n = &w->warnings[w->warning_count++];
    *n = (dig_warning){.rule = rule, .time = world_time(w), .body = body, .dig = graph_of(w->graph, slot), .value = value, .bound = bound,
                       .times = 1};
    snprintf(n->name.s, sizeof n->name.s, "%s", body_name(w, b));
    snprintf(n->why, sizeof n->why, "%s", why);
}

/* The rule is broken in this step, too: for long enough? `pause`: steps that may lie between two times. */
static bool lasts(World *w, dig_rule rule, uint32_t slot, uint64_t pause)
{
    Breach *b = &body_rest_own(w, &w->bodies.data[slot])->breach;
    uint32_t now = (uint32_t)w->steps;
    if (b->last[rule] == now)
        return false;               /* by another contact */
    if (b->run[rule] == 0 || now - b->last[rule] > pause + 1) {
        b->run[rule] = 0;
        b->since[rule] = now;
    }
    b->run[rule] = (uint16_t)int_min(b->run[rule] + 1, UINT16_MAX);
    b->last[rule] = now;
    if (b->run[rule] < rules[rule].steps || (real)(now - b->since[rule] + 1) * w->def.step < rules[rule].patience)
        return false;
    b->run[rule] = 0;
    return true;
}

/* Who was told of a rise does not carry it on. */
static void judge_energy(World *w, const Group *g)
{
    real rise = rise_of(g), borne = borne_of(g);
    if (!(rise > borne) || !lasts(w, DIG_RULE_ENERGY, g->slots[0], 0))
        return;
    warn(w, DIG_RULE_ENERGY, g->member[g->watch.gainer].slot, rise, borne, "");
    for (int i = 0; i < g->moving_count; i++)
        w->bodies.data[g->slots[i]].watch.rise = 0;
}

/* Part of the bound for the smallest pair of a group below which nobody looks at its contacts one by one. What a crowd says of its overlap is
 * that of its contacts as they are now. */
#define FINE 0.1
static real fine_of(const Group *g) { return g->crowd ? 1 : FINE; }

static real depth_of(const GroupContact *c) { return c->live ? real_max(0, contact_depth(c)) : 0; }

/* With whom. A plane is solid all through: a body may well have been put beyond its surface. */
static void warn_overlap(World *w, const GroupPair *q, uint32_t body, real depth, real bound)
{
    char text[BODY_TEXT_SIZE], why[sizeof((dig_warning *)0)->why];
    const Pair *p = &w->pairs.data[q->slot];
    const Solid *other = &w->solids.data[p->body_a == body ? p->solid_b : p->solid_a];
    bool beyond = other->form->shape.type == &shape_plane && depth > w->bodies.data[body].outer;
    snprintf(why, sizeof why, "%s %s", beyond ? "its middle is beyond" : "with", solid_text(w, other, text));
    warn(w, DIG_RULE_OVERLAP, body, depth, bound, why);
}

static void judge_overlaps(World *w, const Group *g)
{
    if (!(g->penetration > fine_of(g) * rules[DIG_RULE_OVERLAP].bound * g->finest))
        return;
    for (int i = 0; i < g->contact_count; i++) {
        const GroupContact *c = &g->contacts[i];
        real depth = depth_of(c), bound = rules[DIG_RULE_OVERLAP].bound * g->pairs[c->pair].size;
        if (!(depth > bound) || !(g->member[c->a].moves || g->member[c->b].moves))
            continue;
        uint32_t body = lighter(g, c->a, c->b);
        if (lasts(w, DIG_RULE_OVERLAP, body, 0))
            warn_overlap(w, &g->pairs[c->pair], body, depth, bound);
    }
}

static void judge_joints(World *w, const Group *g)
{
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        if (!(j->off > 0))
            continue;
        real bound = rules[DIG_RULE_JOINT].bound * joint_size(g, j);
        uint32_t body = lighter(g, j->a, j->b);
        if (j->off > bound && lasts(w, DIG_RULE_JOINT, body, 0))
            warn(w, DIG_RULE_JOINT, body, j->off, bound, w->joints.data[j->slot].type->name);
    }
}

static void judge_residual(World *w, const Group *g)
{
    real bound = residual_bound(g);
    if (g->residual > bound && lasts(w, DIG_RULE_RESIDUAL, g->slots[0], 0))
        warn(w, DIG_RULE_RESIDUAL, g->watch.misfit, g->residual, bound, g->way->name);
}

/* At the default and below, what goes beyond the finest way is swept as a matter of course; who asks for more wants to know. */
static bool asked_for_more(const Group *g) { return g->plan->tolerance < accuracy_plan(accuracy_find("play"))->tolerance; }

/* Tried again after the pauses of solve/gather.c, and in vain again. */
static void judge_budget(World *w, const Group *g)
{
    uint32_t lead = g->slots[0];
    if (g->gave_up && asked_for_more(g) && lasts(w, DIG_RULE_BUDGET, lead, w->bodies.data[lead].trace_pause))
        warn(w, DIG_RULE_BUDGET, lead, rules[DIG_RULE_BUDGET].steps, rules[DIG_RULE_BUDGET].bound, g->gave_up);
}

void watch_world(World *w, const Step *s)
{
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        judge_energy(w, g);
        judge_overlaps(w, g);
        judge_joints(w, g);
        judge_residual(w, g);
        judge_budget(w, g);
    }
}
