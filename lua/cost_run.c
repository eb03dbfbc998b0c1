/* lua/cost_run.c - one run of `digbox cost`: the script as `digbox run` has it, without pictures, its states kept in a record. */

#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include <lauxlib.h>

#include "bind.h"
#include "cost.h"
#include "state.h"

/* A run whose prediction is beyond this many budgets is stopped once it has used a quarter of one. */
static const real HOPELESS = 2, FIRST_LOOK = 0.25;

/* Wall time of a run, in budgets, after which it is stopped although its frame steps keep the budget. */
static const real PATIENCE = 3;

static real cpu_of_process(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (real)t.tv_sec + 1e-9 * (real)t.tv_nsec;
}

static CostRun *run_of(lua_State *L)
{
    return lua_touserdata(L, lua_upvalueindex(1));
}

/* ---- states ------------------------------------------------------------------- */

static real size_of(const dig_body_state *s)
{
    real x = s->high.x - s->low.x, y = s->high.y - s->low.y, z = s->high.z - s->low.z;
    return fmax(1e-12, 0.5 * fmax(x, fmax(y, z)));
}

/* Keeps every second of the frames that are there. */
static void thin(CostRun *r)
{
    int kept = 0;
    r->stride *= 2;
    for (int i = 0; i < r->count; i++)
        if (r->rows[i].step % r->stride == 0)
            r->rows[kept++] = r->rows[i];
    r->count = kept;
}

static void keep_frame(CostRun *r, const dig_world *w, const dig_body *bodies, int n, bool last)
{
    dig_body_state s;
    int moving = 0;
    for (int i = 0; i < n; i++)
        moving += dig_body_get(w, bodies[i], &s) == DIG_OK && s.kind == DIG_DYNAMIC;
    r->moving = moving > r->moving ? moving : r->moving;
    if (moving > COST_ROWS / 4) {
        moving = COST_ROWS / 4;
        r->cut = true;
    }
    while (r->count + moving > COST_ROWS)
        thin(r);
    if (r->steps % r->stride != 0 && !last)
        return;
    for (int i = 0; i < n && moving > 0; i++) {
        if (dig_body_get(w, bodies[i], &s) != DIG_OK || s.kind != DIG_DYNAMIC)
            continue;
        r->rows[r->count++] = (CostRow){r->steps, bodies[i].slot, bodies[i].gen - r->first_gen, 0, size_of(&s), s.position, s.rotation};
        moving--;
    }
}

/* Numbers in [-1, 1] that depend on the body alone (splitmix64: Steele, Lea and Flood 2014). */
static real scatter(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return (real)(z >> 11) / (real)(UINT64_C(1) << 52) - 1;
}

static void perturb(const CostRun *r, dig_world *w, const dig_body *bodies, int n)
{
    dig_body_state s;
    for (int i = 0; i < n; i++) {
        uint64_t seed = bodies[i].slot;
        if (dig_body_get(w, bodies[i], &s) != DIG_OK || s.kind != DIG_DYNAMIC)
            continue;
        real far = r->perturb * size_of(&s), x = scatter(&seed), y = scatter(&seed), z = scatter(&seed);
        real length = fmax(1e-3, sqrt(x * x + y * y + z * z));
        vec3 at = {s.position.x + far * x / length, s.position.y + far * y / length, s.position.z + far * z / length};
        dig_body_teleport(w, bodies[i], &at, NULL, NULL, NULL);
    }
}

/* ---- counts ------------------------------------------------------------------- */

static void count_step(CostRun *r, const dig_world *w, real cpu)
{
    dig_stats s = dig_world_stats(w);
    const real us[] = {s.us_sense, s.us_touch, s.us_graph, s.us_advance, s.us_commit, s.us_report};
    const dig_event *events;
    int n = dig_events(w, &events);
    r->steps++;
    r->cpu += cpu;
    r->substeps += (uint64_t)s.substeps;
    r->iterations += (uint64_t)s.iterations;
    r->evaluations += (uint64_t)s.evaluations;
    r->refused += (uint64_t)s.refused;
    r->trace_events += (uint64_t)s.trace_events;
    r->gave_up = s.gave_up;
    snprintf(r->gave_up_why, sizeof r->gave_up_why, "%s", s.gave_up_why);
    r->us[COST_PHASES - 1] += 1e6 * cpu;
    for (int i = 0; i < COST_PHASES - 1; i++) {
        r->us[i] += us[i];
        r->us[COST_PHASES - 1] -= us[i];
    }
    r->events += (uint64_t)n;
    for (int i = 0; i < n; i++) {
        r->contacts += events[i].kind == DIG_EVENT_CONTACT_BEGIN;
        r->impacts += events[i].kind == DIG_EVENT_IMPACT;
    }
    r->drift = dig_world_energy(w).numerical;
}

/* What it asks for is switched off: before the first step, and whenever the script has switched it on again. */
static void switch_off(const CostRun *r, dig_world *w)
{
    dig_effect_info e;
    for (int i = 0; r->off[0] && i < dig_effect_count(w); i++)
        if (dig_effect_get(w, i, &e) == DIG_OK && e.allowed && strcmp(e.name, r->off) == 0)
            dig_effect_set(w, r->off, false);
}

static void count_effects(CostRun *r, const dig_world *w)
{
    dig_effect_info e;
    r->effect_count = 0;
    for (int i = 0; i < COST_EFFECTS && i < dig_effect_count(w); i++) {
        CostEffect *kept = &r->effects[r->effect_count++];
        if (dig_effect_get(w, i, &e) != DIG_OK)
            continue;
        int most = strcmp(kept->name, e.name) == 0 && kept->bodies > e.bodies ? kept->bodies : e.bodies;
        *kept = (CostEffect){.bodies = most, .bytes = e.bytes, .calls = e.calls, .us = e.us_mean};
        snprintf(kept->name, sizeof kept->name, "%s", e.name);
        snprintf(kept->why, sizeof kept->why, "%s", e.why);
    }
}

/* Has the run used its budget, or will it never keep it? */
static bool is_over(CostRun *r)
{
    real used = cpu_of_process(), done = r->steps * r->frame;
    bool hopeless = r->expected > 0 && used > FIRST_LOOK * r->budget && used * r->expected > HOPELESS * r->budget * done;
    if (used <= r->budget && !hopeless)
        return false;
    r->end = COST_OVER_BUDGET;
    return true;
}

static dig_body *list_bodies(lua_State *L, dig_world *w, int *n)
{
    *n = dig_bodies(w, NULL, 0);
    dig_body *bodies = lua_newuserdatauv(L, (size_t)(*n + 1) * sizeof *bodies, 0);
    *n = dig_bodies(w, bodies, *n);
    return bodies;
}

/* core.cost_sample(world, s of CPU time) -> true when the budget is used up; the first call comes before the first step */
static int cost_sample(lua_State *L)
{
    CostRun *r = run_of(L);
    dig_world *w = bind_check_world(L, 1)->w;
    int n;
    dig_body *bodies = list_bodies(L, w, &n);
    bool begins = r->frame <= 0;
    if (begins && n > 0)
        r->first_gen = bodies[0].gen;
    r->frame = dig_world_frame(w);
    if (begins && r->perturb > 0)
        perturb(r, w, bodies, n);
    if (!begins)
        count_step(r, w, luaL_checknumber(L, 2));
    switch_off(r, w);
    count_effects(r, w);
    keep_frame(r, w, bodies, n, false);
    lua_pushboolean(L, !begins && is_over(r));
    return 1;
}

/* core.cost_last(world): the last frame is kept, whatever the stride */
static int cost_last(lua_State *L)
{
    CostRun *r = run_of(L);
    int n;
    dig_world *w = bind_check_world(L, 1)->w;
    bind_explain(L, 1);
    count_effects(r, w);
    dig_body *bodies = list_bodies(L, w, &n);
    if (r->count == 0 || r->rows[r->count - 1].step != r->steps)
        keep_frame(r, w, bodies, n, true);
    return 0;
}

/* core.cost_several(): another world takes a step */
static int cost_several(lua_State *L)
{
    run_of(L)->several = true;
    return 0;
}

/* ---- the run -------------------------------------------------------------------- */

static int open_cost(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"cost_sample", cost_sample}, {"cost_last", cost_last}, {"cost_several", cost_several}, {NULL, NULL},
    };
    lua_getfield(L, LUA_REGISTRYINDEX, "digbox.core");
    lua_pushvalue(L, 1);
    luaL_setfuncs(L, functions, 1);
    bind_use(L, "cost");
    return 0;
}

static void note_stop(void *data, int code, const char *text)
{
    CostRun *run = data;
    run->end = COST_FAILED;
    run->code = code;
    snprintf(run->message, sizeof run->message, "%s", text);
    if (code == EXIT_TIME)
        snprintf(run->message + strcspn(run->message, ";"), sizeof run->message - strcspn(run->message, ";"),
                 ": it does not come to its end in %g s; --budget S gives it more", PATIENCE * run->budget + 5);
}

int cost_run_world(const RunOptions *o, CostRun *run)
{
    App app = {.memory_limit = (size_t)o->memory << 20, .fuel = o->fuel, .trust = o->trust, .script = o->world, .out = o->out,
               .jailed = true, .log_limit = 1 << 20, .stopped = note_stop, .stopped_data = run};
    run->end = COST_RUNNING;
    run->stride = 1;
    app_limit_time(&app, PATIENCE * run->budget + 5);          /* for scripts that do not get on at all */
    lua_State *L = app_open(&app);
    if (!L)
        return EXIT_INTERNAL;
    lua_pushcfunction(L, run_set_options);
    lua_pushlightuserdata(L, (void *)(uintptr_t)o);
    int code = app_call(L, &app, 1, 0);
    if (code == EXIT_FINE) {
        lua_pushcfunction(L, open_cost);
        lua_pushlightuserdata(L, run);
        code = app_call(L, &app, 1, 0);
    }
    if (code == EXIT_FINE)
        code = app_run_file(L, &app);
    if (code == EXIT_FINE)
        code = app_call_core(L, &app, "cost_finish", 0, 0);
    if (code != EXIT_FINE)
        snprintf(run->message, sizeof run->message, "%s", lua_isstring(L, -1) ? lua_tostring(L, -1) : "failed");
    if (run->end == COST_RUNNING)
        run->end = code == EXIT_FINE ? COST_COMPLETE : COST_FAILED;
    lua_close(L);
    return code;
}
