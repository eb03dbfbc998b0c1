/* view/sheet.c - sheets, such as cloth: particles in columns and rows become one surface.
 *
 * A quad lies between four neighbours as long as joints hold all its sides; a side between two bodies that do not move needs none. So
 * a sheet opens where its threads tear. What is in no quad is drawn by itself, as other bodies and struts are.
 */
#include "view/making.h"

#include <stdlib.h>

/* ---- quads ---- */

typedef struct Weave { Map nodes, threads; } Weave;     /* sheet, column, row -> body; two bodies, the lower first */

static MapKey thread_key(uint32_t a, uint32_t b) { return a < b ? (MapKey){a, b, 0} : (MapKey){b, a, 0}; }

static bool is_held(const Making *m, const Weave *w, uint32_t a, uint32_t b)
{
    const LookBody *bodies = look_bodies(m->l);
    return map_find(&w->threads, thread_key(a, b), NULL) || (bodies[a].kind != DIG_DYNAMIC && bodies[b].kind != DIG_DYNAMIC);
}

static dig_status find_nodes(const Making *m, Weave *w)
{
    for (int i = 0; i < look_count(m->l, LOOK_BODIES); i++) {
        const LookBody *b = &look_bodies(m->l)[i];
        if (b->there && b->sheet)
            DIG_TRY(map_put(&w->nodes, (MapKey){b->sheet, b->column, b->row}, (uint32_t)i));
    }
    for (int i = 0; w->nodes.count > 0 && i < look_count(m->l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(m->l)[i];
        if (j->there && j->b != LOOK_NONE && look_bodies(m->l)[j->a].sheet && look_bodies(m->l)[j->b].sheet)
            DIG_TRY(map_put(&w->threads, thread_key(j->a, j->b), 0));
    }
    return DIG_OK;
}

/* The quad whose first corner is that body, if there is one. */
static dig_status add_quad(Making *m, const Weave *w, uint32_t first)
{
    const LookBody *b = &look_bodies(m->l)[first];
    uint32_t corner[4] = {first, 0, 0, 0};
    if (!map_find(&w->nodes, (MapKey){b->sheet, b->column + 1, b->row}, &corner[1]) ||
        !map_find(&w->nodes, (MapKey){b->sheet, b->column + 1, b->row + 1}, &corner[2]) ||
        !map_find(&w->nodes, (MapKey){b->sheet, b->column, b->row + 1}, &corner[3]))
        return DIG_OK;
    for (int i = 0; i < 4; i++)
        if (!is_held(m, w, corner[i], corner[(i + 1) % 4]))
            return DIG_OK;
    DIG_TRY(list_push(&m->to->quads, NULL));
    memcpy(m->to->quads.data[m->to->quads.count - 1].corner, corner, sizeof corner);
    for (int i = 0; i < 4; i++)
        m->woven[corner[i]] = true;
    return map_put(&m->quads, (MapKey){b->sheet, b->column, b->row}, (uint32_t)m->to->quads.count - 1);
}

dig_status find_quads(Making *m)
{
    Weave w = {{0}, {0}};
    const int bodies = look_count(m->l, LOOK_BODIES);
    dig_status s = find_nodes(m, &w);
    if (s == DIG_OK && w.nodes.count > 0) {
        m->woven = calloc((size_t)bodies + 1, sizeof *m->woven);
        s = m->woven ? DIG_OK : DIG_E_MEMORY;
        for (int i = 0; s == DIG_OK && i < bodies; i++)
            if (look_bodies(m->l)[i].there && look_bodies(m->l)[i].sheet)
                s = add_quad(m, &w, (uint32_t)i);
    }
    map_close(&w.nodes);
    map_close(&w.threads);
    return s;
}

bool is_thread(const Making *m, uint32_t a, uint32_t b)
{
    if (!m->woven || b == LOOK_NONE || !m->woven[a] || !m->woven[b])
        return false;
    const LookBody *p = &look_bodies(m->l)[a], *q = &look_bodies(m->l)[b];
    uint32_t column = p->column < q->column ? p->column : q->column, row = p->row < q->row ? p->row : q->row;
    uint32_t wide = p->column + q->column - 2 * column, high = p->row + q->row - 2 * row;
    if (p->sheet != q->sheet || wide > 1 || high > 1)
        return false;
    return map_find(&m->quads, (MapKey){p->sheet, column, row}, NULL) ||
           (wide == 0 && column > 0 && map_find(&m->quads, (MapKey){p->sheet, column - 1, row}, NULL)) ||
           (high == 0 && row > 0 && map_find(&m->quads, (MapKey){p->sheet, column, row - 1}, NULL));
}

/* ---- surfaces ---- */

typedef struct Sheet {          /* one while it is made */
    uint32_t number, dig;
    uint32_t *vertex;           /* [bodies] its vertex + 1 */
    uint32_t *bodies;           /* [vertices] */
    int      vertices, quads;
} Sheet;

/* Of the first corner that is in one: pins are in none. */
static uint32_t quad_dig(const Making *m, const ViewQuad *q)
{
    for (int i = 0; i < 4; i++)
        if (look_poses(m->l)[q->corner[i]].dig)
            return look_poses(m->l)[q->corner[i]].dig;
    return 0;
}

static bool is_of(const Making *m, const Sheet *s, const ViewQuad *q)
{
    return look_bodies(m->l)[q->corner[0]].sheet == s->number && quad_dig(m, q) == s->dig;
}

static void gather(const Making *m, Sheet *s)
{
    s->vertices = s->quads = 0;
    memset(s->vertex, 0, (size_t)look_count(m->l, LOOK_BODIES) * sizeof *s->vertex);
    for (int i = 0; i < m->to->quads.count; i++) {
        const ViewQuad *q = &m->to->quads.data[i];
        if (!is_of(m, s, q))
            continue;
        s->quads++;
        for (int k = 0; k < 4; k++)
            if (!s->vertex[q->corner[k]]) {
                s->bodies[s->vertices++] = q->corner[k];
                s->vertex[q->corner[k]] = (uint32_t)s->vertices;
            }
    }
}

static vec3 mesh_point(const ViewMesh *m, uint32_t i) { return (vec3){(real)m->vertices[3 * i], (real)m->vertices[3 * i + 1], (real)m->vertices[3 * i + 2]}; }

/* Sums of the normals of the triangles there, each as large as its area. */
static void set_normals(ViewMesh *m)
{
    memset(m->normals, 0, (size_t)(3 * m->vertex_count) * sizeof *m->normals);
    for (int i = 0; i < m->index_count; i += 3) {
        const uint32_t *k = m->indices + i;
        vec3 a = mesh_point(m, k[0]), n = vec3_cross(vec3_sub(mesh_point(m, k[1]), a), vec3_sub(mesh_point(m, k[2]), a));
        for (int c = 0; c < 3; c++) {
            m->normals[3 * k[c]] += (float)n.x;
            m->normals[3 * k[c] + 1] += (float)n.y;
            m->normals[3 * k[c] + 2] += (float)n.z;
        }
    }
    for (int i = 0; i < m->vertex_count; i++) {
        float *n = m->normals + 3 * i;
        write_vec(n, vec3_unit_or((vec3){(real)n[0], (real)n[1], (real)n[2]}, (vec3){0, 1, 0}));
    }
}

/* The triangles; each quad is cut along its shorter diagonal. */
static void set_indices(const Making *m, const Sheet *s, ViewMesh *out)
{
    uint32_t *at = out->indices;
    for (int i = 0; i < m->to->quads.count; i++) {
        const ViewQuad *q = &m->to->quads.data[i];
        if (!is_of(m, s, q))
            continue;
        uint32_t v[4];
        for (int k = 0; k < 4; k++)
            v[k] = s->vertex[q->corner[k]] - 1;
        bool other = vec3_distance(mesh_point(out, v[0]), mesh_point(out, v[2])) > vec3_distance(mesh_point(out, v[1]), mesh_point(out, v[3]));
        const uint32_t cut[2][6] = {{v[0], v[1], v[2], v[0], v[2], v[3]}, {v[0], v[1], v[3], v[1], v[2], v[3]}};
        memcpy(at, cut[other], sizeof cut[other]);
        at += 6;
    }
}

static dig_status make_surface(const Making *m, const Sheet *s, vec3 middle, ViewMesh *out)
{
    *out = (ViewMesh){.form = VIEW_MESH, .vertex_count = s->vertices, .index_count = 6 * s->quads};
    size_t bytes = (size_t)(3 * s->vertices) * sizeof(float);
    out->vertices = malloc(bytes);
    out->normals = malloc(bytes);
    out->taken = malloc(bytes);
    out->indices = malloc((size_t)out->index_count * sizeof *out->indices);
    if (!out->vertices || !out->normals || !out->taken || !out->indices)
        return DIG_E_MEMORY;
    for (int i = 0; i < s->vertices; i++)
        write_vec(out->vertices + 3 * i, vec3_sub(look_poses(m->l)[s->bodies[i]].x, middle));
    memcpy(out->taken, out->vertices, bytes);
    set_indices(m, s, out);
    set_normals(out);
    return DIG_OK;
}

/* The first shape of a body, by which its sheet looks. */
static const LookSolid *solid_of(const Making *m, uint32_t body)
{
    for (int i = 0; i < look_count(m->l, LOOK_SOLIDS); i++)
        if (look_solids(m->l)[i].there && look_solids(m->l)[i].body == body)
            return &look_solids(m->l)[i];
    return NULL;
}

static dig_status make_sheet(Making *m, Sheet *s)
{
    gather(m, s);
    vec3 sum = vec3_zero();
    ViewItem item = {.body = s->bodies[0] + 1, .q = {0, 0, 0, 1}, .roughness = 0.8f, .dig = s->dig, .stress = -1, .asleep = true};
    for (int i = 0; i < s->vertices; i++) {
        const LookPose *p = &look_poses(m->l)[s->bodies[i]];
        sum = vec3_add(sum, p->x);
        item.body = s->bodies[i] + 1 < item.body ? s->bodies[i] + 1 : item.body;
        item.stress = fmaxf(item.stress, m->stress[s->bodies[i]]);
        item.asleep = item.asleep && (!p->awake || look_bodies(m->l)[s->bodies[i]].kind != DIG_DYNAMIC);
        item.temperature = fmaxf(item.temperature, (float)p->temperature);
    }
    vec3 middle = vec3_scale(1 / (real)s->vertices, sum);
    const LookSolid *look = solid_of(m, item.body - 1);
    if (look) {
        memcpy(item.colour, look->colour, sizeof item.colour);
        item.roughness = look->roughness;
        item.metallic = look->metallic;
        item.clear = look->clear;
    }
    for (int i = 0; i < m->to->quads.count; i++)
        if (is_of(m, s, &m->to->quads.data[i]))
            memcpy(m->to->quads.data[i].colour, item.colour, sizeof item.colour);
    write_point(m, item.p, middle);
    DIG_TRY(list_push(&m->to->meshes, NULL));
    item.mesh = m->to->meshes.count - 1;
    DIG_TRY(make_surface(m, s, middle, &m->to->meshes.data[item.mesh]));
    DIG_TRY(list_push(&m->to->items, NULL));
    m->to->items.data[m->to->items.count - 1] = item;
    return DIG_OK;
}

dig_status make_sheets(Making *m)
{
    Map done = {0};
    Sheet s = {0};
    const size_t bodies = (size_t)look_count(m->l, LOOK_BODIES) + 1;
    dig_status status = DIG_OK;
    if (m->to->quads.count == 0)
        return DIG_OK;
    s.vertex = malloc(bodies * sizeof *s.vertex);
    s.bodies = malloc(bodies * sizeof *s.bodies);
    status = s.vertex && s.bodies ? DIG_OK : DIG_E_MEMORY;
    for (int i = 0; i < m->to->quads.count && status == DIG_OK; i++) {
        s.number = look_bodies(m->l)[m->to->quads.data[i].corner[0]].sheet;
        s.dig = quad_dig(m, &m->to->quads.data[i]);
        if (map_find(&done, (MapKey){s.number, s.dig, 0}, NULL))
            continue;
        status = map_put(&done, (MapKey){s.number, s.dig, 0}, 0);
        if (status == DIG_OK)
            status = make_sheet(m, &s);
    }
    free(s.vertex);
    free(s.bodies);
    map_close(&done);
    return status;
}
