#pragma once

#include <cuda_runtime_api.h>

#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/on_device.hpp"

namespace pierce::cuda {

/// The stream on which the caller writes places and reads contacts; it may be another device's.
class CallerStream {
public:
    CallerStream() = default;
    CallerStream(const CallerStream&) = delete;
    ~CallerStream() { forget(); }

    /// Null: there is none. To be called where the device that has the steps is the current one.
    void set(cudaStream_t stream) {
        forget();
        if (stream == nullptr) return;
        int device = 0;
        check(cudaStreamGetDevice(stream, &device), "the device of a stream");
        // An event is recorded on the device that has made it.
        make(is_done_);
        const OnDevice there(device);
        make(is_ready_);
        stream_ = stream;
    }
    /// What is issued on `ours` from now on begins when all is done that the caller has issued.
    void hold_up(cudaStream_t ours) {
        if (stream_ != nullptr) pass(stream_, is_ready_, ours);
    }
    /// What the caller issues from now on begins when all is done that is issued on `ours`.
    void let_go_on(cudaStream_t ours) {
        if (stream_ != nullptr) pass(ours, is_done_, stream_);
    }

private:
    static void make(cudaEvent_t& event) {
        check(cudaEventCreateWithFlags(&event, cudaEventDisableTiming), "an event");
    }
    static void pass(cudaStream_t from, cudaEvent_t event, cudaStream_t to) {
        check(cudaEventRecord(event, from), "an event");
        check(cudaStreamWaitEvent(to, event), "an event");
    }
    void forget() {
        for (cudaEvent_t* event : {&is_ready_, &is_done_}) {
            if (*event != nullptr) cudaEventDestroy(*event);
            *event = nullptr;
        }
        stream_ = nullptr;
    }

    cudaStream_t stream_ = nullptr;
    cudaEvent_t is_ready_ = nullptr;  ///< what the caller has issued is done
    cudaEvent_t is_done_ = nullptr;   ///< what we have issued is done
};

}  // namespace pierce::cuda
