/* lua/bind_film.c - pictures and film: a view of the world, drawn and written as PNG or piped to ffmpeg.
 *
 * What a camera is and when a frame is due is decided in lua/digbox/film.lua; here a view becomes a file. A frame between two
 * steps is drawn from a view blended between them, so that frame times never touch the physics.
 */

#define _XOPEN_SOURCE 700       /* posix_spawn, waitpid */

#include "bind.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "manifest.h"
#include "render/render.h"
#include "state.h"

#ifdef DIGBOX_NO_RENDER

static int no_renderer(lua_State *L)
{
    return bind_error(L, "this build of digbox draws no pictures (it was made with RENDER=0)");
}

void bind_film_open(lua_State *L, int core)
{
    static const char *const names[] = {"view", "blend", "view_camera", "picture", "pipe", "compare_pictures", "png_text", "png_whole", "pixels", "renderer",
                                        "picture_need"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        lua_pushcfunction(L, no_renderer);
        lua_setfield(L, core, names[i]);
    }
    lua_pushboolean(L, 0);
    lua_setfield(L, core, "can_render");
}

int bind_push_view(lua_State *L, View *v)
{
    dig_view_free(v);
    return no_renderer(L);
}

#else

#define VIEW     "view"
#define PIPE     "pipe"
#define RENDERER "renderer"

/* ---- views --------------------------------------------------------------------- */

typedef struct ViewRef {
    View     *v;
    real      time;     /* s, as taken; blending sets v->time         */
    ViewPose *poses;    /* as taken; NULL: not asked for yet          */
} ViewRef;

/* core.view(world) -> view */
static int view_take(lua_State *L)
{
    WorldRef *ref = bind_check_world(L, 1);
    ViewRef *view = lua_newuserdatauv(L, sizeof *view, 0);
    *view = (ViewRef){NULL, 0, NULL};
    luaL_setmetatable(L, VIEW);
    dig_status s = dig_view_take(ref->w, &view->v);
    if (s != DIG_OK)
        return bind_fail_text(L, s, "no memory for a picture of the world");
    view->time = view->v->time;
    bind_push_state(L, 1);
    lua_getfield(L, -1, "seed");
    view->v->seed = (uint64_t)lua_tointeger(L, -1);
    lua_pop(L, 2);
    return 1;
}

int bind_push_view(lua_State *L, View *v)
{
    ViewRef *view = lua_newuserdatauv(L, sizeof *view, 1);
    *view = (ViewRef){v, v->time, NULL};
    luaL_setmetatable(L, VIEW);
    return 1;
}

static int view_gc(lua_State *L)
{
    ViewRef *view = luaL_checkudata(L, 1, VIEW);
    dig_view_free(view->v);
    free(view->poses);
    *view = (ViewRef){NULL, 0, NULL};
    return 0;
}

/* The poses of a view as taken, kept on first use. */
static const ViewPose *own_poses(lua_State *L, ViewRef *view)
{
    if (!view->poses)
        view->poses = view_poses(view->v);
    if (!view->poses)
        bind_fail_text(L, DIG_E_MEMORY, "no memory for a picture of the world");
    return view->poses;
}

/* core.blend(before, after, fraction): moves the items of `after` to where they were at that fraction of the step */
static int view_blend_to(lua_State *L)
{
    ViewRef *a = luaL_checkudata(L, 1, VIEW), *b = luaL_checkudata(L, 2, VIEW);
    real f = luaL_checknumber(L, 3);
    const ViewPose *from = own_poses(L, a), *to = own_poses(L, b);
    view_blend(a->v, from, b->v, to, f);
    b->v->time = a->time + f * (b->time - a->time);
    return 0;
}

static void push_triple(lua_State *L, const real v[3])
{
    bind_push_vec3(L, (vec3){v[0], v[1], v[2]});
}

/* core.view_camera(view, fov, aspect) -> at, look_at, up of a camera that sees everything */
static int view_camera(lua_State *L)
{
    ViewRef *view = luaL_checkudata(L, 1, VIEW);
    RenderCamera c = render_camera_for(view->v, luaL_checknumber(L, 2), luaL_checknumber(L, 3));
    push_triple(L, c.at);
    push_triple(L, c.look_at);
    push_triple(L, c.up);
    return 3;
}

/* ---- options: a table of checked values made by film.lua --------------------------- */

static real number_field(lua_State *L, int table, const char *name, real otherwise)
{
    real x = lua_getfield(L, table, name) == LUA_TNUMBER ? lua_tonumber(L, -1) : otherwise;
    lua_pop(L, 1);
    return x;
}

static bool bool_field(lua_State *L, int table, const char *name, bool otherwise)
{
    bool x = lua_getfield(L, table, name) == LUA_TBOOLEAN ? lua_toboolean(L, -1) : otherwise;
    lua_pop(L, 1);
    return x;
}

static void triple_field(lua_State *L, int table, const char *name, real out[3])
{
    if (lua_getfield(L, table, name) != LUA_TNIL) {
        vec3 v = bind_vec3(L, -1, "m", "camera", name);
        out[0] = v.x;
        out[1] = v.y;
        out[2] = v.z;
    }
    lua_pop(L, 1);
}

static void read_lamps(lua_State *L, int table, RenderOptions *o)
{
    if (lua_getfield(L, table, "lamps") == LUA_TTABLE)
        for (int i = 0; i < 4 && lua_rawgeti(L, -1, i + 1) == LUA_TTABLE; i++) {
            RenderLamp *lamp = &o->lamps[o->lamp_count++];
            real colour[3] = {1, 1, 1};
            int at = lua_gettop(L);
            triple_field(L, at, "at", lamp->at);
            triple_field(L, at, "colour", colour);
            lamp->power = (float)number_field(L, at, "power", 60);
            for (int k = 0; k < 3; k++)
                lamp->colour[k] = (float)colour[k];
            lua_pop(L, 1);
        }
    lua_settop(L, table);
}

static RenderOptions read_options(lua_State *L, int table)
{
    RenderOptions o = render_defaults();
    real sun[3] = {0, 0, 0};
    luaL_checktype(L, table, LUA_TTABLE);
    lua_settop(L, table);
    o.width = (int)number_field(L, table, "width", o.width);
    o.height = (int)number_field(L, table, "height", o.height);
    o.samples = (int)number_field(L, table, "samples", o.samples);
    o.smooth = bool_field(L, table, "smooth", false);
    o.layer = (RenderLayer)(int)number_field(L, table, "layer", RENDER_COLOUR);
    o.overlay = (unsigned)number_field(L, table, "overlay", 0);
    o.sky = (int)number_field(L, table, "sky", o.sky);
    o.camera.fov = number_field(L, table, "fov", 0.7);
    triple_field(L, table, "at", o.camera.at);
    triple_field(L, table, "look_at", o.camera.look_at);
    triple_field(L, table, "up", o.camera.up);
    triple_field(L, table, "sun", sun);
    for (int k = 0; k < 3; k++)
        o.sun[k] = (float)sun[k];
    o.shadows = bool_field(L, table, "shadows", o.shadows);
    read_lamps(L, table, &o);
    if (lua_getfield(L, table, "past") == LUA_TUSERDATA)
        o.past = bind_past(L, -1);              /* stays in the table */
    lua_pop(L, 1);
    return o;
}

/* ---- the renderer: one a Lua state, opened by the first picture ---------------------- */

typedef struct RendererRef { Renderer *r; } RendererRef;

static Renderer *renderer(lua_State *L)
{
    if (lua_getfield(L, LUA_REGISTRYINDEX, "digbox.renderer") != LUA_TUSERDATA) {
        char why[256] = "";
        RendererRef *ref = lua_newuserdatauv(L, sizeof *ref, 0);
        ref->r = NULL;
        luaL_setmetatable(L, RENDERER);
        dig_status s = render_open(NULL, &ref->r, why, sizeof why);
        if (s != DIG_OK)
            bind_fail_text(L, DIG_E_FILE, "no picture can be drawn: %s", why);
        lua_pushvalue(L, -1);
        lua_setfield(L, LUA_REGISTRYINDEX, "digbox.renderer");
        lua_replace(L, -2);
    }
    Renderer *r = ((RendererRef *)lua_touserdata(L, -1))->r;
    lua_pop(L, 1);
    return r;
}

static int renderer_gc(lua_State *L)
{
    RendererRef *ref = luaL_checkudata(L, 1, RENDERER);
    if (ref->r)
        render_close(ref->r);
    ref->r = NULL;
    return 0;
}

/* core.picture_need(options) -> bytes that a process needs, about, which draws such pictures; bytes that it may have */
static int picture_need(lua_State *L)
{
    RenderOptions o = render_defaults();
    lua_settop(L, 1);
    o.width = (int)number_field(L, 1, "width", o.width);
    o.height = (int)number_field(L, 1, "height", o.height);
    o.samples = (int)number_field(L, 1, "samples", 0);
    o.overlay = (unsigned)number_field(L, 1, "overlay", 0);
    o.moments = (int)number_field(L, 1, "moments", 0);
    lua_pushinteger(L, (lua_Integer)render_need(&o));
    lua_pushinteger(L, (lua_Integer)app_room());
    return 2;
}

/* core.renderer() -> "osmesa: 4.5 (Core Profile) ..." */
static int renderer_describe(lua_State *L)
{
    lua_pushstring(L, render_describe(renderer(L)));
    return 1;
}

static const void *draw(lua_State *L, const ViewRef *view, const RenderOptions *o)
{
    Renderer *r = renderer(L);
    const void *pixels = NULL;
    dig_status s = render_draw(r, view->v, o, &pixels);
    if (s != DIG_OK)
        bind_fail_text(L, s, "%s", render_error(r));
    return pixels;
}

/* Draws a picture from a view and its options, or the mean of several in lists of as many: what moves while a shutter is open.
 * Returns the options of the first. */
static RenderOptions draw_all(lua_State *L, int views, int options, const void **pixels)
{
    int top = lua_gettop(L);
    if (!lua_istable(L, views)) {
        const ViewRef *view = luaL_checkudata(L, views, VIEW);
        lua_pushvalue(L, options);
        RenderOptions o = read_options(L, top + 1);
        *pixels = draw(L, view, &o);
        lua_settop(L, top);
        return o;
    }
    RenderOptions first = render_defaults();
    int count = (int)lua_rawlen(L, views);
    for (int i = count; i >= 1; i--) {      /* the first last: overlays show its moment */
        lua_rawgeti(L, views, i);
        const ViewRef *view = luaL_checkudata(L, -1, VIEW);
        lua_rawgeti(L, options, i);
        RenderOptions o = read_options(L, lua_gettop(L));
        if (i == 1)
            first = o;
        o.moment = count > 1 ? count - i + 1 : 0;
        o.moments = count > 1 ? count : 0;
        *pixels = draw(L, view, &o);
        lua_settop(L, top);
    }
    return first;
}

enum { TEXT_COUNT = 16 };

/* A hash of the pixels, and whether they all have one colour. */
static uint64_t hash_pixels(const void *pixels, size_t size, size_t of_one, bool *plain)
{
    const unsigned char *p = pixels;
    uint64_t h = HASH_START, word;
    size_t i = 0;
    for (; i + sizeof word <= size; i += sizeof word) {
        memcpy(&word, p + i, sizeof word);
        h = hash_u64(h, word);
    }
    *plain = size > of_one && memcmp(p, p + of_one, size - of_one) == 0;
    return hash_bytes(h, p + i, size - i);
}

/* Encodes and writes; what core.picture gives is pushed. */
static int write_picture(lua_State *L, const char *path, const RenderOptions *o, const void *pixels, const PngText *texts, int count)
{
    char why[1400], words[200] = "", sum[MANIFEST_SUM];
    PngBytes bytes = {0};
    dig_status s = png_encode(o->layer, o->width, o->height, pixels, texts, count, &bytes, words, sizeof words);
    if (s != DIG_OK)
        snprintf(why, sizeof why, "%s: %s", path, words);
    else
        s = png_save(path, &bytes, true, why, sizeof why);
    uint64_t size = bytes.size;
    if (s == DIG_OK)
        manifest_sum(bytes.data, bytes.size, sum);
    png_release(&bytes);
    if (s != DIG_OK)
        return bind_fail_text(L, s == DIG_E_MEMORY ? s : DIG_E_FILE, "%s", why);
    size_t of_one = o->layer == RENDER_DEPTH || o->layer == RENDER_ID ? 4 : 3;
    bool plain;
    uint64_t hash = hash_pixels(pixels, of_one * (size_t)o->width * (size_t)o->height, of_one, &plain);
    lua_pushinteger(L, (lua_Integer)size);
    lua_pushstring(L, sum);
    lua_pushboolean(L, plain);
    lua_pushinteger(L, (lua_Integer)hash);
    return 4;
}

/* core.picture(view, options, path, {key, value, ...}) -> bytes, SHA-256 of the file, whether it has one colour, a hash of its pixels */
static int film_picture(lua_State *L)
{
    const char *path = luaL_checkstring(L, 3);
    PngText texts[TEXT_COUNT];
    int count = 0;
    luaL_checkstack(L, 4 * TEXT_COUNT, "too many values");
    lua_settop(L, 4);
    const void *pixels = NULL;
    RenderOptions o = draw_all(L, 1, 2, &pixels);
    if (lua_istable(L, 4))
        for (int i = 1; i < 2 * TEXT_COUNT && lua_rawgeti(L, 4, i) != LUA_TNIL; i += 2) {
            lua_rawgeti(L, 4, i + 1);
            texts[count++] = (PngText){lua_tostring(L, -2), lua_tostring(L, -1)};    /* the table keeps both */
        }
    return write_picture(L, path, &o, pixels, texts, count);
}

/* ---- ffmpeg ------------------------------------------------------------------------------ */

typedef struct Pipe {
    pid_t pid;              /* 0 = closed */
    int   fd;
    int   width, height;
    char  path[1200];
    FileDraft draft;        /* where ffmpeg writes */
} Pipe;

extern char **environ;

static const char *extension_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot ? dot : "";
}

/* Starts ffmpeg in a process group of its own, so that Ctrl-C does not cut the film short. Returns an errno. */
static int start_ffmpeg(Pipe *p, const char *fps)
{
    char size[32];
    bool webm = strcmp(extension_of(p->path), ".webm") == 0;
    snprintf(size, sizeof size, "%dx%d", p->width, p->height);
    const char *arguments[] = {
        "ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", fps, "-i", "-",
        "-an", "-c:v", webm ? "libvpx-vp9" : "libx264", "-crf", webm ? "30" : "18", "-b:v", "0", "-vf",
        "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", "-bitexact", "-f", webm ? "webm" : "mp4", p->draft.name, NULL,
    };
    int ends[2];
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    int error = file_pipe(ends);
    if (error != 0)
        return error;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[0], 0);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    error = posix_spawnp(&p->pid, "ffmpeg", &actions, &attributes, (char *const *)(uintptr_t)arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    close(ends[0]);
    if (error != 0) {
        p->pid = 0;
        close(ends[1]);
        return error;
    }
    p->fd = ends[1];
    return 0;
}

/* core.pipe(path, width, height, fps) -> pipe, or nil when there is no ffmpeg */
static int film_pipe(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1);
    Pipe *p = lua_newuserdatauv(L, sizeof *p, 0);
    memset(p, 0, sizeof *p);
    p->draft.handle = -1;
    p->width = (int)luaL_checkinteger(L, 2);
    p->height = (int)luaL_checkinteger(L, 3);
    snprintf(p->path, sizeof p->path, "%s", path);
    luaL_setmetatable(L, PIPE);
    signal(SIGPIPE, SIG_IGN);
    char why[1400];
    if (file_draft(p->path, &p->draft, why, sizeof why) != DIG_OK)
        return bind_fail_text(L, DIG_E_FILE, "%s", why);
    int error = start_ffmpeg(p, lua_pushfstring(L, "%f", luaL_checknumber(L, 4)));
    if (error != 0)
        file_draft_drop(&p->draft);
    if (error == ENOENT)
        return 0;
    if (error != 0)
        return bind_fail_text(L, DIG_E_FILE, "ffmpeg does not start: %s", strerror(error));
    lua_pop(L, 1);
    return 1;
}

static bool put_all(int fd, const char *bytes, size_t size)
{
    while (size > 0) {
        ssize_t n = write(fd, bytes, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        bytes += n;
        size -= (size_t)n;
    }
    return true;
}

/* pipe:frame(view, options) */
static int pipe_frame(lua_State *L)
{
    Pipe *p = luaL_checkudata(L, 1, PIPE);
    ViewRef *view = luaL_checkudata(L, 2, VIEW);
    RenderOptions o = read_options(L, 3);
    o.width = p->width;
    o.height = p->height;
    o.layer = o.layer == RENDER_NORMAL ? RENDER_NORMAL : RENDER_COLOUR;     /* three bytes a pixel */
    const char *pixels = draw(L, view, &o);
    if (!put_all(p->fd, pixels, (size_t)p->width * (size_t)p->height * 3))
        return bind_fail_text(L, DIG_E_FILE, "%s: ffmpeg takes no more frames: %s", p->path, strerror(errno));
    return 0;
}

/* core.pixels(views, options, fd): a picture's bytes, three a pixel, to another process */
static int film_pixels(lua_State *L)
{
    const void *pixels = NULL;
    int fd = (int)luaL_checkinteger(L, 3);
    RenderOptions o = draw_all(L, 1, 2, &pixels);
    if (!put_all(fd, pixels, (size_t)o.width * (size_t)o.height * 3))
        return bind_fail_text(L, DIG_E_FILE, "the frame cannot be handed on: %s", strerror(errno));
    return 0;
}

/* pipe:copy(fd) -> whether a whole frame came from there; it goes on to ffmpeg */
static int pipe_copy(lua_State *L)
{
    Pipe *p = luaL_checkudata(L, 1, PIPE);
    int fd = (int)luaL_checkinteger(L, 2);
    char part[65536];
    size_t left = (size_t)p->width * (size_t)p->height * 3;
    while (left > 0) {
        ssize_t n = read(fd, part, left < sizeof part ? left : sizeof part);
        if (n < 0 && errno == EINTR && !app_signal())
            continue;
        if (n <= 0) {
            lua_pushboolean(L, 0);
            return 1;
        }
        if (!put_all(p->fd, part, (size_t)n))
            return bind_fail_text(L, DIG_E_FILE, "%s: ffmpeg takes no more frames: %s", p->path, strerror(errno));
        left -= (size_t)n;
    }
    lua_pushboolean(L, 1);
    return 1;
}

/* pipe:drop(): no film */
static int pipe_drop(lua_State *L)
{
    Pipe *p = luaL_checkudata(L, 1, PIPE);
    if (p->pid == 0)
        return 0;
    kill(p->pid, SIGTERM);
    close(p->fd);
    while (waitpid(p->pid, NULL, 0) < 0 && errno == EINTR)
        continue;
    p->pid = 0;
    file_draft_drop(&p->draft);
    return 0;
}

static bool finish_pipe(Pipe *p, char *why, size_t capacity)
{
    int status = 0;
    if (p->pid == 0)
        return true;
    close(p->fd);
    while (waitpid(p->pid, &status, 0) < 0 && errno == EINTR)
        continue;
    p->pid = 0;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return file_draft_place(&p->draft, p->path, FILE_DURABLE, why, capacity) == DIG_OK;
    file_draft_drop(&p->draft);
    snprintf(why, capacity, "%s: ffmpeg could not write the film", p->path);
    return false;
}

/* pipe:close(): the film is under its name only when it is whole */
static int pipe_close(lua_State *L)
{
    char why[1400];
    if (!finish_pipe(luaL_checkudata(L, 1, PIPE), why, sizeof why))
        return bind_fail_text(L, DIG_E_FILE, "%s", why);
    return 0;
}

static int pipe_gc(lua_State *L)
{
    char why[1400];
    finish_pipe(luaL_checkudata(L, 1, PIPE), why, sizeof why);
    return 0;
}

/* ---- comparing pictures -------------------------------------------------------------------- */

enum { TILE = 8 };

/* Mean absolute difference of a tile, in levels of 255. */
static double tile_difference(const unsigned char *a, const unsigned char *b, int width, int height, int x0, int y0)
{
    double sum = 0;
    int n = 0;
    for (int y = y0; y < y0 + TILE && y < height; y++)
        for (int x = x0; x < x0 + TILE && x < width; x++, n += 3)
            for (int k = 0; k < 3; k++) {
                size_t i = ((size_t)y * (size_t)width + (size_t)x) * 3 + (size_t)k;
                sum += abs((int)a[i] - (int)b[i]);
            }
    return n > 0 ? sum / n : 0;
}

/* How many pixels are another, and the first of them. */
static void count_pixels(lua_State *L, const unsigned char *a, const unsigned char *b, int width, int height)
{
    int count = 0, first = -1;
    for (int i = 0; i < width * height; i++)
        if (memcmp(a + 3 * (size_t)i, b + 3 * (size_t)i, 3) != 0) {
            count++;
            first = first < 0 ? i : first;
        }
    lua_pushboolean(L, count == 0);
    lua_setfield(L, -2, "same");
    lua_pushinteger(L, count);
    lua_setfield(L, -2, "pixels");
    lua_pushinteger(L, width * height);
    lua_setfield(L, -2, "all");
    lua_pushfstring(L, "%d,%d", first < 0 ? 0 : first % width, first < 0 ? 0 : first / width);
    lua_setfield(L, -2, "first");
}

static void compare_pixels(lua_State *L, const unsigned char *a, const unsigned char *b, int width, int height, double tolerance)
{
    double worst = 0;
    int bad = 0, tiles = 0, bad_x = 0, bad_y = 0;
    for (int y = 0; y < height; y += TILE)
        for (int x = 0; x < width; x += TILE, tiles++) {
            double d = tile_difference(a, b, width, height, x, y);
            bad += d > tolerance;
            if (d > worst) {
                worst = d;
                bad_x = x;
                bad_y = y;
            }
        }
    count_pixels(L, a, b, width, height);
    lua_pushnumber(L, worst);
    lua_setfield(L, -2, "worst");
    lua_pushinteger(L, bad);
    lua_setfield(L, -2, "bad");
    lua_pushinteger(L, tiles);
    lua_setfield(L, -2, "tiles");
    lua_pushfstring(L, "%d,%d", bad_x, bad_y);
    lua_setfield(L, -2, "where");
}

/* core.compare_pictures(a, b, tolerance) -> {same, pixels, all, first, worst, bad, tiles, where} or {why} */
static int film_compare(lua_State *L)
{
    char why[512] = "";
    unsigned char *a = NULL, *b = NULL;
    int wa, ha, wb, hb;
    const char *path_a = luaL_checkstring(L, 1), *path_b = luaL_checkstring(L, 2);
    double tolerance = luaL_checknumber(L, 3);
    lua_newtable(L);
    if (png_read(path_a, &wa, &ha, &a, why, sizeof why) != DIG_OK || png_read(path_b, &wb, &hb, &b, why, sizeof why) != DIG_OK)
        lua_pushstring(L, *why ? why : "cannot be read");
    else if (wa != wb || ha != hb)
        lua_pushfstring(L, "%dx%d against %dx%d", wa, ha, wb, hb);
    else
        lua_pushnil(L);
    lua_setfield(L, -2, "why");
    if (a && b && wa == wb && ha == hb)
        compare_pixels(L, a, b, wa, ha, tolerance);
    free(a);
    free(b);
    return 1;
}

/* core.png_text(path, key) -> the text chunk of that key, or nil. Walks the chunks: length, type, data, checksum (PNG 5.3). */
static int film_png_text(lua_State *L)
{
    unsigned char head[8], body[512];
    const char *key = luaL_checkstring(L, 2);
    FILE *f = fopen(luaL_checkstring(L, 1), "rb");
    bool found = false;
    size_t key_length = strlen(key), length = 0;
    if (!f)
        return 0;
    fseek(f, 8, SEEK_SET);
    while (!found && fread(head, 1, 8, f) == 8) {
        length = (size_t)head[0] << 24 | (size_t)head[1] << 16 | (size_t)head[2] << 8 | head[3];
        if (memcmp(head + 4, "tEXt", 4) == 0 && length < sizeof body && fread(body, 1, length, f) == length) {
            found = length > key_length && memcmp(body, key, key_length + 1) == 0;
            fseek(f, 4, SEEK_CUR);
        } else if (length > 0x7fffffff || fseek(f, (long)length + 4, SEEK_CUR) != 0) {
            break;
        }
    }
    fclose(f);
    if (!found)
        return 0;
    lua_pushlstring(L, (const char *)body + key_length + 1, length - key_length - 1);
    return 1;
}

/* core.png_whole(path) -> whether every chunk is there and as it was written */
static int film_png_whole(lua_State *L)
{
    lua_pushboolean(L, png_whole(luaL_checkstring(L, 1)));
    return 1;
}

/* ---- tables ---------------------------------------------------------------------------------- */

static const luaL_Reg functions[] = {
    {"view", view_take}, {"blend", view_blend_to}, {"view_camera", view_camera}, {"picture", film_picture}, {"pipe", film_pipe},
    {"compare_pictures", film_compare}, {"png_text", film_png_text}, {"renderer", renderer_describe},
    {"picture_need", picture_need}, {"png_whole", film_png_whole}, {"pixels", film_pixels}, {NULL, NULL},
};

void bind_film_open(lua_State *L, int core)
{
    static const luaL_Reg pipe_methods[] = {{"frame", pipe_frame}, {"close", pipe_close}, {"copy", pipe_copy}, {"drop", pipe_drop}, {NULL, NULL}};
    static const luaL_Reg pipe_meta[] = {{"__gc", pipe_gc}, {NULL, NULL}};
    bind_held_type(L, VIEW, view_gc);
    bind_held_type(L, RENDERER, renderer_gc);
    bind_type(L, core, PIPE, pipe_methods, NULL, NULL, pipe_meta);
    lua_pushvalue(L, core);
    luaL_setfuncs(L, functions, 0);
    lua_pushboolean(L, 1);
    lua_setfield(L, -2, "can_render");
    lua_newtable(L);
    static const struct { const char *name; int bit; } overlays[] = {
        {"dig", OVERLAY_DIG}, {"contacts", OVERLAY_CONTACTS}, {"forces", OVERLAY_FORCES}, {"names", OVERLAY_NAMES},
        {"joints", OVERLAY_JOINTS}, {"time", OVERLAY_TIME}, {"temperature", OVERLAY_TEMPERATURE}, {"stress", OVERLAY_STRESS},
        {"trails", OVERLAY_TRAILS}, {"energy", OVERLAY_ENERGY},
    };
    for (size_t i = 0; i < sizeof overlays / sizeof *overlays; i++) {
        lua_pushinteger(L, overlays[i].bit);
        lua_setfield(L, -2, overlays[i].name);
    }
    lua_setfield(L, -2, "overlays");
    lua_pop(L, 1);
}

#endif
