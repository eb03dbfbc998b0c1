/* solve/cover.c - faces of boxes that a joint holds to the next piece of the same thing: they are none of its surface, and no contact
 * has their normal (geom/manifold_covered.c). What breaks off shows its face from the next step on, for its joint is gone.
 *
 * Only where the bodies' rest pose has the whole face on the other box; a plank that bends opens and closes there, and stays one.
 * Bodies of several solids are left alone, and so are those whose joint lets them touch each other: there these faces are what touches. */
#include "solve/group.h"

#define OVER   1e-2             /* of the box's smallest half: so far outside a face is the other box looked for */
#define WITHIN 1e-3             /* the same: and so far from its rim */

static const Solid *only_box(const Group *g, int body)
{
    const World *w = g->world;
    if (body < 0 || g->member[body].slot == NONE)
        return NULL;
    const Body *b = &w->bodies.data[g->member[body].slot];
    if (b->shape_count != 1)
        return NULL;
    const Solid *s = &w->solids.data[b->shape_first];
    return s->form->shape.type == &shape_box ? s : NULL;
}

static pose about_centre(const Group *g, int body, const Solid *s)
{
    return (pose){vec3_sub(s->form->at.p, g->world->bodies.data[g->member[body].slot].centre), s->form->at.q};
}

typedef struct Side { vec3 half; pose at; } Side;       /* a box, in the frame of the joint at rest */

static Side side_of(const Group *g, int body, const Solid *s, vec3 anchor, quat frame)
{
    pose at = about_centre(g, body, s);
    return (Side){((const BoxData *)s->form->shape.data)->half,
                  {quat_unrotate(frame, vec3_sub(at.p, anchor)), quat_mul(quat_conjugate(frame), at.q)}};
}

static real least(vec3 v) { return real_min(v.x, real_min(v.y, v.z)); }

static bool inside(const Side *s, vec3 point)
{
    vec3 p = pose_unpoint(s->at, point);
    return fabs(p.x) <= s->half.x && fabs(p.y) <= s->half.y && fabs(p.z) <= s->half.z;
}

static uint8_t covered_by(const Side *s, const Side *other)
{
    uint8_t faces = 0;
    real size = least(s->half);
    for (int k = 0; k < 3; k++)
        for (int way = -1; way <= 1; way += 2) {
            bool all = true;
            for (int c = 0; c < 4 && all; c++) {
                real p[3] = {s->half.x, s->half.y, s->half.z};
                int u = (k + 1) % 3, v = (k + 2) % 3;
                p[k] = way * (p[k] + OVER * size);
                p[u] = (c & 1 ? 1 : -1) * (p[u] - WITHIN * size);
                p[v] = (c & 2 ? 1 : -1) * (p[v] - WITHIN * size);
                all = inside(other, pose_point(s->at, (vec3){p[0], p[1], p[2]}));
            }
            faces |= all ? covered_face(k, way) : 0;
        }
    return faces;
}

void cover(Group *g)
{
    bool any = false;
    for (int i = 0; i < g->joint_count && g->pair_count > 0; i++) {
        const GroupJoint *j = &g->joints[i];
        bool one_thing = j->view.type->fuses && !g->world->joints.data[j->slot].collides;
        const Solid *a = one_thing ? only_box(g, j->a) : NULL, *b = a ? only_box(g, j->b) : NULL;
        if (!b)
            continue;
        Side of_a = side_of(g, j->a, a, j->ra, j->fa), of_b = side_of(g, j->b, b, j->rb, j->fb);
        g->member[j->a].covered |= covered_by(&of_a, &of_b);
        g->member[j->b].covered |= covered_by(&of_b, &of_a);
        any = true;
    }
    for (int i = 0; i < g->pair_count && any; i++) {
        GroupPair *q = &g->pairs[i];
        q->covered = (Covered){g->member[q->a].covered, g->member[q->b].covered};
    }
}
