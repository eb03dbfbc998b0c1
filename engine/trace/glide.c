/* trace/glide.c - one body that slides or rolls on, by the forces of the frame before.
 *
 * A box that slides on a floor and a ball that rolls down a slope need the same forces frame after frame: normals and levers of their
 * one contact do not change, accelerations are constant, and the centre of mass follows a parabola. That is what the tracer finds, too,
 * with all it has for whatever could happen. Here it is only seen that nothing does: the forces balance at the start, friction keeps its
 * direction, and at the end the same points touch in the same places. Anything else is handed on to the tracer, as it was gathered.
 * A ball on what moves evenly below it, a turntable or a belt, has a closed form, too (below).
 */
#include "math/pair.h"
#include "trace/trace.h"

#define PAIRS   4               /* most of them; all but one without a point */
#define ROUNDING 1e-15          /* of the largest acceleration: along the normal nothing is left */
#define BALANCE 1e-14           /* the same, of what would turn or drag it: far from the origin levers are known no better */
#define STILL   1e-15           /* rad in a step: what turns by less does not */
#define SAME    1e-12           /* cosine, and of the size: levers and directions that differ by less */
#define FOLLOWS (1 - 1e-9)      /* cosine: friction that points there does where the slip is now */

static bool held(const GroupContact *c)
{
    bool all = c->live && c->manifold.count > 0;
    for (int k = 0; k < c->manifold.count && all; k++)
        all = contact_memory(c)[k].held == HELD_SUBSTEPS && contact_memory(c)[k].normal >= 0;
    return all;
}

/* The one contact with points, or -1: there are more, or something has happened to its pair. */
static int only_contact(const Group *g)
{
    int only = -1;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        const GroupContact *c = &g->contacts[q->contact];
        if (q->contacts != 1 || q->fresh)
            return -1;
        if (c->manifold.count == 0 && !c->live)
            continue;
        if (only >= 0 || q->rub->rolling > 0 || !held(c))
            return -1;
        only = q->contact;
    }
    return only;
}

/* Is it on what moves, and is that where its one contact is? */
static bool carries(const Group *g, int body)
{
    int only = g->driven && g->member[body].kinematic ? only_contact(g) : -1;
    return only >= 0 && (g->contacts[only].a == body || g->contacts[only].b == body);
}

static bool suits(const Group *g)
{
    if (g->moving_count != 1 || g->trace_step <= 0 || g->pair_count == 0 || g->pair_count > PAIRS || g->joint_count + g->push_count > 0)
        return false;
    if (g->own || g->varies || g->planar || g->world->region_count > 0 || !g->member[0].moves)
        return false;
    for (int i = 1; i < g->body_count; i++)
        if (!member_still(g, i) && !carries(g, i))
            return false;
    return only_contact(g) >= 0 && trace_suits(g);
}

typedef struct Glide {
    Group *g;
    const Tracer *scales;
    real h;
    GroupContact *c;
    const GroupPair *q;
    real side;                  /* 1: the body is b of its pair, and the normal points at it; -1 */
    bool ball;                  /* about its centre of mass: its lever stays whatever it turns */
    bool turns;
    int  count;
    vec3 normal, lever[MANIFOLD_POINTS];
    uint32_t feature[MANIFOLD_POINTS];
    PointMemory force[MANIFOLD_POINTS];
    bool slides;
    vec3 slip, slip_end;        /* m/s  of b against a, of the first point: of all, where nothing turns */
    vec3 acc, alpha;            /* m/s^2, rad/s^2 */
    Pos  pos; Vel vel;          /* at the start */
    int  table;                 /* member that carries it and moves, or 0 */
    Pos  table_pos;             /* at the start */
    vec3 up, course;            /* m/s  of its centre against the table's, along the plane, at the start */
    real rate, lean;            /* rad/s  at which that turns; rad/m  by which its spin changes with it */
    vec3 gain;                  /* m/s  of its velocity, in the step */
    ManifoldPoint points[MANIFOLD_POINTS];
} Glide;

static vec3 own_point(const Glide *s, const ManifoldPoint *p) { return s->side > 0 ? p->b : p->a; }

/* So far off may what touches be left: more the tracer puts right. */
static bool closed(const Glide *s, real gap)
{
    return fabs(gap) <= real_max(1e-13 * s->scales->size, GATE_DRIFT * s->scales->tolerance);
}

INLINE void look(Glide *s)
{
    const Group *g = s->g;
    const GroupManifold *m = &s->c->manifold;
    const Form *on = s->side > 0 ? s->q->on_b : s->q->on_a;
    s->count = m->count;
    s->normal = m->normal;
    s->pos = g->pos[0];
    s->vel = g->vel[0];
    for (int k = 0; k < m->count; k++) {
        s->points[k] = m->points[k];
        s->lever[k] = vec3_sub(own_point(s, &m->points[k]), s->pos.x);
        s->feature[k] = m->points[k].feature;
        s->force[k] = contact_memory(s->c)[k];
    }
    s->ball = m->count == 1 && on->shape.outer == on->shape.round && vec3_length(vec3_cross(s->lever[0], s->normal)) <= SAME * g->member[0].outer;
    s->turns = s->h * vec3_length(s->vel.w) > STILL;
}

/* Friction of a point, on b, as its slip wants it. */
static bool rub(Glide *s, vec3 *tangent, real normal)
{
    real speed = vec3_length(s->slip), most = s->q->rub->friction_dynamic * normal;
    if (!(s->q->rub->friction > 0))
        return !s->slides && vec3_is_zero(*tangent);
    if (!s->slides)
        return speed <= 1e-3 * s->scales->slip_zero && vec3_length(*tangent) <= s->q->rub->friction * normal;
    real length = vec3_length(*tangent);
    if (!(speed > s->scales->slip_zero) || !(vec3_dot(*tangent, s->slip) < -FOLLOWS * length * speed) || !(fabs(length - most) <= SAME * most))
        return false;
    *tangent = vec3_scale(-most, vec3_scale(1 / speed, s->slip));
    return true;
}

/* Do the forces of the frame before balance? Then they are those of this one. */
INLINE bool balances(Glide *s)
{
    const Group *g = s->g;
    const Member *m = &g->member[0];
    const Mass *mass = &g->mass[0];
    vec3 torque = m->torque, u = s->turns ? vec3_add(s->vel.v, vec3_cross(s->vel.w, s->lever[0])) : s->vel.v;
    real rate = vec3_dot(s->normal, u), bound = 0;
    s->slip = vec3_scale(s->side, vec3_mad(u, -rate, s->normal));
    s->slides = s->c->manifold.slides;
    s->acc = vec3_scale(mass->im, m->force);
    real scale = real_max(g->fall + 1e-9 * s->scales->size * s->scales->pace * s->scales->pace, vec3_length(s->acc)), zero = BALANCE * scale;
    if (!closed(s, rate / s->scales->pace))
        return false;
    for (int k = 0; k < s->count; k++) {
        PointMemory *f = &s->force[k];
        if (!closed(s, s->points[k].gap) || !rub(s, &f->tangent, f->normal))
            return false;
        vec3 force = vec3_scale(s->side, vec3_mad(f->tangent, f->normal, s->normal));
        s->acc = vec3_mad(s->acc, mass->im, force);
        torque = vec3_add(torque, vec3_cross(s->lever[k], force));
        bound += s->q->rub->friction_dynamic * f->normal;
    }
    s->alpha = mat3_mul_vec(mass->ii, torque);
    bool spins_up = vec3_length(s->alpha) * m->outer > zero;
    if (!spins_up)
        s->alpha = vec3_zero();
    if ((spins_up || s->turns) && !(s->ball && m->round))
        return false;
    real lift = vec3_dot(s->normal, s->acc);
    vec3 change = vec3_scale(s->side, spins_up ? vec3_add(s->acc, vec3_cross(s->alpha, s->lever[0])) : s->acc);
    s->slip_end = vec3_mad(s->slip, s->h, change);
    if (!(fabs(lift) <= ROUNDING * scale))
        return false;
    if (!(s->q->rub->friction > 0))
        return true;
    if (!s->slides)
        return vec3_length(change) <= zero;
    /* not so slow that it might stop, or turn, within the step; nor one that turns */
    real speed = vec3_length(s->slip), most = real_max(bound * mass->im, vec3_length(change));
    return speed >= 2 * s->h * most && vec3_length(vec3_cross(s->slip, s->slip_end)) <= SAME * speed * speed;
}

/* ---- a ball on what moves evenly ----
 *
 * It rolls on a plane with normal n, lever -R n, that moves by V and turns by W about n; what pulls it does so along n:
 *
 *   m dv/dt = f,    I dw/dt = -R n x f,    v + R n x w = V + W n x (p - C)
 *   =>  dc/dt = L W n x c    with c = v - V,  L = I / (I + m R^2),    dw/dt = -(R m / I) n x dc/dt
 *
 * so that c turns at an even rate: the circles of a ball on a turntable (A14), a straight line on a belt. */

#define NODE       0.28867513459481287  /* of a part, from its middle: of the Gauss rule of order 4 */
#define TURN_ERROR 720                  /* h^5 |dw/dt| |w|^3 over this bounds the error of a turn by two of them: 768 was the least of 5000 at random */
#define PARTS      16

/* Does it roll, held by what friction can give? */
static bool rolls(Glide *s)
{
    const Group *g = s->g;
    const Member *m = &g->member[0];
    const Mass *mass = &g->mass[0];
    const Vel *table = &g->vel[s->table];
    vec3 up = vec3_scale(s->side, s->normal), at = vec3_add(s->pos.x, s->lever[0]);
    vec3 under = vec3_add(table->v, vec3_cross(table->w, vec3_sub(at, s->table_pos.x)));
    vec3 slip = vec3_sub(vec3_add(s->vel.v, vec3_cross(s->vel.w, s->lever[0])), under);
    real rate = vec3_dot(up, slip), turn = vec3_dot(up, table->w), press = -vec3_dot(up, m->force);
    real lever = -vec3_dot(up, s->lever[0]), inverse = vec3_dot(up, mat3_mul_vec(mass->ii, up));
    real zero = BALANCE * (g->fall + 1e-9 * s->scales->size * s->scales->pace * s->scales->pace);
    bool fits = s->ball && m->round && !s->c->manifold.slides && s->q->rub->friction > 0;
    if (!fits || vec3_length(vec3_cross(table->w, up)) > SAME * fabs(turn))
        return false;
    if (!closed(s, s->points[0].gap) || !closed(s, rate / s->scales->pace) || !(vec3_length(vec3_mad(slip, -rate, up)) <= 1e-3 * s->scales->slip_zero))
        return false;
    if (mass->im * vec3_length(vec3_mad(m->force, press, up)) > zero || vec3_length(mat3_mul_vec(mass->ii, m->torque)) * m->outer > zero)
        return false;
    vec3 course = vec3_sub(s->vel.v, table->v);
    s->up = up;
    s->course = vec3_mad(course, -vec3_dot(up, course), up);
    s->rate = turn * mass->im / (mass->im + lever * lever * inverse);
    s->lean = lever * inverse / mass->im;
    s->force[0].normal = press;
    s->slip = s->slip_end = vec3_zero();
    s->slides = false;
    return fabs(s->rate) * vec3_length(s->course) <= s->q->rub->friction * press * mass->im;
}

/* rad/s  In a time. */
static vec3 spin_after(const Glide *s, vec3 aside, real time)
{
    real half = sin(0.5 * s->rate * time);
    vec3 gain = vec3_mad(vec3_scale(sin(s->rate * time), aside), -2 * half * half, s->course);
    return vec3_mad(s->vel.w, -s->lean, vec3_cross(s->up, gain));
}

/* Two spins of each part, by Magnus' series up to their product. False: it whirls too fast for that. */
static bool turn_on(Glide *s, vec3 aside)
{
    Group *g = s->g;
    real spin = vec3_length(s->vel.w) + 2 * s->lean * vec3_length(s->course) + fabs(s->rate);
    real off = pow(s->h, 5) * s->lean * fabs(s->rate) * vec3_length(s->course) * spin * spin * spin / TURN_ERROR * g->member[0].outer;
    int parts = 1;
    for (; off > 0.1 * s->scales->tolerance; off /= 16)
        if ((parts *= 2) > PARTS)
            return false;
    real part = s->h / parts;
    quat q = s->pos.q;
    for (int i = 0; i < parts; i++) {
        vec3 first = spin_after(s, aside, (i + 0.5 - NODE) * part), second = spin_after(s, aside, (i + 0.5 + NODE) * part);
        vec3 turn = vec3_mad(vec3_scale(0.5 * part, vec3_add(first, second)), -0.5 * NODE * part * part, vec3_cross(first, second));
        q = quat_unit(quat_mul(quat_exp(turn), q));
    }
    g->pos[0].q = q;
    return true;
}

/* Work of the table included. */
static bool roll_on(Glide *s)
{
    Group *g = s->g;
    const Vel *table = &g->vel[s->table];
    real h = s->h, turn = s->rate * h, half = sin(0.5 * turn), whole = sin(turn), im = g->mass[0].im;
    real along = turn != 0 ? whole / turn - 1 : 0, across = turn != 0 ? 2 * half * half / turn : 0;
    vec3 aside = vec3_cross(s->up, s->course);
    if (!turn_on(s, aside))
        return false;
    s->gain = vec3_mad(vec3_scale(whole, aside), -2 * half * half, s->course);
    vec3 turned = vec3_cross(s->up, s->gain);
    g->pos[0].x = vec3_mad(vec3_mad(vec3_mad(s->pos.x, h, s->vel.v), h * along, s->course), h * across, aside);
    g->vel[0] = (Vel){vec3_add(s->vel.v, s->gain), vec3_mad(s->vel.w, -s->lean, turned)};
    g->pos[s->table].x = vec3_mad(s->table_pos.x, h, table->v);
    g->pos[s->table].q = quat_unit(quat_mul(quat_exp(vec3_scale(h, table->w)), s->table_pos.q));
    s->force[0].tangent = vec3_scale(s->side * s->rate / im, vec3_add(aside, turned));
    return true;
}

/* J  What the table gave: all that its motion gained, and what lifting it took. */
static real table_work(const Glide *s)
{
    const Group *g = s->g;
    const Vel *end = &g->vel[0];
    real linear = vec3_dot(vec3_sub(end->v, s->vel.v), vec3_add(end->v, s->vel.v)) / g->mass[0].im;
    real angular = vec3_dot(vec3_sub(end->w, s->vel.w), vec3_add(end->w, s->vel.w)) / vec3_dot(s->up, mat3_mul_vec(g->mass[0].ii, s->up));
    return 0.5 * (linear + angular) - vec3_dot(g->member[0].force, vec3_sub(g->pos[0].x, s->pos.x));
}

INLINE bool move(Glide *s)
{
    const Group *g = s->g;
    const Vel *v = &s->vel;
    real h = s->h;
    if (vec3_length(vec3_cross(s->alpha, v->w)) * h * h * h * g->member[0].outer > 0.1 * s->scales->tolerance)
        return false;
    g->pos[0].x = vec3_mad(vec3_mad(s->pos.x, h, v->v), 0.5 * h * h, s->acc);
    g->vel[0].v = vec3_mad(v->v, h, s->acc);
    if (!s->turns && vec3_is_zero(s->alpha))
        return true;
    vec3 turn = vec3_add(vec3_scale(h, v->w), vec3_add(vec3_scale(0.5 * h * h, s->alpha), vec3_scale(h * h * h / 12, vec3_cross(s->alpha, v->w))));
    g->pos[0].q = quat_unit(quat_mul(quat_exp(turn), s->pos.q));
    g->vel[0].w = vec3_mad(v->w, h, s->alpha);
    return true;
}

/* Is nothing near that was far, but what touched, and where it did? */
INLINE bool touches_as_before(const Glide *s)
{
    const GroupManifold *m = &s->c->manifold;
    real off = SAME * s->g->member[0].outer;
    bool same = s->c->live && m->count == s->count && vec3_distance(m->normal, s->normal) <= SAME;
    for (int k = 0; k < s->count && same; k++) {
        const ManifoldPoint *p = &m->points[k];
        same = p->feature == s->feature[k] && closed(s, p->gap) && vec3_distance(vec3_sub(own_point(s, p), s->g->pos[0].x), s->lever[k]) <= off;
    }
    return same;
}

/* Does what the fixed thing below covers reach no higher than that? The next tile does not. The next plank of a trough does, or a hump that is
 * sunk in the floor: there a ball gets to a place of it that nobody watches. */
static bool lies_below(const Glide *s, const GroupPair *q)
{
    bool on_b = q->a == 0;
    const Shape *shape = on_b ? &q->on_b->shape : &q->on_a->shape;
    if (!shape->type->convex)
        return false;
    pose at = group_shape_pose(s->g, on_b ? q->b : q->a, pair_local(q, on_b));
    vec3 up = vec3_scale(s->side, s->normal), high = pose_point(at, shape->type->support(shape, quat_unrotate(at.q, up)));
    return closed(s, real_max(0, vec3_dot(up, vec3_sub(high, own_point(s, &s->points[0]))) + shape->round));
}

/* Pairs without a point stay so in this frame, or they are the tracer's. */
INLINE bool others_stay_away(const Glide *s)
{
    Group *g = s->g;
    for (int i = 0; i < g->pair_count; i++) {
        GroupPair *q = &g->pairs[i];
        if (q == s->q)
            continue;
        group_touch_pair(g, q, s->h);
        if (g->contacts[q->contact].live || (q->hidden && !lies_below(s, q)))
            return false;
    }
    return true;
}

INLINE void book(const Glide *s)
{
    Group *g = s->g;
    GroupContact *c = s->c;
    ContactRest *rest = contact_rest_of(g, c);
    Acted *acted = contact_acted(g, c);
    vec3 way = vec3_scale(0.5, vec3_add(s->slip, s->slip_end));
    for (int k = 0; k < s->count; k++) {
        const PointMemory *f = &s->force[k];
        real press = s->h * f->normal;
        vec3 drag = s->table ? vec3_scale(s->side / g->mass[0].im, s->gain) : vec3_scale(s->h, f->tangent);
        acted->impulse = vec3_add(acted->impulse, vec3_mad(drag, press, s->normal));
        acted->point_sum = vec3_mad(acted->point_sum, press, own_point(s, &c->manifold.points[k]));
        acted->point_weight += press;
        rest->lost -= s->h * vec3_dot(f->tangent, way);
        contact_memory(c)[k] = *f;
        contact_memory(c)[k].held = f->normal > 0 ? HELD_SUBSTEPS : 0;
        g->penetration = real_max(g->penetration, -c->manifold.points[k].gap);
    }
    acted->last = s->h;
    c->manifold.slides = s->slides;
    rest->rolling = vec3_zero();
    g->lost += rest->lost;
    g->work_in += s->table ? table_work(s) : 0;
    g->member[c->a].constrained = g->member[c->b].constrained = true;
}

/* As it was gathered. */
INLINE dig_status hand_on(const Glide *s, real h)
{
    Group *g = s->g;
    g->pos[0] = s->pos;
    g->vel[0] = s->vel;
    g->pos[s->table] = s->table_pos;
    g->h = h;
    g->evaluations = 0;
    s->c->live = true;
    s->c->manifold.count = s->count;
    s->c->manifold.normal = s->normal;
    for (int k = 0; k < s->count; k++)
        s->c->manifold.points[k] = s->points[k];
    for (int i = 0; i < g->pair_count; i++) {
        GroupContact *c = &g->contacts[g->pairs[i].contact];
        g->pairs[i].reach = 0;
        if (c != s->c) {
            c->live = false;
            c->manifold.count = 0;
        }
    }
    g->handed_on = true;
    return DIG_OK;
}

/* table: the member that carries it and moves, or 0. Compiled for each by itself, so that all of a Glide stays in registers. */
INLINE dig_status go_on(Group *g, GroupContact *c, real dt, int table)
{
    Tracer scales;              /* these alone of it: to clear the rest would cost more than to use it */
    Glide s;
    PointMemory memory[MANIFOLD_POINTS];
    real h = g->h;
    scales.g = s.g = g;
    s.scales = &scales;
    s.h = dt;
    s.c = c;
    s.q = &g->pairs[c->pair];
    s.side = c->b == 0 ? 1 : -1;
    s.table = table;
    s.table_pos = g->pos[s.table];
    trace_scales(&scales);
    g->h = 1e-14;               /* forces are those of this instant */
    look(&s);
    for (int k = 0; k < s.count; k++)
        memory[k] = s.force[k];
    DIG_TRY(group_forces(g));
    g->evaluations = 1;
    bool goes_on = (s.table ? rolls(&s) : balances(&s)) && others_stay_away(&s) && (s.table ? roll_on(&s) : move(&s));
    if (goes_on) {
        group_touch(g, dt, true);
        goes_on = touches_as_before(&s);
    }
    if (!goes_on) {
        hand_on(&s, h);
        for (int k = 0; k < s.count; k++)
            contact_memory(c)[k] = memory[k];
        return DIG_OK;
    }
    book(&s);
    trace_begin(&scales);
    g->substeps = 1;
    g->t = g->h = g->trace_step = dt;
    DIG_TRY(g->stage(g, STAGE_SETTLE));
    g->touch = 1e-7;
    return g->status;
}

static dig_status go_on_still(Group *g, GroupContact *c, real dt) { return go_on(g, c, dt, 0); }
static dig_status go_on_table(Group *g, GroupContact *c, real dt) { return go_on(g, c, dt, c->a + c->b); }     /* the one that glides is 0 */

static dig_status advance(Group *g, real dt)
{
    GroupContact *c = &g->contacts[only_contact(g)];
    return g->driven ? go_on_table(g, c, dt) : go_on_still(g, c, dt);
}

const Way way_glide = {.name = "glide", .tally = WAY_TRACED, .suits = suits, .advance = advance, .inertias = true};
