/* lua/test.c - the command `digbox test`: finds specs, runs each scenario in a process of its own, reports.
 *
 * A child loads the spec and runs one scenario, so a crash, a hang or an endless print costs one scenario. Children write to
 * unnamed temporary files; results are printed in the order of the list, whatever finishes first.
 */

#define _XOPEN_SOURCE 700       /* fork, waitpid, scandir, kill */

#include <dirent.h>
#include <errno.h>
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

#include "command.h"
#include "process.h"
#include "state.h"

enum { DEPTH_LIMIT = 20, OUTPUT_SHOWN = 4000, JOB_LIMIT = 256 };

typedef struct TestOptions {
    const char *out, *pattern, *junit;
    double      time_limit;     /* s, for one scenario */
    double      sim_limit;      /* s of simulated time, for one scenario; 0 = none */
    long long   jobs;
    bool        tap, update_goldens;
} TestOptions;

typedef struct Job {
    char  *file, *name;         /* name NULL: the file itself could not be loaded or holds no scenario */
    int    index;               /* of the scenario in its file, from 1 */
    pid_t  pid;                 /* > 0 while it runs */
    FILE  *output, *result;     /* what it printed; its report */
    double begin, seconds;
    int    code;                /* exit code */
    bool   done;
    char  *text, *printed;
} Job;

typedef struct Run {
    TestOptions o;
    Job   *jobs;
    int    count, capacity;
    char **files;
    int    file_count, file_capacity;
} Run;

/* ---- small things that cannot fail quietly -------------------------------------- */

static void *need(void *block)
{
    if (!block) {
        fputs("digbox: no memory\n", stderr);
        _exit(EXIT_MEMORY);
    }
    return block;
}

static char *copy_text(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(need(malloc(size)), text, size);
}

static char *read_all(FILE *f)
{
    long size = f && fseek(f, 0, SEEK_END) == 0 ? ftell(f) : 0;
    char *text = need(calloc(1, (size_t)(size > 0 ? size : 0) + 1));
    if (size > 0 && fseek(f, 0, SEEK_SET) == 0)
        text[fread(text, 1, (size_t)size, f)] = '\0';
    return text;
}

static FILE *temporary_file(void)
{
    FILE *f = tmpfile();
    if (!f) {
        fprintf(stderr, "digbox: no temporary file: %s\n", strerror(errno));
        exit(EXIT_OUTPUT);
    }
    return f;
}

/* ---- finding specs ------------------------------------------------------------------ */

static void add_file(Run *r, const char *path)
{
    if (r->file_count == r->file_capacity) {
        r->file_capacity = r->file_capacity * 2 + 16;
        r->files = need(realloc(r->files, (size_t)r->file_capacity * sizeof *r->files));
    }
    r->files[r->file_count++] = copy_text(path);
}

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

/* *_spec.lua, and every other Lua file that asks for the kit */
static bool holds_scenarios(const char *path)
{
    if (!ends_with(path, ".lua") || ends_with(path, ".d.lua"))          /* .d.lua: for editors */
        return false;
    if (ends_with(path, "_spec.lua"))
        return true;
    FILE *f = fopen(path, "rb");
    if (!f)
        return false;
    char *text = read_all(f);
    bool found = strstr(text, "digbox.test") != NULL;
    free(text);
    fclose(f);
    return found;
}

static void search_folder(Run *r, const char *folder, int depth)
{
    struct dirent **entries;
    int n = depth < DEPTH_LIMIT ? scandir(folder, &entries, NULL, alphasort) : -1;
    for (int i = 0; i < n; i++) {
        const char *name = entries[i]->d_name;
        char path[4096];
        struct stat info;
        bool skip = name[0] == '.' || strcmp(name, "build") == 0 || strcmp(name, "out") == 0;
        int length = snprintf(path, sizeof path, "%s/%s", folder, name);
        if (!skip && length < (int)sizeof path && stat(path, &info) == 0) {
            if (S_ISDIR(info.st_mode))
                search_folder(r, path, depth + 1);
            else if (S_ISREG(info.st_mode) && holds_scenarios(path))
                add_file(r, path);
        }
        free(entries[i]);
    }
    if (n >= 0)
        free(entries);
}

static bool add_path(Run *r, const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0) {
        usage_error("test: %s: %s", path, strerror(errno));
        return false;
    }
    if (S_ISDIR(info.st_mode))
        search_folder(r, path, 0);
    else
        add_file(r, path);
    return true;
}

/* ---- in the child ----------------------------------------------------------------------- */

static void set_text(lua_State *L, const char *name, const char *text)
{
    lua_pushstring(L, text);
    app_set_option(L, name);
}

static int set_options(lua_State *L)
{
    const TestOptions *o = lua_touserdata(L, 1);
    set_text(L, "mode", "test");
    set_text(L, "out", o->out);
    lua_pushboolean(L, o->update_goldens);
    app_set_option(L, "update_goldens");
    if (o->sim_limit > 0) {
        lua_pushnumber(L, o->sim_limit);
        app_set_option(L, "sim_limit");
    }
    return 0;
}

/* Loads the spec. On failure the text is on the stack. */
static int load_spec(lua_State *L, App *app, const TestOptions *o)
{
    lua_pushcfunction(L, set_options);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    int code = app_call(L, app, 1, 0);
    return code == EXIT_FINE ? app_run_file(L, app) : code;
}

/* Pushes core.scenarios, or an empty table when the kit was never asked for. */
static int push_scenarios(lua_State *L)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    if (lua_getfield(L, -1, "scenarios") != LUA_TTABLE) {
        lua_pop(L, 1);
        lua_newtable(L);
    }
    lua_remove(L, -2);
    return (int)lua_rawlen(L, -1);
}

/* Writes the names, one a line. */
static int child_lists(lua_State *L, App *app, const TestOptions *o, FILE *result)
{
    int code = load_spec(L, app, o);
    if (code != EXIT_FINE) {
        fputs(lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed", result);
        return code;
    }
    int n = push_scenarios(L);
    for (int i = 1; i <= n; i++) {
        lua_rawgeti(L, -1, i);
        lua_getfield(L, -1, "name");
        for (const char *p = lua_tostring(L, -1); *p; p++)
            fputc((unsigned char)*p < 0x20 ? ' ' : *p, result);
        fputc('\n', result);
        lua_pop(L, 2);
    }
    return EXIT_FINE;
}

/* Runs one scenario, which writes what there is to say by core.report. */
static int child_runs(lua_State *L, App *app, const TestOptions *o, int index, FILE *result)
{
    int code = load_spec(L, app, o);
    if (code == EXIT_FINE) {
        push_scenarios(L);
        lua_rawgeti(L, -1, index);
        code = app_call_core(L, app, "run_scenario", 1, 1);
    }
    if (code != EXIT_FINE) {
        fputs(lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed", result);
        return code;
    }
    return lua_toboolean(L, -1) ? EXIT_FINE : EXIT_SCENARIO;
}

/* A limit has tripped: its line is the report, or comes behind that of a failure before. */
static void report_stop(void *data, int code, const char *text)
{
    FILE *result = data;
    (void)code;
    fprintf(result, "%s%s", ftell(result) > 0 ? "\n" : "", text);
    fflush(result);
}

/* core.report(text): what the program's own Lua has to add to it */
static int add_report(lua_State *L)
{
    FILE *result = lua_touserdata(L, lua_upvalueindex(1));
    fputs(luaL_checkstring(L, 1), result);
    fflush(result);
    return 0;
}

static void give_report(lua_State *L, FILE *result)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_pushlightuserdata(L, result);
    lua_pushcclosure(L, add_report, 1);
    lua_setfield(L, -2, "report");
    lua_pop(L, 1);
}

static void run_child(const TestOptions *o, const char *file, int index, FILE *output, FILE *result)
{
    App app = {.fuel = -1, .script = file, .jailed = true, .out = o->out, .also = {o->update_goldens ? file : NULL},
               .log_limit = 1 << 20, .stopped = report_stop, .stopped_data = result};
    app_limit_time(&app, o->time_limit);
    dup2(fileno(output), 1);
    dup2(fileno(output), 2);
    lua_State *L = app_open(&app);
    int code = EXIT_INTERNAL;
    if (L) {
        give_report(L, result);
        code = index == 0 ? child_lists(L, &app, o, result) : child_runs(L, &app, o, index, result);
        app_lift_limits(&app);
        if (app_call_core(L, &app, "close_films", 0, 0) != EXIT_FINE)
            lua_pop(L, 1);
        lua_close(L);
    }
    fclose(result);
    exit(code);
}

/* ---- in the parent ------------------------------------------------------------------------- */

static void start(const TestOptions *o, Job *job)
{
    job->output = temporary_file();
    job->result = temporary_file();
    job->begin = app_clock();
    fflush(NULL);
    const pid_t parent = getpid();
    job->pid = fork();
    if (job->pid < 0) {
        fprintf(stderr, "digbox: cannot start a process: %s\n", strerror(errno));
        exit(EXIT_INTERNAL);
    }
    if (job->pid == 0) {
        process_begin(parent);
        run_child(o, job->file, job->index, job->output, job->result);
    }
}

static void finish(Job *job, int status, double limit)
{
    job->seconds = app_clock() - job->begin;
    job->done = true;
    job->pid = 0;
    job->text = read_all(job->result);
    job->printed = read_all(job->output);
    fclose(job->result);
    fclose(job->output);
    if (WIFEXITED(status)) {
        job->code = WEXITSTATUS(status);
        return;
    }
    char note[256];
    job->code = process_judge(status, WTERMSIG(status) == SIGKILL && job->seconds > limit, note, sizeof note);
    if (job->text[0])           /* it has said itself why it was stopped */
        return;
    free(job->text);
    job->text = copy_text(note);
}

static void take_a_break(void)
{
    static const struct timespec pause = {0, 2000000};
    nanosleep(&pause, NULL);
}

/* Waits a little for any child. The child stops itself at its limit; half as long again, and it is killed. */
static void wait_for_some(Run *r)
{
    bool any = false;
    for (int i = 0; i < r->count; i++) {
        Job *job = &r->jobs[i];
        int status;
        if (job->pid <= 0)
            continue;
        if (waitpid(job->pid, &status, WNOHANG) == job->pid) {
            finish(job, status, r->o.time_limit);
            any = true;
        } else if (app_clock() - job->begin > 1.45 * r->o.time_limit) {
            kill(job->pid, SIGKILL);
        }
    }
    if (!any)
        take_a_break();
}

static void stop_children(Run *r)
{
    for (int i = 0; i < r->count; i++)
        if (r->jobs[i].pid > 0)
            kill(r->jobs[i].pid, SIGKILL);
    for (int i = 0; i < r->count; i++)
        if (r->jobs[i].pid > 0)
            waitpid(r->jobs[i].pid, NULL, 0);
}

static Job *add_job(Run *r, const char *file, const char *name, int index)
{
    if (r->count == r->capacity) {
        r->capacity = r->capacity * 2 + 16;
        r->jobs = need(realloc(r->jobs, (size_t)r->capacity * sizeof *r->jobs));
    }
    Job *job = &r->jobs[r->count++];
    *job = (Job){.file = copy_text(file), .name = name ? copy_text(name) : NULL, .index = index};
    return job;
}

/* Asks a child for the names in a file, and adds a job for each that is wanted. */
static void list_scenarios(Run *r, const char *file)
{
    Job lister = {.file = copy_text(file)};
    int status;
    start(&r->o, &lister);
    while (waitpid(lister.pid, &status, WNOHANG) == 0) {
        if (app_signal() || app_clock() - lister.begin > 1.45 * r->o.time_limit)
            kill(lister.pid, SIGKILL);
        take_a_break();
    }
    finish(&lister, status, r->o.time_limit);
    int index = 0;
    for (char *line = lister.text, *end; lister.code == EXIT_FINE && (end = strchr(line, '\n')) != NULL; line = end + 1) {
        *end = '\0';
        index++;
        if (!r->o.pattern || strstr(line, r->o.pattern))
            add_job(r, file, line, index);
    }
    if (lister.code != EXIT_FINE || index == 0) {
        Job *job = add_job(r, file, NULL, 0);
        job->done = true;
        job->code = lister.code != EXIT_FINE ? lister.code : EXIT_SCENARIO;
        job->text = copy_text(lister.code != EXIT_FINE ? lister.text : "holds no scenario: it checks nothing");
        job->printed = copy_text(lister.printed);
    }
    free(lister.file);
    free(lister.text);
    free(lister.printed);
}

/* ---- reports -------------------------------------------------------------------------------- */

static void print_indented(const char *prefix, const char *text)
{
    while (*text) {
        size_t n = strcspn(text, "\n");
        printf("%s", prefix);
        say_text(stdout, text, n, "\t");
        fputc('\n', stdout);
        text += n + (text[n] == '\n');
    }
}

/* The end of what a scenario printed. */
static void print_output(const char *prefix, const char *printed)
{
    size_t n = strlen(printed);
    if (n > OUTPUT_SHOWN) {
        printed += n - OUTPUT_SHOWN;
        printf("%s(the last %d bytes of its output)\n", prefix, OUTPUT_SHOWN);
    }
    print_indented(prefix, printed);
}

static void print_job(const Run *r, const Job *job, int number)
{
    const char *name = job->name ? job->name : "(the whole file)";
    bool passed = job->code == EXIT_FINE;
    if (r->o.tap) {
        printf("%s %d - %s: %s\n", passed ? "ok" : "not ok", number, job->file, name);
        print_indented("# ", job->text);
        if (!passed)
            print_output("# | ", job->printed);
    } else {
        printf("%s  %s: %s (%.2f s)\n", passed ? "ok  " : "FAIL", job->file, name, job->seconds);
        print_indented("      ", job->text);
        if (!passed)
            print_output("      | ", job->printed);
    }
    fflush(stdout);
}

static void write_xml(FILE *f, const char *text)
{
    static const char special[] = "<>&\"\n";
    static const char *const instead[] = {"&lt;", "&gt;", "&amp;", "&quot;", "&#10;"};
    while (*text) {
        size_t n = strcspn(text, special);
        say_text(f, text, n, "\t");
        text += n;
        if (*text)
            fputs(instead[strchr(special, *text++) - special], f);
    }
}

static int write_junit(const Run *r, int failed)
{
    TextFile t;
    if (!text_begin(&t, r->o.junit))
        return EXIT_OUTPUT;
    FILE *f = t.text;
    fprintf(f, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"digbox\" tests=\"%d\" failures=\"%d\">\n", r->count, failed);
    for (int i = 0; i < r->count; i++) {
        const Job *job = &r->jobs[i];
        fputs("  <testcase classname=\"", f);
        write_xml(f, job->file);
        fputs("\" name=\"", f);
        write_xml(f, job->name ? job->name : "(the whole file)");
        fprintf(f, "\" time=\"%.3f\">", job->seconds);
        if (job->code != EXIT_FINE) {
            fputs("\n    <failure message=\"", f);
            write_xml(f, job->text);
            fputs("\"/>\n  ", f);
        }
        fputs("</testcase>\n", f);
    }
    fputs("</testsuite>\n", f);
    return text_place(&t, r->o.junit);
}

/* Of several codes the one that says most. */
static int worse(int a, int b)
{
    static const int order[] = {EXIT_INTERNAL, EXIT_OUTPUT, EXIT_FORMAT, EXIT_FINITE, EXIT_TIME, EXIT_FUEL, EXIT_MEMORY, EXIT_SCRIPT,
                                EXIT_USAGE, EXIT_SCENARIO};
    for (size_t i = 0; i < sizeof order / sizeof *order; i++)
        if (a == order[i] || b == order[i])
            return order[i];
    return a > b ? a : b;
}

static int run_all(Run *r)
{
    int next = 0, printed = 0, running = 0, failed = 0, code = EXIT_FINE;
    if (r->o.tap)
        printf("TAP version 13\n1..%d\n", r->count);
    while (printed < r->count) {
        if (app_signal()) {
            stop_children(r);
            return 128 + app_signal();
        }
        running = 0;
        for (int i = printed; i < next; i++)
            running += r->jobs[i].pid > 0;
        for (; next < r->count && running < r->o.jobs; next++)
            if (!r->jobs[next].done) {
                start(&r->o, &r->jobs[next]);
                running++;
            }
        for (; printed < next && r->jobs[printed].done; printed++) {
            print_job(r, &r->jobs[printed], printed + 1);
            failed += r->jobs[printed].code != EXIT_FINE;
            code = worse(code, r->jobs[printed].code);
        }
        if (running > 0)
            wait_for_some(r);
    }
    if (r->o.junit)
        code = worse(code, write_junit(r, failed));
    printf("%s%d passed, %d failed\n", r->o.tap ? "# " : "", r->count - failed, failed);
    return code;
}

static void free_run(Run *r)
{
    for (int i = 0; i < r->count; i++) {
        free(r->jobs[i].file);
        free(r->jobs[i].name);
        free(r->jobs[i].text);
        free(r->jobs[i].printed);
    }
    for (int i = 0; i < r->file_count; i++)
        free(r->files[i]);
    free(r->jobs);
    free(r->files);
}

/* ---- the command ------------------------------------------------------------------------------ */

enum { OPT_TAP = 256, OPT_JUNIT, OPT_UPDATE, OPT_TIME, OPT_SIM };

static const struct option test_options[] = {
    {"jobs", required_argument, NULL, 'j'}, {"output", required_argument, NULL, 'o'}, {"tap", no_argument, NULL, OPT_TAP},
    {"junit", required_argument, NULL, OPT_JUNIT}, {"update-goldens", no_argument, NULL, OPT_UPDATE},
    {"time-limit", required_argument, NULL, OPT_TIME}, {"sim-limit", required_argument, NULL, OPT_SIM}, {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static bool read_test_option(TestOptions *o, int key)
{
    switch (key) {
    case 'k': o->pattern = optarg; return true;
    case 'o': o->out = optarg; return true;
    case 'j': return read_whole_option("jobs", optarg, 1, JOB_LIMIT, &o->jobs);
    case OPT_TAP: o->tap = true; return true;
    case OPT_JUNIT: o->junit = optarg; return true;
    case OPT_UPDATE: o->update_goldens = true; return true;
    case OPT_SIM: return read_number_option("sim-limit", optarg, "s", 1e-3, 1e9, &o->sim_limit);
    case OPT_TIME: return read_number_option("time-limit", optarg, "s", 1e-3, 1e9, &o->time_limit);
    default: return false;               /* next_option said why */
    }
}

static int command_test(int argc, char **argv)
{
    Run r = {.o = {.out = "out", .time_limit = 300, .jobs = 1}};
    int key, code = EXIT_FINE;
    while ((key = next_option("test", argc, argv, "k:j:o:h", test_options)) != -1)
        if (key == 'h')
            return print_help("test");
        else if (!read_test_option(&r.o, key))
            return EXIT_USAGE;
    for (int i = optind; i < argc && code == EXIT_FINE; i++)
        code = add_path(&r, argv[i]) ? EXIT_FINE : EXIT_USAGE;
    if (optind == argc)
        search_folder(&r, ".", 0);
    for (int i = 0; i < r.file_count && code == EXIT_FINE && !app_signal(); i++)
        list_scenarios(&r, r.files[i]);
    if (code == EXIT_FINE && app_signal())
        code = 128 + app_signal();
    if (code == EXIT_FINE && r.count == 0) {
        if (r.o.pattern)
            printf("no scenario has '%s' in its name\n0 passed, 0 failed\n", r.o.pattern);
        else
            puts("no scenario found\n0 passed, 0 failed");
        code = EXIT_USAGE;
    } else if (code == EXIT_FINE) {
        code = run_all(&r);
    }
    free_run(&r);
    return flush_output(code);
}

const Command test_command = {
    .name = "test",
    .use = "  digbox test [PATH...] [options]                 run scenarios: files, or folders with *_spec.lua and other scenarios\n",
    .options =
        "  -k PATTERN              only scenarios with this text in their name\n"
        "  -j, --jobs N            so many at the same time (default 1)\n"
        "      --tap               results as Test Anything Protocol\n"
        "      --junit FILE        results as JUnit XML, too\n"
        "      --update-goldens    take the pictures of today as right\n"
        "      --time-limit S      wall time for one scenario (default 300)\n"
        "      --sim-limit S       simulated time for one world of a scenario (default: none)\n"
        "  -o, --output DIR        where pictures of failures go (default out)\n",
    .run = command_test,
    .starts_runs = true,
};
