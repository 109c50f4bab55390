#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <vector>

#include "pierce/backend.hpp"
#include "support/device_backend.hpp"
#if PIERCE_HAS_CUDA
#include <cuda_runtime_api.h>

#include "pierce/cuda_backend.hpp"
#endif

namespace pierce::test {

/// Memory of the host that a device can read, too, where there is one.
template <class T>
struct SharedMemory {
    using value_type = T;

    SharedMemory() = default;
    template <class U>
    SharedMemory(const SharedMemory<U>&) {}
    template <class U>
    bool operator==(const SharedMemory<U>&) const {
        return true;
    }
#if PIERCE_HAS_CUDA
    static bool is_device_there() { return cuda_problem().empty(); }
    T* allocate(std::size_t count) {
        if (!is_device_there()) return std::allocator<T>().allocate(count);
        void* memory = nullptr;
        if (cudaMallocManaged(&memory, count * sizeof(T)) != cudaSuccess) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) {
        if (!is_device_there()) return std::allocator<T>().deallocate(memory, count);
        cudaFree(memory);
    }
#else
    T* allocate(std::size_t count) { return std::allocator<T>().allocate(count); }
    void deallocate(T* memory, std::size_t count) { std::allocator<T>().deallocate(memory, count); }
#endif
};

template <class T>
using SharedVector = std::vector<T, SharedMemory<T>>;

/// A backend on a device; where there is none, one that passes for it.
inline std::unique_ptr<Backend> device_backend() {
#if PIERCE_HAS_CUDA
    if (cuda_problem().empty()) return cuda_backend();
#endif
    return std::make_unique<DeviceBackend>();
}

}  // namespace pierce::test
