/* lua/diff.c - `digbox diff A.replay B.replay`: the first step after which two runs differ, and the body that differs most there. */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command.h"
#include "replay/replay.h"
#include "state.h"

typedef struct Diff {
    Replay     *r[2];
    const char *path[2];
    double      tolerance;      /* m and rad; 0: to the last bit */
    bool        quiet;
} Diff;

typedef struct Apart {          /* bodies of one frame */
    int  body;                  /* that is farthest from its other self; -1: none */
    int  count;                 /* that differ */
    real worst;                 /* the larger of the two below */
    real distance, angle;       /* m, rad */
} Apart;

static const char *body_text(const Replay *r, int index, char *out, size_t capacity)
{
    const ReplayBody *b = replay_body(r, index);
    if (b && b->name[0])
        snprintf(out, capacity, "body '%s'", b->name);
    else
        snprintf(out, capacity, "body #%d", index);
    return out;
}

static int bad_file(const Replay *r, dig_status status)
{
    say_error(replay_error(r));
    return exit_code_of_reading(status);
}

/* ---- what there is ---- */

static int differ(const Diff *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
static int differ(const Diff *d, const char *format, ...)
{
    va_list arguments;
    if (d->quiet)
        return EXIT_DIVERGED;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
    return EXIT_DIVERGED;
}

static int compare_starts(const Diff *d)
{
    const ReplayInfo *a = replay_info(d->r[0]), *b = replay_info(d->r[1]);
    if (a->step != b->step)
        return differ(d, "the steps are %.17g s and %.17g s long", a->step, b->step);
    if (a->first_step != b->first_step)
        return differ(d, "one begins after %llu steps, the other after %llu", (unsigned long long)a->first_step, (unsigned long long)b->first_step);
    return EXIT_FINE;
}

/* ---- one frame ---- */

static real distance_between(vec3 a, vec3 b) { return hypot(hypot(a.x - b.x, a.y - b.y), a.z - b.z); }

/* From the chord between the nearer of the two quaternions that a rotation has: exact for small angles, where a product is not. */
static real angle_between(quat a, quat b)
{
    real sign = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w < 0 ? -1 : 1;
    real chord = hypot(hypot(a.x - sign * b.x, a.y - sign * b.y), hypot(a.z - sign * b.z, a.w - sign * b.w));
    return 4 * asin(fmin(0.5 * chord, 1));
}

static void compare_pose(const Diff *d, const ReplayPose *a, const ReplayPose *b, Apart *apart)
{
    bool same = memcmp(&a->position, &b->position, sizeof a->position) == 0 && memcmp(&a->rotation, &b->rotation, sizeof a->rotation) == 0;
    if (same)
        return;
    real distance = distance_between(a->position, b->position), angle = angle_between(a->rotation, b->rotation);
    real worst = distance > angle ? distance : angle;
    if (d->tolerance > 0 && worst <= d->tolerance)
        return;
    apart->count++;
    if (apart->body < 0 || worst > apart->worst)
        *apart = (Apart){a->body, apart->count, worst, distance, angle};
}

static int tell_pose(const Diff *d, const ReplayFrame *f, const Apart *apart, unsigned long long step)
{
    char name[100], more[80] = "";
    if (apart->count > 1)
        snprintf(more, sizeof more, "; %d bodies differ, it most", apart->count);
    return differ(d, "first difference after step %llu (frame %d, t = %.6g s): %s by %.3g m and %.3g rad%s", step, f->frame, f->time,
                  body_text(d->r[0], apart->body, name, sizeof name), apart->distance, apart->angle, more);
}

/* A body that is there in one of them only; by index, as poses are. */
static int compare_presence(const Diff *d, const ReplayFrame *a, const ReplayFrame *b, unsigned long long step)
{
    for (int i = 0; i < a->pose_count || i < b->pose_count; i++) {
        int x = i < a->pose_count ? a->poses[i].body : INT_MAX, y = i < b->pose_count ? b->poses[i].body : INT_MAX;
        int in = x < y ? 0 : 1;
        char name[100];
        if (x != y)
            return differ(d, "first difference after step %llu (frame %d, t = %.6g s): %s is in %s only", step, a->frame, a->time,
                          body_text(d->r[in], x < y ? x : y, name, sizeof name), d->path[in]);
    }
    return EXIT_FINE;
}

static int compare_frames(const Diff *d, const ReplayFrame *a, const ReplayFrame *b)
{
    unsigned long long step = replay_info(d->r[0])->first_step + (unsigned long long)a->frame;
    Apart apart = {-1, 0, 0, 0, 0};
    int code = compare_presence(d, a, b, step);
    if (code != EXIT_FINE)
        return code;
    for (int i = 0; i < a->pose_count; i++)
        compare_pose(d, &a->poses[i], &b->poses[i], &apart);
    if (apart.count > 0)
        return tell_pose(d, a, &apart, step);
    if (d->tolerance == 0 && a->checksum != b->checksum)
        return differ(d, "first difference after step %llu (frame %d, t = %.6g s): every body is where it is in the other, but the states are not "
                      "the same (%016llx and %016llx)", step, a->frame, a->time, (unsigned long long)a->checksum, (unsigned long long)b->checksum);
    return EXIT_FINE;
}

/* ---- all frames ---- */

static int compare(const Diff *d)
{
    int frames[2] = {replay_info(d->r[0])->frames, replay_info(d->r[1])->frames};
    int common = frames[0] < frames[1] ? frames[0] : frames[1], code = compare_starts(d);
    for (int i = 0; i < common && code == EXIT_FINE; i++) {
        const ReplayFrame *f[2];
        for (int k = 0; k < 2; k++) {
            dig_status status = replay_frame(d->r[k], i, &f[k]);
            if (status != DIG_OK)
                return bad_file(d->r[k], status);
        }
        code = compare_frames(d, f[0], f[1]);
    }
    if (code == EXIT_FINE && frames[0] != frames[1])
        code = differ(d, "the same up to frame %d, where %s ends; %s has %d more", common - 1, d->path[frames[0] < frames[1] ? 0 : 1],
                      d->path[frames[0] < frames[1] ? 1 : 0], abs(frames[0] - frames[1]));
    if (code == EXIT_FINE && !d->quiet) {
        char how[60] = "the last bit";
        int bodies = replay_info(d->r[0])->bodies;
        if (d->tolerance > 0)
            snprintf(how, sizeof how, "%g m and rad", d->tolerance);
        printf("the same to %s: %d frame%s, %d %s\n", how, common, common == 1 ? "" : "s", bodies, bodies == 1 ? "body" : "bodies");
    }
    return code;
}

static int compare_files(Diff *d)
{
    char why[1400] = "";
    int code = EXIT_FINE;
    for (int k = 0; k < 2 && code == EXIT_FINE; k++) {
        code = exit_code_of_reading(replay_open(d->path[k], &d->r[k], why, sizeof why));
        if (code != EXIT_FINE) {
            say_error(why);
        } else if (replay_info(d->r[k])->cut && !d->quiet) {
            fprintf(stderr, "digbox: %s ends early: its first %d frames are compared\n", d->path[k], replay_info(d->r[k])->frames);
        }
    }
    if (code == EXIT_FINE)
        code = compare(d);
    replay_close(d->r[0]);
    replay_close(d->r[1]);
    return flush_output(code);
}

static int command_diff(int argc, char **argv)
{
    static const struct option options[] = {
        {"tolerance", required_argument, NULL, 't'}, {"quiet", no_argument, NULL, 'q'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0},
    };
    Diff d = {.tolerance = 0};
    int key;
    while ((key = next_option("diff", argc, argv, "qh", options)) != -1) {
        if (key == 'h')
            return print_help("diff");
        if (key == 'q')
            d.quiet = true;
        else if (key != 't')
            return EXIT_USAGE;
        else if (!read_number_option("tolerance", optarg, "m", 0, 1e9, &d.tolerance))
            return EXIT_USAGE;
    }
    if (argc - optind != 2)
        return usage_error("diff: which two? (digbox diff A.replay B.replay)");
    d.path[0] = argv[optind];
    d.path[1] = argv[optind + 1];
    return compare_files(&d);
}

const Command diff_command = {
    .name = "diff",
    .use = "  digbox diff A.replay B.replay [options]         the first step after which two runs differ, and the body that differs most\n",
    .options =
        "      --tolerance LENGTH      bodies nearer than that, and turned by less (rad for m), count as the same (default: to the last bit)\n"
        "  -q, --quiet             the exit code only: 0 the same, 7 they differ, 8 a file is bad\n",
    .run = command_diff,
};
