#pragma once

#include <memory>
#include <stdexcept>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/backend.hpp"
#include "pierce/explain.hpp"
#include "pierce/reference_backends.hpp"
#include "pierce/step_stats.hpp"

namespace pierce::test {

/// Throws in its third step, unless it is not to fail.
class FailingBackend : public Backend {
public:
    explicit FailingBackend(bool fails = true) : fails_(fails) {}
    std::string description() const override { return "fails"; }
    void step(const Scene& scene, StepStats& stats) override {
        if (++steps_ == 3 && fails_) throw std::runtime_error("the device is gone");
        inner_->step(scene, stats);
    }
    View<const Contact> contacts() const override { return inner_->contacts(); }
    View<const Pair> pairs() const override { return inner_->pairs(); }
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return inner_->certificate(bodies, pair, side, vertex);
    }
    StepMemory memory() const override { return inner_->memory(); }
    void remember(const StepMemory& memory) override { inner_->remember(memory); }
    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        inner_->closest_hits(bodies, rays, hits);
    }

private:
    std::unique_ptr<Backend> inner_ = bvh_backend();
    bool fails_;
    int steps_ = 0;
};

}  // namespace pierce::test
