/* tests/peers/suite.c - runs the scenes on the engine that is linked in and prints a CSV row for each setting.
 *
 *   peer-ENGINE [SCENE]    e.g. peer-ode A07; without a scene: all of them
 *
 * The time is the processor time of the process per simulated second. States are read between the frames of the first run, which warms
 * caches and memory up, and of which only the step calls count, less what reading the clock takes; in the others nothing is between them
 * but what moves movers, and the least of those counts. What takes long is not repeated.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "suite.h"

enum { REPEATS = 25 };
#define LONG   1000.0       /* ms: what takes longer is not repeated */
#define ENOUGH 50.0         /* ms of the repeated runs together; all three as in tests/accuracy/suite.lua */

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* What two readings of the clock are apart with nothing between them, ms: a system call, as long as a step of one body in some engines. */
static double clock_ms(void)
{
    enum { READINGS = 1000, TRIES = 3 };
    double least = HUGE_VAL;
    for (int i = 0; i < TRIES; i++) {
        double ms = 0;
        for (int k = 0; k < READINGS; k++) {
            double before = cpu_ms();
            ms += cpu_ms() - before;
        }
        least = fmin(least, ms / READINGS);
    }
    return least;
}

static void body_inertia(const PeerBody *b, double inertia[3])
{
    for (int i = 0; i < 3; i++) {
        double p = b->size[(i + 1) % 3], q = b->size[(i + 2) % 3];
        inertia[i] = b->kind == PEER_SPHERE ? 0.4 * b->mass * b->size[0] * b->size[0] : b->mass * (p * p + q * q) / 3;
    }
}

/* From world to body axes, or back with the quaternion conjugated. */
static void turn_vector(const double q[4], int into_body, const double v[3], double out[3])
{
    double s = into_body ? -1 : 1, t[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        t[i] = 2 * s * (q[1 + j] * v[k] - q[1 + k] * v[j]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = v[i] + q[0] * t[i] + s * (q[1 + j] * t[k] - q[1 + k] * t[j]);
    }
}

typedef struct {
    double energy, kinetic, momentum[3], angular[3];
} Totals;

static Totals totals(const PeerScene *scene, const PeerState *state, int tracked)
{
    Totals sum = {0};
    for (int b = 0; b < tracked && b < scene->bodies; b++) {
        const PeerState *s = &state[b];
        double inertia[3], local[3], spin[3], mass = scene->body[b].mass;
        body_inertia(&scene->body[b], inertia);
        turn_vector(s->turn, 1, s->spin, local);
        for (int i = 0; i < 3; i++) {
            sum.kinetic += (mass * s->v[i] * s->v[i] + inertia[i] * local[i] * local[i]) / 2;
            sum.energy -= mass * scene->gravity[i] * s->at[i];
            local[i] *= inertia[i];
        }
        turn_vector(s->turn, 0, local, spin);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            sum.momentum[i] += mass * s->v[i];
            sum.angular[i] += spin[i] + mass * (s->at[j] * s->v[k] - s->at[k] * s->v[j]);
        }
    }
    sum.energy += sum.kinetic;
    return sum;
}

typedef struct {
    double error, ms_per_s, energy_drift, momentum_drift;
    int    finite;
    long   failures;
} Result;

/* Drift at the end: of the energy against the most kinetic energy seen, of the momenta against what they were. */
static void judge_drift(const PeerCase *c, const PeerScene *scene, const PeerRun *run, Result *result)
{
    Totals start = totals(scene, run->sample[0], c->tracked), now = start;
    double most = 0, zero[3] = {0};
    for (int k = 0; k <= run->frames; k++) {
        now = totals(scene, run->sample[k], c->tracked);
        most = fmax(most, now.kinetic);
        for (int b = 0; b < c->tracked && b < scene->bodies; b++)
            result->finite = result->finite && isfinite(run->sample[k][b].at[0] + run->sample[k][b].v[0]);
    }
    result->energy_drift = fmax(result->energy_drift, fabs(now.energy - start.energy) / most);
    double p = vector_distance(now.momentum, start.momentum), p0 = vector_distance(start.momentum, zero);
    double l = vector_distance(now.angular, start.angular), l0 = vector_distance(start.angular, zero);
    result->momentum_drift = fmax(result->momentum_drift, fmax(p0 > 0 ? p / p0 : p, l0 > 0 ? l / l0 : l));
}

static int run_once(const PeerCase *c, const PeerSetting *setting, PeerRun *run, Result *result)
{
    PeerScene scene = {.id = c->id, .gravity = {0, 0, -9.81}};
    c->build(&scene, c->variant);
    if (!peer_open(&scene, setting))
        return 0;
    double ms = 0, idle = clock_ms();
    run->frames = (int)(c->seconds * 60 + 0.5);
    for (int k = 0; k <= run->frames; k++) {
        for (int b = 0; b < c->tracked && b < scene.bodies; b++)
            peer_state(b, &run->sample[k][b]);
        if (k == run->frames)
            break;
        if (c->drive)
            c->drive(k / 60.0, c->variant);
        double before = cpu_ms();
        peer_advance(setting->rate / 60);
        ms += fmax(cpu_ms() - before - idle, 0);
    }
    *result = (Result){.finite = 1, .failures = peer_failures(), .ms_per_s = ms / c->seconds, .error = c->error(run, c->variant)};
    peer_close();
    judge_drift(c, &scene, run, result);
    return 1;
}

/* The frames with nothing between them but what moves movers, by one reading of the clock. -> ms a simulated second, or none */
static double time_bare(const PeerCase *c, const PeerSetting *setting)
{
    PeerScene scene = {.id = c->id, .gravity = {0, 0, -9.81}};
    c->build(&scene, c->variant);
    if (!peer_open(&scene, setting))
        return HUGE_VAL;
    int frames = (int)(c->seconds * 60 + 0.5);
    double begin = cpu_ms();
    for (int k = 0; k < frames; k++) {
        if (c->drive)
            c->drive(k / 60.0, c->variant);
        peer_advance(setting->rate / 60);
    }
    double ms = cpu_ms() - begin;
    peer_close();
    return ms / c->seconds;
}

static int run_setting(const PeerCase *c, const PeerSetting *setting, PeerRun *run, Result *least)
{
    if (!run_once(c, setting, run, least))
        return 0;
    double together = 0, best = HUGE_VAL;
    for (int k = 0; k < REPEATS && together < ENOUGH && least->ms_per_s * c->seconds < LONG; k++) {
        double ms = time_bare(c, setting);
        together += ms * c->seconds;
        best = fmin(best, ms);
    }
    least->ms_per_s = isfinite(best) ? best : least->ms_per_s;
    return 1;
}

static void print_row(const PeerCase *c, const PeerSetting *setting, const Result *r)
{
    long steps = (long)(c->seconds * setting->rate + 0.5);
    printf("%s,%s,%s,", c->id, peer_name, setting->name);
    if (r->finite)
        printf("%.4g", r->error);
    printf(",%.4g,%ld,", r->ms_per_s, steps);
    if (setting->calls)
        printf("%ld", steps * setting->calls);
    printf(",,,");
    if (r->finite && (c->conserves & PEER_ENERGY))
        printf("%.3g", r->energy_drift);
    printf(",");
    if (r->finite && (c->conserves & PEER_MOMENTUM))
        printf("%.3g", r->momentum_drift);
    printf(",");
    if (r->failures || !r->finite)
        printf("%ld", r->failures > 0 ? r->failures : 1);
    printf("\n");
    fflush(stdout);
}

int main(int argc, char **argv)
{
    PeerRun *run = calloc(1, sizeof *run);
    const char *wanted = argc > 1 ? argv[1] : "";
    int known = 0;
    for (const PeerCase *c = peer_cases; run && c->id; c++) {
        if (strncmp(c->id, wanted, strlen(wanted)) != 0)
            continue;
        known = 1;
        for (const PeerSetting *setting = peer_settings; setting->name; setting++) {
            Result result;
            if (run_setting(c, setting, run, &result))
                print_row(c, setting, &result);
        }
    }
    free(run);
    return run && known ? 0 : 77;
}
