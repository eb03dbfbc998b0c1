/* tests/fuzz/target_mesh.c - any bytes as a Wavefront .obj file that a world asks for, and the mesh that comes of it at work.
 *
 * The first byte says how the mesh is used (fixed, moving, with a ball on it, asked by a ray); the rest is the file.
 * What must hold: one sentence at the script's line, or a sound world that goes on.
 */
#include "state.h"

#include <stdio.h>
#include <string.h>

#include <lauxlib.h>

static const char *const files[] = {
    "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n",
    "# a tetrahedron\no t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
    "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0.2 1\nvn 0 1 0\nvt 0 0\nf 1/1/1 3//1 2/1\nf -3 -2 -1\ns off\nusemtl x\n",
    "v 0 0 0 1.0\r\nv 1e-3 0 0\r\nv 0x10 nan 2\r\nf 1 2 3\r\n",
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0 0\nf 1 2 3\nf 1 4 2\nf 1 1 1\nf 9 9 9\nf 0 1 2\nf 1 2\n",
    NULL,
};

static const char world_text[] =
    "local digbox = require 'digbox'\n"
    "local w = digbox.world {}\nlast = w\n"
    "local m = w:mesh { file = 'mesh.obj', fixed = how % 2 == 0 and true or nil, material = 'oak' }\n"
    "if how % 4 >= 2 then w:ball { radius = 0.2, at = { 0.3, 1, 0.3 } } w:box { size = 0.3, at = { 0.2, 0.4, 0.2 } } end\n"
    "if how % 8 >= 4 then w:ray { from = { 0.2, 5, 0.2 }, to = { 0.2, -5, 0.3 } } w:overlap { sphere = { radius = 0.5 } }\n"
    "  w:sweep { sphere = { radius = 0.1 }, at = { 0.2, 3, 0.2 }, velocity = { 0, -4, 0 } } end\n"
    "w:step(2)\n"
    "return how\n";

static const char close_text[] = "if last then last:close() last = nil end";

static void mesh_seeds(FuzzGive *give, void *context)
{
    char text[1024];
    for (int i = 0; files[i]; i++) {
        size_t size = strlen(files[i]);
        text[0] = (char)i;
        memcpy(text + 1, files[i], size);
        give(context, text, size + 1);
    }
}

static int give_text(lua_State *L)
{
    lua_pushvalue(L, lua_upvalueindex(1));
    return 1;
}

/* core.read and core.beside give the bytes: no file is needed. */
static void set_file(lua_State *L, const unsigned char *data, size_t size)
{
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_pushlstring(L, (const char *)data, size);
    lua_pushcclosure(L, give_text, 1);
    lua_setfield(L, -2, "read");
    lua_pushliteral(L, "mesh.obj");
    lua_pushcclosure(L, give_text, 1);
    lua_setfield(L, -2, "beside");
    lua_pop(L, 1);
}

static void check_world(dig_world *w, void *context)
{
    (void)context;
    if (dig_world_check(w) != DIG_OK)
        fuzz_fail("%s", dig_error(w));
}

static void mesh_run(const unsigned char *data, size_t size)
{
    if (size < 1)
        return;
    char text[sizeof world_text + 32];
    static FuzzState *f;                /* kept: opening one takes longer than a mesh */
    f = fuzz_again(f, "fuzz.lua", 3000000);
    lua_State *L = fuzz_lua(f);
    set_file(L, data + 1, size - 1);
    snprintf(text, sizeof text, "local how = %d %s", data[0], world_text);
    int code = fuzz_run(f, text, strlen(text));
    const char *message = code == EXIT_FINE || code == EXIT_MEMORY ? NULL : lua_tostring(L, -1);
    if (code != EXIT_FINE && code != EXIT_MEMORY && (!message || strncmp(message, "fuzz.lua:", 9) != 0))
        fuzz_fail("code %d, not at the script's line: %s", code, message ? message : "no text");
    fuzz_worlds(f, check_world, NULL);
    f = fuzz_again(f, "fuzz.lua", 3000000);
    fuzz_run(f, close_text, sizeof close_text - 1);
}

const FuzzTarget fuzz_mesh = {.name = "mesh", .longest = 1024, .seeds = mesh_seeds, .run = mesh_run};
