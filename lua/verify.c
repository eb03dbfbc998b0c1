/* lua/verify.c - the command `digbox verify`: simulates a replay again and compares the checksum of every step; of a folder with films,
 * see verify_film.c. */
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "state.h"

#include "digbox.h"
#include "replay/rerun.h"

static int fail(const char *path, const char *why, dig_status s)
{
    char text[700];
    snprintf(text, sizeof text, "%s%s%s", strncmp(why, path, strlen(path)) == 0 ? "" : path, strncmp(why, path, strlen(path)) == 0 ? "" : ": ", why);
    say_error(text);
    return exit_code_of_reading(s);
}

static int report(const char *path, const Replay *r, const Rerun *o)
{
    const ReplayInfo *info = replay_info(r);
    const char *cut = info->cut ? ", of a file that ends early" : "";
    if (o->differs < 0) {
        printf("%s: %d steps, %d commands%s: every checksum the same\n", path, o->frames - 1, o->commands, cut);
        return flush_output(EXIT_FINE);
    }
    printf("%s: differs at frame %d (step %" PRIu64 ", t = %.6g s) after %d commands%s: %s", path, o->differs, o->step,
           (double)o->step * info->step, o->commands, cut, o->why);
    if (o->was != o->is)
        printf(" (checksum %016" PRIx64 ", now %016" PRIx64 ")", o->was, o->is);
    if (strcmp(info->digbox, DIGBOX_VERSION) != 0)
        printf("; it was made by digbox %s, this is %s", info->digbox, DIGBOX_VERSION);
    printf("\n");
    return flush_output(EXIT_DIVERGED);
}

static int verify(const char *path)
{
    char why[600] = "";
    Replay *r;
    Rerun o;
    dig_status s = replay_open(path, &r, why, sizeof why);
    if (s != DIG_OK)
        return fail(path, why, s);
    s = replay_rerun(r, &o, why, sizeof why);
    int code = s == DIG_OK ? report(path, r, &o) : fail(path, why, s);
    replay_close(r);
    return code;
}

static int command_verify(int argc, char **argv)
{
    static const struct option options[] = {{"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
    int key = next_option("verify", argc, argv, "h", options), worst = EXIT_FINE;
    if (key != -1)
        return key == 'h' ? print_help("verify") : EXIT_USAGE;
    if (optind >= argc)
        return usage_error("verify: which replays? (digbox verify REPLAY... or FOLDER...)");
    for (int i = optind; i < argc; i++) {
        int code = verify_is_film(argv[i]) ? verify_film(argv[i]) : verify(argv[i]);
        worst = code > worst ? code : worst;
    }
    return worst;
}

const Command verify_command = {
    .name = "verify",
    .use = "  digbox verify REPLAY...                         simulate replays again: is the checksum of every step the same?\n"
           "  digbox verify FOLDER...                         are the frames of films in it as they were written?\n",
    .notes =
        "\n"
        "A replay (digbox run --replay) holds the world it began with and every command that changed it; what effects written in Lua\n"
        "gave back is in the log, so that no script is needed. Exit code 0: every checksum is the same, 7: one differs, which is named,\n"
        "8: the file is no replay, or holds no log.\n"
        "Beside the frames of a film stands a manifest (docs/frames.md) with their sizes and SHA-256. Exit code 0: all are as they were\n"
        "written, 8: one is not, which is named.\n",
    .run = command_verify,
};
