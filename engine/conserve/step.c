/* conserve/step.c - a group becomes the equations of a step, and what they gave goes back and is booked. */
#include "conserve/system.h"
#include "solve/momentum.h"

#define ACROSS 1e-4             /* of the kinetic energy: less of it across the joints stays there */
#define GENTLE 0.1              /* of the same: and more, too                                      */
#define GIVES 1e-3              /* of the energies: a step in which dampers give more is too long      */
#define ALONE 0.01              /* of that: rows one by one tell of as much at least               */

/* ---- pieces ---- */

dig_status step_open(System *s, Group *g)
{
    *s = (System){.g = g, .piece_count = g->body_count + 1, .h = g->world->def.step};
    s->piece = arena_zero(g->arena, (size_t)s->piece_count * sizeof *s->piece);
    if (!s->piece)
        return DIG_E_MEMORY;
    for (int i = 0; i < s->piece_count; i++) {
        Piece *p = &s->piece[i];
        p->q = p->q0 = quat_identity();
        p->r = p->r0 = mat3_identity();
        if (i == g->body_count)
            continue;
        const Member *m = &g->member[i];
        p->moves = m->moves;
        p->mass = m->mass;
        p->inertia = *m->inertia;
        p->inv_inertia = *m->inv_inertia;
        p->reach = 5 * (m->inertia->r0.x + m->inertia->r1.y + m->inertia->r2.z);
    }
    DIG_TRY(parts_compile(s));
    s->node_count = g->moving_count + s->tie_count;
    return order_make(s);
}

/* Poses, velocities and outer impulses at the start of a step. */
static void start(System *s)
{
    const Group *g = s->g;
    for (int i = 0; i < g->body_count; i++) {
        Piece *p = &s->piece[i];
        const Member *m = &g->member[i];
        p->x = p->x0 = g->pos[i].x;
        p->q = p->q0 = g->pos[i].q;
        p->r = p->r0 = quat_matrix(p->q0);
        p->v0 = g->vel[i].v;
        p->w0 = mat3_mul_vec(mat3_transpose(p->r0), g->vel[i].w);
        p->turn = vec3_zero();
        if (!p->moves)
            continue;
        p->p0 = vec3_mad(vec3_scale(p->mass, p->v0), s->h, m->force);
        p->l0 = vec3_mad(mat3_mul_vec(p->r0, mat3_mul_vec(p->inertia, p->w0)), s->h, m->torque);
    }
    parts_begin(s);
}

/* The same, and kinematic bodies go where they are driven. */
void step_begin(System *s)
{
    const Group *g = s->g;
    start(s);
    for (int i = 0; i < g->body_count; i++) {
        Piece *p = &s->piece[i];
        if (!g->member[i].kinematic)
            continue;
        quat d = quat_exp(vec3_scale(s->h, g->vel[i].w));
        p->x = vec3_mad(p->x0, s->h, p->v0);
        p->q = quat_unit(quat_mul(d, p->q0));
        p->turn = vec3_scale(2 / d.w, (vec3){d.x, d.y, d.z});
    }
}

/* ---- bookkeeping ---- */

real step_kinetic(const System *s)
{
    real sum = 0;
    for (int i = 0; i < s->g->moving_count; i++) {
        const Piece *p = &s->piece[i];
        if (p->moves)
            sum += 0.5 * (p->mass * vec3_length2(p->v0) + vec3_dot(p->w0, mat3_mul_vec(p->inertia, p->w0)));
    }
    return sum;
}

static vec3 get3(const real *v) { return (vec3){v[0], v[1], v[2]}; }

/* J  What row k of a tie, of a spring and damper, takes from the motion and does not store. */
static real row_loss(const System *s, const Tie *t, const Part *part, int k)
{
    real p = s->p[t->row + k], half = 0.5 * s->h * part->stiffness, late = part->late;
    real damping = part->damper * (1 + late), before = part->damper * late * s->h * part->rate;
    real change = -(p + (half * (1 - late) - damping) * part->start - before) / (half * (1 + late) + damping) - part->start;
    return (damping * change - before) * change / s->h + 0.5 * part->stiffness * late * change * change;
}

/* Dampers only take. Where what they hold back turns within the step, what it did at the start says nothing of the end: they gave as much. */
static bool gives(const System *s)
{
    real lost = 0, stored = 0;
    for (int i = 0; i < s->tie_count; i++)
        for (int n = s->tie[i].part; n < s->tie[i].part + s->tie[i].parts; n++) {
            const Part *part = &s->part[n];
            stored += part->soft ? 0.5 * part->stiffness * part->start * part->start : 0;
            for (int k = part->at; k < part->at + part->rows && part->soft; k++)
                lost += row_loss(s, &s->tie[i], part, k);
        }
    return lost < 0 && lost < -GIVES * (stored + step_kinetic(s));
}

static void book_tie(System *s, const Tie *t)
{
    Group *g = s->g;
    GroupJoint *j = &g->joints[t->joint];
    for (int n = t->part; n < t->part + t->parts; n++) {
        const Part *part = &s->part[n];
        for (int k = part->at; k < part->at + part->rows; k++) {
            real p = s->p[t->row + k];
            if (j->a >= 0) {
                j->impulse = vec3_mad(j->impulse, p, get3(t->mid[k]));
                j->angular_impulse = vec3_mad(j->angular_impulse, p, get3(t->mid[k] + 3));
            }
            if (part->soft) {
                real lost = row_loss(s, t, part, k);
                g->lost += lost;
                j->lost += lost;
            }
        }
    }
    const int ends[2] = {t->a, t->b};
    for (int k = 0; k < 2; k++)
        if (ends[k] < g->body_count) {
            Member *m = &g->member[ends[k]];
            m->constrained = true;
            const Piece *p = &s->piece[ends[k]];
            if (m->dormant && vec3_length2(p->push) + vec3_length2(p->twist) > 0)
                m->pushed = g->woke = true;
        }
}

static void book(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < s->tie_count; i++)
        book_tie(s, &s->tie[i]);
    for (int i = 0; i < g->body_count; i++) {
        const Piece *p = &s->piece[i];
        group_book_apart(g, i, vec3_sub(p->x, p->x0), p->turn, s->h);
        if (g->member[i].kinematic)
            g->work_in -= (vec3_dot(p->push, vec3_sub(p->x, p->x0)) + vec3_dot(p->twist, p->turn)) / s->h;
    }
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        const Piece *b = &s->piece[p->body];
        vec3 torque = p->has_at ? vec3_add(p->torque, vec3_cross(quat_rotate(b->q0, p->at), p->force)) : p->torque;
        real work = vec3_dot(p->force, vec3_sub(b->x, b->x0)) + vec3_dot(torque, b->turn);
        group_book_push(g, p, work);
    }
}

/* Angles unwind, and rows say how well the joints hold. False: a stop was met. */
bool step_watch(Group *g, bool last)
{
    for (int i = 0; i < g->joint_count; i++) {
        Row rows[JOINT_SLOTS];
        RowList list = {rows, 0, JOINT_SLOTS};
        group_joint_view(g, i);
        g->joints[i].view.type->rows(&g->joints[i].view, &list);
        for (int k = 0; k < list.count; k++) {
            if (rows[k].kind == ROW_LIMIT && rows[k].error < 0)
                return false;
            if (last && rows[k].kind == ROW_HARD)
                g->joint_error = real_max(g->joint_error, fabs(rows[k].error));
        }
    }
    return true;
}

/* The forces of the last step, for reports and as the next first guess. */
void step_remember(System *s)
{
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        GroupJoint *j = &s->g->joints[t->joint];
        memset(j->force, 0, sizeof j->force);
        for (int n = t->part; n < t->part + t->parts; n++) {
            const Part *part = &s->part[n];
            const real *p = s->p_last + t->row + part->at;
            const JointEnd *b = &j->view.b;
            const vec3 axes[3] = {b->axis, b->u, b->n};
            for (int k = 0; k < part->rows; k++)
                j->force[part->slot + k] = part->kind == PART_POINT ? vec3_dot(axes[k], get3(p)) : p[k];
        }
    }
}

/* ---- steps ---- */

/* Joints that others left apart, a contact solve or a script, would be closed by a jerk. */
bool step_place(System *s)
{
    Group *g = s->g;
    start(s);
    if (!newton_place(s))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (s->piece[i].moves) {
            g->pos[i] = (Pos){s->piece[i].x, s->piece[i].q};
            group_refresh_mass(g, i);
        }
    return true;
}

/* A plastic blow: what driven bodies put in, and the rest of the change is lost. */
bool step_clean(System *s)
{
    Group *g = s->g;
    real work = 0;
    start(s);
    real before = step_kinetic(s);
    if (!newton_clean(s))
        return false;
    for (int i = 0; i < g->moving_count; i++)
        if (s->piece[i].moves)
            g->vel[i] = (Vel){s->piece[i].v0, mat3_mul_vec(s->piece[i].r0, s->piece[i].w0)};
    for (int i = 0; i < s->piece_count - 1; i++)
        if (g->member[i].kinematic)
            work -= vec3_dot(s->piece[i].push, g->vel[i].v) + vec3_dot(s->piece[i].twist, g->vel[i].w);
    g->work_in += work;
    g->lost += before + work - step_kinetic(s);
    return true;
}

static bool is_driven(const Group *g)
{
    for (int i = g->moving_count; i < g->body_count; i++)
        if (g->member[i].kinematic && vec3_length2(g->vel[i].v) + vec3_length2(g->vel[i].w) > 0)
            return true;
    return false;
}

/* Of bodies: the first of their mechanism, and what holds that; their velocities before. Of mechanisms, at their first: J  their motion, and
 * how much of it is across joints. */
typedef struct Settle { int *root; uint8_t *ties; Vel *was; real *kinetic, *across; } Settle;

static bool settle_open(const Group *g, Settle *o)
{
    size_t n = (size_t)g->moving_count + 1;
    *o = (Settle){arena_alloc(g->arena, n * sizeof *o->root), arena_zero(g->arena, n), arena_alloc(g->arena, n * sizeof *o->was),
                  arena_alloc(g->arena, n * sizeof *o->kinetic), arena_zero(g->arena, n * sizeof *o->across)};
    return o->root && o->ties && o->was && o->kinetic && o->across;
}

/* Rows one by one tell of less than all of them together, by up to fifty times (a chain of 50 links): is a solve worth while? */
static bool has_across(const System *s, const Settle *o)
{
    const Group *g = s->g;
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        o->across[o->root[s->piece[t->a].moves ? t->a : t->b]] += parts_across(s, t);
    }
    for (int i = 0; i < g->moving_count; i++)
        if (o->root[i] == i && o->across[i] > ACROSS * ALONE * o->kinetic[i])
            return true;
    return false;
}

static void give_back(System *s, const Settle *o)
{
    Group *g = s->g;
    for (int i = 0; i < g->moving_count; i++) {
        o->was[i] = g->vel[i];
        if (s->piece[i].moves)
            g->vel[i] = (Vel){s->piece[i].v0, mat3_mul_vec(s->piece[i].r0, s->piece[i].w0)};
    }
    for (int i = 0; i < g->moving_count; i++) {
        if (!s->piece[i].moves || o->root[i] != i)
            continue;
        bool adds_up = o->kinetic[i] - mechanism_kinetic(g, o->root, i) > ACROSS * o->kinetic[i];
        if (adds_up && mechanism_hold_kinetic(g, o->root, i, !(o->ties[i] & MECHANISM_HELD), o->kinetic[i], GENTLE))
            continue;
        for (int k = i; k < g->moving_count; k++)
            if (o->root[k] == i)
                g->vel[k] = o->was[k];
    }
}

/* The rule ends on the joints in place, not in velocity: it leaves something across them, which the next step mirrors. Of a smooth motion
 * that belongs to the fourth order of composed steps; where it is not smooth, it adds up, and is energy that no motion has: it asks for short
 * steps with many iterations. Then it is given back to the motion. */
dig_status step_settle(System *s)
{
    Group *g = s->g;
    Settle o;
    if (is_driven(g))
        return DIG_OK;
    ArenaMark mark = arena_mark(g->arena);
    if (!settle_open(g, &o))
        return DIG_E_MEMORY;
    group_mechanisms(g, o.root, o.ties);
    for (int i = 0; i < g->moving_count; i++)
        o.kinetic[i] = o.root[i] == i ? mechanism_kinetic(g, o.root, i) : 0;
    if (has_across(s, &o)) {
        start(s);
        if (newton_clean(s))
            give_back(s, &o);
    }
    arena_rewind(g->arena, mark);
    return DIG_OK;
}

real step_fastest_spin(const Group *g)
{
    real w = 0;
    for (int i = 0; i < g->moving_count; i++)
        w = real_max(w, vec3_length2(g->vel[i].w));
    return sqrt(w);
}

bool step_write_pose(const System *s, int i)
{
    Group *g = s->g;
    const Piece *p = &s->piece[i];
    Member *m = &g->member[i];
    if (p->moves || m->kinematic) {
        g->start_pos[i] = g->pos[i];
        g->start_vel[i] = g->vel[i];
        g->pos[i] = (Pos){p->x, p->q};
    }
    return p->moves;
}

static void write_back(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < g->body_count; i++) {
        const Piece *p = &s->piece[i];
        if (!step_write_pose(s, i))
            continue;
        /* refined once: the matrix is orthogonal within rounding only, and that bias would add up */
        vec3 l = vec3_add(p->l0, p->twist), w = mat3_mul_vec(p->r, p->w);
        mat3 back = mat3_transpose(p->r);
        vec3 off = vec3_sub(l, mat3_mul_vec(p->r, mat3_mul_vec(p->inertia, mat3_mul_vec(back, w))));
        w = vec3_add(w, mat3_mul_vec(p->r, mat3_mul_vec(p->inv_inertia, mat3_mul_vec(back, off))));
        g->vel[i] = (Vel){p->v0, w};
        group_refresh_mass(g, i);
    }
}

/* A single step of s->h. *done: it converged. */
dig_status step_single(System *s, bool *done)
{
    Group *g = s->g;
    real taken;
    g->h = s->h;
    DIG_TRY(group_forces(g));
    step_begin(s);
    *done = newton_step(s) && (!s->lends || !gives(s));        /* as many steps as they are to be are not halved where they are extrapolated */
    if (!*done)
        return DIG_OK;
    book(s);
    write_back(s);
    DIG_TRY(group_hold(g, true, &taken));
    g->residual = real_max(g->residual, s->residual / fabs(s->h));
    return DIG_OK;
}
