/* render/camera.c - a camera that sees everything, and the options everybody starts from. */
#include "render/render.h"
#include "render/stage.h"

/* Measured (llvmpipe of Mesa 22.3, peaks of the process at 2048 x 2048 to 4096 x 4096): 88 MiB, and 18.5 bytes a pixel, 47 with four
 * samples. Rounded up; overlays and sums of moments by their buffers. */
uint64_t render_need(const RenderOptions *o)
{
    uint64_t pixels = (uint64_t)o->width * (uint64_t)o->height;
    uint64_t each = 22 + (o->samples > 0 ? 7 * (uint64_t)o->samples : 0) + (o->overlay ? 12 : 0) + (o->moments > 0 ? 12 : 0);
    return ((uint64_t)96 << 20) + pixels * each;
}

RenderOptions render_defaults(void)
{
    return (RenderOptions){
        .width = 1280, .height = 720, .smooth = true, .layer = RENDER_COLOUR, .shadows = true,
        .camera = {.at = {4, 3, 6}, .look_at = {0, 0.5, 0}, .up = {0, 1, 0}, .fov = DIG_PI / 4},
    };
}

/* The smallest distance from which everything is inside the picture, from a given side. A point at x across, z towards
 * the camera is inside if |x - cx| <= (d - z) tan; so d >= z + x / tan - cx / tan and d >= z - x / tan + cx / tan: the
 * largest of either kind give the best centre cx and the distance. The same up and down. */
typedef struct Fit { real right, left, above, below; } Fit;

static void fit_point(Fit *f, vec3 p, real tan_x, real tan_y)
{
    f->right = real_max(f->right, p.z + p.x / tan_x);
    f->left = real_max(f->left, p.z - p.x / tan_x);
    f->above = real_max(f->above, p.z + p.y / tan_y);
    f->below = real_max(f->below, p.z - p.y / tan_y);
}

/* Corners of the box of an item, in the camera's axes (right, up, back), scene units. */
static void fit_item(Fit *f, const View *v, const Stage *s, const ViewItem *item, mat3 camera, real tan_x, real tan_y)
{
    box3 own;
    if (!item_sound(v, item) || !item_bounds(v, item, &own))
        return;
    quat q = quat_from(item->q);
    vec3 corners[8];
    for (int i = 0; i < 8; i++) {
        vec3 p = {i & 1 ? own.high.x : own.low.x, i & 2 ? own.high.y : own.low.y, i & 4 ? own.high.z : own.low.z};
        corners[i] = stage_point(s, vec3_add(vec3_from(item->p), quat_rotate(q, p)));
        /* a huge fixed body is ground to stand on, not a thing to look at: the stage holds only part of it */
        if (item->fixed && vec3_largest(vec3_max(vec3_sub(s->low, corners[i]), vec3_sub(corners[i], s->high))) > 0.5)
            return;
    }
    for (int i = 0; i < 8; i++)
        fit_point(f, mat3_mul_vec(camera, corners[i]), tan_x, tan_y);
}

static void fit_items(Fit *f, const View *v, const Stage *s, mat3 camera, real tan_x, real tan_y)
{
    *f = (Fit){-INFINITY, -INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < v->item_count; i++)
        fit_item(f, v, s, &v->items[i], camera, tan_x, tan_y);
    if (!isfinite(f->right))
        *f = (Fit){3, 3, 3, 3};         /* nothing there: the stage has a default size */
}

/* From the right and the front, a little above. */
RenderCamera render_camera_for(const View *v, real fov, real aspect)
{
    const real azimuth = 0.50, elevation = 0.36, margin = 1.14;      /* rad, rad, 1 */
    const real nearest = 1.9;       /* times the stage's half diagonal: closer, and what is near looks swollen */
    Stage s = stage_of(v, NULL);
    vec3 back = {cos(elevation) * sin(azimuth), -cos(elevation) * cos(azimuth), sin(elevation)};
    vec3 right = vec3_unit(vec3_cross((vec3){0, 0, 1}, back));
    mat3 camera = {right, vec3_cross(back, right), back};
    real tan_y = tan(0.5 * real_clamp(fov, 0.01, 3.0)) / margin, tan_x = tan_y * real_clamp(aspect, 0.01, 100);
    Fit f;
    fit_items(&f, v, &s, camera, tan_x, tan_y);
    real distance = real_max(0.5 * (f.right + f.left), 0.5 * (f.above + f.below));
    real wanted = nearest * 0.5 * vec3_distance(s.low, s.high);
    if (distance < wanted) {
        /* the angles that fill the picture at the wanted distance give the middle as seen from there */
        real ratio = real_max(0.2, distance / wanted);
        fit_items(&f, v, &s, camera, tan_x * ratio, tan_y * ratio);
        tan_x *= ratio;
        tan_y *= ratio;
        distance = real_max(wanted, real_max(0.5 * (f.right + f.left), 0.5 * (f.above + f.below)));
    }
    vec3 middle = {0.5 * tan_x * (f.right - f.left), 0.5 * tan_y * (f.above - f.below), 0};
    mat3 from_camera = mat3_transpose(camera), to_world = mat3_transpose(s.axes);
    vec3 centre = mat3_mul_vec(from_camera, middle);
    vec3 origin = {v->origin[0], v->origin[1], v->origin[2]};
    vec3 look_at = vec3_add(vec3_add(origin, s.centre), vec3_scale(s.unit, mat3_mul_vec(to_world, centre)));
    vec3 at = vec3_mad(look_at, distance * s.unit, mat3_mul_vec(to_world, back));
    vec3 up = s.axes.r2;
    return (RenderCamera){{at.x, at.y, at.z}, {look_at.x, look_at.y, look_at.z}, {up.x, up.y, up.z}, fov};
}
