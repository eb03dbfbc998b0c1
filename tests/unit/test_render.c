/* tests/unit/test_render.c - pictures of views built by hand, checked pixel by pixel against closed forms. */
#include "picture_fixture.h"
#include "render/render.h"

/* ---- views by hand ----------------------------------------------------- */

enum { WIDTH = 160, HEIGHT = 90 };

/* A ball of 1 m (body 2) that stands on a plane (body 1), its centre at the origin. */
static void ball_on_plane(Scene *s)
{
    scene_open(s);
    add(s, VIEW_PLANE, 0, 0, 0, 0, -1, 0);
    add(s, VIEW_SPHERE, 1, 0, 0, 0, 0, 0);
}

/* Boxes, a ball and a capsule on a plane: something of everything, few programs. */
static void mixed(Scene *s)
{
    scene_open(s);
    add(s, VIEW_PLANE, 0, 0, 0, 0, 0, 0);
    add(s, VIEW_BOX, 0.5, 0.5, 0.5, -0.6, 0.25, 0);
    add(s, VIEW_BOX, 0.4, 0.4, 0.4, -0.55, 0.7, 0.05)->colour[0] = 0.8f;
    add(s, VIEW_SPHERE, 0.3, 0, 0, 0.2, 0.3, 0.1);
    add(s, VIEW_CAPSULE, 0.15, 0.4, 0, 0.8, 0.35, -0.3)->colour[2] = 0.1f;
}

static RenderOptions options(void)
{
    RenderOptions o = render_defaults();
    o.width = WIDTH;
    o.height = HEIGHT;
    o.camera = (RenderCamera){{0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 0.8};
    return o;
}

static uint32_t id_at(const Scene *s, RenderOptions o, int x, int y)
{
    o.layer = RENDER_ID;
    return ((const uint32_t *)draw(s, &o))[y * o.width + x];
}

static double depth_at(const Scene *s, RenderOptions o, int x, int y)
{
    o.layer = RENDER_DEPTH;
    return (double)((const float *)draw(s, &o))[y * o.width + x];
}

static int brightness(const void *pixels, int width, int x, int y)
{
    const unsigned char *p = (const unsigned char *)pixels + 3 * (y * width + x);
    return p[0] + p[1] + p[2];
}

static unsigned char *copy_of(const void *pixels, size_t size)
{
    unsigned char *copy = malloc(size);
    if (!copy)
        fail_msg("no memory for %zu bytes", size);
    memcpy(copy, pixels, size);
    return copy;
}

/* ---- layers ------------------------------------------------------------ */

TEST(the_id_layer_names_the_body_that_is_seen)
{
    Scene s;
    ball_on_plane(&s);
    s.items[1].body = 70000;        /* more than 16 bits */
    RenderOptions o = options();
    CHECK_INT(id_at(&s, o, WIDTH / 2, HEIGHT / 2), 70000);
    CHECK_INT(id_at(&s, o, WIDTH / 2, HEIGHT - 1), 1);
    CHECK_INT(id_at(&s, o, WIDTH / 2, 0), 0);
    CHECK_INT(id_at(&s, o, 0, 0), 0);
}

TEST(depth_of_a_ball_and_of_a_plane_is_the_closed_form)
{
    Scene s;
    ball_on_plane(&s);
    RenderOptions o = options();
    o.width = 161;      /* odd: the middle of the picture is the middle of a pixel */
    o.height = 91;
    CHECK_NEAR(depth_at(&s, o, 80, 45), 5, 1e-3);
    /* a pixel to the side: |t d - c| = 1 with d of unit depth */
    double x = (2 * 88.5 / 161 - 1) * tan(0.4) * 161 / 91, dd = 1 + x * x;
    CHECK_NEAR(depth_at(&s, o, 88, 45), (6 - sqrt(36 - 35 * dd)) / dd, 1e-3);
    /* the plane 1 m below the eye is met at depth 1 / slope */
    for (int y = 75; y < 91; y += 5) {
        double slope = (2 * (y + 0.5) / 91 - 1) * tan(0.4);
        CHECK_NEAR(depth_at(&s, o, 2, y), 1 / slope, 1e-3 / slope);
    }
    CHECK(isinf(depth_at(&s, o, 80, 0)));
}

TEST(depth_of_a_turned_box_is_the_closed_form)
{
    Scene s;
    scene_open(&s);
    ViewItem *box = add(&s, VIEW_BOX, 2, 2, 2, 0, 0, 0);
    box->q[1] = (float)sin(0.125 * 3.14159265358979);      /* 45 degrees about y: an edge towards the eye */
    box->q[3] = (float)cos(0.125 * 3.14159265358979);
    RenderOptions o = options();
    o.width = 161;
    o.height = 91;
    CHECK_NEAR(depth_at(&s, o, 80, 45), 6 - sqrt(2), 1e-3);
}

TEST(far_from_the_origin_nothing_changes)
{
    Scene s;
    ball_on_plane(&s);
    RenderOptions o = options();
    const real far[3] = {3e6, -2e6, 5e6};
    for (int i = 0; i < 3; i++) {
        s.view.origin[i] = far[i];
        o.camera.at[i] += far[i];
        o.camera.look_at[i] += far[i];
    }
    o.width = 161;
    o.height = 91;
    CHECK_NEAR(depth_at(&s, o, 80, 45), 5, 1e-3);
}

TEST(the_normal_layer_points_at_the_eye_from_a_face_turned_to_it)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_BOX, 2, 2, 2, 0, 0, 0);
    RenderOptions o = options();
    o.layer = RENDER_NORMAL;
    const unsigned char *p = (const unsigned char *)draw(&s, &o) + 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    CHECK_NEAR(p[0], 127.5, 1);
    CHECK_NEAR(p[1], 127.5, 1);
    CHECK_INT(p[2], 255);
}

/* ---- light ------------------------------------------------------------- */

TEST(the_side_away_from_the_sun_is_darker)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_SPHERE, 1, 0, 0, 0, 0, 0);
    RenderOptions o = options();
    o.sun[0] = 1;
    o.sun[1] = 0.2f;
    const void *p = draw(&s, &o);
    int lit = brightness(p, WIDTH, WIDTH / 2 + 12, HEIGHT / 2), dark = brightness(p, WIDTH, WIDTH / 2 - 12, HEIGHT / 2);
    if (!(lit > dark + 100))
        fail_msg("lit side %d, dark side %d of 765", lit, dark);
}

/* From straight above: x runs right, z down. One metre is this many pixels at height y. */
static RenderOptions from_above(double height)
{
    RenderOptions o = options();
    o.camera = (RenderCamera){{0, height, 0}, {0, 0, 0}, {0, 0, -1}, 0.8};
    o.sun[0] = 1;
    o.sun[1] = 1;
    return o;
}

TEST(a_box_throws_its_shadow_where_the_sun_says)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_PLANE, 0, 0, 0, 0, 0, 0);
    add(&s, VIEW_BOX, 0.8, 0.1, 0.8, 0, 1.5, 0);        /* hovers; its shadow lies 1.5 m to the left */
    RenderOptions o = from_above(8);
    double pixels = HEIGHT / 2.0 / tan(0.4) / 8;
    int x = (int)(WIDTH / 2 - 1.5 * pixels), y = HEIGHT / 2;
    const void *p = draw(&s, &o);
    int shadow = brightness(p, WIDTH, x, y), beside = brightness(p, WIDTH, x, y + (int)(1.5 * pixels));
    int other = brightness(p, WIDTH, WIDTH - x, y);
    o.shadows = false;
    int open = brightness(draw(&s, &o), WIDTH, x, y);
    if (!(shadow < open - 80 && abs(beside - open) < 30 && abs(other - open) < 30))
        fail_msg("in the shadow %d, beside it %d, opposite %d, without shadows %d of 765", shadow, beside, other, open);
}

TEST(a_box_shades_the_box_below_it)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_BOX, 4, 0.2, 4, 0, 0, 0);
    add(&s, VIEW_BOX, 0.8, 0.1, 0.8, 0, 1.0, 0);        /* 0.9 m above the lower one's top */
    RenderOptions o = from_above(8);
    double pixels = HEIGHT / 2.0 / tan(0.4) / 7.9;
    int x = (int)(WIDTH / 2 - 0.9 * pixels), y = HEIGHT / 2;
    const void *p = draw(&s, &o);
    int shadow = brightness(p, WIDTH, x, y), opposite = brightness(p, WIDTH, WIDTH - x, y);
    if (!(shadow < opposite - 80))
        fail_msg("in the shadow %d, opposite %d of 765", shadow, opposite);
}

TEST(a_stronger_lamp_is_brighter)
{
    Scene s;
    ball_on_plane(&s);
    RenderOptions o = options();
    o.sky = 2;
    o.lamp_count = 1;
    o.lamps[0] = (RenderLamp){.at = {0, 0, 3}, .colour = {1, 1, 1}};
    int before = -1;
    for (int watts = 0; watts <= 100; watts += 25) {
        o.lamps[0].power = (float)watts;
        int now = brightness(draw(&s, &o), WIDTH, WIDTH / 2, HEIGHT / 2);
        if (!(now > before))
            fail_msg("%d W gives %d, less gave %d", watts, now, before);
        before = now;
    }
}

/* ---- sameness ---------------------------------------------------------- */

TEST(the_same_view_gives_the_same_bytes)
{
    Scene s, other;
    mixed(&s);
    ball_on_plane(&other);
    RenderOptions o = options();
    o.overlay = OVERLAY_DIG | OVERLAY_TIME;
    size_t size = 3 * WIDTH * HEIGHT;
    unsigned char *first = copy_of(draw(&s, &o), size);
    RenderOptions between = options();
    between.width = 64;
    between.samples = 0;
    draw(&other, &between);
    int different = memcmp(first, draw(&s, &o), size);
    free(first);
    CHECK(different == 0);
}

static void compare_backends(Renderer *a, Renderer *b, RenderLayer layer)
{
    Scene s;
    mixed(&s);
    RenderOptions o = options();
    o.layer = layer;
    o.camera = render_camera_for(&s.view, 0.8, (real)WIDTH / HEIGHT);
    size_t size = (layer == RENDER_COLOUR || layer == RENDER_NORMAL ? 3 : 4) * (size_t)WIDTH * HEIGHT;
    unsigned char *first = copy_of(draw_with(a, &s, &o), size);
    const unsigned char *second = draw_with(b, &s, &o);
    size_t different = 0;
    for (size_t i = 0; i < size; i++)
        different += first[i] != second[i];
    free(first);
    if (different)
        fail_msg("layer %d: %zu of %zu bytes differ", (int)layer, different, size);
}

TEST(osmesa_and_egl_agree_byte_for_byte)
{
    char why[300] = "";
    Renderer *osmesa = NULL, *egl = NULL;
    if (render_open("osmesa", &osmesa, why, sizeof why) != DIG_OK || render_open("egl", &egl, why, sizeof why) != DIG_OK) {
        printf("skipped: %s\n", why);
        render_close(osmesa);
        return;
    }
    if (!strstr(render_describe(egl), "llvmpipe") || !strstr(render_describe(osmesa), "llvmpipe")) {
        printf("skipped: not the same device: %s; %s\n", render_describe(osmesa), render_describe(egl));
    } else {
        for (int layer = RENDER_COLOUR; layer <= RENDER_NORMAL; layer++)
            compare_backends(osmesa, egl, (RenderLayer)layer);
    }
    render_close(osmesa);
    render_close(egl);
}

/* Turns everything by 120 degrees about (1, 1, 1): x to y to z to x. */
static void cycle(float v[3])
{
    float x = v[0], y = v[1], z = v[2];
    v[0] = z;
    v[1] = x;
    v[2] = y;
}

static void cycle_real(real v[3])
{
    real x = v[0], y = v[1], z = v[2];
    v[0] = z;
    v[1] = x;
    v[2] = y;
}

static void cycle_scene(Scene *s, RenderOptions *o)
{
    for (int i = 0; i < s->view.item_count; i++) {
        cycle(s->items[i].p);
        for (int k = 0; k < 4; k++)
            s->items[i].q[k] = 0.5f;    /* all were unturned */
    }
    cycle(s->view.up);
    cycle(o->sun);
    cycle_real(o->camera.at);
    cycle_real(o->camera.look_at);
    cycle_real(o->camera.up);
}

TEST(the_picture_does_not_depend_on_which_way_is_up)
{
    Scene s;
    mixed(&s);
    RenderOptions o = options();
    o.camera = render_camera_for(&s.view, 0.8, (real)WIDTH / HEIGHT);
    o.sun[0] = -0.5f;
    o.sun[1] = 1;
    o.sun[2] = 0.3f;
    unsigned char *upright = copy_of(draw(&s, &o), 3 * WIDTH * HEIGHT);
    o.layer = RENDER_ID;
    uint32_t *ids = (uint32_t *)copy_of(draw(&s, &o), 4 * WIDTH * HEIGHT);
    cycle_scene(&s, &o);
    const uint32_t *turned_ids = draw(&s, &o);
    int different = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        different += turned_ids[i] != ids[i];
    o.layer = RENDER_COLOUR;
    const unsigned char *turned = draw(&s, &o);
    long off = 0;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        off += abs(turned[i] - upright[i]);
    free(ids);
    free(upright);
    if (different > 40)     /* rounding moves a few edge pixels */
        fail_msg("%d of %d pixels show another body", different, WIDTH * HEIGHT);
    CHECK_NEAR((double)off / (3 * WIDTH * HEIGHT), 0, 1);       /* the light maps' texels lie otherwise */
}

TEST(a_thousand_times_larger_looks_the_same)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_BOX, 1, 0.5, 0.75, 0, 0, 0);
    add(&s, VIEW_SPHERE, 0.3, 0, 0, 0.9, 0.1, 0.2);
    RenderOptions o = options();
    o.camera = render_camera_for(&s.view, 0.8, (real)WIDTH / HEIGHT);
    size_t size = 3 * WIDTH * HEIGHT;
    unsigned char *small = copy_of(draw(&s, &o), size);
    for (int i = 0; i < s.view.item_count; i++)
        for (int k = 0; k < 3; k++) {
            s.items[i].p[k] *= 1024;
            s.meshes[i].size[k] *= 1024;
        }
    o.camera = render_camera_for(&s.view, 0.8, (real)WIDTH / HEIGHT);
    const unsigned char *large = draw(&s, &o);
    long off = 0;
    for (size_t i = 0; i < size; i++)
        off += abs(large[i] - small[i]);
    free(small);
    CHECK_NEAR((double)off / (double)size, 0, 0.2);
}

/* ---- camera ------------------------------------------------------------ */

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Each end of each item's diameter along x, y and z must fall inside the picture. */
static void check_all_seen(const Scene *s, real aspect)
{
    RenderCamera c = render_camera_for(&s->view, 0.8, aspect);
    double f[3], r[3], u[3];
    for (int k = 0; k < 3; k++)
        f[k] = c.look_at[k] - c.at[k];
    double length = sqrt(dot(f, f));
    for (int k = 0; k < 3; k++)
        f[k] /= length;
    cross(f, c.up, r);
    length = sqrt(dot(r, r));
    for (int k = 0; k < 3; k++)
        r[k] /= length;
    cross(r, f, u);
    for (int i = 0; i < s->view.item_count; i++) {
        if (s->meshes[i].form == VIEW_PLANE)
            continue;
        for (int end = 0; end < 6; end++) {
            double d[3], half = (double)s->meshes[i].size[end / 2] * (s->meshes[i].form == VIEW_BOX ? 0.5 : 1);
            for (int k = 0; k < 3; k++)
                d[k] = (double)s->items[i].p[k] + s->view.origin[k] + (k == end / 2 ? (end % 2 ? half : -half) : 0) - c.at[k];
            double depth = dot(d, f);
            if (!(depth > 0 && fabs(dot(d, u)) < depth * tan(0.4) && fabs(dot(d, r)) < depth * tan(0.4) * aspect))
                fail_msg("item %d, end %d is outside the picture", i, end);
        }
    }
}

TEST(the_usual_camera_sees_everything)
{
    Scene s;
    mixed(&s);
    check_all_seen(&s, 1.78);
    check_all_seen(&s, 0.5);
    add(&s, VIEW_BOX, 0.3, 9, 0.3, 5, 4.5, -2);         /* tall */
    check_all_seen(&s, 1.78);
    s.view.origin[0] = 1e6;
    check_all_seen(&s, 1.78);
    s.view.up[1] = 0;
    s.view.up[0] = -1;
    check_all_seen(&s, 1.78);
}

TEST(an_empty_view_is_only_sky)
{
    Scene s;
    scene_open(&s);
    RenderOptions o = options();
    o.camera = render_camera_for(&s.view, 0.8, (real)WIDTH / HEIGHT);
    for (int y = 0; y < HEIGHT; y += 8)
        CHECK_INT(id_at(&s, o, WIDTH / 2, y), 0);
    CHECK(brightness(draw(&s, &o), WIDTH, WIDTH / 2, 2) > 300);
}

/* ---- odd input --------------------------------------------------------- */

TEST(items_that_make_no_sense_are_left_out)
{
    Scene s;
    ball_on_plane(&s);
    add(&s, VIEW_BOX, 1, 1, 1, 0, 0, 3)->p[0] = NAN;
    add(&s, VIEW_BOX, 1, 1, 1, 0, 0, 3)->mesh = 99;
    add(&s, VIEW_BOX, 1, 1, 1, 0, 0, 3)->mesh = -1;
    ViewItem *flat = add(&s, VIEW_BOX, 1, 1, 1, 0, 0, 3);
    flat->q[3] = 0;
    CHECK_INT(id_at(&s, options(), WIDTH / 2, HEIGHT / 2), 2);
}

static void check_refused(RenderOptions o, const char *word)
{
    Scene s;
    ball_on_plane(&s);
    const void *pixels = &s;
    CHECK_INT(render_draw(shared, &s.view, &o, &pixels), DIG_E_ARG);
    CHECK(pixels == NULL);
    if (!strstr(render_error(shared), word))
        fail_msg("\"%s\" does not mention %s", render_error(shared), word);
}

TEST(bad_options_are_refused_with_a_sentence)
{
    static const int sizes[] = {0, -1, 16385};
    for (int i = 0; i < 3; i++) {
        RenderOptions o = options();
        char number[16];
        snprintf(number, sizeof number, "%d", sizes[i]);
        o.width = sizes[i];
        check_refused(o, number);
        o = options();
        o.height = sizes[i];
        check_refused(o, number);
    }
    RenderOptions o = options();
    o.samples = 3;
    check_refused(o, "samples = 3");
    o = options();
    o.camera.fov = NAN;
    check_refused(o, "fov");
    o = options();
    o.camera.at[1] = INFINITY;
    check_refused(o, "finite");
    o = options();
    o.camera.look_at[2] = o.camera.at[2];
    check_refused(o, "same point");
    o = options();
    o.lamp_count = 5;
    check_refused(o, "lamp_count = 5");
    o = options();
    o.sky = 4;
    check_refused(o, "sky = 4");
}

TEST(an_unknown_backend_is_refused_with_a_sentence)
{
    Renderer *r = NULL;
    char why[200] = "";
    CHECK(render_open("glide", &r, why, sizeof why) != DIG_OK);
    CHECK(r == NULL);
    CHECK(strstr(why, "glide") != NULL);
}

/* ---- own meshes --------------------------------------------------------- */

TEST(a_closed_mesh_and_both_sides_of_an_open_one_are_seen)
{
    static float corners[] = {-1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, -1};
    static uint32_t closed[] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0}, open[] = {0, 2, 1};
    Scene s;
    scene_open(&s);
    add(&s, VIEW_MESH, 0, 0, 0, 0, 0, 0);
    s.meshes[0] = (ViewMesh){.form = VIEW_MESH, .vertex_count = 4, .index_count = 12, .vertices = corners, .indices = closed};
    CHECK_INT(id_at(&s, options(), WIDTH / 2, HEIGHT / 2), 1);
    CHECK_NEAR(depth_at(&s, options(), WIDTH / 2, HEIGHT / 2), 6, 1e-3);
    s.meshes[0].indices = open;         /* one triangle, seen from behind */
    s.meshes[0].index_count = 3;
    CHECK_INT(id_at(&s, options(), WIDTH / 2, HEIGHT / 2), 1);
    static uint32_t wrong[] = {0, 1, 7};
    s.meshes[0].indices = wrong;        /* no such vertex: not drawn */
    CHECK_INT(id_at(&s, options(), WIDTH / 2, HEIGHT / 2), 0);
}

/* ---- overlays ---------------------------------------------------------- */

TEST(digs_have_colours_of_their_own_and_their_links_are_drawn)
{
    Scene s;
    scene_open(&s);
    add(&s, VIEW_SPHERE, 0.5, 0, 0, -1, 0, 0);
    add(&s, VIEW_SPHERE, 0.5, 0, 0, 1, 0, 0);
    ViewEdge edge = {.a = {-1, 0, 0}, .b = {1, 0, 0}, .dig = 1};
    RenderOptions o = options();
    size_t size = 3 * WIDTH * HEIGHT;
    unsigned char *plain = copy_of(draw(&s, &o), size);
    s.view.edges = &edge;
    s.view.edge_count = 1;
    CHECK(memcmp(plain, draw(&s, &o), size) == 0);      /* not asked for: nothing */
    o.overlay = OVERLAY_DIG;
    const unsigned char *p = draw(&s, &o);
    int middle = 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2), changed = 0;
    for (int k = -3 * WIDTH; k <= 3 * WIDTH; k += 3 * WIDTH)
        changed += abs(p[middle + k] - plain[middle + k]) > 20;
    free(plain);
    CHECK(changed > 0);                                 /* the link, half way between the balls */
    int left = 3 * (HEIGHT * 2 / 5 * WIDTH + WIDTH / 2 - 18), right = left + 3 * 36, apart = 0;
    for (int k = 0; k < 3; k++)
        apart += abs(p[left + k] - p[right + k]);
    if (!(apart > 60))
        fail_msg("colours %d %d %d and %d %d %d", p[left], p[left + 1], p[left + 2], p[right], p[right + 1], p[right + 2]);
}

/* ---- what is seen through ---- */

/* A dull box before a larger one, against the sky. */
static void box_before_box(Scene *s, float clear)
{
    scene_open(s);
    ViewItem *back = add(s, VIEW_BOX, 3, 3, 0.2, 0, 0, -1), *front = add(s, VIEW_BOX, 1, 1, 0.2, 0, 0, 1);
    back->colour[1] = back->colour[2] = front->colour[0] = front->colour[1] = 0.1f;
    front->roughness = 1;           /* nothing glances off */
    front->clear = clear;
}

static void middle(const Scene *s, RenderOptions o, int out[3])
{
    const unsigned char *p = (const unsigned char *)draw(s, &o) + 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    for (int k = 0; k < 3; k++)
        out[k] = p[k];
}

TEST(a_clear_body_mixes_with_what_lies_behind_as_its_opacity_says)
{
    Scene s;
    RenderOptions o = options();
    int front[3], behind[3], both[3];
    o.shadows = false;
    box_before_box(&s, 0);
    middle(&s, o, front);
    box_before_box(&s, 1);
    middle(&s, o, behind);
    CHECK(behind[0] - front[0] > 40 && front[2] - behind[2] > 40);
    for (int i = 1; i <= 3; i++) {
        box_before_box(&s, 0.25f * (float)i);
        for (o.samples = 0; o.samples <= 4; o.samples += 4) {
            middle(&s, o, both);
            for (int k = 0; k < 3; k++)
                CHECK_NEAR(both[k], 0.25 * i * behind[k] + (1 - 0.25 * i) * front[k], 4);
        }
    }
    CHECK_INT(id_at(&s, options(), WIDTH / 2, HEIGHT / 2), 2);      /* data layers show it as any other */
}

TEST(clear_bodies_are_drawn_from_far_to_near_whatever_their_order)
{
    Scene s;
    RenderOptions o = options();
    box_before_box(&s, 0.5f);
    s.items[0].clear = 0.5f;
    s.items[0].roughness = 1;
    int one[3], other[3];
    middle(&s, o, one);
    ViewItem first = s.items[0];
    s.items[0] = s.items[1];
    s.items[1] = first;
    middle(&s, o, other);
    CHECK(one[2] > one[0]);         /* the near one counts most */
    for (int k = 0; k < 3; k++)
        CHECK_INT(one[k], other[k]);
}

TEST(a_clear_body_throws_no_shadow_and_a_nonsensical_one_is_solid)
{
    Scene s;
    RenderOptions o = options();
    int light[3], dark[3], through[3];
    scene_open(&s);
    add(&s, VIEW_PLANE, 0, 0, 0, 0, -1, 0);
    add(&s, VIEW_BOX, 2, 0.2, 2, 0, 1.5, 0);        /* above what the picture shows in its middle */
    o.sun[1] = 1;
    o.camera.at[1] = 0.5;
    o.camera.look_at[1] = -1;
    middle(&s, o, dark);
    s.items[1].clear = 0.5f;
    middle(&s, o, through);
    o.shadows = false;
    middle(&s, o, light);
    CHECK(light[1] - dark[1] > 30 && abs(light[1] - through[1]) <= 4);
    for (int i = 0; i < 2; i++) {
        box_before_box(&s, i ? NAN : -1);
        middle(&s, options(), through);
        box_before_box(&s, 0);
        middle(&s, options(), light);
        CHECK(memcmp(through, light, sizeof light) == 0);
    }
}

TEST(names_and_time_are_written)
{
    Scene s;
    ball_on_plane(&s);
    ViewLabel label = {.p = {0, 1.2f, 0}, .text = "B\xc3\xa4lle \xff \xe2\x82"};       /* also malformed UTF-8 */
    s.view.labels = &label;
    s.view.label_count = 1;
    RenderOptions o = options();
    o.width = 320;
    o.height = 180;
    size_t size = 3 * 320 * 180;
    unsigned char *plain = copy_of(draw(&s, &o), size);
    o.overlay = OVERLAY_NAMES | OVERLAY_TIME;
    const unsigned char *p = draw(&s, &o);
    size_t changed = 0;
    for (size_t i = 0; i < size; i++)
        changed += p[i] != plain[i];
    free(plain);
    if (changed == 0)
        printf("skipped: no font file\n");
    else if (changed < 2000)
        fail_msg("only %zu bytes changed", changed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(the_id_layer_names_the_body_that_is_seen),
        unit_test(depth_of_a_ball_and_of_a_plane_is_the_closed_form),
        unit_test(depth_of_a_turned_box_is_the_closed_form),
        unit_test(far_from_the_origin_nothing_changes),
        unit_test(the_normal_layer_points_at_the_eye_from_a_face_turned_to_it),
        unit_test(the_side_away_from_the_sun_is_darker),
        unit_test(a_box_throws_its_shadow_where_the_sun_says),
        unit_test(a_box_shades_the_box_below_it),
        unit_test(a_stronger_lamp_is_brighter),
        unit_test(the_same_view_gives_the_same_bytes),
        unit_test(osmesa_and_egl_agree_byte_for_byte),
        unit_test(the_picture_does_not_depend_on_which_way_is_up),
        unit_test(a_thousand_times_larger_looks_the_same),
        unit_test(the_usual_camera_sees_everything),
        unit_test(an_empty_view_is_only_sky),
        unit_test(items_that_make_no_sense_are_left_out),
        unit_test(bad_options_are_refused_with_a_sentence),
        unit_test(an_unknown_backend_is_refused_with_a_sentence),
        unit_test(a_closed_mesh_and_both_sides_of_an_open_one_are_seen),
        unit_test(digs_have_colours_of_their_own_and_their_links_are_drawn),
        unit_test(a_clear_body_mixes_with_what_lies_behind_as_its_opacity_says),
        unit_test(clear_bodies_are_drawn_from_far_to_near_whatever_their_order),
        unit_test(a_clear_body_throws_no_shadow_and_a_nonsensical_one_is_solid),
        unit_test(names_and_time_are_written),
    };
    return cmocka_run_group_tests(tests, open_shared, close_shared);
}
