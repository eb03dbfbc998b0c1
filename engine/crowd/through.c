/* crowd/through.c - does anything pass through what is thin, in a crowd of few bodies?
 *
 * Rows are as straight as poses were at the start of a piece, and what turns by a radian within one goes by where they do not hold: 12 of 6000
 * hulls of 1 cm that came at 200 m/s on a wall of 1 mm got through at "sketch". So where few are fast for how thin they are, each piece is looked
 * at when it is done, along the chord of what each body did in it. If something was past the middle of the thinner one the step is put back, and
 * swept: there substeps are halved until nothing is (solve/sweep.c).
 */
#include "crowd/system.h"

#define FEW 64                  /* bodies: more are not swept for it */

static Motion rates_of(const Crowd *c, int body)
{
    const Vel *v = &c->g->vel[body];
    return (Motion){.v = v->v, .w = c->trait[body].moves ? v->w : vec3_zero()};
}

/* Does it move farther than both are thick? */
static bool is_fast(const Crowd *c, const GroupPair *q, const Motion *a, const Motion *b, real dt, real *travel)
{
    *travel = group_travel(c->g, q, a, b, dt);
    return q->contacts == 1 && *travel > q->on_a->shape.inner + q->on_b->shape.inner;
}

bool crowd_may_pass(const Crowd *c, int pieces)
{
    const Group *g = c->g;
    if (c->bodies > FEW || g->pieces > 0)
        return false;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        Motion a = rates_of(c, q->a), b = rates_of(c, q->b);
        real travel;
        if (is_fast(c, q, &a, &b, c->dt / pieces, &travel))
            return true;
    }
    return false;
}

/* From where it was at the start of the piece straight to where it is. */
static Motion chord_of(const Crowd *c, int body, pose local)
{
    const Group *g = c->g;
    const Pos *from = &g->start_pos[body], *to = &g->pos[body];
    pose start = {vec3_add(from->x, quat_rotate(from->q, local.p)), quat_mul(from->q, local.q)};
    vec3 turn = quat_log(quat_mul(to->q, quat_conjugate(from->q)));
    return (Motion){.start = start, .centre = pose_unpoint(local, vec3_zero()),
                    .v = vec3_scale(1 / c->dt, vec3_sub(to->x, from->x)), .w = vec3_scale(1 / c->dt, turn)};
}

bool crowd_passed(const Crowd *c)
{
    const Group *g = c->g;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if (!c->trait[q->a].moves && !c->trait[q->b].moves)
            continue;
        Motion a = chord_of(c, q->a, pair_local(q, false)), b = chord_of(c, q->b, pair_local(q, true));
        real travel;
        if (is_fast(c, q, &a, &b, c->dt, &travel) && group_went_through(q, &a, &b, c->dt, group_thin(q), travel))
            return true;
    }
    return false;
}
