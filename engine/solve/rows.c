/* solve/rows.c - the parts that joints are built from: rows with their Jacobians.
 *
 * Notation: pa, pb anchors; e, u, n the joint frame (axis, u, n); indices a and b for the body it is fixed in. For a vector c
 * fixed in body b, dc/dt = wb x c; x . (w x y) = w . (y x x). Each row's comment derives its rate from its error.
 */
#include "solve/joint_type.h"

/* m  shorter than this, a length has no direction */
#define SHORTEST 1e-12
#define LIMIT_TOLERANCE 1e-4    /* m or rad */

Row *rows_add(RowList *list, RowKind kind, int slot)
{
    DIG_ASSERT(list->count < list->capacity && slot >= 0 && slot < JOINT_SLOTS);
    Row *r = &list->rows[list->count++];
    memset(r, 0, sizeof *r);
    r->kind = kind;
    r->slot = slot;
    r->hi = INFINITY;
    return r;
}

static Row *add_pair(RowList *list, const JointView *j, RowKind kind, int slot)
{
    Row *r = rows_add(list, kind, slot);
    r->count = 2;
    r->body[0] = j->a.body;
    r->body[1] = j->b.body;
    return r;
}

static Row *add_like(RowList *list, const Row *like, RowKind kind, int slot)
{
    Row *r = rows_add(list, kind, slot);
    *r = *like;
    r->kind = kind;
    r->slot = slot;
    r->error = r->rate = r->stiffness = r->damping = 0;
    r->hi = INFINITY;
    return r;
}

/* ---- translation ------------------------------------------------------------ */

/* error = d . (pa - pb), d fixed in b:
 *   rate = d . (va + wa x ra) - d . (vb + wb x rb) + (wb x d) . (pa - pb)
 *        = d . va + wa . (ra x d) - d . vb - wb . ((pa - xb) x d)
 * Both forces act in the one line through pa: no torque is left over. */
Row *rows_translation(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot)
{
    Row *r = add_pair(list, j, kind, slot);
    r->lin[0] = d;
    r->lin[1] = vec3_neg(d);
    r->ang[0] = vec3_cross(j->a.r, d);
    r->ang[1] = vec3_neg(vec3_cross(vec3_sub(j->a.p, j->b.x), d));
    r->error = vec3_dot(d, vec3_sub(j->a.p, j->b.p));
    return r;
}

Row *rows_along(RowList *list, const JointView *j, vec3 d, int slot) { return rows_translation(list, j, ROW_HARD, d, slot); }

void rows_point(RowList *list, const JointView *j, int slot)
{
    rows_along(list, j, j->b.axis, slot);
    rows_along(list, j, j->b.u, slot + 1);
    rows_along(list, j, j->b.n, slot + 2);
}

/* length = |pa - pb|, d = (pa - pb) / length:  rate = d . (d/dt pa - d/dt pb); the change of d is normal to d. */
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
    return r;
}

/* ---- rotation ----------------------------------------------------------------- */

Row *rows_spin(RowList *list, const JointView *j, RowKind kind, vec3 d, int slot)
{
    Row *r = add_pair(list, j, kind, slot);
    r->angular = true;
    r->ang[0] = d;
    r->ang[1] = vec3_neg(d);
    return r;
}

/* error = y . x with x fixed in a and y in b:  rate = (wa - wb) . (x x y) */
static void add_normal(RowList *list, const JointView *j, vec3 x, vec3 y, int slot)
{
    Row *r = rows_spin(list, j, ROW_HARD, vec3_cross(x, y), slot);
    r->error = vec3_dot(x, y);
}

void rows_parallel(RowList *list, const JointView *j, int slot)
{
    add_normal(list, j, j->a.axis, j->b.u, slot);
    add_normal(list, j, j->a.axis, j->b.n, slot + 1);
}

void rows_aligned(RowList *list, const JointView *j, int slot)
{
    rows_parallel(list, j, slot);
    add_normal(list, j, j->a.u, j->b.n, slot + 2);
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
    *memory += remainder(now - *memory, 2 * DIG_PI);
    return *memory;
}

vec3 joint_twist(const JointView *j)
{
    real c = 1 + vec3_dot(j->a.axis, j->b.axis);
    if (!(c > 1e-9))            /* opposite axes: the twist has no meaning */
        return j->b.axis;
    return vec3_scale(1 / c, vec3_add(j->a.axis, j->b.axis));
}

Row *rows_twist(RowList *list, const JointView *j, RowKind kind, int slot)
{
    return rows_spin(list, j, kind, joint_twist(j), slot);
}

real joint_rate(const JointView *j, const Row *r)
{
    return vec3_dot(r->lin[0], j->a.v) + vec3_dot(r->ang[0], j->a.w) + vec3_dot(r->lin[1], j->b.v) + vec3_dot(r->ang[1], j->b.w);
}

/* ---- limits, motors, springs, friction ------------------------------------------ */

/* lo: error = x - lo, rate = dx/dt.  hi: error = hi - x, rate = -dx/dt.  Either impulse >= 0 drives away from its stop. */
void rows_limits(RowList *list, const Row *like, real coordinate, real lo, real hi, int slot)
{
    if (isfinite(lo))
        add_like(list, like, ROW_LIMIT, slot)->error = coordinate - lo;
    if (!isfinite(hi))
        return;
    Row *r = add_like(list, like, ROW_LIMIT, slot + 1);
    r->error = hi - coordinate;
    for (int i = 0; i < r->count; i++) {
        r->lin[i] = vec3_neg(r->lin[i]);
        r->ang[i] = vec3_neg(r->ang[i]);
    }
}

void rows_motor(RowList *list, const Row *like, const DriveMotor *m, int slot)
{
    if (isnan(m->speed) || !(m->most > 0))
        return;
    Row *r = add_like(list, like, ROW_MOTOR, slot);
    r->rate = m->speed;
    r->hi = m->most;
}

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

void rows_drive(RowList *list, const Row *like, real x, const Drive *d, int slot)
{
    rows_limits(list, like, x, d->limits[0], d->limits[1], slot);
    rows_motor(list, like, &d->motor, slot + 2);
    rows_spring(list, like, x, &d->spring, slot + 3);
    rows_friction(list, like, d->friction, slot + 4);
}

real spring_energy(const DriveSpring *s, real x)
{
    real off = x - s->rest;
    return s->stiffness > 0 ? 0.5 * s->stiffness * off * off : 0;
}

bool at_limits(real x, real lo, real hi) { return x <= lo + LIMIT_TOLERANCE || x >= hi - LIMIT_TOLERANCE; }

/* ---- couplings --------------------------------------------------------------------- */

/* r += k times the row of one joint. A body that both joints share is one body of the row, so that its effective mass is right;
 * the world has no part. */
static void mix(Row *r, real k, const Row *add)
{
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
