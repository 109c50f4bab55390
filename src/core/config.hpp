#pragma once

/// Marks a function that runs on the host and, when compiled by nvcc, on the device.
#if defined(__CUDACC__)
#define PIERCE_HD __host__ __device__
#else
#define PIERCE_HD
#endif

/// With PIERCE_CHECKED_VIEWS, what is read or written through a View is within it, or the program ends and says where.
#if defined(PIERCE_CHECKED_VIEWS) && !defined(__CUDA_ARCH__)
#include <cstdio>
#include <cstdlib>
#define PIERCE_CHECK_PLACE(place, size)                                                                      \
    ((place) < (size) ? void() : (std::fprintf(stderr, "%s:%d: place %zu of %zu in %s\n", __FILE__, __LINE__, \
                                               std::size_t{place}, std::size_t{size}, __PRETTY_FUNCTION__), \
                                  std::abort()))
#else
#define PIERCE_CHECK_PLACE(place, size) void()
#endif

// What stages write item by item has no room left at its end, but members named `padding`: where there is room, nvcc copies
// byte by byte (measured: seven times slower for a list of rays).

/// Put before a loop whose turns wait for memory: several then wait at once.
#if defined(__CUDA_ARCH__)
#define PIERCE_OVERLAPPED_LOOP _Pragma("unroll 8")
#else
#define PIERCE_OVERLAPPED_LOOP
#endif

/// Put before a loop of fixed length that should become vector instructions: GCC would unroll it first and then cannot.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define PIERCE_VECTOR_LOOP _Pragma("GCC unroll 1")
#else
#define PIERCE_VECTOR_LOOP
#endif
