/* geom/hull_build.c - from a cloud of points to the corners and polygons of its convex hull, by the Qhull library.
 *
 * Qhull finds the corners (Barber, Dobkin & Huhdanpaa, The Quickhull algorithm for convex hulls, ACM TOMS 22(4), 1996) and
 * merges faces that lie in one plane to within MERGE of the size, so that the six sides of a box read from a file with six
 * digits are six polygons and not twelve slivers. Its lists may come in any order; numbering here starts again from the
 * points given, so that the result depends on nothing else.
 */
#define _POSIX_C_SOURCE 200809L     /* open_memstream: qhull wants a stream for its messages */

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include "geom/hull_build.h"

#include <libqhull_r/qhull_ra.h>

#define FLAT  1e-9      /* of the size: points this near a point, line or plane lie in it */
#define NOTCH 1e-6      /* rad, about: polygons may bend back by this much */

/* ---- is there a solid at all? ---- */

static int farthest_from(const dig_points *p, vec3 from)
{
    int best = 0;
    for (int i = 1; i < p->count; i++)
        if (vec3_length2(vec3_sub(p->v[i], from)) > vec3_length2(vec3_sub(p->v[best], from)))
            best = i;
    return best;
}

static dig_status check_solid(const dig_points *p, char *why, size_t capacity)
{
    if (p->count < 4)
        return shape_fail(DIG_E_ARG, why, capacity, "hull needs 4 points not in one plane (got %d)", p->count);
    if (p->count > HULL_POINTS)
        return shape_fail(DIG_E_FULL, why, capacity, "hull has %d points, must be at most %d", p->count, HULL_POINTS);

    vec3 a = p->v[farthest_from(p, p->v[0])], b = p->v[farthest_from(p, a)];
    real size = vec3_distance(a, b);
    if (size == 0)
        return shape_fail(DIG_E_ARG, why, capacity, "hull needs 4 points not in one plane (the %d given are one point)", p->count);

    vec3 line = vec3_unit(vec3_sub(b, a)), out = vec3_zero();
    real width = 0;                             /* of the point farthest from the line */
    for (int i = 0; i < p->count; i++) {
        vec3 d = vec3_sub(p->v[i], a), off = vec3_mad(d, -vec3_dot(d, line), line);
        if (vec3_length(off) > width) {
            width = vec3_length(off);
            out = off;
        }
    }
    if (!(width > FLAT * size))
        return shape_fail(DIG_E_ARG, why, capacity, "hull needs 4 points not in one plane (the %d given lie on one line)", p->count);

    vec3 n = vec3_unit(vec3_cross(line, out));
    real low = 0, high = 0;
    for (int i = 0; i < p->count; i++) {
        real d = vec3_dot(n, vec3_sub(p->v[i], a));
        low  = real_min(low, d);
        high = real_max(high, d);
    }
    if (!(high - low > FLAT * size))
        return shape_fail(DIG_E_ARG, why, capacity, "hull needs 4 points not in one plane (the %d given lie in one plane)", p->count);
    real thin = real_min(size, real_min(width, high - low));
    if (!(thin >= SHAPE_LENGTH_MIN))
        return shape_fail(DIG_E_ARG, why, capacity, "hull is %g m thin, must be at least %g m", thin, SHAPE_LENGTH_MIN);
    return DIG_OK;
}

/* ---- qhull ---- */

typedef struct Qhull {
    qhT     qh;
    FILE   *messages;
    char   *text;           /* what qhull said; nobody reads it */
    size_t  length;
    coordT *coords;         /* [3 * count] moved and scaled into the unit cube: qhull's tolerances are absolute */
    int     count;
    int    *number;         /* [count] vertex number of each point, -1 = none */
} Qhull;

static dig_status open_qhull(Qhull *q, const dig_points *p)
{
    q->count  = p->count;
    q->coords = malloc(3 * (size_t)p->count * sizeof *q->coords);
    q->number = malloc((size_t)p->count * sizeof *q->number);
    q->messages = open_memstream(&q->text, &q->length);
    if (!q->coords || !q->number || !q->messages)
        return DIG_E_MEMORY;

    vec3 low = p->v[0], high = p->v[0];
    for (int i = 1; i < p->count; i++) {
        low  = vec3_min(low, p->v[i]);
        high = vec3_max(high, p->v[i]);
    }
    vec3 middle = vec3_lerp(low, high, 0.5);
    real s = 1 / vec3_largest(vec3_sub(high, low));
    for (int i = 0; i < p->count; i++) {
        vec3 x = vec3_scale(s, vec3_sub(p->v[i], middle));
        q->coords[3 * i]     = x.x;
        q->coords[3 * i + 1] = x.y;
        q->coords[3 * i + 2] = x.z;
    }
    return DIG_OK;
}

static void close_qhull(Qhull *q)
{
    if (q->messages)
        fclose(q->messages);
    free(q->text);
    free(q->coords);
    free(q->number);
    free(q);
}

/* Numbers the corners in use by the order of their points. False: more than HULL_VERTICES; the count is right all the same. */
static bool number_vertices(Qhull *q, const dig_points *points, HullWork *work)
{
    qhT *qh = &q->qh;
    facetT *facet;
    vertexT *vertex, **vertexp;

    for (int i = 0; i < q->count; i++)
        q->number[i] = -1;
    FORALLfacets {
        FOREACHvertex_(facet->vertices)
            q->number[qh_pointid(qh, vertex->point)] = 0;
    }
    work->vertex_count = 0;
    for (int i = 0; i < q->count; i++)
        if (q->number[i] == 0) {
            if (work->vertex_count < HULL_VERTICES)
                work->vertices[work->vertex_count] = points->v[i];
            q->number[i] = work->vertex_count++;
        }
    return work->vertex_count <= HULL_VERTICES;
}

/* Copies the polygon of one facet, counter-clockwise outside, starting at its lowest corner. */
static bool copy_facet(Qhull *q, facetT *facet, HullWork *work)
{
    qhT *qh = &q->qh;
    setT *ring = qh_facet3vertex(qh, facet);
    int count = qh_setsize(qh, ring), lowest = 0, at = work->corner_count;
    uint8_t corners[HULL_VERTICES];

    if (count < 3 || count > HULL_VERTICES || at + count > HULL_CORNERS || work->face_count >= HULL_FACES) {
        qh_settempfree(qh, &ring);
        return false;
    }
    for (int i = 0; i < count; i++) {
        const vertexT *vertex = SETelemt_(ring, i, vertexT);
        corners[i] = (uint8_t)q->number[qh_pointid(qh, vertex->point)];
    }
    qh_settempfree(qh, &ring);

    vec3 newell = vec3_zero();
    for (int i = 0; i < count; i++)
        newell = vec3_add(newell, vec3_cross(vec3_sub(work->vertices[corners[i]], work->vertices[corners[0]]),
                                             vec3_sub(work->vertices[corners[(i + 1) % count]], work->vertices[corners[0]])));
    bool backward = vec3_dot(newell, (vec3){facet->normal[0], facet->normal[1], facet->normal[2]}) < 0;
    for (int i = 1; i < count; i++)
        if (corners[i] < corners[lowest])
            lowest = i;
    for (int i = 0; i < count; i++)
        work->corners[at + i] = corners[(lowest + (backward ? count - i : i)) % count];
    work->first[work->face_count] = at;
    work->count[work->face_count++] = count;
    work->corner_count += count;
    return true;
}

static bool copy_facets(Qhull *q, HullWork *work)
{
    qhT *qh = &q->qh;
    facetT *facet;
    work->face_count = work->corner_count = 0;
    FORALLfacets {
        if (!copy_facet(q, facet, work))
            return false;
    }
    return true;
}

/* A closed surface of one piece: every edge runs once each way, every corner is used, and V - E + F = 2. */
static bool is_closed(HullWork *work)
{
    int edges = 0;
    bool used[HULL_VERTICES] = {false};
    memset(work->side, 0, sizeof work->side);

    for (int f = 0; f < work->face_count; f++)
        for (int i = 0; i < work->count[f]; i++) {
            int tail = work->corners[work->first[f] + i], head = work->corners[work->first[f] + (i + 1) % work->count[f]];
            if (work->side[tail][head] != 0)
                return false;
            work->side[tail][head] = (uint16_t)(f + 1);
            used[tail] = true;
        }
    for (int a = 0; a < work->vertex_count; a++) {
        if (!used[a])
            return false;
        for (int b = 0; b < work->vertex_count; b++) {
            if ((work->side[a][b] != 0) != (work->side[b][a] != 0))
                return false;
            edges += a < b && work->side[a][b] != 0;
        }
    }
    return work->vertex_count - edges + work->face_count == 2;
}

vec3 hull_area(const HullWork *work, int f)
{
    const uint8_t *c = work->corners + work->first[f];
    vec3 origin = work->vertices[c[0]], area = vec3_zero();
    for (int i = 1; i + 1 < work->count[f]; i++)
        area = vec3_add(area, vec3_cross(vec3_sub(work->vertices[c[i]], origin), vec3_sub(work->vertices[c[i + 1]], origin)));
    return area;
}

/* Merging the facets of a plate hardly thicker than the tolerance can leave a polygon with a notch: clipping needs none. */
static bool is_convex(const HullWork *work)
{
    for (int f = 0; f < work->face_count; f++) {
        const uint8_t *c = work->corners + work->first[f];
        vec3 normal = vec3_unit_or(hull_area(work, f), vec3_zero());
        int n = work->count[f];
        for (int i = 0; i < n && n > 3; i++) {
            vec3 in = vec3_sub(work->vertices[c[(i + 1) % n]], work->vertices[c[i]]);
            vec3 out = vec3_sub(work->vertices[c[(i + 2) % n]], work->vertices[c[(i + 1) % n]]);
            if (vec3_dot(vec3_cross(in, out), normal) < -NOTCH * (vec3_length2(in) + vec3_length2(out)))
                return false;
        }
        if (!(vec3_length2(normal) > 0))
            return false;
    }
    return true;
}

bool hull_is_sound(HullWork *work) { return is_closed(work) && is_convex(work); }

typedef enum Outcome { HULL_GOOD, HULL_FAILED, HULL_TOO_MANY } Outcome;

/* Qhull leaves by longjmp when it fails; nothing that lives across that is a local variable that changes. */
static Outcome copy_hull(Qhull *q, const dig_points *points, HullWork *work)
{
    qhT *qh = &q->qh;
    Outcome outcome = HULL_FAILED;
    if (setjmp(qh->errexit) != 0) {
        qh->NOerrexit = True;
        return HULL_FAILED;
    }
    qh->NOerrexit = False;
    if (!number_vertices(q, points, work))
        outcome = HULL_TOO_MANY;
    else if (copy_facets(q, work))
        outcome = HULL_GOOD;
    qh->NOerrexit = True;
    return outcome;
}

static Outcome run_qhull(Qhull *q, const dig_points *points, const char *options, HullWork *work)
{
    int left_long, left_total;
    char command[32];
    snprintf(command, sizeof command, "qhull %s", options);
    qh_zero(&q->qh, q->messages);
    Outcome outcome = HULL_FAILED;
    if (qh_new_qhull(&q->qh, 3, q->count, q->coords, False, command, NULL, q->messages) == 0)
        outcome = copy_hull(q, points, work);
    qh_freeqhull(&q->qh, !qh_ALL);
    qh_memfreeshort(&q->qh, &left_long, &left_total);
    return outcome == HULL_GOOD && !hull_is_sound(work) ? HULL_FAILED : outcome;
}

/* ---- order ---- */

/* Dictionary order of two polygons that both start at their lowest corner. */
static int compare_faces(const HullWork *work, int a, int b)
{
    int n = int_min(work->count[a], work->count[b]);
    int order = memcmp(work->corners + work->first[a], work->corners + work->first[b], (size_t)n);
    return order != 0 ? order : work->count[a] - work->count[b];
}

static void sort_faces(HullWork *work)
{
    for (int i = 1; i < work->face_count; i++)
        for (int k = i; k > 0 && compare_faces(work, k - 1, k) > 0; k--) {
            int first = work->first[k], count = work->count[k];
            work->first[k] = work->first[k - 1];
            work->count[k] = work->count[k - 1];
            work->first[k - 1] = first;
            work->count[k - 1] = count;
        }
    (void)is_closed(work);          /* the faces have new numbers: fill `side` again */
}

dig_status hull_build(const dig_points *points, HullWork *work, char *why, size_t capacity)
{
    /* Merged to 1e-7 of the size after the hull is built; then, for plates thinner than that, only to rounding; then triangles. */
    static const char *const options[] = {"C-0 C1e-7 Pp", "C-0 Pp", "Qt Pp"};

    DIG_TRY(check_solid(points, why, capacity));
    Qhull *q = calloc(1, sizeof *q);
    if (!q)
        return DIG_E_MEMORY;
    dig_status status = open_qhull(q, points);
    Outcome outcome = HULL_FAILED;
    for (size_t i = 0; status == DIG_OK && outcome == HULL_FAILED && i < sizeof options / sizeof *options; i++)
        outcome = run_qhull(q, points, options[i], work);
    close_qhull(q);
    DIG_TRY(status);

    if (outcome == HULL_TOO_MANY)
        return shape_fail(DIG_E_FULL, why, capacity, "hull has %d corners, must be at most %d", work->vertex_count, HULL_VERTICES);
    if (outcome != HULL_GOOD)
        return shape_fail(DIG_E_ARG, why, capacity, "hull of %d points could not be built: they are too nearly flat", points->count);
    sort_faces(work);
    return DIG_OK;
}
