/* world/graph_save.h - a graph as bytes, and back (base/pack.h).
 *
 * Written is what the future depends on: DIGs in their order with their members in theirs, links at their numbers with the order
 * of every node's list, the links that are free in the order in which they will be taken. Not between graph_begin and graph_end.
 *
 * Floor: world, but needs base only.
 */
#ifndef DIG_GRAPH_SAVE_H
#define DIG_GRAPH_SAVE_H

#include "base/pack.h"
#include "world/graph.h"

/* Reading: g is open and empty and gets nodes below `nodes`; the result passes graph_check. */
void graph_pack(Pack *p, Graph *g, uint32_t nodes);

#endif
