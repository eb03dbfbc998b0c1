/* render/shade.c - finds what a picture's pixels show, sorts them by that, and shades them block by block; a band of rows at a time. */
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

/* A band of the picture: as many rows as are worked on while the processor's own memory still holds them. */
enum { BAND = 32 };

static bool fit_band(ShadeSpace *space, int width)
{
    void *depth = space->depth, *ends = space->ends;
    bool ok = fit(&depth, &space->depth_capacity, (size_t)BAND * (size_t)width + LANE_STEP, sizeof *space->depth) &&
              fit(&ends, &space->end_capacity, (size_t)width + 8, 1);
    space->depth = depth;
    space->ends = ends;
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
    space->most_index = most_index;
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
static int subject_of(const ShadeSpace *space, uint32_t pixel)
{
    unsigned char p[4];
    memcpy(p, &pixel, sizeof p);
    if (p[3] == SKY_KEY)
        return 0;
    int index = p[0] | p[1] << 8 | p[2] << 16;
    return p[3] == SHADE_KEY && index <= space->most_index ? space->item[index] + 1 : -1;
}

/* Marks the last of each run of equal pixels among n. */
LANE_CODE void mark_ends(const uint32_t *row, int n, unsigned char *ends)
{
    for (int i = 0; i + 1 < n; i++)
        ends[i] = row[i] != row[i + 1];
    ends[n - 1] = 1;
}

static void mark_plainly(const uint32_t *row, int n, unsigned char *ends) { mark_ends(row, n, ends); }
WIDE static void mark_widely(const uint32_t *row, int n, unsigned char *ends) { mark_ends(row, n, ends); }

/* Where the next mark is from x on; there is one. Eight more bytes may be read. */
static int next_mark(const unsigned char *ends, int x)
{
    for (uint64_t eight;; x += 8) {
        memcpy(&eight, ends + x, sizeof eight);
        if (eight != 0)
            break;
    }
    while (!ends[x])
        x++;
    return x;
}

/* The runs of equal pixels in rows [low, high), and how many each subject has in first[subject + 1]. */
static bool find_runs(ShadeSpace *space, int subjects, const uint32_t *raw, int width, int low, int high)
{
    bool wide = has_wide();
    space->run_count = 0;
    memset(space->first, 0, ((size_t)subjects + 1) * sizeof *space->first);
    for (int y = low; y < high; y++) {
        const uint32_t *row = raw + (size_t)y * (size_t)width;
        if (!fit_runs(&space->runs, &space->run_capacity, (size_t)space->run_count + (size_t)width))
            return false;
        (wide ? mark_widely : mark_plainly)(row, width, space->ends);
        for (int x = 0, end; x < width; x = end) {
            end = next_mark(space->ends, x) + 1;
            int subject = subject_of(space, row[x]);
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
    int               width, height, low, high;     /* the picture; rows [low, high) of it are the band */
    const ShadeEye   *eye;
    bool              numbers;          /* what to do: number the band's pixels, or shade them */
    bool              known;            /* space->depth says where the band's rays meet the solids */
} ShadeJob;

static uint32_t pixel_bits(int red, int green, int blue, int alpha)
{
    const unsigned char bytes[4] = {(unsigned char)red, (unsigned char)green, (unsigned char)blue, (unsigned char)alpha};
    uint32_t bits;
    memcpy(&bits, bytes, sizeof bits);
    return bits;
}

static uint32_t number_of(int index) { return pixel_bits(index & 255, index >> 8 & 255, index >> 16 & 255, SHADE_KEY); }

static bool set_subjects(ShadeSpace *space, const Frame *frame, const Batches *b, real near, int width, int height)
{
    if (!fit_subjects(space, (size_t)b->count + 1))
        return false;
    subject_set_sky(&space->subjects[0], frame, width, height);
    for (int i = 0; i < b->count; i++) {
        Subject *s = &space->subjects[i + 1];
        subject_set(s, frame, &b->items[i], width, height);
        if (near > 0)
            s->range = subject_range(s, frame, &b->items[i], near, width, height);
    }
    return true;
}

LANE_CODE void shade_block(const ShadeJob *job, const Subject *s, Block *b)
{
    for (int last = b->n - 1; b->n % LANE_STEP != 0; b->n++) {      /* the last pixel again */
        b->x[b->n] = b->x[last];
        b->y[b->n] = b->y[last];
        b->t[b->n] = b->t[last];
    }
    cast_rays(s, b);
    if (s->form == SUBJECT_SKY) {
        shine_sky(s, job->frame, b);
    } else {
        if (!job->known)
            find(s, b);
        follow_rays(s, b);
        face(s, b);
        look(s, b);
        reach(s, job->light, job->frame, b);
        throw_light(s, job->frame, b);
        fade(job->frame, b);
    }
    show(s, &job->eye->mirror, job->width, job->height, b);
    for (int k = 0; k < b->parts; k++)
        memcpy(job->raw + b->part[k].place, b->out + b->part[k].first, (size_t)b->part[k].count * sizeof *b->out);
    b->n = b->parts = 0;
}

/* Takes up to `count` pixels from (x, y) on into the block; so many as there is room for. Whole vectors are filled. */
LANE_CODE int take_pixels(const ShadeJob *job, Block *b, int x, int y, int count)
{
    const int n = b->n, some = int_min(count, LANES - n);
    const size_t place = (size_t)y * (size_t)job->width + (size_t)x;
    const float *depth = job->known ? job->space->depth + (place - (size_t)job->low * (size_t)job->width) : NULL, fy = (float)y;
    for (int k = 0; k < some; k += LANE_STEP) {
        const float fx = (float)(x + k);
        for (int i = 0; i < LANE_STEP; i++)
            b->x[n + k + i] = fx + (float)i;
        for (int i = 0; i < LANE_STEP; i++)
            b->y[n + k + i] = fy;
        if (depth)
            memcpy(b->t + n + k, depth + k, LANE_STEP * sizeof *b->t);
    }
    b->part[b->parts].place = (uint32_t)place;
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

/* Nothing nearer is seen: than `near`, or, in a mirror, than the floor: `rise` above the eye, where rays rise by base + step x. */
typedef struct Sill { float near, rise, base, step; } Sill;

/* Casts rays from n pixels, from (x, y) on to the right, and numbers those for which the solid is the nearest so far. `base` and
 * `step`: the ray of x = 0 in this row, and what it gains from pixel to pixel. */
LANE_CODE void number_pixels(const Solid *solid, SubjectForm form, const float base[3], const float step[3], int x, int n, Sill sill,
                             uint32_t number, float *depth, uint32_t *raw)
{
    for (int i = 0; i < n; i++) {
        float at = (float)(x + i), near = sill.rise > 0 ? sill.rise / most(sill.step * at + sill.base, 1e-9f) : sill.near;
        Reach r = reach_form(solid, form, step[0] * at + base[0], step[1] * at + base[1], step[2] * at + base[2]);
        bool nearest = (r.miss <= 0) & (r.t > near) & (r.t < depth[i]);
        depth[i] = nearest ? r.t : depth[i];
        raw[i] = nearest ? number : raw[i];
    }
}

/* All pixels of the band where a subject may show, LANE_STEP at a time: a few more than asked for, which miss, or are met twice, to no effect. */
LANE_CODE void number_range(const ShadeJob *job, const Subject *s, SubjectForm form, uint32_t number)
{
    const SubjectRange range = s->range;
    const Subject *sky = &job->space->subjects[0];          /* its rays lie in the scene's axes */
    Sill sill = {(float)job->eye->near, (float)job->eye->rise, 0, sky->ray[0][2]};
    const Solid solid = solid_of(s);
    const float step[3] = {s->ray[0][0], s->ray[0][1], s->ray[0][2]};
    const int width = job->width;
    for (int y = int_max(range.y0, job->low); y < int_min(range.y1, job->high); y++) {
        float *depth = job->space->depth + (size_t)(y - job->low) * (size_t)width, base[3];
        uint32_t *raw = job->raw + (size_t)y * (size_t)width;
        sill.base = sky->ray[1][2] * (float)y + sky->ray[2][2];
        for (int k = 0; k < 3; k++)
            base[k] = s->ray[1][k] * (float)y + s->ray[2][k];
        if (form == SUBJECT_PLANE && !(least(base[1], base[1] + step[1] * (float)width) < 0))
            continue;               /* above its horizon */
        if (width < LANE_STEP)
            number_pixels(&solid, form, base, step, 0, width, sill, number, depth, raw);
        else
            for (int x = range.x0; x < range.x1; x += LANE_STEP) {
                int from = int_min(x, width - LANE_STEP);
                number_pixels(&solid, form, base, step, from, LANE_STEP, sill, number, depth + from, raw + from);
            }
    }
}

/* Numbers the pixels of the band for which a subject is the nearest so far. */
LANE_CODE void number_subject(const ShadeJob *job, const Subject *s, const DrawItem *d)
{
    uint32_t number = number_of(d->index);
    switch (s->form) {
    case SUBJECT_PLANE:    number_range(job, s, SUBJECT_PLANE, number); break;
    case SUBJECT_BOX:      number_range(job, s, SUBJECT_BOX, number); break;
    case SUBJECT_BALL:     number_range(job, s, SUBJECT_BALL, number); break;
    case SUBJECT_CAPSULE:  number_range(job, s, SUBJECT_CAPSULE, number); break;
    case SUBJECT_CYLINDER: number_range(job, s, SUBJECT_CYLINDER, number); break;
    case SUBJECT_SKY:      break;
    }
}

LANE_CODE void number_all(const ShadeJob *job)
{
    const uint32_t sky = pixel_bits(0, 0, 0, SKY_KEY);
    const size_t count = (size_t)(job->high - job->low) * (size_t)job->width;
    uint32_t *raw = job->raw + (size_t)job->low * (size_t)job->width;
    float *depth = job->space->depth;
    for (size_t i = 0; i < count; i++)
        raw[i] = sky;
    for (size_t i = 0; i < count; i++)
        depth[i] = INFINITY;
    for (int i = 0; i < job->batches->count; i++)
        number_subject(job, &job->space->subjects[i + 1], &job->batches->items[i]);
}

/* ---- both ------------------------------------------------------------------- */

LANE_CODE void run_job(const ShadeJob *job)
{
    if (job->numbers)
        number_all(job);
    else
        for (int i = 0; i <= job->batches->count; i++)
            shade_subject(job, i);
}

static void run_plainly(const ShadeJob *job) { run_job(job); }

WIDE static void run_widely(const ShadeJob *job) { run_job(job); }

static void run(const ShadeJob *job) { (has_wide() ? run_widely : run_plainly)(job); }

dig_status shade_picture(ShadeSpace *space, const Frame *frame, const Batches *b, const Light *l, const ShadeEye *eye, uint32_t *raw, int width,
                         int height)
{
    if (!set_subjects(space, frame, b, eye->near, width, height) || !index_items(space, b) || !fit_band(space, width))
        return DIG_E_MEMORY;
    memset(space->ends, 0, (size_t)width + 8);
    ShadeJob job = {space, frame, b, l, raw, width, height, 0, 0, eye, false, eye->near > 0};
    for (job.low = 0; job.low < height; job.low = job.high) {
        job.high = int_min(height, job.low + BAND);
        job.numbers = job.known;
        if (job.numbers)
            run(&job);
        job.numbers = false;
        if (!find_runs(space, b->count + 1, raw, width, job.low, job.high) || !sort_runs(space, b->count + 1))
            return DIG_E_MEMORY;
        run(&job);
    }
    return DIG_OK;
}

void shade_close(ShadeSpace *space)
{
    free(space->runs);
    free(space->sorted);
    free(space->item);
    free(space->first);
    free(space->depth);
    free(space->ends);
    free(space->subjects);
    *space = (ShadeSpace){0};
}
