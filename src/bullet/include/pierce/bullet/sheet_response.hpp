#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include <cstdint>
#include <memory>

#include "pierce/bullet/sheet_projection.hpp"
#include "pierce/world.hpp"

namespace pierce::bullet {

/// How sheets are kept apart.
struct SheetSettings {
    ProjectionSettings projection;
    std::uint32_t rounds = 12;  ///< of detecting and moving, before vertices are pulled back
};

/// What keeping sheets apart took in a step.
struct SheetReport {
    std::vector<StageTime> stages;  ///< of detection, summed over its runs
    double detection_ms = 0, response_ms = 0;
    std::uint32_t detections = 0;    ///< runs of detect()
    std::uint32_t rounds = 0;        ///< runs of the projection
    std::uint32_t contacts = 0;      ///< of sheets, where the solver left them
    std::uint32_t crossings = 0;     ///< of these, met during the step
    std::uint32_t remembered = 0;    ///< of these, on the wrong side since before
    std::uint32_t tangled = 0;       ///< of these, crossing since nobody knows when
    std::uint32_t pulled_back = 0;   ///< vertices that were moved back to where the step began, or
                                     ///< towards it
    std::uint32_t moved_bodies = 0;  ///< rigid bodies that sheets have moved
    std::uint32_t crossings_left = 0;  ///< what moves as told has met vertices that were pulled
                                       ///< back all the way
};

/// Keeps Bullet's soft bodies that are sheets apart: from themselves, from each other, from solids.
/// Bullet moves them as if there were nothing; then their vertices, and rigid bodies in contact
/// with them, are moved, contacts detected, and so on, until from where the step began to where it
/// ends nothing has met. Vertices for which that cannot be had in time are pulled back to where
/// they came from, at worst all: from one step to the next no sheet goes through anything, unless
/// what moves as told runs into it.
class SheetResponse {
public:
    /// `world` must outlive it; all soft and rigid bodies that sheets are to meet are bound before
    /// the first step.
    explicit SheetResponse(World& world, SheetSettings settings = {});
    ~SheetResponse();

    /// A soft body with one node per vertex of the mesh, in their order. Throws InputError if the
    /// counts differ.
    void bind(btSoftBody& soft, BodyId body);
    /// An obstacle. If it is dynamic and awake, sheets move it as it moves them; one that is led or
    /// sleeps they do not, but a push that would set it going faster than its sleeping threshold
    /// wakes it for the next step.
    void bind(btRigidBody& rigid, BodyId body);

    /// To be called after Bullet's step of `dt` seconds: moves nodes and rigid bodies and sets
    /// their velocities.
    const SheetReport& finish_step(double dt);
    /// Of the last step.
    const SheetReport& report() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
