/* view/room.c - the room: its floor as a slab below it, its edges as thin bars. Its walls and its ceiling are seen through.
 *
 * The slab begins a little below the floor, so that a floor or a box of the script which lies there is seen in its place.
 */
#include "view/making.h"

#include <stdlib.h>

#define EDGE   0.004        /* of the largest extent: width of an edge */
#define SLAB   0.01         /* of it: thickness of the floor */
#define BELOW  1e-4         /* of it: so much the slab lies below the floor */
#define UNDER  3            /* of the walls in their order: -y */

static const float edge_colour[3] = {0.30f, 0.35f, 0.40f}, slab_colour[3] = {0.52f, 0.53f, 0.55f};

static dig_status box_mesh(Making *m, vec3 size, int *mesh)
{
    static const uint32_t faces[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    DIG_TRY(list_push(&m->to->meshes, NULL));
    *mesh = m->to->meshes.count - 1;
    ViewMesh *to = &m->to->meshes.data[*mesh];
    *to = (ViewMesh){.form = VIEW_BOX, .vertex_count = 8, .index_count = 36, .vertices = malloc(24 * sizeof *to->vertices),
                     .indices = malloc(sizeof faces)};
    if (!to->vertices || !to->indices)
        return DIG_E_MEMORY;
    write_vec(to->size, size);
    memcpy(to->indices, faces, sizeof faces);
    for (int i = 0; i < 8; i++)
        write_vec(to->vertices + 3 * i, (vec3){(i & 4 ? 0.5 : -0.5) * size.x, (i & 2 ? 0.5 : -0.5) * size.y, (i & 1 ? 0.5 : -0.5) * size.z});
    return DIG_OK;
}

static dig_status add_item(Making *m, int mesh, vec3 at, const float colour[3])
{
    DIG_TRY(list_push(&m->to->items, NULL));
    ViewItem *item = &m->to->items.data[m->to->items.count - 1];
    *item = (ViewItem){.mesh = mesh, .roughness = 0.9f, .stress = -1, .fixed = true, .room = true};
    write_point(m, item->p, at);
    write_quat(item->q, quat_identity());
    memcpy(item->colour, colour, sizeof item->colour);
    return DIG_OK;
}

/* Along an axis; k says which of the four. */
static vec3 edge_middle(vec3 half, int axis, int k)
{
    real s = k & 1 ? 1 : -1, u = k & 2 ? 1 : -1;
    return axis == 0 ? (vec3){0, s * half.y, u * half.z} : axis == 1 ? (vec3){s * half.x, 0, u * half.z} : (vec3){s * half.x, u * half.y, 0};
}

dig_status make_room(Making *m)
{
    const LookScene *r = look_scene(m->l);
    if (!r->has_room)
        return DIG_OK;
    vec3 size = r->room_size, half = vec3_scale(0.5, size), c = vec3_add(r->room_at, (vec3){0, half.y, 0});
    real large = real_max(size.x, real_max(size.y, size.z)), edge = EDGE * large;
    int mesh;
    for (int axis = 0; axis < 3; axis++) {
        DIG_TRY(box_mesh(m, (vec3){axis == 0 ? size.x + edge : edge, axis == 1 ? size.y - edge : edge, axis == 2 ? size.z - edge : edge}, &mesh));
        for (int k = 0; k < 4; k++)
            DIG_TRY(add_item(m, mesh, vec3_add(c, edge_middle(half, axis, k)), edge_colour));
    }
    if (r->open_walls & 1u << UNDER)
        return DIG_OK;
    DIG_TRY(box_mesh(m, (vec3){size.x, SLAB * large, size.z}, &mesh));
    return add_item(m, mesh, vec3_sub(r->room_at, (vec3){0, (BELOW + 0.5 * SLAB) * large, 0}), slab_colour);
}
