/* world/joint.c - joint records in the lists of their bodies. What a joint does is its type's business (solve/joint_type.h);
 * creation, which needs the type, is in api/joint.c. */
#include "world/joint.h"

static uint32_t *next_of(JointRec *j, uint32_t body) { return j->a == body ? &j->next_a : &j->next_b; }

static void list_insert(World *w, uint32_t joint, uint32_t body)
{
    if (body == NONE)
        return;
    *next_of(&w->joints.data[joint], body) = w->bodies.data[body].joint_first;
    w->bodies.data[body].joint_first = joint;
}

static void list_remove(World *w, uint32_t joint, uint32_t body)
{
    if (body == NONE)
        return;
    uint32_t *link = &w->bodies.data[body].joint_first;
    while (*link != joint)
        link = next_of(&w->joints.data[*link], body);
    *link = *next_of(&w->joints.data[joint], body);
}

void joint_attach(World *w, uint32_t joint)
{
    list_insert(w, joint, w->joints.data[joint].a);
    list_insert(w, joint, w->joints.data[joint].b);
}

void joint_stir_pairs(World *w, const JointRec *j)
{
    if (j->a != NONE)
        body_refit(w, j->a);
    if (j->b != NONE)
        body_refit(w, j->b);
}

/* Joints that couple this one (gear, rack) go with it. */
static void remove_dependants(World *w, uint32_t slot)
{
    for (int i = 0; i < w->joints.count; i++) {
        const JointRec *j = &w->joints.data[i];
        if (j->alive && (uint32_t)i != slot && (j->other[0] == slot || j->other[1] == slot))
            joint_remove(w, (uint32_t)i);
    }
}

void joint_remove(World *w, uint32_t slot)
{
    remove_dependants(w, slot);
    JointRec *j = &w->joints.data[slot];
    if (j->a != NONE)
        body_wake(w, j->a);
    if (j->b != NONE)
        body_wake(w, j->b);
    joint_stir_pairs(w, j);
    list_remove(w, slot, j->a);
    list_remove(w, slot, j->b);
    if (j->link != NONE) {
        graph_begin(w->graph);
        graph_link_remove(w->graph, j->link);
        graph_end(w->graph);
        dig_event *e = event_post(w, DIG_EVENT_UNLINK, j->a, j->b);
        if (e)
            e->link = DIG_LINK_JOINT;
        post_graph_changes(w, DIG_LAYER_MECHANICAL);
    }
    j->alive = false;
    slot_give(w, &w->free_joints, slot);
}

static bool joined(const World *w, uint32_t a, uint32_t b, bool collides)
{
    for (uint32_t s = w->bodies.data[a].joint_first; s != NONE; s = joint_next(w, s, a)) {
        const JointRec *j = &w->joints.data[s];
        if (j->collides == collides && ((j->a == a && j->b == b) || (j->a == b && j->b == a)))
            return true;
    }
    return false;
}

/* ---- what is held at one point ---- */

#define SAME_POINT 1e-3         /* of the smaller solid */

/* m  How far from a long solid what holds it may be: half as far as it is thick. Links made a little shorter than they are apart end before their pin. */
static real short_of(const Shape *s) { return isfinite(s->outer) ? real_clamp(0.5 * s->outer - s->inner, 0, s->inner) : 0; }

/* Is the anchor, from the centre of mass in body axes, in the solid, on it, or next to its end? */
static bool reaches(const Solid *s, vec3 anchor)
{
    const Shape *shape = &s->form->shape;
    vec3 middle = shape_middle(shape), arm = vec3_sub(quat_unrotate(s->form->at.q, vec3_sub(anchor, s->form->arm)), middle);
    real length = vec3_length(arm), nearer = real_max(SAME_POINT * length, short_of(shape));
    return shape->type->contains(shape, length > nearer ? vec3_mad(middle, 1 - nearer / length, arm) : middle);
}

/* Both are held at one point of a third body, or of the world, and reach there: they overlap, and nothing could part them. Ropes at one hook, bars on
 * one pin. What does not reach there still touches: the bobs of two pendulums that hang from one point. */
static bool meet_at_point(const World *w, const Solid *a, const Solid *b)
{
    real near = SAME_POINT * real_min(a->form->shape.outer, b->form->shape.outer);
    for (uint32_t s = w->bodies.data[a->body].joint_first; s != NONE; s = joint_next(w, s, a->body)) {
        const JointRec *j = &w->joints.data[s];
        if (!j->at_point || j->collides)
            continue;
        bool from = j->a == a->body;
        uint32_t third = from ? j->b : j->a;
        for (uint32_t t = w->bodies.data[b->body].joint_first; t != NONE; t = joint_next(w, t, b->body)) {
            const JointRec *k = &w->joints.data[t];
            bool to = k->a == b->body;
            if (k->at_point && !k->collides && (to ? k->b : k->a) == third && vec3_distance(from ? j->rb : j->ra, to ? k->rb : k->ra) <= near &&
                reaches(a, from ? j->ra : j->rb) && reaches(b, to ? k->ra : k->rb))
                return true;
        }
    }
    return false;
}

bool joint_forbids_contact(const World *w, const Solid *a, const Solid *b)
{
    if (w->bodies.data[a->body].joint_first == NONE || w->bodies.data[b->body].joint_first == NONE)
        return false;
    return joined(w, a->body, b->body, false) || (!joined(w, a->body, b->body, true) && meet_at_point(w, a, b));
}

bool joint_asks_contact(const World *w, uint32_t a, uint32_t b) { return joined(w, a, b, true); }
