#pragma once

#include <cuda_runtime_api.h>

#include <stdexcept>
#include <string>

namespace pierce::cuda {

/// Throws std::runtime_error, saying what failed, unless a call to CUDA succeeded.
inline void check(cudaError_t error, const char* what) {
    if (error != cudaSuccess)
        throw std::runtime_error(std::string("CUDA: ") + what + ": " + cudaGetErrorString(error));
}

}  // namespace pierce::cuda
