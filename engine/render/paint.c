/* render/paint.c - draws one picture. */
#include "render/paint.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/clock.h"

/* ---- light and air ----------------------------------------------------- */

/* Linear colours. The tone curve (level_of in block_light.h) shows 0.5 as 76 %, so a pale floor in the sun is about 0.6. */
typedef struct Air {
    float sun[3], zenith[3], horizon[3], ground[3];     /* light */
    float sky_top[3], sky_rim[3], sky_low[3], glow;     /* what is seen */
} Air;

static const Air airs[] = {
    {{1.08f, 1.00f, 0.87f}, {0.255f, 0.29f, 0.355f}, {0.50f, 0.54f, 0.60f}, {0.15f, 0.135f, 0.115f},
     {0.150f, 0.255f, 0.450f}, {0.46f, 0.52f, 0.59f}, {0.30f, 0.31f, 0.32f}, 0.16f},                    /* clear    */
    {{0.26f, 0.26f, 0.26f}, {0.60f, 0.62f, 0.66f}, {0.55f, 0.57f, 0.60f}, {0.20f, 0.19f, 0.18f},
     {0.36f, 0.39f, 0.43f}, {0.56f, 0.58f, 0.61f}, {0.34f, 0.34f, 0.35f}, 0.02f},                       /* overcast */
    {{0.060f, 0.080f, 0.125f}, {0.020f, 0.026f, 0.045f}, {0.024f, 0.030f, 0.046f}, {0.010f, 0.010f, 0.012f},
     {0.004f, 0.007f, 0.018f}, {0.017f, 0.024f, 0.042f}, {0.010f, 0.012f, 0.018f}, 0.05f},              /* night    */
    {{1.00f, 0.95f, 0.88f}, {0.17f, 0.18f, 0.20f}, {0.22f, 0.23f, 0.24f}, {0.10f, 0.10f, 0.10f},
     {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0},                                                               /* black    */
};

static void put3(float out[4], const float in[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = in[i];
}

static void put_vec3(float out[4], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static void set_air(Frame *f, const Air *air)
{
    put3(f->sun_colour, air->sun);
    put3(f->zenith, air->zenith);
    put3(f->horizon, air->horizon);
    put3(f->ground, air->ground);
    put3(f->sky_top, air->sky_top);
    put3(f->sky_rim, air->sky_rim);
    put3(f->sky_low, air->sky_low);
    f->sky_top[3] = air->glow;
}

/* ---- camera ------------------------------------------------------------ */

typedef struct Sight {
    vec3 at;                        /* scene units */
    vec3 right, up, forward;        /* scene axes, unit */
    real tan_x, tan_y;              /* half the picture's width and height at distance one */
} Sight;

static vec3 vec3_of_array(const real a[3]) { return (vec3){a[0], a[1], a[2]}; }

/* The camera's eye relative to the view's origin, m. */
static vec3 eye_in_view(const View *v, const RenderCamera *c) { return vec3_sub(vec3_of_array(c->at), vec3_of_array(v->origin)); }

static Stage find_stage(const View *v, const RenderOptions *o)
{
    StageEye eye = {eye_in_view(v, &o->camera), tan(0.5 * o->camera.fov)};
    return stage_of(v, &eye);
}

static Sight find_sight(const View *v, const Stage *s, const RenderOptions *o)
{
    const RenderCamera *c = &o->camera;
    Sight e;
    e.at = stage_point(s, eye_in_view(v, c));
    e.forward = mat3_mul_vec(s->axes, vec3_unit(vec3_sub(vec3_of_array(c->look_at), vec3_of_array(c->at))));
    vec3 up = mat3_mul_vec(s->axes, vec3_unit(vec3_of_array(c->up))), other, unused;
    vec3_basis(e.forward, &other, &unused);
    vec3 right = vec3_cross(e.forward, up);
    e.right = vec3_length(right) > 1e-6 ? vec3_unit(right) : other;     /* straight along up: any side will do */
    e.up = vec3_cross(e.right, e.forward);
    e.tan_y = tan(0.5 * c->fov);
    e.tan_x = e.tan_y * o->width / o->height;
    return e;
}

/* Depth from `near` to infinity: planes reach the horizon. */
static void set_projection(Frame *f, const Sight *e, real near)
{
    vec3 row[4] = {vec3_scale(1 / e->tan_x, e->right), vec3_scale(1 / e->tan_y, e->up), e->forward, e->forward};
    real last[4] = {0, 0, -2 * near, 0};
    for (int i = 0; i < 4; i++) {
        f->to_clip[i] = (float)row[i].x;
        f->to_clip[4 + i] = (float)row[i].y;
        f->to_clip[8 + i] = (float)row[i].z;
        f->to_clip[12 + i] = (float)last[i];
    }
}

static real find_near(const Sight *e) { return 0.004 * real_max(vec3_length(e->at), 0.5); }

static vec3 find_sun(const Stage *s, const RenderOptions *o)
{
    vec3 given = vec3_from(o->sun);
    /* from the left of the usual camera and a little behind it: tops bright, one side half lit, one dark */
    vec3 usual = vec3_unit((vec3){-0.64, -0.46, 0.86});
    return vec3_unit_or(mat3_mul_vec(s->axes, given), usual);
}

static void set_lamps(Frame *f, const View *v, const Stage *s, const RenderOptions *o, vec3 eye)
{
    const real response = 0.25;     /* brightness of a white surface per W/m^2: lamps count beside the hazy sun */
    for (int i = 0; i < o->lamp_count; i++) {
        const RenderLamp *lamp = &o->lamps[i];
        vec3 at = vec3_sub(vec3_of_array(lamp->at), vec3_of_array(v->origin));
        put_vec3(f->lamp_at[i], vec3_sub(stage_point(s, at), eye));
        real k = response * (real)lamp->power / (4 * DIG_PI * s->unit * s->unit);
        put_vec3(f->lamp_colour[i], vec3_scale(k, vec3_from(lamp->colour)));
    }
}

/* The lowest place in the picture (-1..1) where the sky may show. With four samples a pixel even hidden sky is dear, so
 * none is drawn where the floor is sure to be: below the edge of its quad, which lies `reach` away, seen at the
 * picture's farthest corner. With the eye on the floor, or below it, the whole sky is drawn. */
static real find_skyline(const Stage *s, const Sight *e, real reach)
{
    real height = e->at.z - s->floor;
    if (s->floor_item < 0 || !(height > 5 * find_near(e)) || e->up.z < 0.05)
        return -1;
    real longest = sqrt(1 + e->tan_x * e->tan_x + e->tan_y * e->tan_y);
    real y = (-height / reach * longest - e->forward.z - fabs(e->tan_x * e->right.z)) / (e->tan_y * e->up.z);
    return real_clamp(y - 0.02, -1, 1);
}

static void set_frame(Frame *f, const View *v, const Stage *s, const Sight *e, const RenderOptions *o, real reach)
{
    *f = (Frame){0};
    set_projection(f, e, find_near(e));
    put_vec3(f->eye, e->at);
    f->eye[3] = (float)s->unit;
    put_vec3(f->forward, e->forward);
    f->forward[3] = (float)(1 / (reach * reach));
    put_vec3(f->ray[0], vec3_scale(e->tan_x, e->right));
    put_vec3(f->ray[1], vec3_scale(e->tan_y, e->up));
    put_vec3(f->ray[2], e->forward);
    put_vec3(f->sun, find_sun(s, o));
    set_air(f, &airs[o->sky]);
    mat3 to_world = mat3_transpose(s->axes);
    put_vec3(f->world[0], to_world.r0);
    put_vec3(f->world[1], to_world.r1);
    put_vec3(f->world[2], to_world.r2);
    set_lamps(f, v, s, o, e->at);
    f->screen[0] = 2.0f / (float)o->width;
    f->screen[1] = 2.0f / (float)o->height;
    f->screen[2] = (float)find_skyline(s, e, reach);
}

/* ---- passes ------------------------------------------------------------ */

/* A picture from one eye. */
typedef struct Pass {
    const RenderOptions *o;
    const Batches *b;
    const Frame   *frame;
    const Target  *t;
    ShadeEye       eye;
    GLuint         mirror;          /* what the floor mirrors, as a texture; 0 = nothing */
} Pass;

static void set_state(const Gl *gl, bool mirrored)
{
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->DepthMask(GL_TRUE);
    gl->Disable(GL_BLEND);
    gl->Enable(GL_CULL_FACE);
    gl->CullFace(mirrored ? GL_FRONT : GL_BACK);        /* a mirror turns triangles round */
    gl->PolygonOffset(1, 8);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
}

static void use_textures(const Gl *gl, const Light *l, GLuint mirror)
{
    const GLuint names[] = {[UNIT_SUN] = l->sun_map, [UNIT_HEIGHT] = l->height_map, [UNIT_FLOOR] = l->floor_map, [UNIT_MIRROR] = mirror};
    for (unsigned unit = UNIT_SUN; unit <= UNIT_MIRROR; unit++) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        gl->BindTexture(GL_TEXTURE_2D, names[unit]);
    }
}

static void clear(const Gl *gl, RenderLayer layer)
{
    static const float sky_depth[4] = {INFINITY, 0, 0, 0}, nothing[4] = {0, 0, 0, 0}, sky[4] = {0, 0, 0, SKY_KEY / 255.0f}, far = 1;
    static const GLuint no_body[4] = {0, 0, 0, 0};
    gl->ClearBufferfv(GL_DEPTH, 0, &far);
    if (layer == RENDER_DEPTH)
        gl->ClearBufferfv(GL_COLOR, 0, sky_depth);
    else if (layer == RENDER_ID)
        gl->ClearBufferuiv(GL_COLOR, 0, no_body);
    else if (layer == RENDER_NORMAL)
        gl->ClearBufferfv(GL_COLOR, 0, nothing);
    else
        gl->ClearBufferfv(GL_COLOR, 0, sky);
}

/* Last and at the far end, so that only what shows is shaded. */
static dig_status paint_sky(Renderer *r)
{
    const Gl *gl = &r->gl;
    const Program *program = programs_get(&r->programs, gl, (ProgramKey){.kind = PROGRAM_SKY}, r->error, sizeof r->error);
    if (!program)
        return DIG_E_FORMAT;
    gl->UseProgram(program->name);
    gl->BindVertexArray(r->empty);
    gl->DepthFunc(GL_LEQUAL);
    gl->Disable(GL_CULL_FACE);
    gl->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    return DIG_OK;
}

/* What is seen through, from far to near: over the picture, hiding nothing. Two colours leave the program: the light it adds with the
 * share of what it stops, and the factor of the pixel's key, by which its edges are told from what lies behind. Up to RECEIVERS of
 * them get sun maps of their own. */
enum { RECEIVERS = 4 };

static dig_status paint_clear(Renderer *r, const Pass *p)
{
    const Gl *gl = &r->gl;
    const Batches *b = p->b;
    if (b->solid == b->count)
        return DIG_OK;
    gl->DepthFunc(GL_LESS);
    gl->DepthMask(GL_FALSE);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_SRC1_ALPHA);
    gl->ActiveTexture(GL_TEXTURE0 + UNIT_SUN);
    dig_status status = DIG_OK;
    bool apart = p->o->shadows && p->eye.rise == 0 && b->count - b->solid <= RECEIVERS;
    int step = apart ? 1 : b->count - b->solid;
    for (int i = b->solid; i < b->count && status == DIG_OK; i += step) {
        if (apart)
            status = light_receive(&r->light, gl, &b->items[i], &r->meshes);
        if (status == DIG_OK)
            status = batches_draw(b, &r->meshes, &r->programs, gl, PROGRAM_SURFACE, i, i + step, r->error, sizeof r->error);
    }
    gl->Disable(GL_BLEND);
    gl->DepthMask(GL_TRUE);
    return status;
}

static void resolve(const Gl *gl, const Target *t)
{
    if (!t->whole)
        return;
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, t->draw);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, t->whole);
    gl->BlitFramebuffer(0, 0, t->width, t->height, 0, 0, t->width, t->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->whole);
}

/* RGB is read as RGBA, which Mesa copies ten times faster. */
static dig_status read_raw(Renderer *r, const RenderOptions *o, const Target *t)
{
    const Gl *gl = &r->gl;
    GLenum format = o->layer == RENDER_DEPTH ? GL_RED : o->layer == RENDER_ID ? GL_RED_INTEGER : GL_RGBA;
    GLenum type = o->layer == RENDER_DEPTH ? GL_FLOAT : o->layer == RENDER_ID ? GL_UNSIGNED_INT : GL_UNSIGNED_BYTE;
    gl->Finish();           /* only so that the times mean what they say; the pixels are read at once anyway */
    real began = cpu_us();
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->whole ? t->whole : t->draw);
    gl->ReadPixels(0, 0, o->width, o->height, format, type, r->raw);
    r->times.read += 1e-3 * (cpu_us() - began);
    GLenum error = gl->GetError();
    if (error == GL_NO_ERROR)
        return DIG_OK;
    snprintf(r->error, sizeof r->error, "OpenGL error 0x%04x while drawing", (unsigned)error);
    return error == GL_OUT_OF_MEMORY ? DIG_E_MEMORY : DIG_E_FULL;
}

static dig_status no_room(Renderer *r, const RenderOptions *o)
{
    snprintf(r->error, sizeof r->error, "no memory for the shading of %d x %d pixels", o->width, o->height);
    return DIG_E_MEMORY;
}

/* Shades what was drawn as numbers; what is seen through comes on top, once OpenGL has got the picture back. */
static dig_status shade(Renderer *r, const Pass *p)
{
    const Gl *gl = &r->gl;
    const RenderOptions *o = p->o;
    dig_status status = shade_picture(&r->shade, p->frame, p->b, &r->light, &p->eye, r->raw, o->width, o->height);
    if (status != DIG_OK)
        return no_room(r, o);
    if (p->b->solid == p->b->count)
        return DIG_OK;
    gl->ActiveTexture(GL_TEXTURE0 + UNIT_FONT);
    gl->BindTexture(GL_TEXTURE_2D, p->t->picture);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, o->width, o->height, GL_RGBA, GL_UNSIGNED_BYTE, r->raw);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    DIG_TRY(paint_clear(r, p));
    return read_raw(r, o, p->t);
}

static dig_status paint_layer(Renderer *r, const Pass *p)
{
    static const ProgramKind kinds[LAYER_COUNT] = {PROGRAM_SURFACE, PROGRAM_DEPTH, PROGRAM_ID, PROGRAM_NORMAL};
    const Gl *gl = &r->gl;
    const RenderOptions *o = p->o;
    gl->BindFramebuffer(GL_FRAMEBUFFER, p->t->draw);
    gl->Viewport(0, 0, p->t->width, p->t->height);
    clear(gl, o->layer);
    bool colour = o->layer == RENDER_COLOUR;
    DIG_TRY(batches_draw(p->b, &r->meshes, &r->programs, gl, kinds[o->layer], 0, colour ? p->b->solid : p->b->count, r->error,
                         sizeof r->error));
    if (colour && p->t->samples == 0) {
        DIG_TRY(read_raw(r, o, p->t));
        return shade(r, p);
    }
    if (colour) {
        DIG_TRY(paint_sky(r));
        DIG_TRY(paint_clear(r, p));
        resolve(gl, p->t);
    }
    return read_raw(r, o, p->t);
}

static dig_status paint_pass(Renderer *r, const Pass *p)
{
    set_state(&r->gl, p->eye.rise > 0);
    programs_set_frame(&r->programs, &r->gl, p->frame);
    use_textures(&r->gl, &r->light, p->mirror);
    return p->eye.near > 0 ? shade(r, p) : paint_layer(r, p);       /* near: nothing for OpenGL to do */
}

/* ---- what a smooth floor mirrors ---------------------------------------- */

static bool has_mirror(const View *v, const Stage *s, const Sight *e)
{
    return s->floor_item >= 0 && plane_sheen(&v->items[s->floor_item]) > 0 && e->at.z > s->floor;
}

/* The frame of the same moment from another height. */
static void move_light(Frame *to, const Frame *from)
{
    memcpy(to->to_sun, from->to_sun, sizeof to->to_sun);
    for (int i = 0; i < 3; i++)
        to->to_sun[12 + i] += from->to_sun[8 + i] * (to->eye[2] - from->eye[2]);
    memcpy(to->top, from->top, sizeof to->top);
    memcpy(to->shade, from->shade, sizeof to->shade);
    to->sun[3] = from->sun[3];
    to->sun_colour[3] = from->sun_colour[3];
    to->ground[3] = from->ground[3];
}

static bool keep_mirror(Renderer *r, size_t size)
{
    if (r->mirror_capacity < size) {
        free(r->mirror);
        r->mirror = malloc(size);
        r->mirror_capacity = r->mirror ? size : 0;
    }
    if (r->mirror)
        memcpy(r->mirror, r->raw, size);
    return r->mirror != NULL;
}

/* Draws what the floor mirrors, half as fine as the picture: the view of an eye below it, upside down, so that both pictures show a
 * floor's pixel at the same place. `p` gets it. What lies below the floor is left out where rays are cast, and not where OpenGL draws. */
static dig_status paint_mirror(Renderer *r, const View *v, const Stage *s, const Sight *e, const BatchEye *from, Pass *p)
{
    const Gl *gl = &r->gl;
    RenderOptions o = *p->o;
    o.width = (o.width + 1) / 2;
    o.height = (o.height + 1) / 2;
    o.samples = 0;
    Sight m = *e;
    m.at.z = 2 * s->floor - e->at.z;
    m.right.z = -e->right.z;
    m.up.z = -e->up.z;
    m.forward.z = -e->forward.z;
    BatchEye eye = *from;
    eye.at = m.at;
    eye.pixels *= 0.5;
    eye.numbers = true;
    eye.patch = eye.mirrors = false;
    const Target *t = targets_get(&r->targets, gl, TARGET_MIRROR, o.width, o.height, 0, r->error, sizeof r->error);
    if (!t || batches_build(&r->mirrored, &r->meshes, gl, v, s, &eye, r->draw) != DIG_OK)
        return no_room(r, &o);
    Frame frame;
    set_frame(&frame, v, s, &m, &o, from->reach);
    move_light(&frame, p->frame);
    Pass below = {&o, &r->mirrored, &frame, t, {.near = r->mirrored.drawn == 0 ? find_near(&m) : 0, .rise = s->floor - m.at.z}, 0};
    dig_status status = paint_pass(r, &below);
    if (status != DIG_OK || !keep_mirror(r, 4 * (size_t)o.width * (size_t)o.height))
        return status != DIG_OK ? status : no_room(r, &o);
    if (p->t->samples > 0) {            /* OpenGL draws the floor */
        gl->ActiveTexture(GL_TEXTURE0 + UNIT_MIRROR);
        gl->BindTexture(GL_TEXTURE_2D, t->picture);
        gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, o.width, o.height, GL_RGBA, GL_UNSIGNED_BYTE, r->mirror);
        p->mirror = t->picture;
    }
    p->eye.mirror = (ShadeMirror){r->mirror, o.width, o.height};
    return DIG_OK;
}

dig_status paint(Renderer *r, const View *v, const RenderOptions *o, const Target *t)
{
    const Gl *gl = &r->gl;
    bool colour = o->layer == RENDER_COLOUR;
    Stage s = find_stage(v, o);
    Sight e = find_sight(v, &s, o);
    real reach = real_max(16, 4.5 * vec3_length(e.at));
    BatchEye eye = {.at = e.at, .pixels = o->height / (2 * e.tan_y), .reach = reach, .lamps = colour ? o->lamp_count : 0,
                    .shadows = o->shadows, .overlay_dig = (o->overlay & OVERLAY_DIG) != 0, .overlay_stress = (o->overlay & OVERLAY_STRESS) != 0,
                    .numbers = colour && t->samples == 0, .fine = !colour};
    if (colour && (o->overlay & OVERLAY_TEMPERATURE))
        eye.heat = heat_scale(v);
    eye.mirrors = colour && has_mirror(v, &s, &e);
    Frame frame;
    set_frame(&frame, v, &s, &e, o, reach);
    eye.patch = colour && !eye.numbers && s.floor_item >= 0;
    if (eye.patch)
        light_ground(&s, vec3_from(frame.sun), &eye.patch_x, &eye.patch_y, &eye.patch_half);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->ActiveTexture(GL_TEXTURE0 + UNIT_HEIGHT);       /* uploads must not unbind another unit's texture */
    dig_status status = batches_build(&r->batches, &r->meshes, gl, v, &s, &eye, ++r->draw);
    if (status != DIG_OK) {
        snprintf(r->error, sizeof r->error, "no memory for %d items", v->item_count);
        return status;
    }
    if (colour) {
        real began = cpu_us();
        status = light_cast(&r->light, &r->batches, &r->meshes, &s, o->shadows, &frame);
        if (status != DIG_OK) {
            snprintf(r->error, sizeof r->error, "no memory for the shadows of %d items", v->item_count);
            return status;
        }
        if (r->batches.drawn > 0)
            light_upload(&r->light, gl);
        r->times.light += 1e-3 * (cpu_us() - began);
    }
    Pass pass = {o, &r->batches, &frame, t, {.near = eye.numbers && r->batches.drawn == 0 ? find_near(&e) : 0}, 0};
    if (eye.mirrors)
        DIG_TRY(paint_mirror(r, v, &s, &e, &eye, &pass));
    return paint_pass(r, &pass);
}

dig_status paint_overlay(Renderer *r, const View *v, const RenderOptions *o, const Target *t)
{
    static const float nothing[4] = {0, 0, 0, 0};
    const Gl *gl = &r->gl;
    Stage s = find_stage(v, o);
    Sight e = find_sight(v, &s, o);
    mat3 to_world = mat3_transpose(s.axes);
    OverlayEye eye = {.at = eye_in_view(v, &o->camera), .right = mat3_mul_vec(to_world, e.right), .up = mat3_mul_vec(to_world, e.up),
                      .forward = mat3_mul_vec(to_world, e.forward), .pixels = o->height / (2 * e.tan_y), .width = o->width,
                      .height = o->height};
    gl->BindFramebuffer(GL_FRAMEBUFFER, t->draw);
    gl->Viewport(0, 0, t->width, t->height);
    gl->ClearBufferfv(GL_COLOR, 0, nothing);
    DIG_TRY(overlay_draw(&r->overlay, &r->programs, gl, v, &s, &eye, o->overlay, o->past, r->error, sizeof r->error));
    return read_raw(r, o, t);
}
