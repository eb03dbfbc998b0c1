/* lua/repl.c - the command `digbox repl`: Lua line by line beside a world, with history and completion where libedit is built in.
 *
 * Without libedit, or when no terminal is there, it reads plain lines.
 */

#define _XOPEN_SOURCE 700       /* isatty */

#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <lauxlib.h>
#ifdef DIGBOX_EDIT
#include <editline/readline.h>
#endif

#include "bind.h"
#include "command.h"
#include "state.h"

enum { LINE_LIMIT = 1 << 16, HISTORY_LINES = 1000 };

/* ---- lines ------------------------------------------------------------------------- */

#ifdef DIGBOX_EDIT

static lua_State *shown;        /* whose names are completed: the library gives its functions no argument */

/* The names that begin with the text, one a call; NULL ends them. */
static char *next_name(const char *text, int state)
{
    lua_State *L = shown;
    int top = lua_gettop(L);
    char *copy = NULL;
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "complete");
    lua_pushstring(L, text);
    lua_pushinteger(L, state + 1);
    if (lua_pcall(L, 2, 1, 0) == LUA_OK && lua_type(L, -1) == LUA_TSTRING) {
        size_t size = lua_rawlen(L, -1) + 1;
        copy = malloc(size);
        if (copy)
            memcpy(copy, lua_tostring(L, -1), size);
    }
    lua_settop(L, top);
    return copy;
}

static char **complete(const char *text, int start, int end)
{
    (void)start;
    (void)end;
    rl_attempted_completion_over = 1;
    return rl_completion_matches(text, next_name);
}

#endif

typedef struct Reader {
    bool  edits;                /* a terminal and libedit */
    char  history[4096];        /* "" = kept nowhere      */
    char *line;                 /* as read, to be freed   */
} Reader;

#ifdef DIGBOX_EDIT
/* The file must be there before the jail is shut, which then lets nothing else in its folder be written. */
static void open_history(Reader *r)
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    if (state && *state)
        snprintf(r->history, sizeof r->history, "%s/digbox_history", state);
    else if (home && *home)
        snprintf(r->history, sizeof r->history, "%s/.digbox_history", home);
    int file = *r->history ? open(r->history, O_RDWR | O_CREAT | O_CLOEXEC, 0600) : -1;
    if (file >= 0)
        close(file);
    else
        *r->history = '\0';
}
#endif

/* Before the jail: the library looks for the terminal's description and its own settings. */
static void open_reader(Reader *r)
{
    *r = (Reader){0};
#ifdef DIGBOX_EDIT
    r->edits = isatty(0) && isatty(1);
    if (!r->edits)
        return;
    rl_readline_name = "digbox";
    rl_basic_word_break_characters = " \t\n\"'`@$><=;|&{}()[],+-*/~#";
    rl_attempted_completion_function = complete;
    rl_initialize();
    using_history();
    stifle_history(HISTORY_LINES);
    open_history(r);
    if (*r->history)
        read_history(r->history);
#endif
}

static void close_reader(Reader *r)
{
    free(r->line);
    r->line = NULL;
#ifdef DIGBOX_EDIT
    if (r->edits && *r->history) {
        write_history(r->history);
        chmod(r->history, 0600);
    }
#endif
}

/* A line without its end; NULL: there are no more. */
static const char *read_one(Reader *r, const char *prompt)
{
    free(r->line);
    r->line = NULL;
#ifdef DIGBOX_EDIT
    if (r->edits) {
        r->line = readline(prompt);
        if (r->line && *r->line)
            add_history(r->line);
        return r->line;
    }
#endif
    if (isatty(0)) {
        fputs(prompt, stdout);
        fflush(stdout);
    }
    r->line = malloc(LINE_LIMIT);
    if (!r->line || !fgets(r->line, LINE_LIMIT, stdin))
        return NULL;
    r->line[strcspn(r->line, "\n")] = '\0';
    return r->line;
}

/* ---- running them ---------------------------------------------------------------------- */

/* The chunk is not wrong, only not over: Lua says that its end came too early. */
static bool wants_more(lua_State *L, int status)
{
    const char *text = status == LUA_ERRSYNTAX ? lua_tostring(L, -1) : NULL;
    size_t n = text ? strlen(text) : 0;
    return n >= 5 && strcmp(text + n - 5, "<eof>") == 0;
}

/* Leaves a function for the text, or the message; as an expression first. */
static int compile(lua_State *L, const char *text)
{
    lua_pushfstring(L, "return %s", text);
    int status = luaL_loadbufferx(L, lua_tostring(L, -1), lua_rawlen(L, -1), "@repl", "t");
    if (status != LUA_OK && !wants_more(L, status)) {
        lua_pop(L, 1);
        status = luaL_loadbufferx(L, text, strlen(text), "@repl", "t");
    }
    lua_remove(L, -2);
    return status;
}

/* Reads lines until they make a whole; pushes the function. False at the end of the input, or when told to end. */
static bool read_chunk(Reader *r, lua_State *L)
{
    const char *line = read_one(r, "> ");
    if (!line || strcmp(line, "exit") == 0 || strcmp(line, "quit") == 0)
        return false;
    lua_pushstring(L, line);
    for (;;) {
        int status = compile(L, lua_tostring(L, -1));
        if (!wants_more(L, status)) {
            lua_remove(L, -2);
            if (status != LUA_OK) {
                say_error(lua_tostring(L, -1));
                lua_pop(L, 1);
                lua_pushnil(L);
            }
            return true;
        }
        lua_pop(L, 1);
        line = read_one(r, ">> ");
        if (!line)
            return false;
        lua_pushfstring(L, "%s\n%s", lua_tostring(L, -1), line);
        lua_remove(L, -2);
    }
}

static void run_chunk(lua_State *L, App *app)
{
    int base = lua_gettop(L) - 1;
    app->stop_code = 0;
    int code = app_call(L, app, 0, LUA_MULTRET);
    if (code != EXIT_FINE) {
        say_error(lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed");
    } else if (lua_gettop(L) > base) {
        lua_getglobal(L, "print");
        lua_insert(L, base + 1);
        if (app_call(L, app, lua_gettop(L) - base - 1, 0) != EXIT_FINE)
            say_error(lua_tostring(L, -1));
    }
    lua_settop(L, base);
    fflush(stdout);
}

/* The options, and what lua/digbox/repl.lua adds. */
static int open_repl(lua_State *L)
{
    const RunOptions *o = lua_touserdata(L, 1);
    lua_pushcfunction(L, run_set_options);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    lua_call(L, 1, 0);
    lua_pushliteral(L, "repl");
    app_set_option(L, "mode");
    bind_use(L, "repl");
    return 0;
}

static int begin_repl(lua_State *L, App *app, const RunOptions *o)
{
    lua_pushcfunction(L, open_repl);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    int code = app_call(L, app, 1, 0);
    if (code == EXIT_FINE && o->world)
        code = app_run_file(L, app);
    if (code == EXIT_FINE)
        code = app_call_core(L, app, "begin_repl", 0, 0);
    if (code != EXIT_FINE)
        say_error(lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed");
    lua_settop(L, 0);
    return code;
}

/* Ctrl-C ends what a line began, not the repl. */
static void run_lines(Reader *r, lua_State *L, App *app)
{
    while (app_signal() == 0 && read_chunk(r, L)) {
        if (lua_isfunction(L, -1)) {
            run_chunk(L, app);
            app_forget_interrupt();
        }
        lua_settop(L, 0);
    }
}

/* A limit is an error here, like any other: one goes on at the next line. */
static int run_repl(const RunOptions *o)
{
    Reader r;
    open_reader(&r);
    App app = {.fuel = -1, .memory_limit = (size_t)o->memory << 20, .script = o->world ? o->world : "repl", .trust = o->trust, .raises = true,
               .out = o->out, .kept = *r.history ? r.history : NULL, .jailed = true, .jail_needed = o->jail_needed, .jail_said = o->verbose};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_MEMORY;
#ifdef DIGBOX_EDIT
    shown = L;
#endif
    int code = begin_repl(L, &app, o);
    if (code == EXIT_FINE)
        run_lines(&r, L, &app);
    close_reader(&r);
    lua_close(L);
    return flush_output(code != EXIT_FINE ? code : app_signal() ? 128 + app_signal() : EXIT_FINE);
}

/* ---- the command ------------------------------------------------------------------------- */

static int command_repl(int argc, char **argv)
{
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'}, {"trust", no_argument, NULL, 't'}, {"memory-limit", required_argument, NULL, 'm'},
        {"require-jail", no_argument, NULL, 'j'}, {"verbose", no_argument, NULL, 'v'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
    };
    RunOptions o = {.out = "out", .seconds = -1, .time_limit = -1, .seed = LLONG_MIN, .fuel = -1, .quiet = true};
    int key;
    argc = cut_arguments(argc, argv, &o);
    while ((key = next_option("repl", argc, argv, "o:h", options)) != -1)
        switch (key) {
        case 'o': o.out = optarg; break;
        case 't': o.trust = true; break;
        case 'j': o.jail_needed = true; break;
        case 'v': o.verbose = true; break;
        case 'm':
            if (!read_whole_option("memory-limit", optarg, 1, 1 << 20, &o.memory))
                return EXIT_USAGE;
            break;
        case 'h': return print_help("repl");
        default: return EXIT_USAGE;
        }
    if (argc - optind > 1)
        return usage_error("repl: one world at most");
    o.world = argv[optind];
    return run_repl(&o);
}

const Command repl_command = {
    .name = "repl",
    .use = "  digbox repl [WORLD.lua] [options]               Lua line by line, beside the world that the script made\n",
    .options =
        "  -o, --output DIR        where pictures go (default out)\n"
        "      --memory-limit MiB  memory that the lines may use: what needs more is an error\n"
        "      --require-jail      only behind the walls of `digbox run` (docs/security.md)\n"
        "      --verbose           say which of them hold\n"
        "      --trust             the script may use io and os, and write anywhere\n",
    .notes = "\nexit, quit or Ctrl-D end it; help \"world:ball\" says what a function takes.\n",
    .run = command_repl,
};
