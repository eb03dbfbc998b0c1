/* crowd/through.c - does anything pass through what is thin, or through a mesh, in a crowd?
 *
 * Rows are as straight as poses were at the start of a piece, and what turns by a radian within one goes by where they do not hold: 12 of 6000
 * hulls of 1 cm that came at 200 m/s on a wall of 1 mm got through at "sketch". So where few are fast for how thin they are, each piece is looked
 * at when it is done, along the chord of what each body did in it. If something was past the middle of the thinner one the step is put back, and
 * swept: there substeps are halved until nothing is (solve/sweep.c). Many are not swept for one: what went through something that does not give
 * way is put back along its chord to where they met, with the velocity it has. The next piece has a contact there, which stops it. So is, of many or
 * few, what crossed a mesh.
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

/* Straight to where it is from where it was at the start of the piece. */
static Motion chord_of(const Crowd *c, int body, pose local)
{
    const Member *m = &c->g->member[body];
    const Pos *to = &c->g->pos[body];
    if (!m->moves && !m->kinematic)
        return (Motion){.start = pose_mul((pose){to->x, to->q}, local), .centre = pose_unpoint(local, vec3_zero())};
    const Carriage *k = carriage_of(c, body);
    quat from = quat_mul(quat_exp(vec3_scale(-1, m->swerve)), to->q);
    return (Motion){.start = pose_mul((pose){k->from, from}, local), .centre = pose_unpoint(local, vec3_zero()),
                    .v = vec3_scale(1 / c->dt, vec3_sub(k->to, k->from)), .w = vec3_scale(1 / c->dt, m->swerve)};
}

/* met: s into the piece; it may be NULL. */
static bool went_through(const Crowd *c, const GroupPair *q, real *met)
{
    Motion a = chord_of(c, q->a, pair_local(q, false)), b = chord_of(c, q->b, pair_local(q, true));
    real travel;
    if (!is_fast(c, q, &a, &b, c->dt, &travel) || !group_went_through(q, &a, &b, c->dt, group_thin(q), travel))
        return false;
    if (met)
        *met = time_of_impact(&q->on_a->shape, &a, &q->on_b->shape, &b, 0, c->dt, NULL);
    return true;
}

bool crowd_passed(const Crowd *c)
{
    const Group *g = c->g;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        if ((c->trait[q->a].moves || c->trait[q->b].moves) && went_through(c, q, NULL))
            return true;
    }
    return false;
}

typedef struct Passing { const Crowd *c; uint8_t *passed; } Passing;       /* [pair_count of g] */

/* Can the other not give way? */
static bool is_wall(const Crowd *c, const GroupPair *q) { return c->trait[q->a].moves != c->trait[q->b].moves; }

/* Meshes and height fields have no inside to be deep in: who was on this side of one with its middle and is on that side went through. What turns
 * there goes round its middle. It had to stop where as much of it as it is thick was before the surface, along its way. */
static bool crossed(const Crowd *c, const GroupPair *q, real *met)
{
    bool first = q->on_a->shape.inner > 0;
    const Shape *body = first ? &q->on_a->shape : &q->on_b->shape, *surface = first ? &q->on_b->shape : &q->on_a->shape;
    Motion by_a = chord_of(c, q->a, pair_local(q, false)), by_b = chord_of(c, q->b, pair_local(q, true));
    const Motion *moves = first ? &by_a : &by_b, *stands = first ? &by_b : &by_a;
    vec3 from = pose_unpoint(motion_at(stands, 0), pose_point(motion_at(moves, 0), shape_middle(body)));
    vec3 way = vec3_sub(pose_unpoint(motion_at(stands, c->dt), pose_point(motion_at(moves, c->dt), shape_middle(body))), from);
    real length = vec3_length(way);
    RayHit hit;
    if (!(length > body->inner) || !surface->type->ray(surface, &(Ray){from, vec3_scale(1 / length, way), length}, &hit))
        return false;
    *met = c->dt * real_max(0, hit.distance - body->inner) / length;
    return true;
}

/* Past what does not give way; planes are deep all the way. In a crowd of few that is kept for sweeps, these are what walls need. */
static bool passed_wall(const Crowd *c, const GroupPair *q, real *met)
{
    real a = q->on_a->shape.inner, b = q->on_b->shape.inner;
    if (!is_wall(c, q) || !isfinite(a + b))
        return false;
    return a > 0 && b > 0 ? !c->before && went_through(c, q, met) : (a > 0 || b > 0) && crossed(c, q, met);
}

static void passed_share(void *context, int thread, int threads)
{
    const Passing *x = context;
    const Group *g = x->c->g;
    real met;
    for (int i = team_first(g->pair_count, thread, threads), end = team_end(g->pair_count, thread, threads); i < end; i++)
        x->passed[i] = passed_wall(x->c, &g->pairs[i], &met);
}

dig_status crowd_hold_back(Crowd *c)
{
    Group *g = c->g;
    if (!(bodies_farthest(c) > 0.5 * c->thinnest))  /* both insides of a pair make all of that at least, one beside a mesh half of it */
        return DIG_OK;
    Passing x = {c, arena_alloc(g->lasting, (size_t)g->pair_count + 1)};
    if (!x.passed)
        return DIG_E_MEMORY;
    team_deal(c->team, passed_share, &x);
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        int body = c->trait[q->a].moves ? q->a : q->b, wall = body == q->a ? q->b : q->a;
        real met;
        if (!x.passed[i] || !passed_wall(c, q, &met))      /* another wall may have held it back already */
            continue;
        Motion motion = chord_of(c, wall, pose_identity());
        body_hold_back(c, body, met / c->dt, vec3_scale(c->dt - met, motion_velocity(&motion, g->pos[body].x, met)));
    }
    return DIG_OK;
}
