#pragma once

#include <bit>
#include <cstdint>

#include "core/device/atomics.hpp"
#include "core/device/view.hpp"

namespace pierce::stages {

/// What is known of pairs so far in a step: bits of a word per pair, which stages set and never
/// clear, and counts.
struct PairMarks {
    static constexpr std::uint32_t vertex_inside = 1,  ///< a vertex of one body is inside the other
        in_contact = 2,                                ///< it has a contact
        has_depth = 4,                                 ///< it has a contact with a depth
        edge_touches = 8,                              ///< an edge touches the other surface
        edge_crosses = 16,                             ///< an edge may cross the other surface
        moved_overlaps = 32,                           ///< an edge that was moved shows an overlap
        separates = 64,                                ///< rays along its way apart are wanted
        vertex_touches = 128,                          ///< a vertex has a contact without a depth
        holds_chord = 256,   ///< a part of an edge of one body is inside the other
        contained = 512,     ///< one body is inside the other as a whole
        runs_inside = 1024,  ///< a vertex only touches, but its ray runs inside
        has_way_out = 2048;  ///< a vertex has a contact with a depth whose way out may be that of
                             ///< the pair: its edges need not be looked at

    View<std::uint32_t> words;
    View<std::uint32_t> deep;  ///< two per pair: how many vertices of the body of each side are
                               ///< inside the other one by more than the touch tolerance

    View<std::uint32_t> depth;  ///< per pair, of its deepest contact, as the bits of a float32;
                                ///< empty if there are no margins

    PIERCE_HD void begin(std::uint32_t pair, std::uint32_t bits) const {
        words[pair] = bits;
        deep[2 * pair] = deep[2 * pair + 1] = 0;
        if (depth.size > 0) depth[pair] = 0;
    }
    /// [length] How deep the pair's deepest contact is so far, if that is known.
    PIERCE_HD double depth_of(std::uint32_t pair) const {
        return depth.size > 0 ? static_cast<double>(std::bit_cast<float>(depth[pair])) : 0.0;
    }
    PIERCE_HD void note_depth(std::uint32_t pair, double its) const {
        if (depth.size > 0)
            atomic_max(depth[pair], std::bit_cast<std::uint32_t>(static_cast<float>(its)));
    }
    PIERCE_HD bool any(std::uint32_t pair, std::uint32_t bits) const {
        return (atomic_read(words[pair]) & bits) != 0;
    }
    PIERCE_HD void set(std::uint32_t pair, std::uint32_t bits) const {
        atomic_set(words[pair], bits);
    }
};

}  // namespace pierce::stages
