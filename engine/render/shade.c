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

/* ---- subjects -------------------------------------------------------------- */

typedef struct Axes { float x[3], y[3], z[3]; } Axes;       /* of a solid, in the scene */

static float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]); }

static Axes axes_of(const float q[4])
{
    float x = q[0], y = q[1], z = q[2], w = q[3];
    return (Axes){{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                  {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                  {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

/* A direction of the scene in a solid's axes. */
static void turn_into(float out[3], const Axes *a, const float v[3])
{
    out[0] = dot3(a->x, v);
    out[1] = dot3(a->y, v);
    out[2] = dot3(a->z, v);
}

/* The row of a map from the scene, relative to the eye, as one from the solid's places. */
static void carry_row(float out[4], const Axes *a, const float row[3], float last, const float place[3])
{
    turn_into(out, a, row);
    out[3] = dot3(row, place) + last;
}

/* Rays of pixels from those of the picture, whose corners are at -1 and 1. */
static void set_rays(float out[3][3], const Frame *f, const Axes *a, int width, int height)
{
    float ray[3][3];
    for (int k = 0; k < 3; k++) {
        ray[0][k] = f->ray[0][k] * (2 / (float)width);
        ray[1][k] = f->ray[1][k] * (2 / (float)height);
        ray[2][k] = f->ray[2][k] + f->ray[0][k] * (1 / (float)width - 1) + f->ray[1][k] * (1 / (float)height - 1);
    }
    for (int k = 0; k < 3; k++)
        turn_into(out[k], a, ray[k]);
}

static SubjectForm form_of(const DrawItem *d)
{
    switch (d->key.form) {
    case FORM_SPHERE:   return SUBJECT_BALL;
    case FORM_BOX:      return SUBJECT_BOX;
    case FORM_CYLINDER: return SUBJECT_CYLINDER;
    default:            break;
    }
    if (d->key.plane)
        return SUBJECT_PLANE;
    return d->mesh >= MESH_CAPSULE && d->mesh < MESH_CAPSULE + MESH_LEVELS ? SUBJECT_CAPSULE : SUBJECT_SKY;
}

bool shade_can(const DrawItem *d) { return !d->key.clear && form_of(d) != SUBJECT_SKY; }

static uint32_t key_bits(unsigned key)
{
    const unsigned char bytes[4] = {0, 0, 0, (unsigned char)key};
    uint32_t bits;
    memcpy(&bits, bytes, sizeof bits);
    return bits;
}

static void set_keys(Subject *s, const DrawItem *d)
{
    unsigned number = d->instance.number[1] * 157u % 240u;
    for (unsigned side = 0; side < SIDES; side++)
        s->key[side] = key_bits(s->form == SUBJECT_PLANE ? 240 + number * 14 / 240 : (number + 37 * side) % 240);
}

static void set_maps(Subject *s, const Frame *f, const Axes *a, const float place[3])
{
    static const float up[3] = {0, 0, 1};
    for (int k = 0; k < 3; k++) {
        float row[3] = {f->to_sun[k], f->to_sun[4 + k], f->to_sun[8 + k]}, last = f->to_sun[12 + k];
        float scale = k < 2 ? SUN_SIZE : 1, shift = k < 2 ? -0.5f : -0.5f - f->sun[3];      /* middles of texels; bias */
        for (int i = 0; i < 3; i++)
            row[i] *= scale;
        carry_row(s->to_sun[k], a, row, last * scale + shift, place);
    }
    const float east[3] = {f->top[0], 0, 0}, north[3] = {0, f->top[0], 0};
    carry_row(s->to_top[0], a, east, f->eye[0] * f->top[0] + f->top[2], place);
    carry_row(s->to_top[1], a, north, f->eye[1] * f->top[0] + f->top[3], place);
    carry_row(s->to_top[2], a, up, f->eye[2], place);
    s->east[0] = a->x[0], s->east[1] = a->y[0], s->east[2] = a->z[0];
    s->north[0] = a->x[1], s->north[1] = a->y[1], s->north[2] = a->z[1];
    turn_into(s->up, a, up);
}

static void set_subject(Subject *s, const Frame *f, const DrawItem *d, int width, int height)
{
    const Instance *k = &d->instance;
    const float back[3] = {-k->place[0], -k->place[1], -k->place[2]};
    Axes a = axes_of(k->turn);
    *s = (Subject){.form = form_of(d), .pattern = d->key.pattern, .lamps = d->key.lamps, .shadows = d->key.shadows, .floor = d->key.floor,
                   .radius = k->size[0], .length = k->size[3], .seed = k->place[3]};
    memcpy(s->half, k->half, sizeof s->half);
    memcpy(s->look, k->look, sizeof s->look);
    memcpy(s->colour, k->colour, sizeof s->colour);
    turn_into(s->eye, &a, back);
    turn_into(s->sun, &a, f->sun);
    set_rays(s->ray, f, &a, width, height);
    set_maps(s, f, &a, k->place);
    set_keys(s, d);
    for (int i = 0; i < 3; i++) {
        s->inverse[i] = 1 / s->half[i];
        s->direct[i] = fmaxf(s->sun[1], 0) * f->sun_colour[i];
        s->sky[i] = f->ground[i] + (s->up[1] * 0.5f + 0.5f) * (f->zenith[i] - f->ground[i]);
    }
    for (int i = 0; i < s->lamps; i++) {
        turn_into(s->lamp[i], &a, f->lamp_at[i]);
        for (int axis = 0; axis < 3; axis++)
            s->lamp[i][axis] += s->eye[axis];
    }
}

static void set_sky(Subject *s, const Frame *f, int width, int height)
{
    static const Axes scene = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    *s = (Subject){.form = SUBJECT_SKY, .key = {key_bits(SKY_KEY)}};
    memcpy(s->sun, f->sun, sizeof s->sun);
    set_rays(s->ray, f, &scene, width, height);
}

/* ---- blocks ---------------------------------------------------------------- */

typedef struct ShadeJob {
    const ShadeSpace *space;
    const Frame      *frame;
    const Batches    *batches;
    const Light      *light;
    uint32_t         *raw;
    int               width, height;
} ShadeJob;

LANE_CODE void shade_block(const ShadeJob *job, const Subject *s, Block *b)
{
    int count = b->n;
    for (; b->n % LANE_STEP != 0; b->n++) {         /* the last pixel again */
        b->x[b->n] = b->x[count - 1];
        b->y[b->n] = b->y[count - 1];
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
    for (int i = 0; i < count; i++)
        job->raw[b->place[i]] = b->out[i];
    b->n = 0;
}

LANE_CODE void shade_subject(const ShadeJob *job, int number)
{
    Subject s;
    Block b;
    int first = job->space->first[number], last = job->space->first[number + 1];
    if (first == last)
        return;
    if (number == 0)
        set_sky(&s, job->frame, job->width, job->height);
    else
        set_subject(&s, job->frame, &job->batches->items[number - 1], job->width, job->height);
    b.n = 0;
    for (int r = first; r < last; r++) {
        ShadeRun run = job->space->sorted[r];
        while (run.count > 0) {
            uint32_t some = run.count < (uint32_t)(LANES - b.n) ? run.count : (uint32_t)(LANES - b.n);
            uint32_t place = run.y * (uint32_t)job->width + run.x;
            for (uint32_t i = 0; i < some; i++) {
                b.x[(uint32_t)b.n + i] = (float)(int32_t)(run.x + i);
                b.y[(uint32_t)b.n + i] = (float)(int32_t)run.y;
                b.place[(uint32_t)b.n + i] = place + i;
            }
            b.n += (int)some;
            run.x += some;
            run.count -= some;
            if (b.n == LANES || (r == last - 1 && run.count == 0))
                shade_block(job, &s, &b);
        }
    }
}

static void shade_plainly(const ShadeJob *job)
{
    for (int i = 0; i <= job->batches->count; i++)
        shade_subject(job, i);
}

/* The same with vectors twice as long, where the processor has them. The bits are the same: no operation is fused. */
#ifdef __x86_64__
__attribute__((target("avx2"))) static void shade_widely(const ShadeJob *job)
{
    for (int i = 0; i <= job->batches->count; i++)
        shade_subject(job, i);
}

static bool has_wide(void) { return __builtin_cpu_supports("avx2"); }
#else
static void shade_widely(const ShadeJob *job) { shade_plainly(job); }
static bool has_wide(void) { return false; }
#endif

dig_status shade_picture(ShadeSpace *space, const Frame *frame, const Batches *b, const Light *l, uint32_t *raw, int width, int height)
{
    if (!index_items(space, b) || !find_runs(space, b, raw, width, height) || !sort_runs(space, b->count + 1))
        return DIG_E_MEMORY;
    ShadeJob job = {space, frame, b, l, raw, width, height};
    (has_wide() ? shade_widely : shade_plainly)(&job);
    return DIG_OK;
}

void shade_close(ShadeSpace *space)
{
    free(space->runs);
    free(space->sorted);
    free(space->item);
    free(space->first);
    *space = (ShadeSpace){0};
}
