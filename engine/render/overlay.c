/* render/overlay.c - lines, arrows and text over a finished picture. */
#include "render/overlay.h"

#include "render/heat.h"

#include <stdio.h>
#include <stdlib.h>

#include "render/batch.h"

static const float rim = 1.1f;      /* px, dark line round every stroke */

/* ---- lists ------------------------------------------------------------ */

static void put_stroke(StrokeList *list, Stroke stroke)
{
    if (list->count == list->capacity) {
        int capacity = list->capacity ? 2 * list->capacity : 256;
        Stroke *data = realloc(list->data, (size_t)capacity * sizeof *data);
        if (!data) {
            list->full = true;
            return;
        }
        list->data = data;
        list->capacity = capacity;
    }
    list->data[list->count++] = stroke;
}

/* Pixel position of a point; false when it lies behind the eye. */
static bool project(const OverlayEye *eye, vec3 p, real out[2])
{
    vec3 r = vec3_sub(p, eye->at);
    real depth = vec3_dot(r, eye->forward);
    if (!(depth > 0) || !vec3_finite(r))
        return false;
    out[0] = 0.5 * eye->width + eye->pixels * vec3_dot(r, eye->right) / depth;
    out[1] = 0.5 * eye->height - eye->pixels * vec3_dot(r, eye->up) / depth;
    /* far outside is as good as the limit, and keeps floats exact */
    return fabs(out[0]) < 1e5 && fabs(out[1]) < 1e5;
}

/* Cuts a segment where it passes behind the eye. */
static bool project_segment(const OverlayEye *eye, vec3 a, vec3 b, real pa[2], real pb[2])
{
    real da = vec3_dot(vec3_sub(a, eye->at), eye->forward), db = vec3_dot(vec3_sub(b, eye->at), eye->forward);
    real near = 0.01 * real_max(da, db);
    if (!(near > 0))
        return false;
    if (da < near)
        a = vec3_lerp(a, b, (near - da) / (db - da));
    else if (db < near)
        b = vec3_lerp(b, a, (near - db) / (da - db));
    return project(eye, a, pa) && project(eye, b, pb);
}

Stroke pen_stroke(const real a[2], const real b[2], real ra, real rb, const float colour[3], float alpha)
{
    return (Stroke){{(float)a[0], (float)a[1], (float)b[0], (float)b[1]}, {(float)ra, (float)rb, rim, 0},
                    {colour[0], colour[1], colour[2], alpha}};
}

/* ---- shapes ----------------------------------------------------------- */

void pen_line(const Pen *pen, vec3 a, vec3 b, real width, const float colour[3], float alpha)
{
    real pa[2], pb[2];
    if (project_segment(pen->eye, a, b, pa, pb))
        put_stroke(&pen->o->strokes, pen_stroke(pa, pb, width * pen->scale + (real)rim, width * pen->scale + (real)rim, colour, alpha));
}

void pen_bare_line(const Pen *pen, vec3 a, vec3 b, real width, const float colour[3], float alpha)
{
    real pa[2], pb[2];
    if (!project_segment(pen->eye, a, b, pa, pb))
        return;
    Stroke s = pen_stroke(pa, pb, width * pen->scale, width * pen->scale, colour, alpha);
    s.widths[2] = 0;
    put_stroke(&pen->o->strokes, s);
}

static void draw_dot(const Pen *pen, vec3 p, real radius, const float colour[3])
{
    real at[2];
    if (project(pen->eye, p, at))
        put_stroke(&pen->o->strokes, pen_stroke(at, at, radius * pen->scale + (real)rim, radius * pen->scale + (real)rim, colour, 1));
}

/* A shaft, then a head that narrows to a point at the tip. */
static void draw_arrow(const Pen *pen, vec3 from, vec3 to, real width, const float colour[3])
{
    real a[2], b[2];
    if (!project_segment(pen->eye, from, to, a, b))
        return;
    real w = width * pen->scale + (real)rim, length = hypot(b[0] - a[0], b[1] - a[1]), head = real_min(4.6 * w, 0.7 * length);
    real t = length > 0 ? 1 - head / length : 0;
    real neck[2] = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
    put_stroke(&pen->o->strokes, pen_stroke(a, neck, w, w, colour, 1));
    put_stroke(&pen->o->strokes, pen_stroke(neck, b, real_min(2.6 * w, 0.8 * head + w), 0.6 + (real)rim, colour, 1));
}

static real text_width(const Font *f, const char *text)
{
    real width = 0;
    for (const Glyph *g; (g = font_next(f, &text));)
        width += (real)g->advance;
    return width;
}

static void draw_glyphs(Overlay *o, real x, real y, const char *text, const float ink[3])
{
    real pen = floor(x);
    for (const Glyph *g; (g = font_next(&o->font, &text)); pen += (real)g->advance) {
        float gx = (float)floor(pen + 0.5) + g->left, gy = (float)floor(y) - g->top;
        put_stroke(&o->glyphs, (Stroke){{gx, gy, gx + g->width, gy + g->height},
                                        {g->x, g->y, (float)(g->x + g->width), (float)(g->y + g->height)}, {ink[0], ink[1], ink[2], 1}});
    }
}

/* Text on a rounded plate; (x, y) is the left end of the baseline. */
static void draw_text(Overlay *o, real x, real y, const char *text)
{
    const Font *f = &o->font;
    if (f->missing || !*text)
        return;
    static const float ink[3] = {1, 1, 1}, plate[3] = {0.07f, 0.08f, 0.10f};
    real half = 0.62 * f->size, middle = y - 0.36 * f->size, left[2] = {x, middle}, right[2] = {x + text_width(f, text), middle};
    Stroke back = pen_stroke(left, right, half, half, plate, 0.62f);
    back.widths[2] = 0;
    put_stroke(&o->strokes, back);
    draw_glyphs(o, x, y, text, ink);
}

void pen_put(const Pen *pen, Stroke stroke) { put_stroke(&pen->o->strokes, stroke); }

real pen_label(const Pen *pen, real x, real y, const char *text, const float colour[3])
{
    if (pen->o->font.missing)
        return 0;
    draw_glyphs(pen->o, x, y, text, colour);
    return text_width(&pen->o->font, text);
}

real pen_text_width(const Pen *pen, const char *text) { return pen->o->font.missing ? 0 : text_width(&pen->o->font, text); }

/* ---- what is shown ----------------------------------------------------- */

/* Colours here are as displayed, not linear. */
static void display_colour(const float linear[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = sqrtf(linear[i] < 0 ? 0 : linear[i] > 1 ? 1 : linear[i]);
}

/* Equal pieces with equal gaps, so many pieces. */
static void draw_dashes(const Pen *pen, vec3 a, vec3 b, int pieces, real width, const float colour[3])
{
    for (int i = 0; i < pieces; i++)
        pen_line(pen, vec3_lerp(a, b, 2 * i / (2.0 * pieces - 1)), vec3_lerp(a, b, (2 * i + 1) / (2.0 * pieces - 1)), width, colour, 1);
}

/* A joint is a double line, with a gap that shows what is behind it. */
static void draw_double(const Pen *pen, vec3 a, vec3 b, const float colour[3])
{
    static const float gap[3] = {0.07f, 0.08f, 0.10f};
    pen_line(pen, a, b, 2.6, colour, 1);
    real pa[2], pb[2];
    if (!project_segment(pen->eye, a, b, pa, pb))
        return;
    Stroke inner = pen_stroke(pa, pb, 0.9 * pen->scale, 0.9 * pen->scale, gap, 1);
    inner.widths[2] = 0;
    put_stroke(&pen->o->strokes, inner);
}

/* The outside: a bar across the end of the link, as the sign for ground. */
static void draw_ground(const Pen *pen, vec3 from, vec3 end, const float colour[3])
{
    static const real wide[3] = {7, 4.5, 2};
    real a[2], b[2];
    if (!project(pen->eye, from, a) || !project(pen->eye, end, b))
        return;
    real length = hypot(b[0] - a[0], b[1] - a[1]), x = length > 1 ? (b[0] - a[0]) / length : 0, y = length > 1 ? (b[1] - a[1]) / length : 1;
    for (int i = 0; i < 3; i++) {
        real at[2] = {b[0] + 4 * i * pen->scale * x, b[1] + 4 * i * pen->scale * y}, w = wide[i] * pen->scale, half = pen->scale + (real)rim;
        const real one[2] = {at[0] - w * y, at[1] + w * x}, other[2] = {at[0] + w * y, at[1] - w * x};
        put_stroke(&pen->o->strokes, pen_stroke(one, other, half, half, colour, 1));
    }
}

/* Contacts are lines, joints double lines, links of other layers dashed, those of the range layer dotted. A link to what belongs to
 * no DIG ends at the sign for ground. Each DIG has its colour; those of other layers are numbered from elsewhere. */
static void show_dig(const Pen *pen, const View *v)
{
    for (int i = 0; i < v->edge_count; i++) {
        const ViewEdge *e = &v->edges[i];
        float linear[3], colour[3];
        vec3 a = vec3_from(e->a), b = vec3_from(e->b);
        dig_colour(e->dig + 7 * e->layer, linear);
        display_colour(linear, colour);
        for (int c = 0; c < 3; c++)         /* paler than the bodies, which have the same colour */
            colour[c] += 0.45f * (1 - colour[c]);
        if (e->layer)
            draw_dashes(pen, a, b, e->layer == DIG_LAYER_RANGE ? 15 : 6, e->layer == DIG_LAYER_RANGE ? 0.8 : 1.2, colour);
        else if (e->kind == DIG_LINK_JOINT)
            draw_double(pen, a, b, colour);
        else
            pen_line(pen, a, b, 1.1, colour, 1);
        draw_dot(pen, a, 2.6, colour);
        if (e->bound)
            draw_ground(pen, a, b, colour);
        else
            draw_dot(pen, b, 2.6, colour);
    }
}

static void show_joints(const Pen *pen, const View *v)
{
    for (int i = 0; i < v->line_count; i++) {
        const ViewLine *l = &v->lines[i];
        float colour[3];
        display_colour(l->colour, colour);
        pen_line(pen, vec3_from(l->a), vec3_from(l->b), 0.9, colour, 1);
        draw_dot(pen, vec3_from(l->a), 1.6, colour);
        draw_dot(pen, vec3_from(l->b), 1.6, colour);
    }
}

static void show_contacts(const Pen *pen, const View *v, real size)
{
    static const float colour[3] = {1.0f, 0.80f, 0.16f};
    for (int i = 0; i < v->contact_count; i++) {
        vec3 p = vec3_from(v->contacts[i].p);
        pen_line(pen, p, vec3_mad(p, 0.05 * size, vec3_from(v->contacts[i].n)), 0.7, colour, 1);
        draw_dot(pen, p, 1.8, colour);
    }
}

static const float contact_red[3] = {0.95f, 0.27f, 0.20f};

static real largest_force(const View *v)
{
    real largest = 0;
    for (int i = 0; i < v->contact_count; i++)
        largest = real_max(largest, vec3_length(vec3_from(v->contacts[i].force)));
    for (int i = 0; i < v->arrow_count; i++)
        largest = real_max(largest, vec3_length(vec3_from(v->arrows[i].v)));
    return isfinite(largest) ? largest : 0;
}

/* m; the longest arrow: two fifths of the scene's size, or a third of the picture's height where the nearest of the large forces is. */
static real longest_arrow(const Pen *pen, const View *v, real size, real largest)
{
    real length = 0.4 * size;
    for (int i = 0; i < v->contact_count + v->arrow_count; i++) {
        bool pushed = i >= v->contact_count;
        const ViewArrow *arrow = pushed ? &v->arrows[i - v->contact_count] : NULL;
        real f = vec3_length(vec3_from(pushed ? arrow->v : v->contacts[i].force)), at[2];
        vec3 p = vec3_from(pushed ? arrow->p : v->contacts[i].p);
        if (!(f > 0.25 * largest) || !project(pen->eye, p, at) || at[0] < 0 || at[0] > pen->eye->width || at[1] < 0 || at[1] > pen->eye->height)
            continue;
        real depth = vec3_dot(vec3_sub(p, pen->eye->at), pen->eye->forward);
        length = real_min(length, pen->eye->height * depth / (3 * pen->eye->pixels) / sqrt(f / largest));
    }
    return length;
}

/* Arrows as long as the root of the force: a pile's feet and its top both show. */
static void show_forces(const Pen *pen, const View *v, real size)
{
    real largest = largest_force(v), longest = longest_arrow(pen, v, size, largest);
    for (int i = 0; i < v->contact_count + v->arrow_count; i++) {
        bool pushed = i >= v->contact_count;
        const ViewArrow *arrow = pushed ? &v->arrows[i - v->contact_count] : NULL;
        vec3 p = vec3_from(pushed ? arrow->p : v->contacts[i].p), force = vec3_from(pushed ? arrow->v : v->contacts[i].force);
        real f = vec3_length(force);
        if (!(f > 1e-6 * largest))
            continue;
        float colour[3];
        if (pushed)
            display_colour(arrow->colour, colour);
        else
            memcpy(colour, contact_red, sizeof colour);
        draw_arrow(pen, p, vec3_mad(p, longest * sqrt(f / largest) / f, force), 1.4, colour);
    }
}

/* ---- names: above what they name, nearer ones first; one that would lie on another goes higher ---- */

typedef struct Plate { real x, y, half; } Plate;       /* px: middle of the baseline, half its width */

enum { MOST_NAMES = 256, LIFTS = 5 };

/* Its middle, off the plates that are there; false: there is no room near by. */
static bool find_room(const Plate *there, int count, real line, Plate *p)
{
    for (int lifts = 0; lifts <= LIFTS; lifts++) {
        bool free = true;
        for (int i = 0; i < count && free; i++)
            free = fabs(there[i].y - p->y) >= line - 0.5 || fabs(there[i].x - p->x) >= there[i].half + p->half;
        if (free)
            return true;
        p->y -= line;
    }
    return false;
}

static void show_name(const Pen *pen, const ViewLabel *label, Plate *plates, int *count)
{
    static const float line[3] = {1, 1, 1};
    Overlay *o = pen->o;
    real at[2], size = o->font.size;
    char text[sizeof label->text];
    snprintf(text, sizeof text, "%s", label->text);
    if (o->font.missing || *count == MOST_NAMES || !project(pen->eye, vec3_from(label->p), at))
        return;
    Plate p = {at[0], at[1] - 1.3 * size, 0.5 * text_width(&o->font, text) + 0.75 * size};
    if (at[0] < 0 || at[0] > pen->eye->width || at[1] < 0 || at[1] > pen->eye->height || !find_room(plates, *count, 1.35 * size, &p))
        return;
    plates[(*count)++] = p;
    const real foot[2] = {p.x, p.y + 0.26 * size};
    Stroke leader = pen_stroke(at, foot, 0.7 * pen->scale + (real)rim, 0.7 * pen->scale + (real)rim, line, 0.9f);
    put_stroke(&o->strokes, leader);
    draw_dot(pen, vec3_from(label->p), 1.3, line);
    draw_text(o, p.x - p.half + 0.75 * size, p.y, text);
}

typedef struct NameAt { real depth; int index; } NameAt;

static int by_depth(const void *a, const void *b)
{
    const NameAt *x = a, *y = b;
    return x->depth != y->depth ? (x->depth > y->depth) - (x->depth < y->depth) : x->index - y->index;
}

static void show_names(const Pen *pen, const View *v)
{
    Plate plates[MOST_NAMES];
    int count = 0;
    NameAt *order = malloc(((size_t)v->label_count + 1) * sizeof *order);
    pen->o->strokes.full |= !order;
    for (int i = 0; order && i < v->label_count; i++)
        order[i] = (NameAt){vec3_dot(vec3_sub(vec3_from(v->labels[i].p), pen->eye->at), pen->eye->forward), i};
    if (order)
        qsort(order, (size_t)v->label_count, sizeof *order, by_depth);
    for (int i = 0; order && i < v->label_count; i++)
        show_name(pen, &v->labels[order[i].index], plates, &count);
    free(order);
}

static void show_texts(const Pen *pen, const View *v, unsigned flags)
{
    Overlay *o = pen->o;
    if (flags & OVERLAY_NAMES)
        show_names(pen, v);
    if (flags & OVERLAY_TIME) {
        char text[80];
        snprintf(text, sizeof text, "t = %.3f s   step %llu", v->time, (unsigned long long)v->step);
        real foot = flags & OVERLAY_ENERGY ? history_foot(pen) : 0;
        draw_text(o, 1.2 * o->font.size, pen->eye->height - foot - 0.9 * o->font.size, text);
    }
}

#define BANDS 80

/* The scale of temperatures: a bar at the right with its ends in K. */
static void show_scale(const Pen *pen, const View *v)
{
    HeatScale scale = heat_scale(v);
    Overlay *o = pen->o;
    real size = o->font.size, x = pen->eye->width - 2 * size, top = 0.25 * pen->eye->height, bottom = 0.75 * pen->eye->height;
    if (!scale.on)
        return;
    for (int i = 0; i < BANDS; i++) {
        float linear[3], colour[3];
        real at[2] = {x, bottom + (top - bottom) * (i + 0.5) / BANDS}, half = 0.5 * (bottom - top) / BANDS + 0.5;
        heat_colour((i + 0.5) / BANDS, linear);
        display_colour(linear, colour);
        Stroke band = pen_stroke((real[2]){at[0] - 0.5 * size, at[1]}, (real[2]){at[0] + 0.5 * size, at[1]}, half, half, colour, 1);
        band.widths[2] = 0;
        put_stroke(&o->strokes, band);
    }
    for (int end = 0; end < 2; end++) {
        char text[32];
        snprintf(text, sizeof text, "%.0f K", end ? scale.high : scale.low);
        draw_text(o, x + 0.8 * size - text_width(&o->font, text), end ? top - 0.9 * size : bottom + 1.6 * size, text);
    }
}

#define LEGEND 40               /* steps of the bar */

/* The colours of stress, from none to what breaks, in the lower right corner. */
static void show_legend(const Pen *pen, unsigned flags)
{
    Overlay *o = pen->o;
    real unit = real_clamp(pen->eye->height / 45, 11, 48), right = pen->eye->width - 5 * unit, left = right - 9 * unit;
    real y = pen->eye->height - 1.2 * unit - (flags & OVERLAY_ENERGY ? history_foot(pen) : 0), half = 0.5 * (right - left) / LEGEND + 0.5;
    for (int i = 0; i < LEGEND; i++) {
        float linear[3], colour[3];
        stress_colour((float)i / (LEGEND - 1), linear);
        display_colour(linear, colour);
        real x = left + (right - left) * (i + 0.5) / LEGEND, a[2] = {x, y - 0.4 * unit}, b[2] = {x, y + 0.4 * unit};
        Stroke step = pen_stroke(a, b, half, half, colour, 1);
        step.widths[2] = 0;                 /* no rim */
        put_stroke(&o->strokes, step);
    }
    draw_text(o, left - unit - text_width(&o->font, "stress 0 %"), y + 0.36 * unit, "stress 0 %");
    draw_text(o, right + unit, y + 0.36 * unit, "100 %");
}

/* Three digits and a prefix of SI. */
void overlay_quantity(char out[32], real x, const char *unit)
{
    static const struct { real size; const char *prefix; } prefixes[] = {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}, {1, ""}, {1e-3, "m"}, {1e-6, "\u00b5"}};
    for (int i = 0; i < 6; i++)
        if (fabs(x) >= 0.9995 * prefixes[i].size) {
            real shown = x / prefixes[i].size;
            int places = fabs(shown) >= 99.95 ? 0 : fabs(shown) >= 9.995 ? 1 : 2;
            snprintf(out, 32, fabs(shown) < 1e5 ? "%.*f %s%s" : "%.*e %s%s", fabs(shown) < 1e5 ? places : 2, shown, prefixes[i].prefix, unit);
            return;
        }
    snprintf(out, 32, "0 %s", unit);
}

/* What arrows are, and how much the longest stands for; at the lower right, above the legend of stress. */
static void show_force_words(const Pen *pen, const View *v, unsigned flags)
{
    static const char *const words[] = {"contact", "push"};
    Overlay *o = pen->o;
    real largest = largest_force(v), size = o->font.size, y = pen->eye->height - 0.9 * size - (flags & OVERLAY_ENERGY ? history_foot(pen) : 0);
    char text[64], most[32];
    if (!(largest > 0) || o->font.missing)
        return;
    y -= flags & OVERLAY_STRESS ? 1.8 * size : 0;
    overlay_quantity(most, largest, "N");
    snprintf(text, sizeof text, "longest %s", most);
    real x = pen->eye->width - 1.2 * size - text_width(&o->font, text);
    draw_text(o, x, y, text);
    for (int kind = v->arrow_count > 0 ? 1 : 0; kind >= 0; kind--) {
        float colour[3] = {contact_red[0], contact_red[1], contact_red[2]};
        if (kind == 1)
            display_colour(v->arrows[0].colour, colour);
        x -= text_width(&o->font, words[kind]) + 1.9 * size;
        draw_text(o, x, y, words[kind]);
        const real left[2] = {x - 2 * size, y - 0.36 * size}, right[2] = {x - 1.1 * size, y - 0.36 * size};      /* beside the plate */
        put_stroke(&o->strokes, pen_stroke(left, right, 0.24 * size, 0.24 * size, colour, 1));
        x -= 2 * size;
    }
}

/* ---- drawing ---------------------------------------------------------- */

void overlay_open(Overlay *o, const Gl *gl)
{
    *o = (Overlay){0};
    gl->GenVertexArrays(1, &o->array);
    gl->GenBuffers(1, &o->buffer);
    gl->BindVertexArray(o->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, o->buffer);
    for (GLuint i = 0; i < 3; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, 4, GL_FLOAT, GL_FALSE, sizeof(Stroke), (const void *)(i * sizeof(float[4])));
        gl->VertexAttribDivisor(i, 1);
    }
}

void overlay_close(Overlay *o, const Gl *gl)
{
    gl->DeleteVertexArrays(1, &o->array);
    gl->DeleteBuffers(1, &o->buffer);
    if (o->font.texture)
        gl->DeleteTextures(1, &o->font.texture);
    font_close(&o->font);
    free(o->strokes.data);
    free(o->glyphs.data);
    *o = (Overlay){0};
}

static void load_font(Overlay *o, const Gl *gl, int size)
{
    Font *f = &o->font;
    if (f->missing || f->size == size)
        return;
    font_make(f, size);
    if (f->missing)
        return;
    if (!f->texture)
        gl->GenTextures(1, &f->texture);
    gl->BindTexture(GL_TEXTURE_2D, f->texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R8, FONT_SIDE, FONT_SIDE, 0, GL_RED, GL_UNSIGNED_BYTE, f->picture);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

static dig_status draw_list(const Overlay *o, Programs *programs, const Gl *gl, const StrokeList *list, ProgramKind kind, char *why,
                            size_t capacity)
{
    if (list->count == 0)
        return DIG_OK;
    const Program *program = programs_get(programs, gl, (ProgramKey){.kind = kind}, why, capacity);
    if (!program)
        return DIG_E_FORMAT;
    gl->UseProgram(program->name);
    gl->BindVertexArray(o->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, o->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, list->count * (GLsizeiptr)sizeof *list->data, list->data, GL_STREAM_DRAW);
    gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, list->count);
    return DIG_OK;
}

dig_status overlay_draw(Overlay *o, Programs *programs, const Gl *gl, const View *v, const Stage *s, const OverlayEye *eye, unsigned flags,
                        const ViewPast *past, char *why, size_t capacity)
{
    o->strokes.count = o->glyphs.count = 0;
    o->strokes.full = o->glyphs.full = false;
    Pen pen = {o, eye, real_clamp(eye->height / 720, 0.6, 6)};
    if (flags & OVERLAY_DIG)
        show_dig(&pen, v);
    if (flags & OVERLAY_JOINTS)
        show_joints(&pen, v);
    if (flags & OVERLAY_CONTACTS)
        show_contacts(&pen, v, s->unit);
    if (flags & OVERLAY_FORCES)
        show_forces(&pen, v, s->unit);
    if ((flags & OVERLAY_TRAILS) && past)
        history_trails(&pen, v, past);
    if (flags & (OVERLAY_ENERGY | OVERLAY_FORCES | OVERLAY_NAMES | OVERLAY_TIME | OVERLAY_TEMPERATURE | OVERLAY_STRESS)) {
        gl->ActiveTexture(GL_TEXTURE0 + UNIT_FONT);
        load_font(o, gl, (int)real_clamp(round(eye->height / 45), 11, 48));
        show_texts(&pen, v, flags);
        if (flags & OVERLAY_TEMPERATURE)
            show_scale(&pen, v);
        if (flags & OVERLAY_STRESS)
            show_legend(&pen, flags);
        if (flags & OVERLAY_FORCES)
            show_force_words(&pen, v, flags);
        if ((flags & OVERLAY_ENERGY) && past)
            history_energies(&pen, v, past);
    }
    if (o->strokes.full || o->glyphs.full) {
        snprintf(why, capacity, "no memory for the overlay");
        return DIG_E_MEMORY;
    }
    gl->ActiveTexture(GL_TEXTURE0 + UNIT_FONT);
    if (o->font.texture)
        gl->BindTexture(GL_TEXTURE_2D, o->font.texture);
    gl->Disable(GL_DEPTH_TEST);
    gl->Disable(GL_CULL_FACE);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    dig_status status = draw_list(o, programs, gl, &o->strokes, PROGRAM_STROKE, why, capacity);
    if (status == DIG_OK)
        status = draw_list(o, programs, gl, &o->glyphs, PROGRAM_GLYPH, why, capacity);
    gl->Disable(GL_BLEND);
    return status;
}
