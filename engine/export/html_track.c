/* export/html_track.c - bodies, links and events of a page, frame by frame; what stays the same is kept once. */
#include "export/html_data.h"

#include <limits.h>

enum { EVENTS_MOST = 20000 };       /* of frequent kinds: what a list in a browser bears; the others are counted */

dig_status html_put_any(void **data, int *count, int *capacity, size_t item, const void *from, int n)
{
    if (*count > INT_MAX / 2 - n)
        return DIG_E_FULL;
    if (*count + n > *capacity)
        DIG_TRY(list_reserve_any(data, capacity, item, int_max(*count + n, 2 * *capacity), NULL));
    if (n > 0)
        memcpy((char *)*data + (size_t)*count * item, from, (size_t)n * item);
    *count += n;
    return DIG_OK;
}

static void put_vec(float *out, vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static HtmlKey key_of(const HtmlData *d, const ReplayPose *p)
{
    HtmlKey k = {.dig = p->dig, .flags = (p->awake ? 1u : 0u) + 2u * (uint32_t)p->mode, .temperature = (float)p->temperature};
    put_vec(k.pose, vec3_sub(p->position, d->place));
    const float q[4] = {(float)p->rotation.x, (float)p->rotation.y, (float)p->rotation.z, (float)p->rotation.w};
    memcpy(k.pose + 3, q, sizeof q);
    put_vec(k.motion, p->velocity);
    put_vec(k.motion + 3, p->spin);
    put_vec(k.motion + 6, p->force);
    return k;
}

static dig_status take_pose(HtmlData *d, const ReplayPose *p)
{
    HtmlBody *b = &d->bodies.data[p->body];
    HtmlTimedKey now = {(uint32_t)d->frames, key_of(d, p)};
    if (p->temperature > 0) {
        d->coldest = real_min(d->coldest, p->temperature);
        d->hottest = real_max(d->hottest, p->temperature);
    }
    if (b->keys.count > 0 && memcmp(&b->keys.data[b->keys.count - 1].key, &now.key, sizeof now.key) == 0)
        return DIG_OK;
    return html_put(&b->keys, &now, 1);
}

/* Which pose belongs to a slot: pictures name bodies by their slots. */
static dig_status index_poses(HtmlData *d, const ReplayFrame *f)
{
    const int none = -1;
    for (int i = 0; i < d->row_of.count; i++)
        d->row_of.data[i] = none;
    for (int i = 0; i < f->pose_count; i++) {
        uint32_t slot = replay_body(d->r, f->poses[i].body)->id.slot;
        if (slot > INT_MAX / 8)
            return DIG_E_FULL;
        while (d->row_of.count <= (int)slot)
            DIG_TRY(html_put(&d->row_of, &none, 1));
        d->row_of.data[slot] = i;
    }
    return DIG_OK;
}

dig_status html_take_poses(HtmlData *d, const ReplayFrame *f)
{
    const dig_energy *e = &f->energy;
    const real energy[10] = {e->kinetic, e->potential, e->elastic, e->heat, e->electric, e->work_in, e->law, e->lost, e->numerical, e->total};
    DIG_TRY(html_put(&d->times, &f->time, 1));
    DIG_TRY(html_put(&d->energy, energy, 10));
    DIG_TRY(index_poses(d, f));
    for (int i = 0; i < f->pose_count; i++)
        DIG_TRY(take_pose(d, &f->poses[i]));
    return DIG_OK;
}

/* ---- links ---- */

static dig_status open_span(HtmlData *d, const dig_link *l, uint32_t a, uint32_t b, MapKey key)
{
    HtmlSpan span = {.a = a, .b = b, .kind = (uint32_t)l->kind, .layer = l->layer, .bound = l->bound, .first = (uint32_t)d->frames};
    DIG_TRY(html_put(&d->spans, &span, 1));
    return map_put(&d->holding, key, (uint32_t)d->spans.count - 1);
}

/* Of other layers than the mechanical one the effort is a number, which stands in x. */
static dig_status take_link(HtmlData *d, const dig_link *l)
{
    int a = replay_body_of(d->r, l->a), b = replay_body_of(d->r, l->b);
    if (a < 0 || b < 0)
        return DIG_OK;
    MapKey key = {(uint32_t)a, (uint32_t)b, ((l->joint.slot + 1) << 8) + (l->layer << 4) + (uint32_t)l->kind};
    uint32_t at = 0, frame = (uint32_t)d->frames;
    bool found = map_find(&d->holding, key, &at);
    uint32_t end = found ? d->spans.data[at].first + (uint32_t)d->spans.data[at].efforts.count : 0;
    if (found && end == frame + 1)
        return DIG_OK;
    if (!found || end != frame) {
        DIG_TRY(open_span(d, l, (uint32_t)a, (uint32_t)b, key));
        at = (uint32_t)d->spans.count - 1;
    }
    HtmlSpan *span = &d->spans.data[at];
    float effort = (float)vec3_length(l->effort), point[3];
    put_vec(point, vec3_sub(l->point, d->place));
    DIG_TRY(html_put(&span->efforts, &effort, 1));
    return span->bound ? html_put(&span->ends, point, 3) : DIG_OK;
}

dig_status html_take_links(HtmlData *d, const ReplayFrame *f)
{
    for (int i = 0; i < f->link_count; i++)
        DIG_TRY(take_link(d, &f->links[i]));
    return DIG_OK;
}

/* ---- events ---- */

/* What there are thousands of in a pile. */
static bool is_frequent(dig_event_kind k)
{
    return k == DIG_EVENT_CONTACT_BEGIN || k == DIG_EVENT_CONTACT_END || k == DIG_EVENT_IMPACT || k == DIG_EVENT_LINK || k == DIG_EVENT_UNLINK;
}

/* Of the frequent kinds each frame gives as many as keep the list readable to its end; the others are all there. */
dig_status html_take_events(HtmlData *d, const ReplayFrame *f, int frame)
{
    int left = int_max(8, EVENTS_MOST / replay_info(d->r)->frames);
    for (int i = 0; i < f->event_count; i++) {
        HtmlEvent e = {.frame = frame, .event = f->events[i]};
        if (is_frequent(e.event.kind) && left-- <= 0) {
            d->events_left_out++;
            continue;
        }
        e.a = replay_body_of(d->r, e.event.a);
        e.b = replay_body_of(d->r, e.event.b);
        DIG_TRY(html_put(&d->events, &e, 1));
    }
    return DIG_OK;
}

void html_data_close(HtmlData *d)
{
    for (int i = 0; i < d->bodies.count; i++)
        list_close(&d->bodies.data[i].keys);
    for (int i = 0; i < d->spans.count; i++) {
        list_close(&d->spans.data[i].efforts);
        list_close(&d->spans.data[i].ends);
    }
    for (int i = 0; i < MOMENTS; i++) {
        list_close(&d->moments[i].at);
        list_close(&d->moments[i].rows);
    }
    list_close(&d->numbers);
    list_close(&d->times);
    list_close(&d->energy);
    list_close(&d->bodies);
    list_close(&d->spans);
    list_close(&d->meshes);
    list_close(&d->vertices);
    list_close(&d->normals);
    list_close(&d->indices);
    list_close(&d->shapes);
    list_close(&d->events);
    list_close(&d->row_of);
    map_close(&d->holding);
    output_close(&d->lights);
}
