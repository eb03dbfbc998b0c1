/* render/overlay.h - lines, arrows and text drawn over a finished picture.
 *
 * Everything is a stroke in pixels: a line with round ends, its own width at either end and a dark rim, or a glyph. Its
 * edges are smoothed by the shader, so overlays look the same with and without multisampling. Nothing hides them: a
 * link joins centres of mass, which lie inside the bodies.
 *
 * Owns:  the stroke and glyph lists, the font's picture and its texture.
 * Floor: render.
 */
#ifndef DIG_OVERLAY_H
#define DIG_OVERLAY_H

#include "render/program.h"
#include "render/render.h"
#include "render/stage.h"

enum { FONT_FIRST = 32, FONT_COUNT = 352, FONT_SIDE = 1024 };      /* Latin up to U+017F */

typedef struct Glyph { short x, y, width, height, left, top; float advance; } Glyph;   /* px */

typedef struct Font {
    Glyph          glyphs[FONT_COUNT];
    unsigned char *picture;     /* [FONT_SIDE^2], 0..255; NULL = no font found */
    int            size;        /* px, 0 = not made yet */
    float          line;        /* px from one baseline to the next */
    bool           missing;     /* looked for and not found */
    GLuint         texture;
} Font;

typedef struct Stroke { float ends[4], widths[4], colour[4]; } Stroke;

typedef struct StrokeList { Stroke *data; int count, capacity; bool full; } StrokeList;

typedef struct Overlay {
    StrokeList strokes, glyphs;
    Font       font;
    GLuint     array, buffer;
} Overlay;

typedef struct OverlayEye {     /* how world points become pixels */
    vec3 at, right, up, forward;        /* m and unit vectors, world axes, `at` relative to the view's origin */
    real pixels;                        /* height / (2 tan(fov / 2)) */
    real width, height;                 /* px */
} OverlayEye;

typedef struct Pen { Overlay *o; const OverlayEye *eye; real scale; } Pen;      /* scale: px of a thin line's half width */

/* A line between points of the view, as wide in px at either end; behind the eye it is cut off. */
void   pen_line(const Pen *pen, vec3 a, vec3 b, real width, const float colour[3], float alpha);
void   pen_bare_line(const Pen *pen, vec3 a, vec3 b, real width, const float colour[3], float alpha);      /* without rim */
/* The same in pixels, with its rim; widths[2] = 0 takes that away. */
Stroke pen_stroke(const real a[2], const real b[2], real ra, real rb, const float colour[3], float alpha);
void   pen_put(const Pen *pen, Stroke stroke);
/* Text without a plate, its baseline's left end at (x, y) px; returns its width, px. */
real   pen_label(const Pen *pen, real x, real y, const char *text, const float colour[3]);

real   pen_text_width(const Pen *pen, const char *text);        /* px */
/* "30.1 kN"; below a millionth it is 0. */
void   overlay_quantity(char out[32], real x, const char *unit);

/* history.c; the curves of the strip take that share of the picture's height, with its words it has history_foot px */
#define HISTORY_HEIGHT 0.15
real history_foot(const Pen *pen);
void history_trails(const Pen *pen, const View *v, const ViewPast *h);
void history_energies(const Pen *pen, const View *v, const ViewPast *h);

void overlay_open(Overlay *o, const Gl *gl);
void overlay_close(Overlay *o, const Gl *gl);

/* Draws what `flags` (OVERLAY_...) ask for into the bound framebuffer, cleared to zero: colours come out weighted by alpha. */
dig_status overlay_draw(Overlay *o, Programs *programs, const Gl *gl, const View *v, const Stage *s, const OverlayEye *eye, unsigned flags,
                        const ViewPast *past, char *why, size_t capacity);

/* font.c: makes the font of that size, once; without any font file `missing` is set and texts are left out. */
void  font_make(Font *f, int size);
void  font_close(Font *f);
/* The glyph of the next character of a UTF-8 text, which it moves past; NULL at the end. Unknown ones become '?'. */
const Glyph *font_next(const Font *f, const char **text);

#endif
