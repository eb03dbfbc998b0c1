/* tests/bench/render.c - what a frame costs: `make bench SCENE=render`.
 *
 * 200 bodies on a floor (100 textured boxes, 20 painted ones, 40 balls, 40 capsules) at 1280x720 with shadows, the camera circling,
 * each frame written as a PNG file. Printed: processor time per phase, frames a second of one process and of two that share the
 * frames, and how far the edges lie from a supersampled picture, for each way of smoothing them.
 *
 *   render [frames] [folder]         everything; frames for each of the two processes (300), folder for the pictures (build/bench/render)
 *   render one SMOOTH FILE           one picture, to look at: none, smooth or samples
 */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "render/render.h"

enum { BODIES = 200, WIDTH = 1280, HEIGHT = 720, FINE = 4, GOAL = 55 };

/* ---- the scene --------------------------------------------------------------- */

typedef struct Scene {
    View     view;
    ViewMesh meshes[BODIES + 1];
    ViewItem items[BODIES + 1];
} Scene;

static double noise(uint64_t *x)        /* 0..1; MMIX constants of Knuth, upper half */
{
    *x = *x * 6364136223846793005u + 1442695040888963407u;
    return (double)(uint32_t)(*x >> 32) / 4294967296.0;
}

static void set_colour(ViewItem *item, const float colour[3], int pattern, float rough)
{
    memcpy(item->colour, colour, sizeof item->colour);
    item->pattern = pattern;
    item->roughness = rough;
}

static const float paints[6][3] = {{0.60f, 0.06f, 0.05f}, {0.05f, 0.32f, 0.60f}, {0.07f, 0.38f, 0.16f},
                                   {0.70f, 0.48f, 0.05f}, {0.05f, 0.42f, 0.45f}, {0.10f, 0.10f, 0.13f}};
static const float wood[3] = {0.40f, 0.23f, 0.10f}, brick[3] = {0.48f, 0.18f, 0.10f};

static void dress(ViewMesh *mesh, ViewItem *item, int i, uint64_t *x)
{
    float a = (float)(0.28 + 0.30 * noise(x)), b = (float)(0.22 + 0.22 * noise(x)), r = (float)(0.12 + 0.10 * noise(x));
    const float *paint = paints[i % 6];
    if (i < 120) {
        *mesh = (ViewMesh){.form = VIEW_BOX, .size = {a, b, i % 2 ? a : b}};
        if (i >= 100)
            set_colour(item, paint, PATTERN_PLAIN, 0.4f);
        else
            set_colour(item, i % 2 ? wood : brick, i % 2 ? PATTERN_WOOD : PATTERN_BRICK, 0.7f);
    } else if (i < 160) {
        *mesh = (ViewMesh){.form = VIEW_SPHERE, .size = {1.2f * r}};
        set_colour(item, paint, PATTERN_STRIPE, 0.25f);
    } else {
        *mesh = (ViewMesh){.form = VIEW_CAPSULE, .size = {0.7f * r, 2.2f * r}};
        set_colour(item, paint, PATTERN_STRIPE, 0.3f);
    }
}

/* A heap in a few layers; poses by chance, not by physics. */
static void scene_fill(Scene *s)
{
    uint64_t x = 20261122;
    memset(s, 0, sizeof *s);
    s->view = (View){.up = {0, 1, 0}, .meshes = s->meshes, .items = s->items, .mesh_count = BODIES + 1, .item_count = BODIES + 1};
    for (int i = 0; i < BODIES; i++) {
        ViewItem *item = &s->items[i];
        *item = (ViewItem){.body = (uint32_t)i + 1, .mesh = i, .dig = 1, .stress = -1};
        int place = (i * 73) % BODIES, layer = place / 80, column = place % 80;
        double yaw = 3.1 * noise(&x), roll = layer ? 0.5 * (noise(&x) - 0.5) : 0;
        item->p[0] = (float)(0.62 * (column % 10 - 4.5) + 0.2 * (noise(&x) - 0.5));
        item->p[1] = (float)(0.22 + 0.42 * layer + 0.08 * noise(&x));
        item->p[2] = (float)(0.62 * (column / 10 - 3.5) + 0.2 * (noise(&x) - 0.5));
        dress(&s->meshes[i], item, i, &x);
        double q[4] = {sin(roll / 2) * cos(yaw / 2), cos(roll / 2) * sin(yaw / 2), sin(roll / 2) * sin(yaw / 2), cos(roll / 2) * cos(yaw / 2)};
        for (int k = 0; k < 4; k++)
            item->q[k] = (float)q[k];
    }
    s->meshes[BODIES] = (ViewMesh){.form = VIEW_PLANE};
    s->items[BODIES] = (ViewItem){.body = BODIES + 1, .mesh = BODIES, .q = {0, 0, 0, 1}, .fixed = true, .stress = -1, .roughness = 0.8f,
                                  .colour = {0.52f, 0.50f, 0.47f}};
}

static RenderOptions options(int frame)
{
    RenderOptions o = render_defaults();
    double angle = 0.5 + 0.004 * frame;
    o.width = WIDTH;
    o.height = HEIGHT;
    o.camera = (RenderCamera){{7.2 * sin(angle), 2.9, 7.2 * cos(angle)}, {0, 0.35, 0}, {0, 1, 0}, 0.70};
    return o;
}

/* ---- clocks ------------------------------------------------------------------- */

static double read_ms(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static double cpu_ms(void) { return read_ms(CLOCK_PROCESS_CPUTIME_ID); }
static double wall_ms(void) { return read_ms(CLOCK_MONOTONIC); }

static void need(bool good, const char *why)
{
    if (good)
        return;
    fprintf(stderr, "bench: render: %s\n", why);
    exit(1);
}

/* ---- frames ------------------------------------------------------------------- */

enum { LIGHT, DRAW, READ, SMOOTH, ENCODE, WRITE, PHASES, FRAMES_KEPT = 1000 };

static const char *const phase_names[PHASES] = {"light maps", "draw", "read back", "smooth", "encode", "write"};

typedef struct Phases { double ms[PHASES][FRAMES_KEPT]; int frames; long bytes; } Phases;

static Renderer *open_renderer(void)
{
    Renderer *r = NULL;
    char why[300] = "";
    need(render_open(NULL, &r, why, sizeof why) == DIG_OK, why);
    return r;
}

static void keep(Phases *p, const RenderTimes *a, const RenderTimes *b, double encode, double write)
{
    if (p->frames == FRAMES_KEPT)
        return;
    double ms[PHASES] = {b->light - a->light, b->draw - a->draw, b->read - a->read, b->smooth - a->smooth, encode, write};
    for (int k = 0; k < PHASES; k++)
        p->ms[k][p->frames] = ms[k];
    p->frames++;
}

/* Frames first..last-1. */
static void film(const Scene *s, int first, int last, const char *folder, Phases *p)
{
    Renderer *r = open_renderer();
    PngBytes png = {0};
    for (int i = first; i < last; i++) {
        RenderOptions o = options(i);
        RenderTimes before = render_times(r);
        const void *pixels;
        char path[600], why[600] = "";
        need(render_draw(r, &s->view, &o, &pixels) == DIG_OK, render_error(r));
        RenderTimes after = render_times(r);
        double a = cpu_ms();
        need(png_encode(o.layer, o.width, o.height, pixels, NULL, 0, &png, why, sizeof why) == DIG_OK, why);
        double b = cpu_ms();
        snprintf(path, sizeof path, "%s/f-%05d.png", folder, i);
        need(png_save(path, &png, false, why, sizeof why) == DIG_OK, why);
        if (i < first + 2)      /* the first ones compile shaders */
            continue;
        p->bytes += (long)png.size;
        keep(p, &before, &after, b - a, cpu_ms() - b);
    }
    png_release(&png);
    render_close(r);
}

static int compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* Medians, and the calmest tenth: on a busy machine the processor time of the same work is up to twice as long. */
static void print_phases(Phases *p)
{
    double sum = 0, calm = 0;
    printf("  processor time of a frame, ms        median   calm\n");
    for (int k = 0; k < PHASES; k++) {
        qsort(p->ms[k], (size_t)p->frames, sizeof *p->ms[k], compare_numbers);
        double median = p->ms[k][p->frames / 2], low = p->ms[k][p->frames / 10];
        printf("    %-30s %9.2f %6.2f\n", phase_names[k], median, low);
        sum += median;
        calm += low;
    }
    printf("    %-30s %9.2f %6.2f   so at most %.1f or %.1f frames/s with two cores; %.0f KB a file\n", "together", sum, calm, 2000 / sum,
           2000 / calm, (double)p->bytes / 1e3 / (p->frames > 0 ? p->frames : 1));
}

/* Frames in `workers` processes side by side, from start-up to the last file; frames a second by the wall clock. The workers are
 * forked before there is any context. */
static double race(const Scene *s, int workers, int frames, const char *folder)
{
    double began = wall_ms();
    pid_t children[4];
    for (int i = 0; i < workers; i++) {
        fflush(stdout);
        children[i] = fork();
        need(children[i] >= 0, "cannot fork");
        if (children[i] == 0) {
            static Phases unused;
            film(s, i * frames, (i + 1) * frames, folder, &unused);
            _exit(0);
        }
    }
    for (int i = 0; i < workers; i++) {
        int status = 0;
        need(waitpid(children[i], &status, 0) == children[i] && status == 0, "a worker failed");
    }
    return 1e3 * workers * frames / (wall_ms() - began);
}

/* ---- edges -------------------------------------------------------------------- */

static unsigned char *picture(Renderer *r, const Scene *s, RenderOptions o)
{
    const void *pixels;
    need(render_draw(r, &s->view, &o, &pixels) == DIG_OK, render_error(r));
    size_t size = 3 * (size_t)o.width * (size_t)o.height;
    unsigned char *copy = malloc(size);
    need(copy != NULL, "no memory");
    memcpy(copy, pixels, size);
    return copy;
}

/* Means of FINE x FINE pixels; edge[i] where these span more than 24 levels of brightness. */
static unsigned char *shrink(const unsigned char *large, bool *edge)
{
    unsigned char *small = malloc((size_t)3 * WIDTH * HEIGHT);
    need(small != NULL, "no memory");
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int sum[3] = {0, 0, 0}, low = 255, high = 0;
            for (int k = 0; k < FINE * FINE; k++) {
                const unsigned char *p = large + 3 * ((size_t)(y * FINE + k / FINE) * WIDTH * FINE + (size_t)(x * FINE + k % FINE));
                int luma = (2 * p[0] + 5 * p[1] + p[2]) / 8;
                low = luma < low ? luma : low;
                high = luma > high ? luma : high;
                for (int c = 0; c < 3; c++)
                    sum[c] += p[c];
            }
            edge[y * WIDTH + x] = high - low > 24;
            for (int c = 0; c < 3; c++)
                small[3 * (y * WIDTH + x) + c] = (unsigned char)((sum[c] + FINE * FINE / 2) / (FINE * FINE));
        }
    return small;
}

static void print_error(const char *name, const unsigned char *p, const unsigned char *truth, const bool *edge)
{
    double at_edges = 0, all = 0;
    long edges = 0, far = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double square = 0;
        int most = 0;
        for (int c = 0; c < 3; c++) {
            int d = abs(p[3 * i + c] - truth[3 * i + c]);
            square += d * d / 3.0;
            most = d > most ? d : most;
        }
        all += square;
        at_edges += edge[i] ? square : 0;
        edges += edge[i];
        far += most > 32;
    }
    printf("  %-10s  edge pixels off by %6.2f levels (rms)   all by %5.2f   %6ld pixels off by more than 32\n", name,
           sqrt(at_edges / (double)(edges ? edges : 1)), sqrt(all / (WIDTH * HEIGHT)), far);
}

static void set_smoothing(RenderOptions *o, const char *name)
{
    o->smooth = strcmp(name, "smooth") == 0;
    o->samples = strcmp(name, "samples") == 0 ? 4 : 0;
}

static void compare_edges(const Scene *s, int frame)
{
    static const char *const names[] = {"none", "smooth", "samples"};
    static bool edge[WIDTH * HEIGHT];
    Renderer *r = open_renderer();
    RenderOptions o = options(frame);
    set_smoothing(&o, "none");
    o.width *= FINE;
    o.height *= FINE;
    unsigned char *large = picture(r, s, o), *truth = shrink(large, edge);
    free(large);
    printf("  edges of frame %d against a picture of %d x %d pixels, each channel 0..255\n", frame, o.width, o.height);
    for (int i = 0; i < 3; i++) {
        o = options(frame);
        set_smoothing(&o, names[i]);
        unsigned char *p = picture(r, s, o);
        print_error(names[i], p, truth, edge);
        free(p);
    }
    free(truth);
    render_close(r);
}

static int one(const Scene *s, const char *smoothing, const char *path)
{
    Renderer *r = open_renderer();
    RenderOptions o = options(0);
    set_smoothing(&o, smoothing);
    const void *pixels;
    char why[600] = "";
    need(render_draw(r, &s->view, &o, &pixels) == DIG_OK, render_error(r));
    need(png_write(path, o.layer, o.width, o.height, pixels, NULL, 0, why, sizeof why) == DIG_OK, why);
    render_close(r);
    return 0;
}

int main(int count, char **arguments)
{
    static Scene s;
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    setenv("LP_NUM_THREADS", "0", 1);
    scene_fill(&s);
    if (count == 4 && strcmp(arguments[1], "one") == 0)
        return one(&s, arguments[2], arguments[3]);
    if (count == 2 && strcmp(arguments[1], "phases") == 0) {
        static Phases p;
        film(&s, 0, 60, ".", &p);
        print_phases(&p);
        return 0;
    }
    int frames = count > 1 ? atoi(arguments[1]) : 300;
    const char *folder = count > 2 ? arguments[2] : "build/bench/render";
    need(frames > 2, "at least 3 frames");
    need(mkdir(folder, 0777) == 0 || errno == EEXIST, folder);
    double loads[1] = {0};
    getloadavg(loads, 1);
    printf("render: %d bodies, %d x %d, shadows, edges smoothed, PNG files; %ld cores, load %.1f at the start\n", BODIES, WIDTH, HEIGHT,
           sysconf(_SC_NPROCESSORS_ONLN), loads[0]);
    double single = race(&s, 1, frames, folder), both = race(&s, 2, frames, folder);
    static Phases p;
    film(&s, 0, frames < 100 ? frames : 100, folder, &p);
    print_phases(&p);
    printf("  end to end, start-up included     one process %.1f frames/s   two %.1f   ratio %.2f   goal %d  %s\n", single, both,
           both / single, GOAL, both >= GOAL ? "met" : "MISSED");
    compare_edges(&s, 0);
    return 0;
}
