/* lua/state.h - a sandboxed Lua state that runs one script.
 *
 * The script gets base functions, string, table, math, utf8, coroutine, and `require` of digbox and of text modules beside it
 * (lib_base.c). A limit that trips ends the process: nothing of the script runs any more, since an error could be caught and a
 * finalizer, a handler or a __close could go on for ever. Limits and Ctrl-C are seen within 25 ms, and before every step.
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
    size_t memory_used, memory_limit;       /* bytes of Lua; limit 0 = the default (1 GiB)         */
    long long fuel;             /* instructions left; < 0 = no limit                               */
    double deadline;            /* s of the monotonic clock; 0 = none                              */
    int    stop_code;           /* why the script was stopped, 0 = it was not                      */
    bool   trust;               /* io and os are there                                             */
    bool   raises;              /* limits raise errors that the script could catch (repl)          */
    size_t log_limit;           /* bytes that print may write; 0 = no limit                        */
    const char *script;         /* path as given                                                   */
    bool   jailed;              /* the process is shut in (jail.h) before it reads the script; not with trust */
    bool   jail_needed;         /* and if it cannot be, the script is not run                      */
    bool   jail_said;           /* says in one line which walls hold                               */
    const char *out;            /* folder that may be written then; NULL = none                    */
    const char *also[4];        /* files that may be written besides, NULL = none                  */
    const char *kept;           /* and one that nothing may be written beside (the repl's history) */
    /* Told of a stop instead of stderr; the process ends when it returns. */
    void (*stopped)(void *data, int code, const char *text);
    void  *stopped_data;
    /* Fault injection: this allocation fails, counted from 1, and with fail_on all after it; 0 = none. */
    size_t fail_at;
    bool   fail_on;

    /* Kept by state.c and the libraries. */
    long long fuel_given;
    size_t logged, resident_limit, allocations, page;
    lua_State *running;         /* the coroutine that runs                                         */
    int    closing;             /* coroutines that are closing each other                          */
    bool   over;                /* more than memory_limit is in use: to be looked at               */
    bool   leaving;             /* a limit has tripped: none holds any more                        */
    volatile bool nudged;       /* a hook was set that calls for a look at the limits              */
    size_t work;                /* charged since the limits were looked at                         */
    int    statm;               /* descriptor of /proc/self/statm, -1 = none                       */
} App;

/* Installs handlers: the first SIGINT or SIGTERM stops the script after the present frame, the second ends the program. */
void app_catch_signals(void);

/* The signal that came, or 0. */
int app_signal(void);

/* Bytes that this process may take, worlds and pictures included: what --memory-limit allows, and at most three quarters of the machine's. */
size_t app_room(void);

/* What Ctrl-C stopped has stopped: the next one is the first again. Other signals stay. */
void app_forget_interrupt(void);

/* The script is stopped after so many seconds of wall time; where it does not respond, the program is, before half as many more. */
void app_limit_time(App *app, double seconds);

/* No limit holds any more: what follows is the program's own and may take its time. */
void app_lift_limits(App *app);

double app_clock(void);         /* s, monotonic */

/* NULL when there is no memory, or no jail where one is needed: it has said so. The core table stands in the registry as "digbox.core". */
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
