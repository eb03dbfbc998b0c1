/* render/light.c - works out what the sun and the sky reach. */
#include "render/floor_light.h"

#include <stdio.h>
#include <stdlib.h>

static const float SLOPE = 1.5f;          /* texels of steepness by which the sun map lies behind its surfaces         */
static const real FOOT = 0.9;           /* typical radii up to which the floor's own shade lies on what stands on it    */

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
