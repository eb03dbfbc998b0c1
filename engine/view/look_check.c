/* view/look_check.c - may tables that come from elsewhere be drawn? */
#include "view/look.h"

#include "math/vec.h"

#define FAR  1e16       /* m; nothing is farther */

static bool finite3(const float v[3]) { return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]); }
static bool near3(vec3 v) { return vec3_finite(v) && vec3_largest(vec3_abs(v)) <= FAR; }

static bool unit(quat q)
{
    real n = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    return fabs(n - 1) <= 1e-6;
}

static bool ended(const char *text, size_t size) { return text[size - 1] == '\0'; }

/* A slot of a body that is there. */
static bool is_body(const Look *l, uint32_t slot)
{
    return slot < (uint32_t)look_count(l, LOOK_BODIES) && look_bodies(l)[slot].there;
}

static const char *check_scene(const Look *l)
{
    if (look_count(l, LOOK_SCENE) != 1)
        return "there is no scene";
    const LookScene *s = look_scene(l);
    bool empty = !(s->low.x <= s->high.x);
    if (!isfinite(s->time) || !near3(s->gravity) || !near3(s->room_size) || !near3(s->room_at) || (!empty && (!near3(s->low) || !near3(s->high))))
        return "the scene has numbers that are not finite";
    if (empty && (s->low.x != INFINITY || s->high.x != -INFINITY))
        return "the bounds of the scene are not in order";
    return NULL;
}

static const char *check_bodies(const Look *l)
{
    if (look_count(l, LOOK_POSES) != look_count(l, LOOK_BODIES))
        return "bodies and poses differ in number";
    for (int i = 0; i < look_count(l, LOOK_BODIES); i++) {
        const LookBody *b = &look_bodies(l)[i];
        const LookPose *p = &look_poses(l)[i];
        if (!b->there)
            continue;
        if (!near3(p->x) || !near3(b->centre) || !isfinite(p->temperature) || !finite3(p->v) || !finite3(p->w) || !finite3(p->force))
            return "a body has numbers that are not finite";
        if (!unit(p->q))
            return "the rotation of a body is none";
        if (b->kind > DIG_STATIC || p->mode > DIG_FIXED || !ended(b->name, sizeof b->name))
            return "a body is of no kind";
    }
    return NULL;
}

static const char *check_solids(const Look *l, int meshes)
{
    for (int i = 0; i < look_count(l, LOOK_SOLIDS); i++) {
        const LookSolid *s = &look_solids(l)[i];
        if (!s->there)
            continue;
        if ((s->body != LOOK_NONE && !is_body(l, s->body)) || s->mesh >= (uint32_t)meshes || s->pattern > PATTERN_CHECK)
            return "a shape belongs to nothing";
        if (!near3(s->at.p) || !unit(s->at.q) || !finite3(s->colour) || !isfinite(s->roughness) || !isfinite(s->metallic) ||
            !(s->clear >= 0 && s->clear <= 1))
            return "a shape has numbers that are not finite";
    }
    return NULL;
}

static const char *check_joints(const Look *l)
{
    if (look_count(l, LOOK_LOADS) != look_count(l, LOOK_JOINTS))
        return "joints and loads differ in number";
    for (int i = 0; i < look_count(l, LOOK_JOINTS); i++) {
        const LookJoint *j = &look_joints(l)[i];
        const LookLoad *load = &look_loads(l)[i];
        if (!j->there)
            continue;
        if (!is_body(l, j->a) || (j->b != LOOK_NONE && !is_body(l, j->b)))
            return "a joint holds a body that is not there";
        if (!near3(j->ra) || !near3(j->rb) || !(j->radius >= 0 && j->radius <= FAR) || isnan(load->stress) || !finite3(load->force))
            return "a joint has numbers that are not finite";
        if (!ended(j->type, sizeof j->type) || !ended(j->name, sizeof j->name))
            return "the name of a joint has no end";
    }
    return NULL;
}

static const char *check_rest(const Look *l)
{
    for (int i = 0; i < look_count(l, LOOK_CONTACTS); i++) {
        const LookContact *c = &look_contacts(l)[i];
        if (!finite3(c->p) || !finite3(c->n) || !finite3(c->force))
            return "a contact has numbers that are not finite";
    }
    for (int i = 0; i < look_count(l, LOOK_EDGES); i++) {
        const LookEdge *e = &look_edges(l)[i];
        bool other = e->bound ? e->b == LOOK_NONE || e->b < (uint32_t)look_count(l, LOOK_BODIES) : is_body(l, e->b);
        if (!is_body(l, e->a) || !other || e->kind >= DIG_LINK_KINDS || e->layer >= DIG_LAYERS || !finite3(e->end))
            return "a link belongs to nothing";
    }
    for (int i = 0; i < look_count(l, LOOK_ARROWS); i++)
        if (!near3(look_arrows(l)[i].p) || !finite3(look_arrows(l)[i].v))
            return "a push has numbers that are not finite";
    return NULL;
}

const char *look_check(const Look *l, int meshes)
{
    const char *why = check_scene(l);
    why = why ? why : check_bodies(l);
    why = why ? why : check_solids(l, meshes);
    why = why ? why : check_joints(l);
    return why ? why : check_rest(l);
}
