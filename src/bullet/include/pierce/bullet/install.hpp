#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pierce/world.hpp"

class btSoftBody;

namespace pierce::bullet {

/// What install() does by itself.
struct InstallOptions {
    /// Binds every triangle mesh (GImpact, BVH, scaled) and every soft body that has an inside, at
    /// the next step, and follows what is added, removed and changed. False: only what bind() names
    /// is bound.
    bool automatic = true;
    std::uint32_t most_per_pair = 24;  ///< contacts of two rigid bodies that reach the solver
    /// Two rigid bodies that are apart get contacts before they touch, if one of them is fast:
    /// where it moves further in a step than its `setCcdMotionThreshold()`, as with Bullet's own
    /// continuous collisions, which know convex shapes only. Bodies whose threshold is 0, Bullet's
    /// default, are never fast.
    bool continuous = true;
};

/// An object that Bullet still handles although it has a mesh, and why.
struct LeftToBullet {
    const btCollisionObject* object = nullptr;
    std::string why;
};

/// Pierce as the narrow phase of a Bullet world. Pairs of two bound objects get Pierce's contacts,
/// and all others Bullet's own. Pierce looks for contacts once in a step in which some bound object
/// has moved; what sleeps keeps its contacts, which are not looked for again.
///
/// Rigid contacts go into persistent manifolds, reduced per pair, and keep their impulses from step
/// to step by vertex. Soft contacts go into the soft bodies' own contact arrays with the hit
/// triangle's barycentric weights. Pairs that Bullet's broad phase and filters leave out get no
/// contacts.
class Installation {
public:
    Installation(const Installation&) = delete;
    Installation& operator=(const Installation&) = delete;

    /// Binds an object that is not soft: from now on its world transform moves `body`, and contacts
    /// of `body` push it. Here and below, what the object or the body was bound to before is
    /// unbound. An object that was bound by hand stays so until unbind(). Throws InputError for a
    /// body that was made for another object, which is followed.
    void bind(btCollisionObject& object, BodyId body);
    /// Binds a soft body, which must have one node per vertex of the mesh, in their order. Throws
    /// InputError if the counts differ, too. If they change later, as where the body tears, bind it
    /// again.
    void bind(btSoftBody& soft, BodyId body);
    /// Ends a binding, at any time between two steps; nothing happens if there is none. Nothing in
    /// Bullet or here points to the object afterwards on Pierce's account, and its pairs get
    /// Bullet's own contacts. An object that was bound by hand must be unbound before it is
    /// deleted.
    void unbind(const btCollisionObject& object);

    /// The body of an object; a null handle if it is not bound.
    BodyId body_of(const btCollisionObject& object) const;
    /// Which meshes and soft bodies the last look for new objects left to Bullet.
    const std::vector<LeftToBullet>& left_to_bullet() const;

    /// True if Pierce looked for contacts in the last step.
    bool has_detected() const;
    /// Time the last step took to turn contacts into what Bullet's solver works on [ms].
    double response_milliseconds() const;
    /// Number of contacts that reached Bullet's solver in the last step; the World has all
    /// contacts.
    std::uint32_t reduced_contacts() const;

private:
    friend Installation& install(btDiscreteDynamicsWorld& bullet, World& contacts,
                                 const InstallOptions& options);
    friend void uninstall(btDiscreteDynamicsWorld& bullet);
    struct State;
    explicit Installation(std::unique_ptr<State> state);
    ~Installation();
    std::unique_ptr<State> state_;
};

/// Makes `contacts` the narrow phase of a Bullet world for meshes and soft bodies. The world's
/// dispatcher must be a btCollisionDispatcher, of which it uses the near callback and the collision
/// configuration; it adds an action to the world. From then on Bullet calls detect(). `contacts`
/// must live as long as the Bullet world, or until uninstall(), which gives the memory back. Throws
/// InputError for another dispatcher, if Pierce is installed already, or if `most_per_pair` is less
/// than least_reduced.
Installation& install(btDiscreteDynamicsWorld& bullet, World& contacts,
                      const InstallOptions& options = {});

/// Ends all bindings and leaves the Bullet world as it was before install(); nothing happens if
/// Pierce is not installed. The bodies and meshes that install() has made are removed. Must be
/// called before the Bullet world ends if its dispatcher lives on.
void uninstall(btDiscreteDynamicsWorld& bullet);

}  // namespace pierce::bullet
