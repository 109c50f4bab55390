#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <map>
#include <unordered_map>
#include <vector>

#include "bullet/coupling.hpp"
#include "pierce/bullet/install.hpp"

namespace pierce::bullet {

/// Binds what a Bullet world has in meshes and closed soft bodies, and follows what is added,
/// removed and changed.
class FollowedObjects {
public:
    FollowedObjects(const btCollisionWorld& bullet, Coupling& coupling)
        : bullet_(bullet), coupling_(coupling) {}

    /// Makes the bindings those of the objects that there are now; true if anything has changed.
    /// Cheap if not.
    bool follow();
    /// Ends what was made for the object, which is not followed any more.
    void leave(const btCollisionObject& object);
    /// Removes all bindings, bodies and meshes that were made here.
    void remove_all();
    const std::vector<LeftToBullet>& left_to_bullet() const { return left_; }

private:
    /// What a binding was made for; another one at the same address differs in it.
    struct Kind {
        const btCollisionObject* object = nullptr;
        const btCollisionShape* shape = nullptr;
        int proxy = 0;  ///< Bullet's number of the object in its broad phase, which is not used
                        ///< again
        bool fixed = false;
        int nodes = 0, faces = 0;  ///< of a soft body

        friend bool operator==(const Kind&, const Kind&) = default;
    };
    /// What was made for an object.
    struct Made {
        Kind kind;
        BodyId body;  ///< null if Bullet handles it
        MeshId mesh;
    };

    static Kind kind_of(const btCollisionObject& object);
    Made make(btCollisionObject& object);
    void remove(const Made& made);
    MeshId mesh_for(const btCollisionShape& shape);

    const btCollisionWorld& bullet_;
    Coupling& coupling_;
    std::vector<Kind> seen_;  ///< the objects of Bullet's world, in its order
    std::unordered_map<const btCollisionObject*, Made> made_;
    std::unordered_map<const btCollisionObject*, Kind> alone_;  ///< those that are not followed
    std::map<const btCollisionShape*, MeshId> meshes_;
    std::map<MeshId, int> users_;  ///< bodies with a mesh that was made here
    std::vector<LeftToBullet> left_;
};

}  // namespace pierce::bullet
