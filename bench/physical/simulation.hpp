#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "physical/scene.hpp"
#include "pierce/bullet/install.hpp"

namespace pierce::physical {

/// The names of all methods: Pierce with its defaults, with complete coverage, and with complete
/// coverage and a margin; Bullet's triangles against triangles (GImpact) with a margin of 0.01 and,
/// "-wide", of 0.04; and Bullet's convex pieces with GJK and EPA, whose margin is 0.04. With
/// "-plane", what is fixed is the half space below its highest point, instead of its mesh.
std::span<const std::string> method_names();

struct MethodSettings {
    std::string method;
    double margin = 0.04;  ///< [length] of pierce-margin; as wide as Bullet's own around hulls
    std::uint32_t most_per_pair = bullet::InstallOptions().most_per_pair;  ///< of Pierce's contacts
};

/// How a body moves.
struct BodyState {
    Pose pose;
    Vec3d velocity;
    Vec3d angular_velocity;
};

/// A scene in a stock Bullet world. The methods differ in the bodies' shapes, and in what is
/// installed. A mesh that no body moves is a btBvhTriangleMeshShape with all methods but those
/// with a plane.
class Simulation {
public:
    /// Throws InputError for an unknown method.
    Simulation(const Scene& scene, const MethodSettings& settings);
    ~Simulation();

    void step(double dt);
    BodyState state_of(std::size_t body) const;
    bool all_sleep() const;
    /// Time that the last step took to find contacts, the broad phase included [ms].
    double detection_milliseconds() const;
    /// The smallest distance of Bullet's contact points, negative where they overlap [length]; 0 if
    /// there are none.
    double deepest_point() const;
    std::uint32_t points() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace pierce::physical
