/* lua/new.c - the command `digbox new DIR`: a folder in which `digbox run world.lua` and `digbox test` work at once. */

#define _XOPEN_SOURCE 700

#include <dirent.h>
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include <lauxlib.h>

#include "bind.h"
#include "command.h"
#include "state.h"

/* Makes it, with the folders above it; one that is there must be empty. */
static bool make_folder(const char *path)
{
    char part[4096];
    size_t length = strlen(path);
    if (length == 0 || length >= sizeof part)
        return usage_error("new: '%.60s' is no name of a folder", path) == 0;
    for (size_t i = 1; i <= length; i++)
        if (path[i] == '/' || path[i] == '\0') {
            memcpy(part, path, i);
            part[i] = '\0';
            if (mkdir(part, 0777) != 0 && errno != EEXIST)
                return usage_error("new: %s: %s", part, strerror(errno)) == 0;
        }
    DIR *folder = opendir(path);
    if (!folder)
        return usage_error("new: %s: %s", path, strerror(errno)) == 0;
    int count = 0;
    while (readdir(folder))
        count++;
    closedir(folder);
    return count <= 2 || usage_error("new: %s holds files already; nothing was changed", path) == 0;        /* . and .. */
}

/* Writes the files into the folder whose name is the argument. */
static int write_files(lua_State *L)
{
    const char *folder = lua_touserdata(L, 1);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    int core = lua_gettop(L);
    bind_use(L, "new");
    lua_getfield(L, core, "new_files");
    lua_call(L, 0, 1);
    int files = lua_gettop(L);
    for (lua_Integer i = 1; lua_rawgeti(L, files, i) == LUA_TTABLE; i++) {
        lua_rawgeti(L, -1, 1);
        const char *path = lua_pushfstring(L, "%s/%s", folder, lua_tostring(L, -1));
        lua_getfield(L, core, "write");
        lua_pushstring(L, path);
        lua_rawgeti(L, -5, 2);
        lua_call(L, 2, 0);
        printf("  %s\n", path);
        lua_settop(L, files);
    }
    return 0;
}

static int command_new(int argc, char **argv)
{
    static const struct option options[] = {{"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
    int key;
    while ((key = next_option("new", argc, argv, "h", options)) != -1)
        return key == 'h' ? print_help("new") : EXIT_USAGE;
    if (argc - optind != 1)
        return usage_error("new: give the name of one folder");
    const char *folder = argv[optind];
    if (!make_folder(folder))
        return EXIT_USAGE;
    App app = {.fuel = -1, .script = ""};
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_MEMORY;
    lua_pushcfunction(L, write_files);
    lua_pushlightuserdata(L, (void *)(uintptr_t)folder);
    int code = app_call(L, &app, 1, 0);
    if (code == EXIT_FINE)
        printf("now: cd %s; digbox run world.lua; digbox test\n", folder);
    else
        say_error(lua_tostring(L, -1));
    lua_close(L);
    return flush_output(code);
}

const Command new_command = {
    .name = "new",
    .use = "  digbox new DIR                                  a folder to begin with: a world, a spec, settings for editors\n",
    .notes =
        "\n"
        "Makes DIR, which must be new or empty: digbox run world.lua and digbox test work in it at once. Says which files it wrote.\n"
        "world.lua drops a ball on a table; the settings let an editor complete the names of digbox.\n",
    .run = command_new,
};
