/* render/floor_light.h - the light on the floor: its shadows, sharp where things touch it and soft far from them, and the sky that is hidden.
 *
 * The sun map says, texel by texel of the floor, how much of the sun is hidden and how far away what hides it is. Three softnesses of
 * that are blended by the width that the edges should have there. Every function is inline, so that light.c can compile it twice.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_FLOOR_LIGHT_H
#define DIG_FLOOR_LIGHT_H

#include "render/light.h"
#include "render/wide.h"

static const real BIAS = 0.0015;        /* scene units by which a thing must lie behind another to be in its shadow   */
static const real SPREAD = 0.09;        /* rad, how fast a shadow's edge widens: a hazy sun, wider than the real one */
static const float CONTACT = 0.9f;      /* how much of the sun's wide glow is lost where the sky is: what touches the floor stands on it */
static const real MID_BLUR = 0.022, WIDE_BLUR = 0.085;      /* scene units, half widths of the softer shadows     */

typedef struct Ground {         /* the square that the height and floor maps cover, scene units */
    real x, y, half;
    real low, high;             /* z that the heights tell apart */
    int  row, column;           /* of the world's grid of floor texels, at the map's first */
} Ground;

LANE_CODE int texels_of(real length, real texel) { return (int)real_clamp(length / texel + 0.5, 1, HEIGHT_SIZE / 4); }

/* For the floor: the sky hidden by what stands on it or hovers just above, into sky[HALF^2], 0..1. */
LANE_CODE void hide_sky(Light *l, const Stage *s, const Ground *g)
{
    enum { N = HEIGHT_SIZE };
    float low = (float)(g->low - s->floor), range = (float)(g->high - g->low), reach = (float)(1 / (1.6 * s->typical));
    real texel = 2 * g->half / N;
    float *near = l->sky, *far = l->spare;
    for (int i = 0; i < N * N; i++) {
        float gap = low + l->below[i] * range, a = 1 - (gap > 0 ? gap : 0) * reach;
        near[i] = far[i] = l->below[i] < 1 && a > 0 ? a * a : 0;
    }
    for (int pass = 0; pass < 2; pass++) {
        blur_box(near, l->scratch, N, texels_of(0.16 * s->typical, texel));
        blur_box(far, l->scratch, N, texels_of(0.80 * s->typical, texel));
    }
    for (int i = 0; i < N * N; i++)
        near[i] = 1 / (1 + 1.6f * near[i] + 1.3f * far[i]);
}

/* ---- the sun on the floor ---------------------------------------------- */

enum { SQUARE = 16 };       /* texels */

/* One row of the floor in the sun map: place (u, v) in texels and depth, at texel 0 and per texel; scene units a depth. */
typedef struct SunRow { float u, v, depth, du, dv, ddepth, range; } SunRow;

/* The texels [first, last) of a row for which start + i step lies in [0, end). */
static void clip_row(float start, float step, float end, int *first, int *last)
{
    if (fabsf(step) < 1e-9f) {
        if (!(start >= 0 && start < end))
            *last = *first;
        return;
    }
    float a = -start / step, b = (end - start) / step, low = a < b ? a : b, high = a < b ? b : a;
    if (low > (float)*first)
        *first = low >= (float)*last ? *last : (int)ceilf(low);
    if (high < (float)*last)
        *last = high <= (float)*first ? *first : (int)floorf(high);
}

/* The least depth of each square of SQUARE x SQUARE texels of the sun map. */
LANE_CODE void find_least(const float *sun, float *least)
{
    enum { M = SUN_SIZE, SQUARES = M / SQUARE };
    for (int j = 0; j < SQUARES; j++) {
        float column[M];
        memcpy(column, sun + (size_t)j * SQUARE * M, sizeof column);
        for (int k = 1; k < SQUARE; k++)
            for (int i = 0; i < M; i++) {
                float z = sun[((size_t)j * SQUARE + (size_t)k) * M + (size_t)i];
                column[i] = z < column[i] ? z : column[i];
            }
        for (int i = 0; i < SQUARES; i++) {
            float z = column[i * SQUARE];
            for (int k = 1; k < SQUARE; k++)
                z = column[i * SQUARE + k] < z ? column[i * SQUARE + k] : z;
            least[j * SQUARES + i] = z;
        }
    }
}

/* Whether nothing in the sun map can hide the texels [first, last) of a row: all of the map round them lies deeper. */
LANE_CODE bool lies_open(const Light *l, const SunRow *r, int first, int last, float bias)
{
    enum { SQUARES = SUN_SIZE / SQUARE };
    float a = (float)first, b = (float)(last - 1), u0 = r->u + r->du * a, u1 = r->u + r->du * b, v0 = r->v + r->dv * a, v1 = r->v + r->dv * b;
    float z0 = r->depth + r->ddepth * a, z1 = r->depth + r->ddepth * b, deepest = z0 > z1 ? z0 : z1;
    deepest = (deepest < 1 ? deepest : 1) - 0.5f * bias;        /* half: rounding must not decide */
    int left = (int)(u0 < u1 ? u0 : u1) / SQUARE, right = ((int)(u0 < u1 ? u1 : u0) + 2) / SQUARE;
    int low = (int)(v0 < v1 ? v0 : v1) / SQUARE, high = ((int)(v0 < v1 ? v1 : v0) + 2) / SQUARE;
    for (int j = int_max(low, 0); j <= int_min(high, SQUARES - 1); j++)
        for (int i = int_max(left, 0); i <= int_min(right, SQUARES - 1); i++)
            if (l->least[j * SQUARES + i] < deepest)
                return false;
    return true;
}

/* Share of the sun hidden at each texel [first, last) of a row (shade), and that times the distance of what hides it (gap); up to SQUARE. */
LANE_CODE void project_texels(const Light *l, const SunRow *r, int first, int last, float bias, float *shade, float *gap)
{
    enum { M = SUN_SIZE };
    float u[SQUARE], v[SQUARE], z[SQUARE], near[4][SQUARE];
    int at[SQUARE];
    for (int i = 0; i < SQUARE; i++) {
        float k = (float)(first + i), x = r->u + r->du * k, y = r->v + r->dv * k, depth = r->depth + r->ddepth * k;
        int column = (int)x, row = (int)y;
        at[i] = row * M + column;
        u[i] = x - (float)column;
        v[i] = y - (float)row;
        z[i] = (depth < 1 ? depth : 1) - bias;      /* the map's floor is at 1: nothing there */
    }
    for (int i = 0; i < SQUARE; i++) {
        const float *d = l->sun + at[first + i < last ? i : 0];
        near[0][i] = d[0];
        near[1][i] = d[1];
        near[2][i] = d[M];
        near[3][i] = d[M + 1];
    }
    float some[SQUARE], far[SQUARE];
    for (int i = 0; i < SQUARE; i++) {
        float o0 = z[i] - near[0][i], o1 = z[i] - near[1][i], o2 = z[i] - near[2][i], o3 = z[i] - near[3][i];
        float w0 = o0 > 0 ? (1 - u[i]) * (1 - v[i]) : 0, w1 = o1 > 0 ? u[i] * (1 - v[i]) : 0;
        float w2 = o2 > 0 ? (1 - u[i]) * v[i] : 0, w3 = o3 > 0 ? u[i] * v[i] : 0;
        some[i] = w0 + w1 + w2 + w3;
        far[i] = (w0 * o0 + w1 * o1 + w2 * o2 + w3 * o3) * r->range;
    }
    memcpy(shade + first, some, (size_t)(last - first) * sizeof *some);
    memcpy(gap + first, far, (size_t)(last - first) * sizeof *far);
}

LANE_CODE void project_row(const Light *l, const SunRow *r, float *shade, float *gap)
{
    enum { N = FLOOR_SIZE, M = SUN_SIZE };
    const float bias = (float)BIAS / r->range;
    int first = 0, last = N;
    clip_row(r->u, r->du, M - 1.01f, &first, &last);
    clip_row(r->v, r->dv, M - 1.01f, &first, &last);
    memset(shade, 0, N * sizeof *shade);
    memset(gap, 0, N * sizeof *gap);
    for (int i = first; i < last; i += SQUARE) {
        int end = int_min(i + SQUARE, last);
        if (!lies_open(l, r, i, end, bias))
            project_texels(l, r, i, end, bias, shade, gap);
    }
}

LANE_CODE void project_shadows(Light *l, const Stage *s, const Ground *g, const float m[16], vec3 eye, real range)
{
    enum { N = FLOOR_SIZE, M = SUN_SIZE };
    find_least(l->sun, l->least);
    float step = (float)(2 * g->half / N), x = (float)(g->x - g->half - eye.x) + 0.5f * step, z = (float)(s->floor - eye.z);
    for (int j = 0; j < N; j++) {
        float y = (float)(g->y - g->half - eye.y) + step * ((float)j + 0.5f), p[3];
        for (int k = 0; k < 3; k++)
            p[k] = m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k];
        SunRow row = {p[0] * M - 0.5f, p[1] * M - 0.5f, p[2], m[0] * step * M, m[1] * step * M, m[2] * step, (float)range};
        project_row(l, &row, l->shade + j * N, l->gap + j * N);
    }
}

/* Means of 2 x 2 texels: FLOOR_SIZE^2 to HEIGHT_SIZE^2. */
LANE_CODE void halve(const float *in, float *out)
{
    enum { N = HEIGHT_SIZE, M = FLOOR_SIZE };
    for (int j = 0; j < N; j++) {
        const float *a = in + 2 * j * M, *b = a + M;
        for (int i = 0; i < N; i++)
            out[j * N + i] = 0.25f * ((a[2 * i] + a[2 * i + 1]) + (b[2 * i] + b[2 * i + 1]));
    }
}

/* Makes three softnesses of the shadow: shade and mid at full fineness, wide at half, and there also how wide the edges
 * should be (blur), from the mean distance of what throws it. */
LANE_CODE void soften_shadows(Light *l, const Ground *g)
{
    enum { N = FLOOR_SIZE, M = HEIGHT_SIZE };
    real texel = 2 * g->half / N;
    int mid = (int)real_clamp(MID_BLUR / texel + 0.5, 1, 40), wide = (int)real_clamp(0.5 * WIDE_BLUR / texel + 0.5, 2, 60);
    memcpy(l->mid, l->shade, N * N * sizeof *l->mid);
    blur_box(l->shade, l->scratch, N, 1);
    blur_box(l->mid, l->scratch, N, mid);
    blur_box(l->mid, l->scratch, N, int_max(1, mid / 2));
    halve(l->mid, l->wide);
    halve(l->gap, l->blur);
    blur_box(l->wide, l->scratch, M, wide);
    blur_box(l->wide, l->scratch, M, int_max(1, wide / 2));
    blur_box(l->blur, l->scratch, M, int_max(1, mid / 2));
    blur_box(l->blur, l->scratch, M, wide);
    blur_box(l->blur, l->scratch, M, int_max(1, wide / 2));
    for (int i = 0; i < M * M; i++)
        l->blur[i] = (float)SPREAD * l->blur[i] / (l->wide[i] + 1e-4f);
}

/* 0..1 to 0..255; what lies outside is cut off */
LANE_CODE int to_level(float x)
{
    x = x > 0 ? x : 0;
    return (int)((x < 1 ? x : 1) * 255 + 0.5f);
}

/* A half-fine row to full fineness. Texel i lies between those of (i - 1) / 2; the outermost go on as straight lines. */
LANE_CODE void widen_row(const float *in, float *out)
{
    enum { M = HEIGHT_SIZE };
    out[0] = in[0] - 0.25f * (in[1] - in[0]);
    out[2 * M - 1] = in[M - 1] + 0.25f * (in[M - 1] - in[M - 2]);
    for (int k = 0; k + 1 < M; k++) {
        out[2 * k + 1] = in[k] + 0.25f * (in[k + 1] - in[k]);
        out[2 * k + 2] = in[k] + 0.75f * (in[k + 1] - in[k]);
    }
}

/* Row j of a half-fine field at full fineness. */
LANE_CODE void widen(const float *field, int j, float *out)
{
    enum { M = HEIGHT_SIZE };
    float row[M];
    int b = int_max(0, int_min(M - 2, (j - 1) / 2));
    float t = 0.5f * (float)j - 0.25f - (float)b;
    const float *low = field + b * M, *high = low + M;
    for (int i = 0; i < M; i++)
        row[i] = low[i] + t * (high[i] - low[i]);
    widen_row(row, out);
}

/* The share of the sun hidden along row j: the three softnesses blended by how wide the edges should be. */
LANE_CODE void blend_shadows(const Light *l, int j, float *out)
{
    enum { N = FLOOR_SIZE };
    const float to_mid = (float)(1 / MID_BLUR), to_wide = (float)(1 / (WIDE_BLUR - MID_BLUR)), start = (float)MID_BLUR;
    const float *shade = l->shade + j * N, *mid = l->mid + j * N;
    float wide[N], blur[N];
    widen(l->wide, j, wide);
    widen(l->blur, j, blur);
    for (int i = 0; i < N; i++) {
        float soft = blur[i] * to_mid, softer = (blur[i] - start) * to_wide;
        soft = soft < 1 ? soft : 1;
        softer = softer > 0 ? softer : 0;
        softer = softer < 1 ? softer : 1;
        float hidden = shade[i] + soft * (mid[i] - shade[i]);
        out[i] = hidden + softer * (wide[i] - hidden);
    }
}

/* Sun, sky and marbling side by side into the floor map. The marbling is fixed to the world and fades out towards the rim;
 * the rim itself is unshaded, so that the map ends without a seam. */
LANE_CODE void pack_floor(Light *l, const Ground *g, bool sunny)
{
    enum { N = FLOOR_SIZE };
    float hidden[N] = {0}, sky[N];
    int fade[N];
    for (int i = 0; i < N; i++)
        fade[i] = int_min(64, int_min(i, N - 1 - i));
    for (int j = 0; j < N; j++) {
        if (sunny)
            blend_shadows(l, j, hidden);
        widen(l->sky, j, sky);
        const unsigned char *marble = l->marble + (size_t)((j + g->row) & (N - 1)) * N;
        uint32_t *row = l->texels + (size_t)N * (size_t)j;
        int turned[N];      /* the marbling, which repeats */
        for (int i = 0; i < N - g->column; i++)
            turned[i] = marble[g->column + i];
        for (int i = N - g->column; i < N; i++)
            turned[i] = marble[g->column + i - N];
        for (int i = 0; i < N; i++) {
            int edge = fade[i] < fade[j] ? fade[i] : fade[j];
            float lost = 1 - sky[i];
            int sun = to_level((1 - hidden[i]) * (1 - CONTACT * lost * lost)), seen = to_level(sky[i]), mark = 128 + (turned[i] - 128) * edge / 64;
            sun = edge > 0 ? sun : 255;
            seen = edge > 0 ? seen : 255;
            row[i] = (uint32_t)sun << RED_SHIFT | (uint32_t)seen << GREEN_SHIFT | (uint32_t)mark << BLUE_SHIFT | 255u << ALPHA_SHIFT;
        }
    }
}

#endif
