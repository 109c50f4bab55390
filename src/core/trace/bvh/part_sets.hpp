#pragma once

#include <cstdint>

#include "core/device/loops.hpp"
#include "pierce/constants.hpp"
#include "pierce/host_device.hpp"

/// Sets of the parts of a treelet.
namespace pierce::bvh {

using PartSet = std::uint32_t;  ///< one bit for each part

inline constexpr std::uint32_t treelet_parts = constants::treelet_parts;
inline constexpr PartSet all_parts = (PartSet{1} << treelet_parts) - 1;

PIERCE_HD constexpr bool has_one_part(PartSet set) { return (set & (set - 1)) == 0; }

PIERCE_HD constexpr std::uint32_t size_of(PartSet set) {
    std::uint32_t size = 0;
    for (; set != 0; set &= set - 1) ++size;
    return size;
}

/// The subsets of a set by number: the parts whose places among those of `set` are the bits of n.
PIERCE_HD constexpr PartSet subset(PartSet set, std::uint32_t n) {
    PartSet result = 0;
    for (; n != 0; set &= set - 1, n >>= 1)
        if (n & 1) result |= set & ~(set - 1);
    return result;
}

/// How many sets of `size` parts there are among the first n parts. A row of Pascal's triangle is a
/// number with six bits for each entry.
PIERCE_HD constexpr std::uint32_t ways(std::uint32_t n, std::uint32_t size) {
    std::uint64_t row = 1;
    for (std::uint32_t k = 0; k < n; ++k) row += row << 6;
    return static_cast<std::uint32_t>(row >> (6 * size)) & 63;
}
static_assert(treelet_parts <= 7, "six bits are enough for the entries");

/// The sets of `size` parts by number, from 0 to ways(treelet_parts, size) - 1.
PIERCE_HD constexpr PartSet nth_set(std::uint32_t size, std::uint32_t n) {
    PartSet set = 0;
    for (std::uint32_t k = treelet_parts; k-- > 0;) {
        if (size == 0 || n < ways(k, size)) continue;
        n -= ways(k, size--);
        set |= PartSet{1} << k;
    }
    return set;
}

/// The sets that one of those who work on a treelet works on (`Who`: Lanes or Alone).
template <class Who>
class ShareOfSets {
    static constexpr std::uint32_t half = treelet_parts / 2;

    /// How many sets of a size one gets.
    PIERCE_HD static constexpr std::uint32_t share(std::uint32_t size) {
        return (ways(treelet_parts, size) + Who::count - 1) / Who::count;
    }

public:
    PIERCE_HD ShareOfSets() {
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t size = 1; size <= half; ++size) PIERCE_UNROLLED_LOOP
        for (std::uint32_t k = 0; k < share(size); ++k)
            sets_[size][k] = nth_set(size, k * Who::count + Who::lane());
    }

    /// Calls work(set) for those of some size. The larger sets are what the smaller ones leave.
    template <class Work>
    PIERCE_HD void each_of(std::uint32_t size, const Work& work) const {
        const std::uint32_t few = size <= half ? size : treelet_parts - size;
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t k = 0; k < share(few); ++k)
            if (k * Who::count + Who::lane() < ways(treelet_parts, few))
                work(size == few ? sets_[few][k] : all_parts ^ sets_[few][k]);
    }

private:
    PartSet sets_[half + 1][share(half)];
};

/// A list of sets, short enough for two registers.
class SetList {
public:
    /// Notes set number k; none may have been noted as that.
    PIERCE_HD void put(std::uint32_t k, PartSet set) {
        bits_ |= static_cast<std::uint64_t>(set) << (treelet_parts * k);
    }
    PIERCE_HD PartSet operator[](std::uint32_t k) const {
        return static_cast<PartSet>(bits_ >> (treelet_parts * k)) & all_parts;
    }

private:
    static_assert(treelet_parts * treelet_parts <= 64);
    std::uint64_t bits_ = 0;
};

}  // namespace pierce::bvh
