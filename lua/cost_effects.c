/* lua/cost_effects.c - `digbox cost --effects`: the world with everything on, then without each effect that is on; table, CSV, bars.
 *
 * What an effect costs is what the world costs more with it than without it. Runs take turns, so that what else the machine does
 * meets all alike; medians of the repeats are compared, and their scatter is told as the clock's noise.
 */

#include "cost.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { ROUNDS = 7, EFFECTS = COST_EFFECTS };

typedef struct Bar {            /* one effect that is on */
    CostEffect e;
    real without[ROUNDS];       /* us per step, of each round    */
    real cost, noise;           /* us per step                   */
} Bar;

typedef struct Bars {
    const CostOptions *o;
    Bar  bar[EFFECTS];
    int  count, rounds;
    real with[ROUNDS];          /* us per step with everything on */
    real all, noise;            /* its median, and what the clock leaves open */
    uint32_t steps;
    real frame;
} Bars;

/* ---- medians ----------------------------------------------------------------- */

static int compare(const void *a, const void *b)
{
    const real x = *(const real *)a, y = *(const real *)b;
    return x < y ? -1 : x > y;
}

static real median(const real *x, int n)
{
    real sorted[ROUNDS];
    memcpy(sorted, x, (size_t)n * sizeof *x);
    qsort(sorted, (size_t)n, sizeof *sorted, compare);
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

/* Standard error of the median of n values, from their median absolute deviation (of a normal scatter: 1.4826 sigma, 1.2533 / sqrt n). */
static real scatter(const real *x, int n)
{
    real off[ROUNDS] = {0}, m = median(x, n);
    for (int i = 0; i < n; i++)
        off[i] = fabs(x[i] - m);
    return 1.4826 * 1.2533 * median(off, n) / sqrt(n);
}

/* ---- runs ---------------------------------------------------------------------- */

/* us per step of one run; < 0: it failed, and *code says how. */
static real run_without(const Bars *b, const char *off, CostRun *run, int *code)
{
    memset(run, 0, sizeof *run);
    run->budget = b->o->budget;
    run->expected = b->steps * b->frame;
    snprintf(run->off, sizeof run->off, "%s", off);
    if (!cost_run_once(b->o, b->o->run.accuracy, *off ? off : "all", run))
        *code = EXIT_INTERNAL;
    else if (app_signal())
        *code = 128 + app_signal();
    else if (run->end == COST_OVER_BUDGET || run->steps == 0)
        *code = EXIT_TIME;
    else if (run->end == COST_FAILED)
        *code = run->code ? run->code : EXIT_INTERNAL;
    return *code == EXIT_FINE ? 1e6 * run->cpu / run->steps : -1;
}

static void list_bars(Bars *b, const CostRun *run)
{
    for (int i = 0; i < run->effect_count; i++)
        if (run->effects[i].calls > 0 && b->count < EFFECTS)
            b->bar[b->count++].e = run->effects[i];
    b->steps = run->steps;
    b->frame = run->frame;
}

static int fail(const Bars *b, const char *off, const CostRun *run, int code)
{
    const char *what = *off ? off : "nothing";
    if (code >= 128)
        return code;
    if (code == EXIT_TIME)
        fprintf(stderr, "digbox: cost: the run with %s switched off does not end within %g s; --seconds N makes it shorter\n", what, b->o->budget);
    else if (*off)
        fprintf(stderr, "digbox: cost: with '%s' switched off: %s\n", off, run->message);
    else
        say_error(run->message);
    return code;
}

/* One round: with everything, then without each. An effect without which the world fails or does not end has no cost to tell. */
static int one_round(Bars *b, CostRun *run)
{
    int code = EXIT_FINE, r = b->rounds;
    b->with[r] = run_without(b, "", run, &code);
    if (code != EXIT_FINE)
        return fail(b, "", run, code);
    if (r == 0)
        list_bars(b, run);
    for (int i = 0; i < b->count; i++) {
        int end = EXIT_FINE;
        b->bar[i].without[r] = run_without(b, b->bar[i].e.name, run, &end);
        if (end >= 128)
            return end;
        if (end != EXIT_FINE && r == 0)
            fail(b, b->bar[i].e.name, run, end);
        if (end != EXIT_FINE)
            b->bar[i].without[r] = NAN;
    }
    b->rounds++;
    return EXIT_FINE;
}

static int compare_cost(const void *a, const void *b)
{
    const Bar *x = a, *y = b;
    if (isnan(x->cost) || isnan(y->cost))
        return isnan(x->cost) - isnan(y->cost);
    return x->cost > y->cost ? -1 : x->cost < y->cost;
}

static void judge(Bars *b)
{
    b->all = median(b->with, b->rounds);
    b->noise = scatter(b->with, b->rounds);
    for (int i = 0; i < b->count; i++) {
        Bar *bar = &b->bar[i];
        real gain[ROUNDS] = {0};
        bool there = true;
        for (int r = 0; r < b->rounds; r++) {
            there = there && !isnan(bar->without[r]);
            gain[r] = b->with[r] - bar->without[r];
        }
        bar->cost = there ? median(gain, b->rounds) : NAN;
        bar->noise = there ? scatter(gain, b->rounds) : NAN;
    }
    qsort(b->bar, (size_t)b->count, sizeof *b->bar, compare_cost);
}

/* ---- table, CSV, bars --------------------------------------------------------------- */

static real share(const Bars *b, const Bar *bar) { return b->all > 0 ? 100 * bar->cost / b->all : 0; }

static void print_table(const Bars *b)
{
    printf("%s: %u frame steps of %.4g s, %.4g us a step with everything on (median of %d runs, +- %.2g us)\n", b->o->run.world, b->steps, b->frame,
           b->all, b->rounds, b->noise);
    printf("\n%-16s %10s %9s %8s %10s %8s %10s  %s\n", "effect", "us a step", "+-", "share, %", "inside, us", "bodies", "bytes", "called for by");
    for (int i = 0; i < b->count; i++) {
        const Bar *bar = &b->bar[i];
        if (isnan(bar->cost))
            printf("%-16s %10s %9s %8s", bar->e.name, "-", "-", "-");
        else
            printf("%-16s %10.3f %9.3f %8.1f", bar->e.name, bar->cost, bar->noise, share(b, bar));
        printf(" %10.3f %8d %10zu  %s\n", bar->e.us, bar->e.bodies, bar->e.bytes, bar->e.why);
    }
    printf("\nus a step: what the world costs more with the effect than without it. Where the world goes another way without it, that\n"
           "may be less than nothing. inside: in the effect's own functions, in each sixteenth step; what a solver does for its rows is\n"
           "not in it. The clock's noise is the standard error of the median of %d rounds.\n", b->rounds);
}

static bool write_csv(const Bars *b, const char *path)
{
    TextFile t;
    if (!text_begin(&t, path))
        return false;
    FILE *f = t.text;
    fputs("effect,us_per_step,noise_us,share_percent,inside_us,bodies,bytes,calls,all_us_per_step,all_noise_us,rounds,why\n", f);
    for (int i = 0; i < b->count; i++) {
        const Bar *bar = &b->bar[i];
        fprintf(f, "%s,%.6g,%.6g,%.6g,%.6g,%d,%zu,%llu,%.6g,%.6g,%d,\"", bar->e.name, bar->cost, bar->noise, share(b, bar), bar->e.us,
                bar->e.bodies, bar->e.bytes, (unsigned long long)bar->e.calls, b->all, b->noise, b->rounds);
        for (const char *p = bar->e.why; *p; p++)
            fputs(*p == '"' ? "\"\"" : (char[]){*p, '\0'}, f);
        fputs("\"\n", f);
    }
    return text_place(&t, path) == EXIT_FINE;
}

static void put_rows(FILE *f, const Bars *b)
{
    int row = 0;
    fputs("$effects << EOD\n", f);
    for (int i = 0; i < b->count; i++) {
        const Bar *bar = &b->bar[i];
        if (isnan(bar->cost))
            continue;
        fprintf(f, "%d %.6g %.6g \"%s\" \"%.3g us, %.1f %%; %d bod%s, %zu bytes\"\n", row--, bar->cost, bar->noise, bar->e.name, bar->cost,
                share(b, bar), bar->e.bodies, bar->e.bodies == 1 ? "y" : "ies", bar->e.bytes);
    }
    fputs("EOD\n", f);
}

static void put_picture(FILE *f, const char *folder, const char *terminal, const char *ending)
{
    char path[1100];
    snprintf(path, sizeof path, "%s/effects.%s", folder, ending);
    fprintf(f, "%s\nset output ", terminal);
    cost_put_quoted(f, path);
    fputs("\nplot $effects using (0.5*$2):1:(0.5*abs($2)):(0.36):yticlabels(4) with boxxyerror fs solid 1 lc rgb '#4a6fa5' notitle, \\\n"
          "     $effects using 2:1:3 with xerrorbars pt -1 lw 2 lc rgb '#b3261e' title \"the clock's noise\", \\\n"
          "     $effects using ($2 > 0 ? $2 + $3 : 0):1:5 with labels left offset 1.2,0 font ',11' tc rgb '#303030' notitle\n"
          "set output\n", f);
}

static void write_script(FILE *f, const Bars *b, const char *folder)
{
    const char *slash = strrchr(b->o->run.world, '/'), *name = slash ? slash + 1 : b->o->run.world;
    char title[1300];
    real most = 0, least = 0;
    for (int i = 0; i < b->count; i++) {
        most = fmax(most, b->bar[i].cost + b->bar[i].noise);
        least = fmin(least, b->bar[i].cost - b->bar[i].noise);
    }
    real width = most - least > 0 ? most - least : 1;
    fputs("# gnuplot: the bars of digbox cost --effects\n", f);
    put_rows(f, b);
    snprintf(title, sizeof title, "%s: what each effect costs, of %.4g us a step", name, b->all);
    fputs("set title ", f);
    cost_put_quoted(f, title);
    fprintf(f, " font ',16' noenhanced\nset xlabel 'CPU time per step with the effect, less that without it, us'\nset xrange [%.4g:%.4g]\n"
               "set yrange [%.1f:0.7]\n", least < 0 ? least - 0.04 * width : 0, most + 0.62 * width, 0.3 - b->count);
    fputs("set ytics nomirror noenhanced\nset xtics nomirror\nset grid xtics lt 1 lc rgb '#e4e4e4'\nset border 3 lc rgb '#606060'\n"
          "set tics tc rgb '#303030'\nset key bottom right\nset arrow 1 from 0, graph 0 to 0, graph 1 nohead lc rgb '#606060'\n", f);
    int high = 160 + 44 * (b->count > 4 ? b->count : 4);
    snprintf(title, sizeof title, "if (strstrt(GPVAL_TERMINALS, 'pngcairo') > 0) { set terminal pngcairo size 1100,%d font 'DejaVu Sans,12' } "
             "else { set terminal png size 1100,%d }", high, high);
    put_picture(f, folder, title, "png");
    snprintf(title, sizeof title, "set terminal svg size 1100,%d font 'DejaVu Sans,12' background rgb 'white'", high);
    put_picture(f, folder, title, "svg");
}

static int write_all(const Bars *b)
{
    char path[1100];
    const char *folder = b->o->run.out;
    snprintf(path, sizeof path, "%s/effects.csv", folder);
    if (!write_csv(b, path))
        return EXIT_OUTPUT;
    snprintf(path, sizeof path, "%s/effects.gp", folder);
    TextFile t;
    if (!text_begin(&t, path))
        return EXIT_OUTPUT;
    write_script(t.text, b, folder);
    if (text_place(&t, path) != EXIT_FINE)
        return EXIT_OUTPUT;
    int code = b->count > 0 ? cost_run_gnuplot(path) : 1;
    if (code == 0)
        printf("\nThe table is in %s/effects.csv, the bars in %s/effects.svg and %s/effects.png.\n", folder, folder, folder);
    else
        printf("\nThe table is in %s/effects.csv. No bars: %s.\n", folder,
               b->count == 0 ? "nothing is on" : code == 127 ? "gnuplot is not installed here" : "gnuplot failed");
    return EXIT_FINE;
}

int cost_effects(const CostOptions *o)
{
    Bars *b = calloc(1, sizeof *b);
    CostRun *run = cost_new_run();
    int code = b && run ? EXIT_FINE : EXIT_MEMORY;
    if (code == EXIT_FINE) {
        b->o = o;
        while (code == EXIT_FINE && b->rounds < ROUNDS)
            code = one_round(b, run);
    }
    if (code == EXIT_FINE) {
        if (!o->run.quiet)
            cost_clear_progress(o);
        judge(b);
        print_table(b);
        code = write_all(b);
    }
    cost_free_run(run);
    free(b);
    return code;
}
