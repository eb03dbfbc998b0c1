/* render/target.h - the framebuffers pictures are drawn into, one set for each layer.
 *
 * Owns:  framebuffers, renderbuffers and textures; targets_close frees them.
 * Floor: render.
 */
#ifndef DIG_TARGET_H
#define DIG_TARGET_H

#include "render/gl.h"
#include "render/render.h"

enum { LAYER_COUNT = 4, TARGET_OVERLAY = LAYER_COUNT, TARGET_MIRROR, TARGET_COUNT };     /* targets: the layers, overlays, what a floor mirrors */

typedef struct Target {
    int    width, height, samples;
    GLuint draw, colour, depth;         /* what is drawn into; multisampled if samples > 0 */
    GLuint picture;                     /* instead of `colour`: a texture, where that is RGBA and not multisampled */
    GLuint whole, resolved;             /* one sample a pixel; 0 when draw is that already */
} Target;

typedef struct Targets { Target entry[TARGET_COUNT]; } Targets;

/* A target (RenderLayer, TARGET_OVERLAY, TARGET_MIRROR) at that size, made anew when it changed. NULL and a sentence when the driver refuses. */
const Target *targets_get(Targets *t, const Gl *gl, int index, int width, int height, int samples, char *why, size_t capacity);
void          targets_close(Targets *t, const Gl *gl);

#endif
