#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "physical/scene.hpp"
#include "physical/simulation.hpp"
#include "pierce/contact.hpp"
#include "pierce/world.hpp"

namespace pierce::physical {

/// The mechanics of a scene's bodies; those that are fixed count nothing.
class Mechanics {
public:
    explicit Mechanics(const Scene& scene);

    /// Kinetic and potential energy over the mass of all bodies [m^2/s^2].
    double energy_per_mass(std::span<const BodyState> states) const;
    /// Sum of the momenta [m/s times mass].
    Vec3d momentum(std::span<const BodyState> states) const;
    /// Sum of the angular momenta about the origin.
    Vec3d angular_momentum(std::span<const BodyState> states) const;
    /// Sums of the sizes of the bodies' momenta and angular momenta, by which drifts are divided.
    double momentum_size(std::span<const BodyState> states) const;
    double angular_momentum_size(std::span<const BodyState> states) const;

    /// The speed of the fastest vertex of each body that is not fixed.
    std::vector<double> speeds(std::span<const BodyState> states) const;
    /// The farthest that any vertex is from its earlier place.
    double moved(std::span<const BodyState> states, std::span<const BodyState> earlier) const;

private:
    Vec3d spin(std::size_t body, const BodyState& state) const;

    const Scene& scene_;
    std::vector<double> mass_;  ///< by body; 0 if it is fixed
    std::vector<Vec3d> inertia_;
};

/// Measures how deep bodies are in each other, whatever method moves them: by Pierce's complete
/// coverage of the meshes themselves, without any margin.
class DepthGauge {
public:
    explicit DepthGauge(const Scene& scene);
    /// The depth of the deepest contact [length]; 0 if there is none.
    double deepest(std::span<const BodyState> states);

private:
    double depth_of(const Contact& contact, std::span<const BodyState> states) const;

    const Scene& scene_;
    World world_;
    std::map<BodyId, std::size_t> place_;  ///< of a body in the scene
};

}  // namespace pierce::physical
