/* lua/jail.c - the walls around the process that runs a script: landlock for files, seccomp for system calls. */

#define _GNU_SOURCE             /* O_PATH, syscall */

#include "jail.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "process.h"

#ifdef __linux__
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
#define HAS_WALLS 1
#else
#define HAS_WALLS 0
#endif

#if HAS_WALLS

/* ---- landlock: kernel 5.13 and later; numbers and bits are the same on all machines -------- */

enum { SYS_CREATE_RULESET = 444, SYS_ADD_RULE = 445, SYS_RESTRICT_SELF = 446, RULE_PATH = 1, ASK_VERSION = 1 };

#define BIT(n) ((uint64_t)1 << (n))
static const uint64_t FILE_EXECUTE = BIT(0), FILE_WRITE = BIT(1), FILE_READ = BIT(2), FOLDER_READ = BIT(3), FOLDER_REMOVE = BIT(4),
    FILE_REMOVE = BIT(5), FOLDER_MAKE = BIT(7), FILE_MAKE = BIT(8), FILE_MOVE = BIT(13), FILE_CUT = BIT(14);
static const uint64_t SCOPE_ABSTRACT = BIT(0), SCOPE_SIGNAL = BIT(1);

typedef struct Ruleset { uint64_t files, net, scope; } Ruleset;
typedef struct __attribute__((packed)) PathRule { uint64_t allowed; int32_t folder; } PathRule;

static int landlock_version(void)
{
    long v = syscall(SYS_CREATE_RULESET, NULL, 0, ASK_VERSION);
    return v > 0 ? (int)v : 0;
}

/* All that this version knows of files: what is not listed in a rule is forbidden. */
static uint64_t known_rights(int version)
{
    return version >= 3 ? BIT(15) - 1 : version == 2 ? BIT(14) - 1 : BIT(13) - 1;
}

static void allow(int ruleset, const char *path, uint64_t rights, uint64_t known)
{
    struct stat info;
    int f = open(path, O_PATH | O_CLOEXEC);
    if (f < 0)
        return;                         /* what is not there needs no rule */
    if (fstat(f, &info) == 0) {
        if (!S_ISDIR(info.st_mode))
            rights &= FILE_EXECUTE | FILE_WRITE | FILE_READ | FILE_CUT;
        PathRule rule = {rights & known, f};
        syscall(SYS_ADD_RULE, ruleset, RULE_PATH, &rule, 0);
    }
    close(f);
}

/* Folders in a list such as that of PATH. */
static void allow_list(int ruleset, const char *list, uint64_t rights, uint64_t known)
{
    char path[PATH_MAX];
    for (const char *p = list; p && *p; ) {
        size_t n = strcspn(p, ":");
        if (*p == '/' && n > 1 && n < sizeof path) {
            memcpy(path, p, n);
            path[n] = '\0';
            allow(ruleset, path, rights, known);
        }
        p += n + (p[n] == ':');
    }
}

static void folder_of(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    size_t n = slash ? (size_t)(slash - path) : 0;
    snprintf(folder, PATH_MAX, "%.*s", slash && n == 0 ? 1 : (int)(n < PATH_MAX ? n : PATH_MAX - 1), slash ? path : ".");
    if (!slash)
        snprintf(folder, PATH_MAX, ".");
}

/* Makes the folder and those above it. */
static void make_folder(const char *path)
{
    char part[PATH_MAX];
    int made = 0;
    if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part)
        return;
    size_t length = strlen(part);
    while (length > 1 && part[length - 1] == '/')
        part[--length] = '\0';
    for (char *p = part; *part; ) {
        p = strchr(p + 1, '/');
        if (p)
            *p = '\0';
        made = mkdir(part, 0777) == 0 ? made + 1 : errno == EEXIST ? 0 : made;
        if (!p)
            break;
        *p = '/';
    }
    if (made > 0)
        process_made_folder(part, made);
}

static void allow_all(int ruleset, const Jail *jail, uint64_t known)
{
    static const char *const programs[] = {"/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/opt", "/nix/store", "/gnu/store"};
    static const char *const readable[] = {
        "/etc/fonts", "/etc/ld.so.cache", "/etc/drirc", "/etc/glvnd", "/etc/egl", "/etc/alternatives", "/etc/localtime",
        "/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/sys/devices/system", "/sys/dev/char", "/sys/devices/pci0000:00",
    };
    static const char *const devices[] = {"/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom", "/dev/dri"};
    const uint64_t read = FILE_READ | FOLDER_READ, use = read | FILE_EXECUTE;
    const uint64_t write = read | FILE_WRITE | FILE_CUT | FILE_MAKE | FILE_REMOVE | FILE_MOVE | FOLDER_MAKE | FOLDER_REMOVE;
    char folder[PATH_MAX];
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        allow(ruleset, programs[i], use, known);
    for (size_t i = 0; i < sizeof readable / sizeof *readable; i++)
        allow(ruleset, readable[i], read, known);
    for (size_t i = 0; i < sizeof devices / sizeof *devices; i++)
        allow(ruleset, devices[i], read | FILE_WRITE, known);
    allow_list(ruleset, getenv("PATH"), use, known);
    allow_list(ruleset, getenv("LD_LIBRARY_PATH"), use, known);
    allow_list(ruleset, getenv("LIBGL_DRIVERS_PATH"), use, known);
    if (jail->script) {
        folder_of(jail->script, folder);
        allow(ruleset, folder, read, known);
    }
    if (jail->out) {
        make_folder(jail->out);
        allow(ruleset, jail->out, write, known);
    }
    if (jail->kept)
        allow(ruleset, jail->kept, FILE_READ | FILE_WRITE | FILE_CUT, known);
    for (int i = 0; i < jail->also_count; i++)
        if (jail->also[i]) {
            folder_of(jail->also[i], folder);           /* they are written under another name first */
            allow(ruleset, folder, write & ~FOLDER_REMOVE, known);
        }
}

static bool shut_files(const Jail *jail, int version)
{
    if (version == 0)
        return false;
    Ruleset r = {.files = known_rights(version), .scope = SCOPE_ABSTRACT | SCOPE_SIGNAL};
    size_t size = version >= 6 ? sizeof r : version >= 4 ? 2 * sizeof r.files : sizeof r.files;
    int ruleset = (int)syscall(SYS_CREATE_RULESET, &r, size, 0);
    if (ruleset < 0)
        return false;
    allow_all(ruleset, jail, r.files);
    bool shut = syscall(SYS_RESTRICT_SELF, ruleset, 0) == 0;
    close(ruleset);
    return shut;
}

/* ---- seccomp -------------------------------------------------------------------------------- */

/* What Lua, the engine, the renderer and ffmpeg use, and what a C library of another version may use in its place. */
static const short allowed_calls[] = {
    SYS_read, SYS_write, SYS_readv, SYS_writev, SYS_pread64, SYS_pwrite64, SYS_preadv, SYS_pwritev, SYS_close, SYS_lseek, SYS_openat,
    SYS_fstat, SYS_newfstatat, SYS_statx, SYS_statfs, SYS_fstatfs, SYS_faccessat, SYS_faccessat2, SYS_readlinkat, SYS_getdents64,
    SYS_getcwd, SYS_chdir, SYS_fchdir, SYS_mkdirat, SYS_unlinkat, SYS_renameat, SYS_renameat2, SYS_ftruncate, SYS_truncate,
    SYS_fallocate, SYS_fsync, SYS_fdatasync, SYS_sync_file_range, SYS_flock, SYS_fcntl, SYS_dup, SYS_dup3, SYS_pipe2, SYS_utimensat, SYS_umask,
    SYS_fchmod, SYS_fchmodat, SYS_fadvise64, SYS_copy_file_range, SYS_sendfile, SYS_splice, SYS_tee, SYS_close_range, SYS_openat2,
    SYS_mmap, SYS_munmap, SYS_mprotect, SYS_mremap, SYS_madvise, SYS_brk, SYS_msync, SYS_mincore, SYS_mlock, SYS_munlock, SYS_mlock2,
    SYS_memfd_create, SYS_membarrier, SYS_mbind, SYS_get_mempolicy, SYS_set_mempolicy,
    SYS_rt_sigaction, SYS_rt_sigprocmask, SYS_rt_sigreturn, SYS_rt_sigsuspend, SYS_rt_sigpending, SYS_rt_sigtimedwait, SYS_sigaltstack,
    SYS_tgkill, SYS_tkill, SYS_setitimer, SYS_getitimer, SYS_timer_create, SYS_timer_settime, SYS_timer_gettime, SYS_timer_delete,
    SYS_timer_getoverrun, SYS_nanosleep, SYS_clock_nanosleep, SYS_clock_gettime, SYS_clock_getres, SYS_gettimeofday, SYS_times,
    SYS_futex, SYS_set_robust_list, SYS_get_robust_list, SYS_rseq, SYS_set_tid_address, SYS_sched_yield, SYS_sched_getaffinity,
    SYS_sched_setaffinity, SYS_sched_getparam, SYS_sched_setparam, SYS_sched_getscheduler, SYS_sched_setscheduler, SYS_sched_getattr,
    SYS_sched_setattr, SYS_sched_get_priority_max, SYS_sched_get_priority_min, SYS_getpriority, SYS_setpriority, SYS_getcpu,
    SYS_execve, SYS_wait4, SYS_waitid, SYS_exit, SYS_exit_group, SYS_restart_syscall, SYS_prctl,
    SYS_getpid, SYS_getppid, SYS_gettid, SYS_getuid, SYS_geteuid, SYS_getgid, SYS_getegid, SYS_getgroups, SYS_getresuid, SYS_getresgid,
    SYS_getpgid, SYS_setpgid, SYS_getsid, SYS_setsid, SYS_uname, SYS_sysinfo, SYS_getrusage, SYS_prlimit64, SYS_getrandom,
    SYS_ppoll, SYS_pselect6, SYS_eventfd2, SYS_epoll_create1, SYS_epoll_ctl, SYS_epoll_pwait, SYS_timerfd_create, SYS_timerfd_settime,
    SYS_inotify_init1, SYS_inotify_add_watch, SYS_inotify_rm_watch, SYS_kcmp, SYS_getxattr, SYS_lgetxattr, SYS_fgetxattr,
#ifdef SYS_open
    SYS_open, SYS_stat, SYS_lstat, SYS_access, SYS_pipe, SYS_dup2, SYS_poll, SYS_select, SYS_vfork, SYS_fork, SYS_unlink, SYS_rename, SYS_mkdir,
    SYS_rmdir, SYS_readlink, SYS_chmod, SYS_getdents, SYS_creat, SYS_epoll_wait, SYS_epoll_create, SYS_eventfd, SYS_time, SYS_alarm,
    SYS_pause, SYS_getpgrp, SYS_utime, SYS_utimes, SYS_futimesat,
#endif
#ifdef SYS_arch_prctl
    SYS_arch_prctl,
#endif
#ifdef SYS_getrlimit
    SYS_getrlimit, SYS_setrlimit,
#endif
};

/* Nothing here asks for these; who does has taken the process over. */
static const short deadly_calls[] = {
    SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev, SYS_mount, SYS_umount2, SYS_pivot_root, SYS_chroot, SYS_unshare, SYS_setns,
    SYS_kexec_load, SYS_reboot, SYS_swapon, SYS_swapoff, SYS_init_module, SYS_finit_module, SYS_delete_module, SYS_bpf, SYS_userfaultfd,
    SYS_perf_event_open, SYS_keyctl, SYS_add_key, SYS_request_key, SYS_open_by_handle_at, SYS_setuid, SYS_setgid, SYS_setresuid,
    SYS_setresgid, SYS_setgroups, SYS_settimeofday, SYS_clock_settime, SYS_sethostname, SYS_acct, SYS_quotactl,
};

enum { ALLOWED = sizeof allowed_calls / sizeof *allowed_calls, DEADLY = sizeof deadly_calls / sizeof *deadly_calls };

#ifdef __x86_64__
static const uint32_t MACHINE = AUDIT_ARCH_X86_64;
#else
static const uint32_t MACHINE = AUDIT_ARCH_AARCH64;
#endif

typedef struct Program { struct sock_filter code[2 * (ALLOWED + DEADLY) + 64]; unsigned short count; } Program;

static void put(Program *p, uint16_t code, uint32_t value, uint8_t yes, uint8_t no)
{
    p->code[p->count++] = (struct sock_filter){code, yes, no, value};
}

static void load_word(Program *p, size_t offset)
{
    put(p, BPF_LD | BPF_W | BPF_ABS, (uint32_t)offset, 0, 0);
}

static void answer(Program *p, uint32_t action)
{
    put(p, BPF_RET | BPF_K, action, 0, 0);
}

/* If the word just loaded is `value`: that action. */
static void answer_if(Program *p, uint32_t value, uint32_t action)
{
    put(p, BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    answer(p, action);
}

/* If the call is `number` and its argument (or, with bits, one of those bits of it) is that: EPERM. */
static void refuse_argument(Program *p, uint32_t number, int argument, uint16_t test, uint32_t value)
{
    put(p, BPF_JMP | BPF_JEQ | BPF_K, number, 0, 4);
    load_word(p, offsetof(struct seccomp_data, args[0]) + 8 * (size_t)argument);
    put(p, (uint16_t)(BPF_JMP | test | BPF_K), value, 0, 1);
    answer(p, SECCOMP_RET_ERRNO | EPERM);
    answer(p, SECCOMP_RET_ALLOW);
}

static void write_program(Program *p)
{
    const uint32_t namespaces = CLONE_NEWUSER | CLONE_NEWNS | CLONE_NEWPID | CLONE_NEWNET | CLONE_NEWIPC | CLONE_NEWUTS | CLONE_NEWCGROUP;
    load_word(p, offsetof(struct seccomp_data, arch));
    put(p, BPF_JMP | BPF_JEQ | BPF_K, MACHINE, 1, 0);
    answer(p, SECCOMP_RET_KILL_PROCESS);
    load_word(p, offsetof(struct seccomp_data, nr));
    for (int i = 0; i < ALLOWED; i++)
        answer_if(p, (uint32_t)allowed_calls[i], SECCOMP_RET_ALLOW);
    for (int i = 0; i < DEADLY; i++)
        answer_if(p, (uint32_t)deadly_calls[i], SECCOMP_RET_KILL_PROCESS);
    answer_if(p, SYS_socket, SECCOMP_RET_ERRNO | EACCES);
    answer_if(p, SYS_kill, SECCOMP_RET_ERRNO | EPERM);
    refuse_argument(p, SYS_ioctl, 1, BPF_JEQ, TIOCSTI);         /* types into the terminal */
    refuse_argument(p, SYS_clone, 0, BPF_JSET, namespaces);
    answer(p, SECCOMP_RET_ERRNO | ENOSYS);      /* clone3 among them, whose flags cannot be seen: the C library takes clone */
}

static bool shut_calls(void)
{
    Program p = {.count = 0};
    write_program(&p);
    struct sock_fprog filter = {p.count, p.code};
    return UNDER_SANITIZER || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter, 0, 0) == 0;
}

bool jail_enter(const Jail *jail, char *text, size_t capacity)
{
    int version = landlock_version();
    bool ready = prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0;
    bool files = ready && shut_files(jail, version), calls = ready && shut_calls();
    if (files)
        snprintf(text, capacity, "landlock %d holds, seccomp %s", version, calls ? "holds" : "is missing");
    else
        snprintf(text, capacity, "landlock is missing, seccomp %s", calls ? "holds" : "is missing, too");
    return files && calls;
}

bool jail_describe(char *text, size_t capacity)
{
    int version = landlock_version();
    bool calls = prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0;
    snprintf(text, capacity, "landlock %s (version %d), seccomp %s", version ? "is there" : "is missing", version, calls ? "is there" : "is missing");
    return version > 0 && calls;
}

#else

bool jail_enter(const Jail *jail, char *text, size_t capacity)
{
    (void)jail;
    snprintf(text, capacity, "landlock and seccomp are missing: they are known for Linux on x86-64 and ARM64 only");
    return false;
}

bool jail_describe(char *text, size_t capacity)
{
    return jail_enter(NULL, text, capacity);
}

#endif
