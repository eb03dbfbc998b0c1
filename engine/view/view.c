/* view/view.c - takes the picture: poses, meshes, contacts, links of a world, as floats about the scene's middle. */
#include "view/view.h"

#include "base/list.h"
#include "world/world.h"

#include <stdlib.h>

typedef struct Taking {
    const World *w;
    View        *v;
    vec3         origin;
    const Column *heat;         /* of the effect that begins with the temperature, effect/heat.h; NULL: there is none */
    float       *stress;                    /* [bodies] */
    LIST(ViewItem)    items;
    LIST(ViewMesh)    meshes;
    LIST(ViewContact) contacts;
    LIST(ViewLine)    lines;
    LIST(ViewArrow)   arrows;
    LIST(ViewLabel)   labels;
    LIST(ViewEdge)    edges;
} Taking;

static void write_point(const Taking *t, float out[3], vec3 p)
{
    vec3 d = vec3_sub(p, t->origin);
    out[0] = (float)d.x;
    out[1] = (float)d.y;
    out[2] = (float)d.z;
}

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static ViewForm form_of(const char *type)
{
    static const struct { const char *name; ViewForm form; } forms[] = {
        {"sphere", VIEW_SPHERE}, {"box", VIEW_BOX}, {"capsule", VIEW_CAPSULE}, {"cylinder", VIEW_CYLINDER}, {"cone", VIEW_CONE}, {"plane", VIEW_PLANE},
    };
    for (size_t i = 0; i < sizeof forms / sizeof forms[0]; i++)
        if (strcmp(forms[i].name, type) == 0)
            return forms[i].form;
    return VIEW_MESH;
}

/* Sizes from the shape's bounds at rest: full extents, or radius and height of what stands along y. */
static void write_size(const Shape *s, ViewForm form, float size[3])
{
    box3 b = s->type->bounds(s, pose_identity());
    vec3 e = vec3_sub(b.high, b.low);
    real radius = 0.5 * e.x;
    switch (form) {
    case VIEW_BOX: write_vec(size, e); break;
    case VIEW_SPHERE: size[0] = (float)radius; break;
    case VIEW_CAPSULE: size[0] = (float)radius; size[1] = (float)(e.y - 2 * radius); break;
    case VIEW_CYLINDER: case VIEW_CONE: size[0] = (float)radius; size[1] = (float)e.y; break;
    case VIEW_PLANE: case VIEW_MESH: break;
    }
}

/* Shapes that share their data share their mesh. */
static dig_status mesh_for(Taking *t, const Shape *s, const void **known, int *index)
{
    for (int i = 0; i < t->meshes.count; i++)
        if (known[i] == s->data) {
            *index = i;
            return DIG_OK;
        }
    DIG_TRY(list_push(&t->meshes, NULL));
    *index = t->meshes.count - 1;
    ViewMesh *m = &t->meshes.data[*index];
    known[*index] = s->data;
    m->form = form_of(s->type->name);
    write_size(s, m->form, m->size);
    if (m->form == VIEW_PLANE)
        return DIG_OK;
    ShapeMesh mesh = {0};
    DIG_TRY(s->type->mesh(s, &mesh));
    m->vertex_count = mesh.vertex_count;
    m->index_count = mesh.index_count;
    m->vertices = mesh.vertices;
    m->normals = mesh.normals;
    m->indices = mesh.indices;
    return DIG_OK;
}

static int pattern_of(const char *name)
{
    static const char *const names[] = {"plain", "wood", "brick", "tile", "stripe", "check"};
    for (int i = 0; i < 6; i++)
        if (strcmp(names[i], name) == 0)
            return i;
    return PATTERN_PLAIN;
}

/* A plane is drawn about its foot point, +y along its normal. */
static pose plane_pose(const Solid *s, pose at)
{
    const PlaneData *d = s->shape.data;
    vec3 n = quat_rotate(at.q, d->normal);
    return (pose){vec3_mad(at.p, d->offset, n), quat_between((vec3){0, 1, 0}, n)};
}

static dig_status take_item(Taking *t, uint32_t slot, const void **known)
{
    const Solid *s = &t->w->solids.data[slot];
    if (s->wall)
        return DIG_OK;                      /* the room's walls are drawn as edges */
    const Body *b = s->body == NONE ? NULL : &t->w->bodies.data[s->body];
    const dig_material_def *m = &t->w->materials.data[s->surface.material].def;
    int mesh;
    DIG_TRY(mesh_for(t, &s->shape, known, &mesh));
    DIG_TRY(list_push(&t->items, NULL));
    ViewItem *item = &t->items.data[t->items.count - 1];
    pose at = solid_pose(t->w, s);
    if (t->meshes.data[mesh].form == VIEW_PLANE)
        at = plane_pose(s, at);
    item->body = s->body == NONE ? 0 : s->body + 1;
    item->mesh = mesh;
    write_point(t, item->p, at.p);
    item->q[0] = (float)at.q.x;
    item->q[1] = (float)at.q.y;
    item->q[2] = (float)at.q.z;
    item->q[3] = (float)at.q.w;
    bool own = s->colour.x >= 0, body_own = b && b->colour.x >= 0;
    write_vec(item->colour, own ? s->colour : body_own ? b->colour : m->colour);
    item->roughness = (float)m->roughness;
    item->metallic = (float)m->metallic;
    item->pattern = (own || body_own) && strcmp(m->pattern.s, "stripe") != 0 ? PATTERN_PLAIN : pattern_of(m->pattern.s);
    item->dig = s->body == NONE ? 0 : graph_of(t->w->graph, s->body);
    item->stress = s->body == NONE ? -1 : t->stress[s->body];
    item->asleep = b && b->kind == DIG_DYNAMIC && !b->awake;
    item->fixed = !b || b->kind == DIG_STATIC;
    const real *heat = t->heat ? column_find(t->heat, s->body) : NULL;
    item->temperature = heat ? (float)heat[0] : 0;
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

static dig_status take_strut(Taking *t, const JointRec *j, real radius, real stress)
{
    vec3 a = vec3_add(t->w->bodies.data[j->a].x, quat_rotate(t->w->bodies.data[j->a].q, j->ra));
    vec3 b = j->b == NONE ? j->rb : vec3_add(t->w->bodies.data[j->b].x, quat_rotate(t->w->bodies.data[j->b].q, j->rb));
    if (!(vec3_distance(a, b) > 1e-9))
        return DIG_OK;
    DIG_TRY(list_push(&t->meshes, NULL));
    DIG_TRY(strut_mesh(&t->meshes.data[t->meshes.count - 1], (float)radius, (float)vec3_distance(a, b)));
    DIG_TRY(list_push(&t->items, NULL));
    ViewItem *item = &t->items.data[t->items.count - 1];
    quat q = quat_between((vec3){0, 1, 0}, vec3_unit(vec3_sub(b, a)));
    *item = (ViewItem){.mesh = t->meshes.count - 1, .q = {(float)q.x, (float)q.y, (float)q.z, (float)q.w}, .colour = {0.30f, 0.32f, 0.35f},
                       .roughness = 0.45f, .stress = (float)stress, .dig = graph_of(t->w->graph, j->a),
                       .asleep = !t->w->bodies.data[j->a].awake};
    write_point(t, item->p, vec3_scale(0.5, vec3_add(a, b)));
    return DIG_OK;
}

static bool gives(const char *type) { return strcmp(type, "strut") == 0 || strcmp(type, "beam") == 0; }

static void raise_stress(Taking *t, uint32_t body, real stress)
{
    if (body != NONE && (real)t->stress[body] < stress)
        t->stress[body] = (float)stress;
}

/* Of the bodies that joints hold which can break. */
static void take_stress(Taking *t)
{
    dig_joint_state s;
    for (int i = 0; i < t->w->bodies.count; i++)
        t->stress[i] = -1;
    for (int i = 0; i < t->w->joints.count; i++) {
        const JointRec *j = &t->w->joints.data[i];
        if (!j->alive || dig_joint_get(t->w, joint_handle(t->w, (uint32_t)i), &s) != DIG_OK || !(s.stress > 0 || gives(s.type)))
            continue;
        raise_stress(t, j->a, s.stress);
        raise_stress(t, j->b, s.stress);
    }
}

static dig_status take_struts(Taking *t)
{
    dig_joint_state s;
    real radius;
    for (int i = 0; i < t->w->joints.count; i++) {
        const JointRec *j = &t->w->joints.data[i];
        dig_joint handle = joint_handle(t->w, (uint32_t)i);
        if (j->alive && dig_joint_get(t->w, handle, &s) == DIG_OK && strcmp(s.type, "strut") == 0 &&
            dig_joint_param(t->w, handle, "radius", &radius) == DIG_OK && radius > 0)
            DIG_TRY(take_strut(t, j, radius, s.stress));
    }
    return DIG_OK;
}

static dig_status take_contacts(Taking *t)
{
    for (int i = 0; i < t->w->pairs.count; i++) {
        const Pair *p = &t->w->pairs.data[i];
        if (!p->alive || !p->touching)
            continue;
        for (uint32_t c = p->contact; c != NONE; c = t->w->contacts.data[c].next) {
            const Contact *contact = &t->w->contacts.data[c];
            for (int k = 0; contact->touching && k < contact->manifold.count; k++) {
                const PointMemory *m = &contact->memory[k];
                if (!(m->normal > 0))
                    continue;
                DIG_TRY(list_push(&t->contacts, NULL));
                ViewContact *out = &t->contacts.data[t->contacts.count - 1];
                write_point(t, out->p, contact->manifold.points[k].a);
                write_vec(out->n, contact->manifold.normal);
                write_vec(out->force, vec3_mad(m->tangent, m->normal, contact->manifold.normal));
            }
        }
    }
    return DIG_OK;
}

static vec3 joint_end(const World *w, uint32_t body, vec3 anchor)
{
    if (body == NONE)
        return anchor;
    const Body *b = &w->bodies.data[body];
    return vec3_add(b->x, quat_rotate(b->q, anchor));
}

static dig_status take_line(Taking *t, vec3 a, vec3 b, vec3 colour, uint32_t dig)
{
    DIG_TRY(list_push(&t->lines, NULL));
    ViewLine *line = &t->lines.data[t->lines.count - 1];
    write_point(t, line->a, a);
    write_point(t, line->b, b);
    write_vec(line->colour, colour);
    line->dig = dig;
    return DIG_OK;
}

static dig_status take_joints(Taking *t)
{
    for (int i = 0; i < t->w->joints.count; i++) {
        const JointRec *j = &t->w->joints.data[i];
        if (!j->alive || j->other[0] != NONE)
            continue;
        vec3 a = joint_end(t->w, j->a, j->ra), b = joint_end(t->w, j->b, j->rb);
        uint32_t dig = graph_of(t->w->graph, j->a);
        DIG_TRY(take_line(t, t->w->bodies.data[j->a].x, a, (vec3){0.9, 0.7, 0.1}, dig));
        if (vec3_distance(a, b) > 1e-6)
            DIG_TRY(take_line(t, a, b, (vec3){0.75, 0.72, 0.65}, dig));
        if (j->b != NONE)
            DIG_TRY(take_line(t, b, t->w->bodies.data[j->b].x, (vec3){0.9, 0.7, 0.1}, dig));
    }
    return DIG_OK;
}

static dig_status take_room(Taking *t)
{
    if (!t->w->has_room)
        return DIG_OK;
    const dig_room_def *r = &t->w->room;
    vec3 h = vec3_scale(0.5, r->size), c = vec3_add(r->at, (vec3){0, h.y, 0});
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 4; k++) {
            real s = k & 1 ? 1 : -1, u = k & 2 ? 1 : -1;
            vec3 a = axis == 0 ? (vec3){-h.x, s * h.y, u * h.z} : axis == 1 ? (vec3){s * h.x, -h.y, u * h.z} : (vec3){s * h.x, u * h.y, -h.z};
            vec3 b = axis == 0 ? (vec3){h.x, s * h.y, u * h.z} : axis == 1 ? (vec3){s * h.x, h.y, u * h.z} : (vec3){s * h.x, u * h.y, h.z};
            DIG_TRY(take_line(t, vec3_add(c, a), vec3_add(c, b), (vec3){0.3, 0.35, 0.4}, 0));
        }
    return DIG_OK;
}

static dig_status take_arrows(Taking *t)
{
    for (int i = 0; i < t->w->pushes.count; i++) {
        const Push *p = &t->w->pushes.data[i];
        const Body *b = &t->w->bodies.data[p->body];
        if (!(vec3_length2(p->force) > 0))
            continue;
        DIG_TRY(list_push(&t->arrows, NULL));
        ViewArrow *a = &t->arrows.data[t->arrows.count - 1];
        write_point(t, a->p, p->has_at ? vec3_add(b->x, quat_rotate(b->q, p->at)) : b->x);
        write_vec(a->v, p->force);
        write_vec(a->colour, (vec3){0.9, 0.15, 0.1});
    }
    return DIG_OK;
}

static dig_status take_labels(Taking *t)
{
    for (int i = 0; i < t->w->bodies.count; i++) {
        const Body *b = &t->w->bodies.data[i];
        if (!b->alive || !b->name[0] || !isfinite(b->outer))
            continue;
        DIG_TRY(list_push(&t->labels, NULL));
        ViewLabel *l = &t->labels.data[t->labels.count - 1];
        write_point(t, l->p, b->x);
        memcpy(l->text, b->name, sizeof l->text);
    }
    return DIG_OK;
}

/* Where a body touches another: the middle of the touching contacts; its own centre when there is none. */
static vec3 touching_point(const World *w, uint32_t body, uint32_t other)
{
    vec3 sum = vec3_zero();
    int n = 0;
    for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next)
        for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
            const Pair *p = &w->pairs.data[l / 2];
            if (!p->touching || (p->body_a != other && p->body_b != other))
                continue;
            for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next)
                if (w->contacts.data[c].touching) {
                    sum = vec3_add(sum, w->contacts.data[c].point);
                    n++;
                }
        }
    return n > 0 ? vec3_scale(1 / (real)n, sum) : w->bodies.data[body].x;
}

/* Where a link to the outside ends: at the contact, at the joint, or at the boundary of its layer. */
static vec3 bound_end(const World *w, uint32_t layer, const GraphLink *l)
{
    if (layer != DIG_LAYER_MECHANICAL)
        return w->bodies.data[l->b].x;
    if (l->kind == DIG_LINK_CONTACT)
        return touching_point(w, l->a, l->b);
    const JointRec *r = &w->joints.data[l->user];
    const Body *b = &w->bodies.data[l->a];
    return vec3_add(b->x, quat_rotate(b->q, r->a == l->a ? r->ra : r->rb));
}

static dig_status take_layer(Taking *t, uint32_t layer)
{
    const World *w = t->w;
    const Graph *g = layer_graph(w, layer);
    for (int i = 0; g && i < w->bodies.count; i++) {
        if (!w->bodies.data[i].alive || !graph_has_node(g, (uint32_t)i))
            continue;
        for (uint32_t l = graph_link_first(g, (uint32_t)i); l != NONE; l = graph_link_next(g, (uint32_t)i, l)) {
            const GraphLink *link = graph_link(g, l);
            if (link->a != (uint32_t)i)
                continue;
            DIG_TRY(list_push(&t->edges, NULL));
            ViewEdge *e = &t->edges.data[t->edges.count - 1];
            write_point(t, e->a, w->bodies.data[link->a].x);
            write_point(t, e->b, link->bound ? bound_end(w, layer, link) : w->bodies.data[link->b].x);
            e->dig = graph_of(g, (uint32_t)i);
            e->kind = link->kind;
            e->layer = layer;
            e->bound = link->bound;
        }
    }
    return DIG_OK;
}

static dig_status take_edges(Taking *t)
{
    for (uint32_t layer = 0; layer < DIG_LAYERS; layer++)
        DIG_TRY(take_layer(t, layer));
    return DIG_OK;
}

/* Bounds of all that has an end; the origin is their middle, rounded to whole metres so that still things stay still. */
static void take_bounds(Taking *t)
{
    box3 all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < t->w->solids.count; i++) {
        const Solid *s = &t->w->solids.data[i];
        if (s->alive && isfinite(s->shape.outer))
            all = box3_union(all, s->shape.type->bounds(&s->shape, solid_pose(t->w, s)));
    }
    if (all.low.x <= all.high.x) {
        vec3 m = vec3_scale(0.5, vec3_add(all.low, all.high));
        /* near the world's origin floats do well enough: stay there */
        t->origin = vec3_length(m) < 1000 ? vec3_zero() : (vec3){round(m.x), round(m.y), round(m.z)};
    }
    write_point(t, t->v->low, all.low);
    write_point(t, t->v->high, all.high);
}

static dig_status take_all(Taking *t)
{
    const World *w = t->w;
    const void **known = calloc((size_t)w->solids.count + 1, sizeof *known);
    t->stress = malloc((size_t)(w->bodies.count + 1) * sizeof *t->stress);
    if (!known || !t->stress) {
        free(known);
        free(t->stress);
        return DIG_E_MEMORY;
    }
    take_stress(t);
    dig_status s = DIG_OK;
    for (int i = 0; i < w->solids.count && s == DIG_OK; i++)
        if (w->solids.data[i].alive)
            s = take_item(t, (uint32_t)i, known);
    free(known);
    free(t->stress);
    DIG_TRY(s);
    DIG_TRY(take_struts(t));
    DIG_TRY(take_contacts(t));
    DIG_TRY(take_joints(t));
    DIG_TRY(take_room(t));
    DIG_TRY(take_arrows(t));
    DIG_TRY(take_labels(t));
    return take_edges(t);
}

static void hand_over(Taking *t)
{
    View *v = t->v;
    v->items = t->items.data;       v->item_count = t->items.count;
    v->meshes = t->meshes.data;     v->mesh_count = t->meshes.count;
    v->contacts = t->contacts.data; v->contact_count = t->contacts.count;
    v->lines = t->lines.data;       v->line_count = t->lines.count;
    v->arrows = t->arrows.data;     v->arrow_count = t->arrows.count;
    v->labels = t->labels.data;     v->label_count = t->labels.count;
    v->edges = t->edges.data;       v->edge_count = t->edges.count;
}

dig_status dig_view_take(const dig_world *w, View **out)
{
    *out = NULL;
    View *v = calloc(1, sizeof *v);
    if (!v)
        return world_fail(w, DIG_E_MEMORY, "not enough memory for a picture");
    Taking t = {.w = w, .v = v};
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, "heat") == 0 && w->effects[i].on)
            t.heat = &w->effects[i].members;
    take_bounds(&t);
    v->origin[0] = t.origin.x;
    v->origin[1] = t.origin.y;
    v->origin[2] = t.origin.z;
    v->time = world_time(w);
    v->step = w->steps;
    v->seed = (uint64_t)w->def.seed;
    write_vec(v->up, vec3_unit_or(vec3_neg(w->def.gravity), (vec3){0, 1, 0}));
    dig_status s = take_all(&t);
    hand_over(&t);
    if (s != DIG_OK) {
        dig_view_free(v);
        return world_fail(w, s, "not enough memory for a picture");
    }
    *out = v;
    return DIG_OK;
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
    free(v->meshes);
    free(v->items);
    free(v->contacts);
    free(v->lines);
    free(v->arrows);
    free(v->labels);
    free(v->edges);
    free(v);
}
