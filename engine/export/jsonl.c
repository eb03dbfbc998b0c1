/* export/jsonl.c - JSON lines: one object about the run and its bodies, then one for each frame with poses, events and links. */
#include "export/output.h"

#include <inttypes.h>
#include <string.h>

static void put_list(Output *out, const char *name, const real *x, int count)
{
    output_text(out, ",\"%s\":[", name);
    for (int i = 0; i < count; i++) {
        output_bytes(out, ",", i > 0);
        output_number(out, x[i]);
    }
    output_bytes(out, "]", 1);
}

static void put_vec3(Output *out, const char *name, vec3 v)
{
    put_list(out, name, (const real[]){v.x, v.y, v.z}, 3);
}

static void put_number(Output *out, const char *name, real x)
{
    output_text(out, ",\"%s\":", name);
    output_number(out, x);
}

static void put_body(Output *out, const ReplayBody *b, int index)
{
    static const char *const kinds[] = {[DIG_DYNAMIC] = "dynamic", [DIG_KINEMATIC] = "kinematic", [DIG_STATIC] = "static"};
    char buffer[32];
    output_text(out, "%s{\"body\":%d,\"name\":", index ? "," : "", index);
    output_json(out, export_name(b, index, buffer));
    output_text(out, ",\"kind\":\"%s\",\"material\":", kinds[b->kind]);
    output_json(out, b->material ? b->material : "");
    output_text(out, ",\"shape\":");
    output_json(out, b->shape ? b->shape : "");
    put_number(out, "mass", b->mass);
    put_vec3(out, "centre", b->centre);
    output_text(out, ",\"born\":%d,\"died\":%d}", b->born, b->died);
}

static void put_head(Replay *r, Output *out)
{
    const ReplayInfo *info = replay_info(r);
    output_text(out, "{\"digbox\":");
    output_json(out, info->digbox);
    put_number(out, "step", info->step);
    output_text(out, ",\"frames\":%d,\"first_step\":%" PRIu64 ",\"seed\":%" PRIu64 ",\"origin\":", info->frames, info->first_step, info->seed);
    output_bytes(out, info->origin, strlen(info->origin));
    output_text(out, ",\"bodies\":[");
    for (int i = 0; i < info->bodies; i++)
        put_body(out, replay_body(r, i), i);
    output_text(out, "]}\n");
}

static void put_pose(Output *out, const ReplayPose *p, bool first)
{
    output_text(out, "%s{\"body\":%d", first ? "" : ",", p->body);
    put_vec3(out, "position", p->position);
    put_list(out, "rotation", (const real[]){p->rotation.x, p->rotation.y, p->rotation.z, p->rotation.w}, 4);
    put_vec3(out, "velocity", p->velocity);
    put_vec3(out, "spin", p->spin);
    put_vec3(out, "force", p->force);
    output_text(out, ",\"dig\":%u,\"awake\":%s", p->dig, p->awake ? "true" : "false");
    if (p->temperature > 0)
        put_number(out, "temperature", p->temperature);
    output_bytes(out, "}", 1);
}

/* A body by its index; null for none. */
static void put_reference(Output *out, const Replay *r, const char *name, dig_body id)
{
    int index = replay_body_of(r, id);
    if (index >= 0)
        output_text(out, ",\"%s\":%d", name, index);
}

static void put_event(const Replay *r, Output *out, const dig_event *e, bool first)
{
    output_text(out, "%s{\"kind\":\"%s\"", first ? "" : ",", dig_event_name(e->kind));
    put_number(out, "time", e->time);
    put_reference(out, r, "a", e->a);
    put_reference(out, r, "b", e->b);
    switch (e->kind) {
    case DIG_EVENT_MERGED: case DIG_EVENT_SPLIT:
        output_text(out, ",\"dig\":%u,\"other_dig\":%u", e->dig, e->other_dig);
        break;
    case DIG_EVENT_CONTACT_BEGIN: case DIG_EVENT_IMPACT:
        put_number(out, "speed", e->speed);
        put_number(out, "impulse", e->impulse);
        put_vec3(out, "point", e->point);
        put_vec3(out, "normal", e->normal);
        break;
    case DIG_EVENT_BROKEN:
        put_number(out, "stress", e->stress);
        break;
    default:
        break;
    }
    output_bytes(out, "}", 1);
}

static const char *link_name(dig_link_kind kind)
{
    static const char *const names[] = {[DIG_LINK_CONTACT] = "contact", [DIG_LINK_JOINT] = "joint", [DIG_LINK_PORT] = "port", [DIG_LINK_RANGE] = "range"};
    return names[kind];
}

static void put_link(const Replay *r, Output *out, const dig_link *l, bool first)
{
    output_text(out, "%s{\"kind\":\"%s\",\"layer\":\"%s\"", first ? "" : ",", link_name(l->kind), dig_layer_name(l->layer));
    put_reference(out, r, "a", l->a);
    put_reference(out, r, "b", l->b);
    put_number(out, "began", l->began);
    put_vec3(out, "effort", l->effort);
    put_vec3(out, "flow", l->flow);
    put_number(out, "power", l->power);
    put_vec3(out, "point", l->point);
    output_bytes(out, "}", 1);
}

static void put_energy(Output *out, const dig_energy *e)
{
    output_text(out, ",\"energy\":{\"kinetic\":");
    output_number(out, e->kinetic);
    put_number(out, "potential", e->potential);
    put_number(out, "elastic", e->elastic);
    put_number(out, "heat", e->heat);
    put_number(out, "electric", e->electric);
    put_number(out, "work_in", e->work_in);
    put_number(out, "law", e->law);
    put_number(out, "lost", e->lost);
    put_number(out, "numerical", e->numerical);
    put_number(out, "total", e->total);
    output_bytes(out, "}", 1);
}

static void put_frame(const Replay *r, Output *out, const ReplayFrame *f)
{
    output_text(out, "{\"frame\":%d", f->frame);
    put_number(out, "time", f->time);
    output_text(out, ",\"checksum\":\"%016" PRIx64 "\"", f->checksum);
    put_energy(out, &f->energy);
    output_text(out, ",\"bodies\":[");
    for (int i = 0; i < f->pose_count; i++)
        put_pose(out, &f->poses[i], i == 0);
    output_text(out, "],\"events\":[");
    for (int i = 0; i < f->event_count; i++)
        put_event(r, out, &f->events[i], i == 0);
    output_text(out, "],\"links\":[");
    for (int i = 0; i < f->link_count; i++)
        put_link(r, out, &f->links[i], i == 0);
    output_text(out, "]}\n");
}

static dig_status write_jsonl(Replay *r, const ExportOptions *options, Output *out)
{
    put_head(r, out);
    for (int i = export_next_frame(r, options, -1); i >= 0 && output_good(out); i = export_next_frame(r, options, i)) {
        const ReplayFrame *f;
        DIG_TRY(replay_frame(r, i, &f));
        put_frame(r, out, f);
    }
    return DIG_OK;
}

const ExportFormat export_jsonl = {".jsonl", "JSON lines: the bodies, then a line for each frame with poses, events and links", write_jsonl};
