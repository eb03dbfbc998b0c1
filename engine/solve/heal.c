/* solve/heal.c - position errors that velocities take off, where joints are solved with their contacts: a body moved by itself would pull
 * at joints so stiff that it is thrown back. */
#include "solve/group.h"

/* Part of a position error that velocities take off in a substep, and the most, m/s and rad/s. */
#define HEAL_PART 0.2
#define HEAL_SPEED 3.0
#define HEAL_SPIN 20.0

/* What is off by more than that (m/s), and by this part of what it is to heal by, contradicts itself. */
#define JAMMED      1e-3
#define JAMMED_PART 0.1

static real heal_rate(const Group *g, real error, real most) { return real_clamp(HEAL_PART * error / g->heal_over, -most, most); }

/* Of the smallest body, and rad: no substep runs past a stop of an angle or a way by that. Then the stop was set there. Lines under a load are
 * longer than they are. */
#define PASSED 1e-4

static bool has_stops(const Group *g, const JointBlock *b) { return g->joints[b->joint].view.type->coordinate_row; }

static bool is_passed(const Group *g, const JointRow *r)
{
    real size = INFINITY;
    for (int k = 0; k < r->row.count; k++)
        size = r->row.body[k] < 0 ? size : real_min(size, g->member[r->row.body[k]].outer);
    return r->row.kind == ROW_LIMIT && r->row.error < -PASSED * (r->row.angular ? 1 : size);
}

bool group_stops_passed(const Group *g)
{
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count && has_stops(g, &g->blocks[i]); k++) {
            const JointRow *r = &g->rows[g->blocks[i].first + k];
            if (r->p > 0 && is_passed(g, r))
                return true;
        }
    return false;
}

/* They keep what is behind them from going on, and no more. */
static void keep_stops(Group *g)
{
    for (int i = 0; i < g->block_count; i++)
        for (int k = 0; k < g->blocks[i].count && has_stops(g, &g->blocks[i]); k++) {
            JointRow *r = &g->rows[g->blocks[i].first + k];
            if (is_passed(g, r))
                r->bias += heal_rate(g, r->row.error, r->row.angular ? HEAL_SPIN : HEAL_SPEED);
        }
}

real group_heal(Group *g)
{
    real most = 0;
    for (int i = 0; i < g->row_count; i++) {
        JointRow *r = &g->rows[i];
        if (r->row.kind == ROW_MOTOR && r->row.error < 0 && (r->lo == 0 || r->hi == 0))      /* goes along with its stop */
            r->bias += copysign(heal_rate(g, r->row.error, r->row.angular ? HEAL_SPIN : HEAL_SPEED), -r->row.rate);
        if (r->row.kind != ROW_HARD && !(r->row.kind == ROW_LIMIT && r->row.error < 0))
            continue;
        real rate = heal_rate(g, r->row.error, r->row.angular ? HEAL_SPIN : HEAL_SPEED);
        r->bias -= rate;
        most = real_max(most, r->row.angular ? 0 : fabs(rate));
    }
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        real gap = g->contacts[r->contact].manifold.points[r->point].gap;
        if (gap >= 0 || r->curved)              /* welds put right what they hold together */
            continue;
        real rate = heal_rate(g, -gap, HEAL_SPEED);
        r->target = real_max(r->target, rate);
        most = real_max(most, rate);
    }
    if (g->stops_kept)
        keep_stops(g);
    return most;
}

bool group_jams(const Group *g, real heals) { return heals > 0 && g->residual > real_max(JAMMED, JAMMED_PART * heals); }

/* Healing throws things when it makes a body so many times faster than itself, is this part of the energy that is gained, and that is more
 * than there was: a limb that is wedged near its joint would have to whirl. Where nothing overlaps, joints alone may fling what is light. */
#define THROWN      2.0
#define THROWN_PART 0.5
#define THROWS      0.1         /* m/s  what heals slower throws nothing */

/* m/s  Of any of its points, how much faster the substep has made the body that it has done most to. */
static real most_thrown(const Group *g)
{
    real most = 0;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        vec3 spin = vec3_sub(g->vel[i].w, g->start_vel[i].w);
        if (m->moves)
            most = real_max(most, vec3_length(vec3_sub(g->vel[i].v, g->start_vel[i].v)) +
                                      (vec3_length2(spin) > 0 ? vec3_length(spin) * m->outer : 0));
    }
    return most;
}

/* J  Of what the last solve's impulses did, what came of speeds that part what overlaps. */
static real parting_work(const Group *g)
{
    real work = 0;
    for (int i = 0; i < g->point_count; i++)
        work += 0.5 * g->points[i].jn * real_max(g->points[i].target, 0);
    return work;
}

/* J  The same of speeds that close joints. */
static real closing_work(const Group *g)
{
    real work = 0;
    for (int i = 0; i < g->row_count; i++) {
        const JointRow *r = &g->rows[i];
        if (r->row.kind == ROW_HARD || (r->row.kind == ROW_LIMIT && r->row.error < 0))
            work += 0.5 * fabs(r->p * heal_rate(g, r->row.error, r->row.angular ? HEAL_SPIN : HEAL_SPEED));
    }
    return work;
}

/* J  That all of them got in this substep, but for the work of forces; *before: what they had. */
static real gain_of(const Group *g, real *before)
{
    real gain = *before = 0;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        vec3 w = quat_unrotate(g->start_pos[i].q, g->start_vel[i].w);
        if (!m->moves)
            continue;
        real had = 0.5 * m->mass * vec3_length2(g->start_vel[i].v) + 0.5 * vec3_dot(w, mat3_mul_vec(*m->inertia, w));
        gain += group_kinetic_of(g, i) - had - 0.5 * g->h * vec3_dot(m->force, vec3_add(g->start_vel[i].v, g->vel[i].v));
        *before += had;
    }
    return gain;
}

bool group_throws(const Group *g, real heals)
{
    real thrown = heals > THROWS ? most_thrown(g) : 0, before;
    if (!(thrown > THROWN * heals))
        return false;
    real gain = gain_of(g, &before), parting = parting_work(g), work = parting > 0 ? parting + closing_work(g) : 0;
    return gain > before && work > THROWN_PART * gain;
}

/* Impulses that wanted what cannot be have grown from substep to substep, and are no guess. */
void group_unwind(Group *g)
{
    for (int i = 0; i < g->point_count; i++)
        g->points[i].jn = g->points[i].jt[0] = g->points[i].jt[1] = 0;
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = 0;
}
