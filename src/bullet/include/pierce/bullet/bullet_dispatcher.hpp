#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>

#include <memory>

#include "pierce/bullet/contact_reduction.hpp"
#include "pierce/world.hpp"

class btRigidBody;
class btSoftBody;

namespace pierce::bullet {

/// Bullet's dispatcher with Pierce as the narrow phase. Give it to any Bullet world in place of
/// btCollisionDispatcher and bind the bodies that Pierce should handle. Pairs of two bound objects
/// get Pierce's contacts, and all others get Bullet's own.
///
/// Rigid contacts go into persistent manifolds, reduced per pair, and keep their impulses from step
/// to step by vertex. Soft contacts go into the soft bodies' own contact arrays with the hit
/// triangle's barycentric weights. Pierce finds the pairs. Bullet's broad phase still decides which
/// bodies form an island, so it must see the same objects.
class Dispatcher : public btCollisionDispatcher {
public:
    /// `world` must outlive the dispatcher.
    Dispatcher(btCollisionConfiguration* configuration, World& world,
               ReductionSettings reduction = {});
    ~Dispatcher() override;

    /// Binds a rigid body: from now on its world transform moves `body`, and contacts of `body`
    /// push it. Here and below, what the object or the body was bound to before is unbound.
    void bind(btRigidBody& rigid, BodyId body);
    /// Binds a soft body, which must have one node per vertex of the mesh, in their order. Throws
    /// InputError if the counts differ. If they change later, as where the body tears, bind it
    /// again.
    void bind(btSoftBody& soft, BodyId body);
    /// Ends a binding, at any time between two steps; nothing happens if there is none. Nothing in
    /// Bullet or here points to the object afterwards on Pierce's account, and its pairs get
    /// Bullet's own contacts. An object must be unbound before it is deleted.
    void unbind(const btCollisionObject& object);

    /// Bullet calls this once per step.
    void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                   btDispatcher* dispatcher) override;

    /// Time the last step took to turn contacts into what Bullet's solver works on [ms].
    double response_milliseconds() const;
    /// Number of contacts that reached Bullet's solver in the last step; the world has all
    /// contacts.
    std::uint32_t reduced_contacts() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
