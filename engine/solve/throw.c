/* solve/throw.c - what springs and motors may do to their bodies within a step: who looks for contacts ahead is to know.
 *
 * A spring that holds still now swings through with what it stores, a motor gets to its speed: a row of stiffness k, off by e, against the
 * mobility u of its ends gives them the rate min(sqrt(k u), k u t) e within t seconds, and moves them by 2 e at most.
 */
#include "solve/group.h"

/* 1/kg or 1/(kg m^2)  Rate per impulse of the end at the row's k-th body, and what its fastest point gains, m/s per N s or N m s. */
static real give_of(const Group *g, const Row *r, int k, real *fastest)
{
    const Member *m = r->body[k] < 0 ? NULL : &g->member[r->body[k]];
    *fastest = 0;
    if (!m || !m->moves)
        return 0;
    vec3 ang = quat_unrotate(g->pos[r->body[k]].q, r->ang[k]), turn = mat3_mul_vec(*m->inv_inertia, ang);
    *fastest = m->im * vec3_length(r->lin[k]) + m->outer * vec3_length(turn);
    return m->im * vec3_length2(r->lin[k]) + vec3_dot(ang, turn);
}

static real rate_of(const Group *g, const Row *r)
{
    real rate = 0;
    for (int k = 0; k < r->count; k++)
        if (r->body[k] >= 0)
            rate += vec3_dot(r->lin[k], g->vel[r->body[k]].v) + vec3_dot(r->ang[k], g->vel[r->body[k]].w);
    return rate;
}

static void throw_by(Group *g, const Row *r, real time)
{
    real mobility = 0, fastest[ROW_BODIES];
    if (r->kind != ROW_SOFT && r->kind != ROW_MOTOR)
        return;
    for (int k = 0; k < r->count; k++)
        mobility += give_of(g, r, k, &fastest[k]);
    if (!(mobility > 0))
        return;
    bool soft = r->kind == ROW_SOFT;
    real off = fabs(r->error), rate = soft ? off * real_min(sqrt(r->stiffness * mobility), r->stiffness * mobility * time)
                                           : real_min(fabs(r->rate - rate_of(g, r)), mobility * r->hi * time);
    real far = soft ? real_min(rate * time, 2 * off) : rate * time;
    for (int k = 0; k < r->count; k++) {
        Member *m = r->body[k] < 0 ? NULL : &g->member[r->body[k]];
        if (!m || !m->moves)
            continue;
        m->thrown += rate / mobility * fastest[k];
        m->thrown_far += far / mobility * fastest[k];
    }
}

/* Can nothing but what holds it act at the joint? */
static bool plain(const JointView *j)
{
    return (j->type->only_point && j->type->only_point(j->params)) || (j->type->loose && j->type->loose(j->params));
}

static void throw_all(Group *g)
{
    for (int i = 0; i < g->joint_count; i++) {
        GroupJoint *j = &g->joints[i];
        if (plain(&j->view))
            continue;
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        real memory[JOINT_MEMORY];
        group_joint_view(g, i);
        memcpy(memory, j->memory, sizeof memory);
        JointView now = j->view;
        now.memory = memory;
        now.type->rows(&now, &list);
        for (int k = 0; k < list.count; k++)
            throw_by(g, &rows[k], g->world->def.step);
    }
}

/* What hangs on what is thrown goes as far. */
static void spread(Group *g)
{
    bool more = g->joint_count > 1;
    while (more) {
        more = false;
        for (int i = 0; i < g->joint_count; i++) {
            const GroupJoint *j = &g->joints[i];
            Member *a = j->a < 0 ? NULL : &g->member[j->a], *b = j->b < 0 ? NULL : &g->member[j->b];
            if (!a || !b || !a->moves || !b->moves || (a->thrown == b->thrown && a->thrown_far == b->thrown_far))
                continue;
            a->thrown = b->thrown = real_max(a->thrown, b->thrown);
            a->thrown_far = b->thrown_far = real_max(a->thrown_far, b->thrown_far);
            more = true;
        }
    }
}

static Bulk bulk_of(const Group *g)
{
    Bulk bulk = {0, 0, 0};
    box3 all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!(m->im > 0))
            continue;
        all = box3_union(all, box3_grow((box3){g->pos[i].x, g->pos[i].x}, m->outer));
        bulk.mass += 1 / m->im;
        bulk.load += (m->pull + m->thrown / g->world->def.step) / m->im;
    }
    if (bulk.mass > 0)
        bulk.size = 0.5 * vec3_distance(all.low, all.high);
    return bulk;
}

void group_find_throws(Group *g)
{
    if (!g->crowd)
        throw_all(g);
    spread(g);
    if (g->joint_count > 0)
        g->bulk = bulk_of(g);
}
