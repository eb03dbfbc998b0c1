/* export/glb_mesh.c - shapes as glTF meshes with their materials; equal ones are written once. */
#include "export/glb.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"

/* Round shapes have normals of their own; readers make flat ones for the others. */
static bool round_normals(const ViewMesh *m, float *normals)
{
    if (m->normals) {
        memcpy(normals, m->normals, (size_t)(3 * m->vertex_count) * sizeof *normals);
        return true;
    }
    if (m->form != VIEW_SPHERE && m->form != VIEW_CAPSULE)
        return false;
    float half = m->form == VIEW_CAPSULE ? 0.5f * m->size[1] : 0;
    for (int i = 0; i < m->vertex_count; i++) {
        const float *v = &m->vertices[3 * i];
        float y = v[1] - fmaxf(-half, fminf(half, v[1])), length = sqrtf(v[0] * v[0] + y * y + v[2] * v[2]);
        const float n[3] = {length > 0 ? v[0] / length : 0, length > 0 ? y / length : 1, length > 0 ? v[2] / length : 0};
        memcpy(&normals[3 * i], n, sizeof n);
    }
    return true;
}

static int put_material(Glb *g, const ViewItem *item)
{
    int index = part_begin(&g->materials);
    const float colour[4] = {item->colour[0], item->colour[1], item->colour[2], 1 - item->clear};
    output_text(&g->materials.text, "{\"pbrMetallicRoughness\":{");
    glb_numbers(&g->materials.text, "baseColorFactor", colour, 4);
    output_text(&g->materials.text, ",\"metallicFactor\":%.9g,\"roughnessFactor\":%.9g}%s}", (double)item->metallic, (double)item->roughness,
                item->clear > 0 ? ",\"alphaMode\":\"BLEND\"" : "");
    return index;
}

/* A plane has no end: a square about its foot point. */
static int put_square(Glb *g, int material)
{
    float s = (float)g->reach;
    const float vertices[12] = {-s, 0, -s, -s, 0, s, s, 0, s, s, 0, -s};
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    int positions = glb_accessor(g, vertices, 4, 3, GLB_FLOAT, true, GLB_VERTICES);
    int triangles = glb_accessor(g, indices, 6, 1, GLB_UINT, false, GLB_INDICES);
    int mesh = part_begin(&g->meshes);
    output_text(&g->meshes.text, "{\"primitives\":[{\"attributes\":{\"POSITION\":%d},\"indices\":%d,\"material\":%d}]}", positions, triangles,
                material);
    return mesh;
}

static int put_mesh(Glb *g, const ViewMesh *m, int material)
{
    float *normals = malloc((size_t)(3 * m->vertex_count) * sizeof *normals);
    if (!normals) {
        output_fail(g->out, "no memory for a mesh of %d vertices", m->vertex_count);
        return -1;
    }
    int positions = glb_accessor(g, m->vertices, m->vertex_count, 3, GLB_FLOAT, true, GLB_VERTICES);
    int normal = round_normals(m, normals) ? glb_accessor(g, normals, m->vertex_count, 3, GLB_FLOAT, false, GLB_VERTICES) : -1;
    int triangles = glb_accessor(g, m->indices, m->index_count, 1, GLB_UINT, false, GLB_INDICES);
    int mesh = part_begin(&g->meshes);
    output_text(&g->meshes.text, "{\"primitives\":[{\"attributes\":{\"POSITION\":%d", positions);
    if (normal >= 0)
        output_text(&g->meshes.text, ",\"NORMAL\":%d", normal);
    output_text(&g->meshes.text, "},\"indices\":%d,\"material\":%d}]}", triangles, material);
    free(normals);
    return mesh;
}

static uint64_t hash_of(const ViewMesh *m)
{
    uint64_t h = hash_bytes(HASH_START, m->size, sizeof m->size);
    if (m->vertices)
        h = hash_bytes(h, m->vertices, (size_t)(3 * m->vertex_count) * sizeof *m->vertices);
    if (m->indices)
        h = hash_bytes(h, m->indices, (size_t)m->index_count * sizeof *m->indices);
    return h;
}

int glb_mesh(Glb *g, const View *v, const ViewItem *item)
{
    const ViewMesh *m = &v->meshes[item->mesh];
    if (m->form != VIEW_PLANE && (m->vertex_count == 0 || m->index_count == 0))
        return -1;
    GlbMesh want = {.hash = hash_of(m), .roughness = item->roughness, .metallic = item->metallic, .clear = item->clear, .form = (int)m->form,
                    .vertices = m->vertex_count, .indices = m->index_count};
    memcpy(want.colour, item->colour, sizeof want.colour);
    memcpy(want.size, m->size, sizeof want.size);
    for (int i = 0; i < g->known.count; i++) {
        want.mesh = g->known.data[i].mesh;
        if (memcmp(&want, &g->known.data[i], sizeof want) == 0)
            return want.mesh;
    }
    int material = put_material(g, item);
    want.mesh = m->form == VIEW_PLANE ? put_square(g, material) : put_mesh(g, m, material);
    if (list_push(&g->known, NULL) != DIG_OK)
        output_fail(g->out, "no memory for the meshes");
    else
        g->known.data[g->known.count - 1] = want;
    return want.mesh;
}
