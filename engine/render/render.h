/* render/render.h - a View becomes pixels.
 *
 * A renderer owns one off-screen GL context (OSMesa, or EGL without a surface)
 * and its buffers; use it from one thread at a time. The same view and
 * options give the same bytes. Everything is drawn into own framebuffers,
 * OpenGL core 3.3. What the program may set in the environment is said in
 * render/context.h; this library leaves it alone.
 *
 * Floor: render. Includes base, math, view only.
 */
#ifndef DIG_RENDER_H
#define DIG_RENDER_H

#include "view/past.h"
#include "view/view.h"

typedef enum RenderLayer { RENDER_COLOUR, RENDER_DEPTH, RENDER_ID, RENDER_NORMAL } RenderLayer;

enum {      /* RenderOptions.overlay, or-ed */
    OVERLAY_DIG = 1, OVERLAY_CONTACTS = 2, OVERLAY_FORCES = 4, OVERLAY_NAMES = 8, OVERLAY_JOINTS = 16, OVERLAY_TIME = 32,
    OVERLAY_STRESS = 64, OVERLAY_TEMPERATURE = 128, OVERLAY_TRAILS = 256, OVERLAY_ENERGY = 512     /* these two need what was before (past) */
};

typedef struct RenderCamera {
    real at[3], look_at[3], up[3];      /* m, world */
    real fov;                           /* rad, vertical */
} RenderCamera;

typedef struct RenderLamp { real at[3]; float power; float colour[3]; } RenderLamp;    /* W, isotropic */

typedef struct RenderOptions {
    int          width, height;         /* 1..16384 px                              */
    int          samples;               /* a pixel, by the driver: 0, 2 or 4        */
    int          moment, moments;       /* 0, 0; or a share of a blurred picture: 1..moments, drawn in order */
    bool         smooth;                /* edges, after drawing (render/smooth.h); not with samples */
    RenderLayer  layer;
    unsigned     overlay;
    RenderCamera camera;
    float        sun[3];                /* from where it shines; zero = default sun */
    bool         shadows;
    int          sky;                   /* 0 clear, 1 overcast, 2 night, 3 black    */
    RenderLamp   lamps[4]; int lamp_count;
    const ViewPast *past;               /* for trails and energies; NULL = none */
} RenderOptions;

typedef struct Renderer Renderer;

/* Bytes, about, of a process that draws such pictures: to be known before the first one is. */
uint64_t      render_need(const RenderOptions *o);
RenderOptions render_defaults(void);                        /* 1280x720, smooth edges, sun, shadows */
RenderCamera  render_camera_for(const View *v, real fov, real aspect);   /* a sensible one that sees everything */

/* backend: "osmesa", "egl" or NULL for the first that works. why gets one sentence on failure. */
dig_status  render_open(const char *backend, Renderer **r, char *why, size_t capacity);
void        render_close(Renderer *r);
const char *render_describe(const Renderer *r);             /* "osmesa: 4.5 (Core Profile) Mesa 22.3.6, llvmpipe ..." */
const char *render_error(const Renderer *r);

/* Draws into pixels, rows from the top: RENDER_COLOUR and RENDER_NORMAL 8-bit RGB (3 bytes), RENDER_DEPTH float metres
 * along the view (infinite = sky), RENDER_ID uint32 body slot + 1 (0 = none). Normals are in world axes, -1..1 as
 * 0..255; black = none. The data layers have one sample a pixel. *pixels belongs to the renderer and stays valid until
 * its next draw. Items whose numbers make no sense are left out.
 *   DIG_E_ARG     an option is out of range: render_error names it
 *   DIG_E_MEMORY  no room for a picture of that size
 *   DIG_E_FULL, DIG_E_FORMAT  the driver failed, or did not compile a shader: render_error has its words */
dig_status render_draw(Renderer *r, const View *v, const RenderOptions *o, const void **pixels);

/* Processor time of the pictures so far, ms of the thread that drew; for whole figures set LP_NUM_THREADS=0. */
typedef struct RenderTimes { real light, draw, read, smooth; } RenderTimes;
RenderTimes render_times(const Renderer *r);

typedef struct PngText { const char *key; const char *value; } PngText;

/* Writes an image under a temporary name in the same folder and renames it: under `path` there is either nothing, the old
 * file, or the whole new one. Depth is written as 16-bit grey in mm, saturating; ids as 24-bit RGB (r low byte). */
dig_status png_write(const char *path, RenderLayer layer, int width, int height, const void *pixels,
                     const PngText *texts, int text_count, char *why, size_t capacity);

/* The same in two steps, for those who measure them or write elsewhere: an image in memory, and a file under `path`, which is
 * flushed to the disk before it gets its name if `flush` (else a crash of the machine may leave it empty). */
typedef struct PngBytes {       /* starts as zeros; may be used again; png_release frees it */
    unsigned char *data, *rows;         /* the image; room to work in, kept for the next one */
    size_t         size, capacity, row_capacity;
} PngBytes;

dig_status png_encode(RenderLayer layer, int width, int height, const void *pixels, const PngText *texts, int text_count, PngBytes *out,
                      char *why, size_t capacity);
dig_status png_save(const char *path, const PngBytes *bytes, bool flush, char *why, size_t capacity);
void       png_release(PngBytes *bytes);

/* Whether all of a PNG file is there: signature, each chunk with its checksum, the end, and image data that unpacks. */
bool png_whole(const char *path);

/* Reads an 8-bit RGB png back (for golden tests). Free *pixels with free(). */
dig_status png_read(const char *path, int *width, int *height, unsigned char **pixels, char *why, size_t capacity);

#endif
