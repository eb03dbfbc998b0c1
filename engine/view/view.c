/* view/view.c - makes the picture: poses, meshes, contacts, links, as floats about the scene's middle. */
#include "view/view.h"

#include "view/look.h"
#include "world/world.h"

#include <stdlib.h>

typedef struct Lists {
    LIST(ViewItem)    items;
    LIST(ViewMesh)    meshes;
    LIST(ViewContact) contacts;
    LIST(ViewLine)    lines;
    LIST(ViewArrow)   arrows;
    LIST(ViewLabel)   labels;
    LIST(ViewEdge)    edges;
} Lists;

/* A view is the front of what owns its arrays: they can only be given back by those who know how much room they have. */
typedef struct Kept { View view; Lists lists; } Kept;

typedef struct Making {
    const Look *l;
    vec3      origin;
    float    *stress;                       /* [bodies] the largest share of its limit that a joint of its bears; -1: none can break */
    uint32_t *mesh;                         /* [meshes of the look] in the view; LOOK_NONE: not yet */
    Lists    *to;
} Making;

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static void write_point(const Making *m, float out[3], vec3 p) { write_vec(out, vec3_sub(p, m->origin)); }

static void write_quat(float out[4], quat q)
{
    out[0] = (float)q.x;
    out[1] = (float)q.y;
    out[2] = (float)q.z;
    out[3] = (float)q.w;
}

/* ---- shapes ---- */

static dig_status copy_array(void **out, const void *from, size_t size)
{
    if (!from)
        return DIG_OK;
    *out = malloc(size + 1);
    if (!*out)
        return DIG_E_MEMORY;
    memcpy(*out, from, size);
    return DIG_OK;
}

static dig_status make_mesh(Making *m, uint32_t index, int *mesh)
{
    if (m->mesh[index] == LOOK_NONE) {
        const ViewMesh *from = &m->l->meshes.data[index].mesh;
        size_t vertices = (size_t)from->vertex_count * 3 * sizeof(float);
        DIG_TRY(list_push(&m->to->meshes, NULL));
        ViewMesh *to = &m->to->meshes.data[m->to->meshes.count - 1];
        *to = *from;
        to->vertices = to->normals = NULL;
        to->indices = NULL;
        DIG_TRY(copy_array((void **)&to->vertices, from->vertices, vertices));
        DIG_TRY(copy_array((void **)&to->normals, from->normals, vertices));
        DIG_TRY(copy_array((void **)&to->indices, from->indices, (size_t)from->index_count * sizeof *from->indices));
        m->mesh[index] = (uint32_t)m->to->meshes.count - 1;
    }
    *mesh = (int)m->mesh[index];
    return DIG_OK;
}

/* A plane is drawn about its foot point, +y along its normal. */
static pose plane_pose(const LookMesh *m, pose at)
{
    vec3 n = quat_rotate(at.q, m->normal);
    return (pose){vec3_mad(at.p, m->offset, n), quat_between((vec3){0, 1, 0}, n)};
}

static dig_status make_item(Making *m, const LookSolid *s)
{
    const LookBody *b = s->body == LOOK_NONE ? NULL : &look_bodies(m->l)[s->body];
    const LookPose *p = b ? &look_poses(m->l)[s->body] : NULL;
    int mesh;
    DIG_TRY(make_mesh(m, s->mesh, &mesh));
    DIG_TRY(list_push(&m->to->items, NULL));
    ViewItem *item = &m->to->items.data[m->to->items.count - 1];
    pose at = s->at;
    if (b)
        at = pose_mul((pose){vec3_sub(p->x, quat_rotate(p->q, b->centre)), p->q}, at);
    if (m->to->meshes.data[mesh].form == VIEW_PLANE)
        at = plane_pose(&m->l->meshes.data[s->mesh], at);
    item->body = b ? s->body + 1 : 0;
    item->mesh = mesh;
    write_point(m, item->p, at.p);
    write_quat(item->q, at.q);
    memcpy(item->colour, s->colour, sizeof item->colour);
    item->roughness = s->roughness;
    item->metallic = s->metallic;
    item->clear = s->clear;
    item->pattern = (int)s->pattern;
    item->dig = b ? p->dig : 0;
    item->stress = b ? m->stress[s->body] : -1;
    item->asleep = b && b->kind == DIG_DYNAMIC && !p->awake;
    item->fixed = !b || b->kind == DIG_STATIC;
    item->temperature = b ? (float)p->temperature : 0;
    return DIG_OK;
}

static dig_status make_items(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_SOLIDS); i++)
        if (look_solids(m->l)[i].there)
            DIG_TRY(make_item(m, &look_solids(m->l)[i]));
    return DIG_OK;
}

/* ---- structures: what their joints bear, and struts, which have no body ---- */

enum { PRISM = 10 };        /* sides of a strut */

/* An upright prism, 1 in all, whose vertices are sent to the strut's size. */
static dig_status strut_mesh(ViewMesh *m, float radius, float length)
{
    *m = (ViewMesh){.form = VIEW_CYLINDER, .size = {radius, length}, .vertex_count = 2 * PRISM, .index_count = 6 * PRISM + 6 * (PRISM - 2)};
    m->vertices = malloc((size_t)(3 * m->vertex_count) * sizeof *m->vertices);
    m->indices = malloc((size_t)m->index_count * sizeof *m->indices);
    if (!m->vertices || !m->indices)
        return DIG_E_MEMORY;
    uint32_t *out = m->indices;
    for (uint32_t i = 0; i < PRISM; i++) {
        float x = radius * (float)cos(2 * DIG_PI * i / PRISM), z = radius * (float)sin(2 * DIG_PI * i / PRISM);
        const float ends[6] = {x, -0.5f * length, z, x, 0.5f * length, z};
        memcpy(m->vertices + (size_t)6 * i, ends, sizeof ends);
        uint32_t a = 2 * i, b = 2 * ((i + 1) % PRISM);
        const uint32_t side[6] = {a, a + 1, b, b, a + 1, b + 1};
        memcpy(out, side, sizeof side);
        out += 6;
    }
    for (uint32_t i = 1; i + 1 < PRISM; i++) {
        const uint32_t caps[6] = {0, 2 * i, 2 * i + 2, 1, 2 * i + 3, 2 * i + 1};
        memcpy(out, caps, sizeof caps);
        out += 6;
    }
    return DIG_OK;
}

static vec3 joint_end(const Making *m, uint32_t body, vec3 anchor)
{
    if (body == LOOK_NONE)
        return anchor;
    const LookPose *p = &look_poses(m->l)[body];
    return vec3_add(p->x, quat_rotate(p->q, anchor));
}

static dig_status make_strut(Making *m, const LookJoint *j, float stress)
{
    vec3 a = joint_end(m, j->a, j->ra), b = joint_end(m, j->b, j->rb);
    const LookPose *p = &look_poses(m->l)[j->a];
    if (!(vec3_distance(a, b) > 1e-9))
        return DIG_OK;
    DIG_TRY(list_push(&m->to->meshes, NULL));
    DIG_TRY(strut_mesh(&m->to->meshes.data[m->to->meshes.count - 1], (float)j->radius, (float)vec3_distance(a, b)));
    DIG_TRY(list_push(&m->to->items, NULL));
    ViewItem *item = &m->to->items.data[m->to->items.count - 1];
    *item = (ViewItem){.joint = (uint32_t)(j - look_joints(m->l)) + 1, .mesh = m->to->meshes.count - 1, .colour = {0.30f, 0.32f, 0.35f},
                       .roughness = 0.45f, .stress = stress, .dig = p->dig, .asleep = !p->awake};
    write_quat(item->q, quat_between((vec3){0, 1, 0}, vec3_unit(vec3_sub(b, a))));
    write_point(m, item->p, vec3_scale(0.5, vec3_add(a, b)));
    return DIG_OK;
}

static void raise_stress(Making *m, uint32_t body, float stress)
{
    if (body != LOOK_NONE && m->stress[body] < stress)
        m->stress[body] = stress;
}

/* Of the bodies that joints hold which can break. */
static void find_stress(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_BODIES); i++)
        m->stress[i] = -1;
    for (int i = 0; i < look_count(m->l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(m->l)[i];
        if (!j->there)
            continue;
        raise_stress(m, j->a, look_loads(m->l)[i].stress);
        raise_stress(m, j->b, look_loads(m->l)[i].stress);
    }
}

static dig_status make_struts(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(m->l)[i];
        if (j->there && j->radius > 0)
            DIG_TRY(make_strut(m, j, look_loads(m->l)[i].stress));
    }
    return DIG_OK;
}

/* ---- contacts, lines, arrows, names, links ---- */

static dig_status make_contacts(Making *m)
{
    int count = look_count(m->l, LOOK_CONTACTS);
    DIG_TRY(list_reserve(&m->to->contacts, count, NULL));
    for (int i = 0; i < count; i++) {
        const LookContact *from = &look_contacts(m->l)[i];
        ViewContact *to = &m->to->contacts.data[i];
        memcpy(to->p, from->p, sizeof to->p);
        memcpy(to->n, from->n, sizeof to->n);
        memcpy(to->force, from->force, sizeof to->force);
    }
    m->to->contacts.count = count;
    return DIG_OK;
}

static dig_status make_line(Making *m, vec3 a, vec3 b, vec3 colour, uint32_t dig)
{
    DIG_TRY(list_push(&m->to->lines, NULL));
    ViewLine *line = &m->to->lines.data[m->to->lines.count - 1];
    write_point(m, line->a, a);
    write_point(m, line->b, b);
    write_vec(line->colour, colour);
    line->dig = dig;
    return DIG_OK;
}

static dig_status make_joints(Making *m)
{
    const vec3 arm = {0.9, 0.7, 0.1}, gap = {0.75, 0.72, 0.65};
    for (int i = 0; i < look_count(m->l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(m->l)[i];
        if (!j->there || !j->drawn)
            continue;
        vec3 a = joint_end(m, j->a, j->ra), b = joint_end(m, j->b, j->rb);
        uint32_t dig = look_poses(m->l)[j->a].dig;
        DIG_TRY(make_line(m, look_poses(m->l)[j->a].x, a, arm, dig));
        if (vec3_distance(a, b) > 1e-6)
            DIG_TRY(make_line(m, a, b, gap, dig));
        if (j->b != LOOK_NONE)
            DIG_TRY(make_line(m, b, look_poses(m->l)[j->b].x, arm, dig));
    }
    return DIG_OK;
}

static dig_status make_room(Making *m)
{
    const LookScene *r = look_scene(m->l);
    if (!r->has_room)
        return DIG_OK;
    vec3 h = vec3_scale(0.5, r->room_size), c = vec3_add(r->room_at, (vec3){0, h.y, 0});
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 4; k++) {
            real s = k & 1 ? 1 : -1, u = k & 2 ? 1 : -1;
            vec3 a = axis == 0 ? (vec3){-h.x, s * h.y, u * h.z} : axis == 1 ? (vec3){s * h.x, -h.y, u * h.z} : (vec3){s * h.x, u * h.y, -h.z};
            vec3 b = axis == 0 ? (vec3){h.x, s * h.y, u * h.z} : axis == 1 ? (vec3){s * h.x, h.y, u * h.z} : (vec3){s * h.x, u * h.y, h.z};
            DIG_TRY(make_line(m, vec3_add(c, a), vec3_add(c, b), (vec3){0.3, 0.35, 0.4}, 0));
        }
    return DIG_OK;
}

static dig_status make_arrows(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_ARROWS); i++) {
        const LookArrow *from = &look_arrows(m->l)[i];
        DIG_TRY(list_push(&m->to->arrows, NULL));
        ViewArrow *a = &m->to->arrows.data[m->to->arrows.count - 1];
        write_point(m, a->p, from->p);
        memcpy(a->v, from->v, sizeof a->v);
        write_vec(a->colour, (vec3){0.04, 0.22, 0.80});      /* not that of contact forces */
    }
    return DIG_OK;
}

static dig_status make_labels(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_BODIES); i++) {
        const LookBody *b = &look_bodies(m->l)[i];
        if (!b->there || !b->labelled)
            continue;
        DIG_TRY(list_push(&m->to->labels, NULL));
        ViewLabel *label = &m->to->labels.data[m->to->labels.count - 1];
        write_point(m, label->p, look_poses(m->l)[i].x);
        memcpy(label->text, b->name, sizeof label->text);
    }
    return DIG_OK;
}

static dig_status make_edges(Making *m)
{
    int count = look_count(m->l, LOOK_EDGES);
    DIG_TRY(list_reserve(&m->to->edges, count, NULL));
    for (int i = 0; i < count; i++) {
        const LookEdge *from = &look_edges(m->l)[i];
        ViewEdge *e = &m->to->edges.data[i];
        *e = (ViewEdge){.dig = from->dig, .kind = from->kind, .layer = from->layer, .bound = from->bound};
        write_point(m, e->a, look_poses(m->l)[from->a].x);
        if (from->bound)
            memcpy(e->b, from->end, sizeof e->b);
        else
            write_point(m, e->b, look_poses(m->l)[from->b].x);
    }
    m->to->edges.count = count;
    return DIG_OK;
}

/* ---- all ---- */

static dig_status make_all(Making *m)
{
    m->stress = malloc((size_t)(look_count(m->l, LOOK_BODIES) + 1) * sizeof *m->stress);
    m->mesh = malloc((size_t)(m->l->meshes.count + 1) * sizeof *m->mesh);
    if (!m->stress || !m->mesh)
        return DIG_E_MEMORY;
    memset(m->mesh, 0xff, (size_t)m->l->meshes.count * sizeof *m->mesh);
    find_stress(m);
    DIG_TRY(make_items(m));
    DIG_TRY(make_struts(m));
    DIG_TRY(make_contacts(m));
    DIG_TRY(make_joints(m));
    DIG_TRY(make_room(m));
    DIG_TRY(make_arrows(m));
    DIG_TRY(make_labels(m));
    return make_edges(m);
}

static void show(Kept *k)
{
    View *v = &k->view;
    Lists *l = &k->lists;
    v->items = l->items.data;       v->item_count = l->items.count;
    v->meshes = l->meshes.data;     v->mesh_count = l->meshes.count;
    v->contacts = l->contacts.data; v->contact_count = l->contacts.count;
    v->lines = l->lines.data;       v->line_count = l->lines.count;
    v->arrows = l->arrows.data;     v->arrow_count = l->arrows.count;
    v->labels = l->labels.data;     v->label_count = l->labels.count;
    v->edges = l->edges.data;       v->edge_count = l->edges.count;
}

dig_status look_view(const Look *l, View **out)
{
    const LookScene *scene = look_scene(l);
    Kept *k = calloc(1, sizeof *k);
    *out = NULL;
    if (!k)
        return DIG_E_MEMORY;
    View *v = &k->view;
    Making m = {.l = l, .origin = look_origin(scene), .to = &k->lists};
    v->origin[0] = m.origin.x;
    v->origin[1] = m.origin.y;
    v->origin[2] = m.origin.z;
    v->time = scene->time;
    v->step = scene->step;
    v->seed = scene->seed;
    write_point(&m, v->low, scene->low);
    write_point(&m, v->high, scene->high);
    write_vec(v->up, vec3_unit_or(vec3_neg(scene->gravity), (vec3){0, 1, 0}));
    dig_status s = make_all(&m);
    show(k);
    free(m.stress);
    free(m.mesh);
    if (s == DIG_OK)
        *out = v;
    else
        dig_view_free(v);
    return s;
}

dig_status dig_view_take(const dig_world *w, View **out)
{
    Look l = {0};
    *out = NULL;
    dig_status s = look_take(&l, w);
    if (s == DIG_OK)
        s = look_view(&l, out);
    look_close(&l);
    return s == DIG_OK ? s : world_fail(w, s, "not enough memory for a picture");
}

void dig_view_free(View *v)
{
    if (!v)
        return;
    for (int i = 0; i < v->mesh_count; i++) {
        free(v->meshes[i].vertices);
        free(v->meshes[i].normals);
        free(v->meshes[i].indices);
    }
    Lists *l = &((Kept *)v)->lists;
    list_close(&l->meshes);
    list_close(&l->items);
    list_close(&l->contacts);
    list_close(&l->lines);
    list_close(&l->arrows);
    list_close(&l->labels);
    list_close(&l->edges);
    free(v);
}
