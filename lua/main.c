/* lua/main.c - the program `digbox`: run, check, help; test and cost have files of their own.
 *
 * Exit codes are in state.h. Errors go to stderr as `digbox: FILE:LINE: message`.
 */

#define _XOPEN_SOURCE 700       /* isatty, strdup */

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <lauxlib.h>

#include "command.h"
#include "state.h"

/* ---- help ------------------------------------------------------------------ */

#define RUN_USE   "  digbox run WORLD.lua [options] [-- ARGUMENTS]   run a world; a picture of its end when it records nothing\n"
#define TEST_USE  "  digbox test [PATH...] [options]                 run scenarios: files, or folders with *_spec.lua and other scenarios\n"
#define CHECK_USE "  digbox check FILE...                            compile, and build the world up to its first step\n"
#define RUN_OPTIONS \
    "  -o, --output DIR        where pictures go (default out)\n" \
    "      --seconds N         simulate to t = N s, whatever the world asks for\n" \
    "      --accuracy A        sketch, play, study, reference, or a tolerance in metres\n" \
    "      --seed N            seed of the world and of math.random\n" \
    "      --threads N         1 to 64; the result is the same for any number\n" \
    "      --set NAME=VALUE    an argument that the world declares (digbox.args); so does -- --NAME VALUE\n" \
    "      --time-limit S      stop after S seconds of wall time (exit code 5)\n" \
    "      --memory-limit MiB  memory that the script may use (exit code 3)\n" \
    "      --fuel N            Lua instructions that the script may use (exit code 4)\n" \
    "      --trust             the script may use io and os, and write anywhere\n" \
    "      --replay FILE       keep the run in a file: to draw, compare and export it without simulating again\n" \
    "      --trace FILE        what each step spent its time on, for chrome://tracing or ui.perfetto.dev\n" \
    "      --strict            a run that became unreliable ends with exit code 12\n" \
    "  -q, --quiet             no progress line, no warnings, no closing line\n"
#define TEST_OPTIONS \
    "  -k PATTERN              only scenarios with this text in their name\n" \
    "  -j, --jobs N            so many at the same time (default 1)\n" \
    "      --tap               results as Test Anything Protocol\n" \
    "      --junit FILE        results as JUnit XML, too\n" \
    "      --update-goldens    take the pictures of today as right\n" \
    "      --time-limit S      for one scenario (default 300)\n" \
    "  -o, --output DIR        where pictures of failures go (default out)\n"

#define COST_USE  "  digbox cost WORLD.lua [options] [-- ARGUMENTS]  what accuracy costs in time: error against CPU time, table and plot\n"
#define COST_OPTIONS \
    "  -o, --output DIR        where cost.csv, cost.gp, cost.svg and cost.png go (default out)\n" \
    "      --seconds N         simulate to t = N s (default: as long as the script runs, else 10 s)\n" \
    "      --effects           what each effect costs instead, as bars: effects.csv, effects.svg and effects.png\n" \
    "      --within LENGTH     the error that the closing sentence is about (default 1 mm)\n" \
    "      --budget S          CPU time that one run may use; settings beyond it are left out (default 10 s)\n" \
    "      --seed N  --threads N  --set NAME=VALUE  --memory-limit MiB  --trust  -q, --quiet   as for run\n"

#define VERIFY_USE "  digbox verify FILE.replay...                    simulate replays again: is the checksum of every step the same?\n"
#define VERIFY_NOTES \
    "\n" \
    "A replay (digbox run --replay) holds the world it began with and every command that changed it; what effects written in Lua\n" \
    "gave back is in the log, so that no script is needed. Exit code 0: every checksum is the same, 7: one differs, which is named,\n" \
    "8: the file is no replay, or holds no log.\n"

#define COST_NOTES \
    "\n" \
    "The world runs at sketch, play, study and reference and at tolerances from 1e-2 to 1e-9 m, from the same start, without\n" \
    "pictures. The finest run that keeps its budget is the reference. The error of a setting is the largest difference of any\n" \
    "body's position, or rotation times half its size, after any frame. CPU time is that of the frame steps alone, without the\n" \
    "script. Measured is the first world that takes a step. Two more runs begin 1e-9 and 1e-8 of a body's size aside: where\n" \
    "they part, the world is chaotic, and errors end there.\n"

static const char help_text[] =
    "digbox - a 3D physics sandbox with dynamic interaction graphs\n"
    "\n" RUN_USE TEST_USE CHECK_USE COST_USE VERIFY_USE
    "  digbox --help | --version\n"
    "\n"
    "run:\n" RUN_OPTIONS
    "\n"
    "test:\n" TEST_OPTIONS
    "\n"
    "cost:\n" COST_OPTIONS
    "\n"
    "Exit codes: 0 ok, 1 script error, 2 usage, 3 memory, 4 fuel, 5 time, 6 scenario failed, 7 replay diverged, 8 bad input file,\n"
    "9 output failed, 10 non-finite state, 11 internal, 12 unreliable (--strict), 130 SIGINT, 143 SIGTERM.\n";

int print_help(const char *command)
{
    static const struct { const char *name, *text; } helps[] = {
        {"run", RUN_USE "\n" RUN_OPTIONS "\nThe arguments that a world declares: digbox run WORLD.lua -- --help\n"},
        {"test", TEST_USE "\n" TEST_OPTIONS},
        {"check", CHECK_USE},
        {"cost", COST_USE "\n" COST_OPTIONS COST_NOTES},
        {"verify", VERIFY_USE VERIFY_NOTES},
    };
    const char *text = help_text;
    for (size_t i = 0; i < sizeof helps / sizeof *helps; i++)
        if (command && strcmp(helps[i].name, command) == 0)
            text = helps[i].text;
    fputs(text, stdout);
    return flush_output(EXIT_FINE);
}

int usage_error(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("digbox: ", stderr);
    vfprintf(stderr, format, arguments);
    fputs("\nTry 'digbox --help'.\n", stderr);
    va_end(arguments);
    return EXIT_USAGE;
}

/* ---- values of options ------------------------------------------------------- */

bool read_number_option(const char *name, const char *text, const char *unit, double low, double high, double *value)
{
    char why[256] = "", *end;
    double x = strtod(text, &end);
    bool plain = *text && *end == '\0' && strspn(text, "0123456789+-.eE") == strlen(text);
    if (!plain && dig_unit_parse(text, unit, &x, why, sizeof why) != DIG_OK) {
        usage_error("--%s: %s", name, why);
        return false;
    }
    if (!(x >= low && x <= high)) {
        usage_error("--%s: %s is not from %g to %g", name, text, low, high);
        return false;
    }
    *value = x;
    return true;
}

bool read_whole_option(const char *name, const char *text, long long low, long long high, long long *value)
{
    char *end;
    errno = 0;
    long long x = strtoll(text, &end, 10);
    if (!*text || *end || errno == ERANGE || x < low || x > high) {
        usage_error("--%s: '%s' is not a whole number from %lld to %lld", name, text, low, high);
        return false;
    }
    *value = x;
    return true;
}

void print_error(const char *text)
{
    /* One message: at most 4,000 bytes, no control bytes but line feeds. */
    fputs("digbox: ", stderr);
    for (int i = 0; i < 4000 && text[i]; i++)
        fputc(((unsigned char)text[i] >= 0x20 && text[i] != 0x7f) || text[i] == '\n' ? text[i] : '?', stderr);
    fputc('\n', stderr);
}

/* Results that cannot be written are a failure, but for a reader who went away. */
int flush_output(int code)
{
    errno = 0;
    bool failed = fflush(stdout) != 0 || ferror(stdout);
    if (!failed || errno == EPIPE)
        return code;
    fprintf(stderr, "digbox: standard output: %s\n", errno ? strerror(errno) : "cannot be written");
    return EXIT_OUTPUT;
}

/* ---- run ----------------------------------------------------------------------- */

enum { OPT_SECONDS = 256, OPT_ACCURACY, OPT_SEED, OPT_THREADS, OPT_SET, OPT_TIME, OPT_MEMORY, OPT_FUEL, OPT_TRUST, OPT_STRICT, OPT_TRACE, OPT_REPLAY };

static const struct option run_options[] = {
    {"output", required_argument, NULL, 'o'}, {"seconds", required_argument, NULL, OPT_SECONDS},
    {"accuracy", required_argument, NULL, OPT_ACCURACY}, {"seed", required_argument, NULL, OPT_SEED},
    {"threads", required_argument, NULL, OPT_THREADS}, {"set", required_argument, NULL, OPT_SET},
    {"time-limit", required_argument, NULL, OPT_TIME}, {"memory-limit", required_argument, NULL, OPT_MEMORY},
    {"fuel", required_argument, NULL, OPT_FUEL}, {"trust", no_argument, NULL, OPT_TRUST},
    {"strict", no_argument, NULL, OPT_STRICT}, {"trace", required_argument, NULL, OPT_TRACE},
    {"replay", required_argument, NULL, OPT_REPLAY}, {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

static bool read_run_option(RunOptions *o, int key)
{
    switch (key) {
    case 'o': o->out = optarg; return *optarg || usage_error("--output: the folder is missing") == 0;
    case 'q': o->quiet = true; return true;
    case OPT_SECONDS: return read_number_option("seconds", optarg, "s", 0, 1e9, &o->seconds);
    case OPT_ACCURACY: o->accuracy = optarg; return true;
    case OPT_SEED: return read_whole_option("seed", optarg, -9000000000000000000, 9000000000000000000, &o->seed);
    case OPT_THREADS: return read_whole_option("threads", optarg, 1, 64, &o->threads);
    case OPT_TIME: return read_number_option("time-limit", optarg, "s", 1e-3, 1e9, &o->time_limit);
    case OPT_MEMORY: return read_whole_option("memory-limit", optarg, 1, 1 << 20, &o->memory);
    case OPT_FUEL: return read_whole_option("fuel", optarg, 1, 1000000000000000000, &o->fuel);
    case OPT_TRUST: o->trust = true; return true;
    case OPT_STRICT: o->strict = true; return true;
    case OPT_TRACE: o->trace = optarg; return *optarg || usage_error("--trace: the file is missing") == 0;
    case OPT_REPLAY: o->replay = optarg; return *optarg || usage_error("--replay: the file is missing") == 0;
    case OPT_SET:
        if (!strchr(optarg, '=') || optarg[0] == '=')
            return usage_error("--set: '%s' is not NAME=VALUE", optarg) == 0;
        o->set[o->set_count++] = optarg;
        return true;
    default: return usage_error("see 'digbox run'") == 0;
    }
}

int cut_arguments(int argc, char **argv, RunOptions *o)
{
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--") == 0) {
            o->arguments = argv + i + 1;
            o->argument_count = argc - i - 1;
            return i;
        }
    return argc;
}

static void push_list(lua_State *L, char **list, int count)
{
    lua_createtable(L, count, 0);
    for (int i = 0; i < count; i++) {
        lua_pushstring(L, list[i]);
        lua_rawseti(L, -2, i + 1);
    }
}

static void push_settings(lua_State *L, const RunOptions *o)
{
    lua_newtable(L);
    for (int i = 0; i < o->set_count; i++) {
        const char *equals = strchr(o->set[i], '=');
        lua_pushlstring(L, o->set[i], (size_t)(equals - o->set[i]));
        lua_pushstring(L, equals + 1);
        lua_rawset(L, -3);
    }
}

static void set_text(lua_State *L, const char *name, const char *text)
{
    lua_pushstring(L, text);
    app_set_option(L, name);
}

int run_set_options(lua_State *L)
{
    const RunOptions *o = lua_touserdata(L, 1);
    char *end;
    set_text(L, "mode", o->dry ? "check" : "run");
    set_text(L, "out", o->out);
    lua_pushboolean(L, o->trust);
    app_set_option(L, "trust");
    lua_pushboolean(L, o->dry);
    app_set_option(L, "dry");
    lua_pushboolean(L, !o->quiet && isatty(2) && !getenv("NO_COLOR"));
    app_set_option(L, "progress");
    lua_pushboolean(L, o->quiet);
    app_set_option(L, "quiet");
    if (o->seconds >= 0) {
        lua_pushnumber(L, o->seconds);
        app_set_option(L, "seconds");
    }
    if (o->accuracy) {
        double tolerance = strtod(o->accuracy, &end);
        if (*end == '\0')
            lua_pushnumber(L, tolerance);
        else
            lua_pushstring(L, o->accuracy);
        app_set_option(L, "accuracy");
    }
    if (o->trace)
        set_text(L, "trace", o->trace);
    if (o->replay)
        set_text(L, "replay", o->replay);
    if (o->seed != LLONG_MIN) {
        lua_pushinteger(L, o->seed);
        app_set_option(L, "seed");
    }
    if (o->threads > 0) {
        lua_pushinteger(L, o->threads);
        app_set_option(L, "threads");
    }
    push_settings(L, o);
    app_set_option(L, "set");
    push_list(L, o->arguments, o->argument_count);
    app_set_option(L, "args");
    return 0;
}

/* After the script: the rest of --seconds, open films, the picture of the end. */
static int finish_run(lua_State *L, App *app, const RunOptions *o)
{
    int code = app_call_core(L, app, "finish_run", 0, 0);
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "finish_replay", 0, 0);
    const char *slash = strrchr(o->world, '/'), *name = slash ? slash + 1 : o->world;
    if (code != EXIT_FINE)
        return code;
    lua_pushlstring(L, name, strlen(name) - (strlen(name) > 4 && strcmp(name + strlen(name) - 4, ".lua") == 0 ? 4 : 0));
    code = app_call_core(L, app, "final_picture", 1, 1);
    if (code == EXIT_FINE && lua_isstring(L, -1) && !o->quiet)
        fprintf(stderr, "digbox: nothing was recorded; the end is in %s\n", lua_tostring(L, -1));
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "finish_trace", 0, 0);
    if (code == EXIT_FINE && !o->quiet)
        code = app_call_core(L, app, "summary", 0, 1);
    if (code == EXIT_FINE && !o->quiet && lua_tostring(L, -1)[0])
        fprintf(stderr, "digbox: %s\n", lua_tostring(L, -1));
    if (code == EXIT_FINE && o->strict)
        code = app_call_core(L, app, "judge_reliable", 0, 0);
    return code;
}

static void report_stop(lua_State *L, App *app)
{
    app->stop_code = 0;                 /* what follows may take its time */
    alarm(0);
    app->fuel = -1;
    app->deadline = 0;
    if (app_call_core(L, app, "report_stop", 0, 0) != EXIT_FINE)
        lua_pop(L, 1);
}

static int run_world(const RunOptions *o, App *app)
{
    lua_State *L = app_open(app);
    if (!L)
        return EXIT_INTERNAL;
    lua_pushcfunction(L, run_set_options);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    int code = app_call(L, app, 1, 0);
    if (code == EXIT_FINE)
        code = app_run_file(L, app);
    if (code == EXIT_FINE && !o->dry)
        code = finish_run(L, app, o);
    if (app_call_core(L, app, "clear_progress", 0, 0) != EXIT_FINE)
        lua_pop(L, 1);
    if (code != EXIT_FINE && lua_isstring(L, -1))
        print_error(lua_tostring(L, -1));
    if (code != EXIT_FINE && code != EXIT_UNRELIABLE)       /* that one came to its end */
        report_stop(L, app);
    lua_close(L);
    return code;
}

static int command_run(int argc, char **argv)
{
    RunOptions o = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1};
    int key, code = EXIT_USAGE;
    argc = cut_arguments(argc, argv, &o);
    o.set = calloc((size_t)argc + 1, sizeof *o.set);
    if (!o.set)
        return EXIT_MEMORY;
    argv[argc] = NULL;
    while ((key = getopt_long(argc, argv, "o:qh", run_options, NULL)) != -1) {
        if (key == 'h') {
            code = print_help("run");
            goto done;
        }
        if (!read_run_option(&o, key))
            goto done;
    }
    if (optind >= argc) {
        usage_error("run: which world? (digbox run WORLD.lua)");
    } else if (optind + 1 < argc) {
        usage_error("run: one world at a time; '%s' is too many (arguments of the world stand after --)", argv[optind + 1]);
    } else {
        o.world = argv[optind];
        App app = {.memory_limit = (size_t)o.memory << 20, .fuel = o.fuel, .trust = o.trust, .script = o.world};
        if (o.time_limit > 0)
            app_limit_time(&app, o.time_limit);
        code = flush_output(run_world(&o, &app));
    }
done:
    free(o.set);
    return code;
}

/* ---- check ------------------------------------------------------------------------ */

static int command_check(int argc, char **argv)
{
    int worst = EXIT_FINE;
    if (argc < 2)
        return usage_error("check: which files? (digbox check FILE...)");
    for (int i = 1; i < argc; i++) {
        RunOptions o = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1, .dry = true, .quiet = true,
                        .world = argv[i]};
        App app = {.fuel = -1, .script = argv[i]};
        if (strcmp(argv[i], "--") == 0)
            continue;
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return print_help("check");
        if (argv[i][0] == '-' && argv[i][1])
            return usage_error("check: unknown option '%s'", argv[i]);
        int code = run_world(&o, &app);
        if (code == EXIT_FINE)
            printf("%s: ok\n", argv[i]);
        worst = code > worst ? code : worst;
    }
    return flush_output(worst);
}

/* ---- commands ------------------------------------------------------------------------ */

static const struct { const char *name; int (*run)(int argc, char **argv); } commands[] = {
    {"run", command_run}, {"test", command_test}, {"check", command_check}, {"cost", command_cost},
    {"verify", command_verify},
};
enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

int main(int argc, char **argv)
{
    const char *names[COMMAND_COUNT];
    const char *word = argc > 1 ? argv[1] : "";
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0)
        return print_help(argc > 2 ? argv[2] : NULL);
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        printf("digbox %s\n", DIGBOX_VERSION);
        return flush_output(EXIT_FINE);
    }
    /* llvmpipe with vectors of 512 bits crashes on multisampled pictures; its own choice, 256, works everywhere. */
    const char *width = getenv("LP_NATIVE_VECTOR_WIDTH");
    if (width && strcmp(width, "512") == 0)
        unsetenv("LP_NATIVE_VECTOR_WIDTH");
    app_catch_signals();
    for (int i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(word, commands[i].name) == 0) {
            argv[1] = argv[0];
            return commands[i].run(argc - 1, argv + 1);
        }
        names[i] = commands[i].name;
    }
    if (!*word)
        return usage_error("what shall be done? (digbox run WORLD.lua)");
    const char *near = dig_suggest(word, names, COMMAND_COUNT);
    if (near)
        return usage_error("unknown command '%s' (did you mean '%s'?)", word, near);
    return usage_error("unknown command '%s'", word);
}
