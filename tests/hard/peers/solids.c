/* tests/hard/peers/solids.c - masses, hulls and overlaps of what a hard case describes; the same for every engine.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "../../bench/scene.h"
#include "peer.h"

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

static void turn_by(const double turn[4], double sense, const double v[3], double out[3])
{
    double t[3], u[3], q[3] = {sense * turn[1], sense * turn[2], sense * turn[3]};
    cross(q, v, t);
    for (int i = 0; i < 3; i++)
        t[i] *= 2;
    cross(q, t, u);
    for (int i = 0; i < 3; i++)
        out[i] = v[i] + turn[0] * t[i] + u[i];
}

void peer_turned(const double turn[4], const double v[3], double out[3]) { turn_by(turn, 1, v, out); }

void peer_turned_back(const double turn[4], const double v[3], double out[3]) { turn_by(turn, -1, v, out); }

double peer_reach(const PeerBody *b)
{
    double most = 0;
    switch (b->kind) {
    case PEER_SPHERE:   return b->size[0];
    case PEER_BOX:      return sqrt(dot(b->size, b->size));
    case PEER_CYLINDER: return hypot(b->size[0], b->size[1]);
    case PEER_HULL:
        for (int i = 0; i < b->hull->points; i++)
            most = fmax(most, sqrt(dot(b->hull->point[i], b->hull->point[i])));
        return most;
    default:            return 0;
    }
}

void peer_inertia(PeerBody *b)
{
    const double *s = b->size;
    double m = b->mass;
    for (int i = 0; i < 3; i++) {
        double p = s[(i + 1) % 3], q = s[(i + 2) % 3];
        if (b->kind == PEER_SPHERE)
            b->inertia[i] = 0.4 * m * s[0] * s[0];
        else if (b->kind == PEER_BOX)
            b->inertia[i] = m * (p * p + q * q) / 3;
        else if (b->kind == PEER_CYLINDER)
            b->inertia[i] = i == 1 ? m * s[0] * s[0] / 2 : m * (s[0] * s[0] / 4 + s[1] * s[1] / 3);
    }
}

/* ---- hulls of few points ---- */

static bool has_face(const PeerHull *h, const double normal[3], double offset)
{
    for (int i = 0; i < h->faces; i++)
        if (dot(h->face[i].normal, normal) > 1 - 1e-9 && fabs(h->face[i].offset - offset) < 1e-9)
            return true;
    return false;
}

/* The corners of the face in their order around it. */
static void order_corners(const PeerHull *h, PeerFace *f)
{
    double middle[3] = {0}, along[3], side[3], angle[PEER_CORNERS], arm[3];
    for (int i = 0; i < f->corners; i++)
        for (int k = 0; k < 3; k++)
            middle[k] += h->point[f->corner[i]][k] / f->corners;
    minus(h->point[f->corner[0]], middle, along);
    cross(f->normal, along, side);
    for (int i = 0; i < f->corners; i++) {
        minus(h->point[f->corner[i]], middle, arm);
        angle[i] = atan2(dot(arm, side), dot(arm, along));
    }
    for (int i = 1; i < f->corners; i++)
        for (int k = i; k > 0 && angle[k] < angle[k - 1]; k--) {
            double a = angle[k];
            int c = f->corner[k];
            angle[k] = angle[k - 1], angle[k - 1] = a;
            f->corner[k] = f->corner[k - 1], f->corner[k - 1] = c;
        }
}

/* Adds the plane through three points as a face when all points are on one side of it. */
static void try_face(PeerHull *h, int i, int j, int k)
{
    double u[3], v[3], n[3];
    minus(h->point[j], h->point[i], u);
    minus(h->point[k], h->point[i], v);
    cross(u, v, n);
    double length = sqrt(dot(n, n)), above = 0, below = 0, size = sqrt(dot(u, u) + dot(v, v));
    if (length < 1e-9 * size * size || h->faces == PEER_FACES)
        return;
    for (int c = 0; c < 3; c++)
        n[c] /= length;
    double offset = dot(n, h->point[i]);
    for (int p = 0; p < h->points; p++) {
        above = fmax(above, dot(n, h->point[p]) - offset);
        below = fmax(below, offset - dot(n, h->point[p]));
    }
    if (above > 1e-9 * size && below > 1e-9 * size)
        return;
    double sense = above > below ? -1 : 1;
    for (int c = 0; c < 3; c++)
        n[c] *= sense;
    offset *= sense;
    if (has_face(h, n, offset))
        return;
    PeerFace *f = &h->face[h->faces++];
    *f = (PeerFace){.normal = {n[0], n[1], n[2]}, .offset = offset};
    for (int p = 0; p < h->points; p++)
        if (fabs(dot(n, h->point[p]) - offset) < 1e-9 * size && f->corners < PEER_CORNERS)
            f->corner[f->corners++] = p;
    order_corners(h, f);
}

static void find_faces(PeerHull *h)
{
    h->faces = 0;
    for (int i = 0; i < h->points; i++)
        for (int j = i + 1; j < h->points; j++)
            for (int k = j + 1; k < h->points; k++)
                try_face(h, i, j, k);
}

/* Volume, and its first and second moments about the origin, from tetrahedra over the triangles of the faces. */
static double moments(const PeerHull *h, double first[3], double second[3][3])
{
    double volume = 0;
    memset(first, 0, 3 * sizeof *first);
    memset(second, 0, 9 * sizeof second[0][0]);
    for (int f = 0; f < h->faces; f++)
        for (int t = 2; t < h->face[f].corners; t++) {
            const int *corner = h->face[f].corner;
            const double *p[3] = {h->point[corner[0]], h->point[corner[t - 1]], h->point[corner[t]]};
            double n[3], sum[3];
            cross(p[1], p[2], n);
            double v = dot(p[0], n) / 6;
            volume += v;
            for (int i = 0; i < 3; i++) {
                sum[i] = p[0][i] + p[1][i] + p[2][i];
                first[i] += v * sum[i] / 4;
            }
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    second[i][j] += v / 20 * (sum[i] * sum[j] + p[0][i] * p[0][j] + p[1][i] * p[1][j] + p[2][i] * p[2][j]);
        }
    return volume;
}

/* Jacobi's rotations: the columns of `axes` become eigenvectors of the symmetric matrix, its diagonal their values. */
static void principal(double matrix[3][3], double axes[3][3])
{
    memset(axes, 0, 9 * sizeof axes[0][0]);
    for (int i = 0; i < 3; i++)
        axes[i][i] = 1;
    for (int sweep = 0; sweep < 60; sweep++) {
        int p = sweep % 3, q = (sweep + 1) % 3;
        if (fabs(matrix[p][q]) < 1e-300)
            continue;
        double angle = 0.5 * atan2(2 * matrix[p][q], matrix[q][q] - matrix[p][p]), c = cos(angle), s = sin(angle);
        for (int k = 0; k < 3; k++) {
            double a = matrix[k][p], b = matrix[k][q];
            matrix[k][p] = c * a - s * b, matrix[k][q] = s * a + c * b;
            a = axes[k][p], b = axes[k][q];
            axes[k][p] = c * a - s * b, axes[k][q] = s * a + c * b;
        }
        for (int k = 0; k < 3; k++) {
            double a = matrix[p][k], b = matrix[q][k];
            matrix[p][k] = c * a - s * b, matrix[q][k] = s * a + c * b;
        }
    }
}

/* The quaternion of a rotation matrix, by its largest component. */
static void quaternion(double m[3][3], double out[4])
{
    double square[4] = {1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2],
                        1 - m[0][0] - m[1][1] + m[2][2]};
    double off[4][4] = {{0, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]},
                        {0, 0, m[0][1] + m[1][0], m[0][2] + m[2][0]}, {0, 0, 0, m[1][2] + m[2][1]}};
    int most = 0;
    for (int i = 1; i < 4; i++)
        most = square[i] > square[most] ? i : most;
    for (int i = 0; i < 4; i++)
        out[i] = (i == most ? square[i] : i < most ? off[i][most] : off[most][i]) / (2 * sqrt(square[most]));
}

bool peer_hull_make(PeerHull *h, const double *points, int count, double density, PeerBody *body)
{
    double first[3], second[3][3], axes[3][3], turn[4], p[3];
    if (count > PEER_POINTS)
        return false;
    h->points = count;
    memcpy(h->point, points, (size_t)(3 * count) * sizeof *points);
    find_faces(h);
    double volume = moments(h, first, second);
    if (!(volume > 0))
        return false;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            h->point[i][k] -= first[k] / volume;
    find_faces(h);
    moments(h, p, second);
    principal(second, axes);
    double side[3] = {axes[0][0], axes[1][0], axes[2][0]}, up[3] = {axes[0][1], axes[1][1], axes[2][1]}, third[3];
    cross(side, up, third);                                 /* right-handed */
    for (int k = 0; k < 3; k++)
        axes[k][2] = third[k];
    quaternion(axes, turn);
    for (int i = 0; i < count; i++) {
        peer_turned_back(turn, h->point[i], p);
        memcpy(h->point[i], p, sizeof p);
    }
    find_faces(h);
    body->mass = density * volume;
    for (int i = 0; i < 3; i++)
        body->inertia[i] = density * (second[(i + 1) % 3][(i + 1) % 3] + second[(i + 2) % 3][(i + 2) % 3]);
    double centre[3] = {first[0] / volume, first[1] / volume, first[2] / volume}, arm[3];
    peer_turned(body->start.turn, centre, arm);
    for (int k = 0; k < 3; k++)
        body->start.at[k] += arm[k];
    const double *q = body->start.turn;
    double both[4] = {q[0] * turn[0] - q[1] * turn[1] - q[2] * turn[2] - q[3] * turn[3],
                      q[0] * turn[1] + q[1] * turn[0] + q[2] * turn[3] - q[3] * turn[2],
                      q[0] * turn[2] - q[1] * turn[3] + q[2] * turn[0] + q[3] * turn[1],
                      q[0] * turn[3] + q[1] * turn[2] - q[2] * turn[1] + q[3] * turn[0]};
    memcpy(body->start.turn, both, sizeof both);
    return true;
}

/* ---- overlaps ---- */

/* A cylinder in a plane: its lowest point along the normal. */
static double cylinder_in_plane(const PeerBody *b, const PeerState *s, const PeerBody *plane)
{
    double axis[3], up[3] = {0, 1, 0};
    peer_turned(s->turn, up, axis);
    double c = dot(axis, plane->size), low = dot(s->at, plane->size) - plane->offset;
    return b->size[1] * fabs(c) + b->size[0] * sqrt(fmax(0, 1 - c * c)) - low;
}

/* Spheres and boxes with each other and with planes, cylinders with planes: what the cases that ask for it have in them. */
double peer_penetration(const PeerScene *scene, const PeerState *state)
{
    size_t n = (size_t)scene->bodies;
    BenchBody *body = calloc(n, sizeof *body);
    BenchPose *pose = calloc(n, sizeof *pose);
    BenchScene all = {.body = body, .bodies = scene->bodies, .ball = -1};
    BenchFound found = {0};
    double deep = 0;
    if (!body || !pose)
        abort();
    for (int i = 0; i < scene->bodies; i++) {
        const PeerBody *b = &scene->body[i];
        bool judged = (b->kind == PEER_SPHERE || b->kind == PEER_BOX) && !b->gone && !b->ghost;
        body[i] = (BenchBody){.kind = b->kind == PEER_BOX ? BENCH_BOX : BENCH_SPHERE, .fixed = b->mass <= 0 || !judged, .wall = !judged};
        memcpy(body[i].size, b->size, sizeof body[i].size);
        memcpy(pose[i].at, state[i].at, sizeof pose[i].at);
        for (int k = 0; k < 4; k++)
            pose[i].turn[k] = state[i].turn[(k + 1) % 4];
        if (b->kind == PEER_PLANE && all.planes < 6) {
            double *plane = all.plane[all.planes++];
            memcpy(plane, b->size, sizeof b->size);
            plane[3] = -b->offset;
        }
        for (int k = 0; b->kind == PEER_CYLINDER && k < scene->bodies; k++)
            if (scene->body[k].kind == PEER_PLANE)
                deep = fmax(deep, cylinder_in_plane(b, &state[i], &scene->body[k]));
    }
    bench_check(&all, pose, &found);
    free(body);
    free(pose);
    return found.lost ? HUGE_VAL : fmax(deep, found.penetration_max);
}
