/* export/html_scene.c - cameras and light of a page: where the script's cameras stand at each frame, and how the scene is lit. */
#include "export/html_data.h"

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static dig_status take_cameras(HtmlData *d, int frame)
{
    HtmlMoment *m = &d->moments[MOMENT_CAMERA];
    const ReplayCamera *list;
    int count, before = m->rows.count;
    DIG_TRY(replay_cameras(d->r, frame, false, &list, &count));
    for (int i = 0; i < count; i++) {
        const ReplayCamera *c = &list[i];
        float row[11] = {(float)((c->has_at ? 1 : 0) + (c->has_look_at ? 2 : 0) + (c->has_up ? 4 : 0))};
        write_vec(row + 1, vec3_sub(c->at, d->place));
        write_vec(row + 4, vec3_sub(c->look_at, d->place));
        write_vec(row + 7, c->up);
        row[10] = (float)c->fov;
        DIG_TRY(html_put(&m->rows, row, 11));
    }
    return html_end_moment(d, MOMENT_CAMERA, before);
}

/* ---- light ---- */

static bool same_light(const ExportLight *a, const ExportLight *b)
{
    bool same = a->shadows == b->shadows && a->sky == b->sky && a->lamp_count == b->lamp_count && vec3_distance(a->sun, b->sun) <= 0;
    for (int i = 0; same && i < a->lamp_count; i++)
        same = a->lamps[i].power >= b->lamps[i].power && a->lamps[i].power <= b->lamps[i].power &&
               vec3_distance(a->lamps[i].at, b->lamps[i].at) <= 0 && vec3_distance(a->lamps[i].colour, b->lamps[i].colour) <= 0;
    return same;
}

static void put_vec(Output *out, const char *name, vec3 v)
{
    output_text(out, "\"%s\":[%.9g,%.9g,%.9g]", name, v.x, v.y, v.z);
}

static void put_light(HtmlData *d, const ExportLight *l)
{
    Output *out = &d->lights;
    output_text(out, "%s{\"frame\":%d,\"sky\":\"%s\",\"shadows\":%s,", out->size ? "," : "", d->frames, l->sky, l->shadows ? "true" : "false");
    put_vec(out, "sun", l->sun);
    output_text(out, ",\"lamps\":[");
    for (int i = 0; i < l->lamp_count; i++) {
        output_text(out, "%s{\"power\":%.9g,", i ? "," : "", l->lamps[i].power);
        put_vec(out, "at", vec3_sub(l->lamps[i].at, d->place));
        output_text(out, ",");
        put_vec(out, "colour", l->lamps[i].colour);
        output_text(out, "}");
    }
    output_text(out, "]}");
}

dig_status html_take_scene(HtmlData *d, const ReplayFrame *f)
{
    ExportLight light;
    int frame = f->frame;
    if (export_light(d->r, frame, &light) && (d->lights.size == 0 || !same_light(&light, &d->light))) {
        put_light(d, &light);
        d->light = light;
    }
    return take_cameras(d, frame);
}

/* Names of the cameras at the end: those that came later stand behind those before. */
void html_put_cameras(HtmlData *d, Output *out)
{
    const ReplayCamera *list;
    int count = 0, last = d->numbers.count > 0 ? d->numbers.data[d->numbers.count - 1] : 0;
    if (replay_cameras(d->r, last, false, &list, &count) != DIG_OK)
        count = 0;
    output_text(out, "\"cameras\":[");
    for (int i = 0; i < count; i++) {
        output_text(out, i ? "," : "");
        html_put_text(out, list[i].name);
    }
    output_text(out, "],\n");
}
