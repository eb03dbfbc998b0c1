/* lua/sweep.c - `digbox sweep`, `digbox task` and `digbox merge`: one world with many arguments and seeds, each run a task of a plan.
 *
 * The texts (plan, results, summary, scripts for Slurm) are made in lua/digbox/sweep.lua; here processes are started and folders
 * renamed. A task works in N.tmp and is done when that has become N, so what was stopped is begun again and what is done is left.
 */

#define _XOPEN_SOURCE 700       /* nftw, setenv, dup2 */

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <lauxlib.h>

#include "bind.h"
#include "command.h"
#include "process.h"
#include "state.h"

enum { PATH_ROOM = 4096, JOB_LIMIT = 256 };

/* ---- what Lua knows of the plan ----------------------------------------------------- */

/* A state with lua/digbox/sweep.lua in it; NULL after a message. */
static lua_State *open_plans(App *app)
{
    *app = (App){.fuel = -1, .script = "", .trust = true};
    lua_State *L = app_open(app);
    if (!L)
        return NULL;
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    bind_use(L, "sweep");
    lua_settop(L, 0);
    return L;
}

/* core.name(...); after a failure its message is said. */
static int call(lua_State *L, App *app, const char *name, int arguments, int results)
{
    int code = app_call_core(L, app, name, arguments, results);
    if (code != EXIT_FINE)
        say_error(lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed");
    return code;
}

static int open_plan(lua_State *L, App *app, const char *path, long long *count)
{
    lua_pushstring(L, path);
    int code = call(L, app, "sweep_open", 1, 1);
    *count = code == EXIT_FINE ? lua_tointeger(L, -1) : 0;
    lua_settop(L, 0);
    return code;
}

static int merge_plan(lua_State *L, App *app)
{
    int code = call(L, app, "sweep_merge", 0, 3);
    if (code != EXIT_FINE)
        return code;
    code = (int)lua_tointeger(L, 1);
    fputs(lua_tostring(L, 2), stdout);
    for (lua_Integer i = 1; lua_rawgeti(L, 3, i) == LUA_TSTRING; i++, lua_pop(L, 1))
        say_error(lua_tostring(L, -1));
    lua_settop(L, 0);
    return code;
}

/* ---- one task ------------------------------------------------------------------------- */

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *where)
{
    (void)info, (void)kind, (void)where;
    return remove(path);
}

static bool remove_tree(const char *path)
{
    struct stat info;
    return lstat(path, &info) != 0 || nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS) == 0;
}

static int cannot(const char *path)
{
    fprintf(stderr, "digbox: %s: %s\n", path, strerror(errno));
    return EXIT_OUTPUT;
}

/* run(words), which begin with a place for the program, in a process of its own; what it says goes into the file. */
static int run_quietly(const char *log, int (*run)(int, char **), int count, char **words)
{
    fflush(NULL);
    int out = dup(1), err = dup(2), file = open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666), code = EXIT_OUTPUT;
    if (out >= 0 && err >= 0 && file >= 0 && dup2(file, 1) >= 0 && dup2(file, 2) >= 0) {
        optind = 0;         /* getopt begins anew */
        code = process_supervise(run, count, words);
    }
    fflush(NULL);
    dup2(out, 1);
    dup2(err, 2);
    close(out);
    close(err);
    close(file);
    return code;
}

/* The words of the list on top of the stack, after the name of the program; they live as long as it stays there. */
static char **words_of(lua_State *L, char *program, int *count)
{
    const int n = (int)lua_rawlen(L, -1), list = lua_gettop(L);
    char **words = calloc((size_t)n + 2, sizeof *words);
    luaL_checkstack(L, n, "a long task");
    if (!words)
        return NULL;
    words[0] = program;
    for (int i = 1; i <= n; i++) {
        lua_rawgeti(L, list, i);
        words[i] = (char *)(uintptr_t)lua_tostring(L, -1);
    }
    *count = n + 1;
    return words;
}

/* Works in N.tmp, which then becomes N. The folder and the words of the run are on the stack. */
static int work(lua_State *L, App *app, char *program, long long index)
{
    char folder[PATH_ROOM], draft[PATH_ROOM + 8], log[PATH_ROOM + 16];
    snprintf(folder, sizeof folder, "%s", lua_tostring(L, 1));
    snprintf(draft, sizeof draft, "%s.tmp", folder);
    snprintf(log, sizeof log, "%s/log.txt", draft);
    int count = 0;
    char **words = words_of(L, program, &count);
    if (!words)
        return EXIT_MEMORY;
    int code = remove_tree(draft) && mkdir(draft, 0777) == 0 ? EXIT_FINE : cannot(draft);
    const double begin = app_clock();
    if (code == EXIT_FINE)
        code = run_quietly(log, run_command.run, count, words);
    free(words);
    lua_settop(L, 0);
    if (code > 128 || code == EXIT_OUTPUT)
        return code;        /* not done: it is begun again */
    lua_pushinteger(L, index);
    lua_pushinteger(L, code);
    lua_pushnumber(L, app_clock() - begin);
    int kept = call(L, app, "sweep_result", 3, 0);
    if (kept != EXIT_FINE)
        return kept;
    return remove_tree(folder) && rename(draft, folder) == 0 ? code : cannot(folder);
}

static int do_task(lua_State *L, App *app, char *program, long long index)
{
    setenv("LP_NUM_THREADS", "0", 1);       /* tasks are beside each other already */
    lua_pushinteger(L, index);
    int code = call(L, app, "sweep_task", 1, 2);
    if (code == EXIT_FINE && !lua_isnil(L, 1))
        code = work(L, app, program, index);
    lua_settop(L, 0);
    return code;
}

/* ---- all tasks, here -------------------------------------------------------------------- */

static bool on_terminal(bool quiet)
{
    return !quiet && isatty(2) && !getenv("NO_COLOR");
}

static pid_t start_task(lua_State *L, App *app, char *program, long long index)
{
    const pid_t parent = getpid();
    fflush(NULL);
    pid_t pid = fork();
    if (pid < 0)
        fprintf(stderr, "digbox: cannot start a process: %s\n", strerror(errno));
    if (pid != 0)
        return pid;
    process_begin(parent);
    _exit(do_task(L, app, program, index));
}

/* `jobs` processes at a time. Failures stand in the results. */
static int run_here(lua_State *L, App *app, char *program, long long count, long long jobs, bool quiet)
{
    pid_t pids[JOB_LIMIT] = {0};
    long long next = 0, done = 0;
    int running = 0, told = 0, code = EXIT_FINE;
    while (running > 0 || (next < count && code == EXIT_FINE && !app_signal())) {
        for (int i = 0; i < jobs && next < count && code == EXIT_FINE && !app_signal(); i++)
            if (pids[i] == 0) {
                pids[i] = start_task(L, app, program, next++);
                code = pids[i] < 0 ? EXIT_INTERNAL : code;
                running += pids[i] > 0;
                pids[i] = pids[i] > 0 ? pids[i] : 0;
            }
        for (int i = 0; i < jobs; i++) {
            if (pids[i] > 0 && app_signal() && !told)
                kill(pids[i], app_signal());
            if (pids[i] > 0 && waitpid(pids[i], NULL, WNOHANG) == pids[i]) {
                pids[i] = 0;
                running--;
                if (++done && on_terminal(quiet))
                    fprintf(stderr, "\r%lld of %lld tasks \033[K", done, count);
            }
        }
        told = app_signal();
        nanosleep(&(struct timespec){0, 1000000}, NULL);
    }
    if (on_terminal(quiet))
        fputs("\r\033[K", stderr);
    return app_signal() ? 128 + app_signal() : code;
}

/* ---- digbox sweep ------------------------------------------------------------------------- */

typedef struct SweepOptions {
    const char *script, *out, *engine;
    long long   jobs, seeds;
    bool        quiet;
    int         set_count, option_count, argument_count;
    char      **set, **options, **arguments;    /* options: those for `digbox run` */
} SweepOptions;

static void push_words(lua_State *L, char **words, int count, const char *name)
{
    lua_createtable(L, count, 0);
    for (int i = 0; i < count; i++) {
        lua_pushstring(L, words[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, name);
}

static int make_plan(lua_State *L, App *app, const SweepOptions *o, long long *count, bool *fresh)
{
    char script[PATH_ROOM], *real_path = realpath(o->script, NULL);
    snprintf(script, sizeof script, "%s", real_path ? real_path : o->script);
    free(real_path);
    lua_createtable(L, 0, 6);
    bind_set_text(L, "script", script);
    bind_set_text(L, "out", o->out);
    lua_pushinteger(L, o->seeds);
    lua_setfield(L, -2, "seeds");
    push_words(L, o->set, o->set_count, "set");
    push_words(L, o->options, o->option_count, "options");
    push_words(L, o->arguments, o->argument_count, "arguments");
    int code = call(L, app, "sweep_plan", 1, 2);
    *count = code == EXIT_FINE ? lua_tointeger(L, -2) : 0;
    *fresh = code == EXIT_FINE && lua_toboolean(L, -1);
    lua_settop(L, 0);
    return code;
}

/* Says what was said last there. */
static void say_refusal(lua_State *L, App *app, const char *log)
{
    lua_settop(L, 0);
    lua_pushstring(L, log);
    if (call(L, app, "sweep_said", 1, 1) == EXIT_FINE)
        usage_error("sweep: %s", lua_tostring(L, -1));
}

/* Builds the world of the first task up to its first step: arguments that it does not know would fail in every task. Where they are refused,
 * or a signal stops it, the folder is as it was before the sweep. */
static int try_first(lua_State *L, App *app, const SweepOptions *o, char *program)
{
    char draft[PATH_ROOM], log[PATH_ROOM + 16];
    int count = 0;
    lua_pushinteger(L, 0);
    int code = call(L, app, "sweep_task", 1, 2);
    if (code != EXIT_FINE)
        return code;
    snprintf(draft, sizeof draft, "%.4000s.tmp", lua_tostring(L, 1));
    snprintf(log, sizeof log, "%s/log.txt", draft);
    char **words = words_of(L, program, &count);
    if (!words)
        return EXIT_MEMORY;
    if (remove_tree(draft) && mkdir(draft, 0777) == 0)
        code = run_quietly(log, run_dry, count, words);
    free(words);
    if (code == EXIT_USAGE)
        say_refusal(L, app, log);
    remove_tree(draft);
    lua_settop(L, 0);
    if (code != EXIT_USAGE && code <= 128)
        return EXIT_FINE;   /* other failures are the tasks' own */
    snprintf(draft, sizeof draft, "%.4000s/plan.jsonl", o->out);
    remove(draft);
    rmdir(o->out);          /* where nothing else is in it */
    return code;
}

/* The program, for the lines that others start. */
static const char *program_path(const char *argv0, char path[PATH_ROOM])
{
    ssize_t n = readlink("/proc/self/exe", path, PATH_ROOM - 1);
    if (n <= 0)
        return argv0;
    path[n] = '\0';
    return path;
}

static int submit(const char *script)
{
    fflush(NULL);
    pid_t pid = fork();
    if (pid == 0) {
        execlp("sh", "sh", script, (char *)NULL);
        _exit(127);
    }
    int status = 0;
    if (pid < 0 || waitpid(pid, &status, 0) != pid || !WIFEXITED(status))
        return EXIT_INTERNAL;
    return WEXITSTATUS(status) ? EXIT_INTERNAL : EXIT_FINE;
}

static int with_engine(lua_State *L, App *app, const SweepOptions *o, char *program, long long count)
{
    char path[PATH_ROOM];
    if (strcmp(o->engine, "local") == 0) {
        int code = run_here(L, app, program, count, o->jobs, o->quiet);
        return code == EXIT_FINE ? merge_plan(L, app) : code;
    }
    bool print = strcmp(o->engine, "print") == 0;
    lua_pushstring(L, program_path(program, path));
    lua_pushinteger(L, o->jobs);
    int code = call(L, app, print ? "sweep_print" : "sweep_slurm", 2, 1);
    if (code != EXIT_FINE || !print)
        return code == EXIT_FINE ? submit(lua_tostring(L, -1)) : code;
    fputs(lua_tostring(L, -1), stdout);
    return EXIT_FINE;
}

static int sweep(const SweepOptions *o, char *program)
{
    App app;
    long long count = 0;
    lua_State *L = open_plans(&app);
    if (!L)
        return EXIT_MEMORY;
    bool fresh = false;
    int code = make_plan(L, &app, o, &count, &fresh);
    if (code == EXIT_FINE && fresh)
        code = try_first(L, &app, o, program);
    if (code == EXIT_FINE)
        code = with_engine(L, &app, o, program, count);
    lua_close(L);
    return flush_output(code);
}

enum { OPT_SET = 256, OPT_SEEDS, OPT_ENGINE, OPT_SECONDS, OPT_ACCURACY, OPT_THREADS, OPT_TIME, OPT_MEMORY, OPT_FUEL, OPT_STRICT, OPT_TRUST,
       OPT_INDEX, OPT_STRIDE };

static const struct option sweep_options[] = {
    {"output", required_argument, NULL, 'o'}, {"set", required_argument, NULL, OPT_SET}, {"seeds", required_argument, NULL, OPT_SEEDS},
    {"engine", required_argument, NULL, OPT_ENGINE}, {"jobs", required_argument, NULL, 'j'}, {"quiet", no_argument, NULL, 'q'},
    {"seconds", required_argument, NULL, OPT_SECONDS}, {"accuracy", required_argument, NULL, OPT_ACCURACY},
    {"threads", required_argument, NULL, OPT_THREADS}, {"time-limit", required_argument, NULL, OPT_TIME},
    {"memory-limit", required_argument, NULL, OPT_MEMORY}, {"fuel", required_argument, NULL, OPT_FUEL},
    {"strict", no_argument, NULL, OPT_STRICT}, {"trust", no_argument, NULL, OPT_TRUST}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

/* An option that every run is given: its name with two dashes, and its value. */
static bool pass_option(SweepOptions *o, char *name, char *value)
{
    o->options[o->option_count++] = name;
    if (value)
        o->options[o->option_count++] = value;
    return true;
}

static bool read_passed_option(SweepOptions *o, int key)
{
    double number;
    long long whole;
    switch (key) {
    case OPT_SECONDS: return read_number_option("seconds", optarg, "s", 0, 1e9, &number) && pass_option(o, "--seconds", optarg);
    case OPT_ACCURACY: return read_accuracy_option(optarg) && pass_option(o, "--accuracy", optarg);
    case OPT_THREADS: return read_whole_option("threads", optarg, 1, 64, &whole) && pass_option(o, "--threads", optarg);
    case OPT_TIME: return read_number_option("time-limit", optarg, "s", 1e-3, 1e9, &number) && pass_option(o, "--time-limit", optarg);
    case OPT_MEMORY: return read_whole_option("memory-limit", optarg, 1, 1 << 20, &whole) && pass_option(o, "--memory-limit", optarg);
    case OPT_FUEL: return read_whole_option("fuel", optarg, 1, 1000000000000000000, &whole) && pass_option(o, "--fuel", optarg);
    case OPT_STRICT: return pass_option(o, "--strict", NULL);
    case OPT_TRUST: return pass_option(o, "--trust", NULL);
    default: return false;               /* next_option said why */
    }
}

static bool read_engine(SweepOptions *o)
{
    static const char *const names[] = {"local", "slurm", "print"};
    for (int i = 0; i < 3; i++)
        if (strcmp(optarg, names[i]) == 0) {
            o->engine = optarg;
            return true;
        }
    return usage_error("--engine: '%s' is not local, slurm or print", optarg) == 0;
}

static bool read_sweep_option(SweepOptions *o, int key)
{
    switch (key) {
    case 'o':
        o->out = optarg;
        if (*optarg && strlen(optarg) < PATH_ROOM - 64)
            return true;
        return usage_error("--output: the folder is %s", *optarg ? "too long" : "missing") == 0;
    case 'j': return read_whole_option("jobs", optarg, 1, JOB_LIMIT, &o->jobs);
    case 'q': o->quiet = true; return true;
    case OPT_SEEDS: return read_whole_option("seeds", optarg, 1, 1000000, &o->seeds);
    case OPT_ENGINE: return read_engine(o);
    case OPT_SET:
        if (!strchr(optarg, '=') || optarg[0] == '=')
            return usage_error("--set: '%s' is not NAME=VALUES", optarg) == 0;
        o->set[o->set_count++] = optarg;
        return true;
    default: return read_passed_option(o, key);
    }
}

static int command_sweep(int argc, char **argv)
{
    SweepOptions o = {.out = NULL, .engine = "local", .jobs = 1};
    RunOptions r = {0};
    int key, code = EXIT_USAGE;
    argc = cut_arguments(argc, argv, &r);
    o.arguments = r.arguments;
    o.argument_count = r.argument_count;
    argv[argc] = NULL;
    o.set = calloc(3 * (size_t)argc + 1, sizeof *o.set);
    if (!o.set)
        return EXIT_MEMORY;
    o.options = o.set + argc;
    while ((key = next_option("sweep", argc, argv, "o:j:qh", sweep_options)) != -1) {
        if (key == 'h') {
            code = print_help("sweep");
            goto done;
        }
        if (!read_sweep_option(&o, key))
            goto done;
    }
    if (optind >= argc) {
        usage_error("sweep: which world? (digbox sweep WORLD.lua --set NAME=A..B/N -o DIR)");
    } else if (optind + 1 < argc) {
        usage_error("sweep: one world at a time; '%s' is too many (arguments of the world stand after --)", argv[optind + 1]);
    } else if (!o.out) {
        usage_error("sweep: where to? (-o DIR)");
    } else if (o.set_count == 0 && o.seeds == 0) {
        usage_error("sweep: nothing is varied: --set NAME=A..B/N or --seeds N");
    } else {
        o.script = argv[optind];
        code = sweep(&o, argv[0]);
    }
done:
    free(o.set);
    return code;
}

const Command sweep_command = {
    .name = "sweep",
    .use = "  digbox sweep WORLD.lua --set NAME=A..B/N -o DIR [options] [-- ARGUMENTS]   one world with many arguments and seeds, a table\n",
    .options =
        "  -o, --output DIR        where the plan, a folder for each run, and summary.csv go\n"
        "      --set NAME=VALUES   A..B/N: N values from A to B; or A,B,C. Given again for another argument: every combination\n"
        "      --seeds N           each with the seeds 1 to N\n"
        "      --engine E          local: here; slurm: as an array of jobs; print: the lines for GNU parallel, xargs and mpirun\n"
        "  -j, --jobs N            so many at the same time (1)\n"
        "      --seconds N  --accuracy A  --threads N  --time-limit S  --memory-limit MiB  --fuel N  --strict  --trust   as for run\n"
        "  -q, --quiet             no progress line\n",
    .notes =
        "\n"
        "What the script returns (return { range = 3.2 }) becomes columns of summary.csv. A sweep that was stopped goes on where it\n"
        "was with the same command; runs that failed are taken again (docs/sweep.md).\n",
    .run = command_sweep,
    .starts_runs = true,
};

/* ---- digbox task ---------------------------------------------------------------------------- */

static const struct option task_options[] = {
    {"index", required_argument, NULL, OPT_INDEX}, {"stride", required_argument, NULL, OPT_STRIDE}, {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static int do_tasks(const char *path, char *program, long long index, long long stride)
{
    App app;
    long long count = 0;
    lua_State *L = open_plans(&app);
    if (!L)
        return EXIT_MEMORY;
    int worst = open_plan(L, &app, path, &count);
    do {
        int code = worst == EXIT_FINE || count > 0 ? do_task(L, &app, program, index) : worst;
        worst = code > worst ? code : worst;
        index += stride;
    } while (count > 0 && stride > 0 && index < count && !app_signal());
    lua_close(L);
    return flush_output(worst);
}

static int command_task(int argc, char **argv)
{
    long long index = -1, stride = 0;
    int key;
    while ((key = next_option("task", argc, argv, "h", task_options)) != -1)
        if (key == 'h')
            return print_help("task");
        else if (key == OPT_INDEX && !read_whole_option("index", optarg, 0, 1000000, &index))
            return EXIT_USAGE;
        else if (key == OPT_STRIDE && !read_whole_option("stride", optarg, 1, 1000000, &stride))
            return EXIT_USAGE;
        else if (key != OPT_INDEX && key != OPT_STRIDE)
            return EXIT_USAGE;
    if (argc - optind != 1)
        return usage_error("task: which plan? (digbox task DIR/plan.jsonl --index N)");
    if (index < 0)
        return usage_error("task: which of the plan? (--index N)");
    return do_tasks(argv[optind], argv[0], index, stride);
}

const Command task_command = {
    .name = "task",
    .use = "  digbox task PLAN --index N [--stride S]         one run of a sweep; with a stride also N + S, N + 2 S, ...\n",
    .options =
        "      --index N           which task of the plan, counted from 0\n"
        "      --stride S          and every S-th after it: so many of these share a plan\n",
    .notes =
        "\n"
        "PLAN is the plan.jsonl that digbox sweep wrote, or its folder. A task that is done is left alone. Exit code: that of the run,\n"
        "the greatest of several (docs/sweep.md).\n",
    .run = command_task,
    .starts_runs = true,
};

/* ---- digbox merge ----------------------------------------------------------------------------- */

static const struct option merge_options[] = {{"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};

static int command_merge(int argc, char **argv)
{
    int key;
    while ((key = next_option("merge", argc, argv, "h", merge_options)) != -1)
        return key == 'h' ? print_help("merge") : EXIT_USAGE;
    if (argc - optind != 1)
        return usage_error("merge: which plan? (digbox merge DIR/plan.jsonl)");
    App app;
    long long count = 0;
    lua_State *L = open_plans(&app);
    if (!L)
        return EXIT_MEMORY;
    int code = open_plan(L, &app, argv[optind], &count);
    if (code == EXIT_FINE)
        code = merge_plan(L, &app);
    lua_close(L);
    return flush_output(code);
}

const Command merge_command = {
    .name = "merge",
    .use = "  digbox merge PLAN                               what the runs of a sweep gave, as summary.csv; 1 when some are missing\n",
    .notes =
        "\n"
        "PLAN is the plan.jsonl that digbox sweep wrote, or its folder. summary.csv beside it gets a row for each task: arguments, seed, exit\n"
        "code, checksum, energies, and what the script returned. Which tasks failed or are missing is said (docs/sweep.md).\n",
    .run = command_merge,
};
