#pragma once

#include <concepts>
#include <cstdint>
#include <stdexcept>

namespace pierce::cuda {

/// How many items there are: a number that the host knows, or a number that only the device knows,
/// with a bound.
struct DeviceCount {
    std::uint32_t bound = 0;
    const std::uint32_t* exact = nullptr;  ///< device memory; null: `bound` is the number
    std::uint32_t factor = 1;              ///< of `*exact`

    DeviceCount() = default;
    DeviceCount(std::uint32_t n) : bound(n) {}
    DeviceCount(std::uint32_t most, const std::uint32_t* number, std::uint32_t times)
        : bound(most), exact(number), factor(times) {}

    /// The number, for parts of a step that cannot do without it. Throws std::logic_error where the
    /// host does not know it.
    operator std::uint32_t() const {
        if (exact != nullptr)
            throw std::logic_error("a count that only the device knows was used on the host");
        return bound;
    }

    template <std::integral N>
    friend DeviceCount operator*(N times, DeviceCount c) {
        const auto by = static_cast<std::uint32_t>(times);
        return {by * c.bound, c.exact, by * c.factor};
    }
};

}  // namespace pierce::cuda
