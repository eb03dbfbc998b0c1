/* lua/command.h - what the commands of the program share. */
#ifndef DIGBOX_COMMAND_H
#define DIGBOX_COMMAND_H

#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>

/* Prints `digbox: ...` and where help is; returns the exit code. */
int usage_error(const char *format, ...);

/* Prints what that command, or with NULL the program, can do; returns the exit code. */
int print_help(const char *command);

/* A number in SI or with a unit, within bounds; false after a message. */
bool read_number_option(const char *name, const char *text, const char *unit, double low, double high, double *value);
bool read_whole_option(const char *name, const char *text, long long low, long long high, long long *value);

void print_error(const char *text);

/* The code, or that of failed output when stdout cannot take the rest. */
int flush_output(int code);

int command_test(int argc, char **argv);

#endif
