/* tests/unit/picture_fixture.h - views built by hand, drawn by one renderer for all tests of a file: compiling shaders takes most of the time.
 *
 * Include it first: it asks for setenv.
 */
#ifndef DIG_PICTURE_FIXTURE_H
#define DIG_PICTURE_FIXTURE_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L     /* setenv */
#endif

#include <stdlib.h>

#include "check.h"
#include "render/render.h"

enum { ITEMS = 16 };

typedef struct Scene {
    View     view;
    ViewMesh meshes[ITEMS];
    ViewItem items[ITEMS];
} Scene;

static void scene_open(Scene *s)
{
    memset(s, 0, sizeof *s);
    s->view.meshes = s->meshes;
    s->view.items = s->items;
    s->view.up[1] = 1;
}

/* The numbers of a form are those of ViewMesh; its centre lies at x, y, z. */
static ViewItem *add(Scene *s, ViewForm form, double a, double b, double c, double x, double y, double z)
{
    int n = s->view.item_count++;
    s->view.mesh_count++;
    s->meshes[n] = (ViewMesh){.form = form, .size = {(float)a, (float)b, (float)c}};
    s->items[n] = (ViewItem){.body = (uint32_t)n + 1, .mesh = n, .p = {(float)x, (float)y, (float)z}, .q = {0, 0, 0, 1},
                             .colour = {0.5f, 0.5f, 0.5f}, .roughness = 0.6f, .stress = -1};
    s->items[n].fixed = form == VIEW_PLANE;
    s->items[n].dig = s->items[n].fixed ? 0 : (uint32_t)n + 1;
    return &s->items[n];
}

static Renderer *shared;

static int open_shared(void **state)
{
    (void)state;
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    setenv("LP_NUM_THREADS", "0", 1);
    char why[300] = "";
    if (render_open(NULL, &shared, why, sizeof why) == DIG_OK)
        return 0;
    fprintf(stderr, "no renderer: %s\n", why);
    return -1;
}

static int close_shared(void **state)
{
    (void)state;
    render_close(shared);
    return 0;
}

static const void *draw_with(Renderer *r, const Scene *s, const RenderOptions *o)
{
    const void *pixels = NULL;
    if (render_draw(r, &s->view, o, &pixels) != DIG_OK)
        fail_msg("render_draw: %s", render_error(r));
    return pixels;
}

static const void *draw(const Scene *s, const RenderOptions *o) { return draw_with(shared, s, o); }

#endif
