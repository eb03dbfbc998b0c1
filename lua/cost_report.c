/* lua/cost_report.c - the tables, the sentences and the CSV file of `digbox cost`. */

#include "cost.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "state.h"

static const char *const phases[COST_PHASES] = {"sense", "touch", "graph", "advance", "commit", "report", "other"};

static bool is_complete(const CostSetting *s)
{
    return s->run && s->run->end == COST_COMPLETE;
}

const char *cost_length(real metres, char text[32])
{
    static const struct { real factor; const char *unit; } units[] = {
        {1, "m"}, {1e-3, "mm"}, {1e-6, "um"}, {1e-9, "nm"}, {1e-12, "pm"},
    };
    size_t i = 0;
    while (i + 1 < sizeof units / sizeof *units && metres < units[i].factor && metres > 0)
        i++;
    if (metres > 0 && metres < 1e-13)
        snprintf(text, 32, "%.1e m", metres);
    else
        snprintf(text, 32, "%.3g %s", metres / units[i].factor, units[i].unit);
    return text;
}

static const char *status_text(const CostSetting *s)
{
    static const char *const texts[] = {"left out", "running", "complete", "over budget", "failed"};
    return texts[s->run ? s->run->end : COST_NOT_RUN];
}

static real ratio_to_play(const Cost *c, const CostSetting *s)
{
    real play = cost_ms_per_second(c->settings[c->play].run);
    return play > 0 ? cost_ms_per_second(s->run) / play : 0;
}

/* ---- tables ---------------------------------------------------------------------- */

static void print_error_cells(const Cost *c, const CostSetting *s)
{
    char bound[32];
    if (!is_complete(s) || c->compared <= 0 || s->error.compared == 0) {
        printf("%-10s %10s %10s %12s", s->name, is_complete(s) ? "-" : status_text(s), "-", "-");
        return;
    }
    if (isfinite(s->error.until))
        snprintf(bound, sizeof bound, "%.4g s", s->error.until);
    else
        snprintf(bound, sizeof bound, "> %.4g s", c->compared);
    if (s == &c->settings[c->reference])
        printf("%-10s %10s %10s %12s", s->name, "reference", "-", "-");
    else if (s->error.max <= 0)
        printf("%-10s %10s %10s %12s", s->name, "the same", "0", bound);
    else
        printf("%-10s %10.2e %10.2e %12s", s->name, s->error.max, s->error.rms, bound);
}

static void print_errors(const Cost *c)
{
    char within[32], heading[64];
    snprintf(heading, sizeof heading, "<%s until", cost_length(c->o->within, within));
    printf("\n%-10s %10s %10s %12s %13s %9s %8s %8s %11s\n", "setting", "error, m", "rms, m", heading, "CPU ms per s", "x play", "events",
           "impacts", "drift, J");
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        print_error_cells(c, s);
        if (s->run && s->run->steps > 0)
            printf(" %13.4g %9.3g %8" PRIu64 " %8" PRIu64 " %11.2e", cost_ms_per_second(s->run), ratio_to_play(c, s), s->run->events,
                   s->run->impacts, s->run->drift);
        putchar('\n');
    }
}

static void print_work(const Cost *c)
{
    printf("\n%-10s %9s %9s %8s %8s %8s  where the time went, %%:", "setting", "substeps", "evals", "refused", "located", "gave up");
    printf("%*s%7s\n%*s", 3, "", "", 57, "");
    for (int k = 0; k < COST_PHASES - 1; k++)
        printf(" %7s", phases[k]);
    putchar('\n');
    for (int i = 0; i < c->count; i++) {
        const CostRun *r = c->settings[i].run;
        if (!r || r->steps == 0)
            continue;
        printf("%-10s %9" PRIu64 " %9" PRIu64 " %8" PRIu64 " %8" PRIu64 " %8" PRIu64 "  ", c->settings[i].name, r->substeps, r->evaluations,
               r->refused, r->trace_events, r->gave_up);
        real sum = 0;           /* phases are timed in every sixteenth step: their shares are those of the timed ones */
        for (int k = 0; k < COST_PHASES - 1; k++)
            sum += r->us[k];
        for (int k = 0; k < COST_PHASES - 1; k++)
            printf(" %7.1f", sum > 0 ? 100 * r->us[k] / sum : 0);
        putchar('\n');
    }
}

static void print_gave_up(const Cost *c)
{
    for (int i = 0; i < c->count; i++) {
        const CostRun *r = c->settings[i].run;
        if (r && r->gave_up > 0)
            printf("%s gave up %" PRIu64 " times and went on in a coarser way; last: %s\n", c->settings[i].name, r->gave_up, r->gave_up_why);
    }
}

/* ---- sentences --------------------------------------------------------------------- */

static void print_heading(const Cost *c)
{
    const CostRun *r = c->settings[c->reference].run;
    printf("%s: %.4g s simulated, %u frame steps of %.4g s, %d moving bod%s; the reference is %s\n", c->o->run.world, r->steps * r->frame,
           r->steps, r->frame, r->moving, r->moving == 1 ? "y" : "ies", c->settings[c->reference].name);
    if (r->several)
        printf("The script steps several worlds: the first one to take a step is measured.\n");
    if (r->cut)
        printf("The world has many bodies: the first %d are compared.\n", COST_ROWS / 4);
}

static void print_twins(const Cost *c)
{
    const CostTwins *t = &c->twins;
    if (!t->known)
        return;
    if (!t->apart) {
        printf("\nNot chaotic in this time: twins that begin 9e-9 of a body's size apart end %.2g of a size apart.\n", t->last);
        return;
    }
    if (t->jump)
        printf("\nNot repeatable beyond t = %.4g s: there twins that began 9e-9 of a body's size apart jump apart\n"
               "(a contact that happens for one alone, or a fall to the other side).", t->horizon);
    else if (t->factor < 1e6)
        printf("\nChaotic from t = %.4g s on: differences grow by a factor of %.3g per second, and twins that began\n"
               "9e-9 of a body's size apart are a thousandth of a size apart.", t->horizon, t->factor);
    else
        printf("\nChaotic from t = %.4g s on: differences grow tenfold every %.3g ms, and twins that began\n"
               "9e-9 of a body's size apart are a thousandth of a size apart.", t->horizon, 1e3 / log10(t->factor));
    if (c->compared > 0)
        printf(" Errors are those up to t = %.4g s;\nlater ones would say nothing of a setting.\n", c->compared);
    else
        printf(" No error has a meaning.\n");
}

static int count_complete(const Cost *c)
{
    int n = 0;
    for (int i = 0; i < c->count; i++)
        n += is_complete(&c->settings[i]);
    return n;
}

static void print_failures(const Cost *c)
{
    bool over = false;
    for (int i = 0; i < c->count; i++) {
        const CostSetting *s = &c->settings[i];
        over = over || (s->run && s->run->end == COST_OVER_BUDGET);
        if (s->run && s->run->end == COST_FAILED)
            printf("%s failed: %s\n", s->name, s->run->message);
        else if (s->run && s->run->end == COST_OVER_BUDGET)
            printf("%s was stopped at t = %.4g s: it needs more than the budget of %g s%s.\n", s->name,
                   s->run->steps * s->run->frame, c->o->budget, s->plan && strcmp(s->name, "reference") == 0 ? "" :
                   s->plan ? "; finer plans are left out" : "; finer tolerances are left out");
        else if (is_complete(s) && s->run->steps != c->settings[c->reference].run->steps)
            printf("%s took %u frame steps where the reference took %u: the script ends when something happens.\n", s->name, s->run->steps,
                   c->settings[c->reference].run->steps);
        if (is_complete(s) && s->error.missing > 0)
            printf("%s has other bodies than the reference: the error covers only those that both have.\n", s->name);
    }
    if (over)
        printf("--budget S gives each run more time, --seconds N makes them shorter.\n");
}

static void print_verdict(const Cost *c)
{
    char within[32], near[32], until[64] = "";
    int best = cost_cheapest(c);
    cost_length(c->o->within, within);
    if (c->settings[c->reference].run->moving == 0) {
        printf("\nNo body in this world moves of itself: there is no error to measure, only time.\n");
        return;
    }
    if (c->compared <= 0)
        return;
    if (count_complete(c) < 2) {
        printf("\nOnly %s finished within its budget: there is nothing to compare it with.\n", c->settings[c->reference].name);
        return;
    }
    if (c->twins.apart)
        snprintf(until, sizeof until, "Up to t = %.4g s, the", c->compared);
    else
        snprintf(until, sizeof until, "The");
    putchar('\n');
    if (c->agreement > 0 && best >= 0)
        printf("The nearest different setting comes within %s of the reference: smaller errors say little.\n", cost_length(c->agreement, near));
    else if (c->agreement <= 0)
        printf("All settings give the same states to the last bit.\n");
    if (cost_of_tenth(c) > 0)
        printf("Over all settings, a tenth of the error costs about %.3g times the CPU time.\n", cost_of_tenth(c));
    if (best >= 0)
        printf("%s cheapest setting that stays within %s is %s: %.3g ms of CPU time per simulated second, %.3g times play.\n", until, within,
               c->settings[best].name, cost_ms_per_second(c->settings[best].run), ratio_to_play(c, &c->settings[best]));
    else
        printf("No setting is shown to stay within %s: none but itself comes nearer to the reference than %s.\n", within, cost_length(c->agreement, near));
}

void cost_print(const Cost *c)
{
    print_heading(c);
    print_twins(c);
    print_errors(c);
    print_work(c);
    print_gave_up(c);
    print_verdict(c);
    print_failures(c);
}

/* ---- CSV ------------------------------------------------------------------------------ */

static void csv_error(FILE *f, const Cost *c, const CostSetting *s)
{
    if (!is_complete(s) || c->compared <= 0 || s->error.compared == 0) {
        fputs(",,,,", f);
        return;
    }
    fprintf(f, "%.9g,%.9g,%.9g,%.9g,", s->error.max, s->error.rms, s->error.position, s->error.rotation);
    if (isfinite(s->error.until))
        fprintf(f, "%.9g", s->error.until);
}

static void csv_row(FILE *f, const Cost *c, const CostSetting *s)
{
    const CostRun *r = s->run;
    fprintf(f, "%s,%s,%s,%s,", s->name, s->plan ? "plan" : "tolerance", status_text(s), s == &c->settings[c->reference] ? "yes" : "no");
    if (!r || r->steps == 0) {
        fprintf(f, ",,,,,%.9g,,,,,,,,,,,,,,,,,,,,,,,,\n", c->compared);
        return;
    }
    fprintf(f, "%.9g,%u,%.9g,%.9g,%.9g,%.9g,", r->steps * r->frame, r->steps, 1e3 * r->cpu, cost_ms_per_second(r), ratio_to_play(c, s),
            c->compared);
    csv_error(f, c, s);
    fprintf(f, ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",\"", r->events,
            r->contacts, r->impacts, r->substeps, r->iterations, r->evaluations, r->refused, r->trace_events, r->gave_up);
    for (const char *p = r->gave_up_why; *p; p++)
        fputs(*p == '"' ? "\"\"" : (char[]){*p, '\0'}, f);
    fprintf(f, "\",%.9g", r->drift);
    for (int k = 0; k < COST_PHASES; k++)
        fprintf(f, ",%.9g", 1e-3 * fmax(0, r->us[k]));
    fputs("\n", f);
}

int cost_write_csv(const Cost *c, const char *path)
{
    TextFile t;
    if (!text_begin(&t, path))
        return EXIT_OUTPUT;
    FILE *f = t.text;
    fputs("setting,kind,status,reference,simulated_s,steps,cpu_ms,cpu_ms_per_s,ratio_to_play,compared_until_s,error_m,rms_m,"
          "position_error_m,rotation_error_rad,beyond_bound_at_s,events,contact_begin,impact,substeps,iterations,evaluations,refused,"
          "trace_events,gave_up,gave_up_why,energy_drift_J", f);
    for (int k = 0; k < COST_PHASES; k++)
        fprintf(f, ",%s_ms", phases[k]);
    fputs("\n", f);
    for (int i = 0; i < c->count; i++)
        csv_row(f, c, &c->settings[i]);
    return text_place(&t, path);
}
