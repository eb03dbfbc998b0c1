/* lua/cost.h - what the parts of `digbox cost` share: the record of one run, the settings, their comparison.
 *
 * Each setting runs in a process of its own, which fills a CostRun in shared memory; the program that compares never runs a script.
 */
#ifndef DIGBOX_COST_H
#define DIGBOX_COST_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "command.h"
#include "digbox.h"

enum { COST_ROWS = 1 << 17, COST_PHASES = 7, COST_SETTINGS = 12, COST_EFFECTS = 32 };

typedef struct CostRow {        /* one body after one frame step */
    uint32_t step, slot, gen, unused;   /* gen: less that of the world's first body, since worlds start at different ones */
    real     size;              /* m, half the longest side of its bounds */
    vec3     position;
    quat     rotation;
} CostRow;

typedef struct CostEffect {     /* what a run says about an effect */
    char     name[32], why[96];
    int      bodies;            /* most that took part in a step      */
    size_t   bytes;             /* at the end                         */
    uint64_t calls;
    real     us;                /* a step, in its own functions       */
} CostEffect;

typedef enum CostEnd { COST_NOT_RUN, COST_RUNNING, COST_COMPLETE, COST_OVER_BUDGET, COST_FAILED } CostEnd;

typedef struct CostRun {
    /* What is asked. */
    real     perturb;           /* 1, of the size of each body: how far it is moved at the start */
    real     budget;            /* s of CPU time                                                 */
    real     expected;          /* s of simulated time, 0 = not known yet                        */
    char     off[32];           /* name of an effect that is switched off; empty = none          */
    /* What came out. */
    CostEnd  end;
    int      code;              /* exit code of a run that failed */
    char     message[1024];
    real     cpu;               /* s of CPU time in the frame steps of the measured world */
    real     frame;             /* s, one frame step */
    uint32_t steps;
    int      moving;            /* most bodies that move of themselves */
    bool     several;           /* other worlds were stepped, too */
    bool     cut;               /* more bodies than are compared  */
    uint64_t substeps, iterations, evaluations, refused, trace_events, gave_up;
    uint64_t events, contacts, impacts;         /* all events; of the kinds contact_begin and impact */
    real     us[COST_PHASES];   /* us of CPU time: sense touch graph advance commit report other     */
    real     drift;             /* J, the ledger's numerical part at the end */
    char     gave_up_why[64];
    CostEffect effects[COST_EFFECTS];
    int      effect_count;
    /* Every stride-th frame and the last one, by step and slot. */
    uint32_t stride, first_gen;
    int      count;
    CostRow  rows[];
} CostRun;

typedef struct CostError {
    real max, rms;              /* m: position, and rotation times size, whichever is more */
    real position, rotation;    /* m, rad: the largest of each           */
    real until;                 /* s: how long it stays within the bound; beyond the last frame = all the time */
    int  compared;              /* bodies times frames                   */
    int  missing;               /* that only one of the two runs has     */
} CostError;

typedef struct CostSetting {
    const char *name;           /* as for --accuracy             */
    bool        plan;           /* a plan by name, not a number  */
    CostRun    *run;
    CostError   error;          /* against the reference         */
} CostSetting;

typedef struct CostTwins {      /* two runs whose starts differ by 9e-9 of the bodies' size */
    bool known, apart, jump;
    real horizon;               /* s: from then on they differ by more than a thousandth of a size */
    real factor;                /* growth of the difference per second, up to there                */
    real last;                  /* of a size: the difference at the end                            */
    real seen;                  /* s: the end                                                      */
} CostTwins;

typedef struct CostOptions {
    RunOptions run;
    double     budget, within;  /* s, m */
    bool       effects;         /* what each effect costs, not what accuracy does */
} CostOptions;

typedef struct Cost {
    const CostOptions *o;
    CostSetting settings[COST_SETTINGS];        /* plans from coarse to fine, then numbers from coarse to fine */
    int       count;
    int       play, reference;  /* indices; reference < 0: nothing is complete */
    CostTwins twins;
    real      compared;         /* s: errors are those up to then */
    real      agreement;        /* m: what the nearest different setting differs by from the reference; < 0 = there is none */
} Cost;

/* cost.c: a record in shared memory (NULL: none to be had), and a run in a process of its own (false: none to be had). */
CostRun *cost_new_run(void);
void     cost_free_run(CostRun *run);
bool     cost_run_once(const CostOptions *o, const char *accuracy, const char *name, CostRun *run);
void     cost_clear_progress(const CostOptions *o);

/* cost_effects.c: `digbox cost --effects` */
int cost_effects(const CostOptions *o);

/* cost_run.c: runs the world once in this process and fills the record; the return value is the exit code. */
int cost_run_world(const RunOptions *o, CostRun *run);

/* cost_compare.c */
void cost_compare(const CostRun *run, const CostRun *reference, real end, real within, CostError *error);
void cost_twins(const CostRun *a, const CostRun *b, CostTwins *twins);
real cost_ms_per_second(const CostRun *run);    /* ms of CPU time per simulated second */
int  cost_cheapest(const Cost *c);              /* that stays within the bound; < 0 = none is shown to */
void cost_judge(Cost *c);                       /* all errors, once runs and twins are there */

real cost_of_tenth(const Cost *c);              /* times the CPU time that a tenth of the error takes, fitted; 0 = cannot be said */

/* cost_report.c: tables to stdout, files in the folder; exit codes. */
const char *cost_length(real metres, char text[32]);    /* with a unit that suits it */
void cost_print(const Cost *c);
int  cost_write_csv(const Cost *c, const char *path);

/* cost_plot.c */
void cost_put_quoted(FILE *out, const char *text);      /* within '...' of gnuplot */
int  cost_run_gnuplot(const char *script);              /* its exit code; 127: there is none */
int  cost_plot(const Cost *c, const char *folder);

#endif
