/* solve/sweep.c - the sub-stepped way to advance a group.
 *
 * Each substep: forces; rows; position errors out; velocities by Gauss-Seidel;
 * then everything moves. Free bodies move on exact parabolas; bodies whose
 * contacts and joints were there before move with the mean of old and new
 * velocity (second order), others with the new one. In groups small enough the
 * substep is cut at the first impact, which is then struck at its own time.
 */
#include "solve/direction.h"
#include "solve/momentum.h"

static bool any_euler(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && member_by_euler(&g->member[i]))
            return true;
    return false;
}

static void predict(Group *g)
{
    g->lifted = 0;
    g->lag = vec3_zero();
    for (int i = 0; i < g->moving_count; i++) {
        Member *m = &g->member[i];
        g->start_pos[i] = g->pos[i];
        g->start_vel[i] = g->vel[i];
        m->constrained = m->implicit_move = member_by_euler(m);
        m->met = false;
        m->swerve = vec3_zero();
        if (!m->moves)
            continue;
        m->swerve = group_swerve(g, i);
        vec3 dv = vec3_scale(g->h * g->mass[i].im, m->force), dw = vec3_scale(g->h, mat3_mul_vec(g->mass[i].ii, m->torque));
        dir_mask(g, &dv, &dw);
        g->vel[i].v = vec3_add(g->vel[i].v, dv);
        g->vel[i].w = vec3_add(vec3_add(g->vel[i].w, dw), m->swerve);
    }
}

static void move(Group *g)
{
    for (int i = 0; i < g->body_count; i++) {
        Member *m = &g->member[i];
        if (m->moves) {
            Vel way = group_way_of(g, i);
            g->pos[i].x = vec3_mad(g->pos[i].x, g->h, way.v);
            group_turn(g, i, way.w);
        } else if (m->kinematic) {
            g->pos[i].x = vec3_mad(g->pos[i].x, g->h, g->vel[i].v);
            g->pos[i].q = quat_unit(quat_mul(quat_exp(vec3_scale(g->h, g->vel[i].w)), g->pos[i].q));
        }
    }
    grip_follow(g, g->h);
}

/* Under a load that comes through joints the guess of the last impulses is off by more than a light wheel's weight: an approach that is
 * none. What presses already does not bounce there; balls that hang side by side do not press, and hand a blow on. */
static bool carries_load(const Group *g, const PointRow *r, real rate)
{
    const GroupContact *c = &g->contacts[r->contact];
    return g->joints_direct && contact_memory(c)[r->point].held > 0 && contact_presses(g, c, -rate);
}

#define BOUNCE_PASSES 64

static bool any_bounces(const Group *g)
{
    for (int i = 0; i < g->point_count; i++)
        if (g->points[i].bounce > 0)
            return true;
    return false;
}

/* Blows that are not located in time: one after the other, each with the speed that those before it have left. A pair that bounces
 * off its present approach never gains energy; all pairs at once off their approaches before the substep would. bare: velocities
 * without the guess of impulses. What the guess holds up does not bounce; and since the solve takes the guess back, but not the bounce,
 * none is harder than what turns the approach without it round: what only the guess of a blow drives together does not bounce at all. */
static void bounce(Group *g, Vel *bare)
{
    real slow = 2 * g->fall * g->h;
    for (int pass = 0, more = 1; pass < BOUNCE_PASSES && more; pass++) {
        more = 0;
        for (int i = 0; i < g->point_count; i++) {
            PointRow *r = &g->points[i];
            real rate = r->bounce > 0 ? dir_rate(g, &r->n, r->a, r->b) : 0;
            real gap = g->contacts[r->contact].manifold.points[r->point].gap;
            if (!(rate < -slow) || gap + g->h * rate >= 0 || !(r->n.k > 0) || carries_load(g, r, rate))
                continue;
            real turn = bare ? dir_rate_between(&r->n, &bare[r->a], &bare[r->b]) : rate;
            real p = real_min(-(1 + r->bounce) * rate, -2 * turn) / r->n.k;
            if (!(p > 0))
                continue;
            dir_apply(g, &r->n, r->a, r->b, p);
            if (bare)
                dir_apply_between(&r->n, &bare[r->a], g->mass[r->a].im, &bare[r->b], g->mass[r->b].im, p);
            r->blow += p;
            more = 1;
        }
    }
}

/* The impulses with which a solve begins, and what bounces. Where all is solved at once the guess may be far off. */
static dig_status begin_solve(Group *g)
{
    if (g->joints_direct)
        bounce(g, NULL);
    ArenaMark mark = arena_mark(g->arena);
    bool bounces = !g->joints_direct && any_bounces(g);
    Vel *bare = bounces ? group_velocities(g) : NULL;
    dig_status status = bounces && !bare ? DIG_E_MEMORY : group_warm_start(g);
    if (bare && status == DIG_OK)
        bounce(g, bare);
    arena_rewind(g->arena, mark);
    return status;
}

/* Which bodies have rows, and whether the mean velocity is good enough to move them. */
static void mark_constrained(Group *g)
{
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        if (!(r->jn > 0))
            continue;               /* it could have touched, but did not: free flight */
        /* a point that carries on is smooth, though turning bodies approach there a little at each substep's start */
        bool carries = contact_memory(&g->contacts[r->contact])[r->point].held == HELD_SUBSTEPS;
        bool several = g->contacts[r->contact].manifold.count > 1;
        bool met = r->target < -1e-6 || (fabs(r->rate_before) > 1e-6 && !carries);
        if (several && carries && g->row_count == 0)    /* of one point the row itself follows the curve, where it can */
            met = -r->rate_before > g->fall * g->h;
        met = met && !r->curved;
        for (int k = 0; k < 2; k++) {
            Member *m = &g->member[k ? r->b : r->a];
            m->constrained = true;
            m->met = m->met || met;
            m->implicit_move = m->implicit_move || met || !g->locate;
        }
    }
    for (int i = 0; i < g->row_count; i++) {
        const JointRow *r = &g->rows[i];
        for (int k = 0; k < r->row.count; k++)
            if (r->row.body[k] >= 0) {
                Member *m = &g->member[r->row.body[k]];
                m->constrained = true;
                m->implicit_move = !g->midpoint;    /* rows that hold for the mean are broken by who moves otherwise */
            }
    }
}

/* Bodies that move with their new velocities lose energy together; a few of them, whose neighbours move with the mean, may gain it: then
 * all do that something holds. Joints that hold for the mean would be broken by it. */
static void move_alike(Group *g)
{
    real lost = 0;
    if (g->row_count > 0)
        return;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (m->moves && m->implicit_move && !member_by_euler(m))
            lost += vec3_dot(m->force, vec3_sub(g->vel[i].v, g->start_vel[i].v)) + vec3_dot(m->torque, vec3_sub(g->vel[i].w, g->start_vel[i].w));
    }
    for (int i = 0; i < g->moving_count && lost < 0; i++)
        if (g->member[i].constrained)
            g->member[i].implicit_move = g->member[i].met = true;
}

/* Does anything outside the group hold it, or anything press at all? */
static bool held_or_pressed(const Group *g)
{
    for (int i = 0; i < g->point_count; i++)
        if (g->points[i].jn > 0)
            return true;
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].a < 0 || g->joints[i].b < 0 || !g->member[g->joints[i].a].moves || !g->member[g->joints[i].b].moves)
            return true;
    return false;
}

/* What moves with its end velocity falls by g h^2 / 2 too far in each substep. Where joints alone act, and none to what is outside, all of it is moved
 * back alike, so that its centre of mass moves with the mean, and no row sees it. */
static void fall_together(Group *g)
{
    vec3 gained = vec3_zero();
    real mass = 0;
    for (int i = 0; i < g->moving_count; i++) {
        const Member *m = &g->member[i];
        if (!m->moves || !m->implicit_move)
            continue;
        mass += m->mass;
        gained = vec3_mad(gained, m->mass, vec3_sub(g->vel[i].v, g->start_vel[i].v));
    }
    if (g->joint_count > 0 && mass > 0 && !any_euler(g) && !held_or_pressed(g))
        g->lag = vec3_scale(-0.5 / mass, gained);
}

/* As before the solve. */
static void restore(Group *g)
{
    project_back(g);
    for (int i = 0; i < g->moving_count; i++) {
        g->pos[i] = g->start_pos[i];
        g->vel[i] = g->start_vel[i];
        group_refresh_mass(g, i);
    }
}

/* Does something close in this substep that was open? Then bodies will not turn on as they did. */
static bool blow_comes(const Group *g)
{
    for (int i = 0; i < g->point_count; i++) {
        const PointRow *r = &g->points[i];
        real gap = g->contacts[r->contact].manifold.points[r->point].gap;
        if (-r->rate_before > group_blow_speed(g) && gap + g->h * r->rate_before < 0)
            return true;
    }
    return false;
}

#define FEW_POINTS 24

static bool is_held(const Group *g, int body)
{
    if (!g->member[body].moves)
        return false;
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].a == body || g->joints[i].b == body)
            return true;
    return false;
}

/* Has what joints hold many contact points? Those of bricks that a ball on a chain has struck do not count. */
static bool pressed_at_many(const Group *g)
{
    int count = 0;
    if (g->point_count <= FEW_POINTS)
        return false;
    for (int i = 0; i < g->point_count && count <= FEW_POINTS; i++)
        count += is_held(g, g->points[i].a) || is_held(g, g->points[i].b);
    return count > FEW_POINTS;
}

/* May rows lie where bodies will have turned to? Not where something heavy presses at many points on what joints hold: no solve gets
 * there, and what is found does not turn them so. */
static bool turns_on(const Group *g)
{
    return g->joints_direct && (group_elastic(g) || !group_top_heavy(g) || !pressed_at_many(g));
}

/* found: velocities at the end from a solve before; NULL = none. */
static dig_status solve_with(Group *g, const Vel *found)
{
    g->braced = 0;
    DIG_TRY(group_forces(g));
    predict(g);
    g->point_count = g->roll_count = g->block_count = g->row_count = 0;
    DIG_TRY(g->stage(g, STAGE_ROWS));
    if (g->midpoint && (any_euler(g) || g->joints_direct))
        group_build_joints(g, false);       /* who moves with the new velocity needs rows for it, not for the mean */
    bool turned = turns_on(g) && (found || !blow_comes(g));
    if (turned)
        group_turn_joints(g, found);        /* a turn straight on from where they are would stretch what bends */
    real heals = g->joints_direct && !g->jammed ? group_heal(g) : 0, before = g->residual;
    if (!g->joints_direct || g->jammed)
        project(g);
    if (g->jammed)
        group_unwind(g);
    ArenaMark mark = arena_mark(g->arena);
    bool levers = group_may_lever(g);
    Vel *bare = levers ? group_velocities(g) : NULL;
    if (levers && !bare)
        return DIG_E_MEMORY;
    DIG_TRY(begin_solve(g));
    g->residual = 0;
    int events = g->events_left;
    bool contradicts = g->contradicts;
    relax_group(g);
    if (g->residual > VELOCITY_COARSE && group_motors_yield(g)) {
        g->events_left = events;
        g->contradicts = contradicts;
        g->residual = before;
        arena_rewind(g->arena, mark);
        restore(g);
        return solve_with(g, found);
    }
    if (group_jams(g, heals) || group_throws(g, heals)) {
        g->jammed = true;
        g->residual = before;
        arena_rewind(g->arena, mark);
        restore(g);
        return solve_with(g, found);
    }
    if (bare)
        group_ease_levers(g, bare);
    arena_rewind(g->arena, mark);
    g->residual = real_max(g->residual, before);
    for (int i = 0; i < g->point_count; i++)
        g->points[i].jn += g->points[i].blow;
    mark_constrained(g);
    move_alike(g);
    fall_together(g);
    group_note_couples(g, turned);
    return g->status;
}

static dig_status solve_substep(Group *g) { return solve_with(g, NULL); }

/* What bends turns on otherwise after a blow than before it. */
static dig_status turn_as_found(Group *g)
{
    ArenaMark mark = arena_mark(g->arena);
    const Vel *found = group_velocities(g);
    if (!found)
        return DIG_E_MEMORY;
    restore(g);
    dig_status status = solve_with(g, found);
    arena_rewind(g->arena, mark);
    return status;
}

/* Does all that gives do so along a line? Then it is places that turn it. */
static bool is_threads(const Group *g)
{
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].view.type->elastic && !g->joints[i].view.type->two_anchors)
            return false;
    return true;
}

static dig_status turn_on(Group *g)
{
    bool good = g->joints_direct && group_elastic(g) && (g->plan->substeps >= SWEEP_FINE || is_threads(g));
    return good && blow_comes(g) ? turn_as_found(g) : DIG_OK;
}

/* As many bodies of a stack may meet one after the other in one substep. */
#define MEETINGS 8

/* Where no impacts are located, what is stopped in this substep is met in it by what comes after, and what is struck meets what is before
 * it. When that goes on for longer, nothing gets through what is thin at least. */
static dig_status meet(Group *g)
{
    for (int i = 0; i < g->pair_count; i++)
        g->pairs[i].meets = false;
    for (int i = 0, most = (g->joints_direct ? 1 : 2) * MEETINGS;
         i < most && group_touch_missed(g, g->world->def.step / g->plan->substeps, i >= MEETINGS); i++) {
        restore(g);
        DIG_TRY(solve_substep(g));
    }
    return DIG_OK;
}

static real stored(Group *g)
{
    real sum = 0;
    for (int i = 0; i < g->joint_count; i++)
        if (g->joints[i].stores) {
            group_joint_view(g, i);
            sum += group_spring_energy(&g->joints[i]);
        }
    return sum;
}

/* Springs may gain so much in a substep: of the energy of motion, and of what lifts all bodies by their size */
#define MADE_UP 1e-3

/* Will springs store more than was taken for it? Their rows see no turn: a thread whose one end a blow stops is stretched by the square of
 * what the other goes on across it. */
static bool springs_gain(Group *g)
{
    real gain = -stored(g), lost = 0;
    ArenaMark mark = arena_mark(g->arena);
    Pos *before = arena_alloc(g->arena, (size_t)g->body_count * sizeof *before);
    const Vel *found = group_velocities(g);         /* what turns changes its spin, too */
    if (!before || !found) {
        g->status = DIG_E_MEMORY;
        return false;
    }
    memcpy(before, g->pos, (size_t)g->body_count * sizeof *before);
    move(g);
    gain += stored(g);
    memcpy(g->pos, before, (size_t)g->body_count * sizeof *before);
    memcpy(g->vel, found, (size_t)g->body_count * sizeof *found);
    arena_rewind(g->arena, mark);
    real much = group_kinetic(g);
    for (int i = 0; i < g->moving_count; i++) {
        group_refresh_mass(g, i);
        much += g->member[i].moves ? vec3_length(g->member[i].force) * g->member[i].outer : 0;
    }
    for (int i = 0; i < g->row_count; i++)
        if (g->rows[i].row.kind == ROW_SOFT)
            lost -= g->rows[i].p * group_mean_rate(g, &g->rows[i].row);
    return gain - lost > MADE_UP * much;
}

/* Blows of such are looked for along a spin that stands still. */
static bool any_whirls(const Group *g)
{
    for (int i = 0; i < g->moving_count; i++)
        if (g->member[i].moves && group_whirls(g, i))
            return true;
    return false;
}

/* Velocities found for a substep that do not hold for all of it. What is light flings about when the heavy jerks at it. */
static bool too_long(Group *g)
{
    bool located = g->locate && g->events_left > 0;
    return (g->locate && overshoots(g, false)) || ((!located || any_whirls(g)) && overshoots(g, true)) ||
        (turns_on(g) && group_top_heavy(g) && group_joints_open(g)) || (g->joint_count > 0 && group_spins_off(g)) ||
        (g->joints_direct && group_elastic(g) && springs_gain(g));
}

#define WHIRLS_ON 64            /* times as short as others a substep gets in which a known point carries something that whirls through something thin */

static bool is_halved(Group *g, real shortest)
{
    return g->h > shortest ? too_long(g) : g->locate && g->h > shortest / WHIRLS_ON && overshoots(g, true);
}

/* The solve was so dear that no more impacts are located in this step: what its rows left to that needs rows, and a shorter substep. */
static dig_status solve_unlocated(Group *g, real *until)
{
    restore(g);
    *until = real_min(*until, g->t + missing_little(g, g->world->def.step));
    g->h = g->heal_over = *until - g->t;
    return solve_substep(g);
}

/* A stop that a script has set behind what it stops brings that back with more than a motor or a load can hold: what has so been moved keeps none of the
 * speed. It goes where the solve has found, into `to`, [body_count], and the velocities are those that there are without it. */
static dig_status keep_speed(Group *g, Pos *to)
{
    Pos *from = arena_alloc(g->arena, (size_t)g->body_count * sizeof *from);
    if (!from)
        return DIG_E_MEMORY;
    memcpy(from, g->pos, (size_t)g->body_count * sizeof *from);
    move(g);
    memcpy(to, g->pos, (size_t)g->body_count * sizeof *to);
    memcpy(g->pos, from, (size_t)g->body_count * sizeof *from);
    restore(g);
    g->stops_kept = true;
    dig_status status = solve_substep(g);
    g->stops_kept = false;
    return status;
}

/* Books the substep, and moves all by it. */
static dig_status finish(Group *g)
{
    ArenaMark mark = arena_mark(g->arena);
    Pos *to = g->joints_direct && group_stops_passed(g) ? arena_alloc(g->arena, (size_t)g->body_count * sizeof *to) : NULL;
    if (to)
        DIG_TRY(keep_speed(g, to));
    group_forget_idle(g);
    group_book(g);
    if (!g->woke) {
        move(g);
        if (to)
            memcpy(g->pos, to, (size_t)g->body_count * sizeof *to);
        for (int i = 0; to && i < g->moving_count; i++)
            group_refresh_mass(g, i);
        grip_lead(g);
    }
    arena_rewind(g->arena, mark);
    return g->status;
}

#define CUTS 16

/* A shorter substep ends where a longer one passed, but where rows too stiff for both take it as far. */
static bool keeps_its_way(const Group *g) { return g->joint_count == 0 || g->midpoint; }

static dig_status substep(Group *g, real until)
{
    g->h = g->heal_over = until - g->t;
    int events = g->events_left;
    if (g->locate && group_clean_joints(g))
        strike_stops(g);
    DIG_TRY(solve_substep(g));
    if (g->locate && events > 0 && g->events_left <= 0 && !g->unsolved)
        DIG_TRY(solve_unlocated(g, &until));
    bool late = !g->locate || g->events_left <= 0;
    if (g->joints_direct || late)
        DIG_TRY(meet(g));
    DIG_TRY(turn_on(g));
    if (g->locate && g->events_left > 0) {
        real hit = locate_impact(g);
        for (int cut = 0; hit < g->h * (1 - 1e-9) && cut < CUTS; cut++) {
            restore(g);
            g->h = real_max(hit, 1e-9 * g->h);
            until = g->t + g->h;
            DIG_TRY(solve_substep(g));
            if (keeps_its_way(g))
                break;
            hit = locate_impact(g);
        }
        if (hit <= g->h) {
            g->events_left--;
            g->located++;
        }
    }
    for (real shortest = g->world->def.step / g->plan->substeps / 16; is_halved(g, shortest);) {
        restore(g);
        g->h *= 0.5;
        g->heal_over = g->locate ? g->h : g->heal_over;
        until = g->t + g->h;
        DIG_TRY(solve_substep(g));
        DIG_TRY(turn_on(g));
    }
    DIG_TRY(finish(g));
    if (g->woke)
        return DIG_OK;          /* this try is thrown away: the sleeper wakes and the step starts again */
    if (g->joints_direct) {     /* heals by velocities, which are not to be kept where they did work */
        real taken;
        DIG_TRY(group_hold(g, false, &taken));
        g->lost += taken;
    }
    g->t = until;
    g->substeps++;
    return DIG_OK;
}

static dig_status reserve(Group *g)
{
    int points = 0;
    for (int i = 0; i < g->contact_count; i++)
        points += MANIFOLD_POINTS;
    g->point_capacity = points;
    g->strikes_most = g->plan->events + g->pair_count;
    g->points = arena_alloc(g->arena, (size_t)(points + 1) * sizeof *g->points);
    g->rolls = arena_alloc(g->arena, (size_t)(g->contact_count + 1) * sizeof *g->rolls);
    g->blocks = arena_alloc(g->arena, (size_t)(g->joint_count + 1) * sizeof *g->blocks);
    g->rows = arena_alloc(g->arena, (size_t)(g->joint_count * JOINT_SLOTS + 1) * sizeof *g->rows);
    DIG_TRY(squeeze_open(g));
    return g->points && g->rolls && g->blocks && g->rows ? DIG_OK : DIG_E_MEMORY;
}

static void measure(Group *g)
{
    g->joint_error = 0;
    g->residual = real_max(g->residual, squeeze_missing(g));
    for (int i = 0; i < g->contact_count; i++)
        for (int k = 0; g->contacts[i].live && k < g->contacts[i].manifold.count; k++)
            g->penetration = real_max(g->penetration, -g->contacts[i].manifold.points[k].gap);
    if (g->joint_count == 0)
        return;
    group_build_joints(g, false);
    for (int i = 0; i < g->row_count; i++)
        if (g->rows[i].row.kind == ROW_HARD)
            g->joint_error = real_max(g->joint_error, fabs(g->rows[i].row.error));
}

#define CLOSED_BY 5.0           /* times the widest gap that was: what has to move farther to close it hangs taut between what is fixed */

/* What the last substep's turns have opened, as the next one would begin with: limbs that whirl open theirs by their reach times half
 * the square of the angle. Not in a straight bridge, which would be lifted by a hundred times what its joints are apart. */
static dig_status close_gaps(Group *g, real part)
{
    Pos *before = arena_alloc(g->arena, (size_t)g->moving_count * sizeof *before);
    if (!before)
        return DIG_E_MEMORY;
    memcpy(before, g->pos, (size_t)g->moving_count * sizeof *before);
    g->h = g->heal_over = part;
    g->point_count = g->roll_count = g->block_count = g->row_count = 0;
    DIG_TRY(g->stage(g, STAGE_ROWS));
    group_build_joints(g, false);
    project(g);
    real moved = 0;
    for (int i = 0; i < g->moving_count; i++)
        moved = real_max(moved, vec3_distance(before[i].x, g->pos[i].x));
    if (moved > CLOSED_BY * g->joint_error) {
        project_back(g);
        memcpy(g->pos, before, (size_t)g->moving_count * sizeof *before);
    }
    for (int i = 0; i < g->moving_count; i++)
        group_refresh_mass(g, i);
    group_touch(g, part, true);
    measure(g);
    return g->status;
}

/* What is laid into each other parts by being moved: what it strikes meanwhile need not be known to the instant. */
static bool any_merged(const Group *g)
{
    bool merged = false;
    for (int i = 0; i < g->contact_count && !merged; i++)
        merged = contact_merged(g, &g->contacts[i]);
    return merged;
}

/* What holds for all of a step, and the contacts of its start. */
static void begin(Group *g, real part, bool all)
{
    g->close_speed = group_close_speed(g);
    g->joints_direct = direct_joints(g);
    g->locate = g->moving_count <= g->plan->events_bodies && !g->joints_direct;
    g->events_left = group_events(g);
    g->whirls_left = sweep_whirls(g);
    g->h = g->heal_over = part;
    group_touch(g, part, all);
    lean_find(g, true);
    g->gentle = group_many(g) && !group_leans(g);
    g->locate = g->locate && !any_merged(g);
    if (g->locate)
        locate_look(g, part);
    group_squeeze(g, JAWS_SLIP, 0);
    if (g->locate)
        impacts(g);
}

#define SLIVER 1e-9             /* of a substep: what sums of times leave by rounding is no substep of its own */

/* Has it taken more than it may? */
static bool spent(const Group *g) { return g->toil_most > 0 && group_toil(g) > g->toil_most; }

/* Movers that close on something within the step hold it from the substep on in which they do. */
static dig_status close_on(Group *g, real dt, real part)
{
    real left = dt - g->t;
    return g->driven && g->way->carries && left > SLIVER * part ? grip_take(g, left, real_min(part, left)) : DIG_OK;
}

#define AT_LIMIT 0.05           /* of the strength */
#define TRIES    6              /* for the time at which it is reached */

/* The joint has let go: where its load came to its limit, or at the start of what was a blow, however short the part. */
static dig_status part_within(Group *g, real dt, real until, int joint, real share)
{
    real low = g->t, low_share = group_share(g, joint, dt), high = until, high_share = share;
    for (int i = 0; i < TRIES && low_share < 1; i++) {
        real reached = low + (high - low) * (1 - low_share) / (high_share - low_share);
        if (reached <= g->t + SLIVER * dt || reached >= until)
            break;
        DIG_TRY(substep(g, reached));
        real now = group_share(g, joint, dt);
        if (g->woke || fabs(now - 1) <= AT_LIMIT) {
            group_part(g, joint, share);
            return DIG_OK;
        }
        group_back_before(g);
        if (now >= high_share)
            break;
        *(now < 1 ? &low : &high) = reached;
        *(now < 1 ? &low_share : &high_share) = now;
    }
    group_part(g, joint, share);
    return DIG_OK;
}

/* A part in which a joint is found over its limit is done again, as far as it held; what it bore is on others, or on none, before the next is
 * judged. */
static dig_status substep_parting(Group *g, real dt, real until)
{
    for (;;) {
        real share;
        bool again = group_may_part(g);
        if (again && !group_keep_before(g))
            return DIG_E_MEMORY;
        DIG_TRY(substep(g, until));
        int worst = g->woke ? -1 : group_overloaded(g, dt, &share);
        if (worst < 0)
            return DIG_OK;
        if (!again) {
            group_part(g, worst, share);
            return DIG_OK;
        }
        group_back_before(g);
        real start = g->t;
        DIG_TRY(part_within(g, dt, until, worst, share));
        if (g->t > start)
            return DIG_OK;              /* the rest is another part */
    }
}

static dig_status sweep_until(Group *g, real dt, real until)
{
    real part = dt / sweep_parts(g);
    while (g->t < until && !g->woke && !spent(g)) {
        real next = g->t + sweep_longest_piece(g, dt);
        DIG_TRY(substep_parting(g, dt, next < until - SLIVER * part ? next : until));
        if (g->woke)
            break;
        group_touch(g, part, true);
        DIG_TRY(close_on(g, dt, part));
        group_squeeze(g, JAWS_SLIP, 0);
        if (g->locate)
            impacts(g);
        if (g->status != DIG_OK)
            return g->status;
    }
    return DIG_OK;
}

dig_status sweep_piece(Group *g, real dt, real until)
{
    real part = real_min(until - g->t, dt / sweep_parts(g));
    begin(g, part, true);
    while (g->t < until && !g->woke && g->status == DIG_OK)
        DIG_TRY(sweep_until(g, dt, until - g->t < 1.5 * part ? until : g->t + part));
    return g->status;
}

dig_status sweep_advance(Group *g, real dt)
{
    DIG_TRY(reserve(g));
    group_find_loops(g);
    g->whirled_parts = sweep_whirled_parts(g, dt);
    real part = dt / sweep_parts(g);
    begin(g, part, g->looked);              /* a way before has looked farther ahead than the first part needs */
    g->looked = false;
    g->breaks_found = true;
    for (int k = 0; k < sweep_parts(g) && !g->woke && !spent(g); k++)
        DIG_TRY(sweep_until(g, dt, k + 1 < sweep_parts(g) ? part * (k + 1) : dt));
    if (spent(g))
        return g->status;
    toil_count(g, dt);
    if (!g->woke) {
        measure(g);
        if (g->joints_direct && !group_bears_load(g) && group_joints_gape(g))
            DIG_TRY(close_gaps(g, part));
        DIG_TRY(group_hold_momenta(g, dt));
        DIG_TRY(g->stage(g, STAGE_SETTLE));
    }
    return g->status;
}
