/* trace/book.c - storage of a tracer, and what the world wants to know: impulses, work, what points remember. */
#include "math/pair.h"
#include "trace/trace.h"

/* One block for all, laid out where the next piece is expected, and again where it was not. Not cleared: everything is written before
 * it is read. Clearing took a quarter of a pendulum's frame, and a block for each array a tenth. */
typedef struct Block { unsigned char *data; size_t used; } Block;

static inline void *take(Block *b, int count, size_t size)
{
    void *at = b->data ? b->data + b->used : NULL;
    b->used += ((size_t)(count + 1) * size + ARENA_ALIGN - 1) & ~(size_t)(ARENA_ALIGN - 1);
    return at;
}
#define TAKE(of, field, count) ((of)->field = take(b, count, sizeof *(of)->field))

/* Breadth first from a body with the fewest neighbours (Cuthill & McKee 1969). */
static void order_bodies(Tracer *t, int *queue)
{
    const Group *g = t->g;
    int n = g->moving_count, head = 0, tail = 0;
    int *degree = queue + n + 1;
    if (n == 1) {
        t->order[0] = 0;
        return;
    }
    memset(queue, 0, (2 * (size_t)n + 4) * sizeof *queue);
    for (int i = 0; i < n; i++)
        t->order[i] = -1;
    for (int j = 0; j < g->joint_count; j++)
        for (int k = 0; k < 2; k++) {
            int b = k ? g->joints[j].b : g->joints[j].a;
            degree[b >= 0 && b < n ? b : n] += (k ? g->joints[j].a : g->joints[j].b) < n;
        }
    for (int p = 0; p < g->pair_count; p++) {
        degree[int_min(g->pairs[p].a, n)] += g->pairs[p].b < n;
        degree[int_min(g->pairs[p].b, n)] += g->pairs[p].a < n;
    }
    while (tail < n) {
        int start = -1;
        for (int i = 0; i < n; i++)
            if (t->order[i] < 0 && (start < 0 || degree[i] < degree[start]))
                start = i;
        t->order[start] = tail;
        queue[tail++] = start;
        for (; head < tail; head++) {
            int body = queue[head];
            for (int j = 0; j < g->joint_count + g->pair_count; j++) {
                int a = j < g->joint_count ? g->joints[j].a : g->pairs[j - g->joint_count].a;
                int b = j < g->joint_count ? g->joints[j].b : g->pairs[j - g->joint_count].b;
                int other = a == body ? b : b == body ? a : -1;
                if (other >= 0 && other < n && t->order[other] < 0) {
                    t->order[other] = tail;
                    queue[tail++] = other;
                }
            }
        }
    }
}

static void lay_out_system(Tracer *t, Block *b)
{
    System *s = &t->sys;
    int n = s->capacity;
    TAKE(s, lines, n);
    TAKE(s, a, n * n);
    TAKE(s, f, n * n);
    TAKE(s, b, n);
    TAKE(s, x, n);
    TAKE(s, r, n);
    TAKE(s, dx, n);
    TAKE(s, first, n);
    TAKE(s, swap, n);
    TAKE(s, run, n);
}

/* The points and rows of the shared impact solver. */
static void lay_out_impacts(const Tracer *t, Block *b)
{
    Group *g = t->g;
    TAKE(g, points, t->touch_capacity);
    TAKE(g, rolls, g->contact_count);
    TAKE(g, blocks, g->joint_count);
    TAKE(g, rows, g->joint_count * JOINT_SLOTS);
}

static void lay_out(Tracer *t, Block *b)
{
    const Group *g = t->g;
    int n = g->moving_count, joints = g->joint_count, powers = TOUCH_POWERS * t->touch_capacity + JOINT_POWERS * joints + g->push_count + 3;
    TAKE(t, touch, t->touch_capacity);
    TAKE(t, old_touch, t->touch_capacity);
    TAKE(t, footing, t->touch_capacity);
    TAKE(t, noted_q, n);
    TAKE(t, stops, joints * JOINT_SLOTS);
    TAKE(t, holds, joints * JOINT_SLOTS);
    TAKE(t, bonds, joints);
    TAKE(t, rows, joints * JOINT_SLOTS);
    TAKE(t, row_count, joints);
    TAKE(t, unwound, joints);
    TAKE(t, order, n);
    TAKE(t, item, joints + t->touch_capacity);
    TAKE(t, joint_force, joints * JOINT_SLOTS);
    TAKE(t, acc0, n);
    TAKE(t, torque0, n);
    TAKE(t, pull, n);
    TAKE(t, twist, n);
    TAKE(t, acc, n);
    TAKE(t, torque, n);
    TAKE(t, alpha, n);
    TAKE(t, spin_l, n);
    TAKE(t, spin0, n);
    TAKE(t, alpha0, n);
    TAKE(t, mover_start, g->body_count);
    TAKE(t, root, n + 1);
    TAKE(t, held, n + 1);
    TAKE(t, anchor, n + 1);
    TAKE(t, gain, n);
    TAKE(t, motion, n);
    TAKE(t, y, n);
    TAKE(t, y1, n);
    TAKE(t, y2, n);
    TAKE(t, kept, n);
    TAKE(t, sum, powers);
    for (int s = 0; s < STAGES; s++) {
        TAKE(t, stage[s], n);
        TAKE(t, quad[s], powers);
    }
    lay_out_system(t, b);
    lay_out_impacts(t, b);
}

dig_status trace_reserve(Tracer *t)
{
    Group *g = t->g;
    int n = g->moving_count, joints = g->joint_count;
    t->touch_capacity = g->point_capacity = g->contact_count * MANIFOLD_POINTS;
    t->sys.capacity = int_min(g->plan->trace_rows, joints * 8 + t->touch_capacity * 6);
    g->strikes_most = g->plan->events + g->pair_count;
    int *queue = arena_alloc(g->arena, (2 * (size_t)n + 4) * sizeof *queue);
    Block b = {arena_next(g->arena), 0};
    lay_out(t, &b);
    unsigned char *data = arena_alloc(g->arena, b.used);
    if (!data || !queue)
        return DIG_E_MEMORY;
    if (data != b.data) {
        b = (Block){data, 0};
        lay_out(t, &b);
    }
    memset(t->joint_force, 0, (size_t)(joints * JOINT_SLOTS) * sizeof *t->joint_force);
    memset(t->row_count, 0, (size_t)joints * sizeof *t->row_count);
    order_bodies(t, queue);
    return DIG_OK;
}

/* ---- sums over the step ---- */

/* Of one of them up to a part of the step, by the dense output. whole: over all of it */
static real mean_up_to(const Tracer *t, int i, real whole)
{
    real first = t->quad[0][i] - whole, last = whole - t->quad[STAGES - 1][i] - first, rest = 1 - t->part, high = 0;
    for (int s = 0; s < STAGES; s++)
        high += s == 1 ? 0 : dormand_prince_dense[s] * t->quad[s][i];
    return whole + rest * (first + t->part * (last + rest * high));
}

/* Means over the step: the quadrature of the pair is that of its positions; powers of a probed step are linear in time. */
void trace_mean(Tracer *t)
{
    int n = trace_powers(t);
    const real *first = t->quad[0], *last = t->quad[STAGES - 1], *weight = dormand_prince[STAGES - 1];
    real part = 0.5 * t->h / t->h_probe;
    for (int i = 0; i < n && t->probed; i++)
        t->sum[i] = first[i] + part * (last[i] - first[i]);
    for (int i = 0; i < n && !t->probed; i++) {
        real sum = weight[0] * first[i];
        UNROLL
        for (int s = 2; s < STAGES - 1; s++)
            sum += weight[s] * t->quad[s][i];
        t->sum[i] = t->part < 1 ? mean_up_to(t, i, sum) : sum;
    }
}

static void wake_dormant(Group *g, int body)
{
    if (g->member[body].dormant)
        g->member[body].pushed = g->woke = true;
}

void trace_book(Tracer *t, const Touching *touch, int count, real begin)
{
    Group *g = t->g;
    real h = t->h;
    const real *q = t->sum;
    for (int i = 0; i < count; i++, q += TOUCH_POWERS) {
        const Touching *c = &touch[i];
        if (!(q[3] > 0))
            continue;
        GroupContact *to = &g->contacts[c->contact];
        Acted *acted = contact_acted(g, to);
        acted->impulse = vec3_mad(acted->impulse, h, (vec3){q[0], q[1], q[2]});
        acted->point_sum = vec3_mad(acted->point_sum, h * q[3], c->k.at);
        acted->point_weight += h * q[3];
        acted->last = begin + h;
        contact_rest_of(g, to)->lost += h * q[4];
        wake_dormant(g, c->a);
        wake_dormant(g, c->b);
    }
    for (int j = 0; j < g->joint_count; j++, q += JOINT_POWERS) {
        g->joints[j].lost += h * q[6];
        g->joints[j].impulse = vec3_mad(g->joints[j].impulse, h, (vec3){q[0], q[1], q[2]});
        g->joints[j].angular_impulse = vec3_mad(g->joints[j].angular_impulse, h, (vec3){q[3], q[4], q[5]});
    }
    for (int i = 0; i < g->push_count; i++, q++)
        g->member[g->pushes[i].body].push_work += g->pushes[i].law ? 0 : h * *q;
    g->lost += h * q[0];
    g->work_in += h * q[1];
    g->law += h * q[2];
    g->substeps++;
}

/* ---- at the end of the frame ---- */

void trace_remember(Tracer *t)
{
    Group *g = t->g;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < g->contacts[i].manifold.room; k++) {
            PointMemory *m = &contact_memory(&g->contacts[i])[k];
            m->normal = 0;
            m->tangent = vec3_zero();
            m->held = 0;
        }
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        GroupContact *to = &g->contacts[c->contact];
        if (!c->gate.presses)
            continue;
        contact_memory(to)[c->point].normal = real_max(c->gate.force, 0);
        contact_memory(to)[c->point].tangent = c->slip.force;
        contact_memory(to)[c->point].held = c->gate.force > 0 ? HELD_SUBSTEPS : 0;
        to->manifold.slides = c->slip.axes && c->slip.grip == GRIP_SLIP;
        contact_rest_of(g, to)->rolling = c->roll.force;
    }
}

static void mark_members(Tracer *t)
{
    Group *g = t->g;
    for (int i = 0; i < t->touch_count; i++)
        if (t->touch[i].gate.presses)
            g->member[t->touch[i].a].constrained = g->member[t->touch[i].b].constrained = true;
    for (int j = 0; j < g->joint_count; j++)
        for (int k = 0; k < 2; k++) {
            int b = k ? g->joints[j].b : g->joints[j].a;
            if (b >= 0)
                g->member[b].constrained = true;
        }
}

void trace_finish(Tracer *t)
{
    Group *g = t->g;
    trace_remember(t);
    mark_members(t);
    for (int j = 0; j < g->joint_count; j++) {
        memcpy(g->joints[j].force, &t->joint_force[j * JOINT_SLOTS], sizeof g->joints[j].force);
        for (int k = 0; k < t->row_count[j]; k++) {
            const Row *r = &t->rows[j * JOINT_SLOTS + k];
            if (r->kind == ROW_HARD)
                g->joint_error = real_max(g->joint_error, fabs(r->error));
        }
    }
    for (int i = 0; i < t->touch_count; i++)
        g->penetration = real_max(g->penetration, -t->touch[i].gate.gap);
}
