/* effect/contact.c - bodies do not pass through each other: one row per contact point,
 *
 *     relative normal velocity >= target,   impulse >= 0.
 *
 * Where impacts are located in time, a point that would strike faster than the
 * closing speed gets no row: the substep is cut at its impact instead. Where
 * they are not (large groups, or the step's events are used up), the point
 * bounces in the substep in which the gap closes (solve/sweep.c).
 */
#include "effect/effect.h"
#include "solve/direction.h"

static bool wanted(const World *w, const Group *g)
{
    (void)w;
    return g->pair_count > 0;
}

static int members(const Group *g) { return g->live_count; }

static EffectCause cause(const Group *g) { return effect_cause_pair(g, &g->pairs[0]); }

/* Normal velocity before the substep's forces. */
static real rate_before(const Group *g, const PointRow *r)
{
    const Member *a = &g->member[r->a], *b = &g->member[r->b];
    Vel va = a->moves ? g->start_vel[r->a] : g->vel[r->a], vb = b->moves ? g->start_vel[r->b] : g->vel[r->b];
    return vec3_dot(r->n.n, vec3_sub(vb.v, va.v)) + vec3_dot(r->n.aa, va.w) + vec3_dot(r->n.ab, vb.w);
}

#define SLIVER 1e-4             /* of a step: a substep so short is what blows or rounding have left of one */
#define ABOVE  1e6              /* times the fastest: so fast is nothing, and digits enough are left beside it */

/* m/s  What a gap may close with at most. In a sliver of a substep that would be any speed, and all digits of a solve would go into it. */
static real closes_by(const Group *g, real size, real gap)
{
    if (!(g->h < SLIVER * g->world->def.step))
        return gap / g->h;
    real fastest = size;                                    /* in a second */
    for (int i = 0; i < g->body_count; i++) {
        real spin = vec3_length(g->vel[i].w);               /* of 0 about what is infinite: no number */
        fastest = real_max(fastest, vec3_length(g->vel[i].v) + (spin > 0 ? spin * g->member[i].outer : 0));
    }
    return real_min(gap / g->h, ABOVE * fastest);
}

/* Does the point need a row, and what velocity may it keep? *left: it has none because its approach is an impact. A point that
 * carried force before keeps its row: a ball that rolls over an edge seems to leave, while its normal turns. */
static bool set_target(const Group *g, const GroupPair *q, PointRow *r, real gap, bool carried, bool *left)
{
    real predicted = dir_rate(g, &r->n, r->a, r->b);
    r->rate_before = rate_before(g, r);
    if (gap <= g->touch * q->size) {
        if (g->locate && g->events_left > 0 && !carried && r->rate_before > g->close_speed && gap > -g->touch * q->size)
            return false;               /* it bounced off: should it come back in this substep, that is an impact */
        r->target = gap > 0 ? -closes_by(g, q->size, gap) : -squeeze_of(g, r->contact).rate;
    } else {
        if (!carried && !q->meets && gap + g->h * real_min(predicted, 0) > 0.5 * gap + 1e-3 * q->size)
            return false;               /* not this substep */
        real closing = real_max(0, r->rate_before - predicted) / g->h;      /* m/s^2 */
        real strike = sqrt(r->rate_before * r->rate_before + 2 * closing * gap);
        real plastic = carried ? real_max(g->close_speed, gentle_speed_of(q->size, vec3_length(g->gravity))) : locate_least(g, q);
        *left = g->locate && g->events_left > 0 && strike > plastic;
        if (*left)
            return false;               /* it will be located */
        r->target = -closes_by(g, q->size, gap);
    }
    r->bounce = g->locate && g->events_left > 0 ? 0 : q->rub->restitution;
    return true;
}

static Vel start_velocity(const Group *g, int body) { return g->member[body].moves ? g->start_vel[body] : g->vel[body]; }

/* Where a body will be half a substep on, along its start velocity. */
static Pos half_way(const Group *g, int body)
{
    Vel v = start_velocity(g, body);
    return (Pos){vec3_mad(g->pos[body].x, 0.5 * g->h, v.v), quat_unit(quat_mul(quat_exp(vec3_scale(0.5 * g->h, v.w)), g->pos[body].q))};
}

typedef struct Middle { bool known, found; Pos a, b; Manifold m; } Middle;        /* of a contact: half a substep on */

#define ASIDE 0.01              /* of its radius */
#define SWUNG 0.01              /* rad  in a substep: what turns by less loses or gains next to nothing */

/* A ball beside the centre of mass of its body turns about that, and the place where it touches with it, be the other flat. */
static bool swings_round(const Group *g, int body, const Form *f)
{
    bool aside = f->shape.type == &shape_sphere && vec3_length(f->arm) > ASIDE * f->shape.outer;
    return aside && g->h * vec3_length(start_velocity(g, body).w) > SWUNG;
}

static void find_middle(const Group *g, const GroupPair *q, const GroupContact *c, Middle *mid)
{
    Vel va = start_velocity(g, c->a), vb = start_velocity(g, c->b);
    real far = g->h * (vec3_length(vec3_sub(vb.v, va.v)) + vec3_length(vb.w) * q->size + vec3_length(va.w) * q->size);
    *mid = (Middle){.known = true};
    if (far < 1e-5 * q->size)
        return;
    mid->a = half_way(g, c->a);
    mid->b = half_way(g, c->b);
    pose la = pair_local(q, false), lb = pair_local(q, true);
    pose pa = {vec3_add(mid->a.x, quat_rotate(mid->a.q, la.p)), quat_mul(mid->a.q, la.q)};
    pose pb = {vec3_add(mid->b.x, quat_rotate(mid->b.q, lb.p)), quat_mul(mid->b.q, lb.q)};
    uint32_t piece;
    ManifoldCache cache = q->hint ? *q->hint : (ManifoldCache){.kind = 0};
    if (manifold_collide(&q->on_a->shape, pa, &q->on_b->shape, pb, far, &cache, &mid->m, &piece, 1) != 1 || mid->m.count != c->manifold.count)
        return;
    real same = vec3_dot(mid->m.normal, c->manifold.normal);
    if ((same > 1 - 1e-14 && !swings_round(g, c->a, q->on_a) && !swings_round(g, c->b, q->on_b)) || same < 0.5)
        return;                             /* flat, or another side altogether */
    mid->found = !seam_hides(g, q, pa, pb, &mid->m);
}

/* Where the normal turns as things roll (over an edge, over a ball, in a bowl, barrel on barrel) the row is taken in the middle of the
 * substep and holds for the mean velocity, as joints do: with J at the middle and v0 the start velocity, J (v0 + v1) / 2 >= 0, less
 * what v0 already breaks at the start, which is to decay. A line that parts is not held to part on, which would be work. */
static void follow_curve(const Group *g, const GroupPair *q, Middle *mid, PointRow *r, real gap)
{
    const GroupContact *c = &g->contacts[r->contact];
    const ManifoldPoint *p = mid->m.points;
    if (!mid->known)
        find_middle(g, q, c, mid);
    if (!mid->found)
        return;
    for (int k = 0; k < mid->m.count && mid->m.count > 1; k++)
        if (mid->m.points[k].feature == c->manifold.points[r->point].feature)
            p = &mid->m.points[k];
    PointRow middle = *r;
    point_row_set(g, &middle, mid->m.normal, vec3_scale(0.5, vec3_add(p->a, p->b)), mid->a.x, mid->b.x);
    real room = -2 * real_max(gap, 0) / g->h, kept = mid->m.count > 1 ? real_min(real_min(r->rate_before, 0), room) : r->rate_before + room;
    middle.target = kept - rate_before(g, &middle);
    middle.curved = true;
    *r = middle;
}

/* Parts of one thing, joined by others of it. */
static bool of_one_thing(const Group *g, const GroupPair *q) { return g->things && g->things->whole[q->a] == g->things->whole[q->b]; }

#define TURNS 1e-5              /* rad  in a substep: what turns by less lies there */

/* What turns with both its bodies, which welds hold against each other, is taken where joints are that are solved with it: in the middle of
 * the substep. At its start it would contradict them, and both would push without end, along arms that are not the same. What the turn
 * opens of the welds, by its square, it is to let them close. */
static void turn_along(const Group *g, PointRow *r)
{
    const GroupContact *c = &g->contacts[r->contact];
    const ManifoldPoint *p = &c->manifold.points[r->point];
    real angle = g->h * vec3_length(start_velocity(g, r->a).w);
    if (angle < TURNS)
        return;
    Pos a = half_way(g, r->a), b = half_way(g, r->b);
    quat turn = quat_mul(a.q, quat_conjugate(g->pos[r->a].q));
    vec3 at = vec3_scale(0.5, vec3_add(p->a, p->b));
    point_row_set(g, r, quat_rotate(turn, c->manifold.normal), vec3_add(a.x, quat_rotate(turn, vec3_sub(at, g->pos[r->a].x))), a.x, b.x);
    r->target = real_min(r->target, 0) - angle * angle * vec3_distance(a.x, b.x) / g->h;
    r->bounce = 0;
    r->curved = true;
}

/* It carries, or has just come to lie: what blows have stopped remembers no force yet, and may roll round an edge all the same. Its turning
 * normal would be taken for the next blow, and so on in each substep. */
static bool lies(const Group *g, const GroupPair *q, const PointRow *r, real gap, bool carried)
{
    return carried || (gap <= g->touch * q->size && fabs(r->rate_before) <= g->close_speed);
}

#define SMOOTH 1e-3             /* of what weight gives in a substep */

/* A point; or an end of the line along which something round lies, where it neither parts nor comes: a line that has been struck would, by
 * rows for the mean velocity, swing to and fro, sink in and be lifted. */
static bool has_curve(const Group *g, const GroupPair *q, const PointRow *r, int count)
{
    const ShapeType *a = q->on_a->shape.type, *b = q->on_b->shape.type;
    bool round = a == &shape_cylinder || a == &shape_capsule || b == &shape_cylinder || b == &shape_capsule;
    return count == 1 || (count == 2 && round && fabs(r->rate_before) <= SMOOTH * g->fall * g->h);
}

static void warm(const Group *g, PointRow *r, const PointMemory *m)
{
    r->jn = m->normal * g->h;
    r->jt[0] = g->h * vec3_dot(m->tangent, r->t[0].n);
    r->jt[1] = g->h * vec3_dot(m->tangent, r->t[1].n);
}

static dig_status rows(const EffectSlot *e, Group *g)
{
    (void)e;
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        GroupPair *q = &g->pairs[c->pair];
        if (!c->live || (!g->member[c->a].moves && !g->member[c->b].moves))
            continue;
        Middle mid = {.known = false};
        PointRow *made = &g->points[g->point_count];
        contact_rows_make(g, made, i);
        c->manifold.left = 0;
        for (int k = 0; k < c->manifold.count; k++) {
            PointRow *r = &g->points[g->point_count];
            bool left = false;
            if (r != &made[k])
                *r = made[k];
            real gap = c->manifold.points[k].gap;
            bool carried = contact_memory(c)[k].held > 0, needed = set_target(g, q, r, gap, carried, &left);
            c->manifold.left |= (uint8_t)(left << k);
            if (!needed)
                continue;
            if (g->joints_direct && of_one_thing(g, q))
                turn_along(g, r);
            else if (g->locate && q->contacts == 1 && has_curve(g, q, r, c->manifold.count) && lies(g, q, r, gap, carried))
                follow_curve(g, q, &mid, r, gap);
            warm(g, r, &contact_memory(c)[k]);
            pair_approaches(q, -r->rate_before);
            g->point_count++;
        }
    }
    return DIG_OK;
}

const EffectType effect_contact = {
    .name = "contact",
    .law = "gap >= 0, normal force >= 0, gap * force = 0; v+ = -e v- at impacts",
    .central = true,
    .cite = "stewart1996",
    .wanted = wanted,
    .stands = LAW_CONTACT,
    .members = members,
    .cause = cause,
    .run = {[STAGE_ROWS] = rows},
};
