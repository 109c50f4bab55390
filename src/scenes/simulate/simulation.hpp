#pragma once

#include <functional>
#include <memory>

#include "pierce/world.hpp"
#include "scenes/detect/method.hpp"
#include "scenes/named/scene.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// A scene that Bullet simulates with contacts that a method finds: the closed loop.
class Simulation {
public:
    /// Throws InputError if the method cannot handle the scene: Bullet's own methods take rigid
    /// bodies only.
    Simulation(const SceneSetup& scene, Method method, const RaySettings& rays = {});
    ~Simulation();

    /// Runs one time step of `dt` seconds; throws InputError unless `dt` is positive.
    const FrameResult& step(double dt);
    /// The same, and adds the bodies to a recording of the same scene where the step has looked for
    /// contacts: for sheets that is where it ends, else where it begins, with nodes of solids that
    /// deform moved ahead.
    const FrameResult& step(double dt, Recording& recording);

    /// Adds the bodies at their present places to a recording of the same scene.
    void record(Recording& recording) const;
    /// The same with sheets where Bullet had put them in the last step, before contacts moved them;
    /// with rays only.
    void record_tried(Recording& recording) const;

    /// Kinetic energy of the centres and nodes over the mass of all moving bodies [m^2/s^2].
    double kinetic_energy_per_mass() const;
    /// The world position of a vertex.
    Vec3d vertex_position(std::uint32_t body, std::uint32_t vertex) const;
    /// Present volume of a body over the volume of its rest shape; 1 for rigid bodies.
    double volume_ratio(std::uint32_t body) const;
    /// The simulation's world, if the method is rays; else null.
    World* world();

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::scenes
