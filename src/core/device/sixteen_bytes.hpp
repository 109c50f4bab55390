#pragma once

#include <cstdint>
#include <cstring>

#include "core/device/four.hpp"

#if defined(PIERCE_FOUR_LANES)

namespace pierce {

/// Sixteen bytes in one vector register, with arithmetic on all of them at once.
struct SixteenBytes {
    using Bytes = unsigned char __attribute__((vector_size(16)));

    Bytes byte;

    /// The bytes of four words.
    static SixteenBytes of(Four::Bits words) { return {reinterpret_cast<Bytes>(words)}; }
    /// The sixteen that lie at an address.
    static SixteenBytes at(const void* address) {
        SixteenBytes bytes{};
        std::memcpy(&bytes.byte, address, sizeof bytes.byte);
        return bytes;
    }

    friend SixteenBytes operator-(SixteenBytes a, SixteenBytes b) { return {a.byte - b.byte}; }
    friend SixteenBytes operator&(SixteenBytes a, SixteenBytes b) { return {a.byte & b.byte}; }

    /// The top bit of each, side by side.
    std::uint32_t top_bits() const {
#if defined(__SSE2__)
        using Chars = char __attribute__((vector_size(16)));
        return static_cast<std::uint32_t>(
            __builtin_ia32_pmovmskb128(reinterpret_cast<Chars>(byte)));
#else
        std::uint64_t half[2];
        std::memcpy(half, &byte, sizeof half);
        // The product adds up shifted copies, whose bits do not overlap.
        const auto together = [](std::uint64_t bits) {
            return static_cast<std::uint32_t>(
                (bits >> 7 & 0x0101010101010101u) * 0x0102040810204080u >> 56);
        };
        return together(half[0]) | together(half[1]) << 8;
#endif
    }
};

}  // namespace pierce

#endif
