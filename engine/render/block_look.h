/* render/block_look.h - what the things that a block shows are made of: the patterns of shaders.c, lane by lane.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_BLOCK_LOOK_H
#define DIG_BLOCK_LOOK_H

#include "render/block.h"

/* ---- noise and joints --------------------------------------------------- */

LANE_CODE float hash(int32_t x, int32_t y)
{
    uint32_t h = (uint32_t)x * 0x27d4eb2du ^ (uint32_t)y * 0x9e3779b1u;
    h = (h ^ (h >> 15)) * 0x85ebca6bu;
    return (float)(int32_t)((h ^ (h >> 13)) & 0xffffu) * (1.0f / 65535.0f);
}

LANE_CODE float noise(float x, float y)
{
    int32_t i = whole(x), j = whole(y);
    float u = x - (float)i, v = y - (float)j;
    u = u * u * (3 - 2 * u);
    v = v * v * (3 - 2 * v);
    return blend(blend(hash(i, j), hash(i + 1, j), u), blend(hash(i, j + 1), hash(i + 1, j + 1), u), v);
}

/* 1 on a joint of half width `width` round whole numbers, 0 off it; turns into the mean where pixels, `span` wide, are coarse. */
LANE_CODE float joint(float u, float span, float width)
{
    float d = 0.5f - fabsf(part(u) - 0.5f), l = unit_range((width - d) / span + 0.5f);
    return blend(l, 2 * width, unit_range(span * 2 - 0.4f));
}

LANE_CODE float joints(float u, float v, float span_u, float span_v, float width_u, float width_v)
{
    float a = joint(u, span_u, width_u), b = joint(v, span_v, width_v);
    return a + b - a * b;
}

/* Coordinates on the face of a solid that a point lies on, and how much of each a pixel spans. */
typedef struct Face { float u, v, wu, wv; } Face;

LANE_CODE Face face_of(const Subject *s, const Block *b, int i)
{
    float px = b->px[i], py = b->py[i], pz = b->pz[i], wx = b->wx[i], wy = b->wy[i], wz = b->wz[i];
    float ax = fabsf(px * s->inverse[0]), ay = fabsf(py * s->inverse[1]), az = fabsf(pz * s->inverse[2]);
    bool x = (ax >= ay) & (ax >= az), y = (ay >= az) & !x;
    return (Face){x ? pz : px, (x | !y) ? py : pz, x ? wz : wx, (x | !y) ? wy : wz};
}

/* ---- patterns ------------------------------------------------------------ */

LANE_CODE void set_colour(Block *b, int i, const float colour[4], float factor)
{
    b->red[i] = colour[0] * factor;
    b->green[i] = colour[1] * factor;
    b->blue[i] = colour[2] * factor;
}

LANE_CODE void look_plain(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++)
        set_colour(b, i, s->colour, 1);
}

LANE_CODE void look_wood(const Subject *s, Block *b)
{
    static const float dark[3] = {0.50f, 0.42f, 0.36f};
    const float *const axis[3][2] = {{b->px, b->wx}, {b->py, b->wy}, {b->pz, b->wz}};
    int grain = (int)s->look[3];
    const float *along = axis[grain][0], *p = axis[(grain + 1) % 3][0], *q = axis[(grain + 2) % 3][0];
    const float *wp = axis[(grain + 1) % 3][1], *wq = axis[(grain + 2) % 3][1];
    const float fine = s->look[2], seed = s->seed;
    for (int i = 0; i < b->n; i++) {
        float x = along[i] * fine, y = p[i] * fine, z = q[i] * fine;
        float slow = noise(x * 0.5f + seed, y * 1.1f + z * 1.6f + seed * 0.7f);
        float fibre = noise(x * 1.6f + seed, (y * 1.3f + z * 1.9f) * 14);
        float u = y * 0.5f + 0.31f + (slow - 0.5f) * 0.16f, v = z * 0.5f + 0.47f + (slow - 0.5f) * 0.16f;
        float far = sqrtf(u * u + v * v) + 1e-6f, r = far * 9 + slow * 0.8f;
        float width = (4.5f * fine) * (fabsf(u) * wp[i] + fabsf(v) * wq[i]) / far, ring = part(r);
        ring = ring * ring * (1 - ring) * 5;
        ring = blend(ring, 0.42f, unit_range(width * 2 - 0.4f));
        float share = unit_range(ring * 0.55f + fibre * fibre * 0.75f - 0.12f);
        b->red[i] = s->colour[0] * blend(1.22f, dark[0], share);
        b->green[i] = s->colour[1] * blend(1.22f, dark[1], share);
        b->blue[i] = s->colour[2] * blend(1.22f, dark[2], share);
    }
}

LANE_CODE void look_brick(const Subject *s, Block *b)
{
    const float fine = s->look[2];
    const int32_t shift = (int32_t)(s->seed * 64);
    for (int i = 0; i < b->n; i++) {
        Face f = face_of(s, b, i);
        float u = f.u * fine, v = f.v * (fine * 2.4f);
        int32_t row = whole(v);
        u += 0.5f * (float)(row & 1);
        float tint = 0.72f + 0.56f * hash(whole(u) + shift, row), grain = noise(u * 9, v * 9) - 0.5f;
        float mortar = joints(u, v, f.wu * fine + 1e-5f, f.wv * (fine * 2.4f) + 1e-5f, 0.035f, 0.085f);
        b->red[i] = blend(s->colour[0] * tint + 0.03f * grain, 0.50f, mortar);
        b->green[i] = blend(s->colour[1] * tint + 0.012f * grain, 0.47f, mortar);
        b->blue[i] = blend(s->colour[2] * tint + 0.004f * grain, 0.43f, mortar);
    }
}

LANE_CODE void look_tile(const Subject *s, Block *b)
{
    const float fine = 0.95f * s->look[2];         /* ends just short of a joint on the edge */
    const int32_t shift = (int32_t)(s->seed * 64);
    for (int i = 0; i < b->n; i++) {
        Face f = face_of(s, b, i);
        float u = f.u * fine, v = f.v * fine, tint = 0.90f + 0.2f * hash(whole(u) + shift, whole(v));
        set_colour(b, i, s->colour, tint * (1 - 0.5f * joints(u, v, f.wu * fine + 1e-5f, f.wv * fine + 1e-5f, 0.030f, 0.030f)));
    }
}

/* Mixed with the pale colour of bands and squares. */
LANE_CODE void set_pale(Block *b, int i, const float colour[4], float share)
{
    b->red[i] = blend(colour[0], 0.80f, share);
    b->green[i] = blend(colour[1], 0.79f, share);
    b->blue[i] = blend(colour[2], 0.77f, share);
}

LANE_CODE void look_stripe(const Subject *s, Block *b)
{
    const float fine = s->look[2], width = s->half[3], flip = s->look[3] > 0.5f ? 1.0f : -1.0f, start = 0.5f - 0.5f * flip;
    for (int i = 0; i < b->n; i++) {
        float q = fabsf(b->py[i] * fine), span = b->wy[i] * fine + 1e-5f;
        set_pale(b, i, s->colour, start + flip * unit_range((width - fabsf(q - (float)whole(q + 0.5f))) / span + 0.5f));
    }
}

LANE_CODE void look_check(const Subject *s, Block *b)
{
    const float fine = 0.99f * s->look[2];
    for (int i = 0; i < b->n; i++) {
        float product = 1;
        const float p[3] = {b->px[i], b->py[i], b->pz[i]}, w[3] = {b->wx[i], b->wy[i], b->wz[i]};
        for (int k = 0; k < 3; k++) {
            float square = (0.25f - fabsf(part(p[k] * fine + 0.25f) - 0.5f)) / (w[k] * fine + 1e-4f);
            product *= least(most(square, -0.5f), 0.5f);
        }
        set_pale(b, i, s->colour, 0.5f - 4 * product);
    }
}

/* ---- planes -------------------------------------------------------------- */

/* -0.5 and 0.5 in the cells of a pattern that repeats every two, less where pixels, `span` wide, lie across their border. */
LANE_CODE float cell_side(float u, float span)
{
    float q = fabsf(part(u * 0.5f) - 0.5f) - 0.25f;
    return least(most(q / (0.5f * span), -0.5f), 0.5f);
}

/* Coordinates on a plane in cells of its pattern, and how many of them a pixel spans. */
LANE_CODE Face plane_at(const Subject *s, const Block *b, int i)
{
    float fine = s->look[2];
    return (Face){b->px[i] * fine + s->half[0], b->pz[i] * fine + s->half[1], b->wx[i] * fine + 1e-5f, b->wz[i] * fine + 1e-5f};
}

/* 1 where cells are large, 0 where they are as small as pixels. */
LANE_CODE float sharpness(Face f) { return unit_range(1.5f - 2 * most(f.wu, f.wv)); }

LANE_CODE void look_plane_check(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++) {
        Face f = plane_at(s, b, i);
        set_colour(b, i, s->colour, 1 - 0.42f * (0.5f - 2 * cell_side(f.u, f.wu) * cell_side(f.v, f.wv) * sharpness(f)));
    }
}

LANE_CODE void look_plane_stripe(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++) {
        Face f = plane_at(s, b, i);
        set_colour(b, i, s->colour, 1 - 0.40f * (0.5f - cell_side(f.u, f.wu) * sharpness(f)));
    }
}

LANE_CODE void look_plane_tile(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++) {
        Face f = plane_at(s, b, i);
        float tint = 1 + (hash(whole(f.u), whole(f.v)) - 0.5f) * 0.10f * sharpness(f);
        set_colour(b, i, s->colour, tint * (1 - 0.45f * joints(f.u, f.v, f.wu, f.wv, 0.011f, 0.011f)));
    }
}

LANE_CODE void look_plane(const Subject *s, Block *b)
{
    if (s->pattern == PATTERN_CHECK)
        look_plane_check(s, b);
    else if (s->pattern == PATTERN_STRIPE)
        look_plane_stripe(s, b);
    else
        look_plane_tile(s, b);
}

LANE_CODE void look(const Subject *s, Block *b)
{
    if (s->form == SUBJECT_PLANE) {
        find_plane_widths(s, b);
        look_plane(s, b);
        return;
    }
    if (s->pattern != PATTERN_PLAIN)
        find_widths(s, b);
    switch (s->pattern) {
    case PATTERN_WOOD:   look_wood(s, b); break;
    case PATTERN_BRICK:  look_brick(s, b); break;
    case PATTERN_TILE:   look_tile(s, b); break;
    case PATTERN_STRIPE: look_stripe(s, b); break;
    case PATTERN_CHECK:  look_check(s, b); break;
    default:             look_plain(s, b); break;
    }
}

#endif
