/* render/block_light.h - the light that the things a block shows throw back: the light of shaders.c, lane by lane.
 *
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_BLOCK_LIGHT_H
#define DIG_BLOCK_LIGHT_H

#include "render/block.h"
#include "render/program.h"
#include "render/shade.h"

typedef float float4 __attribute__((vector_size(16)));

/* ---- maps ----------------------------------------------------------------- */

/* Where lanes fall on a map: the first of four texels, and the shares of its right and upper neighbours. */
typedef struct Spots { int32_t first[LANES]; float u[LANES], v[LANES]; } Spots;

/* o->u, o->v: in texels, middles at whole numbers; beyond the rim the rim counts. */
LANE_CODE void settle_on(Spots *o, int n, int width, int height)
{
    const float right = (float)width - 1.001f, top = (float)height - 1.001f;
    for (int i = 0; i < n; i++) {
        o->u[i] = least(most(o->u[i], 0), right);
        o->v[i] = least(most(o->v[i], 0), top);
    }
    for (int i = 0; i < n; i++) {           /* apart, or compilers branch where a coordinate is limited */
        int32_t column = (int32_t)o->u[i], row = (int32_t)o->v[i];
        o->first[i] = row * width + column;
        o->u[i] -= (float)column;
        o->v[i] -= (float)row;
    }
}

LANE_CODE void settle(Spots *o, int n, int size) { settle_on(o, n, size, size); }

LANE_CODE bool any_on_map(const Spots *o, int n, int size)
{
    int32_t on = 0;
    for (int i = 0; i < n; i++)
        on |= (o->u[i] > 0) & (o->u[i] < (float)size - 1) & (o->v[i] > 0) & (o->v[i] < (float)size - 1);
    return on != 0;
}

/* Two values a texel, side by side. */
LANE_CODE void fetch_pairs(const float *map, int size, const Spots *o, int n, float *a, float *b)
{
    float pairs[2 * LANES];
    for (int i = 0; i < n; i++) {
        float4 low, high;
        const float *from = map + 2 * (size_t)o->first[i], v = o->v[i], u = o->u[i];
        memcpy(&low, from, sizeof low);
        memcpy(&high, from + 2 * (size_t)size, sizeof high);
        float4 both = low + (high - low) * (float4){v, v, v, v}, right = __builtin_shufflevector(both, both, 2, 3, 2, 3);
        both += (right - both) * (float4){u, u, u, u};
        memcpy(pairs + 2 * i, &both, 2 * sizeof *pairs);
    }
    for (int i = 0; i < n; i++) {
        a[i] = pairs[2 * i];
        b[i] = pairs[2 * i + 1];
    }
}

/* The first three bytes of a texel, 0..1. */
LANE_CODE void fetch_bytes(const uint32_t *map, int size, const Spots *o, int n, float *const out[3])
{
    static const int shift[3] = {RED_SHIFT, GREEN_SHIFT, BLUE_SHIFT};
    uint32_t low[2 * LANES], high[2 * LANES];
    for (int i = 0; i < n; i++) {
        const uint32_t *from = map + o->first[i];
        memcpy(low + 2 * i, from, 2 * sizeof *low);
        memcpy(high + 2 * i, from + size, 2 * sizeof *high);
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            float p = (float)(int32_t)(low[2 * i] >> shift[k] & 255), q = (float)(int32_t)(low[2 * i + 1] >> shift[k] & 255);
            float r = (float)(int32_t)(high[2 * i] >> shift[k] & 255), t = (float)(int32_t)(high[2 * i + 1] >> shift[k] & 255);
            out[k][i] = blend(blend(p, q, o->u[i]), blend(r, t, o->u[i]), o->v[i]) * (1.0f / 255);
        }
}

/* ---- what arrives --------------------------------------------------------- */

LANE_CODE float row_of(const float row[4], float x, float y, float z) { return row[0] * x + (row[1] * y + (row[2] * z + row[3])); }

/* Share of the sun, by Chebyshev's inequality from the moments of the depths. */
LANE_CODE void reach_sun(const Subject *s, const Light *l, const Frame *f, Block *b)
{
    Spots o;
    float first[LANES], second[LANES];
    const float least_spread = f->sun_colour[3];
    for (int i = 0; i < b->n; i++) {
        o.u[i] = row_of(s->to_sun[0], b->px[i], b->py[i], b->pz[i]);
        o.v[i] = row_of(s->to_sun[1], b->px[i], b->py[i], b->pz[i]);
    }
    settle(&o, b->n, SUN_SIZE);
    fetch_pairs(l->moments, SUN_SIZE, &o, b->n, first, second);
    for (int i = 0; i < b->n; i++) {
        float z = least(row_of(s->to_sun[2], b->px[i], b->py[i], b->pz[i]), 0.5f);      /* beyond the map's far end: as at it, lit */
        float behind = most(z - first[i], 0);
        float spread = most(second[i] - first[i] * first[i], least_spread);
        b->lit[i] = unit_range(1.25f * spread / (spread + behind * behind) - 0.25f);
    }
}

/* Share of the sky: columns of the height map stand in the way. */
LANE_CODE void reach_sky(const Subject *s, const Light *l, const Frame *f, Block *b)
{
    Spots o;
    float near[LANES], wide[LANES];
    const float off = f->top[1] * HEIGHT_SIZE, highest = f->shade[3], near_weight = f->shade[0], wide_weight = f->shade[1];
    const float floor = f->shade[2], foot = f->ground[3];
    for (int i = 0; i < b->n; i++) {
        float nx = b->nx[i], ny = b->ny[i], nz = b->nz[i], x = b->px[i], y = b->py[i], z = b->pz[i];
        float u = row_of(s->to_top[0], x, y, z), v = row_of(s->to_top[1], x, y, z);
        o.u[i] = u * HEIGHT_SIZE - 0.5f + off * (s->east[0] * nx + (s->east[1] * ny + s->east[2] * nz));
        o.v[i] = v * HEIGHT_SIZE - 0.5f + off * (s->north[0] * nx + (s->north[1] * ny + s->north[2] * nz));
    }
    settle(&o, b->n, HEIGHT_SIZE);
    fetch_pairs(l->heights, HEIGHT_SIZE, &o, b->n, near, wide);
    for (int i = 0; i < b->n; i++) {
        float z = row_of(s->to_top[2], b->px[i], b->py[i], b->pz[i]);
        float a = least(most(near[i] - z, 0), highest), c = least(most(wide[i] - z, 0), highest);
        float low = unit_range(1 - (z - floor) * foot), down = 0.2f - 0.2f * (s->up[0] * b->nx[i] + (s->up[1] * b->ny[i] + s->up[2] * b->nz[i]));
        b->sky[i] = (1 - low * low * down) / (1 + near_weight * a + wide_weight * c);
    }
}

/* The floor's map has both, and a marbling. */
LANE_CODE void reach_floor(const Subject *s, const Light *l, Block *b)
{
    Spots o;
    float marble[LANES];
    for (int i = 0; i < b->n; i++) {
        o.u[i] = row_of(s->to_top[0], b->px[i], b->py[i], b->pz[i]) * FLOOR_SIZE - 0.5f;
        o.v[i] = row_of(s->to_top[1], b->px[i], b->py[i], b->pz[i]) * FLOOR_SIZE - 0.5f;
    }
    if (any_on_map(&o, b->n, FLOOR_SIZE)) {
        settle(&o, b->n, FLOOR_SIZE);
        fetch_bytes(l->texels, FLOOR_SIZE, &o, b->n, (float *const[3]){b->lit, b->sky, marble});
    } else {                /* as on its rim */
        for (int i = 0; i < b->n; i++) {
            b->lit[i] = b->sky[i] = 1;
            marble[i] = 128.0f / 255;
        }
    }
    for (int i = 0; i < b->n; i++) {
        float factor = 0.90f + 0.20f * marble[i];
        b->red[i] *= factor;
        b->green[i] *= factor;
        b->blue[i] *= factor;
    }
}

LANE_CODE void reach(const Subject *s, const Light *l, const Frame *f, Block *b)
{
    if (s->floor) {
        reach_floor(s, l, b);
        return;
    }
    for (int i = 0; i < b->n; i++)
        b->lit[i] = 1;
    if (s->shadows)
        reach_sun(s, l, f, b);
    reach_sky(s, l, f, b);
}

/* ---- what is thrown back --------------------------------------------------- */

/* GGX with its masking folded in (after Karis 2013), less the reflectance; l: unit, towards the light, v: towards the eye. */
LANE_CODE float gloss(float nx, float ny, float nz, float vx, float vy, float vz, float lx, float ly, float lz, float a2, float flat)
{
    float hx = lx + vx, hy = ly + vy, hz = lz + vz, scale = 1 / sqrtf(hx * hx + (hy * hy + hz * hz) + 1e-20f);
    float nh = most((nx * hx + (ny * hy + nz * hz)) * scale, 0), lh = (lx * hx + (ly * hy + lz * hz)) * scale;
    float d = nh * nh * (a2 - 1) + 1.00001f;
    return a2 / (d * d * most(0.1f, lh * lh) * flat);
}

typedef struct Finish { float a2, flat, metal, smoothness2, dull; } Finish;

LANE_CODE Finish finish_of(const Subject *s)
{
    float rough = s->colour[3], metal = most(s->look[0], 0);
    return (Finish){rough * rough * rough * rough, 4 * rough + 2, metal, (1 - rough) * (1 - rough), 1 - 0.6f * rough};
}

/* One channel of sun, sky and mirrored sky. */
LANE_CODE float throw_back(const Frame *f, int k, float c, const Finish *a, float sun, float shine, float nu, float steep, float up, float sky)
{
    float f0 = blend(0.04f, c, a->metal), diffuse = c * (1 - a->metal), fresnel = f0 * a->dull + (1 - f0) * steep;
    float mirror = blend(blend(f->ground[k] * 0.8f, f->horizon[k], unit_range(up * 0.9f + 0.62f)), f->zenith[k], unit_range(up));
    return (diffuse + shine * f0) * (sun * f->sun_colour[k]) + (diffuse * blend(f->ground[k], f->zenith[k], nu) + fresnel * mirror) * sky;
}

LANE_CODE void light_solid(const Subject *s, const Frame *f, Block *b, const float *red, const float *green, const float *blue)
{
    const Finish a = finish_of(s);
    const float sx = s->sun[0], sy = s->sun[1], sz = s->sun[2], ux = s->up[0], uy = s->up[1], uz = s->up[2];
    for (int i = 0; i < b->n; i++) {
        float vx = -b->dx[i], vy = -b->dy[i], vz = -b->dz[i], scale = 1 / sqrtf(vx * vx + (vy * vy + vz * vz));
        float nx = b->nx[i], ny = b->ny[i], nz = b->nz[i];
        vx *= scale;
        vy *= scale;
        vz *= scale;
        float nu = nx * ux + (ny * uy + nz * uz), nv = most(nx * vx + (ny * vy + nz * vz), 0);
        float sun = most(nx * sx + (ny * sy + nz * sz), 0) * b->lit[i], shine = gloss(nx, ny, nz, vx, vy, vz, sx, sy, sz, a.a2, a.flat);
        float edge = 1 - nv, edge2 = edge * edge, steep = edge2 * edge2 * edge * a.smoothness2;
        float up = 2 * nv * nu - (vx * ux + (vy * uy + vz * uz)), half = nu * 0.5f + 0.5f, sky = b->sky[i];
        b->red[i] = throw_back(f, 0, red[i], &a, sun, shine, half, steep, up, sky);
        b->green[i] = throw_back(f, 1, green[i], &a, sun, shine, half, steep, up, sky);
        b->blue[i] = throw_back(f, 2, blue[i], &a, sun, shine, half, steep, up, sky);
    }
}

LANE_CODE void light_plane(const Subject *s, Block *b)
{
    for (int i = 0; i < b->n; i++) {
        b->red[i] *= b->lit[i] * s->direct[0] + b->sky[i] * s->sky[0];
        b->green[i] *= b->lit[i] * s->direct[1] + b->sky[i] * s->sky[1];
        b->blue[i] *= b->lit[i] * s->direct[2] + b->sky[i] * s->sky[2];
    }
}

LANE_CODE void light_lamp(const Subject *s, const float lamp[3], const float colour[4], Block *b, const float *red, const float *green,
                          const float *blue)
{
    const Finish a = finish_of(s);
    for (int i = 0; i < b->n; i++) {
        float vx = -b->dx[i], vy = -b->dy[i], vz = -b->dz[i], scale = 1 / sqrtf(vx * vx + (vy * vy + vz * vz));
        float nx = b->nx[i], ny = b->ny[i], nz = b->nz[i], lx = lamp[0] - b->px[i], ly = lamp[1] - b->py[i], lz = lamp[2] - b->pz[i];
        float near = 1 / most(lx * lx + (ly * ly + lz * lz), 1e-6f), root = sqrtf(near);
        lx *= root;
        ly *= root;
        lz *= root;
        float e = near * most(nx * lx + (ny * ly + nz * lz), 0);
        float shine = gloss(nx, ny, nz, vx * scale, vy * scale, vz * scale, lx, ly, lz, a.a2, a.flat);
        b->red[i] += (red[i] * (1 - a.metal) + shine * blend(0.04f, red[i], a.metal)) * (e * colour[0]);
        b->green[i] += (green[i] * (1 - a.metal) + shine * blend(0.04f, green[i], a.metal)) * (e * colour[1]);
        b->blue[i] += (blue[i] * (1 - a.metal) + shine * blend(0.04f, blue[i], a.metal)) * (e * colour[2]);
    }
}

LANE_CODE void throw_light(const Subject *s, const Frame *f, Block *b)
{
    float red[LANES], green[LANES], blue[LANES];
    const float glow = most(-s->look[0], 0);
    memcpy(red, b->red, sizeof red);
    memcpy(green, b->green, sizeof green);
    memcpy(blue, b->blue, sizeof blue);
    if (s->form == SUBJECT_PLANE)
        light_plane(s, b);
    else
        light_solid(s, f, b, red, green, blue);
    for (int k = 0; k < s->lamps; k++)
        light_lamp(s, s->lamp[k], f->lamp_colour[k], b, red, green, blue);
    for (int i = 0; i < b->n && glow > 0; i++) {
        b->red[i] += red[i] * glow;
        b->green[i] += green[i] * glow;
        b->blue[i] += blue[i] * glow;
    }
}

/* ---- air and display -------------------------------------------------------- */

/* Fog, in the sky's colour at its rim. */
LANE_CODE void fade(const Frame *f, Block *b)
{
    const float scale = f->forward[3], red = f->sky_rim[0], green = f->sky_rim[1], blue = f->sky_rim[2];
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i], t = b->t[i];
        float far = 1 - least(t * t * (dx * dx + (dy * dy + dz * dz)) * scale, 1);
        far *= far;
        b->red[i] = blend(red, b->red[i], far);
        b->green[i] = blend(green, b->green[i], far);
        b->blue[i] = blend(blue, b->blue[i], far);
    }
}

LANE_CODE void shine_sky(const Subject *s, const Frame *f, Block *b)
{
    const float sx = s->sun[0], sy = s->sun[1], sz = s->sun[2], glow = f->sky_top[3];
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i], scale = 1 / sqrtf(dx * dx + (dy * dy + dz * dz)), up = dz * scale;
        float high = 1 - unit_range(up * 1.15f), low = unit_range(-up * 1.6f - 0.12f), sun = most((dx * sx + (dy * sy + dz * sz)) * scale, 0);
        high *= high;
        high *= high;
        sun = sun * sun * sun;
        sun *= sun * glow;
        b->red[i] = blend(blend(f->sky_top[0], f->sky_rim[0], high), f->sky_low[0], low) + f->sun_colour[0] * sun;
        b->green[i] = blend(blend(f->sky_top[1], f->sky_rim[1], high), f->sky_low[1], low) + f->sun_colour[1] * sun;
        b->blue[i] = blend(blend(f->sky_top[2], f->sky_rim[2], high), f->sky_low[2], low) + f->sun_colour[2] * sun;
        b->side[i] = 0;
    }
}

/* One curve for tone and for the display's gamma: white is reached softly, and what is dark stands out. */
LANE_CODE float shown(float light)
{
    light = most(light, 0);
    float y = light * 1.03f / (light + 0.195f);
    return y * (255 + 0.6f * 255 * ((1 - y) * (y - 0.62f)));
}

LANE_CODE uint32_t level_of(float level) { return (uint32_t)(int32_t)least(level + 0.5f, 255); }

/* The levels of a smooth floor with what it mirrors: more of it, the flatter one looks (after Schlick, as bodies do). */
LANE_CODE void show_mirror(const Subject *s, const ShadeMirror *m, int width, int height, Block *b)
{
    Spots o;
    const float scale_x = (float)m->width / (float)width, scale_y = (float)m->height / (float)height;
    float red[LANES], green[LANES], blue[LANES];
    for (int i = 0; i < b->n; i++) {
        o.u[i] = (b->x[i] + 0.5f) * scale_x - 0.5f;
        o.v[i] = (b->y[i] + 0.5f) * scale_y - 0.5f;
    }
    settle_on(&o, b->n, m->width, m->height);
    fetch_bytes(m->pixels, m->width, &o, b->n, (float *const[3]){red, green, blue});
    for (int i = 0; i < b->n; i++) {
        float dx = b->dx[i], dy = b->dy[i], dz = b->dz[i], across = 1 - fabsf(dy) / sqrtf(dx * dx + (dy * dy + dz * dz)), across2 = across * across;
        float steep = across2 * across2 * across, level[3] = {shown(b->red[i]), shown(b->green[i]), shown(b->blue[i])};
        float there[3] = {red[i] * 255, green[i] * 255, blue[i] * 255};
        for (int k = 0; k < 3; k++)
            level[k] = blend(level[k], there[k], (s->mirror[k] + (1 - s->mirror[k]) * steep) * s->sheen);
        b->out[i] = level_of(level[0]) << RED_SHIFT | level_of(level[1]) << GREEN_SHIFT | level_of(level[2]) << BLUE_SHIFT;
    }
}

/* In a picture that is so many pixels wide and high. */
LANE_CODE void show(const Subject *s, const ShadeMirror *mirror, int width, int height, Block *b)
{
    if (s->sheen > 0 && mirror->pixels)
        show_mirror(s, mirror, width, height, b);
    else
        for (int i = 0; i < b->n; i++)
            b->out[i] = level_of(shown(b->red[i])) << RED_SHIFT | level_of(shown(b->green[i])) << GREEN_SHIFT |
                        level_of(shown(b->blue[i])) << BLUE_SHIFT;
    if (s->form == SUBJECT_BOX || s->form == SUBJECT_CYLINDER)
        for (int i = 0; i < b->n; i++)
            b->out[i] |= s->key[b->side[i]];
    else
        for (int i = 0; i < b->n; i++)
            b->out[i] |= s->key[0];
}

#endif
