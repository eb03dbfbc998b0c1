/* render/blur.c - pictures worked on by the CPU: a box blur whose cost does not depend on its width, and a marbling. */
#include "render/light.h"

static int clamp_index(int i, int n) { return i < 0 ? 0 : i >= n ? n - 1 : i; }

/* Four rows of n at once: a running sum waits for itself, four wait together. */
static void blur_four(const float *in, float *out, int n, int radius)
{
    float sum[4] = {0}, scale = 1.0f / (float)(2 * radius + 1);
    for (int k = -radius; k <= radius; k++)
        for (int j = 0; j < 4; j++)
            sum[j] += in[j * n + clamp_index(k, n)];
    for (int x = 0; x < n; x++) {
        const float *enter = in + int_min(x + radius + 1, n - 1), *leave = in + int_max(x - radius, 0);
        for (int j = 0; j < 4; j++) {
            out[j * n + x] = sum[j] * scale;
            sum[j] += enter[j * n] - leave[j * n];
        }
    }
}

/* n is a multiple of four */
static void blur_rows(const float *in, float *out, int n, int radius)
{
    for (int y = 0; y < n; y += 4)
        blur_four(in + (size_t)y * (size_t)n, out + (size_t)y * (size_t)n, n, radius);
}

/* Keeps one sum for each column, so that memory is walked row by row. */
static void blur_columns(const float *in, float *out, int n, int radius)
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

void blur_box(float *data, float *scratch, int n, int radius)
{
    DIG_ASSERT(n <= FLOOR_SIZE && n % 4 == 0);
    if (radius < 1)
        return;
    blur_rows(data, scratch, n, radius);
    blur_columns(scratch, data, n, radius);
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
