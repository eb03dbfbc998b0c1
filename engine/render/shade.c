/* render/shade.c - sorts a picture's pixels by what they show, and shades them block by block. */
#include "render/shade.h"

#include <stdlib.h>

#include "render/block_light.h"
#include "render/block_look.h"

/* ---- runs ----------------------------------------------------------------- */

static bool fit(void **data, int *capacity, size_t wanted, size_t each)
{
    if (wanted <= (size_t)*capacity)
        return true;
    size_t roomy = wanted + wanted / 2 + 16;
    void *larger = roomy < INT32_MAX ? realloc(*data, roomy * each) : NULL;
    if (!larger)
        return false;
    *data = larger;
    *capacity = (int)roomy;
    return true;
}

static bool fit_runs(ShadeRun **runs, int *capacity, size_t wanted)
{
    void *data = *runs;
    bool ok = fit(&data, capacity, wanted, sizeof **runs);
    *runs = data;
    return ok;
}

static bool fit_ints(int **numbers, int *capacity, size_t wanted)
{
    void *data = *numbers;
    bool ok = fit(&data, capacity, wanted, sizeof **numbers);
    *numbers = data;
    return ok;
}

static bool fit_pixels(ShadeSpace *space, size_t pixels)
{
    void *data = space->depth;
    bool ok = fit(&data, &space->depth_capacity, pixels, sizeof *space->depth);
    space->depth = data;
    return ok;
}

static bool fit_subjects(ShadeSpace *space, size_t count)
{
    void *data = space->subjects;
    bool ok = fit(&data, &space->subject_capacity, count, sizeof *space->subjects);
    space->subjects = data;
    return ok;
}

static bool index_items(ShadeSpace *space, const Batches *b)
{
    int most_index = -1;
    for (int i = 0; i < b->count; i++)
        most_index = int_max(most_index, b->items[i].index);
    if (!fit_ints(&space->item, &space->item_capacity, (size_t)most_index + 1) ||
        !fit_ints(&space->first, &space->first_capacity, (size_t)b->count + 2))
        return false;
    for (int i = 0; i <= most_index; i++)
        space->item[i] = -1;
    for (int i = 0; i < b->count; i++)
        space->item[b->items[i].index] = i;
    return true;
}

/* What a pixel shows: 0 the sky, 1 + the number in the batches; -1 = it is shaded already. */
static int subject_of(const ShadeSpace *space, uint32_t pixel, int most_index)
{
    unsigned char p[4];
    memcpy(p, &pixel, sizeof p);
    if (p[3] == SKY_KEY)
        return 0;
    int index = p[0] | p[1] << 8 | p[2] << 16;
    return p[3] == SHADE_KEY && index <= most_index ? space->item[index] + 1 : -1;
}

/* The runs of equal pixels in all rows, and how many each subject has in first[subject + 1]. */
static bool find_runs(ShadeSpace *space, const Batches *b, const uint32_t *raw, int width, int height)
{
    int most_index = -1;
    for (int i = 0; i < b->count; i++)
        most_index = int_max(most_index, b->items[i].index);
    space->run_count = 0;
    memset(space->first, 0, ((size_t)b->count + 2) * sizeof *space->first);
    for (int y = 0; y < height; y++) {
        const uint32_t *row = raw + (size_t)y * (size_t)width;
        if (!fit_runs(&space->runs, &space->run_capacity, (size_t)space->run_count + (size_t)width))
            return false;
        for (int x = 0, end; x < width; x = end) {
            for (end = x + 1; end < width && row[end] == row[x]; end++) {
            }
            int subject = subject_of(space, row[x], most_index);
            if (subject < 0)
                continue;
            space->runs[space->run_count++] = (ShadeRun){(uint32_t)subject, (uint32_t)x, (uint32_t)y, (uint32_t)(end - x)};
            space->first[subject + 1]++;
        }
    }
    return true;
}

/* By subject, each one's from below; first[subject] is then where its runs begin. */
static bool sort_runs(ShadeSpace *space, int subjects)
{
    if (!fit_runs(&space->sorted, &space->sorted_capacity, (size_t)space->run_count))
        return false;
    for (int i = 0; i < subjects; i++)
        space->first[i + 1] += space->first[i];
    for (int i = space->run_count - 1; i >= 0; i--)         /* from the back: ends become beginnings */
        space->sorted[--space->first[space->runs[i].subject + 1]] = space->runs[i];
    memmove(space->first, space->first + 1, (size_t)subjects * sizeof *space->first);
    space->first[subjects] = space->run_count;
    return true;
}

/* ---- blocks ---------------------------------------------------------------- */

typedef struct ShadeJob {
    const ShadeSpace *space;
    const Frame      *frame;
    const Batches    *batches;
    const Light      *light;
    uint32_t         *raw;
    int               width, height;
    real              near;             /* scene units; nearer things are not seen */
    bool              numbers;          /* what to do */
} ShadeJob;

static uint32_t pixel_bits(int red, int green, int blue, int alpha)
{
    const unsigned char bytes[4] = {(unsigned char)red, (unsigned char)green, (unsigned char)blue, (unsigned char)alpha};
    uint32_t bits;
    memcpy(&bits, bytes, sizeof bits);
    return bits;
}

static uint32_t number_of(int index) { return pixel_bits(index & 255, index >> 8 & 255, index >> 16 & 255, SHADE_KEY); }

static bool set_subjects(ShadeSpace *space, const Frame *frame, const Batches *b, int width, int height)
{
    if (!fit_subjects(space, (size_t)b->count + 1))
        return false;
    subject_set_sky(&space->subjects[0], frame, width, height);
    for (int i = 0; i < b->count; i++)
        subject_set(&space->subjects[i + 1], frame, &b->items[i], width, height);
    return true;
}

LANE_CODE void shade_block(const ShadeJob *job, const Subject *s, Block *b)
{
    for (int last = b->n - 1; b->n % LANE_STEP != 0; b->n++) {      /* the last pixel again */
        b->x[b->n] = b->x[last];
        b->y[b->n] = b->y[last];
    }
    cast_rays(s, b);
    if (s->form == SUBJECT_SKY) {
        shine_sky(s, job->frame, b);
    } else {
        meet(s, b);
        look(s, b);
        reach(s, job->light, job->frame, b);
        throw_light(s, job->frame, b);
        fade(job->frame, b);
    }
    show(s, b);
    for (int k = 0; k < b->parts; k++)
        memcpy(job->raw + b->part[k].place, b->out + b->part[k].first, (size_t)b->part[k].count * sizeof *b->out);
    b->n = b->parts = 0;
}

/* Takes up to `count` pixels from (x, y) on into the block; so many as there is room for. */
LANE_CODE int take_pixels(const ShadeJob *job, Block *b, int x, int y, int count)
{
    int some = int_min(count, LANES - b->n);
    float *to_x = b->x + b->n, *to_y = b->y + b->n;
    for (int i = 0; i < some; i++) {
        to_x[i] = (float)(x + i);
        to_y[i] = (float)y;
    }
    b->part[b->parts].place = (uint32_t)(y * job->width + x);
    b->part[b->parts].first = b->n;
    b->part[b->parts++].count = some;
    b->n += some;
    return some;
}

LANE_CODE void shade_subject(const ShadeJob *job, int number)
{
    const Subject *s = &job->space->subjects[number];
    const ShadeRun *last = job->space->sorted + job->space->first[number + 1];
    Block b;
    b.n = b.parts = 0;
    for (const ShadeRun *r = job->space->sorted + job->space->first[number]; r < last; r++)
        for (int done = 0; done < (int)r->count;) {
            done += take_pixels(job, &b, (int)r->x + done, (int)r->y, (int)r->count - done);
            if (b.n == LANES || (r + 1 == last && done == (int)r->count))
                shade_block(job, s, &b);
        }
}

/* ---- numbers --------------------------------------------------------------- */

/* Casts rays at a subject from all pixels where it may show, and numbers those where it is the nearest so far. */
LANE_CODE void number_subject(const ShadeJob *job, const Subject *s, const DrawItem *d)
{
    SubjectRange range = subject_range(s, job->frame, d, job->near, job->width, job->height);
    const uint32_t number = number_of(d->index);
    const float near = (float)job->near;
    Block b;
    for (int y = range.y0; y < range.y1; y++)
        for (int x = range.x0; x < range.x1; x += LANES) {
            int count = int_min(range.x1 - x, LANES);
            b.n = (count + LANE_STEP - 1) / LANE_STEP * LANE_STEP;
            for (int i = 0; i < b.n; i++) {
                b.x[i] = (float)(x + i);
                b.y[i] = (float)y;
            }
            cast_rays(s, &b);
            find(s, &b);
            size_t first = (size_t)y * (size_t)job->width + (size_t)x;
            float *depth = job->space->depth + first;
            uint32_t *raw = job->raw + first;
            for (int i = 0; i < count; i++) {
                bool nearest = (b.miss[i] <= 0) & (b.t[i] > near) & (b.t[i] < depth[i]);
                depth[i] = nearest ? b.t[i] : depth[i];
                raw[i] = nearest ? number : raw[i];
            }
        }
}

/* ---- both ------------------------------------------------------------------- */

LANE_CODE void run_job(const ShadeJob *job)
{
    if (job->numbers) {
        for (int i = 0; i < job->batches->count; i++)
            number_subject(job, &job->space->subjects[i + 1], &job->batches->items[i]);
    } else {
        for (int i = 0; i <= job->batches->count; i++)
            shade_subject(job, i);
    }
}

static void run_plainly(const ShadeJob *job) { run_job(job); }

WIDE static void run_widely(const ShadeJob *job) { run_job(job); }

static void run(const ShadeJob *job) { (has_wide() ? run_widely : run_plainly)(job); }

dig_status shade_number(ShadeSpace *space, const Frame *frame, const Batches *b, real near, uint32_t *raw, int width, int height)
{
    size_t pixels = (size_t)width * (size_t)height;
    if (!fit_pixels(space, pixels) || !set_subjects(space, frame, b, width, height))
        return DIG_E_MEMORY;
    uint32_t sky = pixel_bits(0, 0, 0, SKY_KEY);
    for (size_t i = 0; i < pixels; i++) {
        space->depth[i] = INFINITY;
        raw[i] = sky;
    }
    ShadeJob job = {space, frame, b, NULL, raw, width, height, near, true};
    run(&job);
    return DIG_OK;
}

dig_status shade_picture(ShadeSpace *space, const Frame *frame, const Batches *b, const Light *l, uint32_t *raw, int width, int height)
{
    if (!set_subjects(space, frame, b, width, height) || !index_items(space, b) || !find_runs(space, b, raw, width, height) ||
        !sort_runs(space, b->count + 1))
        return DIG_E_MEMORY;
    ShadeJob job = {space, frame, b, l, raw, width, height, 0, false};
    run(&job);
    return DIG_OK;
}

void shade_close(ShadeSpace *space)
{
    free(space->runs);
    free(space->sorted);
    free(space->item);
    free(space->first);
    free(space->depth);
    free(space->subjects);
    *space = (ShadeSpace){0};
}
