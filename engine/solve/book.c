/* solve/book.c - after a substep: forces are remembered, energy is booked, sleepers that were pushed are noted.
 */
#include "solve/group.h"

/* s  A substep cut short by an impact may be a billionth of the others. What stopped an approach in it, divided by so short a
 * time, would start the next solve with impulses a billion times too large. */
static real remembered_over(const Group *g) { return real_max(g->h, 0.01 * g->world->def.step / g->plan->substeps); }

Vel group_mean_velocity(const Group *g, int body)
{
    const Vel *v = &g->vel[body], *start = &g->start_vel[body];
    if (!g->member[body].moves)
        return *v;
    return (Vel){vec3_scale(0.5, vec3_add(v->v, start->v)), vec3_scale(0.5, vec3_add(v->w, start->w))};
}

Vel group_way_of(const Group *g, int body)
{
    if (!g->member[body].implicit_move || !g->member[body].moves)
        return group_mean_velocity(g, body);
    return (Vel){vec3_add(g->vel[body].v, g->lag), g->vel[body].w};
}

/* Mean velocities of the two bodies of a row. */
typedef struct Means { Vel a, b; bool driven_a, driven_b; } Means;

static Means means_of(const Group *g, int a, int b)
{
    return (Means){group_mean_velocity(g, a), group_mean_velocity(g, b), g->member[a].kinematic, g->member[b].kinematic};
}

/* An impulse along a direction: by the arms that it was solved with, so that nothing is lost between it and the velocities. */
static real book_dir(Group *g, const Dir *d, const Means *m, real p)
{
    real of_a = vec3_dot(d->aa, m->a.w) - vec3_dot(d->n, m->a.v), of_b = vec3_dot(d->ab, m->b.w) + vec3_dot(d->n, m->b.v);
    real lost = -p * (of_a + of_b);
    g->lost += lost;
    if (m->driven_a || m->driven_b)
        g->work_in -= p * ((m->driven_a ? of_a : 0) + (m->driven_b ? of_b : 0));
    return lost;
}

real group_blow_speed(const Group *g) { return g->close_speed + 2 * g->fall * g->h; }

static void book_point(Group *g, PointRow *r, const Means *means)
{
    GroupContact *c = &g->contacts[r->contact];
    Acted *acted = contact_acted(g, c);
    const ManifoldPoint *p = &c->manifold.points[r->point];
    PointMemory *memory = &contact_memory(c)[r->point];
    vec3 tangent = vec3_add(vec3_scale(r->jt[0], r->t[0].n), vec3_scale(r->jt[1], r->t[1].n));
    vec3 impulse = vec3_mad(tangent, r->jn, r->n.n);
    real pressed = r->jn - r->blow, rubbed = 1;
    if (g->unsolved && pressed * r->n.k > VELOCITY_COARSE) {     /* what has no solution is no guess for the next one */
        rubbed = VELOCITY_COARSE / (pressed * r->n.k);
        pressed = VELOCITY_COARSE / r->n.k;
    }
    memory->normal = pressed / remembered_over(g);
    acted->last = r->jn > 0 ? g->t + g->h : acted->last;
    if (r->jn > 0)              /* what closed a gap still approaches: the next substep is not smooth either */
        memory->held = r->target < -1e-6 ? HELD_SUBSTEPS - 1 : HELD_SUBSTEPS;
    memory->tangent = vec3_scale(rubbed / remembered_over(g), tangent);
    acted->impulse = vec3_add(acted->impulse, impulse);
    acted->point_sum = vec3_mad(acted->point_sum, r->jn, p->a);
    acted->point_weight += r->jn;
    c->manifold.slides = r->slides;
    /* where impacts are not located, a fast approach that ends in this substep is one */
    if (!g->locate && r->jn > 0 && -r->rate_before > group_blow_speed(g)) {
        group_note_blow(g, r->a);
        group_note_blow(g, r->b);
        strike_report(g, r, -r->rate_before);
    }
    real lost = book_dir(g, &r->n, means, r->jn) + book_dir(g, &r->t[0], means, r->jt[0]) + book_dir(g, &r->t[1], means, r->jt[1]);
    contact_rest_of(g, c)->lost += lost;
    if (r->jn > 0)
        for (int k = 0; k < 2; k++) {
            Member *m = &g->member[k ? r->b : r->a];
            if (m->dormant)
                m->pushed = g->woke = true;
        }
}

static void book_points(Group *g)
{
    Means means = {.driven_a = false};
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        if (i == 0 || r->a != r[-1].a || r->b != r[-1].b)       /* else the next point of the same two */
            means = means_of(g, r->a, r->b);
        book_point(g, r, &means);
    }
}

static void book_roll(Group *g, RollRow *r)
{
    g->contact_rest[r->contact].rolling = vec3_scale(1 / remembered_over(g), r->j);
    vec3 wa = group_mean_velocity(g, r->a).w, wb = group_mean_velocity(g, r->b).w;
    real lost = -vec3_dot(r->j, vec3_sub(wb, wa));
    g->lost += lost;
    g->contact_rest[r->contact].lost += lost;
    g->work_in += g->member[r->a].kinematic ? vec3_dot(r->j, wa) : 0;
    g->work_in -= g->member[r->b].kinematic ? vec3_dot(r->j, wb) : 0;
}

static real row_rate_of(const Group *g, const Row *r, Vel (*velocity)(const Group *g, int body))
{
    real rate = 0;
    for (int k = 0; k < r->count; k++) {
        int b = r->body[k];
        if (b < 0)
            continue;
        Vel v = velocity(g, b);
        rate += vec3_dot(r->lin[k], v.v) + vec3_dot(r->ang[k], v.w);
    }
    return rate;
}

real group_mean_rate(const Group *g, const Row *r) { return row_rate_of(g, r, group_mean_velocity); }

/* J  What a spring and damper takes from the motion and does not store. By the midpoint rule that is the damper's h c rate^2; by backward
 * Euler there is 1/2 k dx^2 more. */
static real lost_in_spring(const Group *g, const JointRow *r)
{
    real dx = g->h * row_rate_of(g, &r->row, group_way_of);
    return r->k > 0 ? -r->p * group_mean_rate(g, &r->row) - r->row.stiffness * dx * (r->row.error + 0.5 * dx) : 0;
}

/* J  The same of the forces on what moves with its end velocity: they are booked along its way, and speed it up along the mean. Where
 * springs are booked so; and where a blow, too slow to be located, was struck at the start of the substep: it then took less than its
 * impulse along the mean, for part of that impulse bore the weight. Elsewhere this is what the integration makes up, and stays in
 * that figure. */
static void book_implicit(Group *g)
{
    bool all = group_elastic(g);
    for (int i = 0; i < g->moving_count; i++)       /* joints hand a blow on */
        all = all || (g->joints_direct && g->member[i].met);
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves || !m->implicit_move || member_by_euler(m) || !(all || m->met))
            continue;
        Vel mean = group_mean_velocity(g, i), way = group_way_of(g, i);
        g->lost += g->h * (vec3_dot(m->force, vec3_sub(way.v, mean.v)) + vec3_dot(m->torque, vec3_sub(way.w, mean.w)));
    }
}

static void book_joint(Group *g, const JointBlock *b)
{
    GroupJoint *j = &g->joints[b->joint];
    memset(j->force, 0, sizeof j->force);
    for (int i = 0; i < b->count; i++) {
        const JointRow *r = &g->rows[b->first + i];
        j->force[r->row.slot] = r->p / remembered_over(g);
        for (int k = 0; k < r->row.count; k++)
            if (r->row.body[k] == j->a && j->a >= 0) {
                j->impulse = vec3_mad(j->impulse, r->p, r->row.lin[k]);
                j->angular_impulse = vec3_mad(j->angular_impulse, r->p, r->row.ang[k]);
            }
        g->work_in -= r->p * group_row_driven(g, &r->row);
        if (r->row.kind == ROW_HARD || r->row.kind == ROW_LIMIT)        /* what a jerk of a joint takes */
            g->lost -= r->p * group_mean_rate(g, &r->row);
        if (r->row.kind == ROW_DRY || r->row.kind == ROW_MOTOR) {
            real work = r->p * group_mean_rate(g, &r->row);
            *(r->row.kind == ROW_DRY ? &g->lost : &g->work_in) += r->row.kind == ROW_DRY ? -work : work;
            j->lost -= r->row.kind == ROW_DRY ? work : 0;
        }
        if (r->row.kind == ROW_SOFT) {
            real lost = lost_in_spring(g, r);
            g->lost += lost;
            j->lost += lost;
        }
    }
}

/* What healing lifts out of an overlap had fallen too far, and the blow that stopped it took that, too: so much less has been lost, as far
 * as anything has in this step. What bounces has kept a part of it; that is made up, and stays in that figure. Joints heal otherwise. */
static void book_lift(Group *g)
{
    real bounce = 0;
    for (int i = 0; i < g->point_count; i++)
        if (g->points[i].gap < 0)
            bounce = real_max(bounce, g->pairs[g->contacts[g->points[i].contact].pair].rub->restitution);
    if (g->row_count == 0 && g->lifted > 0)
        g->lost -= real_clamp((1 - bounce * bounce) * g->lifted, 0, real_max(0, g->lost));
}

void group_book_pushes(Group *g)
{
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        Vel v = group_way_of(g, p->body);
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        real work = g->h * (vec3_dot(p->force, vec3_add(v.v, vec3_cross(v.w, arm))) + vec3_dot(p->torque, v.w));
        group_book_push(g, p, work);
    }
}

void group_book(Group *g)
{
    book_lift(g);
    book_points(g);
    for (int i = 0; i < g->roll_count; i++)
        book_roll(g, &g->rolls[i]);
    for (int i = 0; i < g->block_count; i++)
        book_joint(g, &g->blocks[i]);
    book_implicit(g);
    g->lost += g->braced;
    for (int i = 0; i < g->moving_count && (g->drags || g->rules); i++) {
        Vel v = group_way_of(g, i);
        group_book_apart(g, i, vec3_scale(g->h, v.v), vec3_scale(g->h, v.w), g->h);
    }
    group_book_pushes(g);
}

void group_forget_idle(Group *g)
{
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; k < g->contacts[i].manifold.count; k++) {
            contact_memory(&g->contacts[i])[k].normal = 0;
            contact_memory(&g->contacts[i])[k].held = int_max(0, contact_memory(&g->contacts[i])[k].held - 1);
            contact_memory(&g->contacts[i])[k].tangent = vec3_zero();
        }
}
