#pragma once

#include <cstdint>

#include "core/device/partition_point.hpp"
#include "core/device/view.hpp"
#include "pierce/constants.hpp"

/// The keys that order a step's contacts. All begin with the pair.
namespace pierce {

/// Of a contact that a ray has found, or that is near: the pair, the side of its source, and a
/// vertex or an edge. Chords of one edge share it.
struct ContactKey {
    static constexpr int pair_shift = 32;

    PIERCE_HD static std::uint64_t of_vertex(std::uint32_t pair, std::uint32_t side,
                                             std::uint32_t vertex) {
        return first_of(pair) | std::uint64_t{side} << 31 | vertex;
    }
    PIERCE_HD static std::uint64_t of_edge(std::uint32_t pair, std::uint32_t side,
                                           std::uint32_t edge) {
        return of_vertex(pair, side, edge) | std::uint64_t{1} << 30;
    }
    /// No key of the pair is less.
    PIERCE_HD static std::uint64_t first_of(std::uint32_t pair) {
        return std::uint64_t{pair} << pair_shift;
    }
    PIERCE_HD static std::uint32_t pair_of(std::uint64_t key) {
        return static_cast<std::uint32_t>(key >> pair_shift);
    }
    /// The key of the same feature in another pair.
    PIERCE_HD static std::uint64_t in_pair(std::uint32_t pair, std::uint64_t key) {
        return first_of(pair) | static_cast<std::uint32_t>(key);
    }
};
static_assert(constants::max_elements <= std::uint32_t{1} << 30);

/// What two features of a sheet and another surface are.
enum class FeatureKind : std::uint8_t {
    vertex_of_a,         ///< a vertex of the pair's a, and a triangle of its b
    vertex_of_b,         ///< the other way round
    edges,               ///< an edge of a and an edge of b
    piercing_edge_of_a,  ///< an edge of a through a triangle of b, at the start of the step and at
                         ///< its end
    piercing_edge_of_b,
};

/// Of a sheet's contact: the pair, the kind of its features, and the number of one of them. Those
/// of one feature are then in any order (OrderTies).
struct SheetKey {
    std::uint32_t bits = 0;  ///< as many as a feature's number has at most

    static constexpr std::uint32_t kind_bits = 3;

    PIERCE_HD std::uint64_t of(std::uint32_t pair, FeatureKind kind, std::uint32_t item) const {
        return std::uint64_t{pair} << (bits + kind_bits) |
               static_cast<std::uint64_t>(kind) << bits | item;
    }
    PIERCE_HD std::uint32_t pair_of(std::uint64_t key) const {
        return static_cast<std::uint32_t>(key >> (bits + kind_bits));
    }
    PIERCE_HD FeatureKind kind_of(std::uint64_t key) const {
        return static_cast<FeatureKind>(key >> bits & ((1u << kind_bits) - 1));
    }
    PIERCE_HD std::uint32_t item_of(std::uint64_t key) const {
        return static_cast<std::uint32_t>(key & ((std::uint64_t{1} << bits) - 1));
    }
};

/// The place of the first key that is not less.
PIERCE_HD inline std::uint32_t first_not_less(View<const std::uint64_t> keys, std::uint64_t key) {
    return partition_point(keys.size, [&](std::uint32_t i) { return keys[i] < key; });
}

}  // namespace pierce
