#include "bullet/followed_objects.hpp"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>

#include <optional>
#include <utility>

#include "bullet/shape_mesh.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {

FollowedObjects::Kind FollowedObjects::kind_of(const btCollisionObject& object) {
    const btSoftBody* soft = btSoftBody::upcast(&object);
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    return {.object = &object,
            .shape = object.getCollisionShape(),
            .proxy = proxy != nullptr ? proxy->getUid() : -1,
            .fixed = object.isStaticObject(),
            .nodes = soft != nullptr ? soft->m_nodes.size() : 0,
            .faces = soft != nullptr ? soft->m_faces.size() : 0};
}

bool FollowedObjects::follow() {
    const btCollisionObjectArray& objects = bullet_.getCollisionObjectArray();
    bool as_before = seen_.size() == static_cast<std::size_t>(objects.size());
    for (int i = 0; as_before && i < objects.size(); ++i)
        as_before = seen_[static_cast<std::size_t>(i)] == kind_of(*objects[i]);
    if (as_before) return false;

    seen_.clear();
    std::unordered_map<const btCollisionObject*, Made> kept;
    std::vector<btCollisionObject*> others;
    for (int i = 0; i < objects.size(); ++i) {
        const Kind kind = kind_of(*objects[i]);
        seen_.push_back(kind);
        const auto last = made_.find(objects[i]);
        if (last != made_.end() && last->second.kind == kind)
            kept.insert(made_.extract(last));
        else
            others.push_back(objects[i]);
    }
    // Before anything new comes, maybe to the same address.
    for (const auto& [object, made] : made_) remove(made);
    if (!made_.empty()) coupling_.forget_soft_contacts();
    std::erase_if(left_, [&](const LeftToBullet& left) { return !kept.contains(left.object); });
    made_ = std::move(kept);
    for (btCollisionObject* object : others) {
        if (coupling_.find(object) != nullptr) continue;  // bound by hand
        const auto alone = alone_.find(object);
        if (alone != alone_.end() && alone->second == kind_of(*object)) continue;
        made_.emplace(object, make(*object));
    }
    return true;
}

void FollowedObjects::leave(const btCollisionObject& object) {
    alone_.insert_or_assign(&object, kind_of(object));
    if (const auto last = made_.find(&object); last != made_.end()) {
        remove(last->second);
        made_.erase(last);
    }
}

void FollowedObjects::remove_all() {
    for (const auto& [object, made] : made_) remove(made);
    made_.clear();
    seen_.clear();
}

void FollowedObjects::remove(const Made& made) {
    if (!made.body) return;
    World& world = coupling_.world();
    coupling_.unbind(made.kind.object);
    world.remove_body(made.body);
    if (--users_[made.mesh] > 0) return;
    users_.erase(made.mesh);
    std::erase_if(meshes_, [&](const auto& entry) { return entry.second == made.mesh; });
    world.remove_mesh(made.mesh);
}

/// The mesh of a shape; bodies with the same shape share it. A null handle if the shape is no
/// triangle mesh.
MeshId FollowedObjects::mesh_for(const btCollisionShape& shape) {
    if (const auto known = meshes_.find(&shape); known != meshes_.end()) return known->second;
    std::optional<MeshData> data = mesh_of(shape);
    if (!data) return {};
    return meshes_[&shape] = coupling_.world().add_mesh(shape.getName(), *std::move(data));
}

FollowedObjects::Made FollowedObjects::make(btCollisionObject& object) {
    Made made{.kind = kind_of(object), .body = {}, .mesh = {}};
    World& world = coupling_.world();
    btSoftBody* soft = btSoftBody::upcast(&object);
    if (btGhostObject::upcast(&object) != nullptr) return made;
    MeshId mesh;
    try {
        if (soft == nullptr)
            mesh = mesh_for(*object.getCollisionShape());
        else if (soft->m_faces.size() > 0)
            mesh = world.add_mesh("soft body", mesh_of(*soft));
    } catch (const InputError& error) {
        left_.push_back({&object, error.what()});
        return made;
    }
    if (!mesh) return made;
    const MeshInside inside = world.mesh(mesh).inside();
    if (!inside.exists()) {
        left_.push_back({&object, describe(inside)});
        if (!users_.contains(mesh)) {
            std::erase_if(meshes_, [&](const auto& entry) { return entry.second == mesh; });
            world.remove_mesh(mesh);
        }
        return made;
    }
    made.mesh = mesh;
    ++users_[mesh];
    if (soft != nullptr) {
        made.body = world.add_deforming_body(mesh);
        world.set_collision(made.body, {.self = SelfCollision::on});
    } else {
        made.body = made.kind.fixed ? world.add_fixed_body(mesh) : world.add_rigid_body(mesh);
    }
    coupling_.bind(object, soft, made.body);
    return made;
}

}  // namespace pierce::bullet
