#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <memory>

#include "pierce/bullet/contact_reduction.hpp"
#include "pierce/world.hpp"

class btRigidBody;
class btSoftBody;

namespace pierce::bullet {

/// Bullet's dispatcher with Pierce as the narrow phase. Give it to any Bullet world in place of
/// btCollisionDispatcher and bind the bodies Pierce should look after; pairs of two bound objects
/// get Pierce's contacts, all others Bullet's own.
///
/// Rigid contacts go into persistent manifolds, reduced per pair, and keep their impulses from step
/// to step by vertex. Soft contacts go into the soft bodies' own contact arrays with the hit
/// triangle's barycentric weights. Pairs are found by Pierce; Bullet's broad phase still decides
/// islands, so it must see the same objects.
class Dispatcher : public btCollisionDispatcher {
public:
    /// `world` must outlive the dispatcher.
    Dispatcher(btCollisionConfiguration* configuration, World& world,
               ReductionSettings reduction = {});
    ~Dispatcher() override;

    /// From now on the rigid body's world transform moves `body`, and contacts of `body` push the
    /// rigid body.
    void bind(btRigidBody& rigid, BodyId body);
    /// The same for a soft body with one node per vertex and one face per triangle of the mesh, in
    /// their order. Throws InputError if the counts differ.
    void bind(btSoftBody& soft, BodyId body);

    /// Called by Bullet once a step.
    void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                   btDispatcher* dispatcher) override;

    /// Time the last step took to turn contacts into what Bullet's solver works on [ms].
    double response_milliseconds() const;
    /// Contacts that reached Bullet's solver in the last step; the world has them all.
    std::uint32_t reduced_contacts() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
