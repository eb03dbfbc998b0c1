/* export/light.h - how the script lit its scene, from the note `light` of a replay (docs/replay.md, "Notes").
 *
 * Floor: export.
 */
#ifndef DIG_EXPORT_LIGHT_H
#define DIG_EXPORT_LIGHT_H

#include "replay/replay.h"

enum { EXPORT_LAMPS = 4 };

typedef struct ExportLamp { vec3 at, colour; real power; } ExportLamp;         /* m; linear RGB; W */

typedef struct ExportLight {
    vec3        sun;            /* direction from where it shines; the renderer's when the script says none */
    bool        shadows;
    const char *sky;            /* "clear", "overcast", "night" or "black"                */
    ExportLamp  lamps[EXPORT_LAMPS];
    int         lamp_count;
} ExportLight;

/* The light at a frame. False: nothing was noted, and *out is what the renderer takes then. */
bool export_light(const Replay *r, int frame, ExportLight *out);

#endif
