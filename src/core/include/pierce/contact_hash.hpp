#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "pierce/contact.hpp"

namespace pierce {

/// A hash of a contact list (64-bit FNV-1a over the bits of every field but `age` and `found`):
/// equal lists have equal hashes.
inline std::uint64_t contact_hash(std::span<const Contact> contacts) {
    std::uint64_t hash = 0xcbf29ce484222325ull;
    const auto add = [&](std::uint64_t value) {
        for (int i = 0; i < 8; ++i) hash = (hash ^ (value >> (8 * i) & 0xff)) * 0x100000001b3ull;
    };
    // Zero has two signs, which are equal.
    const auto add_number = [&](double x) { add(std::bit_cast<std::uint64_t>(x + 0.0)); };
    const auto add_vector = [&](Vec3d v) {
        for (int i = 0; i < 3; ++i) add_number(v[i]);
    };
    for (const Contact& c : contacts) {
        add(std::uint64_t{c.a.index} << 32 | c.b.index);
        add(std::uint64_t{c.a.generation} << 32 | c.b.generation);
        add(std::uint64_t{c.of_sheet} << 4 | std::uint64_t{c.unknown_side} << 3 |
            std::uint64_t{c.reprojected} << 2 | std::uint64_t{c.grazing} << 1 |
            static_cast<std::uint64_t>(c.source));
        add(std::uint64_t{c.vertex} << 32 | c.edge_end);
        add(std::uint64_t{c.edge} << 32 | c.chord);
        add(std::uint64_t{c.other_edge} << 32 | c.triangle);
        add_number(c.along);
        add_number(c.time);
        for (double w : c.barycentric) add_number(w);
        add_vector(c.point_a);
        add_vector(c.point_b);
        add_vector(c.normal);
        add_vector(c.face_normal);
        add_number(c.distance);
    }
    return hash;
}

}  // namespace pierce
