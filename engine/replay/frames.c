/* replay/frames.c - the frames of a replay, and pictures of moments between them. */
#include "replay/inside.h"

#include "math/vec.h"

#include <stdlib.h>

/* ---- records ---- */

static int block_of(const Replay *r, int frame)
{
    int low = 0, high = r->blocks.count;        /* the last block that begins at or before the frame */
    while (high - low > 1) {
        int mid = low + (high - low) / 2;
        if (r->sections.data[r->blocks.data[mid]].first <= (uint32_t)frame)
            low = mid;
        else
            high = mid;
    }
    return r->blocks.data[low];
}

static bool finite_vec(vec3 v) { return isfinite(v.x) && isfinite(v.y) && isfinite(v.z); }

static const char *check_cameras(Kept *k)
{
    for (int i = 0; i < kept_table(k, KEPT_CAMERAS)->count; i++) {
        const KeptCamera *c = &kept_cameras(k)[i];
        if (c->name[sizeof c->name - 1] != '\0' || !finite_vec(c->at) || !finite_vec(c->look_at) || !finite_vec(c->up) || !(c->fov > 0 && c->fov < DIG_PI))
            return "a camera stands nowhere";
    }
    return NULL;
}

/* The meshes are those of the replay; tables are put there and taken away again. */
static const char *check_tables(Replay *r)
{
    Kept *k = &r->now;
    int edges = look_count(&k->look, LOOK_EDGES);
    if (kept_table(k, KEPT_FLOWS)->count != edges || kept_table(k, KEPT_STATE)->count != 1)
        return "tables do not fit each other";
    for (int i = 0; i < kept_table(k, KEPT_EVENTS)->count; i++) {
        const KeptEvent *e = &kept_events(k)[i];
        if (e->kind >= DIG_EVENT_KINDS || e->link >= DIG_LINK_KINDS || e->layer >= DIG_LAYERS || e->wall > 6 || !isfinite(e->time))
            return "an event is of no kind";
    }
    for (int i = 0; i < edges; i++)
        for (int c = 0; c < 3; c++)
            if (!isfinite(kept_flows(k)[i].effort[c]) || !isfinite(kept_flows(k)[i].flow[c]) || !isfinite(kept_flows(k)[i].point[c]))
                return "a link has numbers that are not finite";
    for (int i = 0; i < look_count(&k->look, LOOK_BODIES); i++)
        if (look_bodies(&k->look)[i].there && look_bodies(&k->look)[i].index >= (uint32_t)r->bodies.count)
            return "a body has no number";
    const char *why = check_cameras(k);
    return why ? why : look_check(&k->look, r->meshes.count);
}

static dig_status damaged(Replay *r, int frame, const char *why)
{
    r->block_frame = -1;
    return replay_fail(r, DIG_E_FORMAT, "frame %d: %s", frame, why);
}

static dig_status read_record(Replay *r)
{
    uint8_t kind = 0;
    const Section *s = &r->sections.data[r->block.section];
    int frame = r->block_frame < 0 ? (int)s->first : r->block_frame;
    pack_small(&r->cursor, &kind, RECORD_KINDS, "kind of a record");
    delta_read(&r->cursor, &r->now);
    if (!pack_good(&r->cursor))
        return r->cursor.no_memory ? replay_fail(r, DIG_E_MEMORY, "not enough memory") : damaged(r, frame, r->cursor.why);
    if (kind == RECORD_LEFT && r->block_frame < 0)
        return damaged(r, frame, "a block begins in the middle of a frame");
    if (kind == RECORD_FRAME && r->block_frame >= 0)
        frame++;
    if ((uint32_t)frame >= s->first + s->count)
        return damaged(r, frame, "a block has more frames than it says");
    r->block_frame = frame;
    r->left = kind == RECORD_LEFT;
    return DIG_OK;
}

/* Is the next record about the same frame? */
static bool more_of_frame(const Replay *r) { return r->cursor.at < r->cursor.size && r->cursor.from[r->cursor.at] == RECORD_LEFT; }

dig_status replay_go(Replay *r, int frame, bool left)
{
    if (frame < 0 || frame >= r->info.frames)
        return replay_fail(r, DIG_E_ARG, "frame %d: there are 0 to %d", frame, r->info.frames - 1);
    int section = block_of(r, frame);
    bool past = r->block_frame > frame || (r->block_frame == frame && r->left && !left);
    if (r->block.section != section || r->block_frame < 0 || past) {
        DIG_TRY(replay_load(r, section, &r->block));
        r->cursor = pack_reader(r->block.data, r->block.size);
        r->block_frame = -1;
        kept_clear(&r->now);
    }
    while (r->block_frame < frame || (left && more_of_frame(r))) {
        if (r->cursor.at >= r->cursor.size)
            return damaged(r, frame, "a block has fewer frames than it says");
        DIG_TRY(read_record(r));
    }
    const char *why = check_tables(r);
    return why ? damaged(r, frame, why) : DIG_OK;
}

/* ---- frames ---- */

static int by_body(const void *a, const void *b)
{
    const ReplayPose *x = a, *y = b;
    return x->body < y->body ? -1 : x->body > y->body;
}

static vec3 read_vec(const float v[3]) { return (vec3){(real)v[0], (real)v[1], (real)v[2]}; }

static void fill_pose(const LookBody *b, const LookPose *p, ReplayPose *out)
{
    *out = (ReplayPose){.body = (int)b->index, .position = vec3_sub(p->x, quat_rotate(p->q, b->centre)), .rotation = p->q, .velocity = read_vec(p->v),
                        .spin = read_vec(p->w), .force = read_vec(p->force), .dig = p->dig, .temperature = p->temperature,
                        .awake = b->kind == DIG_DYNAMIC ? p->awake != 0 : b->kind == DIG_KINEMATIC,
                        .mode = b->kind == DIG_STATIC ? DIG_FIXED : (dig_mode)p->mode};
}

static dig_status fill_poses(Replay *r)
{
    const Look *l = &r->now.look;
    int n = 0;
    DIG_TRY(list_reserve(&r->poses, look_count(l, LOOK_BODIES), NULL));
    for (int i = 0; i < look_count(l, LOOK_BODIES); i++)
        if (look_bodies(l)[i].there)
            fill_pose(&look_bodies(l)[i], &look_poses(l)[i], &r->poses.data[n++]);
    r->poses.count = n;
    if (n > 1)
        qsort(r->poses.data, (size_t)n, sizeof *r->poses.data, by_body);
    r->frame.poses = r->poses.data;
    r->frame.pose_count = n;
    return DIG_OK;
}

static dig_status fill_events(Replay *r)
{
    int count = kept_table(&r->now, KEPT_EVENTS)->count;
    DIG_TRY(list_reserve(&r->events, count, NULL));
    for (int i = 0; i < count; i++) {
        const KeptEvent *k = &kept_events(&r->now)[i];
        r->events.data[i] = (dig_event){.kind = (dig_event_kind)k->kind, .time = k->time, .a = {k->a[0], k->a[1]}, .b = {k->b[0], k->b[1]},
                                        .joint = {k->joint[0], k->joint[1]}, .dig = k->dig, .other_dig = k->other_dig, .wall = (int)k->wall,
                                        .speed = k->speed, .impulse = k->impulse, .stress = k->stress, .point = k->point, .normal = k->normal,
                                        .link = (dig_link_kind)k->link, .layer = k->layer, .message = k->message,
                                        .region = {k->region[0], k->region[1]}};
    }
    r->events.count = count;
    r->frame.events = r->events.data;
    r->frame.event_count = count;
    return DIG_OK;
}

static dig_body id_of(const Look *l, uint32_t slot)
{
    return slot < (uint32_t)look_count(l, LOOK_BODIES) ? (dig_body){slot, look_bodies(l)[slot].gen} : (dig_body){0, 0};
}

static dig_status fill_links(Replay *r)
{
    const Look *l = &r->now.look;
    int count = look_count(l, LOOK_EDGES);
    vec3 origin = look_origin(look_scene(l));
    DIG_TRY(list_reserve(&r->links, count, NULL));
    for (int i = 0; i < count; i++) {
        const LookEdge *e = &look_edges(l)[i];
        const KeptFlow *f = &kept_flows(&r->now)[i];
        dig_link *out = &r->links.data[i];
        *out = (dig_link){.a = id_of(l, e->a), .b = id_of(l, e->b), .kind = (dig_link_kind)e->kind, .effort = read_vec(f->effort),
                          .flow = read_vec(f->flow), .began = f->began, .point = vec3_add(read_vec(f->point), origin),
                          .normal = read_vec(f->normal), .bound = e->bound != 0, .layer = e->layer};
        if (f->joint != LOOK_NONE)
            out->joint = (dig_joint){f->joint, f->joint_gen};
        out->power = vec3_dot(out->effort, out->flow);
    }
    r->links.count = count;
    r->frame.links = r->links.data;
    r->frame.link_count = count;
    return DIG_OK;
}

static int count_struts(const Look *l)
{
    int count = 0;
    for (int i = 0; i < look_count(l, LOOK_JOINTS); i++)
        count += look_joints(l)[i].there && look_joints(l)[i].radius > 0;
    return count;
}

dig_status replay_frame(Replay *r, int frame, const ReplayFrame **out)
{
    *out = NULL;
    DIG_TRY(replay_go(r, frame, true));
    const KeptState *state = kept_state(&r->now);
    r->frame = (ReplayFrame){.frame = frame, .time = look_scene(&r->now.look)->time, .checksum = state->checksum, .energy = state->energy,
                             .struts = count_struts(&r->now.look)};
    if (fill_poses(r) != DIG_OK || fill_events(r) != DIG_OK || fill_links(r) != DIG_OK)
        return replay_fail(r, DIG_E_MEMORY, "not enough memory");
    *out = &r->frame;
    return DIG_OK;
}

/* ---- pictures ---- */

/* The picture of tables, which borrow the meshes meanwhile. */
static dig_status draw(Replay *r, Kept *k, View **out)
{
    k->look.meshes.data = r->meshes.data;
    k->look.meshes.count = r->meshes.count;
    dig_status s = look_view(&k->look, out);
    k->look.meshes.data = NULL;
    k->look.meshes.count = 0;
    if (s != DIG_OK)
        return replay_fail(r, s, "not enough memory for a picture");
    (*out)->seed = r->info.seed;
    return DIG_OK;
}

/* The tables of a frame as it was left, beside those that reading goes on with. */
static dig_status keep_before(Replay *r, int frame)
{
    if (r->before_frame == frame)
        return DIG_OK;
    DIG_TRY(replay_go(r, frame, true));
    r->before_frame = -1;
    if (kept_copy(&r->before, &r->now) != DIG_OK)
        return replay_fail(r, DIG_E_MEMORY, "not enough memory");
    r->before_frame = frame;
    return DIG_OK;
}

static dig_status blend(Replay *r, int frame, real time, View **out)
{
    View *a = NULL;
    DIG_TRY(keep_before(r, frame));
    DIG_TRY(replay_go(r, frame + 1, false));
    DIG_TRY(draw(r, &r->before, &a));
    dig_status s = draw(r, &r->now, out);
    if (s == DIG_OK) {
        View *b = *out;
        real f = (time - (b->time - r->info.step)) / r->info.step;
        ViewPose *from = view_poses(a), *to = view_poses(b);
        if (from && to) {
            view_blend(a, from, b, to, f);
            b->time = a->time + f * (b->time - a->time);
        } else {
            s = replay_fail(r, DIG_E_MEMORY, "not enough memory for a picture");
            dig_view_free(b);
            *out = NULL;
        }
        free(from);
        free(to);
    }
    dig_view_free(a);
    return s;
}

dig_status replay_view(Replay *r, real time, View **out)
{
    const real on_time = 1e-9;          /* s; nearer than this a moment falls on a step, as for films */
    *out = NULL;
    if (!isfinite(time))
        return replay_fail(r, DIG_E_ARG, "time = %g s, must be finite", time);
    real n = time / r->info.step - (real)r->info.first_step, last = (real)(r->info.frames - 1);
    int frame = n <= 0 ? 0 : n >= last ? r->info.frames - 1 : (int)n;
    for (int k = frame > 0 ? frame - 1 : 0; k <= frame + 1 && k < r->info.frames; k++)      /* n is rounded: look beside it */
        if (fabs((real)(r->info.first_step + (uint64_t)k) * r->info.step - time) <= on_time) {
            DIG_TRY(replay_go(r, k, true));
            return draw(r, &r->now, out);
        }
    if (n <= 0 || n >= last) {
        DIG_TRY(replay_go(r, frame, true));
        return draw(r, &r->now, out);
    }
    if ((real)(r->info.first_step + (uint64_t)frame) * r->info.step > time)
        frame--;
    return blend(r, frame, time, out);
}

/* ---- cameras ---- */

dig_status replay_cameras(Replay *r, int frame, bool arrived, const ReplayCamera **out, int *count)
{
    Kept *k = !arrived && r->before_frame == frame && frame >= 0 ? &r->before : &r->now;        /* that of a picture made before */
    if (k == &r->now)
        DIG_TRY(replay_go(r, frame, !arrived));
    *count = kept_table(k, KEPT_CAMERAS)->count;
    if (list_reserve(&r->cameras, *count, NULL) != DIG_OK)
        return replay_fail(r, DIG_E_MEMORY, "not enough memory");
    for (int i = 0; i < *count; i++) {
        const KeptCamera *c = &kept_cameras(k)[i];
        ReplayCamera *to = &r->cameras.data[i];
        *to = (ReplayCamera){.has_at = c->says & CAMERA_AT, .has_look_at = c->says & CAMERA_LOOK_AT, .has_up = c->says & CAMERA_UP,
                             .at = c->at, .look_at = c->look_at, .up = c->up, .fov = c->fov};
        memcpy(to->name, c->name, sizeof to->name);
    }
    *out = r->cameras.data;
    return DIG_OK;
}

/* ---- the log of commands ---- */

dig_status replay_start(Replay *r, const void **bytes, size_t *size)
{
    for (int i = 0; i < r->sections.count; i++)
        if (memcmp(r->sections.data[i].tag, "STRT", 4) == 0) {
            DIG_TRY(replay_load(r, i, &r->start));
            *bytes = r->start.data;
            *size = r->start.size;
            return DIG_OK;
        }
    return replay_fail(r, DIG_E_FORMAT, "it holds no log of commands, so that it cannot be simulated again");
}

dig_status replay_commands(Replay *r, int frame, const void **bytes, size_t *size)
{
    for (int i = 0; i < r->sections.count; i++) {
        const Section *s = &r->sections.data[i];
        if (memcmp(s->tag, "CMDS", 4) != 0 || frame < 0 || (uint32_t)frame < s->first || (uint32_t)frame - s->first > s->count)
            continue;
        DIG_TRY(replay_load(r, i, &r->commands));
        Pack p = pack_reader(r->commands.data, r->commands.size);
        for (uint32_t k = s->first; p.at < p.size; k++) {
            uint32_t length = 0;
            pack_u32(&p, &length);
            const unsigned char *from = pack_take(&p, length);
            if (from && k == (uint32_t)frame) {
                *bytes = from;
                *size = length;
                return DIG_OK;
            }
            if (!pack_good(&p))
                return replay_fail(r, DIG_E_FORMAT, "section CMDS: %s", p.why);
        }
    }
    return replay_fail(r, DIG_E_FORMAT, "frame %d: its commands cannot be read", frame);
}
