/* conserve/parts.c - joints taken apart into rows of five formulas, their discrete gradients and their errors.
 *
 * The formulas are found in the rows a joint writes, so that a new type made of the same rows works here too.
 * Notation: subscript 0 at the start, 1 at the end, m their mean; D = pa - pb.
 *   POINT   C = D, in world axes                                      force p on a at am, -p on b at bm
 *   LINE    C = d . D, d fixed in b                                   along dm, in the line through the mean anchor of a
 *   NORMAL  C = x . y, x fixed in a, y in b                           torque p xm x ym
 *   LENGTH  C = |D|                                                   along (D0 + D1) / (|D0| + |D1|)
 *   TWIST   C = angle of a about the axis                             torque along joint_twist, corrected after Gonzalez 1996
 */
#include "conserve/system.h"

typedef struct Arms {
    const Piece *a, *b;
    vec3 a1, am, b1, bm;        /* m  from the centres of mass to the anchors */
    vec3 d0, d1, dm;            /* m  pa - pb                                 */
} Arms;

static Arms arms_of(const System *s, const Tie *t)
{
    Arms r = {.a = &s->piece[t->a], .b = &s->piece[t->b]};
    vec3 a0 = mat3_mul_vec(r.a->r0, t->ra), b0 = mat3_mul_vec(r.b->r0, t->rb);
    r.a1 = mat3_mul_vec(r.a->r, t->ra);
    r.b1 = mat3_mul_vec(r.b->r, t->rb);
    r.am = vec3_scale(0.5, vec3_add(a0, r.a1));
    r.bm = vec3_scale(0.5, vec3_add(b0, r.b1));
    r.d0 = vec3_add(vec3_sub(r.a->x0, r.b->x0), vec3_sub(a0, b0));
    r.d1 = vec3_add(vec3_sub(r.a->x, r.b->x), vec3_sub(r.a1, r.b1));
    r.dm = vec3_scale(0.5, vec3_add(r.d0, r.d1));
    return r;
}

static void set_row(real *row, vec3 la, vec3 aa, vec3 lb, vec3 ab)
{
    const vec3 v[4] = {la, aa, lb, ab};
    for (int i = 0; i < 4; i++) {
        row[3 * i] = v[i].x;
        row[3 * i + 1] = v[i].y;
        row[3 * i + 2] = v[i].z;
    }
}

static vec3 take(const real *row, int i) { return (vec3){row[3 * i], row[3 * i + 1], row[3 * i + 2]}; }

/* ---- the five formulas ---- */

static void eval_point(Tie *t, const Part *part, const Arms *r)
{
    static const vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const real c[3] = {r->d1.x, r->d1.y, r->d1.z};
    for (int i = 0; i < 3; i++) {
        vec3 e = axis[i], back = vec3_neg(e);
        set_row(t->mid[part->at + i], e, vec3_cross(r->am, e), back, vec3_cross(r->bm, back));
        set_row(t->end[part->at + i], e, vec3_cross(r->a1, e), back, vec3_cross(r->b1, back));
        t->error[part->at + i] = c[i];
    }
}

static void eval_line(Tie *t, const Part *part, const Arms *r)
{
    vec3 d0 = mat3_mul_vec(r->b->r0, part->in_b), d1 = mat3_mul_vec(r->b->r, part->in_b);
    vec3 dm = vec3_scale(0.5, vec3_add(d0, d1));
    set_row(t->mid[part->at], dm, vec3_cross(r->am, dm), vec3_neg(dm), vec3_cross(dm, vec3_add(r->bm, r->dm)));
    set_row(t->end[part->at], d1, vec3_cross(r->a1, d1), vec3_neg(d1), vec3_cross(d1, vec3_add(r->b1, r->d1)));
    t->error[part->at] = vec3_dot(d1, r->d1) - part->offset;
}

static void eval_normal(Tie *t, const Part *part, const Arms *r)
{
    vec3 x0 = mat3_mul_vec(r->a->r0, part->in_a), x1 = mat3_mul_vec(r->a->r, part->in_a);
    vec3 y0 = mat3_mul_vec(r->b->r0, part->in_b), y1 = mat3_mul_vec(r->b->r, part->in_b);
    vec3 dm = vec3_scale(0.25, vec3_cross(vec3_add(x0, x1), vec3_add(y0, y1))), d1 = vec3_cross(x1, y1);
    set_row(t->mid[part->at], vec3_zero(), dm, vec3_zero(), vec3_neg(dm));
    set_row(t->end[part->at], vec3_zero(), d1, vec3_zero(), vec3_neg(d1));
    t->error[part->at] = vec3_dot(x1, y1) - part->offset;
}

static void eval_length(Tie *t, const Part *part, const Arms *r)
{
    real l0 = vec3_length(r->d0), l1 = vec3_length(r->d1);
    vec3 m = vec3_scale(2 / (l0 + l1), r->dm), n = vec3_scale(1 / l1, r->d1);
    set_row(t->mid[part->at], m, vec3_cross(r->am, m), vec3_neg(m), vec3_cross(m, r->bm));
    set_row(t->end[part->at], n, vec3_cross(r->a1, n), vec3_neg(n), vec3_cross(n, r->b1));
    t->error[part->at] = l1 - part->offset;
}

static JointView view_at(const Tie *t, int turn, const Piece *a, const Piece *b, bool end)
{
    JointView v = {0};
    joint_end_set(&v.a, end ? a->x : a->x0, end ? a->q : a->q0, vec3_zero(), vec3_zero(), t->ra, t->fa);
    joint_end_set(&v.b, end ? b->x : b->x0, end ? b->q : b->q0, vec3_zero(), vec3_zero(), t->rb, t->fb);
    return turn > 0 ? joint_turned(&v, turn) : v;
}

static vec3 mean(vec3 a, vec3 b) { return vec3_scale(0.5, vec3_add(a, b)); }

/* The axes' means give a direction that is right to second order; the rest of the change goes along the relative turn. */
static void eval_twist(Tie *t, const Part *part, const Arms *r)
{
    JointView v0 = view_at(t, part->turn, r->a, r->b, false), v1 = view_at(t, part->turn, r->a, r->b, true), vm = v1;
    real angle = part->start + part->offset;
    t->error[part->at] = joint_angle(&v1, &angle) - part->offset;
    vm.a.axis = mean(v0.a.axis, v1.a.axis);
    vm.b.axis = mean(v0.b.axis, v1.b.axis);
    vec3 dm = joint_twist(&vm), d1 = joint_twist(&v1), turn = vec3_sub(r->a->turn, r->b->turn);
    real size = vec3_length2(turn), change = t->error[part->at] - part->start;
    if (size > 1e-10)
        dm = vec3_mad(dm, (change - vec3_dot(dm, turn)) / size, turn);
    set_row(t->mid[part->at], vec3_zero(), dm, vec3_zero(), vec3_neg(dm));
    set_row(t->end[part->at], vec3_zero(), d1, vec3_zero(), vec3_neg(d1));
}

typedef void EvalFn(Tie *t, const Part *part, const Arms *r);
static EvalFn *const formulas[] = {[PART_POINT] = eval_point, [PART_LINE] = eval_line, [PART_NORMAL] = eval_normal,
                                   [PART_LENGTH] = eval_length, [PART_TWIST] = eval_twist};

/* ---- the rows of one step ---- */

/* Share of a hard row's own diagonal that keeps redundant joints solvable: errors are taken anew in every iteration, so that it
 * costs no accuracy. */
#define SHARE 1e-8

/* What a unit impulse of a row changes its own rate by, at one end. */
static real mobility(const Piece *piece, const real *row)
{
    if (!piece->moves)
        return 0;
    vec3 turn = mat3_mul_vec(mat3_transpose(piece->r), take(row, 1));
    return vec3_length2(take(row, 0)) / piece->mass + vec3_dot(turn, mat3_mul_vec(piece->inv_inertia, turn));
}

static void push(Piece *piece, const real *row, real p)
{
    piece->push = vec3_mad(piece->push, p, take(row, 0));
    piece->twist = vec3_mad(piece->twist, p, take(row, 1));
}

static void finish_rows(System *s, Tie *t, const Part *part)
{
    Piece *a = &s->piece[t->a], *b = &s->piece[t->b];
    for (int i = part->at; i < part->at + part->rows; i++) {
        real p = s->p[t->row + i];
        if (part->soft) {
            real half = 0.5 * s->h * part->stiffness;
            real begin = half * (1 - part->late) - part->damper * (1 + part->late);
            t->give[i] = 1 / ((half + part->damper) * (1 + part->late));
            t->error[i] += t->give[i] * (p + begin * part->start - part->damper * part->late * s->h * part->rate);
        }
        push(a, t->mid[i], p);
        push(b, t->mid[i] + 6, p);
    }
}

/* Those of soft rows are set with their errors. */
void parts_give(const System *s, Tie *t)
{
    real share = SHARE * (s->resting ? 1 : 0.5 * s->h);
    for (int n = t->part; n < t->part + t->parts; n++)
        for (int i = s->part[n].at; i < s->part[n].at + s->part[n].rows && !s->part[n].soft; i++)
            t->give[i] = share * (mobility(&s->piece[t->a], t->end[i]) + mobility(&s->piece[t->b], t->end[i] + 6));
}

void parts_evaluate(System *s)
{
    for (int i = 0; i < s->piece_count; i++)
        s->piece[i].push = s->piece[i].twist = vec3_zero();
    for (int i = 0; i < s->tie_count; i++) {
        Tie *t = &s->tie[i];
        Arms r = arms_of(s, t);
        for (int k = t->part; k < t->part + t->parts; k++) {
            formulas[s->part[k].kind](t, &s->part[k], &r);
            finish_rows(s, t, &s->part[k]);
        }
    }
}

static bool about(real length, real rest) { return length > 0.5 * rest && length < 2 * rest; }

/* What is pressed together may pass through its middle; what stays about as long as it is at rest cannot have. */
bool parts_turn_over(const System *s, bool rigid)
{
    for (int i = 0; i < s->tie_count; i++)
        for (int k = s->tie[i].part; k < s->tie[i].part + s->tie[i].parts; k++) {
            const Part *part = &s->part[k];
            if (!part->soft || part->kind != PART_LENGTH)
                continue;
            Arms r = arms_of(s, &s->tie[i]);
            bool stays = about(vec3_length(r.d0), part->offset) && about(vec3_length(r.d1), part->offset);
            if (vec3_dot(r.d0, r.d1) < 0 && (stays || !rigid))
                return true;
        }
    return false;
}

/* The blows of impulses at fixed poses; p has 6 per tie. */
void parts_push(System *s, const real *p)
{
    for (int i = 0; i < s->piece_count; i++)
        s->piece[i].push = s->piece[i].twist = vec3_zero();
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        for (int k = 0; k < t->rows; k++) {
            push(&s->piece[t->a], t->end[k], p[6 * i + k]);
            push(&s->piece[t->b], t->end[k] + 6, p[6 * i + k]);
        }
    }
}

/* After parts_begin; the discrete gradient is that of the start. */
void parts_guess(System *s)
{
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        for (int k = 0; k < t->rows; k++) {
            push(&s->piece[t->a], t->mid[k], s->p[t->row + k]);
            push(&s->piece[t->b], t->mid[k] + 6, s->p[t->row + k]);
        }
    }
}

/* coth z - 1 / z (Langevin's function) */
static real langevin(real z) { return fabs(z) < 1e-3 ? z / 3 : 1 / tanh(z) - 1 / z; }

static real rate_of(const Piece *piece, const real *row)
{
    return vec3_dot(take(row, 0), piece->v0) + vec3_dot(take(row, 1), mat3_mul_vec(piece->r0, piece->w0));
}

/* J  What each hard row would take of the motion if it alone had no rate any more, by the gradients at the end of the last step. */
real parts_across(const System *s, const Tie *t)
{
    const Group *g = s->g;
    const int ends[2] = {t->a, t->b};
    real sum = 0;
    for (int n = t->part; n < t->part + t->parts; n++)
        for (int i = s->part[n].at; i < s->part[n].at + s->part[n].rows && !s->part[n].soft; i++) {
            real rate = 0, gives = 0;
            for (int k = 0; k < 2; k++) {
                const real *row = t->end[i] + 6 * k;
                if (!s->piece[ends[k]].moves)
                    continue;
                rate += vec3_dot(take(row, 0), g->vel[ends[k]].v) + vec3_dot(take(row, 1), g->vel[ends[k]].w);
                gives += mobility(&s->piece[ends[k]], row);
            }
            sum += gives > 0 ? 0.5 * rate * rate / gives : 0;
        }
    return sum;
}

/* A damper that stops a motion well within the step must not turn it round, as means over the step would. Spring and damper
 * answer to (1 - late) / 2 times the state at the start and (1 + late) / 2 times that at the end, with `late` such that the row's
 * own motion decays as it does in truth: v1 / v0 = e^(-2 z), z = h c / (2 m). Positions still follow the mean velocity: what is
 * dead within a step comes to rest in two if the damper is k h / 2 at least. Odd in h, so that the rule stays symmetric. Not where
 * the damper is stronger than that: such a spring creeps for longer than a step. */
static void begin_damper(const System *s, const Tie *t, Part *part)
{
    const Piece *a = &s->piece[t->a], *b = &s->piece[t->b];
    const real *row = t->end[part->at];
    real strong = 0.5 * fabs(s->h) * part->stiffness;
    part->late = strong > part->damping ? langevin(0.5 * s->h * part->damping * (mobility(a, row) + mobility(b, row + 6))) : 0;
    part->damper = part->damping + fabs(part->late) * real_max(0, strong - part->damping);
    part->rate = rate_of(a, row) + rate_of(b, row + 6);
}

/* C at the start; the end poses are the start poses now. */
void parts_begin(System *s)
{
    for (int i = 0; i < s->tie_count; i++) {
        Tie *t = &s->tie[i];
        Arms r = arms_of(s, t);
        for (int k = t->part; k < t->part + t->parts; k++) {
            formulas[s->part[k].kind](t, &s->part[k], &r);
            s->part[k].start = t->error[s->part[k].at];
            if (s->part[k].soft)
                begin_damper(s, t, &s->part[k]);
        }
    }
}

/* ---- how the forces change with the end poses: columns of a 12 x 12 matrix, linear and angular of a, then of b ---- */

typedef struct Twelve { vec3 xa, ta, xb, tb; } Twelve;

static Twelve unit_column(int i)
{
    real u[12] = {0};
    u[i] = 1;
    return (Twelve){take(u, 0), take(u, 1), take(u, 2), take(u, 3)};
}

static Twelve bend_line(const Part *part, const Arms *r, real p, Twelve d)
{
    vec3 d0 = mat3_mul_vec(r->b->r0, part->in_b), d1 = mat3_mul_vec(r->b->r, part->in_b), dm = mean(d0, d1);
    vec3 change = vec3_scale(0.5 * p, vec3_cross(d.tb, d1)), arm = vec3_scale(0.5, vec3_cross(d.ta, r->a1));
    vec3 lever = vec3_mad(arm, 0.5, vec3_sub(d.xa, d.xb)), from_b = vec3_add(r->bm, r->dm);
    return (Twelve){change, vec3_mad(vec3_cross(r->am, change), p, vec3_cross(arm, dm)), vec3_neg(change),
                    vec3_neg(vec3_mad(vec3_cross(from_b, change), p, vec3_cross(lever, dm)))};
}

static Twelve bend_length(const Part *part, const Arms *r, real p, Twelve d)
{
    (void)part;
    real l0 = vec3_length(r->d0), l1 = vec3_length(r->d1);
    vec3 m = vec3_scale(2 / (l0 + l1), r->dm), n = vec3_scale(1 / l1, r->d1);
    vec3 aa = vec3_cross(d.ta, r->a1), bb = vec3_cross(d.tb, r->b1);
    vec3 apart = vec3_add(vec3_sub(d.xa, d.xb), vec3_sub(aa, bb));
    vec3 change = vec3_scale(p / (l0 + l1), vec3_mad(apart, -vec3_dot(n, apart), m));
    return (Twelve){change, vec3_mad(vec3_cross(r->am, change), 0.5 * p, vec3_cross(aa, m)), vec3_neg(change),
                    vec3_neg(vec3_mad(vec3_cross(r->bm, change), 0.5 * p, vec3_cross(bb, m)))};
}

typedef Twelve BendFn(const Part *part, const Arms *r, real p, Twelve d);
static BendFn *const bends[] = {[PART_POINT] = NULL, [PART_LINE] = bend_line, [PART_NORMAL] = NULL,
                                [PART_LENGTH] = bend_length, [PART_TWIST] = NULL};

static void add_mat(real k[12][12], int row, int column, mat3 m)
{
    const vec3 rows[3] = {m.r0, m.r1, m.r2};
    for (int i = 0; i < 3; i++) {
        k[row + i][column] += rows[i].x;
        k[row + i][column + 1] += rows[i].y;
        k[row + i][column + 2] += rows[i].z;
    }
}

/* Torque rm x p of an arm whose end turns: (t x r) x p / 2 = (r (p . t) - t (p . r)) / 2. */
static mat3 bend_point(vec3 r, vec3 p)
{
    real c = -0.5 * vec3_dot(r, p);
    return mat3_add(mat3_scale(0.5, mat3_outer(r, p)), mat3_diagonal((vec3){c, c, c}));
}

/* Torque p (x x y) on a, against it on b, of directions x in a and y in b, each taken at its mean: of the ends' turns ta and tb
 * p / 2 ((ta x x1) x ym + xm x (tb x y1)), with (t x x) x y = x (y . t) - t (x . y). */
static void bend_normal(const Part *part, const Arms *r, real p, real k[12][12])
{
    vec3 x1 = mat3_mul_vec(r->a->r, part->in_a), y1 = mat3_mul_vec(r->b->r, part->in_b);
    vec3 xm = mean(mat3_mul_vec(r->a->r0, part->in_a), x1), ym = mean(mat3_mul_vec(r->b->r0, part->in_b), y1);
    real a = -0.5 * p * vec3_dot(x1, ym), b = 0.5 * p * vec3_dot(xm, y1);
    mat3 of_a = mat3_add(mat3_scale(0.5 * p, mat3_outer(x1, ym)), mat3_diagonal((vec3){a, a, a}));
    mat3 of_b = mat3_add(mat3_scale(-0.5 * p, mat3_outer(y1, xm)), mat3_diagonal((vec3){b, b, b}));
    add_mat(k, 3, 3, of_a);
    add_mat(k, 3, 9, of_b);
    add_mat(k, 9, 3, mat3_scale(-1, of_a));
    add_mat(k, 9, 9, mat3_scale(-1, of_b));
}

void parts_bend(const System *s, const Tie *t, mat3 *a, mat3 *b)
{
    Arms r = arms_of(s, t);
    *a = *b = mat3_zero();
    for (int n = t->part; n < t->part + t->parts; n++) {
        const real *p = s->p + t->row + s->part[n].at;
        if (s->part[n].kind != PART_POINT)
            continue;
        vec3 force = {p[0], p[1], p[2]};
        *a = mat3_add(*a, bend_point(r.a1, force));
        *b = mat3_add(*b, bend_point(r.b1, vec3_neg(force)));
    }
}

void parts_stiffness(const System *s, const Tie *t, real k[12][12])
{
    Arms r = arms_of(s, t);
    memset(k, 0, 144 * sizeof k[0][0]);
    for (int n = t->part; n < t->part + t->parts; n++) {
        const Part *part = &s->part[n];
        const real *p = s->p + t->row + part->at;
        if (part->kind == PART_POINT) {
            vec3 force = {p[0], p[1], p[2]};
            add_mat(k, 3, 3, bend_point(r.a1, force));
            add_mat(k, 9, 9, bend_point(r.b1, vec3_neg(force)));
        } else if (part->kind == PART_NORMAL) {
            bend_normal(part, &r, p[0], k);
        }
        for (int i = 0; i < 12 && bends[part->kind]; i++) {
            Twelve c = bends[part->kind](part, &r, p[0], unit_column(i));
            const vec3 v[4] = {c.xa, c.ta, c.xb, c.tb};
            for (int m = 0; m < 4; m++) {
                k[3 * m][i] += v[m].x;
                k[3 * m + 1][i] += v[m].y;
                k[3 * m + 2][i] += v[m].z;
            }
        }
    }
}
