/* view/view.c - makes the picture: poses, meshes, contacts, links, as floats about the scene's middle. */
#include "view/view.h"

#include "view/making.h"
#include "world/world.h"

#include <stdlib.h>

/* A view is the front of what owns its arrays: they can only be given back by those who know how much room they have. */
typedef struct Kept { View view; Lists lists; } Kept;

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
        to->vertices = to->normals = to->taken = NULL;
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
    item->woven = b && m->woven && m->woven[s->body];
    return DIG_OK;
}

static dig_status make_items(Making *m)
{
    for (int i = 0; i < look_count(m->l, LOOK_SOLIDS); i++)
        if (look_solids(m->l)[i].there)
            DIG_TRY(make_item(m, &look_solids(m->l)[i]));
    return DIG_OK;
}

/* ---- what joints bear ---- */

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

static dig_status make_line(Making *m, vec3 a, vec3 b, vec3 colour, uint32_t dig, bool woven)
{
    DIG_TRY(list_push(&m->to->lines, NULL));
    ViewLine *line = &m->to->lines.data[m->to->lines.count - 1];
    write_point(m, line->a, a);
    write_point(m, line->b, b);
    write_vec(line->colour, colour);
    line->dig = dig;
    line->woven = woven;
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
        bool woven = is_thread(m, j->a, j->b);
        DIG_TRY(make_line(m, look_poses(m->l)[j->a].x, a, arm, dig, woven));
        if (vec3_distance(a, b) > 1e-6)
            DIG_TRY(make_line(m, a, b, gap, dig, woven));
        if (j->b != LOOK_NONE)
            DIG_TRY(make_line(m, b, look_poses(m->l)[j->b].x, arm, dig, woven));
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
    DIG_TRY(find_quads(m));
    DIG_TRY(make_items(m));
    DIG_TRY(make_bars(m));
    DIG_TRY(make_sheets(m));
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
    v->quads = l->quads.data;       v->quad_count = l->quads.count;
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
    free(m.woven);
    map_close(&m.quads);
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
        free(v->meshes[i].taken);
    }
    Lists *l = &((Kept *)v)->lists;
    list_close(&l->meshes);
    list_close(&l->items);
    list_close(&l->contacts);
    list_close(&l->lines);
    list_close(&l->arrows);
    list_close(&l->labels);
    list_close(&l->edges);
    list_close(&l->quads);
    free(v);
}
