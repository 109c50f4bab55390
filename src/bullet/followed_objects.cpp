#include "bullet/followed_objects.hpp"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <unordered_set>
#include <utility>

#include "bullet/shape_mesh.hpp"
#include "pierce/error.hpp"

namespace pierce::bullet {
namespace {

/// Stands in objects that are bound, or not followed, where Bullet has room for extensions: an
/// object that comes to the same address has nothing there.
const char mark_of_known = 0;

/// True for the filter that Bullet gives to what is static.
bool meets_no_other_like_it(const btBroadphaseProxy& proxy) {
    return proxy.m_collisionFilterGroup == btBroadphaseProxy::StaticFilter &&
           (proxy.m_collisionFilterMask & btBroadphaseProxy::StaticFilter) == 0;
}

void put_mark(btCollisionObject& object) {
    if (object.internalGetExtensionPointer() == nullptr)
        object.internalSetExtensionPointer(const_cast<char*>(&mark_of_known));
}

std::array<std::uint32_t, 9> size_of(const btCollisionShape& shape) {
    btVector3 lower, upper;
    shape.getAabb(btTransform::getIdentity(), lower, upper);
    std::array<std::uint32_t, 9> size{};
    const btVector3 scaling = shape.getLocalScaling();
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<int>(k);
        size[k] = std::bit_cast<std::uint32_t>(static_cast<float>(scaling[axis]));
        size[3 + k] = std::bit_cast<std::uint32_t>(static_cast<float>(lower[axis]));
        size[6 + k] = std::bit_cast<std::uint32_t>(static_cast<float>(upper[axis]));
    }
    return size;
}

}  // namespace

FollowedObjects::Kind FollowedObjects::kind_of(const btCollisionObject& object) {
    const btSoftBody* soft = btSoftBody::upcast(&object);
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    Kind kind{
        .object = &object,
        .mark = object.internalGetExtensionPointer(),
        .shape = object.getCollisionShape(),
        .proxy = proxy != nullptr ? proxy->getUid() : -1,
        .fixed = object.isStaticObject() && proxy != nullptr && meets_no_other_like_it(*proxy)};
    if (soft == nullptr) {
        if (kind.shape != nullptr && is_triangle_mesh(*kind.shape)) {
            kind.shape_mark = mark_of(*kind.shape);
            kind.size = size_of(*kind.shape);
        }
        return kind;
    }
    kind.nodes = soft->m_nodes.size();
    kind.faces = soft->m_faces.size();
    if (kind.nodes > 0) kind.first_node = &soft->m_nodes[0];
    if (kind.faces > 0) kind.first_face = &soft->m_faces[0];
    return kind;
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
    std::unordered_set<const btCollisionObject*> there;
    for (int i = 0; i < objects.size(); ++i) {
        const Kind kind = kind_of(*objects[i]);
        seen_.push_back(kind);
        there.insert(objects[i]);
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
    std::erase_if(alone_, [&](const auto& entry) { return !there.contains(entry.first); });
    for (btCollisionObject* object : others) {
        if (coupling_.find(object) != nullptr) continue;  // bound by hand
        const auto alone = alone_.find(object);
        if (alone != alone_.end() && alone->second == kind_of(*object)) continue;
        made_.emplace(object, make(*object));
    }
    // What is bound has its mark now.
    for (Kind& kind : seen_) kind = kind_of(*kind.object);
    return true;
}

void FollowedObjects::leave(const btCollisionObject& object) {
    put_mark(const_cast<btCollisionObject&>(object));
    alone_.insert_or_assign(&object, kind_of(object));
    std::erase_if(left_, [&](const LeftToBullet& left) { return left.object == &object; });
    if (const auto last = made_.find(&object); last != made_.end()) {
        remove(last->second);
        made_.erase(last);
    }
}

bool FollowedObjects::has_made(BodyId body) const {
    return std::ranges::any_of(made_, [&](const auto& entry) { return entry.second.body == body; });
}

void FollowedObjects::remove_all() {
    // What is not in the world may be deleted.
    const btCollisionObjectArray& objects = bullet_.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i)
        if (objects[i]->internalGetExtensionPointer() == &mark_of_known)
            objects[i]->internalSetExtensionPointer(nullptr);
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
    remove_unused(made.mesh);
}

void FollowedObjects::remove_unused(MeshId mesh) {
    if (users_.contains(mesh)) return;
    std::erase_if(meshes_, [&](const auto& entry) { return entry.second == mesh; });
    coupling_.world().remove_mesh(mesh);
}

void FollowedObjects::leave_to_bullet(const btCollisionObject& object, std::string why) {
    left_.push_back({&object, std::move(why)});
}

/// The mesh of a shape; bodies with the same shape share it. A null handle if the shape is no
/// triangle mesh.
MeshId FollowedObjects::mesh_for(const btCollisionShape& shape) {
    const std::pair key(&shape, mark_of(shape));
    if (const auto known = meshes_.find(key); known != meshes_.end()) return known->second;
    std::optional<MeshData> data = mesh_of(shape);
    if (!data) return {};
    return meshes_[key] = coupling_.world().add_mesh(shape.getName(), *std::move(data));
}

FollowedObjects::Made FollowedObjects::make(btCollisionObject& object) {
    Made made{.kind = kind_of(object), .body = {}, .mesh = {}};
    World& world = coupling_.world();
    btSoftBody* soft = btSoftBody::upcast(&object);
    if (btGhostObject::upcast(&object) != nullptr) return made;
    const auto* dynamic = dynamic_cast<const btDynamicsWorld*>(&bullet_);
    if (soft != nullptr && dynamic != nullptr &&
        dynamic->getWorldType() == BT_DEFORMABLE_MULTIBODY_DYNAMICS_WORLD) {
        leave_to_bullet(object, "a deformable world's solver does not read contacts of others");
        return made;
    }
    MeshId mesh;
    try {
        if (soft == nullptr)
            mesh = mesh_for(*object.getCollisionShape());
        else if (soft->m_faces.size() > 0)
            mesh = world.add_mesh("soft body", mesh_of(*soft));
    } catch (const InputError& error) {
        leave_to_bullet(object, error.what());
        return made;
    }
    if (!mesh) return made;
    const MeshInside inside = world.mesh(mesh).inside();
    const bool inside_out = soft != nullptr && inside.exists() && volume_of(world.mesh(mesh)) < 0;
    if (!inside.exists() || inside_out) {
        leave_to_bullet(object, inside_out ? "its faces face inward" : describe(inside));
        remove_unused(mesh);
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
    put_mark(object);
    made.kind.mark = object.internalGetExtensionPointer();
    coupling_.bind(object, soft, made.body);
    return made;
}

}  // namespace pierce::bullet
