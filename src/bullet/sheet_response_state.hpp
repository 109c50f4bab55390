#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "core/geometry/moving_point.hpp"
#include "pierce/bullet/sheet_response.hpp"

namespace pierce::bullet {

/// True if the features have met during the step.
inline bool is_met(const Contact& c) { return c.of_sheet && c.found == Found::crossing; }

/// A sheet that Bullet simulates.
struct Sheet {
    btSoftBody* soft = nullptr;
    BodyId body;
    MovingNodes nodes;
    std::vector<Vec3f> end;  ///< the positions given to detection; the next step starts from them
    std::vector<bool> pulled_back;
};

/// A rigid body beside the sheets.
struct Obstacle {
    btRigidBody* rigid = nullptr;
    BodyId body;
    Pose start, end;
    MovingBody moving;
    Vec3d shift, turn, impulse;  ///< summed over all rounds
    bool is_held = false;        ///< put back to where the step began
};

struct SheetResponse::State {
    World& world;
    SheetSettings settings;
    SheetProjection projection;
    std::vector<std::unique_ptr<Sheet>> sheets;
    std::vector<Obstacle> obstacles;
    std::unordered_map<BodyId, Sheet*> sheet_of;
    std::unordered_map<BodyId, std::size_t> obstacle_of;
    SheetReport report;
    /// False while no sheet is through anything when a step begins. Then only what meets during the
    /// step has to be repaired.
    bool is_crossed = true;

    void unbind(const btCollisionObject& object, BodyId body);
    void read_step();
    void detect();
    void count_contacts();
    bool has_violation() const;
    bool counts(const Contact& c) const;
    bool project();
    void move_bodies();
    void keep_apart();
    bool pull_back(std::uint32_t attempt);
    void pull_back(Sheet& sheet, std::uint32_t vertex, double share);
    void pull_back_around(Sheet& sheet);
    enum class Hold { needless, impossible, held };
    Hold hold(BodyId body);
    void write_step(double dt);

    bool concerns_sheet(const Contact& c) const {
        return sheet_of.contains(c.a) || sheet_of.contains(c.b);
    }
    SheetProjection::Point source_point(const Contact& c);
    SheetProjection::Point target_point(const Contact& c);
    SheetProjection::Point solid_point(BodyId body, Vec3d point);
    Vec3d start_of(BodyId body, Vec3d end) const;
    MovingPoint vertex_motion(BodyId body, std::uint32_t vertex) const;
    Vec3d out_of(const Contact& c) const;
};

}  // namespace pierce::bullet
