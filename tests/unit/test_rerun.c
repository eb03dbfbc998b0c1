/* tests/unit/test_rerun.c - a replay simulated again: the same checksums, or the first frame that has another one. */
#include "save_fixture.h"

#include "replay/rerun.h"

enum { FRAMES = 40, MEDDLED = 12 };

typedef struct Forger {         /* between a world and a recorder: at a step, something is put into the log, or left out */
    Recorder *r;
    int       steps, at;
    unsigned char extra[256];
    size_t    extra_size;
    bool      drop;
} Forger;

static void forge(void *context, const void *bytes, size_t size)
{
    Forger *f = context;
    bool is_step = strcmp(dig_command_name(dig_command_look(bytes, size, NULL)), "step") == 0;
    if (is_step && ++f->steps == f->at) {
        CHECK_INT(recorder_commands(f->r, f->extra, f->extra_size), DIG_OK);
        if (f->drop)
            return;
    }
    CHECK_INT(recorder_commands(f->r, bytes, size), DIG_OK);
}

static void keep_one(void *context, const void *bytes, size_t size)
{
    Forger *f = context;
    CHECK(size <= sizeof f->extra);
    memcpy(f->extra, bytes, size);
    f->extra_size = size;
}

/* The bytes of a hit, from a world like the one that is recorded. */
static void learn_hit(Forger *f, real impulse)
{
    dig_world *w = open_small_scene();
    dig_body all[8];
    CHECK(dig_bodies(w, all, 8) >= 2);
    fail_unless(w, dig_world_tap(w, keep_one, f), "tap");
    fail_unless(w, dig_body_hit(w, all[1], (vec3){impulse, 0, 0}, vec3_zero(), false), "hit");
    dig_world_close(w);
}

static Rerun rerun(const char *path, dig_status want, char *why, size_t capacity)
{
    Replay *r;
    Rerun o;
    why[0] = '\0';
    if (replay_open(path, &r, why, capacity) != DIG_OK)
        fail_msg("%s", why);
    CHECK_INT(replay_rerun(r, &o, why, capacity), want);
    replay_close(r);
    return o;
}

/* f NULL: as it is; start: with a saved world */
static void record(const char *path, Forger *f, bool start)
{
    char why[1400] = "";
    dig_world *w = open_small_scene();
    Recorder *r;
    if (recorder_open(path, w, "{}", &r, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
    if (!f && start)
        CHECK_INT(recorder_listen(r), DIG_OK);
    if (f) {
        void *bytes;
        size_t size;
        fail_unless(w, dig_world_pack(w, &bytes, &size), "pack");
        CHECK_INT(recorder_start(r, bytes, size), DIG_OK);
        free(bytes);
        f->r = r;
        fail_unless(w, dig_world_tap(w, forge, f), "tap");
    }
    for (int i = 0; i < FRAMES; i++) {
        CHECK_INT(recorder_before_step(r), DIG_OK);
        step(w, 1);
        CHECK_INT(recorder_step(r), DIG_OK);
    }
    if (f)
        fail_unless(w, dig_world_tap(w, NULL, NULL), "tap");
    CHECK_INT(recorder_close(r, why, sizeof why), DIG_OK);
    step(w, 1);                     /* nobody listens any more */
    dig_world_close(w);
}

TEST(a_rerun_has_the_same_checksums)
{
    char path[512], why[400];
    record(scratch_path(path, sizeof path, "same.replay"), NULL, true);
    Rerun o = rerun(path, DIG_OK, why, sizeof why);
    CHECK_INT(o.differs, -1);
    CHECK_INT(o.frames, FRAMES + 1);
    CHECK_INT(o.commands, FRAMES);
    CHECK_TEXT(o.why, "");
    remove(path);
}

TEST(the_first_other_frame_is_named)
{
    char path[512], why[400];
    Forger f = {.at = MEDDLED};
    learn_hit(&f, 1e-9);            /* N s: too little to be seen */
    record(scratch_path(path, sizeof path, "hit.replay"), &f, true);
    Rerun o = rerun(path, DIG_OK, why, sizeof why);
    CHECK_INT(o.differs, MEDDLED);
    CHECK_INT(o.step, MEDDLED + 5);     /* the scene was stepped before */
    CHECK_INT(o.frames, MEDDLED);
    CHECK(o.was != o.is);
    CHECK_TEXT(o.why, "the step led to another state");
    remove(path);
}

TEST(a_step_that_is_missing_is_found)
{
    char path[512], why[400];
    Forger f = {.at = MEDDLED, .drop = true};
    record(scratch_path(path, sizeof path, "drop.replay"), &f, true);
    CHECK_INT(rerun(path, DIG_OK, why, sizeof why).differs, MEDDLED);
    remove(path);
}

TEST(a_command_that_goes_another_way_is_found)
{
    char path[512], why[400];
    Forger f = {.at = MEDDLED};
    learn_hit(&f, 1e-9);
    f.extra[1] = DIG_E_ARG;         /* it was refused then, says the log */
    record(scratch_path(path, sizeof path, "refused.replay"), &f, true);
    Rerun o = rerun(path, DIG_OK, why, sizeof why);
    CHECK_INT(o.differs, MEDDLED);
    CHECK(strstr(o.why, "command 'hit' returned 'ok'") != NULL);
    remove(path);
}

TEST(what_is_no_log_is_said_to_be_none)
{
    char path[512], why[400];
    Forger f = {.at = MEDDLED, .extra = {250, 0, 0, 0, 0, 0}, .extra_size = 6};
    record(scratch_path(path, sizeof path, "rubbish.replay"), &f, true);
    rerun(path, DIG_E_FORMAT, why, sizeof why);
    CHECK(strstr(why, "frame 12: this is no command") != NULL);
    record(path, NULL, false);
    rerun(path, DIG_E_FORMAT, why, sizeof why);
    CHECK(strstr(why, "no log of commands") != NULL);
    remove(path);
}

int main(void)
{
    RUN_TESTS(unit_test(a_rerun_has_the_same_checksums), unit_test(the_first_other_frame_is_named), unit_test(a_step_that_is_missing_is_found),
              unit_test(a_command_that_goes_another_way_is_found), unit_test(what_is_no_log_is_said_to_be_none));
}
