#pragma once

#include <cuda_runtime_api.h>

#include <utility>

#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/on_device.hpp"

namespace pierce::cuda {

/// The stream on which the caller writes places and reads contacts; it may be another device's.
class CallerStream {
public:
    CallerStream() = default;
    CallerStream(const CallerStream&) = delete;
    ~CallerStream() {
        for (cudaEvent_t event : {is_ready_, is_done_})
            if (event != nullptr) cudaEventDestroy(event);
    }

    /// Null: there is none. If it throws, the stream stays the one before. To be called where the
    /// device that has the steps is the current one.
    void set(cudaStream_t stream) {
        CallerStream other;
        if (stream != nullptr) other.open(stream);
        std::swap(stream_, other.stream_);
        std::swap(is_ready_, other.is_ready_);
        std::swap(is_done_, other.is_done_);
    }
    bool exists() const { return stream_ != nullptr; }
    /// What is issued on `ours` from now on begins when all is done that the caller has issued.
    void hold_up(cudaStream_t ours) {
        if (stream_ != nullptr) pass(stream_, is_ready_, ours);
    }
    /// What the caller issues from now on begins when all is done that is issued on `ours`.
    void let_go_on(cudaStream_t ours) {
        if (stream_ != nullptr) pass(ours, is_done_, stream_);
    }

private:
    void open(cudaStream_t stream) {
        int device = 0;
        check(cudaStreamGetDevice(stream, &device), "the device of a stream");
        // An event is recorded on the device that has made it.
        make(is_done_);
        const OnDevice there(device);
        make(is_ready_);
        stream_ = stream;
    }
    static void make(cudaEvent_t& event) {
        check(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "an event");
    }
    static void pass(cudaStream_t from, cudaEvent_t event, cudaStream_t to) {
        check(cudaEventRecord(event, from), "an event");
        check(cudaStreamWaitEvent(to, event), "an event");
    }

    cudaStream_t stream_ = nullptr;
    cudaEvent_t is_ready_ = nullptr;  ///< what the caller has issued is done
    cudaEvent_t is_done_ = nullptr;   ///< what we have issued is done
};

}  // namespace pierce::cuda
