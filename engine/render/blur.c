/* render/blur.c - pictures worked on by the CPU: a box blur whose cost does not depend on its width, and a marbling. */
#include "render/light.h"
#include "render/wide.h"

LANE_CODE int clamp_index(int i, int n) { return i < 0 ? 0 : i >= n ? n - 1 : i; }

/* One number of each of four rows. */
typedef float Four __attribute__((vector_size(16)));

/* Four columns of four rows; becomes four rows of four columns. */
LANE_CODE void turn_over(Four t[4])
{
    Four a = __builtin_shufflevector(t[0], t[1], 0, 4, 1, 5), b = __builtin_shufflevector(t[2], t[3], 0, 4, 1, 5);
    Four c = __builtin_shufflevector(t[0], t[1], 2, 6, 3, 7), d = __builtin_shufflevector(t[2], t[3], 2, 6, 3, 7);
    t[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    t[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    t[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    t[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}

/* Four rows of n at once, laid across: a running sum waits for itself, four wait together. */
LANE_CODE void blur_four(const float *in, float *out, int n, int radius)
{
    Four across[FLOOR_SIZE], sum = {0}, t[4];
    const float scale = 1.0f / (float)(2 * radius + 1);
    for (int x = 0; x < n; x += 4) {
        for (int j = 0; j < 4; j++)
            memcpy(&t[j], in + j * n + x, sizeof *t);
        turn_over(t);
        memcpy(across + x, t, sizeof t);
    }
    for (int k = -radius; k <= radius; k++)
        sum += across[clamp_index(k, n)];
    for (int x = 0; x < n; x += 4) {
        for (int k = 0; k < 4; k++) {
            t[k] = sum * scale;
            sum += across[int_min(x + k + radius + 1, n - 1)] - across[int_max(x + k - radius, 0)];
        }
        turn_over(t);
        for (int j = 0; j < 4; j++)
            memcpy(out + j * n + x, &t[j], sizeof *t);
    }
}

/* n is a multiple of four */
LANE_CODE void blur_rows(const float *in, float *out, int n, int radius)
{
    for (int y = 0; y < n; y += 4)
        blur_four(in + (size_t)y * (size_t)n, out + (size_t)y * (size_t)n, n, radius);
}

/* Keeps one sum for each column, so that memory is walked row by row. */
LANE_CODE void blur_columns(const float *in, float *out, int n, int radius)
{
    float sum[FLOOR_SIZE], scale = 1.0f / (float)(2 * radius + 1);
    for (int x = 0; x < n; x++)
        sum[x] = 0;
    for (int k = -radius; k <= radius; k++) {
        const float *row = in + (size_t)clamp_index(k, n) * (size_t)n;
        for (int x = 0; x < n; x++)
            sum[x] += row[x];
    }
    for (int y = 0; y < n; y++) {
        float *to = out + (size_t)y * (size_t)n;
        const float *enter = in + (size_t)clamp_index(y + radius + 1, n) * (size_t)n;
        const float *leave = in + (size_t)clamp_index(y - radius, n) * (size_t)n;
        for (int x = 0; x < n; x++) {
            to[x] = sum[x] * scale;
            sum[x] += enter[x] - leave[x];
        }
    }
}

LANE_CODE void blur_both(float *data, float *scratch, int n, int radius)
{
    blur_rows(data, scratch, n, radius);
    blur_columns(scratch, data, n, radius);
}

static void blur_plainly(float *data, float *scratch, int n, int radius) { blur_both(data, scratch, n, radius); }
WIDE static void blur_widely(float *data, float *scratch, int n, int radius) { blur_both(data, scratch, n, radius); }

void blur_box(float *data, float *scratch, int n, int radius)
{
    DIG_ASSERT(n <= FLOOR_SIZE && n % 4 == 0);
    if (radius >= 1)
        (has_wide() ? blur_widely : blur_plainly)(data, scratch, n, radius);
}

/* ---- marbling ---------------------------------------------------------- */

static float lattice(int x, int y, int period)
{
    uint32_t h = (uint32_t)(x & (period - 1)) * 0x27d4eb2du ^ (uint32_t)(y & (period - 1)) * 0x9e3779b1u ^ (uint32_t)period * 0x85ebca6bu;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)(h >> 8) / 16777216.0f;
}

/* Value noise on a lattice of `period` cells round the square. */
static float value_noise(int x, int y, int n, int period)
{
    int cell = n / period, i = x / cell, j = y / cell;
    float u = (float)(x % cell) / (float)cell, v = (float)(y % cell) / (float)cell;
    u = u * u * (3 - 2 * u);
    v = v * v * (3 - 2 * v);
    float low = lattice(i, j, period) + u * (lattice(i + 1, j, period) - lattice(i, j, period));
    float high = lattice(i, j + 1, period) + u * (lattice(i + 1, j + 1, period) - lattice(i, j + 1, period));
    return low + v * (high - low);
}

void marble_fill(unsigned char *out, int n)
{
    for (int y = 0; y < n; y++)
        for (int x = 0; x < n; x++) {
            float sum = 0, weight = 0.5f;
            for (int period = 8; period <= 128; period *= 2, weight *= 0.62f)
                sum += weight * (value_noise(x, y, n, period) - 0.5f);
            out[y * n + x] = (unsigned char)(128 + 150 * sum);
        }
}
