/* render/smooth.c - morphological antialiasing along the borders between faces. */
#include "render/smooth.h"

#include <stdlib.h>

#include "render/wide.h"

/* Bytes of a pixel in memory order: red, green, blue, key. */
typedef struct Pixel { int red, green, blue; } Pixel;

typedef struct Picture {
    const uint32_t *raw;
    unsigned char  *out;
    int             width, height;
} Picture;

enum { SKIP = 8 };                  /* pixels looked at together */
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
enum { KEY_SHIFT = 24 };            /* where a pixel's key lies in a word */
#else
enum { KEY_SHIFT = 0 };
#endif
static const int FAINT = 12;        /* levels of red + green + blue: a fainter border is left alone */

static unsigned char byte_of(uint32_t pixel, int k)
{
    unsigned char bytes[4];
    memcpy(bytes, &pixel, sizeof bytes);
    return bytes[k];
}

static Pixel pixel_of(uint32_t p) { return (Pixel){byte_of(p, 0), byte_of(p, 1), byte_of(p, 2)}; }

static bool differ(uint32_t a, uint32_t b)
{
    if (byte_of(a, 3) == byte_of(b, 3))
        return false;
    Pixel p = pixel_of(a), q = pixel_of(b);
    return abs(p.red - q.red) + abs(p.green - q.green) + abs(p.blue - q.blue) > FAINT;
}

static uint32_t at(const Picture *p, int x, int y) { return p->raw[(size_t)y * (size_t)p->width + (size_t)x]; }

/* ---- mixing ------------------------------------------------------------ */

static unsigned char add_level(int level, int change)
{
    int sum = level + change;
    return (unsigned char)(sum < 0 ? 0 : sum > 255 ? 255 : sum);
}

/* The pixel (x, y) gets `share` of the colour of `other`. What is mixed is always what was drawn, so order does not matter. */
static void mix(const Picture *p, int x, int y, uint32_t other, float share)
{
    int weight = (int)(share * 256 + 0.5f);
    if (weight == 0)
        return;
    unsigned char *to = p->out + 3 * ((size_t)(p->height - 1 - y) * (size_t)p->width + (size_t)x);
    Pixel own = pixel_of(at(p, x, y)), new = pixel_of(other);
    to[0] = add_level(to[0], (weight * (new.red - own.red)) / 256);
    to[1] = add_level(to[1], (weight * (new.green - own.green)) / 256);
    to[2] = add_level(to[2], (weight * (new.blue - own.blue)) / 256);
}

/* Areas above and below zero of the line from a to b over one pixel. */
static void areas(float a, float b, float *above, float *below)
{
    *above = *below = 0;
    if (a >= 0 && b >= 0)
        *above = 0.5f * (a + b);
    else if (a <= 0 && b <= 0)
        *below = -0.5f * (a + b);
    else {
        float left = 0.5f * a * a / (a > b ? a - b : b - a), right = 0.5f * b * b / (a > b ? a - b : b - a);
        *above = a > 0 ? left : right;
        *below = a > 0 ? right : left;
    }
}

/* Height of the border over a run of n pixels, t from its start. The silhouette steps up (0.5) or down (-0.5) at the ends, or not.
 * Steps to both sides: one straight line. Else lines from either end to the middle. */
static float height_at(float t, float n, float start, float end)
{
    if (start * end < 0)
        return start + (end - start) * t / n;
    float half = 0.5f * n;
    return t < half ? start * (1 - t / half) : end * (t - half) / half;
}

/* A run of n pixels along a row (or a column: `upright`) with the border between (x, y) and the next row (column). */
static void mix_run(const Picture *p, int x, int y, int n, bool upright, float start, float end)
{
    int dx = upright ? 0 : 1, dy = upright ? 1 : 0;
    float before = start;
    for (int i = 0; i < n; i++) {
        float above, below, after = height_at((float)(i + 1), (float)n, start, end);
        areas(before, after, &above, &below);
        if (n % 2 == 1 && i == n / 2 && start * end >= 0) {     /* the middle of the run lies in this pixel: a bend at zero */
            above = 0.25f * ((before > 0 ? before : 0) + (after > 0 ? after : 0));
            below = 0.25f * ((before < 0 ? -before : 0) + (after < 0 ? -after : 0));
        }
        before = after;
        int px = x + i * dx, py = y + i * dy;
        if (above > 0)
            mix(p, px + dy, py + dx, at(p, px, py), above);
        if (below > 0)
            mix(p, px, py, at(p, px + dy, py + dx), below);
    }
}

/* ---- runs -------------------------------------------------------------- */

/* Which way the silhouette turns at an end of a run: towards the far side (0.5), the near side (-0.5), neither or both (0).
 * `far_turn`: whether there is a border on the far side across the end. */
static float turn_at(bool near_turn, bool far_turn) { return far_turn == near_turn ? 0 : far_turn ? 0.5f : -0.5f; }

/* The border between rows y and y + 1 over [x, end). */
static void finish_row_run(const Picture *p, int x, int end, int y)
{
    float start_turn = 0, end_turn = 0;
    if (x > 0)
        start_turn = turn_at(differ(at(p, x - 1, y), at(p, x, y)), differ(at(p, x - 1, y + 1), at(p, x, y + 1)));
    if (end < p->width)
        end_turn = turn_at(differ(at(p, end - 1, y), at(p, end, y)), differ(at(p, end - 1, y + 1), at(p, end, y + 1)));
    if (start_turn != 0 || end_turn != 0)
        mix_run(p, x, y, end - x, false, start_turn, end_turn);
}

/* The border between columns x and x + 1 over [y, end). */
static void finish_column_run(const Picture *p, int x, int y, int end)
{
    float start_turn = 0, end_turn = 0;
    if (y > 0)
        start_turn = turn_at(differ(at(p, x, y - 1), at(p, x, y)), differ(at(p, x + 1, y - 1), at(p, x + 1, y)));
    if (end < p->height)
        end_turn = turn_at(differ(at(p, x, end - 1), at(p, x, end)), differ(at(p, x + 1, end - 1), at(p, x + 1, end)));
    if (start_turn != 0 || end_turn != 0)
        mix_run(p, x, y, end - y, true, start_turn, end_turn);
}

/* Where the keys of two lists of n pixels differ: a byte each, 0 = they do not. */
LANE_CODE void compare_keys(const uint32_t *a, const uint32_t *b, int n, unsigned char *apart)
{
    for (int i = 0; i < n; i++)
        apart[i] = (unsigned char)((a[i] ^ b[i]) >> KEY_SHIFT);
}

static void compare_plainly(const uint32_t *a, const uint32_t *b, int n, unsigned char *apart) { compare_keys(a, b, n, apart); }
WIDE static void compare_widely(const uint32_t *a, const uint32_t *b, int n, unsigned char *apart) { compare_keys(a, b, n, apart); }

/* Of SKIP bytes, whether any is not 0. */
static bool any_set(const unsigned char *p)
{
    uint64_t all;
    memcpy(&all, p, sizeof all);
    return all != 0;
}

_Static_assert(SKIP == sizeof(uint64_t), "any_set looks at SKIP bytes");

static void smooth_rows(const Picture *p, unsigned char *apart)
{
    bool wide = has_wide();
    for (int y = 0; y + 1 < p->height; y++) {
        const uint32_t *a = p->raw + (size_t)y * (size_t)p->width, *b = a + p->width;
        (wide ? compare_widely : compare_plainly)(a, b, p->width, apart);
        for (int x = 0; x < p->width;) {
            if (!any_set(apart + x)) {
                x += SKIP;
                continue;
            }
            int start = x;
            while (x < p->width && apart[x] && differ(a[x], b[x]))
                x++;
            if (x > start)
                finish_row_run(p, start, x, y);
            else
                x++;
        }
    }
}

/* open[x]: where a border between columns x and x + 1 began, of those for which busy[x] is not 0. */
static void smooth_columns(const Picture *p, unsigned char *apart, unsigned char *busy, int *open)
{
    bool wide = has_wide();
    int last = p->width - 1;
    apart[last] = 0;
    for (int y = 0; y < p->height; y++) {
        const uint32_t *a = p->raw + (size_t)y * (size_t)p->width;
        (wide ? compare_widely : compare_plainly)(a, a + 1, last, apart);
        for (int x = 0; x < last;) {
            if (!any_set(apart + x) && !any_set(busy + x)) {
                x += SKIP;
                continue;
            }
            bool border = apart[x] && differ(a[x], a[x + 1]);
            if (border && !busy[x])
                open[x] = y;
            if (!border && busy[x])
                finish_column_run(p, x, open[x], y);
            busy[x] = border;
            x++;
        }
    }
    for (int x = 0; x < last; x++)
        if (busy[x])
            finish_column_run(p, x, open[x], p->height);
}

/* ---- pictures ---------------------------------------------------------- */

/* One row without its keys. Four bytes are written for each pixel: the last is overwritten by the next one. */
static void copy_plainly(const uint32_t *from, int width, unsigned char *to)
{
    int x = 0;
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    for (uint64_t two; x + 3 < width; x += 2, to += 6) {        /* the last two bytes are overwritten likewise */
        memcpy(&two, &from[x], 8);
        two = (two & 0xffffff) | (two >> 8 & UINT64_C(0xffffff000000));
        memcpy(to, &two, 8);
    }
#endif
    for (; x + 1 < width; x++, to += 3)
        memcpy(to, &from[x], 4);
    memcpy(to, &from[width - 1], 3);
}

/* The same by four pixels at once. */
WIDE static void copy_widely(const uint32_t *from, int width, unsigned char *to)
{
    typedef unsigned char Bytes __attribute__((vector_size(16)));
    int x = 0;
    for (Bytes four; x + 5 < width; x += 4, to += 12) {
        memcpy(&four, &from[x], 16);
        four = __builtin_shufflevector(four, four, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
        memcpy(to, &four, 16);
    }
    copy_plainly(from + x, width - x, to);
}

void smooth_copy(const uint32_t *raw, int width, int height, unsigned char *out)
{
    bool wide = has_wide();
    for (int y = 0; y < height; y++)
        (wide ? copy_widely : copy_plainly)(raw + (size_t)width * (size_t)(height - 1 - y), width, out + 3 * (size_t)width * (size_t)y);
}

/* Room for rows of `width` pixels: *open and two rows of bytes that are 0 from `width` on. */
static bool fit(SmoothSpace *space, int width)
{
    if (space->capacity >= width)
        return true;
    free(space->open);
    free(space->bytes);
    space->open = malloc((size_t)width * sizeof *space->open);
    space->bytes = malloc(2 * ((size_t)width + SKIP));
    space->capacity = space->open && space->bytes ? width : 0;
    return space->capacity > 0;
}

dig_status smooth_edges(SmoothSpace *space, const uint32_t *raw, int width, int height, unsigned char *out)
{
    if (!fit(space, width))
        return DIG_E_MEMORY;
    Picture p = {raw, out, width, height};
    unsigned char *apart = space->bytes, *busy = apart + width + SKIP;
    memset(apart, 0, 2 * ((size_t)width + SKIP));
    smooth_copy(raw, width, height, out);
    smooth_rows(&p, apart);
    smooth_columns(&p, apart, busy, space->open);
    return DIG_OK;
}

void smooth_close(SmoothSpace *space)
{
    free(space->open);
    free(space->bytes);
    *space = (SmoothSpace){0};
}

void smooth_cover(const uint32_t *overlay, int width, int height, unsigned char *out)
{
    for (int y = 0; y < height; y++) {
        const uint32_t *from = overlay + (size_t)width * (size_t)(height - 1 - y);
        unsigned char *to = out + 3 * (size_t)width * (size_t)y;
        for (int x = 0; x < width; x++) {
            int alpha = byte_of(from[x], 3);
            for (int k = 0; alpha > 0 && k < 3; k++)
                to[3 * x + k] = add_level(byte_of(from[x], k), (to[3 * x + k] * (255 - alpha) + 127) / 255);
        }
    }
}
