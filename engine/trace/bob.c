/* trace/bob.c - one body that hangs by its centre of mass on a rod or a taut rope without mass, by a power series.
 *
 * A bob on a string: r from the point it hangs on keeps its length R. With the same force F everywhere,
 *
 *     r' = v,    v' = F / m + n r,    n = -(v . v + r . F / m) / R^2,
 *
 * so that the terms of the series of each follow from those before (Moore, Interval Analysis, 1966, section 11.2). As many as double
 * precision can tell. It turns as in free flight. A rope that may go slack, what twists it, and anything near are handed on as gathered.
 */
#include "trace/trace.h"

#define ENOUGH   1e-17          /* of the length: terms that follow two smaller ones are no part of the sum */
#define CENTRAL  1e-12          /* of the size: an anchor that far from the centre of mass is at it */
#define KEPT     1e-6           /* of the energy of motion: more is not made good, for so little is left where it turns back */

static bool suits(const Group *g)
{
    return hang_suits(g) && g->joints[0].view.type->two_anchors;
}

typedef struct Bob {
    Hang hang;
    vec3 point, r, v, acc;      /* m, m/s, m/s^2  where it hangs; from there, now; F / m */
    real length;                /* m */
    bool rope;
} Bob;

/* Does one row hold it by its centre of mass, at a known distance? */
static bool look(Group *g, Bob *b)
{
    const GroupJoint *j = &g->joints[0];
    const Member *m = &g->member[0];
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    if (!hang_look(g, &b->hang) || vec3_length(b->hang.own->r) > CENTRAL * m->outer || !vec3_is_zero(m->torque))
        return false;
    j->view.type->rows(&j->view, &list);
    b->rope = list.count == 1 && rows[0].kind == ROW_LIMIT;
    if (list.count != 1 || rows[0].angular || rows[0].count != 2 || !(b->rope || rows[0].kind == ROW_HARD))
        return false;
    b->point = b->hang.other->p;
    b->r = vec3_sub(g->pos[0].x, b->point);
    b->v = b->hang.before.v;
    b->acc = vec3_scale(g->mass[0].im, m->force);
    real away = vec3_length(b->r);
    b->length = b->rope ? away + rows[0].error : away - rows[0].error;
    if (b->rope && vec3_dot(rows[0].lin[b->hang.is_a ? 0 : 1], b->r) > 0)      /* it holds off instead */
        return false;
    bool in_place = b->length > CENTRAL * m->outer && fabs(rows[0].error) <= b->hang.least;
    return in_place && fabs(vec3_dot(b->r, b->v)) <= b->hang.slowest * away;
}

/* One part of the step, of h seconds. False: the series do not end. */
static bool turn(Bob *b, real h)
{
    vec3 r[SERIES_TERMS], v[SERIES_TERMS];
    real n[SERIES_TERMS], small = ENOUGH * b->length, each = -1 / (b->length * b->length);
    r[0] = b->r;
    v[0] = b->v;
    for (int k = 0; k + 1 < SERIES_TERMS; k++) {
        real sum = vec3_dot(r[k], b->acc);
        for (int i = 0; i <= k; i++)
            sum += vec3_dot(v[i], v[k - i]);
        n[k] = each * sum;
        vec3 change = k == 0 ? b->acc : vec3_zero();
        for (int i = 0; i <= k; i++)
            change = vec3_mad(change, n[i], r[k - i]);
        real next = h / (k + 1);
        v[k + 1] = vec3_scale(next, change);
        r[k + 1] = vec3_scale(next, v[k]);
        b->v = vec3_add(b->v, v[k + 1]);
        b->r = vec3_add(b->r, r[k + 1]);
        if (k + 1 >= SERIES_LEAST && vec3_length(r[k + 1]) + vec3_length(r[k]) + h * (vec3_length(v[k + 1]) + vec3_length(v[k])) <= small)
            return true;
    }
    return false;
}

/* Did a rope pull all the time, from there to here? By v . v - 2 r . F / m, which stays, its pull is least where r . F / m is; and as long as
 * it pulls that curve bends up, below its tangent it does not go. */
static bool pulled(const Bob *from, const Bob *to, real h)
{
    real first = vec3_dot(from->r, from->acc), sinks = vec3_dot(from->v, from->acc), least = real_min(first, vec3_dot(to->r, from->acc));
    if (sinks < 0 && vec3_dot(to->v, from->acc) > 0)
        least = real_min(least, first + h * sinks);
    return vec3_length2(from->v) + 3 * least - 2 * first > 0;
}

/* False: not in so few parts, or a rope may go slack. */
static bool swing(Bob *b, real h)
{
    real push = vec3_length(b->acc) / b->length, rate = real_max(vec3_length(b->v) / b->length + h * push, sqrt(2 * push));
    int parts = hang_parts(rate * h);
    if (parts == 0)
        return false;
    for (int i = 0; i < parts; i++) {
        Bob from = *b;
        if (!turn(b, h / parts) || (b->rope && !pulled(&from, b, h / parts)))
            return false;
    }
    return true;
}

/* m/s^2  By which it is held, towards the point. */
static real pull_of(const Bob *b) { return (vec3_length2(b->v) + vec3_dot(b->r, b->acc)) / b->length; }

/* To where it has swung: at its distance, and with the energy that it had where places are rounded. */
static void move(Group *g, Bob *b, real h)
{
    vec3 from = g->pos[0].x, line = vec3_scale(1 / vec3_length(b->r), b->r);
    b->r = vec3_scale(b->length, line);
    g->pos[0].x = vec3_add(b->point, b->r);
    b->v = vec3_mad(b->v, -vec3_dot(line, b->v), line);
    real found = vec3_length2(b->v), wanted = vec3_length2(b->hang.before.v) + 2 * vec3_dot(b->acc, vec3_sub(g->pos[0].x, from));
    if (found > 0 && fabs(wanted - found) <= KEPT * found)       /* added, not multiplied: the root of what is next to one is one more often than not */
        b->v = vec3_mad(b->v, 0.5 * (wanted - found) / found, b->v);
    g->vel[0].v = b->v;
    flight_turn(g, 0, h);
}

static void book(Group *g, const Bob *b, real h)
{
    GroupJoint *j = &g->joints[0];
    Row rows[JOINT_SLOTS];
    vec3 force = vec3_scale(-g->member[0].mass * pull_of(b) / b->length, b->r);
    for (int i = 0, count = hang_rows(g, rows); i < count; i++)
        j->force[rows[i].slot] = vec3_dot(rows[i].lin[b->hang.is_a ? 0 : 1], force);
    hang_book_impulses(g, &b->hang, hang_impulse(g, &b->hang, h), vec3_zero(), vec3_zero());
}

static bool follow(Group *g, real h)
{
    Bob b;
    if (!look(g, &b))
        return false;
    if (!swing(&b, h) || !hang_apart(g, h, 0))
        return false;
    move(g, &b, h);
    book(g, &b, h);
    return true;
}

static dig_status advance(Group *g, real dt) { return hang_advance(g, dt, follow); }

const Way way_bob = {.name = "bob", .tally = WAY_TRACED, .suits = suits, .advance = advance};
