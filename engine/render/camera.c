/* render/camera.c - a camera that sees everything, and the options everybody starts from. */
#include "render/render.h"
#include "render/stage.h"

RenderOptions render_defaults(void)
{
    return (RenderOptions){
        .width = 1280, .height = 720, .samples = 4, .layer = RENDER_COLOUR, .shadows = true,
        .camera = {.at = {4, 3, 6}, .look_at = {0, 0.5, 0}, .up = {0, 1, 0}, .fov = DIG_PI / 4},
    };
}

/* From the right and the front, a little above. The distance is the smallest at which each corner of the box lies
 * inside the picture: a corner at (x, y) across and z towards the camera needs d >= z + |x| / tan(half width). */
RenderCamera render_camera_for(const View *v, real fov, real aspect)
{
    const real azimuth = 0.52, elevation = 0.36, margin = 1.10;      /* rad, rad, 1 */
    Stage s = stage_of(v, false);
    vec3 back = {cos(elevation) * sin(azimuth), -cos(elevation) * cos(azimuth), sin(elevation)};
    vec3 right = vec3_unit(vec3_cross((vec3){0, 0, 1}, back)), up = vec3_cross(back, right);
    real tan_y = tan(0.5 * real_clamp(fov, 0.01, 3.0)) / margin, tan_x = tan_y * real_clamp(aspect, 0.01, 100);
    real distance = 0.1;
    for (int corner = 0; corner < 8; corner++) {
        vec3 p = {corner & 1 ? s.high.x : s.low.x, corner & 2 ? s.high.y : s.low.y, corner & 4 ? s.high.z : s.low.z};
        real across = real_max(fabs(vec3_dot(p, right)) / tan_x, fabs(vec3_dot(p, up)) / tan_y);
        distance = real_max(distance, vec3_dot(p, back) + across);
    }
    mat3 to_world = mat3_transpose(s.axes);
    vec3 origin = {v->origin[0], v->origin[1], v->origin[2]};
    vec3 look_at = vec3_add(origin, s.centre);
    vec3 at = vec3_mad(look_at, distance * s.unit, mat3_mul_vec(to_world, back));
    vec3 world_up = s.axes.r2;
    return (RenderCamera){{at.x, at.y, at.z}, {look_at.x, look_at.y, look_at.z}, {world_up.x, world_up.y, world_up.z}, fov};
}
