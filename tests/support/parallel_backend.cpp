#include "core/step/pipeline_backend.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "support/executor_backends.hpp"
#include "support/parallel_executor.hpp"

namespace pierce::test {

std::unique_ptr<Backend> parallel_backend() {
    return std::make_unique<PipelineBackend<ParallelExecutor, BvhTracer<ParallelExecutor>>>(
        "parallel algorithms", std::make_unique<ParallelExecutor>(),
        std::make_unique<BvhTracer<ParallelExecutor>>());
}

}  // namespace pierce::test
