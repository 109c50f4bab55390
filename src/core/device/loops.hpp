#pragma once

/// Put before a loop that waits for memory in every turn: it is unrolled, so that several turns
/// wait at once.
#if defined(__CUDA_ARCH__)
#define PIERCE_OVERLAPPED_LOOP _Pragma("unroll 8")
#else
#define PIERCE_OVERLAPPED_LOOP
#endif

/// Put before a loop of fixed length, so that a device can keep the items of an array that it
/// indexes in registers.
#if defined(__CUDA_ARCH__)
#define PIERCE_UNROLLED_LOOP _Pragma("unroll")
#else
#define PIERCE_UNROLLED_LOOP
#endif

/// Put before a loop of fixed length that should become vector instructions: GCC would unroll it
/// first and could then no longer make them.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define PIERCE_VECTOR_LOOP _Pragma("GCC unroll 1")
#else
#define PIERCE_VECTOR_LOOP
#endif
