/* export/glb_track.c - keys as samplers and channels. Constant stretches have a key at each end only. */
#include "export/glb.h"

#include <stdlib.h>
#include <string.h>

/* One property of a track, as offsets into a Key. */
typedef struct Property { const char *name; size_t at; int width; } Property;

static const float *value_of(const Key *k, const Property *p) { return (const float *)(const void *)((const char *)k + p->at); }

static bool same_value(const Key *a, const Key *b, const Property *p)
{
    return memcmp(value_of(a, p), value_of(b, p), (size_t)p->width * sizeof(float)) == 0;
}

static void put_channel(Glb *g, int node, const char *path, int times, int values, const char *interpolation)
{
    int sampler = part_begin(&g->samplers);
    output_text(&g->samplers.text, "{\"input\":%d,\"output\":%d,\"interpolation\":\"%s\"}", times, values, interpolation);
    part_begin(&g->channels);
    output_text(&g->channels.text, "{\"sampler\":%d,\"target\":{\"node\":%d,\"path\":\"%s\"}}", sampler, node, path);
}

/* Keys that a straight line between their neighbours would not give back by being constant; at least one. */
static int thin(const Keys *keys, const Property *p, int *keep)
{
    int count = 0;
    for (int i = 0; i < keys->count; i++) {
        const Key *k = &keys->data[i];
        bool inner = i > 0 && i + 1 < keys->count;
        if (!inner || !same_value(k, k - 1, p) || !same_value(k, k + 1, p))
            keep[count++] = i;
    }
    if (count == 2 && same_value(&keys->data[keep[0]], &keys->data[keep[1]], p))
        count = 1;
    return count;
}

static void put_property(Glb *g, int node, const Keys *keys, const Property *p, int *keep, float *buffer)
{
    int count = thin(keys, p, keep), width = strcmp(p->name, "scale") == 0 ? 3 : p->width;
    if (count < 2)
        return;                 /* where it always is, the node says */
    for (int i = 0; i < count; i++)
        buffer[i] = keys->data[keep[i]].time;
    int times = glb_accessor(g, buffer, count, 1, GLB_FLOAT, true, GLB_KEYS);
    for (int i = 0; i < count; i++) {
        const Key *k = &keys->data[keep[i]];
        const float stretch[3] = {k->length > 0 ? 1 : 0, k->length, k->length > 0 ? 1 : 0};
        memcpy(buffer + (size_t)i * (size_t)width, width == p->width ? value_of(k, p) : stretch, (size_t)width * sizeof *buffer);
    }
    put_channel(g, node, p->name, times, glb_accessor(g, buffer, count, width, GLB_FLOAT, false, GLB_KEYS), "LINEAR");
}

void glb_track(Glb *g, int node, Keys *keys, bool stretch)
{
    static const Property properties[] = {
        {"translation", offsetof(Key, p), 3}, {"rotation", offsetof(Key, q), 4}, {"scale", offsetof(Key, length), 1},
    };
    int *keep = malloc((size_t)(keys->count + 1) * sizeof *keep);
    float *buffer = malloc((size_t)(4 * keys->count + 4) * sizeof *buffer);
    if (!keep || !buffer)
        output_fail(g->out, "no memory for the keys of a motion");
    /* A strut's mesh has the length that it was written with. */
    float first = 1;
    for (int i = keys->count - 1; i >= 0; i--)
        first = keys->data[i].length > 0 ? keys->data[i].length : first;
    for (int i = 0; i < keys->count; i++)
        keys->data[i].length /= first;
    for (int i = 0; i < (stretch ? 3 : 2) && keep && buffer; i++)
        put_property(g, node, keys, &properties[i], keep, buffer);
    free(keep);
    free(buffer);
}

void glb_presence(Glb *g, int node, real born, real died)
{
    float times[3], scale[9];
    int count = 0;
    if (!isnan(born)) {
        times[count++] = 0;
        times[count++] = (float)born;
    } else if (!isnan(died)) {
        times[count++] = 0;
    }
    if (!isnan(died))
        times[count++] = (float)died;
    if (count < 2)
        return;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            scale[3 * i + k] = (!isnan(born) && i == 0) || (!isnan(died) && i == count - 1) ? 0 : 1;
    int input = glb_accessor(g, times, count, 1, GLB_FLOAT, true, GLB_KEYS);
    put_channel(g, node, "scale", input, glb_accessor(g, scale, count, 3, GLB_FLOAT, false, GLB_KEYS), "STEP");
}
