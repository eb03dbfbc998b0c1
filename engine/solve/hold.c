/* solve/hold.c - mechanisms gain no energy but what forces give, whatever a solve leaves undone or heals.
 *
 * Joints do no work but for what a solve leaves of their errors. Where a mechanism can hardly move, that counts. A bridge as long as
 * the gap it spans pulls like a string drawn straight: 1e-11 m at each of its forty joints is a joule in every millisecond, and 1e-7 m,
 * as a blow leaves them and healing takes back, is as much as a ton falls by in a metre. What a substep has gained is taken out of the
 * velocities, all by the same share: they obey joints and contacts as before. What hangs on nothing has momenta to keep, and gives it out of
 * how its parts move against each other. What hangs on a mover that does not turn is looked at as the mover sees it, for there its joints do no
 * work either. Those with springs, motors, movers that turn, or several that do not move alike are left as they are: their joints do work.
 */
#include "base/forest.h"
#include "solve/group.h"
#include "solve/momentum.h"

#define HIDDEN 1e-10            /* of the energies in the sum: less is what a solve may leave  */
#define GENTLE 0.1              /* of the kinetic energy: more is not given back               */

typedef struct Held {
    Group *g;
    int   *root;                /* [moving_count] the lowest body of its mechanism             */
    bool  *held, *driven;       /* by root: by what stands; by what moves as it likes          */
    vec3   frame;               /* m/s  of the movers of the group                             */
    bool   alike;               /* all of them have that, and none turns                       */
} Held;

static bool moves(const Group *g, int body) { return body >= 0 && body < g->moving_count && g->member[body].moves; }

static void unite(Held *h, int a, int b)
{
    if (moves(h->g, a) && moves(h->g, b))
        forest_unite(h->root, a, b);
}

/* After all are united. */
static void mark(Held *h, int body, int other)
{
    const Group *g = h->g;
    if (!moves(g, body) || moves(g, other))
        return;
    int root = h->root[body];
    bool by_mover = other >= 0 && g->member[other].kinematic;
    *(by_mover ? &h->driven[root] : &h->held[root]) = true;
}

static void find_frame(Held *h)
{
    const Group *g = h->g;
    bool any = false;
    h->alike = true;
    for (int i = g->moving_count; i < g->body_count; i++) {
        if (!g->member[i].kinematic)
            continue;
        h->frame = any ? h->frame : g->vel[i].v;
        h->alike = h->alike && vec3_is_zero(g->vel[i].w) && !(vec3_length2(vec3_sub(g->vel[i].v, h->frame)) > 0);
        any = true;
    }
}

/* m/s  Seen from where a mechanism's joints do no work: at rest, or with the movers that hold it, where nothing that stands does as well and all
 * movers of the group move alike. */
static bool frame_of(const Held *h, int root, vec3 *v)
{
    *v = h->driven[root] ? h->frame : vec3_zero();
    return !h->driven[root] || (h->alike && !h->held[root]);
}

/* What joints hold together, and contacts that press. */
static void find(Held *h)
{
    const Group *g = h->g;
    find_frame(h);
    for (int i = 0; i < g->moving_count; i++)
        h->root[i] = i;
    for (int i = 0; i < g->joint_count; i++)
        unite(h, g->joints[i].a, g->joints[i].b);
    for (int i = 0; i < g->point_count; i++)
        if (g->points[i].jn > 0)
            unite(h, g->points[i].a, g->points[i].b);
    for (int i = 0; i < g->moving_count; i++)
        h->root[i] = forest_root(h->root, i);
    for (int i = 0; i < g->joint_count; i++)
        for (int k = 0; k < 2; k++)
            mark(h, k ? g->joints[i].b : g->joints[i].a, k ? g->joints[i].a : g->joints[i].b);
    for (int i = 0; i < g->point_count; i++)
        for (int k = 0; k < 2 && g->points[i].jn > 0; k++)
            mark(h, k ? g->points[i].b : g->points[i].a, k ? g->points[i].a : g->points[i].b);
}

/* Have all its joints rows that do no work, or take some? */
static bool is_passive(const Held *h, int root)
{
    const Group *g = h->g;
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        int body = moves(g, j->a) ? j->a : j->b;
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        if (!moves(g, body) || h->root[body] != root)
            continue;
        group_joint_view(h->g, i);
        j->view.type->rows(&j->view, &list);
        for (int k = 0; k < list.count; k++)
            if (rows[k].kind == ROW_SOFT || rows[k].kind == ROW_MOTOR)
                return false;
    }
    return true;
}

static real kinetic_of(const Member *m, quat q, Vel v)
{
    vec3 w = quat_unrotate(q, v.w);
    return 0.5 * m->mass * vec3_length2(v.v) + 0.5 * vec3_dot(w, mat3_mul_vec(*m->inertia, w));
}

typedef struct Gain { real gain, scale, kinetic; bool twisted; } Gain;      /* J, but for the work of forces; twisted: by torques, too */

static Vel seen_from(vec3 frame, Vel v) { return (Vel){vec3_sub(v.v, frame), v.w}; }

/* As seen from what moves with `frame`, m/s. */
static Gain gain_of(const Held *h, int root, vec3 frame)
{
    const Group *g = h->g;
    Gain e = {0, 0, 0, false};
    for (int i = root; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves || h->root[i] != root)
            continue;
        real after = kinetic_of(m, g->pos[i].q, seen_from(frame, g->vel[i]));
        vec3 way = vec3_mad(vec3_sub(g->pos[i].x, g->start_pos[i].x), -g->h, frame);
        e.twisted = e.twisted || vec3_length2(m->torque) > 0;
        e.kinetic += after;
        e.gain += after - kinetic_of(m, g->start_pos[i].q, seen_from(frame, g->start_vel[i])) - vec3_dot(m->force, way);
        e.scale += after + vec3_length(m->force) * vec3_length(g->pos[i].x);
    }
    return e;
}

/* J  Taken out of it. What movers brake by that, they take. */
static real hold(const Held *h, int root, bool both, vec3 frame)
{
    Group *g = h->g;
    Gain e = gain_of(h, root, frame);
    vec3 less = vec3_zero();
    if (e.twisted || !(fabs(e.gain) > HIDDEN * e.scale) || e.gain < (both ? -GENTLE * e.kinetic : 0) || !is_passive(h, root))
        return 0;
    real share = sqrt(real_max(0, 1 - e.gain / e.kinetic));
    for (int i = root; i < g->moving_count; i++)
        if (g->member[i].moves && h->root[i] == root) {
            vec3 v = vec3_sub(g->vel[i].v, frame);
            less = vec3_mad(less, (1 - share) * g->member[i].mass, v);
            g->vel[i] = (Vel){vec3_mad(frame, share, v), vec3_scale(share, g->vel[i].w)};
        }
    g->work_in -= vec3_dot(less, frame);
    return e.kinetic * (1 - share * share);
}

/* J  The same of one that floats: out of how its parts move against each other, for the whole has its momenta to keep. */
static real hold_floating(const Held *h, int root)
{
    Group *g = h->g;
    Gain e = gain_of(h, root, vec3_zero());
    if (e.twisted || !(e.gain > HIDDEN * e.scale) || !is_passive(h, root))
        return 0;
    Rigid r;
    rigid_motion(g, h->root, root, &r);
    real inner = e.kinetic - 0.5 * r.mass * vec3_length2(r.v) - 0.5 * vec3_dot(r.w, r.l);
    if (!(inner > HIDDEN * e.scale))
        return 0;
    real share = sqrt(real_max(0, 1 - e.gain / inner));
    for (int i = root; i < g->moving_count; i++) {
        if (!g->member[i].moves || h->root[i] != root)
            continue;
        vec3 v = vec3_add(r.v, vec3_cross(r.w, vec3_sub(g->pos[i].x, r.at))), w = r.w;
        g->vel[i] = (Vel){vec3_mad(v, share, vec3_sub(g->vel[i].v, v)), vec3_mad(w, share, vec3_sub(g->vel[i].w, w))};
    }
    return inner * (1 - share * share);
}

dig_status group_hold(Group *g, bool both, real *taken)
{
    ArenaMark start = arena_mark(g->arena);
    size_t n = (size_t)g->moving_count;
    Held h = {.g = g, .root = arena_alloc(g->arena, (n + 1) * sizeof *h.root), .held = arena_zero(g->arena, n + 1), .driven = arena_zero(g->arena, n + 1)};
    if (!h.root || !h.held || !h.driven)
        return DIG_E_MEMORY;
    find(&h);
    *taken = 0;
    for (int i = 0; i < g->moving_count; i++) {
        vec3 frame;
        if (g->member[i].moves && h.root[i] == i && frame_of(&h, i, &frame) && !(both && h.driven[i]))
            *taken += h.held[i] || h.driven[i] ? hold(&h, i, both, frame) : both ? 0 : hold_floating(&h, i);
    }
    arena_rewind(g->arena, start);
    return DIG_OK;
}
