/* tests/fuzz/state.c - states, worlds and files for fuzz targets. */
#define _GNU_SOURCE             /* memfd_create */
#include "state.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <lauxlib.h>

#include "lua/sandbox.h"

struct FuzzState {
    App        app;
    lua_State *L;
    bool       lost;            /* it was left in the middle of something */
    FuzzState *next;            /* of those that are lost                 */
    jmp_buf    back;
};

static FuzzState *lost;         /* nobody may free them: kept where a leak checker finds them */

_Noreturn void fuzz_fail(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fputs("fuzz: ", stderr);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    abort();
}

static void come_back(void *data, int code, const char *text)
{
    FuzzState *f = data;
    (void)text;
    f->lost = true;
    f->app.stop_code = code;
    longjmp(f->back, 1);
}

FuzzState *fuzz_open(const char *script, long long fuel)
{
    FuzzState *f = calloc(1, sizeof *f);
    if (!f)
        fuzz_fail("no memory");
    f->app = (App){.fuel = fuel, .script = script, .raises = true, .stopped = come_back, .stopped_data = f};
    f->L = app_open(&f->app);
    if (!f->L)
        fuzz_fail("no state");
    f->app.memory_limit = (size_t)128 << 20;
    f->app.resident_limit = 0;              /* the fuzzer itself grows */
    f->app.log_limit = f->app.logged = 1;   /* nothing is printed, and nothing said about that */
    return f;
}

static void close_state(FuzzState *f)
{
    app_lift_limits(&f->app);
    lua_close(f->L);
}

void fuzz_close(FuzzState *f)
{
    if (!f->lost) {
        close_state(f);
        free(f);
        return;
    }
    f->next = lost;
    lost = f;
}

FuzzState *fuzz_again(FuzzState *f, const char *script, long long fuel)
{
    if (f && f->lost)
        fuzz_close(f);
    if (!f || f->lost)
        return fuzz_open(script, fuel);
    f->app.stop_code = 0;
    f->app.fuel = f->app.fuel_given = fuel;
    lua_settop(f->L, 0);
    lua_gc(f->L, LUA_GCCOLLECT, 0);
    return f;
}

lua_State *fuzz_lua(const FuzzState *f) { return f->L; }

static int run_text(FuzzState *f, const char *text, size_t size)
{
    lua_State *L = f->L;
    lua_settop(L, 0);
    lua_pushlstring(L, text, size);
    if (lib_load_source(L, f->app.script) != LUA_OK)
        return EXIT_SCRIPT;
    return app_call(L, &f->app, 0, 1);
}

int fuzz_run(FuzzState *f, const char *text, size_t size)
{
    if (f->lost || setjmp(f->back) != 0)
        return f->app.stop_code;
    return run_text(f, text, size);
}

/* ---- worlds ---- */

static dig_world *world_at(lua_State *L, int index)
{
    const WorldRef *ref = luaL_testudata(L, index, BIND_WORLD);
    return ref ? ref->w : NULL;
}

dig_world *fuzz_world(FuzzState *f)
{
    lua_State *L = f->L;
    if (f->lost)
        return NULL;
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "last_world");
    dig_world *w = world_at(L, -1);
    lua_pop(L, 2);
    return w;
}

void fuzz_worlds(FuzzState *f, void (*visit)(dig_world *w, void *context), void *context)
{
    lua_State *L = f->L;
    if (f->lost)
        return;
    lua_settop(L, 0);
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_getfield(L, -1, "worlds");
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
        if (world_at(L, -2))
            visit(world_at(L, -2), context);
    lua_settop(L, 0);
}

/* K keeps a thing where the grammar of the api target finds it. */
#define ROOM(text) "local digbox = require 'digbox'\nlocal K = K or function(_, v) return v end\n" text
const char *const fuzz_rooms[] = {
    ROOM("local w = digbox.world {} w:floor { material = 'tile' }\n"
         "w:box { name = 'a', size = 1, at = { 0, 0.5, 0 } } w:ball { name = 'b', radius = 0.3, at = { 0.1, 1.4, 0 }, velocity = { 1, 0, 0 } }\n"
         "w:step(5)\n"),
    ROOM("local w = digbox.world {}\n"
         "local a, b = w:box { size = 0.5, at = { 0, 2, 0 } }, w:capsule { radius = 0.1, length = 0.5, at = { 1, 2, 0 } }\n"
         "local h = w:hinge { a = a, at = { 0, 2, 0 }, axis = { 0, 0, 1 } } w:spring { a = a, b = b, stiffness = 50 }\n"
         "w:slider { a = b, axis = { 1, 0, 0 } } w:rope { a = a, b = b, length = 2 }\n"
         "local g = w:hinge { a = b, at = { 1, 2, 0 }, axis = { 0, 0, 1 } } w:gear { a = h, b = g, ratio = { 1, -2 } } w:step(4)\n"),
    ROOM("local w = digbox.world {}\n"
         "w:heightfield { size = { 2, 1, 2 }, heights = { { 0, 0.1, 0 }, { 0.1, 0, 0.2 }, { 0, 0.1, 0 } }, fixed = true }\n"
         "w:mesh { vertices = { { 5, 0, 0 }, { 6, 0, 0 }, { 5, 0, 1 }, { 6, 0.2, 1 } }, triangles = { { 1, 3, 2 }, { 2, 3, 4 } }, fixed = true }\n"
         "w:hull { points = { { 0, 0, 0 }, { 0.3, 0, 0 }, { 0, 0.3, 0 }, { 0, 0, 0.3 }, { 0.2, 0.2, 0.2 } }, at = { 0, 0.6, 0 } }\n"
         "w:cone { radius = 0.2, height = 0.3, at = { 5.3, 0.4, 0.3 } } w:cylinder { radius = 0.1, height = 0.2, at = { 0.5, 0.7, 0 } }\n"
         "w:step(6)\n"),
    ROOM("local w = digbox.world { seed = 3 } w:ambient { temperature = 290 } w:air {} w:water {}\n"
         "local a = w:box { size = 0.3, at = { 0, 0, 0 }, temperature = 400 } K('heater', w:heater { on = a, power = 20 })\n"
         "local b = w:ball { radius = 0.2, at = { 0.3, 0.1, 0 }, temperature = 280 }\n"
         "K('region', w:region { sphere = { radius = 1 }, at = { 0, 0, 0 }, laws = { drag = 1 } })\n"
         "K('link', w:link { a = a, b = b, layer = 'thermal' }) a:send(b, 'hello', 3, { after = 0.1 }) a:push { force = { 1, 2, 3 }, lasts = 1 }\n"
         "w:step(5)\n"),
    ROOM("local w = digbox.world {}\n"
         "K('cloth', w:cloth { at = { 0, 3, 0 }, across = { 1, 0, 0 }, down = { 0, -1, 0 }, columns = 2, rows = 2, mass = 1, stiffness = 1e3 })\n"
         "K('plank', w:plank { from = { 3, 1, 0 }, to = { 4, 1, 0 }, width = 0.1, height = 0.02, material = 'oak', segments = 2 })\n"
         "K('lattice', w:lattice { at = { 9, 3, 0 }, size = 1, cells = 1, mass = 1, stiffness = 1e3 })\n"
         "K('truss', w:truss { nodes = { A = { at = { 6, 1, 0 } }, B = { at = { 7, 1, 0 } } }, struts = { { 'A', 'B' } }, stiffness = 1e4 })\n"
         "w:step(2)\n"),
    ROOM("local w = digbox.world { accuracy = 'study' }\n"
         "w:box { kinematic = true, size = 1, at = { 0, 0, 0 } }:move_to { at = { 0, 1, 0 }, over = 1 }\n"
         "local t = w:body { parts = { digbox.box { size = 0.2 }, digbox.sphere { radius = 0.1, at = { 0.3, 0, 0 } } }, at = { 0, 2, 0 } }\n"
         "local gone = w:ball { radius = 0.1, at = { 3, 0, 0 } } gone:remove() K('room', w:room { size = 20 })\n"
         "w:ball { radius = 0.1, at = { 2, 1, 0 } } w:wheel { a = t, at = { 0, 2, 0 }, axis = { 1, 0, 0 } } w:step(3)\n"),
    ROOM("local w = digbox.world { seed = 5 } w:floor {}\n"
         "local p = digbox.parts K('door', p.door(w, { at = { 0, 0, 0 } })) K('lift', p.lift(w, { at = { 4, 0, 0 }, height = 2 }))\n"
         "K('drawer', p.drawer(w, { at = { 6, 0.5, 0 } })) K('clock', p.clock(w, { at = { 8, 1, 0 } })) w:step(2)\n"),
    ROOM("local w = digbox.world {} w:floor {}\n"
         "local p = digbox.parts K('ragdoll', p.ragdoll(w, { at = { 0, 1, 0 } })) K('truck', p.truck(w, { at = { 4, 0.5, 0 } }))\n"
         "K('lava_lamp', p.lava_lamp(w, { at = { 8, 0, 0 } })) w:step(2)\n"),
    NULL,
};

/* ---- files ---- */

static int memory_file = -1;
static char memory_path[64];

const char *fuzz_file(const unsigned char *data, size_t size)
{
    if (memory_file < 0)
        memory_file = memfd_create("fuzz", MFD_CLOEXEC);
    if (memory_file < 0 || ftruncate(memory_file, 0) != 0 || pwrite(memory_file, data, size, 0) != (ssize_t)size)
        fuzz_fail("no file in memory");
    snprintf(memory_path, sizeof memory_path, "/proc/self/fd/%d", memory_file);
    return memory_path;
}
