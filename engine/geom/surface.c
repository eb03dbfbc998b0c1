/* geom/surface.c - meshes and height fields: their pieces one by one, each a triangle. */
#include "geom/pair.h"

#define CHUNK 256           /* pieces asked for at once */
#define CUTS  40            /* how often a box is halved when it holds more */

/* ---- the triangle as a convex shape ---- */

static const vec3 *corners_of(const Shape *s) { return s->data; }

static vec3 triangle_support(const Shape *s, vec3 d)
{
    const vec3 *c = corners_of(s);
    real x = vec3_dot(c[0], d), y = vec3_dot(c[1], d), z = vec3_dot(c[2], d);
    return x >= y && x >= z ? c[0] : y >= z ? c[1] : c[2];
}

/* Both sides are faces: number 0 is the one seen counter-clockwise. */
static int triangle_face(const Shape *s, vec3 direction, vec3 corners[16], uint32_t *feature)
{
    const vec3 *c = corners_of(s);
    bool front = vec3_dot(vec3_cross(vec3_sub(c[1], c[0]), vec3_sub(c[2], c[0])), direction) >= 0;
    corners[0] = c[0];
    corners[1] = front ? c[1] : c[2];
    corners[2] = front ? c[2] : c[1];
    *feature = front ? 0 : 1;
    return 3;
}

static box3 triangle_bounds(const Shape *s, pose at)
{
    const vec3 *c = corners_of(s);
    vec3 p = pose_point(at, c[0]), q = pose_point(at, c[1]), r = pose_point(at, c[2]);
    return (box3){vec3_min(p, vec3_min(q, r)), vec3_max(p, vec3_max(q, r))};
}

const ShapeType shape_triangle = {
    .name    = "triangle",
    .doc     = "One piece of a mesh or height field.",
    .convex  = true,
    .support = triangle_support,
    .bounds  = triangle_bounds,
    .face    = triangle_face,
};

Shape triangle_shape(const vec3 corners[3])
{
    real outer2 = real_max(vec3_length2(corners[0]), real_max(vec3_length2(corners[1]), vec3_length2(corners[2])));
    return (Shape){.type = &shape_triangle, .data = corners, .outer = sqrt(outer2)};
}

/* ---- all pieces in a box ---- */

typedef struct Walk { const Shape *s; PieceVisit *visit; void *context; box3 whole; bool stopped; } Walk;

static SurfacePiece load(const Shape *s, uint32_t number)
{
    SurfacePiece p = {.number = number};
    s->type->piece(s, number, p.corners);
    p.origin = vec3_scale(1.0 / 3, vec3_add(p.corners[0], vec3_add(p.corners[1], p.corners[2])));
    return p;
}

/* When the box was cut, a piece belongs to the part that holds the low corner of what it shares with the whole box. */
static bool is_home(const Walk *w, box3 part, const SurfacePiece *p)
{
    vec3 low = vec3_max(vec3_min(p->corners[0], vec3_min(p->corners[1], p->corners[2])), w->whole.low);
    for (int k = 0; k < 3; k++) {
        real x = vec3_at(low, k), high = vec3_at(part.high, k);
        bool last = high >= vec3_at(w->whole.high, k);
        if (x < vec3_at(part.low, k) || x > high || (x == high && !last))
            return false;
    }
    return true;
}

static void visit_part(Walk *w, box3 part, int cuts)
{
    uint32_t number[CHUNK];
    int count = w->s->type->pieces(w->s, part, number, CHUNK);
    if (count > CHUNK && cuts < CUTS) {
        vec3 size = vec3_sub(part.high, part.low), middle = vec3_lerp(part.low, part.high, 0.5);
        box3 low = part, high = part;
        if (size.x >= size.y && size.x >= size.z)
            low.high.x = high.low.x = middle.x;
        else if (size.y >= size.z)
            low.high.y = high.low.y = middle.y;
        else
            low.high.z = high.low.z = middle.z;
        visit_part(w, low, cuts + 1);
        visit_part(w, high, cuts + 1);
        return;
    }
    for (int i = 0; i < int_min(count, CHUNK) && !w->stopped; i++) {
        SurfacePiece p = load(w->s, number[i]);
        if (cuts > 0 && !is_home(w, part, &p))
            continue;
        for (int k = 0; k < 3; k++)
            p.corners[k] = vec3_sub(p.corners[k], p.origin);
        w->stopped = !w->visit(w->context, &p);
    }
}

void surface_visit(const Shape *s, box3 box, PieceVisit *visit, void *context)
{
    Walk w = {.s = s, .visit = visit, .context = context, .whole = box};
    visit_part(&w, box, 0);
}
