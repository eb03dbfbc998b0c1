/* api/command_own.c - what effects of the caller's gave back, as a part of the command that asked them.
 *
 * A log holds no functions. Each time one is asked, its answer is written behind the arguments of the command in work: a step,
 * mostly. Played, the effect stands there with functions that read the answers in the same order. Outside of commands (energies
 * that somebody looks at) nothing is written, and a played effect stores nothing.
 */
#include "api/command.h"

#include <stdio.h>

static void pack_force(Pack *p, vec3 *v)
{
    pack_real(p, &v->x);
    pack_real(p, &v->y);
    pack_real(p, &v->z);
}

/* Forces that were not set are most of them: of those, one byte. */
static void pack_part(Pack *p, dig_effect_part *part)
{
    const real *x[6] = {&part->force.x, &part->force.y, &part->force.z, &part->torque.x, &part->torque.y, &part->torque.z};
    uint8_t set = 0;
    for (int i = 0; i < 6; i++)
        if (*x[i] != 0 || signbit(*x[i]))
            set |= i < 3 ? 1 : 2;
    pack_u8(p, &set);
    if (set & 1)
        pack_force(p, &part->force);
    if (set & 2)
        pack_force(p, &part->torque);
}

dig_status command_answer(const World *w, dig_status s, const dig_effect_call *call, const char *why)
{
    Pack *p = tap_stream(w);
    if (!p)
        return DIG_OK;
    uint8_t status = (uint8_t)s;
    char text[256];
    pack_u8(p, &status);
    uint32_t count = pack_count(p, (uint32_t)call->count, 1, "parts");
    for (uint32_t i = 0; s == DIG_OK && i < count; i++)
        pack_part(p, &call->parts[i]);
    if (s != DIG_OK) {
        snprintf(text, sizeof text, "%s", why);
        pack_text(p, text, sizeof text);
    }
    return pack_good(p) ? DIG_OK : world_fail(w, DIG_E_MEMORY, "not enough memory to log what an effect gave");
}

dig_status command_answer_energy(const World *w, real energy)
{
    Pack *p = tap_stream(w);
    if (p)
        pack_real(p, &energy);
    return DIG_OK;
}

/* ---- played ---- */

static dig_status play_step(void *data, const dig_effect_call *call, char *why, size_t capacity)
{
    const World *w = data;
    Pack *p = w->playback ? w->playback->stream : NULL;
    char text[256] = "";
    if (!p) {
        snprintf(why, capacity, "of this effect there is only what was logged");
        return DIG_E_ARG;
    }
    uint8_t status = 0;
    pack_u8(p, &status);
    pack_check(p, status < DIG_STATUS_COUNT, "an effect gave an unknown status");
    uint32_t count = pack_count(p, 0, status == DIG_OK, "parts");
    pack_check(p, count == (uint32_t)call->count, "an effect was asked about other bodies");
    for (uint32_t i = 0; status == DIG_OK && pack_good(p) && i < count; i++)
        pack_part(p, &call->parts[i]);
    if (status != DIG_OK)
        pack_text(p, text, sizeof text);
    snprintf(why, capacity, "%s", pack_good(p) ? text : p->why);
    return pack_good(p) ? (dig_status)status : DIG_E_FORMAT;
}

static real play_energy(void *data, const dig_effect_call *call)
{
    const World *w = data;
    real energy = 0;
    (void)call;
    if (w->playback && w->playback->stream)
        pack_real(w->playback->stream, &energy);
    return energy;
}

void command_play_effect(World *w, dig_effect_def *def, bool energy)
{
    def->step = play_step;
    def->energy = energy ? play_energy : NULL;
    def->data = w;
}
