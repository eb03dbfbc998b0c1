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

static vec3 trail_point(const ViewPast *h, const View *v, int trail, int i)
{
    const real *p = h->trails + 3 * ((size_t)trail * (size_t)h->trail_length + (size_t)i);
    return (vec3){p[0] - v->origin[0], p[1] - v->origin[1], p[2] - v->origin[2]};
}

/* How far a body came in the time between two points of its trail, the last two of which may be nearer in time. */
static real pace(const ViewPast *h, const View *v, int trail, int i)
{
    return vec3_distance(trail_point(h, v, trail, i), trail_point(h, v, trail, i - 1)) / (i == h->trail_length - 1 ? h->head : 1);
}

static real fastest(const ViewPast *h, const View *v)
{
    real most = 0;
    for (int k = 0; k < h->trail_count; k++)
        for (int i = 1; i < h->trail_length; i++) {
            real d = pace(h, v, k, i);
            most = d > most ? d : most;         /* false where a point is not there (NAN) */
        }
    return most;
}

/* 1 now, 0 at the far end of a trail: its points stay where they are while it passes over them. */
static real youth(const ViewPast *h, int i)
{
    return i == h->trail_length - 1 ? 1 : (i + 1 - h->head) / (h->trail_length - 1);
}

void history_trails(const Pen *pen, const View *v, const ViewPast *h)
{
    real most = fastest(h, v);
    if (!(most > 0))
        return;
    for (int k = 0; k < h->trail_count; k++)
        for (int i = 1; i < h->trail_length; i++) {
            vec3 a = trail_point(h, v, k, i - 1), b = trail_point(h, v, k, i);
            real share = pace(h, v, k, i) / most, young = youth(h, i);
            float colour[3];
            if (!(share > 0.01))
                continue;
            speed_colour(share, colour);
            pen_bare_line(pen, a, b, 0.5 + 1.9 * young, colour, (float)real_min(0.95, 3 * young));
        }
}

/* ---- energies ------------------------------------------------------------ */

static const char *const names[PAST_ENERGIES] = {"kinetic", "potential", "elastic", "lost"};
static const float colours[PAST_ENERGIES][3] = {{0.98f, 0.62f, 0.20f}, {0.30f, 0.66f, 0.95f}, {0.45f, 0.85f, 0.45f}, {0.85f, 0.40f, 0.75f}};

typedef struct Strip { real left, right, top, bottom, low, high, top_energy, end; } Strip;      /* px, J, s */

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
static real energy_at(const ViewPast *h, int i, int kind, real zero)
{
    return h->energies[(size_t)i * (1 + PAST_ENERGIES) + 1 + (size_t)kind] - (kind == 1 ? zero : 0);
}

static real lowest_potential(const ViewPast *h)
{
    real low = INFINITY;
    for (int i = 0; i < h->energy_count; i++)
        low = real_min(low, energy_at(h, i, 1, 0));
    return isfinite(low) ? low : 0;
}

static void set_bounds(Strip *s, const ViewPast *h, real zero)
{
    s->low = 0;
    s->high = 1e-12;
    for (int i = 0; i < h->energy_count; i++)
        for (int k = 0; k < PAST_ENERGIES; k++) {
            s->low = real_min(s->low, energy_at(h, i, k, zero));
            s->high = real_max(s->high, energy_at(h, i, k, zero));
        }
    s->top_energy = s->high;
    s->high += 0.06 * (s->high - s->low);
}

static void draw_curve(const Pen *pen, const Strip *s, const ViewPast *h, int kind, real zero)
{
    real before[2] = {0, 0};
    for (int i = 0; i < h->energy_count; i++) {
        real time = h->energies[(size_t)i * (1 + PAST_ENERGIES)], at[2];
        strip_place(s, time, energy_at(h, i, kind, zero), at);
        if (i > 0)
            strip_line(pen, before, at, 1.2 * pen->scale, colours[kind], 1);
        before[0] = at[0];
        before[1] = at[1];
    }
    strip_line(pen, before, before, 3.2 * pen->scale, colours[kind], 1);
}

static void draw_level(const Pen *pen, const Strip *s, real energy, float alpha)
{
    static const float grey[3] = {0.62f, 0.64f, 0.68f};
    real a[2], b[2];
    strip_place(s, 0, energy, a);
    strip_place(s, s->end, energy, b);
    strip_line(pen, a, b, 0.5 * pen->scale, grey, alpha);
}

/* What the colours mean, with what each kind is now; at the right what the upper line stands for, and since when. */
static void draw_words(const Pen *pen, const Strip *s, const ViewPast *h, real zero, real line)
{
    static const float grey[3] = {0.75f, 0.77f, 0.80f};
    real size = pen->o->font.size, x = s->left;
    char text[96], amount[32];
    for (int k = 0; k < PAST_ENERGIES; k++) {
        overlay_quantity(amount, energy_at(h, h->energy_count - 1, k, zero), "J");
        snprintf(text, sizeof text, "%s %s", names[k], amount);
        pen_label(pen, x, line, text, colours[k]);
        x += 10.5 * size;       /* in columns, so that nothing moves as the numbers do */
    }
    overlay_quantity(amount, s->top_energy, "J");
    snprintf(text, sizeof text, "top %s, width %.3g s", amount, s->end);
    real wide = pen_text_width(pen, text);
    if (x + wide < s->right)
        pen_label(pen, s->right - wide, line, text, grey);
}

real history_foot(const Pen *pen) { return HISTORY_HEIGHT * pen->eye->height + 2.1 * pen->o->font.size; }

void history_energies(const Pen *pen, const View *v, const ViewPast *h)
{
    static const float plate[3] = {0.06f, 0.07f, 0.09f};
    real size = pen->o->font.size, foot = history_foot(pen), zero = lowest_potential(h), height = pen->eye->height;
    Strip s = {.left = 1.2 * size, .right = pen->eye->width - 1.2 * size, .bottom = height - 0.6 * size, .end = v->time - h->begin};
    if (h->energy_count < 2)
        return;
    s.top = height - foot + 1.7 * size;
    set_bounds(&s, h, zero);
    const real one[2] = {-foot, height - 0.5 * foot}, other[2] = {pen->eye->width + foot, height - 0.5 * foot};   /* from rim to rim */
    strip_line(pen, one, other, 0.5 * foot, plate, 0.74f);
    draw_level(pen, &s, 0, 0.8f);
    draw_level(pen, &s, s.top_energy, 0.35f);
    for (int k = PAST_ENERGIES - 1; k >= 0; k--)
        draw_curve(pen, &s, h, k, zero);
    draw_words(pen, &s, h, zero, height - foot + 1.15 * size);
}
