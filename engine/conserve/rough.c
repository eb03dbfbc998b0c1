/* conserve/rough.c - the frame goes on with its joints closed where the energy-momentum step has found no solution.
 *
 * What whips faster than the shortest step has poses that obey its joints, and velocities, all the same. Here both are found by solves that are
 * linear or nearly so, in steps that turn nothing by more than TURN_MOST:
 *
 *     M (v1 - v0) = h f + J^T p,      J v1 = 0 for hard rows,      p = -h (k (C + h C') + c C') for springs and dampers   (implicit Euler)
 *     x1 = x0 + h v1, then moved onto the joints as little as possible, weighed by mass
 *
 * A projection of velocities in the metric of mass takes energy and never gives any; what is taken is booked as lost, and the frame as given up.
 * What a frame gains on the whole, by moves onto the joints, is left to the figure of what the integration makes up.
 * Projected in places and velocities: Hairer & Wanner 1996, Solving Ordinary Differential Equations II, VII.2.
 */
#include "conserve/system.h"

#define TURN_MOST 0.1           /* rad of one step                                             */
#define SHORT     10            /* where it gets there it takes 124 iterations for 20 links; planks under what is heavy took all of 4000, for nothing */
#define GAIN_MOST 1e-4          /* of the energies in the sum: a move onto the joints that adds more was too long */

int rough_budget(const Group *g)
{
    return (int)real_clamp(400000.0 / (g->moving_count + g->joint_count + 20), 1000, 20000);
}

static real stored(System *s)
{
    real sum = 0;
    for (int i = 0; i < s->part_count; i++)
        sum += s->part[i].soft ? 0.5 * s->part[i].stiffness * s->part[i].start * s->part[i].start : 0;
    return sum;
}

/* Of outer forces and then of joints; *works: J  put in by what is driven. False: no velocities obey the joints. */
static bool push(System *s, real *works)
{
    *works = 0;
    for (int i = 0; i < s->g->moving_count; i++) {
        Piece *p = &s->piece[i];
        if (!p->moves)
            continue;
        p->v0 = vec3_scale(1 / p->mass, p->p0);
        p->w0 = mat3_mul_vec(p->inv_inertia, mat3_mul_vec(mat3_transpose(p->r0), p->l0));
    }
    s->g->evaluations++;
    s->yields = true;
    bool fine = newton_clean(s);
    s->yields = false;
    for (int i = 0; i < s->tie_count && fine; i++)
        for (int k = 0; k < s->tie[i].rows; k++)
            s->p_last[s->tie[i].row + k] = s->side[6 * (s->g->moving_count + i) + k] / s->h;
    for (int i = s->g->moving_count; i < s->g->body_count; i++) {
        const Piece *p = &s->piece[i];
        if (s->g->member[i].kinematic)
            *works -= vec3_dot(p->push, p->v0) + vec3_dot(p->twist, mat3_mul_vec(p->r0, p->w0));
    }
    return fine;
}

/* Sleepers that are pushed wake: the frame is tried again then. */
static void wake(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < g->body_count; i++) {
        const Piece *p = &s->piece[i];
        if (g->member[i].dormant && vec3_length2(p->push) + vec3_length2(p->twist) > 0)
            g->member[i].pushed = g->woke = true;
    }
}

/* In the directions of the end, as far as a step turns them. */
static void book_joints(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        GroupJoint *j = &g->joints[t->joint];
        for (int k = 0; k < t->rows && j->a >= 0; k++) {
            real p = s->h * s->p_last[t->row + k];
            j->impulse = vec3_mad(j->impulse, p, (vec3){t->end[k][0], t->end[k][1], t->end[k][2]});
            j->angular_impulse = vec3_mad(j->angular_impulse, p, (vec3){t->end[k][3], t->end[k][4], t->end[k][5]});
        }
        for (int k = 0; k < 2; k++)
            if ((k ? t->b : t->a) < g->body_count)
                g->member[k ? t->b : t->a].constrained = true;
    }
}

/* Angular momentum stays as it is while a body turns; what is driven is at its end already. */
static void move(System *s)
{
    for (int i = 0; i < s->g->body_count; i++) {
        Piece *p = &s->piece[i];
        vec3 w = mat3_mul_vec(p->r0, p->w0), l = mat3_mul_vec(p->r0, mat3_mul_vec(p->inertia, p->w0));
        if (p->moves) {
            p->x = vec3_mad(p->x0, s->h, p->v0);
            p->q = quat_unit(quat_mul(quat_exp(vec3_scale(s->h, w)), p->q0));
        }
        p->x0 = p->x;
        p->q0 = p->q;
        p->r = p->r0 = quat_matrix(p->q);
        if (p->moves)
            p->w0 = mat3_mul_vec(p->inv_inertia, mat3_mul_vec(mat3_transpose(p->r0), l));
    }
}

/* What pushes and drags have done, by where the pieces have come from the group's places. */
static void book_work(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < g->moving_count; i++) {
        const Piece *p = &s->piece[i];
        if (!p->moves)
            continue;
        vec3 moved = vec3_sub(p->x, g->pos[i].x), turned = quat_log(quat_mul(p->q, quat_conjugate(g->pos[i].q)));
        group_book_apart(g, i, moved, turned, s->h);
        for (int k = 0; k < g->push_count; k++) {
            const GroupPush *f = &g->pushes[k];
            if (f->body != i)
                continue;
            vec3 torque = f->has_at ? vec3_add(f->torque, vec3_cross(quat_rotate(g->pos[i].q, f->at), f->force)) : f->torque;
            group_book_push(g, f, vec3_dot(f->force, moved) + vec3_dot(torque, turned));
        }
    }
}

/* J  The work of all outer forces. */
static real work_of_forces(const System *s)
{
    const Group *g = s->g;
    real sum = 0;
    for (int i = 0; i < g->moving_count; i++)
        if (s->piece[i].moves)
            sum += vec3_dot(g->member[i].force, vec3_sub(s->piece[i].x, g->pos[i].x)) +
                   vec3_dot(g->member[i].torque, quat_log(quat_mul(s->piece[i].q, quat_conjugate(g->pos[i].q))));
    return sum;
}

static void write_back(System *s)
{
    Group *g = s->g;
    for (int i = 0; i < g->body_count; i++) {
        const Piece *p = &s->piece[i];
        if (!step_write_pose(s, i))
            continue;
        g->vel[i] = (Vel){p->v0, mat3_mul_vec(p->r0, p->w0)};
        group_refresh_mass(g, i);
    }
}

/* What the joints' moves have added is taken out of the velocities as far as it can be. *done: it ends on the joints. */
static dig_status part(System *s, bool shortest, real *loss, bool *done)
{
    Group *g = s->g;
    real works, taken;
    *done = false;
    g->h = s->h;
    DIG_TRY(group_forces(g));
    step_begin(s);
    real before = stored(s) + step_kinetic(s);
    if (!push(s, &works))
        return DIG_OK;
    wake(s);
    move(s);
    g->evaluations += 3;        /* iterations, mostly */
    if (!newton_place(s))
        return DIG_OK;
    parts_begin(s);
    real by_forces = work_of_forces(s), after = stored(s) + step_kinetic(s), lost = before + works + by_forces - after;
    if (!shortest && lost < -GAIN_MOST * (before + after + fabs(by_forces)))
        return DIG_OK;
    *done = true;
    book_joints(s);
    book_work(s);
    write_back(s);
    DIG_TRY(group_hold(g, false, &taken));
    g->work_in += works;
    *loss += lost + taken;
    return DIG_OK;
}

dig_status rough_run(Group *g, real dt, System *s, const char **why)
{
    const int total = 1 << LEVELS, most = g->evaluations + rough_budget(g) / SHORT;
    real loss = 0;
    DIG_TRY(step_open(s, g));
    *why = step_place(s) ? NULL : "conserve: no poses obey the joints";
    for (int at = 0, width = total; at < total && !g->woke && !*why;) {
        bool done;
        while (width > 1 && step_fastest_spin(g) * dt * width / total > TURN_MOST)
            width /= 2;
        s->h = dt * width / total;
        g->t = dt * at / total;
        DIG_TRY(part(s, width == 1, &loss, &done));
        if (!done) {
            g->refused++;
            *why = width == 1 ? "conserve: no poses obey the joints" : NULL;
            width /= 2;
            continue;
        }
        g->substeps++;
        at += width;
        if (g->evaluations > most)
            *why = "conserve: too many iterations";
        else if (!step_watch(g, false))
            *why = "conserve: a joint met its stop";
        if (width < total && at % (2 * width) == 0)
            width *= 2;
    }
    g->t = dt;
    g->lost += real_max(0, loss);       /* what one step adds another may have taken */
    return DIG_OK;
}
