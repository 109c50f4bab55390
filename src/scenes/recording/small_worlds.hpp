#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "pierce/filter.hpp"
#include "scenes/recording/recording.hpp"

namespace pierce::scenes {

/// What is in each of many small worlds.
enum class SmallWorld : std::uint8_t {
    tori,  ///< two deforming tori of 600 triangles that overlap
    hand,  ///< a hand of 20 rigid bodies, convex and concave, around a ring
    nut,   ///< a nut on a bolt, thread in thread, each a rigid mesh of more than 5,000 triangles
};

/// The kind of that name.
std::optional<SmallWorld> small_world_named(std::string_view name);

/// Bodies of many worlds, one world after the other, and their filters.
struct SmallWorlds {
    Recording recording;
    std::vector<Filter> filters;
};

/// `count` worlds of a kind, each a little ahead of the one before in the same motion.
SmallWorlds small_worlds(SmallWorld kind, std::uint32_t count, std::uint32_t frames);

}  // namespace pierce::scenes
