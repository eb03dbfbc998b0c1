/* step/regraph.c - touches begin and end; DIGs merge and split; overloaded joints break.
 *
 * A contact that is still there at the end of the step is a link. A bounce
 * within the step makes no lasting link: on a body at rest none at all (one
 * update when the ball comes to rest, none per bounce), between two moving
 * bodies one that lives a single step.
 */
#include "base/block.h"
#include "step/step.h"

/* What the end of a step asks of a pair whose touch changes: all threads look, for it lies in many places. */
struct Change {
    uint32_t body_a, body_b, touch;     /* touch: NONE = there was none before */
    int      pair;                      /* of its group                        */
    int      strike;                    /* Strike of that + 1, 0 = none        */
    uint8_t  wall;
    bool     now, was, struck;
    bool     bounced;                   /* struck, and both of them move       */
    real     time, speed, impulse;
};

static uint8_t pair_wall(const World *w, const Pair *p) { return w->solids.data[p->solid_a].wall | w->solids.data[p->solid_b].wall; }

/* Who may fall asleep at the end of this step. */
static int sleepers(const World *w, real dt)
{
    int n = 0;
    for (int i = 0; i < w->awake.count && w->def.sleeping; i++)
        n += w->bodies.data[w->awake.data[i]].still + dt >= SLEEP_TIME;
    return n;
}

/* So many slots there must be for `more` to be taken: what was given back is taken first. */
static int slots_for(int count, int given_back, int more) { return count + int_max(0, more - given_back); }

/* The largest group, which has most to tell of, has most to spare, too. */
static void find_spare(Step *s)
{
    const Group *largest = NULL;
    for (int i = 0; i < s->count; i++) {
        Group *g = &s->groups[i];
        if (!g->spare || (largest && largest->pair_count >= g->pair_count))
            continue;
        largest = g;
        s->spare = &g->spare;
    }
}

/* What lies on each other has two to three touches a body in the end. Once there is more than one, a list that would soon grow again gets room for
 * all of these, so that nothing grows after a pile has landed; a large list grows without being copied. */
static int touches_for(const World *w, int needed)
{
    int bodies = (int)w->awake.count, pile = 2 * bodies + bodies / 2;
    bool small = (size_t)pile * sizeof(Touch) < BLOCK_LARGE;
    return needed > w->touches.capacity && needed > bodies && small ? int_max(needed, pile) : needed;
}

/* For so many new records of pairs, contacts and touches, and what of them is given back. */
static dig_status reserve_records(World *w, int remembered, int born, int widened, int changed)
{
    DIG_TRY(list_reserve(&w->memories, slots_for(w->memories.count, w->free_memories.count, remembered), &w->allocations));
    DIG_TRY(list_reserve(&w->free_memories, w->memories.capacity, &w->allocations));
    DIG_TRY(list_reserve(&w->contacts, slots_for(w->contacts.count, w->free_contacts.count, born), &w->allocations));
    DIG_TRY(list_reserve(&w->free_contacts, w->contacts.capacity, &w->allocations));
    DIG_TRY(contacts_rest(w));
    DIG_TRY(list_reserve(&w->more, slots_for(w->more.count, w->free_more.count, widened), &w->allocations));
    DIG_TRY(list_reserve(&w->free_more, w->more.capacity, &w->allocations));
    DIG_TRY(list_reserve(&w->touches, touches_for(w, slots_for(w->touches.count, w->free_touches.count, changed)), &w->allocations));
    DIG_TRY(list_reserve(&w->free_touches, w->touches.capacity, &w->allocations));
    DIG_TRY(list_reserve(&w->brief, w->touches.capacity, &w->allocations));
    return index_reserve(&w->touch_index, w->touches.capacity);
}

/* All that regraph and what follows may need: a touch, a link and their events for each pair whose touch changes. */
dig_status reserve_regraph(World *w, Step *s)
{
    find_spare(s);
    DIG_TRY(reserve_tell(w, s));
    int changed = 0, most = 0, strikes = 0, born = 0, widened = 0, remembered = 0, others = sleepers(w, s->dt) + 64;
    for (int i = 0; i < s->count; i++) {
        changed += s->groups[i].changed_count + s->groups[i].over_count;
        most = int_max(most, s->groups[i].changed_count);
        strikes = int_max(strikes, s->groups[i].strike_count);
        born += s->groups[i].turned_count;
        widened += s->groups[i].widened_count;
        remembered += s->groups[i].remembered_count;
        others += s->groups[i].watch.leavers + s->groups[i].strike_count + 4 * s->groups[i].joint_count;
    }
    s->changes = most ? step_room(w, s, (size_t)most * sizeof *s->changes) : NULL;
    s->within = strikes ? step_room(w, s, (size_t)strikes * sizeof *s->within) : NULL;
    if ((most && !s->changes) || (strikes && !s->within))
        return world_fail(w, DIG_E_MEMORY, "not enough memory for what %d pairs and %d strikes change", most, strikes);
    if (changed + born + widened + remembered + w->brief.count > 0)
        DIG_TRY(reserve_records(w, remembered, born, widened, changed));
    int events = w->pending.count + 4 * (changed + w->brief.count) + others;
    w->events_most = int_max(w->events_most, events);
    DIG_TRY(reserve_events(w, events));
    return graph_reserve(w->graph, w->bodies.capacity, w->touches.capacity + w->joints.capacity);
}

static void begin_link(World *w, uint32_t touch)
{
    Touch *t = &w->touches.data[touch];
    uint32_t a = t->body_a, b = t->body_b;
    if (t->link != NONE || b == NONE)
        return;                             /* a wall has no body: a touch, but no link */
    bool bound = !body_dynamic(w, a) || !body_dynamic(w, b);
    if (bound && !body_dynamic(w, a)) {       /* the static end comes second */
        uint32_t x = a;
        a = b;
        b = x;
    }
    if (graph_link_add(w->graph, a, b, bound, DIG_LINK_CONTACT, touch, world_time(w), &t->link) != DIG_OK) {
        t->link = NONE;
        return;
    }
    dig_event *e = event_note(w, DIG_EVENT_LINK, t->body_a, t->body_b);
    if (e)
        e->link = DIG_LINK_CONTACT;
}

static void end_link(World *w, Touch *t)
{
    if (t->link == NONE)
        return;
    graph_link_remove(w->graph, t->link);
    t->link = NONE;
    dig_event *e = event_note(w, DIG_EVENT_UNLINK, t->body_a, t->body_b);
    if (e)
        e->link = DIG_LINK_CONTACT;
}

#define SHARED_LEAST 64          /* strikes, pairs, events: fewer are not worth a team */

static Team *team_for(const World *w, int count) { return count < SHARED_LEAST ? NULL : workers_team(w->workers); }

/* Strikes of a group, their events, and which of them are within a DIG, so that nobody is told. */
typedef struct Striking { const World *w; const Group *g; real start; dig_event *event; bool *within; } Striking;

static void strike_share(void *context, int thread, int threads)
{
    const Striking *all = context;
    const World *w = all->w;
    int count = all->g->strike_count;
    for (int i = team_first(count, thread, threads), end = team_end(count, thread, threads); i < end; i++) {
        const Strike *k = &all->g->strikes[i];
        const Pair *p = &w->pairs.data[all->g->pairs[k->pair].slot];
        all->within[i] = graph_lead(w->graph, p->body_a) == graph_lead(w->graph, p->body_b);
        dig_event *e = &all->event[i];
        event_write(w, e, DIG_EVENT_IMPACT, p->body_a, p->body_b);
        event_name(w, e);
        e->time = all->start + k->time;
        e->wall = pair_wall(w, p);
        e->speed = k->speed;
        e->impulse = k->impulse;
        e->point = k->point;
        e->normal = k->normal;
    }
}

static void strikes_of(World *w, Step *s, const Group *g, real start)
{
    Striking all = {w, g, start, events_claim(w, g->strike_count), s->within};
    if (!all.event)
        return;
    team_deal(team_for(w, g->strike_count), strike_share, &all);
    for (int i = 0; i < g->strike_count; i++) {
        const Strike *k = &g->strikes[i];
        if (all.within[i])
            continue;
        const Pair *p = &w->pairs.data[g->pairs[k->pair].slot];
        tell(w, s, p->body_a, p->body_b, start + k->time, k->speed);
        tell(w, s, p->body_b, p->body_a, start + k->time, k->speed);
    }
    w->stats.events += (uint64_t)g->strike_count;
}

/* m/s: a body that a blow left slower than this was not set in motion by it. */
#define SET_IN_MOTION 5e-3

static bool moves_now(const World *w, uint32_t body)
{
    const Body *b = &w->bodies.data[body];
    return vec3_length(b->v) + vec3_length(b->w) * b->outer > SET_IN_MOTION;
}

typedef struct Changing { const World *w; const Group *g; real start; struct Change *change; } Changing;

static void change_share(void *context, int thread, int threads)
{
    const Changing *all = context;
    const World *w = all->w;
    int count = all->g->changed_count;
    for (int i = team_first(count, thread, threads), end = team_end(count, thread, threads); i < end; i++) {
        const GroupPair *q = &all->g->pairs[all->g->changed[i]];
        const Pair *p = &w->pairs.data[q->slot];
        struct Change *c = &all->change[i];
        Impact hit = q->impact ? all->g->impacts[q->impact - 1] : (Impact){.time = 0};
        *c = (struct Change){.body_a = p->body_a, .body_b = p->body_b, .pair = all->g->changed[i], .strike = hit.first,
                             .wall = pair_wall(w, p), .now = q->touching, .was = q->was_touching, .struck = q->struck,
                             .time = all->start + (q->struck ? hit.time : all->g->t), .speed = q->speed, .impulse = hit.impulse};
        const Touch *t = touch_find(w, c->body_a, c->body_b, c->wall);
        c->touch = t ? (uint32_t)(t - w->touches.data) : NONE;
        c->bounced = q->struck && body_dynamic(w, c->body_a) && body_dynamic(w, c->body_b) &&
                     (q->both_moved || (moves_now(w, c->body_a) && moves_now(w, c->body_b)));
    }
}

/* Where, and with which normal, a pair touches that was not struck: laid on each other, or come so slowly. The middle of the points of
 * those pieces that touch, as a force shared evenly would have it. */
static void find_place(const Group *g, const GroupPair *q, dig_event *e)
{
    int count = 0;
    vec3 sum = vec3_zero(), normal = vec3_zero();
    for (int i = q->contact; i < q->contact + q->contacts; i++) {
        const GroupContact *c = &g->contacts[i];
        for (int k = 0; c->touching && k < c->manifold.count; k++, count++) {
            sum = vec3_add(sum, c->manifold.points[k].a);
            normal = vec3_add(normal, c->manifold.normal);
        }
    }
    if (count == 0)
        return;
    e->point = vec3_scale(1.0 / count, sum);
    e->normal = vec3_length2(normal) > 0 ? vec3_unit(normal) : normal;
}

static void post_begin(World *w, const Group *g, const struct Change *c)
{
    dig_event *e = event_note(w, DIG_EVENT_CONTACT_BEGIN, c->body_a, c->body_b);
    if (!e)
        return;
    e->time = c->time;
    e->wall = c->wall;
    e->speed = c->speed;
    e->impulse = c->impulse;
    if (c->strike > 0 && c->strike <= g->strike_count) {
        e->point = g->strikes[c->strike - 1].point;
        e->normal = g->strikes[c->strike - 1].normal;
    } else {
        find_place(g, &g->pairs[c->pair], e);
    }
}

/* Begin, end, or a bounce of one pair. Additions to the graph only; ends are noted in w->brief for later. */
static void touch_pair(World *w, const Group *g, const struct Change *c)
{
    uint32_t slot = c->touch;
    if (slot == NONE && touch_find_or_add(w, c->body_a, c->body_b, c->wall, &slot) != DIG_OK)
        return;
    Touch *t = &w->touches.data[slot];
    bool fresh = t->pairs == 0 && !t->brief && t->began <= 0 && t->link == NONE;
    touch_count(w, t, (int)c->now - (int)c->was);
    if (fresh && (c->now || c->struck)) {
        t->began = c->time + 1e-300;        /* > 0: has begun, even at t = 0 */
        t->speed = c->speed;
        t->impulse = c->impulse;
        post_begin(w, g, c);
    }
    if (t->pairs > 0) {
        begin_link(w, slot);
        return;
    }
    /* ended, or a bounce: remembered until the end of this step's regraph, or of the next one's */
    if (c->bounced)
        begin_link(w, slot);
    if (!t->brief && w->brief.count < w->brief.capacity) {
        t->brief = true;
        t->bounced = c->bounced;
        w->brief.data[w->brief.count++] = slot;
    }
}

static void touch_pairs(World *w, const Step *s, const Group *g, real start)
{
    Changing all = {w, g, start, s->changes};
    team_deal(team_for(w, g->changed_count), change_share, &all);
    for (int i = 0; i < g->changed_count; i++)
        touch_pair(w, g, &s->changes[i]);
}

typedef struct Parting { const World *w; dig_event *event; real least; } Parting;        /* m */

static void look_between(Parting *p, uint32_t solid_a, uint32_t solid_b)
{
    const Solid *a = &p->w->solids.data[solid_a], *b = &p->w->solids.data[solid_b];
    vec3 normal, on_a, on_b;
    real gap = shape_distance(&a->form->shape, solid_pose(p->w, a), &b->form->shape, solid_pose(p->w, b), p->least, &normal, &on_a, &on_b);
    if (!(gap < p->least))
        return;
    p->least = gap;
    p->event->point = vec3_lerp(on_a, on_b, 0.5);
    p->event->normal = normal;
}

/* Where two that touched have parted: in the middle between the two places where they are nearest now, at the end of the step. Of bodies of
 * many shapes those that are still pairs are looked at; where none is, or there is one each, the first ones. */
static void find_parting(const World *w, const Touch *t, dig_event *e)
{
    Parting p = {w, e, INFINITY};
    uint32_t first = w->bodies.data[t->body_a].shape_first, other = t->body_b != NONE ? w->bodies.data[t->body_b].shape_first : w->room_solid[t->wall - 1];
    bool one_each = w->solids.data[first].next == NONE && (t->body_b == NONE || w->solids.data[other].next == NONE);
    for (uint32_t s = first; s != NONE && !one_each; s = w->solids.data[s].next)
        for (uint32_t link = w->solids.data[s].pair_first; link != NONE; link = w->pairs.data[link / 2].next[link % 2]) {
            const Pair *q = &w->pairs.data[link / 2];
            uint32_t b = link % 2 ? q->solid_a : q->solid_b;
            if (t->body_b != NONE ? w->solids.data[b].body == t->body_b : b == other)
                look_between(&p, s, b);
        }
    if (p.least == INFINITY)
        look_between(&p, first, other);
}

/* Touches that are over give up their link; a bounce of two moving bodies keeps it for one step. */
static void end_touches(World *w, real start, real dt)
{
    int n = 0;
    for (int i = 0; i < w->brief.count; i++) {
        uint32_t slot = w->brief.data[i];
        Touch *t = &w->touches.data[slot];
        if (!t->alive)
            continue;
        if (t->pairs > 0) {
            t->brief = t->bounced = false;
            continue;
        }
        if (t->bounced) {
            t->bounced = false;
            w->brief.data[n++] = slot;
            continue;
        }
        end_link(w, t);
        dig_event *e = event_note(w, DIG_EVENT_CONTACT_END, t->body_a, t->body_b);
        if (e) {
            e->time = start + dt;
            e->wall = t->wall;
            find_parting(w, t, e);
        }
        t->brief = false;                   /* it is in the part of the list that is left behind */
        touch_remove(w, slot);
    }
    w->brief.count = n;
}

typedef struct Naming { const World *w; dig_event *event; int count; } Naming;

static void name_share(void *context, int thread, int threads)
{
    const Naming *n = context;
    for (int i = team_first(n->count, thread, threads), end = team_end(n->count, thread, threads); i < end; i++)
        event_name(n->w, &n->event[i]);
}

/* Of all events that were noted from number `first` on. */
static void name_events(World *w, int first)
{
    Naming n = {w, w->pending.data + first, w->pending.count - first};
    team_deal(team_for(w, n.count), name_share, &n);
}

/* Mean load of the step on a's anchor. */
static vec3 couple_of(const JointRec *r, const JointView *v) { return vec3_sub(r->torque, vec3_cross(v->a.r, r->force)); }

static bool is_slow(const World *w, uint32_t body) { return body != NONE && w->bodies.data[body].still > 0; }

static void stir(World *w, uint32_t body)
{
    if (body != NONE)
        w->bodies.data[body].still = 0;
}

static bool has_motor(const JointType *t) { return t->speed && !t->two_anchors; }       /* what acts along a line has none */

/* Does a motor in it turn or push, slow as it may be? One that is held fast does not. */
static bool is_driven(Group *g, int joint)
{
    const JointView *v = &g->joints[joint].view;
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    group_joint_view(g, joint);
    v->type->rows(v, &list);
    for (int i = 0; i < list.count; i++)
        if (rows[i].kind == ROW_MOTOR && v->type->speed(v) * rows[i].rate > 0.5 * rows[i].rate * rows[i].rate)
            return true;
    return false;
}

static void joints_of(World *w, Group *g)
{
    for (int i = 0; i < g->joint_count; i++) {
        GroupJoint *j = &g->joints[i];
        JointRec *r = &w->joints.data[j->slot];
        const JointType *type = r->type;
        if (type->settle && !j->broken) {
            group_joint_view(g, i);
            real lost = type->settle(&j->view, r->force, couple_of(r, &j->view));
            w->ledger.lost += lost;
            r->lost += lost;
            memcpy(r->memory, j->memory, sizeof r->memory);
        }
        if (has_motor(type) && (is_slow(w, r->a) || is_slow(w, r->b)) && is_driven(g, i)) {    /* the hand of a clock does not rest */
            stir(w, r->a);
            stir(w, r->b);
        }
        bool limit = type->at_limit && !r->plain && type->at_limit(&j->view);
        if (limit && !r->at_limit) {
            dig_event *e = event_post(w, DIG_EVENT_LIMIT_REACHED, r->a, r->b);
            if (e)
                e->joint = joint_handle(w, j->slot);
        }
        r->at_limit = limit;
    }
}

/* load in N; share of what it bears; time in s of the world. What its springs held is sound and heat. */
static void break_joint(World *w, const GroupJoint *j, real load, real share, real time)
{
    uint32_t slot = j->slot;
    JointRec *r = &w->joints.data[slot];
    w->ledger.lost += group_spring_energy(j);
    uint32_t a = r->a, b = r->b;
    int first = w->pending.count;
    dig_event *e = event_post(w, DIG_EVENT_BROKEN, a, b);
    if (e) {
        e->joint = joint_handle(w, slot);
        e->impulse = load * w->def.step;
        e->stress = share;
        e->point = j->view.a.p;
    }
    joint_remove(w, slot);
    for (int i = first; i < w->pending.count; i++)      /* what follows from it happened with it */
        w->pending.data[i].time = time;
}

/* A group that is followed in time, or swept, has found its breaks (solve/part.c). Else the weakest first: of the joints of one group that are over their
 * limit in the mean of the step, the one with the largest share breaks. A blow is no force: it counts by the mean in either. */
static void break_joints(World *w, Group *g, real start)
{
    int broken = 0, worst = -1;
    real share = 1;
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        const JointRec *r = &w->joints.data[j->slot];
        if (j->broken && r->alive) {
            real load = r->breaks_at > 0 ? j->overload * r->breaks_at : vec3_length(r->force);
            break_joint(w, j, load, j->overload, start + j->broke);
            broken++;
            continue;
        }
        if (!r->alive || !(r->breaks_at > 0 || r->type->share))
            continue;
        group_joint_view(g, i);
        real s = joint_share(&j->view, r->force, couple_of(r, &j->view));
        if (s > share) {
            share = s;
            worst = i;
        }
    }
    bool followed = g->breaks_found || (g->way && g->way->tally == WAY_TRACED && g->located == 0);
    if (worst >= 0 && broken == 0 && !followed)
        break_joint(w, &g->joints[worst], vec3_length(w->joints.data[g->joints[worst].slot].force), share, world_time(w));
}

/* Mostly none does. */
static bool touches_change(const World *w, const Step *s)
{
    bool any = w->brief.count > 0;
    for (int i = 0; i < s->count && !any; i++)
        any = s->groups[i].changed_count + s->groups[i].over_count > 0;
    return any;
}

static void change_touches(World *w, const Step *s, real start)
{
    graph_begin(w->graph);
    int first = w->pending.count;
    for (int i = 0; i < s->count; i++) {
        const Group *g = &s->groups[i];
        touch_pairs(w, s, g, start);
        for (int k = 0; k < g->over_count; k++)
            pair_let_go(w, g->over[k]);
    }
    end_touches(w, start, s->dt);
    name_events(w, first);
    graph_end(w->graph);
    post_graph_changes(w, DIG_LAYER_MECHANICAL);
}

void regraph(World *w, Step *s)
{
    real start = (real)(w->steps - 1) * s->dt;
    for (int i = 0; i < s->count; i++)
        if (s->groups[i].strike_count > 0)
            strikes_of(w, s, &s->groups[i], start);
    tell_all(w, s);
    if (touches_change(w, s))
        change_touches(w, s, start);
    for (int i = 0; i < s->count; i++) {
        if (s->groups[i].joint_count == 0)
            continue;
        joints_of(w, &s->groups[i]);
        break_joints(w, &s->groups[i], start);
    }
}
