#pragma once

#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <random>
#include <span>
#include <vector>

namespace pierce::fuzz {

/// Decisions taken from bytes, so that whoever makes the bytes, a seed or libFuzzer, makes the
/// decisions. After the last byte every answer is the first one.
class Choices {
public:
    explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    /// A number from 0 to `count` - 1.
    std::uint32_t below(std::uint32_t count) {
        std::uint32_t value = next();
        if (count > 0x100) value |= next() << 8;
        return value % count;
    }
    bool one_in(std::uint32_t count) { return below(count) == count - 1; }
    /// From `low` to `high`, in 65536 steps.
    double real(double low, double high) {
        const std::uint32_t value = next() | next() << 8;
        return low + (high - low) * value / 65535.0;
    }
    template <class T>
    T pick(std::initializer_list<T> all) {
        return *std::next(all.begin(), below(static_cast<std::uint32_t>(all.size())));
    }

private:
    std::uint32_t next() { return at_ < bytes_.size() ? bytes_[at_++] : 0u; }

    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

/// The bytes of a seed.
inline std::vector<std::uint8_t> bytes_of(std::uint64_t seed) {
    constexpr std::size_t enough = 1 << 13;
    std::mt19937_64 engine(seed);
    std::vector<std::uint8_t> bytes(enough);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(engine() >> 56);
    return bytes;
}

}  // namespace pierce::fuzz
