/* lua/view.c - `digbox view`: a replay as one page that any browser plays, without a network. */

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "bind.h"
#include "command.h"
#include "export/export.h"
#include "state.h"

enum { OPT_FRAMES = 256, OPT_FPS, OPT_TITLE };

static const struct option view_options[] = {
    {"output", required_argument, NULL, 'o'}, {"frames", required_argument, NULL, OPT_FRAMES}, {"fps", required_argument, NULL, OPT_FPS},
    {"title", required_argument, NULL, OPT_TITLE}, {"quiet", no_argument, NULL, 'q'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

typedef struct ViewWish { const char *replay, *out, *frames, *title; double fps; bool quiet; } ViewWish;

/* The page that `make viewer` built, if it was there when the program was. */
static bool find_shell(ExportShell *shell)
{
    for (const struct digbox_source *s = digbox_embedded; s->name; s++)
        if (strcmp(s->name, "page.html") == 0) {
            shell->text = s->text;
            shell->size = s->size;
            return true;
        }
    return false;
}

/* The name of the file without folder and ending. */
static void name_title(const char *path, char *title, size_t capacity)
{
    const char *name = strrchr(path, '/');
    snprintf(title, capacity, "%s", name ? name + 1 : path);
    char *dot = strrchr(title, '.');
    if (dot && dot != title)
        *dot = '\0';
}

static int write_page(Replay *r, const ViewWish *w, ExportShell *shell)
{
    ExportOptions options = export_defaults(r);
    char why[512];
    if (w->frames && !read_frames_option(w->frames, replay_info(r)->frames, &options.first, &options.last))
        return EXIT_USAGE;
    options.fps = w->fps;
    options.shell = shell;
    if (replay_info(r)->cut && !w->quiet)
        fprintf(stderr, "digbox: %s: the file was cut short; %d frames of it are whole\n", w->replay, replay_info(r)->frames);
    dig_status status = export_write(r, &export_html, &options, w->out, why, sizeof why);
    if (status != DIG_OK) {
        say_error(why);
        return status == DIG_E_FILE ? EXIT_OUTPUT : exit_code_of_reading(status);
    }
    struct stat info;
    if (!w->quiet && stat(w->out, &info) == 0)
        fprintf(stderr, "digbox: %s: %.2f MB, open it in a browser\n", w->out, 1e-6 * (double)info.st_size);
    return EXIT_FINE;
}

static int view_replay(const ViewWish *w)
{
    ExportShell shell = {0};
    Replay *r;
    char why[512], title[128];
    if (!find_shell(&shell)) {
        fputs("digbox: view: this program was built without the page; 'make viewer' builds it in (with node and npm)\n", stderr);
        return EXIT_USAGE;
    }
    name_title(w->replay, title, sizeof title);
    shell.title = w->title ? w->title : title;
    dig_status status = replay_open(w->replay, &r, why, sizeof why);
    if (status != DIG_OK) {
        say_error(why);
        return exit_code_of_reading(status);
    }
    int code = write_page(r, w, &shell);
    replay_close(r);
    return code;
}

static bool read_view_option(ViewWish *w, int key)
{
    switch (key) {
    case 'o': w->out = optarg; return true;
    case 'q': w->quiet = true; return true;
    case OPT_FRAMES: w->frames = optarg; return true;
    case OPT_TITLE: w->title = optarg; return true;
    case OPT_FPS: return read_number_option("fps", optarg, "1/s", 1e-3, 1e6, &w->fps);
    default: return false;               /* next_option said why */
    }
}

static int command_view(int argc, char **argv)
{
    ViewWish w = {0};
    int key;
    while ((key = next_option("view", argc, argv, "o:qh", view_options)) != -1) {
        if (key == 'h')
            return print_help("view");
        if (!read_view_option(&w, key))
            return EXIT_USAGE;
    }
    if (optind >= argc)
        return usage_error("view: which replay? (digbox view RUN.replay -o page.html; digbox run WORLD.lua --replay RUN.replay makes one)");
    if (optind + 1 < argc)
        return usage_error("view: one replay at a time; '%s' is too many", argv[optind + 1]);
    if (!w.out || !*w.out)
        return usage_error("view: where to? (-o page.html)");
    const char *end = strrchr(w.out, '.');
    if (!end || (strcmp(end, ".html") != 0 && strcmp(end, ".htm") != 0))
        return usage_error("view: '%s' must end in .html; tables and scenes are written by digbox export", w.out);
    w.replay = argv[optind];
    return view_replay(&w);
}

const Command view_command = {
    .name = "view",
    .use = "  digbox view REPLAY -o page.html [options]       a replay as one page for a browser: play, step, pick, links, events, plots\n",
    .options =
        "  -o, --output FILE       the page; it needs no other file and no network\n"
        "      --frames A..B       only these (default all; 0 is the state before the first step)\n"
        "      --fps N             at most so many frames a second (default one for each step)\n"
        "      --title TEXT        what stands above it (default the name of the replay)\n"
        "  -q, --quiet             no closing line\n",
    .run = command_view,
};
