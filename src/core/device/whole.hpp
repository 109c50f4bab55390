#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "pierce/host_device.hpp"

/// Reading and writing items in words of sixteen bytes on a GPU. Threads side by side have their
/// items far apart, so that single members would cost a memory access each.
///
/// Per-item structs use explicit padding: nvcc copies structs with implicit padding at their end
/// byte by byte (measured: seven times slower for a list of rays).
namespace pierce {

namespace detail {
template <class T>
struct Words {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) == 16);
    struct alignas(16) Word {
        std::uint32_t part[4];
    };
    Word word[sizeof(T) / 16];
};
}  // namespace detail

template <class T>
PIERCE_HD T read_whole(const T& at) {
#if defined(__CUDA_ARCH__)
    detail::Words<T> words;
    for (std::size_t k = 0; k < sizeof(T) / 16; ++k)
        *reinterpret_cast<uint4*>(&words.word[k]) = reinterpret_cast<const uint4*>(&at)[k];
    T value;
    memcpy(&value, &words, sizeof(T));
    return value;
#else
    return at;
#endif
}

/// Begins to read what will be needed soon. A GPU has other threads to run while one waits.
template <class T>
PIERCE_HD void read_ahead([[maybe_unused]] const T& at) {
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
    __builtin_prefetch(&at);
#endif
}

template <class T>
PIERCE_HD void write_whole(T& at, const T& value) {
#if defined(__CUDA_ARCH__)
    detail::Words<T> words;
    memcpy(&words, &value, sizeof(T));
    for (std::size_t k = 0; k < sizeof(T) / 16; ++k)
        reinterpret_cast<uint4*>(&at)[k] = *reinterpret_cast<const uint4*>(&words.word[k]);
#else
    at = value;
#endif
}

}  // namespace pierce
