#pragma once

#include <cstdint>

#include "core/device/view.hpp"
#include "core/mesh/mesh_view.hpp"
#include "core/mesh/surface.hpp"
#include "pierce/body.hpp"
#include "pierce/filter.hpp"
#include "pierce/min_max.hpp"
#include "pierce/pose.hpp"

namespace pierce {

/// What a body is; the plan sets it, and it stays until the next plan.
struct BodyShape {
    MeshView mesh;
    std::uint64_t mesh_key = 0;     ///< the mesh's identity, never used twice
    View<const PatchBlock> blocks;  ///< in the body's space
    View<const Offsets> patches;    ///< in the body's space
    View<const BoxNode> box_nodes;  ///< boxes around the triangles, in the body's space; of a
                                    ///< deforming body only where the plan needs boxes
    double range = 0;               ///< [length] longest ray of an open body
    double memory = 0;  ///< [length] if there is a sheet: vertices that have been through
                        ///< this surface are remembered up to this depth
    double margin = 0;  ///< [length] how near other solids are in contact
    Collision collision;
    Filter filter;
    std::uint32_t world_place = 0;  ///< of the body's world among all worlds; bodies that are in
                                    ///< all of them have the last place
    Motion motion = Motion::fixed;
    std::uint32_t part = 0;  ///< which of the backends that share a scene owns the body
};

/// Seven numbers in device memory in which the caller keeps a pose: the position and the quaternion
/// x, y, z, w.
struct DevicePose {
    const float* floats = nullptr;
    const double* doubles = nullptr;

    PIERCE_HD bool exists() const { return floats != nullptr || doubles != nullptr; }
    PIERCE_HD Pose read() const {
        double n[7];
        for (int k = 0; k < 7; ++k)
            n[k] = floats != nullptr ? static_cast<double>(floats[k]) : doubles[k];
        return {{n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}};
    }
};

/// Where a body is; the caller sets it before a step.
struct BodyInput {
    View<const Vec3f> positions;  ///< in the body's space
    View<const Vec3f> start;  ///< positions when the step began; empty for rigid bodies and where
                              ///< they are not needed
    const Vec3f* device_positions = nullptr;  ///< where the caller keeps a deforming body's
                                              ///< positions, if on the device
    const Vec3f* device_start = nullptr;  ///< where the caller keeps the positions when the step
                                          ///< began, if on the device
    DevicePose device_pose;               ///< of a fixed or rigid body: where the caller keeps its
                                          ///< pose, if on the device
    Frame space;                          ///< body's space to world
    Frame start_space;  ///< of a fixed or rigid body: where its space was when the step began
    std::uint64_t positions_version = 0;  ///< changes whenever a deforming body's positions do
    bool active = true;  ///< false: left out of this step: not finite, too far away, in a world
                         ///< that is not active, or not near this part
};

/// What a step finds out about where a body is; the stage bounds writes it.
struct BodyBounds {
    Frame fit;       ///< rest shape to world
    Frame last_fit;  ///< the fit of the last step, if `seen`
    Box fit_box;     ///< around the vertices, in `fit`
    Box world_box;
    double deviation = 0;  ///< [length] no vertex is further than this from its place in the rest
                           ///< shape under `fit`
    double shape_motion = 0;  ///< [length] no vertex has moved further than this in `fit` since the
                              ///< last step
    double prediction_range = 0;  ///< [length] how far predictions look
    double touch = 0;             ///< [length] touch tolerance of this body as a target
    double travel = 0;   ///< [length] no point has moved further than this since the step began, if
                         ///< there is a sheet
    bool seen = false;   ///< the body took part in the last step, too; set where steps remember
    bool still = false;  ///< the body is rigid or fixed and stands where it did in the last step,
                         ///< bit for bit; set where steps remember
};

/// A body as stages see it. The *space* of a body is where its positions live: its own for a fixed
/// or rigid body, the world for a deforming one. Its *fit* is the frame in which it looks most like
/// the mesh's rest shape.
struct BodyView : BodyShape, BodyInput, BodyBounds {
    /// True if the body has an inside that counts.
    PIERCE_HD bool is_solid() const { return mesh.closed && !collision.sheet; }

    /// True if the body's vertices send rays along their velocities to find contacts with the body
    /// itself.
    PIERCE_HD bool sends_velocity_rays() const {
        return collision.sheet && (collision.self == SelfCollision::rays ||
                                   collision.self == SelfCollision::published);
    }

    PIERCE_HD Surface surface() const {
        return {.positions = positions,
                .triangles = mesh.triangles,
                .touch = touch,
                .covered = collision.sheet ? View<const Cover>{} : mesh.covered};
    }

    /// How far beyond its box and its touch tolerance another body may matter to this one.
    PIERCE_HD double outreach() const {
        return prediction_range + travel + collision.thickness + margin;
    }
    /// The same if the other one, or this one, is a sheet.
    PIERCE_HD double outreach_of_sheets() const { return outreach() + memory; }

    /// True if it is certain that the surface goes around every point once or not at all. Then no
    /// ray from an outside point can leave the body before it enters. A deforming body may cross
    /// itself.
    PIERCE_HD bool is_simple() const { return mesh.simple && motion != Motion::deforming; }
};

/// The box around a body's positions, in the space of the positions.
PIERCE_HD inline const Box& positions_box(const BodyView& body) {
    return body.motion == Motion::deforming ? body.world_box : body.mesh.box;
}

/// Two bodies whose boxes overlap, a < b; or a body that is looked for in itself, a = b.
struct Pair {
    std::uint32_t a = 0;
    std::uint32_t b = 0;

    PIERCE_HD bool is_self() const { return a == b; }
    PIERCE_HD std::uint32_t source(std::uint32_t side) const { return side == 0 ? a : b; }
    PIERCE_HD std::uint32_t target(std::uint32_t side) const { return side == 0 ? b : a; }
    friend bool operator==(const Pair&, const Pair&) = default;
    PIERCE_HD friend bool operator<(const Pair& p, const Pair& q) {
        return p.a < q.a || (p.a == q.a && p.b < q.b);
    }
};

/// Which of the backends that share a scene looks at a pair of bodies that two of them own: that of
/// the body that moves, and the lower one if both do.
PIERCE_HD inline std::uint32_t part_of_pair(Motion a, std::uint32_t part_of_a, Motion b,
                                            std::uint32_t part_of_b) {
    if (a == Motion::fixed) return part_of_b;
    return b == Motion::fixed ? part_of_a : min_of(part_of_a, part_of_b);
}

}  // namespace pierce
