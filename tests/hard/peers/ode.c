/* tests/hard/peers/ode.c - driver of ODE (Debian's libode-dev, double precision) for the hard cases.
 *
 * Its own defaults: quick step with 20 iterations, ERP 0.2, CFM 1e-10, no damping, no auto-disable, one step a frame.
 * Contacts: up to 8 a pair, dContactApprox1. A spring is its double-ball joint, with ERP and CFM as its manual says for springs.
 */
#include <math.h>
#include <ode/ode.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "peer.h"

enum { POINTS = 8, TOLD = 4096, SIMPLE_BODIES = 64 };

const char *const peer_name = "ode";

typedef struct {
    dReal    *plane, *point;
    unsigned *face;
} Convex;

struct Peer {
    const PeerScene *scene;
    dWorldID         world;
    dSpaceID         space;
    dJointGroupID    contacts;
    dBodyID         *body;
    dJointID        *joint;
    dJointFeedback  *of_joint;
    Convex          *convex;
    dJointFeedback   told[TOLD];             /* of the contacts of the last step */
    int              told_a[TOLD], told_b[TOLD], tells;
    unsigned long    seed;                   /* its solver orders rows at random: each world by numbers of its own */
};

/* Its solver's complaints are not the report's matter: what comes of them is judged. */
__attribute__((format(printf, 2, 0))) static void be_quiet(int number, const char *format, va_list list)
{
    (void)number, (void)format, (void)list;
}

static bool apart(const PeerBody *a, const PeerBody *b)
{
    return a->ghost || b->ghost || (a->group && a->group == b->group);
}

static void touch(void *data, dGeomID a, dGeomID b)
{
    Peer *p = data;
    int i = (int)(size_t)dGeomGetData(a), k = (int)(size_t)dGeomGetData(b);
    const PeerBody *first = &p->scene->body[i], *second = &p->scene->body[k];
    dBodyID of_a = dGeomGetBody(a), of_b = dGeomGetBody(b);
    if ((first->mass <= 0 && second->mass <= 0) || apart(first, second))
        return;
    if (of_a && of_b && dAreConnectedExcluding(of_a, of_b, dJointTypeContact))
        return;
    dContact contact[POINTS];
    memset(contact, 0, sizeof contact);
    int n = dCollide(a, b, POINTS, &contact[0].geom, sizeof *contact);
    for (int c = 0; c < n; c++) {
        const dReal *normal = contact[c].geom.normal;        /* some of hulls that just touch have none, which would end the process */
        if (!(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2] > 0.5))
            continue;
        dSurfaceParameters *s = &contact[c].surface;
        double rolling = first->rolling > second->rolling ? first->rolling : second->rolling;
        s->mode = dContactApprox1 | (p->scene->restitution > 0 ? dContactBounce : 0) | (rolling > 0 ? dContactRolling : 0);
        s->mu = sqrt(first->friction * second->friction);
        s->bounce = p->scene->restitution;
        s->rho = s->rho2 = s->rhoN = rolling;
        dJointID joint = dJointCreateContact(p->world, p->contacts, &contact[c]);
        dJointAttach(joint, of_a, of_b);
        if (p->tells < TOLD) {
            p->told_a[p->tells] = i;
            p->told_b[p->tells] = k;
            memset(&p->told[p->tells], 0, sizeof *p->told);
            dJointSetFeedback(joint, &p->told[p->tells++]);
        }
    }
}

static dGeomID make_hull(dSpaceID space, const PeerHull *h, Convex *c)
{
    int numbers = 0, k = 0;
    for (int f = 0; f < h->faces; f++)
        numbers += 1 + h->face[f].corners;
    c->plane = calloc((size_t)(4 * h->faces), sizeof *c->plane);
    c->point = calloc((size_t)(3 * h->points), sizeof *c->point);
    c->face = calloc((size_t)numbers, sizeof *c->face);
    if (!c->plane || !c->point || !c->face)
        abort();
    for (int i = 0; i < 3 * h->points; i++)
        c->point[i] = h->point[i / 3][i % 3];
    for (int f = 0; f < h->faces; f++) {
        memcpy(c->plane + 4 * f, h->face[f].normal, sizeof h->face[f].normal);
        c->plane[4 * f + 3] = h->face[f].offset;
        c->face[k++] = (unsigned)h->face[f].corners;
        for (int i = 0; i < h->face[f].corners; i++)
            c->face[k++] = (unsigned)h->face[f].corner[i];
    }
    return dCreateConvex(space, c->plane, (unsigned)h->faces, c->point, (unsigned)h->points, c->face);
}

static dGeomID make_geom(Peer *p, const PeerBody *b, int i)
{
    const double *s = b->size;
    switch (b->kind) {
    case PEER_SPHERE: return dCreateSphere(p->space, s[0]);
    case PEER_BOX:    return dCreateBox(p->space, 2 * s[0], 2 * s[1], 2 * s[2]);
    case PEER_HULL:   return make_hull(p->space, b->hull, &p->convex[i]);
    case PEER_PLANE:  return dCreatePlane(p->space, s[0], s[1], s[2], b->offset);
    default:          /* a disc that is driven is a square table: its own cylinder does not meet its sphere reliably */
        return b->driven ? dCreateBox(p->space, 2 * s[0], 2 * s[1], 2 * s[0]) : dCreateCylinder(p->space, s[0], 2 * s[1]);
    }
}

static void add_body(Peer *p, int i)
{
    const PeerBody *b = &p->scene->body[i];
    const PeerState *at = &b->start;
    dGeomID geom = make_geom(p, b, i);
    dGeomSetData(geom, (void *)(size_t)i);
    if (b->kind == PEER_PLANE)
        return;
    if (b->mass <= 0 && !b->driven) {
        dGeomSetPosition(geom, at->at[0], at->at[1], at->at[2]);
        dGeomSetQuaternion(geom, at->turn);
        return;
    }
    dBodyID body = p->body[i] = dBodyCreate(p->world);
    dGeomSetBody(geom, body);
    if (b->kind == PEER_CYLINDER && !b->driven) {           /* ODE's lies along z */
        const dQuaternion upright = {0.70710678118654752, -0.70710678118654752, 0, 0};
        dGeomSetOffsetQuaternion(geom, upright);
    }
    dBodySetPosition(body, at->at[0], at->at[1], at->at[2]);
    dBodySetQuaternion(body, at->turn);
    dBodySetLinearVel(body, at->v[0], at->v[1], at->v[2]);
    dBodySetAngularVel(body, at->spin[0], at->spin[1], at->spin[2]);
    if (b->driven) {
        dBodySetKinematic(body);
        return;
    }
    dMass mass;
    dMassSetParameters(&mass, b->mass, 0, 0, 0, b->inertia[0], b->inertia[1], b->inertia[2], 0, 0, 0);
    dBodySetMass(body, &mass);
}

static void set_spring(dJointID joint, const PeerJoint *j, double h)
{
    dJointSetDBallAnchor1(joint, j->at[0][0], j->at[0][1], j->at[0][2]);
    dJointSetDBallAnchor2(joint, j->at[1][0], j->at[1][1], j->at[1][2]);
    dJointSetDBallDistance(joint, j->length);
    dJointSetDBallParam(joint, dParamERP, h * j->stiffness / (h * j->stiffness + j->damping));
    dJointSetDBallParam(joint, dParamCFM, 1 / (h * j->stiffness + j->damping));
}

static void set_hinge(dJointID joint, const PeerJoint *j)
{
    dJointSetHingeAnchor(joint, j->at[0][0], j->at[0][1], j->at[0][2]);
    dJointSetHingeAxis(joint, j->axis[0], j->axis[1], j->axis[2]);
    if (j->limited) {
        dJointSetHingeParam(joint, dParamLoStop, j->lower);
        dJointSetHingeParam(joint, dParamHiStop, j->upper);
    }
    if (j->motor_torque > 0) {
        dJointSetHingeParam(joint, dParamVel, j->motor_speed);
        dJointSetHingeParam(joint, dParamFMax, j->motor_torque);
    }
}

static void add_joint(Peer *p, int i)
{
    const PeerJoint *j = &p->scene->joint[i];
    dJointID joint = j->kind == PEER_BALL ? dJointCreateBall(p->world, 0) : j->kind == PEER_HINGE ? dJointCreateHinge(p->world, 0) :
                     j->kind == PEER_SLIDER ? dJointCreateSlider(p->world, 0) : dJointCreateDBall(p->world, 0);
    p->joint[i] = joint;
    dJointAttach(joint, p->body[j->a], j->b < 0 ? 0 : p->body[j->b]);
    dJointSetFeedback(joint, &p->of_joint[i]);
    if (j->kind == PEER_BALL)
        dJointSetBallAnchor(joint, j->at[0][0], j->at[0][1], j->at[0][2]);
    else if (j->kind == PEER_HINGE)
        set_hinge(joint, j);
    else if (j->kind == PEER_SLIDER)
        dJointSetSliderAxis(joint, j->axis[0], j->axis[1], j->axis[2]);
    else
        set_spring(joint, j, p->scene->step);
}

static void *array(int count, size_t size)
{
    void *list = calloc((size_t)count + 1, size);
    if (!list)
        abort();
    return list;
}

Peer *peer_open(const PeerScene *scene, char *why, size_t room)
{
    static int worlds = 0;
    (void)why, (void)room;
    if (worlds++ == 0) {
        dInitODE2(0);
        dAllocateODEDataForThread((unsigned)dAllocateMaskAll);
        dSetMessageHandler(be_quiet);
    }
    Peer *p = array(0, sizeof *p);
    p->scene = scene;
    p->body = array(scene->bodies, sizeof(dBodyID));
    p->joint = array(scene->joints, sizeof(dJointID));
    p->of_joint = array(scene->joints, sizeof(dJointFeedback));
    p->convex = array(scene->bodies, sizeof(Convex));
    p->world = dWorldCreate();
    p->space = scene->bodies > SIMPLE_BODIES ? dHashSpaceCreate(0) : dSimpleSpaceCreate(0);
    p->contacts = dJointGroupCreate(0);
    dWorldSetGravity(p->world, scene->gravity[0], scene->gravity[1], scene->gravity[2]);
    for (int i = 0; i < scene->bodies; i++)
        if (!scene->body[i].gone)
            add_body(p, i);
    for (int i = 0; i < scene->joints; i++)
        add_joint(p, i);
    return p;
}

void peer_step(Peer *p)
{
    for (int i = 0; i < p->scene->bodies; i++) {
        const PeerBody *b = &p->scene->body[i];
        if (!p->body[i] || !b->driven)
            continue;
        dBodySetLinearVel(p->body[i], b->drive[0][0], b->drive[0][1], b->drive[0][2]);
        dBodySetAngularVel(p->body[i], b->drive[1][0], b->drive[1][1], b->drive[1][2]);
    }
    p->tells = 0;
    dJointGroupEmpty(p->contacts);
    dSpaceCollide(p->space, p, touch);
    dRandSetSeed(p->seed);
    dWorldQuickStep(p->world, p->scene->step);
    p->seed = dRandGetSeed();
}

void peer_states(Peer *p, PeerState *out)
{
    for (int i = 0; i < p->scene->bodies; i++) {
        if (!p->body[i])
            continue;
        memcpy(out[i].at, dBodyGetPosition(p->body[i]), sizeof out[i].at);
        memcpy(out[i].turn, dBodyGetQuaternion(p->body[i]), sizeof out[i].turn);
        memcpy(out[i].v, dBodyGetLinearVel(p->body[i]), sizeof out[i].v);
        memcpy(out[i].spin, dBodyGetAngularVel(p->body[i]), sizeof out[i].spin);
    }
}

void peer_push(Peer *p, int body, const double impulse[3])
{
    const double h = p->scene->step;
    dBodyAddForce(p->body[body], impulse[0] / h, impulse[1] / h, impulse[2] / h);
}

bool peer_joint_force(Peer *p, int joint, double force[3])
{
    memcpy(force, p->of_joint[joint].f1, 3 * sizeof *force);
    return true;
}

int peer_touches(Peer *p, PeerTouch *out, int room)
{
    int n = p->tells < room ? p->tells : room;
    for (int i = 0; i < n; i++) {
        /* A contact of the second geometry alone has it as its first body: its force is the other end's, turned. */
        bool first = p->body[p->told_a[i]];
        out[i] = (PeerTouch){.a = p->told_a[i], .b = p->told_b[i]};
        for (int k = 0; k < 3; k++)
            out[i].force[k] = first ? -p->told[i].f1[k] : p->told[i].f1[k];
    }
    return n;
}

void peer_close(Peer *p)
{
    dJointGroupDestroy(p->contacts);
    dSpaceDestroy(p->space);
    dWorldDestroy(p->world);
    for (int i = 0; i < p->scene->bodies; i++) {
        free(p->convex[i].plane);
        free(p->convex[i].point);
        free(p->convex[i].face);
    }
    free(p->body);
    free(p->joint);
    free(p->of_joint);
    free(p->convex);
    free(p);
}
