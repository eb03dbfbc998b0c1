/* solve/squeeze.c - what lies between two things that no impulse moves, and that leave it less room than it is wide.
 *
 * A box between a wall and a piston that goes on: the rows of its two contacts ask for speeds that no body has at once, and sweeps go on
 * raising impulses until they are seen to bring nothing. That there is no solution shows beforehand. Where the places at which both press lie
 * before each other, whatever turns the body gives to the one there it takes from the other, and their normals are opposite: the sum of both
 * rows asks for more than nothing from nothing. Then each yields by half of what is missing: the body goes with the mean of both, and what
 * heals overlaps lets both be in it equally deep.
 */
#include "solve/group.h"

#define OPPOSITE (-1 + 1e-6)    /* cosine of normals */
#define BEFORE   1e-6           /* of the size: so far beside each other two points are one before the other */
#define SLOW     1e-6           /* of the size in a step: so slowly nothing presses that is not to rounding */
#define DEEP     1e-3           /* the same: less is no more than what pressing leaves */
#define CLOSED   1e-6           /* the same: so little room between jaws is none */

static bool is_stiff(const Group *g, int body) { return !g->member[body].moves && !g->member[body].dormant; }

/* The body that is pressed, or -1: both move, or none does. */
static int pressed_of(const Group *g, const GroupContact *c)
{
    return g->member[c->a].moves && is_stiff(g, c->b) ? c->a : g->member[c->b].moves && is_stiff(g, c->a) ? c->b : -1;
}

real contact_depth(const GroupContact *c)
{
    real depth = -INFINITY;
    for (int k = 0; k < c->manifold.count; k++)
        depth = real_max(depth, -c->manifold.points[k].gap);
    return depth;
}

/* Not where joints hold somebody, who then bears by it what comes down, and not under something heavy, which presses things into each other. */
bool contact_merged(const Group *g, const GroupContact *c)
{
    bool free = g->joint_count == 0 && c->live && g->member[c->a].moves && g->member[c->b].moves;
    return free && contact_depth(c) > MERGED * g->pairs[c->pair].size && !group_top_heavy(g);
}

static vec3 mean_point(const GroupContact *c)
{
    vec3 sum = vec3_zero();
    for (int k = 0; k < c->manifold.count; k++)
        sum = vec3_add(sum, vec3_scale(0.5, vec3_add(c->manifold.points[k].a, c->manifold.points[k].b)));
    return vec3_scale(1.0 / c->manifold.count, sum);
}

static vec3 inward(const GroupContact *c, int body) { return c->b == body ? c->manifold.normal : vec3_neg(c->manifold.normal); }

/* m/s  Of the stiff one, at a point. */
static vec3 velocity_at(const Group *g, const GroupContact *c, int body, vec3 at)
{
    int by = c->a == body ? c->b : c->a;
    return vec3_add(g->vel[by].v, vec3_cross(g->vel[by].w, vec3_sub(at, g->pos[by].x)));
}

/* Along n, does p lie before a triangle? */
static bool in_triangle(vec3 p, vec3 a, vec3 b, vec3 c, vec3 n)
{
    real s = vec3_dot(n, vec3_cross(vec3_sub(b, a), vec3_sub(p, a))), t = vec3_dot(n, vec3_cross(vec3_sub(c, b), vec3_sub(p, b)));
    real u = vec3_dot(n, vec3_cross(vec3_sub(a, c), vec3_sub(p, c)));
    return (s >= 0 && t >= 0 && u >= 0) || (s <= 0 && t <= 0 && u <= 0);
}

/* Does the middle of the one lie before the other? Of four points some triangle has it. */
static bool before(const GroupContact *c, vec3 p, vec3 n, real near)
{
    const ManifoldPoint *at = c->manifold.points;
    int count = c->manifold.count;
    for (int k = 0; k < count; k++) {
        vec3 off = vec3_sub(p, at[k].a);
        if (vec3_length(vec3_mad(off, -vec3_dot(n, off), n)) <= near)
            return true;
    }
    for (int i = 0; i + 2 < count; i++)
        for (int j = i + 1; j + 1 < count; j++)
            for (int k = j + 1; k < count; k++)
                if (in_triangle(p, at[i].a, at[j].a, at[k].a, n))
                    return true;
    return false;
}

static bool by_mover(const Group *g, const GroupContact *c) { return g->member[c->a].kinematic || g->member[c->b].kinematic; }

/* Two contacts of one body. What holds by friction are movers alone: what was made a little too wide for its place between two that are fixed
 * falls. And movers that open let go, once they will be deep in it no more. */
static void squeeze(Group *g, int i, int j, int body, Jaws which, real ahead)
{
    const GroupContact *c = &g->contacts[i], *d = &g->contacts[j];
    Jaws kind = g->pairs[c->pair].rub->friction > 0 && g->pairs[d->pair].rub->friction > 0 ? JAWS_RUB : JAWS_SLIP;
    bool holds = which == JAWS_RUB;
    if (!(which & kind) || (holds && !by_mover(g, c) && !by_mover(g, d)))
        return;
    vec3 n = inward(c, body);
    if (vec3_dot(n, inward(d, body)) > OPPOSITE)
        return;
    vec3 p = mean_point(c), q = mean_point(d);
    real size = real_min(g->pairs[c->pair].size, g->pairs[d->pair].size), deep = contact_depth(c) + contact_depth(d);
    bool from_c = before(d, p, n, BEFORE * size);
    if (!from_c && !before(c, q, n, BEFORE * size))
        return;
    /* by where they lie before each other, along one normal: what turns as one thing does not close, wherever the middles are */
    vec3 at = from_c ? p : q;
    real rate = vec3_dot(n, vec3_sub(velocity_at(g, c, body, at), velocity_at(g, d, body, at))), way = rate * g->world->def.step;
    if (deep + ahead * real_max(rate, 0) < -(holds ? CLOSED : g->touch) * size)
        return;
    real yields = way > SLOW * size ? 0.5 * rate : 0, heals = deep > DEEP * size ? 0.5 * deep : 0;
    bool opens = holds && way < -SLOW * size && deep + way < DEEP * size, grips = holds && c->grips && d->grips;
    if (opens || (yields + heals <= 0 && !grips))
        return;
    for (int k = 0; k < 2; k++) {
        Squeeze *to = &g->squeezed[k ? j : i];
        to->rate = real_max(to->rate, yields);
        to->depth = real_max(to->depth, heals);
        to->grips = to->grips || grips;
    }
    g->squeezes = true;
}

/* Does it touch, by something stiff that moves, or deeply? Without one there is nothing to be squeezed by. */
static bool may_squeeze(const Group *g, const GroupContact *c, real ahead)
{
    if (ahead > 0 && by_mover(g, c))
        return true;
    real least = c->grips ? -CLOSED : g->driven && by_mover(g, c) ? -g->touch : DEEP;
    return contact_depth(c) > least * g->pairs[c->pair].size;
}

bool squeeze_possible(const Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        if (g->contacts[i].live && pressed_of(g, &g->contacts[i]) >= 0 && may_squeeze(g, &g->contacts[i], 0))
            return true;
    return false;
}

dig_status squeeze_open(Group *g)
{
    g->squeezed = arena_alloc(g->arena, (size_t)(g->contact_count + 1) * sizeof *g->squeezed);
    g->pressed = arena_alloc(g->arena, (size_t)g->body_count * sizeof *g->pressed);
    return g->squeezed && g->pressed ? DIG_OK : DIG_E_MEMORY;
}

void group_squeeze(Group *g, Jaws which, real ahead)
{
    g->squeezes = false;
    if (!g->squeezed || !(ahead > 0 || squeeze_possible(g)))
        return;
    memset(g->pressed, 0xff, (size_t)g->body_count * sizeof *g->pressed);
    for (int i = g->contact_count - 1; i >= 0; i--) {
        int body = g->contacts[i].live ? pressed_of(g, &g->contacts[i]) : -1;
        g->squeezed[i] = (Squeeze){0, 0, body < 0 ? -1 : g->pressed[body], false};
        if (body >= 0)
            g->pressed[body] = i;
    }
    for (int i = 0; i < g->contact_count; i++) {
        int body = g->contacts[i].live ? pressed_of(g, &g->contacts[i]) : -1;
        if (body < 0 || !may_squeeze(g, &g->contacts[i], ahead))
            continue;
        for (int j = g->pressed[body]; j >= 0; j = g->squeezed[j].next)
            if (j != i)
                squeeze(g, i, j, body, which, ahead);
    }
}

real squeeze_missing(const Group *g)
{
    real most = 0;
    for (int i = 0; i < g->contact_count && g->squeezes; i++)
        most = real_max(most, 2 * g->squeezed[i].rate);
    return most;
}
