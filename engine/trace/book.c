/* trace/book.c - storage of a tracer, and what the world wants to know: impulses, work, what points remember. */
#include "trace/trace.h"

/* Not cleared: everything is written before it is read. Clearing took a quarter of a pendulum's frame. */
static void *get(Tracer *t, size_t count, size_t size) { return arena_alloc(t->g->arena, (count + 1) * size); }
#define GET(field, count) (t->field = get(t, (size_t)(count), sizeof *t->field))

/* Breadth first from a body with the fewest neighbours (Cuthill & McKee 1969). */
static void order_bodies(Tracer *t, int *queue)
{
    const Group *g = t->g;
    int n = g->moving_count, head = 0, tail = 0;
    int *degree = queue + n + 1;
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

static dig_status reserve_system(Tracer *t)
{
    const Group *g = t->g;
    System *s = &t->sys;
    s->capacity = int_min(g->plan->trace_rows, g->joint_count * 8 + t->touch_capacity * 6);
    size_t n = (size_t)s->capacity + 1;
    s->lines = get(t, n, sizeof *s->lines);
    s->a = arena_alloc(g->arena, n * n * sizeof *s->a);
    s->f = arena_alloc(g->arena, n * n * sizeof *s->f);
    s->b = get(t, n, sizeof *s->b);
    s->x = get(t, n, sizeof *s->x);
    s->r = get(t, n, sizeof *s->r);
    s->dx = get(t, n, sizeof *s->dx);
    s->first = get(t, n, sizeof *s->first);
    s->swap = get(t, n, sizeof *s->swap);
    return s->lines && s->a && s->f && s->b && s->x && s->r && s->dx && s->first && s->swap ? DIG_OK : DIG_E_MEMORY;
}

/* The points, rows and strikes of the shared impact solver. */
static dig_status reserve_impacts(Tracer *t)
{
    Group *g = t->g;
    g->point_capacity = t->touch_capacity;
    g->strike_capacity = g->plan->events + g->pair_count;
    g->points = get(t, (size_t)t->touch_capacity, sizeof *g->points);
    g->rolls = get(t, (size_t)g->contact_count, sizeof *g->rolls);
    g->blocks = get(t, (size_t)g->joint_count, sizeof *g->blocks);
    g->rows = get(t, (size_t)g->joint_count * JOINT_SLOTS, sizeof *g->rows);
    g->strikes = get(t, (size_t)g->strike_capacity, sizeof *g->strikes);
    return g->points && g->rolls && g->blocks && g->rows && g->strikes ? DIG_OK : DIG_E_MEMORY;
}

dig_status trace_reserve(Tracer *t)
{
    const Group *g = t->g;
    int n = g->moving_count, joints = g->joint_count;
    t->touch_capacity = g->contact_count * MANIFOLD_POINTS;
    int powers = 4 * t->touch_capacity + 6 * joints + g->push_count + 2;
    bool fine = GET(touch, t->touch_capacity) && GET(old_touch, t->touch_capacity) && GET(stops, joints * JOINT_SLOTS)
        && GET(holds, joints * JOINT_SLOTS) && GET(rows, joints * JOINT_SLOTS) && GET(row_count, joints) && GET(order, n)
        && GET(item, joints + t->touch_capacity) && GET(joint_force, joints * JOINT_SLOTS) && GET(acc0, n) && GET(torque0, n)
        && GET(acc, n) && GET(torque, n) && GET(alpha, n) && GET(spin0, n) && GET(alpha0, n) && GET(mover_start, g->body_count)
        && GET(y, n) && GET(y1, n) && GET(y2, n) && GET(sum, powers);
    for (int s = 0; s < STAGES && fine; s++)
        fine = GET(stage[s], n) && GET(quad[s], powers);
    int *queue = get(t, 2 * (size_t)n + 4, sizeof *queue);
    if (!fine || !queue)
        return DIG_E_MEMORY;
    memset(queue, 0, (2 * (size_t)n + 4) * sizeof *queue);
    memset(t->joint_force, 0, (size_t)(joints * JOINT_SLOTS) * sizeof *t->joint_force);
    memset(t->row_count, 0, (size_t)joints * sizeof *t->row_count);
    order_bodies(t, queue);
    DIG_TRY(reserve_system(t));
    return reserve_impacts(t);
}

/* ---- sums over the step ---- */

/* Means over the step: the quadrature of the pair is that of its positions; powers of a probed step are linear in time. */
void trace_mean(Tracer *t)
{
    static const real weight[STAGES] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84, 0};
    int n = 4 * t->touch_count + 6 * t->g->joint_count + t->g->push_count + 2;
    for (int i = 0; i < n; i++) {
        t->sum[i] = 0;
        if (t->probed)
            t->sum[i] = t->quad[0][i] + 0.5 * t->h / t->h_probe * (t->quad[STAGES - 1][i] - t->quad[0][i]);
        else
            for (int s = 0; s < STAGES; s++)
                t->sum[i] += weight[s] * t->quad[s][i];
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
    for (int i = 0; i < count; i++, q += 4) {
        const Touching *c = &touch[i];
        if (!(q[3] > 0))
            continue;
        GroupContact *to = &g->contacts[c->contact];
        to->impulse = vec3_mad(to->impulse, h, (vec3){q[0], q[1], q[2]});
        to->point_sum = vec3_mad(to->point_sum, h * q[3], c->k.at);
        to->point_weight += h * q[3];
        to->last = begin + h;
        wake_dormant(g, c->a);
        wake_dormant(g, c->b);
    }
    for (int j = 0; j < g->joint_count; j++, q += 6) {
        g->joints[j].impulse = vec3_mad(g->joints[j].impulse, h, (vec3){q[0], q[1], q[2]});
        g->joints[j].angular_impulse = vec3_mad(g->joints[j].angular_impulse, h, (vec3){q[3], q[4], q[5]});
    }
    for (int i = 0; i < g->push_count; i++, q++)
        g->push_work[g->pushes[i].body] += h * *q;
    g->lost += h * q[0];
    g->work_in += h * q[1];
    g->substeps++;
}

/* ---- at the end of the frame ---- */

void trace_remember(Tracer *t)
{
    Group *g = t->g;
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < MANIFOLD_POINTS; k++) {
            PointMemory *m = &g->contacts[i].memory[k];
            m->normal = 0;
            m->tangent = vec3_zero();
            m->held = 0;
        }
    for (int i = 0; i < t->touch_count; i++) {
        const Touching *c = &t->touch[i];
        GroupContact *to = &g->contacts[c->contact];
        if (!c->gate.presses)
            continue;
        to->memory[c->point].normal = real_max(c->gate.force, 0);
        to->memory[c->point].tangent = c->slip.force;
        to->memory[c->point].held = c->gate.force > 0 ? HELD_SUBSTEPS : 0;
        to->sliding = c->slip.axes && c->slip.grip == GRIP_SLIP;
        to->rolling = c->roll.force;
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
