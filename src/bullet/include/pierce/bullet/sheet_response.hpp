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
    std::uint32_t rounds = 12;  ///< rounds of detecting and moving before vertices are pulled back
};

/// The work of a step to keep sheets apart, and its result.
struct SheetReport {
    std::vector<StageTime> stages;  ///< of detection, summed over its runs
    double detection_ms = 0, response_ms = 0;
    std::uint32_t detections = 0;    ///< runs of detect()
    std::uint32_t rounds = 0;        ///< runs of the projection
    std::uint32_t contacts = 0;      ///< contacts of sheets as the solver left them
    std::uint32_t crossings = 0;     ///< of these, met during the step
    std::uint32_t remembered = 0;    ///< of these, on the wrong side since before
    std::uint32_t tangled = 0;       ///< of these, edges through triangles since an unknown step
    std::uint32_t pulled_back = 0;   ///< vertices that were moved back to where the step began, or
                                     ///< towards it
    std::uint32_t moved_bodies = 0;  ///< rigid bodies that sheets have moved
    std::uint32_t held_bodies = 0;   ///< free rigid bodies that were put back to where the step
                                     ///< began, where vertices could go back no further
    std::uint32_t crossings_left = 0;  ///< meetings of bodies that sheets cannot move, and that
                                       ///< have moved, with vertices that were pulled back all the
                                       ///< way
};

/// Keeps Bullet's soft bodies that are sheets apart: from themselves, from each other, from solids.
/// Bullet moves the sheets as if they had no contacts. Then rounds follow: contacts are detected,
/// and the sheets' vertices, and rigid bodies in contact with them, are moved. The rounds end when
/// nothing meets between the step's begin and its end. Vertices for which that takes too many
/// rounds are pulled back to where they came from, at worst all of them; a free body that still
/// meets such vertices is held where the step began. So no sheet goes through anything from one
/// step to the next, unless a body whose motion is given runs into it.
class SheetResponse {
public:
    /// `world` must outlive this object. All soft and rigid bodies that sheets are to meet must be
    /// bound, at any time between steps.
    explicit SheetResponse(World& world, SheetSettings settings = {});
    ~SheetResponse();

    /// Binds a sheet: a soft body with one node per vertex of the mesh, in their order. Throws
    /// InputError if the counts differ. To be called again when the sheet has got another mesh or
    /// other nodes.
    void bind(btSoftBody& soft, BodyId body);
    /// Binds an obstacle. If it is dynamic and awake, it and the sheets move each other. Sheets do
    /// not move an obstacle that is led or sleeps. But a push that would make it faster than its
    /// sleeping threshold wakes it for the next step.
    void bind(btRigidBody& rigid, BodyId body);
    /// Forgets a sheet or an obstacle, so that it can be deleted; nothing happens if it is not
    /// bound. Sheets still meet its body in the world where that is, until it is removed there.
    void unbind(const btCollisionObject& object);

    /// To be called after Bullet's step of `dt` seconds: moves nodes and rigid bodies and sets
    /// their velocities.
    const SheetReport& finish_step(double dt);
    /// The report of the last step.
    const SheetReport& report() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::bullet
