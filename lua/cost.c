/* lua/cost.c - `digbox cost`: the same world at every accuracy, each run in a process of its own, one at a time.
 *
 * Here are the options and the order of the runs; what a run keeps is in cost_run.c, what is made of it in cost_compare.c,
 * cost_report.c and cost_plot.c.
 */

#define _DEFAULT_SOURCE         /* MAP_ANONYMOUS */

#include "cost.h"

#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "process.h"
#include "state.h"

static const char *const plan_names[] = {"sketch", "play", "study", "reference"};
static const char *const ladder_names[] = {"1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9"};
enum { PLANS = 4, PLAY = 1, LADDER = 8 };

/* Short runs are repeated up to this much CPU time, s, in two rounds over all settings, and the fastest counts: single ones
 * differ by their cold start and by what else the machine does. */
static const real TIMED = 0.05;
enum { REPEATS = 4 };

static const real TWIN_ONE = 1e-9, TWIN_TWO = 1e-8;     /* of the bodies' size */

/* ---- one run, watched ------------------------------------------------------------ */

static const size_t RUN_BYTES = sizeof(CostRun) + COST_ROWS * sizeof(CostRow);

CostRun *cost_new_run(void)
{
    CostRun *r = mmap(NULL, RUN_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (r == MAP_FAILED) {
        fprintf(stderr, "digbox: cost: no memory\n");
        return NULL;
    }
    return r;
}

void cost_free_run(CostRun *run)
{
    if (run)
        munmap(run, RUN_BYTES);
}

static void child(const CostOptions *o, const char *accuracy, CostRun *run)
{
    RunOptions options = o->run;
    options.accuracy = accuracy;
    options.quiet = true;
    int nowhere = open("/dev/null", O_WRONLY);      /* what the script prints would be printed a dozen times */
    if (nowhere >= 0)
        dup2(nowhere, 1);
    run->code = cost_run_world(&options, run);
    _exit(run->code);
}

static bool on_terminal(const CostOptions *o)
{
    return !o->run.quiet && isatty(2) && !getenv("NO_COLOR");
}

static void show_progress(const CostOptions *o, const char *name, const CostRun *run)
{
    if (!on_terminal(o))
        return;
    fprintf(stderr, "\r%-10s t = %.2f s", name, run->steps * run->frame);
    if (run->expected > 0)
        fprintf(stderr, " of %.2f s", run->expected);
    fprintf(stderr, ", CPU %.1f s \033[K", run->cpu);
}

void cost_clear_progress(const CostOptions *o)
{
    if (on_terminal(o))
        fputs("\r\033[K", stderr);
}

/* Waits for the process. Returns the status of waitpid. */
static int watch(const CostOptions *o, pid_t pid, const char *name, const CostRun *run)
{
    const double begin = app_clock();
    double next = begin + 0.3;
    int status = 0;
    bool told = false;
    for (struct timespec pause = {0, 500000}; waitpid(pid, &status, WNOHANG) == 0; ) {
        if (app_signal() && !told) {
            kill(pid, app_signal());
            told = true;
        }
        if (app_clock() > next) {
            show_progress(o, name, run);
            next = app_clock() + 0.2;
            pause.tv_nsec = 20000000;
        }
        nanosleep(&pause, NULL);
    }
    return status;
}

static void judge_end(CostRun *run, const char *world, int status)
{
    if (WIFEXITED(status) && run->end != COST_RUNNING)
        return;
    bool late = WIFEXITED(status) && WEXITSTATUS(status) == EXIT_TIME;
    run->end = COST_FAILED;
    run->code = late ? EXIT_TIME : EXIT_INTERNAL;
    snprintf(run->message, sizeof run->message, late ? "%s: the script does not respond" : "%s: the run died", world);
}

/* Runs the world once; false when no process can be had. */
bool cost_run_once(const CostOptions *o, const char *accuracy, const char *name, CostRun *run)
{
    fflush(NULL);
    const pid_t parent = getpid();
    pid_t pid = fork();
    if (pid < 0) {
        fprintf(stderr, "digbox: cannot start a process: %s\n", strerror(errno));
        return false;
    }
    if (pid == 0) {
        process_begin(parent);
        child(o, accuracy, run);
    }
    judge_end(run, o->run.world, watch(o, pid, name, run));
    return true;
}

static void say_end(const CostOptions *o, const char *name, const CostRun *run)
{
    if (o->run.quiet)
        return;
    fprintf(stderr, "%s%-12s %.4g s simulated in %.4g s of CPU time", on_terminal(o) ? "\r\033[K" : "digbox: cost: ", name,
            run->steps * run->frame, run->cpu);
    fputs(run->end == COST_OVER_BUDGET ? ": over the budget, stopped\n" : run->end == COST_FAILED ? ": failed\n" : "\n", stderr);
}

/* A run, again when it was too short to be timed once. Returns an allocated record, or NULL. */
static CostRun *run_setting(const CostOptions *o, const char *accuracy, const char *name, real perturb, real expected)
{
    CostRun *shared = cost_new_run(), *kept = NULL;
    real fastest = INFINITY, sum = 0;
    for (int i = 0; shared && i < REPEATS; i++) {
        memset(shared, 0, sizeof *shared);
        shared->perturb = perturb;
        shared->budget = o->budget;
        shared->expected = expected;
        if (!cost_run_once(o, accuracy, name, shared))
            break;
        size_t bytes = sizeof *shared + (size_t)shared->count * sizeof(CostRow);
        if (shared->cpu < fastest || shared->end != COST_COMPLETE) {
            free(kept);
            kept = malloc(bytes);
            if (kept)
                memcpy(kept, shared, bytes);
            fastest = shared->cpu;
        }
        sum += shared->cpu;
        if (shared->end != COST_COMPLETE || perturb > 0 || sum > TIMED || app_signal())
            break;
    }
    cost_free_run(shared);
    return kept;
}

/* ---- all runs ---------------------------------------------------------------------- */

static void list_settings(Cost *c)
{
    for (int i = 0; i < PLANS; i++)
        c->settings[c->count++] = (CostSetting){.name = plan_names[i], .plan = true};
    for (int i = 0; i < LADDER; i++)
        c->settings[c->count++] = (CostSetting){.name = ladder_names[i]};
    c->play = PLAY;
}

static bool is_complete(const CostSetting *s)
{
    return s->run && s->run->end == COST_COMPLETE;
}

/* The finest plan and the finest number that are complete; of the two, the one that takes more work, if they differ. */
static int choose_reference(const Cost *c)
{
    int plan = -1, number = -1;
    for (int i = 0; i < c->count; i++)
        if (is_complete(&c->settings[i]))
            *(c->settings[i].plan ? &plan : &number) = i;
    if (plan < 0 || number < 0)
        return plan < 0 ? number : plan;
    CostError e;
    cost_compare(c->settings[plan].run, c->settings[number].run, INFINITY, 1, &e);
    if (e.max <= 0 && e.missing == 0)
        return plan;
    return c->settings[plan].run->cpu > c->settings[number].run->cpu ? plan : number;
}

/* Runs one setting. Returns an exit code that ends everything, or EXIT_FINE. */
static int take(Cost *c, int index, real expected)
{
    CostSetting *s = &c->settings[index];
    s->run = run_setting(c->o, s->name, s->name, 0, expected);
    if (!s->run)
        return EXIT_INTERNAL;
    if (s->run->steps > 0 || s->run->end != COST_FAILED)       /* else its message says all */
        say_end(c->o, s->name, s->run);
    if (app_signal())
        return 128 + app_signal();
    if (index != c->play || s->run->end != COST_FAILED)
        return EXIT_FINE;
    say_error(s->run->message);
    return s->run->code ? s->run->code : EXIT_INTERNAL;
}

/* Every setting; those finer than one that is over the budget are left out. */
static int take_all(Cost *c)
{
    int code = take(c, c->play, c->o->run.seconds > 0 ? c->o->run.seconds : 0);
    if (code != EXIT_FINE)
        return code;
    const CostRun *play = c->settings[c->play].run;
    real expected = play->end == COST_COMPLETE ? play->steps * play->frame : fmax(0, c->o->run.seconds);
    bool over_plan = false, over_number = false;
    for (int i = 0; i < c->count && code == EXIT_FINE; i++) {
        bool *over = c->settings[i].plan ? &over_plan : &over_number;
        if (i != c->play && !*over)
            code = take(c, i, expected);
        *over = *over || (c->settings[i].run && c->settings[i].run->end == COST_OVER_BUDGET);
    }
    return code;
}

/* The second round. */
static int time_again(Cost *c)
{
    for (int i = 0; i < c->count && !app_signal(); i++) {
        CostSetting *s = &c->settings[i];
        if (!is_complete(s) || s->run->cpu >= TIMED)
            continue;
        CostRun *again = run_setting(c->o, s->name, s->name, 0, s->run->steps * s->run->frame);
        if (!again || again->end != COST_COMPLETE || again->cpu >= s->run->cpu) {
            free(again);
            continue;
        }
        free(s->run);
        s->run = again;
    }
    return app_signal() ? 128 + app_signal() : EXIT_FINE;
}

static int take_twins(Cost *c)
{
    const CostSetting *finest = &c->settings[c->reference];
    real expected = finest->run->steps * finest->run->frame;
    CostRun *one = run_setting(c->o, finest->name, "twin 1e-9", TWIN_ONE, expected), *two = NULL;
    if (one && !app_signal()) {
        say_end(c->o, "twin 1e-9", one);
        two = run_setting(c->o, finest->name, "twin 1e-8", TWIN_TWO, expected);
    }
    if (two && !app_signal())
        say_end(c->o, "twin 1e-8", two);
    if (one && two && one->end != COST_FAILED && two->end != COST_FAILED)
        cost_twins(one, two, &c->twins);
    free(one);
    free(two);
    return app_signal() ? 128 + app_signal() : EXIT_FINE;
}

static bool make_folder(const char *path)
{
    char part[1024];
    snprintf(part, sizeof part, "%s/", path);
    for (char *p = strchr(part + 1, '/'); p; p = strchr(p + 1, '/')) {
        *p = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST) {
            fprintf(stderr, "digbox: %s: %s\n", part, strerror(errno));
            return false;
        }
        *p = '/';
    }
    return true;
}

static int measure(Cost *c)
{
    char path[1100];
    if (!make_folder(c->o->run.out))
        return EXIT_OUTPUT;
    if (c->o->effects)
        return cost_effects(c->o);
    int code = take_all(c);
    if (code == EXIT_FINE)
        code = time_again(c);
    if (code != EXIT_FINE)
        return code;
    c->reference = choose_reference(c);
    if (c->reference < 0) {
        fprintf(stderr, "digbox: cost: no setting finishes this world within %g s of CPU time; --seconds N makes it shorter, "
                "--budget S gives it more\n", c->o->budget);
        return EXIT_TIME;
    }
    if (c->settings[c->reference].run->moving > 0)
        code = take_twins(c);
    if (code != EXIT_FINE)
        return code;
    cost_judge(c);
    cost_print(c);
    snprintf(path, sizeof path, "%s/cost.csv", c->o->run.out);
    code = cost_write_csv(c, path);
    return code == EXIT_FINE ? cost_plot(c, c->o->run.out) : code;
}

/* ---- options ------------------------------------------------------------------------- */

enum { OPT_SECONDS = 256, OPT_WITHIN, OPT_BUDGET, OPT_SEED, OPT_THREADS, OPT_SET, OPT_MEMORY, OPT_TRUST, OPT_EFFECTS };

static const struct option cost_options[] = {
    {"output", required_argument, NULL, 'o'}, {"seconds", required_argument, NULL, OPT_SECONDS},
    {"within", required_argument, NULL, OPT_WITHIN}, {"budget", required_argument, NULL, OPT_BUDGET},
    {"seed", required_argument, NULL, OPT_SEED}, {"threads", required_argument, NULL, OPT_THREADS},
    {"set", required_argument, NULL, OPT_SET}, {"memory-limit", required_argument, NULL, OPT_MEMORY},
    {"trust", no_argument, NULL, OPT_TRUST}, {"effects", no_argument, NULL, OPT_EFFECTS},
    {"quiet", no_argument, NULL, 'q'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
};

static bool read_option(CostOptions *o, int key)
{
    RunOptions *r = &o->run;
    switch (key) {
    case 'o':
        r->out = optarg;
        if (*optarg && strlen(optarg) < 1000)
            return true;
        return usage_error("--output: the folder is %s", *optarg ? "too long" : "missing") == 0;
    case 'q': r->quiet = true; return true;
    case OPT_SECONDS: return read_number_option("seconds", optarg, "s", 1e-6, 1e9, &r->seconds);
    case OPT_WITHIN: return read_number_option("within", optarg, "m", 1e-15, 1e9, &o->within);
    case OPT_BUDGET: return read_number_option("budget", optarg, "s", 1e-3, 1e9, &o->budget);
    case OPT_SEED: return read_whole_option("seed", optarg, -9000000000000000000, 9000000000000000000, &r->seed);
    case OPT_THREADS: return read_whole_option("threads", optarg, 1, 64, &r->threads);
    case OPT_MEMORY: return read_whole_option("memory-limit", optarg, 1, 1 << 20, &r->memory);
    case OPT_TRUST: r->trust = true; return true;
    case OPT_EFFECTS: o->effects = true; return true;
    case OPT_SET:
        if (!strchr(optarg, '=') || optarg[0] == '=')
            return usage_error("--set: '%s' is not NAME=VALUE", optarg) == 0;
        r->set[r->set_count++] = optarg;
        return true;
    default: return false;               /* next_option said why */
    }
}

static int command_cost(int argc, char **argv)
{
    CostOptions o = {.run = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1}, .budget = 10, .within = 1e-3};
    Cost c = {.o = &o, .reference = -1};
    int key, code = EXIT_USAGE;
    argc = cut_arguments(argc, argv, &o.run);
    o.run.set = calloc((size_t)argc + 1, sizeof *o.run.set);
    if (!o.run.set)
        return EXIT_MEMORY;
    argv[argc] = NULL;
    while ((key = next_option("cost", argc, argv, "o:qh", cost_options)) != -1) {
        if (key == 'h') {
            code = print_help("cost");
            goto done;
        }
        if (!read_option(&o, key))
            goto done;
    }
    if (optind >= argc) {
        usage_error("cost: which world? (digbox cost WORLD.lua)");
    } else if (optind + 1 < argc) {
        usage_error("cost: one world at a time; '%s' is too many (arguments of the world stand after --)", argv[optind + 1]);
    } else {
        o.run.world = argv[optind];
        list_settings(&c);
        code = flush_output(measure(&c));
    }
    for (int i = 0; i < c.count; i++)
        free(c.settings[i].run);
done:
    free(o.run.set);
    return code;
}

const Command cost_command = {
    .name = "cost",
    .use = "  digbox cost WORLD.lua [options] [-- ARGUMENTS]  what accuracy costs in time: error against CPU time, table and plot\n",
    .options =
        "  -o, --output DIR        where cost.csv, cost.gp, cost.svg and cost.png go (default out)\n"
        "      --seconds N         simulate to t = N s (default: as long as the script runs, else 10 s)\n"
        "      --effects           what each effect costs instead, as bars: effects.csv, effects.svg and effects.png\n"
        "      --within LENGTH     the error that the closing sentence is about (default 1 mm)\n"
        "      --budget S          CPU time that one run may use; settings beyond it are left out (default 10 s)\n"
        "      --seed N  --threads N  --set NAME=VALUE  --memory-limit MiB  --trust  -q, --quiet   as for run\n",
    .notes =
        "\n"
        "The world runs at sketch, play, study and reference and at tolerances from 1e-2 to 1e-9 m, from the same start, without\n"
        "pictures. The finest run that keeps its budget is the reference. The error of a setting is the largest difference of any\n"
        "body's position, or rotation times half its size, after any frame. CPU time is that of the frame steps alone, without the\n"
        "script. Measured is the first world that takes a step. Two more runs begin 1e-9 and 1e-8 of a body's size aside: where\n"
        "they part, the world is chaotic, and errors end there.\n",
    .run = command_cost,
    .starts_runs = true,
};
