#pragma once

/// Marks a function that runs on the host and, when compiled by nvcc, on the device.
#if defined(__CUDACC__)
#define PIERCE_HD __host__ __device__
#else
#define PIERCE_HD
#endif
