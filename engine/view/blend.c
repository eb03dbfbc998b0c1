/* view/blend.c - a picture between two steps, for films: frame times never touch the physics. */
#include "view/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ViewPose *view_poses(const View *v)
{
    ViewPose *poses = malloc((size_t)(v->item_count + 1) * sizeof *poses);
    for (int i = 0; poses && i < v->item_count; i++) {
        memcpy(poses[i].p, v->items[i].p, sizeof poses[i].p);
        memcpy(poses[i].q, v->items[i].q, sizeof poses[i].q);
    }
    return poses;
}

/* Straight line between positions; normalised linear blend between rotations, which for a step apart is within 1e-4 of the arc. */
static void blend_item(ViewItem *out, const ViewPose *a, const ViewPose *b, const float shift[3], float f)
{
    float dot = 0, length = 0;
    for (int k = 0; k < 3; k++)
        out->p[k] = (1 - f) * (a->p[k] + shift[k]) + f * b->p[k];
    for (int k = 0; k < 4; k++)
        dot += a->q[k] * b->q[k];
    for (int k = 0; k < 4; k++) {
        out->q[k] = (1 - f) * (dot < 0 ? -a->q[k] : a->q[k]) + f * b->q[k];
        length += out->q[k] * out->q[k];
    }
    for (int k = 0; k < 4 && length > 0; k++)
        out->q[k] /= sqrtf(length);
}

/* The vertices of a sheet, about its place, which is blended as any item's is. */
static void blend_sheet(ViewMesh *out, const ViewMesh *a, float f)
{
    bool both = a && a->taken && a->vertex_count == out->vertex_count;
    for (int i = 0; i < 3 * out->vertex_count; i++)
        out->vertices[i] = both ? (1 - f) * a->taken[i] + f * out->taken[i] : out->taken[i];
}

void view_blend(const View *a, const ViewPose *from, View *b, const ViewPose *to, real fraction)
{
    float shift[3];
    for (int k = 0; k < 3; k++)
        shift[k] = (float)(a->origin[k] - b->origin[k]);
    for (int i = 0; i < b->item_count; i++) {
        ViewItem *item = &b->items[i];
        memcpy(item->p, to[i].p, sizeof item->p);
        memcpy(item->q, to[i].q, sizeof item->q);
        bool same = i < a->item_count && a->items[i].body == item->body && a->items[i].mesh == item->mesh;
        ViewMesh *mesh = &b->meshes[item->mesh];
        if (same)
            blend_item(item, &from[i], &to[i], shift, (float)fraction);
        if (mesh->taken)
            blend_sheet(mesh, same ? &a->meshes[item->mesh] : NULL, (float)fraction);
    }
}
