#pragma once

#include <cuda_runtime_api.h>

#include <stdexcept>
#include <string>

#include "pierce/error.hpp"

namespace pierce::cuda {

/// Throws, saying what failed, unless a call to CUDA succeeded: OutOfMemory where a device has none
/// left, std::runtime_error otherwise.
inline void check(cudaError_t error, const char* what) {
    if (error == cudaSuccess) return;
    const std::string message = std::string("CUDA: ") + what + ": " + cudaGetErrorString(error);
    if (error == cudaErrorMemoryAllocation) throw OutOfMemory(message);
    throw std::runtime_error(message);
}

}  // namespace pierce::cuda
