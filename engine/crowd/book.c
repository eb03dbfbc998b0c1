/* crowd/book.c - what the solve found goes to the group's records: forces, points, impacts, energy. */
#include "crowd/system.h"

/* The turn is exact: what turns for ever about one axis would move its points outward by half its square in every step. */
static vec3 carried(const Crowd *c, int body, vec3 at)
{
    if (!c->trait[body].moves && !c->trait[body].kinematic)
        return at;
    const Carriage *k = carriage_of(c, body);
    return vec3_add(k->to, mat3_mul_vec(k->turn, vec3_sub(at, k->from)));
}

/* Points go with their bodies; the gap changes by what the row saw. */
static void carry(const Crowd *crowd, GroupContact *c)
{
    Group *g = crowd->g;
    GroupPair *q = &g->pairs[c->pair];
    for (int k = 0; k < c->manifold.count; k++) {
        ManifoldPoint *p = &c->manifold.points[k];
        p->a = carried(crowd, c->a, p->a);
        p->b = carried(crowd, c->b, p->b);
        p->gap = vec3_dot(c->manifold.normal, vec3_sub(p->b, p->a));
    }
    if (c->manifold.count >= 3) {
        const Trait *a = &crowd->trait[c->a], *b = &crowd->trait[c->b];
        int side = a->moves && !(a->round && b->moves) ? c->a : c->b;
        if (!a->moves || !b->moves)
            side = a->moves ? c->b : c->a;
        if (crowd->trait[side].moves || crowd->trait[side].kinematic)
            c->manifold.normal = vec3_unit(mat3_mul_vec(carriage_of(crowd, side)->turn, c->manifold.normal));
        if (q->contacts == 1)           /* others may be in other threads' hands */
            crowd_sign(g, q);
    }
}

static bool strikes(const Crowd *c, real speed)
{
    return speed > c->g->close_speed + 2 * c->g->fall * (real)c->h;
}

static bool pushes_sleeper(const Crowd *c, const GroupContact *t, real sum)
{
    return sum > 0 && (c->trait[t->a].dormant || c->trait[t->b].dormant);
}

/* Strikes are listed in the order of batches, and sleepers are marked, by one thread: what concerns more than the contact. */
static void note_batch(Crowd *c, const Batch *b)
{
    Group *g = c->g;
    for (int lane = 0; lane < LANES && b->contact[lane] >= 0; lane++) {
        const GroupContact *t = &g->contacts[b->contact[lane]];
        real sum = 0;
        for (int k = 0; k < t->manifold.count; k++) {
            real whole = (real)b->point[k].sum[lane], speed = -(real)b->point[k].rate_before[lane];
            PointRow r = {.contact = b->contact[lane], .point = k, .a = t->a, .b = t->b, .jn = whole};
            sum += whole;
            if (whole > 0)
                g->pairs[t->pair].approach = real_max(g->pairs[t->pair].approach, speed);
            if (!(whole > 0) || !strikes(c, speed))
                continue;
            g->member[t->a].collided = g->member[t->b].collided = true;
            strike_report(g, &r, speed);
        }
        for (int k = 0; k < 2 && pushes_sleeper(c, t, sum); k++) {
            Member *m = &g->member[k ? t->b : t->a];
            if (m->dormant)
                m->pushed = g->woke = true;
        }
    }
}

/* Room for a strike of each contact that may have one. */
static dig_status reserve_strikes(Crowd *c)
{
    Group *g = c->g;
    for (int i = 0; i < c->batches; i++)
        g->strike_capacity += c->batch[i].noted ? LANES : 0;
    g->strikes = arena_alloc(g->arena, (size_t)(g->strike_capacity + 1) * sizeof *g->strikes);
    return g->strikes ? DIG_OK : DIG_E_MEMORY;
}

/* Friction at the middle becomes forces at the points. */
static void book_friction(GroupContact *t, const Batch *b, int lane, real h, real load)
{
    vec3 n = t->manifold.normal, u, v, middle = vec3_zero();
    int count = t->manifold.count;
    real spread = 0, twist = b->twist ? (real)b->twist->j[lane] : 0;
    vec3_basis(n, &u, &v);
    vec3 force = vec3_add(vec3_scale((real)b->patch->j[0][lane], u), vec3_scale((real)b->patch->j[1][lane], v));
    vec3 whole = vec3_add(vec3_scale((real)b->patch->sum[0][lane], u), vec3_scale((real)b->patch->sum[1][lane], v));
    t->impulse = vec3_add(t->impulse, whole);
    real part = 1.0 / count, per_load = load > 0 ? 1 / load : 0, rate = 1 / h;
    if (twist != 0) {
        for (int k = 0; k < count; k++)
            middle = vec3_mad(middle, 0.5 * part, vec3_add(t->manifold.points[k].a, t->manifold.points[k].b));
        for (int k = 0; k < count; k++)
            spread += vec3_length2(vec3_sub(t->manifold.points[k].a, middle));
    }
    real turn = spread > 0 ? rate * twist / spread : 0;
    force = vec3_scale(rate, force);
    for (int k = 0; k < count; k++) {
        vec3 tangent = vec3_scale(load > 0 ? t->memory[k].normal * h * per_load : part, force);
        if (turn != 0)
            tangent = vec3_mad(tangent, turn, vec3_cross(n, vec3_sub(t->manifold.points[k].a, middle)));
        t->memory[k].tangent = tangent;
    }
}

#define YIELDS 0.1              /* s: soft rows carry a load by overlap at first, and after some of this without; by as much sooner as
                                 * there are passes, for then the load has come through */

/* N  What of a force a soft row need not carry by overlap: what it has carried for long. Else piles sink under their own weight, and
 * overlap that no motion can take away, for contacts all around hold it, waits until the load has grown enough to open one of them. Not
 * where points share the load, and may exchange it. */
static float borne(const Crowd *c, real before, real force)
{
    real passes = (real)c->passes / c->substeps;
    return (float)real_min(force, before + real_min(1, passes * c->dt / YIELDS) * (force - before));
}

static void book_lane(Crowd *c, Batch *b, int lane)
{
    Group *g = c->g;
    GroupContact *t = &g->contacts[b->contact[lane]];
    GroupPair *q = &g->pairs[t->pair];
    real load = 0, sum = 0, h = (real)c->h, rate = 1 / h;
    for (int k = 0; k < t->manifold.count; k++) {
        real j = (real)b->point[k].j[lane], whole = (real)b->point[k].sum[lane], speed = -(real)b->point[k].rate_before[lane];
        load += j;
        sum += whole;
        t->memory[k].normal = j * rate;
        t->memory[k].borne = t->manifold.count == 1 ? borne(c, (real)t->memory[k].borne, j * rate) : 0;
        t->memory[k].held = whole > 0 ? HELD_SUBSTEPS : 0;
        t->point_sum = vec3_mad(t->point_sum, whole, t->manifold.points[k].a);
        t->point_weight += whole;
        if (!b->patch)
            t->memory[k].tangent = vec3_zero();
        if (whole > 0) {
            t->last = g->t;
            if (q->contacts == 1)       /* the pair's other contacts may be in other threads' hands */
                q->approach = real_max(q->approach, speed);
            b->noted = b->noted || q->contacts > 1 || strikes(c, speed);
        }
    }
    b->noted = b->noted || pushes_sleeper(c, t, sum);
    if (b->patch)
        book_friction(t, b, lane, h, load);
    t->impulse = vec3_mad(t->impulse, sum, t->manifold.normal);
    t->rolling = b->roll ? vec3_scale(rate, (vec3){(real)b->roll->j[0][lane], (real)b->roll->j[1][lane], (real)b->roll->j[2][lane]})
                         : vec3_zero();
}

/* J  Given by movers through this contact: their velocity is constant. */
static real movers_work(const Group *g, const GroupContact *c)
{
    real work = 0;
    for (int k = 0; k < 2; k++) {
        int body = k ? c->b : c->a;
        if (!g->member[body].kinematic || !(c->point_weight > WEIGHT_LEAST))
            continue;
        vec3 at = vec3_scale(1 / c->point_weight, c->point_sum);
        vec3 v = vec3_add(g->vel[body].v, vec3_cross(g->vel[body].w, vec3_sub(at, g->pos[body].x)));
        work += (k ? -1 : 1) * vec3_dot(c->impulse, v);
    }
    return work;
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
        if (!m->moves)
            continue;
        vec3 moved = vec3_sub(g->pos[i].x, m->start_pos.x);
        g->lost += vec3_dot(m->force, moved) + vec3_dot(m->torque, g->shift[i].w);
        group_book_apart(g, i, moved, g->shift[i].w, c->dt);
    }
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        vec3 way = vec3_add(vec3_sub(g->pos[p->body].x, g->member[p->body].start_pos.x), vec3_cross(g->shift[p->body].w, arm));
        real work = vec3_dot(p->force, way) + vec3_dot(p->torque, g->shift[p->body].w);
        group_book_push(g, p, work);
    }
    g->lost -= group_kinetic(g);
}

typedef struct Book { Crowd *c; real *deepest; } Book;      /* m  of each thread */

static void fetch_batches(const Crowd *c, int i)
{
    const Batch *next = &c->batch[int_min(i + 1, c->batches - 1)], *after = &c->batch[int_min(i + 2, c->batches - 1)];
    for (int k = 0; k < LANES && after->contact[k] >= 0; k++)
        fetch_head(c->g, after->contact[k]);
    for (int k = 0; k < LANES && next->contact[k] >= 0; k++)
        fetch_body(c->g, next->contact[k]);
    for (int k = 0; k < next->points; k++)
        fetch_soon(&next->point[k].j, sizeof next->point[k] - offsetof(WidePoint, j));
    if (next->patch)
        fetch_soon(&next->patch->j, sizeof *next->patch - offsetof(WidePatch, j));
}

static void book_share(void *context, int thread, int threads)
{
    const Book *b = context;
    Crowd *c = b->c;
    for (int i = team_first(c->batches, thread, threads), last = team_end(c->batches, thread, threads); i < last; i++) {
        fetch_batches(c, i);
        for (int k = 0; k < LANES && c->batch[i].contact[k] >= 0; k++)
            book_lane(c, &c->batch[i], k);
    }
}

static void carry_share(void *context, int thread, int threads)
{
    const Book *b = context;
    Group *g = b->c->g;
    int first = team_first(g->contact_count, thread, threads), end = team_end(g->contact_count, thread, threads);
    real deepest = 0;
    for (int i = first; i < end; i++) {
        GroupContact *t = &g->contacts[i];
        if (!t->live)
            continue;
        carry(b->c, t);
        for (int k = 0; k < t->manifold.count; k++)
            deepest = real_max(deepest, -t->manifold.points[k].gap);
    }
    b->deepest[thread] = deepest;
}

static void book_movers(Group *g)
{
    bool any = false;
    for (int i = g->moving_count; i < g->body_count; i++)
        any = any || g->member[i].kinematic;
    for (int i = 0; i < g->contact_count && any; i++) {
        real given = g->contacts[i].live ? movers_work(g, &g->contacts[i]) : 0;
        g->work_in += given;
        g->lost += given;
    }
}

static Vel mean_velocity(const Group *g, int body)
{
    const Member *m = &g->member[body];
    if (!m->moves)
        return g->vel[body];
    return (Vel){vec3_scale(0.5, vec3_add(g->vel[body].v, m->start_vel.v)), vec3_scale(0.5, vec3_add(g->vel[body].w, m->start_vel.w))};
}

/* J  What a contact would have taken, were its force even over the step. */
static real even_loss(const Group *g, const GroupContact *c, real dt)
{
    if (!(c->point_weight > WEIGHT_LEAST))
        return 0;
    vec3 at = vec3_scale(1 / c->point_weight, c->point_sum);
    Vel a = mean_velocity(g, c->a), b = mean_velocity(g, c->b);
    vec3 va = vec3_add(a.v, vec3_cross(a.w, vec3_sub(at, g->member[c->a].start_pos.x)));
    vec3 vb = vec3_add(b.v, vec3_cross(b.w, vec3_sub(at, g->member[c->b].start_pos.x)));
    return real_max(0, -vec3_dot(c->impulse, vec3_sub(vb, va)) - dt * vec3_dot(c->rolling, vec3_sub(b.w, a.w)));
}

/* What is lost is known of the crowd as a whole. Where an effect asks for it, each contact is given a share of that. */
static void share_losses(const Crowd *c, real lost)
{
    Group *g = c->g;
    real sum = 0;
    for (int i = 0; i < g->contact_count; i++)
        sum += g->contacts[i].lost = even_loss(g, &g->contacts[i], c->dt);
    real share = sum > 0 && lost > 0 ? lost / sum : 0;
    for (int i = 0; i < g->contact_count; i++)
        g->contacts[i].lost *= isfinite(share) ? share : 0;
}

dig_status book_close(Crowd *c)
{
    Group *g = c->g;
    int threads = c->team ? c->team->threads : 1;
    Book b = {c, arena_alloc(g->arena, (size_t)threads * sizeof *b.deepest)};
    if (!b.deepest)
        return DIG_E_MEMORY;
    team_run(c->team, book_share, &b);
    DIG_TRY(reserve_strikes(c));
    for (int i = 0; i < c->batches; i++)
        if (c->batch[i].noted)
            note_batch(c, &c->batch[i]);
    book_energy(c);
    book_movers(g);
    if (g->losses)
        share_losses(c, g->lost);
    team_run(c->team, carry_share, &b);
    for (int i = 0; i < threads; i++)
        g->penetration = real_max(g->penetration, b.deepest[i]);
    return DIG_OK;
}
