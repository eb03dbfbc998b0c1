/* world/layer.h - the other layers: who is joined by wires, by heat, by pipes, by being near. One graph each (world/graph.h).
 *
 * The mechanical layer is world->graph: every dynamic body is in it, and its links are touches and joints. In the layers here a
 * body is in a DIG while it has a link there, fixed ones too unless the link is bound. A layer has no bytes before its first link.
 *
 * Two ways to keep a layer:
 *   by hand     layer_begin; layer_add and layer_cut; layer_end          wires, pipes: made and cut once
 *   by marking  layer_begin; layer_mark for all that are there now; layer_end with sweep = true      thermal contacts, flocks:
 *               what is marked and not there is added, what is there, was marked once and is not marked now, goes
 * Both post link, unlink, merged and split events that carry the layer.
 *
 * Owns:      the graph and the links of each layer; layer_close frees them.
 * Invariant: layer_check().
 * Floor:     world.
 */
#ifndef DIG_LAYER_H
#define DIG_LAYER_H

#include "world/graph.h"
#include "base/list.h"
#include "base/map.h"

typedef struct LayerLink {
    uint32_t gen;               /* generation of the handle                            */
    bool     alive;
    bool     kept, marked;      /* by marking: ever, in this sweep                     */
    uint32_t a, b;              /* body slots                                          */
    uint32_t link;              /* in the layer's graph                                */
    real     effort, flow;      /* of the layer: V and A, K and W/K, Pa and m^3/s; their product is W */
    real     ratio;             /* of b to a, for messages by ratio; 0 = none          */
} LayerLink;

typedef struct Layer {
    Graph *graph;               /* NULL before the first link                          */
    LIST(LayerLink) links;
    LIST(uint32_t)  free_links;
    LIST(uint32_t)  loose;      /* bodies that lost a link in this batch               */
    Map    pairs;               /* (a, b, 0) -> link that is kept by marking           */
    Map    bounds;              /* (body, 0, 0) -> bound links that end there          */
} Layer;

struct dig_world;

Graph     *layer_graph(const struct dig_world *w, uint32_t layer);      /* NULL: no such layer, or no link in it yet */
void       layer_begin(struct dig_world *w, uint32_t layer);            /* before the first link it does nothing */
/* DIG_E_MEMORY, DIG_E_FULL: nothing is added. bound: b stays outside. ratio 0: none. The batch must be open, or the layer unused. */
dig_status layer_add(struct dig_world *w, uint32_t layer, uint32_t a, uint32_t b, bool bound, real ratio, uint32_t *link);
void       layer_cut(struct dig_world *w, uint32_t layer, uint32_t link);
dig_status layer_mark(struct dig_world *w, uint32_t layer, uint32_t a, uint32_t b, bool bound, uint32_t *link);
void       layer_end(struct dig_world *w, uint32_t layer, bool sweep);

bool       layer_bounds(const Layer *l, uint32_t body);                 /* is it a boundary of the layer? */
dig_status layer_connect(Layer *l);                                     /* after loading: both maps from the links */
void       layers_forget(struct dig_world *w, uint32_t body);           /* all its links go */
void       layer_close(Layer *l);
dig_status layer_copy(Layer *to, const Layer *from, uint64_t *allocations);
size_t     layer_bytes(const Layer *l);
uint64_t   layer_hash(uint64_t h, const Layer *l);      /* h itself when it was never used */
bool       layer_check(const Layer *l);

#endif
