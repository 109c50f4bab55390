#include "pierce/reference_backends.hpp"

#include "core/execute/serial_executor.hpp"
#include "core/partition/resting_backend.hpp"
#include "core/step/pipeline_backend.hpp"
#include "core/trace/brute_force_tracer.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "pierce/error.hpp"

namespace pierce {

std::unique_ptr<Backend> reference_backend() {
    return std::make_unique<PipelineBackend<SerialExecutor, BruteForceTracer>>(
        "reference, 1 thread", std::make_unique<SerialExecutor>(),
        std::make_unique<BruteForceTracer>());
}

void check_tree_builder(TreeBuilder builder) {
    if (builder > TreeBuilder::ploc)
        throw InputError("the builder of trees has a value without a meaning");
}

std::unique_ptr<Backend> bvh_backend(TreeOptions trees) {
    check_tree_builder(trees.builder);
    return resting_backend([=] {
        return std::make_unique<PipelineBackend<SerialExecutor, BvhTracer<SerialExecutor>>>(
            "bvh, 1 thread", std::make_unique<SerialExecutor>(),
            std::make_unique<BvhTracer<SerialExecutor>>(trees));
    });
}

}  // namespace pierce
