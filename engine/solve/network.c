/* solve/network.c - parts, Newton's iteration, and the two rules of time. */
#include "solve/network.h"

#define ITERATIONS 60
#define CONVERGED 1e-11         /* 1  of the largest effort: Newton squares it in the next round */

/* ---- memory and parts ---- */

static real *reals(Arena *arena, int count, dig_status *s)
{
    real *x = arena_zero(arena, ((size_t)count + 1) * sizeof *x);
    *s = x ? *s : DIG_E_MEMORY;
    return x;
}

static int *ints(Arena *arena, int count, dig_status *s)
{
    int *x = arena_zero(arena, ((size_t)count + 1) * sizeof *x);
    *s = x ? *s : DIG_E_MEMORY;
    return x;
}

dig_status network_open(Network *n, Arena *arena, int nodes, int boundaries, int branches)
{
    dig_status s = DIG_OK;
    *n = (Network){.nodes = nodes, .boundaries = boundaries, .branches = branches};
    n->effort = reals(arena, nodes + boundaries, &s);
    real **const of_nodes[] = {&n->capacity, &n->source, &n->start, &n->extra, &n->rest, &n->rate[0], &n->rate[1], &n->rate[2],
                                &n->change, &n->work[0], &n->work[1], &n->work[2], &n->work[3]};
    for (size_t i = 0; i < sizeof of_nodes / sizeof *of_nodes; i++)
        *of_nodes[i] = reals(arena, nodes, &s);
    for (int i = 0; i < 3; i++)
        n->flow[i] = reals(arena, branches, &s);
    n->member = ints(arena, nodes, &s);
    n->place = ints(arena, nodes, &s);
    n->order = ints(arena, branches, &s);
    n->value = ints(arena, branches, &s);
    n->branch = arena_zero(arena, ((size_t)branches + 1) * sizeof *n->branch);
    n->part = arena_zero(arena, ((size_t)nodes + 1) * sizeof *n->part);
    return n->branch && n->part ? s : DIG_E_MEMORY;
}

static int root(int *parent, int i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

static bool inner(const Network *n, const NetBranch *b) { return b->a < n->nodes && b->b < n->nodes; }

/* The part of a branch: that of an end that is no boundary; -1 between boundaries. */
static int part_of(const Network *n, const int *part, const NetBranch *b)
{
    return b->a < n->nodes ? part[b->a] : b->b < n->nodes ? part[b->b] : -1;
}

/* Numbers the parts by their first nodes: part[node]. */
static void number_parts(Network *n, int *part)
{
    for (int i = 0; i < n->nodes; i++)
        part[i] = i;
    for (int i = 0; i < n->branches; i++)
        if (inner(n, &n->branch[i])) {
            int a = root(part, n->branch[i].a), b = root(part, n->branch[i].b);
            part[int_max(a, b)] = int_min(a, b);
        }
    n->parts = 0;
    for (int i = 0; i < n->nodes; i++) {            /* a root comes before all it stands for */
        int r = root(part, i);
        n->place[i] = r == i ? n->parts++ : n->place[r];
    }
    for (int i = 0; i < n->nodes; i++) {
        part[i] = n->place[i];
        n->part[part[i]].nodes++;
    }
}

static void sort_parts(Network *n, const int *part)
{
    int nodes = 0, branches = 0;
    for (int i = 0; i < n->branches; i++) {
        int p = part_of(n, part, &n->branch[i]);
        if (p >= 0) {
            n->part[p].branches++;
            n->part[p].bent = n->part[p].bent || n->branch[i].law;
        }
    }
    for (int p = 0; p < n->parts; p++) {
        n->part[p].node = nodes;
        n->part[p].branch = branches;
        nodes += n->part[p].nodes;
        branches += n->part[p].branches;
        n->part[p].nodes = n->part[p].branches = 0;
    }
    for (int i = 0; i < n->nodes; i++) {
        NetPart *p = &n->part[part[i]];
        n->place[i] = p->nodes;
        n->member[p->node + p->nodes++] = i;
    }
    for (int i = 0; i < n->branches; i++) {
        int k = part_of(n, part, &n->branch[i]);
        if (k >= 0)
            n->order[n->part[k].branch + n->part[k].branches++] = i;
    }
}

static dig_status plan_part(Network *n, Arena *arena, NetPart *p, int *link)
{
    int links = 0;
    p->swept = n->direct > 0 && p->nodes > n->direct;
    if (p->swept)
        return DIG_OK;
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        if (inner(n, b) && b->a != b->b) {
            link[2 * links] = n->place[b->a];
            link[2 * links++ + 1] = n->place[b->b];
        }
    }
    if (!ldl_plan(&p->matrix, arena, p->nodes, link, links))
        return DIG_E_MEMORY;
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        n->value[n->order[i]] = inner(n, b) && b->a != b->b ? ldl_find(&p->matrix, n->place[b->a], n->place[b->b]) : -1;
    }
    return DIG_OK;
}

dig_status network_plan(Network *n, Arena *arena)
{
    dig_status s = DIG_OK;
    int *part = ints(arena, n->nodes, &s), *link = ints(arena, 2 * n->branches, &s);
    DIG_TRY(s);
    number_parts(n, part);
    sort_parts(n, part);
    for (int p = 0; p < n->parts; p++)
        DIG_TRY(plan_part(n, arena, &n->part[p], link));
    return DIG_OK;
}

/* ---- one implicit solve ---- */

static real line_flow(const Network *n, const NetBranch *b)
{
    return b->line.g * (n->effort[b->a] - n->effort[b->b]) + b->line.i0;
}

static void find_lines(Network *n, const NetPart *p, real h)
{
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        NetBranch *b = &n->branch[n->order[i]];
        if (b->law)
            b->line = b->law(b, n->effort[b->a], n->effort[b->b], h);
    }
}

/* What flows into each node, and along each branch. */
static void find_rates(Network *n, const NetPart *p, int stage)
{
    for (int i = p->node; i < p->node + p->nodes; i++)
        n->rate[stage][n->member[i]] = n->source[n->member[i]];
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        real flow = n->flow[stage][n->order[i]] = line_flow(n, b);
        if (b->a < n->nodes)
            n->rate[stage][b->a] -= flow;
        if (b->b < n->nodes)
            n->rate[stage][b->b] += flow;
    }
}

static void assemble(const Network *n, NetPart *p, real alpha)
{
    ldl_clear(&p->matrix);
    for (int i = p->node; i < p->node + p->nodes; i++)
        *ldl_diagonal(&p->matrix, n->place[n->member[i]]) += alpha * n->capacity[n->member[i]];
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        if (b->a == b->b)
            continue;
        if (b->a < n->nodes)
            *ldl_diagonal(&p->matrix, n->place[b->a]) += b->line.g;
        if (b->b < n->nodes)
            *ldl_diagonal(&p->matrix, n->place[b->b]) += b->line.g;
        if (n->value[n->order[i]] >= 0)
            p->matrix.below[n->value[n->order[i]]] -= b->line.g;
    }
}

/* y = A x by places, branch by branch */
static void multiply(const Network *n, const NetPart *p, real alpha, const real *x, real *y)
{
    for (int i = 0; i < p->nodes; i++)
        y[i] = alpha * n->capacity[n->member[p->node + i]] * x[i];
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        int a = b->a < n->nodes ? n->place[b->a] : -1, c = b->b < n->nodes ? n->place[b->b] : -1;
        real flow = b->line.g * ((a >= 0 ? x[a] : 0) - (c >= 0 ? x[c] : 0));
        if (a >= 0)
            y[a] += flow;
        if (c >= 0)
            y[c] -= flow;
    }
}

static void find_diagonal(const Network *n, const NetPart *p, real alpha, real *diagonal)
{
    for (int i = 0; i < p->nodes; i++)
        diagonal[i] = alpha * n->capacity[n->member[p->node + i]];
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        const NetBranch *b = &n->branch[n->order[i]];
        if (b->a < n->nodes && b->a != b->b)
            diagonal[n->place[b->a]] += b->line.g;
        if (b->b < n->nodes && b->a != b->b)
            diagonal[n->place[b->b]] += b->line.g;
    }
}

#define SWEPT 1e-14             /* 1  of the right side, in the norm of the preconditioner */

/* Hestenes & Stiefel 1952, each unknown scaled by its diagonal. b -> x. */
static bool conjugate(const Network *n, const NetPart *p, real alpha, real *x)
{
    real *diagonal = n->work[0], *r = n->work[1], *d = n->work[2], *image = n->work[3], rho = 0;
    find_diagonal(n, p, alpha, diagonal);
    for (int i = 0; i < p->nodes; i++) {
        if (!(diagonal[i] > 0))
            return false;
        r[i] = x[i];
        x[i] = 0;
        d[i] = r[i] / diagonal[i];
        rho += r[i] * d[i];
    }
    real first = rho;
    for (int round = 0; round < 4 * p->nodes + 50 && rho > SWEPT * SWEPT * first; round++) {
        real bend = 0, next = 0;
        multiply(n, p, alpha, d, image);
        for (int i = 0; i < p->nodes; i++)
            bend += d[i] * image[i];
        if (!(bend > 0))
            return false;
        for (int i = 0; i < p->nodes; i++) {
            x[i] += rho / bend * d[i];
            r[i] -= rho / bend * image[i];
            next += r[i] * r[i] / diagonal[i];
        }
        for (int i = 0; i < p->nodes; i++)
            d[i] = r[i] / diagonal[i] + next / rho * d[i];
        rho = next;
    }
    return rho <= 1e-16 * first;        /* enough, if not all: the books are kept by the flows */
}

/* Of the lines as they are; again: of the same matrix as the last time. b -> x, by places. */
static bool solve_lines(Network *n, NetPart *p, real alpha, bool again, real *x)
{
    if (p->swept)
        return conjugate(n, p, alpha, x);
    if (!again) {
        assemble(n, p, alpha);
        if (!ldl_factor(&p->matrix))
            return false;
    }
    ldl_solve(&p->matrix, x);
    return true;
}

/* alpha C (x - rest) = extra + flows in(x), which are left in rate[stage]. False: no solution. */
static bool solve(Network *n, NetPart *p, real alpha, real h, int stage)
{
    real *change = n->change;           /* by place */
    for (int round = 0; round < ITERATIONS; round++) {
        real most = 0, size = 0;
        find_lines(n, p, h);
        find_rates(n, p, stage);
        for (int i = 0; i < p->nodes; i++) {
            int k = n->member[p->node + i];
            change[i] = n->extra[k] + n->rate[stage][k] - alpha * n->capacity[k] * (n->effort[k] - n->rest[k]);
        }
        if (!solve_lines(n, p, alpha, false, change))
            return false;
        for (int i = 0; i < p->nodes; i++) {
            int k = n->member[p->node + i];
            n->effort[k] += change[i];
            most = real_max(most, fabs(change[i]));
            size = real_max(size, fabs(n->effort[k]));
            if (!isfinite(n->effort[k]))
                return false;
        }
        n->iterations++;
        if (!p->bent || most <= CONVERGED * size) {
            find_rates(n, p, stage);    /* of the lines that the balance holds for */
            return true;
        }
    }
    return false;
}

/* ---- the rules of time ---- */

static void keep(const Network *n, const NetPart *p, const real *from, real *to)
{
    for (int i = p->node; i < p->node + p->nodes; i++)
        to[n->member[i]] = from[n->member[i]];
}

static void book(Network *n, const NetPart *p, real h, const real weight[3])
{
    for (int i = p->branch; i < p->branch + p->branches; i++) {
        int k = n->order[i];
        for (int s = 0; s < 3; s++)
            n->branch[k].through += weight[s] != 0 ? h * weight[s] * n->flow[s][k] : 0;
    }
}

static bool euler(Network *n, NetPart *p, real h)
{
    for (int i = p->node; i < p->node + p->nodes; i++)
        n->extra[n->member[i]] = 0;
    keep(n, p, n->start, n->rest);
    if (!solve(n, p, 1 / h, h, 0))
        return false;
    book(n, p, h, (real[3]){1, 0, 0});
    return true;
}

#define GAMMA 0.585786437626904951198       /* 2 - sqrt 2: both stages have the same matrix, and stiff parts die out */
#define SHARE 0.353553390593273762200       /* sqrt 2 / 4: weight of the start and of the middle; GAMMA / 2 of the end */

static const real weights[3] = {SHARE, SHARE, 0.5 * GAMMA};

/* The part of the error that is not damped, per effort and in units of the tolerance; third order less second, through the matrix
 * of the last solve so that what is stiff counts for what it is. */
static real error_of(Network *n, NetPart *p, real alpha, real h)
{
    const real third[3] = {(1 - SHARE) / 3, (3 * SHARE + 1) / 3, GAMMA / 6};
    real worst = 0;
    for (int i = 0; i < p->nodes; i++) {
        int k = n->member[p->node + i];
        n->change[i] = 0;
        for (int s = 0; s < 3; s++)
            n->change[i] += alpha * h * (third[s] - weights[s]) * n->rate[s][k];
    }
    if (!solve_lines(n, p, alpha, true, n->change))
        return INFINITY;
    for (int i = 0; i < p->nodes; i++)
        worst = real_max(worst, fabs(n->change[i]));
    return worst / n->tolerance;
}

/* A substep from start; false: nothing is booked. */
static bool trapezoid_bdf2(Network *n, NetPart *p, real h, real *error)
{
    real alpha = 2 / (GAMMA * h), f = 1 / (GAMMA * (2 - GAMMA));
    find_lines(n, p, 0.5 * GAMMA * h);
    find_rates(n, p, 0);
    keep(n, p, n->rate[0], n->extra);
    keep(n, p, n->start, n->rest);
    if (!solve(n, p, alpha, 0.5 * GAMMA * h, 1))
        return false;
    for (int i = p->node; i < p->node + p->nodes; i++) {
        int k = n->member[i];
        n->extra[k] = 0;
        n->rest[k] = n->start[k] + f * (n->effort[k] - n->start[k]);
    }
    if (!solve(n, p, alpha, 0.5 * GAMMA * h, 2))
        return false;
    *error = error_of(n, p, alpha, h);
    return true;
}

#define FINEST 4096             /* 1  substeps: what still errs then is taken by the backward Euler rule */

static bool advance_fine(Network *n, NetPart *p, real dt)
{
    int at = 0, step = FINEST;
    while (at < FINEST) {
        real h = dt * step / FINEST, error = 0;
        bool done = trapezoid_bdf2(n, p, h, &error) && error <= 1;
        if (!done)
            keep(n, p, n->start, n->effort);
        if (!done && step > 1) {
            step /= 2;
            continue;
        }
        if (done)
            book(n, p, h, weights);
        else if (!euler(n, p, h))
            return false;
        n->substeps++;
        p->passed += h;
        at += step;
        keep(n, p, n->effort, n->start);
        if (error < 0.06 && step < FINEST && at % (2 * step) == 0)      /* third order: an eighth, and some room */
            step *= 2;
    }
    return true;
}

/* Would a step change anything that can be told from rounding? What flows through is booked all the same. */
static bool rests(Network *n, NetPart *p, real dt)
{
    find_lines(n, p, dt);
    find_rates(n, p, 0);
    for (int i = p->node; i < p->node + p->nodes; i++) {
        int k = n->member[i];
        if (!(fabs(n->rate[0][k]) * dt <= 1e-17 * n->capacity[k] * fabs(n->effort[k])))
            return false;
    }
    book(n, p, dt, (real[3]){1, 0, 0});
    return true;
}

static bool advance_part(Network *n, NetPart *p, real dt)
{
    keep(n, p, n->effort, n->start);
    p->passed = 0;
    bool still = rests(n, p, dt);
    if (!still && n->tolerance > 0)
        return advance_fine(n, p, dt);
    if (!still && !euler(n, p, dt))
        return false;
    n->substeps += !still;
    p->passed = dt;
    return true;
}

void network_advance(Network *n, real dt)
{
    n->substeps = n->iterations = 0;
    n->failed = false;
    for (int i = 0; i < n->branches; i++)
        n->branch[i].through = 0;
    for (int i = 0; i < n->parts; i++) {
        NetPart *p = &n->part[i];
        if (advance_part(n, p, dt))
            continue;
        n->failed = true;
        keep(n, p, n->start, n->effort);
    }
}

void network_settle(Network *n)
{
    n->iterations = 0;
    n->failed = false;
    for (int i = 0; i < n->parts; i++) {
        NetPart *p = &n->part[i];
        keep(n, p, n->effort, n->start);
        for (int k = p->node; k < p->node + p->nodes; k++)
            n->extra[n->member[k]] = 0;
        keep(n, p, n->effort, n->rest);
        if (!solve(n, p, 0, INFINITY, 0)) {
            n->failed = true;
            keep(n, p, n->start, n->effort);
        }
    }
}
