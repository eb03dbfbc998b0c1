/* tests/bench/bullet.cpp - driver of Bullet (Debian's libbullet-dev, in float): its defaults, 10 iterations, one thread.
 *
 * Bounds of bodies that do not move are left alone, which is Bullet's own setting for large worlds.
 */
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>
#include <vector>
#include "engine.h"

extern "C" {
extern const char *const bench_engine;
const char *const bench_engine = "bullet";
}

namespace {

constexpr btScalar hull_margin = btScalar(0.005);

/* Pools that are too small make Bullet allocate in every step. */
btDefaultCollisionConstructionInfo pools(const BenchScene &scene)
{
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = scene.bodies < 2000 ? 8192 : 131072;
    return info;
}

struct World {
    explicit World(const BenchScene &scene) : configuration(pools(scene)) {}
    btDefaultCollisionConfiguration     configuration;
    btCollisionDispatcher               dispatcher{&configuration};
    btDbvtBroadphase                    broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld             dynamics{&dispatcher, &broadphase, &solver, &configuration};
    std::map<std::tuple<int, double, double, double>, std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>>       bodies;
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
};

World *world;      /* ends with the process */

std::unique_ptr<btCollisionShape> make_shape(const BenchBody &b)
{
    const btScalar x = btScalar(b.size[0]), y = btScalar(b.size[1]), z = btScalar(b.size[2]);
    if (b.kind == BENCH_SPHERE)
        return std::make_unique<btSphereShape>(x);
    if (b.kind == BENCH_BOX)
        return std::make_unique<btBoxShape>(btVector3(x, y, z));
    if (b.kind == BENCH_CAPSULE)
        return std::make_unique<btCapsuleShape>(x, 2 * y);
    auto hull = std::make_unique<btConvexHullShape>();
    Icosahedron ico;
    bench_icosahedron(&ico);
    for (const auto &p : ico.point)
        hull->addPoint(btVector3(btScalar(p[0]), btScalar(p[1]), btScalar(p[2])) * x, false);
    hull->recalcLocalAabb();
    hull->setMargin(hull_margin);
    return hull;
}

void add_body(const BenchScene &scene, const BenchBody &b)
{
    auto &shape = world->shapes[std::make_tuple(b.kind, b.size[0], b.size[1], b.size[2])];
    if (!shape)
        shape = make_shape(b);
    const btScalar mass = b.fixed ? btScalar(0) : btScalar(1000 * bench_volume(&b));
    btVector3 inertia(0, 0, 0);
    if (mass > 0)
        shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
    info.m_startWorldTransform =
        btTransform(btQuaternion(btScalar(b.turn[0]), btScalar(b.turn[1]), btScalar(b.turn[2]), btScalar(b.turn[3])),
                    btVector3(btScalar(b.at[0]), btScalar(b.at[1]), btScalar(b.at[2])));
    info.m_friction = btSqrt(btScalar(0.5));        /* Bullet multiplies those of the two bodies */
    info.m_restitution = 0;
    auto body = std::make_unique<btRigidBody>(info);
    if (!scene.sleeping && mass > 0)
        body->setActivationState(DISABLE_DEACTIVATION);
    world->dynamics.addRigidBody(body.get());
    world->bodies.push_back(std::move(body));
}

}  // namespace

extern "C" {

bool bench_open(const BenchScene *scene, int threads)
{
    if (threads > 1) {
        fprintf(stderr, "bullet: Debian's library is built for one thread\n");
        return false;
    }
    world = new World(*scene);
    world->dynamics.setGravity(btVector3(0, btScalar(-9.81), 0));
    world->dynamics.setForceUpdateAllAabbs(false);
    for (int i = 0; i < scene->bodies; i++)
        add_body(*scene, scene->body[i]);
    for (int i = 0; i < scene->joints; i++) {
        const BenchJoint &j = scene->joint[i];
        const btVector3 at(btScalar(j.at[0]), btScalar(j.at[1]), btScalar(j.at[2]));
        btRigidBody &a = *world->bodies[size_t(j.a)], &b = *world->bodies[size_t(j.b)];
        auto joint = std::make_unique<btPoint2PointConstraint>(a, b, a.getWorldTransform().inverse() * at,
                                                               b.getWorldTransform().inverse() * at);
        world->dynamics.addConstraint(joint.get(), true);
        world->joints.push_back(std::move(joint));
    }
    return true;
}

void bench_step(void) { world->dynamics.stepSimulation(btScalar(1) / 60, 0); }

void bench_sample(void) {}

void bench_pose(int body, BenchPose *pose)
{
    const btTransform &t = world->bodies[size_t(body)]->getWorldTransform();
    const btQuaternion q = t.getRotation();
    *pose = {{double(t.getOrigin().x()), double(t.getOrigin().y()), double(t.getOrigin().z())},
             {double(q.x()), double(q.y()), double(q.z()), double(q.w())}};
}

int bench_awake(void)
{
    int awake = 0;
    for (const auto &b : world->bodies)
        awake += !b->isStaticObject() && b->getActivationState() != ISLAND_SLEEPING;
    return awake;
}

void bench_kick(int body, const double v[3])
{
    world->bodies[size_t(body)]->activate(true);
    world->bodies[size_t(body)]->setLinearVelocity(btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2])));
}

void bench_report(FILE *out)
{
    int points = 0, touching = 0;
    for (int i = 0; i < world->dispatcher.getNumManifolds(); i++) {
        const int k = world->dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
        points += k;
        touching += k > 0;
    }
    fprintf(out, ", contacts = %d, points = %d, pairs = %d", touching, points, world->dispatcher.getNumManifolds());
}

}
