/* api/heat.c - energy given to a body, as heat. */
#include "api/api.h"
#include "api/command.h"
#include "effect/heat.h"

static EffectSlot *slot_of(World *w)
{
    for (int i = 0; i < w->effect_count; i++)
        if (strcmp(w->effects[i].name, "heat") == 0)
            return &w->effects[i];
    return NULL;
}

static dig_status do_warm(World *w, dig_body handle, real energy, real to)
{
    const Body *b = api_body(w, handle, "warm");
    if (!b)
        return DIG_E_DEAD;
    EffectSlot *e = slot_of(w);
    Heat *h = e ? column_find(&e->members, handle.slot) : NULL;
    if (!h)
        return world_fail(w, DIG_E_KIND, "warm: %s has no temperature; give it one when it is made, or assign one", BODY_TEXT(w, b));
    if (isnan(energy) == isnan(to))
        return world_fail(w, DIG_E_ARG, "warm: %s: give either an energy (J) or a temperature (K)", BODY_TEXT(w, b));
    real work = isnan(to) ? energy : h->capacity * (to - h->start) - h->stored;
    real reached = isnan(to) ? h->start + (h->stored + work) / h->capacity : to;
    if (h->capacity == 0 && isnan(to))
        return world_fail(w, DIG_E_KIND, "warm: %s keeps its temperature whatever flows in: only the temperature can be set", BODY_TEXT(w, b));
    if (!(reached >= 0 && reached <= HEAT_MOST && isfinite(work)))
        return world_fail(w, DIG_E_ARG, "warm: %s would have %g K, must be 0 to %g K", BODY_TEXT(w, b), reached, HEAT_MOST);
    h->temperature = reached;
    h->stored += work;
    h->start = h->capacity > 0 ? h->start : reached;
    w->ledger.work_in += w->ledger.started ? work : 0;
    return DIG_OK;
}

dig_status run_warm(World *w, CommandArg *a)
{
    return do_warm(w, a[0].body, a[1].number, a[2].number);
}

dig_status dig_body_warm(dig_world *w, dig_body handle, real energy, real to)
{
    return COMMAND(w, COMMAND_WARM, do_warm(w, handle, energy, to), {.body = handle}, {.number = energy}, {.number = to});
}
