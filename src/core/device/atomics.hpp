#pragma once

#include <cstdint>

#include "pierce/host_device.hpp"

/// The few atomic operations that items of a stage need, on host and device. They work on integers
/// only, so that no result depends on the order of items. What a thread wrote before an operation
/// on 32 bits is visible to every thread that reads the operation's result.
namespace pierce {

/// Adds `value` and returns the previous value.
PIERCE_HD inline std::uint32_t atomic_add(std::uint32_t& target, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
    __threadfence();
    const std::uint32_t before = atomicAdd(&target, value);
    __threadfence();
    return before;
#else
    return __atomic_fetch_add(&target, value, __ATOMIC_ACQ_REL);
#endif
}

PIERCE_HD inline std::uint64_t atomic_add(std::uint64_t& target, std::uint64_t value) {
#if defined(__CUDA_ARCH__)
    static_assert(sizeof(unsigned long long) == sizeof(std::uint64_t));
    return atomicAdd(reinterpret_cast<unsigned long long*>(&target), value);
#else
    return __atomic_fetch_add(&target, value, __ATOMIC_ACQ_REL);
#endif
}

/// Adds to a counter that neighbouring items share: the threads of a warp add up first. It orders
/// no other memory access.
PIERCE_HD inline void atomic_count(std::uint32_t& counter, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
#if __CUDA_ARCH__ >= 800
    const unsigned here = __match_any_sync(__activemask(),
                                           reinterpret_cast<unsigned long long>(&counter));
    const unsigned sum = __reduce_add_sync(here, value);
    if (threadIdx.x % warpSize == static_cast<unsigned>(__ffs(static_cast<int>(here)) - 1))
        atomicAdd(&counter, sum);
#else
    atomicAdd(&counter, value);
#endif
#else
    __atomic_fetch_add(&counter, value, __ATOMIC_RELAXED);
#endif
}

/// Writes `value` and returns the previous value.
PIERCE_HD inline std::uint32_t atomic_exchange(std::uint32_t& target, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
    __threadfence();
    const std::uint32_t before = atomicExch(&target, value);
    __threadfence();
    return before;
#else
    return __atomic_exchange_n(&target, value, __ATOMIC_ACQ_REL);
#endif
}

/// Writes the larger of `target` and `value`.
PIERCE_HD inline void atomic_max(std::uint32_t& target, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
    atomicMax(&target, value);
#else
    std::uint32_t before = __atomic_load_n(&target, __ATOMIC_RELAXED);
    while (before < value && !__atomic_compare_exchange_n(&target, &before, value, true,
                                                          __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
#endif
}

/// What stands there while other items may set bits. It orders no other memory access.
PIERCE_HD inline std::uint32_t atomic_read(const std::uint32_t& target) {
#if defined(__CUDA_ARCH__)
    return *static_cast<const volatile std::uint32_t*>(&target);
#else
    return __atomic_load_n(&target, __ATOMIC_RELAXED);
#endif
}

/// Sets some bits; any number of items may do so. It orders no other memory access.
PIERCE_HD inline void atomic_set(std::uint32_t& target, std::uint32_t bits) {
    if ((atomic_read(target) & bits) == bits) return;
#if defined(__CUDA_ARCH__)
    atomicOr(&target, bits);
#else
    __atomic_fetch_or(&target, bits, __ATOMIC_RELAXED);
#endif
}

/// Writes 1; any number of items may do so.
PIERCE_HD inline void atomic_mark(std::uint32_t& target) {
#if defined(__CUDA_ARCH__)
    *static_cast<volatile std::uint32_t*>(&target) = 1;
#else
    __atomic_store_n(&target, 1u, __ATOMIC_RELAXED);
#endif
}

}  // namespace pierce
