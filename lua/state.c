/* lua/state.c - the sandboxed Lua state of the program: its limits, signals, memory, and how a script is run and stopped. */

#define _XOPEN_SOURCE 700       /* sigaction, setitimer, clock_gettime, pread */

#include "state.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "bind.h"
#include "command.h"
#include "jail.h"
#include "process.h"
#include "sandbox.h"

enum { HOOK_EVERY = 1000 };             /* instructions between looks at a fuel limit            */
enum { TICK_US = 25000 };               /* how often time, memory and signals are looked at      */
enum { MEMORY_DEFAULT_MIB = 1024 };     /* what a script may use when nobody says how much       */
enum { PATIENCE = 10 };                 /* s from the first signal to the end of who ignores it  */
static const double HARD = 1.4;         /* times the limit: where a script does not respond, the process ends */

/* ---- signals and the clock ------------------------------------------------------ */

static volatile sig_atomic_t caught;

static App *volatile current;           /* whose limits the timer looks at */
static pthread_t main_thread;
static bool catching;                   /* the handlers are installed */
static volatile double hard_deadline;   /* s; 0 = none */

double app_clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void start_timer(void)
{
    const struct itimerval every = {{0, TICK_US}, {0, TICK_US}};
    if (catching)
        setitimer(ITIMER_REAL, &every, NULL);
}

static void on_signal(int number)
{
    if (caught)
        _exit(128 + number);
    caught = number;
    hard_deadline = app_clock() + PATIENCE;
    start_timer();
}

static void count_hook(lua_State *L, lua_Debug *ar);

/* A C function of Lua can run for ever without a hook being called: the last resort of limits and of signals. */
static void end_hard(void)
{
    static const char text[] = "digbox: the script does not respond; killed\n";
    ssize_t ignored = write(2, text, sizeof text - 1);
    (void)ignored;
    _exit(caught ? 128 + caught : EXIT_TIME);
}

/* Resident memory of the process, without a call that a signal handler may not make. */
static size_t resident_bytes(const App *app)
{
    char text[128];
    size_t pages = 0;
    ssize_t n = app->statm >= 0 ? pread(app->statm, text, sizeof text - 1, 0) : 0;
    text[n > 0 ? n : 0] = '\0';
    const char *p = text + strcspn(text, " ");
    for (p += *p == ' '; *p >= '0' && *p <= '9'; p++)
        pages = pages * 10 + (size_t)(*p - '0');
    return pages * app->page;
}

static bool is_due(const App *app)
{
    return caught || (app->deadline > 0 && app_clock() > app->deadline) ||
           (app->resident_limit > 0 && resident_bytes(app) > app->resident_limit);
}

/* A hook is set only when there is something to stop for: setting one visits every frame of the stack. With a fuel limit there is
 * a hook anyway, which must not be moved: its counting would depend on the clock. */
static void on_tick(int number)
{
    int error = errno;
    if (!pthread_equal(pthread_self(), main_thread)) {
        pthread_kill(main_thread, number);
        return;
    }
    if (hard_deadline > 0 && app_clock() > hard_deadline)
        end_hard();
    App *app = current;
    if (app && !app->leaving && !app->nudged && app->running && is_due(app)) {
        app->nudged = true;
        if (app->fuel < 0)
            lua_sethook(app->running, count_hook, LUA_MASKCOUNT, 1);
    }
    errno = error;
}

void app_limit_time(App *app, double seconds)
{
    app->deadline = app_clock() + seconds;
    hard_deadline = app_clock() + HARD * seconds;
    process_limit(HARD * seconds + 0.04 * seconds);
    start_timer();
}

void app_lift_limits(App *app)
{
    app->leaving = true;
    app->deadline = 0;
    app->fuel = -1;
    if (!caught)
        hard_deadline = 0;
    process_limit(0);
}

void app_catch_signals(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    main_thread = pthread_self();
    catching = true;
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    struct sigaction before;
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)     /* nohup */
        sigaction(SIGHUP, &action, NULL);
    action.sa_handler = on_tick;
    action.sa_flags = SA_RESTART;
    sigaction(SIGALRM, &action, NULL);
    signal(SIGPIPE, SIG_IGN);
#ifdef SIGXFSZ
    signal(SIGXFSZ, SIG_IGN);
#endif
}

int app_signal(void)
{
    return caught;
}

void app_forget_interrupt(void)
{
    if (caught != SIGINT)
        return;
    hard_deadline = 0;
    caught = 0;
}

/* ---- stopping: the script gets no word any more ------------------------------------- */

/* "world.lua:12: " without a byte of Lua's memory. */
static void find_place(lua_State *L, char *text, size_t capacity)
{
    lua_Debug ar;
    *text = '\0';
    for (int level = 0; L && lua_getstack(L, level, &ar); level++) {
        lua_getinfo(L, "Sl", &ar);
        if (ar.source[0] == '@' && ar.currentline > 0) {
            snprintf(text, capacity, "%s:%d: ", ar.source + 1, ar.currentline);
            return;
        }
    }
}

static void call_quietly(lua_State *L, const char *name)
{
    if (!lua_checkstack(L, 16) || lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core") != LUA_TTABLE)
        return;
    lua_getfield(L, -1, name);
    if (lua_pcall(L, 0, 0, 0) != LUA_OK)
        lua_pop(L, 1);
    lua_pop(L, 1);
}

/* Ends the process. `sound`: the state is between two instructions or in a function of ours, so that the program's own Lua can
 * finish films and say where the run stood; in the middle of an allocation it cannot. */
static _Noreturn void leave(lua_State *L, App *app, int code, const char *text, bool sound)
{
    char place[1024], line[2048];
    find_place(L, place, sizeof place);
    if (!*place)
        snprintf(place, sizeof place, "%.1000s: ", app->script);
    snprintf(line, sizeof line, "%s%s", place, text);
    app_lift_limits(app);
    app->stop_code = code;
    if (sound)
        call_quietly(L, "clear_progress");
    if (app->stopped)
        app->stopped(app->stopped_data, code, line);
    else
        say_error(line);
    if (sound)
        call_quietly(L, "report_stop");
    code = flush_output(code);
    fflush(NULL);
    _exit(code);
}

static void stop(lua_State *L, App *app, int code, const char *text)
{
    if (!app->raises)
        leave(L, app, code, text, true);
    app->stop_code = code;
    bind_where(L);
    lua_pushstring(L, text);
    lua_concat(L, 2);
    lua_error(L);
}

/* ---- limits ---------------------------------------------------------------- */

static void stop_memory(lua_State *L, App *app, size_t limit, const char *who, bool sound)
{
    char text[128];
    snprintf(text, sizeof text, "the %s needs more than %zu MiB; raise --memory-limit", who, limit >> 20);
    if (sound)
        stop(L, app, EXIT_MEMORY, text);
    else
        leave(L, app, EXIT_MEMORY, text, false);
}

/* Over its limit with garbage and all: without it, is it still? Little room counts as none, else the collector would never rest. */
static void check_memory(lua_State *L, App *app)
{
    lua_gc(L, LUA_GCCOLLECT, 0);
    app->over = false;
    if (app->memory_used > app->memory_limit / 8 * 7)
        stop_memory(L, app, app->memory_limit, "script", true);
}

static void check_limits(lua_State *L, App *app)
{
    char text[160];
    if (app->leaving)
        return;
    if (app->over)
        check_memory(L, app);
    if (caught)
        stop(L, app, 128 + caught, caught == SIGINT ? "stopped by Ctrl-C" : "stopped by a signal");
    if (app->fuel == 0) {
        snprintf(text, sizeof text, "used up its instructions (%lld); raise --fuel or do less per step", app->fuel_given);
        stop(L, app, EXIT_FUEL, text);
    }
    if (app->deadline > 0 && app_clock() > app->deadline)
        stop(L, app, EXIT_TIME, "used up its time; raise --time-limit or simulate less");
    if (app->resident_limit > 0 && resident_bytes(app) > app->resident_limit)
        stop_memory(L, app, app->resident_limit, "run", true);
}

static void burn(App *app, size_t work)
{
    if (app->fuel > 0)
        app->fuel = (unsigned long long)app->fuel > work ? app->fuel - (long long)work : 0;
}

lua_State *app_run(lua_State *L)
{
    App *app = app_of(L);
    lua_State *before = app->running;
    app->running = L;
    if (!app->leaving && (app->over || (app->nudged && app->fuel < 0)))
        lua_sethook(L, count_hook, LUA_MASKCOUNT, 1);
    return before;
}

static void count_hook(lua_State *L, lua_Debug *ar)
{
    App *app = app_of(L);
    (void)ar;
    if (!app->over)
        burn(app, HOOK_EVERY);
    app->nudged = false;
    check_limits(L, app);
    if (app->fuel >= 0)
        lua_sethook(L, count_hook, LUA_MASKCOUNT, HOOK_EVERY);
    else if (!app->nudged)
        lua_sethook(L, NULL, 0, 0);
}

void app_charge(lua_State *L, size_t work)
{
    App *app = app_of(L);
    app->work += work;
    if (app->work < HOOK_EVERY)
        return;
    burn(app, app->work);
    app->work = 0;
    if (app->fuel == 0 || app->over || app->nudged || caught || (app->deadline > 0 && app_clock() > app->deadline))
        check_limits(L, app);
}

void app_need(lua_State *L, size_t bytes)
{
    App *app = app_of(L);
    if (!app->leaving && bytes > app->memory_limit)
        stop_memory(L, app, app->memory_limit, "script", true);
}

/* Before each frame step. The clock and the memory of the process are looked at by the timer, which nudges: at each step they would
 * cost as much as a step of a small world. */
void app_poll(lua_State *L)
{
    App *app = app_of(L);
    if (app->nudged || app->over || caught || app->fuel == 0)
        check_limits(L, app);
}

static int poll_limits(lua_State *L)
{
    app_poll(L);
    return 0;
}

/* ---- memory ------------------------------------------------------------------- */

/* The limit is a soft one: what passes it succeeds, and the hook looks into it at the next instruction. Lua never gets a refusal,
 * so that it never has to collect in the middle of an instruction: its release 5.4.4 then uses freed memory. What is refused all
 * the same (twice the limit, no memory in the machine) ends the process here. */
static void *allocate(void *data, void *block, size_t old, size_t size)
{
    App *app = data;
    if (!block)
        old = 0;                /* Lua passes a type there */
    if (size == 0) {
        app->memory_used -= old;
        free(block);
        return NULL;
    }
    if (size > old && !app->leaving) {
        size_t used = app->memory_used - old;
        if (size > 2 * app->memory_limit || used + size > 2 * app->memory_limit)
            stop_memory(app->running, app, app->memory_limit, "script", false);
        if (used + size > app->memory_limit && !app->over && app->running) {
            app->over = true;
            lua_sethook(app->running, count_hook, LUA_MASKCOUNT, 1);
        }
        app->allocations++;
    }
    bool fails = app->fail_at && size > old && (app->allocations == app->fail_at || (app->fail_on && app->allocations > app->fail_at));
    void *moved = fails ? NULL : realloc(block, size);
    if (!moved && size <= old)
        return block;
    if (!moved)
        leave(app->running, app, EXIT_MEMORY, "no memory", false);
    app->memory_used += size - old;
    return moved;
}

static int panic(lua_State *L)
{
    const char *text = lua_type(L, -1) == LUA_TSTRING ? lua_tostring(L, -1) : NULL;
    fprintf(stderr, "digbox: internal: %s\n", text ? text : "error outside a protected call");
    fflush(NULL);
    _exit(EXIT_INTERNAL);
}

/* ---- opening --------------------------------------------------------------------------- */

static int forget(lua_State *L)
{
    App *app = app_of(L);
    if (current == app)
        current = NULL;
    if (app->statm >= 0)
        close(app->statm);
    app->statm = -1;
    return 0;
}

/* When the state is closed, the timer forgets it. */
static void forget_at_close(lua_State *L)
{
    lua_newuserdatauv(L, 1, 0);
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, forget);
    lua_setfield(L, -2, "__gc");
    lua_setmetatable(L, -2);
    lua_setfield(L, LUA_REGISTRYINDEX, "digbox.app");
}

static const BindHost host = {.charge = app_charge, .run = app_run, .poll = app_poll};

static int open_state(lua_State *L)
{
    App *app = lua_touserdata(L, 1);
    forget_at_close(L);
    lib_open(L, app->trust);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pop(L, 1);
    bind_open(L);
    lua_pop(L, 1);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_pushcfunction(L, poll_limits);
    lua_setfield(L, -2, "poll");
    bind_host_by(L, &host);
    bind_use(L, "sandbox");
    bind_hint_methods(L);
    lua_settop(L, 0);
    if (!app->trust) {
        lib_finish(L);
        lib_check(L);
    }
    return 0;
}

static size_t physical_bytes(void)
{
    long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (size_t)pages * (size_t)size : 0;
}

size_t app_room(void)
{
    size_t most = physical_bytes() / 4 * 3, given = current ? current->resident_limit : 0;
    return given && given < most ? given : most;
}

/* Besides Lua's own memory: that of the whole process, with worlds and renderer in it. */
static void limit_memory(App *app)
{
    const size_t MIB = (size_t)1 << 20;
    size_t given = app->memory_limit;
    if (!given)
        app->memory_limit = (size_t)MEMORY_DEFAULT_MIB * MIB;
    app->resident_limit = given ? 4 * given + 512 * MIB : physical_bytes() / 4 * 3;
    if (given)
        process_limit_space(8 * given + 8192 * MIB);    /* drivers reserve far more than they use */
}

static bool shut_in(const App *app)
{
    char text[160];
    const Jail jail = {.script = app->script, .out = app->out, .also = app->also, .also_count = sizeof app->also / sizeof *app->also, .kept = app->kept};
    if (!app->jailed || app->trust) {
        if (app->jail_said)
            fputs("digbox: jail: none, the script is trusted\n", stderr);
        return true;
    }
    bool tight = jail_enter(&jail, text, sizeof text);
    if (app->jail_said)
        fprintf(stderr, "digbox: jail: %s\n", text);
    if (!tight && app->jail_needed)
        fprintf(stderr, "digbox: %s: %s; without --require-jail it would be run behind the walls that are left\n", app->script, text);
    return tight || !app->jail_needed;
}

lua_State *app_open(App *app)
{
    app->running = NULL;
    app->fuel_given = app->fuel;
    app->page = (size_t)sysconf(_SC_PAGESIZE);
    app->statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    limit_memory(app);
    process_name(app->script);
    if (!shut_in(app))
        return NULL;
    lua_State *L = lua_newstate(allocate, app);
    if (!L)
        return NULL;
    *(App **)lua_getextraspace(L) = app;
    app->running = L;
    lua_atpanic(L, panic);
    lua_pushcfunction(L, open_state);
    lua_pushlightuserdata(L, app);
    if (lua_pcall(L, 1, 0, 0) != LUA_OK) {
        fprintf(stderr, "digbox: internal: %s\n", lua_tostring(L, -1));
        lua_close(L);
        return NULL;
    }
    if (app->fuel >= 0)
        lua_sethook(L, count_hook, LUA_MASKCOUNT, HOOK_EVERY);
    current = app;
    start_timer();
    return L;
}

void app_set_option(lua_State *L, const char *name)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "options");
    lua_pushvalue(L, -3);
    lua_setfield(L, -2, name);
    lua_pop(L, 3);
}

/* ---- running ------------------------------------------------------------------------------ */

/* Turns what was raised into text; never calls the script's __tostring. */
static int handle_message(lua_State *L)
{
    if (lua_type(L, 1) == LUA_TSTRING) {
        if (strncmp(lua_tostring(L, 1), "C stack overflow", 16) == 0) {         /* raised in a C function: it has no position */
            bind_where(L);
            lua_insert(L, 1);
            lua_concat(L, 2);
        }
        lua_settop(L, 1);
        bind_hint(L);
        return 1;
    }
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "finished");
    if (lua_rawequal(L, 1, -1)) {
        lua_settop(L, 1);
        return 1;
    }
    bind_where(L);
    lua_pushfstring(L, "error was called with a %s, must be with a text that says what is wrong", luaL_typename(L, 1));
    lua_concat(L, 2);
    return 1;
}

static int code_of_failure(lua_State *L, App *app, int status)
{
    if (lua_istable(L, -1)) {               /* core.finished: the script ended itself */
        lua_pop(L, 1);
        return EXIT_FINE;
    }
    if (app->stop_code)
        return app->stop_code;
    if (status == LUA_ERRMEM) {
        lua_pop(L, 1);
        if (app->memory_limit > 0)
            lua_pushfstring(L, "%s: the script needs more than %d MiB; raise --memory-limit", app->script,
                            (int)(app->memory_limit >> 20));
        else
            lua_pushfstring(L, "%s: no memory", app->script);
        return EXIT_MEMORY;
    }
    return bind_exit_code(L, lua_tostring(L, -1));
}

int app_call(lua_State *L, App *app, int arguments, int results)
{
    int base = lua_gettop(L) - arguments;
    lua_pushcfunction(L, handle_message);
    lua_insert(L, base);
    int status = lua_pcall(L, arguments, results, base);
    lua_remove(L, base);
    return status == LUA_OK ? EXIT_FINE : code_of_failure(L, app, status);
}

int app_call_core(lua_State *L, App *app, const char *name, int arguments, int results)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, name);
    lua_remove(L, -2);
    lua_insert(L, -arguments - 1);
    return app_call(L, app, arguments, results);
}

void app_hash(const char *text, size_t size, char out[17])
{
    uint64_t h = 0xcbf29ce484222325u;       /* Fowler, Noll and Vo: FNV-1a, 64 bits */
    for (size_t i = 0; i < size; i++)
        h = (h ^ (unsigned char)text[i]) * 0x100000001b3u;
    snprintf(out, 17, "%016" PRIx64, h);
}

static int load_script(lua_State *L)
{
    const char *path = lua_tostring(L, 1);
    char hash[17];
    size_t size;
    if (!lib_push_source(L, path))
        return lua_error(L);
    const char *text = lua_tolstring(L, -1, &size);
    app_hash(text, size, hash);
    lua_pushstring(L, hash);
    app_set_option(L, "script_hash");
    if (lib_load_source(L, path) != LUA_OK)
        return lua_error(L);
    return 1;
}

int app_run_file(lua_State *L, App *app)
{
    const char *slash = strrchr(app->script, '/');
    lua_pushstring(L, app->script);
    app_set_option(L, "script");
    lua_pushstring(L, slash ? slash + 1 : app->script);
    app_set_option(L, "script_name");
    lua_pushcfunction(L, load_script);
    lua_pushstring(L, app->script);
    int code = app_call(L, app, 1, 1);
    if (code != EXIT_FINE)
        return code;
    const int below = lua_gettop(L) - 1;
    code = app_call(L, app, 0, 1);
    if (code == EXIT_FINE && lua_gettop(L) > below)     /* nothing is there where it was ended early */
        app_set_option(L, "returned");
    return code;
}
