/* render/block.h - pixels that show the same thing, side by side: where their rays meet it, and which way it faces there.
 *
 * A Subject is what they show, a Block up to LANES of its pixels, not necessarily neighbours. Everything is a loop over lanes
 * without branches, which compilers turn into vector instructions; results are those of IEEE arithmetic without fused
 * operations, the same for any width of vectors. Here every function is inline, so that shade.c can compile it twice.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_BLOCK_H
#define DIG_BLOCK_H

#include "render/light.h"

enum { LANES = 64, LANE_STEP = 8, SIDES = 5 };

#define LANE_CODE static inline __attribute__((always_inline))

typedef enum SubjectForm { SUBJECT_SKY, SUBJECT_PLANE, SUBJECT_BALL, SUBJECT_BOX, SUBJECT_CAPSULE, SUBJECT_CYLINDER } SubjectForm;

/* Lengths in scene units, directions and places in the axes of the solid (the sky: the scene's) unless said otherwise. */
typedef struct Subject {
    SubjectForm form;
    int   pattern, lamps;
    bool  floor, shadows;               /* its light comes from the floor map; the sun map is there */
    float eye[3];
    float ray[3][3];                    /* of pixel (x, y): [0] x + [1] y + [2]; one long along the view      */
    float sun[3], east[3], north[3], up[3];     /* towards the sun; the scene's axes                          */
    float radius, length;               /* balls, capsules; cylinders: radius                                 */
    float half[4], look[4], colour[4], seed;    /* as in Instance                                             */
    float inverse[3];                   /* 1 / half                                                           */
    float to_sun[3][4], to_top[3][4];   /* place to texels of the sun map and depth; to 0..1 of the maps over the floor and height */
    float direct[3], sky[3];            /* planes: light of the open sun and of the open sky                  */
    float lamp[FRAME_LAMPS][3];
    uint32_t key[SIDES];                /* of each side, in place                                             */
} Subject;

typedef struct Block {
    int      n;                         /* lanes in use; a multiple of LANE_STEP                              */
    float    x[LANES], y[LANES];        /* pixel, from the left and from below                                */
    uint32_t place[LANES], out[LANES];  /* where in the picture; the pixel's new value                        */
    float    t[LANES];                  /* distance along the view                                            */
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

LANE_CODE void follow_rays(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2];
    for (int i = 0; i < b->n; i++) {
        b->px[i] = ex + b->t[i] * b->dx[i];
        b->py[i] = ey + b->t[i] * b->dy[i];
        b->pz[i] = ez + b->t[i] * b->dz[i];
    }
}

LANE_CODE void meet_plane(const Subject *s, Block *b)
{
    const float height = s->eye[1];
    for (int i = 0; i < b->n; i++) {
        b->t[i] = height / most(-b->dy[i], 1e-7f);
        b->nx[i] = b->nz[i] = 0;
        b->ny[i] = 1;
        b->side[i] = 0;
    }
    follow_rays(s, b);
}

/* The last of three slabs to be entered. Edges look rounded: outside the box shrunk by the bevel, the normal points away from the
 * nearest point of that smaller box. */
LANE_CODE void meet_box(const Subject *s, Block *b)
{
    const float hx = s->half[0], hy = s->half[1], hz = s->half[2], ex = s->eye[0], ey = s->eye[1], ez = s->eye[2];
    const float bevel = s->look[1], rest = 1e-4f * bevel, ix = hx - bevel, iy = hy - bevel, iz = hz - bevel;
    for (int i = 0; i < b->n; i++) {
        float dx = off_zero(b->dx[i], 1e-12f), dy = off_zero(b->dy[i], 1e-12f), dz = off_zero(b->dz[i], 1e-12f);
        float tx = ((dx > 0 ? -hx : hx) - ex) / dx, ty = ((dy > 0 ? -hy : hy) - ey) / dy, tz = ((dz > 0 ? -hz : hz) - ez) / dz;
        b->t[i] = most(most(tx, ty), most(tz, 0));
    }
    follow_rays(s, b);
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

/* The ray from (ex, ey, ez) along d to the ball round the origin; from the ray's nearest point to the middle, which keeps its digits. */
LANE_CODE float reach_ball(float ex, float ey, float ez, float dx, float dy, float dz, float radius)
{
    float dd = dx * dx + (dy * dy + dz * dz), near = -(ex * dx + (ey * dy + ez * dz)) / dd;
    float ox = ex + near * dx, oy = ey + near * dy, oz = ez + near * dz;
    float inside = most(radius * radius - (ox * ox + (oy * oy + oz * oz)), 0);
    return near - sqrtf(inside / dd);
}

LANE_CODE void meet_ball(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius;
    for (int i = 0; i < b->n; i++)
        b->t[i] = reach_ball(ex, ey, ez, b->dx[i], b->dy[i], b->dz[i], radius);
    follow_rays(s, b);
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], py = b->py[i], pz = b->pz[i], scale = 1 / sqrtf(px * px + (py * py + pz * pz) + 1e-30f);
        b->nx[i] = px * scale;
        b->ny[i] = py * scale;
        b->nz[i] = pz * scale;
        b->side[i] = 0;
    }
}

/* To the wall, and where that is beyond an end, to the ball there. */
LANE_CODE void meet_capsule(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius, end = 0.5f * s->length;
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i];
        float dd = dx * dx + dz * dz + 1e-12f, near = -(ex * dx + ez * dz) / dd, ox = ex + near * dx, oz = ez + near * dz;
        float wall = near - sqrtf(most(radius * radius - (ox * ox + oz * oz), 0) / dd), y = ey + wall * dy;
        float middle = y < 0 ? -end : end, ball = reach_ball(ex, ey - middle, ez, dx, dy, dz, radius);
        b->t[i] = fabsf(y) < end ? wall : ball;
    }
    follow_rays(s, b);
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], y = b->py[i], pz = b->pz[i], py = y - least(most(y, -end), end);
        float scale = 1 / sqrtf(px * px + (py * py + pz * pz) + 1e-30f);
        b->nx[i] = px * scale;
        b->ny[i] = py * scale;
        b->nz[i] = pz * scale;
        b->side[i] = 0;
    }
}

/* The later of wall and end. Its rim looks rounded as the edges of a box do, in (radius, height). */
LANE_CODE void meet_cylinder(const Subject *s, Block *b)
{
    const float ex = s->eye[0], ey = s->eye[1], ez = s->eye[2], radius = s->radius, end = s->half[1];
    const float bevel = s->look[1], rest = 1e-4f * bevel, inner = s->half[0] - bevel, top = end - bevel;
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dz = b->dz[i], dy = off_zero(b->dy[i], 1e-12f);
        float dd = dx * dx + dz * dz + 1e-12f, near = -(ex * dx + ez * dz) / dd, ox = ex + near * dx, oz = ez + near * dz;
        float wall = near - sqrtf(most(radius * radius - (ox * ox + oz * oz), 0) / dd), cap = ((dy > 0 ? -end : end) - ey) / dy;
        b->t[i] = most(most(wall, cap), 0);
    }
    follow_rays(s, b);
    for (int i = 0; i < b->n; i++) {
        float px = b->px[i], py = b->py[i], pz = b->pz[i], d = most(sqrtf(px * px + pz * pz), 1e-9f);
        float x = most(d - inner, 0) + rest, y = most(fabsf(py) - top, 0) + rest, scale = 1 / sqrtf(x * x + y * y);
        b->nx[i] = px * (x * scale / d);
        b->ny[i] = py < 0 ? -y * scale : y * scale;
        b->nz[i] = pz * (x * scale / d);
        b->side[i] = y >= x;
    }
}

LANE_CODE void meet(const Subject *s, Block *b)
{
    switch (s->form) {
    case SUBJECT_PLANE:    meet_plane(s, b); break;
    case SUBJECT_BOX:      meet_box(s, b); break;
    case SUBJECT_BALL:     meet_ball(s, b); break;
    case SUBJECT_CAPSULE:  meet_capsule(s, b); break;
    case SUBJECT_CYLINDER: meet_cylinder(s, b); break;
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
        float slope = b->t[i] / off_zero(nx * dx + (ny * dy + nz * dz), s->form == SUBJECT_PLANE ? 1e-7f : 0.03f), t = b->t[i];
        float across = slope * (nx * r[0][0] + (ny * r[0][1] + nz * r[0][2]));
        float along = slope * (nx * r[1][0] + (ny * r[1][1] + nz * r[1][2]));
        b->wx[i] = fabsf(t * r[0][0] - across * dx) + fabsf(t * r[1][0] - along * dx);
        b->wy[i] = fabsf(t * r[0][1] - across * dy) + fabsf(t * r[1][1] - along * dy);
        b->wz[i] = fabsf(t * r[0][2] - across * dz) + fabsf(t * r[1][2] - along * dz);
    }
}

#endif
