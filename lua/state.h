/* lua/state.h - a sandboxed Lua state that runs one script.
 *
 * The script gets base functions, string, table, math, utf8, coroutine, and `require` of digbox and of text modules beside it.
 * Limits and Ctrl-C are seen every 100,000 instructions and before every step.
 */
#ifndef DIGBOX_STATE_H
#define DIGBOX_STATE_H

#include <lua.h>

#include "digbox.h"

enum ExitCode {
    EXIT_FINE = 0, EXIT_SCRIPT = 1, EXIT_USAGE = 2, EXIT_MEMORY = 3, EXIT_FUEL = 4, EXIT_TIME = 5, EXIT_SCENARIO = 6,
    EXIT_DIVERGED = 7, EXIT_FORMAT = 8, EXIT_OUTPUT = 9, EXIT_FINITE = 10, EXIT_INTERNAL = 11, EXIT_UNRELIABLE = 12,
    EXIT_SIGINT = 130, EXIT_SIGTERM = 143
};

typedef struct App {            /* of one state; the state's extra space points here */
    size_t memory_used, memory_limit;       /* bytes of Lua; limit 0 = none                    */
    long long fuel;             /* instructions left; < 0 = no limit                           */
    double deadline;            /* s of the monotonic clock; 0 = none                          */
    int    stop_code;           /* why the script was stopped, 0 = it was not                  */
    bool   trust;               /* io and os are there                                         */
    const char *script;         /* path as given                                               */
} App;

/* Installs handlers: the first SIGINT or SIGTERM stops the script after the present frame, the second ends the program. */
void app_catch_signals(void);

/* The signal that came, or 0. */
int app_signal(void);

/* The script is stopped after so many seconds of wall time; where it does not respond, the program is, after half as many more. */
void app_limit_time(App *app, double seconds);

double app_clock(void);         /* s, monotonic */

/* NULL when there is no memory. The core table stands in the registry as "digbox.core". */
lua_State *app_open(App *app);

/* core.options.name = value on top of the stack (popped). */
void app_set_option(lua_State *L, const char *name);

/* Reads a script and runs it. On failure pushes one line of text. Returns an exit code. */
int app_run_file(lua_State *L, App *app);

/* Calls the function below n arguments. Returns an exit code; a failure leaves one line of text on the stack. */
int app_call(lua_State *L, App *app, int arguments, int results);

/* Calls core.name(...) the same way; the arguments are on the stack. */
int app_call_core(lua_State *L, App *app, const char *name, int arguments, int results);

/* FNV-1a of a text, as 16 hexadecimal digits. */
void app_hash(const char *text, size_t size, char out[17]);

#endif
