/* tests/unit/test_replay.c - a run that is kept and read again: the same pictures, the same numbers, whatever happens to the file. */
#include "save_fixture.h"

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

static void record(dig_world *w, const char *path, int frames, Meddle *meddle, Seen *s)
{
    char why[1400] = "";
    Recorder *r;
    if (recorder_open(path, w, "{\"script\":\"a test\"}", &r, why, sizeof why) != DIG_OK)
        fail_msg("%s", why);
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

int main(void)
{
    RUN_TESTS(unit_test(everything_looks_the_same));
}
