/* crowd/book.c - what the solve found goes to the group's records: forces, points, impacts, energy. */
#include "crowd/system.h"
#include "math/reg3.h"

static const Carriage stands = {.turn = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

static const Carriage *carriage_that_moves(const Crowd *c, int body)
{
    return c->trait[body].moves || c->trait[body].kinematic ? carriage_of(c, body) : &stands;
}

/* A carriage for many points. The turn is exact: what turns for ever about one axis would move its points outward by half its square in
 * every step. */
typedef struct Carrier { reg33 turn; reg3 from, to; } Carrier;

INLINE Carrier carrier_of(const Carriage *k) { return (Carrier){reg33_of(&k->turn), reg3_of(k->from), reg3_of(k->to)}; }
INLINE reg3 carried(const Carrier *k, reg3 at) { return k->to + reg33_by(&k->turn, at - k->from); }

/* rad  Twice the axis times the sine of a turn. */
static vec3 skew_of(const mat3 *m) { return (vec3){m->r2.y - m->r1.z, m->r0.z - m->r2.x, m->r1.x - m->r0.y}; }

/* m  By how much more its two bodies travel than points of one move against the other: at this contact by `slip`, about it by their turn
 * against each other. What they turn in common counts as well, for the normal stays where it is meanwhile. */
static real in_common(const GroupPair *q, const Carriage *ka, const Carriage *kb, real slip)
{
    vec3 sa = skew_of(&ka->turn), sb = skew_of(&kb->turn);
    real turn = 0.5 * vec3_distance(sa, sb) + 0.25 * vec3_length(vec3_add(sa, sb));
    real way = ka->way + kb->way - slip - turn * q->size;
    return way > 0 && isfinite(way) ? way : 0;      /* a plane that turns has no farthest point */
}

/* A manifold turns with the side that has its face. */
static void turn_normal(const Crowd *crowd, GroupContact *c, const Carriage *ka, const Carriage *kb)
{
    const Trait *a = &crowd->trait[c->a], *b = &crowd->trait[c->b];
    const Carriage *side = a->moves && !(a->round && b->moves) ? ka : kb;
    if (!a->moves || !b->moves)
        side = a->moves ? kb : ka;
    if (side != &stands)
        c->manifold.normal = vec3_unit(mat3_mul_vec(side->turn, c->manifold.normal));
}

/* Points go with their bodies; the gap changes by what the row saw. Returns the deepest of what was so before and these, m. */
INLINE real carry(const Crowd *crowd, GroupContact *c, real deepest)
{
    Group *g = crowd->g;
    GroupPair *q = &g->pairs[c->pair];
    const int count = c->manifold.count;
    bool watched = q->contacts == 1 && q->until >= 0;   /* others may be in other threads' hands */
    const Carriage *ka = carriage_that_moves(crowd, c->a), *kb = carriage_that_moves(crowd, c->b);
    const Carrier ca = carrier_of(ka), cb = carrier_of(kb);
    const reg3 normal = reg3_of(c->manifold.normal);
    real slip2 = 0;
    for (ManifoldPoint *p = c->manifold.points, *end = p + count; p < end; p++) {
        reg3 a0 = reg3_load(&p->a), b0 = reg3_load(&p->b), a = carried(&ca, a0), b = carried(&cb, b0), d = b - a;
        if (watched)
            slip2 = real_max(slip2, reg3_length2(d - (b0 - a0)));
        reg3_store(&p->a, a);
        reg3_store(&p->b, b);
        p->gap = reg3_dot(normal, d);
        deepest = real_max(deepest, -p->gap);
    }
    if (count >= 3) {
        turn_normal(crowd, c, ka, kb);
        if (q->contacts == 1)
            crowd_sign(g, q);
    }
    if (watched)
        q->until += in_common(q, ka, kb, sqrt(slip2));
    return deepest;
}

/* m/s  What approaches no faster has only fallen so far in a substep. */
static real strike_speed(const Crowd *c) { return c->g->close_speed + 2 * c->g->fall * (real)c->h; }

static bool pushes_sleeper(const Crowd *c, const GroupContact *t, real sum)
{
    return sum > 0 && (c->trait[t->a].dormant || c->trait[t->b].dormant);
}

/* The row of a contact: its batch, and the lane. */
static Batch *batch_of(const Crowd *c, int contact, int *lane)
{
    *lane = c->row[contact] % LANES;
    return &c->batch[c->row[contact] / LANES];
}

static real lane_of(const Wide *v, int lane) { return (real)v->at[lane]; }

/* Strikes are listed in the order of contacts, and sleepers are marked, by one thread: what concerns more than the contact. */
static void note_contact(Crowd *c, int contact)
{
    Group *g = c->g;
    const GroupContact *t = &g->contacts[contact];
    int lane;
    const Batch *b = batch_of(c, contact, &lane);
    real sum = 0;
    for (int k = 0; k < t->manifold.count; k++) {
        real whole = lane_of(&b->point[k].sum, lane), speed = -lane_of(&b->point[k].rate_before, lane);
        PointRow r = {.contact = contact, .point = k, .a = t->a, .b = t->b, .jn = whole};
        sum += whole;
        if (whole > 0)
            pair_approaches(&g->pairs[t->pair], speed);
        if (!(whole > 0) || !(speed > strike_speed(c)))
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

/* Friction at the middle becomes forces at the points. */
INLINE void book_friction(GroupContact *t, Acted *acted, const Batch *b, int lane, real h, real load)
{
    const ManifoldPoint *point = t->manifold.points;
    PointMemory *memory = contact_memory(t);
    const int count = t->manifold.count;
    vec3 n = t->manifold.normal, u, v;
    vec3_basis(n, &u, &v);
    real part = 1.0 / count, per_load = load > 0 ? 1 / load : 0, rate = 1 / h, spread = 0, twist = b->twist ? lane_of(&b->twist->j, lane) : 0;
    vec3 last = vec3_add(vec3_scale(lane_of(&b->patch->j[0], lane), u), vec3_scale(lane_of(&b->patch->j[1], lane), v));
    vec3 whole = vec3_add(vec3_scale(lane_of(&b->patch->sum[0], lane), u), vec3_scale(lane_of(&b->patch->sum[1], lane), v));
    acted->impulse = vec3_add(acted->impulse, whole);
    reg3 axis = reg3_of(n), force = reg3_of(vec3_scale(rate, last)), middle = reg3_all(0);
    if (twist != 0) {
        for (int k = 0; k < count; k++)
            middle = middle + reg3_all(0.5 * part) * (reg3_load(&point[k].a) + reg3_load(&point[k].b));
        for (int k = 0; k < count; k++)
            spread += reg3_length2(reg3_load(&point[k].a) - middle);
    }
    real turn = spread > 0 ? rate * twist / spread : 0;
    for (int k = 0; k < count; k++) {
        reg3 tangent = reg3_all(load > 0 ? memory[k].normal * h * per_load : part) * force;
        if (turn != 0)
            tangent = tangent + reg3_all(turn) * reg3_cross(axis, reg3_load(&point[k].a) - middle);
        memory[k].tangent = reg3_get(tangent);
    }
}

/* The vector across the normal of a round contact. */
static void book_rub(GroupContact *t, Acted *acted, const WideRub *r, int lane, real h)
{
    acted->impulse = vec3_add(acted->impulse, (vec3){lane_of(&r->sum[0], lane), lane_of(&r->sum[1], lane), lane_of(&r->sum[2], lane)});
    contact_memory(t)->tangent = vec3_scale(1 / h, (vec3){lane_of(&r->j[0], lane), lane_of(&r->j[1], lane), lane_of(&r->j[2], lane)});
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

typedef struct Book { Crowd *c; real strikes, *deepest; uint8_t *to_note; } Book;     /* m/s  see strike_speed; m  of each thread; [contact_count] */

/* Returns whether there is something to note. */
INLINE bool book_row(const Book *book, int contact)
{
    const Crowd *c = book->c;
    Group *g = c->g;
    GroupContact *t = &g->contacts[contact];
    GroupPair *q = &g->pairs[t->pair];
    int lane;
    const Batch *b = batch_of(c, contact, &lane);
    Acted *acted = g->few ? acted_in(g, contact) : &g->acted[contact];
    const int count = t->manifold.count;
    PointMemory *memory = contact_memory(t);
    reg3 at = reg3_of(acted->point_sum);
    real load = 0, sum = 0, weight = acted->point_weight, fastest = -INFINITY, h = (real)c->h, rate = 1 / h;
    for (int k = 0; k < count; k++) {
        const WidePoint *p = &b->point[k];
        real j = lane_of(&p->j, lane), whole = lane_of(&p->sum, lane), force = j * rate;
        load += j;
        sum += whole;
        memory[k].normal = force;
        memory[k].borne = count <= crowd_alone(q) ? borne(c, (real)memory[k].borne, force) : 0;
        memory[k].held = whole > 0 ? HELD_SUBSTEPS : 0;
        at = at + reg3_all(whole) * reg3_load(&t->manifold.points[k].a);
        weight += whole;
        if (whole > 0)
            fastest = real_max(fastest, -lane_of(&p->rate_before, lane));
    }
    acted->point_sum = reg3_get(at);
    acted->point_weight = weight;
    if (sum > 0)
        acted->last = g->t;
    if (q->contacts == 1)       /* the pair's other contacts may be in other threads' hands */
        pair_approaches(q, fastest);
    if (b->patch)
        book_friction(t, acted, b, lane, h, load);
    else if (b->rub)
        book_rub(t, acted, b->rub, lane, h);
    for (int k = 0; k < count && !b->patch && !b->rub; k++)
        memory[k].tangent = vec3_zero();
    acted->impulse = vec3_mad(acted->impulse, sum, t->manifold.normal);
    if (g->contact_rest)
        g->contact_rest[contact].rolling = b->roll ? vec3_scale(rate, (vec3){lane_of(&b->roll->j[0], lane), lane_of(&b->roll->j[1], lane),
                                                                             lane_of(&b->roll->j[2], lane)}) : vec3_zero();
    return fastest > book->strikes || (q->contacts > 1 && sum > 0) || pushes_sleeper(c, t, sum);
}

/* m  Of its centre of mass. */
static vec3 way_in_piece(const Crowd *c, int body)
{
    const Carriage *k = carriage_that_moves(c, body);
    return vec3_sub(k->to, k->from);
}

/* What forces and movers gave, and kinetic energy has not got, is lost. */
static void book_energy(Crowd *c)
{
    Group *g = c->g;
    real given = crowd_work_of_movers(c);
    g->work_in += given;
    g->lost += given;
    for (int i = 0; i < c->blocks; i++)
        g->lost += c->lost[i];
    for (int i = 0; i < g->moving_count && (g->drags || g->rules); i++)
        group_book_apart(g, i, way_in_piece(c, i), g->member[i].swerve, c->dt);
    for (int i = 0; i < g->push_count; i++) {
        const GroupPush *p = &g->pushes[i];
        vec3 arm = p->has_at ? quat_rotate(g->pos[p->body].q, p->at) : vec3_zero();
        const Member *m = &g->member[p->body];
        vec3 way = vec3_add(way_in_piece(c, p->body), vec3_cross(m->swerve, arm));
        real work = vec3_dot(p->force, way) + vec3_dot(p->torque, m->swerve);
        group_book_push(g, p, work);
    }
}

/* In the order of contacts, for what is known of each lies in it; the rows of neighbours are near each other, too (rows.c). What is to
 * be noted stays where it struck until then. */
INLINE void book_part(void *context, int thread, int threads)
{
    const Book *b = context;
    const Crowd *c = b->c;
    int count = c->g->contact_count;
    real deepest = 0;
    for (int i = team_first(count, thread, threads), end = team_end(count, thread, threads); i < end; i++) {
        b->to_note[i] = c->row[i] >= 0 && book_row(b, i);
        if (c->g->contacts[i].live && !b->to_note[i])
            deepest = carry(c, &c->g->contacts[i], deepest);
    }
    b->deepest[thread] = deepest;
}

FOR_WIDTHS(book_share, book_part)

static void carry_noted(void *context, int thread, int threads)
{
    const Book *b = context;
    int count = b->c->g->contact_count;
    for (int i = team_first(count, thread, threads), end = team_end(count, thread, threads); i < end; i++)
        if (b->to_note[i])
            b->deepest[thread] = carry(b->c, &b->c->g->contacts[i], b->deepest[thread]);
}

/* There is room for a strike of each contact that may have one. */
static dig_status note(const Book *b)
{
    Group *g = b->c->g;
    int more = 0;
    for (int i = 0; i < g->contact_count; i++)
        more += b->to_note[i];
    if (more == 0)
        return DIG_OK;
    Strike *strikes = spare_take(&g->spare, g->lasting, (size_t)(g->strike_count + more) * sizeof *strikes);
    Impact *impacts = spare_take(&g->spare, g->lasting, (size_t)(g->impact_count + more) * sizeof *impacts);
    if (!strikes || !impacts)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->strike_count; i++)       /* of pieces before this one */
        strikes[i] = g->strikes[i];
    for (int i = 0; i < g->impact_count; i++)
        impacts[i] = g->impacts[i];
    g->impacts = impacts;
    g->strikes = strikes;
    g->strike_room = g->strikes_most = g->strike_count + more;
    for (int i = 0; i < g->contact_count; i++)
        if (b->to_note[i])
            note_contact(b->c, i);
    return DIG_OK;
}

static Vel mean_velocity(const Group *g, int body)
{
    const Member *m = &g->member[body];
    if (!m->moves)
        return g->vel[body];
    return (Vel){vec3_scale(0.5, vec3_add(g->vel[body].v, g->start_vel[body].v)), vec3_scale(0.5, vec3_add(g->vel[body].w, g->start_vel[body].w))};
}

/* J  What a contact would have taken, were its force even over the step. */
static real even_loss(const Group *g, const GroupContact *c, real dt)
{
    const Acted *acted = acted_in(g, (int)(c - g->contacts));
    if (!acted || !(acted->point_weight > WEIGHT_LEAST))
        return 0;
    vec3 at = vec3_scale(1 / acted->point_weight, acted->point_sum);
    Vel a = mean_velocity(g, c->a), b = mean_velocity(g, c->b);
    vec3 va = vec3_add(a.v, vec3_cross(a.w, vec3_sub(at, g->start_pos[c->a].x)));
    vec3 vb = vec3_add(b.v, vec3_cross(b.w, vec3_sub(at, g->start_pos[c->b].x)));
    return real_max(0, -vec3_dot(acted->impulse, vec3_sub(vb, va)) - dt * vec3_dot(contact_rolling(g, c), vec3_sub(b.w, a.w)));
}

/* What is lost is known of the crowd as a whole. Where an effect asks for it, each contact is given a share of that. */
static void share_losses(const Crowd *c, real lost)
{
    Group *g = c->g;
    real sum = 0;
    for (int i = 0; i < g->contact_count; i++)
        sum += g->contact_rest[i].lost = even_loss(g, &g->contacts[i], c->dt);
    real share = sum > 0 && lost > 0 ? lost / sum : 0;
    for (int i = 0; i < g->contact_count; i++)
        g->contact_rest[i].lost *= isfinite(share) ? share : 0;
}

/* Of what acts only: of the first half of a batch where its contacts' rows begin, which nobody asks for any more, of the others in what the bodies'
 * rows have done with. */
static dig_status open_few(Crowd *c)
{
    _Static_assert(2 * ACTED_BLOCK == LANES, "a contact has the number of its row");
    _Static_assert(ACTED_BLOCK * sizeof(Acted) <= sizeof(WideContact), "it has room there");
    Group *g = c->g;
    const size_t bytes = ACTED_BLOCK * sizeof **g->few;
    bodies_spare(c);
    g->few = arena_alloc(g->lasting, 2 * (size_t)c->batches * sizeof *g->few);
    for (int i = 0; i < 2 * c->batches && g->few; i++) {
        const Batch *b = &c->batch[i / 2];
        if (i % 2 == b->halves)
            continue;
        g->few[i] = i % 2 == 0 ? (void *)b->of : spare_take(&g->spare, g->lasting, bytes);
        if (!g->few[i])
            return DIG_E_MEMORY;
        memset(g->few[i], 0, bytes);
    }
    g->acts = c->row;
    return g->few ? DIG_OK : DIG_E_MEMORY;
}

dig_status book_close(Crowd *c)
{
    Group *g = c->g;
    if (c->alone)
        DIG_TRY(open_few(c));
    int shares = team_shares(c->team);
    Book b = {c, strike_speed(c), arena_alloc(g->lasting, (size_t)shares * sizeof *b.deepest), arena_alloc(g->lasting, (size_t)(g->contact_count + 1))};
    if (!b.deepest || !b.to_note)
        return DIG_E_MEMORY;
    team_deal(c->team, book_share(c), &b);
    const Strike *before = g->strikes;
    DIG_TRY(note(&b));
    if (g->strikes != before)
        team_deal(c->team, carry_noted, &b);
    book_energy(c);
    for (int i = 0; i < shares; i++)
        g->penetration = real_max(g->penetration, b.deepest[i]);
    return DIG_OK;
}

void book_step(const Crowd *c)
{
    if (c->g->losses)
        share_losses(c, c->g->lost);
}
