/* solve/locate.c - when, within this substep, does something strike?
 *
 * Looks along the motion that the substep would make. Pairs that are apart are
 * followed by conservative advancement; of pairs that already touch at some
 * point, the other points are followed one by one.
 */
#include "solve/direction.h"

/* How a body moves through the substep, without where from. */
static Motion body_motion(const Group *g, int body)
{
    const Member *m = &g->member[body];
    Motion r = {.start = {.p = vec3_zero()}};
    Vel now = g->vel[body];
    if (!m->moves) {
        r.v = now.v;
        r.w = now.w;
        return r;
    }
    Vel old = g->start_vel[body];
    r.w = vec3_scale(0.5, vec3_add(old.w, now.w));
    if (m->constrained) {
        const Vel way = group_way_of(g, body);
        r.v = way.v;
        r.w = way.w;
    } else {
        r.v = old.v;
        r.a = vec3_scale(1 / g->h, vec3_sub(now.v, old.v));
    }
    return r;
}

/* The same, from where a shape of it is. */
static Motion motion_of(const Group *g, int body, pose local, Motion r)
{
    r.start = group_shape_pose(g, body, local);
    r.centre = pose_unpoint(local, vec3_zero());
    return r;
}

static Motion shape_motion(const Group *g, int body, pose local) { return motion_of(g, body, local, body_motion(g, body)); }

/* m  The farthest that a point of a shape moves by its turn. */
static real rim_travel(const Group *g, int body, const Motion *m)
{
    real turn = g->h * vec3_length(m->w);
    return turn > 0 ? 2 * g->member[body].rim * real_min(1, 0.5 * turn) : 0;
}

/* m  How far healing has moved the points of a body since its contacts were found. */
static real healed_by(const Group *g, int body)
{
    const Member *m = &g->member[body];
    if (!m->moves)
        return 0;
    quat turn = quat_mul(g->pos[body].q, quat_conjugate(g->start_pos[body].q));
    return vec3_distance(g->pos[body].x, g->start_pos[body].x) + 2 * m->rim * vec3_length((vec3){turn.x, turn.y, turn.z});
}

/* Does some point touch? */
static bool is_touching(const Group *g, const GroupPair *q)
{
    bool touching = false;
    for (int k = q->contact; k < q->contact + q->contacts; k++)
        for (int p = 0; g->contacts[k].live && p < g->contacts[k].manifold.count; p++)
            touching = touching || g->contacts[k].manifold.points[p].gap <= g->touch * q->size;
    return touching;
}

/* Each blow that is located costs many as much as a substep does. What lands gently and does not bounce, rows stop as well where it lands: they take
 * the same from it, by less than a substep too early. Each of 60 dominoes that fell rattled those that lay before it, 30 times a frame. What is gentle
 * for something heavy is not for what is light below it. */
real locate_least(const Group *g, const GroupPair *q)
{
    if (!g->gentle)
        return g->close_speed;
    real e = q->rub->restitution, gentle = gentle_speed_of(q->size, g->fall);
    return real_max(g->close_speed, e * gentle > g->close_speed ? g->close_speed / e : gentle);
}

void locate_look(Group *g, real time)
{
    for (int i = 0; i < g->pair_count; i++) {
        GroupPair *q = &g->pairs[i];
        if (q->reach == 0 && q->contacts == 1 && (g->member[q->a].moves || g->member[q->b].moves) && !is_touching(g, q))
            group_touch_pair(g, q, time);
    }
}

/* m  How far points of a pair may move against each other in this substep. */
static real most_travel(const Group *g, const GroupPair *q, const Motion *a, const Motion *b)
{
    real h = g->h;
    vec3 v = vec3_sub(b->v, a->v), acc = vec3_sub(b->a, a->a);
    return vec3_length(v) * h + 0.5 * vec3_length(acc) * h * h + rim_travel(g, q->a, a) + rim_travel(g, q->b, b);
}

/* What had no contact is farther apart than that looked for; and balls around the shapes say more of what is far. */
static bool cannot_meet(const Group *g, const GroupPair *q, const Motion *a, const Motion *b)
{
    real travel = most_travel(g, q, a, b);
    if (q->contacts == 1 && g->contacts[q->contact].manifold.count == 0 && !seam_near(g, q) &&
        travel + healed_by(g, q->a) + healed_by(g, q->b) < q->reach)
        return true;
    if (!isfinite(q->on_a->shape.outer) || !isfinite(q->on_b->shape.outer))
        return false;
    return vec3_distance(a->start.p, b->start.p) - q->on_a->shape.outer - q->on_b->shape.outer > travel;
}

static real meeting(const Group *g, const GroupPair *q, const Motion *a, const Motion *b, real time)
{
    real t = time_of_impact(&q->on_a->shape, a, &q->on_b->shape, b, 0.25 * g->touch * q->size, time, NULL);
    if (!(t <= time))
        return INFINITY;
    vec3 n, pa, pb;
    real gap = shape_distance(&q->on_a->shape, motion_at(a, t), &q->on_b->shape, motion_at(b, t), INFINITY, &n, &pa, &pb);
    if (manifold_covered(&q->on_a->shape, motion_at(a, t), &q->on_b->shape, motion_at(b, t), q->covered, n))
        return INFINITY;
    Manifold there = {.normal = n, .count = 1, .points = {{.a = pa, .b = pb, .gap = gap}}};
    if (seam_hides(g, q, motion_at(a, t), motion_at(b, t), &there))
        return INFINITY;
    real speed = -vec3_dot(n, vec3_sub(motion_velocity(b, pb, t), motion_velocity(a, pa, t)));
    if (!(speed > locate_least(g, q)))
        return INFINITY;
    return gap > 0 ? t + gap / speed : t;       /* Newton's last step: from the tolerance to the rounding error */
}

/* Where two shapes move, with their centres of mass at the start. */
typedef struct Meeting { Motion a, b; vec3 centre_a, centre_b; } Meeting;

static Meeting meeting_of(const Group *g, const GroupPair *q)
{
    Meeting m = {.a = shape_motion(g, q->a, pair_local(q, false)), .b = shape_motion(g, q->b, pair_local(q, true))};
    m.centre_a = pose_point(m.a.start, m.a.centre);
    m.centre_b = pose_point(m.b.start, m.b.centre);
    return m;
}

/* m/s  How fast a point parts along n, at first. */
static real parts_with(const Meeting *m, vec3 n, const ManifoldPoint *p)
{
    vec3 va = vec3_add(m->a.v, vec3_cross(m->a.w, vec3_sub(p->a, m->centre_a)));
    return vec3_dot(n, vec3_sub(vec3_add(m->b.v, vec3_cross(m->b.w, vec3_sub(p->b, m->centre_b))), va));
}

/* Points of a pair that touches already: their gaps as parabolas of time. */
static real locate_points(const Group *g, const GroupPair *q, const Meeting *m, real tolerance)
{
    real first = INFINITY;
    for (int i = q->contact; i < q->contact + q->contacts; i++) {
        const GroupContact *c = &g->contacts[i];
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            const ManifoldPoint *p = &c->manifold.points[k];
            vec3 n = c->manifold.normal;
            real v0 = parts_with(m, n, p), acc = vec3_dot(n, vec3_sub(m->b.a, m->a.a));
            if (p->gap <= tolerance) {
                if (v0 > g->close_speed && -2 * v0 >= acc * g->h)       /* leaves and comes back */
                    first = real_min(first, -2 * v0 / acc);
                continue;
            }
            /* gap + v0 t + acc t^2 / 2 = 0, the root without cancellation */
            real d = v0 * v0 - 2 * acc * p->gap;
            if (!(d > 0) || !(sqrt(d) > (c->manifold.left >> k & 1 ? 0 : locate_least(g, q))))
                continue;
            real t = 2 * p->gap / (sqrt(d) - v0);
            if (t > 0 && t <= g->h)
                first = real_min(first, t);
        }
    }
    return first;
}

/* m/s^2  By how much more a point parts each second, for what turns carries it round its centre. */
static real parts_more(const GroupPair *q, const Meeting *m, vec3 n, const ManifoldPoint *p)
{
    vec3 a = vec3_add(m->a.a, motion_sway(&q->on_a->shape, &m->a, p->a, n));
    vec3 b = vec3_add(m->b.a, motion_sway(&q->on_b->shape, &m->b, p->b, vec3_neg(n)));
    return vec3_dot(n, vec3_sub(b, a));
}

/* s  When a point that touches has parted that far. What a blow has left at rest there is carried off by its turn. INFINITY: it presses on. */
static real off_at(const Group *g, const GroupPair *q, const Meeting *m, vec3 n, const ManifoldPoint *p, real off, real tolerance)
{
    real speed = parts_with(m, n, p), way = off - p->gap, bend = real_max(0, parts_more(q, m, n, p));
    if (speed > g->close_speed && speed * speed > 2 * bend * way)
        return way / speed;
    if (!(bend > 0) || (speed < 0 && speed * speed > 2 * bend * tolerance))
        return INFINITY;
    return 2 * way / (speed + sqrt(speed * speed + 2 * bend * way));
}

/* s  When all points that touch have parted, by as much as the two are thick in this substep: what whirls may then come in with its other
 * end, of which they know nothing. INFINITY: some point presses on, or the two are slow. */
static real parted_at(const Group *g, const GroupPair *q, const Meeting *m, real tolerance)
{
    real travel = vec3_distance(m->a.v, m->b.v) * g->h + rim_travel(g, q->a, &m->a) + rim_travel(g, q->b, &m->b), last = 0;
    if (!(travel > q->on_a->shape.inner + q->on_b->shape.inner))
        return INFINITY;
    for (int i = q->contact; i < q->contact + q->contacts; i++) {
        const GroupContact *c = &g->contacts[i];
        for (int k = 0; c->live && k < c->manifold.count; k++) {
            const ManifoldPoint *p = &c->manifold.points[k];
            if (p->gap <= tolerance)
                last = real_max(last, off_at(g, q, m, c->manifold.normal, p, 2 * tolerance, tolerance));
        }
    }
    return last;
}

static real locate_other_end(const Group *g, const GroupPair *q, const Meeting *m, real tolerance)
{
    real from = parted_at(g, q, m, tolerance);
    if (!(from < g->h))
        return INFINITY;
    Motion a = motion_from(&m->a, from), b = motion_from(&m->b, from);
    return from + meeting(g, q, &a, &b, g->h - from);
}

static real locate_apart(const Group *g, const GroupPair *q, const Meeting *m)
{
    return cannot_meet(g, q, &m->a, &m->b) ? INFINITY : meeting(g, q, &m->a, &m->b, g->h);
}

/* Points that pressed before lie on each other while one of their contact still does after the solve, though rows that hold for a substep let a gap
 * of h^2 grow where bodies turn: they close slower than a blow. */
static bool lies_on(const Group *g, const PointRow *r)
{
    const GroupContact *c = &g->contacts[r->contact];
    return contact_memory(c)[r->point].held > 0 && c->manifold.points[r->point].gap < g->close_speed * g->h;
}

static void mark_pressed(Group *g)
{
    for (int i = 0; i < g->pair_count; i++)
        g->pairs[i].presses = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < g->point_count; i++) {
            const PointRow *r = &g->points[i];
            GroupPair *q = &g->pairs[g->contacts[r->contact].pair];
            if ((pass == 0 ? r->jn > 0 : q->presses != 0) && lies_on(g, r))
                q->presses |= (uint8_t)(1 << r->point);
        }
}

/* m  By how much the turn of a body bends the way of a point in this substep. */
static real bent(const Group *g, int body, const Motion *m)
{
    real turn = 0.5 * g->h * g->h * vec3_length2(m->w);
    return turn > 0 ? turn * g->member[body].rim : 0;
}

/* Does it press, and stay open where it does not, so that nobody need follow it? What is no point of the contact is farther than that looked for. */
static bool presses_on(const Group *g, const GroupPair *q, const Meeting *m)
{
    const GroupManifold *known = &g->contacts[q->contact].manifold;
    real healed = healed_by(g, q->a) + healed_by(g, q->b), off = bent(g, q->a, &m->a) + bent(g, q->b, &m->b) + healed;
    if (!q->presses || q->contacts != 1 || !(most_travel(g, q, &m->a, &m->b) + healed < q->reach))
        return false;
    for (int k = 0; k < known->count; k++)
        if (!(q->presses >> k & 1) && !(known->points[k].gap + g->h * parts_with(m, known->normal, &known->points[k]) > off))
            return false;
    return true;
}

real locate_impact(Group *g)
{
    real first = INFINITY;
    mark_pressed(g);
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        const Member *ma = &g->member[q->a], *mb = &g->member[q->b];
        if ((!ma->moves && !mb->moves) || is_squeezed(g, q->contact))
            continue;
        real tolerance = g->touch * q->size;
        Meeting m = meeting_of(g, q);
        if (!is_touching(g, q)) {
            first = real_min(first, presses_on(g, q, &m) ? INFINITY : locate_apart(g, q, &m));
            continue;
        }
        first = real_min(first, locate_points(g, q, &m, tolerance));
        first = real_min(first, locate_other_end(g, q, &m, tolerance));
    }
    return first;
}

/* Share of the smaller size that a pair may sink into each other in one substep. With four times as much, barrels of 0.3 m that come down
 * rim first overlapped by 5 mm in 8 of 24 starts; it costs no more. */
#define SINK_MOST 0.005

/* m  Negative: they are apart. */
static real depth_at(const GroupPair *q, const Motion *a, const Motion *b, real t)
{
    return -shape_distance(&q->on_a->shape, motion_at(a, t), &q->on_b->shape, motion_at(b, t), 0, NULL, NULL, NULL);
}

real group_travel(const Group *g, const GroupPair *q, const Motion *a, const Motion *b, real h)
{
    real travel = h * (vec3_length(vec3_sub(b->v, a->v)) + vec3_length(vec3_sub(b->a, a->a)) * h);
    travel += isfinite(q->on_a->shape.outer) ? h * vec3_length(a->w) * g->member[q->a].rim : 0;
    return travel + (isfinite(q->on_b->shape.outer) ? h * vec3_length(b->w) * g->member[q->b].rim : 0);
}

/* Parts of a substep in which what whirls is looked at: what goes through something farther than both are thick may be out again at its end. */
#define LOOKS 8

/* What goes straight on is past the middle from `most` over its speed on, and for more than as long again: halving the time since they met finds it,
 * however fast it is. */
bool group_went_through(const GroupPair *q, const Motion *a, const Motion *b, real h, real most, real travel)
{
    real met = time_of_impact(&q->on_a->shape, a, &q->on_b->shape, b, 0, h, NULL);
    for (real since = h - met; met < h && since * travel > most * h; since *= 0.5)
        if (depth_at(q, a, b, met + since) > most)
            return true;
    return false;
}

static bool goes_deeper(const Group *g, const GroupPair *q, real most, bool through)
{
    const GroupContact *c = &g->contacts[q->contact];
    Motion a = body_motion(g, q->a), b = body_motion(g, q->b);
    real travel = group_travel(g, q, &a, &b, g->h), depth = most;
    if (travel <= most)
        return false;
    a = motion_of(g, q->a, pair_local(q, false), a);
    b = motion_of(g, q->b, pair_local(q, true), b);
    for (int k = 0; k < c->manifold.count; k++)
        depth = real_max(depth, most - c->manifold.points[k].gap);
    int looks = !through ? 1 : (int)real_clamp(ceil(travel / most), 2, LOOKS);
    for (int k = looks; k > 0; k--)
        if (depth_at(q, &a, &b, g->h * k / looks) > depth)
            return true;
    return through && travel > LOOKS * most && group_went_through(q, &a, &b, g->h, depth, travel);
}

/* Of many pieces nobody knows how deep something is in them. */
static bool crosses(const Group *g, const GroupPair *q)
{
    Motion a = shape_motion(g, q->a, pair_local(q, false)), b = shape_motion(g, q->b, pair_local(q, true));
    return surface_crossed(&q->on_a->shape, &a, &q->on_b->shape, &b, g->h);
}

/* Would a corner that no contact point stands for yet be deep in the other body after this substep? through: past the middle of the thinner
 * one, which healing would then take out on the far side, if it is not there already at the end. */
bool overshoots(const Group *g, bool through)
{
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!g->member[q->a].moves && !g->member[q->b].moves)
            continue;
        if (q->contacts != 1 && through && crosses(g, q))
            return true;
        if (q->contacts != 1 || !g->contacts[q->contact].live || is_squeezed(g, q->contact))
            continue;
        if (goes_deeper(g, q, through ? group_thin(q) : SINK_MOST * q->size, through))
            return true;
    }
    return false;
}

/* Of the size of a pair: no impact that is not located goes deeper, but one faster than MISSED * size / SHORTEST. */
#define MISSED 0.002
#define SHORTEST(dt) ((dt) / 16)

static real fastest_point(const Group *g, int body)
{
    real reach = g->member[body].outer;
    return isfinite(reach) ? reach * vec3_length(g->vel[body].w) : 0;
}

/* s  Where no more impacts are located in this step, short pieces keep what is missed small. Slow things need none: what presses on
 * after its rows have contradicted each other would only be solved in vain more often. */
real missing_little(const Group *g, real dt)
{
    real piece = dt / g->plan->substeps;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        real speed = vec3_length(vec3_sub(g->vel[q->b].v, g->vel[q->a].v)) + fastest_point(g, q->a) + fastest_point(g, q->b);
        if (speed * piece > MISSED * q->size)
            piece = MISSED * q->size / speed;
    }
    return real_max(piece, SHORTEST(dt));
}
