#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>

#include "core/device/view.hpp"
#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/device_count.hpp"

namespace pierce::cuda {

/// An array in device memory, from the device's current memory pool (cudaDeviceSetMemPool chooses
/// it). It grows and never shrinks, so that steady steps allocate nothing; what is in it stays,
/// what is new is not initialized. Growing waits for the device, so that all streams may use what
/// was allocated on the default one.
template <class T>
class DeviceBuffer {
    static_assert(std::is_trivially_destructible_v<T>);

public:
    DeviceBuffer() = default;
    DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
    DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~DeviceBuffer() {
        if (data_ == nullptr)
            return;  // while a step is captured, buffers are exchanged, and CUDA forbids to wait
        cudaDeviceSynchronize();
        cudaFreeAsync(data_, nullptr);
    }

    T* data() { return data_; }
    const T* data() const { return data_; }
    /// At most so many items.
    std::size_t size() const { return count_.bound; }
    bool empty() const { return count_.bound == 0; }
    DeviceCount count() const { return count_; }
    void clear() { count_ = {}; }

    void resize(DeviceCount count) {
        if (count.bound > capacity_) grow(count.bound);
        count_ = count;
    }

private:
    void swap(DeviceBuffer& other) {
        std::swap(data_, other.data_);
        std::swap(capacity_, other.capacity_);
        std::swap(count_, other.count_);
    }

    void grow(std::size_t least) {
        const std::size_t capacity = std::max(least, capacity_ + capacity_ / 2);
        T* larger = nullptr;
        check(cudaMallocAsync(&larger, capacity * sizeof(T), nullptr),
              "allocation of device memory");
        check(cudaDeviceSynchronize(), "waiting for the device");
        if (count_.bound > 0)
            check(cudaMemcpyAsync(larger, data_, count_.bound * sizeof(T), cudaMemcpyDeviceToDevice,
                                  nullptr),
                  "copy on the device");
        if (data_ != nullptr) check(cudaFreeAsync(data_, nullptr), "return of device memory");
        check(cudaStreamSynchronize(nullptr), "waiting for the device");
        data_ = larger;
        capacity_ = capacity;
    }

    T* data_ = nullptr;
    std::size_t capacity_ = 0;
    DeviceCount count_;
};

template <class T>
DeviceCount count_of(const DeviceBuffer<T>& buffer) {
    return buffer.count();
}

/// One value that the device writes and the host reads once the device is done: host memory that
/// both see.
template <class T>
class SharedValue {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    SharedValue() {
        check(cudaHostAlloc(&data_, sizeof(T), cudaHostAllocMapped), "allocation of pinned memory");
    }
    SharedValue(SharedValue&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
    ~SharedValue() { cudaFreeHost(data_); }

    T* data() const { return data_; }

private:
    T* data_ = nullptr;
};

}  // namespace pierce::cuda
