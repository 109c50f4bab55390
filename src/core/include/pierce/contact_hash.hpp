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
    const auto add_vector = [&](Vec3d v) {
        for (int i = 0; i < 3; ++i) add(std::bit_cast<std::uint64_t>(v[i] + 0.0));
    };
    for (const Contact& c : contacts) {
        add(std::uint64_t{c.a.index} << 32 | c.b.index);
        add(c.feature());
        add(c.grazing);
        add(c.triangle);
        for (double w : c.barycentric) add(std::bit_cast<std::uint64_t>(w + 0.0));
        add_vector(c.point_a);
        add_vector(c.point_b);
        add_vector(c.normal);
        add_vector(c.face_normal);
        add(std::bit_cast<std::uint64_t>(c.distance + 0.0));
    }
    return hash;
}

}  // namespace pierce
