/* tests/bench/run.c - runs one scene on the engine that is linked in and prints what was measured as a row for report.lua.
 *
 *   ENGINE SCENE N THREADS SECONDS      N = 0: the published size; no step begins after SECONDS of processor time, or twice that
 *                                       by the wall clock
 *
 * The process keeps to one processor for each thread where it may. Time is the processor time of the process (one thread) and
 * the wall clock, of every step; the checker looks at the poses after the last one.
 */
#include <dirent.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#include "engine.h"

enum { CANNOT = 77, WARM_STEPS = 300, MOST_THREADS = 64 };

typedef struct { double seconds, *cpu, *wall; int steps; double create_ms, warm_ms, before_mb, rss_mb; int awake; } Run;

static double clock_ms(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* MB that the process holds now: before there is a world, the program and the scene's list. 0: not known. */
static double resident_mb(void)
{
    long size, pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    if (!f)
        return 0;
    if (fscanf(f, "%ld %ld", &size, &pages) != 2)
        pages = 0;
    fclose(f);
    return (double)pages * (double)sysconf(_SC_PAGESIZE) / 1048576;
}

static int by_number(const void *a, const void *b)
{
    const long *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* One processor for each thread, last first: the first one serves interrupts more often. */
static void pin(void)
{
    cpu_set_t allowed, one;
    long thread[MOST_THREADS];
    size_t cpu[CPU_SETSIZE], cpus = 0;
    int threads = 0;
    DIR *tasks = opendir("/proc/self/task");
    if (!tasks)
        return;
    for (struct dirent *e = readdir(tasks); e; e = readdir(tasks))
        if (e->d_name[0] != '.' && threads < MOST_THREADS)
            thread[threads++] = strtol(e->d_name, NULL, 10);
    closedir(tasks);
    qsort(thread, (size_t)threads, sizeof *thread, by_number);
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0)
        return;
    for (size_t i = CPU_SETSIZE; i-- > 0;)
        if (CPU_ISSET(i, &allowed))
            cpu[cpus++] = i;
    for (int i = 0; i < threads && cpus > 0; i++) {
        CPU_ZERO(&one);
        CPU_SET(cpu[(size_t)i % cpus], &one);
        if (sched_setaffinity((pid_t)thread[i], sizeof one, &one) != 0)
            fprintf(stderr, "%s: not pinned\n", bench_engine);
    }
}

/* Until everything sleeps, which may take twice the time of the rest; then the ball is sent down its lane. */
static void fall_asleep(const BenchScene *s, Run *r)
{
    double begin = clock_ms(CLOCK_PROCESS_CPUTIME_ID), now = begin, wall_end = clock_ms(CLOCK_MONOTONIC) + 4e3 * r->seconds;
    int steps = 0;
    do {
        bench_step();
        steps++;
        r->awake = bench_awake();
        now = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
    } while (r->awake > 0 && steps < WARM_STEPS && now - begin < 2e3 * r->seconds && clock_ms(CLOCK_MONOTONIC) < wall_end);
    r->warm_ms = (now - begin) / steps;
    bench_kick(s->ball, (double[3]){8, 0, 0});
}

static void run_steps(const BenchScene *s, Run *r)
{
    double wall_end = clock_ms(CLOCK_MONOTONIC) + 2e3 * r->seconds, cpu_end = clock_ms(CLOCK_PROCESS_CPUTIME_ID) + 1e3 * r->seconds;
    for (; r->steps < s->steps; r->steps++) {
        double wall = clock_ms(CLOCK_MONOTONIC), cpu = clock_ms(CLOCK_PROCESS_CPUTIME_ID);
        if (wall > wall_end || cpu > cpu_end)
            break;
        bench_step();
        r->cpu[r->steps] = clock_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu;
        r->wall[r->steps] = clock_ms(CLOCK_MONOTONIC) - wall;
        if (r->steps >= s->steps / 3)
            bench_sample();
    }
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    r->rss_mb = (double)used.ru_maxrss / 1024;
}

static void print_steps(const char *name, const double *ms, int steps)
{
    printf(", %s = {", name);
    for (int i = 0; i < steps; i++)
        printf("%.4g,", ms[i]);
    printf("}");
}

static void print_row(const BenchScene *s, const Run *r, int threads, const BenchFound *f)
{
    int moving = 0;
    for (int i = 0; i < s->bodies; i++)
        moving += !s->body[i].fixed;
    printf("row{scene = '%s', n = %d, engine = '%s', threads = %d, moving = %d, steps = %d, steps_wanted = %d", s->name, s->n,
           bench_engine, threads, moving, r->steps, s->steps);
    printf(", before_mb = %.1f, rss_mb = %.1f, penetration_max_mm = %.4g, penetration_mean_mm = %.4g, overlaps = %d", r->before_mb, r->rss_mb,
           f->penetration_max * 1e3, f->penetration_mean * 1e3, f->overlaps);
    printf(", top_height_m = %.5g, joint_error_mm = %.4g, lost = %d, create_ms = %.4g", f->top_height, f->joint_error * 1e3, f->lost,
           r->create_ms);
    if (s->sleeping)
        printf(", awake_before = %d, warm_ms = %.4g", r->awake, r->warm_ms);
    bench_report(stdout);
    print_steps("cpu", r->cpu, r->steps);
    print_steps("wall", r->wall, r->steps);
    printf("}\n");
}

int main(int argc, char **argv)
{
    BenchScene scene;
    if (argc != 5 || !bench_scene(&scene, argv[1], (int)strtol(argv[2], NULL, 10))) {
        fprintf(stderr, "usage: %s SCENE N THREADS SECONDS\n", argv[0]);
        return 2;
    }
    int threads = (int)strtol(argv[3], NULL, 10);
    Run run = {.seconds = strtod(argv[4], NULL)};
    run.cpu = calloc((size_t)scene.steps, sizeof *run.cpu);
    run.wall = calloc((size_t)scene.steps, sizeof *run.wall);
    BenchPose *pose = calloc((size_t)scene.bodies, sizeof *pose);
    if (!run.cpu || !run.wall || !pose)
        return 2;
    run.before_mb = resident_mb();
    double begin = clock_ms(CLOCK_MONOTONIC);
    if (!bench_open(&scene, threads))
        return CANNOT;
    run.create_ms = clock_ms(CLOCK_MONOTONIC) - begin;
    pin();
    if (scene.sleeping)
        fall_asleep(&scene, &run);
    run_steps(&scene, &run);
    for (int i = 0; i < scene.bodies; i++)
        bench_pose(i, &pose[i]);
    BenchFound found;
    bench_check(&scene, pose, &found);
    print_row(&scene, &run, threads, &found);
    return 0;
}
