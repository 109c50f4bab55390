#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
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
    /// True if the object is followed, whether it is bound or left to Bullet.
    bool knows(const btCollisionObject& object) const { return made_.contains(&object); }
    /// True if the body was made here, for some object.
    bool has_made(BodyId body) const;
    /// Removes all bindings, bodies and meshes that were made here.
    void remove_all();
    const std::vector<LeftToBullet>& left_to_bullet() const { return left_; }

private:
    /// What a binding was made for; another one at the same address differs in it.
    struct Kind {
        const btCollisionObject* object = nullptr;
        const void* mark = nullptr;  ///< that bound objects have, and new ones have not
        const btCollisionShape* shape = nullptr;
        std::uint64_t shape_mark = 0;         ///< mark_of() a rigid object's shape
        std::array<std::uint32_t, 9> size{};  ///< scaling and local box of a rigid object's shape,
                                              ///< as the bits of float32
        int proxy = 0;  ///< Bullet's number of the object in its broad phase; some broad phases use
                        ///< numbers again
        bool fixed = false;
        const void* first_node = nullptr;  ///< of a soft body, like the next three
        const void* first_face = nullptr;
        int nodes = 0, faces = 0;

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
    void leave_to_bullet(const btCollisionObject& object, std::string why);
    void remove(const Made& made);
    void remove_unused(MeshId mesh);
    MeshId mesh_for(const btCollisionShape& shape);

    const btCollisionWorld& bullet_;
    Coupling& coupling_;
    std::vector<Kind> seen_;  ///< the objects of Bullet's world, in its order
    std::unordered_map<const btCollisionObject*, Made> made_;
    std::unordered_map<const btCollisionObject*, Kind> alone_;  ///< those that are not followed
    std::map<std::pair<const btCollisionShape*, std::uint64_t>, MeshId> meshes_;  ///< by shape and
                                                                                  ///< its mark
    std::map<MeshId, int> users_;  ///< bodies with a mesh that was made here
    std::vector<LeftToBullet> left_;
};

}  // namespace pierce::bullet
