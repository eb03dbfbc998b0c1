/* export/glb_scene.c - cameras, the sun and lamps, from what the script noted of them (docs/replay.md, "Notes"). */
#include "export/glb.h"
#include "export/light.h"

#include <stdio.h>

#include "math/quat.h"

#define LUMENS_PER_WATT 12.0    /* of a filament lamp */
#define SUN_LUX 3.0             /* readers show 1 to 10 as daylight at their usual exposure */

/* glTF looks along -z of the node, up is +y. */
static quat looking(vec3 along, vec3 up)
{
    vec3 z = vec3_unit(vec3_neg(along)), x = vec3_cross(up, z);
    if (!(vec3_length(x) > 1e-9))
        x = vec3_cross(fabs(z.y) < 0.9 ? (vec3){0, 1, 0} : (vec3){1, 0, 0}, z);
    x = vec3_unit(x);
    vec3 y = vec3_cross(z, x);
    return quat_from_matrix((mat3){{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}});
}

static int put_node(Glb *g, const char *name, vec3 at, quat turn)
{
    int node = part_begin(&g->nodes);
    const float p[3] = {(float)at.x, (float)at.y, (float)at.z}, q[4] = {(float)turn.x, (float)turn.y, (float)turn.z, (float)turn.w};
    output_text(&g->roots.text, "%s%d", g->roots.count++ ? "," : "", node);
    output_text(&g->nodes.text, "{\"name\":");
    output_json(&g->nodes.text, name);
    output_bytes(&g->nodes.text, ",", 1);
    glb_numbers(&g->nodes.text, "translation", p, 3);
    output_bytes(&g->nodes.text, ",", 1);
    glb_numbers(&g->nodes.text, "rotation", q, 4);
    return node;
}

/* Where a camera is at the first frame; one that is placed by what it sees is left out. */
static void put_camera(Glb *g, const ReplayCamera *c, int number)
{
    char plain[32];
    if (!c->has_at || !c->has_look_at || !(vec3_distance(c->at, c->look_at) > 0))
        return;
    snprintf(plain, sizeof plain, "camera %d", number + 1);
    put_node(g, c->name[0] ? c->name : plain, c->at, looking(vec3_sub(c->look_at, c->at), c->has_up ? c->up : (vec3){0, 1, 0}));
    output_text(&g->nodes.text, ",\"camera\":%d}", part_begin(&g->cameras));
    output_text(&g->cameras.text, "{\"type\":\"perspective\",\"perspective\":{\"yfov\":%.9g,\"znear\":0.01,\"aspectRatio\":1.7777778}}", c->fov);
}

static void put_light(Glb *g, const char *type, const char *name, vec3 at, quat turn, real intensity, vec3 colour)
{
    const float rgb[3] = {(float)colour.x, (float)colour.y, (float)colour.z};
    put_node(g, name, at, turn);
    output_text(&g->nodes.text, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}}", part_begin(&g->lights));
    output_text(&g->lights.text, "{\"type\":\"%s\",\"intensity\":%.9g,", type, intensity);
    glb_numbers(&g->lights.text, "color", rgb, 3);
    output_bytes(&g->lights.text, "}", 1);
}

static void put_lights(Glb *g, const ExportLight *light)
{
    if (vec3_length(light->sun) > 0)
        put_light(g, "directional", "sun", vec3_scale(10, vec3_unit(light->sun)), looking(vec3_neg(light->sun), (vec3){0, 1, 0}), SUN_LUX,
                  (vec3){1, 1, 1});
    for (int i = 0; i < light->lamp_count; i++) {
        const ExportLamp *l = &light->lamps[i];
        put_light(g, "point", "lamp", l->at, quat_identity(), l->power * LUMENS_PER_WATT / (4 * DIG_PI), l->colour);
    }
}

void glb_scene(Glb *g)
{
    const ReplayCamera *cameras;
    ExportLight light;
    int count = 0;
    if (replay_cameras(g->r, g->options->first, false, &cameras, &count) == DIG_OK)
        for (int i = 0; i < count; i++)
            put_camera(g, &cameras[i], i);
    if (export_light(g->r, g->options->first, &light))
        put_lights(g, &light);
}
