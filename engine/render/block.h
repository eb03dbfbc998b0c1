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
    float    x[LANES + LANE_STEP], y[LANES + LANE_STEP];            /* pixel, from the left and from below    */
    float    t[LANES + LANE_STEP];                                  /* distance along the view                */
    uint32_t out[LANES];                /* the pixel's new value                                              */
    struct { uint32_t place; int first, count; } part[LANES];       /* runs of lanes that lie side by side in the picture from `place` on */
    int      parts;
    float    dx[LANES], dy[LANES], dz[LANES];       /* ray                                                    */
    float    px[LANES], py[LANES], pz[LANES];       /* where it meets the solid                               */
    float    nx[LANES], ny[LANES], nz[LANES];       /* normal                                                 */
    float    wx[LANES], wy[LANES], wz[LANES];       /* how much of the solid a pixel spans along each axis    */
    float    red[LANES], green[LANES], blue[LANES]; /* colour, then light                                     */
    float    lit[LANES], sky[LANES];                /* share of the sun that arrives, of the sky that is seen */
    int32_t  side[LANES];
} Block;

/* ---- numbers ----------------------------------------------------------- */

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

/* What rays are cast at, apart from the Subject: the compiler sees that no store changes it. */
typedef struct Solid { float ex, ey, ez, hx, hy, hz, radius, end; } Solid;

LANE_CODE Solid solid_of(const Subject *s)
{
    return (Solid){s->eye[0], s->eye[1], s->eye[2], s->half[0], s->half[1], s->half[2], s->radius,
                   s->form == SUBJECT_CAPSULE ? 0.5f * s->length : s->half[1]};
}

/* Distance along the view; above 0: the ray misses the solid. */
typedef struct Reach { float t, miss; } Reach;

LANE_CODE Reach reach_plane(const Solid *s, float dx, float dy, float dz)
{
    float t = s->ey / most(-dy, 1e-7f), x = s->ex + t * dx, z = s->ez + t * dz;
    return (Reach){t, dy < -1e-7f ? most(fabsf(x), fabsf(z)) - s->radius : 1};
}

/* Between the last of three slabs to be entered and the first to be left. */
LANE_CODE Reach reach_box(const Solid *s, float dx, float dy, float dz)
{
    float x = -1 / off_zero(dx, 1e-12f), y = -1 / off_zero(dy, 1e-12f), z = -1 / off_zero(dz, 1e-12f);
    float wide_x = fabsf(s->hx * x), wide_y = fabsf(s->hy * y), wide_z = fabsf(s->hz * z);
    float enter = most(most(s->ex * x - wide_x, s->ey * y - wide_y), s->ez * z - wide_z);
    return (Reach){most(enter, 0), enter - least(least(s->ex * x + wide_x, s->ey * y + wide_y), s->ez * z + wide_z)};
}

/* The ray from (ex, ey, ez) along d to the ball round the origin; from the ray's nearest point to the middle, which keeps its digits.
 * Rays that just miss it are taken to touch it. */
LANE_CODE Reach reach_round(float ex, float ey, float ez, float dx, float dy, float dz, float radius)
{
    float dd = dx * dx + (dy * dy + dz * dz), near = -(ex * dx + (ey * dy + ez * dz)) / dd;
    float ox = ex + near * dx, oy = ey + near * dy, oz = ez + near * dz, miss = ox * ox + (oy * oy + oz * oz) - radius * radius;
    return (Reach){near - sqrtf(most(-miss, 0) / dd), miss};
}

LANE_CODE Reach reach_ball(const Solid *s, float dx, float dy, float dz) { return reach_round(s->ex, s->ey, s->ez, dx, dy, dz, s->radius); }

/* To the wall, and where that is beyond an end, to the ball there. */
LANE_CODE Reach reach_capsule(const Solid *s, float dx, float dy, float dz)
{
    float dd = dx * dx + dz * dz + 1e-12f, near = -(s->ex * dx + s->ez * dz) / dd, ox = s->ex + near * dx, oz = s->ez + near * dz;
    float beside = ox * ox + oz * oz - s->radius * s->radius, wall = near - sqrtf(most(-beside, 0) / dd), y = s->ey + wall * dy;
    Reach ball = reach_round(s->ex, s->ey - (y < 0 ? -s->end : s->end), s->ez, dx, dy, dz, s->radius);
    bool side = fabsf(y) < s->end;
    return (Reach){side ? wall : ball.t, side ? beside : ball.miss};
}

/* Between the later entry into wall and slab and the earlier way out. */
LANE_CODE Reach reach_cylinder(const Solid *s, float dx, float dy, float dz)
{
    float y = -1 / off_zero(dy, 1e-12f), wide = fabsf(s->end * y);
    float dd = dx * dx + dz * dz + 1e-12f, near = -(s->ex * dx + s->ez * dz) / dd, ox = s->ex + near * dx, oz = s->ez + near * dz;
    float beside = ox * ox + oz * oz - s->radius * s->radius, deep = sqrtf(most(-beside, 0) / dd), enter = most(near - deep, s->ey * y - wide);
    return (Reach){most(enter, 0), most(beside, enter - least(near + deep, s->ey * y + wide))};
}

/* `form` is known where this is compiled. */
LANE_CODE Reach reach_form(const Solid *s, SubjectForm form, float dx, float dy, float dz)
{
    switch (form) {
    case SUBJECT_PLANE:    return reach_plane(s, dx, dy, dz);
    case SUBJECT_BOX:      return reach_box(s, dx, dy, dz);
    case SUBJECT_BALL:     return reach_ball(s, dx, dy, dz);
    case SUBJECT_CAPSULE:  return reach_capsule(s, dx, dy, dz);
    case SUBJECT_CYLINDER: return reach_cylinder(s, dx, dy, dz);
    case SUBJECT_SKY:      break;
    }
    return (Reach){0, 1};
}

LANE_CODE void find_form(const Subject *s, SubjectForm form, Block *b)
{
    const Solid solid = solid_of(s);
    for (int i = 0; i < b->n; i++)
        b->t[i] = reach_form(&solid, form, b->dx[i], b->dy[i], b->dz[i]).t;
}

/* b->t of the rays b->dx, dy, dz. */
LANE_CODE void find(const Subject *s, Block *b)
{
    switch (s->form) {
    case SUBJECT_PLANE:    find_form(s, SUBJECT_PLANE, b); break;
    case SUBJECT_BOX:      find_form(s, SUBJECT_BOX, b); break;
    case SUBJECT_BALL:     find_form(s, SUBJECT_BALL, b); break;
    case SUBJECT_CAPSULE:  find_form(s, SUBJECT_CAPSULE, b); break;
    case SUBJECT_CYLINDER: find_form(s, SUBJECT_CYLINDER, b); break;
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
