#pragma once

#include <cuda_runtime.h>

#include <mutex>

#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/turns.hpp"

namespace pierce::cuda {

/// A graph of what `issue` puts on a stream. Whatever `issue` throws ends the capture.
template <class Issue>
cudaGraphExec_t captured(cudaStream_t stream, const Issue& issue) {
    const std::scoped_lock turn(captures_and_waits());
    check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), "capture of a step");
    cudaGraph_t graph = nullptr;
    try {
        issue();
    } catch (...) {
        cudaStreamEndCapture(stream, &graph);
        if (graph != nullptr) cudaGraphDestroy(graph);
        throw;
    }
    check(cudaStreamEndCapture(stream, &graph), "capture of a step");
    cudaGraphExec_t executable = nullptr;
    const cudaError_t made = cudaGraphInstantiate(&executable, graph, 0);
    cudaGraphDestroy(graph);
    check(made, "a graph of a step");
    return executable;
}

}  // namespace pierce::cuda
