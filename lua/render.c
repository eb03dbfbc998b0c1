/* lua/render.c - `digbox render`: frames of a replay, drawn by several processes side by side.
 *
 * What a frame looks like is decided in lua/digbox/render.lua; here are the options and the workers. These are forked before any
 * picture is drawn (a fork after OpenGL has started threads may hang), each opens the replay anew and draws every n-th frame. For a
 * video they hand their pixels to this process, which gives them to ffmpeg in their order; else they write files and hand on what
 * the manifest says of each, which this process alone holds.
 */

#define _XOPEN_SOURCE 700       /* fork, setenv */

#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "command.h"
#include "process.h"
#include "state.h"

enum { MOST_WORKERS = 64 };

typedef struct RenderJob {
    const char *replay, *to, *camera, *frames, *size, *layer, *overlay;     /* NULL = not given */
    double      fps;                                                        /* Hz, < 0 = not given */
    long long   samples, blur, workers;                                     /* < 0 = not given */
    bool        resume, force, quiet;
    int        *list, count;                                                /* frames to draw */
} RenderJob;

typedef struct Worker { pid_t pid; int fd; } Worker;    /* fd: its pixels or its entries of the manifest come from there */

/* ---- Lua ------------------------------------------------------------------------- */

static void set_text(lua_State *L, const char *name, const char *text)
{
    if (!text)
        return;
    lua_pushstring(L, text);
    lua_setfield(L, -2, name);
}

static void set_whole(lua_State *L, const char *name, long long value)
{
    if (value < 0)
        return;
    lua_pushinteger(L, value);
    lua_setfield(L, -2, name);
}

static int push_job(lua_State *L)
{
    const RenderJob *job = lua_touserdata(L, 1);
    lua_newtable(L);
    set_text(L, "replay", job->replay);
    set_text(L, "to", job->to);
    set_text(L, "camera", job->camera);
    set_text(L, "frames", job->frames);
    set_text(L, "size", job->size);
    set_text(L, "layer", job->layer);
    set_text(L, "overlay", job->overlay);
    set_whole(L, "samples", job->samples);
    set_whole(L, "blur", job->blur);
    set_whole(L, "workers", job->workers);
    if (job->fps > 0) {
        lua_pushnumber(L, job->fps);
        lua_setfield(L, -2, "fps");
    }
    return 1;
}

static int push_list(lua_State *L)
{
    const RenderJob *job = lua_touserdata(L, 1);
    lua_createtable(L, job->count, 0);
    for (int i = 0; i < job->count; i++) {
        lua_pushinteger(L, job->list[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

/* Leaves the plan on the stack, or a text. A bad option or file is said before anything is done. */
static int make_plan(lua_State *L, App *app, const RenderJob *job)
{
    lua_pushcfunction(L, push_job);
    lua_pushlightuserdata(L, (void *)(uintptr_t)job);
    int code = app_call(L, app, 1, 1);
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "render_plan", 1, 1);
    bool of_file = code != EXIT_FINE && lua_isstring(L, -1) && strstr(lua_tostring(L, -1), job->replay);
    return code == EXIT_SCRIPT ? of_file ? EXIT_FORMAT : EXIT_USAGE : code;
}

/* What draws here, asked in a process of its own: in this one no OpenGL may start before the workers do. */
static bool ask_renderer(lua_State *L, App *app, char *text, size_t capacity)
{
    int ends[2], status = 0;
    *text = '\0';
    if (file_pipe(ends) != 0)
        return false;
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        int code = app_call_core(L, app, "renderer", 0, 1);
        const char *said = lua_tostring(L, -1);
        bool fine = code == EXIT_FINE && said && write(ends[1], said, strlen(said)) > 0;
        if (code != EXIT_FINE && said)
            say_error(said);
        _exit(fine ? EXIT_FINE : EXIT_OUTPUT);
    }
    close(ends[1]);
    ssize_t n = pid < 0 ? 0 : read(ends[0], text, capacity - 1);
    close(ends[0]);
    while (pid > 0 && waitpid(pid, &status, 0) < 0 && errno == EINTR)
        continue;
    text[n > 0 ? n : 0] = '\0';
    text[strcspn(text, "\n")] = '\0';
    return pid > 0 && n > 0 && WIFEXITED(status) && WEXITSTATUS(status) == EXIT_FINE;
}

/* The frames that are not there yet, judged once and for all workers; the plan is on top of the stack and stays. */
static int list_frames(lua_State *L, App *app, RenderJob *job, bool video)
{
    char renderer[512] = "";
    if (!video && !ask_renderer(L, app, renderer, sizeof renderer)) {
        lua_pushnil(L);
        return app_signal() ? 128 + app_signal() : EXIT_OUTPUT;
    }
    lua_pushvalue(L, -1);
    lua_pushstring(L, job->replay);
    lua_pushstring(L, job->force ? "force" : job->resume ? "resume" : "new");
    lua_pushstring(L, renderer);
    int code = app_call_core(L, app, "render_begin", 4, 1);
    if (code != EXIT_FINE)
        return code == EXIT_SCRIPT ? EXIT_USAGE : code;
    job->count = (int)lua_rawlen(L, -1);
    job->list = calloc((size_t)job->count + 1, sizeof *job->list);
    if (!job->list)
        return EXIT_MEMORY;
    for (int i = 0; i < job->count; i++) {
        lua_rawgeti(L, -1, i + 1);
        job->list[i] = (int)lua_tointeger(L, -1);
        lua_pop(L, 1);
    }
    return EXIT_FINE;
}

static int fail(lua_State *L, int code)
{
    if (lua_isstring(L, -1))
        say_error(lua_tostring(L, -1));
    return code;
}

/* ---- workers ---------------------------------------------------------------------- */

static int work(const RenderJob *job, int index, int fd)
{
    App app = {.fuel = -1, .script = job->replay};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_INTERNAL;
    int code = make_plan(L, &app, job);
    if (code == EXIT_FINE) {
        lua_pushcfunction(L, push_list);
        lua_pushlightuserdata(L, (void *)(uintptr_t)job);
        code = app_call(L, &app, 1, 1);
    }
    if (code == EXIT_FINE) {
        lua_pushinteger(L, index);
        lua_pushinteger(L, job->workers);
        lua_pushinteger(L, fd);
        code = app_call_core(L, &app, "render_work", 5, 0);
    }
    if (code != EXIT_FINE)
        fail(L, code);
    lua_close(L);
    return app_signal() ? 128 + app_signal() : code;
}

/* Returns an errno. */
static int start_worker(const RenderJob *job, Worker *workers, int index)
{
    int ends[2] = {-1, -1};
    const pid_t parent = getpid();
    int error = file_pipe(ends);
    if (error != 0)
        return error;
    fflush(stdout);
    pid_t pid = fork();
    if (pid < 0) {
        error = errno;
        close(ends[0]);
        close(ends[1]);
        return error;
    }
    if (pid == 0) {
        process_begin(parent);
        for (int i = 0; i < index; i++)
            close(workers[i].fd);
        close(ends[0]);
        signal(SIGPIPE, SIG_IGN);
        if (job->workers > 1)
            setenv("LP_NUM_THREADS", "0", 0);   /* one thread each: two such processes are faster than one of two threads */
        _exit(work(job, index, ends[1]));
    }
    close(ends[1]);
    workers[index] = (Worker){pid, ends[0]};
    return 0;
}

static void pass_signal_on(const Worker *workers, int count)
{
    for (int i = 0; app_signal() && i < count; i++)
        kill(workers[i].pid, app_signal());
}

static void push_fds(lua_State *L, const Worker *workers, int count)
{
    lua_createtable(L, count, 0);
    for (int i = 0; i < count; i++) {
        lua_pushinteger(L, workers[i].fd);
        lua_rawseti(L, -2, i + 1);
    }
}

/* The plan and the list of frames are on the stack. */
static int collect_video(lua_State *L, App *app, const Worker *workers, int count)
{
    push_fds(L, workers, count);
    int code = app_call_core(L, app, "render_collect", 3, 1);
    if (code != EXIT_FINE)
        return fail(L, code);
    return lua_toboolean(L, -1) ? EXIT_FINE : EXIT_OUTPUT;
}

/* The same; the plan stays. What was drawn when a signal comes is in the manifest, too. */
static int collect_entries(lua_State *L, App *app, const RenderJob *job, const Worker *workers, int count)
{
    int code = EXIT_FINE;
    lua_pushvalue(L, -2);
    lua_insert(L, -2);                          /* plan, plan, frames */
    if (count > 0) {
        push_fds(L, workers, count);
        code = app_call_core(L, app, "render_list", 3, 0);
    } else {
        lua_pop(L, 2);
    }
    pass_signal_on(workers, count);
    if (code == EXIT_FINE) {
        push_fds(L, workers, count);
        lua_pushinteger(L, job->count);
        code = app_call_core(L, app, "render_end", 3, 0);
    }
    return code == EXIT_FINE ? code : fail(L, code);
}

/* Waits for all; the first code that is not fine. A signal to this process alone is passed on. */
static int wait_for(const Worker *workers, int count)
{
    int code = EXIT_FINE;
    for (int i = 0; i < count; i++) {
        int status = 0;
        while (waitpid(workers[i].pid, &status, 0) < 0 && errno == EINTR)
            for (int k = i; app_signal() && k < count; k++)
                kill(workers[k].pid, app_signal());
        int own = WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_INTERNAL;
        if (!WIFEXITED(status))
            fprintf(stderr, "digbox: render: a worker was ended by signal %d\n", WTERMSIG(status));
        code = code == EXIT_FINE ? own : code;
    }
    return code;
}

static int run_workers(lua_State *L, App *app, RenderJob *job, bool video)
{
    Worker workers[MOST_WORKERS];
    int started = 0, error = 0;
    while (job->count > 0 && started < job->workers && !error) {
        error = start_worker(job, workers, started);
        started += !error;
    }
    int code = EXIT_FINE;
    if (error) {
        fprintf(stderr, "digbox: render: no further process: %s\n", strerror(error));
        for (int i = 0; i < started; i++)
            kill(workers[i].pid, SIGTERM);
    } else if (video) {
        code = job->count > 0 ? collect_video(L, app, workers, started) : EXIT_FINE;
    } else {
        code = collect_entries(L, app, job, workers, started);
    }
    for (int i = 0; i < started; i++)
        close(workers[i].fd);
    int theirs = wait_for(workers, started);
    if (error)
        return EXIT_INTERNAL;
    return app_signal() ? 128 + app_signal() : theirs != EXIT_FINE ? theirs : code;
}

static int render(RenderJob *job)
{
    App app = {.fuel = -1, .script = job->replay};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_INTERNAL;
    int code = make_plan(L, &app, job);
    bool video = false;
    char name[1024] = "";
    if (code == EXIT_FINE) {
        lua_getfield(L, -1, "video");
        video = lua_toboolean(L, -1);
        lua_getfield(L, -2, "said");
        snprintf(name, sizeof name, "%s", lua_tostring(L, -1));
        lua_pop(L, 2);
        code = list_frames(L, &app, job, video);
    }
    if (code != EXIT_FINE) {
        fail(L, code);
    } else {
        job->workers = job->workers < job->count ? job->workers : job->count > 0 ? job->count : 1;
        code = run_workers(L, &app, job, video);
        if (code == EXIT_FINE && !job->quiet && !job->resume)           /* resuming says more */
            fprintf(stderr, "digbox: %s: %d frame%s\n", name, job->count, job->count == 1 ? "" : "s");
    }
    lua_close(L);
    free(job->list);
    return code;
}

/* ---- the command ------------------------------------------------------------------- */

enum { OPT_CAMERA = 256, OPT_FRAMES, OPT_FPS, OPT_SIZE, OPT_SAMPLES, OPT_LAYER, OPT_OVERLAY, OPT_BLUR, OPT_RESUME, OPT_FORCE };

static const struct option render_options[] = {
    {"output", required_argument, NULL, 'o'}, {"jobs", required_argument, NULL, 'j'}, {"camera", required_argument, NULL, OPT_CAMERA},
    {"frames", required_argument, NULL, OPT_FRAMES}, {"fps", required_argument, NULL, OPT_FPS},
    {"size", required_argument, NULL, OPT_SIZE}, {"samples", required_argument, NULL, OPT_SAMPLES},
    {"layer", required_argument, NULL, OPT_LAYER}, {"overlay", required_argument, NULL, OPT_OVERLAY},
    {"blur", required_argument, NULL, OPT_BLUR}, {"resume", no_argument, NULL, OPT_RESUME}, {"force", no_argument, NULL, OPT_FORCE},
    {"quiet", no_argument, NULL, 'q'}, {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static bool read_option(RenderJob *job, int key)
{
    switch (key) {
    case 'o': job->to = optarg; return true;
    case 'j': return read_whole_option("jobs", optarg, 1, MOST_WORKERS, &job->workers);
    case OPT_CAMERA: job->camera = optarg; return true;
    case OPT_FRAMES: job->frames = optarg; return true;
    case OPT_FPS: return read_number_option("fps", optarg, "Hz", 1e-3, 1e5, &job->fps);
    case OPT_SIZE: job->size = optarg; return true;
    case OPT_SAMPLES: return read_whole_option("samples", optarg, 0, 4, &job->samples);
    case OPT_LAYER: job->layer = optarg; return true;
    case OPT_OVERLAY: job->overlay = optarg; return true;
    case OPT_BLUR: return read_whole_option("blur", optarg, 1, 64, &job->blur);
    case OPT_RESUME: job->resume = true; return true;
    case OPT_FORCE: job->force = true; return true;
    case 'q': job->quiet = true; return true;
    default: return false;               /* next_option said why */
    }
}

static int command_render(int argc, char **argv)
{
    RenderJob job = {.fps = -1, .samples = -1, .blur = -1, .workers = 1};
    int key;
    while ((key = next_option("render", argc, argv, "o:j:qh", render_options)) != -1) {
        if (key == 'h')
            return print_help("render");
        if (!read_option(&job, key))
            return EXIT_USAGE;
    }
    if (job.resume && job.force)
        return usage_error("render: --resume keeps what is there, --force forgets it: one of them");
    if (optind >= argc)
        return usage_error("render: which replay? (digbox render FILE.replay)");
    if (optind + 1 < argc)
        return usage_error("render: one replay at a time; '%s' is too many", argv[optind + 1]);
    job.replay = argv[optind];
    return flush_output(render(&job));
}

const Command render_command = {
    .name = "render",
    .use = "  digbox render REPLAY [-o PATTERN] [options]     frames of a run, without simulating it again\n",
    .options = "  -o, --output PATTERN   out/NAME-%05d.png; .mp4 or .webm for a film (default: the replay's name)\n"
               "  -j, --jobs N           so many processes side by side (1); the files are the same for any N\n"
               "  --frames A..B          these frames only, counted from 0\n"
               "  --fps HZ               frames a second of simulated time (as the script's film, else 30)\n"
               "  --size WxH             px (as the script's film, else 1280x720)\n"
               "  --camera NAME          a camera of the script (its film's, else its first)\n"
               "  --layer L              colour, depth, id or normal\n"
               "  --overlay LIST         dig,contacts,forces,names,joints,time,stress,temperature,trails,energy\n"
               "  --samples 0|2|4        samples a pixel; not given: edges are smoothed afterwards\n"
               "  --blur N               motion blur: each frame is the mean of N moments of its first half (1)\n"
               "  --resume               keep the frames that are there and whole, draw the others\n"
               "  --force                forget what is there and draw the film anew\n"
               "  -q, --quiet            no closing line\n",
    .notes =
        "\n"
        "Layers: colour; normal, in world axes, -1..1 as 0..255; depth, 16-bit grey, mm along the view, 65535 for the sky and beyond 65.5 m;\n"
        "id, which body is seen: R + 256 G + 65536 B is its number in the world's table (body.debug.db_id) + 1, and 0 is none. Overlays are\n"
        "drawn over colour alone. What each shows is in docs/frames.md. A video holds colour and normal.\n",
    .run = command_render,
};
