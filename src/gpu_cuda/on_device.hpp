#pragma once

#include <cuda_runtime_api.h>

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
    ~OnDevice() { cudaSetDevice(before_); }

private:
    int before_;
};

}  // namespace pierce::cuda
