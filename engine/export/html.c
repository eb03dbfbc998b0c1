/* export/html.c - writes a replay into the page's shell: the JSON header, the sections (html_data.h, packed by html_pack.c), and the rest of the shell. */
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
    output_text(out, "{\"format\":2,\"title\":");
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
    output_text(out, "\"events_left_out\":%d,\n", d->events_left_out);
}

/* ---- sections: what is told with how many digits ---- */

enum { BITS = -1 };
static const HtmlPart whole = {1, 1, 0, 0}, exact = {1, BITS, 0, 0};

static HtmlRows rows_of(const void *words, int count, int width) { return (HtmlRows){words, (size_t)(count / width), (size_t)width}; }

static void put_list(HtmlSections *s, const char *name, const char *type, const void *words, int count, HtmlPart part)
{
    HtmlRows r = rows_of(words, count, part.width);
    html_section_words(s, name, type, &r, &part, 1);
}

/* A step of places: a four-millionth of the scene, or twice that, and at most two micrometres. */
static real grid_of(const HtmlData *d)
{
    real size = 0;
    for (int i = 0; i < 3; i++)
        size = real_max(size, (real)d->high[i] - (real)d->low[i]);
    return ldexp(1, (size > 0 && size < 8 ? ilogb(size) + 1 : 3) - 22);
}

/* Columns of HtmlTimedKey. Velocities err by a step of place in a second. */
static void put_keys(const HtmlData *d, HtmlSections *s, real grid)
{
    const HtmlPart poses[] = {{3, 2, grid, 0}, {4, 2, 0x1p-20, 0}}, motion[] = {{3, 1, grid, 0}, {3, 1, 0x1p-20, 0}, {3, BITS, 0, 12}};
    const HtmlPart temperature = {1, BITS, 0, 8};
    const struct { const char *name, *type; const HtmlPart *parts; int count, at; } lists[] = {
        {"key_frame", "u32", &whole, 1, 0}, {"key_pose", "f32", poses, 2, 1}, {"key_motion", "f32", motion, 3, 8}, {"key_dig", "u32", &whole, 1, 18},
        {"key_flags", "u32", &whole, 1, 19}, {"key_temperature", "f32", &temperature, 1, 17},
    };
    const size_t stride = sizeof(HtmlTimedKey) / sizeof(uint32_t);
    Output keys = {0};
    for (int i = 0; i < d->bodies.count; i++)
        output_bytes(&keys, d->bodies.data[i].keys.data, (size_t)d->bodies.data[i].keys.count * sizeof(HtmlTimedKey));
    for (size_t i = 0; i < sizeof lists / sizeof *lists - (d->coldest > d->hottest ? 1 : 0); i++) {
        HtmlRows r = {keys.data ? (const uint32_t *)(const void *)keys.data + lists[i].at : NULL, keys.size / sizeof(HtmlTimedKey), stride};
        html_section_words(s, lists[i].name, lists[i].type, &r, lists[i].parts, lists[i].count);
    }
    if (!output_good(&keys))
        output_fail(&s->bytes, "%s", keys.why);
    output_close(&keys);
}

static void put_links(const HtmlData *d, HtmlSections *s, real grid)
{
    Output rows = {0}, efforts = {0}, ends = {0};
    for (int i = 0; i < d->spans.count; i++) {
        const HtmlSpan *l = &d->spans.data[i];
        const uint32_t row[6] = {l->a, l->b, l->kind, l->layer + (l->bound ? 256u : 0), l->first, (uint32_t)l->efforts.count};
        output_bytes(&rows, row, sizeof row);
        output_bytes(&efforts, l->efforts.data, (size_t)l->efforts.count * sizeof(float));
        output_bytes(&ends, l->ends.data, (size_t)l->ends.count * sizeof(float));
    }
    put_list(s, "link", "u32", rows.data, (int)(rows.size / 4), (HtmlPart){6, 1, 0, 0});
    put_list(s, "effort", "f32", efforts.data, (int)(efforts.size / 4), (HtmlPart){1, BITS, 0, 12});
    put_list(s, "link_end", "f32", ends.data, (int)(ends.size / 4), (HtmlPart){3, 1, 0x1p6 * grid, 0});
    if (!output_good(&rows) || !output_good(&efforts) || !output_good(&ends))
        output_fail(&s->bytes, "no memory for the page");
    output_close(&rows);
    output_close(&efforts);
    output_close(&ends);
}

static void put_events(const HtmlData *d, HtmlSections *s)
{
    Output rows = {0};
    for (int i = 0; i < d->events.count; i++) {
        const HtmlEvent *h = &d->events.data[i];
        const dig_event *e = &h->event;
        const real row[HTML_EVENT_WIDTH] = {h->frame, e->time, e->kind, h->a, h->b, isfinite(e->speed) ? (real)(float)e->speed : 0,
            isfinite(e->impulse) ? (real)(float)e->impulse : 0, (real)e->dig, (real)e->other_dig, (real)e->link, (real)e->layer,
            isfinite(e->stress) ? (real)(float)e->stress : 0};
        output_bytes(&rows, row, sizeof row);
    }
    html_section_reals(s, "event", (const real *)(const void *)rows.data, rows.size / (HTML_EVENT_WIDTH * sizeof(real)), HTML_EVENT_WIDTH);
    if (!output_good(&rows))
        output_fail(&s->bytes, "%s", rows.why);
    output_close(&rows);
}

/* What is drawn only: places to a sixteen-thousandth of the scene, arrows to 8 bits. */
static void put_moments(const HtmlData *d, HtmlSections *s, real grid)
{
    const HtmlPart place = {3, 0, 0x1p8 * grid, 0}, arrow = {3, BITS, 0, 16}, ends = {6, 0, 0x1p4 * grid, 0};
    const HtmlPart parts[MOMENTS][2] = {
        [MOMENT_CONTACT] = {place, arrow}, [MOMENT_LINE] = {ends, exact}, [MOMENT_STRUT] = {ends, {2, BITS, 0, 12}},
        [MOMENT_PUSH] = {place, arrow}, [MOMENT_CAMERA] = {{11, BITS, 0, 0}}, [MOMENT_SHEET] = {{5, BITS, 0, 0}},
    };
    for (int i = 0; i < MOMENTS; i++) {
        HtmlRows r = rows_of(d->moments[i].rows.data, d->moments[i].rows.count, html_moments[i].width);
        put_list(s, html_moments[i].at, "u32", d->moments[i].at.data, d->moments[i].at.count, (HtmlPart){2, 1, 0, 0});
        html_section_words(s, html_moments[i].name, "f32", &r, parts[i], parts[i][1].width ? 2 : 1);
    }
}

static void put_sections(const HtmlData *d, HtmlSections *s)
{
    real grid = grid_of(d);
    html_section_reals(s, "times", d->times.data, (size_t)d->times.count, 1);
    html_section_reals(s, "energy", d->energy.data, (size_t)d->energy.count / 10, 10);
    put_list(s, "number", "u32", d->numbers.data, d->numbers.count, whole);
    put_keys(d, s, grid);
    put_links(d, s, grid);
    put_events(d, s);
    put_moments(d, s, grid);
    put_list(s, "vertex", "f32", d->vertices.data, d->vertices.count, (HtmlPart){3, BITS, 0, 0});
    put_list(s, "normal", "f32", d->normals.data, d->normals.count, (HtmlPart){3, BITS, 0, 0});
    put_list(s, "index", "u32", d->indices.data, d->indices.count, whole);
}

static void put_data(HtmlData *d, const ExportShell *shell, Output *out)
{
    HtmlSections s = {0};
    put_sections(d, &s);
    output_text(out, "<script type=\"application/json\" id=\"digbox-head\">");
    put_header(d, shell, out);
    output_text(out, "\"bytes\":%zu,\"sections\":{", s.bytes.size);
    output_bytes(out, s.list.data, s.list.size);
    output_text(out, "}}</script>\n<script type=\"application/base64\" id=\"digbox-data\">");
    html_put_packed(out, &s.bytes);
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
