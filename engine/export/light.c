/* export/light.c - reads the note `light`; what is missing or makes no sense is as the renderer has it. */
#include "export/light.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

static const ExportLight usual = {.sun = {0.4, 0.8, 0.45}, .shadows = true, .sky = "clear"};

static bool read_vec3(const cJSON *o, const char *name, vec3 *v)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(o, name);
    double x[3];
    if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != 3)
        return false;
    for (int i = 0; i < 3; i++)
        if (!isfinite(x[i] = cJSON_GetNumberValue(cJSON_GetArrayItem(list, i))))
            return false;
    *v = (vec3){x[0], x[1], x[2]};
    return true;
}

static const char *known_sky(const char *name)
{
    static const char *const skies[] = {"clear", "overcast", "night", "black"};
    for (size_t i = 0; name && i < sizeof skies / sizeof *skies; i++)
        if (strcmp(skies[i], name) == 0)
            return skies[i];
    return usual.sky;
}

static void read_lamp(ExportLight *out, const cJSON *lamp)
{
    ExportLamp *l = &out->lamps[out->lamp_count];
    double power = cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(lamp, "power"));
    *l = (ExportLamp){.colour = {1, 1, 1}, .power = isfinite(power) ? power : 60};
    read_vec3(lamp, "colour", &l->colour);
    out->lamp_count += read_vec3(lamp, "at", &l->at);
}

bool export_light(const Replay *r, int frame, ExportLight *out)
{
    const char *text = replay_note(r, "light", frame, NULL);
    cJSON *note = text ? cJSON_Parse(text) : NULL;
    const cJSON *lamp;
    *out = usual;
    if (!note)
        return false;
    read_vec3(note, "sun", &out->sun);
    out->shadows = !cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(note, "shadows"));
    out->sky = known_sky(cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(note, "sky")));
    cJSON_ArrayForEach(lamp, cJSON_GetObjectItemCaseSensitive(note, "lamps"))
        if (out->lamp_count < EXPORT_LAMPS)
            read_lamp(out, lamp);
    cJSON_Delete(note);
    return true;
}
