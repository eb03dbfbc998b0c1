/* export/html_data.h - what a page shows, gathered frame by frame and then written: html_track.c follows bodies and links,
 * html_shape.c shapes and what is drawn beside them, html_scene.c cameras and light, html.c writes, html_pack.c makes it small.
 *
 * A page holds a JSON header and one packed block of arrays, the sections. Frames are those of the page, from 0:
 *   times, number, energy    [frames] s; frame of the replay; [10 * frames] J, the fields of dig_energy without `initial`
 *   key_frame, key_pose, key_motion, key_dig, key_flags, key_temperature
 *                        what changed of a body: its frame; position (m from `place`), rotation x y z w; velocity, spin, force;
 *                        DIG; 1 = awake plus twice the mode; K. Those of a body stand together and hold until its next one.
 *   link, effort, link_end   six numbers a span of frames: a, b, kind, layer + 256 when it is to the outside, first frame,
 *                        frames; then for each of its frames |effort|, and where it ends outside (m from `place`)
 *   X_at, X              for X = contact (point, force), line (ends, colour), strut (ends, radius, stress), push (point, force),
 *                        sheet (four bodies, colour), camera:
 *                        first row and rows of every frame; a frame like the one before points at the same rows
 *   camera_at, camera    the script's, eleven numbers each: 1 = place + 2 = target + 4 = up are said; place and target (m from `place`), up, angle
 *   event                [12 * events] frame of the page, time, kind, bodies, speed, impulse, DIGs, kind of link, layer, stress
 *   vertex, normal, index    of meshes
 * The lists of the JSON header say the rest with names.
 *
 * Owns:  an HtmlData everything in it, until html_data_close.
 * Floor: export.
 */
#ifndef DIG_EXPORT_HTML_DATA_H
#define DIG_EXPORT_HTML_DATA_H

#include "base/list.h"
#include "base/map.h"
#include "export/light.h"
#include "export/output.h"
#include "math/quat.h"

typedef struct HtmlKey {            /* compared byte by byte: no padding */
    float    pose[7], motion[9], temperature;
    uint32_t dig, flags;
} HtmlKey;

typedef struct HtmlTimedKey { uint32_t frame; HtmlKey key; } HtmlTimedKey;

typedef struct HtmlBody {
    LIST(HtmlTimedKey) keys;
    bool shaped;                    /* its shapes are known */
    bool woven;                     /* at this frame a sheet is drawn in its place: they are not wanted yet */
} HtmlBody;

typedef struct HtmlSpan {           /* a link while it holds */
    uint32_t a, b, kind, layer, first;
    bool     bound;
    LIST(float) efforts;            /* [frames] */
    LIST(float) ends;               /* [3 * frames] when bound */
} HtmlSpan;

typedef struct HtmlMesh { uint64_t hash; ViewForm form; float size[3]; int vertex, vertex_count, normal_count, index, index_count; } HtmlMesh;
typedef struct HtmlShape { int body, mesh, pattern; float p[3], q[4], colour[3], roughness, metallic, opacity; } HtmlShape; /* body -1: none */
typedef struct HtmlEvent { int frame, a, b; dig_event event; } HtmlEvent;

typedef enum HtmlMomentName { MOMENT_CONTACT, MOMENT_LINE, MOMENT_STRUT, MOMENT_PUSH, MOMENT_CAMERA, MOMENT_SHEET, MOMENTS } HtmlMomentName;
extern const struct HtmlMomentKind { const char *at, *name; int width; } html_moments[MOMENTS];

typedef struct HtmlMoment {
    LIST(uint32_t) at;              /* [2 * frames] */
    LIST(float) rows;
    uint32_t first;                 /* row of the frame before */
} HtmlMoment;

typedef struct HtmlData {
    Replay *r;
    vec3    place;                  /* m, what all positions are relative to */
    float   up[3], low[3], high[3]; /* bounds, m from place */
    vec3    middle; real reach;     /* m: what goes farther from the middle does not count for the bounds */
    int     frames;
    LIST(int)       numbers;        /* [frames] of the replay */
    LIST(real)      times;
    LIST(real)      energy;
    LIST(HtmlBody)  bodies;         /* [bodies of the replay] */
    LIST(HtmlSpan)  spans;
    Map             holding;        /* link -> its last span */
    LIST(HtmlMesh)  meshes;
    LIST(float)     vertices;
    LIST(float)     normals;
    LIST(uint32_t)  indices;
    LIST(HtmlShape) shapes;
    LIST(HtmlEvent) events;
    int             events_left_out;
    Output          lights;         /* JSON objects, one for each frame at which the light is another one */
    ExportLight     light;          /* the last of them */
    HtmlMoment      moments[MOMENTS];
    LIST(int)       row_of;         /* pose of a slot at this frame, -1 = none */
    real            coldest, hottest;   /* K; coldest > hottest when nothing has a temperature */
} HtmlData;

/* ---- what is written (html_pack.c) ---- */

typedef struct HtmlSections { Output bytes, list; } HtmlSections;               /* the block, and its table of contents as JSON */
typedef struct HtmlRows { const uint32_t *words; size_t count, stride; } HtmlRows;   /* floats or integers of 32 bits */
typedef struct HtmlPart {           /* some columns, and what they may lose */
    int  width, order;              /* order of differences; -1: none, the bits of the numbers */
    real step;                      /* floats become multiples of this; 0: they do not         */
    int  drop;                      /* order -1: so many of the lowest bits are rounded away   */
} HtmlPart;
enum { HTML_EVENT_WIDTH = 12 };

/* A section of all parts, side by side in rows as they are read. A part that does not fit on its grid keeps all its bits. */
void html_section_words(HtmlSections *s, const char *name, const char *type, const HtmlRows *r, const HtmlPart *parts, int count);
void html_section_reals(HtmlSections *s, const char *name, const real *x, size_t rows, int width);
void html_put_packed(Output *out, const Output *block);             /* deflate in base64 */

/* ---- what is gathered ---- */

/* Ends the rows of a frame, which began at the number `before`: those that are as the frame before had them are not kept twice. */
dig_status html_end_moment(HtmlData *d, HtmlMomentName name, int before);
/* A list of numbers gets n more. */
#define html_put(list, numbers, n) html_put_any((void **)&(list)->data, &(list)->count, &(list)->capacity, sizeof *(list)->data, (numbers), (n))
dig_status html_put_any(void **data, int *count, int *capacity, size_t item, const void *from, int n);

dig_status html_take_poses(HtmlData *d, const ReplayFrame *f);
dig_status html_take_links(HtmlData *d, const ReplayFrame *f);
dig_status html_take_events(HtmlData *d, const ReplayFrame *f, int frame);
dig_status html_take_view(HtmlData *d, const ReplayFrame *f, const View *v);
dig_status html_take_scene(HtmlData *d, const ReplayFrame *f);      /* cameras and light */
void       html_put_cameras(HtmlData *d, Output *out);
void       html_put_text(Output *out, const char *text);            /* quoted JSON without < */
void       html_data_close(HtmlData *d);

#endif
