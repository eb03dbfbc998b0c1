/* render/history.c - overlays of what was: trails of bodies, and a strip with the energies at the bottom. */
#include <stdio.h>

#include "render/overlay.h"

/* ---- trails ------------------------------------------------------------- */

/* Brighter and wider towards now; in the colour of the body's speed: slow is blue, fast is yellow, the fastest of the moment white. */
static void speed_colour(real share, float out[3])
{
    static const float stops[4][3] = {{0.16f, 0.36f, 0.85f}, {0.15f, 0.75f, 0.70f}, {0.98f, 0.82f, 0.25f}, {1.0f, 0.97f, 0.90f}};
    real x = 3 * real_clamp(share, 0, 1);
    int k = x < 1 ? 0 : x < 2 ? 1 : 2;
    for (int i = 0; i < 3; i++)
        out[i] = (float)((1 - (x - k)) * (real)stops[k][i] + (x - k) * (real)stops[k + 1][i]);
}

static vec3 trail_point(const RenderHistory *h, const View *v, int trail, int i)
{
    const real *p = h->trails + 3 * ((size_t)trail * (size_t)h->trail_length + (size_t)i);
    return (vec3){p[0] - v->origin[0], p[1] - v->origin[1], p[2] - v->origin[2]};
}

static real fastest(const RenderHistory *h, const View *v)
{
    real most = 0;
    for (int k = 0; k < h->trail_count; k++)
        for (int i = 1; i < h->trail_length; i++) {
            real d = vec3_distance(trail_point(h, v, k, i), trail_point(h, v, k, i - 1));
            most = d > most ? d : most;         /* false where a point is not there (NAN) */
        }
    return most;
}

void history_trails(const Pen *pen, const View *v, const RenderHistory *h)
{
    real most = fastest(h, v);
    if (!(most > 0))
        return;
    for (int k = 0; k < h->trail_count; k++)
        for (int i = 1; i < h->trail_length; i++) {
            vec3 a = trail_point(h, v, k, i - 1), b = trail_point(h, v, k, i);
            real d = vec3_distance(a, b), age = (real)i / (h->trail_length - 1);
            float colour[3];
            if (!(d > 0.01 * most))
                continue;
            speed_colour(d / most, colour);
            pen_bare_line(pen, a, b, 0.6 + 1.0 * age, colour, (float)(0.15 + 0.75 * age));
        }
}

/* ---- energies ------------------------------------------------------------ */

static const char *const names[RENDER_ENERGIES] = {"kinetic", "potential", "elastic", "lost"};
static const float colours[RENDER_ENERGIES][3] = {{0.98f, 0.62f, 0.20f}, {0.30f, 0.66f, 0.95f}, {0.45f, 0.85f, 0.45f}, {0.85f, 0.40f, 0.75f}};

typedef struct Strip { real left, right, top, bottom, low, high, end; } Strip;      /* px, J, s */

static void strip_line(const Pen *pen, const real a[2], const real b[2], real half, const float colour[3], float alpha)
{
    Stroke s = pen_stroke(a, b, half, half, colour, alpha);
    s.widths[2] = 0;            /* no rim */
    pen_put(pen, s);
}

static void strip_place(const Strip *s, real time, real energy, real out[2])
{
    out[0] = s->left + (s->right - s->left) * (s->end > 0 ? time / s->end : 1);
    out[1] = s->bottom - (s->bottom - s->top) * (energy - s->low) / (s->high - s->low);
}

/* Potential energy counts from its lowest, as its zero is anybody's choice. */
static real energy_at(const RenderHistory *h, int i, int kind, real zero)
{
    return h->energies[(size_t)i * (1 + RENDER_ENERGIES) + 1 + (size_t)kind] - (kind == 1 ? zero : 0);
}

static real lowest_potential(const RenderHistory *h)
{
    real low = INFINITY;
    for (int i = 0; i < h->energy_count; i++)
        low = real_min(low, energy_at(h, i, 1, 0));
    return isfinite(low) ? low : 0;
}

static void set_bounds(Strip *s, const RenderHistory *h, real zero)
{
    s->low = 0;
    s->high = 1e-12;
    for (int i = 0; i < h->energy_count; i++)
        for (int k = 0; k < RENDER_ENERGIES; k++) {
            s->low = real_min(s->low, energy_at(h, i, k, zero));
            s->high = real_max(s->high, energy_at(h, i, k, zero));
        }
    s->high += 0.06 * (s->high - s->low);
}

static void draw_curve(const Pen *pen, const Strip *s, const RenderHistory *h, int kind, real zero, real now)
{
    real before[2] = {0, 0};
    for (int i = 0; i < h->energy_count; i++) {
        real time = h->energies[(size_t)i * (1 + RENDER_ENERGIES)], at[2];
        if (time > now + 1e-9)
            break;
        strip_place(s, time, energy_at(h, i, kind, zero), at);
        if (i > 0)
            strip_line(pen, before, at, 0.9 * pen->scale, colours[kind], 1);
        before[0] = at[0];
        before[1] = at[1];
    }
}

void history_energies(const Pen *pen, const View *v, const RenderHistory *h)
{
    static const float plate[3] = {0.07f, 0.08f, 0.10f}, grey[3] = {0.45f, 0.47f, 0.50f};
    real size = pen->o->font.size, height = HISTORY_HEIGHT * pen->eye->height, zero = lowest_potential(h);
    Strip s = {.left = 1.2 * size, .right = pen->eye->width - 1.2 * size, .bottom = pen->eye->height - 0.8 * size, .end = h->end};
    if (h->energy_count < 2)
        return;
    s.top = s.bottom - height;
    set_bounds(&s, h, zero);
    real middle = 0.5 * (s.top + s.bottom), half = 0.5 * height + 0.4 * size;
    const real one[2] = {-half, middle}, other[2] = {pen->eye->width + half, middle};      /* from rim to rim */
    strip_line(pen, one, other, half, plate, 0.66f);
    real a[2], b[2];
    strip_place(&s, 0, 0, a);
    strip_place(&s, s.end, 0, b);
    strip_line(pen, a, b, 0.5 * pen->scale, grey, 1);
    for (int k = 0; k < RENDER_ENERGIES; k++)
        draw_curve(pen, &s, h, k, zero, v->time - h->begin);
    real x = s.left + 0.6 * size;
    for (int k = 0; k < RENDER_ENERGIES; k++)
        x += pen_label(pen, x, s.top + 0.9 * size, names[k], colours[k]) + 1.2 * size;
    char text[40];
    snprintf(text, sizeof text, "%.4g J", s.high);
    pen_label(pen, s.right - 5 * size, s.top + 0.9 * size, text, grey);
}
