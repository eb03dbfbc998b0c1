/* lua/export.c - `digbox export`: a replay in a form that other programs read. */

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "command.h"
#include "export/export.h"
#include "state.h"

enum { OPT_FRAMES = 256, OPT_FPS, OPT_AT };

static const struct option export_options[] = {
    {"output", required_argument, NULL, 'o'}, {"frames", required_argument, NULL, OPT_FRAMES}, {"fps", required_argument, NULL, OPT_FPS},
    {"at", required_argument, NULL, OPT_AT}, {"quiet", no_argument, NULL, 'q'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

typedef struct Wish { const char *replay, *out, *frames; double fps, at; bool quiet; } Wish;

/* A..B, A.. or ..B; what is left out is the first or the last frame. */
bool read_frames_option(const char *text, int frames, int *first_frame, int *last_frame)
{
    const char *dots = strstr(text, "..");
    char *end;
    long first = dots == text ? 0 : strtol(text, &end, 10), last = frames - 1;
    bool fine = dots && (dots == text || end == dots);
    if (fine && dots[2]) {
        last = strtol(dots + 2, &end, 10);
        fine = *end == '\0';
    }
    if (!fine) {
        usage_error("--frames: '%s' is not A..B", text);
        return false;
    }
    if (first < 0 || first > last || last >= frames) {
        usage_error("--frames: %s is not within the frames of the replay, 0..%d", text, frames - 1);
        return false;
    }
    *first_frame = (int)first;
    *last_frame = (int)last;
    return true;
}

static int unknown_format(const char *path)
{
    char list[200] = "";
    for (int i = 0; export_format(i); i++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", export_format(i)->suffix);
    return usage_error("export: %s: its name must end in one of %s", path, list);
}

static int export_open_replay(Replay *r, const Wish *w, const ExportFormat *format)
{
    ExportOptions options = export_defaults(r);
    char why[512];
    if (w->frames && !read_frames_option(w->frames, replay_info(r)->frames, &options.first, &options.last))
        return EXIT_USAGE;
    if (!isnan(w->at) && strcmp(format->suffix, ".dot") != 0)
        return usage_error("--at: %s is no picture of one moment: only .dot is", w->out);
    const real begin = (real)replay_info(r)->first_step * replay_info(r)->step, end = begin + (replay_info(r)->frames - 1) * replay_info(r)->step;
    if (!isnan(w->at) && !(w->at >= begin - 1e-9 && w->at <= end + 1e-9))
        return usage_error("--at: %g s is not within the replay, %g to %g s", w->at, begin, end);
    options.fps = w->fps;
    options.at = w->at;
    if (replay_info(r)->cut && !w->quiet)
        fprintf(stderr, "digbox: %s: the file was cut short; %d frames of it are whole\n", w->replay, replay_info(r)->frames);
    dig_status status = export_write(r, format, &options, w->out, why, sizeof why);
    if (status != DIG_OK) {
        say_error(why);
        return status == DIG_E_FILE ? EXIT_OUTPUT : exit_code_of_reading(status);
    }
    struct stat info;
    if (!w->quiet && stat(w->out, &info) == 0)
        fprintf(stderr, "digbox: %s: %lld bytes, %s\n", w->out, (long long)info.st_size, format->what);
    return EXIT_FINE;
}

static int export_replay(const Wish *w)
{
    const ExportFormat *format = export_find(w->out);
    Replay *r;
    char why[512];
    if (!format)
        return unknown_format(w->out);
    dig_status status = replay_open(w->replay, &r, why, sizeof why);
    if (status != DIG_OK) {
        say_error(why);
        return exit_code_of_reading(status);
    }
    int code = export_open_replay(r, w, format);
    replay_close(r);
    return code;
}

static bool read_wish(Wish *w, int key)
{
    switch (key) {
    case 'o': w->out = optarg; return true;
    case 'q': w->quiet = true; return true;
    case OPT_FRAMES: w->frames = optarg; return true;
    case OPT_FPS: return read_number_option("fps", optarg, "1/s", 1e-3, 1e6, &w->fps);
    case OPT_AT: return read_number_option("at", optarg, "s", 0, 1e9, &w->at);
    default: return false;               /* next_option said why */
    }
}

static int command_export(int argc, char **argv)
{
    Wish w = {.at = NAN};
    int key;
    while ((key = next_option("export", argc, argv, "o:qh", export_options)) != -1) {
        if (key == 'h')
            return print_help("export");
        if (!read_wish(&w, key))
            return EXIT_USAGE;
    }
    if (optind >= argc)
        return usage_error("export: which replay? (digbox export RUN.replay -o RUN.glb; digbox run WORLD.lua --replay RUN.replay makes one)");
    if (optind + 1 < argc)
        return usage_error("export: one replay at a time; '%s' is too many", argv[optind + 1]);
    if (!w.out)
        return usage_error("export: where to? (-o FILE.glb, .csv, .jsonl, .npy or .dot)");
    w.replay = argv[optind];
    return export_replay(&w);
}

const Command export_command = {
    .name = "export",
    .use = "  digbox export REPLAY -o FILE [options]          a replay for other programs: .glb .csv .jsonl .npy .dot\n",
    .options =
        "  -o, --output FILE       its ending says the format: .glb binary glTF 2.0 with baked motion, .csv a row for each body and\n"
        "                          frame, .jsonl a line for each frame, .npy a NumPy array, .dot graphs of one moment for Graphviz\n"
        "      --frames A..B       only these (default all; 0 is the state before the first step)\n"
        "      --fps N             at most so many frames a second (default one for each step)\n"
        "      --at S              .dot: the moment that is drawn (default the last frame)\n"
        "  -q, --quiet             no closing line\n",
    .run = command_export,
};
