/* tests/unit/test_overlay.c - what overlays draw and where: names, contacts, forces, joints, and the legends of stress and temperature.
 *
 * Each picture is compared with the same one without overlays; what differs has to lie where the overlay belongs.
 */
#include "picture_fixture.h"
#include "render/render.h"
#include "render/batch.h"
#include "render/heat.h"
#include "render/overlay.h"

enum { WIDTH = 640, HEIGHT = 360, BYTES = 3 * WIDTH * HEIGHT };

static const double EYE = 6, FOV = 0.8, SIZE = 11;      /* m before the origin; rad; px of the letters: HEIGHT / 45, at least 11 */

/* ---- a ball at the origin, seen from z = EYE ------------------------------- */

static void ball(Scene *s)
{
    scene_open(s);
    add(s, VIEW_SPHERE, 0.3, 0, 0, 0, 0, 0);
}

static bool fonts;

static int open_fonts(void **state)
{
    Font font = {0};
    font_make(&font, (int)SIZE);
    fonts = !font.missing;
    font_close(&font);
    if (!fonts)
        printf("no font file: words are not checked\n");
    return open_shared(state);
}

static void shoot(const Scene *s, unsigned overlay, unsigned char *out)
{
    RenderOptions o = render_defaults();
    o.width = WIDTH;
    o.height = HEIGHT;
    o.overlay = overlay;
    o.camera = (RenderCamera){{0, 0, EYE}, {0, 0, 0}, {0, 1, 0}, FOV};
    memcpy(out, draw(s, &o), BYTES);
}

/* Where a point at (x, y, z) m lies in the picture, px from the left and from above. */
static double px(double x, double z) { return WIDTH / 2.0 + x / (EYE - z) * HEIGHT / (2 * tan(FOV / 2)); }
static double py(double y, double z) { return HEIGHT / 2.0 - y / (EYE - z) * HEIGHT / (2 * tan(FOV / 2)); }

/* ---- what differs ---------------------------------------------------------- */

typedef struct Box { int left, top, right, bottom, count; } Box;       /* of changed pixels: [left, right) x [top, bottom) */

/* Changed pixels among columns [x0, x1), rows [y0, y1). */
static Box changes(const unsigned char *a, const unsigned char *b, double x0, double y0, double x1, double y1)
{
    Box c = {WIDTH, HEIGHT, 0, 0, 0};
    for (int y = (int)y0; y < (int)y1; y++)
        for (int x = (int)x0; x < (int)x1; x++)
            if (memcmp(a + 3 * (y * WIDTH + x), b + 3 * (y * WIDTH + x), 3) != 0) {
                c.left = x < c.left ? x : c.left;
                c.top = y < c.top ? y : c.top;
                c.right = x >= c.right ? x + 1 : c.right;
                c.bottom = y >= c.bottom ? y + 1 : c.bottom;
                c.count++;
            }
    return c;
}

static Box all_changes(const unsigned char *a, const unsigned char *b) { return changes(a, b, 0, 0, WIDTH, HEIGHT); }

static unsigned char plain[BYTES], shown[BYTES], other[BYTES];

/* A colour of 0..1 as overlays show it, in levels, at pixel (x, y). */
static void check_colour(const unsigned char *p, double x, double y, const float linear[3])
{
    for (int k = 0; k < 3; k++) {
        double want = 255 * sqrt(fmin((double)linear[k], 1));
        int got = p[3 * ((int)y * WIDTH + (int)x) + k];
        if (!(fabs(got - want) <= 8))
            fail_msg("pixel (%.0f, %.0f), channel %d: %d, want %.0f +- 8", x, y, k, got, want);
    }
}

/* ---- names ----------------------------------------------------------------- */

TEST(a_name_stands_above_its_place)
{
    static const double places[3][3] = {{0, 0, 0}, {1.2, -0.6, 0}, {-1.5, 0.5, -2}};
    Scene s;
    ball(&s);
    shoot(&s, 0, plain);
    if (!fonts)
        return;
    for (int i = 0; i < 3; i++) {
        ViewLabel label = {.p = {(float)places[i][0], (float)places[i][1], (float)places[i][2]}, .text = "crate"};
        s.view.labels = &label;
        s.view.label_count = 1;
        double x = px(places[i][0], places[i][2]), y = py(places[i][1], places[i][2]);
        shoot(&s, 0, shown);
        CHECK_INT(all_changes(plain, shown).count, 0);          /* not asked for: nothing */
        shoot(&s, OVERLAY_NAMES, shown);
        Box c = all_changes(plain, shown);
        CHECK_NEAR(0.5 * (c.left + c.right), x, 2);
        CHECK_NEAR(c.bottom, y, 4);                             /* a dot at the place */
        CHECK(c.right - c.left > 3 * SIZE);
        /* the word lies on a plate round its line, 1.3 letters above the place */
        Box word = changes(plain, shown, 0, 0, WIDTH, y - 1.3 * SIZE + 1);
        CHECK(word.count > 200 && word.top < y - 1.9 * SIZE && word.top > y - 3 * SIZE);
    }
}

TEST(a_longer_name_is_wider_and_what_is_not_seen_has_none)
{
    Scene s;
    ball(&s);
    ViewLabel label = {.text = "ii"};
    s.view.labels = &label;
    s.view.label_count = 1;
    shoot(&s, 0, plain);
    if (!fonts)
        return;
    shoot(&s, OVERLAY_NAMES, shown);
    Box few = all_changes(plain, shown);
    strcpy(label.text, "wwwwwwww");
    shoot(&s, OVERLAY_NAMES, shown);
    Box many = all_changes(plain, shown);
    CHECK(many.right - many.left > few.right - few.left + 4 * SIZE);
    label.p[2] = (float)EYE + 1;        /* behind the eye */
    shoot(&s, OVERLAY_NAMES, shown);
    CHECK_INT(all_changes(plain, shown).count, 0);
}

TEST(the_nearer_of_two_names_keeps_its_place)
{
    Scene s;
    ball(&s);
    ViewLabel labels[2] = {{.p = {0, 0, -3}, .text = "i"}, {.p = {0, 0, 1}, .text = "wwwwwwwwww"}}, turned[2] = {labels[1], labels[0]};
    shoot(&s, 0, plain);
    if (!fonts)
        return;
    s.view.labels = labels;
    s.view.label_count = 2;
    shoot(&s, OVERLAY_NAMES, shown);
    s.view.labels = turned;
    shoot(&s, OVERLAY_NAMES, other);
    CHECK(memcmp(shown, other, BYTES) == 0);        /* whatever their order */
    double y = HEIGHT / 2.0;
    Box low = changes(plain, shown, 0, y - 2 * SIZE, WIDTH, y - 1.3 * SIZE);
    Box high = changes(plain, shown, 0, y - 3.4 * SIZE, WIDTH, y - 2.7 * SIZE);
    CHECK(low.right - low.left > 6 * SIZE);
    CHECK(high.count > 0 && high.right - high.left < 3 * SIZE);
    CHECK_NEAR(0.5 * (high.left + high.right), WIDTH / 2.0, 2);
}

/* ---- contacts, forces, joints ---------------------------------------------- */

TEST(a_contact_is_marked_at_its_point_along_its_normal)
{
    Scene s;
    ball(&s);
    ViewContact contact = {.p = {0.5f, -0.4f, 0}, .n = {0, 1, 0}};
    s.view.contacts = &contact;
    s.view.contact_count = 1;
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_CONTACTS, shown);
    Box c = all_changes(plain, shown);
    CHECK(c.count > 10 && c.right - c.left < 10);
    CHECK_NEAR(0.5 * (c.left + c.right), px(0.5, 0), 1.5);
    CHECK_NEAR(c.bottom, py(-0.4, 0) + 2.5, 2.5);
    contact.n[1] = -1;
    shoot(&s, OVERLAY_CONTACTS, shown);
    CHECK_NEAR(all_changes(plain, shown).top, py(-0.4, 0) - 2.5, 2.5);
}

TEST(forces_point_where_they_push_and_the_largest_is_told)
{
    Scene s;
    ball(&s);
    ViewContact contacts[2] = {{.p = {-1, -0.5f, 0}, .force = {0, 40, 0}}, {.p = {1, -0.5f, 0}, .force = {0, 10, 0}}};
    s.view.contacts = contacts;
    s.view.contact_count = 2;
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_FORCES, shown);
    double y = py(-0.5, 0);
    const double near = 20, low = HEIGHT - 40;
    Box large = changes(plain, shown, px(-1, 0) - near, 0, px(-1, 0) + near, low);
    Box small = changes(plain, shown, px(1, 0) - near, 0, px(1, 0) + near, low);
    CHECK_NEAR(large.bottom, y + 2, 3);
    CHECK_NEAR(small.bottom, y + 2, 3);
    CHECK_NEAR((large.bottom - large.top) / (double)(small.bottom - small.top), 2, 0.35);       /* as the roots of the forces */
    const unsigned char *p = shown + 3 * ((int)(y - 8) * WIDTH + (int)px(-1, 0));                /* in its head */
    CHECK(p[0] > 180 && p[1] < 120 && p[2] < 110);                                              /* red */
    Box words = changes(plain, shown, WIDTH / 2, HEIGHT - 3 * SIZE, WIDTH, HEIGHT);
    if (fonts)
        CHECK(words.count > 400 && words.right > WIDTH - 2 * SIZE);
    contacts[0].force[1] = -40;
    shoot(&s, OVERLAY_FORCES, shown);
    CHECK_NEAR(changes(plain, shown, px(-1, 0) - near, 0, px(-1, 0) + near, low).top, y - 2, 3);
}

TEST(arms_of_joints_are_drawn_from_end_to_end)
{
    Scene s;
    ball(&s);
    ViewLine line = {.a = {-1, 0.6f, 0}, .b = {1, 0.6f, 0}, .colour = {0.8f, 0.1f, 0.1f}};
    s.view.lines = &line;
    s.view.line_count = 1;
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_JOINTS, shown);
    Box c = all_changes(plain, shown);
    CHECK_NEAR(c.left, px(-1, 0), 6);
    CHECK_NEAR(c.right, px(1, 0), 6);
    CHECK_NEAR(0.5 * (c.top + c.bottom), py(0.6, 0), 2);
}

/* ---- legends --------------------------------------------------------------- */

TEST(stress_has_a_legend_from_none_to_what_breaks)
{
    Scene s;
    ball(&s);
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_STRESS, shown);
    double right = WIDTH - 5 * SIZE, left = right - 9 * SIZE, y = HEIGHT - 1.2 * SIZE;
    for (int step = 0; step < 40; step += 3) {      /* of forty: no plate or rim over any of them */
        float colour[3];
        stress_colour((float)step / 39, colour);
        check_colour(shown, left + (right - left) * (step + 0.5) / 40, y, colour);
    }
    if (!fonts)
        return;
    Box zero = changes(plain, shown, left - 8 * SIZE, y - SIZE, left - 3, y + SIZE), full = changes(plain, shown, right + 4, y - SIZE, WIDTH, y + SIZE);
    CHECK(zero.right - zero.left > 4 * SIZE && full.right - full.left > 2 * SIZE && full.right < WIDTH);
    CHECK_INT(changes(plain, shown, 0, 0, WIDTH, y - 2 * SIZE).count, 0);       /* the ball bears nothing */
}

TEST(temperatures_have_a_scale_when_something_has_one)
{
    Scene s;
    ball(&s);
    double x = WIDTH - 2 * SIZE, top = 0.25 * HEIGHT, bottom = 0.75 * HEIGHT;
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_TEMPERATURE, shown);
    CHECK_INT(all_changes(plain, shown).count, 0);
    s.items[0].temperature = 420;           /* of a scale from 400 to 450 K */
    shoot(&s, 0, plain);
    shoot(&s, OVERLAY_TEMPERATURE, shown);
    for (int band = 0; band < 80; band += 7) {
        float colour[3];
        heat_colour((band + 0.5) / 80, colour);
        check_colour(shown, x, bottom + (top - bottom) * (band + 0.5) / 80, colour);
    }
    CHECK(changes(plain, shown, WIDTH / 2.0 - 20, HEIGHT / 2.0 - 20, WIDTH / 2.0 + 20, HEIGHT / 2.0 + 20).count > 1000);     /* the ball */
    if (!fonts)
        return;
    CHECK(changes(plain, shown, x - 4 * SIZE, top - 2 * SIZE, WIDTH, top - 3).count > 60);
    CHECK(changes(plain, shown, x - 4 * SIZE, bottom + 3, WIDTH, bottom + 2 * SIZE).count > 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        unit_test(a_name_stands_above_its_place),
        unit_test(a_longer_name_is_wider_and_what_is_not_seen_has_none),
        unit_test(the_nearer_of_two_names_keeps_its_place),
        unit_test(a_contact_is_marked_at_its_point_along_its_normal),
        unit_test(forces_point_where_they_push_and_the_largest_is_told),
        unit_test(arms_of_joints_are_drawn_from_end_to_end),
        unit_test(stress_has_a_legend_from_none_to_what_breaks),
        unit_test(temperatures_have_a_scale_when_something_has_one),
    };
    return cmocka_run_group_tests(tests, open_fonts, close_shared);
}
