/* tests/unit/test_replay.c - a run that is kept and read again: the same pictures, the same numbers, whatever happens to the file. */
#include "save_fixture.h"

#include <libdeflate.h>

#include "replay/replay.h"

enum { FRAMES = 90 };

/* What a film sees of each frame, taken from the running world. */
typedef struct Seen {
    View    *arrived[FRAMES], *left[FRAMES];    /* after the step, and before the next one */
    uint64_t checksum[FRAMES];
    real     energy[FRAMES];
    int      events[FRAMES];
    int      count;
} Seen;

static View *view_of(dig_world *w)
{
    View *v;
    fail_unless(w, dig_view_take(w, &v), "view");
    return v;
}

static void see(dig_world *w, Seen *s, int frame)
{
    const dig_event *events;
    s->arrived[frame] = view_of(w);
    s->checksum[frame] = dig_world_checksum(w);
    s->energy[frame] = dig_world_energy(w).total;
    s->events[frame] = dig_events(w, &events);
    s->count = frame + 1;
}

static void forget(Seen *s)
{
    for (int i = 0; i < s->count; i++) {
        dig_view_free(s->arrived[i]);
        dig_view_free(s->left[i]);
    }
}

typedef void Meddle(dig_world *w, int frame);       /* what a script does between steps */

/* `listen`: the recorder hears what is done to the world, and takes only what that may have changed. */
static void record_as(dig_world *w, const char *path, int frames, Meddle *meddle, Seen *s, bool listen)
{
    char why[1400] = "";
    Recorder *r;
    if (recorder_open(path, w, "{\"script\":\"a test\"}", &r, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
    if (listen)
        CHECK_INT(recorder_listen(r), DIG_OK);
    see(w, s, 0);
    for (int i = 0; i < frames; i++) {
        if (meddle)
            meddle(w, i);
        CHECK_INT(recorder_before_step(r), DIG_OK);
        s->left[i] = view_of(w);
        if (i + 1 == frames)
            break;
        step(w, 1);
        CHECK_INT(recorder_step(r), DIG_OK);
        see(w, s, i + 1);
    }
    if (recorder_close(r, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
}

static void record(dig_world *w, const char *path, int frames, Meddle *meddle, Seen *s) { record_as(w, path, frames, meddle, s, false); }

static Replay *open_replay(const char *path)
{
    char why[1400] = "";
    Replay *r;
    if (replay_open(path, &r, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
    return r;
}

/* ---- are two pictures the same, bit for bit? ---- */

#define SAME_ARRAY(a, b, count) (memcmp((a), (b), (size_t)(count) * sizeof *(a)) == 0)

static void same_mesh(const ViewMesh *a, const ViewMesh *b)
{
    CHECK_INT(a->form, b->form);
    CHECK_INT(a->vertex_count, b->vertex_count);
    CHECK_INT(a->index_count, b->index_count);
    CHECK(SAME_ARRAY(a->size, b->size, 3));
    CHECK((a->normals != NULL) == (b->normals != NULL));
    CHECK(a->vertex_count == 0 || SAME_ARRAY(a->vertices, b->vertices, 3 * a->vertex_count));
    CHECK(!a->normals || SAME_ARRAY(a->normals, b->normals, 3 * a->vertex_count));
    CHECK(a->index_count == 0 || SAME_ARRAY(a->indices, b->indices, a->index_count));
}

static void same_item(const ViewItem *a, const ViewItem *b)
{
    CHECK_INT(a->body, b->body);
    CHECK_INT(a->mesh, b->mesh);
    CHECK(SAME_ARRAY(a->p, b->p, 3) && SAME_ARRAY(a->q, b->q, 4) && SAME_ARRAY(a->colour, b->colour, 3));
    CHECK(a->roughness == b->roughness && a->metallic == b->metallic && a->pattern == b->pattern && a->dig == b->dig);
    CHECK(a->clear == b->clear);
    CHECK(a->stress == b->stress && a->asleep == b->asleep && a->fixed == b->fixed && a->temperature == b->temperature);
}

static void same_marks(const View *a, const View *b)
{
    CHECK_INT(a->contact_count, b->contact_count);
    CHECK(a->contact_count == 0 || SAME_ARRAY(a->contacts, b->contacts, a->contact_count));
    CHECK_INT(a->line_count, b->line_count);
    CHECK(a->line_count == 0 || SAME_ARRAY(a->lines, b->lines, a->line_count));
    CHECK_INT(a->arrow_count, b->arrow_count);
    CHECK(a->arrow_count == 0 || SAME_ARRAY(a->arrows, b->arrows, a->arrow_count));
    CHECK_INT(a->label_count, b->label_count);
    CHECK(a->label_count == 0 || SAME_ARRAY(a->labels, b->labels, a->label_count));
    CHECK_INT(a->edge_count, b->edge_count);
    for (int i = 0; i < a->edge_count; i++) {
        const ViewEdge *x = &a->edges[i], *y = &b->edges[i];
        CHECK(SAME_ARRAY(x->a, y->a, 3) && SAME_ARRAY(x->b, y->b, 3));
        CHECK(x->dig == y->dig && x->kind == y->kind && x->layer == y->layer && x->bound == y->bound);
    }
}

static void same_view(const View *a, const View *b)
{
    CHECK(SAME_ARRAY(a->origin, b->origin, 3) && SAME_ARRAY(a->low, b->low, 3) && SAME_ARRAY(a->high, b->high, 3) && SAME_ARRAY(a->up, b->up, 3));
    CHECK(a->time == b->time && a->step == b->step && a->seed == b->seed);
    CHECK_INT(a->mesh_count, b->mesh_count);
    for (int i = 0; i < a->mesh_count; i++)
        same_mesh(&a->meshes[i], &b->meshes[i]);
    CHECK_INT(a->item_count, b->item_count);
    for (int i = 0; i < a->item_count; i++)
        same_item(&a->items[i], &b->items[i]);
    same_marks(a, b);
}

/* A film of the running world: before from one frame as it was left, after from the next as it arrived. */
static void same_between(Replay *r, const Seen *s, int frame, real f, real step)
{
    View *v, *b = s->arrived[frame + 1];
    real time = s->left[frame]->time + f * step;
    ViewPose *from = view_poses(s->left[frame]), *to = view_poses(b);
    real share = (time - (b->time - step)) / step, taken = b->time;
    CHECK(from && to);
    view_blend(s->left[frame], from, b, to, share);
    b->time = s->left[frame]->time + share * (b->time - s->left[frame]->time);
    CHECK_INT(replay_view(r, time, &v), DIG_OK);
    same_view(v, b);
    dig_view_free(v);
    view_blend(b, to, b, to, 1);
    for (int i = 0; i < b->item_count; i++) {
        memcpy(b->items[i].p, to[i].p, sizeof to[i].p);
        memcpy(b->items[i].q, to[i].q, sizeof to[i].q);
    }
    b->time = taken;
    free(from);
    free(to);
}

static void same_pictures(Replay *r, const Seen *s)
{
    real h = replay_info(r)->step;
    CHECK_INT(replay_info(r)->frames, s->count);
    for (int i = 0; i < s->count; i++) {
        View *v;
        if (replay_view(r, s->left[i]->time, &v) != DIG_OK)
            fail_msg("%s", replay_error(r));
        same_view(v, s->left[i]);
        dig_view_free(v);
        if (i + 1 < s->count) {
            same_between(r, s, i, 0.25, h);
            same_between(r, s, i, 0.7, h);
        }
    }
    for (int i = s->count - 2; i >= 0; i -= 7)          /* and backwards */
        same_between(r, s, i, 0.5, h);
}

/* ---- the run and what is read of it ---- */

TEST(everything_looks_the_same)
{
    char path[512];
    Seen s = {0};
    dig_world *w = open_scene();
    record(w, scratch_path(path, sizeof path, "all.replay"), FRAMES, NULL, &s);
    Replay *r = open_replay(path);
    const ReplayInfo *info = replay_info(r);
    CHECK(!info->cut && info->version >= 1 && info->step == dig_world_frame(w));
    CHECK_TEXT(info->digbox, DIGBOX_VERSION);
    CHECK_TEXT(info->origin, "{\"script\":\"a test\"}");
    same_pictures(r, &s);
    int events = 0;
    for (int i = 0; i < FRAMES; i++) {
        const ReplayFrame *f;
        CHECK_INT(replay_frame(r, i, &f), DIG_OK);
        CHECK(f->checksum == s.checksum[i] && f->energy.total == s.energy[i] && f->time == s.left[i]->time);
        CHECK_INT(f->event_count, s.events[i]);
        CHECK_INT(f->link_count, s.left[i]->edge_count);
        events += f->event_count;
    }
    CHECK(events > 20);
    replay_close(r);
    forget(&s);
    dig_world_close(w);
    remove(path);
}


/* ---- what a script does between steps ---- */

static void meddle(dig_world *w, int frame)
{
    dig_body ball = dig_body_find(w, "ball"), b;
    if (frame % 4 == 3 && frame < 40) {                 /* the slot is used again two frames later */
        b = dig_body_find(w, "guest");
        if (b.gen != 0)
            fail_unless(w, dig_body_remove(w, b), "remove");
    } else if (frame % 4 == 1) {
        b = add_ball(w, look(0.5, 0.5), 0.1 + 0.01 * frame, 1, (vec3){-2, 2, 3 + 0.1 * frame}, (vec3){0, 1, 0});
        fail_unless(w, dig_body_set(w, b, "name", &(dig_text){"guest"}), "name");
    }
    if (frame == 10)
        fail_unless(w, dig_body_teleport(w, ball, &(vec3){0, 3, 0}, NULL, NULL, NULL), "teleport");
    if (frame % 9 == 5)
        fail_unless(w, dig_body_push(w, ball, (vec3){0, 30, 3}, vec3_zero(), false, 0.05), "push");
    if (frame == 20)
        fail_unless(w, dig_body_set(w, dig_body_find(w, "stone"), "colour", &(vec3){1, 0, 0}), "colour");
    if (frame == 24)
        fail_unless(w, dig_body_set(w, dig_body_find(w, "stone"), "opacity", &(real){0.25}), "opacity");
    if (frame == 33)
        fail_unless(w, dig_world_set_gravity(w, (vec3){1, -3, 0}), "gravity");
    dig_joint joints[8];
    if (frame == 37 && dig_joints(w, joints, 8) > 0)
        fail_unless(w, dig_joint_remove(w, joints[0]), "joint");
}

static void judge_meddling(bool listen)
{
    char path[512];
    Seen s = {0};
    dig_world *w = open_scene();
    record_as(w, scratch_path(path, sizeof path, "meddle.replay"), FRAMES, meddle, &s, listen);
    Replay *r = open_replay(path);
    same_pictures(r, &s);
    replay_close(r);
    forget(&s);
    dig_world_close(w);
    remove(path);
}

TEST(what_a_script_does_between_steps_is_seen) { judge_meddling(false); }

TEST(and_by_one_who_hears_of_it) { judge_meddling(true); }

/* A slot that is used again holds another body. */
TEST(bodies_are_born_and_die)
{
    char path[512];
    Seen s = {0};
    dig_world *w = open_scene();
    record(w, scratch_path(path, sizeof path, "born.replay"), 60, meddle, &s);
    Replay *r = open_replay(path);
    int guests = 0, gone = 0, slots[100] = {0}, again = 0;
    for (int i = 0; replay_body(r, i); i++) {
        const ReplayBody *b = replay_body(r, i);
        CHECK_INT(replay_body_of(r, b->id), i);
        CHECK(b->born >= 0 && b->died > b->born && b->died <= 60);
        again += b->id.slot < 100 && slots[b->id.slot]++ > 0;
        if (strcmp(b->name, "guest") != 0)
            continue;
        guests++;
        gone += b->died < 60;
        CHECK(b->born % 4 == 1);
        CHECK_TEXT(b->shape, "sphere");
        CHECK_NEAR(b->mass, 1, 0);
        for (int k = 0; k < 60; k++) {                  /* it is among the poses as long as it lives */
            const ReplayFrame *f;
            int there = 0;
            CHECK_INT(replay_frame(r, k, &f), DIG_OK);
            for (int p = 0; p < f->pose_count; p++)
                there += f->poses[p].body == i;
            CHECK_INT(there, k >= b->born && k < b->died);
        }
    }
    CHECK(guests >= 10 && gone >= 9 && again >= 9);
    CHECK(replay_body_of(r, (dig_body){9999, 1}) == -1);
    replay_close(r);
    forget(&s);
    dig_world_close(w);
    remove(path);
}

/* Joints that break, struts that carry: a tower of struts under a load. */
static void hold(dig_world *w, const char *type, dig_body a, dig_body b, vec3 at)
{
    real data[48];
    const dig_schema *schema = dig_schema_find("joint", type);
    static const struct { const char *name; real value; } given[] = {
        {"stiffness", 2e5}, {"radius", 0.03}, {"length", 0.5}, {"width", 0.05}, {"height", 0.05}, {"modulus", 1e9}, {"strength", 2e7},
    };
    dig_schema_defaults(schema, data);
    for (const dig_param *p = schema->rows; p->name; p++)
        for (size_t i = 0; i < sizeof given / sizeof *given; i++)
            if (strcmp(p->name, given[i].name) == 0 && p->kind == DIG_REAL)
                memcpy((char *)data + p->offset, &given[i].value, sizeof(real));
    dig_joint j = create_joint(w, type, a, b, at, (vec3){1, 0, 0}, data);
    if (strcmp(type, "strut") == 0)
        fail_unless(w, dig_joint_set(w, j, &(dig_setting){"breaks_at", &(real){80}}, 1), "breaks_at");
}

static dig_world *tower(void)
{
    dig_world *w = open_world(1.0 / 60, "play", true);
    dig_body before = add_floor(w, look(0.6, 0));
    for (int i = 0; i < 6; i++) {
        dig_body b = add_box(w, look(0.6, 0), (vec3){0.4, 0.2, 0.4}, 3, (vec3){0.5 * i, 2, 0}, quat_identity());
        hold(w, i == 0 ? "weld" : i % 2 ? "strut" : "beam", b, before, (vec3){0.5 * i - 0.25, 2, 0});
        before = b;
    }
    return w;
}

TEST(joints_break_and_bear)
{
    char path[512];
    Seen s = {0};
    dig_world *w = tower();
    record(w, scratch_path(path, sizeof path, "tower.replay"), FRAMES, NULL, &s);
    Replay *r = open_replay(path);
    int broken = 0, joints = 0;
    real stress = 0;
    for (int i = 0; i < FRAMES; i++) {
        const ReplayFrame *f;
        CHECK_INT(replay_frame(r, i, &f), DIG_OK);
        for (int k = 0; k < f->event_count; k++)
            broken += f->events[k].kind == DIG_EVENT_BROKEN;
        for (int k = 0; k < f->link_count; k++)
            joints += f->links[k].kind == DIG_LINK_JOINT;
        for (int k = 0; k < s.left[i]->item_count; k++)
            stress = fmax(stress, (real)s.left[i]->items[k].stress);
    }
    CHECK(broken > 0 && joints > 0 && stress > 0);
    same_pictures(r, &s);
    replay_close(r);
    forget(&s);
    dig_world_close(w);
    remove(path);
}

/* ---- poses and links are those of the API ---- */

static void same_body(const dig_world *w, const Replay *r, const ReplayPose *p)
{
    dig_body all[200];
    dig_body_state s;
    int n = dig_bodies(w, all, 200), i = 0;
    uint32_t slot = replay_body(r, p->body)->id.slot;
    while (i < n && all[i].slot != slot)
        i++;
    CHECK(i < n);
    CHECK_INT(dig_body_get(w, all[i], &s), DIG_OK);
    CHECK(memcmp(&s.position, &p->position, sizeof s.position) == 0 && memcmp(&s.rotation, &p->rotation, sizeof s.rotation) == 0);
    CHECK_NEAR(p->velocity.y, s.velocity.y, 1e-6 * (1 + fabs(s.velocity.y)));
    CHECK_NEAR(p->spin.z, s.spin.z, 1e-6 * (1 + fabs(s.spin.z)));
    CHECK_NEAR(p->force.y, s.force.y, 1e-6 * (1 + fabs(s.force.y)));
    CHECK(p->awake == s.awake && p->mode == s.mode && p->dig == s.dig.id);
    CHECK_TEXT(replay_body(r, p->body)->name, s.name);
}

TEST(poses_are_those_of_the_world)
{
    char path[512];
    Seen s = {0};
    const ReplayFrame *f;
    dig_world *w = open_scene();
    record(w, scratch_path(path, sizeof path, "poses.replay"), 40, NULL, &s);
    Replay *r = open_replay(path);
    CHECK_INT(replay_frame(r, 39, &f), DIG_OK);
    CHECK_INT(f->pose_count, dig_bodies(w, NULL, 0));
    for (int i = 0; i < f->pose_count; i++)
        same_body(w, r, &f->poses[i]);
    CHECK(replay_frame(r, 40, &f) == DIG_E_ARG && strstr(replay_error(r), "frame 40: there are 0 to 39"));
    CHECK(replay_frame(r, -1, &f) == DIG_E_ARG);
    View *v;
    CHECK(replay_view(r, NAN, &v) == DIG_E_ARG);
    replay_close(r);
    forget(&s);
    dig_world_close(w);
    remove(path);
}

/* ---- notes and commands ---- */

TEST(notes_and_commands_belong_to_frames)
{
    char path[512], why[200] = "";
    Recorder *r;
    int since;
    const void *bytes;
    size_t size;
    dig_world *w = open_small_scene();
    CHECK_INT(recorder_open(scratch_path(path, sizeof path, "notes.replay"), w, "{}", &r, why, sizeof why), DIG_OK);
    CHECK_INT(recorder_start(r, "start", 5), DIG_OK);
    for (int i = 1; i <= 600; i++) {                    /* several blocks */
        step(w, 1);
        CHECK_INT(recorder_commands(r, &i, sizeof i), DIG_OK);
        CHECK_INT(recorder_step(r), DIG_OK);
        if (i % 100 == 0)
            CHECK_INT(recorder_note(r, i % 200 == 0 ? "even" : "odd", i < 400 ? "{\"before\":400}" : "{}"), DIG_OK);
    }
    CHECK_INT(recorder_commands(r, "last", 4), DIG_OK);
    CHECK_INT(recorder_note(r, "a name that is longer than thirty-one bytes", "{}"), DIG_E_ARG);
    CHECK_INT(recorder_close(r, why, sizeof why), DIG_E_ARG);
    CHECK(strstr(why, "31 bytes") != NULL);
    CHECK_INT(recorder_open(path, w, "{}", &r, why, sizeof why), DIG_OK);
    CHECK_INT(recorder_start(r, "start", 5), DIG_OK);
    for (int i = 1; i <= 600; i++) {
        step(w, 1);
        CHECK_INT(recorder_commands(r, &i, sizeof i), DIG_OK);
        CHECK_INT(recorder_step(r), DIG_OK);
        if (i % 100 == 0)
            CHECK_INT(recorder_note(r, i % 200 == 0 ? "even" : "odd", i < 400 ? "{\"before\":400}" : "{}"), DIG_OK);
    }
    CHECK_INT(recorder_commands(r, "last", 4), DIG_OK);
    CHECK_INT(recorder_close(r, why, sizeof why), DIG_OK);
    Replay *p = open_replay(path);
    CHECK_INT(replay_info(p)->frames, 601);
    CHECK(replay_note(p, "even", 199, NULL) == NULL && replay_note(p, "eve", 600, NULL) == NULL);
    CHECK_TEXT(replay_note(p, "even", 399, &since), "{\"before\":400}");
    CHECK_INT(since, 200);
    CHECK_TEXT(replay_note(p, "even", 600, &since), "{}");
    CHECK_INT(since, 400);                              /* said again at 600: nothing new */
    CHECK_TEXT(replay_note(p, "odd", 300, &since), "{\"before\":400}");
    CHECK_INT(since, 100);
    CHECK(replay_start(p, &bytes, &size) == DIG_OK && size == 5 && memcmp(bytes, "start", 5) == 0);
    for (int i = 600; i >= 1; i--)
        CHECK(replay_commands(p, i, &bytes, &size) == DIG_OK && size == sizeof i && memcmp(bytes, &i, size) == 0);
    CHECK(replay_commands(p, 0, &bytes, &size) == DIG_OK && size == 0);
    CHECK(replay_commands(p, 601, &bytes, &size) == DIG_OK && size == 4 && memcmp(bytes, "last", 4) == 0);
    CHECK_INT(replay_commands(p, 602, &bytes, &size), DIG_E_FORMAT);
    replay_close(p);
    dig_world_close(w);
    remove(path);
}

static ReplayCamera camera_at(real x, bool aims)
{
    return (ReplayCamera){.name = "eye", .has_at = true, .has_look_at = aims, .at = {x, 1, 2}, .look_at = {0, aims ? x : 0, 0}, .fov = 0.5};
}

/* A camera moves with each step and is put back by the script after every tenth; a second one comes with step 300. */
TEST(cameras_belong_to_frames)
{
    char path[512], why[200] = "";
    Recorder *r;
    const ReplayCamera *list;
    int count;
    dig_world *w = open_small_scene();
    CHECK_INT(recorder_open(scratch_path(path, sizeof path, "cameras.replay"), w, "{}", &r, why, sizeof why), DIG_OK);
    for (int i = 0; i <= 600; i++) {
        ReplayCamera now[2] = {camera_at(i, true), camera_at(-i, false)};
        CHECK_INT(recorder_cameras(r, now, i < 300 ? 1 : 2), DIG_OK);
        if (i > 0)
            CHECK_INT(recorder_step(r), DIG_OK);
        now[0] = camera_at(1000 + i, true);
        if (i % 10 == 0)
            CHECK_INT(recorder_cameras(r, now, i < 300 ? 1 : 2), DIG_OK);
        CHECK_INT(recorder_before_step(r), DIG_OK);
        step(w, 1);
    }
    CHECK_INT(recorder_close(r, why, sizeof why), DIG_OK);
    dig_world_close(w);
    Replay *p = open_replay(path);
    for (int i = 600; i > 0; i -= 7)
        for (int arrived = 0; arrived < 2; arrived++) {
            CHECK_INT(replay_cameras(p, i, arrived, &list, &count), DIG_OK);
            CHECK_INT(count, i < 300 ? 1 : 2);
            CHECK(list[0].at.x == (!arrived && i % 10 == 0 ? 1000 + i : i));
            CHECK(list[0].has_look_at && !list[0].has_up && list[0].fov == 0.5);
            CHECK_TEXT(list[0].name, "eye");
            CHECK(i < 300 || (list[1].at.x == -i && !list[1].has_look_at));
        }
    CHECK_INT(replay_cameras(p, 601, false, &list, &count), DIG_E_ARG);
    replay_close(p);
    remove(path);
}

/* What stays costs no byte a frame but the records' marks, and two doubles that change, of the clock. */
TEST(a_camera_that_stands_still_is_written_once)
{
    char path[2][512], why[200] = "";
    size_t size[2];
    for (int k = 0; k < 2; k++) {
        Recorder *r;
        dig_world *w = open_small_scene();
        CHECK_INT(recorder_open(scratch_path(path[k], sizeof path[k], k ? "still.replay" : "none.replay"), w, "{}", &r, why, sizeof why), DIG_OK);
        for (int i = 0; i < 200; i++) {
            ReplayCamera eye = camera_at(3, true);
            CHECK_INT(recorder_cameras(r, &eye, k), DIG_OK);
            CHECK_INT(recorder_before_step(r), DIG_OK);
            step(w, 1);
            CHECK_INT(recorder_cameras(r, &eye, k), DIG_OK);
            CHECK_INT(recorder_step(r), DIG_OK);
        }
        CHECK_INT(recorder_close(r, why, sizeof why), DIG_OK);
        dig_world_close(w);
        Bytes b = read_bytes(path[k]);
        size[k] = b.size;
        free(b.data);
        remove(path[k]);
    }
    CHECK(size[1] > size[0] && size[1] - size[0] < 300);
}

TEST(a_file_that_cannot_be_written_is_named)
{
    char why[200] = "";
    Recorder *r;
    dig_world *w = open_small_scene();
    CHECK_INT(recorder_open("no/such/folder/a.replay", w, "{}", &r, why, sizeof why), DIG_E_FILE);
    CHECK(strstr(why, "no/such/folder/a.replay: the replay cannot be written: No such file or directory") != NULL);
    CHECK(r == NULL);
    if (access("/dev/full", W_OK) == 0) {
        CHECK_INT(recorder_open("/dev/full", w, "{}", &r, why, sizeof why), DIG_E_FILE);
        CHECK(strstr(why, "No space left on device") != NULL);
    }
    dig_world_close(w);
}

/* ---- files that are cut or changed ---- */

/* Everything that can be asked of a file; counts what works. */
static int ask_everything(const char *path, char *why, size_t capacity)
{
    Replay *r;
    View *v;
    const ReplayFrame *f;
    const ReplayCamera *cameras;
    const void *bytes;
    size_t size;
    int good = 0, count;
    if (replay_open(path, &r, why, capacity) != DIG_OK) {
        CHECK(r == NULL && strstr(why, path) == why);
        return -1;
    }
    const ReplayInfo *info = replay_info(r);
    for (int i = 0; i < info->frames && i < 1000; i++) {
        if (replay_frame(r, i, &f) == DIG_OK)
            good++;
        if (replay_view(r, ((real)info->first_step + i + 0.5) * info->step, &v) == DIG_OK)
            dig_view_free(v);
        replay_commands(r, i, &bytes, &size);
    }
    for (int i = 0; replay_body(r, i); i++)
        CHECK(replay_body(r, i)->name && replay_body(r, i)->died >= replay_body(r, i)->born);
    replay_start(r, &bytes, &size);
    replay_note(r, "light", 3, NULL);
    replay_cameras(r, 3, false, &cameras, &count);
    replay_close(r);
    return good;
}

/* Blocks are full at 256 frames. */
static Bytes small_file(char *path, size_t capacity, int frames)
{
    char why[200] = "";
    Recorder *r;
    dig_world *w = open_small_scene();
    CHECK_INT(recorder_open(scratch_path(path, capacity, "small.replay"), w, "{}", &r, why, sizeof why), DIG_OK);
    CHECK_INT(recorder_start(r, "start", 5), DIG_OK);
    for (int i = 1; i < frames; i++) {
        step(w, 1);
        CHECK_INT(recorder_commands(r, &i, sizeof i), DIG_OK);
        CHECK_INT(recorder_note(r, "light", i % 2 ? "[1]" : "[2]"), DIG_OK);
        CHECK_INT(recorder_cameras(r, &(ReplayCamera){.name = "eye", .has_at = true, .at = {i, 1, 2}, .fov = 0.5}, 1), DIG_OK);
        CHECK_INT(recorder_step(r), DIG_OK);
    }
    CHECK_INT(recorder_close(r, why, sizeof why), DIG_OK);
    dig_world_close(w);
    return read_bytes(path);
}

TEST(a_file_cut_at_any_byte_opens_to_its_last_whole_block)
{
    char path[512], why[1400];
    Bytes b = small_file(path, sizeof path, 300);
    int refused = 0, first = 0, whole = 0;
    Replay *r;
    for (size_t n = b.size + 1; n-- > 0;) {                     /* ever shorter */
        CHECK_INT(truncate(path, (off_t)n), 0);
        if (replay_open(path, &r, why, sizeof why) != DIG_OK) {
            CHECK(first > 0 && strstr(why, path) == why);
            refused++;
            continue;
        }
        int frames = replay_info(r)->frames;
        CHECK(refused == 0 && (frames == 256 || frames == 300));
        CHECK(replay_info(r)->cut == (n < b.size));
        first += frames == 256;
        whole += frames == 300;
        CHECK(frames == 256 ? whole > 0 : first == 0);
        replay_close(r);
        if (n % 16 == 0)
            CHECK_INT(ask_everything(path, why, sizeof why), frames);
    }
    CHECK(refused > 64 && first > 64 && whole > 64);
    free(b.data);
    remove(path);
}

TEST(changed_bytes_are_refused_or_harmless)
{
    char path[512], why[1400];
    Bytes b = small_file(path, sizeof path, 60);
    uint64_t seed = 1;
    int refused = 0;
    for (int n = 0; n < 2000; n++) {
        unsigned char *copy = malloc(b.size);
        CHECK(copy != NULL);
        memcpy(copy, b.data, b.size);
        int changes = 1 + n % 4;
        for (int k = 0; k < changes; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            copy[(seed >> 33) % b.size] = (unsigned char)(seed >> 56);
        }
        write_bytes(path, copy, b.size);
        refused += ask_everything(path, why, sizeof why) != 60;
        free(copy);
    }
    CHECK(refused > 1000);                              /* nearly every byte is under a checksum */
    free(b.data);
    remove(path);
}

/* The same with the checksums made good again: what is inside is judged for itself. */
static void put32(unsigned char *to, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        to[i] = (unsigned char)(x >> 8 * i);
}

static uint64_t get64(const unsigned char *from)
{
    uint64_t x = 0;
    for (int i = 0; i < 8; i++)
        x |= (uint64_t)from[i] << 8 * i;
    return x;
}

/* Unpacks every section, so that changes reach the rows; without the index. Returns the new size. */
static size_t unpack_all(const Bytes *b, unsigned char *out)
{
    struct libdeflate_decompressor *d = libdeflate_alloc_decompressor();
    size_t at = 64, to = 64;
    memcpy(out, b->data, 64);
    while (at + 40 <= b->size && memcmp(b->data + at, "INDX", 4) != 0) {
        size_t raw = (size_t)get64(b->data + at + 16), size = (size_t)get64(b->data + at + 24);
        memcpy(out + to, b->data + at, 40);
        if (b->data[at + 4])
            CHECK(libdeflate_deflate_decompress(d, b->data + at + 40, size, out + to + 40, raw, NULL) == LIBDEFLATE_SUCCESS);
        else
            memcpy(out + to + 40, b->data + at + 40, raw);
        put32(out + to + 4, 0);
        put32(out + to + 24, (uint32_t)raw);
        to += 40 + raw;
        at += 40 + size;
    }
    libdeflate_free_decompressor(d);
    return to;
}

static void sign_all(unsigned char *data, size_t size)
{
    put32(data + 60, libdeflate_crc32(0, data, 60));
    for (size_t at = 64; at + 40 <= size;) {
        uint64_t bytes = get64(data + at + 24);
        if (bytes > size - at - 40)
            break;
        put32(data + at + 32, libdeflate_crc32(0, data + at + 40, (size_t)bytes));
        put32(data + at + 36, libdeflate_crc32(0, data + at, 36));
        at += 40 + (size_t)bytes;
    }
}

TEST(wrong_contents_with_right_checksums_do_no_harm)
{
    char path[512], why[1400];
    Bytes b = small_file(path, sizeof path, 20);
    unsigned char *plain = malloc(1 << 22), *copy = malloc(1 << 22);
    CHECK(plain && copy);
    size_t size = unpack_all(&b, plain);
    sign_all(plain, size);
    write_bytes(path, plain, size);
    CHECK_INT(ask_everything(path, why, sizeof why), 20);       /* unchanged it is whole */
    uint64_t seed = 5;
    int refused = 0;
    for (int n = 0; n < 2000; n++) {
        memcpy(copy, plain, size);
        int changes = 1 + n % 3;
        for (int k = 0; k < changes; k++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            size_t where = (seed >> 33) % size;
            unsigned flipped = copy[where] ^ 1u << (seed >> 60) % 8;
            copy[where] = (unsigned char)(n % 2 ? seed >> 56 : flipped);
        }
        sign_all(copy, size);
        write_bytes(path, copy, size);
        refused += ask_everything(path, why, sizeof why) != 20;
    }
    CHECK(refused > 200);
    free(plain);
    free(copy);
    free(b.data);
    remove(path);
}

/* Its arrays lie in pages of their own, not in malloc's (base/block.h). */
TEST(a_view_of_thousands_of_bodies_is_given_back)
{
    enum { COUNT = 12000 };
    dig_world *w = open_world(0.01, NULL, false);
    for (int i = 0; i < COUNT; i++)
        add_ball(w, (Look){0}, 0.5, 1, (vec3){2.0 * (i % 100), 0, 2.0 * (i / 100)}, vec3_zero());
    for (int i = 0; i < 3; i++) {
        View *v = view_of(w);
        CHECK_INT(v->item_count, COUNT);
        dig_view_free(v);
    }
    dig_world_close(w);
}

int main(void)
{
    RUN_TESTS(unit_test(everything_looks_the_same), unit_test(what_a_script_does_between_steps_is_seen),
              unit_test(and_by_one_who_hears_of_it), unit_test(bodies_are_born_and_die),
              unit_test(joints_break_and_bear), unit_test(poses_are_those_of_the_world), unit_test(notes_and_commands_belong_to_frames),
              unit_test(cameras_belong_to_frames), unit_test(a_camera_that_stands_still_is_written_once),
              unit_test(a_file_that_cannot_be_written_is_named), unit_test(a_file_cut_at_any_byte_opens_to_its_last_whole_block),
              unit_test(changed_bytes_are_refused_or_harmless), unit_test(wrong_contents_with_right_checksums_do_no_harm),
              unit_test(a_view_of_thousands_of_bodies_is_given_back));
}
