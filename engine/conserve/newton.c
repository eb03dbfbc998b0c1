/* conserve/newton.c - one step of the energy-momentum rule, by Newton's method. */
#include "conserve/system.h"

#define ITERATIONS 12
#define EXACT 1e-13             /* m  residual at which a precise step is done               */
#define FINE 3e-12              /* m  for other steps, and when an iteration gains little    */
#define LEFT 3e-13              /* m  for these, if the last iteration had the factor of one before */
#define ENOUGH 1e-9             /* m  residual that is taken when rounding allows no better  */
#define QUICK 1e-4              /* of the residual before: an iteration of a precise step that leaves less lends the next its factor */
#define SLOW 0.05               /* the same: one with such a factor that leaves more is the last of them */
#define OVERSHOOT 1e-15         /* m  residual down to which such iterations of a precise step gain what those with a factor of their own would */
#define GUESSED 1.0             /* of the farthest move by joints that were guessed: a residual below it says the guess is good */
#define SMOOTH 0.1              /* the same: above it joints do not do the like in the steps of a part, and later ones begin without */
#define TURN_AT_ONCE 0.5        /* rad, of one Newton iteration                              */
#define TURN_MOST 6.0           /* of the Cayley vector: 143 degrees                         */

static mat3 in_world(mat3 r, mat3 m) { return mat3_mul(mat3_mul(r, m), mat3_transpose(r)); }

static bool imply(System *s, Piece *b)
{
    b->r = quat_matrix(b->q);
    if (!b->moves)
        return true;
    quat d = quat_mul(quat_conjugate(b->q0), b->q);
    vec3 c = vec3_scale(2 / d.w, (vec3){d.x, d.y, d.z});
    b->w = vec3_mad(vec3_neg(b->w0), 2 / s->h, c);
    b->turn = mat3_mul_vec(b->r0, c);
    return vec3_length2(c) < TURN_MOST * TURN_MOST;        /* false for NaN too */
}

static vec3 implied_velocity(const System *s, const Piece *b)
{
    return vec3_mad(vec3_neg(b->v0), 2 / s->h, vec3_sub(b->x, b->x0));
}

static void put3(real *to, vec3 v)
{
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

static vec3 get3(const real *v) { return (vec3){v[0], v[1], v[2]}; }

/* Residuals into side, negated; the largest in metres. False: a body turns too far. */
static bool evaluate(System *s)
{
    int bodies = s->g->moving_count;
    for (int i = 0; i < s->piece_count; i++)
        if (!imply(s, &s->piece[i]))
            return false;
    parts_evaluate(s);
    s->residual = 0;
    for (int i = 0; i < bodies; i++) {
        const Piece *b = &s->piece[i];
        real *side = s->side + 6 * i;
        put3(side, vec3_zero());
        put3(side + 3, vec3_zero());
        if (!b->moves)
            continue;
        vec3 linear = vec3_sub(vec3_add(b->p0, b->push), vec3_scale(b->mass, implied_velocity(s, b)));
        vec3 angular = vec3_sub(vec3_add(b->l0, b->twist), mat3_mul_vec(b->r, mat3_mul_vec(b->inertia, b->w)));
        put3(side, linear);
        put3(side + 3, angular);
        s->residual = real_max(s->residual, fabs(s->h) * vec3_largest(vec3_abs(linear)) / b->mass);
        s->residual = real_max(s->residual, fabs(s->h) * vec3_largest(vec3_abs(angular)) / b->reach);
    }
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        for (int k = 0; k < t->rows; k++) {
            s->side[6 * (bodies + i) + k] = -t->error[k];
            s->residual = real_max(s->residual, fabs(t->error[k]));
        }
    }
    return isfinite(s->residual);
}

/* ---- the matrix ---- */

static void put_mat(real *to, int stride, mat3 m)
{
    put3(to, m.r0);
    put3(to + stride, m.r1);
    put3(to + 2 * stride, m.r2);
}

static void body_block(System *s, int i)
{
    const Piece *b = &s->piece[i];
    Block at = order_diagonal(s, i);
    real *d = s->value + at.at;
    if (!b->moves) {
        for (int k = 0; k < 6; k++)
            d[7 * k] = 1;
        return;
    }
    real m = s->resting ? b->mass : 2 * b->mass / s->h;
    mat3 turn = in_world(b->r, b->inertia);
    if (!s->resting) {
        vec3 g = vec3_scale(0.5, mat3_mul_vec(mat3_transpose(b->r0), b->turn));
        mat3 slope = mat3_add(mat3_add(mat3_identity(), mat3_skew(g)), mat3_outer(g, g));
        turn = mat3_scale(2 / s->h, in_world(b->r, mat3_mul(b->inertia, slope)));
        turn = mat3_sub(turn, mat3_skew(mat3_mul_vec(b->r, mat3_mul_vec(b->inertia, b->w))));
    }
    d[0] = d[7] = d[14] = m;
    put_mat(d + 21, 6, turn);
}

static void subtract_block(System *s, Block to, real k[12][12], int row, int column)
{
    for (int i = 0; i < 6; i++)
        for (int c = 0; c < 6; c++)
            s->value[to.at + i * to.stride + c] -= k[row + i][column + c];
}

static void subtract_turn(System *s, int body, mat3 k)
{
    Block at = order_diagonal(s, body);
    const vec3 row[3] = {k.r0, k.r1, k.r2};
    for (int i = 0; i < 3; i++) {
        real *d = s->value + at.at + (3 + i) * at.stride + 3;
        d[0] -= row[i].x;
        d[1] -= row[i].y;
        d[2] -= row[i].z;
    }
}

static void stiffness_blocks(System *s, const Tie *t, const TieBlocks *at)
{
    bool a = s->piece[t->a].moves, b = s->piece[t->b].moves;
    if (!t->coupled) {
        mat3 turn[2];
        parts_bend(s, t, &turn[0], &turn[1]);
        if (a)
            subtract_turn(s, t->a, turn[0]);
        if (b)
            subtract_turn(s, t->b, turn[1]);
        return;
    }
    real k[12][12];
    parts_stiffness(s, t, k);
    if (a)
        subtract_block(s, order_diagonal(s, t->a), k, 0, 0);
    if (b)
        subtract_block(s, order_diagonal(s, t->b), k, 6, 6);
    if (a && b) {
        subtract_block(s, at->ab, k, 0, 6);
        subtract_block(s, at->ba, k, 6, 0);
    }
}

static void tie_blocks(System *s, int i)
{
    Tie *t = &s->tie[i];
    const TieBlocks *at = &s->blocks[i];
    Block own = order_diagonal(s, s->g->moving_count + i);
    parts_give(s, t);
    for (int k = 0; k < t->rows; k++)
        s->value[own.at + k * own.stride + k] = t->give[k];
    for (int side = 0; side < 2; side++) {
        if (!s->piece[side ? t->b : t->a].moves)
            continue;
        for (int k = 0; k < t->rows; k++)
            for (int c = 0; c < 6; c++) {
                s->value[at->ja[side].at + k * at->ja[side].stride + c] = t->end[k][6 * side + c];
                s->value[at->aj[side].at + c * at->aj[side].stride + k] = -t->mid[k][6 * side + c];
            }
    }
    if (!s->resting)
        stiffness_blocks(s, t, at);
}

static bool solve(System *s)
{
    memset(s->value, 0, (size_t)s->value_count * sizeof *s->value);
    for (int i = 0; i < s->g->moving_count; i++)
        body_block(s, i);
    for (int i = 0; i < s->tie_count; i++)
        tie_blocks(s, i);
    return factor_solve(s);
}

/* ---- the step ---- */

static void improve(System *s)
{
    int bodies = s->g->moving_count;
    for (int i = 0; i < bodies; i++) {
        Piece *b = &s->piece[i];
        if (!b->moves)
            continue;
        vec3 turn = get3(s->side + 6 * i + 3);
        real length = vec3_length(turn);
        b->x = vec3_add(b->x, get3(s->side + 6 * i));
        if (length > TURN_AT_ONCE)
            turn = vec3_scale(TURN_AT_ONCE / length, turn);
        b->q = quat_unit(quat_mul(quat_exp(turn), b->q));
    }
    for (int i = 0; i < s->tie_count; i++)
        for (int k = 0; k < s->tie[i].rows; k++)
            s->p[s->tie[i].row + k] += s->side[6 * (bodies + i) + k];
}

/* Of the impulses of the last step, what the next begins with. Where joints share a load in many ways, nothing but rounding says in
 * which: it would add up from step to step (a door on three hinges at 1 kHz: to 226 times its weight in 20 s). */
#define KEEPS (1 - 1.0 / 128)

static bool carries_on(const System *s) { return s->pulls > 0 && s->smooth; }

/* What joints do to bodies is a smooth function of time, whichever way steps go: the polynomial through the steps of a composed part. */
static void carry_on(System *s)
{
    real weight[PULLS], t = s->since + 0.5 * s->h;
    for (int k = 0; k < s->pulls; k++) {
        weight[k] = s->h;
        for (int j = 0; j < s->pulls; j++)
            weight[k] *= j == k ? 1 : (t - s->pulled[j]) / (s->pulled[k] - s->pulled[j]);
    }
    for (int i = 0; i < s->piece_count; i++)
        for (int k = 0; k < s->pulls; k++) {
            Piece *b = &s->piece[i];
            b->push = vec3_mad(b->push, weight[k], b->pull[k]);
            b->twist = vec3_mad(b->twist, weight[k], b->wrench[k]);
        }
}

typedef enum Guess { GUESS_COASTS, GUESS_FORCED, GUESS_JOINED } Guess;

/* Where bodies would get by their velocities; by outer forces too; and by what the joints did in the last step, or do in the steps of a
 * composed part. Returns the farthest that the joints' part moves one, m. */
static real predict(System *s, Guess by)
{
    real farthest = 0;
    for (int i = 0; i < s->row_count; i++)
        s->p[i] = KEEPS * s->h * s->p_last[i];
    for (int i = 0; i < s->piece_count; i++)
        s->piece[i].push = s->piece[i].twist = vec3_zero();
    if (by == GUESS_JOINED && carries_on(s))
        carry_on(s);
    else if (by == GUESS_JOINED)
        parts_guess(s);
    for (int i = 0; i < s->piece_count; i++) {
        Piece *b = &s->piece[i];
        if (!b->moves)
            continue;
        vec3 v = b->v0, w = b->w0;
        if (by != GUESS_COASTS) {
            v = vec3_scale(1 / b->mass, vec3_add(b->p0, b->push));
            w = mat3_mul_vec(b->inv_inertia, mat3_mul_vec(mat3_transpose(b->r0), vec3_add(b->l0, b->twist)));
        }
        vec3 g = vec3_scale(0.25 * s->h, vec3_add(b->w0, w));
        b->x = vec3_mad(b->x0, 0.5 * s->h, vec3_add(b->v0, v));
        b->q = quat_unit(quat_mul(b->q0, (quat){g.x, g.y, g.z, 1}));
        farthest = real_max(farthest, fabs(0.5 * s->h) * vec3_length(b->push) / b->mass);
    }
    return farthest;
}

/* The joints' part counts if joints then fit much better than it moved bodies: light ones between taut joints are thrown about by it.
 * Not in rings: what of a load is shared in many ways is nothing as long as the directions are exactly those of the last step, and
 * would grow from step to step where they are a little off. Nor do outer forces count that throw a spring over to its other side: struts
 * that hold 1 g under 1 kN stood on their heads there, in balance, too. */
static bool begin_newton(System *s)
{
    if (carries_on(s) || !s->rings) {
        real farthest = predict(s, GUESS_JOINED);
        bool fine = evaluate(s);
        s->smooth = s->smooth && fine && s->residual < SMOOTH * farthest;
        if (fine && s->residual < GUESSED * farthest)
            return true;
        s->g->evaluations++;
    }
    predict(s, GUESS_FORCED);
    if (!evaluate(s))
        return false;
    if (!parts_turn_over(s, false))
        return true;
    s->g->evaluations++;
    predict(s, GUESS_COASTS);
    return evaluate(s);
}

static void note_pulls(System *s)
{
    if (s->precise && s->pulls < PULLS) {
        for (int i = 0; i < s->piece_count; i++) {
            s->piece[i].pull[s->pulls] = vec3_scale(1 / s->h, s->piece[i].push);
            s->piece[i].wrench[s->pulls] = vec3_scale(1 / s->h, s->piece[i].twist);
        }
        s->pulled[s->pulls++] = s->since + 0.5 * s->h;
        s->smooth = s->pulls == 1 || s->smooth;
    }
    s->since += s->h;
}

/* The velocities from the impulses, not from the poses: momentum is then exact to rounding whatever the tolerance. */
static void finish(System *s)
{
    for (int i = 0; i < s->g->moving_count; i++) {
        Piece *b = &s->piece[i];
        if (!b->moves)
            continue;
        b->v0 = vec3_scale(1 / b->mass, vec3_add(b->p0, b->push));
        vec3 l = mat3_mul_vec(mat3_transpose(b->r), vec3_add(b->l0, b->twist));
        b->w = mat3_mul_vec(b->inv_inertia, l);
    }
    for (int i = 0; i < s->row_count; i++)
        s->p_last[i] = s->p[i] / s->h;
    note_pulls(s);
}

/* Is it good enough? last: the residual before; kept: the last iteration went by the factor of one before. A precise step that began well
 * goes on by the factor of its only one. */
static bool is_solved(const System *s, real best, real last, bool kept, int iteration)
{
    if (s->residual < (s->precise ? EXACT : kept ? LEFT : FINE))
        return !s->precise || s->residual < OVERSHOOT || (kept ? s->residual > SLOW * last : iteration != 1);
    return (s->residual < FINE && s->residual > 0.01 * best && !kept) || (s->residual < ENOUGH && iteration >= 7);
}

/* Near the solution the matrix hardly changes from one iteration to the next: the factor of the last one then gains about as many digits
 * as that one did, for a quarter of the work or less, and is not counted. Precise steps go on from there to rounding, others
 * begin with it where two such iterations should be enough. Not where steps are extrapolated, which shows what they leave. */
static bool lends_factor(const System *s, real last, bool kept)
{
    real gain = s->residual / last;
    if (kept)
        return gain < SLOW;
    return s->precise ? gain < QUICK : s->lends && s->residual * gain * gain < LEFT;
}

bool newton_step(System *s)
{
    real best = INFINITY, last = INFINITY;
    bool kept = false;
    for (int i = 0; i <= ITERATIONS; i++) {
        if (i == 0 ? !begin_newton(s) : !evaluate(s))
            return false;
        s->g->evaluations += !kept;
        if (is_solved(s, best, last, kept, i)) {
            if (parts_turn_over(s, true))
                return false;
            finish(s);
            return true;
        }
        if (i == ITERATIONS || (i >= 6 && s->residual > 10 * best))
            return false;
        kept = i > 0 && lends_factor(s, last, kept);
        if (kept)
            factor_again(s);
        else if (!solve(s))
            return false;
        last = s->residual;
        best = real_min(best, s->residual);
        improve(s);
    }
    return false;
}

/* ---- at fixed poses: what broke the joints from outside is put right ---- */

/* Springs and dampers rest, or answer to the end of the step: p = -h (k (C + h C') + c C'), with error for what C' is to be but for p. */
static void rest_soft(const System *s, Tie *t)
{
    for (int n = t->part; n < t->part + t->parts; n++) {
        const Part *part = &s->part[n];
        real stiff = s->h * part->stiffness + part->damping;
        for (int k = part->at; k < part->at + part->rows && part->soft; k++) {
            if (!s->yields) {
                memset(t->end[k], 0, sizeof t->end[k]);
                memset(t->mid[k], 0, sizeof t->mid[k]);
            }
            t->give[k] = s->yields ? 1 / (s->h * stiff) : 1;
            t->error[k] = s->yields ? part->stiffness * part->start / stiff : 0;
        }
    }
}

static void evaluate_resting(System *s)
{
    for (int i = 0; i < s->piece_count; i++)
        s->piece[i].turn = vec3_zero();
    memset(s->p, 0, (size_t)s->row_count * sizeof *s->p);
    parts_evaluate(s);
    memset(s->side, 0, (size_t)(6 * s->node_count) * sizeof *s->side);
    for (int i = 0; i < s->tie_count; i++)
        rest_soft(s, &s->tie[i]);
}

static bool solve_resting(System *s)
{
    s->resting = true;
    bool fine = solve(s);
    s->resting = false;
    return fine;
}

#define PLACED 60              /* iterations; three are usual, 14 where a chain that is all but straight is too short */

#define APPROACHES 300          /* more, that were cut short */

/* Poses far off are approached along one direction: were some bodies held back alone, what they are tied to would be torn away. */
static bool shorten(System *s)
{
    int bodies = s->g->moving_count;
    real most = 0;
    for (int i = 0; i < bodies; i++)
        most = s->piece[i].moves ? real_max(most, vec3_length(get3(s->side + 6 * i + 3))) : most;
    for (int k = 0; k < 6 * bodies && most > TURN_AT_ONCE; k++)
        s->side[k] *= TURN_AT_ONCE / most;
    return most > TURN_AT_ONCE;
}

/* Least move of the bodies, weighed by mass, after which the hard rows have no error. */
bool newton_place(System *s)
{
    int bodies = s->g->moving_count;
    for (int n = 0, far = 0; n < PLACED && far < APPROACHES; n++) {
        real worst = 0;
        evaluate_resting(s);
        for (int i = 0; i < s->tie_count; i++)
            for (int k = 0; k < s->tie[i].rows; k++) {
                s->side[6 * (bodies + i) + k] = -s->tie[i].error[k];
                worst = real_max(worst, fabs(s->tie[i].error[k]));
            }
        if (worst < ENOUGH)
            return true;
        if (!isfinite(worst) || !solve_resting(s))
            return false;
        if (shorten(s)) {
            n--;
            far++;
        }
        improve(s);
        for (int i = 0; i < bodies; i++) {
            Piece *b = &s->piece[i];
            vec3 w = mat3_mul_vec(b->r0, b->w0);
            b->x0 = b->x;
            b->q0 = b->q;
            b->r = b->r0 = quat_matrix(b->q);
            b->w0 = mat3_mul_vec(mat3_transpose(b->r0), w);
        }
    }
    return false;
}

static real rate_of(const System *s, const Tie *t, int row)
{
    real rate = 0;
    for (int side = 0; side < 2; side++) {
        const Piece *b = &s->piece[side ? t->b : t->a];
        rate += vec3_dot(get3(t->end[row] + 6 * side), b->v0) +
                vec3_dot(get3(t->end[row] + 6 * side + 3), mat3_mul_vec(b->r0, b->w0));
    }
    return rate;
}

/* Least change of the velocities, weighed by mass, after which the hard rows have no rate. */
bool newton_clean(System *s)
{
    int bodies = s->g->moving_count;
    evaluate_resting(s);
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        for (int n = t->part; n < t->part + t->parts; n++)
            for (int k = s->part[n].at; k < s->part[n].at + s->part[n].rows; k++)
                s->side[6 * (bodies + i) + k] = -rate_of(s, t, k) - (s->part[n].soft ? t->error[k] : 0);
    }
    bool fine = solve_resting(s);
    for (int i = 0; i < bodies && fine; i++) {
        Piece *b = &s->piece[i];
        b->v0 = vec3_add(b->v0, get3(s->side + 6 * i));
        b->w0 = vec3_add(b->w0, mat3_mul_vec(mat3_transpose(b->r0), get3(s->side + 6 * i + 3)));
    }
    parts_push(s, s->side + 6 * bodies);
    return fine;
}
