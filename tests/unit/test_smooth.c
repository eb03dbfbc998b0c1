/* tests/unit/test_smooth.c - silhouettes smoothed after drawing, against the areas that lines cover; depths drawn by the CPU. */
#include <stdlib.h>

#include "check.h"
#include "render/cast.h"
#include "render/smooth.h"

enum { WIDTH = 64, HEIGHT = 48 };

/* One colour above the line y = at + slope x (from the bottom), another below; drawn without any smoothing. */
static void draw_line(uint32_t *raw, double at, double slope, int key_above, int key_below)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            bool above = y + 0.5 > at + slope * (x + 0.5);
            const unsigned char pixel[4] = {above ? 200 : 40, above ? 180 : 60, above ? 20 : 220, (unsigned char)(above ? key_above : key_below)};
            memcpy(&raw[y * WIDTH + x], pixel, 4);
        }
}

/* Share of a pixel above the line, by many small columns. */
static double share_above(double at, double slope, int x, int y)
{
    double sum = 0;
    for (int i = 0; i < 64; i++) {
        double top = y + 1 - (at + slope * (x + (i + 0.5) / 64));
        sum += top < 0 ? 0 : top > 1 ? 1 : top;
    }
    return sum / 64;
}

/* Root mean square of the errors of red at the pixels that the line crosses, as shares. */
static double line_error(const unsigned char *out, double at, double slope)
{
    double sum = 0;
    int count = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 8; x < WIDTH - 8; x++) {       /* runs are cut at the rim */
            double share = share_above(at, slope, x, y), got = (out[3 * ((HEIGHT - 1 - y) * WIDTH + x)] - 40) / 160.0;
            if (share <= 0 || share >= 1)
                continue;
            sum += (got - share) * (got - share);
            count++;
        }
    return sqrt(sum / count);
}

TEST(a_slanted_border_covers_its_share_of_each_pixel)
{
    static uint32_t raw[WIDTH * HEIGHT];
    static unsigned char plain[3 * WIDTH * HEIGHT], out[3 * WIDTH * HEIGHT];
    SmoothSpace space = {0};
    static const double slopes[] = {0.13, -0.29, 0.37, 0.61, -0.8, 0.97};
    for (int i = 0; i < 6; i++) {
        double at = HEIGHT / 2.0 - slopes[i] * WIDTH / 2 + 0.3;
        draw_line(raw, at, slopes[i], 1, 2);
        smooth_copy(raw, WIDTH, HEIGHT, plain);
        CHECK_INT(smooth_edges(&space, raw, WIDTH, HEIGHT, out), DIG_OK);
        double before = line_error(plain, at, slopes[i]), after = line_error(out, at, slopes[i]);
        /* Near diagonals runs are one or two pixels long and less is known: measured 0.141 at -0.8, 0.165 at 0.97; else 0.126 at most. */
        bool diagonal = fabs(slopes[i]) > 0.7;
        if (!(after < (diagonal ? 0.17 : 0.13) && after < (diagonal ? 0.75 : 0.6) * before))
            fail_msg("slope %g: shares off by %.3f, %.3f unsmoothed", slopes[i], after, before);
    }
    smooth_close(&space);
}

TEST(upright_is_treated_as_level)
{
    static uint32_t raw[WIDTH * WIDTH], turned[WIDTH * WIDTH];
    static unsigned char a[3 * WIDTH * WIDTH], b[3 * WIDTH * WIDTH];
    SmoothSpace space = {0};
    for (int y = 0; y < WIDTH; y++)
        for (int x = 0; x < WIDTH; x++) {
            double far = hypot(x - 30.2, y - 33.7);
            const unsigned char pixel[4] = {far < 20 ? 250 : 10, 100, 50, far < 20 ? 3 : 240};
            memcpy(&raw[y * WIDTH + x], pixel, 4);
            memcpy(&turned[x * WIDTH + y], pixel, 4);
        }
    CHECK_INT(smooth_edges(&space, raw, WIDTH, WIDTH, a), DIG_OK);
    CHECK_INT(smooth_edges(&space, turned, WIDTH, WIDTH, b), DIG_OK);
    int different = 0;
    for (int y = 0; y < WIDTH; y++)
        for (int x = 0; x < WIDTH; x++)
            different += abs(a[3 * ((WIDTH - 1 - y) * WIDTH + x)] - b[3 * ((WIDTH - 1 - x) * WIDTH + y)]) > 1;
    smooth_close(&space);
    CHECK_INT(different, 0);
}

TEST(what_is_one_face_stays_as_it_is)
{
    static uint32_t raw[WIDTH * HEIGHT];
    static unsigned char plain[3 * WIDTH * HEIGHT], out[3 * WIDTH * HEIGHT];
    SmoothSpace space = {0};
    draw_line(raw, 10, 0.4, 7, 7);      /* a pattern, not a border */
    smooth_copy(raw, WIDTH, HEIGHT, plain);
    CHECK_INT(smooth_edges(&space, raw, WIDTH, HEIGHT, out), DIG_OK);
    smooth_close(&space);
    CHECK(memcmp(plain, out, sizeof out) == 0);
}

TEST(an_overlay_covers_by_its_weight)
{
    uint32_t over[2];
    unsigned char out[6] = {100, 200, 40, 100, 200, 40};
    const unsigned char clear[4] = {0, 0, 0, 0}, half[4] = {100, 0, 0, 128};
    memcpy(&over[0], clear, 4);
    memcpy(&over[1], half, 4);
    smooth_cover(over, 2, 1, out);
    CHECK_INT(out[0], 100);
    CHECK_INT(out[3], 100 + (100 * 127 + 127) / 255);
    CHECK_INT(out[4], (200 * 127 + 127) / 255);
}

/* ---- depths ------------------------------------------------------------ */

enum { SIDE = 32 };

/* A slanted square roof, z = 0.25 x, over |x|, |y| < 0.5, and its lower side; counter-clockwise from above and from below. */
static float roof[] = {-0.5f, -0.5f, -0.125f, 0.5f, -0.5f, 0.125f, 0.5f, 0.5f, 0.125f, -0.5f, 0.5f, -0.125f};
static uint32_t corners[] = {0, 1, 2, 0, 2, 3, 0, 2, 1, 0, 3, 2};

TEST(depths_of_a_roof_are_its_plane)
{
    float seen[12], above[SIDE * SIDE], below[SIDE * SIDE];
    CastGroup group = {0, 12, true};
    Casters c = {.places = roof, .seen = seen, .corners = corners, .groups = &group, .place_count = 4, .corner_count = 12, .group_count = 1};
    const float down[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};       /* z from 1 to -1 is depth 0 to 1 */
    cast_heights(&c, down, SIDE, above, below);
    int covered = 0;
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            double x = (i + 0.5) / SIDE * 2 - 1, y = (j + 0.5) / SIDE * 2 - 1;
            bool inside = fabs(x) < 0.5 && fabs(y) < 0.5;
            double depth = 0.5 - 0.5 * 0.25 * x;
            CHECK_NEAR((double)above[j * SIDE + i], inside ? depth : 1, 1e-6);
            CHECK_NEAR((double)below[j * SIDE + i], inside ? 1 - depth : 1, 1e-6);
            covered += inside;
        }
    CHECK_INT(covered, SIDE * SIDE / 4);
    /* pushed away by one and a half texels of its steepness */
    float nearest[SIDE * SIDE];
    cast_clear(nearest, SIDE);
    cast_nearest(&c, down, SIDE, 1.5f, nearest);
    int middle = SIDE / 2 * SIDE + SIDE / 2;
    CHECK_NEAR((double)(nearest[middle] - above[middle]), 1.5 * 0.125 * 2 / SIDE, 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(a_slanted_border_covers_its_share_of_each_pixel), unit_test(upright_is_treated_as_level),
        unit_test(what_is_one_face_stays_as_it_is),                 unit_test(an_overlay_covers_by_its_weight),
        unit_test(depths_of_a_roof_are_its_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
