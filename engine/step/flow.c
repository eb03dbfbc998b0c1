/* step/flow.c - effects on the world as a whole, once a frame step: heat flows on while bodies sleep. */
#include "step/step.h"

dig_status reserve_flow(World *w, real dt)
{
    for (uint32_t left = w->bits.flow; left; left &= left - 1) {
        EffectSlot *e = &w->effects[lowest_bit(left)];
        if (e->type->reserve)
            DIG_TRY(e->type->reserve(w, e, dt));
    }
    return DIG_OK;
}

/* What an effect kept of its layer goes with it: all its links are unmarked. */
static void clear_layer(World *w, uint32_t layer)
{
    if (layer == 0 || w->layers[layer].pairs.count == 0)
        return;
    layer_begin(w, layer);
    layer_end(w, layer, true);
}

void flow(World *w, const Step *s)
{
    for (uint32_t left = w->flowing; left; left &= left - 1) {
        EffectSlot *e = &w->effects[lowest_bit(left)];
        uint32_t layer = e->type->layer;
        if (!(w->bits.flow & left & -left)) {
            clear_layer(w, layer);
            continue;
        }
        w->met |= left & -left;
        real start = s->timed ? wall_us() : 0;
        if (layer)
            layer_begin(w, layer);
        e->type->flow(w, e, s->dt);
        if (layer)
            layer_end(w, layer, true);
        e->flow_us = s->timed ? wall_us() - start : e->flow_us;
        e->calls++;
    }
}
