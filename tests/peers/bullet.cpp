/* tests/peers/bullet.cpp - driver of Bullet (Debian's libbullet-dev): in float as it comes, and in double with its float64 libraries.
 *
 * Defaults of btSequentialImpulseConstraintSolver (10 iterations), no sleeping, no damping. Where bodies bounce, the two
 * settings that its users are advised to take for elastic impacts: contacts count only when they touch (contact
 * processing threshold 0) and penetration is never turned into speed (split impulse at every depth). Movers are
 * kinematic bodies whose velocity is handed to the solver exactly, in the callback before each step.
 */
#include <btBulletDynamicsCommon.h>
#include <cstring>
#include <memory>
#include <vector>
#include "peer.h"

extern "C" {
#ifdef BT_USE_DOUBLE_PRECISION
const char *const peer_name = "bullet64";
#else
const char *const peer_name = "bullet";
#endif
const PeerSetting peer_settings[] = {
    {"60 Hz", 60, 0, 0, 1},     {"240 Hz", 240, 0, 0, 1},           {"960 Hz", 960, 0, 0, 1},
    {"3840 Hz", 3840, 0, 0, 1}, {"60 Hz it100", 60, 0, 100, 1},     {"240 Hz it100", 240, 0, 100, 1},
    {nullptr, 0, 0, 0, 0}
};
}

namespace {

btVector3 vector(const double v[3])
{
    return btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2]));
}

struct World {
    btDefaultCollisionConfiguration     configuration;
    btCollisionDispatcher               dispatcher{&configuration};
    btDbvtBroadphase                    broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld             dynamics{&dispatcher, &broadphase, &solver, &configuration};
    std::vector<std::unique_ptr<btCollisionShape>>  shapes;
    std::vector<std::unique_ptr<btRigidBody>>       bodies;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    std::vector<btVector3>                          v, spin;   /* of the movers */
    int rate = 60;

    ~World()
    {
        for (auto &joint : joints)
            dynamics.removeConstraint(joint.get());
        for (auto &body : bodies)
            dynamics.removeRigidBody(body.get());
    }
};

std::unique_ptr<World> world;

std::unique_ptr<btCollisionShape> make_shape(const PeerBody &b, bool boxes)
{
    const btScalar x = btScalar(b.size[0]), y = btScalar(b.size[1]), z = btScalar(b.size[2]);
    switch (b.kind) {
    case PEER_SPHERE:
        return std::make_unique<btSphereShape>(x);
    case PEER_BOX:
        return std::make_unique<btBoxShape>(btVector3(x, y, z));
    case PEER_DISC:      /* a square top: only its plane is touched */
        return std::make_unique<btBoxShape>(btVector3(x, x, y));
    default:             /* a box stands on a box with four points at once, on a plane with one more each step */
        if (boxes)
            return std::make_unique<btBoxShape>(btVector3(20, 20, 1));
        return std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0));
    }
}

void add_body(const PeerScene &scene, const PeerBody &b, bool boxes)
{
    auto shape = make_shape(b, boxes);
    btVector3 inertia(0, 0, 0);
    const btScalar mass = btScalar(b.mass);
    if (mass > 0)
        shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
    btVector3 at = vector(b.at);
    if (b.kind == PEER_GROUND && boxes)
        at.setZ(-1);
    info.m_startWorldTransform =
        btTransform(btQuaternion(btScalar(b.turn[1]), btScalar(b.turn[2]), btScalar(b.turn[3]), btScalar(b.turn[0])), at);
    info.m_friction = btSqrt(btScalar(scene.friction));          /* Bullet multiplies those of the two bodies */
    info.m_restitution = btSqrt(btScalar(scene.restitution));
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    body->setLinearVelocity(vector(b.v));
    body->setAngularVelocity(vector(b.spin));
    if (b.mover)
        body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    if (scene.restitution > 0)
        body->setContactProcessingThreshold(0);
    if (scene.hinges)
        world->dynamics.addRigidBody(body.get(), 1, 0);          /* hinged rods do not touch each other */
    else
        world->dynamics.addRigidBody(body.get());
    world->shapes.push_back(std::move(shape));
    world->bodies.push_back(std::move(body));
    world->v.push_back(btVector3(0, 0, 0));
    world->spin.push_back(btVector3(0, 0, 0));
}

void add_hinge(const PeerHinge &h)
{
    btRigidBody &to = *world->bodies[size_t(h.to)];
    const btVector3 at = vector(h.at), axis = vector(h.axis);
    std::unique_ptr<btTypedConstraint> joint;
    if (h.from < 0) {
        joint = std::make_unique<btHingeConstraint>(to, to.getWorldTransform().inverse() * at, axis);
    } else {
        btRigidBody &from = *world->bodies[size_t(h.from)];
        joint = std::make_unique<btHingeConstraint>(from, to, from.getWorldTransform().inverse() * at,
                                                    to.getWorldTransform().inverse() * at, axis, axis);
    }
    world->dynamics.addConstraint(joint.get(), true);
    world->joints.push_back(std::move(joint));
}

/* Bullet derives a kinematic body's velocity from differences of its place, which in float is mostly rounding. */
void set_movers(btDynamicsWorld *, btScalar)
{
    for (size_t i = 0; i < world->bodies.size(); i++)
        if (world->bodies[i]->isKinematicObject()) {
            world->bodies[i]->setLinearVelocity(world->v[i]);
            world->bodies[i]->setAngularVelocity(world->spin[i]);
        }
}

void place_movers(btScalar h)
{
    for (size_t i = 0; i < world->bodies.size(); i++)
        if (world->bodies[i]->isKinematicObject()) {
            btTransform to;
            btTransformUtil::integrateTransform(world->bodies[i]->getWorldTransform(), world->v[i], world->spin[i], h, to);
            world->bodies[i]->setWorldTransform(to);
        }
}

}  // namespace

extern "C" {

int peer_open(const PeerScene *scene, const PeerSetting *setting)
{
    world = std::make_unique<World>();
    world->rate = setting->rate;
    world->dynamics.setGravity(vector(scene->gravity));
    world->dynamics.setInternalTickCallback(set_movers, nullptr, true);
    btContactSolverInfo &info = world->dynamics.getSolverInfo();
    if (setting->iterations)
        info.m_numIterations = setting->iterations;
    if (scene->restitution > 0) {
        info.m_restitutionVelocityThreshold = 0;
        info.m_splitImpulse = 1;
        info.m_splitImpulsePenetrationThreshold = 0;
    }
    bool boxes = false;
    for (int i = 0; i < scene->bodies; i++)
        boxes = boxes || (scene->body[i].kind == PEER_BOX && scene->body[i].mass > 0);
    for (int i = 0; i < scene->bodies; i++)
        add_body(*scene, scene->body[i], boxes);
    for (int i = 0; i < scene->hinges; i++)
        add_hinge(scene->hinge[i]);
    return 1;
}

void peer_move(int body, const double v[3], const double spin[3])
{
    world->v[size_t(body)] = vector(v);
    world->spin[size_t(body)] = vector(spin);
}

void peer_advance(int steps)
{
    const btScalar h = btScalar(1) / btScalar(world->rate);
    for (int k = 0; k < steps; k++) {
        place_movers(h);
        world->dynamics.stepSimulation(h, 0);
    }
}

void peer_state(int body, PeerState *state)
{
    const btRigidBody &b = *world->bodies[size_t(body)];
    const btQuaternion q = b.getWorldTransform().getRotation();
    const double turn[4] = {double(q.w()), double(q.x()), double(q.y()), double(q.z())};
    std::memcpy(state->turn, turn, sizeof turn);
    for (int i = 0; i < 3; i++) {
        state->at[i] = double(b.getWorldTransform().getOrigin()[i]);
        state->v[i] = double(b.getLinearVelocity()[i]);
        state->spin[i] = double(b.getAngularVelocity()[i]);
    }
}

long peer_failures(void)
{
    return 0;
}

void peer_close(void)
{
    world.reset();
}

}
