#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "pierce/backend.hpp"
#include "pierce/constants.hpp"

namespace pierce {

/// When bodies at rest become a part of their own.
struct RestRules {
    std::uint32_t bodies = constants::rest_bodies;  ///< the least number of them all
    std::uint32_t steps = constants::rest_steps;    ///< without a change, of a body at rest
    /// After how many steps' worth of looking at bodies at rest parts are chosen anew; twice as
    /// many each time that this has not paid, up to the most.
    std::uint32_t patience = constants::rest_patience;
    std::uint32_t most_patience = constants::rest_most_patience;
};

/// A backend for which bodies at rest cost nothing: where most bodies are at rest, they become a
/// part of their own (PartitionedBackend), which does not run. Contacts are those of the backend
/// alone. `make`: makes such a backend; it is called again for the other part.
std::unique_ptr<Backend> resting_backend(std::function<std::unique_ptr<Backend>()> make,
                                         const RestRules& rules = {});

}  // namespace pierce
