/* lua/main.c - the program `digbox`: which command, its help, and what commands share. Each command has a file of its own
 * that ends in its Command.
 *
 * Exit codes are in state.h. Errors go to stderr as `digbox: FILE:LINE: message`.
 */

#define _XOPEN_SOURCE 700       /* unsetenv */

#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "command.h"
#include "process.h"
#include "state.h"

static const Command *const commands[] = {
    &run_command, &test_command, &check_command, &cost_command, &sweep_command, &task_command, &merge_command, &render_command,
    &export_command, &view_command, &diff_command, &verify_command, &api_command, &repl_command, &new_command, &doctor_command,
};
enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

/* ---- help ------------------------------------------------------------------ */

static void print_program_help(void)
{
    fputs("digbox - a 3D physics sandbox with dynamic interaction graphs\n\n", stdout);
    for (int i = 0; i < COMMAND_COUNT; i++)
        fputs(commands[i]->use, stdout);
    fputs("  digbox --help | --version\n\n", stdout);
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (commands[i]->options)
            printf("%s:\n%s\n", commands[i]->name, commands[i]->options);
    printf("Exit codes: %s\n", exit_code_help());
}

const Command *command_at(int index)
{
    return index >= 0 && index < COMMAND_COUNT ? commands[index] : NULL;
}

const char *exit_code_help(void)
{
    return "0 ok, 1 script error, 2 usage, 3 memory, 4 fuel, 5 time, 6 scenario failed, 7 replays differ,\n"
           "8 bad input file, 9 output failed, 10 non-finite state, 11 internal, 12 unreliable (--strict), 130 SIGINT, 143 SIGTERM.";
}

static const Command *find_command(const char *name)
{
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

int print_help(const char *command)
{
    const Command *c = command ? find_command(command) : NULL;
    if (!c)
        print_program_help();
    else
        printf("%s%s%s%s", c->use, c->options ? "\n" : "", c->options ? c->options : "", c->notes ? c->notes : "");
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

/* ---- options ------------------------------------------------------------------ */

/* The option before optind that there is not, or that is short for several. */
static int unknown_option(const char *command, const char *word, const struct option *options)
{
    enum { MOST = 64 };
    const char *names[MOST];
    int count = 0, same = 0;
    size_t length = strcspn(word + 2, "=");
    for (int i = 0; options[i].name && count < MOST; i++) {
        same += strncmp(options[i].name, word + 2, length) == 0;
        names[count++] = options[i].name;
    }
    char name[128];
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name - 1 ? length : sizeof name - 1), word + 2);
    const char *near = dig_suggest(name, names, count);
    if (same > 1)
        return usage_error("%s: option '--%s' may mean several: write it in full", command, name);
    if (near)
        return usage_error("%s: unknown option '--%s' (did you mean '--%s'?)", command, name, near);
    return usage_error("%s: unknown option '--%s'; 'digbox %s --help' lists them", command, name, command);
}

int next_option(const char *command, int argc, char **argv, const char *letters, const struct option *options)
{
    char own[64];
    int index = -1;
    opterr = 0;
    optopt = 0;
    snprintf(own, sizeof own, ":%s", letters);          /* ':' tells a missing value from an unknown option */
    int key = getopt_long(argc, argv, own, options, &index);
    if (key != ':' && key != '?')
        return key;
    const char *word = optind > 0 && optind <= argc ? argv[optind - 1] : "";
    const char *name = NULL;
    for (int i = 0; options[i].name; i++)
        if (options[i].val == optopt && !(optopt && strncmp(word, "--", 2) != 0))
            name = options[i].name;
    if (key == ':' && name)
        usage_error("%s: --%s wants a value", command, name);
    else if (key == ':')
        usage_error("%s: -%c wants a value", command, optopt);
    else if (optopt && name)
        usage_error("%s: --%s takes no value", command, name);
    else if (optopt)
        usage_error("%s: unknown option '-%c'; 'digbox %s --help' lists them", command, optopt, command);
    else
        unknown_option(command, word, options);
    return '?';
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
        usage_error("--%s: %s%s%s is not from %g to %g %s", name, text, plain ? " " : "", plain ? unit : "", low, high, unit);
        return false;
    }
    *value = x;
    return true;
}

bool read_accuracy_option(const char *text)
{
    static const char *const plans[] = {"sketch", "play", "study", "reference"};
    double metres;
    if (strchr("0123456789.+-", text[0]) && text[0])
        return read_number_option("accuracy", text, "m", 1e-12, 1, &metres);       /* as the tolerance of a world (engine/api/schema.c) */
    for (int i = 0; i < 4; i++)
        if (strcmp(text, plans[i]) == 0)
            return true;
    const char *near = dig_suggest(text, plans, 4);
    if (near)
        return usage_error("--accuracy: unknown accuracy '%s' (did you mean '%s'?)", text, near) == 0;
    return usage_error("--accuracy: '%s' is not sketch, play, study, reference or a length", text) == 0;
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

/* ---- the command ------------------------------------------------------------ */

static int unknown_command(const char *word)
{
    const char *names[COMMAND_COUNT];
    for (int i = 0; i < COMMAND_COUNT; i++)
        names[i] = commands[i]->name;
    static const char *const plain[] = {"--help", "--version"};
    const char *near = word[0] == '-' ? dig_suggest(word, plain, 2) : dig_suggest(word, names, COMMAND_COUNT);
    if (near)
        return usage_error("unknown command '%s' (did you mean '%s'?)", word, near);
    return usage_error("unknown command '%s'", word);
}

#ifdef __SANITIZE_ADDRESS__
/* Leaks that are not ours, as in tests/lsan.supp, which a run that is shut in cannot read. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libLLVM\nleak:swrast_dri\nleak:libOSMesa\nleak:libfontconfig\n";
}
#endif

/* Where standard input or output is closed, the next file to be opened would get its number, and then what is printed. Reading from
 * and writing to these fails as it would have. */
static void keep_standard_numbers(void)
{
    for (int handle = 0; handle <= 2; handle++)
        if (fcntl(handle, F_GETFD) < 0 && open("/dev/null", handle == 0 ? O_WRONLY : O_RDONLY) != handle)
            _exit(EXIT_OUTPUT);
}

int main(int argc, char **argv)
{
    keep_standard_numbers();
    const char *word = argc > 1 ? argv[1] : "";
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0)
        return argc > 2 && !find_command(argv[2]) ? unknown_command(argv[2]) : print_help(argc > 2 ? argv[2] : NULL);
    if (strcmp(word, "--version") == 0 || strcmp(word, "-V") == 0) {
        printf("digbox %s\n", DIGBOX_VERSION);
        return flush_output(EXIT_FINE);
    }
    if (!*word)
        return usage_error("what shall be done? (digbox run WORLD.lua)");
    const Command *c = find_command(word);
    if (!c)
        return unknown_command(word);
    /* llvmpipe with vectors of 512 bits crashes on multisampled pictures; its own choice, 256, works everywhere. */
    const char *width = getenv("LP_NATIVE_VECTOR_WIDTH");
    if (width && strcmp(width, "512") == 0)
        unsetenv("LP_NATIVE_VECTOR_WIDTH");
    app_catch_signals();
    argv[1] = argv[0];
    return c->starts_runs ? c->run(argc - 1, argv + 1) : process_supervise(c->run, argc - 1, argv + 1);
}
