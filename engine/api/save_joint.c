/* api/save_joint.c - the sections of joints, and of outside acts: pushes and regions. */
#include "api/save.h"
#include "world/region.h"

#include <stdio.h>
#include <stdlib.h>

enum { JOINT_BYTES = 330, PUSH_BYTES = 90, REGION_BYTES = 110 };        /* at least */

/* ---- joints ---- */

static void pack_type(Pack *p, JointRec *j)
{
    char name[32] = "";
    if (!p->reading)
        snprintf(name, sizeof name, "%s", j->type->name);
    pack_text(p, name, sizeof name);
    for (int i = 0; p->reading && joint_types[i]; i++)
        if (strcmp(joint_types[i]->name, name) == 0)
            j->type = joint_types[i];
    if (!j->type)
        pack_fail(p, "there is no joint type '%s'", name);
}

/* What the rows of the last substep left, and what the reports read. */
static void pack_joint_state(Pack *p, JointRec *j)
{
    for (size_t i = 0; i < sizeof j->memory / sizeof *j->memory; i++)
        pack_real_in(p, &j->memory[i], -1e9, 1e9, "memory of a joint");
    for (size_t i = 0; i < sizeof j->impulse / sizeof *j->impulse; i++)
        pack_real_in(p, &j->impulse[i], -SAVE_STRONG, SAVE_STRONG, "force of a joint");
    pack_vec3(p, &j->force, SAVE_STRONG, "force of a joint");
    pack_vec3(p, &j->torque, SAVE_STRONG, "torque of a joint");
    pack_real_in(p, &j->error, -SAVE_FAR, SAVE_FAR, "error of a joint");
    pack_bool(p, &j->at_limit);
}

static void pack_joint(Pack *p, const World *w, JointRec *j)
{
    uint32_t joints = (uint32_t)w->joints.count;
    save_gen(p, w, &j->gen, true);
    pack_type(p, j);
    if (!pack_good(p))
        return;
    j->alive = true;
    j->at_point = j->type->at_point;
    pack_bool(p, &j->collides);
    pack_text(p, j->name, sizeof j->name);
    pack_index(p, &j->a, (uint32_t)w->bodies.count, false, "first body of a joint");
    pack_index(p, &j->b, (uint32_t)w->bodies.count, true, "second body of a joint");
    pack_index(p, &j->next_a, joints, true, "next joint of a body");
    pack_index(p, &j->next_b, joints, true, "next joint of a body");
    pack_index(p, &j->other[0], joints, true, "coupled joint");
    pack_index(p, &j->other[1], joints, true, "coupled joint");
    pack_u32(p, &j->link);
    pack_vec3(p, &j->ra, SAVE_FAR, "anchor of a joint");
    pack_vec3(p, &j->rb, SAVE_FAR, "anchor of a joint");
    pack_quat(p, &j->fa, "frame of a joint");
    pack_quat(p, &j->fb, "frame of a joint");
    pack_real_in(p, &j->breaks_at, 0, INFINITY, "strength of a joint");
    save_rows(p, w, j->type->params, j->params, j->type->name);
    j->plain = joint_plain(j->type, j->params);
    pack_joint_state(p, j);
}

void save_joints(Pack *p, World *w)
{
    unsigned char *unused = SAVE_TABLE(p, w, &w->joints, &w->free_joints, JOINT_BYTES, "joints");
    for (int i = 0; unused && i < w->joints.count && pack_good(p); i++)
        if (!unused[i])
            pack_joint(p, w, &w->joints.data[i]);
    free(unused);
}

/* ---- outside acts ---- */

static void pack_push(Pack *p, const World *w, Push *push)
{
    pack_index(p, &push->body, (uint32_t)w->bodies.count, false, "body that is pushed");
    pack_vec3(p, &push->force, SAVE_STRONG, "force of a push");
    pack_vec3(p, &push->torque, SAVE_STRONG, "torque of a push");
    pack_vec3(p, &push->at, SAVE_FAR, "place of a push");
    pack_bool(p, &push->has_at);
    pack_bool(p, &push->law);
    pack_real_in(p, &push->from, -SAVE_LONG, SAVE_LONG, "start of a push");
    pack_real_in(p, &push->until, -SAVE_LONG, INFINITY, "end of a push");
}

static void pack_region(Pack *p, const World *w, Region *r)
{
    save_gen(p, w, &r->gen, true);
    save_pose(p, &r->at, "place of a region");
    save_rows(p, w, dig_schema_at("region", 0)->rows, &r->laws, "region");
    shape_pack(p, &r->shape);
    if (p->reading)
        r->alive = r->shape.type != NULL;
}

void save_acts(Pack *p, World *w)
{
    uint32_t count = pack_count(p, (uint32_t)w->pushes.count, PUSH_BYTES, "pushes");
    if (p->reading && list_reserve(&w->pushes, (int)count, &w->allocations) != DIG_OK) {
        pack_fail_memory(p);
        return;
    }
    w->pushes.count = (int)count;
    for (uint32_t i = 0; i < count; i++)
        pack_push(p, w, &w->pushes.data[i]);

    unsigned char *unused = SAVE_TABLE(p, w, &w->regions, &w->free_regions, REGION_BYTES, "regions");
    for (int i = 0; unused && i < w->regions.count && pack_good(p); i++)
        if (!unused[i])
            pack_region(p, w, &w->regions.data[i]);
    free(unused);
    if (!p->reading)
        return;
    w->region_count = pack_good(p) ? w->regions.count - w->free_regions.count : 0;
    for (int i = 0; i < w->bodies.count; i++)       /* follows from where they are */
        w->bodies.data[i].rate = w->bodies.data[i].kind == DIG_DYNAMIC && pack_good(p) ? region_rate(w, w->bodies.data[i].x) : 1;
}
