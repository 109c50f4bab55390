#include <btBulletCollisionCommon.h>
#include <btBulletDynamicsCommon.h>
#include <pierce/bullet/install.hpp>

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld bullet(&dispatcher, &broadphase, &solver, &configuration);
    pierce::World contacts;
    const bool none = pierce::bullet::install(bullet, contacts).reduced_contacts() == 0;
    pierce::bullet::uninstall(bullet);
    return none ? 0 : 1;
}
