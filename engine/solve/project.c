/* solve/project.c - position errors are removed without touching velocities, so that what overlaps is moved apart and
 * nothing is launched, whatever the step. One linearised pass over penetrating points and joint errors. */
#include "solve/direction.h"
#include "solve/fours.h"

/* m/s per sqrt(m): overlaps heal at most as fast as a body would fall by its own size under 10 m/s^2. */
#define HEAL_SPEED 3.0

/* Part of the size. Bodies that are that deep in something (MERGED) are moved apart without being turned, by any of their contacts. Turned, a row of boxes
 * laid into each other rears up while it heals, and what was lifted falls; and what is deep in a wall on one side and just touched on the
 * other was turned by the touch. What nothing keeps from parting is not turned by the last of its overlap either. */
#define DEEP_FREE 5e-3
#define SLIGHT    1e-3          /* less than this is no more than what pressing and rolling leave */

/* Works on g->shift in the place of velocities: directions and rows apply to Vel. */
static real wanted_gap(const Group *g, const PointRow *r)
{
    const GroupContact *c = &g->contacts[r->contact];
    real depth = -c->manifold.points[r->point].gap - squeeze_of(g, r->contact).depth;
    if (!(depth > 0))
        return depth;           /* may close by its gap, no more */
    real most = HEAL_SPEED * sqrt(g->pairs[c->pair].size) * g->heal_over;
    return real_min(depth, most);
}

/* m  Wider gaps of joints are closed. But where all joints are solved at once, velocities hold them, and what their turns leave is not
 * worth a solve before it is so many local tolerances of the smallest body. */
#define CLOSED 1e-12
#define CLOSE  10

/* m or rad */
static real close_enough(const Group *g)
{
    real size = INFINITY;
    for (int i = 0; i < g->moving_count && g->joints_direct; i++)
        size = g->member[i].moves ? real_min(size, g->member[i].outer) : size;
    return isfinite(size) ? real_max(CLOSE * g->tolerance * size, CLOSED) : CLOSED;
}

static bool needed(const Group *g)
{
    real close = close_enough(g);
    for (int i = 0; i < g->point_count; i++)
        if (g->contacts[g->points[i].contact].manifold.points[g->points[i].point].gap < -1e-3 * g->touch)
            return true;
    for (int i = 0; i < g->row_count; i++) {
        const Row *r = &g->rows[i].row;
        if ((r->kind == ROW_HARD && fabs(r->error) > close) || (r->kind == ROW_LIMIT && r->error < -real_max(close, 1e-9)))
            return true;
    }
    return false;
}

/* part: of the size */
static bool is_deeper(const Group *g, const PointRow *r, real part)
{
    const GroupContact *c = &g->contacts[r->contact];
    return -c->manifold.points[r->point].gap > part * g->pairs[c->pair].size;
}

/* deep: by body */
static void drop_levers(const Group *g, const bool *deep, PointRow *r)
{
    if (deep[r->a])
        r->n.aa = r->n.ia = vec3_zero();
    if (deep[r->b])
        r->n.ab = r->n.ib = vec3_zero();
    if (deep[r->a] || deep[r->b])
        r->n.k = (g->mass[r->a].im + g->mass[r->b].im) * vec3_length2(r->n.n) + vec3_dot(r->n.aa, r->n.ia) + vec3_dot(r->n.ab, r->n.ib);
}

static bool any_deep(const Group *g)
{
    for (int i = 0; i < g->point_count; i++)
        if (is_deeper(g, &g->points[i], MERGED))
            return true;
    return false;
}

typedef struct Kept { Dir n; real jt[2]; } Kept;

/* No stop of an angle or a way is passed by what heals others: it comes nearer by its room, no more. Not so of a line, which is another once its
 * ends are shifted across it. */
static bool has_bounds(const Group *g, const JointBlock *b)
{
    const JointType *type = g->joints[b->joint].view.type;
    return type->coordinate_row || type->sways;
}

/* kg or kg m^2: what a spring resists a shift by, beside the inertia of its ends, were it a way of that time. Moved as if it were not there, pieces of
 * a steel plank came by 42 kJ in their joints, where 8 moved. */
static real stiff_of(const Group *g, const JointRow *r) { return g->heal_over * g->heal_over * r->row.stiffness; }

#define SLACK 1e-6              /* less than this part of that inertia is nothing */

static bool is_stiff(const Group *g, const JointRow *r) { return r->row.kind == ROW_SOFT && stiff_of(g, r) * r->k > SLACK; }

static void start_block(Group *g, const JointBlock *b, real *saved)
{
    bool bounds = has_bounds(g, b);
    for (int i = b->first; i < b->first + b->count; i++) {
        JointRow *r = &g->rows[i];
        real *s = saved + 4 * i, most = (r->row.angular ? 20.0 : HEAL_SPEED) * g->heal_over;
        s[0] = r->p;
        s[1] = r->bias;
        s[2] = r->gamma;
        s[3] = r->k;
        r->p = 0;
        r->gamma = 0;
        if (is_stiff(g, r)) {
            r->bias = 0;
            r->gamma = 1 / stiff_of(g, r);
            continue;
        }
        bool stop = r->row.kind == ROW_LIMIT && (bounds || r->row.error < 0);
        r->bias = real_clamp(-r->row.error, stop ? -INFINITY : -most, most);
        if (r->row.kind != ROW_HARD && !stop)
            r->k = 0;
    }
}

static void start_shift(Group *g, real *saved, Kept *kept, bool *deep)
{
    bool free = g->joint_count == 0 && !group_top_heavy(g);
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        if (is_deeper(g, r, free && g->member[r->a].moves && g->member[r->b].moves ? DEEP_FREE : MERGED))
            deep[r->a] = deep[r->b] = true;
    }
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        kept[i] = (Kept){r->n, {r->jt[0], r->jt[1]}};
        r->jt[0] = r->jt[1] = 0;
        drop_levers(g, deep, r);
        saved[4 * i] = r->jn;
        saved[4 * i + 1] = r->target;
        saved[4 * i + 2] = r->friction;
        r->jn = 0;
        r->target = wanted_gap(g, r);
        r->friction = 0;
    }
    for (int i = 0; i < g->block_count; i++)
        start_block(g, &g->blocks[i], saved + 4 * g->point_count);
}

/* How far it is to the stop now. */
static void move_stop(const Group *g, JointRow *r)
{
    real room = real_max(0, r->row.error);
    r->row.error += joint_row_rate(g, &r->row);
    r->bias += (room - real_max(0, r->row.error)) / g->h;
}

/* How far it is stretched now. */
static void move_spring(const Group *g, JointRow *r)
{
    real way = joint_row_rate(g, &r->row);
    r->row.error += way;
    r->bias -= way * g->h * r->row.stiffness * r->gamma;
}

static void end_block(Group *g, const JointBlock *b, const real *saved)
{
    bool bounds = has_bounds(g, b);
    for (int i = b->first; i < b->first + b->count; i++) {
        JointRow *r = &g->rows[i];
        const real *s = saved + 4 * i;
        r->p = s[0];
        r->bias = s[1];
        r->gamma = s[2];
        r->k = s[3];
        if (bounds && r->row.kind == ROW_LIMIT)
            move_stop(g, r);
        if (is_stiff(g, r))
            move_spring(g, r);
    }
}

static void end_shift(Group *g, const real *saved, const Kept *kept)
{
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        ManifoldPoint *p = &g->contacts[r->contact].manifold.points[r->point];
        r->n = kept[i].n;
        r->gap = p->gap;
        r->healed = p->gap += dir_rate(g, &r->n, r->a, r->b);
        r->jn = saved[4 * i];
        memcpy(r->jt, kept[i].jt, sizeof r->jt);
        r->target = saved[4 * i + 1];
        r->friction = saved[4 * i + 2];
    }
    for (int i = 0; i < g->block_count; i++)
        end_block(g, &g->blocks[i], saved + 4 * g->point_count);
}

static void swap_velocities(Group *g)
{
    Vel *t = g->vel;
    g->vel = g->shift;
    g->shift = t;
}

/* Neither of its bodies is turned: its points all ask for one and the same way along the normal, and the deepest has the last word. */
static bool is_one_way(const Group *g, const bool *deep, const PointRow *r)
{
    return (deep[r->a] || !g->member[r->a].moves) && (deep[r->b] || !g->member[r->b].moves);
}

/* Points to sweep: of such contacts the deepest alone. */
static void list_ways(Group *g, const bool *deep, PointRow *to)
{
    int count = 0;
    for (int i = 0, n; i < g->point_count; i += n) {
        const PointRow *r = &g->points[i];
        int best = i;
        for (n = 1; i + n < g->point_count && g->points[i + n].contact == r->contact; n++)
            best = g->points[i + n].target > g->points[best].target ? i + n : best;
        if (is_one_way(g, deep, r)) {
            to[count++] = g->points[best];
            continue;
        }
        memcpy(to + count, r, (size_t)n * sizeof *to);
        count += n;
    }
    g->points = to;
    g->point_count = count;
}

/* was: room for velocities, all zero. Returns what the last sweep changed, m or rad. */
static real relax_shift(Group *g, Vel *was)
{
    real worst = 0;
    int sweeps = (int)real_clamp(20000.0 / (g->point_count + g->row_count + 1), 3, 100), rolls = g->roll_count;
    g->roll_count = 0;          /* nothing rolls here */
    Fours *fours = fours_open(g, 0, false);
    for (int i = 0; i < sweeps; i++) {
        worst = relax_joints(g);
        worst = real_max(worst, fours ? fours_relax(fours) : relax_points(g, 0, g->point_count));
        if (worst < 1e-13 || relax_in_vain(g, was, worst))
            break;
        memcpy(was, g->vel, (size_t)g->moving_count * sizeof *was);
    }
    if (fours)
        fours_close(fours);
    g->roll_count = rolls;
    return worst;
}

/* Sweeps bring what lies in something heavy out of it by a hundredth of its way a substep, or less, and meanwhile it turns and slides off. */
static bool wants_direct(const Group *g)
{
    bool plain = true;
    for (int i = 0; i < g->point_count && plain && !g->joints_direct; i++)
        plain = !is_deeper(g, &g->points[i], SLIGHT);
    return g->joints_direct ? !g->jammed : !plain && group_top_heavy(g);
}

#define UNDONE 1e-6             /* m or rad */

static bool beyond_stop(const Group *g)
{
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count && has_bounds(g, &g->blocks[i]); k++) {
            const Row *r = &g->rows[g->blocks[i].first + k].row;
            if (r->kind == ROW_LIMIT && r->error < 0)
                return true;
        }
    return false;
}

/* Joints at their stops make a long stiff beam, of which sweeps lift one end by letting the other sink: it was lifted again in each substep,
 * and fell. was: as of relax_shift(), and room to keep what that has done. */
static void shift(Group *g, Vel *was)
{
    if (!(relax_shift(g, was) > UNDONE) || g->joints_direct || !beyond_stop(g))
        return;
    memcpy(was, g->vel, (size_t)g->moving_count * sizeof *was);
    memset(g->vel, 0, (size_t)g->moving_count * sizeof *g->vel);
    for (int i = 0; i < g->point_count; i++)
        g->points[i].jn = 0;
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = 0;
    if (!direct_project_joints(g))
        memcpy(g->vel, was, (size_t)g->moving_count * sizeof *was);
}

/* The same, of what is as good as in one place by as few rows as tell it; impulses of shifts are of no use afterwards. */
static void shift_ways(Group *g, const bool *deep, Vel *was)
{
    PointRow *all = g->points, *some = any_deep(g) ? arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *some) : NULL;
    int count = g->point_count;
    if (some)                   /* else all are swept */
        list_ways(g, deep, some);
    shift(g, was);
    g->points = all;
    g->point_count = count;
}

void project(Group *g)
{
    if (!needed(g))
        return;
    ArenaMark mark = arena_mark(g->arena);
    real *saved = arena_alloc(g->arena, (size_t)(4 * (g->point_count + g->row_count) + 1) * sizeof *saved);
    Kept *kept = arena_alloc(g->arena, (size_t)(g->point_count + 1) * sizeof *kept);
    bool *deep = arena_zero(g->arena, (size_t)g->body_count * sizeof *deep);
    Vel *was = arena_zero(g->arena, (size_t)(g->moving_count + 1) * sizeof *was);
    if (!saved || !kept || !deep || !was) {
        g->status = DIG_E_MEMORY;
        return;
    }
    for (int i = 0; i < g->body_count; i++)
        g->shift[i] = (Vel){vec3_zero(), vec3_zero()};
    swap_velocities(g);
    start_shift(g, saved, kept, deep);
    if (!wants_direct(g) || !direct_project(g))
        shift_ways(g, deep, was);
    end_shift(g, saved, kept);
    swap_velocities(g);
    for (int i = 0; i < g->moving_count; i++) {
        if (!g->member[i].moves)
            continue;
        g->pos[i].x = vec3_add(g->pos[i].x, g->shift[i].v);
        g->pos[i].q = quat_unit(quat_mul(quat_exp(g->shift[i].w), g->pos[i].q));
        if (group_whirls(g, i))
            g->vel[i].w = quat_rotate(quat_exp(g->shift[i].w), g->vel[i].w);
        g->lifted -= vec3_dot(g->member[i].force, g->shift[i].v) + vec3_dot(g->member[i].torque, g->shift[i].w);
    }
    arena_rewind(g->arena, mark);
}

void project_back(Group *g)
{
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        GroupManifold *m = &g->contacts[r->contact].manifold;
        if (r->point < m->count && m->points[r->point].gap == r->healed)
            m->points[r->point].gap = r->gap;
    }
}
