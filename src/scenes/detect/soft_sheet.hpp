#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <memory>
#include <span>

#include "scenes/named/scene.hpp"

namespace pierce::scenes {

/// A sheet as Bullet simulates it: a node per vertex, a link per edge and another link across it,
/// and a face per triangle. Bullet's collisions are off.
class SoftSheet {
public:
    SoftSheet(btSoftBodyWorldInfo& info, const SceneBody& body, const MeshData& mesh);

    btSoftBody& soft() const { return *soft_; }
    double mass() const { return mass_; }
    /// Switches on Bullet's contacts of nodes with rigid bodies, and makes clusters for
    /// meet_itself().
    void collide_by_bullet();
    /// Runs Bullet's own self-collision of convex clusters of nodes, which makes contacts for its
    /// next step.
    void meet_itself();
    /// The number of contacts that meet_itself() makes with the nodes at `positions`.
    std::uint32_t meetings_at(std::span<const Vec3f> positions);

private:
    std::unique_ptr<btSoftBody> soft_;
    double mass_ = 0, thickness_ = 0;
};

}  // namespace pierce::scenes
