/* lua/api.c - the command `digbox api`: what a script can name, as text, for editors, for the shell and on paper.
 *
 * The texts are made in Lua (lua/digbox/api.lua) from the declarations that calls are checked against.
 */

#define _XOPEN_SOURCE 700

#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include <lauxlib.h>

#include "bind.h"
#include "command.h"
#include "state.h"

typedef struct ApiOptions {
    const char *form, *name;
} ApiOptions;

/* core.commands and core.exit_codes: what the manual page and the completion say of the program. */
static void push_commands(lua_State *L)
{
    const Command *c;
    lua_newtable(L);
    for (int i = 0; (c = command_at(i)) != NULL; i++) {
        lua_newtable(L);
        bind_set_text(L, "name", c->name);
        bind_set_text(L, "use", c->use);
        bind_set_text(L, "options", c->options ? c->options : "");
        lua_rawseti(L, -2, i + 1);
    }
}

/* Pushes the text. */
static int make_text(lua_State *L)
{
    const ApiOptions *o = lua_touserdata(L, 1);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    push_commands(L);
    lua_setfield(L, -2, "commands");
    bind_set_text(L, "exit_codes", exit_code_help());
    bind_use(L, "api");
    lua_pop(L, 1);
    lua_getfield(L, -1, "api_text");
    lua_pushstring(L, o->form);
    lua_pushstring(L, o->name);
    lua_call(L, 2, 1);
    return 1;
}

static int print_text(const ApiOptions *o)
{
    App app = {.fuel = -1, .script = ""};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_MEMORY;
    lua_pushcfunction(L, make_text);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    int code = app_call(L, &app, 1, 1);
    if (code == EXIT_FINE)
        fputs(lua_tostring(L, -1), stdout);
    else
        say_error(lua_tostring(L, -1));
    lua_close(L);
    return flush_output(code);
}

/* ---- the command ------------------------------------------------------------------ */

enum { OPT_JSON = 256, OPT_LUACATS, OPT_COMPLETION, OPT_MAN, OPT_MARKDOWN, OPT_MATERIALS, OPT_NAMES };

static const struct option api_options[] = {
    {"json", no_argument, NULL, OPT_JSON}, {"luacats", no_argument, NULL, OPT_LUACATS},
    {"completion", required_argument, NULL, OPT_COMPLETION}, {"man", no_argument, NULL, OPT_MAN},
    {"markdown", no_argument, NULL, OPT_MARKDOWN}, {"materials", no_argument, NULL, OPT_MATERIALS}, {"names", no_argument, NULL, OPT_NAMES},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static bool read_api_option(ApiOptions *o, int key)
{
    switch (key) {
    case OPT_JSON: o->form = "json"; return true;
    case OPT_LUACATS: o->form = "luacats"; return true;
    case OPT_MAN: o->form = "man"; return true;
    case OPT_MARKDOWN: o->form = "markdown"; return true;
    case OPT_MATERIALS: o->form = "materials"; return true;
    case OPT_NAMES: o->form = "names"; return true;
    case OPT_COMPLETION:
        o->form = "completion";
        return strcmp(optarg, "bash") == 0 || usage_error("--completion: '%s' is not known, only bash is", optarg) == 0;
    default: return false;               /* next_option said why */
    }
}

static int command_api(int argc, char **argv)
{
    ApiOptions o = {.form = "text"};
    int key;
    while ((key = next_option("api", argc, argv, "h", api_options)) != -1)
        if (key == 'h')
            return print_help("api");
        else if (!read_api_option(&o, key))
            return EXIT_USAGE;
    if (argc - optind > 1)
        return usage_error("api: one name at a time");
    o.name = argv[optind];
    if (o.name && strcmp(o.form, "text") != 0 && strcmp(o.form, "json") != 0)
        return usage_error("api: a name goes with text or --json");
    return print_text(&o);
}

const Command api_command = {
    .name = "api",
    .use = "  digbox api [NAME] [options]                     what a script can name: functions, fields, events, materials\n",
    .options =
        "      --json              for programs\n"
        "      --luacats           for editors: the file digbox.d.lua\n"
        "      --markdown          for readers: docs/lua.md\n"
        "      --materials         the table of materials: docs/materials.md\n"
        "      --man               the manual page\n"
        "      --completion SHELL  for bash: completion of commands, options and names\n"
        "      --names             all names, one a line\n",
    .run = command_api,
};
