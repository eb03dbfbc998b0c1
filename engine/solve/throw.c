/* solve/throw.c - what springs and motors may do to their bodies within a step: who looks for contacts ahead is to know.
 *
 * A spring that holds still now swings through with what it stores, a motor gets to its speed: a row of stiffness k, off by e, against the
 * mobility u of its ends gives them the rate min(sqrt(k u), k u t) e within t seconds, and moves them by 2 e at most.
 */
#include "base/forest.h"
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

/* m/s or rad/s, and m or rad: by so much may the row change its rate, and itself. mobility: 1/kg or 1/(kg m^2) of its ends. */
static Throw throw_of(const Group *g, const Row *r, real mobility, real time)
{
    if (r->kind == ROW_MOTOR) {
        real rate = real_min(fabs(r->rate - group_row_rate(g, r)), mobility * r->hi * time);
        return (Throw){rate, rate * time};
    }
    real off = fabs(r->error), rate = off * real_min(sqrt(r->stiffness * mobility), r->stiffness * mobility * time);
    return (Throw){rate, real_min(rate * time, 2 * off)};
}

static bool open_throws(Group *g)
{
    if (!g->throws)
        g->throws = arena_zero(g->lasting, (size_t)g->body_count * sizeof *g->throws);
    g->no_room = g->no_room || !g->throws;
    return g->throws;
}

static void throw_by(Group *g, const Row *r, real time)
{
    real mobility = 0, fastest[ROW_BODIES];
    for (int k = 0; k < r->count; k++)
        mobility += give_of(g, r, k, &fastest[k]);
    if (!(mobility > 0) || !open_throws(g))
        return;
    Throw most = throw_of(g, r, mobility, time);
    for (int k = 0; k < r->count; k++) {
        if (r->body[k] < 0 || !g->member[r->body[k]].moves)
            continue;
        Throw *t = &g->throws[r->body[k]];
        t->rate += most.rate / mobility * fastest[k];
        t->far += most.far / mobility * fastest[k];
    }
}

#define LAGS 1e-2               /* of the speed wanted, or of that it has */
#define STILL 1e-6              /* m/s or rad/s: of one that brakes */

/* It pushed in the last step, and is not at its speed. One that has not pushed yet gets there by a blow. */
static bool lags(const Group *g, const GroupJoint *j, const Row *r)
{
    real now = group_row_rate(g, r);
    return j->force[r->slot] != 0 && fabs(r->rate - now) > real_max(STILL, LAGS * real_max(fabs(r->rate), fabs(now)));
}

/* Can nothing but what holds it act at the joint? */
static bool plain(const JointView *j)
{
    return joint_plain(j->type, j->params) || (j->type->loose && j->type->loose(j->params));
}

/* The rows of a joint as it stands; what it remembers stays as it is. Returns how many there are. */
static int rows_now(Group *g, int joint, Row rows[JOINT_SLOTS])
{
    RowList list = {rows, 0, JOINT_SLOTS};
    real memory[JOINT_MEMORY];
    group_joint_view(g, joint);
    JointView now = g->joints[joint].view;
    memcpy(memory, g->joints[joint].memory, sizeof memory);
    now.memory = memory;
    now.type->rows(&now, &list);
    return list.count;
}

static void throw_all(Group *g)
{
    for (int i = 0; i < g->joint_count; i++) {
        GroupJoint *j = &g->joints[i];
        Row rows[JOINT_SLOTS];
        int count = plain(&j->view) ? 0 : rows_now(g, i, rows);
        for (int k = 0; k < count; k++) {
            if (rows[k].kind == ROW_SOFT || rows[k].kind == ROW_MOTOR)
                throw_by(g, &rows[k], g->world->def.step);
            j->lags = j->lags || (rows[k].kind == ROW_MOTOR && isinf(rows[k].hi) && lags(g, j, &rows[k]));
        }
    }
}

static bool share(const Group *g, int joint)
{
    const GroupJoint *j = &g->joints[joint];
    if (j->a < 0 || j->b < 0 || !g->member[j->a].moves || !g->member[j->b].moves)
        return false;
    Throw *a = &g->throws[j->a], *b = &g->throws[j->b];
    if (a->rate == b->rate && a->far == b->far)
        return false;
    *a = *b = (Throw){real_max(a->rate, b->rate), real_max(a->far, b->far)};
    return true;
}

/* What hangs on what is thrown goes as far. To and fro: a chain is done in two passes, whichever way it was built. */
static void spread(const Group *g)
{
    for (bool more = g->throws && g->joint_count > 1, back = false; more; back = !back) {
        more = false;
        for (int i = 0; i < g->joint_count; i++)
            more = share(g, back ? g->joint_count - 1 - i : i) || more;
    }
}

void group_find_throws(Group *g)
{
    bool lags = false;
    g->throws_found = true;
    throw_all(g);
    spread(g);
    for (int i = 0; i < g->joint_count; i++)
        lags = lags || g->joints[i].lags;
    if (lags)
        group_find_bulk(g);
}

void group_find_bulk(Group *g)
{
    if (g->bulk.found)
        return;
    g->bulk.found = true;           /* first: the throws ask for it, too */
    if (!g->throws_found)
        group_find_throws(g);
    box3 all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!(m->im > 0))
            continue;
        all = box3_union(all, box3_grow((box3){g->pos[i].x, g->pos[i].x}, m->outer));
        g->bulk.mass += 1 / m->im;
        g->bulk.load += (m->pull + (g->throws ? g->throws[i].rate : 0) / g->world->def.step) / m->im;
    }
    if (g->bulk.mass > 0)
        g->bulk.size = 0.5 * vec3_distance(all.low, all.high);
}

static int end_of(const Group *g, int body) { return body >= 0 && body < g->moving_count && g->member[body].moves ? body : g->moving_count; }

static bool holds(const JointView *j)
{
    return j->type->free_axes < 6 && !j->type->couples && !(j->type->only_limits && j->type->only_limits(j->params));
}

bool group_in_loop(Group *g, int joint)
{
    ArenaMark mark = arena_mark(g->arena);
    int *parent = arena_alloc(g->arena, (size_t)(g->moving_count + 1) * sizeof *parent);
    for (int i = 0; i <= g->moving_count && parent; i++)
        parent[i] = i;
    for (int i = 0; i < g->joint_count && parent; i++)
        if (i != joint && !g->joints[i].broken && holds(&g->joints[i].view))
            forest_unite(parent, end_of(g, g->joints[i].a), end_of(g, g->joints[i].b));
    if (!parent)
        g->status = DIG_E_MEMORY;
    bool looped = parent && forest_root(parent, end_of(g, g->joints[joint].a)) == forest_root(parent, end_of(g, g->joints[joint].b));
    arena_rewind(g->arena, mark);
    return looped;
}

/* Of motors without a bound that drive, and do not only brake. */
void group_find_loops(Group *g)
{
    bool any = false;
    for (int i = 0; i < g->joint_count; i++) {
        GroupJoint *j = &g->joints[i];
        Row rows[JOINT_SLOTS];
        int count = j->broken || plain(&j->view) ? 0 : rows_now(g, i, rows);
        bool firm = false;
        for (int k = 0; k < count; k++)
            firm = firm || (rows[k].kind == ROW_MOTOR && isinf(rows[k].hi) && rows[k].rate != 0);
        j->looped = firm && group_in_loop(g, i);
        any = any || j->looped;
    }
    if (any)
        group_find_bulk(g);
}

bool group_motors_yield(Group *g)
{
    bool any = false;
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count; k++) {
            const Row *r = &g->rows[g->blocks[i].first + k].row;
            GroupJoint *j = &g->joints[g->blocks[i].joint];
            if (r->kind == ROW_MOTOR && isinf(r->hi) && !j->lags)
                j->lags = any = true;
        }
    if (any)
        group_find_bulk(g);
    return any;
}
