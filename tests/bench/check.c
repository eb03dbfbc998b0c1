/* tests/bench/check.c - how wrong the poses are that an engine ended with: overlaps, joints, heights. The same for all engines.
 *
 * Every solid is a small polytope with a radius around it. Two of them overlap by the largest separation over all axes that
 * can carry it (face normals, edge x edge, and for round ones point to point and point to edge), which is exact.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "scene.h"

typedef struct {
    int    points, edges, normals;
    double point[HULL_POINTS][3], normal[HULL_FACES][3];
    int    edge[HULL_EDGES][2];
    double radius;
} Solid;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void minus(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* v turned by the unit quaternion q = (x, y, z, w). */
static void turned(const double q[4], const double v[3], double out[3])
{
    double t[3], u[3];
    cross(q, v, t);
    for (int i = 0; i < 3; i++)
        t[i] *= 2;
    cross(q, t, u);
    for (int i = 0; i < 3; i++)
        out[i] = v[i] + q[3] * t[i] + u[i];
}

static void placed(const BenchPose *pose, const double local[3], double out[3])
{
    turned(pose->turn, local, out);
    for (int i = 0; i < 3; i++)
        out[i] += pose->at[i];
}

static double reach(const BenchBody *b)         /* m, of its bounding sphere */
{
    switch (b->kind) {
    case BENCH_BOX:     return sqrt(dot(b->size, b->size));
    case BENCH_CAPSULE: return b->size[0] + b->size[1];
    default:            return b->size[0];
    }
}

static void make_box(Solid *s, const double half[3], const BenchPose *pose)
{
    s->points = 8;
    for (int i = 0; i < 8; i++) {
        placed(pose, (double[3]){i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]}, s->point[i]);
        for (int k = 0; k < 3; k++)
            if (!(i & 1 << k)) {
                s->edge[s->edges][0] = i;
                s->edge[s->edges++][1] = i | 1 << k;
            }
    }
    for (int k = 0; k < 3; k++)
        turned(pose->turn, (double[3]){k == 0, k == 1, k == 2}, s->normal[s->normals++]);
}

static void make_solid(Solid *s, const BenchBody *b, const BenchPose *pose, const Icosahedron *ico)
{
    s->edges = s->normals = 0;
    s->radius = b->kind == BENCH_SPHERE || b->kind == BENCH_CAPSULE ? b->size[0] : 0;
    if (b->kind == BENCH_BOX) {
        make_box(s, b->size, pose);
        return;
    }
    if (b->kind == BENCH_SPHERE) {
        s->points = 1;
        memcpy(s->point[0], pose->at, sizeof pose->at);
    } else if (b->kind == BENCH_CAPSULE) {
        s->points = 2;
        s->edges = 1;
        s->edge[0][0] = 0;
        s->edge[0][1] = 1;
        placed(pose, (double[3]){0, b->size[1], 0}, s->point[0]);
        placed(pose, (double[3]){0, -b->size[1], 0}, s->point[1]);
    } else {
        s->points = HULL_POINTS;
        s->edges = HULL_EDGES;
        s->normals = HULL_FACES;
        memcpy(s->edge, ico->edge, sizeof s->edge);
        for (int i = 0; i < HULL_POINTS; i++) {
            double p[3] = {ico->point[i][0] * b->size[0], ico->point[i][1] * b->size[0], ico->point[i][2] * b->size[0]};
            placed(pose, p, s->point[i]);
        }
        for (int i = 0; i < HULL_FACES; i++)
            turned(pose->turn, ico->normal[i], s->normal[i]);
    }
}

static void extent(const Solid *s, const double n[3], double *low, double *high)
{
    *low = *high = dot(s->point[0], n);
    for (int i = 1; i < s->points; i++) {
        double d = dot(s->point[i], n);
        *low = fmin(*low, d);
        *high = fmax(*high, d);
    }
}

/* Raises *best to the separation along the axis, either way. */
static void try_axis(const Solid *a, const Solid *b, const double axis[3], double *best)
{
    double length = sqrt(dot(axis, axis));
    if (length < 1e-9)
        return;
    double n[3] = {axis[0] / length, axis[1] / length, axis[2] / length}, a0, a1, b0, b1;
    extent(a, n, &a0, &a1);
    extent(b, n, &b0, &b1);
    *best = fmax(*best, fmax(b0 - a1, a0 - b1) - a->radius - b->radius);
}

/* Axes from the points of a round solid to the points and edges of the other. */
static void try_round(const Solid *a, const Solid *b, double *best)
{
    for (int i = 0; i < a->points; i++) {
        double axis[3], along[3];
        for (int j = 0; j < b->points; j++) {
            minus(b->point[j], a->point[i], axis);
            try_axis(a, b, axis, best);
        }
        for (int j = 0; j < b->edges; j++) {
            const double *from = b->point[b->edge[j][0]];
            minus(b->point[b->edge[j][1]], from, along);
            minus(a->point[i], from, axis);
            double t = fmin(1, fmax(0, dot(axis, along) / dot(along, along)));
            for (int k = 0; k < 3; k++)
                axis[k] -= t * along[k];
            try_axis(a, b, axis, best);
        }
    }
}

/* Negative: they overlap by that much. Any positive value means that they do not. */
static double separation(const Solid *a, const Solid *b)
{
    double best = -1e30;
    for (int i = 0; i < a->normals && best <= 0; i++)
        try_axis(a, b, a->normal[i], &best);
    for (int i = 0; i < b->normals && best <= 0; i++)
        try_axis(a, b, b->normal[i], &best);
    for (int i = 0; i < a->edges && best <= 0; i++)
        for (int j = 0; j < b->edges && best <= 0; j++) {
            double u[3], v[3], axis[3];
            minus(a->point[a->edge[i][1]], a->point[a->edge[i][0]], u);
            minus(b->point[b->edge[j][1]], b->point[b->edge[j][0]], v);
            cross(u, v, axis);
            if (dot(axis, axis) > 1e-12 * dot(u, u) * dot(v, v))        /* parallel edges give no direction, only rounding */
                try_axis(a, b, axis, &best);
        }
    if (a->radius > 0 && best <= 0)
        try_round(a, b, &best);
    if (b->radius > 0 && best <= 0)
        try_round(b, a, &best);
    return best;
}

typedef struct { const BenchScene *scene; const BenchPose *pose; BenchFound *found; Icosahedron ico; double sum; } Check;

static void book(Check *c, double gap)
{
    if (gap >= 0)
        return;
    c->found->penetration_max = fmax(c->found->penetration_max, -gap);
    c->found->overlaps++;
    c->sum -= gap;
}

/* Planes of the scene. False: the body is lost, and there is nothing to measure. */
static bool check_planes(Check *c, int i)
{
    const BenchPose *pose = &c->pose[i];
    bool inside = dot(pose->at, pose->at) < 1e10 && fabs(dot(pose->turn, pose->turn) + pose->turn[3] * pose->turn[3] - 1) < 1e-3;
    Solid s;
    make_solid(&s, &c->scene->body[i], pose, &c->ico);
    for (int k = 0; k < c->scene->planes && inside; k++) {
        double low, high;
        extent(&s, c->scene->plane[k], &low, &high);
        low += c->scene->plane[k][3] - s.radius;
        inside = low > -1;
        if (inside)
            book(c, low);
    }
    c->found->lost += !inside;
    return inside;
}

static void check_pair(Check *c, int i, int j)
{
    const BenchScene *s = c->scene;
    const BenchBody *a = &s->body[i], *b = &s->body[j];
    double between[3], touch = reach(a) + reach(b);
    minus(c->pose[i].at, c->pose[j].at, between);
    if (dot(between, between) > touch * touch || (s->linked && abs(i - j) == 1))
        return;
    Solid p, q;
    make_solid(&p, a, &c->pose[i], &c->ico);
    make_solid(&q, b, &c->pose[j], &c->ico);
    book(c, separation(&p, &q));
}

typedef struct { int64_t cell; int body; } Place;

static int by_cell(const void *a, const void *b)
{
    const Place *p = a, *q = b;
    return p->cell != q->cell ? (p->cell > q->cell) - (p->cell < q->cell) : (p->body > q->body) - (p->body < q->body);
}

static int first_of(const Place *place, int count, int64_t cell)
{
    int low = 0, high = count;
    while (low < high) {
        int mid = (low + high) / 2;
        if (place[mid].cell < cell)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

enum { CELL_BIAS = 1 << 19, CELL_BITS = 20 };

static int64_t cell_of(const double at[3], double edge, int dx, int dy, int dz)
{
    int64_t x = (int64_t)floor(at[0] / edge) + CELL_BIAS + dx, y = (int64_t)floor(at[1] / edge) + CELL_BIAS + dy;
    return ((x << CELL_BITS | y) << CELL_BITS) + (int64_t)floor(at[2] / edge) + CELL_BIAS + dz;
}

/* All pairs with a moving body in it, by cells as wide as the largest of them. */
static void check_pairs(Check *c, const bool *usable)
{
    const BenchScene *s = c->scene;
    Place *place = malloc((size_t)s->bodies * sizeof *place);
    double edge = 0;
    int count = 0;
    if (!place)
        abort();
    for (int i = 0; i < s->bodies; i++)
        if (usable[i])
            edge = fmax(edge, 2 * reach(&s->body[i]));
    for (int i = 0; i < s->bodies; i++)
        if (usable[i])
            place[count++] = (Place){cell_of(c->pose[i].at, edge, 0, 0, 0), i};
    qsort(place, (size_t)count, sizeof *place, by_cell);
    for (int i = 0; i < s->bodies; i++) {
        if (!usable[i] || s->body[i].fixed)
            continue;
        for (int d = 0; d < 27; d++) {
            int64_t cell = cell_of(c->pose[i].at, edge, d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
            for (int k = first_of(place, count, cell); k < count && place[k].cell == cell; k++)
                if (s->body[place[k].body].fixed || place[k].body < i)      /* each pair once */
                    check_pair(c, i, place[k].body);
        }
    }
    free(place);
}

/* Where the joint's point is now, as body i carries it. */
static void carried(const Check *c, int i, const double at[3], double out[3])
{
    const BenchBody *b = &c->scene->body[i];
    double back[4] = {-b->turn[0], -b->turn[1], -b->turn[2], b->turn[3]}, arm[3], local[3];
    minus(at, b->at, arm);
    turned(back, arm, local);
    placed(&c->pose[i], local, out);
}

void bench_check(const BenchScene *scene, const BenchPose *pose, BenchFound *found)
{
    Check c = {.scene = scene, .pose = pose, .found = found};
    bool *usable = calloc((size_t)scene->bodies, sizeof *usable);
    if (!usable)
        abort();
    memset(found, 0, sizeof *found);
    bench_icosahedron(&c.ico);
    for (int i = 0; i < scene->bodies; i++)
        usable[i] = scene->body[i].fixed ? !scene->body[i].wall : check_planes(&c, i);
    check_pairs(&c, usable);
    found->penetration_mean = found->overlaps ? c.sum / found->overlaps : 0;
    for (int i = 0; i < scene->joints; i++) {
        double a[3], b[3], gap[3];
        carried(&c, scene->joint[i].a, scene->joint[i].at, a);
        carried(&c, scene->joint[i].b, scene->joint[i].at, b);
        minus(a, b, gap);
        found->joint_error = fmax(found->joint_error, sqrt(dot(gap, gap)));
    }
    for (int i = 0; i < scene->tops; i++)
        found->top_height += pose[scene->top[i]].at[1] / scene->tops;
    free(usable);
}
