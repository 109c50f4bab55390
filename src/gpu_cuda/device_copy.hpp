#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>

#include "gpu_cuda/cuda_check.hpp"

namespace pierce::cuda {

/// Starts the copy of an array to, from or within device memory, in the order of the stream.
template <class T>
void copy(T* to, const T* from, std::size_t count, cudaMemcpyKind kind, cudaStream_t stream) {
    if (count > 0) check(cudaMemcpyAsync(to, from, count * sizeof(T), kind, stream), "a copy");
}

}  // namespace pierce::cuda
