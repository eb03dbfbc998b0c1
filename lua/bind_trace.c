/* lua/bind_trace.c - `digbox run --trace FILE`: what every frame step spent its time on, as Chrome's trace format (JSON array), to be
 * looked at in chrome://tracing, Perfetto or Speedscope.
 *
 * The array may lack its end, so the trace of a run that was killed can be read, too. */
#define _POSIX_C_SOURCE 200809L
#include "bind.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define TRACE_FILE "digbox.trace"

typedef struct TraceFile { FILE *file; double zero; } TraceFile;      /* zero: us, on the monotonic clock */

static double now_us(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

/* core.trace_open(path) -> trace, or nil and why not */
static int trace_open(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1);
    TraceFile *t = lua_newuserdatauv(L, sizeof *t, 0);
    *t = (TraceFile){.zero = now_us()};
    luaL_setmetatable(L, TRACE_FILE);
    t->file = fopen(path, "w");
    if (!t->file) {
        lua_pushnil(L);
        lua_pushstring(L, strerror(errno));
        return 2;
    }
    fputs("[\n{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":1,\"args\":{\"name\":\"digbox\"}}", t->file);
    return 1;
}

static void span(TraceFile *t, const char *name, double at, double us)
{
    fprintf(t->file, ",\n{\"name\":\"%s\",\"ph\":\"X\",\"pid\":1,\"tid\":1,\"ts\":%.3f,\"dur\":%.3f}", name, at, us);
}

/* Phases follow each other; contacts are found while groups are advanced. */
static void phases(TraceFile *t, double at, const dig_stats *s)
{
    const struct { const char *name; double us; } phase[] = {
        {"sense", s->us_sense}, {"advance", s->us_advance + s->us_touch}, {"commit", s->us_commit},
        {"graph", s->us_graph}, {"report", s->us_report},
    };
    for (int i = 0; i < 5; i++) {
        span(t, phase[i].name, at, phase[i].us);
        if (i == 1)
            span(t, "touch", at, s->us_touch);
        at += phase[i].us;
    }
}

static void counts(TraceFile *t, double at, const dig_stats *s)
{
    fprintf(t->file, ",\n{\"name\":\"counts\",\"ph\":\"C\",\"pid\":1,\"ts\":%.3f,\"args\":{\"awake\":%d,\"contacts\":%d,\"pairs\":%d}}", at, s->awake,
            s->contacts, s->pairs);
    fprintf(t->file, ",\n{\"name\":\"groups\",\"ph\":\"C\",\"pid\":1,\"ts\":%.3f,\"args\":{\"traced\":%d,\"conserved\":%d,\"swept\":%d}}", at,
            s->traced, s->conserved, s->swept);
}

/* core.trace_step(trace, world): a frame step. True when it was written. */
static int trace_step(lua_State *L)
{
    TraceFile *t = luaL_checkudata(L, 1, TRACE_FILE);
    dig_world *w = bind_check_world(L, 2)->w;
    dig_time_every_step(w, true);
    double begin = now_us();
    bind_step(L, 2);
    double end = now_us();
    dig_stats s = dig_world_stats(w);
    fprintf(t->file, ",\n{\"name\":\"step\",\"ph\":\"X\",\"pid\":1,\"tid\":1,\"ts\":%.3f,\"dur\":%.3f,\"args\":{\"t\":%.9g,\"substeps\":%d,"
            "\"iterations\":%d,\"evaluations\":%d,\"located\":%d,\"residual\":%.3g}}", begin - t->zero, end - begin, dig_world_time(w), s.substeps,
            s.iterations, s.evaluations, s.located, s.residual < 1e300 ? s.residual : 1e300);
    phases(t, begin - t->zero, &s);
    counts(t, begin - t->zero, &s);
    lua_pushboolean(L, !ferror(t->file));
    return 1;
}

/* core.trace_close(trace): true when all was written */
static int trace_close(lua_State *L)
{
    TraceFile *t = luaL_checkudata(L, 1, TRACE_FILE);
    bool fine = true;
    if (t->file) {
        fputs("\n]\n", t->file);
        fine = !ferror(t->file);
        fine = fclose(t->file) == 0 && fine;
        t->file = NULL;
    }
    lua_pushboolean(L, fine);
    return 1;
}

void bind_trace_open(lua_State *L, int core)
{
    bind_held_type(L, TRACE_FILE, trace_close);
    lua_pushcfunction(L, trace_open);
    lua_setfield(L, core, "trace_open");
    lua_pushcfunction(L, trace_step);
    lua_setfield(L, core, "trace_step");
    lua_pushcfunction(L, trace_close);
    lua_setfield(L, core, "trace_close");
}
