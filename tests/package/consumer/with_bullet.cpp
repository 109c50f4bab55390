#include <btBulletCollisionCommon.h>
#include <pierce/bullet/bullet_dispatcher.hpp>

int main() {
    btDefaultCollisionConfiguration configuration;
    pierce::World world;
    const pierce::bullet::Dispatcher dispatcher(&configuration, world);
    return dispatcher.reduced_contacts() == 0 ? 0 : 1;
}
