#include "support/backends.hpp"

#include <algorithm>
#include <vector>

#include "core/step/pipeline_backend.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "pierce/embree_backend.hpp"
#include "pierce/reference_backends.hpp"
#include "support/parallel_executor.hpp"
#include "support/shuffled_executor.hpp"
#if PIERCE_HAS_CUDA
#include "pierce/cuda_backend.hpp"
#endif

namespace pierce::test {
namespace {

/// Our own trees, which know what bodies there are.
class ArrangedTrees : public BvhTracer<ShuffledExecutor> {
public:
    void update(ShuffledExecutor& executor, View<const BodyView> bodies,
                View<const std::uint32_t> wanted) {
        arrange(executor, bodies);
        BvhTracer::update(executor, bodies, wanted);
    }
};

/// Does every step twice, as a GPU does when a list outgrows its room: the first time for nothing.
class ShuffledBackend : public PipelineBackend<ShuffledExecutor, ArrangedTrees> {
public:
    ShuffledBackend()
        : PipelineBackend("shuffled, 1 thread", std::make_unique<ShuffledExecutor>(),
                          std::make_unique<ArrangedTrees>()) {}
    bool certificates_pay() const override { return false; }

    void step(const Scene& scene, StepStats& stats) override {
        std::vector<std::vector<SeenPatch>> seen;
        for (const View<SeenPatch>& body : scene.seen) seen.emplace_back(body.begin(), body.end());
        StepStats for_nothing = stats;
        executor().run([&] { pipeline().step(scene, for_nothing); });
        pipeline().forget_step(scene);
        for (std::uint32_t b = 0; b < scene.seen.size; ++b)
            std::ranges::copy(seen[b], scene.seen[b].begin());
        PipelineBackend::step(scene, stats);
    }
};

std::unique_ptr<Backend> parallel_backend() {
    return std::make_unique<PipelineBackend<ParallelExecutor, BvhTracer<ParallelExecutor>>>(
        "parallel algorithms", std::make_unique<ParallelExecutor>(),
        std::make_unique<BvhTracer<ParallelExecutor>>());
}

}  // namespace

std::vector<NamedBackend> backends() {
    std::vector<NamedBackend> all = {
        {"reference", [] { return reference_backend(); }},
        {"bvh", [] { return bvh_backend(); }},
        {"embree_1", [] { return embree_backend(1); }},
        {"embree_3", [] { return embree_backend(3); }},
        {"shuffled", [] { return std::make_unique<ShuffledBackend>(); }},
        {"parallel", [] { return parallel_backend(); }}};
#if PIERCE_HAS_CUDA
    if (cuda_problem().empty()) {
        all.push_back({"cuda", [] { return cuda_backend(); }});
        all.push_back({"cuda_stepwise", [] { return cuda_backend({.graph = false}); }});
    }
#endif
    return all;
}

}  // namespace pierce::test
