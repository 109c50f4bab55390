#pragma once

#include <memory>
#include <string>
#include <utility>

#include "core/body/body_view.hpp"
#include "core/body/scene.hpp"
#include "core/device/view.hpp"
#include "core/step/common/step_memory.hpp"
#include "core/trace/ray.hpp"
#include "pierce/backend.hpp"
#include "pierce/explain.hpp"
#include "pierce/step_stats.hpp"

namespace pierce::test {

/// What several backends were asked for.
struct Calls {
    int backends = 0, steps = 0, rests = 0;
};

/// Counts what it passes on.
class CountingBackend : public Backend {
public:
    CountingBackend(std::unique_ptr<Backend> inner, Calls& calls)
        : inner_(std::move(inner)), calls_(calls) {
        ++calls_.backends;
    }
    std::string description() const override { return inner_->description(); }
    void step(const Scene& scene, StepStats& stats) override {
        ++calls_.steps;
        inner_->step(scene, stats);
    }
    bool step_at_rest() override {
        const bool rests = inner_->step_at_rest();
        calls_.rests += rests;
        return rests;
    }
    View<const Contact> contacts() const override { return inner_->contacts(); }
    View<const Pair> pairs() const override { return inner_->pairs(); }
    Certificate certificate(View<const BodyView> bodies, Pair pair, std::uint32_t side,
                            std::uint32_t vertex) const override {
        return inner_->certificate(bodies, pair, side, vertex);
    }
    void fetch_bodies(View<BodyView> bodies) const override { inner_->fetch_bodies(bodies); }
    void fetch_seen(View<const BodyId> ids, View<const View<SeenPatch>> seen) const override {
        inner_->fetch_seen(ids, seen);
    }
    StepMemory memory() const override { return inner_->memory(); }
    void remember(const StepMemory& memory) override { inner_->remember(memory); }
    void closest_hits(View<const BodyView> bodies, View<const Ray> rays, View<Hit> hits) override {
        inner_->closest_hits(bodies, rays, hits);
    }

private:
    std::unique_ptr<Backend> inner_;
    Calls& calls_;
};

}  // namespace pierce::test
