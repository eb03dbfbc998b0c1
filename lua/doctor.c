/* lua/doctor.c - the command `digbox doctor`: what this program and this machine are, what is missing, and what installs it.
 *
 * Exit code 0: all that is needed is there; 1: something needed is not. What only makes things nicer is said and changes nothing.
 */

#define _GNU_SOURCE             /* syscall, uname */

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/syscall.h>
#endif

#include <lauxlib.h>

#include "bind.h"
#include "command.h"
#include "state.h"

#if defined(__clang__)
#define COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "a C compiler"
#endif

enum { NOTE, FINE, LACKS, BAD };                /* LACKS: does without; BAD: does not work */

typedef struct Doctor {
    int bad, lacking;
} Doctor;

static void say(Doctor *d, int state, const char *what, const char *text, const char *remedy)
{
    static const char *const marks[] = {"    ", "ok  ", "    ", "BAD "};
    printf("%s %-14s %s\n", marks[state], what, text);
    if (state >= LACKS && remedy)
        printf("     %-14s -> %s\n", "", remedy);
    d->bad += state == BAD;
    d->lacking += state == LACKS;
}

/* ---- the program -------------------------------------------------------------------- */

static void look_at_program(Doctor *d)
{
    char text[256];
    snprintf(text, sizeof text, "%s, built by %s", DIGBOX_VERSION, COMPILER);
    say(d, FINE, "digbox", text, NULL);
    say(d, FINE, "Lua", LUA_RELEASE, NULL);
#ifdef DIGBOX_EDIT
    say(d, FINE, "libedit", "digbox repl has history and completion", NULL);
#else
    say(d, LACKS, "libedit", "not built in: digbox repl reads plain lines", "apt-get install libedit-dev, then make");
#endif
}

/* ---- the machine ----------------------------------------------------------------------- */

/* The first line of a file that begins with the key, behind its colon. */
static bool read_line(const char *path, const char *key, char *text, size_t size)
{
    char line[512];
    bool found = false;
    FILE *f = fopen(path, "r");
    while (f && !found && fgets(line, sizeof line, f)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) == 0 && (colon || !*key)) {
            snprintf(text, size, "%.*s", (int)strcspn(colon ? colon + 2 : line, "\n"), colon ? colon + 2 : line);
            found = true;
        }
    }
    if (f)
        fclose(f);
    return found;
}

static const char *cpu_features(char *text, size_t size)
{
    text[0] = '\0';
#if defined(__x86_64__) && defined(__GNUC__)
    static const char *const names[] = {"sse4.2", "avx", "avx2", "fma", "avx512f"};
    bool has[] = {__builtin_cpu_supports("sse4.2") != 0, __builtin_cpu_supports("avx") != 0, __builtin_cpu_supports("avx2") != 0,
                  __builtin_cpu_supports("fma") != 0, __builtin_cpu_supports("avx512f") != 0};
    for (size_t i = 0; i < sizeof has / sizeof *has; i++)
        if (has[i])
            snprintf(text + strlen(text), size - strlen(text), "%s%s", *text ? " " : "", names[i]);
#endif
    return *text ? text : "none that digbox knows";
}

static void look_at_machine(Doctor *d)
{
    char text[512], model[256] = "unknown";
    struct utsname u;
    if (uname(&u) == 0) {
        snprintf(text, sizeof text, "%.80s %.80s, %.40s", u.sysname, u.release, u.machine);
        say(d, NOTE, "system", text, NULL);
    }
    read_line("/proc/cpuinfo", "model name", model, sizeof model);
    say(d, NOTE, "processor", model, NULL);
    say(d, NOTE, "its features", cpu_features(text, sizeof text), NULL);
    snprintf(text, sizeof text, "%ld, %.1f GiB of memory", sysconf(_SC_NPROCESSORS_ONLN),
             (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE) / 1073741824.0);
    say(d, NOTE, "threads", text, NULL);
}

/* What can fence in a stranger's script. */
static void look_at_walls(Doctor *d)
{
    char text[256];
    bool seccomp = read_line("/proc/sys/kernel/seccomp/actions_avail", "", text, sizeof text);
    say(d, seccomp ? FINE : LACKS, "seccomp", seccomp ? "there" : "this kernel has none", "run strangers' worlds in a virtual machine");
#if defined(__linux__) && defined(SYS_landlock_create_ruleset)
    long abi = syscall(SYS_landlock_create_ruleset, NULL, 0, 1);        /* 1: asks for the version */
#else
    long abi = -1;
#endif
    snprintf(text, sizeof text, abi > 0 ? "version %ld" : "this kernel has none", abi);
    say(d, abi > 0 ? FINE : LACKS, "landlock", text, "run strangers' worlds in a virtual machine");
}

/* ---- pictures ------------------------------------------------------------------------------ */

/* Pushes the name of the renderer after it has drawn a picture. */
static int try_renderer(lua_State *L)
{
    static const char script[] =
        "local core = ...\n"
        "local world = core.digbox.world {}\n"
        "world:ball { radius = 1 }\n"
        "local view = core.view(world)\n"
        "local name = core.renderer()\n"
        "core.view_camera(view, 0.7, 1)\n"
        "return name";
    if (luaL_loadbufferx(L, script, sizeof script - 1, "=doctor", "t") != LUA_OK)
        return lua_error(L);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_call(L, 1, 1);
    return 1;
}

static void look_at_renderer(Doctor *d, lua_State *L, App *app)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "can_render");
    bool built = lua_toboolean(L, -1);
    lua_pop(L, 2);
    if (!built) {
        say(d, LACKS, "renderer", "not built in (RENDER=0): no pictures", "apt-get install libosmesa6-dev libpng-dev libfreetype-dev, then make");
        return;
    }
    lua_pushcfunction(L, try_renderer);
    int code = app_call(L, app, 0, 1);
    say(d, code == EXIT_FINE ? FINE : BAD, "renderer", lua_tostring(L, -1), "apt-get install libosmesa6");
    lua_pop(L, 1);
}

static void look_at_variables(Doctor *d)
{
    static const char *const names[] = {"GALLIUM_DRIVER", "LP_NUM_THREADS", "LP_NATIVE_VECTOR_WIDTH", "LIBGL_ALWAYS_SOFTWARE",
                                        "MESA_LOADER_DRIVER_OVERRIDE", "NO_COLOR"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const char *value = getenv(names[i]);
        char text[256];
        if (!value)
            continue;
        snprintf(text, sizeof text, "%s=%.200s", names[i], value);
        bool slow = i == 0 && strcmp(value, "softpipe") == 0;
        say(d, slow ? LACKS : NOTE, "environment", text, "unset GALLIUM_DRIVER: softpipe draws many times slower than llvmpipe");
    }
}

/* ---- helpers --------------------------------------------------------------------------------- */

static bool on_path(const char *program, char *found, size_t size)
{
    const char *path = getenv("PATH");
    while (path && *path) {
        int length = (int)strcspn(path, ":");
        int used = snprintf(found, size, "%.*s/%s", length, path, program);
        if (used > 0 && (size_t)used < size && access(found, X_OK) == 0)
            return true;
        path += length + (path[length] == ':');
    }
    return false;
}

static const struct { const char *program, *without, *remedy; } helpers[] = {
    {"ffmpeg", "no .mp4 and .webm: films are PNG frames", "apt-get install ffmpeg"},
    {"gnuplot", "digbox cost writes its tables without plots", "apt-get install gnuplot-nox"},
    {"luacheck", "nothing: it checks Lua for slips", "apt-get install lua-check"},
};

static void look_at_helpers(Doctor *d)
{
    char found[4096];
    for (size_t i = 0; i < sizeof helpers / sizeof *helpers; i++) {
        bool there = on_path(helpers[i].program, found, sizeof found);
        say(d, there ? FINE : LACKS, helpers[i].program, there ? found : helpers[i].without, helpers[i].remedy);
    }
    bool writable = access(".", W_OK) == 0;
    say(d, writable ? FINE : BAD, "this folder", writable ? "can be written: pictures go to out/" : "cannot be written: pictures go nowhere",
        "use -o DIR, or go to a folder of your own");
}

/* ---- the command -------------------------------------------------------------------------------- */

static int command_doctor(int argc, char **argv)
{
    static const struct option options[] = {{"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
    int key;
    while ((key = next_option("doctor", argc, argv, "h", options)) != -1)
        return key == 'h' ? print_help("doctor") : EXIT_USAGE;
    if (argc > optind)
        return usage_error("doctor: wants no arguments");
    Doctor d = {0, 0};
    App app = {.fuel = -1, .script = "doctor"};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_MEMORY;
    look_at_program(&d);
    look_at_machine(&d);
    look_at_walls(&d);
    look_at_renderer(&d, L, &app);
    look_at_variables(&d);
    look_at_helpers(&d);
    lua_close(L);
    if (d.bad)
        printf("%d thing%s must be mended\n", d.bad, d.bad == 1 ? "" : "s");
    else
        printf("all that is needed is there%s\n", d.lacking ? "; what is marked -> would be nice to have" : "");
    return flush_output(d.bad ? EXIT_SCRIPT : EXIT_FINE);
}

const Command doctor_command = {
    .name = "doctor",
    .use = "  digbox doctor                                   what this machine has and lacks, and what installs it\n",
    .notes =
        "\n"
        "Looks at the program, the walls that shut scripts in, the renderer, variables that change pictures, ffmpeg and other helpers, and\n"
        "whether this folder can be written. Exit code 0: all that is needed is there; 1: something must be mended.\n",
    .run = command_doctor,
};
