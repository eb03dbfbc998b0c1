/* export/glb.c - binary glTF 2.0 with baked motion: a node for each body and strut, one animation. Opens in Blender, Godot and
 * in browsers.
 *
 * Bodies that come later or go earlier than the film have scale 0 while they are not there, which all readers know.
 */
#include "export/glb.h"

#include <stdlib.h>
#include <string.h>

#include "math/quat.h"

int part_begin(Part *p)
{
    output_bytes(&p->text, ",", p->count > 0);
    return p->count++;
}

void glb_numbers(Output *o, const char *name, const float *x, int count)
{
    output_text(o, "\"%s\":[", name);
    for (int i = 0; i < count; i++) {
        output_bytes(o, ",", i > 0);
        output_text(o, "%.9g", (double)x[i]);
    }
    output_bytes(o, "]", 1);
}

static void put_bounds(Output *o, const float *x, int count, int width)
{
    float low[4], high[4];
    for (int k = 0; k < width; k++) {
        low[k] = high[k] = x[k];
        for (int i = 1; i < count; i++) {
            low[k] = fminf(low[k], x[i * width + k]);
            high[k] = fmaxf(high[k], x[i * width + k]);
        }
    }
    output_bytes(o, ",", 1);
    glb_numbers(o, "min", low, width);
    output_bytes(o, ",", 1);
    glb_numbers(o, "max", high, width);
}

int glb_accessor(Glb *g, const void *data, int count, int width, int component, bool bounds, int target)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    size_t size = (size_t)count * (size_t)width * 4;
    int view = part_begin(&g->views), accessor = part_begin(&g->accessors);
    output_text(&g->views.text, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu", g->bin.size, size);
    if (target)
        output_text(&g->views.text, ",\"target\":%d", target);
    output_bytes(&g->views.text, "}", 1);
    output_text(&g->accessors.text, "{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"", view, component, count, types[width]);
    if (bounds)
        put_bounds(&g->accessors.text, data, count, width);
    output_bytes(&g->accessors.text, "}", 1);
    output_bytes(&g->bin, data, size);
    return accessor;
}

/* ---- bodies ---- */

static void put_place(Output *o, const float p[3], const float q[4])
{
    output_bytes(o, ",", 1);
    glb_numbers(o, "translation", p, 3);
    output_bytes(o, ",", 1);
    glb_numbers(o, "rotation", q, 4);
}

static void write_place(float p[3], float q[4], vec3 x, quat r)
{
    const float place[7] = {(float)x.x, (float)x.y, (float)x.z, (float)r.x, (float)r.y, (float)r.z, (float)r.w};
    memcpy(p, place, 3 * sizeof *p);
    memcpy(q, place + 3, 4 * sizeof *q);
}

/* The items of a body as nodes below it; their indices go to `children`. Sheets are none: their particles are written, which move. */
static void put_items(Glb *g, const View *v, const ReplayBody *b, const ReplayPose *now, Output *children)
{
    int count = 0;
    for (int i = 0; i < v->item_count; i++) {
        const ViewItem *item = &v->items[i];
        int mesh = item->body == b->id.slot + 1 && !v->meshes[item->mesh].taken ? glb_mesh(g, v, item) : -1;
        if (mesh < 0)
            continue;
        vec3 at = {item->p[0] + v->origin[0], item->p[1] + v->origin[1], item->p[2] + v->origin[2]};
        quat turn = quat_unit((quat){item->q[0], item->q[1], item->q[2], item->q[3]});
        float p[3], q[4];
        write_place(p, q, quat_unrotate(now->rotation, vec3_sub(at, now->position)), quat_mul(quat_conjugate(now->rotation), turn));
        output_text(children, "%s%d", count++ ? "," : "", part_begin(&g->nodes));
        output_text(&g->nodes.text, "{\"mesh\":%d", mesh);
        put_place(&g->nodes.text, p, q);
        output_bytes(&g->nodes.text, "}", 1);
    }
}

static int put_body(Glb *g, const View *v, const ReplayBody *b, int index, const ReplayPose *now)
{
    static const char *const kinds[] = {[DIG_DYNAMIC] = "dynamic", [DIG_KINEMATIC] = "kinematic", [DIG_STATIC] = "static"};
    Output children = {0}, *o = &g->nodes.text;
    char buffer[32];
    float p[3], q[4];
    put_items(g, v, b, now, &children);
    int node = part_begin(&g->nodes);
    output_text(&g->roots.text, "%s%d", g->roots.count++ ? "," : "", node);
    output_text(o, "{\"name\":");
    output_json(o, export_name(b, index, buffer));
    write_place(p, q, now->position, now->rotation);
    put_place(o, p, q);
    if (children.size) {
        output_text(o, ",\"children\":[");
        output_bytes(o, children.data, children.size);
        output_bytes(o, "]", 1);
    }
    output_text(o, ",\"extras\":{\"digbox\":{\"body\":%d,\"kind\":\"%s\",\"material\":", index, kinds[b->kind]);
    output_json(o, b->material ? b->material : "");
    if (isfinite(b->mass))
        output_text(o, ",\"mass\":%.17g", b->mass);
    output_text(o, "}}}");
    if (!output_good(&children))
        output_fail(g->out, "%s", children.why);
    output_close(&children);
    return node;
}

/* ---- keys ---- */

/* Of everything that moves, gathered frame by frame. */
typedef struct Motion {
    int   bodies, *node;        /* [bodies] the node of a body; -1: none yet */
    Keys *keys;                 /* [bodies] */
    int   struts, *strut_node;  /* [struts] by slot of the joint */
    Keys *strut_keys;
} Motion;

static dig_status add_key(Keys *keys, Key k)
{
    const Key *last = keys->count ? &keys->data[keys->count - 1] : NULL;
    float dot = 0;
    for (int i = 0; i < 4 && last; i++)
        dot += last->q[i] * k.q[i];
    for (int i = 0; i < 4 && dot < 0; i++)
        k.q[i] = -k.q[i];
    DIG_TRY(list_push(keys, NULL));
    keys->data[keys->count - 1] = k;
    return DIG_OK;
}

static dig_status room_for_strut(Motion *m, int slot)
{
    if (slot < m->struts)
        return DIG_OK;
    int count = 2 * slot + 16;
    int *node = realloc(m->strut_node, (size_t)count * sizeof *node);
    m->strut_node = node ? node : m->strut_node;
    Keys *keys = realloc(m->strut_keys, (size_t)count * sizeof *keys);
    m->strut_keys = keys ? keys : m->strut_keys;
    if (!node || !keys)
        return DIG_E_MEMORY;
    for (int i = m->struts; i < count; i++) {
        m->strut_node[i] = -1;
        m->strut_keys[i] = (Keys){0};
    }
    m->struts = count;
    return DIG_OK;
}

/* A strut is a node of its own, whose mesh is stretched along y. Where it is not there its length is 0. */
static dig_status add_strut(Glb *g, Motion *m, const View *v, const ViewItem *item, float time, float before)
{
    int slot = (int)item->joint - 1;
    DIG_TRY(room_for_strut(m, slot));
    Keys *keys = &m->strut_keys[slot];
    Key k = {.time = time, .length = v->meshes[item->mesh].size[1]};
    for (int i = 0; i < 3; i++)
        k.p[i] = item->p[i] + (float)v->origin[i];
    memcpy(k.q, item->q, sizeof k.q);
    if (m->strut_node[slot] < 0) {
        int mesh = glb_mesh(g, v, item);
        m->strut_node[slot] = part_begin(&g->nodes);
        output_text(&g->roots.text, "%s%d", g->roots.count++ ? "," : "", m->strut_node[slot]);
        output_text(&g->nodes.text, "{\"name\":\"strut %d\",\"mesh\":%d", slot, mesh);
        put_place(&g->nodes.text, k.p, k.q);
        output_bytes(&g->nodes.text, "}", 1);
        if (time > 0) {
            Key none = k;
            none.time = before;
            none.length = 0;
            DIG_TRY(add_key(keys, none));
        }
    }
    return add_key(keys, k);
}

static dig_status end_struts(Motion *m, float time)
{
    for (int i = 0; i < m->struts; i++) {
        Keys *keys = &m->strut_keys[i];
        if (!keys->count || keys->data[keys->count - 1].time >= time || keys->data[keys->count - 1].length == 0)
            continue;
        Key none = keys->data[keys->count - 1];
        none.time = time;
        none.length = 0;
        DIG_TRY(add_key(keys, none));
    }
    return DIG_OK;
}

static real reach_of(const View *v)
{
    real reach = 10;
    for (int k = 0; k < 3 && v->low[0] <= v->high[0]; k++)
        reach = fmax(reach, 4 * (real)(v->high[k] - v->low[k]));
    return reach;
}

static dig_status add_frame(Glb *g, Motion *m, const ReplayFrame *f, float before)
{
    float time = (float)(f->time - g->start);
    bool fresh = false;
    View *v = NULL;
    for (int i = 0; i < f->pose_count; i++)
        fresh = fresh || m->node[f->poses[i].body] < 0;
    if (fresh || f->struts > 0 || m->struts > 0) {
        DIG_TRY(replay_view(g->r, f->time, &v));
        DIG_TRY(replay_frame(g->r, f->frame, &f));
        g->reach = g->reach > 0 ? g->reach : reach_of(v);
    }
    dig_status status = DIG_OK;
    for (int i = 0; i < f->pose_count && status == DIG_OK; i++) {
        const ReplayPose *p = &f->poses[i];
        const ReplayBody *b = replay_body(g->r, p->body);
        Key k = {.time = time, .length = 1};
        write_place(k.p, k.q, p->position, p->rotation);
        if (m->node[p->body] < 0)
            m->node[p->body] = put_body(g, v, b, p->body, p);
        if (b->kind != DIG_STATIC)
            status = add_key(&m->keys[p->body], k);
    }
    for (int i = 0; v && i < v->item_count && status == DIG_OK; i++)
        if (v->items[i].joint)
            status = add_strut(g, m, v, &v->items[i], time, before);
    dig_view_free(v);
    return status == DIG_OK ? end_struts(m, time) : status;
}

static dig_status write_motion(Glb *g, Motion *m)
{
    float before = 0;
    int last = g->options->first;
    for (int i = export_next_frame(g->r, g->options, -1); i >= 0; i = export_next_frame(g->r, g->options, i)) {
        const ReplayFrame *f;
        DIG_TRY(replay_frame(g->r, i, &f));
        g->start = i == g->options->first ? f->time : g->start;
        real time = f->time;
        DIG_TRY(add_frame(g, m, f, before));
        before = (float)(time - g->start);
        last = i;
    }
    for (int i = 0; i < m->bodies; i++) {
        const ReplayBody *b = replay_body(g->r, i);
        if (m->node[i] < 0)
            continue;
        glb_track(g, m->node[i], &m->keys[i], false);
        real step = replay_info(g->r)->step;
        glb_presence(g, m->node[i], b->born > g->options->first ? (b->born - g->options->first) * step : NAN,
                     b->died <= last ? (b->died - g->options->first) * step : NAN);
    }
    for (int i = 0; i < m->struts; i++)
        if (m->strut_node[i] >= 0)
            glb_track(g, m->strut_node[i], &m->strut_keys[i], true);
    return DIG_OK;
}

static dig_status gather(Glb *g)
{
    Motion m = {.bodies = replay_info(g->r)->bodies};
    m.node = malloc((size_t)(m.bodies + 1) * sizeof *m.node);
    m.keys = calloc((size_t)(m.bodies + 1), sizeof *m.keys);
    for (int i = 0; i < m.bodies && m.node; i++)
        m.node[i] = -1;
    dig_status status = m.node && m.keys ? write_motion(g, &m) : DIG_E_MEMORY;
    for (int i = 0; i < m.bodies && m.keys; i++)
        list_close(&m.keys[i]);
    for (int i = 0; i < m.struts; i++)
        list_close(&m.strut_keys[i]);
    free(m.node);
    free(m.keys);
    free(m.strut_node);
    free(m.strut_keys);
    return status;
}

/* ---- the file ---- */

static void put_part(Output *o, const char *name, const Part *p)
{
    if (p->count == 0)
        return;
    output_text(o, ",\"%s\":[", name);
    output_bytes(o, p->text.data, p->text.size);
    output_bytes(o, "]", 1);
}

static void put_json(Glb *g, Output *o)
{
    output_text(o, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"digbox %s\"}", replay_info(g->r)->digbox);
    if (g->lights.count) {
        output_text(o, ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
        output_bytes(o, g->lights.text.data, g->lights.text.size);
        output_text(o, "]}}");
    }
    output_text(o, ",\"scene\":0,\"scenes\":[{\"name\":\"digbox\"");
    put_part(o, "nodes", &g->roots);
    output_text(o, "}]");
    put_part(o, "nodes", &g->nodes);
    put_part(o, "meshes", &g->meshes);
    put_part(o, "materials", &g->materials);
    put_part(o, "cameras", &g->cameras);
    put_part(o, "accessors", &g->accessors);
    put_part(o, "bufferViews", &g->views);
    if (g->channels.count) {
        output_text(o, ",\"animations\":[{\"name\":\"run\"");
        put_part(o, "samplers", &g->samplers);
        put_part(o, "channels", &g->channels);
        output_text(o, "}]");
    }
    if (g->bin.size)
        output_text(o, ",\"buffers\":[{\"byteLength\":%zu}]", g->bin.size);
    output_bytes(o, "}", 1);
    while (o->size % 4)
        output_bytes(o, " ", 1);
}

static void put_u32(Output *o, size_t x)
{
    const unsigned char bytes[4] = {(unsigned char)x, (unsigned char)(x >> 8), (unsigned char)(x >> 16), (unsigned char)(x >> 24)};
    output_bytes(o, bytes, 4);
}

/* 12 bytes of header, then the two chunks. */
static void put_chunks(Glb *g, const Output *json, Output *out)
{
    size_t whole = 12 + 8 + json->size + (g->bin.size ? 8 + g->bin.size : 0);
    if (whole > UINT32_MAX) {
        output_fail(out, "the scene needs %zu bytes, a .glb has 4294967295 at most: fewer frames or a lower --fps make it smaller", whole);
        return;
    }
    output_bytes(out, "glTF", 4);
    put_u32(out, 2);
    put_u32(out, whole);
    put_u32(out, json->size);
    output_bytes(out, "JSON", 4);
    output_bytes(out, json->data, json->size);
    if (g->bin.size) {
        put_u32(out, g->bin.size);
        output_bytes(out, "BIN", 4);
        output_bytes(out, g->bin.data, g->bin.size);
    }
}

static dig_status write_glb(Replay *r, const ExportOptions *options, Output *out)
{
    Glb g = {.r = r, .options = options, .out = out};
    Output json = {0}, *const all[] = {&json, &g.bin, &g.nodes.text, &g.meshes.text, &g.materials.text, &g.accessors.text, &g.views.text,
                                       &g.samplers.text, &g.channels.text, &g.cameras.text, &g.lights.text, &g.roots.text};
    dig_status status = gather(&g);
    if (status == DIG_OK) {
        glb_scene(&g);
        put_json(&g, &json);
        put_chunks(&g, &json, out);
    }
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (!output_good(all[i]))
            output_fail(out, "%s", all[i]->why);
        output_close(all[i]);
    }
    list_close(&g.known);
    return status;
}

const ExportFormat export_glb = {".glb", "binary glTF 2.0 with baked motion, for Blender, Godot and browsers", write_glb};
