/* render/paint.h - one picture: the frame's numbers, then the passes in order.
 *
 * Floor: render.
 */
#ifndef DIG_PAINT_H
#define DIG_PAINT_H

#include "render/light.h"
#include "render/overlay.h"
#include "render/shade.h"
#include "render/smooth.h"
#include "render/target.h"

struct Renderer {
    const ContextBackend *backend;
    void      *context;
    Gl         gl;
    Programs   programs;
    Meshes     meshes;
    Batches    batches, mirrored;   /* from the eye, and from its place in the mirror of a smooth floor */
    Light      light;
    Overlay    overlay;
    Targets    targets;
    ShadeSpace shade;
    SmoothSpace smooth;
    RenderTimes times;
    GLuint     empty;               /* vertex array without attributes, for the sky */
    uint64_t   draw;                /* pictures so far */
    void      *pixels, *raw;        /* of the last picture: as handed out; as read, bottom row first */
    void      *mirror;              /* what a smooth floor mirrors, as `raw`, half as fine */
    uint32_t  *sum;                 /* of the moments of a blurred picture so far: squares of levels, about as light adds */
    size_t     sum_capacity;
    size_t     pixel_capacity, raw_capacity, mirror_capacity;
    char       description[200], error[400];
};

/* Draws one picture into `t`, resolved, without overlays, and reads it into r->raw. The context is bound. */
dig_status paint(Renderer *r, const View *v, const RenderOptions *o, const Target *t);

/* Draws the overlays alone into `t` and reads them likewise. */
dig_status paint_overlay(Renderer *r, const View *v, const RenderOptions *o, const Target *t);

#endif
