#pragma once

#include <cstdint>
#include <functional>

#include "pierce/host_device.hpp"
#include "pierce/ids.hpp"

namespace pierce {

/// The world of bodies that are in all worlds.
inline constexpr std::int32_t all_worlds = -1;

/// Which other bodies a body meets. Two bodies are no pair unless each one's groups are among those
/// that the other one meets, their worlds allow it, and they are not of one chain. World::exclude()
/// leaves out single pairs. What a body has with itself is Collision::self, whatever its filter.
struct Filter {
    std::uint32_t groups = 1;           ///< one bit for each group that the body is in
    std::uint32_t meets = 0xffffffffu;  ///< one bit for each group whose bodies it meets
    std::uint32_t chain = 0;            ///< bodies of the same chain, such as the links of a robot,
                                        ///< do not meet; 0: of none
    std::int32_t world = all_worlds;    ///< bodies of different worlds do not meet

    /// True if bodies with these filters may be a pair.
    PIERCE_HD bool allows(const Filter& other) const {
        const bool worlds = world == other.world || world == all_worlds ||
                            other.world == all_worlds;
        const bool chains = chain == 0 || chain != other.chain;
        return worlds && chains && (groups & other.meets) != 0 && (other.groups & meets) != 0;
    }

    friend bool operator==(const Filter&, const Filter&) = default;
};

/// Tells whether two bodies meet, the one in the lower slot first.
using PairFilter = std::function<bool(BodyId a, BodyId b)>;

}  // namespace pierce
