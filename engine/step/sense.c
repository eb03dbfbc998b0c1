/* step/sense.c - whose boxes may meet in this step.
 *
 * Every awake solid gets a reach box: its bounds swept by its motion through
 * the step and grown by what a neighbour's blow could add. Leaves of the tree
 * hold fat boxes; only solids that left theirs ask the tree anew, and a pair
 * lives while the fat boxes overlap.
 */
#include "solve/plan.h"
#include "step/step.h"
#include "world/region.h"

#include <stdlib.h>

#define LEAF_STEPS 4            /* so far ahead a leaf is made to last                   */
#define LEAF_FAR   2            /* outer radii: but no farther than this                 */
#define LEAF_MARGIN 0.1         /* outer radii, on all sides                             */
#define OVERSIZED  2            /* of a fresh leaf: larger ones are made anew            */
#define OVERSIZED_RESTING 1.25  /* the same where the solid stays within that margin     */

static int compare_u32(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

/* Drops from the list who fell asleep or stands still; ascending, so that results do not depend on who woke first. */
static void tidy_awake(World *w)
{
    int n = 0;
    bool sorted = true;
    w->movers = 0;
    for (int i = 0; i < w->awake.count; i++) {
        uint32_t slot = w->awake.data[i];
        Body *b = &w->bodies.data[slot];
        bool keep = b->alive && ((b->kind == DIG_DYNAMIC && b->awake) || b->kind == DIG_KINEMATIC);
        if (!keep) {
            b->listed = b->paired = b->kept = false;
            continue;
        }
        w->movers += b->kind == DIG_KINEMATIC;
        sorted = sorted && (n == 0 || w->awake.data[n - 1] < slot);
        w->awake.data[n++] = slot;
    }
    w->awake.count = n;
    if (!sorted)
        qsort(w->awake.data, (size_t)n, sizeof *w->awake.data, compare_u32);
}

static real strongest_gravity(const World *w)
{
    real most = vec3_length(w->def.gravity);
    for (int i = 0; i < w->regions.count && w->region_count > 0; i++)
        if (w->regions.data[i].alive && vec3_finite(w->regions.data[i].laws.gravity))
            most = real_max(most, vec3_length(w->regions.data[i].laws.gravity));
    return most;
}

#define SHARED_LEAST 256         /* bodies: fewer are not worth a team */

static Team *team_for(const World *w) { return w->awake.count < SHARED_LEAST ? NULL : workers_team(w->workers); }

/* What acts from outside. Drags only slow, and are left out. */
static void find_pull(Body *b, real gravity)
{
    real pull = b->kind == DIG_DYNAMIC ? fabs(b->gravity_scale) * gravity / body_inertness(b) : 0;
    if (pull != b->pull)
        b->lies = -1;
    b->pull = pull;
}

/* Of what is pushed; that of others is found with their reach. */
static void find_pulls(World *w, real gravity)
{
    for (int i = 0; i < w->pushes.count; i++) {
        Body *b = &w->bodies.data[w->pushes.data[i].body];
        find_pull(b, gravity);
        b->pushed = b->listed;
    }
    for (int i = 0; i < w->pushes.count; i++) {
        const Push *p = &w->pushes.data[i];
        Body *b = &w->bodies.data[p->body];
        if (b->kind != DIG_DYNAMIC)
            continue;
        real force = vec3_length(p->force), torque = vec3_length(p->torque) + (p->has_at ? vec3_length(p->at) * force : 0);
        const mat3 *light = &body_inertia(b)->inverse;
        real turned = torque * b->outer * (light->r0.x + light->r1.y + light->r2.z);
        b->pull += (force * b->inv_mass + turned) / body_inertness(b);
        b->lies = -1;
    }
}

typedef struct Speed { real way, turn; } Speed;         /* m/s of its centre of mass, rad/s */

static Speed speed_of(const Body *b) { return (Speed){vec3_length(b->v), vec3_length(b->w)}; }

/* m/s  No place of its surface gets faster in the step, unless something strikes it. */
static real point_speed(const Body *b, Speed v, real dt) { return v.way + v.turn * b->rim + b->pull * dt; }

static inline box3 reach_of(const World *w, const Solid *s, const Body *b, Speed v, real dt)
{
    box3 box = s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s));
    if (b->kind == DIG_STATIC || (b->kind == DIG_DYNAMIC && !b->awake))
        return box;
    vec3 fall = vec3_scale(0.5 * dt * dt * b->gravity_scale, w->def.gravity);
    box = box3_swept(box, vec3_mad(b->kind == DIG_DYNAMIC ? fall : vec3_zero(), dt, b->v));
    real angle = real_min(2, v.turn * dt);
    real rim = s->form->shape.type == &shape_sphere ? 0 : s->form->shape.outer;         /* a ball gets nowhere by turning about its own centre */
    vec3 off = vec3_sub(s->form->at.p, b->centre);
    real arm = (vec3_is_zero(off) ? 0 : vec3_length(off)) + rim;
    return box3_grow(box, angle * arm + 0.02 * s->form->shape.outer + b->pull * dt * dt);
}

/* Who was listed lately brings its pairs along. */
static dig_status list_pairs(World *w, Body *b)
{
    b->paired = true;
    for (uint32_t s = b->shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
            if (!w->pairs.data[l / 2].listed) {
                DIG_TRY(list_reserve(&w->near, w->near.count + 1, &w->allocations));
                w->near.data[w->near.count++] = l / 2;
                w->pairs.data[l / 2].listed = true;
            }
    return DIG_OK;
}

/* m  How far beyond its reach the leaf of a solid is made to last: one of just its reach would be left in each step. */
static vec3 leaf_ahead(const Solid *s, const Body *b, real speed, real dt)
{
    real way = dt * speed, far = real_min(LEAF_STEPS * way, LEAF_FAR * s->form->shape.outer);
    return vec3_scale(way > 0 ? dt * real_max(1, far / way) : 0, b->v);
}

/* The box of its leaf in the tree, that lasts for some steps. */
static box3 leaf_of(const Solid *s, const Body *b, real dt)
{
    return box3_grow(box3_swept(s->reach, leaf_ahead(s, b, vec3_length(b->v), dt)), LEAF_MARGIN * s->form->shape.outer);
}

static real sum_of(vec3 v) { return fabs(v.x) + fabs(v.y) + fabs(v.z); }

/* Is it left over from faster days? Then it finds too many pairs. */
static bool oversized(box3 leaf, const Solid *s, const Body *b, real speed, real dt)
{
    real margin = LEAF_MARGIN * s->form->shape.outer, wide = sum_of(vec3_sub(leaf.high, leaf.low));
    real least = sum_of(vec3_sub(s->reach.high, s->reach.low)) + 6 * (margin + s->struck);     /* of one that does not move */
    if (wide <= OVERSIZED_RESTING * least)
        return false;
    real ahead = sum_of(leaf_ahead(s, b, speed, dt));
    return wide > (ahead < margin ? OVERSIZED_RESTING : OVERSIZED) * (least + ahead);
}

/* The tree of boxes must never see NaN or what overflows as an area. */
#define FARTHEST 1e100

static bool box_sane(box3 b) { return sum_of(b.low) + sum_of(b.high) < FARTHEST; }

static bool body_sane(const Body *b)
{
    return vec3_length2(b->x) < FARTHEST && vec3_length2(b->v) < FARTHEST && vec3_length2(b->w) < FARTHEST && quat_finite(b->q);
}

/* m  Where the solid may get in the step; returns whether its leaf in the tree is no longer right for that. */
static bool find_reach(World *w, Solid *s, const Body *b, Speed v, real dt)
{
    s->reach = reach_of(w, s, b, v, dt);
    if (s->astray > 0)
        s->reach = box3_grow(s->reach, s->astray);
    if (s->leaf < 0)
        return false;
    if (!box_sane(s->reach))        /* not by its motion so far: the step will find out what does it */
        s->reach = s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s));
    s->blow = 0;
    return !box3_inside(tree_box(&w->tree, s->leaf), s->reach) || oversized(tree_box(&w->tree, s->leaf), s, b, v.way, dt);
}

/* What there is to do about a body once its reach is known. */
enum { STRAYED = 1, FAST = 2, INSANE = 4, UNPAIRED = 8, LANDS = 16 };     /* LANDS: near a plane, of which there is no pair yet */

/* gravity: m/s^2, the strongest; found: [awake]; keeps: reaches may be those of an earlier step. */
typedef struct Sensing { World *w; real dt, gravity; bool keeps; uint8_t *found; } Sensing;

#define SLOW      0.02          /* outer radii: who gets farther in a step would not lie within the same bounds for long */
#define TOO_FAR   1e6           /* m: of who has travelled farther, a double forgets what it moves by */

/* m  So much each face of its reach may move until there may be something to do about the solid. */
static real room_of(const World *w, uint32_t solid, const Body *b, real dt)
{
    const Solid *s = &w->solids.data[solid];
    if (s->leaf < 0)
        return INFINITY;
    box3 leaf = tree_box(&w->tree, s->leaf);
    vec3 low = vec3_sub(s->reach.low, leaf.low), high = vec3_sub(leaf.high, s->reach.high), wide = vec3_sub(leaf.high, leaf.low);
    real least = vec3_least(vec3_min(low, high)), fresh = sum_of(vec3_sub(s->reach.high, s->reach.low)) + 6 * (LEAF_MARGIN * s->form->shape.outer + s->struck);
    least = real_min(least, (OVERSIZED_RESTING * fresh - sum_of(wide)) / (6 * OVERSIZED_RESTING));
    least = real_min(least, real_min(0.9 * s->form->shape.inner - b->pull * dt * dt, plane_room(w, solid)));
    return s->astray > 0 ? 0 : least - PLACE_ROUNDING * vec3_largest(vec3_max(vec3_abs(leaf.low), vec3_abs(leaf.high)));
}

real roams_until(real room, real travel, real roam) { return travel < TOO_FAR ? real_max(0, 0.999 * room + 2 * travel - roam) : 0; }

/* All that is to be known of a body; returns what there is to do. roam: m, see Body. */
static uint8_t sense_body(const Sensing *n, Body *b, Speed v, real roam)
{
    World *w = n->w;
    uint8_t found = 0;
    real far = point_speed(b, v, n->dt) * n->dt, room = n->keeps && roam - b->travel < SLOW * b->outer ? INFINITY : 0;
    bool astray = false;
    for (uint32_t k = b->shape_first; k != NONE; k = w->solids.data[k].next) {
        Solid *s = &w->solids.data[k];
        found |= (uint8_t)((find_reach(w, s, b, v, n->dt) ? STRAYED : 0) | (far > 0.9 * s->form->shape.inner ? FAST : 0) | (plane_new(w, k) ? LANDS : 0));
        astray = astray || s->astray > 0;
        if (s->form->shape.type->pieces)  /* its box is that of another box, turned, whose corners get farther than it does */
            room = 0;
        if (room > 0)
            room = real_min(room, room_of(w, k, b, n->dt));
    }
    b->roam = astray || b->lies < 0 ? INFINITY : roam;
    b->lies = b->lies < 0 ? -1 : found || astray || !(room > 0) ? 0 : roams_until(room, b->travel, roam);
    return found;
}

INLINE void sense_share(void *context, int thread, int threads)
{
    const Sensing *n = context;
    World *w = n->w;
    for (int i = team_first(w->awake.count, thread, threads), end = team_end(w->awake.count, thread, threads); i < end; i++) {
        Body *b = &w->bodies.data[w->awake.data[i]];
        if (i + FETCH_AHEAD < w->awake.count)
            fetch_soon(&w->bodies.data[w->awake.data[i + FETCH_AHEAD]], offsetof(Body, inertia));
        uint8_t found = (uint8_t)((b->paired ? 0 : UNPAIRED) | (body_sane(b) ? 0 : INSANE));
        if (!b->pushed)
            find_pull(b, n->gravity);
        b->pushed = false;
        Speed v = speed_of(b);
        real roam = b->travel + n->dt * (v.way + v.turn * b->outer);
        b->alone = false;
        b->kept = n->keeps && roam < b->lies && !(found & INSANE);
        if (b->kept)
            b->roam = roam;
        else if (!(found & INSANE))
            found |= sense_body(n, b, v, roam);
        n->found[i] = found;
    }
}

static dig_status insane(World *w, const Body *b)
{
    w->culprit = body_handle(w, (uint32_t)(b - w->bodies.data));
    w->stats.rejected++;
    return world_fail(w, DIG_E_FINITE, "at t = %g s the state of %s has a non-finite position or velocity", world_time(w), BODY_TEXT(w, b));
}

/* Gives the leaves that have been left new boxes, with which they will ask who is near. */
static void move_leaves(World *w, const Body *b, real dt)
{
    real speed = vec3_length(b->v);
    for (uint32_t i = b->shape_first; i != NONE; i = w->solids.data[i].next) {
        Solid *s = &w->solids.data[i];
        if (s->leaf < 0 || (box3_inside(tree_box(&w->tree, s->leaf), s->reach) && !oversized(tree_box(&w->tree, s->leaf), s, b, speed, dt)))
            continue;
        tree_move(&w->tree, s->leaf, leaf_of(s, b, dt));
        s->struck = 0;
        solid_ask(w, i);
    }
}

box3 solid_reach(const World *w, const Solid *s)
{
    const Body *b = s->body == NONE ? NULL : &w->bodies.data[s->body];
    return b && b->kept ? reach_of(w, s, b, speed_of(b), w->def.step) : s->reach;
}

/* Reaches that are made longer in this step are first made those of this step. */
static void end_keeping(World *w, Body *b)
{
    for (uint32_t i = b->kept ? b->shape_first : NONE; i != NONE; i = w->solids.data[i].next)
        w->solids.data[i].reach = solid_reach(w, &w->solids.data[i]);
    b->kept = false;
    b->lies = 0;
    b->roam = INFINITY;
}

/* Lets a solid reach `far` farther in this step, in any direction; once, by the largest. A blow by a mover, or on one, could come in each of
 * the next steps as well: its leaf is made to last. */
static void grow_reach(World *w, uint32_t solid, real far, bool mover, real dt)
{
    Solid *s = &w->solids.data[solid];
    if (far <= s->blow)
        return;
    end_keeping(w, &w->bodies.data[s->body]);
    s->reach = box3_grow(s->reach, far - s->blow);
    s->blow = far;
    if (s->leaf < 0 || box3_inside(tree_box(&w->tree, s->leaf), s->reach))
        return;
    s->struck = mover ? far : 0;
    tree_move(&w->tree, s->leaf, mover ? leaf_of(s, &w->bodies.data[s->body], dt) : s->reach);
    solid_ask(w, solid);
}

/* 1  Of the speed at which something strikes a body, how much that gets at the place of the blow where nothing bounces: far from the
 * centre of mass, as at the end of a rod, a body is as light as a quarter of it. A measure, not a bound: what is struck off its centre may
 * be faster elsewhere. Groups that follow their blows find such a one afterwards (stray.c); others a step later. */
static real handed_on(const Body *striker, const Body *struck)
{
    return striker->kind == DIG_DYNAMIC ? striker->mass / (striker->mass + 0.25 * struck->mass) : 1;
}

/* What strikes fast enough to pass through something before the next step may bounce: it then ends on a sphere through where it would
 * have been, for what is plastic half as wide as its way, and for what is elastic as wide. And it hands on what it strikes with. Only
 * the speed against the other counts: a swarm that falls together strikes nothing. */
static void spread_from(World *w, uint32_t solid, const Body *striker, real dt)
{
    for (uint32_t l = w->solids.data[solid].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
        const Pair *p = &w->pairs.data[l / 2];
        uint32_t other = l % 2 ? p->solid_a : p->solid_b;
        const Solid *s = &w->solids.data[solid], *o = &w->solids.data[other];
        const Body *b = o->body == NONE ? NULL : &w->bodies.data[o->body];
        bool dynamic = b && b->kind == DIG_DYNAMIC && b->awake;
        vec3 speed = b ? vec3_sub(striker->v, b->v) : striker->v;
        real far = dt * (vec3_length(speed) + vec3_length(striker->w) * striker->rim + striker->pull * dt);
        if (far <= 0.9 * s->form->shape.inner || (o->leaf >= 0 && !box3_overlap(solid_reach(w, s), dynamic ? solid_reach(w, o) : tree_box(&w->tree, o->leaf))))
            continue;
        bool mover = striker->kind == DIG_KINEMATIC || (b && b->kind == DIG_KINEMATIC);
        real back = 1 + pair_rub(w, p).restitution;
        grow_reach(w, solid, 0.5 * back * (far + (b ? dt * vec3_length(b->v) : 0)), mover, dt);
        if (dynamic)
            grow_reach(w, other, back * handed_on(striker, b) * far, mover, dt);
    }
}

/* Are there only things that never move in its reach? Then its group is itself, its blows are followed in time, and should one send it where
 * nobody looked, the step is done again (stray.c): a hundred bullets on one wall need not be looked at together. Where small groups are
 * crowds as well, nobody follows it. */
static bool flies_alone(const World *w, const Body *b, uint32_t slot)
{
    if (b->kind != DIG_DYNAMIC || b->joint_first != NONE || graph_fellows(w->graph, graph_lead(w->graph, slot)) != 1 ||
        w->debt.pause > 0 || w->awake.count + w->near.count > accuracy_plan(w->accuracy)->crowd_total)
        return false;
    for (uint32_t i = b->shape_first; i != NONE; i = w->solids.data[i].next) {
        const Solid *s = &w->solids.data[i];
        for (uint32_t l = s->pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            const Solid *o = &w->solids.data[l % 2 ? p->solid_a : p->solid_b];
            bool stands = o->body == NONE || w->bodies.data[o->body].kind == DIG_STATIC;
            if (!stands && box3_overlap(s->reach, o->leaf >= 0 && !w->bodies.data[o->body].listed ? tree_box(&w->tree, o->leaf) : solid_reach(w, o)))
                return false;
        }
    }
    return true;
}

static void spread_speed(World *w, uint32_t slot, real dt)
{
    w->bodies.data[slot].alone = flies_alone(w, &w->bodies.data[slot], slot);
    if (w->bodies.data[slot].alone)
        return;
    real far = dt * point_speed(&w->bodies.data[slot], speed_of(&w->bodies.data[slot]), dt);
    for (uint32_t s = w->bodies.data[slot].shape_first; s != NONE; s = w->solids.data[s].next)
        if (far > 0.9 * w->solids.data[s].form->shape.inner)
            spread_from(w, s, &w->bodies.data[slot], dt);
}

static void wake_if_near(World *w, uint32_t solid, uint32_t other)
{
    const Solid *s = &w->solids.data[solid], *o = &w->solids.data[other];
    if (!o->alive || o->leaf < 0 || o->body == NONE || w->bodies.data[o->body].kind != DIG_DYNAMIC || w->bodies.data[o->body].awake)
        return;
    box3 box = o->form->shape.type->bounds(&o->form->shape, solid_pose(w, o));
    if (s->leaf < 0 ? plane_near(w, solid, box) && bodies_may_touch(w, s, o)
                    : box3_overlap(s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s)), box))
        body_wake(w, o->body);
}

/* What cannot be pushed, and was put where it is by hand, wakes the sleepers it was put into: no impulse would tell them. */
static void wake_near(World *w, uint32_t solid)
{
    const Solid *s = &w->solids.data[solid];
    if (s->body == NONE || w->bodies.data[s->body].kind == DIG_DYNAMIC || !w->bodies.data[s->body].collides)
        return;
    if (!isfinite(s->form->shape.outer))
        for (int i = 0; i < w->solids.count; i++)
            wake_if_near(w, solid, (uint32_t)i);
    for (uint32_t l = s->pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2])
        wake_if_near(w, solid, l % 2 ? w->pairs.data[l / 2].solid_a : w->pairs.data[l / 2].solid_b);
}

/* All reaches first, for they need nobody else; then what changes the tree, in order; then all that were moved ask who is near, and those that
 * blows may throw farther do so again. */
static dig_status sense_bodies(World *w, real dt, bool keeps)
{
    int count = w->awake.count;
    if (count == 0)
        return ask_all(w);
    Sensing n = {w, dt, strongest_gravity(w), keeps, arena_alloc(&w->scratch, (size_t)count)};
    if (!n.found)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for %d bodies", count);
    find_pulls(w, n.gravity);
    team_deal(team_for(w), sense_share, &n);
    uint8_t any = 0;
    for (int i = 0; i < count; i++)
        any |= n.found[i];
    for (int i = 0; i < count && any & (UNPAIRED | INSANE); i++) {
        Body *b = &w->bodies.data[w->awake.data[i]];
        if (n.found[i] & UNPAIRED)
            DIG_TRY(list_pairs(w, b));
        if (n.found[i] & INSANE)
            return insane(w, b);
    }
    for (int i = 0; i < count && any & STRAYED; i++)
        if (n.found[i] & STRAYED)
            move_leaves(w, &w->bodies.data[w->awake.data[i]], dt);
    DIG_TRY(ask_all(w));
    for (int i = 0; i < count && any & LANDS; i++)
        for (uint32_t s = n.found[i] & LANDS ? w->bodies.data[w->awake.data[i]].shape_first : NONE; s != NONE; s = w->solids.data[s].next)
            DIG_TRY(ask_planes(w, s));
    for (int i = 0; i < count && any & FAST; i++)
        if (n.found[i] & FAST)
            spread_speed(w, w->awake.data[i], dt);
    return ask_all(w);
}

/* Who is new or was moved by hand; planes: is one of them one? Where memory runs out, all are asked again in the next try. */
static dig_status ask_moved(World *w, bool *planes)
{
    int count = w->asking.count;
    uint32_t *moved = arena_alloc(&w->scratch, (size_t)count * sizeof *moved);
    if (!moved)
        return DIG_E_MEMORY;
    memcpy(moved, w->asking.data, (size_t)count * sizeof *moved);
    for (int i = 0; i < count; i++) {
        Solid *s = &w->solids.data[moved[i]];
        s->reach = s->leaf >= 0 ? tree_box(&w->tree, s->leaf) : s->reach;
        if (s->body != NONE) {
            w->bodies.data[s->body].kept = false;
            w->bodies.data[s->body].lies = -1;
        }
        *planes = *planes || !isfinite(s->form->shape.outer);
    }
    DIG_TRY(ask_all(w));
    for (int i = 0; i < count; i++)
        wake_near(w, moved[i]);
    return DIG_OK;
}

dig_status sense_pairs(World *w, real dt)
{
    bool planes = false;
    DIG_TRY(world_compact(w));
    tidy_awake(w);
    if (w->asking.count > 0) {
        DIG_TRY(ask_moved(w, &planes));
        tidy_awake(w);                  /* who was woken just now has its place in the order */
    }
    return sense_bodies(w, dt, w->movers == 0 && !planes);
}
