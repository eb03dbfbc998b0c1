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

real group_heal(Group *g)
{
    real most = 0;
    for (int i = 0; i < g->row_count; i++) {
        JointRow *r = &g->rows[i];
        if (r->row.kind != ROW_HARD && !(r->row.kind == ROW_LIMIT && r->row.error < 0))
            continue;
        real rate = heal_rate(g, r->row.error, r->row.angular ? HEAL_SPIN : HEAL_SPEED);
        r->bias -= rate;
        most = real_max(most, r->row.angular ? 0 : fabs(rate));
    }
    for (int i = 0; i < g->point_count; i++) {
        PointRow *r = &g->points[i];
        real gap = g->contacts[r->contact].manifold.points[r->point].gap;
        if (gap >= 0)
            continue;
        real rate = heal_rate(g, -gap, HEAL_SPEED);
        r->target = real_max(r->target, rate);
        most = real_max(most, rate);
    }
    return most;
}

bool group_jams(const Group *g, real heals) { return heals > 0 && g->residual > real_max(JAMMED, JAMMED_PART * heals); }

/* Impulses that wanted what cannot be have grown from substep to substep, and are no guess. */
void group_unwind(Group *g)
{
    for (int i = 0; i < g->point_count; i++)
        g->points[i].jn = g->points[i].jt[0] = g->points[i].jt[1] = 0;
    for (int i = 0; i < g->row_count; i++)
        g->rows[i].p = 0;
}
