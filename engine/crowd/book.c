/* crowd/book.c - what the solve found goes to the group's records: forces, points, impacts, energy. */
#include "crowd/system.h"

static vec3 carried(const Group *g, int body, vec3 at)
{
    const Member *m = &g->member[body];
    if (!m->moves && !m->kinematic)
        return at;
    vec3 shift = vec3_sub(g->pos[body].x, m->start_pos.x);
    return vec3_add(at, vec3_add(shift, vec3_cross(g->shift[body].w, vec3_sub(at, m->start_pos.x))));
}

/* Points go with their bodies; the gap changes by what the row saw. */
static void carry(Group *g, GroupContact *c)
{
    GroupPair *q = &g->pairs[c->pair];
    for (int k = 0; k < c->manifold.count; k++) {
        ManifoldPoint *p = &c->manifold.points[k];
        p->a = carried(g, c->a, p->a);
        p->b = carried(g, c->b, p->b);
        p->gap = vec3_dot(c->manifold.normal, vec3_sub(p->b, p->a));
    }
    if (c->manifold.count >= 3) {
        int side = g->member[c->a].moves && !(g->member[c->a].round && g->member[c->b].moves) ? c->a : c->b;
        if (!g->member[c->a].moves || !g->member[c->b].moves)
            side = g->member[c->a].moves ? c->b : c->a;
        c->manifold.normal = vec3_unit(vec3_add(c->manifold.normal, vec3_cross(g->shift[side].w, c->manifold.normal)));
        crowd_sign(g, q);
    }
}

static void note_impact(Group *g, const GroupContact *c, int contact, int point, real speed, real jn)
{
    PointRow r = {.contact = contact, .point = point, .a = c->a, .b = c->b, .jn = jn};
    g->member[c->a].collided = g->member[c->b].collided = true;
    strike_report(g, &r, speed);
}

static void book_lane(Crowd *c, const Batch *b, int lane)
{
    Group *g = c->g;
    int contact = b->contact[lane];
    GroupContact *t = &g->contacts[contact];
    GroupPair *q = &g->pairs[t->pair];
    vec3 n = t->manifold.normal, u, v, force = vec3_zero(), middle = vec3_zero();
    real load = 0, sum = 0, spread = 0, twist = 0;
    int count = t->manifold.count;
    for (int k = 0; k < count; k++) {
        load += (real)b->point[k].j[lane];
        sum += (real)b->point[k].sum[lane];
        middle = vec3_mad(middle, 0.5 / count, vec3_add(t->manifold.points[k].a, t->manifold.points[k].b));
    }
    if (b->patch) {
        vec3_basis(n, &u, &v);
        force = vec3_add(vec3_scale((real)b->patch->j[0][lane], u), vec3_scale((real)b->patch->j[1][lane], v));
        vec3 whole = vec3_add(vec3_scale((real)b->patch->sum[0][lane], u), vec3_scale((real)b->patch->sum[1][lane], v));
        t->impulse = vec3_add(t->impulse, whole);
        twist = (real)b->patch->jw[lane];
        for (int k = 0; k < count; k++)
            spread += vec3_length2(vec3_sub(t->manifold.points[k].a, middle));
    }
    t->impulse = vec3_mad(t->impulse, sum, n);
    for (int k = 0; k < count; k++) {
        real j = (real)b->point[k].j[lane], whole = (real)b->point[k].sum[lane], speed = -(real)b->point[k].rate_before[lane];
        const ManifoldPoint *p = &t->manifold.points[k];
        vec3 tangent = vec3_scale(load > 0 ? j / load : 1.0 / count, force);
        if (spread > 0)
            tangent = vec3_mad(tangent, twist / spread, vec3_cross(n, vec3_sub(p->a, middle)));
        t->memory[k].normal = j / (real)c->h;
        t->memory[k].tangent = vec3_scale(1 / (real)c->h, tangent);
        t->memory[k].held = whole > 0 ? HELD_SUBSTEPS : 0;
        t->point_sum = vec3_mad(t->point_sum, whole, p->a);
        t->point_weight += whole;
        if (whole > 0) {
            t->last = g->t;
            q->approach = real_max(q->approach, speed);
            if (speed > g->close_speed + 2 * vec3_length(g->gravity) * (real)c->h)
                note_impact(g, t, contact, k, speed, whole);
        }
    }
    if (b->roll)
        t->rolling = vec3_scale(1 / (real)c->h, (vec3){(real)b->roll->j[0][lane], (real)b->roll->j[1][lane], (real)b->roll->j[2][lane]});
    for (int k = 0; k < 2 && sum > 0; k++) {
        Member *m = &g->member[k ? t->b : t->a];
        if (m->dormant)
            m->pushed = g->woke = true;
    }
}

/* J  Given by movers through this contact: their velocity is constant. */
static real movers_work(const Group *g, const GroupContact *c)
{
    real work = 0;
    for (int k = 0; k < 2; k++) {
        int body = k ? c->b : c->a;
        if (!g->member[body].kinematic || !(c->point_weight > 0))
            continue;
        vec3 at = vec3_scale(1 / c->point_weight, c->point_sum);
        vec3 v = vec3_add(g->vel[body].v, vec3_cross(g->vel[body].w, vec3_sub(at, g->pos[body].x)));
        work += (k ? -1 : 1) * vec3_dot(c->impulse, v);
    }
    return work;
}

static void forget(Group *g)
{
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *c = &g->contacts[i];
        for (int k = 0; k < c->manifold.count; k++) {
            c->memory[k].normal = 0;
            c->memory[k].held = 0;
            c->memory[k].tangent = vec3_zero();
        }
        if (c->live)
            c->rolling = vec3_zero();
    }
}

void book_open(Crowd *c)
{
    c->g->lost += group_kinetic(c->g);
}

/* What forces gave, and kinetic energy has not got, is lost. */
static void book_energy(Crowd *c)
{
    Group *g = c->g;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (m->moves)
            g->lost += vec3_dot(m->force, vec3_sub(g->pos[i].x, m->start_pos.x)) + vec3_dot(m->torque, g->shift[i].w);
    }
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        vec3 way = vec3_add(vec3_sub(g->pos[p->body].x, g->member[p->body].start_pos.x), vec3_cross(g->shift[p->body].w, arm));
        real work = vec3_dot(p->force, way) + vec3_dot(p->torque, g->shift[p->body].w);
        g->push_work[p->body] += work;
        g->work_in += work;
    }
    g->lost -= group_kinetic(g);
}

void book_close(Crowd *c)
{
    Group *g = c->g;
    forget(g);
    for (int i = 0; i < c->batches; i++)
        for (int k = 0; k < LANES; k++)
            if (c->batch[i].contact[k] >= 0)
                book_lane(c, &c->batch[i], k);
    for (int i = 0; i < g->body_count; i++)
        if (g->member[i].moves || g->member[i].kinematic)
            g->shift[i].w = quat_log(quat_mul(g->pos[i].q, quat_conjugate(g->member[i].start_pos.q)));
    book_energy(c);
    for (int i = 0; i < g->contact_count; i++) {
        GroupContact *t = &g->contacts[i];
        if (!t->live)
            continue;
        real given = movers_work(g, t);
        g->work_in += given;
        g->lost += given;
        carry(g, t);
        for (int k = 0; k < t->manifold.count; k++)
            g->penetration = real_max(g->penetration, -t->manifold.points[k].gap);
    }
}
