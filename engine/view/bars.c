/* view/bars.c - joints that are seen: struts, ropes and rods between two points as bars, springs as coils. */
#include "view/making.h"

#include <stdlib.h>

enum { PRISM = 10 };        /* sides of a bar */

/* An upright prism: a cylinder, for who draws triangles only. */
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

/* ---- coils ---- */

enum { TURNS = 8, RINGS = 14 * TURNS, WIRE = 5, LEADS = 2 };    /* rings along the wire, sides of it; parts of a turn in which it comes from the axis */
static const float WIRE_PART = 0.18f;       /* of the radius of the coil */

/* Point i of the wire's middle, and its axes across. */
static vec3 coil_point(real radius, real length, int i, vec3 *out, vec3 *up)
{
    real s = (real)i / RINGS, angle = 2 * DIG_PI * TURNS * s, lead = real_min(1, real_min(s, 1 - s) * TURNS * LEADS), r = radius * lead;
    *out = (vec3){cos(angle), 0, sin(angle)};
    *up = vec3_cross(vec3_unit((vec3){-r * sin(angle), length / (2 * DIG_PI * TURNS), r * cos(angle)}), *out);
    return (vec3){r * cos(angle), (s - 0.5) * length, r * sin(angle)};
}

/* About the y axis, as a bar of that radius would be. */
static dig_status coil_mesh(ViewMesh *m, float radius, float length)
{
    *m = (ViewMesh){.form = VIEW_MESH, .size = {radius, length}, .vertex_count = (RINGS + 1) * WIRE, .index_count = 6 * RINGS * WIRE};
    m->vertices = malloc((size_t)(3 * m->vertex_count) * sizeof *m->vertices);
    m->normals = malloc((size_t)(3 * m->vertex_count) * sizeof *m->normals);
    m->indices = malloc((size_t)m->index_count * sizeof *m->indices);
    if (!m->vertices || !m->normals || !m->indices)
        return DIG_E_MEMORY;
    uint32_t *out = m->indices;
    for (uint32_t i = 0; i <= RINGS; i++) {
        vec3 aside, up, middle = coil_point((real)radius, (real)length, (int)i, &aside, &up);
        for (uint32_t k = 0; k < WIRE; k++) {
            real turn = 2 * DIG_PI * k / WIRE;
            vec3 n = vec3_mad(vec3_scale(cos(turn), aside), sin(turn), up);
            write_vec(m->normals + (size_t)3 * (i * WIRE + k), n);
            write_vec(m->vertices + (size_t)3 * (i * WIRE + k), vec3_mad(middle, (real)(WIRE_PART * radius), n));
            uint32_t a = i * WIRE + k, b = i * WIRE + (k + 1) % WIRE;
            const uint32_t side[6] = {a, b, a + WIRE, b, b + WIRE, a + WIRE};
            if (i < RINGS)
                memcpy(out, side, sizeof side);
            out += i < RINGS ? 6 : 0;
        }
    }
    return DIG_OK;
}

/* ---- how they look ---- */

enum { MOST_COILS = 500 };      /* more springs than that are drawn as bars: each coil is a mesh of its own */

typedef struct BarLook { const char *type; float colour[3], roughness, metallic; } BarLook;

static const BarLook bar_looks[] = {        /* the first is that of struts */
    {"", {0.30f, 0.32f, 0.35f}, 0.45f, 0}, {"rope", {0.42f, 0.31f, 0.17f}, 0.9f, 0}, {"distance", {0.45f, 0.46f, 0.48f}, 0.35f, 0.6f},
    {"spring", {0.55f, 0.57f, 0.60f}, 0.4f, 0.4f},
};

static const BarLook *look_of(const LookJoint *j)
{
    for (size_t i = 1; i < sizeof bar_looks / sizeof *bar_looks; i++)
        if (strcmp(j->type, bar_looks[i].type) == 0)
            return &bar_looks[i];
    return bar_looks;
}

static dig_status make_bar(Making *m, const LookJoint *j, float stress, int *coils)
{
    vec3 a = joint_end(m, j->a, j->ra), b = joint_end(m, j->b, j->rb);
    const LookPose *p = &look_poses(m->l)[j->a], *q = j->b == LOOK_NONE ? p : &look_poses(m->l)[j->b];
    const BarLook *look = look_of(j);
    bool coil = strcmp(look->type, "spring") == 0 && (*coils)++ < MOST_COILS;
    float length = (float)vec3_distance(a, b), radius = (float)j->radius;
    if (!(length > 1e-9f))
        return DIG_OK;
    DIG_TRY(list_push(&m->to->meshes, NULL));
    ViewMesh *mesh = &m->to->meshes.data[m->to->meshes.count - 1];
    DIG_TRY(coil ? coil_mesh(mesh, radius, length) : strut_mesh(mesh, *look->type == 's' ? 2 * WIRE_PART * radius : radius, length));
    DIG_TRY(list_push(&m->to->items, NULL));
    ViewItem *item = &m->to->items.data[m->to->items.count - 1];
    *item = (ViewItem){.joint = (uint32_t)(j - look_joints(m->l)) + 1, .mesh = m->to->meshes.count - 1, .roughness = look->roughness,
                       .metallic = look->metallic, .stress = stress, .dig = p->dig ? p->dig : q->dig, .asleep = !p->awake && !q->awake,
                       .woven = is_thread(m, j->a, j->b)};
    memcpy(item->colour, look->colour, sizeof item->colour);
    write_quat(item->q, quat_between((vec3){0, 1, 0}, vec3_unit(vec3_sub(b, a))));
    write_point(m, item->p, vec3_scale(0.5, vec3_add(a, b)));
    return DIG_OK;
}

dig_status make_bars(Making *m)
{
    int coils = 0;
    for (int i = 0; i < look_count(m->l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(m->l)[i];
        if (j->there && j->radius > 0)
            DIG_TRY(make_bar(m, j, look_loads(m->l)[i].stress, &coils));
    }
    return DIG_OK;
}
