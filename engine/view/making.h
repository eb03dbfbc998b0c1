/* view/making.h - what the files share that make a picture from tables: view.c, bars.c, room.c and sheet.c.
 *
 * Floor: view.
 */
#ifndef DIG_MAKING_H
#define DIG_MAKING_H

#include "view/look.h"

typedef struct Lists {
    LIST(ViewItem)    items;
    LIST(ViewMesh)    meshes;
    LIST(ViewContact) contacts;
    LIST(ViewLine)    lines;
    LIST(ViewArrow)   arrows;
    LIST(ViewLabel)   labels;
    LIST(ViewEdge)    edges;
    LIST(ViewQuad)    quads;
} Lists;

typedef struct Making {         /* a picture while it is made */
    const Look *l;
    vec3      origin;
    float    *stress;                       /* [bodies] the largest share of its limit that a joint of its bears; -1: none can break */
    uint32_t *mesh;                         /* [meshes of the look] in the view; LOOK_NONE: not yet */
    Lists    *to;
    bool     *woven;                        /* [bodies] a corner of a quad; NULL: there are no sheets */
    Map       quads;                        /* sheet, column and row of the first corner -> quad */
} Making;

static inline void write_vec(float out[3], vec3 v)
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

static inline void write_point(const Making *m, float out[3], vec3 p) { write_vec(out, vec3_sub(p, m->origin)); }

static inline void write_quat(float out[4], quat q)
{
    out[0] = (float)q.x;
    out[1] = (float)q.y;
    out[2] = (float)q.z;
    out[3] = (float)q.w;
}

/* m  An end of a joint, in the world. */
static inline vec3 joint_end(const Making *m, uint32_t body, vec3 anchor)
{
    if (body == LOOK_NONE)
        return anchor;
    const LookPose *p = &look_poses(m->l)[body];
    return vec3_add(p->x, quat_rotate(p->q, anchor));
}

/* bars.c: joints that are drawn as bars and coils. */
dig_status make_bars(Making *m);

/* room.c: its floor and its edges. */
dig_status make_room(Making *m);

/* sheet.c: finds the quads of sheets, before items are made; then makes an item for each sheet and DIG of it. */
dig_status find_quads(Making *m);
dig_status make_sheets(Making *m);
/* Is a joint between these bodies a thread or a diagonal of a quad? */
bool       is_thread(const Making *m, uint32_t a, uint32_t b);

#endif
