#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "core/device/four.hpp"
#include "core/device/quick_math.hpp"
#include "core/device/sixteen_bytes.hpp"
#include "core/device/whole.hpp"
#include "core/geometry/float_rules.hpp"
#include "core/geometry/quick_vec3.hpp"
#include "pierce/constants.hpp"

/// Compares many boxes with many: sixteen boxes take as little memory as five of float32, and are
/// compared side by side.
namespace pierce {

/// A box in float32, not smaller than what it holds; empty by default.
struct alignas(16) QuickBox {
    static constexpr float nowhere = std::numeric_limits<float>::infinity();

    Vec3f lower{nowhere, nowhere, nowhere};
    float lower_padding = 0;
    Vec3f upper{-nowhere, -nowhere, -nowhere};
    float upper_padding = 0;

    PIERCE_HD bool empty() const { return !(lower.x <= upper.x); }
    PIERCE_HD void extend(Vec3f p) {
#if defined(PIERCE_FOUR_LANES)
        const Four at = Four::FourLanes{p.x, p.y, p.z, 0};
        min_of(at, Four::at(&lower)).put(&lower);
        max_of(at, Four::at(&upper)).put(&upper);
#else
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = quick_min(p[axis], lower[axis]);
            upper[axis] = quick_max(p[axis], upper[axis]);
        }
#endif
    }
    PIERCE_HD void extend(const QuickBox& box) {
#if defined(PIERCE_FOUR_LANES)
        min_of(Four::at(&box.lower), Four::at(&lower)).put(&lower);
        max_of(Four::at(&box.upper), Four::at(&upper)).put(&upper);
#else
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = quick_min(box.lower[axis], lower[axis]);
            upper[axis] = quick_max(box.upper[axis], upper[axis]);
        }
#endif
    }
    /// Grown by `margin` on every side, and a little more.
    PIERCE_HD QuickBox inflated(float margin) const {
        QuickBox box;
#if defined(PIERCE_FOUR_LANES)
        const Four low = Four::at(&lower) - margin, high = Four::at(&upper) + margin,
                   ulp = std::numeric_limits<float>::epsilon();
        (low - abs_of(low) * ulp).put(&box.lower);
        (high + abs_of(high) * ulp).put(&box.upper);
#else
        for (int axis = 0; axis < 3; ++axis) {
            box.lower[axis] = not_above(lower[axis] - margin);
            box.upper[axis] = not_below(upper[axis] + margin);
        }
#endif
        return box;
    }
};

/// A few boxes that are asked about together; an even number of them.
struct FewBoxes {
    static constexpr std::uint32_t most = 8;

    QuickBox box[most];
    std::uint32_t count = 0;
};

/// A step is 1/124 of a side of a box. Coordinates inside the box lie on steps 1 to 125,
/// coordinates below or above it on 0 and 126. If a coordinate is not above another one, its step
/// is not above the other's step, however values are rounded: a difference, a product and a sum in
/// float32 each keep that order. So boxes that overlap also overlap in steps.
struct alignas(16) BoxSteps {
    Vec3f origin;
    float padding = 0;
    Vec3f per_length;  ///< share of the way to the last step, per length
    float padding_2 = 0;

    static constexpr std::uint32_t last = 126;  ///< this plus one takes seven bits; the eighth bit
                                                ///< is for borrowing from

    BoxSteps() = default;
    PIERCE_HD explicit BoxSteps(const QuickBox& whole) {
        constexpr float step = 1 / static_cast<float>(last - 2),
                        share = 1 - 2 / static_cast<float>(last);
        for (int axis = 0; axis < 3; ++axis) {
            // Even in a flat box, a step is a difference that coordinates can have.
            const float lower = whole.lower[axis], upper = whole.upper[axis];
            const float least = quick_max(
                constants::grid_thinness * quick_max(std::fabs(lower), std::fabs(upper)),
                std::numeric_limits<float>::min());
            const float side = quick_max(upper - lower, least);
            per_length[axis] = share / side;
            origin[axis] = lower - step * side;
        }
    }

    /// The step of a coordinate, plus `more`.
    PIERCE_HD std::uint32_t at(float coordinate, int axis, std::uint32_t more) const {
        const float share = (coordinate - origin[axis]) * per_length[axis];
        // The lowest bits of the sum hold a whole number.
        const float sum = quick_fma(static_cast<float>(last), quick_clamp(share),
                                    whole_numbers + static_cast<float>(more));
        return std::bit_cast<std::uint32_t>(sum) - std::bit_cast<std::uint32_t>(whole_numbers);
    }

#if defined(PIERCE_FOUR_LANES)
    /// The steps of an end of a box along all axes, plus `more`.
    Four::Bits at_end(const Vec3f& end, std::uint32_t more) const {
        return at_shares((Four::at(&end) - Four::at(&origin)) * Four::at(&per_length), more);
    }
    /// The steps at four shares of the way to the last step, plus `more`.
    static Four::Bits at_shares(Four shares, std::uint32_t more) {
        const Four sum = Four(static_cast<float>(last)) * min_of(max_of(shares, 0), 1) +
                         Four(whole_numbers + static_cast<float>(more));
        return reinterpret_cast<Four::Bits>(sum.lane) - std::bit_cast<std::int32_t>(whole_numbers);
    }
#endif

private:
    static constexpr float whole_numbers = 0x1p23f;
};

/// Sixteen boxes, in steps of the box around them, a byte a coordinate.
struct alignas(16) GridBoxes {
    /// One coordinate of all sixteen boxes, a byte each: for lower ends the step, for upper ends
    /// one step more and the top bit. The bytes are kept in words, because a GPU would take single
    /// bytes apart and put them together again.
    struct alignas(16) Row {
        std::uint32_t word[constants::group_size / 4];

        PIERCE_HD void set(std::uint32_t k, std::uint32_t byte) {
            reinterpret_cast<unsigned char*>(word)[k] = static_cast<unsigned char>(byte);
        }
        PIERCE_HD std::uint32_t get(std::uint32_t k) const {
            return reinterpret_cast<const unsigned char*>(word)[k];
        }
    };

    static constexpr std::uint32_t top_bit = 0x80;

#if defined(PIERCE_FOUR_LANES)
    /// Ranges of steps: one along each axis, or four along one.
    class StepRanges {
    public:
        /// `begins`: one more than the first steps; `ends`: the last steps.
        StepRanges(Four::Bits begins, Four::Bits ends)
            : begins_(in_every_byte(begins)), ends_(in_every_byte(ends | int{top_bit})) {}

        /// In the top bits, which of sixteen ranges overlap the range `k`.
        template <int k>
        SixteenBytes overlap(const Row& lower, const Row& upper) const {
            return (SixteenBytes::of(__builtin_shufflevector(ends_, ends_, k, k, k, k)) -
                    SixteenBytes::at(&lower)) &
                   (SixteenBytes::at(&upper) -
                    SixteenBytes::of(__builtin_shufflevector(begins_, begins_, k, k, k, k)));
        }

    private:
        static Four::Bits in_every_byte(Four::Bits steps) {
            steps |= steps << 8;
            return steps | steps << 16;
        }
        Four::Bits begins_, ends_;
    };
#endif

    Row lower[3], upper[3];
    BoxSteps steps;

    /// Sets box k. An empty box ends before the first step, where no box begins.
    PIERCE_HD void set(std::uint32_t k, const BoxSteps& grid, const QuickBox& box) {
#if defined(PIERCE_FOUR_LANES)
        const Four::Bits begins = grid.at_end(box.lower, 0),
                         ends = box.empty() ? Four::Bits{} : grid.at_end(box.upper, 1);
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis].set(k, static_cast<std::uint32_t>(begins[axis]));
            upper[axis].set(k, static_cast<std::uint32_t>(ends[axis]) | top_bit);
        }
#else
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis].set(k, grid.at(box.lower[axis], axis, 0));
            upper[axis].set(k, (box.empty() ? 0 : grid.at(box.upper[axis], axis, 1)) | top_bit);
        }
#endif
    }

    /// A bit for each of the sixteen that may overlap `box`; an empty one gets none.
    PIERCE_HD std::uint32_t near(const QuickBox& box) const { return near<1>({box}); }

    /// The same for two boxes, sixteen bits each; a GPU reads the sixteen once for both.
    PIERCE_HD std::uint32_t near(const QuickBox& box, const QuickBox& other) const {
        return near<2>({box, other});
    }

    /// A bit for each of the sixteen that may overlap one of a few boxes.
    PIERCE_HD std::uint32_t near(const FewBoxes& boxes) const {
        std::uint32_t mask = 0;
        for (std::uint32_t b = 0; b < boxes.count; b += 2)
            mask |= near(boxes.box[b], boxes.box[b + 1]);
        return (mask | mask >> constants::group_size) & ((1u << constants::group_size) - 1);
    }

private:
    static constexpr std::uint32_t every_byte = 0x01010101, top_bits = top_bit * every_byte;

    template <std::uint32_t count>
    PIERCE_HD std::uint32_t near(const QuickBox (&box)[count]) const {
        const BoxSteps grid = read_whole(steps);
        std::uint32_t mask = 0;
#if defined(__CUDA_ARCH__)
        Row hits[count];
        for (Row& row : hits) row = {top_bits, top_bits, top_bits, top_bits};
        for (int axis = 0; axis < 3; ++axis) {
            const Row begin = read_whole(lower[axis]), end = read_whole(upper[axis]);
            for (std::uint32_t b = 0; b < count; ++b) {
                // Each byte has seven bits. With the top bit set before a subtraction, the bit
                // stays if and only if the difference is not negative, and no byte borrows from the
                // next one.
                const std::uint32_t low = every_byte * grid.at(box[b].lower[axis], axis, 1);
                const std::uint32_t high = every_byte * grid.at(box[b].upper[axis], axis, 0) |
                                           top_bits;
                for (int w = 0; w < 4; ++w)
                    hits[b].word[w] &= (high - begin.word[w]) & (end.word[w] - low);
            }
        }
        for (std::uint32_t b = 0; b < count; ++b)
            for (int w = 0; w < 4; ++w)
                mask |= top_bits_together(hits[b].word[w]) << (constants::group_size * b + 4 * w);
#elif defined(PIERCE_FOUR_LANES)
        // The same with bytes in a vector register.
        for (std::uint32_t b = 0; b < count; ++b) {
            const StepRanges ranges(grid.at_end(box[b].lower, 1), grid.at_end(box[b].upper, 0));
            const SixteenBytes hits = ranges.overlap<0>(lower[0], upper[0]) &
                                      ranges.overlap<1>(lower[1], upper[1]) &
                                      ranges.overlap<2>(lower[2], upper[2]);
            mask |= hits.top_bits() << (constants::group_size * b);
        }
#else
        for (std::uint32_t b = 0; b < count; ++b)
            for (std::uint32_t k = 0; k < constants::group_size; ++k) {
                bool hit = true;
                for (int axis = 0; axis < 3; ++axis)
                    hit &= lower[axis].get(k) <= grid.at(box[b].upper[axis], axis, 0) &&
                           (upper[axis].get(k) & ~top_bit) >= grid.at(box[b].lower[axis], axis, 1);
                mask |= std::uint32_t{hit} << (constants::group_size * b + k);
            }
#endif
        return mask;
    }

    /// The top bits of all bytes, side by side: the product adds up shifted copies, whose bits do
    /// not overlap.
    PIERCE_HD static std::uint32_t top_bits_together(std::uint32_t bits) {
        return (bits >> 7) * 0x10204080u >> 28;
    }
};
static_assert(sizeof(GridBoxes) == 128);

}  // namespace pierce
