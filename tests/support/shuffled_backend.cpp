#include <algorithm>
#include <vector>

#include "core/step/pipeline_backend.hpp"
#include "core/trace/bvh/bvh_tracer.hpp"
#include "support/executor_backends.hpp"
#include "support/shuffled_executor.hpp"

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
        pipeline().recall(*scene.plan);
        for (std::uint32_t b = 0; b < scene.seen.size; ++b)
            std::ranges::copy(seen[b], scene.seen[b].begin());
        PipelineBackend::step(scene, stats);
    }
};

class BackendWithLittleMemory : public PipelineBackend<ShuffledExecutor, ArrangedTrees> {
public:
    explicit BackendWithLittleMemory(std::uint32_t& lists_left)
        : PipelineBackend("with little memory", std::make_unique<ShuffledExecutor>(),
                          std::make_unique<ArrangedTrees>()) {
        executor().lists_left = &lists_left;
    }
};

}  // namespace

std::unique_ptr<Backend> backend_with_little_memory(std::uint32_t& lists_left) {
    return std::make_unique<BackendWithLittleMemory>(lists_left);
}

std::unique_ptr<Backend> shuffled_backend() { return std::make_unique<ShuffledBackend>(); }

}  // namespace pierce::test
