/* chain/lanes.c - bodies and joints of a group become links and ties, four side by side, and what came out is the group's again. */
#include "chain/system.h"
#include "base/wide.h"

/* A function of each four links or ties, compiled plainly and for wide registers. */
#define FOR_WIDTHS(name, part) \
    static void name##_plain(Chain *c, const Linkage *t) { part(c, t); } \
    WIDE static void name##_wide(Chain *c, const Linkage *t) { part(c, t); } \
    void name(Chain *c, const Linkage *t) { (has_wide() ? name##_wide : name##_plain)(c, t); }

/* ---- vectors that lie anywhere ---- */

INLINE four four_at(const real *x) { return *(const four_any *)(const void *)x; }

/* What comes after each is read, too, and means nothing. */
INLINE four3 four3_from(const real *a, const real *b, const real *c, const real *d)
{
    four rest, v[LANES] = {four_at(a), four_at(b), four_at(c), four_at(d)};
    return four3_together(v, &rest);
}

INLINE four_quat four_quat_from(const quat *a, const quat *b, const quat *c, const quat *d)
{
    four w, v[LANES] = {four_at(&a->x), four_at(&b->x), four_at(&c->x), four_at(&d->x)};
    four3 xyz = four3_together(v, &w);
    return (four_quat){xyz.x, xyz.y, xyz.z, w};
}

/* Nothing may come after a matrix: of its last row what comes before is read. */
INLINE four33 four33_from(const mat3 *a, const mat3 *b, const mat3 *c, const mat3 *d)
{
    four last[LANES] = {four_at(&a->r1.z), four_at(&b->r1.z), four_at(&c->r1.z), four_at(&d->r1.z)};
    four_transpose(last);
    return (four33){four3_from(&a->r0.x, &b->r0.x, &c->r0.x, &d->r0.x), four3_from(&a->r1.x, &b->r1.x, &c->r1.x, &d->r1.x),
                    {last[1], last[2], last[3]}};
}

/* Nothing else is written. */
INLINE void put_vec(vec3 *to, four v)
{
    PAIR(to->x) = SHUFFLE(v, v, 0, 1);
    to->z = v[2];
}

/* ---- at the start ---- */

/* A lane without a body: it stands still. */
static const mat3 unit = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const Member nobody = {.mass = 1, .inertia = &unit, .inv_inertia = &unit};
static const Pos nowhere = {{0, 0, 0}, {0, 0, 0, 1}};
static const Vel rest[2];       /* with what is read after it */

INLINE void open_links(const Chain *c, Links *l)
{
    const Group *g = c->g;
    const Member *m[LANES];
    const Pos *p[LANES];
    const Vel *v[LANES];
    for (int k = 0; k < LANES; k++) {
        int body = l->body[k];
        m[k] = body < 0 ? &nobody : &g->member[body];
        p[k] = body < 0 ? &nowhere : &g->pos[body];
        v[k] = body < 0 ? rest : &g->vel[body];
    }
    l->mass = (four){m[0]->mass, m[1]->mass, m[2]->mass, m[3]->mass};
    l->inertia = four33_from(m[0]->inertia, m[1]->inertia, m[2]->inertia, m[3]->inertia);
    l->inverse = four33_from(m[0]->inv_inertia, m[1]->inv_inertia, m[2]->inv_inertia, m[3]->inv_inertia);
    l->force = four3_from(&m[0]->force.x, &m[1]->force.x, &m[2]->force.x, &m[3]->force.x);
    l->torque = four3_from(&m[0]->torque.x, &m[1]->torque.x, &m[2]->torque.x, &m[3]->torque.x);
    l->x = four3_from(&p[0]->x.x, &p[1]->x.x, &p[2]->x.x, &p[3]->x.x);
    l->q = four_quat_from(&p[0]->q, &p[1]->q, &p[2]->q, &p[3]->q);
    l->v = four3_from(&v[0]->v.x, &v[1]->v.x, &v[2]->v.x, &v[3]->v.x);
    l->w = four3_from(&v[0]->w.x, &v[1]->w.x, &v[2]->w.x, &v[3]->w.x);
}

INLINE void open_tree(Chain *c, const Linkage *t)
{
    four most = four_all(0);
    for (Links *l = c->links + t->first; l < c->links + t->last; l++) {
        open_links(c, l);
        most = four_most(most, four3_dot(l->w, l->w));
        l->r = four_quat_matrix(l->q);
        l->w = four33_back3(&l->r, l->w);
        for (Ends *e = c->ends + l->end; e < c->ends + l->end + l->ends; e++)
            e->impulse = e->twist = four3_zero();
    }
    c->spin = sqrt(real_max(real_max(most[0], most[1]), real_max(most[2], most[3])));
    c->began = motion_of(c, t);
}
FOR_WIDTHS(links_open, open_tree)

/* ---- joints ---- */

/* Four ties of a tree, in lanes. */
typedef struct Four { int count, joint[LANES]; } Four;

/* The last ones may be fewer: the lanes that are left are of the first of them. */
INLINE Four four_ties(const Chain *c, const Linkage *t, int first)
{
    Four f = {int_min(LANES, t->last_tie - first), {0}};
    for (int k = 0; k < LANES; k++)
        f.joint[k] = c->owned[k < f.count ? first + k : first];
    return f;
}

/* Of b, in which a joint's force is kept from step to step. */
INLINE four_quat frames_of(const Chain *c, const Four *f)
{
    const Group *g = c->g;
    const quat *q[LANES], *frame[LANES];
    quat fixed[LANES];
    for (int k = 0; k < LANES; k++) {
        const GroupJoint *j = &g->joints[f->joint[k]];
        frame[k] = &j->fb;
        if (c->tie[f->joint[k]].end[1] >= 0) {
            q[k] = &g->pos[j->b].q;
        } else {
            fixed[k] = fixed_pose(g, j->b, 0).q;
            q[k] = &fixed[k];
        }
    }
    return four_quat_mul(four_quat_from(q[0], q[1], q[2], q[3]), four_quat_from(frame[0], frame[1], frame[2], frame[3]));
}

/* Joints push as in the last step, at both ends. */
INLINE void guess_ties(Chain *c, const Linkage *t)
{
    const GroupJoint *j = c->g->joints;
    for (int n = t->first_tie; n < t->last_tie; n += LANES) {
        const Four f = four_ties(c, t, n);
        four3 force = four3_from(j[f.joint[0]].force, j[f.joint[1]].force, j[f.joint[2]].force, j[f.joint[3]].force);
        four3 p = four3_scale(four_all(c->h), four_quat_rotate(frames_of(c, &f), force));
        for (int k = 0; k < f.count; k++) {
            Tie *tie = &c->tie[f.joint[k]];
            tie->h = c->h;
            tie->twist = vec3_zero();
            for (int side = 0; side < 2; side++)
                if (tie->end[side] >= 0)
                    four3_put(&ends_of(c, tie->end[side])->p, lane_of(tie->end[side]), four3_get(&p, k));
        }
    }
}
FOR_WIDTHS(ties_guess, guess_ties)

/* ---- at the end ---- */

INLINE void close_links(Chain *c, const Linkage *t)
{
    Group *g = c->g;
    for (const Links *l = c->links + t->first; l < c->links + t->last; l++) {
        four x[LANES], q[LANES] = {l->q.x, l->q.y, l->q.z, l->q.w}, v[LANES], w[LANES];
        four3_apart(l->x, four_all(0), x);
        four_transpose(q);
        four3_apart(l->v, four_all(0), v);
        four3_apart(four_quat_rotate(l->q, l->w), four_all(0), w);
        for (int k = 0; k < LANES && l->body[k] >= 0; k++) {
            const int body = l->body[k];
            put_vec(&g->pos[body].x, x[k]);
            *(four_any *)(void *)&g->pos[body].q = q[k];
            put_vec(&g->vel[body].v, v[k]);
            put_vec(&g->vel[body].w, w[k]);
            g->member[body].constrained |= l->count[k] > 0;
        }
    }
}
FOR_WIDTHS(links_close, close_links)

/* N s, N m s  By the joint on its body a or b. */
INLINE vec3 twist_at(const Chain *c, const Tie *t, int side)
{
    return t->end[side] < 0 ? t->twist : four3_get(&ends_of(c, t->end[side])->twist, lane_of(t->end[side]));
}

/* Poses are those of the end. */
INLINE void close_ties(Chain *c, const Linkage *t)
{
    for (int n = t->first_tie; n < t->last_tie; n += LANES) {
        const Four f = four_ties(c, t, n);
        four3 p = four3_zero();
        four h = four_all(1);
        for (int k = 0; k < f.count; k++) {
            const Tie *tie = &c->tie[f.joint[k]];
            GroupJoint *j = &c->g->joints[f.joint[k]];
            const int end = moving_end(tie), lane = lane_of(end);
            const Ends *e = ends_of(c, end);
            j->impulse = vec3_scale(e->side[lane], four3_get(&e->impulse, lane));
            j->angular_impulse = twist_at(c, tie, 0);
            four3_put(&p, k, four3_get(&e->p, lane));
            h[k] = tie->h;
        }
        four force[LANES];
        four3_apart(four3_scale(1.0 / h, four_quat_rotate(four_quat_conjugate(frames_of(c, &f)), p)), four_all(0), force);
        for (int k = 0; k < f.count; k++) {
            GroupJoint *j = &c->g->joints[f.joint[k]];
            memset(j->force, 0, sizeof j->force);
            memcpy(j->force, &force[k], TIE_ROWS * sizeof *j->force);
        }
    }
}
FOR_WIDTHS(ties_close, close_ties)

vec3 tie_twist_on_b(const Chain *c, int joint) { return twist_at(c, &c->tie[joint], 1); }
