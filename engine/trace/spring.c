/* trace/spring.c - one or two bodies that one spring moves along its line: in closed form.
 *
 * Let s be by how much the spring is longer than without force, u what its two ends give way along its line, a by how much all else speeds
 * up the one against the other. Where nothing moves across that line and nothing turns it,
 *
 *     s'' = a - u (k s + c s'),
 *
 * whatever k is: steps that follow the swing of 1 kg on 1e8 N/m would have to be of 0.1 ms, and those that are stable without that have to
 * be solved for. Anything else is handed on as it was gathered.
 */
#include "trace/trace.h"

#define PAIRS  4                /* most of what is near */
#define CLEAR  1e-4             /* of the size: what stays so far apart does not touch */
#define ACROSS 1e-12            /* of the length: so far may it move across its line in a step, or a body's lever be off that line */
#define SHORT  0.1              /* of the length: nearer its ends do not come, or the line might be another one */
#define SAME   1e-8             /* rad: roots as near as that are one */

static bool is_free(const Group *g, int body) { return body >= 0 && g->member[body].moves; }

static bool suits(const Group *g)
{
    if (g->joint_count != 1 || !trace_untouched(g, PAIRS) || g->push_count > 0 || g->planar || g->moving_count > 2)
        return false;
    if (g->own || g->varies || g->drags || g->rules || g->world->region_count > 0)
        return false;
    const GroupJoint *j = &g->joints[0];
    const JointType *t = j->view.type;
    if (!t->two_anchors || t->elastic || !j->stores || j->breaks_at > 0 || j->broken)
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (!g->member[i].moves || g->member[i].integrator != DIG_AUTO || (i != j->a && i != j->b))
            return false;
    return (is_free(g, j->a) || member_still(g, j->a)) && (is_free(g, j->b) || member_still(g, j->b));
}

/* Motion along the line. */
typedef struct Swing {
    Row  row;
    real length;                /* m */
    vec3 line;                  /*       from b to a */
    real rate, pull;            /* m/s, m/s^2  of the length: now, and what all but the spring adds */
    real mobility;              /* 1/kg */
} Swing;

static vec3 acceleration_of(const Group *g, int body) { return is_free(g, body) ? vec3_scale(g->mass[body].im, g->member[body].force) : vec3_zero(); }
static vec3 velocity_of(const Group *g, int body) { return is_free(g, body) ? g->vel[body].v : vec3_zero(); }
static real mobility_of(const Group *g, int body) { return is_free(g, body) ? g->mass[body].im : 0; }

/* Does the spring turn nothing, and nothing its end? */
static bool stays_in_line(const Group *g, const JointEnd *e, vec3 line, real length)
{
    if (!is_free(g, e->body))
        return true;
    const Member *m = &g->member[e->body];
    if (!vec3_is_zero(m->torque))
        return false;
    if (vec3_is_zero(e->r) && m->round)
        return true;
    return vec3_is_zero(g->vel[e->body].w) && vec3_length(vec3_cross(e->r, line)) <= ACROSS * length;
}

static bool across(vec3 v, vec3 line, real most) { return vec3_length(vec3_mad(v, -vec3_dot(v, line), line)) > most; }

/* The joint was viewed when its energy was asked for, by who watches the group. */
static bool look(const Group *g, real h, Swing *s)
{
    const JointView *j = &g->joints[0].view;
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    j->type->rows(j, &list);
    if (list.count != 1 || rows[0].kind != ROW_SOFT || rows[0].angular || rows[0].count != 2 || !(rows[0].stiffness > 0))
        return false;
    s->row = rows[0];
    s->length = joint_length(j);
    s->line = s->row.lin[0];
    vec3 v = vec3_sub(velocity_of(g, j->a.body), velocity_of(g, j->b.body));
    vec3 a = vec3_sub(acceleration_of(g, j->a.body), acceleration_of(g, j->b.body));
    s->rate = vec3_dot(s->line, v);
    s->pull = vec3_dot(s->line, a);
    s->mobility = mobility_of(g, j->a.body) + mobility_of(g, j->b.body);
    real most = ACROSS * s->length;
    if (across(v, s->line, most / h) || across(a, s->line, most / (h * h)))
        return false;
    if (!stays_in_line(g, &j->a, s->line, s->length) || !stays_in_line(g, &j->b, s->line, s->length))
        return false;
    real stiffness = s->mobility * s->row.stiffness, middle = s->pull / stiffness, off = s->row.error - middle;
    real least = s->length - s->row.error + middle - sqrt(off * off + s->rate * s->rate / stiffness);
    return least > SHORT * s->length;
}

/* Of y'' + 2 b y' + w^2 y = 0: *even has y = 1 and y' + b y = 0 at first, *odd y = 0 and y' = 1. */
static void decay(real b, real w2, real h, real *even, real *odd)
{
    real d = w2 - b * b;
    if (d > 0) {
        real w = sqrt(d), fades = b > 0 ? exp(-b * h) : 1;
        *even = fades * cos(w * h);
        *odd = fades * sin(w * h) / w;
        return;
    }
    real q = sqrt(-d), slow = exp(-w2 / (b + q) * h), part = exp(-2 * q * h);       /* -b + q without cancellation */
    *even = 0.5 * slow * (1 + part);
    *odd = q * h > SAME ? slow * -expm1(-2 * q * h) / (2 * q) : slow * h;
}

static real energy_of(const Swing *s, real longer, real rate)
{
    return 0.5 * (s->row.stiffness * longer * longer + rate * rate / s->mobility);
}

static void speed_up(Group *g, int body, const Swing *s, real side, real more)
{
    if (is_free(g, body))
        g->vel[body].v = vec3_mad(g->vel[body].v, side * g->mass[body].im / s->mobility * more, s->line);
}

/* way, gain: m and m/s  of the length in the step, but for what the ends do without the spring. */
static void carry(Group *g, int body, const Swing *s, real side, real way, real gain)
{
    if (!is_free(g, body))
        return;
    real h = g->h, part = side * g->mass[body].im / s->mobility;
    vec3 a = acceleration_of(g, body), w = g->vel[body].w;
    g->pos[body].x = vec3_mad(vec3_mad(vec3_mad(g->pos[body].x, h, g->vel[body].v), 0.5 * h * h, a), part * way, s->line);
    g->vel[body].v = vec3_mad(vec3_mad(g->vel[body].v, h, a), part * gain, s->line);
    if (!vec3_is_zero(w))
        g->pos[body].q = quat_unit(quat_mul(quat_exp(vec3_scale(h, w)), g->pos[body].q));
}

static vec3 place_of(const Group *g, int body) { return is_free(g, body) ? g->pos[body].x : vec3_zero(); }

/* m/s  The rate that keeps the energy where places are rounded: of a swing of a ten-millionth of a metre they are known to a billionth. */
static real kept_rate(const Swing *s, real from, real to, real rate)
{
    real square = s->rate * s->rate + s->mobility * s->row.stiffness * (from - to) * (from + to);
    return square > 0.25 * rate * rate ? copysign(sqrt(square), rate) : rate;
}

/* m  From the middle, as far as it may swing. */
static real amplitude(const Swing *s)
{
    real w2 = s->mobility * s->row.stiffness, from = s->row.error - s->pull / w2;
    return sqrt(from * from + s->rate * s->rate / w2);
}

/* m  So far may a body get along n within the step: by the swing, and by what it does besides. */
static real farthest(const Group *g, int body, const Swing *s, real side, vec3 n)
{
    if (!is_free(g, body))
        return 0;
    real h = g->h, part = side * g->mass[body].im / s->mobility, w2 = s->mobility * s->row.stiffness;
    real from = s->row.error - s->pull / w2, far = amplitude(s), along = part * vec3_dot(n, s->line);
    vec3 v = vec3_mad(g->vel[body].v, -part * s->rate, s->line), a = vec3_mad(acceleration_of(g, body), -part * s->pull, s->line);
    return real_max(along * (far - from), along * (-far - from)) + h * (fabs(vec3_dot(n, v)) + 0.5 * h * fabs(vec3_dot(n, a)));
}

/* What does not turn stays on its side of a plane between the two, across the line on which they are nearest. */
static bool stays_clear(const Group *g, const GroupPair *q, const Swing *s)
{
    const GroupJoint *j = &g->joints[0];
    const GroupManifold *m = &g->contacts[q->contact].manifold;
    real gap = INFINITY;
    for (int k = 0; k < 2; k++) {
        int body = k == 0 ? q->a : q->b;
        if (!vec3_is_zero(g->vel[body].w) || (!is_free(g, body) && !member_still(g, body)))
            return false;
    }
    for (int k = 0; k < m->count; k++)
        gap = real_min(gap, m->points[k].gap);
    real way = farthest(g, q->a, s, q->a == j->a ? 1 : -1, m->normal) + farthest(g, q->b, s, q->b == j->a ? 1 : -1, vec3_neg(m->normal));
    return gap - way > CLEAR * q->size;
}

/* Does nothing meet? What was found near is then left behind: the next step looks anew. */
static bool keeps_apart(Group *g, const Swing *s)
{
    bool apart = true;
    for (int i = 0; i < g->pair_count; i++) {
        group_touch_pair(g, &g->pairs[i], g->h);
        apart = apart && !g->pairs[i].hidden && (!g->contacts[g->pairs[i].contact].live || stays_clear(g, &g->pairs[i], s));
    }
    g->looked = true;
    if (apart)
        trace_leave_pairs(g);
    return apart;
}

#define TURNS 1.5               /* rad: what swings farther in the step may turn back, and come again */

/* Where it turns back within the step, which its ends do not tell. */
static void note_turns(Group *g, int body, const Swing *s, real side, vec3 start, real from, real to)
{
    real far = amplitude(s);
    if (!is_free(g, body))
        return;
    vec3 line = vec3_scale(side * g->mass[body].im / s->mobility, s->line), end = g->pos[body].x;
    for (int k = -1; k <= 1; k += 2) {
        group_note_swing(g, body, vec3_mad(start, k * far - from, line), 0);
        group_note_swing(g, body, vec3_mad(end, k * far - to, line), 0);
    }
}

static void swing(Group *g, const Swing *s)
{
    GroupJoint *j = &g->joints[0];
    real h = g->h, k = s->row.stiffness, w2 = s->mobility * k, b = 0.5 * s->mobility * s->row.damping, even, odd;
    real middle = s->pull / w2, from = s->row.error - middle;
    decay(b, w2, h, &even, &odd);
    real to = from * even + (s->rate + b * from) * odd, rate = s->rate * even - (b * s->rate + w2 * from) * odd;
    real gain = rate - s->rate - h * s->pull;
    real way = to - from - h * (s->rate + 0.5 * h * s->pull);
    vec3 a = place_of(g, j->a), c = place_of(g, j->b), apart = vec3_sub(a, c);
    carry(g, j->a, s, 1, way, gain);
    carry(g, j->b, s, -1, way, gain);
    if (s->rate * rate < 0 || w2 * h * h > TURNS * TURNS) {
        note_turns(g, j->a, s, 1, a, from, to);
        note_turns(g, j->b, s, -1, c, from, to);
    }
    if (!(s->row.damping > 0)) {
        to = from + vec3_dot(s->line, vec3_sub(vec3_sub(place_of(g, j->a), place_of(g, j->b)), apart));
        real more = kept_rate(s, from, to, rate) - rate;
        speed_up(g, j->a, s, 1, more);
        speed_up(g, j->b, s, -1, more);
        rate += more;
        gain += more;
    }
    memset(j->force, 0, sizeof j->force);
    j->force[s->row.slot] = -k * (middle + to) - s->row.damping * rate;
    j->impulse = vec3_mad(j->impulse, gain / s->mobility, s->line);
    if (!(s->row.damping > 0))
        return;
    real lost = real_max(0, energy_of(s, from, s->rate) - energy_of(s, to, rate));      /* about the middle no work is done by the rest */
    j->lost += lost;
    g->lost += lost;
}

static dig_status advance(Group *g, real dt)
{
    Swing s;
    real h = g->h;
    g->h = dt;
    DIG_TRY(group_forces(g));
    if (!look(g, dt, &s) || !keeps_apart(g, &s)) {
        g->h = h;
        g->handed_on = true;
        return DIG_OK;
    }
    swing(g, &s);
    for (int i = 0; i < g->moving_count; i++)
        g->member[i].constrained = true;
    g->evaluations = g->substeps = 1;
    g->t = dt;
    return g->stage(g, STAGE_SETTLE);
}

const Way way_spring = {.name = "spring", .tally = WAY_TRACED, .suits = suits, .advance = advance};
