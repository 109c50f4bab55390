#pragma once

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <span>
#include <type_traits>
#include <utility>

#include "core/device/view.hpp"
#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/device_copy.hpp"
#include "gpu_cuda/device_count.hpp"
#include "gpu_cuda/turns.hpp"

namespace pierce::cuda {

/// An array in device memory, from the device's current memory pool (cudaDeviceSetMemPool chooses
/// it). The array grows and never shrinks, so that steady steps allocate nothing. Growing keeps the
/// items and does not initialize new ones. Growing also waits for the device, so that all streams
/// may use what was allocated on the default stream.
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
            return;  // buffers are exchanged while a step is captured, when CUDA forbids waiting
        const std::scoped_lock turn(captures_and_waits());
        cudaDeviceSynchronize();
        cudaFreeAsync(data_, nullptr);
    }

    T* data() { return data_; }
    const T* data() const { return data_; }
    /// The largest number of items that the buffer may hold now.
    std::size_t size() const { return count_.bound(); }
    /// The largest number of items that it can hold without growing.
    std::size_t capacity() const { return capacity_; }
    bool empty() const { return count_.bound() == 0; }
    DeviceCount count() const { return count_; }
    void clear() { count_ = {}; }

    void resize(DeviceCount count) {
        if (count.bound() > capacity_) grow(count.bound());
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
        const std::scoped_lock turn(captures_and_waits());
        check(cudaMallocAsync(&larger, capacity * sizeof(T), nullptr),
              "allocation of device memory");
        check(cudaDeviceSynchronize(), "waiting for the device");
        copy(larger, data_, count_.bound(), cudaMemcpyDeviceToDevice, nullptr);
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

/// One value that the device writes, and that the host reads after waiting for the device. It is in
/// host memory that both can access.
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

/// An array that the host writes and that the device copies without waiting for the host.
template <class T>
class StagingBuffer {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    StagingBuffer() = default;
    StagingBuffer(const StagingBuffer&) = delete;
    ~StagingBuffer() { cudaFreeHost(data_); }

    std::size_t capacity() const { return capacity_; }
    /// Room for `count` items; what they are is for the caller to say.
    T* resize(std::size_t count) {
        if (count > capacity_) {
            cudaFreeHost(data_);
            data_ = nullptr;
            capacity_ = 0;
            check(cudaHostAlloc(&data_, count * sizeof(T), cudaHostAllocDefault),
                  "allocation of pinned memory");
            capacity_ = count;
        }
        return data_;
    }

private:
    T* data_ = nullptr;
    std::size_t capacity_ = 0;
};

}  // namespace pierce::cuda
