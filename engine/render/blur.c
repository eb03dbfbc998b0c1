/* render/blur.c - a box blur whose cost does not depend on its width. */
#include "render/light.h"

static int clamp_index(int i, int n) { return i < 0 ? 0 : i >= n ? n - 1 : i; }

static void blur_rows(const float *in, float *out, int n, int radius)
{
    float scale = 1.0f / (float)(2 * radius + 1);
    for (int y = 0; y < n; y++) {
        const float *row = in + (size_t)y * (size_t)n;
        float *to = out + (size_t)y * (size_t)n;
        float sum = 0;
        for (int k = -radius; k <= radius; k++)
            sum += row[clamp_index(k, n)];
        for (int x = 0; x < n; x++) {
            to[x] = sum * scale;
            sum += row[clamp_index(x + radius + 1, n)] - row[clamp_index(x - radius, n)];
        }
    }
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
    DIG_ASSERT(n <= FLOOR_SIZE);
    if (radius < 1)
        return;
    blur_rows(data, scratch, n, radius);
    blur_columns(scratch, data, n, radius);
}
