#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/device/loops.hpp"
#include "pierce/host_device.hpp"
#include "pierce/vec3.hpp"

#if defined(__GNUC__) && !defined(__CUDACC__) && !defined(PIERCE_FUSED_PRODUCTS)
#define PIERCE_FOUR_LANES  // of one vector register
#endif

namespace pierce {

/// Four float32, with arithmetic on all of them at once: on the host in one vector register, which
/// a compiler does not find by itself in longer computations.
struct Four {
    static constexpr std::uint32_t count = 4;
    static constexpr std::uint32_t all_bits = (1u << count) - 1;  ///< a bit for each lane

#if defined(PIERCE_FOUR_LANES)
    using FourLanes = float __attribute__((vector_size(16)));
    using Bits = std::int32_t __attribute__((vector_size(16)));

    FourLanes lane;

    Four() = default;
    Four(float all) : lane{all, all, all, all} {}
    Four(float a, float b, float c, float d) : lane{a, b, c, d} {}
    Four(FourLanes lanes) : lane(lanes) {}

    /// The four that lie at an address.
    static Four at(const void* address) {
        FourLanes lanes{};
        std::memcpy(&lanes, address, sizeof lanes);
        return lanes;
    }

    friend Four operator+(Four a, Four b) { return a.lane + b.lane; }
    friend Four operator-(Four a, Four b) { return a.lane - b.lane; }
    friend Four operator*(Four a, Four b) { return a.lane * b.lane; }
    friend Four operator/(Four a, Four b) { return a.lane / b.lane; }
    friend Four operator-(Four a) { return -a.lane; }
    /// Of two numbers of which one is NaN: the second.
    friend Four max_of(Four a, Four b) { return a.lane > b.lane ? a.lane : b.lane; }
    friend Four min_of(Four a, Four b) { return a.lane < b.lane ? a.lane : b.lane; }
    friend Four abs_of(Four a) {
        return reinterpret_cast<FourLanes>(reinterpret_cast<Bits>(a.lane) & 0x7fffffff);
    }
    friend Four whole_part_of(Four a) {
        return __builtin_convertvector(__builtin_convertvector(a.lane, Bits), FourLanes);
    }
    friend Four where(Four a, Four less_than, Four then, Four otherwise) {
        return a.lane < less_than.lane ? then.lane : otherwise.lane;
    }
    /// A bit for each lane in which a is greater.
    friend std::uint32_t greater(Four a, Four b) { return sign_bits(a.lane > b.lane); }

    /// Four whole numbers that lie at an address.
    static Bits bits_at(const void* address) {
        Bits bits{};
        std::memcpy(&bits, address, sizeof bits);
        return bits;
    }
    /// The sign bits of four whole numbers that are 0 or -1, side by side.
    static std::uint32_t sign_bits(Bits truths) {
#if defined(__SSE__)
        return static_cast<std::uint32_t>(
            __builtin_ia32_movmskps(reinterpret_cast<FourLanes>(truths)));
#else
        const Bits bits = truths & Bits{1, 2, 4, 8};
        std::uint64_t half[2];
        std::memcpy(half, &bits, sizeof half);
        const std::uint64_t both = half[0] | half[1];
        return static_cast<std::uint32_t>(both | both >> 32);
#endif
    }
#else
    float lane[count];

    Four() = default;
    PIERCE_HD Four(float all) : lane{all, all, all, all} {}
    PIERCE_HD Four(float a, float b, float c, float d) : lane{a, b, c, d} {}

    template <class F>
    PIERCE_HD static Four of(const F& f) {
        Four result;
        PIERCE_UNROLLED_LOOP
        for (std::uint32_t k = 0; k < count; ++k) result.lane[k] = f(k);
        return result;
    }
    PIERCE_HD friend Four operator+(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] + b.lane[k]; });
    }
    PIERCE_HD friend Four operator-(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] - b.lane[k]; });
    }
    PIERCE_HD friend Four operator*(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] * b.lane[k]; });
    }
    PIERCE_HD friend Four operator/(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] / b.lane[k]; });
    }
    PIERCE_HD friend Four operator-(Four a) {
        return of([&](std::uint32_t k) { return -a.lane[k]; });
    }
    PIERCE_HD friend Four max_of(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] > b.lane[k] ? a.lane[k] : b.lane[k]; });
    }
    PIERCE_HD friend Four min_of(Four a, Four b) {
        return of([&](std::uint32_t k) { return a.lane[k] < b.lane[k] ? a.lane[k] : b.lane[k]; });
    }
    PIERCE_HD friend Four abs_of(Four a) {
        return of([&](std::uint32_t k) { return std::fabs(a.lane[k]); });
    }
    /// Without what is behind the point; of numbers below 2^31.
    PIERCE_HD friend Four whole_part_of(Four a) {
        return of([&](std::uint32_t k) {
            return static_cast<float>(static_cast<std::int32_t>(a.lane[k]));
        });
    }
    /// A bit for each lane in which a is greater.
    PIERCE_HD friend std::uint32_t greater(Four a, Four b) {
        std::uint32_t bits = 0;
        for (std::uint32_t k = 0; k < count; ++k) bits |= std::uint32_t{a.lane[k] > b.lane[k]} << k;
        return bits;
    }
    /// `then` where a is less, otherwise `otherwise`.
    PIERCE_HD friend Four where(Four a, Four less_than, Four then, Four otherwise) {
        return of([&](std::uint32_t k) {
            return a.lane[k] < less_than.lane[k] ? then.lane[k] : otherwise.lane[k];
        });
    }
#endif

    /// The smallest of the four.
    PIERCE_HD friend float least_of(Four a) {
        const float one = a[2] < a[0] ? a[2] : a[0], other = a[3] < a[1] ? a[3] : a[1];
        return one < other ? one : other;
    }

    PIERCE_HD friend Vec3f first_three(Four a) { return {a[0], a[1], a[2]}; }

    /// Puts the four at an address.
    void put(void* address) const { std::memcpy(address, &lane, sizeof lane); }

    PIERCE_HD float operator[](std::uint32_t k) const { return lane[k]; }
    PIERCE_HD void set(std::uint32_t k, float value) { lane[k] = value; }
};

/// Four words of 32 bits.
struct FourWords {
    static constexpr std::uint32_t count = Four::count;

    std::uint32_t word[count];

    /// Of each, the `bits` bits from `first` on, as a number with a sign.
    template <int first, int bits>
    PIERCE_HD Four field() const {
#if defined(PIERCE_FOUR_LANES)
        Four::Bits lanes;
        std::memcpy(&lanes, word, sizeof lanes);
        return __builtin_convertvector(lanes << (32 - first - bits) >> (32 - bits),
                                       Four::FourLanes);
#else
        return Four::of([&](std::uint32_t k) {
            return static_cast<float>(static_cast<std::int32_t>(word[k] << (32 - first - bits)) >>
                                      (32 - bits));
        });
#endif
    }
};

/// Four points or directions.
struct FourVec3 {
    Four x, y, z;

    /// A point or direction, four times.
    PIERCE_HD static FourVec3 all(Vec3f v) { return {v.x, v.y, v.z}; }

#if defined(PIERCE_FOUR_LANES)
    static FourVec3 of(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
        using FourLanes = Four::FourLanes;
        return {FourLanes{a.x, b.x, c.x, d.x}, FourLanes{a.y, b.y, c.y, d.y},
                FourLanes{a.z, b.z, c.z, d.z}};
    }
    /// Four points, each in the first twelve of sixteen bytes, and the numbers after them. The
    /// addresses are no array: GCC 12 would compute them in vector registers, by way of memory.
    static FourVec3 gathered(const void* at_a, const void* at_b, const void* at_c, const void* at_d,
                             Four& after) {
        using FourLanes = Four::FourLanes;
        const FourLanes a = Four::at(at_a).lane, b = Four::at(at_b).lane, c = Four::at(at_c).lane,
                        d = Four::at(at_d).lane;
        const FourLanes xy_of_ab = __builtin_shufflevector(a, b, 0, 4, 1, 5),
                        xy_of_cd = __builtin_shufflevector(c, d, 0, 4, 1, 5),
                        zw_of_ab = __builtin_shufflevector(a, b, 2, 6, 3, 7),
                        zw_of_cd = __builtin_shufflevector(c, d, 2, 6, 3, 7);
        after = __builtin_shufflevector(zw_of_ab, zw_of_cd, 2, 3, 6, 7);
        return {__builtin_shufflevector(xy_of_ab, xy_of_cd, 0, 1, 4, 5),
                __builtin_shufflevector(xy_of_ab, xy_of_cd, 2, 3, 6, 7),
                __builtin_shufflevector(zw_of_ab, zw_of_cd, 0, 1, 4, 5)};
    }
    /// As for one vector: the sums are in the same order.
    friend Four quick_dot(FourVec3 a, FourVec3 b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
    friend Four sum_of_sizes(FourVec3 v) { return abs_of(v.x) + abs_of(v.y) + abs_of(v.z); }
#else
    PIERCE_HD static FourVec3 of(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
        const Vec3f all[Four::count] = {a, b, c, d};
        return {Four::of([&](std::uint32_t k) { return all[k].x; }),
                Four::of([&](std::uint32_t k) { return all[k].y; }),
                Four::of([&](std::uint32_t k) { return all[k].z; })};
    }
#endif

    PIERCE_HD friend FourVec3 operator+(FourVec3 a, FourVec3 b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    PIERCE_HD friend FourVec3 operator-(FourVec3 a, FourVec3 b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    PIERCE_HD friend FourVec3 operator*(FourVec3 a, Four s) { return {a.x * s, a.y * s, a.z * s}; }
    PIERCE_HD friend FourVec3 cross(FourVec3 a, FourVec3 b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    PIERCE_HD friend Four dot(FourVec3 a, FourVec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    /// The largest coordinate of each, without sign.
    PIERCE_HD friend Four largest_of(FourVec3 a) {
        return max_of(max_of(abs_of(a.x), abs_of(a.y)), abs_of(a.z));
    }
};

}  // namespace pierce
