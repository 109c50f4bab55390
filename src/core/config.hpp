#pragma once

/// Marks a function that runs on the host and, when compiled by nvcc, on the device.
#if defined(__CUDACC__)
#define PIERCE_HD __host__ __device__
#else
#define PIERCE_HD
#endif

// What stages write item by item has no room left at its end, but members named `padding`: where there is room, nvcc copies
// byte by byte (measured: seven times slower for a list of rays).

/// Put before a loop of fixed length that should become vector instructions: GCC would unroll it first and then cannot.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define PIERCE_VECTOR_LOOP _Pragma("GCC unroll 1")
#else
#define PIERCE_VECTOR_LOOP
#endif
