/* solve/rows.c - the parts that joints are built from: rows with their Jacobians.
 *
 * Notation: pa, pb anchors; e, u, n the joint frame (axis, u, n); indices a and b for the body it is fixed in. For a vector c
 * fixed in body b, dc/dt = wb x c; x . (w x y) = w . (y x x). Each row's comment derives its rate from its error, and its drift
 * from its rate: d(rate)/dt with wa, wb and the velocities va, vb of the centres of mass constant.
 */
#include "solve/joint_type.h"

/* m  shorter than this, a length has no direction */
#define SHORTEST 1e-12
#define LIMIT_TOLERANCE 1e-4    /* m or rad */

/* Without its bodies. */
static inline Row *add_row(RowList *list, RowKind kind, int slot)
{
    DIG_ASSERT(list->count < list->capacity && slot >= 0 && slot < JOINT_SLOTS);
    Row *r = &list->rows[list->count++];
    r->kind = kind;
    r->slot = slot;
    r->error = r->rate = r->drift = r->stiffness = r->damping = 0;
    r->hi = INFINITY;
    r->angular = false;
    return r;
}

Row *rows_add(RowList *list, RowKind kind, int slot)
{
    Row *r = add_row(list, kind, slot);
    r->count = 0;
    memset(r->body, 0, sizeof r->body);
    memset(r->lin, 0, sizeof r->lin);
    memset(r->ang, 0, sizeof r->ang);
    return r;
}

/* Of the two bodies of the joint, without its Jacobian. */
static inline Row *add_pair(RowList *list, const JointView *j, RowKind kind, int slot)
{
    Row *r = add_row(list, kind, slot);
    r->count = 2;
    r->body[0] = j->a.body;
    r->body[1] = j->b.body;
    return r;
}

/* Of the same bodies and with the same Jacobian. */
static void copy_jacobian(Row *r, const Row *from)
{
    r->count = from->count;
    for (int i = 0; i < from->count; i++) {
        r->body[i] = from->body[i];
        r->lin[i] = from->lin[i];
        r->ang[i] = from->ang[i];
    }
}

static Row *add_like(RowList *list, const Row *like, RowKind kind, int slot)
{
    Row *r = add_row(list, kind, slot);
    copy_jacobian(r, like);
    r->drift = like->drift;
    r->angular = like->angular;
    return r;
}

/* ---- translation ------------------------------------------------------------ */

/* m/s and, without accelerations, m/s^2, of a joint's anchor in its body */
static vec3 anchor_velocity(const JointEnd *e) { return vec3_add(e->v, vec3_cross(e->w, e->r)); }
static vec3 anchor_turning(const JointEnd *e) { return vec3_cross(e->w, vec3_cross(e->w, e->r)); }

/* error = d . (pa - pb), d fixed in b:
 *   rate = d . (va + wa x ra) - d . (vb + wb x rb) + (wb x d) . (pa - pb)
 *        = d . va + wa . (ra x d) - d . vb - wb . ((pa - xb) x d)
 * Both forces act in the one line through pa: no torque is left over.
 *
 * With P = pa - xb, dP/dt = va + wa x ra - vb:  rate = d . s, s = dP/dt - wb x P the velocity of pa as seen from b, and
 *   drift = (wb x d) . s + d . (wa x (wa x ra) - wb x dP/dt)
 *         = d . (wa x (wa x ra) - wb x (s + dP/dt)) */
typedef struct Translation { vec3 arm, between, turning; } Translation;        /* what does not depend on d: P, pa - pb, the drift's vector */

static Translation translation_of(const JointView *j)
{
    vec3 arm = vec3_sub(j->a.p, j->b.x), moves = vec3_sub(anchor_velocity(&j->a), j->b.v), seen = vec3_sub(moves, vec3_cross(j->b.w, arm));
    return (Translation){arm, vec3_sub(j->a.p, j->b.p), vec3_sub(anchor_turning(&j->a), vec3_cross(j->b.w, vec3_add(seen, moves)))};
}

static inline Row *add_translation(RowList *list, const JointView *j, RowKind kind, const Translation *t, const vec3 *d, int slot)
{
    Row *r = add_pair(list, j, kind, slot);
    r->lin[0] = *d;
    r->lin[1] = vec3_neg(*d);
    r->ang[0] = vec3_cross(j->a.r, *d);
    r->ang[1] = vec3_cross(*d, t->arm);
    r->error = vec3_dot(*d, t->between);
    r->drift = vec3_dot(*d, t->turning);
    return r;
}

Row *rows_translation(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot)
{
    Translation t = translation_of(j);
    return add_translation(list, j, kind, &t, &d, slot);
}

Row *rows_along(RowList *list, const JointView *j, vec3 d, int slot) { return rows_translation(list, j, ROW_HARD, d, slot); }

void rows_point(RowList *list, const JointView *j, int slot)
{
    Translation t = translation_of(j);
    add_translation(list, j, ROW_HARD, &t, &j->b.axis, slot);
    add_translation(list, j, ROW_HARD, &t, &j->b.u, slot + 1);
    add_translation(list, j, ROW_HARD, &t, &j->b.n, slot + 2);
}

/* length = |pa - pb|, d = (pa - pb) / length:  rate = d . (d/dt pa - d/dt pb); the change of d is normal to d. With
 * u = d/dt pa - d/dt pb, dd/dt = (u - (d . u) d) / length, so
 *   drift = |u - (d . u) d|^2 / length + d . (wa x (wa x ra) - wb x (wb x rb)) */
Row *rows_length(RowList *list, const JointView *j, RowKind kind, real *length, int slot)
{
    vec3 between = vec3_sub(j->a.p, j->b.p);
    *length = vec3_length(between);
    if (!(*length > SHORTEST))
        return NULL;
    vec3 d = vec3_scale(1 / *length, between);
    Row *r = add_pair(list, j, kind, slot);
    r->lin[0] = d;
    r->lin[1] = vec3_neg(d);
    r->ang[0] = vec3_cross(j->a.r, d);
    r->ang[1] = vec3_neg(vec3_cross(j->b.r, d));
    vec3 moves = vec3_sub(anchor_velocity(&j->a), anchor_velocity(&j->b));
    vec3 across = vec3_mad(moves, -vec3_dot(d, moves), d);
    r->drift = vec3_length2(across) / *length + vec3_dot(d, vec3_sub(anchor_turning(&j->a), anchor_turning(&j->b)));
    return r;
}

real joint_length(const JointView *j) { return vec3_distance(j->a.p, j->b.p); }

real joint_length_rate(const JointView *j)
{
    Row r;
    RowList one = {&r, 0, 1};
    real length;
    return rows_length(&one, j, ROW_SOFT, &length, 0) ? joint_rate(j, &r) : 0;
}

/* ---- rotation ----------------------------------------------------------------- */

static inline Row *add_spin(RowList *list, const JointView *j, RowKind kind, const vec3 *d, int slot)
{
    Row *r = add_pair(list, j, kind, slot);
    r->angular = true;
    r->lin[0] = r->lin[1] = vec3_zero();
    r->ang[0] = *d;
    r->ang[1] = vec3_neg(*d);
    return r;
}

Row *rows_spin(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot) { return add_spin(list, j, kind, &d, slot); }

/* rate = d . (wa - wb), and the spins are constant:  drift = dd/dt . (wa - wb) */
void row_turns(Row *r, const JointView *j, vec3 turn) { r->drift = vec3_dot(turn, vec3_sub(j->a.w, j->b.w)); }

/* error = y . x with x fixed in a and y in b:  rate = (wa - wb) . (x x y);  d(x x y)/dt = (wa x x) x y + x x (wb x y) */
static void add_normal(RowList *list, const JointView *j, const vec3 *x, const vec3 *y, int slot)
{
    vec3 d = vec3_cross(*x, *y), turn = vec3_add(vec3_cross(vec3_cross(j->a.w, *x), *y), vec3_cross(*x, vec3_cross(j->b.w, *y)));
    Row *r = add_spin(list, j, ROW_HARD, &d, slot);
    r->error = vec3_dot(*x, *y);
    r->drift = vec3_dot(turn, vec3_sub(j->a.w, j->b.w));
}

void rows_parallel(RowList *list, const JointView *j, int slot)
{
    add_normal(list, j, &j->a.axis, &j->b.u, slot);
    add_normal(list, j, &j->a.axis, &j->b.n, slot + 1);
}

void rows_aligned(RowList *list, const JointView *j, int slot)
{
    rows_parallel(list, j, slot);
    add_normal(list, j, &j->a.u, &j->b.n, slot + 2);
}

/* Twist of a against b. The shortest rotation T that takes ea to eb maps ua to
 *   T ua = ua - (ua . eb) / (1 + ea . eb) (ea + eb),
 * and the twist is the angle of T ua in the plane of b. Written out with the entries of the rotation from b to a,
 *   (1 + ea . eb) (cos, sin) = (ub . ua + nb . na, nb . ua - ub . na).
 * Differentiated with de/dt = w x e this turns at (ea + eb) . (wa - wb) / (1 + ea . eb): with parallel axes the plain spin about
 * the axis. Checked against differences in tests/unit/test_rows.c. */
real joint_angle(const JointView *j, real *memory)
{
    const JointEnd *a = &j->a, *b = &j->b;
    real s = vec3_dot(b->n, a->u) - vec3_dot(b->u, a->n), c = vec3_dot(b->u, a->u) + vec3_dot(b->n, a->n);
    real now = atan2(s, c);
    real more = now - *memory;
    *memory += fabs(more) < DIG_PI ? more : remainder(more, 2 * DIG_PI);
    return *memory;
}

#define OPPOSITE 1e-9           /* 1 + ea . eb of axes so nearly opposite that the twist has no meaning */

vec3 joint_twist(const JointView *j)
{
    real c = 1 + vec3_dot(j->a.axis, j->b.axis);
    if (!(c > OPPOSITE))
        return j->b.axis;
    return vec3_scale(1 / c, vec3_add(j->a.axis, j->b.axis));
}

/* d = (ea + eb) / c, c = 1 + ea . eb:  dd/dt = (wa x ea + wb x eb - dc/dt d) / c,
 *   dc/dt = (wa x ea) . eb + ea . (wb x eb)
 * Where the axes are opposite d = eb stands for it, which is fixed in b. */
static vec3 twist_turn(const JointView *j, vec3 d)
{
    vec3 ea = j->a.axis, eb = j->b.axis, a = vec3_cross(j->a.w, ea), b = vec3_cross(j->b.w, eb);
    real c = 1 + vec3_dot(ea, eb);
    if (!(c > OPPOSITE))
        return b;
    return vec3_scale(1 / c, vec3_mad(vec3_add(a, b), -(vec3_dot(a, eb) + vec3_dot(ea, b)), d));
}

static void turn_end(JointEnd *e, int turn)
{
    const vec3 d[3] = {e->axis, e->u, e->n};
    e->axis = d[turn];
    e->u = d[(turn + 1) % 3];
    e->n = d[(turn + 2) % 3];
}

JointView joint_turned(const JointView *j, int turn)
{
    JointView v = *j;
    turn_end(&v.a, turn);
    turn_end(&v.b, turn);
    return v;
}

Row *rows_twist(RowList *list, const JointView *j, RowKind kind, int slot)
{
    vec3 d = joint_twist(j);
    Row *r = rows_spin(list, j, kind, d, slot);
    row_turns(r, j, twist_turn(j, d));
    return r;
}

real joint_rate(const JointView *j, const Row *r)
{
    return vec3_dot(r->lin[0], j->a.v) + vec3_dot(r->ang[0], j->a.w) + vec3_dot(r->lin[1], j->b.v) + vec3_dot(r->ang[1], j->b.w);
}

real joint_share(const JointView *j, vec3 force, vec3 couple)
{
    if (j->type->share)
        return j->type->share(j, force, couple);
    return j->breaks_at > 0 ? vec3_length(force) / j->breaks_at : 0;
}

/* ---- limits, motors, springs, friction ------------------------------------------ */

/* lo: error = x - lo, rate = dx/dt.  hi: error = hi - x, rate = -dx/dt, and so its drift. Either impulse >= 0 drives away
 * from its stop. */
void rows_limits(RowList *list, const Row *like, real coordinate, real lo, real hi, int slot)
{
    if (isfinite(lo))
        add_like(list, like, ROW_LIMIT, slot)->error = coordinate - lo;
    if (!isfinite(hi))
        return;
    Row *r = add_like(list, like, ROW_LIMIT, slot + 1);
    r->error = hi - coordinate;
    r->drift = -like->drift;
    for (int i = 0; i < r->count; i++) {
        r->lin[i] = vec3_neg(r->lin[i]);
        r->ang[i] = vec3_neg(r->ang[i]);
    }
}

static void add_motor(RowList *list, const Row *like, const DriveMotor *m, real room, int slot)
{
    if (isnan(m->speed) || !(m->most > 0))
        return;
    Row *r = add_like(list, like, ROW_MOTOR, slot);
    r->error = room;
    r->rate = m->speed;
    r->hi = m->most;
}

void rows_motor(RowList *list, const Row *like, const DriveMotor *m, int slot) { add_motor(list, like, m, INFINITY, slot); }

void rows_spring(RowList *list, const Row *like, real x, const DriveSpring *s, int slot)
{
    if (!(s->stiffness > 0) && !(s->damping > 0))
        return;
    Row *r = add_like(list, like, ROW_SOFT, slot);
    r->error = x - s->rest;
    r->stiffness = s->stiffness;
    r->damping = s->damping;
}

void rows_friction(RowList *list, const Row *like, real friction, int slot)
{
    if (friction > 0)
        add_like(list, like, ROW_DRY, slot)->hi = friction;
}

bool drive_acts(const Drive *d)
{
    return isfinite(d->limits[0]) || isfinite(d->limits[1]) || (!isnan(d->motor.speed) && d->motor.most > 0) || d->spring.stiffness > 0
        || d->spring.damping > 0 || d->friction > 0;
}

/* m or rad  From x to the stop that the motor drives at. */
static real room_ahead(const Drive *d, real x)
{
    real room = d->motor.speed > 0 ? d->limits[1] - x : d->motor.speed < 0 ? x - d->limits[0] : INFINITY;
    return isnan(room) ? INFINITY : room;
}

void rows_drive(RowList *list, const Row *like, real x, const Drive *d, int slot)
{
    rows_limits(list, like, x, d->limits[0], d->limits[1], slot + DRIVE_LO);
    add_motor(list, like, &d->motor, room_ahead(d, x), slot + DRIVE_MOTOR);
    rows_spring(list, like, x, &d->spring, slot + DRIVE_SPRING);
    rows_friction(list, like, d->friction, slot + DRIVE_FRICTION);
}

real spring_energy(const DriveSpring *s, real x)
{
    real off = x - s->rest;
    return s->stiffness > 0 ? 0.5 * s->stiffness * off * off : 0;
}

bool at_limits(real x, real lo, real hi) { return x <= lo + LIMIT_TOLERANCE || x >= hi - LIMIT_TOLERANCE; }

/* ---- couplings --------------------------------------------------------------------- */

/* r += k times the row of one joint, its drift too, which is linear in the Jacobian. A body that both joints share is one body
 * of the row, so that its effective mass is right; the world has no part. */
static void mix(Row *r, real k, const Row *add)
{
    r->drift += k * add->drift;
    for (int i = 0; i < add->count; i++) {
        if (add->body[i] < 0)
            continue;
        int at = 0;
        while (at < r->count && r->body[at] != add->body[i])
            at++;
        if (at == r->count) {
            r->count++;
            r->body[at] = add->body[i];
        }
        r->lin[at] = vec3_mad(r->lin[at], k, add->lin[i]);
        r->ang[at] = vec3_mad(r->ang[at], k, add->ang[i]);
    }
}

Row *rows_coupled(RowList *list, const JointView *j, real k0, real k1, int slot)
{
    Row pair[2];
    RowList both = {pair, 0, 2};
    real k[2] = {k0, k1}, sum = 0;
    for (int i = 0; i < 2; i++) {
        const JointView *o = j->other[i];
        if (!o || !o->type->coordinate_row || !o->type->coordinate_row(&both, o, ROW_HARD, 0))
            return NULL;
        sum += k[i] * o->type->coordinate(o);
    }
    if (j->memory[1] != k0 || j->memory[2] != k1) {
        j->memory[0] = sum;
        j->memory[1] = k0;
        j->memory[2] = k1;
    }
    Row *r = rows_add(list, ROW_HARD, slot);
    mix(r, k0, &pair[0]);
    mix(r, k1, &pair[1]);
    r->error = sum - j->memory[0];
    return r;
}
