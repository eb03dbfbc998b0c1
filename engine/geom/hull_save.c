/* geom/hull_save.c - a convex hull as bytes: its corners and polygons. Building it anew from its corners could merge other
 * faces than the points it came from did. */
#include <stdlib.h>

#include "geom/hull_build.h"
#include "geom/save.h"

#define BENT    1e-5    /* of the size: a corner of a face may lie this far below its plane, which goes through the farthest */
#define THINNEST 1e-5   /* m  centre of mass to the nearest face; a hull is 1e-4 m thick at least */

static void hull_work(const Shape *s, HullWork *work)
{
    const HullData *d = s->data;
    work->vertex_count = d->vertex_count;
    work->face_count   = d->face_count;
    work->corner_count = d->corner_count;
    memcpy(work->vertices, hull_vertices(d), (size_t)d->vertex_count * sizeof *work->vertices);
    memcpy(work->corners, hull_corners(d), (size_t)d->corner_count);
    for (int f = 0; f < d->face_count; f++) {
        work->first[f] = hull_faces(d)[f].first;
        work->count[f] = hull_faces(d)[f].count;
    }
}

static int pack_number(Pack *p, int x, int low, int high, const char *what)
{
    uint16_t n = (uint16_t)x;
    pack_u16(p, &n);
    if (p->reading && (n < low || n > high))
        pack_fail(p, "a hull has %u %s, must be %d to %d", n, what, low, high);
    return pack_good(p) ? n : 0;
}

static void pack_lists(Pack *p, HullWork *work)
{
    work->vertex_count = pack_number(p, work->vertex_count, 4, HULL_VERTICES, "corners");
    work->face_count   = pack_number(p, work->face_count, 4, HULL_FACES, "faces");
    work->corner_count = pack_number(p, work->corner_count, 12, HULL_CORNERS, "corners of faces");
    for (int i = 0; i < work->vertex_count; i++)
        pack_vec3(p, &work->vertices[i], SHAPE_LENGTH_MAX, "corner of a hull");
    for (int f = 0; f < work->face_count; f++) {
        work->first[f] = pack_number(p, work->first[f], 0, HULL_CORNERS, "as the first corner of a face");
        work->count[f] = pack_number(p, work->count[f], 3, HULL_VERTICES, "corners in a face");
    }
    for (int i = 0; i < work->corner_count; i++)
        pack_small(p, &work->corners[i], (unsigned)work->vertex_count, "corner of a face");
}

/* Every corner entry belongs to one face. */
static bool faces_cover(const HullWork *work)
{
    bool used[HULL_CORNERS] = {false};
    int total = 0;
    for (int f = 0; f < work->face_count; f++) {
        if (work->first[f] + work->count[f] > work->corner_count)
            return false;
        for (int i = work->first[f]; i < work->first[f] + work->count[f]; i++) {
            if (used[i])
                return false;
            used[i] = true;
        }
        total += work->count[f];
    }
    return total == work->corner_count;
}

/* No corner lies above a face: its plane goes through the farthest corner, so its own must be there too. */
static bool is_hull(const Shape *s)
{
    const HullData *d = s->data;
    for (int f = 0; f < d->face_count; f++) {
        const HullFace *face = &hull_faces(d)[f];
        for (int i = face->first; i < face->first + face->count; i++)
            if (!(face->offset - vec3_dot(face->normal, hull_vertices(d)[hull_corners(d)[i]]) <= BENT * s->outer))
                return false;
    }
    return d->mass.volume > 0 && s->inner >= THINNEST;
}

static void read_hull(Pack *p, HullWork *work, Shape *s)
{
    pack_lists(p, work);
    if (!pack_check(p, pack_good(p) && faces_cover(work) && hull_is_sound(work), "the faces of a hull are no closed surface"))
        return;
    s->type = &shape_hull;
    if (hull_make_data(work, s) != DIG_OK) {
        shape_free(s);
        pack_fail_memory(p);
    } else if (!is_hull(s)) {
        shape_free(s);
        pack_fail(p, "a hull is not convex, or has no volume");
    }
}

void hull_pack(Pack *p, Shape *s)
{
    HullWork *work = calloc(1, sizeof *work);
    if (!work) {
        pack_fail_memory(p);
        return;
    }
    if (p->reading) {
        read_hull(p, work, s);
    } else {
        hull_work(s, work);
        pack_lists(p, work);
    }
    free(work);
}
