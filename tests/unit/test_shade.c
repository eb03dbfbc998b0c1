/* tests/unit/test_shade.c - pictures shaded by the CPU beside those that OpenGL draws of the same views. */
#include "picture_fixture.h"
#include "render/render.h"

enum { WIDTH = 320, HEIGHT = 180 };

static RenderOptions options(void)
{
    RenderOptions o = render_defaults();
    o.width = WIDTH;
    o.height = HEIGHT;
    o.smooth = false;
    o.camera = (RenderCamera){{0, 1.5, 6}, {0, 0, 0}, {0, 1, 0}, 0.8};
    return o;
}

static void *copy_of(const void *pixels, size_t size)
{
    void *copy = malloc(size);
    assert_non_null(copy);
    memcpy(copy, pixels, size);
    return copy;
}

/* All forms and patterns that the CPU shades, under the sun and a lamp, some turned, one metallic. */
static void one_of_each(Scene *s, int pattern)
{
    static const ViewForm forms[] = {VIEW_BOX, VIEW_SPHERE, VIEW_CAPSULE, VIEW_CYLINDER};
    scene_open(s);
    add(s, VIEW_PLANE, 0, 0, 0, 0, -0.8, 0)->pattern = pattern == PATTERN_WOOD || pattern == PATTERN_BRICK ? PATTERN_PLAIN : pattern;
    for (int i = 0; i < 8; i++) {
        ViewForm form = forms[i % 4];
        ViewItem *item = add(s, form, form == VIEW_BOX ? 0.9 : 0.45, 0.7, 0.8, 1.25 * (i % 4) - 1.9, i / 4 ? 0.9 : -0.35, i / 4 ? -0.3 : 0.2);
        item->pattern = pattern;
        item->roughness = 0.3f + 0.05f * (float)i;
        item->metallic = i == 5;
        item->colour[i % 3] = 0.2f;
        for (int k = 0; k < 3; k++)
            item->q[k] = i / 4 ? 0.3f * (float)(k - 1) + 0.1f : 0;
        item->q[3] = i / 4 ? 0.8f : 1;
    }
}

/* Whether a pixel and its neighbours, two each way, show the same body. */
static bool is_inside(const uint32_t *id, int width, int x, int y)
{
    for (int dy = -2; dy <= 2; dy++)
        for (int dx = -2; dx <= 2; dx++)
            if (id[(y + dy) * width + x + dx] != id[y * width + x])
                return false;
    return true;
}

/* Differences inside the outline of each body: in the mean of its colour, and of the single pixels. */
typedef struct Apart { double colour[ITEMS + 1], pixel[ITEMS + 1]; long count[ITEMS + 1]; } Apart;

static Apart compare_bodies(const uint32_t *id, const unsigned char *a, const unsigned char *b, int width, int height)
{
    Apart d = {{0}, {0}, {0}};
    for (int y = 2; y < height - 2; y++)
        for (int x = 2; x < width - 2; x++) {
            int i = y * width + x;
            if (!is_inside(id, width, x, y))
                continue;
            d.count[id[i]]++;
            for (int k = 0; k < 3; k++) {
                d.colour[id[i]] += (a[3 * i + k] - b[3 * i + k]) / 3.0;
                d.pixel[id[i]] += abs(a[3 * i + k] - b[3 * i + k]) / 3.0;
            }
        }
    return d;
}

static uint32_t *ids_of(const Scene *s, RenderOptions o)
{
    o.layer = RENDER_ID;
    return copy_of(draw(s, &o), 4 * WIDTH * HEIGHT);
}

/* Bodies shaded by the CPU look as those shaded by OpenGL, which still does it where a pixel has several samples. Its balls are
 * polyhedra, on which fine wood lies a pixel beside. */
TEST(bodies_look_the_same_whoever_shades_them)
{
    Scene s;
    RenderOptions o = options(), other = o;
    o.lamp_count = other.lamp_count = 1;
    o.lamps[0] = other.lamps[0] = (RenderLamp){{1, 2.5, 2}, 60, {1, 0.8f, 0.6f}};
    other.samples = 4;
    for (int pattern = PATTERN_PLAIN; pattern <= PATTERN_CHECK; pattern++) {
        one_of_each(&s, pattern);
        uint32_t *id = ids_of(&s, o);
        unsigned char *quick = copy_of(draw(&s, &o), 3 * WIDTH * HEIGHT);
        Apart d = compare_bodies(id, quick, draw(&s, &other), WIDTH, HEIGHT);
        for (int i = 1; i <= s.view.item_count; i++) {
            double n = (double)d.count[i];
            if (!(n > 200 && fabs(d.colour[i] / n) < 1.5 && d.pixel[i] / n < (pattern == PATTERN_WOOD ? 6 : 3)))
                fail_msg("pattern %d, body %d: %g pixels; colour off by %.2f levels, pixels by %.2f", pattern, i, n, d.colour[i] / n,
                         d.pixel[i] / n);
        }
        free(id);
        free(quick);
    }
}

/* Rays meet the solids that OpenGL draws: with a mesh in the view it numbers the pixels itself, and only outlines may differ. */
TEST(rays_find_the_bodies_that_opengl_draws)
{
    static float corners[9] = {-3, 3, 0, -2.9f, 3, 0, -3, 3.1f, 0};      /* a scrap in a corner of the picture */
    static uint32_t triangle[3] = {0, 1, 2};
    for (int turn = 0; turn < 3; turn++) {
        Scene s;
        RenderOptions o = options();
        one_of_each(&s, PATTERN_PLAIN);
        o.camera.at[0] = turn - 1.0;
        o.camera.at[2] = turn == 2 ? 1.4 : 6;        /* close by: some bodies reach behind the eye */
        o.shadows = false;
        unsigned char *rays = copy_of(draw(&s, &o), 3 * WIDTH * HEIGHT);
        uint32_t *id = ids_of(&s, o);
        s.meshes[s.view.mesh_count] = (ViewMesh){.form = VIEW_MESH, .vertices = corners, .vertex_count = 3, .indices = triangle,
                                                 .index_count = 3};
        s.items[s.view.item_count] = (ViewItem){.body = 99, .mesh = s.view.mesh_count++, .q = {0, 0, 0, 1}, .fixed = true};
        s.view.item_count++;
        const unsigned char *drawn = draw(&s, &o);
        long off = 0, inside = 0, outline = 0;
        for (int y = 2; y < HEIGHT - 2; y++)
            for (int x = 2; x < WIDTH - 2; x++) {
                int i = y * WIDTH + x;
                bool differ = abs(rays[3 * i] - drawn[3 * i]) + abs(rays[3 * i + 1] - drawn[3 * i + 1]) > 60, in = is_inside(id, WIDTH, x, y);
                inside += in;
                off += in && differ;
                outline += !in && differ;
            }
        if (!(inside > WIDTH * HEIGHT / 2 && off < 20 && outline < 300))
            fail_msg("camera %d: of %ld pixels inside outlines %ld differ, on outlines %ld", turn, inside, off, outline);
        free(rays);
        free(id);
    }
}

/* A smooth floor mirrors what stands on it, straight below it and as high, whoever draws it; a dull one, and what lies below, does not. */
TEST(a_smooth_floor_mirrors_what_stands_on_it)
{
    Scene s;
    RenderOptions o = options();
    scene_open(&s);
    ViewItem *plane = add(&s, VIEW_PLANE, 0, 0, 0, 0, 0, 0), *ball = add(&s, VIEW_SPHERE, 0.4, 0, 0, 0, 1, 0);
    plane->fixed = true;
    ball->colour[0] = 0.9f;
    ball->colour[1] = ball->colour[2] = 0.02f;
    o.shadows = false;
    o.camera = (RenderCamera){{0, 1.5, 6}, {0, 0, 0}, {0, 1, 0}, 0.8};
    /* the ball's image is at (0, -1, 0): 1 m below what the camera looks at, seen from 1.5 m up and 6 m away */
    double slope = atan2(1.5, 6), image = atan2(2.5, 6) - slope, y = HEIGHT / 2.0 * (1 + tan(image) / tan(0.4));
    int red[4], beside[4];
    for (int i = 0; i < 4; i++) {
        plane->roughness = i == 3 ? 0.4f : 0.02f;
        ball->p[1] = i == 2 ? -1 : 1;
        o.samples = i == 1 ? 4 : 0;
        const unsigned char *p = draw(&s, &o), *at = p + 3 * ((int)y * WIDTH + WIDTH / 2), *off = at + 3 * (WIDTH / 3);
        red[i] = at[0] - at[1];
        beside[i] = off[0] - off[1];
    }
    for (int i = 0; i < 2; i++)
        if (!(red[i] > beside[i] + 8))
            fail_msg("%s: red less green is %d in the image of the ball, %d beside it", i == 0 ? "by rays" : "by OpenGL", red[i], beside[i]);
    CHECK(abs(red[0] - red[1]) < 3);
    CHECK(abs(red[2] - beside[2]) < 3);
    CHECK(abs(red[3] - beside[3]) < 3);
}

/* A box stands in a clear slab over a deep floor; seen from above, its shadow on the slab ends in a straight line. */
TEST(a_shadow_on_what_is_seen_through_has_a_straight_rim)
{
    Scene s;
    RenderOptions o = options();
    scene_open(&s);
    add(&s, VIEW_BOX, 12, 0.4, 8, 0, -8.2, 0)->fixed = true;
    add(&s, VIEW_BOX, 12, 8, 8, 0, -4, 0)->clear = 0.5f;
    add(&s, VIEW_BOX, 0.8, 0.8, 1.6, -0.3, 0, 0);
    s.items[1].fixed = true;
    s.items[2].q[1] = 0.15f;
    s.items[2].q[3] = 0.9887f;
    o.sun[0] = -1;
    o.sun[1] = 1;
    o.camera = (RenderCamera){{0, 4, 0}, {0, 0, 0}, {0, 0, -1}, 0.8};
    const unsigned char *p = draw(&s, &o);
    double first = 0, last = 0, bend = 0, rim[HEIGHT] = {0};
    enum { TOP = HEIGHT / 2 - 20, BOTTOM = HEIGHT / 2 + 20 };
    for (int y = TOP; y <= BOTTOM; y++) {           /* from the right: the first pixel that is a third of the way to the darkest */
        int x = WIDTH - 20, open = p[3 * (y * WIDTH + x) + 1], dark = open;
        for (int k = WIDTH / 2; k < WIDTH / 2 + 60; k++)
            dark = int_min(dark, p[3 * (y * WIDTH + k) + 1]);
        CHECK(open - dark > 24);
        while (x > 0 && 3 * (open - p[3 * (y * WIDTH + x) + 1]) < open - dark)
            x--;
        rim[y] = x;
        CHECK(x > WIDTH / 2 && x < WIDTH / 2 + 60);
    }
    first = rim[TOP];
    last = rim[BOTTOM];
    for (int y = TOP; y <= BOTTOM; y++)
        bend = fmax(bend, fabs(rim[y] - (first + (last - first) * (y - TOP) / (BOTTOM - TOP))));
    if (bend > 1.5)
        fail_msg("the rim bends by %.1f pixels", bend);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(bodies_look_the_same_whoever_shades_them),
        unit_test(rays_find_the_bodies_that_opengl_draws),
        unit_test(a_shadow_on_what_is_seen_through_has_a_straight_rim),
        unit_test(a_smooth_floor_mirrors_what_stands_on_it),
    };
    return cmocka_run_group_tests(tests, open_shared, close_shared);
}
