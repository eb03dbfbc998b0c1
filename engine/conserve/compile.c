/* conserve/compile.c - which formula each row of a joint is, found from the row itself. */
#include "base/forest.h"
#include "conserve/system.h"

typedef struct Found { Part part[TIE_ROWS]; int parts, rows; bool hard, coupled; const char *why; } Found;

static bool same(vec3 a, vec3 b) { return vec3_equal(a, b); }

/* The directions of one end in world axes, and in the body's. */
static vec3 axis_of(const JointEnd *e, int i) { return i == 0 ? e->axis : i == 1 ? e->u : e->n; }

static vec3 axis_in(quat frame, int i)
{
    return quat_rotate(frame, (vec3){i == 0, i == 1, i == 2});
}

/* Three hard rows on the anchors along the three axes of b, from row i on. */
static bool is_point(const JointView *v, const Row *rows, int i, int count)
{
    if (i + 3 > count)
        return false;
    for (int k = 0; k < 3; k++) {
        const Row *r = &rows[i + k];
        if (r->kind != ROW_HARD || r->angular || r->slot != rows[i].slot + k || !same(r->lin[0], axis_of(&v->b, k)))
            return false;
    }
    return true;
}

static bool find_line(const JointView *v, quat fb, const Row *r, Part *part)
{
    for (int k = 0; k < 3; k++)
        if (same(r->lin[0], axis_of(&v->b, k))) {
            part->kind = PART_LINE;
            part->in_b = axis_in(fb, k);
            part->offset = vec3_dot(r->lin[0], vec3_sub(v->a.p, v->b.p)) - r->error;
            return true;
        }
    return false;
}

static bool find_normal(const JointView *v, quat fa, quat fb, const Row *r, Part *part)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (same(r->ang[0], vec3_cross(axis_of(&v->a, i), axis_of(&v->b, k)))) {
                part->kind = PART_NORMAL;
                part->in_a = axis_in(fa, i);
                part->in_b = axis_in(fb, k);
                return true;
            }
    return false;
}

static bool find_twist(const JointView *v, const Row *r, Part *part)
{
    for (int turn = 0; turn < 3; turn++) {
        JointView t = joint_turned(v, turn);
        real angle = 0;
        if (!same(r->ang[0], joint_twist(&t)))
            continue;
        part->kind = PART_TWIST;
        part->turn = turn;
        part->offset = joint_angle(&t, &angle) - r->error;
        part->start = r->error;             /* wound up by whole turns, too */
        return true;
    }
    return false;
}

static bool find_part(const JointView *v, quat fa, quat fb, const Row *rows, int count, int i, Part *part)
{
    const Row *r = &rows[i];
    *part = (Part){.rows = 1, .slot = r->slot, .soft = r->kind == ROW_SOFT, .stiffness = r->stiffness, .damping = r->damping};
    if (is_point(v, rows, i, count)) {
        part->kind = PART_POINT;
        part->rows = 3;
        return true;
    }
    if (!r->angular && v->type->two_anchors && count == 1) {
        part->kind = PART_LENGTH;
        part->offset = vec3_distance(v->a.p, v->b.p) - r->error;
        return vec3_distance(v->a.p, v->b.p) > 1e-9;
    }
    if (!r->angular)
        return find_line(v, fb, r, part);
    if (r->kind == ROW_HARD)
        return find_normal(v, fa, fb, r, part);
    return find_twist(v, r, part);
}

/* May the stop be met in this step? Speeds may double, gravity acts. */
static bool near_stop(const Group *g, const Row *r)
{
    real rate = 0, reach = 0;
    for (int i = 0; i < r->count; i++)
        if (r->body[i] >= 0) {
            const Vel *v = &g->vel[r->body[i]];
            rate += vec3_dot(r->lin[i], v->v) + vec3_dot(r->ang[i], v->w);
            reach += vec3_length(r->lin[i]);
        }
    real dt = g->world->def.step;
    return r->error < 2 * fabs(rate) * dt + (reach + r->angular) * g->fall * dt * dt + 1e-6;
}

static void take_apart(const Group *g, const GroupJoint *j, const JointView *v, Found *f)
{
    Row rows[JOINT_SLOTS];
    RowList list = {rows, 0, JOINT_SLOTS};
    *f = (Found){.why = NULL};
    if (v->type->couples) {
        f->why = "conserve: a gear or rack";
        return;
    }
    v->type->rows(v, &list);
    int count = 0;
    for (int i = 0; i < list.count; i++) {
        const Row *r = &rows[i];
        if (r->kind == ROW_MOTOR || r->kind == ROW_DRY)
            f->why = "conserve: a motor or friction in a joint";
        else if (r->kind == ROW_LIMIT && near_stop(g, r))
            f->why = "conserve: a joint near its stop";
        else if (r->kind != ROW_LIMIT)
            rows[count++] = *r;
    }
    for (int i = 0; i < count && !f->why;) {
        Part *part = &f->part[f->parts];
        if (!find_part(v, j->fa, j->fb, rows, count, i, part) || f->rows + part->rows > TIE_ROWS) {
            f->why = "conserve: a joint without a formula";
            return;
        }
        i += part->rows;
        if (part->soft && !(g->world->def.step * part->stiffness + part->damping > 1e-200))
            continue;           /* neither stiff nor damped */
        part->at = f->rows;
        f->rows += part->rows;
        f->hard = f->hard || !part->soft;
        f->coupled = f->coupled || (part->kind != PART_POINT && part->kind != PART_TWIST);
        f->parts++;
    }
}

static JointView view_of(const Group *g, const GroupJoint *j, real *memory)
{
    JointView v = j->view;
    const Pos still = {vec3_zero(), quat_identity()};
    const Pos *a = j->a < 0 ? &still : &g->pos[j->a], *b = j->b < 0 ? &still : &g->pos[j->b];
    joint_end_set(&v.a, a->x, a->q, j->a < 0 ? vec3_zero() : g->vel[j->a].v, j->a < 0 ? vec3_zero() : g->vel[j->a].w, j->ra, j->fa);
    joint_end_set(&v.b, b->x, b->q, j->b < 0 ? vec3_zero() : g->vel[j->b].v, j->b < 0 ? vec3_zero() : g->vel[j->b].w, j->rb, j->fb);
    v.a.body = j->a;
    v.b.body = j->b;
    v.memory = memory;
    return v;
}

bool parts_understood(const Group *g)
{
    for (int i = 0; i < g->joint_count; i++) {
        real memory[JOINT_MEMORY];
        Found f;
        memcpy(memory, g->joints[i].memory, sizeof memory);
        JointView v = view_of(g, &g->joints[i], memory);
        take_apart(g, &g->joints[i], &v, &f);
        if (f.why)
            return false;
    }
    return true;
}

static bool moves(const Group *g, int body) { return body >= 0 && g->member[body].moves; }

/* The forces of the last step are the first guess; a point's are kept along the axes of b. */
static void warm(System *s, const Tie *t, const JointView *v)
{
    const real *force = s->g->joints[t->joint].force;
    for (int k = t->part; k < t->part + t->parts; k++) {
        const Part *part = &s->part[k];
        real *p = s->p_last + t->row + part->at;
        if (part->kind != PART_POINT) {
            p[0] = force[part->slot];
            continue;
        }
        vec3 f = vec3_zero();
        for (int i = 0; i < 3; i++)
            f = vec3_mad(f, force[part->slot + i], axis_of(&v->b, i));
        p[0] = f.x;
        p[1] = f.y;
        p[2] = f.z;
    }
}

/* Does a ring of hard rows share its load in many ways? What does not move is one piece. */
static dig_status find_rings(System *s)
{
    int *parent = arena_alloc(s->g->arena, (size_t)s->piece_count * sizeof *parent);
    if (!parent)
        return DIG_E_MEMORY;
    for (int i = 0; i < s->piece_count; i++)
        parent[i] = s->piece[i].moves ? i : s->piece_count - 1;
    s->rings = false;
    for (int i = 0; i < s->tie_count; i++) {
        const Tie *t = &s->tie[i];
        if (!t->hard)
            continue;
        s->rings = s->rings || forest_root(parent, t->a) == forest_root(parent, t->b);
        forest_unite(parent, t->a, t->b);
    }
    return DIG_OK;
}

dig_status parts_compile(System *s)
{
    Group *g = s->g;
    s->tie = arena_zero(g->arena, (size_t)(g->joint_count + 1) * sizeof *s->tie);
    s->part = arena_zero(g->arena, (size_t)(g->joint_count * TIE_ROWS + 1) * sizeof *s->part);
    s->p = arena_zero(g->arena, (size_t)(g->joint_count * TIE_ROWS + 1) * sizeof *s->p);
    s->p_last = arena_zero(g->arena, (size_t)(g->joint_count * TIE_ROWS + 1) * sizeof *s->p_last);
    if (!s->tie || !s->part || !s->p || !s->p_last)
        return DIG_E_MEMORY;
    for (int i = 0; i < g->joint_count; i++) {
        GroupJoint *j = &g->joints[i];
        Found f;
        if (!moves(g, j->a) && !moves(g, j->b))
            continue;
        JointView v = view_of(g, j, j->memory);
        take_apart(g, j, &v, &f);
        if (f.rows == 0)
            continue;
        Tie *t = &s->tie[s->tie_count++];
        *t = (Tie){.joint = i, .a = j->a < 0 ? g->body_count : j->a, .b = j->b < 0 ? g->body_count : j->b, .part = s->part_count,
                   .parts = f.parts, .rows = f.rows, .row = s->row_count, .hard = f.hard, .coupled = f.coupled,
                   .ra = j->ra, .rb = j->rb, .fa = j->fa, .fb = j->fb};
        memcpy(s->part + s->part_count, f.part, (size_t)f.parts * sizeof *s->part);
        s->part_count += f.parts;
        s->row_count += f.rows;
        warm(s, t, &v);
    }
    return find_rings(s);
}
