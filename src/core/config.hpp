#pragma once

/// Marks a function that runs on the host and, when compiled by nvcc, on the device.
#if defined(__CUDACC__)
#define PIERCE_HD __host__ __device__
#else
#define PIERCE_HD
#endif

/// Put before a loop of fixed length that should become vector instructions: GCC would unroll it first and then cannot.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define PIERCE_VECTOR_LOOP _Pragma("GCC unroll 1")
#else
#define PIERCE_VECTOR_LOOP
#endif
