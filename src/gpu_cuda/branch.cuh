#pragma once

#include <cuda_runtime.h>

#include "gpu_cuda/cuda_check.hpp"
#include "gpu_cuda/stage_kernels.cuh"

/// Parts of a captured step that a graph leaves out where they have nothing to do.
namespace pierce::cuda {

inline __global__ void decide(const cudaGraphConditionalHandle branch, const Items items) {
    cudaGraphSetConditional(branch, items.count() > 0);
}

/// True if what is issued to the stream becomes part of a graph.
inline bool is_captured(cudaStream_t stream) {
    cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
    check(cudaStreamIsCapturing(stream, &status), "the state of a stream");
    return status == cudaStreamCaptureStatusActive;
}

/// Where a stream's capture stands.
struct Capture {
    cudaGraph_t graph = nullptr;
    const cudaGraphNode_t* nodes = nullptr;  ///< what the next node waits for
    std::size_t node_count = 0;

    explicit Capture(cudaStream_t stream) {
        cudaStreamCaptureStatus status;
#if CUDART_VERSION >= 13000
        check(cudaStreamGetCaptureInfo(stream, &status, nullptr, &graph, &nodes, nullptr,
                                       &node_count),
              "the state of a capture");
#else
        check(cudaStreamGetCaptureInfo_v2(stream, &status, nullptr, &graph, &nodes, &node_count),
              "the state of a capture");
#endif
    }
};

/// Adds a branch to the graph that `stream` is captured into. The graph takes the branch if there
/// are items when it gets there. Returns the branch's own graph, which is empty so far.
inline cudaGraph_t add_branch(cudaStream_t stream, const Items& items) {
    cudaGraphConditionalHandle handle;
    check(cudaGraphConditionalHandleCreate(&handle, Capture(stream).graph, 0,
                                           cudaGraphCondAssignDefault),
          "a branch");
    decide<<<1, 1, 0, stream>>>(handle, items);
    check(cudaGetLastError(), "a launch");
    cudaGraphNodeParams branch = {};
    branch.type = cudaGraphNodeTypeConditional;
    branch.conditional.handle = handle;
    branch.conditional.type = cudaGraphCondTypeIf;
    branch.conditional.size = 1;
    const Capture before(stream);
    cudaGraphNode_t node = nullptr;
#if CUDART_VERSION >= 13000
    check(cudaGraphAddNode(&node, before.graph, before.nodes, nullptr, before.node_count, &branch),
          "a branch");
    check(cudaStreamUpdateCaptureDependencies(stream, &node, nullptr, 1,
                                              cudaStreamSetCaptureDependencies),
          "a branch");
#else
    check(cudaGraphAddNode(&node, before.graph, before.nodes, before.node_count, &branch),
          "a branch");
    check(cudaStreamUpdateCaptureDependencies(stream, &node, 1, cudaStreamSetCaptureDependencies),
          "a branch");
#endif
    return branch.conditional.phGraph_out[0];
}

}  // namespace pierce::cuda
