/* render/subject.c - takes items apart for the shading by the CPU. */
#include "render/subject.h"

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

bool subject_can(const DrawItem *d) { return !d->key.clear && form_of(d) != SUBJECT_SKY; }

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

void subject_set(Subject *s, const Frame *f, const DrawItem *d, int width, int height)
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
    for (int i = 0; i < 3 && s->form == SUBJECT_PLANE; i++)
        s->mirror[i] = 0.08f + s->look[3] * (s->colour[i] - 0.08f);
    s->sheen = s->form == SUBJECT_PLANE ? s->look[1] : 0;
    for (int i = 0; i < s->lamps; i++) {
        turn_into(s->lamp[i], &a, f->lamp_at[i]);
        for (int axis = 0; axis < 3; axis++)
            s->lamp[i][axis] += s->eye[axis];
    }
}

void subject_set_sky(Subject *s, const Frame *f, int width, int height)
{
    static const Axes scene = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    *s = (Subject){.form = SUBJECT_SKY, .key = {key_bits(SKY_KEY)}};
    memcpy(s->sun, f->sun, sizeof s->sun);
    set_rays(s->ray, f, &scene, width, height);
}

/* ---- where it shows --------------------------------------------------------- */

typedef struct Bounds { float low[2], high[2]; bool all; } Bounds;      /* -1..1; all: somewhere in the picture */

/* A ball's outline is a cone round the eye; its sides, seen along either axis of the picture, are tangents of a circle. */
static void include_ball(Bounds *b, const Frame *f, const float at[3], float radius)
{
    float z = dot3(at, f->forward);
    for (int k = 0; k < 2; k++) {
        float scale = sqrtf(dot3(f->ray[k], f->ray[k])), x = dot3(at, f->ray[k]) / scale, square = z * z - radius * radius;
        float root = radius * sqrtf(fmaxf(x * x + square, 0));
        b->all = b->all || !(z > 1.01f * radius);
        if (b->all)
            return;
        b->low[k] = fminf(b->low[k], (x * z - root) / (square * scale));
        b->high[k] = fmaxf(b->high[k], (x * z + root) / (square * scale));
    }
}

static void include_point(Bounds *b, const Frame *f, const float at[3], float near)
{
    float z = dot3(at, f->forward);
    b->all = b->all || !(z > near);
    for (int k = 0; k < 2 && !b->all; k++) {
        float x = dot3(at, f->ray[k]) / (dot3(f->ray[k], f->ray[k]) * z);
        b->low[k] = fminf(b->low[k], x);
        b->high[k] = fmaxf(b->high[k], x);
    }
}

static void include_box(Bounds *b, const Frame *f, const float place[3], const Axes *a, const float half[3], float near)
{
    for (int corner = 0; corner < 8; corner++) {
        float p[3], x = corner & 1 ? half[0] : -half[0], y = corner & 2 ? half[1] : -half[1], z = corner & 4 ? half[2] : -half[2];
        for (int k = 0; k < 3; k++)
            p[k] = place[k] + (x * a->x[k] + (y * a->y[k] + z * a->z[k]));
        include_point(b, f, p, near);
    }
}

/* -1..1 to pixels, with one to spare. */
static int pixel_of(float x, int size, int more)
{
    float p = 0.5f * (x + 1) * (float)size + (float)more;
    return p > 0 ? p < (float)size ? (int)p : size : 0;
}

SubjectRange subject_range(const Subject *s, const Frame *f, const DrawItem *d, real near, int width, int height)
{
    const Instance *k = &d->instance;
    Bounds b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, s->form == SUBJECT_PLANE};
    Axes a = axes_of(k->turn);
    if (s->form == SUBJECT_BALL || s->form == SUBJECT_CAPSULE) {
        for (int end = -1; end <= 1; end += 2) {
            float at[3], off = s->form == SUBJECT_CAPSULE ? 0.5f * s->length * (float)end : 0;
            for (int i = 0; i < 3; i++)
                at[i] = k->place[i] + off * a.y[i];
            include_ball(&b, f, at, s->radius);
        }
    } else if (s->form != SUBJECT_PLANE) {
        const float half[3] = {s->form == SUBJECT_BOX ? s->half[0] : s->radius, s->half[1], s->form == SUBJECT_BOX ? s->half[2] : s->radius};
        include_box(&b, f, k->place, &a, half, (float)near);
    }
    if (b.all)
        return (SubjectRange){0, 0, width, height};
    return (SubjectRange){pixel_of(b.low[0], width, -1), pixel_of(b.low[1], height, -1), pixel_of(b.high[0], width, 2),
                          pixel_of(b.high[1], height, 2)};
}
