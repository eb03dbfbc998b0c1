/* lua/process.h - a run is a process of its own, watched by one that never loads Lua (defence D1 of docs/security.md).
 *
 * The supervisor keeps the wall clock, passes signals on, and says in one sentence how a run died. What a run wants it to know
 * (its deadline, its script, the folder it made) stands in a page that both share; the supervisor believes none of it further
 * than printing it cleanly and stopping earlier or later.
 */
#ifndef DIGBOX_PROCESS_H
#define DIGBOX_PROCESS_H

#include <stdbool.h>
#include <stddef.h>

/* A sanitizer reserves terabytes of address space and traces its own process to find leaks. */
#if defined(__SANITIZE_ADDRESS__)
#define UNDER_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define UNDER_SANITIZER 1
#endif
#endif
#ifndef UNDER_SANITIZER
#define UNDER_SANITIZER 0
#endif

/* Runs the command in a child and waits for it. Returns the exit code: that of the child, or what its death means. */
int process_supervise(int (*run)(int argc, char **argv), int argc, char **argv);

/* In a child, right after fork: it dies with its parent, dumps no core, and cannot write files or start processes without end.
 * `parent` is the pid of the process that called fork. */
void process_begin(int parent);

/* In a run: kill me so many seconds from now (0 = never). Does nothing in a process without a supervisor. */
void process_limit(double seconds);

/* In a run: what to call it in messages. */
void process_name(const char *script);

/* In a run: how much address space the process may take, bytes. */
void process_limit_space(size_t bytes);

/* In a run: that folder (and `levels` - 1 above it) was made; the supervisor removes what is still empty at the end. */
void process_made_folder(const char *path, int levels);

/* What the end of a process with that status of waitpid means: an exit code, and a clause such as "died (signal 11: ...)". */
int process_judge(int status, bool late, char *text, size_t capacity);

#endif
