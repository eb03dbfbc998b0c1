/* lua/run.c - `digbox run` and `digbox check`: a world script, its options, and what is said when it ends. */

#define _XOPEN_SOURCE 700       /* isatty, strdup */

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <lauxlib.h>

#include "command.h"
#include "process.h"
#include "state.h"

/* ---- run ----------------------------------------------------------------------- */

enum { OPT_SECONDS = 256, OPT_ACCURACY, OPT_SEED, OPT_THREADS, OPT_SET, OPT_TIME, OPT_MEMORY, OPT_FUEL, OPT_TRUST, OPT_STRICT,
       OPT_TRACE, OPT_JAIL, OPT_VERBOSE, OPT_LOG, OPT_REPLAY, OPT_RESUME, OPT_FORCE, OPT_INJECT, OPT_RESULT };

static const struct option run_options[] = {
    {"output", required_argument, NULL, 'o'}, {"seconds", required_argument, NULL, OPT_SECONDS},
    {"accuracy", required_argument, NULL, OPT_ACCURACY}, {"seed", required_argument, NULL, OPT_SEED},
    {"threads", required_argument, NULL, OPT_THREADS}, {"set", required_argument, NULL, OPT_SET},
    {"time-limit", required_argument, NULL, OPT_TIME}, {"memory-limit", required_argument, NULL, OPT_MEMORY},
    {"fuel", required_argument, NULL, OPT_FUEL}, {"trust", no_argument, NULL, OPT_TRUST},
    {"strict", no_argument, NULL, OPT_STRICT}, {"trace", required_argument, NULL, OPT_TRACE},
    {"replay", required_argument, NULL, OPT_REPLAY}, {"result", required_argument, NULL, OPT_RESULT}, {"quiet", no_argument, NULL, 'q'},
    {"require-jail", no_argument, NULL, OPT_JAIL}, {"verbose", no_argument, NULL, OPT_VERBOSE},
    {"resume", no_argument, NULL, OPT_RESUME}, {"force", no_argument, NULL, OPT_FORCE},
    {"log-limit", required_argument, NULL, OPT_LOG}, {"inject", required_argument, NULL, OPT_INJECT}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

/* nan:body=7,step=60 */
static bool read_fault(RunOptions *o, const char *text)
{
    int end = 0;
    if (sscanf(text, "nan:body=%9lld,step=%18lld%n", &o->inject_body, &o->inject_step, &end) == 2 && text[end] == '\0' &&
        o->inject_body >= 0 && o->inject_step >= 0)
        return o->injects = true;
    return usage_error("--inject: '%s' is not nan:body=N,step=N", text) == 0;
}

static bool read_run_option(RunOptions *o, int key)
{
    switch (key) {
    case 'o': o->out = optarg; return *optarg || usage_error("--output: the folder is missing") == 0;
    case 'q': o->quiet = true; return true;
    case OPT_SECONDS: return read_number_option("seconds", optarg, "s", 0, 1e9, &o->seconds);
    case OPT_ACCURACY: o->accuracy = optarg; return read_accuracy_option(optarg);
    case OPT_SEED: return read_whole_option("seed", optarg, -9000000000000000000, 9000000000000000000, &o->seed);
    case OPT_THREADS: return read_whole_option("threads", optarg, 1, 64, &o->threads);
    case OPT_TIME: return read_number_option("time-limit", optarg, "s", 1e-3, 1e9, &o->time_limit);
    case OPT_MEMORY: return read_whole_option("memory-limit", optarg, 1, 1 << 20, &o->memory);
    case OPT_FUEL: return read_whole_option("fuel", optarg, 1, 1000000000000000000, &o->fuel);
    case OPT_TRUST: o->trust = true; return true;
    case OPT_JAIL: o->jail_needed = true; return true;
    case OPT_VERBOSE: o->verbose = true; return true;
    case OPT_INJECT: return read_fault(o, optarg);
    case OPT_LOG: return read_whole_option("log-limit", optarg, 0, 1 << 20, &o->log_limit);
    case OPT_STRICT: o->strict = true; return true;
    case OPT_RESUME: o->resume = true; return true;
    case OPT_FORCE: o->force = true; return true;
    case OPT_TRACE: o->trace = optarg; return *optarg || usage_error("--trace: the file is missing") == 0;
    case OPT_RESULT: o->result = optarg; return *optarg || usage_error("--result: the file is missing") == 0;
    case OPT_REPLAY: o->replay = optarg; return *optarg || usage_error("--replay: the file is missing") == 0;
    case OPT_SET:
        if (!strchr(optarg, '=') || optarg[0] == '=')
            return usage_error("--set: '%s' is not NAME=VALUE", optarg) == 0;
        o->set[o->set_count++] = optarg;
        return true;
    default: return false;               /* next_option said why */
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

static void set_flag(lua_State *L, const char *name, bool on)
{
    lua_pushboolean(L, on);
    app_set_option(L, name);
}

int run_set_options(lua_State *L)
{
    const RunOptions *o = lua_touserdata(L, 1);
    char *end;
    set_text(L, "mode", o->dry ? "check" : "run");
    set_text(L, "out", o->out);
    set_flag(L, "trust", o->trust);
    set_flag(L, "dry", o->dry);
    set_flag(L, "progress", !o->quiet && isatty(2) && !getenv("NO_COLOR"));
    set_flag(L, "quiet", o->quiet);
    set_flag(L, "resume", o->resume);
    set_flag(L, "force", o->force);
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
    if (o->injects) {
        lua_createtable(L, 0, 2);
        lua_pushinteger(L, o->inject_body);
        lua_setfield(L, -2, "body");
        lua_pushinteger(L, o->inject_step);
        lua_setfield(L, -2, "step");
        app_set_option(L, "inject");
    }
    push_settings(L, o);
    app_set_option(L, "set");
    push_list(L, o->arguments, o->argument_count);
    app_set_option(L, "args");
    return 0;
}

/* After the script: the rest of --seconds, open films, the picture of the end. Then it has come to its end, whatever is to be said of it. */
static int finish_run(lua_State *L, App *app, const RunOptions *o, bool *ended)
{
    int code = app_call_core(L, app, "finish_run", 0, 0);
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "finish_replay", 0, 0);
    if (code == EXIT_FINE && o->result) {
        lua_pushstring(L, o->result);
        code = app_call_core(L, app, "finish_result", 1, 0);
    }
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
    *ended = code == EXIT_FINE;
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "judge_finite", 0, 0);
    if (code == EXIT_FINE && o->strict)
        code = app_call_core(L, app, "judge_reliable", 0, 0);
    return code;
}

static void report_stop(lua_State *L, App *app)
{
    app_lift_limits(app);
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
    bool ended = false;
    int code = app_call(L, app, 1, 0);
    if (code == EXIT_FINE)
        code = app_run_file(L, app);
    if (o->verbose && app->fuel >= 0)
        fprintf(stderr, "digbox: fuel: %lld used\n", app->fuel_given - app->fuel);
    if (code == EXIT_FINE)
        code = o->dry ? app_call_core(L, app, "judge_arguments", 0, 0) : finish_run(L, app, o, &ended);
    if (app_call_core(L, app, "clear_progress", 0, 0) != EXIT_FINE)
        lua_pop(L, 1);
    if (code != EXIT_FINE && lua_isstring(L, -1))
        say_error(lua_tostring(L, -1));
    if (code != EXIT_FINE && !ended)
        report_stop(L, app);
    lua_close(L);
    return code;
}

/* dry: the world is built up to its first step, as `digbox check` does. */
static int run_with(int argc, char **argv, bool dry)
{
    RunOptions o = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1, .log_limit = 1, .dry = dry};
    int key, code = EXIT_USAGE;
    argc = cut_arguments(argc, argv, &o);
    o.set = calloc((size_t)argc + 1, sizeof *o.set);
    if (!o.set) {
        say_error("no memory");
        return EXIT_MEMORY;
    }
    argv[argc] = NULL;
    while ((key = next_option("run", argc, argv, "o:qh", run_options)) != -1) {
        if (key == 'h') {
            code = print_help("run");
            goto done;
        }
        if (!read_run_option(&o, key))
            goto done;
    }
    if (o.resume && o.force) {
        usage_error("run: --resume keeps frames, --force does not: one of them");
    } else if (optind >= argc) {
        usage_error("run: which world? (digbox run WORLD.lua)");
    } else if (optind + 1 < argc) {
        usage_error("run: one world at a time; '%s' is too many (arguments of the world stand after --)", argv[optind + 1]);
    } else {
        o.world = argv[optind];
        App app = {.memory_limit = (size_t)o.memory << 20, .fuel = o.fuel, .trust = o.trust, .script = o.world, .out = o.out,
                   .also = {o.trace, o.replay, o.result}, .jailed = true, .jail_needed = o.jail_needed, .jail_said = o.verbose,
                   .log_limit = o.trust ? 0 : (size_t)o.log_limit << 20};
        if (o.time_limit > 0)
            app_limit_time(&app, o.time_limit);
        code = flush_output(run_world(&o, &app));
    }
done:
    free(o.set);
    return code;
}

static int command_run(int argc, char **argv)
{
    return run_with(argc, argv, false);
}

int run_dry(int argc, char **argv)
{
    return run_with(argc, argv, true);
}

const Command run_command = {
    .name = "run",
    .use = "  digbox run WORLD.lua [options] [-- ARGUMENTS]   run a world; a picture of its end when it records nothing\n",
    .options =
        "  -o, --output DIR        where pictures go (default out)\n"
        "      --resume            frames of the same run that are there and whole are not drawn again (docs/frames.md)\n"
        "      --force             films that are there are taken anew\n"
        "      --seconds N         simulate to t = N s, whatever the world asks for\n"
        "      --accuracy A        sketch, play, study, reference, or a tolerance in metres\n"
        "      --seed N            seed of the world and of math.random\n"
        "      --threads N         1 to 64; the result is the same for any number\n"
        "      --set NAME=VALUE    an argument that the world declares (digbox.args); so does -- --NAME VALUE\n"
        "      --time-limit S      stop after S seconds of wall time (exit code 5)\n"
        "      --memory-limit MiB  memory that the script may use (exit code 3)\n"
        "      --fuel N            Lua instructions, and work of the engine, that the script may use (exit code 4)\n"
        "      --log-limit MiB     text that the script may print (default 1; 0 = without limit)\n"
        "      --require-jail      do not run where the kernel lacks seccomp or landlock (docs/security.md)\n"
        "      --verbose           say which of them hold, and with --fuel how much was used\n"
        "      --trust             the script may use io and os, and write anywhere\n"
        "      --replay FILE       keep the run in a file: to draw, compare and export it without simulating again\n"
        "      --result FILE       as JSON: checksum, energies, and what the script returned (return { range = 3.2 })\n"
        "      --trace FILE        what each step spent its time on, for chrome://tracing or ui.perfetto.dev\n"
        "      --inject nan:body=N,step=K   for tests: after step K, a number of body #N is not finite (exit code 10)\n"
        "      --strict            a run that became unreliable ends with exit code 12\n"
        "  -q, --quiet             no progress line, no warnings, no closing line\n",
    .notes = "\nThe arguments that a world declares: digbox run WORLD.lua -- --help\n",
    .run = command_run,
};

/* ---- check ------------------------------------------------------------------------ */

/* argv[1]: one file, in a process of its own */
static int check_file(int argc, char **argv)
{
    RunOptions o = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1, .dry = true, .quiet = true, .world = argv[1]};
    App app = {.fuel = -1, .script = argv[1], .jailed = true, .log_limit = 1 << 20};
    (void)argc;
    int code = run_world(&o, &app);
    if (code == EXIT_FINE)
        printf("%s: ok\n", argv[1]);
    return flush_output(code);
}

static int command_check(int argc, char **argv)
{
    int worst = EXIT_FINE;
    if (argc < 2)
        return usage_error("check: which files? (digbox check FILE...)");
    for (int i = 1; i < argc; i++) {
        char *one[] = {argv[0], argv[i], NULL};
        if (strcmp(argv[i], "--") == 0)
            continue;
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return print_help("check");
        if (argv[i][0] == '-' && argv[i][1])
            return usage_error("check: unknown option '%s'", argv[i]);
        int code = process_supervise(check_file, 2, one);
        worst = code > worst ? code : worst;
        if (code > 128)
            break;
    }
    return worst;
}

const Command check_command = {
    .name = "check",
    .use = "  digbox check FILE...                            compile, and build the world up to its first step\n",
    .notes =
        "\n"
        "Each file runs shut in, as with digbox run, until it asks for the first step: nothing is simulated, drawn or written. Says `FILE: ok`,\n"
        "or what is wrong and in which line. Exit code 0: all are fine, else the greatest of those of the files.\n",
    .run = command_check,
    .starts_runs = true,
};
