/* api/layer.c - links of the other layers, made and removed by hand. */
#include "api/api.h"
#include "api/command.h"

static LayerLink *find(World *w, dig_wire wire)
{
    if (wire.layer == DIG_LAYER_MECHANICAL || wire.layer >= DIG_LAYERS || wire.slot >= (uint32_t)w->layers[wire.layer].links.count)
        return NULL;
    LayerLink *k = &w->layers[wire.layer].links.data[wire.slot];
    return k->alive && k->gen == wire.gen ? k : NULL;
}

bool dig_wire_alive(const dig_world *w, dig_wire wire)
{
    if (wire.layer == DIG_LAYER_MECHANICAL || wire.layer >= DIG_LAYERS || wire.slot >= (uint32_t)w->layers[wire.layer].links.count)
        return false;
    const LayerLink *k = &w->layers[wire.layer].links.data[wire.slot];
    return k->alive && k->gen == wire.gen;
}

static dig_status check(const World *w, const dig_wire_def *def)
{
    if (def->layer == DIG_LAYER_MECHANICAL || def->layer >= DIG_LAYERS)
        return world_fail(w, DIG_E_ARG, "link: layer = %u, must be 1..%d (contacts and joints make the mechanical one)", def->layer, DIG_LAYERS - 1);
    if (!api_body(w, def->a, "link") || !api_body(w, def->b, "link"))
        return DIG_E_DEAD;
    if (def->a.slot == def->b.slot)
        return world_fail(w, DIG_E_ARG, "link: a and b are the same %s", BODY_TEXT(w, &w->bodies.data[def->a.slot]));
    if (!isfinite(def->ratio))
        return world_fail(w, DIG_E_ARG, "link: ratio = %g, must be finite", def->ratio);
    const Layer *l = &w->layers[def->layer];       /* a boundary belongs to no DIG of the layer, whatever else is joined to it */
    bool member = l->graph && graph_has_node(l->graph, def->b.slot);
    if (layer_bounds(l, def->a.slot) || (def->bound ? member : layer_bounds(l, def->b.slot)))
        return world_fail(w, DIG_E_ARG, "link: a body is a boundary of the %s layer or a member of a DIG there, not both", dig_layer_name(def->layer));
    return DIG_OK;
}

static dig_status do_add(World *w, const dig_wire_def *def, dig_wire *out)
{
    *out = (dig_wire){0, 0, 0};
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "link: nothing can be linked while the world is stepping");
    DIG_TRY(check(w, def));
    uint32_t slot = 0;
    layer_begin(w, def->layer);
    dig_status s = layer_add(w, def->layer, def->a.slot, def->b.slot, def->bound, def->ratio, &slot);
    layer_end(w, def->layer, false);
    if (s != DIG_OK)
        return world_fail(w, s, "link: not enough memory");
    *out = (dig_wire){def->layer, slot, w->layers[def->layer].links.data[slot].gen};
    return DIG_OK;
}

dig_status run_wire(World *w, CommandArg *a)
{
    return do_add(w, a[0].what, a[1].place);
}

dig_status dig_wire_add(dig_world *w, const dig_wire_def *def, dig_wire *out)
{
    return COMMAND(w, COMMAND_WIRE, do_add(w, def, out), {.what = def}, {.place = out});
}

static dig_status do_set(World *w, dig_wire wire, real effort, real flow)
{
    LayerLink *k = find(w, wire);
    if (!k)
        return world_fail(w, DIG_E_DEAD, "link: this link was removed");
    if (!isfinite(effort) || !isfinite(flow))
        return world_fail(w, DIG_E_ARG, "link: effort = %g and flow = %g must be finite", effort, flow);
    k->effort = effort;
    k->flow = flow;
    return DIG_OK;
}

dig_status run_wire_set(World *w, CommandArg *a)
{
    return do_set(w, a[0].wire, a[1].number, a[2].number);
}

dig_status dig_wire_set(dig_world *w, dig_wire wire, real effort, real flow)
{
    return COMMAND(w, COMMAND_WIRE_SET, do_set(w, wire, effort, flow), {.wire = wire}, {.number = effort}, {.number = flow});
}

static dig_status do_remove_wire(World *w, dig_wire wire)
{
    if (!find(w, wire))
        return world_fail(w, DIG_E_DEAD, "link: this link was removed");
    if (w->busy)
        return world_fail(w, DIG_E_BUSY, "link: nothing can be unlinked while the world is stepping");
    layer_begin(w, wire.layer);
    layer_cut(w, wire.layer, wire.slot);
    layer_end(w, wire.layer, false);
    return DIG_OK;
}

dig_status run_wire_remove(World *w, CommandArg *a)
{
    return do_remove_wire(w, a[0].wire);
}

dig_status dig_wire_remove(dig_world *w, dig_wire wire)
{
    return COMMAND(w, COMMAND_WIRE_REMOVE, do_remove_wire(w, wire), {.wire = wire});
}
