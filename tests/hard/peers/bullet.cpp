/* tests/hard/peers/bullet.cpp - driver of Bullet (Debian's libbullet-dev, in float) for the hard cases.
 *
 * Its own defaults: sequential impulses with 10 iterations, one step a frame; no damping, no sleep. Where bodies bounce, the two
 * settings that its users are advised to take (see tests/peers/bullet.cpp). Its continuous collision detection, which a body has to
 * be given, is on for bodies that pass their own size in a frame. The ground under anything but balls is a large box, on
 * which a box stands with four points at once.
 */
#include <btBulletDynamicsCommon.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>
#include "peer.h"

namespace {

btVector3 vector(const double v[3]) { return btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2])); }

btTransform placed(const PeerState &s)
{
    return btTransform(btQuaternion(btScalar(s.turn[1]), btScalar(s.turn[2]), btScalar(s.turn[3]), btScalar(s.turn[0])), vector(s.at));
}

/* Pools that are too small make Bullet allocate in every step. */
btDefaultCollisionConstructionInfo pools(const PeerScene &scene)
{
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = scene.bodies < 500 ? 4096 : 131072;
    return info;
}

}  // namespace

struct Peer {
    explicit Peer(const PeerScene &described) : scene(&described), configuration(pools(described)) {}
    const PeerScene                    *scene;
    btDefaultCollisionConfiguration     configuration;
    btCollisionDispatcher               dispatcher{&configuration};
    btDbvtBroadphase                    broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld             dynamics{&dispatcher, &broadphase, &solver, &configuration};
    std::vector<std::unique_ptr<btCollisionShape>>  shapes;
    std::vector<std::unique_ptr<btRigidBody>>       bodies;      /* one each of the scene; empty: gone */
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    std::vector<std::unique_ptr<btJointFeedback>>   told;

    ~Peer()
    {
        for (auto &joint : joints)
            dynamics.removeConstraint(joint.get());
        for (auto &body : bodies)
            if (body)
                dynamics.removeRigidBody(body.get());
    }
};

namespace {

constexpr double hull_margin = 0.001;       /* m, of the rounded edges of a hull; its faces are moved in by as much */

/* The corner where three of the hull's faces meet, all moved in by the margin. */
btVector3 inner_corner(const PeerHull &h, int corner)
{
    double a[3][4];
    int rows = 0;
    for (int f = 0; f < h.faces && rows < 3; f++) {
        const PeerFace &face = h.face[f];
        if (std::find(face.corner, face.corner + face.corners, corner) == face.corner + face.corners)
            continue;
        for (int k = 0; k < 3; k++)
            a[rows][k] = face.normal[k];
        a[rows++][3] = face.offset - hull_margin;
    }
    auto det = [&](int x, int y, int z) {
        return a[0][x] * (a[1][y] * a[2][z] - a[1][z] * a[2][y]) - a[0][y] * (a[1][x] * a[2][z] - a[1][z] * a[2][x]) +
               a[0][z] * (a[1][x] * a[2][y] - a[1][y] * a[2][x]);
    };
    const double d = det(0, 1, 2);
    return btVector3(btScalar(det(3, 1, 2) / d), btScalar(det(0, 3, 2) / d), btScalar(det(0, 1, 3) / d));
}

std::unique_ptr<btCollisionShape> make_shape(const PeerBody &b)
{
    const btScalar x = btScalar(b.size[0]), y = btScalar(b.size[1]), z = btScalar(b.size[2]);
    if (b.kind == PEER_SPHERE)
        return std::make_unique<btSphereShape>(x);
    if (b.kind == PEER_BOX)
        return std::make_unique<btBoxShape>(btVector3(x, y, z));
    if (b.kind == PEER_CYLINDER)
        return std::make_unique<btCylinderShape>(btVector3(x, y, x));
    auto hull = std::make_unique<btConvexHullShape>();
    for (int i = 0; i < b.hull->points; i++)
        hull->addPoint(inner_corner(*b.hull, i), false);
    hull->recalcLocalAabb();
    hull->setMargin(btScalar(hull_margin));
    return hull;
}

/* A plane: as it is under balls, else the top of a box so large that nothing leaves it within the run. */
std::unique_ptr<btCollisionShape> make_plane(const PeerScene &scene, const PeerBody &plane, btTransform &at)
{
    double middle[3] = {0, 0, 0}, reach = 0, speed = 0, size = 0;
    int count = 0;
    bool round = true;
    for (int i = 0; i < scene.bodies; i++) {
        const PeerBody &b = scene.body[i];
        if (b.mass <= 0)
            continue;
        round = round && b.kind == PEER_SPHERE;
        count++;
        for (int k = 0; k < 3; k++)
            middle[k] += b.start.at[k];
    }
    at.setIdentity();
    const btVector3 normal = vector(plane.size);
    if (round || count == 0)
        return std::make_unique<btStaticPlaneShape>(normal, btScalar(plane.offset));
    for (double &m : middle)
        m /= count;
    for (int i = 0; i < scene.bodies; i++) {
        const PeerBody &b = scene.body[i];
        if (b.mass <= 0)
            continue;
        reach = std::max(reach, std::hypot(b.start.at[0] - middle[0], b.start.at[1] - middle[1], b.start.at[2] - middle[2]));
        speed = std::max(speed, std::hypot(b.start.v[0], b.start.v[1], b.start.v[2]));
        size = std::max(size, peer_reach(&b));
    }
    const double *g = scene.gravity, weight = std::hypot(g[0], g[1], g[2]);
    const double level = -(g[0] * plane.size[0] + g[1] * plane.size[1] + g[2] * plane.size[2]) / weight;
    const double slides = weight > 0 && level < 1 - 1e-9 ? 20 * weight : 0;         /* down a slope, in 6 s */
    const double half = 3 * reach + 10 * size + 30 * speed + slides, thick = half / 4;
    double depth = plane.offset - thick;
    for (int k = 0; k < 3; k++)
        depth -= plane.size[k] * middle[k];
    for (int k = 0; k < 3; k++)
        middle[k] += depth * plane.size[k];
    at.setRotation(shortestArcQuat(btVector3(0, 1, 0), normal));
    at.setOrigin(vector(middle));
    return std::make_unique<btBoxShape>(btVector3(btScalar(half), btScalar(thick), btScalar(half)));
}

void add_body(Peer &p, const PeerBody &b, int i)
{
    const PeerScene &scene = *p.scene;
    btTransform at = placed(b.start);
    auto shape = b.kind == PEER_PLANE ? make_plane(scene, b, at) : make_shape(b);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(b.mass), nullptr, shape.get(), vector(b.inertia));
    info.m_startWorldTransform = at;
    info.m_friction = btScalar(std::sqrt(b.friction));              /* Bullet multiplies those of the two bodies */
    info.m_restitution = btScalar(std::sqrt(scene.restitution));
    if (b.rolling > 0 && b.friction > 0)                            /* and the rolling of one with the friction of the other */
        info.m_rollingFriction = btScalar(b.rolling / std::sqrt(b.friction));
    auto body = std::make_unique<btRigidBody>(info);
    body->setUserIndex(i);
    body->setActivationState(DISABLE_DEACTIVATION);
    body->setLinearVelocity(vector(b.start.v));
    body->setAngularVelocity(vector(b.start.spin));
    if (b.driven)
        body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    if (scene.restitution > 0)
        body->setContactProcessingThreshold(0);
    const double least = b.kind == PEER_BOX ? std::min({b.size[0], b.size[1], b.size[2]}) : b.size[0];
    if (b.mass > 0 && std::hypot(b.start.v[0], b.start.v[1], b.start.v[2]) * scene.step > least) {
        body->setCcdMotionThreshold(btScalar(least));
        body->setCcdSweptSphereRadius(btScalar(0.9 * least));
    }
    const int bit = 1 << (b.group % 30);
    p.dynamics.addRigidBody(body.get(), b.ghost ? 0 : bit, b.ghost ? 0 : b.group ? ~bit : -1);
    p.shapes.push_back(std::move(shape));
    p.bodies.push_back(std::move(body));
}

btVector3 carried(const btRigidBody &b, const double at[3]) { return b.getWorldTransform().inverse() * vector(at); }

btVector3 carried_axis(const btRigidBody &b, const double axis[3]) { return b.getWorldTransform().getBasis().transpose() * vector(axis); }

std::unique_ptr<btTypedConstraint> make_hinge(const Peer &p, const PeerJoint &j, btRigidBody &a, btRigidBody *b)
{
    std::unique_ptr<btHingeConstraint> hinge;
    if (b)
        hinge = std::make_unique<btHingeConstraint>(*b, a, carried(*b, j.at[1]), carried(a, j.at[0]), carried_axis(*b, j.axis),
                                                    carried_axis(a, j.axis));
    else
        hinge = std::make_unique<btHingeConstraint>(a, carried(a, j.at[0]), carried_axis(a, j.axis));
    if (j.limited)
        hinge->setLimit(btScalar(j.lower), btScalar(j.upper));
    if (j.motor_torque > 0)
        hinge->enableAngularMotor(true, btScalar(j.motor_speed), btScalar(j.motor_torque * p.scene->step));
    return hinge;
}

/* A frame at a point whose x axis points along; in the body, or in the world. */
btTransform frame_at(const btRigidBody *body, const double at[3], const btVector3 &along)
{
    const btTransform world(shortestArcQuat(btVector3(1, 0, 0), along), vector(at));
    return body ? body->getWorldTransform().inverse() * world : world;
}

/* A spring along the first axis of a joint that leaves everything else free. */
std::unique_ptr<btTypedConstraint> make_spring(const PeerJoint &j, btRigidBody &a, btRigidBody *b)
{
    const btVector3 along = (vector(j.at[0]) - vector(j.at[1])).normalized();           /* from b to a */
    btRigidBody &other = b ? *b : btTypedConstraint::getFixedBody();
    auto spring = std::make_unique<btGeneric6DofSpring2Constraint>(other, a, frame_at(b, j.at[1], along), frame_at(&a, j.at[0], along));
    for (int axis = 0; axis < 6; axis++)
        spring->setLimit(axis, 1, -1);
    spring->enableSpring(0, true);
    spring->setStiffness(0, btScalar(j.stiffness));
    spring->setDamping(0, btScalar(j.damping));
    spring->setEquilibriumPoint(0, btScalar(j.length));
    return spring;
}

std::unique_ptr<btTypedConstraint> make_joint(const Peer &p, const PeerJoint &j)
{
    btRigidBody &a = *p.bodies[size_t(j.a)], *b = j.b < 0 ? nullptr : p.bodies[size_t(j.b)].get();
    if (j.kind == PEER_HINGE)
        return make_hinge(p, j, a, b);
    if (j.kind == PEER_SPRING)
        return make_spring(j, a, b);
    if (j.kind == PEER_BALL && b)
        return std::make_unique<btPoint2PointConstraint>(a, *b, carried(a, j.at[0]), carried(*b, j.at[1]));
    if (j.kind == PEER_BALL)
        return std::make_unique<btPoint2PointConstraint>(a, carried(a, j.at[0]));
    const btVector3 along = vector(j.axis);
    if (b)
        return std::make_unique<btSliderConstraint>(*b, a, frame_at(b, j.at[1], along), frame_at(&a, j.at[0], along), true);
    return std::make_unique<btSliderConstraint>(a, frame_at(&a, j.at[0], along), true);
}

/* Bullet derives a kinematic body's velocity from differences of its place, which in float is mostly rounding. */
void set_movers(btDynamicsWorld *world, btScalar)
{
    const Peer &p = *static_cast<Peer *>(world->getWorldUserInfo());
    for (size_t i = 0; i < p.bodies.size(); i++)
        if (p.scene->body[i].driven && p.bodies[i]) {
            p.bodies[i]->setLinearVelocity(vector(p.scene->body[i].drive[0]));
            p.bodies[i]->setAngularVelocity(vector(p.scene->body[i].drive[1]));
        }
}

}  // namespace

extern "C" {

extern const char *const peer_name;
const char *const peer_name = "bullet";

Peer *peer_open(const PeerScene *scene, char *, size_t)
{
    auto p = std::make_unique<Peer>(*scene);
    p->dynamics.setGravity(vector(scene->gravity));
    p->dynamics.setInternalTickCallback(set_movers, p.get(), true);
    if (scene->restitution > 0) {
        btContactSolverInfo &info = p->dynamics.getSolverInfo();
        info.m_restitutionVelocityThreshold = 0;
        info.m_splitImpulse = 1;
        info.m_splitImpulsePenetrationThreshold = 0;
    }
    for (int i = 0; i < scene->bodies; i++)
        if (scene->body[i].gone)
            p->bodies.push_back(nullptr);
        else
            add_body(*p, scene->body[i], i);
    for (int i = 0; i < scene->joints; i++) {
        auto joint = make_joint(*p, scene->joint[i]);
        p->told.push_back(std::make_unique<btJointFeedback>());
        joint->setJointFeedback(p->told.back().get());
        p->dynamics.addConstraint(joint.get(), true);
        p->joints.push_back(std::move(joint));
    }
    return p.release();
}

void peer_step(Peer *p)
{
    const btScalar h = btScalar(p->scene->step);
    for (size_t i = 0; i < p->bodies.size(); i++) {
        const PeerBody &b = p->scene->body[i];
        btTransform to;
        if (!b.driven || !p->bodies[i])
            continue;
        btTransformUtil::integrateTransform(p->bodies[i]->getWorldTransform(), vector(b.drive[0]), vector(b.drive[1]), h, to);
        p->bodies[i]->setWorldTransform(to);
    }
    p->dynamics.stepSimulation(h, 0);
}

void peer_states(Peer *p, PeerState *out)
{
    for (size_t i = 0; i < p->bodies.size(); i++) {
        if (!p->bodies[i] || p->scene->body[i].kind == PEER_PLANE)
            continue;
        const btRigidBody &b = *p->bodies[i];
        const btQuaternion q = b.getWorldTransform().getRotation();
        PeerState &s = out[i];
        s.turn[0] = double(q.w()), s.turn[1] = double(q.x()), s.turn[2] = double(q.y()), s.turn[3] = double(q.z());
        for (int k = 0; k < 3; k++) {
            s.at[k] = double(b.getWorldTransform().getOrigin()[k]);
            s.v[k] = double(b.getLinearVelocity()[k]);
            s.spin[k] = double(b.getAngularVelocity()[k]);
        }
    }
}

void peer_push(Peer *p, int body, const double impulse[3]) { p->bodies[size_t(body)]->applyCentralImpulse(vector(impulse)); }

bool peer_joint_force(Peer *p, int joint, double force[3])
{
    for (int k = 0; k < 3; k++)
        force[k] = double(p->told[size_t(joint)]->m_appliedForceBodyA[k]);
    return true;
}

int peer_touches(Peer *p, PeerTouch *out, int room)
{
    int n = 0;
    for (int m = 0; m < p->dispatcher.getNumManifolds(); m++) {
        const btPersistentManifold &pair = *p->dispatcher.getManifoldByIndexInternal(m);
        for (int c = 0; c < pair.getNumContacts() && n < room; c++) {
            const btManifoldPoint &point = pair.getContactPoint(c);         /* its normal points from the second to the first */
            const btVector3 push = (point.m_normalWorldOnB * point.m_appliedImpulse + point.m_lateralFrictionDir1 *
                                    point.m_appliedImpulseLateral1 + point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2) /
                                   btScalar(p->scene->step);
            const double force[3] = {double(push.x()), double(push.y()), double(push.z())};
            out[n] = {pair.getBody1()->getUserIndex(), pair.getBody0()->getUserIndex(), {force[0], force[1], force[2]}};
            n++;
        }
    }
    return n;
}

void peer_close(Peer *p) { delete p; }

}
