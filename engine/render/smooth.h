/* render/smooth.h - smooths the silhouettes of a finished picture.
 *
 * Multisampling doubles the time of a picture in software. Instead every pixel says in its alpha which face of which body
 * it shows (SMOOTH_...), and where neighbours differ, the line between them is found again and the pixels on it are
 * mixed by the share that either side covers: morphological antialiasing (Reshetov, High Performance Graphics 2009),
 * which normally guesses edges from brightness and then smears textures; those filter themselves here.
 *
 * Owns:  open runs of columns and marks of a row, in SmoothSpace.
 * Floor: render. No OpenGL here.
 */
#ifndef DIG_SMOOTH_H
#define DIG_SMOOTH_H

#include "base/base.h"

typedef struct SmoothSpace { int *open; unsigned char *bytes; int capacity; } SmoothSpace;

/* `raw` is RGBA as OpenGL reads it, the bottom row first; `out` gets RGB, the top row first. */
void       smooth_copy(const uint32_t *raw, int width, int height, unsigned char *out);
dig_status smooth_edges(SmoothSpace *space, const uint32_t *raw, int width, int height, unsigned char *out);
void       smooth_close(SmoothSpace *space);

/* Lays an overlay, RGBA with the colour already weighted by alpha, over the picture; rows as above. */
void smooth_cover(const uint32_t *overlay, int width, int height, unsigned char *out);

#endif
