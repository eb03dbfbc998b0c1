/* render/light.c - works out what the sun and the sky reach. */
#include "render/light.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/wide.h"

static const real BIAS = 0.0015;        /* scene units by which a thing must lie behind another to be in its shadow   */
static const float SLOPE = 1.5f;          /* texels of steepness by which the sun map lies behind its surfaces         */
static const real SPREAD = 0.09;        /* rad, how fast a shadow's edge widens: a hazy sun, wider than the real one */
static const real FOOT = 0.9;           /* typical radii up to which the floor's own shade lies on what stands on it    */
static const float CONTACT = 0.9f;      /* how much of the sun's wide glow is lost where the sky is: what touches the floor stands on it */
static const real MID_BLUR = 0.022, WIDE_BLUR = 0.085;      /* scene units, half widths of the softer shadows     */

/* ---- textures --------------------------------------------------------- */

static GLuint make_texture(const Gl *gl, GLint format, GLenum layout, GLenum type, int size, GLint filter)
{
    GLuint name = 0;
    gl->GenTextures(1, &name);
    gl->BindTexture(GL_TEXTURE_2D, name);
    gl->TexImage2D(GL_TEXTURE_2D, 0, format, size, size, 0, layout, type, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return name;
}

dig_status light_open(Light *l, const Gl *gl, char *why, size_t capacity)
{
    enum { HEIGHTS = HEIGHT_SIZE * HEIGHT_SIZE, FLOORS = FLOOR_SIZE * FLOOR_SIZE, SUNS = SUN_SIZE * SUN_SIZE };
    l->sun_map = make_texture(gl, GL_RG32F, GL_RG, GL_FLOAT, SUN_SIZE, GL_LINEAR);
    l->height_map = make_texture(gl, GL_RG32F, GL_RG, GL_FLOAT, HEIGHT_SIZE, GL_LINEAR);
    l->floor_map = make_texture(gl, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, FLOOR_SIZE, GL_LINEAR);
    l->sun = malloc(SUNS * sizeof *l->sun);
    l->moments = calloc(2 * SUNS, sizeof *l->moments);
    /* zeroed: the shadow fields are read, with no weight, even when there is no sun */
    l->above = calloc(8 * HEIGHTS, sizeof *l->above);
    l->shade = calloc(4 * (size_t)FLOORS, sizeof *l->shade);
    l->texels = calloc(FLOORS, sizeof *l->texels);
    l->marble = malloc(FLOORS);
    if (!l->sun || !l->moments || !l->above || !l->shade || !l->texels || !l->marble) {
        snprintf(why, capacity, "no memory for the light maps");
        return DIG_E_MEMORY;
    }
    l->below = l->above + HEIGHTS;
    l->sky = l->below + HEIGHTS;
    l->wide = l->sky + HEIGHTS;
    l->blur = l->wide + HEIGHTS;
    l->heights = l->blur + HEIGHTS;
    l->spare = l->heights + 2 * (size_t)HEIGHTS;
    l->mid = l->shade + FLOORS;
    l->gap = l->mid + FLOORS;
    l->scratch = l->gap + FLOORS;
    marble_fill(l->marble, FLOOR_SIZE);
    return DIG_OK;
}

void light_close(Light *l, const Gl *gl)
{
    GLuint textures[] = {l->sun_map, l->height_map, l->floor_map};
    gl->DeleteTextures(3, textures);
    cast_close(&l->casters);
    free(l->sun);
    free(l->moments);
    free(l->above);
    free(l->shade);
    free(l->texels);
    free(l->marble);
    *l = (Light){0};
}

/* ---- where the maps lie ------------------------------------------------ */

typedef struct Ground {         /* the square that the height and floor maps cover, scene units */
    real x, y, half;
    real low, high;             /* z that the heights tell apart */
    int  row, column;           /* of the world's grid of floor texels, at the map's first */
} Ground;

/* Moves x (scene units; `at` m is where scene 0 lies on that axis) to a whole number of texels of the world, so that
 * shadows do not swim when the scene's middle moves. */
static real snap(real x, real at, real texel, real unit)
{
    real texels = (at / unit + x) / texel;
    return x + (round(texels) - texels) * texel;
}

/* x in texels, wrapped to one repeat of the marbling. */
static int grid_index(real x, real texel) { return (int)(fmod(round(x / texel), FLOOR_SIZE) + FLOOR_SIZE) % FLOOR_SIZE; }

static Ground find_ground(const Stage *s, vec3 sun)
{
    vec3 low = s->low, high = s->high;
    real fall = sun.z > 0.05 ? real_min(2, (s->high.z - s->floor) / sun.z) : 0;     /* how far shadows reach */
    low.x += real_min(0, -sun.x * fall);
    low.y += real_min(0, -sun.y * fall);
    high.x += real_max(0, -sun.x * fall);
    high.y += real_max(0, -sun.y * fall);
    real half = 0.53 * real_max(high.x - low.x, high.y - low.y) + 1.5 * s->typical;
    half = exp2(ceil(4 * log2(half)) / 4);
    vec3 at = mat3_mul_vec(s->axes, s->centre);
    real texel = 2 * half / HEIGHT_SIZE;
    Ground g = {.x = snap(0.5 * (low.x + high.x), at.x, texel, s->unit), .y = snap(0.5 * (low.y + high.y), at.y, texel, s->unit),
                .half = half, .low = s->floor - 0.01, .high = real_max(s->high.z, s->floor) + 0.5};
    g.column = grid_index(at.x / s->unit + g.x, 0.5 * texel);
    g.row = grid_index(at.y / s->unit + g.y, 0.5 * texel);
    return g;
}

void light_ground(const Stage *s, vec3 sun, real *x, real *y, real *half)
{
    Ground g = find_ground(s, sun);
    *x = g.x;
    *y = g.y;
    *half = g.half;
}

/* Column-major matrix with these rows. */
static void set_rows(float m[16], const vec3 row[3], const real last[3])
{
    for (int i = 0; i < 3; i++) {
        m[i] = (float)row[i].x;
        m[4 + i] = (float)row[i].y;
        m[8 + i] = (float)row[i].z;
        m[12 + i] = (float)last[i];
    }
    m[3] = m[7] = m[11] = 0;
    m[15] = 1;
}

/* The span along the sun that holds what matters; *half of it, about the returned middle. */
static real find_span(const Stage *s, vec3 sun, real *half)
{
    real low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 8; i++) {
        vec3 p = {i & 1 ? s->high.x : s->low.x, i & 2 ? s->high.y : s->low.y, i & 4 ? s->high.z : s->low.z};
        low = real_min(low, vec3_dot(p, sun));
        high = real_max(high, vec3_dot(p, sun));
    }
    *half = exp2(ceil(4 * log2(0.51 * (high - low) + 0.02)) / 4);
    return 0.5 * (low + high);
}

/* Points relative to the eye into the clip space of the sun map. Returns half the span that depths 0..1 cover. */
static real sun_matrix(float m[16], const Stage *s, vec3 sun, vec3 eye)
{
    real half, middle = find_span(s, sun, &half);
    vec3 t, u, at = mat3_mul_vec(s->axes, s->centre);
    vec3_basis(sun, &t, &u);
    real texel = 2.0 / SUN_SIZE;
    vec3 row[3] = {t, u, vec3_scale(-1 / half, sun)};
    real shift_t = snap(0, vec3_dot(at, t), texel, s->unit), shift_u = snap(0, vec3_dot(at, u), texel, s->unit);
    real last[3] = {vec3_dot(t, eye) - shift_t, vec3_dot(u, eye) - shift_u,
                    (middle - vec3_dot(sun, eye)) / half};
    set_rows(m, row, last);
    return half;
}

/* Seen from above. */
static void height_matrix(float m[16], const Ground *g, vec3 eye)
{
    real middle = 0.5 * (g->high + g->low), half = 0.5 * (g->high - g->low);
    vec3 row[3] = {{1 / g->half, 0, 0}, {0, 1 / g->half, 0}, {0, 0, -1 / half}};
    real last[3] = {(eye.x - g->x) / g->half, (eye.y - g->y) / g->half, -(eye.z - middle) / half};
    set_rows(m, row, last);
}

static void clip_to_unit(float out[16], const float in[16])
{
    for (int i = 0; i < 16; i++)
        out[i] = 0.5f * in[i] + (i % 4 == 3 ? 0.5f * in[i] : 0.5f * in[i - i % 4 + 3]);
}

/* ---- heights ---------------------------------------------------------- */

/* Depth = plane[0] + plane[1] i + plane[2] j of the floor at texel (i, j) of the sun map; no floor, or the sun too low: 1 everywhere. */
static void floor_depth(float plane[3], const Stage *s, const float to_map[16], real floor)
{
    /* the map's rows are at right angles; the third is the sun's, as long as one depth */
    vec3 row[3];
    for (int i = 0; i < 3; i++)
        row[i] = (vec3){(real)to_map[i], (real)to_map[4 + i], (real)to_map[8 + i]};
    real square = vec3_length2(row[2]), slope = row[2].z / square;
    plane[0] = 1;
    plane[1] = plane[2] = 0;
    if (s->floor_item < 0 || !(row[2].z < -0.05 * sqrt(square)))
        return;
    /* p = x row0 + y row1 + t row2 / square lies on the floor: z = floor */
    real texel = 2.0 / SUN_SIZE, x = 0.5 * texel - 1 - (real)to_map[12], y = 0.5 * texel - 1 - (real)to_map[13];
    real depth = (floor - x * row[0].z - y * row[1].z) / slope + (real)to_map[14];
    plane[0] = (float)(0.5 + 0.5 * depth);
    plane[1] = (float)(-0.5 * texel * row[0].z / slope);
    plane[2] = (float)(-0.5 * texel * row[1].z / slope);
}

/* Row j of the depths that bodies are compared with: what is not hit lies on the floor, or at the far end; less a half for precision. */
LANE_CODE void centre_depths(const float *row, int j, const float plane[3], float *out)
{
    float start = plane[0] + plane[2] * (float)j;
    for (int i = 0; i < SUN_SIZE; i++) {
        float far = start + plane[1] * (float)i, z = row[i];
        far = far < 1 ? far : 1;
        out[i] = (z < far ? z : far) - 0.5f;
    }
}

/* Weights 1, 2, 1 both ways, for depths and for their squares. The rim is left out: it stays at the far end. */
LANE_CODE void smooth_moments(const float *depth, float *moments)
{
    enum { N = SUN_SIZE };
    for (int j = 0; j < N; j++) {
        const float *b = depth + j * N, *a = j > 0 ? b - N : b, *c = j + 1 < N ? b + N : b;
        float one[N], two[N], *to = moments + 2 * j * N;
        for (int i = 0; i < N; i++) {
            one[i] = 0.0625f * (a[i] + 2 * b[i] + c[i]);
            two[i] = 0.0625f * (a[i] * a[i] + 2 * b[i] * b[i] + c[i] * c[i]);
        }
        for (int i = 1; i + 1 < N; i++) {
            to[2 * i] = one[i - 1] + 2 * one[i] + one[i + 1];
            to[2 * i + 1] = two[i - 1] + 2 * two[i] + two[i + 1];
        }
        to[0] = to[2 * N - 2] = 0.5f;
        to[1] = to[2 * N - 1] = 0.25f;
    }
    for (int i = 0; i < N; i++) {
        moments[2 * i] = moments[2 * (N * (N - 1) + i)] = 0.5f;
        moments[2 * i + 1] = moments[2 * (N * (N - 1) + i) + 1] = 0.25f;
    }
}

LANE_CODE void fill_moments(Light *l, const float *depth)
{
    for (int j = 0; j < SUN_SIZE; j++)
        centre_depths(depth + j * SUN_SIZE, j, l->floor_plane, l->scratch + j * SUN_SIZE);
    smooth_moments(l->scratch, l->moments);
}

static void cast_sun(Light *l, const Stage *s, const float to_map[16], real floor)
{
    cast_clear(l->sun, SUN_SIZE);
    cast_nearest(&l->casters, to_map, SUN_SIZE, SLOPE, l->sun);
    floor_depth(l->floor_plane, s, to_map, floor);
    memcpy(l->sun_clip, to_map, sizeof l->sun_clip);
}

_Static_assert(FLOOR_SIZE >= SUN_SIZE, "light_receive keeps depths in a field of the floor's");

dig_status light_receive(Light *l, const Gl *gl, const DrawItem *d, const Meshes *meshes)
{
    DIG_TRY(cast_gather_one(&l->casters, d, meshes));
    memcpy(l->mid, l->sun, SUN_SIZE * SUN_SIZE * sizeof *l->mid);       /* free once the floor's map is packed */
    cast_nearest(&l->casters, l->sun_clip, SUN_SIZE, SLOPE, l->mid);
    fill_moments(l, l->mid);
    gl->BindTexture(GL_TEXTURE_2D, l->sun_map);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SUN_SIZE, SUN_SIZE, GL_RG, GL_FLOAT, l->moments);
    return DIG_OK;
}

static int texels_of(real length, real texel) { return (int)real_clamp(length / texel + 0.5, 1, HEIGHT_SIZE / 4); }

/* For bodies: heights smoothed over a small and a large width. */
LANE_CODE void fill_heights(Light *l, const Stage *s, const Ground *g)
{
    enum { N = HEIGHT_SIZE };
    float range = (float)(g->high - g->low), high = (float)g->high, floor = (float)s->floor;
    float *near = l->sky, *far = l->wide;
    real texel = 2 * g->half / N;
    for (int i = 0; i < N * N; i++)
        near[i] = l->above[i] < 1 ? high - l->above[i] * range : floor;
    for (int i = 0; i < N; i++)         /* the rim */
        near[i] = near[N * (N - 1) + i] = near[N * i] = near[N * i + N - 1] = floor;
    memcpy(far, near, N * N * sizeof *far);
    for (int pass = 0; pass < 2; pass++) {
        blur_box(near, l->scratch, N, texels_of(0.22 * s->typical, texel));
        blur_box(far, l->scratch, N, texels_of(0.75 * s->typical, texel));
    }
    for (int i = 0; i < N * N; i++) {
        l->heights[2 * i] = near[i];
        l->heights[2 * i + 1] = far[i];
    }
}

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

static void set_shading(Frame *f, const Stage *s, const Ground *g)
{
    f->top[0] = (float)(0.5 / g->half);
    f->top[1] = (float)(0.5 / g->half * 0.45 * s->typical);
    f->top[2] = (float)(0.5 - 0.5 * g->x / g->half);
    f->top[3] = (float)(0.5 - 0.5 * g->y / g->half);
    f->shade[0] = (float)(0.30 / s->typical);
    f->shade[1] = (float)(0.28 / s->typical);
    f->shade[2] = (float)s->floor;
    f->shade[3] = (float)(2.5 * s->typical);
    f->ground[3] = (float)(s->floor_item >= 0 ? 1 / (FOOT * s->typical) : 1e6);
}

/* What the depths of casters in l->sun, l->above and l->below say. */
typedef struct LightJob {
    const Stage  *stage;
    const Ground *ground;
    vec3          eye;
    real          range;                        /* scene units that depths 0..1 of the sun map cover */
    bool          shadows, floor, floor_shadow;
} LightJob;

LANE_CODE void fill_maps(Light *l, const LightJob *job, const Frame *frame)
{
    if (job->shadows)
        fill_moments(l, l->sun);
    fill_heights(l, job->stage, job->ground);
    if (!job->floor)
        return;
    hide_sky(l, job->stage, job->ground);
    if (job->floor_shadow) {
        project_shadows(l, job->stage, job->ground, frame->to_sun, job->eye, job->range);
        soften_shadows(l, job->ground);
    }
    pack_floor(l, job->ground, job->floor_shadow);
}

static void fill_plainly(Light *l, const LightJob *job, const Frame *frame) { fill_maps(l, job, frame); }
WIDE static void fill_widely(Light *l, const LightJob *job, const Frame *frame) { fill_maps(l, job, frame); }

dig_status light_cast(Light *l, const Batches *b, const Meshes *meshes, const Stage *s, bool shadows, Frame *frame)
{
    vec3 eye = vec3_from(frame->eye), sun = vec3_from(frame->sun);
    Ground ground = find_ground(s, sun);
    bool floor = s->floor_item >= 0, floor_shadow = floor && shadows && sun.z > 0.02;
    float to_map[16];
    DIG_TRY(cast_gather(&l->casters, b, meshes, 1));
    real half = sun_matrix(to_map, s, sun, eye);
    clip_to_unit(frame->to_sun, to_map);
    if (shadows)
        cast_sun(l, s, to_map, s->floor - eye.z);
    height_matrix(to_map, &ground, eye);
    cast_heights(&l->casters, to_map, HEIGHT_SIZE, l->above, l->below);
    set_shading(frame, s, &ground);
    frame->sun[3] = (float)(0.5 * BIAS / half);
    frame->sun_colour[3] = frame->sun[3] * frame->sun[3];
    LightJob job = {s, &ground, eye, 2 * half, shadows, floor, floor_shadow};
    (has_wide() ? fill_widely : fill_plainly)(l, &job, frame);
    return DIG_OK;
}

void light_upload(const Light *l, const Gl *gl)
{
    gl->BindTexture(GL_TEXTURE_2D, l->sun_map);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SUN_SIZE, SUN_SIZE, GL_RG, GL_FLOAT, l->moments);
    gl->BindTexture(GL_TEXTURE_2D, l->height_map);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, HEIGHT_SIZE, HEIGHT_SIZE, GL_RG, GL_FLOAT, l->heights);
    gl->BindTexture(GL_TEXTURE_2D, l->floor_map);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, FLOOR_SIZE, FLOOR_SIZE, GL_RGBA, GL_UNSIGNED_BYTE, l->texels);
}
