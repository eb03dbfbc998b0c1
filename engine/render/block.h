/* render/block.h - pixels that show the same thing, side by side: where their rays meet it, and which way it faces there.
 *
 * A Block is up to LANES pixels of a Subject, not necessarily neighbours. Everything is a loop over lanes
 * without branches, which compilers turn into vector instructions; results are those of IEEE arithmetic without fused
 * operations, the same for any width of vectors. Here every function is inline, so that shade.c can compile it twice.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_BLOCK_H
#define DIG_BLOCK_H

#include "render/subject.h"
#include "render/wide.h"

enum { LANES = 64, LANE_STEP = 8 };

typedef struct Block {
    int      n;                         /* lanes in use; a multiple of LANE_STEP                              */
    float    x[LANES], y[LANES];        /* pixel, from the left and from below                                */
    uint32_t out[LANES];                /* the pixel's new value                                              */
    struct { uint32_t place; int first, count; } part[LANES];       /* runs of lanes that lie side by side in the picture from `place` on */
    int      parts;
    float    t[LANES], miss[LANES];     /* distance along the view; above 0: the ray misses the solid         */
    float    dx[LANES], dy[LANES], dz[LANES];       /* ray                                                    */
    float    px[LANES], py[LANES], pz[LANES];       /* where it meets the solid                               */
    float    nx[LANES], ny[LANES], nz[LANES];       /* normal                                                 */
    float    wx[LANES], wy[LANES], wz[LANES];       /* how much of the solid a pixel spans along each axis    */
    float    red[LANES], green[LANES], blue[LANES]; /* colour, then light                                     */
    float    lit[LANES], sky[LANES];                /* share of the sun that arrives, of the sky that is seen */
    int32_t  side[LANES];
} Block;

/* ---- numbers ----------------------------------------------------------- */

LANE_CODE float least(float a, float b) { return a < b ? a : b; }
LANE_CODE float most(float a, float b) { return a > b ? a : b; }
LANE_CODE float unit_range(float x) { return least(most(x, 0), 1); }
LANE_CODE float blend(float a, float b, float t) { return a + t * (b - a); }

/* Of |x| < 2^31. */
LANE_CODE int32_t whole(float x)
{
    int32_t i = (int32_t)x;
    return i - ((float)i > x);
}

LANE_CODE float part(float x) { return x - (float)whole(x); }

/* x, but not closer to zero than `limit` */
LANE_CODE float off_zero(float x, float limit) { return x < 0 ? least(x, -limit) : most(x, limit); }

/* ---- where rays meet solids -------------------------------------------- */

LANE_CODE void cast_rays(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++) {
        float x = b->x[i], y = b->y[i];
        b->dx[i] = s->ray[0][0] * x + (s->ray[1][0] * y + s->ray[2][0]);
        b->dy[i] = s->ray[0][1] * x + (s->ray[1][1] * y + s->ray[2][1]);
        b->dz[i] = s->ray[0][2] * x + (s->ray[1][2] * y + s->ray[2][2]);
    }
}

LANE_CODE void find_plane(const Subject *s, Block *b)
{
    const float ex = s->eye[0], height = s->eye[1], ez = s->eye[2], size = s->radius;
    for (int i = 0; i < b->n; i++) {
        float dy = b->dy[i], t = height / most(-dy, 1e-7f), x = ex + t * b->dx[i], z = ez + t * b->dz[i];
        b->t[i] = t;
        b->miss[i] = dy < -1e-7f ? most(fabsf(x), fabsf(z)) - size : 1;
    }
}

/* Between the last of three slabs to be entered and the first to be left. */
LANE_CODE void find_box(const Subject *s, Block *b)
{
    const float hx = s->half[0], hy = s->half[1], hz = s->half[2], ex = s->eye[0], ey = s->eye[1], ez = s->eye[2];
    for (int i = 0; i < b->n; i++) {
        float x = -1 / off_zero(b->dx[i], 1e-12f), y = -1 / off_zero(b->dy[i], 1e-12f), z = -1 / off_zero(b->dz[i], 1e-12f);
        float wide_x = fabsf(hx * x), wide_y = fabsf(hy * y), wide_z = fabsf(hz * z);
        float enter = most(most(ex * x - wide_x, ey * y - wide_y), ez * z - wide_z);
        b->t[i] = most(enter, 0);
        b->miss[i] = enter - least(least(ex * x + wide_x, ey * y + wide_y), ez * z + wide_z);
    }
}

typedef struct Reach { float t, miss; } Reach;

/* The ray from (ex, ey, ez) along d to the ball round the origin; from the ray's nearest point to the middle, which keeps its digits.
 * Rays that just miss it are taken to touch it. */
LANE_CODE Reach reach_ball(float ex, float ey, float ez, float dx, float dy, float dz, float radius)
{
    float dd = dx * dx + (dy * dy + dz * dz), near = -(ex * dx + (ey * dy + ez * dz)) / dd;
    float ox = ex + near * dx, oy = ey + near * dy, oz = ez + near * dz, miss = ox * ox + (oy * oy + oz * oz) - radius * radius;
    return (Reach){near - sqrtf(most(-miss, 0) / dd), miss};
}

LANE_CODE void find_ball(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius;
    for (int i = 0; i < b->n; i++) {
        Reach r = reach_ball(ex, ey, ez, b->dx[i], b->dy[i], b->dz[i], radius);
        b->t[i] = r.t;
        b->miss[i] = r.miss;
    }
}

/* To the wall, and where that is beyond an end, to the ball there. */
LANE_CODE void find_capsule(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius, end = 0.5f * s->length;
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i];
        float dd = dx * dx + dz * dz + 1e-12f, near = -(ex * dx + ez * dz) / dd, ox = ex + near * dx, oz = ez + near * dz;
        float beside = ox * ox + oz * oz - radius * radius, wall = near - sqrtf(most(-beside, 0) / dd), y = ey + wall * dy;
        Reach ball = reach_ball(ex, ey - (y < 0 ? -end : end), ez, dx, dy, dz, radius);
        b->t[i] = fabsf(y) < end ? wall : ball.t;
        b->miss[i] = fabsf(y) < end ? beside : ball.miss;
    }
}

/* Between the later entry into wall and slab and the earlier way out. */
LANE_CODE void find_cylinder(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius, end = s->half[1];
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dz = b->dz[i], y = -1 / off_zero(b->dy[i], 1e-12f), wide = fabsf(end * y);
        float dd = dx * dx + dz * dz + 1e-12f, near = -(ex * dx + ez * dz) / dd, ox = ex + near * dx, oz = ez + near * dz;
        float beside = ox * ox + oz * oz - radius * radius, deep = sqrtf(most(-beside, 0) / dd), enter = most(near - deep, ey * y - wide);
        b->t[i] = most(enter, 0);
        b->miss[i] = most(beside, enter - least(near + deep, ey * y + wide));
    }
}

/* b->t and b->miss of the rays b->dx, dy, dz. */
LANE_CODE void find(const Subject *s, Block *b)
{
    switch (s->form) {
    case SUBJECT_PLANE:    find_plane(s, b); break;
    case SUBJECT_BOX:      find_box(s, b); break;
    case SUBJECT_BALL:     find_ball(s, b); break;
    case SUBJECT_CAPSULE:  find_capsule(s, b); break;
    case SUBJECT_CYLINDER: find_cylinder(s, b); break;
    case SUBJECT_SKY:      break;
    }
}

/* ---- which way they face there ------------------------------------------ */

LANE_CODE void follow_rays(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2];
    for (int i = 0; i < b->n; i++) {
        b->px[i] = ex + b->t[i] * b->dx[i];
        b->py[i] = ey + b->t[i] * b->dy[i];
        b->pz[i] = ez + b->t[i] * b->dz[i];
    }
}

LANE_CODE void face_plane(Block *b)
{
    for (int i = 0; i < b->n; i++) {
        b->nx[i] = b->nz[i] = 0;
        b->ny[i] = 1;
        b->side[i] = 0;
    }
}

/* Edges look rounded: outside the box shrunk by the bevel, the normal points away from the nearest point of that smaller box. */
LANE_CODE void face_box(const Subject *s, Block *b)
{
    const float bevel = s->look[1], rest = 1e-4f * bevel, ix = s->half[0] - bevel, iy = s->half[1] - bevel, iz = s->half[2] - bevel;
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], py = b->py[i], pz = b->pz[i];
        float x = most(fabsf(px) - ix, 0) + rest, y = most(fabsf(py) - iy, 0) + rest, z = most(fabsf(pz) - iz, 0) + rest;
        float scale = 1 / sqrtf(x * x + (y * y + z * z));
        b->nx[i] = px < 0 ? -x * scale : x * scale;
        b->ny[i] = py < 0 ? -y * scale : y * scale;
        b->nz[i] = pz < 0 ? -z * scale : z * scale;
        b->side[i] = 1 + ((y >= z) & (y >= x)) + 2 * ((z >= x) & (z >= y));
    }
}

/* Away from the nearest point of the line from -end to end along y; a ball has end 0. */
LANE_CODE void face_round(Block *b, float end)
{
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], y = b->py[i], pz = b->pz[i], py = y - least(most(y, -end), end);
        float scale = 1 / sqrtf(px * px + (py * py + pz * pz) + 1e-30f);
        b->nx[i] = px * scale;
        b->ny[i] = py * scale;
        b->nz[i] = pz * scale;
        b->side[i] = 0;
    }
}

/* The rim looks rounded as the edges of a box do, in (radius, height). */
LANE_CODE void face_cylinder(const Subject *s, Block *b)
{
    const float bevel = s->look[1], rest = 1e-4f * bevel, inner = s->half[0] - bevel, top = s->half[1] - bevel;
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], py = b->py[i], pz = b->pz[i], d = most(sqrtf(px * px + pz * pz), 1e-9f);
        float x = most(d - inner, 0) + rest, y = most(fabsf(py) - top, 0) + rest, scale = 1 / sqrtf(x * x + y * y);
        b->nx[i] = px * (x * scale / d);
        b->ny[i] = py < 0 ? -y * scale : y * scale;
        b->nz[i] = pz * (x * scale / d);
        b->side[i] = y >= x;
    }
}

LANE_CODE void face(const Subject *s, Block *b)
{
    switch (s->form) {
    case SUBJECT_PLANE:    face_plane(b); break;
    case SUBJECT_BOX:      face_box(s, b); break;
    case SUBJECT_BALL:     face_round(b, 0); break;
    case SUBJECT_CAPSULE:  face_round(b, 0.5f * s->length); break;
    case SUBJECT_CYLINDER: face_cylinder(s, b); break;
    case SUBJECT_SKY:      break;
    }
}

LANE_CODE void meet(const Subject *s, Block *b)
{
    find(s, b);
    follow_rays(s, b);
    face(s, b);
}

/* How much of the solid a pixel spans along each axis, as GLSL's fwidth: with p = eye + t d on the tangent plane,
 * dp/dx = t (d' - d (n d') / (n d)). Near silhouettes it is kept finite. */
LANE_CODE void find_widths(const Subject *s, Block *b)
{
    const float (*r)[3] = s->ray;
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i], nx = b->nx[i], ny = b->ny[i], nz = b->nz[i];
        float slope = b->t[i] / off_zero(nx * dx + (ny * dy + nz * dz), 0.03f), t = b->t[i];
        float across = slope * (nx * r[0][0] + (ny * r[0][1] + nz * r[0][2]));
        float along = slope * (nx * r[1][0] + (ny * r[1][1] + nz * r[1][2]));
        b->wx[i] = fabsf(t * r[0][0] - across * dx) + fabsf(t * r[1][0] - along * dx);
        b->wy[i] = fabsf(t * r[0][1] - across * dy) + fabsf(t * r[1][1] - along * dy);
        b->wz[i] = fabsf(t * r[0][2] - across * dz) + fabsf(t * r[1][2] - along * dz);
    }
}

/* The same for n = (0, 1, 0). */
LANE_CODE void find_plane_widths(const Subject *s, Block *b)
{
    const float (*r)[3] = s->ray;
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dz = b->dz[i], t = b->t[i], slope = t / off_zero(b->dy[i], 1e-7f), across = slope * r[0][1], along = slope * r[1][1];
        b->wx[i] = fabsf(t * r[0][0] - across * dx) + fabsf(t * r[1][0] - along * dx);
        b->wz[i] = fabsf(t * r[0][2] - across * dz) + fabsf(t * r[1][2] - along * dz);
    }
}

#endif
