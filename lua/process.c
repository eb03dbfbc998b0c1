/* lua/process.c - a run is a process of its own, watched by one that never loads Lua. */

#define _DEFAULT_SOURCE         /* sigtimedwait, MAP_ANONYMOUS, strsignal */

#include "process.h"

#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/prctl.h>
#endif

#include "command.h"
#include "state.h"

enum { SLICE_MS = 50 };         /* how often the supervisor looks at the clock                    */
enum { PATIENCE = 12 };         /* s from a signal that was passed on to the end of who ignores it */
enum { FILE_GIB = 64, PROCESSES = 4096, STACK_MIB = 64 };

typedef struct Watch {          /* shared by a run and its supervisor */
    _Atomic int64_t deadline;   /* ns of the monotonic clock; 0 = none          */
    char what[PATH_MAX];        /* the script                                   */
    char made[PATH_MAX];        /* folder that was made for output              */
    int  made_levels;           /* and how many folders above it, itself counted */
} Watch;

/* Of the run in this process; NULL where none is supervised. */
static Watch *watch;
static pid_t  watched;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* ---- in the run --------------------------------------------------------------- */

static void lower(int resource, rlim_t most)
{
    struct rlimit limit;
    if (getrlimit(resource, &limit) != 0 || (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur <= most))
        return;
    limit.rlim_cur = most;
    setrlimit(resource, &limit);
}

void process_begin(int parent)
{
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)        /* it died before the call above */
        _exit(EXIT_INTERNAL);
#else
    (void)parent;
#endif
    struct rlimit stack;
    struct rlimit none = {0, 0};
    setrlimit(RLIMIT_CORE, &none);
    lower(RLIMIT_FSIZE, (rlim_t)FILE_GIB << 30);
    lower(RLIMIT_NPROC, PROCESSES);
    /* Lua counts its C calls, up to 200 a coroutine; the stack holds as many as coroutines may be closed inside each other. */
    if (getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur != RLIM_INFINITY && stack.rlim_cur < (rlim_t)STACK_MIB << 20) {
        rlim_t wanted = (rlim_t)STACK_MIB << 20;
        stack.rlim_cur = stack.rlim_max != RLIM_INFINITY && stack.rlim_max < wanted ? stack.rlim_max : wanted;
        setrlimit(RLIMIT_STACK, &stack);
    }
}

static bool is_watched(void)
{
    return watch && watched == getpid();
}

void process_limit(double seconds)
{
    if (!is_watched())
        return;
    atomic_store(&watch->deadline, seconds > 0 ? now_ns() + (int64_t)(1e9 * seconds) : 0);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (seconds > 0 && seconds < 1e7)       /* should the supervisor be stopped meanwhile */
        lower(RLIMIT_CPU, (rlim_t)(seconds * (double)(cores > 0 ? cores : 1)) + 2);
}

void process_name(const char *script)
{
    if (is_watched())
        snprintf(watch->what, sizeof watch->what, "%s", script);
}

void process_limit_space(size_t bytes)
{
    if (is_watched() && !UNDER_SANITIZER)
        lower(RLIMIT_AS, bytes);
}

void process_made_folder(const char *path, int levels)
{
    if (!is_watched() || strlen(path) >= sizeof watch->made)
        return;
    snprintf(watch->made, sizeof watch->made, "%s", path);
    watch->made_levels = levels;
}

/* ---- how it ended ---------------------------------------------------------------- */

int process_judge(int status, bool late, char *text, size_t capacity)
{
    snprintf(text, capacity, "%s", "");
    if (WIFEXITED(status))
        return WEXITSTATUS(status);
    int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (late) {
        snprintf(text, capacity, "does not respond; killed");
        return EXIT_TIME;
    }
    switch (number) {
    case SIGXCPU:
        snprintf(text, capacity, "used up its CPU time; raise --time-limit or simulate less");
        return EXIT_TIME;
    case SIGSYS:
        snprintf(text, capacity, "asked for a forbidden system call and was ended");
        return EXIT_INTERNAL;
    default:
        snprintf(text, capacity, "the run died (signal %d: %s)", number, strsignal(number));
        return EXIT_INTERNAL;
    }
}

/* ---- the supervisor -------------------------------------------------------------- */

typedef struct Supervisor {
    pid_t   pid;
    bool    own_group;          /* the run has a process group of its own                   */
    int     passed;             /* last signal that was passed on, 0 = none                 */
    int64_t give_up;            /* ns; when a run that was signalled is killed; 0 = never   */
    bool    late;
} Supervisor;

static void kill_run(const Supervisor *s)
{
    if (s->own_group)
        kill(-s->pid, SIGKILL);
    kill(s->pid, SIGKILL);
}

static void stop_with_run(const Supervisor *s)
{
    if (s->own_group)
        kill(-s->pid, SIGSTOP);
    raise(SIGSTOP);
    kill(s->own_group ? -s->pid : s->pid, SIGCONT);
}

/* The terminal signals its whole foreground group: a run in the same group has it already. */
static void pass_on(Supervisor *s, const siginfo_t *info)
{
    if (info->si_signo == SIGTSTP) {
        stop_with_run(s);
        return;
    }
    if (s->own_group || info->si_code <= 0)
        kill(s->pid, info->si_signo);
    s->passed = info->si_signo;
    if (!s->give_up)
        s->give_up = now_ns() + (int64_t)PATIENCE * 1000000000;
}

static int wait_for_run(Supervisor *s, const sigset_t *signals)
{
    const struct timespec slice = {0, SLICE_MS * 1000000};
    int status = 0;
    for (;;) {
        siginfo_t info;
        int number = sigtimedwait(signals, &info, &slice);
        if (number > 0 && number != SIGCHLD)
            pass_on(s, &info);
        pid_t ended = waitpid(s->pid, &status, WNOHANG);
        if (ended == s->pid || (ended < 0 && errno == ECHILD))
            return status;
        int64_t deadline = atomic_load(&watch->deadline), now = now_ns();
        if ((deadline && now > deadline) || (s->give_up && now > s->give_up)) {
            s->late = deadline && now > deadline;
            kill_run(s);
        }
    }
}

static int report(const Supervisor *s, int status)
{
    char clause[256], line[PATH_MAX + 320], what[PATH_MAX];
    int code = process_judge(status, s->late, clause, sizeof clause);
    if (!*clause)
        return code;
    if (!s->late && s->passed && (WTERMSIG(status) == s->passed || s->give_up))
        return 128 + s->passed;
    memcpy(what, watch->what, sizeof what);         /* the run may have written anything */
    what[sizeof what - 1] = '\0';
    snprintf(line, sizeof line, "%s%s%s%s", what, *what ? ": " : "", clause,
             code == EXIT_INTERNAL ? "; that is a fault of digbox, not of the world" : "");
    say_error(line);
    return code;
}

static void remove_empty_folders(void)
{
    char path[PATH_MAX];
    memcpy(path, watch->made, sizeof path);
    path[sizeof path - 1] = '\0';
    for (int i = 0; i < watch->made_levels && i < 64 && *path && rmdir(path) == 0; i++) {
        char *slash = strrchr(path, '/');
        if (!slash || slash == path)
            return;
        *slash = '\0';
    }
}

static _Noreturn void begin_run(int (*run)(int, char **), int argc, char **argv, pid_t parent, const sigset_t *mask, bool own_group)
{
    watched = getpid();
    if (own_group)
        setpgid(0, 0);
    process_begin(parent);
    sigprocmask(SIG_SETMASK, mask, NULL);
    exit(run(argc, argv));
}

int process_supervise(int (*run)(int argc, char **argv), int argc, char **argv)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGCHLD};
    sigset_t signals, before;
    /* Where someone sits at the terminal, the run stays in the group that may read from it. */
    Supervisor s = {.own_group = !isatty(0)};
    const pid_t parent = getpid();
    watch = mmap(NULL, sizeof *watch, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (watch == MAP_FAILED) {
        fprintf(stderr, "digbox: no memory to start a run: %s\n", strerror(errno));
        return EXIT_MEMORY;
    }
    sigemptyset(&signals);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaddset(&signals, numbers[i]);
    sigprocmask(SIG_BLOCK, &signals, &before);
    fflush(NULL);
    int code = EXIT_INTERNAL;
    s.pid = fork();
    if (s.pid < 0)
        fprintf(stderr, "digbox: cannot start a process: %s\n", strerror(errno));
    if (s.pid == 0)
        begin_run(run, argc, argv, parent, &before, s.own_group);
    if (s.pid > 0) {
        if (s.own_group)
            setpgid(s.pid, s.pid);
        code = report(&s, wait_for_run(&s, &signals));
        remove_empty_folders();
    }
    munmap(watch, sizeof *watch);
    watch = NULL;
    sigprocmask(SIG_SETMASK, &before, NULL);        /* who goes on, as a sweep after its try, can be stopped again */
    return code;
}
