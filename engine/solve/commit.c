/* solve/commit.c - the end of a group's step: which pairs begin and end, and all that it found goes back into the world's records. */
#include "solve/group.h"

#include "math/pair3.h"
#include "world/joint.h"

/* Does the point lie still against the other body? Then it touches, though nothing presses: books side by side. */
static bool point_rests(const Group *g, const GroupContact *c, const ManifoldPoint *p)
{
    vec3 va = vec3_add(g->vel[c->a].v, vec3_cross(g->vel[c->a].w, vec3_sub(p->a, g->pos[c->a].x)));
    vec3 vb = vec3_add(g->vel[c->b].v, vec3_cross(g->vel[c->b].w, vec3_sub(p->b, g->pos[c->b].x)));
    return fabs(vec3_dot(c->manifold.normal, vec3_sub(vb, va))) <= 0.1 * g->close_speed;
}

#define HOP 2e-3                /* of the size */

static bool hops(const Group *g, int contact, real dt)
{
    const Acted *acted = acted_in(g, contact);
    return acted && acted->last > 0.5 * dt;
}

/* Does it touch? A touch begins with force and ends with distance: a hop of a thousandth of the size is no end while force comes
 * back. */
static bool contact_touches(const Group *g, const GroupPair *q, int contact, real dt)
{
    const GroupContact *c = &g->contacts[contact];
    real near = 100 * g->touch * q->size;
    for (int k = 0; k < c->manifold.count; k++) {
        const ManifoldPoint *at = &c->manifold.points[k];
        bool there = at->gap <= near || (q->was_touching && at->gap <= HOP * q->size && hops(g, contact, dt));
        if (there && (contact_memory(c)[k].normal > 0 || q->was_touching || point_rests(g, c, at)))
            return true;
    }
    return false;
}

/* Has it no point (so that it does not roll either), and no force that the world's record would hold? */
static bool contact_idle(const Group *g, int contact)
{
    const GroupManifold *m = &g->contacts[contact].manifold;
    if (m->count > 0 || m->slides)
        return false;
    const Acted *acted = acted_in(g, contact);
    return !acted || vec3_is_zero(acted->impulse);
}

/* Is there a hint to keep of a pair? Meshes have theirs from the start. */
static bool keeps_memory(const GroupPair *q) { return q->contacts > 1 || (q->hint && q->hint->kind != 0); }

typedef struct Verdict { int changed, turned, widened, remembered, live, rubbing; real finest; } Verdict;     /* of one thread */
typedef struct Judge { Group *g; real dt; Verdict *verdict; } Judge;

static void judge_pair(Group *g, int i, real dt, Verdict *v, int *changed, int *turned)
{
    GroupPair *q = &g->pairs[i];
    v->finest = real_min(v->finest, q->size);
    bool touching = false;
    for (int k = q->contact; k < q->contact + q->contacts; k++) {
        GroupContact *c = &g->contacts[k];
        if (c->manifold.count == 0) {       /* what is over is not remembered */
            if (g->contact_rest)
                g->contact_rest[k].rolling = vec3_zero();
            c->manifold.slides = false;
        }
        c->touching = contact_touches(g, q, k, dt);
        touching = touching || c->touching;
        c->was_idle = c->idle;
        c->idle = contact_idle(g, k);
        bool comes_or_goes = q->contacts == 1 && (c->slot == NONE) != c->idle;
        bool widens = c->manifold.count > 1 && !c->manifold.wide;
        bool remembers = k == q->contact && keeps_memory(q) != (q->memory != NONE);
        if (comes_or_goes || widens || remembers)
            turned[v->turned++] = k;
        v->widened += widens;
        v->remembered += remembers && q->memory == NONE;
        v->live += c->live;
        v->rubbing += c->live && q->rub->friction > 0;
    }
    q->touching = touching;
    if (touching != q->was_touching || (q->struck && !touching))
        changed[v->changed++] = i;
}

INLINE void judge_share(void *context, int thread, int threads)
{
    const Judge *j = context;
    Group *g = j->g;
    int first = team_first(g->pair_count, thread, threads), end = team_end(g->pair_count, thread, threads);
    Verdict v = {.finest = INFINITY};
    for (int i = first; i < end; i++)
        judge_pair(g, i, j->dt, &v, g->changed + first, g->turned + g->pairs[first].contact);
    j->verdict[thread] = v;
}

/* Lists the pairs that regraph must look at: begun, over, or struck and apart again. */
dig_status group_judge(Group *g, real dt)
{
    int shares = team_shares(g->team);
    Judge j = {.g = g, .dt = dt, .verdict = arena_alloc(g->arena, (size_t)shares * sizeof *j.verdict)};
    g->changed = spare_take(&g->spare, g->lasting, (size_t)g->pair_count * sizeof *g->changed);
    g->turned = spare_take(&g->spare, g->lasting, (size_t)g->contact_count * sizeof *g->turned);
    if (!j.verdict || !g->changed || !g->turned || g->no_room)
        return DIG_E_MEMORY;
    team_deal(g->team, judge_share, &j);
    g->changed_count = g->turned_count = g->widened_count = g->remembered_count = g->live_count = g->rubbing_count = 0;
    g->finest = INFINITY;
    for (int t = 0; t < shares && g->pair_count > 0; t++) {
        const Verdict *v = &j.verdict[t];
        int first = team_first(g->pair_count, t, shares);
        if (first > 0 && first < g->pair_count) {        /* those of the first share are where they should be */
            memmove(g->changed + g->changed_count, g->changed + first, (size_t)v->changed * sizeof *g->changed);
            memmove(g->turned + g->turned_count, g->turned + g->pairs[first].contact, (size_t)v->turned * sizeof *g->turned);
        }
        g->changed_count += v->changed;
        g->turned_count += v->turned;
        g->widened_count += v->widened;
        g->remembered_count += v->remembered;
        g->live_count += v->live;
        g->rubbing_count += v->rubbing;
        g->finest = real_min(g->finest, v->finest);
    }
    return DIG_OK;
}

/* ---- back into the world ---- */

#define FIRST_PAUSE 256         /* over the square of the plan's substeps: 16 steps at "play", 1 at "study", where sweeps cost what is asked for */

#define LONGEST_PAUSE 1024
#define CALM_PAUSE    128       /* of what lies calm: then all of it is solved at once again */

/* A group that the traced way handed on is not tried again for some steps, then twice as many, ...; each that succeeds forgets one. */
static void commit_trace(const Group *g, Body *b, Toil fresh)
{
    b->toil = b->toil.steps | b->toil.pause | b->toil.dear ? toil_after(g, b->toil) : fresh;
    if (g->trace_failed) {
        int longest = g->calm ? int_max(CALM_PAUSE, b->trace_pause) : LONGEST_PAUSE;
        int first = int_max(1, int_min(16, FIRST_PAUSE / (g->plan->substeps * g->plan->substeps)));
        b->trace_pause = (uint16_t)int_min(longest, int_max(first, 2 * b->trace_pause));
        b->trace_wait = b->trace_pause;
        b->trace_step = 0;
        return;
    }
    if (b->trace_wait > 0)
        b->trace_wait--;
    else if (b->trace_pause > 0)
        b->trace_pause--;
    b->trace_step = g->trace_step;
}

/* kg m^2/s  By how much the angular momentum about its centre of mass changed since it had the spin old_w. What is not round was watched (watch.c)
 * from the spin that the body has. */
static vec3 spun(const Body *b, const Member *m, vec3 old_w, const Pos *pos, const Vel *vel)
{
    const mat3 *inertia = &body_inertia(b)->of;
    if (b->round_inertia)
        return vec3_sub(mat3_mul_vec(*inertia, vel->w), mat3_mul_vec(*inertia, old_w));
    if (!b->rests)
        return m->torque;
    const pair_quat q = pair_quat_of(b->q, pos->q);
    pair3 l = pair_quat_rotate(q, pair3_by(inertia, pair_quat_rotate(pair_quat_conjugate(q), pair3_of(old_w, vel->w))));
    return vec3_sub(pair3_get(l, 1), pair3_get(l, 0));
}

/* What lies in a crowd trembles: where it gets to says more than its speed. */
static void commit_drift(World *w, const Group *g, Body *b, const Pos *to)
{
    bool crowded = g->crowd && g->world->def.sleeping;
    if (crowded && (!b->crowded || b->still <= 0))
        *body_drift(w, b) = (Drift){vec3_zero(), vec3_zero()};
    b->crowded = crowded;
    if (!crowded)
        return;
    quat q = quat_mul(to->q, quat_conjugate(b->q));
    Drift *d = body_drift(w, b);
    d->way = vec3_add(d->way, vec3_sub(to->x, b->x));
    d->turn = vec3_mad(d->turn, copysign(2, q.w), (vec3){q.x, q.y, q.z});
}

/* fresh: toil_after of what has had none. */
static void commit_body(World *w, const Group *g, int i, Toil fresh, real dt)
{
    const Member *m = &g->member[i];
    Body *b = &w->bodies.data[m->slot];
    b->watch.rise = m->moves ? g->watch.part : 0;
    b->watch.borne = m->moves ? g->watch.part_borne : 0;
    if (!m->moves)
        return;
    const BodyRest *rest = body_rest(w, b);
    vec3 old_v = vec3_sub(b->v, rest->hit_v), old_w = vec3_sub(b->w, rest->hit_w);
    vec3 turned = spun(b, m, old_w, &g->pos[i], &g->vel[i]);
    commit_drift(w, g, b, &g->pos[i]);
    b->prev_x = b->x;
    b->prev_q = b->q;
    body_travels(b, g->pos[i].x, g->pos[i].q);
    b->x = g->pos[i].x;
    b->q = g->pos[i].q;
    b->v = g->vel[i].v;
    b->w = g->vel[i].w;
    b->collided = m->collided;
    b->euler = m->integrator == DIG_AUTO ? m->collided || m->constrained : m->integrator == DIG_SWITCH ? m->collided : m->integrator == DIG_EULER;
    b->work += m->push_work;
    commit_trace(g, b, fresh);
    b->force = vec3_scale(m->mass / dt, vec3_sub(b->v, old_v));
    b->torque = vec3_scale(body_inertness(b) / dt, turned);
    if (b->rests)
        body_rest_own(w, b)->hit_v = body_rest_own(w, b)->hit_w = vec3_zero();
    b->lies = real_max(b->lies, 0);     /* the pairs have seen that something else acts on it */
}

static void commit_contact(World *w, const Group *g, int contact, real dt)
{
    const GroupContact *from = &g->contacts[contact];
    Contact *to = &w->contacts.data[from->slot];
    to->idle = from->idle;
    to->piece = from->piece;
    to->normal = from->manifold.normal;
    to->count = (uint8_t)from->manifold.count;
    for (int k = 0; k < from->manifold.count; k++) {
        ContactPoint *p = contact_point(w, to, k);
        p->at = from->manifold.points[k];
        p->memory = contact_memory(from)[k];
    }
    to->rests = false;
    if (g->contact_rest)
        contact_rest_set(w, from->slot, g->contact_rest[contact]);
    to->sliding = from->manifold.slides;
    to->grips = from->grips;
    to->touching = from->touching;
    static const Acted none;
    const Acted *acted = acted_in(g, contact);
    acted = acted ? acted : &none;
    to->force = vec3_scale(1 / dt, acted->impulse);
    to->point = acted->point_weight > WEIGHT_LEAST ? vec3_scale(1 / acted->point_weight, acted->point_sum)
                                       : from->manifold.count ? from->manifold.points[0].a : vec3_zero();
}

static dig_status commit_memory(World *w, Pair *p, GroupPair *q, bool keeps)
{
    dig_status room = keeps && p->memory == NONE ? pair_remember(w, p) : DIG_OK;
    if (!keeps && p->memory != NONE)
        pair_forget(w, p);
    q->memory = p->memory;
    return room;
}

/* A pair of convex solids has a contact as long as there is something to remember, and that has room for more than one point from when
 * there are more, and a memory as long as there is a hint; there is room for all of these (reserve_regraph). */
void group_commit_records(World *w, Group *g)
{
    for (int i = 0; i < g->turned_count; i++) {
        GroupContact *c = &g->contacts[g->turned[i]];
        GroupPair *q = &g->pairs[c->pair];
        Pair *p = &w->pairs.data[q->slot];
        dig_status room = g->turned[i] == q->contact ? commit_memory(w, p, q, keeps_memory(q)) : DIG_OK;
        if (c->idle && q->contacts == 1) {
            if (c->slot != NONE)
                contact_give(w, c->slot);
            p->contact = c->slot = NONE;
            continue;
        }
        if (c->slot == NONE && room == DIG_OK) {
            room = contact_take(w, &c->slot);
            p->contact = c->slot;
        }
        if (c->manifold.count > 1 && room == DIG_OK)
            room = contact_widen(w, &w->contacts.data[c->slot]);
        DIG_ASSERT(room == DIG_OK);
    }
}

static void commit_pair(World *w, const Group *g, const GroupPair *q, real dt)
{
    Pair *p = &w->pairs.data[q->slot];
    if (q->memory != NONE && q->hint)
        w->memories.data[q->memory].cache = *q->hint;
    p->until = q->until;
    p->fresh = false;
    p->touching = q->touching;
    for (int i = q->contact; i < q->contact + q->contacts; i++)
        if (g->contacts[i].slot != NONE && !(g->contacts[i].idle && g->contacts[i].was_idle))
            commit_contact(w, g, i, dt);
}

static void commit_joint(World *w, const GroupJoint *j, real dt)
{
    JointRec *r = &w->joints.data[j->slot];
    memcpy(r->memory, j->memory, sizeof r->memory);
    memcpy(r->impulse, j->force, sizeof r->impulse);
    r->lost = j->lost;
    r->force = vec3_scale(1 / dt, j->impulse);
    r->torque = vec3_scale(1 / dt, j->angular_impulse);
}

static void fetch_commit(const World *w, const Group *g, int i)
{
    if (i + FETCH_AHEAD >= g->pair_count)
        return;
    const GroupPair *q = &g->pairs[i + FETCH_AHEAD];
    const GroupContact *from = &g->contacts[q->contact];
    uint32_t slot = from->slot;
    if (from->manifold.count > 0) {
        fetch_soon(from->manifold.points, (size_t)from->manifold.count * sizeof(ManifoldPoint));
        fetch_soon(contact_memory(from), (size_t)from->manifold.count * sizeof(PointMemory));
    }
    fetch_more(w, g->contacts[g->pairs[i + FETCH_AHEAD / 2].contact].slot);
    fetch_soon(&w->pairs.data[q->slot], sizeof(Pair));
    if (q->memory != NONE && q->hint) {
        fetch_soon(q->hint, sizeof *q->hint);
        fetch_soon(&w->memories.data[q->memory], sizeof(ManifoldCache));
    }
    if (slot != NONE) {
        const Acted *acted = acted_in(g, q->contact);
        fetch_soon(&w->contacts.data[slot], sizeof(Contact));
        if (acted)
            fetch_soon(acted, sizeof *acted);
    }
}

typedef struct Commit { World *w; const Group *g; } Commit;

INLINE void commit_share(void *context, int thread, int threads)
{
    const Commit *c = context;
    const Group *g = c->g;
    const Toil fresh = toil_after(g, (Toil){0, 0, 0});
    real dt = c->w->def.step;
    for (int i = team_first(g->moving_count, thread, threads), end = team_end(g->moving_count, thread, threads); i < end; i++) {
        if (i + BODIES_AHEAD < g->moving_count)
            fetch_soon(&c->w->bodies.data[g->slots[i + BODIES_AHEAD]], offsetof(Body, watch) + sizeof(BodyWatch));
        commit_body(c->w, g, i, fresh, dt);
    }
    for (int i = team_first(g->pair_count, thread, threads), end = team_end(g->pair_count, thread, threads); i < end; i++) {
        fetch_commit(c->w, g, i);
        commit_pair(c->w, g, &g->pairs[i], dt);
    }
}

void group_commit(World *w, const Group *g)
{
    Commit c = {w, g};
    team_deal(g->team, commit_share, &c);
    for (int i = 0; i < g->joint_count; i++) {
        if (i + JOINTS_AHEAD < g->joint_count) {
            const JointRec *next = &w->joints.data[g->joints[i + JOINTS_AHEAD].slot];
            fetch_soon(next->memory, offsetof(JointRec, error) - offsetof(JointRec, memory));
        }
        commit_joint(w, &g->joints[i], w->def.step);
    }
}
