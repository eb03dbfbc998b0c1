/* tests/peers/ode.c - driver of ODE (Debian's libode-dev, double precision).
 *
 * Settings are ODE's own defaults (quick step, 20 iterations, ERP 0.2, CFM 1e-10, no damping, no auto-disable), at four
 * rates; and the direct solver, dWorldStep, at the same. Contacts: dContactApprox1 with a bounce threshold of 0.
 */
#include <ode/ode.h>
#include <stdarg.h>
#include <string.h>
#include "peer.h"

enum { QUICK, DIRECT, POINTS = 8 };

const char *const peer_name = "ode";
const PeerSetting peer_settings[] = {
    {"60 Hz", 60, QUICK, 0, 1},      {"240 Hz", 240, QUICK, 0, 1},      {"960 Hz", 960, QUICK, 0, 1},
    {"3840 Hz", 3840, QUICK, 0, 1},  {"240 Hz it100", 240, QUICK, 100, 1},
    {"60 Hz direct", 60, DIRECT, 0, 1},   {"240 Hz direct", 240, DIRECT, 0, 1},
    {"960 Hz direct", 960, DIRECT, 0, 1}, {"3840 Hz direct", 3840, DIRECT, 0, 1},
    {0}
};

static struct {
    dWorldID      world;
    dSpaceID      space;
    dJointGroupID contacts;
    dBodyID       body[PEER_BODIES];
    PeerScene     scene;
    PeerSetting   setting;
    long          messages;      /* of its solver: "LCP internal error" */
} ode;

__attribute__((format(printf, 2, 0))) static void count_message(int number, const char *format, va_list list)
{
    (void)number, (void)format, (void)list;
    ode.messages++;
}

static void touch(void *data, dGeomID a, dGeomID b)
{
    (void)data;
    dBodyID p = dGeomGetBody(a), q = dGeomGetBody(b);
    if (ode.scene.hinges || (!p && !q))      /* hinged rods do not touch each other */
        return;
    dContact contact[POINTS];
    memset(contact, 0, sizeof contact);
    int n = dCollide(a, b, POINTS, &contact[0].geom, sizeof *contact);
    for (int i = 0; i < n; i++) {
        dSurfaceParameters *s = &contact[i].surface;
        s->mode = dContactApprox1 | (ode.scene.restitution > 0 ? dContactBounce : 0);
        s->mu = ode.scene.friction;
        s->bounce = ode.scene.restitution;
        dJointAttach(dJointCreateContact(ode.world, ode.contacts, &contact[i]), p, q);
    }
}

static void add_body(const PeerBody *b, int i)
{
    dGeomID geom;
    dMass mass;
    double m = b->mass > 0 ? b->mass : 1;
    ode.body[i] = 0;
    if (b->kind == PEER_GROUND) {
        dCreatePlane(ode.space, 0, 0, 1, 0);
        return;
    }
    if (b->kind == PEER_SPHERE) {
        geom = dCreateSphere(ode.space, b->size[0]);
        dMassSetSphereTotal(&mass, m, b->size[0]);
    } else {
        double x = 2 * b->size[0], y = 2 * b->size[1], z = 2 * b->size[2];
        if (b->kind == PEER_DISC) {              /* ODE's cylinder does not meet its sphere reliably: a square top does the same */
            y = x;
            z = 2 * b->size[1];
        }
        geom = dCreateBox(ode.space, x, y, z);
        dMassSetBoxTotal(&mass, m, x, y, z);
    }
    dBodyID body = ode.body[i] = dBodyCreate(ode.world);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, b->at[0], b->at[1], b->at[2]);
    dBodySetQuaternion(body, b->turn);
    dBodySetLinearVel(body, b->v[0], b->v[1], b->v[2]);
    dBodySetAngularVel(body, b->spin[0], b->spin[1], b->spin[2]);
    if (b->mover)
        dBodySetKinematic(body);
}

int peer_open(const PeerScene *scene, const PeerSetting *setting)
{
    dInitODE2(0);
    dAllocateODEDataForThread((unsigned)dAllocateMaskAll);
    ode.scene = *scene;
    ode.setting = *setting;
    ode.messages = 0;
    dSetMessageHandler(count_message);
    ode.world = dWorldCreate();
    ode.space = dSimpleSpaceCreate(0);
    ode.contacts = dJointGroupCreate(0);
    dWorldSetGravity(ode.world, scene->gravity[0], scene->gravity[1], scene->gravity[2]);
    if (setting->iterations)
        dWorldSetQuickStepNumIterations(ode.world, setting->iterations);
    for (int i = 0; i < scene->bodies; i++)
        add_body(&scene->body[i], i);
    for (int i = 0; i < scene->hinges; i++) {
        const PeerHinge *h = &scene->hinge[i];
        dJointID joint = dJointCreateHinge(ode.world, 0);
        dJointAttach(joint, ode.body[h->to], h->from < 0 ? 0 : ode.body[h->from]);
        dJointSetHingeAnchor(joint, h->at[0], h->at[1], h->at[2]);
        dJointSetHingeAxis(joint, h->axis[0], h->axis[1], h->axis[2]);
    }
    return 1;
}

void peer_move(int body, const double v[3], const double spin[3])
{
    dBodySetLinearVel(ode.body[body], v[0], v[1], v[2]);
    dBodySetAngularVel(ode.body[body], spin[0], spin[1], spin[2]);
}

void peer_advance(int steps)
{
    double h = 1.0 / ode.setting.rate;
    for (int k = 0; k < steps; k++) {
        dSpaceCollide(ode.space, 0, touch);
        if (ode.setting.variant == DIRECT)
            dWorldStep(ode.world, h);
        else
            dWorldQuickStep(ode.world, h);
        dJointGroupEmpty(ode.contacts);
    }
}

void peer_state(int body, PeerState *state)
{
    memset(state, 0, sizeof *state);
    if (!ode.body[body])
        return;
    memcpy(state->at, dBodyGetPosition(ode.body[body]), sizeof state->at);
    memcpy(state->turn, dBodyGetQuaternion(ode.body[body]), sizeof state->turn);
    memcpy(state->v, dBodyGetLinearVel(ode.body[body]), sizeof state->v);
    memcpy(state->spin, dBodyGetAngularVel(ode.body[body]), sizeof state->spin);
}

long peer_failures(void)
{
    return ode.messages;
}

void peer_close(void)
{
    dJointGroupDestroy(ode.contacts);
    dSpaceDestroy(ode.space);
    dWorldDestroy(ode.world);
    dCloseODE();
}
