/* api/save.h - a world as bytes, section by section; shared by the files save*.c.
 *
 * A file is a header, a table of sections and the sections, in the order of save.c. Every record is written field by field by
 * one function that also reads it (base/pack.h). Reading happens twice over: each field is checked for itself as it comes, then
 * save_connect.c checks what the fields say of each other and rebuilds what follows from them (maps, back links, inverses), so
 * that the rest of the engine may trust the tables as if it had made them. The bounds are far beyond what a world that works can
 * hold, and keep every product of two or three numbers finite.
 *
 * Not written: what the next step makes anew (reach boxes, scratch), times of the clock, capacities. Handles are written
 * relative to the world's first: equal worlds give equal files, and a handle of the saved world is dead in the loaded one.
 *
 * Memory: a table is allocated only when the bytes that are left can hold its records. A world takes at most 300 bytes of
 * memory per byte of file (where all slots of the body table are free; else some 5), besides 2 MB for any world.
 *
 * Floor: api.
 */
#ifndef DIG_SAVE_H
#define DIG_SAVE_H

#include "api/api.h"
#include "base/pack.h"
#include "geom/save.h"

#define SAVE_FORMAT 16u

#define SAVE_FAR    WORLD_FAR
#define SAVE_FAST   WORLD_FAST
#define SAVE_LONG   1e18        /* s         */
#define SAVE_STRONG WORLD_STRONG
#define SAVE_MUCH   1e200       /* J, statistics */

/* ---- sections, in the order of the file ---- */

/* The def alone comes first: with it the world is opened. */
void save_def(Pack *p, dig_world_def *def);
void save_settings(Pack *p, World *w);
void save_materials(Pack *p, World *w);
void save_bodies(Pack *p, World *w);
void save_solids(Pack *p, World *w);
void save_joints(Pack *p, World *w);
void save_pairs(Pack *p, World *w);
void save_touches(Pack *p, World *w);
void save_acts(Pack *p, World *w);          /* pushes and regions */
void save_lists(Pack *p, World *w);
void save_tree(Pack *p, World *w);
void save_graph(Pack *p, World *w);
void save_layers(Pack *p, World *w);
void save_events(Pack *p, World *w);
void save_messages(Pack *p, World *w);
void save_mail(Pack *p, World *w);          /* messages on their way */
void save_effects(Pack *p, World *w);       /* what effects keep */
void save_note(Pack *p, World *w);          /* of the program around it */

/* After all sections were read. */
void save_connect(Pack *p, World *w);

/* ---- parts of records ---- */

/* Generation of a handle; `own`: of a record of this world, which is checked. */
void save_gen(Pack *p, const World *w, uint32_t *gen, bool own);
void save_body_handle(Pack *p, const World *w, dig_body *b);
void save_joint_handle(Pack *p, const World *w, dig_joint *j);
void save_region_handle(Pack *p, const World *w, dig_region *r);
void save_message(Pack *p, const World *w, dig_message *m);
void save_surface(Pack *p, const World *w, Surface *s);
void save_pose(Pack *p, pose *at, const char *what);
/* A struct by the rows that describe it, checked by them when read. */
void save_rows(Pack *p, const World *w, const dig_param *rows, void *fields, const char *subject);
/* One field of such a struct, as it is; not of a list or a table. */
void save_field(Pack *p, const World *w, const dig_param *row, void *field);
/* A list of slots below `limit`, any number of times each. `list` points to a LIST(uint32_t). */
void save_slots(Pack *p, World *w, void *list, uint32_t limit, const char *what);

/* The slots of a table: how many there are, and which are free. Reading makes room, all zero. Returns one mark per slot, 1 =
 * free, to be freed by the caller, or NULL after a failure. `least` bytes follow for every slot in use. */
unsigned char *save_table(Pack *p, World *w, void **data, int *count, int *capacity, size_t item, void *free_list, size_t least, const char *what);
#define SAVE_TABLE(p, w, list, free_list, least, what) \
    save_table((p), (w), (void **)&(list)->data, &(list)->count, &(list)->capacity, sizeof *(list)->data, (free_list), (least), (what))

/* A world from the bytes of a file; generations of its handles count from `gen_start` unless that is 0. */
dig_status save_read(const void *bytes, size_t size, uint32_t gen_start, World **out, char *why, size_t capacity);

/* save_mass.c: is the inertia possible for the body's shapes? Derives what follows from it. */
bool save_derive_mass(World *w, Body *b);

#endif
