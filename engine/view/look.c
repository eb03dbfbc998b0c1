/* view/look.c - takes from a world, as it is, what a picture of it depends on. */
#include "view/look.h"

#include "world/world.h"

#include <stdlib.h>

const size_t look_row_size[LOOK_TABLES] = {
    [LOOK_SCENE] = sizeof(LookScene), [LOOK_BODIES] = sizeof(LookBody), [LOOK_POSES] = sizeof(LookPose), [LOOK_SOLIDS] = sizeof(LookSolid),
    [LOOK_JOINTS] = sizeof(LookJoint), [LOOK_LOADS] = sizeof(LookLoad), [LOOK_CONTACTS] = sizeof(LookContact),
    [LOOK_EDGES] = sizeof(LookEdge), [LOOK_ARROWS] = sizeof(LookArrow),
};

/* Rows have no padding: these are the sums of their fields. */
_Static_assert(sizeof(LookScene) == 152 && sizeof(LookBody) == 120 && sizeof(LookPose) == 112 && sizeof(LookSolid) == 96 &&
               sizeof(LookJoint) == 160 && sizeof(LookLoad) == 16 && sizeof(LookContact) == 36 && sizeof(LookEdge) == 32 &&
               sizeof(LookArrow) == 40, "a row has padding");

dig_status look_resize(Look *l, LookTable t, int count)
{
    ListAny *list = &l->tables[t];
    DIG_TRY(list_reserve_any(&list->data, &list->capacity, look_row_size[t], count, NULL));
    if (count > list->count)
        memset((char *)list->data + (size_t)list->count * look_row_size[t], 0, (size_t)(count - list->count) * look_row_size[t]);
    list->count = count;
    return DIG_OK;
}

/* One more row, which the caller fills. NULL: no memory. */
static inline void *add_row(Look *l, LookTable t)
{
    ListAny *list = &l->tables[t];
    if (list->count < list->capacity)
        list->count++;
    else if (list_push_any(&list->data, &list->count, &list->capacity, look_row_size[t], NULL) != DIG_OK)
        return NULL;
    return (char *)list->data + (size_t)(list->count - 1) * look_row_size[t];
}

vec3 look_origin(const LookScene *s)
{
    if (!(s->low.x <= s->high.x))
        return vec3_zero();
    vec3 m = vec3_scale(0.5, vec3_add(s->low, s->high));
    /* near the world's origin floats do well enough: stay there; else round, so that still things stay still */
    return vec3_length(m) < 1000 ? vec3_zero() : (vec3){round(m.x), round(m.y), round(m.z)};
}

static void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* ---- the scene ---- */

/* Is all of a body inside the box, by the sphere about its centre of mass? Then its shapes do not make the box larger. */
static bool encloses(const box3 *all, const Body *b)
{
    const real spare = 1e-9;        /* m and share, for what rounding may add to a shape's bounds */
    real r = b->outer * (1 + spare) + spare;
    return b->x.x - r >= all->low.x && b->x.x + r <= all->high.x && b->x.y - r >= all->low.y && b->x.y + r <= all->high.y &&
           b->x.z - r >= all->low.z && b->x.z + r <= all->high.z;
}

static box3 with_solid(box3 all, const World *w, const Solid *s) { return box3_union(all, s->form->shape.type->bounds(&s->form->shape, solid_pose(w, s))); }

static bool has_end(const Solid *s) { return s->alive && isfinite(s->form->shape.outer); }

/* The bounds of the shapes whose bodies lie farthest out along each axis: they enclose most others. */
static box3 outermost(const World *w)
{
    box3 all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    const Solid *ends[6] = {NULL};
    vec3 low = all.low, high = all.high;
    for (int i = 0; i < w->solids.count; i++) {
        const Solid *s = &w->solids.data[i];
        if (s->body == NONE || !has_end(s))
            continue;
        vec3 x = w->bodies.data[s->body].x;
        if (x.x < low.x) { low.x = x.x; ends[0] = s; }
        if (x.y < low.y) { low.y = x.y; ends[1] = s; }
        if (x.z < low.z) { low.z = x.z; ends[2] = s; }
        if (x.x > high.x) { high.x = x.x; ends[3] = s; }
        if (x.y > high.y) { high.y = x.y; ends[4] = s; }
        if (x.z > high.z) { high.z = x.z; ends[5] = s; }
    }
    for (int k = 0; k < 6; k++)
        all = ends[k] ? with_solid(all, w, ends[k]) : all;
    return all;
}

static dig_status take_scene(Look *l, const World *w)
{
    box3 all = outermost(w);
    for (int i = 0; i < w->solids.count; i++) {
        const Solid *s = &w->solids.data[i];
        if (has_end(s) && (s->body == NONE || !encloses(&all, &w->bodies.data[s->body])))
            all = with_solid(all, w, s);
    }
    DIG_TRY(look_resize(l, LOOK_SCENE, 1));
    *look_scene(l) = (LookScene){.time = world_time(w), .step = w->steps, .seed = (uint64_t)w->def.seed, .low = all.low, .high = all.high,
                                 .gravity = w->def.gravity, .has_room = w->has_room};
    if (w->has_room) {
        look_scene(l)->room_size = w->room.size;
        look_scene(l)->room_at = w->room.at;
        for (int i = 0; i < 6; i++)
            look_scene(l)->open_walls |= (uint32_t)(w->room_solid[i] == NONE) << i;
    }
    return DIG_OK;
}

/* ---- bodies ---- */

static void take_body(LookBody *row, const World *w, const Body *b)
{
    const BodyRest *rest = body_rest(w, b);
    *row = (LookBody){.there = 1, .gen = b->gen - w->gen_start + 1, .index = row->index, .kind = (uint8_t)b->kind,
                      .labelled = rest->name[0] && isfinite(b->outer), .centre = b->centre, .sheet = (uint32_t)rest->sheet.x,
                      .column = (uint32_t)rest->sheet.y, .row = (uint32_t)rest->sheet.z};
    memcpy(row->name, rest->name, strlen(rest->name));
}

static void take_pose(LookPose *row, const World *w, const Body *b, uint32_t slot)
{
    *row = (LookPose){.x = b->x, .q = b->q, .dig = graph_of(w->graph, slot), .awake = b->awake, .mode = (uint8_t)b->mode};
    write_vec(row->v, b->v);
    write_vec(row->w, b->w);
    write_vec(row->force, b->force);
}

/* The effect that begins with the temperature (effect/heat.h); NULL: there is none. */
static const Column *heat_of(const World *w)
{
    for (int i = 0; i < w->effect_count; i++)
        if (w->effects[i].on && strcmp(w->effects[i].name, "heat") == 0)
            return &w->effects[i].members;
    return NULL;
}

static dig_status take_bodies(Look *l, const World *w, bool same)
{
    const Column *heat = heat_of(w);
    DIG_TRY(look_resize(l, LOOK_BODIES, w->bodies.count));
    DIG_TRY(look_resize(l, LOOK_POSES, w->bodies.count));
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        if (!b->alive) {
            look_bodies(l)[i] = (LookBody){0};
            look_poses(l)[i] = (LookPose){0};
            continue;
        }
        if (!same)
            take_body(&look_bodies(l)[i], w, b);
        take_pose(&look_poses(l)[i], w, b, (uint32_t)i);
        const real *degrees = heat ? column_find(heat, (uint32_t)i) : NULL;
        look_poses(l)[i].temperature = degrees ? degrees[0] : 0;
    }
    return DIG_OK;
}

/* ---- shapes ---- */

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

static dig_status make_mesh(LookMesh *m, const Shape *s)
{
    ShapeMesh made = {0};
    m->shape = shape_keep(s);
    m->mesh.form = form_of(s->type->name);
    write_size(s, m->mesh.form, m->mesh.size);
    if (m->mesh.form == VIEW_PLANE) {
        const PlaneData *d = s->data;
        m->normal = d->normal;
        m->offset = d->offset;
        return DIG_OK;
    }
    DIG_TRY(s->type->mesh(s, &made));
    m->mesh.vertex_count = made.vertex_count;
    m->mesh.index_count = made.index_count;
    m->mesh.vertices = made.vertices;
    m->mesh.normals = made.normals;
    m->mesh.indices = made.indices;
    return DIG_OK;
}

/* Shapes that share their data share their mesh. A reference is kept to the data, so its address stays its own. */
static dig_status find_mesh(Look *l, const Shape *s, uint32_t *index)
{
    MapKey key = map_key((uint64_t)(uintptr_t)s->data);
    if (*index < (uint32_t)l->meshes.count && l->meshes.data[*index].shape.data == s->data)
        return DIG_OK;
    if (map_find(&l->known, key, index))
        return DIG_OK;
    DIG_TRY(list_push(&l->meshes, NULL));
    *index = (uint32_t)l->meshes.count - 1;
    dig_status status = make_mesh(&l->meshes.data[*index], s);
    return status == DIG_OK ? map_put(&l->known, key, *index) : status;
}

static int pattern_of(const char *name)
{
    static const char *const names[] = {"plain", "wood", "brick", "tile", "stripe", "check"};
    for (int i = 0; i < 6; i++)
        if (names[i][0] == name[0] && strcmp(names[i], name) == 0)
            return i;
    return PATTERN_PLAIN;
}

static dig_status take_solid(Look *l, const World *w, const Solid *s, LookSolid *row)
{
    const Body *b = s->body == NONE ? NULL : &w->bodies.data[s->body];
    const dig_material_def *m = &w->materials.data[s->form->surface.material].def;
    bool own = s->form->colour.x >= 0, body_own = b && body_make(b)->colour.x >= 0;
    bool plain = (own || body_own) && strcmp(m->pattern.s, "stripe") != 0;
    uint32_t mesh = row->there ? row->mesh : LOOK_NONE;
    DIG_TRY(find_mesh(l, &s->form->shape, &mesh));
    *row = (LookSolid){.there = 1, .body = s->body, .mesh = mesh, .at = s->form->at, .roughness = (float)m->roughness, .metallic = (float)m->metallic,
                       .clear = b ? (float)(1 - body_make(b)->opacity) : 0,
                       .pattern = plain ? PATTERN_PLAIN : (uint32_t)pattern_of(m->pattern.s)};
    write_vec(row->colour, own ? s->form->colour : body_own ? body_make(b)->colour : m->colour);
    return DIG_OK;
}

static dig_status take_solids(Look *l, const World *w)
{
    DIG_TRY(look_resize(l, LOOK_SOLIDS, w->solids.count));
    for (int i = 0; i < w->solids.count; i++) {
        const Solid *s = &w->solids.data[i];
        if (s->alive && !s->wall)           /* the room's walls: room.c */
            DIG_TRY(take_solid(l, w, s, &look_solids(l)[i]));
        else
            look_solids(l)[i] = (LookSolid){0};
    }
    return DIG_OK;
}

/* ---- joints ---- */

/* Bodies on joints of these types show how much they bear, even nothing. */
static bool gives(const char *type) { return strcmp(type, "strut") == 0 || strcmp(type, "beam") == 0; }

/* m  Of a bar or coil that shows a joint between two points: by the smaller body that it holds, and by its length. 0: it is not shown. */
static real radius_shown(const World *w, const JointRec *j, dig_joint handle, const char *type)
{
    static const struct { const char *type; real of_body, of_length; } shown[] = {{"rope", 0.06, 0.01}, {"distance", 0.06, 0.01}, {"spring", 0.35, 0.07}};
    const Body *a = &w->bodies.data[j->a], *b = j->b == NONE ? NULL : &w->bodies.data[j->b];
    real length = NAN;
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
        if (strcmp(type, shown[i].type) != 0)
            continue;
        real body = real_min(isfinite(a->outer) ? a->outer : 1, b && isfinite(b->outer) ? b->outer : 1) * shown[i].of_body;
        bool known = dig_joint_param(w, handle, "length", &length) == DIG_OK && length > 1e-6;
        return known ? real_min(body, length * shown[i].of_length) : body;
    }
    return 0;
}

static void take_joint(const World *w, uint32_t slot, LookJoint *row, LookLoad *load)
{
    const JointRec *j = &w->joints.data[slot];
    dig_joint handle = joint_handle(w, slot);
    dig_joint_state s;
    real radius;
    *row = (LookJoint){.there = 1, .gen = j->gen - w->gen_start + 1, .a = j->a, .b = j->b, .drawn = j->other[0] == NONE, .ra = j->ra, .rb = j->rb};
    *load = (LookLoad){.stress = -1};
    write_vec(load->force, j->force);
    memcpy(row->name, j->name, strlen(j->name));
    if (dig_joint_get(w, handle, &s) != DIG_OK)
        return;
    memcpy(row->type, s.type, strlen(s.type) < sizeof row->type ? strlen(s.type) : sizeof row->type - 1);
    if (s.stress > 0 || gives(s.type))
        load->stress = (float)s.stress;
    if (strcmp(s.type, "strut") == 0 && dig_joint_param(w, handle, "radius", &radius) == DIG_OK && radius > 0)
        row->radius = radius;
    row->radius = row->radius > 0 ? row->radius : radius_shown(w, j, handle, s.type);
}

static dig_status take_joints(Look *l, const World *w)
{
    DIG_TRY(look_resize(l, LOOK_JOINTS, w->joints.count));
    DIG_TRY(look_resize(l, LOOK_LOADS, w->joints.count));
    for (int i = 0; i < w->joints.count; i++) {
        if (w->joints.data[i].alive) {
            take_joint(w, (uint32_t)i, &look_joints(l)[i], &look_loads(l)[i]);
        } else {
            look_joints(l)[i] = (LookJoint){0};
            look_loads(l)[i] = (LookLoad){0};
        }
    }
    return DIG_OK;
}

/* ---- contacts, pushes ---- */

static dig_status take_contacts(Look *l, const World *w, vec3 origin)
{
    l->tables[LOOK_CONTACTS].count = 0;
    if (w->pairs.count == 0)
        return DIG_OK;
    const Pair *pairs = w->pairs.data, *end = pairs + w->pairs.count;
    for (const Pair *p = pairs; p < end; p++) {
        contacts_fetch(w, p, end);
        if (!p->touching || !p->alive)
            continue;
        for (uint32_t c = p->contact; c != NONE; c = w->contacts.data[c].next) {
            const Contact *contact = &w->contacts.data[c];
            for (int k = 0; contact->touching && k < contact->count; k++) {
                const ContactPoint *at = contact_point_seen(w, contact, k);
                const PointMemory *m = &at->memory;
                LookContact *out = m->normal > 0 ? add_row(l, LOOK_CONTACTS) : NULL;
                if (!(m->normal > 0))
                    continue;
                if (!out)
                    return DIG_E_MEMORY;
                write_vec(out->p, vec3_sub(at->at.a, origin));
                write_vec(out->n, contact->normal);
                write_vec(out->force, vec3_mad(m->tangent, m->normal, contact->normal));
            }
        }
    }
    return DIG_OK;
}

static dig_status take_arrows(Look *l, const World *w)
{
    l->tables[LOOK_ARROWS].count = 0;
    for (int i = 0; i < w->pushes.count; i++) {
        const Push *p = &w->pushes.data[i];
        const Body *b = &w->bodies.data[p->body];
        if (!(vec3_length2(p->force) > 0))
            continue;
        LookArrow *a = add_row(l, LOOK_ARROWS);
        if (!a)
            return DIG_E_MEMORY;
        a->spare = 0;
        a->p = p->has_at ? vec3_add(b->x, quat_rotate(b->q, p->at)) : b->x;
        write_vec(a->v, p->force);
    }
    return DIG_OK;
}

/* ---- links ---- */

typedef struct Middle { vec3 sum; int count; } Middle;

static void add_pair(const World *w, const Pair *p, Middle *m)
{
    for (uint32_t c = p->contact; p->touching && c != NONE; c = w->contacts.data[c].next)
        if (w->contacts.data[c].touching) {
            m->sum = vec3_add(m->sum, w->contacts.data[c].point);
            m->count++;
        }
}

/* Where a body touches another: the middle of the touching contacts; its own centre when there is none. */
static vec3 touching_point(const World *w, uint32_t body, uint32_t other)
{
    Middle m = {vec3_zero(), 0};
    uint32_t pair;
    if (other != NONE && pair_between(w, body, other, &pair)) {
        if (pair != NONE)
            add_pair(w, &w->pairs.data[pair], &m);
    } else {
        for (uint32_t s = w->bodies.data[body].shape_first; s != NONE; s = w->solids.data[s].next)
            for (uint32_t l = w->solids.data[s].pair_first; l != NONE; l = w->pairs.data[l / 2].next[l % 2]) {
                const Pair *p = &w->pairs.data[l / 2];
                if (p->body_a == other || p->body_b == other)
                    add_pair(w, p, &m);
            }
    }
    return m.count > 0 ? vec3_scale(1 / (real)m.count, m.sum) : w->bodies.data[body].x;
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

static dig_status take_layer(Look *look, const World *w, uint32_t layer, vec3 origin)
{
    const Graph *g = layer_graph(w, layer);
    for (int i = 0; g && i < w->bodies.count; i++) {
        if (!w->bodies.data[i].alive || !graph_has_node(g, (uint32_t)i))
            continue;
        uint32_t dig = graph_of(g, (uint32_t)i);
        for (uint32_t l = graph_link_first(g, (uint32_t)i); l != NONE; l = graph_link_next(g, (uint32_t)i, l)) {
            const GraphLink *link = graph_link(g, l);
            if (link->a != (uint32_t)i)
                continue;
            LookEdge *e = add_row(look, LOOK_EDGES);
            if (!e)
                return DIG_E_MEMORY;
            *e = (LookEdge){.a = link->a, .b = link->b, .dig = dig, .link = l, .kind = link->kind, .layer = (uint8_t)layer, .bound = link->bound};
            if (link->bound)
                write_vec(e->end, vec3_sub(bound_end(w, layer, link), origin));
        }
    }
    return DIG_OK;
}

static dig_status take_all(Look *l, const World *w, bool same)
{
    DIG_TRY(take_scene(l, w));
    vec3 origin = look_origin(look_scene(l));
    DIG_TRY(take_bodies(l, w, same));
    if (!same)
        DIG_TRY(take_solids(l, w));
    DIG_TRY(take_joints(l, w));
    DIG_TRY(take_contacts(l, w, origin));
    DIG_TRY(take_arrows(l, w));
    l->tables[LOOK_EDGES].count = 0;
    for (uint32_t layer = 0; layer < DIG_LAYERS; layer++)
        DIG_TRY(take_layer(l, w, layer, origin));
    return DIG_OK;
}

dig_status look_take(Look *l, const dig_world *w) { return take_all(l, w, false); }

static bool same_bodies(const Look *l, const World *w)
{
    if (look_count(l, LOOK_BODIES) != w->bodies.count || look_count(l, LOOK_SOLIDS) != w->solids.count)
        return false;
    for (int i = 0; i < w->bodies.count; i++) {
        const Body *b = &w->bodies.data[i];
        const LookBody *row = &look_bodies(l)[i];
        if (b->alive != (row->there != 0) || (b->alive && b->gen - w->gen_start + 1 != row->gen))
            return false;
    }
    return true;
}

dig_status look_take_moving(Look *l, const dig_world *w, bool *same)
{
    *same = same_bodies(l, w);
    return take_all(l, w, *same);
}

/* ---- is it still so? ---- */

static bool same_body(const World *w, const Body *b, const LookBody *row, const LookPose *p)
{
    if (b->alive != (row->there != 0) || !b->alive)
        return b->alive == (row->there != 0);
    return b->gen - w->gen_start + 1 == row->gen && memcmp(&b->x, &p->x, sizeof b->x) == 0 && memcmp(&b->q, &p->q, sizeof b->q) == 0 &&
           b->awake == (p->awake != 0) && (float)b->v.x == p->v[0] && (float)b->v.y == p->v[1] && (float)b->v.z == p->v[2] &&
           memcmp(body_name(w, b), row->name, sizeof row->name) == 0;
}

bool look_holds(const Look *l, const dig_world *w)
{
    int joints = 0;
    if (look_count(l, LOOK_SCENE) != 1 || look_count(l, LOOK_BODIES) != w->bodies.count || look_count(l, LOOK_SOLIDS) != w->solids.count ||
        look_count(l, LOOK_JOINTS) != w->joints.count || w->pushes.count > 0 || look_scene(l)->has_room != (uint32_t)w->has_room ||
        memcmp(&look_scene(l)->gravity, &w->def.gravity, sizeof(vec3)) != 0)
        return false;
    for (int i = 0; i < w->bodies.count; i++)
        if (!same_body(w, &w->bodies.data[i], &look_bodies(l)[i], &look_poses(l)[i]))
            return false;
    for (int i = 0; i < w->joints.count; i++)
        joints += w->joints.data[i].alive != (look_joints(l)[i].there != 0);
    return joints == 0;
}

/* ---- the tables ---- */

dig_status look_copy_tables(Look *to, const Look *from)
{
    for (int t = 0; t < LOOK_TABLES; t++) {
        DIG_TRY(look_resize(to, (LookTable)t, from->tables[t].count));
        if (from->tables[t].count > 0)
            memcpy(to->tables[t].data, from->tables[t].data, (size_t)from->tables[t].count * look_row_size[t]);
    }
    return DIG_OK;
}

void look_close(Look *l)
{
    for (int t = 0; t < LOOK_TABLES; t++)
        list_free_any(&l->tables[t].data, &l->tables[t].count, &l->tables[t].capacity, look_row_size[t]);
    for (int i = 0; i < l->meshes.count; i++) {
        free(l->meshes.data[i].mesh.vertices);
        free(l->meshes.data[i].mesh.normals);
        free(l->meshes.data[i].mesh.indices);
        shape_free(&l->meshes.data[i].shape);
    }
    list_close(&l->meshes);
    map_close(&l->known);
    *l = (Look){0};
}
