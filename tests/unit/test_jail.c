/* tests/unit/test_jail.c - what a process that is shut in can still do, had a script taken it over. */
#define _GNU_SOURCE             /* mkdtemp, syscall */
#include "check.h"
#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <lua.h>

#include "lua/jail.h"
#include "lua/process.h"

static char base[512];          /* folder of this test: world/ and what is made beside it */

static const char *in_base(const char *name)
{
    static char path[4][600];
    static int next;
    char *p = path[next++ % 4];
    snprintf(p, sizeof path[0], "%s/%s", base, name);
    return p;
}

static void write_file(const char *path)
{
    int f = open(path, O_WRONLY | O_CREAT, 0666);
    CHECK(f >= 0);
    close(f);
}

static int prepare(void **state)
{
    (void)state;
    if (!mkdtemp(scratch_path(base, sizeof base, "jail-XXXXXX")))
        return 1;
    mkdir(in_base("world"), 0777);
    write_file(in_base("world/world.lua"));
    write_file(in_base("secret"));
    return 0;
}

static int tidy(void **state)
{
    (void)state;
    static const char *const files[] = {"world/world.lua", "secret", "out/deep/a.png", "new", "b.replay", "world/new"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        unlink(in_base(files[i]));
    rmdir(in_base("out/deep"));
    rmdir(in_base("out"));
    rmdir(in_base("world"));
    return rmdir(base);
}

static bool can_open(const char *path, int how)
{
    int f = open(path, how, 0666);
    if (f >= 0)
        close(f);
    return f >= 0;
}

enum { ASK_FILES, ASK_REPLAY, ASK_CALLS, ASK_PROGRAM, ASK_TRACE };

static bool files_are_shut(void)
{
    bool works = can_open(in_base("world/world.lua"), O_RDONLY) && mkdir(in_base("out/deep"), 0777) == 0 &&
                 can_open(in_base("out/deep/x"), O_WRONLY | O_CREAT) && rename(in_base("out/deep/x"), in_base("out/deep/a.png")) == 0 &&
                 can_open("/dev/null", O_WRONLY) && can_open("/proc/self/statm", O_RDONLY);
    bool shut = !can_open(in_base("secret"), O_RDONLY) && !can_open("/etc/passwd", O_RDONLY) && !can_open(in_base("new"), O_WRONLY | O_CREAT) &&
                !can_open(in_base("world/new"), O_WRONLY | O_CREAT) && !can_open(in_base("world/world.lua"), O_WRONLY) &&
                unlink(in_base("world/world.lua")) != 0 && rename(in_base("out/deep/a.png"), in_base("new")) != 0;
    return works && shut;
}

static bool calls_are_shut(pid_t parent)
{
    bool sockets = socket(AF_INET, SOCK_STREAM, 0) < 0 && socket(AF_UNIX, SOCK_STREAM, 0) < 0;
    return sockets && kill(parent, SIGTERM) != 0 && kill(parent, SIGKILL) != 0;
}

/* In a child that is shut in. Returns the status of waitpid, or -1 where this kernel has no walls. */
static int ask(int question)
{
    fflush(NULL);
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0) {
        char text[160];
        const char *also[] = {question == ASK_REPLAY ? in_base("b.replay") : NULL};
        const Jail jail = {.script = in_base("world/world.lua"), .out = in_base("out"), .also = also, .also_count = 1};
        if (!jail_enter(&jail, text, sizeof text))
            _exit(77);
        switch (question) {
        case ASK_FILES: _exit(files_are_shut() ? 0 : 1);
        case ASK_REPLAY: _exit(can_open(in_base("b.replay"), O_WRONLY | O_CREAT) ? 0 : 1);
        case ASK_CALLS: _exit(calls_are_shut(parent) ? 0 : 1);
        case ASK_PROGRAM: execlp("true", "true", (char *)NULL); _exit(1);
        default: ptrace(PTRACE_ATTACH, parent, NULL, NULL); _exit(0);
        }
    }
    int status = 0;
    CHECK(pid > 0 && waitpid(pid, &status, 0) == pid);
    return WIFEXITED(status) && WEXITSTATUS(status) == 77 ? -1 : status;
}

static void answers(int question, int want)
{
    int status = ask(question);
    if (status < 0)
        skip();
    CHECK_INT(status, want);
}

TEST(files_can_be_written_in_the_output_folder_only) { answers(ASK_FILES, 0); }
TEST(a_file_that_the_user_named_can_be_written)      { answers(ASK_REPLAY, 0); }
TEST(programs_of_the_system_can_be_started)          { answers(ASK_PROGRAM, 0); }

TEST(no_socket_and_no_signal_to_others)
{
    if (!UNDER_SANITIZER)               /* there is no seccomp then */
        answers(ASK_CALLS, 0);
}

TEST(who_traces_others_is_ended)
{
    int status = UNDER_SANITIZER ? -1 : ask(ASK_TRACE);
    if (status < 0)
        skip();
    CHECK(WIFSIGNALED(status));
    CHECK_INT(WTERMSIG(status), SIGSYS);
    char text[256];
    CHECK_INT(process_judge(status, false, text, sizeof text), 11);
    CHECK_TEXT(text, "asked for a forbidden system call and was ended");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_can_be_written_in_the_output_folder_only), cmocka_unit_test(a_file_that_the_user_named_can_be_written),
        cmocka_unit_test(programs_of_the_system_can_be_started), cmocka_unit_test(no_socket_and_no_signal_to_others),
        cmocka_unit_test(who_traces_others_is_ended),
    };
    return cmocka_run_group_tests(tests, prepare, tidy);
}
