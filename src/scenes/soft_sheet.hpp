#pragma once

#include <BulletSoftBody/btSoftBody.h>

#include <memory>
#include <span>
#include <vector>

#include "scenes/scene.hpp"

namespace pierce::scenes {

/// A sheet as Bullet simulates it: a node per vertex, a link per edge and one across it, a face per
/// triangle. Bullet's collisions are off.
class SoftSheet {
public:
    SoftSheet(btSoftBodyWorldInfo& info, const SceneBody& body, const MeshData& mesh);

    btSoftBody& soft() const { return *soft_; }
    double mass() const { return mass_; }
    /// Switches Bullet's nodes against rigid bodies on, and makes clusters for meet_itself().
    void collide_by_bullet();
    /// Bullet's own self-collision, convex clusters of nodes against each other: contacts for its
    /// next step.
    void meet_itself();
    /// How many contacts that makes with the nodes standing at `positions`.
    std::uint32_t meetings_at(std::span<const Vec3f> positions);
    /// Sends the nodes that are led to where they are to be at `time`, the end of the next step of
    /// `dt` [s].
    void lead(double time, double dt);

private:
    std::unique_ptr<btSoftBody> soft_;
    std::vector<Guide> guides_;
    std::vector<Vec3d> start_;
    std::vector<double> node_mass_;
    double mass_ = 0, thickness_ = 0;
};

}  // namespace pierce::scenes
