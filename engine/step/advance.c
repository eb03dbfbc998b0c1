/* step/advance.c - groups are advanced on private copies, in parallel, and checked. */
#include "base/block.h"
#include "math/pair.h"
#include "step/step.h"

#include <float.h>
#include <stdlib.h>

/* ---- the effects of a stage ---- */

static bool vel_finite(const Vel *v) { return vec3_finite(v->v) && vec3_finite(v->w); }

/* Blame mode: the first effect after which something is not finite. */
static bool find_culprit(Group *g, const char *effect, bool forces)
{
    for (int i = 0; i < g->moving_count && g->culprit < 0; i++) {
        const Member *m = &g->member[i];
        bool fine = vec3_finite(g->pos[i].x) && quat_finite(g->pos[i].q) && vel_finite(&g->vel[i]);
        if (forces)
            fine = fine && vec3_finite(m->force) && vec3_finite(m->torque);
        if (m->moves && !fine) {
            g->culprit = i;
            g->culprit_effect = effect;
        }
    }
    return g->culprit >= 0;
}

static dig_status run_stage(Group *g, int stage)
{
    const World *w = g->world;
    if (g->blame && find_culprit(g, stage == STAGE_FORCE ? "state" : "solver", false))
        return DIG_E_FINITE;
    for (uint32_t left = g->effects & w->bits.stage[stage]; left; left &= left - 1) {
        int i = lowest_bit(left);
        const EffectSlot *slot = &w->effects[i];
        real start = g->timed ? wall_us() : 0;
        DIG_TRY(slot->type->run[stage](slot, g));
        if (g->timed)
            g->effect_us[i] += wall_us() - start;
        if (g->blame && find_culprit(g, slot->type->name, stage == STAGE_FORCE))
            return DIG_E_FINITE;
    }
    return DIG_OK;
}

/* ---- one group ---- */

static bool has_member(const Group *g, const Column *members)
{
    for (int i = 0; i < g->moving_count && members->count > 0; i++)
        if (g->member[i].moves && column_find(members, g->member[i].slot))
            return true;
    return false;
}

/* Of one that may be called for: World.bits. */
static bool is_wanted(const Group *g, const EffectSlot *e)
{
    if (e->type->wanted)
        return e->type->wanted(g->world, g);
    if (e->owner)
        return e->owner->all ? g->moving_count > 0 : has_member(g, &e->members);
    return e->type->body_params ? has_member(g, &e->members) : e->world != NULL;
}

static void call_effects(Group *g)
{
    const World *w = g->world;
    const EffectBits *bits = &w->bits;
    for (uint32_t left = bits->called; left; left &= left - 1) {
        const EffectSlot *e = &w->effects[lowest_bit(left)];
        if (!is_wanted(g, e))
            continue;
        g->effects |= left & -left;
        g->laws |= 1u << e->type->stands;
    }
    g->losses = bits->losses;
    g->own = g->effects & bits->own;
    g->turns = g->effects & bits->turns;
    g->varies = g->effects & bits->varies;
    g->settles = g->effects & bits->stage[STAGE_SETTLE];
}

/* What no effect stands for is kept from the ways. Pairs come back when the step is judged: bodies may touch without force. */
static dig_status leave_out(Group *g)
{
    DIG_TRY(group_leave_out(g, 0));
    if (!(g->laws >> LAW_JOINTS & 1))
        g->joint_count = 0;
    if (!(g->laws >> LAW_PUSH & 1))
        g->push_count = 0;
    if (!(g->laws >> LAW_CONTACT & 1))
        g->pair_count = g->contact_count = g->left_count = g->left_end = 0;
    return DIG_OK;
}

static bool is_sphere(const Body *b) { return b->round_inertia && b->rim == 0; }

/* Where nothing can turn a sphere, its rotation is no unknown: it keeps its spin to the last bit and goes on turning evenly, whatever
 * rounding in the rows of its contacts says. */
static void keep_spins(Group *g, real dt)
{
    const World *w = g->world;
    for (int i = 0; i < g->moving_count && !g->turns && !g->woke; i++) {
        const Body *b = &w->bodies.data[g->member[i].slot];         /* as before the step */
        if (!g->member[i].moves || !is_sphere(b))
            continue;
        g->vel[i].w = b->w;
        g->pos[i].q = vec3_length2(b->w) > 0 ? quat_unit(quat_mul(quat_exp(vec3_scale(dt, b->w)), b->q)) : b->q;
        g->unturned++;
    }
}

static dig_status advance_judged(Group *g, real dt)
{
    int pairs = g->pair_count, contacts = g->contact_count;
    DIG_TRY(leave_out(g));
    DIG_TRY(group_apart(g));
    watch_start(g);
    DIG_TRY(group_advance(g, dt));
    keep_spins(g, dt);
    if (pairs > 0 && !(g->laws >> LAW_CONTACT & 1)) {
        g->pair_count = pairs;
        g->contact_count = contacts;
        g->acts = NULL;         /* what acted was counted of no contact: now there are some, and nothing acted in them */
        DIG_TRY(group_gather_rest(g));
        DIG_TRY(group_open_acted(g));
        group_touch(g, dt, true);
    }
    return group_judge(g, dt);
}

/* Fault injection (dig_world_inject). */
static void poison(Group *g, dig_body who)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && g->member[i].slot == who.slot)
            g->vel[i].v.x = (real)NAN;
}

static bool member_finite(const Group *g, int i)
{
    return !g->member[i].moves || (vec3_finite(g->pos[i].x) && quat_finite(g->pos[i].q) && vel_finite(&g->vel[i]));
}

static bool joints_finite(const Group *g)
{
    for (int i = 0; i < g->joint_count; i++)
        if (!vec3_finite(g->joints[i].impulse) || !vec3_finite(g->joints[i].angular_impulse))
            return false;
    return true;
}

static bool group_finite(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (!member_finite(g, i))
            return false;
    return joints_finite(g) && g->status == DIG_OK;
}

/* Numbers may be finite and yet so large that no step could follow, nor a file hold them. */
static bool in_range(const Group *g, int i)
{
    real fast = real_max(vec3_largest(vec3_abs(g->vel[i].v)), vec3_largest(vec3_abs(g->vel[i].w)));
    return !g->member[i].moves || (vec3_largest(vec3_abs(g->pos[i].x)) <= WORLD_FAR && fast <= WORLD_FAST);
}

_Static_assert(sizeof(Pos) == 7 * sizeof(real) && sizeof(Vel) == 6 * sizeof(real), "member_sound goes through their numbers");

/* Both, in one look, two numbers at a time: what is in range is finite. */
static bool member_sound(const Group *g, int i)
{
    const real *p = &g->pos[i].x.x, *v = &g->vel[i].v.x;
    const pair far = pair_all(WORLD_FAR), fast = pair_all(WORLD_FAST), finite = pair_all(DBL_MAX), far_finite = {WORLD_FAR, DBL_MAX};
    pair_int fine = (pair_abs(two(v)) <= fast) & (pair_abs(two(v + 2)) <= fast) & (pair_abs(two(v + 4)) <= fast);
    fine &= (pair_abs(two(p)) <= far) & (pair_abs(two(p + 2)) <= far_finite) & (pair_abs(two(p + 4)) <= finite) & (pair_abs(two(p + 5)) <= finite);
    return !g->member[i].moves || pair_bits(fine) == 3;
}

typedef struct Soundness { const Group *g; atomic_bool nan, far; } Soundness;      /* of some member: it is no number; it is out of range */

INLINE void sound_share(void *context, int thread, int threads)
{
    Soundness *s = context;
    for (int i = team_first(s->g->moving_count, thread, threads), end = team_end(s->g->moving_count, thread, threads); i < end; i++) {
        if (member_sound(s->g, i))
            continue;
        if (!member_finite(s->g, i))
            atomic_store(&s->nan, true);
        if (!in_range(s->g, i))
            atomic_store(&s->far, true);
    }
}

/* As group_finite; g->sound: and all is in range. */
static bool look_if_sound(Group *g)
{
    Soundness s = {.g = g};
    team_deal(g->team, sound_share, &s);
    bool finite = !atomic_load(&s.nan) && joints_finite(g) && g->status == DIG_OK;
    g->sound = finite && !atomic_load(&s.far);
    return finite;
}

typedef struct Context { World *w; Step *s; bool blame, alone; } Context;     /* alone: this is the calling thread, and others wait */

/* The group of that part of the step, from the world's records to what a commit would write. */
static void advance_part(Context *c, int i, Scratch scratch)
{
    const struct StepGroup *part = &c->s->parts[i];
    Group *g = &c->s->groups[i];
    block_clear(g, sizeof *g);
    g->plan = part->plan;
    g->tolerance = accuracy_local(part->accuracy);
    g->may_trace = part->may_trace;
    g->crowd = part->crowd;
    g->calm = part->calm;
    g->again = c->s->tries > 0;
    g->team = part->together ? workers_team(c->w->workers) : NULL;
    g->stage = run_stage;
    g->blame = c->blame;
    g->timed = c->s->timed;
    g->status = group_gather(g, c->w, c->s->leads + part->dig_first, part->dig_count, c->s->pairs + part->pair_first, part->pair_count, scratch.step,
                             scratch.group);
    if (g->status != DIG_OK)
        return;
    if (c->w->poisoned.gen != 0)
        poison(g, c->w->poisoned);
    if (group_is_most(g)) {         /* at most one is. Not all the room there is: what nobody has written to takes no memory */
        g->idle = c->w->events.data;
        g->idle_bytes = (size_t)int_min(c->w->events_written, c->w->events.capacity) * sizeof *c->w->events.data;
    }
    call_effects(g);
    if (g->own && !c->alone) {
        g->waits = true;
        return;
    }
    g->status = advance_judged(g, c->s->dt);
    if (g->status == DIG_OK)
        watch_group(g);
    bool finite = look_if_sound(g);
    g->strays = finite ? count_strays(g) : 0;
}

static void advance_one(void *context, int i, Scratch scratch)
{
    ArenaMark mark = arena_mark(scratch.group);
    advance_part(context, i, scratch);
    arena_rewind(scratch.group, mark);
}

static bool all_finite(const Step *s)
{
    for (int i = 0; i < s->count; i++)
        if (!s->groups[i].sound && !group_finite(&s->groups[i]))
            return false;
    return true;
}

static dig_status wake_pushed(World *w, const Step *s)
{
    bool woke = false;
    for (int i = 0; i < s->count; i++)
        woke = woke || s->groups[i].woke;
    if (!woke || !all_finite(s))            /* that step will not be: it wakes nobody */
        return DIG_OK;
    woke = false;
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        for (int k = 0; g->woke && k < g->moving_count; k++)
            if (g->member[k].pushed) {
                body_wake(w, g->member[k].slot);
                woke = true;
            }
    }
    return woke ? DIG_E_BUSY : DIG_OK;
}

/* Who asks for it, can take the step without this body. Where functions of the caller's act it is for them to mend what they did. */
static void accuse(World *w, const Group *g, int member)
{
    if (member >= 0 && !g->own)
        w->culprit = body_handle(w, g->member[member].slot);
}

static dig_status name_culprit(World *w, const Group *g)
{
    accuse(w, g, g->culprit);
    const char *effect = g->culprit_effect ? g->culprit_effect : "solver";
    const Body *b = g->culprit >= 0 ? &w->bodies.data[g->member[g->culprit].slot] : NULL;
    return world_fail(w, DIG_E_FINITE, "at t = %g s effect '%s' gave %s a non-finite %s", world_time(w), effect, b ? BODY_TEXT(w, b) : "?",
                      strcmp(effect, "solver") == 0 || strcmp(effect, "state") == 0 ? "velocity" : "force");
}

typedef struct Cost { int cost, part; } Cost;

static int compare_cost(const void *a, const void *b)
{
    const Cost *x = a, *y = b;
    return x->cost != y->cost ? (x->cost < y->cost ? 1 : -1) : (x->part > y->part) - (x->part < y->part);
}

#define TOGETHER 256            /* bodies and pairs: less is not worth the meetings of a team */

/* Who does what: crowds so large that others would wait for them are advanced by all threads together; then the rest, the dearest
 * first. This decides when things are done, not what comes out. */
static dig_status share_out(World *w, Step *s)
{
    if (!workers_team(w->workers))
        return DIG_OK;
    Cost *list = arena_alloc(&w->scratch, (size_t)s->count * sizeof *list);
    s->order = arena_alloc(&w->scratch, (size_t)s->count * sizeof *s->order);
    if (!list || !s->order)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for the step's groups");
    int64_t total = 0, threads = workers_team(w->workers)->threads;
    for (int i = 0; i < s->count; i++) {
        list[i] = (Cost){s->parts[i].cost, i};
        total += list[i].cost;
    }
    if (threads > 1)
        qsort(list, (size_t)s->count, sizeof *list, compare_cost);
    s->together = 0;
    for (int i = 0; i < s->count; i++) {
        struct StepGroup *g = &s->parts[list[i].part];
        s->order[i] = list[i].part;
        g->together = threads > 1 && s->together == i && g->crowd && g->cost >= TOGETHER && threads * g->cost > total;
        s->together += g->together;
    }
    return DIG_OK;
}

/* The groups that are not done together, each by one thread. */
static void in_order(World *w, Step *s, Job *job, Context *c)
{
    workers_run(w->workers, world_scratch(w), job, c, s->count - s->together);
}

static int turn_of(const Step *s, int i) { return s->order ? s->order[s->together + i] : i; }

static void advance_turn(void *context, int i, Scratch scratch)
{
    const Context *c = context;
    advance_one(context, turn_of(c->s, i), scratch);
}

static void commit_turn(void *context, int i, Scratch scratch)
{
    const Context *c = context;
    (void)scratch;
    group_commit(c->w, &c->s->groups[turn_of(c->s, i)]);
}

void commit_groups(World *w, Step *s)
{
    Context c = {w, s, false, false};
    for (int i = 0; i < s->count; i++)
        group_commit_records(w, &s->groups[i]);
    for (int i = 0; i < s->together; i++)
        group_commit(w, &s->groups[s->order[i]]);
    in_order(w, s, commit_turn, &c);
}

dig_status advance_groups(World *w, Step *s)
{
    if (s->count == 0)
        return DIG_OK;
    Context c = {w, s, false, !workers_team(w->workers)};
    DIG_TRY(share_out(w, s));
    for (int i = 0; i < s->together; i++)
        advance_one(&c, s->order[i], world_scratch(w));
    in_order(w, s, advance_turn, &c);
    c.alone = true;                     /* effects of the caller's: by this thread, and in the same order for any number of them */
    for (int i = 0; i < s->count; i++)
        if (s->groups[i].waits)
            advance_one(&c, i, world_scratch(w));
    for (int i = 0; i < s->count; i++) {
        dig_status status = s->groups[i].status;
        if (status == DIG_E_MEMORY)
            return world_fail(w, status, "at t = %g s: not enough memory for a group of %d bodies", world_time(w), s->groups[i].moving_count);
        if (status != DIG_OK && status != DIG_E_FINITE)
            return status;
    }
    DIG_TRY(wake_pushed(w, s));
    return all_finite(s) ? look_for_strays(w, s) : DIG_OK;
}

/* ---- the finite check ---- */

static dig_status check_range(World *w, const Group *g)
{
    for (int i = 0; i < g->moving_count; i++) {
        if (in_range(g, i))
            continue;
        real far = vec3_largest(vec3_abs(g->pos[i].x));
        real fast = real_max(vec3_largest(vec3_abs(g->vel[i].v)), vec3_largest(vec3_abs(g->vel[i].w)));
        const Body *b = &w->bodies.data[g->member[i].slot];
        accuse(w, g, i);
        w->stats.rejected++;
        if (fast > WORLD_FAST)
            return world_fail(w, DIG_E_FINITE, "at t = %g s %s would have a velocity or spin of %g m/s or rad/s, must be at most %g",
                              world_time(w), BODY_TEXT(w, b), fast, WORLD_FAST);
        return world_fail(w, DIG_E_FINITE, "at t = %g s %s would be %g m from the origin, must be at most %g m", world_time(w), BODY_TEXT(w, b),
                          far, WORLD_FAR);
    }
    return DIG_OK;
}

/* One pass a step; only after a hit is the group advanced again in blame mode, checking after each effect. That works because a
 * failed step changed nothing. */
dig_status check_finite(World *w, Step *s)
{
    for (int i = 0; i < s->count; i++) {
        if (s->groups[i].sound)
            continue;
        if (group_finite(&s->groups[i])) {
            DIG_TRY(check_range(w, &s->groups[i]));
            continue;
        }
        Context c = {w, s, true, true};
        advance_one(&c, i, world_scratch(w));
        if (s->groups[i].culprit < 0)
            find_culprit(&s->groups[i], "solver", false);
        w->stats.rejected++;
        return name_culprit(w, &s->groups[i]);
    }
    return DIG_OK;
}
