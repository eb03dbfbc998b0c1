/* tests/bench/ode.c - driver of ODE (Debian's libode-dev, double): quick step with its 20 iterations, sweep and prune, 4 contacts a pair.
 *
 * With two threads its islands are shared out by its own thread pool, where the library was built with it.
 */
#include <ode/ode.h>
#include <stdlib.h>
#include <string.h>
#include "engine.h"

enum { POINTS = 4 };

const char *const bench_engine = "ode";

static struct {
    dWorldID          world;
    dSpaceID          space;
    dJointGroupID     contacts;
    dBodyID          *body;
    const BenchScene *scene;
    Icosahedron       ico;
    dReal             point[3 * HULL_POINTS], plane[4 * HULL_FACES];     /* of the one hull that a scene has */
    unsigned          face[4 * HULL_FACES];
    int               count;
} ode;

static void touch(void *data, dGeomID a, dGeomID b)
{
    (void)data;
    dBodyID p = dGeomGetBody(a), q = dGeomGetBody(b);
    if ((!p || !dBodyIsEnabled(p)) && (!q || !dBodyIsEnabled(q)))
        return;
    if (p && q && dAreConnectedExcluding(p, q, dJointTypeContact))
        return;
    dContact contact[POINTS];
    int n = dCollide(a, b, POINTS, &contact[0].geom, sizeof *contact);
    for (int i = 0; i < n; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 0.5;
        dJointAttach(dJointCreateContact(ode.world, ode.contacts, &contact[i]), p, q);
    }
    ode.count += n;
}

static dGeomID make_hull(double radius)
{
    for (int i = 0; i < 3 * HULL_POINTS; i++)
        ode.point[i] = ode.ico.point[i / 3][i % 3] * radius;
    for (int i = 0; i < HULL_FACES; i++) {
        const double *corner = ode.ico.point[ode.ico.face[i][0]], *n = ode.ico.normal[i];
        ode.plane[4 * i + 3] = (corner[0] * n[0] + corner[1] * n[1] + corner[2] * n[2]) * radius;
        ode.face[4 * i] = 3;
        for (int k = 0; k < 3; k++) {
            ode.plane[4 * i + k] = n[k];
            ode.face[4 * i + 1 + k] = (unsigned)ode.ico.face[i][k];
        }
    }
    return dCreateConvex(ode.space, ode.plane, HULL_FACES, ode.point, HULL_POINTS, ode.face);
}

static dGeomID make_geom(const BenchBody *b, dMass *mass)
{
    const double *r = b->size;
    switch (b->kind) {
    case BENCH_SPHERE:
        dMassSetSphere(mass, 1000, r[0]);
        return dCreateSphere(ode.space, r[0]);
    case BENCH_BOX:
        dMassSetBox(mass, 1000, 2 * r[0], 2 * r[1], 2 * r[2]);
        return dCreateBox(ode.space, 2 * r[0], 2 * r[1], 2 * r[2]);
    case BENCH_CAPSULE:
        dMassSetCapsule(mass, 1000, 2, r[0], 2 * r[1]);
        return dCreateCapsule(ode.space, r[0], 2 * r[1]);
    default:
        dMassSetSphereTotal(mass, 1000 * bench_volume(b), r[0]);
        return make_hull(r[0]);
    }
}

static void add_body(const BenchBody *b, int i)
{
    const dQuaternion turn = {b->turn[3], b->turn[0], b->turn[1], b->turn[2]};
    dMass mass;
    dGeomID geom = make_geom(b, &mass);
    if (b->fixed) {
        dGeomSetPosition(geom, b->at[0], b->at[1], b->at[2]);
        dGeomSetQuaternion(geom, turn);
        return;
    }
    dBodyID body = ode.body[i] = dBodyCreate(ode.world);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, b->at[0], b->at[1], b->at[2]);
    dBodySetQuaternion(body, turn);
    if (b->kind == BENCH_CAPSULE) {             /* ODE's lies along z */
        const dQuaternion upright = {0.70710678118654752, -0.70710678118654752, 0, 0};
        dGeomSetOffsetQuaternion(geom, upright);
    }
}

static bool share_out(int threads)
{
    dThreadingImplementationID sharing = dThreadingAllocateMultiThreadedImplementation();
    dThreadingThreadPoolID pool = sharing ? dThreadingAllocateThreadPool((unsigned)threads, 0, dAllocateFlagBasicData, NULL) : NULL;
    if (!pool)
        return false;
    dThreadingThreadPoolServeMultiThreadedImplementation(pool, sharing);
    dWorldSetStepThreadingImplementation(ode.world, dThreadingImplementationGetFunctions(sharing), sharing);
    return true;
}

bool bench_open(const BenchScene *scene, int threads)
{
    dInitODE2(0);
    dAllocateODEDataForThread((unsigned)dAllocateMaskAll);
    bench_icosahedron(&ode.ico);
    ode.scene = scene;
    ode.world = dWorldCreate();
    ode.space = dSweepAndPruneSpaceCreate(0, dSAP_AXES_XZY);
    ode.contacts = dJointGroupCreate(0);
    ode.body = calloc((size_t)scene->bodies, sizeof *ode.body);
    if (!ode.body || (threads > 1 && !share_out(threads))) {
        fprintf(stderr, "ode: no threads in this build of the library\n");
        return false;
    }
    dWorldSetGravity(ode.world, 0, -9.81, 0);
    dWorldSetQuickStepNumIterations(ode.world, 20);
    if (scene->sleeping)
        dWorldSetAutoDisableFlag(ode.world, 1);
    for (int i = 0; i < scene->bodies; i++)
        add_body(&scene->body[i], i);
    for (int i = 0; i < scene->joints; i++) {
        const BenchJoint *j = &scene->joint[i];
        dJointID joint = dJointCreateBall(ode.world, 0);
        dJointAttach(joint, ode.body[j->a], ode.body[j->b]);
        dJointSetBallAnchor(joint, j->at[0], j->at[1], j->at[2]);
    }
    return true;
}

void bench_step(void)
{
    ode.count = 0;
    dSpaceCollide(ode.space, 0, touch);
    dWorldQuickStep(ode.world, 1.0 / 60);
    dJointGroupEmpty(ode.contacts);
}

void bench_sample(void) {}

void bench_pose(int body, BenchPose *pose)
{
    const BenchBody *b = &ode.scene->body[body];
    memcpy(pose->at, b->at, sizeof pose->at);
    memcpy(pose->turn, b->turn, sizeof pose->turn);
    if (!ode.body[body])
        return;
    memcpy(pose->at, dBodyGetPosition(ode.body[body]), sizeof pose->at);
    const dReal *q = dBodyGetQuaternion(ode.body[body]);
    for (int i = 0; i < 4; i++)
        pose->turn[i] = q[(i + 1) % 4];
}

int bench_awake(void)
{
    int awake = 0;
    for (int i = 0; i < ode.scene->bodies; i++)
        awake += ode.body[i] && dBodyIsEnabled(ode.body[i]);
    return awake;
}

void bench_kick(int body, const double v[3])
{
    dBodyEnable(ode.body[body]);
    dBodySetLinearVel(ode.body[body], v[0], v[1], v[2]);
}

void bench_report(FILE *out) { fprintf(out, ", points = %d", ode.count); }
