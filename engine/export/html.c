/* export/html.c - writes a replay into the page's shell: the JSON header, the sections (html_data.h) in base64, and the rest of the shell. */
#include "export/html_data.h"

static const char place_mark[] = "<!--DIGBOX-DATA-->";

/* ---- gathering ---- */

static dig_status take_frame(HtmlData *d, const ReplayFrame *f)
{
    View *v = NULL;
    DIG_TRY(replay_view(d->r, f->time, &v));
    if (d->frames == 0)
        d->place = (vec3){v->origin[0], v->origin[1], v->origin[2]};
    dig_status s = html_take_poses(d, f);
    if (s == DIG_OK)
        s = html_take_links(d, f);
    if (s == DIG_OK)
        s = html_take_view(d, f, v);
    if (s == DIG_OK)
        s = html_take_scene(d, f);
    if (s == DIG_OK)
        s = html_put(&d->numbers, &f->frame, 1);
    dig_view_free(v);
    d->frames += s == DIG_OK;
    return s;
}

/* Frames that are not shown hand their events on to the next one that is. */
static dig_status gather(HtmlData *d, const ExportOptions *o)
{
    const HtmlBody none = {0};
    for (int i = 0; i < replay_info(d->r)->bodies; i++)
        DIG_TRY(html_put(&d->bodies, &none, 1));
    int next = export_next_frame(d->r, o, -1), last = next;
    for (int i = next; i >= 0; i = export_next_frame(d->r, o, i))
        last = i;
    for (int i = next; i >= 0 && i <= last; i++) {
        const ReplayFrame *f;
        DIG_TRY(replay_frame(d->r, i, &f));
        DIG_TRY(html_take_events(d, f, d->frames));
        if (i == next) {
            DIG_TRY(take_frame(d, f));
            next = export_next_frame(d->r, o, i);
        }
    }
    return DIG_OK;
}

/* ---- the header: JSON in a script element, where no < may stand ---- */

void html_put_text(Output *out, const char *text)
{
    Output json = {0};
    output_json(&json, text ? text : "");
    for (size_t i = 0; i < json.size; i++)
        if (json.data[i] == '<')
            output_text(out, "\\u003c");
        else
            output_bytes(out, json.data + i, 1);
    if (!output_good(&json))
        output_fail(out, "%s", json.why);
    output_close(&json);
}

static void put_number(Output *out, const char *name, real x)
{
    output_text(out, "\"%s\":", name);
    output_number(out, x);
    output_text(out, ",");
}

static void put_floats(Output *out, const char *name, const float *x, int n)
{
    output_text(out, "\"%s\":[", name);
    for (int i = 0; i < n; i++)
        output_text(out, isfinite(x[i]) ? "%s%.9g" : "%s0", i ? "," : "", (double)x[i]);
    output_text(out, "],");
}

static void put_names(Output *out, const char *name, const char *(*text)(int), int n)
{
    output_text(out, "\"%s\":[", name);
    for (int i = 0; i < n; i++)
        output_text(out, "%s\"%s\"", i ? "," : "", text(i));
    output_text(out, "],");
}

static const char *mode_name(int i) { return (const char *const[]){"moving", "resting", "fixed"}[i]; }
static const char *link_name(int i) { return (const char *const[]){"contact", "joint", "port", "range"}[i]; }
static const char *layer_name(int i) { return dig_layer_name((uint32_t)i); }
static const char *event_name(int i) { return dig_event_name((dig_event_kind)i); }
static const char *form_name(ViewForm f) { return (const char *const[]){"mesh", "sphere", "box", "capsule", "cylinder", "cone", "plane"}[f]; }
static const char *pattern_name(int p) { return p >= 0 && p < 6 ? (const char *const[]){"plain", "wood", "brick", "tile", "stripe", "check"}[p] : "plain"; }

static void put_bodies(const HtmlData *d, Output *out)
{
    static const char *const kinds[] = {[DIG_DYNAMIC] = "dynamic", [DIG_STATIC] = "static", [DIG_KINEMATIC] = "kinematic"};
    int first = 0;
    output_text(out, "\"bodies\":[");
    for (int i = 0; i < d->bodies.count; i++) {
        const ReplayBody *b = replay_body(d->r, i);
        const HtmlBody *own = &d->bodies.data[i];
        /* born and died are frames of the replay: those of the page that are not before them */
        int born = 0, died = 0;
        while (born < d->frames && d->numbers.data[born] < b->born)
            born++;
        for (died = born; died < d->frames && d->numbers.data[died] < b->died; died++) {
        }
        const float centre[3] = {(float)b->centre.x, (float)b->centre.y, (float)b->centre.z};
        output_text(out, "%s{\"name\":", i ? ",\n" : "");
        html_put_text(out, b->name);
        output_text(out, ",\"material\":");
        html_put_text(out, b->material);
        output_text(out, ",\"shape\":");
        html_put_text(out, b->shape);
        output_text(out, ",\"kind\":\"%s\",", kinds[b->kind]);
        put_number(out, "mass", b->mass);
        put_floats(out, "centre", centre, 3);
        output_text(out, "\"born\":%d,\"died\":%d,\"keys\":[%d,%d]}", born, died, first, own->keys.count);
        first += own->keys.count;
    }
    output_text(out, "],\n");
}

static void put_shapes(const HtmlData *d, Output *out)
{
    output_text(out, "\"meshes\":[");
    for (int i = 0; i < d->meshes.count; i++) {
        const HtmlMesh *m = &d->meshes.data[i];
        output_text(out, "%s{\"form\":\"%s\",", i ? ",\n" : "", form_name(m->form));
        put_floats(out, "size", m->size, 3);
        output_text(out, "\"vertices\":[%d,%d],\"indices\":[%d,%d],\"normals\":", m->vertex, m->vertex_count, m->index, m->index_count);
        if (m->normal_count)
            output_text(out, "[%d,%d]}", m->vertex, m->normal_count);
        else
            output_text(out, "null}");
    }
    output_text(out, "],\n\"shapes\":[");
    for (int i = 0; i < d->shapes.count; i++) {
        const HtmlShape *s = &d->shapes.data[i];
        output_text(out, "%s{\"body\":%d,\"mesh\":%d,", i ? ",\n" : "", s->body, s->mesh);
        put_floats(out, "p", s->p, 3);
        put_floats(out, "q", s->q, 4);
        put_floats(out, "colour", s->colour, 3);
        put_number(out, "roughness", (real)s->roughness);
        put_number(out, "metallic", (real)s->metallic);
        put_number(out, "opacity", (real)s->opacity);
        output_text(out, "\"pattern\":\"%s\"}", pattern_name(s->pattern));
    }
    output_text(out, "],\n");
}

static void put_events(const HtmlData *d, Output *out)
{
    output_text(out, "\"events\":[");
    for (int i = 0; i < d->events.count; i++) {
        const HtmlEvent *h = &d->events.data[i];
        const dig_event *e = &h->event;
        output_text(out, "%s[%d,", i ? ",\n" : "", h->frame);
        output_number(out, e->time);
        output_text(out, ",%d,%d,%d,%.6g,%.6g,%u,%u,%d,%u,%.4g]", (int)e->kind, h->a, h->b, isfinite(e->speed) ? e->speed : 0,
                    isfinite(e->impulse) ? e->impulse : 0, e->dig, e->other_dig, (int)e->link, e->layer, isfinite(e->stress) ? e->stress : 0);
    }
    output_text(out, "],\n\"events_left_out\":%d,\n", d->events_left_out);
}

/* The scale of temperatures ends at multiples of 50 K, as in pictures. */
static void put_heat(const HtmlData *d, Output *out)
{
    real low = 50 * floor(d->coldest / 50), high = 50 * ceil(d->hottest / 50);
    if (d->coldest > d->hottest)
        output_text(out, "\"heat\":null,");
    else
        output_text(out, "\"heat\":[%g,%g],", low, high > low ? high : low + 50);
}

static void put_header(HtmlData *d, const ExportShell *shell, Output *out)
{
    const ReplayInfo *info = replay_info(d->r);
    const float place[3] = {(float)d->place.x, (float)d->place.y, (float)d->place.z};
    output_text(out, "{\"format\":1,\"title\":");
    html_put_text(out, shell->title);
    output_text(out, ",\"digbox\":");
    html_put_text(out, info->digbox);
    output_text(out, ",\"origin\":");
    html_put_text(out, info->origin);
    output_text(out, ",\"seed\":%llu,\"frames\":%d,\"cut\":%s,", (unsigned long long)info->seed, d->frames, info->cut ? "true" : "false");
    put_number(out, "step", info->step);
    put_floats(out, "place", place, 3);
    put_floats(out, "up", d->up, 3);
    put_floats(out, "low", d->low, 3);
    put_floats(out, "high", d->high, 3);
    html_put_cameras(d, out);
    output_text(out, "\"lights\":[");
    output_bytes(out, d->lights.data, d->lights.size);
    output_text(out, "],\n");
    put_heat(d, out);
    put_names(out, "link_kinds", link_name, DIG_LINK_KINDS);
    put_names(out, "layers", layer_name, DIG_LAYERS);
    put_names(out, "modes", mode_name, 3);
    put_names(out, "event_kinds", event_name, DIG_EVENT_KINDS);
    put_bodies(d, out);
    put_shapes(d, out);
    put_events(d, out);
}

/* ---- sections ---- */

typedef struct Sections {
    Output bytes, list;         /* the block, and its table of contents as JSON */
} Sections;

static void put_little(Output *out, uint64_t x, int size)
{
    unsigned char b[8];
    for (int i = 0; i < size; i++)
        b[i] = (unsigned char)(x >> (8 * i));
    output_bytes(out, b, (size_t)size);
}

/* Sections begin at multiples of 8 bytes. */
static void begin_section(Sections *s, const char *name, const char *type, size_t count)
{
    while (s->bytes.size % 8)
        output_bytes(&s->bytes, "", 1);
    output_text(&s->list, "%s\"%s\":[\"%s\",%zu,%zu]", s->list.size ? "," : "", name, type, s->bytes.size, count);
}

static void put_f32(Output *out, const float *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, x + i, sizeof bits);
        put_little(out, bits, 4);
    }
}

static void put_u32(Output *out, const uint32_t *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        put_little(out, x[i], 4);
}

static void section_f64(Sections *s, const char *name, const real *x, int n)
{
    begin_section(s, name, "f64", (size_t)n);
    for (int i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, x + i, sizeof bits);
        put_little(&s->bytes, bits, 8);
    }
}

static void section_f32(Sections *s, const char *name, const float *x, int n)
{
    begin_section(s, name, "f32", (size_t)n);
    put_f32(&s->bytes, x, (size_t)n);
}

static void section_u32(Sections *s, const char *name, const uint32_t *x, int n)
{
    begin_section(s, name, "u32", (size_t)n);
    put_u32(&s->bytes, x, (size_t)n);
}

enum KeyPart { KEY_FRAME, KEY_POSE, KEY_MOTION, KEY_DIG, KEY_FLAGS, KEY_TEMPERATURE, KEY_PARTS };

static void put_key(Output *out, const HtmlTimedKey *k, int part)
{
    switch (part) {
    case KEY_FRAME:       put_u32(out, &k->frame, 1); break;
    case KEY_POSE:        put_f32(out, k->key.pose, 7); break;
    case KEY_MOTION:      put_f32(out, k->key.motion, 9); break;
    case KEY_DIG:         put_u32(out, &k->key.dig, 1); break;
    case KEY_FLAGS:       put_little(out, k->key.flags, 1); break;
    case KEY_TEMPERATURE: put_f32(out, &k->key.temperature, 1); break;
    default: break;
    }
}

static void put_keys(const HtmlData *d, Sections *s)
{
    static const struct { const char *name, *type; size_t width; } parts[KEY_PARTS] = {
        [KEY_FRAME] = {"key_frame", "u32", 1}, [KEY_POSE] = {"key_pose", "f32", 7}, [KEY_MOTION] = {"key_motion", "f32", 9},
        [KEY_DIG] = {"key_dig", "u32", 1}, [KEY_FLAGS] = {"key_flags", "u8", 1}, [KEY_TEMPERATURE] = {"key_temperature", "f32", 1},
    };
    size_t count = 0;
    for (int i = 0; i < d->bodies.count; i++)
        count += (size_t)d->bodies.data[i].keys.count;
    for (int part = 0; part < KEY_PARTS; part++) {
        if (part == KEY_TEMPERATURE && d->coldest > d->hottest)
            continue;
        begin_section(s, parts[part].name, parts[part].type, count * parts[part].width);
        for (int i = 0; i < d->bodies.count; i++)
            for (int k = 0; k < d->bodies.data[i].keys.count; k++)
                put_key(&s->bytes, &d->bodies.data[i].keys.data[k], part);
    }
}

static void put_links(const HtmlData *d, Sections *s)
{
    size_t efforts = 0, ends = 0;
    begin_section(s, "link", "u32", 6 * (size_t)d->spans.count);
    for (int i = 0; i < d->spans.count; i++) {
        const HtmlSpan *l = &d->spans.data[i];
        const uint32_t row[6] = {l->a, l->b, l->kind, l->layer + (l->bound ? 256u : 0), l->first, (uint32_t)l->efforts.count};
        put_u32(&s->bytes, row, 6);
        efforts += (size_t)l->efforts.count;
        ends += (size_t)l->ends.count;
    }
    begin_section(s, "effort", "f32", efforts);
    for (int i = 0; i < d->spans.count; i++)
        put_f32(&s->bytes, d->spans.data[i].efforts.data, (size_t)d->spans.data[i].efforts.count);
    begin_section(s, "link_end", "f32", ends);
    for (int i = 0; i < d->spans.count; i++)
        put_f32(&s->bytes, d->spans.data[i].ends.data, (size_t)d->spans.data[i].ends.count);
}

static void put_sections(const HtmlData *d, Sections *s)
{
    section_f64(s, "times", d->times.data, d->times.count);
    section_f64(s, "energy", d->energy.data, d->energy.count);
    begin_section(s, "number", "u32", (size_t)d->numbers.count);
    for (int i = 0; i < d->numbers.count; i++)
        put_little(&s->bytes, (uint32_t)d->numbers.data[i], 4);
    put_keys(d, s);
    put_links(d, s);
    for (int i = 0; i < MOMENTS; i++) {
        section_u32(s, html_moments[i].at, d->moments[i].at.data, d->moments[i].at.count);
        section_f32(s, html_moments[i].name, d->moments[i].rows.data, d->moments[i].rows.count);
    }
    section_f32(s, "vertex", d->vertices.data, d->vertices.count);
    section_f32(s, "normal", d->normals.data, d->normals.count);
    section_u32(s, "index", d->indices.data, d->indices.count);
}

static void put_base64(Output *out, const unsigned char *in, size_t size)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char text[4 * 256];
    size_t n = 0;
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t x = (uint32_t)in[i] << 16 | (left > 1 ? (uint32_t)in[i + 1] << 8 : 0) | (left > 2 ? in[i + 2] : 0);
        text[n++] = digit[x >> 18];
        text[n++] = digit[x >> 12 & 63];
        text[n++] = left > 1 ? digit[x >> 6 & 63] : '=';
        text[n++] = left > 2 ? digit[x & 63] : '=';
        if (n == sizeof text || left <= 3) {
            output_bytes(out, text, n);
            n = 0;
        }
    }
}

static void put_data(HtmlData *d, const ExportShell *shell, Output *out)
{
    Sections s = {0};
    put_sections(d, &s);
    output_text(out, "<script type=\"application/json\" id=\"digbox-head\">");
    put_header(d, shell, out);
    output_text(out, "\"bytes\":%zu,\"sections\":{", s.bytes.size);
    output_bytes(out, s.list.data, s.list.size);
    output_text(out, "}}</script>\n<script type=\"application/base64\" id=\"digbox-data\">");
    put_base64(out, s.bytes.data, s.bytes.size);
    output_text(out, "</script>\n");
    if (!output_good(&s.bytes) || !output_good(&s.list))
        output_fail(out, "%s", s.bytes.why[0] ? s.bytes.why : s.list.why);
    output_close(&s.bytes);
    output_close(&s.list);
}

static const char *find_mark(const ExportShell *shell)
{
    size_t n = sizeof place_mark - 1;
    for (size_t i = 0; shell && i + n <= shell->size; i++)
        if (shell->text[i] == '<' && memcmp(shell->text + i, place_mark, n) == 0)
            return shell->text + i;
    return NULL;
}

static dig_status write_html(Replay *r, const ExportOptions *options, Output *out)
{
    const ExportShell *shell = options->shell;
    const char *mark = find_mark(shell);
    if (!mark) {
        output_fail(out, "the page's shell has no place for data");
        return DIG_E_FORMAT;
    }
    HtmlData d = {.r = r, .up = {0, 1, 0}, .coldest = INFINITY, .hottest = -INFINITY};
    dig_status s = gather(&d, options);
    if (s == DIG_OK) {
        const char *rest = mark + sizeof place_mark - 1;
        output_bytes(out, shell->text, (size_t)(mark - shell->text));
        put_data(&d, shell, out);
        output_bytes(out, rest, (size_t)(shell->text + shell->size - rest));
    } else if (s == DIG_E_MEMORY || s == DIG_E_FULL) {
        output_fail(out, s == DIG_E_FULL ? "the replay is too long for one page: choose fewer frames" : "no memory for the page");
    }
    html_data_close(&d);
    return s;
}

const ExportFormat export_html = {".html", "a page for a browser", write_html};
