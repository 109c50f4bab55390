#pragma once

#include <cstdint>

#include "core/device/bits.hpp"
#include "core/device/ordered_float.hpp"
#include "core/device/warp.hpp"
#include "pierce/host_device.hpp"
#include "pierce/min_max.hpp"

/// Work on one thing that several threads share, with a room in which they meet. On a GPU the
/// threads of a warp work on it, each of them a lane. On the host one thread is the only lane. A
/// stage is launched with executor.in_lanes(things).
namespace pierce {

/// Threads of a block in which lanes have rooms. Larger blocks would need room for more at once.
inline constexpr std::uint32_t room_threads = 64;

/// One thread that works on a thing by itself. It has the functions of Lanes.
struct Alone {
    static constexpr std::uint32_t count = 1;

    PIERCE_HD static std::uint32_t thing_of(std::uint32_t item) { return item; }
    PIERCE_HD static std::uint32_t lane() { return 0; }
    PIERCE_HD static bool is_first() { return true; }
    PIERCE_HD static void settle() {}
    PIERCE_HD static std::uint32_t ask(bool flag) { return flag; }
    PIERCE_HD static std::uint32_t before(std::uint32_t) { return 0; }
    PIERCE_HD static std::uint32_t from(std::uint32_t, std::uint32_t value) { return value; }
    PIERCE_HD static std::uint32_t least(std::uint32_t value) { return value; }
    PIERCE_HD static float least(float value) { return value; }
    PIERCE_HD static float largest(float value) { return value; }

    template <class Work>
    PIERCE_HD static void share(std::uint32_t begin, std::uint32_t end, const Work& work) {
        for (std::uint32_t k = begin; k < end; ++k) work(k);
    }
};

#if defined(__CUDA_ARCH__)
/// The lanes that work on one thing. All of them must call every function.
struct Lanes {
    static constexpr std::uint32_t count = warp_threads;

    PIERCE_HD static std::uint32_t thing_of(std::uint32_t item) { return item / count; }
    PIERCE_HD static std::uint32_t lane() { return threadIdx.x % count; }
    PIERCE_HD static bool is_first() { return lane() == 0; }
    /// Waits until what the other lanes wrote can be read.
    PIERCE_HD static void settle() { __syncwarp(); }
    /// A bit for every lane with a true flag.
    PIERCE_HD static std::uint32_t ask(bool flag) { return __ballot_sync(all, flag); }
    /// How many of the lanes before this one are in a mask from ask().
    PIERCE_HD static std::uint32_t before(std::uint32_t mask) {
        return bit_count(mask & ((1u << lane()) - 1));
    }
    /// What a lane has.
    PIERCE_HD static std::uint32_t from(std::uint32_t lane, std::uint32_t value) {
        return __shfl_sync(all, value, static_cast<int>(lane));
    }
    /// The least of what the lanes have. NaN counts as more than any number.
    PIERCE_HD static std::uint32_t least(std::uint32_t value) {
#if __CUDA_ARCH__ >= 800
        return __reduce_min_sync(all, value);
#else
        for (std::uint32_t step = count / 2; step > 0; step /= 2)
            value = min_of(value, __shfl_xor_sync(all, value, step));
        return value;
#endif
    }
    PIERCE_HD static float least(float value) {
        return from_ordered_bits(least(value == value ? ordered_bits(value) : ~0u));
    }
    /// The largest of what the lanes have. NaN counts as less than any number.
    PIERCE_HD static float largest(float value) { return -least(-value); }

    /// Calls work(k) for this lane's share of begin <= k < end.
    template <class Work>
    PIERCE_HD static void share(std::uint32_t begin, std::uint32_t end, const Work& work) {
        for (std::uint32_t k = begin + lane(); k < end; k += count) work(k);
    }

private:
    static constexpr unsigned all = 0xffffffffu;
};
#elif defined(__CUDACC__)
struct Lanes : Alone {
    static constexpr std::uint32_t count = warp_threads;
};
#else
using Lanes = Alone;
#endif

/// Emits what `Finder` finds, each item by the first of its lanes: items that take very different
/// ways would wait for each other if they were lanes of one warp.
template <class Finder>
struct FindApart {
    Finder finder;

    explicit PIERCE_HD FindApart(const Finder& its_finder) : finder(its_finder) {}
    PIERCE_HD auto find(std::uint32_t item) const {
        using Seen = decltype(finder.find(item));
        return Lanes::is_first() ? finder.find(Lanes::thing_of(item)) : Seen{};
    }
    template <class Found>
    PIERCE_HD static std::uint32_t count(const Found& found) {
        return Finder::count(found);
    }
    template <class Found, class... T>
    PIERCE_HD void write(std::uint32_t item, const Found& found, std::uint32_t place,
                         T*... lists) const {
        if (Finder::count(found) > 0) finder.write(Lanes::thing_of(item), found, place, lists...);
    }
};

/// Memory in which the lanes that work on one thing meet. `T` must need no constructor. A stage may
/// have one room of a type, and must say so: `static constexpr bool has_rooms = true`.
template <class T>
class Room {
public:
#if defined(__CUDA_ARCH__)
    PIERCE_HD Room() {
        __shared__ T rooms[room_threads / Lanes::count];
        room_ = &rooms[threadIdx.x / Lanes::count];
    }
    PIERCE_HD T& operator*() const { return *room_; }

private:
    T* room_;
#else
    // Lanes fill what they read.
    Room() {}  // NOLINT(cppcoreguidelines-pro-type-member-init,modernize-use-equals-default)
    T& operator*() { return room_; }

private:
    T room_;
#endif
};

/// `size` numbers that those who work on one thing share (`Who`: Lanes or Alone). On a GPU the
/// numbers of things side by side lie side by side. It counts as a room.
template <class Who, std::uint32_t size>
class SharedNumbers {
public:
#if defined(__CUDA_ARCH__)
    PIERCE_HD SharedNumbers() {
        __shared__ float numbers[size * things];
        numbers_ = numbers + threadIdx.x / Who::count;
    }
    PIERCE_HD float& operator[](std::uint32_t i) const { return numbers_[i * things]; }

private:
    static constexpr std::uint32_t things = room_threads / Who::count;
    float* numbers_;
#else
    // Lanes fill what they read.
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init,modernize-use-equals-default)
    SharedNumbers() {}
    float& operator[](std::uint32_t i) { return numbers_[i]; }
    float operator[](std::uint32_t i) const { return numbers_[i]; }

private:
    float numbers_[size];
#endif
};

/// The smaller of what a room holds and `value`; any number of lanes may bring one.
template <class T>
PIERCE_HD void keep_least(T& target, T value) {
#if defined(__CUDA_ARCH__)
    atomicMin(&target, value);
#else
    target = min_of(target, value);
#endif
}

/// The same with the larger one.
template <class T>
PIERCE_HD void keep_largest(T& target, T value) {
#if defined(__CUDA_ARCH__)
    atomicMax(&target, value);
#else
    target = max_of(target, value);
#endif
}

/// The same with the sum.
PIERCE_HD inline void keep_sum(std::uint32_t& target, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
    atomicAdd(&target, value);
#else
    target += value;
#endif
}

}  // namespace pierce
