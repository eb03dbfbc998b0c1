/* geom/save.h - shapes and the tree of boxes as bytes, and back (base/pack.h).
 *
 * A shape is written as its type and what rebuilds the very same data, bit for bit: its def where making it again does, else
 * the lists themselves. What is read is checked as what a script gives, and the lists for everything the queries rely on.
 *
 * Floor: geom.
 */
#ifndef DIG_GEOM_SAVE_H
#define DIG_GEOM_SAVE_H

#include "base/pack.h"
#include "geom/shape.h"
#include "geom/tree.h"

#define SHAPE_PACKED 10             /* bytes, at least, of a packed shape */

/* Reading: *s gets a shape with one reference, or stays zeroed when the pack has failed. */
void shape_pack(Pack *p, Shape *s);
/* Reading: t is open and empty; its leaves hold any number below `users`, each at most once. */
void tree_pack(Pack *p, Tree *t, uint32_t users);

/* The types with lists: hull_save.c, mesh_save.c. */
void hull_pack(Pack *p, Shape *s);
void mesh_pack(Pack *p, Shape *s);

#endif
