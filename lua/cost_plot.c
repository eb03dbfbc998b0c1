/* lua/cost_plot.c - the plot of `digbox cost`: error against CPU time, both logarithmic, drawn by gnuplot. */

#define _POSIX_C_SOURCE 200809L

#include "cost.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "state.h"

typedef struct Range { real low, high; } Range;

/* What the plot shows, and where an error of nothing stands. */
typedef struct Frame { Range x, y; real bottom; bool nothing; } Frame;

static bool is_shown(const Cost *c, const CostSetting *s)
{
    return s->run && s->run->end == COST_COMPLETE && s->error.compared > 0 && c->compared > 0 && cost_ms_per_second(s->run) > 0;
}

static void include(Range *r, real x)
{
    r->low = fmin(r->low, x);
    r->high = fmax(r->high, x);
}

static real decade_below(real x) { return pow(10, floor(log10(x) + 1e-9)); }
static real decade_above(real x) { return pow(10, ceil(log10(x) - 1e-9)); }

static Frame frame_of(const Cost *c)
{
    Frame f = {{INFINITY, 0}, {INFINITY, 0}, 0, false};
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        if (!is_shown(c, s))
            continue;
        include(&f.x, cost_ms_per_second(s->run));
        if (s->error.max > 0)
            include(&f.y, s->error.max);
        else
            f.nothing = true;
    }
    include(&f.y, c->o->within);
    f.bottom = decade_below(f.y.low) / 10;
    f.x = (Range){decade_below(f.x.low / 1.3), decade_above(f.x.high * 1.6)};
    f.y = (Range){f.nothing ? f.bottom / 3 : decade_below(f.y.low), decade_above(f.y.high * 2)};
    return f;
}

static real height(const Frame *f, const CostSetting *s)
{
    return s->error.max > 0 ? s->error.max : f->bottom;
}

/* Text within '...' of gnuplot: quotes are doubled. */
void cost_put_quoted(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++) {
        if (*text == '\'')
            fputc('\'', out);
        fputc((unsigned char)*text < 0x20 ? ' ' : *text, out);
    }
    fputc('\'', out);
}

/* Are two points so near that one label would cover the other? */
static bool near(const Frame *f, const CostSetting *a, const CostSetting *b)
{
    real x = log10(cost_ms_per_second(a->run) / cost_ms_per_second(b->run)) / log10(f->x.high / f->x.low);
    real y = log10(height(f, a) / height(f, b)) / log10(f->y.high / f->y.low);
    return fabs(x) < 0.08 && fabs(y) < 0.04;
}

/* The names of all plans, or of the first number, at that point; none where they stand with an earlier point. */
static void put_label(FILE *out, const Cost *c, const Frame *f, int index)
{
    const CostSetting *s = &c->settings[index];
    for (int i = 0; i < index; i++)
        if (c->settings[i].plan == s->plan && is_shown(c, &c->settings[i]) && near(f, s, &c->settings[i])) {
            fputs(" \"\"\n", out);
            return;
        }
    fprintf(out, " \"%s", s->name);
    for (int i = index + 1; i < c->count && s->plan; i++)
        if (c->settings[i].plan && is_shown(c, &c->settings[i]) && near(f, s, &c->settings[i]))
            fprintf(out, ", %s", c->settings[i].name);
    fputs("\"\n", out);
}

static void put_points(FILE *out, const Cost *c, const Frame *f, bool plans)
{
    fprintf(out, "$%s << EOD\n", plans ? "plans" : "ladder");
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        if (!is_shown(c, s) || s->plan != plans)
            continue;
        if (s->error.max <= 0)      /* no line leads there: that is no error */
            fputc('\n', out);
        fprintf(out, "%.9g %.9g", cost_ms_per_second(s->run), height(f, s));
        put_label(out, c, f, i);
    }
    fputs("EOD\n", out);
}

static void put_titles(FILE *out, const Cost *c)
{
    char title[1200];
    const char *slash = strrchr(c->o->run.world, '/'), *name = slash ? slash + 1 : c->o->run.world;
    snprintf(title, sizeof title, "%s: what accuracy costs", name);
    fputs("set title ", out);
    cost_put_quoted(out, title);
    if (c->twins.apart)
        fprintf(out, ".\"\\n%s from t = %.4g s on: errors end there\"", c->twins.jump ? "not repeatable" : "chaotic", c->twins.horizon);
    fputs(" font ',16' noenhanced\nset xlabel 'CPU time per simulated second, ms'\n", out);
    snprintf(title, sizeof title, "error against %s%s, m (largest of all bodies, t = 0 to %.4g s)", c->settings[c->reference].plan ? "" :
             "a tolerance of ", c->settings[c->reference].name, c->compared);
    fputs("set ylabel ", out);
    cost_put_quoted(out, title);
    fputs(" noenhanced\n", out);
}

/* One picture; the data stand above. */
static void put_picture(FILE *out, const char *folder, const char *terminal, const char *ending)
{
    char path[1100];
    snprintf(path, sizeof path, "%s/cost.%s", folder, ending);
    fprintf(out, "%s\nset output ", terminal);
    cost_put_quoted(out, path);
    fputs("\nplot $ladder using 1:2 with linespoints ls 1 title 'tolerances in metres', \\\n"
          "     $ladder using 1:2:3 with labels offset -1.2,-0.9 font ',9' tc rgb '#4a6fa5' notitle, \\\n"
          "     $plans using 1:2 with points ls 2 title 'plans', \\\n"
          "     $reference using 1:2 with points ls 3 title 'reference', \\\n"
          "     $plans using 1:2:3 with labels offset 0,1.2 font ',13' tc rgb '#b3261e' notitle\n"
          "set output\n", out);
}

static void write_script(FILE *out, const Cost *c, const char *folder)
{
    const Frame f = frame_of(c);
    char bound[32];
    fputs("# gnuplot: the plot of digbox cost\n", out);
    put_points(out, c, &f, false);
    put_points(out, c, &f, true);
    fprintf(out, "$reference << EOD\n%.9g %.9g\nEOD\n", cost_ms_per_second(c->settings[c->reference].run), f.bottom);
    put_titles(out, c);
    fprintf(out, "set logscale xy\nset xrange [%.3g:%.3g]\nset yrange [%.3g:%.3g]\nset format x '%%g'\nset format y '10^{%%T}'\n", f.x.low,
            f.x.high, f.y.low, f.y.high);
    fputs("set grid lt 1 lc rgb '#e4e4e4'\nset key top right box lc rgb '#d8d8d8'\nset border lc rgb '#606060'\nset tics tc rgb '#303030'\n"
          "set style line 1 lc rgb '#4a6fa5' lw 2 pt 7 ps 0.9\nset style line 2 lc rgb '#b3261e' pt 7 ps 2.4\n"
          "set style line 3 lc rgb '#303030' lw 2 pt 6 ps 3.4\n", out);
    fprintf(out, "set arrow 1 from graph 0, first %.9g to graph 1, first %.9g nohead dt 2 lc rgb '#2e7d32'\n"
                 "set label 1 'within %s' at graph 0.01, first %.9g offset 0,0.6 tc rgb '#2e7d32'\n", c->o->within, c->o->within,
            cost_length(c->o->within, bound), c->o->within);
    if (f.x.low < 1000 && f.x.high > 1000)
        fputs("set arrow 2 from first 1000, graph 0 to first 1000, graph 1 nohead dt 2 lc rgb '#909090'\n"
              "set label 2 'real time' at first 1000, graph 0.02 rotate by 90 offset 0.8,0 tc rgb '#606060'\n", out);
    if (f.nothing)
        fprintf(out, "set ytics add ('same as reference' %.9g)\n", f.bottom);
    put_picture(out, folder, "if (strstrt(GPVAL_TERMINALS, 'pngcairo') > 0) { set terminal pngcairo size 1100,760 font 'DejaVu Sans,12' } "
                "else { set terminal png size 1100,760 }", "png");
    put_picture(out, folder, "set terminal svg size 1100,760 font 'DejaVu Sans,12' background rgb 'white'", "svg");
}

/* Runs gnuplot on the file: its exit code, 127 when there is none. */
int cost_run_gnuplot(const char *script)
{
    fflush(NULL);
    pid_t pid = fork();
    int status = 0;
    if (pid < 0)
        return 127;
    if (pid == 0) {
        int nowhere = open("/dev/null", O_WRONLY);
        if (nowhere >= 0) {
            dup2(nowhere, 1);
            dup2(nowhere, 2);
        }
        execlp("gnuplot", "gnuplot", script, (char *)NULL);
        _exit(127);
    }
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR)
        ;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 126;
}

int cost_plot(const Cost *c, const char *folder)
{
    char path[1100];
    bool any = false;
    for (int i = 0; i < c->count; i++)
        any = any || is_shown(c, &c->settings[i]);
    if (!any) {
        printf("\nThe table is in %s/cost.csv; there is no error to plot.\n", folder);
        return EXIT_FINE;
    }
    snprintf(path, sizeof path, "%s/cost.gp", folder);
    TextFile t;
    if (!text_begin(&t, path))
        return EXIT_OUTPUT;
    write_script(t.text, c, folder);
    if (text_place(&t, path) != EXIT_FINE)
        return EXIT_OUTPUT;
    int code = cost_run_gnuplot(path);
    if (code == 0)
        printf("\nThe table is in %s/cost.csv, the plot in %s/cost.svg and %s/cost.png.\n", folder, folder, folder);
    else
        printf("\nThe table is in %s/cost.csv. No plot: %s. Later, from this folder: gnuplot %s\n", folder,
               code == 127 ? "gnuplot is not installed here" : "gnuplot failed", path);
    return EXIT_FINE;
}
