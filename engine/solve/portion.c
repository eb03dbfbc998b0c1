/* solve/portion.c - into how many parts a step is cut that is swept, and how long the next substep may be.
 */
#include "solve/group.h"

/* rad: what is not round about its body's centre of mass and touches turns no farther in one piece, or its corners would be missed. */
#define TURN_MOST 0.15

/* Parts of a step that are as short for that as they get. Where what turns is so near that it may strike, they are shorter, as often as that costs about the
 * same for few bodies as for one: blows are looked for along a spin that stands still, as that of a box or of a tumbling rod does not. */
#define TURN_PARTS  32
#define WHIRL_PARTS 65536

#define ASIDE 0.01              /* of its size */

static bool angular_shape(const Shape *s) { return s->outer - s->inner > 0.01 * s->outer; }

/* A bounce is over when it would rise less than a hundred-thousandth of the size of what bounces. */
real group_close_speed(const Group *g)
{
    real size = INFINITY;
    for (int i = 0; i < g->pair_count; i++)
        size = real_min(size, g->pairs[i].size);
    return close_speed_of(size, g->fall);
}

#define FINER        4          /* times as many parts, for so few */
#define FINER_BODIES 8

#define WHIRLED    0.1          /* rad  in a part: an end of a joint that goes farther round opens it by a two-hundredth of its arm */
#define MOST_PARTS 32           /* of many bodies; of few as many as cost about the same */
#define FEW_PARTS  256

/* Parts in which no end of a joint goes farther round than that. What turns about the joint itself, as a wheel on its axle, does not. */
int sweep_whirled_parts(const Group *g, real dt)
{
    real most = 0;                  /* 1/s^2 */
    for (int i = 0; i < g->joint_count; i++) {
        const GroupJoint *j = &g->joints[i];
        const int body[2] = {j->a, j->b};
        for (int k = 0; k < 2 && !j->broken; k++) {
            if (body[k] < 0 || !g->member[body[k]].moves)
                continue;
            vec3 arm = quat_rotate(g->pos[body[k]].q, k ? j->rb : j->ra);
            real around = vec3_length2(vec3_cross(g->vel[body[k]].w, arm)), size = g->member[body[k]].outer;
            most = real_max(most, around / real_max(vec3_length2(arm), 0.01 * size * size));
        }
    }
    return (int)real_min(ceil(sqrt(most) * dt / WHIRLED), real_clamp(1024.0 / g->moving_count, MOST_PARTS, FEW_PARTS));
}

/* Into how many parts a step is cut. What contacts hold moves on by the velocities at the end of a part: that makes up or loses
 * energy in proportion to the part. Where the traced way was tried in vain, which is far dearer than sweeps of so few, it is to be less.
 * Of many that lie there one part has more of what sweeps there are: they creep the less. */
int sweep_parts(const Group *g)
{
    if (lies_uneasy(g))
        return 1;
    bool tried = (g->trace_failed || g->trace_wait > 0) && g->moving_count <= FINER_BODIES;
    return int_max(g->plan->substeps * (tried && g->plan->substeps >= SWEEP_FINE ? FINER : 1), g->joint_count > 0 ? g->whirled_parts : 1);
}

#define SWAYED     0.5          /* rad  in a part, of what sways at its stops: it gains from 2 on, and joints that share a body at less */
#define SWAY_WORK  4096.0       /* bodies times parts */
#define SWAY_PARTS 4            /* of ever so many bodies */

static int swayed_parts(Group *g, real dt)
{
    if (g->joint_count == 0 || g->joints_direct)
        return 1;
    return (int)real_min(ceil(group_sways(g, dt) * dt / SWAYED), real_clamp(SWAY_WORK / g->moving_count, SWAY_PARTS, FEW_PARTS));
}

/* m  How far a turn may bring it out of where it is: by its corners, or round as it is, since it is beside the centre of mass. That what has corners may
 * lie aside, too, is left out. */
static real play_of(const Form *f)
{
    real aside = 2 * vec3_length(f->arm);
    return angular_shape(&f->shape) ? f->shape.outer - f->shape.inner : aside > ASIDE * f->shape.outer ? aside : 0;
}

/* rad/s */
static real turning(const Group *g, int body, const Form *f) { return play_of(f) > 0 ? vec3_length(g->vel[body].w) : 0; }

/* m */
static real play(const Group *g, int body, const Form *f) { return turning(g, body, f) > 0 ? play_of(f) : 0; }

/* s  For so long the two do not meet, whichever way they turn. */
static real clear_for(const Group *g, const GroupPair *q)
{
    real room = play(g, q->a, q->on_a) + play(g, q->b, q->on_b), first = INFINITY;
    for (int k = q->contact; k < q->contact + q->contacts; k++) {
        const GroupManifold *m = &g->contacts[k].manifold;
        real closing = vec3_dot(m->normal, vec3_sub(g->vel[q->a].v, g->vel[q->b].v));
        for (int p = 0; g->contacts[k].live && p < m->count; p++) {
            real open = m->points[p].gap - room;
            first = real_min(first, open <= 0 ? 0 : closing > 0 ? open / closing : INFINITY);
        }
    }
    return first;
}

#define SPUN_UP 2               /* times as many parts: a blow within the step made it whirl */

#define WHIRL_COUNT 16384       /* over the square of how many they are, */
#define WHIRL_MOST  4096        /* and for few so many */

int sweep_whirls(const Group *g)
{
    return int_min(WHIRL_MOST, WHIRL_COUNT / int_max(g->moving_count, 1) / int_max(g->moving_count, 1));
}

/* s  In which what turns near something turns little. late: no more impacts are located; what is clear needs no short pieces then. */
static real turning_piece(Group *g, real dt, bool late)
{
    real piece = INFINITY, part = dt / TURN_PARTS, shortest = g->whirls_left > 0 ? dt / WHIRL_PARTS : part;
    for (int i = 0; i < g->pair_count; i++) {
        const GroupPair *q = &g->pairs[i];
        bool live = false;
        for (int k = q->contact; k < q->contact + q->contacts; k++)
            live = live || g->contacts[k].live;
        real spin = live ? real_max(turning(g, q->a, q->on_a), turning(g, q->b, q->on_b)) : 0, turn = TURN_MOST / real_max(spin, 1e-9);
        if (turn < part)        /* of how deep a corner is in many pieces nobody knows, so that no substep is halved for it */
            piece = real_min(piece, real_max(real_max(shortest, q->contacts > 1 ? turn / 3 : turn), real_min(late ? dt : part, clear_for(g, q))));
        else if (!late)
            piece = real_min(piece, turn);
    }
    g->whirls_left -= piece < part;
    return piece;
}

/* s  How long the next substep may be. */
real sweep_longest_piece(Group *g, real dt)
{
    int whirled = g->joint_count > 0 ? sweep_whirled_parts(g, dt) : 0;
    real longest = dt / int_max(whirled > SPUN_UP * sweep_parts(g) ? whirled : 1, swayed_parts(g, dt));
    if (!g->locate)
        return longest;
    bool late = g->events_left <= 0;
    return real_min(late ? real_min(longest, missing_little(g, dt)) : longest, turning_piece(g, dt, late));
}
