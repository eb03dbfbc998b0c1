/* conserve/romberg.c - runs in 2, 4, 8, ... parts over one frame step, extrapolated to infinitely many. */
#include "conserve/system.h"

dig_status romberg_open(Romberg *r, const Group *g)
{
    *r = (Romberg){.bodies = g->moving_count, .error = INFINITY};
    r->last = arena_zero(g->arena, (size_t)(ROMBERG_ROWS * r->bodies) * sizeof *r->last);
    return r->last ? DIG_OK : DIG_E_MEMORY;
}

static Moved moved_of(const Group *g, const GroupKept *from, int i)
{
    vec3 turn = quat_log(quat_mul(g->pos[i].q, quat_conjugate(from->pos[i].q)));
    return (Moved){vec3_sub(g->pos[i].x, from->pos[i].x), turn, g->vel[i].v, g->vel[i].w};
}

/* From column k to the next, whose error is of an order higher by two: of the difference between two rows. */
static real share_of(int k) { return 1 / (real)((4 << 2 * k) - 1); }

static vec3 onward(vec3 fine, vec3 coarse, real share) { return vec3_mad(fine, share, vec3_sub(fine, coarse)); }

static Moved moved_onward(const Moved *fine, const Moved *coarse, real share)
{
    return (Moved){onward(fine->x, coarse->x, share), onward(fine->turn, coarse->turn, share),
                   onward(fine->v, coarse->v, share), onward(fine->w, coarse->w, share)};
}

/* The error is how far the last two columns are apart, in place: velocities along what is held back are worth little, for they are
 * gone within a step. */
void romberg_enter(Romberg *r, const Group *g, const GroupKept *from)
{
    real worst = 0, lost = g->lost;
    for (int i = 0; i < r->bodies; i++) {
        Moved now = moved_of(g, from, i);
        for (int k = 0; k <= r->rows; k++) {
            Moved *at = &r->last[k * r->bodies + i], coarse = *at;
            *at = now;
            now = moved_onward(at, &coarse, share_of(k));
        }
        const Moved *best = &r->last[r->rows * r->bodies + i], *other = best - (r->rows > 0 ? r->bodies : 0);
        worst = real_max(worst, vec3_distance(best->x, other->x) + g->member[i].outer * vec3_distance(best->turn, other->turn));
    }
    for (int k = 0; k <= r->rows; k++) {
        real coarse = r->lost[k];
        r->lost[k] = lost;
        lost += share_of(k) * (lost - coarse);
    }
    r->error = r->rows > 0 ? worst : INFINITY;
    r->rows++;
}

void romberg_take(const Romberg *r, Group *g, const GroupKept *from)
{
    for (int i = 0; i < r->bodies; i++) {
        const Moved *m = &r->last[(r->rows - 1) * r->bodies + i];
        if (!g->member[i].moves)
            continue;
        g->pos[i] = (Pos){vec3_add(from->pos[i].x, m->x), quat_unit(quat_mul(quat_exp(m->turn), from->pos[i].q))};
        g->vel[i] = (Vel){m->v, m->w};
        group_refresh_mass(g, i);
    }
    g->lost = r->lost[r->rows - 1];
}
