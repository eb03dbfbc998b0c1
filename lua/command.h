/* lua/command.h - what the commands of the program share. */
#ifndef DIGBOX_COMMAND_H
#define DIGBOX_COMMAND_H

#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>

#include <lua.h>

#include "digbox.h"

typedef struct RunOptions {
    const char *world, *out, *accuracy, *trace, *replay, *result;
    double      seconds, time_limit;        /* < 0 = not given */
    long long   seed, threads, memory, fuel;
    bool        trust, quiet, strict, dry, jail_needed, verbose;
    bool        resume, force;  /* frames of an earlier run are kept, or forgotten */
    long long   log_limit;      /* MiB that print may write; 0 = no limit */
    bool        injects;        /* a fault, for tests: */
    long long   inject_body, inject_step;
    int         set_count, argument_count;
    char      **set;                        /* [set_count] NAME=VALUE */
    char      **arguments;                  /* [argument_count] after -- */
} RunOptions;

/* A command of the program: the const table at the end of its file. main.c lists them in the order of the help. */
typedef struct Command {
    const char *name;
    const char *use;                        /* line of the program's help */
    const char *options, *notes;            /* NULL = none; notes are in the command's own help only */
    int       (*run)(int argc, char **argv);    /* argv[0] is the program; returns the exit code */
    bool        starts_runs;            /* starts a process for each script itself; others run in a child of main.c (process.h) */
} Command;

extern const Command run_command, test_command, check_command, cost_command, sweep_command, task_command, merge_command, render_command,
                     export_command, view_command, diff_command, verify_command, api_command, repl_command, new_command, doctor_command;

/* In the order of the help; NULL past the end. */
const Command *command_at(int index);
const char *exit_code_help(void);

/* Prints `digbox: ...` and where help is; returns the exit code. */
int usage_error(const char *format, ...);

/* getopt_long, which here says what is wrong in one sentence; '?' after that. */
struct option;
int next_option(const char *command, int argc, char **argv, const char *letters, const struct option *options);

/* Prints what that command, or with NULL the program, can do; returns the exit code. */
int print_help(const char *command);

/* A number in SI or with a unit, within bounds; false after a message. */
bool read_number_option(const char *name, const char *text, const char *unit, double low, double high, double *value);
/* A..B, A.. or ..B of so many frames. */
bool read_frames_option(const char *text, int frames, int *first, int *last);
/* The name of a plan, or a tolerance: a length. */
bool read_accuracy_option(const char *text);
bool read_whole_option(const char *name, const char *text, long long low, long long high, long long *value);

/* Films in a folder, or the one of a manifest, against what was written (verify_film.c). Returns an exit code. */
bool verify_is_film(const char *path);
int  verify_film(const char *path);

/* What it means for the program that a file could not be read so. */
int exit_code_of_reading(dig_status status);

/* One message: at most 4,000 bytes. */
void say_error(const char *text);

/* Text that others made, for a terminal: '?' stands for what is no UTF-8 and for control characters but those in `kept`. */
void say_text(FILE *f, const char *text, size_t size, const char *kept);

/* A text that becomes a file: write to `text`, then place it: the whole of it under that name, or what was there; what is no file (a
 * device, a pipe) is written as it is. Returns an exit code, after a message where it is not EXIT_FINE. */
typedef struct TextFile { FILE *text; char *data; size_t size; } TextFile;
bool text_begin(TextFile *t, const char *path);
int  text_place(TextFile *t, const char *path);

/* The code, or that of failed output when stdout cannot take the rest. */
int flush_output(int code);

/* `digbox run` with these words, up to the first step of the world; nothing is written (run.c). */
int run_dry(int argc, char **argv);

/* What stands after a bare -- is for the world: the number of arguments before it. */
int cut_arguments(int argc, char **argv, RunOptions *o);

/* A Lua function: core.options from the RunOptions in its argument. */
int run_set_options(lua_State *L);

#endif
