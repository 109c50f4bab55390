#pragma once

#include <cuda_runtime_api.h>

#include <new>

#include "gpu_cuda/cuda_check.hpp"

namespace pierce::cuda {

/// The device on which the calling thread works now.
inline int current_device() {
    int device = 0;
    check(cudaGetDevice(&device), "the current device");
    return device;
}

/// Makes a device the calling thread's current one until the end of a block.
class OnDevice {
public:
    explicit OnDevice(int device) : before_(current_device()) {
        check(cudaSetDevice(device), "the choice of a device");
    }
    OnDevice(const OnDevice&) = delete;
    /// In a destructor, where an error of earlier work must not throw.
    OnDevice(int device, std::nothrow_t) noexcept : before_(device) {
        cudaGetDevice(&before_);
        cudaSetDevice(device);
    }
    ~OnDevice() { cudaSetDevice(before_); }

private:
    int before_;
};

}  // namespace pierce::cuda
